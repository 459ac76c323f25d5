#include "numeric/numeric_albedo.h"

#include "base/base.h"
#include "numeric/numeric_quadrature.h"

#include <math.h>
#include <stdbool.h>

/* Panels of 16 points for half a turn of azimuth. The polar angle has one for each unit of t (numeric_albedo.h). */
#define PANELS_AROUND 2

typedef struct albedo {
	const shade_brdf_model *model;
	const shade_brdf_parameters *parameters;
	bool of_light; /* the fixed direction is the light's, else the view's */
	/* polar coordinates are those of the varying direction about the mirrored fixed one; else those of the half vector
	 * of the two about the normal */
	bool about_mirrored;
	stilb_vec3 fixed;             /* the fixed direction, z along the normal */
	double sine, cosine, azimuth; /* of the fixed direction */
	double alpha;
	/* of the polar angle that the azimuth is integrated at: its tan; with about_mirrored the tan of half of it */
	double tangent;
} albedo;

static const shade_frame frame = {{1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}, {0.0f, 0.0f, 1.0f}};

/* The integrand at the varying direction `other`: f(l, v) times its cosine. */
static double reflected(const albedo *a, const double other[3])
{
	stilb_vec3 moving = stilb_vec3_make((float)other[0], (float)other[1], (float)other[2]);
	if (!a->of_light)
		return (double)shade_brdf_cos(*a->model, *a->parameters, frame, moving, a->fixed)[0];
	return (double)shade_brdf_cos(*a->model, *a->parameters, frame, a->fixed, moving)[0] * other[2] / a->cosine;
}

static double over_directions(const double direction[3], const void *context)
{
	return reflected(context, direction);
}

/* The integrand with `other` in coordinates whose x axis is the azimuth of the fixed direction. */
static double reflected_turned(const albedo *a, const double other[3])
{
	double x = cos(a->azimuth), y = sin(a->azimuth);
	double turned[3] = {other[0] * x - other[1] * y, other[0] * y + other[1] * x, other[2]};
	return reflected(a, turned);
}

/* The integrand at the half vector of azimuth phi from the fixed direction. The varying direction is the fixed one
 * mirrored at it; d(direction) = 4 (fixed.h) dh. */
static double over_half_azimuth(double phi, const void *context)
{
	const albedo *a = context;
	double z = 1.0 / sqrt(1.0 + a->tangent * a->tangent), radius = a->tangent * z;
	double h[3] = {radius * cos(phi), radius * sin(phi), z};
	double fixed_h = a->sine * h[0] + a->cosine * h[2];
	double other[3] = {2.0 * fixed_h * h[0] - a->sine, 2.0 * fixed_h * h[1], 2.0 * fixed_h * h[2] - a->cosine};
	return reflected_turned(a, other) * 4.0 * fixed_h;
}

/* The integrand at azimuth phi about the mirrored direction; phi = 0 is towards the normal. The polar angle is twice
 * the angle whose tan is `tangent`, so a solid angle is 4 cos(half the polar angle) times that of halved directions. */
static double over_mirrored_azimuth(double phi, const void *context)
{
	const albedo *a = context;
	double z2 = 1.0 / (1.0 + a->tangent * a->tangent);
	double along = 2.0 * z2 - 1.0, across = 2.0 * a->tangent * z2;
	double other[3] = {across * cos(phi) * a->cosine - along * a->sine, across * sin(phi),
	                   across * cos(phi) * a->sine + along * a->cosine};
	return reflected_turned(a, other) * 4.0 * sqrt(z2);
}

/* The azimuth, radians in [0, pi], up to which the varying direction lies above the horizon. Where half vectors h vary,
 * that direction is the fixed one mirrored at h: its height 2 dot(fixed, h) h_z - fixed_z must be above 0. */
static double horizon(const albedo *a)
{
	double z2 = 1.0 / (1.0 + a->tangent * a->tangent), cotangent = a->cosine / a->sine;
	double lowest = a->about_mirrored ? -cotangent * (2.0 * z2 - 1.0) / (2.0 * a->tangent * z2)
	                                  : cotangent * (0.5 / z2 - 1.0) / a->tangent;
	return acos(fmin(1.0, fmax(-1.0, lowest)));
}

