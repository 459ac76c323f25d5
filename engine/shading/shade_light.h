/*
 * shade_light: lights and their units, in one place: what a sun, a sky of two colours and lamps send to a point.
 * [any-thread]
 *
 * Units, radiometric; read lumen, candela, lux and nit for the photometric twins, every formula stays:
 *   L  radiance    W sr^-1 m^-2   what a surface shows; does not fall off with distance
 *   E  irradiance  W m^-2         what arrives; across the beam, unless a normal is named
 *   I  intensity   W sr^-1        a whole lamp, seen from far away
 *      flux        W              a whole lamp, over all directions
 * A lamp of the radius r0 whose surface has the radiance L shows a disc of the area pi r0^2 to whom it faces:
 *   I = pi L r0^2        E = I / d^2 = pi L (r0 / d)^2        flux = 4 pi I for a sphere, pi I for a disk (one face)
 * Here a sun holds E, a sky holds L, and a light with a place holds I: its brightness from afar stays when its size
 * changes. Games
 * often leave the pi out and call L r0^2 the intensity, so that a light of 1 shows a white surface as 1:
 * shade_from_pi_folded.
 *
 * A falloff is E / I in m^-2. It depends on d^2, so that no root is needed, and it is clamped inside the lamp's shape,
 * where 1 / d^2 would claim more than the surface's pi L. Karis's falloffs, which stand for E / (pi L), are r0^2 times
 * these. What a lamp sends to one point comes from one direction, so it is handed on as a sun. Nothing here casts
 * shadows.
 *
 * Ranges: lengths in [0, 1e9] m, light in [0, 1e15]. These structs hold vec3 and never lie in a buffer shared with the
 * GPU.
 * Sources: Schueler, "The Blinn-Phong Normalization Zoo" (2011), "Two Pi Or Not Two Pi" with its comments; Karis,
 * "Tiled Light Culling" (2012).
 */
#ifndef SHADE_LIGHT_H
#define SHADE_LIGHT_H

#include "shade_constants.h"
#include "shade_luminance.h"

#include "glsl_begin.h"

/* No two points are nearer than the root of this (0.1 mm, in m^2): keeps a lamp without a radius finite. */
#define SHADE_LIGHT_SQUARE_MIN 1e-8f

/* shade_hemisphere_share: the largest axis_y^2, just below 1 so that the logarithm of 1 - axis_y^2 is finite. */
#define SHADE_HEMISPHERE_SQUARE_MAX 0.99999994f

/* Lumens of one watt of white light. Source: Ward and Shakespeare, "Rendering with Radiance" (1998), WHTEFFICACY. */
#define SHADE_LIGHT_EFFICACY 179.0f

/* A colour darker than this has no lumens to be scaled to: it stays black. */
#define SHADE_LIGHT_LUMINANCE_MIN 1e-30f

/* direction points to the sun; irradiance is measured across the beam, W m^-2. */
SHADE_STRUCT(shade_sun)
{
	vec3 direction;
	vec3 irradiance;
};

/* Radiance above and below the horizon, W sr^-1 m^-2. */
SHADE_STRUCT(shade_sky)
{
	vec3 sky;
	vec3 ground;
};

/* A light of any kind, as stilb_scene_light: kind is a SHADE_LIGHT_, falloff a SHADE_FALLOFF_. position: its centre, m,
 * unused by a directional light. direction: unit, from the light into the scene; the normal of a disk or a rectangle,
 * which shine to that side alone. A light that is not flat shines from -direction at its very centre. intensity:
 * W sr^-1, of a flat light along direction; of a directional one irradiance across the beam, W m^-2. cos_inner,
 * cos_outer: of a spot's cone, see shade_spot_share. radius: of a sphere or a disk, m, may be 0. half_x, half_y: of a
 * rectangle, from its centre to the middles of two neighbouring sides, m. reach: where a falloff that is not physical
 * ends, m, beyond the radius. */
SHADE_STRUCT(shade_light)
{
	int kind;
	int falloff;
	vec3 position;
	vec3 direction;
	vec3 intensity;
	float cos_inner;
	float cos_outer;
	float radius;
	vec3 half_x;
	vec3 half_y;
	float reach;
};

/* ---- units ------------------------------------------------------------------------------------------------------- */

/* I = pi L r0^2 of a sphere, or of a disk along its axis. Source: Schueler, reply to Iryoku: his I, not his
 * I', which leaves the pi out. */
