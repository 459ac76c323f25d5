/*
 * gi_light_tree: which of many lights to ask: a binary tree of boxes around lights, walked down by how much light each
 * half may send to a point. Used by gi_light.c alone, and by tests. [any-thread] once made.
 *
 * A node's importance estimates irradiance: power over squared distance, times the cosines at the light and at the surface.
 * Near the box, where one direction does not stand for all, these are taken where the box is most in favour of them; from afar
 * the light's is a mean over its surfaces. It is 0 only where none of its lights shines. Source: Conty Estevez and Kulla,
 * "Importance Sampling of Many Lights with Adaptive Tree Splitting" (2018), without the splitting; the mean is our own.
 */
#ifndef STILB_GI_LIGHT_TREE_H
#define STILB_GI_LIGHT_TREE_H

#include "base/base.h"
#include "base/base_math.h"

typedef struct gi_light_node {
	float center[3], radius2; /* of the sphere around the box: what importance looks at */
	float axis[3];            /* of a cone that holds every normal (of a light without a size: every direction) */
	float cos_cone;           /* its half angle; -1: everything */
	float sin_cone;
	float cos_beam; /* how far beyond it light goes: 0 for surfaces */
	float power;    /* radiance x area, or intensity */
	float sum[3];   /* of the surfaces' normals x power: what goes one way more than the other */
	float spread;   /* and what goes all ways */
	float lamps;    /* of power, that of lights without a size */
	uint32_t child; /* and child + 1; GI_LIGHT_LEAF: none */
	float low[3], high[3];
	uint32_t parent; /* of the root: itself */
	uint32_t light;  /* of a leaf: whatever number it was given */
} gi_light_node;

#define GI_LIGHT_LEAF UINT32_MAX

/* nodes: [2 * leaf_count - 1], the root first. leaves: [leaf_count], axis, cos_cone, cos_beam, power, lamps,
 * box and light are set; put in another order.
 * leaf_count >= 1. */
void gi_light_tree_build(gi_light_node *nodes, gi_light_node *leaves, uint32_t leaf_count);

/* Estimate of the irradiance that a node sends to a surface. */
float gi_light_node_importance(const gi_light_node *node, stilb_vec3 position, stilb_vec3 normal);

/* A leaf, by its place in nodes, and its probability. u in [0, 1). GI_LIGHT_LEAF: no light shines here. */
uint32_t gi_light_tree_choose(const gi_light_node *nodes, stilb_vec3 position, stilb_vec3 normal, float u,
                              float *probability);

/* The probability with which choose returns this leaf. */
float gi_light_tree_probability(const gi_light_node *nodes, stilb_vec3 position, stilb_vec3 normal, uint32_t leaf);

#endif
