/*
 * gi_sampler: random numbers as a function of (pixel, sample, dimension) and nothing else. [any-thread]
 *
 * A gi_point is one sample of one pixel; its numbers are asked for by dimension, in any order. A dimension pair (2k, 2k + 1)
 * is one stratified point of the square. gi_sampler_branch opens a sample into n of its own kind: the rays of a gather.
 * Numbers are made of integers: every instruction set gives the same bits.
 */
#ifndef STILB_GI_SAMPLER_H
#define STILB_GI_SAMPLER_H

#include "base/base_math.h"
#include "gi/gi_render.h"

/* Dimensions: camera first, then eight for every vertex of the path, 0 the first hit. */
#define GI_DIMENSION_PIXEL 0 /* 2: place in the filter */
#define GI_DIMENSION_LENS 2  /* 2 */
#define GI_DIMENSIONS_CAMERA 8
#define GI_DIMENSIONS_VERTEX 8
#define GI_DIMENSION_DIRECTION 0 /* 2: of the next ray */
#define GI_DIMENSION_LIGHT 2     /* 2: place on the light */
#define GI_DIMENSION_CHOICE 4    /* which light */
#define GI_DIMENSION_LOBE 5      /* diffuse or highlight */
#define GI_DIMENSION_ROULETTE 6
#define GI_DIMENSION_OF(vertex) (GI_DIMENSIONS_CAMERA + GI_DIMENSIONS_VERTEX * (vertex))

struct gi_sampler_kernels;

typedef struct gi_sampler {
	stilb_gi_sampler_kind kind;
	uint64_t seed;
	uint32_t samples; /* a pixel, planned: what the grids of STRATIFIED are made for */
	const struct gi_sampler_kernels *kernels;
} gi_sampler;

typedef struct gi_point {
	uint64_t hash;  /* of pixel and seed, or of the branch */
	uint32_t index; /* of the sample */
	uint32_t count; /* planned */
} gi_point;

/* samples >= 1. */
gi_sampler gi_sampler_make(stilb_gi_sampler_kind kind, uint64_t seed, uint32_t samples);

gi_point gi_sampler_point(const gi_sampler *sampler, uint32_t x, uint32_t y, uint32_t index);

/* The i-th of n points below this one; dimension tells branches of one point apart. */
gi_point gi_sampler_branch(const gi_sampler *sampler, gi_point parent, uint32_t dimension, uint32_t i, uint32_t n);

/* In [0, 1). dimension is even. */
stilb_vec2 gi_sample_2d(const gi_sampler *sampler, gi_point point, uint32_t dimension);

/* Dimensions first .. first + 7 at once: the same numbers, sooner. first is a multiple of 8. */
void gi_sample_8(const gi_sampler *sampler, gi_point point, uint32_t first, float numbers[8]);

#endif
