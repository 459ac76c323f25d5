/* Series, samplers and their densities: against their formulas in double, and against each other: every sample is a
 * unit vector whose density is the density function's. test_numeric_density: many of them fill the sphere so. */

#include "shading/shade_sampling.h"

#include "support/shade_proof.h"

#include <stdio.h>

/* The samplers' arguments: exponent or sharpness n, the widths of the GGX surface, the direction to the viewer. */
typedef struct lobe {
	float n;
	shade_alphas alphas;
	stilb_vec3 v;
} lobe;

/* X(name, arguments of the sampler before u, arguments of the density before the direction, is v reflected) */
#define SAMPLERS(X)                                                                                                    \
	X(hemisphere, (u), (w), false)                                                                                     \
	X(cosine, (u), (w), false)                                                                                         \
	X(power, (on->n, u), (on->n, w), false)                                                                            \
	X(vmf, (on->n, u), (on->n, w), false)                                                                              \
	X(blinn_normal, (on->n, u), (on->n, w), false)                                                                     \
	X(ggx_normal, (on->alphas, u), (on->alphas, w), false)                                                             \
	X(ggx_visible_normal, (on->alphas, on->v, u), (on->alphas, on->v, w), false)                                       \
	X(phong, (on->n, on->v, u), (on->n, on->v, w), false)                                                              \
	X(blinn_phong, (on->n, on->v, u), (on->n, on->v, w), true)                                                         \
	X(ggx, (on->alphas, on->v, u), (on->alphas, on->v, w), true)                                                       \
	X(ggx_visible, (on->alphas, on->v, u), (on->alphas, on->v, w), true)

#define SAMPLER_FUNCTIONS(name, sampler_arguments, density_arguments, reflected)                                       \
	static shade_sample draw_##name(const lobe *on, stilb_vec2 u)                                                      \
	{                                                                                                                  \
		(void)on;                                                                                                      \
		return shade_sample_##name sampler_arguments;                                                                  \
	}                                                                                                                  \
	static float density_##name(const lobe *on, stilb_vec3 w)                                                          \
	{                                                                                                                  \
		(void)on;                                                                                                      \
		return shade_pdf_##name density_arguments;                                                                     \
	}
SAMPLERS(SAMPLER_FUNCTIONS)

static shade_sample draw_sphere(const lobe *on, stilb_vec2 u)
{
	(void)on;
	return shade_sample_sphere(u);
}

static float density_sphere(const lobe *on, stilb_vec3 w)
{
	(void)on;
	(void)w;
	return shade_pdf_sphere();
}

typedef struct sampler {
	const char *name;
	shade_sample (*draw)(const lobe *on, stilb_vec2 u);
	float (*density)(const lobe *on, stilb_vec3 w);
	bool reflected; /* the density is one of the half vector of v and the direction */
} sampler;

