/* shade_light_cone.h: the cone of light directions about the mirrored view in which a light's highlight can be seen.
 * Outside of it no light makes a highlight (reflected radiance for an irradiance of 1, sr^-1) above the tolerance that
 * the cone was made for, and a narrower cone would miss some that do. */
#include "shading/shade_light_cone.h"
#include "support/shade_proof.h"

/* ---- vectors in double ------------------------------------------------------------------------------------------- */

typedef struct vector {
	double x, y, z;
} vector;

static double dot(vector a, vector b)
{
	return a.x * b.x + a.y * b.y + a.z * b.z;
}

static vector blend(double s, vector a, double t, vector b)
{
	return (vector){s * a.x + t * b.x, s * a.y + t * b.y, s * a.z + t * b.z};
}

static vector unit(vector a)
{
	return blend(1.0 / sqrt(dot(a, a)), a, 0.0, a);
}

static vector widened(stilb_vec3 v)
{
	return unit((vector){(double)v[0], (double)v[1], (double)v[2]});
}

static stilb_vec3 narrowed(vector v)
{
	return stilb_vec3_make((float)v.x, (float)v.y, (float)v.z);
}

static double sine_squared(vector a, vector b)
{
	vector c = {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
	return dot(c, c);
}

static double angle_between(vector a, vector b)
{
	return atan2(sqrt(sine_squared(a, b)), dot(a, b));
}

/* The unit vector a turned by an angle (radians) towards the unit vector b, which is at right angles to it. */
static vector turned(vector a, vector b, double angle)
{
	vector across = unit(blend(1.0, b, -dot(a, b), a));
	return blend(cos(angle), a, sin(angle), across);
}

/* ---- lobes in double, each with its own formula ------------------------------------------------------------------ */

enum { PHONG, BLINN_PHONG, GGX, LOBE_COUNT };

/* What a cone is made from: the surface's normal, the direction to the viewer, the lobe's exponent (Phong, Blinn-Phong)
 * or alpha (GGX), and the tolerance, sr^-1. */
typedef struct surface {
	stilb_vec3 n, v;
	float exponent, alpha, tolerance;
} surface;

static shade_cone cone_of(int lobe, const surface *s)
{
	if (lobe == PHONG)
		return shade_cone_phong(s->n, s->v, s->exponent, s->tolerance);
	if (lobe == BLINN_PHONG)
		return shade_cone_blinn_phong(s->n, s->v, s->exponent, s->tolerance);
	return shade_cone_ggx(s->n, s->v, s->alpha, s->tolerance);
}

static double cosine_power(double sine2, double n)
{
	return sine2 < 1.0 ? exp(0.5 * n * log1p(-sine2)) : 0.0;
}

/* An upper bound of the radiance, sr^-1, that the surface reflects of a light of irradiance 1 from l: the function from
 * which the cone's formula follows. */
static double highlight(int lobe, const surface *s, vector l)
{
	vector n = widened(s->n), v = widened(s->v), sum = blend(1.0, l, 1.0, v);
	double exponent = (double)s->exponent, alpha2 = (double)s->alpha * (double)s->alpha;
	if (lobe == PHONG) {
		vector r = blend(2.0 * dot(n, v), n, -1.0, v);
		double shape = dot(r, l) > 0.0 ? cosine_power(sine_squared(r, l), exponent) : 0.0;
		return (exponent + 2.0) / (2.0 * M_PI) * shape;
	}
	double sine2 = sine_squared(n, sum) / dot(sum, sum);
	if (lobe == BLINN_PHONG)
		return (exponent + 2.0) * (exponent + 4.0) / (8.0 * M_PI * (exp2(-0.5 * exponent) + exponent)) *
		       cosine_power(sine2, exponent);
	double bracket = alpha2 + sine2 * (1.0 - alpha2), n_dot_v = fmax(dot(n, v), 0.0);
	double g1_by_n_dot_v = 2.0 / (n_dot_v + sqrt(alpha2 + (1.0 - alpha2) * n_dot_v * n_dot_v));
	return alpha2 / (M_PI * bracket * bracket) * g1_by_n_dot_v / 4.0;
}

/* ---- exactness --------------------------------------------------------------------------------------------------- */

#define WITHIN 6e-6 /* how much larger a cone may be: SHADE_CONE_EPSILON, SHADE_CONE_SHARE_EPSILON, and rounding */

/* Karis's two forms, angle = acos((2 t / (n + 2))^(1 / n)) with t of a pi-folded light, and acos(share^(1 / n)). */
static void phong_has_both_of_karis_forms(void **state)
{
	(void)state;
	stilb_vec3 n = {0.0f, 0.0f, 1.0f}, v = {0.6f, 0.0f, 0.8f};
	static const float exponents[] = {0.5f, 1.0f, 10.0f, 300.0f, 2e6f};
	for (size_t i = 0; i < sizeof exponents / sizeof exponents[0]; i++) {
		double exponent = (double)exponents[i], folded = 0.2 * (exponent + 2.0) / 2.0;
		double angle = acos(pow(2.0 * folded / (exponent + 2.0), 1.0 / exponent));
		shade_cone cone = shade_cone_phong(n, v, exponents[i], (float)(folded / M_PI));
		SHADE_PROOF_NEAR(shade_cone_half_angle(cone), angle, 2e-6, WITHIN);
		SHADE_PROOF_NEAR3(cone.axis, -0.6, 0.0, 0.8, 0.0, 1e-6);
		for (double share = 0.001; share < 1.0; share += 0.111)
			SHADE_PROOF_NEAR(shade_cone_chord_phong((float)share, exponents[i]),
			                 sqrt(-2.0 * expm1(log((double)(float)share) / exponent)), 1e-6, 0.0);
	}
	assert_true(shade_cone_chord_phong(1.0005f, 10.0f) == -1.0f && shade_cone_chord_phong(1.0f, 10.0f) == -1.0f);
	assert_true(shade_cone_chord_phong(0.9995f, 10.0f) > 0.0f);
	SHADE_PROOF_NEAR(shade_cone_chord_phong(0.0f, 10.0f), sqrt(2.0), 1e-7, 0.0);
}

static void facets_turn_the_light_twice_as_far(void **state)
{
	(void)state;
	static const float exponents[] = {0.5f, 1.0f, 10.0f, 300.0f, 2e6f};
	for (size_t i = 0; i < sizeof exponents / sizeof exponents[0]; i++)
		for (double share = 0.001; share < 1.0; share += 0.111) {
			double sine2 = -expm1(2.0 * log((double)(float)share) / (double)exponents[i]);
			SHADE_PROOF_NEAR(shade_cone_chord_blinn_phong((float)share, exponents[i]), 2.0 * sqrt(sine2), 1e-6, 0.0);
		}
	assert_true(shade_cone_chord_blinn_phong(1.0005f, 10.0f) == -1.0f);
	assert_true(shade_cone_chord_blinn_phong(0.9995f, 10.0f) > 0.0f);
	assert_true(shade_cone_chord_blinn_phong(0.0f, 10.0f) == 2.0f);
	for (double alpha = 1e-3; alpha < 1.0; alpha *= 1.7)
		for (double share = 0.001; share < 1.0; share += 0.111) {
			double a2 = (double)(float)alpha * (double)(float)alpha, s = sqrt((double)(float)share);
			double sine2 = fmin(a2 * (1.0 - s) / (s * (1.0 - a2)), 1.0);
			SHADE_PROOF_NEAR(shade_cone_chord_ggx((float)share, (float)alpha), 2.0 * sqrt(sine2), 1e-6, 0.0);
		}
	assert_true(shade_cone_chord_ggx(1.0005f, 0.3f) == -1.0f && shade_cone_chord_ggx(0.9995f, 0.3f) > 0.0f);
	assert_true(shade_cone_chord_ggx(0.0f, 0.3f) == 2.0f && shade_cone_chord_ggx(0.9f, 1.0f) == 2.0f);
	SHADE_PROOF_NEAR(shade_cone_chord_of_facets(0.25f), 1.0, 1e-7, 0.0);
	SHADE_PROOF_NEAR(shade_cone_depth(0.75f), -log(0.75), 2e-7, 0.0);
	SHADE_PROOF_NEAR(shade_cone_depth(1e-30f), 30.0 * log(10.0), 2e-7, 0.0);
}

/* On the rim of the cone, in the plane of n and v, each highlight equals the tolerance; the margin SHADE_CONE_EPSILON
 * is taken off first. */
static void rims_are_at_the_tolerance(void **state)
{
	(void)state;
	const surface surfaces[] = {
		{{0.0f, 0.0f, 1.0f}, {0.6f, 0.0f, 0.8f}, 2.0f, 0.9f, 0.1f},
		{{0.0f, 1.0f, 0.0f}, {0.28f, 0.96f, 0.0f}, 30.0f, 0.4f, 0.05f},
		{{0.0f, 0.6f, 0.8f}, {0.0f, 0.0f, 1.0f}, 500.0f, 0.1f, 7.0f},
	};
	for (size_t i = 0; i < sizeof surfaces / sizeof surfaces[0]; i++)
		for (int lobe = 0; lobe < LOBE_COUNT; lobe++) {
			shade_cone cone = cone_of(lobe, &surfaces[i]);
			vector axis = widened(cone.axis), n = widened(surfaces[i].n);
			double half_angle = 2.0 * asin(0.5 * (double)(cone.chord - SHADE_CONE_EPSILON));
			SHADE_PROOF_NEAR(shade_cone_half_angle(cone), half_angle, 0.0, 5e-6);
			SHADE_PROOF_NEAR(highlight(lobe, &surfaces[i], turned(axis, n, half_angle)), surfaces[i].tolerance, 3e-4,
			                 0.0);
			assert_true(shade_cone_holds(cone, narrowed(turned(axis, n, 0.999 * half_angle))));
			assert_false(shade_cone_holds(cone, narrowed(turned(axis, n, 1.001 * half_angle))));
		}
}

static void cones_keep_to_their_range(void **state)
{
	(void)state;
	stilb_vec3 n = {0.0f, 0.0f, 1.0f};
	assert_true(shade_cone_mirrored(n, n, -0.5f).chord == -1.0f);
	SHADE_PROOF_NEAR(shade_cone_mirrored(n, n, 3.0f).chord, 2.0, 0.0, WITHIN);
	SHADE_PROOF_NEAR(shade_cone_mirrored(n, n, 1.0f).chord, 1.0, 0.0, WITHIN);
	SHADE_PROOF_NEAR(shade_cone_half_angle(shade_cone_mirrored(n, n, 2.0f)), M_PI, 1e-7, 0.0);
	assert_true(shade_cone_half_angle(shade_cone_mirrored(n, n, -1.0f)) == 0.0f);
}

/* ---- the union --------------------------------------------------------------------------------------------------- */

static double half_angle_of(shade_cone cone)
{
	return 2.0 * asin(fmin(0.5 * (double)cone.chord, 1.0));
}

/* The half angle of the smallest cone that holds both. */
static double half_angle_of_union(shade_cone a, shade_cone b)
{
	double of_a = half_angle_of(a), of_b = half_angle_of(b);
	double apart = angle_between(widened(a.axis), widened(b.axis));
	if (a.chord < 0.0f || b.chord < 0.0f)
		return a.chord < 0.0f ? fmax(of_b, 0.0) : of_a;
	return fmin(fmax(fmax(of_a, of_b), 0.5 * (of_a + of_b + apart)), M_PI);
}

static shade_cone cone_at(double angle, double half_angle)
{
	return (shade_cone){stilb_vec3_make((float)sin(angle), 0.0f, (float)cos(angle)),
	                    (float)(2.0 * sin(0.5 * half_angle))};
}

static void unions_are_the_smallest(void **state)
{
	(void)state;
	for (double apart = 0.0; apart <= M_PI; apart += 0.15)
		for (double of_a = 0.0; of_a <= M_PI; of_a += 0.19)
			for (double of_b = 0.0; of_b <= M_PI; of_b += 0.19) {
				shade_cone a = cone_at(0.0, of_a), b = cone_at(apart, of_b), both = shade_cone_union(a, b);
				SHADE_PROOF_NEAR(2.0 * sin(0.5 * half_angle_of(both)), 2.0 * sin(0.5 * half_angle_of_union(a, b)), 0.0,
				                 WITHIN);
				if (of_a + apart + of_b >= 2.0 * M_PI - 1e-5 || fabs(of_a - of_b) > apart - 1e-3)
					continue; /* the union is every direction, or one of the two cones */
				double turn = 0.5 * (apart + of_b - of_a);
				SHADE_PROOF_NEAR3(both.axis, sin(turn), 0.0, cos(turn), 0.0, 1e-5);
			}
}

static void unions_of_special_cones(void **state)
{
	(void)state;
	shade_cone up = cone_at(0.0, 0.5), down = cone_at(M_PI, 0.4);
	shade_cone none = {up.axis, -1.0f}, all = {down.axis, 2.0f}, point = {up.axis, 0.0f};
	assert_true(shade_cone_union(up, none).chord == up.chord && shade_cone_union(none, up).chord == up.chord);
	assert_true(shade_cone_union(none, none).chord < 0.0f);
	assert_true(shade_cone_union(up, all).chord >= 2.0f && shade_cone_union(all, up).chord >= 2.0f);
	assert_true(shade_cone_union(point, all).chord >= 2.0f && shade_cone_union(all, point).chord >= 2.0f);
	SHADE_PROOF_NEAR(shade_cone_union(cone_at(0.0, 2.5), cone_at(2.0, 2.4)).chord, 2.0, 0.0, WITHIN);
	assert_true(shade_cone_union(up, up).chord == up.chord && shade_cone_union(point, up).chord == up.chord);
	/* Opposite axes, half angles 0.5 and 0.4: the union has (pi + 0.5 + 0.4) / 2, about some axis at right angles. */
	shade_cone both = shade_cone_union(up, down);
	SHADE_PROOF_NEAR(half_angle_of(both), 0.5 * (M_PI + 0.5 + 0.4), 0.0, 1e-5);
	SHADE_PROOF_NEAR(angle_between(widened(both.axis), widened(up.axis)), 0.5 * (M_PI + 0.4 - 0.5), 0.0, 1e-5);
	const stilb_vec3 axes[] = {{1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}, {0.0f, 0.0f, 1.0f}, {0.6f, 0.0f, 0.8f}};
	for (size_t i = 0; i < sizeof axes / sizeof axes[0]; i++) {
		vector across = widened(shade_cone_across(axes[i], -axes[i])),
			   same = widened(shade_cone_across(axes[i], axes[i]));
		SHADE_PROOF_NEAR(dot(across, widened(axes[i])), 0.0, 0.0, 1e-7);
		SHADE_PROOF_NEAR(dot(same, widened(axes[i])), 0.0, 0.0, 1e-7);
	}
}

static void half_angles_add(void **state)
{
	(void)state;
	for (double a = 0.0; a < M_PI; a += 0.3)
		for (double b = 0.0; b < M_PI; b += 0.3) {
			shade_half_angle of_a = shade_half_angle_from_chord((float)(2.0 * sin(0.5 * a)));
			shade_half_angle of_b = shade_half_angle_from_chord((float)(2.0 * sin(0.5 * b)));
			shade_half_angle sum = shade_half_angle_sum(of_a, of_b), rest = shade_half_angle_difference(of_a, of_b);
			SHADE_PROOF_NEAR(sum.sine, sin(0.5 * (a + b)), 0.0, 1e-6);
			SHADE_PROOF_NEAR(sum.cosine, cos(0.5 * (a + b)), 0.0, 1e-6);
			SHADE_PROOF_NEAR(rest.sine, sin(0.5 * (a - b)), 0.0, 1e-6);
			SHADE_PROOF_NEAR(rest.cosine, cos(0.5 * (a - b)), 0.0, 1e-6);
		}
}

/* ---- random draws ------------------------------------------------------------------------------------------------ */

/* A random surface and view: one in ten is seen along the surface or nearly so, one in fifty has the tolerance 0. */
static surface random_surface(shade_proof_random *random)
{
	surface s = {.n = shade_proof_random_direction(random)};
	s.v = shade_proof_random_above(random, s.n);
	if (shade_proof_uniform(random) < 0.1f) {
		stilb_vec3 along = stilb_vec3_normalize(s.v - s.n * stilb_vec3_dot(s.n, s.v));
		s.v = stilb_vec3_normalize(along + s.n * shade_proof_log_range(random, 1e-9f, 1e-1f));
	}
	s.exponent = shade_proof_log_range(random, 1e-2f, 2e6f);
	s.alpha = shade_proof_log_range(random, SHADE_ALPHA_MIN, 1.0f);
	s.tolerance = shade_proof_uniform(random) < 0.02f ? 0.0f : shade_proof_log_range(random, 1e-6f, 1e3f);
	return s;
}

/* A direction anywhere, or near the cone's rim: between 1e-7 and a tenth of the half angle beside it, towards n, away
 * from it, or to any side. */
static vector random_light(shade_proof_random *random, const surface *s, shade_cone cone)
{
	vector anywhere = widened(shade_proof_random_direction(random)), axis = widened(cone.axis);
	float kind = shade_proof_uniform(random), beside = shade_proof_log_range(random, 1e-7f, 0.1f);
	if (kind < 0.3f)
		return anywhere;
	if (kind > 0.6f && sine_squared(axis, widened(s->n)) > 1e-6)
		anywhere = kind < 0.8f ? widened(s->n) : blend(-1.0, widened(s->n), 0.0, anywhere);
	double half_angle =
		half_angle_of(cone) * (1.0 + (shade_proof_uniform(random) < 0.3f ? -1.0 : 1.0) * (double)beside);
	return turned(axis, anywhere, fmin(half_angle, M_PI));
}

static void no_light_outside_exceeds(int lobe, uint64_t seed)
{
	shade_proof_random random = {.seed = seed};
	int outside = 0, inside = 0;
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		surface s = random_surface(&random);
		shade_cone cone = cone_of(lobe, &s);
		assert_true(cone.chord < 2.00001f && (cone.chord >= 0.0f || cone.chord == -1.0f));
		stilb_vec3 l = narrowed(random_light(&random, &s, cone));
		double found = highlight(lobe, &s, widened(l));
		inside += found > (double)s.tolerance;
		if (shade_cone_holds(cone, l))
			continue;
		outside++;
		if (found > (double)s.tolerance)
			fail_msg(
				"lobe %d, exponent %g, alpha %g: a light %.9g from the axis shows %.9g, above %.9g, and the cone ends "
				"at %.9g",
				lobe, (double)s.exponent, (double)s.alpha, angle_between(widened(l), widened(cone.axis)), found,
				(double)s.tolerance, half_angle_of(cone));
	}
	assert_true(outside > SHADE_PROOF_COUNT / 5 && inside > SHADE_PROOF_COUNT / 20);
}

