/* shade_sh.h and shade_luminance.h: against spherical harmonics that are computed here in double from Legendre's
 * recurrence, and against numerical integration. */

#include "shading/shade_sh.h"

#include "numeric/numeric_quadrature.h"
#include "support/shade_proof.h"

/* ---- truth ------------------------------------------------------------------------------------------------------- */

static int band_of(int index)
{
	return index == 0 ? 0 : index < 4 ? 1 : 2;
}

/* Associated Legendre function with the Condon-Shortley phase, 0 <= m <= l, by its three-term recurrence in l. */
static double legendre(int l, int m, double x)
{
	double last = 0.0, value = 1.0;
	for (int i = 1; i <= m; i++)
		value *= -(2.0 * i - 1.0) * sqrt(1.0 - x * x);
	for (int i = m + 1; i <= l; i++) {
		double next = ((2.0 * i - 1.0) * x * value - (i + m - 1.0) * last) / (i - m);
		last = value;
		value = next;
	}
	return value;
}

/* The real harmonic of the index l (l + 1) + m, from its definition in angles about +Z. */
static double harmonic(int index, const double d[3])
{
	int l = band_of(index), m = index - l * (l + 1), size = abs(m);
	double phi = atan2(d[1], d[0]), z = fmin(fmax(d[2], -1.0), 1.0);
	double norm = sqrt((2.0 * l + 1.0) / (4.0 * M_PI) * tgamma(l - size + 1.0) / tgamma(l + size + 1.0));
	double turn = m == 0 ? 1.0 : sqrt(2.0) * (m > 0 ? cos(size * phi) : sin(size * phi));
	return norm * turn * legendre(l, size, z);
}

/* The clamped cosine's part in band l: the integral of cos P_l(cos) over the half sphere. */
static double cosine_legendre(double x, const void *context)
{
	return 2.0 * M_PI * x * legendre(*(const int *)context, 0, x);
}

static double cosine_band(int l)
{
	return stilb_numeric_integrate(cosine_legendre, &l, 0.0, 1.0, 1);
}

/* The irradiance that three bands give for a directional light of irradiance 1, on a surface whose normal has this
 * cosine with it. Band l is multiplied by window[l]. */
static double irradiance_at(double cosine, const double window[3])
{
	double sum = 0.0;
	for (int l = 0; l < 3; l++)
		sum += window[l] * cosine_band(l) * (2.0 * l + 1.0) / (4.0 * M_PI) * legendre(l, 0, cosine);
	return sum;
}

static double radiance_at(double cosine, const double window[3])
{
	double sum = 0.0;
	for (int l = 0; l < 3; l++)
		sum += window[l] * (2.0 * l + 1.0) / (4.0 * M_PI) * legendre(l, 0, cosine);
	return sum;
}

static shade_sh random_sh(shade_proof_random *random, float highest)
{
	shade_sh f;
	for (int i = 0; i < 9; i++)
		f.c[i] = shade_proof_range(random, -highest, highest);
	return f;
}

static void to_doubles(stilb_vec3 v, double d[3])
{
	for (int axis = 0; axis < 3; axis++)
		d[axis] = (double)v[axis];
}

static double sum_of_harmonics(shade_sh f, const double d[3])
{
	double sum = 0.0;
	for (int i = 0; i < 9; i++)
		sum += (double)f.c[i] * harmonic(i, d);
	return sum;
}

/* A frame with a random normal, turned about it by a random angle. */
static shade_frame random_frame(shade_proof_random *random, bool mirrored)
{
	shade_frame frame = shade_frame_from_normal(shade_proof_random_direction(random));
	float angle = shade_proof_range(random, 0.0f, 6.2831853f);
	stilb_vec3 t = frame.t * cosf(angle) + frame.b * sinf(angle), b = frame.b * cosf(angle) - frame.t * sinf(angle);
	return (shade_frame){t, mirrored ? -b : b, frame.n};
}

/* ---- exactness --------------------------------------------------------------------------------------------------- */

static void luminance_weighs_channels(void **state)
{
	(void)state;
	SHADE_PROOF_NEAR(shade_luminance(stilb_vec3_make(1.0f, 0.0f, 0.0f)), 0.2126, 1e-7, 0.0);
	SHADE_PROOF_NEAR(shade_luminance(stilb_vec3_make(0.0f, 1.0f, 0.0f)), 0.7152, 1e-7, 0.0);
	SHADE_PROOF_NEAR(shade_luminance(stilb_vec3_make(0.0f, 0.0f, 1.0f)), 0.0722, 1e-7, 0.0);
	SHADE_PROOF_NEAR(shade_luminance(stilb_vec3_make(1e30f, 1e30f, 1e30f)), 1e30, 2e-7, 0.0);
}

