/* Recording and replay on the null device: the stream of draws follows from the scene alone, whichever worker records
 * which segment (part of a pass) and in which order, and after frames that ran out of memory. The linker sends
 * allocations here (--wrap), to let them fail. */
#include "render/render_internal.h"
#include "support/render_reference.h"
#include "support/test.h"

#include <stddef.h>
#include <stdlib.h>

/* Lists models as moved, though they are where they were: their parts have rows of the frame. */
static void list_moved(stilb_scene *scene, uint32_t models)
{
	for (scene->moved_count = 0; scene->moved_count < models; scene->moved_count++)
		scene->moved[scene->moved_count] = scene->moved_count;
}

/* ---- memory that runs out ---------------------------------------------------------------------------------------- */

/* The number of further allocations that succeed; several workers decrement it. Relaxed: only the number matters. */
static _Atomic int64_t allocations_left = INT64_MAX;
static _Atomic int queue_fails; /* 1: malloc, which only the job queue calls, fails; relaxed too */

void *__real_stilb_memory_alloc(size_t count, size_t size);
void *__wrap_stilb_memory_alloc(size_t count, size_t size);
void *__real_realloc(void *memory, size_t size);
void *__wrap_realloc(void *memory, size_t size);
void *__real_malloc(size_t size);
void *__wrap_malloc(size_t size);

static bool allocation_granted(void)
{
	return atomic_fetch_sub_explicit(&allocations_left, 1, memory_order_relaxed) > 0;
}

static void allocations_allow(int64_t count)
{
	atomic_store_explicit(&allocations_left, count, memory_order_relaxed);
}

void *__wrap_stilb_memory_alloc(size_t count, size_t size)
{
	return allocation_granted() ? __real_stilb_memory_alloc(count, size) : NULL;
}

void *__wrap_realloc(void *memory, size_t size)
{
	return allocation_granted() ? __real_realloc(memory, size) : NULL;
}

