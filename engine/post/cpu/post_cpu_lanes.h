/* Inside post/cpu/: arithmetic on eight numbers, which has the same bits in every instruction set. */
#ifndef POST_CPU_LANES_H
#define POST_CPU_LANES_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

/* No function hands a vector to another file, whose registers may differ; so -Wno-psabi. */
#define LANES_INLINE static inline __attribute__((always_inline))

typedef float lanes __attribute__((vector_size(32)));
typedef int32_t lanes_int __attribute__((vector_size(32)));                     /* of comparisons: -1 is true */
typedef float lanes_at __attribute__((vector_size(32), aligned(4), may_alias)); /* in memory, at any place */

LANES_INLINE lanes lanes_all(float x)
{
	return (lanes){x, x, x, x, x, x, x, x};
}

LANES_INLINE lanes lanes_load(const float *from)
{
	return *(const lanes_at *)from;
}

LANES_INLINE void lanes_store(lanes x, float *to)
{
	*(lanes_at *)to = x;
}

/* yes where the condition is true, else no. */
LANES_INLINE lanes lanes_select(lanes_int condition, lanes yes, lanes no)
{
	return (lanes)((condition & (lanes_int)yes) | (~condition & (lanes_int)no));
}

LANES_INLINE lanes lanes_min(lanes a, lanes b)
{
	return lanes_select(a < b, a, b);
}

LANES_INLINE lanes lanes_max(lanes a, lanes b)
{
	return lanes_select(a > b, a, b);
}

LANES_INLINE lanes lanes_clamp(lanes x, float low, float high)
{
	return lanes_min(lanes_max(x, lanes_all(low)), lanes_all(high));
}

LANES_INLINE lanes lanes_abs(lanes x)
{
	return (lanes)((lanes_int)x & INT32_MAX);
}

/* True if the condition is in some lane. */
LANES_INLINE bool lanes_any(lanes_int condition)
{
#if defined(__AVX__)
	return _mm256_movemask_ps((__m256)condition) != 0;
#else
	uint64_t parts[4];
	memcpy(parts, &condition, sizeof parts);
	return (parts[0] | parts[1] | parts[2] | parts[3]) != 0;
#endif
}

LANES_INLINE lanes lanes_root(lanes x)
{
#if defined(__AVX__)
	return (lanes)_mm256_sqrt_ps((__m256)x);
#elif defined(__x86_64__)
	__m128 half[2];
	memcpy(half, &x, sizeof half);
	half[0] = _mm_sqrt_ps(half[0]);
	half[1] = _mm_sqrt_ps(half[1]);
	memcpy(&x, half, sizeof half);
	return x;
#else
	for (int i = 0; i < 8; i++)
		x[i] = sqrtf(x[i]);
	return x;
#endif
}

/* To the nearest integer, ties to even; |x| < 2^22. */
LANES_INLINE lanes lanes_round(lanes x)
{
	lanes all = lanes_all(12582912.0f); /* 1.5 * 2^23: floats there are integers */
	return (x + all) - all;
}

LANES_INLINE lanes_int lanes_to_int(lanes x)
{
	return __builtin_convertvector(x, lanes_int);
}

LANES_INLINE lanes lanes_gather(const float *from, lanes_int at)
{
#if defined(__AVX2__)
	return (lanes)_mm256_i32gather_ps(from, (__m256i)at, 4);
#else
	lanes x;
	for (int i = 0; i < 8; i++)
		x[i] = from[at[i]];
	return x;
#endif
}

/* The angle in [0, pi] of a cosine in [-1, 1], within 1e-6. Source: Abramowitz, Stegun, "Handbook of Mathematical
 * Functions", 4.4.46. */
LANES_INLINE lanes lanes_acos(lanes cosine)
{
	static const float terms[8] = {1.5707963050f, -0.2145988016f, 0.0889789874f, -0.0501743046f,
	                               0.0308918810f, -0.0170881256f, 0.0066700901f, -0.0012624911f};
	lanes x = lanes_abs(cosine), sum = lanes_all(terms[7]);
	for (int i = 7; i-- > 0;)
		sum = sum * x + terms[i];
	lanes angle = lanes_root(1.0f - x) * sum;
	return lanes_select(cosine < 0.0f, 3.14159265f - angle, angle);
}

/* ---- three of them ----------------------------------------------------------------------------------------------- */

typedef struct lanes3 {
	lanes x, y, z;
} lanes3;

LANES_INLINE lanes3 lanes3_subtract(lanes3 a, lanes3 b)
{
	return (lanes3){a.x - b.x, a.y - b.y, a.z - b.z};
}

LANES_INLINE lanes3 lanes3_scale(lanes3 a, lanes by)
{
	return (lanes3){a.x * by, a.y * by, a.z * by};
}

LANES_INLINE lanes lanes3_dot(lanes3 a, lanes3 b)
{
	return a.x * b.x + a.y * b.y + a.z * b.z;
}

LANES_INLINE lanes3 lanes3_cross(lanes3 a, lanes3 b)
{
	return (lanes3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

LANES_INLINE lanes3 lanes3_select(lanes_int condition, lanes3 yes, lanes3 no)
{
	return (lanes3){lanes_select(condition, yes.x, no.x), lanes_select(condition, yes.y, no.y),
	                lanes_select(condition, yes.z, no.z)};
}

LANES_INLINE lanes3 lanes3_unit(lanes3 a)
{
	return lanes3_scale(a, 1.0f / lanes_root(lanes3_dot(a, a)));
}

#endif
