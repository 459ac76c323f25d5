/*
 * geometry: coarser versions of a mesh, and the order of its vertices and triangles.
 *
 * The simplifier removes vertices one by one: a vertex is moved onto a neighbour, and the triangles between the two
 * vanish. So a coarser mesh is other triangles over the same vertices, and no vertex ever changes. Which vertex goes
 * next is decided by what changes: how far the surface moves from the planes of the triangles around the vertex, and
 * how far normals, texture coordinates and whatever else the table of streams names then are from what those triangles
 * have.
 * Sources: Garland and Heckbert, "Surface simplification using quadric error metrics", SIGGRAPH 1997; Hoppe, "New
 * quadric metric for simplifying meshes with appearance attributes", IEEE Visualization 1999; errors of the surface as
 * it is, as in Lindstrom and Turk, "Fast and memory efficient polygonal simplification", IEEE Visualization 1998.
 *
 * What it keeps.  A surface that is a manifold stays one (link condition of Dey, Edelsbrunner, Guha and Nekhayev,
 *              "Topology preserving edge contraction", 1999); borders stay borders; what is not a manifold stays as it
 *              is. Vertices at one position move together, also if they are many (facets), so nothing tears. A seam
 *              of a stream marked `seam` moves only along itself. No triangle turns over.
 * Any input.   Triangles with two equal positions, or with a position that is not finite, are in no coarser mesh:
 *              nothing can be seen of them. Empty meshes are simplified to empty ones.
 * Determinism. The result has the same bits for any number of workers.
 * Threads.     [any-thread] with the worker index that it has in the pool; pool NULL: on the calling thread alone.
 * Errors.      STILB_ERROR_ARGUMENT: an index or a number is out of its range. STILB_ERROR_MEMORY. The output is {0}
 *              then.
 */
#ifndef STILB_GEOMETRY_H
#define STILB_GEOMETRY_H

#include "base/base.h"
#include "jobs/job.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* What a difference of a stream's values means. */
typedef enum stilb_geometry_kind {
	STILB_GEOMETRY_DIRECTION, /* unit vectors, such as normals; a difference of 1 is 60 degrees */
	STILB_GEOMETRY_TEXTURE,   /* a place on a texture: counted as the distance on the surface that it stands for */
	STILB_GEOMETRY_VALUE,     /* a number of size 1, such as a colour */
	STILB_GEOMETRY_KINDS
} stilb_geometry_kind;

#define STILB_GEOMETRY_STREAMS 8 /* the most of a mesh, beside positions */

/* Values of vertices, `components` (1..4) floats for each. */
typedef struct stilb_geometry_stream {
	const char *name; /* for messages and as a key of caches, "normal" */
	stilb_geometry_kind kind;
	uint32_t components;
	/* 0 or more: what a difference of 1 (TEXTURE: of a triangle's edge) counts, in edges of the triangles that are to
	 * remain, against a distance from the surface. */
	float weight;
	bool seam;           /* where values of one position differ, the surface is cut open, and cuts are kept */
	const float *values; /* of the first vertex; not finite ones count as 0 */
	size_t stride;       /* bytes from one vertex to the next */
} stilb_geometry_stream;

typedef struct stilb_geometry_mesh {
	uint32_t vertex_count, index_count;
	const uint32_t *indices; /* [index_count], three for each triangle, each < vertex_count */
	const float *positions;  /* three floats for each vertex, metres */
	size_t position_stride;  /* bytes from one vertex to the next */
	uint32_t stream_count;   /* 0..STILB_GEOMETRY_STREAMS */
	const stilb_geometry_stream *streams;
	/* [vertex_count] not 0: the position of this vertex stays, for example because another mesh begins there; NULL:
	 * none. */
	const uint8_t *locked;
} stilb_geometry_mesh;

typedef struct stilb_geometry_simplify_desc {
	uint32_t target_triangles; /* ends with this many triangles, or one less; with more if no more can go */
	float max_error;           /* metres; ends before an error estimated to be larger; 0: no limit */
} stilb_geometry_simplify_desc;

typedef struct stilb_geometry_simplified {
	uint32_t *indices; /* [index_count] */
	uint32_t index_count;
	uint32_t *target; /* [vertex_count] the vertex onto which a vertex was moved in the end; itself: it stays */
	float error;      /* metres, an estimate: no bound. stilb_geometry_distance gives a bound */
} stilb_geometry_simplified;

/* Simplifies a mesh. Time proportional to the number of triangles. See the head of this file. */
stilb_result stilb_geometry_simplify(const stilb_geometry_mesh *mesh, const stilb_geometry_simplify_desc *desc,
                                     stilb_job_pool *pool, uint32_t worker, stilb_geometry_simplified *simplified);

/* Frees the arrays and leaves {0}. Accepts {0}. [any-thread] */
void stilb_geometry_simplified_finish(stilb_geometry_simplified *simplified);

/* How far two surfaces over the vertices of `mesh` are from each other at most: no point of one is farther from the
 * other than *bound, metres, and none of that one is farther from this. Measured at points that lie as close as the
 * finer surface's vertices, closer where the distance is large, and enlarged by 6 %. Triangles whose positions are not
 * finite must not be among them. 0 if one of them is empty. STILB_ERROR_MEMORY. [any-thread] */
stilb_result stilb_geometry_distance(const stilb_geometry_mesh *mesh, const uint32_t *a, uint32_t a_count,
                                     const uint32_t *b, uint32_t b_count, stilb_job_pool *pool, uint32_t worker,
                                     float *bound);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
