/* base_json: a strict reader accepts its documents and finds the same values. */
#include "base/base_json.h"
#include "support/json_flat.h"
#include "support/test.h"

#include <float.h>
#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static json_flat flat;

static int flat_done(void **state)
{
	(void)state;
	json_flat_finish(&flat);
	return 0;
}

/* Reads the document and finishes the writer. */
static void read_back(stilb_json *json)
{
	json_flat_finish(&flat);
	assert_false(json->failed);
	assert_int_equal(json->depth, 0);
	assert_int_equal(strlen(json->text), json->length);
	json_flat_text(json->text, json->length, &flat);
	assert_string_equal(flat.error, "");
	stilb_json_finish(json);
	assert_null(json->text);
}

static void assert_value(const char *path, char kind, const char *text)
{
	const json_flat_value *value = json_flat_find(&flat, path);
	assert_non_null(value);
	assert_int_equal(value->kind, kind);
	assert_string_equal(value->text, text);
}

static void test_nesting(void **state)
{
	(void)state;
	stilb_json json = {0};
	stilb_json_begin(&json, NULL, '{');
	stilb_json_int(&json, "first", 1);
	stilb_json_begin(&json, "empty object", '{');
	stilb_json_end(&json, '}');
	stilb_json_begin(&json, "list", '[');
	stilb_json_int(&json, NULL, 2);
	stilb_json_begin(&json, NULL, '{');
	stilb_json_string(&json, "name", "x");
	stilb_json_end(&json, '}');
	stilb_json_begin(&json, NULL, '[');
	stilb_json_end(&json, ']');
	stilb_json_bool(&json, NULL, true);
	stilb_json_end(&json, ']');
	stilb_json_bool(&json, "last", false);
	stilb_json_end(&json, '}');
	read_back(&json);
	assert_value("", '{', "{}");
	assert_value("first", '0', "1");
	assert_value("empty object", '{', "{}");
	assert_value("list[0]", '0', "2");
	assert_value("list[1].name", '"', "x");
	assert_value("list[2]", '[', "[]");
	assert_value("list[3]", 'w', "true");
	assert_value("last", 'w', "false");
	assert_int_equal(flat.count, 10);
	stilb_json_begin(&json, NULL, '[');
	stilb_json_end(&json, ']');
	read_back(&json);
	assert_value("", '[', "[]");
}

static void test_deep_and_long(void **state)
{
	(void)state;
	stilb_json json = {0};
	for (int i = 0; i < 60; i++)
		stilb_json_begin(&json, NULL, '[');
	for (int i = 0; i < 60; i++)
		stilb_json_end(&json, ']');
	read_back(&json);
	assert_int_equal(flat.count, 60);
	stilb_json_begin(&json, NULL, '[');
	for (int i = 0; i < 20000; i++)
		stilb_json_int(&json, NULL, i);
	stilb_json_end(&json, ']');
	read_back(&json);
	assert_int_equal(flat.count, 20001);
	assert_value("[19999]", '0', "19999");
}

static void test_strings(void **state)
{
	(void)state;
	char every[256];
	for (int i = 1; i < 128; i++)
		every[i - 1] = (char)i;
	every[127] = '\0';
	stilb_json json = {0};
	stilb_json_begin(&json, NULL, '{');
	stilb_json_string(&json, "every", every);
	stilb_json_string(&json, "empty", "");
	stilb_json_string(&json, "more", "\xc3\xa9\xe2\x82\xac\xf0\x9f\x98\x80 \\u0041 \"\\");
	stilb_json_string(&json, "a\"b\\c\nd", "key");
	stilb_json_end(&json, '}');
	read_back(&json);
	assert_value("every", '"', every);
	assert_value("empty", '"', "");
	assert_value("more", '"', "\xc3\xa9\xe2\x82\xac\xf0\x9f\x98\x80 \\u0041 \"\\");
	assert_value("a\"b\\c\nd", '"', "key");
}

