/* What a material of glTF has beyond constants: its maps, how they lie, and the factors of the extensions. */
#include "scene/importer/gltf/gltf.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* ---- where maps are ---------------------------------------------------------------------------------------------- */

#define SURFACE_PBR "pbrMetallicRoughness"
#define SURFACE_GLOSS "KHR_materials_pbrSpecularGlossiness"
#define SURFACE_COAT "KHR_materials_clearcoat"
#define SURFACE_SPECULAR "KHR_materials_specular"
#define SURFACE_SHEEN "KHR_materials_sheen"
#define SURFACE_BRUSHED "KHR_materials_anisotropy"
#define SURFACE_THROUGH "KHR_materials_transmission"
#define SURFACE_VOLUME "KHR_materials_volume"

/* The keys of the maps. */
static const struct surface_key {
	const char *key, *within; /* within: the object or the extension that has it; NULL: the material itself */
} surface_keys[STILB_SCENE_MAPS] = {
	[STILB_SCENE_MAP_COLOR] = {"baseColorTexture", SURFACE_PBR},
	[STILB_SCENE_MAP_REFLECTION] = {"metallicRoughnessTexture", SURFACE_PBR},
	[STILB_SCENE_MAP_NORMAL] = {"normalTexture", NULL},
	[STILB_SCENE_MAP_OCCLUSION] = {"occlusionTexture", NULL},
	[STILB_SCENE_MAP_EMISSION] = {"emissiveTexture", NULL},
	[STILB_SCENE_MAP_CLEARCOAT] = {"clearcoatTexture", SURFACE_COAT},
	[STILB_SCENE_MAP_CLEARCOAT_ROUGHNESS] = {"clearcoatRoughnessTexture", SURFACE_COAT},
	[STILB_SCENE_MAP_CLEARCOAT_NORMAL] = {"clearcoatNormalTexture", SURFACE_COAT},
	[STILB_SCENE_MAP_SPECULAR] = {"specularTexture", SURFACE_SPECULAR},
	[STILB_SCENE_MAP_SPECULAR_COLOR] = {"specularColorTexture", SURFACE_SPECULAR},
	[STILB_SCENE_MAP_SHEEN_COLOR] = {"sheenColorTexture", SURFACE_SHEEN},
	[STILB_SCENE_MAP_SHEEN_ROUGHNESS] = {"sheenRoughnessTexture", SURFACE_SHEEN},
	[STILB_SCENE_MAP_ANISOTROPY] = {"anisotropyTexture", SURFACE_BRUSHED},
	[STILB_SCENE_MAP_TRANSMISSION] = {"transmissionTexture", SURFACE_THROUGH},
	[STILB_SCENE_MAP_THICKNESS] = {"thicknessTexture", SURFACE_VOLUME},
};

static bool surface_is_glossy(gltf *from, uint32_t item)
{
	return gltf_extension(from, item, SURFACE_GLOSS) != GLTF_NONE;
}

static bool surface_is_unlit(gltf *from, uint32_t item)
{
	return gltf_extension(from, item, "KHR_materials_unlit") != GLTF_NONE;
}

/* The token of the texture info of a map, whatever is shown of it; GLTF_NONE: there is none. */
static uint32_t surface_info(gltf *from, uint32_t item, stilb_scene_map_kind kind)
{
	scene_json *json = &from->json;
	const struct surface_key *map = &surface_keys[kind];
	if (kind <= STILB_SCENE_MAP_REFLECTION && surface_is_glossy(from, item))
		return scene_json_member(json, gltf_extension(from, item, SURFACE_GLOSS),
		                         kind == STILB_SCENE_MAP_COLOR ? "diffuseTexture" : "specularGlossinessTexture");
	if (!map->within)
		return scene_json_member(json, item, map->key);
	return scene_json_member(json,
	                         kind <= STILB_SCENE_MAP_REFLECTION ? scene_json_member(json, item, map->within)
	                                                            : gltf_extension(from, item, map->within),
	                         map->key);
}

uint32_t gltf_map_info(gltf *from, uint32_t item, stilb_scene_map_kind kind)
{
	stilb_scene_surface surface;
	uint32_t info = surface_info(from, item, kind);
	if (info == GLTF_NONE)
		return GLTF_NONE;
	gltf_surface_factors(from, item, &surface);
	return importer_hides_map(&surface, kind) ? GLTF_NONE : info;
}

/* ---- how they lie ------------------------------------------------------------------------------------------------ */

