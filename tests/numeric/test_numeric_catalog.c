/* Every row of the catalogue does what it says: its own integral is 1, it conserves energy or gains the amount in the
 * table, it is reciprocal or is not, and its samples are spread as its density says. */
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

enum { RINGS = 24, SECTORS = 16, BINS = RINGS * SECTORS, SAMPLES = 1 << 17 };

/* How samples of a row are counted in bins. Counted are directions, in a frame whose z is where the density is highest;
 * where that is known of the half vector of view and direction, half vectors (STILB_NUMERIC_POLE_HALF). */
typedef struct spread {
	const stilb_numeric_row *row;
	const stilb_numeric_shape *shape;
	shade_frame frame; /* its normal is that z axis */
	double width;
	double ring_z; /* the height at which the azimuth is integrated */
} spread;

static spread make_spread(const stilb_numeric_row *row, const stilb_numeric_shape *shape)
{
	stilb_vec3 pole = {0.0f, 0.0f, 1.0f}, v = shape->view;
	if (row->pole == STILB_NUMERIC_POLE_MIRRORED)
		pole = stilb_vec3_make(-v[0], -v[1], v[2]);
	double width = fmax(1e-3, (double)(shape->roughness * shape->roughness));
	return (spread){row, shape, shade_frame_from_normal(pole), width, 0.0};
}

static stilb_vec3 counted(const spread *s, stilb_vec3 direction)
{
	if (s->row->pole != STILB_NUMERIC_POLE_HALF)
		return shade_frame_to_local(s->frame, direction);
	stilb_vec3 h = stilb_vec3_normalize(direction + s->shape->view);
	return h[2] < 0.0f ? -h : h;
}

/* The bin of p: its ring about z and its sector. With theta the angle from z, rings are equal steps of
 * tan^2(theta / 2) / (width^2 + tan^2(theta / 2)): so each holds about as many samples of a lobe of that width. */
static int bin_of(const spread *s, stilb_vec3 p)
{
	double rim2 = (double)(p[0] * p[0] + p[1] * p[1]);
	double tangent2 =
		p[2] > 0.0f ? rim2 / pow(1.0 + (double)p[2], 2.0) : pow(1.0 - (double)p[2], 2.0) / fmax(rim2, 1e-30);
	int ring = (int)(RINGS * tangent2 / (s->width * s->width + tangent2));
	int sector = (int)(SECTORS * (0.5 + atan2((double)p[1], (double)p[0]) / (2.0 * M_PI)));
	return (ring < RINGS ? ring : RINGS - 1) * SECTORS + (sector < SECTORS ? sector : SECTORS - 1);
}

/* The height z, -1 to 1, at which a ring ends below; for ring -1 it is 1, the pole where ring 0 begins. */
static double ring_height(const spread *s, int ring)
{
	double share = (ring + 1.0) / RINGS;
	double width2 = s->width * s->width;
	return (1.0 - share - width2 * share) / (1.0 - share + width2 * share);
}

static double density_at(double phi, const void *context)
{
	const spread *s = context;
	double radius = sqrt(fmax(0.0, 1.0 - s->ring_z * s->ring_z));
	stilb_vec3 p = stilb_vec3_make((float)(radius * cos(phi)), (float)(radius * sin(phi)), (float)s->ring_z);
	if (s->row->pole != STILB_NUMERIC_POLE_HALF)
		return (double)s->row->density(s->shape, shade_frame_to_world(s->frame, p));
	float view_h = stilb_vec3_dot(s->shape->view, p);
	if (p[2] < 0.0f)
		return 0.0;
	return (double)s->row->density(s->shape, p * (2.0f * view_h) - s->shape->view) * 4.0 * fabs((double)view_h);
}

typedef struct sector {
	spread spread;
	double low, high;
} sector;

static double density_in_sector(double z, const void *context)
{
	sector s = *(const sector *)context;
	s.spread.ring_z = z;
	return stilb_numeric_integrate(density_at, &s.spread, s.low, s.high, 1);
}

