/*
 * shade_constants: numbers that several shading headers need, and logarithm and exponential where the plain form would
 * lose its digits: log(1 + x) and 1 - exp(-x) for small x. Narrow lobes live there: (n.h)^n with n = 10^6 is decided by
 * 1 - n.h = 10^-6. [any-thread]
 *
 * Near 0 both are Taylor series in nested form, whose coefficients are 1 / k: made from the loop's integers, so that
 * there is no constant to get wrong, and the GPU, which may round log and exp more coarsely, agrees with C. The loops
 * have a fixed count and are unrolled.
 */
#ifndef SHADE_CONSTANTS_H
#define SHADE_CONSTANTS_H

#include "glsl_begin.h"

#define SHADE_PI 3.14159265358979323846f
#define SHADE_INV_PI 0.31830988618379067154f

/* The series is used below it; above it log and exp lose no more than one or two bits. */
#define SHADE_SERIES_LIMIT 0.25f

/* log(1 + x), x > -1, relative error below 4e-7. Series of 2 atanh(s), s = x / (2 + x): 2 (s + s^3/3 + s^5/5 + s^7/7),
 * whose first term left out is 2 10^-8 of the sum at |s| = 1/7. */
SHADE_FN float shade_log1p(float x)
{
	float s = x / (2.0f + x);
	float s2 = s * s;
	float sum = 0.0f;
	for (int k = 7; k > 0; k -= 2)
		sum = sum * s2 + 1.0f / float(k);
	return select(abs(x) < SHADE_SERIES_LIMIT, 2.0f * s * sum, log(1.0f + x));
}

/* 1 - exp(-x), x >= 0, relative error below 4e-7. Series: x (1 - x/2 (1 - x/3 (1 - x/4 (1 - x/5 (1 - x/6))))), whose
 * first term left out is 5 10^-8 of the sum. */
SHADE_FN float shade_one_minus_exp(float x)
{
	float sum = 0.0f;
	for (int k = 7; k > 1; k--)
		sum = 1.0f - sum * x / float(k);
	return select(x < SHADE_SERIES_LIMIT, x * sum, 1.0f - exp(-x));
}

#include "glsl_end.h"
#endif
