/*
 * bake_patch: one chart while it is laid flat: its triangles with corners of its own, and their places in the plane.
 *
 *   bake_patch_begin -> bake_patch_project -> bake_patch_conform -> is the map good? bake_patch_is_good
 *                    -> bake_patch_settle turns and moves it
 *
 * Threads.  A patch belongs to one thread. All are in double and in a fixed order.
 */
#ifndef BAKE_PATCH_H
#define BAKE_PATCH_H

#include "bake/unwrap/bake_topology.h"

typedef struct bake_patch {
	const bake_topology *topology;
	const uint32_t *triangles; /* [count] of the mesh */
	uint32_t count, vertex_count, border_count;
	uint32_t *corner;      /* [3 * count] the vertex of each corner; corners are one vertex if a way around it, from
	                          triangle to neighbour, joins them. So each vertex has one side of the border at most */
	uint32_t *place_of;    /* [vertex_count] a corner of the mesh that is there: bake_topology.place */
	uint32_t (*border)[2]; /* [border_count] vertices where sides of the border begin and end */
	double (*at)[2];       /* [vertex_count] places in the plane */
	double area;           /* of the triangles */
	double normal[3];      /* unit, their mean; 0: they have none */
	bool level;            /* they lie in one plane, so that the projection is exact */
} bake_patch;

/* chart: [triangle_count of the mesh] the chart of each triangle; local: as many numbers, of which those of the chart's
 * triangles are written. STILB_ERROR_MEMORY. */
stilb_result bake_patch_begin(const bake_topology *topology, const uint32_t *triangles, uint32_t count,
                              const uint32_t *chart, uint32_t *local, bake_patch *patch);
void bake_patch_finish(bake_patch *patch);

/* Projects it along its normal. */
void bake_patch_project(bake_patch *patch);

/* Makes `at`, which is a start, the least-squares conformal map with two vertices held: bake_conform.c.
 * STILB_ERROR_MEMORY. */
stilb_result bake_patch_conform(bake_patch *patch);

/* True if no triangle is turned over or squeezed to nothing, and no place is covered twice: bake_check.c. *good; the
 * result is STILB_ERROR_MEMORY at worst. */
stilb_result bake_patch_is_good(const bake_patch *patch, bool *good);

/* The sum over triangles of area times the square of Sander's stretch, 1 for no stretch, of the map scaled to the
 * surface's area; infinite if a triangle has no area in the map. */
double bake_patch_stretch(const bake_patch *patch);

/* Scales it to the area of its triangles, and turns it so that its box is smallest, wider than high, and begins at
 * (0, 0): bake_settle.c. STILB_ERROR_MEMORY. */
stilb_result bake_patch_settle(bake_patch *patch, float size[2]);

/* Twice the area of a triangle of the map, positive if it is counter-clockwise. */
static inline double bake_patch_area2(const bake_patch *patch, uint32_t triangle)
{
	const uint32_t *v = &patch->corner[3 * (size_t)triangle];
	const double *a = patch->at[v[0]], *b = patch->at[v[1]], *c = patch->at[v[2]];
	return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/* Corners of a triangle in a plane of its own: (0, 0), (x[1], 0) and (x[2], y). */
typedef struct bake_flat {
	double x1, x2, y;
} bake_flat;

bake_flat bake_patch_flat(const bake_patch *patch, uint32_t triangle);

#endif
