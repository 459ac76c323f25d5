/* Sorted passes: ascending keys, equal keys in recording order, for any number of workers; compared with a merge sort
 * of the same draws. The linker sends allocations here (--wrap), to let them fail. */
#include "support/render_fixture.h"
#include "support/test.h"

#include <pthread.h>
#include <sched.h>
#include <stddef.h>

/* ---- memory that runs out once ---------------------------------------------------------------------------------- */

/* Allocations left until the one that fails. Relaxed: only the number matters. */
static _Atomic int64_t allocations_left = INT64_MAX;

void *__real_stilb_memory_alloc(size_t count, size_t size);
void *__wrap_stilb_memory_alloc(size_t count, size_t size);
void *__real_realloc(void *memory, size_t size);
void *__wrap_realloc(void *memory, size_t size);

static bool allocation_fails(void)
{
	return atomic_fetch_sub_explicit(&allocations_left, 1, memory_order_relaxed) == 1;
}

static void allocation_fail(int64_t number)
{
	atomic_store_explicit(&allocations_left, number, memory_order_relaxed);
}

void *__wrap_stilb_memory_alloc(size_t count, size_t size)
{
	return allocation_fails() ? NULL : __real_stilb_memory_alloc(count, size);
}

void *__wrap_realloc(void *memory, size_t size)
{
	return allocation_fails() ? NULL : __real_realloc(memory, size);
}

/* ---- a list of draws -------------------------------------------------------------------------------------------- */

#define TEXTURES 3u
#define MATERIALS 24u
#define SEGMENT_DRAWS 700u

/* A list of draws with keys of one kind, of a scene with materials with and without textures. */
typedef struct list {
	stilb_scene *scene;
	stilb_render *render;
	stilb_job_pool *pool;
	stilb_render_texture textures[TEXTURES];
	stilb_render_material materials[MATERIALS];
	fixture_draw *draws; /* [count] */
	uint32_t count;
} list;

typedef enum key_kind {
	KEYS_EQUAL,
	KEYS_ASCENDING,
	KEYS_DESCENDING,
	KEYS_ANY,
	KEYS_FEW,
	KEYS_HIGH_BYTE,
	KEYS_OUTER_BYTES,
	KEYS_ALL_ONES,
	KEY_KINDS,
} key_kind;

static uint64_t make_key(key_kind kind, uint32_t index)
{
	uint64_t random = stilb_random_u64(61, index);
	switch (kind) {
	case KEYS_ASCENDING:
		return index * 0x100000001u;
	case KEYS_DESCENDING:
		return UINT64_MAX - index * 0x100000001u;
	case KEYS_ANY:
		return random;
	case KEYS_FEW:
		return random % 4 * 0x0001000001000001u;
	case KEYS_HIGH_BYTE:
		return random << 56;
	case KEYS_OUTER_BYTES:
		return (random & 0x7f000000000000ffu) | 0x00aabbccddeeff00u;
	case KEYS_ALL_ONES:
		return random % 50 == 0 ? 0 : UINT64_MAX;
	default:
		return 77;
	}
}

static list list_make(uint32_t workers, int replay, int materials)
{
	list l = {.scene = fixture_scene(MATERIALS)};
	l.pool = fixture_pool(workers, (stilb_job_hooks){0});
	l.render = fixture_render(workers + 1, replay, materials);
	assert_int_equal(stilb_render_set_scene(l.render, l.scene), STILB_OK);
	for (uint32_t t = 0; t < TEXTURES; t++) {
		uint8_t pixel = (uint8_t)t;
		stilb_image image = {1, 1, 1, STILB_IMAGE_U8_SRGB, &pixel, 0};
		assert_int_equal(stilb_render_texture_create(l.render, &image, &l.textures[t]), STILB_OK);
	}
	for (uint32_t m = 0; m < MATERIALS; m++) {
		stilb_render_texture texture = m % 4 == 3 ? (stilb_render_texture){0} : l.textures[m % 4];
		assert_int_equal(stilb_render_material_create(l.render, &l.scene->materials[m], texture, &l.materials[m]),
		                 STILB_OK);
	}
	return l;
}

static void list_free(list *l)
{
	free(l->draws);
	stilb_render_destroy(l->render);
	stilb_job_pool_destroy(l->pool);
	stilb_scene_destroy(l->scene);
}

