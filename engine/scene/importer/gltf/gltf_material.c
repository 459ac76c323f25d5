/* Materials of glTF: metallic-roughness, or the extension specular-glossiness of older files. */
#include "scene/importer/gltf/gltf.h"

/* A material while it is read. */
typedef struct gltf_reader {
	gltf *from;
	uint32_t item; /* GLTF_NONE: the default one */
	char name[96];
	bool missing_color; /* the map of its colour could not be loaded: it becomes magenta */
	stilb_scene_surface surface;
} gltf_reader;

/* ---- maps -------------------------------------------------------------------------------------------------------- */

/* Reads a map, unless it lies on a third uv or its picture could not be loaded. */
static void material_map(gltf_reader *reader, const gltf_sets *sets, stilb_scene_map_kind kind)
{
	gltf *from = reader->from;
	importer *import = from->import;
	stilb_scene_map *map = &reader->surface.maps[kind];
	uint32_t info = gltf_map_info(from, reader->item, kind), picture = gltf_texture_picture(from, info);
	bool color = kind == STILB_SCENE_MAP_COLOR;
	if (picture == GLTF_NONE)
		return;
	if (!importer_texture_is_there(import, picture, reader->name, color)) {
		reader->missing_color |= color;
		return;
	}
	if (!gltf_map_read(from, info, sets, map)) {
		importer_lose(import, IMPORTER_LOSS_SETS, reader->name);
		return;
	}
	map->texture = importer_texture_number(picture, stilb_scene_map_is_color(kind, reader->surface.workflow));
}

/* ---- all --------------------------------------------------------------------------------------------------------- */

/* Reads material m of the scene, the default one behind those of the file, with its surface if it needs one. */
static void material_read(gltf *from, uint32_t m, stilb_scene_material *material, stilb_scene_surface *surface)
{
	const gltf_list *materials = &from->lists[GLTF_MATERIALS];
	gltf_reader reader = {.from = from, .item = m < materials->count ? materials->items[m] : GLTF_NONE};
	reader.surface = stilb_scene_surface_make();
	reader.surface.metalness = 1.0f; /* the default material is white metal, glTF 2.0, 3.9.6: rough, without maps */
	if (reader.item != GLTF_NONE) {
		gltf_sets sets = gltf_material_sets(from, m);
		gltf_name(from, GLTF_MATERIALS, m, reader.name);
		gltf_surface_factors(from, reader.item, &reader.surface);
		for (int kind = 0; kind < STILB_SCENE_MAPS; kind++)
			material_map(&reader, &sets, (stilb_scene_map_kind)kind);
	}
	if (reader.missing_color)
		importer_magenta(&reader.surface);
	importer_constants(from->import, &reader.surface, material);
	/* A mirror turns triangles over, and frames cull by material: every model with this one is seen from both sides. */
	if (from->shown[m] & GLTF_SHOWN_MIRRORED)
		reader.surface.one_sided = false;
	if (surface)
		*surface = reader.surface;
}

stilb_result gltf_add_materials(gltf *from)
{
	stilb_scene *scene = from->import->scene;
	const gltf_list *materials = &from->lists[GLTF_MATERIALS];
	STILB_ASSERT(scene->material_count >= materials->count);
	uint32_t surfaces = 0;
	for (uint32_t m = 0; m < scene->material_count; m++)
		surfaces += gltf_material_needs_surface(from, m);
	stilb_result result = scene_add_surfaces(scene, surfaces);
	surfaces = 0;
	for (uint32_t m = 0; result == STILB_OK && m < scene->material_count; m++) {
		bool needs = gltf_material_needs_surface(from, m);
		material_read(from, m, &scene->materials[m], needs ? &scene->surfaces[surfaces] : NULL);
		surfaces += needs;
		scene->materials[m].surface = needs ? surfaces : 0;
		if (m < materials->count && scene->names.materials)
			scene_json_string(&from->json, materials->items[m], "name", scene->names.materials[m], STILB_SCENE_NAME);
	}
	return result == STILB_OK ? importer_take_textures(from->import) : result;
}
