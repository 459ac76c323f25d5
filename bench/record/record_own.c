/* The engine's subjects of the suite `record`: recording by hand and from a scene, the three ways of replay, whole
 * frames on the null device and on lavapipe. Every run ends with a comparison of the stream hash or the picture. */
#include "bench/record/record_child.h"

#include "culling/cull.h"
#include "jobs/job.h"
#include "profiler/prof.h"
#include "render/render.h"
#include "scene/edit/scene_edit.h"

#include <stdatomic.h>

#define SEGMENT_DRAWS 256u /* draws that one job records by hand */
#define WARM_UP_FRAMES 4   /* not measured: until the buffers of both frames in flight have grown */
#define BLOCK_FRAMES 16    /* frames of one kind in a row, if two kinds take turns */
#define BUSY_NS 300000     /* be_busy lasts ten times as long as a worker spins before it sleeps */
#define OWNER 0u           /* worker index of a pool's owner */

/* ---- the subjects ------------------------------------------------------------------------------------------------ */

typedef enum recorder {
	BY_HAND, /* stilb_render_draw for each draw, as a program without a scene does */
	SCENE,   /* stilb_render_record */
} recorder;

static const struct subject {
	const char *name;
	recorder recorder;
	stilb_render_replay_mode replay;
} subjects[] = {
	{"stilb", BY_HAND, STILB_RENDER_REPLAY_INDIRECT},          {"stilb-scene", SCENE, STILB_RENDER_REPLAY_INDIRECT},
	{"stilb-indirect", SCENE, STILB_RENDER_REPLAY_INDIRECT},   {"stilb-direct", SCENE, STILB_RENDER_REPLAY_DIRECT},
	{"stilb-secondary", SCENE, STILB_RENDER_REPLAY_SECONDARY},
};

static const stilb_render_materials materials[] = {
	[RECORD_INDEX] = STILB_RENDER_MATERIALS_INDEX,
	[RECORD_BIND] = STILB_RENDER_MATERIALS_BIND,
	[RECORD_PIPELINE] = STILB_RENDER_MATERIALS_PIPELINE,
};

/* ---- a run ------------------------------------------------------------------------------------------------------- */

/* The data that a program without a scene keeps for each of its objects. */
typedef struct object {
	stilb_render_mesh mesh;
	stilb_render_material material;
} object;

typedef struct run {
	const struct subject *subject;
	const record_case *on;
	const bench_child *child;
	uint64_t until; /* end of the run, ns */
	uint32_t draws;
	stilb_scene *scene;
	uint32_t *models; /* ids of all models: only RECORD_FRAME culls */
	object *objects;  /* [draws] */
	uint64_t *keys;   /* [draws] sort keys */
	stilb_render *render;
	stilb_job_pool *alone; /* a pool without workers */
	stilb_job_pool *pool;  /* a pool with the case's number of threads */
	stilb_render_pass pass;
	stilb_render_view view;
	stilb_cull *cull;
	stilb_cull_visible visible;
} run;

