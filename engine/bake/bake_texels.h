/*
 * bake_texels: which place of which surface every texel of a page shows.
 *
 * A texel is cut into four cells, and a cell that a triangle touches, however little, has a spot: the middle of what
 * the triangle has of the cell, so that it lies on the surface, never beside it. Of several triangles the one that has
 * the most of the cell gets it, of equal ones the first. Texels that no triangle touches have no spot.
 *
 * Life cycle.  stilb_bake_texels_create -> read by any thread -> stilb_bake_texels_destroy.
 * Threads.     create: [main-thread] of the pool. The same bits for any number of workers.
 * Memory.      68 bytes a texel of the page.
 */
#ifndef STILB_BAKE_TEXELS_H
#define STILB_BAKE_TEXELS_H

#include "bake/bake_atlas.h"

#define STILB_BAKE_CELLS 4 /* of a texel: two rows of two */

typedef struct stilb_bake_spot {
	uint32_t triangle; /* of its part's mesh */
	float u, v;        /* barycentric, (1 - u - v) of corner 0, u of corner 1, v of corner 2; each in [0, 1] */
	float share;       /* of the cell that the triangle has, (0, 1]; 0: there is no spot */
} stilb_bake_spot;

typedef struct stilb_bake_texels {
	uint32_t side, page;
	stilb_bake_spot (*spots)[STILB_BAKE_CELLS]; /* [side * side] row by row */
	uint32_t *place;  /* [side * side] index in stilb_bake_atlas.places of the chart; STILB_BAKE_NO_CHART: of none */
	uint32_t *part;   /* [atlas.place_count] the part of each place */
	uint64_t covered; /* texels with a spot */
} stilb_bake_texels;

/* The texels of a page. STILB_ERROR_MEMORY; then *out is NULL. */
stilb_result stilb_bake_texels_create(const stilb_bake_atlas *atlas, uint32_t page, stilb_job_pool *pool,
                                      stilb_bake_texels **out);

/* Accepts NULL. [one-writer] */
void stilb_bake_texels_destroy(stilb_bake_texels *texels);

#endif
