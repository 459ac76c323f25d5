/* numeric_dfg.h: the table's values against the albedo of the same lobe by numeric_albedo.h, their interpolation
 * against quadrature, and the white furnace with what facets hand on. */
#include "numeric/numeric_dfg.h"

#include "numeric/numeric_albedo.h"
#include "numeric/numeric_catalog.h"
#include "numeric/numeric_quadrature.h"
#include "shading/shade_environment.h"
#include "support/shade_proof.h"

/* The lobe's albedo with Schlick's term of f0. */
static double albedo(double f0, double n_dot_v, double roughness)
{
	shade_brdf_model model = {
		.kind = SHADE_BRDF_MICROFACET, .ndf = SHADE_NDF_GGX, .g = SHADE_G_SMITH_GGX, .f = SHADE_F_SCHLICK};
	shade_brdf_parameters surface = stilb_numeric_white((float)roughness, 0.0f);
	surface.specular = stilb_vec3_make((float)f0, (float)f0, (float)f0);
	return stilb_numeric_albedo_of_view(&model, &surface, (stilb_numeric_angles){.polar = acos(n_dot_v)});
}

static void values_are_those_of_the_lobe(void **state)
{
	(void)state;
	for (int k = 0; k <= 8; k++)
		for (int i = 1; i <= 8; i++) {
			double roughness = 0.03 + 0.97 * k / 8, n_dot_v = i / 8.0;
			stilb_numeric_dfg value = stilb_numeric_dfg_of(n_dot_v, roughness);
			SHADE_PROOF_NEAR(value.b, albedo(0.0, n_dot_v, roughness), 1e-3, 2e-5);
			SHADE_PROOF_NEAR(value.a + value.b, albedo(1.0, n_dot_v, roughness), 0.0, 5e-5);
			SHADE_PROOF_NEAR(0.3 * value.a + value.b, albedo(0.3, n_dot_v, roughness), 0.0, 5e-5);
		}
}

/* A mirror: Fresnel's term itself. Seen along the normal, roughness 1 has the closed form a + b = ... of its lobe: the
 * mean over half vectors of a cosine-like D, which is the integral of 4 z V n.l z dz with D = 1 / pi. */
static double rough_lobe(double z, const void *context)
{
	(void)context;
	double n_dot_l = 2.0 * z * z - 1.0;
	return 2.0 * 4.0 * z * n_dot_l / ((1.0 + 1.0) * (n_dot_l + 1.0));
}

static void ends_have_closed_forms(void **state)
{
	(void)state;
	for (int i = 4; i <= 10; i++) {
		double c = i / 10.0;
		stilb_numeric_dfg mirror = stilb_numeric_dfg_of(c, 0.0);
		SHADE_PROOF_NEAR(mirror.b, pow(1.0 - c, 5.0), 1e-3, 2e-5);
		SHADE_PROOF_NEAR(mirror.a + mirror.b, 1.0, 2e-5, 0.0);
	}
	stilb_numeric_dfg rough = stilb_numeric_dfg_of(1.0, 1.0);
	SHADE_PROOF_NEAR(rough.a + rough.b, stilb_numeric_integrate(rough_lobe, NULL, sqrt(0.5), 1.0, 4), 1e-6, 0.0);
	/* At the horizon nothing is a quotient of 0 by 0. */
	for (int k = 0; k <= 10; k++) {
		stilb_numeric_dfg edge = stilb_numeric_dfg_of(0.0, k / 10.0);
		assert_true(edge.a >= 0.0 && edge.b >= 0.0 && edge.a + edge.b <= 1.0 + 1e-5);
	}
}

/* Bilinear interpolation, as a device does it. */
static stilb_vec2 looked_up(const float *table, uint32_t side, double n_dot_v, double roughness)
{
	stilb_vec2 texel = shade_dfg_texel(shade_dfg_place((float)n_dot_v, (float)roughness), (float)side);
	double x = (double)texel[0] * side - 0.5, y = (double)texel[1] * side - 0.5;
	uint32_t left = x > 0.0 ? (uint32_t)x : 0, top = y > 0.0 ? (uint32_t)y : 0;
	uint32_t right = left + 1 < side ? left + 1 : left, bottom = top + 1 < side ? top + 1 : top;
	x -= left;
	y -= top;
	stilb_vec2 value;
	for (int c = 0; c < 2; c++) {
		double above =
			(double)table[2 * (top * side + left) + c] * (1.0 - x) + (double)table[2 * (top * side + right) + c] * x;
		double below = (double)table[2 * (bottom * side + left) + c] * (1.0 - x) +
		               (double)table[2 * (bottom * side + right) + c] * x;
		value[c] = (float)(above * (1.0 - y) + below * y);
	}
	return value;
}

