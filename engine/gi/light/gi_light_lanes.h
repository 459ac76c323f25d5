/*
 * gi_light_lanes: importance of the children of a node of the light tree (gi_light_tree.h), several at once. Included
 * once for each instruction set, with the name of its function in WEIGH and the floats of a register in LANES, 4 or 8;
 * all give the same bits. [any-thread]
 */
#ifndef STILB_GI_LIGHT_LANES_H
#define STILB_GI_LIGHT_LANES_H

#include "gi/light/gi_light_tree.h"

#include <math.h>
#include <string.h>

typedef float lanes __attribute__((vector_size(4 * LANES)));
typedef int32_t lanes_mask __attribute__((vector_size(4 * LANES)));

/* Least cosine at the lit surface that importance assumes: the triangle may face the light although a bump-mapped or
 * interpolated normal does not. */
#define FACING_MIN 0.02f
/* Least importance of a node, as a share of the largest that it could be: a mean over its surfaces may be near 0
 * although a single light shines. */
#define MEAN_MIN 0.02f

#define INLINE static inline __attribute__((always_inline))

INLINE lanes select_lanes(lanes_mask where, lanes yes, lanes no)
{
	return (lanes)((where & (lanes_mask)yes) | (~where & (lanes_mask)no));
}

INLINE lanes at_least(lanes x, float least)
{
	return select_lanes(x > least, x, (lanes){0} + least);
}

INLINE lanes root(lanes x)
{
	lanes roots;
	for (int i = 0; i < LANES; i++)
		roots[i] = sqrtf(x[i]);
	return roots;
}

INLINE lanes load(const float from[LANES])
{
	lanes x;
	memcpy(&x, from, sizeof x);
	return x;
}

/* The sine of an angle in [0, pi] from its cosine. */
INLINE lanes sine(lanes cosine)
{
	return root(at_least(1.0f - cosine * cosine, 0.0f));
}

INLINE lanes dot(const lanes a[3], const lanes b[3])
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Cosine of max(a - b, 0) for angles in [0, pi]. */
INLINE lanes cosine_less(lanes cos_a, lanes sin_a, lanes cos_b, lanes sin_b)
{
	return select_lanes(cos_a > cos_b, (lanes){0} + 1.0f, cos_a * cos_b + sin_a * sin_b);
}

/* Estimates of the irradiance that the lights of nodes, from lane `first` on, send to a surface. */
INLINE lanes importance(const gi_light_eight *nodes, uint32_t first, stilb_vec3 position, stilb_vec3 normal)
{
	lanes axis[3], sum[3], to[3], facing = {0};
	for (int i = 0; i < 3; i++) {
		axis[i] = load(&nodes->axis[i][first]);
		sum[i] = load(&nodes->sum[i][first]);
		to[i] = load(&nodes->center[i][first]) - position[i];
		facing += normal[i] * to[i];
	}
	lanes radius2 = load(&nodes->radius2[first]), power = load(&nodes->power[first]);
	lanes cos_cone = load(&nodes->cos_cone[first]), sin_cone = load(&nodes->sin_cone[first]);
	/* The mean of the squared distance to points anywhere in the box: its diagonal is 2 radii. */
	lanes distance2 = dot(to, to), mean2 = at_least(distance2 + radius2 * (1.0f / 3.0f), 1e-30f);
	lanes_mask outside = distance2 > radius2; /* else light may come from any side: no cosine is known */
	lanes inverse = 1.0f / select_lanes(outside, distance2, at_least(radius2, 1e-30f)), scale = root(inverse);
	lanes sin2_box = radius2 * inverse, cos_box = root(at_least(1.0f - sin2_box, 0.0f)), sin_box = root(sin2_box);
	lanes from_axis = -scale * dot(axis, to), sin_axis = sine(from_axis);
	lanes beyond_cone = cosine_less(from_axis, sin_axis, cos_cone, sin_cone);
	lanes sin_beyond = select_lanes(from_axis > cos_cone, (lanes){0}, sin_axis * cos_cone - from_axis * sin_cone);
	lanes emitted = cosine_less(beyond_cone, sin_beyond, cos_box, sin_box);
	lanes from_normal = scale * facing;
	facing = at_least(cosine_less(from_normal, sine(from_normal), cos_box, sin_box), FACING_MIN);
	lanes most = power * at_least(emitted, FACING_MIN);
	lanes mean = at_least(-scale * dot(sum, to), 0.0f) + load(&nodes->spread[first]);
	lanes sent = mean + (most - mean) * sin2_box, least = MEAN_MIN * most;
	sent = select_lanes(sent > least, sent, least) * facing;
	sent = select_lanes(emitted > load(&nodes->cos_beam[first]), sent, (lanes){0});
	return select_lanes(outside, sent, power) / mean2;
}

void WEIGH(const gi_light_eight *children, uint32_t count, stilb_vec3 position, stilb_vec3 normal,
           gi_light_weights *weights)
{
	for (uint32_t i = 0; i < count; i++) {
		float *each = &weights->each[(size_t)8 * i];
		for (uint32_t first = 0; first < 8; first += LANES) {
			lanes some = importance(&children[i], first, position, normal);
			memcpy(&each[first], &some, sizeof some);
		}
		weights->eights[i] = ((each[0] + each[1]) + (each[2] + each[3])) + ((each[4] + each[5]) + (each[6] + each[7]));
	}
}

#endif
