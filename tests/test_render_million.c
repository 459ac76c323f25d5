/* A million draws: none is dropped, in any mode, with and without workers; small frames before and after are as ever, and all
 * memory is given back. */
#include "support/render_fixture.h"

#include <malloc.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#define MODELS 500000u
#define DRAWS (2 * MODELS)

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
	hash_all = reference_hash_models(REFERENCE_HASH_START, scene, ids, MODELS);
	hash_few = reference_hash_models(REFERENCE_HASH_START, scene, ids, 5);
	return 0;
}

static int give_back(void **state)
{
	(void)state;
	free(ids);
	stilb_scene_destroy(scene);
	return 0;
}

static void draw(stilb_render *render, const stilb_render_pass *pass, uint32_t models, stilb_job_pool *pool)
{
	assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
	assert_int_equal(stilb_render_record(render, 0, scene, ids, models, pool, 0), STILB_OK);
	assert_int_equal(stilb_render_replay(render, pass, 1, &one_view, 1, pool, 0), STILB_OK);
	assert_true(stilb_render_stats_get(render).draws == 2 * (uint64_t)models);
}

/* Bytes that the process has asked for and not given back. */
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
	assert_int_equal(stilb_render_upload_scene(render, scene), STILB_OK);
	draw(render, &one_pass, MODELS, pool); /* most of it through the heap */
	assert_true(stilb_render_stream_hash(render) == hash_all);
	stilb_render_stats stats = stilb_render_stats_get(render);
	bool indirect = replay == STILB_RENDER_REPLAY_INDIRECT;
	assert_true(stats.recorded_bytes == 96ull * DRAWS && stats.draw_commands == (indirect ? 0 : DRAWS));
	draw(render, &one_pass, 5, pool);
	assert_true(stilb_render_stream_hash(render) == hash_few);
	draw(render, indirect ? &sorted_pass : &one_pass, MODELS, pool); /* in place now; all keys are equal */
	assert_true(stilb_render_stream_hash(render) == hash_all);
	for (uint32_t i = 0; i <= workers; i++)
		assert_int_equal(render->contexts[i].overflow_count, 0);
	draw(render, &one_pass, 5, pool);
	assert_true(stilb_render_stream_hash(render) == hash_few);
	stilb_render_destroy(render);
	if (!FIXTURE_SANITIZED) /* they keep what is freed */
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

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(nothing_is_dropped)};
	return cmocka_run_group_tests(tests, make, give_back);
}
