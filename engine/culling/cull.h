/*
 * culling: bounding spheres and a view in, the ids of the spheres that the view can see out, in scene order.
 *
 * Definition.  A sphere is visible if for all six planes of the view, evaluated in float in this order,
 *                  ((x * px + y * py) + z * pz) + distance >= -radius
 *              A NaN anywhere in a sphere makes it invisible: the sphere of a model that is hidden or removed. An
 *              infinite radius makes it visible from everywhere.
 * Methods.     All return the same set, bit for bit. `octree` walks a tree of cubic cells, sixteen at a time, and does
 *              not test planes that a cell is wholly inside of. `flat` tests every sphere. `auto` takes the octree if
 *              the view sees all of it or the last run saw at most a quarter of the models, else flat.
 *              The octree is loose: a cell of side s holds objects whose centres lie in it and that reach up to s / 2
 *              beyond its faces, so an object's size and centre alone determine its cell. Source: Thatcher Ulrich,
 *              "Loose Octrees", Game Programming Gems, 2000, with his k = 2.
 * Code.        AVX-512, AVX2 or plain C, the widest that the CPU has, or the one that STILB_ISA names (stilb_cpu_isa).
 * Life cycle.  stilb_cull_create -> frames -> stilb_cull_destroy, and stilb_cull_visible_finish for each view.
 * Per frame.   stilb_cull_update once for all models whose bounds have changed, then stilb_cull_run for each view, or
 *              stilb_cull_run_views for all.
 * Threads.     [one-writer]: any thread, but one call at a time for each stilb_cull, stilb_cull_octree and
 *              stilb_cull_visible. stilb_cull_run spreads its work over the job pool it is given, and stays on the
 *              caller alone if there is too little to be worth waking a thread.
 * Cost.        insert, move, remove: at most max_depth steps; a move within a cell is a store. No allocation while
 *              culling once the buffers have grown to the scene; cells that become empty are reused. A scene that
 *              outgrows its octree, twice the models or twice as many outside its root, gets a new one in
 *              stilb_cull_update.
 * Errors.      STILB_ERROR_MEMORY leaves everything as it was before the call, except for stilb_cull_update.
 * Example.     One view, every frame:
 *
 *   stilb_cull_visible visible = {0};
 *   stilb_cull *cull;
 *   stilb_result result = stilb_cull_create(scene, &cull);
 *   while (result == STILB_OK && running()) {
 *       stilb_frustum frustum = stilb_frustum_from_matrix(&view_projection);
 *       result = stilb_cull_update(cull, scene, scene->moved, scene->moved_count);
 *       if (result == STILB_OK)
 *           result = stilb_cull_run(cull, STILB_CULL_AUTO, scene, &frustum, pool, 0, &visible);
 *       for (uint32_t i = 0; result == STILB_OK && i < visible.count; i++)
 *           draw(visible.ids[i]);
 *   }
 *   stilb_cull_visible_finish(&visible);
 *   stilb_cull_destroy(cull);
 */
#ifndef STILB_CULL_H
#define STILB_CULL_H

#include "base/base.h"
#include "base/base_math.h"
#include "jobs/job.h"
#include "scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

typedef enum stilb_cull_method {
	STILB_CULL_AUTO, /* one of the others, chosen in every run by what the last run saw */
	STILB_CULL_OCTREE,
	STILB_CULL_FLAT,
} stilb_cull_method;

typedef struct stilb_cull stilb_cull;

/* The models that one view sees. One for each view, zero-initialised; stilb_cull_run allocates and fills it. */
typedef struct stilb_cull_visible {
	uint32_t *ids; /* [count] ascending, which is scene order */
	uint32_t count;
	stilb_cull_method method;     /* of the last run; never AUTO */
	uint32_t capacity;            /* models, a multiple of 4096 */
	uint32_t set_count;           /* sets of bits: one for each thread of the pool */
	uint64_t *bits;               /* scratch: [set_count][capacity / 64], one bit a model; all zero between runs */
	uint32_t *chunk_count;        /* scratch: [capacity / 4096] visible models in each 4096 */
	struct stilb_cull_list *list; /* scratch: the cells to look into; NULL: not needed so far */
} stilb_cull_visible;

/* Builds the octree over all models of the scene. Its depth is chosen so that a cell holds some 64 to 256 models where
 * they lie evenly. On failure *cull is NULL. STILB_ERROR_ARGUMENT: STILB_ISA is wrong. STILB_ERROR_MEMORY.
 * [any-thread] */
stilb_result stilb_cull_create(const stilb_scene *scene, stilb_cull **cull);

