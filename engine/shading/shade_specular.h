/*
 * shade_specular: the parts of a microfacet BRDF, any with any. [any-thread]
 *
 *   f(l, v) = D(h) F(v.h) G(l, v, h) / (4 (n.l) (n.v)) = D F V,   h = (l + v) / |l + v|
 *
 * Unit vectors: n is the normal, l points to the light, v to the viewer; a dot between two is their cosine.
 * D, sr^-1: density of the microfacets' normals m; the integral of D(m) (n.m) over the hemisphere is 1.
 * G in [0, 1]: share of the facets that neither l nor v has in its shadow. It is kept as the visibility
 *   V = G / (4 (n.l) (n.v)), where the cosines that make a quotient 0 / 0 at grazing angles are gone already;
 *   shade_g gives G itself back.
 * F in [0, 1]: what a facet reflects.
 * alpha in [SHADE_ALPHA_MIN, 1]: width of D, roughness squared (Burley 2012; Karis 2013); up to 2 for anisotropic D.
 *
 * A facet's tilt is given by sin2_h = 1 - (n.h)^2, [0, 1]. A float n.h near 1 has steps of 6e-8, which is 12 % of the
 * tilt of a highlight of alpha 1e-3: shade_angles_of takes it from the cross product, without that loss.
 *
 * Not every pair conserves energy: with SHADE_G_SMITH_BECKMANN a white surface reflects up to 1.30 of the light for
 * Blinn's D (roughness 1) and 1.62 for GGX (0.5; 1.65 for an anisotropic one), seen at up to 89 degrees; towards 90
 * Blinn's rises to 1.34 and GGX's to 1.74: a G made for Beckmann's D shadows too little where D has more steep facets.
 * The other pairs stay at or below 1 for every angle and roughness. All are reciprocal.
 *
 * Formulas: Karis, "Specular BRDF Reference" (2013), with the paper of each beside it.
 */
#ifndef SHADE_SPECULAR_H
#define SHADE_SPECULAR_H

#include "shade_constants.h"
#include "shade_model.h"
#include "shade_phong.h"

#include "glsl_begin.h"

#define SHADE_ALPHA_MIN 1e-3f

/* Keep quotients finite, also those that are not chosen in the end: a GPU need not know infinity. */
#define SHADE_COSINE_EPSILON 1e-4f
#define SHADE_SINE2_EPSILON 1e-12f
#define SHADE_FRESNEL_EPSILON 1e-30f
#define SHADE_F0_MIN 1e-20f

/* The angles between the vectors of one evaluation: cosines, and sin2_h = 1 - (n.h)^2. */
SHADE_STRUCT(shade_angles)
{
	float n_dot_l;
	float n_dot_v;
	float n_dot_h;
	float v_dot_h;
	float sin2_h;
};

/* Of unit n, l and v. v.h = l.h = |l + v| / 2. Where l = -v there is no h: v.h is SHADE_COSINE_EPSILON then, n.h 0. */
SHADE_FN shade_angles shade_angles_of(vec3 n, vec3 l, vec3 v)
{
	vec3 sum = l + v;
	vec3 tilt = cross(n, sum);
	float half_length = max(0.5f * length(sum), SHADE_COSINE_EPSILON);
	float inverse_length = 0.5f / half_length;
	float n_dot_l = dot(n, l);
	float n_dot_v = dot(n, v);
	shade_angles angles = {n_dot_l, n_dot_v, (n_dot_l + n_dot_v) * inverse_length, min(half_length, 1.0f),
	                       dot(tilt, tilt) * (inverse_length * inverse_length)};
	return angles;
}

/* ---- D: distribution of the normals ----------------------------------------------------------------------------- */

/* alpha = roughness^2, as Karis has it, at least SHADE_ALPHA_MIN; roughness in [0, 1]. */
SHADE_FN float shade_alpha_from_roughness(float roughness)
{
	return max(roughness * roughness, SHADE_ALPHA_MIN);
}

/* Blinn-Phong: cos^n / (pi alpha^2), n = 2 / alpha^2 - 2. Source: Blinn, "Models of light reflection for computer
 * synthesized pictures" (1977). */
SHADE_FN float shade_d_blinn(float sin2_h, float alpha)
{
	return shade_cos_power(sin2_h, shade_exponent_from_alpha(alpha)) / (SHADE_PI * alpha * alpha);
}

/* Beckmann: exp(-tan^2 / alpha^2) / (pi alpha^2 cos^4). 0 for facets at a right angle. Source: Beckmann and
 * Spizzichino, "The scattering of electromagnetic waves from rough surfaces" (1963). */