static const sampler samplers[] = {{"sphere", draw_sphere, density_sphere, false},
#define SAMPLER_ROW(name, sampler_arguments, density_arguments, reflected)                                             \
	{#name, draw_##name, density_##name, reflected},
                                   SAMPLERS(SAMPLER_ROW)};
enum { SAMPLER_COUNT = sizeof samplers / sizeof samplers[0] };

static stilb_vec2 random_pair(shade_proof_random *random)
{
	stilb_vec2 u = {shade_proof_uniform(random), shade_proof_uniform(random)};
	return u;
}

/* A random lobe: alpha from alpha_least on, n up to n_most, in every order of magnitude; views up to grazing ones. */
static lobe random_lobe(shade_proof_random *random, float alpha_least, float n_most)
{
	lobe on = {
		.n = shade_proof_log_range(random, 1e-3f, n_most),
		.alphas = {shade_proof_log_range(random, alpha_least, 1.0f), shade_proof_log_range(random, alpha_least, 1.0f)},
		.v = shade_proof_random_above(random, stilb_vec3_make(0.0f, 0.0f, 1.0f))};
	return on;
}

/* ---- exactness: series ------------------------------------------------------------------------------------------- */

static void series_keep_all_digits(void **state)
{
	(void)state;
	for (float x = 1e-30f; x < 80.0f; x *= 1.02f) {
		SHADE_PROOF_NEAR(shade_one_minus_exp(x), -expm1(-(double)x), 4e-7, 0.0);
		SHADE_PROOF_NEAR(shade_log1p(x), log1p((double)x), 4e-7, 0.0);
		if (x < 0.999f)
			SHADE_PROOF_NEAR(shade_log1p(-x), log1p(-(double)x), 4e-7, 0.0);
	}
	assert_true(shade_one_minus_exp(0.0f) == 0.0f && shade_log1p(0.0f) == 0.0f && shade_one_minus_exp(200.0f) == 1.0f);
}

/* ---- exactness: patterns ----------------------------------------------------------------------------------------- */

static void strata_get_one_pair_each(void **state)
{
	(void)state;
	enum { COLUMNS = 5, ROWS = 3 };
	for (int index = 0; index < COLUMNS * ROWS; index++) {
		stilb_vec2 u = {0.25f, 0.999f}, pair = shade_sample_stratified(index, COLUMNS, ROWS, u);
		SHADE_PROOF_NEAR(pair[0], (index % COLUMNS + 0.25) / COLUMNS, 1e-6, 0.0);
		SHADE_PROOF_NEAR(pair[1], (index / COLUMNS + 0.999) / ROWS, 1e-6, 0.0);
	}
	stilb_vec2 last = shade_sample_stratified(4095, 64, 64, (stilb_vec2){SHADE_UNIFORM_MAX, SHADE_UNIFORM_MAX});
	assert_true(last[0] < 1.0f && last[1] < 1.0f);
	assert_true(shade_pdf_stratified(last) == 1.0f);
	assert_true(shade_pdf_stratified((stilb_vec2){-1e-6f, 0.5f}) == 0.0f);
	assert_true(shade_pdf_stratified((stilb_vec2){0.5f, 1.0004f}) == 0.0f);
	assert_true(shade_pdf_stratified((stilb_vec2){1.0004f, 0.5f}) == 0.0f);
}

/* Shirley and Chiu's map as published: four wedges. */
static void concentric_exact(double u, double v, double p[2])
{
	double a = 2.0 * u - 1.0, b = 2.0 * v - 1.0, r, phi;
	if (a > -b && a > b) {
		r = a;
		phi = M_PI / 4.0 * b / a;
	} else if (a > -b) {
		r = b;
		phi = M_PI / 4.0 * (2.0 - a / b);
	} else if (a < b) {
		r = -a;
		phi = M_PI / 4.0 * (4.0 + b / a);
	} else {
		r = -b;
		phi = b == 0.0 ? 0.0 : M_PI / 4.0 * (6.0 - a / b);
	}
	p[0] = r * cos(phi);
	p[1] = r * sin(phi);
}

static void disk_is_concentric(void **state)
{
	(void)state;
	shade_proof_random random = {1, 0};
	for (int i = 0; i < 2000; i++) {
		stilb_vec2 u = random_pair(&random);
		double want[2];
		concentric_exact((double)u[0], (double)u[1], want);
		stilb_vec2 p = shade_sample_disk(u);
		SHADE_PROOF_NEAR(p[0], want[0], 0.0, 3e-7);
		SHADE_PROOF_NEAR(p[1], want[1], 0.0, 3e-7);
		SHADE_PROOF_NEAR(shade_pdf_disk(p * 0.999999f), 1.0 / M_PI, 1e-6, 0.0);
		shade_sample lifted = shade_sample_cosine(u);
		double z = sqrt(1.0 - want[0] * want[0] - want[1] * want[1]);
		SHADE_PROOF_NEAR3(lifted.direction, want[0], want[1], z, 0.0, 1e-6);
		SHADE_PROOF_NEAR(lifted.pdf, (double)lifted.direction[2] / M_PI, 1e-6, 0.0);
	}
	stilb_vec2 center = shade_sample_disk((stilb_vec2){0.5f, 0.5f});
	assert_true(center[0] == 0.0f && center[1] == 0.0f);
	assert_true(shade_pdf_disk((stilb_vec2){0.80016f, 0.60012f}) == 0.0f); /* radius 1.0002 */
}

/* ---- exactness: directions --------------------------------------------------------------------------------------- */

static void polar_near(shade_sample got, double z, double u1, double pdf, double relative)
{
	double sine = sqrt(fmax(1.0 - z * z, 0.0)), phi = 2.0 * M_PI * u1;
	/* Next to -Z the sine is the root of a difference of nearly equal numbers: there the bound is wider. */
	double bound = z < 0.0 ? 1e-6 / fmax(sine, 1e-3) : 1e-6;
	SHADE_PROOF_NEAR3(got.direction, sine * cos(phi), sine * sin(phi), z, 0.0, bound);
	SHADE_PROOF_NEAR(got.pdf, pdf, relative, 0.0);
}

static void directions_are_their_inverses(void **state)
{
	(void)state;
	shade_proof_random random = {2, 0};
	for (int i = 0; i < 2000; i++) {
		stilb_vec2 pair = random_pair(&random);
		double u = (double)pair[0], phi = (double)pair[1];
		float n = shade_proof_log_range(&random, 1e-3f, 2e6f);
		double k = (double)n;
		polar_near(shade_sample_sphere(pair), 1.0 - 2.0 * u, phi, 1.0 / (4.0 * M_PI), 1e-6);
		polar_near(shade_sample_hemisphere(pair), 1.0 - u, phi, 1.0 / (2.0 * M_PI), 1e-6);
		double log_z = log1p(-u) / (k + 1.0);
		polar_near(shade_sample_power(n, pair), exp(log_z), phi, (k + 1.0) / (2.0 * M_PI) * exp(k * log_z), 1e-5);
		log_z = log1p(-u) / (k + 2.0);
		polar_near(shade_sample_blinn_normal(n, pair), exp(log_z), phi,
		           (k + 2.0) / (2.0 * M_PI) * exp((k + 1.0) * log_z), 1e-5);
		double mass = -expm1(-2.0 * k), below = -log1p(-u * mass) / k;
		polar_near(shade_sample_vmf(n, pair), 1.0 - below, phi, k / (2.0 * M_PI * mass) * exp(-k * below), 1e-5);
	}
	polar_near(shade_sample_vmf(0.0f, (stilb_vec2){0.3f, 0.1f}), 1.0 - 2.0 * 0.3, 0.1, 1.0 / (4.0 * M_PI), 1e-6);
}

/* In narrow lobes the sine of the angle to the axis has the right digits; a bound on the difference of the directions
 * would not show it. */
static void narrow_lobes_keep_their_width(void **state)
{
	(void)state;
	for (float n = 1e3f; n < 1e7f; n *= 3.0f) {
		for (float u = 1e-3f; u < 1.0f; u += 0.01f) {
			stilb_vec3 power = shade_sample_power(n, (stilb_vec2){u, 0.0f}).direction;
			SHADE_PROOF_NEAR(power[0], sqrt(-expm1(2.0 * log1p(-(double)u) / ((double)n + 1.0))), 1e-6, 0.0);
			stilb_vec3 vmf = shade_sample_vmf(n, (stilb_vec2){u, 0.0f}).direction;
			double below = -log1p((double)u * expm1(-2.0 * (double)n)) / (double)n;
			SHADE_PROOF_NEAR(vmf[0], sqrt(below * (2.0 - below)), 1e-6, 0.0);
			SHADE_PROOF_NEAR(shade_pdf_power(n, power), (double)shade_sample_power(n, (stilb_vec2){u, 0.0f}).pdf, 1e-5,
			                 0.0);
			SHADE_PROOF_NEAR(shade_pdf_vmf(n, vmf), (double)shade_sample_vmf(n, (stilb_vec2){u, 0.0f}).pdf, 1e-5, 0.0);
		}
	}
}

static void densities_are_their_formulas(void **state)
{
	(void)state;
	shade_proof_random random = {3, 0};
	for (int i = 0; i < 2000; i++) {
		stilb_vec3 w = shade_proof_random_direction(&random);
		double z = (double)w[2], up = fmax(z, 0.0),
			   lost = sqrt((double)w[0] * (double)w[0] + (double)w[1] * (double)w[1]);
		float n = shade_proof_log_range(&random, 0.1f, 200.0f);
		double k = (double)n, log_up = z > 0.5 ? 0.5 * log1p(-lost * lost) : log(up);
		SHADE_PROOF_NEAR(shade_pdf_sphere(), 1.0 / (4.0 * M_PI), 1e-6, 0.0);
		SHADE_PROOF_NEAR(shade_pdf_hemisphere(w), z < 0.0 ? 0.0 : 1.0 / (2.0 * M_PI), 1e-6, 0.0);
		SHADE_PROOF_NEAR(shade_pdf_cosine(w), up / M_PI, 1e-6, 0.0);
		SHADE_PROOF_NEAR(shade_pdf_power(n, w), z < 0.0 ? 0.0 : (k + 1.0) / (2.0 * M_PI) * exp(k * log_up), 3e-5,
		                 1e-20);
		SHADE_PROOF_NEAR(shade_pdf_blinn_normal(n, w),
		                 z < 0.0 ? 0.0 : (k + 2.0) / (2.0 * M_PI) * exp((k + 1.0) * log_up), 3e-5, 1e-20);
		SHADE_PROOF_NEAR(shade_pdf_vmf(n, w), k / (-2.0 * M_PI * expm1(-2.0 * k)) * exp(k * (z - 1.0)), 1e-4, 1e-20);
		if (z > 1e-3)
			SHADE_PROOF_NEAR(shade_log_cosine(w), log_up, 1e-6, 1e-6);
	}
	stilb_vec3 grazing = stilb_vec3_make(1.0f, 0.0f, 0.0f);
	SHADE_PROOF_NEAR(shade_pdf_hemisphere(grazing), 1.0 / (2.0 * M_PI), 1e-6, 0.0);
	assert_true(isfinite(shade_log_cosine(grazing)) && isfinite(shade_log_cosine(stilb_vec3_make(0.0f, 0.8f, -0.6f))));
	assert_true(shade_pdf_power(0.0f, grazing) == 0.0f && shade_pdf_power(3.0f, grazing) == 0.0f);
	SHADE_PROOF_NEAR(shade_pdf_vmf(0.0f, grazing), 1.0 / (4.0 * M_PI), 1e-6, 0.0);
}

/* ---- exactness: microfacets -------------------------------------------------------------------------------------- */

/* D of the anisotropic GGX surface as Burley and Karis print it. */
static double ggx_exact(const lobe *on, const double h[3])
{
	double ax = (double)on->alphas.x, ay = (double)on->alphas.y;
	double q = pow(h[0] / ax, 2.0) + pow(h[1] / ay, 2.0) + h[2] * h[2];
	return 1.0 / (M_PI * ax * ay * q * q);
}

/* Smith's G1 by Lambda, Heitz (2018), eq. 2. */
static double ggx_g1_exact(const lobe *on)
{
	double x = (double)(on->alphas.x * on->v[0]), y = (double)(on->alphas.y * on->v[1]), z = (double)on->v[2];
	double lambda = 0.5 * (sqrt(1.0 + (x * x + y * y) / (z * z)) - 1.0);
	return 1.0 / (1.0 + lambda);
}

static double normalized(double h[3])
{
	double length = sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
	for (int c = 0; c < 3; c++)
		h[c] /= length;
	return length;
}

static double dot_exact(stilb_vec3 v, const double h[3])
{
	return (double)v[0] * h[0] + (double)v[1] * h[1] + (double)v[2] * h[2];
}

/* Dupuy and Benyoub's map in double. */
static void visible_normal_exact(const lobe *on, stilb_vec2 u, double h[3])
{
	double ax = (double)on->alphas.x, ay = (double)on->alphas.y;
	double view[3] = {ax * (double)on->v[0], ay * (double)on->v[1], (double)on->v[2]};
	normalized(view);
	double phi = 2.0 * M_PI * (double)u[1], z = (1.0 - (double)u[0]) * (1.0 + view[2]) - view[2];
	double sine = sqrt(fmax(1.0 - z * z, 0.0));
	h[0] = ax * (sine * cos(phi) + view[0]);
	h[1] = ay * (sine * sin(phi) + view[1]);
	h[2] = z + view[2];
	normalized(h);
}

static void ggx_is_exact(void **state)
{
	(void)state;
	shade_proof_random random = {4, 0};
	for (int i = 0; i < 3000; i++) {
		lobe on = random_lobe(&random, 0.05f, 100.0f);
		on.v[2] += 0.05f; /* not grazing, where 1 / v.h costs digits: samples_have_their_density has those */
		on.v = stilb_vec3_normalize(on.v);
		stilb_vec2 u = random_pair(&random);
		double disk[2], h[3];
		concentric_exact((double)u[0], (double)u[1], disk);
		h[0] = (double)on.alphas.x * disk[0];
		h[1] = (double)on.alphas.y * disk[1];
		h[2] = sqrt(1.0 - disk[0] * disk[0] - disk[1] * disk[1]);
		normalized(h);
		stilb_vec3 near_h = stilb_vec3_make((float)h[0], (float)h[1], (float)h[2]);
		shade_sample normal = shade_sample_ggx_normal(on.alphas, u);
		SHADE_PROOF_NEAR3(normal.direction, h[0], h[1], h[2], 0.0, 1e-6);
		SHADE_PROOF_NEAR(shade_pdf_ggx_normal(on.alphas, near_h), ggx_exact(&on, h) * h[2], 1e-5, 0.0);

		visible_normal_exact(&on, u, h);
		near_h = stilb_vec3_make((float)h[0], (float)h[1], (float)h[2]);
		double v_dot_h = dot_exact(on.v, h), seen = ggx_exact(&on, h) * ggx_g1_exact(&on) / (double)on.v[2];
		normal = shade_sample_ggx_visible_normal(on.alphas, on.v, u);
		if (u[0] < 0.99f) {
			SHADE_PROOF_NEAR3(normal.direction, h[0], h[1], h[2], 0.0, 3e-6);
			shade_sample l = shade_sample_ggx_visible(on.alphas, on.v, u);
			SHADE_PROOF_NEAR(l.pdf, seen / 4.0, 1e-4, 0.0);
			SHADE_PROOF_NEAR3(l.direction, 2.0 * v_dot_h * h[0] - (double)on.v[0],
			                  2.0 * v_dot_h * h[1] - (double)on.v[1], 2.0 * v_dot_h * h[2] - (double)on.v[2], 0.0,
			                  6e-6);
			SHADE_PROOF_NEAR(normal.pdf, seen * v_dot_h, 1e-4, 0.0);
		}
		SHADE_PROOF_NEAR(shade_ggx_visible_density(on.alphas, on.v, near_h), seen, 1e-5, 0.0);
		SHADE_PROOF_NEAR(shade_pdf_ggx_visible_normal(on.alphas, on.v, near_h), seen * v_dot_h, 1e-5, 1e-7 * seen);
	}
}

static void reflection_divides_by_four_v_dot_h(void **state)
{
	(void)state;
	stilb_vec3 any = stilb_vec3_make(0.6f, 0.0f, 0.8f);
	SHADE_PROOF_NEAR3(shade_half_vector(any, -any), 0.0, 0.0, 1.0, 0.0, 0.0);
	assert_true(shade_pdf_ggx((shade_alphas){0.01f, 0.01f}, any, -any) == 0.0f);
	assert_true(shade_pdf_blinn_phong(100.0f, any, -any) == 0.0f);
	shade_proof_random random = {5, 0};
	for (int i = 0; i < 3000; i++) {
		lobe on = random_lobe(&random, 0.1f, 50.0f);
		stilb_vec3 l = shade_proof_random_direction(&random);
		double h[3], below = (double)(on.v[2] + l[2]) < 0.0 ? -1.0 : 1.0;
		for (int c = 0; c < 3; c++)
			h[c] = below * ((double)on.v[c] + (double)l[c]);
		if (normalized(h) < 0.1)
			continue;
		double v_dot_h = fabs(dot_exact(on.v, h)), n = (double)on.n, d = ggx_exact(&on, h);
		SHADE_PROOF_NEAR3(shade_half_vector(on.v, l), h[0], h[1], h[2], 0.0, 2e-6);
		SHADE_PROOF_NEAR(shade_pdf_reflected(3.0f, -(float)v_dot_h), 0.75 / v_dot_h, 1e-6, 0.0);
		SHADE_PROOF_NEAR(shade_pdf_mirrored(3.0f, on.v, l), 0.75 / v_dot_h, 1e-4, 0.0);
		SHADE_PROOF_NEAR(shade_pdf_ggx(on.alphas, on.v, l), d * h[2] / (4.0 * v_dot_h), 1e-4, 1e-6);
		double visible = below < 0.0 ? 0.0 : d * ggx_g1_exact(&on) / (double)on.v[2] / 4.0;
		SHADE_PROOF_NEAR(shade_pdf_ggx_visible(on.alphas, on.v, l), visible, 1e-4, 1e-6);
		SHADE_PROOF_NEAR(shade_pdf_blinn_phong(on.n, on.v, l),
		                 (n + 2.0) / (2.0 * M_PI) * pow(h[2], n + 1.0) / (4.0 * v_dot_h), 1e-4, 1e-6);
		double r_dot_l =
			(double)on.v[2] * (double)l[2] - (double)on.v[0] * (double)l[0] - (double)on.v[1] * (double)l[1];
		SHADE_PROOF_NEAR(shade_pdf_phong(on.n, on.v, l),
		                 r_dot_l < 0.0 ? 0.0 : (n + 1.0) / (2.0 * M_PI) * pow(r_dot_l, n), 1e-4, 1e-6);
	}
}

/* ---- properties -------------------------------------------------------------------------------------------------- */

/* How far the density of a direction may be from the one that its sampler gives: the direction's roundings, 1e-7, as
 * seen by the lobe: wider by 1 / alpha (sqrt(n)), by 1 / cos at a cosine lobe's rim, and by 1 / v.h where the half
 * vector is the difference of long vectors. */
static double density_tolerance(const sampler *s, const lobe *on, stilb_vec2 u, stilb_vec3 direction)
{
	double narrow = sqrt((double)on->n) + 1.0 / (double)fminf(on->alphas.x, on->alphas.y);
	double cosine = pow(1.0 - (double)u[0], 1.0 / ((double)on->n + 1.0));
	stilb_vec3 h = on->v + direction;
	double v_dot_h = 0.5 * sqrt((double)stilb_vec3_dot(h, h));
	double lobe_tolerance = 3e-6 * narrow + 1e-6 * (double)on->n * (1.0 / cosine - 1.0);
	return 2e-5 + lobe_tolerance / (s->reflected ? fmax(v_dot_h, 1e-9) : 1.0);
}

static void check_sample(const sampler *s, const lobe *on, stilb_vec2 u)
{
	shade_sample got = s->draw(on, u);
	double length2 = (double)stilb_vec3_dot(got.direction, got.direction);
	float density = s->density(on, got.direction);
	if (!(fabs(length2 - 1.0) < 2e-6))
		fail_msg("%s: a direction of length %g for u %.8g %.8g", s->name, sqrt(length2), (double)u[0], (double)u[1]);
	if (!(got.pdf > 0.0f && got.pdf < INFINITY && density >= 0.0f && density < INFINITY))
		fail_msg("%s: density %g, %g by the sampler", s->name, (double)density, (double)got.pdf);
	double tolerance = density_tolerance(s, on, u, got.direction);
	if (tolerance < 0.1 && !(fabs((double)density / (double)got.pdf - 1.0) < tolerance))
		fail_msg("%s: density %.8g, %.8g by the sampler: n %g, alpha %g %g, v %g %g %g, u %.8g %.8g", s->name,
		         (double)density, (double)got.pdf, (double)on->n, (double)on->alphas.x, (double)on->alphas.y,
		         (double)on->v[0], (double)on->v[1], (double)on->v[2], (double)u[0], (double)u[1]);
}

static void samples_have_their_density(void **state)
{
	(void)state;
	for (int k = 0; k < SAMPLER_COUNT; k++) {
		shade_proof_random random = {10 + (uint64_t)k, 0};
		for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
			lobe on = random_lobe(&random, 1e-3f, 2e6f);
			check_sample(&samplers[k], &on, random_pair(&random));
		}
	}
}

