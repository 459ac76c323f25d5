/*
 * gi_integrator: turns camera rays into radiance; one integrator for each name in STILB_GI_INTEGRATORS.
 *
 * gi_render.c makes a batch of samples of one tile, traces their camera rays, and gives the batch to the integrator,
 * which writes radiance. The result of a sample must depend on that sample alone: not on the batch, not on the
 * worker.
 */
#ifndef STILB_GI_INTEGRATOR_H
#define STILB_GI_INTEGRATOR_H

#include "gi/gi_render.h"
#include "gi/gi_surface.h"
#include "gi/sample/gi_sampler.h"

struct gi_cache;

/* Data that all batches of a render share. Constant while batches run, except for the cache, which synchronises
 * itself. */
typedef struct gi_view {
	const stilb_gi_scene *scene;
	stilb_gi_settings settings;
	gi_sampler sampler;
	struct gi_cache *cache; /* IRRADIANCE_CACHE only */
} gi_view;

/* The lights that are sampled. */
static inline const gi_lights *gi_view_lights(const gi_view *view)
{
	return view->settings.no_shadows ? &view->scene->open_lights : &view->scene->lights;
}

#define GI_BATCH 1024 /* samples in a batch, at most */

typedef struct gi_batch {
	const gi_view *view;
	uint32_t worker;
	uint32_t count;
	const gi_point *points; /* [count] the samples' random numbers: gi_sampler.h */
	const gi_ray_hit *rays; /* [count] camera rays and their hits; directions are unit */
	stilb_vec3 *radiance;   /* [count] out */
	void *scratch; /* gi_integrator.scratch_size bytes of this worker, cache line aligned, kept between batches */
	uint64_t rays_traced, shadow_rays; /* out: rays traced, and shadow rays among them; the integrator adds to them */
} gi_batch;

typedef struct gi_integrator {
	void (*shade)(gi_batch *batch); /* writes batch->radiance; called by any number of threads, each its own batch */
	size_t scratch_size;            /* bytes that gi_batch.scratch must have */
} gi_integrator;

const gi_integrator *gi_integrator_of(stilb_gi_integrator name); /* gi_integrator.c */

extern const gi_integrator gi_integrator_color, gi_integrator_direct, gi_integrator_ao; /* gi_simple.c */
extern const gi_integrator gi_integrator_montecarlo;                                    /* gi_montecarlo.c */
extern const gi_integrator gi_integrator_path, gi_integrator_split;                     /* gi_path.c */
extern const gi_integrator gi_integrator_irradiance_cache;                              /* gi_cache_shade.c */

extern const gi_integrator gi_integrator_channel; /* gi_channel.c */

/* True if the integrator is CHANNEL and its values are no light. */
bool gi_shows_data(const stilb_gi_settings *settings);

/* Makes light of values of data: that whose sRGB code is the value. rgb: [pixels][3]. */
void gi_data_to_light(float *rgb, size_t pixels);

/* Writes the radiance that the surfaces at the ends of the batch's rays, which are traced already, reflect towards the
 * rays' origins, after at most depth reflections; 0 for a miss. vertex: the number of those ends on the path (0 is the
 * camera ray's hit), for random numbers. batch->scratch is of gi_integrator_path.scratch_size. In gi_path.c. */
void gi_path_gather(gi_batch *batch, uint32_t vertex, uint32_t depth);

#endif