static float table[2 * STILB_NUMERIC_DFG_SIDE * STILB_NUMERIC_DFG_SIDE];

/* n.v from 0 to 1, dense near 0; a quarter of the roughnesses below 0.25. */
static double some_cosine(uint32_t i)
{
	double u = (double)stilb_random_float(1, i);
	return i % 3 == 0 ? u * u * u : u;
}

static double some_roughness(uint32_t i)
{
	double u = (double)stilb_random_float(2, i);
	return i % 4 == 0 ? u * u : u;
}

static void interpolation_is_within_a_thousandth(void **state)
{
	(void)state;
	for (uint32_t i = 0; i < (TEST_EMULATED || TEST_ASAN ? 500u : 6000u); i++) {
		double n_dot_v = some_cosine(i), roughness = some_roughness(i);
		stilb_numeric_dfg want = stilb_numeric_dfg_of(n_dot_v, roughness);
		stilb_vec2 got = looked_up(table, STILB_NUMERIC_DFG_SIDE, n_dot_v, roughness);
		SHADE_PROOF_NEAR(got[0], want.a, 0.0, 1e-3);
		SHADE_PROOF_NEAR(got[1], want.b, 0.0, 1e-3);
	}
}

/* The lobe itself times what the table says it lacks, in white light: a white metal reflects all of it, others less. */
static void white_metal_fills_the_furnace(void **state)
{
	(void)state;
	for (uint32_t i = 0; i < (TEST_EMULATED || TEST_ASAN ? 500u : 6000u); i++) {
		double n_dot_v = some_cosine(i), roughness = some_roughness(i);
		stilb_numeric_dfg lobe = stilb_numeric_dfg_of(n_dot_v, roughness);
		stilb_vec2 dfg = looked_up(table, STILB_NUMERIC_DFG_SIDE, n_dot_v, roughness);
		double more = (double)shade_energy_compensation(stilb_vec3_make(1.0f, 1.0f, 1.0f), dfg)[0];
		SHADE_PROOF_NEAR((lobe.a + lobe.b) * more, 1.0 - 2.5e-4, 0.0, 1.25e-3);
		assert_true((lobe.a + lobe.b) * more <= 1.0 + 1e-3);
		double f0 = (double)stilb_random_float(4, i);
		more = (double)shade_energy_compensation(stilb_vec3_make((float)f0, 0.0f, 0.0f), dfg)[0];
		assert_true((f0 * lobe.a + lobe.b) * more <= 1.0 + 1e-3);
		assert_true(more >= 1.0 - 1e-6);
	}
}

static void rows_make_the_table(void **state)
{
	(void)state;
	float whole[2 * 9 * 9], parts[2 * 9 * 9];
	stilb_numeric_dfg_rows(whole, 9, 0, 9);
	for (uint32_t row = 9; row > 0; row--)
		stilb_numeric_dfg_rows(parts, 9, row - 1, row);
	assert_memory_equal(whole, parts, sizeof whole);
	/* The last row is roughness 1, the last column n.v 1. */
	stilb_numeric_dfg last = stilb_numeric_dfg_of(1.0, 1.0), dark = stilb_numeric_dfg_of(0.0, 1.0);
	SHADE_PROOF_NEAR(whole[2 * 80], last.a, 1e-6, 0.0);
	SHADE_PROOF_NEAR(whole[2 * 72 + 1], dark.b, 1e-6, 0.0);
}

int main(void)
{
	stilb_numeric_dfg_rows(table, STILB_NUMERIC_DFG_SIDE, 0, STILB_NUMERIC_DFG_SIDE);
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(values_are_those_of_the_lobe),
		cmocka_unit_test(ends_have_closed_forms),
		cmocka_unit_test(interpolation_is_within_a_thousandth),
		cmocka_unit_test(white_metal_fills_the_furnace),
		cmocka_unit_test(rows_make_the_table),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
