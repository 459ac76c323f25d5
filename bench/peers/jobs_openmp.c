/* OpenMP as a subject of the suite `jobs`. Tasks need a parallel region, so every spawn opens one. OpenMP's threads
 * spin between regions. */
#include "bench/jobs/jobs_subject.h"

#include <omp.h>
#include <stddef.h>

static bool open(uint32_t threads, bool steals)
{
	(void)steals;
	omp_set_dynamic(0);
	omp_set_num_threads((int)threads);
	return true;
}

static void close(void)
{
}

static void spawn(jobs_fn *fn, char *data, uint32_t count)
{
#pragma omp parallel
#pragma omp single
	for (uint32_t i = 0; i < count; i++) {
#pragma omp task firstprivate(i)
		fn(data + i, 0);
	}
}

static void array(jobs_range_fn *fn, void *context, uint32_t count)
{
#pragma omp parallel for schedule(dynamic, 1)
	for (uint32_t i = 0; i < count; i++)
		fn(i, i + 1, 0, context);
}

static void join_static(jobs_range_fn *fn, void *context, uint32_t count)
{
#pragma omp parallel for schedule(static)
	for (uint32_t i = 0; i < count; i++)
		fn(i, i + 1, 0, context);
}

static void loop_guided(jobs_range_fn *fn, void *context, uint32_t count)
{
#pragma omp parallel for schedule(guided)
	for (uint32_t i = 0; i < count; i++)
		fn(i, i + 1, 0, context);
}

static void range_guided(jobs_range_64_fn *fn, void *context, uint64_t count)
{
#pragma omp parallel for schedule(guided)
	for (uint64_t i = 0; i < count; i++)
		fn(i, i + 1, 0, context);
}

static void range_static(jobs_range_64_fn *fn, void *context, uint64_t count)
{
#pragma omp parallel for schedule(static)
	for (uint64_t i = 0; i < count; i++)
		fn(i, i + 1, 0, context);
}

enum { TILE = 64 };

static uint32_t least(uint32_t a, uint32_t b)
{
	return a < b ? a : b;
}

static void tiles_dynamic(jobs_tile_fn *fn, void *context, uint32_t width, uint32_t height)
{
#pragma omp parallel for collapse(2) schedule(dynamic, 1)
	for (uint32_t y = 0; y < height; y += TILE)
		for (uint32_t x = 0; x < width; x += TILE)
			fn(x, least(x + TILE, width), y, least(y + TILE, height), 0, context);
}

/* Rows, as in a program that knows no tiles. */
static void tiles_rows(jobs_tile_fn *fn, void *context, uint32_t width, uint32_t height)
{
#pragma omp parallel for schedule(static)
	for (uint32_t y = 0; y < height; y++)
		fn(0, width, y, y + 1, 0, context);
}

static double reduce(jobs_fold_fn *fn, void *context, uint64_t count)
{
	double sum = 0.0;
#pragma omp parallel for reduction(+ : sum) schedule(static)
	for (uint64_t i = 0; i < count; i += JOBS_REDUCE_GRAIN)
		fn(i, count - i < JOBS_REDUCE_GRAIN ? count : i + JOBS_REDUCE_GRAIN, &sum, context);
	return sum;
}

static uint64_t fib_task(uint32_t n)
{
	if (n < 2)
		return n;
	uint64_t a;
#pragma omp task shared(a)
	a = fib_task(n - 1);
	uint64_t b = fib_task(n - 2);
#pragma omp taskwait
	return a + b;
}

static uint64_t fib(uint32_t n)
{
	uint64_t result = 0;
#pragma omp parallel
#pragma omp single
	result = fib_task(n);
	return result;
}

static const jobs_subject openmp = {.name = "openmp",
                                    .open = open,
                                    .close = close,
                                    .spawn = spawn,
                                    .array = array,
                                    .join = array,
                                    .loop = loop_guided,
                                    .range = range_guided,
                                    .tiles = tiles_dynamic,
                                    .reduce = reduce,
                                    .fib = fib};
static const jobs_subject openmp_static = {.name = "openmp-static",
                                           .open = open,
                                           .close = close,
                                           .join = join_static,
                                           .loop = join_static,
                                           .range = range_static,
                                           .tiles = tiles_rows};
const jobs_subject *const jobs_subjects[] = {&openmp, &openmp_static, NULL};
