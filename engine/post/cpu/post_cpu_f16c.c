/* Rows of half floats with F16C. Empty on other architectures. */
#include "post/cpu/post_cpu.h"

#if defined(__x86_64__)

#include <immintrin.h>

static void f16c_widen(const uint16_t *from, uint32_t count, post_texel *to)
{
	for (uint32_t i = 0; i < count; i++)
		to[i] = (post_texel)_mm_cvtph_ps(_mm_loadl_epi64((const __m128i *)(from + (size_t)4 * i)));
}

static void f16c_narrow(const post_texel *from, uint32_t count, uint16_t *to)
{
	for (uint32_t i = 0; i < count; i++)
		_mm_storel_epi64((__m128i *)(to + (size_t)4 * i), _mm_cvtps_ph((__m128)from[i], _MM_FROUND_TO_NEAREST_INT));
}

const post_cpu_rows post_cpu_rows_f16c = {f16c_widen, f16c_narrow};

#endif
