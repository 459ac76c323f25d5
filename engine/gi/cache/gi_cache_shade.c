/*
 * The integrator irradiance_cache: emission and direct light as in path, diffuse indirect light from the cache, and
 * paths for what a cache cannot hold: highlights, and diffuse light where no record is valid.
 */
#include "gi/cache/gi_cache_gather.h"

#include "gi/integrate/gi_direct.h"
#include "gi/trace/gi_ray.h"
#include "gi/trace/gi_through.h"
#include "profiler/prof.h"

#include "shading/shade_constants.h"
#include "shading/shade_sampling.h"

#define BRANCHES 2u        /* paths that a sample may need: a highlight's and a diffuse one */
#define RECORD_PIXELS 1.2f /* radius of the dot that show_records draws, in pixels */

/* A branch: a further ray of a sample, for light that the cache does not hold. */
typedef struct cache_branch {
	stilb_vec3 weight;   /* factor on the light that the surface at its end reflects */
	stilb_vec3 shown;    /* factor on the light that the surface at its end emits */
	gi_direct_left left; /* for the weight, by multiple importance sampling (MIS), of the emission that it finds */
	uint32_t target;     /* index in the batch of the sample that it belongs to */
	uint32_t part;       /* gi_surface.part of the surface that its ray leaves */
} cache_branch;

typedef struct cache_scratch {
	gi_ray shadows[GI_LIGHT_GROUPS * GI_BATCH];
	stilb_vec3 direct[GI_LIGHT_GROUPS * GI_BATCH];
	cache_branch branches[BRANCHES * GI_BATCH];
	gi_ray_hit rays[BRANCHES * GI_BATCH];
	gi_point points[BRANCHES * GI_BATCH];
	stilb_vec3 reflected[GI_BATCH];
	uint32_t shadow_count, branch_count;
} cache_scratch;

/* ---- one sample -------------------------------------------------------------------------------------------------- */

static void want_branch(gi_batch *batch, uint32_t sample, stilb_vec3 origin, stilb_vec3 direction, float chance,
                        const cache_branch *wanted)
{
	STILB_ASSERT(sample < batch->count);
	STILB_ASSERT(((const cache_scratch *)batch->scratch)->branch_count < BRANCHES * GI_BATCH);
	cache_scratch *scratch = batch->scratch;
	uint32_t i = scratch->branch_count++;
	scratch->branches[i] = *wanted;
	scratch->branches[i].target = sample;
	scratch->rays[i] = gi_ray_hit_make_by(origin, direction, chance);
	scratch->points[i] = batch->points[sample];
}

/* Diffuse indirect light where no record is valid: one path estimates it. */
static void want_diffuse(gi_batch *batch, uint32_t sample, const gi_surface *surface, stilb_vec3 diffuse,
                         const float numbers[8])
{
	stilb_vec2 u = {numbers[GI_DIMENSION_DIRECTION], numbers[GI_DIMENSION_DIRECTION + 1]};
	shade_sample chosen = shade_sample_cosine(u);
	stilb_vec3 direction = shade_frame_to_world(shade_frame_from_normal(surface->normal), chosen.direction);
	if (stilb_vec3_dot(direction, surface->geometric) <= 0.0f)
		return;
	cache_branch wanted = {.weight = diffuse};
	want_branch(batch, sample, gi_surface_ray_origin(surface, surface->geometric), direction,
	            numbers[GI_DIMENSION_CHANCE], &wanted);
}

/* diffuse: gi_bsdf.diffuse. */
static void sample_diffuse(gi_batch *batch, uint32_t sample, const gi_surface *surface, stilb_vec3 diffuse,
                           const float numbers[8])
{
	gi_cache *cache = batch->view->cache;
	stilb_vec3 irradiance;
	if (!gi_cache_find(cache, surface, &irradiance)) {
		if (batch->view->settings.cache.mode == STILB_GI_CACHE_FROZEN) {
			want_diffuse(batch, sample, surface, diffuse, numbers);
			return;
		}
		gi_cache_record record = gi_cache_gather(cache, batch->worker, surface, batch->points[sample]);
		gi_cache_add(cache, &record); /* if there is no memory for it, it is used for this sample only */
		irradiance = record.irradiance;
	}
	batch->radiance[sample] += diffuse * SHADE_INV_PI * irradiance;
}

