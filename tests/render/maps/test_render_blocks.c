/* Textures of compressed blocks: they stay blocks where the device reads them, and show what their decoded pixels show,
 * with all mips, few or none, of odd sizes; maps of normals with two channels; dumps hold them. */
#include "render/maps/maps_stage.h"
#include "render/render_dump.h"

#define PATH "test_render_blocks.dump"

static const stilb_image_format formats[] = {STILB_IMAGE_BC1_SRGB,   STILB_IMAGE_BC1_LINEAR, STILB_IMAGE_BC3_SRGB,
                                             STILB_IMAGE_BC3_LINEAR, STILB_IMAGE_BC4_LINEAR, STILB_IMAGE_BC5_LINEAR,
                                             STILB_IMAGE_BC7_SRGB,   STILB_IMAGE_BC7_LINEAR};

#define FORMATS (sizeof formats / sizeof *formats)

static bool is_bc7(stilb_image_format format)
{
	return format == STILB_IMAGE_BC7_SRGB || format == STILB_IMAGE_BC7_LINEAR;
}

/* A picture of random blocks, which mean something in every format. */
static stilb_image blocks_make(stilb_image_format format, uint32_t width, uint32_t height, uint32_t levels)
{
	stilb_image image;
	uint32_t channels = stilb_image_format_channels(format);
	assert_int_equal(stilb_image_create_levels(&image, width, height, channels, format, levels), STILB_OK);
	uint8_t *bytes = image.pixels;
	for (uint64_t i = 0; i < stilb_image_levels_size(&image); i++)
		bytes[i] = (uint8_t)(stilb_random_u64(format + width, i) >> 11);
	for (uint64_t i = 0; is_bc7(format) && i < stilb_image_levels_size(&image); i += 16)
		bytes[i] |= 64; /* it has some mode */
	return image;
}

/* The texels of all levels. */
static stilb_image decoded_of(const stilb_image *blocks)
{
	stilb_image all;
	uint32_t levels = stilb_image_level_count(blocks);
	assert_int_equal(stilb_image_create_levels(&all, blocks->width, blocks->height, blocks->channels,
	                                           stilb_image_decoded_format(blocks->format), levels),
	                 STILB_OK);
	for (uint32_t l = 0; l < levels; l++) {
		stilb_image from = stilb_image_level(blocks, l), to = stilb_image_level(&all, l), texels;
		assert_int_equal(stilb_image_decode(&from, &texels), STILB_OK);
		memcpy(to.pixels, texels.pixels, stilb_image_size(&texels));
		stilb_image_finish(&texels);
	}
	return all;
}

/* The surface whose map is the picture, `times` times along a side of the frame's picture. */
static stilb_image shown(stage *s, const stilb_image *texture, stilb_scene_map_kind kind, float times)
{
	square q;
	square_make(&q, 1.0f);
	stilb_scene_surface surface = kind == STILB_SCENE_MAP_COLOR ? surface_unlit() : surface_matt();
	surface.maps[kind].texture = 1;
	surface.maps[kind].to_u[0] = surface.maps[kind].to_v[1] = times;
	stage_show_square(s, &q, &surface, texture, 1);
	return stage_picture(s);
}

/* The largest difference of two pictures. */
static double difference(const stilb_image *a, const stilb_image *b)
{
	double largest = 0.0;
	for (uint32_t y = 0; y < a->height; y++)
		for (uint32_t x = 0; x < a->width; x++)
			for (int c = 0; c < 3; c++)
				largest = fmax(largest, fabs(picture_value(a, x, y, c) - picture_value(b, x, y, c)));
	return largest;
}

/* What the device has of the scene's only texture. */
static render_array_kind kind_of(const stage *s)
{
	const render_device *device = s->render->device;
	uint32_t index = s->render->scene.textures[0].texture.id & RENDER_INDEX_MASK;
	return device->arrays.items[device->textures[index].array - 1].kind;
}

/* A code of 8 bits, and as much again for what drivers round; of sRGB times its slope, which is 2.3 at most. */
#define OFF(format) ((stilb_image_format_as_data(format) == (format) ? 1.0 : 2.3) * 2.0 / 255)

