/* Frame dumps on a Vulkan device: a dump with textures, several passes and views, and a sorted pass gives the same
 * picture, pixel by pixel, in every replay mode. */
#include "render/render_dump.h"
#include "support/picture_reference.h"
#include "support/test.h"

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PATH "test_render_dump_picture.dump"
#define SIDE 96u
#define QUADS 40u

static stilb_job_pool *pool;

static stilb_result make_render(int replay, int materials, stilb_render **render)
{
	stilb_render_desc desc = {.device = STILB_RENDER_DEVICE_VULKAN,
	                          .replay = (stilb_render_replay_mode)replay,
	                          .materials = (stilb_render_materials)materials,
	                          .width = SIDE,
	                          .height = SIDE,
	                          .samples = 1,
	                          .context_count = stilb_job_pool_worker_count(pool) + 1,
	                          .validate = true,
	                          .keep_textures = true};
	return stilb_render_create(&desc, render);
}

static stilb_render_texture make_texture(stilb_render *render, uint32_t seed)
{
	stilb_image image;
	stilb_render_texture texture;
	assert_int_equal(stilb_image_create(&image, 4, 4, 1 + seed % 4, STILB_IMAGE_U8_SRGB), STILB_OK);
	for (size_t i = 0; i < stilb_image_size(&image); i++)
		((uint8_t *)image.pixels)[i] = (uint8_t)(stilb_random_u64(seed, i) & 0xff);
	assert_int_equal(stilb_render_texture_create(render, &image, &texture), STILB_OK);
	stilb_image_finish(&image);
	return texture;
}

/* Upright squares, every other one with a texture, in two passes that see them from two sides. */
static void record_quads(stilb_render *render, stilb_render_mesh mesh, const stilb_render_material materials[QUADS])
{
	stilb_render_context *context = stilb_render_context_get(render, 0);
	for (uint32_t pass = 0; pass < 2; pass++) {
		assert_int_equal(stilb_render_pass_begin(render, pass, 2), STILB_OK);
		for (uint32_t segment = 0; segment < 2; segment++) {
			stilb_render_segment_begin(context, pass, segment);
			for (uint32_t q = segment; q < QUADS; q += 2) {
				float x = (float)(q % 8) - 3.5f, y = (float)(q / 8) - 2.0f, depth = -6.0f - (float)pass;
				stilb_mat4 turned = {{0.5f, 0, 0, 0, 0, 0, 0.5f, 0, 0, -0.5f, 0, 0, x, y, depth, 1}};
				stilb_render_draw_with_key(context, (QUADS - q) * 1000u, mesh, materials[q], &turned);
			}
			stilb_render_segment_end(context);
		}
		assert_int_equal(stilb_render_pass_end(render, pass), STILB_OK);
	}
}

/* What views show behind the models, for each round of the test. */
static enum { PLAIN, FLOOR, MAP, NOTHING, PANORAMA, BACKGROUNDS } background;

#define PANORAMA_WIDTH 32u
#define PANORAMA_HEIGHT 16u

static void fill_background(stilb_render_view *view)
{
	static float map[3 * STILB_SCENE_BACKDROP_WIDTH * STILB_SCENE_BACKDROP_HEIGHT];
	static float texels[3 * PANORAMA_WIDTH * PANORAMA_HEIGHT];
	static stilb_scene_floor floor = {.center = {0.0f, -1.5f, -5.0f}, .radius = 3.0f};
	static const stilb_scene_backdrop_kind kinds[BACKGROUNDS] = {
		[FLOOR] = STILB_SCENE_BACKDROP_COLOR,
		[MAP] = STILB_SCENE_BACKDROP_MAP,
		[NOTHING] = STILB_SCENE_BACKDROP_NOTHING,
	};
	for (size_t i = 0; i < sizeof map / sizeof *map; i++)
		map[i] = stilb_random_float(5, i);
	for (size_t i = 0; i < sizeof texels / sizeof *texels; i++)
		texels[i] = stilb_random_float(6, i) * (i == 3 * 100 ? 400.0f : 1.0f); /* one of them is a lamp */
	for (size_t i = 0; i < STILB_SCENE_FLOOR_SIDE * STILB_SCENE_FLOOR_SIDE; i++)
		floor.covered[i / STILB_SCENE_FLOOR_SIDE][i % STILB_SCENE_FLOOR_SIDE] = stilb_random_float(7, i);
	view->backdrop.kind = kinds[background];
	view->backdrop.color[0] = view->backdrop.color[2] = 0.7f;
	view->backdrop.map = background == MAP ? map : NULL;
	view->backdrop.floor = background == FLOOR ? &floor : NULL;
	view->surroundings.rotation = 0.4f;
	if (background == PANORAMA)
		view->surroundings.panorama = (stilb_image){.width = PANORAMA_WIDTH,
		                                            .height = PANORAMA_HEIGHT,
		                                            .channels = 3,
		                                            .format = STILB_IMAGE_F32_LINEAR,
		                                            .pixels = texels};
}