static void no_light_outside_phong_exceeds(void **state)
{
	(void)state;
	no_light_outside_exceeds(PHONG, 1);
}

static void no_light_outside_blinn_phong_exceeds(void **state)
{
	(void)state;
	no_light_outside_exceeds(BLINN_PHONG, 2);
}

static void no_light_outside_ggx_exceeds(void **state)
{
	(void)state;
	no_light_outside_exceeds(GGX, 3);
}

/* The same for the highlights that a shader computes in float: Phong's and Blinn-Phong's, and D V n.l of GGX with each
 * G that the header names. Where these have no digits they are left out: cosines near a right angle, and the half
 * vector of nearly opposite vectors. */
static void no_light_outside_exceeds_in_float(void **state)
{
	(void)state;
	static const int gs[] = {SHADE_G_SMITH_GGX, SHADE_G_IMPLICIT, SHADE_G_NEUMANN};
	shade_proof_random random = {.seed = 4};
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		surface s = random_surface(&random);
		shade_cone cone = cone_of(i % LOBE_COUNT, &s);
		stilb_vec3 l = narrowed(random_light(&random, &s, cone));
		shade_angles angles = shade_angles_of(s.n, l, s.v);
		float sin2_r = shade_sin2_r(s.n, l, s.v);
		bool coarse = i % LOBE_COUNT == PHONG ? sin2_r > 0.99f && sin2_r < 1.0f : angles.v_dot_h < 0.1f;
		if (shade_cone_holds(cone, l) || angles.n_dot_l <= 0.0f || angles.n_dot_v <= 0.0f || coarse)
			continue;
		float most = 1.00001f * s.tolerance;
		if (i % LOBE_COUNT == PHONG) {
			assert_true(shade_phong(sin2_r, s.exponent) <= most);
			assert_true(shade_phong_modified(sin2_r, angles.n_dot_l, s.exponent) <= most);
		} else if (i % LOBE_COUNT == BLINN_PHONG) {
			assert_true(shade_blinn_phong(angles.sin2_h, s.exponent) <= most);
			assert_true(shade_blinn_phong_modified(angles.sin2_h, angles.n_dot_l, s.exponent) <= most);
		} else {
			for (size_t g = 0; g < sizeof gs / sizeof gs[0]; g++)
				assert_true(shade_d_ggx(angles.sin2_h, s.alpha) * shade_v(gs[g], angles, s.alpha, s.alpha) *
				                angles.n_dot_l <=
				            most);
		}
	}
}

