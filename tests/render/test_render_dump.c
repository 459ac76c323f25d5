/* Frame dumps on the null device: a saved frame plays with the same stream, and a damaged file is refused with a reason
 * or plays. The linker sends allocations here (--wrap), to let them fail. */
#include "render/render_dump_format.h"
#include "render/render_internal.h"
#include "scene/scene_internal.h"
#include "support/test.h"

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define PATH "test_render_dump.dump"
#define PATH_AGAIN "test_render_dump_again.dump"

/* ---- memory that runs out ---------------------------------------------------------------------------------------- */

/* The number of further allocations that succeed. Relaxed: only the number matters. */
static _Atomic int64_t allocations_left = INT64_MAX;

void *__real_stilb_memory_alloc(size_t count, size_t size);
void *__wrap_stilb_memory_alloc(size_t count, size_t size);
void *__real_malloc(size_t size);
void *__wrap_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__real_realloc(void *memory, size_t size);
void *__wrap_realloc(void *memory, size_t size);

static bool granted(void)
{
	return atomic_fetch_sub_explicit(&allocations_left, 1, memory_order_relaxed) > 0;
}

static void allow(int64_t count)
{
	atomic_store_explicit(&allocations_left, count, memory_order_relaxed);
}

void *__wrap_stilb_memory_alloc(size_t count, size_t size)
{
	return granted() ? __real_stilb_memory_alloc(count, size) : NULL;
}

void *__wrap_malloc(size_t size)
{
	return granted() ? __real_malloc(size) : NULL;
}

void *__wrap_calloc(size_t count, size_t size)
{
	return granted() ? __real_calloc(count, size) : NULL;
}

void *__wrap_realloc(void *memory, size_t size)
{
	return granted() ? __real_realloc(memory, size) : NULL;
}

/* ---- a frame by hand --------------------------------------------------------------------------------------------- */

typedef struct frame {
	stilb_render *render;
	stilb_render_mesh meshes[4];
	stilb_render_texture textures[3];
	stilb_render_material materials[50];
} frame;

static const stilb_render_pass passes[2] = {
	{.name = "late", .view = 1, .order = 5},
	{.name = "early, by key", .view = 0, .order = 1, .sort = true},
};
static const uint32_t segment_counts[2] = {4, 3};

static stilb_job_pool *make_pool(uint32_t workers)
{
	stilb_job_pool_desc desc = {.worker_count = workers};
	stilb_job_pool *pool;
	assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
	return pool;
}

static stilb_render *make_render(uint32_t contexts, int replay, int materials, bool keep_textures)
{
	stilb_render_desc desc = {.device = STILB_RENDER_DEVICE_NULL,
	                          .replay = (stilb_render_replay_mode)replay,
	                          .materials = (stilb_render_materials)materials,
	                          .output = STILB_RENDER_OUTPUT_LINEAR,
	                          .width = 64,
	                          .height = 32,
	                          .samples = 4,
	                          .context_count = contexts,
	                          .keep_textures = keep_textures};
	stilb_render *render;
	assert_int_equal(stilb_render_create(&desc, &render), STILB_OK);
	return render;
}

static void make_texture(frame *f, uint32_t t, uint32_t channels, stilb_image_format format)
{
	stilb_image image;
	assert_int_equal(stilb_image_create(&image, 3, 1 + t, channels, format), STILB_OK);
	for (size_t i = 0; i < stilb_image_size(&image); i++)
		((uint8_t *)image.pixels)[i] = (uint8_t)(i + t);
	assert_int_equal(stilb_render_texture_create(f->render, &image, &f->textures[t]), STILB_OK);
	stilb_image_finish(&image);
}

/* All of a sphere is one cluster, and its first level another that can replace it. */
static void make_clusters(stilb_scene_mesh *mesh)
{
	const stilb_scene_level *level = &mesh->levels[0];
	assert_int_equal(scene_mesh_add_clusters(mesh, 2, 2, level->index_count), STILB_OK);
	memcpy(mesh->cluster_indices, mesh->level_indices + level->first_index,
	       level->index_count * sizeof *mesh->level_indices);
	mesh->clusters[0] =
		(stilb_scene_cluster){.radius = 1.0f, .index_count = mesh->index_count, .from = STILB_SCENE_NONE};
	mesh->clusters[1] = (stilb_scene_cluster){.radius = 1.0f, .index_count = mesh->cluster_index_count, .from = 0};
	mesh->groups[0] = (stilb_scene_cluster_group){.radius = 1.0f, .error = 0.5f, .cluster_count = 1};
	mesh->groups[1] =
		(stilb_scene_cluster_group){.radius = 1.0f, .error = INFINITY, .first_cluster = 1, .cluster_count = 1};
}

/* Ids of resources that no draw uses lie before and between those of resources that draws use. */
static void make_resources(frame *f)
{
	for (uint32_t m = 0; m < 4; m++) {
		stilb_scene_mesh mesh;
		assert_int_equal(m == 2 ? stilb_scene_mesh_sphere(1, &mesh) : stilb_scene_mesh_plane(&mesh), STILB_OK);
		if (m == 2)
			make_clusters(&mesh);
		assert_int_equal(stilb_render_mesh_create(f->render, &mesh, &f->meshes[m]), STILB_OK);
		stilb_scene_mesh_finish(&mesh);
	}
	make_texture(f, 0, 4, STILB_IMAGE_U8_SRGB);
	make_texture(f, 1, 1, STILB_IMAGE_U16_LINEAR);
	make_texture(f, 2, 3, STILB_IMAGE_F16_LINEAR);
	for (uint32_t m = 0; m < 50; m++) {
		stilb_scene_material material = {.diffuse = {0.5f, 0.25f, (float)m},
		                                 .specular = {0.1f, 0.2f, 0.3f},
		                                 .roughness = 0.5f,
		                                 .anisotropy = 0.25f,
		                                 .wrap = 0.75f,
		                                 .emission = {0.5f, 1.0f, (float)m}};
		stilb_render_texture texture = m % 5 == 0 ? f->textures[1 + m / 5 % 2] : (stilb_render_texture){0};
		assert_int_equal(stilb_render_material_create(f->render, &material, texture, &f->materials[m]), STILB_OK);
	}
	stilb_render_mesh_destroy(f->render, f->meshes[0]);
}

