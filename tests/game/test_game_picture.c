/* Names of the pictures that F12 saves: no file is replaced, and the name of the picture that the run saves at its end
 * stays free. */
#include "game/live/live_picture.h"
#include "support/folder.h"
#include "support/test.h"

#include <stdlib.h>
#include <unistd.h>

static void assert_name(const char *path, const char *last, const char *expected)
{
	char *name;
	assert_int_equal(live_picture_reserve(path, last, &name), STILB_OK);
	assert_non_null(name);
	assert_string_equal(name, expected);
	assert_int_equal(access(name, F_OK), 0); /* it is taken from now on */
	free(name);
}

static void touch(const char *path)
{
	FILE *file = fopen(path, "w");
	assert_non_null(file);
	fclose(file);
}

static void test_names(void **state)
{
	(void)state;
	char *name = (char *)&name;
	assert_name("a.png", NULL, "a.png");
	assert_name("a.png", NULL, "a-2.png");
	touch("a-4.png");
	assert_name("a.png", NULL, "a-3.png");
	assert_name("a.png", NULL, "a-5.png");
	assert_name("b.png", "b.png", "b-2.png"); /* b.png is the name for the end of the run */
	assert_name("b.png", "./b.png", "b-3.png");
	assert_int_equal(access("b.png", F_OK), -1);
	assert_name("./b.png", "c.png", "./b.png");
	assert_int_equal(symlink("nowhere.png", "d.png"), 0); /* a link to nothing is a name that exists */
	assert_name("d.png", NULL, "d-2.png");
	assert_int_equal(access("nowhere.png", F_OK), -1);
	assert_name("e", NULL, "e");
	assert_name("e", NULL, "e-2");
	touch(".f");
	assert_name(".f", NULL, ".f-2");
	assert_int_equal(live_picture_reserve("missing.x/e", NULL, &name), STILB_ERROR_FILE);
	assert_string_equal(stilb_error_message(), "cannot create 'missing.x/e': No such file or directory");
	assert_null(name);
}

static int folder_end(void **state)
{
	(void)state;
	folder_clear();
	return folder_remove();
}

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(test_names)};
	return cmocka_run_group_tests(tests, folder_make, folder_end);
}