static double over_polar(double t, const void *context)
{
	albedo a = *(const albedo *)context;
	a.tangent = a.alpha * sinh(t);
	double end = a.sine > 0.0 ? horizon(&a) : M_PI;
	stilb_numeric_function *f = a.about_mirrored ? over_mirrored_azimuth : over_half_azimuth;
	double right = stilb_numeric_integrate(f, &a, 0.0, end, PANELS_AROUND);
	bool symmetric = a.model->kind != SHADE_BRDF_MICROFACET || a.model->ndf != SHADE_NDF_GGX_ANISOTROPIC;
	double left = symmetric ? right : stilb_numeric_integrate(f, &a, -end, 0.0, PANELS_AROUND);
	/* sin(theta) dtheta, where dtheta = cos^2(theta) d(tan(theta)) */
	double z2 = 1.0 / (1.0 + a.tangent * a.tangent);
	return (right + left) * a.tangent * z2 * sqrt(z2) * a.alpha * cosh(t);
}

/* Integral over the polar angle from low to high. */
static double between(const albedo *a, double low, double high)
{
	STILB_ASSERT(low >= 0.0 && low <= high && high <= M_PI / 2.0);
	double first = asinh(tan(low) / a->alpha), last = asinh(tan(high) / a->alpha);
	int panels = (int)ceil(last - first);
	return panels > 0 ? stilb_numeric_integrate(over_polar, a, first, last, panels) : 0.0;
}

/* Integral over all polar angles; polar: that of the fixed direction. Up to the angle `whole` the varying direction is
 * above the horizon at every azimuth, beyond `last` at none. Phong's lobes end a quarter turn from the mirrored
 * direction, which is the angle pi / 4, as half of theirs is counted. */
static double over_lobe(const albedo *a, double polar)
{
	double whole = M_PI / 4.0 - polar / 2.0, last = M_PI / 4.0 + (a->about_mirrored ? 0.0 : polar / 2.0);
	return between(a, 0.0, whole) + between(a, whole, last);
}

static double integrate(const shade_brdf_model *model, const shade_brdf_parameters *parameters,
                        stilb_numeric_angles fixed, bool of_light)
{
	STILB_ASSERT(model->kind >= 0 && model->kind < SHADE_BRDF_COUNT);
	STILB_ASSERT(parameters->roughness >= 0.0f && parameters->roughness <= 1.0f);
	STILB_ASSERT(fixed.polar >= 0.0 && fixed.polar < M_PI / 2.0);
	double sine = sin(fixed.polar), cosine = cos(fixed.polar);
	albedo a = {
		.model = model,
		.parameters = parameters,
		.of_light = of_light,
		.about_mirrored = model->kind == SHADE_BRDF_PHONG || model->kind == SHADE_BRDF_PHONG_MODIFIED,
		.fixed = stilb_vec3_make((float)(sine * cos(fixed.azimuth)), (float)(sine * sin(fixed.azimuth)), (float)cosine),
		.sine = sine,
		.cosine = cosine,
		.azimuth = fixed.azimuth,
		.alpha = (double)shade_alpha_from_roughness(parameters->roughness),
	};
	if (model->kind != SHADE_BRDF_LAMBERT && model->kind != SHADE_BRDF_WRAPPED)
		return over_lobe(&a, fixed.polar);
	/* The wrapped model is also lit from below its horizon, down to n.l = -wrap. */
	double wrap = model->kind == SHADE_BRDF_WRAPPED && !of_light ? (double)parameters->wrap : 0.0;
	return stilb_numeric_integrate_sphere(over_directions, &a, -wrap, 1.0, 1);
}

double stilb_numeric_albedo_of_view(const shade_brdf_model *model, const shade_brdf_parameters *parameters,
                                    stilb_numeric_angles view)
{
	return integrate(model, parameters, view, false);
}

double stilb_numeric_albedo_of_light(const shade_brdf_model *model, const shade_brdf_parameters *parameters,
                                     stilb_numeric_angles light)
{
	return integrate(model, parameters, light, true);
}
