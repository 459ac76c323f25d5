/*
 * gi_trace: rays, what they hit, and the one interface through which they are traced, so that a test can put another
 * intersector behind it. [any-thread]
 *
 *   gi_ray_hit ray = gi_ray_hit_make(origin, direction);      gi_ray.h
 *   tracer->intersect(tracer, &ray);
 *   if (gi_is_hit(&ray))
 *       ... ray.ray.t_max metres away, on triangle ray.hit.triangle of part ray.hit.part
 *
 * Layout.  A ray is three vectors of 16 bytes and a hit is two, so that whole vectors are loaded and stored. It is also
 *          the layout of Embree's structs: gi_embree.c asserts that, field by field, and passes these on as they are.
 *          Nothing outside gi/trace names a type of Embree.
 */
#ifndef STILB_GI_TRACE_H
#define STILB_GI_TRACE_H

#include "base/base.h"

#include <stdbool.h>
#include <stdint.h>

#define GI_PACKET 16u /* rays that are traced together */

/* gi_hit.part of a ray that hit nothing; gi_hit.instance of a hit on a triangle that is no instance's. */
#define GI_NO_PART UINT32_MAX

/* Kinds of rays, the bits of gi_ray.mask. A ray meets the parts whose gi_part.mask has one of its bits; a ray without
 * any meets nothing. */
#define GI_MASK_LOOK 1u  /* from the camera, and on from surfaces to what they mirror or what lights them indirectly */
#define GI_MASK_LIGHT 2u /* from a surface towards lights: what it meets casts a shadow */
#define GI_MASK_ALL UINT32_MAX

/* The segment origin + t direction, t_min < t <= t_max. direction need not be unit; t counts in its length. */
typedef struct gi_ray {
	float origin[3], t_min;
	float direction[3];
	float time;     /* [0, 1): a random number of this ray alone, by which it goes through surfaces that are
	                   half there (gi_cover.h). Embree calls the member so; nothing moves */
	float t_max;    /* out: where the hit is; of an occluded shadow ray -infinity */
	uint32_t mask;  /* GI_MASK_... */
	uint32_t id;    /* for the caller, kept as it is */
	uint32_t flags; /* 0 */
} __attribute__((aligned(16))) gi_ray;

typedef struct gi_hit {
	float normal[3];   /* of the triangle, in world space, counter-clockwise side, not unit */
	float u, v;        /* barycentric: the point is (1 - u - v) a + u b + v c of the corners a, b, c */
	uint32_t triangle; /* its index in the mesh of the part */
	uint32_t part;     /* its index in the scene, of instances too; GI_NO_PART: the ray hit nothing */
	uint32_t instance; /* Embree's number of the instance; GI_NO_PART: no instance. For the intersector's own use */
} __attribute__((aligned(16))) gi_hit;

/* A ray and the closest hit on it. */
typedef struct gi_ray_hit {
	gi_ray ray;
	gi_hit hit;
} gi_ray_hit;

/* Sixteen rays, transposed: each number is a row over the sixteen lanes, [axis][lane] or [lane]. */
typedef struct gi_ray16 {
	float origin[3][GI_PACKET], t_min[GI_PACKET];
	float direction[3][GI_PACKET], time[GI_PACKET];
	float t_max[GI_PACKET];
	uint32_t mask[GI_PACKET], id[GI_PACKET], flags[GI_PACKET];
} __attribute__((aligned(64))) gi_ray16;

typedef struct gi_hit16 {
	float normal[3][GI_PACKET];
	float u[GI_PACKET], v[GI_PACKET];
	uint32_t triangle[GI_PACKET], part[GI_PACKET], instance[GI_PACKET];
} __attribute__((aligned(64))) gi_hit16;

typedef struct gi_ray_hit16 {
	gi_ray16 ray;
	gi_hit16 hit;
} gi_ray_hit16;

/* The functions that trace rays against the triangles of one scene. */
typedef struct gi_tracer gi_tracer;
struct gi_tracer {
	/* The closest hit of one ray: t_max and hit. hit.part is GI_NO_PART before. */
	void (*intersect)(const gi_tracer *tracer, gi_ray_hit *ray);
	/* The closest hits of sixteen rays with nearby origins and directions. valid: [16], -1 to trace that lane or 0,
	 * 64-byte aligned. */
	void (*intersect16)(const gi_tracer *tracer, const int *valid, gi_ray_hit16 *rays);
	/* Any hit: t_max becomes -infinity where something lies on the segment, and stays as it is where nothing does. */
	void (*occluded)(const gi_tracer *tracer, gi_ray *rays, uint32_t count);
	void *state;
};

static inline bool gi_is_hit(const gi_ray_hit *ray)
{
	return ray->hit.part != GI_NO_PART;
}

/* One lane of sixteen. */
static inline gi_ray_hit gi_ray_of(const gi_ray_hit16 *rays, uint32_t lane)
{
	STILB_ASSERT(lane < GI_PACKET);
	const gi_ray16 *ray = &rays->ray;
	const gi_hit16 *hit = &rays->hit;
	return (gi_ray_hit){
		.ray = {.origin = {ray->origin[0][lane], ray->origin[1][lane], ray->origin[2][lane]},
	            .t_min = ray->t_min[lane],
	            .direction = {ray->direction[0][lane], ray->direction[1][lane], ray->direction[2][lane]},
	            .time = ray->time[lane],
	            .t_max = ray->t_max[lane],
	            .mask = ray->mask[lane],
	            .id = ray->id[lane],
	            .flags = ray->flags[lane]},
		.hit = {.normal = {hit->normal[0][lane], hit->normal[1][lane], hit->normal[2][lane]},
	            .u = hit->u[lane],
	            .v = hit->v[lane],
	            .triangle = hit->triangle[lane],
	            .part = hit->part[lane],
	            .instance = hit->instance[lane]},
	};
}

#endif
