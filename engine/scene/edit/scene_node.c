/* Nodes that come, move and go. */
#include "scene/edit/scene_node.h"

#include "scene/edit/scene_check.h"
#include "scene/edit/scene_edit_internal.h"
#include "scene/play/scene_play_internal.h"
#include "scene/scene_internal.h"

#include <stdio.h>
#include <string.h>

#define NODE_MOST_STEPS 64u /* up the hierarchy to keep its order; beyond, making the order anew is cheaper */

/* ---- checks ------------------------------------------------------------------------------------------------------ */

static bool node_exists(const stilb_scene *scene, uint32_t id)
{
	return id < scene->nodes.count && scene->edits->nodes.next[id] == EDIT_IN_USE;
}

/* STILB_OK if there is such a node and edits can begin. */
static stilb_result node_find(stilb_scene *scene, uint32_t id)
{
	stilb_result result = scene_edit_begin(scene);
	if (result == STILB_OK && !node_exists(scene, id))
		return stilb_fail(STILB_ERROR_ARGUMENT, "there is no node %u", id);
	return result;
}

static stilb_result node_check_parent(const stilb_scene *scene, uint32_t id, uint32_t parent)
{
	if (parent != STILB_SCENE_NONE && !node_exists(scene, parent))
		return stilb_fail(STILB_ERROR_ARGUMENT, "node %u: there is no node %u", id, parent);
	return STILB_OK;
}

/* ---- changes ----------------------------------------------------------------------------------------------------- */

void scene_edit_node_changed(edit_nodes *nodes, uint32_t node)
{
	STILB_ASSERT(node < nodes->capacity);
	uint32_t slot = nodes->slot[node];
	if (slot < nodes->changed_count && nodes->changed[slot] == node)
		return;
	STILB_ASSERT(nodes->changed_count < nodes->capacity);
	nodes->slot[node] = nodes->changed_count;
	nodes->changed[nodes->changed_count++] = node;
}

static stilb_result node_reserve(stilb_scene *scene)
{
	stilb_scene_nodes *all = &scene->nodes;
	edit_nodes *nodes = &scene->edits->nodes;
	edit_array arrays[] = {
		{(void **)&all->parent, sizeof *all->parent, 0},
		{(void **)&all->pose, sizeof *all->pose, 0},
		{(void **)&all->local, sizeof *all->local, 0},
		{(void **)&all->to_world, sizeof *all->to_world, 0},
		{(void **)&all->name, sizeof *all->name, 0},
		{(void **)&nodes->next, sizeof *nodes->next, 0},
		{(void **)&nodes->children, sizeof *nodes->children, 0},
		{(void **)&nodes->first_model, sizeof *nodes->first_model, 0},
		{(void **)&nodes->order, sizeof *nodes->order, 0},
		{(void **)&nodes->end, sizeof *nodes->end, 0},
		{(void **)&nodes->position, sizeof *nodes->position, 0},
		{(void **)&nodes->first_child, sizeof *nodes->first_child, 0},
		{(void **)&nodes->sibling, sizeof *nodes->sibling, 0},
		{(void **)&nodes->changed, sizeof *nodes->changed, 0},
		{(void **)&nodes->slot, sizeof *nodes->slot, 0},
		{(void **)&nodes->marks, sizeof *nodes->marks, 0},
		{(void **)&nodes->figure, sizeof *nodes->figure, 0},
	};
	if (nodes->first_free || all->count < nodes->capacity)
		return STILB_OK;
	if (all->count >= STILB_SCENE_MAX_MODELS) /* of a file there may be more, which stay */
		return stilb_fail(STILB_ERROR_ARGUMENT, "more than %u nodes", STILB_SCENE_MAX_MODELS);
	if (scene_edit_grow(arrays, sizeof arrays / sizeof *arrays, all->count, all->count + 1, &nodes->capacity))
		return STILB_OK;
	return stilb_fail(STILB_ERROR_MEMORY, "no memory for another node");
}

/* Puts a new node at the end of the order, if the subtree of its parent ends there. */
static void node_append(stilb_scene *scene, uint32_t id)
{
	edit_nodes *nodes = &scene->edits->nodes;
	uint32_t end = nodes->order_count, steps = 0;
	for (uint32_t n = scene->nodes.parent[id]; n != STILB_SCENE_NONE && !nodes->unordered; n = scene->nodes.parent[n])
		nodes->unordered = nodes->end[nodes->position[n]] != end || ++steps > NODE_MOST_STEPS;
	if (nodes->unordered || end == nodes->capacity) { /* holes fill the rest */
		nodes->unordered = true;
		return;
	}
	for (uint32_t n = scene->nodes.parent[id]; n != STILB_SCENE_NONE; n = scene->nodes.parent[n])
		nodes->end[nodes->position[n]] = end + 1;
	nodes->order[end] = id;
	nodes->position[id] = end;
	nodes->end[end] = end + 1;
	nodes->order_count = end + 1;
}

