/* KHR_materials_variants: further materials for the parts of a scene. */
#include "scene/importer/gltf/gltf.h"

#include "scene/edit/scene_variant.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The mappings of a primitive: each has a material and the variants that show it. */
static uint32_t variant_mappings(gltf *from, uint32_t primitive)
{
	return scene_json_array(&from->json, gltf_extension(from, primitive, "KHR_materials_variants"), "mappings");
}

gltf_sets gltf_variant_sets(gltf *from, uint32_t primitive, uint32_t material, const char *name)
{
	scene_json *json = &from->json;
	uint32_t mappings = variant_mappings(from, primitive);
	gltf_sets all = gltf_material_sets(from, material);
	bool agree = true;
	for (uint32_t at = scene_json_first(json, mappings); at != GLTF_NONE; at = scene_json_after(json, mappings, at)) {
		gltf_sets other = gltf_material_sets(from, gltf_reference(from, at, "material", GLTF_MATERIALS));
		if (other.normals && !all.normals)
			all.normal = other.normal;
		all.normals |= other.normals;
		if (!other.any)
			continue;
		if (!all.any)
			all.set[0] = other.set[0];
		all.any = true;
		if (!all.second)
			all.set[1] = other.set[1];
		agree &= all.set[0] == other.set[0] && (!other.second || all.set[1] == other.set[1]);
		all.second |= other.second;
	}
	if (!agree)
		importer_lose(from->import, IMPORTER_LOSS_VARIANT_MAPPINGS, name);
	return all;
}

void gltf_show_materials(gltf *from, uint32_t primitive, uint32_t material, uint8_t how)
{
	scene_json *json = &from->json;
	uint32_t mappings = variant_mappings(from, primitive);
	from->shown[material] |= how;
	for (uint32_t at = scene_json_first(json, mappings); at != GLTF_NONE; at = scene_json_after(json, mappings, at)) {
		uint32_t other = gltf_reference(from, at, "material", GLTF_MATERIALS);
		if (other != GLTF_NONE)
			from->shown[other] |= how;
	}
}

/* Writes to row[variant * parts + part] what the variants of one of gltf's parts show. */
static void variant_read_part(gltf *from, uint32_t part, uint32_t *row)
{
	scene_json *json = &from->json;
	uint32_t count = from->lists[GLTF_VARIANTS].count, parts = from->parts.count;
	uint32_t mappings = variant_mappings(from, from->parts.parts[part].item);
	for (uint32_t v = 0; v < count; v++)
		row[(size_t)v * parts + part] = from->parts.parts[part].material;
	for (uint32_t at = scene_json_first(json, mappings); at != GLTF_NONE; at = scene_json_after(json, mappings, at)) {
		uint32_t material = gltf_reference(from, at, "material", GLTF_MATERIALS);
		uint32_t names = scene_json_array(json, at, "variants");
		for (uint32_t n = scene_json_first(json, names); n != GLTF_NONE; n = scene_json_after(json, names, n)) {
			uint64_t v = scene_json_whole(json, n);
			if (v >= count)
				scene_json_blame(json, n, "it names variant %llu, but there are %u", (unsigned long long)v, count);
			if (json->fault[0])
				return;
			if (material != GLTF_NONE)
				row[(size_t)v * parts + part] = material;
		}
	}
}

stilb_result gltf_add_variants(gltf *from)
{
	stilb_scene *scene = from->import->scene;
	uint32_t count = from->lists[GLTF_VARIANTS].count, parts = from->parts.count;
	STILB_ASSERT(scene && parts == scene->mesh_count);
	if (count == 0)
		return STILB_OK;
	if (count > STILB_SCENE_MAX_VARIANTS || (uint64_t)count * scene->part_count > STILB_SCENE_MAX_MODELS * 16ull)
		return stilb_fail(STILB_ERROR_FILE, "it has %u variants of %u parts, which are too many", count,
		                  scene->part_count);
	uint32_t *row = malloc(((size_t)count * parts + 1) * sizeof *row);
	stilb_result result =
		row ? scene_add_variants(scene, count) : stilb_fail(STILB_ERROR_MEMORY, "no memory for its %u variants", count);
	for (uint32_t p = 0; result == STILB_OK && p < parts; p++)
		variant_read_part(from, p, row);
	if (result == STILB_OK)
		result = scene_json_check(&from->json);
	for (uint32_t v = 0; result == STILB_OK && v <= count; v++) {
		uint32_t *to = scene->variants->materials + (size_t)v * scene->part_count;
		char name[96];
		for (uint32_t p = 0; p < scene->part_count; p++)
			to[p] = v == 0 ? scene->part_material[p] : row[(size_t)(v - 1) * parts + scene->part_mesh[p]];
		if (v == 0)
			continue;
		gltf_name(from, GLTF_VARIANTS, v - 1, name);
		snprintf(scene->variants->names[v - 1], sizeof *scene->variants->names, "%.63s", name);
	}
	free(row);
	return result;
}
