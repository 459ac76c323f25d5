/* Meshes, materials, textures and lights that come, change and go. */
#include "scene/edit/scene_check.h"
#include "scene/edit/scene_edit_internal.h"
#include "scene/play/scene_play_internal.h"
#include "scene/scene_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- ids --------------------------------------------------------------------------------------------------------- */

#define EDIT_IDS_ARRAYS 4

/* The arrays that every kind has. */
static void edit_ids_arrays(edit_ids *ids, edit_array arrays[EDIT_IDS_ARRAYS])
{
	uint32_t **each[EDIT_IDS_ARRAYS] = {&ids->next, &ids->users, &ids->changed, &ids->slot};
	for (int i = 0; i < EDIT_IDS_ARRAYS; i++)
		arrays[i] = (edit_array){(void **)each[i], sizeof(uint32_t), 0};
}

/* Makes room for another id. arrays: [EDIT_IDS_ARRAYS + own_count], the last ones the kind's own. */
static stilb_result edit_reserve(edit_ids *ids, edit_array *arrays, uint32_t own_count, uint32_t count)
{
	if (ids->first_free || count < ids->capacity)
		return STILB_OK;
	edit_ids_arrays(ids, arrays);
	if (count < UINT32_MAX && scene_edit_grow(arrays, EDIT_IDS_ARRAYS + own_count, count, count + 1, &ids->capacity))
		return STILB_OK;
	return stilb_fail(STILB_ERROR_MEMORY, "no memory for another %s", ids->name);
}

/* The id that edit_take will give. */
static uint32_t edit_next(const edit_ids *ids, uint32_t count)
{
	return ids->first_free ? ids->first_free - 1 : count;
}

/* Gives out an id, for which there is room. */
static uint32_t edit_take(edit_ids *ids, uint32_t *count)
{
	uint32_t id = edit_next(ids, *count);
	STILB_ASSERT(id < ids->capacity);
	if (ids->first_free)
		ids->first_free = ids->next[id];
	else
		(*count)++;
	ids->next[id] = EDIT_IN_USE;
	ids->users[id] = 0;
	scene_edit_changed(ids, id);
	return id;
}

static stilb_result edit_find(const edit_ids *ids, uint32_t count, uint32_t id)
{
	if (!scene_edit_has(ids, count, id))
		return stilb_fail(STILB_ERROR_ARGUMENT, "there is no %s %u", ids->name, id);
	return STILB_OK;
}

/* Takes an id back. STILB_ERROR_ARGUMENT: there is no such thing, or something names it. */
static stilb_result edit_give_back(edit_ids *ids, uint32_t count, uint32_t id, const char *user)
{
	stilb_result result = edit_find(ids, count, id);
	if (result != STILB_OK)
		return result;
	if (ids->users[id] > 0)
		return stilb_fail(STILB_ERROR_ARGUMENT, "%s %u is in use by %u %s%s; remove these first", ids->name, id,
		                  ids->users[id], user, ids->users[id] == 1 ? "" : "s");
	ids->next[id] = ids->first_free;
	ids->first_free = id + 1;
	scene_edit_changed(ids, id);
	return STILB_OK;
}

/* ---- meshes ------------------------------------------------------------------------------------------------------ */

static stilb_result edit_reserve_mesh(stilb_scene *scene)
{
	stilb_scene_edits *edits = scene->edits;
	edit_array arrays[EDIT_IDS_ARRAYS + 5] = {
		[EDIT_IDS_ARRAYS] = {(void **)&scene->meshes, sizeof *scene->meshes, 0},
		[EDIT_IDS_ARRAYS + 1] = {(void **)&edits->mesh_sphere, sizeof *edits->mesh_sphere, 0},
		[EDIT_IDS_ARRAYS + 2] = {(void **)&edits->mesh_stale, sizeof *edits->mesh_stale, 0},
		[EDIT_IDS_ARRAYS + 3] = {(void **)&edits->mesh_figure, sizeof *edits->mesh_figure, 0},
		[EDIT_IDS_ARRAYS + 4] = {(void **)&edits->mesh_pose, sizeof *edits->mesh_pose, 0}};
	return edit_reserve(&edits->meshes, arrays, 5, scene->mesh_count);
}

