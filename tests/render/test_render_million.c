/* A million draws: none is dropped, in any mode, with and without workers. Small frames before and after are complete,
 * also if memory ran out in between, and all memory is freed. The linker sends allocations here (--wrap), to let the
 * large ones fail. */
#include "support/render_fixture.h"
#include "support/test.h"

#include <malloc.h>
#include <stddef.h>

#define MODELS (TEST_ASAN ? 200000u : 500000u)
#define DRAWS (2 * MODELS)

/* Allocations of more bytes fail. Relaxed: only the value matters. */
static _Atomic size_t allocation_most = SIZE_MAX;

void *__real_stilb_memory_alloc(size_t count, size_t size);
void *__wrap_stilb_memory_alloc(size_t count, size_t size);

void *__wrap_stilb_memory_alloc(size_t count, size_t size)
{
	size_t most = atomic_load_explicit(&allocation_most, memory_order_relaxed);
	return count * size <= most ? __real_stilb_memory_alloc(count, size) : NULL;
}

static stilb_scene *scene;
static uint32_t *ids;
static uint64_t hash_all, hash_few;

static const stilb_render_pass one_pass = {.name = "main"}, sorted_pass = {.name = "sorted", .sort = true};
static const stilb_render_view one_view;

static int make(void **state)
{
	(void)state;
	scene = fixture_scene(MODELS);
	ids = fixture_ids(MODELS);
	hash_all = reference_hash_models(REFERENCE_HASH_PASS, scene, ids, MODELS);
	hash_few = reference_hash_models(REFERENCE_HASH_PASS, scene, ids, 5);
	return 0;
}

static int give_back(void **state)
{
	(void)state;
	free(ids);
	stilb_scene_destroy(scene);
	return 0;
}

static stilb_result try_draw(stilb_render *render, const stilb_render_pass *pass, uint32_t models, stilb_job_pool *pool)
{
	stilb_result result = stilb_render_frame_begin(render);
	if (result == STILB_OK)
		result = stilb_render_record(render, 0, scene, ids, models, pool, 0);
	return result == STILB_OK ? stilb_render_replay(render, pass, 1, &one_view, 1, pool, 0) : result;
}

static void draw(stilb_render *render, const stilb_render_pass *pass, uint32_t models, stilb_job_pool *pool)
{
	assert_int_equal(try_draw(render, pass, models, pool), STILB_OK);
	assert_true(stilb_render_stats_get(render).draws == 2 * (uint64_t)models);
}

/* Bytes allocated by the process. */
static size_t memory_in_use(void)
{
	struct mallinfo2 info = mallinfo2();
	return info.uordblks + info.hblkhd;
}

static void a_million_draws(uint32_t workers, int replay)
{
	stilb_job_pool *pool = fixture_pool(workers, (stilb_job_hooks){0});
	size_t before = memory_in_use();
	stilb_render *render = fixture_render(workers + 1, replay, STILB_RENDER_MATERIALS_INDEX);
	assert_int_equal(stilb_render_set_scene(render, scene), STILB_OK);
	/* The frame's memory is too small: most draws are first written to the heap. */
	draw(render, &one_pass, MODELS, pool);
	assert_true(stilb_render_stream_hash(render) == hash_all);
	stilb_render_stats stats = stilb_render_stats_get(render);
	bool indirect = replay == STILB_RENDER_REPLAY_INDIRECT;
	assert_true(stats.recorded_bytes == 32ull * DRAWS && stats.draw_commands == (indirect ? 0 : DRAWS));
	draw(render, &one_pass, 5, pool);
	assert_true(stilb_render_stream_hash(render) == hash_few);
	/* It has grown: draws are written in place. All sort keys are equal, so sorting keeps the order. */
	draw(render, indirect ? &sorted_pass : &one_pass, MODELS, pool);
	assert_true(stilb_render_stream_hash(render) == hash_all);
	for (uint32_t i = 0; i <= workers; i++)
		assert_int_equal(render->contexts[i].overflow_count, 0);
	draw(render, &one_pass, 5, pool);
	assert_true(stilb_render_stream_hash(render) == hash_few);
	stilb_render_destroy(render);
	if (!TEST_ASAN) /* sanitizers keep freed memory for a while */
		assert_in_range(memory_in_use(), 0, before + (1u << 20));
	stilb_job_pool_destroy(pool);
}

static void nothing_is_dropped(void **state)
{
	(void)state;
	for (uint32_t workers = 0; workers <= 3; workers += 3)
		for (int replay = 0; replay < FIXTURE_REPLAYS; replay++)
			a_million_draws(workers, replay);
}

/* A small frame before or after a large one succeeds, also if the large one had no memory. */
static void too_much_for_the_memory(void **state)
{
	(void)state;
	size_t enough_for_few = 8u << 20;
	stilb_job_pool *pool = fixture_pool(1, (stilb_job_hooks){0});
	for (int replay = 0; replay < FIXTURE_REPLAYS; replay++) {
		stilb_render *render = fixture_render(2, replay, STILB_RENDER_MATERIALS_INDEX);
		assert_int_equal(stilb_render_set_scene(render, scene), STILB_OK);
		draw(render, &one_pass, 5, pool); /* the scene's own memory is there */
		atomic_store_explicit(&allocation_most, enough_for_few, memory_order_relaxed);
		for (int frame = 0; frame < 9; frame++) {
			if (frame == 6) /* the one large frame that has memory */
				atomic_store_explicit(&allocation_most, SIZE_MAX, memory_order_relaxed);
			if (frame % 3 == 0)
				assert_int_equal(try_draw(render, &one_pass, MODELS, pool), frame < 6 ? STILB_ERROR_MEMORY : STILB_OK);
			else
				draw(render, &one_pass, 5, pool);
			atomic_store_explicit(&allocation_most, enough_for_few, memory_order_relaxed);
			assert_true(frame % 3 == 0 || stilb_render_stream_hash(render) == hash_few);
		}
		atomic_store_explicit(&allocation_most, SIZE_MAX, memory_order_relaxed);
		stilb_render_destroy(render);
	}
	stilb_job_pool_destroy(pool);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(nothing_is_dropped),
		cmocka_unit_test(too_much_for_the_memory),
	};
	return cmocka_run_group_tests(tests, make, give_back);
}
