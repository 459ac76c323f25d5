/*
 * shade_sg: Spherical Gaussians, lobes on the sphere that can be multiplied and integrated in closed form. [any-thread]
 *
 *   G(v) = amplitude exp(sharpness (axis.v - 1))
 *
 * axis and v are unit; sharpness (lambda) in [0, 1e8]: 0 is a constant, 2 / alpha^2 is about a lobe of microfacets of
 * the width alpha (shade_specular.h); amplitude per channel, finite, in the unit of what the lobe stands for (radiance:
 * W sr^-1 m^-2). Integrals cover the whole sphere.
 *
 * Numbers. 1 - axis.v is |v - axis|^2 / 2 and is computed so: the difference of two near vectors is exact, and a lobe
 * of sharpness 1e6 keeps its shape. All integrals are computed from the mean of axis.v over the lobe
 * (shade_sg_mean_cosine), in a form that keeps its digits for a small sharpness and for a large one.
 * Sources: Karis, "Spherical Gaussians (part 1)" (2018), but for shade_sg_inner_product; Wang et al., "All-Frequency
 * Rendering of Dynamic, Spatially-Varying Reflectance" (2009); Tsai and Shih, "All-Frequency Precomputed Radiance
 * Transfer using Spherical Radial Basis Functions and Clustered Tensor Approximation" (2006).
 */
#ifndef SHADE_SG_H
#define SHADE_SG_H

#include "shade_constants.h"

#include "glsl_begin.h"

#define SHADE_SG_DIVISOR_MIN 1e-30f
#define SHADE_SG_SHARPNESS_MIN 1e-4f /* for 1 / sharpness: a lobe that has less counts as having this */
#define SHADE_SG_FRACTION_LIMIT 1.0f /* sharpness below which the mean cosine is a continued fraction */
#define SHADE_SG_FRACTION_FIRST 13   /* the innermost odd number of that fraction: it is exact to 1e-9 then */

SHADE_STRUCT(shade_sg)
{
	vec3 axis;
	float sharpness;
	vec3 amplitude;
};

/* The lobe's value in the unit direction v, by the formula above; where v is the axis, it is the amplitude. */
SHADE_FN vec3 shade_sg_evaluate(shade_sg g, vec3 v)
{
	vec3 apart = v - g.axis;
	return g.amplitude * exp(-0.5f * g.sharpness * dot(apart, apart));
}

/* coth(sharpness) - 1 = 2 exp(-2 sharpness) / (1 - exp(-2 sharpness)); sharpness >= SHADE_SG_FRACTION_LIMIT. */
SHADE_FN float shade_sg_coth_minus_one(float sharpness)
{
	float e = exp(-2.0f * sharpness);
	return 2.0f * e / (1.0f - e);
}

/* Mean of axis.v over the lobe, in [0, 1): coth(sharpness) - 1 / sharpness, Langevin's function.
 * Small sharpness x, where the two terms cancel: Gauss's continued fraction x / (3 + x^2 / (5 + x^2 / (7 + ...))).
 * Relative error below 1e-6. Source: Karis, "von Mises-Fisher (part 2)" (2018), length of r. */
SHADE_FN float shade_sg_mean_cosine(float sharpness)
{
	if (sharpness > SHADE_SG_FRACTION_LIMIT)
		return 1.0f - (1.0f / sharpness - shade_sg_coth_minus_one(sharpness));
	float fraction = float(SHADE_SG_FRACTION_FIRST);
	for (int odd = SHADE_SG_FRACTION_FIRST - 2; odd >= 3; odd -= 2)
		fraction = float(odd) + sharpness * sharpness / fraction;
	return sharpness / fraction;
}

/* Amplitude of the lobe whose integral is 1, sr^-1: sharpness / (2 pi (1 - exp(-2 sharpness))), and 1 / (4 pi) at 0.
 * With c = coth(x) - 1 / x, x / (1 - exp(-2 x)) is (1 + x (1 + c)) / 2: only sums of positive numbers.
 * Source: Karis, part 1, "Normalization". */
SHADE_FN float shade_sg_normalized_amplitude(float sharpness)
{
	return (1.0f + sharpness * (1.0f + shade_sg_mean_cosine(sharpness))) / (4.0f * SHADE_PI);
}

