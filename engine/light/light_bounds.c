/* How far one light reaches. */
#include "light/light_internal.h"
#include "shading/shade_light.h"

#include <math.h>

#define REACH_MIN 1e-4       /* metres: root of SHADE_LIGHT_SQUARE_MIN */
#define REACH_MAX 1e18       /* metres: beyond it a light counts as reaching everywhere */
#define REACH_GROWTH 0x1p-18 /* share: what a GPU may round a distance or a falloff by */
#define COSINE_GROWTH 1e-5   /* the same of a cosine */
#define COSINE_45 0.70710678 /* of 45 degrees */

static double dot3(const float a[3], const float b[3])
{
	return (double)a[0] * (double)b[0] + (double)a[1] * (double)b[1] + (double)a[2] * (double)b[2];
}

static double brightest(const stilb_scene_light *light)
{
	return light_larger((double)light->intensity[0],
	                    light_larger((double)light->intensity[1], (double)light->intensity[2]));
}

/* The distance at which intensity * share(d) / d^2 falls to irradiance, share being the falloff's. With u = (d /
 * reach)^2 and q = irradiance * reach^2 / intensity the forms are (1 - u)^2 = q u, 1 - u = q u and 1 - u^2 = q u. */
static double reach_of(const stilb_scene_light *light, double intensity, double irradiance)
{
	if (light->falloff == STILB_SCENE_LIGHT_PHYSICAL)
		return sqrt(intensity / irradiance);
	double end = light_larger((double)light->reach, REACH_MIN), q = irradiance * end * end / intensity,
		   u = 1.0 / (1.0 + q);
	if (light->falloff == STILB_SCENE_LIGHT_WINDOWED)
		u = 2.0 / (2.0 + q + sqrt(q * q + 4.0 * q));
	if (light->falloff == STILB_SCENE_LIGHT_RANGED)
		u = 2.0 / (q + sqrt(q * q + 4.0));
	return end * sqrt(u);
}

/* intensity * share(d) / d^2, share being the falloff's. */
static double irradiance_of(const stilb_scene_light *light, double intensity, double distance)
{
	double sent = intensity / (distance * distance);
	if (light->falloff == STILB_SCENE_LIGHT_PHYSICAL)
		return sent;
	double end = light_larger((double)light->reach, REACH_MIN), u = distance / end * (distance / end);
	if (u >= 1.0)
		return 0.0;
	if (light->falloff == STILB_SCENE_LIGHT_WINDOWED)
		return sent * (1.0 - u) * (1.0 - u);
	return sent * (light->falloff == STILB_SCENE_LIGHT_RANGED ? 1.0 - u * u : 1.0 - u);
}

/* A sphere, and a disk, which the sphere around it hides, send at most I / d^2 from their centre, whatever part of them
 * a surface sees. So does a rectangle that the sphere around it replaces, with the same radiance, hence as much more
 * intensity as the sphere's disk has area; or all of it drawn together in its nearest point. */
double light_reach(const stilb_scene_light *light, double irradiance)
{
	double intensity = brightest(light);
	if (!(intensity > 0.0))
		return 0.0;
	if (!(irradiance > 0.0))
		return light->falloff == STILB_SCENE_LIGHT_PHYSICAL ? (double)INFINITY
		                                                    : light_larger((double)light->reach, REACH_MIN);
	double reach = reach_of(light, intensity, irradiance);
	if (light->kind == STILB_SCENE_LIGHT_RECTANGLE) {
		double xx = dot3(light->half_x, light->half_x), yy = dot3(light->half_y, light->half_y);
		double wider = reach_of(light, intensity * (double)SHADE_PI * (xx + yy) / (4.0 * sqrt(xx * yy)), irradiance);
		double farther = sqrt(intensity / irradiance) + sqrt(xx + yy);
		reach = light_smaller(wider, farther);
	}
	return reach;
}

