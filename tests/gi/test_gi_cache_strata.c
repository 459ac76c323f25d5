/* What a hemisphere of rays says: irradiance and its derivatives against closed forms, and against their own
 * differences. */
#include "gi/cache/gi_cache_strata.h"
#include "support/test.h"

#include <math.h>
#include <stdlib.h>

#define RAYS 4096
#define TRIES 16 /* gathers with different random numbers, whose mean is compared */

/* Radiance of one direction, in the surface's frame, and the distance of what is there. */
typedef gi_cache_cell surroundings(stilb_vec3 direction, const float *parameters);

static gi_cache_gathered gather(const gi_cache_strata *strata, surroundings *at, const float *parameters, uint64_t seed)
{
	uint32_t count = gi_cache_strata_cells(strata);
	gi_cache_cell *cells = stilb_memory_alloc(count, sizeof *cells);
	for (uint32_t i = 0; i < count; i++) {
		stilb_vec2 u = {stilb_random_float(seed, 2 * i), stilb_random_float(seed, 2 * i + 1)};
		cells[i] = at(gi_cache_strata_direction(strata, i, u), parameters);
	}
	gi_cache_gathered gathered = gi_cache_strata_gather(strata, cells);
	free(cells);
	return gathered;
}

typedef struct derivatives {
	double irradiance, rotation[2], translation[2], hessian[3], nearness;
} derivatives;

/* Irradiance and its derivatives, of the first colour channel, as means over all tries. */
static derivatives mean(surroundings *at, const float *parameters)
{
	gi_cache_strata strata;
	assert_int_equal(gi_cache_strata_create(RAYS, &strata), STILB_OK);
	derivatives sum = {0};
	for (uint64_t seed = 0; seed < TRIES; seed++) {
		gi_cache_gathered one = gather(&strata, at, parameters, seed);
		sum.irradiance += (double)one.irradiance[0] / TRIES;
		sum.nearness += (double)one.nearness / TRIES;
		for (int i = 0; i < 2; i++) {
			sum.rotation[i] += (double)one.rotation[i][0] / TRIES;
			sum.translation[i] += (double)one.translation[i][0] / TRIES;
		}
		for (int i = 0; i < 3; i++)
			sum.hessian[i] += (double)one.hessian[i] / TRIES;
	}
	gi_cache_strata_destroy(&strata);
	return sum;
}

static void expect(double value, double truth, double tolerance, const char *what)
{
	if (!(fabs(value - truth) <= tolerance))
		fail_msg("%s: %.5f, not %.5f +- %.5f", what, value, truth, tolerance);
}

/* A wall of radiance 1 across the direction at angle parameters[2], at distance parameters[0], of height
 * parameters[1]. */
static gi_cache_cell wall(stilb_vec3 direction, const float *parameters)
{
	float across = direction[0] * cosf(parameters[2]) + direction[1] * sinf(parameters[2]);
	bool hit = across > 0.0f && parameters[0] * direction[2] < parameters[1] * across;
	float radiance = hit ? 1.0f : 0.0f;
	return (gi_cache_cell){{radiance, radiance, radiance}, hit ? across / parameters[0] : 0.0f};
}

static double wall_irradiance(double distance, double height)
{
	return M_PI / 2 * (1 - distance / hypot(distance, height));
}

/* Not where the upper edge is near the zenith, whose rings are wide: the distance across them varies by a tenth. */
static void wall_has_its_gradient_and_hessian(void **state)
{
	(void)state;
	static const float walls[][3] = {{1.0f, 1.0f, 0.7f}, {0.5f, 0.6f, 2.5f}, {2.0f, 1.0f, -1.3f}};
	for (int w = 0; w < 3; w++) {
		const float *p = walls[w];
		double d = (double)p[0], h = (double)p[1], c = cos((double)p[2]), s = sin((double)p[2]), step = 1e-3 * d;
		derivatives got = mean(wall, p);
		expect(got.irradiance, wall_irradiance(d, h), 2e-3, "irradiance");
		double slope = M_PI / 2 * h * h / pow(d * d + h * h, 1.5); /* towards the wall */
		double nearer = wall_irradiance(d - step, h), farther = wall_irradiance(d + step, h);
		expect(slope, (nearer - farther) / (2 * step), 1e-4 * slope, "closed form, by differences");
		expect(got.translation[0], slope * c, 0.05 * slope, "gradient along t");
		expect(got.translation[1], slope * s, 0.05 * slope, "gradient along b");
		double bend = 3 * M_PI / 2 * h * h * d / pow(d * d + h * h, 2.5);
		expect(bend, (nearer + farther - 2 * wall_irradiance(d, h)) / (step * step), 1e-3 * bend, "its differences");
		expect(got.hessian[0], bend * c * c, 0.08 * bend, "hessian tt");
		expect(got.hessian[1], bend * c * s, 0.08 * bend, "hessian tb");
		expect(got.hessian[2], bend * s * s, 0.08 * bend, "hessian bb");
	}
}