/* Lists a mesh as wholly changed, which its ranges no longer say anything about. */
static void edit_mesh_changed(stilb_scene_edits *edits, uint32_t id)
{
	uint32_t kept = 0;
	for (uint32_t r = 0; r < edits->range_count; r++)
		if (edits->ranges[r].mesh != id)
			edits->ranges[kept++] = edits->ranges[r];
	edits->range_count = kept;
	scene_edit_changed(&edits->meshes, id);
}

/* The vertices are others: the sphere around them, and the bounds of models that show them, are no longer right. */
static void edit_mesh_stale(stilb_scene_edits *edits, uint32_t id)
{
	edits->mesh_sphere[id].radius = (float)NAN;
	edits->unmeasured = true;
	edits->measures++;
	edits->stale_count += !edits->mesh_stale[id];
	edits->mesh_stale[id] = true;
}

stilb_result stilb_scene_add_mesh(stilb_scene *scene, const stilb_scene_mesh *mesh, uint32_t *id)
{
	STILB_ASSERT(mesh && id);
	stilb_scene_mesh copy, own = *mesh; /* it may be one of the scene's, whose array moves */
	stilb_result result = scene_edit_begin(scene);
	if (result == STILB_OK)
		result = scene_check_mesh(&own, edit_next(&scene->edits->meshes, scene->mesh_count));
	if (result == STILB_OK)
		result = edit_reserve_mesh(scene);
	if (result == STILB_OK)
		result = scene_copy_mesh(&own, &copy);
	if (result != STILB_OK)
		return result;
	*id = edit_take(&scene->edits->meshes, &scene->mesh_count);
	scene->revisions.geometry++;
	scene->meshes[*id] = copy;
	scene->edits->mesh_sphere[*id].radius = (float)NAN;
	scene->edits->mesh_figure[*id] = 0;
	scene->edits->mesh_pose[*id] = 0;
	scene->edits->unmeasured = true;
	return STILB_OK;
}

/* A mesh that was a figure's is the program's now. */
static void edit_mesh_take(stilb_scene *scene, uint32_t id)
{
	uint32_t *figure = &scene->edits->mesh_figure[id];
	if (*figure)
		scene_play_forget_mesh(scene, *figure, id);
	*figure = 0;
}

stilb_result stilb_scene_set_mesh(stilb_scene *scene, uint32_t id, const stilb_scene_mesh *mesh)
{
	STILB_ASSERT(mesh);
	stilb_scene_mesh copy;
	stilb_result result = scene_edit_begin(scene);
	if (result == STILB_OK)
		result = edit_find(&scene->edits->meshes, scene->mesh_count, id);
	if (result == STILB_OK)
		result = scene_check_mesh(mesh, id);
	if (result == STILB_OK)
		result = scene_copy_mesh(mesh, &copy);
	if (result != STILB_OK)
		return result;
	edit_mesh_take(scene, id);
	stilb_scene_mesh_finish(&scene->meshes[id]);
	scene->meshes[id] = copy;
	edit_mesh_changed(scene->edits, id);
	edit_mesh_stale(scene->edits, id);
	scene->revisions.geometry++;
	return STILB_OK;
}

/* Makes room in the list of ranges. False: it is full, or there is no memory. */
static bool edit_reserve_range(stilb_scene_edits *edits)
{
	edit_array ranges = {(void **)&edits->ranges, sizeof *edits->ranges, 0};
	uint32_t count = edits->range_count;
	return count < edits->range_capacity ||
	       (count < EDIT_MOST_RANGES && scene_edit_grow(&ranges, 1, count, count + 1, &edits->range_capacity));
}

