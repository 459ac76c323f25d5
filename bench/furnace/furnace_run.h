/* What the files of the suite `furnace`'s program share. */
#ifndef FURNACE_RUN_H
#define FURNACE_RUN_H

#include "bench/harness/bench_child.h"

#include "gi/gi_scene.h"

/* ---- numbers ----------------------------------------------------------------------------------------------------- */

/* Where random numbers come from. One experiment after the other, one run after the other: the simple ones just go
 * on. */
typedef struct furnace_numbers {
	const char *name;
	void (*seed)(uint32_t seed);
	void (*run)(uint32_t experiment, uint32_t run);    /* NULL: just goes on */
	void (*vertex)(uint32_t vertex, float numbers[3]); /* in [0, 1): two for a direction, one for the roulette */
} furnace_numbers;

/* By the name of the subject; NULL: there is none. */
const furnace_numbers *furnace_numbers_find(const char *name);

/* ---- a scene, and the threads that trace it ---------------------------------------------------------------------- */

typedef struct furnace_world {
	stilb_job_pool *pool;
	stilb_scene *scene;
	stilb_gi_scene *gi;
} furnace_world;

/* Ends the program with the reason when it cannot. */
furnace_world furnace_world_open(const char *name, uint32_t workers);
void furnace_world_close(furnace_world *world);

/* ---- the case equal-time ----------------------------------------------------------------------------------------- */

void furnace_equal_time(const bench_child *child);

#endif