/* Just inside, in the plane of n and v on either side of the axis, the highlight is above the tolerance: no smaller
 * cone would do. On the far side the plane ends where the half vector reaches a right angle with v. */
static void cones_are_no_wider_than_needed(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 5};
	int checked = 0;
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		surface s = random_surface(&random);
		int lobe = i % LOBE_COUNT;
		shade_cone cone = cone_of(lobe, &s);
		vector n = widened(s.n), v = widened(s.v), r = unit(blend(2.0 * dot(n, v), n, -1.0, v));
		double inside = 0.999 * half_angle_of(cone) - 1e-5, tilt = angle_between(n, v);
		/* There the highlight is flat, and moving aside changes little. */
		bool at_the_peak = highlight(lobe, &s, r) < 1.01 * (double)s.tolerance;
		bool bounded = cone.chord >= 0.0f && cone.chord < 1.999f && s.tolerance > 0.0f;
		if (!bounded || at_the_peak || inside < 0.0 || tilt < 1e-3)
			continue;
		for (int side = -1; side <= 1; side += 2) {
			if (lobe != PHONG && side < 0 && 2.0 * tilt + inside > M_PI - 0.01)
				continue;
			double found = highlight(lobe, &s, turned(r, n, side * inside));
			checked++;
			if (!(found > (double)s.tolerance))
				fail_msg("lobe %d, exponent %g, alpha %g: %g inside of the cone, where %g is allowed outside", lobe,
				         (double)s.exponent, (double)s.alpha, found, (double)s.tolerance);
		}
	}
	assert_true(checked > SHADE_PROOF_COUNT / 2);
}

