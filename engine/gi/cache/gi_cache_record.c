#include "gi/cache/gi_cache_record.h"

#include "shading/shade_constants.h"

/* ---- the Hessian's ellipse --------------------------------------------------------------------------------------- */

/* A rotation of the two axes of the tangent plane, and the second derivatives of irradiance along the new axes. */
typedef struct tangent_axes {
	float cosine, sine;
	float curvature[2];
} tangent_axes;

/* The rotation that makes the symmetric 2 x 2 matrix {xx, xy, yy} diagonal. */
static tangent_axes principal_axes(const float matrix[3])
{
	float mean = 0.5f * (matrix[0] + matrix[2]);
	float half = 0.5f * (matrix[0] - matrix[2]);
	float off = matrix[1];
	float spread = sqrtf(half * half + off * off);
	float angle = 0.5f * atan2f(off, half);
	return (tangent_axes){.cosine = cosf(angle), .sine = sinf(angle), .curvature = {mean + spread, mean - spread}};
}

/* Rotates the tangent t and the bitangent b of the frame, and the gradients that are given along them. */
static void turn_axes(const tangent_axes *axes, shade_frame *frame, gi_cache_gathered *gathered)
{
	float c = axes->cosine, s = axes->sine;
	stilb_vec3 t = frame->t, b = frame->b;
	frame->t = t * c + b * s;
	frame->b = b * c - t * s;
	stilb_vec3 *pairs[2] = {gathered->translation, gathered->rotation};
	for (int i = 0; i < 2; i++) {
		stilb_vec3 x = pairs[i][0], y = pairs[i][1];
		pairs[i][0] = x * c + y * s;
		pairs[i][1] = y * c - x * s;
	}
}

/* The radius at which the error of a linear extrapolation, integrated over the record's ellipse, reaches the
 * tolerance: limits->error times the irradiance over a square of side limits->unit.
 * Source: Schwarzhaupt, Jensen, Jarosz (2012), whose tolerance is an absolute number. */
static float hessian_radius(float curvature, float irradiance, const gi_cache_limits *limits)
{
	float tolerated = limits->error * irradiance * limits->unit * limits->unit;
	return sqrtf(sqrtf(4.0f * SHADE_INV_PI * tolerated / fabsf(curvature)));
}

/* ---- radii ------------------------------------------------------------------------------------------------------- */

/* The radius within its limits: at most reach and limits->longest, at least limits->shortest. fminf and fmaxf ignore
 * NaN: a radius of 0 / 0, as found where no light arrives, becomes the smaller of reach and longest. */
static float clamp_radius(float radius, float reach, const gi_cache_limits *limits)
{
	return fmaxf(fminf(fminf(radius, reach), limits->longest), limits->shortest);
}

/* The farthest that a radius may be, except with the rule HARMONIC: the distance at which extrapolation along the
 * gradient would have changed the irradiance by 100 %, or the harmonic mean distance to the surfaces that the record
 * sees, whichever is shorter. */
static float farthest_reach(const gi_cache_gathered *gathered)
{
	float t = gi_cache_mean(gathered->translation[0]);
	float b = gi_cache_mean(gathered->translation[1]);
	float level = gi_cache_mean(gathered->irradiance) / sqrtf(t * t + b * b);
	return fminf(level, 1.0f / gathered->nearness);
}

static void gradients_drop(gi_cache_gathered *gathered)
{
	for (int i = 0; i < 2; i++)
		gathered->rotation[i] = gathered->translation[i] = (stilb_vec3){0};
}

/* The most that the second derivative may change the irradiance by within the record's radii, as a share of it: that of
 * few rays is noisy. */
#define BEND_MOST 0.25f

/* The factor on the square of the distance along an axis in gi_cache_record_irradiance. */
static float bend_of(float curvature, float irradiance, float radius)
{
	float most = BEND_MOST / (radius * radius);
	return fminf(fmaxf(0.5f * curvature / irradiance, -most), most); /* of 0 / 0 a number that is multiplied by 0 */
}

/* Shortens the gradient of each colour channel whose irradiance, extrapolated along it, would fall by more than the
 * share `most` of it within the record's radii. */
static void gradients_limit(gi_cache_gathered *gathered, const float radius[2], float most)
{
	for (int i = 0; i < 3; i++) {
		float t = gathered->translation[0][i] * radius[0];
		float b = gathered->translation[1][i] * radius[1];
		float change = sqrtf(t * t + b * b);
		float limit = most * gathered->irradiance[i];
		float kept = change > limit ? limit / change : 1.0f;
		gathered->translation[0][i] *= kept;
		gathered->translation[1][i] *= kept;
	}
}

static stilb_vec4 row(stilb_vec3 v, float last)
{
	return (stilb_vec4){v[0], v[1], v[2], last};
}

gi_cache_record gi_cache_record_make(const gi_cache_gathered *gathered, shade_frame frame, stilb_vec3 position,
                                     const gi_cache_limits *limits)
{
	STILB_ASSERT(limits->error > 0.0f && limits->longest > 0.0f);
	STILB_ASSERT(limits->shortest >= 0.0f && limits->shortest <= limits->longest);
	STILB_ASSERT(gathered->nearness >= 0.0f);
	gi_cache_gathered turned = *gathered;
	float radius[2], bend[2] = {0.0f, 0.0f};
	tangent_axes axes = {0};
	if (limits->radius == STILB_GI_CACHE_HESSIAN) {
		axes = principal_axes(gathered->hessian);
		turn_axes(&axes, &frame, &turned);
		for (int i = 0; i < 2; i++)
			radius[i] = hessian_radius(axes.curvature[i], gi_cache_mean(gathered->irradiance), limits);
	} else {
		radius[0] = radius[1] = limits->error / gathered->nearness;
	}
	float reach = limits->radius == STILB_GI_CACHE_HARMONIC ? INFINITY : farthest_reach(gathered);
	for (int i = 0; i < 2; i++)
		radius[i] = clamp_radius(radius[i], reach, limits);

	bool bends = limits->radius == STILB_GI_CACHE_HESSIAN && limits->gradients;
	for (int i = 0; i < 2 && bends; i++)
		bend[i] = bend_of(axes.curvature[i], gi_cache_mean(gathered->irradiance), radius[i]);
	if (!limits->gradients)
		gradients_drop(&turned);
	float shorter = fminf(radius[0], radius[1]);
	gradients_limit(&turned, radius, bends ? 1.0f - BEND_MOST : 1.0f);
	return (gi_cache_record){
		.position = row(position, 1.0f / radius[0]),
		.normal = row(frame.n, 1.0f / radius[1]),
		.tangent = row(frame.t, 1.0f / shorter),
		.irradiance = row(turned.irradiance, 1.0f / fmaxf(radius[0], radius[1])),
		.translation = {row(turned.translation[0], bend[0]), row(turned.translation[1], bend[1])},
		.rotation = {row(turned.rotation[0], 0.0f), row(turned.rotation[1], 0.0f)},
	};
}

void gi_cache_record_limit(gi_cache_record *record, float radius)
{
	STILB_ASSERT(radius > 0.0f);
	float inverse = 1.0f / radius;
	record->position[3] = fmaxf(record->position[3], inverse);
	record->normal[3] = fmaxf(record->normal[3], inverse);
	record->tangent[3] = fmaxf(record->tangent[3], inverse);
	record->irradiance[3] = fmaxf(record->irradiance[3], inverse);
}
