/* Every row of the catalogue does what it says: its own integral is 1, it conserves energy or gains the amount in the
 * table, it is reciprocal or is not, and its samples are directions with a density. */
#include "support/shade_proof.h"

#include "numeric/numeric_catalog.h"
#include "numeric/numeric_quadrature.h"

#include <stdio.h>
#include <string.h>

static const float ROUGHNESSES[] = {0.0f, 0.1f, 0.35f, 0.7f, 1.0f};
enum { ROUGHNESS_COUNT = sizeof ROUGHNESSES / sizeof ROUGHNESSES[0] };

static stilb_numeric_shape make_shape(float roughness)
{
	/* The view direction is neither in a plane of symmetry nor near the horizon. */
	return (stilb_numeric_shape){roughness, 0.4f, stilb_vec3_normalize(stilb_vec3_make(0.5f, 0.3f, 0.7f))};
}

typedef void row_check(const stilb_numeric_row *row);

static void each_row(stilb_numeric_kind kind, row_check *check)
{
	size_t count, seen = 0;
	const stilb_numeric_row *rows = stilb_numeric_catalog(&count);
	for (size_t i = 0; i < count; i++)
		if (rows[i].kind == kind) {
			check(&rows[i]);
			seen++;
		}
	assert_true(seen > 5);
}

/* ---- the table --------------------------------------------------------------------------------------------------- */

static void names_find_their_rows(void **state)
{
	(void)state;
	size_t count;
	const stilb_numeric_row *rows = stilb_numeric_catalog(&count);
	for (size_t i = 0; i < count; i++) {
		assert_ptr_equal(stilb_numeric_catalog_find(rows[i].name), &rows[i]);
		assert_true(strlen(rows[i].formula) > 0 && strlen(rows[i].source) > 0);
		assert_true(i == 0 || rows[i].kind >= rows[i - 1].kind);
	}
	assert_ptr_equal(stilb_numeric_catalog_find("ggx-smith_ggx"), stilb_numeric_catalog_find("ggx_smith_ggx"));
	assert_non_null(stilb_numeric_catalog_find("ggx-smith_ggx"));
	assert_null(stilb_numeric_catalog_find("ggx"));
	assert_null(stilb_numeric_catalog_find("lambert_"));
	assert_null(stilb_numeric_catalog_find(""));
}

/* All D x G pairs and all other kinds stand in the table, each once. */
static void table_is_whole(void **state)
{
	(void)state;
	int pairs[SHADE_NDF_COUNT][SHADE_G_COUNT] = {0}, kinds[SHADE_BRDF_COUNT] = {0};
	size_t count;
	const stilb_numeric_row *rows = stilb_numeric_catalog(&count);
	for (size_t i = 0; i < count; i++) {
		if (rows[i].kind != STILB_NUMERIC_BRDF)
			continue;
		const shade_brdf_model *model = &rows[i].model;
		if (model->kind == SHADE_BRDF_MICROFACET)
			pairs[model->ndf][model->g]++;
		else
			kinds[model->kind]++;
	}
	for (int d = 0; d < SHADE_NDF_COUNT; d++)
		for (int g = 0; g < SHADE_G_COUNT; g++)
			assert_int_equal(pairs[d][g], 1);
	for (int kind = 0; kind < SHADE_BRDF_MICROFACET; kind++)
		assert_int_equal(kinds[kind], 1);
}

/* ---- measures ---------------------------------------------------------------------------------------------------- */

static void check_measure(const stilb_numeric_row *row)
{
	int count = row->measure == STILB_NUMERIC_MEASURE_SMOOTH ? 1 : ROUGHNESS_COUNT;
	for (int i = 0; i < count; i++) {
		stilb_numeric_shape shape = make_shape(ROUGHNESSES[i]);
		double measure = stilb_numeric_measure_of(row, &shape);
		if (!(fabs(measure - 1.0) <= 1e-4))
			fail_msg("%s, roughness %g: %s is %.7f", row->name, (double)ROUGHNESSES[i],
			         stilb_numeric_measure_text(row->measure), measure);
	}
}

static void distributions_have_their_measure(void **state)
{
	(void)state;
	each_row(STILB_NUMERIC_DISTRIBUTION, check_measure);
}

static void brdfs_have_their_measure(void **state)
{
	(void)state;
	each_row(STILB_NUMERIC_BRDF, check_measure);
}

static void densities_have_their_measure(void **state)
{
	(void)state;
	each_row(STILB_NUMERIC_SAMPLER, check_measure);
}

/* Schueler's NDF row is normalised without the cosine; with it the integral is (n + 1) / (n + 2). */
static void ndf_row_is_not_a_heightfield(void **state)
{
	(void)state;
	stilb_numeric_row row = *stilb_numeric_catalog_find("d_blinn_phong");
	row.measure = STILB_NUMERIC_MEASURE_D_COS;
	stilb_numeric_shape shape = make_shape(0.7f);
	double n = 2.0 / pow(0.7, 4.0) - 2.0;
	SHADE_PROOF_NEAR(stilb_numeric_measure_of(&row, &shape), (n + 1.0) / (n + 2.0), 1e-5, 0.0);
}

/* ---- flags ------------------------------------------------------------------------------------------------------- */

