/* shade_sg.h and shade_vmf.h: Spherical Gaussians, lobes exp(sharpness (axis.v - 1)) on the sphere, against their
 * formulas in double and against numerical integration, the von Mises-Fisher distribution against the moments of its
 * own density. */

#include "shading/shade_sg.h"
#include "shading/shade_vmf.h"

#include "numeric/numeric_quadrature.h"
#include "support/shade_proof.h"

static const double sharpnesses[] = {0.0, 1e-5, 0.01, 0.3, 0.99, 1.0, 1.7, 5.0, 30.0, 400.0, 2e4, 2e6, 1e8};
#define SHARPNESS_COUNT (sizeof sharpnesses / sizeof sharpnesses[0])

static const stilb_vec3 Z = {0.0f, 0.0f, 1.0f};

/* The unit vector at this angle (radians) from +Z towards +X. */
static stilb_vec3 tilted(double angle)
{
	return stilb_vec3_make((float)sin(angle), 0.0f, (float)cos(angle));
}

static shade_sg lobe(stilb_vec3 axis, double sharpness, float amplitude)
{
	shade_sg g = {axis, (float)sharpness, {amplitude, 2.0f * amplitude, 0.5f * amplitude}};
	return g;
}

/* ---- truths in double -------------------------------------------------------------------------------------------- */

/* (1 - exp(-2 x)) / x, which is 2 at 0: times 2 pi the integral of a lobe of the sharpness x. */
static double mass(double x)
{
	return x == 0.0 ? 2.0 : -expm1(-2.0 * x) / x;
}

/* Langevin's function coth x - 1 / x, a lobe's mean cosine; below 0.05, where double loses digits too, its series. */
static double langevin(double x)
{
	return x < 0.05 ? x / 3.0 - x * x * x / 45.0 + 2.0 * pow(x, 5.0) / 945.0 : 1.0 / tanh(x) - 1.0 / x;
}

/* 1 - langevin(x), without its cancellation for large x. */
static double variance(double x)
{
	return x < 0.05 ? 1.0 - langevin(x) : 1.0 / x - 2.0 * exp(-2.0 * x) / -expm1(-2.0 * x);
}

/* The integral of the product of two lobes of amplitude 1 whose axes are `angle` radians apart: Karis's formula,
 * corrected as shade_sg_inner_product says. */
static double inner_product(double s1, double s2, double angle)
{
	double size = sqrt(s1 * s1 + s2 * s2 + 2.0 * s1 * s2 * cos(angle));
	return 2.0 * M_PI * (exp(size - s1 - s2) - exp(-size - s1 - s2)) / size;
}

/* ---- exactness: Spherical Gaussians ------------------------------------------------------------------------------ */

static void lobes_are_exponentials(void **state)
{
	(void)state;
	for (size_t i = 0; i < SHARPNESS_COUNT; i++)
		for (int step = 0; step <= 8; step++) {
			double s = sharpnesses[i], angle = step * fmin(0.5 / sqrt(s + 0.01), M_PI / 8.0);
			double half = sin(angle / 2.0), want = exp(-2.0 * s * half * half);
			stilb_vec3 g = shade_sg_evaluate(lobe(Z, s, 3.0f), tilted(angle));
			// The tolerance is the error of a float direction 1e-4 from Z.
			SHADE_PROOF_NEAR3(g, 3.0 * want, 6.0 * want, 1.5 * want, 4e-4, 1e-6);
		}
	SHADE_PROOF_NEAR(shade_sg_evaluate(lobe(Z, 5.0, 1.0f), tilted(1.0))[0], exp(5.0 * (cos(1.0) - 1.0)), 1e-6, 0.0);
}

static void mean_cosine_is_langevins(void **state)
{
	(void)state;
	for (double x = 1e-4; x < 1e8; x *= 1.3) {
		double s = (double)(float)x;
		SHADE_PROOF_NEAR(shade_sg_mean_cosine((float)x), langevin(s), 5e-7, 0.0);
		if (s >= 1.0)
			SHADE_PROOF_NEAR(shade_sg_coth_minus_one((float)x), 2.0 / expm1(2.0 * s), 1e-6, 1e-30);
	}
	SHADE_PROOF_NEAR(shade_sg_coth_minus_one(10.0f), 2.0 / expm1(20.0), 5e-6, 0.0);
	SHADE_PROOF_NEAR(shade_sg_coth_minus_one(1.0f), 2.0 / expm1(2.0), 1e-6, 0.0);
	assert_true(shade_sg_mean_cosine(0.0f) == 0.0f);
}

