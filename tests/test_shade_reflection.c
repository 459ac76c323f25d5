/* Reflection by quadrature and closed form: Lambert, the two-colour sky, Blinn-Phong's factor, energy, the whole surface. */

#include "shading/shade_blinn_phong.h"
#include "shading/shade_diffuse.h"
#include "shading/shade_energy.h"
#include "shading/shade_surface.h"

#include "base/base.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

static void near(const char *what, double got, double want, double bound)
{
	if (!(fabs(got - want) <= bound))
		fail_msg("%s: got %.9g, expected %.9g within %g", what, got, want, bound);
}

static double direction_component(double theta, double phi, int axis)
{
	return axis == 1 ? cos(theta) : sin(theta) * (axis == 0 ? cos(phi) : sin(phi));
}

/* Integral over the hemisphere about +Y of f dw, by midpoints. f gets the direction and context. */
typedef double hemisphere_function(stilb_vec3 direction, const void *context);

static double hemisphere_integral(hemisphere_function *f, const void *context, int steps)
{
	double sum = 0.0;
	for (int i = 0; i < steps; i++) {
		double theta = (i + 0.5) / steps * M_PI / 2.0;
		for (int j = 0; j < steps; j++) {
			double phi = (j + 0.5) / steps * 2.0 * M_PI;
			stilb_vec3 w =
				stilb_vec3_make((float)direction_component(theta, phi, 0), (float)direction_component(theta, phi, 1),
			                    (float)direction_component(theta, phi, 2));
			sum += f(w, context) * sin(theta);
		}
	}
	return sum * (M_PI / 2.0 / steps) * (2.0 * M_PI / steps);
}

/* ---- Lambert and the sky ----------------------------------------------------------------------------------------- */

static double lambert_rdf(stilb_vec3 w, const void *context)
{
	return (double)shade_lambert(*(const stilb_vec3 *)context)[1] * (double)w[1];
}

static void lambert_reflects_its_share(void **state)
{
	(void)state;
	stilb_vec3 diffuse = stilb_vec3_make(0.2f, 0.7f, 1.0f);
	near("albedo", hemisphere_integral(lambert_rdf, &diffuse, 200), 0.7, 1e-4);
	stilb_vec3 brdf = shade_lambert(diffuse);
	near("red", (double)brdf[0], 0.2 / M_PI, 1e-8);
	near("blue", (double)brdf[2], 1.0 / M_PI, 3e-8);
}

typedef struct sky_case {
	stilb_vec3 normal;
	double sky, ground;
} sky_case;

/* Both halves of the sphere at once: direction w above, and its mirror image below. */
static double sky_cosine(stilb_vec3 w, const void *context)
{
	const sky_case *c = context;
	stilb_vec3 below = stilb_vec3_make(w[0], -w[1], w[2]);
	double up = (double)stilb_vec3_dot(c->normal, w), down = (double)stilb_vec3_dot(c->normal, below);
	return c->sky * fmax(up, 0.0) + c->ground * fmax(down, 0.0);
}

static void sky_irradiance_is_exact(void **state)
{
	(void)state;
	stilb_vec3 sky = stilb_vec3_make(2.0f, 0.3f, 0.0f), ground = stilb_vec3_make(0.5f, 0.9f, 1.0f);
	for (int step = 0; step <= 8; step++) {
		double angle = step * M_PI / 8.0;
		stilb_vec3 normal = stilb_vec3_make((float)sin(angle), (float)cos(angle), 0.0f);
		stilb_vec3 irradiance = shade_hemisphere_irradiance(normal[1], sky, ground);
		for (int channel = 0; channel < 3; channel++) {
			sky_case c = {normal, (double)sky[channel], (double)ground[channel]};
			near("sky", (double)irradiance[channel], hemisphere_integral(sky_cosine, &c, 300), 2e-4);
		}
	}
	near("up sees the sky", (double)shade_hemisphere_irradiance(1.0f, sky, ground)[0], 2.0 * M_PI, 1e-6);
	near("down sees the ground", (double)shade_hemisphere_irradiance(-1.0f, sky, ground)[0], 0.5 * M_PI, 1e-6);
}

/* ---- Blinn-Phong ----------------------------------------------------------------------------------------------------- */

/* Integral of the RDF, light and normal aligned: n.h = cos(theta / 2). Simpson's rule in double around the float
 * function. */
static double albedo_at_normal_incidence(float n)
{
	enum { STEPS = 20000 };
	double sum = 0.0;
	for (int i = 0; i <= STEPS; i++) {
		double theta = i * M_PI / 2.0 / STEPS;
		double rdf = (double)shade_blinn_phong_modified((float)cos(theta / 2.0), n) * cos(theta);
		sum += rdf * sin(theta) * (i == 0 || i == STEPS ? 1.0 : i % 2 ? 4.0 : 2.0);
	}
	return 2.0 * M_PI * sum * (M_PI / 2.0 / STEPS) / 3.0;
}

