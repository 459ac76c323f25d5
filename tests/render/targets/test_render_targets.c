/* Scene passes into images of their own: second cameras within the picture, main images of another size, depth alone.
 * Each is compared with the same view drawn as a picture of its own, bit for bit where sizes agree. */
#include "geometry/geometry_impostor.h"
#include "gpu/gpu_internal.h"
#include "render/render_dump.h"
#include "render/render_internal.h"
#include "support/folder.h"
#include "support/picture_reference.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WIDTH 99u /* odd, and the insets too */
#define HEIGHT 67u
#define FEW (TEST_ASAN || TEST_TSAN) /* fewer devices, whose programs take most of the time */

static bool null_device;

/* ---- a renderer with something of every kind --------------------------------------------------------------------- */

typedef struct stage {
	stilb_render *render;
	stilb_job_pool *pool;
	stilb_render_mesh ball, tile;
	stilb_render_texture textures[2];
	stilb_render_material plain, checked[2];
	stilb_render_impostor impostor;
	stilb_gpu_plan *seen; /* of the last frame, by a feature that marks `shown` as read */
	const char *shown;
} stage;

static stilb_result mark_shown(void *user, stilb_gpu_plan *plan, uint16_t *image)
{
	const stage *s = user;
	(void)image;
	uint16_t found = s->shown ? stilb_gpu_plan_find(plan, s->shown) : 0;
	if (found)
		stilb_gpu_plan_show(plan, found);
	return STILB_OK;
}

static stilb_render_texture make_texture(stilb_render *render, uint8_t bright)
{
	stilb_image image;
	stilb_render_texture texture;
	assert_int_equal(stilb_image_create(&image, 4, 4, 3, STILB_IMAGE_U8_SRGB), STILB_OK);
	for (size_t i = 0; i < stilb_image_size(&image); i++)
		((uint8_t *)image.pixels)[i] = (uint8_t)((i / 3 + i / 12) % 2 ? bright : 40);
	assert_int_equal(stilb_render_texture_create(render, &image, &texture), STILB_OK);
	stilb_image_finish(&image);
	return texture;
}

static void make_impostor(stage *s, const stilb_scene_mesh *mesh)
{
	static const stilb_scene_material material = {.diffuse = {0.2f, 0.6f, 0.3f}, .roughness = 1.0f};
	stilb_geometry_impostor_part part = {.mesh = mesh, .material = &material};
	stilb_geometry_impostor_desc desc = {.grid = 5, .side = 24, .samples = 2};
	stilb_scene_impostor impostor;
	assert_int_equal(stilb_geometry_impostor_bake(&part, 1, &desc, s->pool, 0, &impostor), STILB_OK);
	assert_int_equal(stilb_render_impostor_create(s->render, &impostor, &s->impostor), STILB_OK);
	stilb_scene_impostor_finish(&impostor);
}

