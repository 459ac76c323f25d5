/*
 * gi_light_listed: how a light of the scene's list is sampled, of any kind. For gi_light.c and tests. [any-thread]
 *
 * No ray can hit these lights: spheres, disks and rectangles of the list are seen by no camera and in no mirror.
 * Spheres are sampled uniformly in the cone of directions that they fill, rectangles as gi_light_shape does, disks
 * uniformly by area. Source of the cone: Shirley, Wang, Zimmerman, "Monte Carlo Techniques for Direct Lighting
 * Calculations" (1996).
 */
#ifndef STILB_GI_LIGHT_LISTED_H
#define STILB_GI_LIGHT_LISTED_H

#include "gi/light/gi_light_shape.h"
#include "gi/light/gi_light_tree.h"

typedef struct gi_light_listed {
	stilb_scene_light light;
	gi_light_shape shape; /* of a RECTANGLE */
} gi_light_listed;

gi_light_listed gi_light_listed_make(const stilb_scene_light *light);

/* Samples the light: fills direction, distance, radiance, delta and pdf, the probability of choosing the light not
 * included: per steradian, or 1 for a light without a size. False: it sends nothing to position. u in [0, 1)^2. */
bool gi_light_listed_sample(const gi_light_listed *listed, stilb_vec3 position, stilb_vec2 u, gi_light_sample *sample);

/* The leaf of the tree for a light that has a position; its number `light` is left to the caller. */
gi_light_node gi_light_listed_node(const gi_light_listed *listed);

#endif
