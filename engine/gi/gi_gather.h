/*
 * gi_gather: the light that arrives at points of surfaces, for whoever keeps it there: lightmaps, probes.
 *
 * Each point is one sample: a light of each group is asked, and a ray goes on in a direction of cosine-weighted density
 * as a path of the integrator PATH, both weighed against each other by multiple importance sampling. What either finds
 * is told with the direction it came from, so that any basis can be summed.
 *
 * Life cycle.  stilb_gi_gather_create -> stilb_gi_gather_light and _open, any number -> stilb_gi_gather_destroy.
 * Same bits.   What a sample finds depends on its point, the scene and the settings alone.
 * Threads.     create, destroy: [main-thread] of the scene. light, open: [any-thread], each with a number of its own.
 * Units.       Metres of the world; irradiance in W m^-2.
 */
#ifndef GI_GATHER_H
#define GI_GATHER_H

#include "gi/gi_render.h"

typedef struct stilb_gi_gather stilb_gi_gather;

#define STILB_GI_GATHER_POINTS 1024u                        /* most of one call */
#define STILB_GI_GATHER_FOUND (4u * STILB_GI_GATHER_POINTS) /* most that one call finds */

/* A sample at a point of a triangle. */
typedef struct stilb_gi_gather_point {
	float corners[3][3]; /* counter-clockwise seen from the side that light arrives at; the triangle has an area */
	float u, v;          /* barycentric: the point is (1 - u - v) corners[0] + u corners[1] + v corners[2] */
	float normal[3];     /* unit, the one that irradiance is for, on the same side */
	uint32_t part;       /* of the scene, whose triangle it is */
	uint32_t x, y;       /* choose the random numbers, with settings.seed and */
	uint32_t sample;     /* the sample's number among those of (x, y) */
} stilb_gi_gather_point;

/* Light from one direction. The sum over what a sample found is an estimate of its irradiance. */
typedef struct stilb_gi_gathered {
	float irradiance[3]; /* on a surface with the point's normal */
	float direction[3];  /* unit, towards where it came from, above the point's normal */
	uint32_t point;      /* index in the call's points */
	float distance;      /* metres, along the point's ray, to what it met; INFINITY: nothing, or a light was asked */
	bool asked;          /* a light was asked; else the point's ray found it */
	bool back;           /* the point's ray met the back of a triangle */
} stilb_gi_gathered;

/* Of settings sampler, seed, samples, depth, only, model and roulette are read; depth 1 is direct light alone. threads:
 * how many numbers of threads there will be, >= 1. STILB_ERROR_ARGUMENT as of stilb_gi_render_create,
 * STILB_ERROR_MEMORY; then *out is NULL. */
stilb_result stilb_gi_gather_create(const stilb_gi_scene *scene, const stilb_gi_settings *settings, uint32_t threads,
                                    stilb_gi_gather **out);

/* Accepts NULL. */
void stilb_gi_gather_destroy(stilb_gi_gather *gather);

/* Takes a sample at each of count <= STILB_GI_GATHER_POINTS points. Writes at most STILB_GI_GATHER_FOUND entries to
 * found, in an order that depends on the points alone, and returns their number. thread: below `threads`. */
uint32_t stilb_gi_gather_light(stilb_gi_gather *gather, uint32_t thread, const stilb_gi_gather_point *points,
                               uint32_t count, stilb_gi_gathered *found);

/* open[i]: 1 if a ray of cosine-weighted density from point i meets nothing within distance (> 0, metres or INFINITY),
 * else 0. */
void stilb_gi_gather_open(stilb_gi_gather *gather, uint32_t thread, const stilb_gi_gather_point *points, uint32_t count,
                          float distance, float *open);

/* Rays that were traced so far, those towards lights among them; exact when no thread gathers. [any-thread] */
uint64_t stilb_gi_gather_rays(const stilb_gi_gather *gather);

#endif
