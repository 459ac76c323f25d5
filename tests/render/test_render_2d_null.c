/* 2D passes on the null device: the draws that reach the device and their order, memory that grows and that runs out.
 * 2D passes are no part of the stream hash and of dumps. The linker sends allocations here (--wrap), which lets them
 * fail. */
#include "render/render_dump.h"
#include "render/render_internal.h"
#include "support/render_reference.h"
#include "support/test.h"

#include <stddef.h>
#include <stdlib.h>
#include <unistd.h>

/* ---- memory that runs out ---------------------------------------------------------------------------------------- */

/* Allocations from now up to the one that fails; later ones succeed. Relaxed: only the number matters. */
static _Atomic int64_t allocations_left;

void *__real_stilb_memory_alloc(size_t count, size_t size);
void *__wrap_stilb_memory_alloc(size_t count, size_t size);

static void allocation_fails(int64_t number)
{
	atomic_store_explicit(&allocations_left, number, memory_order_relaxed);
}

void *__wrap_stilb_memory_alloc(size_t count, size_t size)
{
	bool fails = atomic_fetch_sub_explicit(&allocations_left, 1, memory_order_relaxed) == 1;
	return fails ? NULL : __real_stilb_memory_alloc(count, size);
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

static const stilb_render_pass passes[2] = {{.name = "overlay", .kind = STILB_RENDER_PASS_2D},
                                            {.name = "main", .order = 3}};
static const stilb_render_view one_view[1];

static stilb_render *make_render(stilb_render_replay_mode replay)
{
	stilb_render_desc desc = {
		.device = STILB_RENDER_DEVICE_NULL, .replay = replay, .width = 64, .height = 64, .context_count = 4};
	stilb_render *render;
	assert_int_equal(stilb_render_create(&desc, &render), STILB_OK);
	return render;
}

static stilb_render_texture make_texture(stilb_render *render)
{
	static uint8_t white[4] = {255, 255, 255, 255};
	stilb_image image = {1, 1, 4, STILB_IMAGE_U8_SRGB, white, 0};
	stilb_render_texture out;
	assert_int_equal(stilb_render_texture_create(render, &image, &out), STILB_OK);
	return out;
}

/* Shape number n: a fan of triangles with n + 3 vertices; each vertex holds n and its own number, so that the data can
 * be recognised at the device. */
typedef struct shape {
	stilb_render_vertex_2d vertices[40];
	uint32_t indices[120];
	uint32_t vertex_count, index_count;
	float clip[4];
} shape;

static shape shape_make(uint32_t number)
{
	shape s = {.vertex_count = 3 + number % 37, .clip = {(float)number, 1.0f, 2.0f, 3.0f}};
	for (uint32_t v = 0; v < s.vertex_count; v++)
		s.vertices[v] = (stilb_render_vertex_2d){.position = {(float)number, (float)v}};
	for (uint32_t v = 2; v < s.vertex_count; v++) {
		s.indices[s.index_count++] = 0;
		s.indices[s.index_count++] = v - 1;
		s.indices[s.index_count++] = v;
	}
	return s;
}

static void shape_record(stilb_render_context *context, uint32_t number, stilb_render_texture texture)
{
	shape s = shape_make(number);
	uint32_t first = stilb_render_geometry_2d(context, s.vertices, s.vertex_count, s.indices, s.index_count);
	stilb_render_draw_2d(context, first, s.index_count, s.clip, texture);
}

/* Checks the draws that the device gets: all shapes in order, each with its clip. */
static void assert_shapes(const stilb_render *render, uint32_t count)
{
	const render_pass_lists *lists = &render->passes[0];
	const stilb_render_vertex_2d *vertices = render->memory[RENDER_MEMORY_VERTICES_2D].data;
	const uint32_t *indices = render->memory[RENDER_MEMORY_INDICES_2D].data;
	uint32_t number = 0;
	for (uint32_t r = 0; r < lists->run_count; r++)
		for (uint32_t c = 0; c < lists->runs[r].count; c++, number++) {
			const render_command *command = &render_commands(render)[lists->runs[r].first + c];
			shape s = shape_make(number);
			assert_int_equal(command->index_count, s.index_count);
			assert_int_equal(command->instance_count, 1);
			assert_int_equal(command->vertex_offset, 0);
			assert_memory_equal(render_row_of(render, command)->transform, s.clip, sizeof s.clip);
			for (uint32_t i = 0; i < s.index_count; i++)
				assert_memory_equal(&vertices[indices[command->first_index + i]], &s.vertices[s.indices[i]],
				                    sizeof *vertices);
		}
	assert_int_equal(number, count);
}

/* Records the shapes in segments of 100 (numbered parts of the pass), each by another context, the last one first. */
static stilb_result record_shapes(stilb_render *render, uint32_t count, stilb_render_texture texture)
{
	uint32_t segments = (count + 99) / 100;
	stilb_result result = stilb_render_pass_begin(render, 0, segments);
	for (uint32_t s = segments; s-- > 0 && result == STILB_OK;) {
		stilb_render_context *context = stilb_render_context_get(render, s % render->context_count);
		stilb_render_segment_begin(context, 0, s);
		for (uint32_t n = s * 100; n < count && n < (s + 1) * 100; n++)
			shape_record(context, n, texture);
		stilb_render_segment_end(context);
	}
	return result == STILB_OK ? stilb_render_pass_end(render, 0) : result;
}

static stilb_result draw_shapes(stilb_render *render, uint32_t count, stilb_render_texture texture)
{
	stilb_result result = stilb_render_frame_begin(render);
	if (result == STILB_OK)
		result = record_shapes(render, count, texture);
	if (result == STILB_OK)
		result = stilb_render_replay(render, passes, 1, NULL, 0, NULL, 0);
	return result == STILB_OK ? stilb_render_present(render) : result;
}

static uint64_t shape_bytes(uint32_t count)
{
	uint64_t bytes = 0;
	for (uint32_t n = 0; n < count; n++) {
		shape s = shape_make(n);
		bytes += s.vertex_count * sizeof *s.vertices + s.index_count * sizeof *s.indices;
	}
	return bytes;
}

/* ---- tests ------------------------------------------------------------------------------------------------------- */

/* Draws frames with 2D geometry: the first begins without memory for it, the next with too little, later ones with
 * enough. */
static void memory_outgrows_and_stays(void **state)
{
	(void)state;
	static const uint32_t counts[] = {7, 0, 350, 5000, 1, 5000, 4999, 20000, 20000, 20000, 3};
	for (int mode = 0; mode < 3; mode++) {
		stilb_render *render = make_render((stilb_render_replay_mode)mode);
		stilb_render_texture texture = make_texture(render);
		for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
			assert_int_equal(draw_shapes(render, counts[c], texture), STILB_OK);
			assert_shapes(render, counts[c]);
		}
		for (uint32_t i = 0; i < render->context_count; i++)
			assert_int_equal(render->contexts[i].overflow_count, 0);
		stilb_render_destroy(render);
	}
}

