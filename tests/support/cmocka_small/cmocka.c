#include "cmocka.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PASSED = 1, FAILED, SKIPPED };
static jmp_buf test_end; /* of the test at hand; jumped to with one of these */
static bool test_runs;
static void *test_state; /* static: a test that ends by longjmp has changed it */

_Noreturn static void end_test(int how)
{
	if (!test_runs) /* in a group's setup or teardown */
		exit(255);
	longjmp(test_end, how);
}

/* ---- output ------------------------------------------------------------------------------------------------------ */

void print_message(const char *format, ...)
{
	va_list words;
	va_start(words, format);
	vprintf(format, words);
	va_end(words);
	fflush(stdout);
}

void print_error(const char *format, ...)
{
	va_list words;
	va_start(words, format);
	vfprintf(stderr, format, words);
	va_end(words);
}

_Noreturn void small_fail(const char *file, int line, const char *format, ...)
{
	va_list words;
	va_start(words, format);
	fprintf(stderr, "%s:%d: error: ", file, line);
	vfprintf(stderr, format, words);
	fputc('\n', stderr);
	va_end(words);
	end_test(FAILED);
}

_Noreturn void small_skip(void)
{
	end_test(SKIPPED);
}

/* ---- asserts ----------------------------------------------------------------------------------------------------- */

void small_expect(bool holds, const char *text, const char *file, int line)
{
	if (!holds)
		small_fail(file, line, "%s", text);
}

void small_equal(uintmax_t a, uintmax_t b, bool equal, const char *file, int line)
{
	if ((a == b) != equal)
		small_fail(file, line, "%#jx %s %#jx", a, equal ? "!=" : "==", b);
}

void small_in_range(uintmax_t value, uintmax_t least, uintmax_t most, const char *file, int line)
{
	if (value < least || value > most)
		small_fail(file, line, "%ju is not in %ju..%ju", value, least, most);
}

void small_float_equal(float a, float b, float epsilon, const char *file, int line)
{
	if (!(fabsf(a - b) <= epsilon))
		small_fail(file, line, "%.9g and %.9g differ by more than %.9g", (double)a, (double)b, (double)epsilon);
}

void small_string_equal(const char *a, const char *b, bool equal, const char *file, int line)
{
	if ((strcmp(a, b) == 0) != equal)
		small_fail(file, line, "\"%s\" %s \"%s\"", a, equal ? "!=" : "==", b);
}

void small_memory_equal(const void *a, const void *b, size_t size, const char *file, int line)
{
	const unsigned char *left = a, *right = b;
	for (size_t i = 0; i < size; i++)
		if (left[i] != right[i])
			small_fail(file, line, "byte %zu of %zu: %#x != %#x", i, size, left[i], right[i]);
}

/* ---- runs -------------------------------------------------------------------------------------------------------- */

static int run_test(const struct CMUnitTest *test, void *state)
{
	test_runs = true;
	test_state = state;
	int how = setjmp(test_end);
	if (how == 0) {
		if (test->setup_func && test->setup_func(&test_state) != 0)
			small_fail(test->name, 0, "its setup failed");
		test->test_func(&test_state);
		how = PASSED;
	}
	if (test->teardown_func && how != SKIPPED && test->teardown_func(&test_state) != 0)
		how = FAILED;
	test_runs = false;
	return how;
}

int small_run(const char *group, const struct CMUnitTest *tests, size_t count, CMFixtureFunction setup,
              CMFixtureFunction teardown)
{
	int counts[SKIPPED + 1] = {0};
	void *state = NULL;
	print_message("%s: %zu tests\n", group, count);
	if (setup && setup(&state) != 0)
		return (int)count;
	for (size_t i = 0; i < count; i++) {
		int how = run_test(&tests[i], tests[i].initial_state ? tests[i].initial_state : state);
		counts[how]++;
		print_message("%s %s\n", how == PASSED ? "passed" : how == FAILED ? "FAILED" : "skipped", tests[i].name);
	}
	if (teardown && teardown(&state) != 0)
		counts[FAILED]++;
	return counts[FAILED];
}