/* 1 level, down to one block, down to one texel; seen near and from afar. */
static void blocks_show_their_texels(void **state)
{
	(void)state;
	static const uint32_t sides[][2] = {{16, 16}, {13, 6}, {5, 31}, {4, 4}, {1, 1}, {64, 8}};
	stage s = stage_open((stilb_render_desc){0}, 1);
	bool software = stilb_gpu_is_software(s.render->device->gpu);
	for (size_t f = 0; f < FORMATS; f += 1 + TEST_ASAN)
		for (size_t i = 0; i < sizeof sides / sizeof *sides; i++) {
			uint32_t all = render_mip_count(sides[i][0], sides[i][1]);
			for (uint32_t levels = 1; levels <= all; levels++) {
				bool few = sides[i][0] >> (levels - 1) > 4 || sides[i][1] >> (levels - 1) > 4;
				if (levels > 1 && levels + 3 < all)
					continue;
				stilb_image blocks = blocks_make(formats[f], sides[i][0], sides[i][1], levels);
				stilb_image texels = decoded_of(&blocks);
				bool kept = !few && !(software && is_bc7(formats[f]));
				for (float times = 1.0f; times < 10.0f; times *= 3.0f) {
					stilb_image got = shown(&s, &blocks, STILB_SCENE_MAP_COLOR, times);
					render_array_kind kind = kind_of(&s);
					stilb_image_format format = kept ? blocks.format : texels.format;
					assert_int_equal(kind.format, render_texture_format(format));
					assert_int_equal(kind.mips, kept ? levels : all);
					stilb_image want = shown(&s, &texels, STILB_SCENE_MAP_COLOR, times);
					/* Mips that are missing are those of a block or less: seen from so near that they do not matter. */
					double off = kept ? OFF(formats[f]) : 0.0;
					if (levels == all || !kept || times < 2.0f)
						assert_near("blocks", difference(&got, &want), 0.0, off);
					stilb_image_finish(&got);
					stilb_image_finish(&want);
				}
				stilb_image_finish(&blocks);
				stilb_image_finish(&texels);
			}
		}
	stage_close(&s);
}

/* Where the device has no blocks, they are decoded: then the bits are those of the texels. */
static void devices_without_blocks_decode(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0}, 2);
	for (uint32_t f = STILB_GPU_BC1_U; f <= STILB_GPU_BC7_SRGB; f++)
		s.render->device->gpu->formats[f] = 0;
	for (size_t f = 0; f < FORMATS; f++) {
		stilb_image blocks = blocks_make(formats[f], 300, 77, 4), texels = decoded_of(&blocks);
		stilb_image got = shown(&s, &blocks, STILB_SCENE_MAP_COLOR, 1.0f);
		assert_int_equal(kind_of(&s).format, render_texture_format(texels.format));
		assert_int_equal(kind_of(&s).mips, 9);
		stilb_image want = shown(&s, &texels, STILB_SCENE_MAP_COLOR, 1.0f);
		assert_memory_equal(got.pixels, want.pixels, stilb_image_size(&got));
		stilb_image_finish(&got);
		stilb_image_finish(&want);
		stilb_image_finish(&blocks);
		stilb_image_finish(&texels);
	}
	stage_close(&s);
}

static const stilb_scene_light slanted = {
	.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {-0.48f, -0.8f, 0.36f}, .intensity = {3, 3, 3}};

/* BC5 holds x and y of normals. */
static void normals_of_two_channels(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0}, 0);
	reference_set3(s.view.surroundings.sky, 0.0f, 0.0f, 0.0f);
	s.view.lights = &slanted;
	s.view.light_count = 1;
	stilb_image blocks = blocks_make(STILB_IMAGE_BC5_LINEAR, 8, 8, 2);
	for (uint32_t b = 0; b < 5; b++) { /* all near to x = .2, y = -.3: no slope is steep */
		uint8_t *block = (uint8_t *)blocks.pixels + 16 * b;
		block[0] = (uint8_t)(150 + b), block[1] = (uint8_t)(158 - b), block[8] = (uint8_t)(90 - b), block[9] = 86;
	}
	stilb_image texels = decoded_of(&blocks), flat = {0};
	stilb_image got = shown(&s, &blocks, STILB_SCENE_MAP_NORMAL, 1.0f);
	assert_int_equal(kind_of(&s).format, STILB_GPU_BC5_U);
	stilb_image want = shown(&s, &texels, STILB_SCENE_MAP_NORMAL, 1.0f);
	square q;
	square_make(&q, 1.0f);
	stilb_scene_surface surface = surface_matt();
	stage_show_square(&s, &q, &surface, NULL, 0);
	flat = stage_picture(&s);
	assert_near("normals", difference(&got, &want), 0.0, 0.02); /* a code's slope, times 3 / pi */
	assert_true(difference(&got, &flat) > 0.1);
	stilb_image_finish(&got);
	stilb_image_finish(&want);
	stilb_image_finish(&flat);
	stilb_image_finish(&blocks);
	stilb_image_finish(&texels);
	stage_close(&s);
}