static double expected_share(const spread *s, int bin)
{
	int ring = bin / SECTORS, i = bin % SECTORS;
	sector part = {*s, ((double)i / SECTORS - 0.5) * 2.0 * M_PI, ((i + 1.0) / SECTORS - 0.5) * 2.0 * M_PI};
	double low = ring_height(s, ring), high = ring_height(s, ring - 1);
	/* Densities jump to 0 at the horizon z = 0, so a ring across it is integrated in two parts. */
	if (low < 0.0 && high > 0.0)
		return stilb_numeric_integrate(density_in_sector, &part, low, 0.0, 1) +
		       stilb_numeric_integrate(density_in_sector, &part, 0.0, high, 1);
	return stilb_numeric_integrate(density_in_sector, &part, low, high, 1);
}

/* Pearson's chi-square of the samples against the expected density: by how many of its standard deviations it lies
 * above its mean, the degrees of freedom. Bins in which fewer than ten samples are expected are joined into one. */
static double chi_square(const spread *sampled, const spread *expected)
{
	static int counts[BINS];
	memset(counts, 0, sizeof counts);
	shade_proof_random random = {.seed = 23};
	for (int i = 0; i < SAMPLES; i++) {
		float u = shade_proof_uniform(&random), v = shade_proof_uniform(&random);
		counts[bin_of(sampled, counted(sampled, sampled->row->sample(sampled->shape, (stilb_vec2){u, v}).direction))]++;
	}
	double chi2 = 0.0, rest = 0.0, rest_expected = 0.0;
	int freedom = 0;
	for (int bin = 0; bin < BINS; bin++) {
		double want = SAMPLES * expected_share(expected, bin), got = counts[bin];
		if (want < 10.0) {
			rest += got;
			rest_expected += want;
			continue;
		}
		chi2 += (got - want) * (got - want) / want;
		freedom++;
	}
	chi2 += (rest - rest_expected) * (rest - rest_expected) / fmax(rest_expected, 10.0);
	return (chi2 - freedom) / sqrt(2.0 * freedom);
}

static void check_spread(const stilb_numeric_row *row)
{
	static const float roughnesses[] = {0.1f, 0.4f, 0.8f};
	for (size_t i = 0; i < sizeof roughnesses / sizeof roughnesses[0]; i++) {
		stilb_numeric_shape shape = make_shape(roughnesses[i]);
		spread s = make_spread(row, &shape);
		double above = chi_square(&s, &s);
		if (!(above < 4.0))
			fail_msg("%s, roughness %g: chi-square is %.1f standard deviations too large", row->name,
			         (double)roughnesses[i], above);
	}
}

static void samples_are_spread_as_their_density(void **state)
{
	(void)state;
	each_row(STILB_NUMERIC_SAMPLER, check_spread);
}

/* The same samples do not pass for another density, nor for that of a lobe wider by a twentieth. */
static void chi_square_sees_a_wrong_density(void **state)
{
	(void)state;
	stilb_numeric_shape shape = make_shape(0.4f), wider = make_shape(0.41f);
	spread cosine = make_spread(stilb_numeric_catalog_find("sample_cosine"), &shape);
	spread hemisphere = make_spread(stilb_numeric_catalog_find("sample_hemisphere"), &shape);
	spread visible = make_spread(stilb_numeric_catalog_find("sample_ggx_visible"), &shape);
	spread visible_wider = visible;
	visible_wider.shape = &wider;
	assert_true(chi_square(&cosine, &hemisphere) > 100.0);
	assert_true(chi_square(&visible, &visible_wider) > 4.0);
}

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
		cmocka_unit_test(samples_are_spread_as_their_density),
		cmocka_unit_test(chi_square_sees_a_wrong_density),
		cmocka_unit_test(samples_are_directions_with_a_density),
	};
	return SHADE_PROOF_RUN(exactness, properties);
}
