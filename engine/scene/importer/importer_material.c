/* Makes surfaces of Assimp's materials, metallic-roughness, specular-glossiness or Phong's, and constants of these. */
#include "scene/importer/importer.h"

#include <assimp/GltfMaterial.h>
#include <assimp/material.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* One of Assimp's materials while it is read. */
typedef struct material_reader {
	importer *import;
	const struct aiMaterial *from;
	struct aiString name;
	bool missing_texture; /* a texture of its colour could not be loaded: the material becomes magenta */
	stilb_scene_surface surface;
	bool needs_surface;
} material_reader;

/* Reads a colour, >= 0; false: the material has none of this key. */
static bool material_color(const material_reader *reader, const char *key, unsigned type, unsigned index, float rgb[3])
{
	struct aiColor4D color;
	if (aiGetMaterialColor(reader->from, key, type, index, &color) != aiReturn_SUCCESS)
		return false;
	rgb[0] = importer_clamp(color.r, 0.0f, 1e9f);
	rgb[1] = importer_clamp(color.g, 0.0f, 1e9f);
	rgb[2] = importer_clamp(color.b, 0.0f, 1e9f);
	return true;
}

/* Reads a number; false: the material has none of this key. */
static bool material_number(const material_reader *reader, const char *key, unsigned type, unsigned index, float *out)
{
	ai_real value;
	unsigned count = 1;
	if (aiGetMaterialFloatArray(reader->from, key, type, index, &value, &count) != aiReturn_SUCCESS || count < 1)
		return false;
	*out = importer_clamp(value, -1e9f, 1e9f);
	return true;
}

/* The texture of the first of two kinds that the material has and that could be loaded, *kind then says which; NULL:
 * none. */
static const importer_texture *material_texture_of(material_reader *reader, enum aiTextureType first,
                                                   enum aiTextureType second, bool color, enum aiTextureType *kind)
{
	const enum aiTextureType kinds[2] = {first, second};
	struct aiString path;
	for (int i = 0; i < 2; i++) {
		if (aiGetMaterialTexture(reader->from, kinds[i], 0, &path, NULL, NULL, NULL, NULL, NULL, NULL) !=
		        aiReturn_SUCCESS ||
		    !importer_texture_is_named(&path))
			continue;
		uint32_t texture = importer_texture_of(reader->import, path.data, reader->name.data, color);
		reader->missing_texture |= color && texture == UINT32_MAX;
		STILB_ASSERT(texture == UINT32_MAX || texture < reader->import->texture_count);
		*kind = kinds[i];
		if (texture != UINT32_MAX)
			return &reader->import->textures[texture];
	}
	return NULL;
}

static uint8_t material_wrap(const material_reader *reader, const char *key, unsigned type)
{
	float mode = (float)aiTextureMapMode_Wrap;
	material_number(reader, key, type, 0, &mode);
	return mode == (float)aiTextureMapMode_Clamp || mode == (float)aiTextureMapMode_Decal ? STILB_SCENE_CLAMP
	       : mode == (float)aiTextureMapMode_Mirror                                       ? STILB_SCENE_MIRROR
	                                                                                      : STILB_SCENE_REPEAT;
}

/* Makes a texture of one of two kinds a map of the surface; NULL: the material has none. Its transform is in the uv
 * already. */
static const importer_texture *foreign_map(material_reader *reader, stilb_scene_map_kind to, enum aiTextureType first,
                                           enum aiTextureType second)
{
	enum aiTextureType kind = first;
	bool color = to == STILB_SCENE_MAP_COLOR;
	const importer_texture *texture = material_texture_of(reader, first, second, color, &kind);
	if (!texture)
		return NULL;
	stilb_scene_map *map = &reader->surface.maps[to];
	map->texture = importer_texture_number((uint32_t)(texture - reader->import->textures),
	                                       stilb_scene_map_is_color(to, STILB_SCENE_METALLIC));
	map->wrap_u = material_wrap(reader, _AI_MATKEY_MAPPINGMODE_U_BASE, kind);
	map->wrap_v = material_wrap(reader, _AI_MATKEY_MAPPINGMODE_V_BASE, kind);
	reader->needs_surface = true;
	return texture;
}

/* ---- kinds ------------------------------------------------------------------------------------------------------- */