/* A sky of radiance 1 over a horizon that is turned by parameters[0] about b. */
static gi_cache_cell sky(stilb_vec3 direction, const float *parameters)
{
	float radiance = direction[0] * sinf(parameters[0]) + direction[2] * cosf(parameters[0]) > 0.0f ? 1.0f : 0.0f;
	return (gi_cache_cell){{radiance, radiance, radiance}, 0.0f};
}

/* Not where the horizon is within the last ring: half of a ring's mean tangent is less than that of its lower half. */
static void sky_has_its_rotational_gradient(void **state)
{
	(void)state;
	for (float angle = 0.5f; angle < 1.5f; angle += 0.3f) {
		derivatives got = mean(sky, &angle);
		double slope = M_PI / 2 * sin((double)angle);
		expect(got.irradiance, M_PI / 2 * (1 + cos((double)angle)), 2e-3, "irradiance");
		expect(got.rotation[0], slope, 0.02 * slope + 1e-3, "turned towards the sky");
		expect(got.rotation[1], 0.0, 0.02 * slope + 1e-3, "turned along the horizon");
		assert_true(got.translation[0] == 0.0 && got.hessian[0] == 0.0); /* nothing is near */
	}
}

/* Radiance 1 from everywhere, from a sphere of radius parameters[0] about the surface. */
static gi_cache_cell furnace(stilb_vec3 direction, const float *parameters)
{
	(void)direction;
	return (gi_cache_cell){{1.0f, 1.0f, 1.0f}, 1.0f / parameters[0]};
}

static void furnace_is_flat(void **state)
{
	(void)state;
	float radius = 3.0f;
	derivatives got = mean(furnace, &radius);
	expect(got.irradiance, M_PI, 1e-5, "irradiance");
	expect(got.nearness, 1.0 / 3.0, 1e-4, "nearness");
	for (int i = 0; i < 2; i++) {
		expect(got.rotation[i], 0.0, 1e-4, "rotation");
		expect(got.translation[i], 0.0, 0.0, "translation");
	}
}

/* tan(theta) of a single ray in the outer ring has no bound, so its square has no mean; the ring's is below 2. */
static void rings_bound_the_tangent(void **state)
{
	(void)state;
	gi_cache_strata strata;
	assert_int_equal(gi_cache_strata_create(65536, &strata), STILB_OK);
	double total = 0.0;
	for (uint32_t i = 0; i < strata.ring_count; i++)
		total += (double)strata.rings[i].tangent / strata.ring_count;
	expect(total, M_PI / 2, 1e-4, "mean of tan(theta) over projected area");
	assert_true(strata.rings[strata.ring_count - 1].tangent < 2.0f * sqrtf((float)strata.ring_count));
	gi_cache_strata_destroy(&strata);
}

static void cells_do_not_exceed_the_rays(void **state)
{
	(void)state;
	for (uint32_t rays = 16; rays < 5000; rays += 7) {
		gi_cache_strata strata;
		assert_int_equal(gi_cache_strata_create(rays, &strata), STILB_OK);
		uint32_t cells = gi_cache_strata_cells(&strata);
		assert_true(cells <= rays && cells >= rays - rays / 4);
		gi_cache_strata_destroy(&strata);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(wall_has_its_gradient_and_hessian),
		cmocka_unit_test(sky_has_its_rotational_gradient),
		cmocka_unit_test(furnace_is_flat),
		cmocka_unit_test(rings_bound_the_tangent),
		cmocka_unit_test(cells_do_not_exceed_the_rays),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
