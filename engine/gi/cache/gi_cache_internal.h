/* gi_cache_internal: what the files of the irradiance cache share. */
#ifndef STILB_GI_CACHE_INTERNAL_H
#define STILB_GI_CACHE_INTERNAL_H

#include "gi/cache/gi_cache.h"
#include "gi/cache/gi_cache_octree.h"
#include "gi/film/gi_camera.h"

#include <stdatomic.h>

/* What a worker gathers with: a batch of the hemisphere's rays. */
typedef struct gi_cache_worker {
	gi_ray_hit rays[GI_BATCH];
	gi_point points[GI_BATCH];
	stilb_vec3 radiance[GI_BATCH];
	gi_ray shadows[GI_BATCH]; /* id: of the ray at whose end it starts; and what comes if nothing lies in the way */
	stilb_vec3 direct[GI_BATCH];
	gi_ray_hit path_rays[GI_BATCH]; /* those of the rays that go on as paths */
	gi_point path_points[GI_BATCH];
	stilb_vec3 path_radiance[GI_BATCH];
	uint32_t targets[GI_BATCH]; /* which they are */
	uint32_t shadow_count;
	gi_cache_cell *cells; /* [cells of the strata] */
	void *scratch;        /* of paths */
	/* This worker's own, read by whoever asks for progress; all rays, and of these: */
	_Atomic uint64_t traced;
	_Atomic uint64_t shadow_rays;
	char unused[STILB_CACHE_LINE];
} gi_cache_worker;

struct gi_cache_pixel;

/* Where the overture is. */
typedef struct gi_cache_overture {
	uint32_t block, strip;         /* what is looked at next; block 0: all has been looked at */
	uint32_t count, capacity;      /* of pixels */
	struct gi_cache_pixel *pixels; /* those that miss a record */
	gi_cache_record *records;      /* of a round */
	uint64_t looked;               /* pixels so far */
	_Atomic uint32_t round;        /* relaxed, both: numbers to show */
	_Atomic float done;
} gi_cache_overture;

struct gi_cache {
	const gi_view *view;
	stilb_job_pool *pool;
	gi_camera camera;
	float footprint; /* of a pixel at distance 1, metres */
	gi_cache_limits limits;
	gi_cache_strata strata;
	gi_cache_octree *octree;
	uint32_t worker_count;
	gi_cache_worker *workers;
	gi_cache_overture overture;
};

/* gi_cache.c */

/* The limits of a record at that place. [any-thread] */
gi_cache_limits gi_cache_limits_at(const gi_cache *cache, stilb_vec3 position);

/* Whether the surface reflects what a cache holds. [any-thread] */
bool gi_cache_wants(const gi_surface *surface);

/* Irradiance there from the records that hold; false: none does. [any-thread] */
bool gi_cache_find(const gi_cache *cache, const gi_surface *surface, stilb_vec3 *irradiance);

/* Whether a record lies there, to so many pixels. [any-thread] */
bool gi_cache_record_is_at(const gi_cache *cache, stilb_vec3 position, float pixels);

/* Adds a record, while others look up and add. False: no memory. [any-thread] */
bool gi_cache_add(gi_cache *cache, const gi_cache_record *record);

/* gi_cache_gather.c */

/* Gathers a record at a surface, with the numbers below point. [any-thread], each with its own worker. */
gi_cache_record gi_cache_gather(gi_cache *cache, uint32_t worker, const gi_surface *surface, gi_point point);

/* gi_cache_overture.c; overture is {0} for init, and finish accepts that. */
stilb_result gi_cache_overture_init(gi_cache_overture *overture, bool wanted);
void gi_cache_overture_finish(gi_cache_overture *overture);
stilb_result gi_cache_overture_run(gi_cache *cache, gi_cache_report *report, void *user);

/* gi_cache_file.c */
stilb_result gi_cache_load(gi_cache *cache, const char *path);

#endif
