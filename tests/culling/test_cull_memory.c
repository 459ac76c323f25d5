/* Culling without memory: every allocation fails once, nothing is lost, and the next call works.
 * The linker sends the module's calls of stilb_memory_alloc here (--wrap), to let them fail. */
#include "support/cull_reference.h"

#define OBJECTS 400u

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

static stilb_sphere random_sphere(reference_random *random)
{
	return (stilb_sphere){random_between(random, -60.0f, 60.0f), random_between(random, -60.0f, 60.0f),
	                      random_between(random, -60.0f, 60.0f), exp2f(random_between(random, -6.0f, 7.0f))};
}

static void assert_objects(const stilb_cull_octree *octree, const stilb_sphere *spheres, const bool *present)
{
	assert_null(cull_octree_check(octree));
	for (uint32_t id = 0; id < OBJECTS; id++) {
		cull_place place = id < octree->place_capacity ? octree->places[id] : (cull_place){0};
		assert_int_equal(place.cell_plus_one != 0, present[id]);
		if (!present[id])
			continue;
		const cull_cell *cell = &octree->cells[place.cell_plus_one - 1];
		stilb_sphere found = {cell->x[place.slot], cell->y[place.slot], cell->z[place.slot], cell->radius[place.slot]};
		assert_memory_equal(&found, &spheres[id], sizeof found);
	}
}

static void test_octree_keeps_what_it_had(void **state)
{
	(void)state;
	stilb_cull_octree_desc desc = {{0.0f, 0.0f, 0.0f}, 64.0f, 8};
	stilb_cull_octree *octree;
	for (allocations_left = 0; stilb_cull_octree_create(&desc, &octree) != STILB_OK;) {
		assert_null(octree);
		static uint32_t tries;
		allocations_left = ++tries;
	}
	reference_random random = {.seed = 1};
	stilb_sphere spheres[OBJECTS];
	bool present[OBJECTS] = {false};
	uint32_t failures = 0;
	for (int step = 0; step < 3000; step++) {
		uint32_t id = random_below(&random, OBJECTS);
		stilb_sphere sphere = random_sphere(&random);
		allocations_left = random_below(&random, 3);
		stilb_result result =
			present[id] ? stilb_cull_octree_move(octree, id, sphere) : stilb_cull_octree_insert(octree, id, sphere);
		if (result == STILB_OK) {
			spheres[id] = sphere;
			present[id] = true;
		} else {
			assert_int_equal(result, STILB_ERROR_MEMORY);
			failures++;
		}
		if (step % 20 == 0 || result != STILB_OK)
			assert_objects(octree, spheres, present);
		if (random_below(&random, 3) == 0) {
			stilb_cull_octree_remove(octree, id);
			present[id] = false;
		}
	}
	assert_true(failures > 100);
	allocations_left = UINT32_MAX;
	stilb_cull_octree_destroy(octree);
}

static void test_mark_fails_clean(void **state)
{
	(void)state;
	stilb_cull_octree_desc desc = {{0.0f, 0.0f, 0.0f}, 64.0f, 4};
	stilb_cull_octree *octree;
	uint64_t bits[OBJECTS / 64 + 1] = {0}, zero[OBJECTS / 64 + 1] = {0};
	reference_random random = {.seed = 2};
	float low[3] = {-1e3f, -1e3f, -1e3f}, high[3] = {1e3f, 1e3f, 1e3f};
	stilb_frustum all = box_view(low, high);
	assert_int_equal(stilb_cull_octree_create(&desc, &octree), STILB_OK);
	for (uint32_t id = 0; id < OBJECTS; id++)
		assert_int_equal(stilb_cull_octree_insert(octree, id, random_sphere(&random)), STILB_OK);
	allocations_left = 0;
	assert_int_equal(stilb_cull_octree_mark(octree, &all, bits), STILB_ERROR_MEMORY);
	assert_memory_equal(bits, zero, sizeof bits);
	allocations_left = UINT32_MAX;
	assert_int_equal(stilb_cull_octree_mark(octree, &all, bits), STILB_OK);
	for (uint32_t id = 0; id < OBJECTS; id++)
		assert_true(reference_bit(bits, id));
	stilb_cull_octree_destroy(octree);
}

/* Lets 0, 1, 2, ... allocations of a creation and of a run succeed, until they are enough: with fewer the call returns
 * the error and loses nothing. */
static void test_create_and_run_fail_clean(void **state)
{
	(void)state;
	reference_random random = {.seed = 3};
	stilb_scene scene = scene_make(OBJECTS);
	for (uint32_t model = 0; model < OBJECTS; model++)
		scene_set(&scene, model, random_sphere(&random));
	stilb_cull *cull = NULL;
	uint32_t needed = 0;
	for (; !cull; needed++) {
		allocations_left = needed;
		stilb_result result = stilb_cull_create(&scene, &cull);
		assert_int_equal(result, cull ? STILB_OK : STILB_ERROR_MEMORY);
	}
	assert_true(needed > 5);

	/* A view that sees all models without holding the octree's root cell wholly: so the octree is walked. */
	float low[3] = {-1e3f, -1e3f, -1e3f}, high[3] = {60.0f, 60.0f, 60.0f};
	stilb_frustum all = box_view(low, high);
	stilb_cull_visible visible = {0};
	for (uint32_t budget = 0; budget < 5; budget++) { /* too few for: ids, bits, chunk counts, items, families */
		allocations_left = budget;
		stilb_result result = stilb_cull_run(cull, STILB_CULL_OCTREE, &scene, &all, NULL, 0, &visible);
		assert_int_equal(result, STILB_ERROR_MEMORY);
		assert_int_equal(visible.count, 0);
		stilb_cull_visible_finish(&visible);
	}
	allocations_left = 5;
	assert_int_equal(stilb_cull_run(cull, STILB_CULL_OCTREE, &scene, &all, NULL, 0, &visible), STILB_OK);
	assert_int_equal(visible.count, OBJECTS);
	allocations_left = 0; /* the buffers have grown: no allocation is needed */
	assert_int_equal(stilb_cull_run(cull, STILB_CULL_OCTREE, &scene, &all, NULL, 0, &visible), STILB_OK);
	assert_int_equal(stilb_cull_run(cull, STILB_CULL_FLAT, &scene, &all, NULL, 0, &visible), STILB_OK);
	assert_int_equal(visible.count, OBJECTS);
	allocations_left = UINT32_MAX;
	stilb_cull_visible_finish(&visible);
	stilb_cull_destroy(cull);
	scene_free(&scene);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(test_octree_keeps_what_it_had),
		cmocka_unit_test(test_mark_fails_clean),
		cmocka_unit_test(test_create_and_run_fail_clean),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
