/* The hierarchy of the scene that is shown. */
#include "scene/importer/gltf/gltf.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

gltf_place gltf_node_place(gltf *from, uint32_t item)
{
	scene_json *json = &from->json;
	gltf_place place = {.pose = {.rotation = {0, 0, 0, 1}, .scale = {1, 1, 1}}};
	if (scene_json_numbers(json, item, "matrix", place.local.m, 16))
		return place;
	place.moves = true;
	scene_json_numbers(json, item, "translation", place.pose.translation, 3);
	scene_json_numbers(json, item, "rotation", place.pose.rotation, 4);
	scene_json_numbers(json, item, "scale", place.pose.scale, 3);
	place.local = stilb_scene_pose_matrix(&place.pose);
	return place;
}

bool gltf_is_finite(const stilb_mat4 *m)
{
	float sum = 0.0f;
	for (int i = 0; i < 16; i++)
		sum += m->m[i] * 0.0f; /* NaN for NaN and infinity */
	return sum == 0.0f;
}

/* Lists a node, each at most once, so there is room; one whose transform is not finite is left out. */
static void nodes_append(gltf *from, uint32_t index, uint32_t parent)
{
	gltf_node node = {.item = from->lists[GLTF_NODES].items[index], .index = index, .parent = parent};
	node.to_world = gltf_node_place(from, node.item).local;
	if (parent != GLTF_NONE)
		node.to_world = stilb_mat4_multiply(from->nodes[parent].to_world, node.to_world);
	if (gltf_is_finite(&node.to_world))
		from->nodes[from->node_count++] = node;
	else
		from->import->bad_nodes++;
}

typedef struct nodes_lister {
	gltf *from;
	bool *listed; /* [nodes] */
} nodes_lister;

/* Adds the nodes of an array of indices, in the space of a listed node; GLTF_NONE: in the world. */
static stilb_result nodes_add(nodes_lister *lister, uint32_t array, uint32_t parent)
{
	gltf *from = lister->from;
	scene_json *json = &from->json;
	const gltf_list *all = &from->lists[GLTF_NODES];
	for (uint32_t at = scene_json_first(json, array); at != GLTF_NONE; at = scene_json_after(json, array, at)) {
		uint64_t index = scene_json_whole(json, at);
		if (index >= all->count)
			scene_json_blame(json, at, "it names node %llu, but there are %u", (unsigned long long)index, all->count);
		if (json->fault[0])
			return scene_json_check(json);
		if (lister->listed[index])
			return stilb_fail(STILB_ERROR_FILE, "its hierarchy is recursive or no tree: node %llu has two parents",
			                  (unsigned long long)index);
		lister->listed[index] = true;
		nodes_append(from, (uint32_t)index, parent);
	}
	return scene_json_check(json);
}

/* Adds the nodes that are no other's children. */
static stilb_result nodes_add_roots(nodes_lister *lister)
{
	gltf *from = lister->from;
	scene_json *json = &from->json;
	const gltf_list *all = &from->lists[GLTF_NODES];
	bool *child = calloc(all->count + 1ull, sizeof *child);
	if (!child)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for its hierarchy");
	for (uint32_t n = 0; n < all->count; n++) {
		uint32_t array = scene_json_array(json, all->items[n], "children");
		for (uint32_t at = scene_json_first(json, array); at != GLTF_NONE; at = scene_json_after(json, array, at)) {
			uint64_t index = scene_json_whole(json, at);
			if (index < all->count)
				child[index] = true;
		}
	}
	for (uint32_t n = 0; n < all->count; n++)
		if (!child[n]) {
			lister->listed[n] = true;
			nodes_append(from, n, GLTF_NONE);
		}
	free(child);
	return scene_json_check(json);
}

/* Lists the nodes breadth first; the list itself is the queue of those whose children are still to be added. */
static stilb_result nodes_list(nodes_lister *lister)
{
	gltf *from = lister->from;
	scene_json *json = &from->json;
	const gltf_list *scenes = &from->lists[GLTF_SCENES];
	uint32_t scene = gltf_reference(from, SCENE_JSON_ROOT, "scene", GLTF_SCENES);
	if (scene == GLTF_NONE)
		scene = 0;
	stilb_result result = scenes->count == 0
	                          ? nodes_add_roots(lister)
	                          : nodes_add(lister, scene_json_array(json, scenes->items[scene], "nodes"), GLTF_NONE);
	for (uint32_t i = 0; result == STILB_OK && i < from->node_count; i++)
		result = nodes_add(lister, scene_json_array(json, from->nodes[i].item, "children"), i);
	for (uint32_t i = 0; result == STILB_OK && i < scenes->count; i++)
		if (i != scene) {
			char name[96];
			gltf_name(from, GLTF_SCENES, i, name);
			importer_lose(from->import, IMPORTER_LOSS_SCENES, name);
		}
	return result;
}

stilb_result gltf_list_nodes(gltf *from)
{
	STILB_ASSERT(!from->nodes);
	uint32_t count = from->lists[GLTF_NODES].count;
	if (count > IMPORTER_MAX_NODES)
		return stilb_fail(STILB_ERROR_FILE, "it has more than %u nodes", IMPORTER_MAX_NODES);
	nodes_lister lister = {.from = from, .listed = calloc(count + 1ull, sizeof *lister.listed)};
	from->nodes = calloc(count + 1ull, sizeof *from->nodes);
	stilb_result result = lister.listed && from->nodes ? nodes_list(&lister)
	                                                   : stilb_fail(STILB_ERROR_MEMORY, "no memory for its hierarchy");
	free(lister.listed);
	return result;
}

/* The pose of a place: as the file has it, unless its rotation is none. */
static stilb_scene_pose nodes_pose(const gltf_place *place)
{
	const float *q = place->pose.rotation;
	float square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
	bool turns = place->moves && square >= 0.98f && square <= 1.02f;
	return turns ? place->pose : stilb_scene_pose_of(&place->local);
}

stilb_result gltf_add_nodes(gltf *from, uint32_t instances)
{
	stilb_scene *scene = from->import->scene;
	stilb_scene_nodes *nodes = &scene->nodes;
	stilb_result result = scene_add_nodes(scene, from->node_count + instances);
	for (uint32_t n = 0; result == STILB_OK && n < from->node_count; n++) {
		gltf_place place = gltf_node_place(from, from->nodes[n].item);
		nodes->parent[n] = from->nodes[n].parent;
		nodes->pose[n] = nodes_pose(&place);
		nodes->local[n] = place.local;
		nodes->to_world[n] = from->nodes[n].to_world;
		scene_json_string(&from->json, from->nodes[n].item, "name", nodes->name[n], sizeof *nodes->name);
	}
	nodes->count = result == STILB_OK ? from->node_count : 0; /* the instances are added one by one */
	return result == STILB_OK ? scene_json_check(&from->json) : result;
}
