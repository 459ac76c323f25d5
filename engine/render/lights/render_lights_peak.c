/* How bright a surface can be under a light: what a tolerance of light is shared by. */
#include "render/render_internal.h"
#include "shading/shade_brdf.h"
#include "shading/shade_layers.h"

#include <math.h>

/* The extremes of a scene's materials. Impostors and pictures of distant models mix materials, which stays within. */
typedef struct peak_looks {
	float diffuse, specular, roughness, anisotropy;                /* highest, highest, lowest, farthest from 0 */
	float coat, coat_roughness, sheen, sheen_roughness, thin_left; /* highest, lowest, ..., highest */
} peak_looks;

static float peak_highest(const float color[3])
{
	return fmaxf(color[0], fmaxf(color[1], color[2]));
}

/* What a factor and its map say at least. */
static float peak_lowest(float factor, const stilb_scene_map *map)
{
	return map->texture > 0 ? 0.0f : factor;
}

static void peak_add_surface(peak_looks *looks, const stilb_scene_surface *surface)
{
	const stilb_scene_map *maps = surface->maps;
	float roughness = peak_lowest(surface->roughness, &maps[STILB_SCENE_MAP_REFLECTION]);
	looks->diffuse = looks->specular = 1.0f;
	looks->roughness = fminf(looks->roughness, surface->function > 0 ? 0.0f : roughness);
	looks->coat = fmaxf(looks->coat, surface->clearcoat);
	looks->thin_left = fmaxf(looks->thin_left, surface->transmission);
	float sheen = peak_highest(surface->sheen_color);
	looks->sheen = fmaxf(looks->sheen, sheen);
	if (surface->clearcoat > 0.0f)
		looks->coat_roughness = fminf(looks->coat_roughness, peak_lowest(surface->clearcoat_roughness,
		                                                                 &maps[STILB_SCENE_MAP_CLEARCOAT_ROUGHNESS]));
	if (sheen > 0.0f)
		looks->sheen_roughness = fminf(looks->sheen_roughness,
		                               peak_lowest(surface->sheen_roughness, &maps[STILB_SCENE_MAP_SHEEN_ROUGHNESS]));
}

/* The highlight of a layer: GGX with Smith's shadowing. */
static float peak_of_layer(float roughness)
{
	shade_brdf_model model = {SHADE_BRDF_MICROFACET, SHADE_NDF_GGX, SHADE_G_SMITH_GGX, SHADE_F_NONE};
	return shade_brdf_peak(model, roughness, 0.0f);
}

/* Sheen's D is at most (2 + 1 / alpha) / (2 pi), its V n.l at most 1/4. */
static float peak_of_sheen(float roughness)
{
	float r = fmaxf(roughness, SHADE_SHEEN_ROUGHNESS_MIN);
	return (2.0f + 1.0f / (r * r)) / (8.0f * SHADE_PI);
}

float stilb_render_light_peak(const stilb_scene *scene, const stilb_render_shading *shading)
{
	STILB_ASSERT(scene && shading);
	peak_looks looks = {.roughness = 1.0f, .coat_roughness = 1.0f, .sheen_roughness = 1.0f};
	for (uint32_t m = 0; m < scene->material_count; m++) {
		const stilb_scene_material *material = &scene->materials[m];
		looks.diffuse = fmaxf(looks.diffuse, peak_highest(material->diffuse));
		looks.specular = fmaxf(looks.specular, peak_highest(material->specular));
		looks.roughness = fminf(looks.roughness, material->roughness);
		looks.anisotropy = fmaxf(looks.anisotropy, fabsf(material->anisotropy));
		if (material->surface > 0)
			peak_add_surface(&looks, &scene->surfaces[material->surface - 1]);
	}
	shade_brdf_model model = {(int)shading->brdf, (int)shading->ndf, (int)shading->g, (int)shading->f};
	bool fresnel = model.kind == SHADE_BRDF_MICROFACET && model.f != SHADE_F_NONE;
	bool matt = model.kind == SHADE_BRDF_LAMBERT || model.kind == SHADE_BRDF_WRAPPED;
	float specular = fresnel ? 1.0f : fminf(looks.specular + fmaxf(shading->specular, 0.0f), 1.0f);
	float roughness = fminf(fmaxf(looks.roughness + shading->roughness, 0.0f), 1.0f);
	float anisotropy = fminf(looks.anisotropy + fabsf(shading->anisotropy), 1.0f);
	float peak = looks.diffuse * SHADE_INV_PI;
	if (!matt)
		peak += specular * shade_brdf_peak(model, roughness, anisotropy);
	peak += looks.thin_left * peak_of_layer(roughness) + looks.coat * peak_of_layer(looks.coat_roughness) +
	        looks.sheen * peak_of_sheen(looks.sheen_roughness);
	return fmaxf(peak, SHADE_INV_PI);
}
