/* The stream of draws that the device gets is the same for 0 to 8 workers and many schedules of each, a schedule being
 * who does what when. The linker redirects the job system's loops to this file (--wrap), which permutes their slices
 * and pauses between them; the hooks of the pool pause, too. So segments (numbered parts of a pass) are recorded in
 * orders that the scheduler alone would hardly produce. Arguments: the number of schedules;
 * "vulkan", to compare pictures instead; WORKERS SCHEDULE, to repeat one schedule. */
#include "support/render_fixture.h"
#include "support/test.h"

#include <sched.h>
#include <stddef.h>
#include <stdio.h>
#include <time.h>

#define MOST_WORKERS 8u
#define ALL_MODES (FIXTURE_REPLAYS * FIXTURE_MATERIALS)

/* ---- the scheduler that permutes --------------------------------------------------------------------------------- */

static struct {
	uint64_t seed;
	_Atomic uint64_t pauses; /* made so far; seeds the next. Relaxed: any thread may get any number */
	bool on;
} fuzz;

static void fuzz_pause(void)
{
	uint64_t index = atomic_fetch_add_explicit(&fuzz.pauses, 1, memory_order_relaxed);
	uint64_t random = stilb_random_u64(fuzz.seed, index);
	if (!fuzz.on || random % 4 == 0)
		return;
	if (random % 128 == 1)
		nanosleep(&(struct timespec){.tv_nsec = 1}, NULL);
	else if (random % 4 == 1)
		sched_yield();
	else
		for (volatile uint32_t spin = (uint32_t)(random >> 32) % 500; spin > 0; spin--) {
		}
}

static void fuzz_hook(void *user, uint32_t worker)
{
	(void)user, (void)worker;
	fuzz_pause();
}

static void fuzz_begin_hook(void *user, uint32_t worker, uint64_t tag)
{
	(void)tag;
	fuzz_hook(user, worker);
}

static void fuzz_steal_hook(void *user, uint32_t worker, uint32_t victim)
{
	(void)victim;
	fuzz_hook(user, worker);
}

static const stilb_job_hooks fuzz_hooks = {
	.job_begin = fuzz_begin_hook, .job_end = fuzz_hook, .steal = fuzz_steal_hook};

typedef struct fuzz_loop {
	stilb_job_range_fn *fn;
	void *context;
	uint32_t count, first, step; /* slice s runs as slice (first + s * step) % count */
} fuzz_loop;

static void fuzz_slice(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const fuzz_loop *loop = context;
	for (uint32_t s = begin; s < end; s++) {
		uint32_t slice = (uint32_t)((loop->first + (uint64_t)s * loop->step) % loop->count);
		fuzz_pause();
		loop->fn(slice, slice + 1, worker, loop->context);
		fuzz_pause();
	}
}

static uint32_t common_divisor(uint32_t a, uint32_t b)
{
	return b == 0 ? a : common_divisor(b, a % b);
}

void __real_stilb_job_parallel_for(stilb_job_pool *pool, uint32_t count, uint32_t grain, stilb_job_range_fn *fn,
                                   void *context, uint32_t worker);
void __wrap_stilb_job_parallel_for(stilb_job_pool *pool, uint32_t count, uint32_t grain, stilb_job_range_fn *fn,
                                   void *context, uint32_t worker);

void __wrap_stilb_job_parallel_for(stilb_job_pool *pool, uint32_t count, uint32_t grain, stilb_job_range_fn *fn,
                                   void *context, uint32_t worker)
{
	uint64_t random = stilb_random_u64(fuzz.seed, UINT64_MAX - count);
	fuzz_loop loop = {fn, context, count, (uint32_t)random, 1 + (uint32_t)(random >> 32) % 9973};
	assert_int_equal(grain, 1);
	while (count > 1 && common_divisor(loop.step, count) != 1)
		loop.step++;
	__real_stilb_job_parallel_for(pool, count, 1, fuzz_slice, &loop, worker);
}

/* ---- the draws: a scene, and two passes by hand, the first of which is sorted ----------------------------------- */

#define MODELS 520u
#define TEXTURES 3u
#define MATERIALS 20u
#define SEGMENTS 40u
#define HAND_PASSES 2u
#define PASSES (HAND_PASSES + 1)

static const stilb_render_pass passes[PASSES] = {
	{.name = "sorted", .order = 1, .sort = true}, {.name = "by hand", .order = 9}, {.name = "scene", .order = 5}};
static const uint32_t sequence[PASSES] = {0, 2, 1};

typedef struct hand_pass {
	uint32_t first[SEGMENTS + 1];
	fixture_draw *draws; /* [first[SEGMENTS]] in the order of recording */
} hand_pass;

