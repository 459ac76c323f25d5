/* All methods give the result of a plain loop over all spheres, in order, with every instruction set and any number of
 * workers, while models move. */
#include "support/cull_reference.h"

#define POOLS 3

static const uint32_t pool_workers[POOLS] = {0, 1, 3};

/* A moving scene, its stilb_cull, and the expected result. */
typedef struct fixture {
	stilb_scene scene;
	stilb_cull *cull;
	stilb_job_pool *pools[POOLS];
	stilb_cull_visible visible;
	uint32_t *expected;
	uint32_t expected_count;
	uint64_t seen; /* models seen, added up over all views */
} fixture;

typedef stilb_sphere sphere_fn(reference_random *random, uint32_t model, uint32_t model_count);

static void fixture_init(fixture *f, uint32_t model_count, sphere_fn *sphere, reference_random *random)
{
	*f = (fixture){.scene = scene_make(model_count)};
	for (uint32_t model = 0; model < model_count; model++)
		scene_set(&f->scene, model, sphere(random, model, model_count));
	assert_int_equal(stilb_cull_create(&f->scene, &f->cull), STILB_OK);
	f->expected = calloc(model_count + 1, sizeof *f->expected);
	assert_non_null(f->expected);
	for (int i = 0; i < POOLS; i++) {
		stilb_job_pool_desc desc = {.worker_count = pool_workers[i]};
		assert_int_equal(stilb_job_pool_create(&desc, &f->pools[i]), 0);
	}
}

static void fixture_finish(fixture *f)
{
	for (int i = 0; i < POOLS; i++)
		stilb_job_pool_destroy(f->pools[i]);
	stilb_cull_visible_finish(&f->visible);
	stilb_cull_destroy(f->cull);
	free(f->expected);
	scene_free(&f->scene);
}

static void assert_run(fixture *f, stilb_cull_method method, const stilb_frustum *frustum, stilb_job_pool *pool)
{
	stilb_cull_visible *visible = &f->visible;
	assert_int_equal(stilb_cull_run(f->cull, method, &f->scene, frustum, pool, 0, visible), STILB_OK);
	assert_int_equal(visible->count, f->expected_count);
	assert_memory_equal(visible->ids, f->expected, f->expected_count * sizeof *f->expected);
	for (uint32_t i = 0; i < visible->capacity / 64 * visible->set_count; i++)
		if (visible->bits[i])
			fail_msg("bits are left in word %u", i);
	assert_true(visible->method == method || (method == STILB_CULL_AUTO && visible->method != STILB_CULL_AUTO));
}

static void use_isa(fixture *f, stilb_isa isa)
{
	f->cull->kernels = f->cull->octree->kernels = cull_kernels_for(isa);
}

/* Checks one view with all methods, instruction sets and pools. always_parallel: small scenes are spread over the
 * workers too. */
static void assert_view(fixture *f, const stilb_frustum *frustum, bool always_parallel)
{
	f->expected_count = 0;
	for (uint32_t model = 0; model < f->scene.model_count; model++)
		if (reference_visible(scene_get(&f->scene, model), frustum))
			f->expected[f->expected_count++] = model;
	f->seen += f->expected_count;
	f->cull->serial_below = always_parallel ? 0 : CULL_SERIAL_BELOW;
	for (stilb_isa isa = STILB_ISA_SCALAR; isa <= stilb_cpu_widest_isa(); isa++) {
		use_isa(f, isa);
		for (int i = 0; i < POOLS; i++) {
			assert_run(f, STILB_CULL_OCTREE, frustum, f->pools[i]);
			assert_run(f, STILB_CULL_FLAT, frustum, f->pools[i]);
		}
		assert_run(f, STILB_CULL_AUTO, frustum, f->pools[0]);
	}
}

static void move_tenth(fixture *f, sphere_fn *sphere, reference_random *random)
{
	uint32_t count = 0, model_count = f->scene.model_count;
	uint32_t *moved = calloc(model_count + 1, sizeof *moved);
	assert_non_null(moved);
	for (uint32_t model = random_below(random, 10); model < model_count; model += 10) {
		scene_set(&f->scene, model, sphere(random, model, model_count));
		moved[count++] = model;
	}
	assert_int_equal(stilb_cull_update(f->cull, &f->scene, moved, count), STILB_OK);
	free(moved);
}

