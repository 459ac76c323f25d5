/* The samplers of the catalogue choose directions as often as their densities say, over roughness, brushing and view:
 * support/chi_square.h, which is tested first. With the argument "long" more of each, and more draws. */
#include "numeric/numeric_catalog.h"
#include "support/chi_square.h"

static uint32_t draws = 60000;
static bool is_long;

/* ---- the test itself --------------------------------------------------------------------------------------------- */

/* Values of tables: Abramowitz and Stegun, "Handbook of Mathematical Functions" (1964), 26.7 and 26.8. */
static void tails_are_those_of_tables(void **state)
{
	(void)state;
	static const double rows[][3] = {{1, 3.84146, 0.05},    {1, 10.8276, 0.001},  {2, 9.21034, 0.01},
	                                 {5, 1.14548, 0.95},    {10, 18.3070, 0.05},  {10, 29.5883, 0.001},
	                                 {30, 18.4926, 0.95},   {60, 91.9517, 0.005}, {100, 124.342, 0.05},
	                                 {100, 149.449, 0.001}, {100, 67.3276, 0.995}};
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
		SHADE_PROOF_NEAR(chi_square_tail(rows[i][1], rows[i][0]), rows[i][2], 5e-5, 0.0);
	for (double x = 0.1; x < 700.0; x *= 1.3) {
		SHADE_PROOF_NEAR(chi_square_tail(x, 2.0), exp(-0.5 * x), 1e-12, 0.0);
		SHADE_PROOF_NEAR(chi_square_tail(x, 4.0), exp(-0.5 * x) * (1.0 + 0.5 * x), 1e-12, 0.0);
		SHADE_PROOF_NEAR(chi_square_tail(x, 1.0), erfc(sqrt(0.5 * x)), 1e-12, 0.0);
	}
	assert_true(chi_square_tail(0.0, 3.0) == 1.0);
	SHADE_PROOF_NEAR(chi_square_poisson_tail(3.0, 0.0), 1.0, 0.0, 0.0);
	SHADE_PROOF_NEAR(chi_square_poisson_tail(3.0, 1.0), 1.0 - exp(-3.0), 1e-12, 0.0);
	SHADE_PROOF_NEAR(chi_square_poisson_tail(3.0, 3.0), 1.0 - exp(-3.0) * (1.0 + 3.0 + 4.5), 1e-12, 0.0);
}

/* A known density: x with the density 2 x to a power, y even, a share of the draws without a point. */
typedef struct ramp {
	double drawn, told; /* density 1 + drawn (x - 1/2) * 2 of the draws, told of the density */
	double lost, told_lost;
} ramp;

static bool ramp_draw(const void *context, shade_proof_random *random, double at[2])
{
	const ramp *r = context;
	double u = (double)shade_proof_uniform(random), k = r->drawn;
	/* x + k (x^2 - x) = u */
	at[0] = k == 0.0 ? u : (k - 1.0 + sqrt((1.0 - k) * (1.0 - k) + 4.0 * k * u)) / (2.0 * k);
	at[1] = (double)shade_proof_uniform(random);
	return (double)shade_proof_uniform(random) >= r->lost;
}

static double ramp_density(const void *context, const double at[2])
{
	const ramp *r = context;
	return (1.0 - r->told_lost) * (1.0 + r->told * (2.0 * at[0] - 1.0));
}

static chi_square_result ramp_compare(ramp r, uint64_t seed, uint32_t count)
{
	return chi_square_compare(&(chi_square_subject){ramp_draw, ramp_density, &r}, seed, count);
}

/* For draws as the density says p is spread evenly: of 400 the largest distance to that (Kolmogorov and Smirnov) is
 * below 2.03 / sqrt(400) but for one time in 2,000. */
static void p_of_right_densities_is_even(void **state)
{
	(void)state;
	enum { TRIES = 400 };
	double p[TRIES], most = 0.0;
	for (int i = 0; i < TRIES; i++) {
		double expected[12];
		uint32_t found[12] = {0};
		shade_proof_random random = {.seed = 1000 + (uint64_t)i};
		for (int k = 0; k < 12; k++)
			expected[k] = 500.0 / 12.0;
		for (int k = 0; k < 500; k++)
			found[(int)(shade_proof_uniform(&random) * 12.0f)]++;
		p[i] = 0.5 * chi_square_p(expected, found, 12, 0.0); /* no pool: the factor 2 is for the pool's own p */
	}
	for (int i = 0; i < TRIES; i++) {
		int below = 0;
		for (int k = 0; k < TRIES; k++)
			below += p[k] <= p[i];
		if (p[i] < 0.5) /* larger ones count as 1 */
			most = fmax(most, fabs((double)below / TRIES - p[i]));
	}
	assert_true(most < 2.03 / sqrt(TRIES));
	SHADE_PROOF_NEAR(ramp_compare((ramp){0.6, 0.6, 0.1, 0.1}, 1, 50000).mass, 0.9, 1e-9, 0.0);
	assert_true(ramp_compare((ramp){0.6, 0.6, 0.1, 0.1}, 1, 50000).p > 1e-4);
}

