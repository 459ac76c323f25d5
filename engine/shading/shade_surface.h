/*
 * shade_surface: the radiance of a surface under one light and a sky of two colours; what the renderer's fragment
 * shader calls, and what its tests call in C. [any-thread]
 *
 * Vectors are unit and point away from the surface. Light is linear Rec.709; radiance in W sr^-1 m^-2, irradiance in
 * W m^-2. These structs hold vec3 and so never lie in a buffer shared with the GPU.
 */
#ifndef SHADE_SURFACE_H
#define SHADE_SURFACE_H

#include "shade_brdf.h"
#include "shade_light_area.h"

#include "glsl_begin.h"

/* diffuse + specular <= 1 per channel (shade_limit_to_one); the rest as in shade_brdf_parameters. */
SHADE_STRUCT(shade_material)
{
	vec3 diffuse;
	vec3 specular;
	float roughness;
	float anisotropy;
	float wrap;
};

/* The material as it is seen at this cosine between normal and viewer: the highlight takes of its diffuse light
 * (shade_brdf_diffuse_left). What all functions below are given. */
SHADE_FN shade_material shade_surface_seen(shade_brdf_model model, shade_material material, float n_dot_v)
{
	shade_material seen = material;
	float strongest = max(material.specular[0], max(material.specular[1], material.specular[2]));
	if (strongest > 0.0f)
		seen.diffuse = material.diffuse * shade_brdf_diffuse_left(model, n_dot_v, material.roughness);
	return seen;
}

/* Diffuse share of the BRDF times n.l, per channel, sr^-1. It is wrapped by material.wrap, and by nothing for
 * SHADE_BRDF_LAMBERT. */
SHADE_FN vec3 shade_surface_diffuse_cos(shade_brdf_model model, shade_material material, vec3 n, vec3 l)
{
	float wrap = select(model.kind == SHADE_BRDF_LAMBERT, 0.0f, material.wrap);
	return material.diffuse * shade_wrapped(dot(n, l), wrap);
}

/* Highlight times n.l, per channel, sr^-1; the two diffuse kinds have none. */
SHADE_FN vec3 shade_surface_highlight_cos(shade_brdf_model model, shade_material material, shade_frame frame, vec3 l,
                                          vec3 v)
{
	if (model.kind == SHADE_BRDF_LAMBERT || model.kind == SHADE_BRDF_WRAPPED)
		return vec3(0.0f);
	shade_brdf_parameters p = {material.specular, material.roughness, material.anisotropy, material.wrap};
	return shade_brdf_cos(model, p, frame, l, v);
}

/* BRDF times n.l of the material, per channel, sr^-1: diffuse share and highlight. */
SHADE_FN vec3 shade_surface_brdf_cos(shade_brdf_model model, shade_material material, shade_frame frame, vec3 l, vec3 v)
{
	return shade_surface_diffuse_cos(model, material, frame.n, l) +
	       shade_surface_highlight_cos(model, material, frame, l, v);
}

/* Radiance from the surface to v of one light: seen, from shade_light_at; of a light with a size also spread, from
 * shade_area_irradiance, which the diffuse share takes in its place, unless it is wrapped. The material's roughness is
 * then that of shade_roughness_under. */
SHADE_FN vec3 shade_surface_lit(shade_brdf_model model, shade_material material, shade_frame frame, shade_sun seen,
                                bool sized, vec3 spread, vec3 v)
{
	bool wrapped = model.kind != SHADE_BRDF_LAMBERT && material.wrap > 0.0f;
	vec3 even = shade_lambert(material.diffuse) * spread;
	if (!sized || wrapped)
		even = shade_surface_diffuse_cos(model, material, frame.n, seen.direction) * seen.irradiance;
	return even + shade_surface_highlight_cos(model, material, frame, seen.direction, v) * seen.irradiance;
}

/* The share of a point's view that a light with a size takes, as the squared sine of the angle at which the radius of a
 * disk is seen that would take as much: r^2 / d^2 of a sphere, A cos / (pi d^2) of a disk or a rectangle. [0, 1] */
SHADE_FN float shade_light_share(shade_light light, vec3 position)
{
	vec3 center = light.position - position;
	float square = max(dot(center, center), SHADE_LIGHT_SQUARE_MIN), round = light.radius * light.radius;
	if (light.kind == SHADE_LIGHT_RECTANGLE)
		round = shade_rectangle_area(light.half_x, light.half_y) * SHADE_INV_PI;
	if (light.kind != SHADE_LIGHT_SPHERE)
		round *= max(-dot(center, light.direction), 0.0f) * inversesqrt(square);
	return min(round / square, 1.0f);
}

/* What a light's size adds to the square of alpha, for each of its share. */
#define SHADE_LIGHT_WIDENS 0.1875f

/* The roughness with which the highlight of a light's centre looks like that of the whole light, whose share is
 * [0, 1]: alpha'^2 = alpha^2 + 3/16 share. Half vectors turn by half as much as the light's points, which alone would
 * be 1/8; of seven factors that were tried 3/16 is the nearest to integrals of GGX, Blinn-Phong and Phong over a
 * sphere, a disk and a rectangle. Source: Karis, "Real Shading in Unreal Engine 4" (2013), for the idea; the form is
 * ours. */
SHADE_FN float shade_roughness_under(float roughness, float share)
{
	float alpha = shade_alpha_from_roughness(roughness);
	return sqrt(sqrt(min(alpha * alpha + SHADE_LIGHT_WIDENS * share, 1.0f)));
}

/* The same for a light and a position. */
SHADE_FN vec3 shade_surface_light(shade_brdf_model model, shade_material material, shade_frame frame, shade_light light,
                                  vec3 position, vec3 v)
{
	bool sized = shade_light_is_sized(light.kind);
	vec3 spread = vec3(0.0f);
	if (sized) {
		spread = shade_area_irradiance(light, position, frame.n);
		material.roughness = shade_roughness_under(material.roughness, shade_light_share(light, position));
	}
	return shade_surface_lit(model, material, frame, shade_light_at(light, position), sized, spread, v);
}

/* Radiance from the surface to v of what the sky sends, evenly reflected: diffuse / pi * E_sky, with E_sky from
 * shade_hemisphere_irradiance. */
SHADE_FN vec3 shade_surface_sky(shade_material material, shade_sky sky, vec3 n)
{
	vec3 irradiance = shade_hemisphere_irradiance(clamp(n[1], -1.0f, 1.0f), sky.sky, sky.ground);
	return shade_lambert(material.diffuse) * irradiance;
}

/* Radiance from the surface to v: BRDF n.l E_sun, and shade_surface_sky. A material's specular share sees the sun
 * alone. No shadows. */
SHADE_FN vec3 shade_surface_radiance(shade_brdf_model model, shade_material material, shade_sun sun, shade_sky sky,
                                     shade_frame frame, vec3 v)
{
	vec3 from_sun = shade_surface_brdf_cos(model, material, frame, sun.direction, v) * sun.irradiance;
	return from_sun + shade_surface_sky(material, sky, frame.n);
}

#include "glsl_end.h"
#endif
