/* shade_layers.h: in double, against quadrature, and that no layer makes light. */

#include "shading/shade_layers.h"

#include "numeric/numeric_quadrature.h"
#include "support/shade_proof.h"

static const stilb_vec3 up = {0.0f, 0.0f, 1.0f, 0.0f};

static stilb_vec3 seen_at(float cosine)
{
	return stilb_vec3_make(sqrtf(1.0f - cosine * cosine), 0.0f, cosine);
}

/* D V n.l of GGX in double. */
static double ggx_cos(double roughness, stilb_vec3 l, stilb_vec3 v)
{
	double a2 = pow(fmax(roughness * roughness, 1e-3), 2), x = (double)l[0] + (double)v[0];
	double y = (double)l[1] + (double)v[1], z = (double)l[2] + (double)v[2], cos2 = z * z / (x * x + y * y + z * z);
	double nl = (double)l[2], nv = (double)v[2], d = a2 / (3.14159265358979 * pow(cos2 * (a2 - 1) + 1, 2));
	return nl * d / ((nl + sqrt(a2 + (1 - a2) * nl * nl)) * (nv + sqrt(a2 + (1 - a2) * nv * nv)));
}

static void coats_in_double(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 1};
	for (int k = 0; k < 2000; k++) {
		stilb_vec3 l = shade_proof_random_above(&random, up), v = shade_proof_random_above(&random, up);
		float roughness = shade_proof_range(&random, 0.2f, 1.0f), coat = shade_proof_uniform(&random);
		SHADE_PROOF_NEAR(shade_coat_cos(roughness, up, l, v), ggx_cos((double)roughness, l, v), 1e-3, 1e-6);
		SHADE_PROOF_NEAR(shade_layer_highlight_cos(roughness, up, l, v), ggx_cos((double)roughness, l, v), 1e-3, 1e-6);
		double left = pow(1 - (double)v[2], 5);
		SHADE_PROOF_NEAR(shade_coat_share(coat, v[2]), (double)coat * (0.04 + 0.96 * left), 1e-5, 1e-7);
		assert_true(shade_coat_cos(roughness, up, -l, v) == 0.0f && shade_coat_cos(roughness, up, l, -v) == 0.0f);
	}
}

static double sheen_albedo(double n_dot_v, double r)
{
	double x = sqrt(n_dot_v);
	return exp(0.704 - 2.66 * r + 1.448 * r * r + 0.097 / r + (-0.534 + 1.366 * r - 1.235 * r * r - 0.098 / r) * x +
	           (-0.715 + 0.1 * r + 0.733 * r * r - 1.008 / r) * n_dot_v);
}

/* Sheen without the division that keeps it from making light. */
static double sheen_cos(double r, stilb_vec3 l, stilb_vec3 v)
{
	double x = (double)l[0] + (double)v[0], y = (double)l[1] + (double)v[1], z = (double)l[2] + (double)v[2];
	double sin2 = (x * x + y * y) / (x * x + y * y + z * z), nl = (double)l[2], nv = (double)v[2];
	double d = (2 + 1 / (r * r)) * pow(sin2, 0.5 / (r * r)) / (2 * 3.14159265358979);
	return d * nl / (4 * (nl + nv - nl * nv));
}

