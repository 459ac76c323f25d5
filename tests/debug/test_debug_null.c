/* Debug drawing on the null device: threads draw while frames are made, and nothing is lost; how long things stay; and
 * the order of what the device gets. */
#include "tests/debug/debug_world.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

static const stilb_debug_style plain = {.rgba = 0xffffffff};

static stilb_engine_desc null_desc(uint32_t workers)
{
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.device = STILB_RENDER_DEVICE_NULL;
	desc.workers = workers;
	return desc;
}

/* Draws a frame; returns how many lines and letters are in it. */
static uint32_t frame(const world *w)
{
	stilb_engine_report report;
	if (stilb_engine_frame(w->engine, &report) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return stilb_debug_count(w->debug);
}

static uint64_t passes(const world *w)
{
	return stilb_gpu_stats_get(stilb_engine_gpu(w->engine)).passes;
}

/* What the device would read of the frame. */
static const debug_record *records_of(const world *w)
{
	const debug_buffer *buffer = &w->debug->buffers[w->debug->buffer];
	return (const debug_record *)stilb_gpu_buffer_mapped(stilb_engine_gpu(w->engine), buffer->buffer) +
	       STILB_RENDER_MAX_PASSES + (buffer->capacity + 16383) / 16384;
}

static void assert_at(const float got[3], float x, float y, float z)
{
	if (!(fabsf(got[0] - x) < 1e-4f && fabsf(got[1] - y) < 1e-4f && fabsf(got[2] - z) < 1e-4f))
		fail_msg("%g %g %g, not %g %g %g", (double)got[0], (double)got[1], (double)got[2], (double)x, (double)y,
		         (double)z);
}

/* Which corner of the box from -1, -1, near to 1, 1, 1 a place is after a matrix: a bit for each axis. */
static uint32_t corner_of(const stilb_mat4 *matrix, const float place[3], float near)
{
	uint32_t corner = 0;
	float h[4];
	for (int r = 0; r < 4; r++)
		h[r] = matrix->m[r] * place[0] + matrix->m[4 + r] * place[1] + matrix->m[8 + r] * place[2] + matrix->m[12 + r];
	for (uint32_t a = 0; a < 3; a++) {
		float value = h[a] / h[3], low = a < 2 ? -1.0f : near;
		assert_true(fabsf(value - low) < 1e-3f || fabsf(value - 1.0f) < 1e-3f);
		corner |= (uint32_t)(fabsf(value - 1.0f) < 1e-3f) << a;
	}
	return corner;
}

/* Twelve edges, each once. */
static void assert_box(const world *w, const stilb_mat4 *matrix, float near)
{
	bool seen[8][8] = {{false}};
	assert_int_equal(stilb_debug_count(w->debug), 12);
	for (uint32_t i = 0; i < 12; i++) {
		const debug_record *r = &records_of(w)[i];
		uint32_t from = corner_of(matrix, r->from, near), to = corner_of(matrix, r->to, near);
		assert_int_equal(__builtin_popcount(from ^ to), 1);
		assert_true(!seen[from][to] && !seen[to][from]);
		seen[from][to] = true;
	}
}

/* Boxes by their corners, also what a camera sees; axes by their ends. */
static void shapes_are_where_they_belong(void **state)
{
	(void)state;
	world w = world_open(null_desc(0));
	stilb_mat4 identity = stilb_mat4_identity(), place = stilb_mat4_scale_translate(2.0f, 1.0f, 2.0f, -9.0f);
	static const float low[3] = {-1, -1, 0.25f}, high[3] = {1, 1, 1};
	stilb_debug_box(w.debug, low, high, NULL, plain);
	frame(&w);
	assert_box(&w, &identity, 0.25f);
	stilb_debug_box(w.debug, low, high, &place, plain);
	stilb_mat4 back = stilb_mat4_scale_translate(0.5f, -0.5f, -1.0f, 4.5f);
	frame(&w);
	assert_box(&w, &back, 0.25f);
	/* The inverse of x / -z, y / -z, 1 / -z is itself but for signs: w = z' of what went in. */
	stilb_mat4 camera = {.m = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0}};
	stilb_mat4 inverse = {.m = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0}};
	stilb_debug_box(w.debug, low, high, &inverse, plain);
	frame(&w);
	assert_box(&w, &camera, 0.25f);
	stilb_debug_axes(w.debug, &place, 3.0f, (stilb_debug_style){.rgba = 0x80});
	assert_int_equal(frame(&w), 3);
	for (uint32_t i = 0; i < 3; i++) {
		const debug_record *r = &records_of(&w)[i];
		assert_at(r->from, 1, 2, -9);
		assert_int_equal(r->rgba & 0xff, 0x80);
		uint32_t axis = r->rgba >> 24 == 0xff ? 0 : (r->rgba >> 16 & 0xff) == 0xc0 ? 1 : 2;
		assert_at(r->to, axis == 0 ? 7 : 1, axis == 1 ? 8 : 2, axis == 2 ? -3 : -9);
	}
	/* A circle lies in its plane, at its radius, and closes. */
	static const float center[3] = {1, 2, -5}, axis[3] = {0.3f, -2, 0.9f};
	stilb_debug_circle(w.debug, center, axis, 1.5f, plain);
	assert_int_equal(frame(&w), 48);
	float sum[3] = {0};
	for (uint32_t i = 0; i < 48; i++) {
		const debug_record *r = &records_of(&w)[i];
		float along = 0.0f, square = 0.0f;
		for (int a = 0; a < 3; a++) {
			float d = r->from[a] - center[a];
			along += d * axis[a];
			square += d * d;
			sum[a] += r->to[a] - r->from[a];
		}
		assert_true(fabsf(along) < 1e-4f && fabsf(square - 2.25f) < 1e-4f);
	}
	assert_at(sum, 0, 0, 0);
	world_close(&w);
}

