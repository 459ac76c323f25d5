#include "scene/scene_surface.h"
#include "scene/edit/scene_check.h"

#include <float.h>
#include <math.h>

#define MAP_NAME(id, name, channels, is_color) #name,
const char *const stilb_scene_map_names[] = {STILB_SCENE_MAPS_OF_SURFACES(MAP_NAME) NULL};

stilb_scene_surface stilb_scene_surface_make(void)
{
	stilb_scene_surface surface = {
		.color = {1, 1, 1, 1},
		.roughness = 1.0f,
		.specular = {1, 1, 1},
		.specular_weight = 1.0f,
		.ior = 1.5f,
		.normal_scale = 1.0f,
		.occlusion = 1.0f,
		.cutoff = 0.5f,
		.clearcoat_normal_scale = 1.0f,
		.attenuation = {1, 1, 1},
		.attenuation_distance = INFINITY,
	};
	for (int i = 0; i < STILB_SCENE_MAPS; i++)
		surface.maps[i] = (stilb_scene_map){.to_u = {1, 0, 0}, .to_v = {0, 1, 0}};
	return surface;
}

bool stilb_scene_map_is_color(stilb_scene_map_kind kind, stilb_scene_workflow workflow)
{
#define MAP_IS_COLOR(id, name, channels, is_color) is_color,
	static const bool colors[] = {STILB_SCENE_MAPS_OF_SURFACES(MAP_IS_COLOR)};
	STILB_ASSERT((uint32_t)kind < STILB_SCENE_MAPS);
	return colors[kind] || (kind == STILB_SCENE_MAP_REFLECTION && workflow == STILB_SCENE_SPECULAR);
}

#define SURFACE_MAP_FAR 1e6f /* of a map's transform: beyond it floats are too coarse for a place in a texture */

static const char *surface_map_mistake(const stilb_scene_map *map)
{
	if (map->set > 1)
		return "a map lies on neither of the two uv";
	if (map->wrap_u >= STILB_SCENE_WRAPS || map->wrap_v >= STILB_SCENE_WRAPS)
		return "a map's wrap is unknown";
	if (!scene_is_within(map->to_u, 3, -SURFACE_MAP_FAR, SURFACE_MAP_FAR) ||
	    !scene_is_within(map->to_v, 3, -SURFACE_MAP_FAR, SURFACE_MAP_FAR))
		return "a map's transform is not within 1e6";
	return NULL;
}

const char *stilb_scene_surface_mistake(const stilb_scene_surface *surface)
{
	STILB_ASSERT(surface);
	const stilb_scene_surface *s = surface;
	const float shares[] = {s->metalness, s->roughness,           s->specular_weight, s->occlusion,   s->anisotropy,
	                        s->clearcoat, s->clearcoat_roughness, s->sheen_roughness, s->transmission};
	const float numbers[] = {s->normal_scale, s->clearcoat_normal_scale, s->anisotropy_rotation};
	for (int i = 0; i < STILB_SCENE_MAPS; i++) {
		const char *mistake = surface_map_mistake(&s->maps[i]);
		if (mistake)
			return mistake;
	}
	if ((uint32_t)s->workflow >= STILB_SCENE_WORKFLOWS || (uint32_t)s->alpha >= STILB_SCENE_ALPHAS)
		return "its workflow or its alpha is unknown";
	if (!scene_is_within(s->color, 4, 0.0f, 1.0f) || !scene_is_within(s->sheen_color, 3, 0.0f, 1.0f))
		return "a colour is not in 0..1";
	if (!scene_is_within(s->specular, 3, 0.0f, s->workflow == STILB_SCENE_SPECULAR ? 1.0f : FLT_MAX))
		return "its specular colour is out of range";
	if (!scene_is_within(shares, sizeof shares / sizeof *shares, 0.0f, 1.0f))
		return "a factor is not in 0..1";
	if (!scene_is_within(numbers, sizeof numbers / sizeof *numbers, -FLT_MAX, FLT_MAX))
		return "a scale or the anisotropy's rotation is not finite";
	if (!scene_is_within(s->emission, 3, 0.0f, FLT_MAX))
		return "its emission is negative or not finite";
	if (!(s->ior == 0.0f || (s->ior >= 1.0f && s->ior <= 1e3f)))
		return "its index of refraction is neither 0 nor 1..1000";
	if (!scene_is_within(&s->cutoff, 1, 0.0f, FLT_MAX) || !scene_is_within(&s->thickness, 1, 0.0f, SCENE_FAR))
		return "its cutoff or its thickness is negative or not finite";
	if (!(s->attenuation_distance > 0.0f) || !scene_is_within(s->attenuation, 3, FLT_MIN, 1.0f))
		return "its attenuation is not in 0..1, or has no distance";
	if (!scene_is_within(s->parameters[0], STILB_SCENE_PARAMETERS * 4, -FLT_MAX, FLT_MAX))
		return "a parameter of its function is not finite";
	return NULL;
}