/* Adds one ray for the highlight. Its direction's density is the highlight's alone, since bsdf->share, the probability
 * of sampling the highlight, was set to 1; gi_direct_ask uses the same density for its MIS weight, so the weights of
 * both sum to 1. Of a layered surface nothing is cached: the ray is for all of its lobes. */
static void want_highlight(gi_batch *batch, uint32_t sample, const gi_surface *surface, const gi_bsdf *bsdf,
                           const float numbers[8])
{
	STILB_ASSERT(bsdf->share == 1.0f);
	stilb_vec2 u = {numbers[GI_DIMENSION_DIRECTION], numbers[GI_DIMENSION_DIRECTION + 1]};
	gi_bsdf_sample chosen;
	if (!gi_bsdf_sample_direction(bsdf, numbers[GI_DIMENSION_LOBE], u, &chosen))
		return;
	float n_dot_l = stilb_vec3_dot(bsdf->frame.n, chosen.direction);
	stilb_vec3 diffuse = bsdf->diffuse * (SHADE_INV_PI * n_dot_l / chosen.pdf);
	if (gi_bsdf_is_layered(bsdf))
		diffuse = (stilb_vec3){0};
	cache_branch wanted = {.weight = chosen.weight - diffuse,
	                       .left = gi_direct_leave(bsdf, &chosen, GI_DIRECT_WITH_HIGHLIGHT),
	                       .part = surface->part};
	if (batch->view->settings.only != STILB_GI_ONLY_INDIRECT)
		wanted.shown = chosen.weight;
	stilb_vec3 origin = gi_surface_ray_origin(surface, surface->geometric);
	want_branch(batch, sample, gi_bsdf_origin(bsdf, origin, chosen.direction), chosen.direction,
	            numbers[GI_DIMENSION_CHANCE], &wanted);
}

static void want_direct(gi_batch *batch, uint32_t sample, const gi_surface *surface, const gi_bsdf *bsdf,
                        const float numbers[8])
{
	cache_scratch *scratch = batch->scratch;
	STILB_ASSERT(scratch->shadow_count + GI_LIGHT_GROUPS <= GI_LIGHT_GROUPS * GI_BATCH);
	gi_ray *shadows = &scratch->shadows[scratch->shadow_count];
	stilb_vec3 origin = gi_surface_ray_origin(surface, surface->geometric);
	gi_direct_beside beside = bsdf->share > 0.0f ? GI_DIRECT_WITH_HIGHLIGHT : GI_DIRECT_ALONE;
	uint32_t asked = gi_direct_ask(batch->view, bsdf, surface->part, origin, numbers, beside, shadows,
	                               &scratch->direct[scratch->shadow_count]);
	for (uint32_t k = 0; k < asked; k++)
		shadows[k].id = sample;
	scratch->shadow_count += asked;
}

static void sample_surface(gi_batch *batch, uint32_t sample, gi_surface *surface)
{
	const gi_view *view = batch->view;
	bool indirect_only = view->settings.only == STILB_GI_ONLY_INDIRECT;
	if (!indirect_only)
		batch->radiance[sample] = surface->emission + surface->unlit;
	if (view->settings.depth == 0)
		return;
	float numbers[8];
	gi_sample_8(&view->sampler, batch->points[sample], GI_DIMENSION_OF(0), numbers);
	gi_bsdf bsdf;
	gi_bsdf_make(&view->settings.model, surface, -gi_ray_direction(&batch->rays[sample].ray), &bsdf);
	if (bsdf.share > 0.0f) {
		bsdf.share = 1.0f;
		want_highlight(batch, sample, surface, &bsdf, numbers);
	}
	if (!indirect_only)
		want_direct(batch, sample, surface, &bsdf, numbers);
	if (view->settings.depth > 1 && gi_cache_wants(surface))
		sample_diffuse(batch, sample, surface, bsdf.diffuse, numbers);
}

static void sample_start(gi_batch *batch, uint32_t sample)
{
	const gi_view *view = batch->view;
	const gi_ray_hit *ray = &batch->rays[sample];
	batch->radiance[sample] = (stilb_vec3){0};
	if (!gi_is_hit(ray)) {
		if (view->settings.only != STILB_GI_ONLY_INDIRECT)
			batch->radiance[sample] = gi_environment_radiance(&view->scene->lights, gi_ray_direction(&ray->ray));
		return;
	}
	gi_surface surface;
	gi_surface_at(view->scene, ray, &surface);
	if (view->settings.cache.show_records && gi_cache_record_is_at(view->cache, surface.position, RECORD_PIXELS))
		batch->radiance[sample] = stilb_vec3_make(1.0f, 0.02f, 0.02f);
	else
		sample_surface(batch, sample, &surface);
}

