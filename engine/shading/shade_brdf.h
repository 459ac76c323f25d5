/*
 * shade_brdf: every reflection model of engine/shading behind one function, chosen by integers; in a shader these are
 * specialisation constants, and only the chosen model is left. [any-thread]
 *
 * Directions are unit and point away from the surface: n is its normal, l points to the light, v to the viewer. D, G
 * and F are the factors of a microfacet model (shade_specular.h). Energy: Lambert, the two modified highlights and 29
 * of the 32 pairs of D and G reflect at most what arrives; wrapped, the two original highlights, minimalist and
 * Smith-Beckmann's G with a D that is not Beckmann's do not: their headers say by how much.
 */
#ifndef SHADE_BRDF_H
#define SHADE_BRDF_H

#include "shade_diffuse.h"
#include "shade_energy.h"
#include "shade_frame.h"
#include "shade_minimalist.h"
#include "shade_model.h"
#include "shade_phong.h"
#include "shade_specular.h"

#include "glsl_begin.h"

/* specular, [0, 1]: for SHADE_BRDF_MICROFACET F0, the reflectance at normal incidence; for the highlights of
 * shade_phong.h and shade_minimalist.h their reflectance; for Lambert and wrapped the diffuse reflectance.
 * roughness, [0, 1]: the lobe's width alpha is its square, and exponents are made from alpha. anisotropy, (-1, 1), 0
 * for none: where it is positive D is wider along the frame's t; only SHADE_NDF_GGX_ANISOTROPIC. wrap, [0, 1]: only
 * SHADE_BRDF_WRAPPED. */
SHADE_STRUCT(shade_brdf_parameters)
{
	vec3 specular;
	float roughness;
	float anisotropy;
	float wrap;
};

/* BRDF times n.l of the microfacet model that the integers ndf, g and f choose: D F V n.l. l and v are read for
 * SHADE_NDF_GGX_ANISOTROPIC alone; the others need only the angles. */
SHADE_FN vec3 shade_microfacet_cos(shade_brdf_model model, shade_brdf_parameters p, shade_frame frame, shade_angles a,
                                   vec3 l, vec3 v)
{
	float alpha = shade_alpha_from_roughness(p.roughness);
	vec3 fresnel = shade_f(model.f, p.specular, a.v_dot_h);
	if (model.ndf == SHADE_NDF_GGX && model.g == SHADE_G_SMITH_GGX)
		return fresnel * (shade_dv_ggx(a.sin2_h, a.n_dot_l, a.n_dot_v, alpha) * a.n_dot_l);
	if (model.ndf != SHADE_NDF_GGX_ANISOTROPIC)
		return fresnel * (shade_d(model.ndf, a.sin2_h, alpha) * shade_v(model.g, a, alpha, alpha) * a.n_dot_l);
	shade_alphas alphas = shade_alphas_from_anisotropy(alpha, p.anisotropy);
	vec3 local_l = shade_frame_to_local(frame, l);
	vec3 local_v = shade_frame_to_local(frame, v);
	float alpha_l = shade_alpha_along(alphas, local_l);
	float alpha_v = shade_alpha_along(alphas, local_v);
	vec3 h = (local_l + local_v) * (0.5f / a.v_dot_h);
	float d = shade_d_ggx_anisotropic(h[0], h[1], alphas.x, alphas.y);
	return fresnel * (d * shade_v(model.g, a, alpha_l, alpha_v) * a.n_dot_l);
}

/* BRDF times n.l, per channel, sr^-1: what Schueler calls the reflection density. Finite for all directions, and 0 for
 * v below the horizon and, but for SHADE_BRDF_WRAPPED, for l below it. It is the product and not the BRDF because the
 * BRDFs of wrapped and of the original Phong and Blinn-Phong are infinite at n.l = 0. */
SHADE_FN vec3 shade_brdf_cos(shade_brdf_model model, shade_brdf_parameters p, shade_frame frame, vec3 l, vec3 v)
{
	shade_angles a = shade_angles_of(frame.n, l, v);
	if (a.n_dot_v <= 0.0f)
		return vec3(0.0f);
	if (model.kind == SHADE_BRDF_WRAPPED)
		return p.specular * shade_wrapped(a.n_dot_l, p.wrap);
	if (a.n_dot_l <= 0.0f)
		return vec3(0.0f);
	if (model.kind == SHADE_BRDF_LAMBERT)
		return shade_lambert(p.specular) * a.n_dot_l;

	float alpha = shade_alpha_from_roughness(p.roughness);
	float n = shade_exponent_from_alpha(alpha);
	if (model.kind == SHADE_BRDF_BLINN_PHONG)
		return p.specular * shade_blinn_phong(a.sin2_h, n);
	if (model.kind == SHADE_BRDF_BLINN_PHONG_MODIFIED)
		return p.specular * shade_blinn_phong_modified(a.sin2_h, a.n_dot_l, n);
	if (model.kind == SHADE_BRDF_MINIMALIST)
		return p.specular * (shade_minimalist(a.sin2_h, a.v_dot_h, n) * a.n_dot_l);
	if (model.kind == SHADE_BRDF_PHONG)
		return p.specular * shade_phong(shade_sin2_r(frame.n, l, v), shade_exponent_about_r(n));
	if (model.kind == SHADE_BRDF_PHONG_MODIFIED)
		return p.specular * shade_phong_modified(shade_sin2_r(frame.n, l, v), a.n_dot_l, shade_exponent_about_r(n));
	return shade_microfacet_cos(model, p, frame, a, l, v);
}

