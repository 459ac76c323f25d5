/*
 * shade_normal_filter: a normal and a roughness that stand for many: what mip chains of normal maps hold, so that a
 * bumpy surface seen from afar becomes rough instead of smooth or sparkling. [any-thread]
 *
 * A texel is a lobe of microfacet normals: a unit normal, and a width alpha = roughness^2 in [SHADE_ALPHA_MIN, 1]. A
 * filter turns texels into something that can be averaged, and the average back into a lobe. Here stand both steps; the
 * loop over a picture is image/image_normals.h.
 *
 * | filter      | averages                                  | smooth normals outweigh rough | anisotropic | space   |
 * |-------------|-------------------------------------------|-------------------------------|-------------|---------|
 * | vMF         | r of the lobe itself                      | yes                           | no          | any     |
 * | Toksvig     | normals as long as they are glossy        | yes                           | no          | any     |
 * | variance    | unit normals, and alpha^2 beside them     | no                            | no          | any     |
 * | convolution | the same                                  | no                            | no          | any     |
 * | LEAN        | slopes, and their covariance with alpha^2 | no                            | yes         | tangent |
 *
 * r is the average vector of a lobe's directions. The first four average mean directions (shade_vmf.h), which are such
 * vectors; what comes out is the mean's axis as normal, and an alpha from its variance. All work in 1 / sharpness =
 * alpha^2 / 2: a flat, smooth patch has 0 there and nothing is divided by it.
 * Use vMF, and LEAN where bumps have a grain; the others are for comparison and for data that was made with them.
 * Sources: Karis, "Normal map filtering using vMF (part 3)" (2018); Toksvig, "Mipmapping Normal Maps" (2004); Olano and
 * Baker, "LEAN Mapping" (2010).
 */
#ifndef SHADE_NORMAL_FILTER_H
#define SHADE_NORMAL_FILTER_H

#include "shade_specular.h"
#include "shade_vmf.h"

#include "glsl_begin.h"

#define SHADE_FILTER_LENGTH_MIN 1e-4f
#define SHADE_LEAN_Z_MIN 0.02f /* least z of a normal: slopes x / z and y / z end at 50 */
#define SHADE_LEAN_VARIANCE_MIN 1e-12f

SHADE_STRUCT(shade_rough_normal)
{
	vec3 normal;
	float alpha;
};

/* 1 / sharpness of a lobe of microfacet normals: alpha^2 / 2. Made for Beckmann, near enough for Blinn and GGX.
 * Source: Wang et al., "All-Frequency Rendering of Dynamic, Spatially-Varying Reflectance" (2009). */
SHADE_FN float shade_filter_inverse_sharpness(float alpha)
{
	return 0.5f * alpha * alpha;
}

/* Its inverse, sqrt(2 / sharpness), clamped to [SHADE_ALPHA_MIN, 1]. */
SHADE_FN float shade_filter_alpha(float inverse_sharpness)
{
	return clamp(sqrt(2.0f * inverse_sharpness), SHADE_ALPHA_MIN, 1.0f);
}

/* ---- vMF: the lobes themselves are averaged ---------------------------------------------------------------------- */

SHADE_FN shade_mean_direction shade_filter_vmf_mean(shade_rough_normal texel)
{
	shade_vmf lobe = {texel.normal, shade_filter_inverse_sharpness(texel.alpha)};
	return shade_vmf_mean(lobe);
}

/* Exact inverse of shade_filter_vmf_mean: a patch of equal texels keeps its alpha. */
SHADE_FN shade_rough_normal shade_filter_vmf(shade_mean_direction mean)
{
	shade_rough_normal texel = {mean.axis, shade_filter_alpha(shade_vmf_inverse_sharpness(mean.variance))};
	return texel;
}

/* For textures that the GPU filters, as published: the vector r goes in, and comes out averaged. A float r knows
 * 1 - |r| to 1e-7, so alpha is good from 0.01 on; the fast inverse makes it at most 2.4 % too small. */
SHADE_FN vec3 shade_filter_vmf_encode(shade_rough_normal texel)
{
	return shade_mean_direction_vector(shade_filter_vmf_mean(texel));
}

