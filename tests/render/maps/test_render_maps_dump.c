/* Dumps of frames with surfaces: the same picture, the same stream hash and the same file again, in every replay mode,
 * also with levels of detail that fade and morph; damaged ones are refused. With the argument "null" on that device:
 * without pictures. */
#include "render/maps/maps_stage.h"
#include "render/render_dump.h"
#include "render/render_dump_format.h"
#include "support/folder.h"

/* Of their own, because both tests may run at once. */
#define PATH (null_device ? "test_render_maps_null.dump" : "test_render_maps.dump")
#define PATH_AGAIN (null_device ? "test_render_maps_null_again.dump" : "test_render_maps_again.dump")
#define CELLS 5u

static bool null_device;

static stilb_image noise(stilb_image_format format, uint32_t channels, uint64_t seed)
{
	stilb_image image;
	assert_int_equal(stilb_image_create(&image, 9, 6, channels, format), STILB_OK);
	for (size_t i = 0; i < stilb_image_size(&image); i++)
		((uint8_t *)image.pixels)[i] = (uint8_t)(stilb_random_u64(seed, i) & 0xff);
	return image;
}

/* A square of many triangles with a level of two, which morphs. */
typedef struct grid {
	stilb_scene_vertex vertices[25], morph[25];
	stilb_scene_vertex_extra extras[25];
	uint32_t indices[96], coarse[6];
	stilb_scene_level level;
	stilb_scene_mesh mesh;
} grid;

static uint32_t grid_vertex(uint32_t x, uint32_t y)
{
	/* The corners come first: the level uses them alone. */
	static const uint32_t places[25] = {0,  4,  5,  6,  1,  7,  8,  9, 10, 11, 12, 13, 14,
	                                    15, 16, 17, 18, 19, 20, 21, 2, 22, 23, 24, 3};
	return places[5 * y + x];
}

static void grid_make(grid *g)
{
	*g = (grid){0};
	uint32_t *index = g->indices;
	for (uint32_t i = 0; i < 25; i++) {
		float x = (float)(i % 5) / 2.0f - 1.0f, z = (float)(i / 5) / 2.0f - 1.0f;
		uint32_t v = grid_vertex(i % 5, i / 5);
		g->vertices[v] = (stilb_scene_vertex){
			.position = {x, 0.1f * x * z, z}, .normal = {0, 1, 0}, .uv = {(x + 1) / 2, (z + 1) / 2}};
		g->morph[v] = g->vertices[v];
		g->morph[v].position[1] = 0.0f;
		g->extras[v] = (stilb_scene_vertex_extra){
			.tangent = {1, 0, 0, i % 3 ? 1.0f : -1.0f}, .uv = {z, x}, .color = {1, 1, x * x, 0.75f}};
	}
	for (uint32_t i = 0; i < 16; i++) {
		uint32_t x = i % 4, y = i / 4;
		const uint32_t corners[4] = {grid_vertex(x, y), grid_vertex(x, y + 1), grid_vertex(x + 1, y + 1),
		                             grid_vertex(x + 1, y)};
		const uint32_t quad[6] = {corners[0], corners[1], corners[2], corners[0], corners[2], corners[3]};
		memcpy(index, quad, sizeof quad);
		index += 6;
	}
	const uint32_t coarse[6] = {0, 2, 3, 0, 3, 1};
	memcpy(g->coarse, coarse, sizeof coarse);
	g->level = (stilb_scene_level){.index_count = 6, .vertex_count = 4, .error = 0.1f};
	g->mesh = (stilb_scene_mesh){.vertices = g->vertices,
	                             .extras = g->extras,
	                             .indices = g->indices,
	                             .vertex_count = 25,
	                             .index_count = 96,
	                             .level_count = 1,
	                             .level_index_count = 6,
	                             .levels = &g->level,
	                             .level_indices = g->coarse,
	                             .morph = g->morph};
}

/* Cells of two meshes in five materials: a matt surface with all maps, a mask, one that blends, one without maps, and a
 * material without a surface. */
