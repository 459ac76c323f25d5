/* Levels of a mesh, one after the other, each from the one before it. */
#include "geometry/geometry_internal.h"
#include "geometry/geometry_plan.h"
#include "geometry/geometry_tree.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

#define NONE UINT32_MAX
#define PROGRESS 0.85f /* a level with more of the finer one's triangles is not worth its memory */
/* Triangles of a mesh with which all of its levels are compared. Finer levels are compared with the next one each, and
 * their errors add up. */
#define COMPARED_MOST 262144u

/* The levels on their way. Level 0 is the mesh itself, without triangles that cannot be seen. */
typedef struct chain {
	const stilb_geometry_mesh *view;
	stilb_job_pool *pool;
	uint32_t worker;
	uint32_t count;                                /* levels beside 0 */
	uint32_t *indices[STILB_SCENE_MAX_LEVELS + 1]; /* of level l, vertices of the mesh as it was */
	uint32_t *all;                                 /* [view->index_count] of the mesh, ordered */
	uint32_t index_count[STILB_SCENE_MAX_LEVELS + 1];
	float error[STILB_SCENE_MAX_LEVELS + 1];
	uint8_t *last;      /* [vertex_count] 1 + the last level that uses a vertex; 0: none does */
	uint32_t *to;       /* [vertex_count] the vertex where it goes then */
	geometry_tree tree; /* of the level that others are compared with */
	uint32_t compared;  /* which that is */
} chain;

static void chain_finish(chain *c)
{
	for (uint32_t l = 0; l <= STILB_SCENE_MAX_LEVELS; l++)
		free(c->indices[l]);
	free(c->all);
	free(c->last);
	free(c->to);
	geometry_tree_finish(&c->tree);
}

/* The vertex onto which v was moved so far; shortens the way for the next one who asks. */
static uint32_t root_of(uint32_t *target, uint32_t v)
{
	uint32_t root = v;
	while (target[root] != root)
		root = target[root];
	while (target[v] != root) {
		uint32_t next = target[v];
		target[v] = root;
		v = next;
	}
	return root;
}

/* Keeps the triangles of `work` as the next level. False: no memory. */
static bool chain_keep(chain *c, uint32_t level, geometry_work *work)
{
	c->indices[level] = stilb_memory_alloc(work->count, sizeof *work->triangles);
	if (!c->indices[level])
		return false;
	c->index_count[level] = 3 * work->count;
	memcpy(c->indices[level], work->triangles, work->count * sizeof *work->triangles);
	for (uint32_t i = 0; i < c->index_count[level]; i++)
		c->last[c->indices[level][i]] = (uint8_t)(level + 1);
	for (uint32_t v = 0; level > 0 && v < c->view->vertex_count; v++)
		if (c->last[v] == level)
			c->to[v] = root_of(work->target, v);
	return level == 0 || geometry_order(c->view, c->indices[level], c->index_count[level]);
}

/* Measures the error of a level. False: no memory. */
static bool chain_measure(chain *c, uint32_t level)
{
	geometry_tree tree;
	if (!geometry_tree_create(c->view->positions, c->view->position_stride, c->indices[level],
	                          c->index_count[level] / 3, c->pool, c->worker, &tree))
		return false;
	float distance = 0.0f;
	geometry_side finer = {c->view, c->indices[c->compared], &c->tree}, own = {c->view, c->indices[level], &tree};
	bool made = level == 0 || geometry_distance(&finer, &own, c->pool, c->worker, &distance);
	if (level > 0) {
		float sum = c->error[c->compared] + distance;
		c->error[level] = sum > c->error[level - 1] ? sum : c->error[level - 1];
	}
	if (level == 0 || c->tree.count > COMPARED_MOST) {
		geometry_tree_finish(&c->tree);
		c->tree = tree;
		c->compared = level;
	} else
		geometry_tree_finish(&tree);
	return made;
}

