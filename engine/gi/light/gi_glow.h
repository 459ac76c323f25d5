/*
 * gi_glow: what a triangle emits that is not the same all over: by a map of emission, or by alpha, which lets a share
 * of rays through and so takes as much from what is asked of it as a light, or by a clear coat. [any-thread]
 */
#ifndef STILB_GI_GLOW_H
#define STILB_GI_GLOW_H

#include "gi/gi_maps.h"

typedef struct gi_glow {
	gi_maps maps;        /* surface is NULL of a triangle that emits the same all over */
	gi_place corners[3]; /* of the triangle */
} gi_glow;

/* Radiance times alpha at a point of the triangle; u and v: barycentric, of its second and third corner. */
stilb_vec3 gi_glow_at(const gi_glow *glow, float u, float v);

/* The same towards a point that sees the triangle at this cosine: what a clear coat leaves of it. */
stilb_vec3 gi_glow_towards(const gi_glow *glow, float u, float v, float cosine);

/* Its mean over the triangle, from points about two texels apart, fewer where its longest side covers more than 128:
 * the same for the same glow. 0 of one that was found dark at all of them. */
stilb_vec3 gi_glow_mean(const gi_glow *glow);

/* True if no texel is above 0 in red, green or blue. Reads the picture up to the first one. */
bool gi_glow_is_dark(const stilb_image *image);

#endif
