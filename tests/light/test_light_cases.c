/* Scenes and arguments at the ends of their ranges, one light at a time, and no memory. The linker sends the module's
 * calls of stilb_memory_alloc here (--wrap), to let them fail. */
#include "light_reference.h"

static uint32_t allocations_left = UINT32_MAX;

void *__real_stilb_memory_alloc(size_t count, size_t size);
void *__wrap_stilb_memory_alloc(size_t count, size_t size);

void *__wrap_stilb_memory_alloc(size_t count, size_t size)
{
	if (allocations_left == 0)
		return NULL;
	allocations_left -= allocations_left != UINT32_MAX;
	return __real_stilb_memory_alloc(count, size);
}

/* A camera at the origin that looks along -Z, 90 degrees wide and high. */
static stilb_light_grid square_grid(void)
{
	return (stilb_light_grid){.view_projection = stilb_mat4_perspective(1.5707963f, 1.0f, 0.1f, 100.0f),
	                          .width = 256,
	                          .height = 256,
	                          .tile = 32,
	                          .slices = 8,
	                          .first = 1.0f,
	                          .last = 64.0f};
}

static stilb_scene_light point_light(float x, float y, float z, float reach)
{
	return (stilb_scene_light){.kind = STILB_SCENE_LIGHT_POINT,
	                           .position = {x, y, z},
	                           .direction = {0.0f, -1.0f, 0.0f},
	                           .intensity = {1.0f, 2.0f, 3.0f},
	                           .cos_inner = 0.9f,
	                           .cos_outer = 0.8f,
	                           .radius = 0.1f * reach,
	                           .half_x = {0.1f * reach, 0.0f, 0.0f},
	                           .half_y = {0.0f, 0.0f, 0.1f * reach},
	                           .reach = reach,
	                           .falloff = STILB_SCENE_LIGHT_WINDOWED};
}

static void build(stilb_light_lists *lists, const stilb_light_grid *grid, const stilb_scene_light *lights,
                  uint32_t count)
{
	assert_int_equal(stilb_light_lists_build(lists, grid, lights, count, NULL, 0, NULL, 0), STILB_OK);
	assert_sound(lists, count);
}

static void test_no_light(void **state)
{
	(void)state;
	stilb_light_lists lists = {0};
	stilb_light_grid grid = square_grid();
	build(&lists, &grid, NULL, 0);
	assert_int_equal(lists.light_count, 0);
	assert_int_equal(lists.id_count, 0);
	assert_int_equal(lists.columns * lists.rows * lists.slices, 512);
	stilb_scene_light lights[4] = {point_light(0, 0, 5, 3), point_light(0, 0, -5, 3), point_light(0, 0, -5, 3),
	                               point_light(0, 0, -5, 3)};
	lights[1].use = STILB_SCENE_LIGHT_BAKED; /* the first is behind the camera */
	memset(lights[2].intensity, 0, sizeof lights[2].intensity);
	lights[3].kind = STILB_SCENE_LIGHT_DIRECTIONAL;
	memset(lights[3].intensity, 0, sizeof lights[3].intensity);
	build(&lists, &grid, lights, 4);
	assert_int_equal(lists.light_count, 0);
	grid.tolerance = 0.1f;
	grid.peak = 1.0f;
	build(&lists, &grid, lights, 4);
	assert_int_equal(lists.light_count, 0);
	stilb_light_lists_finish(&lists);
	assert_null(lists.ids);
	stilb_light_lists_finish(NULL);
}

static void test_one_cell(void **state)
{
	(void)state;
	stilb_light_lists lists = {0};
	stilb_light_grid grid = square_grid();
	grid.width = grid.height = grid.slices = 1;
	grid.first = grid.last = NAN; /* not read */
	stilb_scene_light lights[3] = {point_light(0, 0, -5, 3), point_light(0, 0, 5, 3), point_light(0, 0, 5, 6)};
	build(&lists, &grid, lights, 3);
	assert_int_equal(lists.id_count, 2);
	assert_int_equal(lists.lights[lists.ids[0]], 0);
	assert_int_equal(lists.lights[lists.ids[1]], 2);
	stilb_light_lists_finish(&lists);
}