static void basis_is_the_harmonics(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 1};
	for (int k = 0; k < 500; k++) {
		stilb_vec3 direction = shade_proof_random_direction(&random);
		double d[3];
		to_doubles(direction, d);
		shade_sh basis = shade_sh_basis(direction), light = shade_sh_directional(direction, 3.0f);
		for (int i = 0; i < 9; i++) {
			SHADE_PROOF_NEAR(basis.c[i], harmonic(i, d), 0.0, 5e-7);
			SHADE_PROOF_NEAR(light.c[i], 3.0 * harmonic(i, d), 0.0, 1.5e-6);
		}
	}
}

static void coefficients_are_a_vector(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 2};
	for (int k = 0; k < 100; k++) {
		shade_sh a = random_sh(&random, 2.0f), b = random_sh(&random, 2.0f);
		shade_sh sum = shade_sh_add(a, b), half = shade_sh_scale(a, 0.5f);
		stilb_vec3 direction = shade_proof_random_direction(&random);
		double d[3], product = 0.0;
		to_doubles(direction, d);
		for (int i = 0; i < 9; i++) {
			assert_true(sum.c[i] == a.c[i] + b.c[i]);
			assert_true(half.c[i] == 0.5f * a.c[i]);
			product += (double)a.c[i] * (double)b.c[i];
		}
		SHADE_PROOF_NEAR(shade_sh_dot(a, b), product, 0.0, 1e-5);
		SHADE_PROOF_NEAR(shade_sh_evaluate(a, direction), sum_of_harmonics(a, d), 0.0, 1e-5);
	}
}

static void ambient_is_the_same_everywhere(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 3};
	shade_sh f = shade_sh_ambient(0.7f);
	for (int k = 0; k < 100; k++) {
		stilb_vec3 d = shade_proof_random_direction(&random);
		SHADE_PROOF_NEAR(shade_sh_evaluate(f, d), 0.7, 1e-6, 0.0);
		SHADE_PROOF_NEAR(shade_sh_irradiance(f, d), 0.7 * M_PI, 1e-6, 0.0);
	}
}

static void convolution_scales_bands(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 4};
	shade_sh f = random_sh(&random, 1.0f);
	shade_sh scaled = shade_sh_convolve(f, stilb_vec3_make(2.0f, 3.0f, 5.0f));
	shade_sh irradiance = shade_sh_convolve_cosine(f), windowed = shade_sh_window(f, 0.3f);
	const float factors[] = {2.0f, 3.0f, 5.0f};
	double held = 0.0;
	for (int i = 0; i < 9; i++) {
		int l = band_of(i);
		assert_true(scaled.c[i] == f.c[i] * factors[l]);
		SHADE_PROOF_NEAR(irradiance.c[i], (double)f.c[i] * cosine_band(l), 1e-6, 0.0);
		SHADE_PROOF_NEAR(windowed.c[i], (double)f.c[i] * exp(-0.3 * l * (l + 1)), 1e-6, 0.0);
		held += cosine_band(l) * cosine_band(l) / (4.0 * M_PI);
	}
	SHADE_PROOF_NEAR(cosine_band(0), M_PI, 1e-12, 0.0);
	SHADE_PROOF_NEAR(cosine_band(1), 2.0 * M_PI / 3.0, 1e-12, 0.0);
	SHADE_PROOF_NEAR(cosine_band(2), M_PI / 4.0, 1e-12, 0.0);
	/* 2 pi / 3 is the integral of the cosine's square over the hemisphere. */
	SHADE_PROOF_NEAR(held, 0.9922 * 2.0 * M_PI / 3.0, 1e-4, 0.0);
}

typedef struct lobe_band {
	double exponent;
	int l;
} lobe_band;

/* The lobe's density over all azimuths, times Legendre's polynomial. */
static double lobe_legendre(double x, const void *context)
{
	const lobe_band *band = context;
	return (band->exponent + 1.0) * pow(x, band->exponent) * legendre(band->l, 0, x);
}

