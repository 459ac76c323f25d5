/*
 * shade_light_cone: the cone of directions from which a light can still be seen in a highlight; every light outside of
 * it may be left out. [any-thread]
 *
 * Diffuse light ends with the lamp's reach (shade_light.h). A highlight does not: the smoother the surface, the higher
 * and the narrower it is, so a mirror shows a candle from any distance, but only where the candle's image is. So beside
 * the distance a highlight is culled by its direction: for one point with the normal n, seen from v, the lights whose
 * highlight exceeds a tolerance lie in a cone about the mirrored view r = 2 (n.v) n - v. Cones of several points are
 * joined into one for a whole tile of pixels. A light is left out when its diffuse light and its highlight both stay
 * below the tolerance.
 *
 * Two forms. A tolerance of the reflected radiance for an irradiance of 1 across the beam (BRDF times n.l, sr^-1),
 * which the functions with n and v take; or a share of the lobe's peak, (0, 1), when the peak is part of the lamp's
 * reach already (shade_reach_from_error), which the functions shade_cone_chord_* take.
 *
 * A cone is kept as its chord, the distance between the tips of its axis and of a direction on its rim: 2 sin of half
 * the angle. At 2 it holds every direction, below 0 none. Chords keep their digits where the cosine, 1 - 1e-7 in the
 * highlight of a smooth surface, has lost them. Each cone is a little larger than its formula says, since unit vectors,
 * tolerances and peaks are rounded: by SHADE_CONE_EPSILON, and as if for a tolerance SHADE_CONE_SHARE_EPSILON smaller.
 *
 * Sources: Karis, "Tiled Light Culling" (2012), axis and angle for Phong; its sequel "Sparse shadows through tracing"
 * asks how to do the same for Blinn: the answer below and the form for GGX are derived here.
 */
#ifndef SHADE_LIGHT_CONE_H
#define SHADE_LIGHT_CONE_H

#include "shade_constants.h"
#include "shade_frame.h"
#include "shade_phong.h"
#include "shade_specular.h"

#include "glsl_begin.h"

/* EPSILON and SHARE_EPSILON: see above. COSINE_EPSILON: the error that a float n.v may have. SHARE_MIN: below this
 * share of the peak a cone of Phong or Blinn-Phong holds the whole lobe, and GGX counts the share as this. APART_MIN:
 * two axes less apart than this give no direction from one to the other. */
#define SHADE_CONE_EPSILON 2e-6f
#define SHADE_CONE_SHARE_EPSILON 2e-6f
#define SHADE_CONE_COSINE_EPSILON 3e-7f
#define SHADE_CONE_SHARE_MIN 1e-30f
#define SHADE_CONE_APART_MIN 1e-6f

/* axis: unit. chord: 2 sin(half angle / 2). */
SHADE_STRUCT(shade_cone)
{
	vec3 axis;
	float chord;
};

/* ---- the width of a lobe ----------------------------------------------------------------------------------------- */

/* -log(share), which keeps its digits for shares near 0 and near 1. share: a fraction of a lobe's peak, [1e-30, 1]. */
SHADE_FN float shade_cone_depth(float share)
{
	return select(share > SHADE_SERIES_LIMIT, -shade_log1p(share - 1.0f), -log(share));
}

/* Phong with the exponent n > 0: (r.l)^n > share, so r.l > share^(1 / n); chord^2 = 2 (1 - share^(1 / n)). A share of 1
 * and above leaves no direction; one below 1e-30 the hemisphere about r. Source: Karis, "Cone angle". */
SHADE_FN float shade_cone_chord_phong(float share, float n)
{
	if (share >= 1.0f)
		return -1.0f;
	if (share < SHADE_CONE_SHARE_MIN)
		return sqrt(2.0f);
	return sqrt(2.0f * shade_one_minus_exp(shade_cone_depth(share) / n));
}

/* Lobes that depend on the half vector h of l and v: the chord of the cone of lights l for which the angle between n
 * and h is below b, sin2 = sin(b)^2. Such a light is the view mirrored by a facet whose normal is h. A facet that turns
 * by b turns its mirror image by 2 b at most (two mirrorings make a rotation by twice the angle between the mirrors),
 * and by just 2 b in the plane of n and v, to both sides. So the smallest cone that holds them all has Phong's axis r
 * and the half angle 2 b; its chord is 2 sin(b). It holds lights below the horizon too. */
