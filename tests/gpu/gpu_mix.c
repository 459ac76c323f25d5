/* The shaders random.frag and random.comp on the CPU. */
#include "gpu_mix.h"

/* A texel of a range's mip and layer, both counted from the range's first; at the nearest place that there is. */
static uint32_t texel(const mix_input *input, uint32_t mip, uint32_t layer, uint32_t x, uint32_t y)
{
	const mix_thing *thing = input->thing;
	uint32_t width = mix_side(thing->width, input->mip + mip), height = mix_side(thing->height, input->mip + mip);
	uint32_t at = (y < height ? y : height - 1) * width + (x < width ? x : width - 1);
	uint32_t sub = mix_sub(thing, input->mip + mip, input->layer + layer);
	return input->previous ? thing->before[sub][at] : thing->now[sub][at];
}

/* The texel of a face that a direction meets, which the pass's number gives. Vulkan 1.3 specification, "Cube Map Face
 * Selection". */
static uint32_t cube_texel(const mix_input *input, uint32_t number)
{
	static const struct {
		int s_axis, t_axis;
		float s_sign, t_sign;
	} faces[6] = {{2, 1, -1, -1}, {2, 1, 1, -1}, {0, 2, 1, 1}, {0, 2, 1, -1}, {0, 1, 1, -1}, {0, 1, -1, -1}};
	uint32_t axis = number % 3, face = 2 * axis + (number % 6 < 3 ? 0 : 1);
	float direction[3] = {0.13f, 0.23f, 0.13f};
	direction[axis] = number % 6 < 3 ? 1.0f : -1.0f;
	uint32_t mip = input->mips - 1, side = mix_side(input->thing->width, input->mip + mip);
	float s = 0.5f * (faces[face].s_sign * direction[faces[face].s_axis] + 1.0f);
	float t = 0.5f * (faces[face].t_sign * direction[faces[face].t_axis] + 1.0f);
	return texel(input, mip, face, (uint32_t)(s * (float)side), (uint32_t)(t * (float)side));
}

void mix_values(const mix_input inputs[MIX_INPUTS], uint32_t number, uint32_t layer, uint32_t width, uint32_t height,
                uint32_t *values)
{
	const mix_input *array = &inputs[MIX_INPUT_ARRAY], *words = &inputs[MIX_INPUT_BUFFER];
	for (uint32_t i = 0; i < width * height; i++) {
		uint32_t x = i % width, y = i / width, place = x + 97 * y;
		uint32_t hash = mix_step(number, place + 8191 * layer);
		hash = mix_step(hash, texel(&inputs[MIX_INPUT_FLAT], 0, 0, x, y));
		hash = mix_step(hash, texel(&inputs[MIX_INPUT_COLOR], 0, 0, x, y));
		for (uint32_t l = 0; l < array->layers; l++)
			hash = mix_step(hash, texel(array, array->mips - 1, l, x, y));
		hash = mix_step(hash, cube_texel(&inputs[MIX_INPUT_CUBE], number));
		hash = mix_step(hash, texel(&inputs[MIX_INPUT_SAMPLES], 0, 0, x, y));
		values[i] = mix_step(hash, texel(words, 0, 0, place % MIX_WORDS, 0));
	}
}
