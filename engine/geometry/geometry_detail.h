/*
 * geometry_detail: makes coarser levels of a scene's meshes on a thread of its own, beside the frames and with low
 * priority; those that are on disk come at once (geometry_levels.h).
 *
 *   stilb_geometry_detail_find(scene);                       as long as nobody else has the scene
 *   stilb_geometry_detail *detail;
 *   if (stilb_geometry_detail_start(scene, &detail) == STILB_OK)
 *       while (!stilb_geometry_detail_give(detail, scene))   in each update of the scene
 *           ...
 *   stilb_geometry_detail_end(detail);
 *
 * The levels are those of stilb_geometry_levels_desc_default.
 * Meshes that move by skins or shapes have none: what they are made of belongs to vertices by their number.
 * Threads.  stilb_geometry_detail_find and _make are [any-thread] as long as no other thread has the scene; the others
 *           are for the thread that edits the scene.
 */
#ifndef STILB_GEOMETRY_DETAIL_H
#define STILB_GEOMETRY_DETAIL_H

#include "scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* Meshes of fewer triangles are drawn as they are. */
#define STILB_GEOMETRY_DETAIL_LEAST 500u

typedef struct stilb_geometry_detail stilb_geometry_detail;

/* Gives the meshes of a scene that nobody else has yet the levels that are on disk. */
void stilb_geometry_detail_find(stilb_scene *scene);

/* Gives all of them levels, and waits for that; those for which there is no memory have none. */
void stilb_geometry_detail_make(stilb_scene *scene);

/* Begins to make levels of meshes that have none; *detail is NULL if there is nothing to do. STILB_ERROR_MEMORY,
 * STILB_ERROR_THREAD; *detail is NULL then. */
stilb_result stilb_geometry_detail_start(const stilb_scene *scene, stilb_geometry_detail **detail);

/* Gives the scene the levels that have been made since the last call, at most one mesh in a call, so that no frame
 * takes long. True: that was all. Accepts NULL. */
bool stilb_geometry_detail_give(stilb_geometry_detail *detail, stilb_scene *scene);

/* Gives up what is not made yet, waits for the thread, and frees. Accepts NULL. */
void stilb_geometry_detail_end(stilb_geometry_detail *detail);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
