/* shade_diffuse: light that leaves a surface evenly. [any-thread] */
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

/* Wrapped diffuse, BRDF times n.l of a surface that reflects everything, sr^-1: max((n.l + w) / (1 + w)^2, 0) / pi.
 * n_dot_l in [-1, 1]; wrap w in [0, 1], 0 is Lambert, and light reaches the surface down to n.l = -w.
 * The integral over all directions of light is 1: McAuley's energy conservation. It is not reciprocal, and for a single
 * light it does not conserve energy: it reflects (n.l + w) / ((1 + w)^2 n.l) of what arrives, which is more than 1 for
 * n.l < 1 / (2 + w); at 89 degrees and w = 1 it is 14.6.
 * Source: McAuley, "Energy-Conserving Wrapped Diffuse" (2011). */
SHADE_FN float shade_wrapped(float n_dot_l, float wrap)
{
	float w = 1.0f + wrap;
	return max(n_dot_l + wrap, 0.0f) * SHADE_INV_PI / (w * w);
}

#include "glsl_end.h"
#endif
