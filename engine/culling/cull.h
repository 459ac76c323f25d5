/*
 * culling: bounding spheres and a view in, the ids of what the view can see out, in scene order.
 *
 * Two methods return the same set, bit for bit: `octree`, a loose octree (k = 2) whose cells are tested sixteen at a time
 * and with plane masks, and `flat`, which tests every sphere. `auto` takes whichever is likely to be faster: the octree
 * where it is seen as a whole or little of it was seen in the run before, else flat. In all a sphere is visible when, for
 * all six planes and in float,
 *     ((x * px + y * py) + z * pz) + distance >= -radius
 * holds. NaN anywhere in a sphere makes it invisible; an infinite radius makes it visible from everywhere.
 * All run on AVX-512, AVX2 or plain C, whichever is the best that the CPU has or what STILB_ISA says (stilb_cpu_isa).
 * Source: Thatcher Ulrich, "Loose Octrees", Game Programming Gems, 2000 (a cell of side s reaches s / 2 beyond each of
 * its faces, so size and centre name the one cell of an object, and no other object has to be looked at).
 *
 * Life cycle.  stilb_cull_create -> per frame: stilb_cull_move for what moved, stilb_cull_run per view ->
 *              stilb_cull_destroy.
 * Threads.     [one-writer]: one call at a time for each stilb_cull, stilb_cull_octree and stilb_cull_visible.
 *              stilb_cull_run spreads its work over the job pool it is given, and stays on the caller alone when the
 *              work is too small to be worth waking a thread.
 * Cost.        insert, move, remove: O(1), at most max_depth steps; a move within a cell is a store. No allocation
 *              while culling once the buffers have grown to the scene; cells that empty are reused.
 * Errors.      STILB_ERROR_MEMORY leaves everything as it was before the call, but for stilb_cull_move.
 */
#ifndef STILB_CULL_H
#define STILB_CULL_H

#include "base/base.h"
#include "base/base_math.h"
#include "jobs/job.h"
#include "scene/scene.h"

typedef enum stilb_cull_method {
	STILB_CULL_AUTO, /* one of the others, chosen anew in every run by what the run before saw */
	STILB_CULL_OCTREE,
	STILB_CULL_FLAT,
} stilb_cull_method;

typedef struct stilb_cull stilb_cull;

/* What one view sees; one per view, zero-initialised, grown by stilb_cull_run. */
typedef struct stilb_cull_visible {
	uint32_t *ids; /* [count] ascending, so scene order */
	uint32_t count;
	stilb_cull_method method; /* of the last run; never AUTO */
	uint32_t capacity;        /* models */
	uint32_t set_count;       /* sets of bits: one for each thread of the pool */
	uint64_t *bits;           /* scratch: [set_count][capacity / 64], one bit a model; all zero between runs */
	uint32_t *chunk_count;    /* scratch */
} stilb_cull_visible;

/* Builds the octree over all models of the scene, with cells for some 64 to 256 models where these lie evenly. Neither
 * the count of models nor their ids may change afterwards. STILB_ERROR_ARGUMENT: STILB_ISA is wrong. [one-writer] */
stilb_result stilb_cull_create(const stilb_scene *scene, stilb_cull **cull);

/* Tells the octree the new bounds of count models, ids as in scene->moved. STILB_ERROR_MEMORY: models before the one
 * that did not fit have moved, the others have their old bounds. [one-writer] */
stilb_result stilb_cull_move(stilb_cull *cull, const stilb_scene *scene, const uint32_t *ids, uint32_t count);

/* Fills visible with what frustum sees. worker is the caller's index in pool; without a pool (NULL) all runs on the
 * caller. On failure visible->count is 0. [one-writer] */
stilb_result stilb_cull_run(stilb_cull *cull, stilb_cull_method method, const stilb_scene *scene,
                            const stilb_frustum *frustum, stilb_job_pool *pool, uint32_t worker,
                            stilb_cull_visible *visible);

/* Both accept NULL, finish also {0}. [one-writer] */
void stilb_cull_visible_finish(stilb_cull_visible *visible);
void stilb_cull_destroy(stilb_cull *cull);

/* ---- the loose octree by itself ---------------------------------------------------------------------------------- */

typedef struct stilb_cull_octree stilb_cull_octree;

/* The root cell, within 2^60 m of the origin. Objects that no cell can hold stay in the root and are tested one by one:
 * centres outside it, radii above half_size or below 0, bounds that are not finite. */
typedef struct stilb_cull_octree_desc {
	float center[3];    /* of the root cell, metres */
	float half_size;    /* half the root cell's side, metres, > 0 */
	uint32_t max_depth; /* 0..20: cells are never smaller than 2 * half_size / 2^max_depth */
} stilb_cull_octree_desc;

/* STILB_ERROR_ARGUMENT: desc is out of the ranges above, or STILB_ISA is wrong. [any-thread] */
stilb_result stilb_cull_octree_create(const stilb_cull_octree_desc *desc, stilb_cull_octree **octree);

/* NULL is fine. [one-writer] */
void stilb_cull_octree_destroy(stilb_cull_octree *octree);

/* Adds object id (any number below 2^31; dense ids keep the tree small). STILB_ERROR_ARGUMENT: it is in the tree already,
 * or too large. [one-writer] */
stilb_result stilb_cull_octree_insert(stilb_cull_octree *octree, uint32_t id, stilb_sphere bounds);

/* New bounds for an object of the tree. STILB_ERROR_ARGUMENT: it is not in the tree. [one-writer] */
stilb_result stilb_cull_octree_move(stilb_cull_octree *octree, uint32_t id, stilb_sphere bounds);

/* Takes an object out; an id that is not in the tree is ignored. [one-writer] */
void stilb_cull_octree_remove(stilb_cull_octree *octree, uint32_t id);

/* Sets bit id % 64 of bits[id / 64] for every visible object, and leaves the others as they are. [one-writer] */
stilb_result stilb_cull_octree_mark(stilb_cull_octree *octree, const stilb_frustum *frustum, uint64_t *bits);

#endif
