#include "geometry/geometry_tree.h"

#include "geometry/geometry_internal.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define NONE UINT32_MAX
#define STACK (3 * GEOMETRY_TREE_LEVELS + 4)

typedef struct tree_build {
	geometry_tree *tree;
	const float *positions;
	size_t stride;
	const uint32_t *indices;
	geometry_keyed *keyed, *sorted;
	float lower[3], scale;
	uint32_t level;
} tree_build;

static const float *corner_of(const tree_build *b, uint32_t index)
{
	return (const float *)((const char *)b->positions + b->indices[index] * b->stride);
}

static void tree_key(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	const tree_build *b = context;
	for (uint32_t t = begin; t < end; t++) {
		uint32_t cell[3];
		for (int axis = 0; axis < 3; axis++) {
			float sum = 0.0f;
			for (uint32_t k = 0; k < 3; k++)
				sum += corner_of(b, 3 * t + k)[axis] - b->lower[axis];
			float at = sum * (1.0f / 3.0f) * b->scale;
			cell[axis] = at > 0.0f ? at < 1023.0f ? (uint32_t)at : 1023u : 0u;
		}
		b->keyed[t] = (geometry_keyed){geometry_morton(cell[0], cell[1], cell[2]), t};
	}
}

static void tree_gather(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	const tree_build *b = context;
	for (uint32_t t = begin; t < end; t++) {
		geometry_tree_triangle *out = &b->tree->triangles[t];
		out->id = b->sorted[t].value;
		for (uint32_t k = 0; k < 3; k++)
			memcpy(out->corner[k], corner_of(b, 3 * out->id + k), sizeof out->corner[k]);
	}
}

/* Unlike fminf and fmaxf, which are calls since they look for NaN. */
static inline float lesser(float a, float b)
{
	return a < b ? a : b;
}

static inline float larger(float a, float b)
{
	return a > b ? a : b;
}

/* The box of child c of a node of a level. False: there is no such child. */
static bool child_box(const geometry_tree *tree, uint32_t level, uint32_t child, float lower[3], float upper[3])
{
	for (int axis = 0; axis < 3; axis++) {
		lower[axis] = FLT_MAX;
		upper[axis] = -FLT_MAX;
	}
	if (level > 0) {
		if (child >= tree->sizes[level - 1])
			return false;
		const geometry_tree_node *node = &tree->levels[level - 1][child];
		for (int axis = 0; axis < 3; axis++)
			for (int k = 0; k < 4; k++) {
				lower[axis] = lesser(lower[axis], node->lower[axis][k]);
				upper[axis] = larger(upper[axis], node->upper[axis][k]);
			}
		return true;
	}
	if (child >= tree->count)
		return false;
	for (int k = 0; k < 3; k++)
		for (int axis = 0; axis < 3; axis++) {
			lower[axis] = lesser(lower[axis], tree->triangles[child].corner[k][axis]);
			upper[axis] = larger(upper[axis], tree->triangles[child].corner[k][axis]);
		}
	return true;
}

static void tree_boxes(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	const tree_build *b = context;
	for (uint32_t i = begin; i < end; i++) {
		geometry_tree_node *node = &b->tree->levels[b->level][i];
		for (uint32_t k = 0; k < 4; k++) {
			float lower[3], upper[3];
			bool is_there = child_box(b->tree, b->level, 4 * i + k, lower, upper);
			for (int axis = 0; axis < 3; axis++) {
				/* A child that is not there is nowhere: infinitely far from everything. */
				node->lower[axis][k] = is_there ? lower[axis] : FLT_MAX;
				node->upper[axis][k] = is_there ? upper[axis] : -FLT_MAX;
			}
		}
	}
}