SHADE_FN float shade_d_beckmann(float sin2_h, float alpha)
{
	float cos2 = max(1.0f - sin2_h, SHADE_COSINE_EPSILON);
	float alpha2 = alpha * alpha;
	return exp(-sin2_h / (alpha2 * cos2)) / (SHADE_PI * alpha2 * cos2 * cos2);
}

/* GGX, Trowbridge-Reitz: alpha^2 / (pi (cos^2 (alpha^2 - 1) + 1)^2); the bracket is alpha^2 + sin^2 (1 - alpha^2),
 * where nothing cancels. Source: Walter et al., "Microfacet models for refraction through rough surfaces" (2007), eq.
 * 33. */
SHADE_FN float shade_d_ggx(float sin2_h, float alpha)
{
	float alpha2 = alpha * alpha;
	float bracket = alpha2 + sin2_h * (1.0f - alpha2);
	return alpha2 / (SHADE_PI * bracket * bracket);
}

/* GGX of another width along each tangent: 1 / (pi alpha_x alpha_y (x^2 / alpha_x^2 + y^2 / alpha_y^2 + z^2)^2), with
 * (x, y, z) = (t.h, b.h, n.h). Source: Burley, "Physically-Based Shading at Disney" (2012), eq. 13. */
SHADE_FN float shade_d_ggx_anisotropic(float t_dot_h, float b_dot_h, float alpha_x, float alpha_y)
{
	float x = t_dot_h / alpha_x;
	float y = b_dot_h / alpha_y;
	float z2 = 1.0f - t_dot_h * t_dot_h - b_dot_h * b_dot_h;
	float bracket = x * x + y * y + z2;
	return 1.0f / (SHADE_PI * alpha_x * alpha_y * bracket * bracket);
}

/* The widths along t and b. */
SHADE_STRUCT(shade_alphas)
{
	float x;
	float y;
};

/* anisotropy in (-1, 1): alpha (1 + a) along t, alpha (1 - a) along b. Source: Kulla and Conty, "Revisiting Physically
 * Based Shading at Imageworks" (2017). */
SHADE_FN shade_alphas shade_alphas_from_anisotropy(float alpha, float anisotropy)
{
	shade_alphas alphas = {max(alpha * (1.0f + anisotropy), SHADE_ALPHA_MIN),
	                       max(alpha * (1.0f - anisotropy), SHADE_ALPHA_MIN)};
	return alphas;
}

/* The width that an anisotropic D shows to a direction, in the frame's coordinates: for the shadowing terms, which take
 * one alpha for each direction. Source: Heitz, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs"
 * (2014), eq. 80. Along the normal, where no term depends on alpha, it is some number between the two. */
SHADE_FN float shade_alpha_along(shade_alphas alphas, vec3 local)
{
	float x = local[0] * local[0] + SHADE_SINE2_EPSILON;
	float y = local[1] * local[1] + SHADE_SINE2_EPSILON;
	return sqrt((x * alphas.x * alphas.x + y * alphas.y * alphas.y) / (x + y));
}

/* D by its number, SHADE_NDF_...; SHADE_NDF_GGX_ANISOTROPIC counts as SHADE_NDF_GGX. */
SHADE_FN float shade_d(int ndf, float sin2_h, float alpha)
{
	if (ndf == SHADE_NDF_BLINN)
		return shade_d_blinn(sin2_h, alpha);
	if (ndf == SHADE_NDF_BECKMANN)
		return shade_d_beckmann(sin2_h, alpha);
	return shade_d_ggx(sin2_h, alpha);
}

/* ---- V = G / (4 (n.l) (n.v)): shadowing ------------------------------------------------------------------------- */

/* Implicit: G = (n.l) (n.v). Source: Hoffman, "Background: Physics and Math of Shading" (2013). */
SHADE_FN float shade_v_implicit(void)
{
	return 0.25f;
}

/* Neumann: G = (n.l) (n.v) / max(n.l, n.v). Source: Neumann et al., "Compact metallic reflectance models" (1999). */
SHADE_FN float shade_v_neumann(float n_dot_l, float n_dot_v)
{
	return 0.25f / max(max(n_dot_l, n_dot_v), SHADE_COSINE_EPSILON);
}

/* Cook-Torrance, V-shaped grooves: G = min(1, 2 (n.h) (n.v) / (v.h), 2 (n.h) (n.l) / (v.h)).
 * Source: Cook and Torrance, "A Reflectance Model for Computer Graphics" (1982), eq. for G. */
