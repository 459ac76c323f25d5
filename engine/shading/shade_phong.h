/*
 * shade_phong: Phong's and Blinn's highlights and what normalises them: Schueler's zoo. [any-thread]
 *
 * In products n is the normal: l points to the light, v to the viewer, r is v mirrored at n, h the unit vector halfway
 * between l and v, and n.l their cosine. As a power n is the lobe's exponent.
 * Two words that are easily mixed up. A reflection density function (RDF) says where the light goes that does reflect:
 * it is the BRDF times n.l, sr^-1, and its integral over the hemisphere is the albedo. The four factors make that
 * integral 1 for light along the normal. A normal distribution function (NDF) is a density of microfacet normals.
 *   row                        shape                 measure that the factor makes 1
 *   Phong                      (r.l)^n               integral of the RDF, v = n
 *   Phong, modified            (r.l)^n (n.l)         the same
 *   Blinn-Phong                (n.h)^n               the same
 *   Blinn-Phong, modified      (n.h)^n (n.l)         the same
 *   Blinn-Phong NDF            (n.h)^n               integral of D
 *   Blinn-Phong heightfield    (n.h)^n               integral of D (n.h)
 * Normalised is not energy conserving. Under an even sky all four reflect at most what they get, seen from anywhere.
 * But the two original rows are not reciprocal, and of light that comes in flat they reflect more than arrives, without
 * bound towards 90 degrees: at 89 degrees 14.6 times (Phong) and 28.6 times (Blinn-Phong). The two modified rows, which
 * take n.l along, stay below 1 from both sides.
 *
 * Exponents n >= 0. Source of the table: Schueler, "The Blinn-Phong Normalization Zoo" (2011).
 */
#ifndef SHADE_PHONG_H
#define SHADE_PHONG_H

#include "shade_constants.h"

#include "glsl_begin.h"

/* cos^n of an angle in [0, pi / 2] given by its sin^2, n >= 0; 0 at a right angle. A float cosine near 1 has steps of
 * 6e-8, too coarse for pow(cos, n) with the exponents of 10^6 that a smooth surface has; sin^2 has its digits there. In
 * return a cosine below 1e-3 has none left, which only the flattest lobes (n below 2) show, at their very end. */
SHADE_FN float shade_cos_power(float sin2, float n)
{
	return select(sin2 < 1.0f, exp(0.5f * n * shade_log1p(-sin2)), 0.0f);
}

/* sin^2 of the angle between l and the mirror direction r of v, unit vectors; 1 from a right angle on, where Phong's
 * lobe has ended. From |l - r|^2 = 2 - 2 l.r, so that small angles keep their digits. */
SHADE_FN float shade_sin2_r(vec3 n, vec3 l, vec3 v)
{
	vec3 apart = l + v - n * (2.0f * dot(n, v));
	float apart2 = dot(apart, apart);
	return select(apart2 < 2.0f, apart2 * (1.0f - 0.25f * apart2), 1.0f);
}

/* ---- exponents -------------------------------------------------------------------------------------------------- */

/* n = 2 / alpha^2 - 2 of the lobes about h, as in Karis, "Specular BRDF Reference" (2013). alpha in (0, 1]. */
SHADE_FN float shade_exponent_from_alpha(float alpha)
{
	return 2.0f * (1.0f - alpha) * (1.0f + alpha) / (alpha * alpha);
}

/* The inverse of shade_exponent_from_alpha: sqrt(2 / (n + 2)). */
SHADE_FN float shade_alpha_from_exponent(float n)
{
	return sqrt(2.0f / (n + 2.0f));
}

/* The exponent about r that looks like n about h: n / 4, since h turns half as far as r and exponents go with the
 * square of the angle. Source: Fisher and Woo, "R.E versus N.H Specular Highlights", Graphics Gems IV (1994). */
SHADE_FN float shade_exponent_about_r(float n)
{
	return 0.25f * n;
}

