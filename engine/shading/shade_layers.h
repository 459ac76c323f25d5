/*
 * shade_layers: what glTF lays over a surface, clear coat and sheen, and what goes through it. Both renderers include
 * it. [any-thread]
 *
 * Each function named ..._cos is a BSDF times n.l, sr^-1, of a layer alone. From the inside to the outside, with b the
 * base's own, e what it emits, of n, v, l (unit, away from the surface) and the factors of the material:
 *
 *   b                                             shade_surface.h, with color times 1 - transmission as diffuse colour
 *                                                 and shade_brdf_diffuse_left,
 *       + tint transmission shade_thin_cos        where l is on the other side,
 *   s = b * shade_sheen_left + sheen * shade_sheen_cos,
 *   c = s * (1 - share) + share * shade_coat_cos, share = shade_coat_share; e is times 1 - share, too.
 *
 * Roughness is perceptual, [0, 1]; its square is alpha. Sources: KHR_materials_clearcoat, _sheen, _transmission,
 * _anisotropy (Khronos, 2020-2023).
 */
#ifndef SHADE_LAYERS_H
#define SHADE_LAYERS_H

#include "shade_specular.h"

#include "glsl_begin.h"

#define SHADE_SHEEN_ROUGHNESS_MIN 0.1f
#define SHADE_SHEEN_SINE2_MIN 1e-12f

/* Highlight of GGX with Smith's shadowing and no Fresnel term, n.l included: 0 if l or v is below the surface. */
SHADE_FN float shade_layer_highlight_cos(float roughness, vec3 n, vec3 l, vec3 v)
{
	shade_angles a = shade_angles_of(n, l, v);
	float alpha = shade_alpha_from_roughness(roughness);
	float lit = shade_dv_ggx(a.sin2_h, max(a.n_dot_l, 0.0f), max(a.n_dot_v, 0.0f), alpha) * a.n_dot_l;
	return select(a.n_dot_l > 0.0f && a.n_dot_v > 0.0f, lit, 0.0f);
}

/* ---- clear coat -------------------------------------------------------------------------------------------------- */

/* What the coat sends back instead of what is below it, [0, 1]: Schlick's term of an index of 1.5, of the angle between
 * the viewer and the coat's own normal. coat: [0, 1]. */
SHADE_FN float shade_coat_share(float coat, float n_dot_v)
{
	return coat * shade_f_schlick_1(0.04f, clamp(n_dot_v, 0.0f, 1.0f));
}

/* The coat's highlight, which its share multiplies. n: the coat's own normal. */
SHADE_FN float shade_coat_cos(float roughness, vec3 n, vec3 l, vec3 v)
{
	return shade_layer_highlight_cos(roughness, n, l, v);
}

/* ---- sheen ------------------------------------------------------------------------------------------------------- */

/* Share of a white environment that sheen of the colour 1 reflects to v: our fit, exp of a polynomial in the root of
 * n.v whose coefficients are of r and 1 / r. Right to 0.025, where it is above 1 relative to it (root of the mean
 * square 0.013). Roughness below SHADE_SHEEN_ROUGHNESS_MIN counts as that. */
SHADE_FN float shade_sheen_albedo_raw(float n_dot_v, float roughness)
{
	float r = max(roughness, SHADE_SHEEN_ROUGHNESS_MIN);
	float x = sqrt(clamp(n_dot_v, 0.0f, 1.0f));
	float a = 0.704f - 2.66f * r + 1.448f * r * r + 0.097f / r;
	float b = -0.534f + 1.366f * r - 1.235f * r * r - 0.098f / r;
	float c = -0.715f + 0.1f * r + 0.733f * r * r - 1.008f / r;
	return exp(a + b * x + c * x * x);
}

/* The same of the lobe as it is here, at most 1. */
SHADE_FN float shade_sheen_albedo(float n_dot_v, float roughness)
{
	return min(shade_sheen_albedo_raw(n_dot_v, roughness), 1.0f);
}

/* The fit with a margin for its error, at least the lobe's albedo: what keeps sheen from making light. Straight ahead,
 * where the fit is above that, there is no margin. */
SHADE_FN float shade_sheen_most(float n_dot_v, float roughness)
{
	float raw = shade_sheen_albedo_raw(n_dot_v, roughness);
	float c2 = clamp(n_dot_v * n_dot_v, 0.0f, 1.0f);
	return raw + 0.0235f * (1.0f - c2 * c2) * max(raw, 1.0f);
}