SHADE_FN float shade_v_cook_torrance(float n_dot_l, float n_dot_v, float n_dot_h, float v_dot_h)
{
	float smaller = max(min(n_dot_l, n_dot_v), SHADE_COSINE_EPSILON);
	float larger = max(max(n_dot_l, n_dot_v), SHADE_COSINE_EPSILON);
	return min(0.25f / smaller, 0.5f * n_dot_h / v_dot_h) / larger;
}

/* Kelemen: G = (n.l) (n.v) / (v.h)^2. Source: Kelemen and Szirmay-Kalos, "A microfacet based coupled specular-matte
 * BRDF model with importance sampling" (2001). */
SHADE_FN float shade_v_kelemen(float v_dot_h)
{
	float c = max(v_dot_h, SHADE_COSINE_EPSILON);
	return 0.25f / (c * c);
}

/* Smith's V is the product of two factors, one for x = l and one for x = v: G1(x) / (2 (n.x)). G1(x) is the share of
 * facets that are not shadowed seen from the direction x; each shade_v1_... below has its own and returns the factor.
 * Source: Smith, "Geometrical shadowing of a random rough surface" (1967). */

/* Beckmann's factor for the direction x (l or v), at the angle t to the normal n: with c = (n.x) / (alpha sin t),
 * G1 = (3.535 c + 2.181 c^2) / (1 + 2.276 c + 2.577 c^2) for c < 1.6, otherwise 1. Source: Walter et al. (2007), table
 * 1 and its rational fit. */
SHADE_FN float shade_v1_smith_beckmann(float n_dot_x, float alpha)
{
	float slope = alpha * sqrt(max(1.0f - n_dot_x * n_dot_x, SHADE_SINE2_EPSILON));
	float c = n_dot_x / slope;
	float fit = (3.535f + 2.181f * c) / (slope * (1.0f + (2.276f + 2.577f * c) * c));
	return 0.5f * select(c < 1.6f, fit, 1.0f / n_dot_x);
}

/* GGX's factor for the direction x (l or v), with its G1 = 2 (n.x) / ((n.x) + sqrt(alpha^2 + (1 - alpha^2) (n.x)^2)).
 * Source: Walter et al. (2007), eq. 34. */
SHADE_FN float shade_v1_smith_ggx(float n_dot_x, float alpha)
{
	float alpha2 = alpha * alpha;
	return 1.0f / (n_dot_x + sqrt(alpha2 + (1.0f - alpha2) * n_dot_x * n_dot_x));
}

/* Schlick's form of the factor for x (l or v), G1 = (n.x) / ((n.x) (1 - k) + k); k: see below. Source: Schlick, "An
 * Inexpensive BRDF Model for Physically-based Rendering" (1994), eq. 19. */
SHADE_FN float shade_v1_schlick(float n_dot_x, float k)
{
	return 0.5f / (n_dot_x * (1.0f - k) + k);
}

/* k for Beckmann: alpha sqrt(2 / pi). Source: Schlick (1994). */
SHADE_FN float shade_schlick_k_beckmann(float alpha)
{
	return alpha * 0.79788456080286535588f;
}

/* k for GGX: alpha / 2. Source: Karis, "Real Shading in Unreal Engine 4" (2013). */
SHADE_FN float shade_schlick_k_ggx(float alpha)
{
	return alpha * 0.5f;
}

/* The fused GGX visibility: both halves of shade_v1_smith_ggx with one division. Source: Karis (2013), "Optimize". */
SHADE_FN float shade_v_smith_ggx(float n_dot_l, float n_dot_v, float alpha_l, float alpha_v)
{
	float l2 = alpha_l * alpha_l;
	float v2 = alpha_v * alpha_v;
	float of_l = n_dot_l + sqrt((n_dot_l - n_dot_l * l2) * n_dot_l + l2);
	float of_v = n_dot_v + sqrt((n_dot_v - n_dot_v * v2) * n_dot_v + v2);
	return 1.0f / (of_l * of_v);
}

/* D V of GGX with its Smith term, by one division for all. Source: Karis (2013), on optimising the whole. */
SHADE_FN float shade_dv_ggx(float sin2_h, float n_dot_l, float n_dot_v, float alpha)
{
	float alpha2 = alpha * alpha;
	float bracket = alpha2 + sin2_h * (1.0f - alpha2);
	float of_l = n_dot_l + sqrt((n_dot_l - n_dot_l * alpha2) * n_dot_l + alpha2);
	float of_v = n_dot_v + sqrt((n_dot_v - n_dot_v * alpha2) * n_dot_v + alpha2);
	return alpha2 / (SHADE_PI * bracket * bracket * of_l * of_v);
}

/* V by the number of its G, SHADE_G_...; n.l and n.v > 0. alpha_l and alpha_v: the widths of D along l and along v,
 * both alpha unless D is anisotropic (shade_alpha_along). */