static void show_cells(stage *s)
{
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_image images[3] = {noise(STILB_IMAGE_U8_SRGB, 4, 1), noise(STILB_IMAGE_U8_LINEAR, 3, 2),
	                         noise(STILB_IMAGE_U8_LINEAR, 2, 3)};
	uint32_t textures[3], materials[5], meshes[2];
	for (int i = 0; i < 3; i++) {
		textures[i] = 1 + stilb_scene_build_texture(build, &images[i]);
		stilb_image_finish(&images[i]);
	}
	stilb_scene_surface surface = surface_matt();
	for (uint32_t i = 0; i < RENDER_MAPS; i++)
		surface.maps[i].texture = textures[i == STILB_SCENE_MAP_NORMAL                                           ? 2
		                                   : stilb_scene_map_is_color((stilb_scene_map_kind)i, surface.workflow) ? 0
		                                                                                                         : 1];
	surface.maps[STILB_SCENE_MAP_OCCLUSION].set = 1;
	surface.maps[STILB_SCENE_MAP_OCCLUSION].wrap_u = STILB_SCENE_MIRROR;
	reference_set3(surface.emission, 0.5f, 0.25f, 0.125f);
	surface.clearcoat = 0.5f;
	materials[0] = stage_material(build, &surface);
	surface.clearcoat = 0.0f;
	for (uint32_t i = RENDER_MAPS_PLAIN; i < RENDER_MAPS; i++)
		surface.maps[i].texture = 0;
	surface.alpha = STILB_SCENE_MASK;
	materials[1] = stage_material(build, &surface);
	surface.alpha = STILB_SCENE_BLEND;
	surface.one_sided = true;
	materials[2] = stage_material(build, &surface);
	surface = surface_unlit();
	surface.color[1] = 0.5f;
	materials[3] = stage_material(build, &surface);
	static const float grey[3] = {0.5f, 0.4f, 0.3f}, none[3] = {0};
	stilb_scene_material plain = stilb_scene_material_make(grey, none, 0.5f);
	plain.diffuse_texture = textures[0];
	materials[4] = stilb_scene_build_material(build, &plain);
	grid g;
	grid_make(&g);
	meshes[0] = stilb_scene_build_mesh(build, &g.mesh);
	g.mesh.extras = NULL;
	meshes[1] = stilb_scene_build_mesh(build, &g.mesh);
	for (uint32_t cell = 0; cell < 2 * CELLS * CELLS; cell++) {
		float scale = 1.0f / (float)CELLS, x = (float)(2 * (cell % CELLS) + 1),
			  z = (float)(2 * (cell / CELLS % CELLS) + 1);
		stage_model(
			build, meshes[cell % 3 == 0], materials[(cell * 7 + cell / CELLS) % 5],
			stilb_mat4_scale_translate(1.3f * scale, -1.0f + x * scale, (float)(cell % 9) * 0.02f, -1.0f + z * scale));
	}
	stage_show(s, build);
}

/* Few kinds with the address sanitizer on a driver, whose programs take most of the time: the null device runs all. */
#define FEW (TEST_ASAN && !null_device)

static stage dump_stage(uint32_t kind)
{
	stilb_render_desc desc = {.device = null_device ? STILB_RENDER_DEVICE_NULL : STILB_RENDER_DEVICE_VULKAN,
	                          .replay = (stilb_render_replay_mode)(kind % 3),
	                          .samples = kind % 4 == 3 && !null_device ? 4 : 1,
	                          .width = 64,
	                          .morph = true,
	                          .float_vertices = kind % 5 == 4,
	                          .keep_textures = true};
	stage s = stage_open(desc, kind % 2 * 2);
	s.view.both_sides = kind % 2;
	return s;
}

