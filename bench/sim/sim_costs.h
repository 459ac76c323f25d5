/* What a machine costs as a text file: stilb-bench-sim-here --costs measures and writes it, stilb-bench-sim --costs
 * FILE simulates that machine. Lines "name number", with the names of sim_machine's members; # begins a comment. */
#ifndef SIM_COSTS_H
#define SIM_COSTS_H

#include "bench/sim/sim.h"

#include <stdio.h>

/* Fills all but name and title. Each member must be there once. False after a line on stderr that names the file, the
 * line and what is wrong. */
bool sim_costs_read(sim_machine *machine, const char *path);

void sim_costs_write(FILE *out, const sim_machine *machine);

/* Measures the machine that this program runs on, as far as CPUs go that it may use: what they share by the kernel's
 * account, and what lines, instructions and system calls cost. Threads are pinned; on a busy machine costs are too
 * high.
 * What is not measured stays as it is: sleep, timeslice, block and function. False, after a line on stderr, if threads
 * cannot be created. Takes a second or two. */
bool sim_costs_measure(sim_machine *machine);

#endif
