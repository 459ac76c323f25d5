/*
 * bake_basis: light from three directions, for surfaces with bumps: the basis of Half-Life 2.
 *
 * Source.      McTaggart, "Half-Life 2 / Valve Source Shading", GDC 2004: three directions perpendicular to each other,
 *              all equally far off the normal; a bumped normal n takes their colours with the weights max(n . b, 0)^2
 *              over their sum.
 * Frame.       Of a texel: x along growing u of the page, made perpendicular to the normal; y along growing v,
 *              perpendicular to both; z the normal. So whoever has positions and the second uv can make it.
 * Colours.     c_k = E_k L / mean(E): E_k the irradiance / pi of a white surface that faces b_k, of which the part
 *              below the surface's horizon sees nothing, L the lightmap, each channel by itself. So a surface without
 *              bumps, which weighs all three alike, has the lightmap exactly.
 * Threads.     [any-thread]
 */
#ifndef STILB_BAKE_BASIS_H
#define STILB_BAKE_BASIS_H

#include "base/base_math.h"
#include "shading/shade_luminance.h"

#define STILB_BAKE_BASIS 3

/* Direction k in the frame's coordinates. */
static inline stilb_vec3 stilb_bake_basis(uint32_t k)
{
	static const float directions[STILB_BAKE_BASIS][3] = {{0.81649658f, 0.0f, 0.57735027f},
	                                                      {-0.40824829f, 0.70710678f, 0.57735027f},
	                                                      {-0.40824829f, -0.70710678f, 0.57735027f}};
	return stilb_vec3_make(directions[k][0], directions[k][1], directions[k][2]);
}

/* The weights of a unit normal in the frame's coordinates, 1 together; of one that faces none of them 1/3 each. */
static inline stilb_vec3 stilb_bake_basis_weights(stilb_vec3 normal)
{
	stilb_vec3 weights = {0};
	float sum = 0.0f;
	for (uint32_t k = 0; k < STILB_BAKE_BASIS; k++) {
		float cosine = fmaxf(stilb_vec3_dot(normal, stilb_bake_basis(k)), 0.0f);
		weights[k] = cosine * cosine;
		sum += weights[k];
	}
	return sum > 0.0f ? weights * (1.0f / sum) : stilb_vec3_make(1.0f / 3.0f, 1.0f / 3.0f, 1.0f / 3.0f);
}

/* The two-texture form: how much of the lightmap's light comes from each direction, 1 on the mean, all of it in the
 * lightmap's colour; its bumps are wrong where they face lights of different colours. directional: the colours of the
 * basis. Source: Karis, "UDK" (graphicrants.blogspot.com, 2009). */
static inline void stilb_bake_intensities(float (*directional)[3], float intensities[STILB_BAKE_BASIS])
{
	float sum = 0.0f;
	for (uint32_t k = 0; k < STILB_BAKE_BASIS; k++) {
		const float *color = directional[k];
		intensities[k] = shade_luminance(stilb_vec3_make(color[0], color[1], color[2]));
		sum += intensities[k];
	}
	for (uint32_t k = 0; k < STILB_BAKE_BASIS; k++)
		intensities[k] = sum > 0.0f ? intensities[k] * (float)STILB_BAKE_BASIS / sum : 1.0f;
}

#endif
