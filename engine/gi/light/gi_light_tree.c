#include "gi/light/gi_light_tree.h"

#include "gi/gi_vector.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* So many upper levels of the tree are split in the middle of the range of the lights' centres; those below, where that
 * has not separated them, into halves of equal number. */
#define MIDDLES_UNTIL 48u
#define BELOW_ONE 0.99999994f /* the largest float below 1 */

/* ---- building ---------------------------------------------------------------------------------------------------- */

/* Sets out's cone to the smallest that contains the cones of a and b. Source: Barequet and Elber, "Optimal bounding
 * cones of vectors in three dimensions" (2005), for two cones. */
static void join_cones(gi_light_node *out, const gi_light_node *a, const gi_light_node *b)
{
	const gi_light_node *wide = a->cos_cone < b->cos_cone ? a : b, *narrow = wide == a ? b : a;
	stilb_vec3 axis = gi_vector(wide->axis), other = gi_vector(narrow->axis);
	float cos_between = fminf(fmaxf(stilb_vec3_dot(axis, other), -1.0f), 1.0f);
	float between = acosf(cos_between), wide_angle = acosf(wide->cos_cone), narrow_angle = acosf(narrow->cos_cone);
	float angle = 0.5f * (wide_angle + between + narrow_angle);
	memcpy(out->axis, wide->axis, sizeof out->axis);
	out->cos_cone = wide->cos_cone;
	if (between + narrow_angle <= wide_angle)
		return;
	stilb_vec3 part = other - axis * cos_between;
	float size2 = stilb_vec3_dot(part, part);
	out->cos_cone = -1.0f;
	if (angle >= (float)M_PI || !(size2 > 1e-12f))
		return;
	float turn = angle - wide_angle;
	stilb_vec3 turned = axis * cosf(turn) + part * (sinf(turn) / sqrtf(size2));
	for (int i = 0; i < 3; i++)
		out->axis[i] = turned[i];
	out->cos_cone = cosf(fminf(angle + 1e-3f, (float)M_PI)); /* a margin for rounding */
}

/* Derives the fields of a node that importance reads. Surfaces whose normals point everywhere, like a sphere's, have a
 * sum (of normal x power) of 0, and each side sees a quarter of their power. Of surfaces that all face one way a side
 * sees the power times the cosine to that way. A mixture is split into these two. */
static void finish(gi_light_node *node)
{
	stilb_vec3 sum = gi_vector(node->sum);
	float rest = node->power - node->lamps - sqrtf(stilb_vec3_dot(sum, sum));
	node->spread = node->lamps + 0.25f * fmaxf(rest, 0.0f);
	stilb_vec3 half = (gi_vector(node->high) - gi_vector(node->low)) * 0.5f, center = gi_vector(node->low) + half;
	for (int i = 0; i < 3; i++)
		node->center[i] = center[i];
	node->radius2 = stilb_vec3_dot(half, half);
	node->sin_cone = gi_sine(node->cos_cone);
}

static void join(gi_light_node *out, const gi_light_node *a, const gi_light_node *b)
{
	for (int i = 0; i < 3; i++) {
		out->low[i] = fminf(a->low[i], b->low[i]);
		out->high[i] = fmaxf(a->high[i], b->high[i]);
	}
	for (int i = 0; i < 3; i++)
		out->sum[i] = a->sum[i] + b->sum[i];
	out->power = a->power + b->power;
	out->lamps = a->lamps + b->lamps;
	out->cos_beam = fminf(a->cos_beam, b->cos_beam);
	join_cones(out, a, b);
	finish(out);
}

static float middle(const gi_light_node *node, int axis)
{
	return 0.5f * (node->low[axis] + node->high[axis]);
}

/* The axis along which the centres of the lights spread most, and the middle of that range. */
static int widest_axis(const gi_light_node *leaves, uint32_t count, float *halfway)
{
	float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
	for (uint32_t i = 0; i < count; i++)
		for (int axis = 0; axis < 3; axis++) {
			low[axis] = fminf(low[axis], middle(&leaves[i], axis));
			high[axis] = fmaxf(high[axis], middle(&leaves[i], axis));
		}
	int widest = 0;
	for (int axis = 1; axis < 3; axis++)
		if (high[axis] - low[axis] > high[widest] - low[widest])
			widest = axis;
	*halfway = 0.5f * (low[widest] + high[widest]);
	return widest;
}