static void a_highlights_lobe_has_these_bands(void **state)
{
	(void)state;
	static const double exponents[] = {0.0, 1.0, 2.5, 7.0, 30.0, 200.0};
	for (size_t i = 0; i < sizeof exponents / sizeof *exponents; i++) {
		stilb_vec3 bands = shade_sh_lobe((float)exponents[i]);
		for (int l = 0; l < 3; l++) {
			lobe_band band = {exponents[i], l};
			SHADE_PROOF_NEAR(bands[l], stilb_numeric_integrate(lobe_legendre, &band, 0.0, 1.0, 60), 1e-5, 1e-7);
		}
	}
	assert_true(shade_sh_lobe(1e6f)[2] > 0.999f); /* a mirror's are 1 */
}

/* 1.0625 and 0.0625, and less than nothing in between: the header's facts, asserted. */
static void directional_light_rings(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 5};
	const double all[3] = {1.0, 1.0, 1.0};
	double least = 1.0, where = 0.0;
	for (int k = 0; k < 200; k++) {
		stilb_vec3 l = shade_proof_random_direction(&random);
		shade_sh light = shade_sh_directional(l, 1.0f);
		shade_frame frame = shade_frame_from_normal(l);
		float cosine = k / 100.0f - 1.0f;
		stilb_vec3 n = l * cosine + frame.t * sqrtf(1.0f - cosine * cosine);
		double irradiance = (double)shade_sh_irradiance(light, n);
		SHADE_PROOF_NEAR(irradiance, irradiance_at((double)cosine, all), 0.0, 1e-6);
		SHADE_PROOF_NEAR(shade_sh_irradiance(light, l), 1.0625, 1e-6, 0.0);
		SHADE_PROOF_NEAR(shade_sh_irradiance(light, -l), 0.0625, 0.0, 1e-6);
		if (irradiance < least) {
			least = irradiance;
			where = (double)cosine;
		}
	}
	SHADE_PROOF_NEAR(least, -0.03958, 0.0, 1e-5);
	SHADE_PROOF_NEAR(where, -8.0 / 15.0, 0.0, 6e-3);
}

typedef double lobe_value(double cosine, const double window[3]);

static double least_value(lobe_value *value, double blur)
{
	const double window[3] = {1.0, exp(-2.0 * blur), exp(-6.0 * blur)};
	double least = 1.0;
	for (int i = 0; i <= 2000; i++)
		least = fmin(least, value(i / 1000.0 - 1.0, window));
	return least;
}

/* The named windows are the smallest without negative light, rounded up in the fourth digit. */
static void named_windows_are_the_least(void **state)
{
	(void)state;
	assert_true(least_value(irradiance_at, (double)SHADE_SH_WINDOW_IRRADIANCE) > 0.0);
	assert_true(least_value(irradiance_at, (double)SHADE_SH_WINDOW_IRRADIANCE * 0.9998) < 0.0);
	assert_true(least_value(radiance_at, (double)SHADE_SH_WINDOW_RADIANCE) > 0.0);
	assert_true(least_value(radiance_at, (double)SHADE_SH_WINDOW_RADIANCE * 0.9998) < 0.0);
}

/* Sloan's window 1 / (1 + s l^2 (l + 1)^2) with the least s that leaves no negative irradiance, which is on the light's
 * back then: facing the light, 0.584 is left of 1. */
static void laplacian_window_costs_more(void **state)
{
	(void)state;
	double low = 0.1, high = 1.0, window[3] = {1.0};
	for (int step = 0; step < 50; step++) {
		double s = 0.5 * (low + high);
		window[1] = 1.0 / (1.0 + 4.0 * s);
		window[2] = 1.0 / (1.0 + 36.0 * s);
		*(irradiance_at(-1.0, window) < 0.0 ? &low : &high) = s;
	}
	SHADE_PROOF_NEAR(irradiance_at(1.0, window), 0.5845, 0.0, 1e-4);
	stilb_vec3 l = stilb_vec3_make(0.0f, 0.6f, 0.8f), bands = stilb_vec3_make(1.0f, (float)window[1], (float)window[2]);
	shade_sh light = shade_sh_convolve(shade_sh_directional(l, 1.0f), bands);
	SHADE_PROOF_NEAR(shade_sh_irradiance(light, l), 0.5845, 0.0, 1e-4);
}

