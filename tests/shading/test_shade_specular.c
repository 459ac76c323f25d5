/* shade_specular.h and shade_minimalist.h: the terms D, G and F of microfacet models against Karis's formulas, as
 * printed, in double; the integrals that are 1 by numerical integration. */

#include "shading/shade_minimalist.h"
#include "shading/shade_specular.h"

#include "numeric/numeric_quadrature.h"
#include "support/shade_proof.h"
#include "support/shade_reference.h"

static const double alphas[] = {1e-3, 0.01, 0.1, 0.3, 0.6, 0.9, 1.0};
#define ALPHA_COUNT (sizeof alphas / sizeof alphas[0])

/* ---- exactness: D ----------------------------------------------------------------------------------------------- */

/* D at tilts of the facet from 0 to many times its width alpha: tan = s alpha, so sin^2 = (s alpha)^2 / (1 + (s
 * alpha)^2), s = 0, 0.3, ... */
static void distributions_have_their_formulas(void **state)
{
	(void)state;
	for (size_t i = 0; i < ALPHA_COUNT; i++)
		for (double s = 0.0; s < 4.0; s += 0.3) {
			double alpha = (double)(float)alphas[i], tan2 = s * alpha * s * alpha;
			float sin2 = (float)(tan2 / (1.0 + tan2)), a = (float)alpha;
			SHADE_PROOF_NEAR(shade_d_blinn(sin2, a), reference_blinn_d((double)sin2, alpha), 2e-5, 1e-6);
			SHADE_PROOF_NEAR(shade_d_beckmann(sin2, a), reference_beckmann_d((double)sin2, alpha), 2e-5, 1e-6);
			SHADE_PROOF_NEAR(shade_d_ggx(sin2, a), reference_ggx_d((double)sin2, alpha), 2e-6, 0.0);
			assert_true(shade_d(SHADE_NDF_BLINN, sin2, a) == shade_d_blinn(sin2, a));
			assert_true(shade_d(SHADE_NDF_BECKMANN, sin2, a) == shade_d_beckmann(sin2, a));
			assert_true(shade_d(SHADE_NDF_GGX, sin2, a) == shade_d_ggx(sin2, a));
			assert_true(shade_d(SHADE_NDF_GGX_ANISOTROPIC, sin2, a) == shade_d_ggx(sin2, a));
		}
}

static void anisotropic_ggx_has_its_formula(void **state)
{
	(void)state;
	for (size_t i = 0; i < ALPHA_COUNT; i++)
		for (double phi = 0.0; phi < 3.0; phi += 0.5) {
			double ax = (double)(float)alphas[i], ay = (double)(float)(0.37 * ax + 1e-3), s = 0.8 * ax;
			float x = (float)(s * cos(phi)), y = (float)(s * sin(phi));
			SHADE_PROOF_NEAR(shade_d_ggx_anisotropic(x, y, (float)ax, (float)ay),
			                 reference_ggx_anisotropic_d((double)x, (double)y, ax, ay), 3e-6, 0.0);
			SHADE_PROOF_NEAR(shade_d_ggx_anisotropic(x, y, (float)ax, (float)ax),
			                 reference_ggx_d((double)x * (double)x + (double)y * (double)y, ax), 3e-6, 0.0);
		}
}

static void widths_follow_roughness_and_anisotropy(void **state)
{
	(void)state;
	SHADE_PROOF_NEAR(shade_alpha_from_roughness(0.6f), 0.36, 1e-6, 0.0);
	assert_true(shade_alpha_from_roughness(0.0f) == SHADE_ALPHA_MIN);
	shade_alphas wide = shade_alphas_from_anisotropy(0.4f, 0.5f), narrow = shade_alphas_from_anisotropy(0.4f, -0.5f);
	SHADE_PROOF_NEAR(wide.x, 0.6, 1e-6, 0.0);
	SHADE_PROOF_NEAR(wide.y, 0.2, 1e-6, 0.0);
	assert_true(narrow.x == wide.y && narrow.y == wide.x);
	assert_true(shade_alphas_from_anisotropy(0.4f, 1.0f).y == SHADE_ALPHA_MIN);
	assert_true(shade_alphas_from_anisotropy(0.4f, -1.0f).x == SHADE_ALPHA_MIN);
	/* Along the tangents, between them, and along the normal. */
	SHADE_PROOF_NEAR(shade_alpha_along(wide, stilb_vec3_make(0.5f, 0.0f, 0.8660254f)), 0.6, 1e-6, 0.0);
	SHADE_PROOF_NEAR(shade_alpha_along(wide, stilb_vec3_make(0.0f, -0.5f, 0.8660254f)), 0.2, 1e-6, 0.0);
	SHADE_PROOF_NEAR(shade_alpha_along(wide, stilb_vec3_make(0.3f, 0.4f, 0.8660254f)), sqrt(0.36 * 0.36 + 0.64 * 0.04),
	                 1e-6, 0.0);
	SHADE_PROOF_NEAR(shade_alpha_along(wide, stilb_vec3_make(0.0f, 0.0f, 1.0f)), sqrt(0.2), 1e-6, 0.0);
}

