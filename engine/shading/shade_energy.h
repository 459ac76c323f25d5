/* shade_energy: materials that give back no more light than they get. [any-thread] */
#ifndef SHADE_ENERGY_H
#define SHADE_ENERGY_H

#include "glsl_begin.h"

#define SHADE_ENERGY_SHARE_MIN 1e-9f

/* Share of the light that leaves evenly, and in the highlight; per channel, [0, 1]. */
SHADE_STRUCT(shade_reflectance)
{
	vec3 diffuse;
	vec3 specular;
};

/* diffuse and specular scaled by the same number in each channel, so that their sum, as floats, is at most 1; where it
 * is at most 1 already they stay, to the last bit or one beside it. Negative inputs count as 0; the sum is finite.
 * Both lobes have an albedo of at most 1, so diffuse + specular <= 1 conserves energy. Called when a material is made,
 * not per pixel. Source: Driscoll, "Energy Conservation In Games" (2009): C_d + C_s <= 1. */
SHADE_FN shade_reflectance shade_limit_to_one(vec3 diffuse, vec3 specular)
{
	vec3 d = max(diffuse, 0.0f);
	vec3 s = max(specular, 0.0f);
	vec3 scale = vec3(1.0f) / max(d + s, 1.0f);
	vec3 s_limited = min(s * scale, 1.0f);
	// The products round; the difference to 1 does not let the sum round past it.
	shade_reflectance limited = {min(d * scale, vec3(1.0f) - s_limited), s_limited};
	return limited;
}

/* What a highlight of GGX with Schlick's Fresnel term leaves of the diffuse light, [0, 1]: all straight ahead, where
 * the diffuse colour has given way already (diffuse + specular <= 1), and next to nothing where a smooth surface is
 * seen at a slant and mirrors all. That highlight reflects f0 a + b of a white environment (numeric/numeric_dfg.h),
 * with a + b <= 1: of diffuse colours of at most 1 - f0 the factor 1 - b leaves no more than it lacks. Our fit to b is
 * above it by .012 (root of the mean square; .095 at most, at cosines below .05) and below it by .004 at most, so light
 * is rather lost than made. n_dot_v, roughness: [0, 1]. Of the viewer's angle alone, as layers take it: Kulla and
 * Conty, "Revisiting Physically Based Shading at Imageworks" (2017). */
SHADE_FN float shade_diffuse_left(float n_dot_v, float roughness)
{
	float c = clamp(n_dot_v, 0.0f, 1.0f);
	float width = roughness * (0.376f + roughness * (1.064f - 1.442f * roughness));
	float width2 = width * width;
	float share = 1.0f - sqrt((c * c + width2) / (1.0f + width2));
	float power = 5.0f - roughness * (1.8f + 1.593f * roughness);
	float most = roughness * (0.737f - roughness * (4.148f + 0.539f * roughness));
	return 1.0f - exp(most + power * log(max(share, SHADE_ENERGY_SHARE_MIN)));
}

#include "glsl_end.h"
#endif