/* By the same two bounds. */
double light_irradiance(const stilb_scene_light *light, double distance)
{
	double intensity = brightest(light);
	if (!(intensity > 0.0))
		return 0.0;
	if (!(distance > REACH_MIN))
		return (double)INFINITY;
	double sent = irradiance_of(light, intensity, distance);
	if (light->kind == STILB_SCENE_LIGHT_RECTANGLE) {
		double xx = dot3(light->half_x, light->half_x), yy = dot3(light->half_y, light->half_y);
		double nearest = distance - sqrt(xx + yy), wider = (double)SHADE_PI * (xx + yy) / (4.0 * sqrt(xx * yy));
		sent = irradiance_of(light, intensity * light_larger(wider, 1.0), distance);
		if (nearest > 0.0)
			sent = light_smaller(sent, intensity / (nearest * nearest));
	}
	return sent;
}

/* Shortens the sphere to what of it lies in the cone, whose far end is `end` metres from the apex. */
static void bounds_shorten(stilb_light_bounds *bounds, const double apex[3], const double axis[3], double cosine,
                           double end)
{
	bool narrow = cosine > COSINE_45;
	double along = narrow ? end / (2.0 * cosine) : end * cosine;
	double radius = narrow ? along : end * sqrt(1.0 - cosine * cosine);
	double center[3];
	for (int i = 0; i < 3; i++)
		center[i] = apex[i] + axis[i] * along;
	radius += radius * LIGHT_RELATIVE + (fabs(center[0]) + fabs(center[1]) + fabs(center[2])) * 0x1p-22;
	if (radius < (double)bounds->sphere.radius)
		bounds->sphere = (stilb_sphere){(float)center[0], (float)center[1], (float)center[2], (float)radius};
}

/* Adds the cone with this cosine of the half angle, as shade_light_at computes it, with room for rounding: a light that
 * is nearer than 0.1 mm shines everywhere. */
static void bounds_cone(stilb_light_bounds *bounds, const stilb_scene_light *light, double cosine, double reach)
{
	double length = sqrt(dot3(light->direction, light->direction)), pull;
	double apex[3], axis[3];
	cosine -= COSINE_GROWTH;
	if (cosine <= -1.0)
		return;
	pull = (1.01 * REACH_MIN + light_size(light->position) * LIGHT_RELATIVE) / sqrt(1.0 - cosine * cosine);
	for (int i = 0; i < 3; i++) {
		axis[i] = (double)light->direction[i] / length;
		apex[i] = (double)light->position[i] - axis[i] * pull;
		bounds->axis[i] = (float)axis[i];
		bounds->apex[i] = (float)apex[i];
	}
	bounds->cos_angle = (float)cosine;
	if (cosine > 0.0 && isfinite(reach))
		bounds_shorten(bounds, apex, axis, cosine, reach + pull);
}

/* The radius of the sphere around the light's centre, as stilb_light_bounds has it; *reach: with room for rounding. */
static float bounds_radius(const stilb_scene_light *light, double *reach)
{
	if (light->kind == STILB_SCENE_LIGHT_DIRECTIONAL)
		return brightest(light) > 0.0 ? INFINITY : -1.0f;
	*reach = light_smaller(*reach, light_reach(light, 0.0));
	if (!(*reach > 0.0))
		return -1.0f;
	*reach *= 1.0 + REACH_GROWTH;
	if (*reach <= REACH_MAX * 2.0)
		return (float)(*reach + light_size(light->position) * LIGHT_RELATIVE);
	*reach = (double)INFINITY;
	return INFINITY;
}

void light_bounds_within(const stilb_scene_light *light, double reach, stilb_light_bounds *bounds)
{
	float radius = bounds_radius(light, &reach);
	bounds->sphere = (stilb_sphere){light->position[0], light->position[1], light->position[2], radius};
	bounds->cos_angle = -1.0f;
	if (light->kind == STILB_SCENE_LIGHT_SPOT && radius >= 0.0f) {
		double length = sqrt(dot3(light->direction, light->direction)), cosine = (double)light->cos_outer;
		bounds_cone(bounds, light, light_smaller(cosine, cosine / length), reach);
	}
	if ((light->kind == STILB_SCENE_LIGHT_DISK || light->kind == STILB_SCENE_LIGHT_RECTANGLE) && radius >= 0.0f)
		bounds_cone(bounds, light, 0.0, reach);
}

stilb_light_bounds stilb_light_bounds_of(const stilb_scene_light *light)
{
	stilb_light_bounds bounds = {0};
	STILB_ASSERT(light);
	light_bounds_within(light, (double)INFINITY, &bounds);
	return bounds;
}