/* Reorders the leaves into two groups, for the two children of a node; returns how many are in the first. */
static uint32_t part(gi_light_node *leaves, uint32_t count, uint32_t level)
{
	float halfway;
	int axis = widest_axis(leaves, count, &halfway);
	uint32_t first = 0;
	for (uint32_t i = 0; i < count && level < MIDDLES_UNTIL; i++)
		if (middle(&leaves[i], axis) < halfway) {
			gi_light_node swapped = leaves[i];
			leaves[i] = leaves[first];
			leaves[first++] = swapped;
		}
	return first == 0 || first == count ? count / 2 : first;
}

/* A run of leaves that one child will hold. */
typedef struct leaf_run {
	gi_light_node *leaves;
	uint32_t count, level;
} leaf_run;

/* Cuts the run of the most leaves in two, until there are as many runs as a node has children, or nothing to cut. */
static uint32_t cut(leaf_run *runs)
{
	uint32_t count = 1;
	for (; count < GI_LIGHT_CHILDREN; count++) {
		leaf_run *most = runs;
		for (uint32_t i = 1; i < count; i++)
			if (runs[i].count > most->count)
				most = &runs[i];
		if (most->count == 1)
			break;
		uint32_t first = part(most->leaves, most->count, most->level++);
		runs[count] = (leaf_run){most->leaves + first, most->count - first, most->level};
		most->count = first;
	}
	return count;
}

/* Builds the subtree at nodes[at] from leaves; *used is the first free node. */
static void build(gi_light_node *nodes, uint32_t at, leaf_run from, uint32_t *used)
{
	STILB_ASSERT(from.count >= 1);
	uint32_t parent = nodes[at].parent;
	if (from.count == 1) {
		nodes[at] = from.leaves[0];
		nodes[at].parent = parent;
		nodes[at].child = GI_LIGHT_LEAF;
		nodes[at].child_count = 0;
		for (int i = 0; i < 3; i++)
			nodes[at].sum[i] = nodes[at].axis[i] * (nodes[at].power - nodes[at].lamps);
		finish(&nodes[at]);
		return;
	}
	leaf_run runs[GI_LIGHT_CHILDREN] = {from};
	uint32_t child = *used, count = cut(runs);
	*used += count;
	for (uint32_t i = 0; i < count; i++) {
		nodes[child + i].parent = at;
		build(nodes, child + i, runs[i], used);
	}
	gi_light_node all = nodes[child];
	for (uint32_t i = 1; i < count; i++) {
		gi_light_node before = all;
		join(&all, &before, &nodes[child + i]);
	}
	all.parent = parent;
	all.child = child;
	all.child_count = count;
	nodes[at] = all;
}

/* Children know their parent and lie in its box. For STILB_CHECK. */
static bool tree_is_sound(const gi_light_node *nodes, uint32_t count)
{
	for (uint32_t i = 0; i < count; i++) {
		const gi_light_node *parent = &nodes[nodes[i].parent];
		if (nodes[i].parent >= count || (i > 0 && i - parent->child >= parent->child_count))
			return false;
		for (int axis = 0; axis < 3; axis++)
			if (nodes[i].low[axis] < parent->low[axis] || nodes[i].high[axis] > parent->high[axis])
				return false;
	}
	return true;
}

/* Copies what importance reads of a node to a lane. */
static void pack(const gi_light_node *node, gi_light_eight *eights, uint32_t lane)
{
	for (int i = 0; i < 3; i++) {
		eights->center[i][lane] = node->center[i];
		eights->axis[i][lane] = node->axis[i];
		eights->sum[i][lane] = node->sum[i];
	}
	eights->radius2[lane] = node->radius2;
	eights->cos_cone[lane] = node->cos_cone;
	eights->sin_cone[lane] = node->sin_cone;
	eights->cos_beam[lane] = node->cos_beam;
	eights->power[lane] = node->power;
	eights->spread[lane] = node->spread;
}

static gi_light_weigh *weigh_by(void)
{
#if defined(__x86_64__)
	stilb_isa isa;
	if (stilb_cpu_isa(&isa) == STILB_OK && isa >= STILB_ISA_AVX2)
		return gi_light_weigh_avx2;
#endif
	return gi_light_weigh_scalar; /* the same bits */
}