static void record_segment(frame *f, uint32_t pass, uint32_t segment)
{
	stilb_render_context *context = stilb_render_context_get(f->render, 0);
	stilb_render_segment_begin(context, pass, segment);
	for (uint32_t d = 0; d < (segment == 1 ? 0 : 7 + segment); d++) {
		stilb_mat4 transform = stilb_mat4_scale_translate(1.0f + (float)d, (float)segment, -2.0f, (float)pass);
		stilb_render_material material = f->materials[10 + (d * 11 + segment * 3 + pass) % 30];
		uint64_t key = (uint64_t)(d * 7 % 5) << 40;
		if (d % 4 == 3) /* some triangles of the sphere's own 80, then of the 20 behind them */
			render_draw_clusters(context, key, f->meshes[2], material, &transform,
			                     (render_cluster_range){d == 3 ? 30 : 240, d == 3 ? 60 : 54, 0}, 0, 0);
		else
			stilb_render_draw_with_key(context, key, f->meshes[1 + (d & 1)], material, &transform);
	}
	stilb_render_segment_end(context);
}

static const stilb_scene_light lights[3] = {
	{.kind = STILB_SCENE_LIGHT_SPOT,
     .position = {1, 2, 3},
     .direction = {0, -1, 0},
     .intensity = {4, 5, 6},
     .cos_inner = 0.9f,
     .cos_outer = 0.8f,
     .unit = STILB_SCENE_LIGHT_PHOTOMETRIC},
	{.kind = STILB_SCENE_LIGHT_RECTANGLE,
     .position = {1, 2, 3},
     .direction = {-1, 0, 0},
     .intensity = {7, 8, 9},
     .half_x = {0, 2, 0},
     .half_y = {0, 0, 3},
     .reach = 70.0f,
     .falloff = STILB_SCENE_LIGHT_SUBTRACTED},
	{.kind = STILB_SCENE_LIGHT_SPHERE,
     .position = {-1, -2, -3},
     .intensity = {10, 11, 12},
     .radius = 0.7f,
     .use = STILB_SCENE_LIGHT_LIVE},
};

static const stilb_render_target inset = {
	.name = "inset", .width = 30, .height = 20, .output = true, .place = {2, 3, 16, 8}, .border = 4};

static void fill_views(stilb_render_view views[2])
{
	for (int v = 0; v < 2; v++) {
		views[v] = (stilb_render_view){.view_projection = stilb_mat4_identity(), .camera_position = {1, 2, (float)v}};
		views[v].surroundings =
			(stilb_scene_surroundings){.sky = {0.1f, 0.2f, 0.3f}, .ground = {0.4f, 0.5f, 0.6f}, .glossy = v == 1};
		views[v].shading = (stilb_render_shading){7, 3, 4, 2, 0.1f, -0.2f, 0.3f, -0.4f};
		views[v].shading.brdf -= (uint32_t)v;
		views[v].lights = v ? &lights[2] : lights;
		views[v].light_count = v ? 1 : 2;
		views[v].both_sides = v == 0;
		views[v].ambient = v ? STILB_RENDER_AMBIENT_SH_PIXEL : STILB_RENDER_AMBIENT_HEMISPHERE;
		views[v].target = v ? NULL : &inset;
		views[v].light_fade = v ? 0.0f : 450.0f; /* the light that ends is seen as 700 pixels */
		views[v].light_tolerance = v ? 0.25f : 0.0f;
		views[v].light_peak = v ? 2.0f : 0.0f;
	}
}

static stilb_result save(stilb_render *render, const char *path)
{
	stilb_render_view views[2];
	fill_views(views);
	return stilb_render_dump_save(render, passes, 2, views, 2, path);
}

/* Draws the frame and saves it. */
static uint64_t dump_frame(frame *f, const char *path)
{
	stilb_render_view views[2];
	stilb_job_pool *pool = make_pool(0);
	fill_views(views);
	assert_int_equal(stilb_render_frame_begin(f->render), STILB_OK);
	for (uint32_t p = 0; p < 2; p++) {
		assert_int_equal(stilb_render_pass_begin(f->render, p, segment_counts[p]), STILB_OK);
		for (uint32_t s = segment_counts[p]; s-- > 0;)
			record_segment(f, p, s);
		assert_int_equal(stilb_render_pass_end(f->render, p), STILB_OK);
	}
	assert_int_equal(stilb_render_replay(f->render, passes, 2, views, 2, pool, 0), STILB_OK);
	assert_int_equal(save(f->render, path), STILB_OK);
	stilb_job_pool_destroy(pool);
	return stilb_render_stream_hash(f->render);
}

static uint64_t make_dump(const char *path)
{
	frame f = {.render = make_render(1, 0, 0, true)};
	make_resources(&f);
	uint64_t hash = dump_frame(&f, path);
	stilb_render_destroy(f.render);
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
	uint8_t *copy = malloc(size ? size : 1);
	assert_non_null(copy);
	memcpy(copy, bytes, size);
	return render_dump_read(copy, size, "a.dump", dump);
}

static void sign(uint8_t *bytes, size_t size)
{
	uint64_t checksum = stilb_hash_fnv1a64(STILB_FNV1A64_START, bytes, size - sizeof checksum);
	memcpy(bytes + size - sizeof checksum, &checksum, sizeof checksum);
}

static stilb_result play(stilb_render_dump *dump, stilb_render *render, stilb_job_pool *pool)
{
	stilb_result result = stilb_render_frame_begin(render);
	if (result == STILB_OK)
		result = stilb_render_dump_record(dump, render, pool, 0);
	return result == STILB_OK ? stilb_render_dump_replay(dump, render, pool, 0) : result;
}