static stilb_result chain_make(chain *c, const stilb_geometry_levels_desc *desc)
{
	geometry_work work;
	stilb_result result = geometry_work_create(c->view, c->pool, c->worker, &work);
	if (result != STILB_OK)
		return result;
	c->last = calloc(c->view->vertex_count + 1u, sizeof *c->last);
	c->to = stilb_memory_alloc(c->view->vertex_count, sizeof *c->to);
	c->all = stilb_memory_alloc(c->view->index_count, sizeof *c->all);
	bool made = c->last && c->to && c->all;
	if (made) {
		memcpy(c->all, c->view->indices, c->view->index_count * sizeof *c->all);
		made = geometry_order(c->view, c->all, c->view->index_count);
	}
	made = made && chain_keep(c, 0, &work) && chain_measure(c, 0);
	while (made && result == STILB_OK && c->count < STILB_SCENE_MAX_LEVELS && work.count > desc->least) {
		uint32_t before = work.count, target = (uint32_t)((float)before * desc->ratio);
		result = geometry_work_reduce(&work, target > 0 ? target : 1, FLT_MAX);
		if (result == STILB_OK && desc->give_up && desc->give_up(desc->user))
			result = stilb_fail(STILB_ERROR_GIVEN_UP, "the levels of a mesh of %u triangles were given up",
			                    c->view->index_count / 3);
		if (result != STILB_OK || work.count == 0 || (float)work.count > PROGRESS * (float)before)
			break;
		made = chain_keep(c, c->count + 1, &work) && chain_measure(c, c->count + 1);
		c->count++;
	}
	geometry_work_finish(&work);
	if (result != STILB_OK)
		return result;
	return made ? STILB_OK
	            : stilb_fail(STILB_ERROR_MEMORY, "no memory for the levels of a mesh of %u triangles",
	                         c->view->index_count / 3);
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

/* Numbers vertices: those of the coarsest level first, in the order of their use, then what the next one adds.
 * counts[l] becomes the vertices up to level l. */
static void chain_number(const chain *c, uint32_t *number, uint32_t counts[STILB_SCENE_MAX_LEVELS + 1])
{
	uint32_t next = 0, vertex_count = c->view->vertex_count;
	memset(number, 0xff, vertex_count * sizeof *number);
	for (uint32_t l = c->count + 1; l-- > 0;) {
		const uint32_t *indices = l > 0 ? c->indices[l] : c->all;
		uint32_t count = l > 0 ? c->index_count[l] : c->view->index_count;
		for (uint32_t i = 0; i < count; i++)
			if (number[indices[i]] == NONE)
				number[indices[i]] = next++;
		counts[l] = next;
	}
	for (uint32_t v = 0; v < vertex_count; v++)
		if (number[v] == NONE)
			number[v] = next++;
}

static void write_plan(const chain *c, const uint32_t *number, const uint32_t *counts, geometry_plan *plan)
{
	uint32_t first = 0;
	for (uint32_t l = 1; l <= c->count; l++) {
		plan->levels[l - 1] = (stilb_scene_level){
			.first_index = first, .index_count = c->index_count[l], .vertex_count = counts[l], .error = c->error[l]};
		for (uint32_t i = 0; i < c->index_count[l]; i++)
			plan->level_indices[first++] = number[c->indices[l][i]];
	}
	for (uint32_t i = 0; i < plan->index_count; i++)
		plan->indices[i] = number[c->all[i]];
	for (uint32_t v = 0; v < plan->vertex_count; v++) {
		bool moves = c->last[v] > 0 && c->last[v] <= c->count; /* not what all levels use, nor what no triangle uses */
		plan->order[number[v]] = v;
		plan->to[number[v]] = moves ? c->to[v] : v;
	}
}

/* What the chain has found, as a plan. False: no memory. */
static bool chain_plan(const chain *c, geometry_plan *plan)
{
	uint32_t counts[STILB_SCENE_MAX_LEVELS + 1];
	*plan = (geometry_plan){.level_count = c->count};
	if (c->count == 0)
		return true;
	plan->vertex_count = c->view->vertex_count;
	plan->index_count = c->view->index_count;
	for (uint32_t l = 1; l <= c->count; l++)
		plan->level_index_count += c->index_count[l];
	uint32_t *number = stilb_memory_alloc(plan->vertex_count, sizeof *number);
	bool made = number && geometry_plan_allocate(plan);
	if (made) {
		chain_number(c, number, counts);
		write_plan(c, number, counts, plan);
	}
	free(number);
	return made;
}

/* ---- the whole --------------------------------------------------------------------------------------------------- */

/* stilb_geometry_stream.weight of what stilb_scene_vertex_extra has. */
#define CHAIN_COLOR_WEIGHT 0.15f
#define CHAIN_UV_WEIGHT 0.1f

uint32_t geometry_streams_of(const stilb_scene_streams *table, const void *vertices, const float *weights,
                             stilb_geometry_stream out[STILB_GEOMETRY_STREAMS])
{
	static const stilb_geometry_kind kinds[] = {
		[STILB_SCENE_STREAM_DIRECTION] = STILB_GEOMETRY_DIRECTION,
		[STILB_SCENE_STREAM_TEXTURE] = STILB_GEOMETRY_TEXTURE,
		[STILB_SCENE_STREAM_VALUE] = STILB_GEOMETRY_VALUE,
	};
	STILB_ASSERT(table->count >= 1 && table->count <= STILB_GEOMETRY_STREAMS + 1);
	for (uint32_t s = 1; s < table->count; s++) {
		const stilb_scene_stream *stream = &table->streams[s];
		STILB_ASSERT(stream->kind != STILB_SCENE_STREAM_POSITION);
		out[s - 1] = (stilb_geometry_stream){
			.name = stream->name,
			.kind = kinds[stream->kind],
			.components = stream->components,
			.weight = weights[s],
			.seam = stream->seam,
			.values = vertices ? (const float *)((const char *)vertices + stream->offset) : NULL,
			.stride = table->size,
		};
	}
	return table->count - 1;
}

/* Adds colours and second uv of vertices, where they differ. Returns how many streams there are then. */
static uint32_t view_extras(const stilb_scene_mesh *mesh, stilb_geometry_stream *streams, uint32_t count)
{
	const stilb_scene_vertex_extra *extras = mesh->extras;
	bool colors = false, uvs = false;
	for (uint32_t v = 1; v < mesh->vertex_count && !(colors && uvs); v++) {
		colors |= memcmp(extras[v].color, extras[0].color, sizeof extras->color) != 0;
		uvs |= memcmp(extras[v].uv, extras[0].uv, sizeof extras->uv) != 0;
	}
	STILB_ASSERT(count + 2 <= STILB_GEOMETRY_STREAMS);
	stilb_geometry_stream color = {"color",       STILB_GEOMETRY_VALUE, 4, CHAIN_COLOR_WEIGHT, true,
	                               extras->color, sizeof *extras};
	stilb_geometry_stream uv = {"uv 2", STILB_GEOMETRY_TEXTURE, 2, CHAIN_UV_WEIGHT, true, extras->uv, sizeof *extras};
	if (colors)
		streams[count++] = color;
	if (uvs)
		streams[count++] = uv;
	return count;
}

stilb_geometry_mesh geometry_view_of(const stilb_scene_mesh *mesh, const stilb_geometry_levels_desc *desc,
                                     stilb_geometry_stream streams[STILB_GEOMETRY_STREAMS])
{
	uint32_t count = geometry_streams_of(&stilb_scene_vertex_streams, mesh->vertices, desc->weights, streams);
	if (mesh->extras && mesh->vertex_count > 0)
		count = view_extras(mesh, streams, count);
	return (stilb_geometry_mesh){
		.vertex_count = mesh->vertex_count,
		.index_count = mesh->index_count,
		.indices = mesh->indices,
		.positions = mesh->vertices ? mesh->vertices->position : NULL,
		.position_stride = sizeof *mesh->vertices,
		.stream_count = count,
		.streams = streams,
		.locked = desc->locked,
	};
}

stilb_result geometry_chain_make(const stilb_scene_mesh *mesh, const stilb_geometry_levels_desc *desc,
                                 stilb_job_pool *pool, uint32_t worker, geometry_plan *plan)
{
	*plan = (geometry_plan){0};
	stilb_geometry_stream streams[STILB_GEOMETRY_STREAMS];
	stilb_geometry_mesh view = geometry_view_of(mesh, desc, streams);
	chain c = {.view = &view, .pool = pool, .worker = worker};
	stilb_result result = STILB_OK;
	if (mesh->index_count / 3 > desc->least)
		result = chain_make(&c, desc);
	if (result == STILB_OK && !chain_plan(&c, plan))
		result =
			stilb_fail(STILB_ERROR_MEMORY, "no memory for the levels of a mesh of %u triangles", mesh->index_count / 3);
	chain_finish(&c);
	return result;
}
