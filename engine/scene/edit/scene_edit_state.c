/* Arrays that grow, ids that are free, and lists of what has changed. Needs nothing of the rest of scene/. */
#include "scene/edit/scene_edit_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- arrays ------------------------------------------------------------------------------------------------------ */

#define EDIT_MOST_ARRAYS 20

bool scene_edit_grow(const edit_array *arrays, uint32_t array_count, uint32_t count, uint32_t needed,
                     uint32_t *capacity)
{
	void *grown[EDIT_MOST_ARRAYS];
	uint64_t larger = 2 * (uint64_t)*capacity;
	larger = larger < 16 ? 16 : larger;
	larger = larger < needed ? needed : larger;
	STILB_ASSERT(array_count <= EDIT_MOST_ARRAYS && count <= *capacity && needed > *capacity);
	bool enough = larger <= UINT32_MAX / 2;
	for (uint32_t i = 0; i < array_count; i++) {
		size_t room = larger + arrays[i].extra;
		grown[i] = enough ? stilb_memory_alloc(room, arrays[i].element) : NULL;
		enough = grown[i];
	}
	for (uint32_t i = 0; i < array_count; i++) {
		if (!enough) {
			free(grown[i]);
			continue;
		}
		size_t used = ((size_t)count + arrays[i].extra) * arrays[i].element;
		size_t bytes = ((size_t)larger + arrays[i].extra) * arrays[i].element;
		used = *arrays[i].at ? used : 0; /* there is no array yet: count is 0 */
		if (used > 0)
			memcpy(grown[i], *arrays[i].at, used);
		memset((char *)grown[i] + used, 0, bytes - used);
		free(*arrays[i].at);
		*arrays[i].at = grown[i];
	}
	if (enough)
		*capacity = (uint32_t)larger;
	return enough;
}

/* An array of zeros. Sets *failed if there is no memory for it. */
static void *edit_zeros(bool *failed, size_t count, size_t size)
{
	void *array = calloc(count + 1, size); /* never of size 0 */
	*failed |= !array;
	return array;
}

static void edit_ids_make(edit_ids *ids, const char *name, uint32_t count, bool *failed)
{
	*ids = (edit_ids){
		.name = name,
		.capacity = count,
		.next = edit_zeros(failed, count, sizeof *ids->next),
		.users = edit_zeros(failed, count, sizeof *ids->users),
		.changed = edit_zeros(failed, count, sizeof *ids->changed),
		.slot = edit_zeros(failed, count, sizeof *ids->slot),
	};
	for (uint32_t i = 0; i < count && ids->next; i++)
		ids->next[i] = EDIT_IN_USE;
}

static void edit_ids_finish(edit_ids *ids)
{
	free(ids->next);
	free(ids->users);
	free(ids->changed);
	free(ids->slot);
}

static void edit_nodes_make(edit_nodes *nodes, uint32_t count, bool *failed)
{
	*nodes = (edit_nodes){
		.capacity = count,
		.next = edit_zeros(failed, count, sizeof *nodes->next),
		.children = edit_zeros(failed, count, sizeof *nodes->children),
		.first_model = edit_zeros(failed, count, sizeof *nodes->first_model),
		.order = edit_zeros(failed, count, sizeof *nodes->order),
		.end = edit_zeros(failed, count, sizeof *nodes->end),
		.position = edit_zeros(failed, count, sizeof *nodes->position),
		.unordered = true,
		.first_child = edit_zeros(failed, count, sizeof *nodes->first_child),
		.sibling = edit_zeros(failed, count, sizeof *nodes->sibling),
		.changed = edit_zeros(failed, count, sizeof *nodes->changed),
		.slot = edit_zeros(failed, count, sizeof *nodes->slot),
		.marks = edit_zeros(failed, count, sizeof *nodes->marks),
		.figure = edit_zeros(failed, count, sizeof *nodes->figure),
	};
}

static void edit_nodes_finish(edit_nodes *nodes)
{
	void *arrays[] = {nodes->next,    nodes->children, nodes->first_model, nodes->order,
	                  nodes->end,     nodes->position, nodes->first_child, nodes->sibling,
	                  nodes->changed, nodes->slot,     nodes->marks,       nodes->figure};
	for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
		free(arrays[i]);
}

void scene_edit_finish(stilb_scene_edits *edits)
{
	if (!edits)
		return;
	edit_ids_finish(&edits->meshes);
	edit_ids_finish(&edits->materials);
	edit_ids_finish(&edits->surfaces);
	edit_ids_finish(&edits->textures);
	edit_ids_finish(&edits->functions);
	edit_nodes_finish(&edits->nodes);
	free(edits->mesh_sphere);
	free(edits->mesh_figure);
	free(edits->mesh_pose);
	free(edits->mesh_stale);
	free(edits->models);
	free(edits->ranges);
	free(edits);
}

/* ---- creation ---------------------------------------------------------------------------------------------------- */