static stage stage_open(stilb_render_desc desc, uint32_t workers)
{
	stage s = {0};
	static const stilb_scene_material white = {
		.diffuse = {0.7f, 0.6f, 0.5f}, .specular = {0.1f, 0.1f, 0.1f}, .roughness = 0.4f};
	stilb_scene_mesh ball, tile;
	desc.device = null_device ? STILB_RENDER_DEVICE_NULL : STILB_RENDER_DEVICE_VULKAN;
	desc.width = desc.width ? desc.width : WIDTH;
	desc.height = desc.height ? desc.height : HEIGHT;
	desc.samples = desc.samples ? desc.samples : 1;
	desc.context_count = workers + 1;
	desc.keep_textures = true;
	desc.validate = true;
	if (stilb_render_create(&desc, &s.render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(stilb_job_pool_create(&(stilb_job_pool_desc){.worker_count = workers}, &s.pool), 0);
	assert_int_equal(stilb_scene_mesh_sphere(2, &ball), STILB_OK);
	assert_int_equal(stilb_scene_mesh_plane(&tile), STILB_OK);
	assert_int_equal(stilb_render_mesh_create(s.render, &ball, &s.ball), STILB_OK);
	assert_int_equal(stilb_render_mesh_create(s.render, &tile, &s.tile), STILB_OK);
	assert_int_equal(stilb_render_material_create(s.render, &white, (stilb_render_texture){0}, &s.plain), STILB_OK);
	for (uint32_t t = 0; t < 2; t++) {
		s.textures[t] = make_texture(s.render, t ? 250 : 140);
		assert_int_equal(stilb_render_material_create(s.render, &white, s.textures[t], &s.checked[t]), STILB_OK);
	}
	make_impostor(&s, &ball);
	stilb_scene_mesh_finish(&ball);
	stilb_scene_mesh_finish(&tile);
	return s;
}

static void stage_close(stage *s)
{
	assert_int_equal(stilb_render_wait(s->render), STILB_OK);
	assert_int_equal(stilb_render_validation_messages(s->render), 0);
	stilb_render_destroy(s->render);
	stilb_job_pool_destroy(s->pool);
}

/* Plain and textured meshes that overlap, one that fades, and an impostor; in one segment or two. */
static void record(stage *s, uint32_t pass)
{
	assert_int_equal(stilb_render_pass_begin(s->render, pass, 2), STILB_OK);
	for (uint32_t segment = 0; segment < 2; segment++) {
		stilb_render_context *context =
			stilb_render_context_get(s->render, segment % (stilb_job_pool_worker_count(s->pool) + 1));
		stilb_render_segment_begin(context, pass, segment);
		for (uint32_t i = 0; i < 6; i++) {
			stilb_mat4 m = stilb_mat4_scale_translate(0.5f, -1.5f + 0.6f * (float)i, segment ? 0.4f : 0.0f,
			                                          -0.7f + 0.3f * (float)(i % 4));
			stilb_render_material material = i % 3 == 0 ? s->plain : s->checked[i % 3 - 1];
			stilb_render_draw(context, i % 2 ? s->tile : s->ball, material, &m);
		}
		stilb_mat4 fading = stilb_mat4_scale_translate(0.6f, segment ? 1.2f : -1.1f, 0.7f, 0.4f);
		render_draw_level(context, 0, s->ball, s->checked[1], &fading, 0, segment ? 9u : 32u + 20u, 1);
		stilb_mat4 far = stilb_mat4_scale_translate(0.5f, segment ? -0.4f : 0.5f, 0.8f, -0.6f);
		stilb_render_draw(context, s->impostor.mesh, s->impostor.material, &far);
		stilb_render_segment_end(context);
	}
	assert_int_equal(stilb_render_pass_end(s->render, pass), STILB_OK);
}

/* Camera number `which`, for a picture of this size. */
static stilb_render_view view_of(uint32_t which, uint32_t width, uint32_t height)
{
	static const dvec places[3] = {{1.7, 2.6, 3.1}, {-2.0, 1.2, 2.2}, {0.3, 3.5, -1.0}};
	static const stilb_scene_light sun = {
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {-0.6f, -0.8f, 0.0f}, .intensity = {2.0f, 2.0f, 2.0f}};
	reference_camera camera =
		reference_camera_at(places[which], (dvec){0.0, 0.3, 0.0}, (dvec){0, 1, 0}, 1.4, width, height);
	stilb_render_view view = {
		.view_projection = reference_matrix(&camera),
		.lights = &sun,
		.light_count = 1,
		.surroundings = {.sky = {0.2f, 0.3f, 0.5f}, .ground = {0.3f, 0.2f, 0.1f}},
		.backdrop = {.kind = STILB_SCENE_BACKDROP_SURROUNDINGS}, /* both are seen: drawn by a pass */
		.shading = stilb_render_shading_default(),
		.exposure = (float)which,
		.tone = which,
	};
	reference_set3(view.camera_position, (float)places[which].x, (float)places[which].y, (float)places[which].z);
	return view;
}

/* Draws the views, each as one pass. */
static stilb_result draw(stage *s, const stilb_render_view *views, uint32_t count)
{
	stilb_render_pass passes[STILB_RENDER_MAX_PASSES] = {0};
	assert_int_equal(stilb_render_frame_begin(s->render), STILB_OK);
	for (uint32_t p = 0; p < count; p++) {
		record(s, p);
		passes[p] = (stilb_render_pass){.name = "scene", .view = p, .order = p};
	}
	return stilb_render_replay(s->render, passes, count, views, count, s->pool, 0);
}

static void draw_well(stage *s, const stilb_render_view *views, uint32_t count)
{
	if (draw(s, views, count) != STILB_OK)
		fail_msg("%s", stilb_error_message());
}

static stilb_image picture(stage *s)
{
	stilb_image image;
	if (stilb_render_read_image(s->render, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return image;
}

/* The picture of a view alone, by a renderer of its size. */
static stilb_image picture_alone(uint32_t which, uint32_t width, uint32_t height, uint32_t samples)
{
	stage s = stage_open((stilb_render_desc){.width = width, .height = height, .samples = samples}, 0);
	stilb_render_view view = view_of(which, width, height);
	draw_well(&s, &view, 1);
	stilb_image image = picture(&s);
	stage_close(&s);
	return image;
}

/* A copy of an image of the last frame's plan: marked by stage.shown, or an output. */
static float *read_floats(stage *s, const char *name, uint32_t count)
{
	const stilb_gpu_plan *plan = stilb_render_plan(s->render);
	uint64_t ticket, frame;
	const void *bytes = NULL;
	if (stilb_gpu_read_begin(stilb_render_gpu(s->render), plan, stilb_gpu_plan_find(plan, name), 0, 0, &ticket) !=
	        STILB_OK ||
	    stilb_gpu_read_get(stilb_render_gpu(s->render), ticket, true, &bytes, &frame) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	float *floats = malloc(count * sizeof *floats);
	assert_non_null(floats);
	memcpy(floats, bytes, count * sizeof *floats);
	stilb_gpu_read_end(stilb_render_gpu(s->render), ticket);
	return floats;
}

/* True if a rectangle of the picture shows the other one. */
static bool shows(const stilb_image *image, const uint16_t place[4], const stilb_image *other)
{
	assert_int_equal(place[2], other->width);
	assert_int_equal(place[3], other->height);
	for (uint32_t y = 0; y < place[3]; y++)
		if (memcmp((uint8_t *)image->pixels + 3 * ((size_t)(place[1] + y) * image->width + place[0]),
		           (uint8_t *)other->pixels + 3 * (size_t)y * other->width, (size_t)3 * other->width) != 0)
			return false;
	return true;
}

/* ---- second cameras ---------------------------------------------------------------------------------------------- */

/* Two insets over the picture, the second one over a corner of the first. */
static void insets_are_pictures_of_their_own(void **state)
{
	(void)state;
	static const stilb_render_target first = {.name = "left", .width = 31, .height = 23, .place = {3, 5, 31, 23}};
	static const stilb_render_target second = {.name = "right", .width = 40, .height = 20, .place = {59, 47, 40, 20}};
	for (uint32_t samples = FEW ? 4 : 1; samples <= 4; samples += 3) {
		stage s = stage_open((stilb_render_desc){.samples = samples}, 0);
		stilb_image alone[3] = {picture_alone(0, WIDTH, HEIGHT, samples), picture_alone(1, 31, 23, samples),
		                        picture_alone(2, 40, 20, samples)};
		stilb_render_view views[3] = {view_of(0, WIDTH, HEIGHT), view_of(1, 31, 23), view_of(2, 40, 20)};
		views[1].target = &first;
		views[2].target = &second;
		for (uint32_t frame = 0; frame < 3; frame++) {
			draw_well(&s, views, 3);
			stilb_image image = picture(&s);
			assert_true(shows(&image, first.place, &alone[1]));
			assert_true(shows(&image, second.place, &alone[2]));
			uint32_t same = 0;
			for (uint32_t p = 0; p < WIDTH * HEIGHT; p++)
				same += memcmp((uint8_t *)image.pixels + 3 * p, (uint8_t *)alone[0].pixels + 3 * p, 3) == 0;
			assert_true(same >= WIDTH * HEIGHT - 31 * 23 - 40 * 20);
			stilb_image_finish(&image);
		}
		for (uint32_t i = 0; i < 3; i++)
			stilb_image_finish(&alone[i]);
		stage_close(&s);
	}
}

/* Tiles that leave a stripe of the picture free, and no main images at all. */
static void tiles_without_a_main_picture(void **state)
{
	(void)state;
	stilb_render_target tiles[2] = {
		{.name = "a", .width = 50, .height = 67, .place = {0, 0, 50, 67}},
		{.name = "b", .width = 40, .height = 67, .place = {50, 0, 40, 67}},
	};
	stage s = stage_open((stilb_render_desc){0}, 0);
	stilb_image alone[2] = {picture_alone(1, 50, 67, 1), picture_alone(2, 40, 67, 1)};
	stilb_render_view views[2] = {view_of(1, 50, 67), view_of(2, 40, 67)};
	views[0].target = &tiles[0];
	views[1].target = &tiles[1];
	draw_well(&s, views, 2);
	stilb_image image = picture(&s);
	assert_true(shows(&image, tiles[0].place, &alone[0]));
	assert_true(shows(&image, tiles[1].place, &alone[1]));
	tiles[1].border = 2;
	draw_well(&s, views, 2);
	stilb_image framed = picture(&s);
	for (uint32_t y = 0; y < 67; y++)
		for (uint32_t x = 0; x < 40; x++) {
			bool edge = x < 2 || x >= 38 || y < 2 || y >= 65;
			const uint8_t *got = (uint8_t *)framed.pixels + 3 * ((size_t)y * WIDTH + 50 + x);
			const uint8_t *want = (uint8_t *)alone[1].pixels + 3 * ((size_t)y * 40 + x);
			assert_memory_equal(got, edge ? (const uint8_t[3]){0} : want, 3);
		}
	stilb_image_finish(&framed);
	for (uint32_t y = 0; y < HEIGHT; y++)
		for (uint32_t x = 3 * 90; x < 3 * WIDTH; x++)
			assert_int_equal(((uint8_t *)image.pixels)[3 * y * WIDTH + x], 0);
	stilb_image none;
	assert_int_equal(stilb_render_read_radiance(s.render, &none), STILB_ERROR_DEVICE);
	stilb_image_finish(&image);
	stilb_image_finish(&alone[0]);
	stilb_image_finish(&alone[1]);
	stage_close(&s);
}

/* Main images of half and of one and a half times the picture's size: their radiance is that of a picture of that size,
 * and the picture is that radiance, filtered linearly and tone mapped. */
static void main_images_of_another_size(void **state)
{
	(void)state;
	static const uint32_t sizes[2][2] = {{50, 34}, {148, 100}};
	for (uint32_t i = 0; i < 2; i++) {
		uint32_t w = sizes[i][0], h = sizes[i][1];
		stilb_render_target scaled = {.name = "color", .width = w, .height = h, .place = {0, 0, WIDTH, HEIGHT}};
		stage s = stage_open((stilb_render_desc){.output = STILB_RENDER_OUTPUT_LINEAR}, 0);
		stage other = stage_open((stilb_render_desc){.width = w, .height = h, .output = STILB_RENDER_OUTPUT_LINEAR}, 0);
		stilb_render_view view = view_of(0, w, h);
		draw_well(&other, &view, 1);
		view.target = &scaled;
		draw_well(&s, &view, 1);
		memset(&scaled, 0xff, sizeof scaled); /* it is read during replay alone */
		stilb_image light, alone = picture(&other), image = picture(&s);
		assert_int_equal(stilb_render_read_radiance(s.render, &light), STILB_OK);
		assert_int_equal(light.width, w);
		assert_int_equal(light.height, h);
		assert_memory_equal(light.pixels, alone.pixels, stilb_image_size(&alone));
		double worst = 0.0;
		for (uint32_t y = 0; y < HEIGHT; y++)
			for (uint32_t x = 0; x < WIDTH; x++)
				for (int c = 0; c < 3; c++) {
					double u = fmax((x + 0.5) / WIDTH * w - 0.5, 0.0), v = fmax((y + 0.5) / HEIGHT * h - 0.5, 0.0);
					uint32_t left = (uint32_t)u, top = (uint32_t)v;
					uint32_t right = left + 1 < w ? left + 1 : left, below = top + 1 < h ? top + 1 : top;
					double a = u - left, b = v - top;
					double want =
						(picture_value(&light, left, top, c) * (1 - a) + picture_value(&light, right, top, c) * a) *
							(1 - b) +
						(picture_value(&light, left, below, c) * (1 - a) + picture_value(&light, right, below, c) * a) *
							b;
					worst = fmax(worst, fabs(picture_value(&image, x, y, c) - want) / (0.05 + want));
				}
		if (worst > 0.02) /* the filter's weights have 8 bits */
			fail_msg("%u x %u: off by %.3f", w, h, worst);
		stilb_image_finish(&light);
		stilb_image_finish(&alone);
		stilb_image_finish(&image);
		stage_close(&s);
		stage_close(&other);
	}
}

/* ---- depth alone ------------------------------------------------------------------------------------------------- */

/* The depth of a view with lights is that of the same view of depth alone, bit for bit, in all modes and ways to have
 * materials, also of what fades and of impostors; textures break no runs of it. */
static void depth_alone_is_the_depth(void **state)
{
	(void)state;
	static const stilb_render_target shadow = {
		.name = "shadow", .kind = STILB_RENDER_TARGET_DEPTH, .width = WIDTH, .height = HEIGHT, .output = true};
	for (uint32_t mode = FEW ? 2 : 0; mode < 3; mode++)
		for (uint32_t materials = 0; materials < (mode == 1 ? 3 : 1); materials++) {
			stilb_render_desc desc = {.replay = (stilb_render_replay_mode)mode,
			                          .materials = (stilb_render_materials)materials};
			stage s = stage_open(desc, mode == 2 ? 2 : 0);
			s.shown = "depth";
			stilb_render_feature feature = {STILB_RENDER_STAGE_LIGHT, mark_shown, &s};
			assert_int_equal(stilb_render_add_feature(s.render, &feature), STILB_OK);
			stilb_render_view views[2] = {view_of(0, WIDTH, HEIGHT), view_of(0, WIDTH, HEIGHT)};
			views[0].target = &shadow;
			draw_well(&s, views, 2);
			float *got = read_floats(&s, "shadow", WIDTH * HEIGHT), *want = read_floats(&s, "depth", WIDTH * HEIGHT);
			uint32_t covered = 0;
			for (uint32_t p = 0; p < WIDTH * HEIGHT; p++)
				covered += want[p] > 0.0f;
			assert_in_range(covered, 500, WIDTH * HEIGHT - 500);
			assert_memory_equal(got, want, WIDTH * HEIGHT * sizeof *got);
			free(got);
			free(want);
			stage_close(&s);
		}
}

/* A frame of depth alone: the picture is black, and commands are fewer than where surfaces are seen. */
static void depth_without_a_picture(void **state)
{
	(void)state;
	static const stilb_render_target shadow = {
		.name = "shadow", .kind = STILB_RENDER_TARGET_DEPTH, .width = 200, .height = 31, .output = true};
	stage s = stage_open((stilb_render_desc){0}, 0);
	stilb_render_view view = view_of(0, 200, 31);
	draw_well(&s, &view, 1);
	uint64_t lit = stilb_render_stats_get(s.render).indirect_commands;
	view.target = &shadow;
	draw_well(&s, &view, 1);
	uint64_t alone = stilb_render_stats_get(s.render).indirect_commands;
	assert_true(alone < lit);
	if (!null_device) {
		stilb_image image = picture(&s);
		for (size_t i = 0; i < stilb_image_size(&image); i++)
			assert_int_equal(((uint8_t *)image.pixels)[i], 0);
		stilb_image_finish(&image);
	}
	stage_close(&s);
}

/* What nobody reads is not drawn: the plan leaves the target's pass out. */
static void targets_that_nobody_reads(void **state)
{
	(void)state;
	static const stilb_render_target unread = {.name = "unread", .width = 20, .height = 20};
	stage s = stage_open((stilb_render_desc){.samples = 4}, 0);
	stilb_render_view views[2] = {view_of(0, WIDTH, HEIGHT), view_of(1, 20, 20)};
	views[1].target = &unread;
	draw_well(&s, views, 2);
	const stilb_gpu_plan *plan = stilb_render_plan(s.render);
	const stilb_gpu_step *steps;
	uint32_t count = stilb_gpu_plan_steps(plan, &steps), resolves = 0;
	for (uint32_t i = 0; i < count; i++)
		resolves += strcmp(stilb_gpu_plan_row(plan, steps[i].pass)->name, "resolve") == 0;
	assert_int_equal(resolves, 1);
	assert_int_equal(stilb_gpu_plan_passes(plan) - count, 3); /* its backdrop, its pass, its resolve */
	stage_close(&s);
}

/* ---- mistakes, dumps, threads ------------------------------------------------------------------------------------ */

static void mistakes_are_errors(void **state)
{
	(void)state;
	static const stilb_render_target wide = {.name = "wide", .width = 10, .height = 10, .place = {90, 0, 10, 10}};
	static const stilb_render_target twice[2] = {{.name = "twice", .width = 10, .height = 10, .place = {0, 0, 10, 10}},
	                                             {.name = "twice", .width = 10, .height = 10, .place = {9, 9, 10, 10}}};
	stage s = stage_open((stilb_render_desc){0}, 0);
	stilb_render_view views[2] = {view_of(0, WIDTH, HEIGHT), view_of(1, 10, 10)};
	views[1].target = &wide;
	assert_int_equal(draw(&s, views, 2), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "fills 10 x 10 texels at 90, 0, and 'picture' has 99 x 67"));
	views[0].target = &twice[0];
	views[1].target = &twice[1];
	assert_int_equal(draw(&s, views, 2), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "have the name 'twice'"));
	views[0].target = views[1].target = NULL;
	draw_well(&s, views, 2);
	stage_close(&s);
}

#define PATH "targets.dump"

/* A frame with an inset and a shadow, saved and played: the same stream, picture and depth. */
static void dumps_hold_targets(void **state)
{
	(void)state;
	static const stilb_render_target inset = {.name = "left", .width = 31, .height = 23, .place = {3, 5, 31, 23}};
	static const stilb_render_target shadow = {
		.name = "shadow", .kind = STILB_RENDER_TARGET_DEPTH, .width = 64, .height = 48, .output = true};
	stage s = stage_open((stilb_render_desc){0}, 0);
	stilb_render_view views[3] = {view_of(2, 64, 48), view_of(0, WIDTH, HEIGHT), view_of(1, 31, 23)};
	views[0].target = &shadow;
	views[2].target = &inset;
	draw_well(&s, views, 3);
	stilb_render_pass passes[3] = {
		{.name = "scene"}, {.name = "scene", .view = 1, .order = 1}, {.name = "scene", .view = 2, .order = 2}};
	assert_int_equal(stilb_render_dump_save(s.render, passes, 3, views, 3, PATH), STILB_OK);
	stilb_render_dump *dump;
	if (stilb_render_dump_load(PATH, &dump) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stilb_render_desc desc = {.device = null_device ? STILB_RENDER_DEVICE_NULL : STILB_RENDER_DEVICE_VULKAN,
	                          .width = WIDTH,
	                          .height = HEIGHT,
	                          .samples = 1,
	                          .context_count = 1,
	                          .validate = true};
	stage played = {.pool = s.pool};
	/* In a picture of another size places are as large a part of it; the largest sides that there are do fit. */
	desc.width = 200;
	desc.height = null_device ? 16384 : 40;
	assert_int_equal(stilb_render_create(&desc, &played.render), STILB_OK);
	assert_int_equal(stilb_render_dump_upload(dump, played.render), STILB_OK);
	assert_int_equal(stilb_render_frame_begin(played.render), STILB_OK);
	assert_int_equal(stilb_render_dump_record(dump, played.render, s.pool, 0), STILB_OK);
	if (stilb_render_dump_replay(dump, played.render, s.pool, 0) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	const stilb_gpu_plan *plan = stilb_render_plan(played.render);
	uint32_t placed = 0;
	for (uint32_t p = 0; p < stilb_gpu_plan_passes(plan); p++) {
		const uint16_t *area = stilb_gpu_plan_row(plan, p)->area;
		placed += area[0] == 6 && area[2] == 63 && area[3] == (23 * desc.height + 33) / 67; /* 3 and 34 of 99 */
	}
	assert_int_equal(placed, 1);
	stilb_render_destroy(played.render);
	desc.width = WIDTH;
	desc.height = HEIGHT;
	assert_int_equal(stilb_render_create(&desc, &played.render), STILB_OK);
	assert_int_equal(stilb_render_dump_upload(dump, played.render), STILB_OK);
	assert_int_equal(stilb_render_frame_begin(played.render), STILB_OK);
	assert_int_equal(stilb_render_dump_record(dump, played.render, s.pool, 0), STILB_OK);
	assert_int_equal(stilb_render_dump_replay(dump, played.render, s.pool, 0), STILB_OK);
	assert_true(stilb_render_stream_hash(played.render) == stilb_render_stream_hash(s.render));
	if (!null_device) {
		stilb_image want = picture(&s), got = picture(&played);
		assert_memory_equal(got.pixels, want.pixels, stilb_image_size(&want));
		float *depths = read_floats(&s, "shadow", 64 * 48), *again = read_floats(&played, "shadow", 64 * 48);
		assert_memory_equal(depths, again, 64 * 48 * sizeof *depths);
		free(depths);
		free(again);
		stilb_image_finish(&want);
		stilb_image_finish(&got);
	}
	stilb_render_dump_destroy(dump);
	assert_int_equal(stilb_render_validation_messages(played.render), 0);
	stilb_render_destroy(played.render);
	stage_close(&s);
	remove(PATH);
}

static void take_line(void *user, const char *line)
{
	char *lines = user;
	strncat(strncat(lines, line, 400 - strlen(lines)), "\n", 400 - strlen(lines));
}

static stilb_result add_rows(void *user, stilb_gpu_plan *plan, uint16_t *image)
{
	(void)user;
	static const char *const names[] = {"fill", "add", "fill"};
	uint16_t own = stilb_gpu_plan_buffer(
		plan, &(stilb_gpu_plan_buffer_row){.name = "own", .bytes = WIDTH * HEIGHT * 8, .output = true});
	for (int i = 0; i < 3; i++)
		stilb_gpu_plan_pass(plan, &(stilb_gpu_pass){.name = names[i],
		                                            .kind = STILB_GPU_PASS_COPY,
		                                            .uses = {{.resource = *image, .how = STILB_GPU_USE_COPY_FROM},
		                                                     {.resource = own, .how = STILB_GPU_USE_COPY_TO}},
		                                            .use_count = 2});
	return STILB_OK;
}

/* What a dump leaves out is named, each name once: 2D passes that draw, and passes of features. */
static void dumps_name_what_they_leave_out(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0}, 0);
	stilb_render_view view = view_of(0, WIDTH, HEIGHT);
	stilb_render_pass passes[4] = {{.name = "scene"},
	                               {.name = "words", .kind = STILB_RENDER_PASS_2D},
	                               {.name = "empty", .kind = STILB_RENDER_PASS_2D, .order = 1},
	                               {.name = "word", .kind = STILB_RENDER_PASS_2D, .order = 2}};
	static const stilb_render_vertex_2d corners[3] = {
		{{0, 0}, {0, 0}, {255}}, {{9, 0}, {0, 0}, {255}}, {{0, 9}, {0, 0}, {255}}};
	stilb_render_feature feature = {STILB_RENDER_STAGE_LAST, add_rows, &s};
	for (int way = 0; way < 3; way++) {
		if (way == 2)
			assert_int_equal(stilb_render_add_feature(s.render, &feature), STILB_OK);
		assert_int_equal(stilb_render_frame_begin(s.render), STILB_OK);
		record(&s, 0);
		for (uint32_t p = 1; p < 4; p++) {
			assert_int_equal(stilb_render_pass_begin(s.render, p, 1), STILB_OK);
			stilb_render_context *context = stilb_render_context_get(s.render, 0);
			stilb_render_segment_begin(context, p, 0);
			uint32_t first = stilb_render_geometry_2d(context, corners, 3, (uint32_t[]){0, 1, 2}, 3);
			if (way > 0 && p != 2)
				stilb_render_draw_2d(context, first, 3, (float[]){0, 0, 9, 9}, (stilb_render_texture){0});
			stilb_render_segment_end(context);
			assert_int_equal(stilb_render_pass_end(s.render, p), STILB_OK);
		}
		stilb_result result = stilb_render_replay(s.render, passes, 4, &view, 1, s.pool, 0);
		if (result != STILB_OK)
			fail_msg("%s", stilb_error_message());
		char lines[401] = "";
		stilb_log_set(take_line, lines);
		assert_int_equal(stilb_render_dump_save(s.render, passes, 4, &view, 1, PATH), STILB_OK);
		stilb_log_set(NULL, NULL);
		static const char flat[] = "'targets.dump': without the frame's 2D passes: words, word\n";
		static const char own[] = "'targets.dump': without the program's own passes: fill, add\n";
		char wanted[200];
		snprintf(wanted, sizeof wanted, "%s%s", way > 0 ? flat : "", way > 1 ? own : "");
		assert_string_equal(lines, wanted);
	}
	stage_close(&s);
	remove(PATH);
}

/* ---- frames that end with one of their passes -------------------------------------------------------------------- */

#define MOST_ROWS 24u

/* The image that a row of the last plan draws into, and its rectangle of it. */
static uint16_t row_draws(const stilb_gpu_plan *plan, uint32_t row, uint16_t area[4])
{
	const stilb_gpu_pass *pass = stilb_gpu_plan_row(plan, row);
	memcpy(area, pass->area, 4 * sizeof *area);
	return pass->color_count > 0 ? pass->color[0].image : pass->depth.image;
}

static void until(stage *s, const char *pass, const char *image)
{
	stilb_render_until(s->render, pass);
	stilb_render_show_image(s->render, image ? &(stilb_render_shown){.name = image} : NULL);
}

/* The picture of a frame without models, which shows an image. */
static stilb_image picture_empty(stage *s, const stilb_render_view *views, uint32_t count, const char *image)
{
	stilb_render_pass passes[STILB_RENDER_MAX_PASSES] = {0};
	until(s, NULL, image);
	assert_int_equal(stilb_render_frame_begin(s->render), STILB_OK);
	for (uint32_t p = 0; p < count; p++) {
		assert_int_equal(stilb_render_pass_begin(s->render, p, 0), STILB_OK);
		assert_int_equal(stilb_render_pass_end(s->render, p), STILB_OK);
		passes[p] = (stilb_render_pass){.name = "scene", .view = p, .order = p};
	}
	assert_int_equal(stilb_render_replay(s->render, passes, count, views, count, s->pool, 0), STILB_OK);
	return picture(s);
}

static bool is_inside(uint32_t x, uint32_t y, const uint16_t area[4])
{
	return x >= area[0] && y >= area[1] && x < (uint32_t)area[0] + area[2] && y < (uint32_t)area[1] + area[3];
}

/* The picture of a frame that ends with a tone map is the whole one but for the places of later ones. */
static void check_tones(const stilb_image *got, const stilb_image *whole, const uint16_t later[][4], uint32_t count)
{
	uint32_t differ = 0;
	for (uint32_t y = 0; y < HEIGHT; y++)
		for (uint32_t x = 0; x < WIDTH; x++) {
			bool open = false;
			for (uint32_t i = 0; i < count; i++)
				open |= is_inside(x, y, later[i]);
			size_t at = 3 * ((size_t)y * WIDTH + x);
			bool same = memcmp((uint8_t *)got->pixels + at, (uint8_t *)whole->pixels + at, 3) == 0;
			assert_true(open || same);
			differ += !same;
		}
	assert_true((differ > 0) == (count > 0));
}

/* Each pass of a frame with two insets and a shadow in turn: the picture shows what is in its image then. That is what
 * the whole frame leaves there if no later pass draws into it, and the backdrop, as a frame without models has it, if
 * the next one draws models over it. */
static void frames_end_with_each_pass(void **state)
{
	(void)state;
	static const stilb_render_target first = {.name = "left", .width = 31, .height = 23, .place = {3, 5, 31, 23}};
	static const stilb_render_target second = {.name = "right", .width = 40, .height = 20, .place = {59, 47, 40, 20}};
	static const stilb_render_target shadow = {
		.name = "shadow", .kind = STILB_RENDER_TARGET_DEPTH, .width = 64, .height = 48, .output = true};
	for (uint32_t samples = 1; samples <= 4; samples += 3) {
		stage s = stage_open((stilb_render_desc){.samples = samples}, 0);
		stilb_render_view views[4] = {view_of(2, 64, 48), view_of(0, WIDTH, HEIGHT), view_of(1, 31, 23),
		                              view_of(2, 40, 20)};
		views[0].target = &shadow;
		views[2].target = &first;
		views[3].target = &second;
		draw_well(&s, views, 4);
		const stilb_gpu_plan *plan = stilb_render_plan(s.render);
		uint32_t rows = stilb_gpu_plan_passes(plan), kinds[3] = {0};
		uint16_t images[MOST_ROWS], areas[MOST_ROWS][4], shown = stilb_gpu_plan_find(plan, "picture");
		assert_int_equal(rows, samples > 1 ? 12 : 9);
		for (uint32_t row = 0; row < rows; row++)
			images[row] = row_draws(plan, row, areas[row]);
		stilb_image whole = picture(&s);
		for (uint32_t row = 0; row < rows; row++) {
			char number[16], name[64];
			snprintf(number, sizeof number, "%u", row + 1);
			snprintf(name, sizeof name, "%s", stilb_gpu_plan_name(plan, images[row]));
			until(&s, number, NULL);
			draw_well(&s, views, 4);
			stilb_image got = picture(&s), want;
			uint32_t later = row + 1;
			while (later < rows && images[later] != images[row])
				later++;
			if (images[row] == shown) {
				check_tones(&got, &whole, (const uint16_t(*)[4])(areas + row + 1), rows - row - 1);
				kinds[0]++;
			} else {
				if (later == rows) {
					until(&s, NULL, name);
					draw_well(&s, views, 4);
					want = picture(&s);
				} else {
					want = picture_empty(&s, views, 4, name);
				}
				assert_memory_equal(got.pixels, want.pixels, stilb_image_size(&want));
				kinds[later == rows ? 1 : 2]++;
				stilb_image_finish(&want);
			}
			stilb_image_finish(&got);
		}
		assert_true(kinds[0] == 3 && kinds[1] == (samples > 1 ? 7 : 4) && kinds[2] == 2);
		until(&s, NULL, NULL);
		draw_well(&s, views, 4);
		stilb_image again = picture(&s);
		assert_memory_equal(again.pixels, whole.pixels, stilb_image_size(&whole));
		stilb_image_finish(&again);
		stilb_image_finish(&whole);
		stage_close(&s);
	}
}

/* Radiance is that of "color" where the frame ends, once there is any. */
static void radiance_of_a_frame_that_ends(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){.samples = 4}, 0);
	stilb_render_view view = view_of(0, WIDTH, HEIGHT);
	stilb_image whole, got;
	draw_well(&s, &view, 1);
	assert_int_equal(stilb_render_read_radiance(s.render, &whole), STILB_OK);
	until(&s, "scene", NULL);
	draw_well(&s, &view, 1);
	assert_int_equal(stilb_render_read_radiance(s.render, &got), STILB_ERROR_DEVICE);
	assert_non_null(strstr(stilb_error_message(), "'color' has no light yet where frames end, after pass 'scene'"));
	until(&s, "resolve", "depth");
	draw_well(&s, &view, 1);
	assert_int_equal(stilb_render_read_radiance(s.render, &got), STILB_OK);
	assert_memory_equal(got.pixels, whole.pixels, stilb_image_size(&whole));
	stilb_image_finish(&whole);
	stilb_image_finish(&got);
	stage_close(&s);
}

static void assert_steps(stage *s, const stilb_render_view *views, uint32_t count, const char *wanted)
{
	draw_well(s, views, count);
	const stilb_gpu_plan *plan = stilb_render_plan(s->render);
	const stilb_gpu_step *steps;
	uint32_t ran = stilb_gpu_plan_steps(plan, &steps);
	char found[200] = "";
	for (uint32_t i = 0; i < ran; i++)
		strcat(strcat(found, i > 0 ? "," : ""), stilb_gpu_plan_row(plan, steps[i].pass)->name);
	assert_string_equal(found, wanted);
}

static void assert_refused(stage *s, const stilb_render_view *views, uint32_t count, const char *wanted)
{
	assert_int_equal(draw(s, views, count), STILB_ERROR_ARGUMENT);
	if (!strstr(stilb_error_message(), wanted))
		fail_msg("'%s' is not in: %s", wanted, stilb_error_message());
}

/* Names and numbers; of passes with one name the last. What is wrong is said, and the next frame is whole again. */
static void frames_end_by_name(void **state)
{
	(void)state;
	static const stilb_render_target inset = {.name = "left", .width = 31, .height = 23, .place = {3, 5, 31, 23}};
	stage s = stage_open((stilb_render_desc){.samples = 4}, 0);
	stilb_render_view views[2] = {view_of(0, WIDTH, HEIGHT), view_of(1, 31, 23)};
	views[1].target = &inset;
	assert_steps(&s, views, 2, "backdrop,scene,backdrop,scene,resolve,resolve,tone map,tone map");
	uint64_t hash = stilb_render_stream_hash(s.render);
	until(&s, "backdrop", NULL);
	assert_steps(&s, views, 2, "backdrop,scene,backdrop,show");
	assert_true(stilb_render_stream_hash(s.render) == hash); /* of what is recorded, whatever is drawn of it */
	until(&s, "scene", "depth");
	assert_steps(&s, views, 2, "backdrop,scene,backdrop,scene,show");
	until(&s, "2", "depth");
	assert_steps(&s, views, 2, "backdrop,scene,show");
	until(&s, "tone map", NULL);
	assert_steps(&s, views, 2, "backdrop,scene,backdrop,scene,resolve,resolve,tone map,tone map");
	until(&s, "tone map", "picture");
	assert_steps(&s, views, 2, "backdrop,scene,backdrop,scene,resolve,resolve,tone map,tone map");
	until(&s, "7", "left");
	assert_steps(&s, views, 2, "backdrop,scene,backdrop,scene,resolve,resolve,tone map,show");
	static const char *const wrong[] = {"tone", "0", "9", "1x", "-1", "Scene", "99999999999999999999"};
	for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
		char text[200];
		until(&s, wrong[i], NULL);
		snprintf(
			text, sizeof text,
			"there is no pass '%s' for the frame to end with; this frame has 1 backdrop, 2 scene, 3 backdrop, 4 scene, "
			"5 resolve, 6 resolve, 7 tone map, 8 tone map",
			wrong[i]);
		assert_refused(&s, views, 2, text);
	}
	until(&s, "1", "depth");
	assert_refused(&s, views, 2, "image 'depth' has no content yet after pass 1 'backdrop'");
	until(&s, "resolve", "picture");
	assert_refused(&s, views, 2, "image 'picture' has no content yet after pass 6 'resolve'");
	until(&s, "scene", "nothing");
	assert_refused(&s, views, 2, "there is no image 'nothing' to show");
	until(&s, "scene", NULL);
	stilb_render_show_image(s.render, &(stilb_render_shown){.name = "color samples", .mip = 1});
	assert_refused(&s, views, 2, "has 1 mips and 1 layers; there is no mip 1, layer 0");
	stilb_render_feature feature = {STILB_RENDER_STAGE_LIGHT, add_rows, &s};
	assert_int_equal(stilb_render_add_feature(s.render, &feature), STILB_OK);
	until(&s, "add", NULL);
	assert_refused(&s, views, 2, "'add', which the frame ends with, draws into no image; show one by its name");
	stilb_render_remove_feature(s.render, &s);
	until(&s, "", NULL);
	assert_steps(&s, views, 2, "backdrop,scene,backdrop,scene,resolve,resolve,tone map,tone map");
	stage_close(&s);
}