SHADE_FN vec3 shade_intensity_from_radiance(vec3 radiance, float radius)
{
	return radiance * (SHADE_PI * radius * radius);
}

/* L = I / (pi r0^2), its inverse; radius above 0.1 mm, a smaller one counts as that. */
SHADE_FN vec3 shade_radiance_from_intensity(vec3 intensity, float radius)
{
	return intensity / (SHADE_PI * max(radius * radius, SHADE_LIGHT_SQUARE_MIN));
}

/* I = flux / (4 pi) of a sphere: 4 pi is the whole sphere of directions. Candela from lumen. */
SHADE_FN vec3 shade_intensity_from_flux_sphere(vec3 flux)
{
	return flux / (4.0f * SHADE_PI);
}

/* flux = 4 pi I of a sphere. Lumen from candela. */
SHADE_FN vec3 shade_flux_from_intensity_sphere(vec3 intensity)
{
	return intensity * (4.0f * SHADE_PI);
}

/* I = flux / pi along the axis of a disk that shines to one side: pi is the hemisphere's integral of cos. */
SHADE_FN vec3 shade_intensity_from_flux_disk(vec3 flux)
{
	return flux / SHADE_PI;
}

/* flux = pi I of a disk. */
SHADE_FN vec3 shade_flux_from_intensity_disk(vec3 intensity)
{
	return intensity * SHADE_PI;
}

/* The games' convention to this one, for intensity and irradiance alike: E = pi E', I = pi I' (I' = L r0^2). A sun of
 * E' = 1 shows a white Lambertian surface that faces it as radiance 1. Source: Schueler, reply to Gaame: I'; Hoffman,
 * "Crafting Physically Motivated Shading Models for Game Development" (2010). */
SHADE_FN vec3 shade_from_pi_folded(vec3 folded)
{
	return folded * SHADE_PI;
}

/* This convention to the games'. */
SHADE_FN vec3 shade_to_pi_folded(vec3 light)
{
	return light * SHADE_INV_PI;
}

/* Watts of a light of the given colour from its lumens; W sr^-1 from candela, W m^-2 from lux. color: linear Rec.709,
 * of any height, since the result's luminance is lumens / 179; black stays black. Source: Ward and Shakespeare. */
SHADE_FN vec3 shade_watts_from_lumens(float lumens, vec3 color)
{
	return color * (lumens / (SHADE_LIGHT_EFFICACY * max(shade_luminance(color), SHADE_LIGHT_LUMINANCE_MIN)));
}

/* ---- sky and ground ---------------------------------------------------------------------------------------------- */

/* Irradiance on a surface whose normal has the height normal_y in [-1, 1], under surroundings of two uniform halves:
 * radiance sky above the horizon, ground below it, nothing in the way. Exact:
 *   E = pi (sky (1 + normal_y) / 2 + ground (1 - normal_y) / 2)
 * Source: the tilted plane's view factor of the sky, (1 + cos) / 2: Liu and Jordan, "The Long-Term Average Performance
 * of Flat-Plate Solar-Energy Collectors" (1963). */
SHADE_FN vec3 shade_hemisphere_irradiance(float normal_y, vec3 sky, vec3 ground)
{
	return mix(ground, sky, 0.5f + 0.5f * normal_y) * SHADE_PI;
}

/* Share, [0, 1], of the lobe max(axis . l, 0)^n that lies above the horizon. axis_y: height of the axis, [-1, 1];
 * exponent n in [0, 1e6]. The horizon is a great circle of the lobe, so the share is exactly
 *   integral of cos^n from -pi/2 to asin(axis_y), divided by the same up to pi/2,
 * a line for n = 1 (Liu and Jordan's), smoothstep for n = 3, a Gaussian's integral for large n. One closed form stands
 * for all of them:
 *   (1 +- sqrt(1 - (1 - axis_y^2)^k)) / 2,   k = 2 / pi (n + 1/2 + 1 / (8 n + 49/8))
 * k gives it the exact slope at the horizon (the ratio of two gamma functions, to 2e-4 for n >= 1). It is the line for
 * n = 1 and Polya's Gaussian for large n. Error below 0.0032 for n >= 0.5, below 0.0065 from there to 0. Source:
 * derived here; Polya, "Remarks on Computing the Probability Integral in One and Two Dimensions" (1949). */