SHADE_FN float shade_v(int g, shade_angles a, float alpha_l, float alpha_v)
{
	if (g == SHADE_G_IMPLICIT)
		return shade_v_implicit();
	if (g == SHADE_G_NEUMANN)
		return shade_v_neumann(a.n_dot_l, a.n_dot_v);
	if (g == SHADE_G_COOK_TORRANCE)
		return shade_v_cook_torrance(a.n_dot_l, a.n_dot_v, a.n_dot_h, a.v_dot_h);
	if (g == SHADE_G_KELEMEN)
		return shade_v_kelemen(a.v_dot_h);
	if (g == SHADE_G_SMITH_BECKMANN)
		return shade_v1_smith_beckmann(a.n_dot_l, alpha_l) * shade_v1_smith_beckmann(a.n_dot_v, alpha_v);
	if (g == SHADE_G_SMITH_GGX)
		return shade_v_smith_ggx(a.n_dot_l, a.n_dot_v, alpha_l, alpha_v);
	if (g == SHADE_G_SCHLICK_BECKMANN)
		return shade_v1_schlick(a.n_dot_l, shade_schlick_k_beckmann(alpha_l)) *
		       shade_v1_schlick(a.n_dot_v, shade_schlick_k_beckmann(alpha_v));
	return shade_v1_schlick(a.n_dot_l, shade_schlick_k_ggx(alpha_l)) *
	       shade_v1_schlick(a.n_dot_v, shade_schlick_k_ggx(alpha_v));
}

/* G itself, [0, 1]. */
SHADE_FN float shade_g(int g, shade_angles a, float alpha_l, float alpha_v)
{
	return 4.0f * a.n_dot_l * a.n_dot_v * shade_v(g, a, alpha_l, alpha_v);
}

/* ---- F: Fresnel ------------------------------------------------------------------------------------------------- */

/* (1 - v.h)^5, how far Schlick's F has gone from F0 to 1. Source: Schlick (1994), eq. 15. */
SHADE_FN float shade_schlick_share(float v_dot_h)
{
	float m = 1.0f - v_dot_h;
	float m2 = m * m;
	return m2 * m2 * m;
}

/* Schlick: F0 + (1 - F0) (1 - v.h)^5, of one channel and of three. */
SHADE_FN float shade_f_schlick_1(float f0, float v_dot_h)
{
	return f0 + (1.0f - f0) * shade_schlick_share(v_dot_h);
}

SHADE_FN vec3 shade_f_schlick(vec3 f0, float v_dot_h)
{
	return f0 + (vec3(1.0f) - f0) * shade_schlick_share(v_dot_h);
}

/* Cook-Torrance: Fresnel's equations for unpolarised light, with eta = (1 + sqrt F0) / (1 - sqrt F0):
 *   g = sqrt(eta^2 + c^2 - 1), c = v.h,  F = ((g - c) / (g + c))^2 (1 + (((g + c) c - 1) / ((g - c) c + 1))^2) / 2
 * Everything is multiplied by q = 1 - sqrt F0, so that a metal of F0 = 1 needs no infinite eta; (q g)^2 is then
 * 4 sqrt F0 + (q c)^2. F0 outside [0, 1] counts as its nearer end. Source: Cook and Torrance (1982). */
SHADE_FN float shade_f_cook_torrance_1(float f0, float v_dot_h)
{
	float root = sqrt(max(f0, SHADE_F0_MIN));
	float q = max(1.0f - root, SHADE_FRESNEL_EPSILON);
	float c = q * v_dot_h;
	float g = sqrt(4.0f * root + c * c);
	float across = (g - c) / (g + c);
	float along = ((g + c) * v_dot_h - q) / ((g - c) * v_dot_h + q);
	return 0.5f * across * across * (1.0f + along * along);
}

SHADE_FN vec3 shade_f_cook_torrance(vec3 f0, float v_dot_h)
{
	return vec3(shade_f_cook_torrance_1(f0[0], v_dot_h), shade_f_cook_torrance_1(f0[1], v_dot_h),
	            shade_f_cook_torrance_1(f0[2], v_dot_h));
}

/* F by its number, SHADE_F_...; SHADE_F_NONE is F0 for every angle. */
SHADE_FN vec3 shade_f(int f, vec3 f0, float v_dot_h)
{
	if (f == SHADE_F_SCHLICK)
		return shade_f_schlick(f0, v_dot_h);
	if (f == SHADE_F_COOK_TORRANCE)
		return shade_f_cook_torrance(f0, v_dot_h);
	return f0;
}

#include "glsl_end.h"
#endif
