/* New places for what hangs on nodes that have changed. Nodes stand in an order in which each subtree is a range, so
 * that those to be updated are a few ranges; these are cut into pieces that need nothing of one another, for the
 * pool. */
#include "scene/edit/scene_node.h"

#include "profiler/prof.h"
#include "scene/edit/scene_edit_internal.h"
#include "scene/play/scene_play_internal.h"
#include "scene/scene_internal.h"
#include "scene/scene_pose.h"

#include <string.h>

#define UPDATE_GRAIN 256u   /* nodes of a piece */
#define UPDATE_ALONE 8192u  /* below so many nodes the pool is not asked: it would take longer */
#define UPDATE_PIECES 1024u /* at once */

/* ---- order ------------------------------------------------------------------------------------------------------- */

/* The children of each node, and the roots, as lists in the order of their ids. Returns 1 + the first root. */
static uint32_t order_list(const stilb_scene_nodes *all, edit_nodes *nodes)
{
	uint32_t roots = 0;
	memset(nodes->first_child, 0, all->count * sizeof *nodes->first_child);
	for (uint32_t n = all->count; n-- > 0;) {
		if (nodes->next[n] != EDIT_IN_USE)
			continue;
		uint32_t *first = all->parent[n] == STILB_SCENE_NONE ? &roots : &nodes->first_child[all->parent[n]];
		nodes->sibling[n] = *first;
		*first = n + 1;
	}
	return roots;
}

/* A node first, then its children's subtrees. Without recursion no hierarchy is too deep. */
static void order_make(const stilb_scene_nodes *all, edit_nodes *nodes)
{
	uint32_t count = 0, at = order_list(all, nodes);
	while (at) {
		uint32_t n = at - 1;
		nodes->position[n] = count;
		nodes->order[count++] = n;
		at = nodes->first_child[n];
		while (!at) { /* up, until there is a sibling; on the way the subtrees end */
			nodes->end[nodes->position[n]] = count;
			at = nodes->sibling[n];
			n = all->parent[n];
			if (n == STILB_SCENE_NONE)
				break;
		}
	}
	nodes->order_count = count;
	nodes->hole_count = 0;
	nodes->unordered = false;
}

/* ---- places ------------------------------------------------------------------------------------------------------ */

static inline void update_node(stilb_scene *scene, uint32_t position)
{
	const stilb_scene_edits *edits = scene->edits;
	stilb_scene_nodes *all = &scene->nodes;
	uint32_t n = edits->nodes.order[position];
	if (n == STILB_SCENE_NONE)
		return;
	if (all->parent[n] == STILB_SCENE_NONE)
		all->to_world[n] = all->local[n];
	else
		scene_multiply(&all->to_world[all->parent[n]], &all->local[n], &all->to_world[n]);
	for (uint32_t m = edits->nodes.first_model[n]; m; m = edits->models[m - 1].next_on_node)
		scene_edit_place_model(scene, m - 1, &all->to_world[n]);
}

/* ---- on the pool ------------------------------------------------------------------------------------------------- */

/* A range of the order; what its nodes hang on, outside of it, has its place already. */
typedef struct update_piece {
	uint32_t begin, end;
} update_piece;

typedef struct update {
	stilb_scene *scene;
	stilb_job_pool *pool;
	uint32_t worker;
	uint32_t piece_count, node_count; /* collected so far */
	update_piece pieces[UPDATE_PIECES];
} update;

static void update_pieces(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	update *u = context;
	(void)worker;
	for (uint32_t i = begin; i < end; i++)
		for (uint32_t position = u->pieces[i].begin; position < u->pieces[i].end; position++)
			update_node(u->scene, position);
}

static void update_flush(update *u)
{
	uint32_t grain = (uint32_t)((uint64_t)u->piece_count * UPDATE_GRAIN / (u->node_count + 1));
	stilb_job_parallel_for(u->pool, u->piece_count, grain, update_pieces, u, u->worker);
	u->piece_count = u->node_count = 0;
}

static void update_collect(update *u, uint32_t begin, uint32_t end)
{
	if (begin == end)
		return;
	if (u->piece_count == UPDATE_PIECES)
		update_flush(u);
	u->pieces[u->piece_count++] = (update_piece){begin, end};
	u->node_count += end - begin;
}

/* Cuts a subtree into pieces of whole subtrees. A node whose subtree is larger than a piece is placed here. */
static void update_split(update *u, uint32_t begin, uint32_t end)
{
	const uint32_t *ends = u->scene->edits->nodes.end;
	uint32_t piece = begin, at = begin;
	while (at < end) {
		if (ends[at] - at > UPDATE_GRAIN) {
			update_collect(u, piece, at);
			update_node(u->scene, at);
			piece = ++at;
		} else {
			at = ends[at];
			if (at - piece >= UPDATE_GRAIN) {
				update_collect(u, piece, at);
				piece = at;
			}
		}
	}
	update_collect(u, piece, at);
}

/* ---- ranges ------------------------------------------------------------------------------------------------------ */

