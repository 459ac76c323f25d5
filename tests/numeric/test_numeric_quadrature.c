/* Numerical integration, which the tests of the shading formulas rest on, against closed forms; and the albedo in the
 * coordinates of numeric_albedo.h against the same integral over plain directions. */
#include "support/shade_proof.h"

#include "numeric/numeric_albedo.h"
#include "numeric/numeric_quadrature.h"

static double power_of(double x, const void *context)
{
	return pow(x, *(const int *)context);
}

/* The Gauss-Legendre rule of 16 points is exact up to x^31, and not for x^32. */
static void gauss_is_exact_for_polynomials(void **state)
{
	(void)state;
	for (int degree = 0; degree <= 32; degree++) {
		double want = (pow(2.0, degree + 1) - pow(-1.0, degree + 1)) / (degree + 1);
		double error = fabs(stilb_numeric_integrate(power_of, &degree, -1.0, 2.0, 1) / want - 1.0);
		assert_true(degree == 32 ? error > 1e-13 : error < 1e-14);
		SHADE_PROOF_NEAR(stilb_numeric_integrate(power_of, &degree, -1.0, 2.0, 3), want, 1e-13, 0.0);
	}
}

/* The rule's points, summed by hand, give its integral; they rise from one end to the other. */
static void points_are_those_of_the_rule(void **state)
{
	(void)state;
	int degree = 31;
	stilb_numeric_point points[48];
	stilb_numeric_points(-1.0, 2.0, 3, points);
	double sum = 0.0, length = 0.0;
	for (int i = 0; i < 48; i++) {
		assert_true(points[i].x > (i > 0 ? points[i - 1].x : -1.0) && points[i].x < 2.0);
		sum += points[i].weight * power_of(points[i].x, &degree);
		length += points[i].weight;
	}
	SHADE_PROOF_NEAR(sum, stilb_numeric_integrate(power_of, &degree, -1.0, 2.0, 3), 1e-13, 0.0);
	SHADE_PROOF_NEAR(length, 3.0, 1e-14, 0.0);
}

/* x^2 y^4 z^2 */
static double monomial(const double w[3], const void *context)
{
	(void)context;
	return w[0] * w[0] * pow(w[1], 4.0) * w[2] * w[2];
}

static double odd(const double w[3], const void *context)
{
	(void)context;
	return w[0] + w[1] * w[2] + w[2];
}

/* Source of the closed form: Folland, "How to Integrate a Polynomial over a Sphere" (2001). */
static void sphere_is_exact_for_polynomials(void **state)
{
	(void)state;
	double want = 2.0 * tgamma(1.5) * tgamma(2.5) * tgamma(1.5) / tgamma(5.5);
	SHADE_PROOF_NEAR(stilb_numeric_integrate_sphere(monomial, NULL, -1.0, 1.0, 1), want, 1e-13, 0.0);
	SHADE_PROOF_NEAR(stilb_numeric_integrate_sphere(monomial, NULL, 0.0, 1.0, 1), want / 2.0, 1e-13, 0.0);
	SHADE_PROOF_NEAR(stilb_numeric_integrate_sphere(odd, NULL, -1.0, 1.0, 1), 0.0, 0.0, 1e-13);
	SHADE_PROOF_NEAR(stilb_numeric_integrate_sphere(odd, NULL, 0.0, 1.0, 1), M_PI, 1e-13, 0.0);
	SHADE_PROOF_NEAR(stilb_numeric_integrate_lobe(monomial, NULL, 0.3), want, 1e-9, 0.0);
}

/* exp(-k (1 - z)), 1 - z = (x^2 + y^2) / (1 + z) so that it is exact near the pole. */
static double lobe(const double w[3], const void *context)
{
	double below = w[2] > 0.0 ? (w[0] * w[0] + w[1] * w[1]) / (1.0 + w[2]) : 1.0 - w[2];
	return exp(-*(const double *)context * below);
}

/* 1 / (1 + k (1 - z))^2: a long tail. */
static double tail(const double w[3], const void *context)
{
	double below = w[2] > 0.0 ? (w[0] * w[0] + w[1] * w[1]) / (1.0 + w[2]) : 1.0 - w[2];
	return pow(1.0 + *(const double *)context * below, -2.0);
}