static stilb_image dump_picture(stage *s)
{
	stilb_image image = {0};
	if (!null_device && stilb_render_read_image(s->render, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return image;
}

static void dump_save(stage *s, const char *path)
{
	stilb_render_pass pass = {.name = "main"};
	if (stilb_render_dump_save(s->render, &pass, 1, &s->view, 1, path) != STILB_OK)
		fail_msg("%s", stilb_error_message());
}

static uint8_t *file_bytes(const char *path, size_t *size)
{
	FILE *file = fopen(path, "rb");
	assert_non_null(file);
	uint8_t *bytes = malloc(1 << 20);
	assert_non_null(bytes);
	*size = fread(bytes, 1, 1 << 20, file);
	assert_true(*size > 0 && *size < 1 << 20);
	fclose(file);
	return bytes;
}

static void assert_files_are_equal(void)
{
	size_t a, b;
	uint8_t *first = file_bytes(PATH, &a), *second = file_bytes(PATH_AGAIN, &b);
	assert_int_equal(a, b);
	assert_memory_equal(first, second, a);
	free(first);
	free(second);
}

static void assert_plays(const stilb_image *picture, uint64_t hash, uint32_t kind)
{
	stilb_render_dump *dump;
	if (stilb_render_dump_load(PATH, &dump) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stage s = dump_stage(kind);
	stilb_render_dump_info info = stilb_render_dump_info_get(dump);
	assert_true(info.stream_hash == hash);
	if (stilb_render_dump_upload(dump, s.render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(stilb_render_frame_begin(s.render), STILB_OK);
	assert_int_equal(stilb_render_dump_record(dump, s.render, s.pool, 0), STILB_OK);
	assert_int_equal(stilb_render_dump_replay(dump, s.render, s.pool, 0), STILB_OK);
	assert_true(stilb_render_stream_hash(s.render) == hash);
	stilb_image again = dump_picture(&s);
	assert_int_equal(again.width, picture->width);
	if (picture->pixels)
		assert_memory_equal(again.pixels, picture->pixels, stilb_image_size(picture));
	stilb_image_finish(&again);
	s.view = dump->view_table[0];
	dump_save(&s, PATH_AGAIN);
	assert_files_are_equal();
	stilb_render_dump_destroy(dump);
	stage_close(&s);
}

static void a_dump_is_the_frame(void **state)
{
	(void)state;
	static const stilb_render_detail_mode modes[] = {STILB_RENDER_DETAIL_OFF, STILB_RENDER_DETAIL_FADE,
	                                                 STILB_RENDER_DETAIL_MORPH, STILB_RENDER_DETAIL_POP};
	for (uint32_t kind = 0; kind < 8; kind += FEW ? 3 : 1) {
		stage s = dump_stage(kind);
		s.view.detail = (stilb_render_detail){modes[kind % 4], 0.4f};
		show_cells(&s);
		stage_frame(&s);
		s.view.detail.error = modes[kind % 4] == STILB_RENDER_DETAIL_MORPH ? 0.75f : 1.5f;
		for (int f = 0; f < 6; f++)
			stage_frame(&s);
		uint64_t hash = stilb_render_stream_hash(s.render);
		stilb_image picture = dump_picture(&s);
		dump_save(&s, PATH);
		stage_close(&s);
		assert_plays(&picture, hash, kind);
		stilb_image_finish(&picture);
	}
	remove(PATH);
	remove(PATH_AGAIN);
}

/* How many of the frame's draws fade or have morphed. */
static uint32_t changing_draws(const stage *s)
{
	const render_pass_lists *lists = &s->render->passes[0];
	uint32_t count = 0;
	for (uint32_t r = 0; r < lists->run_count; r++)
		for (uint32_t c = lists->runs[r].first; c < lists->runs[r].first + lists->runs[r].count; c++)
			count += render_command_detail(&render_commands(s->render)[c]) > 0;
	return count;
}

/* The same bits for each number of workers and each mode, with levels that fade or morph. */
static void levels_are_the_same_everywhere(void **state)
{
	(void)state;
	for (int morph = 0; morph < 2; morph++) {
		stilb_image first = {0};
		uint64_t hash = 0;
		for (uint32_t kind = 0; kind < 6; kind += FEW ? 2 : 1) {
			stilb_render_desc desc = {.device = null_device ? STILB_RENDER_DEVICE_NULL : STILB_RENDER_DEVICE_VULKAN,
			                          .replay = (stilb_render_replay_mode)(kind % 3),
			                          .width = 64,
			                          .morph = true};
			stage s = stage_open(desc, kind / 3 * 3);
			s.view.detail = (stilb_render_detail){morph ? STILB_RENDER_DETAIL_MORPH : STILB_RENDER_DETAIL_FADE, 0.4f};
			show_cells(&s);
			stage_frame(&s);
			s.view.detail.error = morph ? 0.75f : 1.5f; /* the level is off by some 0.8 pixels */
			for (int f = 0; f < 5; f++)
				stage_frame(&s);
			assert_true(changing_draws(&s) >= 10);
			stilb_image picture = dump_picture(&s);
			if (kind == 0) {
				first = picture;
				hash = stilb_render_stream_hash(s.render);
			} else {
				assert_true(stilb_render_stream_hash(s.render) == hash);
				if (!null_device)
					assert_memory_equal(picture.pixels, first.pixels, stilb_image_size(&first));
				stilb_image_finish(&picture);
			}
			stage_close(&s);
		}
		stilb_image_finish(&first);
	}
}

/* Vertices that lie in pairs, because their mesh may morph, have the same extras. */
static void pairs_have_their_extras(void **state)
{
	(void)state;
	stilb_image pictures[2] = {{0}};
	for (int morph = 0; morph < 2 && !null_device; morph++) {
		stage s = stage_open((stilb_render_desc){.width = 64, .morph = morph}, 0);
		show_cells(&s);
		pictures[morph] = stage_picture(&s);
		stage_close(&s);
	}
	if (!null_device)
		assert_memory_equal(pictures[0].pixels, pictures[1].pixels, stilb_image_size(&pictures[0]));
	stilb_image_finish(&pictures[0]);
	stilb_image_finish(&pictures[1]);
}

/* Draws of a material come together: each set is bound once, but for those that blend. A sorted pass stays as it is. */
static void draws_of_a_material_come_together(void **state)
{
	(void)state;
	for (int sort = 0; sort < 2; sort++) {
		stage s = dump_stage(0);
		s.sort = sort;
		show_cells(&s);
		stage_frame(&s);
		const render_pass_lists *lists = &s.render->passes[0];
		uint32_t runs[8] = {0}, most = 0, plain = 0;
		uint64_t last = 0, draws = 0;
		for (uint32_t r = 0; r < lists->run_count; r++) {
			uint64_t of_maps = lists->runs[r].state & RENDER_STATE_MAPS;
			uint32_t maps = of_maps ? render_state_group(lists->runs[r].state) : 7;
			bool blends = of_maps && render_group_of(&s.render->resources, maps)->key.bits & RENDER_MAPS_BLEND;
			draws += lists->runs[r].count;
			plain += !of_maps && last; /* behind some with maps */
			runs[maps] += !blends && (r == 0 || !of_maps ||
			                          (lists->runs[r - 1].state & RENDER_INDEX_MASK) !=
			                              (lists->runs[r].state & RENDER_INDEX_MASK));
			last = of_maps;
		}
		for (int m = 0; m < 7; m++)
			most = runs[m] > most ? runs[m] : most;
		assert_int_equal(draws, 2 * CELLS * CELLS);
		assert_true(sort ? most > 3 && plain > 0 : most == 1 && plain == 0);
		stage_close(&s);
	}
}

static void sign(uint8_t *bytes, size_t size)
{
	uint64_t checksum = stilb_hash_fnv1a64(STILB_FNV1A64_START, bytes, size - sizeof checksum);
	memcpy(bytes + size - sizeof checksum, &checksum, sizeof checksum);
}

static const struct {
	render_dump_part part;
	size_t offset;
	uint32_t value;
	const char *reason;
} damages[] = {
	{RENDER_DUMP_HEADER, offsetof(render_dump_header, surfaces), 3, "do not add up"},
	{RENDER_DUMP_HEADER, offsetof(render_dump_header, extras), 1, "do not add up"},
	{RENDER_DUMP_MATERIALS, offsetof(render_dump_material, surface), 0, "material 1: surface 2, not 1"},
	{RENDER_DUMP_MATERIALS, offsetof(render_dump_material, texture), 1, "material 0: surface 1, not 1, or a texture"},
	{RENDER_DUMP_MATERIALS, 4 * 64 + offsetof(render_dump_material, surface), 5, "material 4: surface 5, not 5"},
	{RENDER_DUMP_MESHES, offsetof(render_dump_mesh, extras), 2, "mesh 0: 2 kinds of extras"},
	{RENDER_DUMP_MESHES, offsetof(render_dump_mesh, extras), 0, "header: 25 extras of vertices, but meshes have 0"},
	{RENDER_DUMP_EXTRAS, 4, 0x3f000000, "extra 0: a number"},
	{RENDER_DUMP_EXTRAS, 8, 0x7f800000, "extra 0: a number"},
	{RENDER_DUMP_EXTRAS, 24 + 16, 0x7c007c00, "extra 1: a number"},
	{RENDER_DUMP_SURFACES, 0, 0x7fc00000, "surface 0: a number is not finite"},
	{RENDER_DUMP_SURFACES, offsetof(render_maps_record, places), 0x7fc00000, "surface 0: a map's place is not finite"},
	{RENDER_DUMP_SURFACES, offsetof(render_dump_surface, bits), RENDER_MAPS_EXTRAS, "surface 0: its bits"},
	{RENDER_DUMP_SURFACES, offsetof(render_dump_surface, bits), RENDER_MAPS_COAT, "surface 0: its bits"},
	{RENDER_DUMP_SURFACES, offsetof(render_dump_surface, bits), 0, "surface 0: a map's texture"},
	{RENDER_DUMP_SURFACES, offsetof(render_dump_surface, textures), 9, "surface 0: a map's texture"},
	{RENDER_DUMP_SURFACES, offsetof(render_dump_surface, samplers), 18, "surface 0: a map's sampler"},
	{RENDER_DUMP_SURFACES, offsetof(render_dump_surface, samplers) + 12, 1u << 24, "surface 0: its unused"},
	{RENDER_DUMP_SURFACES, offsetof(render_dump_surface, also_unused), 1, "surface 0: its unused"},
	{RENDER_DUMP_SURFACES, offsetof(render_dump_surface, function), 1, "surface 0: its function is not there"},
	{RENDER_DUMP_SURFACES, offsetof(render_dump_surface, parameters) + 60, 0x7fc00000, "or a parameter is not finite"},
};

static void damaged_ones_are_refused(void **state)
{
	(void)state;
	size_t size;
	uint64_t begin[RENDER_DUMP_PARTS + 1];
	stage s = dump_stage(0);
	show_cells(&s);
	stage_frame(&s);
	dump_save(&s, PATH);
	stage_close(&s);
	uint8_t *bytes = file_bytes(PATH, &size);
	assert_true(render_dump_layout((const render_dump_header *)(const void *)bytes, begin) &&
	            begin[RENDER_DUMP_PARTS] == size);
	for (size_t d = 0; d < sizeof damages / sizeof *damages; d++) {
		stilb_render_dump *dump;
		uint8_t *changed = malloc(size);
		assert_non_null(changed);
		memcpy(changed, bytes, size);
		memcpy(changed + begin[damages[d].part] + damages[d].offset, &damages[d].value, sizeof(uint32_t));
		sign(changed, size);
		assert_int_equal(render_dump_read(changed, size, "x", &dump), STILB_ERROR_FILE);
		if (!strstr(stilb_error_message(), damages[d].reason))
			fail_msg("%s: %s", damages[d].reason, stilb_error_message());
	}
	free(bytes);
	remove(PATH);
}

/* Every byte of what surfaces add, changed: it is refused, or plays. */
static void changed_ones_are_refused_or_play(void **state)
{
	(void)state;
	static const render_dump_part parts[] = {RENDER_DUMP_SURFACES, RENDER_DUMP_EXTRAS};
	if (!null_device)
		return;
	size_t size;
	uint64_t begin[RENDER_DUMP_PARTS + 1];
	uint32_t refused = 0, played = 0;
	stage s = dump_stage(0);
	show_cells(&s);
	stage_frame(&s);
	dump_save(&s, PATH);
	stage_close(&s);
	uint8_t *bytes = file_bytes(PATH, &size);
	render_dump_layout((const render_dump_header *)(const void *)bytes, begin);
	for (int p = 0; p < 2; p++)
		for (uint64_t at = begin[parts[p]]; at < begin[parts[p] + 1]; at += 1 + TEST_ASAN * 3) {
			stilb_render_dump *dump;
			uint8_t *changed = malloc(size);
			assert_non_null(changed);
			memcpy(changed, bytes, size);
			changed[at] ^= (uint8_t)(1u << at % 8 | 0x10);
			sign(changed, size);
			if (render_dump_read(changed, size, "x", &dump) != STILB_OK) {
				refused++;
				continue;
			}
			played++;
			s = dump_stage(0);
			assert_int_equal(stilb_render_dump_upload(dump, s.render), STILB_OK);
			assert_int_equal(stilb_render_frame_begin(s.render), STILB_OK);
			assert_int_equal(stilb_render_dump_record(dump, s.render, s.pool, 0), STILB_OK);
			assert_int_equal(stilb_render_dump_replay(dump, s.render, s.pool, 0), STILB_OK);
			stilb_render_dump_destroy(dump);
			stage_close(&s);
		}
	assert_true(refused > 20 && played > 100);
	free(bytes);
	remove(PATH);
}

static int tear_down(void **state)
{
	(void)state;
	return folder_remove();
}

int main(int argc, char **argv)
{
	null_device = argc > 1 && strcmp(argv[1], "null") == 0;
	if (!null_device && reference_no_driver())
		return 77;
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_dump_is_the_frame),      cmocka_unit_test(levels_are_the_same_everywhere),
		cmocka_unit_test(pairs_have_their_extras),  cmocka_unit_test(draws_of_a_material_come_together),
		cmocka_unit_test(damaged_ones_are_refused), test_one_thread(changed_ones_are_refused_or_play),
	};
	return cmocka_run_group_tests(tests, folder_make, tear_down);
}