static void window_has_its_price(void **state)
{
	(void)state;
	stilb_vec3 l = stilb_vec3_make(0.6f, 0.0f, -0.8f);
	shade_sh light = shade_sh_window(shade_sh_directional(l, 1.0f), SHADE_SH_WINDOW_IRRADIANCE);
	SHADE_PROOF_NEAR(shade_sh_irradiance(light, l), 0.8438, 0.0, 1e-4);
	SHADE_PROOF_NEAR(shade_sh_irradiance(light, -l), 0.0137, 0.0, 1e-4);
}

static void rotation_is_exact(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 6};
	for (int k = 0; k < 200; k++) {
		shade_sh f = random_sh(&random, 1.0f);
		shade_frame frame = random_frame(&random, k % 2);
		shade_sh turned = shade_sh_rotate(f, frame);
		stilb_vec3 direction = shade_proof_random_direction(&random);
		double d[3];
		to_doubles(shade_frame_to_local(frame, direction), d);
		SHADE_PROOF_NEAR(shade_sh_evaluate(turned, direction), sum_of_harmonics(f, d), 0.0, 3e-6);
		shade_frame back = {shade_frame_to_local(frame, stilb_vec3_make(1.0f, 0.0f, 0.0f)),
		                    shade_frame_to_local(frame, stilb_vec3_make(0.0f, 1.0f, 0.0f)),
		                    shade_frame_to_local(frame, stilb_vec3_make(0.0f, 0.0f, 1.0f))};
		shade_sh again = shade_sh_rotate(turned, back);
		for (int i = 0; i < 9; i++)
			SHADE_PROOF_NEAR(again.c[i], f.c[i], 0.0, 2e-6);
	}
}

static void dominant_direction_is_band_1(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 7};
	for (int k = 0; k < 100; k++) {
		stilb_vec3 l = shade_proof_random_direction(&random);
		float irradiance = shade_proof_log_range(&random, 1e-15f, 1e15f);
		shade_sh f = shade_sh_add(shade_sh_directional(l, irradiance), shade_sh_ambient(irradiance));
		SHADE_PROOF_NEAR3(shade_sh_dominant_direction(f), l[0], l[1], l[2], 0.0, 1e-6);
	}
	for (int axis = 0; axis < 6; axis++) {
		stilb_vec3 l = {0};
		l[axis / 2] = axis % 2 ? -1.0f : 1.0f;
		SHADE_PROOF_NEAR3(shade_sh_dominant_direction(shade_sh_directional(l, 1.0f)), l[0], l[1], l[2], 0.0, 0.0);
	}
	SHADE_PROOF_NEAR3(shade_sh_dominant_direction(shade_sh_ambient(0.0f)), 0.0, 1.0, 0.0, 0.0, 0.0);
	SHADE_PROOF_NEAR3(shade_sh_dominant_direction(shade_sh_ambient(1e30f)), 0.0, 1.0, 0.0, 0.0, 0.0);
	/* A uniform light has no direction, also with noise of a float step in band 1. */
	shade_sh noise = shade_sh_ambient(1.0f);
	noise.c[3] = 1e-6f;
	SHADE_PROOF_NEAR3(shade_sh_dominant_direction(noise), 0.0, 1.0, 0.0, 0.0, 0.0);
}

/* The irradiance of f on a surface, as a function of its normal, is approximated by that of a directional light from l
 * and an ambient light: least squares over all normals. These are the integrands of the sums in its normal equations,
 * of which `term`, 0 to 4, chooses one. */
typedef struct least_squares {
	shade_sh f;
	double l[3];
	int term;
} least_squares;

static double least_squares_term(const double n[3], const void *context)
{
	const least_squares *c = context;
	double of_f = 0.0, of_light = 0.0;
	for (int i = 0; i < 9; i++) {
		of_f += (double)c->f.c[i] * cosine_band(band_of(i)) * harmonic(i, n);
		of_light += harmonic(i, c->l) * cosine_band(band_of(i)) * harmonic(i, n);
	}
	const double terms[5] = {of_light * of_light, of_light * M_PI, M_PI * M_PI, of_f * of_light, of_f * M_PI};
	return terms[c->term];
}

