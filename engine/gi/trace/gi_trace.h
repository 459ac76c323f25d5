/*
 * gi_trace: rays against the triangles, behind one call, so that a test can put another intersector there.
 * Rays and hits are Embree's structs. [any-thread]
 */
#ifndef STILB_GI_TRACE_H
#define STILB_GI_TRACE_H

#include <embree3/rtcore.h>
#include <stdbool.h>
#include <stdint.h>

/* Embree names them for C++ alone. */
typedef struct RTCRay RTCRay;
typedef struct RTCRayHit RTCRayHit;
typedef struct RTCRayHit16 RTCRayHit16;

/* geomID of a hit is the part's number in the scene, for instances too (the intersector sees to it); u, v and primID are
 * Embree's; Ng is in the world's space and not unit. */
typedef struct gi_tracer gi_tracer;
struct gi_tracer {
	/* One ray, going anywhere. */
	void (*intersect)(const gi_tracer *tracer, RTCRayHit *ray);
	/* Sixteen that start side by side; valid: -1 or 0 each. */
	void (*intersect16)(const gi_tracer *tracer, const int *valid, RTCRayHit16 *rays);
	/* Many short questions: tfar becomes -infinity where something lies between tnear and tfar. */
	void (*occluded)(const gi_tracer *tracer, RTCRay *rays, uint32_t count);
	void *state;
};

static inline bool gi_hit(const RTCRayHit *ray)
{
	return ray->hit.geomID != RTC_INVALID_GEOMETRY_ID;
}

/* One of the sixteen. */
static inline RTCRayHit gi_ray_of(const RTCRayHit16 *rays, uint32_t i)
{
	return (RTCRayHit){
		.ray = {.org_x = rays->ray.org_x[i],
	            .org_y = rays->ray.org_y[i],
	            .org_z = rays->ray.org_z[i],
	            .tnear = rays->ray.tnear[i],
	            .dir_x = rays->ray.dir_x[i],
	            .dir_y = rays->ray.dir_y[i],
	            .dir_z = rays->ray.dir_z[i],
	            .time = rays->ray.time[i],
	            .tfar = rays->ray.tfar[i],
	            .mask = rays->ray.mask[i],
	            .id = rays->ray.id[i],
	            .flags = rays->ray.flags[i]},
		.hit = {.Ng_x = rays->hit.Ng_x[i],
	            .Ng_y = rays->hit.Ng_y[i],
	            .Ng_z = rays->hit.Ng_z[i],
	            .u = rays->hit.u[i],
	            .v = rays->hit.v[i],
	            .primID = rays->hit.primID[i],
	            .geomID = rays->hit.geomID[i],
	            .instID = {rays->hit.instID[0][i]}},
	};
}

#endif
