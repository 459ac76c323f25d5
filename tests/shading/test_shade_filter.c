/* shade_normal_filter.h, where filters average texels of a normal and a roughness: each filter against its formula in
 * double, the filters against one another where they must agree, and all of them against what they stand for: the
 * average of the lobes of microfacet normals themselves. */

#include "shading/shade_normal_filter.h"

#include "numeric/numeric_quadrature.h"
#include "support/shade_proof.h"

static const stilb_vec3 Z = {0.0f, 0.0f, 1.0f};

/* The unit vector at this angle (radians) from +Z towards +X. */
static stilb_vec3 tilted(double angle)
{
	return stilb_vec3_make((float)sin(angle), 0.0f, (float)cos(angle));
}

static shade_rough_normal texel(stilb_vec3 normal, double alpha)
{
	shade_rough_normal t = {normal, (float)alpha};
	return t;
}

/* The spherical variance 1 - |r| (shade_vmf.h) of the von Mises-Fisher lobe of a texel; not for a small sharpness. */
static double lobe_variance(double alpha)
{
	double sharpness = 2.0 / (alpha * alpha);
	return 1.0 / sharpness - 2.0 * exp(-2.0 * sharpness) / -expm1(-2.0 * sharpness);
}

/* ---- the filters by one interface, to be compared ---------------------------------------------------------------- */

typedef enum filter { VMF, TOKSVIG, VARIANCE, CONVOLUTION, LEAN, FILTER_COUNT } filter;

/* Averages `count` texels, all weighing the same. */
static shade_rough_normal filtered(filter f, const shade_rough_normal *texels, int count)
{
	shade_mean_direction mean = {Z, 0.0f};
	shade_lean lean = {{0.0f, 0.0f}, {0.0f, 0.0f, 0.0f}};
	float alpha2 = 0.0f;
	for (int i = 0; i < count; i++) {
		shade_mean_direction one = f == VMF       ? shade_filter_vmf_mean(texels[i])
		                           : f == TOKSVIG ? shade_filter_toksvig_mean(texels[i])
		                                          : shade_filter_normal_mean(texels[i].normal);
		float share = 1.0f / (float)(i + 1);
		mean = shade_mean_direction_mix(mean, one, share);
		lean = shade_lean_mix(lean, shade_lean_from_normal(texels[i]), share);
		alpha2 += texels[i].alpha * texels[i].alpha / (float)count;
	}
	switch (f) {
	case VMF:
		return shade_filter_vmf(mean);
	case TOKSVIG:
		return shade_filter_toksvig(mean);
	case VARIANCE:
		return shade_filter_variance(mean, alpha2);
	case CONVOLUTION:
		return shade_filter_convolution(mean, alpha2);
	default:
		return shade_lean_normal(lean);
	}
}

/* ---- exactness --------------------------------------------------------------------------------------------------- */

static void widths_are_sharpnesses(void **state)
{
	(void)state;
	SHADE_PROOF_NEAR(shade_filter_inverse_sharpness(0.5f), 0.125, 1e-6, 0.0);
	SHADE_PROOF_NEAR(shade_filter_alpha(0.125f), 0.5, 1e-6, 0.0);
	assert_true(shade_filter_alpha(0.0f) == SHADE_ALPHA_MIN);
	assert_true(shade_filter_alpha(3000.0f) == 1.0f);
}

static void vmf_takes_the_lobes_mean(void **state)
{
	(void)state;
	for (double alpha = 1e-3; alpha <= 1.0; alpha *= 1.1) {
		double a = (double)(float)alpha;
		shade_rough_normal t = texel(tilted(0.3), alpha);
		SHADE_PROOF_NEAR(shade_filter_vmf_mean(t).variance, lobe_variance(a), 1e-6, 0.0);
		SHADE_PROOF_NEAR(shade_filter_vmf(shade_filter_vmf_mean(t)).alpha, a, 1e-6, 0.0);
		stilb_vec3 r = shade_filter_vmf_encode(t);
		SHADE_PROOF_NEAR3(r, sin(0.3) * (1.0 - lobe_variance(a)), 0.0, cos(0.3) * (1.0 - lobe_variance(a)), 1e-6, 0.0);
		shade_rough_normal back = shade_filter_vmf_decode(r);
		SHADE_PROOF_NEAR3(back.normal, sin(0.3), 0.0, cos(0.3), 1e-6, 0.0);
		if (alpha > 0.01)
			SHADE_PROOF_NEAR(back.alpha, 0.988 * a, 0.0, 0.0125 * a + 1e-5);
	}
	assert_true(shade_filter_vmf_decode(Z * 0.5f).alpha == 1.0f);
	SHADE_PROOF_NEAR(shade_filter_vmf_decode(Z * 0.8f).alpha, sqrt(2.0 * 0.36 / (0.8 * 2.36)), 1e-6, 0.0);
}

