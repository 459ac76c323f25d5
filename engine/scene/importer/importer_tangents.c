/* Tangents for maps of normals, where files have none. */
#include "scene/importer/importer.h"
#include "scene/tangents/scene_tangents.h"

#include <stdlib.h>
#include <string.h>

/* Where vertices lie on the map. */
static void tangents_places(const stilb_scene_mesh *mesh, const stilb_scene_map *map, float (*out)[2])
{
	for (uint32_t v = 0; v < mesh->vertex_count; v++) {
		const float *uv = map->set ? mesh->extras[v].uv : mesh->vertices[v].uv;
		out[v][0] = map->to_u[0] * uv[0] + map->to_u[1] * uv[1] + map->to_u[2];
		out[v][1] = map->to_v[0] * uv[0] + map->to_v[1] * uv[1] + map->to_v[2];
	}
}

/* Gives the mesh the vertices of a split. */
static stilb_result tangents_apply(const scene_tangents_split *split, stilb_scene_mesh *mesh)
{
	stilb_scene_mesh made;
	stilb_result result = scene_mesh_create(&made, split->vertex_count, mesh->index_count);
	if (result == STILB_OK)
		result = scene_mesh_add_extras(&made);
	if (result != STILB_OK) {
		stilb_scene_mesh_finish(&made);
		return result;
	}
	for (uint32_t v = 0; v < split->vertex_count; v++) {
		made.vertices[v] = mesh->vertices[split->sources[v]];
		made.extras[v] = mesh->extras[split->sources[v]];
		memcpy(made.extras[v].tangent, split->tangents[v], sizeof made.extras[v].tangent);
	}
	memcpy(made.indices, split->indices, mesh->index_count * sizeof *made.indices);
	stilb_scene_mesh_finish(mesh);
	*mesh = made;
	return STILB_OK;
}

stilb_result importer_make_tangents(stilb_scene_mesh *mesh, const stilb_scene_map *map, uint32_t **sources)
{
	STILB_ASSERT(mesh->extras && mesh->level_count == 0);
	float(*places)[2] = malloc((mesh->vertex_count + 1ull) * sizeof *places);
	float(*tangents)[4] = malloc((mesh->index_count + 1ull) * sizeof *tangents);
	scene_tangents_split split = {0};
	stilb_result result = STILB_OK;
	if (!places || !tangents)
		result = stilb_fail(STILB_ERROR_MEMORY, "no memory for tangents of %u vertices", mesh->vertex_count);
	if (result == STILB_OK) {
		tangents_places(mesh, map, places);
		scene_tangents_mesh from = {.positions = mesh->vertices->position,
		                            .normals = mesh->vertices->normal,
		                            .uvs = places[0],
		                            .position_stride = sizeof *mesh->vertices,
		                            .normal_stride = sizeof *mesh->vertices,
		                            .uv_stride = sizeof *places,
		                            .indices = mesh->indices,
		                            .vertex_count = mesh->vertex_count,
		                            .index_count = mesh->index_count};
		result = scene_tangents_make(&from, tangents);
		if (result == STILB_OK)
			result = scene_tangents_split_make(&from, (const float(*)[4])tangents, &split);
	}
	if (result == STILB_OK)
		result = tangents_apply(&split, mesh);
	if (result == STILB_OK && sources) {
		*sources = split.sources;
		split.sources = NULL;
	}
	scene_tangents_split_finish(&split);
	free(places);
	free(tangents);
	return result;
}