/* Gloss in [0, 1], the exponent's logarithm: n = 2^(13 gloss), 1 to 8192.
 * Source: Lazarov, "Physically-based lighting in Call of Duty: Black Ops" (2011), 8192^gloss. */
#define SHADE_GLOSS_OCTAVES 13.0f
SHADE_FN float shade_exponent_from_gloss(float gloss)
{
	return exp2(SHADE_GLOSS_OCTAVES * gloss);
}

/* The inverse of shade_exponent_from_gloss, n > 0. */
SHADE_FN float shade_gloss_from_exponent(float n)
{
	return log2(n) / SHADE_GLOSS_OCTAVES;
}

/* ---- factors ---------------------------------------------------------------------------------------------------- */

/* Each is what the row of the table above is multiplied by. Phong: (n + 1) / (2 pi). */
SHADE_FN float shade_phong_factor(float n)
{
	return (n + 1.0f) / (2.0f * SHADE_PI);
}

/* Phong, modified: (n + 2) / (2 pi). */
SHADE_FN float shade_phong_modified_factor(float n)
{
	return (n + 2.0f) / (2.0f * SHADE_PI);
}

/* Blinn-Phong: (n + 2) / (4 pi (2 - 2^(-n/2))), between (n + 2) / (8 pi) and (n + 4) / (8 pi), which follow. */
SHADE_FN float shade_blinn_phong_factor(float n)
{
	return (n + 2.0f) / (4.0f * SHADE_PI * (2.0f - exp2(-0.5f * n)));
}

SHADE_FN float shade_blinn_phong_factor_low(float n)
{
	return (n + 2.0f) / (8.0f * SHADE_PI);
}

SHADE_FN float shade_blinn_phong_factor_high(float n)
{
	return (n + 4.0f) / (8.0f * SHADE_PI);
}

/* Blinn-Phong, modified: (n + 2) (n + 4) / (8 pi (2^(-n/2) + n)), between (n + 6) / (8 pi) and (n + 8) / (8 pi), which
 * follow; for n = 0 it is Lambert's 1 / pi. */
SHADE_FN float shade_blinn_phong_modified_factor(float n)
{
	return (n + 2.0f) * (n + 4.0f) / (8.0f * SHADE_PI * (exp2(-0.5f * n) + n));
}

SHADE_FN float shade_blinn_phong_modified_factor_low(float n)
{
	return (n + 6.0f) / (8.0f * SHADE_PI);
}

SHADE_FN float shade_blinn_phong_modified_factor_high(float n)
{
	return (n + 8.0f) / (8.0f * SHADE_PI);
}

/* Blinn-Phong NDF: the integral of D is 1. It is the integral of Phong's lobe, with n.h in the place of r.l. */
SHADE_FN float shade_blinn_phong_ndf_factor(float n)
{
	return shade_phong_factor(n);
}

/* Heightfield: integral of D (n.h) = 1, modified Phong's integral. shade_d_blinn of shade_specular.h is this one. */
SHADE_FN float shade_blinn_phong_heightfield_factor(float n)
{
	return shade_phong_modified_factor(n);
}

/* ---- BRDF times n.l --------------------------------------------------------------------------------------------- */

/* sin2_r and sin2_h: of the angle between r and l (below a right angle), and between n and h. n_dot_l >= 0. */
SHADE_FN float shade_phong(float sin2_r, float n)
{
	return shade_phong_factor(n) * shade_cos_power(sin2_r, n);
}

SHADE_FN float shade_phong_modified(float sin2_r, float n_dot_l, float n)
{
	return shade_phong_modified_factor(n) * shade_cos_power(sin2_r, n) * n_dot_l;
}

SHADE_FN float shade_blinn_phong(float sin2_h, float n)
{
	return shade_blinn_phong_factor(n) * shade_cos_power(sin2_h, n);
}

SHADE_FN float shade_blinn_phong_modified(float sin2_h, float n_dot_l, float n)
{
	return shade_blinn_phong_modified_factor(n) * shade_cos_power(sin2_h, n) * n_dot_l;
}

#include "glsl_end.h"
#endif
