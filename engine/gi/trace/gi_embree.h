/*
 * gi_embree: rays as structs of the ray tracing library Embree, and Embree's tree of a scene, for benches that measure
 * Embree alone. Only gi_embree.c and benches include it; no other file knows Embree's types.
 *
 * The conversions are casts: gi_embree.c asserts that both structs have the same layout. A cast pointer is for Embree's
 * functions; the caller itself reads and writes through its own type. [any-thread]
 */
#ifndef STILB_GI_EMBREE_H
#define STILB_GI_EMBREE_H

#include "gi/gi_scene.h"
#include "gi/trace/gi_trace.h"

#include <embree3/rtcore.h>

static inline struct RTCRay *gi_embree_ray(gi_ray *ray)
{
	return (struct RTCRay *)ray;
}

static inline struct RTCRayHit *gi_embree_ray_hit(gi_ray_hit *ray)
{
	return (struct RTCRayHit *)ray;
}

static inline struct RTCRay16 *gi_embree_ray16(gi_ray16 *rays)
{
	return (struct RTCRay16 *)rays;
}

static inline struct RTCRayHit16 *gi_embree_ray_hit16(gi_ray_hit16 *rays)
{
	return (struct RTCRayHit16 *)rays;
}

/* The tree of a scene that was created with stilb_gi_embree; valid as long as the scene. [any-thread] */
RTCScene gi_embree_scene(const stilb_gi_scene *scene);

#endif
