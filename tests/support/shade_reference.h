/*
 * shade_reference: the reflection formulas of the sources written anew in double, in the order and form in which they
 * are printed: what shade_phong.h, shade_specular.h and shade_brdf.h are held against.
 */
#ifndef SHADE_REFERENCE_H
#define SHADE_REFERENCE_H

#include "shading/shade_brdf.h"

#include <math.h>

/* ---- Karis: the terms, from angles ------------------------------------------------------------------------------ */

/* D with c = n.m, as printed; sin2 = 1 - c^2 is given where the text subtracts. */
static inline double reference_blinn_d(double sin2, double a)
{
	return exp((1.0 / (a * a) - 1.0) * log1p(-sin2)) / (M_PI * a * a);
}

static inline double reference_beckmann_d(double sin2, double a)
{
	double c2 = 1.0 - sin2;
	return exp(-sin2 / (a * a * c2)) / (M_PI * a * a * c2 * c2);
}

static inline double reference_ggx_d(double sin2, double a)
{
	double bracket = sin2 * (a * a - 1.0) - a * a; /* -((1 - sin2) (a^2 - 1) + 1) */
	return a * a / (M_PI * bracket * bracket);
}

static inline double reference_ggx_anisotropic_d(double x, double y, double ax, double ay)
{
	double bracket = x * x / (ax * ax) + y * y / (ay * ay) + 1.0 - x * x - y * y;
	return 1.0 / (M_PI * ax * ay * bracket * bracket);
}

static inline double reference_beckmann_g1(double c, double a)
{
	double t = c / (a * sqrt(1.0 - c * c));
	return t < 1.6 ? (3.535 * t + 2.181 * t * t) / (1.0 + 2.276 * t + 2.577 * t * t) : 1.0;
}

static inline double reference_ggx_g1(double c, double a)
{
	return 2.0 * c / (c + sqrt(a * a + (1.0 - a * a) * c * c));
}

static inline double reference_schlick_g1(double c, double k)
{
	return c / (c * (1.0 - k) + k);
}

/* G by number, as printed. */
static inline double reference_g_of(int g, double nl, double nv, double nh, double vh, double al, double av)
{
	double k = sqrt(2.0 / M_PI);
	switch (g) {
	case SHADE_G_IMPLICIT:
		return nl * nv;
	case SHADE_G_NEUMANN:
		return nl * nv / fmax(nl, nv);
	case SHADE_G_COOK_TORRANCE:
		return fmin(1.0, fmin(2.0 * nh * nv / vh, 2.0 * nh * nl / vh));
	case SHADE_G_KELEMEN:
		return nl * nv / (vh * vh);
	case SHADE_G_SMITH_BECKMANN:
		return reference_beckmann_g1(nl, al) * reference_beckmann_g1(nv, av);
	case SHADE_G_SMITH_GGX:
		return reference_ggx_g1(nl, al) * reference_ggx_g1(nv, av);
	case SHADE_G_SCHLICK_BECKMANN:
		return reference_schlick_g1(nl, k * al) * reference_schlick_g1(nv, k * av);
	default:
		return reference_schlick_g1(nl, al / 2.0) * reference_schlick_g1(nv, av / 2.0);
	}
}

static inline double reference_schlick_f(double f0, double c)
{
	return f0 + (1.0 - f0) * pow(1.0 - c, 5.0);
}

static inline double reference_cook_torrance_f(double f0, double c)
{
	double eta = (1.0 + sqrt(f0)) / (1.0 - sqrt(f0)), g = sqrt(eta * eta + c * c - 1.0);
	double across = (g - c) / (g + c), along = ((g + c) * c - 1.0) / ((g - c) * c + 1.0);
	return 0.5 * across * across * (1.0 + along * along);
}

static inline double reference_f_of(int f, double f0, double vh)
{
	return f == SHADE_F_NONE      ? f0
	       : f == SHADE_F_SCHLICK ? reference_schlick_f(f0, vh)
	                              : reference_cook_torrance_f(f0, vh);
}

/* ---- whole BRDFs times n.l, from vectors ------------------------------------------------------------------------ */

typedef struct reference_vector {
	double x, y, z;
} reference_vector;

static inline reference_vector reference_vector_of(stilb_vec3 v)
{
	return (reference_vector){(double)v[0], (double)v[1], (double)v[2]};
}

static inline double reference_dot(reference_vector a, reference_vector b)
{
	return a.x * b.x + a.y * b.y + a.z * b.z;
}

