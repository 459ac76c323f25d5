/*
 * gi_cache: the irradiance cache: diffuse indirect light is gathered at few places, the records, and interpolated
 * between them. This file holds the records and what is derived from the settings; three others work on it:
 *
 *   gi_cache_gather.h   makes a record at a surface
 *   gi_cache_fill.h     creates a cache, fills it before the picture (the overture), saves it
 *   gi_cache_file.h     reads and writes records
 *
 * Life cycle.  gi_cache_create -> find and add, from batches of the integrator irradiance_cache and from the overture
 *              -> gi_cache_destroy. gi_cache_fill.c creates and destroys it.
 * Threads.     create, destroy: one thread. All others: [any-thread], while others add.
 * Source:      Ward, Rubinstein, Clear, "A Ray Tracing Solution for Diffuse Interreflection" (1988); Ward, Heckbert,
 *              "Irradiance Gradients" (1992); Krivanek et al., "Making Radiance and Irradiance Caching Practical:
 *              Adaptive Caching and Neighbor Clamping" (2006); Schwarzhaupt, Jensen, Jarosz, "Practical Hessian-Based
 *              Error Control for Irradiance Caching" (2012).
 */
#ifndef STILB_GI_CACHE_H
#define STILB_GI_CACHE_H

#include "gi/cache/gi_cache_octree.h"
#include "gi/integrate/gi_integrator.h"

#include <stdatomic.h>

/* One thread's memory for gathering a record, a batch of the hemisphere's rays at a time. */
typedef struct gi_cache_worker {
	gi_ray_hit rays[GI_BATCH];
	gi_point points[GI_BATCH];
	stilb_vec3 radiance[GI_BATCH];
	stilb_vec3 left[GI_BATCH]; /* what glass on the ray leaves of that; set in scenes that light goes through */
	gi_ray shadows[GI_LIGHT_GROUPS * GI_BATCH]; /* [shadow_count] id: index of the ray at whose end it starts */
	/* [shadow_count] radiance that counts if the shadow ray is not occluded */
	stilb_vec3 direct[GI_LIGHT_GROUPS * GI_BATCH];
	uint32_t shadow_count;
	/* The rays that go on as paths: copies of ray and point, the radiance that the path finds, the index in rays. */
	gi_ray_hit path_rays[GI_BATCH];
	gi_point path_points[GI_BATCH];
	stilb_vec3 path_radiance[GI_BATCH];
	uint32_t targets[GI_BATCH];
	gi_cache_cell *cells; /* [gi_cache_strata_cells] */
	void *scratch;        /* gi_integrator_path.scratch_size bytes */
	/* Numbers of rays traced: of all kinds, and of shadow rays among these. Only the thread that works with this struct
	 * adds; gi_cache_fill_progress reads them at any time. Relaxed: they are for display, and order nothing. */
	_Atomic uint64_t traced;
	_Atomic uint64_t shadow_rays;
	char unused[STILB_CACHE_LINE];
} gi_cache_worker;

typedef struct gi_cache {
	const gi_view *view;
	stilb_vec3 eye;  /* the camera's position */
	float footprint; /* width of a pixel at distance 1 from the eye, metres */
	gi_cache_limits limits;
	gi_cache_strata strata;
	gi_cache_octree *octree;
	uint32_t worker_count;
	gi_cache_worker *workers; /* [worker_count] */
} gi_cache;

/* An empty cache for view->settings, which gi_settings_check accepts. view must outlive it; view->cache need not be set
 * yet. worker_count >= 1: threads that will make records. STILB_ERROR_MEMORY; then *out is NULL. */
stilb_result gi_cache_create(const gi_view *view, uint32_t worker_count, gi_cache **out);

/* Accepts NULL. */
void gi_cache_destroy(gi_cache *cache);

/* Limits for a record at that position: its shortest radius depends on the size of a pixel there. */
gi_cache_limits gi_cache_limits_at(const gi_cache *cache, stilb_vec3 position);

/* True if the surface reflects diffuse light, which is what a cache holds, and nothing lies on it. */
bool gi_cache_wants(const gi_surface *surface);

/* Irradiance at the surface, W m^-2, from all records that are valid there. False: none is, and irradiance is not
 * written. */
bool gi_cache_find(const gi_cache *cache, const gi_surface *surface, stilb_vec3 *irradiance);

/* True if a record would be used at the surface with an error below reach, in (0, 1]; the error is that of
 * gi_cache_record_error, 1 where a record ceases to be valid. */
bool gi_cache_covers(const gi_cache *cache, const gi_surface *surface, float reach);

/* True if a record lies within so many pixels' widths of the position. */
bool gi_cache_record_is_at(const gi_cache *cache, stilb_vec3 position, float pixels);

/* Adds a copy of the record; with the radius rule SPLIT_SPHERE its radii are first limited by those of its neighbours.
 * False: no memory. */
bool gi_cache_add(gi_cache *cache, const gi_cache_record *record);

#endif
