/* The program stilb-bench-sim: the cases of sim_cases.h on machines and numbers of CPUs of the caller's choice. */
#include "bench/sim/sim_costs.h"
#include "bench/sim/sim_plot.h"
#include "game/cli/flags.h"

#include <stdio.h>
#include <string.h>

static const char *const all = "all";

typedef struct options {
	const char *machine, *name, *before, *plot, *costs;
	uint64_t cores, threads;
	bool json, lines;
} options;

static sim_points points;

static void print(const options *o, const sim_machine *machine, const sim_case *which, uint32_t cpus)
{
	double value = sim_case_run(which, machine, cpus);
	if (o->json)
		printf("%s\n{\"machine\":\"%s\",\"cpus\":%u,\"case\":\"%s\",\"unit\":\"%s\",\"value\":%.6g}",
		       points.count == 0 ? "[" : ",", machine->name, cpus, which->name, which->unit, value);
	else
		printf("%-9s %4u %-14s %10.4g %s\n", machine->name, cpus, which->name, value, which->unit);
	fflush(stdout);
	sim_points_add(&points, (sim_point){machine, which, cpus, value, false});
	if (o->lines)
		sim_lines_print(12);
}

static void run_cases(const options *o, const sim_machine *machine, uint32_t cpus)
{
	for (size_t i = 0; i < sim_case_count; i++)
		if (strcmp(o->name, all) == 0 || strcmp(sim_cases[i].name, o->name) == 0)
			print(o, machine, &sim_cases[i], cpus);
}

static void run_machine(const options *o, const sim_machine *machine)
{
	if (o->cores > 0) {
		run_cases(o, machine, (uint32_t)o->cores);
		return;
	}
	for (uint32_t cpus = 2; cpus <= SIM_CPUS_MAX; cpus *= 2)
		run_cases(o, machine, cpus);
}

int main(int argc, char **argv)
{
	options o = {.machine = all, .name = all};
	const flag flags[] = {
		{"--machine", FLAG_TEXT, &o.machine, "NAME", "xeon, epyc, graviton, here, or all: the first three (all)", 0, 0,
	     NULL},
		{"--costs", FLAG_TEXT, &o.costs, "FILE",
	     "a machine that stilb-bench-sim-here --costs has measured, in place of these", 0, 0, NULL},
		{"--cores", FLAG_NUMBER, &o.cores, "N", "CPUs, 2..256 (2, 4, ... 256)", 2, SIM_CPUS_MAX, NULL},
		{"--threads", FLAG_NUMBER, &o.threads, "N", "threads of the pool, 1..257 (one for each CPU)", 1, 257, NULL},
		{"--case", FLAG_TEXT, &o.name, "NAME", "one case (all)", 0, 0, NULL},
		{"--plot", FLAG_TEXT, &o.plot, "FILE", "draw the results as a PNG", 0, 0, NULL},
		{"--before", FLAG_TEXT, &o.before, "FILE", "what an earlier run printed, to be drawn as well", 0, 0, NULL},
		{"--json", FLAG_SWITCH, &o.json, NULL, "an array of objects", 0, 0, NULL},
		{"--lines", FLAG_SWITCH, &o.lines, NULL, "also print the cache lines that cost most", 0, 0, NULL},
	};
	size_t count = sizeof flags / sizeof *flags;
	flags_result parsed = flags_parse(flags, count, argc - 1, argv + 1);
	if (parsed == FLAGS_HELP)
		flags_print(flags, count);
	if (parsed != FLAGS_OK)
		return parsed == FLAGS_HELP ? 0 : 2;
	static sim_machine measured = {.name = "measured", .title = "a machine that was measured"};
	if (o.costs && (strcmp(o.machine, all) != 0 || o.plot)) {
		fprintf(
			stderr,
			"stilb-bench-sim: --costs: goes with neither --machine nor --plot, which are for the table's machines\n");
		return 2;
	}
	if (o.costs && !sim_costs_read(&measured, o.costs))
		return 2;
	const sim_machine *machine = sim_machine_named(o.machine);
	if (!machine && strcmp(o.machine, all) != 0) {
		fprintf(stderr, "stilb-bench-sim: --machine: there is no %s\n", o.machine);
		return 2;
	}
	sim_pool_threads = (uint32_t)o.threads;
	if (o.costs)
		run_machine(&o, &measured);
	for (size_t i = 0; i < sim_machine_count && !o.costs; i++)
		if (machine ? machine == &sim_machines[i] : strcmp(sim_machines[i].name, "here") != 0)
			run_machine(&o, &sim_machines[i]);
	if (o.json)
		printf("\n]\n");
	bool good = !o.before || sim_points_read(&points, o.before);
	return good && (!o.plot || sim_plot(&points, o.plot)) ? 0 : 1;
}