static void dominant_irradiance_is_the_least_squares(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 8};
	for (int k = 0; k < 3; k++) {
		stilb_vec3 l = shade_proof_random_direction(&random);
		shade_sh other = shade_sh_directional(shade_proof_random_direction(&random), 0.4f);
		shade_sh f = shade_sh_add(shade_sh_add(shade_sh_directional(l, 1.0f), other), shade_sh_ambient(0.2f));
		least_squares c = {.f = f};
		to_doubles(l, c.l);
		double s[5];
		for (c.term = 0; c.term < 5; c.term++)
			s[c.term] = stilb_numeric_integrate_sphere(least_squares_term, &c, -1.0, 1.0, 1);
		double determinant = s[0] * s[2] - s[1] * s[1];
		SHADE_PROOF_NEAR(shade_sh_dominant_irradiance(f, l), (s[3] * s[2] - s[4] * s[1]) / determinant, 2e-6, 0.0);
	}
}

static void dominant_irradiance_has_its_limits(void **state)
{
	(void)state;
	stilb_vec3 up = stilb_vec3_make(0.0f, 1.0f, 0.0f);
	shade_sh light = shade_sh_directional(up, 1.0f);
	assert_true(shade_sh_dominant_irradiance(light, -up) == 0.0f);
	light.c[0] *= 0.5f; /* more in band 1 than any light that is nowhere negative has */
	SHADE_PROOF_NEAR(shade_sh_dominant_irradiance(light, up), 0.5, 1e-6, 0.0);
	light.c[0] = -1.0f;
	assert_true(shade_sh_dominant_irradiance(light, up) == 0.0f);
}

static shade_sh channel(shade_sh_rgb f, int k)
{
	return k == 0 ? f.r : k == 1 ? f.g : f.b;
}

static void assert_same(shade_sh got, shade_sh want)
{
	for (int i = 0; i < 9; i++)
		assert_true(got.c[i] == want.c[i]);
}

static void three_channels_are_three_times_one(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 9};
	shade_sh_rgb f = {random_sh(&random, 1.0f), random_sh(&random, 1.0f), random_sh(&random, 1.0f)};
	stilb_vec3 d = shade_proof_random_direction(&random), color = stilb_vec3_make(0.5f, 2.0f, 3.0f);
	shade_frame frame = random_frame(&random, false);
	shade_sh_rgb light = shade_sh_rgb_directional(d, color), ambient = shade_sh_rgb_ambient(color);
	shade_sh_rgb sum = shade_sh_rgb_add(f, light), blurred = shade_sh_rgb_window(f, 0.2f);
	shade_sh_rgb turned = shade_sh_rgb_rotate(f, frame);
	stilb_vec3 radiance = shade_sh_rgb_evaluate(f, d), irradiance = shade_sh_rgb_irradiance(f, d);
	for (int k = 0; k < 3; k++) {
		shade_sh one = channel(f, k);
		assert_same(channel(light, k), shade_sh_directional(d, color[k]));
		assert_same(channel(ambient, k), shade_sh_ambient(color[k]));
		assert_same(channel(sum, k), shade_sh_add(one, channel(light, k)));
		assert_same(channel(blurred, k), shade_sh_window(one, 0.2f));
		assert_same(channel(turned, k), shade_sh_rotate(one, frame));
		assert_true(radiance[k] == shade_sh_evaluate(one, d));
		assert_true(irradiance[k] == shade_sh_irradiance(one, d));
	}
}

static void sun_and_sky_come_back(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 10};
	for (int k = 0; k < 200; k++) {
		stilb_vec3 l = shade_proof_random_direction(&random), sun = shade_proof_random_color(&random, 4.0f);
		stilb_vec3 ambient = shade_proof_random_color(&random, 1.0f);
		shade_sh_rgb f = shade_sh_rgb_add(shade_sh_rgb_directional(l, sun), shade_sh_rgb_ambient(ambient));
		shade_sh_light light = shade_sh_dominant_light(f);
		if (shade_luminance(sun) < 1e-3f)
			continue; /* black light has no direction */
		SHADE_PROOF_NEAR3(light.direction, l[0], l[1], l[2], 0.0, 1e-5);
		SHADE_PROOF_NEAR3(light.irradiance, sun[0], sun[1], sun[2], 1e-5, 1e-5);
		SHADE_PROOF_NEAR3(light.ambient, ambient[0], ambient[1], ambient[2], 1e-5, 2e-6);
	}
}