SHADE_FN float shade_cone_chord_of_facets(float sin2)
{
	return 2.0f * sqrt(clamp(sin2, 0.0f, 1.0f));
}

/* Blinn-Phong with the exponent n > 0: cos(b)^n > share, where b is the angle between the normal and h, so
 * sin(b)^2 < 1 - share^(2 / n). A share of 1 and above leaves no direction; one below 1e-30 leaves every direction. */
SHADE_FN float shade_cone_chord_blinn_phong(float share, float n)
{
	if (share >= 1.0f)
		return -1.0f;
	if (share < SHADE_CONE_SHARE_MIN)
		return 2.0f;
	return shade_cone_chord_of_facets(shade_one_minus_exp(2.0f * shade_cone_depth(share) / n));
}

/* GGX: (alpha^2 / (alpha^2 + sin^2 (1 - alpha^2)))^2 > share: with s = sqrt(share),
 *   sin(b)^2 = alpha^2 (1 - s) / (s (1 - alpha^2)),   1 - s = (1 - share) / (1 + s).
 * Its tail is long: where Blinn-Phong's cone is narrow, GGX's may hold every direction. alpha in
 * [SHADE_ALPHA_MIN, 1]. */
SHADE_FN float shade_cone_chord_ggx(float share, float alpha)
{
	if (share >= 1.0f)
		return -1.0f;
	float s = sqrt(max(share, SHADE_CONE_SHARE_MIN));
	float alpha2 = alpha * alpha;
	return shade_cone_chord_of_facets(alpha2 * (1.0f - share) /
	                                  (s * (1.0f + s) * max(1.0f - alpha2, SHADE_CONE_EPSILON)));
}

/* ---- cones of one point ------------------------------------------------------------------------------------------ */

/* The cone about v mirrored by n. */
SHADE_FN shade_cone shade_cone_mirrored(vec3 n, vec3 v, float chord)
{
	vec3 r = n * (2.0f * dot(n, v)) - v;
	shade_cone cone = {r, select(chord < 0.0f, -1.0f, min(chord, 2.0f) + SHADE_CONE_EPSILON)};
	return cone;
}

/* Which share of the highlight's peak the tolerance is; a little less, for rounding. Both in sr^-1. */
SHADE_FN float shade_cone_share(float tolerance, float peak)
{
	return tolerance / peak * (1.0f - SHADE_CONE_SHARE_EPSILON);
}

/* Phong, modified or not, of exponent n > 0: beyond, shade_phong_modified and shade_phong are at most the tolerance,
 * sr^-1. Karis's tolerance, of a pi-folded light, is pi times this one. */
SHADE_FN shade_cone shade_cone_phong(vec3 n, vec3 v, float exponent, float tolerance)
{
	float share = shade_cone_share(tolerance, shade_phong_modified_factor(exponent));
	return shade_cone_mirrored(n, v, shade_cone_chord_phong(share, exponent));
}

/* Blinn-Phong, modified or not: beyond, shade_blinn_phong_modified and shade_blinn_phong are at most the tolerance. */
SHADE_FN shade_cone shade_cone_blinn_phong(vec3 n, vec3 v, float exponent, float tolerance)
{
	float share = shade_cone_share(tolerance, shade_blinn_phong_modified_factor(exponent));
	return shade_cone_mirrored(n, v, shade_cone_chord_blinn_phong(share, exponent));
}

/* The GGX distribution with its Smith term (or with the implicit or Neumann's G) and F <= 1: f (n.l) = D V F (n.l) is
 * at most D G1(v) / (4 (n.v)), since G1(l) <= 1; so the peak is D(0) G1(v) / (4 (n.v)). */
SHADE_FN shade_cone shade_cone_ggx(vec3 n, vec3 v, float alpha, float tolerance)
{
	// G1(v) / (n.v) of a smooth surface falls steeply from n.v = 0 on, and a float n.v is rounded.
	float n_dot_v = max(dot(n, v) - SHADE_CONE_COSINE_EPSILON, 0.0f);
	float peak = 0.5f * shade_d_ggx(0.0f, alpha) * shade_v1_smith_ggx(n_dot_v, alpha);
	return shade_cone_mirrored(n, v, shade_cone_chord_ggx(shade_cone_share(tolerance, peak), alpha));
}

