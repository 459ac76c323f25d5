/* Materials of glTF: metallic-roughness, or the extension specular-glossiness of older files. */
#include "scene/importer/gltf/gltf.h"

#include <math.h>
#include <string.h>

/* A material while it is read. */
typedef struct gltf_reader {
	gltf *from;
	uint32_t item;
	char name[96];
	bool missing_texture; /* that of its colour could not be loaded: it becomes magenta */
} gltf_reader;

/* The texture of an info; NULL: there is none, or it could not be loaded, which sets *missing. */
static const importer_texture *material_picture(gltf_reader *reader, uint32_t info, bool *missing)
{
	importer *import = reader->from->import;
	uint32_t picture = gltf_texture_picture(reader->from, info);
	if (picture == GLTF_NONE)
		return NULL;
	*missing |= !importer_texture_is_there(import, picture, reader->name);
	return import->textures[picture].image.pixels ? &import->textures[picture] : NULL;
}

/* Reads a colour, >= 0, if there is one. */
static void material_factor(gltf *from, uint32_t object, const char *key, float rgb[3], uint32_t count)
{
	float values[4];
	if (!gltf_json_numbers(&from->json, object, key, values, count))
		return;
	for (int i = 0; i < 3; i++)
		rgb[i] = importer_clamp(values[i], 0.0f, 1e9f);
}

/* The reflectance of the surface at normal incidence: KHR_materials_ior and KHR_materials_specular. */
static void material_dielectric(gltf_reader *reader, float reflectance[3])
{
	gltf *from = reader->from;
	gltf_json *json = &from->json;
	uint32_t specular = gltf_extension(from, reader->item, "KHR_materials_specular");
	uint32_t ior = gltf_extension(from, reader->item, "KHR_materials_ior");
	float index = (float)gltf_json_number(json, ior, "ior", 1.5), color[3] = {1, 1, 1};
	float strength = importer_clamp((float)gltf_json_number(json, specular, "specularFactor", 1.0), 0.0f, 1.0f);
	material_factor(from, specular, "specularColorFactor", color, 3);
	float root = index > 0.0f ? (index - 1.0f) / (index + 1.0f) : 1.0f; /* ior 0 stands for a mirror */
	float at_normal = ior == GLTF_NONE ? IMPORTER_DIELECTRIC : root * root;
	for (int i = 0; i < 3; i++)
		reflectance[i] = fminf(at_normal * color[i], 1.0f) * strength;
	if (gltf_json_member(json, specular, "specularTexture") != GLTF_NONE ||
	    gltf_json_member(json, specular, "specularColorTexture") != GLTF_NONE)
		importer_lose(from->import, IMPORTER_LOSS_SPECULAR_MAPS, reader->name);
}

static const importer_texture *material_metallic_roughness(gltf_reader *reader, stilb_scene_material *material)
{
	gltf *from = reader->from;
	gltf_json *json = &from->json;
	uint32_t pbr = gltf_json_member(json, reader->item, "pbrMetallicRoughness");
	importer_metallic read = {.color = {1, 1, 1}};
	bool missing_map = false;
	material_factor(from, pbr, "baseColorFactor", read.color, 4);
	read.metal = (float)gltf_json_number(json, pbr, "metallicFactor", 1.0);
	read.roughness = (float)gltf_json_number(json, pbr, "roughnessFactor", 1.0);
	read.base = material_picture(reader, gltf_json_member(json, pbr, "baseColorTexture"), &reader->missing_texture);
	read.map = material_picture(reader, gltf_json_member(json, pbr, "metallicRoughnessTexture"), &missing_map);
	material_dielectric(reader, read.dielectric);
	if (read.map)
		importer_lose(from->import, IMPORTER_LOSS_METAL_MAPS, reader->name);
	importer_material_metallic(&read, material);
	return read.base;
}

static const importer_texture *material_specular_glossiness(gltf_reader *reader, uint32_t gloss,
                                                            stilb_scene_material *material)
{
	gltf *from = reader->from;
	gltf_json *json = &from->json;
	bool missing_map = false;
	float diffuse[3] = {1, 1, 1}, specular[3] = {1, 1, 1};
	material_factor(from, gloss, "diffuseFactor", diffuse, 4);
	material_factor(from, gloss, "specularFactor", specular, 3);
	const importer_texture *map =
		material_picture(reader, gltf_json_member(json, gloss, "specularGlossinessTexture"), &missing_map);
	if (map)
		importer_lose(from->import, IMPORTER_LOSS_SPECULAR_MAPS, reader->name);
	for (int i = 0; i < 3; i++) {
		material->diffuse[i] = diffuse[i];
		material->specular[i] = specular[i] * (map ? map->mean[i] : 1.0f);
	}
	material->roughness = 1.0f - (float)gltf_json_number(json, gloss, "glossinessFactor", 1.0);
	return material_picture(reader, gltf_json_member(json, gloss, "diffuseTexture"), &reader->missing_texture);
}

