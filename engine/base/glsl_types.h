/*
 * glsl_types: GLSL's built-in functions in C, for stilb_vec2, stilb_vec3 and stilb_vec4. They are the C half of the
 * shading dialect, in which the files in engine/shading are written so that both C and GLSL compile them. Those files
 * never call these functions by name: glsl_begin.h maps the GLSL names to them.
 *
 * Names.    glsl_<function>_1 takes floats, _2 a vec2, _4 a vec3 or vec4 (one type in C: all four lanes are computed,
 *           and lane 3 of a vec3 stays unspecified). A trailing f says that the other operands are floats. dot, length,
 *           distance, normalize, cross and reflect look at three lanes; glsl_dot4 at four.
 * Meaning.  As in the OpenGL Shading Language Specification 4.60, chapter 8. A result that it leaves undefined (pow of
 *           a negative base, clamp with min > max, NaN in min and max) is unspecified here, too, and never asserted.
 * Threads.  Pure functions: [any-thread].
 */
#ifndef STILB_GLSL_TYPES_H
#define STILB_GLSL_TYPES_H

#ifdef __cplusplus
#error "the shading dialect is C and GLSL: C++ has no _Generic"
#endif

#include "base/base_math.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

typedef uint32_t glsl_uint;

/* ---- one value at a time ----------------------------------------------------------------------------------------- */

static inline float glsl_abs_1(float x)
{
	return fabsf(x);
}

static inline float glsl_sign_1(float x)
{
	return x > 0.0f ? 1.0f : x < 0.0f ? -1.0f : 0.0f;
}

static inline float glsl_floor_1(float x)
{
	return floorf(x);
}

static inline float glsl_ceil_1(float x)
{
	return ceilf(x);
}

static inline float glsl_fract_1(float x)
{
	return x - floorf(x);
}

static inline float glsl_sqrt_1(float x)
{
	return sqrtf(x);
}

static inline float glsl_inversesqrt_1(float x)
{
	return 1.0f / sqrtf(x);
}

static inline float glsl_exp_1(float x)
{
	return expf(x);
}

static inline float glsl_exp2_1(float x)
{
	return exp2f(x);
}

static inline float glsl_log_1(float x)
{
	return logf(x);
}

static inline float glsl_log2_1(float x)
{
	return log2f(x);
}

static inline float glsl_sin_1(float x)
{
	return sinf(x);
}

static inline float glsl_cos_1(float x)
{
	return cosf(x);
}

static inline float glsl_tan_1(float x)
{
	return tanf(x);
}

static inline float glsl_asin_1(float x)
{
	return asinf(x);
}

static inline float glsl_acos_1(float x)
{
	return acosf(x);
}

static inline float glsl_atan_1(float y_over_x)
{
	return atanf(y_over_x);
}

static inline float glsl_atan2_1(float y, float x)
{
	return atan2f(y, x);
}

static inline float glsl_pow_1(float x, float y)
{
	return powf(x, y);
}

static inline float glsl_mod_1(float x, float y)
{
	return x - y * floorf(x / y);
}

static inline float glsl_min_1(float x, float y)
{
	return y < x ? y : x;
}

static inline float glsl_max_1(float x, float y)
{
	return x < y ? y : x;
}

static inline float glsl_step_1(float edge, float x)
{
	return x < edge ? 0.0f : 1.0f;
}

static inline float glsl_clamp_1(float x, float low, float high)
{
	return glsl_min_1(glsl_max_1(x, low), high);
}

static inline float glsl_mix_1(float x, float y, float a)
{
	return x * (1.0f - a) + y * a;
}

static inline float glsl_smoothstep_1(float edge0, float edge1, float x)
{
	float t = glsl_clamp_1((x - edge0) / (edge1 - edge0), 0.0f, 1.0f);
	return t * t * (3.0f - 2.0f * t);
}

/* ---- lane by lane ------------------------------------------------------------------------------------------------ */

