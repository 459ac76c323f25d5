/*
 * gi_cache_fill: owns an irradiance cache and fills it before the picture is made: the overture.
 *
 * Life cycle.  gi_cache_fill_create -> gi_view.cache = gi_cache_fill_records -> gi_cache_fill_run, until it has
 *              finished -> the picture -> gi_cache_fill_save -> gi_cache_fill_destroy.
 * Modes.       FROZEN: the overture goes in rounds. The records of a round depend on those of earlier rounds alone and
 *              are added in the order of their pixels, and nothing is added after the overture: the same bits for any
 *              number of workers.
 *              LIVE: a thread that finds no record for a pixel gathers one at once, and all other threads may use it.
 * Threads.     create, run, save, destroy: [main-thread] of the pool. progress: [any-thread].
 */
#ifndef STILB_GI_CACHE_FILL_H
#define STILB_GI_CACHE_FILL_H

#include "gi/cache/gi_cache.h"
#include "jobs/job.h"

typedef struct gi_cache_fill gi_cache_fill;

typedef struct gi_cache_progress {
	uint32_t round;   /* of the overture, from 1 */
	double done;      /* share of the overture's pixels that have records, [0, 1] */
	uint32_t records; /* so far */
	uint64_t rays, shadow_rays;
} gi_cache_progress;

/* Called after each round, on the thread that called run. False: stop. */
typedef bool gi_cache_report(void *user, const gi_cache_progress *progress);

/* A cache for view->settings, which gi_settings_check accepts; with the records of settings.cache.load if that is set.
 * view must outlive it. STILB_ERROR_ARGUMENT: a FROZEN cache that would stay empty, having neither an overture nor a
 * file to load; STILB_ERROR_FILE: see gi_cache_load; STILB_ERROR_MEMORY. Then *out is NULL. */
stilb_result gi_cache_fill_create(const gi_view *view, stilb_job_pool *pool, gi_cache_fill **out);

/* Accepts NULL. */
void gi_cache_fill_destroy(gi_cache_fill *fill);

/* The cache, for gi_view.cache; valid until destroy. */
gi_cache *gi_cache_fill_records(gi_cache_fill *fill);

/* Runs the overture. If report says stop it returns STILB_OK early; the next call goes on from there, and in the end
 * the records are the same as without a stop. report may be NULL. STILB_ERROR_MEMORY. */
stilb_result gi_cache_fill_run(gi_cache_fill *fill, gi_cache_report *report, void *user);

/* Writes settings.cache.save, if that is set: see gi_cache_save. */
stilb_result gi_cache_fill_save(const gi_cache_fill *fill);

/* The progress so far. [any-thread] */
gi_cache_progress gi_cache_fill_progress(const gi_cache_fill *fill);

#endif
