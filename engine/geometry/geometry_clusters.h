/* The hierarchy of clusters of a large mesh (stilb_scene_cluster). Inside the module and its tests. */
#ifndef GEOMETRY_CLUSTERS_H
#define GEOMETRY_CLUSTERS_H

#include "geometry/geometry_internal.h"
#include "scene/scene.h"

#define GEOMETRY_CLUSTER_MOST 128u /* triangles of a cluster */
#define GEOMETRY_GROUP_MOST 16u    /* clusters of a group that is replaced */

typedef struct geometry_clusters {
	uint32_t cluster_count, group_count, cluster_index_count, cut_index_count;
	stilb_scene_cluster *clusters;
	stilb_scene_cluster_group *groups;
	uint32_t *indices; /* [index_count of the mesh] its triangles in the order of clusters */
	uint32_t *cluster_indices;
	uint32_t *cut; /* the mesh where all groups up to one are replaced and no other: the first such one that is small */
	float cut_error; /* metres, as stilb_scene_level.error */
} geometry_clusters;

typedef struct geometry_clusters_desc {
	uint32_t cut_most;           /* triangles of the cut, at most, if that can be reached */
	uint32_t triangles;          /* of a cluster, at most: GEOMETRY_CLUSTER_MOST, but for tests of small meshes */
	uint32_t clusters;           /* of a group, at most: GEOMETRY_GROUP_MOST */
	bool (*give_up)(void *user); /* as that of stilb_geometry_levels_desc */
	void *user;
} geometry_clusters_desc;

/* Makes the hierarchy of a mesh that has been checked. All but cut_error is 0 if nothing of it can be simplified.
 * STILB_ERROR_MEMORY, STILB_ERROR_GIVEN_UP; *clusters is {0} then. */
stilb_result geometry_clusters_make(const stilb_geometry_mesh *mesh, const geometry_clusters_desc *desc,
                                    stilb_job_pool *pool, uint32_t worker, geometry_clusters *clusters);

/* Frees the arrays and leaves {0}. Accepts {0}. */
void geometry_clusters_finish(geometry_clusters *clusters);

/* ---- how far a coarser version is -------------------------------------------------------------------------------- */

/* Triangles and those that replaced them. */
typedef struct geometry_replaced {
	const stilb_geometry_mesh *mesh;
	const uint32_t *canonical;    /* [vertex_count] the lowest vertex at the same position */
	const uint32_t (*finer)[3];   /* [finer_count] */
	const uint32_t (*coarser)[3]; /* [coarser_count] */
	const uint32_t *gone;         /* [gone_count] vertices of the finer ones that the others do not have */
	uint32_t finer_count, coarser_count, gone_count;
} geometry_replaced;

/* What no point of either is farther from the other than, metres, as stilb_geometry_distance; on one thread. False: no
 * memory. */
bool geometry_replaced_distance(const geometry_replaced *replaced, float *bound);

/* ---- splitting by space ------------------------------------------------------------------------------------------ */

/* Something at a place. */
typedef struct geometry_spot {
	float at[3];
	uint32_t id; /* each differs */
} geometry_spot;

/* Sorts spots into `parts` (1..count) parts that are each close together, of count / parts spots or one more: part i is
 * spots[count * i / parts] and those after it. jitter: 0: halves are equal; else the cuts lie elsewhere for each such
 * number. */
void geometry_split(geometry_spot *spots, uint32_t count, uint32_t parts, uint32_t jitter);

#endif