static void list_fill(list *l, uint32_t count, key_kind kind)
{
	free(l->draws);
	l->draws = calloc(count + 1, sizeof *l->draws);
	l->count = count;
	assert_non_null(l->draws);
	for (uint32_t d = 0; d < count; d++) {
		uint32_t mesh = (uint32_t)(stilb_random_u64(62, d) % l->scene->mesh_count);
		uint32_t material = (uint32_t)(stilb_random_u64(63, d / 2) % MATERIALS);
		l->draws[d] = (fixture_draw){
			.key = make_key(kind, d),
			.mesh = stilb_render_scene_mesh(l->render, mesh),
			.material = l->materials[material],
			.index_count = l->scene->meshes[mesh].index_count,
			.texture = material % 4 == 3 ? 0 : fixture_index(l->textures[material % 4].id),
			.transform = fixture_transform(64, d),
		};
	}
}

typedef struct list_pass {
	const list *list;
	uint32_t pass;
} list_pass;

static void record_slice(uint32_t begin, uint32_t end, uint32_t worker, void *data)
{
	const list_pass *job = data;
	const list *l = job->list;
	stilb_render_context *context = stilb_render_context_get(l->render, worker);
	for (uint32_t s = begin; s < end; s++) {
		uint32_t first = s * SEGMENT_DRAWS, last = first + SEGMENT_DRAWS < l->count ? first + SEGMENT_DRAWS : l->count;
		stilb_render_segment_begin(context, job->pass, s);
		for (uint32_t d = first; d < last; d++)
			fixture_record(context, &l->draws[d]);
		stilb_render_segment_end(context);
	}
}

static stilb_result list_record(const list *l, uint32_t pass)
{
	uint32_t segments = l->count / SEGMENT_DRAWS + 1; /* the last may be empty */
	stilb_result result = stilb_render_pass_begin(l->render, pass, segments);
	if (result != STILB_OK)
		return result;
	list_pass job = {l, pass};
	stilb_job_parallel_for(l->pool, segments, 1, record_slice, &job, 0);
	return stilb_render_pass_end(l->render, pass);
}

/* The same list in each of the passes. */
static stilb_result list_draw(const list *l, const stilb_render_pass *passes, uint32_t pass_count)
{
	static const stilb_render_view view;
	stilb_result result = stilb_render_frame_begin(l->render);
	for (uint32_t p = 0; p < pass_count && result == STILB_OK; p++)
		result = list_record(l, p);
	return result == STILB_OK ? stilb_render_replay(l->render, passes, pass_count, &view, 1, l->pool, 0) : result;
}

static uint64_t list_hash(const list *l, uint64_t hash, bool sorted)
{
	fixture_draw *draws = malloc((l->count + 1) * sizeof *draws);
	assert_non_null(draws);
	memcpy(draws, l->draws, l->count * sizeof *draws);
	if (sorted)
		fixture_sort(draws, l->count);
	hash = fixture_hash_all(reference_hash_pass(hash, &(stilb_render_view){0}), draws, l->count);
	free(draws);
	return hash;
}

static const stilb_render_pass sorted_pass = {.name = "sorted", .sort = true};

/* Keys ascend, every command has its run's state, and neighbouring runs differ in theirs. */
static void assert_runs(const list *l)
{
	const render_pass_lists *lists = &l->render->passes[0];
	uint32_t mask = render_material_mask(l->render->device->materials), wrong = 0;
	uint64_t draws = 0, key = 0;
	for (uint32_t r = 0; r < lists->run_count; r++) {
		const render_run *run = &lists->runs[r];
		assert_true(run->count > 0);
		assert_true(r == 0 || run->first == run[-1].first + run[-1].count);
		assert_true(r == 0 || run->state != run[-1].state);
		for (uint32_t c = run->first; c < run->first + run->count; c++) {
			const render_command *command = &render_commands(l->render)[c];
			uint32_t entry = l->render->resources.materials[command->material];
			wrong += run->state != render_state(entry, command->material, mask) || command->key < key;
			key = command->key;
		}
		draws += run->count;
	}
	assert_int_equal(wrong, 0);
	assert_true(draws == l->count);
}

/* ---- order ------------------------------------------------------------------------------------------------------ */

