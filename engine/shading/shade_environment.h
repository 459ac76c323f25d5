/*
 * shade_environment: gloss under a prefiltered environment: where to look its cube and its table up, and what to make
 * of both. [any-thread]
 *
 * The split sum: what a surface reflects of the light from everywhere is about the light's mean over the lobe, from a
 * cube (numeric/numeric_prefilter.h), times what the lobe reflects of a white environment, from a table
 * (numeric/numeric_dfg.h). Source: Karis, "Real Shading in Unreal Engine 4" (2013).
 *
 *   vec2 place = shade_dfg_place(n_dot_v, roughness);
 *   vec2 dfg = texture(table, shade_dfg_texel(place, 64.0f)).rg;
 *   shade_environment_look look = shade_environment_look_of(n, v, roughness);
 *   vec3 light = textureLod(cube, look.toward, shade_environment_mip(look.roughness, mips)).rgb;
 *   vec3 radiance = light * shade_environment_reflectance(f0, dfg);
 *
 * Roughness is perceptual, [0, 1]; unit vectors: n is the normal, v points to the viewer; n_dot_v in [0, 1]. The lobe
 * is GGX with Smith's shadowing and Schlick's Fresnel term (shade_dv_ggx, shade_f_schlick).
 */
#ifndef SHADE_ENVIRONMENT_H
#define SHADE_ENVIRONMENT_H

#include "shade_specular.h"

#include "glsl_begin.h"

#define SHADE_DFG_ROUGHNESS_MIN 0.031622777f /* the square root of SHADE_ALPHA_MIN; the table has none below */
#define SHADE_DFG_WHITE_MIN 1e-3f

/* ---- cubes ------------------------------------------------------------------------------------------------------- */

/* A place on a cube: face 0..5 is +X -X +Y -Y +Z -Z; s from its left to its right side and t from its top to its
 * bottom, [-1, 1]. */
SHADE_STRUCT(shade_cube_place)
{
	int face;
	float s;
	float t;
};

/* Where Vulkan samples a cube in this direction, of any length but 0. Source: Vulkan 1.3, 16.5.3 and 16.5.4, "Cube Map
 * Face Selection"; of two equal axes z counts before y, and y before x. */
SHADE_FN shade_cube_place shade_cube_place_of(vec3 direction)
{
	float x = direction[0];
	float y = direction[1];
	float z = direction[2];
	vec3 size = abs(direction);
	if (size[2] >= max(size[0], size[1])) {
		shade_cube_place on_z = {select(z < 0.0f, 5, 4), x / z, -y / size[2]};
		return on_z;
	}
	if (size[1] >= size[0]) {
		shade_cube_place on_y = {select(y < 0.0f, 3, 2), x / size[1], z / y};
		return on_y;
	}
	shade_cube_place on_x = {select(x < 0.0f, 1, 0), -z / x, -y / size[0]};
	return on_x;
}

/* The direction of a place, not unit: its largest component is 1. */
SHADE_FN vec3 shade_cube_direction(int face, float s, float t)
{
	float side = select(face == 0 || face == 2 || face == 4, 1.0f, -1.0f);
	if (face < 2)
		return vec3(side, -t, -side * s);
	if (face < 4)
		return vec3(s, side, side * t);
	return vec3(side * s, -t, side);
}

/* The mip of a cube with `mips` mips (2 or more), 0 to mips - 1, whose lobe has this roughness; between two mips it is
 * a fraction. And back. */
SHADE_FN float shade_environment_mip(float roughness, float mips)
{
	return roughness * (mips - 1.0f);
}

SHADE_FN float shade_environment_roughness(float mip, float mips)
{
	return mip / (mips - 1.0f);
}

/* Where the middle of the lobe is, unit: between the normal and the mirrored viewer, since shadowing makes a rough lobe
 * lean to the normal. n.v >= 0. The share of the mirrored direction, (1 - alpha) / (1 + 1.25 alpha (1 - n.v)), is our
 * fit to the mean direction of what the lobe reflects: with it the mean is met to 0.06 (root of the mean square over
 * n.v and roughness, 0.15 at most), by the mirrored direction to 0.41 (0.89). Source of the idea: Lagarde and de
 * Rousiers, "Moving Frostbite to Physically Based Rendering" (2014), 4.9.3, whose own share is right to 0.08 and too
 * low for small roughness. */
SHADE_FN vec3 shade_environment_direction(vec3 n, vec3 v, float roughness)
{
	float alpha = shade_alpha_from_roughness(roughness);
	float n_dot_v = max(dot(n, v), 0.0f);
	float share = (1.0f - alpha) / (1.0f + 1.25f * alpha * (1.0f - n_dot_v));
	return normalize(mix(n, reflect(-v, n), share));
}