static void draws_are_counted(void **state)
{
	(void)state;
	for (int mode = 0; mode < 3; mode++) {
		stilb_render *render = make_render((stilb_render_replay_mode)mode);
		stilb_render_texture texture = make_texture(render);
		bool indirect = mode == STILB_RENDER_REPLAY_INDIRECT;
		assert_int_equal(draw_shapes(render, 90, texture), STILB_OK);
		stilb_render_stats stats = stilb_render_stats_get(render);
		assert_true(stats.draws == 90);
		assert_true(stats.draw_commands == (indirect ? 0 : 90));
		assert_true(stats.indirect_commands == indirect); /* one device command for all draws, whatever their clips */
		assert_true(stats.execute_commands == 0);
		assert_true(stats.binds_asked == 270 && stats.binds_sent == 3);
		assert_true(stats.recorded_bytes == 90 * 96 + shape_bytes(90));
		/* With textures: one device command for each run of draws with the same texture. */
		assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
		assert_int_equal(stilb_render_pass_begin(render, 0, 1), STILB_OK);
		stilb_render_context *context = stilb_render_context_get(render, 0);
		stilb_render_segment_begin(context, 0, 0);
		for (uint32_t n = 0; n < 12; n++)
			shape_record(context, n, n / 3 % 2 ? (stilb_render_texture){0} : texture);
		stilb_render_segment_end(context);
		assert_int_equal(stilb_render_pass_end(render, 0), STILB_OK);
		assert_int_equal(stilb_render_replay(render, passes, 1, NULL, 0, NULL, 0), STILB_OK);
		assert_true(stilb_render_stats_get(render).indirect_commands == (indirect ? 4 : 0));
		assert_true(stilb_render_stats_get(render).binds_sent ==
		            3 + 1 + 2 + 1); /* three for the first draw, then pipeline and texture where they change */
		assert_shapes(render, 12);
		assert_int_equal(draw_shapes(render, 0, texture), STILB_OK);
		stats = stilb_render_stats_get(render);
		assert_true(stats.draws == 0 && stats.recorded_bytes == 0 && stats.indirect_commands == 0);
		stilb_render_destroy(render);
	}
}

