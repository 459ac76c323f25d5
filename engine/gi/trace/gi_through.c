#include "gi/trace/gi_through.h"

#include "gi/gi_surface.h"
#include "gi/trace/gi_cover.h"
#include "gi/trace/gi_ray.h"

#include <float.h>

#define THROUGH_CHUNK 64u /* shadow rays whose ends are kept while they are traced together */

/* The ray's hit on glass; false: it is on something else, or there is none. */
static bool through_surface(const stilb_gi_scene *scene, const gi_ray_hit *ray, gi_surface *surface)
{
	if (!gi_is_hit(ray) || !scene->parts[ray->hit.part].passes)
		return false;
	gi_surface_at(scene, ray, surface);
	return surface->layered;
}

/* Goes on behind the surface, up to `end`. Source of the step: gi_surface.error, along the ray. */
static void through_go_on(const stilb_gi_scene *scene, const gi_surface *surface, float end, gi_ray_hit *ray)
{
	float cosine = fabsf(stilb_vec3_dot(surface->geometric, gi_ray_direction(&ray->ray)));
	float at = ray->ray.t_max, step = 2.0f * surface->error / fmaxf(cosine, 1e-3f);
	ray->ray.t_min = fmaxf(at + step, at * (1.0f + 2.0f * FLT_EPSILON));
	ray->ray.t_max = end;
	ray->hit.part = ray->hit.instance = GI_NO_PART;
	if (ray->ray.t_min < end)
		scene->tracer.intersect(&scene->tracer, ray);
}

/* The number of the ray for this pane, other than that by which it blends there. */
static float through_number(const gi_ray_hit *ray)
{
	gi_crossing crossing = {.part = ~ray->hit.part, .triangle = ray->hit.triangle, .chance = ray->ray.time};
	return gi_cover_number(&crossing);
}

stilb_vec3 gi_through(const stilb_gi_scene *scene, gi_ray_hit *ray, uint64_t *traced)
{
	stilb_vec3 factor = stilb_vec3_make(1.0f, 1.0f, 1.0f);
	float end = INFINITY;
	gi_surface surface;
	while (through_surface(scene, ray, &surface)) {
		if (surface.layers.solid)
			factor *= surface.layers.left;
		if (!(through_number(ray) < surface.layers.pass))
			break;
		factor *= surface.layers.passed / surface.layers.pass;
		through_go_on(scene, &surface, end, ray);
		*traced += 1;
	}
	ray->ray.t_min = 0.0f;
	return factor;
}

/* True if nothing but panes is on the shadow ray; *light is what they leave of it. */
static bool through_panes(const stilb_gi_scene *scene, const gi_ray *shadow, stilb_vec3 *light)
{
	gi_ray_hit ray = gi_ray_hit_make_by(gi_ray_origin(shadow), gi_ray_direction(shadow), shadow->time);
	gi_surface surface;
	float end = shadow->t_max;
	ray.ray.t_max = end;
	ray.ray.mask = shadow->mask;
	scene->tracer.intersect(&scene->tracer, &ray);
	while (gi_is_hit(&ray)) {
		if (!through_surface(scene, &ray, &surface) || !(surface.layers.pass > 0.0f))
			return false;
		*light *= surface.layers.passed;
		through_go_on(scene, &surface, end, &ray);
	}
	return true;
}

void gi_through_occluded(const stilb_gi_scene *scene, gi_ray *rays, stilb_vec3 *light, uint32_t count)
{
	if (!scene->passes) {
		scene->tracer.occluded(&scene->tracer, rays, count);
		return;
	}
	for (uint32_t first = 0; first < count; first += THROUGH_CHUNK) {
		uint32_t number = count - first < THROUGH_CHUNK ? count - first : THROUGH_CHUNK;
		float ends[THROUGH_CHUNK];
		for (uint32_t i = 0; i < number; i++)
			ends[i] = rays[first + i].t_max;
		scene->tracer.occluded(&scene->tracer, rays + first, number);
		for (uint32_t i = 0; i < number; i++) {
			gi_ray *ray = &rays[first + i];
			if (ray->t_max >= 0.0f)
				continue;
			ray->t_max = ends[i];
			if (!through_panes(scene, ray, &light[first + i]))
				ray->t_max = -INFINITY;
		}
	}
}