/* Reads a material of metalness and roughness. A map of both, of files in which green is roughness and blue metalness,
 * counts by its mean. */
static void material_metallic(material_reader *reader)
{
	stilb_scene_surface *s = &reader->surface;
	float color[3] = {1, 1, 1}, metal = 1.0f, rough = 1.0f;
	enum aiTextureType kind;
	if (!material_color(reader, AI_MATKEY_BASE_COLOR, color))
		material_color(reader, AI_MATKEY_COLOR_DIFFUSE, color);
	material_number(reader, AI_MATKEY_METALLIC_FACTOR, &metal);
	material_number(reader, AI_MATKEY_ROUGHNESS_FACTOR, &rough);
	const importer_texture *map =
		material_texture_of(reader, aiTextureType_UNKNOWN, aiTextureType_DIFFUSE_ROUGHNESS, false, &kind);
	if (map)
		importer_lose(reader->import, IMPORTER_LOSS_METAL_MAPS, reader->name.data);
	for (int i = 0; i < 3; i++)
		s->color[i] = importer_clamp(color[i], 0.0f, 1.0f);
	s->metalness = importer_clamp(metal * (map ? map->stored_mean[2] : 1.0f), 0.0f, 1.0f);
	s->roughness = importer_clamp(rough * (map ? map->stored_mean[1] : 1.0f), 0.0f, 1.0f);
}

/* Makes the surface one of these reflectances: as a material whose constants they are, within what it may have. */
static void material_reflect(material_reader *reader, const float diffuse[3], const float specular[3], float roughness)
{
	stilb_scene_surface *s = &reader->surface;
	stilb_scene_material fit = stilb_scene_material_make(diffuse, specular, importer_clamp(roughness, 0.0f, 1.0f));
	float left = 1.0f - fmaxf(fmaxf(fit.specular[0], fit.specular[1]), fit.specular[2]);
	s->workflow = STILB_SCENE_SPECULAR;
	s->roughness = fit.roughness;
	for (int i = 0; i < 3; i++) {
		s->specular[i] = fit.specular[i];
		s->color[i] = left > 0.0f ? fminf(fit.diffuse[i] / left, 1.0f) : 0.0f;
	}
}

static void material_glossy(material_reader *reader, float gloss)
{
	float diffuse[3] = {1, 1, 1}, specular[3] = {1, 1, 1};
	material_color(reader, AI_MATKEY_COLOR_DIFFUSE, diffuse);
	material_color(reader, AI_MATKEY_COLOR_SPECULAR, specular);
	material_reflect(reader, diffuse, specular, 1.0f - gloss);
}

/* Converts a Phong material, whose specular colour was chosen by eye and conserves no energy. A heuristic: white counts
 * as twice the reflectance of plastic, mid grey as that of plastic; where the diffuse colour is black, the material is
 * a mirror or metal, and the specular colour is taken as it is.
 * The exponent n is that of Blinn and Phong: n = 2 / alpha^2 - 2, alpha = roughness^2 (Karis, "Specular BRDF
 * Reference", 2013). */
static void material_classic(material_reader *reader, bool textured)
{
	float diffuse[3] = {0.6f, 0.6f, 0.6f}, specular[3] = {0}, exponent = 0.0f, strength = 1.0f;
	material_color(reader, AI_MATKEY_COLOR_DIFFUSE, diffuse);
	material_color(reader, AI_MATKEY_COLOR_SPECULAR, specular);
	material_number(reader, AI_MATKEY_SHININESS, &exponent);
	material_number(reader, AI_MATKEY_SHININESS_STRENGTH, &strength);
	float brightest = fmaxf(fmaxf(diffuse[0], diffuse[1]), diffuse[2]);
	bool black = brightest < 0.01f && !textured;
	if (brightest == 0.0f && textured) /* many exporters write black beside a texture */
		diffuse[0] = diffuse[1] = diffuse[2] = 1.0f;
	exponent = importer_clamp(exponent, 0.0f, 1e6f);
	strength = exponent > 0.0f ? importer_clamp(strength, 0.0f, 1.0f) : 0.0f;
	for (int i = 0; i < 3; i++)
		specular[i] = strength * fminf(specular[i], 1.0f) * (black ? 1.0f : 2.0f * IMPORTER_DIELECTRIC);
	material_reflect(reader, diffuse, specular, sqrtf(sqrtf(2.0f / (exponent + 2.0f))));
}

