/* Simplifies a piece of a mesh on one thread. Inside the module alone. */
#ifndef GEOMETRY_REGION_H
#define GEOMETRY_REGION_H

#include "geometry/geometry.h"

/* What all regions of a round read. */
typedef struct geometry_round {
	const stilb_geometry_mesh *mesh;
	const uint32_t *canonical; /* [vertex_count] the lowest vertex at the same position */
	const uint8_t *locked;     /* [vertex_count] of canonical vertices: it stays; NULL: none does */
	/* [vertex_count] of canonical vertices: the region that has all of its triangles, or GEOMETRY_SHARED; NULL: there
	 * is one region. */
	const uint32_t *owner;
	float scale[STILB_GEOMETRY_STREAMS]; /* metres for a difference of 1 of a stream's value */
	float value_limit;                   /* m^2, the most that values cost, but for directions */
	uint32_t groups;                     /* vectors of four numbers for all streams of a vertex */
	/* m^2: triangles at a position whose areas add up to this cost what they move, squared; larger ones more, since
	 * more of the surface moves, and smaller ones less. 0: 1. */
	float area;
} geometry_round;

#define GEOMETRY_SHARED UINT32_MAX
#define GEOMETRY_REGION_MOST 16383u /* triangles of a region */

/* When a region ends: as soon as one of these is reached. */
typedef struct geometry_stop {
	uint32_t triangles; /* this many are left */
	float cost;         /* the next collapse costs more, m^2 */
} geometry_stop;

/* The collapses of a region in the order made. */
typedef struct geometry_record {
	float *cost;         /* [count] the largest so far, m^2: ascending */
	uint32_t *triangles; /* [count] removed so far */
	uint32_t *maps_end;  /* [count] entries of from and to that belong to it and those before */
	uint32_t *from, *to; /* vertices of the mesh */
	uint32_t count;
	void *memory;
} geometry_record;

/* Collapses edges inside of `count` triangles of region `id` until `stop`; triangles is unchanged. False: no memory;
 * the record is to be finished all the same. */
bool geometry_region_collapse(const geometry_round *round, uint32_t id, const uint32_t (*triangles)[3], uint32_t count,
                              geometry_stop stop, geometry_record *record);

/* How many collapses of a record cost at most `cost`. */
uint32_t geometry_record_prefix(const geometry_record *record, float cost);

void geometry_record_finish(geometry_record *record);

#endif
