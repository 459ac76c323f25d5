/*
 * gi_glass: the rough boundary of a volume of glass, where light turns: GGX facets that refract by Snell's law.
 * [any-thread]
 *
 * Directions are unit, v and h in the coordinates of a frame about the normal: v is on the upper side, where the viewer
 * is, l on the lower one. eta: index of refraction on the viewer's side over that on the other side.
 * Radiance. What is carried is radiance over the square of the index (basic radiance), which refraction leaves as it
 * is, so that no factor of eta^2 stands here.
 * Source: Walter et al., "Microfacet Models for Refraction through Rough Surfaces" (2007), eq. 16, 17, 21, 40.
 */
#ifndef STILB_GI_GLASS_H
#define STILB_GI_GLASS_H

#include "base/base_math.h"
#include "shading/shade_layers.h"
#include "shading/shade_sampling.h"

#define GI_GLASS_TURN_MIN 1e-8f /* keeps the density finite where light hardly turns */

/* Cosine beyond the facet from that on the viewer's side; 0: of total reflection. */
static inline float gi_glass_beyond(float eta, float v_dot_h)
{
	return sqrtf(fmaxf(1.0f - eta * eta * (1.0f - v_dot_h * v_dot_h), 0.0f));
}

/* The cosine that Schlick's term takes: that in the thinner medium. At 0 it is 1: total reflection is met without a
 * jump. */
static inline float gi_glass_thin_side(float eta, float v_dot_h)
{
	return eta > 1.0f ? gi_glass_beyond(eta, v_dot_h) : v_dot_h;
}

/* v refracted by the facet h. Not where all is reflected. */
static inline stilb_vec3 gi_glass_refract(float eta, stilb_vec3 v, stilb_vec3 h)
{
	float c = stilb_vec3_dot(v, h);
	return h * (eta * c - gi_glass_beyond(eta, c)) - v * eta;
}

/* The facet that refracts v to l, on v's side. */
static inline stilb_vec3 gi_glass_facet(float eta, stilb_vec3 v, stilb_vec3 l)
{
	stilb_vec3 sum = v * eta + l;
	float square = stilb_vec3_dot(sum, sum);
	sum *= 1.0f / sqrtf(fmaxf(square, SHADE_COS2_MIN));
	return stilb_vec3_dot(sum, v) < 0.0f ? -sum : sum;
}

/* Density, sr^-1, of l where facets h are chosen as v sees them. */
static inline float gi_glass_pdf(float eta, shade_alphas alphas, stilb_vec3 v, stilb_vec3 l)
{
	stilb_vec3 h = gi_glass_facet(eta, v, l);
	float c = stilb_vec3_dot(v, h), beyond = -stilb_vec3_dot(l, h), turn = eta * c - beyond;
	if (!(h[2] > 0.0f && c > 0.0f && beyond > 0.0f && l[2] < 0.0f))
		return 0.0f;
	return shade_pdf_ggx_visible_normal(alphas, v, h) * beyond / fmaxf(turn * turn, GI_GLASS_TURN_MIN);
}

/* Share of what the facet h lets through that l is not shadowed from: 1 - F of the strongest channel, times Smith's
 * term of l. The BTDF times |n.l| is this times gi_glass_pdf. */
static inline float gi_glass_share(float eta, stilb_vec3 f0, float alpha, float v_dot_h, float l_height)
{
	float across = fabsf(l_height);
	return shade_facet_left(f0, gi_glass_thin_side(eta, v_dot_h)) * 2.0f * across * shade_v1_smith_ggx(across, alpha);
}

#endif
