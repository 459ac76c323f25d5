/* The integrators without recursion: color, direct, ao. */
#include "gi/integrate/gi_direct.h"
#include "gi/integrate/gi_integrator.h"
#include "gi/trace/gi_ray.h"
#include "gi/trace/gi_through.h"
#include "profiler/prof.h"

#include "shading/shade_sampling.h"

/* ---- color ------------------------------------------------------------------------------------------------------- */

/* Diffuse + specular reflectance, or what is unlit; 0 for a miss. */
static void color_shade(gi_batch *batch)
{
	for (uint32_t i = 0; i < batch->count; i++) {
		batch->radiance[i] = stilb_vec3_make(0.0f, 0.0f, 0.0f);
		if (!gi_is_hit(&batch->rays[i]))
			continue;
		gi_surface surface;
		gi_surface_at(batch->view->scene, &batch->rays[i], &surface);
		batch->radiance[i] = gi_surface_albedo(&surface) + surface.unlit;
	}
}

const gi_integrator gi_integrator_color = {.shade = color_shade};

/* ---- direct ------------------------------------------------------------------------------------------------------ */

typedef struct direct_scratch {
	gi_ray shadows[GI_LIGHT_GROUPS * GI_BATCH];   /* id: index of the sample */
	stilb_vec3 light[GI_LIGHT_GROUPS * GI_BATCH]; /* radiance to add if nothing is on the shadow ray */
	uint32_t count;
} direct_scratch;

/* Light that a ray finds which is sampled in the highlight: a highlight is narrow, so that sampling lights alone would
 * be noisy. Weighted by multiple importance sampling against the light that direct_seen samples. */
static stilb_vec3 direct_in_highlight(gi_batch *batch, const gi_bsdf *bsdf, const gi_surface *surface,
                                      const float numbers[GI_DIMENSIONS_VERTEX])
{
	const gi_view *view = batch->view;
	stilb_vec2 u = {numbers[GI_DIMENSION_DIRECTION], numbers[GI_DIMENSION_DIRECTION + 1]};
	gi_bsdf_sample chosen;
	if (!gi_bsdf_sample_direction(bsdf, numbers[GI_DIMENSION_LOBE], u, &chosen))
		return stilb_vec3_make(0.0f, 0.0f, 0.0f);
	gi_ray_hit ray = gi_ray_hit_make_by(gi_surface_ray_origin(surface, chosen.direction), chosen.direction,
	                                    numbers[GI_DIMENSION_CHANCE]);
	gi_surface found;
	stilb_vec3 weight = chosen.weight;
	gi_direct_left left = gi_direct_leave(bsdf, &chosen, GI_DIRECT_WITH_RAY);
	if (left.pdf > 0.0f)
		ray.ray.mask = view->scene->parts[surface->part].lit_by;
	if (!view->settings.no_shadows)
		weight *= gi_through_intersect(view->scene, &ray, &batch->rays_traced);
	if (gi_is_hit(&ray))
		gi_surface_at(view->scene, &ray, &found);
	return weight * gi_direct_found(view, &left, &ray, gi_is_hit(&ray) ? &found : NULL);
}

/* Light that sample i sees without a shadow ray: emission, and what the highlight's own ray finds. Adds a shadow ray
 * for each sampled light to scratch. */
static stilb_vec3 direct_seen(gi_batch *batch, direct_scratch *scratch, uint32_t i)
{
	STILB_ASSERT(scratch->count + GI_LIGHT_GROUPS <= GI_LIGHT_GROUPS * GI_BATCH);
	const gi_view *view = batch->view;
	const gi_ray_hit *ray = &batch->rays[i];
	stilb_vec3 direction = gi_ray_direction(&ray->ray);
	if (!gi_is_hit(ray))
		return gi_environment_radiance(&view->scene->lights, direction);
	gi_surface surface;
	gi_surface_at(view->scene, ray, &surface);
	gi_bsdf bsdf;
	gi_bsdf_make(&view->settings.model, &surface, -direction, &bsdf);
	if (view->settings.no_shadows)
		bsdf.geometric = bsdf.frame.n; /* the triangle itself hides nothing either */
	float numbers[GI_DIMENSIONS_VERTEX];
	gi_sample_8(&view->sampler, batch->points[i], GI_DIMENSION_OF(0), numbers);
	bool highlight = bsdf.share > 0.0f;
	gi_ray *shadows = &scratch->shadows[scratch->count];
	uint32_t asked =
		gi_direct_ask(view, &bsdf, surface.part, gi_surface_ray_origin(&surface, -direction), numbers,
	                  highlight ? GI_DIRECT_WITH_RAY : GI_DIRECT_ALONE, shadows, &scratch->light[scratch->count]);
	for (uint32_t k = 0; k < asked; k++)
		shadows[k].id = i;
	scratch->count += asked;
	stilb_vec3 seen = surface.emission + surface.unlit;
	return highlight ? seen + direct_in_highlight(batch, &bsdf, &surface, numbers) : seen;
}

static void direct_flush(gi_batch *batch, direct_scratch *scratch)
{
	PROFILE("gi.shadow");
	if (!batch->view->settings.no_shadows) {
		gi_through_occluded(batch->view->scene, scratch->shadows, scratch->light, scratch->count);
		batch->rays_traced += scratch->count;
		batch->shadow_rays += scratch->count;
	}
	for (uint32_t s = 0; s < scratch->count; s++)
		if (scratch->shadows[s].t_max >= 0.0f)
			batch->radiance[scratch->shadows[s].id] += scratch->light[s];
}

