/* Converts materials, metallic-roughness, specular-glossiness or Phong's, to diffuse, specular and roughness. */
#include "scene/importer/importer.h"

#include <assimp/GltfMaterial.h>
#include <assimp/material.h>
#include <math.h>
#include <string.h>

#define DIELECTRIC 0.04f /* reflectance of glass and plastic at normal incidence; glTF uses it for all non-metals */

/* One of Assimp's materials while it is read. */
typedef struct material_reader {
	importer *import;
	const struct aiMaterial *from;
	struct aiString name;
	bool missing_texture; /* a texture of its colour could not be loaded: the material becomes magenta */
} material_reader;

static float material_clamp(float value, float low, float high)
{
	STILB_ASSERT(low < high);
	return !(value > low) ? low : value < high ? value : high; /* NaN becomes low */
}

/* Reads a colour, >= 0; false: the material has none of this key. */
static bool material_color(const material_reader *reader, const char *key, unsigned type, unsigned index, float rgb[3])
{
	struct aiColor4D color;
	if (aiGetMaterialColor(reader->from, key, type, index, &color) != aiReturn_SUCCESS)
		return false;
	rgb[0] = material_clamp(color.r, 0.0f, 1e9f);
	rgb[1] = material_clamp(color.g, 0.0f, 1e9f);
	rgb[2] = material_clamp(color.b, 0.0f, 1e9f);
	return true;
}

/* Reads a number; false: the material has none of this key. */
static bool material_number(const material_reader *reader, const char *key, unsigned type, unsigned index, float *out)
{
	ai_real value;
	unsigned count = 1;
	if (aiGetMaterialFloatArray(reader->from, key, type, index, &value, &count) != aiReturn_SUCCESS || count < 1)
		return false;
	*out = material_clamp(value, -1e9f, 1e9f);
	return true;
}

/* The texture of the first of two kinds that the material has and that could be loaded; NULL: none. */
static const importer_texture *material_texture(material_reader *reader, enum aiTextureType first,
                                                enum aiTextureType second)
{
	const enum aiTextureType kinds[2] = {first, second};
	struct aiString path;
	for (int i = 0; i < 2; i++) {
		if (aiGetMaterialTexture(reader->from, kinds[i], 0, &path, NULL, NULL, NULL, NULL, NULL, NULL) !=
		        aiReturn_SUCCESS ||
		    path.data[0] == '\0')
			continue;
		uint32_t texture = importer_texture_of(reader->import, path.data, reader->name.data);
		reader->missing_texture |= texture == UINT32_MAX;
		STILB_ASSERT(texture == UINT32_MAX || texture < reader->import->texture_count);
		if (texture != UINT32_MAX)
			return &reader->import->textures[texture];
	}
	return NULL;
}

/* ---- kinds ------------------------------------------------------------------------------------------------------- */

/* Converts a material of metalness and roughness. Metals reflect their colour as specular and nothing as diffuse,
 * non-metals their colour as diffuse and DIELECTRIC as specular. A stilb_scene_material has one roughness for the whole
 * surface, so a map of roughness and metalness counts by its mean. base: the colour's texture or NULL. Source: glTF
 * 2.0, appendix B, simplified. */
static void material_metallic(material_reader *reader, const importer_texture *base, stilb_scene_material *material)
{
	float color[3] = {1, 1, 1}, metal = 1.0f, roughness = 1.0f, mean[3];
	if (!material_color(reader, AI_MATKEY_BASE_COLOR, color))
		material_color(reader, AI_MATKEY_COLOR_DIFFUSE, color);
	material_number(reader, AI_MATKEY_METALLIC_FACTOR, &metal);
	material_number(reader, AI_MATKEY_ROUGHNESS_FACTOR, &roughness);
	/* material_texture sets missing_texture, which makes the material magenta; for a missing map of roughness that is
	 * undone, since without it the material's colour is still right. */
	bool missing = reader->missing_texture;
	const importer_texture *map = material_texture(reader, aiTextureType_UNKNOWN, aiTextureType_DIFFUSE_ROUGHNESS);
	reader->missing_texture = missing;
	if (map) { /* green is roughness, blue metalness */
		roughness *= map->stored_mean[1];
		metal *= map->stored_mean[2];
	}
	metal = material_clamp(metal, 0.0f, 1.0f);
	for (int i = 0; i < 3; i++) {
		mean[i] = material_clamp(color[i] * (base ? base->mean[i] : 1.0f), 0.0f, 1.0f);
		material->diffuse[i] = color[i] * (1.0f - metal) * (1.0f - DIELECTRIC);
		material->specular[i] = DIELECTRIC * (1.0f - metal) + mean[i] * metal;
	}
	material->roughness = roughness;
}

static void material_glossy(const material_reader *reader, float gloss, stilb_scene_material *material)
{
	float diffuse[3] = {1, 1, 1}, specular[3] = {1, 1, 1};
	material_color(reader, AI_MATKEY_COLOR_DIFFUSE, diffuse);
	material_color(reader, AI_MATKEY_COLOR_SPECULAR, specular);
	for (int i = 0; i < 3; i++) {
		material->diffuse[i] = diffuse[i];
		material->specular[i] = specular[i];
	}
	material->roughness = 1.0f - gloss;
}

