/*
 * gi_sampler: random numbers as a function of pixel, sample and dimension, and nothing else. [any-thread]
 *
 * A gi_point is one sample of one pixel; its numbers are asked for by dimension, in any order. The dimensions 2k and
 * 2k + 1 are one stratified point of the square. gi_sampler_branch splits a sample into n, for the rays of a gather.
 * All arithmetic is on integers, so every instruction set gives the same bits.
 */
#ifndef STILB_GI_SAMPLER_H
#define STILB_GI_SAMPLER_H

#include "base/base_math.h"
#include "gi/gi_render.h"

/* Dimensions: first the camera's, then eight for every vertex of the path; vertex 0 is the first hit. */
#define GI_DIMENSION_PIXEL 0 /* 2 numbers: position in the filter */
#define GI_DIMENSION_LENS 2  /* 2 numbers: position on the lens */
#define GI_DIMENSION_SEEN 4  /* 2 numbers, of which the first is the camera ray's own: gi_ray.time */
#define GI_DIMENSIONS_CAMERA 8
#define GI_DIMENSIONS_VERTEX 8
#define GI_DIMENSION_DIRECTION 0 /* 2 numbers: direction of the next ray */
#define GI_DIMENSION_LIGHT 2     /* 2 numbers: position on the light */
#define GI_DIMENSION_CHOICE 4    /* choice of the light */
#define GI_DIMENSION_LOBE 5      /* choice between diffuse and highlight */
#define GI_DIMENSION_ROULETTE 6
#define GI_DIMENSION_CHANCE 7 /* gi_ray.time of the rays that leave the vertex */
#define GI_DIMENSION_OF(vertex) (GI_DIMENSIONS_CAMERA + GI_DIMENSIONS_VERTEX * (vertex))

struct gi_sampler_kernels;

typedef struct gi_sampler {
	stilb_gi_sampler_kind kind;
	uint64_t seed;
	uint32_t samples; /* planned for each pixel; STRATIFIED and BLUE_NOISE make their points for so many */
	const struct gi_sampler_kernels *kernels;
} gi_sampler;

typedef struct gi_point {
	uint64_t hash;  /* of pixel and seed, or of the branch */
	uint32_t index; /* number of the sample */
	uint32_t count; /* planned number of samples */
} gi_point;

/* samples >= 1: planned for each pixel. */
gi_sampler gi_sampler_make(stilb_gi_sampler_kind kind, uint64_t seed, uint32_t samples);

gi_point gi_sampler_point(const gi_sampler *sampler, uint32_t x, uint32_t y, uint32_t index);

/* Point i of the n that this one branches into; dimension distinguishes several branchings of one point. */
gi_point gi_sampler_branch(const gi_sampler *sampler, gi_point parent, uint32_t dimension, uint32_t i, uint32_t n);

/* Two numbers in [0, 1). dimension is even. */
stilb_vec2 gi_sample_2d(const gi_sampler *sampler, gi_point point, uint32_t dimension);

/* Dimensions first .. first + 7 at once, faster than one by one: the same numbers. first is a multiple of 8. */
void gi_sample_8(const gi_sampler *sampler, gi_point point, uint32_t first, float numbers[8]);

#endif