/* ---- saving and playing ------------------------------------------------------------------------------------------ */

static void the_same_stream_comes_back(void **state)
{
	(void)state;
	static const uint32_t workers[] = {0, 1, 3};
	uint64_t hash = make_dump(PATH);
	size_t size, size_again;
	uint8_t *bytes = read_bytes(PATH, &size);
	for (int way = 0; way < 27; way++) {
		stilb_job_pool *pool = make_pool(workers[way % 3]);
		stilb_render *render = make_render(workers[way % 3] + 1, way / 3 % 3, way / 9, true);
		stilb_render_dump *dump;
		assert_int_equal(stilb_render_dump_load(PATH, &dump), STILB_OK);
		assert_int_equal(stilb_render_dump_upload(dump, render), STILB_OK);
		for (int f = 0; f < 3; f++) {
			assert_int_equal(play(dump, render, pool), STILB_OK);
			assert_true(stilb_render_stream_hash(render) == hash);
			assert_true(stilb_render_stats_get(render).draws == stilb_render_dump_info_get(dump).draws);
		}
		assert_int_equal(save(render, PATH_AGAIN), STILB_OK);
		uint8_t *again = read_bytes(PATH_AGAIN, &size_again);
		assert_int_equal(size_again, size);
		assert_memory_equal(again, bytes, size);
		free(again);
		stilb_render_dump_destroy(dump);
		stilb_render_destroy(render);
		stilb_job_pool_destroy(pool);
	}
	free(bytes);
}

/* Lights fade as in the picture that was saved, also in one that is eight times as high. */
static void lights_fade_as_they_did(void **state)
{
	(void)state;
	static const uint32_t heights[] = {32, 256, 8};
	frame f = {.render = make_render(1, 0, 0, true)};
	stilb_job_pool *pool = make_pool(0);
	stilb_render_dump *dump;
	stilb_render_view views[2];
	make_resources(&f);
	dump_frame(&f, PATH);
	fill_views(views);
	views[1].lights = lights;
	views[1].light_count = 2;
	views[1].light_fade = 800.0f; /* the light that ends is seen as 1,120 pixels */
	assert_int_equal(stilb_render_dump_save(f.render, passes, 2, views, 2, PATH), STILB_OK);
	stilb_render_destroy(f.render);
	assert_int_equal(stilb_render_dump_load(PATH, &dump), STILB_OK);
	for (int h = 0; h < 3; h++) {
		stilb_render *render = make_render(1, 0, 0, true);
		assert_int_equal(stilb_render_resize(render, 64, heights[h]), STILB_OK);
		assert_int_equal(stilb_render_dump_upload(dump, render), STILB_OK);
		assert_int_equal(play(dump, render, pool), STILB_OK);
		stilb_render_stats stats = stilb_render_stats_get(render);
		assert_int_equal(stats.light_faded, 2); /* and that of the inset */
		assert_int_equal(stats.light_gone, 0);
		stilb_render_destroy(render);
	}
	stilb_render_dump_destroy(dump);
	stilb_job_pool_destroy(pool);
}

static void only_what_is_used_is_in_it(void **state)
{
	(void)state;
	stilb_render_dump *dump;
	uint64_t hash = make_dump(PATH);
	assert_int_equal(stilb_render_dump_load(PATH, &dump), STILB_OK);
	stilb_render_dump_info info = stilb_render_dump_info_get(dump);
	assert_true(info.stream_hash == hash);
	assert_int_equal(info.passes, 2);
	assert_int_equal(info.draws, 7 + 9 + 10 + 7 + 9);
	assert_int_equal(info.meshes, 2);
	assert_in_range(info.materials, 10, 30);
	assert_int_equal(info.textures, 2); /* draws use two of three textures */
	assert_int_equal(info.width, 64);
	assert_int_equal(info.height, 32);
	assert_int_equal(info.samples, 4);
	assert_int_equal(info.output, STILB_RENDER_OUTPUT_LINEAR);
	assert_int_equal(dump->meshes[0].id, 1);
	assert_int_equal(dump->meshes[1].id, 2);
	assert_in_range(dump->materials[0].id, 10, 39);
	assert_string_equal(dump->passes[1].name, "early, by key");
	stilb_render_dump_destroy(dump);
}

#define SCENE_MODELS 20u

/* Draws a scene, in one pass together with a mesh by hand unless that is {0}, and saves the frame. */
static stilb_result dump_scene(stilb_render *render, const stilb_scene *scene, frame *by_hand, stilb_job_pool *pool,
                               const char *path)
{
	stilb_render_view views[2];
	uint32_t ids[SCENE_MODELS];
	stilb_mat4 place = stilb_mat4_identity();
	fill_views(views);
	for (uint32_t i = 0; i < SCENE_MODELS; i++)
		ids[i] = i;
	assert_int_equal(stilb_render_set_scene(render, scene), STILB_OK);
	assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
	assert_int_equal(stilb_render_record(render, 0, scene, ids, SCENE_MODELS, pool, 0), STILB_OK);
	assert_int_equal(stilb_render_pass_begin(render, 1, 1), STILB_OK);
	stilb_render_context *context = stilb_render_context_get(render, 0);
	stilb_render_segment_begin(context, 1, 0);
	if (by_hand)
		stilb_render_draw(context, by_hand->meshes[0], by_hand->materials[0], &place);
	stilb_render_segment_end(context);
	assert_int_equal(stilb_render_pass_end(render, 1), STILB_OK);
	assert_int_equal(stilb_render_replay(render, passes, 2, views, 2, pool, 0), STILB_OK);
	return save(render, path);
}

