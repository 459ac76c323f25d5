/* Textures that are made while frames are drawn: stand-ins of the mean color at first, at the end the picture of those
 * that were waited for, bit for bit; the same frames every time; edited, removed and destroyed on their way. */
#include "render/maps/maps_stage.h"
#include "scene/edit/scene_edit.h"

#define TEXTURES 9u

/* Pictures of several formats and sizes; number 1 is two frames' work. */
static stilb_image texture_make(uint32_t t, uint64_t seed)
{
	static const stilb_image_format formats[4] = {STILB_IMAGE_U8_SRGB, STILB_IMAGE_U16_SRGB, STILB_IMAGE_F16_LINEAR,
	                                              STILB_IMAGE_BC3_SRGB};
	stilb_image image;
	stilb_image_format format = formats[t % 4];
	uint32_t side = t == 1 ? 2048 : 50 + 30 * t, channels = stilb_image_format_channels(format);
	channels = channels > 0 ? channels : 1 + t % 4;
	assert_int_equal(stilb_image_create_levels(&image, side, side + t, channels, format, t % 4 == 3 ? 3 : 1), STILB_OK);
	uint8_t *bytes = image.pixels;
	uint64_t size = stilb_image_levels_size(&image), part = 70000; /* repeated: large pictures are soon made */
	for (uint64_t i = 0; i < size; i++)
		bytes[i] = i < part ? (uint8_t)(stilb_random_u64(seed + t, i / 7) &
		                                (format == STILB_IMAGE_F16_LINEAR && i % 2 ? 0x3a : 0xff))
		                    : bytes[i - part];
	return image;
}

/* Nine squares, each with a texture of its own; the last one without a surface. */
static void show_textures(stage *s)
{
	static const float white[3] = {1, 1, 1}, none[3] = {0};
	stilb_scene_build *build = stilb_scene_build_begin();
	square q;
	square_make(&q, 1.0f);
	uint32_t mesh = stilb_scene_build_mesh(build, &q.mesh);
	for (uint32_t t = 0; t < TEXTURES; t++) {
		stilb_image image = texture_make(t, 1);
		stilb_scene_surface surface = surface_unlit();
		surface.maps[STILB_SCENE_MAP_COLOR].texture = 1 + stilb_scene_build_texture(build, &image);
		stilb_scene_material material = stilb_scene_material_make(white, none, 0.5f);
		material.diffuse_texture = surface.maps[STILB_SCENE_MAP_COLOR].texture;
		uint32_t made =
			t + 1 < TEXTURES ? stage_material(build, &surface) : stilb_scene_build_material(build, &material);
		float x = (float)(t % 3) * (2.0f / 3) - 2.0f / 3, z = (float)(t / 3) * (2.0f / 3) - 2.0f / 3;
		stage_model(build, mesh, made, stilb_mat4_scale_translate(0.33f, x, 0.0f, z));
		stilb_image_finish(&image);
	}
	stage_show(s, build);
}