static void direct_shade(gi_batch *batch)
{
	STILB_ASSERT(batch->count <= GI_BATCH);
	direct_scratch *scratch = batch->scratch;
	scratch->count = 0;
	bool any = batch->view->settings.only != STILB_GI_ONLY_INDIRECT;
	for (uint32_t i = 0; i < batch->count; i++)
		batch->radiance[i] = any ? direct_seen(batch, scratch, i) : stilb_vec3_make(0.0f, 0.0f, 0.0f);
	direct_flush(batch, scratch);
}

const gi_integrator gi_integrator_direct = {.shade = direct_shade, .scratch_size = sizeof(direct_scratch)};

/* ---- ao ---------------------------------------------------------------------------------------------------------- */

#define AO_STREAM 256 /* rays that are collected and then traced together */

typedef struct ao_scratch {
	gi_ray rays[AO_STREAM]; /* id: index of the sample */
	uint32_t count;
} ao_scratch;

/* The k-th ray of sample i, with cosine-weighted density, so that the share of free rays is the result. */
static gi_ray ao_ray(const gi_batch *batch, const gi_surface *surface, uint32_t i, uint32_t k)
{
	STILB_ASSERT(i < batch->count && k < batch->view->settings.rays);
	const gi_view *view = batch->view;
	uint32_t dimension = GI_DIMENSION_OF(0) + GI_DIMENSION_DIRECTION;
	gi_point branch = gi_sampler_branch(&view->sampler, batch->points[i], dimension, k, view->settings.rays);
	shade_sample chosen = shade_sample_cosine(gi_sample_2d(&view->sampler, branch, dimension));
	stilb_vec3 direction = shade_frame_to_world(shade_frame_from_normal(surface->normal), chosen.direction);
	float distance = view->settings.ao_distance;
	float chance =
		view->scene->blends ? gi_sample_2d(&view->sampler, branch, dimension + GI_DIMENSION_ROULETTE)[1] : 0.0f;
	gi_ray ray = gi_ray_make_of(view->scene->parts[surface->part].lit_by, gi_surface_ray_origin(surface, direction),
	                            direction, distance > 0.0f ? distance : INFINITY, chance);
	ray.id = i;
	return ray;
}

/* True if the ray goes below the triangle, which happens where the shading normal leans: the surface itself occludes
 * it. */
static bool ao_below(const gi_surface *surface, const gi_ray *ray)
{
	return stilb_vec3_dot(surface->geometric, gi_ray_direction(ray)) <= 0.0f;
}

/* Traces the collected rays, adds those that meet nothing to their samples' sums, and empties the list. */
static void ao_flush(gi_batch *batch, ao_scratch *scratch)
{
	STILB_ASSERT(scratch->count <= AO_STREAM);
	PROFILE("gi.shadow");
	const gi_tracer *tracer = &batch->view->scene->tracer;
	tracer->occluded(tracer, scratch->rays, scratch->count);
	for (uint32_t r = 0; r < scratch->count; r++)
		if (scratch->rays[r].t_max >= 0.0f)
			batch->radiance[scratch->rays[r].id] += 1.0f;
	batch->rays_traced += scratch->count;
	batch->shadow_rays += scratch->count;
	scratch->count = 0;
}

/* Distance to the nearest hit on the ray as a share of ao_distance; 1: there is none within ao_distance. */
static float ao_reach(gi_batch *batch, const gi_ray *ray)
{
	STILB_ASSERT(batch->view->settings.ao_distance > 0.0f);
	const gi_tracer *tracer = &batch->view->scene->tracer;
	gi_ray_hit hit = gi_ray_hit_make_by(gi_ray_origin(ray), gi_ray_direction(ray), ray->time);
	hit.ray.t_max = ray->t_max;
	hit.ray.mask = ray->mask;
	tracer->intersect(tracer, &hit);
	batch->rays_traced++;
	return gi_is_hit(&hit) ? hit.ray.t_max / batch->view->settings.ao_distance : 1.0f;
}

static void ao_shade(gi_batch *batch)
{
	STILB_ASSERT(batch->count <= GI_BATCH && batch->view->settings.rays >= 1);
	const stilb_gi_settings *settings = &batch->view->settings;
	ao_scratch *scratch = batch->scratch;
	scratch->count = 0;
	for (uint32_t i = 0; i < batch->count; i++) {
		batch->radiance[i] = stilb_vec3_make(0.0f, 0.0f, 0.0f);
		if (!gi_is_hit(&batch->rays[i]))
			continue;
		gi_surface surface;
		gi_surface_at(batch->view->scene, &batch->rays[i], &surface);
		for (uint32_t k = 0; k < settings->rays; k++) {
			gi_ray ray = ao_ray(batch, &surface, i, k);
			if (ao_below(&surface, &ray))
				continue;
			if (settings->ao_weighted) {
				batch->radiance[i] += ao_reach(batch, &ray);
				continue;
			}
			scratch->rays[scratch->count++] = ray;
			if (scratch->count == AO_STREAM)
				ao_flush(batch, scratch);
		}
	}
	ao_flush(batch, scratch);
	for (uint32_t i = 0; i < batch->count; i++)
		batch->radiance[i] =
			gi_is_hit(&batch->rays[i]) ? batch->radiance[i] / (float)settings->rays : stilb_vec3_make(1.0f, 1.0f, 1.0f);
}

const gi_integrator gi_integrator_ao = {.shade = ao_shade, .scratch_size = sizeof(ao_scratch)};
