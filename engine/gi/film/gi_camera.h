/*
 * gi_camera: from pixels to rays. [any-thread]
 *
 * Depth of field. The pinhole's ray meets the focal plane, at distance `focus` along the view axis, in a point; the
 * ray through a point of the aperture starts there and goes to the same point. So points of the plane are sharp, and
 * a point at depth z is spread over a disk of diameter 2 r |z - focus| / (z focus) in the picture plane at distance
 * 1, with r the radius of the aperture.
 *
 * Clip planes. A ray begins in the plane at distance near_z along the view axis and ends in the one at far_z, as frames
 * draw what lies between them: along the ray that is near_z / cos, with the angle between ray and axis.
 */
#ifndef STILB_GI_CAMERA_H
#define STILB_GI_CAMERA_H

#include "gi/gi_render.h"
#include "gi/trace/gi_trace.h"

typedef struct gi_camera {
	stilb_vec3 position, right, up, forward; /* in world space; the last three are the camera's axes, unit */
	float half_width, half_height;           /* of the part of the plane at distance 1 that the picture shows */
	float to_u, to_v;                        /* from pixels to units of that plane */
	float near_z, far_z;                     /* of the clip planes */
	stilb_gi_lens lens;
} gi_camera;

gi_camera gi_camera_make(const stilb_scene_camera *camera, const stilb_gi_lens *lens, uint32_t width, uint32_t height);

/* A point of the aperture, metres along right and up, uniform over it; u in [0, 1)^2. */
stilb_vec2 gi_camera_aperture(const gi_camera *camera, stilb_vec2 u);

/* The ray through (x, y), in pixels from the top left corner of the picture; lens in [0, 1)^2 chooses the point of
 * the aperture. direction is unit, t_min and t_max lie in the clip planes, nothing is hit. */
void gi_camera_ray(const gi_camera *camera, float x, float y, stilb_vec2 lens, gi_ray_hit *ray);

/* An offset from the pixel's centre, in pixels, distributed like the filter's weights: all weights are positive, so
 * all samples count the same. u in [0, 1)^2. Source: Ernst, Stamminger, Greiner, "Filter importance sampling"
 * (2006). */
stilb_vec2 gi_filter_offset(stilb_gi_filter_kind filter, stilb_vec2 u);

#endif
