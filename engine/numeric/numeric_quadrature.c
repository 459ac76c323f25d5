#include "numeric/numeric_quadrature.h"

#include "base/base.h"

#include <math.h>

/* Nodes and weights of the Gauss-Legendre rule of 16 points on [-1, 1]. It is symmetric: the positive half is here.
 * Source: Abramowitz and Stegun, "Handbook of Mathematical Functions" (1964), table 25.4. */
#define HALF_POINTS 8
static const double nodes[HALF_POINTS] = {
	0.095012509837637440185, 0.281603550779258913230, 0.458016777657227386342, 0.617876244402643748447,
	0.755404408355003033895, 0.865631202387831743880, 0.944575023073232576078, 0.989400934991649932596,
};
static const double weights[HALF_POINTS] = {
	0.189450610455068496285, 0.182603415044923588867, 0.169156519395002538189, 0.149595988816576732081,
	0.124628971255533872052, 0.095158511682492784810, 0.062253523938647892863, 0.027152459411754094852,
};

double stilb_numeric_integrate(stilb_numeric_function *f, const void *context, double low, double high, int panels)
{
	STILB_ASSERT(f && panels >= 1);
	STILB_ASSERT(isfinite(low) && isfinite(high));
	double half = 0.5 * (high - low) / panels, sum = 0.0;
	for (int panel = 0; panel < panels; panel++) {
		double middle = low + (2 * panel + 1) * half;
		for (int i = 0; i < HALF_POINTS; i++)
			sum += weights[i] * (f(middle - half * nodes[i], context) + f(middle + half * nodes[i], context));
	}
	return sum * half;
}

void stilb_numeric_points(double low, double high, int panels, stilb_numeric_point *points)
{
	STILB_ASSERT(points && panels >= 1);
	STILB_ASSERT(isfinite(low) && isfinite(high));
	double half = 0.5 * (high - low) / panels;
	for (int panel = 0; panel < panels; panel++) {
		double middle = low + (2 * panel + 1) * half;
		for (int i = 0; i < 2 * HALF_POINTS; i++) {
			int k = i < HALF_POINTS ? HALF_POINTS - 1 - i : i - HALF_POINTS;
			double x = i < HALF_POINTS ? middle - half * nodes[k] : middle + half * nodes[k];
			*points++ = (stilb_numeric_point){x, half * weights[k]};
		}
	}
}

typedef struct ring {
	stilb_numeric_direction_function *f;
	const void *context;
	int points;
} ring;

/* Integral over the azimuth at one height z. */
static double around(double z, const void *context)
{
	STILB_ASSERT(z >= -1.0 && z <= 1.0);
	const ring *r = context;
	double radius = sqrt(fmax(0.0, 1.0 - z * z)), sum = 0.0;
	for (int i = 0; i < r->points; i++) {
		double phi = (i + 0.5) / r->points * 2.0 * M_PI;
		double direction[3] = {radius * cos(phi), radius * sin(phi), z};
		sum += r->f(direction, r->context);
	}
	return sum * 2.0 * M_PI / r->points;
}

double stilb_numeric_integrate_sphere(stilb_numeric_direction_function *f, const void *context, double low, double high,
                                      int panels)
{
	STILB_ASSERT(low >= -1.0 && low <= high && high <= 1.0);
	ring r = {f, context, 32 * panels};
	return stilb_numeric_integrate(around, &r, low, high, panels);
}

#define LOBE_POINTS 64

typedef struct lobe {
	ring ring;
	double width;
} lobe;

static double across(double t, const void *context)
{
	const lobe *l = context;
	double tangent = l->width * sinh(t), cosine2 = 1.0 / (1.0 + tangent * tangent);
	double slope = l->width * cosh(t) * cosine2; /* derivative of theta / 2 by t */
	return around(2.0 * cosine2 - 1.0, &l->ring) * 4.0 * tangent * cosine2 * slope;
}

double stilb_numeric_integrate_lobe(stilb_numeric_direction_function *f, const void *context, double width)
{
	STILB_ASSERT(f && width > 0.0 && width <= 1.0);
	lobe l = {{f, context, LOBE_POINTS}, width};
	double horizon = asinh(1.0 / width);
	double above = stilb_numeric_integrate(across, &l, 0.0, horizon, (int)ceil(2.0 * horizon));
	return above + stilb_numeric_integrate(around, &l.ring, -1.0, 0.0, 4);
}