typedef struct content {
	stilb_scene *scene;
	uint32_t *ids;
	stilb_render_view view;
	stilb_render_texture textures[TEXTURES];
	stilb_render_material materials[MATERIALS];
	hand_pass hand[HAND_PASSES];
	/* The expected result of replay. */
	fixture_draw *streams[PASSES];
	uint32_t counts[PASSES];
	uint64_t hash;
} content;

static content all;

static uint32_t segment_size(uint32_t pass, uint32_t segment)
{
	if (segment == 7)
		return pass == 0 ? 600 : 2100; /* draws: more than a chunk of rows holds, and than one of commands */
	return segment % 5 == 2 ? 0 : (uint32_t)(stilb_random_u64(pass, segment) % 30);
}

/* Creates materials, and textures if there are any, in the same order on every device, so that their handles are
 * equal. */
static void content_upload(stilb_render *render)
{
	assert_int_equal(stilb_render_set_scene(render, all.scene), STILB_OK);
	for (uint32_t t = 0; t < TEXTURES; t++) {
		uint8_t pixels[4 * 4 * 3];
		for (size_t i = 0; i < sizeof pixels; i++)
			pixels[i] = (uint8_t)(stilb_random_u64(t, i) % 256);
		stilb_image image = {4, 4, 3, STILB_IMAGE_U8_SRGB, pixels, 0};
		if (stilb_render_texture_create(render, &image, &all.textures[t]) != STILB_OK)
			fail_msg("%s", stilb_error_message());
	}
	for (uint32_t m = 0; m < MATERIALS; m++) {
		stilb_render_texture texture = m % 4 == 3 ? (stilb_render_texture){0} : all.textures[m % 4];
		assert_int_equal(stilb_render_material_create(render, &all.scene->materials[m], texture, &all.materials[m]),
		                 STILB_OK);
	}
}

static fixture_draw content_draw(const stilb_render *render, uint32_t pass, uint32_t index)
{
	uint32_t mesh = (uint32_t)(stilb_random_u64(21 + pass, index) % all.scene->mesh_count);
	uint32_t material = (uint32_t)(stilb_random_u64(31 + pass, index / 3) % MATERIALS);
	return (fixture_draw){
		.key = stilb_random_u64(41 + pass, index) % 100 << 40,
		.mesh = stilb_render_scene_mesh(render, mesh),
		.material = all.materials[material],
		.index_count = all.scene->meshes[mesh].index_count,
		.texture = material % 4 == 3 ? 0 : fixture_index(all.textures[material % 4].id),
		.transform = fixture_transform(51 + pass, index),
	};
}

static void content_make_hand(const stilb_render *render, uint32_t p)
{
	hand_pass *hand = &all.hand[p];
	for (uint32_t s = 0; s < SEGMENTS; s++)
		hand->first[s + 1] = hand->first[s] + segment_size(p, s);
	uint32_t count = all.counts[p] = hand->first[SEGMENTS];
	hand->draws = calloc(count, sizeof *hand->draws);
	all.streams[p] = calloc(count, sizeof *hand->draws);
	assert_true(hand->draws && all.streams[p]);
	for (uint32_t d = 0; d < count; d++)
		hand->draws[d] = content_draw(render, p, d);
	memcpy(all.streams[p], hand->draws, count * sizeof *hand->draws);
	if (passes[p].sort)
		fixture_sort(all.streams[p], count);
}

static void content_make_scene(const stilb_render *render)
{
	const stilb_scene *scene = all.scene;
	fixture_draw *draws = all.streams[HAND_PASSES] = calloc(scene->part_count, sizeof *draws);
	assert_non_null(draws);
	for (uint32_t m = 0; m < scene->model_count; m++)
		for (uint32_t p = scene->first_part[all.ids[m]]; p < scene->first_part[all.ids[m] + 1]; p++)
			draws[all.counts[HAND_PASSES]++] = (fixture_draw){
				.mesh = stilb_render_scene_mesh(render, scene->part_mesh[p]),
				.material = stilb_render_scene_material(render, scene->part_material[p]),
				.index_count = scene->meshes[scene->part_mesh[p]].index_count,
				.transform = scene->part_transform[p],
			};
}

static int content_make(void **state)
{
	(void)state;
	all.scene = fixture_scene(MODELS);
	all.ids = fixture_ids(MODELS);
	stilb_scene_camera camera = stilb_scene_stress_camera(all.scene, STILB_SCENE_VIEW_ALL, 1.0f);
	all.view.view_projection = stilb_scene_camera_matrix(&camera, 1.0f);
	memcpy(all.view.camera_position, camera.position, sizeof camera.position);
	all.view.lights = all.scene->lights;
	all.view.light_count = all.scene->light_count;
	all.view.surroundings = all.scene->surroundings;
	all.view.shading = stilb_render_shading_default();
	stilb_render *render = fixture_render(1, 0, 0);
	content_upload(render);
	for (uint32_t p = 0; p < HAND_PASSES; p++)
		content_make_hand(render, p);
	content_make_scene(render);
	all.hash = REFERENCE_HASH_START;
	for (uint32_t p = 0; p < PASSES; p++)
		all.hash = fixture_hash_all(reference_hash_pass(all.hash, &all.view), all.streams[sequence[p]],
		                            all.counts[sequence[p]]);
	stilb_render_destroy(render);
	return 0;
}

