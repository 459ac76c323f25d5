/* Converts materials, metallic-roughness, specular-glossiness or Phong's, to diffuse, specular and roughness. */
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

/* The texture of the first of two kinds that the material has and that could be loaded; NULL: none. */
static const importer_texture *material_texture(material_reader *reader, enum aiTextureType first,
                                                enum aiTextureType second)
{
	const enum aiTextureType kinds[2] = {first, second};
	struct aiString path;
	for (int i = 0; i < 2; i++) {
		if (aiGetMaterialTexture(reader->from, kinds[i], 0, &path, NULL, NULL, NULL, NULL, NULL, NULL) !=
		        aiReturn_SUCCESS ||
		    !importer_texture_is_named(&path))
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

/* Metals reflect their colour as specular and nothing as diffuse, non-metals their colour as diffuse and `dielectric`
 * as specular. A stilb_scene_material has one roughness for the whole surface, so a map of roughness and metalness
 * counts by its mean. Source: glTF 2.0, appendix B, simplified. */
void importer_material_metallic(const importer_metallic *from, stilb_scene_material *material)
{
	float metal = from->metal * (from->map ? from->map->stored_mean[2] : 1.0f);
	metal = importer_clamp(metal, 0.0f, 1.0f);
	for (int i = 0; i < 3; i++) {
		float mean = importer_clamp(from->color[i] * (from->base ? from->base->mean[i] : 1.0f), 0.0f, 1.0f);
		float dielectric = from->dielectric[i];
		float strongest = fmaxf(fmaxf(from->dielectric[0], from->dielectric[1]), from->dielectric[2]);
		material->diffuse[i] = from->color[i] * (1.0f - metal) * (1.0f - strongest);
		material->specular[i] = dielectric * (1.0f - metal) + mean * metal;
	}
	material->roughness = from->roughness * (from->map ? from->map->stored_mean[1] : 1.0f);
}

/* Reads a material of metalness and roughness. base: the colour's texture or NULL. */
static void material_metallic(material_reader *reader, const importer_texture *base, stilb_scene_material *material)
{
	importer_metallic read = {.color = {1, 1, 1},
	                          .metal = 1.0f,
	                          .roughness = 1.0f,
	                          .dielectric = {IMPORTER_DIELECTRIC, IMPORTER_DIELECTRIC, IMPORTER_DIELECTRIC},
	                          .base = base};
	if (!material_color(reader, AI_MATKEY_BASE_COLOR, read.color))
		material_color(reader, AI_MATKEY_COLOR_DIFFUSE, read.color);
	material_number(reader, AI_MATKEY_METALLIC_FACTOR, &read.metal);
	material_number(reader, AI_MATKEY_ROUGHNESS_FACTOR, &read.roughness);
	/* material_texture sets missing_texture, which makes the material magenta; for a missing map of roughness that is
	 * undone, since without it the material's colour is still right. */
	bool missing = reader->missing_texture;
	read.map = material_texture(reader, aiTextureType_UNKNOWN, aiTextureType_DIFFUSE_ROUGHNESS);
	reader->missing_texture = missing;
	if (read.map)
		importer_lose(reader->import, IMPORTER_LOSS_METAL_MAPS, reader->name.data);
	importer_material_metallic(&read, material);
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
	exponent = importer_clamp(exponent, 0.0f, 1e6f);
	strength = exponent > 0.0f ? importer_clamp(strength, 0.0f, 1.0f) : 0.0f;
	for (int i = 0; i < 3; i++) {
		material->diffuse[i] = diffuse[i];
		material->specular[i] = strength * fminf(specular[i], 1.0f) * (black ? 1.0f : 2.0f * IMPORTER_DIELECTRIC);
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
	if (map)
		importer_lose(reader->import, IMPORTER_LOSS_EMISSION_MAPS, reader->name.data);
	for (int i = 0; i < 3; i++)
		material->emission[i] = importer_clamp(color[i] * intensity * (map ? map->mean[i] : 1.0f), 0.0f, 1e9f);
}

/* ---- losses ------------------------------------------------------------------------------------------------------ */

static bool material_has(const material_reader *reader, enum aiTextureType kind)
{
	return aiGetMaterialTextureCount(reader->from, kind) > 0;
}

/* True if the texture of the colour is clamped or mirrored where it ends. */
static bool material_clamps(const material_reader *reader)
{
	static const enum aiTextureType kinds[2] = {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE};
	for (int i = 0; i < 2; i++) {
		float u = (float)aiTextureMapMode_Wrap, v = u;
		material_number(reader, AI_MATKEY_MAPPINGMODE_U(kinds[i], 0), &u);
		material_number(reader, AI_MATKEY_MAPPINGMODE_V(kinds[i], 0), &v);
		if (material_has(reader, kinds[i]) && (u != (float)aiTextureMapMode_Wrap || v != (float)aiTextureMapMode_Wrap))
			return true;
	}
	return false;
}

/* Counts what of the material is not shown. */
static void material_lose(const material_reader *reader)
{
	importer *import = reader->import;
	const char *name = reader->name.data;
	float opacity = 1.0f;
	if (material_number(reader, AI_MATKEY_OPACITY, &opacity) && opacity < 1.0f)
		importer_lose(import, IMPORTER_LOSS_BLENDING, name);
	if (material_has(reader, aiTextureType_OPACITY))
		importer_lose(import, IMPORTER_LOSS_CUTOUTS, name);
	float factor = 0.0f, mirrored[3] = {0}, seen[3] = {0};
	if ((material_number(reader, AI_MATKEY_CLEARCOAT_FACTOR, &factor) && factor > 0.0f) ||
	    (material_color(reader, AI_MATKEY_SHEEN_COLOR_FACTOR, seen) && seen[0] + seen[1] + seen[2] > 0.0f))
		importer_lose(import, IMPORTER_LOSS_COATS, name);
	if (material_number(reader, AI_MATKEY_TRANSMISSION_FACTOR, &factor) && factor > 0.0f)
		importer_lose(import, IMPORTER_LOSS_TRANSMISSION, name);
	factor = 0.0f;
	if (material_has(reader, aiTextureType_REFLECTION) ||
	    (material_number(reader, AI_MATKEY_REFLECTIVITY, &factor) && factor > 0.0f &&
	     material_color(reader, AI_MATKEY_COLOR_REFLECTIVE, mirrored) &&
	     mirrored[0] + mirrored[1] + mirrored[2] > 0.0f))
		importer_lose(import, IMPORTER_LOSS_MIRRORS, name);
	if (aiGetMaterialTextureCount(reader->from, aiTextureType_DIFFUSE) > 1)
		importer_lose(import, IMPORTER_LOSS_LAYERS, name);
	if (material_number(reader, AI_MATKEY_ENABLE_WIREFRAME, &factor) && factor > 0.0f)
		importer_lose(import, IMPORTER_LOSS_WIRES, name);
	if (material_clamps(reader))
		importer_lose(import, IMPORTER_LOSS_WRAPPING, name);
	if (material_has(reader, aiTextureType_NORMALS) || material_has(reader, aiTextureType_HEIGHT) ||
	    material_has(reader, aiTextureType_NORMAL_CAMERA))
		importer_lose(import, IMPORTER_LOSS_NORMAL_MAPS, name);
	if (material_has(reader, aiTextureType_SPECULAR) || material_has(reader, aiTextureType_SHININESS))
		importer_lose(import, IMPORTER_LOSS_SPECULAR_MAPS, name);
	if (material_has(reader, aiTextureType_AMBIENT_OCCLUSION) || material_has(reader, aiTextureType_LIGHTMAP))
		importer_lose(import, IMPORTER_LOSS_OCCLUSION_MAPS, name);
}

/* ---- all --------------------------------------------------------------------------------------------------------- */

static void material_convert(importer *import, const struct aiMaterial *from, stilb_scene_material *material)
{
	material_reader reader = {.import = import, .from = from};
	float metal, gloss;
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
	material_lose(&reader);
}

/* The textures that are not moved, such as maps of roughness, were needed for their means only. */
stilb_result importer_take_textures(importer *import)
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
	for (uint32_t m = 0; m < from->mNumMaterials; m++) {
		struct aiString name = {0};
		material_convert(import, from->mMaterials[m], &import->scene->materials[m]);
		if (import->scene->names.materials &&
		    aiGetMaterialString(from->mMaterials[m], AI_MATKEY_NAME, &name) == aiReturn_SUCCESS)
			snprintf(import->scene->names.materials[m], STILB_SCENE_NAME, "%.*s", STILB_SCENE_NAME - 1, name.data);
	}
	return importer_take_textures(import);
}
