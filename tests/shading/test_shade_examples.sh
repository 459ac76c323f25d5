#!/bin/sh
# engine/shading in a program of one's own: test_shade_examples.sh SOURCE_DIR gcc|clang|glslc
#
# The examples are built from a copy of what engine/shading/README.md says is needed, and nothing else of Stilb, with the
# warnings that a careful stranger has on. A GLSL that is too old, or of the other kind, is told so in words.
set -u
source=$(cd "$1" && pwd) || exit 1
tool=$2
if ! command -v "$tool" > /dev/null; then
	echo "skipped: $tool is not installed"
	exit 77
fi
work=$(mktemp -d ./test_shade_examples_XXXXXX) || exit 1
trap 'rm -rf "$work"' EXIT
failed=0
mkdir -p "$work/base"
cp -r "$source/engine/shading" "$work/shading"
cp "$source/engine/base/glsl_types.h" "$source/engine/base/base_math.h" "$work/base"

fail() {
	echo "FAILED: $1"
	failed=1
}

# Smooth metal gives back all of its F0, rough metal less, in three channels of the same proportion.
check_c() {
	for optimise in -O0 -O2; do
		"$tool" -std=c17 $optimise -Wall -Wextra -Wconversion -pedantic -Werror -I"$work" \
			"$work/shading/examples/white_furnace.c" -o "$work/white_furnace" -lm || fail "white_furnace.c $optimise"
		"$work/white_furnace" > "$work/said" || fail "white_furnace fails"
		cat "$work/said"
		awk '$3 > last { faults++ } { last = $3 } NR == 1 && ($3 < 0.98 || $3 > 1.001 || $5 < 0.29 || $5 > 0.31) { faults++ }
			$2 == "" || $4 / $3 < 0.79 || $4 / $3 > 0.83 { faults++ }
			BEGIN { last = 2 } END { exit NR != 4 || faults > 0 }' "$work/said" || fail "white_furnace says something else"
	done
}

# compile VERSION FILE: the shader with another first line.
compile() {
	sed "1s/.*/#version $1/" "$2" > "$work/shader.frag"
	glslc --target-env=vulkan1.3 -Werror -I"$work" "$work/shader.frag" -o "$work/out.spv" > "$work/said" 2>&1
}

check_glsl() {
	compile 450 "$work/shading/examples/bumpy_surface.frag" || { cat "$work/said"; fail "bumpy_surface.frag"; }
	for version in "310 es" "410"; do
		! compile "$version" "$work/shading/examples/bumpy_surface.frag" || fail "#version $version is accepted"
		grep -q "GLSL 4.20 or later" "$work/said" || { head -3 "$work/said"; fail "#version $version: no word of what is needed"; }
	done
}

if [ "$tool" = glslc ]; then check_glsl; else check_c; fi
exit $failed
