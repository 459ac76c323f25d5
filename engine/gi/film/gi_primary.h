/*
 * gi_primary: traces camera rays, and finds at their first hits what the picture's layers beside radiance show: albedo,
 * normal and depth. [any-thread]
 *
 * Sixteen rays at a time, in SIMD. One source, gi_primary_lanes.h, is compiled for each instruction set; all give
 * the same bits.
 */
#ifndef STILB_GI_PRIMARY_H
#define STILB_GI_PRIMARY_H

#include "gi/film/gi_camera.h"
#include "gi/integrate/gi_integrator.h"

typedef struct gi_primary {
	gi_ray_hit rays[GI_BATCH]; /* the directions are unit */
	float albedo[GI_BATCH][4]; /* diffuse + specular reflectance, or what is unlit; [3] is unused; 0 for a miss */
	float normal[GI_BATCH][4]; /* shading normal in world space, [3] is unused; 0 for a miss */
	float depth[GI_BATCH];     /* along the view axis, metres; +infinity for a miss */
} gi_primary;

/* Samples to be traced. Neighbours in the arrays should be neighbours in the picture: each sixteen make a packet. */
typedef struct gi_primary_samples {
	uint32_t count;         /* at most GI_BATCH */
	const uint16_t *x, *y;  /* [count] pixels, from the top left corner */
	const gi_point *points; /* [count] */
} gi_primary_samples;

/* The functions for one instruction set; the struct is at the end of this file. */
typedef struct gi_primary_kernels gi_primary_kernels;

/* The functions for an instruction set, which this CPU must have. */
const gi_primary_kernels *gi_primary_kernels_for(stilb_isa isa);

/* Traces the camera rays of all samples and fills out[0] .. out[count - 1]; writes up to the next multiple of 16. */
void gi_primary_trace(const gi_primary_kernels *kernels, const gi_view *view, const gi_camera *camera,
                      const gi_primary_samples *samples, gi_primary *out);

/* ---- inside ------------------------------------------------------------------------------------------------------ */

/* Where the samples' camera rays go through the picture, in pixels, and numbers in [0, 1)^2 that choose the point on
 * the lens. */
typedef struct gi_primary_places {
	float x[GI_BATCH], y[GI_BATCH], lens_u[GI_BATCH], lens_v[GI_BATCH];
	float chance[GI_BATCH]; /* gi_ray.time; of scenes in which something blends, else unset */
} gi_primary_places;

typedef struct gi_primary_packet {
	gi_ray_hit16 rays;
	const gi_part *parts[16]; /* the part that each lane hit; NULL: none */
	const gi_triangle *triangles[16];
} gi_primary_packet;

struct gi_primary_kernels {
	/* The two random numbers of a dimension (gi_sample_2d) for Sobol points; count is a multiple of 16. */
	void (*sobol)(const gi_point *points, uint32_t dimension, uint32_t count, float *u, float *v);
	/* gi_camera_ray for places first .. first + 15; first is a multiple of 16. */
	void (*rays)(const gi_camera *camera, const gi_primary_places *places, uint32_t first, gi_ray_hit16 *rays);
	/* Rays and surfaces of a packet to out[first] .. out[first + 15]; first is a multiple of 16. */
	void (*surfaces)(const stilb_gi_scene *scene, const gi_camera *camera, const gi_primary_packet *packet,
	                 uint32_t first, gi_primary *out);
};

extern const gi_primary_kernels gi_primary_kernels_scalar, gi_primary_kernels_avx2, gi_primary_kernels_avx512;

#endif
