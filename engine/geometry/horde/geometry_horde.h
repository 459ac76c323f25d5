/*
 * geometry_horde: finds the models of a scene that look alike and are many, bakes an impostor of each kind where that
 * saves time (geometry_impostor.h), and gives it to all of them.
 *
 * Alike.    The same meshes and materials in the same places relative to the first part. A horde has at least
 *           STILB_GEOMETRY_HORDE_MODELS of them.
 * Saves.    From where frames would draw the impostor, the model's parts in the coarsest levels that may be off by half
 *           a pixel still have STILB_GEOMETRY_HORDE_TRIANGLES together: an impostor costs as much as some 30 triangles.
 *           A mesh without levels counts in full.
 * Left out. Models that emit light, meshes that skins or shapes move, models that have an impostor already.
 * Edits.    Impostors are stale after an edit of meshes or materials; calling this again removes them and bakes anew.
 *
 *   uint32_t made;
 *   stilb_geometry_horde_desc desc = stilb_geometry_horde_desc_default();
 *   stilb_result result = stilb_geometry_hordes(scene, &desc, pool, 0, &made);
 */
#ifndef STILB_GEOMETRY_HORDE_H
#define STILB_GEOMETRY_HORDE_H

#include "geometry/geometry_impostor.h"
#include "scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

#define STILB_GEOMETRY_HORDE_MODELS 32u
#define STILB_GEOMETRY_HORDE_TRIANGLES 64u

typedef struct stilb_geometry_horde_desc {
	stilb_geometry_impostor_desc impostor;
	uint64_t bytes; /* of the maps of all that are made: the hordes that draw most triangles come first */
	/* Asked before each is baked, on the calling thread; true: no more are made. NULL: never. */
	bool (*give_up)(void *user);
	void *user;
} stilb_geometry_horde_desc;

/* The default impostor, 10.6 MiB each, and 128 MiB. [any-thread] */
stilb_geometry_horde_desc stilb_geometry_horde_desc_default(void);

/* *made: how many impostors were baked. Models that have none because their impostor cannot be baked are no error.
 * STILB_ERROR_MEMORY; what was made until then stays. [one-writer], with a pool as in geometry_impostor.h. */
stilb_result stilb_geometry_hordes(stilb_scene *scene, const stilb_geometry_horde_desc *desc, stilb_job_pool *pool,
                                   uint32_t worker, uint32_t *made);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