/* D of cloth: (2 + 1 / alpha) sin^(1 / alpha) / (2 pi), densest where fibres stand across. Source: Estevez and Kulla,
 * "Production Friendly Microfacet Sheen BRDF" (2017), eq. 2. */
SHADE_FN float shade_d_sheen(float sin2_h, float roughness)
{
	float r = max(roughness, SHADE_SHEEN_ROUGHNESS_MIN);
	float inverse = 1.0f / (r * r);
	float power = exp(0.5f * inverse * log(max(sin2_h, SHADE_SHEEN_SINE2_MIN)));
	return (2.0f + inverse) * power / (2.0f * SHADE_PI);
}

/* The sheen's D V n.l, with V = 1 / (4 (n.l + n.v - n.l n.v)) of Ashikhmin and Premoze, "Distribution-based BRDFs"
 * (2007), eq. 5; 0 if l or v is below the surface. As it stands the lobe of smooth sheen reflects up to four times what
 * arrives at grazing angles: there it is divided by shade_sheen_most. */
SHADE_FN float shade_sheen_cos(float roughness, vec3 n, vec3 l, vec3 v)
{
	shade_angles a = shade_angles_of(n, l, v);
	float between = max(a.n_dot_l + a.n_dot_v - a.n_dot_l * a.n_dot_v, SHADE_COSINE_EPSILON);
	float lobe = shade_d_sheen(min(a.sin2_h, 1.0f), roughness) * a.n_dot_l / (4.0f * between);
	float above = max(shade_sheen_most(a.n_dot_v, roughness), 1.0f);
	return select(a.n_dot_l > 0.0f && a.n_dot_v > 0.0f, lobe / above, 0.0f);
}

/* The direction about which the lobe lies, unit: light that arrives evenly about it, by the cosine, is about what sheen
 * reflects over its albedo. n.v >= 0. Our fit to the lobe's mean direction, which leans to the viewer. Under three
 * lobes of light anywhere it is right to 0.1 for roughness above 0.7 and to 0.2 at 0.2 (root of the mean square), the
 * light about the normal to 0.14 and 0.4, and GGX's mean about the mirrored direction to 0.35 and 0.8. */
SHADE_FN vec3 shade_sheen_direction(vec3 n, vec3 v, float roughness)
{
	float r = max(roughness, SHADE_SHEEN_ROUGHNESS_MIN);
	float n_dot_v = dot(n, v);
	float lean = 0.227f / (r * r * (1.25f - n_dot_v * n_dot_v));
	vec3 toward = n + (v - n * n_dot_v) * lean;
	return toward * inversesqrt(dot(toward, toward));
}

/* What sheen leaves of the light of what is below it, [0, 1]; color: [0, 1]. Source: Kulla and Conty, "Revisiting
 * Physically Based Shading at Imageworks" (2017), of the viewer's angle alone. */
SHADE_FN float shade_sheen_left(vec3 color, float n_dot_v, float roughness)
{
	return 1.0f - max(color[0], max(color[1], color[2])) * min(shade_sheen_most(n_dot_v, roughness), 1.0f);
}

/* ---- transmission ------------------------------------------------------------------------------------------------ */

/* What a facet of this reflectance lets through: 1 - F of the strongest channel, so that light keeps its hue. */
SHADE_FN float shade_facet_left(vec3 f0, float v_dot_h)
{
	return 1.0f - shade_f_schlick_1(max(f0[0], max(f0[1], f0[2])), v_dot_h);
}

/* Light through a thin wall, whose two faces together do not turn it: the highlight of l mirrored to the viewer's side,
 * of what the facets let through, |n.l| included. 0 if l and v are on the same side, or v is below the surface. */
SHADE_FN float shade_thin_cos(vec3 f0, float roughness, vec3 n, vec3 l, vec3 v)
{
	vec3 mirrored = l - n * (2.0f * dot(n, l));
	float v_dot_h = min(0.5f * length(mirrored + v), 1.0f);
	return shade_layer_highlight_cos(roughness, n, mirrored, v) * shade_facet_left(f0, v_dot_h);
}

/* ---- anisotropy -------------------------------------------------------------------------------------------------- */

/* Roughness and anisotropy, as shade_brdf_parameters has them, of a surface that is brushed along t: alpha along it is
 * mixed with 1 by the strength's square, and across it stays. strength: [0, 1]. */
SHADE_FN vec2 shade_gltf_brushed(float roughness, float strength)
{
	float across = shade_alpha_from_roughness(roughness);
	float along = mix(across, 1.0f, strength * strength);
	return vec2(sqrt(0.5f * (along + across)), (along - across) / (along + across));
}

#include "glsl_end.h"
#endif
