/* shade_phong.h, Phong's and Blinn's highlights ("Schueler's zoo"): against their formulas written anew in double, and
 * their factors against numerical integration. */

#include "shading/shade_phong.h"

#include "numeric/numeric_quadrature.h"
#include "support/shade_proof.h"

/* Exponents from 0 to that of the smoothest surface, SHADE_ALPHA_MIN. */
static const double exponents[] = {0.0, 0.01, 0.5, 1.0, 2.0, 7.0, 30.0, 200.0, 8192.0, 2e6};
#define EXPONENT_COUNT (sizeof exponents / sizeof exponents[0])

/* ---- exactness -------------------------------------------------------------------------------------------------- */

/* sin^2 of eleven tilts (step 0 to 10) at which a lobe of the exponent n is between its peak, 1, and about e^-10. */
static double tilt2(double n, int step)
{
	return fmin(step * 2.0 / (n + 2.0), 0.999);
}

static void cos_power_is_a_power(void **state)
{
	(void)state;
	for (size_t i = 0; i < EXPONENT_COUNT; i++)
		for (int step = 0; step <= 10; step++) {
			double n = exponents[i], sin2 = (double)(float)tilt2(n, step);
			SHADE_PROOF_NEAR(shade_cos_power((float)sin2, (float)n), exp(0.5 * n * log1p(-sin2)), 1e-5, 1e-7);
		}
	assert_true(shade_cos_power(0.0f, 2e6f) == 1.0f);
	assert_true(shade_cos_power(1.0f, 0.0f) == 0.0f);
	assert_true(shade_cos_power(1.0f, 2e6f) == 0.0f);
	SHADE_PROOF_NEAR(shade_cos_power(0.9995f, 1.0f), sqrt(0.0005), 1e-4, 0.0);
}

static void exponents_follow_alpha(void **state)
{
	(void)state;
	SHADE_PROOF_NEAR(shade_exponent_from_alpha(1.0f), 0.0, 0.0, 0.0);
	SHADE_PROOF_NEAR(shade_exponent_from_alpha(0.5f), 6.0, 1e-6, 0.0);
	SHADE_PROOF_NEAR(shade_exponent_from_alpha(1e-3f), 1999998.0, 1e-6, 0.0);
	SHADE_PROOF_NEAR(shade_alpha_from_exponent(6.0f), 0.5, 1e-6, 0.0);
	SHADE_PROOF_NEAR(shade_alpha_from_exponent(0.0f), 1.0, 1e-6, 0.0);
	SHADE_PROOF_NEAR(shade_exponent_about_r(6.0f), 1.5, 1e-6, 0.0);
	SHADE_PROOF_NEAR(shade_exponent_from_gloss(0.0f), 1.0, 1e-6, 0.0);
	SHADE_PROOF_NEAR(shade_exponent_from_gloss(1.0f), 8192.0, 1e-6, 0.0);
	SHADE_PROOF_NEAR(shade_gloss_from_exponent(128.0f), 7.0 / 13.0, 1e-6, 0.0);
}

/* The factors have the formulas of the header's table; the two Blinn-Phong ones lie between their bounds. */
static void factors_have_their_formulas(void **state)
{
	(void)state;
	for (size_t i = 0; i < EXPONENT_COUNT; i++) {
		double n = exponents[i], half = pow(0.5, n / 2.0), pi8 = 8.0 * M_PI;
		float x = (float)n;
		n = (double)x;
		SHADE_PROOF_NEAR(shade_phong_factor(x), (n + 1.0) * 4.0 / pi8, 2e-6, 0.0);
		SHADE_PROOF_NEAR(shade_phong_modified_factor(x), (n + 2.0) * 4.0 / pi8, 2e-6, 0.0);
		SHADE_PROOF_NEAR(shade_blinn_phong_factor(x), (n + 2.0) * 2.0 / pi8 / (2.0 - half), 2e-6, 0.0);
		SHADE_PROOF_NEAR(shade_blinn_phong_factor_low(x), (n + 2.0) / pi8, 2e-6, 0.0);
		SHADE_PROOF_NEAR(shade_blinn_phong_factor_high(x), (n + 4.0) / pi8, 2e-6, 0.0);
		SHADE_PROOF_NEAR(shade_blinn_phong_modified_factor(x), (n + 2.0) * (n + 4.0) / pi8 / (half + n), 2e-6, 0.0);
		SHADE_PROOF_NEAR(shade_blinn_phong_modified_factor_low(x), (n + 6.0) / pi8, 2e-6, 0.0);
		SHADE_PROOF_NEAR(shade_blinn_phong_modified_factor_high(x), (n + 8.0) / pi8, 2e-6, 0.0);
		SHADE_PROOF_NEAR(shade_blinn_phong_ndf_factor(x), (n + 1.0) * 4.0 / pi8, 2e-6, 0.0);
		SHADE_PROOF_NEAR(shade_blinn_phong_heightfield_factor(x), (n + 2.0) * 4.0 / pi8, 2e-6, 0.0);
	}
	SHADE_PROOF_NEAR(shade_blinn_phong_modified_factor(0.0f), 1.0 / M_PI, 1e-6, 0.0);
}

