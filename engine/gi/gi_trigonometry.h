/*
 * gi_trigonometry: sines, cosines and arc cosines without branches and calls, so that loops over lanes become SIMD; the
 * same bits for one number and for sixteen, in every instruction set. [any-thread]
 */
#ifndef STILB_GI_TRIGONOMETRY_H
#define STILB_GI_TRIGONOMETRY_H

#include "shading/shade_constants.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#define GI_LANE static inline __attribute__((always_inline))

/* yes where `where` is 1, no where it is 0. Of ?: compilers may make a branch, where a part of one side is a constant
 * or was computed before; then the loop around it does not become SIMD. */
GI_LANE float gi_select(int32_t where, float yes, float no)
{
	int32_t a, b, mask = -where;
	memcpy(&a, &yes, sizeof a);
	memcpy(&b, &no, sizeof b);
	a = (a & mask) | (b & ~mask);
	memcpy(&yes, &a, sizeof yes);
	return yes;
}

/* Sine and cosine of |x| <= pi / 4, relative error below 2e-8 and rounding: the series up to x^7 and x^8 with the last
 * three coefficients interpolated at Chebyshev's points of x^2. */
GI_LANE float gi_sine_small(float x)
{
	float t = x * x;
	return x + x * t * (-0.166666642f + t * (0.00833274703f + t * -0.00019587639f));
}

GI_LANE float gi_cosine_small(float x)
{
	float t = x * x;
	return 1.0f - 0.5f * t + t * t * (0.0416666642f + t * (-0.0013888299f + t * 2.45472802e-05f));
}

/* Of x in [0, 2 pi]: the nearest multiple of pi / 2, given in two parts of which the first has so few bits that it is
 * subtracted exactly, is taken away (Cody and Waite, "Software Manual for the Elementary Functions", 1980). */
GI_LANE void gi_sine_and_cosine(float x, float *sine, float *cosine)
{
	int32_t quarter = (int32_t)(x * (2.0f * SHADE_INV_PI) + 0.5f);
	float rest = (x - (float)quarter * 1.5703125f) - (float)quarter * 4.83826795e-4f;
	float s = gi_sine_small(rest), c = gi_cosine_small(rest);
	float across = gi_select(quarter & 1, c, s), along = gi_select(quarter & 1, s, c);
	*sine = gi_select(quarter >> 1 & 1, -across, across);
	*cosine = gi_select((quarter + 1) >> 1 & 1, -along, along);
}

/* |x| <= 1. The error is at most 2e-8 and rounding. Source: Abramowitz and Stegun, "Handbook of Mathematical Functions"
 * (1964), 4.4.46. */
GI_LANE float gi_arc_cosine(float x)
{
	float size = fabsf(x);
	float p = 0.0066700901f - 0.0012624911f * size;
	p = -0.0170881256f + p * size;
	p = 0.0308918810f + p * size;
	p = -0.0501743046f + p * size;
	p = 0.0889789874f + p * size;
	p = -0.2145988016f + p * size;
	p = 1.5707963050f + p * size;
	float angle = sqrtf(1.0f - size) * p;
	return gi_select(x < 0.0f, SHADE_PI - angle, angle);
}

#endif