void *__wrap_malloc(size_t size)
{
	return atomic_load_explicit(&queue_fails, memory_order_relaxed) ? NULL : __real_malloc(size);
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

static stilb_scene *make_scene(uint32_t models)
{
	stilb_scene *scene;
	assert_int_equal(stilb_scene_create_stress(models, 7, &scene), STILB_OK);
	return scene;
}

static stilb_render *make_render(const stilb_scene *scene, uint32_t contexts, stilb_render_replay_mode replay)
{
	stilb_render_desc desc = {
		.device = STILB_RENDER_DEVICE_NULL, .replay = replay, .width = 64, .height = 64, .context_count = contexts};
	stilb_render *render;
	assert_int_equal(stilb_render_create(&desc, &render), STILB_OK);
	assert_int_equal(stilb_render_set_scene(render, scene), STILB_OK);
	return render;
}

static stilb_job_pool *make_pool(uint32_t workers)
{
	stilb_job_pool_desc desc = {.worker_count = workers};
	stilb_job_pool *pool;
	assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
	return pool;
}

static const stilb_render_pass one_pass[1] = {{.name = "main"}};
static const stilb_render_view one_view[1];

static stilb_result draw_frame(stilb_render *render, const stilb_scene *scene, const uint32_t *ids, uint32_t count,
                               stilb_job_pool *pool)
{
	stilb_result result = stilb_render_frame_begin(render);
	if (result == STILB_OK)
		result = stilb_render_record(render, 0, scene, ids, count, pool, 0);
	if (result == STILB_OK)
		result = stilb_render_replay(render, one_pass, 1, one_view, 1, pool, 0);
	return result == STILB_OK ? stilb_render_present(render) : result;
}

static void assert_frame(stilb_render *render, const stilb_scene *scene, const uint32_t *ids, uint32_t count,
                         stilb_job_pool *pool)
{
	assert_int_equal(draw_frame(render, scene, ids, count, pool), STILB_OK);
	assert_true(stilb_render_stream_hash(render) == reference_hash_models(REFERENCE_HASH_PASS, scene, ids, count));
	assert_true(stilb_render_stats_get(render).draws == 2u * (uint64_t)count);
}

static uint32_t *all_ids(uint32_t count)
{
	uint32_t *ids = calloc(count, sizeof *ids);
	assert_non_null(ids);
	for (uint32_t i = 0; i < count; i++)
		ids[i] = i;
	return ids;
}

/* ---- a scene through the pool ------------------------------------------------------------------------------------ */

static void the_stream_is_the_scenes(void **state)
{
	(void)state;
	static const uint32_t workers[] = {0, 1, 2, 3, 8};
	stilb_scene *scene = make_scene(5000);
	uint32_t *ids = all_ids(5000);
	for (size_t w = 0; w < sizeof workers / sizeof *workers; w++)
		for (uint32_t spare = 0; spare < 20; spare += 19)
			for (int mode = 0; mode < 3; mode++) {
				stilb_job_pool *pool = make_pool(workers[w]);
				stilb_render *render = make_render(scene, workers[w] + 1 + spare, (stilb_render_replay_mode)mode);
				assert_frame(render, scene, ids, 5000, pool);
				assert_frame(render, scene, ids + 1234, 777, pool);
				stilb_render_destroy(render);
				stilb_job_pool_destroy(pool);
			}
	free(ids);
	stilb_scene_destroy(scene);
}

static void commands_are_counted(void **state)
{
	(void)state;
	stilb_scene *scene = make_scene(5000);
	uint32_t *ids = all_ids(5000);
	stilb_job_pool *pool = make_pool(2);
	for (int mode = 0; mode < 3; mode++) {
		bool indirect = mode == STILB_RENDER_REPLAY_INDIRECT, secondary = mode == STILB_RENDER_REPLAY_SECONDARY;
		stilb_render *render = make_render(scene, 3, (stilb_render_replay_mode)mode);
		for (uint32_t count = 5000; count < UINT32_MAX; count = count ? 0 : UINT32_MAX) {
			assert_frame(render, scene, ids, count, pool);
			stilb_render_stats stats = stilb_render_stats_get(render);
			assert_true(stats.draw_commands == (indirect ? 0 : 2u * count));
			/* Indirect replay: one device command for each sequence of chunks that a worker claimed in a row. */
			assert_true(indirect && count > 0 ? stats.indirect_commands >= 1 && stats.indirect_commands <= 20
			                                  : stats.indirect_commands == 0);
			assert_true(stats.execute_commands == (secondary && count > 0 ? 3 : 0));
			assert_true(stats.binds_asked == 6u * count);
			assert_true(stats.binds_sent == (count == 0 ? 0 : secondary ? 6 : 2));
			assert_true(stats.recorded_bytes == 2u * count * 32u);
		}
		assert_true(stilb_render_stream_hash(render) == REFERENCE_HASH_PASS); /* nothing was visible */
		stilb_render_destroy(render);
	}
	stilb_job_pool_destroy(pool);
	free(ids);
	stilb_scene_destroy(scene);
}

/* A subset of the models, ascending; its size changes from frame to frame. */
static uint32_t random_ids(uint32_t *ids, uint32_t models, uint64_t frame)
{
	uint32_t count = 0;
	float share = stilb_random_float(1, frame);
	share *= share;
	for (uint32_t m = 0; m < models; m++)
		if (stilb_random_float(2 + frame, m) < share)
			ids[count++] = m;
	return count;
}

static void a_thousand_frames(void **state)
{
	(void)state;
	uint32_t models = 3000;
	stilb_scene *scene = make_scene(models);
	uint32_t *ids = all_ids(models);
	stilb_job_pool *pool = make_pool(3);
	stilb_render *render = make_render(scene, 4, STILB_RENDER_REPLAY_INDIRECT);
	for (uint64_t frame = 0; frame < (TEST_TSAN ? 40 : 1000); frame++)
		assert_frame(render, scene, ids, random_ids(ids, models, frame), pool);
	stilb_render_destroy(render);
	stilb_job_pool_destroy(pool);
	free(ids);
	stilb_scene_destroy(scene);
}

static void memory_grows_and_stays(void **state)
{
	(void)state;
	/* Models have two draws each: below, far above, exactly at, and just above a new frame's capacity. */
	static const uint32_t counts[] = {5, 20000, 50, 35000, 16384, 16385, 0, 35000, 34999, 35000, 34999};
	stilb_scene *scene = make_scene(35000);
	uint32_t *ids = all_ids(35000);
	list_moved(scene, 35000);
	for (uint32_t workers = TEST_TSAN ? 3 : 0; workers < 4; workers += 3) {
		stilb_job_pool *pool = make_pool(workers);
		stilb_render *render = make_render(scene, workers + 1, STILB_RENDER_REPLAY_INDIRECT);
		for (size_t c = 0; c < sizeof counts / sizeof *counts; c++)
			assert_frame(render, scene, ids, counts[c], pool);
		assert_true(render->memory[RENDER_MEMORY_ROWS].capacity >= 70000);
		assert_true(render->memory[RENDER_MEMORY_COMMANDS].capacity >= 69998);
		for (uint32_t i = 0; i <= workers; i++)
			/* The frame before has made the memory grow, so no claim goes to the heap. */
			assert_int_equal(render->contexts[i].overflow_count, 0);
		stilb_render_destroy(render);
		stilb_job_pool_destroy(pool);
	}
	free(ids);
	stilb_scene_destroy(scene);
}

static void other_context_counts_and_sizes(void **state)
{
	(void)state;
	static const uint32_t workers[] = {3, 0, 8, 1};
	stilb_scene *scene = make_scene(3000);
	uint32_t *ids = all_ids(3000);
	stilb_render *render = make_render(scene, 1, STILB_RENDER_REPLAY_DIRECT);
	for (size_t w = 0; w < sizeof workers / sizeof *workers; w++) {
		stilb_job_pool *pool = make_pool(workers[w]);
		assert_int_equal(stilb_render_set_context_count(render, workers[w] + 1), STILB_OK);
		assert_int_equal(stilb_render_resize(render, 100 + workers[w], 16384), STILB_OK);
		assert_frame(render, scene, ids, 3000, pool);
		uint32_t width, height;
		stilb_render_size(render, &width, &height);
		assert_int_equal(width, 100 + workers[w]);
		assert_int_equal(height, 16384);
		stilb_job_pool_destroy(pool);
	}
	/* Without memory for new contexts the existing ones still work. */
	stilb_job_pool *pool = make_pool(1);
	allocations_allow(0);
	assert_int_equal(stilb_render_set_context_count(render, 9), STILB_ERROR_MEMORY);
	allocations_allow(INT64_MAX);
	assert_frame(render, scene, ids, 3000, pool);
	stilb_job_pool_destroy(pool);
	stilb_render_destroy(render);
	free(ids);
	stilb_scene_destroy(scene);
}

/* ---- by hand ----------------------------------------------------------------------------------------------------- */

typedef struct hand_draw {
	uint32_t mesh, material;
	stilb_mat4 transform;
} hand_draw;

static hand_draw random_draw(const stilb_scene *scene, uint64_t index)
{
	hand_draw draw = {
		.mesh = (uint32_t)(stilb_random_u64(11, index) % scene->mesh_count),
		.material = (uint32_t)(stilb_random_u64(12, index) % scene->material_count),
		.transform = stilb_mat4_identity(),
	};
	for (int column = 0; column < 4; column++)
		for (int row = 0; row < 3; row++)
			draw.transform.m[4 * column + row] =
				stilb_random_float(13, index * 16 + (uint64_t)(4 * column + row)) - 0.5f;
	return draw;
}

/* Draw number d of segment s of pass p. */
static uint64_t hand_index(uint32_t pass, uint32_t segment, uint32_t d)
{
	return ((uint64_t)pass << 40) + ((uint64_t)segment << 20) + d;
}

/* Empty and short segments, and segments longer than one, two and three chunks of commands; some end at a chunk's
 * end. */
static const uint32_t segment_draws[] = {0, 1, 2047, 1, 0, 2048, 5000, 3, 7001, 0, 2048, 2047, 4097, 0};
#define SEGMENTS (sizeof segment_draws / sizeof *segment_draws)

static void hand_record_segment(stilb_render *render, uint32_t worker, const stilb_scene *scene, uint32_t pass,
                                uint32_t s)
{
	stilb_render_context *context = stilb_render_context_get(render, worker);
	stilb_render_segment_begin(context, pass, s);
	for (uint32_t d = 0; d < segment_draws[s]; d++) {
		hand_draw draw = random_draw(scene, hand_index(pass, s, d));
		stilb_render_draw(context, stilb_render_scene_mesh(render, draw.mesh),
		                  stilb_render_scene_material(render, draw.material), &draw.transform);
	}
	stilb_render_segment_end(context);
}

static uint64_t hand_hash(uint64_t hash, const stilb_scene *scene, uint32_t pass)
{
	for (uint32_t s = 0; s < SEGMENTS; s++)
		for (uint32_t d = 0; d < segment_draws[s]; d++) {
			hand_draw draw = random_draw(scene, hand_index(pass, s, d));
			hash = reference_hash_draw(hash, scene, draw.mesh, draw.material, &draw.transform);
		}
	return hash;
}

/* Records the segments of a pass in a random order, each by a random context. */
static void hand_record_pass(stilb_render *render, const stilb_scene *scene, uint32_t pass, uint64_t seed)
{
	uint32_t order[SEGMENTS];
	for (uint32_t s = 0; s < SEGMENTS; s++)
		order[s] = s;
	for (uint32_t s = SEGMENTS - 1; s > 0; s--) {
		uint32_t other = (uint32_t)(stilb_random_u64(seed, s) % (s + 1)), held = order[s];
		order[s] = order[other];
		order[other] = held;
	}
	assert_int_equal(stilb_render_pass_begin(render, pass, SEGMENTS), STILB_OK);
	for (uint32_t s = 0; s < SEGMENTS; s++) {
		uint32_t worker = (uint32_t)(stilb_random_u64(seed, 100 + s) % render->context_count);
		hand_record_segment(render, worker, scene, pass, order[s]);
	}
	assert_int_equal(stilb_render_pass_end(render, pass), STILB_OK);
}

static void segments_in_any_order(void **state)
{
	(void)state;
	stilb_scene *scene = make_scene(50);
	uint64_t expected = hand_hash(REFERENCE_HASH_PASS, scene, 0);
	for (uint32_t contexts = 1; contexts <= 5; contexts++) {
		stilb_render *render = make_render(scene, contexts, STILB_RENDER_REPLAY_INDIRECT);
		for (uint64_t frame = 0; frame < 6; frame++) {
			assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
			hand_record_pass(render, scene, 0, frame);
			assert_int_equal(stilb_render_replay(render, one_pass, 1, one_view, 1, NULL, 0), STILB_OK);
			assert_true(stilb_render_stream_hash(render) == expected);
		}
		stilb_render_destroy(render);
	}
	stilb_scene_destroy(scene);
}

/* ---- the device's view of the stream ----------------------------------------------------------------------------- */

#define SPY_PASSES 4u

/* A device that stands between render and the null device: it lists the passes, and hashes every draw from the data
 * that the device gets. */
static struct {
	gpu_functions functions;
	const gpu_functions *real;
	const stilb_render *render;
	const stilb_scene *scene;
	const stilb_render_pass *table; /* [SPY_PASSES] of the frame; NULL: it has one pass, with an empty view */
	const stilb_render_view *views;
	uint32_t pass_count;
	const stilb_render_pass *passes[SPY_PASSES]; /* as they run */
	uint64_t drawn[SPY_PASSES];
	uint64_t hash;
	uint32_t wrong; /* commands that draw other vertices or indices than their mesh's */
} spy;

static void spy_draw(const render_command *c)
{
	const stilb_scene_mesh *meshes = spy.scene->meshes;
	const render_row *row = render_row_of(spy.render, c);
	stilb_mat4 transform = stilb_mat4_identity();
	for (int i = 0; i < 12; i++)
		transform.m[i % 4 * 4 + i / 4] = row->transform[i];
	spy.hash = reference_hash_draw(spy.hash, spy.scene, row->mesh, row->material, &transform);
	spy.wrong += c->index_count != meshes[row->mesh].index_count || c->material != row->material || c->key != 0;
	uint32_t first = row->mesh == 0 ? 0 : meshes[0].index_count + meshes[0].level_index_count;
	spy.wrong += c->instance_count != 1 || c->first_index != first;
	spy.wrong += c->vertex_offset != (row->mesh == 0 ? 0 : (int32_t)meshes[0].vertex_count);
}

/* The view that a row's constants name holds what the pass's view says. */
static void spy_view(const stilb_gpu_pass *row)
{
	const stilb_render_pass *pass = NULL;
	for (uint32_t p = 0; p < SPY_PASSES; p++)
		pass = strcmp(spy.table[p].name, row->name) == 0 ? &spy.table[p] : pass;
	assert_non_null(pass);
	const stilb_render_view *view = &spy.views[pass->view];
	render_push push;
	memcpy(&push, row->constants, sizeof push);
	const render_view_data *data = (const void *)(uintptr_t)push.view.rest; /* of this device an address here */
	spy.wrong += push.view.added[0] != view->shading.roughness || push.view.added[2] != view->shading.wrap;
	spy.wrong += memcmp(data->view_projection, &view->view_projection, sizeof data->view_projection) != 0;
	spy.passes[spy.pass_count] = pass;
	spy.hash = reference_hash_pass(spy.hash, view);
}

static void spy_list(const stilb_gpu_draws *list)
{
	spy.wrong += list->draws != render_commands(spy.render);
	for (uint32_t r = 0; r < list->run_count; r++) {
		const stilb_gpu_run *run = &list->runs[r];
		for (uint32_t c = 0; c < run->count; c++)
			spy_draw((const render_command *)list->draws + run->first + c);
		spy.drawn[spy.pass_count] += run->count;
		spy.wrong += run->set != 0 || list->has_constants; /* neither textures nor materials to bind */
	}
}

static stilb_result spy_run(stilb_gpu *gpu, const stilb_gpu_plan *plan, const stilb_gpu_draws *lists,
                            uint32_t list_count, const stilb_gpu_threads *threads, const gpu_upload_ready *uploads,
                            uint32_t upload_count)
{
	const stilb_gpu_step *steps;
	uint32_t count = stilb_gpu_plan_steps(plan, &steps);
	for (uint32_t s = 0; s < count; s++) {
		const stilb_gpu_pass *row = stilb_gpu_plan_row(plan, steps[s].pass);
		if (row->kind != STILB_GPU_PASS_DRAWS)
			continue;
		assert_true(spy.pass_count < SPY_PASSES && row->draws < list_count);
		if (spy.table)
			spy_view(row);
		else
			spy.hash = REFERENCE_HASH_PASS;
		spy_list(&lists[row->draws]);
		spy.pass_count++;
	}
	return spy.real->run(gpu, plan, lists, list_count, threads, uploads, upload_count);
}

static void spy_on(stilb_render *render, const stilb_scene *scene, const stilb_render_pass *passes,
                   const stilb_render_view *views)
{
	memset(&spy, 0, sizeof spy);
	spy.real = render->device->gpu->functions;
	spy.functions = *spy.real;
	spy.functions.run = spy_run;
	spy.render = render;
	spy.scene = scene;
	spy.table = passes;
	spy.views = views;
	spy.hash = REFERENCE_HASH_START;
	render->device->gpu->functions = &spy.functions;
}

static void passes_by_their_order(void **state)
{
	(void)state;
	static const stilb_render_pass passes[4] = {
		{.name = "late", .view = 1, .order = 9},
		{.name = "first", .view = 0, .order = 2},
		{.name = "also late", .view = 2, .order = 9},
		{.name = "middle", .view = 1, .order = 5},
	};
	static const uint32_t sequence[4] = {1, 3, 0, 2};
	stilb_render_view views[3] = {0};
	views[1].shading = stilb_render_shading_default();
	views[2].shading.wrap = -0.5f;
	stilb_scene *scene = make_scene(50);
	stilb_render *render = make_render(scene, 3, STILB_RENDER_REPLAY_INDIRECT);
	spy_on(render, scene, passes, views);
	assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
	for (uint32_t p = 4; p-- > 0;)
		hand_record_pass(render, scene, p, p);
	assert_int_equal(stilb_render_replay(render, passes, 4, views, 3, NULL, 0), STILB_OK);
	uint64_t expected = REFERENCE_HASH_START, draws = 0;
	for (uint32_t s = 0; s < SEGMENTS; s++)
		draws += segment_draws[s];
	assert_int_equal(spy.pass_count, 4);
	for (int i = 0; i < 4; i++) {
		expected = reference_hash_pass(expected, &views[passes[sequence[i]].view]);
		expected = hand_hash(expected, scene, sequence[i]);
		assert_ptr_equal(spy.passes[i], &passes[sequence[i]]);
		assert_true(spy.drawn[i] == draws);
	}
	assert_int_equal(spy.wrong, 0);
	assert_true(spy.hash == expected);
	assert_true(stilb_render_stream_hash(render) == expected);
	stilb_render_stats stats = stilb_render_stats_get(render);
	assert_true(stats.draws == 4 * draws && stats.indirect_commands >= 4);
	stilb_render_destroy(render);
	stilb_scene_destroy(scene);
}

static void meshes_and_materials_are_copied(void **state)
{
	(void)state;
	stilb_scene *scene = make_scene(600), *same = make_scene(600);
	uint32_t *ids = all_ids(600);
	stilb_job_pool *pool = make_pool(2);
	stilb_render *render = make_render(scene, 3, STILB_RENDER_REPLAY_INDIRECT);
	for (uint32_t m = 0; m < scene->mesh_count; m++)
		scene->meshes[m].index_count = scene->meshes[m].vertex_count = scene->meshes[m].level_count = 0;
	spy_on(render, same, NULL, NULL);
	assert_int_equal(draw_frame(render, scene, ids, 600, pool), STILB_OK);
	assert_true(spy.hash == reference_hash_models(REFERENCE_HASH_PASS, same, ids, 600));
	assert_int_equal(spy.wrong, 0);
	stilb_render_destroy(render);
	stilb_job_pool_destroy(pool);
	free(ids);
	stilb_scene_destroy(scene);
	stilb_scene_destroy(same);
}

/* ---- no memory --------------------------------------------------------------------------------------------------- */

/* Every allocation of a frame that outgrows its commands and rows fails once; two complete frames follow each failed
 * one. */
static void a_frame_without_memory(void **state)
{
	(void)state;
	uint32_t models = 18000, moved = 3000;
	stilb_scene *scene = make_scene(models);
	uint32_t *ids = all_ids(models);
	assert_true(2 * models > RENDER_FIRST_COMMANDS && 2 * moved > RENDER_FIRST_ROWS);
	list_moved(scene, moved);
	for (uint32_t workers = TEST_TSAN ? 2 : 0; workers < 4; workers += 2) {
		stilb_job_pool *pool = make_pool(workers);
		int64_t granted = 0;
		for (stilb_result result = STILB_ERROR_MEMORY; result != STILB_OK; granted += granted < 8 ? 1 : 5) {
			stilb_render *render = make_render(scene, workers + 1, STILB_RENDER_REPLAY_INDIRECT);
			allocations_allow(granted);
			stilb_fail(STILB_ERROR_FILE, "no message yet");
			result = draw_frame(render, scene, ids, models, pool);
			allocations_allow(INT64_MAX);
			assert_true(result == STILB_OK || result == STILB_ERROR_MEMORY);
			if (result != STILB_OK)
				if (!strstr(stilb_error_message(), "no memory for"))
					fail_msg("%s", stilb_error_message());
			assert_frame(render, scene, ids, models, pool);
			assert_frame(render, scene, ids, 100, pool);
			stilb_render_destroy(render);
		}
		assert_true(granted > 20); /* for places, rows, commands, segments, runs, chunks, growth, indirect draws */
		stilb_job_pool_destroy(pool);
	}
	free(ids);
	stilb_scene_destroy(scene);
}

static void creation_without_memory(void **state)
{
	(void)state;
	stilb_scene *scene = make_scene(10);
	stilb_render_desc desc = {.device = STILB_RENDER_DEVICE_NULL, .width = 64, .height = 64, .context_count = 2};
	stilb_result result = STILB_ERROR_MEMORY;
	int64_t granted = 0;
	for (; result != STILB_OK; granted++) {
		stilb_render *render;
		allocations_allow(granted);
		result = stilb_render_create(&desc, &render);
		if (result != STILB_OK)
			assert_null(render);
		else
			result = stilb_render_set_scene(render, scene);
		allocations_allow(INT64_MAX);
		assert_true(result == STILB_OK || result == STILB_ERROR_MEMORY);
		stilb_render_destroy(render);
	}
	assert_true(granted > 8); /* for the renderer, contexts, heaps, ranges, indices */
	stilb_scene_destroy(scene);
}

/* A job that cannot be queued is run at once by the thread that submits it. */
static void a_full_queue_is_no_error(void **state)
{
	(void)state;
	stilb_scene *scene = make_scene(5000);
	uint32_t *ids = all_ids(5000);
	stilb_job_pool *pool = make_pool(2);
	stilb_render *render = make_render(scene, 3, STILB_RENDER_REPLAY_INDIRECT);
	assert_int_equal(draw_frame(render, scene, ids, 5000, pool), STILB_OK); /* later frames upload nothing */
	atomic_store_explicit(&queue_fails, 1, memory_order_relaxed);
	stilb_result result = draw_frame(render, scene, ids, 5000, pool);
	atomic_store_explicit(&queue_fails, 0, memory_order_relaxed);
	assert_int_equal(result, STILB_OK);
	assert_true(stilb_render_stream_hash(render) == reference_hash_models(REFERENCE_HASH_PASS, scene, ids, 5000));
	stilb_render_destroy(render);
	stilb_job_pool_destroy(pool);
	free(ids);
	stilb_scene_destroy(scene);
}

/* ---- info -------------------------------------------------------------------------------------------------------- */

static void the_null_device_says_what_it_is(void **state)
{
	(void)state;
	stilb_scene *scene = make_scene(1);
	stilb_render *render = make_render(scene, 1, STILB_RENDER_REPLAY_INDIRECT);
	stilb_image image = {0};
	assert_string_equal(stilb_render_device_name(render), "null");
	assert_false(stilb_render_device_is_software(render));
	assert_int_equal(stilb_render_samples(render), 1);
	assert_int_equal(stilb_render_validation_messages(render), 0);
	assert_int_equal(stilb_render_read_image(render, &image), STILB_ERROR_DEVICE);
	assert_non_null(strstr(stilb_error_message(), "--device vulkan"));
	assert_int_equal(stilb_render_wait(render), STILB_OK);
	assert_true(stilb_render_stats_get(render).gpu_ms == 0.0);
	assert_true(stilb_render_stream_hash(render) == REFERENCE_HASH_START);
	stilb_render_destroy(render);
	stilb_render_destroy(NULL);
	stilb_scene_destroy(scene);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(the_stream_is_the_scenes),
		cmocka_unit_test(commands_are_counted),
		cmocka_unit_test(a_thousand_frames),
		cmocka_unit_test(memory_grows_and_stays),
		cmocka_unit_test(other_context_counts_and_sizes),
		test_one_thread(segments_in_any_order),
		test_one_thread(passes_by_their_order),
		cmocka_unit_test(meshes_and_materials_are_copied),
		cmocka_unit_test(a_frame_without_memory),
		cmocka_unit_test(creation_without_memory),
		cmocka_unit_test(a_full_queue_is_no_error),
		cmocka_unit_test(the_null_device_says_what_it_is),
		cmocka_unit_test(reference_no_third_party),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