/* Shapes without vertices or indices. */
static void empty_geometry_is_none(void **state)
{
	(void)state;
	stilb_render *render = make_render(STILB_RENDER_REPLAY_INDIRECT);
	shape s = shape_make(1);
	assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
	assert_int_equal(stilb_render_pass_begin(render, 0, 1), STILB_OK);
	stilb_render_context *context = stilb_render_context_get(render, 0);
	stilb_render_segment_begin(context, 0, 0);
	stilb_render_geometry_2d(context, s.vertices, 0, s.indices, 0);
	stilb_render_geometry_2d(context, s.vertices, 3, NULL, 0);
	stilb_render_segment_end(context);
	assert_int_equal(stilb_render_pass_end(render, 0), STILB_OK);
	assert_int_equal(stilb_render_replay(render, passes, 1, NULL, 0, NULL, 0), STILB_OK);
	assert_true(stilb_render_stats_get(render).draws == 0);
	stilb_render_destroy(render);
}

/* Each allocation fails once: the frame returns an error that says so, and the next frame is complete. */
static void without_memory_the_frame_fails(void **state)
{
	(void)state;
	for (int mode = 0; mode < 3; mode++) {
		bool failed = true;
		for (int64_t n = 1; failed; n++) {
			stilb_render *render = make_render((stilb_render_replay_mode)mode);
			stilb_render_texture texture = make_texture(render);
			assert_int_equal(draw_shapes(render, 3, texture), STILB_OK);
			allocation_fails(n);
			stilb_result result = draw_shapes(render, 60, texture);
			failed = atomic_load_explicit(&allocations_left, memory_order_relaxed) <= 0;
			allocation_fails(0);
			assert_true(failed || result == STILB_OK);
			if (result == STILB_OK) {
				assert_shapes(render, 60);
			} else {
				assert_int_equal(result, STILB_ERROR_MEMORY);
				assert_non_null(strstr(stilb_error_message(), "no memory for"));
			}
			assert_int_equal(draw_shapes(render, 500, texture), STILB_OK);
			assert_shapes(render, 500);
			stilb_render_destroy(render);
			assert_in_range(n, 1, 200);
		}
	}
}

static size_t read_file(const char *path, uint8_t *bytes, size_t size)
{
	FILE *file = fopen(path, "rb");
	assert_non_null(file);
	size_t length = fread(bytes, 1, size, file);
	assert_true(length < size);
	fclose(file);
	return length;
}