static void toksvig_has_his_formulas(void **state)
{
	(void)state;
	for (double size = 0.05; size < 1.0; size += 0.05)
		for (double s = 0.0; s < 1e5; s = s * 3.0 + 1.0) {
			double want = size / (size + s * (1.0 - size));
			SHADE_PROOF_NEAR(shade_toksvig_factor((float)(1.0 - size), (float)s), want, 2e-6, 0.0);
		}
	for (double alpha = 1e-3; alpha <= 1.0; alpha *= 1.1) {
		double a = (double)(float)alpha, s = 2.0 / (a * a) - 2.0;
		shade_mean_direction mean = shade_filter_toksvig_mean(texel(Z, alpha));
		SHADE_PROOF_NEAR(mean.variance, 1.0 / (s + 1.0), 1e-6, 0.0);
		SHADE_PROOF_NEAR(shade_filter_toksvig(mean).alpha, a, 1e-6, 0.0);
	}
}

static void widening_has_its_formulas(void **state)
{
	(void)state;
	for (double size = 0.7; size < 1.0; size += 0.01)
		for (double alpha = 0.01; alpha < 0.6; alpha *= 1.5) {
			shade_mean_direction mean = {Z, (float)(1.0 - size)};
			double want = sqrt(alpha * alpha + 2.0 * (1.0 - size) / size);
			shade_rough_normal widened = shade_filter_variance(mean, (float)(alpha * alpha));
			SHADE_PROOF_NEAR(widened.alpha, fmin(want, 1.0), 2e-6, 0.0);
			shade_rough_normal convolved = shade_filter_convolution(mean, (float)(alpha * alpha));
			double kappa = ((double)convolved.alpha * (double)convolved.alpha - alpha * alpha) / 2.0;
			if (convolved.alpha < 1.0f) // alpha was widened by 2 / sharpness: that of the lobe whose |r| is size
				SHADE_PROOF_NEAR(1.0 / tanh(1.0 / kappa) - kappa, size, 1e-5, 0.0);
		}
	assert_true(shade_filter_normal_mean(tilted(0.3)).variance == 0.0f);
	SHADE_PROOF_NEAR3(shade_filter_normal_mean(tilted(0.3)).axis, sin(0.3), 0.0, cos(0.3), 1e-6, 0.0);
}

