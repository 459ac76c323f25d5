/*
 * shade_sampling: two numbers in [0, 1) to a direction, by a chosen density, and that density itself. [any-thread]
 *
 * Space.    Directions are unit, in a tangent frame: x and y along the surface, z along the normal or the lobe's axis
 *           (shade_frame.h turns them into the world's). v points away from the surface, v[2] >= 0.
 * Density.  Every sampler shade_sample_X has its shade_pdf_X: per steradian (the disk's: per unit area), defined on the
 *           whole sphere, integral 1 over it. A lobe about h or r reaches below the horizon: such a sample carries no
 *           light but belongs to the density. shade_sample.pdf is finite and > 0, and taken from the random numbers
 *           where that keeps more digits than the direction itself: directions in float32 resolve sines of about 10^-7.
 * Numbers.  u in [0, 1) each: well distributed numbers give well distributed directions (all maps are continuous but
 *           for the seam of an angle). u[0] decides the distance from the axis, u[1] the angle about it; only the maps
 *           that use shade_concentric (disk, cosine, ggx_normal) mix the two.
 */
#ifndef SHADE_SAMPLING_H
#define SHADE_SAMPLING_H

#include "shade_constants.h"
#include "shade_frame.h"
#include "shade_specular.h"
#include "shade_vmf.h"

#include "glsl_begin.h"

/* A direction and its density, sr^-1. */
SHADE_STRUCT(shade_sample)
{
	vec3 direction;
	float pdf;
};

#define SHADE_UNIFORM_MAX 0.99999994f /* the largest float below 1 */
#define SHADE_COS2_MIN 1e-12f         /* keeps a cosine, and what divides by it, above 0 at the rim of the disk */
#define SHADE_COS_MIN 1e-30f          /* least cosine whose logarithm is taken */
#define SHADE_V_DOT_H_MIN 1e-6f       /* least v.h: at 0, where l = -v, the density would be infinite */
#define SHADE_SHARPNESS_MIN 1e-12f    /* of a vMF lobe: one of sharpness 0 counts as having this */

/* ---- patterns ---------------------------------------------------------------------------------------------------- */

/* One number pair for each cell of a grid of columns x rows: the pair u, moved into cell number `index`. Taken over
 * all indices 0 ... columns * rows - 1 the density is 1, and the variance of an estimate falls faster than with free
 * pairs.
 * Source: Cook, "Stochastic Sampling in Computer Graphics" (1986), jitter. */
SHADE_FN vec2 shade_sample_stratified(int index, int columns, int rows, vec2 u)
{
	int column = index % columns;
	int row = index / columns;
	float x = (float(column) + u[0]) / float(columns);
	float y = (float(row) + u[1]) / float(rows);
	return min(vec2(x, y), SHADE_UNIFORM_MAX);
}

/* Density of the pairs over all indices: 1 on the unit square. */
SHADE_FN float shade_pdf_stratified(vec2 u)
{
	return step(0.0f, min(u[0], u[1])) * step(max(u[0], u[1]), 1.0f);
}

/* ---- disk -------------------------------------------------------------------------------------------------------- */

/* Maps the unit square to the unit disk, concentric squares to concentric circles: (cosine, sine, radius) of the point.
 * The radius is in [-1, 1): on the left and lower sides of the squares it is negative, which turns the point by half a
 * turn. Source: Shirley and Chiu, "A Low Distortion Map Between Disk and Square" (1997). */
SHADE_FN vec3 shade_concentric(vec2 u)
{
	float x = 2.0f * u[0] - 1.0f;
	float y = 2.0f * u[1] - 1.0f;
	bool steep = abs(y) >= abs(x);
	float radius = select(steep, y, x);
	float ratio = select(radius == 0.0f, 0.0f, select(steep, x, y) / radius);
	float angle = 0.25f * SHADE_PI * ratio;
	return vec3(select(steep, sin(angle), cos(angle)), select(steep, cos(angle), sin(angle)), radius);
}

/* A point of the unit disk, each as likely as any other. */
SHADE_FN vec2 shade_sample_disk(vec2 u)
{
	vec3 polar = shade_concentric(u);
	return vec2(polar[0], polar[1]) * polar[2];
}

/* Density per unit area: 1 / pi inside. */
SHADE_FN float shade_pdf_disk(vec2 p)
{
	return SHADE_INV_PI * step(dot(p, p), 1.0f);
}

/* ---- sphere and hemisphere --------------------------------------------------------------------------------------- */

/* Unit vector at the angle phi about z, from its sine and cosine to z. */
SHADE_FN vec3 shade_direction_polar(float sine, float cosine, float phi)
{
	return vec3(sine * cos(phi), sine * sin(phi), cosine);
}