/* ---- the largest value ------------------------------------------------------------------------------------------- */

/* Bound of the microfacet models' D, sr^-1: its value for a facet along the normal. Beckmann's is up to 1.48 times that
 * for tilted facets of alpha above 0.7; an anisotropic one with a width above 1 up to its fourth power. */
SHADE_FN float shade_d_peak(int ndf, shade_alphas alphas)
{
	float wide = max(max(alphas.x, alphas.y), 1.0f);
	float tilted = select(ndf == SHADE_NDF_BECKMANN, 1.48f, wide * wide * wide * wide);
	return tilted / (SHADE_PI * alphas.x * alphas.y);
}

/* Bound of V n.l. Smith's and Schlick's factor for l times n.l is at most 1/2, that for v at most 1 / alpha, with
 * Beckmann's fit 3.535 / 2 / (alpha sin t), sin t being at least 1 / sqrt(1 + (1.6 alpha)^2) where the fit is used. Of
 * Kelemen and Cook-Torrance at most 1/2 / (v.h), as n.l <= 2 v.h, and 1/4 / min(n.l, n.v): without bound but for the
 * epsilon. */
SHADE_FN float shade_v_peak(int g, shade_alphas alphas)
{
	float narrow = min(alphas.x, alphas.y);
	float wide = max(alphas.x, alphas.y);
	if (g == SHADE_G_IMPLICIT || g == SHADE_G_NEUMANN)
		return 0.25f;
	if (g == SHADE_G_KELEMEN || g == SHADE_G_COOK_TORRANCE)
		return 0.5f / SHADE_COSINE_EPSILON;
	if (g == SHADE_G_SMITH_BECKMANN)
		return 0.884f * sqrt(1.0f + 2.56f * wide * wide) / narrow;
	return 0.5f / narrow;
}

/* No direction makes shade_brdf_cos of p.specular = 1 larger than this, sr^-1, but for what is rounded; of microfacets
 * with a Fresnel term of no p.specular. Bounds for each factor, of which microfacets reach a fifth or more and
 * minimalist far less. roughness and anisotropy: as in shade_brdf_parameters. Source: derived here from the formulas
 * above. */
SHADE_FN float shade_brdf_peak(shade_brdf_model model, float roughness, float anisotropy)
{
	float alpha = shade_alpha_from_roughness(roughness);
	float n = shade_exponent_from_alpha(alpha);
	if (model.kind == SHADE_BRDF_LAMBERT || model.kind == SHADE_BRDF_WRAPPED)
		return SHADE_INV_PI;
	if (model.kind == SHADE_BRDF_BLINN_PHONG)
		return shade_blinn_phong_factor(n);
	if (model.kind == SHADE_BRDF_BLINN_PHONG_MODIFIED)
		return shade_blinn_phong_modified_factor(n);
	if (model.kind == SHADE_BRDF_MINIMALIST) /* F V n.l <= 1/4 2 (l.h) / (l.h)^3 */
		return shade_blinn_phong_ndf_factor(n) * 0.5f / (SHADE_COSINE_EPSILON * SHADE_COSINE_EPSILON);
	if (model.kind == SHADE_BRDF_PHONG)
		return shade_phong_factor(shade_exponent_about_r(n));
	if (model.kind == SHADE_BRDF_PHONG_MODIFIED)
		return shade_phong_modified_factor(shade_exponent_about_r(n));
	shade_alphas alphas = {alpha, alpha};
	if (model.ndf == SHADE_NDF_GGX_ANISOTROPIC)
		alphas = shade_alphas_from_anisotropy(alpha, anisotropy);
	return shade_d_peak(model.ndf, alphas) * shade_v_peak(model.g, alphas);
}

/* What the model's highlight leaves of the diffuse light at the viewer's angle: 1 but for microfacets with a Fresnel
 * term, shade_diffuse_left. A material without a highlight has all of it left; that is the caller's to know. */
SHADE_FN float shade_brdf_diffuse_left(shade_brdf_model model, float n_dot_v, float roughness)
{
	if (model.kind != SHADE_BRDF_MICROFACET || model.f == SHADE_F_NONE)
		return 1.0f;
	return shade_diffuse_left(n_dot_v, roughness);
}

#include "glsl_end.h"
#endif