static void lean_averages_slopes(void **state)
{
	(void)state;
	shade_rough_normal a = texel(stilb_vec3_normalize(stilb_vec3_make(0.3f, -0.4f, 1.0f)), 0.3);
	shade_rough_normal b = texel(stilb_vec3_normalize(stilb_vec3_make(-0.6f, 0.1f, 1.0f)), 0.1);
	shade_lean of_a = shade_lean_from_normal(a), mixed = shade_lean_mix(of_a, shade_lean_from_normal(b), 0.25f);
	SHADE_PROOF_NEAR(of_a.slope[0], 0.3, 1e-6, 0.0);
	SHADE_PROOF_NEAR(of_a.slope[1], -0.4, 1e-6, 0.0);
	SHADE_PROOF_NEAR3(of_a.covariance, 0.045, 0.045, 0.0, 1e-6, 0.0);
	double x = 0.75 * 0.3 - 0.25 * 0.6, y = -0.75 * 0.4 + 0.25 * 0.1, own = 0.75 * 0.045 + 0.25 * 0.005;
	double xx = 0.75 * 0.09 + 0.25 * 0.36, yy = 0.75 * 0.16 + 0.25 * 0.01, xy = -0.75 * 0.12 - 0.25 * 0.06;
	SHADE_PROOF_NEAR(mixed.slope[0], x, 1e-6, 1e-7);
	SHADE_PROOF_NEAR(mixed.slope[1], y, 1e-6, 0.0);
	SHADE_PROOF_NEAR3(shade_lean_moments(mixed), xx + own, yy + own, xy, 1e-6, 1e-7);
	SHADE_PROOF_NEAR3(mixed.covariance, xx + own - x * x, yy + own - y * y, xy - x * y, 1e-6, 1e-7);
	shade_lean back = shade_lean_from_moments(mixed.slope, shade_lean_moments(mixed));
	SHADE_PROOF_NEAR3(back.covariance, mixed.covariance[0], mixed.covariance[1], mixed.covariance[2], 1e-5, 1e-7);
	/* Rounded moments may claim more correlation than there is: at most sqrt(xx yy). */
	stilb_vec2 none = {0.0f, 0.0f};
	SHADE_PROOF_NEAR3(shade_lean_from_moments(none, stilb_vec3_make(0.04f, 0.01f, 1.0f)).covariance, 0.04, 0.01, 0.02,
	                  1e-6, 0.0);
	SHADE_PROOF_NEAR3(shade_lean_from_moments(none, stilb_vec3_make(0.04f, 0.01f, -1.0f)).covariance, 0.04, 0.01, -0.02,
	                  1e-6, 0.0);
	shade_rough_normal one = shade_lean_normal(mixed);
	double alpha = sqrt(xx + yy + 2.0 * own - x * x - y * y), size = sqrt(1.0 + x * x + y * y);
	SHADE_PROOF_NEAR(one.alpha, alpha, 1e-6, 0.0);
	SHADE_PROOF_NEAR3(one.normal, x / size, y / size, 1.0 / size, 1e-6, 1e-7);
}

/* Below z = SHADE_LEAN_Z_MIN the slope is that of a normal with this z: finite at z = 0, of the same sign below it. */
static void lean_ends_the_slopes(void **state)
{
	(void)state;
	static const float z[] = {0.0199f, 0.01f, 0.0f, -0.01f, -0.5f};
	for (int i = 0; i < 5; i++) {
		float s = sqrtf(1.0f - z[i] * z[i]);
		shade_lean lean = shade_lean_from_normal(texel(stilb_vec3_make(0.6f * s, -0.8f * s, z[i]), 0.2));
		SHADE_PROOF_NEAR(lean.slope[0], 0.6 * (double)s / 0.02, 1e-6, 0.0);
		SHADE_PROOF_NEAR(lean.slope[1], -0.8 * (double)s / 0.02, 1e-6, 0.0);
		SHADE_PROOF_NEAR3(lean.covariance, 0.02, 0.02, 0.0, 1e-6, 0.0);
	}
	shade_lean above = shade_lean_from_normal(texel(stilb_vec3_make(sqrtf(1.0f - 0.021f * 0.021f), 0.0f, 0.021f), 0.2));
	SHADE_PROOF_NEAR(above.slope[0], sqrt(1.0 - 0.021 * 0.021) / 0.021, 1e-6, 0.0);
}

/* Ellipses made from their axes. */
static void lean_finds_its_axes(void **state)
{
	(void)state;
	for (int step = -9; step <= 9; step++) {
		double angle = step * M_PI / 18.0, c = cos(angle), s = sin(angle);
		double along = 0.4, across = 0.1, p = along * along / 2.0, q = across * across / 2.0;
		shade_lean lean = {{0.0f, 0.0f},
		                   {(float)(p * c * c + q * s * s), (float)(p * s * s + q * c * c), (float)((p - q) * c * s)}};
		shade_lean_axes axes = shade_lean_axes_of(lean);
		SHADE_PROOF_NEAR(axes.alpha_along, along, 1e-6, 0.0);
		SHADE_PROOF_NEAR(axes.alpha_across, across, 1e-5, 0.0);
		SHADE_PROOF_NEAR(fabs((double)axes.direction[0] * c + (double)axes.direction[1] * s), 1.0, 1e-6, 0.0);
	}
	shade_lean round = {{0.3f, 0.0f}, {0.02f, 0.02f, 0.0f}};
	assert_true(shade_lean_axes_of(round).direction[0] == 1.0f && shade_lean_axes_of(round).direction[1] == 0.0f);
	SHADE_PROOF_NEAR(shade_lean_axes_of(round).alpha_along, 0.2, 1e-6, 0.0);
	SHADE_PROOF_NEAR(shade_lean_axes_of(round).alpha_across, 0.2, 1e-6, 0.0);
}