/* The lobe of the same axis and sharpness whose integral is 1 in each channel; g's own amplitude does not matter. */
SHADE_FN shade_sg shade_sg_normalize(shade_sg g)
{
	shade_sg unit = {g.axis, g.sharpness, vec3(shade_sg_normalized_amplitude(g.sharpness))};
	return unit;
}

/* Integral of G over the sphere: 2 pi amplitude (1 - exp(-2 sharpness)) / sharpness; 4 pi amplitude at sharpness 0.
 * Source: Tsai and Shih 2006. */
SHADE_FN vec3 shade_sg_integral(shade_sg g)
{
	return g.amplitude / shade_sg_normalized_amplitude(g.sharpness);
}

/* G1 G2, which is again a Spherical Gaussian, exactly. With u = sharpness1 axis1 + sharpness2 axis2:
 *   axis u / |u|, sharpness |u|, amplitude a1 a2 exp(|u| - sharpness1 - sharpness2)
 * The exponent is written as -s1 s2 |axis1 - axis2|^2 / (|u| + s1 + s2), the same without a difference of large
 * numbers. Opposite axes of equal sharpness (u = 0) leave a constant; its axis is axis1. Source: Wang et al. 2009. */
SHADE_FN shade_sg shade_sg_product(shade_sg g1, shade_sg g2)
{
	vec3 u = g1.axis * g1.sharpness + g2.axis * g2.sharpness;
	vec3 apart = g1.axis - g2.axis;
	float sharpness = length(u);
	float both = sharpness + g1.sharpness + g2.sharpness;
	float exponent = -g1.sharpness * g2.sharpness * dot(apart, apart) / max(both, SHADE_SG_DIVISOR_MIN);
	vec3 axis = select(sharpness > SHADE_SG_DIVISOR_MIN, u / sharpness, g1.axis);
	shade_sg product = {axis, sharpness, g1.amplitude * g2.amplitude * exp(exponent)};
	return product;
}

/* G^n, exactly: sharpness n, amplitude^n. amplitude >= 0, n > 0. Source: Karis, part 1, "Raising to a power". */
SHADE_FN shade_sg shade_sg_power(shade_sg g, float n)
{
	shade_sg power = {g.axis, g.sharpness * n, pow(g.amplitude, vec3(n))};
	return power;
}

/* Integral of G1 G2 over the sphere; light times lobe. Karis's formula with his |u| read as the length of the weighted
 * sum (printed, it is the length of the average: 1e-5 instead of 0.2 for sharpness 5 and 9 at 0.7 rad):
 *   2 pi a1 a2 (exp(|u| - s1 - s2) - exp(-|u| - s1 - s2)) / |u|
 * Here as the integral of the product, so that |u| = 0, sharpness 0 and 1e8 need no care. */
SHADE_FN vec3 shade_sg_inner_product(shade_sg g1, shade_sg g2)
{
	return shade_sg_integral(shade_sg_product(g1, g2));
}

/* G1 blurred by a lobe of G2's sharpness and amplitude (its axis has no part in it), approximately again a lobe:
 *   sharpness s1 s2 / (s1 + s2), amplitude 2 pi a1 a2 / (s1 + s2)
 * The amplitude here has the factor 1 - exp(-2 (s1 + s2)) that makes the peak exact and lets both sharpnesses be 0.
 * Error at any v, in parts of the peak: below 0.006 from sharpness 20 on (both), 0.08 at 2.
 * Source: Iwasaki et al., "Interactive Bi-scale Editing of Highly Glossy Materials" (2012). */
SHADE_FN shade_sg shade_sg_convolve(shade_sg g1, shade_sg g2)
{
	float both = g1.sharpness + g2.sharpness;
	float sharpness = g1.sharpness * g2.sharpness / max(both, SHADE_SG_DIVISOR_MIN);
	vec3 amplitude = g1.amplitude * g2.amplitude / shade_sg_normalized_amplitude(both);
	shade_sg blurred = {g1.axis, sharpness, amplitude};
	return blurred;
}

#include "glsl_end.h"
#endif