/* The attribute with the places of a map: TEXCOORD_<n>. */
static uint32_t surface_set(gltf *from, uint32_t info)
{
	scene_json *json = &from->json;
	uint32_t transform = gltf_extension(from, info, "KHR_texture_transform");
	uint64_t set = scene_json_size(json, transform, "texCoord", scene_json_size(json, info, "texCoord", 0));
	return set < GLTF_SETS_MOST ? (uint32_t)set : GLTF_SETS_MOST;
}

/* Finds what tangents are made for: a map of normals, or else of the coat's normals, or of the direction of brushing,
 * or else, where the surface is brushed without a map, the uv as it is. */
static void surface_need_tangents(gltf *from, uint32_t item, gltf_sets *sets)
{
	static const stilb_scene_map_kind kinds[] = {STILB_SCENE_MAP_NORMAL, STILB_SCENE_MAP_CLEARCOAT_NORMAL,
	                                             STILB_SCENE_MAP_ANISOTROPY};
	stilb_scene_surface surface = stilb_scene_surface_make();
	sets->normal = surface.maps[STILB_SCENE_MAP_NORMAL];
	for (size_t i = 0; item != GLTF_NONE && !sets->normals && i < sizeof kinds / sizeof *kinds; i++) {
		uint32_t info = gltf_map_info(from, item, kinds[i]);
		sets->normals = info != GLTF_NONE && gltf_map_read(from, info, sets, &sets->normal);
	}
	if (item == GLTF_NONE || sets->normals || gltf_extension(from, item, SURFACE_BRUSHED) == GLTF_NONE)
		return;
	gltf_surface_factors(from, item, &surface);
	sets->normals = surface.anisotropy > 0.0f;
}

gltf_sets gltf_material_sets(gltf *from, uint32_t material)
{
	gltf_sets sets = {.set = {0, 1}};
	uint32_t used[2] = {GLTF_NONE, GLTF_NONE}, count = 0; /* ascending */
	uint32_t item = material == GLTF_NONE ? GLTF_NONE : from->lists[GLTF_MATERIALS].items[material];
	for (int kind = 0; item != GLTF_NONE && kind < STILB_SCENE_MAPS; kind++) {
		uint32_t info = gltf_map_info(from, item, (stilb_scene_map_kind)kind);
		if (info == GLTF_NONE)
			continue;
		uint32_t set = surface_set(from, info);
		sets.any = true;
		if (set == used[0] || set == used[1])
			continue;
		count++;
		if (used[0] == GLTF_NONE || set < used[0]) {
			used[1] = used[0];
			used[0] = set;
		} else if (set < used[1]) {
			used[1] = set;
		}
	}
	if (count > 0 && (used[0] > 1 || (count > 1 && used[1] > 1))) {
		sets.set[0] = used[0];
		sets.set[1] = count > 1 ? used[1] : GLTF_NONE;
	}
	surface_need_tangents(from, item, &sets);
	sets.second = count > 0 && sets.set[1] != GLTF_NONE && (sets.set[1] == used[0] || sets.set[1] == used[1]);
	return sets;
}

/* A number of a transform: NaN is 0. */
static float surface_number(float value)
{
	return value == value ? importer_clamp(value, -1e6f, 1e6f) : 0.0f;
}

/* KHR_texture_transform: scale, then turn, then move. Its angle is counter-clockwise as one sees the texture, whose v
 * points down: (1, 0) goes to (cos, -sin). */
static void surface_transform(gltf *from, uint32_t transform, stilb_scene_map *map)
{
	scene_json *json = &from->json;
	float offset[2] = {0, 0}, scale[2] = {1, 1};
	float angle = (float)scene_json_number(json, transform, "rotation", 0.0);
	scene_json_numbers(json, transform, "offset", offset, 2);
	scene_json_numbers(json, transform, "scale", scale, 2);
	float c = cosf(angle), s = sinf(angle);
	const float rows[2][3] = {{c * scale[0], s * scale[1], offset[0]}, {-s * scale[0], c * scale[1], offset[1]}};
	for (int i = 0; i < 3; i++) {
		map->to_u[i] = surface_number(rows[0][i]);
		map->to_v[i] = surface_number(rows[1][i]);
	}
}

