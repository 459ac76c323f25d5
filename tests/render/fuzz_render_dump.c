/* Fuzzes the reading of frame dumps, files that hold all commands of a frame (render_dump.h). Whatever the bytes,
 * render_dump_read never crashes and returns a dump or a reason; a dump plays on the null device and can be saved. The
 * mutator knows the parts of a file, adapts the header's counts to them, and in most cases writes the right checksum,
 * without which every mutant would be refused at once. */
#include "render/render_dump_format.h"
#include "render/render_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerInitialize(int *argc, char ***argv);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed);
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max_size);

static stilb_job_pool *pool;

static void require(bool condition)
{
	if (!condition)
		abort();
}

static stilb_render *make_render(uint32_t way)
{
	stilb_render_desc desc = {.device = STILB_RENDER_DEVICE_NULL,
	                          .replay = (stilb_render_replay_mode)(way % 3),
	                          .materials = (stilb_render_materials)(way / 3 % 3),
	                          .width = 8,
	                          .height = 8,
	                          .context_count = 1,
	                          .keep_textures = true};
	stilb_render *render;
	require(stilb_render_create(&desc, &render) == STILB_OK);
	return render;
}

/* ---- seeds ------------------------------------------------------------------------------------------------------- */

static stilb_render_material seed_material(stilb_render *render, bool textured)
{
	static uint8_t pixels[3 * 1 * 4] = {1, 2, 3, 4, 5, 6, 7, 8, 9};
	stilb_image image = {3, 1, 4, STILB_IMAGE_U8_SRGB, pixels, 0};
	stilb_scene_material material = {.diffuse = {0.5f, 0.5f, 0.5f},
	                                 .specular = {0.1f, 0.1f, 0.1f},
	                                 .roughness = 0.6f,
	                                 .anisotropy = 0.1f,
	                                 .wrap = 0.2f};
	stilb_render_texture texture = {0};
	stilb_render_material out;
	require(!textured || stilb_render_texture_create(render, &image, &texture) == STILB_OK);
	require(stilb_render_material_create(render, &material, texture, &out) == STILB_OK);
	return out;
}

/* One to three passes; those with odd numbers are sorted. */
static void make_seed(const char *path, uint32_t pass_count)
{
	static const stilb_render_pass passes[3] = {
		{.name = "main"}, {.name = "sorted", .view = 1, .sort = true, .order = 3}, {.name = "last", .order = 2}};
	static float texels[4 * 2 * 3] = {1.0f, 0.5f, 0.25f},
								map[3 * STILB_SCENE_BACKDROP_WIDTH * STILB_SCENE_BACKDROP_HEIGHT];
	stilb_render_view views[2] = {{.view_projection = stilb_mat4_identity()}};
	if (pass_count == 2) /* one seed of three has a panorama, and a background */
		views[0].surroundings.panorama = (stilb_image){4, 2, 3, STILB_IMAGE_F32_LINEAR, texels, 0};
	if (pass_count == 2)
		views[1].backdrop = (stilb_scene_backdrop){.kind = STILB_SCENE_BACKDROP_MAP, .map = map};
	stilb_mat4 transform = stilb_mat4_scale_translate(2.0f, 3.0f, 4.0f, 5.0f);
	stilb_render *render = make_render(0);
	stilb_scene_mesh plane;
	stilb_render_mesh meshes[2];
	require(stilb_scene_mesh_plane(&plane) == STILB_OK);
	for (int m = 0; m < 2; m++)
		require(stilb_render_mesh_create(render, &plane, &meshes[m]) == STILB_OK);
	stilb_scene_mesh_finish(&plane);
	stilb_render_material materials[2] = {seed_material(render, true), seed_material(render, pass_count > 1)};
	require(stilb_render_frame_begin(render) == STILB_OK);
	stilb_render_context *context = stilb_render_context_get(render, 0);
	for (uint32_t p = 0; p < pass_count; p++) {
		require(stilb_render_pass_begin(render, p, p + 1) == STILB_OK);
		for (uint32_t s = 0; s <= p; s++) {
			stilb_render_segment_begin(context, p, s);
			for (uint32_t d = 0; d < 2 + s; d++)
				stilb_render_draw_with_key(context, 1000 - d, meshes[d & 1], materials[d & 1], &transform);
			stilb_render_segment_end(context);
		}
		require(stilb_render_pass_end(render, p) == STILB_OK);
	}
	require(stilb_render_replay(render, passes, pass_count, views, 2, pool, 0) == STILB_OK);
	require(stilb_render_dump_save(render, passes, pass_count, views, 2, path) == STILB_OK);
	stilb_render_destroy(render);
}

/* Writes the seeds into the folder that is the last argument; the fuzzer reads it afterwards. */
int LLVMFuzzerInitialize(int *argc, char ***argv)
{
	const char *seeds = (*argv)[*argc - 1];
	if (*argc < 2 || seeds[0] == '-') {
		fprintf(stderr, "usage: fuzz_render_dump [-OPTION=VALUE ...] FOLDER\n");
		exit(1);
	}
	mkdir(seeds, 0777);
	stilb_job_pool_desc desc = {.worker_count = 0};
	require(stilb_job_pool_create(&desc, &pool) == 0);
	for (uint32_t passes = 1; passes <= 3; passes++) {
		char path[512];
		snprintf(path, sizeof path, "%s/%u-passes", seeds, passes);
		make_seed(path, passes);
	}
	return 0;
}