static void blinn_phong_albedo_is_one(void **state)
{
	(void)state;
	static const float exponents[] = {1e-3f, 0.5f, 1.0f, 10.0f, 100.0f, 1000.0f, 8192.0f};
	for (size_t i = 0; i < sizeof exponents / sizeof exponents[0]; i++)
		near("albedo", albedo_at_normal_incidence(exponents[i]), 1.0, 1e-4);
}

static void blinn_phong_factor_keeps_its_bounds(void **state)
{
	(void)state;
	for (double n = 0.1; n < 3000.0; n *= 1.1) {
		double factor = (double)shade_blinn_phong_modified_factor((float)n);
		assert_true(factor > (n + 6.0) / (8.0 * M_PI));
		assert_true(factor < (n + 8.0) / (8.0 * M_PI));
		double exact = (n + 2.0) * (n + 4.0) / (8.0 * M_PI * (exp2(-n / 2.0) + n));
		near("factor", factor / exact, 1.0, 1e-6);
	}
	near("Lambert", (double)shade_blinn_phong_modified_factor(0.0f), 1.0 / M_PI, 1e-7);
}

typedef struct lobe_case {
	stilb_vec3 light;
	float exponent;
} lobe_case;

static double lobe_rdf(stilb_vec3 w, const void *context)
{
	const lobe_case *c = context;
	stilb_vec3 up = stilb_vec3_make(0.0f, 1.0f, 0.0f);
	return (double)shade_blinn_phong_modified(shade_n_dot_h(up, c->light, w), c->exponent) * (double)w[1];
}

/* The factor is made for normal incidence; from anywhere else less is reflected, never more. */
static void blinn_phong_never_gains_energy(void **state)
{
	(void)state;
	static const float exponents[] = {0.5f, 1.0f, 4.0f, 30.0f, 200.0f};
	for (size_t i = 0; i < sizeof exponents / sizeof exponents[0]; i++) {
		double last = 1.0 + 1e-3;
		for (int step = 0; step <= 8; step++) {
			double angle = step * 88.0 / 8.0 * M_PI / 180.0;
			lobe_case c = {stilb_vec3_make((float)sin(angle), (float)cos(angle), 0.0f), exponents[i]};
			double albedo = hemisphere_integral(lobe_rdf, &c, 240);
			assert_true(albedo < last);
			last = albedo;
		}
		assert_true(last < 0.8);
	}
}

static void blinn_phong_outside_its_lobe(void **state)
{
	(void)state;
	assert_true(shade_blinn_phong_modified(-0.5f, 3.0f) == 0.0f);
	assert_true(shade_blinn_phong_modified(0.0f, 3.0f) == 0.0f);
	assert_true(shade_blinn_phong_modified(1.0000002f, 8192.0f) == shade_blinn_phong_modified_factor(8192.0f));
}

/* ---- energy ------------------------------------------------------------------------------------------------------------ */

static stilb_vec3 random_vec3(uint64_t seed, uint64_t index, float low, float high)
{
	float v[3];
	for (uint64_t k = 0; k < 3; k++)
		v[k] = low + (high - low) * stilb_random_float(seed, index * 3 + k);
	return stilb_vec3_make(v[0], v[1], v[2]);
}

static void limited_channel(float d, float s, float got_d, float got_s)
{
	assert_true(got_d >= 0.0f && got_s >= 0.0f);
	float sum = got_d + got_s;
	if (!(sum <= 1.0f))
		fail_msg("%.9g and %.9g became %.9g and %.9g", (double)d, (double)s, (double)got_d, (double)got_s);
	double total = (double)fmaxf(d, 0.0f) + (double)fmaxf(s, 0.0f);
	double scale = total > 1.0 ? 1.0 / total : 1.0;
	near("diffuse", (double)got_d, (double)fmaxf(d, 0.0f) * scale, 1.5e-7);
	near("specular", (double)got_s, (double)fmaxf(s, 0.0f) * scale, 1.5e-7);
}

static void materials_are_limited_to_one(void **state)
{
	(void)state;
	for (uint64_t i = 0; i < 200000; i++) {
		float high = i % 3 == 0 ? 1.0f : i % 3 == 1 ? 4.0f : 1e6f;
		stilb_vec3 diffuse = random_vec3(1, i, -0.2f * high, high), specular = random_vec3(2, i, -0.2f * high, high);
		shade_reflectance limited = shade_limit_to_one(diffuse, specular);
		for (int channel = 0; channel < 3; channel++)
			limited_channel(diffuse[channel], specular[channel], limited.diffuse[channel], limited.specular[channel]);
	}
	stilb_vec3 huge = stilb_vec3_make(3e38f, 3e38f, 1.0f), tiny = stilb_vec3_make(3e38f, 1e-30f, 1.0f);
	shade_reflectance limited = shade_limit_to_one(huge, tiny);
	for (int channel = 0; channel < 3; channel++)
		assert_true(limited.diffuse[channel] + limited.specular[channel] <= 1.0f);
}

