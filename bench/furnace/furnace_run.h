/* furnace_run: shared by the files of the program of the suite `furnace`. Errors end the program. [main-thread] */
#ifndef FURNACE_RUN_H
#define FURNACE_RUN_H

#include "bench/harness/bench_child.h"

#include "gi/gi_scene.h"

/* ---- numbers ----------------------------------------------------------------------------------------------------- */

/* A source of random numbers. It is told which numbers are asked for: those of a vertex of a path (run) of an
 * experiment (FURNACE_RUNS paths). Generators with a single sequence ignore that and continue their sequence. */
typedef struct furnace_numbers {
	const char *name;
	void (*seed)(uint32_t seed);
	void (*run)(uint32_t experiment, uint32_t run);    /* called when a path begins; NULL: not needed */
	void (*vertex)(uint32_t vertex, float numbers[3]); /* in [0, 1): two for a direction, one for the roulette */
} furnace_numbers;

/* The source with the subject's name, or NULL. */
const furnace_numbers *furnace_numbers_find(const char *name);

/* ---- a scene, and the threads that trace it ---------------------------------------------------------------------- */

typedef struct furnace_world {
	stilb_job_pool *pool;
	stilb_scene *scene;
	stilb_gi_scene *gi;
} furnace_world;

/* Opens the built-in scene `name`. workers: threads besides the caller. */
furnace_world furnace_world_open(const char *name, uint32_t workers);
void furnace_world_close(furnace_world *world);

/* ---- the case equal-time ----------------------------------------------------------------------------------------- */

void furnace_equal_time(const bench_child *child);

#endif