/* Lists a range of vertices, joined with the last one listed if they touch. */
static void edit_range_add(stilb_scene_edits *edits, stilb_scene_vertices range)
{
	const edit_ids *meshes = &edits->meshes;
	uint32_t slot = meshes->slot[range.mesh], end = range.first + range.count;
	if (slot < meshes->changed_count && meshes->changed[slot] == range.mesh)
		return; /* all of it is listed */
	stilb_scene_vertices *last = edits->range_count > 0 ? &edits->ranges[edits->range_count - 1] : NULL;
	if (last && last->mesh == range.mesh && last->first <= end && range.first <= last->first + last->count) {
		uint32_t last_end = last->first + last->count;
		last->extras |= range.extras;
		last->first = last->first < range.first ? last->first : range.first;
		last->count = (last_end > end ? last_end : end) - last->first;
		return;
	}
	if (!edit_reserve_range(edits)) {
		edit_mesh_changed(edits, range.mesh);
		return;
	}
	STILB_ASSERT(edits->ranges && edits->range_count < edits->range_capacity);
	edits->ranges[edits->range_count++] = range;
}

stilb_result stilb_scene_set_vertices(stilb_scene *scene, uint32_t id, uint32_t first, uint32_t count,
                                      const stilb_scene_vertex *vertices)
{
	STILB_ASSERT(vertices || count == 0);
	stilb_result result = scene_edit_begin(scene);
	if (result == STILB_OK)
		result = edit_find(&scene->edits->meshes, scene->mesh_count, id);
	if (result != STILB_OK)
		return result;
	stilb_scene_mesh *mesh = &scene->meshes[id];
	if (first > mesh->vertex_count || count > mesh->vertex_count - first)
		return stilb_fail(STILB_ERROR_ARGUMENT, "mesh %u: it has %u vertices, not %llu", id, mesh->vertex_count,
		                  (unsigned long long)first + count);
	result = scene_check_vertices(vertices, first, count, id);
	if (result != STILB_OK || count == 0)
		return result;
	memcpy(mesh->vertices + first, vertices, count * sizeof *vertices);
	if (mesh->level_count > 0 || mesh->cluster_count > 0) {
		stilb_scene_mesh_drop_levels(mesh);
		edit_mesh_changed(scene->edits, id);
	} else {
		edit_range_add(scene->edits, (stilb_scene_vertices){id, first, count, false});
	}
	edit_mesh_stale(scene->edits, id);
	scene->revisions.geometry++;
	return STILB_OK;
}

void scene_edit_mesh_posed(stilb_scene *scene, uint32_t mesh, const float low[3], const float high[3],
                           uint32_t model_count)
{
	stilb_scene_edits *edits = scene->edits;
	const stilb_scene_mesh *posed = &scene->meshes[mesh];
	STILB_ASSERT(posed->level_count == 0 && posed->cluster_count == 0);
	float center[3], square = 0.0f;
	for (int i = 0; i < 3; i++) {
		center[i] = 0.5f * low[i] + 0.5f * high[i];
		square += (high[i] - center[i]) * (high[i] - center[i]);
	}
	edit_range_add(edits, (stilb_scene_vertices){mesh, 0, posed->vertex_count, posed->extras});
	scene->revisions.geometry++;
	edits->mesh_pose[mesh] = ++scene->revisions.poses;
	bool usable = square < 1e36f && fabsf(center[0]) + fabsf(center[1]) + fabsf(center[2]) < SCENE_FAR;
	if (!usable || edits->meshes.users[mesh] > model_count)
		edit_mesh_stale(edits, mesh);
	if (usable)
		edits->mesh_sphere[mesh] = (stilb_sphere){center[0], center[1], center[2], sqrtf(square) * 1.00001f};
}

stilb_result stilb_scene_remove_mesh(stilb_scene *scene, uint32_t id)
{
	stilb_result result = scene_edit_begin(scene);
	if (result == STILB_OK)
		result = edit_give_back(&scene->edits->meshes, scene->mesh_count, id, "part");
	if (result != STILB_OK)
		return result;
	edit_mesh_take(scene, id);
	edit_mesh_changed(scene->edits, id); /* without its ranges */
	scene->revisions.geometry++;
	stilb_scene_mesh_finish(&scene->meshes[id]);
	return STILB_OK;
}

/* ---- materials --------------------------------------------------------------------------------------------------- */

