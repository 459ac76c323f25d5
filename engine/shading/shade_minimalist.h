/*
 * shade_minimalist: Schueler's minimalist Cook-Torrance: the product of Fresnel term and visibility as one power of
 * l.h. [any-thread]
 *
 *   f = D F V,   D = (n + 1) / (2 pi) (n.h)^n (shade_phong.h's NDF row),   F V = ks / (4 (l.h)^3)
 * ks is the highlight's reflectance; n is the exponent, and the normal in n.h. F V is linear in ks and does not turn to
 * white at grazing angles: one multiplication instead of Schlick's five or six steps. Compared with Schlick's F and
 * Kelemen's V it is too dark at grazing angles for water (ks 0.02: down to 0.29 of it), within 40 % for 0.05 (up
 * to 87 degrees), and too bright for metals (0.8: twice as much at 60 degrees, and more beyond). Reciprocal, but not
 * energy conserving: a smooth surface reflects ks / (n.v), more than 1 as soon as n.v < ks (beyond 88.9, 87.1 and 36.9
 * degrees for ks 0.02, 0.05 and 0.8); 57 ks at 89 degrees, and 2 ks for the roughest.
 * Source: Schueler, "The Blinn-Phong Normalization Zoo" (2011); "An Efficient and Physically Plausible Real-Time
 * Shading Model", ShaderX7 (2009).
 */
#ifndef SHADE_MINIMALIST_H
#define SHADE_MINIMALIST_H

#include "shade_constants.h"
#include "shade_phong.h"
#include "shade_specular.h"

#include "glsl_begin.h"

/* D, sr^-1: the integral of D is 1. */
SHADE_FN float shade_minimalist_d(float sin2_h, float n)
{
	return shade_blinn_phong_ndf_factor(n) * shade_cos_power(sin2_h, n);
}

/* F V / ks. */
SHADE_FN float shade_minimalist_fv(float l_dot_h)
{
	float c = max(l_dot_h, SHADE_COSINE_EPSILON);
	return 0.25f / (c * c * c);
}

/* What shade_minimalist_fv approximates: Schlick's F times Kelemen's V. */
SHADE_FN vec3 shade_schlick_kelemen_fv(vec3 f0, float l_dot_h)
{
	return shade_f_schlick(f0, l_dot_h) * shade_v_kelemen(l_dot_h);
}

/* The BRDF of ks = 1, sr^-1. */
SHADE_FN float shade_minimalist(float sin2_h, float l_dot_h, float n)
{
	return shade_minimalist_d(sin2_h, n) * shade_minimalist_fv(l_dot_h);
}

#include "glsl_end.h"
#endif