/* Converts a Phong material, whose specular colour was chosen by eye and conserves no energy. A heuristic: white counts
 * as twice the reflectance of plastic, mid grey as that of plastic; where the diffuse colour is black, the material is
 * a mirror or metal, and the specular colour is taken as it is.
 * The exponent n is that of Blinn and Phong: n = 2 / alpha^2 - 2, alpha = roughness^2 (Karis, "Specular BRDF
 * Reference", 2013). */
static void material_classic(const material_reader *reader, bool textured, stilb_scene_material *material)
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
	exponent = material_clamp(exponent, 0.0f, 1e6f);
	strength = exponent > 0.0f ? material_clamp(strength, 0.0f, 1.0f) : 0.0f;
	for (int i = 0; i < 3; i++) {
		material->diffuse[i] = diffuse[i];
		material->specular[i] = strength * fminf(specular[i], 1.0f) * (black ? 1.0f : 2.0f * DIELECTRIC);
	}
	material->roughness = sqrtf(sqrtf(2.0f / (exponent + 2.0f)));
}

/* Emitted radiance, constant over the surface: a texture counts by its mean. */
static void material_emission(material_reader *reader, stilb_scene_material *material)
{
	float color[3] = {0}, intensity = 1.0f;
	if (!material_color(reader, AI_MATKEY_COLOR_EMISSIVE, color))
		return;
	material_number(reader, AI_MATKEY_EMISSIVE_INTENSITY, &intensity);
	bool missing = reader->missing_texture;
	const importer_texture *map = fmaxf(fmaxf(color[0], color[1]), color[2]) > 0.0f
	                                  ? material_texture(reader, aiTextureType_EMISSION_COLOR, aiTextureType_EMISSIVE)
	                                  : NULL;
	reader->missing_texture = missing;
	for (int i = 0; i < 3; i++)
		material->emission[i] = material_clamp(color[i] * intensity * (map ? map->mean[i] : 1.0f), 0.0f, 1e9f);
}

/* ---- all --------------------------------------------------------------------------------------------------------- */

static void material_convert(importer *import, const struct aiMaterial *from, stilb_scene_material *material)
{
	material_reader reader = {.import = import, .from = from};
	float opacity = 1.0f, metal, gloss;
	stilb_scene_material read = {0};
	STILB_ASSERT(from);
	if (aiGetMaterialString(from, AI_MATKEY_NAME, &reader.name) != aiReturn_SUCCESS)
		strcpy(reader.name.data, "without a name");
	const importer_texture *base = material_texture(&reader, aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE);
	uint32_t texture = base ? 1 + (uint32_t)(base - import->textures) : 0;
	if (material_number(&reader, AI_MATKEY_GLOSSINESS_FACTOR, &gloss))
		material_glossy(&reader, gloss, &read);
	else if (material_number(&reader, AI_MATKEY_METALLIC_FACTOR, &metal))
		material_metallic(&reader, base, &read);
	else
		material_classic(&reader, texture > 0, &read);
	*material = stilb_scene_material_make(read.diffuse, read.specular, read.roughness);
	material->diffuse_texture = texture;
	if (reader.missing_texture && !texture)
		*material = stilb_scene_material_make((float[3]){1, 0, 1}, (float[3]){0}, 1.0f);
	material_emission(&reader, material);
	if (material_number(&reader, AI_MATKEY_OPACITY, &opacity))
		import->transparent_materials += opacity < 1.0f;
}

/* Moves the textures that the converted materials refer to into the scene and renumbers them. The others, such as maps
 * of roughness, were needed for their means only. */
static stilb_result material_take_textures(importer *import)
{
	stilb_scene *scene = import->scene;
	uint32_t used = 0;
	stilb_result result = scene_add_textures(scene, import->texture_count);
	for (uint32_t t = 0; result == STILB_OK && t < import->texture_count; t++) {
		uint32_t first = used;
		for (uint32_t m = 0; m < scene->material_count; m++)
			if (scene->materials[m].diffuse_texture == 1 + t) {
				scene->materials[m].diffuse_texture = 1 + first; /* <= 1 + t, so no later t matches it */
				used = first + 1;
			}
		STILB_ASSERT(used <= t + 1);
		if (used > first) {
			scene->textures[first] = import->textures[t].image;
			import->textures[t].image = (stilb_image){0};
		}
	}
	scene->texture_count = used;
	return result;
}

stilb_result importer_add_materials(importer *import)
{
	const struct aiScene *from = import->from;
	STILB_ASSERT(import->scene->material_count == (from->mNumMaterials ? from->mNumMaterials : 1));
	import->scene->materials[0] = stilb_scene_material_make((float[3]){0.6f, 0.6f, 0.6f}, (float[3]){0}, 1.0f);
	for (uint32_t m = 0; m < from->mNumMaterials; m++)
		material_convert(import, from->mMaterials[m], &import->scene->materials[m]);
	if (import->transparent_materials)
		importer_warn("%u of its materials are transparent: they are shown opaque", import->transparent_materials);
	return material_take_textures(import);
}