/* A scene's frame is the same file whatever was shown before. */
static void a_scene_keeps_its_ids(void **state)
{
	(void)state;
	stilb_scene *scenes[2];
	stilb_scene_mesh plane;
	stilb_job_pool *pool = make_pool(0);
	stilb_render *old = make_render(1, 0, 0, false), *new = make_render(1, 0, 0, false);
	size_t size, size_again;
	for (int i = 0; i < 2; i++)
		assert_int_equal(stilb_scene_create_stress(SCENE_MODELS, (uint64_t)i, &scenes[i]), STILB_OK);
	frame by_hand = {.render = old};
	assert_int_equal(stilb_scene_mesh_plane(&plane), STILB_OK);
	assert_int_equal(stilb_render_mesh_create(old, &plane, &by_hand.meshes[0]), STILB_OK);
	assert_int_equal(
		stilb_render_material_create(old, &scenes[0]->materials[0], (stilb_render_texture){0}, &by_hand.materials[0]),
		STILB_OK);
	for (int i = 0; i < 5; i++)
		assert_int_equal(dump_scene(old, scenes[i % 2], NULL, pool, PATH), STILB_OK);
	assert_int_equal(dump_scene(old, scenes[1], NULL, pool, PATH), STILB_OK);
	assert_int_equal(dump_scene(new, scenes[1], NULL, pool, PATH_AGAIN), STILB_OK);
	assert_true(stilb_render_stream_hash(old) == stilb_render_stream_hash(new));
	uint8_t *bytes = read_bytes(PATH, &size), *again = read_bytes(PATH_AGAIN, &size_again);
	assert_int_equal(size, size_again);
	assert_memory_equal(bytes, again, size);
	assert_int_equal(dump_scene(old, scenes[1], &by_hand, pool, PATH), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "by hand, others with the same ids"));
	free(bytes);
	free(again);
	stilb_scene_mesh_finish(&plane);
	stilb_render_destroy(old);
	stilb_render_destroy(new);
	stilb_scene_destroy(scenes[0]);
	stilb_scene_destroy(scenes[1]);
	stilb_job_pool_destroy(pool);
}

static void what_cannot_be_dumped(void **state)
{
	(void)state;
	frame f = {.render = make_render(1, 0, 0, false)};
	remove(PATH);
	assert_int_equal(save(f.render, PATH), STILB_ERROR_ARGUMENT);
	make_resources(&f);
	stilb_job_pool *pool = make_pool(0);
	stilb_render_view views[2];
	fill_views(views);
	assert_int_equal(stilb_render_frame_begin(f.render), STILB_OK);
	for (uint32_t p = 0; p < 2; p++) {
		assert_int_equal(stilb_render_pass_begin(f.render, p, 1), STILB_OK);
		record_segment(&f, p, 0);
		assert_int_equal(stilb_render_pass_end(f.render, p), STILB_OK);
	}
	assert_int_equal(stilb_render_replay(f.render, passes, 2, views, 2, pool, 0), STILB_OK);
	assert_int_equal(save(f.render, PATH), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "keep_textures"));
	assert_int_not_equal(access(PATH, F_OK), 0);
	stilb_job_pool_destroy(pool);
	stilb_render_destroy(f.render);
}

/* ---- damaged files ----------------------------------------------------------------------------------------------- */

static void assert_refused(const uint8_t *bytes, size_t size, const char *reason)
{
	stilb_render_dump *dump;
	stilb_result result = read_copy(bytes, size, &dump);
	if (result != STILB_ERROR_FILE || !strstr(stilb_error_message(), reason))
		print_error("%d '%s' has no '%s'\n", (int)result, stilb_error_message(), reason);
	assert_int_equal(result, STILB_ERROR_FILE);
	assert_null(dump);
	assert_non_null(strstr(stilb_error_message(), "'a.dump'"));
	assert_non_null(strstr(stilb_error_message(), reason));
}

static void every_change_is_noticed(void **state)
{
	(void)state;
	size_t size;
	make_dump(PATH);
	uint8_t *bytes = read_bytes(PATH, &size);
	for (size_t i = 0; i < size; i++) {
		assert_refused(bytes, i, "");
		for (int bit = 0; bit<8; bit += size> 10000 ? 3 : 1) {
			bytes[i] ^= (uint8_t)(1 << bit);
			assert_refused(bytes, size, "");
			bytes[i] ^= (uint8_t)(1 << bit);
		}
	}
	stilb_render_dump *dump;
	assert_int_equal(read_copy(bytes, size, &dump), STILB_OK); /* the undamaged file */
	stilb_render_dump_destroy(dump);
	free(bytes);
}

/* True if all ids are small. A dump with large ones is not played, which would only cost time and memory: every id
 * below them gets an empty resource. */
static bool ids_are_small(const stilb_render_dump *dump)
{
	const render_dump_header *header = dump->header;
	return (header->materials == 0 || dump->materials[header->materials - 1].id < 1000) &&
	       (header->meshes == 0 || dump->meshes[header->meshes - 1].id < 1000);
}

/* Every so many of the first bytes that leave a valid file are played when they have changed: making a renderer takes
 * most of the time, and fuzz_render_dump plays many more with the address sanitizer. */
#define PLAY_STEP (TEST_ASAN ? 7 : 1)

/* Random bytes are changed and the checksum is corrected: the file is refused, or it plays. */
static void every_signed_change_is_refused_or_plays(void **state)
{
	(void)state;
	size_t size, played = 0;
	make_dump(PATH);
	uint8_t *bytes = read_bytes(PATH, &size);
	stilb_job_pool *pool = make_pool(0);
	for (size_t i = 0; i < size - 8; i++) {
		static const uint8_t changes[] = {0x01, 0x80, 0xff};
		for (size_t c = 0; c < sizeof changes; c++) {
			if (TEST_ASAN && i % 3 != c)
				continue; /* each byte in one of the three ways there, in all of them here */
			stilb_render_dump *dump;
			bytes[i] ^= changes[c];
			sign(bytes, size);
			if (read_copy(bytes, size, &dump) != STILB_OK) {
				assert_non_null(strstr(stilb_error_message(), "'a.dump': "));
			} else if (ids_are_small(dump) && i % (i < 3000 ? PLAY_STEP : 16) == 0) {
				stilb_render *render = make_render(1, (int)c, (int)(i % 3), false);
				assert_int_equal(stilb_render_dump_upload(dump, render), STILB_OK);
				assert_int_equal(play(dump, render, pool), STILB_OK);
				stilb_render_destroy(render);
				played++;
			}
			stilb_render_dump_destroy(dump);
			bytes[i] ^= changes[c];
		}
	}
	assert_true(played > 100); /* many changes, as of a colour or a transform, leave a valid file */
	stilb_job_pool_destroy(pool);
	free(bytes);
}

