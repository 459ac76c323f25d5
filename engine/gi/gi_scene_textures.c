#include "gi/gi_scene_textures.h"

#include "profiler/prof.h"

#include <stdlib.h>

#define TEXTURE_ROWS 64u /* of texels that a job decodes, a multiple of 4 */

uint64_t gi_scene_textures_hash(const stilb_scene *scene)
{
	uint64_t head[] = {scene->revisions.textures, scene->texture_count};
	uint64_t hash = stilb_hash_fnv1a64(STILB_FNV1A64_START, head, sizeof head);
	for (uint32_t i = 0; i < scene->texture_count; i++) {
		const stilb_image *image = &scene->textures[i];
		uint64_t numbers[] = {(uintptr_t)image->pixels, image->width, image->height, image->format};
		hash = stilb_hash_fnv1a64(hash, numbers, sizeof numbers);
	}
	return hash;
}

/* A picture of blocks, and its texels. */
typedef struct texture_decoding {
	const stilb_image *from;
	stilb_image *to;
} texture_decoding;

static void texture_decode_rows(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const texture_decoding *decoding = context;
	uint32_t last = end * TEXTURE_ROWS, height = decoding->from->height;
	(void)worker;
	stilb_image_decode_rows(decoding->from, begin * TEXTURE_ROWS, last < height ? last : height, decoding->to);
}

/* One that is not made of blocks becomes a view: storage 0, and not to be finished. */
static stilb_result texture_make(const stilb_image *from, stilb_job_pool *pool, stilb_image *to)
{
	*to = *from;
	to->storage = 0;
	if (!from->pixels || !stilb_image_format_is_blocks(from->format))
		return STILB_OK;
	stilb_result result =
		stilb_image_create(to, from->width, from->height, from->channels, stilb_image_decoded_format(from->format));
	if (result != STILB_OK)
		return result;
	texture_decoding decoding = {from, to};
	stilb_job_parallel_for(pool, (from->height + TEXTURE_ROWS - 1) / TEXTURE_ROWS, 1, texture_decode_rows, &decoding,
	                       0);
	return STILB_OK;
}

stilb_result gi_scene_textures_make(stilb_gi_scene *gi, const stilb_scene *scene, stilb_job_pool *pool)
{
	gi_found *found = &gi->found;
	uint64_t hash = gi_scene_textures_hash(scene);
	if (found->textures && found->textures_hash == hash)
		return STILB_OK;
	PROFILE("gi.textures");
	gi_scene_textures_finish(found);
	found->textures = calloc((size_t)scene->texture_count + 1, sizeof *found->textures);
	found->decoded = calloc((size_t)scene->texture_count + 1, sizeof *found->decoded);
	stilb_result result = STILB_OK;
	if (!found->textures || !found->decoded)
		result = stilb_fail(STILB_ERROR_MEMORY, "no memory for a scene of %u textures", scene->texture_count);
	for (uint32_t i = 0; i < scene->texture_count && result == STILB_OK; i++) {
		result = texture_make(&scene->textures[i], pool, &found->textures[i]);
		found->decoded[i] = result == STILB_OK && found->textures[i].pixels != scene->textures[i].pixels;
		found->texture_count = i + 1;
	}
	if (result != STILB_OK)
		gi_scene_textures_finish(found);
	found->textures_hash = hash;
	return result;
}

void gi_scene_textures_finish(gi_found *found)
{
	for (uint32_t i = 0; i < found->texture_count; i++)
		if (found->decoded[i])
			stilb_image_finish(&found->textures[i]);
	free(found->textures);
	free(found->decoded);
	found->textures = NULL;
	found->decoded = NULL;
	found->texture_count = 0;
}
