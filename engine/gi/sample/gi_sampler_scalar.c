/* The kernels one number at a time, in plain C: the reference for the vector versions. */
#include "gi/sample/gi_sampler_kernels.h"

static void scalar_sobol_8(uint64_t hash, uint32_t index, uint32_t first, float numbers[8])
{
	uint32_t reversed = gi_reverse(index);
	for (uint32_t i = 0; i < 8; i += 2) {
		uint32_t x = gi_sobol_index(hash, reversed, first + i), y = gi_sobol_second(x);
		numbers[i] = gi_owen_fraction(x, gi_seed(hash, first + i));
		numbers[i + 1] = gi_owen_fraction(y, gi_seed(hash, first + i + 1));
	}
}

static void scalar_random_8(uint64_t hash, uint32_t first, float numbers[8])
{
	for (uint32_t i = 0; i < 8; i++)
		numbers[i] = gi_fraction(gi_seed(hash, first + i));
}

const gi_sampler_kernels gi_sampler_kernels_scalar = {.sobol_8 = scalar_sobol_8, .random_8 = scalar_random_8};

#define EIGHT(x)                                                                                                       \
	{                                                                                                                  \
		x, x, x, x, x, x, x, x                                                                                         \
	}
#define BYTES4(x) x, x, x, x
#define TWICE(...)                                                                                                     \
	{                                                                                                                  \
		__VA_ARGS__, __VA_ARGS__                                                                                       \
	}
#define STEP(n) n##u *GI_SEED_STEP

const gi_sampler_constants_avx2 gi_sampler_constants = {
	.one = EIGHT(1),
	.seed_mix_1 = EIGHT(GI_SEED_MIX_1),
	.seed_mix_2 = EIGHT(GI_SEED_MIX_2),
	.owen_mix_1 = EIGHT(GI_OWEN_MIX_1),
	.owen_mix_2 = EIGHT(GI_OWEN_MIX_2),
	.owen_mix_3 = EIGHT(GI_OWEN_MIX_3),
	.steps = {STEP(0), STEP(1), STEP(2), STEP(3), STEP(4), STEP(5), STEP(6), STEP(7)},
	.pair_steps = {STEP(0), STEP(0), STEP(2), STEP(2), STEP(4), STEP(4), STEP(6), STEP(6)},
	.every_1 = EIGHT(0xaaaaaaaau),
	.every_2 = EIGHT(0xccccccccu),
	.every_4 = EIGHT(0xf0f0f0f0u),
	.every_8 = EIGHT(0xff00ff00u),
	.low_half = TWICE(BYTES4(15), BYTES4(15), BYTES4(15), BYTES4(15)),
	.reversed_half = TWICE(0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15),
	.swap_bytes = TWICE(3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12),
};
