/*
 * light_reached: a view's cells and the lights that reach it, as a compute program reads them that makes the lists of
 * light.h (render's shaders/deferred/cells.glsl). Inside the engine.
 *
 * What the program does is what light_scalar.h does for one light and one row of a slice, in the same order of float
 * operations. So on a device that divides and takes roots as IEEE 754 rounds them the lists are the same; on others the
 * tests have room for what these round (light_kernels.h), and no light is missing all the same. Of a tolerance it does
 * what ends lamps without an end, and leaves nothing else out.
 */
#ifndef STILB_LIGHT_REACHED_H
#define STILB_LIGHT_REACHED_H

#include "light/light.h"

/* A light, in the order of the view's that do not reach everywhere. */
typedef struct stilb_light_reached {
	float place[4]; /* clip x, y and w of its sphere's middle, and depth */
	float radius;
	uint32_t slices; /* first | last << 8 of those that it reaches, first > last: none; 1 << 16: it has a cone */
	float cosine, sine;
	float base[3], slack; /* of the cone, as light_cone in light_kernels.h */
	float axis[3], padding;
} stilb_light_reached;

/* The cells. Behind it, four floats each: for the columns' edges, and one more, inverse, offset and edge; for the rows'
 * likewise, then x and w, then of the unit and of the band that the row is in the first row and the end; for the slices
 * the near and the far end. */
typedef struct stilb_light_cells {
	float depth_plane[4];
	float slice_scale, slice_bias;
	uint32_t columns, rows, slices, light_count; /* light_count: of those that do not reach everywhere */
	uint32_t padding[2];
	float along[4];                    /* change of clip x, y and w for one metre along the view */
	float squares[4], column_scale[4]; /* xx, xw, ww and area; scale and shift: of light_columns */
	float base_x[4], base_y[4], ray[4], ray_x[4], ray_y[4];
	float planes[][4];
} stilb_light_cells;

/* As stilb_light_lists_build, but makes no lists: starts and ids stay as they are, id_count is 0. */
stilb_result stilb_light_reached_find(stilb_light_lists *lists, const stilb_light_grid *grid,
                                      const stilb_scene_light *lights, uint32_t count, const uint32_t *candidates,
                                      uint32_t candidate_count, stilb_job_pool *pool, uint32_t worker);

/* The pairs of light and cell that these can have at most. */
uint64_t stilb_light_reached_most(const stilb_light_lists *lists);
/* Bytes of the cells that the last stilb_light_reached_find has found, with the planes; a multiple of 16. */
size_t stilb_light_cells_bytes(const stilb_light_lists *lists);
/* Writes them. */
void stilb_light_cells_write(const stilb_light_lists *lists, stilb_light_cells *out);
/* Writes lists->light_count - lists->everywhere_count lights. */
void stilb_light_reached_write(const stilb_light_lists *lists, stilb_light_reached *out);

#endif