/* The average of equal texels is that texel, however smooth, rough or tilted. */
static void equal_texels_stay(void **state)
{
	(void)state;
	for (int f = 0; f < FILTER_COUNT; f++)
		for (double alpha = 1e-3; alpha <= 1.0; alpha *= 1.3) {
			stilb_vec3 n = stilb_vec3_normalize(stilb_vec3_make(0.3f, -0.2f, 1.0f));
			shade_rough_normal texels[] = {texel(n, alpha), texel(n, alpha), texel(n, alpha), texel(n, alpha)};
			shade_rough_normal got = filtered((filter)f, texels, 4);
			SHADE_PROOF_NEAR(got.alpha, alpha, 2e-5, 0.0);
			SHADE_PROOF_NEAR3(got.normal, n[0], n[1], n[2], 1e-6, 0.0);
		}
}

/* Two normals 2 t apart, t in radians: every filter makes alpha^2 + t^2 of alpha^2, as long as both are small. */
static void filters_agree_on_small_bumps(void **state)
{
	(void)state;
	for (int f = 0; f < FILTER_COUNT; f++)
		for (double t = 1e-3; t < 0.03; t *= 1.5) {
			shade_rough_normal texels[] = {texel(tilted(t), 0.02), texel(tilted(-t), 0.02)};
			shade_rough_normal got = filtered((filter)f, texels, 2);
			SHADE_PROOF_NEAR(got.alpha, sqrt(4e-4 + t * t), 1e-3, 0.0);
			SHADE_PROOF_NEAR3(got.normal, 0.0, 0.0, 1.0, 1e-6, 1e-6);
		}
}

/* A smooth texel leans to +X, a rough one as far to -X: vMF's and Toksvig's mean normal leans to +X, those of the other
 * filters to neither side. */
static void a_smooth_normal_outweighs_a_rough_one(void **state)
{
	(void)state;
	shade_rough_normal texels[] = {texel(tilted(0.3), 0.05), texel(tilted(-0.3), 0.8)};
	double smooth = 1.0 - lobe_variance(0.05), rough = 1.0 - lobe_variance(0.8);
	double want = atan((smooth - rough) / (smooth + rough) * tan(0.3));
	double lean[FILTER_COUNT];
	for (int f = 0; f < FILTER_COUNT; f++) {
		shade_rough_normal got = filtered((filter)f, texels, 2);
		lean[f] = atan2((double)got.normal[0], (double)got.normal[2]);
	}
	SHADE_PROOF_NEAR(lean[VMF], want, 1e-4, 0.0);
	assert_true(lean[VMF] > 0.05 && lean[TOKSVIG] > 0.05);
	assert_true(fabs(lean[VARIANCE]) < 1e-6 && fabs(lean[CONVOLUTION]) < 1e-6 && fabs(lean[LEAN]) < 1e-6);
}

/* ---- against the average of the lobes ---------------------------------------------------------------------------- */

/* Density of microfacet normals h about a texel's normal: Beckmann's D, with the tilt taken from h - n. */
static double beckmann(shade_rough_normal t, const double h[3])
{
	double d2 = 0.0;
	for (int k = 0; k < 3; k++)
		d2 += (h[k] - (double)t.normal[k]) * (h[k] - (double)t.normal[k]);
	double cosine = 1.0 - d2 / 2.0, cos2 = cosine * cosine, a2 = (double)t.alpha * (double)t.alpha;
	return cosine <= 1e-3 ? 0.0 : exp(-(1.0 - cos2) / (a2 * cos2)) / (M_PI * a2 * cos2 * cos2);
}

typedef struct patch {
	const shade_rough_normal *texels;
	int count;
	shade_rough_normal stand_in;
} patch;

/* The integrand of the distance between the density of the filtered texel (stand_in) and the average of all texels'
 * densities, |difference| / 2. The integral is 0 if they are equal, and 1 if they lie nowhere in the same place. */
