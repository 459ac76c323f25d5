/* Rows are calls of shading functions in which GPU and C are compared (cases/README.md). This runs them in C: they are
 * numbered 0, 1, 2, ..., and no input gives a NaN or an infinity. Built once for each topic. The first argument is the
 * count of random inputs for each row. */
#include "shade_topic.h"
#include "support/shade_proof.h"

typedef struct shade_row {
	const char *name;
	int index;
	float relative, absolute;
} shade_row;

static const shade_row rows[] = {
#define ROW(row, name, relative, absolute) {#name, row, relative, absolute},
	SHADE_TOPIC_CASES(ROW)
#undef ROW
};

static void rows_are_numbered(void **state)
{
	(void)state;
	assert_int_equal(sizeof rows / sizeof rows[0], SHADE_TOPIC_COUNT);
	for (int i = 0; i < SHADE_TOPIC_COUNT; i++)
		if (rows[i].index != i || !(rows[i].relative <= 1e-3f && rows[i].absolute <= 1e-3f))
			fail_msg("%s: row %d with the bounds %g and %g is the row %d of its list", rows[i].name, rows[i].index,
			         (double)rows[i].relative, (double)rows[i].absolute, i);
}

static stilb_vec4 random_vec4(uint64_t seed, uint64_t index)
{
	stilb_vec4 v;
	for (uint64_t k = 0; k < 4; k++)
		v[k] = stilb_random_float(seed, index * 4 + k);
	return v;
}

static uint64_t input_count = 20000;

static void check_finite(int row, stilb_vec4 a, stilb_vec4 b)
{
	stilb_vec4 result = shade_topic_case(row, a, b);
	for (int k = 0; k < 4; k++)
		if (!isfinite(result[k]))
			fail_msg("%s: lane %d is %g for a {%.9g, %.9g, %.9g, %.9g}, b {%.9g, %.9g, %.9g, %.9g}", rows[row].name, k,
			         (double)result[k], (double)a[0], (double)a[1], (double)a[2], (double)a[3], (double)b[0],
			         (double)b[1], (double)b[2], (double)b[3]);
}

static void rows_are_finite(void **state)
{
	(void)state;
	for (int i = 0; i < SHADE_TOPIC_COUNT; i++)
		for (uint64_t n = 0; n < input_count; n++)
			check_finite(i, random_vec4(1, n), random_vec4(2, n));
}

/* Every input number at its lowest, in the middle, and at its highest, in all combinations: black light, grazing and
 * opposite directions, the smoothest surface. */
static void rows_are_finite_at_their_corners(void **state)
{
	(void)state;
	for (int i = 0; i < SHADE_TOPIC_COUNT; i++)
		for (int corner = 0; corner < SHADE_PROOF_CORNERS; corner++) {
			stilb_vec4 a, b;
			for (int k = 0; k < 4; k++) {
				a[k] = shade_proof_corner(corner, k);
				b[k] = shade_proof_corner(corner, k + 4);
			}
			check_finite(i, a, b);
		}
}

/* A row whose result is the same for every input compares nothing. Only the vocabulary's is meant to be always 0. */
static void rows_depend_on_their_inputs(void **state)
{
	(void)state;
	for (int i = 0; i < SHADE_TOPIC_COUNT; i++) {
		stilb_vec4 first = shade_topic_case(i, random_vec4(1, 0), random_vec4(2, 0));
		bool differs = rows[i].absolute == 0.0f;
		for (uint64_t n = 1; n < 1000; n++) {
			stilb_vec4 result = shade_topic_case(i, random_vec4(1, n), random_vec4(2, n));
			differs |= result[0] != first[0] || result[1] != first[1] || result[2] != first[2] || result[3] != first[3];
		}
		if (!differs)
			fail_msg("%s answers the same to every input", rows[i].name);
	}
}

int main(int argc, char **argv)
{
	if (argc > 1)
		input_count = strtoull(argv[1], NULL, 10);
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(rows_are_numbered),
		cmocka_unit_test(rows_are_finite),
		cmocka_unit_test(rows_are_finite_at_their_corners),
		cmocka_unit_test(rows_depend_on_their_inputs),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
