/*
 * gi_cache_gather: makes one record of the irradiance cache: a ray through every cell of the hemisphere above a point
 * (gi_cache_strata.h), and the light that the surfaces which the rays hit reflect back. Where records cover such a
 * surface, its indirect light is taken from them; else a path continues from there.
 */
#include "gi/cache/gi_cache_gather.h"

#include "gi/integrate/gi_direct.h"
#include "gi/sample/gi_counter.h"
#include "gi/trace/gi_ray.h"
#include "gi/trace/gi_through.h"
#include "profiler/prof.h"

#include "shading/shade_constants.h"

/* Indirect light is taken from other records only if settings.depth is at least this. Records hold light after any
 * number of reflections; with a smaller depth the picture would show light after more reflections than it may. */
#define REUSE_DEPTH 16u

/* Traces the rays of cells first .. first + number - 1. */
static void trace_cells(const gi_cache *cache, gi_cache_worker *worker, const gi_surface *surface, shade_frame frame,
                        gi_point point, uint32_t first, uint32_t number)
{
	STILB_ASSERT(number <= GI_BATCH && first + number <= gi_cache_strata_cells(&cache->strata));
	PROFILE("gi.cache.rays");
	const gi_view *view = cache->view;
	uint32_t cells = gi_cache_strata_cells(&cache->strata);
	stilb_vec3 origin = gi_surface_ray_origin(surface, surface->geometric);
	uint64_t further = 0;
	for (uint32_t i = 0; i < number; i++) {
		gi_point branch = gi_sampler_branch(&view->sampler, point, GI_DIMENSION_OF(0), first + i, cells);
		stilb_vec2 u = gi_sample_2d(&view->sampler, branch, GI_DIMENSION_OF(0));
		stilb_vec3 local = gi_cache_strata_direction(&cache->strata, first + i, u);
		stilb_vec3 direction = shade_frame_to_world(frame, local);
		worker->points[i] = branch;
		float chance = 0.0f;
		if (view->scene->blends)
			chance = gi_sample_2d(&view->sampler, branch, GI_DIMENSION_OF(0) + GI_DIMENSION_ROULETTE)[1];
		worker->rays[i] = gi_ray_hit_make_by(origin, direction, chance);
		/* A direction may be above the plane of the shading normal but below the triangle's: no light comes from there,
		 * so the ray is not traced and stays a miss. */
		if (stilb_vec3_dot(direction, surface->geometric) > 0.0f)
			view->scene->tracer.intersect(&view->scene->tracer, &worker->rays[i]);
		if (view->scene->passes)
			worker->left[i] = gi_through(view->scene, &worker->rays[i], &further);
	}
	gi_counter_add(&worker->traced, further);
}

/* Takes the indirect light where ray i ends from the cache, and adds shadow rays for the direct light there to the
 * worker's list. False: no record covers that point, so a path must find both. */
static bool reflected_from_cache(const gi_cache *cache, gi_cache_worker *worker, uint32_t i)
{
	STILB_ASSERT(worker->shadow_count + GI_LIGHT_GROUPS <= GI_LIGHT_GROUPS * GI_BATCH);
	const gi_view *view = cache->view;
	const gi_ray_hit *ray = &worker->rays[i];
	gi_surface surface;
	gi_surface_at(view->scene, ray, &surface);
	gi_bsdf bsdf;
	gi_bsdf_make(&view->settings.model, &surface, -gi_ray_direction(&ray->ray), &bsdf);
	stilb_vec3 irradiance = {0};
	if (bsdf.share > 0.0f || (gi_cache_wants(&surface) && !gi_cache_find(cache, &surface, &irradiance)))
		return false;
	worker->radiance[i] = surface.diffuse * SHADE_INV_PI * irradiance;

	float numbers[8];
	gi_sample_8(&view->sampler, worker->points[i], GI_DIMENSION_OF(1), numbers);
	gi_ray *shadows = &worker->shadows[worker->shadow_count];
	uint32_t asked = gi_direct_ask(view, &bsdf, surface.part, gi_surface_ray_origin(&surface, surface.geometric),
	                               numbers, GI_DIRECT_ALONE, shadows, &worker->direct[worker->shadow_count]);
	for (uint32_t k = 0; k < asked; k++)
		shadows[k].id = i;
	worker->shadow_count += asked;
	return true;
}

