/*
 * shade_firefly: an average in which one very bright, badly sampled value does not drown all others. [any-thread]
 *
 * Each value is weighted by how much the simple tone curve dims it: range / (range + luminance). The weighted mean is
 * then the same as: tone map each value, average, tone map back. This holds because luminance is linear: the mean's
 * luma is the mean of the lumas. (A luma is the one number of a colour that the curve is applied to, shade_tonemap.h.)
 * With the largest channel as luma, or with the curve that is linear up to a, weighted mean and tone mapped average
 * differ, and who wants the latter must really tone map, average and invert.
 * It is biased: as bright as the plain mean at most, far below it where few bright values carry the light (caustics),
 * and the plain mean itself where range is far above all values.
 *
 * Colours are linear, each channel in [0, 1e30].
 * Source: Karis, "Tone mapping" (2013), weight.
 */
#ifndef SHADE_FIREFLY_H
#define SHADE_FIREFLY_H

#include "shade_luminance.h"

#include "glsl_begin.h"

#define SHADE_FIREFLY_WEIGHT_MIN 1e-32f /* less than any value weighs: with no values the mean is 0, not 0 / 0 */

/* 1 / (1 + luma / range), in (0, 1]; luma >= 0, range > 0. */
SHADE_FN float shade_firefly_weight(float luma, float range)
{
	return range / (range + luma);
}

/* The sums that an average is made from (xyz: weighted colours, w: weights) after one more value. They start as 0; sums
 * over parts of the values may be added up. */
SHADE_FN vec4 shade_firefly_add(vec4 sums, vec3 color, float range)
{
	float weight = shade_firefly_weight(shade_luminance(color), range);
	return sums + vec4(color * weight, weight);
}

/* The average that the sums stand for. */
SHADE_FN vec3 shade_firefly_mean(vec4 sums)
{
	return vec3(sums[0], sums[1], sums[2]) / max(sums[3], SHADE_FIREFLY_WEIGHT_MIN);
}

#include "glsl_end.h"
#endif