static void what_shapes_are_made_of(void **state)
{
	(void)state;
	world w = world_open(null_desc(1));
	static const float low[3] = {-1, -1, -3}, high[3] = {1, 1, -2};
	stilb_mat4 identity = stilb_mat4_identity();
	assert_int_equal(frame(&w), 0);
	uint64_t before = passes(&w);
	stilb_debug_line(w.debug, low, high, plain);
	assert_int_equal(frame(&w), 1);
	assert_int_equal(passes(&w), before + 1);
	assert_int_equal(frame(&w), 0);
	assert_int_equal(passes(&w), before); /* a frame without lines has no pass for them */
	stilb_debug_box(w.debug, low, high, NULL, plain);
	assert_int_equal(frame(&w), 12);
	stilb_debug_sphere(w.debug, low, 1.0f, plain);
	assert_int_equal(frame(&w), 3 * 48);
	stilb_debug_axes(w.debug, &identity, 1.0f, plain);
	assert_int_equal(frame(&w), 3);
	stilb_debug_text(w.debug, low, plain, "%s %d", "ab c", 12);
	assert_int_equal(frame(&w), 2 * 5); /* blanks are nothing to draw */
	float points[2 * 1000][3] = {{0}};
	stilb_debug_lines(w.debug, (const float(*)[3])points, 1000, plain);
	stilb_debug_lines(w.debug, NULL, 0, plain);
	assert_int_equal(frame(&w), 1000);
	char text[600];
	memset(text, 'x', sizeof text);
	text[sizeof text - 1] = '\0';
	stilb_debug_text(w.debug, low, plain, "%s", text);
	assert_int_equal(frame(&w), 2 * 255);
	stilb_engine_set_scene(w.engine, NULL);
	stilb_debug_line(w.debug, low, high, plain);
	assert_int_equal(frame(&w), 0); /* no camera */
	stilb_engine_set_scene(w.engine, w.scene);
	assert_int_equal(frame(&w), 0);
	world_close(&w);
}