/* All combinations of the ends of the arguments' ranges: no NaN, no infinity, unit vectors. */
static void samples_survive_the_ends(void **state)
{
	(void)state;
	static const float ends[] = {0.0f, 1e-38f, 5e-8f, 0.25f, 0.5f, 0.9999999f, SHADE_UNIFORM_MAX};
	static const float exponents[] = {0.0f, 1e-20f, 1.0f, 1e7f}, alphas[] = {1e-3f, 1.0f};
	const stilb_vec3 views[] = {{0.0f, 0.0f, 1.0f, 0.0f}, {1.0f, 0.0f, 0.0f, 0.0f}, {0.6f, -0.8f, 1e-20f, 0.0f}};
	for (int k = 0; k < SAMPLER_COUNT; k++)
		for (int i = 0; i < 49 * 4 * 3 * 4; i++) {
			lobe on = {.n = exponents[i / 49 % 4],
			           .v = views[i / 49 / 4 % 3],
			           .alphas = {alphas[i / 49 / 12 % 2], alphas[i / 49 / 24]}};
			stilb_vec2 u = {ends[i % 7], ends[i / 7 % 7]};
			shade_sample got = samplers[k].draw(&on, u);
			stilb_vec3 opposite = -on.v;
			SHADE_PROOF_NEAR(stilb_vec3_dot(got.direction, got.direction), 1.0, 0.0, 2e-6);
			assert_true(got.pdf > 0.0f && got.pdf < INFINITY);
			SHADE_PROOF_LIGHT(samplers[k].density(&on, got.direction));
			SHADE_PROOF_LIGHT(samplers[k].density(&on, on.v));
			SHADE_PROOF_LIGHT(samplers[k].density(&on, opposite));
		}
}