/* ---- rays -------------------------------------------------------------------------------------------------------- */

static void trace_sample_shadows(gi_batch *batch)
{
	PROFILE("gi.shadow");
	cache_scratch *scratch = batch->scratch;
	gi_through_occluded(batch->view->scene, scratch->shadows, scratch->direct, scratch->shadow_count);
	for (uint32_t i = 0; i < scratch->shadow_count; i++)
		if (scratch->shadows[i].t_max >= 0.0f)
			batch->radiance[scratch->shadows[i].id] += scratch->direct[i];
	batch->rays_traced += scratch->shadow_count;
	batch->shadow_rays += scratch->shadow_count;
}

/* The light emitted where a branch's ray ends, times its factor. */
static stilb_vec3 branch_found(const gi_view *view, const cache_branch *branch, const gi_ray_hit *ray)
{
	if (branch->shown[0] + branch->shown[1] + branch->shown[2] == 0.0f)
		return (stilb_vec3){0};
	gi_surface surface;
	bool hit = gi_is_hit(ray);
	if (hit)
		gi_surface_at(view->scene, ray, &surface);
	return branch->shown * gi_direct_found(view, &branch->left, ray, hit ? &surface : NULL);
}

/* Adds the light that a branch's ray would find, were it a ray towards lights, to its sample, and leaves none to find
 * for the ray itself. */
static void find_lights(gi_batch *batch, cache_branch *branch, const gi_ray_hit *ray, uint64_t *traced)
{
	if (branch->shown[0] + branch->shown[1] + branch->shown[2] == 0.0f)
		return;
	batch->radiance[branch->target] +=
		branch->shown * gi_direct_find(batch->view, &branch->left, branch->part, ray, traced);
	branch->shown = (stilb_vec3){0};
}

static void trace_branches(gi_batch *batch)
{
	STILB_ASSERT(batch->worker < batch->view->cache->worker_count);
	PROFILE("gi.cache.branch");
	cache_scratch *scratch = batch->scratch;
	const gi_view *view = batch->view;
	for (uint32_t first = 0; first < scratch->branch_count; first += GI_BATCH) {
		uint32_t left = scratch->branch_count - first;
		gi_batch paths = *batch;
		paths.count = left < GI_BATCH ? left : GI_BATCH;
		paths.points = &scratch->points[first];
		paths.rays = &scratch->rays[first];
		paths.radiance = scratch->reflected;
		paths.scratch = view->cache->workers[batch->worker].scratch;
		for (uint32_t i = 0; i < paths.count; i++) {
			cache_branch *branch = &scratch->branches[first + i];
			if (view->scene->flagged && branch->left.pdf > 0.0f)
				find_lights(batch, branch, &scratch->rays[first + i], &paths.rays_traced);
			stilb_vec3 glass = gi_through_intersect(view->scene, &scratch->rays[first + i], &paths.rays_traced);
			branch->weight *= glass;
			branch->shown *= glass;
		}
		gi_path_gather(&paths, 1, view->settings.depth - 1);
		for (uint32_t i = 0; i < paths.count; i++) {
			const cache_branch *branch = &scratch->branches[first + i];
			batch->radiance[branch->target] += branch->weight * scratch->reflected[i];
			batch->radiance[branch->target] += branch_found(view, branch, &paths.rays[i]);
		}
		batch->rays_traced = paths.rays_traced;
		batch->shadow_rays = paths.shadow_rays;
	}
}

static void cache_shade(gi_batch *batch)
{
	STILB_ASSERT(batch->view->cache);
	STILB_ASSERT(batch->count <= GI_BATCH);
	cache_scratch *scratch = batch->scratch;
	scratch->shadow_count = scratch->branch_count = 0;
	{
		PROFILE("gi.shade");
		for (uint32_t i = 0; i < batch->count; i++)
			sample_start(batch, i);
	}
	trace_sample_shadows(batch);
	trace_branches(batch);
}

const gi_integrator gi_integrator_irradiance_cache = {.shade = cache_shade, .scratch_size = sizeof(cache_scratch)};
