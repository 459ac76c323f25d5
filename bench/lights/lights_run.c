/* The program of the suite `lights`: builds a view's lists by one thread and by two, in turn with the peer: the tests
 * of all pairs of light and cell, a sphere against six planes, eight at a time, from arrays in memory. Both builds must
 * have the same bits. */
#include "bench/harness/bench_child.h"
#include "bench/lights/lights_cases.h"
#include "bench/lights/lights_floor.h"
#include "bench/lights/lights_frames.h"
#include "bench/lights/lights_octree.h"
#include "jobs/job.h"
#include "light/light_lists.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#define WIDTH 1920u
#define HEIGHT 1080u
#define TILE 32u
#define SLICES 24u

/* ---- scenes ------------------------------------------------------------------------------------------------------ */

static float draw(uint32_t light, uint32_t number, float low, float high)
{
	return low + (high - low) * stilb_random_float(24, 8 * (uint64_t)light + number);
}

/* Lamps evenly in a box that begins before the camera; every fourth is a spot that shines down, or none is. */
static void fill_box(stilb_scene_light *lights, uint32_t count, float width, float height, float depth, float reach,
                     bool spots)
{
	for (uint32_t i = 0; i < count; i++) {
		stilb_scene_light *light = &lights[i];
		*light = (stilb_scene_light){
			.kind = spots && i % 4 == 3 ? STILB_SCENE_LIGHT_SPOT : STILB_SCENE_LIGHT_POINT,
			.position = {draw(i, 0, -0.5f * width, 0.5f * width), draw(i, 1, 0.0f, height), draw(i, 2, -depth, 2.0f)},
			.direction = {0.0f, -1.0f, 0.0f},
			.intensity = {draw(i, 3, 1.0f, 5.0f), draw(i, 4, 1.0f, 5.0f), draw(i, 5, 1.0f, 5.0f)},
			.cos_inner = 0.9f,
			.cos_outer = 0.7f,
			.reach = reach * draw(i, 6, 0.7f, 1.3f),
			.falloff = STILB_SCENE_LIGHT_WINDOWED,
		};
	}
}

/* Bulbs on five strings across a garden. */
static void fill_strings(stilb_scene_light *lights, uint32_t count)
{
	fill_box(lights, count, 12.0f, 3.0f, 12.0f, 1.5f, false);
	for (uint32_t i = 0; i < count; i++) {
		float along = (float)(i / 5) / (float)(count / 5) - 0.5f;
		lights[i].position[0] = 12.0f * along;
		lights[i].position[1] = 2.0f + 4.0f * along * along;
		lights[i].position[2] = -2.0f * (float)(i % 5) - 2.0f;
	}
}

static stilb_light_grid fill(stilb_scene_light *lights, uint32_t count)
{
	float last = 50.0f;
	if (count == 18) {
		fill_box(lights, count, 8.0f, 3.0f, 8.0f, 5.0f, true);
	} else if (count == 230) {
		fill_strings(lights, count);
	} else if (count == 1000) {
		fill_box(lights, count, 40.0f, 10.0f, 45.0f, 3.0f, true);
	} else if (count == 10000) {
		fill_box(lights, count, 120.0f, 12.0f, 120.0f, 3.0f, false);
	} else {
		fill_box(lights, count, 1000.0f, 30.0f, 1000.0f, 8.0f, true);
		last = 400.0f;
	}
	stilb_mat4 view = stilb_mat4_view(stilb_vec3_make(0.0f, 1.7f, 0.0f), 0.1f, 0.05f);
	stilb_mat4 projection = stilb_mat4_perspective(1.0f, (float)WIDTH / (float)HEIGHT, 0.1f, 2000.0f);
	return (stilb_light_grid){.view_projection = stilb_mat4_multiply(projection, view),
	                          .width = WIDTH,
	                          .height = HEIGHT,
	                          .tile = TILE,
	                          .slices = SLICES,
	                          .first = 1.0f,
	                          .last = last};
}

/* ---- the peer ---------------------------------------------------------------------------------------------------- */

/* The spheres of all pairs in the order of the lists, and the frusta of the cells. */
typedef struct stream {
	float *x, *y, *z, *radius;
	uint8_t *visible;      /* a bit for each */
	stilb_frustum *frusta; /* of each cell */
	stilb_frustum view;
	uint32_t count;
} stream;

/* The plane where the row `row` of the matrix is `edge` times its last row; side: 1 or -1. */
static stilb_plane plane_of(const stilb_mat4 *matrix, int row, float edge, float side)
{
	float n[4];
	for (int k = 0; k < 4; k++)
		n[k] = side * (matrix->m[4 * k + row] - edge * matrix->m[4 * k + 3]);
	float length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
	return (stilb_plane){n[0] / length, n[1] / length, n[2] / length, n[3] / length};
}

