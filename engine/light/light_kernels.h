/*
 * The innermost loops of light lists: a table of functions for each instruction set. All tables give the same results,
 * bit for bit: float operations in the order of light_scalar.c, without fused multiply-add. Only light_avx2.c and
 * light_avx512.c are compiled for more than the baseline of the architecture.
 *
 * Space is that of clip coordinates: a point is its x, y, w there and its depth. The signed distance of a point from
 * the plane between two columns or rows is x * inverse - w * offset, metres, positive towards the later ones. A sphere
 * that only partly lies on the inner side of a plane is replaced by the smaller sphere around the circle in which it
 * meets the plane, if its centre is outside: that one holds all of the sphere that is inside. Source: Persson, Olsson,
 * "Practical Clustered Deferred and Forward Shading" (2013).
 */
#ifndef LIGHT_KERNELS_H
#define LIGHT_KERNELS_H

#include "base/base.h"
#include "light/light.h"

#define LIGHT_BLOCK 8u /* cells on a side of a block, whose cells are a mask's bits */
#define LIGHT_BLOCK_CELLS (LIGHT_BLOCK * LIGHT_BLOCK)
#define LIGHT_CHUNK 512u              /* lights that are worked on together; a multiple of LIGHT_LANES */
#define LIGHT_LANES 16u               /* of the widest vector; kernels write up to so many elements more */
#define LIGHT_SQUARE_GROWTH 1.000002f /* of a squared radius: covers the rounding of r^2 - e^2 */

/* Planes between columns or rows. */
typedef struct light_planes {
	float *inverse, *offset; /* [count of columns or rows + 1, padded by LIGHT_LANES with the last] */
	float *x, *w;            /* of rows: change of clip x and w for one metre along the plane's normal */
} light_planes;

/* The part of the view that holds the cells of one slice and of LIGHT_BLOCK rows. */
typedef struct light_band {
	const light_planes *rows;
	uint32_t slice, first_row, end_row; /* rows first_row .. end_row - 1 */
	float near_z, far_z;                /* depths between which the slice lies */
	float along[3];                     /* change of clip x, y and w for one metre along the view */
} light_band;

/* A chunk of lights, an array for each component. */
typedef struct light_chunk {
	const float *x, *y, *w, *depth, *radius; /* padded to a multiple of LIGHT_LANES with lights of no slice */
	const uint8_t *first_slice, *last_slice; /* of the slices that the light reaches; first > last: none */
	uint32_t count;
} light_chunk;

/* Those lights of a chunk that reach a band. */
typedef struct light_picked {
	/* The sphere around what of the light's sphere is in the slice. */
	float x[LIGHT_CHUNK + LIGHT_LANES], y[LIGHT_CHUNK + LIGHT_LANES], w[LIGHT_CHUNK + LIGHT_LANES];
	float square[LIGHT_CHUNK + LIGHT_LANES]; /* squared radius */
	/* The sphere around what is in the band. */
	float band_x[LIGHT_CHUNK + LIGHT_LANES], band_w[LIGHT_CHUNK + LIGHT_LANES], band_radius[LIGHT_CHUNK + LIGHT_LANES];
	uint32_t at[LIGHT_CHUNK + LIGHT_LANES]; /* its place in the chunk */
} light_picked;

typedef struct light_kernels {
	/* Writes the lights that reach the band, ascending, and returns their number. */
	uint32_t (*pick)(const light_band *band, const light_chunk *chunk, light_picked *picked);
	/* Of picked[0 .. count - 1], writes the places of those that reach columns first .. end - 1, and returns their
	 * number. */
	uint32_t (*columns)(const light_picked *picked, uint32_t count, const light_planes *columns, uint32_t first,
	                    uint32_t end, uint32_t *places);
	/* For each of count places: which cells the light reaches of the block of the band's rows and the columns from
	 * first_column on, bit column + 8 * row. Columns and rows that the view lacks have any bits. */
	void (*cells)(const light_band *band, const light_picked *picked, const uint32_t *places, uint32_t count,
	              const light_planes *columns, uint32_t first_column, uint64_t *masks);
	/* Adds to each cell's counter the number of masks that have it. */
	void (*count)(const uint64_t *masks, uint32_t count, uint32_t counters[LIGHT_BLOCK_CELLS]);
	/* Appends each light to the lists of its cells: cursors are the places in ids where each cell's list goes on. */
	void (*fill)(const uint64_t *masks, const uint32_t *lights, uint32_t count, uint32_t cursors[LIGHT_BLOCK_CELLS],
	             uint32_t *ids);
} light_kernels;

extern const light_kernels light_kernels_scalar, light_kernels_avx2, light_kernels_avx512;

/* The table for an instruction set, which this CPU must have. */
const light_kernels *light_kernels_for(stilb_isa isa);

#endif