#define HEADER(field) offsetof(render_dump_header, field)
#define VIEW(field) offsetof(render_dump_view, field)
#define TARGET(field) offsetof(render_dump_target, field)

/* Offset from the beginning of a part, the 32 bits to write there, and a part of the message to expect. */
static const struct damage {
	render_dump_part part;
	size_t offset;
	uint32_t value;
	const char *reason;
} damages[] = {
	{RENDER_DUMP_HEADER, HEADER(magic), 0x54495453, "not a frame dump"},
	{RENDER_DUMP_HEADER, HEADER(version), 1, "version 1, but this program reads version 15"},
	{RENDER_DUMP_HEADER, HEADER(byte_order), 0x04030201, "byte order"},
	{RENDER_DUMP_HEADER, HEADER(file_size), 100000000, "truncated"},
	{RENDER_DUMP_HEADER, HEADER(file_size), 200, "continues after its last byte, 200"},
	{RENDER_DUMP_HEADER, HEADER(draws), 1000, "do not add up"},
	{RENDER_DUMP_HEADER, HEADER(draws) + 4, 0x80000000, "do not add up"},
	{RENDER_DUMP_HEADER, HEADER(vertices) + 4, 0x08000000, "do not add up"}, /* 2^59 vertices of 32 bytes: 2^64 */
	{RENDER_DUMP_HEADER, HEADER(pixel_bytes) + 4, UINT32_MAX, "do not add up"},
	{RENDER_DUMP_HEADER, HEADER(meshes), UINT32_MAX, "do not add up"},
	{RENDER_DUMP_HEADER, HEADER(width), 0, "header: a picture of 0x32"},
	{RENDER_DUMP_HEADER, HEADER(height), 16385, "header: a picture of 64x16385"},
	{RENDER_DUMP_HEADER, HEADER(samples), 2, "header: 2 samples"},
	{RENDER_DUMP_HEADER, HEADER(output), 2, "header: unknown output 2"},
	{RENDER_DUMP_VIEWS, sizeof(render_dump_view) + 16, 0x7f800000, "view 1: a number is not finite"},
	{RENDER_DUMP_VIEWS, VIEW(specular), 0xff800000, "view 0: a number is not finite"},
	{RENDER_DUMP_VIEWS, VIEW(brdf), 8, "view 0: unknown shading: model 8, D 3, G 4, F 2, glossy 0"},
	{RENDER_DUMP_VIEWS, VIEW(ndf), 4, "D 4,"},
	{RENDER_DUMP_VIEWS, VIEW(g), 8, "G 8,"},
	{RENDER_DUMP_VIEWS, VIEW(f), UINT32_MAX, "F 4294967295,"},
	{RENDER_DUMP_VIEWS, sizeof(render_dump_view) + VIEW(glossy), 2,
     "view 1: unknown shading: model 6, D 3, G 4, F 2, glossy 2, both sides 0"},
	{RENDER_DUMP_VIEWS, sizeof(render_dump_view) + VIEW(both_sides), 3, "glossy 1, both sides 3"},
	{RENDER_DUMP_VIEWS, VIEW(lights), 1, "header: 3 lights, but views have 2"},
	{RENDER_DUMP_HEADER, HEADER(lights), 4, "do not add up"},
	{RENDER_DUMP_HEADER, HEADER(backdrop_bytes), 8, "do not add up"},
	{RENDER_DUMP_HEADER, HEADER(backdrop_bytes), UINT32_MAX, "do not add up"},
	{RENDER_DUMP_HEADER, HEADER(levels), 3, "do not add up"},
	{RENDER_DUMP_HEADER, HEADER(streams), 1, "header: its vertices have other streams"},
	{RENDER_DUMP_VIEWS, VIEW(exposure), 0x43000000, "view 0: its exposure is not within 100 stops"},
	{RENDER_DUMP_VIEWS, VIEW(tone), 7, "view 0: unknown tone map 7, dither 0"},
	{RENDER_DUMP_VIEWS, VIEW(dither), 3, "view 0: unknown tone map 0, dither 3"},
	{RENDER_DUMP_VIEWS, VIEW(target), 2, "view 0: target 2, but there are 1"},
	{RENDER_DUMP_VIEWS, VIEW(exposure), 0x7fc00000, "view 0: its exposure is not within 100 stops"},
	{RENDER_DUMP_VIEWS, VIEW(time), 0x7fc00000, "view 0: its time is not finite"},
	{RENDER_DUMP_VIEWS, VIEW(lighting), STILB_RENDER_LIGHTING_WAYS,
     "view 0: its time is not finite, or way 11 of lighting unknown"},
	{RENDER_DUMP_VIEWS, VIEW(lighting), STILB_RENDER_COVERAGE_WAYS << 8, "view 0: its time is not finite, or way 1024"},
	{RENDER_DUMP_VIEWS, VIEW(light_tolerance), 0xbf800000u, "view 0: tolerance -1 of light"},
	{RENDER_DUMP_VIEWS, VIEW(light_tolerance), 0x3f000000u, "view 0: tolerance 0.5 of light, peak 0"},
	{RENDER_DUMP_VIEWS, VIEW(light_peak), 0x7fc00000u, "view 0: tolerance 0 of light, peak nan"},
	{RENDER_DUMP_VIEWS, VIEW(light_fade), 0xbf800000u, "view 0: its lights fade at -1 of 20 pixels of height"},
	{RENDER_DUMP_VIEWS, VIEW(light_fade_height), 0, "view 0: its lights fade at 450 of 0 pixels of height"},
	{RENDER_DUMP_VIEWS, VIEW(light_fade_height), 16385, "view 0: its lights fade at 450 of 16385 pixels of height"},
	{RENDER_DUMP_VIEWS, VIEW(lighting), STILB_RENDER_GBUFFER_KINDS << 16,
     "view 0: its time is not finite, or way 131072"},
	{RENDER_DUMP_VIEWS, VIEW(lighting), (uint32_t)STILB_RENDER_AMBIENT_KINDS << 24,
     "view 0: its time is not finite, or way 100663296"},
	{RENDER_DUMP_LIGHTS, 96, 6, "light 1: its kind is unknown"},
	{RENDER_DUMP_LIGHTS, offsetof(render_dump_light, unused), 1, "light 0: its unused bytes are not zero"},
	{RENDER_DUMP_LIGHTS, 96 + offsetof(render_dump_light, half_x), 0x40000000, "light 1: its sides and its direction"},
	{RENDER_DUMP_LIGHTS, 2 * 96 + 92, 0x7fc00000, "light 2: a number is not finite"},
	{RENDER_DUMP_PASSES, 0, 0x41410a41, "pass 0: its name"},
	{RENDER_DUMP_PASSES, 60, 0x41414141, "pass 0: its name"},
	{RENDER_DUMP_PASSES, offsetof(render_dump_pass, view), 2, "pass 0: view 2, but there are 2"},
	{RENDER_DUMP_PASSES, 88 + offsetof(render_dump_pass, sort), 2, "pass 1: unknown sort 2"},
	{RENDER_DUMP_HEADER, HEADER(targets), 2, "do not add up"},
	{RENDER_DUMP_HEADER, HEADER(functions), 2, "do not add up"},
	{RENDER_DUMP_HEADER, HEADER(function_bytes), 8, "do not add up"},
	{RENDER_DUMP_TARGETS, 0, 0, "target 0: its name"},
	{RENDER_DUMP_TARGETS, 52, 1, "target 0: its name"},
	{RENDER_DUMP_TARGETS, TARGET(kind), 2, "target 0: unknown kind 2"},
	{RENDER_DUMP_TARGETS, TARGET(kind), 1, "target 0: unknown kind 1, output 1, or a place"}, /* depth has none */
	{RENDER_DUMP_TARGETS, TARGET(border), 256, "target 0: a border of 256 pixels"},
	{RENDER_DUMP_TARGETS, TARGET(unused), 3, "target 0: a border of 4 pixels, unused bytes 3"},
	{RENDER_DUMP_TARGETS, TARGET(width), 16385, "target 0: 16385x20 pixels"},
	{RENDER_DUMP_TARGETS, TARGET(height), 0, "target 0: 30x0 pixels"},
	{RENDER_DUMP_TARGETS, TARGET(output), 2, "target 0: unknown kind 0, output 2"},
	{RENDER_DUMP_TARGETS, TARGET(place), 3 << 16 | 49, "or a place outside the picture: 16x8 at 49, 3"},
	{RENDER_DUMP_TARGETS, TARGET(place), 25 << 16 | 2, "or a place outside the picture: 16x8 at 2, 25"},
	{RENDER_DUMP_TARGETS, TARGET(place) + 4, 8 << 16, "or a place outside the picture: 0x8 at 2, 3"},
	{RENDER_DUMP_PASSES, offsetof(render_dump_pass, segments), 8, "pass 0: its 8 segments go beyond all 7"},
	{RENDER_DUMP_PASSES, 88 + offsetof(render_dump_pass, segments), 2, "pass 1: 16 draws, but its segments have 7"},
	{RENDER_DUMP_PASSES, offsetof(render_dump_pass, draws), 9, "pass 0: 9 draws, but its segments have 26"},
	{RENDER_DUMP_SEGMENTS, 0, 8, "pass 0: 26 draws, but its segments have 27"},
	{RENDER_DUMP_SEGMENTS, 28, 1, "behind the segments"},
	{RENDER_DUMP_TEXTURES, 0, 0, "texture 0: id 0, not in 1..1048575"},
	{RENDER_DUMP_TEXTURES, 24, 2, "texture 1: id 2, not in 3..1048575"},
	{RENDER_DUMP_TEXTURES, 4, 16385, "texture 0: 16385x2 pixels"},
	{RENDER_DUMP_TEXTURES, 12, 3, "of format 3; a side has 1..16384, and formats are 0 to 13 without 3"},
	{RENDER_DUMP_TEXTURES, 12, 6, "bytes of pixels, but textures have"},
	{RENDER_DUMP_TEXTURES, 12, 14, "of format 14"},
	{RENDER_DUMP_TEXTURES, 4, 16384, "texture 0: its pixels go beyond"},
	{RENDER_DUMP_TEXTURES, 16, 0, "texture 0: 0 mip levels"},
	{RENDER_DUMP_TEXTURES, 16, 3, "texture 0: 3 mip levels (and 0); 3x2 pixels have 1 to 2"},
	{RENDER_DUMP_TEXTURES, 20, 1, "1 mip levels (and 1)"},
	{RENDER_DUMP_TEXTURES, 28, 1, "bytes of pixels, but textures have"},
	{RENDER_DUMP_MATERIALS, 64, 0, "material 1: id 0, not in "},
	{RENDER_DUMP_MATERIALS, 0, 1 << 24, "material 0: id 16777216, not in 0..16777215"},
	{RENDER_DUMP_MATERIALS, 4, 3, "material 0: texture 3, but there are 2"},
	{RENDER_DUMP_MATERIALS, 8, 0x7fc00000, "material 0: a number is not finite"},
	{RENDER_DUMP_MATERIALS, 40, 0xff800000, "material 0: a number is not finite"},
	{RENDER_DUMP_MATERIALS, 52, 0x7fc00000, "material 0: a number is not finite"},
	{RENDER_DUMP_MATERIALS, 56, 5, "material 0: it is of an impostor (5)"},
	{RENDER_DUMP_MATERIALS, 60, 5, "material 0: surface 5, not 1"},
	{RENDER_DUMP_MESHES, 24, 1, "mesh 1: id 1, not in 2.."},
	{RENDER_DUMP_MESHES, 4, 0, "mesh 0: 0 vertices"},
	{RENDER_DUMP_MESHES, 8, 0, "0 indices"},
	{RENDER_DUMP_MESHES, 4, UINT32_MAX, "mesh 0: its 4294967295 vertices"},
	{RENDER_DUMP_MESHES, 8, 0x7fffffff, "mesh 0: its 2147483647 indices of level 0 go beyond"},
	{RENDER_DUMP_MESHES, 12, 1, "mesh 0: level 1 has "},
	{RENDER_DUMP_MESHES, 12, 0x80000000, "mesh 0: "},
	{RENDER_DUMP_MESHES, 28, 43, "mesh 1: its 43 vertices"},
	{RENDER_DUMP_MESHES, 32, 3, "mesh 1: index 0 of level 1 is vertex"},
	{RENDER_DUMP_MESHES, 12, 0xc0000001, "mesh 0: 1 levels that morph and clusters"}, /* no mesh morphs from clusters */
	{RENDER_DUMP_MESHES, 16, 3, "mesh 0: 3 indices of clusters that it does not have"},
	{RENDER_DUMP_MESHES, 20, 7, "mesh 0: 7 kinds of extras"},
	{RENDER_DUMP_DRAWS, 8, 63 << 20, "draw 0: 0 indices from 0 on of the clusters of mesh 0"},
	{RENDER_DUMP_DRAWS, 64, 3, "draw 0: 0 indices from 3 on of the clusters of mesh 0"},
	{RENDER_DUMP_DRAWS, 72 + 68, 3, "draw 1: 3 indices from 0 on of the clusters of mesh 1"},
	{RENDER_DUMP_DRAWS, 72 + 8, 2, "draw 1: mesh 2 and material"},
	{RENDER_DUMP_DRAWS, 12, UINT32_MAX, "draw 0: mesh 0 and material 16777215"},
	{RENDER_DUMP_DRAWS, 8, 1 << 20, "draw 0: mesh 0 cannot be drawn in level 1"},
	{RENDER_DUMP_DRAWS, 8, 1 << 26, "cannot be drawn in level 0 with detail 1 of kind 0"},
	{RENDER_DUMP_DRAWS, 12, 4 << 24, "with detail 0 of kind 4"},
	{RENDER_DUMP_DRAWS, 12, 1 << 24, "with detail 0 of kind 1"},
	{RENDER_DUMP_DRAWS, 2 * 72 + 60, 0x7f800001, "draw 2: its transform"},
	{RENDER_DUMP_VERTICES, 4, 0x7f800000, "mesh 0: a vertex is not finite"},
	{RENDER_DUMP_INDICES, 8, 4, "mesh 0: index 2 of level 0 is vertex 4, but it has 4"},
};

