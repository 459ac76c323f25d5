/* stilb_file_find_part: beside the program before anywhere else, then in the installation of the headers. */
#include "base/base_file.h"
#include "support/folder.h"
#include "support/test.h"

#include <limits.h>
#include <sys/stat.h>

#define PART "test-base-part.txt"

/* In place of the installed header's constant. */
extern char stilb_header_path[];
char stilb_header_path[PATH_MAX + 64];

static char program[PATH_MAX];

static void put(const char *path)
{
	FILE *file = fopen(path, "w");
	assert_non_null(file);
	fclose(file);
}

static void assert_found(const char *wanted)
{
	char path[STILB_FILE_PART_MAX], found[PATH_MAX], expected[PATH_MAX];
	assert_true(stilb_file_find_part(PART, path));
	assert_non_null(realpath(path, found));
	assert_non_null(realpath(wanted, expected));
	assert_string_equal(found, expected);
}

static void test_parts_are_found(void **state)
{
	(void)state;
	char here[PATH_MAX], beside[PATH_MAX + 64], path[STILB_FILE_PART_MAX];
	assert_non_null(getcwd(here, sizeof here));
	assert_false(stilb_file_find_part(PART, path));
	snprintf(stilb_header_path, sizeof stilb_header_path, "%s/include/stilb/base.h", here);
	assert_false(stilb_file_find_part(PART, path));
	assert_int_equal(mkdir("include", 0755) | mkdir("include/stilb", 0755), 0);
	assert_int_equal(mkdir("lib", 0755) | mkdir("lib/stilb", 0755), 0);
	put("lib/stilb/" PART);
	assert_found("lib/stilb/" PART);
	snprintf(stilb_header_path, sizeof stilb_header_path, "include/stilb/base.h"); /* as -I include would say it */
	assert_false(stilb_file_find_part(PART, path));
	snprintf(stilb_header_path, sizeof stilb_header_path, "%s/include/stilb/base.h", here);
	snprintf(beside, sizeof beside, "%s/" PART, program);
	put(beside);
	assert_found(beside);
	assert_int_equal(remove(beside) | remove("lib/stilb/" PART) | rmdir("lib/stilb") | rmdir("lib"), 0);
	assert_int_equal(rmdir("include/stilb") | rmdir("include"), 0);
	assert_false(stilb_file_find_part(PART, path));
}

static int finish(void **state)
{
	(void)state;
	return folder_remove();
}

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(test_parts_are_found)};
	ssize_t length = readlink("/proc/self/exe", program, sizeof program - 1);
	char *slash = length > 0 ? strrchr(program, '/') : NULL;
	if (!slash)
		return 1;
	*slash = '\0';
	return cmocka_run_group_tests(tests, folder_make, finish);
}
