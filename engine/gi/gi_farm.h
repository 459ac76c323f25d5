/*
 * gi_farm: pictures that many machines make together, of the units that farm.h describes: squares of the picture.
 *
 *   A part:    stilb_gi_render_create -> stilb_gi_farm_share -> stilb_gi_render_run -> stilb_gi_farm_save_part
 *   The whole: stilb_gi_farm_merge, which needs neither the scene nor a render
 *   Machines that talk: stilb_gi_farm_begin -> stilb_gi_farm_work and stilb_gi_farm_feed, both to a crew (farm_crew.h)
 *              -> stilb_gi_render_run on all of them -> the first one has the picture
 *
 * Same bits.   A picture of parts has the bits of one that one machine made, by whatever parts and in whatever order
 *              they are merged. The irradiance cache's overture depends on the whole picture, and every machine
 *              computes all of it, so that a part depends on no other; settings.cache.save and load share it.
 * Threads.     [main-thread] of the render, but what a stilb_farm_work has.
 */
#ifndef GI_FARM_H
#define GI_FARM_H

#include "farm/farm.h"
#include "gi/gi_render.h"

/* Makes the picture one of units, before the first run. STILB_ERROR_ARGUMENT: its bits would depend on more than the
 * units: a limit of time, a limit of the error of the whole picture, or a live irradiance cache; STILB_ERROR_MEMORY. */
stilb_result stilb_gi_farm_begin(stilb_gi_render *render);

/* After begin: the render as work; it points into the render. */
stilb_farm_work stilb_gi_farm_work(stilb_gi_render *render);

/* After begin, while run does not run: the next runs render the units that the feed gives; progress is of the whole
 * picture. */
void stilb_gi_farm_feed(stilb_gi_render *render, const stilb_farm_feed *feed);

/* What other machines have traced: progress adds it to its own counts. [any-thread] */
typedef struct stilb_gi_farm_counts {
	uint64_t samples, rays, camera_rays, shadow_rays, bad_samples;
} stilb_gi_farm_counts;
void stilb_gi_farm_count(stilb_gi_render *render, const stilb_gi_farm_counts *more);

/* What this machine has traced. [any-thread] */
stilb_gi_farm_counts stilb_gi_farm_counted(const stilb_gi_render *render);

/* Begins, and lets run render share `index` of `of` alone, in as many calls as it takes. Checkpoints are then of that
 * share. Errors as begin. */
stilb_result stilb_gi_farm_share(stilb_gi_render *render, uint32_t index, uint32_t of);

/* Writes the part, whole or not at all, after run has finished. STILB_ERROR_FILE, STILB_ERROR_MEMORY. */
stilb_result stilb_gi_farm_save_part(const stilb_gi_render *render, const char *path);

/* What the parts tell of their making. */
typedef struct stilb_gi_farm_merged {
	uint32_t width, height, samples;
	uint64_t rays;
	double seconds; /* of all parts together */
} stilb_gi_farm_merged;

/* Puts a picture together from all its parts, in any order, denoises it on the pool if its settings say so, and writes
 * it as stilb_gi_render_save does: the same file as one machine's. STILB_ERROR_ARGUMENT: a part is missing, there
 * twice, or of another picture; STILB_ERROR_FILE: one is damaged, or the picture cannot be written;
 * STILB_ERROR_MEMORY. count >= 1. The pool's [main-thread]. */
stilb_result stilb_gi_farm_merge(const char *const *paths, uint32_t count, const char *output, stilb_job_pool *pool,
                                 stilb_gi_farm_merged *merged);

#endif