static void the_message_names_the_place(void **state)
{
	(void)state;
	size_t size;
	uint64_t begin[RENDER_DUMP_PARTS + 1];
	make_dump(PATH);
	uint8_t *bytes = read_bytes(PATH, &size), *changed = malloc(size);
	render_dump_header header;
	memcpy(&header, bytes, sizeof header);
	assert_true(render_dump_layout(&header, begin) && begin[RENDER_DUMP_PARTS] == size);
	for (size_t d = 0; d < sizeof damages / sizeof *damages; d++) {
		memcpy(changed, bytes, size);
		memcpy(changed + begin[damages[d].part] + damages[d].offset, &damages[d].value, sizeof(uint32_t));
		sign(changed, size);
		assert_refused(changed, size, damages[d].reason);
	}
	memcpy(changed, bytes, size);
	changed[size - 1] ^= 1;
	assert_refused(changed, size, "checksum");
	assert_refused(changed, 0, "empty");
	assert_refused(changed, 5, "ends in the header");
	free(changed);
	free(bytes);
}

/* ---- unreadable files -------------------------------------------------------------------------------------------- */

static void write_bytes(const char *path, const void *bytes, size_t size)
{
	FILE *file = fopen(path, "wb");
	assert_non_null(file);
	assert_int_equal(fwrite(bytes, 1, size, file), size);
	assert_int_equal(fclose(file), 0);
}