static double difference_at(const double h[3], const void *context)
{
	const patch *p = context;
	double average = 0.0;
	for (int i = 0; i < p->count; i++)
		average += beckmann(p->texels[i], h) / p->count;
	return 0.5 * fabs(average - beckmann(p->stand_in, h));
}

static double distance(const shade_rough_normal *texels, int count, shade_rough_normal stand_in)
{
	patch p = {texels, count, stand_in};
	return stilb_numeric_integrate_sphere(difference_at, &p, 0.0, 1.0, 6);
}

#define PATCH 64

/* A bumpy patch of 64 texels: their slopes are spread as a normal distribution of the deviation `slope`. */
static void make_bumps(shade_rough_normal *texels, double slope, double alpha)
{
	for (int i = 0; i < PATCH; i++) {
		double radius = slope * sqrt(-2.0 * log((i % 8 + 0.5) / 8.0)), angle = (i / 8 + (i % 8) * 0.5) * M_PI / 4.0;
		double x = radius * cos(angle), y = radius * sin(angle);
		texels[i] = texel(stilb_vec3_normalize(stilb_vec3_make((float)x, (float)y, 1.0f)), alpha);
	}
}

/* Slopes as wide as the lobes, and half as wide again. Without a filter (the mean normal with the texels' alpha) the
 * distance from the average is large, and known; with any filter it is small. */
static void filters_stand_for_the_average(void **state)
{
	(void)state;
	static const double cases[][4] = {{0.15, 0.15, 0.38, 0.036}, {0.3, 0.2, 0.56, 0.11}};
	shade_rough_normal texels[PATCH];
	for (int i = 0; i < 2; i++) {
		const double *c = cases[i];
		make_bumps(texels, c[0], c[1]);
		SHADE_PROOF_NEAR(distance(texels, PATCH, texel(Z, c[1])), c[2], 0.02, 0.0);
		for (int f = 0; f < FILTER_COUNT; f++) {
			double with = distance(texels, PATCH, filtered((filter)f, texels, PATCH));
			if (!(with < c[3]))
				fail_msg("filter %d is %g from the average", f, with);
		}
	}
}

/* ---- properties -------------------------------------------------------------------------------------------------- */

static void good(shade_rough_normal t)
{
	assert_true(t.alpha >= SHADE_ALPHA_MIN && t.alpha <= 1.0f);
	SHADE_PROOF_NEAR(stilb_vec3_dot(t.normal, t.normal), 1.0, 1e-5, 0.0);
}

static shade_rough_normal random_texel(shade_proof_random *random, bool tangent)
{
	stilb_vec3 n = tangent ? shade_proof_random_above(random, Z) : shade_proof_random_direction(random);
	return texel(n, (double)shade_proof_log_range(random, SHADE_ALPHA_MIN, 1.0f));
}

/* Patches with normals anywhere (object space), above the surface (tangent space), opposite ones, and equal ones. */
static void any_patch_gives_a_lobe(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 1};
	for (int i = 0; i < SHADE_PROOF_COUNT / FILTER_COUNT; i++) {
		shade_rough_normal texels[4];
		for (int k = 0; k < 4; k++)
			texels[k] = random_texel(&random, i & 1);
		if (i % 8 == 6)
			texels[1].normal = -texels[0].normal;
		for (int f = 0; f < FILTER_COUNT; f++) {
			float roughest = 0.0f, smoothest = 1.0f;
			for (int k = 0; k < 4; k++)
				roughest = fmaxf(roughest, texels[k].alpha), smoothest = fminf(smoothest, texels[k].alpha);
			shade_rough_normal got = filtered((filter)f, texels, 4);
			good(got);
			assert_true(got.alpha >= smoothest * 0.9999f); // filtering never polishes
			if (f != LEAN && f != VARIANCE && f != CONVOLUTION)
				continue;
			assert_true(got.alpha >= roughest * 0.4999f); // of four texels: a quarter of its alpha^2 is left
		}
	}
}