static uint8_t surface_wrap(gltf *from, uint32_t sampler, const char *key)
{
	enum { CLAMP_TO_EDGE = 33071, MIRRORED_REPEAT = 33648 };
	uint64_t wrap = scene_json_size(&from->json, sampler, key, 0);
	return wrap == CLAMP_TO_EDGE     ? STILB_SCENE_CLAMP
	       : wrap == MIRRORED_REPEAT ? STILB_SCENE_MIRROR
	                                 : STILB_SCENE_REPEAT;
}

static void surface_sampler(gltf *from, uint32_t info, stilb_scene_map *map)
{
	enum { NEAREST = 9728 };
	uint32_t texture = gltf_reference(from, info, "index", GLTF_TEXTURES);
	uint32_t sampler = texture == GLTF_NONE
	                       ? GLTF_NONE
	                       : gltf_reference(from, from->lists[GLTF_TEXTURES].items[texture], "sampler", GLTF_SAMPLERS);
	uint32_t item = sampler == GLTF_NONE ? GLTF_NONE : from->lists[GLTF_SAMPLERS].items[sampler];
	map->wrap_u = surface_wrap(from, item, "wrapS");
	map->wrap_v = surface_wrap(from, item, "wrapT");
	map->nearest = scene_json_size(&from->json, item, "magFilter", 0) == NEAREST;
}

bool gltf_map_read(gltf *from, uint32_t info, const gltf_sets *sets, stilb_scene_map *map)
{
	uint32_t transform = gltf_extension(from, info, "KHR_texture_transform"), set = surface_set(from, info);
	if (set != sets->set[0] && set != sets->set[1])
		return false;
	map->set = set != sets->set[0];
	surface_sampler(from, info, map);
	if (transform != GLTF_NONE)
		surface_transform(from, transform, map);
	return true;
}

/* ---- factors ----------------------------------------------------------------------------------------------------- */

static float surface_share(gltf *from, uint32_t object, const char *key, double missing)
{
	return importer_clamp((float)scene_json_number(&from->json, object, key, missing), 0.0f, 1.0f);
}

/* Reads `count` numbers in [0, most], if they are there. */
static void surface_color(gltf *from, uint32_t object, const char *key, float *color, uint32_t count, float most)
{
	float values[4];
	if (!scene_json_numbers(&from->json, object, key, values, count))
		return;
	for (uint32_t i = 0; i < count; i++)
		color[i] = importer_clamp(values[i], 0.0f, most);
}

static float surface_scale(gltf *from, uint32_t info, const char *key)
{
	return importer_clamp((float)scene_json_number(&from->json, info, key, 1.0), -1e3f, 1e3f);
}

static void surface_metallic(gltf *from, uint32_t item, stilb_scene_surface *surface)
{
	uint32_t pbr = scene_json_member(&from->json, item, SURFACE_PBR);
	uint32_t specular = gltf_extension(from, item, SURFACE_SPECULAR);
	uint32_t ior = gltf_extension(from, item, "KHR_materials_ior");
	float index = (float)scene_json_number(&from->json, ior, "ior", 1.5);
	surface_color(from, pbr, "baseColorFactor", surface->color, 4, 1.0f);
	surface->metalness = surface_share(from, pbr, "metallicFactor", 1.0);
	surface->roughness = surface_share(from, pbr, "roughnessFactor", 1.0);
	surface_color(from, specular, "specularColorFactor", surface->specular, 3, 1e9f);
	surface->specular_weight = surface_share(from, specular, "specularFactor", 1.0);
	surface->ior = index == 0.0f ? 0.0f : importer_clamp(index, 1.0f, 1e3f); /* 0 stands for a mirror */
}

static void surface_glossy(gltf *from, uint32_t gloss, stilb_scene_surface *surface)
{
	surface->workflow = STILB_SCENE_SPECULAR;
	surface_color(from, gloss, "diffuseFactor", surface->color, 4, 1.0f);
	surface_color(from, gloss, "specularFactor", surface->specular, 3, 1.0f);
	surface->roughness = 1.0f - surface_share(from, gloss, "glossinessFactor", 1.0);
}

static void surface_alpha(gltf *from, uint32_t item, stilb_scene_surface *surface)
{
	scene_json *json = &from->json;
	uint32_t mode = scene_json_member(json, item, "alphaMode");
	if (scene_json_is(json, mode, "MASK"))
		surface->alpha = STILB_SCENE_MASK;
	if (scene_json_is(json, mode, "BLEND"))
		surface->alpha = STILB_SCENE_BLEND;
	surface->cutoff = importer_clamp((float)scene_json_number(json, item, "alphaCutoff", 0.5), 0.0f, 1e9f);
	surface->one_sided = !scene_json_bool(json, item, "doubleSided", false);
	surface->unlit = surface_is_unlit(from, item);
}