/* Strings of drivers may be cut within a character or be in another encoding: the document stays valid. */
static void test_strings_that_are_not_utf8(void **state)
{
	(void)state;
	static const char *const cases[][2] = {
		{"caf\xe9 x", "caf\xef\xbf\xbd x"},
		{"cut \xe2\x82", "cut \xef\xbf\xbd\xef\xbf\xbd"},
		{"\xc0\xaf", "\xef\xbf\xbd\xef\xbf\xbd"},                                   /* overlong form */
		{"\xed\xa0\x80", "\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd"},                   /* half of a surrogate pair */
		{"\xf4\x90\x80\x80!", "\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd!"}, /* above U+10FFFF */
		{"\xf4\x8f\xbf\xbf", "\xf4\x8f\xbf\xbf"},
		{"\xff\xc3\xa9", "\xef\xbf\xbd\xc3\xa9"},
	};
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		stilb_json json = {0};
		stilb_json_string(&json, NULL, cases[i][0]);
		read_back(&json);
		assert_value("", '"', cases[i][1]);
	}
}

static void number_is(double value, const char *text)
{
	stilb_json json = {0};
	stilb_json_double(&json, NULL, value);
	read_back(&json);
	assert_value("", '0', text);
}

static void float_is(float value, const char *text)
{
	stilb_json json = {0};
	stilb_json_float(&json, NULL, value);
	read_back(&json);
	assert_value("", '0', text);
	assert_true(!isfinite(value) || strtof(text, NULL) == value);
}

static void test_numbers(void **state)
{
	(void)state;
	float_is(0.1f, "0.100000001");
	float_is(-3e-20f, "-2.9999999e-20");
	float_is(16777217.0f, "16777216");
	float_is(FLT_MAX, "3.40282347e+38");
	float_is(NAN, "0");
	float_is(INFINITY, "0");
	number_is(0.0, "0.000000");
	number_is(-0.0, "0.000000");
	number_is(1.5, "1.500000");
	number_is(-1.5, "-1.500000");
	number_is(-0.25, "-0.250000");
	number_is(-0.0000001, "0.000000");
	number_is(0.0000006, "0.000001");
	number_is(0.9999996, "1.000000");
	number_is(12345.678901, "12345.678901");
	number_is(1234567890.125, "1234567890.125000");
	number_is(9e12, "0.000000");
	number_is((double)NAN, "0.000000");
	number_is((double)INFINITY, "0.000000");
	number_is(-(double)INFINITY, "0.000000");
	number_is(1e300, "0.000000");
	stilb_json json = {0};
	stilb_json_begin(&json, NULL, '[');
	stilb_json_int(&json, NULL, INT64_MIN);
	stilb_json_int(&json, NULL, INT64_MAX);
	stilb_json_int(&json, NULL, 0);
	stilb_json_end(&json, ']');
	read_back(&json);
	assert_value("[0]", '0', "-9223372036854775808");
	assert_value("[1]", '0', "9223372036854775807");
	assert_value("[2]", '0', "0");
}

/* Makes a locale with a decimal comma, since the machine may have none. Its other parts are missing, so localedef
 * complains. False: it could not be made. */
static bool comma_locale(void)
{
	static const char source[] =
		"LC_NUMERIC\ndecimal_point \"<U002C>\"\nthousands_sep \"\"\ngrouping -1\nEND LC_NUMERIC\n";
	char folder[] = "test_base_json_XXXXXX", command[256];
	assert_non_null(mkdtemp(folder));
	snprintf(command, sizeof command,
	         "cd %s && cat >source && localedef --no-archive -c -i ./source ./comma 2>log || true", folder);
	FILE *shell = popen(command, "w");
	assert_non_null(shell);
	fputs(source, shell);
	pclose(shell);
	setenv("LOCPATH", folder, 1);
	bool found = setlocale(LC_NUMERIC, "comma");
	unsetenv("LOCPATH");
	snprintf(command, sizeof command, "rm -r %s", folder);
	assert_int_equal(system(command), 0);
	return found;
}

