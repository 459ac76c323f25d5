/* A tree of boxes over triangles, for the nearest of them to a point. Inside the module, its tests and benchmarks. */
#ifndef GEOMETRY_TREE_H
#define GEOMETRY_TREE_H

#include "base/base_math.h"
#include "geometry/geometry.h"

#define GEOMETRY_TREE_LEVELS 16

typedef struct geometry_tree_triangle {
	float corner[3][3];
	uint32_t id; /* its place in the indices given */
} geometry_tree_triangle;

/* The boxes of four children that follow one another. */
typedef struct geometry_tree_node {
	stilb_vec4 lower[3], upper[3];
} geometry_tree_node;

/* Triangles in the order of a Z-order curve; level 0 has the boxes of triangles. */
typedef struct geometry_tree {
	geometry_tree_triangle *triangles;
	uint32_t count;
	uint32_t level_count;
	geometry_tree_node *levels[GEOMETRY_TREE_LEVELS]; /* the last has one node */
	uint32_t sizes[GEOMETRY_TREE_LEVELS];             /* nodes */
} geometry_tree;

typedef struct geometry_nearest {
	float square;      /* of the distance, m^2 */
	uint32_t triangle; /* in the tree's order; UINT32_MAX: none within the limit */
	float at[2];       /* the nearest point: corner 0 + at[0] (corner 1 - corner 0) + at[1] (corner 2 - corner 0) */
} geometry_nearest;

/* Makes the tree of triangles whose positions are finite. False: no memory, and tree is {0}. */
bool geometry_tree_create(const float *positions, size_t stride, const uint32_t *indices, uint32_t triangle_count,
                          stilb_job_pool *pool, uint32_t worker, geometry_tree *tree);
void geometry_tree_finish(geometry_tree *tree);

/* The nearest triangle to a point that is nearer than the square root of `limit`; or any one that is as near as that of
 * `enough`. hint: one that may be near, in the tree's order, or UINT32_MAX. */
geometry_nearest geometry_tree_nearest(const geometry_tree *tree, stilb_vec3 point, float limit, float enough,
                                       uint32_t hint);

/* Calls visit for every triangle within the square root of `square` of a point, in the tree's order. */
void geometry_tree_within(const geometry_tree *tree, stilb_vec3 point, float square,
                          void (*visit)(const geometry_tree_triangle *triangle, const geometry_nearest *at, void *user),
                          void *user);

#endif
