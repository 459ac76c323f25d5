/*
 * The innermost loops of culling: a table of functions for each instruction set. All tables give the same results, bit
 * for bit. Only cull_avx2.c and cull_avx512.c are compiled for more than the baseline of the architecture.
 *
 * A sphere is visible if for all planes, in float, ((x * px + y * py) + z * pz) + distance >= -radius, evaluated in
 * this order and without fused multiply-add, which would round differently.
 */
#ifndef STILB_CULL_KERNELS_H
#define STILB_CULL_KERNELS_H

#include "base/base.h"
#include "base/base_math.h"

#define CULL_PLANES 6
#define CULL_ALL_PLANES 0x3fu /* masks have one bit for each plane of the frustum */
#define CULL_CHILDREN 8u
#define CULL_WIDTH 16u     /* spheres, or cells, in the widest vector */
#define CULL_BITS_WORDS 8u /* bits are read and cleared a cache line at a time */
#define CULL_BITS_OBJECTS (CULL_BITS_WORDS * 64u)
#define CULL_SLACK                                                                                                     \
	CULL_WIDTH /* elements that a kernel may write beyond the last id: arrays of ids are so much longer */

/* Spheres, an array for each component. */
typedef struct cull_spheres {
	const float *x, *y, *z, *radius;
} cull_spheres;

/* Constants of one depth, for each plane and each of eight siblings: the greatest (high) and the least (low) signed
 * distance from the plane of a point in the sibling's cell, minus the distance of the parent's centre, and widened by a
 * margin for rounding. */
typedef struct cull_level {
	_Alignas(64) double high[CULL_PLANES][CULL_CHILDREN];
	double low[CULL_PLANES][CULL_CHILDREN];
} cull_level;

/* Sixteen cells of one depth: two families of siblings. The second may repeat the first. */
typedef struct cull_sixteen {
	const double *center[2]; /* in: [CULL_PLANES] signed distances of the parents' centres from the planes */
	const float *reach[2];   /* in: [CULL_CHILDREN] see stilb_cull_octree.reach */
	uint16_t rejected;       /* out, a bit for each cell: wholly outside a plane */
	uint16_t
		inside[CULL_PLANES]; /* out, a bit for each cell: wholly inside this plane; 0 if the plane was not tested */
} cull_sixteen;

typedef struct cull_kernels {
	/* Writes the indices of the visible ones among spheres 0 .. count - 1, ascending, and returns their number. Writes
	 * up to CULL_SLACK elements beyond them. */
	uint32_t (*flat)(cull_spheres spheres, uint32_t count, const stilb_frustum *frustum, uint32_t *ids);
	/* Writes 0 .. count - 1, and up to CULL_SLACK elements beyond them. */
	void (*all)(uint32_t count, uint32_t *ids);
	/* Sets bit i of bits to 1 if sphere i is visible for all planes of the mask, else to 0; bits from count to the end
	 * of the last word to 0. count > 0, and the mask has a plane. */
	void (*test)(cull_spheres spheres, uint32_t count, const stilb_frustum *frustum, uint32_t planes, uint64_t *bits);
	/* Tests sixteen cells against the planes of the mask. */
	void (*sixteen)(cull_sixteen *cells, const cull_level *level, uint32_t planes);
	/* bits is the first of count sets of `words` words each, `stride` words apart: ors the others into the first,
	 * clears them, and returns the number of bits set in the first. words is a multiple of CULL_BITS_WORDS. */
	uint32_t (*gather)(uint64_t *bits, size_t stride, uint32_t count, uint32_t words);
	/* Writes first_id + i for every bit i that is set, ascending, clears the bits, and returns their number. Writes up
	 * to CULL_SLACK elements beyond them. words is a multiple of CULL_BITS_WORDS. */
	uint32_t (*expand)(uint64_t *bits, uint32_t words, uint32_t first_id, uint32_t *ids);
} cull_kernels;

extern const cull_kernels cull_kernels_scalar, cull_kernels_avx2, cull_kernels_avx512;

/* The table for an instruction set, which this CPU must have. */
const cull_kernels *cull_kernels_for(stilb_isa isa);

#endif