static void any_keys_in_any_number(void **state)
{
	(void)state;
	static const uint32_t counts[] = {0, 1, 2, 3, 512, 2048, 2049, 9000, 40000, 100};
	for (uint32_t workers = TEST_TSAN ? 3 : 0; workers <= 3; workers += 3) {
		list l = list_make(workers, STILB_RENDER_REPLAY_INDIRECT, STILB_RENDER_MATERIALS_BIND);
		for (key_kind kind = 0; kind < KEY_KINDS; kind += TEST_TSAN ? 3 : 1)
			for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
				list_fill(&l, counts[c], kind);
				assert_int_equal(list_draw(&l, &sorted_pass, 1), STILB_OK);
				if (stilb_render_stream_hash(l.render) != list_hash(&l, REFERENCE_HASH_START, true))
					fail_msg("%u keys of kind %d with %u workers are in another order", counts[c], (int)kind, workers);
				assert_runs(&l);
			}
		list_free(&l);
	}
}

static void any_workers_and_modes(void **state)
{
	(void)state;
	static const uint32_t workers[] = {2, 8, 0, 1, 5};
	for (int w = 0; w < (TEST_TSAN ? 2 : 5); w++)
		for (int replay = 0; replay < FIXTURE_REPLAYS; replay++)
			for (int materials = 0; materials < FIXTURE_MATERIALS; materials++) {
				list l = list_make(workers[w], replay, materials);
				list_fill(&l, 6000, KEYS_FEW);
				for (int frame = 0; frame < 3; frame++) {
					assert_int_equal(list_draw(&l, &sorted_pass, 1), STILB_OK);
					assert_true(stilb_render_stream_hash(l.render) == list_hash(&l, REFERENCE_HASH_START, true));
					assert_runs(&l);
				}
				fixture_sort(l.draws, l.count);
				uint64_t parts = replay == STILB_RENDER_REPLAY_SECONDARY ? workers[w] + 1 : 1;
				stilb_render_stats stats = stilb_render_stats_get(l.render);
				assert_true(stats.draws == 6000 && stats.binds_asked == 18000);
				assert_true(stats.binds_sent == fixture_binds_in_parts(l.draws, l.count, materials, parts));
				list_free(&l);
			}
}

/* Sorted by material, each material is bound once. */
static void keys_save_bindings(void **state)
{
	(void)state;
	list l = list_make(1, STILB_RENDER_REPLAY_DIRECT, STILB_RENDER_MATERIALS_BIND);
	list_fill(&l, 5000, KEYS_EQUAL);
	assert_int_equal(list_draw(&l, &sorted_pass, 1), STILB_OK);
	assert_true(stilb_render_stats_get(l.render).binds_sent > 2000);
	for (uint32_t d = 0; d < l.count; d++)
		l.draws[d].key = fixture_index(l.draws[d].material.id);
	assert_int_equal(list_draw(&l, &sorted_pass, 1), STILB_OK);
	fixture_sort(l.draws, l.count);
	uint64_t binds = fixture_binds(l.draws, l.count, STILB_RENDER_MATERIALS_BIND);
	assert_true(stilb_render_stats_get(l.render).binds_sent == binds && binds < 3 * MATERIALS);
	list_free(&l);
}

/* ---- together with other passes --------------------------------------------------------------------------------- */

#define MANY_PASSES 5u

static const stilb_render_pass many_passes[MANY_PASSES] = {
	{.name = "as recorded", .order = 3},
	{.name = "sorted", .order = 1, .sort = true},
	{.name = "sorted last", .order = 9, .sort = true},
	{.name = "as recorded too", .order = 2},
	{.name = "sorted between", .order = 4, .sort = true},
};

/* A device that stands between render and the null device, and counts in moved_late the lists that point into memory
 * that the frame's commands have left: none. */
static struct {
	gpu_functions functions;
	const gpu_functions *real;
	const stilb_render *render;
	uint32_t passes, moved_late;
	_Atomic bool runs; /* release: pairs with the acquire of destroy_materials */
} spy;

static stilb_result spy_run(stilb_gpu *gpu, const stilb_gpu_plan *plan, const stilb_gpu_draws *lists,
                            uint32_t list_count, const stilb_gpu_threads *threads, const gpu_upload_ready *uploads,
                            uint32_t upload_count)
{
	atomic_store_explicit(&spy.runs, true, memory_order_release); /* see runs */
	spy.passes = list_count;
	for (uint32_t l = 0; l < list_count; l++)
		spy.moved_late += lists[l].draws != render_commands(spy.render) ||
		                  stilb_gpu_buffer_mapped(gpu, lists[l].commands) != lists[l].draws;
	return spy.real->run(gpu, plan, lists, list_count, threads, uploads, upload_count);
}

