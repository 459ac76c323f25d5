/*
 * gi_lanes: what vertices of paths on matt surfaces compute, sixteen at a time, by a function for each instruction set,
 * with the same bits in all. [any-thread]
 *
 *   lanes.surfaces[i] = ..., lanes.numbers[i] = ...      all lanes
 *   kernels->leave(&lanes);                              origin, next
 *   lanes.shapes[i] = ..., lanes.chance[i] = ...         all lanes, if lights are asked
 *   kernels->ask(&lanes);                                light, weight
 */
#ifndef STILB_GI_LANES_H
#define STILB_GI_LANES_H

#include "gi/gi_surface.h"
#include "gi/light/gi_light_shape.h"

#define GI_LANES 16u

typedef struct gi_lanes {
	const gi_surface *surfaces[GI_LANES]; /* also of vertices that are not matt, whose results nobody reads */
	const float *numbers[GI_LANES];       /* gi_sample_8 of the vertex */
	/* Out, of leave. */
	stilb_vec4 origin[GI_LANES]; /* of rays that leave the surface: gi_surface_ray_origin on the viewer's side */
	stilb_vec4
		next[GI_LANES]; /* direction by the cosine, unit, and its density; [3] is 0 if it is below the triangle */

	const gi_light_shape *shapes[GI_LANES]; /* the light that is asked: a rectangle */
	float chance[GI_LANES];                 /* the probability of its choice; 0: no light is asked */
	/* Out, of ask. */
	stilb_vec4 light[GI_LANES]; /* direction to a point of it, unit, and in [3] t_max of the shadow ray */
	/* Times the shape's emission and the surface's diffuse reflectance it is the radiance reflected to the viewer, with
	 * its weight by multiple importance sampling against `next`; 0: none. */
	float weight[GI_LANES];

	/* Between the two: rows of vectors. */
	float rows_origin[4][GI_LANES], rows_normal[4][GI_LANES], rows_geometric[4][GI_LANES];
} __attribute__((aligned(64))) gi_lanes;

typedef struct gi_lanes_kernels {
	void (*leave)(gi_lanes *lanes);
	void (*ask)(gi_lanes *lanes);
} gi_lanes_kernels;

extern const gi_lanes_kernels gi_lanes_scalar, gi_lanes_avx2, gi_lanes_avx512;

/* The functions for an instruction set, which this CPU must have. */
const gi_lanes_kernels *gi_lanes_for(stilb_isa isa);

/* Those for stilb_cpu_isa. */
const gi_lanes_kernels *gi_lanes_of_cpu(void);

#endif
