/*
 * gi_ray: makes rays of vectors, and reads the vectors of rays. [any-thread]
 *
 * Whole vectors are stored, not three floats each, since intersectors load whole vectors right after: a load of a
 * vector whose parts were stored one by one must wait until all of them have reached the cache (store forwarding
 * fails).
 */
#ifndef STILB_GI_RAY_H
#define STILB_GI_RAY_H

#include "base/base_math.h"
#include "gi/trace/gi_trace.h"

#include <assert.h>
#include <stddef.h>
#include <string.h>

static_assert(offsetof(gi_ray, t_min) == 12 && offsetof(gi_ray, direction) == 16 && offsetof(gi_ray, time) == 28 &&
                  offsetof(gi_ray, t_max) == 32 && offsetof(gi_ray, mask) == 36 && sizeof(gi_ray) == 48,
              "three vectors: origin and t_min, direction and time, t_max and three integers");
static_assert(offsetof(gi_hit, part) == 24 && offsetof(gi_hit, instance) == 28 && sizeof(gi_hit) == 32,
              "two vectors, the second ends with part and instance");

/* The ray's origin; lane 3 of the vector is its t_min. */
static inline stilb_vec3 gi_ray_origin(const gi_ray *ray)
{
	stilb_vec3 origin;
	memcpy(&origin, (const char *)ray, sizeof origin);
	return origin;
}

/* The ray's direction; lane 3 of the vector is its time. */
static inline stilb_vec3 gi_ray_direction(const gi_ray *ray)
{
	stilb_vec3 direction;
	memcpy(&direction, (const char *)ray + 16, sizeof direction);
	return direction;
}

/* The last four 4-byte words of a gi_ray or of a gi_hit. */
typedef int32_t gi_ray_words __attribute__((vector_size(16)));

/* A ray of this kind, GI_MASK_..., from origin (t_min is 0) to t_max = length, counted in lengths of direction; its id
 * is 0. chance: gi_ray.time, [0, 1). */
static inline gi_ray gi_ray_make_of(uint32_t mask, stilb_vec3 origin, stilb_vec3 direction, float length, float chance)
{
	stilb_vec4 tail = {length};
	gi_ray_words words;
	gi_ray ray;
	origin[3] = 0.0f;
	direction[3] = chance;
	memcpy(&words, &tail, sizeof words);
	words[1] = (int32_t)mask;
	memcpy((char *)&ray, &origin, sizeof origin);
	memcpy((char *)&ray + 16, &direction, sizeof direction);
	memcpy((char *)&ray + 32, &words, sizeof words);
	return ray;
}

/* A shadow ray. */
static inline gi_ray gi_ray_make(stilb_vec3 origin, stilb_vec3 direction, float length, float chance)
{
	return gi_ray_make_of(GI_MASK_LIGHT, origin, direction, length, chance);
}

/* A ray that looks, from origin to infinity, with room for its nearest hit, which is "none" until it is traced. */
static inline gi_ray_hit gi_ray_hit_make_by(stilb_vec3 origin, stilb_vec3 direction, float chance)
{
	gi_ray_words zero = {0}, nothing = {0, 0, (int32_t)GI_NO_PART, (int32_t)GI_NO_PART};
	gi_ray_hit ray;
	ray.ray = gi_ray_make_of(GI_MASK_LOOK, origin, direction, INFINITY, chance);
	memcpy((char *)&ray.hit, &zero, sizeof zero);
	memcpy((char *)&ray.hit + 16, &nothing, sizeof nothing);
	return ray;
}

static inline gi_ray_hit gi_ray_hit_make(stilb_vec3 origin, stilb_vec3 direction)
{
	return gi_ray_hit_make_by(origin, direction, 0.0f);
}

#endif