/* A lobe is factor x power x cosine. With n = 3, sin^2 = 0.3, n.l = 0.4 each of the three changes the result. */
static void lobes_are_factor_power_and_cosine(void **state)
{
	(void)state;
	double power = pow(0.7, 1.5), pi8 = 8.0 * M_PI, half = pow(0.5, 1.5);
	SHADE_PROOF_NEAR(shade_phong(0.3f, 3.0f), 16.0 / pi8 * power, 2e-6, 0.0);
	SHADE_PROOF_NEAR(shade_phong_modified(0.3f, 0.4f, 3.0f), 20.0 / pi8 * power * 0.4, 2e-6, 0.0);
	SHADE_PROOF_NEAR(shade_blinn_phong(0.3f, 3.0f), 10.0 / (pi8 * (2.0 - half)) * power, 2e-6, 0.0);
	SHADE_PROOF_NEAR(shade_blinn_phong_modified(0.3f, 0.4f, 3.0f), 35.0 / (pi8 * (half + 3.0)) * power * 0.4, 2e-6,
	                 0.0);
}

/* sin^2 between l and v's mirror image about n, in double; the angle is right or wider where the cosine is not
 * positive. */
static double mirror_sin2(stilb_vec3 n, stilb_vec3 l, stilb_vec3 v)
{
	double n_dot_v = 0.0, r_dot_l = 0.0, r2 = 0.0, l2 = 0.0;
	for (int k = 0; k < 3; k++)
		n_dot_v += (double)n[k] * (double)v[k];
	for (int k = 0; k < 3; k++) {
		double r = 2.0 * n_dot_v * (double)n[k] - (double)v[k];
		r_dot_l += r * (double)l[k];
		r2 += r * r;
		l2 += (double)l[k] * (double)l[k];
	}
	return r_dot_l <= 0.0 ? 1.0 : 1.0 - r_dot_l * r_dot_l / (r2 * l2);
}

static void mirror_angle_is_exact(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 31};
	for (int i = 0; i < 1000; i++) {
		stilb_vec3 n = shade_proof_random_direction(&random), v = shade_proof_random_above(&random, n);
		stilb_vec3 l = shade_proof_random_above(&random, n);
		SHADE_PROOF_NEAR(shade_sin2_r(n, l, v), mirror_sin2(n, l, v), 2e-6, 1e-6);
	}
	stilb_vec3 n = {0.0f, 0.0f, 1.0f}, v = {0.6f, 0.0f, 0.8f};
	SHADE_PROOF_NEAR(shade_sin2_r(n, stilb_vec3_make(-0.6f, 0.0f, 0.8f), v), 0.0, 0.0, 0.0);
	/* 0.05 degrees within the right angle something is left of the flattest lobe, and as far beyond it nothing is. */
	assert_true(shade_sin2_r(n, stilb_vec3_make(0.7994761f, 0.0f, 0.6006979f), v) < 1.0f);
	assert_true(shade_sin2_r(n, stilb_vec3_make(0.8005233f, 0.0f, 0.5993016f), v) == 1.0f);
}

static const struct CMUnitTest exactness[] = {
	cmocka_unit_test(cos_power_is_a_power),        cmocka_unit_test(exponents_follow_alpha),
	cmocka_unit_test(factors_have_their_formulas), cmocka_unit_test(lobes_are_factor_power_and_cosine),
	cmocka_unit_test(mirror_angle_is_exact),
};

/* ---- properties ------------------------------------------------------------------------------------------------- */

/* One row of the table along the normal: the lobe at the angle theta between l and n = v = r. */
typedef struct zoo_row {
	float (*lobe)(double theta, float n);
	float n;
} zoo_row;

static float sine2(double angle)
{
	return (float)(sin(angle) * sin(angle));
}

static float phong_lobe(double theta, float n)
{
	return shade_phong(sine2(theta), n);
}

static float phong_modified_lobe(double theta, float n)
{
	return shade_phong_modified(sine2(theta), (float)cos(theta), n);
}

static float blinn_phong_lobe(double theta, float n)
{
	return shade_blinn_phong(sine2(theta / 2.0), n);
}

static float blinn_phong_modified_lobe(double theta, float n)
{
	return shade_blinn_phong_modified(sine2(theta / 2.0), (float)cos(theta), n);
}