/* Three channels with lights from different directions: the common direction is that of the luminance. */
static void direction_is_the_luminances(void **state)
{
	(void)state;
	stilb_vec3 x = stilb_vec3_make(1.0f, 0.0f, 0.0f), z = stilb_vec3_make(0.0f, 0.0f, 1.0f);
	shade_sh_rgb green = shade_sh_rgb_directional(x, stilb_vec3_make(0.0f, 1.0f, 0.0f));
	shade_sh_rgb blue = shade_sh_rgb_directional(z, stilb_vec3_make(0.0f, 0.0f, 1.0f));
	stilb_vec3 d = shade_sh_dominant_light(shade_sh_rgb_add(green, blue)).direction;
	double size = sqrt(0.7152 * 0.7152 + 0.0722 * 0.0722);
	SHADE_PROOF_NEAR3(d, 0.7152 / size, 0.0, 0.0722 / size, 0.0, 1e-6);
}

/* ---- properties -------------------------------------------------------------------------------------------------- */

/* Unsoeld's theorem: the squares of a band's functions add up to (2 l + 1) / (4 pi) in every direction. */
static void bands_look_the_same_everywhere(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 20};
	for (int k = 0; k < SHADE_PROOF_COUNT; k++) {
		shade_sh basis = shade_sh_basis(shade_proof_random_direction(&random));
		float squares[3] = {0};
		for (int i = 0; i < 9; i++)
			squares[band_of(i)] += basis.c[i] * basis.c[i];
		for (int l = 0; l < 3; l++)
			SHADE_PROOF_NEAR(squares[l], (2.0 * l + 1.0) / (4.0 * M_PI), 2e-6, 0.0);
	}
}

/* A few lights, from faint to bright. */
static shade_sh random_light(shade_proof_random *random)
{
	shade_sh light = shade_sh_ambient(0.0f);
	int count = 1 + (int)(3.0f * shade_proof_uniform(random));
	for (int i = 0; i < count; i++) {
		float irradiance = shade_proof_log_range(random, 1e-4f, 1e4f);
		light = shade_sh_add(light, shade_sh_directional(shade_proof_random_direction(random), irradiance));
	}
	return light;
}

static void windowed_light_is_not_negative(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 21};
	for (int k = 0; k < SHADE_PROOF_COUNT; k++) {
		shade_sh light = random_light(&random);
		stilb_vec3 d = shade_proof_random_direction(&random);
		float stronger = shade_proof_uniform(&random) * shade_proof_uniform(&random);
		shade_sh soft = shade_sh_window(light, SHADE_SH_WINDOW_IRRADIANCE + stronger);
		SHADE_PROOF_LIGHT(shade_sh_irradiance(soft, d));
		SHADE_PROOF_LIGHT(shade_sh_evaluate(shade_sh_window(light, SHADE_SH_WINDOW_RADIANCE + stronger), d));
		assert_true(soft.c[0] == light.c[0]);
	}
}

/* A single light after shade_sh_window with SHADE_SH_WINDOW_IRRADIANCE, the least blur at which no irradiance is
 * negative: it is not, where it is lowest. */
static void windowed_light_is_not_negative_where_it_is_darkest(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 22};
	for (int k = 0; k < SHADE_PROOF_COUNT; k++) {
		stilb_vec3 l = shade_proof_random_direction(&random);
		shade_frame frame = shade_frame_from_normal(l);
		shade_sh light = shade_sh_directional(l, shade_proof_log_range(&random, 1e-15f, 1e15f));
		float cosine = shade_proof_range(&random, -1.0f, -0.4f);
		stilb_vec3 d = l * cosine + frame.t * sqrtf(1.0f - cosine * cosine);
		SHADE_PROOF_LIGHT(shade_sh_irradiance(shade_sh_window(light, SHADE_SH_WINDOW_IRRADIANCE), d));
		SHADE_PROOF_LIGHT(shade_sh_evaluate(shade_sh_window(light, SHADE_SH_WINDOW_RADIANCE), d));
	}
}

static void endless_blur_leaves_the_mean(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 23};
	for (int k = 0; k < 1000; k++) {
		shade_sh light = random_light(&random);
		stilb_vec3 d = shade_proof_random_direction(&random);
		shade_sh flat = shade_sh_window(light, shade_proof_log_range(&random, 40.0f, 1e30f));
		SHADE_PROOF_NEAR(shade_sh_evaluate(flat, d), (double)light.c[0] / sqrt(4.0 * M_PI), 1e-6, 0.0);
	}
}

