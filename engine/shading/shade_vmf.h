/*
 * shade_vmf: von Mises-Fisher, the normal distribution of directions: a Spherical Gaussian whose integral is 1, fitted
 * to directions by their mean. [any-thread]
 *
 * Held as its axis and 1 / sharpness in [0, 1e4]: 0 is one direction, large is evenly all around, and nothing is
 * divided by a width that may be 0. For a lobe of microfacets of the width alpha (shade_specular.h) it is alpha^2 / 2.
 *
 * A mean direction is the average r of unit vectors, |r| in [0, 1]: its direction, and the spherical variance 1 - |r|,
 * which is held instead of |r|: where all directions lie within 1e-3, a float |r| has lost it.
 * Sources: Karis, "von Mises-Fisher (part 2)" (2018); Banerjee et al., "Clustering on the Unit Hypersphere using von
 * Mises-Fisher Distributions" (2005); Jakob, "Numerically stable sampling of the von Mises-Fisher distribution on S2"
 * (2012).
 */
#ifndef SHADE_VMF_H
#define SHADE_VMF_H

#include "shade_sg.h"

#include "glsl_begin.h"

#define SHADE_VMF_INVERSE_SHARPNESS_MIN 1e-9f
#define SHADE_VMF_MEAN_MIN 1e-4f /* |r| below which the mean has no direction */

SHADE_STRUCT(shade_vmf)
{
	vec3 axis;
	float inverse_sharpness;
};

/* r = (1 - variance) axis; axis is unit, variance in [0, 1]. */
SHADE_STRUCT(shade_mean_direction)
{
	vec3 axis;
	float variance;
};

/* Density, sr^-1, of the direction v; its integral over the sphere is 1. A 1 / sharpness below 1e-9 counts as that.
 * Source: Karis, part 2; Jakob 2012 (the form without sinh). */
SHADE_FN float shade_vmf_density(shade_vmf d, vec3 v)
{
	float sharpness = 1.0f / max(d.inverse_sharpness, SHADE_VMF_INVERSE_SHARPNESS_MIN);
	vec3 apart = v - d.axis;
	return shade_sg_normalized_amplitude(sharpness) * exp(-0.5f * sharpness * dot(apart, apart));
}

/* Spherical variance 1 - |r|, in [0, 1), from 1 / sharpness: 1 - coth(sharpness) + 1 / sharpness, to about 1e-7 and for
 * narrow lobes to 1e-6 of itself. 0 gives 0. Source: Karis, part 2, length of r. */
SHADE_FN float shade_vmf_variance(float inverse_sharpness)
{
	float sharpness = 1.0f / max(inverse_sharpness, SHADE_VMF_INVERSE_SHARPNESS_MIN);
	if (sharpness > SHADE_SG_FRACTION_LIMIT)
		return inverse_sharpness - shade_sg_coth_minus_one(sharpness);
	return 1.0f - shade_sg_mean_cosine(sharpness);
}

/* Slope of shade_vmf_variance, d variance / d (1 / sharpness), in (0, 1]: 1 - (x / sinh x)^2, x = sharpness. With the
 * mean cosine c it is x^2 - x^2 c^2 - 2 x c, which keeps its digits where x is small. */
SHADE_FN float shade_vmf_variance_slope(float inverse_sharpness)
{
	float x = 1.0f / max(inverse_sharpness, SHADE_VMF_INVERSE_SHARPNESS_MIN);
	if (x > SHADE_SG_FRACTION_LIMIT) {
		float e = exp(-2.0f * x);
		return 1.0f - 4.0f * x * x * e / ((1.0f - e) * (1.0f - e));
	}
	float c = shade_sg_mean_cosine(x);
	return x * (x - x * c * c - 2.0f * c);
}

/* 1 / sharpness from the spherical variance, fast: (1 - r^2) / (r (3 - r^2)), r = 1 - variance; as published,
 *   sharpness = r (3 - r^2) / (1 - r^2)
 * Exact at both ends, in between up to 4.7 % too narrow: sharpness 1 becomes 1.007, 5 becomes 5.25 (the worst), 50
 * becomes 50.5. variance in [0, 1]. Source: Banerjee et al. 2005. */
SHADE_FN float shade_vmf_inverse_sharpness_fast(float variance)
{
	float r = max(1.0f - variance, SHADE_VMF_MEAN_MIN);
	return variance * (2.0f - variance) / (r * (3.0f - r * r));
}

/* The same exactly, the inverse of shade_vmf_variance: two steps of Newton's method from the fast form, which leave an
 * error of 1e-9.
 * There remains the rounding of 1 - |r|, which weighs where |r| is small: 1e-6 up to 1 / sharpness = 1, 3e-4 at 100. */
SHADE_FN float shade_vmf_inverse_sharpness(float variance)
{
	float target = min(variance, 1.0f - SHADE_VMF_MEAN_MIN);
	float inverse = shade_vmf_inverse_sharpness_fast(target);
	for (int newton = 0; newton < 2; newton++)
		inverse += (target - shade_vmf_variance(inverse)) / shade_vmf_variance_slope(inverse);
	return max(inverse, 0.0f);
}