static stilb_result edit_material_check(const stilb_scene *scene, const stilb_scene_material *material, uint32_t id)
{
	stilb_result result = scene_check_material(material, id);
	uint32_t texture = material->diffuse_texture;
	if (result == STILB_OK && texture && !scene_edit_has(&scene->edits->textures, scene->texture_count, texture - 1))
		return stilb_fail(STILB_ERROR_ARGUMENT, "material %u: there is no texture %u", id, texture - 1);
	if (result == STILB_OK && material->surface &&
	    !scene_edit_has(&scene->edits->surfaces, scene->surface_count, material->surface - 1))
		return stilb_fail(STILB_ERROR_ARGUMENT, "material %u: there is no surface %u", id, material->surface - 1);
	return result;
}

/* Replaces a material, and counts who names which texture and surface. */
static void edit_material_put(stilb_scene *scene, uint32_t id, stilb_scene_material material)
{
	uint32_t *users = scene->edits->textures.users, was = scene->materials[id].diffuse_texture;
	if (was)
		users[was - 1]--;
	if (material.diffuse_texture)
		users[material.diffuse_texture - 1]++;
	users = scene->edits->surfaces.users;
	if (scene->materials[id].surface)
		users[scene->materials[id].surface - 1]--;
	if (material.surface)
		users[material.surface - 1]++;
	scene->materials[id] = material;
	scene->revisions.materials++;
	scene_edit_changed(&scene->edits->materials, id);
}

stilb_result stilb_scene_add_material(stilb_scene *scene, const stilb_scene_material *material, uint32_t *id)
{
	STILB_ASSERT(material && id);
	stilb_scene_material own = *material; /* it may be one of the scene's, whose array moves */
	stilb_result result = scene_edit_begin(scene);
	edit_array arrays[EDIT_IDS_ARRAYS + 1] = {
		[EDIT_IDS_ARRAYS] = {(void **)&scene->materials, sizeof *scene->materials, 0}};
	if (result == STILB_OK)
		result = edit_material_check(scene, &own, edit_next(&scene->edits->materials, scene->material_count));
	if (result == STILB_OK)
		result = edit_reserve(&scene->edits->materials, arrays, 1, scene->material_count);
	if (result != STILB_OK)
		return result;
	*id = edit_take(&scene->edits->materials, &scene->material_count);
	edit_material_put(scene, *id, own); /* a free material is all zeros, and names no texture */
	return STILB_OK;
}

stilb_result stilb_scene_set_material(stilb_scene *scene, uint32_t id, const stilb_scene_material *material)
{
	STILB_ASSERT(material);
	stilb_result result = scene_edit_begin(scene);
	if (result == STILB_OK)
		result = edit_find(&scene->edits->materials, scene->material_count, id);
	if (result == STILB_OK)
		result = edit_material_check(scene, material, id);
	if (result == STILB_OK)
		edit_material_put(scene, id, *material);
	return result;
}

stilb_result stilb_scene_remove_material(stilb_scene *scene, uint32_t id)
{
	stilb_result result = scene_edit_begin(scene);
	if (result == STILB_OK)
		result = edit_give_back(&scene->edits->materials, scene->material_count, id, "part");
	if (result == STILB_OK)
		edit_material_put(scene, id, (stilb_scene_material){0});
	return result;
}

/* ---- surfaces ---------------------------------------------------------------------------------------------------- */

static stilb_result edit_surface_check(const stilb_scene *scene, const stilb_scene_surface *surface, uint32_t id)
{
	stilb_result result = scene_check_surface(surface, UINT32_MAX, UINT32_MAX, id); /* which there are is asked below */
	for (int i = 0; result == STILB_OK && i < STILB_SCENE_MAPS; i++) {
		uint32_t texture = surface->maps[i].texture;
		if (texture && !scene_edit_has(&scene->edits->textures, scene->texture_count, texture - 1))
			return stilb_fail(STILB_ERROR_ARGUMENT, "surface %u: there is no texture %u for its map %s", id,
			                  texture - 1, stilb_scene_map_names[i]);
	}
	uint32_t function = surface->function;
	if (result == STILB_OK && function &&
	    !scene_edit_has(&scene->edits->functions, scene->function_count, function - 1))
		return stilb_fail(STILB_ERROR_ARGUMENT, "surface %u: there is no function %u", id, function - 1);
	return result;
}

