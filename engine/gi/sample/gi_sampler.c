#include "gi/sample/gi_sampler.h"

#include "gi/sample/gi_sampler_kernels.h"

#include <math.h>

/* Constants that keep the streams of random numbers of one seed apart. */
#define STREAM_PIXEL 0x70697865u
#define STREAM_SAMPLE 0x736d706cu
#define STREAM_BRANCH 0x62726e63u
#define STREAM_ORDER 0x6f726472u

/* ---- making ------------------------------------------------------------------------------------------------------ */

const gi_sampler_kernels *gi_sampler_kernels_for(stilb_isa isa)
{
	STILB_ASSERT(isa < STILB_ISA_COUNT && isa <= stilb_cpu_widest_isa());
#if defined(__x86_64__)
	if (isa >= STILB_ISA_AVX2)
		return &gi_sampler_kernels_avx2;
#endif
	(void)isa;
	return &gi_sampler_kernels_scalar;
}

gi_sampler gi_sampler_make(stilb_gi_sampler_kind kind, uint64_t seed, uint32_t samples)
{
	STILB_ASSERT(kind < STILB_GI_SAMPLER_COUNT);
	STILB_ASSERT(samples >= 1);
	stilb_isa isa;
	if (stilb_cpu_isa(&isa) != STILB_OK)
		isa = STILB_ISA_SCALAR; /* the same bits */
	return (gi_sampler){.kind = kind, .seed = seed, .samples = samples, .kernels = gi_sampler_kernels_for(isa)};
}

/* ---- points ------------------------------------------------------------------------------------------------------ */

static uint64_t mixed(uint64_t hash, uint32_t stream, uint64_t value)
{
	return stilb_random_u64(hash ^ stream, value);
}

static uint64_t packed(uint32_t high, uint32_t low)
{
	return (uint64_t)high << 32 | low;
}

/* Spreads 32 bits to the even places of 64, for Morton codes. */
static uint64_t spread(uint32_t bits)
{
	uint64_t x = bits;
	x = (x | x << 16) & 0x0000ffff0000ffffu;
	x = (x | x << 8) & 0x00ff00ff00ff00ffu;
	x = (x | x << 4) & 0x0f0f0f0f0f0f0f0fu;
	x = (x | x << 2) & 0x3333333333333333u;
	return (x | x << 1) & 0x5555555555555555u;
}

/* The index of a pixel in a hierarchical order, which visits squares of 2^k x 2^k pixels one after the other, for each
 * k. Later the points' indices are shuffled by Owen scrambling (gi_sobol_index), which permutes the four quarters of
 * each square at random, but keeps those two quarters together that have the same higher bit of their two. Which
 * quarters are together (side by side, one above the other, or crosswise) is chosen here at random, so that all 24
 * orders of four occur. Source: Ahmed and Wonka, "Screen-Space Blue-Noise Diffusion of Monte Carlo Sampling Error via
 * Hierarchical Ordering of Pixels" (2020). */
static uint64_t pixel_order(uint64_t hash, uint32_t x, uint32_t y)
{
	uint64_t morton = spread(y) << 1 | spread(x);
	uint64_t order = morton;
	for (int shift = 0; morton >> shift; shift += 2) {
		uint32_t pairing = gi_seed(hash + (uint32_t)shift, (uint32_t)(morton >> shift >> 2)) % 3;
		uint64_t low = morton >> shift & 1, high = morton >> shift >> 1 & 1;
		if (pairing == 1)
			order ^= (low ^ high) * 3 << shift; /* swaps the two bits */
		else if (pairing == 2)
			order ^= low << 1 << shift; /* the bits become high ^ low, low */
	}
	return order;
}

/* A point of BLUE_NOISE: all pixels share one Sobol sequence, and neighbouring pixels have neighbouring parts of it, so
 * that their errors compensate. The number of samples should be as planned, or a power of two. */
