#!/bin/sh
# The shading dialect through its compilers: test_shade_dialect.sh SOURCE_DIR gcc|clang|glslc
#
# Every header of engine/shading is compiled alone and twice, all of them together before and after <tgmath.h>, and for
# glslc inside a compute shader that spirv-val then checks. What they leave behind must be SHADE_ constants and lists and
# nothing else. Headers with a known mistake must fail: a check that cannot fail is none.
set -u
source=$(cd "$1" && pwd) || exit 1
tool=$2
if ! command -v "$tool" > /dev/null || { [ "$tool" = glslc ] && ! command -v spirv-val > /dev/null; }; then
	echo "skipped: $tool (or spirv-val) is not installed"
	exit 77
fi
work=$(mktemp -d ./test_shade_dialect_XXXXXX) || exit 1
trap 'rm -rf "$work"' EXIT
failed=0
flags="-D_GNU_SOURCE -std=gnu17 -ffp-contract=off -Wall -Wextra -Wmissing-prototypes -Wshadow -Wdouble-promotion -Werror"
words=$(sed -n 's/^#pragma push_macro("\(.*\)")$/\1/p' "$source/engine/shading/glsl_begin.h")
headers=$(cd "$source/engine" && ls shading/shade_*.h)
cases=$(cd "$source/tests" && ls shading/cases/case*.h)

fail() {
	echo "FAILED: $1"
	failed=1
}

# compile_c FILE: warnings are errors; -O2, since some warnings need it.
compile_c() {
	"$tool" $flags -O2 -I"$source/engine" -I"$source/tests" -I"$work" -c "$1" -o "$work/out.o"
}

# compile_glsl FILE [TARGET]: for the oldest Vulkan version in use, or the one given.
compile_glsl() {
	target=${2:-vulkan1.0}
	glslc -Werror --target-env="$target" -I"$source/engine" -I"$source/tests" -I"$work" -fshader-stage=compute "$1" \
		-o "$work/out.spv" && spirv-val --target-env "$target" "$work/out.spv"
}

# includes HEADER...: one line each.
includes() {
	for header in "$@"; do
		echo "#include \"$header\""
	done
}

# A TU (or shader) that includes the headers given, twice, on stdout.
unit() {
	if [ "$tool" = glslc ]; then
		echo '#version 450 core'
		includes "$@" "$@"
		echo 'layout(local_size_x = 1) in;'
		echo 'void main() {}'
	else
		includes "$@" "$@"
		echo 'int shade_test_unit;'
	fi
}

compile() {
	if [ "$tool" = glslc ]; then compile_glsl "$1"; else compile_c "$1"; fi
}

check_each_header() {
	for header in $headers shading/shade_vocabulary.h $cases; do
		unit "$header" > "$work/alone.c"
		compile "$work/alone.c" || fail "$header alone"
	done
}

# Words that another header may have taken; none may be left, and in C those of <tgmath.h> work on.
check_all_together_c() {
	{
		echo '#include <tgmath.h>'
		includes $headers
		echo 'float before(float x); float before(float x) { return sqrt(x) + pow(x, 2.0f); }'
	} > "$work/after_tgmath.c"
	compile_c "$work/after_tgmath.c" || fail "after <tgmath.h>"
	{
		includes $headers $cases
		for word in $words SHADE_FN SHADE_CONST SHADE_STRUCT; do
			printf '#ifdef %s\n#error %s is left\n#endif\n' "$word" "$word"
		done
		echo '#include <tgmath.h>'
		includes $headers $cases
		echo '_Static_assert(_Generic(sqrt(1.0f), float: 1, default: 0), "tgmath");'
		echo '_Static_assert(_Generic(fabs(1.0), double: 1, default: 0), "tgmath");'
	} > "$work/before_tgmath.c"
	compile_c "$work/before_tgmath.c" || fail "before <tgmath.h>"
}

# leftovers HEADER...: the macros that the headers define beyond what glsl_types.h does, and that are neither SHADE_ constants
# nor lists SHADE_X(X).
leftovers() {
	includes base/glsl_types.h > "$work/types.c"
	includes "$@" > "$work/left.c"
	"$tool" $flags -I"$source/engine" -I"$work" -dM -E "$work/types.c" | sort > "$work/types.txt"
	"$tool" $flags -I"$source/engine" -I"$work" -dM -E "$work/left.c" | sort > "$work/left.txt"
	comm -13 "$work/types.txt" "$work/left.txt" | grep -v '^#define SHADE_[A-Z0-9_]*\((X)\)\{0,1\}\( \|$\)'
}

