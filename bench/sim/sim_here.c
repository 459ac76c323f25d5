/* The program stilb-bench-sim-here: the cases of sim_cases.h, not simulated but on this machine, to compare with what
 * the simulator says of it. Prints the median, least and most of several runs with 1, 2, 4, ... threads, up to 8 or one
 * for each CPU. */
#include "bench/harness/bench_child.h"
#include "bench/sim/sim_cases.h"
#include "bench/sim/sim_costs.h"
#include "game/cli/flags.h"
#include "jobs/job_sys.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { ROUNDS_MAX = 1000 };

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

typedef struct options {
	const char *name; /* of a case; NULL: all */
	uint64_t rounds;
	bool costs;
} options;

static void run_case(const options *o, const sim_case *which, uint32_t threads)
{
	static double times[ROUNDS_MAX];
	sim_pool_threads = threads;
	for (uint64_t r = 0; r < o->rounds; r++)
		times[r] = sim_case_run(which, NULL, 0);
	qsort(times, o->rounds, sizeof *times, compare);
	printf("here %2u threads %-14s %10.4g %s [%.4g-%.4g]\n", threads, which->name, times[o->rounds / 2], which->unit,
	       times[0], times[o->rounds - 1]);
	fflush(stdout);
}

/* What a machine costs, with those of the table's `here` for what is not measured. */
static int print_costs(void)
{
	sim_machine machine = sim_machines[0];
	for (size_t i = 0; i < sim_machine_count; i++)
		if (strcmp(sim_machines[i].name, "here") == 0)
			machine = sim_machines[i];
	if (!sim_costs_measure(&machine))
		return 1;
	sim_costs_write(stdout, &machine);
	return 0;
}

int main(int argc, char **argv)
{
	options o = {.rounds = 15};
	const flag flags[] = {
		{"--case", FLAG_TEXT, &o.name, "NAME", "one case (all)", 0, 0, NULL},
		{"--rounds", FLAG_NUMBER, &o.rounds, "N", "runs of each case, of which the median counts (15)", 1, ROUNDS_MAX,
	     NULL},
		{"--costs", FLAG_SWITCH, &o.costs, NULL, "measure what this machine costs instead, for stilb-bench-sim --costs",
	     0, 0, NULL},
	};
	size_t count = sizeof flags / sizeof *flags;
	flags_result parsed = flags_parse(flags, count, argc - 1, argv + 1);
	if (parsed == FLAGS_HELP)
		flags_print(flags, count);
	if (parsed != FLAGS_OK)
		return parsed == FLAGS_HELP ? 0 : 2;
	if (o.costs)
		return print_costs();
	bool found = false;
	for (size_t i = 0; i < sim_case_count; i++)
		for (uint32_t threads = 1; threads <= 8 || threads <= sim_cpus(); threads *= 2)
			if (!o.name || strcmp(o.name, sim_cases[i].name) == 0) {
				run_case(&o, &sim_cases[i], threads);
				found = true;
			}
	if (!found)
		fprintf(stderr, "stilb-bench-sim-here: --case: there is no %s\n", o.name);
	return found ? 0 : 2;
}