/* ---- exactness: angles, V and F --------------------------------------------------------------------------------- */

static void angles_are_those_of_the_vectors(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 41};
	for (int i = 0; i < 2000; i++) {
		stilb_vec3 n = shade_proof_random_direction(&random), l = shade_proof_random_above(&random, n);
		stilb_vec3 v = shade_proof_random_above(&random, n);
		if (i % 2)
			/* v is nearly l mirrored, so the half vector is next to n. */
			v = stilb_vec3_normalize(2.0f * stilb_vec3_dot(n, l) * n - l + v * 1e-3f);
		double nl = 0.0, nv = 0.0, h2 = 0.0, vh = 0.0, cross2 = 0.0, h[3];
		for (int k = 0; k < 3; k++) {
			h[k] = (double)l[k] + (double)v[k];
			nl += (double)n[k] * (double)l[k];
			nv += (double)n[k] * (double)v[k];
			h2 += h[k] * h[k];
			vh += (double)v[k] * h[k];
		}
		for (int k = 0; k < 3; k++) {
			int p = (k + 1) % 3, q = (k + 2) % 3;
			double c = (double)n[p] * h[q] - (double)n[q] * h[p];
			cross2 += c * c;
		}
		if (h2 < 1e-3)
			continue;
		shade_angles a = shade_angles_of(n, l, v);
		SHADE_PROOF_NEAR(a.n_dot_l, nl, 0.0, 3e-7);
		SHADE_PROOF_NEAR(a.n_dot_v, nv, 0.0, 3e-7);
		SHADE_PROOF_NEAR(a.n_dot_h, (nl + nv) / sqrt(h2), 1e-6, 1e-5);
		SHADE_PROOF_NEAR(a.v_dot_h, vh / sqrt(h2), 1e-6, 3e-7 / sqrt(h2)); /* 3e-7: float vectors are unit to 1e-7 */
		SHADE_PROOF_NEAR(sqrtf(a.sin2_h), sqrt(cross2 / h2), 1e-5, 1e-6);
	}
	stilb_vec3 n = {0.0f, 0.0f, 1.0f}, l = {0.6f, 0.0f, 0.8f};
	shade_angles opposite = shade_angles_of(n, l, -l), same = shade_angles_of(n, n, n);
	assert_true(opposite.n_dot_h == 0.0f && opposite.v_dot_h == SHADE_COSINE_EPSILON && opposite.sin2_h == 0.0f);
	assert_true(same.n_dot_h == 1.0f && same.v_dot_h == 1.0f && same.sin2_h == 0.0f);
}

/* All eight shadowing terms, at angles on both sides of c = 1.6, where Beckmann's fit ends, and in the three cases of
 * Cook-Torrance's minimum. */
static void shadowing_has_its_formulas(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 42};
	for (int i = 0; i < 4000; i++) {
		float nl = shade_proof_range(&random, 0.02f, 1.0f), nv = shade_proof_range(&random, 0.02f, 1.0f);
		float nh = shade_proof_range(&random, 0.05f, 1.0f), vh = shade_proof_range(&random, 0.05f, 1.0f);
		float al = shade_proof_range(&random, 0.02f, 1.0f), av = shade_proof_range(&random, 0.02f, 1.0f);
		shade_angles a = {nl, nv, nh, vh, 0.0f};
		double l = (double)nl, v = (double)nv;
		for (int g = 0; g < SHADE_G_COUNT; g++) {
			double want = reference_g_of(g, l, v, (double)nh, (double)vh, (double)al, (double)av);
			SHADE_PROOF_NEAR(shade_v(g, a, al, av), want / (4.0 * l * v), 1e-5, 0.0);
			SHADE_PROOF_NEAR(shade_g(g, a, al, av), want, 1e-5, 0.0);
		}
	}
}