static void run_views(uint32_t model_count, float extent, uint32_t views, sphere_fn *sphere, uint64_t seed)
{
	fixture f;
	reference_random random = {.seed = seed};
	if (TEST_TSAN)
		views = 4 + views / 10;
	fixture_init(&f, model_count, sphere, &random);
	for (uint32_t view = 0; view < views; view++) {
		stilb_frustum frustum = random_view(&random, extent);
		assert_view(&f, &frustum, view % 2);
		move_tenth(&f, sphere, &random);
	}
	assert_null(cull_octree_check(f.cull->octree));
	uint64_t all = (uint64_t)model_count * views;
	assert_true(f.seen > all / 200 && f.seen < all); /* the views see some models and not all */
	fixture_finish(&f);
}

/* ---- a thousand views ------------------------------------------------------------------------------------------- */

static void test_views_of_a_grid(void **state)
{
	(void)state;
	run_views(5000, 70.0f, 300, grid_sphere, 1);
}

/* A sphere anywhere, of any size from a point to as large as the whole scene. */
static stilb_sphere cloud_sphere(reference_random *random, uint32_t model, uint32_t model_count)
{
	(void)model, (void)model_count;
	return (stilb_sphere){random_between(random, -50.0f, 50.0f), random_between(random, -50.0f, 50.0f),
	                      random_between(random, -50.0f, 50.0f),
	                      exp2f(random_between(random, -10.0f, 6.5f)) - 0x1p-10f};
}

static void test_views_of_a_cloud(void **state)
{
	(void)state;
	run_views(3000, 50.0f, 300, cloud_sphere, 2);
}

/* Most models in one place, some far away, one in ten with NaN, infinite or negative bounds. */
static stilb_sphere crowd_sphere(reference_random *random, uint32_t model, uint32_t model_count)
{
	(void)model, (void)model_count;
	uint32_t kind = random_below(random, 20);
	if (kind < 2)
		return random_strange_sphere(random, 30.0f);
	float reach = kind == 2 ? 3000.0f : 5.0f;
	return (stilb_sphere){random_between(random, -reach, reach), random_between(random, -reach, reach),
	                      random_between(random, -reach, reach), random_between(random, 0.0f, 1.0f)};
}

static void test_views_of_a_crowd(void **state)
{
	(void)state;
	run_views(2000, 10.0f, 250, crowd_sphere, 3);
}

/* Points and balls at integer coordinates: many lie on faces of cells. */
static stilb_sphere lattice_sphere(reference_random *random, uint32_t model, uint32_t model_count)
{
	(void)model_count;
	float x = (float)(model % 16) - 8.0f, y = (float)(model / 16 % 16) - 8.0f, z = (float)(model / 256) - 8.0f;
	return (stilb_sphere){x, y, z, (float)random_below(random, 3) * 0.5f};
}

static void test_views_of_a_lattice(void **state)
{
	(void)state;
	run_views(4097, 8.0f, 150, lattice_sphere, 4);
}

/* Large enough for several threads with the default CULL_SERIAL_BELOW. */
static void test_views_of_a_large_grid(void **state)
{
	(void)state;
	run_views(CULL_SERIAL_BELOW + 1000, 360.0f, 10, grid_sphere, 5);
}

/* ---- degenerate cases ------------------------------------------------------------------------------------------- */

/* Planes that touch the spheres of a lattice exactly: distance >= -radius, so these are visible. */
static void test_touching_is_visible(void **state)
{
	(void)state;
	fixture f;
	reference_random random = {.seed = 6};
	fixture_init(&f, 4096, lattice_sphere, &random);
	for (int round = 0; round < 50; round++) {
		float low[3], high[3];
		for (int axis = 0; axis < 3; axis++) {
			low[axis] = (float)random_below(&random, 20) * 0.5f - 9.0f;
			high[axis] = low[axis] + (float)random_below(&random, 10) * 0.5f;
		}
		stilb_frustum frustum = box_view(low, high);
		assert_view(&f, &frustum, round % 2);
	}
	float low[3] = {-9.0f, -9.0f, -9.0f}, high[3] = {-8.0f, 9.0f, 9.0f};
	stilb_frustum face = box_view(low, high);
	assert_view(&f, &face, false);
	uint32_t expected = 16 * 16;                    /* the layer x = -8 ... */
	for (uint32_t model = 0; model < 4096; model++) /* ... and the balls of radius 1 at x = -7 */
		expected += f.scene.bounds.x[model] == -7.0f && f.scene.bounds.radius[model] == 1.0f;
	assert_int_equal(f.expected_count, expected);
	fixture_finish(&f);
}

