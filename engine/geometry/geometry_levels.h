/*
 * geometry_levels: makes the levels of a scene's mesh (stilb_scene_level): each has about half of the triangles of the
 * one before it and uses a prefix of the same vertices, so that all of them share one upload and a vertex moves on its
 * own way to where the next level has it. A large mesh has clusters, too (stilb_scene_cluster): the same for places.
 *
 * Example.  A mesh of a scene that is about to be built:
 *
 *   stilb_geometry_levels_desc desc = stilb_geometry_levels_desc_default();
 *   stilb_result result = stilb_geometry_levels(&mesh, &desc, pool, 0);
 *
 * The same vertices and triangles are in the mesh afterwards, in another order: that of the levels, and inside of it
 * one that suits the caches of a device. What else belongs to vertices by their number (skins, shapes) must not exist.
 * Threads and errors are those of geometry.h; after an error the mesh is as it was.
 */
#ifndef STILB_GEOMETRY_LEVELS_H
#define STILB_GEOMETRY_LEVELS_H

#include "geometry/geometry.h"
#include "scene/scene.h"
#include "scene/scene_streams.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

typedef struct stilb_geometry_levels_desc {
	float ratio;    /* triangles of a level in terms of the finer one, [0.1, 0.9] */
	uint32_t least; /* no level is made of one that has this many triangles or fewer */
	/* Of each row of stilb_scene_vertex_streams (stilb_geometry_stream.weight); that of positions is not used. */
	float weights[STILB_SCENE_VERTEX_STREAMS];
	uint32_t cluster_least; /* a mesh of more triangles has clusters, and levels from this many triangles downwards */
	const uint8_t *locked;  /* [vertex_count] as stilb_geometry_mesh.locked; NULL: none */
	/* Asked between levels and before each is compared, and with every million triangles of clusters, on the calling
	 * thread; true: the caller gives it up, which is STILB_ERROR_GIVEN_UP. NULL: never. */
	bool (*give_up)(void *user);
	void *user;
} stilb_geometry_levels_desc;

/* Halves down to 20 triangles, with the weights of stilb_scene_vertex_streams; clusters beyond 100,000 triangles.
 * [any-thread] */
stilb_geometry_levels_desc stilb_geometry_levels_desc_default(void);

/* Replaces the mesh's levels by new ones, as many as can be made: none of a mesh of few triangles or one that cannot
 * be simplified; and its clusters, if it has many triangles. With clusters there is no morph. Errors hold for the
 * surfaces; they are measured at many points of both, more of them where the distance is large, and enlarged by 6 % for
 * what lies between. */
stilb_result stilb_geometry_levels(stilb_scene_mesh *mesh, const stilb_geometry_levels_desc *desc, stilb_job_pool *pool,
                                   uint32_t worker);

/* ---- the cache on disk ---------------------------------------------------------------------------------------------
 * Levels are kept in files, one a mesh, under a hash of the mesh's values and of all settings: in the folder
 * stilb/levels of $XDG_CACHE_HOME, else of $HOME/.cache. A file is whole or not there. One that is damaged, or was
 * written by somebody else, is as good as none: sizes, checksum and every number in it are checked before it is used.
 * A full disk, a folder that cannot be written, neither of the two variables, or STILB_CACHE=off in the environment
 * only cost the time of the next run. */

#define STILB_GEOMETRY_CACHE_BYTES ((uint64_t)1 << 30) /* files that were not used for longest go beyond this */
#define STILB_GEOMETRY_CACHE_LEAST 2000u /* triangles; what takes about as long to make as to read is not kept */

/* stilb_geometry_levels, which are kept on disk, or come from there. */
stilb_result stilb_geometry_levels_cached(stilb_scene_mesh *mesh, const stilb_geometry_levels_desc *desc,
                                          stilb_job_pool *pool, uint32_t worker);

/* Takes levels from the disk alone. False: they are not there, or there is no memory, and the mesh is as it was. True
 * also for a mesh that is known to have none. [any-thread] */
bool stilb_geometry_levels_find(stilb_scene_mesh *mesh, const stilb_geometry_levels_desc *desc);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
