/* Lists of lights by compute: the same bits as those of jobs, for random lights of every kind in views with and without
 * perspective; the same pictures in each way of lighting, also where lists have no room. Under the validation layer. */
#include "light/light_reference.h"

#include "render/maps/maps_stage.h" /* names a type as these name variables */

#define WIDTH 99u /* odd: the last cells of a row are narrow */
#define HEIGHT 67u
#define LIGHTS 10000u
#define MANY 100000u
#define MODELS 64u

typedef struct made {
	stilb_render *render;
	stilb_job_pool *pool;
	stilb_scene *scene;
	stilb_scene_light *lights; /* [light_count] */
	stilb_render_view view;
	stilb_gpu_buffer copy; /* of the lists of the last frame, with `bytes`; {0}: they were by jobs */
	uint64_t bytes;
} made;

/* Copies the lists that a frame makes. */
static stilb_result made_copy(void *user, stilb_gpu_plan *plan, uint16_t *image)
{
	made *m = user;
	(void)image;
	stilb_gpu *gpu = stilb_render_gpu(m->render);
	uint16_t lists = stilb_gpu_plan_find(plan, "light lists 0");
	if (m->bytes > 0) {
		assert_int_equal(stilb_render_wait(m->render), STILB_OK);
		stilb_gpu_buffer_destroy(gpu, m->copy);
	}
	m->bytes = 0;
	if (lists == 0)
		return STILB_OK;
	const stilb_light_lists *l = &m->render->lists;
	uint64_t words = (uint64_t)l->columns * l->rows * l->slices + 1 + l->light_count - l->everywhere_count;
	uint32_t room = m->render->device->rooms[0], most = m->render->device->most_room;
	m->bytes = sizeof(render_light_lists) + (words + (room < most ? room : most)) * sizeof(uint32_t);
	stilb_gpu_buffer_desc desc = {
		.name = "copy", .bytes = m->bytes, .memory = STILB_GPU_MEMORY_READ, .uses = STILB_GPU_BUFFER_COPY};
	assert_int_equal(stilb_gpu_buffer_create(gpu, &desc, &m->copy), STILB_OK);
	uint16_t copy = stilb_gpu_plan_buffer(
		plan, &(stilb_gpu_plan_buffer_row){.name = "copy", .bytes = m->bytes, .owned = m->copy.id});
	stilb_gpu_plan_pass(plan, &(stilb_gpu_pass){.name = "copy",
	                                            .kind = STILB_GPU_PASS_COPY,
	                                            .uses = {{.resource = lists, .how = STILB_GPU_USE_COPY_FROM},
	                                                     {.resource = copy, .how = STILB_GPU_USE_COPY_TO}},
	                                            .use_count = 2});
	return STILB_OK;
}

