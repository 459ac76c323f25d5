/*
 * gi_primary: camera rays, what they hit, and the G-buffer of the picture's other layers. [any-thread]
 *
 * Sixteen rays at a time, in SIMD. One source, gi_primary_lanes.h, is compiled for each instruction set; the results are the
 * same bits.
 */
#ifndef STILB_GI_PRIMARY_H
#define STILB_GI_PRIMARY_H

#include "gi/film/gi_camera.h"
#include "gi/integrate/gi_integrator.h"

typedef struct gi_primary {
	gi_ray_hit rays[GI_BATCH]; /* direction is unit */
	float albedo[GI_BATCH][4]; /* diffuse + specular reflectance, [3] is not used; 0 for a miss */
	float normal[GI_BATCH][4]; /* shading normal in the world, [3] is not used; 0 for a miss */
	float depth[GI_BATCH];     /* along the view; +infinity for a miss */
} gi_primary;

/* Samples to be traced. Neighbours in the arrays should be neighbours in the picture: sixteen of them are one packet. */
typedef struct gi_primary_samples {
	uint32_t count;         /* at most GI_BATCH */
	const uint16_t *x, *y;  /* [count] pixels, from the top left corner */
	const gi_point *points; /* [count] */
} gi_primary_samples;

/* The functions for one instruction set, below. */
typedef struct gi_primary_kernels gi_primary_kernels;

/* Those for an instruction set that this CPU has. */
const gi_primary_kernels *gi_primary_kernels_for(stilb_isa isa);

/* Camera rays through all samples, and the first rows of out for each. out is written up to the next multiple of 16. */
void gi_primary_trace(const gi_primary_kernels *kernels, const gi_view *view, const gi_camera *camera,
                      const gi_primary_samples *samples, gi_primary *out);

/* ---- inside ------------------------------------------------------------------------------------------------------- */

/* Places in the picture in pixels, and points of [0, 1)^2 on the lens. */
typedef struct gi_primary_places {
	float x[GI_BATCH], y[GI_BATCH], lens_u[GI_BATCH], lens_v[GI_BATCH];
} gi_primary_places;

typedef struct gi_primary_packet {
	gi_ray_hit16 rays;
	const gi_part *parts[16]; /* that were hit; NULL: none */
	const gi_triangle *triangles[16];
} gi_primary_packet;

struct gi_primary_kernels {
	/* gi_sample_2d of Sobol points; count is a multiple of 16. */
	void (*sobol)(const gi_point *points, uint32_t dimension, uint32_t count, float *u, float *v);
	/* gi_camera_ray of sixteen places from first on. */
	void (*rays)(const gi_camera *camera, const gi_primary_places *places, uint32_t first, gi_ray_hit16 *rays);
	/* Rays and G-buffer of a packet to sixteen places of out from first on. */
	void (*surfaces)(const stilb_gi_scene *scene, const gi_camera *camera, const gi_primary_packet *packet,
	                 uint32_t first, gi_primary *out);
};

extern const gi_primary_kernels gi_primary_kernels_scalar, gi_primary_kernels_avx2, gi_primary_kernels_avx512;

#endif