static void expect(stilb_result result)
{
	if (result != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
}

static bool time_left(const run *r, const record_samples *samples)
{
	return samples->count < 3 || bench_child_now_ns() < r->until;
}

static double ns_per_draw(const run *r, record_samples *samples)
{
	return record_samples_median(samples) / r->draws;
}

/* ---- the stages of a frame --------------------------------------------------------------------------------------- */

/* Body of a parallel loop over segments, each SEGMENT_DRAWS draws: records segments [begin, end). */
static void hand_record(uint32_t begin, uint32_t end, uint32_t worker, void *data)
{
	const run *r = data;
	stilb_render_context *context = stilb_render_context_get(r->render, worker);
	for (uint32_t segment = begin; segment < end; segment++) {
		uint32_t first = segment * SEGMENT_DRAWS, after = first + SEGMENT_DRAWS;
		after = after < r->draws ? after : r->draws;
		stilb_render_segment_begin(context, 0, segment);
		for (uint32_t i = first; i < after; i++)
			stilb_render_draw(context, r->objects[i].mesh, r->objects[i].material, &r->scene->part_transform[i]);
		stilb_render_segment_end(context);
	}
}

/* Records all draws by hand with their sort keys, on one thread. */
static void hand_record_keys(const run *r)
{
	stilb_render_context *context = stilb_render_context_get(r->render, OWNER);
	expect(stilb_render_pass_begin(r->render, 0, 1));
	stilb_render_segment_begin(context, 0, 0);
	for (uint32_t i = 0; i < r->draws; i++)
		stilb_render_draw_with_key(context, r->keys[i], r->objects[i].mesh, r->objects[i].material,
		                           &r->scene->part_transform[i]);
	stilb_render_segment_end(context);
	expect(stilb_render_pass_end(r->render, 0));
}

static void record(run *r, stilb_job_pool *pool)
{
	if (r->subject->recorder == SCENE) {
		expect(stilb_render_record(r->render, 0, r->scene, r->models, r->scene->model_count, pool, OWNER));
		return;
	}
	uint32_t segments = (r->draws + SEGMENT_DRAWS - 1) / SEGMENT_DRAWS;
	expect(stilb_render_pass_begin(r->render, 0, segments));
	stilb_job_parallel_for(pool, segments, 1, hand_record, r, OWNER);
	expect(stilb_render_pass_end(r->render, 0));
}

static void replay(run *r, stilb_job_pool *pool)
{
	expect(stilb_render_replay(r->render, &r->pass, 1, &r->view, 1, pool, OWNER));
}

/* Draws one frame; returns the time of its recording, ns. */
static uint64_t frame_recording(run *r, stilb_job_pool *pool)
{
	expect(stilb_render_frame_begin(r->render));
	uint64_t begin = bench_child_now_ns();
	record(r, pool);
	uint64_t end = bench_child_now_ns();
	replay(r, r->alone);
	return end - begin;
}

static uint64_t frame_replaying(run *r)
{
	expect(stilb_render_frame_begin(r->render));
	record(r, r->pool);
	uint64_t begin = bench_child_now_ns();
	replay(r, r->pool);
	return bench_child_now_ns() - begin;
}

/* ---- the kinds of case ------------------------------------------------------------------------------------------- */

static record_samples first, second, third, fourth; /* times; which ones depends on the kind of case */

static void measure_draws(run *r)
{
	for (int i = 0; i < WARM_UP_FRAMES; i++)
		frame_recording(r, r->alone);
	while (time_left(r, &first))
		record_samples_add(&first, frame_recording(r, r->alone));
	bench_child_metric("record", ns_per_draw(r, &first));
	stilb_render_stats stats = stilb_render_stats_get(r->render);
	bench_child_metric("bytes", (double)stats.recorded_bytes / (double)stats.draws);
}

static void measure_phase(run *r)
{
	while (time_left(r, &second)) {
		for (int i = 0; i < WARM_UP_FRAMES; i++)
			frame_recording(r, r->alone);
		for (int i = 0; i < BLOCK_FRAMES; i++)
			record_samples_add(&first, frame_recording(r, r->alone));
		stilb_job_phase_begin(r->pool);
		for (int i = 0; i < WARM_UP_FRAMES; i++)
			frame_recording(r, r->pool);
		for (int i = 0; i < BLOCK_FRAMES; i++)
			record_samples_add(&second, frame_recording(r, r->pool));
		stilb_job_phase_end(r->pool);
	}
	double one = record_samples_median(&first), two = record_samples_median(&second);
	bench_child_metric("one", one * 1e-3);
	bench_child_metric("two", two * 1e-3);
	bench_child_metric("speed-up", one / two);
}

/* Keeps the main thread busy until all workers sleep. */
static void be_busy(void)
{
	for (uint64_t until = bench_child_now_ns() + BUSY_NS; bench_child_now_ns() < until;)
		;
}

/* The time at which wake_worker's job, `woken`, ran, ns; 0 before. Release in `woken`, pairs with the acquire in
 * wake_worker. */
static _Atomic uint64_t woken_at;

static void woken(void *data, uint32_t worker)
{
	(void)data, (void)worker;
	atomic_store_explicit(&woken_at, bench_child_now_ns(), memory_order_release); /* pairs with wake_worker */
}

/* Measures the two costs of a sleeping worker: the time from the waker's call until the worker runs (wake), and the
 * time that the call takes the waker (cost). */
static void wake_worker(run *r, record_samples *wake, record_samples *cost)
{
	stilb_job_group group = {0};
	atomic_store_explicit(&woken_at, 0, memory_order_relaxed); /* relaxed: submitting the job publishes it */
	uint64_t begin = bench_child_now_ns(), started;
	if (stilb_job_submit(r->pool, woken, NULL, &group, OWNER) != 0)
		bench_child_fail("out of memory");
	uint64_t end = bench_child_now_ns();
	while ((started = atomic_load_explicit(&woken_at, memory_order_acquire)) ==
	       0) /* pairs with woken; a wait would run the job here */
		;
	stilb_job_wait(r->pool, &group, OWNER);
	record_samples_add(wake, started - begin);
	record_samples_add(cost, end - begin);
}

/* A frame's recording takes T1 on one thread (metric one). On two, of which one sleeps at first, in a time T the waker
 * can work for T - wake-cost and the woken worker for T - wake, so at best T = (T1 + wake + wake-cost) / 2. The metric
 * of-best is the measured time (two) divided by that. */
static void measure_parked(run *r)
{
	for (int i = 0; i < WARM_UP_FRAMES; i++)
		frame_recording(r, r->pool);
	while (time_left(r, &second)) {
		be_busy();
		record_samples_add(&first, frame_recording(r, r->alone));
		be_busy();
		record_samples_add(&second, frame_recording(r, r->pool));
		be_busy();
		wake_worker(r, &third, &fourth);
	}
	double one = record_samples_median(&first), two = record_samples_median(&second);
	double wake = record_samples_median(&third), cost = record_samples_median(&fourth);
	bench_child_metric("one", one * 1e-3);
	bench_child_metric("two", two * 1e-3);
	bench_child_metric("wake", wake * 1e-3);
	bench_child_metric("wake-cost", cost * 1e-3);
	bench_child_metric("of-best", two / ((one + wake + cost) / 2.0));
}

#define VIEWS 6u

/* Draws a frame of so many views, each of the whole scene; returns the time of their recording, ns. */
static uint64_t frame_views(run *r, uint32_t count, stilb_job_pool *pool)
{
	static const char *const names[VIEWS] = {"v1", "v2", "v3", "v4", "v5", "v6"};
	stilb_render_target targets[VIEWS];
	stilb_render_view views[VIEWS];
	stilb_render_pass passes[VIEWS];
	stilb_render_recording recordings[VIEWS];
	for (uint32_t v = 0; v < count; v++) {
		targets[v] = (stilb_render_target){.name = names[v], .width = 64, .height = 64, .output = true};
		views[v] = r->view;
		views[v].target = &targets[v];
		passes[v] = (stilb_render_pass){.name = names[v], .view = v, .order = v};
		recordings[v] = (stilb_render_recording){v, r->scene->model_count, r->models, &views[v]};
	}
	expect(stilb_render_frame_begin(r->render));
	uint64_t begin = bench_child_now_ns();
	expect(stilb_render_record_views(r->render, r->scene, recordings, count, pool, OWNER));
	uint64_t end = bench_child_now_ns();
	expect(stilb_render_replay(r->render, passes, count, views, count, r->alone, OWNER));
	return end - begin;
}

/* One view and six on one thread, then six on two; and what each view more writes for a draw. The last frame is one of
 * the scene alone, for the check. */
static void measure_views(run *r)
{
	while (time_left(r, &third)) {
		for (int i = 0; i < WARM_UP_FRAMES; i++)
			frame_views(r, VIEWS, r->alone);
		for (int i = 0; i < BLOCK_FRAMES; i++) {
			record_samples_add(&first, frame_views(r, 1, r->alone));
			record_samples_add(&second, frame_views(r, VIEWS, r->alone));
		}
		stilb_job_phase_begin(r->pool);
		for (int i = 0; i < WARM_UP_FRAMES; i++)
			frame_views(r, VIEWS, r->pool);
		for (int i = 0; i < BLOCK_FRAMES; i++)
			record_samples_add(&third, frame_views(r, VIEWS, r->pool));
		stilb_job_phase_end(r->pool);
	}
	stilb_render_stats stats = stilb_render_stats_get(r->render);
	double single = record_samples_median(&first), one = record_samples_median(&second);
	double two = record_samples_median(&third);
	bench_child_metric("one", one * 1e-3);
	bench_child_metric("two", two * 1e-3);
	bench_child_metric("speed-up", one / two);
	bench_child_metric("of-sum", one / (VIEWS * single));
	bench_child_metric("bytes", (double)stats.recorded_bytes / (double)stats.draws);
	frame_recording(r, r->alone);
}

static void measure_replay(run *r)
{
	stilb_job_phase_begin(r->pool);
	for (int i = 0; i < WARM_UP_FRAMES; i++)
		frame_replaying(r);
	while (time_left(r, &first))
		record_samples_add(&first, frame_replaying(r));
	stilb_job_phase_end(r->pool);
	bench_child_metric("replay", ns_per_draw(r, &first));
}

static uint64_t frame_with_keys(run *r, bool sort)
{
	r->pass.sort = sort;
	expect(stilb_render_frame_begin(r->render));
	hand_record_keys(r);
	uint64_t begin = bench_child_now_ns();
	replay(r, r->alone);
	return bench_child_now_ns() - begin;
}

/* The time of a sorted pass minus that of one in recording order. The last frame is sorted, for the check. */
static void measure_sort(run *r)
{
	for (int i = 0; i < WARM_UP_FRAMES; i++)
		frame_with_keys(r, true);
	while (time_left(r, &second)) {
		record_samples_add(&first, frame_with_keys(r, false));
		record_samples_add(&second, frame_with_keys(r, true));
	}
	double unsorted = ns_per_draw(r, &first), sorted = ns_per_draw(r, &second);
	bench_child_metric("sort", sorted - unsorted);
	bench_child_metric("replay", sorted);
}

/* Draws one frame in the stages cull, record and replay of the engine's frame. at: the times, in ns, at which the first
 * begins, the second, the third, and at which the third ends. */
static void frame_stages(run *r, const stilb_frustum *frustum, uint64_t at[4])
{
	expect(stilb_render_frame_begin(r->render));
	at[0] = bench_child_now_ns();
	expect(stilb_cull_run(r->cull, STILB_CULL_AUTO, r->scene, frustum, r->pool, OWNER, &r->visible));
	at[1] = bench_child_now_ns();
	expect(stilb_render_record(r->render, 0, r->scene, r->visible.ids, r->visible.count, r->pool, OWNER));
	at[2] = bench_child_now_ns();
	replay(r, r->pool);
	at[3] = bench_child_now_ns();
}

static void measure_frame(run *r)
{
	stilb_frustum frustum = stilb_frustum_from_matrix(&r->view.view_projection);
	uint64_t at[4];
	expect(stilb_cull_create(r->scene, &r->cull));
	stilb_job_phase_begin(r->pool);
	for (int i = 0; i < WARM_UP_FRAMES; i++)
		frame_stages(r, &frustum, at);
	while (time_left(r, &first)) {
		frame_stages(r, &frustum, at);
		record_samples_add(&first, at[3] - at[0]);
		record_samples_add(&second, at[1] - at[0]);
		record_samples_add(&third, at[2] - at[1]);
		record_samples_add(&fourth, at[3] - at[2]);
	}
	stilb_job_phase_end(r->pool);
	bench_child_metric("frame", record_samples_median(&first) * 1e-6);
	bench_child_metric("cull", record_samples_median(&second) * 1e-3);
	bench_child_metric("record", record_samples_median(&third) * 1e-3);
	bench_child_metric("replay", record_samples_median(&fourth) * 1e-3);
	stilb_cull_visible_finish(&r->visible);
	stilb_cull_destroy(r->cull);
}

static void measure_picture(run *r)
{
	record_picture_times times = {0};
	do {
		expect(stilb_render_frame_begin(r->render));
		record(r, r->pool);
		uint64_t begin = bench_child_now_ns();
		replay(r, r->pool);
		uint64_t end = bench_child_now_ns();
		expect(stilb_render_present(r->render));
		record_samples_add(&second, end - begin);
	} while (record_picture_frame(&times, &first, r->until));
	record_picture_print(&times, &first);
	bench_child_metric("replay", ns_per_draw(r, &second));
}

static void (*const measures[])(run *r) = {
	[RECORD_DRAWS] = measure_draws,     [RECORD_PHASE] = measure_phase, [RECORD_PARKED] = measure_parked,
	[RECORD_REPLAY] = measure_replay,   [RECORD_SORT] = measure_sort,   [RECORD_FRAME] = measure_frame,
	[RECORD_PICTURE] = measure_picture, [RECORD_VIEWS] = measure_views,
};

/* ---- verification ------------------------------------------------------------------------------------------------ */

static const uint64_t *sorted_keys; /* the keys that order_by_key compares, since qsort passes no context */

static int order_by_key(const void *a, const void *b)
{
	uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
	uint64_t key_x = sorted_keys[x], key_y = sorted_keys[y];
	return key_x != key_y ? (key_x > key_y) - (key_x < key_y) : (x > y) - (x < y);
}

/* The begin of the stream hash: of a view whose lights are all directional. */
static uint64_t hash_view(const stilb_render_view *view)
{
	uint64_t hash = stilb_hash_fnv1a64(STILB_FNV1A64_START, &view->shading, sizeof view->shading);
	uint32_t glossy = view->surroundings.glossy, both_sides = view->both_sides;
	hash = stilb_hash_fnv1a64(hash, view->surroundings.sky, sizeof view->surroundings.sky);
	hash = stilb_hash_fnv1a64(hash, view->surroundings.ground, sizeof view->surroundings.ground);
	hash = stilb_hash_fnv1a64(hash, &glossy, sizeof glossy);
	hash = stilb_hash_fnv1a64(hash, &both_sides, sizeof both_sides);
	hash = stilb_hash_fnv1a64(hash, &view->light_count, sizeof view->light_count);
	for (uint32_t i = 0; i < view->light_count; i++) {
		const stilb_scene_light *light = &view->lights[i];
		float numbers[20] = {[3] = (float)light->kind};
		memcpy(&numbers[4], light->direction, sizeof light->direction);
		memcpy(&numbers[8], light->intensity, sizeof light->intensity);
		hash = stilb_hash_fnv1a64(hash, numbers, sizeof numbers);
	}
	return hash;
}

/* The stream hash (render.h) of all draws in scene order, or for RECORD_SORT in the order of their keys. */
static uint64_t expected_hash(const run *r)
{
	uint32_t *order = record_alloc(r->draws, sizeof *order);
	for (uint32_t i = 0; i < r->draws; i++)
		order[i] = i;
	sorted_keys = r->keys;
	if (r->pass.sort)
		qsort(order, r->draws, sizeof *order, order_by_key);
	uint64_t hash = hash_view(&r->view);
	for (uint32_t k = 0; k < r->draws; k++) {
		uint32_t i = order[k], ids[2] = {r->scene->part_mesh[i], r->scene->part_material[i]};
		hash = stilb_hash_fnv1a64(hash, ids, sizeof ids);
		hash = stilb_hash_fnv1a64(hash, r->scene->part_transform[i].m, sizeof r->scene->part_transform[i].m);
		hash = stilb_hash_fnv1a64(hash, &r->scene->meshes[ids[0]].index_count, sizeof(uint32_t));
	}
	free(order);
	return hash;
}

static void verify(const run *r)
{
	if (stilb_render_stats_get(r->render).draws != r->draws)
		bench_child_fail("wrong result: %llu draws were replayed instead of %u",
		                 (unsigned long long)stilb_render_stats_get(r->render).draws, r->draws);
	if (r->on->textures == RECORD_NO_TEXTURES && stilb_render_stream_hash(r->render) != expected_hash(r))
		bench_child_fail("wrong result: what was replayed is not the scene");
	if (r->on->kind != RECORD_PICTURE)
		return;
	stilb_image image;
	expect(stilb_render_read_image(r->render, &image));
	record_picture_check(record_picture_sum(image.pixels, (size_t)image.width * image.height), r->child->argument);
	stilb_image_finish(&image);
}

/* ---- the program ------------------------------------------------------------------------------------------------- */

static stilb_job_pool *make_pool(uint32_t threads)
{
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	stilb_job_pool *pool;
	desc.worker_count = threads - 1;
	if (stilb_job_pool_create(&desc, &pool) != 0)
		bench_child_fail("cannot start the job system");
	return pool;
}

static void make_render(run *r)
{
	bool picture = r->on->kind == RECORD_PICTURE;
	stilb_render_desc desc = {
		.device = picture ? STILB_RENDER_DEVICE_VULKAN : STILB_RENDER_DEVICE_NULL,
		.replay = r->subject->replay,
		.materials = materials[r->on->materials],
		.gpu = picture ? "llvmpipe" : NULL,
		.width = RECORD_WIDTH,
		.height = RECORD_HEIGHT,
		.samples = 1,
		.context_count = r->on->threads,
		.float_vertices = true, /* as the bare program: pictures are compared bit by bit */
	};
	expect(stilb_render_create(&desc, &r->render));
	expect(stilb_render_set_scene(r->render, r->scene));
}

static const stilb_image_format formats[] = {STILB_IMAGE_U8_SRGB, STILB_IMAGE_U8_LINEAR, STILB_IMAGE_U16_LINEAR};

/* Gives the material a surface with a texture, both its own. */
static void give_texture(run *r, uint32_t material)
{
	uint32_t kind = (uint32_t)(stilb_random_u64(2, material) % 72), texture, surface;
	uint32_t width = 4, height = 4;
	stilb_scene_surface with = stilb_scene_surface_make();
	stilb_scene_material changed = r->scene->materials[material];
	stilb_image_format format = STILB_IMAGE_U8_SRGB;
	if (r->on->textures == RECORD_SIZES) {
		width += kind / 6;
		format = formats[kind % 3];
		with.maps[STILB_SCENE_MAP_COLOR].nearest = kind / 3 % 2;
	} else if (r->on->textures == RECORD_ALL_SIZES) {
		width = 1 + material % 150;
		height = 1 + material / 150;
	}
	stilb_image image;
	expect(stilb_image_create(&image, width, height, 4, format));
	expect(stilb_scene_add_texture(r->scene, &image, &texture));
	stilb_image_finish(&image);
	with.maps[STILB_SCENE_MAP_COLOR].texture = texture + 1;
	expect(stilb_scene_add_surface(r->scene, &with, &surface));
	changed.surface = surface + 1;
	expect(stilb_scene_set_material(r->scene, material, &changed));
}

static void make_scene(run *r)
{
	expect(stilb_scene_create_stress(r->on->models, 1, &r->scene));
	for (uint32_t m = 0; m < r->scene->material_count && r->on->textures != RECORD_NO_TEXTURES; m++)
		give_texture(r, m);
	stilb_scene_changes_clear(r->scene);
	r->draws = r->scene->part_count;
	r->models = record_alloc(r->scene->model_count, sizeof *r->models);
	for (uint32_t i = 0; i < r->scene->model_count; i++)
		r->models[i] = i;
	r->view = (stilb_render_view){
		.view_projection = stilb_scene_camera_matrix(&r->scene->camera, (float)RECORD_WIDTH / (float)RECORD_HEIGHT),
		.lights = r->scene->lights,
		.light_count = r->scene->light_count,
		.surroundings = r->scene->surroundings,
		.backdrop = {.kind = STILB_SCENE_BACKDROP_COLOR}, /* the sky's colour, as of the bare program: no horizon */
		.shading = stilb_render_shading_default(),
	};
	memcpy(r->view.camera_position, r->scene->camera.position, sizeof r->view.camera_position);
	memcpy(r->view.backdrop.color, r->scene->surroundings.sky, sizeof r->view.backdrop.color);
	r->pass = (stilb_render_pass){.name = "main"};
}

static void make_objects(run *r)
{
	r->objects = record_alloc(r->draws, sizeof *r->objects);
	r->keys = record_alloc(r->draws, sizeof *r->keys);
	for (uint32_t i = 0; i < r->draws; i++) {
		r->objects[i] = (object){
			.mesh = stilb_render_scene_mesh(r->render, r->scene->part_mesh[i]),
			.material = stilb_render_scene_material(r->render, r->scene->part_material[i]),
		};
		r->keys[i] = stilb_random_u64(1, i) & 0xffffff;
	}
}

static const struct subject *find_subject(const char *name)
{
	for (size_t i = 0; i < sizeof subjects / sizeof *subjects; i++)
		if (strcmp(subjects[i].name, name) == 0)
			return &subjects[i];
	bench_child_fail("no subject %s", name);
}

int main(int argc, char **argv)
{
	bench_child child = bench_child_args(argc, argv);
	stilb_prof_record_set(false); /* else the cost of recording profiler zones would be measured, too */
	run r = {.subject = find_subject(child.subject), .on = record_case_find(child.case_name), .child = &child};
	if (record_picture_skips(r.on, child.argument))
		return BENCH_CHILD_SKIP;
	make_scene(&r);
	make_render(&r);
	make_objects(&r);
	r.alone = make_pool(1);
	r.pool = make_pool(r.on->threads);
	r.until = record_deadline(child.seconds);
	measures[r.on->kind](&r);
	verify(&r);
	stilb_job_pool_destroy(r.pool);
	stilb_job_pool_destroy(r.alone);
	stilb_render_destroy(r.render);
	stilb_scene_destroy(r.scene);
	free(r.objects);
	free(r.keys);
	free(r.models);
	return 0;
}