static void lobes_of_any_width(void **state)
{
	(void)state;
	for (double width = 1e-3; width <= 1.0; width *= 1.7) {
		double k = 2.0 / (width * width);
		SHADE_PROOF_NEAR(stilb_numeric_integrate_lobe(lobe, &k, width), -2.0 * M_PI * expm1(-2.0 * k) / k, 1e-7, 0.0);
		SHADE_PROOF_NEAR(stilb_numeric_integrate_lobe(tail, &k, width), 4.0 * M_PI / (1.0 + 2.0 * k), 1e-7, 0.0);
	}
}

/* ---- albedo ------------------------------------------------------------------------------------------------------ */

static const shade_frame frame = {{1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}, {0.0f, 0.0f, 1.0f}};

typedef struct plain {
	shade_brdf_model model;
	shade_brdf_parameters parameters;
	stilb_vec3 fixed;
} plain;

static double of_view(const double l[3], const void *context)
{
	const plain *p = context;
	stilb_vec3 light = stilb_vec3_make((float)l[0], (float)l[1], (float)l[2]);
	return (double)shade_brdf_cos(p->model, p->parameters, frame, light, p->fixed)[0];
}

static double of_light(const double v[3], const void *context)
{
	const plain *p = context;
	stilb_vec3 view = stilb_vec3_make((float)v[0], (float)v[1], (float)v[2]);
	return (double)shade_brdf_cos(p->model, p->parameters, frame, p->fixed, view)[0] * v[2] / (double)p->fixed[2];
}

static void check_against_plain(shade_brdf_model model)
{
	static const double degrees[] = {0.0, 35.0, 70.0};
	shade_brdf_parameters parameters = {
		.specular = {1.0f, 0.0f, 0.0f}, .roughness = 0.6f, .anisotropy = 0.5f, .wrap = 0.3f};
	for (size_t i = 0; i < sizeof degrees / sizeof degrees[0]; i++) {
		stilb_numeric_angles angles = {degrees[i] * M_PI / 180.0, 0.7};
		stilb_vec3 fixed = stilb_vec3_make((float)(sin(angles.polar) * cos(angles.azimuth)),
		                                   (float)(sin(angles.polar) * sin(angles.azimuth)), (float)cos(angles.polar));
		plain p = {model, parameters, fixed};
		double view = stilb_numeric_integrate_sphere(of_view, &p, -1.0, 0.0, 8) +
		              stilb_numeric_integrate_sphere(of_view, &p, 0.0, 1.0, 8);
		double light = stilb_numeric_integrate_sphere(of_light, &p, 0.0, 1.0, 8);
		SHADE_PROOF_NEAR(stilb_numeric_albedo_of_view(&model, &parameters, angles), view, 5e-4, 0.0);
		SHADE_PROOF_NEAR(stilb_numeric_albedo_of_light(&model, &parameters, angles), light, 5e-4, 0.0);
	}
}

static void albedo_of_every_model(void **state)
{
	(void)state;
	for (int kind = 0; kind < SHADE_BRDF_MICROFACET; kind++)
		check_against_plain((shade_brdf_model){kind, 0, 0, 0});
	for (int d = 0; d < SHADE_NDF_COUNT; d++)
		for (int g = 0; g < SHADE_G_COUNT; g++)
			check_against_plain((shade_brdf_model){SHADE_BRDF_MICROFACET, d, g, SHADE_F_NONE});
}

/* A surface as smooth as can be is a mirror: Schlick's F at the mirror's angle, and Cook and Torrance's. */
static void smooth_surfaces_reflect_fresnel(void **state)
{
	(void)state;
	shade_brdf_parameters parameters = {.specular = {0.04f, 0.0f, 0.0f}, .roughness = 0.0f};
	for (double degrees = 0.0; degrees < 85.0; degrees += 20.0) {
		stilb_numeric_angles angles = {degrees * M_PI / 180.0, 0.0};
		shade_brdf_model schlick = {SHADE_BRDF_MICROFACET, SHADE_NDF_GGX, SHADE_G_SMITH_GGX, SHADE_F_SCHLICK};
		double want = 0.04 + 0.96 * pow(1.0 - cos(angles.polar), 5.0);
		SHADE_PROOF_NEAR(stilb_numeric_albedo_of_view(&schlick, &parameters, angles), want, 1e-3, 0.0);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(gauss_is_exact_for_polynomials),  cmocka_unit_test(points_are_those_of_the_rule),
		cmocka_unit_test(sphere_is_exact_for_polynomials), cmocka_unit_test(lobes_of_any_width),
		cmocka_unit_test(albedo_of_every_model),           cmocka_unit_test(smooth_surfaces_reflect_fresnel),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