/* Clears a mip and layer of an image, and copies it to those of another. */
static stilb_result add_parts(void *user, stilb_gpu_plan *plan, uint16_t *image)
{
	stage *s = user;
	stilb_gpu_plan_image_row row = {
		.name = "from", .format = STILB_GPU_RGBA16_F, .width = 8, .height = 8, .layers = 3, .mips = 2};
	uint16_t from = stilb_gpu_plan_image(plan, &row);
	row.name = "to";
	uint16_t to = stilb_gpu_plan_image(plan, &row);
	stilb_gpu_pass pass = {
		.name = "clear",
		.kind = STILB_GPU_PASS_DRAWS,
		.color = {{.image = from, .mip = 1, .layer = 2, .load = STILB_GPU_LOAD_CLEAR, .clear = {0, 1, 0, 1}}},
		.color_count = 1};
	(void)image;
	stilb_result result = stilb_render_add_draws(s->render, &(stilb_gpu_draws){0}, &pass.draws);
	stilb_gpu_plan_pass(plan, &pass);
	stilb_gpu_plan_pass(
		plan, &(stilb_gpu_pass){.name = "copy",
	                            .kind = STILB_GPU_PASS_COPY,
	                            .uses = {{from, STILB_GPU_USE_COPY_FROM, .mip = 1, .mips = 1, .layer = 2, .layers = 1},
	                                     {to, STILB_GPU_USE_COPY_TO, .mip = 1, .mips = 1, .layer = 1, .layers = 1}},
	                            .use_count = 2});
	return result;
}

