/*
 * gi_cache_strata: the hemisphere of a record cut into rings of equal projected area and those into sectors, and what
 * one ray in each says together: irradiance, how it changes when the surface turns or moves, and how that changes.
 * [any-thread]
 *
 * Derivatives.  Radiance is constant within a cell, and what divides two cells is seen at the distance of the nearer
 *               one. A point at distance r in the unit direction w seems to move by -x / r when the surface moves by x
 *               along itself, so the edge between two cells moves, and with it n.w times the difference of their
 *               radiances. For a piece of an edge that does not move in the world, with m = w x dw:
 *                   gradient   dL (n.w / r) m
 *                   Hessian    dL (4 n.w / r^2) sym(m w^T)
 *               of which only the parts along the surface count. Summed over rings and sectors the first is Ward and
 *               Heckbert's gradient. The horizon does not move and has n.w = 0: it adds nothing.
 * Source:       Ward, Heckbert, "Irradiance Gradients" (1992). The second derivative is the first's, taken
 *               once more of the integral of n.p (p x dp) / |p|^4; it knows occlusion as that of Schwarzhaupt, Jensen,
 *               Jarosz, "Practical Hessian-Based Error Control for Irradiance Caching" (2012) does, whose cells
 *               are triangles between hits.
 */
#ifndef STILB_GI_CACHE_STRATA_H
#define STILB_GI_CACHE_STRATA_H

#include "base/base.h"
#include "base/base_math.h"

typedef struct gi_cache_ring {
	float tangent;   /* mean of tan(theta) over the ring, projected area counted */
	float inner;     /* cos^2 sin of its inner edge, times a sector's 2 sin(angle / 2) */
	float inner2;    /* 4 cos^2 sin^2 of its inner edge */
	float sine_step; /* sin(theta) of its outer edge less that of its inner one */
} gi_cache_ring;

typedef struct gi_cache_sector {
	float middle[2], edge[2]; /* cosine and sine of its middle and of where it begins */
	float spread[3];          /* xx, xy, yy: integral of u u^T over it, u the unit vector at its angles */
} gi_cache_sector;

typedef struct gi_cache_strata {
	uint32_t ring_count, sector_count;
	gi_cache_ring *rings;
	gi_cache_sector *sectors;
} gi_cache_strata;

/* What came along one cell's ray. */
typedef struct gi_cache_cell {
	stilb_vec3 radiance;
	float nearness; /* 1 / distance of what was hit, 0: nothing */
} gi_cache_cell;

/* In a tangent frame: 0 along t, 1 along b. Colours in lanes. */
typedef struct gi_cache_gathered {
	stilb_vec3 irradiance;
	stilb_vec3 rotation[2];    /* change of irradiance where the normal's tip moves by 1 along t or b */
	stilb_vec3 translation[2]; /* the same for the position, per metre */
	float hessian[3]; /* tt, tb, bb of the second derivative by position, mean of the colours, per square metre */
	float nearness;   /* mean: 1 / (harmonic mean distance) */
} gi_cache_gathered;

/* Of the three colours, equal shares: luminance would hardly see what happens beside a red wall. */
static inline float gi_cache_mean(stilb_vec3 colour)
{
	return (colour[0] + colour[1] + colour[2]) * (1.0f / 3.0f);
}

/* About as many cells as rays, never more; their sides are about as long as wide. rays >= 16. STILB_ERROR_MEMORY. */
stilb_result gi_cache_strata_create(uint32_t rays, gi_cache_strata *strata);
void gi_cache_strata_destroy(gi_cache_strata *strata);

uint32_t gi_cache_strata_cells(const gi_cache_strata *strata);

/* A direction in the tangent frame, z along the normal, through cell ring * sector_count + sector; u in [0, 1)^2 is the
 * place in it. Density over all cells: n.l / pi. */
stilb_vec3 gi_cache_strata_direction(const gi_cache_strata *strata, uint32_t cell, stilb_vec2 u);

/* cells: [gi_cache_strata_cells], in that order. */
gi_cache_gathered gi_cache_strata_gather(const gi_cache_strata *strata, const gi_cache_cell *cells);

#endif
