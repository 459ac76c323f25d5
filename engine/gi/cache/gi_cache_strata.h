/*
 * gi_cache_strata: the hemisphere above a record, divided into rings of equal projected area and those into sectors,
 * and what one ray through each cell gives in sum: irradiance, its gradients by rotation and by position, and its
 * second derivative by position. [any-thread]
 *
 * Derivatives.  Radiance is taken as constant within a cell, and the edge between two cells as being at the distance
 *               of the nearer one. When the surface moves by x along itself, a point at distance r in the unit
 *               direction w seems to move by -x / r, so the edge moves, and irradiance changes by n.w times the
 *               difference of the two radiances. For a piece of an edge that is fixed in the world, with m = w x dw:
 *                   gradient   dL (n.w / r) m
 *                   Hessian    dL (4 n.w / r^2) sym(m w^T)
 *               of which the parts along the surface are used. Summed over rings and sectors the first is Ward and
 *               Heckbert's gradient. The horizon does not move and has n.w = 0: it adds nothing.
 * Source:       Ward, Heckbert, "Irradiance Gradients" (1992). The Hessian is derived the same way, as the second
 * derivative of the integral of n.p (p x dp) / |p|^4; like that of Schwarzhaupt, Jensen, Jarosz, "Practical
 * Hessian-Based Error Control for Irradiance Caching" (2012), whose cells are triangles between hits, it accounts
 * for occlusion.
 */
#ifndef STILB_GI_CACHE_STRATA_H
#define STILB_GI_CACHE_STRATA_H

#include "base/base.h"
#include "base/base_math.h"

typedef struct gi_cache_ring {
	float tangent;   /* mean of tan(theta) over the ring's projected area */
	float inner;     /* cos^2 sin of the theta of its inner edge, times 2 sin(angle / 2), angle a sector's width */
	float inner2;    /* 4 cos^2 sin^2 of the theta of its inner edge */
	float sine_step; /* sin(theta) at its outer edge minus that at its inner edge */
} gi_cache_ring;

typedef struct gi_cache_sector {
	float middle[2], edge[2]; /* cosine and sine of the azimuth of its middle, and of its first edge */
	float spread[3];          /* xx, xy, yy: integral of u u^T over its azimuths, u the unit vector at an azimuth */
} gi_cache_sector;

typedef struct gi_cache_strata {
	uint32_t ring_count, sector_count;
	gi_cache_ring *rings;
	gi_cache_sector *sectors;
} gi_cache_strata;

/* The result of one cell's ray. */
typedef struct gi_cache_cell {
	stilb_vec3 radiance;
	float nearness; /* 1 / distance to the hit, 0: a miss */
} gi_cache_cell;

/* Sums over all cells, in the frame of tangent t, bitangent b and normal: index 0 is along t, 1 along b. Red, green and
 * blue in lanes 0 to 2 of each vector. */
typedef struct gi_cache_gathered {
	stilb_vec3 irradiance;
	stilb_vec3 rotation[2];    /* change of irradiance per unit that the normal's tip moves along t or b */
	stilb_vec3 translation[2]; /* change of irradiance per metre along t or b */
	/* tt, tb, bb: second derivative of irradiance by position, mean of the colours, per square metre */
	float hessian[3];
	float nearness; /* mean over the cells: 1 / (harmonic mean distance) */
} gi_cache_gathered;

/* The mean of the three colours. Not luminance, which would hardly see a change of red light beside a red wall. */
static inline float gi_cache_mean(stilb_vec3 colour)
{
	return (colour[0] + colour[1] + colour[2]) * (1.0f / 3.0f);
}

/* As many cells as fit into `rays` >= 16, about as wide as they are long. STILB_ERROR_MEMORY; then strata is {0}. */
stilb_result gi_cache_strata_create(uint32_t rays, gi_cache_strata *strata);
void gi_cache_strata_destroy(gi_cache_strata *strata);

uint32_t gi_cache_strata_cells(const gi_cache_strata *strata);

/* A direction through a cell, whose index is ring * sector_count + sector, in the tangent frame with z along the
 * normal; u in [0, 1)^2 is the position in the cell. For a random cell and u the density is cosine / pi per
 * steradian. */
stilb_vec3 gi_cache_strata_direction(const gi_cache_strata *strata, uint32_t cell, stilb_vec2 u);

/* Sums up what the rays through all cells found. cells: [gi_cache_strata_cells], by the cell's index. */
gi_cache_gathered gi_cache_strata_gather(const gi_cache_strata *strata, const gi_cache_cell *cells);

#endif