bool gi_light_tree_build(gi_light_node *leaves, uint32_t leaf_count, gi_light_tree *tree)
{
	STILB_ASSERT(leaf_count >= 1);
	uint32_t used = 1, eights = 0;
	*tree = (gi_light_tree){.nodes = stilb_memory_alloc(2 * (size_t)leaf_count - 1, sizeof *tree->nodes),
	                        .weigh = weigh_by()};
	if (!tree->nodes)
		return false;
	tree->nodes[0] = (gi_light_node){.parent = 0};
	build(tree->nodes, 0, (leaf_run){leaves, leaf_count, 0}, &used);
	STILB_ASSERT(used <= 2 * leaf_count - 1);
	STILB_CHECK(tree_is_sound(tree->nodes, used));
	tree->node_count = used;
	for (uint32_t i = 0; i < used; i++) {
		tree->nodes[i].eight = eights;
		eights += (tree->nodes[i].child_count + 7) / 8;
	}
	tree->eights = stilb_memory_alloc(eights, sizeof *tree->eights);
	if (!tree->eights) {
		gi_light_tree_finish(tree);
		return false;
	}
	memset(tree->eights, 0, eights * sizeof *tree->eights);
	for (uint32_t i = 0; i < used; i++)
		for (uint32_t c = 0; c < tree->nodes[i].child_count; c++)
			pack(&tree->nodes[tree->nodes[i].child + c], &tree->eights[tree->nodes[i].eight + c / 8], c % 8);
	return true;
}

void gi_light_tree_finish(gi_light_tree *tree)
{
	free(tree->nodes);
	free(tree->eights);
	*tree = (gi_light_tree){0};
}

/* ---- choosing ---------------------------------------------------------------------------------------------------- */

/* Fills in the importance of each of a node's children; returns their sum. */
static float weigh(const gi_light_tree *tree, const gi_light_node *node, stilb_vec3 position, stilb_vec3 normal,
                   gi_light_weights *weights)
{
	uint32_t count = (node->child_count + 7) / 8;
	tree->weigh(&tree->eights[node->eight], count, position, normal, weights);
	float sum = weights->eights[0];
	for (uint32_t i = 1; i < count; i++)
		sum += weights->eights[i];
	return sum;
}

/* The first of the weights with which their sum is above *rest; by rounding there may be none: then the last above 0.
 * *rest becomes the part of it that is beyond the weights before. Without branches, which nobody could foretell. */
static uint32_t pick(const float *weights, uint32_t count, float *rest)
{
	uint32_t at = 0;
	float sum = 0.0f, before = 0.0f;
	for (uint32_t i = 0; i < count; i++) {
		sum += weights[i];
		at += *rest >= sum;
		before = *rest >= sum ? sum : before;
	}
	if (at == count) {
		do
			at--;
		while (!(weights[at] > 0.0f));
		before = sum - weights[at];
	}
	*rest -= before;
	return at;
}

uint32_t gi_light_tree_choose(const gi_light_tree *tree, stilb_vec3 position, stilb_vec3 normal, float u,
                              float *probability)
{
	STILB_ASSERT(u >= 0.0f && u < 1.0f);
	uint32_t at = 0;
	float chance = 1.0f;
	while (tree->nodes[at].child != GI_LIGHT_LEAF) {
		const gi_light_node *node = &tree->nodes[at];
		gi_light_weights weights;
		float sum = weigh(tree, node, position, normal, &weights), rest = u * sum;
		if (!(sum > 0.0f))
			return GI_LIGHT_LEAF;
		uint32_t child = node->child_count > 8 ? 8 * pick(weights.eights, (node->child_count + 7) / 8, &rest) : 0;
		uint32_t left = node->child_count - child;
		child += pick(&weights.each[child], left < 8 ? left : 8, &rest);
		chance *= weights.each[child] / sum;
		u = rest / weights.each[child]; /* may be 1 or more, by rounding */
		u = u < BELOW_ONE ? u : BELOW_ONE;
		at = node->child + child;
	}
	*probability = chance;
	return at;
}

float gi_light_tree_probability(const gi_light_tree *tree, stilb_vec3 position, stilb_vec3 normal, uint32_t leaf)
{
	STILB_ASSERT(tree->nodes[leaf].child == GI_LIGHT_LEAF);
	float chance = 1.0f;
	for (uint32_t at = leaf; at != 0; at = tree->nodes[at].parent) {
		const gi_light_node *parent = &tree->nodes[tree->nodes[at].parent];
		gi_light_weights weights;
		float sum = weigh(tree, parent, position, normal, &weights);
		if (!(sum > 0.0f))
			return 0.0f;
		chance *= weights.each[at - parent->child] / sum;
	}
	return chance;
}