static int content_free(void **state)
{
	(void)state;
	for (uint32_t p = 0; p < PASSES; p++)
		free(all.streams[p]);
	for (uint32_t p = 0; p < HAND_PASSES; p++)
		free(all.hand[p].draws);
	free(all.ids);
	stilb_scene_destroy(all.scene);
	return 0;
}

/* ---- a frame ---------------------------------------------------------------------------------------------------- */

static void record_hand_segment(stilb_render *render, uint32_t pass, uint32_t segment, uint32_t worker)
{
	const hand_pass *hand = &all.hand[pass];
	stilb_render_context *context = stilb_render_context_get(render, worker);
	stilb_render_segment_begin(context, pass, segment);
	fuzz_pause();
	for (uint32_t d = hand->first[segment]; d < hand->first[segment + 1]; d++)
		fixture_record(context, &hand->draws[d]);
	fuzz_pause();
	stilb_render_segment_end(context);
}

static void hand_slice(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	for (uint32_t s = begin; s < end; s++)
		record_hand_segment(context, 1, s, worker);
}

typedef struct hand_job {
	stilb_render *render;
	uint32_t segment;
} hand_job;

static void hand_run(void *data, uint32_t worker)
{
	const hand_job *job = data;
	record_hand_segment(job->render, 0, job->segment, worker);
}

/* Records with one job for each segment. They run in any order: the thread that waits for its own jobs runs the newest
 * first, a thread that steals them the oldest. */
static void record_by_jobs(stilb_render *render, stilb_job_pool *pool)
{
	hand_job jobs[SEGMENTS];
	stilb_job_group group = {0};
	for (uint32_t s = 0; s < SEGMENTS; s++) {
		jobs[s] = (hand_job){render, (uint32_t)((fuzz.seed + s * 7) % SEGMENTS)};
		assert_int_equal(stilb_job_submit(pool, hand_run, &jobs[s], &group, 0), 0);
	}
	stilb_job_wait(pool, &group, 0);
}

static void draw_frame(stilb_render *render, stilb_job_pool *pool)
{
	assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
	assert_int_equal(stilb_render_pass_begin(render, 0, SEGMENTS), STILB_OK);
	record_by_jobs(render, pool);
	assert_int_equal(stilb_render_pass_end(render, 0), STILB_OK);
	assert_int_equal(stilb_render_pass_begin(render, 1, SEGMENTS), STILB_OK);
	stilb_job_parallel_for(pool, SEGMENTS, 1, hand_slice, render, 0);
	assert_int_equal(stilb_render_pass_end(render, 1), STILB_OK);
	assert_int_equal(stilb_render_record(render, 2, all.scene, all.ids, MODELS, pool, 0), STILB_OK);
	assert_int_equal(stilb_render_replay(render, passes, PASSES, &all.view, 1, pool, 0), STILB_OK);
}

/* ---- the stream ------------------------------------------------------------------------------------------------- */

static uint64_t expected_binds(int replay, int materials, uint32_t workers)
{
	uint64_t binds = 0, parts = replay == STILB_RENDER_REPLAY_SECONDARY ? workers + 1 : 1;
	for (uint32_t p = 0; p < PASSES; p++)
		binds += fixture_binds_in_parts(all.streams[p], all.counts[p], materials, parts);
	return binds;
}

static void check_schedule(stilb_render *render, stilb_job_pool *pool, uint32_t workers, uint32_t schedule)
{
	int replay = (int)render->device->replay, materials = (int)render->device->materials;
	fuzz.seed = stilb_random_u64(workers, schedule);
	fuzz.on = schedule > 0;
	draw_frame(render, pool);
	stilb_render_stats stats = stilb_render_stats_get(render);
	uint64_t hash = stilb_render_stream_hash(render), binds = expected_binds(replay, materials, workers);
	if (hash != all.hash || stats.draws != (uint64_t)all.counts[0] + all.counts[1] + all.counts[2])
		fail_msg("another stream: hash %016lx, not %016lx, %lu draws; to repeat: %u %u", hash, all.hash, stats.draws,
		         workers, schedule);
	if (stats.binds_sent != binds)
		fail_msg("%lu binds sent, not %lu, with replay %d and materials %d; to repeat: %u %u", stats.binds_sent, binds,
		         replay, materials, workers, schedule);
}