/* Headless frames are 1/60 s apart. */
static void some_stay(void **state)
{
	(void)state;
	world w = world_open(null_desc(1));
	static const float a[3] = {0, 0, -2}, b[3] = {1, 0, -2};
	frame(&w);
	stilb_debug_line(w.debug, a, b, (stilb_debug_style){.rgba = 0xffffffff, .seconds = 2.5f / 60.0f});
	stilb_debug_line(w.debug, a, b, (stilb_debug_style){.rgba = 0xffffffff, .seconds = 1e-6f});
	stilb_debug_line(w.debug, a, b, plain);
	assert_int_equal(frame(&w), 3);
	for (uint32_t i = 0; i < 1500; i++) /* more than a chunk, so that some go and some stay */
		stilb_debug_line(w.debug, a, b,
		                 (stilb_debug_style){.rgba = 0xffffffff, .seconds = i % 2 ? 0.5f / 60.0f : 1.5f / 60.0f});
	assert_int_equal(frame(&w), 1501);
	assert_int_equal(frame(&w), 751);
	assert_int_equal(frame(&w), 0);
	world_close(&w);
}

/* ---- threads ----------------------------------------------------------------------------------------------------- */

#define THREADS 8u
#define LINES (TEST_TSAN ? 2000u : 40000u)

typedef struct drawer {
	stilb_debug *debug;
	uint32_t number;
	pthread_t thread;
	_Atomic uint32_t *running;
} drawer;

static void *draw_lines(void *user)
{
	const drawer *d = user;
	for (uint32_t i = 0; i < LINES; i++) {
		float from[3] = {(float)d->number, (float)i, -2.0f}, to[3] = {0, 0, -3.0f};
		stilb_debug_line(d->debug, from, to, plain);
		if (i % 100 == 0)
			stilb_debug_text(d->debug, from, plain, "%c", 'a' + (int)d->number);
	}
	/* Release: partner of the acquire in the test; what this thread has drawn is in the next frame at the latest. */
	atomic_fetch_sub_explicit(d->running, 1, memory_order_release);
	return NULL;
}

/* Threads draw while the engine makes frames; later ones go on where those that have ended stopped. */
static void no_line_is_lost(void **state)
{
	(void)state;
	world w = world_open(null_desc(2));
	static _Atomic uint32_t running;
	drawer drawers[THREADS];
	uint64_t drawn = 0, expected = 0;
	for (int round = 0; round < (TEST_TSAN ? 2 : 10); round++) {
		atomic_store_explicit(&running, THREADS, memory_order_relaxed); /* the threads are started after it */
		for (uint32_t t = 0; t < THREADS; t++) {
			drawers[t] = (drawer){.debug = w.debug, .number = t, .running = &running};
			assert_int_equal(pthread_create(&drawers[t].thread, NULL, draw_lines, &drawers[t]), 0);
		}
		/* Acquire: partner of the release in draw_lines. */
		while (atomic_load_explicit(&running, memory_order_acquire) > 0)
			drawn += frame(&w);
		for (uint32_t t = 0; t < THREADS; t++)
			pthread_join(drawers[t].thread, NULL);
		drawn += frame(&w);
		expected += (uint64_t)THREADS * (LINES + 2 * ((LINES + 99) / 100));
		assert_int_equal(drawn, expected);
	}
	world_close(&w);
}

static pthread_barrier_t all_have_drawn;

static void *draw_and_wait(void *debug)
{
	static const float at[3] = {0, 0, -2};
	stilb_debug_line(debug, at, at, plain);
	pthread_barrier_wait(&all_have_drawn);
	return NULL;
}

/* 600 threads, 200 at a time, are well; 600 at a time are an error of the frame. */
static void threads_are_counted_at_a_time(void **state)
{
	(void)state;
	enum { MANY = 600, SOME = 200 };
	static pthread_t threads[MANY];
	world w = world_open(null_desc(0));
	stilb_engine_report report;
	pthread_attr_t small;
	pthread_attr_init(&small);
	pthread_attr_setstacksize(&small, 128u << 10);
	static const uint32_t rounds[] = {SOME, SOME, SOME, MANY};
	for (size_t r = 0; r < sizeof rounds / sizeof *rounds; r++) {
		pthread_barrier_init(&all_have_drawn, NULL, rounds[r]);
		for (uint32_t t = 0; t < rounds[r]; t++)
			assert_int_equal(pthread_create(&threads[t], &small, draw_and_wait, w.debug), 0);
		for (uint32_t t = 0; t < rounds[r]; t++)
			pthread_join(threads[t], NULL);
		pthread_barrier_destroy(&all_have_drawn);
		if (rounds[r] < STILB_DEBUG_THREADS)
			assert_int_equal(frame(&w), rounds[r]);
	}
	assert_int_equal(stilb_engine_frame(w.engine, &report), STILB_ERROR_THREAD);
	assert_non_null(strstr(stilb_error_message(), "more than 512 threads draw"));
	pthread_attr_destroy(&small);
	world_close(&w);
}