static void wrong_densities_are_found(void **state)
{
	(void)state;
	assert_true(ramp_compare((ramp){0.6, 0.5, 0.0, 0.0}, 2, 50000).p < 1e-6);   /* a little too flat */
	assert_true(ramp_compare((ramp){0.6, -0.6, 0.0, 0.0}, 3, 50000).p < 1e-6);  /* a sign */
	assert_true(ramp_compare((ramp){0.6, 0.6, 0.0, 0.02}, 4, 50000).p < 1e-6);  /* too small all over */
	assert_true(ramp_compare((ramp){0.6, 0.6, 0.02, 0.0}, 5, 50000).p < 1e-6);  /* too large, more is lost than said */
	assert_true(ramp_compare((ramp){0.6, 0.6, 0.0, -0.01}, 6, 50000).p == 0.0); /* above 1 in all */
	/* 40 draws where 2 are expected, in a pool of its own */
	assert_true(chi_square_p((const double[]){500.0, 498.0, 2.0}, (const uint32_t[]){480, 480, 40}, 3, 0.0) < 1e-20);
	assert_true(chi_square_p((const double[]){500.0, 498.0, 2.0}, (const uint32_t[]){500, 497, 3}, 3, 0.0) > 0.5);
}

/* ---- samplers ---------------------------------------------------------------------------------------------------- */

typedef struct spread {
	const stilb_numeric_row *row;
	stilb_numeric_shape shape;
} spread;

static const shade_frame frame = {.t = {1.0f, 0.0f, 0.0f}, .b = {0.0f, 1.0f, 0.0f}, .n = {0.0f, 0.0f, 1.0f}};

static bool spread_draw(const void *context, shade_proof_random *random, double at[2])
{
	const spread *s = context;
	stilb_vec2 u = {shade_proof_uniform(random), shade_proof_uniform(random)};
	chi_square_place(frame, s->row->sample(&s->shape, u).direction, at);
	return true;
}

static double spread_density(const void *context, const double at[2])
{
	const spread *s = context;
	return 4.0 * M_PI * (double)s->row->density(&s->shape, chi_square_direction(frame, at));
}

/* Directions and points of the square belong to each other, and equal areas to equal solid angles. */
static void the_square_is_the_sphere(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 5};
	uint32_t found[64] = {0};
	double expected[64];
	for (int i = 0; i < 100000; i++) {
		stilb_vec3 w =
			shade_sample_sphere((stilb_vec2){shade_proof_uniform(&random), shade_proof_uniform(&random)}).direction;
		double at[2];
		chi_square_place(frame, w, at);
		stilb_vec3 back = chi_square_direction(frame, at) - w;
		assert_true(stilb_vec3_dot(back, back) < 1e-12f);
		found[(int)(at[0] * 8.0) * 8 + (int)(at[1] * 8.0)]++;
	}
	for (int i = 0; i < 64; i++)
		expected[i] = 100000.0 / 64.0;
	assert_true(chi_square_p(expected, found, 64, 0.0) > 1e-4);
}

static const float polars[] = {0.0f, 0.8f, 1.3f, 1.5f};

static spread spread_of(const stilb_numeric_row *row, float roughness, float anisotropy, float polar)
{
	return (spread){row, {roughness, anisotropy, stilb_vec3_make(sinf(polar), 0.0f, cosf(polar))}};
}

static void check_row(const stilb_numeric_row *row, chi_square_family *family)
{
	static const float roughnesses[] = {0.05f, 0.2f, 0.5f, 1.0f};
	for (int r = is_long ? 0 : 1; r < 4; r += is_long ? 1 : 2)
		for (int p = 0; p < 4; p += is_long ? 1 : 2)
			for (int a = 0; a < (is_long ? 2 : 1); a++) {
				float anisotropy = a ? 0.0f : 0.7f;
				spread s = spread_of(row, roughnesses[r], anisotropy, polars[p]);
				chi_square_subject subject = {spread_draw, spread_density, &s};
				chi_square_result got = chi_square_compare(&subject, 7 + family->done, draws);
				if (!chi_square_passes(family, got.p))
					fail_msg("%s, roughness %g, anisotropy %g, view %g: p %.2g, integral %.5f", row->name,
					         (double)roughnesses[r], (double)anisotropy, (double)polars[p], got.p, got.mass);
			}
}

static void samplers_choose_as_their_densities_say(void **state)
{
	(void)state;
	size_t count, samplers = 0;
	const stilb_numeric_row *rows = stilb_numeric_catalog(&count);
	for (size_t i = 0; i < count; i++)
		samplers += rows[i].kind == STILB_NUMERIC_SAMPLER;
	chi_square_family family = chi_square_family_of((uint32_t)samplers * (is_long ? 4 * 4 * 2 : 2 * 2));
	for (size_t i = 0; i < count; i++)
		if (rows[i].kind == STILB_NUMERIC_SAMPLER)
			check_row(&rows[i], &family);
	chi_square_end(&family);
}

int main(int argc, char **argv)
{
	is_long = argc > 1 && strcmp(argv[1], "long") == 0;
	draws = is_long ? 40000 : TEST_ASAN || TEST_EMULATED ? 20000 : 60000;
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(tails_are_those_of_tables),
		cmocka_unit_test(p_of_right_densities_is_even),
		cmocka_unit_test(wrong_densities_are_found),
		cmocka_unit_test(the_square_is_the_sphere),
		cmocka_unit_test(samplers_choose_as_their_densities_say),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