/* Passes of features that fill one mip and layer of an image: these are shown, and no others have content. */
static void frames_end_with_a_part_of_an_image(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0}, 0);
	stilb_render_view view = view_of(0, WIDTH, HEIGHT);
	stilb_render_feature feature = {STILB_RENDER_STAGE_LIGHT, add_parts, &s};
	assert_int_equal(stilb_render_add_feature(s.render, &feature), STILB_OK);
	static const uint16_t layers[2] = {2, 1};
	for (uint32_t i = 0; i < 2; i++) {
		until(&s, i ? "copy" : "clear", NULL);
		draw_well(&s, &view, 1);
		const stilb_gpu_plan *plan = stilb_render_plan(s.render);
		const stilb_gpu_pass *row = stilb_gpu_plan_row(plan, stilb_gpu_plan_passes(plan) - 1);
		assert_string_equal(row->name, "show");
		assert_string_equal(stilb_gpu_plan_name(plan, row->uses[0].resource), i ? "to" : "from");
		assert_int_equal(row->uses[0].mip, 1);
		assert_int_equal(row->uses[0].layer, layers[i]);
		if (!null_device) {
			stilb_image image = picture(&s);
			for (size_t p = 0; p < stilb_image_size(&image); p++)
				assert_int_equal(((uint8_t *)image.pixels)[p], p % 3 == 1 ? 255 : 0);
			stilb_image_finish(&image);
		}
		for (uint32_t part = 0; part < 6; part++) {
			stilb_render_show_image(s.render,
			                        &(stilb_render_shown){i ? "to" : "from", part % 2, part / 2, 0, 0, false});
			bool there = part % 2 == 1 && part / 2 == layers[i];
			assert_int_equal(draw(&s, &view, 1), there ? STILB_OK : STILB_ERROR_ARGUMENT);
			assert_true(there || strstr(stilb_error_message(), "has no content yet after pass"));
		}
	}
	stage_close(&s);
}

