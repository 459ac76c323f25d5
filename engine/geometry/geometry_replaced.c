/* How far a few thousand triangles are from the coarser ones that replaced them. All vertices of the coarser ones are
 * vertices of the finer ones, so that what is new are edges and what they span. Of two such surfaces that lie along one
 * another the distance is largest at a vertex that is gone, or where an edge that is new crosses one that is gone: all
 * of these vertices are looked at, and points on edges, more of them about the farthest point of an edge where that is
 * far. Where a triangle spans a hollow it may be larger inside: points there are looked at, too. */
#include "geometry/geometry_clusters.h"
#include "geometry/geometry_tree.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define NONE UINT32_MAX
#define NEARLY 0.75f /* of the farthest distance: what is looked at closer */
#define DENSEST 64u  /* parts of an edge, at most */
#define INSIDE 8u    /* parts of the sides of the grid inside of a triangle, at most, at first */
#define CLOSER 12u   /* the same at the second look */
#define HALVINGS 3   /* of the distance between the points about the farthest one */

typedef struct replaced_edge {
	stilb_vec3 from, along;
	float place, farthest; /* the farthest point: from + place along; metres */
	uint32_t parts, hint;
} replaced_edge;

typedef struct replaced_work {
	const geometry_replaced *in;
	geometry_tree finer, coarser;
	uint64_t *keys; /* [mask + 1] edges as two positions; 0: free */
	uint32_t mask;
	replaced_edge *edges;
	uint32_t edge_count;
	float spacing, farthest; /* metres */
} replaced_work;

static stilb_vec3 place_of(const replaced_work *w, uint32_t vertex)
{
	const float *at = geometry_position(w->in->mesh, vertex);
	return stilb_vec3_make(at[0], at[1], at[2]);
}

/* How far a point is from a surface, metres, or that it is nearer than what counts. */
static float look_from(replaced_work *w, const geometry_tree *tree, stilb_vec3 point, uint32_t *hint)
{
	float enough = NEARLY * NEARLY * w->farthest * w->farthest;
	geometry_nearest nearest = geometry_tree_nearest(tree, point, FLT_MAX, enough, *hint);
	*hint = nearest.triangle;
	float distance = sqrtf(nearest.square);
	w->farthest = distance > w->farthest ? distance : w->farthest;
	return distance;
}

/* Into how many parts a side of this squared length is divided, at most `most`, by points that are so many times as far
 * from each other as the finer vertices. */
static uint32_t parts_of(const replaced_work *w, float square, float times, uint32_t most)
{
	float parts = ceilf(sqrtf(square) / (times * w->spacing));
	return parts < (float)most ? (uint32_t)parts : most;
}

/* ---- edges ------------------------------------------------------------------------------------------------------- */

/* Notes an edge. False: it was there. */
static bool note_edge(replaced_work *w, uint32_t a, uint32_t b)
{
	uint64_t low = w->in->canonical[a], high = w->in->canonical[b];
	uint64_t key = 1 + (low < high ? low << 32 | high : high << 32 | low);
	for (uint32_t i = (uint32_t)(key * 0x9e3779b97f4a7c15u >> 32) & w->mask;; i = (i + 1) & w->mask) {
		if (w->keys[i] == key)
			return false;
		if (w->keys[i] == 0) {
			w->keys[i] = key;
			return true;
		}
	}
}

/* Lists the edges that are new. */
static void list_edges(replaced_work *w)
{
	const geometry_replaced *in = w->in;
	for (uint32_t t = 0; t < in->finer_count; t++)
		for (uint32_t k = 0; k < 3; k++)
			note_edge(w, in->finer[t][k], in->finer[t][(k + 1) % 3]);
	for (uint32_t t = 0; t < in->coarser_count; t++)
		for (uint32_t k = 0; k < 3; k++) {
			uint32_t a = in->coarser[t][k], b = in->coarser[t][(k + 1) % 3];
			if (!note_edge(w, a, b))
				continue;
			stilb_vec3 from = place_of(w, a), along = place_of(w, b) - from;
			uint32_t parts = parts_of(w, stilb_vec3_dot(along, along), 1.0f, DENSEST);
			w->edges[w->edge_count++] = (replaced_edge){
				.from = from, .along = along, .parts = parts > 2 ? parts : 2, .place = 0.5f, .hint = NONE};
		}
}

static void look_at_place(replaced_work *w, replaced_edge *edge, float place)
{
	float distance = look_from(w, &w->finer, edge->from + edge->along * place, &edge->hint);
	if (distance > edge->farthest) {
		edge->farthest = distance;
		edge->place = place;
	}
}

static void look_at_edges(replaced_work *w)
{
	uint32_t hint = NONE;
	for (uint32_t i = 0; i < w->edge_count; i++) {
		replaced_edge *edge = &w->edges[i];
		edge->hint = hint;
		for (uint32_t n = 1; n < edge->parts; n++)
			look_at_place(w, edge, (float)n / (float)edge->parts);
		hint = edge->hint;
	}
	for (uint32_t i = 0; i < w->edge_count; i++) {
		replaced_edge *edge = &w->edges[i];
		float step = 0.5f / (float)edge->parts;
		for (int n = 0; n < HALVINGS && edge->farthest >= NEARLY * w->farthest; n++, step *= 0.5f) {
			float middle = edge->place;
			look_at_place(w, edge, middle - step);
			look_at_place(w, edge, middle + step);
		}
	}
}

