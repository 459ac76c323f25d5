/* The program stilb-bench-sim-here: the cases of sim_cases.h, not simulated but on this machine, to compare with what
 * the simulator says of it. Prints the median, least and most of several runs. */
#include "bench/harness/bench_child.h"
#include "bench/sim/sim_cases.h"
#include "jobs/job_sys.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { ROUNDS = 15 };

double sim_now(void)
{
	return (double)bench_child_now_ns();
}

void sim_work(double ns)
{
	static double rate; /* ticks in a nanosecond; threads that come here at first at the same time all measure it */
	if (rate == 0.0)
		rate = (double)job_sys_ticks_in(1u << 20) / (1u << 20);
	uint64_t begin = job_sys_ticks(), ticks = (uint64_t)(ns * rate);
	while (job_sys_ticks() - begin < ticks)
		;
}

void sim_sleep(double ns)
{
	struct timespec time = {.tv_nsec = (long)ns};
	nanosleep(&time, NULL);
}

void sim_lines_reset(void)
{
}

uint32_t sim_cpus(void)
{
	return bench_child_cpu_count();
}

void sim_run(const sim_machine *machine, uint32_t cpus, void (*main)(void *), void *data)
{
	(void)machine, (void)cpus;
	main(data);
}

static int compare(const void *a, const void *b)
{
	double x = *(const double *)a, y = *(const double *)b;
	return (x > y) - (x < y);
}

int main(int argc, char **argv)
{
	static const uint32_t threads[] = {1, 2, 4, 8};
	for (size_t i = 0; i < sim_case_count; i++)
		for (size_t t = 0; t < sizeof threads / sizeof *threads; t++) {
			double times[ROUNDS];
			if (argc > 1 && strcmp(argv[1], sim_cases[i].name) != 0)
				continue;
			sim_pool_threads = threads[t];
			for (int r = 0; r < ROUNDS; r++)
				times[r] = sim_case_run(&sim_cases[i], NULL, 0);
			qsort(times, ROUNDS, sizeof *times, compare);
			printf("here %u threads %-14s %10.4g %s [%.4g-%.4g]\n", threads[t], sim_cases[i].name, times[ROUNDS / 2],
			       sim_cases[i].unit, times[0], times[ROUNDS - 1]);
			fflush(stdout);
		}
	return 0;
}