static void disk_points_lie_in_it(void **state)
{
	(void)state;
	enum { SIDE = 1000, CELLS = SIDE * SIDE }; /* one point in each cell */
	shade_proof_random random = {6, 0};
	double sum[3] = {0.0, 0.0, 0.0};
	for (int i = 0; i < CELLS; i++) {
		stilb_vec2 p = shade_sample_disk(shade_sample_stratified(i, SIDE, SIDE, random_pair(&random)));
		double r2 = (double)p[0] * (double)p[0] + (double)p[1] * (double)p[1];
		assert_true(r2 <= 1.0 + 2e-7);
		sum[0] += (double)p[0];
		sum[1] += (double)p[1];
		sum[2] += r2;
	}
	SHADE_PROOF_NEAR(sum[0] / CELLS, 0.0, 0.0, 1e-5); /* with free pairs: 1e-3 */
	SHADE_PROOF_NEAR(sum[1] / CELLS, 0.0, 0.0, 1e-5);
	SHADE_PROOF_NEAR(sum[2] / CELLS, 0.5, 0.0, 1e-5);
}

/* At a grazing view, fewer reflections by visible normals end below the horizon, where they are lost, than by normals
 * that are drawn from D alone. */
static void visible_normals_waste_less(void **state)
{
	(void)state;
	lobe on = {.alphas = {0.5f, 0.5f}, .v = stilb_vec3_normalize(stilb_vec3_make(1.0f, 0.0f, 0.1f))};
	shade_proof_random random = {7, 0};
	int all = 0, visible = 0;
	for (int i = 0; i < 100000; i++) {
		stilb_vec2 u = random_pair(&random);
		all += shade_sample_ggx(on.alphas, on.v, u).direction[2] < 0.0f;
		visible += shade_sample_ggx_visible(on.alphas, on.v, u).direction[2] < 0.0f;
	}
	printf("below the horizon at a grazing view: %.1f %% of all normals' reflections, %.1f %% of the visible ones'\n",
	       all / 1000.0, visible / 1000.0);
	assert_true(visible < all);
}

int main(void)
{
	const struct CMUnitTest exactness[] = {
		cmocka_unit_test(series_keep_all_digits),
		cmocka_unit_test(strata_get_one_pair_each),
		cmocka_unit_test(disk_is_concentric),
		cmocka_unit_test(directions_are_their_inverses),
		cmocka_unit_test(narrow_lobes_keep_their_width),
		cmocka_unit_test(densities_are_their_formulas),
		cmocka_unit_test(ggx_is_exact),
		cmocka_unit_test(reflection_divides_by_four_v_dot_h),
	};
	const struct CMUnitTest properties[] = {
		cmocka_unit_test(samples_have_their_density),
		cmocka_unit_test(samples_survive_the_ends),
		cmocka_unit_test(disk_points_lie_in_it),
		cmocka_unit_test(visible_normals_waste_less),
	};
	return SHADE_PROOF_RUN(exactness, properties);
}
