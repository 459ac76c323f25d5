/* cmocka_small: what our tests use of cmocka, for builds where that library is not: the preset arm64. Same names, same
 * meaning, same summary; no mocks, no signal handlers. Asserts only on the thread that runs the test. */
#ifndef CMOCKA_SMALL_H
#define CMOCKA_SMALL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef void (*CMUnitTestFunction)(void **state);
typedef int (*CMFixtureFunction)(void **state); /* 0: it went well */

struct CMUnitTest {
	const char *name;
	CMUnitTestFunction test_func;
	CMFixtureFunction setup_func, teardown_func; /* may be NULL */
	void *initial_state;
};

#define cmocka_unit_test(test) cmocka_unit_test_setup_teardown(test, NULL, NULL)
#define cmocka_unit_test_setup(test, setup) cmocka_unit_test_setup_teardown(test, setup, NULL)
#define cmocka_unit_test_teardown(test, teardown) cmocka_unit_test_setup_teardown(test, NULL, teardown)
#define cmocka_unit_test_setup_teardown(test, setup, teardown)                                                         \
	{                                                                                                                  \
		.name = #test, .test_func = (test), .setup_func = (setup), .teardown_func = (teardown)                         \
	}

/* Runs the tests in order; the number of those that failed. */
#define cmocka_run_group_tests(tests, setup, teardown) cmocka_run_group_tests_name(#tests, tests, setup, teardown)
#define cmocka_run_group_tests_name(group, tests, setup, teardown)                                                     \
	small_run(group, tests, sizeof(tests) / sizeof(tests)[0], setup, teardown)
int small_run(const char *group, const struct CMUnitTest *tests, size_t count, CMFixtureFunction setup,
              CMFixtureFunction teardown);

/* End the test at hand. */
_Noreturn void small_fail(const char *file, int line, const char *format, ...) __attribute__((format(printf, 3, 4)));
_Noreturn void small_skip(void);
#define fail() small_fail(__FILE__, __LINE__, "fail()")
#define fail_msg(...) small_fail(__FILE__, __LINE__, __VA_ARGS__)
#define skip() small_skip()

void print_message(const char *format, ...) __attribute__((format(printf, 1, 2)));
void print_error(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* As in cmocka, integers and pointers are compared as uintmax_t. */
void small_expect(bool holds, const char *text, const char *file, int line);
void small_equal(uintmax_t a, uintmax_t b, bool equal, const char *file, int line);
void small_in_range(uintmax_t value, uintmax_t least, uintmax_t most, const char *file, int line);
void small_float_equal(float a, float b, float epsilon, const char *file, int line);
void small_string_equal(const char *a, const char *b, bool equal, const char *file, int line);
void small_memory_equal(const void *a, const void *b, size_t size, const char *file, int line);

#define assert_true(c) small_expect((c) ? true : false, #c, __FILE__, __LINE__)
#define assert_false(c) small_expect((c) ? false : true, "!(" #c ")", __FILE__, __LINE__)
#define assert_non_null(c) small_expect((c) != NULL, #c " != NULL", __FILE__, __LINE__)
#define assert_null(c) small_expect((c) == NULL, #c " == NULL", __FILE__, __LINE__)
#define assert_int_equal(a, b) small_equal((uintmax_t)(a), (uintmax_t)(b), true, __FILE__, __LINE__)
#define assert_int_not_equal(a, b) small_equal((uintmax_t)(a), (uintmax_t)(b), false, __FILE__, __LINE__)
#define assert_ptr_equal(a, b) small_equal((uintptr_t)(a), (uintptr_t)(b), true, __FILE__, __LINE__)
#define assert_ptr_not_equal(a, b) small_equal((uintptr_t)(a), (uintptr_t)(b), false, __FILE__, __LINE__)
#define assert_in_range(value, least, most)                                                                            \
	small_in_range((uintmax_t)(value), (uintmax_t)(least), (uintmax_t)(most), __FILE__, __LINE__)
#define assert_float_equal(a, b, epsilon) small_float_equal(a, b, epsilon, __FILE__, __LINE__)
#define assert_string_equal(a, b) small_string_equal(a, b, true, __FILE__, __LINE__)
#define assert_string_not_equal(a, b) small_string_equal(a, b, false, __FILE__, __LINE__)
#define assert_memory_equal(a, b, size) small_memory_equal(a, b, size, __FILE__, __LINE__)

#endif