static void test_numbers_in_a_locale_with_a_comma(void **state)
{
	(void)state;
	char text[32];
	assert_true(comma_locale());
	snprintf(text, sizeof text, "%.1f", 1.5);
	assert_string_equal(text, "1,5");
	number_is(1.5, "1.500000");
	number_is(-1234567.5, "-1234567.500000");
	setlocale(LC_NUMERIC, "C");
}

static void test_save(void **state)
{
	(void)state;
	char path[] = "test_base_json_XXXXXX";
	int descriptor = mkstemp(path);
	assert_true(descriptor >= 0);
	close(descriptor);
	stilb_json json = {0};
	stilb_json_begin(&json, NULL, '{');
	stilb_json_int(&json, "n", -3);
	stilb_json_end(&json, '}');
	assert_int_equal(stilb_json_save(&json, path), STILB_OK);
	assert_null(json.text);
	json_flat_finish(&flat);
	json_flat_file(path, &flat);
	assert_string_equal(flat.error, "");
	assert_value("n", '0', "-3");
	FILE *file = fopen(path, "rb");
	assert_int_equal(fseek(file, -1, SEEK_END), 0);
	assert_int_equal(fgetc(file), '\n');
	fclose(file);
	assert_int_equal(remove(path), 0);
	stilb_json_begin(&json, NULL, '[');
	stilb_json_end(&json, ']');
	assert_int_equal(stilb_json_save(&json, "missing-folder/x.json"), STILB_ERROR_FILE);
	assert_null(json.text);
}

/* ---- no memory --------------------------------------------------------------------------------------------------- */

static int allocations_left = -1;

void *__real_realloc(void *memory, size_t size);
void *__wrap_realloc(void *memory, size_t size);

void *__wrap_realloc(void *memory, size_t size)
{
	if (allocations_left == 0)
		return NULL;
	allocations_left -= allocations_left > 0;
	return __real_realloc(memory, size);
}

static void test_no_memory_is_remembered(void **state)
{
	(void)state;
	for (int i = 0; i < 4; i++) {
		stilb_json json = {0};
		allocations_left = i;
		stilb_json_begin(&json, NULL, '[');
		for (int k = 0; k < 1000; k++)
			stilb_json_int(&json, NULL, k);
		allocations_left = -1; /* memory is available again, but a part is missing */
		stilb_json_end(&json, ']');
		assert_true(json.failed);
		assert_int_equal(stilb_json_save(&json, "not-written.json"), STILB_ERROR_MEMORY);
		assert_non_null(strstr(stilb_error_message(), "not-written.json"));
		assert_int_not_equal(access("not-written.json", F_OK), 0);
		assert_null(json.text);
	}
}

/* The reader refuses text that is not JSON; else the tests above would prove nothing. */
static void test_reader_is_strict(void **state)
{
	(void)state;
	static const char *const wrong[] = {
		"",    "{",      "[1,]",  "{\"a\":1,}", "[1 2]", "[01]",    "[1.]",     "[.5]",   "[NaN]", "[inf]", "[1,5",
		"\"a", "\"\n\"", "[1] 2", "{\"a\" 1}",  "{a:1}", "\"\\x\"", "\"\xff\"", "[\"a\"", "['a']", "[+1]",  "[-]"};
	for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
		json_flat_finish(&flat);
		assert_false(json_flat_text(wrong[i], strlen(wrong[i]), &flat));
		assert_true(flat.error[0] != '\0');
	}
}

#define FLAT_TEST(name) cmocka_unit_test_teardown(name, flat_done)

int main(void)
{
	const struct CMUnitTest tests[] = {
		FLAT_TEST(test_reader_is_strict),
		FLAT_TEST(test_nesting),
		FLAT_TEST(test_deep_and_long),
		FLAT_TEST(test_strings),
		FLAT_TEST(test_strings_that_are_not_utf8),
		FLAT_TEST(test_numbers),
		FLAT_TEST(test_numbers_in_a_locale_with_a_comma),
		FLAT_TEST(test_save),
		FLAT_TEST(test_no_memory_is_remembered),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
