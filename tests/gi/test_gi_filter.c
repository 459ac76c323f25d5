/* gi_filter_offset: places are spread as the filters' weights: the share of a filter below the place of u is u. */
#include "support/shade_proof.h"

#include "gi/film/gi_camera.h"
#include "numeric/numeric_quadrature.h"

#define RADIUS 1.5

static double gaussian(double x, const void *context)
{
	(void)context;
	return exp(-2.0 * x * x); /* sigma 0.5 */
}

static double blackman_harris(double x, const void *context)
{
	(void)context;
	double t = M_PI * x / RADIUS;
	return 0.35875 + 0.48829 * cos(t) + 0.14128 * cos(2.0 * t) + 0.01168 * cos(3.0 * t);
}

static void assert_spread(stilb_gi_filter_kind kind, stilb_numeric_function *weight, double radius)
{
	double whole = stilb_numeric_integrate(weight, NULL, -radius, radius, 4);
	float before = -2.0f;
	for (int i = 0; i <= 1000; i++) {
		float u = fminf((float)i / 1000.0f, 0x1.fffffep-1f);
		stilb_vec2 place = gi_filter_offset(kind, (stilb_vec2){u, 1.0f - 0x1p-24f - u});
		double x = (double)place[0];
		assert_true(fabs(x) <= radius && place[0] >= before);
		SHADE_PROOF_NEAR(stilb_numeric_integrate(weight, NULL, -radius, x, 4) / whole, u, 0.0, 3e-6);
		SHADE_PROOF_NEAR(stilb_numeric_integrate(weight, NULL, -radius, (double)place[1], 4) / whole, 1.0 - (double)u,
		                 0.0, 3e-6);
		before = place[0];
	}
}

static double box(double x, const void *context)
{
	(void)x, (void)context;
	return 1.0;
}

static void places_are_spread_as_the_weights(void **state)
{
	(void)state;
	assert_spread(STILB_GI_FILTER_BOX, box, 0.5);
	assert_spread(STILB_GI_FILTER_GAUSSIAN, gaussian, RADIUS);
	assert_spread(STILB_GI_FILTER_BLACKMAN_HARRIS, blackman_harris, RADIUS);
}

/* Numbers next to both ends of [0, 1), where the densities run out. */
static void ends_stay_inside(void **state)
{
	(void)state;
	static const float ends[] = {0.0f, 0x1p-24f, 1e-6f, 1e-5f, 1e-4f};
	for (int kind = 0; kind < STILB_GI_FILTER_COUNT; kind++)
		for (int i = 0; i < 5; i++) {
			double radius = kind == STILB_GI_FILTER_BOX ? 0.5 : RADIUS;
			stilb_vec2 place =
				gi_filter_offset((stilb_gi_filter_kind)kind, (stilb_vec2){ends[i], 0x1.fffffep-1f - ends[i]});
			assert_true((double)place[0] >= -radius && place[0] < 0.0f);
			assert_true((double)place[1] <= radius && place[1] > 0.0f);
		}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(places_are_spread_as_the_weights),
		cmocka_unit_test(ends_stay_inside),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
