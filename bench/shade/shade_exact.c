/* The reflectance formulas of the suite `shade` in double, as published: h, the half vector of the directions to light
 * (l) and viewer (v), is normalized, cosines are dot products, no term is computed once for several uses. */
#include "bench/shade/shade_run.h"

#include <math.h>

typedef struct directions {
	double n[3], l[3], v[3], h[3];
} directions;

static double dot(const double a[3], const double b[3])
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void unit(double a[3])
{
	double scale = 1.0 / sqrt(dot(a, a));
	for (int c = 0; c < 3; c++)
		a[c] *= scale;
}

/* The point's directions in double. n, l and v are not normalized again, since the exact formulas must get the same
 * input as the implementations that are compared with them. */
static directions directions_of(const shade_run_point *p)
{
	directions d;
	for (int c = 0; c < 3; c++) {
		d.n[c] = (double)p->n[c];
		d.l[c] = (double)p->l[c];
		d.v[c] = (double)p->v[c];
	}
	unit(d.n);
	unit(d.l);
	unit(d.v);
	for (int c = 0; c < 3; c++)
		d.h[c] = d.l[c] + d.v[c];
	unit(d.h);
	return d;
}

static double alpha_of(const shade_run_point *p)
{
	return fmax((double)p->roughness * (double)p->roughness, (double)SHADE_RUN_ALPHA_MIN);
}

static double exponent_of(const shade_run_point *p)
{
	return 2.0 / pow(alpha_of(p), 2.0) - 2.0;
}

static void scaled(const shade_run_point *p, double scale, double result[3])
{
	for (int c = 0; c < 3; c++)
		result[c] = (double)p->f0[c] * scale;
}

void shade_exact_wrapped(const shade_run_point *p, double result[3])
{
	directions d = directions_of(p);
	double w = (double)SHADE_RUN_WRAP;
	scaled(p, fmax(dot(d.n, d.l) + w, 0.0) / ((1.0 + w) * (1.0 + w)) / M_PI, result);
}

void shade_exact_phong_modified(const shade_run_point *p, double result[3])
{
	directions d = directions_of(p);
	double n = exponent_of(p) / 4.0, r[3];
	for (int c = 0; c < 3; c++)
		r[c] = 2.0 * dot(d.n, d.l) * d.n[c] - d.l[c];
	scaled(p, (n + 2.0) / (2.0 * M_PI) * pow(fmax(dot(r, d.v), 0.0), n) * dot(d.n, d.l), result);
}

void shade_exact_blinn_phong_modified(const shade_run_point *p, double result[3])
{
	directions d = directions_of(p);
	double n = exponent_of(p), factor = (n + 2.0) * (n + 4.0) / (8.0 * M_PI * (exp2(-n / 2.0) + n));
	scaled(p, factor * pow(dot(d.n, d.h), n) * dot(d.n, d.l), result);
}

void shade_exact_minimalist(const shade_run_point *p, double result[3])
{
	directions d = directions_of(p);
	double n = exponent_of(p);
	scaled(p, (n + 1.0) * pow(dot(d.n, d.h), n) / (8.0 * M_PI * pow(dot(d.l, d.h), 3.0)) * dot(d.n, d.l), result);
}

void shade_exact_ggx(const shade_run_point *p, double result[3])
{
	directions d = directions_of(p);
	double a2 = pow(alpha_of(p), 2.0), n_h = dot(d.n, d.h), n_l = dot(d.n, d.l), n_v = dot(d.n, d.v);
	double distribution = a2 / (M_PI * pow(n_h * n_h * (a2 - 1.0) + 1.0, 2.0));
	double g_l = 2.0 * n_l / (n_l + sqrt(a2 + (1.0 - a2) * n_l * n_l));
	double g_v = 2.0 * n_v / (n_v + sqrt(a2 + (1.0 - a2) * n_v * n_v));
	for (int c = 0; c < 3; c++) {
		double f0 = (double)p->f0[c], fresnel = f0 + (1.0 - f0) * pow(1.0 - dot(d.v, d.h), 5.0);
		result[c] = distribution * fresnel * g_l * g_v / (4.0 * n_l * n_v) * n_l;
	}
}

void shade_exact_cook_torrance(const shade_run_point *p, double result[3])
{
	directions d = directions_of(p);
	double a2 = pow(alpha_of(p), 2.0), n_h = dot(d.n, d.h), n_l = dot(d.n, d.l), n_v = dot(d.n, d.v), c = dot(d.v, d.h);
	double distribution = exp((n_h * n_h - 1.0) / (a2 * n_h * n_h)) / (M_PI * a2 * pow(n_h, 4.0));
	double shadowing = fmin(1.0, fmin(2.0 * n_h * n_v / c, 2.0 * n_h * n_l / c));
	for (int i = 0; i < 3; i++) {
		double eta = (1.0 + sqrt((double)p->f0[i])) / (1.0 - sqrt((double)p->f0[i])), g = sqrt(eta * eta + c * c - 1.0);
		double fresnel =
			0.5 * pow((g - c) / (g + c), 2.0) * (1.0 + pow(((g + c) * c - 1.0) / ((g - c) * c + 1.0), 2.0));
		result[i] = distribution * fresnel * shadowing / (4.0 * n_l * n_v) * n_l;
	}
}
