/* The integrator montecarlo: N rays at every hit, and N more at each of theirs. Its cost is exponential: a baseline
 * for teaching, and the simplest estimator to test the others against. Emitting surfaces are found by those
 * rays only; the lights of the scene's list, which no ray can hit, are sampled. */
#include "gi/integrate/gi_direct.h"
#include "gi/trace/gi_ray.h"
#include "gi/trace/gi_through.h"
#include "profiler/prof.h"

double stilb_gi_montecarlo_rays(const stilb_gi_settings *settings)
{
	STILB_ASSERT(settings->rays >= 1);
	double rays = 0.0, level = (double)settings->width * settings->height * settings->samples;
	for (uint32_t bounce = 0; bounce <= settings->depth; bounce++, level *= settings->rays)
		rays += level;
	return rays;
}

/* The point that a ray hit, and how light is reflected there towards the ray's origin. */
typedef struct hit {
	gi_surface surface;
	gi_bsdf bsdf;
	gi_point point;
	uint32_t vertex; /* reflections between it and the camera; 0: the camera ray's hit */
} hit;

/* Light that reaches the hit from one sampled light of each group and is reflected to the viewer, if no ray can hit
 * that light; else 0: it is found by the rays of `gathered`. */
static stilb_vec3 light_of_list(gi_batch *batch, const hit *at)
{
	STILB_ASSERT(at->vertex < batch->view->settings.depth);
	const gi_view *view = batch->view;
	const gi_lights *lights = &view->scene->lights;
	stilb_vec3 none = stilb_vec3_make(0.0f, 0.0f, 0.0f);
	const gi_part *part = &view->scene->parts[at->surface.part];
	if (lights->listed_count == 0 && !view->scene->flagged)
		return none;
	float numbers[GI_DIMENSIONS_VERTEX];
	gi_sample_8(&view->sampler, at->point, GI_DIMENSION_OF(at->vertex), numbers);
	stilb_vec2 place = {numbers[GI_DIMENSION_LIGHT], numbers[GI_DIMENSION_LIGHT + 1]};
	stilb_vec3 position = at->surface.position, normal = at->surface.normal, geometric = at->surface.geometric;
	float choice = numbers[GI_DIMENSION_CHOICE], chance = 1.0f;
	if (gi_bsdf_is_layered(&at->bsdf) && !gi_direct_side(&at->bsdf, &position, &normal, &choice, &chance))
		return none;
	if (stilb_vec3_dot(normal, at->surface.normal) < 0.0f)
		geometric = -geometric;
	stilb_vec3 sum = none;
	for (gi_light_group group = 0; group < GI_LIGHT_GROUPS; group++) {
		gi_light_sample light;
		if (!gi_light_is_asked(lights, group, false) ||
		    !gi_light_sample_at(lights, group, false, position, normal, choice, place, &light) ||
		    !gi_direct_asks_alone(part, &light) || stilb_vec3_dot(geometric, light.direction) <= 0.0f)
			continue;
		stilb_vec3 origin = gi_surface_ray_origin(&at->surface, light.direction);
		gi_ray shadow =
			gi_ray_make_of(part->lit_by, origin, light.direction, light.distance, numbers[GI_DIMENSION_CHANCE]);
		gi_through_occluded(view->scene, &shadow, &light.radiance, 1);
		batch->rays_traced++;
		batch->shadow_rays++;
		if (shadow.t_max >= 0.0f)
			sum += gi_bsdf_cos(&at->bsdf, light.direction) * light.radiance / (light.pdf * chance);
	}
	return sum;
}

static stilb_vec3 radiance_along(gi_batch *batch, const gi_ray_hit *ray, gi_point point, uint32_t vertex, bool found);

/* Light that arrives along the k-th ray from a surface and is reflected. The rays of a diffuse surface are distributed
 * with the cosine. */
