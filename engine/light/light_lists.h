/* The lights of a view and the cells that they reach, on the way to lists. For this folder and its tests. */
#ifndef LIGHT_LISTS_H
#define LIGHT_LISTS_H

#include "light/light_internal.h"

#include <stdatomic.h>

/* Lights that reach a part of the view, an array for each component, in the scene's order. */
typedef struct light_reaching {
	float *x, *y, *w, *depth, *radius; /* of the sphere: clip coordinates and depth of its centre; metres */
	uint8_t *first_slice, *last_slice;
	light_cone *cones;
	uint32_t *index; /* in the scene */
	uint32_t count, capacity;
} light_reaching;

/* Some masks of one block, one after the other. */
typedef struct light_segment {
	uint32_t block; /* of the unit, from the left */
	uint32_t count;
} light_segment;

/* The cells of one slice and LIGHT_BLOCK rows: what one job works on. Its blocks lie side by side. */
typedef struct light_unit {
	uint64_t *masks;  /* [count] which cells of a block a light reaches; never 0; in each block the lights ascend */
	uint32_t *lights; /* [count] */
	light_segment *segments;
	uint32_t count, capacity, segment_count, segment_capacity;
	uint64_t id_count; /* all bits of all masks */
	uint64_t first_id; /* in the lists */
	uint32_t longest;  /* list */
} light_unit;

struct light_scratch {
	light_view view;
	light_reaching reaching;
	uint32_t *everywhere;                        /* [capacity] in chunks, as reaching while it is filled */
	uint32_t *chunk_reaching, *chunk_everywhere; /* how many of each chunk of candidates reach a part, and all */
	light_unit *units;
	uint32_t unit_capacity;
	uint32_t *counters; /* [units][blocks][LIGHT_BLOCK_CELLS] lengths of the lists */
	size_t counter_capacity;
	uint32_t light_capacity, start_capacity, id_capacity; /* of the lists' arrays */
	const light_kernels *kernels;
	uint32_t serial_below; /* LIGHT_SERIAL_BELOW; tests change it */
};

/* Least number of lights times units for which several threads are used: less takes no longer than waking one. */
#define LIGHT_SERIAL_BELOW 8192u

/* What a build is asked for. */
typedef struct light_build {
	struct light_scratch *scratch;
	stilb_light_lists *lists;
	const stilb_light_grid *grid;
	const stilb_scene_light *lights;
	const uint32_t *candidates;
	uint32_t count;        /* of candidates */
	double irradiance;     /* what a light may send where it is left out */
	bool without_physical; /* lights that reach everywhere are only counted */
	stilb_job_pool *pool;
	uint32_t worker;
	atomic_bool failed; /* relaxed: no memory; read after the loop, which orders it */
} light_build;

/* Fills scratch->reaching, lists->lights, light_count and everywhere_count. */
stilb_result light_reaching_find(light_build *build);

/* Fills the units' masks and counters. */
stilb_result light_units_fill(light_build *build);

/* Calls fn for slices of 0 .. count - 1; on the pool if there is enough to do. */
void light_spread(light_build *build, uint32_t count, stilb_job_range_fn *fn);

void light_units_finish(struct light_scratch *scratch);
void light_reaching_finish(struct light_scratch *scratch);

/* Units and blocks of a view. */
static inline uint32_t light_bands(const light_view *view)
{
	return (view->rows + LIGHT_BLOCK - 1) / LIGHT_BLOCK;
}

static inline uint32_t light_blocks(const light_view *view)
{
	return (view->columns + LIGHT_BLOCK - 1) / LIGHT_BLOCK;
}

static inline uint32_t light_units(const light_view *view)
{
	return light_bands(view) * view->slices;
}

#endif
