/*
 * shade_blinn_phong: the normalised Blinn-Phong highlight, "modified" row of Schueler's table. [any-thread]
 *
 * Two words that are easily mixed up. A reflection density function (RDF) says where the light goes that does reflect and
 * is the BRDF times n.l; its integral over the hemisphere is the albedo. The modified row's RDF is
 *   factor(n) (n.h)^n (n.l),   so the BRDF is   factor(n) (n.h)^n,
 * and a light of irradiance E across its beam gives the radiance BRDF * E * (n.l): the cosine is taken once.
 */
#ifndef SHADE_BLINN_PHONG_H
#define SHADE_BLINN_PHONG_H

#include "shade_constants.h"

#include "glsl_begin.h"

/* The factor that makes the albedo 1 at normal incidence, sr^-1; exponent n >= 0, and n = 0 gives Lambert's 1 / pi:
 *   (n + 2) (n + 4) / (8 pi (2^(-n/2) + n))
 * It lies between (n + 6) / (8 pi) and (n + 8) / (8 pi). Away from normal incidence the albedo is smaller than 1.
 * Source: Schueler, "The Blinn-Phong Normalization Zoo" (2011), table, row "Blinn-Phong (modified)". */
SHADE_FN float shade_blinn_phong_modified_factor(float n)
{
	return (n + 2.0f) * (n + 4.0f) / (8.0f * SHADE_PI * (exp2(-0.5f * n) + n));
}

/* BRDF of a surface that reflects everything, sr^-1: factor(n) (n.h)^n. n_dot_h in [-1, 1] (below 0: none), n > 0. */
SHADE_FN float shade_blinn_phong_modified(float n_dot_h, float n)
{
	return shade_blinn_phong_modified_factor(n) * pow(clamp(n_dot_h, 0.0f, 1.0f), n);
}

#include "glsl_end.h"
#endif
