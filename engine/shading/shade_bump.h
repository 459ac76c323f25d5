/*
 * shade_bump: small bumps on a surface by turning its normal: from a height field or a map of its derivatives, without
 * tangents in the mesh. [any-thread]
 *
 * The surface gradient lies in the surface, points where the height grows fastest and is as long as the slope (metres
 * per metre). It comes from two steps along the surface, s and t: how the position and how the height (both metres)
 * change over each. The steps may be
 *   pixels          a fragment shader passes dFdx and dFdy of position and height: shade_bump_from_height;
 *   pixels, and uv  the map's derivatives come smoothly filtered, the chain rule brings them to pixels:
 *                   shade_bump_from_derivatives. Better up close, where a height texture shows its texels;
 *   ray differences a tracer has no neighbours: shade_ray_differential_* give the position's and the uv's steps;
 *   u and v         where dp/du and dp/dv are known, with shade_bump_gradient alone.
 * Gradients of several layers add up (then shade_bump_normal once), and scaling one scales its bumps' height.
 *
 * Range.      Normals are unit, steps from 1e-12 to 1e12 metres long. Where the two steps are parallel up to 1e-5 (a
 *             silhouette), or one is missing, there is no gradient to be had: it fades to 0 and the normal stays.
 * Exactness.  Only the height's slope counts, not the height, which moves a curved surface's normals apart: exact on a
 *             plane, off by height / radius on a sphere (Blinn, "Simulation of Wrinkled Surfaces", SIGGRAPH 1978).
 * Sources.    Mikkelsen, "Bump Mapping Unparametrized Surfaces on the GPU" (Journal of Graphics, GPU, and Game Tools
 *             15, 2010); Driscoll, "Derivative Maps" (2012), whose code has a minus where the formula above it, and the
 *             paper, have a plus; Igehy, "Tracing Ray Differentials" (SIGGRAPH 1999).
 */
#ifndef SHADE_BUMP_H
#define SHADE_BUMP_H

#include "glsl_begin.h"

#define SHADE_BUMP_STEP2_MIN 1e-24f /* m^2, least square of a step's length */
#define SHADE_BUMP_SINE_MIN 1e-5f   /* least sine of the angle between the two steps, along n */

/* Surface gradient from two steps along the surface and the height's change over each:
 *   ((dp_dt x n) dh_ds + (n x dp_ds) dh_dt) / (n . (dp_ds x dp_dt))
 * n: the surface's own normal (the shading normal where it is smooth). The steps may be swapped or form a left-handed
 * frame: the divisor changes its sign too. Source: Mikkelsen 2010; Driscoll's formula. */
SHADE_FN vec3 shade_bump_gradient(vec3 n, vec3 dp_ds, vec3 dp_dt, float dh_ds, float dh_dt)
{
	// The gradient does not depend on the steps' lengths: scaled to 1, they make the divisor the sine between them.
	float per_s = inversesqrt(max(dot(dp_ds, dp_ds), SHADE_BUMP_STEP2_MIN));
	float per_t = inversesqrt(max(dot(dp_dt, dp_dt), SHADE_BUMP_STEP2_MIN));
	vec3 across_t = cross(dp_dt * per_t, n);
	vec3 across_s = cross(n, dp_ds * per_s);
	float sine = dot(dp_ds * per_s, across_t);
	vec3 rise = across_t * (dh_ds * per_s) + across_s * (dh_dt * per_t);
	return rise * (sign(sine) / max(abs(sine), SHADE_BUMP_SINE_MIN));
}

/* The bumped surface's unit normal: n moved against the gradient. scale multiplies the height, negative ones turn bumps
 * to dents. |scale * gradient| up to 1e18. Source: Mikkelsen 2010, n' = n - gradient. */
SHADE_FN vec3 shade_bump_normal(vec3 n, vec3 gradient, float scale)
{
	return normalize(n - gradient * scale);
}

/* The bumped normal from differences between pixels: position and height (metres), to the right and downwards (or up:
 * it does not matter). In GLSL: dFdxFine(position), dFdyFine(position), dFdxFine(height), dFdyFine(height). */
