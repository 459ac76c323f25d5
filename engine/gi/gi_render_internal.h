/*
 * gi_render_internal: what stands behind stilb_gi_render, for the files that drive, save and resume it.
 */
#ifndef GI_RENDER_INTERNAL_H
#define GI_RENDER_INTERNAL_H

#include "base/base_contract.h"
#include "gi/cache/gi_cache_fill.h"
#include "gi/film/gi_camera.h"
#include "gi/film/gi_film.h"
#include "gi/film/gi_primary.h"
#include "gi/integrate/gi_integrator.h"

/* What one thread has done. It alone adds, and stilb_gi_render_progress reads meanwhile: all relaxed, a little old is fine. */
typedef struct gi_render_counters {
	_Atomic uint64_t samples, rays, camera_rays, shadow_rays, bad_samples;
} gi_render_counters;

/* The same, added up. */
typedef struct gi_render_totals {
	uint64_t samples, rays, camera_rays, shadow_rays, bad_samples;
} gi_render_totals;

/* A thread's batch: samples of one tile. */
typedef struct gi_render_worker {
	gi_render_counters counters;
	uint32_t count;
	gi_point points[GI_BATCH];
	size_t pixels[GI_BATCH];
	uint16_t x[GI_BATCH], y[GI_BATCH];
	stilb_vec3 radiance[GI_BATCH];
	gi_primary primary;
	void *scratch; /* the integrator's */
} __attribute__((aligned(STILB_CACHE_LINE))) gi_render_worker;

struct stilb_gi_render {
	stilb_owner owner; /* the thread that created it */
	gi_view view;
	gi_cache_fill *cache_fill; /* IRRADIANCE_CACHE only */
	gi_camera camera;
	const gi_primary_kernels *kernels;
	const gi_integrator *integrator;
	stilb_job_pool *pool;
	gi_film film;
	gi_render_worker *workers; /* one for each thread of the pool, the owner first */
	uint32_t worker_count;
	uint32_t batch_size;      /* samples, at most GI_BATCH */
	gi_render_totals resumed; /* done before the checkpoint that was resumed */
	bool overture_finished;   /* of the irradiance cache */

	/* Set by anybody, read by all threads before each batch, cleared when run returns; relaxed: it orders nothing. */
	_Atomic bool stop;
	_Atomic bool cut;     /* a tile of this pass was left undone; relaxed: read after the loop over tiles has joined */
	uint64_t deadline_ns; /* of stilb_time_ns; 0: none. Written before the loop over tiles */

	/* What progress tells of the run as a whole: written by run, under the lock. */
	stilb_lock lock;
	double seconds;       /* of finished calls of run */
	uint64_t begun_ns;    /* of the one that runs; 0: none */
	double overture_done; /* share; 1 without one */
	double estimate;      /* gi_film_error after the last whole pass; +infinity before */
	char stage[32];
	stilb_gi_end end;
	uint32_t pass_count;
	stilb_gi_pass passes[STILB_GI_MAX_PASSES];
};

gi_render_totals gi_render_totals_of(const stilb_gi_render *render);

#endif