static void good_materials_stay(void **state)
{
	(void)state;
	stilb_vec3 diffuse = stilb_vec3_make(0.5f, 0.0f, 1.0f), specular = stilb_vec3_make(0.25f, 1.0f, 0.0f);
	shade_reflectance kept = shade_limit_to_one(diffuse, specular);
	for (int channel = 0; channel < 3; channel++) {
		assert_true(kept.diffuse[channel] == diffuse[channel]);
		assert_true(kept.specular[channel] == specular[channel]);
	}
}

/* ---- the surface --------------------------------------------------------------------------------------------------------- */

static const shade_sky DARK = {{0}, {0}};

/* Sun at angle a from the normal, mirror reflection into the eye: h = n, so the highlight is the factor itself. */
static void surface_has_its_closed_form(void **state)
{
	(void)state;
	shade_material material = {{0.5f, 0.2f, 0.0f}, {0.1f, 0.3f, 0.6f}, 50.0f};
	stilb_vec3 n = {0.0f, 1.0f, 0.0f};
	double a = 0.6, factor = 52.0 * 54.0 / (8.0 * M_PI * (exp2(-25.0) + 50.0));
	shade_sun sun = {{(float)sin(a), (float)cos(a), 0.0f}, {3.0f, 2.0f, 1.0f}};
	stilb_vec3 v = {-(float)sin(a), (float)cos(a), 0.0f};
	shade_sky sky = {{0.2f, 0.3f, 0.4f}, {9.0f, 9.0f, 9.0f}};
	stilb_vec3 radiance = shade_surface_radiance(material, sun, sky, n, v);
	for (int channel = 0; channel < 3; channel++) {
		double diffuse = (double)material.diffuse[channel], specular = (double)material.specular[channel];
		double brdf = diffuse / M_PI + specular * factor;
		double want = brdf * (double)sun.irradiance[channel] * cos(a) + diffuse * (double)sky.sky[channel];
		near("radiance", (double)radiance[channel], want, 2e-6);
	}
}

static void surface_turned_away_sees_only_the_sky(void **state)
{
	(void)state;
	shade_material material = {{0.5f, 0.5f, 0.5f}, {0.5f, 0.5f, 0.5f}, 10.0f};
	shade_sun sun = {{0.0f, -1.0f, 0.0f}, {5.0f, 5.0f, 5.0f}};
	stilb_vec3 n = {0.0f, 1.0f, 0.0f};
	stilb_vec3 v = {0.0f, 1.0f, 0.0f}; /* l = -v: there is no half vector, and nothing becomes NaN */
	stilb_vec3 radiance = shade_surface_radiance(material, sun, DARK, n, v);
	for (int channel = 0; channel < 3; channel++)
		assert_true(radiance[channel] == 0.0f);
	assert_true(shade_n_dot_h(n, sun.direction, v) == 0.0f);
	shade_sky sky = {{1.0f, 1.0f, 1.0f}, {0}};
	near("white furnace's upper half", (double)shade_surface_radiance(material, sun, sky, n, v)[0], 0.5, 1e-6);
}

typedef struct surface_case {
	shade_material material;
	shade_sun sun;
} surface_case;

static double surface_cosine(stilb_vec3 v, const void *context)
{
	const surface_case *c = context;
	stilb_vec3 n = {0.0f, 1.0f, 0.0f};
	return (double)shade_surface_radiance(c->material, c->sun, DARK, n, v)[0] * (double)v[1];
}

/* All that leaves (radiosity) against all that comes in (irradiance times the cosine): random limited materials. */
static void surface_gives_back_no_more_than_it_gets(void **state)
{
	(void)state;
	for (uint64_t i = 0; i < 40; i++) {
		shade_reflectance share = shade_limit_to_one(random_vec3(7, i, 0.0f, 2.0f), random_vec3(8, i, 0.0f, 2.0f));
		float angle = stilb_random_float(9, i) * 1.5f;
		surface_case c = {{share.diffuse, share.specular, exp2f(7.0f * stilb_random_float(10, i))},
		                  {{sinf(angle), cosf(angle), 0.0f}, {4.0f, 4.0f, 4.0f}}};
		double leaves = hemisphere_integral(surface_cosine, &c, 120), comes = 4.0 * (double)cosf(angle);
		if (!(leaves <= comes * 1.001))
			fail_msg("%g leaves of %g", leaves, comes);
		assert_true(leaves >= comes * (double)share.diffuse[0] * 0.999);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(lambert_reflects_its_share),
		cmocka_unit_test(sky_irradiance_is_exact),
		cmocka_unit_test(blinn_phong_albedo_is_one),
		cmocka_unit_test(blinn_phong_factor_keeps_its_bounds),
		cmocka_unit_test(blinn_phong_never_gains_energy),
		cmocka_unit_test(blinn_phong_outside_its_lobe),
		cmocka_unit_test(materials_are_limited_to_one),
		cmocka_unit_test(good_materials_stay),
		cmocka_unit_test(surface_has_its_closed_form),
		cmocka_unit_test(surface_turned_away_sees_only_the_sky),
		cmocka_unit_test(surface_gives_back_no_more_than_it_gets),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