/* Every direction as likely as any other: heights on a sphere are uniform (Archimedes). */
SHADE_FN shade_sample shade_sample_sphere(vec2 u)
{
	float sine = 2.0f * sqrt(u[0] * (1.0f - u[0]));
	shade_sample chosen = {shade_direction_polar(sine, 1.0f - 2.0f * u[0], 2.0f * SHADE_PI * u[1]),
	                       0.25f * SHADE_INV_PI};
	return chosen;
}

/* 1 / (4 pi) */
SHADE_FN float shade_pdf_sphere(void)
{
	return 0.25f * SHADE_INV_PI;
}

/* Every direction above the horizon as likely as any other. */
SHADE_FN shade_sample shade_sample_hemisphere(vec2 u)
{
	float sine = sqrt(u[0] * (2.0f - u[0]));
	shade_sample chosen = {shade_direction_polar(sine, 1.0f - u[0], 2.0f * SHADE_PI * u[1]), 0.5f * SHADE_INV_PI};
	return chosen;
}

/* 1 / (2 pi) above the horizon. */
SHADE_FN float shade_pdf_hemisphere(vec3 direction)
{
	return 0.5f * SHADE_INV_PI * step(0.0f, direction[2]);
}

/* A direction above the horizon with a density proportional to its cosine: points of the disk, lifted to the sphere.
 * Right for Lambert: BRDF x cos / pdf is constant.
 * Source: Malley's method; Pharr, Jakob, Humphreys, "Physically Based Rendering", 3rd ed. (2016), 13.6.3. */
SHADE_FN shade_sample shade_sample_cosine(vec2 u)
{
	vec3 polar = shade_concentric(u);
	float height = sqrt(max((1.0f - polar[2]) * (1.0f + polar[2]), SHADE_COS2_MIN));
	shade_sample chosen = {vec3(polar[0] * polar[2], polar[1] * polar[2], height), height * SHADE_INV_PI};
	return chosen;
}

/* n.l / pi above the horizon. */
SHADE_FN float shade_pdf_cosine(vec3 direction)
{
	return max(direction[2], 0.0f) * SHADE_INV_PI;
}

/* ---- lobes about z ----------------------------------------------------------------------------------------------- */

/* log(z) of a direction above the horizon; near the axis, where z is near 1, from x and y, which keep its digits. */
SHADE_FN float shade_log_cosine(vec3 direction)
{
	float sine2 = direction[0] * direction[0] + direction[1] * direction[1];
	bool near = sine2 < SHADE_SERIES_LIMIT;
	return select(near, 0.5f * shade_log1p(-sine2), log(max(direction[2], SHADE_COS_MIN)));
}

/* Density (n + 1) / (2 pi) z^n, exponent n in [0, 1e7]; n = 0 is the hemisphere, n = 1 the cosine's.
 * z = (1 - u[0])^(1 / (n + 1)); its sine comes from 1 - z^2, not from z, which is 1 in float for large n.
 * Source: Lafortune and Willems, "Using the modified Phong reflectance model for physically based rendering" (1994),
 * 4. */
SHADE_FN shade_sample shade_sample_power(float n, vec2 u)
{
	float log_z = shade_log1p(-u[0]) / (n + 1.0f);
	vec3 direction =
		shade_direction_polar(sqrt(shade_one_minus_exp(-2.0f * log_z)), exp(log_z), 2.0f * SHADE_PI * u[1]);
	shade_sample chosen = {direction, shade_phong_factor(n) * exp(n * log_z)};
	return chosen;
}

SHADE_FN float shade_pdf_power(float n, vec3 direction)
{
	float lobe = shade_phong_factor(n) * exp(n * shade_log_cosine(direction));
	return select(direction[2] > 0.0f, lobe, 0.0f);
}

/* The von Mises-Fisher density sharpness / (2 pi (1 - exp(-2 sharpness))) exp(sharpness (z - 1)), shade_vmf_density
 * about z; sharpness in [0, 1e7], 0 is the sphere. 1 - z = -log(1 - u[0] (1 - exp(-2 sharpness))) / sharpness keeps its
 * digits for every sharpness.
 * Source: Jakob, "Numerically stable sampling of the von Mises-Fisher distribution on S^2 (and other tricks)"
 * (2012). */
SHADE_FN shade_sample shade_sample_vmf(float sharpness, vec2 u)
{
	float k = max(sharpness, SHADE_SHARPNESS_MIN);
	float mass = shade_one_minus_exp(2.0f * k);
	float below = -shade_log1p(-u[0] * mass) / k; // 1 - z
	float sine = sqrt(below * max(2.0f - below, 0.0f));
	vec3 direction = shade_direction_polar(sine, 1.0f - below, 2.0f * SHADE_PI * u[1]);
	shade_sample chosen = {direction, shade_sg_normalized_amplitude(k) * exp(-k * below)};
	return chosen;
}

