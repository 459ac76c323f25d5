/* What levels and clusters of a mesh are, without the mesh's values: what a cache keeps. Inside the module and its
 * tests. */
#ifndef GEOMETRY_PLAN_H
#define GEOMETRY_PLAN_H

#include "geometry/geometry_levels.h"

typedef struct geometry_plan {
	/* all 0: there are neither levels nor clusters */
	uint32_t vertex_count, index_count, level_count, level_index_count, cluster_count, group_count, cluster_index_count;
	stilb_scene_level *levels; /* [level_count] */
	uint32_t *order; /* [vertex_count] the vertex of the mesh as it was that is at this place now: each once */
	uint32_t *to;    /* [vertex_count] the vertex of the mesh as it was that is the morph of the one here; with clusters
	                      NULL */
	uint32_t *indices;                 /* [index_count] places */
	uint32_t *level_indices;           /* [level_index_count] places */
	stilb_scene_cluster *clusters;     /* [cluster_count] */
	stilb_scene_cluster_group *groups; /* [group_count] */
	uint32_t *cluster_indices;         /* [cluster_index_count] places */
} geometry_plan;

/* Makes the arrays for the counts. False: no memory. */
bool geometry_plan_allocate(geometry_plan *plan);
void geometry_plan_finish(geometry_plan *plan);

/* One of its arrays, bytes. */
typedef struct geometry_plan_part {
	void *data;
	size_t size;
} geometry_plan_part;

#define GEOMETRY_PLAN_PARTS 8

/* All arrays, in the order of the members. */
void geometry_plan_parts(const geometry_plan *plan, geometry_plan_part parts[GEOMETRY_PLAN_PARTS]);

static_assert(STILB_SCENE_MOST_STREAMS == STILB_GEOMETRY_STREAMS + 1, "positions stand alone");

/* Fills in what the simplifier knows of vertices that consist of a table's streams, but for positions, and returns how
 * many these are. weights: [table->count]. */
uint32_t geometry_streams_of(const stilb_scene_streams *table, const void *vertices, const float *weights,
                             stilb_geometry_stream out[STILB_GEOMETRY_STREAMS]);

/* A scene's mesh as the simplifier sees it. */
stilb_geometry_mesh geometry_view_of(const stilb_scene_mesh *mesh, const stilb_geometry_levels_desc *desc,
                                     stilb_geometry_stream streams[STILB_GEOMETRY_STREAMS]);

/* The two hashes by which the cache finds levels of a mesh whose vertices consist of a table's streams; weights:
 * [table->count], in place of desc->weights. */
void geometry_cache_key(const stilb_scene_streams *table, const void *vertices, const float *weights,
                        const stilb_scene_mesh *mesh, const stilb_geometry_levels_desc *desc, uint64_t key[2]);

/* What is wrong with a mesh or the settings, as stilb_fail; STILB_OK: nothing. */
stilb_result geometry_levels_check(const stilb_scene_mesh *mesh, const stilb_geometry_levels_desc *desc);

/* Makes the plan of a mesh that has been checked. STILB_ERROR_MEMORY, STILB_ERROR_GIVEN_UP. */
stilb_result geometry_plan_make(const stilb_scene_mesh *mesh, const stilb_geometry_levels_desc *desc,
                                stilb_job_pool *pool, uint32_t worker, geometry_plan *plan);

/* The same without clusters. */
stilb_result geometry_chain_make(const stilb_scene_mesh *mesh, const stilb_geometry_levels_desc *desc,
                                 stilb_job_pool *pool, uint32_t worker, geometry_plan *plan);

/* Gives the mesh the order, levels and clusters of a plan that was made for it, which is {0} then. STILB_ERROR_MEMORY,
 * and the mesh and the plan are as they were. */
stilb_result geometry_plan_apply(geometry_plan *plan, stilb_scene_mesh *mesh);

#endif
