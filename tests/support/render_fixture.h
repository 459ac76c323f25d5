/* Shared by the tests of recording and replay: scenes, pools, renderers on the null device, and random draws. */
#ifndef RENDER_FIXTURE_H
#define RENDER_FIXTURE_H

#include "render/render_internal.h"
#include "support/render_reference.h"

#include <stdlib.h>

#define FIXTURE_REPLAYS 3
#define FIXTURE_MATERIALS 3

static inline stilb_scene *fixture_scene(uint32_t models)
{
	stilb_scene *scene;
	assert_int_equal(stilb_scene_create_stress(models, 7, &scene), STILB_OK);
	return scene;
}

static inline stilb_job_pool *fixture_pool(uint32_t workers, stilb_job_hooks hooks)
{
	stilb_job_pool_desc desc = {.worker_count = workers, .affinity = STILB_JOB_AFFINITY_NONE, .hooks = hooks};
	stilb_job_pool *pool;
	assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
	return pool;
}

/* A renderer on the null device without a scene. */
static inline stilb_render *fixture_render(uint32_t contexts, int replay, int materials)
{
	stilb_render_desc desc = {
		.device = STILB_RENDER_DEVICE_NULL,
		.replay = (stilb_render_replay_mode)replay,
		.materials = (stilb_render_materials)materials,
		.width = 64,
		.height = 64,
		.context_count = contexts,
	};
	stilb_render *render;
	assert_int_equal(stilb_render_create(&desc, &render), STILB_OK);
	return render;
}

/* An array of the ids 0, 1, 2, ..., count - 1; to be freed. */
static inline uint32_t *fixture_ids(uint32_t count)
{
	uint32_t *ids = calloc(count + 1, sizeof *ids);
	assert_non_null(ids);
	for (uint32_t i = 0; i < count; i++)
		ids[i] = i;
	return ids;
}

/* ---- draws ------------------------------------------------------------------------------------------------------ */

typedef struct fixture_draw {
	uint64_t key;
	stilb_render_mesh mesh;
	stilb_render_material material;
	uint32_t index_count; /* of the mesh */
	uint32_t texture;     /* of the material: an index, 0 for none */
	stilb_mat4 transform;
} fixture_draw;

/* Any affine transform. */
static inline stilb_mat4 fixture_transform(uint64_t seed, uint64_t index)
{
	stilb_mat4 transform = stilb_mat4_identity();
	for (int column = 0; column < 4; column++)
		for (int row = 0; row < 3; row++)
			transform.m[4 * column + row] = stilb_random_float(seed, index * 16 + (uint64_t)(4 * column + row)) - 0.5f;
	return transform;
}

static inline void fixture_record(stilb_render_context *context, const fixture_draw *draw)
{
	stilb_render_draw_with_key(context, draw->key, draw->mesh, draw->material, &draw->transform);
}

/* An id without its generation, counted from 0. */
static inline uint32_t fixture_index(uint32_t id)
{
	return id & 0xffffffu;
}

static inline uint64_t fixture_hash(uint64_t hash, const fixture_draw *draw)
{
	hash = reference_hash_u32(hash, fixture_index(draw->mesh.id));
	hash = reference_hash_u32(hash, fixture_index(draw->material.id));
	for (int i = 0; i < 16; i++)
		hash = reference_hash_float(hash, draw->transform.m[i]);
	return reference_hash_u32(hash, draw->index_count);
}

static inline uint64_t fixture_hash_all(uint64_t hash, const fixture_draw *draws, uint64_t count)
{
	for (uint64_t d = 0; d < count; d++)
		hash = fixture_hash(hash, &draws[d]);
	return hash;
}

/* Merges two sorted halves; of equal keys the left one's come first. */
static inline void fixture_merge(fixture_draw *draws, uint64_t middle, uint64_t count, fixture_draw *scratch)
{
	uint64_t left = 0, right = middle;
	for (uint64_t i = 0; i < count; i++) {
		bool take_right = left == middle || (right < count && draws[right].key < draws[left].key);
		scratch[i] = take_right ? draws[right++] : draws[left++];
	}
	memcpy(draws, scratch, count * sizeof *draws);
}

static inline void fixture_sort_with(fixture_draw *draws, uint64_t count, fixture_draw *scratch)
{
	if (count < 2)
		return;
	uint64_t middle = count / 2;
	fixture_sort_with(draws, middle, scratch);
	fixture_sort_with(draws + middle, count - middle, scratch);
	fixture_merge(draws, middle, count, scratch);
}

/* Stable merge sort by ascending key. */
static inline void fixture_sort(fixture_draw *draws, uint64_t count)
{
	fixture_draw *scratch = malloc((count + 1) * sizeof *scratch);
	assert_non_null(scratch);
	fixture_sort_with(draws, count, scratch);
	free(scratch);
}

/* The expected number of binds: pipeline, buffers and material before the first draw; then the texture if it changes,
 * the pipeline if one of two draws has a texture and the other has not, and the material as --materials needs it. */
static inline uint64_t fixture_binds(const fixture_draw *draws, uint64_t count, int materials)
{
	bool bind = materials == STILB_RENDER_MATERIALS_BIND;
	uint64_t binds = count > 0 ? 2 + (bind || draws[0].texture != 0) : 0;
	for (uint64_t d = 1; d < count; d++) {
		const fixture_draw *before = &draws[d - 1], *now = &draws[d];
		uint32_t last_material = fixture_index(before->material.id), material = fixture_index(now->material.id);
		bool pipeline = (now->texture != 0) != (before->texture != 0);
		if (materials == STILB_RENDER_MATERIALS_PIPELINE)
			pipeline |= material % 2 != last_material % 2;
		bool set = now->texture != 0 && (pipeline || now->texture != before->texture);
		set |= bind && (pipeline || material != last_material);
		binds += (uint64_t)set + pipeline;
	}
	return binds;
}

/* The expected number of binds of a stream of draws that is cut into `parts` pieces of about equal length, each of
 * which begins with nothing bound. */
static inline uint64_t fixture_binds_in_parts(const fixture_draw *draws, uint64_t count, int materials, uint64_t parts)
{
	uint64_t binds = 0;
	for (uint64_t p = 0; p < parts; p++) {
		uint64_t first = count * p / parts;
		binds += fixture_binds(draws + first, count * (p + 1) / parts - first, materials);
	}
	return binds;
}

#endif
