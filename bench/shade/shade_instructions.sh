#!/bin/sh
# shade_instructions.sh [COMPILER]: how many instructions Schueler's minimalist form takes against Schlick's F with
# Kelemen's V, in C and in SPIR-V, as a table in Markdown. The same source lines are compiled both ways.
#
# x86-64: all instructions of a function but its return (gcc, or the compiler named, -O3, SSE). SPIR-V: those that
# compute (no loads, stores and rearranging) of a shader after glslc and spirv-opt -O; exp and log count as one.
set -eu
source=$(cd "$(dirname "$0")/.." && pwd)
compiler=${1:-gcc}
for tool in "$compiler" objdump glslc spirv-opt spirv-dis; do
	command -v "$tool" > /dev/null && continue
	echo "shade_instructions.sh: $tool is not installed (Debian: gcc or clang, binutils, glslc, spirv-tools)" >&2
	exit 1
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# The forms to compare, all with the same arguments; c is l.h, but in minimalist_whole and schlick_whole the roughness.
arguments="vec3 f0, vec3 n, vec3 l, vec3 v, float c"
cat > "$work/cases.h" << END
#include "shading/shade_brdf.h"
#include "shading/glsl_begin.h"
SHADE_FN vec3 minimalist_1($arguments) { return vec3(f0[0] * shade_minimalist_fv(c)); }
SHADE_FN vec3 schlick_1($arguments) { return vec3(shade_f_schlick_1(f0[0], c) * shade_v_kelemen(c)); }
SHADE_FN vec3 minimalist_3($arguments) { return f0 * shade_minimalist_fv(c); }
SHADE_FN vec3 schlick_3($arguments) { return shade_schlick_kelemen_fv(f0, c); }
SHADE_FN vec3 whole(int kind, $arguments)
{
	shade_brdf_model model = {kind, SHADE_NDF_BLINN, SHADE_G_KELEMEN, SHADE_F_SCHLICK};
	shade_brdf_parameters p = {f0, c, 0.0f, 0.0f};
	shade_frame frame = {n, n, n}; // an isotropic model asks for n alone
	return shade_brdf_cos(model, p, frame, l, v);
}
SHADE_FN vec3 minimalist_whole($arguments) { return whole(SHADE_BRDF_MINIMALIST, f0, n, l, v, c); }
SHADE_FN vec3 schlick_whole($arguments) { return whole(SHADE_BRDF_MICROFACET, f0, n, l, v, c); }
#include "shading/glsl_end.h"
END

# count_c FUNCTION: prints the number of x86-64 instructions of one of these functions.
count_c() {
	cat > "$work/case.c" <<- END
		#include "cases.h"
		#include "shading/glsl_begin.h"
		vec3 counted($arguments);
		vec3 counted($arguments) { return $1(f0, n, l, v, c); }
	END
	"$compiler" -O3 -std=gnu17 -D_GNU_SOURCE -ffp-contract=off -fno-math-errno -I"$source/engine" -I"$work" \
		-c "$work/case.c" -o "$work/case.o"
	objdump -d --no-show-raw-insn "$work/case.o" | awk -F '\t' '/<counted>:/ { in_function = 1 }
		in_function && NF >= 2 && $2 !~ /^(ret|nop|endbr|cs nop|data16|xchg +%ax)/ { count++ }
		END { print count + 0 }'
}

# count_spirv FUNCTION: prints the number of its SPIR-V instructions that compute.
count_spirv() {
	cat > "$work/case.comp" <<- END
		#version 460
		#extension GL_GOOGLE_include_directive : require
		#include "cases.h"
		layout(local_size_x = 1) in;
		layout(std430, binding = 0) buffer Values { vec4 v[]; } values;
		void main()
		{
			vec3 f0 = vec3(values.v[1]), n = vec3(values.v[2]), l = vec3(values.v[3]), v = vec3(values.v[4]);
			values.v[0] = vec4($1(f0, n, l, v, values.v[5].x), 0.0);
		}
	END
	glslc --target-env=vulkan1.2 -I"$source/engine" -I"$work" "$work/case.comp" -o "$work/case.spv"
	spirv-opt -O "$work/case.spv" -o "$work/fast.spv"
	spirv-dis --no-color "$work/fast.spv" | awk '/ OpLabel/ { in_function = 1; next }
		/OpFunctionEnd/ { in_function = 0 }
		in_function && !/Op(Load|Store|AccessChain|Return|Composite(Construct|Extract)|VectorShuffle)/ { count++ }
		END { print count + 0 }'
}

echo "| computes | minimalist, x86-64 | Schlick x Kelemen, x86-64 | minimalist, SPIR-V | Schlick x Kelemen, SPIR-V |"
echo "|---|---|---|---|---|"
while read -r name title; do
	echo "| $title | $(count_c "minimalist_$name") | $(count_c "schlick_$name") |" \
		"$(count_spirv "minimalist_$name") | $(count_spirv "schlick_$name") |"
done << 'END'
1 F V of one channel
3 F V of three channels
whole BRDF n.l of three channels (D of Blinn)
END
