/* shade_diffuse: light that leaves a surface evenly, and the irradiance of a sky of two colours. [any-thread] */
#ifndef SHADE_DIFFUSE_H
#define SHADE_DIFFUSE_H

#include "shade_constants.h"

#include "glsl_begin.h"

/* BRDF of a Lambertian surface, sr^-1: diffuse / pi, since the hemisphere's integral of cos is pi.
 * diffuse: reflectance per channel, [0, 1]. Source: Driscoll, "Energy Conservation In Games" (2009). */
SHADE_FN vec3 shade_lambert(vec3 diffuse)
{
	return diffuse * SHADE_INV_PI;
}

/* Irradiance (W m^-2) on a surface whose normal has the height normal_y in [-1, 1], under surroundings of two uniform
 * halves: radiance sky above the horizon, ground below it, nothing in the way. Exact:
 *   E = pi (sky (1 + normal_y) / 2 + ground (1 - normal_y) / 2)
 * Source: the tilted plane's view factor of the sky, (1 + cos) / 2: Liu and Jordan, "The Long-Term Average Performance of
 * Flat-Plate Solar-Energy Collectors" (1963). */
SHADE_FN vec3 shade_hemisphere_irradiance(float normal_y, vec3 sky, vec3 ground)
{
	return mix(ground, sky, 0.5f + 0.5f * normal_y) * SHADE_PI;
}

#include "glsl_end.h"
#endif