static void material_emission(material_reader *reader)
{
	float color[3] = {0}, intensity = 1.0f;
	if (!material_color(reader, AI_MATKEY_COLOR_EMISSIVE, color))
		return;
	material_number(reader, AI_MATKEY_EMISSIVE_INTENSITY, &intensity);
	for (int i = 0; i < 3; i++)
		reader->surface.emission[i] = importer_clamp(color[i] * intensity, 0.0f, 1e9f);
	if (fmaxf(fmaxf(color[0], color[1]), color[2]) > 0.0f)
		foreign_map(reader, STILB_SCENE_MAP_EMISSION, aiTextureType_EMISSION_COLOR, aiTextureType_EMISSIVE);
}

/* Opacity is that of all of the surface, or of the colour's picture if that is named as the picture of it, too. */
static void material_opacity(material_reader *reader)
{
	float opacity = 1.0f;
	struct aiString path, of_color;
	stilb_scene_surface *s = &reader->surface;
	material_number(reader, AI_MATKEY_OPACITY, &opacity);
	s->color[3] = importer_clamp(opacity, 0.0f, 1.0f);
	if (s->color[3] < 1.0f)
		s->alpha = STILB_SCENE_BLEND;
	if (s->color[3] == 0.0f)
		importer_lose(reader->import, IMPORTER_LOSS_UNSEEN, reader->name.data);
	if (aiGetMaterialTexture(reader->from, aiTextureType_OPACITY, 0, &path, NULL, NULL, NULL, NULL, NULL, NULL) ==
	    aiReturn_SUCCESS) {
		bool same = false;
		for (int i = 0; !same && i < 2; i++)
			same = aiGetMaterialTexture(reader->from, i == 0 ? aiTextureType_BASE_COLOR : aiTextureType_DIFFUSE, 0,
			                            &of_color, NULL, NULL, NULL, NULL, NULL, NULL) == aiReturn_SUCCESS &&
			       strcmp(path.data, of_color.data) == 0;
		if (same && s->alpha == STILB_SCENE_OPAQUE)
			s->alpha = STILB_SCENE_MASK;
		if (!same)
			importer_lose(reader->import, IMPORTER_LOSS_CUTOUTS, reader->name.data);
	}
	reader->needs_surface |= s->alpha != STILB_SCENE_OPAQUE;
}

static float material_share(const material_reader *reader, const char *key, unsigned type, unsigned index)
{
	float share = 0.0f;
	material_number(reader, key, type, index, &share);
	return importer_clamp(share, 0.0f, 1.0f);
}

/* Factors of layers, as OBJ's materials have them (Pc, Pcr, Ps). */
static void material_layers(material_reader *reader)
{
	stilb_scene_surface *s = &reader->surface;
	float sheen[3] = {0};
	s->clearcoat = material_share(reader, AI_MATKEY_CLEARCOAT_FACTOR);
	s->clearcoat_roughness = material_share(reader, AI_MATKEY_CLEARCOAT_ROUGHNESS_FACTOR);
	s->sheen_roughness = material_share(reader, AI_MATKEY_SHEEN_ROUGHNESS_FACTOR);
	s->transmission = material_share(reader, AI_MATKEY_TRANSMISSION_FACTOR);
	material_color(reader, AI_MATKEY_SHEEN_COLOR_FACTOR, sheen);
	for (int i = 0; i < 3; i++)
		s->sheen_color[i] = fminf(sheen[i], 1.0f);
	reader->needs_surface |= importer_has_layers(s);
}

/* ---- losses ------------------------------------------------------------------------------------------------------ */

static bool material_has(const material_reader *reader, enum aiTextureType kind)
{
	return aiGetMaterialTextureCount(reader->from, kind) > 0;
}