static shade_cone random_cone(shade_proof_random *random)
{
	shade_cone cone = {shade_proof_random_direction(random), shade_proof_log_range(random, 1e-5f, 2.0f)};
	float kind = shade_proof_uniform(random);
	cone.chord = kind < 0.02f ? -1.0f : kind < 0.04f ? 0.0f : kind < 0.06f ? 2.0f : cone.chord;
	return cone;
}

/* A second cone: about any axis, or nearly the same axis, or nearly the opposite one. */
static shade_cone random_other(shade_proof_random *random, shade_cone cone)
{
	shade_cone other = random_cone(random);
	float kind = shade_proof_uniform(random), nearness = shade_proof_log_range(random, 1e-9f, 1e-1f);
	if (kind < 0.4f)
		other.axis = stilb_vec3_normalize((kind < 0.2f ? cone.axis : -cone.axis) + other.axis * nearness);
	return other;
}

/* A direction of the cone, its rim included. */
static stilb_vec3 random_inside(shade_proof_random *random, shade_cone cone)
{
	vector anywhere = widened(shade_proof_random_direction(random));
	double half_angle = half_angle_of(cone) * fmin((double)shade_proof_range(random, 0.0f, 2.0f), 1.0);
	return narrowed(turned(widened(cone.axis), anywhere, half_angle));
}

