/*
 * culling, the innermost loops: one table of functions for each instruction set, all with the same results, bit for bit.
 * Only cull_avx2.c and cull_avx512.c are compiled for more than the base of the architecture.
 *
 * A sphere is visible when, for all planes and in float, ((x * px + y * py) + z * pz) + distance >= -radius, evaluated in
 * this order. No fused multiply-add: it rounds otherwise.
 */
#ifndef STILB_CULL_KERNELS_H
#define STILB_CULL_KERNELS_H

#include "base/base.h"
#include "base/base_math.h"

#define CULL_PLANES 6
#define CULL_ALL_PLANES 0x3fu /* a mask has one bit for each plane of the frustum */
#define CULL_CHILDREN 8u
#define CULL_WIDTH 16u     /* the widest vector, in spheres and in cells */
#define CULL_BITS_WORDS 8u /* bits are read and cleared by so many words: a cache line */
#define CULL_BITS_OBJECTS (CULL_BITS_WORDS * 64u)
#define CULL_SLACK CULL_WIDTH /* ids that a kernel may write beyond the last one */

/* Spheres, one array a component. */
typedef struct cull_spheres {
	const float *x, *y, *z, *radius;
} cull_spheres;

/* For each plane and each of eight siblings: how far the signed distance of the part of the sibling's box that is most
 * inside (high) and least inside (low) can lie from that of the parent's centre, margins for rounding included. */
typedef struct cull_level {
	_Alignas(64) double high[CULL_PLANES][CULL_CHILDREN];
	double low[CULL_PLANES][CULL_CHILDREN];
} cull_level;

/* Sixteen cells of one depth: two families of siblings (the second may be the first again). */
typedef struct cull_sixteen {
	const double *center[2];      /* [CULL_PLANES] signed distances of the parents' centres */
	const float *reach[2];        /* [CULL_CHILDREN] */
	uint16_t rejected;            /* out, a bit a cell: wholly outside a plane */
	uint16_t inside[CULL_PLANES]; /* out, a bit a cell: wholly inside this plane; 0 for planes that were not tested */
} cull_sixteen;

typedef struct cull_kernels {
	/* Writes the ids of the visible among spheres 0 .. count - 1 of a scene, ascending; how many. Writes up to CULL_SLACK
	 * beyond them. */
	uint32_t (*flat)(cull_spheres spheres, uint32_t count, const stilb_frustum *frustum, uint32_t *ids);
	/* Writes 0 .. count - 1, and up to CULL_SLACK more. */
	void (*all)(uint32_t count, uint32_t *ids);
	/* Sets bit i of bits to whether sphere i is visible for all planes of the mask. Writes whole words. */
	void (*test)(cull_spheres spheres, uint32_t count, const stilb_frustum *frustum, uint32_t planes, uint64_t *bits);
	/* Tests cells against the planes of the mask. */
	void (*sixteen)(cull_sixteen *cells, const cull_level *level, uint32_t planes);
	/* Ors the bits of count - 1 further sets, each stride words behind the one before, into the first and clears them; how
	 * many are set in the end. words is a multiple of CULL_BITS_WORDS. */
	uint32_t (*gather)(uint64_t *bits, size_t stride, uint32_t count, uint32_t words);
	/* Writes the numbers of the bits that are set, plus first_id, ascending, and clears the bits; how many. Writes up to
	 * CULL_SLACK beyond them. words is a multiple of CULL_BITS_WORDS. */
	uint32_t (*expand)(uint64_t *bits, uint32_t words, uint32_t first_id, uint32_t *ids);
} cull_kernels;

extern const cull_kernels cull_kernels_scalar, cull_kernels_avx2, cull_kernels_avx512;

/* The table for an instruction set that this CPU has. */
const cull_kernels *cull_kernels_for(stilb_isa isa);

#endif
