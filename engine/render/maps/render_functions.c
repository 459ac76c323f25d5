#include "render/maps/render_functions.h"

#include "render/render_internal.h"

#include <string.h>

static_assert(RENDER_FUNCTION_SEEN + 4 == STILB_SCENE_FUNCTION_CODES, "all kinds");
static_assert(RENDER_MAX_FUNCTIONS <= 1u << 10, "a key of programs has that many bits for them");

stilb_gpu_shader render_function_code(const stilb_scene_function *function, render_function_kind kind, bool layers,
                                      bool gloss, bool coverage, bool extras)
{
	uint32_t variant = kind == RENDER_FUNCTION_MAPS      ? 8u * layers + 4u * gloss + 2u * coverage
	                   : kind == RENDER_FUNCTION_THROUGH ? 2u * gloss
	                   : kind == RENDER_FUNCTION_CHANNEL ? 2u * coverage
	                                                     : 2u * layers;
	uint32_t code = (uint32_t)kind + variant + extras;
	STILB_ASSERT(code < STILB_SCENE_FUNCTION_CODES);
	return (stilb_gpu_shader){.words = function->codes[code].words, .bytes = function->codes[code].bytes};
}

uint64_t render_function_hash(const stilb_scene_function *function)
{
	uint64_t hash = stilb_hash_fnv1a64(STILB_FNV1A64_START, function->name, strlen(function->name));
	for (uint32_t c = 0; c < STILB_SCENE_FUNCTION_CODES; c++)
		hash = stilb_hash_fnv1a64(hash, function->codes[c].words, function->codes[c].bytes);
	return hash + (hash == 0);
}

void render_function_free(render_function *function)
{
	if (!function)
		return;
	stilb_scene_function_finish(&function->own);
	free(function);
}

void render_function_name(const stilb_render *render, uint32_t index, render_maps *maps)
{
	STILB_ASSERT(index < RENDER_MAX_FUNCTIONS && render_maps_function(maps->bits) == 0);
	if (index == 0)
		return;
	const render_function *function =
		render->device->programs.functions[index]; /* it stays until its owner destroys it */
	STILB_ASSERT(function);
	maps->bits |= (uint64_t)index << RENDER_MAPS_FUNCTION_SHIFT;
	maps->function_hash = function->hash;
}