/* ---- triangles --------------------------------------------------------------------------------------------------- */

/* Points of a grid inside of a triangle, without its sides. */
static float look_inside(replaced_work *w, const geometry_tree *tree, const stilb_vec3 corner[3], uint32_t parts,
                         uint32_t *hint)
{
	float farthest = look_from(w, tree, (corner[0] + corner[1] + corner[2]) * (1.0f / 3.0f), hint);
	stilb_vec3 side = (corner[1] - corner[0]) * (1.0f / (float)parts),
			   other = (corner[2] - corner[0]) * (1.0f / (float)parts);
	for (uint32_t i = 1; i < parts && parts > 3; i++)
		for (uint32_t j = 1; i + j < parts; j++)
			farthest = fmaxf(farthest, look_from(w, tree, corner[0] + side * (float)i + other * (float)j, hint));
	return farthest;
}

/* Of the sides of a triangle the longest one, squared. */
static float longest_square(const stilb_vec3 corner[3])
{
	float longest = 0.0f;
	for (int k = 0; k < 3; k++) {
		stilb_vec3 side = corner[(k + 1) % 3] - corner[k];
		float square = stilb_vec3_dot(side, side);
		longest = square > longest ? square : longest;
	}
	return longest;
}

static void corners_of(const replaced_work *w, const uint32_t vertex[3], stilb_vec3 corner[3])
{
	for (uint32_t k = 0; k < 3; k++)
		corner[k] = place_of(w, vertex[k]);
}

/* Large triangles of the coarser surface. What the others span are finer vertices, which have been looked at. */
static void look_at_triangles(replaced_work *w)
{
	const geometry_replaced *in = w->in;
	stilb_vec3 corner[3];
	uint32_t hint = NONE;
	for (uint32_t t = 0; t < in->coarser_count; t++) {
		corners_of(w, in->coarser[t], corner);
		uint32_t parts = parts_of(w, longest_square(corner), 3.0f, INSIDE);
		if (parts < 2)
			continue;
		float farthest = look_inside(w, &w->finer, corner, parts, &hint);
		if (farthest >= NEARLY * w->farthest)
			look_inside(w, &w->finer, corner, CLOSER, &hint);
	}
}

/* The finer triangles' vertices tell where they are, but for large ones. */
static void look_back(replaced_work *w)
{
	const geometry_replaced *in = w->in;
	stilb_vec3 corner[3];
	uint32_t hint = NONE;
	for (uint32_t i = 0; i < in->gone_count; i++)
		look_from(w, &w->coarser, place_of(w, in->gone[i]), &hint);
	for (uint32_t t = 0; t < in->finer_count; t++) {
		corners_of(w, in->finer[t], corner);
		uint32_t parts = parts_of(w, longest_square(corner), 3.0f, DENSEST);
		if (parts < 2)
			continue;
		look_inside(w, &w->coarser, corner, parts < INSIDE ? parts : INSIDE, &hint);
		for (uint32_t k = 0; k < 3; k++)
			for (uint32_t n = 1; n < parts; n++)
				look_from(w, &w->coarser, corner[k] + (corner[(k + 1) % 3] - corner[k]) * ((float)n / (float)parts),
				          &hint);
	}
}

/* ---- the whole --------------------------------------------------------------------------------------------------- */

static void measure_space(replaced_work *w, float *reach)
{
	double area = 0.0;
	stilb_vec3 corner[3];
	*reach = 0.0f;
	for (uint32_t t = 0; t < w->in->finer_count; t++) {
		corners_of(w, w->in->finer[t], corner);
		stilb_vec3 n = stilb_vec3_cross(corner[1] - corner[0], corner[2] - corner[0]);
		area += 0.5 * (double)sqrtf(stilb_vec3_dot(n, n));
		for (int axis = 0; axis < 3; axis++)
			*reach = fabsf(corner[0][axis]) > *reach ? fabsf(corner[0][axis]) : *reach;
	}
	float spacing = (float)sqrt(2.0 * area / w->in->finer_count);
	w->spacing = spacing > FLT_MIN ? spacing : 1.0f;
}

static bool replaced_allocate(replaced_work *w)
{
	const geometry_replaced *in = w->in;
	uint32_t capacity = 64;
	while (capacity < 4 * (in->finer_count + in->coarser_count))
		capacity *= 2;
	w->mask = capacity - 1;
	w->keys = calloc(capacity, sizeof *w->keys);
	w->edges = stilb_memory_alloc(3 * (size_t)in->coarser_count, sizeof *w->edges);
	const float *positions = in->mesh->positions;
	size_t stride = in->mesh->position_stride;
	return w->keys && w->edges &&
	       geometry_tree_create(positions, stride, in->finer[0], in->finer_count, NULL, 0, &w->finer) &&
	       geometry_tree_create(positions, stride, in->coarser[0], in->coarser_count, NULL, 0, &w->coarser);
}

bool geometry_replaced_distance(const geometry_replaced *replaced, float *bound)
{
	replaced_work w = {.in = replaced};
	float reach;
	bool made = replaced_allocate(&w);
	if (made) {
		measure_space(&w, &reach);
		list_edges(&w);
		look_back(&w);
		look_at_edges(&w);
		look_at_triangles(&w);
		*bound = 1.06f * w.farthest + 1e-6f * reach;
	}
	free(w.keys);
	free(w.edges);
	geometry_tree_finish(&w.finer);
	geometry_tree_finish(&w.coarser);
	return made;
}