/* Numbers of models around multiples of 64 (a word of bits) and of CULL_CHUNK, with one stilb_cull_visible used for all
 * of them. */
static void test_counts_around_chunks(void **state)
{
	(void)state;
	uint32_t counts[] = {8193, 0, 1, 7, 8, 9, 63, 64, 65, 4095, 4096, 4097, 8192};
	float low[3] = {-1e6f, -1e6f, -1e6f}, high[3] = {1e6f, 1e6f, 1e6f}, half[3] = {1e6f, 1e6f, 0.0f};
	stilb_cull_visible visible = {0};
	for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
		fixture f;
		reference_random random = {.seed = 7};
		fixture_init(&f, counts[i], grid_sphere, &random);
		f.visible = visible;
		stilb_frustum all = box_view(low, high), some = box_view(low, half), none = box_view(half, high);
		none.planes[1].distance = -2e6f;
		for (int parallel = 0; parallel < 2; parallel++) {
			assert_view(&f, &all, parallel);
			assert_int_equal(f.expected_count, counts[i]);
			assert_view(&f, &some, parallel);
			assert_view(&f, &none, parallel);
			assert_int_equal(f.expected_count, 0);
		}
		assert_run(&f, STILB_CULL_FLAT, &none, NULL); /* without a pool */
		visible = f.visible;
		f.visible = (stilb_cull_visible){0};
		fixture_finish(&f);
	}
	stilb_cull_visible_finish(&visible);
}

static stilb_sphere same_sphere(reference_random *random, uint32_t model, uint32_t model_count)
{
	(void)random, (void)model, (void)model_count;
	return (stilb_sphere){1e6f, 1.0f, -3.0f, 0.0f};
}

static stilb_sphere nan_sphere(reference_random *random, uint32_t model, uint32_t model_count)
{
	(void)random, (void)model_count;
	stilb_sphere sphere = {0.0f, 0.0f, 0.0f, 1.0f};
	((float *)&sphere)[model % 4] = (float)NAN;
	return sphere;
}

static stilb_sphere infinite_sphere(reference_random *random, uint32_t model, uint32_t model_count)
{
	(void)random, (void)model_count;
	return (stilb_sphere){(float)model * 1e30f, 0.0f, 0.0f, INFINITY};
}

static void test_scenes_without_shape(void **state)
{
	(void)state;
	const struct {
		sphere_fn *sphere;
		uint32_t visible;
	} cases[] = {{same_sphere, 500}, {nan_sphere, 0}, {infinite_sphere, 500}};
	float low[3] = {-2e6f, -2e6f, -2e6f}, high[3] = {2e6f, 2e6f, 2e6f};
	stilb_frustum all = box_view(low, high);
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		fixture f;
		reference_random random = {.seed = 8};
		fixture_init(&f, 500, cases[i].sphere, &random);
		assert_null(cull_octree_check(f.cull->octree));
		assert_view(&f, &all, false);
		assert_int_equal(f.expected_count, cases[i].visible);
		for (int view = 0; view < 20; view++) {
			stilb_frustum frustum = random_view(&random, 10.0f);
			assert_view(&f, &frustum, view % 2);
			move_tenth(&f, cloud_sphere, &random);
		}
		fixture_finish(&f);
	}
}

/* A finished view is empty and may be finished or used again; NULL is accepted. */
static void test_finished_views(void **state)
{
	(void)state;
	fixture f;
	reference_random random = {.seed = 9};
	fixture_init(&f, 300, cloud_sphere, &random);
	stilb_frustum frustum = random_view(&random, 50.0f);
	for (int use = 0; use < 2; use++) {
		assert_view(&f, &frustum, false);
		assert_non_null(f.visible.ids);
		for (int again = 0; again < 2; again++) {
			stilb_cull_visible_finish(&f.visible);
			assert_null(f.visible.ids);
			assert_int_equal(f.visible.capacity, 0);
		}
	}
	fixture_finish(&f);
	stilb_cull_visible_finish(NULL);
	stilb_cull_destroy(NULL);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(test_views_of_a_grid),       cmocka_unit_test(test_views_of_a_cloud),
		cmocka_unit_test(test_views_of_a_crowd),      cmocka_unit_test(test_views_of_a_lattice),
		cmocka_unit_test(test_views_of_a_large_grid), cmocka_unit_test(test_touching_is_visible),
		cmocka_unit_test(test_counts_around_chunks),  cmocka_unit_test(test_scenes_without_shape),
		cmocka_unit_test(test_finished_views),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
