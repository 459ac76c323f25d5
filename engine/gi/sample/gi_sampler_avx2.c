/* The sampler's kernels (gi_sampler_kernels.h) with AVX2: eight dimensions, which are four pairs, at a time. */
#include "gi/sample/gi_sampler_kernels.h"

#if defined(__x86_64__)
#include <immintrin.h>

#define INLINE static inline __attribute__((always_inline))

/* Constants are loaded from a table that is opaque to the compiler: if it saw them, it would build each in a general
 * register, which takes half as long as all the rest. */
#define CONSTANT(name) _mm256_load_si256((const __m256i *)gi_sampler_constants.name)

/* gi_seed for eight numbers, `number` plus eight offsets; steps holds the offsets times GI_SEED_STEP. */
INLINE __m256i avx2_seed(uint64_t hash, uint32_t number, __m256i steps)
{
	__m256i x = _mm256_add_epi32(steps, _mm256_set1_epi32((int)(number * GI_SEED_STEP + (uint32_t)hash)));
	x = _mm256_xor_si256(x, _mm256_srli_epi32(x, 16));
	x = _mm256_mullo_epi32(x, CONSTANT(seed_mix_1));
	x = _mm256_add_epi32(x, _mm256_set1_epi32((int)(uint32_t)(hash >> 32)));
	x = _mm256_xor_si256(x, _mm256_srli_epi32(x, 15));
	x = _mm256_mullo_epi32(x, CONSTANT(seed_mix_2));
	return _mm256_xor_si256(x, _mm256_srli_epi32(x, 16));
}

/* gi_owen_hash */
INLINE __m256i avx2_owen_hash(__m256i x, __m256i seed)
{
	__m256i odd = _mm256_or_si256(_mm256_srli_epi32(seed, 16), CONSTANT(one));
	x = _mm256_xor_si256(x, _mm256_mullo_epi32(x, CONSTANT(owen_mix_1)));
	x = _mm256_mullo_epi32(_mm256_add_epi32(x, seed), odd);
	x = _mm256_xor_si256(x, _mm256_mullo_epi32(x, CONSTANT(owen_mix_2)));
	return _mm256_xor_si256(x, _mm256_mullo_epi32(x, CONSTANT(owen_mix_3)));
}

/* gi_reverse: reverses the nibbles by a table, then swaps the bytes. */
INLINE __m256i avx2_reverse(__m256i x)
{
	__m256i table = CONSTANT(reversed_half), half = CONSTANT(low_half);
	__m256i low = _mm256_slli_epi32(_mm256_shuffle_epi8(table, _mm256_and_si256(x, half)), 4);
	__m256i high = _mm256_shuffle_epi8(table, _mm256_and_si256(_mm256_srli_epi32(x, 4), half));
	return _mm256_shuffle_epi8(_mm256_or_si256(low, high), CONSTANT(swap_bytes));
}

/* x ^ (x & mask) >> shift */
#define FOLD(x, mask, shift) _mm256_xor_si256(x, _mm256_srli_epi32(_mm256_and_si256(x, CONSTANT(mask)), shift))

/* gi_sobol_second */
INLINE __m256i avx2_sobol_second(__m256i x)
{
	x = FOLD(x, every_1, 1);
	x = FOLD(x, every_2, 2);
	x = FOLD(x, every_4, 4);
	x = FOLD(x, every_8, 8);
	return _mm256_xor_si256(x, _mm256_srli_epi32(x, 16));
}

/* gi_fraction */
INLINE __m256 avx2_fraction(__m256i x)
{
	return _mm256_mul_ps(_mm256_cvtepi32_ps(_mm256_srli_epi32(x, 8)), _mm256_set1_ps(0x1p-24f));
}

/* sobol_8 of gi_sampler_kernels. The two lanes of a pair of dimensions compute the same index, until one of them turns
 * it into the second coordinate of the point. */
static void avx2_sobol_8(uint64_t hash, uint32_t index, uint32_t first, float numbers[8])
{
	STILB_ASSERT((uintptr_t)&gi_sampler_constants % 32 == 0);
	__m256i shuffle_seed = avx2_seed(hash, first + GI_SEED_SHUFFLE, CONSTANT(pair_steps));
	__m256i x = avx2_reverse(avx2_owen_hash(_mm256_set1_epi32((int)gi_reverse(index)), shuffle_seed));
	x = _mm256_blend_epi32(x, avx2_sobol_second(x), 0xaa);
	__m256i scrambled = avx2_owen_hash(x, avx2_seed(hash, first, CONSTANT(steps)));
	_mm256_storeu_ps(numbers, avx2_fraction(avx2_reverse(scrambled)));
}

static void avx2_random_8(uint64_t hash, uint32_t first, float numbers[8])
{
	_mm256_storeu_ps(numbers, avx2_fraction(avx2_seed(hash, first, CONSTANT(steps))));
}

const gi_sampler_kernels gi_sampler_kernels_avx2 = {.sobol_8 = avx2_sobol_8, .random_8 = avx2_random_8};

#endif