SHADE_FN vec3 shade_bump_from_height(vec3 n, vec3 dp_dx, vec3 dp_dy, float dh_dx, float dh_dy, float scale)
{
	return shade_bump_normal(n, shade_bump_gradient(n, dp_dx, dp_dy, dh_dx, dh_dy), scale);
}

/* The height's change over a step of which the change of uv is known: the chain rule dh/du du/ds + dh/dv dv/ds.
 * Source: Driscoll 2012. */
SHADE_FN float shade_bump_chain_rule(vec2 dh_duv, vec2 duv_ds)
{
	return dot(dh_duv, duv_ds);
}

/* Derivatives per texel, as a map stores them, to derivatives per unit of uv. size: texels across and down. */
SHADE_FN vec2 shade_bump_derivatives_per_uv(vec2 dh_dtexel, vec2 size)
{
	return dh_dtexel * size;
}

/* The bumped normal from a derivative map's value and the changes of position and uv between pixels. */
SHADE_FN vec3 shade_bump_from_derivatives(vec3 n, vec3 dp_dx, vec3 dp_dy, vec2 dh_duv, vec2 duv_dx, vec2 duv_dy,
                                          float scale)
{
	float dh_dx = shade_bump_chain_rule(dh_duv, duv_dx);
	float dh_dy = shade_bump_chain_rule(dh_duv, duv_dy);
	return shade_bump_from_height(n, dp_dx, dp_dy, dh_dx, dh_dy, scale);
}

/* ---- the tracer's steps ------------------------------------------------------------------------------------------ */

#define SHADE_RAY_COSINE_MIN 1e-4f

/* The differences between the ray of the next pixel and that of this one: of the origins (metres) and of the unit
 * directions. */
SHADE_STRUCT(shade_ray_differential)
{
	vec3 origin;
	vec3 direction;
};

/* The differential of a pinhole camera's ray. forward: the direction through the pixel, before it is made unit;
 * to_next: what is added to it for the next pixel (right or down). Source: Igehy 1999, the derivative of a normalised
 * direction. */
SHADE_FN shade_ray_differential shade_ray_differential_pinhole(vec3 forward, vec3 to_next)
{
	float square = dot(forward, forward);
	vec3 direction = (to_next - forward * (dot(forward, to_next) / square)) * inversesqrt(square);
	shade_ray_differential ray = {vec3(0.0f), direction};
	return ray;
}

/* The position's change over one pixel where the ray hits, on the plane through the hit whose normal is n: the beam
 * goes on for the path (metres) and is then moved along the ray onto the plane. direction: the ray's, unit; its cosine
 * with n counts as at least 1e-4 in size. Source: Igehy 1999, "Transfer". */
SHADE_FN vec3 shade_ray_differential_hit(shade_ray_differential ray, vec3 direction, float path, vec3 n)
{
	vec3 moved = ray.origin + ray.direction * path;
	float cosine = dot(direction, n);
	float divisor = select(cosine < 0.0f, min(cosine, -SHADE_RAY_COSINE_MIN), max(cosine, SHADE_RAY_COSINE_MIN));
	return moved - direction * (dot(moved, n) / divisor);
}

/* The change of uv that goes with a step dp along the surface: dp = du dp_du + dv dp_dv, solved for (du, dv). It fades
 * to 0 where dp_du and dp_dv are parallel (the sine between them below 1e-5), so that there is no solution. */
SHADE_FN vec2 shade_ray_differential_uv(vec3 n, vec3 dp, vec3 dp_du, vec3 dp_dv)
{
	float per_u = inversesqrt(max(dot(dp_du, dp_du), SHADE_BUMP_STEP2_MIN));
	float per_v = inversesqrt(max(dot(dp_dv, dp_dv), SHADE_BUMP_STEP2_MIN));
	float sine = dot(n, cross(dp_du * per_u, dp_dv * per_v));
	float per_sine = sign(sine) / max(abs(sine), SHADE_BUMP_SINE_MIN);
	float du = dot(n, cross(dp, dp_dv * per_v)) * per_u;
	float dv = dot(n, cross(dp_du * per_u, dp)) * per_v;
	return vec2(du, dv) * per_sine;
}

#include "glsl_end.h"
#endif