bool geometry_tree_create(const float *positions, size_t stride, const uint32_t *indices, uint32_t triangle_count,
                          stilb_job_pool *pool, uint32_t worker, geometry_tree *tree)
{
	*tree = (geometry_tree){.count = triangle_count};
	tree_build b = {.tree = tree, .positions = positions, .stride = stride, .indices = indices};
	if (triangle_count == 0)
		return true;
	tree->triangles = stilb_memory_alloc(triangle_count, sizeof *tree->triangles);
	b.keyed = stilb_memory_alloc(triangle_count, 2 * sizeof *b.keyed);
	uint32_t children = triangle_count;
	bool made = tree->triangles && b.keyed;
	do {
		children = (children + 3) / 4;
		tree->sizes[tree->level_count] = children;
		tree->levels[tree->level_count] = stilb_memory_alloc(children, sizeof **tree->levels);
		made = made && tree->levels[tree->level_count];
		tree->level_count++;
	} while (children > 1);
	float upper[3] = {-FLT_MAX, -FLT_MAX, -FLT_MAX}, extent = 0.0f;
	b.lower[0] = b.lower[1] = b.lower[2] = FLT_MAX;
	for (uint32_t i = 0; i < 3 * triangle_count; i++)
		for (int axis = 0; axis < 3; axis++) {
			b.lower[axis] = lesser(b.lower[axis], corner_of(&b, i)[axis]);
			upper[axis] = larger(upper[axis], corner_of(&b, i)[axis]);
		}
	for (int axis = 0; axis < 3; axis++)
		extent = larger(extent, upper[axis] - b.lower[axis]);
	b.scale = extent > 0.0f ? 1023.0f / extent : 0.0f;
	if (made) {
		geometry_for(pool, worker, triangle_count, 8192, tree_key, &b);
		made = geometry_sort(pool, worker, b.keyed, b.keyed + triangle_count, triangle_count, 30, &b.sorted);
	}
	if (made) {
		geometry_for(pool, worker, triangle_count, 8192, tree_gather, &b);
		for (b.level = 0; b.level < tree->level_count; b.level++)
			geometry_for(pool, worker, tree->sizes[b.level], 1024, tree_boxes, &b);
	}
	free(b.keyed);
	if (!made)
		geometry_tree_finish(tree);
	return made;
}

void geometry_tree_finish(geometry_tree *tree)
{
	free(tree->triangles);
	for (uint32_t level = 0; level < tree->level_count; level++)
		free(tree->levels[level]);
	*tree = (geometry_tree){0};
}

/* ---- distances --------------------------------------------------------------------------------------------------- */

typedef struct tree_vector {
	double x, y, z;
} tree_vector;

static inline tree_vector vector_of(const float p[3])
{
	return (tree_vector){(double)p[0], (double)p[1], (double)p[2]};
}

static inline double dot_of(tree_vector a, tree_vector b)
{
	return a.x * b.x + a.y * b.y + a.z * b.z;
}

/* a - t b */
static inline tree_vector without(tree_vector a, double t, tree_vector b)
{
	return (tree_vector){a.x - t * b.x, a.y - t * b.y, a.z - t * b.z};
}

static inline geometry_nearest nearest_at(tree_vector d, double u, double v)
{
	return (geometry_nearest){.square = (float)dot_of(d, d), .at = {(float)u, (float)v}};
}

/* The nearest point of a triangle. Source: Ericson, "Real-Time Collision Detection", 2005, 5.1.5. In double: of a
 * needle that is a hundred times as long as wide, products of floats leave no digits. */
static geometry_nearest triangle_nearest(const geometry_tree_triangle *triangle, stilb_vec3 point)
{
	const float at[3] = {point[0], point[1], point[2]};
	tree_vector a = vector_of(triangle->corner[0]), ap = without(vector_of(at), 1.0, a);
	tree_vector ab = without(vector_of(triangle->corner[1]), 1.0, a);
	tree_vector ac = without(vector_of(triangle->corner[2]), 1.0, a);
	double d1 = dot_of(ab, ap), d2 = dot_of(ac, ap);
	if (d1 <= 0.0 && d2 <= 0.0)
		return nearest_at(ap, 0.0, 0.0);
	tree_vector bp = without(ap, 1.0, ab);
	double d3 = dot_of(ab, bp), d4 = dot_of(ac, bp);
	if (d3 >= 0.0 && d4 <= d3)
		return nearest_at(bp, 1.0, 0.0);
	double vc = d1 * d4 - d3 * d2;
	if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) {
		double v = d1 - d3 > 0.0 ? d1 / (d1 - d3) : 0.0;
		return nearest_at(without(ap, v, ab), v, 0.0);
	}
	tree_vector cp = without(ap, 1.0, ac);
	double d5 = dot_of(ab, cp), d6 = dot_of(ac, cp);
	if (d6 >= 0.0 && d5 <= d6)
		return nearest_at(cp, 0.0, 1.0);
	double vb = d5 * d2 - d1 * d6;
	if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
		double w = d2 - d6 > 0.0 ? d2 / (d2 - d6) : 0.0;
		return nearest_at(without(ap, w, ac), 0.0, w);
	}
	double va = d3 * d6 - d5 * d4;
	if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
		double sum = (d4 - d3) + (d5 - d6), w = sum > 0.0 ? (d4 - d3) / sum : 0.0;
		return nearest_at(without(bp, w, without(ac, 1.0, ab)), 1.0 - w, w);
	}
	double inverse = 1.0 / (va + vb + vc), v = vb * inverse, w = vc * inverse;
	return nearest_at(without(without(ap, v, ab), w, ac), v, w);
}

