/* What files of geometry share. */
#ifndef GEOMETRY_INTERNAL_H
#define GEOMETRY_INTERNAL_H

#include "geometry/geometry.h"
#include "geometry/geometry_region.h"

/* ---- loops and sorting ------------------------------------------------------------------------------------------- */

/* stilb_job_parallel_for, or without a pool one call for all. */
void geometry_for(stilb_job_pool *pool, uint32_t worker, uint32_t count, uint32_t grain, stilb_job_range_fn *fn,
                  void *context);

/* A value with a key to sort by. */
typedef struct geometry_keyed {
	uint32_t key, value;
} geometry_keyed;

/* Sorts items by the lower `bits` bits of their keys, stable; other is as large and is overwritten. The result is in
 * *sorted, which is one of the two. False: no memory. */
bool geometry_sort(stilb_job_pool *pool, uint32_t worker, geometry_keyed *items, geometry_keyed *other, uint32_t count,
                   uint32_t bits, geometry_keyed **sorted);

/* Interleaves the lower ten bits of three numbers. */
static inline uint32_t geometry_morton(uint32_t x, uint32_t y, uint32_t z)
{
	uint32_t code = 0;
	const uint32_t parts[3] = {x, y, z};
	for (uint32_t i = 0; i < 3; i++) {
		uint32_t v = parts[i] & 0x3ff;
		v = (v | v << 16) & 0x030000ff;
		v = (v | v << 8) & 0x0300f00f;
		v = (v | v << 4) & 0x030c30c3;
		v = (v | v << 2) & 0x09249249;
		code |= v << i;
	}
	return code;
}

static inline const float *geometry_position(const stilb_geometry_mesh *mesh, uint32_t vertex)
{
	return (const float *)((const char *)mesh->positions + vertex * mesh->position_stride);
}

/* ---- meshes ------------------------------------------------------------------------------------------------------ */

/* Writes the lowest vertex at the same position, which has finite coordinates, for each vertex; itself for one whose
 * position is not finite. False: no memory. */
bool geometry_weld(const stilb_geometry_mesh *mesh, stilb_job_pool *pool, uint32_t worker, uint32_t *canonical);

/* ---- the simplifier, step by step -------------------------------------------------------------------------------- */

/* A mesh on its way through rounds of simplification. */
typedef struct geometry_work {
	const stilb_geometry_mesh *mesh;
	stilb_job_pool *pool;
	uint32_t worker;
	uint32_t *canonical;      /* [vertex_count] */
	uint8_t *locked;          /* [vertex_count] of canonical vertices, or NULL */
	uint32_t *target;         /* [vertex_count] the vertex onto which this one was moved; itself */
	uint32_t (*triangles)[3]; /* [count] of vertices of the mesh */
	uint32_t count;
	float lower[3], extent; /* the box of all positions of triangles: its lower corner and longest side, metres */
	double area;            /* of all triangles, m^2 */
	double texture_density[STILB_GEOMETRY_STREAMS]; /* per metre, of TEXTURE streams */
	uint32_t rounds;
	float cost; /* the largest of a collapse, m^2 */
} geometry_work;

/* Makes one of a mesh whose members are in range. STILB_ERROR_MEMORY. */
stilb_result geometry_work_create(const stilb_geometry_mesh *mesh, stilb_job_pool *pool, uint32_t worker,
                                  geometry_work *work);
void geometry_work_finish(geometry_work *work);

/* Removes triangles until `target` are left, or one less; more if no more can go or would cost more than max_cost,
 * m^2. STILB_ERROR_MEMORY. */
stilb_result geometry_work_reduce(geometry_work *work, uint32_t target, float max_cost);

/* Sets what values count in a round that leaves `target` triangles. */
void geometry_round_scale(geometry_round *round, const geometry_work *work, uint32_t target);

/* True if a triangle has three finite and different positions. */
bool geometry_work_is_sound(const geometry_work *work, const uint32_t vertex[3]);

/* What is wrong with a mesh, as stilb_fail of STILB_ERROR_ARGUMENT; STILB_OK: nothing. */
stilb_result geometry_mesh_check(const stilb_geometry_mesh *mesh);

/* ---- distances and order ----------------------------------------------------------------------------------------- */

/* One of two surfaces over the same vertices. */
typedef struct geometry_side {
	const stilb_geometry_mesh *mesh;
	const uint32_t *indices;
	const struct geometry_tree *tree; /* of these */
} geometry_side;

/* A bound of how far a point of one of two surfaces is from the other (stilb_geometry_distance). False: no memory. */
bool geometry_distance(const geometry_side *a, const geometry_side *b, stilb_job_pool *pool, uint32_t worker,
                       float *bound);

/* Orders triangles so that a device meets vertices again soon and what is in front early. False: no memory, and indices
 * are as they were. */
bool geometry_order(const stilb_geometry_mesh *mesh, uint32_t *indices, uint32_t count);

/* The same of 256 triangles at most, without regard to what is in front. */
bool geometry_order_few(uint32_t (*triangles)[3], uint32_t count);

#endif