/* Lights that reach everywhere stand first, in order; the camera is inside one that reaches every cell. */
static void test_everywhere(void **state)
{
	(void)state;
	stilb_light_lists lists = {0};
	stilb_light_grid grid = square_grid();
	stilb_scene_light lights[5];
	for (uint32_t i = 0; i < 5; i++)
		lights[i] = point_light(0, 0, -5, i == 2 ? 1e8f : 1.0f);
	lights[1].kind = STILB_SCENE_LIGHT_DIRECTIONAL;
	lights[3].falloff = STILB_SCENE_LIGHT_PHYSICAL;
	build(&lists, &grid, lights, 5);
	assert_int_equal(lists.everywhere_count, 2);
	assert_int_equal(lists.lights[0], 1);
	assert_int_equal(lists.lights[1], 3);
	assert_int_equal(lists.light_count, 5);
	for (uint32_t cell = 0; cell < 512; cell++)
		assert_true(lists_have(&lists, cell, 2));
	assert_true(lists.id_count < 512 + 200); /* the small ones reach few */
	grid.tolerance = 0.01f;
	grid.peak = 1.0f;
	build(&lists, &grid, lights, 5); /* ends the lamp, not the sun */
	assert_int_equal(lists.everywhere_count, 1);
	assert_true(lists.left_out > 0);
	stilb_light_lists_finish(&lists);
}

/* More lights in one place than are worked on at a time: each cell has all of them, or none. */
static void test_many_in_one_place(void **state)
{
	(void)state;
	enum { MANY = 5000 };
	static stilb_scene_light lights[MANY];
	stilb_light_lists lists = {0};
	stilb_light_grid grid = square_grid();
	for (uint32_t i = 0; i < MANY; i++)
		lights[i] = point_light(0, 0, -5, 3);
	build(&lists, &grid, lights, 1);
	uint32_t one = lists.id_count;
	build(&lists, &grid, lights, MANY);
	assert_int_equal(lists.id_count, one * MANY);
	for (uint32_t cell = 0; cell < 512; cell++) {
		uint32_t length = lists.starts[cell + 1] - lists.starts[cell];
		assert_true(length == 0 || length == MANY);
	}
	stilb_light_lists_finish(&lists);
}

static void test_candidates(void **state)
{
	(void)state;
	stilb_light_lists lists = {0}, all = {0};
	stilb_light_grid grid = square_grid();
	stilb_scene_light lights[40];
	uint32_t candidates[20];
	for (uint32_t i = 0; i < 40; i++) {
		lights[i] = point_light((float)i - 20.0f, 0, i % 2 ? -20.0f : 20.0f, 2.0f);
		candidates[i / 2] = i / 2 * 2 + 1;
	}
	build(&all, &grid, lights, 40);
	assert_int_equal(stilb_light_lists_build(&lists, &grid, lights, 40, candidates, 20, NULL, 0), STILB_OK);
	assert_int_equal(lists.light_count, all.light_count);
	assert_memory_equal(lists.lights, all.lights, all.light_count * sizeof *all.lights);
	assert_memory_equal(lists.ids, all.ids, all.id_count * sizeof *all.ids);
	assert_int_equal(stilb_light_lists_build(&lists, &grid, lights, 40, candidates, 0, NULL, 0), STILB_OK);
	assert_int_equal(lists.light_count, 0);
	stilb_light_lists_finish(&lists);
	stilb_light_lists_finish(&all);
}

/* ---- one light --------------------------------------------------------------------------------------------------- */

