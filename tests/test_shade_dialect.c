/* The C half of the shading dialect: every word's answer, and nothing of it left or lost after glsl_end.h. */

#include <tgmath.h>

#define max own_max
#define select(a) (a)

#include "shade_cases.h"
#include "shade_vocabulary.h"

#include "base/base.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

static void every_word_answers_right(void **state)
{
	(void)state;
	volatile float zero = 0.0f;
	int line = shade_vocabulary_fault(zero);
	if (line != 0)
		fail_msg("shade_vocabulary.h:%d", line);
}

#define TEXT(x) TEXT_OF(x)
#define TEXT_OF(x) #x

static void other_macros_come_back(void **state)
{
	(void)state;
	assert_string_equal(TEXT(max), "own_max");
	assert_string_equal(TEXT(select(3)), "(3)");
	assert_int_equal(_Generic(sqrt(2.0f), float : 4, default : 0), 4); /* <tgmath.h>'s */
	assert_int_equal(_Generic(sqrt(2.0), double : 8, default : 0), 8);
#if defined(min) || defined(dot) || defined(vec3) || defined(float) || defined(stilb_vec3) || defined(SHADE_FN)
	fail_msg("a word is left");
#endif
}

static void types_are_plain_vectors(void **state)
{
	(void)state;
	assert_int_equal(sizeof(stilb_vec2), 8);
	assert_int_equal(sizeof(stilb_vec3), 16);
	assert_int_equal(sizeof(shade_reflectance), 32);
	stilb_vec3 v = {1.0f, 2.0f, 3.0f};
	assert_true(shade_lambert(v)[1] == 2.0f * SHADE_INV_PI);
}

/* The rows that a GPU is compared with have numbers for every input. */
static void cases_are_finite(void **state)
{
	(void)state;
	int rows = 0;
#define COUNT_ROW(row, name, bound) rows += row == rows && bound < 1e-3f;
	SHADE_CASES(COUNT_ROW)
	assert_int_equal(rows, SHADE_CASE_COUNT);
	for (int row = 0; row < SHADE_CASE_COUNT; row++) {
		float highest = 0.0f;
		for (uint64_t i = 0; i < 20000; i++) {
			stilb_vec4 a, b;
			for (int k = 0; k < 4; k++) {
				a[k] = stilb_random_float(1, i * 4 + (uint64_t)k);
				b[k] = stilb_random_float(2, i * 4 + (uint64_t)k);
			}
			stilb_vec4 result = shade_case(row, a, b);
			for (int k = 0; k < 4; k++) {
				assert_true(isfinite(result[k]));
				highest = fmaxf(highest, result[k]);
			}
		}
		assert_true(highest > 0.1f);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_word_answers_right),
		cmocka_unit_test(other_macros_come_back),
		cmocka_unit_test(types_are_plain_vectors),
		cmocka_unit_test(cases_are_finite),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