/* The rational fit of Beckmann's G1 ends at c = 1.6 and not 0.1 % beside it: at the end it is 1.0000556, and 1 from
 * there on, a step just large enough to be seen. */
static void beckmann_fit_ends_where_it_should(void **state)
{
	(void)state;
	for (double c = 1.59; c < 1.61; c += 0.0003) {
		double alpha = 0.4, tangent = 1.0 / (c * alpha), nx = 1.0 / sqrt(1.0 + tangent * tangent);
		if (fabs(c - 1.6) < 1e-5)
			continue;
		SHADE_PROOF_NEAR(2.0f * (float)nx * shade_v1_smith_beckmann((float)nx, 0.4f), reference_beckmann_g1(nx, alpha),
		                 5e-6, 0.0);
	}
}

static void fused_ggx_is_its_parts(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 43};
	for (int i = 0; i < 1000; i++) {
		float nl = shade_proof_uniform(&random), nv = shade_proof_uniform(&random), s = shade_proof_uniform(&random);
		float alpha = shade_proof_log_range(&random, 1e-3f, 1.0f);
		double l = (double)nl, v = (double)nv, a = (double)alpha;
		double roots = (l + sqrt(a * a + (1.0 - a * a) * l * l)) * (v + sqrt(a * a + (1.0 - a * a) * v * v));
		SHADE_PROOF_NEAR(shade_dv_ggx(s, nl, nv, alpha), reference_ggx_d((double)s, a) / roots, 3e-6, 0.0);
		SHADE_PROOF_NEAR(shade_v1_smith_ggx(nl, alpha) * shade_v1_smith_ggx(nv, alpha), 1.0 / roots, 2e-6, 0.0);
	}
}

static void fresnel_has_its_formulas(void **state)
{
	(void)state;
	for (double f0 = 0.0; f0 < 0.999; f0 += 0.0499)
		for (double c = 0.02; c <= 1.0; c += 0.049) {
			float r = (float)f0, x = (float)c;
			stilb_vec3 color = {r, 0.25f, 0.81f};
			SHADE_PROOF_NEAR3(shade_f_schlick(color, x), reference_schlick_f((double)r, (double)x),
			                  reference_schlick_f(0.25, (double)x), reference_schlick_f((double)0.81f, (double)x), 2e-6,
			                  1e-7);
			SHADE_PROOF_NEAR3(shade_f_cook_torrance(color, x), reference_cook_torrance_f((double)r, (double)x),
			                  reference_cook_torrance_f(0.25, (double)x),
			                  reference_cook_torrance_f((double)0.81f, (double)x), 5e-6, 1e-6);
			assert_true(shade_f_schlick_1(r, x) == shade_f_schlick(color, x)[0]);
			assert_true(shade_f(SHADE_F_NONE, color, x)[2] == color[2]);
			assert_true(shade_f(SHADE_F_SCHLICK, color, x)[0] == shade_f_schlick(color, x)[0]);
			assert_true(shade_f(SHADE_F_COOK_TORRANCE, color, x)[0] == shade_f_cook_torrance(color, x)[0]);
		}
}

/* Terms at cosines of 0, and at those a little above 1 that rounding makes: finite, and not negative. */
static void terms_are_light_at_the_ends(void **state)
{
	(void)state;
	for (float alpha = SHADE_ALPHA_MIN; alpha <= 1.0f; alpha *= 2.0f) {
		SHADE_PROOF_LIGHT(shade_v_neumann(0.0f, 0.0f));
		SHADE_PROOF_LIGHT(shade_v_cook_torrance(0.0f, 0.0f, 0.0f, 1.0f));
		SHADE_PROOF_LIGHT(shade_v_cook_torrance(0.0f, 1.0f, 0.7f, 0.7f));
		SHADE_PROOF_LIGHT(shade_v_kelemen(0.0f));
		SHADE_PROOF_LIGHT(shade_minimalist_fv(0.0f));
		SHADE_PROOF_LIGHT(shade_v1_smith_beckmann(0.0f, alpha));
		SHADE_PROOF_NEAR(shade_v1_smith_beckmann(1.0000001f, alpha), 0.5, 1e-6, 0.0);
		SHADE_PROOF_NEAR(shade_v1_smith_ggx(0.0f, alpha), 1.0 / (double)alpha, 1e-6, 0.0);
		SHADE_PROOF_LIGHT(shade_d_beckmann(1.0f, alpha));
		SHADE_PROOF_LIGHT(shade_d_blinn(1.0000001f, alpha));
		SHADE_PROOF_LIGHT(shade_d_ggx(1.0000001f, alpha));
	}
}