static void unions_hold_both(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 6};
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		shade_cone a = random_cone(&random), b = random_other(&random, a), both = shade_cone_union(a, b);
		stilb_vec3 of_a = random_inside(&random, a), of_b = random_inside(&random, b);
		both.chord += both.chord < 0.0f ? 0.0f : 3e-7f; /* the directions that are tested are rounded */
		if ((a.chord >= 0.0f && !shade_cone_holds(both, of_a)) || (b.chord >= 0.0f && !shade_cone_holds(both, of_b)))
			fail_msg("chords %.9g and %.9g, %.9g apart: not in the union's %.9g", (double)a.chord, (double)b.chord,
			         angle_between(widened(a.axis), widened(b.axis)), (double)both.chord);
		SHADE_PROOF_NEAR(2.0 * sin(0.5 * fmax(half_angle_of(both), 0.0)), 2.0 * sin(0.5 * half_angle_of_union(a, b)),
		                 0.0, WITHIN);
	}
}

/* A tile of pixels: cones joined one after the other hold every direction of each. */
static void a_tile_holds_the_cones_of_its_pixels(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 7};
	for (int tile = 0; tile < 2000; tile++) {
		shade_cone cones[64], all = {{0.0f, 0.0f, 1.0f}, -1.0f};
		surface s = random_surface(&random);
		for (int i = 0; i < 64; i++) {
			s.n = stilb_vec3_normalize(s.n + shade_proof_random_direction(&random) * 0.02f);
			cones[i] = cone_of(tile % LOBE_COUNT, &s);
			all = shade_cone_union(all, cones[i]);
		}
		all.chord += all.chord < 0.0f ? 0.0f : 3e-7f;
		for (int i = 0; i < 64; i++)
			assert_true(cones[i].chord < 0.0f || shade_cone_holds(all, random_inside(&random, cones[i])));
	}
}

int main(void)
{
	const struct CMUnitTest exactness[] = {
		cmocka_unit_test(phong_has_both_of_karis_forms),
		cmocka_unit_test(facets_turn_the_light_twice_as_far),
		cmocka_unit_test(rims_are_at_the_tolerance),
		cmocka_unit_test(cones_keep_to_their_range),
		cmocka_unit_test(unions_are_the_smallest),
		cmocka_unit_test(unions_of_special_cones),
		cmocka_unit_test(half_angles_add),
	};
	const struct CMUnitTest properties[] = {
		cmocka_unit_test(no_light_outside_phong_exceeds),       cmocka_unit_test(no_light_outside_blinn_phong_exceeds),
		cmocka_unit_test(no_light_outside_ggx_exceeds),         cmocka_unit_test(no_light_outside_exceeds_in_float),
		cmocka_unit_test(cones_are_no_wider_than_needed),       cmocka_unit_test(unions_hold_both),
		cmocka_unit_test(a_tile_holds_the_cones_of_its_pixels),
	};
	return SHADE_PROOF_RUN(exactness, properties);
}
