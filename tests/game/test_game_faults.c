/* stilb with too few threads, too little memory, or one allocation that fails: it never crashes, prints the reason in
 * one line, and writes --stats. The second argument is the library support/failing_preload.c. */
#include "support/stilb_program.h"

#include <sys/resource.h>

#define MANY 20000 /* more allocations than a run makes: guards against an endless loop */

/* A render without an output file, so that no library for pictures is loaded. */
#define SMALL "render cornell --size 8x8 --spp 1 --workers 1 --preview "

static char preload[PATH_MAX + 16]; /* "LD_PRELOAD=...", "" in a build with sanitizers */

/* Runs stilb with a limited address space, as `ulimit -v` does. */
static int code_within(rlim_t bytes, const char *line)
{
	struct rlimit before;
	assert_int_equal(getrlimit(RLIMIT_AS, &before), 0);
	struct rlimit limit = {bytes, before.rlim_max};
	assert_int_equal(setrlimit(RLIMIT_AS, &limit), 0);
	stilb_start(no_display, -1, line);
	assert_int_equal(setrlimit(RLIMIT_AS, &before), 0);
	program_wait(&run);
	return run.code;
}

/* The stacks of 256 threads do not fit into an address space of 1 GiB. */
static void test_a_render_without_threads_reports(void **state)
{
	(void)state;
	if (!preload[0])
		skip(); /* a sanitizer needs more address space than the limit */
	assert_int_equal(code_within(1 << 30, "render cornell --preview --workers 256 --stats a.json"), 1);
	assert_said(run.err, "no memory for 256 threads; try fewer with --workers");
	assert_said(run.out, "stats: a.json\n");
	read_stats("a.json");
	assert_string_equal(stat_text("scene.name", '"'), "cornell");
	assert_string_equal(stat_text("end", '"'), "failure");
	assert_non_null(strstr(stat_text("message", '"'), "no memory for 256 threads"));
	assert_string_equal(stat_text("finished", 'w'), "false");
}

/* The message names the part that memory was missing for. */
static void test_memory_is_said(void **state)
{
	(void)state;
	if (!preload[0])
		skip(); /* a sanitizer needs more address space than the limit */
	assert_int_equal(code_within(200 << 20, SMALL "--stats a.json"), 1);
	assert_said(run.err, "no memory to start Embree; raise the limit");
	read_stats("a.json");
	assert_non_null(strstr(stat_text("message", '"'), "no memory to start Embree"));
	assert_int_equal(code_within(300 << 20, "demo --headless --frames 1 --models 10 --size 64x64"), 1);
	assert_said(run.err, "no memory for the tables of meshes and materials; close other programs, or raise the limit");
}

/* Each allocation fails in a run of its own. No file but complete statistics is left behind. */
static void every_allocation_fails_once(const char *line)
{
	char at[32];
	const char *const environment[] = {NO_DISPLAY, preload, at, "STILB_FAIL_MARK=mark", NULL};
	int failed = 0;
	for (int i = 0; i < MANY; i++) {
		snprintf(at, sizeof at, "STILB_FAIL_AT=%d", i);
		int code = stilb_code(environment, line);
		if (remove("mark") != 0) {
			assert_int_equal(code, 0); /* none failed: the run makes fewer allocations than this */
			assert_true(failed > 0 && i > 20);
			return;
		}
		if (code < 0 || code > 1 || (code == 1 && run.err[0] == '\0'))
			print_error("allocation %d of '%s': exit %d, \"%s\"\n", i, line, code, run.err);
		assert_in_range(code, 0, 1);
		assert_true(code == 0 || run.err[0] != '\0');
		failed += code;
		if (access("a.json", F_OK) == 0) {
			read_stats("a.json");
			assert_int_equal(remove("a.json"), 0);
		} else {
			assert_int_equal(code, 1);
		}
		assert_int_equal(folder_entries(), 0);
	}
	fail_msg("no end of allocations");
}

static void test_every_allocation_of_a_render_fails_once(void **state)
{
	(void)state;
	if (!preload[0])
		skip(); /* a sanitizer has an allocator of its own */
	every_allocation_fails_once(SMALL "--stats a.json");
}

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup(test_a_render_without_threads_reports, folder_fresh),
		cmocka_unit_test_setup(test_memory_is_said, folder_fresh),
		cmocka_unit_test_setup(test_every_allocation_of_a_render_fails_once, folder_fresh),
	};
	if (argc > 2 && argv[2][0])
		snprintf(preload, sizeof preload, "LD_PRELOAD=%s", argv[2]);
	if (!folder_enter(argc > 1 ? argv[1] : NULL, "game_faults")) {
		fprintf(stderr, "usage: %s PATH-OF-STILB [LIBRARY-OF-FAILING-PRELOAD]\n", argv[0]);
		return 2;
	}
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}
