/* Names what a glTF file has besides a scene at rest. */
#include "scene/importer/gltf/gltf.h"

#include <stdio.h>
#include <string.h>

/* The extensions that are read. */
static const char *const extensions_read[] = {
	"EXT_mesh_gpu_instancing",    "EXT_meshopt_compression",
	"EXT_texture_webp",           "KHR_draco_mesh_compression",
	"KHR_lights_punctual",        "KHR_materials_anisotropy",
	"KHR_materials_clearcoat",    "KHR_materials_emissive_strength",
	"KHR_materials_ior",          "KHR_materials_pbrSpecularGlossiness",
	"KHR_materials_sheen",        "KHR_materials_specular",
	"KHR_materials_transmission", "KHR_materials_unlit",
	"KHR_materials_variants",     "KHR_materials_volume",
	"KHR_mesh_quantization",      "KHR_meshopt_compression",
	"KHR_texture_basisu", /* each of its pictures is named where it is missed */
	"KHR_texture_transform",      "MSFT_texture_dds",
};

static bool extensions_are_read(const scene_json *json, uint32_t name)
{
	for (size_t i = 0; i < sizeof extensions_read / sizeof *extensions_read; i++)
		if (scene_json_is(json, name, extensions_read[i]))
			return true;
	return false;
}

/* Warns of the strings in an array that is_read does not know, NULL knows none: "<words>: a, b". key: of the string in
 * the array's objects; NULL: the values themselves. */
static void extensions_tell(gltf *from, uint32_t array, const char *key, bool (*is_read)(const scene_json *, uint32_t),
                            const char *words)
{
	scene_json *json = &from->json;
	char line[1024] = "";
	size_t size = 0;
	for (uint32_t at = scene_json_first(json, array); at != GLTF_NONE; at = scene_json_after(json, array, at)) {
		char name[96];
		if (is_read && is_read(json, at))
			continue;
		if (key)
			scene_json_string(json, at, key, name, sizeof name);
		else
			scene_json_copy(json, at, name, sizeof name);
		if (size + strlen(name) + 8 < sizeof line)
			size += (size_t)snprintf(line + size, sizeof line - size, "%s%s", size ? ", " : "", name);
	}
	if (size)
		importer_warn("%s: %s", words, line);
}

void gltf_tell_extensions(gltf *from)
{
	scene_json *json = &from->json;
	uint32_t used = scene_json_array(json, SCENE_JSON_ROOT, "extensionsUsed");
	uint32_t required = scene_json_array(json, SCENE_JSON_ROOT, "extensionsRequired");
	uint32_t variants = gltf_extension(from, SCENE_JSON_ROOT, "KHR_materials_variants");
	extensions_tell(from, required, NULL, extensions_are_read,
	                "it requires extensions that are not shown, so it looks other than it should");
	extensions_tell(from, used, NULL, extensions_are_read, "it uses extensions that are not shown");
	extensions_tell(from, scene_json_array(json, variants, "variants"), "name", NULL, "its materials have variants");
}
