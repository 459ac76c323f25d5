/* Backgrounds and panoramas in frame dumps, on the null device: they come back bit by bit; a file that is played and
 * dumped again is the same file; a damaged one is refused with words that name the place, or plays. */
#include "render/render_dump_format.h"
#include "render/render_internal.h"
#include "support/test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PATH "test_render_dump_backdrop.dump"
#define AGAIN "test_render_dump_backdrop_again.dump"
#define VIEWS 3u
#define WIDTH 5u /* of the panorama; odd, so that the part needs its padding */
#define HEIGHT 3u

static float map[3 * STILB_SCENE_BACKDROP_WIDTH * STILB_SCENE_BACKDROP_HEIGHT], texels[2][3 * WIDTH * HEIGHT];
static stilb_scene_floor floor_below = {.center = {1.0f, -2.0f, 3.0f}, .radius = 4.0f};

static const stilb_render_pass passes[1] = {{.name = "main"}};

static stilb_render *make_render(void)
{
	stilb_render_desc desc = {
		.device = STILB_RENDER_DEVICE_NULL, .width = 8, .height = 8, .context_count = 1, .keep_textures = true};
	stilb_render *render;
	assert_int_equal(stilb_render_create(&desc, &render), STILB_OK);
	return render;
}

/* View 0 has a panorama, 1 a map and the same panorama turned, 2 a floor. */
static void fill_views(stilb_render_view views[VIEWS])
{
	for (size_t i = 0; i < sizeof map / sizeof *map; i++)
		map[i] = stilb_random_float(1, i);
	for (size_t i = 0; i < sizeof texels / sizeof(float); i++)
		texels[i / (3 * WIDTH * HEIGHT)][i % (3 * WIDTH * HEIGHT)] = stilb_random_float(2, i);
	for (size_t i = 0; i < STILB_SCENE_FLOOR_SIDE * STILB_SCENE_FLOOR_SIDE; i++)
		floor_below.covered[i / STILB_SCENE_FLOOR_SIDE][i % STILB_SCENE_FLOOR_SIDE] = stilb_random_float(3, i);
	for (uint32_t v = 0; v < VIEWS; v++) {
		views[v] =
			(stilb_render_view){.view_projection = stilb_mat4_identity(), .shading = stilb_render_shading_default()};
		if (v < 2)
			views[v].surroundings.panorama = (stilb_image){WIDTH, HEIGHT, 3, STILB_IMAGE_F32_LINEAR, texels[0], 0};
		views[v].surroundings.rotation = 0.25f * (float)v;
	}
	views[1].backdrop = (stilb_scene_backdrop){.kind = STILB_SCENE_BACKDROP_MAP, .map = map};
	views[2].backdrop =
		(stilb_scene_backdrop){.kind = STILB_SCENE_BACKDROP_COLOR, .color = {0.5f, 0.25f, 2.0f}, .floor = &floor_below};
}

static bool change_before_save; /* a texel of the panorama */

/* Draws a frame of one triangle mesh and saves it. Returns the stream's hash. */
static uint64_t draw(const stilb_render_view *views, uint32_t view_count, const char *path)
{
	stilb_job_pool *pool;
	stilb_scene_mesh plane;
	stilb_render_mesh mesh;
	stilb_render_material material;
	stilb_scene_material paint = {.diffuse = {0.5f, 0.5f, 0.5f}, .roughness = 0.5f};
	stilb_mat4 place = stilb_mat4_identity();
	stilb_render *render = make_render();
	assert_int_equal(stilb_job_pool_create(&(stilb_job_pool_desc){0}, &pool), 0);
	assert_int_equal(stilb_scene_mesh_plane(&plane), STILB_OK);
	assert_int_equal(stilb_render_mesh_create(render, &plane, &mesh), STILB_OK);
	stilb_scene_mesh_finish(&plane);
	assert_int_equal(stilb_render_material_create(render, &paint, (stilb_render_texture){0}, &material), STILB_OK);
	assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
	assert_int_equal(stilb_render_pass_begin(render, 0, 1), STILB_OK);
	stilb_render_context *context = stilb_render_context_get(render, 0);
	stilb_render_segment_begin(context, 0, 0);
	stilb_render_draw_with_key(context, 0, mesh, material, &place);
	stilb_render_segment_end(context);
	assert_int_equal(stilb_render_pass_end(render, 0), STILB_OK);
	assert_int_equal(stilb_render_replay(render, passes, 1, views, view_count, pool, 0), STILB_OK);
	texels[0][0] += change_before_save ? 1.0f : 0.0f;
	assert_int_equal(stilb_render_dump_save(render, passes, 1, views, view_count, path), STILB_OK);
	uint64_t hash = stilb_render_stream_hash(render);
	stilb_render_destroy(render);
	stilb_job_pool_destroy(pool);
	return hash;
}

