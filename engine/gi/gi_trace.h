/*
 * gi_trace: rays against the triangles, behind one call, so that a test can put another intersector there.
 * Rays and hits are Embree's structs. [any-thread]
 */
#ifndef STILB_GI_TRACE_H
#define STILB_GI_TRACE_H

#include <embree3/rtcore.h>
#include <stdbool.h>
#include <stdint.h>

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

#endif
