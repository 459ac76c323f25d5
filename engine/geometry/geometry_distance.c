/* How far two surfaces are from each other. Where the distance of two surfaces of triangles that lie along one another
 * is largest, there is a vertex of one of them or two edges cross; where one spans a hollow of the other, it may be
 * anywhere. All vertices are looked at, and points on the edges and inside of triangles that are as close as the finer
 * one's vertices, closer where the distance is large. */
#include "geometry/geometry_internal.h"
#include "geometry/geometry_tree.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define NONE UINT32_MAX
#define CHUNK 512u   /* points or triangles of a job */
#define FIRST 32u    /* one point of this many tells how far the others need to be looked at */
#define DENSEST 64u  /* parts of an edge, at most, at first */
#define INSIDE 8u    /* the same of the grid inside of a triangle */
#define MANY 16384u  /* triangles of a surface whose vertices tell where it is, but for its large triangles */
#define CLOSER 6u    /* times as many where a point is nearly as far as the farthest */
#define NEARLY 0.75f /* of the farthest distance: what is looked at closer */

typedef struct distance {
	const geometry_side *from, *to;
	const uint32_t *points; /* [count] vertices; NULL: the edges of `from` */
	uint32_t count;
	float spacing;      /* metres between points of edges */
	bool large_alone;   /* triangles whose sides are no longer than that are left to their vertices */
	uint32_t step;      /* every `step`-th point or triangle is looked at */
	float enough;       /* m^2: nobody asks whether a point is still nearer than this */
	float closer;       /* metres: triangles with points as far as this are looked at closer; 0: the first look */
	float *of_triangle; /* [count] metres, of edges */
	float *farthest;    /* [chunk] m^2 */
} distance;

static stilb_vec3 corner(const geometry_tree_triangle *triangle, int k)
{
	return stilb_vec3_make(triangle->corner[k][0], triangle->corner[k][1], triangle->corner[k][2]);
}

static float look(const distance *d, stilb_vec3 point, uint32_t *hint)
{
	geometry_nearest nearest = geometry_tree_nearest(d->to->tree, point, FLT_MAX, d->enough, *hint);
	*hint = nearest.triangle;
	return nearest.square;
}

static float longest_side(const stilb_vec3 corners[3])
{
	float longest = 0.0f;
	for (int k = 0; k < 3; k++) {
		stilb_vec3 side = corners[(k + 1) % 3] - corners[k];
		longest = fmaxf(longest, stilb_vec3_dot(side, side));
	}
	return sqrtf(longest);
}

/* Points on the sides of a triangle and inside, where it may span a hollow; with `densely` more of them. m^2. */
static float look_at_triangle(const distance *d, const geometry_tree_triangle *triangle, bool densely, uint32_t *hint)
{
	stilb_vec3 corners[3] = {corner(triangle, 0), corner(triangle, 1), corner(triangle, 2)};
	if (d->large_alone && longest_side(corners) <= d->spacing)
		return 0.0f;
	float farthest = look(d, (corners[0] + corners[1] + corners[2]) * (1.0f / 3.0f), hint), longest = 1.0f;
	for (int k = 0; k < 3; k++) {
		stilb_vec3 from = corners[k], side = corners[(k + 1) % 3] - from;
		float parts = ceilf(sqrtf(stilb_vec3_dot(side, side)) / d->spacing);
		parts = fminf(fmaxf(parts, 2.0f), (float)DENSEST) * (densely ? (float)CLOSER : 1.0f);
		longest = fmaxf(longest, parts);
		for (int i = 1; i < (int)parts; i++)
			farthest = fmaxf(farthest, look(d, from + side * ((float)i / parts), hint));
	}
	float n = fminf(longest, densely ? (float)DENSEST : (float)INSIDE);
	stilb_vec3 x = (corners[1] - corners[0]) * (1.0f / n), y = (corners[2] - corners[0]) * (1.0f / n);
	for (int i = 1; i < (int)n; i++)
		for (int j = 1; i + j < (int)n; j++)
			farthest = fmaxf(farthest, look(d, corners[0] + x * (float)i + y * (float)j, hint));
	return farthest;
}

static void look_at_chunks(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	const distance *d = context;
	for (uint32_t chunk = begin; chunk < end; chunk++) {
		uint32_t hint = NONE, last = d->count - chunk * CHUNK < CHUNK ? d->count : (chunk + 1) * CHUNK;
		float farthest = 0.0f;
		for (uint32_t i = chunk * CHUNK; i < last; i += d->step) {
			if (d->points) {
				const float *at = geometry_position(d->from->mesh, d->points[i]);
				farthest = fmaxf(farthest, look(d, stilb_vec3_make(at[0], at[1], at[2]), &hint));
				continue;
			}
			if (d->closer > 0.0f && d->of_triangle[i] < d->closer)
				continue;
			float square = look_at_triangle(d, &d->from->tree->triangles[i], d->closer > 0.0f, &hint);
			farthest = fmaxf(farthest, square);
			d->of_triangle[i] = sqrtf(square);
		}
		d->farthest[chunk] = farthest;
	}
}