/* Replaces a surface, and counts who names which texture and function. */
static void edit_surface_put(stilb_scene *scene, uint32_t id, const stilb_scene_surface *surface)
{
	stilb_scene_surface *at = &scene->surfaces[id];
	uint32_t *users = scene->edits->textures.users;
	for (int i = 0; i < STILB_SCENE_MAPS; i++) {
		if (at->maps[i].texture)
			users[at->maps[i].texture - 1]--;
		if (surface->maps[i].texture)
			users[surface->maps[i].texture - 1]++;
	}
	users = scene->edits->functions.users;
	if (at->function)
		users[at->function - 1]--;
	if (surface->function)
		users[surface->function - 1]++;
	*at = *surface;
	for (uint32_t m = 0; scene->edits->surfaces.users[id] > 0 && m < scene->material_count; m++)
		if (scene->materials[m].surface == id + 1)
			scene_edit_changed(&scene->edits->materials, m);
	scene->revisions.materials++;
}

stilb_result stilb_scene_add_surface(stilb_scene *scene, const stilb_scene_surface *surface, uint32_t *id)
{
	STILB_ASSERT(surface && id);
	stilb_scene_surface own = *surface; /* it may be one of the scene's, whose array moves */
	stilb_result result = scene_edit_begin(scene);
	edit_array arrays[EDIT_IDS_ARRAYS + 1] = {
		[EDIT_IDS_ARRAYS] = {(void **)&scene->surfaces, sizeof *scene->surfaces, 0}};
	if (result == STILB_OK)
		result = edit_surface_check(scene, &own, edit_next(&scene->edits->surfaces, scene->surface_count));
	if (result == STILB_OK)
		result = edit_reserve(&scene->edits->surfaces, arrays, 1, scene->surface_count);
	if (result != STILB_OK)
		return result;
	*id = edit_take(&scene->edits->surfaces, &scene->surface_count);
	edit_surface_put(scene, *id, &own);
	return STILB_OK;
}

stilb_result stilb_scene_set_surface(stilb_scene *scene, uint32_t id, const stilb_scene_surface *surface)
{
	STILB_ASSERT(surface);
	stilb_scene_surface copy = *surface;
	stilb_result result = scene_edit_begin(scene);
	if (result == STILB_OK)
		result = edit_find(&scene->edits->surfaces, scene->surface_count, id);
	if (result == STILB_OK)
		result = edit_surface_check(scene, &copy, id);
	if (result == STILB_OK)
		edit_surface_put(scene, id, &copy);
	return result;
}

stilb_result stilb_scene_remove_surface(stilb_scene *scene, uint32_t id)
{
	stilb_result result = scene_edit_begin(scene);
	if (result == STILB_OK)
		result = edit_give_back(&scene->edits->surfaces, scene->surface_count, id, "material");
	if (result == STILB_OK)
		edit_surface_put(scene, id, &(stilb_scene_surface){0});
	return result;
}

/* ---- functions of surfaces --------------------------------------------------------------------------------------- */

stilb_result stilb_scene_add_function(stilb_scene *scene, const stilb_scene_function *function, uint32_t *id)
{
	STILB_ASSERT(function && id);
	stilb_scene_function copy, own = *function; /* it may be one of the scene's, whose array moves */
	stilb_result result = scene_edit_begin(scene);
	edit_array arrays[EDIT_IDS_ARRAYS + 1] = {
		[EDIT_IDS_ARRAYS] = {(void **)&scene->functions, sizeof *scene->functions, 0}};
	if (result == STILB_OK)
		result = scene_check_function(&own, edit_next(&scene->edits->functions, scene->function_count));
	if (result == STILB_OK)
		result = edit_reserve(&scene->edits->functions, arrays, 1, scene->function_count);
	if (result == STILB_OK)
		result = stilb_scene_function_copy(&own, &copy);
	if (result != STILB_OK)
		return result;
	*id = edit_take(&scene->edits->functions, &scene->function_count);
	scene->functions[*id] = copy;
	return STILB_OK;
}