static void integrals_have_their_formula(void **state)
{
	(void)state;
	for (size_t i = 0; i < SHARPNESS_COUNT; i++) {
		double s = (double)(float)sharpnesses[i], want = 2.0 * M_PI * mass(s);
		shade_sg g = lobe(Z, s, 3.0f), unit = shade_sg_normalize(g);
		SHADE_PROOF_NEAR3(shade_sg_integral(g), 3.0 * want, 6.0 * want, 1.5 * want, 1e-6, 0.0);
		SHADE_PROOF_NEAR(shade_sg_normalized_amplitude((float)s), 1.0 / want, 1e-6, 0.0);
		SHADE_PROOF_NEAR3(unit.amplitude, 1.0 / want, 1.0 / want, 1.0 / want, 1e-6, 0.0);
		assert_true(unit.sharpness == g.sharpness && unit.axis[2] == 1.0f);
	}
}

/* The lobe that shade_sg_product returns has in every direction the product of the two lobes' values. */
static void products_are_lobes(void **state)
{
	(void)state;
	static const double angles[] = {0.0, 0.02, 0.7, 2.0, 3.0};
	for (size_t i = 0; i < 8; i++)
		for (size_t j = 0; j < 5; j++) {
			shade_sg a = lobe(Z, sharpnesses[i], 3.0f), b = lobe(tilted(angles[j]), 6.0, 0.5f);
			shade_sg p = shade_sg_product(a, b);
			SHADE_PROOF_NEAR(stilb_vec3_dot(p.axis, p.axis), 1.0, 1e-6, 0.0);
			for (int step = -6; step <= 6; step++) {
				stilb_vec3 v = tilted(step * 0.5), got = shade_sg_evaluate(p, v);
				stilb_vec3 of_a = shade_sg_evaluate(a, v), of_b = shade_sg_evaluate(b, v);
				for (int k = 0; k < 3; k++)
					SHADE_PROOF_NEAR(got[k], (double)of_a[k] * (double)of_b[k], 2e-5, 1e-9);
			}
		}
}

static void opposite_lobes_leave_a_constant(void **state)
{
	(void)state;
	shade_sg p = shade_sg_product(lobe(Z, 2.0, 1.0f), lobe(-Z, 2.0, 1.0f));
	SHADE_PROOF_NEAR(p.sharpness, 0.0, 0.0, 0.0);
	SHADE_PROOF_NEAR3(p.axis, 0.0, 0.0, 1.0, 0.0, 0.0);
	SHADE_PROOF_NEAR(p.amplitude[0], exp(-4.0), 1e-6, 0.0);
	SHADE_PROOF_NEAR(shade_sg_inner_product(lobe(Z, 2.0, 1.0f), lobe(-Z, 2.0, 1.0f))[0], 4.0 * M_PI * exp(-4.0), 1e-6,
	                 0.0);
	shade_sg even = shade_sg_product(lobe(Z, 0.0, 1.0f), lobe(tilted(1.0), 0.0, 2.0f));
	SHADE_PROOF_NEAR(even.amplitude[0], 2.0, 0.0, 0.0);
	SHADE_PROOF_NEAR3(even.axis, 0.0, 0.0, 1.0, 0.0, 0.0);
}

static void powers_are_lobes(void **state)
{
	(void)state;
	shade_sg g = lobe(Z, 4.0, 1.5f), power = shade_sg_power(g, 2.5f);
	for (int step = 0; step <= 6; step++) {
		double want = pow((double)shade_sg_evaluate(g, tilted(step * 0.3))[1], 2.5);
		SHADE_PROOF_NEAR(shade_sg_evaluate(power, tilted(step * 0.3))[1], want, 1e-5, 0.0);
	}
}

