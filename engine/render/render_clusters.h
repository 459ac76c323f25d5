/*
 * Clusters of large meshes: what the heaps and the CPU hold of them, and which of them a view needs. Inside render/.
 *
 * Cut.      A group suffices, so that its coarser version may be drawn, if its error e (metres in the mesh's space) is
 *           at most the allowed one from the nearest point of its sphere: e s pixels / near <= error, as levels have it
 *           (render_detail.h), where s is the largest factor by which the part's transform stretches anything. A
 *           cluster is drawn if its own group does not suffice, and the group that it is from does, or it is from none.
 *           Errors and spheres grow from a group to those above it, so where one suffices, all below it do: along each
 *           way from the mesh itself to a root exactly one cluster is drawn. Rounding could at most draw two, never
 *           none: a way begins with what suffices and ends with what does not.
 * In view.  Groups whose sphere is outside of the view are left out, and so are clusters of groups that are partly
 *           outside. Clusters that turn their back on the camera are left out unless both sides are drawn: all their
 *           normals are within an angle a of an axis, and from the camera to the sphere's centre c, radius r, the way
 *           is v; v axis - |v| sin a changes by at most the way that c moves, so if it is at least r, it is at least 0
 *           for all points of the sphere, and no normal there points towards the camera.
 * Order.    Clusters are drawn in the order of their groups; those whose indices follow one another are one draw.
 */
#ifndef STILB_RENDER_CLUSTERS_H
#define STILB_RENDER_CLUSTERS_H

#include "base/base_math.h"
#include "render/render_detail.h"

/* A cluster. */
typedef struct render_cluster {
	float center[3], radius; /* with what rounding may cost */
	float axis[3], spread;   /* normals are so far from the axis: the sine of the angle; 2: beyond 90 degrees */
	uint32_t first_index, index_count; /* from the mesh's first index in the heap on */
	uint32_t from;                     /* group; render_clusters.group_count: none, which always suffices */
	uint32_t depth; /* 0: of the mesh itself; else one more than the deepest of the group that it is from */
} render_cluster;

static_assert(sizeof(render_cluster) == 48, "without gaps");

/* The clusters of a mesh, in one piece of memory; constant from its creation to its release. */
typedef struct render_clusters {
	uint32_t cluster_count, group_count;
	uint32_t depth;        /* of the deepest cluster */
	uint32_t coarser;      /* from the mesh's first index on: where those of clusters that are from groups begin */
	uint32_t group_padded; /* a multiple of 32, > group_count */
	/* [group_padded] of each group; error is NaN where nothing replaces it, and beyond the last. */
	float *x, *y, *z, *radius, *error;
	uint32_t *first_cluster;  /* [group_count + 1] */
	render_cluster *clusters; /* [cluster_count] */
} render_clusters;

/* STILB_ERROR_ARGUMENT: the clusters do not name groups, vertices and indices that there are. [any-thread] */
stilb_result render_clusters_check(const stilb_scene_mesh *mesh);

/* Makes them of a checked mesh that has some. coarser: where the first of mesh->cluster_indices lies, from the mesh's
 * first index on. NULL: no memory. [any-thread] */
render_clusters *render_clusters_make(const stilb_scene_mesh *mesh, uint32_t coarser);
/* Accepts NULL. */
void render_clusters_free(render_clusters *clusters);

/* How a view sees the clusters of a part. */
typedef struct render_cluster_view {
	float rows[3][4];      /* from the mesh's space to the world's axes, about the camera */
	float stretch;         /* s */
	float reach;           /* an error of 1 m is allowed from so many metres on */
	float near;            /* what is nearer counts as this far */
	float perspective;     /* 1, or 0: everything is as far as `near` */
	bool backs;            /* clusters that turn their back are left out */
	float camera[3];       /* backs: in the mesh's space */
	stilb_frustum frustum; /* in the mesh's space */
} render_cluster_view;

/* transform: of the part. [any-thread] */
render_cluster_view render_cluster_view_make(const render_detail_view *view, const stilb_render_view *seen,
                                             const stilb_mat4 *transform);

/* True if the cluster turns its back on the camera: view->backs. */
static inline bool render_cluster_is_back(const render_cluster_view *view, const render_cluster *cluster)
{
	float along = 0.0f, square = 0.0f;
	for (int i = 0; i < 3; i++) {
		float v = cluster->center[i] - view->camera[i];
		along += v * cluster->axis[i];
		square += v * v;
	}
	along -= cluster->radius;
	return along > 0.0f && along * along >= cluster->spread * cluster->spread * square;
}

/* Fills in cut->ranges. depths: clusters of different depths are in ranges of their own, which tell it. False: no
 * memory. [any-thread] */
bool render_clusters_choose(const render_clusters *clusters, const render_cluster_view *view, bool depths,
                            render_cluster_cut *cut);

/* The bits of the groups that suffice, four groups at a time where the CPU can; [group_padded / 32]. */
void render_clusters_suffice(const render_clusters *clusters, const render_cluster_view *view, uint32_t *suffices);
/* The same one by one, for tests. */
void render_clusters_suffice_scalar(const render_clusters *clusters, const render_cluster_view *view,
                                    uint32_t *suffices);

void render_cluster_cut_finish(render_cluster_cut *cut);

#endif