static float ndf_lobe(double theta, float n)
{
	return shade_blinn_phong_ndf_factor(n) * shade_cos_power(sine2(theta), n);
}

static float heightfield_lobe(double theta, float n)
{
	return shade_blinn_phong_heightfield_factor(n) * shade_cos_power(sine2(theta), n) * (float)cos(theta);
}

static double zoo_integrand(double theta, const void *context)
{
	const zoo_row *row = context;
	return 2.0 * M_PI * (double)row->lobe(theta, row->n) * sin(theta);
}

/* The integral that each row of the header's table is normalised by is 1: the albedo at normal incidence for the four
 * highlights, the integral of D, and of D times the cosine. */
static void rows_are_normalised(void **state)
{
	(void)state;
	static float (*const lobes[])(double, float) = {
		phong_lobe, phong_modified_lobe, blinn_phong_lobe, blinn_phong_modified_lobe, ndf_lobe, heightfield_lobe,
	};
	for (size_t lobe = 0; lobe < sizeof lobes / sizeof lobes[0]; lobe++)
		for (size_t i = 0; i < EXPONENT_COUNT; i++) {
			zoo_row row = {lobes[lobe], (float)exponents[i]};
			double end = fmin(M_PI / 2.0, 30.0 / sqrt(exponents[i] + 1.0)); /* beyond it the lobe is 0 in float */
			SHADE_PROOF_NEAR(stilb_numeric_integrate(zoo_integrand, &row, 0.0, end, 30), 1.0, 1e-5, 0.0);
		}
}

static void bounds_enclose_their_factors(void **state)
{
	(void)state;
	for (float n = 0.05f; n < 4000.0f; n *= 1.01f) {
		float factor = shade_blinn_phong_factor(n), modified = shade_blinn_phong_modified_factor(n);
		/* Both upper bounds are reached at n = 0, both lower ones at infinity: a float may land on the bound. */
		assert_true(shade_blinn_phong_factor_low(n) <= factor && factor < shade_blinn_phong_factor_high(n));
		assert_true(shade_blinn_phong_modified_factor_low(n) < modified);
		assert_true(modified < shade_blinn_phong_modified_factor_high(n));
	}
}

/* Alpha and gloss to an exponent and back, and from an exponent and back, over the whole range. */
static void exponents_come_back(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 32};
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		float alpha = shade_proof_log_range(&random, 1e-3f, 1.0f), n = shade_proof_log_range(&random, 1e-2f, 2e6f);
		float gloss = shade_proof_uniform(&random);
		SHADE_PROOF_NEAR(shade_alpha_from_exponent(shade_exponent_from_alpha(alpha)), alpha, 1e-6, 0.0);
		/* The sum n + 2 rounds off the last digits of a small n. */
		SHADE_PROOF_NEAR(shade_exponent_from_alpha(shade_alpha_from_exponent(n)), n, 1e-6, 1e-6);
		SHADE_PROOF_NEAR(shade_gloss_from_exponent(shade_exponent_from_gloss(gloss)), gloss, 1e-6, 1e-6);
		SHADE_PROOF_NEAR(shade_exponent_from_gloss(shade_gloss_from_exponent(n)), n, 2e-6, 0.0);
	}
}

static void every_lobe_is_light(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 33};
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		stilb_vec3 normal = shade_proof_random_direction(&random), v = shade_proof_random_direction(&random);
		stilb_vec3 l = shade_proof_random_direction(&random);
		float n = i % 4 == 0 ? 0.0f : shade_proof_log_range(&random, 1e-3f, 2e6f);
		float sin2_h = i % 3 == 0 ? (float)(i % 2) : shade_proof_uniform(&random);
		float cosine = i % 5 == 0 ? 0.0f : shade_proof_uniform(&random), sin2_r = shade_sin2_r(normal, l, v);
		assert_true(sin2_r >= 0.0f && sin2_r <= 1.0f);
		assert_true(shade_cos_power(sin2_h, n) <= 1.0f);
		SHADE_PROOF_LIGHT(shade_phong(sin2_r, n));
		SHADE_PROOF_LIGHT(shade_phong_modified(sin2_r, cosine, n));
		SHADE_PROOF_LIGHT(shade_blinn_phong(sin2_h, n));
		SHADE_PROOF_LIGHT(shade_blinn_phong_modified(sin2_h, cosine, n));
	}
}

static const struct CMUnitTest properties[] = {
	cmocka_unit_test(rows_are_normalised),
	cmocka_unit_test(bounds_enclose_their_factors),
	cmocka_unit_test(exponents_come_back),
	cmocka_unit_test(every_lobe_is_light),
};

int main(void)
{
	return SHADE_PROOF_RUN(exactness, properties);
}