/* Emitted radiance, constant over the surface: a texture counts by its mean. */
static void material_emit(gltf_reader *reader, stilb_scene_material *material)
{
	gltf *from = reader->from;
	gltf_json *json = &from->json;
	uint32_t extension = gltf_extension(from, reader->item, "KHR_materials_emissive_strength");
	float color[3] = {0}, strength = (float)gltf_json_number(json, extension, "emissiveStrength", 1.0);
	bool missing = false;
	material_factor(from, reader->item, "emissiveFactor", color, 3);
	if (fmaxf(fmaxf(color[0], color[1]), color[2]) <= 0.0f)
		return;
	const importer_texture *map =
		material_picture(reader, gltf_json_member(json, reader->item, "emissiveTexture"), &missing);
	if (map)
		importer_lose(from->import, IMPORTER_LOSS_EMISSION_MAPS, reader->name);
	for (int i = 0; i < 3; i++)
		material->emission[i] = importer_clamp(color[i] * strength * (map ? map->mean[i] : 1.0f), 0.0f, 1e9f);
}

/* Counts what of the material is not shown, besides its maps. */
static void material_lose_rest(gltf_reader *reader)
{
	gltf *from = reader->from;
	gltf_json *json = &from->json;
	importer *import = from->import;
	uint32_t alpha = gltf_json_member(json, reader->item, "alphaMode");
	if (gltf_json_is(json, alpha, "MASK"))
		importer_lose(import, IMPORTER_LOSS_CUTOUTS, reader->name);
	if (gltf_json_is(json, alpha, "BLEND"))
		importer_lose(import, IMPORTER_LOSS_BLENDING, reader->name);
	if (gltf_json_member(json, reader->item, "normalTexture") != GLTF_NONE)
		importer_lose(import, IMPORTER_LOSS_NORMAL_MAPS, reader->name);
	if (gltf_json_member(json, reader->item, "occlusionTexture") != GLTF_NONE)
		importer_lose(import, IMPORTER_LOSS_OCCLUSION_MAPS, reader->name);
}

/* The values of a sampler's wrapS, wrapT and magFilter. */
enum { GLTF_REPEAT = 10497, GLTF_NEAREST = 9728 };

/* Counts what of the sampler of a drawn texture is not shown. */
static void material_lose_sampler(gltf_reader *reader, uint32_t info)
{
	gltf *from = reader->from;
	gltf_json *json = &from->json;
	uint32_t texture = gltf_reference(from, info, "index", GLTF_TEXTURES);
	if (texture == GLTF_NONE)
		return;
	uint32_t sampler = gltf_reference(from, from->lists[GLTF_TEXTURES].items[texture], "sampler", GLTF_SAMPLERS);
	uint32_t item = sampler == GLTF_NONE ? GLTF_NONE : from->lists[GLTF_SAMPLERS].items[sampler];
	if (gltf_json_size(json, item, "wrapS", GLTF_REPEAT) != GLTF_REPEAT ||
	    gltf_json_size(json, item, "wrapT", GLTF_REPEAT) != GLTF_REPEAT)
		importer_lose(from->import, IMPORTER_LOSS_WRAPPING, reader->name);
	if (gltf_json_size(json, item, "magFilter", 0) == GLTF_NEAREST)
		importer_lose(from->import, IMPORTER_LOSS_NEAREST, reader->name);
}

static void material_read(gltf *from, uint32_t index, stilb_scene_material *material)
{
	gltf_reader reader = {.from = from, .item = from->lists[GLTF_MATERIALS].items[index]};
	gltf_json *json = &from->json;
	stilb_scene_material read = {0};
	uint32_t gloss = gltf_extension(from, reader.item, "KHR_materials_pbrSpecularGlossiness");
	uint32_t pbr = gltf_json_member(json, reader.item, "pbrMetallicRoughness");
	gltf_name(from, GLTF_MATERIALS, index, reader.name);
	const importer_texture *base = gloss == GLTF_NONE ? material_metallic_roughness(&reader, &read)
	                                                  : material_specular_glossiness(&reader, gloss, &read);
	*material = stilb_scene_material_make(read.diffuse, read.specular, read.roughness);
	material->diffuse_texture = base ? 1 + (uint32_t)(base - from->import->textures) : 0;
	if (reader.missing_texture && !base)
		*material = stilb_scene_material_make((float[3]){1, 0, 1}, (float[3]){0}, 1.0f);
	material_emit(&reader, material);
	material_lose_rest(&reader);
	if (base)
		material_lose_sampler(&reader, gloss == GLTF_NONE ? gltf_json_member(json, pbr, "baseColorTexture")
		                                                  : gltf_json_member(json, gloss, "diffuseTexture"));
}

stilb_result gltf_add_materials(gltf *from)
{
	stilb_scene *scene = from->import->scene;
	const gltf_list *materials = &from->lists[GLTF_MATERIALS];
	STILB_ASSERT(scene->material_count >= materials->count);
	for (uint32_t m = 0; m < materials->count; m++) {
		material_read(from, m, &scene->materials[m]);
		if (scene->names.materials)
			gltf_json_string(&from->json, materials->items[m], "name", scene->names.materials[m], STILB_SCENE_NAME);
	}
	/* The default material is white metal, glTF 2.0, 3.9.6: rough, without maps. */
	for (uint32_t m = materials->count; m < scene->material_count; m++) {
		importer_metallic plain = {.color = {1, 1, 1},
		                           .metal = 1.0f,
		                           .roughness = 1.0f,
		                           .dielectric = {IMPORTER_DIELECTRIC, IMPORTER_DIELECTRIC, IMPORTER_DIELECTRIC}};
		stilb_scene_material read = {0};
		importer_material_metallic(&plain, &read);
		scene->materials[m] = stilb_scene_material_make(read.diffuse, read.specular, read.roughness);
	}
	return importer_take_textures(from->import);
}
