/* What becomes of every surface, whoever read it: magenta if its colour is missing, which maps it needs, its means. */
#include "scene/importer/importer.h"
#include "shading/shade_gltf.h"

#include <math.h>

void importer_magenta(stilb_scene_surface *surface)
{
	surface->workflow = STILB_SCENE_METALLIC;
	surface->color[0] = surface->color[2] = 1.0f;
	surface->color[1] = 0.0f;
	surface->metalness = 0.0f;
	surface->roughness = 1.0f;
	surface->specular_weight = 0.0f;
	surface->maps[STILB_SCENE_MAP_COLOR].texture = 0;
	surface->maps[STILB_SCENE_MAP_REFLECTION].texture = 0;
}

/* ---- layers ------------------------------------------------------------------------------------------------------ */

static bool surface_is_black(const float rgb[3])
{
	return !(rgb[0] > 0.0f || rgb[1] > 0.0f || rgb[2] > 0.0f);
}

bool importer_hides_map(const stilb_scene_surface *s, stilb_scene_map_kind kind)
{
	if (s->unlit)
		return kind != STILB_SCENE_MAP_COLOR;
	switch (kind) {
	case STILB_SCENE_MAP_EMISSION:
		return surface_is_black(s->emission);
	case STILB_SCENE_MAP_CLEARCOAT:
	case STILB_SCENE_MAP_CLEARCOAT_NORMAL:
		return s->clearcoat == 0.0f;
	case STILB_SCENE_MAP_CLEARCOAT_ROUGHNESS:
		return s->clearcoat == 0.0f || s->clearcoat_roughness == 0.0f;
	case STILB_SCENE_MAP_SPECULAR:
		return s->workflow != STILB_SCENE_METALLIC || s->specular_weight == 0.0f;
	case STILB_SCENE_MAP_SPECULAR_COLOR:
		return s->workflow != STILB_SCENE_METALLIC || s->specular_weight == 0.0f || surface_is_black(s->specular);
	case STILB_SCENE_MAP_SHEEN_COLOR:
		return surface_is_black(s->sheen_color);
	case STILB_SCENE_MAP_SHEEN_ROUGHNESS:
		return surface_is_black(s->sheen_color) || s->sheen_roughness == 0.0f;
	case STILB_SCENE_MAP_ANISOTROPY:
		return s->anisotropy == 0.0f;
	case STILB_SCENE_MAP_TRANSMISSION:
		return s->transmission == 0.0f;
	case STILB_SCENE_MAP_THICKNESS:
		return s->transmission == 0.0f || s->thickness == 0.0f;
	default:
		return false;
	}
}

bool importer_has_layers(const stilb_scene_surface *s)
{
	return s->clearcoat > 0.0f || !surface_is_black(s->sheen_color) || s->transmission > 0.0f || s->anisotropy > 0.0f;
}

/* ---- constants --------------------------------------------------------------------------------------------------- */

/* The picture of a map; NULL: the surface has no such map. */
static const importer_texture *constants_picture(const importer *import, const stilb_scene_map *map)
{
	uint32_t index = (map->texture - 1) / 2; /* importer_texture_number */
	STILB_ASSERT(map->texture == 0 || index < import->texture_count);
	return map->texture ? &import->textures[index] : NULL;
}

/* The means of a map's light and of its values as stored, 1 without a map. */
typedef struct constants_mean {
	float light[3], stored[4];
} constants_mean;

static constants_mean constants_mean_of(const importer *import, const stilb_scene_map *map)
{
	constants_mean mean = {{1.0f, 1.0f, 1.0f}, {1.0f, 1.0f, 1.0f, 1.0f}};
	const importer_texture *picture = constants_picture(import, map);
	for (int i = 0; picture && i < 3; i++)
		mean.light[i] = importer_clamp(picture->mean[i], 0.0f, 1e9f);
	for (int i = 0; picture && i < 4; i++)
		mean.stored[i] = importer_clamp(picture->stored_mean[i], 0.0f, 1.0f);
	return mean;
}

void importer_constants(const importer *import, const stilb_scene_surface *s, stilb_scene_material *material)
{
	constants_mean of_color = constants_mean_of(import, &s->maps[STILB_SCENE_MAP_COLOR]);
	constants_mean of_reflection = constants_mean_of(import, &s->maps[STILB_SCENE_MAP_REFLECTION]);
	constants_mean of_emission = constants_mean_of(import, &s->maps[STILB_SCENE_MAP_EMISSION]);
	constants_mean of_specular = constants_mean_of(import, &s->maps[STILB_SCENE_MAP_SPECULAR]);
	constants_mean of_tint = constants_mean_of(import, &s->maps[STILB_SCENE_MAP_SPECULAR_COLOR]);
	stilb_vec3 color = {0}, specular = stilb_vec3_make(s->specular[0], s->specular[1], s->specular[2]);
	shade_gltf_base base;
	for (int i = 0; i < 3; i++)
		color[i] = s->color[i] * fminf(of_color.light[i], 1.0f);
	if (s->workflow == STILB_SCENE_METALLIC) {
		for (int i = 0; i < 3; i++)
			specular[i] *= fminf(of_tint.light[i], 1.0f);
		base =
			shade_gltf_metallic(color, s->metalness * of_reflection.stored[2], s->roughness * of_reflection.stored[1],
		                        shade_gltf_dielectric(s->ior, specular, s->specular_weight * of_specular.stored[3]));
	} else {
		for (int i = 0; i < 3; i++)
			specular[i] *= fminf(of_reflection.light[i], 1.0f);
		base = shade_gltf_specular(color, specular, (1.0f - s->roughness) * of_reflection.stored[3]);
	}
	const float diffuse[3] = {base.diffuse[0], base.diffuse[1], base.diffuse[2]};
	const float reflected[3] = {base.specular[0], base.specular[1], base.specular[2]};
	*material = stilb_scene_material_make(diffuse, reflected, base.roughness);
	for (int i = 0; i < 3; i++)
		material->emission[i] = importer_clamp(s->emission[i] * of_emission.light[i], 0.0f, 1e9f);
}
