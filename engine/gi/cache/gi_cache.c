#include "gi/cache/gi_cache.h"

#include "gi/film/gi_camera.h"

#include <stdlib.h>
#include <string.h>

/* The radius of a record is how far from it it is valid. */
#define LONGEST_OF_SCENE 0.125f   /* the longest radius, as a share of the scene's diagonal */
#define UNIT_OF_SCENE 0.0625f     /* gi_cache_limits.unit, as a share of the scene's diagonal */
#define SHORTEST_PIXELS 1.5f      /* the shortest radius, in widths of a pixel at the record's distance, */
#define SHORTEST_OF_LONGEST 0.08f /* but at most this share of the longest radius */

/* ---- life -------------------------------------------------------------------------------------------------------- */

static bool cache_worker_create(gi_cache_worker *worker, uint32_t cells)
{
	worker->cells = stilb_memory_alloc(cells, sizeof(gi_cache_cell));
	worker->scratch = stilb_memory_alloc(1, gi_integrator_path.scratch_size);
	return worker->cells && worker->scratch;
}

static stilb_result cache_workers_create(gi_cache *cache, uint32_t count)
{
	cache->workers = stilb_memory_alloc(count, sizeof(gi_cache_worker));
	if (!cache->workers)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the irradiance cache");
	memset(cache->workers, 0, count * sizeof(gi_cache_worker));
	cache->worker_count = count;
	for (uint32_t i = 0; i < count; i++)
		if (!cache_worker_create(&cache->workers[i], gi_cache_strata_cells(&cache->strata)))
			return stilb_fail(STILB_ERROR_MEMORY, "no memory for the irradiance cache's %u gather rays on %u workers",
			                  cache->view->settings.cache.rays, count);
	return STILB_OK;
}

static float diagonal_of(const stilb_gi_scene_info *info)
{
	float squared = 0.0f;
	for (int i = 0; i < 3; i++) {
		float side = fmaxf(info->high[i] - info->low[i], 0.0f);
		squared += side * side;
	}
	return squared > 0.0f ? sqrtf(squared) : 1.0f;
}

static gi_cache_limits limits_make(const gi_view *view)
{
	const stilb_gi_cache_settings *settings = &view->settings.cache;
	float scale = diagonal_of(&view->scene->info);
	bool hessian = settings->radius == STILB_GI_CACHE_HESSIAN;
	return (gi_cache_limits){
		.error = settings->error,
		.turn = hessian ? sqrtf(settings->error) : settings->error,
		.radius = settings->radius,
		.gradients = settings->gradients,
		.longest = scale * LONGEST_OF_SCENE,
		.unit = scale * UNIT_OF_SCENE,
	};
}

/* Metres that one pixel's width covers at the distance of that position from the camera. */
static float pixel_size(const gi_cache *cache, stilb_vec3 position)
{
	stilb_vec3 way = position - cache->eye;
	return cache->footprint * sqrtf(stilb_vec3_dot(way, way));
}

gi_cache_limits gi_cache_limits_at(const gi_cache *cache, stilb_vec3 position)
{
	gi_cache_limits limits = cache->limits;
	limits.shortest = fminf(SHORTEST_PIXELS * pixel_size(cache, position), cache->limits.longest * SHORTEST_OF_LONGEST);
	return limits;
}

static stilb_result cache_make(gi_cache *cache, uint32_t worker_count)
{
	const stilb_gi_scene_info *info = &cache->view->scene->info;
	stilb_result result = gi_cache_strata_create(cache->view->settings.cache.rays, &cache->strata);
	if (result == STILB_OK)
		result = gi_cache_octree_create(info->low, info->high, &cache->octree);
	if (result == STILB_OK)
		result = cache_workers_create(cache, worker_count);
	return result;
}

stilb_result gi_cache_create(const gi_view *view, uint32_t worker_count, gi_cache **out)
{
	STILB_ASSERT(view && view->scene && out);
	STILB_ASSERT(worker_count >= 1);
	STILB_ASSERT(view->settings.cache.error > 0.0f && view->settings.cache.error <= 1.0f);
	*out = NULL;
	const stilb_gi_settings *settings = &view->settings;
	gi_cache *cache = stilb_memory_alloc(1, sizeof(*cache));
	if (!cache)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the irradiance cache");
	gi_camera camera = gi_camera_make(&settings->camera, &settings->lens, settings->width, settings->height);
	STILB_ASSERT(camera.half_height > 0.0f);
	*cache = (gi_cache){.view = view,
	                    .eye = camera.position,
	                    .footprint = 2.0f * camera.half_height / (float)settings->height,
	                    .limits = limits_make(view)};
	stilb_result result = cache_make(cache, worker_count);
	if (result == STILB_OK)
		*out = cache;
	else
		gi_cache_destroy(cache);
	return result;
}

void gi_cache_destroy(gi_cache *cache)
{
	if (!cache)
		return;
	for (uint32_t i = 0; i < cache->worker_count; i++) {
		free(cache->workers[i].cells);
		free(cache->workers[i].scratch);
	}
	free(cache->workers);
	gi_cache_octree_destroy(cache->octree);
	gi_cache_strata_destroy(&cache->strata);
	free(cache);
}

/* ---- use --------------------------------------------------------------------------------------------------------- */

bool gi_cache_wants(const gi_surface *surface)
{
	return !surface->layered && surface->diffuse[0] + surface->diffuse[1] + surface->diffuse[2] > 0.0f;
}

bool gi_cache_find(const gi_cache *cache, const gi_surface *surface, stilb_vec3 *irradiance)
{
	STILB_ASSERT(irradiance);
	return gi_cache_octree_lookup(cache->octree, surface->position, surface->normal, cache->limits.turn, irradiance);
}

bool gi_cache_covers(const gi_cache *cache, const gi_surface *surface, float reach)
{
	STILB_ASSERT(reach > 0.0f && reach <= 1.0f);
	return gi_cache_octree_covers(cache->octree, surface->position, surface->normal, cache->limits.turn, reach);
}

bool gi_cache_record_is_at(const gi_cache *cache, stilb_vec3 position, float pixels)
{
	STILB_ASSERT(pixels > 0.0f);
	return gi_cache_octree_record_near(cache->octree, position, pixels * pixel_size(cache, position));
}

bool gi_cache_add(gi_cache *cache, const gi_cache_record *record)
{
	STILB_ASSERT(cache && record);
	gi_cache_record limited = *record;
	if (cache->limits.radius == STILB_GI_CACHE_SPLIT_SPHERE)
		gi_cache_octree_clamp(cache->octree, &limited);
	return gi_cache_octree_insert(cache->octree, &limited);
}