/* Over the whole range of alpha, what makes a texel of a mean is the inverse of what makes a mean of a texel. */
static void widths_come_back(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 4};
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		shade_rough_normal t = random_texel(&random, i & 1);
		shade_rough_normal vmf = shade_filter_vmf(shade_filter_vmf_mean(t));
		shade_rough_normal toksvig = shade_filter_toksvig(shade_filter_toksvig_mean(t));
		SHADE_PROOF_NEAR(vmf.alpha, (double)t.alpha, 1e-6, 0.0);
		SHADE_PROOF_NEAR(toksvig.alpha, (double)t.alpha, 1e-6, 0.0);
		SHADE_PROOF_NEAR(shade_filter_alpha(shade_filter_inverse_sharpness(t.alpha)), (double)t.alpha, 2e-7, 0.0);
		assert_true(vmf.normal[0] == t.normal[0] && toksvig.normal[0] == t.normal[0]);
		/* A float r knows its length to 1e-7, and the fast form is 2.4 % too narrow at most. */
		shade_rough_normal decoded = shade_filter_vmf_decode(shade_filter_vmf_encode(t));
		double alpha = (double)t.alpha;
		SHADE_PROOF_NEAR(decoded.alpha, 0.988 * alpha, 0.0, 0.0125 * alpha + 4e-7 / alpha);
	}
}

static void any_average_decodes(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 2};
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		stilb_vec3 direction = shade_proof_random_direction(&random);
		good(shade_filter_vmf_decode(direction * (i % 16 ? shade_proof_uniform(&random) : 1e-3f * (float)(i % 5))));
		float v = i % 16 ? shade_proof_uniform(&random) : (float)(i / 16 % 2),
			  s = shade_proof_range(&random, 0.0f, 2e6f);
		shade_mean_direction mean = {direction, v};
		good(shade_filter_toksvig(mean));
		good(shade_filter_vmf(mean));
		good(shade_filter_variance(mean, shade_proof_uniform(&random)));
		good(shade_filter_convolution(mean, shade_proof_uniform(&random)));
		float factor = shade_toksvig_factor(v, s);
		assert_true(factor >= 0.0f && factor <= 1.0f);
	}
}

static void any_moments_are_an_ellipse(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 3};
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		float widest = shade_proof_log_range(&random, 1e-6f, 1e4f);
		stilb_vec2 slope = {shade_proof_range(&random, -50.0f, 50.0f), shade_proof_range(&random, -50.0f, 50.0f)};
		stilb_vec3 moments = shade_proof_random_color(&random, widest);
		moments[2] -= 0.5f * widest;
		shade_lean lean = shade_lean_from_moments(i & 1 ? slope : slope * 1e-4f, moments);
		shade_lean_axes axes = shade_lean_axes_of(lean);
		good(shade_lean_normal(lean));
		assert_true(lean.covariance[0] >= 0.0f && lean.covariance[1] >= 0.0f);
		assert_true(axes.alpha_along >= axes.alpha_across && axes.alpha_across >= SHADE_ALPHA_MIN);
		assert_true(axes.alpha_along <= 1.0f);
		SHADE_PROOF_NEAR(axes.direction[0] * axes.direction[0] + axes.direction[1] * axes.direction[1], 1.0, 1e-5, 0.0);
	}
}

int main(void)
{
	const struct CMUnitTest exactness[] = {
		cmocka_unit_test(widths_are_sharpnesses),       cmocka_unit_test(vmf_takes_the_lobes_mean),
		cmocka_unit_test(toksvig_has_his_formulas),     cmocka_unit_test(widening_has_its_formulas),
		cmocka_unit_test(lean_averages_slopes),         cmocka_unit_test(lean_ends_the_slopes),
		cmocka_unit_test(lean_finds_its_axes),          cmocka_unit_test(equal_texels_stay),
		cmocka_unit_test(filters_agree_on_small_bumps), cmocka_unit_test(a_smooth_normal_outweighs_a_rough_one),
	};
	const struct CMUnitTest properties[] = {
		cmocka_unit_test(filters_stand_for_the_average),
		cmocka_unit_test(any_patch_gives_a_lobe),
		cmocka_unit_test(widths_come_back),
		cmocka_unit_test(any_average_decodes),
		cmocka_unit_test(any_moments_are_an_ellipse),
	};
	return SHADE_PROOF_RUN(exactness, properties);
}