/* Reads the new bounds of models ids[0 .. count - 1] from the scene: models that have moved, appeared, or have a NaN in
 * their bounds now or had one before; an id may stand there twice. All models that the scene has got since the last
 * call must be among them; it cannot have got fewer. scene->moved and scene->moved_count are such a list.
 * STILB_ERROR_MEMORY: the models before the failing one are up to date, the others have their old bounds; the same call
 * may be made again. [one-writer] */
stilb_result stilb_cull_update(stilb_cull *cull, const stilb_scene *scene, const uint32_t *ids, uint32_t count);

/* Fills visible with the models inside the frustum. scene is the one that cull was created with, every changed model
 * told to stilb_cull_update. worker is the caller's index in pool; pool may be NULL: then all work is done by the
 * caller. On STILB_ERROR_MEMORY visible->count is 0. [one-writer] */
stilb_result stilb_cull_run(stilb_cull *cull, stilb_cull_method method, const stilb_scene *scene,
                            const stilb_frustum *frustum, stilb_job_pool *pool, uint32_t worker,
                            stilb_cull_visible *visible);

/* stilb_cull_run of several views at once: frusta[count], visible[count]. Where there are at least as many as threads,
 * and enough to do, each thread takes whole views. On STILB_ERROR_MEMORY all counts are 0. [one-writer] */
stilb_result stilb_cull_run_views(stilb_cull *cull, stilb_cull_method method, const stilb_scene *scene,
                                  const stilb_frustum *frusta, uint32_t count, stilb_job_pool *pool, uint32_t worker,
                                  stilb_cull_visible *visible);

/* Frees the arrays and leaves {0}. Accepts NULL and {0}. [one-writer] */
void stilb_cull_visible_finish(stilb_cull_visible *visible);

/* Accepts NULL. [one-writer] */
void stilb_cull_destroy(stilb_cull *cull);

/* ---- the loose octree by itself -------------------------------------------------------------------------------------
 * For objects that come and go, and any set of ids.
 *
 *   stilb_cull_octree *octree;
 *   stilb_cull_octree_desc desc = {.half_size = 500.0f, .max_depth = 8};
 *   stilb_result result = stilb_cull_octree_create(&desc, &octree);
 *   if (result == STILB_OK)
 *       result = stilb_cull_octree_insert(octree, 7, (stilb_sphere){x, y, z, radius});
 *   if (result == STILB_OK)
 *       result = stilb_cull_octree_mark(octree, &frustum, bits);
 *   stilb_cull_octree_destroy(octree);
 */

typedef struct stilb_cull_octree stilb_cull_octree;

/* The root cell. It must lie within 2^60 m of the origin. Objects that fit into no cell stay in the root and are tested
 * one by one: those with a centre outside it, a radius above half_size or below 0, or bounds that are not finite. */
typedef struct stilb_cull_octree_desc {
	float center[3];    /* of the root cell, metres */
	float half_size;    /* half the root cell's side, metres, > 0 */
	uint32_t max_depth; /* 0..20: the smallest cells have sides of 2 * half_size / 2^max_depth */
} stilb_cull_octree_desc;

/* On failure *octree is NULL. STILB_ERROR_ARGUMENT: desc is out of the ranges above, or STILB_ISA is wrong.
 * STILB_ERROR_MEMORY. [any-thread] */
stilb_result stilb_cull_octree_create(const stilb_cull_octree_desc *desc, stilb_cull_octree **octree);

/* Accepts NULL. [one-writer] */
void stilb_cull_octree_destroy(stilb_cull_octree *octree);

/* Adds object id, a number below 2^31; memory grows with the highest id. bounds: centre and radius, metres.
 * STILB_ERROR_ARGUMENT: it is in the tree already, or too large. STILB_ERROR_MEMORY. [one-writer] */
stilb_result stilb_cull_octree_insert(stilb_cull_octree *octree, uint32_t id, stilb_sphere bounds);

/* Gives an object of the tree new bounds. STILB_ERROR_ARGUMENT: it is not in the tree. STILB_ERROR_MEMORY: it keeps its
 * old bounds. [one-writer] */
stilb_result stilb_cull_octree_move(stilb_cull_octree *octree, uint32_t id, stilb_sphere bounds);

/* Removes an object; an id that is not in the tree is ignored. [one-writer] */
void stilb_cull_octree_remove(stilb_cull_octree *octree, uint32_t id);

/* Sets bit id % 64 of bits[id / 64] for every visible object, and leaves the other bits as they are: bits has a word
 * for every 64 ids up to the highest. STILB_ERROR_MEMORY: no bit is set. [one-writer] */
stilb_result stilb_cull_octree_mark(stilb_cull_octree *octree, const stilb_frustum *frustum, uint64_t *bits);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
