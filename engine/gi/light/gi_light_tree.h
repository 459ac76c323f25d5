/*
 * gi_light_tree: chooses one of many lights: a tree of boxes around lights, descended with probabilities proportional
 * to the irradiance that each of a node's children may send to a point. For gi_light.c and tests. [any-thread] once
 * built. A node has up to sixteen children: four levels of halves at once, of which the lower ones know more of what
 * is near. They are weighed eight at a time where there is AVX2, with the same bits without.
 *
 * A node's importance estimates irradiance: power over the mean squared distance, times the cosines at the light and at
 * the surface. Near the box the cosines are the largest that any point of the box allows; from afar the light's is a
 * mean over its surfaces. It is 0 only if none of its lights shines there. Source: Conty Estevez and Kulla,
 * "Importance Sampling of Many Lights with Adaptive Tree Splitting" (2018), without the splitting; the means are ours.
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
	uint32_t eight; /* index of the children's first gi_light_eight */
	float low[3], high[3];
	uint32_t parent; /* index; the root's is the root itself */
	uint32_t light;  /* of a leaf: its number, given by the caller */
} gi_light_node;

#define GI_LIGHT_LEAF UINT32_MAX

#define GI_LIGHT_CHILDREN 16u /* of a node, at most; a multiple of eight */

/* What importance reads of eight siblings, one a lane; lanes without a sibling are 0. */
typedef struct gi_light_eight {
	_Alignas(32) float center[3][8], radius2[8], axis[3][8], cos_cone[8], sin_cone[8], cos_beam[8], power[8], sum[3][8],
		spread[8];
} gi_light_eight;

/* The importance of a node's children, and sums of eight. */
typedef struct gi_light_weights {
	float each[GI_LIGHT_CHILDREN], eights[GI_LIGHT_CHILDREN / 8];
} gi_light_weights;

/* Weighs the children of a node, which fill count gi_light_eights. */
typedef void gi_light_weigh(const gi_light_eight *children, uint32_t count, stilb_vec3 position, stilb_vec3 normal,
                            gi_light_weights *weights);
gi_light_weigh gi_light_weigh_scalar, gi_light_weigh_avx2;

typedef struct gi_light_tree {
	gi_light_node *nodes;   /* the root first */
	gi_light_eight *eights; /* of the children of each node */
	gi_light_weigh *weigh;
	uint32_t node_count;
} gi_light_tree;

/* Builds the tree. leaves: [leaf_count] >= 1 with axis, cos_cone, cos_beam, power, lamps, box and light set; they are
 * reordered. False: no memory; then tree is {0}. */
bool gi_light_tree_build(gi_light_node *leaves, uint32_t leaf_count, gi_light_tree *tree);

/* Accepts {0}. */
void gi_light_tree_finish(gi_light_tree *tree);

/* Chooses a leaf, returned as index in nodes, with its probability; u in [0, 1). GI_LIGHT_LEAF: no light shines
 * there. */
uint32_t gi_light_tree_choose(const gi_light_tree *tree, stilb_vec3 position, stilb_vec3 normal, float u,
                              float *probability);

/* The probability with which gi_light_tree_choose returns this leaf. */
float gi_light_tree_probability(const gi_light_tree *tree, stilb_vec3 position, stilb_vec3 normal, uint32_t leaf);

#endif
