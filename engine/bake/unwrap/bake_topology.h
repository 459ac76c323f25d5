/*
 * bake_topology: which triangles are neighbours. Vertices at the same position are one, whatever else they differ in;
 * triangles are neighbours across an edge if no third one has it and both see the same side as their front.
 *
 * A half-edge is a triangle's side: number 3 * triangle + i goes from corner i to corner (i + 1) % 3.
 * Threads.  create, finish: [one-writer]; else constant.
 */
#ifndef BAKE_TOPOLOGY_H
#define BAKE_TOPOLOGY_H

#include "bake/bake_unwrap.h"

#define BAKE_NONE UINT32_MAX

typedef struct bake_topology {
	uint32_t triangle_count;
	uint32_t *twin;         /* [3 * triangle_count] the half-edge of the neighbour; BAKE_NONE: charts end here */
	double (*place)[3];     /* [3 * triangle_count] of the corners; of triangles that are not good anything */
	double (*normal)[3];    /* [triangle_count] unit */
	double *area;           /* [triangle_count] 0: the triangle gets no chart */
	uint32_t flat, invalid; /* triangles of area 0, and with corners that are no places */
	uint32_t odd_edges;     /* edges that would join, but more than two triangles have them, or they disagree */
} bake_topology;

stilb_result bake_topology_create(const stilb_bake_mesh *mesh, bake_topology *topology);
void bake_topology_finish(bake_topology *topology);

static inline uint32_t bake_next(uint32_t half_edge)
{
	return half_edge % 3 == 2 ? half_edge - 2 : half_edge + 1;
}

#endif