static void inner_products_have_the_corrected_formula(void **state)
{
	(void)state;
	static const double angles[] = {0.0, 0.1, 0.7, 1.6, 2.8};
	for (size_t i = 1; i < 9; i++)
		for (size_t j = 1; j < 9; j++)
			for (size_t k = 0; k < 5; k++) {
				double a = (double)(float)sharpnesses[i], b = (double)(float)sharpnesses[j];
				if (a < 0.1 && b < 0.1)
					continue; // the formula here has no digits left
				double got = (double)shade_sg_inner_product(lobe(Z, a, 1.0f), lobe(tilted(angles[k]), b, 3.0f))[0];
				SHADE_PROOF_NEAR(got, 3.0 * inner_product(a, b, angles[k]), 1e-5, 1e-12);
			}
	// Amplitudes 0.7 and 1.3: 0.19873; with the averaged axis, as printed, it would be 1.1e-5.
	SHADE_PROOF_NEAR(shade_sg_inner_product(lobe(Z, 5.0, 0.7f), lobe(tilted(0.7), 9.0, 1.3f))[0], 0.19873, 0.0, 5e-6);
	SHADE_PROOF_NEAR(shade_sg_inner_product(lobe(Z, 0.0, 1.0f), lobe(tilted(0.7), 0.0, 1.0f))[0], 4.0 * M_PI, 1e-6,
	                 0.0);
	SHADE_PROOF_NEAR(shade_sg_inner_product(lobe(Z, 1e8, 1.0f), lobe(Z, 1e8, 1.0f))[0], M_PI * 1e-8, 1e-6, 0.0);
}

static void convolution_keeps_the_formula(void **state)
{
	(void)state;
	shade_sg got = shade_sg_convolve(lobe(tilted(0.3), 20.0, 3.0f), lobe(Z, 30.0, 0.5f));
	SHADE_PROOF_NEAR(got.sharpness, 12.0, 1e-6, 0.0);
	SHADE_PROOF_NEAR3(got.amplitude, 2.0 * M_PI * 1.5 / 50.0, 2.0 * M_PI * 6.0 / 50.0, 2.0 * M_PI * 0.375 / 50.0, 1e-6,
	                  0.0);
	assert_true(got.axis[0] == tilted(0.3)[0]);
	got = shade_sg_convolve(lobe(Z, 0.0, 1.0f), lobe(Z, 0.0, 1.0f)); // two constants of 1 over the whole sphere
	SHADE_PROOF_NEAR(got.sharpness, 0.0, 0.0, 0.0);
	SHADE_PROOF_NEAR(got.amplitude[0], 4.0 * M_PI, 1e-6, 0.0);
}

/* ---- exactness: von Mises-Fisher --------------------------------------------------------------------------------- */

static void densities_have_their_formula(void **state)
{
	(void)state;
	for (double s = 0.01; s < 1e4; s *= 3.0) {
		shade_vmf d = {Z, (float)(1.0 / s)};
		double sharpness = 1.0 / (double)d.inverse_sharpness, angle = 1.0 / sqrt(s + 1.0);
		double half = sin(angle / 2.0), want = exp(-2.0 * sharpness * half * half) / (2.0 * M_PI * mass(sharpness));
		SHADE_PROOF_NEAR(shade_vmf_density(d, tilted(angle)), want, 2e-5, 0.0);
	}
	shade_vmf needle = {Z, 0.0f};
	SHADE_PROOF_NEAR(shade_vmf_density(needle, Z), 1e9 / (2.0 * M_PI), 1e-6, 0.0);
}

static void variance_and_its_slope(void **state)
{
	(void)state;
	for (double k = 1e-7; k < 3e3; k *= 1.3) {
		double x = 1.0 / (double)(float)k, sinh_x = sinh(fmin(x, 300.0));
		double slope = x < 0.01 ? x * x / 3.0 : 1.0 - x * x / (sinh_x * sinh_x);
		SHADE_PROOF_NEAR(shade_vmf_variance((float)k), variance(x), 3e-7, 0.0);
		SHADE_PROOF_NEAR(shade_vmf_variance_slope((float)k), slope, x < 0.1 ? 1e-4 : 1e-6, 0.0);
	}
	assert_true(shade_vmf_variance(0.0f) == 0.0f);
}