static void spy_on(stilb_render *render)
{
	spy.real = render->device->gpu->functions;
	spy.functions = *spy.real;
	spy.functions.run = spy_run;
	spy.render = render;
	spy.passes = spy.moved_late = 0;
	atomic_store_explicit(&spy.runs, false, memory_order_relaxed);
	render->device->gpu->functions = &spy.functions;
}

static void many_passes_that_grow(void **state)
{
	(void)state;
	static const uint32_t order[MANY_PASSES] = {1, 3, 0, 4, 2};
	list l = list_make(2, STILB_RENDER_REPLAY_INDIRECT, STILB_RENDER_MATERIALS_PIPELINE);
	spy_on(l.render);
	for (uint32_t count = 300; count < (TEST_TSAN ? 20000 : 80000); count *= 6) {
		list_fill(&l, count, KEYS_ANY);
		assert_int_equal(list_draw(&l, many_passes, MANY_PASSES), STILB_OK);
		assert_int_equal(spy.passes, MANY_PASSES);
		uint64_t hash = REFERENCE_HASH_START;
		for (uint32_t p = 0; p < MANY_PASSES; p++)
			hash = list_hash(&l, hash, many_passes[order[p]].sort);
		assert_true(stilb_render_stream_hash(l.render) == hash);
	}
	assert_int_equal(spy.moved_late, 0);
	list_free(&l);
}

/* ---- resources destroyed during a frame ------------------------------------------------------------------------- */

/* Once the device is given the frame, destroys the materials that it draws with. */
static void *destroy_materials(void *data)
{
	list *l = data;
	while (!atomic_load_explicit(&spy.runs, memory_order_acquire))
		sched_yield();
	for (uint32_t m = 0; m < MATERIALS; m++)
		stilb_render_material_destroy(l->render, l->materials[m]);
	return NULL;
}

static void materials_destroyed_during_replay(void **state)
{
	(void)state;
	list l = list_make(0, STILB_RENDER_REPLAY_INDIRECT, STILB_RENDER_MATERIALS_BIND);
	list_fill(&l, 20000, KEYS_ANY);
	spy_on(l.render);
	pthread_t thread;
	assert_int_equal(pthread_create(&thread, NULL, destroy_materials, &l), 0);
	assert_int_equal(list_draw(&l, &sorted_pass, 1), STILB_OK);
	assert_int_equal(pthread_join(thread, NULL), 0);
	assert_true(stilb_render_stream_hash(l.render) == list_hash(&l, REFERENCE_HASH_START, true));
	list_free(&l);
}

/* ---- no memory -------------------------------------------------------------------------------------------------- */

/* Each allocation of a frame fails in turn; the next frame is complete. */
static void a_sort_without_memory(void **state)
{
	(void)state;
	stilb_result result = STILB_ERROR_MEMORY;
	int64_t number = 1;
	for (; result != STILB_OK; number++) {
		list l = list_make(0, STILB_RENDER_REPLAY_INDIRECT, STILB_RENDER_MATERIALS_BIND);
		list_fill(&l, 20000, KEYS_ANY); /* draws, of which sorting makes copies: more than a new frame holds */
		allocation_fail(number);
		result = list_draw(&l, &sorted_pass, 1);
		allocation_fail(INT64_MAX);
		assert_true(result == STILB_OK || result == STILB_ERROR_MEMORY);
		if (result != STILB_OK)
			assert_non_null(strstr(stilb_error_message(), "no memory for"));
		assert_int_equal(list_draw(&l, &sorted_pass, 1), STILB_OK);
		assert_true(stilb_render_stream_hash(l.render) == list_hash(&l, REFERENCE_HASH_START, true));
		list_free(&l);
	}
	assert_true(number > 10);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(any_keys_in_any_number),
		cmocka_unit_test(any_workers_and_modes),
		cmocka_unit_test(keys_save_bindings),
		cmocka_unit_test(many_passes_that_grow),
		cmocka_unit_test(materials_destroyed_during_replay),
		test_one_thread(a_sort_without_memory),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