SHADE_FN float shade_pdf_vmf(float sharpness, vec3 direction)
{
	shade_vmf lobe = {vec3(0.0f, 0.0f, 1.0f), 1.0f / max(sharpness, SHADE_SHARPNESS_MIN)};
	return shade_vmf_density(lobe, direction);
}

/* ---- microfacet normals ------------------------------------------------------------------------------------------ */

/* Density of the reflection l = reflect(-v, h) where h has the density pdf_h: a solid angle dw_h of normals becomes
 * dw_l = 4 |v.h| dw_h of directions. If l is given and not h, |v.h| is |v + l| / 2, which keeps its digits where v.h is
 * small: shade_pdf_mirrored.
 * Source: Walter et al., "Microfacet Models for Refraction through Rough Surfaces" (2007), eq. 14. */
SHADE_FN float shade_pdf_reflected(float pdf_h, float v_dot_h)
{
	return pdf_h / (4.0f * max(abs(v_dot_h), SHADE_V_DOT_H_MIN));
}

/* The microfacet normal that reflects v to l, on the upper side of the surface. Where l = -v there is none: +Z then. */
SHADE_FN vec3 shade_half_vector(vec3 v, vec3 l)
{
	vec3 sum = v + l;
	float length2 = dot(sum, sum);
	float scale = select(sum[2] < 0.0f, -1.0f, 1.0f) * inversesqrt(max(length2, SHADE_COS2_MIN));
	return select(length2 > SHADE_COS2_MIN, sum * scale, vec3(0.0f, 0.0f, 1.0f));
}

/* shade_pdf_reflected from l, for an h that is shade_half_vector(v, l). 0 where l = -v: no normal reflects v there, and
 * +Z, which stands in for one, is the likeliest: in the float directions about -v it would hold up to 5 % of all. */
SHADE_FN float shade_pdf_mirrored(float pdf_h, vec3 v, vec3 l)
{
	float v_dot_h = 0.5f * length(v + l);
	return select(v_dot_h > SHADE_V_DOT_H_MIN, shade_pdf_reflected(pdf_h, v_dot_h), 0.0f);
}

/* v reflected by the microfacet normal h, with the density of the reflection; h.pdf is that of the normal. */
SHADE_FN shade_sample shade_sample_reflected(vec3 v, shade_sample h)
{
	shade_sample chosen = {reflect(-v, h.direction), shade_pdf_reflected(h.pdf, dot(v, h.direction))};
	return chosen;
}

/* Blinn's microfacet normals h. n is the exponent, and z = h[2] the cosine of h to the surface's normal: the density
 * D(h) z = (n + 2) / (2 pi) z^(n + 1) is that of the cosine lobe of exponent n + 1.
 * n = 2 / alpha^2 - 2 in [0, 1e7]. Source: Walter et al. (2007), eq. 37 f. with Karis's exponent, "Specular BRDF
 * Reference" (2013). */
SHADE_FN shade_sample shade_sample_blinn_normal(float n, vec2 u)
{
	return shade_sample_power(n + 1.0f, u);
}

SHADE_FN float shade_pdf_blinn_normal(float n, vec3 h)
{
	return shade_pdf_power(n + 1.0f, h);
}

/* v reflected by such a normal: the highlight of Blinn-Phong and of every BRDF with Blinn's D. */
SHADE_FN shade_sample shade_sample_blinn_phong(float n, vec3 v, vec2 u)
{
	return shade_sample_reflected(v, shade_sample_blinn_normal(n, u));
}

SHADE_FN float shade_pdf_blinn_phong(float n, vec3 v, vec3 l)
{
	return shade_pdf_mirrored(shade_pdf_blinn_normal(n, shade_half_vector(v, l)), v, l);
}

/* The lobe (n + 1) / (2 pi) (r.l)^n about the mirror direction r: Phong's highlight. n in [0, 1e7]. */
SHADE_FN shade_sample shade_sample_phong(float n, vec3 v, vec2 u)
{
	shade_sample lobe = shade_sample_power(n, u);
	shade_frame mirror = shade_frame_from_normal(vec3(-v[0], -v[1], v[2]));
	shade_sample chosen = {shade_frame_to_world(mirror, lobe.direction), lobe.pdf};
	return chosen;
}

SHADE_FN float shade_pdf_phong(float n, vec3 v, vec3 l)
{
	shade_frame mirror = shade_frame_from_normal(vec3(-v[0], -v[1], v[2]));
	return shade_pdf_power(n, shade_frame_to_local(mirror, l));
}