static stilb_result fail_first(void *user, stilb_gpu_plan *plan, uint16_t *image)
{
	(void)user, (void)plan, (void)image;
	return stilb_fail(STILB_ERROR_DEVICE, "not this time");
}

/* After a frame that failed before it had any images there is nothing to read, and that is said. */
static void nothing_is_read_of_a_failed_frame(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0}, 0);
	stilb_render_view view = view_of(0, WIDTH, HEIGHT);
	stilb_render_feature feature = {STILB_RENDER_STAGE_FIRST, fail_first, &s};
	stilb_image image;
	draw_well(&s, &view, 1);
	assert_int_equal(stilb_render_add_feature(s.render, &feature), STILB_OK);
	assert_int_equal(draw(&s, &view, 1), STILB_ERROR_DEVICE);
	assert_int_equal(stilb_render_read_image(s.render, &image), STILB_ERROR_DEVICE);
	assert_int_equal(stilb_render_read_radiance(s.render, &image), STILB_ERROR_DEVICE);
	stilb_render_remove_feature(s.render, &s);
	draw_well(&s, &view, 1);
	stage_close(&s);
}

/* Many views of one scene, recorded together by several threads, are the views recorded one by one. */
static void views_recorded_together(void **state)
{
	(void)state;
	enum { VIEWS = 6, MODELS = 700 };
	stilb_scene *scene;
	assert_int_equal(scene_create(MODELS, MODELS, 2, 1, &scene), STILB_OK);
	assert_int_equal(stilb_scene_mesh_sphere(2, &scene->meshes[0]), STILB_OK);
	assert_int_equal(stilb_scene_mesh_plane(&scene->meshes[1]), STILB_OK);
	uint32_t ids[MODELS], together = 0;
	stilb_render_target targets[VIEWS];
	stilb_render_view views[VIEWS];
	stilb_render_pass passes[VIEWS];
	char names[VIEWS][8];
	for (uint32_t m = 0; m < MODELS; m++) {
		ids[m] = scene->first_part[m] = m;
		scene->first_part[m + 1] = m + 1;
		scene->bounds.radius[m] = 0.1f;
		scene->part_mesh[m] = m % 2;
		scene->part_transform[m] =
			stilb_mat4_scale_translate(0.1f, (float)(m % 26) - 13.0f, 0.0f, (float)(m / 26) - 13.0f);
	}
	for (uint32_t v = 0; v < VIEWS; v++) {
		snprintf(names[v], sizeof names[v], "v%u", v);
		targets[v] = (stilb_render_target){.name = names[v], .width = 16, .height = 16, .output = true};
		views[v] = view_of(v % 3, 16, 16);
		views[v].target = &targets[v];
		views[v].detail = (stilb_render_detail){v % 2 ? STILB_RENDER_DETAIL_POP : STILB_RENDER_DETAIL_OFF, 1.0f};
		passes[v] = (stilb_render_pass){.name = names[v], .view = v, .order = v};
	}
	uint64_t hashes[3];
	for (uint32_t way = 0; way < 3; way++) {
		stage s = stage_open((stilb_render_desc){0}, way == 2 ? 3 : 0);
		assert_int_equal(stilb_render_set_scene(s.render, scene), STILB_OK);
		assert_int_equal(stilb_render_frame_begin(s.render), STILB_OK);
		stilb_render_recording recordings[VIEWS];
		for (uint32_t v = 0; v < VIEWS; v++) {
			recordings[v] = (stilb_render_recording){v, v == 3 ? 0 : MODELS - 100 * v, ids, &views[v]};
			if (way == 0)
				assert_int_equal(stilb_render_record_view(s.render, v, scene, ids, recordings[v].visible_count,
				                                          &views[v], s.pool, 0),
				                 STILB_OK);
		}
		if (way > 0)
			assert_int_equal(stilb_render_record_views(s.render, scene, recordings, VIEWS, s.pool, 0), STILB_OK);
		if (stilb_render_replay(s.render, passes, VIEWS, views, VIEWS, s.pool, 0) != STILB_OK)
			fail_msg("%s", stilb_error_message());
		hashes[way] = stilb_render_stream_hash(s.render);
		together += (uint32_t)stilb_render_stats_get(s.render).draws;
		stage_close(&s);
	}
	assert_int_equal(together, 3 * (5 * MODELS - 100 * (1 + 2 + 4 + 5)));
	assert_true(hashes[0] == hashes[1] && hashes[0] == hashes[2]);
	stilb_scene_destroy(scene);
}

