/*
 * shade_surface: the radiance of a surface under one sun and a sky of two colours; what the renderer's fragment shader
 * calls, and what its tests call in C. [any-thread]
 *
 * Vectors are unit and point away from the surface. Light is linear Rec.709; radiance in W sr^-1 m^-2, irradiance in
 * W m^-2. These structs hold vec3 and so never lie in a buffer shared with the GPU.
 */
#ifndef SHADE_SURFACE_H
#define SHADE_SURFACE_H

#include "shade_blinn_phong.h"
#include "shade_diffuse.h"

#include "glsl_begin.h"

/* diffuse + specular <= 1 per channel (shade_limit_to_one); shininess is Blinn-Phong's exponent, > 0. */
SHADE_STRUCT(shade_material)
{
	vec3 diffuse;
	vec3 specular;
	float shininess;
};

/* direction points to the sun; irradiance is measured across the beam. */
SHADE_STRUCT(shade_sun)
{
	vec3 direction;
	vec3 irradiance;
};

/* Radiance above and below the horizon. */
SHADE_STRUCT(shade_sky)
{
	vec3 sky;
	vec3 ground;
};

/* Cosine between the normal n and the vector halfway between l and v; 0 where l = -v leaves no such vector. */
SHADE_FN float shade_n_dot_h(vec3 n, vec3 l, vec3 v)
{
	vec3 h = l + v;
	return dot(n, h) * inversesqrt(max(dot(h, h), 1e-12f));
}

/* BRDF of the material, per channel, sr^-1: diffuse / pi + specular * modified Blinn-Phong. */
SHADE_FN vec3 shade_surface_brdf(shade_material material, vec3 n, vec3 l, vec3 v)
{
	float highlight = shade_blinn_phong_modified(shade_n_dot_h(n, l, v), material.shininess);
	return shade_lambert(material.diffuse) + material.specular * highlight;
}

/* Radiance from the surface to v:
 *   BRDF * E_sun * max(n.l, 0)  +  diffuse / pi * E_sky
 * with E_sky from shade_hemisphere_irradiance. The sky is reflected evenly only: a material's specular share sees the sun
 * alone. No shadows. */
SHADE_FN vec3 shade_surface_radiance(shade_material material, shade_sun sun, shade_sky sky, vec3 n, vec3 v)
{
	float n_dot_l = max(dot(n, sun.direction), 0.0f);
	vec3 from_sun = shade_surface_brdf(material, n, sun.direction, v) * sun.irradiance * n_dot_l;
	vec3 sky_irradiance = shade_hemisphere_irradiance(clamp(n[1], -1.0f, 1.0f), sky.sky, sky.ground);
	return from_sun + shade_lambert(material.diffuse) * sky_irradiance;
}

#include "glsl_end.h"
#endif