/* The sharpness that Banerjee's approximation gives back for the mean direction of a lobe of this sharpness. */
static double fast(double sharpness)
{
	return 1.0 / (double)shade_vmf_inverse_sharpness_fast((float)variance(sharpness));
}

static void fast_form_is_as_good_as_it_says(void **state)
{
	(void)state;
	SHADE_PROOF_NEAR(fast(1.0), 1.00712, 3e-6, 0.0);
	SHADE_PROOF_NEAR(fast(5.0), 5.246834, 3e-6, 0.0);
	SHADE_PROOF_NEAR(fast(50.0), 50.47495, 3e-6, 0.0);
	double worst = 0.0;
	for (double s = 0.05; s < 1e7; s *= 1.02) {
		SHADE_PROOF_NEAR(fast(s) / s, 1.025, 0.0, 0.0251); // from 1 to 1.05: never too wide
		worst = fmax(worst, 1.0 - s / fast(s));
	}
	SHADE_PROOF_NEAR(worst, 0.047, 0.0, 0.0002);
	SHADE_PROOF_NEAR(shade_vmf_inverse_sharpness_fast(1.0f), 1.0 / 3e-4, 1e-3, 0.0); // even all around, not infinite
	assert_true(shade_vmf_inverse_sharpness_fast(0.0f) == 0.0f);
}

static void newtons_form_is_the_inverse(void **state)
{
	(void)state;
	for (double k = 1e-7; k <= 100.0; k *= 1.2) {
		double bound = k < 1.0 ? 1e-6 : 3e-6 * k;
		SHADE_PROOF_NEAR(shade_vmf_inverse_sharpness((float)variance(1.0 / k)), k, bound, 0.0);
	}
	assert_true(shade_vmf_inverse_sharpness(0.0f) == 0.0f);
	SHADE_PROOF_NEAR(shade_vmf_inverse_sharpness(1.0f), 1.0 / 3e-4, 1e-3, 0.0);
}

static void mean_directions_are_vectors(void **state)
{
	(void)state;
	shade_mean_direction mean = {tilted(0.5), 0.25f};
	stilb_vec3 r = shade_mean_direction_vector(mean);
	SHADE_PROOF_NEAR3(r, 0.75 * sin(0.5), 0.0, 0.75 * cos(0.5), 1e-6, 0.0);
	shade_mean_direction back = shade_mean_direction_from_vector(r);
	SHADE_PROOF_NEAR(back.variance, 0.25, 1e-6, 0.0);
	SHADE_PROOF_NEAR3(back.axis, sin(0.5), 0.0, cos(0.5), 1e-6, 0.0);
	back = shade_mean_direction_from_vector(stilb_vec3_make(0.0f, 0.0f, 0.0f));
	assert_true(back.variance == 1.0f && back.axis[2] == 1.0f);
	assert_true(shade_mean_direction_from_vector(Z * 1.00001f).variance == 0.0f);
}

/* The mean of two sets of directions taken together is the mean of their means, weighted by their sizes. */
static void mixing_is_averaging(void **state)
{
	(void)state;
	shade_mean_direction a = {tilted(0.2), 0.25f}, b = {tilted(1.1), 0.5f};
	shade_mean_direction mixed = shade_mean_direction_mix(a, b, 0.375f);
	double x = 0.625 * 0.75 * sin(0.2) + 0.375 * 0.5 * sin(1.1), z = 0.625 * 0.75 * cos(0.2) + 0.375 * 0.5 * cos(1.1);
	double size = hypot(x, z);
	SHADE_PROOF_NEAR(mixed.variance, 1.0 - size, 5e-7, 0.0);
	SHADE_PROOF_NEAR3(mixed.axis, x / size, 0.0, z / size, 5e-7, 0.0);
	mixed = shade_mean_direction_mix(a, a, 0.375f);
	SHADE_PROOF_NEAR(mixed.variance, 0.25, 2e-7, 0.0);
	// Normals a thousandth apart: 1 - |r| is 1.25e-7, which no float |r| could tell.
	a = (shade_mean_direction){tilted(0.0), 0.0f}, b = (shade_mean_direction){tilted(1e-3), 0.0f};
	SHADE_PROOF_NEAR(shade_mean_direction_mix(a, b, 0.5f).variance, 1.25e-7, 1e-3, 0.0);
	b.axis = -Z;
	mixed = shade_mean_direction_mix(a, b, 0.5f);
	SHADE_PROOF_NEAR(mixed.variance, 1.0, 1e-6, 0.0);
	SHADE_PROOF_NEAR3(mixed.axis, 0.0, 0.0, 1.0, 0.0, 0.0);
	/* r = -8e-5 Z is too short for a direction: about +Z the variance would be 1.00008. */
	assert_true(shade_mean_direction_mix(a, b, 0.50004f).variance == 1.0f);
}

