#!/bin/sh
# What the shading headers become in C: test_shade_assembly.sh SOURCE_DIR gcc|clang
#
# Evaluations of a known model, compiled as a program would, must be straight single-precision SSE: no x87, no double,
# everything inline, and no call where the formula has no exponential. A file with each mistake must be caught.
set -u
source=$(cd "$1" && pwd) || exit 1
compiler=$2
if ! command -v "$compiler" > /dev/null; then
	echo "skipped: $compiler is not installed"
	exit 77
fi
if [ "$(uname -m)" != x86_64 ]; then
	echo "skipped: SSE is x86-64's"
	exit 77
fi
work=$(mktemp -d ./test_shade_assembly_XXXXXX) || exit 1
trap 'rm -rf "$work"' EXIT
failed=0

fail() {
	echo "FAILED: $1"
	failed=1
}

# evaluation NAME MODEL: an evaluation whose model the compiler knows.
evaluation() {
	cat << END
void $1(const stilb_vec4 *in, stilb_vec4 *out);
void $1(const stilb_vec4 *in, stilb_vec4 *out)
{
	shade_brdf_parameters p = {.specular = in[3], .roughness = in[4][0], .wrap = 0.5f};
	shade_frame frame = {.n = in[0]};
	*out = shade_brdf_cos((shade_brdf_model){$2}, p, frame, in[1], in[2]);
}
END
}

# compile FILE: its assembly, without comments and directives, on stdout.
compile() {
	"$compiler" -std=gnu17 -D_GNU_SOURCE -O2 -ffp-contract=off -fno-math-errno -fno-asynchronous-unwind-tables \
		-I"$source/engine" -S "$1" -o - | sed 's/#.*//' | grep -E '^[[:space:]]+[a-z]'
}

# plain FILE: single precision all through?
plain() {
	! compile "$1" | grep -E '[[:space:]](cvtss2sd|cvtsd2ss|f(ld|st|mul|add|div|sub|sqrt)[a-z]*|[a-z]+(sd|pd))[[:space:]]' |
		grep -v -E '(movmskpd|movapd|movupd|unpck.pd|andpd|orpd|xorpd|shufpd|movlpd|movhpd|movsd)[[:space:]]' > "$work/found"
}

# calls FILE: the functions called.
calls() {
	compile "$1" | sed -n -E 's/^[[:space:]]+(call|callq|jmp)[[:space:]]+\*?([a-z_][A-Za-z0-9_]*).*/\2/p' | sort -u
}

ggx='.kind = SHADE_BRDF_MICROFACET, .ndf = SHADE_NDF_GGX'
{
	echo '#include "shading/shade_brdf.h"'
	evaluation lambert '.kind = SHADE_BRDF_LAMBERT'
	evaluation wrapped '.kind = SHADE_BRDF_WRAPPED'
	for g in IMPLICIT NEUMANN COOK_TORRANCE KELEMEN SMITH_BECKMANN SMITH_GGX SCHLICK_BECKMANN SCHLICK_GGX; do
		for f in NONE SCHLICK COOK_TORRANCE; do
			evaluation "ggx_${g}_$f" "$ggx, .g = SHADE_G_$g, .f = SHADE_F_$f"
		done
	done
} > "$work/no_exp.c"
{
	echo '#include "shading/shade_brdf.h"'
	for kind in PHONG PHONG_MODIFIED BLINN_PHONG BLINN_PHONG_MODIFIED MINIMALIST; do
		evaluation "$kind" ".kind = SHADE_BRDF_$kind"
	done
	evaluation beckmann '.kind = SHADE_BRDF_MICROFACET, .ndf = SHADE_NDF_BECKMANN, .g = SHADE_G_SMITH_BECKMANN'
} > "$work/exp.c"

for file in no_exp exp; do
	[ "$(compile "$work/$file.c" | wc -l)" -gt 100 ] || fail "$file.c: hardly any code"
	plain "$work/$file.c" || fail "$file.c: not single precision alone: $(head -3 "$work/found")"
done
found=$(calls "$work/no_exp.c" | tr '\n' ' ')
[ -z "$found" ] || fail "no_exp.c calls $found"
found=$(calls "$work/exp.c" | grep -v -x -E 'expf|exp2f|logf|powf|log1pf' | tr '\n' ' ')
[ -z "$found" ] || fail "exp.c calls $found"
calls "$work/exp.c" | grep -q -x expf || fail "exp.c calls no expf: the check for calls sees none"

echo 'double wrong(float x); double wrong(float x) { return (double)x * 0.5; }' > "$work/double.c"
! plain "$work/double.c" || fail "a double was not seen"
echo 'float far(float x); float wrong(float x); float wrong(float x) { return far(x) + 1.0f; }' > "$work/far.c"
[ "$(calls "$work/far.c")" = far ] || fail "a call was not seen"

exit $failed