/* ---- angles ------------------------------------------------------------------------------------------------------ */

/* An angle in [0, 2 pi] as sine and cosine of its half: sums need no arcus then, and small angles keep their digits. */
SHADE_STRUCT(shade_half_angle)
{
	float sine;
	float cosine;
};

SHADE_FN shade_half_angle shade_half_angle_from_chord(float chord)
{
	float sine = 0.5f * chord;
	shade_half_angle half_angle = {sine, sqrt(max(1.0f - sine * sine, 0.0f))};
	return half_angle;
}

SHADE_FN shade_half_angle shade_half_angle_sum(shade_half_angle a, shade_half_angle b)
{
	shade_half_angle sum = {a.sine * b.cosine + a.cosine * b.sine, a.cosine * b.cosine - a.sine * b.sine};
	return sum;
}

SHADE_FN shade_half_angle shade_half_angle_difference(shade_half_angle a, shade_half_angle b)
{
	shade_half_angle difference = {a.sine * b.cosine - a.cosine * b.sine, a.cosine * b.cosine + a.sine * b.sine};
	return difference;
}

/* ---- what cones are asked ---------------------------------------------------------------------------------------- */

/* Is the direction, unit, inside? */
SHADE_FN bool shade_cone_holds(shade_cone cone, vec3 direction)
{
	return distance(direction, cone.axis) <= cone.chord;
}

/* The half angle in [0, pi]; 0 for a cone without directions. */
SHADE_FN float shade_cone_half_angle(shade_cone cone)
{
	shade_half_angle half_angle = shade_half_angle_from_chord(max(cone.chord, 0.0f));
	return 2.0f * atan(half_angle.sine, half_angle.cosine);
}

/* ---- the union --------------------------------------------------------------------------------------------------- */

/* A unit vector across the unit vector a, on b's side of it; any one across where b is a or -a. Taken from the shorter
 * of b - a and b + a, which have the same part across. */
SHADE_FN vec3 shade_cone_across(vec3 a, vec3 b)
{
	vec3 apart = select(dot(a, b) > 0.0f, b - a, b + a);
	return shade_frame_from_tangent(a, select(length(apart) > SHADE_CONE_APART_MIN, apart, vec3(0.0f))).t;
}

/* The union of two cones where the first is not the smaller one. */
SHADE_FN shade_cone shade_cone_union_ordered(shade_cone a, shade_cone b)
{
	shade_half_angle of_a = shade_half_angle_from_chord(a.chord);
	shade_half_angle of_b = shade_half_angle_from_chord(b.chord);
	shade_half_angle between = {0.5f * distance(a.axis, b.axis), 0.5f * length(a.axis + b.axis)};
	shade_half_angle reach = shade_half_angle_sum(between, of_b);
	shade_half_angle turn = shade_half_angle_difference(reach, of_a); // sine and cosine of (B + D - A) / 2, see below
	if (b.chord < 0.0f || turn.sine <= 0.0f)
		return a;
	shade_half_angle width = shade_half_angle_sum(reach, of_a); // of (A + B + D) / 2, the new half angle
	float sine = select(width.cosine > 0.0f, width.sine / sqrt(2.0f + 2.0f * width.cosine),
	                    sqrt(max(0.5f - 0.5f * width.cosine, 0.0f)));
	float chord = 2.0f * select(width.sine < 0.0f, 1.0f, sine) + SHADE_CONE_EPSILON;
	shade_cone both = {normalize(a.axis * turn.cosine + shade_cone_across(a.axis, b.axis) * turn.sine), chord};
	return both;
}

/* The smallest cone that holds both. With half angles A >= B and the angle D between the axes: a where D + B <= A,
 * otherwise the half angle (A + B + D) / 2 about the axis that is (B + D - A) / 2 from a towards b; every direction
 * where that reaches pi. Cones joined one after the other hold all, in any order, but are not the smallest for three
 * and more: Barequet and Elber, "Optimal bounding cones of vectors in three dimensions" (2005). */
SHADE_FN shade_cone shade_cone_union(shade_cone a, shade_cone b)
{
	if (a.chord < b.chord)
		return shade_cone_union_ordered(b, a);
	return shade_cone_union_ordered(a, b);
}

#include "glsl_end.h"
#endif