static gi_point ordered_point(const gi_sampler *sampler, uint32_t x, uint32_t y, uint32_t index)
{
	STILB_ASSERT(sampler->kind == STILB_GI_SAMPLER_BLUE_NOISE && sampler->samples >= 1);
	uint64_t hash = mixed(sampler->seed, STREAM_ORDER, 0);
	int bits = sampler->samples > 1 ? 32 - __builtin_clz(sampler->samples - 1) : 0;
	uint64_t place = (pixel_order(hash, x, y) << bits) + index;
	return (gi_point){mixed(hash, STREAM_PIXEL, place >> 32), (uint32_t)place, sampler->samples};
}

gi_point gi_sampler_point(const gi_sampler *sampler, uint32_t x, uint32_t y, uint32_t index)
{
	if (sampler->kind == STILB_GI_SAMPLER_BLUE_NOISE)
		return ordered_point(sampler, x, y, index);
	uint64_t hash = mixed(sampler->seed, STREAM_PIXEL, packed(y, x));
	if (sampler->kind == STILB_GI_SAMPLER_RANDOM) /* has no order: the index is hashed as well */
		hash = mixed(hash, STREAM_SAMPLE, index);
	return (gi_point){hash, index, sampler->samples};
}

/* Branches of a point are further points of the same sample. With the samplers SOBOL and BLUE_NOISE the branches of all
 * samples of a pixel form one sequence, in which those of one sample follow one another and are stratified; bits that
 * do not fit into an index go into the hash. With the others the branches of a sample are stratified among themselves,
 * or, if each sample has one branch, over the samples. */
gi_point gi_sampler_branch(const gi_sampler *sampler, gi_point parent, uint32_t dimension, uint32_t i, uint32_t n)
{
	STILB_ASSERT(i < n);
	uint64_t index = (uint64_t)parent.index * n + i, hash;
	switch (sampler->kind) {
	case STILB_GI_SAMPLER_RANDOM:
		hash = mixed(parent.hash, STREAM_BRANCH, packed(dimension, i));
		return (gi_point){hash, i, n};
	case STILB_GI_SAMPLER_STRATIFIED:
		hash = mixed(parent.hash, STREAM_BRANCH, packed(dimension, n == 1 ? UINT32_MAX : parent.index));
		return n == 1 ? (gi_point){hash, parent.index, parent.count} : (gi_point){hash, i, n};
	case STILB_GI_SAMPLER_SOBOL:
	case STILB_GI_SAMPLER_BLUE_NOISE:
	case STILB_GI_SAMPLER_COUNT:
		break;
	}
	hash = mixed(parent.hash, STREAM_BRANCH, packed(dimension, (uint32_t)(index >> 32)));
	return (gi_point){hash, (uint32_t)index, n};
}

/* ---- stratified -------------------------------------------------------------------------------------------------- */

/* The image of i in a random permutation of 0 .. count - 1: a permutation of the next power of two, repeated until
 * the value is below count. Source: Kensler, "Correlated Multi-Jittered Sampling" (2013). */
static uint32_t permuted(uint32_t i, uint32_t count, uint32_t seed)
{
	STILB_ASSERT(i < count);
	uint32_t mask = count > 1 ? UINT32_MAX >> __builtin_clz(count - 1) : 0;
	do {
		i ^= seed;
		i *= 0xe170893du;
		i ^= seed >> 16;
		i ^= (i & mask) >> 4;
		i ^= seed >> 8;
		i *= 0x0929eb3fu;
		i ^= seed >> 23;
		i ^= (i & mask) >> 1;
		i *= 1 | seed >> 27;
		i *= 0x6935fa69u;
		i ^= (i & mask) >> 11;
		i *= 0x74dcb303u;
		i ^= (i & mask) >> 2;
		i *= 0x9e501cc3u;
		i ^= (i & mask) >> 2;
		i *= 0xc860a3dfu;
		i &= mask;
		i ^= i >> 5;
	} while (i >= count);
	return (i + seed) % count;
}

typedef struct strata {
	uint32_t columns, rows;
} strata;

/* The most nearly square grid with a cell for each of count points; count is at most 2^24. */
static strata strata_of(uint32_t count)
{
	STILB_ASSERT(count >= 1 && count <= 1u << 24);
	uint32_t columns = (uint32_t)sqrtf((float)count);
	return (strata){columns, (count + columns - 1) / columns};
}