/* ---- mutations --------------------------------------------------------------------------------------------------- */

static void sign(uint8_t *data, size_t size)
{
	if (size < sizeof(render_dump_header) + 8)
		return;
	uint64_t bytes = size;
	memcpy(data, RENDER_DUMP_MAGIC, 8);
	memcpy(data + offsetof(render_dump_header, file_size), &bytes, sizeof bytes);
	uint64_t checksum = stilb_hash_fnv1a64(STILB_FNV1A64_START, data, size - 8);
	memcpy(data + size - 8, &checksum, sizeof checksum);
}

/* Duplicates or removes the last element of a part whose elements are a multiple of 8 bytes, and adapts the header's
 * count. */
static size_t change_count(uint8_t *data, size_t size, size_t max_size, const uint64_t *begin, uint32_t chosen,
                           bool add)
{
	static const struct {
		render_dump_part part;
		size_t count, count_size, element;
	} parts[] = {
		{RENDER_DUMP_VIEWS, offsetof(render_dump_header, views), 4, sizeof(render_dump_view)},
		{RENDER_DUMP_LIGHTS, offsetof(render_dump_header, lights), 4, sizeof(render_dump_light)},
		{RENDER_DUMP_PASSES, offsetof(render_dump_header, passes), 4, sizeof(render_dump_pass)},
		{RENDER_DUMP_TEXTURES, offsetof(render_dump_header, textures), 4, sizeof(render_dump_texture)},
		{RENDER_DUMP_MATERIALS, offsetof(render_dump_header, materials), 4, sizeof(render_dump_material)},
		{RENDER_DUMP_MESHES, offsetof(render_dump_header, meshes), 4, sizeof(render_dump_mesh)},
		{RENDER_DUMP_DRAWS, offsetof(render_dump_header, draws), 8, sizeof(render_dump_draw)},
		{RENDER_DUMP_VERTICES, offsetof(render_dump_header, vertices), 8, sizeof(stilb_scene_vertex)},
	};
	chosen %= sizeof parts / sizeof *parts;
	size_t element = parts[chosen].element, end = begin[parts[chosen].part + 1];
	uint64_t count = (end - begin[parts[chosen].part]) / element;
	if (count == 0 || (add && size + element > max_size))
		return size;
	size_t from = add ? end - element : end, to = add ? end : end - element;
	memmove(data + to, data + from, size - from);
	count += add ? 1 : (uint64_t)-1;
	memcpy(data + parts[chosen].count, &count, parts[chosen].count_size);
	return size + to - from;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed)
{
	render_dump_header header;
	uint64_t begin[RENDER_DUMP_PARTS + 1];
	bool whole = size >= sizeof header;
	if (whole)
		memcpy(&header, data, sizeof header);
	whole = whole && render_dump_layout(&header, begin) && begin[RENDER_DUMP_PARTS] == size;
	uint32_t part = seed / 16 % RENDER_DUMP_CHECKSUM, action = seed % 16;
	if (!whole || action == 0)
		size = LLVMFuzzerMutate(data, size, max_size);
	else if (action < 4)
		size = change_count(data, size, max_size, begin, seed / 64, seed / 16 % 2);
	else if (begin[part] < begin[part + 1])
		LLVMFuzzerMutate(data + begin[part], begin[part + 1] - begin[part], begin[part + 1] - begin[part]);
	if (action != 15)
		sign(data, size);
	return size;
}

/* ---- checks ------------------------------------------------------------------------------------------------------ */

/* True if all ids are small. A dump with large ones is not played, which would only cost time and memory: every id
 * below them gets an empty resource. */
static bool plays_quickly(const stilb_render_dump *dump)
{
	const render_dump_header *header = dump->header;
	return (header->materials == 0 || dump->materials[header->materials - 1].id < 1000) &&
	       (header->meshes == 0 || dump->meshes[header->meshes - 1].id < 1000) && header->segments < 1000;
}

static void play(stilb_render_dump *dump, stilb_render *render)
{
	require(stilb_render_dump_upload(dump, render) == STILB_OK);
	for (int frame = 0; frame < 2; frame++) {
		require(stilb_render_frame_begin(render) == STILB_OK);
		require(stilb_render_dump_record(dump, render, pool, 0) == STILB_OK);
		require(stilb_render_dump_replay(dump, render, pool, 0) == STILB_OK);
	}
	require(stilb_render_stats_get(render).draws == dump->header->draws);
	require(stilb_render_dump_save(render, dump->pass_table, dump->header->passes, dump->view_table,
	                               dump->header->views, "/dev/null") == STILB_OK);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	stilb_render_dump *dump;
	uint8_t *copy = malloc(size ? size : 1); /* of exactly that size, so that the sanitizer sees reads beyond it */
	require(copy);
	if (size > 0)
		memcpy(copy, data, size);
	stilb_result result = render_dump_read(copy, size, "a.dump", &dump);
	if (result != STILB_OK) {
		require(result == STILB_ERROR_FILE && !dump && strstr(stilb_error_message(), "'a.dump': "));
		return 0;
	}
	if (plays_quickly(dump)) {
		stilb_render *render = make_render((uint32_t)dump->header->stream_hash % 9);
		play(dump, render);
		stilb_render_destroy(render);
	}
	stilb_render_dump_destroy(dump);
	return 0;
}
