/*
 * gi_sampler_kernels: functions that compute eight dimensions (random numbers) of a gi_point at once, in a table for
 * each instruction set, all with the same bits; and the formulas in plain C, which are the reference. [any-thread]
 *
 * Points.  A pair of dimensions is a point of the two-dimensional Sobol sequence. Both coordinates are
 *          Owen-scrambled, and so is the index, which makes the pairs independent of one another and keeps every run
 *          of 2^k indices that starts at a multiple of 2^k stratified. Source: Burley, "Practical Hash-based Owen
 *          Scrambling" (2020).
 * Bits.    Owen scrambling flips a bit of a coordinate depending on the higher ones; a hash by multiplication changes a
 *          bit depending on the lower ones, as carries go upwards. So coordinates are kept with their bits in reverse
 *          order. The first coordinate of a Sobol point is its index with the bits reversed.
 */
#ifndef STILB_GI_SAMPLER_KERNELS_H
#define STILB_GI_SAMPLER_KERNELS_H

#include "base/base.h"

typedef struct gi_sampler_kernels {
	/* numbers[i] is dimension first + i of the point; first is a multiple of 8. */
	void (*sobol_8)(uint64_t hash, uint32_t index, uint32_t first, float numbers[8]);
	void (*random_8)(uint64_t hash, uint32_t first, float numbers[8]);
} gi_sampler_kernels;

extern const gi_sampler_kernels gi_sampler_kernels_scalar, gi_sampler_kernels_avx2;

/* The functions for an instruction set, which this CPU must have. */
const gi_sampler_kernels *gi_sampler_kernels_for(stilb_isa isa);

/* gi_seed makes 32 random bits of a hash and a number. The numbers of different uses are kept apart: a dimension itself
 * for its value, and plus these for the shuffle of its indices and for the jitter of its grid. */
#define GI_SEED_SHUFFLE 0x40000000u
#define GI_SEED_JITTER 0x80000000u

/* The multipliers in gi_seed and gi_owen_hash. */
#define GI_SEED_STEP 0x9e3779b9u
#define GI_SEED_MIX_1 0x7feb352du
#define GI_SEED_MIX_2 0x846ca68bu
#define GI_OWEN_MIX_1 0x3d20adeau
#define GI_OWEN_MIX_2 0x05526c56u
#define GI_OWEN_MIX_3 0x53a22864u

/* Constants for the vector versions, eight lanes each. */
typedef struct gi_sampler_constants_avx2 {
	_Alignas(32) uint32_t one[8], seed_mix_1[8], seed_mix_2[8], owen_mix_1[8], owen_mix_2[8], owen_mix_3[8];
	uint32_t steps[8], pair_steps[8]; /* GI_SEED_STEP times 0, 1, 2, ..., and times 0, 0, 2, 2, ... */
	uint32_t every_1[8], every_2[8], every_4[8], every_8[8]; /* masks: of every 2, 4, 8 and 16 bits the upper half */
	uint8_t low_half[32], reversed_half[32], swap_bytes[32];
} gi_sampler_constants_avx2;
extern const gi_sampler_constants_avx2 gi_sampler_constants;

/* 32 random bits for (hash, number); the hash is given in halves. Source of the mixer: Wellons, "Prospecting for
 * Hash Functions" (2018), lowbias32. */
static inline uint32_t gi_seed_halves(uint32_t low, uint32_t high, uint32_t number)
{
	uint32_t x = low + number * GI_SEED_STEP;
	x ^= x >> 16;
	x = x * GI_SEED_MIX_1 + high;
	x ^= x >> 15;
	x *= GI_SEED_MIX_2;
	return x ^ x >> 16;
}

static inline uint32_t gi_seed(uint64_t hash, uint32_t number)
{
	return gi_seed_halves((uint32_t)hash, (uint32_t)(hash >> 32), number);
}

/* Owen scrambling of a fraction whose bits are reversed: bit i is flipped or not by a function of the bits below it.
 * Source: Laine and Karras, "Stratified Sampling for Stochastic Transparency" (2011), with the constants of Vegdahl,
 * "Building a Better LK Hash" (2021). */
static inline uint32_t gi_owen_hash(uint32_t x, uint32_t seed)
{
	x ^= x * GI_OWEN_MIX_1;
	x += seed;
	x *= seed >> 16 | 1;
	x ^= x * GI_OWEN_MIX_2;
	return x ^ x * GI_OWEN_MIX_3;
}

static inline uint32_t gi_reverse(uint32_t x)
{
	x = __builtin_bswap32(x);
	x = (x >> 4 & 0x0f0f0f0fu) | (x & 0x0f0f0f0fu) << 4;
	x = (x >> 2 & 0x33333333u) | (x & 0x33333333u) << 2;
	return (x >> 1 & 0x55555555u) | (x & 0x55555555u) << 1;
}

/* The second coordinate of point `index` of the Sobol sequence, bits reversed. It is the index times a matrix of bits,
 * Pascal's triangle modulo 2: bit j of the result is the sum, modulo 2, of those bits i of the index for which
 * i & j == j (Lucas), so that five steps, one for each bit of the number i, compute all.
 * Source: Sobol, "On the distribution of points in a cube" (1967), polynomial x + 1. */
static inline uint32_t gi_sobol_second(uint32_t index)
{
	index ^= (index & 0xaaaaaaaau) >> 1;
	index ^= (index & 0xccccccccu) >> 2;
	index ^= (index & 0xf0f0f0f0u) >> 4;
	index ^= (index & 0xff00ff00u) >> 8;
	return index ^ index >> 16;
}

/* The upper 24 bits as a fraction in [0, 1), exact in a float. */
static inline float gi_fraction(uint32_t x)
{
	return (float)(int32_t)(x >> 8) * 0x1p-24f;
}

/* A coordinate, given with its bits reversed, as an Owen-scrambled fraction in [0, 1). */
static inline float gi_owen_fraction(uint32_t x, uint32_t seed)
{
	return gi_fraction(gi_reverse(gi_owen_hash(x, seed)));
}

/* The shuffled index of a pair of dimensions; the point's index is given reversed. */
static inline uint32_t gi_sobol_index(uint64_t hash, uint32_t reversed_index, uint32_t dimension)
{
	return gi_reverse(gi_owen_hash(reversed_index, gi_seed(hash, GI_SEED_SHUFFLE + dimension)));
}

#endif
