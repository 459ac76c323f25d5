#include "gi/gi_maps.h"

#include "gi/gi_texture.h"
#include "gi/gi_vector.h"

/* What is brighter counts as this, as texels of panoramas do. */
#define RADIANCE_MAX 1e15f

/* ---- places ------------------------------------------------------------------------------------------------------ */

gi_place gi_place_of(const stilb_scene_vertex *vertex, const stilb_scene_vertex_extra *extra)
{
	gi_place place = {.uv = {{vertex->uv[0], vertex->uv[1]}}, .color = {1.0f, 1.0f, 1.0f, 1.0f}};
	if (extra) {
		place.uv[1] = (stilb_vec2){extra->uv[0], extra->uv[1]};
		place.color = (stilb_vec4){extra->color[0], extra->color[1], extra->color[2], extra->color[3]};
	}
	return place;
}

gi_place gi_place_between(const gi_place corners[3], float u, float v)
{
	const gi_place *a = &corners[0], *b = &corners[1], *c = &corners[2];
	gi_place place;
	for (int set = 0; set < 2; set++)
		place.uv[set] = a->uv[set] + ((b->uv[set] - a->uv[set]) * u + (c->uv[set] - a->uv[set]) * v);
	place.color = a->color + ((b->color - a->color) * u + (c->color - a->color) * v);
	return place;
}

/* ---- maps -------------------------------------------------------------------------------------------------------- */

bool gi_maps_vary(const stilb_scene_surface *surface)
{
	uint32_t any = 0;
	for (int kind = 0; kind < STILB_SCENE_MAPS; kind++)
		if (kind != STILB_SCENE_MAP_OCCLUSION && kind != STILB_SCENE_MAP_THICKNESS)
			any |= surface->maps[kind].texture;
	return any > 0;
}

bool gi_maps_are_layered(const stilb_scene_surface *surface)
{
	const float *sheen = surface->sheen_color;
	return surface->clearcoat > 0.0f || sheen[0] + sheen[1] + sheen[2] > 0.0f || surface->anisotropy > 0.0f ||
	       surface->transmission > 0.0f;
}

/* All four channels of a map's texel, 1 where there is none. */
static stilb_vec4 maps_texel(const gi_maps *maps, stilb_scene_map_kind kind, const gi_place *place)
{
	if (!gi_maps_have(maps, kind))
		return (stilb_vec4){1.0f, 1.0f, 1.0f, 1.0f};
	const stilb_scene_map *map = &maps->surface->maps[kind];
	STILB_ASSERT(map->set < 2);
	return gi_texture_map(&maps->textures[map->texture - 1], map, place->uv[map->set]);
}

static stilb_vec4 maps_limited(stilb_vec4 x)
{
	for (int i = 0; i < 4; i++)
		x[i] = fminf(fmaxf(x[i], 0.0f), 1.0f);
	return x;
}

stilb_vec4 gi_maps_texel(const gi_maps *maps, stilb_scene_map_kind kind, const gi_place *place)
{
	return maps_limited(maps_texel(maps, kind, place));
}

/* Textures of floats and vertices may hold anything; what reflects more than it gets would make light. */
stilb_vec4 gi_maps_color(const gi_maps *maps, const gi_place *place)
{
	const float *c = maps->surface->color;
	stilb_vec4 factor = {c[0], c[1], c[2], c[3]};
	return maps_limited(factor * place->color * maps_texel(maps, STILB_SCENE_MAP_COLOR, place));
}

shade_gltf_base gi_maps_base(const gi_maps *maps, const gi_place *place, stilb_vec4 color)
{
	const stilb_scene_surface *surface = maps->surface;
	stilb_vec4 texel = maps_limited(maps_texel(maps, STILB_SCENE_MAP_REFLECTION, place));
	if (surface->workflow == STILB_SCENE_SPECULAR)
		return shade_gltf_specular(color, gi_vector(surface->specular) * texel, (1.0f - surface->roughness) * texel[3]);
	stilb_vec4 tint = maps_texel(maps, STILB_SCENE_MAP_SPECULAR_COLOR, place);
	float weight = maps_texel(maps, STILB_SCENE_MAP_SPECULAR, place)[3];
	stilb_vec3 dielectric =
		shade_gltf_dielectric(surface->ior, gi_vector(surface->specular) * tint, surface->specular_weight * weight);
	return shade_gltf_metallic(color, surface->metalness * texel[2], surface->roughness * texel[1],
	                           maps_limited(dielectric));
}

float gi_maps_metalness(const gi_maps *maps, const gi_place *place)
{
	if (maps->surface->workflow == STILB_SCENE_SPECULAR)
		return 0.0f;
	return maps->surface->metalness * maps_limited(maps_texel(maps, STILB_SCENE_MAP_REFLECTION, place))[2];
}

float gi_maps_occlusion(const gi_maps *maps, const gi_place *place)
{
	float texel = maps_limited(maps_texel(maps, STILB_SCENE_MAP_OCCLUSION, place))[0];
	return shade_gltf_occlusion(texel, maps->surface->occlusion);
}

stilb_vec3 gi_maps_emission(const gi_maps *maps, const gi_place *place)
{
	stilb_vec3 emission = gi_vector(maps->surface->emission);
	if (!gi_maps_have(maps, STILB_SCENE_MAP_EMISSION))
		return emission;
	stilb_vec4 texel = maps_texel(maps, STILB_SCENE_MAP_EMISSION, place);
	for (int i = 0; i < 3; i++)
		emission[i] = fminf(emission[i] * fminf(fmaxf(texel[i], 0.0f), RADIANCE_MAX), RADIANCE_MAX); /* NaN is 0 */
	return emission;
}

float gi_maps_alpha(const gi_maps *maps, const gi_place *place)
{
	if (maps->surface->alpha == STILB_SCENE_OPAQUE)
		return 1.0f;
	return gi_maps_alpha_at(maps, place->uv[maps->surface->maps[STILB_SCENE_MAP_COLOR].set], place->color[3]);
}

float gi_maps_alpha_at(const gi_maps *maps, stilb_vec2 uv, float alpha)
{
	STILB_ASSERT(maps->surface->alpha != STILB_SCENE_OPAQUE);
	alpha *= maps->surface->color[3];
	const stilb_scene_map *map = &maps->surface->maps[STILB_SCENE_MAP_COLOR];
	if (gi_maps_have(maps, STILB_SCENE_MAP_COLOR))
		alpha *= gi_texture_alpha(&maps->textures[map->texture - 1], map, uv);
	if (maps->surface->alpha == STILB_SCENE_MASK)
		return alpha < maps->surface->cutoff ? 0.0f : 1.0f;
	return fminf(fmaxf(alpha, 0.0f), 1.0f);
}

/* A picture of two channels has x as grey and y as alpha. */
stilb_vec3 gi_maps_normal(const gi_maps *maps, stilb_scene_map_kind kind, float scale, const gi_place *place)
{
	STILB_ASSERT(gi_maps_have(maps, kind));
	stilb_vec4 texel = maps_texel(maps, kind, place);
	if (maps->textures[maps->surface->maps[kind].texture - 1].channels == 2)
		texel = stilb_vec3_make(texel[0], texel[3], shade_gltf_normal_z(texel[0], texel[3]));
	return shade_gltf_normal(texel, scale);
}