static int tear_down(void **state)
{
	(void)state;
	return folder_remove();
}

int main(int argc, char **argv)
{
	static const struct CMUnitTest any[] = {
		cmocka_unit_test(depth_without_a_picture), cmocka_unit_test(targets_that_nobody_reads),
		cmocka_unit_test(mistakes_are_errors),     cmocka_unit_test(nothing_is_read_of_a_failed_frame),
		cmocka_unit_test(dumps_hold_targets),      cmocka_unit_test(dumps_name_what_they_leave_out),
		cmocka_unit_test(frames_end_by_name),      cmocka_unit_test(frames_end_with_a_part_of_an_image),
		cmocka_unit_test(views_recorded_together)};
	static const struct CMUnitTest pictures[] = {
		cmocka_unit_test(insets_are_pictures_of_their_own), cmocka_unit_test(tiles_without_a_main_picture),
		cmocka_unit_test(main_images_of_another_size),      cmocka_unit_test(depth_alone_is_the_depth),
		cmocka_unit_test(frames_end_with_each_pass),        cmocka_unit_test(radiance_of_a_frame_that_ends)};
	null_device = argc > 1 && strcmp(argv[1], "null") == 0;
	int failed = cmocka_run_group_tests(any, folder_make, tear_down);
	return null_device ? failed : failed + cmocka_run_group_tests(pictures, folder_make, tear_down);
}
