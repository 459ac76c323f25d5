/* What a tolerance leaves out of a cell sends no more than it to any point of the cell, all lights together, whatever
 * the material: also a glossy one, whose BRDF times cosine is as high as the peak. */
#include "light_reference.h"

#define LIGHTS 400u
#define POINTS 400u

static stilb_scene_light lights[LIGHTS];

/* The most that a surface at the point can show of the light, W sr^-1 m^-2. */
static double shows(const stilb_light_grid *grid, const stilb_scene_light *light, const float point[3],
                    light_random *random)
{
	double exact[3] = {(double)point[0], (double)point[1], (double)point[2]};
	double intensity = (double)fmaxf(fmaxf(light->intensity[0], light->intensity[1]), light->intensity[2]);
	double most = intensity * reference_sends(light, exact);
	shade_light shaded = scene_light_shade(light);
	stilb_vec3 at = stilb_vec3_make(point[0], point[1], point[2]);
	shade_sun sun = shade_light_at(shaded, at);
	for (int c = 0; c < 3; c++)
		most = fmax(most, (double)sun.irradiance[c]);
	for (int i = 0; i < 4 && shade_light_is_sized(shaded.kind); i++) {
		float n[3];
		draw_direction(random, n);
		stilb_vec3 normal = i == 0 ? sun.direction : stilb_vec3_make(n[0], n[1], n[2]);
		stilb_vec3 irradiance = shade_area_irradiance(shaded, at, normal);
		for (int c = 0; c < 3; c++)
			most = fmax(most, (double)irradiance[c]);
	}
	return most * (double)grid->peak;
}

static void check_tolerance(uint64_t seed, uint32_t views, bool physical)
{
	light_random random = {.seed = seed};
	stilb_light_lists lists = {0};
	uint32_t left_out = 0, checked = 0;
	double nearest = 0.0;
	for (uint32_t v = 0; v < views; v++) {
		for (uint32_t i = 0; i < LIGHTS; i++) {
			lights[i] = draw_light(&random, 10.0, 4.0);
			lights[i].use = STILB_SCENE_LIGHT_LIVE;
			lights[i].falloff = physical ? STILB_SCENE_LIGHT_PHYSICAL : lights[i].falloff;
			for (int c = 0; c < 3 && physical; c++)
				lights[i].intensity[c] *= 1e-3f;
		}
		stilb_light_grid grid = draw_grid(&random, 10.0);
		grid.tolerance = (float)exp2(draw(&random, -8.0, 2.0));
		grid.peak = (float)draw(&random, 0.32, 20.0);
		assert_int_equal(stilb_light_lists_build(&lists, &grid, lights, LIGHTS, NULL, 0, NULL, 0), STILB_OK);
		left_out += lists.left_out > 0;
		for (uint32_t p = 0; p < POINTS; p++) {
			double exact[3], sum = 0.0;
			uint32_t pixel[2];
			reference_place(&lists, &grid, draw(&random, -1.0, 1.0), draw(&random, -1.0, 1.0),
			                10.0 * exp2(draw(&random, -6.0, 1.0)), exact);
			float point[3] = {(float)exact[0], (float)exact[1], (float)exact[2]};
			if (!reference_pixel(&grid, exact, pixel))
				continue;
			uint32_t cell = reference_cell(&lists, &grid, pixel, point);
			for (uint32_t i = 0; i < LIGHTS; i++) {
				double most = shows(&grid, &lights[i], point, &random);
				if (most > 0.0 && !lists_have(&lists, cell, i))
					sum += most;
			}
			if (sum > (double)grid.tolerance)
				fail_msg("view %u: lights that are left out show %g, the tolerance is %g", v, sum,
				         (double)grid.tolerance);
			nearest = fmax(nearest, sum / (double)grid.tolerance);
			checked++;
		}
	}
	printf("%u points, at most %.2f of the tolerance\n", checked, nearest);
	assert_true(checked > views * POINTS / 4 && left_out > views / 2);
	assert_true(!physical || nearest > 0.05); /* the tolerance is made use of */
	stilb_light_lists_finish(&lists);
}

static void test_lights_that_end(void **state)
{
	(void)state;
	check_tolerance(7, TEST_ASAN ? 4 : 12, false);
}

static void test_physical_lights(void **state)
{
	(void)state;
	check_tolerance(8, TEST_ASAN ? 4 : 12, true);
}

/* A light's reach for an irradiance: beyond it no surface gets more, and within it the light sends about that much. */
static void test_reach(void **state)
{
	(void)state;
	light_random random = {.seed = 14};
	stilb_light_grid grid = {.peak = 1.0f};
	for (uint32_t i = 0; i < 4000; i++) {
		stilb_scene_light light = draw_light(&random, 1.0, 4.0);
		light.falloff = (stilb_scene_light_falloff)draw_below(&random, STILB_SCENE_LIGHT_FALLOFFS);
		if (light.kind == STILB_SCENE_LIGHT_DIRECTIONAL)
			continue;
		float direction[3], point[3],
			brightest = fmaxf(fmaxf(light.intensity[0], light.intensity[1]), light.intensity[2]);
		double irradiance = (double)brightest * exp2(draw(&random, -10.0, 10.0)) / (double)(light.reach * light.reach);
		double reach = light_reach(&light, irradiance), beyond = reach * draw(&random, 1.0, 2.0);
		draw_direction(&random, direction);
		for (int k = 0; k < 3; k++)
			point[k] = light.position[k] + (float)beyond * direction[k];
		if (shows(&grid, &light, point, &random) > 1.001 * irradiance)
			fail_msg("kind %u, falloff %u: more than %g at %g m, reach %g m", light.kind, light.falloff, irradiance,
			         beyond, reach);
		double inside[3] = {(double)light.position[0] + 0.999 * reach, (double)light.position[1],
		                    (double)light.position[2]};
		if (light.kind == STILB_SCENE_LIGHT_POINT && reach < 0.999 * (double)light.reach)
			assert_true((double)brightest * reference_sends(&light, inside) > 0.99 * irradiance);
	}
}

/* The more is tolerated, the less is in the lists. */
static void test_more_tolerance_is_less_light(void **state)
{
	(void)state;
	light_random random = {.seed = 9};
	stilb_light_lists lists = {0};
	for (uint32_t i = 0; i < LIGHTS; i++)
		lights[i] = draw_light(&random, 10.0, 4.0);
	stilb_light_grid grid = draw_grid(&random, 10.0);
	uint32_t before = UINT32_MAX;
	for (int step = 0; step < 12; step++) {
		grid.tolerance = step == 0 ? 0.0f : 1e-4f * exp2f(2.0f * (float)step);
		assert_int_equal(stilb_light_lists_build(&lists, &grid, lights, LIGHTS, NULL, 0, NULL, 0), STILB_OK);
		uint32_t pairs = lists.id_count + lists.everywhere_count * lists.columns * lists.rows * lists.slices;
		assert_true(pairs <= before);
		before = pairs;
	}
	stilb_light_lists_finish(&lists);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(test_reach),
		cmocka_unit_test(test_lights_that_end),
		cmocka_unit_test(test_physical_lights),
		cmocka_unit_test(test_more_tolerance_is_less_light),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