static void assert_load_fails(const char *path, const char *reason)
{
	stilb_render_dump *dump;
	assert_int_equal(stilb_render_dump_load(path, &dump), STILB_ERROR_FILE);
	assert_null(dump);
	assert_non_null(strstr(stilb_error_message(), path));
	if (!strstr(stilb_error_message(), reason))
		print_error("%s\n", stilb_error_message());
	assert_non_null(strstr(stilb_error_message(), reason));
}

static void files_that_cannot_be_read(void **state)
{
	(void)state;
	static const char text[] =
		"a text that is no dump, but is longer than the header of one, so that all of it has to be "
		"looked at before it can be refused, which it is";
	size_t size;
	assert_load_fails("missing.dump", "No such file");
	assert_load_fails(".", "directory");
	assert_load_fails("/dev/null", "empty");
	assert_load_fails("/dev/zero", "not a frame dump"); /* an endless file is not read to the end */
	write_bytes(PATH_AGAIN, text, sizeof text);
	assert_load_fails(PATH_AGAIN, "not a frame dump");
	make_dump(PATH);
	uint8_t *bytes = read_bytes(PATH, &size);
	write_bytes(PATH_AGAIN, bytes, size - 1);
	assert_load_fails(PATH_AGAIN, "truncated");
	bytes = realloc(bytes, size + 100000);
	assert_non_null(bytes);
	memset(bytes + size, 0, 100000);
	write_bytes(PATH_AGAIN, bytes, size + 100000);
	assert_load_fails(PATH_AGAIN, "continues after its last byte");
	free(bytes);
}

