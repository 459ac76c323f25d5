#include "scene/importer/importer.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

stilb_mat4 importer_matrix(const struct aiMatrix4x4 *m)
{
	return (stilb_mat4){.m = {m->a1, m->b1, m->c1, m->d1, m->a2, m->b2, m->c2, m->d2, m->a3, m->b3, m->c3, m->d3, m->a4,
	                          m->b4, m->c4, m->d4}};
}

bool importer_is_finite(const stilb_mat4 *m)
{
	bool finite = true;
	for (int i = 0; i < 16; i++)
		finite &= isfinite(m->m[i]) != 0;
	return finite;
}

/* The node that a child hangs on. Assimp 5.2 lists all bones of Half-Life's models as children of one node, and says in
 * mParent alone on which of them each hangs; their transforms are relative to that. */
static uint32_t nodes_find_parent(const importer *import, uint32_t lister, const struct aiNode *child)
{
	if (child->mParent == import->nodes[lister].node || !importer_is_format(import->from, "Quake Mesh"))
		return lister;
	for (uint32_t i = import->node_count; --i > lister;)
		if (import->nodes[i].node == child->mParent)
			return i;
	return lister;
}

/* Lists the nodes breadth first; the list itself is the queue of nodes whose children are still to be added. Without
 * recursion no hierarchy is too deep. */
stilb_result importer_list_nodes(importer *import)
{
	STILB_ASSERT(import->from && !import->nodes);
	uint32_t capacity = 1024;
	import->nodes = malloc(capacity * sizeof *import->nodes);
	if (!import->nodes)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for its hierarchy");
	if (!import->from->mRootNode)
		return stilb_fail(STILB_ERROR_FILE, "it has no root node");
	import->nodes[0].node = import->from->mRootNode;
	stilb_mat4 root = importer_matrix(&import->from->mRootNode->mTransformation);
	import->nodes[0].to_world = import->nodes[0].local = stilb_mat4_multiply(import->world.to_world, root);
	if (!importer_is_finite(&import->nodes[0].local))
		return stilb_fail(STILB_ERROR_FILE, "the transform of its root is NaN or infinite");
	import->nodes[0].parent = STILB_SCENE_NONE;
	import->node_count = 1;
	for (uint32_t i = 0; i < import->node_count; i++) {
		const struct aiNode *node = import->nodes[i].node;
		if ((uint64_t)import->node_count + node->mNumChildren > IMPORTER_MAX_NODES)
			return stilb_fail(STILB_ERROR_FILE, "it has more than %u nodes", IMPORTER_MAX_NODES);
		while (import->node_count + node->mNumChildren > capacity) {
			capacity *= 2;
			importer_node *more = realloc(import->nodes, capacity * sizeof *more);
			if (!more)
				return stilb_fail(STILB_ERROR_MEMORY, "no memory for its hierarchy");
			import->nodes = more;
		}
		for (uint32_t c = 0; c < node->mNumChildren; c++) {
			if (!node->mChildren[c])
				continue; /* Assimp 5.2 leaves holes in the hierarchy of .raw */
			stilb_mat4 own = importer_matrix(&node->mChildren[c]->mTransformation);
			uint32_t parent = nodes_find_parent(import, i, node->mChildren[c]);
			stilb_mat4 to_world = stilb_mat4_multiply(import->nodes[parent].to_world, own);
			importer_node child = {node->mChildren[c], to_world, parent, own};
			if (importer_is_finite(&child.to_world))
				import->nodes[import->node_count++] = child;
			else
				import->bad_nodes++;
		}
		STILB_ASSERT(import->node_count <= capacity);
	}
	return STILB_OK;
}

stilb_result importer_add_nodes(importer *import)
{
	stilb_scene_nodes *nodes = &import->scene->nodes;
	stilb_result result = scene_add_nodes(import->scene, import->node_count);
	for (uint32_t n = 0; result == STILB_OK && n < import->node_count; n++) {
		const importer_node *from = &import->nodes[n];
		nodes->parent[n] = from->parent;
		nodes->pose[n] = stilb_scene_pose_of(&from->local);
		nodes->local[n] = from->local;
		nodes->to_world[n] = from->to_world;
		snprintf(nodes->name[n], sizeof *nodes->name, "%.*s", STILB_SCENE_NAME - 1, from->node->mName.data);
	}
	return result;
}

const importer_node *importer_find_node(const importer *import, const struct aiString *name)
{
	STILB_ASSERT(import && name);
	for (uint32_t i = 0; i < import->node_count; i++)
		if (strcmp(import->nodes[i].node->mName.data, name->data) == 0)
			return &import->nodes[i];
	return &import->world;
}

stilb_vec3 importer_point(const importer_node *node, stilb_vec3 p)
{
	const float *m = node->to_world.m;
	stilb_vec3 at = {0};
	for (int row = 0; row < 3; row++)
		at[row] = m[row] * p[0] + m[4 + row] * p[1] + m[8 + row] * p[2] + m[12 + row];
	return at;
}