SHADE_FN float shade_hemisphere_share(float axis_y, float exponent)
{
	float k = 2.0f * SHADE_INV_PI * (exponent + 0.5f + 1.0f / (8.0f * exponent + 6.125f));
	float square = min(axis_y * axis_y, SHADE_HEMISPHERE_SQUARE_MAX);
	float half_width = 0.5f * sqrt(shade_one_minus_exp(-k * shade_log1p(-square)));
	return 0.5f + select(axis_y < 0.0f, -half_width, half_width);
}

/* Mean radiance of sky and ground under a highlight: the lobe above about the mirrored view, whose height is
 * reflected_y in [-1, 1]. Times the material's specular reflectance it is the surface's answer to its surroundings;
 * exponent 1 gives the diffuse form over pi. exponent: about the mirrored direction (shade_exponent_about_r). */
SHADE_FN vec3 shade_hemisphere_radiance(float reflected_y, float exponent, vec3 sky, vec3 ground)
{
	return mix(ground, sky, shade_hemisphere_share(reflected_y, exponent));
}

/* ---- falloff ----------------------------------------------------------------------------------------------------- */

/* E / I of a sphere, m^-2: 1 / d^2, and 1 / radius^2 inside. square: d^2. Exact at every distance for a surface that
 * has the whole sphere above its horizon, with n.l taken at the centre: the integral over the cap of directions that
 * the sphere fills, with the half angle b, is pi L sin(b)^2 n.l, and sin(b) = r0 / d. Source: Karis, "Sphere";
 * Schueler's derivation of E. */
SHADE_FN float shade_falloff_sphere(float square, float radius)
{
	return 1.0f / max(max(square, radius * radius), SHADE_LIGHT_SQUARE_MIN);
}

/* E / I of a disk, m^-2: 1 / (d^2 + radius^2). Exact on the axis for a surface that faces the disk. Elsewhere it is
 * taken times the cosine at the disk, as from afar: too little by 3 (sin(b) radius / d)^2 of it, b being the angle to
 * the axis; 1 % at most from 18 radii on. Source: Karis, "Disk". */
SHADE_FN float shade_falloff_disk(float square, float radius)
{
	return 1.0f / max(square + radius * radius, SHADE_LIGHT_SQUARE_MIN);
}

/* What ends a falloff at reach: max(1 - d^2 / reach^2, 0)^2, a factor in [0, 1]. Value and slope are 0 at the end, so
 * that no edge is seen there. Source: Karis, "windowing". */
SHADE_FN float shade_falloff_window(float square, float reach)
{
	float left = max(1.0f - square / max(reach * reach, SHADE_LIGHT_SQUARE_MIN), 0.0f);
	return left * left;
}

/* The other way to end a falloff: max(falloff - tolerance, 0), m^-2. The irradiance is nowhere too low by more than
 * tolerance * I, an error proportional to the light's intensity. For the same reach it keeps more light than the window
 * does, but its slope is not 0 at the end, which shows as an edge. Source: Karis, "Culling inverse squared falloff". */
SHADE_FN float shade_falloff_subtracted(float falloff, float tolerance)
{
	return max(falloff - tolerance, 0.0f);
}

/* The tolerance for which the falloff of a sphere ends at reach: 1 / reach^2. */
SHADE_FN float shade_tolerance_from_reach(float reach)
{
	return 1.0f / max(reach * reach, SHADE_LIGHT_SQUARE_MIN);
}

/* The reach of a sphere whose irradiance may miss error, W m^-2: sqrt(intensity / error). For a material whose
 * highlight is higher than its diffuse light, intensity is multiplied by that height: the sphere that culls its
 * highlight. error > 0. */
SHADE_FN float shade_reach_from_error(float intensity, float error)
{
	return sqrt(intensity / error);
}

/* What ends a falloff at reach in files of glTF: max(1 - d^4 / reach^4, 0), a factor in [0, 1]. It keeps more light
 * than the window does, and ends with an edge. Source: Khronos, KHR_lights_punctual, "Range Property". */
SHADE_FN float shade_falloff_range(float square, float reach)
{
	float share = square / max(reach * reach, SHADE_LIGHT_SQUARE_MIN);
	return max(1.0f - share * share, 0.0f);
}

