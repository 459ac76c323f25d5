/*
 * gi_through: rays that go through glass without being scattered. [any-thread]
 *
 * Panes (thin walls of smooth glass) are passed straight on by chance, as what blends is (gi_cover.h), with the
 * probability gi_layers.pass; else the ray meets the pane, whose lobes weigh as much more. So camera, indirect and
 * shadow rays agree on what is behind a pane, lights without a size shine through, and nothing bounces there.
 * A ray that meets the back of a volume has come through it, and what it absorbs is left out of its light.
 */
#ifndef STILB_GI_THROUGH_H
#define STILB_GI_THROUGH_H

#include "gi/gi_scene_internal.h"

/* Traces on a ray that was traced, from its origin, until it meets something that is no pane, or a pane by chance.
 * Returns the factor on its light, 1 where there is no glass. *traced: the number of rays is added. */
stilb_vec3 gi_through(const stilb_gi_scene *scene, gi_ray_hit *ray, uint64_t *traced);

/* gi_tracer.occluded for shadow rays whose light, light[0..count), panes tint but do not block. */
void gi_through_occluded(const stilb_gi_scene *scene, gi_ray *rays, stilb_vec3 *light, uint32_t count);

/* gi_tracer.intersect, then gi_through. */
static inline stilb_vec3 gi_through_intersect(const stilb_gi_scene *scene, gi_ray_hit *ray, uint64_t *traced)
{
	scene->tracer.intersect(&scene->tracer, ray);
	*traced += 1;
	return scene->passes ? gi_through(scene, ray, traced) : stilb_vec3_make(1.0f, 1.0f, 1.0f);
}

#endif