SHADE_FN shade_rough_normal shade_filter_vmf_decode(vec3 average)
{
	shade_mean_direction mean = shade_mean_direction_from_vector(average);
	shade_rough_normal texel = {mean.axis, shade_filter_alpha(shade_vmf_inverse_sharpness_fast(mean.variance))};
	return texel;
}

/* ---- Toksvig ----------------------------------------------------------------------------------------------------- */

/* What the averaging of unit normals does to Blinn-Phong's exponent s: the factor |N| / (|N| + s (1 - |N|)) in [0, 1].
 * variance is 1 - |N|, s >= 0; the same as 1 / s' = 1 / s + (1 - |N|) / |N|. Source: Toksvig 2004, f_t. */
SHADE_FN float shade_toksvig_factor(float variance, float exponent)
{
	float size = max(1.0f - variance, SHADE_FILTER_LENGTH_MIN);
	return size / (size + exponent * variance);
}

/* The texel as a normal of the length s / (s + 1), which then needs no gloss map: the variance is 1 / (s + 1), and with
 * s = 2 / alpha^2 - 2 it is alpha^2 / (2 - alpha^2). Source: Toksvig 2004, "Free Gloss Maps". */
SHADE_FN shade_mean_direction shade_filter_toksvig_mean(shade_rough_normal texel)
{
	float alpha2 = texel.alpha * texel.alpha;
	shade_mean_direction mean = {texel.normal, alpha2 / (2.0f - alpha2)};
	return mean;
}

/* The inverse: s = |N| / (1 - |N|), alpha^2 = 2 / (s + 2) = 2 variance / (1 + variance). */
SHADE_FN shade_rough_normal shade_filter_toksvig(shade_mean_direction mean)
{
	float alpha = sqrt(2.0f * mean.variance / (1.0f + mean.variance));
	shade_rough_normal texel = {mean.axis, clamp(alpha, SHADE_ALPHA_MIN, 1.0f)};
	return texel;
}

/* ---- widening by the variance of unit normals -------------------------------------------------------------------- */

/* A texel without its width: the normal alone. */
SHADE_FN shade_mean_direction shade_filter_normal_mean(vec3 normal)
{
	shade_mean_direction mean = {normal, 0.0f};
	return mean;
}

/* The common form, usually called Toksvig: alpha'^2 = alpha^2 + 2 sigma^2 with his sigma^2 = (1 - |N|) / |N|.
 * alpha2 is the average of alpha^2, [0, 1]. Source: Karis, part 3, on what engines do. */
SHADE_FN shade_rough_normal shade_filter_variance(shade_mean_direction mean, float alpha2)
{
	float sigma2 = mean.variance / max(1.0f - mean.variance, SHADE_FILTER_LENGTH_MIN);
	shade_rough_normal texel = {mean.axis, clamp(sqrt(alpha2 + 2.0f * sigma2), SHADE_ALPHA_MIN, 1.0f)};
	return texel;
}

/* The lobe convolved with the vMF of the normals: alpha'^2 = alpha^2 + 2 / sharpness; for equal texels alpha itself.
 * alpha2 is the average of alpha^2, [0, 1]. Source: Karis, part 3 (his 2, against 1/2 and 1 in Neubelt and Pettineo,
 * "Crafting a Next-Gen Material Pipeline for The Order: 1886" (2013)); Han et al., "Frequency Domain Normal Map
 * Filtering" (2007). */
SHADE_FN shade_rough_normal shade_filter_convolution(shade_mean_direction mean, float alpha2)
{
	float inverse_sharpness = shade_vmf_inverse_sharpness(mean.variance);
	shade_rough_normal texel = {mean.axis, clamp(sqrt(alpha2 + 2.0f * inverse_sharpness), SHADE_ALPHA_MIN, 1.0f)};
	return texel;
}

/* ---- LEAN: slopes in the tangent plane --------------------------------------------------------------------------- */

/* Gaussian of the slopes (x / z, y / z) of microfacet normals: its centre, and its covariance (xx, yy, xy). Held
 * about that centre: got from the published second moments M = covariance + slope slope^T it would lose its digits on
 * steep, smooth patches. */
SHADE_STRUCT(shade_lean)
{
	vec2 slope;
	vec3 covariance;
};

