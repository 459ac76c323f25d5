/* What the simulator measures: a case runs the job system on a machine and returns one number. */
#ifndef SIM_CASES_H
#define SIM_CASES_H

#include "bench/sim/sim.h"

typedef struct sim_case {
	const char *name;
	const char *title;
	const char *unit;
	void (*run)(void *result); /* the first thread; stores a double */
} sim_case;

extern const sim_case sim_cases[];
extern const size_t sim_case_count;

/* A pool has this many threads, the owner included; 0: one for each CPU of the simulation. */
extern uint32_t sim_pool_threads;

/* Runs the case on so many CPUs. */
double sim_case_run(const sim_case *which, const sim_machine *machine, uint32_t cpus);

#endif
