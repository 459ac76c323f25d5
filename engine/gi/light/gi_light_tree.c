#include "gi/light/gi_light_tree.h"

#include "gi/gi_vector.h"

#include <math.h>
#include <string.h>

/* Least cosine at the lit surface that importance assumes: the triangle may face the light although a bump-mapped or
 * interpolated normal does not. */
#define FACING_MIN 0.02f
/* Least importance of a node, as a share of the largest that it could be: a mean over its surfaces may be near 0
 * although a single light shines. */
#define MEAN_MIN 0.02f
/* So many upper levels of the tree are split in the middle of the range of the lights' centres; those below, where that
 * has not separated them, into halves of equal number. */
#define MIDDLES_UNTIL 48u
#define BELOW_ONE 0.99999994f /* the largest float below 1 */

/* ---- importance -------------------------------------------------------------------------------------------------- */

static float at_least(float x, float least)
{
	return x > least ? x : least;
}

/* Cosine of max(a - b, 0) for angles in [0, pi]. */
static float cosine_less(float cos_a, float sin_a, float cos_b, float sin_b)
{
	return cos_a > cos_b ? 1.0f : cos_a * cos_b + sin_a * sin_b;
}

/* Sine of max(a - b, 0). */
static float sine_less(float cos_a, float sin_a, float cos_b, float sin_b)
{
	return cos_a > cos_b ? 0.0f : sin_a * cos_b - cos_a * sin_b;
}

float gi_light_node_importance(const gi_light_node *node, stilb_vec3 position, stilb_vec3 normal)
{
	stilb_vec3 to_node = gi_vector(node->center) - position;
	float distance2 = stilb_vec3_dot(to_node, to_node);
	if (!(distance2 > node->radius2)) /* inside the sphere light may come from any side: no cosine is known */
		return node->power / at_least(node->radius2, 1e-30f);
	float inverse = 1.0f / distance2, scale = sqrtf(inverse);
	float sin2_box = node->radius2 * inverse, cos_box = sqrtf(1.0f - sin2_box), sin_box = sqrtf(sin2_box);
	float from_axis = -scale * stilb_vec3_dot(gi_vector(node->axis), to_node), sin_axis = gi_sine(from_axis);
	float beyond_cone = cosine_less(from_axis, sin_axis, node->cos_cone, node->sin_cone);
	float sin_beyond = sine_less(from_axis, sin_axis, node->cos_cone, node->sin_cone);
	float emitted = cosine_less(beyond_cone, sin_beyond, cos_box, sin_box);
	if (!(emitted > node->cos_beam))
		return 0.0f;
	float from_normal = scale * stilb_vec3_dot(normal, to_node);
	float facing = cosine_less(from_normal, gi_sine(from_normal), cos_box, sin_box);
	float most = node->power * at_least(emitted, FACING_MIN);
	float mean = at_least(-scale * stilb_vec3_dot(gi_vector(node->sum), to_node), 0.0f) + node->spread;
	float sent = mean + (most - mean) * sin2_box;
	return at_least(sent, MEAN_MIN * most) * at_least(facing, FACING_MIN) * inverse;
}

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
	node->spread = node->lamps + 0.25f * at_least(rest, 0.0f);
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

uint32_t gi_light_tree_build(gi_light_node *nodes, gi_light_node *leaves, uint32_t leaf_count)
{
	STILB_ASSERT(leaf_count >= 1);
	uint32_t used = 1;
	nodes[0] = (gi_light_node){.parent = 0};
	build(nodes, 0, (leaf_run){leaves, leaf_count, 0}, &used);
	STILB_ASSERT(used <= 2 * leaf_count - 1);
	STILB_CHECK(tree_is_sound(nodes, used));
	return used;
}

/* ---- choosing ---------------------------------------------------------------------------------------------------- */

/* The importance of each child, and their sum. */
static float children_importance(const gi_light_node *nodes, const gi_light_node *node, stilb_vec3 position,
                                 stilb_vec3 normal, float importance[GI_LIGHT_CHILDREN])
{
	float sum = 0.0f;
	for (uint32_t i = 0; i < node->child_count; i++) {
		importance[i] = gi_light_node_importance(&nodes[node->child + i], position, normal);
		sum += importance[i];
	}
	return sum;
}

uint32_t gi_light_tree_choose(const gi_light_node *nodes, stilb_vec3 position, stilb_vec3 normal, float u,
                              float *probability)
{
	STILB_ASSERT(u >= 0.0f && u < 1.0f);
	uint32_t at = 0;
	float chance = 1.0f, importance[GI_LIGHT_CHILDREN];
	while (nodes[at].child != GI_LIGHT_LEAF) {
		float sum = children_importance(nodes, &nodes[at], position, normal, importance), rest = u * sum;
		if (!(sum > 0.0f))
			return GI_LIGHT_LEAF;
		uint32_t chosen = GI_LIGHT_CHILDREN;
		float before = 0.0f; /* of the sum, rest lies beyond it */
		for (uint32_t i = 0; i < nodes[at].child_count && !(chosen < GI_LIGHT_CHILDREN && rest < before); i++) {
			if (!(importance[i] > 0.0f))
				continue;
			if (chosen < GI_LIGHT_CHILDREN)
				rest -= importance[chosen];
			chosen = i;
			before = importance[i];
		}
		chance *= importance[chosen] / sum;
		u = rest / importance[chosen]; /* may be 1 or more, by rounding */
		u = u < BELOW_ONE ? u : BELOW_ONE;
		at = nodes[at].child + chosen;
	}
	*probability = chance;
	return at;
}

float gi_light_tree_probability(const gi_light_node *nodes, stilb_vec3 position, stilb_vec3 normal, uint32_t leaf)
{
	STILB_ASSERT(nodes[leaf].child == GI_LIGHT_LEAF);
	float chance = 1.0f, importance[GI_LIGHT_CHILDREN];
	for (uint32_t at = leaf; at != 0; at = nodes[at].parent) {
		const gi_light_node *parent = &nodes[nodes[at].parent];
		float sum = children_importance(nodes, parent, position, normal, importance);
		if (!(sum > 0.0f))
			return 0.0f;
		chance *= importance[at - parent->child] / sum;
	}
	return chance;
}