/* Counts what of the material is not shown. */
static void foreign_lose(const material_reader *reader)
{
	importer *import = reader->import;
	const char *name = reader->name.data;
	float factor = 0.0f, mirrored[3] = {0};
	if (material_has(reader, aiTextureType_REFLECTION) ||
	    (material_number(reader, AI_MATKEY_REFLECTIVITY, &factor) && factor > 0.0f &&
	     material_color(reader, AI_MATKEY_COLOR_REFLECTIVE, mirrored) &&
	     mirrored[0] + mirrored[1] + mirrored[2] > 0.0f))
		importer_lose(import, IMPORTER_LOSS_MIRRORS, name);
	if (aiGetMaterialTextureCount(reader->from, aiTextureType_DIFFUSE) > 1)
		importer_lose(import, IMPORTER_LOSS_LAYERS, name);
	if (material_number(reader, AI_MATKEY_ENABLE_WIREFRAME, &factor) && factor > 0.0f)
		importer_lose(import, IMPORTER_LOSS_WIRES, name);
	if (material_has(reader, aiTextureType_HEIGHT) || material_has(reader, aiTextureType_NORMAL_CAMERA))
		importer_lose(import, IMPORTER_LOSS_NORMAL_MAPS, name);
	if (material_has(reader, aiTextureType_SPECULAR) || material_has(reader, aiTextureType_SHININESS))
		importer_lose(import, IMPORTER_LOSS_SPECULAR_MAPS, name);
	if (material_has(reader, aiTextureType_AMBIENT_OCCLUSION) || material_has(reader, aiTextureType_LIGHTMAP))
		importer_lose(import, IMPORTER_LOSS_OCCLUSION_MAPS, name);
}

/* ---- all --------------------------------------------------------------------------------------------------------- */

/* Reads a material, and its surface into reader->surface. */
static void material_convert(material_reader *reader, stilb_scene_material *material)
{
	float metal, gloss;
	STILB_ASSERT(reader->from);
	if (aiGetMaterialString(reader->from, AI_MATKEY_NAME, &reader->name) != aiReturn_SUCCESS)
		strcpy(reader->name.data, "without a name");
	reader->surface = stilb_scene_surface_make();
	const importer_texture *base =
		foreign_map(reader, STILB_SCENE_MAP_COLOR, aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE);
	if (material_number(reader, AI_MATKEY_GLOSSINESS_FACTOR, &gloss))
		material_glossy(reader, gloss);
	else if (material_number(reader, AI_MATKEY_METALLIC_FACTOR, &metal))
		material_metallic(reader);
	else
		material_classic(reader, base);
	if (reader->missing_texture && !base)
		importer_magenta(&reader->surface);
	foreign_map(reader, STILB_SCENE_MAP_NORMAL, aiTextureType_NORMALS, aiTextureType_NORMALS);
	material_opacity(reader);
	material_emission(reader);
	material_layers(reader);
	importer_constants(reader->import, &reader->surface, material);
	foreign_lose(reader);
}

bool importer_material_has_normals(const struct aiMaterial *material)
{
	return aiGetMaterialTextureCount(material, aiTextureType_NORMALS) > 0;
}

/* Reads material m, and adds its surface if it needs one, for which there is room. */
static void material_add(importer *import, uint32_t m)
{
	stilb_scene *scene = import->scene;
	material_reader reader = {.import = import, .from = import->from->mMaterials[m]};
	material_convert(&reader, &scene->materials[m]);
	if (reader.needs_surface || import->colored[m]) {
		scene->surfaces[scene->surface_count++] = reader.surface;
		scene->materials[m].surface = scene->surface_count;
	}
	if (scene->names.materials)
		snprintf(scene->names.materials[m], STILB_SCENE_NAME, "%.*s", STILB_SCENE_NAME - 1, reader.name.data);
}

stilb_result importer_add_materials(importer *import)
{
	stilb_scene *scene = import->scene;
	uint32_t count = import->from->mNumMaterials;
	STILB_ASSERT(scene->material_count == (count ? count : 1));
	stilb_result result = scene_add_surfaces(scene, scene->material_count);
	if (result != STILB_OK)
		return result;
	scene->surface_count = 0;
	scene->materials[0] = stilb_scene_material_make((float[3]){0.6f, 0.6f, 0.6f}, (float[3]){0}, 1.0f);
	if (count == 0 && import->colored[0]) {
		scene->surfaces[scene->surface_count++] = stilb_scene_surface_make();
		scene->materials[0].surface = 1;
	}
	for (uint32_t m = 0; m < count; m++)
		material_add(import, m);
	return importer_take_textures(import);
}
