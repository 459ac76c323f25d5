/* What levels of a mesh are, without the mesh's values: what a cache keeps. Inside the module and its tests. */
#ifndef GEOMETRY_PLAN_H
#define GEOMETRY_PLAN_H

#include "geometry/geometry_levels.h"

/* All but the counts is one block of memory, in the order of the members. */
typedef struct geometry_plan {
	uint32_t vertex_count, index_count, level_count, level_index_count; /* all 0: there are no levels */
	stilb_scene_level *levels;                                          /* [level_count] */
	uint32_t *order;         /* [vertex_count] the vertex of the mesh as it was that is at this place now: each once */
	uint32_t *to;            /* [vertex_count] the vertex of the mesh as it was that is the morph of the one here */
	uint32_t *indices;       /* [index_count] places */
	uint32_t *level_indices; /* [level_index_count] places */
	void *memory;
	size_t size; /* bytes of it */
} geometry_plan;

/* Makes the block for the counts. False: no memory. */
bool geometry_plan_allocate(geometry_plan *plan);
void geometry_plan_finish(geometry_plan *plan);

static_assert(STILB_SCENE_MOST_STREAMS == STILB_GEOMETRY_STREAMS + 1, "positions stand alone");

/* Fills in what the simplifier knows of vertices that consist of a table's streams, but for positions, and returns how
 * many these are. weights: [table->count]. */
uint32_t geometry_streams_of(const stilb_scene_streams *table, const void *vertices, const float *weights,
                             stilb_geometry_stream out[STILB_GEOMETRY_STREAMS]);

/* The two hashes by which the cache finds levels of a mesh whose vertices consist of a table's streams; weights:
 * [table->count], in place of desc->weights. */
void geometry_cache_key(const stilb_scene_streams *table, const void *vertices, const float *weights,
                        const stilb_scene_mesh *mesh, const stilb_geometry_levels_desc *desc, uint64_t key[2]);

/* What is wrong with a mesh or the settings, as stilb_fail; STILB_OK: nothing. */
stilb_result geometry_levels_check(const stilb_scene_mesh *mesh, const stilb_geometry_levels_desc *desc);

/* Makes the plan of a mesh that has been checked. STILB_ERROR_MEMORY. */
stilb_result geometry_plan_make(const stilb_scene_mesh *mesh, const stilb_geometry_levels_desc *desc,
                                stilb_job_pool *pool, uint32_t worker, geometry_plan *plan);

/* Gives the mesh the order and levels of a plan that was made for it. STILB_ERROR_MEMORY, and the mesh is as it was. */
stilb_result geometry_plan_apply(const geometry_plan *plan, stilb_scene_mesh *mesh);

#endif