/* What lies on the surface: clear coat and sheen; and along which way it is brushed. */
static void surface_layers(gltf *from, uint32_t item, stilb_scene_surface *surface)
{
	scene_json *json = &from->json;
	uint32_t coat = gltf_extension(from, item, SURFACE_COAT), sheen = gltf_extension(from, item, SURFACE_SHEEN);
	uint32_t brushed = gltf_extension(from, item, SURFACE_BRUSHED);
	surface->clearcoat = surface_share(from, coat, "clearcoatFactor", 0.0);
	surface->clearcoat_roughness = surface_share(from, coat, "clearcoatRoughnessFactor", 0.0);
	surface->clearcoat_normal_scale =
		surface_scale(from, surface_info(from, item, STILB_SCENE_MAP_CLEARCOAT_NORMAL), "scale");
	surface_color(from, sheen, "sheenColorFactor", surface->sheen_color, 3, 1.0f);
	surface->sheen_roughness = surface_share(from, sheen, "sheenRoughnessFactor", 0.0);
	surface->anisotropy = surface_share(from, brushed, "anisotropyStrength", 0.0);
	surface->anisotropy_rotation = surface_number((float)scene_json_number(json, brushed, "anisotropyRotation", 0.0));
}

/* What goes through the surface. Exporters write a distance of 0 for glass that absorbs nothing, which has none. */
static void surface_transmission(gltf *from, uint32_t item, stilb_scene_surface *surface)
{
	scene_json *json = &from->json;
	uint32_t through = gltf_extension(from, item, SURFACE_THROUGH), volume = gltf_extension(from, item, SURFACE_VOLUME);
	float distance = (float)scene_json_number(json, volume, "attenuationDistance", 0.0);
	surface->transmission = surface_share(from, through, "transmissionFactor", 0.0);
	surface->thickness = importer_clamp((float)scene_json_number(json, volume, "thicknessFactor", 0.0), 0.0f, 1e9f);
	surface->attenuation_distance = distance > 0.0f ? distance : INFINITY;
	surface_color(from, volume, "attenuationColor", surface->attenuation, 3, 1.0f);
	for (int i = 0; i < 3; i++)
		surface->attenuation[i] = fmaxf(surface->attenuation[i], FLT_MIN); /* black has no logarithm */
}

void gltf_surface_factors(gltf *from, uint32_t item, stilb_scene_surface *surface)
{
	scene_json *json = &from->json;
	uint32_t gloss = gltf_extension(from, item, SURFACE_GLOSS);
	uint32_t extension = gltf_extension(from, item, "KHR_materials_emissive_strength");
	float strength = importer_clamp((float)scene_json_number(json, extension, "emissiveStrength", 1.0), 0.0f, 1e9f);
	uint32_t occlusion = surface_info(from, item, STILB_SCENE_MAP_OCCLUSION);
	*surface = stilb_scene_surface_make();
	if (gloss == GLTF_NONE)
		surface_metallic(from, item, surface);
	else
		surface_glossy(from, gloss, surface);
	surface_color(from, item, "emissiveFactor", surface->emission, 3, 1e9f);
	for (int i = 0; i < 3; i++)
		surface->emission[i] = fminf(surface->emission[i] * strength, 1e9f);
	surface->normal_scale = surface_scale(from, surface_info(from, item, STILB_SCENE_MAP_NORMAL), "scale");
	surface->occlusion = surface_share(from, occlusion, "strength", 1.0);
	surface_layers(from, item, surface);
	surface_transmission(from, item, surface);
	surface_alpha(from, item, surface);
}

bool gltf_material_needs_surface(gltf *from, uint32_t material)
{
	if (from->shown[material] & GLTF_SHOWN_COLORED)
		return true;
	if (material >= from->lists[GLTF_MATERIALS].count)
		return false; /* the default one */
	stilb_scene_surface surface;
	uint32_t item = from->lists[GLTF_MATERIALS].items[material];
	for (int kind = 0; kind < STILB_SCENE_MAPS; kind++)
		if (gltf_texture_picture(from, gltf_map_info(from, item, (stilb_scene_map_kind)kind)) != GLTF_NONE)
			return true;
	gltf_surface_factors(from, item, &surface);
	return surface.alpha != STILB_SCENE_OPAQUE || surface.unlit || importer_has_layers(&surface);
}