static void fill_views(stilb_render_view views[2])
{
	static const stilb_scene_light sun = {
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {0.0f, -0.6f, -0.8f}, .intensity = {2.0f, 2.0f, 2.0f}};
	stilb_mat4 projection = stilb_mat4_perspective(1.0f, 1.0f, 0.1f, 100.0f);
	for (int v = 0; v < 2; v++) {
		stilb_mat4 view = stilb_mat4_view(stilb_vec3_make(0.0f, 0.0f, 1.0f), 0.3f * (float)v, 0.0f);
		views[v] = (stilb_render_view){.view_projection = stilb_mat4_multiply(projection, view),
		                               .camera_position = {0.0f, 0.0f, 1.0f},
		                               .lights = &sun,
		                               .light_count = 1,
		                               .surroundings = {.sky = {0.2f, 0.3f, 0.5f}, .ground = {0.1f, 0.1f, 0.1f}},
		                               .shading = stilb_render_shading_default()};
		fill_background(&views[v]);
	}
}

/* Draws, and writes the frame to PATH. */
static void draw_and_save(stilb_render *render, stilb_image *picture)
{
	static const stilb_render_pass passes[2] = {{.name = "behind", .view = 1, .order = 2},
	                                            {.name = "in front", .view = 0, .order = 1, .sort = true}};
	stilb_render_view views[2];
	stilb_scene_mesh plane;
	stilb_render_mesh mesh;
	stilb_render_material materials[QUADS];
	fill_views(views);
	assert_int_equal(stilb_scene_mesh_plane(&plane), STILB_OK);
	assert_int_equal(stilb_render_mesh_create(render, &plane, &mesh), STILB_OK);
	stilb_scene_mesh_finish(&plane);
	for (uint32_t q = 0; q < QUADS; q++) {
		stilb_scene_material material = {
			{0.9f, 0.3f + 0.01f * (float)q, 0.5f}, {0.05f, 0.05f, 0.05f}, .roughness = 0.7f};
		stilb_render_texture texture = q % 2 ? make_texture(render, q) : (stilb_render_texture){0};
		assert_int_equal(stilb_render_material_create(render, &material, texture, &materials[q]), STILB_OK);
	}
	assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
	record_quads(render, mesh, materials);
	assert_int_equal(stilb_render_replay(render, passes, 2, views, 2, pool, 0), STILB_OK);
	assert_int_equal(stilb_render_read_image(render, picture), STILB_OK);
	assert_int_equal(stilb_render_dump_save(render, passes, 2, views, 2, PATH), STILB_OK);
	assert_int_equal(stilb_render_validation_messages(render), 0);
}

