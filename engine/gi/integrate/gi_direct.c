#include "gi/integrate/gi_direct.h"

#include "gi/trace/gi_ray.h"
#include "gi/trace/gi_through.h"

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

/* Where lights are asked from. */
typedef struct direct_side {
	stilb_vec3 origin, normal;
	float choice, chance; /* chance: that this side asks */
	bool layered;
	const gi_part *part; /* that the surface is of; NULL: gi_scene.flagged is not set, so that all are alike */
} direct_side;

/* Asks one group. False: the light sends nothing. */
static inline __attribute__((always_inline)) bool direct_ask_group(const gi_view *view, const gi_bsdf *bsdf,
                                                                   const direct_side *side, const float numbers[8],
                                                                   gi_light_group group, gi_direct_beside beside,
                                                                   gi_ray *shadow, stilb_vec3 *direct)
{
	stilb_vec2 u = {numbers[GI_DIMENSION_LIGHT], numbers[GI_DIMENSION_LIGHT + 1]};
	gi_light_sample light;
	if (!gi_light_sample_at(gi_view_lights(view), group, beside != GI_DIRECT_WITH_RAY, side->origin, side->normal,
	                        side->choice, u, &light))
		return false;
	if (side->layered &&
	    gi_bsdf_is_beyond(bsdf, light.direction) != (stilb_vec3_dot(side->normal, bsdf->frame.n) < 0.0f))
		return false; /* the other side asks there */
	stilb_vec3 sent = gi_bsdf_cos(bsdf, light.direction) * light.radiance;
	if (!(sent[0] + sent[1] + sent[2] > 0.0f))
		return false;
	float pdf = light.pdf * side->chance, weight = 1.0f / pdf;
	bool alone = side->part ? gi_direct_asks_alone(side->part, &light) : light.delta;
	if (beside != GI_DIRECT_ALONE && !alone)
		weight *= gi_direct_weight(pdf, gi_bsdf_pdf(bsdf, light.direction));
	*direct = sent * weight;
	*shadow = gi_ray_make_of(side->part ? side->part->lit_by : GI_MASK_LIGHT, side->origin, light.direction,
	                         light.distance, numbers[GI_DIMENSION_CHANCE]);
	return true;
}

/* Always inline: most surfaces have one side, and most scenes no flags; what that leaves is compiled apart. */
static inline __attribute__((always_inline)) uint32_t direct_ask_from(const gi_view *view, const gi_bsdf *bsdf,
                                                                      direct_side side, const float numbers[8],
                                                                      gi_direct_beside beside, gi_ray *shadows,
                                                                      stilb_vec3 *direct)
{
	uint32_t count = 0;
	for (gi_light_group group = 0; group < GI_LIGHT_GROUPS; group++)
		if (gi_light_is_asked(gi_view_lights(view), group, beside != GI_DIRECT_WITH_RAY))
			count += direct_ask_group(view, bsdf, &side, numbers, group, beside, &shadows[count], &direct[count]);
	return count;
}

/* Of a surface of layers, or in a scene where parts are not alike. */
static __attribute__((noinline)) uint32_t direct_ask_rare(const gi_view *view, const gi_bsdf *bsdf, direct_side side,
                                                          const float numbers[8], gi_direct_beside beside,
                                                          gi_ray *shadows, stilb_vec3 *direct)
{
	if (side.layered && !gi_direct_side(bsdf, &side.origin, &side.normal, &side.choice, &side.chance))
		return 0;
	return direct_ask_from(view, bsdf, side, numbers, beside, shadows, direct);
}

uint32_t gi_direct_ask(const gi_view *view, const gi_bsdf *bsdf, uint32_t part, stilb_vec3 origin,
                       const float numbers[8], gi_direct_beside beside, gi_ray *shadows, stilb_vec3 *direct)
{
	STILB_ASSERT(bsdf->share >= 0.0f && bsdf->share <= 1.0f);
	STILB_ASSERT(part < view->scene->part_count);
	bool flagged = view->scene->flagged, layered = gi_bsdf_is_layered(bsdf);
	float choice = numbers[GI_DIMENSION_CHOICE];
	if (flagged || layered) {
		const gi_part *from = flagged ? &view->scene->parts[part] : NULL;
		return direct_ask_rare(view, bsdf, (direct_side){origin, bsdf->frame.n, choice, 1.0f, layered, from}, numbers,
		                       beside, shadows, direct);
	}
	return direct_ask_from(view, bsdf, (direct_side){origin, bsdf->frame.n, choice, 1.0f, false, NULL}, numbers, beside,
	                       shadows, direct);
}

stilb_vec3 gi_direct_found(const gi_view *view, const gi_direct_left *left, const gi_ray_hit *ray,
                           const gi_surface *surface)
{
	STILB_ASSERT(surface ? gi_is_hit(ray) : !gi_is_hit(ray));
	const gi_lights *lights = gi_view_lights(view);
	if (!surface) {
		stilb_vec3 direction = gi_ray_direction(&ray->ray), radiance = gi_environment_radiance(lights, direction);
		if (left->pdf == 0.0f)
			return radiance;
		bool all = left->beside != GI_DIRECT_WITH_RAY;
		return radiance * gi_direct_weight(left->pdf, gi_environment_pdf(lights, left->normal, direction, all));
	}
	const gi_part *part = &view->scene->parts[surface->part];
	if (left->pdf == 0.0f || part->first_light == GI_NO_LIGHT || !surface->front)
		return surface->emission;
	STILB_ASSERT(surface->part == ray->hit.part && surface->triangle == ray->hit.triangle);
	float asked = gi_light_pdf(lights, gi_ray_origin(&ray->ray), left->normal, part->first_light + surface->triangle,
	                           ray->ray.t_max);
	return surface->emission * gi_direct_weight(left->pdf, asked);
}

stilb_vec3 gi_direct_find(const gi_view *view, const gi_direct_left *left, uint32_t part, const gi_ray_hit *ray,
                          uint64_t *traced)
{
	STILB_ASSERT(part < view->scene->part_count && !gi_is_hit(ray));
	gi_ray_hit towards = *ray;
	gi_surface surface;
	towards.ray.mask = view->scene->parts[part].lit_by;
	stilb_vec3 factor = gi_through_intersect(view->scene, &towards, traced);
	if (gi_is_hit(&towards))
		gi_surface_at(view->scene, &towards, &surface);
	return factor * gi_direct_found(view, left, &towards, gi_is_hit(&towards) ? &surface : NULL);
}