/* The records that a frame's device would read, whichever threads have drawn them. */
static void the_order_is_that_of_the_content(void **state)
{
	(void)state;
	enum { COUNT = 3000 };
	static debug_record first[COUNT];
	for (uint32_t backwards = 0; backwards < 2; backwards++) {
		world w = world_open(null_desc(2));
		for (uint32_t i = 0; i < COUNT; i++) {
			uint32_t n = backwards ? COUNT - 1 - i : i;
			float at[3], to[3];
			for (uint32_t a = 0; a < 3; a++) {
				at[a] = stilb_random_float(1, 6 * n + a) - 0.5f;
				to[a] = stilb_random_float(1, 6 * n + 3 + a) - 0.5f;
			}
			if (n % 3 == 0)
				at[2] = to[2] = -3.0f; /* many are equally far */
			stilb_debug_style style = {.rgba = (uint32_t)stilb_random_u64(2, n), .on_top = n % 2 == 0};
			if (n % 5 == 0)
				style.seconds = 1.0f;
			stilb_debug_line(w.debug, at, to, style);
		}
		assert_int_equal(frame(&w), COUNT);
		const debug_record *records = records_of(&w);
		if (!backwards)
			memcpy(first, records, sizeof first);
		assert_memory_equal(first, records, sizeof first);
		for (uint32_t i = 1; i < COUNT; i++) {
			float z0 = records[i - 1].from[2] + records[i - 1].to[2], z1 = records[i].from[2] + records[i].to[2];
			bool top0 = records[i - 1].word & DEBUG_ON_TOP, top1 = records[i].word & DEBUG_ON_TOP;
			assert_true(top0 < top1 || (top0 == top1 && (z0 <= z1 + 1e-5f || z1 >= 0)));
		}
		world_close(&w);
	}
}

/* The calling thread's time alone: the machine may be busy. */
static uint64_t thread_ns(void)
{
	struct timespec t;
	clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
	return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

/* Many more than one command has, more than one block, in memory that grows; and how long it takes. */
static void a_million_lines(void **state)
{
	(void)state;
	enum { COUNT = TEST_TSAN || TEST_ASAN ? 100000 : 1000000 };
	world w = world_open(null_desc(1));
	for (int round = 0; round < 3; round++) {
		uint64_t begin = thread_ns();
		for (uint32_t i = 0; i < COUNT; i++) {
			float from[3] = {(float)(i % 1000), (float)(i / 1000), -2.0f - (float)(i % 7)}, to[3] = {0, 1, -3.0f};
			stilb_debug_line(w.debug, from, to, plain);
		}
		uint64_t drawn = thread_ns();
		assert_int_equal(frame(&w), COUNT);
		uint64_t end = thread_ns();
		printf("%d lines: %.1f ns each to draw, %.1f ns in the frame\n", COUNT, (double)(drawn - begin) / COUNT,
		       (double)(end - drawn) / COUNT);
		uint64_t vertices = 0;
		const debug_buffer *buffer = &w.debug->buffers[w.debug->buffer];
		const uint32_t *commands =
			(const uint32_t *)stilb_gpu_buffer_mapped(stilb_engine_gpu(w.engine), buffer->buffer) +
			8 * STILB_RENDER_MAX_PASSES;
		for (uint32_t c = 0; c < w.debug->run.count; c++) {
			assert_int_equal(commands[8 * c + 3], 4 * 16384 * c);
			vertices += commands[8 * c];
		}
		assert_int_equal(vertices, 6 * (uint64_t)COUNT);
	}
	world_close(&w);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(what_shapes_are_made_of),
		test_one_thread(shapes_are_where_they_belong),
		cmocka_unit_test(some_stay),
		cmocka_unit_test(no_line_is_lost),
		test_one_thread(threads_are_counted_at_a_time),
		test_one_thread(the_order_is_that_of_the_content),
		test_one_thread(a_million_lines),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