/* ---- nodes ------------------------------------------------------------------------------------------------------- */

stilb_result stilb_scene_add_node(stilb_scene *scene, uint32_t parent, const stilb_scene_pose *pose, uint32_t *id)
{
	STILB_ASSERT(pose && id);
	stilb_result result = scene_edit_begin(scene);
	if (result != STILB_OK)
		return result;
	edit_nodes *nodes = &scene->edits->nodes;
	stilb_scene_nodes *all = &scene->nodes;
	uint32_t node = nodes->first_free ? nodes->first_free - 1 : all->count;
	result = node_check_parent(scene, node, parent);
	if (result == STILB_OK)
		result = scene_check_pose(pose, node);
	if (result == STILB_OK)
		result = node_reserve(scene);
	if (result != STILB_OK)
		return result;
	if (nodes->first_free)
		nodes->first_free = nodes->next[node];
	else
		all->count++;
	nodes->next[node] = EDIT_IN_USE;
	nodes->children[node] = nodes->first_model[node] = nodes->figure[node] = 0;
	all->parent[node] = parent;
	all->pose[node] = *pose;
	all->local[node] = stilb_scene_pose_matrix(pose);
	all->to_world[node] = all->local[node];
	all->name[node][0] = 0;
	if (parent != STILB_SCENE_NONE)
		nodes->children[parent]++;
	node_append(scene, node);
	scene_edit_node_changed(nodes, node);
	*id = node;
	return STILB_OK;
}

/* The first of these that hangs on a node, or STILB_SCENE_NONE. mounts: NULL, or [count]. */
static uint32_t node_mounted(const stilb_scene_mount *mounts, uint32_t count, uint32_t node)
{
	for (uint32_t i = 0; mounts && i < count; i++)
		if (mounts[i].node == node + 1)
			return i;
	return STILB_SCENE_NONE;
}

/* STILB_OK if nothing hangs on a node. */
static stilb_result node_check_free(const stilb_scene *scene, uint32_t id)
{
	const edit_nodes *nodes = &scene->edits->nodes;
	if (nodes->children[id] > 0)
		return stilb_fail(STILB_ERROR_ARGUMENT, "node %u is in use by %u node%s; remove these first", id,
		                  nodes->children[id], nodes->children[id] == 1 ? "" : "s");
	if (nodes->first_model[id])
		return stilb_fail(STILB_ERROR_ARGUMENT, "node %u is in use by model %u; attach it elsewhere first", id,
		                  nodes->first_model[id] - 1);
	uint32_t light = node_mounted(scene->light_mounts, scene->light_count, id);
	if (light != STILB_SCENE_NONE)
		return stilb_fail(STILB_ERROR_ARGUMENT, "node %u is in use by light %u; attach it elsewhere first", id, light);
	uint32_t camera = node_mounted(scene->camera_mounts, scene->camera_count, id);
	if (camera != STILB_SCENE_NONE)
		return stilb_fail(STILB_ERROR_ARGUMENT, "node %u is in use by camera %u; attach it elsewhere first", id,
		                  camera);
	return STILB_OK;
}

stilb_result stilb_scene_remove_node(stilb_scene *scene, uint32_t id)
{
	stilb_result result = node_find(scene, id);
	if (result == STILB_OK)
		result = node_check_free(scene, id);
	if (result != STILB_OK)
		return result;
	edit_nodes *nodes = &scene->edits->nodes;
	uint32_t parent = scene->nodes.parent[id];
	if (nodes->figure[id])
		scene_play_forget_node(scene, nodes->figure[id], id);
	nodes->figure[id] = 0;
	if (parent != STILB_SCENE_NONE)
		nodes->children[parent]--;
	if (!nodes->unordered) {
		nodes->order[nodes->position[id]] = STILB_SCENE_NONE;
		nodes->hole_count++;
	}
	scene->nodes.parent[id] = id;
	scene->nodes.name[id][0] = 0;
	nodes->next[id] = nodes->first_free;
	nodes->first_free = id + 1;
	return STILB_OK;
}

stilb_result stilb_scene_set_node_pose(stilb_scene *scene, uint32_t id, const stilb_scene_pose *pose)
{
	STILB_ASSERT(pose);
	stilb_result result = node_find(scene, id);
	if (result == STILB_OK)
		result = scene_check_pose(pose, id);
	if (result != STILB_OK)
		return result;
	scene->nodes.pose[id] = *pose;
	scene->nodes.local[id] = stilb_scene_pose_matrix(pose);
	scene_edit_node_changed(&scene->edits->nodes, id);
	return STILB_OK;
}

