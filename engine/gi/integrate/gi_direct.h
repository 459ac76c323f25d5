/*
 * gi_direct: light straight from the lights at one vertex of a path, found in the two ways of multiple importance sampling: a
 * light is asked, or the next ray finds it. The weights of both ways add up to 1. [any-thread]
 */
#ifndef STILB_GI_DIRECT_H
#define STILB_GI_DIRECT_H

#include "gi/integrate/gi_integrator.h"
#include "gi/sample/gi_bsdf.h"

/* Asks one light. *direct is what the surface sends to its viewer if nothing lies on *shadow, a ray for gi_tracer.occluded;
 * false: nothing comes from there. origin: gi_surface_ray_origin's, on the viewer's side. numbers: gi_sample_8's of the vertex.
 * weighed: gi_direct_found counts the other share of this light, so that *direct is weighed against gi_bsdf_pdf. */
bool gi_direct_ask(const gi_view *view, const gi_bsdf *bsdf, stilb_vec3 origin, const float numbers[8], bool weighed,
                   gi_ray *shadow, stilb_vec3 *direct);

/* What a traced ray found that shines: the emission of surface, or of the surroundings where it is NULL. pdf is the density with
 * which the ray's direction was chosen at a surface of this normal, and weighs it against gi_direct_ask; 0: the light counts in
 * full. */
stilb_vec3 gi_direct_found(const gi_view *view, float pdf, stilb_vec3 normal, const gi_ray_hit *ray,
                           const gi_surface *surface);

#endif