static float below_one(float x)
{
	return x < 1.0f ? x : 0x1.fffffep-1f;
}

/* The point of one cell of the grid, jittered so that each coordinate alone is stratified as finely as there are
 * cells (Kensler 2013). Cells are taken in random order, so that if there are more cells than points each is equally
 * likely to be left out. After the last cell a new grid begins. */
static stilb_vec2 stratified_pair(gi_point point, strata grid, uint32_t dimension)
{
	uint32_t columns = grid.columns, rows = grid.rows, cells = columns * rows;
	uint64_t hash = point.hash + point.index / cells * 0x9e3779b97f4a7c15u;
	uint32_t cell = permuted(point.index % cells, cells, gi_seed(hash, GI_SEED_SHUFFLE + dimension));
	uint32_t column = cell % columns, row = cell / columns;
	uint32_t fine_x = permuted(row, rows, gi_seed(hash, dimension));
	uint32_t fine_y = permuted(column, columns, gi_seed(hash, dimension + 1));
	uint64_t jitter = hash ^ packed(cell, 0);
	float x = (float)(column * rows + fine_x) + gi_fraction(gi_seed(jitter, GI_SEED_JITTER + dimension));
	float y = (float)(row * columns + fine_y) + gi_fraction(gi_seed(jitter, GI_SEED_JITTER + dimension + 1));
	return (stilb_vec2){below_one(x / (float)cells), below_one(y / (float)cells)};
}

/* ---- numbers ----------------------------------------------------------------------------------------------------- */

static stilb_vec2 random_pair(gi_point point, uint32_t dimension)
{
	return (stilb_vec2){gi_fraction(gi_seed(point.hash, dimension)), gi_fraction(gi_seed(point.hash, dimension + 1))};
}

static stilb_vec2 sobol_pair(gi_point point, uint32_t dimension)
{
	uint32_t x = gi_sobol_index(point.hash, gi_reverse(point.index), dimension), y = gi_sobol_second(x);
	return (stilb_vec2){gi_owen_fraction(x, gi_seed(point.hash, dimension)),
	                    gi_owen_fraction(y, gi_seed(point.hash, dimension + 1))};
}

stilb_vec2 gi_sample_2d(const gi_sampler *sampler, gi_point point, uint32_t dimension)
{
	STILB_ASSERT(dimension % 2 == 0);
	switch (sampler->kind) {
	case STILB_GI_SAMPLER_RANDOM:
		return random_pair(point, dimension);
	case STILB_GI_SAMPLER_STRATIFIED:
		return stratified_pair(point, strata_of(point.count), dimension);
	case STILB_GI_SAMPLER_SOBOL:
	case STILB_GI_SAMPLER_BLUE_NOISE:
	case STILB_GI_SAMPLER_COUNT:
		break;
	}
	return sobol_pair(point, dimension);
}

static void stratified_8(gi_point point, uint32_t first, float numbers[8])
{
	strata grid = strata_of(point.count);
	for (uint32_t i = 0; i < 8; i += 2) {
		stilb_vec2 pair = stratified_pair(point, grid, first + i);
		numbers[i] = pair[0];
		numbers[i + 1] = pair[1];
	}
}

void gi_sample_8(const gi_sampler *sampler, gi_point point, uint32_t first, float numbers[8])
{
	STILB_ASSERT(first % 8 == 0);
	switch (sampler->kind) {
	case STILB_GI_SAMPLER_RANDOM:
		sampler->kernels->random_8(point.hash, first, numbers);
		return;
	case STILB_GI_SAMPLER_STRATIFIED:
		stratified_8(point, first, numbers);
		return;
	case STILB_GI_SAMPLER_SOBOL:
	case STILB_GI_SAMPLER_BLUE_NOISE:
	case STILB_GI_SAMPLER_COUNT:
		break;
	}
	sampler->kernels->sobol_8(point.hash, point.index, first, numbers);
}