/* ---- means ------------------------------------------------------------------------------------------------------- */

/* r, the averaged vector: what can be filtered linearly, also by a GPU's texture unit. */
SHADE_FN vec3 shade_mean_direction_vector(shade_mean_direction mean)
{
	return mean.axis * (1.0f - mean.variance);
}

/* From r, |r| in [0, 1] (a longer one counts as 1). The variance comes out to 1e-7, not better. Where |r| is below
 * SHADE_VMF_MEAN_MIN there is no direction: +Z, variance 1. */
SHADE_FN shade_mean_direction shade_mean_direction_from_vector(vec3 r)
{
	float length2 = dot(r, r);
	float size = sqrt(length2);
	bool some = size > SHADE_VMF_MEAN_MIN;
	vec3 axis = select(some, r / max(size, SHADE_VMF_MEAN_MIN), vec3(0.0f, 0.0f, 1.0f));
	shade_mean_direction mean = {axis, select(some, clamp(1.0f - size, 0.0f, 1.0f), 1.0f)};
	return mean;
}

/* The mean of two sets of directions taken together, from the mean of each; weight in [0, 1] is the share of b. Exact,
 * in whatever order sets are joined, and to the last digits: along the new axis m each set has the mean
 * (1 - variance) axis.m, and 1 - axis.m is |axis - m|^2 / 2, so
 *   variance = sum of share (variance_i + (1 - variance_i) |axis_i - m|^2 / 2),
 * a sum of positive numbers. Sets that cancel out leave variance 1 about a's axis. */
SHADE_FN shade_mean_direction shade_mean_direction_mix(shade_mean_direction a, shade_mean_direction b, float weight)
{
	float of_a = (1.0f - weight) * (1.0f - a.variance);
	float of_b = weight * (1.0f - b.variance);
	vec3 r = a.axis * of_a + b.axis * of_b;
	float size = length(r);
	vec3 axis = select(size > SHADE_VMF_MEAN_MIN, r / max(size, SHADE_VMF_MEAN_MIN), a.axis);
	vec3 to_a = a.axis - axis;
	vec3 to_b = b.axis - axis;
	float within = mix(a.variance, b.variance, weight);
	float between = 0.5f * (of_a * dot(to_a, to_a) + of_b * dot(to_b, to_b));
	shade_mean_direction mean = {axis, min(within + between, 1.0f)};
	return mean;
}

/* The mean of a distribution, and the distribution of a mean: each is the other's inverse. Source: Karis, part 2. */
SHADE_FN shade_mean_direction shade_vmf_mean(shade_vmf d)
{
	shade_mean_direction mean = {d.axis, shade_vmf_variance(d.inverse_sharpness)};
	return mean;
}

SHADE_FN shade_vmf shade_vmf_from_mean(shade_mean_direction mean)
{
	shade_vmf d = {mean.axis, shade_vmf_inverse_sharpness(mean.variance)};
	return d;
}

/* ---- Spherical Gaussians as distributions ------------------------------------------------------------------------ */

/* The lobe whose integral is `weight`. Source: Karis, part 2, "G = w V". */
SHADE_FN shade_sg shade_sg_from_vmf(shade_vmf d, vec3 weight)
{
	float sharpness = 1.0f / max(d.inverse_sharpness, SHADE_VMF_INVERSE_SHARPNESS_MIN);
	shade_sg g = {d.axis, sharpness, weight * shade_sg_normalized_amplitude(sharpness)};
	return g;
}

/* The shape alone; shade_sg_integral is the weight that belongs to it. */
SHADE_FN shade_vmf shade_vmf_from_sg(shade_sg g)
{
	shade_vmf d = {g.axis, 1.0f / max(g.sharpness, SHADE_SG_SHARPNESS_MIN)};
	return d;
}

/* One lobe for G1 + G2: the integral is exact in each channel, and so is the mean direction, each lobe weighted by its
 * integral summed over the channels; the shape is the vMF of that mean. Good where the axes lie closer than the lobes
 * are wide: two sharp lobes far apart become a single wide one. Amplitudes >= 0; both 0: g1's shape, black.
 * Source: Karis, part 2, "Addition of SGs". */
SHADE_FN shade_sg shade_sg_add(shade_sg g1, shade_sg g2)
{
	vec3 integral1 = shade_sg_integral(g1);
	vec3 integral2 = shade_sg_integral(g2);
	float weight1 = integral1[0] + integral1[1] + integral1[2];
	float weight2 = integral2[0] + integral2[1] + integral2[2];
	shade_mean_direction mean1 = shade_vmf_mean(shade_vmf_from_sg(g1));
	shade_mean_direction mean2 = shade_vmf_mean(shade_vmf_from_sg(g2));
	float share2 = weight2 / max(weight1 + weight2, SHADE_SG_DIVISOR_MIN);
	return shade_sg_from_vmf(shade_vmf_from_mean(shade_mean_direction_mix(mean1, mean2, share2)),
	                         integral1 + integral2);
}

#include "glsl_end.h"
#endif