/* Where to look the cube up: a direction, unit, and the roughness whose mip to take. */
SHADE_STRUCT(shade_environment_look)
{
	vec3 toward;
	float roughness;
};

/* The cube's lobes are round, as seen along the normal. At a slant the real one is long in the plane of normal and
 * viewer, where it keeps its width, and narrow across it: facets that tilt sideways turn the mirrored direction by n.v
 * times as much. A round lobe as narrow as that about the mirrored direction is nearer to it than one as wide as it is
 * long, for a smooth surface; a rough one, which the horizon cuts off, is met by the wide one about the lobe's middle.
 * Our fit goes from the first at alpha 0 to the second from alpha 1 / 1.7 on. n.v >= 0. */
SHADE_FN shade_environment_look shade_environment_look_of(vec3 n, vec3 v, float roughness)
{
	float alpha = shade_alpha_from_roughness(roughness);
	float n_dot_v = clamp(dot(n, v), 0.0f, 1.0f);
	float slim = max(1.0f - 1.7f * alpha, 0.0f);
	vec3 middle = shade_environment_direction(n, v, roughness);
	shade_environment_look look = {normalize(mix(middle, reflect(-v, n), slim)),
	                               roughness * sqrt(1.0f - slim * (1.0f - n_dot_v))};
	return look;
}

/* ---- the table --------------------------------------------------------------------------------------------------- */

/* Its value is (a, b): the lobe reflects f0 a + b of a white environment, without light that facets hand on to others.
 * Source: Karis (2013).
 *
 * Its columns are no steps of n.v, since the lobe changes with n.v over alpha towards the horizon: with x the root of
 * n.v and r the roughness, a column is at (x + x / (x + r (1 - x))) / 2. Rows are steps of roughness. Both run from the
 * middle of the first to the middle of the last texel. (The map is ours: 64 x 64 are then right to 1e-3, where
 * columns by n.v are to 4e-2.) */

/* A table's column and row for these, [0, 1] each. */
SHADE_FN vec2 shade_dfg_place(float n_dot_v, float roughness)
{
	float r = max(roughness, SHADE_DFG_ROUGHNESS_MIN);
	float x = sqrt(clamp(n_dot_v, 0.0f, 1.0f));
	float row = (r - SHADE_DFG_ROUGHNESS_MIN) / (1.0f - SHADE_DFG_ROUGHNESS_MIN);
	return vec2(0.5f * (x + x / (x + r * (1.0f - x))), row);
}

/* The n.v and the roughness of a place: the inverse, for who makes the table. x is the positive root of
 * (1 - r) x^2 + (1 + r - 2 u (1 - r)) x - 2 u r = 0. */
SHADE_FN vec2 shade_dfg_from_place(vec2 place)
{
	float r = mix(SHADE_DFG_ROUGHNESS_MIN, 1.0f, place[1]);
	float rest = 1.0f - r;
	float twice = 2.0f * place[0];
	float b = 1.0f + r - twice * rest;
	float x = 2.0f * twice * r / (b + sqrt(b * b + 4.0f * twice * r * rest));
	return vec2(x * x, r);
}

/* Texture coordinates of a place in a table of side x side texels. */
SHADE_FN vec2 shade_dfg_texel(vec2 place, float side)
{
	return (place * (side - 1.0f) + 0.5f) / side;
}

/* ---- both -------------------------------------------------------------------------------------------------------- */

/* What to multiply a lobe with, of any light, so that it has the light that facets hand on to others, too: then it
 * reflects all of a white environment where f0 is 1, and below that the lost light is tinted once more by f0.
 * Source: Turquin, "Practical multiple scattering compensation for microfacet models" (2019), eq. 16. Against a random
 * walk on the surface (Heitz et al. 2016) it is right to 0.016 for f0 from 0.04 to 1 and roughness from 0.3 on (root of
 * the mean square, 0.053 at most); the sum of series of Fdez-Aguera (2019) to 0.024 (0.086). */
SHADE_FN vec3 shade_energy_compensation(vec3 f0, vec2 dfg)
{
	float white = max(dfg[0] + dfg[1], SHADE_DFG_WHITE_MIN);
	return vec3(1.0f) + f0 * ((1.0f - white) / white);
}

/* Share of a white environment that gloss of this f0 reflects, per channel, at most 1. */
SHADE_FN vec3 shade_environment_reflectance(vec3 f0, vec2 dfg)
{
	return (f0 * dfg[0] + vec3(dfg[1])) * shade_energy_compensation(f0, dfg);
}

#include "glsl_end.h"
#endif