/* A scene with and without a 2D pass gives the same stream hash and the same dump. */
static void no_part_of_hash_and_dump(void **state)
{
	(void)state;
	char with[64], without[64];
	snprintf(with, sizeof with, "test_render_2d_null.%d.with", (int)getpid());
	snprintf(without, sizeof without, "test_render_2d_null.%d.without", (int)getpid());
	stilb_scene *scene;
	stilb_job_pool *pool;
	uint32_t ids[40];
	for (uint32_t i = 0; i < 40; i++)
		ids[i] = i;
	assert_int_equal(stilb_scene_create_stress(40, 7, &scene), STILB_OK);
	assert_int_equal(stilb_job_pool_create(&(stilb_job_pool_desc){.worker_count = 2}, &pool), 0);
	stilb_render *render = make_render(STILB_RENDER_REPLAY_INDIRECT);
	assert_int_equal(stilb_render_set_scene(render, scene), STILB_OK);
	uint64_t hash = reference_hash_models(REFERENCE_HASH_PASS, scene, ids, 40);
	stilb_render_pass alone = passes[1];
	assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
	assert_int_equal(stilb_render_record(render, 0, scene, ids, 40, pool, 0), STILB_OK);
	assert_int_equal(stilb_render_replay(render, &alone, 1, one_view, 1, pool, 0), STILB_OK);
	assert_true(stilb_render_stream_hash(render) == hash);
	assert_int_equal(stilb_render_dump_save(render, &alone, 1, one_view, 1, without), STILB_OK);

	assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
	assert_int_equal(stilb_render_record(render, 1, scene, ids, 40, pool, 0), STILB_OK);
	assert_int_equal(record_shapes(render, 250, (stilb_render_texture){0}), STILB_OK);
	assert_int_equal(stilb_render_replay(render, passes, 2, one_view, 1, pool, 0), STILB_OK);
	assert_true(stilb_render_stream_hash(render) == hash);
	assert_true(stilb_render_stats_get(render).draws == 2 * 40 + 250);
	assert_int_equal(render->replayed[0], 1); /* scene passes come first, also with a greater order */
	assert_int_equal(render->replayed[1], 0);
	assert_int_equal(stilb_render_dump_save(render, passes, 2, one_view, 1, with), STILB_OK);
	static uint8_t bytes[2][1 << 20];
	size_t size = read_file(with, bytes[0], sizeof bytes[0]);
	assert_int_equal(read_file(without, bytes[1], sizeof bytes[1]), size);
	assert_memory_equal(bytes[0], bytes[1], size);

	assert_int_equal(draw_shapes(render, 5, (stilb_render_texture){0}), STILB_OK);
	assert_true(stilb_render_stream_hash(render) == REFERENCE_HASH_START);
	assert_int_equal(stilb_render_dump_save(render, passes, 1, one_view, 1, with), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "2D"));
	unlink(with);
	unlink(without);
	stilb_render_destroy(render);
	stilb_job_pool_destroy(pool);
	stilb_scene_destroy(scene);
}

/* ---- from all workers at once ------------------------------------------------------------------------------------ */

typedef struct crowd {
	stilb_render *render;
	stilb_render_texture texture;
} crowd;

static void crowd_slice(uint32_t begin, uint32_t end, uint32_t worker, void *user)
{
	const crowd *c = user;
	stilb_render_context *context = stilb_render_context_get(c->render, worker);
	for (uint32_t s = begin; s < end; s++) {
		stilb_render_segment_begin(context, 0, s);
		for (uint32_t n = s * 50; n < (s + 1) * 50; n++)
			shape_record(context, n, c->texture);
		stilb_render_segment_end(context);
	}
}

static void workers_share_the_memory(void **state)
{
	(void)state;
	stilb_job_pool *pool;
	assert_int_equal(stilb_job_pool_create(&(stilb_job_pool_desc){.worker_count = 3}, &pool), 0);
	stilb_render *render = make_render(STILB_RENDER_REPLAY_DIRECT);
	crowd c = {render, make_texture(render)};
	for (uint32_t frame = 0; frame < 12; frame++) {
		uint32_t segments = 10 + frame % 4 * 25;
		assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
		assert_int_equal(stilb_render_pass_begin(render, 0, segments), STILB_OK);
		stilb_job_parallel_for(pool, segments, 1, crowd_slice, &c, 0);
		assert_int_equal(stilb_render_pass_end(render, 0), STILB_OK);
		assert_int_equal(stilb_render_replay(render, passes, 1, NULL, 0, pool, 0), STILB_OK);
		assert_shapes(render, segments * 50);
	}
	stilb_render_destroy(render);
	stilb_job_pool_destroy(pool);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		test_one_thread(memory_outgrows_and_stays), cmocka_unit_test(draws_are_counted),
		cmocka_unit_test(empty_geometry_is_none),   test_one_thread(without_memory_the_frame_fails),
		cmocka_unit_test(no_part_of_hash_and_dump), cmocka_unit_test(workers_share_the_memory),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
