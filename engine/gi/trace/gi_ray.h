/*
 * gi_ray: Embree's ray structs from vectors, and back. [any-thread]
 *
 * Whole vectors are moved, as Embree itself does: a load that spans several stores just made has to wait for all of them.
 */
#ifndef STILB_GI_RAY_H
#define STILB_GI_RAY_H

#include "base/base_math.h"
#include "gi/trace/gi_trace.h"

#include <stddef.h>
#include <string.h>

_Static_assert(offsetof(RTCRay, tnear) == 12 && offsetof(RTCRay, dir_x) == 16 && offsetof(RTCRay, time) == 28 &&
                   offsetof(RTCRay, tfar) == 32 && offsetof(RTCRay, mask) == 36 && sizeof(RTCRay) == 48,
               "three vectors: origin and tnear, direction and time, tfar and three integers");
_Static_assert(offsetof(struct RTCHit, geomID) == 24 && offsetof(struct RTCHit, instID) == 28,
               "two vectors: ..., geomID, instID");

static inline stilb_vec3 gi_ray_org(const RTCRay *ray)
{
	stilb_vec3 org;
	memcpy(&org, (const char *)ray, sizeof org);
	return org;
}

static inline stilb_vec3 gi_ray_dir(const RTCRay *ray)
{
	stilb_vec3 dir;
	memcpy(&dir, (const char *)ray + 16, sizeof dir);
	return dir;
}

/* Four words of a ray. */
typedef int32_t gi_ray_words __attribute__((vector_size(16)));

/* From origin, tnear 0, to length. */
static inline RTCRay gi_ray_make(stilb_vec3 origin, stilb_vec3 direction, float length)
{
	stilb_vec4 tail = {length};
	gi_ray_words words;
	RTCRay ray;
	origin[3] = 0.0f;
	direction[3] = 0.0f;
	memcpy(&words, &tail, sizeof words);
	words[1] = -1; /* mask */
	memcpy((char *)&ray, &origin, sizeof origin);
	memcpy((char *)&ray + 16, &direction, sizeof direction);
	memcpy((char *)&ray + 32, &words, sizeof words);
	return ray;
}

/* Without an end, and nothing hit yet. */
static inline RTCRayHit gi_rayhit_make(stilb_vec3 origin, stilb_vec3 direction)
{
	const gi_ray_words zero = {0}, nothing = {0, 0, (int32_t)RTC_INVALID_GEOMETRY_ID, (int32_t)RTC_INVALID_GEOMETRY_ID};
	RTCRayHit ray;
	ray.ray = gi_ray_make(origin, direction, INFINITY);
	memcpy((char *)&ray.hit, &zero, sizeof zero);
	memcpy((char *)&ray.hit + 16, &nothing, sizeof nothing);
	return ray;
}

#endif