static void trace_cell_shadows(const gi_cache *cache, gi_cache_worker *worker)
{
	PROFILE("gi.cache.shadow");
	gi_through_occluded(cache->view->scene, worker->shadows, worker->direct, worker->shadow_count);
	for (uint32_t i = 0; i < worker->shadow_count; i++)
		if (worker->shadows[i].t_max >= 0.0f)
			worker->radiance[worker->shadows[i].id] += worker->direct[i];
	gi_counter_add(&worker->traced, worker->shadow_count);
	gi_counter_add(&worker->shadow_rays, worker->shadow_count);
	worker->shadow_count = 0;
}

/* Traces the first path_count paths of worker number `index`, and stores the radiance of each with the ray that it
 * continues: path i's at radiance[targets[i]]. */
static void trace_paths(const gi_cache *cache, uint32_t index, uint32_t path_count)
{
	STILB_ASSERT(path_count <= GI_BATCH);
	gi_cache_worker *worker = &cache->workers[index];
	gi_batch batch = {.view = cache->view,
	                  .worker = index,
	                  .count = path_count,
	                  .points = worker->path_points,
	                  .rays = worker->path_rays,
	                  .radiance = worker->path_radiance,
	                  .scratch = worker->scratch};
	gi_path_gather(&batch, 1, cache->view->settings.depth - 1);
	for (uint32_t i = 0; i < path_count; i++)
		worker->radiance[worker->targets[i]] = worker->path_radiance[i];
	gi_counter_add(&worker->traced, batch.rays_traced);
	gi_counter_add(&worker->shadow_rays, batch.shadow_rays);
}

/* 1 / distance to what the ray hit, 0 for a miss. Distances below the shortest radius of a record count as that radius:
 * records cannot resolve them, and they would dominate the harmonic mean. */
static float nearness(const gi_ray_hit *ray, float shortest)
{
	return gi_is_hit(ray) ? 1.0f / fmaxf(ray->ray.t_max, shortest) : 0.0f;
}

static void gather_cells(gi_cache *cache, uint32_t index, const gi_surface *surface, shade_frame frame, gi_point point,
                         float shortest)
{
	gi_cache_worker *worker = &cache->workers[index];
	uint32_t cells = gi_cache_strata_cells(&cache->strata);
	bool reuse = cache->view->settings.depth >= REUSE_DEPTH;
	for (uint32_t first = 0, number; first < cells; first += number) {
		number = cells - first < GI_BATCH ? cells - first : GI_BATCH;
		trace_cells(cache, worker, surface, frame, point, first, number);
		uint32_t paths = 0;
		for (uint32_t i = 0; i < number; i++) {
			worker->radiance[i] = (stilb_vec3){0};
			if (!gi_is_hit(&worker->rays[i]) || (reuse && reflected_from_cache(cache, worker, i)))
				continue;
			worker->path_rays[paths] = worker->rays[i];
			worker->path_points[paths] = worker->points[i];
			worker->targets[paths++] = i;
		}
		trace_cell_shadows(cache, worker);
		trace_paths(cache, index, paths);
		for (uint32_t i = 0; i < number && cache->view->scene->passes; i++)
			worker->radiance[i] *= worker->left[i];
		for (uint32_t i = 0; i < number; i++)
			worker->cells[first + i] = (gi_cache_cell){worker->radiance[i], nearness(&worker->rays[i], shortest)};
	}
	gi_counter_add(&worker->traced, cells);
}

gi_cache_record gi_cache_gather(gi_cache *cache, uint32_t worker, const gi_surface *surface, gi_point point)
{
	STILB_ASSERT(worker < cache->worker_count);
	shade_frame frame = shade_frame_from_normal(surface->normal);
	gi_cache_limits limits = gi_cache_limits_at(cache, surface->position);
	gather_cells(cache, worker, surface, frame, point, limits.shortest);
	gi_cache_gathered gathered = gi_cache_strata_gather(&cache->strata, cache->workers[worker].cells);
	return gi_cache_record_make(&gathered, frame, surface->position, &limits);
}