static void without_memory(void **state)
{
	(void)state;
	make_dump(PATH);
	stilb_job_pool *pool = make_pool(0);
	uint32_t failures = 0;
	stilb_result result = STILB_ERROR_MEMORY;
	for (int64_t count = 0; result != STILB_OK; count++) {
		stilb_render *render = make_render(1, (int)(count % 3), (int)(count % 2), true);
		stilb_render_dump *dump;
		stilb_render_dump_costs costs;
		allow(count);
		result = stilb_render_dump_load(PATH, &dump);
		if (result == STILB_OK)
			result = stilb_render_dump_upload(dump, render);
		if (result == STILB_OK)
			result = play(dump, render, pool);
		if (result == STILB_OK)
			result = save(render, PATH_AGAIN);
		if (result == STILB_OK)
			result = stilb_render_dump_measure(dump, render, pool, 0, 0.0, &costs);
		allow(INT64_MAX);
		assert_true(result == STILB_OK || result == STILB_ERROR_MEMORY || result == STILB_ERROR_FILE);
		failures += result != STILB_OK;
		stilb_render_dump_destroy(dump);
		stilb_render_destroy(render);
		assert_true(count < 10000);
	}
	assert_true(failures > 20);
	stilb_job_pool_destroy(pool);
}

/* ---- costs ------------------------------------------------------------------------------------------------------- */

static const stilb_render_dump_cost *cost_of(const stilb_render_dump_costs *costs, const char *kind)
{
	for (int k = 0; k < STILB_RENDER_DUMP_COSTS; k++)
		if (strcmp(costs->kinds[k].kind, kind) == 0)
			return &costs->kinds[k];
	return NULL;
}

/* Checks how many commands of a kind there are, and low <= median <= high. The times themselves are not tested. */
static void assert_cost(const stilb_render_dump_costs *costs, const char *kind, uint64_t count, bool known)
{
	const stilb_render_dump_cost *cost = cost_of(costs, kind);
	if (!cost)
		print_error("no kind '%s'\n", kind);
	assert_non_null(cost);
	assert_int_equal(cost->count, count);
	assert_int_equal(cost->known, known);
	assert_true(isfinite(cost->ns) && cost->low <= cost->ns && cost->ns <= cost->high);
}

static uint32_t ordered[2]; /* how often the measurement has ordered each pass */

stilb_result __real_render_order(stilb_render *render, const stilb_render_pass *pass, render_pass_lists *lists);
stilb_result __wrap_render_order(stilb_render *render, const stilb_render_pass *pass, render_pass_lists *lists);
stilb_result __wrap_render_order(stilb_render *render, const stilb_render_pass *pass, render_pass_lists *lists)
{
	ordered[lists - render->passes]++;
	return __real_render_order(render, pass, lists);
}

static void each_kind_has_its_cost(void **state)
{
	(void)state;
	make_dump(PATH);
	stilb_job_pool *pool = make_pool(2);
	for (int way = 0; way < 9; way++) {
		int replay = way % 3, materials = way / 3;
		bool indirect = replay == STILB_RENDER_REPLAY_INDIRECT, secondary = replay == STILB_RENDER_REPLAY_SECONDARY;
		stilb_render *render = make_render(3, replay, materials, false);
		stilb_render_dump *dump;
		stilb_render_dump_costs costs;
		assert_int_equal(stilb_render_dump_load(PATH, &dump), STILB_OK);
		assert_int_equal(stilb_render_dump_upload(dump, render), STILB_OK);
		memset(ordered, 0, sizeof ordered);
		assert_int_equal(stilb_render_dump_measure(dump, render, pool, 0, 0.001, &costs), STILB_OK);
		assert_true(ordered[0] >= costs.rounds && ordered[1] == ordered[0]); /* each pass once in a frame */
		assert_true(costs.rounds >= STILB_RENDER_DUMP_MIN_ROUNDS && costs.frame_ns > 0.0);
		assert_cost(&costs, "record a draw", 42, true);
		assert_cost(&costs, "order a draw", 42, true);
		assert_cost(&costs, secondary ? "execute" : "begin a pass", secondary ? 6 : 2, true);
		assert_cost(&costs, "draw", indirect ? 0 : 42, !indirect);
		const stilb_render_dump_cost *material = cost_of(&costs, "bind a material");
		const stilb_render_dump_cost *pipeline = cost_of(&costs, "bind a pipeline");
		/* Draws with and without a texture alternate, and each change needs another pipeline. */
		assert_true(materials == STILB_RENDER_MATERIALS_PIPELINE ? pipeline->count > 25 : pipeline->count < 25);
		assert_true(materials == STILB_RENDER_MATERIALS_BIND ? material->count > 25 : material->count < 25);
		assert_true(material->count > 0 && pipeline->count > 0);
		assert_int_equal(material->known, material->count >= 20);
		assert_int_equal(cost_of(&costs, "draw indirect")->known, indirect);
		assert_int_equal(cost_of(&costs, "draw indirect")->count > 0, indirect);
		assert_cost(&costs, "submit", 1, true);
		stilb_render_dump_destroy(dump);
		stilb_render_destroy(render);
	}
	stilb_job_pool_destroy(pool);
}

static int remove_files(void **state)
{
	(void)state;
	remove(PATH);
	remove(PATH_AGAIN);
	return 0;
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(the_same_stream_comes_back),
		cmocka_unit_test(lights_fade_as_they_did),
		cmocka_unit_test(only_what_is_used_is_in_it),
		cmocka_unit_test(a_scene_keeps_its_ids),
		cmocka_unit_test(what_cannot_be_dumped),
		test_one_thread(every_change_is_noticed),
		test_one_thread(every_signed_change_is_refused_or_plays),
		cmocka_unit_test(the_message_names_the_place),
		cmocka_unit_test(files_that_cannot_be_read),
		test_one_thread(without_memory),
		cmocka_unit_test(each_kind_has_its_cost),
	};
	return cmocka_run_group_tests(tests, NULL, remove_files);
}
