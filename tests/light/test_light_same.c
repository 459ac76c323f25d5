/* The lists have the same bits with any number of threads and any instruction set. */
#include "light_reference.h"

#define POOLS 5u
#define LIGHTS 3000u

static stilb_scene_light lights[LIGHTS];

static void build(stilb_light_lists *lists, const stilb_light_grid *grid, stilb_isa isa, stilb_job_pool *pool)
{
	stilb_light_lists_build(lists, grid, lights, 0, NULL, 0, NULL, 0); /* makes the scratch */
	lists->scratch->kernels = light_kernels_for(isa);
	lists->scratch->serial_below = 0;
	assert_int_equal(stilb_light_lists_build(lists, grid, lights, LIGHTS, NULL, 0, pool, 0), STILB_OK);
}

static void assert_same(const stilb_light_lists *a, const stilb_light_lists *b)
{
	size_t cells = (size_t)a->columns * a->rows * a->slices;
	assert_int_equal(a->light_count, b->light_count);
	assert_int_equal(a->everywhere_count, b->everywhere_count);
	assert_int_equal(a->id_count, b->id_count);
	assert_int_equal(a->left_out, b->left_out);
	assert_memory_equal(a->lights, b->lights, a->light_count * sizeof *a->lights);
	assert_memory_equal(a->starts, b->starts, (cells + 1) * sizeof *a->starts);
	assert_memory_equal(a->ids, b->ids, a->id_count * sizeof *a->ids);
}

static void test_same_bits(void **state)
{
	(void)state;
	light_random random = {.seed = 5};
	stilb_job_pool *pools[POOLS];
	for (uint32_t p = 0; p < POOLS; p++) {
		stilb_job_pool_desc desc = {.worker_count = p};
		assert_int_equal(stilb_job_pool_create(&desc, &pools[p]), 0);
	}
	stilb_light_lists reference = {0}, lists = {0};
	uint32_t views = TEST_TSAN || TEST_ASAN ? 4 : 10;
	for (uint32_t v = 0; v < views; v++) {
		for (uint32_t i = 0; i < LIGHTS; i++)
			lights[i] = draw_light(&random, 10.0, v % 3 == 0 ? 4.0 : 1.0);
		stilb_light_grid grid = draw_grid(&random, 10.0);
		grid.tolerance = v % 2 ? 0.01f : 0.0f;
		build(&reference, &grid, STILB_ISA_SCALAR, NULL);
		assert_sound(&reference, LIGHTS);
		for (stilb_isa isa = STILB_ISA_SCALAR; isa <= stilb_cpu_widest_isa(); isa++)
			for (uint32_t p = 0; p < POOLS; p++) {
				build(&lists, &grid, isa, pools[p]);
				assert_same(&reference, &lists);
			}
	}
	stilb_light_lists_finish(&reference);
	stilb_light_lists_finish(&lists);
	for (uint32_t p = 0; p < POOLS; p++)
		stilb_job_pool_destroy(pools[p]);
}

/* Lists hold no more than 1.5 times their content, also after views that needed more or less; small ones 4 KiB more. */
static void test_memory_follows_the_content(void **state)
{
	(void)state;
	light_random random = {.seed = 6};
	stilb_light_lists lists = {0};
	for (uint32_t i = 0; i < LIGHTS; i++)
		lights[i] = draw_light(&random, 10.0, 1.0);
	for (uint32_t v = 0; v < 20; v++) {
		stilb_light_grid grid = draw_grid(&random, 10.0);
		assert_int_equal(stilb_light_lists_build(&lists, &grid, lights, LIGHTS, NULL, 0, NULL, 0), STILB_OK);
		const struct light_scratch *scratch = lists.scratch;
		double cells = (double)lists.columns * lists.rows * lists.slices;
		assert_true((double)scratch->id_capacity <= 1.5 * (double)lists.id_count + 1100.0);
		assert_true((double)scratch->start_capacity <= 1.5 * cells + 1100.0);
		assert_true((double)scratch->light_capacity <= 1.5 * (double)lists.light_count + 1100.0);
	}
	stilb_light_lists_finish(&lists);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(test_same_bits),
		test_one_thread(test_memory_follows_the_content),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
