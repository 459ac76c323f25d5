/*
 * gi_camera: pixels to rays. [any-thread]
 *
 * Depth of field by the focal plane: the pinhole's ray meets the plane at `focus` along the view axis; the ray through a point
 * of the aperture starts there and goes to that same point. So a point of the plane is sharp for every aperture point, and one
 * at depth z off it is spread over a disk of diameter 2 r |z - focus| / z x (1 / focus) in units of the picture plane at 1 m.
 */
#ifndef STILB_GI_CAMERA_H
#define STILB_GI_CAMERA_H

#include "gi/gi_render.h"
#include "gi/trace/gi_trace.h"

typedef struct gi_camera {
	stilb_vec3 position, right, up, forward; /* unit */
	float half_width, half_height;           /* of the picture plane at distance 1 */
	float to_u, to_v;                        /* pixels to the plane */
	stilb_gi_lens lens;
} gi_camera;

gi_camera gi_camera_make(const stilb_scene_camera *camera, const stilb_gi_lens *lens, uint32_t width, uint32_t height);

/* A point of the aperture, from u in [0, 1)^2: metres along right and up. */
stilb_vec2 gi_camera_aperture(const gi_camera *camera, stilb_vec2 u);

/* The ray through (x, y) in pixels from the top left corner of the picture, lens in [0, 1)^2. direction is unit, t_min 0, t_max inf. */
void gi_camera_ray(const gi_camera *camera, float x, float y, stilb_vec2 lens, gi_ray_hit *ray);

/* Where in the filter: pixel coordinates relative to the pixel's centre, distributed as the filter's weight (all weights are
 * positive, so that every sample counts the same). Source: Ernst, Stamminger, Greiner, "Filter importance sampling" (2006). */
stilb_vec2 gi_filter_offset(stilb_gi_filter_kind filter, stilb_vec2 u);

#endif