/* A frame with its update; what is left. */
static uint32_t frame(stage *s, stilb_image *picture)
{
	stilb_scene_changes changes = stilb_scene_changes_read(s->scene);
	if (stilb_render_update_scene(s->render, s->scene, &changes) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stilb_scene_changes_clear(s->scene);
	stilb_lock_take(&s->render->resources.lock);
	for (uint32_t t = 0; t < s->render->scene.texture_count;
	     t++) { /* what is shown is there, or comes with this frame */
		const render_texture_upload *upload =
			render_upload_of(&s->render->resources, s->render->scene.textures[t].texture.id & RENDER_INDEX_MASK);
		assert_false(upload && upload->patient);
	}
	stilb_lock_give(&s->render->resources.lock);
	if (picture)
		*picture = stage_picture(s);
	else
		stage_frame(s);
	return stilb_render_textures_left(s->render);
}

static stage open_as(stilb_render_textures textures, uint32_t workers)
{
	stage s = stage_open((stilb_render_desc){.width = 60, .keep_textures = true}, workers);
	stilb_render_set_pool(s.render, s.pool);
	stilb_render_set_textures(s.render, textures);
	return s;
}

static void close_it(stage *s)
{
	stilb_render_set_pool(s->render, NULL);
	stage_close(s);
}

/* Draws until all is there, 100 frames at most; the frames' number. */
static uint32_t frames_until_there(stage *s)
{
	uint32_t frames = 1;
	while (frame(s, NULL) > 0)
		assert_true(++frames < 100);
	return frames;
}

static void assert_same(const stilb_image *got, const stilb_image *want)
{
	assert_int_equal(stilb_image_size(got), stilb_image_size(want));
	assert_memory_equal(got->pixels, want->pixels, stilb_image_size(want));
}

/* The mean of all pixels of a picture's smallest level, within what some rows can tell. */
static void assert_is_mean(const stilb_image *frame_picture, uint32_t t)
{
	stilb_image all = texture_make(t, 1), image = stilb_image_level(&all, stilb_image_level_count(&all) - 1);
	float *light = malloc((size_t)4 * image.width * sizeof *light);
	double sum[4] = {0};
	for (uint32_t y = 0; y < image.height; y++) {
		stilb_image_row_to_light(&image, y, light);
		for (uint32_t x = 0; x < image.width; x++)
			for (uint32_t c = 0; c < image.channels; c++)
				sum[c] += (double)light[x * image.channels + c] / image.width / image.height;
	}
	for (int c = 0; c < 3; c++)
		assert_near("a mean", picture_value(frame_picture, 10 + 20 * (t % 3), 10 + 20 * (t / 3), c),
		            image.channels < 3 ? sum[0] : sum[c], 0.03);
	free(light);
	stilb_image_finish(&all);
}

static void the_end_is_that_of_waiting(void **state)
{
	(void)state;
	stage waits = open_as(STILB_RENDER_TEXTURES_AT_ONCE, 1);
	show_textures(&waits);
	assert_int_equal(stilb_render_textures_left(waits.render), 0);
	stilb_image want, first;
	frame(&waits, &want);
	for (int spare = 0; spare < 2; spare++) {
		stage s = open_as(spare ? STILB_RENDER_TEXTURES_SPARE : STILB_RENDER_TEXTURES_EVEN, 1);
		show_textures(&s);
		assert_int_equal(stilb_render_textures_left(s.render), TEXTURES);
		first = stage_picture(&s);
		for (uint32_t t = 0; t < TEXTURES; t++)
			assert_is_mean(&first, t);
		assert_true(frames_until_there(&s) > 1);
		stilb_image got;
		frame(&s, &got);
		assert_same(&got, &want);
		assert_true(memcmp(first.pixels, got.pixels, stilb_image_size(&got)) != 0);
		assert_int_equal(s.render->resources.upload_count, 0);
		stilb_image_finish(&got);
		stilb_image_finish(&first);
		close_it(&s);
	}
	stilb_image_finish(&want);
	close_it(&waits);
}

/* EVEN: frame n shows the same for any number of workers. */
static void frames_are_the_same_every_time(void **state)
{
	(void)state;
	stilb_image all[100];
	uint32_t frames = 0;
	for (uint32_t workers = 0; workers < 4; workers += 3) {
		stage s = open_as(STILB_RENDER_TEXTURES_EVEN, workers);
		show_textures(&s);
		for (uint32_t f = 0, left = 1; left > 0; f++) {
			stilb_image got;
			assert_true(f < 100);
			left = frame(&s, &got);
			if (workers == 0) {
				all[frames++] = got;
				continue;
			}
			assert_true(f < frames && (left == 0) == (f + 1 == frames));
			assert_same(&got, &all[f]);
			stilb_image_finish(&got);
		}
		close_it(&s);
	}
	assert_true(frames > 2);
	uint32_t kinds = 1;
	for (uint32_t f = 1; f < frames; f++)
		kinds += memcmp(all[f].pixels, all[f - 1].pixels, stilb_image_size(&all[f])) != 0;
	assert_true(kinds > 2); /* textures do not come all at once */
	for (uint32_t f = 0; f < frames; f++)
		stilb_image_finish(&all[f]);
}

/* With AT_ONCE the next update makes all that is left. */
static void a_hurry_makes_the_rest(void **state)
{
	(void)state;
	stilb_image pictures[2];
	for (int hurry = 0; hurry < 2; hurry++) {
		stage s = open_as(hurry ? STILB_RENDER_TEXTURES_EVEN : STILB_RENDER_TEXTURES_AT_ONCE, 1);
		show_textures(&s);
		if (hurry) {
			assert_true(frame(&s, NULL) > 0);
			stilb_render_set_textures(s.render, STILB_RENDER_TEXTURES_AT_ONCE);
		}
		assert_int_equal(frame(&s, &pictures[hurry]), 0);
		close_it(&s);
	}
	assert_same(&pictures[1], &pictures[0]);
	stilb_image_finish(&pictures[0]);
	stilb_image_finish(&pictures[1]);
}

static void edit(stage *s, uint32_t t, uint64_t seed)
{
	stilb_image image = texture_make(t, seed);
	assert_int_equal(stilb_scene_set_texture(s->scene, t, &image), STILB_OK);
	stilb_image_finish(&image);
}

static void make_plain(stage *s, uint32_t material)
{
	stilb_scene_surface surface = surface_unlit();
	uint32_t id;
	assert_int_equal(stilb_scene_add_surface(s->scene, &surface, &id), STILB_OK);
	stilb_scene_material plain = s->scene->materials[material];
	uint32_t before = plain.surface - 1;
	plain.surface = 1 + id;
	plain.diffuse_texture = 0;
	assert_int_equal(stilb_scene_set_material(s->scene, material, &plain), STILB_OK);
	assert_int_equal(stilb_scene_remove_surface(s->scene, before), STILB_OK);
}

/* Edits at each frame of the way, of a texture that waits, is being made, is copied, or is there: its last picture is
 * shown at the end. A texture without a surface gets one, others lose theirs and are removed; one is added. */
static void edits_on_the_way(void **state)
{
	(void)state;
	for (uint32_t when = 0; when < 5; when += 1 + TEST_ASAN) {
		stilb_image pictures[2];
		for (int later = 0; later < 2; later++) {
			stage s = open_as(later ? STILB_RENDER_TEXTURES_EVEN : STILB_RENDER_TEXTURES_AT_ONCE, 2);
			show_textures(&s);
			for (uint32_t f = 0; f < when; f++)
				frame(&s, NULL);
			edit(&s, 1, 77);
			edit(&s, 0, 78);
			edit(&s, 7, 79);
			frame(&s, NULL);
			assert_true(!later || when > 0 || s.render->scene.textures[1].loading != RENDER_LOADING_DONE);
			edit(&s, 1, 80);
			make_plain(&s, 2);
			assert_int_equal(stilb_scene_remove_texture(s.scene, 2), STILB_OK);
			stilb_scene_material material = s.scene->materials[TEXTURES - 1];
			stilb_scene_surface surface = surface_unlit();
			surface.maps[STILB_SCENE_MAP_COLOR].texture = TEXTURES;
			uint32_t id;
			assert_int_equal(stilb_scene_add_surface(s.scene, &surface, &id), STILB_OK);
			material.surface = 1 + id;
			material.diffuse_texture = 0;
			assert_int_equal(stilb_scene_set_material(s.scene, TEXTURES - 1, &material), STILB_OK);
			frames_until_there(&s);
			frame(&s, &pictures[later]);
			for (uint32_t t = 0; t < 6; t++) /* what was given up is released */
				frame(&s, NULL);
			assert_int_equal(s.render->resources.upload_count, 0);
			assert_int_equal(s.render->resources.retired_count, 0);
			close_it(&s);
		}
		assert_same(&pictures[1], &pictures[0]);
		stilb_image_finish(&pictures[0]);
		stilb_image_finish(&pictures[1]);
	}
}

/* Another scene, and the end, at each frame of the way; a picture that was freed before is not read (the address
 * sanitizer sees that). */
static void ends_on_the_way(void **state)
{
	(void)state;
	for (uint32_t when = 0; when < 5; when += 1 + TEST_ASAN) {
		stage s = open_as(STILB_RENDER_TEXTURES_EVEN, 2);
		show_textures(&s);
		for (uint32_t f = 0; f < when; f++)
			frame(&s, NULL);
		show_textures(&s); /* which destroys the scene before */
		assert_int_equal(stilb_render_textures_left(s.render), TEXTURES);
		frame(&s, NULL);
		if (when % 2) {
			assert_int_equal(stilb_render_set_scene(s.render, NULL), STILB_OK);
			assert_int_equal(stilb_render_textures_left(s.render), 0);
			for (int f = 0; f < 4; f++)
				assert_int_equal(stilb_render_frame_begin(s.render), STILB_OK);
			assert_int_equal(s.render->resources.live, 0);
		}
		close_it(&s);
	}
}

/* What the device does not take is told when the scene is set. */
static void what_is_too_large(void **state)
{
	(void)state;
	for (int later = 0; later < 2; later++) {
		stage s = open_as(later ? STILB_RENDER_TEXTURES_EVEN : STILB_RENDER_TEXTURES_AT_ONCE, 0);
		s.render->device->gpu->faults.image_side = 1000;
		stilb_scene_build *build = stilb_scene_build_begin();
		square q;
		square_make(&q, 1.0f);
		stilb_image image = texture_make(1, 1);
		stilb_scene_surface surface = surface_unlit();
		surface.maps[STILB_SCENE_MAP_COLOR].texture = 1 + stilb_scene_build_texture(build, &image);
		stage_model(build, stilb_scene_build_mesh(build, &q.mesh), stage_material(build, &surface),
		            stilb_mat4_identity());
		assert_int_equal(stilb_scene_build_end(build, &s.scene), STILB_OK);
		assert_int_equal(stilb_render_set_scene(s.render, s.scene), STILB_ERROR_ARGUMENT);
		assert_non_null(strstr(stilb_error_message(), "texture 0 of the scene: GPU '"));
		assert_int_equal(stilb_render_textures_left(s.render), 0);
		stilb_image_finish(&image);
		close_it(&s);
	}
}

int main(void)
{
	if (reference_no_driver())
		return 77;
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_end_is_that_of_waiting),
		cmocka_unit_test(frames_are_the_same_every_time),
		cmocka_unit_test(a_hurry_makes_the_rest),
		cmocka_unit_test(edits_on_the_way),
		cmocka_unit_test(ends_on_the_way),
		cmocka_unit_test(what_is_too_large),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