static void distributions_lobes_and_means(void **state)
{
	(void)state;
	shade_vmf d = {tilted(0.4), 0.2f};
	shade_mean_direction mean = shade_vmf_mean(d);
	SHADE_PROOF_NEAR(mean.variance, variance(5.0), 1e-6, 0.0);
	SHADE_PROOF_NEAR(shade_vmf_from_mean(mean).inverse_sharpness, 0.2, 1e-6, 0.0);
	assert_true(mean.axis[0] == d.axis[0] && shade_vmf_from_mean(mean).axis[0] == d.axis[0]);
	shade_sg g = shade_sg_from_vmf(d, stilb_vec3_make(1.0f, 2.0f, 0.0f));
	double peak = 1.0 / (2.0 * M_PI * mass(5.0));
	SHADE_PROOF_NEAR3(g.amplitude, peak, 2.0 * peak, 0.0, 1e-6, 0.0);
	SHADE_PROOF_NEAR(g.sharpness, 5.0, 1e-6, 0.0);
	SHADE_PROOF_NEAR(shade_vmf_from_sg(g).inverse_sharpness, 0.2, 1e-6, 0.0);
	SHADE_PROOF_NEAR(shade_vmf_from_sg(lobe(Z, 0.0, 1.0f)).inverse_sharpness, 1e4, 1e-6, 0.0);
}

static void added_lobes_keep_integral_and_mean(void **state)
{
	(void)state;
	shade_sg a = lobe(Z, 8.0, 1.0f), b = lobe(tilted(0.6), 20.0, 3.0f), sum = shade_sg_add(a, b);
	double of_a = 2.0 * M_PI * mass(8.0), of_b = 6.0 * M_PI * mass(20.0);
	double x = of_b * langevin(20.0) * sin(0.6), z = of_a * langevin(8.0) + of_b * langevin(20.0) * cos(0.6);
	SHADE_PROOF_NEAR(shade_sg_integral(sum)[0], of_a + of_b, 2e-6, 0.0);
	SHADE_PROOF_NEAR3(sum.axis, x / hypot(x, z), 0.0, z / hypot(x, z), 1e-6, 0.0);
	SHADE_PROOF_NEAR(langevin((double)sum.sharpness), hypot(x, z) / (of_a + of_b), 1e-6, 0.0);
	sum = shade_sg_add(a, a); // a lobe added to itself keeps its shape
	SHADE_PROOF_NEAR(sum.sharpness, 8.0, 2e-6, 0.0);
	SHADE_PROOF_NEAR3(sum.amplitude, 2.0, 4.0, 1.0, 2e-6, 0.0);
	// All channels weigh the same: with one lobe red, the other as much blue, the axis is halfway.
	shade_sg red = {Z, 10.0f, {1.0f, 0.0f, 0.0f}}, blue = {tilted(1.0), 10.0f, {0.0f, 0.0f, 1.0f}};
	sum = shade_sg_add(red, blue);
	SHADE_PROOF_NEAR3(sum.axis, sin(0.5), 0.0, cos(0.5), 2e-6, 0.0);
	SHADE_PROOF_NEAR3(shade_sg_integral(sum), 2.0 * M_PI * mass(10.0), 0.0, 2.0 * M_PI * mass(10.0), 2e-6, 0.0);
	sum = shade_sg_add(lobe(Z, 8.0, 0.0f), lobe(Z, 3.0, 0.0f));
	SHADE_PROOF_NEAR(sum.sharpness, 8.0, 2e-6, 0.0);
	SHADE_PROOF_NEAR3(sum.amplitude, 0.0, 0.0, 0.0, 0.0, 0.0);
}