static void sheen_in_double(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 2};
	for (int k = 0; k < 4000; k++) {
		stilb_vec3 l = shade_proof_random_above(&random, up), v = shade_proof_random_above(&random, up);
		float roughness = shade_proof_range(&random, 0.1f, 1.0f);
		double r = (double)roughness, albedo = sheen_albedo((double)v[2], r);
		SHADE_PROOF_NEAR(shade_sheen_albedo_raw(v[2], roughness), albedo, 2e-5, 1e-7);
		SHADE_PROOF_NEAR(shade_sheen_albedo(v[2], roughness), fmin(albedo, 1.0), 2e-5, 1e-7);
		double most = albedo + 0.0235 * (1 - pow((double)v[2], 4)) * fmax(albedo, 1.0);
		SHADE_PROOF_NEAR(shade_sheen_most(v[2], roughness), most, 2e-5, 1e-7);
		double wanted = sheen_cos(r, l, v) / fmax(most, 1.0);
		SHADE_PROOF_NEAR(shade_sheen_cos(roughness, up, l, v), wanted, 2e-4, 1e-6);
		assert_true(shade_sheen_cos(roughness, up, -l, v) == 0.0f && shade_sheen_cos(roughness, up, l, -v) == 0.0f);
		stilb_vec3 color = stilb_vec3_make(0.25f, 0.75f, 0.5f);
		SHADE_PROOF_NEAR(shade_sheen_left(color, v[2], roughness), 1 - 0.75 * fmin(most, 1.0), 1e-4, 1e-6);
	}
	SHADE_PROOF_NEAR(shade_d_sheen(1.0f, 0.5f), 6 / (2 * 3.14159265358979), 1e-5, 0.0);
	SHADE_PROOF_NEAR(shade_d_sheen(0.25f, 0.5f), 6 * 0.0625 / (2 * 3.14159265358979), 1e-5, 0.0);
	assert_true(shade_sheen_albedo_raw(0.1f, 0.0f) == shade_sheen_albedo_raw(0.1f, 0.1f));
}

/* Straight through, a wall of reflectance f0 has the density of its mirrored highlight times 1 - F. */
static void thin_walls_in_double(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 3};
	for (int k = 0; k < 2000; k++) {
		stilb_vec3 l = shade_proof_random_above(&random, up), v = shade_proof_random_above(&random, up);
		stilb_vec3 f0 = shade_proof_random_color(&random, 0.5f), below = stilb_vec3_make(l[0], l[1], -l[2]);
		float roughness = shade_proof_range(&random, 0.2f, 1.0f);
		double h = 0.5 * (double)sqrtf(stilb_vec3_dot(l + v, l + v)),
			   most = fmax(fmax((double)f0[0], (double)f0[1]), (double)f0[2]);
		double left = (1 - most) * (1 - pow(1 - h, 5));
		SHADE_PROOF_NEAR(shade_facet_left(f0, (float)h), left, 1e-4, 1e-6);
		SHADE_PROOF_NEAR(shade_thin_cos(f0, roughness, up, below, v), left * ggx_cos((double)roughness, l, v), 2e-4,
		                 1e-6);
		assert_true(shade_thin_cos(f0, roughness, up, l, v) == 0.0f);
	}
}

/* Towards the viewer from the normal, unit. */
static void sheen_leans_to_the_viewer(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 5};
	for (int k = 0; k < 2000; k++) {
		stilb_vec3 v = shade_proof_random_above(&random, up);
		float roughness = shade_proof_range(&random, 0.1f, 1.0f);
		double r = (double)roughness, z = (double)v[2], lean = 0.227 / (r * r * (1.25 - z * z));
		double x = (double)v[0] * lean, y = (double)v[1] * lean, length = sqrt(x * x + y * y + 1);
		SHADE_PROOF_NEAR3(shade_sheen_direction(up, v, roughness), x / length, y / length, 1 / length, 2e-5, 2e-6);
	}
}

/* The alphas that come out are those of KHR_materials_anisotropy. */
static void brushed_has_both_alphas(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 4};
	for (int k = 0; k < 2000; k++) {
		float roughness = shade_proof_range(&random, 0.05f, 1.0f), strength = shade_proof_uniform(&random);
		stilb_vec2 brushed = shade_gltf_brushed(roughness, strength);
		shade_alphas alphas = shade_alphas_from_anisotropy(shade_alpha_from_roughness(brushed[0]), brushed[1]);
		double across = (double)roughness * (double)roughness, s2 = (double)strength * (double)strength;
		SHADE_PROOF_NEAR(alphas.x, across + s2 * (1 - across), 1e-5, 1e-6);
		SHADE_PROOF_NEAR(alphas.y, across, 1e-4, 1e-6);
	}
}