static stilb_vec3 gathered(gi_batch *batch, const hit *at, uint32_t k)
{
	STILB_ASSERT(k < batch->view->settings.rays);
	const gi_view *view = batch->view;
	const gi_sampler *sampler = &view->sampler;
	uint32_t dimension = GI_DIMENSION_OF(at->vertex);
	gi_point branch = gi_sampler_branch(sampler, at->point, dimension, k, view->settings.rays);
	float numbers[GI_DIMENSIONS_VERTEX];
	gi_sample_8(sampler, branch, dimension, numbers);
	stilb_vec2 place = {numbers[GI_DIMENSION_DIRECTION], numbers[GI_DIMENSION_DIRECTION + 1]};
	gi_bsdf_sample chosen;
	if (!gi_bsdf_sample_direction(&at->bsdf, numbers[GI_DIMENSION_LOBE], place, &chosen))
		return stilb_vec3_make(0.0f, 0.0f, 0.0f);
	gi_ray_hit ray = gi_ray_hit_make_by(gi_surface_ray_origin(&at->surface, chosen.direction), chosen.direction,
	                                    numbers[GI_DIMENSION_CHANCE]);
	gi_direct_left left = gi_direct_leave(&at->bsdf, &chosen, GI_DIRECT_WITH_RAY);
	bool found = view->scene->flagged && left.pdf > 0.0f;
	stilb_vec3 lights = stilb_vec3_make(0.0f, 0.0f, 0.0f);
	left.pdf = 0.0f; /* all that the ray finds counts */
	if (found && (view->settings.only != STILB_GI_ONLY_INDIRECT || at->vertex > 0))
		lights = chosen.weight * gi_direct_find(view, &left, at->surface.part, &ray, &batch->rays_traced);
	stilb_vec3 weight = chosen.weight * gi_through_intersect(view->scene, &ray, &batch->rays_traced);
	return lights + weight * radiance_along(batch, &ray, branch, at->vertex + 1, found);
}

/* Radiance that a traced ray brings to its origin. vertex: number of the vertex where it ends. found: but for what is
 * emitted there. */
static stilb_vec3 radiance_along(gi_batch *batch, const gi_ray_hit *ray, gi_point point, uint32_t vertex, bool found)
{
	STILB_ASSERT(vertex <= batch->view->settings.depth);
	const gi_view *view = batch->view;
	bool indirect = view->settings.only == STILB_GI_ONLY_INDIRECT;
	stilb_vec3 direction = gi_ray_direction(&ray->ray);
	stilb_vec3 radiance = stilb_vec3_make(0.0f, 0.0f, 0.0f);
	if (!gi_is_hit(ray))
		return found || (indirect && vertex <= 1) ? radiance : gi_environment_radiance(&view->scene->lights, direction);
	hit at = {.point = point, .vertex = vertex};
	gi_surface_at(view->scene, ray, &at.surface);
	if (!found && (!indirect || vertex > 1))
		radiance += at.surface.emission;
	if (!indirect && vertex == 0)
		radiance += at.surface.unlit;
	if (vertex == view->settings.depth)
		return radiance;
	gi_bsdf_make(&view->settings.model, &at.surface, -direction, &at.bsdf);
	if (!indirect || vertex > 0)
		radiance += light_of_list(batch, &at);
	stilb_vec3 sum = stilb_vec3_make(0.0f, 0.0f, 0.0f);
	for (uint32_t k = 0; k < view->settings.rays; k++)
		sum += gathered(batch, &at, k);
	return radiance + sum / (float)view->settings.rays;
}

static void montecarlo_shade(gi_batch *batch)
{
	STILB_ASSERT(batch->count <= GI_BATCH);
	PROFILE("gi.bounce");
	for (uint32_t i = 0; i < batch->count; i++)
		batch->radiance[i] = radiance_along(batch, &batch->rays[i], batch->points[i], 0, false);
}

const gi_integrator gi_integrator_montecarlo = {.shade = montecarlo_shade};