/* The material of a scene without surfaces may show blocks, too, and their levels do not matter. */
static void without_a_surface(void **state)
{
	(void)state;
	static const float white[3] = {1, 1, 1}, none[3] = {0};
	stage s = stage_open((stilb_render_desc){0}, 0);
	stilb_image pictures[2], blocks = blocks_make(STILB_IMAGE_BC3_SRGB, 9, 7, 2), texels = decoded_of(&blocks);
	for (int i = 0; i < 2; i++) {
		stilb_scene_build *build = stilb_scene_build_begin();
		square q;
		square_make(&q, 1.0f);
		stilb_scene_material material = stilb_scene_material_make(white, none, 0.5f);
		material.diffuse_texture = 1 + stilb_scene_build_texture(build, i ? &texels : &blocks);
		uint32_t mesh = stilb_scene_build_mesh(build, &q.mesh);
		stage_model(build, mesh, stilb_scene_build_material(build, &material), stilb_mat4_identity());
		stage_show(&s, build);
		pictures[i] = stage_picture(&s);
	}
	assert_near("blocks", difference(&pictures[0], &pictures[1]), 0.0, OFF(STILB_IMAGE_BC3_SRGB));
	for (int i = 0; i < 2; i++)
		stilb_image_finish(&pictures[i]);
	stilb_image_finish(&blocks);
	stilb_image_finish(&texels);
	stage_close(&s);
}

/* Edits write blocks into blocks of the same shape, and make others anew. */
static void edits(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){0}, 0);
	stilb_image first = blocks_make(STILB_IMAGE_BC1_LINEAR, 24, 20, 3);
	stilb_image before = shown(&s, &first, STILB_SCENE_MAP_COLOR, 1.0f);
	for (int step = 0; step < 3; step++) {
		stilb_image next = step == 0   ? blocks_make(STILB_IMAGE_BC1_LINEAR, 24, 20, 3)
		                   : step == 1 ? blocks_make(STILB_IMAGE_BC1_LINEAR, 24, 20, 5)
		                               : blocks_make(STILB_IMAGE_BC3_LINEAR, 12, 20, 5);
		((uint8_t *)next.pixels)[3] ^= 0x55;
		for (uint64_t i = 4; step == 0 && i < stilb_image_size(&next); i += 8)
			((uint8_t *)next.pixels)[i] ^= 0xff;
		uint32_t id = s.render->scene.textures[0].texture.id;
		assert_int_equal(stilb_scene_set_texture(s.scene, 0, &next), STILB_OK);
		stilb_scene_changes changes = stilb_scene_changes_read(s.scene);
		assert_int_equal(stilb_render_update_scene(s.render, s.scene, &changes), STILB_OK);
		assert_true((s.render->scene.textures[0].texture.id == id) == (step == 0));
		stilb_image got = stage_picture(&s), want = shown(&s, &next, STILB_SCENE_MAP_COLOR, 1.0f);
		assert_memory_equal(got.pixels, want.pixels, stilb_image_size(&got));
		assert_true(difference(&got, &before) > 0.01);
		stilb_image_finish(&got);
		stilb_image_finish(&before);
		stilb_image_finish(&next);
		before = want;
	}
	stilb_image_finish(&before);
	stilb_image_finish(&first);
	stage_close(&s);
}

/* Dumps hold blocks and their levels, and levels that were given with texels. */
static void dumps_hold_them(void **state)
{
	(void)state;
	for (size_t f = 0; f <= FORMATS; f++) {
		stage s = stage_open((stilb_render_desc){.keep_textures = true}, 0);
		stilb_image blocks = blocks_make(formats[f < FORMATS ? f : 0], 24, 20, f % 3 ? 5 : 3);
		stilb_image texture = f < FORMATS ? blocks : decoded_of(&blocks);
		stilb_image picture = shown(&s, &texture, STILB_SCENE_MAP_COLOR, 4.0f), again = {0};
		stilb_render_pass pass = {.name = "main"};
		if (stilb_render_dump_save(s.render, &pass, 1, &s.view, 1, PATH) != STILB_OK)
			fail_msg("%s", stilb_error_message());
		stage_close(&s);
		stilb_render_dump *dump;
		if (stilb_render_dump_load(PATH, &dump) != STILB_OK)
			fail_msg("%s", stilb_error_message());
		s = stage_open((stilb_render_desc){0}, 0);
		if (stilb_render_dump_upload(dump, s.render) != STILB_OK)
			fail_msg("%s", stilb_error_message());
		assert_int_equal(stilb_render_frame_begin(s.render), STILB_OK);
		assert_int_equal(stilb_render_dump_record(dump, s.render, s.pool, 0), STILB_OK);
		assert_int_equal(stilb_render_dump_replay(dump, s.render, s.pool, 0), STILB_OK);
		assert_int_equal(stilb_render_read_image(s.render, &again), STILB_OK);
		assert_memory_equal(again.pixels, picture.pixels, stilb_image_size(&picture));
		stilb_render_dump_destroy(dump);
		stilb_image_finish(&again);
		stilb_image_finish(&picture);
		if (f == FORMATS)
			stilb_image_finish(&texture);
		stilb_image_finish(&blocks);
		stage_close(&s);
	}
	remove(PATH);
}

int main(void)
{
	if (reference_no_driver())
		return 77;
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(blocks_show_their_texels),
		cmocka_unit_test(devices_without_blocks_decode),
		cmocka_unit_test(normals_of_two_channels),
		cmocka_unit_test(without_a_surface),
		cmocka_unit_test(edits),
		cmocka_unit_test(dumps_hold_them),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