/* ---- quadrature -------------------------------------------------------------------------------------------------- */

typedef struct lobes {
	shade_sg a, b;
} lobes;

static stilb_vec3 as_vec3(const double w[3])
{
	return stilb_vec3_make((float)w[0], (float)w[1], (float)w[2]);
}

static double product_at(const double w[3], const void *context)
{
	const lobes *c = context;
	return (double)shade_sg_evaluate(c->a, as_vec3(w))[0] * (double)shade_sg_evaluate(c->b, as_vec3(w))[0];
}

static void integrals_are_what_quadrature_finds(void **state)
{
	(void)state;
	static const double angles[] = {0.0, 0.4, 1.3, 2.2, M_PI};
	for (size_t i = 0; i < 9; i++) // sharpnesses up to 30, which the quadrature resolves
		for (size_t j = 0; j < 9; j += 2)
			for (size_t k = 0; k < 5; k++) {
				lobes c = {lobe(Z, sharpnesses[i], 1.0f), lobe(tilted(angles[k]), sharpnesses[j], 2.0f)};
				double truth = stilb_numeric_integrate_sphere(product_at, &c, -1.0, 1.0, 4);
				SHADE_PROOF_NEAR(shade_sg_inner_product(c.a, c.b)[0], truth, 2e-5, 1e-9);
			}
}

static double density_at(const double w[3], const void *context)
{
	return (double)shade_vmf_density(*(const shade_vmf *)context, as_vec3(w));
}

static double density_cosine_at(const double w[3], const void *context)
{
	return density_at(w, context) * w[2];
}

static void densities_integrate_to_one_and_have_their_mean(void **state)
{
	(void)state;
	for (double s = 0.01; s < 2e3; s *= 2.0) {
		shade_vmf d = {Z, (float)(1.0 / s)};
		double low = fmax(-1.0, 1.0 - 40.0 / s), bare = 1.0 - exp(-40.0);
		double total = stilb_numeric_integrate_sphere(density_at, &d, low, 1.0, 4);
		double mean = stilb_numeric_integrate_sphere(density_cosine_at, &d, low, 1.0, 4);
		SHADE_PROOF_NEAR(total, bare, 1e-5, 0.0);
		SHADE_PROOF_NEAR(mean, 1.0 - (double)shade_vmf_variance(d.inverse_sharpness), 1e-5, 1e-6);
	}
}

/* The largest error, relative to the peak, of the lobe that approximates a convolution. The exact value at v is an
 * inner product with the second lobe about v. */
static double convolution_error(double s1, double s2)
{
	shade_sg blurred = shade_sg_convolve(lobe(Z, s1, 1.0f), lobe(Z, s2, 1.0f));
	double worst = 0.0, peak = (double)blurred.amplitude[0];
	SHADE_PROOF_NEAR(peak, inner_product(s1, s2, 0.0), 1e-5, 0.0);
	for (double angle = 0.0; angle <= M_PI; angle += 0.01)
		worst = fmax(worst, fabs((double)shade_sg_evaluate(blurred, tilted(angle))[0] - inner_product(s1, s2, angle)));
	return worst / peak;
}

static void convolution_is_as_good_as_it_says(void **state)
{
	(void)state;
	for (double s = 20.0; s < 1e4; s *= 3.0) {
		assert_true(convolution_error(s, s) < 0.006);
		assert_true(convolution_error(20.0, s) < 0.006);
	}
	assert_true(convolution_error(2.0, 2.0) < 0.08);
	assert_true(convolution_error(2.0, 2.0) > 0.006);
}

/* ---- properties -------------------------------------------------------------------------------------------------- */