# check_own_words: a user's macro of each name is put aside and comes back.
check_own_words() {
	{
		echo '#include <math.h>'
		for word in $words; do
			case $word in float | int) ;; *) echo "#define $word own_$word" ;; esac
		done
		includes $headers
		for word in $words; do
			case $word in float | int) ;; *) echo "left $word" ;; esac
		done
	} > "$work/own.c"
	"$tool" $flags -I"$source/engine" -E -P "$work/own.c" > "$work/own.txt" || fail "own words"
	for word in $words; do
		case $word in float | int) ;; *) grep -q "^left own_$word\$" "$work/own.txt" || fail "own $word is lost" ;; esac
	done
}

check_all_together_glsl() {
	{
		echo '#version 450 core'
		includes $headers shading/shade_vocabulary.h $cases
		for word in dot4 select SHADE_FN SHADE_CONST SHADE_STRUCT; do
			printf '#ifdef %s\n#error %s is left\n#endif\n' "$word" "$word"
		done
		includes $headers shading/shade_vocabulary.h $cases
		cat <<- 'END'
			layout(local_size_x = 64) in;
			layout(std430, set = 0, binding = 0) readonly buffer Inputs { vec4 inputs[]; };
			layout(std430, set = 0, binding = 1) writeonly buffer Results { vec4 results[]; };
			void main()
			{
				uint i = gl_GlobalInvocationID[0];
				vec4 a = inputs[2u * i];
				vec4 b = inputs[2u * i + 1u];
				results[i] = shade_case_dialect(int(b[3]), a, b);
			}
		END
	} > "$work/all.comp"
	for version in vulkan1.0 vulkan1.3; do
		compile_glsl "$work/all.comp" $version || fail "all in a compute shader, $version"
	done
}

# one_line LINE: does a header whose one function has this line compile?
one_line() {
	{
		printf '#ifndef SHADE_ONE_LINE_H\n#define SHADE_ONE_LINE_H\n#include "shading/glsl_begin.h"\n'
		echo "SHADE_FN float shade_one_line(vec3 v, float x) { $1 }"
		printf '#include "shading/glsl_end.h"\n#endif\n'
	} > "$work/shade_one_line.h"
	unit shade_one_line.h > "$work/one_line.c"
	compile "$work/one_line.c" > "$work/one_line.txt" 2>&1
}

must_fail() {
	! one_line "$2" || fail "$1 was accepted"
}

check_mistakes() {
	one_line 'return length(max(v, 0.0f)) * x;' || fail "a good line was refused: $(cat "$work/one_line.txt")"
	must_fail 'an unknown name' 'return y;'
	must_fail 'a missing overload' 'return length(cross(v, x));'
	must_fail 'a vector made of a scalar without vec3' 'vec3 w = x; return w[0];'
	if [ "$tool" = glslc ]; then
		must_fail 'a pointer' 'float *p = &x; return *p;'
		must_fail 'a C cast' 'return (float)1;'
		must_fail 'math.h' 'return sqrtf(x);'
	else
		must_fail 'a swizzle' 'return v.x;'
		must_fail 'a double' 'return x * 2.0;'
		must_fail 'a scalar first' 'return max(x, v)[0];'
		must_fail 'an out parameter' 'return length(out v);'
		must_fail 'matrices' 'mat3 m; return x;'
	fi
	printf '#define leaked 1\n#include "shading/glsl_begin.h"\n#include "shading/glsl_end.h"\n' > "$work/shade_leak.h"
	if [ "$tool" != glslc ] && [ "$(leftovers shade_leak.h)" != '#define leaked 1' ]; then
		fail "a leaked macro was not seen"
	fi
}

check_each_header
if [ "$tool" = glslc ]; then
	check_all_together_glsl
else
	check_all_together_c
	check_own_words
	left=$(leftovers $headers)
	[ -z "$left" ] || fail "left behind: $left"
fi
check_mistakes
[ $failed = 0 ] && echo "$tool: $(echo "$headers" | wc -l) headers, $(echo "$words" | wc -l) words"
exit $failed