stilb_result stilb_scene_set_node_matrix(stilb_scene *scene, uint32_t id, const stilb_mat4 *local)
{
	STILB_ASSERT(local);
	stilb_result result = node_find(scene, id);
	if (result == STILB_OK && !scene_is_affine(local))
		return stilb_fail(STILB_ERROR_ARGUMENT, "node %u: its matrix is not affine, or not within 1e18", id);
	if (result != STILB_OK)
		return result;
	scene->nodes.pose[id] = stilb_scene_pose_of(local);
	scene->nodes.local[id] = *local;
	scene_edit_node_changed(&scene->edits->nodes, id);
	return STILB_OK;
}

stilb_result stilb_scene_set_node_parent(stilb_scene *scene, uint32_t id, uint32_t parent)
{
	stilb_result result = node_find(scene, id);
	if (result == STILB_OK)
		result = node_check_parent(scene, id, parent);
	if (result != STILB_OK)
		return result;
	uint32_t *parents = scene->nodes.parent, was = parents[id];
	for (uint32_t n = parent; n != STILB_SCENE_NONE; n = parents[n])
		if (n == id)
			return stilb_fail(STILB_ERROR_ARGUMENT, "node %u: node %u hangs on it", id, parent);
	if (was == parent)
		return STILB_OK;
	edit_nodes *nodes = &scene->edits->nodes;
	if (was != STILB_SCENE_NONE)
		nodes->children[was]--;
	if (parent != STILB_SCENE_NONE)
		nodes->children[parent]++;
	parents[id] = parent;
	nodes->unordered = true;
	scene_edit_node_changed(nodes, id);
	return STILB_OK;
}

stilb_result stilb_scene_set_node_name(stilb_scene *scene, uint32_t id, const char *name)
{
	stilb_result result = node_find(scene, id);
	if (result == STILB_OK)
		snprintf(scene->nodes.name[id], sizeof *scene->nodes.name, "%s", name ? name : "");
	return result;
}

uint32_t stilb_scene_find_node(const stilb_scene *scene, const char *name)
{
	STILB_ASSERT(scene && name);
	for (uint32_t n = 0; n < scene->nodes.count; n++)
		if (scene->nodes.parent[n] != n && strcmp(scene->nodes.name[n], name) == 0)
			return n;
	return STILB_SCENE_NONE;
}

/* ---- lights and cameras ------------------------------------------------------------------------------------------ */

/* Checks that thing `id` of `count` can hang on a node, and makes room in its list. */
static stilb_result node_mount(stilb_scene *scene, stilb_scene_mount **mounts, uint32_t count, uint32_t id,
                               uint32_t node, const char *what)
{
	stilb_result result = scene_edit_begin(scene);
	if (result == STILB_OK && id >= count)
		return stilb_fail(STILB_ERROR_ARGUMENT, "there is no %s %u", what, id);
	if (result == STILB_OK && node != STILB_SCENE_NONE && !node_exists(scene, node))
		return stilb_fail(STILB_ERROR_ARGUMENT, "%s %u: there is no node %u", what, id, node);
	return result == STILB_OK && node != STILB_SCENE_NONE ? scene_add_mounts(mounts, count) : result;
}

/* Keeps how a thing hangs; one that hangs on no node needs no list. */
static void node_mount_put(stilb_scene *scene, stilb_scene_mount *mounts, uint32_t id, stilb_scene_mount mount)
{
	if (mounts)
		mounts[id] = mount;
	if (mount.node)
		scene_edit_node_changed(&scene->edits->nodes, mount.node - 1);
}

stilb_result stilb_scene_attach_light(stilb_scene *scene, uint32_t light, uint32_t node)
{
	stilb_result result = node_mount(scene, &scene->light_mounts, scene->light_count, light, node, "light");
	if (result == STILB_OK)
		node_mount_put(scene, scene->light_mounts, light,
		               node == STILB_SCENE_NONE ? (stilb_scene_mount){0}
		                                        : scene_mount_of_light(&scene->lights[light], node + 1));
	return result;
}

stilb_result stilb_scene_attach_camera(stilb_scene *scene, uint32_t camera, uint32_t node)
{
	stilb_result result = node_mount(scene, &scene->camera_mounts, scene->camera_count, camera, node, "camera");
	if (result == STILB_OK)
		node_mount_put(scene, scene->camera_mounts, camera,
		               node == STILB_SCENE_NONE ? (stilb_scene_mount){0}
		                                        : scene_mount_of_camera(&scene->cameras[camera].camera, node + 1));
	return result;
}