static uint8_t *read_bytes(const char *path, size_t *size)
{
	FILE *file = fopen(path, "rb");
	assert_non_null(file);
	assert_int_equal(fseek(file, 0, SEEK_END), 0);
	*size = (size_t)ftell(file);
	rewind(file);
	uint8_t *bytes = malloc(*size);
	assert_non_null(bytes);
	assert_int_equal(fread(bytes, 1, *size, file), *size);
	fclose(file);
	return bytes;
}

/* Reads from a copy in a block of exactly `size` bytes, so that the address sanitizer sees reads beyond it. */
static stilb_result read_copy(const uint8_t *bytes, size_t size, stilb_render_dump **dump)
{
	uint8_t *copy = malloc(size);
	assert_non_null(copy);
	memcpy(copy, bytes, size);
	return render_dump_read(copy, size, "a.dump", dump);
}

static void sign(uint8_t *bytes, size_t size)
{
	uint64_t checksum = stilb_hash_fnv1a64(STILB_FNV1A64_START, bytes, size - sizeof checksum);
	memcpy(bytes + size - sizeof checksum, &checksum, sizeof checksum);
}

/* Plays a dump and saves it again; returns the stream's hash. */
static uint64_t play(stilb_render_dump *dump, const char *path)
{
	stilb_job_pool *pool;
	stilb_render *render = make_render();
	assert_int_equal(stilb_job_pool_create(&(stilb_job_pool_desc){0}, &pool), 0);
	assert_int_equal(stilb_render_dump_upload(dump, render), STILB_OK);
	assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
	assert_int_equal(stilb_render_dump_record(dump, render, pool, 0), STILB_OK);
	assert_int_equal(stilb_render_dump_replay(dump, render, pool, 0), STILB_OK);
	uint64_t hash = stilb_render_stream_hash(render);
	assert_int_equal(stilb_render_dump_save(render, dump->pass_table, dump->header->passes, dump->view_table,
	                                        dump->header->views, path),
	                 STILB_OK);
	stilb_render_destroy(render);
	stilb_job_pool_destroy(pool);
	return hash;
}

static void they_come_back(void **state)
{
	(void)state;
	stilb_render_view views[VIEWS];
	stilb_render_dump *dump;
	size_t size, again_size;
	fill_views(views);
	uint64_t hash = draw(views, VIEWS, PATH);
	assert_int_equal(stilb_render_dump_load(PATH, &dump), STILB_OK);
	assert_true(dump->header->stream_hash == hash);
	assert_true(play(dump, AGAIN) == hash);
	for (uint32_t v = 0; v < VIEWS; v++) {
		const stilb_render_view *view = &dump->view_table[v];
		assert_int_equal(view->backdrop.kind, views[v].backdrop.kind);
		assert_memory_equal(view->backdrop.color, views[v].backdrop.color, sizeof view->backdrop.color);
		assert_int_equal(view->surroundings.panorama.width, v < 2 ? WIDTH : 0);
		if (v < 2)
			assert_memory_equal(view->surroundings.panorama.pixels, texels[0], sizeof texels[0]);
		assert_true(v >= 2 || view->surroundings.rotation == views[v].surroundings.rotation);
	}
	assert_memory_equal(dump->view_table[1].backdrop.map, map, sizeof map);
	assert_memory_equal(dump->view_table[2].backdrop.floor, &floor_below, sizeof floor_below);
	stilb_render_dump_destroy(dump);
	uint8_t *bytes = read_bytes(PATH, &size), *again = read_bytes(AGAIN, &again_size);
	assert_int_equal(size, again_size);
	assert_memory_equal(bytes, again, size);
	free(bytes);
	free(again);
}