static shade_sg random_lobe(shade_proof_random *random)
{
	float kind = shade_proof_uniform(random);
	shade_sg g = {shade_proof_random_direction(random), shade_proof_log_range(random, 1e-8f, 1e8f),
	              shade_proof_random_color(random, shade_proof_log_range(random, 1e-6f, 1e12f))};
	if (kind < 0.1f)
		g.sharpness = 0.0f;
	return g;
}

/* A second lobe for g; one in three has the same axis or the opposite one. */
static shade_sg random_partner(shade_proof_random *random, shade_sg g)
{
	shade_sg other = random_lobe(random);
	float kind = shade_proof_uniform(random);
	if (kind < 0.3f)
		other.axis = kind < 0.15f ? g.axis : -g.axis;
	if (kind < 0.1f)
		other.sharpness = g.sharpness;
	return other;
}

static void unit(stilb_vec3 axis)
{
	SHADE_PROOF_NEAR(stilb_vec3_dot(axis, axis), 1.0, 1e-5, 0.0);
}

static void a_lobe_gives_light(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 1};
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		shade_sg g = random_lobe(&random);
		stilb_vec3 light = shade_sg_evaluate(g, shade_proof_random_direction(&random));
		stilb_vec3 integral = shade_sg_integral(g), peak = shade_sg_normalize(g).amplitude;
		SHADE_PROOF_LIGHT3(light);
		SHADE_PROOF_LIGHT3(integral);
		SHADE_PROOF_LIGHT3(peak);
		SHADE_PROOF_LIGHT3(shade_sg_power(g, shade_proof_range(&random, 0.01f, 3.0f)).amplitude);
		float cosine = shade_sg_mean_cosine(g.sharpness);
		assert_true(cosine >= 0.0f && cosine <= 1.0f);
		for (int k = 0; k < 3; k++)
			assert_true(light[k] <= g.amplitude[k] && integral[k] <= 12.5664f * g.amplitude[k]);
	}
}

static void two_lobes_give_light(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 2};
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		shade_sg a = random_lobe(&random), b = random_partner(&random, a);
		shade_sg product = shade_sg_product(a, b), blurred = shade_sg_convolve(a, b);
		stilb_vec3 both = shade_sg_inner_product(a, b), swapped = shade_sg_inner_product(b, a);
		SHADE_PROOF_LIGHT3(product.amplitude);
		SHADE_PROOF_LIGHT3(blurred.amplitude);
		SHADE_PROOF_LIGHT3(both);
		SHADE_PROOF_LIGHT(product.sharpness);
		SHADE_PROOF_LIGHT(blurred.sharpness);
		unit(product.axis);
		assert_true(product.sharpness <= (a.sharpness + b.sharpness) * 1.000001f);
		assert_true(blurred.sharpness <= fminf(a.sharpness, b.sharpness) * 1.000001f);
		SHADE_PROOF_NEAR3(both, swapped[0], swapped[1], swapped[2], 4e-5, 1e-36);
	}
}

static void sums_of_lobes_keep_the_light(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 3};
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		shade_sg a = random_lobe(&random), b = random_partner(&random, a), sum = shade_sg_add(a, b);
		stilb_vec3 before = shade_sg_integral(a) + shade_sg_integral(b), after = shade_sg_integral(sum);
		SHADE_PROOF_LIGHT3(sum.amplitude);
		SHADE_PROOF_LIGHT(sum.sharpness);
		unit(sum.axis);
		SHADE_PROOF_NEAR3(after, before[0], before[1], before[2], 1e-5, 1e-30);
	}
}