/* One way, from points or from edges; *farthest grows, metres. False: no memory. */
static bool distance_one_way(distance d, stilb_job_pool *pool, uint32_t worker, float *farthest)
{
	uint32_t chunks = (d.count + CHUNK - 1) / CHUNK;
	d.farthest = stilb_memory_alloc(chunks, sizeof *d.farthest);
	d.of_triangle = d.points ? NULL : stilb_memory_alloc(d.count, sizeof *d.of_triangle);
	bool made = d.farthest && (d.points || d.of_triangle);
	for (uint32_t pass = 0; made && pass < (d.points ? 2u : 3u); pass++) {
		d.step = pass == 0 ? FIRST : 1;
		d.closer = pass == 2 ? fmaxf(NEARLY * *farthest, FLT_MIN) : 0.0f;
		d.enough = NEARLY * NEARLY * *farthest * *farthest;
		geometry_for(pool, worker, chunks, 1, look_at_chunks, &d);
		for (uint32_t i = 0; i < chunks; i++)
			*farthest = fmaxf(*farthest, sqrtf(d.farthest[i]));
	}
	free(d.farthest);
	free(d.of_triangle);
	return made;
}

static double tree_area(const geometry_tree *tree)
{
	double area = 0.0;
	for (uint32_t t = 0; t < tree->count; t++) {
		stilb_vec3 a = corner(&tree->triangles[t], 0);
		stilb_vec3 n = stilb_vec3_cross(corner(&tree->triangles[t], 1) - a, corner(&tree->triangles[t], 2) - a);
		area += 0.5 * (double)sqrtf(stilb_vec3_dot(n, n));
	}
	return area;
}

/* The largest coordinate of a tree's box: what floats round by grows with it. */
static float tree_reach(const geometry_tree *tree)
{
	float reach = 0.0f;
	const geometry_tree_node *root = &tree->levels[tree->level_count - 1][0];
	for (int axis = 0; axis < 3; axis++)
		for (int k = 0; k < 4; k++)
			if (root->lower[axis][k] <= root->upper[axis][k])
				reach = fmaxf(reach, fmaxf(fabsf(root->lower[axis][k]), fabsf(root->upper[axis][k])));
	return reach;
}

/* Lists the vertices of one side that the other one does not use, in the order of its tree. used: of all vertices, bit
 * 1 of those that the other one uses; bit 2 is set for those listed. */
static uint32_t list_points(const geometry_side *side, uint8_t *used, uint32_t *points)
{
	uint32_t count = 0;
	for (uint32_t t = 0; t < side->tree->count; t++)
		for (uint32_t k = 0; k < 3; k++) {
			uint32_t v = side->indices[3 * (size_t)side->tree->triangles[t].id + k];
			if (used[v] == 0)
				points[count++] = v;
			used[v] |= 2;
		}
	return count;
}

/* From the vertices of `from` that `to` does not have. False: no memory. */
static bool distance_of_points(const geometry_side *from, const geometry_side *to, stilb_job_pool *pool,
                               uint32_t worker, float *farthest)
{
	uint8_t *used = calloc(from->mesh->vertex_count + 1u, 1);
	uint32_t *points = stilb_memory_alloc(from->mesh->vertex_count, sizeof *points);
	bool made = used && points;
	if (made) {
		for (uint32_t i = 0; i < 3 * to->tree->count; i++)
			used[to->indices[i]] = 1;
		distance d = {.from = from, .to = to, .points = points, .count = list_points(from, used, points)};
		made = distance_one_way(d, pool, worker, farthest);
	}
	free(used);
	free(points);
	return made;
}

bool geometry_distance(const geometry_side *a, const geometry_side *b, stilb_job_pool *pool, uint32_t worker,
                       float *bound)
{
	*bound = 0.0f;
	if (a->tree->count == 0 || b->tree->count == 0)
		return true;
	const geometry_side *finer = a->tree->count > b->tree->count ? a : b, *coarser = finer == a ? b : a;
	float farthest = 0.0f, spacing = (float)sqrt(2.0 * tree_area(finer->tree) / finer->tree->count);
	distance edges = {
		.from = coarser, .to = finer, .count = coarser->tree->count, .spacing = spacing > FLT_MIN ? spacing : 1.0f};
	distance back = {.from = finer,
	                 .to = coarser,
	                 .count = finer->tree->count,
	                 .spacing = finer->tree->count > MANY ? 2.0f * edges.spacing : edges.spacing,
	                 .large_alone = true};
	if (!distance_of_points(finer, coarser, pool, worker, &farthest) ||
	    !distance_of_points(coarser, finer, pool, worker, &farthest) ||
	    !distance_one_way(edges, pool, worker, &farthest) || !distance_one_way(back, pool, worker, &farthest))
		return false;
	*bound = 1.06f * farthest + 1e-6f * tree_reach(finer->tree);
	return true;
}

stilb_result stilb_geometry_distance(const stilb_geometry_mesh *mesh, const uint32_t *a, uint32_t a_count,
                                     const uint32_t *b, uint32_t b_count, stilb_job_pool *pool, uint32_t worker,
                                     float *bound)
{
	STILB_ASSERT(mesh && bound && (a || a_count == 0) && (b || b_count == 0));
	if (a_count < 3 || b_count < 3) {
		*bound = 0.0f;
		return STILB_OK;
	}
	geometry_tree first = {0}, second = {0};
	geometry_side sides[2] = {{mesh, a, &first}, {mesh, b, &second}};
	*bound = 0.0f;
	bool made = geometry_tree_create(mesh->positions, mesh->position_stride, a, a_count / 3, pool, worker, &first) &&
	            geometry_tree_create(mesh->positions, mesh->position_stride, b, b_count / 3, pool, worker, &second) &&
	            geometry_distance(&sides[0], &sides[1], pool, worker, bound);
	geometry_tree_finish(&first);
	geometry_tree_finish(&second);
	return made ? STILB_OK
	            : stilb_fail(STILB_ERROR_MEMORY, "no memory to compare meshes of %u and %u triangles", a_count / 3,
	                         b_count / 3);
}