static stilb_frustum cell_frustum(const stilb_light_lists *lists, const stilb_mat4 *matrix, uint32_t cell)
{
	uint32_t x = cell % lists->columns, y = cell / lists->columns % lists->rows;
	uint32_t z = cell / lists->columns / lists->rows;
	float wide = 2.0f * TILE / WIDTH, high = 2.0f * TILE / HEIGHT;
	float near_z = z > 0 ? exp2f(((float)z - lists->slice_bias) / lists->slice_scale) : 0.0f;
	float far_z = z + 1 < lists->slices ? exp2f(((float)z + 1.0f - lists->slice_bias) / lists->slice_scale) : 1e9f;
	const float *d = lists->depth_plane;
	return (stilb_frustum){{plane_of(matrix, 0, (float)x * wide - 1.0f, 1.0f),
	                        plane_of(matrix, 0, (float)(x + 1) * wide - 1.0f, -1.0f),
	                        plane_of(matrix, 1, (float)y * high - 1.0f, 1.0f),
	                        plane_of(matrix, 1, (float)(y + 1) * high - 1.0f, -1.0f),
	                        {d[0], d[1], d[2], d[3] - near_z},
	                        {-d[0], -d[1], -d[2], far_z - d[3]}}};
}

static stream stream_make(const stilb_light_lists *lists, const stilb_scene_light *lights, const stilb_mat4 *matrix)
{
	size_t room = (size_t)lists->id_count + 8, cells = (size_t)lists->columns * lists->rows * lists->slices;
	stream s = {.count = lists->id_count, .view = stilb_frustum_from_matrix(matrix)};
	s.x = stilb_memory_alloc(4 * room, sizeof *s.x);
	s.visible = stilb_memory_alloc(room + cells, 1);
	s.frusta = stilb_memory_alloc(cells, sizeof *s.frusta);
	if (!s.x || !s.visible || !s.frusta)
		bench_child_fail("no memory");
	s.y = s.x + room;
	s.z = s.y + room;
	s.radius = s.z + room;
	memset(s.x, 0, 4 * room * sizeof *s.x);
	for (uint32_t cell = 0; cell < cells; cell++)
		s.frusta[cell] = cell_frustum(lists, matrix, cell);
	for (uint32_t i = 0; i < s.count; i++) {
		const stilb_scene_light *light = &lights[lists->lights[lists->everywhere_count + lists->ids[i]]];
		s.x[i] = light->position[0];
		s.y[i] = light->position[1];
		s.z[i] = light->position[2];
		s.radius[i] = light->reach;
	}
	return s;
}

static void stream_free(stream *s)
{
	free(s->x);
	free(s->visible);
	free(s->frusta);
}

#if defined(__x86_64__)
/* Tests spheres begin .. end - 1 eight at a time; a byte for each eight. */
__attribute__((target("avx2"))) static inline uint8_t *test_spheres(const stream *s, const stilb_frustum *frustum,
                                                                    uint32_t begin, uint32_t end, uint8_t *visible)
{
	__m256 plane[6][4];
	for (int p = 0; p < 6; p++) {
		plane[p][0] = _mm256_set1_ps(frustum->planes[p].x);
		plane[p][1] = _mm256_set1_ps(frustum->planes[p].y);
		plane[p][2] = _mm256_set1_ps(frustum->planes[p].z);
		plane[p][3] = _mm256_set1_ps(frustum->planes[p].distance);
	}
	for (uint32_t i = begin; i < end; i += 8) {
		__m256 x = _mm256_loadu_ps(s->x + i), y = _mm256_loadu_ps(s->y + i), z = _mm256_loadu_ps(s->z + i);
		__m256 least = _mm256_sub_ps(_mm256_setzero_ps(), _mm256_loadu_ps(s->radius + i));
		__m256 in = _mm256_castsi256_ps(_mm256_set1_epi32(-1));
		for (int p = 0; p < 6; p++) {
			__m256 sum = _mm256_add_ps(_mm256_mul_ps(x, plane[p][0]), _mm256_mul_ps(y, plane[p][1]));
			sum = _mm256_add_ps(_mm256_add_ps(sum, _mm256_mul_ps(z, plane[p][2])), plane[p][3]);
			in = _mm256_and_ps(in, _mm256_cmp_ps(sum, least, _CMP_GE_OQ));
		}
		*visible++ = (uint8_t)_mm256_movemask_ps(in);
	}
	return visible;
}

/* Each pair's sphere against its cell. */
__attribute__((target("avx2"))) static void cells_run(stream *s, const stilb_light_lists *lists)
{
	uint8_t *visible = s->visible;
	uint32_t cells = lists->columns * lists->rows * lists->slices;
	for (uint32_t cell = 0; cell < cells; cell++)
		if (lists->starts[cell] < lists->starts[cell + 1])
			visible = test_spheres(s, &s->frusta[cell], lists->starts[cell], lists->starts[cell + 1], visible);
}

/* All pairs' spheres against one frustum: what the tests alone take. */
__attribute__((target("avx2"))) static void stream_run(stream *s)
{
	test_spheres(s, &s->view, 0, s->count, s->visible);
}
#endif

/* ---- times ------------------------------------------------------------------------------------------------------- */

