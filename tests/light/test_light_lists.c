/* No light is missing: random points that a light reaches, in random views, against double precision. */
#include "light_reference.h"

#define LIGHTS 300u
#define POINTS 2000u    /* near the ends of lights */
#define VIEW_POINTS 60u /* anywhere in a view */

static stilb_scene_light lights[LIGHTS];

/* A point that the light may reach: often near where its reach, its cone or its half space ends. */
static void draw_point(light_random *random, const stilb_scene_light *light, float point[3])
{
	float direction[3], reach = light->falloff == STILB_SCENE_LIGHT_PHYSICAL ? 20.0f : light->reach;
	draw_direction(random, direction);
	if (light->kind == STILB_SCENE_LIGHT_SPOT && draw_below(random, 2) == 0) { /* near the cone */
		double along = 0.0, cosine = (double)light->cos_outer + draw(random, 0.0, 0.02), length = 0.0, axis = 0.0;
		cosine = fmin(cosine, 1.0);
		for (int i = 0; i < 3; i++) {
			along += (double)direction[i] * (double)light->direction[i];
			axis += (double)light->direction[i] * (double)light->direction[i];
		}
		double across[3];
		for (int i = 0; i < 3; i++) {
			across[i] = (double)direction[i] - along / axis * (double)light->direction[i];
			length += across[i] * across[i];
		}
		for (int i = 0; i < 3; i++)
			direction[i] = (float)(cosine * (double)light->direction[i] / sqrt(axis) +
			                       sqrt(1.0 - cosine * cosine) * across[i] / sqrt(length));
	}
	double share = draw_below(random, 2) ? cbrt(draw(random, 0.0, 1.0)) : draw(random, 0.98, 1.0);
	for (int i = 0; i < 3; i++)
		point[i] = light->position[i] + direction[i] * (float)((double)reach * share);
}

static uint32_t check_point(const stilb_light_lists *lists, const stilb_light_grid *grid, uint32_t index,
                            const float point[3])
{
	const stilb_scene_light *light = &lights[index];
	double exact[3] = {(double)point[0], (double)point[1], (double)point[2]};
	uint32_t pixel[2];
	bool sends = reference_sends(light, exact) > 0.0;
	if (!sends) /* most are far away */
		for (int i = 0; i < 3; i++)
			sends = sends || fabs(exact[i] - (double)light->position[i]) < 1.001 * (double)light->reach;
	if (!sends || light->use == STILB_SCENE_LIGHT_BAKED)
		return 0;
	shade_sun sun = shade_light_at(scene_light_shade(light), stilb_vec3_make(point[0], point[1], point[2]));
	sends = reference_sends(light, exact) > 0.0 || sun.irradiance[0] > 0.0f || sun.irradiance[1] > 0.0f ||
	        sun.irradiance[2] > 0.0f;
	if (!sends || !reference_pixel(grid, exact, pixel))
		return 0;
	uint32_t cell = reference_cell(lists, grid, pixel, point);
	if (!lists_have(lists, cell, index))
		fail_msg("light %u of kind %u is missing in cell %u (pixel %u, %u) of %u x %u x %u", index, light->kind, cell,
		         pixel[0], pixel[1], lists->columns, lists->rows, lists->slices);
	return 1;
}

/* All lights at points that the view shows somewhere. */
static uint32_t check_view(light_random *random, const stilb_light_lists *lists, const stilb_light_grid *grid,
                           double extent)
{
	uint32_t checked = 0;
	for (uint32_t i = 0; i < VIEW_POINTS; i++) {
		double exact[3], nx = draw(random, -1.0, 1.0), ny = draw(random, -1.0, 1.0);
		reference_place(lists, grid, nx, ny, extent * exp2(draw(random, -8.0, 1.5)), exact);
		float point[3] = {(float)exact[0], (float)exact[1], (float)exact[2]};
		for (uint32_t k = 0; k < LIGHTS; k++)
			checked += check_point(lists, grid, k, point);
	}
	return checked;
}

static void run_views(uint64_t seed, uint32_t views, double extent)
{
	light_random random = {.seed = seed};
	stilb_light_lists lists = {0};
	uint32_t checked = 0;
	for (uint32_t v = 0; v < views; v++) {
		for (uint32_t i = 0; i < LIGHTS; i++)
			lights[i] = draw_light(&random, extent, 0.3 * extent);
		stilb_light_grid grid = draw_grid(&random, extent);
		assert_int_equal(stilb_light_lists_build(&lists, &grid, lights, LIGHTS, NULL, 0, NULL, 0), STILB_OK);
		assert_sound(&lists, LIGHTS);
		checked += check_view(&random, &lists, &grid, extent);
		for (uint32_t i = 0; i < POINTS; i++) {
			float point[3];
			uint32_t index = draw_below(&random, LIGHTS);
			draw_point(&random, &lights[index], point);
			checked += check_point(&lists, &grid, index, point);
		}
	}
	printf("extent %g: %u points checked\n", extent, checked);
	assert_true(checked > views * 400);
	stilb_light_lists_finish(&lists);
}

static void test_none_is_missing(void **state)
{
	(void)state;
	run_views(1, TEST_ASAN ? 20 : 200, 10.0);
}

static void test_none_is_missing_in_the_small_and_in_the_large(void **state)
{
	(void)state;
	run_views(2, TEST_ASAN ? 4 : 40, 0.05);
	run_views(3, TEST_ASAN ? 4 : 40, 1e6);
}

/* Tiny lights on both sides of where slices end: what a shader rounds there is allowed for. */
static void test_none_is_missing_where_slices_end(void **state)
{
	(void)state;
	light_random random = {.seed = 4};
	stilb_light_lists lists = {0};
	uint32_t checked = 0;
	for (uint32_t v = 0; v < 60; v++) {
		stilb_light_grid grid = draw_grid(&random, 10.0);
		grid.slices = 3 + draw_below(&random, 126);
		grid.last = grid.first * (float)(1.0 + exp2(draw(&random, -8.0, 6.0)));
		assert_int_equal(stilb_light_lists_build(&lists, &grid, NULL, 0, NULL, 0, NULL, 0), STILB_OK);
		for (uint32_t i = 0; i < LIGHTS; i++) {
			double depth = reference_depth(&lists, 1 + draw_below(&random, grid.slices - 1)), at[3];
			reference_place(&lists, &grid, draw(&random, -1.0, 1.0), draw(&random, -1.0, 1.0),
			                depth * (1.0 + draw(&random, -2e-7, 2e-7)), at);
			lights[i] = draw_light(&random, 1.0, 1e-6 * depth);
			lights[i].use = STILB_SCENE_LIGHT_LIVE;
			for (int k = 0; k < 3; k++)
				lights[i].position[k] = (float)at[k];
		}
		assert_int_equal(stilb_light_lists_build(&lists, &grid, lights, LIGHTS, NULL, 0, NULL, 0), STILB_OK);
		for (uint32_t i = 0; i < LIGHTS; i++)
			checked += check_point(&lists, &grid, i, lights[i].position);
	}
	assert_true(checked > 60 * LIGHTS / 4);
	stilb_light_lists_finish(&lists);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(test_none_is_missing),
		cmocka_unit_test(test_none_is_missing_in_the_small_and_in_the_large),
		cmocka_unit_test(test_none_is_missing_where_slices_end),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