/* The texel's normal, where +Z is the surface's own normal, gives the centre; its alpha gives the variance alpha^2 / 2
 * along each axis, that of Beckmann's distribution (Olano and Baker: 1 / s, with Blinn-Phong's exponent s). A normal
 * with a z below SHADE_LEAN_Z_MIN is taken as if it had that z. */
SHADE_FN shade_lean shade_lean_from_normal(shade_rough_normal texel)
{
	float inverse_z = 1.0f / max(texel.normal[2], SHADE_LEAN_Z_MIN);
	float variance = shade_filter_inverse_sharpness(texel.alpha);
	shade_lean lean = {vec2(texel.normal[0], texel.normal[1]) * inverse_z, vec3(variance, variance, 0.0f)};
	return lean;
}

/* Average of both; weight in [0, 1] is the share of b. Exact, in whatever order texels are averaged: the covariance is
 * the average of the two plus that of the two centres about the new one. Source: Chan, Golub, LeVeque, "Updating
 * Formulae and a Pairwise Algorithm for Computing Sample Variances" (1979). */
SHADE_FN shade_lean shade_lean_mix(shade_lean a, shade_lean b, float weight)
{
	vec2 apart = b.slope - a.slope;
	vec3 between = vec3(apart[0] * apart[0], apart[1] * apart[1], apart[0] * apart[1]);
	shade_lean lean = {mix(a.slope, b.slope, weight),
	                   mix(a.covariance, b.covariance, weight) + between * (weight * (1.0f - weight))};
	return lean;
}

/* To the published second moments (xx, yy, xy), which a texture can hold and a GPU filter, and back; the way back loses
 * what is small beside slope^2. Source: Olano and Baker 2010, M, and covariance = M - B B^T. */
SHADE_FN vec3 shade_lean_moments(shade_lean lean)
{
	vec2 s = lean.slope;
	return lean.covariance + vec3(s[0] * s[0], s[1] * s[1], s[0] * s[1]);
}

SHADE_FN shade_lean shade_lean_from_moments(vec2 slope, vec3 moments)
{
	float xx = max(moments[0] - slope[0] * slope[0], 0.0f);
	float yy = max(moments[1] - slope[1] * slope[1], 0.0f);
	float most = sqrt(xx * yy);
	float xy = clamp(moments[2] - slope[0] * slope[1], -most, most);
	shade_lean lean = {slope, vec3(xx, yy, xy)};
	return lean;
}

/* The lobe without its direction: alpha^2 is the mean over both axes, xx + yy. */
SHADE_FN shade_rough_normal shade_lean_normal(shade_lean lean)
{
	float alpha = sqrt(max(lean.covariance[0] + lean.covariance[1], 0.0f));
	shade_rough_normal texel = {normalize(vec3(lean.slope, 1.0f)), clamp(alpha, SHADE_ALPHA_MIN, 1.0f)};
	return texel;
}

/* The ellipse of the slopes: the unit direction along which they spread most, alpha along it and across it. Where
 * they spread alike the direction is +X. */
SHADE_STRUCT(shade_lean_axes)
{
	vec2 direction;
	float alpha_along;
	float alpha_across;
};

/* Eigenvalues of the covariance: m +- d with m = (xx + yy) / 2, d = sqrt(((xx - yy) / 2)^2 + xy^2); the direction is at
 * half the angle of ((xx - yy) / 2, xy). */
SHADE_FN shade_lean_axes shade_lean_axes_of(shade_lean lean)
{
	float m = 0.5f * (lean.covariance[0] + lean.covariance[1]);
	float x = 0.5f * (lean.covariance[0] - lean.covariance[1]);
	float y = lean.covariance[2];
	float d = sqrt(x * x + y * y);
	// The half angle from the longer of two equivalent vectors, d + x or d - x: neither is a difference then.
	vec2 half_angle = select(x >= 0.0f, vec2(d + x, y), vec2(abs(y), select(y < 0.0f, x - d, d - x)));
	vec2 direction = select(d > SHADE_LEAN_VARIANCE_MIN, normalize(half_angle), vec2(1.0f, 0.0f));
	shade_lean_axes axes = {direction, clamp(sqrt(2.0f * (m + d)), SHADE_ALPHA_MIN, 1.0f),
	                        clamp(sqrt(2.0f * max(m - d, 0.0f)), SHADE_ALPHA_MIN, 1.0f)};
	return axes;
}

#include "glsl_end.h"
#endif