#define GLSL_LANES1(name)                                                                                              \
	static inline stilb_vec2 glsl_##name##_2(stilb_vec2 x)                                                             \
	{                                                                                                                  \
		return (stilb_vec2){glsl_##name##_1(x[0]), glsl_##name##_1(x[1])};                                             \
	}                                                                                                                  \
	static inline stilb_vec4 glsl_##name##_4(stilb_vec4 x)                                                             \
	{                                                                                                                  \
		return (stilb_vec4){glsl_##name##_1(x[0]), glsl_##name##_1(x[1]), glsl_##name##_1(x[2]),                       \
		                    glsl_##name##_1(x[3])};                                                                    \
	}

#define GLSL_LANES2(name)                                                                                              \
	static inline stilb_vec2 glsl_##name##_2(stilb_vec2 x, stilb_vec2 y)                                               \
	{                                                                                                                  \
		return (stilb_vec2){glsl_##name##_1(x[0], y[0]), glsl_##name##_1(x[1], y[1])};                                 \
	}                                                                                                                  \
	static inline stilb_vec4 glsl_##name##_4(stilb_vec4 x, stilb_vec4 y)                                               \
	{                                                                                                                  \
		return (stilb_vec4){glsl_##name##_1(x[0], y[0]), glsl_##name##_1(x[1], y[1]), glsl_##name##_1(x[2], y[2]),     \
		                    glsl_##name##_1(x[3], y[3])};                                                              \
	}

#define GLSL_LANES3(name)                                                                                              \
	static inline stilb_vec2 glsl_##name##_2(stilb_vec2 x, stilb_vec2 y, stilb_vec2 z)                                 \
	{                                                                                                                  \
		return (stilb_vec2){glsl_##name##_1(x[0], y[0], z[0]), glsl_##name##_1(x[1], y[1], z[1])};                     \
	}                                                                                                                  \
	static inline stilb_vec4 glsl_##name##_4(stilb_vec4 x, stilb_vec4 y, stilb_vec4 z)                                 \
	{                                                                                                                  \
		return (stilb_vec4){glsl_##name##_1(x[0], y[0], z[0]), glsl_##name##_1(x[1], y[1], z[1]),                      \
		                    glsl_##name##_1(x[2], y[2], z[2]), glsl_##name##_1(x[3], y[3], z[3])};                     \
	}

GLSL_LANES1(abs)
GLSL_LANES1(sign)
GLSL_LANES1(floor)
GLSL_LANES1(ceil)
GLSL_LANES1(fract)
GLSL_LANES1(sqrt)
GLSL_LANES1(inversesqrt)
GLSL_LANES1(exp)
GLSL_LANES1(exp2)
GLSL_LANES1(log)
GLSL_LANES1(log2)
GLSL_LANES1(sin)
GLSL_LANES1(cos)
GLSL_LANES1(tan)
GLSL_LANES1(asin)
GLSL_LANES1(acos)
GLSL_LANES1(atan)
GLSL_LANES2(atan2)
GLSL_LANES2(pow)
GLSL_LANES2(mod)
GLSL_LANES2(min)
GLSL_LANES2(max)
GLSL_LANES2(step)
GLSL_LANES3(clamp)
GLSL_LANES3(mix)
GLSL_LANES3(smoothstep)

#undef GLSL_LANES1
#undef GLSL_LANES2
#undef GLSL_LANES3

/* ---- constructors ------------------------------------------------------------------------------------------------ */

static inline stilb_vec2 glsl_vec2_splat(float s)
{
	return (stilb_vec2){s, s};
}

static inline stilb_vec2 glsl_vec2_same(stilb_vec2 v)
{
	return v;
}

static inline stilb_vec2 glsl_vec2_first(stilb_vec4 v)
{
	return (stilb_vec2){v[0], v[1]};
}

static inline stilb_vec2 glsl_vec2_make2(float x, float y)
{
	return (stilb_vec2){x, y};
}

static inline stilb_vec4 glsl_vec4_splat(float s)
{
	return (stilb_vec4){s, s, s, s};
}

static inline stilb_vec4 glsl_vec4_same(stilb_vec4 v)
{
	return v;
}

static inline stilb_vec3 glsl_vec3_make2(stilb_vec2 v, float z)
{
	return (stilb_vec3){v[0], v[1], z, 0.0f};
}

static inline stilb_vec3 glsl_vec3_make3(float x, float y, float z)
{
	return (stilb_vec3){x, y, z, 0.0f};
}

static inline stilb_vec4 glsl_vec4_make2(stilb_vec3 v, float w)
{
	return (stilb_vec4){v[0], v[1], v[2], w};
}

static inline stilb_vec4 glsl_vec4_make4(float x, float y, float z, float w)
{
	return (stilb_vec4){x, y, z, w};
}

/* ---- a vector first, scalars second ------------------------------------------------------------------------------ */

#define GLSL_SCALAR2(name)                                                                                             \
	static inline stilb_vec2 glsl_##name##_2f(stilb_vec2 x, float y)                                                   \
	{                                                                                                                  \
		return glsl_##name##_2(x, glsl_vec2_splat(y));                                                                 \
	}                                                                                                                  \
	static inline stilb_vec4 glsl_##name##_4f(stilb_vec4 x, float y)                                                   \
	{                                                                                                                  \
		return glsl_##name##_4(x, glsl_vec4_splat(y));                                                                 \
	}

GLSL_SCALAR2(min)
GLSL_SCALAR2(max)
GLSL_SCALAR2(mod)

#undef GLSL_SCALAR2

static inline stilb_vec2 glsl_clamp_2f(stilb_vec2 x, float low, float high)
{
	return glsl_clamp_2(x, glsl_vec2_splat(low), glsl_vec2_splat(high));
}

static inline stilb_vec4 glsl_clamp_4f(stilb_vec4 x, float low, float high)
{
	return glsl_clamp_4(x, glsl_vec4_splat(low), glsl_vec4_splat(high));
}

static inline stilb_vec2 glsl_mix_2f(stilb_vec2 x, stilb_vec2 y, float a)
{
	return glsl_mix_2(x, y, glsl_vec2_splat(a));
}

static inline stilb_vec4 glsl_mix_4f(stilb_vec4 x, stilb_vec4 y, float a)
{
	return glsl_mix_4(x, y, glsl_vec4_splat(a));
}

/* step and smoothstep keep GLSL's order: the edges come first. */
static inline stilb_vec2 glsl_step_2f(float edge, stilb_vec2 x)
{
	return glsl_step_2(glsl_vec2_splat(edge), x);
}

static inline stilb_vec4 glsl_step_4f(float edge, stilb_vec4 x)
{
	return glsl_step_4(glsl_vec4_splat(edge), x);
}

static inline stilb_vec2 glsl_smoothstep_2f(float edge0, float edge1, stilb_vec2 x)
{
	return glsl_smoothstep_2(glsl_vec2_splat(edge0), glsl_vec2_splat(edge1), x);
}

static inline stilb_vec4 glsl_smoothstep_4f(float edge0, float edge1, stilb_vec4 x)
{
	return glsl_smoothstep_4(glsl_vec4_splat(edge0), glsl_vec4_splat(edge1), x);
}

/* ---- geometry: two lanes of a vec2, three of a vec3 -------------------------------------------------------------- */

static inline float glsl_dot_2(stilb_vec2 a, stilb_vec2 b)
{
	return a[0] * b[0] + a[1] * b[1];
}

static inline float glsl_dot_3(stilb_vec3 a, stilb_vec3 b)
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline float glsl_dot4(stilb_vec4 a, stilb_vec4 b)
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

static inline float glsl_length_2(stilb_vec2 v)
{
	return sqrtf(glsl_dot_2(v, v));
}

static inline float glsl_length_3(stilb_vec3 v)
{
	return sqrtf(glsl_dot_3(v, v));
}

static inline float glsl_distance_2(stilb_vec2 a, stilb_vec2 b)
{
	return glsl_length_2(a - b);
}

static inline float glsl_distance_3(stilb_vec3 a, stilb_vec3 b)
{
	return glsl_length_3(a - b);
}

static inline stilb_vec2 glsl_normalize_2(stilb_vec2 v)
{
	return v * glsl_inversesqrt_1(glsl_dot_2(v, v));
}

static inline stilb_vec3 glsl_normalize_3(stilb_vec3 v)
{
	return v * glsl_inversesqrt_1(glsl_dot_3(v, v));
}

static inline stilb_vec3 glsl_cross(stilb_vec3 a, stilb_vec3 b)
{
	return glsl_vec3_make3(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]);
}

/* The direction i, which points to the surface, as in GLSL, mirrored at the surface of unit normal n. */
static inline stilb_vec2 glsl_reflect_2(stilb_vec2 i, stilb_vec2 n)
{
	return i - n * (2.0f * glsl_dot_2(n, i));
}

static inline stilb_vec3 glsl_reflect_3(stilb_vec3 i, stilb_vec3 n)
{
	return i - n * (2.0f * glsl_dot_3(n, i));
}

/* ---- bits -------------------------------------------------------------------------------------------------------- */

static inline glsl_uint glsl_float_bits(float x)
{
	union {
		float f;
		glsl_uint u;
	} bits = {.f = x};
	return bits.u;
}

static inline float glsl_bits_float(glsl_uint x)
{
	union {
		glsl_uint u;
		float f;
	} bits = {.u = x};
	return bits.f;
}

#endif