static void test_bounds(void **state)
{
	(void)state;
	stilb_scene_light light = point_light(1, 2, 3, 4);
	stilb_light_bounds bounds = stilb_light_bounds_of(&light);
	assert_true(bounds.sphere.x == 1.0f && bounds.sphere.radius > 4.0f && bounds.sphere.radius < 4.001f);
	assert_true(bounds.cos_angle == -1.0f);
	light.falloff = STILB_SCENE_LIGHT_PHYSICAL;
	assert_true(isinf(stilb_light_bounds_of(&light).sphere.radius));
	light.kind = STILB_SCENE_LIGHT_DIRECTIONAL;
	assert_true(isinf(stilb_light_bounds_of(&light).sphere.radius));
	memset(light.intensity, 0, sizeof light.intensity);
	assert_true(stilb_light_bounds_of(&light).sphere.radius == -1.0f);
	light = point_light(1, 2, 3, 4);
	light.kind = STILB_SCENE_LIGHT_SPOT;
	bounds = stilb_light_bounds_of(&light);
	assert_true(bounds.cos_angle < 0.8f && bounds.cos_angle > 0.799f);
	assert_true(bounds.sphere.radius < 2.6f && bounds.sphere.y < 0.0f); /* 4 / (2 * 0.8), below the light */
	assert_true(bounds.apex[1] > 2.0f && bounds.axis[1] == -1.0f);
	light.kind = STILB_SCENE_LIGHT_DISK;
	bounds = stilb_light_bounds_of(&light);
	assert_true(bounds.cos_angle < 0.0f && bounds.cos_angle > -0.001f && bounds.sphere.radius < 4.001f);
	light.reach = 1e-9f; /* no distance counts as less than 0.1 mm */
	assert_true(stilb_light_bounds_of(&light).sphere.radius > 0.99e-4f);
}

/* Two spots under each other: the cells of the upper one's cone only, none of its back. */
static void test_cone(void **state)
{
	(void)state;
	stilb_light_lists lists = {0};
	stilb_light_grid grid = square_grid();
	stilb_scene_light light = point_light(0, 0, -10, 5);
	build(&lists, &grid, &light, 1);
	uint32_t sphere = lists.id_count;
	light.kind = STILB_SCENE_LIGHT_DISK;
	build(&lists, &grid, &light, 1);
	uint32_t disk = lists.id_count;
	light.kind = STILB_SCENE_LIGHT_SPOT;
	build(&lists, &grid, &light, 1);
	for (uint32_t cell = 0; cell < 512; cell++) /* rows 0 to 2 are above the light by more than a metre */
		if (cell / 8 % 8 < 3)
			assert_int_equal(lists.starts[cell], lists.starts[cell + 1]);
	assert_true(lists.id_count < disk && disk < sphere && lists.id_count > 0);
	stilb_light_lists_finish(&lists);
}

/* ---- mistakes ---------------------------------------------------------------------------------------------------- */

static void refused(const stilb_light_grid *grid, const char *words)
{
	stilb_light_lists lists = {0};
	stilb_scene_light light = point_light(0, 0, -5, 3);
	assert_int_equal(stilb_light_lists_build(&lists, grid, &light, 1, NULL, 0, NULL, 0), STILB_ERROR_ARGUMENT);
	if (!strstr(stilb_error_message(), words))
		fail_msg("'%s' does not say '%s'", stilb_error_message(), words);
	assert_true(lists.light_count == 0 && lists.id_count == 0 && lists.columns == 0);
	stilb_light_lists_finish(&lists);
}

#define REFUSED(MEMBER, VALUE, WORDS)                                                                                  \
	do {                                                                                                               \
		stilb_light_grid wrong = square_grid();                                                                        \
		wrong.peak = 1.0f;                                                                                             \
		wrong.MEMBER = VALUE;                                                                                          \
		refused(&wrong, WORDS);                                                                                        \
	} while (0)

