/*
 * gi_integrator: what turns camera rays into radiance, one function for each name of STILB_GI_INTEGRATORS.
 *
 * gi_render.c makes a batch of camera samples of one tile, traces the camera rays sixteen at a time, fills the hits, and hands
 * it to the integrator, which writes radiance. A sample's result must depend on nothing but the sample: not on the batch it is
 * in, not on the worker.
 */
#ifndef STILB_GI_INTEGRATOR_H
#define STILB_GI_INTEGRATOR_H

#include "gi/gi_render.h"
#include "gi/gi_surface.h"
#include "gi/sample/gi_sampler.h"

struct gi_cache;

/* What all batches of a render share; nobody writes it while batches run (gi_cache says itself what it allows). */
typedef struct gi_view {
	const stilb_gi_scene *scene;
	stilb_gi_settings settings;
	gi_sampler sampler;
	struct gi_cache *cache; /* IRRADIANCE_CACHE only */
} gi_view;

#define GI_BATCH 1024 /* samples at most */

typedef struct gi_batch {
	const gi_view *view;
	uint32_t worker;
	uint32_t count;
	const gi_point *points; /* [count] */
	const gi_ray_hit *rays; /* [count] camera rays and what they hit; direction is unit */
	stilb_vec3 *radiance;   /* [count] out */
	void *scratch; /* of this worker: gi_integrator.scratch_size bytes, cache line aligned, kept between batches */
	uint64_t rays_traced, shadow_rays; /* out: added to */
} gi_batch;

typedef struct gi_integrator {
	void (*shade)(gi_batch *batch);
	size_t scratch_size;
} gi_integrator;

const gi_integrator *gi_integrator_of(stilb_gi_integrator name); /* gi_integrator.c */

extern const gi_integrator gi_integrator_color, gi_integrator_direct, gi_integrator_ao; /* gi_simple.c */
extern const gi_integrator gi_integrator_montecarlo;                                    /* gi_montecarlo.c */
extern const gi_integrator gi_integrator_path, gi_integrator_split;                     /* gi_path.c */
extern const gi_integrator gi_integrator_irradiance_cache;                              /* gi_cache_shade.c */

/* For a whole batch of rays that are traced already: radiance[i] is what the surface that rays[i] hit reflects towards its
 * origin, after depth reflections at most; nothing for a miss. Scratch is gi_integrator_path's. gi_path.c. */
void gi_path_gather(gi_batch *batch, uint32_t vertex, uint32_t depth);

#endif
