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
                                    .fib = fib};
static const jobs_subject openmp_static = {
	.name = "openmp-static", .open = open, .close = close, .join = join_static, .loop = join_static};
const jobs_subject *const jobs_subjects[] = {&openmp, &openmp_static, NULL};