/* GGX normals h, density D(h) h[2] with D = shade_d_ggx_anisotropic (h[2]: the cosine to the surface's normal): the
 * surface is that of an ellipsoid, so they are the unit sphere's normals, cosine distributed, stretched. Both alphas in
 * [SHADE_ALPHA_MIN, 1]. */
SHADE_FN shade_sample shade_sample_ggx_normal(shade_alphas alphas, vec2 u)
{
	vec3 unit = shade_sample_cosine(u).direction;
	vec3 h = normalize(vec3(alphas.x * unit[0], alphas.y * unit[1], unit[2]));
	shade_sample chosen = {h, shade_d_ggx_anisotropic(h[0], h[1], alphas.x, alphas.y) * h[2]};
	return chosen;
}

SHADE_FN float shade_pdf_ggx_normal(shade_alphas alphas, vec3 h)
{
	return shade_d_ggx_anisotropic(h[0], h[1], alphas.x, alphas.y) * max(h[2], 0.0f);
}

/* v reflected by such a normal. At grazing v half of them end below the horizon: prefer shade_sample_ggx_visible. */
SHADE_FN shade_sample shade_sample_ggx(shade_alphas alphas, vec3 v, vec2 u)
{
	return shade_sample_reflected(v, shade_sample_ggx_normal(alphas, u));
}

SHADE_FN float shade_pdf_ggx(shade_alphas alphas, vec3 v, vec3 l)
{
	return shade_pdf_mirrored(shade_pdf_ggx_normal(alphas, shade_half_vector(v, l)), v, l);
}

/* D(h) G1(v) / n.v with Smith's G1 of GGX: 2 D(h) / (n.v + sqrt(alpha_x^2 v_x^2 + alpha_y^2 v_y^2 + v_z^2)), finite at
 * grazing v. Times max(v.h, 0) it is the density of the normals that v sees.
 * Source: Heitz, "Sampling the GGX Distribution of Visible Normals" (2018), eq. 1 to 3. */
SHADE_FN float shade_ggx_visible_density(shade_alphas alphas, vec3 v, vec3 h)
{
	vec3 stretched = vec3(alphas.x * v[0], alphas.y * v[1], v[2]);
	return 2.0f * shade_d_ggx_anisotropic(h[0], h[1], alphas.x, alphas.y) / (v[2] + length(stretched));
}

/* GGX normals as v sees them: D(h) G1(v) max(v.h, 0) / n.v. On the unit sphere they are halfway between v and a point
 * spread evenly over the cap of the directions that v's mirror images reach: z > -v_z. Of the two maps in use (the
 * other: Heitz 2018, by a warped disk) this one has no frame about v and no case at normal incidence.
 * Source: Dupuy and Benyoub, "Sampling Visible GGX Normals with Spherical Caps" (2023). */
SHADE_FN shade_sample shade_sample_ggx_visible_normal(shade_alphas alphas, vec3 v, vec2 u)
{
	vec3 view = normalize(vec3(alphas.x * v[0], alphas.y * v[1], v[2]));
	float below = u[0] * (1.0f + view[2]); // 1 - z of the point on the cap
	float sine = sqrt(below * max(2.0f - below, 0.0f));
	float height = (1.0f - u[0]) * (1.0f + view[2]); // z of the point + view[2], never below 0
	vec3 unit = shade_direction_polar(sine, height, 2.0f * SHADE_PI * u[1]) + vec3(view[0], view[1], 0.0f);
	vec3 h = normalize(vec3(alphas.x * unit[0], alphas.y * unit[1], unit[2]));
	shade_sample chosen = {h, shade_ggx_visible_density(alphas, v, h) * max(dot(v, h), SHADE_V_DOT_H_MIN)};
	return chosen;
}

SHADE_FN float shade_pdf_ggx_visible_normal(shade_alphas alphas, vec3 v, vec3 h)
{
	float seen = shade_ggx_visible_density(alphas, v, h) * max(dot(v, h), 0.0f);
	return select(h[2] > 0.0f, seen, 0.0f);
}

/* v reflected by such a normal. BRDF x cos / pdf is F G2 / G1(v), at most F: no sample outweighs the others. */
SHADE_FN shade_sample shade_sample_ggx_visible(shade_alphas alphas, vec3 v, vec2 u)
{
	vec3 h = shade_sample_ggx_visible_normal(alphas, v, u).direction;
	shade_sample chosen = {reflect(-v, h), 0.25f * shade_ggx_visible_density(alphas, v, h)};
	return chosen;
}

SHADE_FN float shade_pdf_ggx_visible(shade_alphas alphas, vec3 v, vec3 l)
{
	float seen = 0.25f * shade_ggx_visible_density(alphas, v, shade_half_vector(v, l));
	return select(v[2] + l[2] > 0.0f, seen, 0.0f);
}

#include "glsl_end.h"
#endif