/* a s + b t, made unit. */
static inline reference_vector reference_unit(reference_vector a, double s, reference_vector b, double t)
{
	reference_vector sum = {a.x * s + b.x * t, a.y * s + b.y * t, a.z * s + b.z * t};
	double length = sqrt(reference_dot(sum, sum));
	return (reference_vector){sum.x / length, sum.y / length, sum.z / length};
}

/* Width of an anisotropic D along x: alpha_x^2 cos^2(phi) + alpha_y^2 sin^2(phi), phi the azimuth of x. */
static inline double reference_alpha_along(reference_vector x, reference_vector t, reference_vector b, double ax,
                                           double ay)
{
	double phi = atan2(reference_dot(b, x), reference_dot(t, x));
	return sqrt(ax * ax * cos(phi) * cos(phi) + ay * ay * sin(phi) * sin(phi));
}

/* D G F / (4 n.v). */
static inline double reference_microfacet(shade_brdf_model model, double f0, double alpha, double anisotropy,
                                          const shade_frame *frame, reference_vector l, reference_vector v)
{
	reference_vector n = reference_vector_of(frame->n), t = reference_vector_of(frame->t);
	reference_vector b = reference_vector_of(frame->b), h = reference_unit(l, 1.0, v, 1.0);
	double nl = reference_dot(n, l), nv = reference_dot(n, v), nh = reference_dot(n, h), vh = reference_dot(v, h);
	double sin2 = 1.0 - nh * nh, al = alpha, av = alpha, d;
	if (model.ndf == SHADE_NDF_GGX_ANISOTROPIC) {
		double ax = fmax(alpha * (1.0 + anisotropy), 1e-3), ay = fmax(alpha * (1.0 - anisotropy), 1e-3);
		al = reference_alpha_along(l, t, b, ax, ay);
		av = reference_alpha_along(v, t, b, ax, ay);
		d = reference_ggx_anisotropic_d(reference_dot(t, h), reference_dot(b, h), ax, ay);
	} else {
		d = model.ndf == SHADE_NDF_BLINN      ? reference_blinn_d(sin2, alpha)
		    : model.ndf == SHADE_NDF_BECKMANN ? reference_beckmann_d(sin2, alpha)
		                                      : reference_ggx_d(sin2, alpha);
	}
	return d * reference_g_of(model.g, nl, nv, nh, vh, al, av) * reference_f_of(model.f, f0, vh) / (4.0 * nv);
}

/* One channel of shade_brdf_cos. */
static inline double reference_brdf_cos(shade_brdf_model model, shade_brdf_parameters p, int channel,
                                        const shade_frame *frame, stilb_vec3 to_light, stilb_vec3 to_eye)
{
	reference_vector n = reference_vector_of(frame->n), l = reference_vector_of(to_light);
	reference_vector v = reference_vector_of(to_eye);
	double nl = reference_dot(n, l), nv = reference_dot(n, v), k = (double)p.specular[channel], w = (double)p.wrap;
	double alpha = fmax((double)p.roughness * (double)p.roughness, 1e-3), power = 2.0 / (alpha * alpha) - 2.0;
	if (nv <= 0.0)
		return 0.0;
	if (model.kind == SHADE_BRDF_WRAPPED)
		return k / M_PI * fmax((nl + w) / ((1.0 + w) * (1.0 + w)), 0.0);
	if (nl <= 0.0)
		return 0.0;
	double nh = reference_dot(n, reference_unit(l, 1.0, v, 1.0)), lh = sqrt(0.5 + 0.5 * reference_dot(l, v));
	double rl = fmax(reference_dot(l, reference_unit(n, 2.0 * nv, v, -1.0)), 0.0), half = exp2(-power / 2.0);
	switch (model.kind) {
	case SHADE_BRDF_LAMBERT:
		return k / M_PI * nl;
	case SHADE_BRDF_PHONG:
		return k * (power / 4.0 + 1.0) / (2.0 * M_PI) * pow(rl, power / 4.0);
	case SHADE_BRDF_PHONG_MODIFIED:
		return k * (power / 4.0 + 2.0) / (2.0 * M_PI) * pow(rl, power / 4.0) * nl;
	case SHADE_BRDF_BLINN_PHONG:
		return k * (power + 2.0) / (4.0 * M_PI * (2.0 - half)) * pow(nh, power);
	case SHADE_BRDF_BLINN_PHONG_MODIFIED:
		return k * (power + 2.0) * (power + 4.0) / (8.0 * M_PI * (half + power)) * pow(nh, power) * nl;
	case SHADE_BRDF_MINIMALIST:
		return k * (power + 1.0) * pow(nh, power) / (8.0 * M_PI * lh * lh * lh) * nl;
	default:
		return reference_microfacet(model, k, alpha, (double)p.anisotropy, frame, l, v);
	}
}

#endif
