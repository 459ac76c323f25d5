/*
 * light: which lights of a view reach which part of it.
 *
 * Grid.      The picture is cut into tiles of equal pixels, and each tile by depth into slices, whose far ends lie by
 *            equal factors apart; the last one is open. A tile's part of a slice is a cell, "froxel" in the literature.
 * Lists.     A cell's list holds each light that can send something to a point of the cell: none is missing, some may
 *            be too many. There is no limit to the number of lights but memory.
 * Everywhere Lights that reach all of space (suns, and lamps whose falloff is physical and which the tolerance does not
 *            end) are in no cell's list: they stand first, and count for every cell.
 * Tolerance  What is left out of a cell's list although it reaches the cell sends at most `tolerance` to any point of
 *            it, all such lights together, whatever the material. Lamps without an end share half of it and end where
 *            each sends its part; the rest, or all of it without such lamps, goes to each cell's weakest lights, by
 *            what they send to the nearest point of a sphere around the cell. Cells of the open slice keep theirs.
 * Order      Lights keep the scene's order, so that sums over a list have the same bits as sums over all lights that a
 *            view has: what a list lacks sends exactly 0, unless a tolerance above 0 allows more.
 * Shader     Of a pixel at gl_FragCoord whose point is p: the cell is x = uint(gl_FragCoord.x) / tile, y likewise, and
 *            the slice of p's depth, as slice_scale and slice_bias say. It sums the first everywhere_count lights, then
 *            those of its list, in their order.
 * Life cycle {0} -> stilb_light_lists_build every frame -> stilb_light_lists_finish.
 * Threads    [one-writer]: any thread, one call at a time for each stilb_light_lists. The work is spread over the pool.
 *            The lists are the same, bit for bit, for any number of workers and any instruction set (STILB_ISA).
 * Sources    Olsson, Billeter, Assarsson, "Clustered Deferred and Forward Shading" (2012); Persson, Olsson, "Practical
 *            Clustered Deferred and Forward Shading" (2013).
 */
#ifndef STILB_LIGHT_H
#define STILB_LIGHT_H

#include "base/base.h"
#include "base/base_math.h"
#include "jobs/job.h"
#include "scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

#define STILB_LIGHT_SLICES_MAX 128u

/* A view, and how it is cut. */
typedef struct stilb_light_grid {
	stilb_mat4 view_projection; /* world to clip space, perspective or orthographic, as of stilb_render_view */
	uint32_t width, height;     /* of the picture, pixels, 1..16384 */
	uint32_t tile;              /* a tile's side, pixels: a power of 2, 8..1024 */
	uint32_t slices;            /* 1..STILB_LIGHT_SLICES_MAX */
	float first, last; /* depth where the first slice ends and where the last one begins, metres, 0 < first < last; with
	                      one slice neither is read, with two only the first */
	float tolerance;   /* radiance, W sr^-1 m^-2, >= 0 */
	float peak; /* the largest value of BRDF times cosine of all materials that are seen, sr^-1, >= 1 / pi; read if the
	               tolerance is above 0 */
} stilb_light_grid;

typedef struct stilb_light_lists {
	uint32_t *lights; /* [light_count] indices of the view's lights: first everywhere_count that reach all of it, then
	                        those that reach a part of it, of which cells' lists are; both ascending */
	uint32_t light_count, everywhere_count;
	uint32_t columns, rows, slices; /* cells: columns * rows * slices; cell (x, y, z) is x + columns * (y + rows * z) */
	uint32_t *starts;               /* [cells + 1]: cell c has ids[starts[c]] .. ids[starts[c + 1] - 1] */
	uint32_t *ids;                  /* [id_count] ascending in each cell; id i is lights[everywhere_count + i] */
	uint32_t id_count;
	/* Depth of a point p: dot(depth_plane, (p, 1)), metres along the view, from the eye; of an orthographic view from
	 * the near plane. */
	float depth_plane[4];
	float slice_scale, slice_bias; /* slice: clamp(floor(log2(max(depth, 1e-30)) * slice_scale + slice_bias), 0,
	                                  slices - 1) */
	uint32_t left_out; /* pairs of light and cell that only the tolerance left out; UINT32_MAX: so many or more */
	struct light_scratch *scratch;
} stilb_light_lists;

/* Fills lists with the lights of lights[0 .. count - 1] that the view has: those that reach a part of it, without BAKED
 * ones. candidates: ascending indices of lights among which all are that may reach the view, [candidate_count]; NULL:
 * all. lights have no mistake (stilb_scene_light_mistake). worker is the caller's index in pool; pool may be NULL: then
 * the caller does all. STILB_ERROR_ARGUMENT: a number of the grid is out of its range, or STILB_ISA is wrong.
 * STILB_ERROR_MEMORY. On failure all counts are 0. [one-writer] */
stilb_result stilb_light_lists_build(stilb_light_lists *lists, const stilb_light_grid *grid,
                                     const stilb_scene_light *lights, uint32_t count, const uint32_t *candidates,
                                     uint32_t candidate_count, stilb_job_pool *pool, uint32_t worker);

/* Frees what lists hold and leaves {0}. Accepts NULL and {0}. [one-writer] */
void stilb_light_lists_finish(stilb_light_lists *lists);

/* ---- one light --------------------------------------------------------------------------------------------------- */

/* The part of space that a light can reach: a sphere, and of that what lies within a cone. The sphere of a light with a
 * cone is the one around both, so its centre may lie in front of the light. */
typedef struct stilb_light_bounds {
	stilb_sphere sphere; /* metres; radius INFINITY: everywhere; -1: nowhere, the light has no intensity */
	float axis[3];       /* unit; the cone opens from `apex` along it */
	float apex[3];       /* a little behind the light */
	float cos_angle;     /* of the cone's half angle, [-1, 1); -1: no cone */
} stilb_light_bounds;

/* Where the light sends more than 0, with room for what a GPU rounds. [any-thread] */
stilb_light_bounds stilb_light_bounds_of(const stilb_scene_light *light);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
