#include "gi/integrate/gi_direct.h"

#include "gi/trace/gi_ray.h"

/* The weight, by multiple importance sampling, of a direction that was chosen with density pdf and that another
 * technique chooses with density other: the power heuristic, beta = 2, written so that no square overflows.
 * Source: Veach, "Robust Monte Carlo Methods for Light Transport Simulation" (1997), 9.2.4. */
static float mis_weight(float pdf, float other)
{
	float ratio = other / pdf;
	return 1.0f / (1.0f + ratio * ratio);
}

bool gi_direct_side(const gi_bsdf *bsdf, stilb_vec3 *origin, stilb_vec3 *normal, float *choice, float *chance)
{
	const gi_lobes *lobes = &bsdf->layers->lobes;
	bool beyond = *choice < lobes->ask_beyond;
	*chance = beyond ? lobes->ask_beyond : lobes->ask;
	if (!(*chance > 0.0f))
		return false;
	float rest = beyond ? *choice / *chance : (*choice - lobes->ask_beyond) / *chance;
	*choice = fminf(fmaxf(rest, 0.0f), SHADE_UNIFORM_MAX);
	if (beyond) {
		*origin = lobes->beyond;
		*normal = -*normal;
	}
	return true;
}

bool gi_direct_ask(const gi_view *view, const gi_bsdf *bsdf, stilb_vec3 origin, const float numbers[8], bool weighed,
                   gi_ray *shadow, stilb_vec3 *direct)
{
	STILB_ASSERT(bsdf->share >= 0.0f && bsdf->share <= 1.0f);
	stilb_vec2 u = {numbers[GI_DIMENSION_LIGHT], numbers[GI_DIMENSION_LIGHT + 1]};
	stilb_vec3 normal = bsdf->frame.n;
	float choice = numbers[GI_DIMENSION_CHOICE], chance = 1.0f;
	bool layered = gi_bsdf_is_layered(bsdf);
	gi_light_sample light;
	if (layered && !gi_direct_side(bsdf, &origin, &normal, &choice, &chance))
		return false;
	if (!gi_light_sample_at(gi_view_lights(view), origin, normal, choice, u, &light))
		return false;
	if (layered && gi_bsdf_is_beyond(bsdf, light.direction) != (stilb_vec3_dot(normal, bsdf->frame.n) < 0.0f))
		return false; /* the other side asks there */
	stilb_vec3 sent = gi_bsdf_cos(bsdf, light.direction) * light.radiance;
	if (!(sent[0] + sent[1] + sent[2] > 0.0f))
		return false;
	float pdf = light.pdf * chance, weight = 1.0f / pdf;
	if (weighed && !light.delta)
		weight *= mis_weight(pdf, gi_bsdf_pdf(bsdf, light.direction));
	*direct = sent * weight;
	*shadow = gi_ray_make(origin, light.direction, light.distance, numbers[GI_DIMENSION_CHANCE]);
	return true;
}

stilb_vec3 gi_direct_found(const gi_view *view, float pdf, stilb_vec3 normal, const gi_ray_hit *ray,
                           const gi_surface *surface)
{
	STILB_ASSERT(surface ? gi_is_hit(ray) : !gi_is_hit(ray));
	const gi_lights *lights = gi_view_lights(view);
	stilb_vec3 origin = gi_ray_origin(&ray->ray), direction = gi_ray_direction(&ray->ray);
	if (!surface) {
		stilb_vec3 radiance = gi_environment_radiance(lights, direction);
		return pdf > 0.0f ? radiance * mis_weight(pdf, gi_environment_pdf(lights, origin, normal, direction))
		                  : radiance;
	}
	const gi_part *part = &view->scene->parts[surface->part];
	if (pdf == 0.0f || part->first_light == GI_NO_LIGHT || !surface->front)
		return surface->emission;
	STILB_ASSERT(surface->part == ray->hit.part && surface->triangle == ray->hit.triangle);
	float asked = gi_light_pdf(lights, origin, normal, part->first_light + surface->triangle, ray->ray.t_max);
	return surface->emission * mis_weight(pdf, asked);
}