static void test_arguments(void **state)
{
	(void)state;
	REFUSED(width, 0, "sides");
	REFUSED(height, 16385, "sides");
	REFUSED(tile, 4, "tile");
	REFUSED(tile, 2048, "tile");
	REFUSED(tile, 48, "tile");
	REFUSED(slices, 0, "slices");
	REFUSED(slices, 129, "slices");
	REFUSED(first, 0.0f, "first slice");
	REFUSED(first, NAN, "first slice");
	REFUSED(last, 1.0f, "last slice");
	REFUSED(last, INFINITY, "last slice");
	REFUSED(tolerance, -1.0f, "tolerance");
	REFUSED(tolerance, NAN, "tolerance");
	REFUSED(view_projection.m[3], NAN, "finite");
	REFUSED(view_projection, (stilb_mat4){0}, "perspective");
	stilb_light_grid grid = square_grid();
	grid.tolerance = 0.1f;
	refused(&grid, "peak");
}

/* ---- the ends of ranges ------------------------------------------------------------------------------------------ */

/* Huge and tiny places, reaches and views: no list is unsound, and a light at a visible point is in its cell. */
static void test_extremes(void **state)
{
	(void)state;
	light_random random = {.seed = 12};
	stilb_light_lists lists = {0};
	for (uint32_t v = 0; v < 300; v++) {
		stilb_light_grid grid = draw_grid(&random, 1.0);
		float scale = (float)pow(10.0, draw(&random, -4.0, 17.0));
		if (v % 2)
			grid.view_projection =
				stilb_mat4_multiply(grid.view_projection, stilb_mat4_scale_translate(1.0f / scale, 0.0f, 0.0f, 0.0f));
		stilb_scene_light lights[20];
		for (uint32_t i = 0; i < 20; i++) {
			lights[i] = draw_light(&random, (double)scale, (double)scale * pow(10.0, draw(&random, -5.0, 5.0)));
			lights[i].reach = fminf(lights[i].reach, 1e18f);
		}
		build(&lists, &grid, lights, 20);
		for (uint32_t i = 0; i < 20; i++) {
			const float *p = lights[i].position;
			double exact[3] = {(double)p[0], (double)p[1], (double)p[2]};
			uint32_t pixel[2];
			if (lights[i].use == STILB_SCENE_LIGHT_BAKED || !reference_pixel(&grid, exact, pixel))
				continue;
			assert_true(lists_have(&lists, reference_cell(&lists, &grid, pixel, p), i));
		}
	}
	stilb_light_lists_finish(&lists);
}

static void test_no_memory(void **state)
{
	(void)state;
	light_random random = {.seed = 13};
	static stilb_scene_light lights[600];
	for (uint32_t i = 0; i < 600; i++)
		lights[i] = draw_light(&random, 10.0, 3.0);
	stilb_light_grid grid = square_grid();
	uint32_t needed = 0;
	for (stilb_result result = STILB_ERROR_MEMORY; result != STILB_OK; needed++) {
		stilb_light_lists lists = {0};
		allocations_left = needed;
		result = stilb_light_lists_build(&lists, &grid, lights, 600, NULL, 0, NULL, 0);
		if (result != STILB_OK) {
			assert_int_equal(result, STILB_ERROR_MEMORY);
			assert_true(lists.light_count == 0 && lists.everywhere_count == 0 && lists.id_count == 0);
			if (lists.scratch) { /* the next call works with what is there */
				allocations_left = UINT32_MAX;
				build(&lists, &grid, lights, 600);
				assert_true(lists.id_count > 0);
			}
		} else { /* and another one needs none */
			allocations_left = 0;
			build(&lists, &grid, lights, 600);
		}
		allocations_left = UINT32_MAX;
		stilb_light_lists_finish(&lists);
	}
	assert_true(needed > 12);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(test_no_light),   cmocka_unit_test(test_one_cell),
		cmocka_unit_test(test_everywhere), cmocka_unit_test(test_many_in_one_place),
		cmocka_unit_test(test_candidates), cmocka_unit_test(test_bounds),
		cmocka_unit_test(test_cone),       cmocka_unit_test(test_arguments),
		cmocka_unit_test(test_extremes),   cmocka_unit_test(test_no_memory),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
