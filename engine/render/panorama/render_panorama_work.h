/*
 * render_panorama_work: a panorama that is being made, for the files of render_panorama. Not for others.
 */
#ifndef STILB_RENDER_PANORAMA_WORK_H
#define STILB_RENDER_PANORAMA_WORK_H

#include "numeric/numeric_prefilter.h"
#include "render/render_panorama.h"

#define PANORAMA_ACROSS 512u /* cells */
#define PANORAMA_DOWN 256u
#define PANORAMA_VALUE_MAX 1e15f             /* brighter texels count as this, as for rays */
#define PANORAMA_EDGES (2 * PANORAMA_ACROSS) /* edges of a row's cells, half a turn more at each end */

typedef float panorama_v4 __attribute__((vector_size(16)));
typedef int32_t panorama_i4 __attribute__((vector_size(16)));

/* Sums along a row of cells, of one colour, from half a turn before its first cell to half a turn behind its last: of
 * the light, and of the light times the cosine and the sine of its longitude, up to the edge e; and the light of the
 * cell behind it. Edges with an even number come first ([0]), then the odd ones, so that every second lies beside the
 * one before: columns of the table are two cells wide. */
typedef struct panorama_sums {
	float light[2][PANORAMA_EDGES / 2], cosine[2][PANORAMA_EDGES / 2], sine[2][PANORAMA_EDGES / 2],
		cell[2][PANORAMA_EDGES / 2];
} panorama_sums;

struct render_panorama_work {
	stilb_image map; /* its pixels are valid during a call of render_panorama_update alone */
	uint64_t key;
	uint32_t stage, row; /* the next of its rows */
	render_panorama_table *light;
	uint16_t (*texels)[4];  /* [height][width] */
	uint32_t width, height; /* of the texels */
	uint32_t lamp_count;
	render_panorama_lamp lamps[RENDER_PANORAMA_LAMPS];
	render_panorama_around around;
	float (*cells)[PANORAMA_ACROSS][3];      /* [DOWN] L dw; L from the gloss's first stage on */
	panorama_sums (*sums)[3];                /* [DOWN] */
	uint16_t (*cube)[4];                     /* [RENDER_PANORAMA_CUBE] */
	uint16_t (*dfg)[RENDER_PANORAMA_DFG][2]; /* render_panorama's */
	bool dfg_shown;                          /* it is complete */
	uint64_t cells_key[2];                   /* of the cache, from the gloss's first stage on */
	bool kept;                               /* cube and dfg came from the cache: no stage of the gloss is left */
	stilb_numeric_prefilter *gloss;
};

/* Values of the panorama as they are used: NaN and values below 0 are 0, large ones have a limit. */
static inline panorama_v4 panorama_valid(panorama_v4 values)
{
	panorama_v4 zero = {0.0f, 0.0f, 0.0f, 0.0f},
				most = {PANORAMA_VALUE_MAX, PANORAMA_VALUE_MAX, PANORAMA_VALUE_MAX, PANORAMA_VALUE_MAX};
	panorama_i4 positive = values > zero, beyond = values > most;
	values = (panorama_v4)((panorama_i4)values & positive); /* a NaN is 0 */
	return (panorama_v4)(((panorama_i4)values & ~beyond) | ((panorama_i4)most & beyond));
}

static inline const float *panorama_texel(const stilb_image *map, uint32_t x, uint32_t y)
{
	return (const float *)map->pixels + ((size_t)y * map->width + x) * map->channels;
}

/* The share of texel number i of `texels` along a side that lies in cell number c of `cells` along it, begin to end, as
 * numbers of 0..1 along the side. Empty where they do not meet: end <= begin. */
typedef struct panorama_overlap {
	double begin, end;
} panorama_overlap;

static inline panorama_overlap panorama_overlap_of(uint32_t i, uint32_t texels, uint32_t c, uint32_t cells)
{
	double low = (double)i / texels, high = (i + 1.0) / texels, from = (double)c / cells, to = (c + 1.0) / cells;
	return (panorama_overlap){low > from ? low : from, high < to ? high : to};
}

/* render_panorama_ambient.c, a stage of one row: sets `around` by the cells without the lamps. */
void render_panorama_find_ambient(render_panorama_work *work);

/* render_panorama_light.c, stages of the work: rows [begin, end) of it. */

/* One row: finds the lamps, and takes them out of the cells. */
void render_panorama_find_lamps(render_panorama_work *work);
void render_panorama_sum_rows(render_panorama_work *work, uint32_t begin, uint32_t end);  /* of DOWN */
void render_panorama_fill_rows(render_panorama_work *work, uint32_t begin, uint32_t end); /* of RENDER_PANORAMA_ROWS */

/* render_panorama_cache.c: the cube and the table by what they are made of, the cells without the lamps, in the folder
 * stilb/panoramas (base_cache.h). Sets cells_key and reads both; false: they are not there, and of any values. */
bool render_panorama_cache_find(render_panorama_work *work);
/* Keeps them, complete. */
void render_panorama_cache_keep(const render_panorama_work *work);

/* render_panorama_gloss.c, stages of the work after those: the cells' radiance, the cube's stages, the table. */
#define PANORAMA_GLOSS_STAGES (STILB_NUMERIC_PREFILTER_STAGES + 2u)
/* Of a work with cells and light. False: no memory. */
bool render_panorama_gloss_begin(render_panorama_work *work);
/* The rows of a stage, 0 .. PANORAMA_GLOSS_STAGES - 1, and about what one costs, in texels read. */
uint32_t render_panorama_gloss_rows(const render_panorama_work *work, uint32_t stage, double *cost);
void render_panorama_gloss_run(render_panorama_work *work, uint32_t stage, uint32_t begin, uint32_t end);
void render_panorama_gloss_end(render_panorama_work *work);

#endif
