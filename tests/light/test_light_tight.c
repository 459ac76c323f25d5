/* The lists are not much longer than they must be: of the pairs of light and cell, counted is the share of which a
 * point of the cell, out of many that lie evenly in it, is reached. */
#include "light_reference.h"

#define LIGHTS 120u
#define SIDE 7  /* points along the sides of a cell */
#define DEEP 13 /* and along its depth */

static stilb_scene_light lights[LIGHTS];

static bool cell_is_reached(const stilb_light_lists *lists, const stilb_light_grid *grid, uint32_t cell,
                            const stilb_scene_light *light)
{
	uint32_t x = cell % lists->columns, y = cell / lists->columns % lists->rows;
	uint32_t z = cell / lists->columns / lists->rows;
	double near_z = reference_depth(lists, z), far_z = reference_depth(lists, z + 1);
	double corners[2] = {fmin((x + 1.0) * grid->tile, grid->width), fmin((y + 1.0) * grid->tile, grid->height)};
	for (int i = 0; i < SIDE * SIDE * DEEP; i++) {
		double u = (i % SIDE) / (SIDE - 1.0), v = (i / SIDE % SIDE) / (SIDE - 1.0);
		double t = i / (SIDE * SIDE) / (DEEP - 1.0), point[3];
		double px = x * (double)grid->tile * (1.0 - u) + corners[0] * u;
		double py = y * (double)grid->tile * (1.0 - v) + corners[1] * v;
		reference_place(lists, grid, 2.0 * px / grid->width - 1.0, 2.0 * py / grid->height - 1.0,
		                near_z * (1.0 - t) + far_z * t, point);
		if (reference_sends(light, point) > 0.0)
			return true;
	}
	return false;
}

/* Pairs over those that are reached. The last slice is left out: it has no end. */
static double excess(stilb_scene_light_kind kind, uint64_t seed)
{
	light_random random = {.seed = seed};
	stilb_light_lists lists = {0};
	stilb_light_grid grid = {.width = 1280, .height = 720, .tile = 32, .slices = 16, .first = 1.0f, .last = 20.0f};
	stilb_mat4 view = stilb_mat4_view(stilb_vec3_make(0.0f, 0.0f, 12.0f), 0.0f, 0.0f);
	grid.view_projection = stilb_mat4_multiply(stilb_mat4_perspective(1.0f, 1280.0f / 720.0f, 0.1f, 100.0f), view);
	for (uint32_t i = 0; i < LIGHTS; i++) {
		lights[i] = draw_light(&random, 8.0, 2.0);
		lights[i].kind = kind;
		lights[i].use = STILB_SCENE_LIGHT_LIVE;
		lights[i].falloff = STILB_SCENE_LIGHT_RANGED;
		lights[i].cos_outer = (float)draw(&random, 0.6, 0.95);
		lights[i].cos_inner = lights[i].cos_outer;
	}
	assert_int_equal(stilb_light_lists_build(&lists, &grid, lights, LIGHTS, NULL, 0, NULL, 0), STILB_OK);
	uint32_t pairs = 0, reached = 0, cells = lists.columns * lists.rows * (lists.slices - 1);
	for (uint32_t cell = 0; cell < cells; cell++)
		for (uint32_t i = lists.starts[cell]; i < lists.starts[cell + 1]; i++) {
			pairs++;
			reached += cell_is_reached(&lists, &grid, cell, &lights[lists.lights[lists.ids[i]]]);
		}
	printf("kind %u: %u pairs, %u reached: %.3f\n", kind, pairs, reached, (double)pairs / reached);
	assert_true(reached > 1000);
	stilb_light_lists_finish(&lists);
	return (double)pairs / reached;
}

static void test_spheres(void **state)
{
	(void)state;
	assert_true(excess(STILB_SCENE_LIGHT_POINT, 10) < 1.1);
}

static void test_cones(void **state)
{
	(void)state;
	assert_true(excess(STILB_SCENE_LIGHT_SPOT, 11) < 1.6);
	assert_true(excess(STILB_SCENE_LIGHT_DISK, 12) < 1.2);
}

int main(void)
{
	struct CMUnitTest tests[] = {cmocka_unit_test(test_spheres), cmocka_unit_test(test_cones)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
