/* The numbers of workers that the suite `threads` sweeps over. */
#include "bench/harness/bench_internal.h"
#include "bench/threads/bench_threads.h"

#define MAX_WORKERS 256u /* STILB_JOB_MAX_WORKERS */

uint32_t bench_threads_counts[BENCH_THREADS_MAX_COUNTS];
size_t bench_threads_count;
uint64_t bench_threads_hashes[3];
static char names[BENCH_THREADS_MAX_COUNTS][32];

static uint32_t least(uint32_t a, uint32_t b)
{
	return a < b ? a : b;
}

uint32_t bench_threads_fitting(void)
{
	uint32_t cpus = bench_cpu_count();
	return least(cpus > 1 ? cpus - 1 : 1, MAX_WORKERS);
}

uint32_t bench_threads_too_many(void)
{
	return least(2 * bench_cpu_count(), MAX_WORKERS);
}

const char *bench_threads_name(uint32_t workers)
{
	for (size_t i = 0; i < bench_threads_count; i++)
		if (bench_threads_counts[i] == workers)
			return names[i];
	return "";
}

static void add_count(uint32_t workers)
{
	if (bench_threads_count < BENCH_THREADS_MAX_COUNTS &&
	    (bench_threads_count == 0 || workers > bench_threads_counts[bench_threads_count - 1])) {
		snprintf(names[bench_threads_count], sizeof names[0], BENCH_THREADS_OURS "%u", workers);
		bench_threads_counts[bench_threads_count++] = workers;
	}
}

/* Chooses 0 to twice the number of CPUs; on more than 4 CPUs only powers of two and a few around and above the number
 * of CPUs. */
void bench_threads_choose_counts(void)
{
	uint32_t fitting = bench_threads_fitting(), most = bench_threads_too_many();
	if (most < 9) {
		for (uint32_t workers = 0; workers <= most; workers++)
			add_count(workers);
		return;
	}
	add_count(0);
	for (uint32_t workers = 1; workers < fitting; workers *= 2)
		add_count(workers);
	add_count(fitting);
	add_count(fitting + 1);
	add_count(least(fitting + fitting / 2, most));
	add_count(most);
}