static void count_lines(void *user, const char *line)
{
	*(int *)user += strstr(line, "without a panorama") ? 1 : 0;
}

/* A view whose panorama is not the frame's first is dumped as it was shown, by its sky and ground, also if both have
 * the same texels; and so is a frame whose panorama was written to since. */
static void other_panoramas_are_not_kept(void **state)
{
	(void)state;
	for (int way = 0; way < 3; way++) {
		stilb_render_view views[VIEWS];
		stilb_render_dump *dump;
		int lines = 0;
		fill_views(views);
		if (way == 0)
			memcpy(texels[1], texels[0], sizeof texels[0]);
		if (way < 2)
			views[1].surroundings.panorama.pixels = texels[1];
		change_before_save = way == 2;
		stilb_log_set(count_lines, &lines);
		uint64_t hash = draw(views, VIEWS, PATH);
		stilb_log_set(NULL, NULL);
		change_before_save = false;
		assert_int_equal(lines, 1);
		assert_int_equal(stilb_render_dump_load(PATH, &dump), STILB_OK);
		assert_int_equal(dump->backdrops[0].width, way < 2 ? WIDTH : 0);
		assert_int_equal(dump->backdrops[1].width, 0);
		assert_true((play(dump, AGAIN) == hash) == (way < 2)); /* else the file's is that of the frame without it */
		assert_true(play(dump, AGAIN) == dump->header->stream_hash);
		stilb_render_dump_destroy(dump);
	}
}

/* Frames that show sky and ground alone have no such part: their files are those of before it. */
static void plain_frames_have_no_part(void **state)
{
	(void)state;
	stilb_render_view views[VIEWS];
	stilb_render_dump *dump;
	fill_views(views);
	draw(&(stilb_render_view){.view_projection = stilb_mat4_identity(), .shading = views[0].shading}, 1, PATH);
	assert_int_equal(stilb_render_dump_load(PATH, &dump), STILB_OK);
	assert_int_equal(dump->header->backdrop_bytes, 0);
	stilb_render_dump_destroy(dump);
}

#define RECORD(view, field) (40 * (view) + offsetof(render_dump_backdrop, field))
#define FLOATS(index) (40 * VIEWS + 4 * (index))
#define MAP_AT (3 * WIDTH * HEIGHT)
#define FLOOR_AT (MAP_AT + 3 * STILB_SCENE_BACKDROP_WIDTH * STILB_SCENE_BACKDROP_HEIGHT)

