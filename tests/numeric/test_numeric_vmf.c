/* numeric_vmf: fits of directions drawn from a known distribution, of few directions by hand, and what is refused. */

#include "numeric/numeric_vmf.h"

#include "shading/shade_frame.h"
#include "shading/shade_sampling.h"
#include "support/shade_proof.h"

#include <string.h>

#define COUNT 40000

static stilb_vec3 directions[COUNT];
static float weights[COUNT];

static shade_vmf fit(const float *of_each, size_t count)
{
	shade_vmf vmf;
	if (stilb_numeric_vmf_fit(directions, of_each, count, &vmf) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return vmf;
}

/* The sharpness that is fitted to n = 40000 samples lies within four standard deviations of the true one. Its variance
 * is 1 / (n L'(sharpness)) with Langevin's function L(x) = coth x - 1 / x, which for sharp lobes is sharpness^2 / n
 * (Mardia and Jupp, "Directional Statistics" (2000)). */
static void samples_give_their_distribution_back(void **state)
{
	(void)state;
	stilb_vec3 axis = stilb_vec3_normalize(stilb_vec3_make(0.3f, -0.8f, 0.5f));
	shade_frame frame = shade_frame_from_normal(axis);
	shade_proof_random random = {.seed = 1};
	for (float sharpness = 0.5f; sharpness < 2e6f; sharpness *= 4.0f) {
		for (int i = 0; i < COUNT; i++) {
			stilb_vec2 u = {shade_proof_uniform(&random), shade_proof_uniform(&random)};
			directions[i] = shade_frame_to_world(frame, shade_sample_vmf(sharpness, u).direction);
		}
		shade_vmf vmf = fit(NULL, COUNT);
		double k = (double)sharpness, sinh_k = sinh(fmin(k, 300.0)), slope = 1.0 / (k * k) - 1.0 / (sinh_k * sinh_k);
		SHADE_PROOF_NEAR(1.0f / vmf.inverse_sharpness, k, 0.0, 4.0 / sqrt(COUNT * slope));
		double off = (double)stilb_vec3_dot(vmf.axis - axis, vmf.axis - axis);
		assert_true(off < 20.0 / COUNT / fmin(k, k * k / 3.0));
	}
}

/* The fit's own mean is the mean of the directions. */
static void few_directions_by_hand(void **state)
{
	(void)state;
	directions[0] = stilb_vec3_make(1.0f, 0.0f, 0.0f);
	directions[1] = stilb_vec3_make(0.0f, 5.0f, 0.0f); /* the length does not matter */
	shade_vmf vmf = fit(NULL, 2);
	double k = (double)vmf.inverse_sharpness, r = sqrt(0.5);
	SHADE_PROOF_NEAR(1.0 / tanh(1.0 / k) - k, r, 1e-6, 0.0);
	SHADE_PROOF_NEAR3(vmf.axis, r, r, 0.0, 1e-6, 0.0);
	weights[0] = 30.0f, weights[1] = 10.0f;
	vmf = fit(weights, 2);
	k = (double)vmf.inverse_sharpness, r = sqrt(0.75 * 0.75 + 0.25 * 0.25);
	SHADE_PROOF_NEAR(1.0 / tanh(1.0 / k) - k, r, 1e-6, 0.0);
	SHADE_PROOF_NEAR3(vmf.axis, 0.75 / r, 0.25 / r, 0.0, 1e-6, 0.0);
	weights[0] = 0.0f;
	vmf = fit(weights, 2);
	assert_true(vmf.inverse_sharpness == 0.0f && vmf.axis[1] == 1.0f);
}

/* Directions that differ by 1e-6 radians: the length of their mean r is less than 1 by 1.25e-13 only. */
static void narrow_bundles_keep_their_width(void **state)
{
	(void)state;
	directions[0] = stilb_vec3_make(0.5e-6f, 0.0f, 1.0f);
	directions[1] = stilb_vec3_make(-0.5e-6f, 0.0f, 1.0f);
	SHADE_PROOF_NEAR(fit(NULL, 2).inverse_sharpness, 1.25e-13, 2e-3, 0.0);
}

static void what_cancels_out_is_even(void **state)
{
	(void)state;
	directions[0] = stilb_vec3_make(1.0f, 0.0f, 0.0f);
	directions[1] = -directions[0];
	shade_vmf vmf = fit(NULL, 2);
	assert_true(vmf.inverse_sharpness > 3000.0f && vmf.inverse_sharpness < 4000.0f);
	assert_true(vmf.axis[2] == 1.0f);
	SHADE_PROOF_NEAR(shade_vmf_density(vmf, directions[0]), 0.25 / M_PI, 1e-3, 0.0);
}

static void refused(const float *of_each, size_t count, const char *why)
{
	shade_vmf vmf = {{1.0f, 2.0f, 3.0f}, 4.0f};
	assert_int_equal(stilb_numeric_vmf_fit(directions, of_each, count, &vmf), STILB_ERROR_ARGUMENT);
	if (!strstr(stilb_error_message(), why))
		fail_msg("\"%s\" does not say \"%s\"", stilb_error_message(), why);
	assert_true(vmf.axis[1] == 2.0f && vmf.inverse_sharpness == 4.0f);
}

static void bad_input_is_refused(void **state)
{
	(void)state;
	for (int i = 0; i < 4; i++) {
		directions[i] = stilb_vec3_make(0.0f, 1.0f, 0.0f);
		weights[i] = 0.0f;
	}
	refused(NULL, 0, "there are none");
	refused(weights, 4, "all weights are 0");
	weights[2] = -1.0f;
	refused(weights, 4, "weight 2 is -1");
	weights[2] = NAN;
	refused(weights, 4, "weight 2 is");
	directions[3][1] = 0.0f;
	refused(NULL, 4, "number 3 is (0, 0, 0)");
	directions[3][0] = INFINITY;
	refused(NULL, 4, "number 3 is (inf");
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(samples_give_their_distribution_back),
		cmocka_unit_test(few_directions_by_hand),
		cmocka_unit_test(narrow_bundles_keep_their_width),
		cmocka_unit_test(what_cancels_out_is_even),
		cmocka_unit_test(bad_input_is_refused),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
