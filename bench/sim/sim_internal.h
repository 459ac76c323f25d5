/* What sim_core.c (threads, CPUs, kernel) does for sim_lines.c (memory). Times are in picoseconds. */
#ifndef SIM_INTERNAL_H
#define SIM_INTERNAL_H

#include "bench/sim/sim.h"

/* Memory of the simulated program: stacks, then heap. At a fixed address, so that hashes of addresses are the same in
 * every run. */
#define SIM_ARENA ((uintptr_t)1 << 44)
#define SIM_ARENA_SIZE ((size_t)1 << 29)
#define SIM_LINE 64

/* sim_core.c, which does not know of lines */
void sim_core_run(const sim_machine *machine, uint32_t cpus, void (*main)(void *), void *data); /* sim_run */
void sim_turn(uint64_t ahead); /* lets CPUs run that are behind the calling one by more than `ahead` */
uint64_t *sim_clock(void);     /* the CPU's, which the caller may advance */
void sim_count_transfer(void);
uintptr_t sim_arena_end(void); /* of the part that is in use */

#endif
