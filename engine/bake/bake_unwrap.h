/*
 * bake_unwrap: lays the triangles of a mesh flat, as charts, so that every place of the surface has a place of its own
 * in a picture: what lightmaps need.
 *
 * Charts.      Triangles grow together across edges while their normals stay within a cone (angle) and no edge is a
 *              crease; small neighbours are merged. A flat chart is projected, exactly. Others are least-squares
 *              conformal maps: Levy, Petitjean, Ray, Maillot, "Least Squares Conformal Maps for Automatic Texture
 *              Atlas Generation" (2002), by conjugate gradients in double, in a fixed order. A map that turns a
 *              triangle over or covers a place twice is not accepted: the projection takes its place, or the chart is
 *              cut in two, down to single triangles, which are always good.
 * Scale.       Each chart has the area that its triangles have, so that a texel shows as much of the surface
 *              everywhere; it is turned so that its box is smallest.
 * Same bits.   For any number of workers.
 * Any mesh.    Triangles of area 0, and those with a corner that is NaN, infinite, beyond 1e10 or not in the mesh, get
 *              no chart. Edges of more than two triangles, or of two that disagree about which side is the front, are
 *              where charts end; so doubled triangles have texels each.
 * Threads.     [main-thread] of the pool, or a job of it: worker is the index of the calling thread.
 * Units.       Those of the positions.
 * Errors.      STILB_ERROR_MEMORY; then the result is {0}.
 */
#ifndef STILB_BAKE_UNWRAP_H
#define STILB_BAKE_UNWRAP_H

#include "base/base.h"
#include "jobs/job.h"

#define STILB_BAKE_NO_CHART UINT32_MAX

/* The triangles to unwrap. */
typedef struct stilb_bake_mesh {
	const void *positions; /* [vertex_count] three floats each, position_step bytes from one to the next */
	size_t position_step;
	const uint32_t *indices; /* [3 * triangle_count] */
	uint32_t vertex_count, triangle_count;
} stilb_bake_mesh;

typedef struct stilb_bake_unwrap_options {
	float cone;   /* radians: most that a triangle's normal may be off its chart's, (0, pi / 2) */
	float crease; /* radians: charts end at edges whose triangles' normals are farther apart, (0, pi] */
} stilb_bake_unwrap_options;

/* A cone of 55 degrees, creases of 60. [any-thread] */
stilb_bake_unwrap_options stilb_bake_unwrap_options_default(void);

typedef struct stilb_bake_chart {
	uint32_t first, count; /* its triangles, in stilb_bake_uv.triangles */
	float width, height;   /* of its box, whose lower corner is (0, 0); width >= height */
} stilb_bake_chart;

typedef struct stilb_bake_uv {
	uint32_t triangle_count, chart_count;
	float (*corners)[2];      /* [3 * triangle_count] the place of each triangle's corners in its chart's box */
	uint32_t *chart;          /* [triangle_count] STILB_BAKE_NO_CHART: it has none */
	uint32_t *triangles;      /* chart by chart */
	stilb_bake_chart *charts; /* [chart_count] */
	/* Triangles without a chart: of area 0, and those whose corners are no places; edges of more than two triangles, or
	 * of two with opposite fronts. */
	uint32_t flat, invalid, odd_edges;
} stilb_bake_uv;

/* Unwraps a mesh. options NULL: the default ones. */
stilb_result stilb_bake_unwrap(const stilb_bake_mesh *mesh, const stilb_bake_unwrap_options *options,
                               stilb_job_pool *pool, uint32_t worker, stilb_bake_uv *uv);

/* Frees the arrays and leaves {0}. Accepts {0}. [one-writer] */
void stilb_bake_uv_finish(stilb_bake_uv *uv);

/* How far the charts are from the surface's own shape: the root mean square over the surface of the stretch of lengths,
 * 1 where nothing is stretched, over that of a map of the same area; 1 for no triangles. The norm L2 of Sander, Snyder,
 * Gortler, Hoppe, "Texture Mapping Progressive Meshes" (2001), section 3. [any-thread] */
double stilb_bake_stretch(const stilb_bake_mesh *mesh, const stilb_bake_uv *uv);

#endif