stilb_result stilb_scene_remove_function(stilb_scene *scene, uint32_t id)
{
	stilb_result result = scene_edit_begin(scene);
	if (result == STILB_OK)
		result = edit_give_back(&scene->edits->functions, scene->function_count, id, "surface");
	if (result == STILB_OK)
		stilb_scene_function_finish(&scene->functions[id]);
	return result;
}

/* ---- lights ------------------------------------------------------------------------------------------------------ */

static stilb_result edit_check_light(const stilb_scene *scene, const stilb_scene_light *light, uint32_t id)
{
	const char *mistake = stilb_scene_light_mistake(light);
	if (mistake)
		return stilb_fail(STILB_ERROR_ARGUMENT, "light %u: %s", id, mistake);
	if (light->face > scene->part_count || (light->face && scene->part_mesh[light->face - 1] == STILB_SCENE_NONE))
		return stilb_fail(STILB_ERROR_ARGUMENT, "light %u: there is no part %u", id, light->face - 1);
	return STILB_OK;
}

stilb_result stilb_scene_set_lights(stilb_scene *scene, const stilb_scene_light *lights, uint32_t count)
{
	STILB_ASSERT(scene && (lights || count == 0));
	stilb_result result = STILB_OK;
	for (uint32_t i = 0; i < count && result == STILB_OK; i++)
		result = edit_check_light(scene, &lights[i], i);
	if (result != STILB_OK)
		return result;
	stilb_scene_light *copy = stilb_memory_alloc(count + (size_t)1, sizeof *copy);
	if (!copy)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for %u lights", count);
	if (count > 0)
		memcpy(copy, lights, count * sizeof *copy);
	free(scene->lights);
	free(scene->light_mounts);
	scene->light_mounts = NULL;
	scene->lights = copy;
	scene->light_count = count;
	return STILB_OK;
}

/* ---- textures ---------------------------------------------------------------------------------------------------- */

stilb_result stilb_scene_add_texture(stilb_scene *scene, const stilb_image *image, uint32_t *id)
{
	STILB_ASSERT(image && id);
	stilb_image copy, own = *image; /* it may be one of the scene's, whose array moves */
	stilb_result result = scene_edit_begin(scene);
	edit_array arrays[EDIT_IDS_ARRAYS + 1] = {
		[EDIT_IDS_ARRAYS] = {(void **)&scene->textures, sizeof *scene->textures, 0}};
	if (result == STILB_OK)
		result = scene_check_texture(&own, edit_next(&scene->edits->textures, scene->texture_count));
	if (result == STILB_OK)
		result = edit_reserve(&scene->edits->textures, arrays, 1, scene->texture_count);
	if (result == STILB_OK)
		result = stilb_image_copy(&own, false, &copy);
	if (result != STILB_OK)
		return result;
	*id = edit_take(&scene->edits->textures, &scene->texture_count);
	scene->revisions.materials++;
	scene->revisions.textures++;
	scene->textures[*id] = copy;
	return STILB_OK;
}

stilb_result stilb_scene_set_texture(stilb_scene *scene, uint32_t id, const stilb_image *image)
{
	STILB_ASSERT(image);
	stilb_image copy;
	stilb_result result = scene_edit_begin(scene);
	if (result == STILB_OK)
		result = edit_find(&scene->edits->textures, scene->texture_count, id);
	if (result == STILB_OK)
		result = scene_check_texture(image, id);
	if (result == STILB_OK)
		result = stilb_image_copy(image, false, &copy);
	if (result != STILB_OK)
		return result;
	stilb_image_finish(&scene->textures[id]);
	scene->textures[id] = copy;
	scene_edit_changed(&scene->edits->textures, id);
	scene->revisions.materials++;
	scene->revisions.textures++;
	return STILB_OK;
}

stilb_result stilb_scene_remove_texture(stilb_scene *scene, uint32_t id)
{
	stilb_result result = scene_edit_begin(scene);
	if (result == STILB_OK)
		result = edit_give_back(&scene->edits->textures, scene->texture_count, id, "material or surface");
	if (result != STILB_OK)
		return result;
	stilb_image_finish(&scene->textures[id]);
	scene->revisions.materials++;
	scene->revisions.textures++;
	return STILB_OK;
}
