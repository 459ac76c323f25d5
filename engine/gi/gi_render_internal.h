/*
 * gi_render_internal: struct stilb_gi_render, for the files that drive, save and resume a render.
 */
#ifndef GI_RENDER_INTERNAL_H
#define GI_RENDER_INTERNAL_H

#include "base/base_contract.h"
#include "farm/farm.h"
#include "gi/cache/gi_cache_fill.h"
#include "gi/film/gi_camera.h"
#include "gi/film/gi_film.h"
#include "gi/film/gi_primary.h"
#include "gi/film/gi_unit.h"
#include "gi/integrate/gi_integrator.h"

/* Counters of one thread. That thread alone adds; stilb_gi_render_progress reads at any time. All accesses are relaxed:
 * no other data is read because of a counter's value, and progress may show a value that is a batch old. */
typedef struct gi_render_counters {
	_Atomic uint64_t samples, rays, camera_rays, shadow_rays, bad_samples;
} gi_render_counters;

/* The sums of all threads' counters. */
typedef struct gi_render_totals {
	uint64_t samples, rays, camera_rays, shadow_rays, bad_samples;
} gi_render_totals;

/* One thread's batch: samples of one tile that are rendered together. */
typedef struct gi_render_worker {
	gi_render_counters counters;
	uint32_t count;
	gi_point points[GI_BATCH];
	size_t pixels[GI_BATCH];
	uint16_t x[GI_BATCH], y[GI_BATCH];
	stilb_vec3 radiance[GI_BATCH];
	stilb_vec3 left[GI_BATCH]; /* what glass on the camera rays leaves of that; set in scenes that light goes through */
	gi_primary primary;
	void *scratch; /* of the integrator */
	/* With slices: the number of the loop that this thread has taken tiles of last, and when its slice of it ends. */
	uint64_t loop, slice_end_ns;
	bool added; /* samples were added to the film since the tile began */
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
	gi_render_worker *workers; /* one for each thread of the pool, the main thread's first */
	uint32_t worker_count;
	uint32_t until;           /* samples of each pixel, with which run returns; 0: all */
	uint32_t batch_size;      /* samples in a batch, at most GI_BATCH */
	uint32_t caller;          /* index in the pool of the thread that calls run: 0, or STILB_JOB_OUTSIDE */
	uint64_t slice_ns;        /* a loop over tiles ends after so long, and another one goes on; 0: never */
	uint64_t loop;            /* number of the loop over tiles */
	uint32_t first_tile;      /* of the pass that is being rendered: all tiles before it are done */
	uint32_t window;          /* tiles of a slice's loop at most, about as many as fit; 0: none is known */
	gi_render_totals resumed; /* counted before the checkpoint that was resumed */
	bool overture_finished;   /* the irradiance cache is filled */

	/* Of renders that are shared by machines (gi_farm.h); units.order is NULL in others. */
	gi_units units;
	stilb_farm_feed feed;           /* take NULL: run goes in passes over the whole picture */
	struct gi_identity *identity;   /* NULL until stilb_gi_farm_work makes it */
	uint32_t share_index, share_of; /* of a part; 0: the whole picture */
	uint64_t share_pixels;          /* 0: all of the picture */
	gi_render_counters others;      /* of other machines */
	/* The next unit of the share, counted from its first. Set by run before its loop, taken by the workers. Relaxed: no
	 * other data goes with it. */
	_Atomic uint32_t share_next;

	/* Asks run to return: set by any thread, read by all workers before each batch, cleared when run returns. Relaxed:
	 * no other data goes with it, and a worker that sees it late renders one more batch. */
	_Atomic bool stop;
	/* A tile of the current pass was not finished. Relaxed: it is read after the parallel loop over the tiles has
	 * ended, which orders the workers' stores before the read. */
	_Atomic bool cut;
	/* The first tile of the loop that was not finished, UINT32_MAX: none. Relaxed, as `cut`. */
	_Atomic uint32_t first_cut;
	uint64_t deadline_ns; /* time at which run ends, by stilb_time_ns; 0: none. Written before the loop over tiles */

	/* The program's view of progress; only the thread in run touches these. */
	stilb_gi_watch_fn *watch;
	void *watch_user;
	uint64_t watched_ns; /* when it was called last */

	/* For progress: written by run and read by progress, under the lock. */
	stilb_lock lock;
	double seconds;       /* of the calls of run that have returned */
	uint64_t begun_ns;    /* start of the current call of run; 0: none */
	double overture_done; /* share of the overture (filling the irradiance cache) that is done; 1 without one */
	double estimate;      /* gi_film_error after the last whole pass; +infinity before */
	char stage[32];
	stilb_gi_end end;
	uint32_t pass_count;
	stilb_gi_pass passes[STILB_GI_MAX_PASSES];
};

gi_render_totals gi_render_totals_of(const stilb_gi_render *render);

#endif
