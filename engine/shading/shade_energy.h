/* shade_energy: materials that give back no more light than they get. [any-thread] */
#ifndef SHADE_ENERGY_H
#define SHADE_ENERGY_H

#include "glsl_begin.h"

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

#include "glsl_end.h"
#endif
