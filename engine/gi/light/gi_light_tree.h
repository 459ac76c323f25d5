/*
 * gi_light_tree: chooses one of many lights: a tree of boxes around lights, descended with probabilities proportional
 * to the irradiance that each of a node's children may send to a point. For gi_light.c and tests. [any-thread] once
 * built. A node has up to four children: two levels of halves at once, for no more time, of which the lower one knows
 * more of what is near.
 *
 * A node's importance estimates irradiance: power over squared distance, times the cosines at the light and at the
 * surface. Near the box the cosines are the largest that any point of the box allows; from afar the light's is a
 * mean over its surfaces. It is 0 only if none of its lights shines there. Source: Conty Estevez and Kulla,
 * "Importance Sampling of Many Lights with Adaptive Tree Splitting" (2018), without the splitting; the mean over the
 * surfaces is ours.
 */
#ifndef STILB_GI_LIGHT_TREE_H
#define STILB_GI_LIGHT_TREE_H

#include "base/base.h"
#include "base/base_math.h"

typedef struct gi_light_node {
	float center[3], radius2; /* sphere around the box; importance sees the box as this */
	/* Axis of a cone that contains all normals of the surfaces (of a light without a size: all directions of its
	 * light). */
	float axis[3];
	float cos_cone; /* cosine of the cone's half angle; -1: all directions */
	float sin_cone;
	float cos_beam; /* cosine of the angle beyond the cone up to which light is emitted: 0 for surfaces */
	float power;    /* radiance x area, or intensity; mean of the colours */
	float sum[3];   /* sum of normal x power over the surfaces: the part of the power that goes one way */
	float spread;   /* the part of the power that goes all ways */
	float lamps;    /* the part of power that is from lights without a size */
	uint32_t child; /* index of the first child, the others follow; GI_LIGHT_LEAF: none */
	uint32_t child_count;
	float low[3], high[3];
	uint32_t parent; /* index; the root's is the root itself */
	uint32_t light;  /* of a leaf: its number, given by the caller */
} gi_light_node;

#define GI_LIGHT_LEAF UINT32_MAX

#define GI_LIGHT_CHILDREN 4u

/* Builds the tree; returns the number of its nodes. leaves: [leaf_count] >= 1 with axis, cos_cone, cos_beam, power,
 * lamps, box and light set; they are reordered. nodes: out, the root first; room for 2 * leaf_count - 1. */
uint32_t gi_light_tree_build(gi_light_node *nodes, gi_light_node *leaves, uint32_t leaf_count);

/* Estimate of the irradiance that a node's lights send to a surface. */
float gi_light_node_importance(const gi_light_node *node, stilb_vec3 position, stilb_vec3 normal);

/* Chooses a leaf, returned as index in nodes, with its probability; u in [0, 1). GI_LIGHT_LEAF: no light shines
 * there. */
uint32_t gi_light_tree_choose(const gi_light_node *nodes, stilb_vec3 position, stilb_vec3 normal, float u,
                              float *probability);

/* The probability with which gi_light_tree_choose returns this leaf. */
float gi_light_tree_probability(const gi_light_node *nodes, stilb_vec3 position, stilb_vec3 normal, uint32_t leaf);

#endif
