#include "numeric/numeric_dfg.h"

#include "base/base.h"
#include "numeric/numeric_quadrature.h"
#include "shading/shade_environment.h"

#include <math.h>

/* The half vector's polar angle theta is given by tan(theta) = alpha sinh(t). Panels are 3 wide in t; what is beyond
 * DFG_LAST weighs exp(-2 DFG_LAST). */
#define DFG_LAST 12.0
#define DFG_PANELS 5  /* at most: 4 fill 0 to DFG_LAST, and rounding may ask for one more */
#define DFG_POINTS 16 /* of a panel */

typedef struct dfg_lobe {
	double sine, cosine; /* of the view direction */
	double alpha2, view; /* alpha squared; n.v + sqrt(alpha^2 + (1 - alpha^2) (n.v)^2), Smith's factor of v */
} dfg_lobe;

/* Smith's factor of a direction (shade_v_smith_ggx is 1 / the product of both). */
static double dfg_smith(double cosine, double alpha2)
{
	return cosine + sqrt(alpha2 + (1.0 - alpha2) * cosine * cosine);
}

/* Half a turn of azimuth at the polar angle of this tangent, as far as the light is above the horizon. The integrand is
 * V n.l 4 v.h, split by Fresnel's share. */
static stilb_numeric_dfg dfg_around(const dfg_lobe *lobe, double tangent)
{
	double z = 1.0 / sqrt(1.0 + tangent * tangent), end = M_PI;
	if (lobe->sine > 0.0) {
		double lowest = lobe->cosine / lobe->sine * (0.5 / (z * z) - 1.0) / tangent;
		end = acos(fmin(1.0, fmax(-1.0, lowest)));
	}
	stilb_numeric_point points[DFG_POINTS];
	stilb_numeric_points(0.0, end, 1, points);
	stilb_numeric_dfg sum = {0.0, 0.0};
	for (int i = 0; i < DFG_POINTS; i++) {
		double v_dot_h = lobe->sine * tangent * z * cos(points[i].x) + lobe->cosine * z;
		double n_dot_l = fmax(2.0 * v_dot_h * z - lobe->cosine, 0.0), m = 1.0 - v_dot_h;
		double visible = 4.0 * v_dot_h * n_dot_l / (lobe->view * dfg_smith(n_dot_l, lobe->alpha2));
		double share = m * m * m * m * m;
		sum.a += points[i].weight * visible * (1.0 - share);
		sum.b += points[i].weight * visible * share;
	}
	return sum;
}

/* Adds the polar angles from low to high. D sin(theta) dtheta is sinh(t) / (pi cos(theta) cosh^3(t)) dt. */
static void dfg_add(const dfg_lobe *lobe, double low, double high, stilb_numeric_dfg *sum)
{
	double alpha = sqrt(lobe->alpha2);
	double first = asinh(tan(low) / alpha), last = fmin(asinh(tan(high) / alpha), DFG_LAST);
	if (!(last > first))
		return;
	stilb_numeric_point points[DFG_PANELS * DFG_POINTS];
	int panels = (int)ceil((last - first) / 3.0);
	STILB_ASSERT(panels <= DFG_PANELS);
	stilb_numeric_points(first, last, panels, points);
	for (int i = 0; i < panels * DFG_POINTS; i++) {
		double tangent = alpha * sinh(points[i].x), c = cosh(points[i].x);
		double weight = points[i].weight * sinh(points[i].x) * sqrt(1.0 + tangent * tangent) / (M_PI * c * c * c);
		stilb_numeric_dfg ring = dfg_around(lobe, tangent);
		sum->a += 2.0 * weight * ring.a; /* both halves of the turn */
		sum->b += 2.0 * weight * ring.b;
	}
}

stilb_numeric_dfg stilb_numeric_dfg_of(double n_dot_v, double roughness)
{
	STILB_ASSERT(n_dot_v >= 0.0 && n_dot_v <= 1.0 && roughness >= 0.0 && roughness <= 1.0);
	double alpha = fmax(roughness * roughness, (double)SHADE_ALPHA_MIN), polar = acos(n_dot_v);
	dfg_lobe lobe = {.sine = sqrt(1.0 - n_dot_v * n_dot_v),
	                 .cosine = n_dot_v,
	                 .alpha2 = alpha * alpha,
	                 .view = dfg_smith(n_dot_v, alpha * alpha)};
	/* Up to the first angle the light is above the horizon at every azimuth, beyond the second at none. */
	double whole = M_PI / 4.0 - polar / 2.0, last = fmin(M_PI / 4.0 + polar / 2.0, M_PI / 2.0 - 1e-12);
	stilb_numeric_dfg sum = {0.0, 0.0};
	dfg_add(&lobe, 0.0, fmax(whole, 0.0), &sum);
	dfg_add(&lobe, fmax(whole, 0.0), last, &sum);
	return sum;
}

void stilb_numeric_dfg_rows(float *table, uint32_t side, uint32_t begin, uint32_t end)
{
	STILB_ASSERT(table && side >= 2 && begin <= end && end <= side);
	for (size_t i = (size_t)begin * side; i < (size_t)end * side; i++) {
		size_t row = i / side;
		stilb_vec2 place = {(float)(i % side) / (float)(side - 1), (float)row / (float)(side - 1)};
		stilb_vec2 at = shade_dfg_from_place(place);
		stilb_numeric_dfg value = stilb_numeric_dfg_of(fmin((double)at[0], 1.0), fmin((double)at[1], 1.0));
		table[2 * i] = (float)value.a;
		table[2 * i + 1] = (float)value.b;
	}
}