static uint64_t clock_ns(clockid_t clock)
{
	struct timespec now;
	clock_gettime(clock, &now);
	return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

/* CPU time of the busier of two threads, ns: so long it would take by the clock on a machine with nothing else to do.
 * */
static double build_ns(stilb_light_lists *lists, const stilb_light_grid *grid, const stilb_scene_light *lights,
                       uint32_t count, stilb_job_pool *pool)
{
	uint64_t own = clock_ns(CLOCK_THREAD_CPUTIME_ID), all = clock_ns(CLOCK_PROCESS_CPUTIME_ID);
	if (stilb_light_lists_build(lists, grid, lights, count, NULL, 0, pool, 0) != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
	own = clock_ns(CLOCK_THREAD_CPUTIME_ID) - own;
	all = clock_ns(CLOCK_PROCESS_CPUTIME_ID) - all;
	return (double)(all > 2 * own ? all - own : own);
}

static void require_same(const stilb_light_lists *a, const stilb_light_lists *b)
{
	size_t cells = (size_t)a->columns * a->rows * a->slices;
	if (a->id_count != b->id_count || memcmp(a->starts, b->starts, (cells + 1) * sizeof *a->starts) != 0 ||
	    memcmp(a->ids, b->ids, a->id_count * sizeof *a->ids) != 0)
		bench_child_fail("two threads make other lists than one");
}

/* The least of several times each, in turn. */
static void measure(const bench_child *child, const stilb_light_grid *grid, const stilb_scene_light *lights,
                    uint32_t count)
{
	stilb_job_pool *pool;
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	stilb_light_lists one_lists = {0}, two_lists = {0};
	desc.worker_count = 1;
	if (stilb_job_pool_create(&desc, &pool) != 0)
		bench_child_fail("no worker starts");
	build_ns(&one_lists, grid, lights, count, NULL);
	double one = (double)INFINITY, two = one, peer = one, stream_least = one, pairs = (double)one_lists.id_count;
	stream spheres = stream_make(&one_lists, lights, &grid->view_projection);
	uint64_t end = bench_child_now_ns() + (uint64_t)(child->seconds * 1e9);
	for (int i = 0; i < 2 || bench_child_now_ns() < end; i++) {
		one = fmin(one, build_ns(&one_lists, grid, lights, count, NULL));
		two = fmin(two, build_ns(&two_lists, grid, lights, count, pool));
#if defined(__x86_64__)
		if (stilb_cpu_widest_isa() >= STILB_ISA_AVX2) {
			uint64_t begin = clock_ns(CLOCK_THREAD_CPUTIME_ID);
			cells_run(&spheres, &one_lists);
			uint64_t middle = clock_ns(CLOCK_THREAD_CPUTIME_ID);
			stream_run(&spheres);
			peer = fmin(peer, (double)(middle - begin));
			stream_least = fmin(stream_least, (double)(clock_ns(CLOCK_THREAD_CPUTIME_ID) - middle));
		}
#endif
	}
	require_same(&one_lists, &two_lists);
	bench_child_metric("one", one * 1e-6);
	bench_child_metric("two", two * 1e-6);
	bench_child_metric("speedup", one / two);
	bench_child_metric("pairs", pairs);
	bench_child_metric("pair", one / pairs);
	if (isfinite(peer)) {
		bench_child_metric("peer", peer / pairs);
		bench_child_metric("ratio", one / peer);
		bench_child_metric("stream", stream_least / pairs);
	}
	const struct light_scratch *scratch = one_lists.scratch;
	size_t cells = (size_t)one_lists.columns * one_lists.rows * one_lists.slices;
	double content = (double)one_lists.light_count + (double)cells + 1.0 + pairs;
	double room = (double)scratch->light_capacity + (double)scratch->start_capacity + (double)scratch->id_capacity;
	bench_child_metric("memory", room * 4.0 / 1048576.0);
	bench_child_metric("room", room / content);
	stream_free(&spheres);
	stilb_light_lists_finish(&one_lists);
	stilb_light_lists_finish(&two_lists);
	stilb_job_pool_destroy(pool);
}

static void run(const bench_child *child, uint32_t count, bool octree)
{
	stilb_scene_light *lights = stilb_memory_alloc(count, sizeof *lights);
	if (!lights)
		bench_child_fail("no memory");
	stilb_light_grid grid = fill(lights, count);
	if (octree)
		lights_octree_measure(child, &grid, lights, count);
	else
		measure(child, &grid, lights, count);
	free(lights);
}

int main(int argc, char **argv)
{
	bench_child child = bench_child_args(argc, argv);
#define CASE(NAME, TITLE, LIGHTS)                                                                                      \
	if (strcmp(child.case_name, NAME) == 0) {                                                                          \
		run(&child, LIGHTS, false);                                                                                    \
		return 0;                                                                                                      \
	}
	LIGHTS_CASES(CASE)
#undef CASE
	if (strcmp(child.case_name, LIGHTS_FRAMES) == 0) {
		lights_frames_measure(&child);
		return 0;
	}
	if (strcmp(child.case_name, LIGHTS_FLOOR) == 0) {
		lights_floor_measure(&child);
		return 0;
	}
	if (strcmp(child.case_name, LIGHTS_OCTREE) != 0)
		return BENCH_CHILD_SKIP;
	run(&child, LIGHTS_OCTREE_COUNT, true);
	return 0;
}