typedef int32_t tree_mask __attribute__((vector_size(16)));

/* The lanes above 0, and 0 in place of the others. */
static stilb_vec4 positive(stilb_vec4 v)
{
	return (stilb_vec4)((tree_mask)v & (v > 0.0f));
}

/* The squared distances of a point from four boxes. */
static stilb_vec4 box_distances(const geometry_tree_node *node, stilb_vec3 p)
{
	stilb_vec4 sum = {0};
	for (int axis = 0; axis < 3; axis++) {
		stilb_vec4 at = {p[axis], p[axis], p[axis], p[axis]};
		stilb_vec4 d = positive(node->lower[axis] - at) + positive(at - node->upper[axis]); /* one of them is 0 */
		sum += d * d;
	}
	return sum;
}

typedef struct tree_entry {
	uint32_t level, node;
	float square;
} tree_entry;

/* Makes a triangle the best one if it is nearer. */
static void try_triangle(const geometry_tree *tree, uint32_t triangle, stilb_vec3 point, geometry_nearest *best)
{
	geometry_nearest at = triangle_nearest(&tree->triangles[triangle], point);
	if (at.square < best->square) {
		*best = at;
		best->triangle = triangle;
	}
}

geometry_nearest geometry_tree_nearest(const geometry_tree *tree, stilb_vec3 point, float limit, float enough,
                                       uint32_t hint)
{
	geometry_nearest best = {.square = limit, .triangle = NONE};
	if (tree->count == 0)
		return best;
	if (hint != NONE)
		try_triangle(tree, hint, point, &best);
	tree_entry stack[STACK];
	uint32_t depth = 0;
	stack[depth++] = (tree_entry){tree->level_count - 1, 0, 0.0f};
	while (depth > 0 && best.square > enough) {
		tree_entry entry = stack[--depth];
		if (entry.square >= best.square)
			continue;
		stilb_vec4 square = box_distances(&tree->levels[entry.level][entry.node], point);
		/* The nearest last, so that it comes next. */
		uint32_t order[4], count = 0;
		for (uint32_t k = 0; k < 4; k++) {
			if (!(square[k] < best.square))
				continue;
			uint32_t at = count++;
			for (; at > 0 && square[order[at - 1]] < square[k]; at--)
				order[at] = order[at - 1];
			order[at] = k;
		}
		if (entry.level > 0) {
			for (uint32_t i = 0; i < count; i++)
				stack[depth++] = (tree_entry){entry.level - 1, 4 * entry.node + order[i], square[order[i]]};
			continue;
		}
		for (uint32_t i = count; i-- > 0;)
			if (square[order[i]] < best.square)
				try_triangle(tree, 4 * entry.node + order[i], point, &best);
	}
	return best;
}

void geometry_tree_within(const geometry_tree *tree, stilb_vec3 point, float square,
                          void (*visit)(const geometry_tree_triangle *triangle, const geometry_nearest *at, void *user),
                          void *user)
{
	if (tree->count == 0)
		return;
	tree_entry stack[STACK];
	uint32_t depth = 0;
	stack[depth++] = (tree_entry){tree->level_count - 1, 0, 0.0f};
	while (depth > 0) {
		tree_entry entry = stack[--depth];
		stilb_vec4 boxes = box_distances(&tree->levels[entry.level][entry.node], point);
		for (uint32_t k = 4; k-- > 0;) {
			uint32_t child = 4 * entry.node + k;
			if (!(boxes[k] <= square))
				continue;
			if (entry.level > 0) {
				stack[depth++] = (tree_entry){entry.level - 1, child, boxes[k]};
				continue;
			}
			geometry_nearest at = triangle_nearest(&tree->triangles[child], point);
			at.triangle = child;
			if (at.square <= square)
				visit(&tree->triangles[child], &at, user);
		}
	}
}