/* The subtrees of the changed nodes that lie in no other of them, by where they begin in the order: replaces the list
 * of changed nodes. Returns how many nodes they have together. */
static uint32_t update_find_ranges(edit_nodes *nodes, uint32_t *range_count)
{
	uint32_t low = UINT32_MAX, high = 0, total = 0, count = 0;
	for (uint32_t i = 0; i < nodes->changed_count; i++) {
		uint32_t n = nodes->changed[i];
		if (nodes->next[n] != EDIT_IN_USE)
			continue; /* removed since */
		uint32_t position = nodes->position[n];
		nodes->marks[position] = 1;
		low = position < low ? position : low;
		high = position >= high ? position + 1 : high;
	}
	for (uint32_t at = low; at < high;) {
		unsigned char *mark = memchr(nodes->marks + at, 1, high - at);
		if (!mark)
			break;
		uint32_t begin = (uint32_t)(mark - nodes->marks);
		nodes->changed[count++] = begin; /* all of the list has been read */
		at = nodes->end[begin];
		total += at - begin;
	}
	if (low < high)
		memset(nodes->marks + low, 0, high - low);
	*range_count = count;
	return total;
}

/* Lists the models of a range of the order as moved, and its figures as to be posed. True if there are any. */
static bool update_list_models(stilb_scene *scene, uint32_t begin, uint32_t end)
{
	const stilb_scene_edits *edits = scene->edits;
	bool any = false;
	for (uint32_t position = begin; position < end; position++) {
		uint32_t n = edits->nodes.order[position];
		uint32_t first = n == STILB_SCENE_NONE ? 0 : edits->nodes.first_model[n];
		uint32_t figure = n == STILB_SCENE_NONE ? 0 : edits->nodes.figure[n];
		if (figure)
			scene->figures->figures[figure - 1].posing = true;
		for (uint32_t m = first; m; m = edits->models[m - 1].next_on_node) {
			any = true;
			if (!edits->models[m - 1].hidden)
				scene_edit_moved(scene, m - 1);
		}
	}
	return any;
}

/* True if the node lies in one of the ranges, whose begins are in nodes->changed, in ascending order. */
static bool update_has_placed(const edit_nodes *nodes, uint32_t range_count, uint32_t node)
{
	uint32_t low = 0, high = range_count, position = nodes->position[node];
	while (low < high) { /* the first range that begins after the node */
		uint32_t middle = low + (high - low) / 2;
		if (nodes->changed[middle] <= position)
			low = middle + 1;
		else
			high = middle;
	}
	return low > 0 && position < nodes->end[nodes->changed[low - 1]];
}

/* Places the lights and cameras on nodes that were placed. */
static void update_mounts(stilb_scene *scene, uint32_t range_count)
{
	const edit_nodes *nodes = &scene->edits->nodes;
	const stilb_mat4 *places = scene->nodes.to_world;
	for (uint32_t i = 0; scene->light_mounts && i < scene->light_count; i++) {
		const stilb_scene_mount *mount = &scene->light_mounts[i];
		if (mount->node && update_has_placed(nodes, range_count, mount->node - 1))
			scene_mount_light(mount, &places[mount->node - 1], &scene->lights[i]);
	}
	for (uint32_t i = 0; scene->camera_mounts && i < scene->camera_count; i++) {
		const stilb_scene_mount *mount = &scene->camera_mounts[i];
		if (mount->node && update_has_placed(nodes, range_count, mount->node - 1))
			scene_mount_camera(mount, &places[mount->node - 1], &scene->cameras[i].camera);
	}
}

void scene_edit_update_places(stilb_scene *scene, stilb_job_pool *pool, uint32_t worker)
{
	edit_nodes *nodes = &scene->edits->nodes;
	if (nodes->changed_count == 0)
		return;
	PROFILE("scene nodes");
	uint32_t range_count;
	if (nodes->unordered || nodes->hole_count > nodes->order_count / 2)
		order_make(&scene->nodes, nodes);
	uint32_t total = update_find_ranges(nodes, &range_count);
	scene_edit_measure(scene);
	update u = {.scene = scene, .pool = pool, .worker = worker};
	for (uint32_t r = 0; r < range_count; r++) {
		uint32_t begin = nodes->changed[r], end = nodes->end[begin];
		if (pool && total >= UPDATE_ALONE)
			update_split(&u, begin, end);
		else
			for (uint32_t position = begin; position < end; position++)
				update_node(scene, position);
	}
	if (u.piece_count > 0)
		update_flush(&u);
	bool any = false;
	for (uint32_t r = 0; r < range_count; r++)
		any |= update_list_models(scene, nodes->changed[r], nodes->end[nodes->changed[r]]);
	scene->revisions.places += any;
	update_mounts(scene, range_count);
	nodes->changed_count = 0;
}

void stilb_scene_update_nodes(stilb_scene *scene, stilb_job_pool *pool, uint32_t worker)
{
	STILB_ASSERT(scene);
	if (scene->edits)
		scene_edit_update_places(scene, pool, worker);
	if (scene->figures)
		scene_play_pose(scene, pool, worker);
}
