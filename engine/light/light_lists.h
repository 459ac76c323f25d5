/* The lights of a view and the cells that they reach, on the way to lists. For this folder and its tests. */
#ifndef LIGHT_LISTS_H
#define LIGHT_LISTS_H

#include "light/light_internal.h"

#include <stdatomic.h>

/* What is found of a chunk of candidates. */
typedef struct light_found {
	uint32_t count, everywhere_count; /* lights that reach a part of the view, and all of it */
	uint32_t gap;                     /* places of the chunks before it that are empty */
} light_found;

/* Lights that reach a part of the view, an array for each component, in the scene's order. Candidates are worked on in
 * chunks; what is found of a chunk stands from its first place on, with a gap behind it. */
typedef struct light_reaching {
	float *x, *y, *w, *depth, *radius; /* of the sphere: clip coordinates and depth of its centre; metres */
	uint8_t *first_slice, *last_slice;
	light_cone *cones;
	uint32_t *number;     /* the own place, with LIGHT_WITH_CONE */
	uint32_t *index;      /* in the scene */
	uint32_t *everywhere; /* those that reach everywhere: indices in the scene */
	light_found *chunks;
	uint32_t chunk_count, count, everywhere_count, capacity;
} light_reaching;

#define LIGHT_BAND_ROWS 8u  /* most rows of a band */
#define LIGHT_UNIT_BANDS 4u /* most bands of a unit */

/* One row of a slice. */
typedef struct light_row {
	uint32_t *numbers; /* [count] the lights that reach it, ascending */
	light_span *spans; /* [count] what they reach of it */
	uint32_t count;
} light_row;

/* Some rows of one slice, whose cells lie side by side. */
typedef struct light_band {
	light_row rows[LIGHT_BAND_ROWS];
	uint32_t capacity; /* of each row; they share one block of memory */
	uint64_t id_count; /* cells of all spans */
	uint64_t first_id; /* in the lists */
} light_band;

struct light_scratch {
	light_view view;
	light_reaching reaching;
	light_band *bands; /* [slices][bands of the view] */
	uint32_t band_capacity;
	uint32_t *counters; /* [slices][rows][columns + 1] lengths of the lists */
	size_t counter_capacity;
	float *weak; /* of light_prune: for each light of the lists its place, and how far away it is weak */
	uint32_t weak_capacity;
	uint32_t light_capacity, start_capacity, id_capacity; /* of the lists' arrays */
	const light_kernels *kernels;
	uint32_t serial_below; /* LIGHT_SERIAL_BELOW; tests change it */
};

/* Least work for which several threads are used: less takes no longer than waking one. Counted in lights times bands;
 * the cells of a band take as long as so many lights. */
#define LIGHT_SERIAL_BELOW 8192u
#define LIGHT_CELLS_WORK 64u

/* What a build is asked for. */
typedef struct light_build {
	struct light_scratch *scratch;
	stilb_light_lists *lists;
	const stilb_light_grid *grid;
	const stilb_scene_light *lights;
	const uint32_t *candidates;
	uint32_t count;    /* of candidates */
	double irradiance; /* what a lamp without an end may send where it ends; 0: it does not */
	double prunable;   /* what lights may send together, W m^-2, that light_prune leaves out of a cell */
	stilb_job_pool *pool;
	uint32_t worker;
	atomic_bool failed; /* relaxed: no memory; read after the loop, which orders it */
} light_build;

/* Fills scratch->reaching. */
stilb_result light_reaching_find(light_build *build);

/* Fills the bands and the counters. */
stilb_result light_bands_fill(light_build *build);

/* Calls fn for slices of 0 .. count - 1; on the pool if there is enough to do. */
void light_spread(light_build *build, uint32_t count, stilb_job_range_fn *fn);

/* Leaves weak lights out of the lists, which are written. STILB_ERROR_MEMORY. */
stilb_result light_prune(light_build *build);

void light_bands_finish(struct light_scratch *scratch);
void light_reaching_finish(light_reaching *reaching);

/* Bands of a slice. */
static inline uint32_t light_bands(const light_view *view)
{
	return (view->rows + LIGHT_BAND_ROWS - 1) / LIGHT_BAND_ROWS;
}

/* Units of a slice: as few bands as evenly as can be. */
static inline uint32_t light_units(const light_view *view)
{
	return (light_bands(view) + LIGHT_UNIT_BANDS - 1) / LIGHT_UNIT_BANDS;
}

/* light_slab.inverse_near and _far of a slice. */
static inline void light_slab_inverses(const light_view *view, uint32_t slice, float *near, float *far)
{
	float least = 1.0f / view->depths.near_z[slice];
	*near = view->perspective && least < LIGHT_INVERSE_MAX ? least : LIGHT_INVERSE_MAX;
	*far = view->perspective ? 1.0f / view->depths.far_z[slice] : -LIGHT_INVERSE_MAX;
}

/* The first row of a band. */
static inline uint32_t light_band_row(const light_view *view, uint32_t band)
{
	uint32_t row = band * LIGHT_BAND_ROWS;
	return row < view->rows ? row : view->rows;
}

/* The counters of a row. */
static inline uint32_t *light_counters(const struct light_scratch *scratch, uint32_t slice, uint32_t row)
{
	const light_view *view = &scratch->view;
	return scratch->counters + ((size_t)slice * view->rows + row) * (view->columns + 1);
}

#endif