static void assert_plays(int replay, int materials, const stilb_image *picture, uint64_t hash)
{
	stilb_render *render;
	stilb_render_dump *dump;
	stilb_image played;
	assert_int_equal(make_render(replay, materials, &render), STILB_OK);
	assert_int_equal(stilb_render_dump_load(PATH, &dump), STILB_OK);
	assert_int_equal(stilb_render_dump_upload(dump, render), STILB_OK);
	for (int frame = 0; frame < 3; frame++) {
		assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
		assert_int_equal(stilb_render_dump_record(dump, render, pool, 0), STILB_OK);
		assert_int_equal(stilb_render_dump_replay(dump, render, pool, 0), STILB_OK);
		assert_true(stilb_render_stream_hash(render) == hash);
	}
	assert_int_equal(stilb_render_read_image(render, &played), STILB_OK);
	assert_int_equal(stilb_image_size(&played), stilb_image_size(picture));
	assert_memory_equal(played.pixels, picture->pixels, stilb_image_size(picture));
	stilb_render_dump_costs costs; /* commands that are never submitted cause no validation message */
	assert_int_equal(stilb_render_dump_measure(dump, render, pool, 0, 0.02, &costs), STILB_OK);
	assert_int_equal(stilb_render_validation_messages(render), 0);
	stilb_image_finish(&played);
	stilb_render_dump_destroy(dump);
	stilb_render_destroy(render);
}

/* The number of pixels that differ from the first one; 0 for an empty picture. */
static size_t pixels_drawn(const stilb_image *picture)
{
	const uint8_t *pixels = picture->pixels;
	size_t drawn = 0;
	for (size_t i = 0; i < stilb_image_size(picture); i += picture->channels)
		drawn += memcmp(pixels + i, pixels, 3) != 0;
	return drawn;
}

static void the_same_pixels(void **state)
{
	(void)state;
	stilb_render *render;
	stilb_image picture;
	background = PLAIN;
	assert_int_equal(make_render(STILB_RENDER_REPLAY_DIRECT, STILB_RENDER_MATERIALS_INDEX, &render), STILB_OK);
	draw_and_save(render, &picture);
	uint64_t hash = stilb_render_stream_hash(render);
	stilb_render_destroy(render);
	assert_true(pixels_drawn(&picture) > SIDE * SIDE / 5);
	for (int way = 0; way < 9; way++)
		if (!TEST_ASAN || way % 3 == way / 3) /* test_render_picture has all pairs */
			assert_plays(way % 3, way / 3, &picture, hash);
	stilb_image_finish(&picture);
}

/* The number of bytes in which two pictures of one size differ. */
static size_t bytes_that_differ(const stilb_image *a, const stilb_image *b)
{
	size_t differ = 0;
	assert_true(a->width == b->width && a->height == b->height);
	for (uint32_t i = 0; i < a->width * a->height; i++)
		for (uint32_t c = 0; c < 3; c++)
			differ +=
				((const uint8_t *)a->pixels)[i * a->channels + c] != ((const uint8_t *)b->pixels)[i * b->channels + c];
	return differ;
}

/* Each kind of background, and a panorama, which lights the squares, too. */
static void backgrounds_come_back(void **state)
{
	(void)state;
	stilb_image pictures[BACKGROUNDS];
	for (int b = PLAIN + 1; b < BACKGROUNDS; b++) {
		stilb_render *render;
		background = b;
		assert_int_equal(make_render(b % 3, STILB_RENDER_MATERIALS_INDEX, &render), STILB_OK);
		draw_and_save(render, &pictures[b]);
		uint64_t hash = stilb_render_stream_hash(render);
		stilb_render_destroy(render);
		assert_plays((b + 1) % 3, b % 2, &pictures[b], hash);
		for (int other = PLAIN + 1; other < b; other++)
			assert_true(bytes_that_differ(&pictures[b], &pictures[other]) > SIDE * SIDE / 20);
	}
	for (int b = PLAIN + 1; b < BACKGROUNDS; b++)
		stilb_image_finish(&pictures[b]);
}

int main(void)
{
	struct CMUnitTest tests[] = {cmocka_unit_test(the_same_pixels), cmocka_unit_test(backgrounds_come_back)};
	stilb_job_pool_desc desc = {.worker_count = 2};
	if (reference_no_driver())
		return 77;
	if (stilb_job_pool_create(&desc, &pool) != 0)
		return 1;
	int failed = cmocka_run_group_tests(tests, NULL, NULL);
	remove(PATH);
	stilb_job_pool_destroy(pool);
	return failed;
}