static void variances_round_trip(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 4};
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		float k = shade_proof_log_range(&random, 1e-9f, 1e4f), v = shade_proof_uniform(&random);
		float spread = shade_vmf_variance(k), slope = shade_vmf_variance_slope(k);
		assert_true(spread > 0.0f && spread <= 1.0f && slope > 0.0f && slope <= 1.0f);
		assert_true(shade_vmf_variance(k * 1.01f) >= spread);
		if (v < 0.9998f) // above it |r| counts as too short to have a direction
			SHADE_PROOF_NEAR(shade_vmf_variance(shade_vmf_inverse_sharpness(v)), (double)v, 1e-6, 2e-7);
		if (k < 100.0f)
			SHADE_PROOF_NEAR(shade_vmf_inverse_sharpness(spread), (double)k, k < 1.0f ? 2e-6 : 4e-6 * (double)k, 0.0);
		shade_vmf d = {shade_proof_random_direction(&random), k};
		shade_mean_direction mean = {d.axis, fminf(v, 0.999f)};
		shade_mean_direction back = shade_mean_direction_from_vector(shade_mean_direction_vector(mean));
		SHADE_PROOF_NEAR(back.variance, (double)mean.variance, 0.0, 3e-7);
		SHADE_PROOF_NEAR3(back.axis, d.axis[0], d.axis[1], d.axis[2], 0.0, 4e-7);
		SHADE_PROOF_LIGHT(shade_vmf_density(d, shade_proof_random_direction(&random)));
		SHADE_PROOF_LIGHT(shade_vmf_density(d, d.axis));
	}
}

/* Mixing means gives what averaging the vectors in double gives, and the same in another order. */
static void means_mix_in_any_order(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 5};
	for (int i = 0; i < SHADE_PROOF_COUNT / 4; i++) {
		shade_mean_direction m[4];
		double r[3] = {0};
		for (int j = 0; j < 4; j++) {
			m[j].axis = shade_proof_random_direction(&random);
			m[j].variance = shade_proof_uniform(&random) * (i % 2 ? 1.0f : 1e-3f);
			for (int k = 0; k < 3; k++)
				r[k] += 0.25 * (1.0 - (double)m[j].variance) * (double)m[j].axis[k];
		}
		shade_mean_direction pairs = shade_mean_direction_mix(shade_mean_direction_mix(m[0], m[1], 0.5f),
		                                                      shade_mean_direction_mix(m[2], m[3], 0.5f), 0.5f);
		shade_mean_direction chain = m[3];
		for (int j = 2; j >= 0; j--)
			chain = shade_mean_direction_mix(chain, m[j], 1.0f / (float)(4 - j));
		unit(pairs.axis);
		assert_true(pairs.variance >= 0.0f && pairs.variance <= 1.0f);
		SHADE_PROOF_NEAR3(shade_mean_direction_vector(pairs), r[0], r[1], r[2], 0.0, 2e-4);
		SHADE_PROOF_NEAR(1.0f - pairs.variance, sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]), 0.0, 2e-4);
		SHADE_PROOF_NEAR(chain.variance, (double)pairs.variance, 0.0, 2e-4);
	}
}

int main(void)
{
	const struct CMUnitTest exactness[] = {
		cmocka_unit_test(lobes_are_exponentials),
		cmocka_unit_test(mean_cosine_is_langevins),
		cmocka_unit_test(integrals_have_their_formula),
		cmocka_unit_test(products_are_lobes),
		cmocka_unit_test(opposite_lobes_leave_a_constant),
		cmocka_unit_test(powers_are_lobes),
		cmocka_unit_test(inner_products_have_the_corrected_formula),
		cmocka_unit_test(convolution_keeps_the_formula),
		cmocka_unit_test(densities_have_their_formula),
		cmocka_unit_test(variance_and_its_slope),
		cmocka_unit_test(fast_form_is_as_good_as_it_says),
		cmocka_unit_test(newtons_form_is_the_inverse),
		cmocka_unit_test(mean_directions_are_vectors),
		cmocka_unit_test(mixing_is_averaging),
		cmocka_unit_test(distributions_lobes_and_means),
		cmocka_unit_test(added_lobes_keep_integral_and_mean),
	};
	const struct CMUnitTest properties[] = {
		cmocka_unit_test(integrals_are_what_quadrature_finds),
		cmocka_unit_test(densities_integrate_to_one_and_have_their_mean),
		cmocka_unit_test(convolution_is_as_good_as_it_says),
		cmocka_unit_test(a_lobe_gives_light),
		cmocka_unit_test(two_lobes_give_light),
		cmocka_unit_test(sums_of_lobes_keep_the_light),
		cmocka_unit_test(variances_round_trip),
		cmocka_unit_test(means_mix_in_any_order),
	};
	return SHADE_PROOF_RUN(exactness, properties);
}