/* The share, [0, 1], of its light that the falloff leaves at the distance sqrt(square) from the light's centre: 1,
 * shade_falloff_window, shade_falloff_range, or what shade_falloff_subtracted leaves of a sphere's falloff for the
 * tolerance of this reach.
 * radius: of a sphere or a disk, else 0. */
#define SHADE_FALLOFF_PHYSICAL 0
#define SHADE_FALLOFF_WINDOWED 1
#define SHADE_FALLOFF_SUBTRACTED 2
#define SHADE_FALLOFF_RANGED 3
SHADE_FN float shade_falloff_share(int falloff, float square, float radius, float reach)
{
	if (falloff == SHADE_FALLOFF_PHYSICAL)
		return 1.0f;
	if (falloff == SHADE_FALLOFF_WINDOWED)
		return shade_falloff_window(square, reach);
	if (falloff == SHADE_FALLOFF_RANGED)
		return shade_falloff_range(square, reach);
	return max(1.0f - max(square, radius * radius) * shade_tolerance_from_reach(reach), 0.0f);
}

/* ---- lights ------------------------------------------------------------------------------------------------------ */

/* The kinds of shade_light, numbered as stilb_scene_light_kind. */
#define SHADE_LIGHT_POINT 0
#define SHADE_LIGHT_SPOT 1
#define SHADE_LIGHT_DIRECTIONAL 2
#define SHADE_LIGHT_SPHERE 3
#define SHADE_LIGHT_DISK 4
#define SHADE_LIGHT_RECTANGLE 5
#define SHADE_LIGHT_COUNT 6

/* shade_spot_share: the least difference of the cosines; keeps the edge of a sharp cone finite. */
#define SHADE_SPOT_WIDTH_MIN 1e-6f

/* Share of its intensity, [0, 1], that a spot sends where the cosine from its axis is `cosine`: 1 from cos_inner on, 0
 * up to cos_outer, and a smoothstep between. cos_inner >= cos_outer; where they are equal, the share is 1 above them.
 * Source: derived here; glTF's KHR_lights_punctual leaves the curve open, and suggests t^2. */
SHADE_FN float shade_spot_share(float cosine, float cos_inner, float cos_outer)
{
	float t = clamp((cosine - cos_outer) / max(cos_inner - cos_outer, SHADE_SPOT_WIDTH_MIN), 0.0f, 1.0f);
	return t * t * (3.0f - 2.0f * t);
}

/* Area of a rectangle, m^2. */
SHADE_FN float shade_rectangle_area(vec3 half_x, vec3 half_y)
{
	return 4.0f * sqrt(dot(half_x, half_x) * dot(half_y, half_y));
}

/* E / I of a light with a place, m^-2, at the distance sqrt(square); cosine: between its direction and the point, below
 * 0 counts as 0. A rectangle counts as a disk of the same area. */
SHADE_FN float shade_light_falloff(shade_light light, float square, float cosine)
{
	float share = shade_falloff_share(light.falloff, square, light.radius, light.reach);
	if (light.kind == SHADE_LIGHT_SPHERE)
		return share * shade_falloff_sphere(square, light.radius);
	if (light.kind == SHADE_LIGHT_DISK)
		return share * (max(cosine, 0.0f) * shade_falloff_disk(square, light.radius));
	if (light.kind == SHADE_LIGHT_RECTANGLE) {
		float radius = sqrt(shade_rectangle_area(light.half_x, light.half_y) * SHADE_INV_PI);
		return share * (max(cosine, 0.0f) * shade_falloff_disk(square, radius));
	}
	if (light.kind == SHADE_LIGHT_SPOT)
		share *= shade_spot_share(cosine, light.cos_inner, light.cos_outer);
	return share / max(square, SHADE_LIGHT_SQUARE_MIN);
}

/* What the light sends to position, as a sun: all of it as if it came from the light's centre. */
SHADE_FN shade_sun shade_light_at(shade_light light, vec3 position)
{
	if (light.kind == SHADE_LIGHT_DIRECTIONAL) {
		shade_sun distant = {-light.direction, light.intensity};
		return distant;
	}
	vec3 offset = light.position - position;
	float square = dot(offset, offset);
	vec3 direction = select(square > SHADE_LIGHT_SQUARE_MIN, offset * inversesqrt(square), -light.direction);
	float falloff = shade_light_falloff(light, square, -dot(direction, light.direction));
	shade_sun seen = {direction, light.intensity * falloff};
	return seen;
}

#include "glsl_end.h"
#endif