static void minimalist_has_its_formula(void **state)
{
	(void)state;
	for (double c = 0.05; c <= 1.0; c += 0.05) {
		float x = (float)c;
		double lh = (double)x, power = pow(0.8, 3.5);
		stilb_vec3 f0 = {0.02f, 0.05f, 0.8f};
		SHADE_PROOF_NEAR(shade_minimalist_d(0.2f, 7.0f), 8.0 / (2.0 * M_PI) * power, 2e-6, 0.0);
		SHADE_PROOF_NEAR(shade_minimalist_fv(x), 0.25 / (lh * lh * lh), 2e-6, 0.0);
		SHADE_PROOF_NEAR(shade_minimalist(0.2f, x, 7.0f), 8.0 * power / (8.0 * M_PI * lh * lh * lh), 2e-6, 0.0);
		SHADE_PROOF_NEAR3(shade_schlick_kelemen_fv(f0, x), reference_schlick_f((double)0.02f, lh) / (4.0 * lh * lh),
		                  reference_schlick_f((double)0.05f, lh) / (4.0 * lh * lh),
		                  reference_schlick_f((double)0.8f, lh) / (4.0 * lh * lh), 3e-6, 0.0);
	}
}

static const struct CMUnitTest exactness[] = {
	cmocka_unit_test(distributions_have_their_formulas),
	cmocka_unit_test(anisotropic_ggx_has_its_formula),
	cmocka_unit_test(widths_follow_roughness_and_anisotropy),
	cmocka_unit_test(angles_are_those_of_the_vectors),
	cmocka_unit_test(shadowing_has_its_formulas),
	cmocka_unit_test(beckmann_fit_ends_where_it_should),
	cmocka_unit_test(fused_ggx_is_its_parts),
	cmocka_unit_test(fresnel_has_its_formulas),
	cmocka_unit_test(terms_are_light_at_the_ends),
	cmocka_unit_test(minimalist_has_its_formula),
};

/* ---- properties ------------------------------------------------------------------------------------------------- */

typedef struct distribution {
	int ndf;
	float alpha, anisotropy;
} distribution;

/* The integral of D cos over the hemisphere, as one in u, [0, 1), with tan = alpha u / (1 - u): as a function of
 * tan / alpha every D has the width 1.
 * dm = sin dtheta dphi, and cos sin dtheta = tan dtan / (1 + tan^2)^2. */
static double distribution_integrand(double u, const void *context)
{
	const distribution *d = context;
	double alpha = (double)d->alpha, tangent = alpha * u / (1.0 - u), tan2 = tangent * tangent;
	double dtan = alpha / ((1.0 - u) * (1.0 - u));
	float sin2 = (float)(tan2 / (1.0 + tan2));
	return 2.0 * M_PI * (double)shade_d(d->ndf, sin2, d->alpha) * tangent * dtan / ((1.0 + tan2) * (1.0 + tan2));
}

static void distributions_are_normalised(void **state)
{
	(void)state;
	for (size_t i = 0; i < ALPHA_COUNT; i++)
		for (int ndf = 0; ndf < SHADE_NDF_GGX_ANISOTROPIC; ndf++) {
			distribution d = {.ndf = ndf, .alpha = (float)alphas[i]};
			SHADE_PROOF_NEAR(stilb_numeric_integrate(distribution_integrand, &d, 0.0, 1.0, 60), 1.0, 2e-5, 0.0);
		}
}

static double anisotropic_integrand(const double m[3], const void *context)
{
	const distribution *d = context;
	shade_alphas widths = shade_alphas_from_anisotropy(d->alpha, d->anisotropy);
	return (double)shade_d_ggx_anisotropic((float)m[0], (float)m[1], widths.x, widths.y) * m[2];
}

static void anisotropic_ggx_is_normalised(void **state)
{
	(void)state;
	for (float alpha = 0.2f; alpha < 1.05f; alpha += 0.2f)
		for (float anisotropy = -0.6f; anisotropy < 0.9f; anisotropy += 0.4f) {
			distribution d = {.alpha = alpha, .anisotropy = anisotropy};
			double whole = stilb_numeric_integrate_sphere(anisotropic_integrand, &d, 0.0, 1.0, 20);
			SHADE_PROOF_NEAR(whole, 1.0, 2e-5, 0.0);
		}
}