static void rotation_keeps_lengths(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 24};
	for (int k = 0; k < SHADE_PROOF_COUNT; k++) {
		shade_sh f = random_sh(&random, 1.0f), turned = shade_sh_rotate(f, random_frame(&random, k % 2));
		assert_true(turned.c[0] == f.c[0]);
		float before[3] = {0}, after[3] = {0};
		for (int i = 0; i < 9; i++) {
			before[band_of(i)] += f.c[i] * f.c[i];
			after[band_of(i)] += turned.c[i] * turned.c[i];
		}
		for (int l = 1; l < 3; l++)
			SHADE_PROOF_NEAR(after[l], before[l], 1e-5, 1e-6);
	}
}

/* Coefficients of any size and sign, each channel its own, black ones too. */
static void dominant_light_is_light(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 25};
	for (int k = 0; k < SHADE_PROOF_COUNT; k++) {
		float scale = shade_proof_log_range(&random, 1e-8f, 1e30f) * (k % 3 ? 1.0f : 1e-30f);
		shade_sh_rgb f = {random_sh(&random, scale), random_sh(&random, k % 4 == 0 ? 0.0f : 1e-3f * scale),
		                  random_sh(&random, k % 8 == 0 ? 1e30f : 0.0f)};
		shade_sh_light light = shade_sh_dominant_light(f);
		SHADE_PROOF_NEAR(stilb_vec3_dot(light.direction, light.direction), 1.0, 1e-6, 0.0);
		SHADE_PROOF_LIGHT3(light.irradiance);
		SHADE_PROOF_LIGHT3(light.ambient);
	}
}

/* The two lights that replace any surroundings keep their mean radiance: irradiance / (4 pi) + ambient. */
static void dominant_light_keeps_the_mean(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 26};
	for (int k = 0; k < SHADE_PROOF_COUNT; k++) {
		shade_sh gray = random_light(&random);
		shade_sh_rgb f = {gray, gray, gray};
		shade_sh_light light = shade_sh_dominant_light(f);
		double mean = (double)gray.c[0] / sqrt(4.0 * M_PI);
		SHADE_PROOF_NEAR((double)light.irradiance[1] / (4.0 * M_PI) + (double)light.ambient[1], mean, 2e-6, 0.0);
	}
}

static void huge_light_stays_finite(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 27};
	for (int k = 0; k < SHADE_PROOF_COUNT; k++) {
		shade_sh f = random_sh(&random, 1e30f);
		stilb_vec3 d = shade_proof_random_direction(&random);
		assert_true(isfinite(shade_sh_evaluate(f, d)));
		assert_true(isfinite(shade_sh_irradiance(f, d)));
		assert_true(isfinite(shade_sh_evaluate(shade_sh_rotate(f, shade_frame_from_normal(d)), d)));
	}
}

int main(void)
{
	const struct CMUnitTest exactness[] = {
		cmocka_unit_test(luminance_weighs_channels),
		cmocka_unit_test(basis_is_the_harmonics),
		cmocka_unit_test(coefficients_are_a_vector),
		cmocka_unit_test(ambient_is_the_same_everywhere),
		cmocka_unit_test(convolution_scales_bands),
		cmocka_unit_test(a_highlights_lobe_has_these_bands),
		cmocka_unit_test(directional_light_rings),
		cmocka_unit_test(named_windows_are_the_least),
		cmocka_unit_test(window_has_its_price),
		cmocka_unit_test(laplacian_window_costs_more),
		cmocka_unit_test(rotation_is_exact),
		cmocka_unit_test(dominant_direction_is_band_1),
		cmocka_unit_test(dominant_irradiance_is_the_least_squares),
		cmocka_unit_test(dominant_irradiance_has_its_limits),
		cmocka_unit_test(three_channels_are_three_times_one),
		cmocka_unit_test(sun_and_sky_come_back),
		cmocka_unit_test(direction_is_the_luminances),
	};
	const struct CMUnitTest properties[] = {
		cmocka_unit_test(bands_look_the_same_everywhere),
		cmocka_unit_test(windowed_light_is_not_negative),
		cmocka_unit_test(windowed_light_is_not_negative_where_it_is_darkest),
		cmocka_unit_test(endless_blur_leaves_the_mean),
		cmocka_unit_test(rotation_keeps_lengths),
		cmocka_unit_test(dominant_light_is_light),
		cmocka_unit_test(dominant_light_keeps_the_mean),
		cmocka_unit_test(huge_light_stays_finite),
	};
	return SHADE_PROOF_RUN(exactness, properties);
}