/* Offset in the part, the 32 bits to write there, and a part of the message to expect. */
static const struct damage {
	size_t offset;
	uint32_t value;
	const char *reason;
} damages[] = {
	{RECORD(0, kind), 4, "background of view 0: unknown kind 4, map 0 or floor 0"},
	{RECORD(1, map), 2, "background of view 1: unknown kind 1, map 2"},
	{RECORD(2, floor), UINT32_MAX, "floor 4294967295"},
	{RECORD(2, color) + 4, 0xbf800000, "background of view 2: a number is negative or not finite"},
	{RECORD(0, rotation), 0x7fc00000, "background of view 0: a number is negative or not finite"},
	{RECORD(0, width), 0, "background of view 0: a panorama without a width"},
	{RECORD(0, width), 65537, "background of view 0: a panorama of 65537x3 pixels of 3 channels; a side has 1..65536"},
	{RECORD(0, height), 0, "a panorama of 5x0 pixels"},
	{RECORD(0, channels), 2, "pixels of 2 channels"},
	{RECORD(1, width), 6, "background of view 1: another panorama than a view before it has"},
	{RECORD(1, map), 0, "bytes of backgrounds, but views have"},
	{RECORD(0, floor), 1, "bytes of backgrounds, but views have"},
	{FLOATS(MAP_AT), 0xbf800000, "background of view 1: its map has a negative number"},
	{FLOATS(FLOOR_AT - 1), 0x7f800000, "background of view 1: its map has a negative number"},
	{FLOATS(FLOOR_AT), 0x7fc00000, "background of view 2: a number of its floor is out of range"},
	{FLOATS(FLOOR_AT + 3), 0, "background of view 2: a number of its floor is out of range"},
	{FLOATS(FLOOR_AT + 4099), 0x3f800001, "background of view 2: a number of its floor is out of range"},
	{FLOATS(FLOOR_AT + 4100), 1, "the bytes behind the backgrounds are not zero"},
};

static void the_message_names_the_place(void **state)
{
	(void)state;
	stilb_render_view views[VIEWS];
	stilb_render_dump *dump;
	size_t size;
	uint64_t begin[RENDER_DUMP_PARTS + 1];
	fill_views(views);
	draw(views, VIEWS, PATH);
	uint8_t *bytes = read_bytes(PATH, &size);
	assert_true(render_dump_layout((render_dump_header *)bytes, begin) && begin[RENDER_DUMP_PARTS] == size);
	for (size_t d = 0; d < sizeof damages / sizeof *damages; d++) {
		uint8_t *at = bytes + begin[RENDER_DUMP_BACKDROPS] + damages[d].offset, old[4];
		memcpy(old, at, sizeof old);
		memcpy(at, &damages[d].value, sizeof old);
		sign(bytes, size);
		assert_int_equal(read_copy(bytes, size, &dump), STILB_ERROR_FILE);
		if (!strstr(stilb_error_message(), damages[d].reason))
			fail_msg("'%s' does not say '%s'", stilb_error_message(), damages[d].reason);
		memcpy(at, old, sizeof old);
	}
	free(bytes);
}

/* Every byte of the header and of the records, and some of the floats, changed and signed. */
static void every_signed_change_is_refused_or_plays(void **state)
{
	(void)state;
	stilb_render_view views[VIEWS];
	size_t size, played = 0, refused = 0;
	uint64_t begin[RENDER_DUMP_PARTS + 1];
	fill_views(views);
	draw(views, VIEWS, PATH);
	uint8_t *bytes = read_bytes(PATH, &size);
	assert_true(render_dump_layout((render_dump_header *)bytes, begin));
	size_t records = begin[RENDER_DUMP_BACKDROPS], floats = records + FLOATS(0);
	for (size_t i = 0; i < size - 8; i += i < begin[1] || (i >= records && i < floats) ? 1 : 311) {
		for (int bit = 0; bit < 8; bit += 7) {
			stilb_render_dump *dump;
			bytes[i] ^= (uint8_t)(1 << bit);
			sign(bytes, size);
			bool good = read_copy(bytes, size, &dump) == STILB_OK;
			refused += !good;
			if (good && i >= records && played < 4) {
				play(dump, AGAIN);
				played++;
			}
			stilb_render_dump_destroy(dump);
			bytes[i] ^= (uint8_t)(1 << bit);
		}
	}
	assert_true(played == 4 && refused > 100);
	free(bytes);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(they_come_back),
		cmocka_unit_test(other_panoramas_are_not_kept),
		cmocka_unit_test(plain_frames_have_no_part),
		cmocka_unit_test(the_message_names_the_place),
		cmocka_unit_test(every_signed_change_is_refused_or_plays),
	};
	int failed = cmocka_run_group_tests(tests, NULL, NULL);
	remove(PATH);
	remove(AGAIN);
	return failed;
}