/* ---- energy ------------------------------------------------------------------------------------------------------ */

typedef struct layer_view {
	stilb_vec3 v;
	float roughness;
} layer_view;

static stilb_vec3 direction_of(const double direction[3])
{
	return stilb_vec3_make((float)direction[0], (float)direction[1], (float)direction[2]);
}

static double raw_sheen(const double direction[3], const void *context)
{
	const layer_view *view = context;
	return sheen_cos((double)view->roughness, direction_of(direction), view->v);
}

static double kept_sheen(const double direction[3], const void *context)
{
	const layer_view *view = context;
	return (double)shade_sheen_cos(view->roughness, up, direction_of(direction), view->v);
}

static double coat(const double direction[3], const void *context)
{
	const layer_view *view = context;
	return (double)shade_coat_cos(view->roughness, up, direction_of(direction), view->v);
}

static double wall(const double direction[3], const void *context)
{
	const layer_view *view = context;
	stilb_vec3 f0 = stilb_vec3_make(0.04f, 0.02f, 0.0f), below = direction_of(direction);
	return (double)shade_thin_cos(f0, view->roughness, up, stilb_vec3_make(below[0], below[1], -below[2]), view->v);
}

/* The fit is right to 0.026, relative where it is above 1. Sheen over white gives back at most 1, and .952 at least. */
static void sheen_keeps_light(void **state)
{
	(void)state;
	double square = 0.0;
	for (int i = 0; i < 10; i++)
		for (int k = 0; k < 10; k++) {
			float n_dot_v = 0.004f + 0.996f * (float)(k * k) / 81.0f, roughness = 0.1f + 0.9f * (float)i / 9.0f;
			layer_view view = {seen_at(n_dot_v), roughness};
			double exact = stilb_numeric_integrate_sphere(raw_sheen, &view, 0.0, 1.0, 8);
			double fitted = (double)shade_sheen_albedo_raw(n_dot_v, roughness),
				   error = (fitted - exact) / fmax(exact, 1);
			square += error * error / 100;
			if (fabs(error) > 0.026)
				fail_msg("n.v %g, roughness %g: %g, not %g", (double)n_dot_v, (double)roughness, fitted, exact);
			double kept = stilb_numeric_integrate_sphere(kept_sheen, &view, 0.0, 1.0, 8);
			double left = (double)shade_sheen_left(stilb_vec3_make(1.0f, 1.0f, 1.0f), n_dot_v, roughness);
			if (!(kept + left <= 1.0 + 1e-3 && kept + left >= 0.952))
				fail_msg("n.v %g, roughness %g: %g of 1", (double)n_dot_v, (double)roughness, kept + left);
		}
	SHADE_PROOF_NEAR(sqrt(square), 0.013, 0.0, 0.003);
}

static void nothing_is_added(void **state)
{
	(void)state;
	for (int i = 0; i < 8; i++)
		for (int k = 1; k < 8; k++) {
			layer_view view = {seen_at((float)k / 7.0f), 0.3f + 0.1f * (float)i};
			assert_true(stilb_numeric_integrate_sphere(coat, &view, 0.0, 1.0, 8) <= 1.0 + 1e-4);
			assert_true(stilb_numeric_integrate_sphere(wall, &view, 0.0, 1.0, 8) <= 1.0 + 1e-4);
		}
}

int main(void)
{
	const struct CMUnitTest exactness[] = {
		cmocka_unit_test(coats_in_double),           cmocka_unit_test(sheen_in_double),
		cmocka_unit_test(sheen_leans_to_the_viewer), cmocka_unit_test(thin_walls_in_double),
		cmocka_unit_test(brushed_has_both_alphas),
	};
	const struct CMUnitTest properties[] = {cmocka_unit_test(sheen_keeps_light), cmocka_unit_test(nothing_is_added)};
	return SHADE_PROOF_RUN(exactness, properties);
}