static void check_energy(const stilb_numeric_row *row)
{
	double largest = stilb_numeric_largest_albedo(row);
	printf("%-34s %9.4f %s\n", row->name, largest, row->conserving ? "conserving" : "gains energy");
	if (!(fabs(largest - row->largest_albedo) <= 1e-3 * row->largest_albedo))
		fail_msg("%s: the largest albedo is %.5f, in the table %.5f", row->name, largest, row->largest_albedo);
	if (row->conserving != (largest <= 1.0 + 1e-3))
		fail_msg("%s: the largest albedo is %.5f", row->name, largest);
}

static void energy_is_kept_or_gained_as_the_table_says(void **state)
{
	(void)state;
	each_row(STILB_NUMERIC_BRDF, check_energy);
}

/* Models that gain energy without a bound: at half the angle above the horizon they gain twice as much. */
static void some_gains_have_no_bound(void **state)
{
	(void)state;
	static const char *const names[] = {"wrapped", "phong", "blinn_phong", "minimalist"};
	for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
		const stilb_numeric_row *row = stilb_numeric_catalog_find(names[i]);
		float roughness = row->model.kind == SHADE_BRDF_MINIMALIST ? 0.0f : 1.0f;
		double at_89 = stilb_numeric_white_albedo(row, roughness, (stilb_numeric_angles){89.0 * M_PI / 180.0, 0.0});
		double nearer = stilb_numeric_white_albedo(row, roughness, (stilb_numeric_angles){89.5 * M_PI / 180.0, 0.0});
		SHADE_PROOF_NEAR(nearer / at_89, 2.0, 0.02, 0.0);
	}
}

/* |f(l, v) - f(v, l)| of a row's model for random directions, relative to f(l, v) + f(v, l); all are multiplied by both
 * cosines, and 0.01 is added to the divisor so that values too dark to be seen do not matter. */
static double asymmetry(const stilb_numeric_row *row, shade_proof_random *random)
{
	shade_frame frame = {{1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}, {0.0f, 0.0f, 1.0f}};
	stilb_vec3 l = shade_proof_random_above(random, frame.n), v = shade_proof_random_above(random, frame.n);
	shade_brdf_parameters white = stilb_numeric_white(shade_proof_range(random, 0.3f, 0.7f), 0.5f);
	SHADE_PROOF_LIGHT3(shade_brdf_cos(row->model, white, frame, l, v));
	double there = (double)shade_brdf_cos(row->model, white, frame, l, v)[0] * (double)v[2];
	double back = (double)shade_brdf_cos(row->model, white, frame, v, l)[0] * (double)l[2];
	return fabs(there - back) / (there + back + 0.01);
}

static void check_reciprocity(const stilb_numeric_row *row)
{
	shade_proof_random random = {.seed = 17};
	double worst = 0.0;
	for (int i = 0; i < (TEST_ASAN ? 4000 : 30000); i++) /* for each of 39 models: over 10^6 pairs of directions */
		worst = fmax(worst, asymmetry(row, &random));
	if (row->reciprocal ? worst > 1e-4 : worst < 0.5)
		fail_msg("%s: f(l, v) and f(v, l) differ by %g of their sum", row->name, worst);
}

static void reciprocity_is_as_the_table_says(void **state)
{
	(void)state;
	each_row(STILB_NUMERIC_BRDF, check_reciprocity);
}

/* ---- samplers ---------------------------------------------------------------------------------------------------- */

static void check_samples(const stilb_numeric_row *row)
{
	shade_proof_random random = {.seed = 29};
	for (int i = 0; i < 100000; i++) {
		stilb_numeric_shape shape = make_shape(shade_proof_uniform(&random));
		shape.view = shade_proof_random_above(&random, stilb_vec3_make(0.0f, 0.0f, 1.0f));
		float u = shade_proof_uniform(&random), v = shade_proof_uniform(&random);
		if (i < 4) /* the corners of the square */
			u = i & 1 ? 0.99999994f : 0.0f, v = i & 2 ? 0.99999994f : 0.0f;
		shade_sample chosen = row->sample(&shape, (stilb_vec2){u, v});
		double length2 = (double)stilb_vec3_dot(chosen.direction, chosen.direction);
		if (!(fabs(length2 - 1.0) <= 2e-6) || !(chosen.pdf > 0.0f && chosen.pdf < INFINITY))
			fail_msg("%s(%g, %g): length^2 %g, density %g", row->name, (double)u, (double)v, length2,
			         (double)chosen.pdf);
		SHADE_PROOF_LIGHT(row->density(&shape, chosen.direction));
		SHADE_PROOF_LIGHT(row->density(&shape, shade_proof_random_direction(&random)));
	}
}

static void samples_are_directions_with_a_density(void **state)
{
	(void)state;
	each_row(STILB_NUMERIC_SAMPLER, check_samples);
}

int main(void)
{
	const struct CMUnitTest exactness[] = {
		cmocka_unit_test(names_find_their_rows),
		cmocka_unit_test(table_is_whole),
		cmocka_unit_test(distributions_have_their_measure),
		cmocka_unit_test(brdfs_have_their_measure),
		cmocka_unit_test(densities_have_their_measure),
		cmocka_unit_test(ndf_row_is_not_a_heightfield),
	};
	const struct CMUnitTest properties[] = {
		test_no_asan(energy_is_kept_or_gained_as_the_table_says), /* some_gains_have_no_bound calls the same */
		cmocka_unit_test(some_gains_have_no_bound),
		cmocka_unit_test(reciprocity_is_as_the_table_says),
		cmocka_unit_test(samples_are_directions_with_a_density),
	};
	return SHADE_PROOF_RUN(exactness, properties);
}