static stilb_scene_edits *edit_make(const stilb_scene *scene)
{
	bool failed = false;
	stilb_scene_edits *edits = calloc(1, sizeof *edits);
	if (!edits)
		return NULL;
	edit_ids_make(&edits->meshes, "mesh", scene->mesh_count, &failed);
	edit_ids_make(&edits->materials, "material", scene->material_count, &failed);
	edit_ids_make(&edits->surfaces, "surface", scene->surface_count, &failed);
	edit_ids_make(&edits->textures, "texture", scene->texture_count, &failed);
	edit_ids_make(&edits->functions, "surface function", scene->function_count, &failed);
	edit_nodes_make(&edits->nodes, scene->nodes.count, &failed);
	edits->mesh_sphere = edit_zeros(&failed, scene->mesh_count, sizeof *edits->mesh_sphere);
	edits->mesh_figure = edit_zeros(&failed, scene->mesh_count, sizeof *edits->mesh_figure);
	edits->mesh_pose = edit_zeros(&failed, scene->mesh_count, sizeof *edits->mesh_pose);
	edits->mesh_stale = edit_zeros(&failed, scene->mesh_count, sizeof *edits->mesh_stale);
	edits->model_capacity = scene->model_count;
	edits->part_capacity = scene->part_count;
	edits->models = edit_zeros(&failed, scene->model_count, sizeof *edits->models);
	if (!failed)
		return edits;
	scene_edit_finish(edits);
	return NULL;
}

/* Which nodes and models hang on which node. */
static void edit_nodes_fill(const stilb_scene *scene, stilb_scene_edits *edits)
{
	edit_nodes *nodes = &edits->nodes;
	for (uint32_t n = 0; n < scene->nodes.count; n++) {
		nodes->next[n] = EDIT_IN_USE;
		if (scene->nodes.parent[n] != STILB_SCENE_NONE)
			nodes->children[scene->nodes.parent[n]]++;
	}
	for (uint32_t m = scene->model_count; m-- > 0;) {
		uint32_t node = scene->model_node[m];
		if (!node)
			continue;
		uint32_t *first = &nodes->first_model[node - 1];
		edits->models[m].next_on_node = *first;
		if (*first)
			edits->models[*first - 1].previous_on_node = m + 1;
		*first = m + 1;
	}
}

stilb_result scene_edit_begin(stilb_scene *scene)
{
	STILB_ASSERT(scene);
	if (scene->edits)
		return STILB_OK;
	stilb_scene_edits *edits = edit_make(scene);
	if (!edits)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory to edit a scene of %u models", scene->model_count);
	for (uint32_t p = 0; p < scene->part_count; p++) {
		edits->meshes.users[scene->part_mesh[p]]++;
		edits->materials.users[scene->part_material[p]]++;
	}
	for (uint32_t m = 0; m < scene->material_count; m++) {
		if (scene->materials[m].diffuse_texture)
			edits->textures.users[scene->materials[m].diffuse_texture - 1]++;
		if (scene->materials[m].surface)
			edits->surfaces.users[scene->materials[m].surface - 1]++;
	}
	for (uint32_t s = 0; s < scene->surface_count; s++) {
		for (int i = 0; i < STILB_SCENE_MAPS; i++)
			if (scene->surfaces[s].maps[i].texture)
				edits->textures.users[scene->surfaces[s].maps[i].texture - 1]++;
		if (scene->surfaces[s].function)
			edits->functions.users[scene->surfaces[s].function - 1]++;
	}
	for (uint32_t m = 0; m < scene->mesh_count; m++)
		edits->mesh_sphere[m].radius = (float)NAN;
	for (uint32_t m = 0; m < scene->model_count; m++)
		edits->models[m] = (edit_model){
			.radius = scene->bounds.radius[m], .next = EDIT_IN_USE, .hidden = isnan(scene->bounds.radius[m])};
	for (uint32_t i = 0; i < scene->moved_count; i++)
		edits->models[scene->moved[i]].slot = i;
	edits->unmeasured = true;
	edits->measures = 1;
	edit_nodes_fill(scene, edits);
	scene->edits = edits;
	return STILB_OK;
}

/* ---- lists ------------------------------------------------------------------------------------------------------- */

void scene_edit_changed(edit_ids *ids, uint32_t id)
{
	STILB_ASSERT(id < ids->capacity);
	uint32_t slot = ids->slot[id];
	if (slot < ids->changed_count && ids->changed[slot] == id)
		return;
	STILB_ASSERT(ids->changed_count < ids->capacity);
	ids->slot[id] = ids->changed_count;
	ids->changed[ids->changed_count++] = id;
}

bool scene_edit_has(const edit_ids *ids, uint32_t count, uint32_t id)
{
	return id < count && ids->next[id] == EDIT_IN_USE;
}

void stilb_scene_changes_clear(stilb_scene *scene)
{
	STILB_ASSERT(scene);
	scene->moved_count = 0;
	stilb_scene_edits *edits = scene->edits;
	if (!edits)
		return;
	edits->meshes.changed_count = edits->materials.changed_count = edits->textures.changed_count = 0;
	edits->surfaces.changed_count = edits->functions.changed_count = 0;
	edits->range_count = 0;
}