static void made_open(made *m, uint32_t width, uint32_t height, uint32_t lamps)
{
	*m = (made){0};
	stilb_render_desc desc = {.device = STILB_RENDER_DEVICE_VULKAN,
	                          .width = width,
	                          .height = height,
	                          .samples = 1,
	                          .output = STILB_RENDER_OUTPUT_LINEAR,
	                          .context_count = 2,
	                          .validate = true};
	if (stilb_render_create(&desc, &m->render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(stilb_job_pool_create(&(stilb_job_pool_desc){.worker_count = 1}, &m->pool), 0);
	assert_int_equal(stilb_scene_create_stress(MODELS, 7, &m->scene), STILB_OK);
	if (lamps > 0)
		assert_int_equal(stilb_scene_stress_add_lamps(m->scene, lamps), STILB_OK);
	assert_int_equal(stilb_render_set_scene(m->render, m->scene), STILB_OK);
	stilb_render_feature feature = {.stage = STILB_RENDER_STAGE_LAST, .add = made_copy, .user = m};
	assert_int_equal(stilb_render_add_feature(m->render, &feature), STILB_OK);
	stilb_scene_camera camera = stilb_scene_stress_camera(m->scene, STILB_SCENE_VIEW_FEW, (float)width / (float)height);
	m->view = (stilb_render_view){.view_projection = stilb_scene_camera_matrix(&camera, (float)width / (float)height),
	                              .lights = m->scene->lights,
	                              .light_count = m->scene->light_count,
	                              .lighting = STILB_RENDER_LIGHTING_CLUSTERED,
	                              .surroundings = m->scene->surroundings,
	                              .backdrop = {.kind = STILB_SCENE_BACKDROP_SURROUNDINGS},
	                              .shading = stilb_render_shading_default()};
	memcpy(m->view.camera_position, camera.position, sizeof m->view.camera_position);
}

static void made_close(made *m)
{
	assert_int_equal(stilb_render_wait(m->render), STILB_OK);
	assert_int_equal(stilb_render_validation_messages(m->render), 0);
	if (m->bytes > 0)
		stilb_gpu_buffer_destroy(stilb_render_gpu(m->render), m->copy);
	stilb_render_destroy(m->render);
	stilb_scene_destroy(m->scene);
	stilb_job_pool_destroy(m->pool);
	free(m->lights);
}

static void made_frame(made *m, stilb_render_light_lists who)
{
	uint32_t ids[MODELS];
	for (uint32_t i = 0; i < MODELS; i++)
		ids[i] = i;
	m->view.light_lists = who;
	assert_int_equal(stilb_render_frame_begin(m->render), STILB_OK);
	assert_int_equal(stilb_render_record(m->render, 0, m->scene, ids, MODELS, m->pool, 0), STILB_OK);
	if (stilb_render_replay(m->render, &(stilb_render_pass){.name = "main"}, 1, &m->view, 1, m->pool, 0) != STILB_OK)
		fail_msg("%s", stilb_error_message());
}

static stilb_image made_picture(made *m, stilb_render_light_lists who)
{
	stilb_image image = {0};
	made_frame(m, who);
	if (stilb_render_read_image(m->render, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(m->bytes > 0, who == STILB_RENDER_LIGHT_LISTS_COMPUTE);
	return image;
}

/* ---- lists ------------------------------------------------------------------------------------------------------- */

/* Makes the view's lists by jobs, then by compute, and compares them. Returns how many pairs they have. */
static uint32_t assert_same_lists(made *m, const char *what)
{
	made_frame(m, STILB_RENDER_LIGHT_LISTS_JOBS);
	const stilb_light_lists *lists = &m->render->lists;
	size_t cells = (size_t)lists->columns * lists->rows * lists->slices;
	uint32_t count = lists->id_count, listed = lists->light_count - lists->everywhere_count;
	uint32_t *starts = malloc((cells + 1) * sizeof *starts), *ids = malloc((count + 1) * sizeof *ids);
	assert_non_null(starts);
	assert_non_null(ids);
	memcpy(starts, lists->starts, (cells + 1) * sizeof *starts);
	memcpy(ids, lists->ids, count * sizeof *ids);
	made_frame(m, STILB_RENDER_LIGHT_LISTS_COMPUTE);
	assert_int_equal(stilb_render_wait(m->render), STILB_OK);
	assert_true(m->bytes > 0);
	const render_light_lists *got = stilb_gpu_buffer_mapped(stilb_render_gpu(m->render), m->copy);
	assert_memory_equal(got->depth_plane, lists->depth_plane, sizeof got->depth_plane);
	assert_memory_equal(&got->slice_scale, &lists->slice_scale, sizeof got->slice_scale);
	assert_memory_equal(&got->slice_bias, &lists->slice_bias, sizeof got->slice_bias);
	assert_int_equal(got->all, listed);
	for (uint32_t i = 0; i < listed; i++)
		assert_int_equal(got->words[cells + 1 + i], i);
	for (size_t c = 0; c <= cells; c++)
		if (got->words[c] != starts[c])
			fail_msg("%s: list %zu of %zu begins at %u, by jobs at %u", what, c, cells, got->words[c], starts[c]);
	const uint32_t *got_ids = got->words + cells + 1 + listed;
	for (uint32_t i = 0; i < count; i++)
		if (got_ids[i] != ids[i])
			fail_msg("%s: id %u of %u is %u, by jobs %u", what, i, count, got_ids[i], ids[i]);
	printf("%s: %u lights in %zu cells, %u pairs\n", what, listed, cells, count);
	free(starts);
	free(ids);
	return count;
}

static void random_lights(made *m, light_random *random, double reach)
{
	if (!m->lights)
		m->lights = malloc(LIGHTS * sizeof *m->lights);
	assert_non_null(m->lights);
	for (uint32_t i = 0; i < LIGHTS; i++) {
		m->lights[i] = draw_light(random, 10.0, reach);
		assert_null(stilb_scene_light_mistake(&m->lights[i]));
	}
	m->view.lights = m->lights;
	m->view.light_count = LIGHTS;
}

static void the_same_lists(void **state)
{
	(void)state;
	static const char *const names[] = {"from the side", "from within", "of a long lens", "parallel"};
	static const double eyes[3][3] = {{14, 6, 9}, {1, 0.5, -2}, {40, -30, 25}}, lenses[3] = {1.2, 0.7, 8.0};
	light_random random = {.seed = 3};
	made m;
	made_open(&m, WIDTH, HEIGHT, 0);
	for (int v = 0; v < 4; v++) {
		random_lights(&m, &random, v == 1 ? 3.0 : 1.0);
		if (v < 3) {
			reference_camera camera = reference_camera_at((dvec){eyes[v][0], eyes[v][1], eyes[v][2]}, (dvec){0, 0, 0},
			                                              (dvec){0, 1, 0}, lenses[v], WIDTH, HEIGHT);
			m.view.view_projection = reference_matrix(&camera);
		} else {
			m.view.view_projection = orthographic(9.0f, 6.0f, -20.0f, 20.0f);
		}
		assert_true(assert_same_lists(&m, names[v]) > 10000);
	}
	made_close(&m);
}

/* Lists without lights; and views that no light reaches. */
static void no_lights(void **state)
{
	(void)state;
	made m;
	made_open(&m, WIDTH, HEIGHT, 60);
	for (uint32_t i = 0; i < m.scene->light_count; i++)
		m.scene->lights[i].position[1] += 1e6f;
	assert_int_equal(assert_same_lists(&m, "out of sight"), 0);
	stilb_image all = made_picture(&m, STILB_RENDER_LIGHT_LISTS_JOBS);
	stilb_image got = made_picture(&m, STILB_RENDER_LIGHT_LISTS_COMPUTE);
	assert_memory_equal(all.pixels, got.pixels, stilb_image_size(&all));
	stilb_image_finish(&all);
	stilb_image_finish(&got);
	m.view.light_count = 0;
	made_frame(&m, STILB_RENDER_LIGHT_LISTS_COMPUTE);
	made_close(&m);
}

static void lists_of_a_city(void **state)
{
	(void)state;
	made m;
	made_open(&m, 64, 36, MANY);
	assert_true(assert_same_lists(&m, "a city") > MANY);
	made_close(&m);
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

static void assert_same_picture(made *m, const char *what, const stilb_image *by_jobs, uint32_t room)
{
	m->render->device->most_room = room;
	for (int frame = 0; frame < 2; frame++) {
		stilb_image got = made_picture(m, STILB_RENDER_LIGHT_LISTS_COMPUTE);
		assert_int_equal(stilb_render_stats_get(m->render).light_pairs > 0, 1);
		if (memcmp(got.pixels, by_jobs->pixels, stilb_image_size(&got)) != 0)
			fail_msg("%s, room %u, frame %d: another picture than by jobs", what, room, frame);
		stilb_image_finish(&got);
	}
	m->render->device->most_room = UINT32_MAX;
}

static void the_same_pictures(void **state)
{
	(void)state;
	static const stilb_render_lighting ways[] = {
		STILB_RENDER_LIGHTING_CLUSTERED,     STILB_RENDER_LIGHTING_DEFERRED, STILB_RENDER_LIGHTING_TILED_DEFERRED,
		STILB_RENDER_LIGHTING_TILED_FORWARD, STILB_RENDER_LIGHTING_INDEXED,  STILB_RENDER_LIGHTING_PREPASS,
		STILB_RENDER_LIGHTING_PRELIGHT};
	made m;
	made_open(&m, WIDTH, HEIGHT, 230);
	for (size_t w = 0; w < sizeof ways / sizeof *ways; w++) {
		m.view.lighting = ways[w];
		stilb_image by_jobs = made_picture(&m, STILB_RENDER_LIGHT_LISTS_JOBS);
		uint32_t pairs = m.render->lists.id_count;
		const char *name = stilb_render_lighting_names[ways[w]];
		assert_true(pairs > 100);
		assert_same_picture(&m, name, &by_jobs, UINT32_MAX);
		assert_same_picture(&m, name, &by_jobs, pairs);
		assert_same_picture(&m, name, &by_jobs, pairs / 2);
		assert_same_picture(&m, name, &by_jobs, 1);
		stilb_image_finish(&by_jobs);
	}
	made_close(&m);
}

/* A view whose lists become longer than there is room for: the frame itself is right, and later ones have room. */
static void more_than_there_is_room_for(void **state)
{
	(void)state;
	made m;
	made_open(&m, WIDTH, HEIGHT, 1000);
	m.view.light_count = 20;
	made_frame(&m, STILB_RENDER_LIGHT_LISTS_JOBS);
	made_frame(&m, STILB_RENDER_LIGHT_LISTS_COMPUTE);
	uint32_t few = m.render->device->rooms[0];
	m.view.light_count = m.scene->light_count;
	stilb_image got = made_picture(&m, STILB_RENDER_LIGHT_LISTS_COMPUTE);
	assert_int_equal(m.render->device->rooms[0], few);
	stilb_image by_jobs = made_picture(&m, STILB_RENDER_LIGHT_LISTS_JOBS);
	assert_true(m.render->lists.id_count > few);
	assert_memory_equal(got.pixels, by_jobs.pixels, stilb_image_size(&got));
	stilb_image_finish(&by_jobs);
	stilb_image_finish(&got);
	m.view.light_count = 20;
	for (int frame = 0; frame < 4; frame++)
		made_frame(&m, STILB_RENDER_LIGHT_LISTS_COMPUTE);
	m.view.light_count = m.scene->light_count;
	for (uint32_t frame = 0; frame <= STILB_GPU_FRAMES; frame++)
		made_frame(&m, STILB_RENDER_LIGHT_LISTS_COMPUTE);
	assert_true(m.render->device->rooms[0] >= m.render->device->pairs[0]);
	assert_int_equal(m.render->device->pairs[0], stilb_render_stats_get(m.render).light_pairs);
	assert_true(m.render->device->pairs[0] > few);
	made_close(&m);
}

/* More lights at the viewer than software devices' loops take turns: deferred lighting without lists adds them up in
 * several passes, and of lists it is told. All but the last are so weak that they are not seen. */
static void more_lights_than_turns(void **state)
{
	(void)state;
	enum { COUNT = 14000, BRIGHT = 100 };
	made m;
	made_open(&m, 16, 9, 60);
	m.lights = malloc(COUNT * sizeof *m.lights);
	assert_non_null(m.lights);
	for (uint32_t i = 0; i < COUNT; i++) {
		m.lights[i] = m.scene->lights[1];
		m.lights[i].kind = STILB_SCENE_LIGHT_POINT;
		m.lights[i].reach = 1000.0f;
		reference_set3(m.lights[i].intensity, 1.0f, 1.0f, 1.0f);
		if (i < COUNT - BRIGHT)
			reference_set3(m.lights[i].intensity, 1e-6f, 1e-6f, 1e-6f);
		memcpy(m.lights[i].position, m.view.camera_position, sizeof m.lights[i].position);
	}
	m.view.lights = m.lights + COUNT - BRIGHT;
	m.view.light_count = BRIGHT;
	m.view.lighting = STILB_RENDER_LIGHTING_DEFERRED;
	stilb_image few = made_picture(&m, STILB_RENDER_LIGHT_LISTS_JOBS);
	m.view.lights = m.lights;
	m.view.light_count = COUNT;
	for (int c = STILB_RENDER_COVERAGE_SCREEN; c <= STILB_RENDER_COVERAGE_RECTANGLES; c++) {
		m.view.deferred.coverage = (stilb_render_coverage)c;
		stilb_image all = made_picture(&m, STILB_RENDER_LIGHT_LISTS_JOBS);
		for (uint32_t i = 0; i < 16 * 9; i++) {
			double want = picture_value(&few, i % 16, i / 16, 1), got = picture_value(&all, i % 16, i / 16, 1);
			if (!(fabs(got - want) <= 0.05 * want))
				fail_msg("%s, pixel %u: %g, and %g of the bright lights", stilb_render_coverage_names[c], i, got, want);
		}
		stilb_image_finish(&all);
	}
	stilb_image_finish(&few);
	assert_false(m.render->told_loop);
	m.view.deferred.coverage = STILB_RENDER_COVERAGE_CELLS;
	made_frame(&m, STILB_RENDER_LIGHT_LISTS_JOBS);
	assert_int_equal(m.render->told_loop, stilb_gpu_is_software(stilb_render_gpu(m.render)));
	made_close(&m);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_same_lists),
		cmocka_unit_test(no_lights),
		cmocka_unit_test(lists_of_a_city),
		cmocka_unit_test(the_same_pictures),
		cmocka_unit_test(more_than_there_is_room_for),
		cmocka_unit_test(more_lights_than_turns),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
