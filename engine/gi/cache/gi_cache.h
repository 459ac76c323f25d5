/*
 * gi_cache: the irradiance cache: diffuse indirect light is gathered at few places, the records, and interpolated
 * between them.
 *
 * Life cycle.  gi_cache_create -> gi_cache_prepare: the overture, which fills it -> batches of the integrator
 *              irradiance_cache read it (gi_view.cache) -> gi_cache_save -> gi_cache_destroy.
 * Modes.       FROZEN: the overture goes in rounds. The records of a round depend on those of older rounds alone and
 *              are added in the order of their pixels, and nothing is added after it: the same bits for every worker
 *              count.
 *              LIVE: whoever misses a record gathers it there and then, and everyone sees it at once.
 * Source:      Ward, Rubinstein, Clear, "A Ray Tracing Solution for Diffuse Interreflection" (1988); Ward, Heckbert,
 *              "Irradiance Gradients" (1992); Krivanek et al., "Making Radiance and Irradiance Caching Practical:
 *              Adaptive Caching and Neighbor Clamping" (2006); Schwarzhaupt, Jensen, Jarosz, "Practical Hessian-Based
 *              Error Control for Irradiance Caching" (2012).
 * Threads.     create, prepare, save, destroy: [main-thread] of the pool.
 */
#ifndef STILB_GI_CACHE_H
#define STILB_GI_CACHE_H

#include "gi/integrate/gi_integrator.h"
#include "jobs/job.h"

typedef struct gi_cache gi_cache;

typedef struct gi_cache_progress {
	uint32_t round;   /* of the overture, from 1 */
	double done;      /* share of the overture's pixels that have records, [0, 1] */
	uint32_t records; /* so far */
	uint64_t rays, shadow_rays;
} gi_cache_progress;

/* Called between rounds, on the thread that called prepare. False: stop. */
typedef bool gi_cache_report(void *user, const gi_cache_progress *progress);

/* Loads settings.cache.load if there is one. view must stay; its cache may be set afterwards. STILB_ERROR_ARGUMENT names
 * the setting that is out of its range; STILB_ERROR_FILE: what was to be loaded is no cache, is damaged, or belongs to
 * another scene or other settings; STILB_ERROR_MEMORY. */
stilb_result gi_cache_create(const gi_view *view, stilb_job_pool *pool, gi_cache **out);

/* The overture. Told to stop, it returns STILB_OK early, and the next call goes on where it was: with the same records in
 * the end. report may be NULL. STILB_ERROR_MEMORY. */
stilb_result gi_cache_prepare(gi_cache *cache, gi_cache_report *report, void *user);

/* Writes settings.cache.save, whole or not at all; nothing without one. */
stilb_result gi_cache_save(const gi_cache *cache);

void gi_cache_destroy(gi_cache *cache);

/* What it holds, and what it cost so far. [any-thread] */
gi_cache_progress gi_cache_progress_of(const gi_cache *cache);

#endif