/* A metal's F is 1 everywhere, every F is 1 at grazing angles and F0 at normal incidence, and none leaves [0, 1]. */
static void fresnel_keeps_its_ends(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 44};
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		float f0 = i % 7 == 0 ? 0.0f : shade_proof_uniform(&random),
			  c = i % 5 == 0 ? 1.0f : shade_proof_uniform(&random);
		stilb_vec3 color = {f0, 0.0f, 1.0f};
		for (int f = 0; f < SHADE_F_COUNT; f++) {
			stilb_vec3 at = shade_f(f, color, c), normal = shade_f(f, color, 1.0f), grazing = shade_f(f, color, 0.0f);
			SHADE_PROOF_LIGHT3(at);
			SHADE_PROOF_NEAR(at[2], 1.0, 0.0, 1e-6);
			SHADE_PROOF_NEAR(normal[0], f0, 1e-5, 1e-6);
			SHADE_PROOF_NEAR(grazing[2], 1.0, 0.0, 1e-6);
			SHADE_PROOF_NEAR(grazing[0], f == SHADE_F_NONE ? (double)f0 : 1.0, 1e-6, 0.0);
			assert_true(at[0] <= 1.000001f);
		}
	}
	SHADE_PROOF_NEAR3(shade_f_cook_torrance(stilb_vec3_make(1e30f, -1.0f, 2.0f), 0.5f), 1.0, 0.0, 1.0, 1e-5, 1e-6);
}

/* Over all angles that three unit vectors can have V and G are finite and not negative, and G is at most 1. */
static void every_term_is_light(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 45};
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		stilb_vec3 n = shade_proof_random_direction(&random), l = shade_proof_random_above(&random, n);
		stilb_vec3 v = shade_proof_random_above(&random, n);
		if (i % 8 == 0) /* both at the horizon, opposite or almost so */
			l = stilb_vec3_normalize(-v + n * shade_proof_log_range(&random, 1e-9f, 1e-2f));
		float alpha = i % 3 == 0 ? SHADE_ALPHA_MIN : shade_proof_log_range(&random, SHADE_ALPHA_MIN, 1.0f);
		shade_angles a = shade_angles_of(n, l, v);
		a.n_dot_l = fmaxf(a.n_dot_l, 0.0f);
		a.n_dot_v = fmaxf(a.n_dot_v, 0.0f);
		a.n_dot_h = fmaxf(a.n_dot_h, 0.0f);
		for (int g = 0; g < SHADE_G_COUNT; g++) {
			float share = shade_g(g, a, alpha, alpha);
			SHADE_PROOF_LIGHT(shade_v(g, a, alpha, alpha));
			SHADE_PROOF_LIGHT(share);
			/* At the horizon rounding may make v.h too small against n.l and n.v, by whose product Kelemen divides. */
			assert_true(a.v_dot_h < 0.01f || share <= 1.0002f);
		}
		for (int ndf = 0; ndf < SHADE_NDF_COUNT; ndf++)
			SHADE_PROOF_LIGHT(shade_d(ndf, a.sin2_h, alpha));
		SHADE_PROOF_LIGHT(shade_dv_ggx(a.sin2_h, a.n_dot_l, a.n_dot_v, alpha));
		SHADE_PROOF_LIGHT(shade_minimalist(a.sin2_h, a.v_dot_h, shade_exponent_from_alpha(alpha)));
		SHADE_PROOF_LIGHT3(shade_schlick_kelemen_fv(stilb_vec3_make(0.0f, 0.04f, 1.0f), a.v_dot_h));
	}
}

static void anisotropic_terms_are_light(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 46};
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		stilb_vec3 m = shade_proof_random_direction(&random);
		float alpha = shade_proof_log_range(&random, SHADE_ALPHA_MIN, 1.0f);
		shade_alphas widths = shade_alphas_from_anisotropy(alpha, shade_proof_range(&random, -1.0f, 1.0f));
		float along = shade_alpha_along(widths, m);
		SHADE_PROOF_LIGHT(shade_d_ggx_anisotropic(m[0], m[1], widths.x, widths.y));
		assert_true(along >= fminf(widths.x, widths.y) * 0.99999f && along <= fmaxf(widths.x, widths.y) * 1.00001f);
	}
}

static const struct CMUnitTest properties[] = {
	cmocka_unit_test(distributions_are_normalised), cmocka_unit_test(anisotropic_ggx_is_normalised),
	cmocka_unit_test(fresnel_keeps_its_ends),       cmocka_unit_test(every_term_is_light),
	cmocka_unit_test(anisotropic_terms_are_light),
};

int main(void)
{
	return SHADE_PROOF_RUN(exactness, properties);
}
