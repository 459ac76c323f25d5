/*
 * gi_cover: whether a ray that crosses a triangle meets it, or goes on as if nothing were there: where a MASK cuts it
 * out, by chance where it BLENDs with what is behind, and from behind where it is one-sided. [any-thread]
 *
 * An answer depends on the ray's number (gi_ray.time), the part and the triangle alone, not on the order in which an
 * intersector asks, nor on how often.
 */
#ifndef STILB_GI_COVER_H
#define STILB_GI_COVER_H

#include "gi/gi_scene_internal.h"

/* The number of a ray that meets all that blends, as if it were opaque; all others are below. */
#define GI_CHANCE_ALL 1.0f

/* Where a ray crosses a triangle of a part that has gi_part.sieve. */
typedef struct gi_crossing {
	uint32_t part, triangle;
	float u, v;   /* barycentric, as in gi_hit */
	float chance; /* gi_ray.time */
	bool front;   /* the ray comes from the triangle's front */
} gi_crossing;

/* A number in [0, 1) of the ray for this triangle; those of two triangles are independent. */
float gi_cover_number(const gi_crossing *crossing);

/* True if the ray ends there. */
bool gi_cover_meets(const stilb_gi_scene *scene, const gi_crossing *crossing);

#endif
