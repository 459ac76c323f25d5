/* The shading dialect (glsl_begin.h) in C: every word of it gives the right answer; after glsl_end.h none of its macros
 * is left, and none that stood before is lost. */

#include <tgmath.h>

#define max own_max
#define select(a) (a)

#include "shade_vocabulary.h"

#include "shading/shade_diffuse.h"
#include "shading/shade_energy.h"

#include "base/base.h"
#include "support/test.h"

#include <stddef.h>
#include <string.h>

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

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_word_answers_right),
		cmocka_unit_test(other_macros_come_back),
		cmocka_unit_test(types_are_plain_vectors),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