/* Runs schedules first .. last - 1, each with the next combination of replay mode and materials. */
static void check_schedules(uint32_t workers, uint32_t first, uint32_t last)
{
	stilb_job_pool *pool = fixture_pool(workers, fuzz_hooks);
	stilb_render *renders[ALL_MODES];
	for (int m = 0; m < ALL_MODES; m++) {
		renders[m] = fixture_render(workers + 1, m % FIXTURE_REPLAYS, m / FIXTURE_REPLAYS);
		content_upload(renders[m]);
	}
	for (uint32_t schedule = first; schedule < last; schedule++)
		check_schedule(renders[schedule % ALL_MODES], pool, workers, schedule);
	for (int m = 0; m < ALL_MODES; m++)
		stilb_render_destroy(renders[m]);
	stilb_job_pool_destroy(pool);
}

static uint32_t schedules = TEST_TSAN ? 40 : TEST_ASAN ? 20 : 100, repeat_workers, repeat_schedule;

static void one_stream(void **state)
{
	(void)state;
	/* With 4 to 7 the sanitizers would see nothing new. */
	uint32_t sanitized = TEST_TSAN || TEST_ASAN;
	for (uint32_t workers = TEST_TSAN ? 1 : 0; workers <= MOST_WORKERS; workers += sanitized && workers == 3 ? 5 : 1)
		check_schedules(workers, 0, schedules);
}

static void repeated(void **state)
{
	(void)state;
	check_schedules(repeat_workers, repeat_schedule, repeat_schedule + 1);
}

/* ---- the picture ------------------------------------------------------------------------------------------------ */

static stilb_image draw_picture(int replay, int materials, uint32_t workers)
{
	stilb_render_desc desc = {.replay = (stilb_render_replay_mode)replay,
	                          .materials = (stilb_render_materials)materials,
	                          .width = 160,
	                          .height = 160,
	                          .context_count = workers + 1,
	                          .validate = true};
	stilb_render *render;
	stilb_image image = {0};
	if (stilb_render_create(&desc, &render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stilb_job_pool *pool = fixture_pool(workers, fuzz_hooks);
	content_upload(render);
	for (uint32_t schedule = 0; schedule < 3; schedule++) {
		fuzz.seed = stilb_random_u64(workers, schedule);
		fuzz.on = schedule > 0;
		draw_frame(render, pool);
		assert_true(stilb_render_stream_hash(render) == all.hash);
	}
	assert_int_equal(stilb_render_read_image(render, &image), STILB_OK);
	assert_int_equal(stilb_render_validation_messages(render), 0);
	stilb_render_destroy(render);
	stilb_job_pool_destroy(pool);
	return image;
}

static bool is_flat(const stilb_image *image)
{
	const uint8_t *pixels = image->pixels;
	return memcmp(pixels, pixels + 4, stilb_image_size(image) - 4) == 0;
}

static void one_picture(void **state)
{
	(void)state;
	static const uint32_t workers[] = {0, 1, 3, 8};
	stilb_image first = draw_picture(0, 0, 0);
	assert_false(is_flat(&first));
	for (int mode = 0; mode < ALL_MODES; mode++)
		for (size_t w = (size_t)mode % 2; w < sizeof workers / sizeof *workers; w += 2) { /* two of them in each mode */
			stilb_image image = draw_picture(mode % FIXTURE_REPLAYS, mode / FIXTURE_REPLAYS, workers[w]);
			if (memcmp(image.pixels, first.pixels, stilb_image_size(&first)) != 0)
				fail_msg("another picture with replay %d, materials %d and %u workers", mode % FIXTURE_REPLAYS,
				         mode / FIXTURE_REPLAYS, workers[w]);
			stilb_image_finish(&image);
		}
	stilb_image_finish(&first);
}

int main(int argc, char **argv)
{
	struct CMUnitTest streams[] = {
		cmocka_unit_test(one_stream),
		cmocka_unit_test(reference_no_third_party),
	};
	struct CMUnitTest pictures[] = {cmocka_unit_test(one_picture)};
	struct CMUnitTest repeats[] = {cmocka_unit_test(repeated)};
	if (argc == 3) {
		repeat_workers = (uint32_t)strtoul(argv[1], NULL, 10);
		repeat_schedule = (uint32_t)strtoul(argv[2], NULL, 10);
		return cmocka_run_group_tests(repeats, content_make, content_free);
	}
	if (argc == 2 && strcmp(argv[1], "vulkan") == 0)
		return cmocka_run_group_tests(pictures, content_make, content_free);
	if (argc == 2)
		schedules = (uint32_t)strtoul(argv[1], NULL, 10);
	return cmocka_run_group_tests(streams, content_make, content_free);
}
