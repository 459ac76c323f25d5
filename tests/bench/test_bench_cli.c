/* stilb-bench: its flags, short runs and their JSON, and programs that fail, print wrong results, hang or die. */
#include "support/bench_program.h"

#include <math.h>

static char faulty_path[PATH_MAX];

static int bench_code(const char *line)
{
	return stilb_code(NULL, line);
}

/* Runs stilb-bench, which must succeed. stilb_good would require an empty stderr, but stilb-bench prints there each
 * round that it has finished. */
static void bench_good(const char *line)
{
	int code = bench_code(line);
	if (code != 0)
		print_error("%s\n%s", line, run.err);
	assert_int_equal(code, 0);
}

/* ---- words ------------------------------------------------------------------------------------------------------- */

static void test_help_and_list(void **state)
{
	(void)state;
	stilb_good("--help");
	static const char *const words[] = {"queue",    "jobs",      "cull",   "queue --steps", "--quick",
	                                    "--rounds", "--seconds", "--only", "--case",        "--json",
	                                    "--plot",   "--list",    "--steps"};
	for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
		char line[32];
		snprintf(line, sizeof line, "\n  %s ", words[i]);
		assert_said(run.out, line);
	}
	stilb_good("queue --list");
	assert_said(run.out, "stilb-low-lock");
	assert_said(run.out, "batch16-pinned-2P2C");
	stilb_good("queue --steps --list");
	assert_said(run.out, "step4");
	assert_said(run.out, "large-2P1C");
	assert_int_equal(folder_entries(), 0);
}

/* A command line that is refused, and a word that the line on stderr must have. */
static const char *const refusals[][2] = {
	{"", "no suite"},
	{"bogus", "'bogus'"},
	{"queue --bogus", "'--bogus'"},
	{"queue extra", "'extra'"},
	{"queue --quick=1", "no value"},
	{"queue --rounds 0", "1..1000"},
	{"queue --rounds many", "'many'"},
	{"queue --rounds 2 --rounds 1001", "'1001'"},
	{"queue --seconds 0", "0.01..60"},
	{"queue --seconds 61", "'61'"},
	{"queue --seconds nan", "'nan'"},
	{"queue --seconds 1e1", "'1e1'"},
	{"queue --seconds", "missing"},
	{"queue --only stilb-low-lock,bogus", "'bogus'"},
	{"queue --only {}", "--only"},
	{"queue --case 4P4C,3P9C", "'3P9C'"},
	{"queue --case batch16-1P1C --only sutter", "--list"},
	{"queue --steps --only sutter", "'sutter'"},
	{"jobs --steps", "--steps"},
	{"queue --json missing/a.json", "does not exist"},
	{"queue --json .", "folder"},
	{"queue --plot missing/a.png", "does not exist"},
	{"queue --json a --plot ./a", "--plot"},
};

static void test_refusals(void **state)
{
	(void)state;
	for (size_t i = 0; i < sizeof refusals / sizeof *refusals; i++) {
		int code = bench_code(refusals[i][0]);
		if (code != 2)
			print_error("stilb-bench %s: %s", refusals[i][0], run.err);
		assert_int_equal(code, 2);
		assert_string_equal(run.out, "");
		assert_error_lines(1);
		assert_said(run.err, refusals[i][1]);
		assert_int_equal(folder_entries(), 0);
	}
}

/* ---- a small run ------------------------------------------------------------------------------------------------- */

/* The index, in the JSON file's array "rows", of the row of a case, a subject and a metric, or -1. */
static int row_of(const char *case_name, const char *subject, const char *metric)
{
	for (int i = 0;; i++) {
		char path[3][32];
		const json_flat_value *values[3];
		static const char *const keys[3] = {"case", "subject", "metric"};
		const char *const wanted[3] = {case_name, subject, metric};
		int same = 0;
		for (int k = 0; k < 3; k++) {
			snprintf(path[k], sizeof path[k], "rows[%d].%s", i, keys[k]);
			values[k] = json_flat_find(&stats, path[k]);
			if (!values[k])
				return -1;
			same += strcmp(values[k]->text, wanted[k]) == 0;
		}
		if (same == 3)
			return i;
	}
}

static double row_value(const char *case_name, const char *subject, const char *metric, const char *key)
{
	char path[64];
	int row = row_of(case_name, subject, metric);
	if (row < 0)
		print_error("no row %s %s %s\n", case_name, subject, metric);
	assert_true(row >= 0);
	snprintf(path, sizeof path, "rows[%d].%s", row, key);
	return strtod(stat_text(path, '0'), NULL);
}

/* Asserts that the row of a case, a subject and a metric has min <= median <= max and this number of runs; returns the
 * median. */
static double assert_row(const char *case_name, const char *subject, const char *metric, int runs)
{
	double median = row_value(case_name, subject, metric, "median");
	assert_true(row_value(case_name, subject, metric, "min") <= median);
	assert_true(median <= row_value(case_name, subject, metric, "max"));
	assert_true(row_value(case_name, subject, metric, "runs") == runs);
	return median;
}

static void assert_small_run(int runs)
{
	static const char *const subjects[] = {"stilb-low-lock", "stilb-lock-free", "sutter", "mutex", "counter"};
	static const char *const limits[] = {"clock", "uncontended-atomic", "contended-atomic", "futex-wake-p50",
	                                     "futex-wake-p99"};
	assert_string_equal(stat_text("suite", '"'), "queue");
	assert_true(stat_int("machine.cpus") >= 1);
	stat_text("machine.flags", '"');
	for (size_t i = 0; i < 5; i++)
		assert_true(assert_row("limits", "machine", limits[i], runs) > 0.0);
	for (size_t i = 0; i < 5; i++) {
		double throughput = assert_row("2P2C", subjects[i], "throughput", runs);
		/* A run of at least 0.02 s verified as many items as its throughput says. */
		double items = assert_row("2P2C", subjects[i], "items", runs);
		assert_true(items >= 1.0 && items * 1.05 >= throughput * 1e6 * 0.02);
		assert_true(assert_row("2P2C", subjects[i], "peak-memory", runs) > 0.0);
		assert_row("2P2C", subjects[i], "steal", runs);
	}
	assert_row("batch16-1P1C", "stilb-low-lock", "throughput", runs);
	assert_int_equal(row_of("batch16-1P1C", "sutter", "throughput"), -1);
}

static void test_small_run(void **state)
{
	(void)state;
	assert_int_equal(bench_code("queue --quick --case 2P1C"), 2); /* there is no such case */
	static const char words[] =
		"queue --quick --seconds 0.02 --rounds=9 --rounds 2 --only stilb-l*,sutter,mutex,counter "
		"--case 2P2C,batch16-1P1C --json a.json";
	bench_good(words);
	assert_said(run.out, "stilb-low-lock");
	assert_said(run.out, "worst");
	assert_null(strstr(run.out, "FAILED"));
	read_stats("a.json");
	assert_said(run.out, stat_text("machine.flags", '"'));
	assert_small_run(2);
	assert_int_equal(folder_entries(), 1);
}

/* Every run of the suite `cull` checks which models its way of culling finds, so a run that succeeds was right. */
static void test_small_run_of_cull(void **state)
{
	(void)state;
	bench_good("cull --goals --quick --seconds 0.01 --rounds 1 --case 10k-10,10k-move --json a.json");
	assert_said(run.out, "goal <= 1.1");
	assert_said(run.out, "goal >= 10");
	read_stats("a.json");
	assert_string_equal(stat_text("suite", '"'), "cull");
	static const char *const subjects[] = {"stilb-flat-scalar", "stilb-octree", "stilb-auto", "stilb-octree-2"};
	for (size_t i = 0; i < 4; i++) {
		double us = assert_row("10k-10", subjects[i], "p50", 1);
		assert_true(fabs(assert_row("10k-10", subjects[i], "per-model", 1) / (us * 0.1) - 1.0) < 0.001);
		assert_true(fabs(assert_row("10k-10", subjects[i], "visible", 1) - 10.0) < 0.1);
	}
	assert_true(assert_row("10k-move", "rebuild", "p50", 1) > 0.0);
	assert_int_equal(row_of("10k-move", "stream", "p50"), -1);
}

static void test_json_goes_where_it_is_told(void **state)
{
	(void)state;
	char line[512];
	static const char words[] = "queue --seconds 0.01 --rounds 1 --only mutex --case 1P1C";
	snprintf(line, sizeof line, "%s --json -", words);
	bench_good(line);
	json_flat_finish(&stats);
	assert_true(json_flat_text(run.out, strlen(run.out), &stats)); /* stdout has only JSON */
	assert_row("1P1C", "mutex", "throughput", 1);
	assert_said(run.err, "best peer: mutex"); /* the tables are on stderr then */
	snprintf(line, sizeof line, "%s --json /dev/full", words);
	assert_int_equal(bench_code(line), 1);
	assert_said(run.err, "\nstilb: cannot write '/dev/full'");
	int full = open("/dev/full", O_WRONLY | O_CLOEXEC);
	stilb_start(NULL, full, words);
	program_wait(&run);
	close(full);
	assert_int_equal(run.code, 1);
	assert_said(run.err, "standard output");
	assert_int_equal(folder_entries(), 0);
}

/* ---- programs with faults ---------------------------------------------------------------------------------------- */

/* The check of queue_load.h notices an item that is lost, repeated or changed, and stilb-bench reports it. */
static void test_wrong_results_are_failures(void **state)
{
	(void)state;
	copy_program(stilb_path, "stilb-bench");
	copy_program(faulty_path, "stilb-bench-queue-own");
	write_program("stilb-bench-limits", GOOD_LIMITS);
	static const char *const faulty[] = {"sutter", "stilb-low-lock", "stilb-lock-free"};
	for (size_t i = 0; i < 3; i++) {
		char line[256];
		snprintf(line, sizeof line, "queue --seconds 0.05 --rounds 1 --case 1P1C --only mutex,%s --json a.json",
		         faulty[i]);
		assert_int_equal(copy_code(NULL, line), 1);
		assert_said(run.err, "\nstilb: ");
		assert_said(run.err, "wrong result");
		assert_said(run.out, "FAILED in 1 of 1 runs: wrong result");
		read_stats("a.json");
		assert_int_equal(row_of("1P1C", faulty[i], "throughput"), -1);
		assert_row("1P1C", "mutex", "throughput", 1);
		/* The run was long enough for the faults, which the other queues have at item 1000. */
		assert_true(row_value("1P1C", "mutex", "items", "median") > 2000.0);
	}
}

/* A peer that hangs is killed and reported, and the exit code stays 0; a hanging subject of Stilb's is a failure. */
static void test_programs_that_hang_or_die(void **state)
{
	(void)state;
	copy_program(stilb_path, "stilb-bench");
	write_program("stilb-bench-limits", GOOD_LIMITS);
	write_program("stilb-bench-queue-own",
	              "case $1 in mutex) echo throughput 7; echo items 8;; *) exec sleep 60;; esac");
	assert_int_equal(
		copy_code(NULL,
	              "queue --give-up 2 --quick --seconds 0.01 --rounds 2 --case 1P1C --only mutex,sutter --json a.json"),
		0);
	assert_said(run.out, "TIMED OUT in 1 of 1 runs"); /* so sutter was not run again in the second round */
	read_stats("a.json");
	assert_true(assert_row("1P1C", "mutex", "throughput", 2) == 7.0);
	assert_true(row_value("1P1C", "sutter", "timed-out", "median") == 1.0);
	assert_int_equal(row_of("1P1C", "sutter", "throughput"), -1);
	assert_int_equal(copy_code(NULL, "queue --give-up 1 --seconds 0.01 --rounds 1 --case 1P1C --only stilb-low-lock"),
	                 1);
	assert_said(run.err, "stilb: stilb-low-lock in 1P1C: no result after 1 s, killed");
	/* A program that spins is killed by its limit of CPU time, however long that takes on a busy machine. */
	write_program("stilb-bench-queue-own", "while :; do :; done");
	assert_int_equal(copy_code(NULL, "queue --quick --seconds 0.01 --rounds 1 --case 1P1C --only stilb-low-lock"), 1);
	assert_said(run.err, "of CPU time, killed");

	static const char *const deaths[][2] = {{"kill -SEGV $$", "signal 11"},
	                                        {"echo broken >&2; exit 3", "broken"},
	                                        {"exit 3", "exit status 3"},
	                                        {"echo throughput", "throughput"},
	                                        {"exit 0", "exit status 0"}};
	for (size_t i = 0; i < sizeof deaths / sizeof *deaths; i++) {
		write_program("stilb-bench-queue-own", deaths[i][0]);
		assert_int_equal(copy_code(NULL, "queue --seconds 0.01 --rounds 1 --case 1P1C --only mutex"), 1);
		assert_said(run.err, deaths[i][1]);
	}
	write_program("stilb-bench-queue-own", "exit 77"); /* BENCH_CHILD_SKIP: no row, no failure */
	assert_int_equal(copy_code(NULL, "queue --seconds 0.01 --rounds 1 --case 1P1C --only mutex --json a.json"), 0);
	read_stats("a.json");
	assert_int_equal(row_of("1P1C", "mutex", "throughput"), -1);
}

/* ---- in words ---------------------------------------------------------------------------------------------------- */

/* Returns the three sentences at the end of stdout. Asserts that nothing says "goal" or "MISSED", which only runs with
 * --goals do. */
static const char *last_words(void)
{
	const char *words = strstr(run.out, "\nqueue: ");
	assert_non_null(words);
	assert_int_equal(program_lines(words + 1), 3);
	assert_null(strstr(run.out, "goal"));
	assert_null(strstr(run.out, "MISSED"));
	return words;
}

static void test_three_sentences_at_the_end(void **state)
{
	(void)state;
	copy_bench();
	write_program("stilb-bench-queue-own", "case $1-$2 in\n"
	                                       "stilb-low-lock-1P1C) echo throughput 8;;\n"
	                                       "stilb-low-lock-2P2C) echo throughput 30;;\n"
	                                       "*) echo throughput 10;;\n"
	                                       "esac\necho items 8");
	assert_int_equal(copy_code(NULL, "queue --seconds 0.01 --rounds 2 --case 1P1C,2P2C --only mutex,stilb-low-lock"),
	                 0);
	const char *words = last_words();
	assert_said(words,
	            "\nqueue: 8 runs of 0.01 s (4 pairs of a subject and a case, 2 rounds), of which 8 gave a result.\n");
	assert_said(words,
	            "\nStilb is at least as good as the best of the others in 1 of 2 comparisons; it is furthest behind in "
	            "1P1C, whose throughput is 8.00 Mops/s with stilb-low-lock and 10.0 Mops/s with mutex.\n");
	assert_said(words, "\nDifferences below 0 % are noise");
	assert_int_equal(copy_code(NULL, "queue --seconds 0.01 --rounds 1 --case 2P2C --only mutex,stilb-low-lock"), 0);
	assert_said(last_words(), "\nStilb is at least as good as the best of the others in the only comparison.\n"
	                          "No subject ran twice");
	assert_int_equal(copy_code(NULL, "queue --seconds 0.01 --rounds 1 --case 2P2C --only stilb-low-lock"), 0);
	assert_said(last_words(), "\nNothing but Stilb was measured in this run");
	assert_int_equal(copy_code(NULL, "queue --goals --seconds 0.01 --rounds 1 --case 2P2C --only stilb-low-lock"), 0);
	assert_said(run.out, "\ngoals, set on the CPU named in docs/benchmarks.md");
}

/* With both streams in one file, the line about a failure follows the tables and is a line of its own. */
static void test_streams_do_not_tear_each_other(void **state)
{
	(void)state;
	copy_bench();
	assert_int_equal(rename("stilb-bench", "real"), 0);
	write_program("stilb-bench", "exec ./real \"$@\" 2>&1");
	write_program("stilb-bench-queue-own", "echo broken >&2; exit 3");
	assert_int_equal(copy_code(NULL, "queue --seconds 0.01 --rounds 1 --case 1P1C --only mutex,stilb-low-lock"), 1);
	const char *table = strstr(run.out, "\n1P1C: "),
			   *failed = strstr(run.out, "\nstilb: stilb-low-lock in 1P1C: broken\n");
	const char *words = strstr(run.out, "\nqueue: ");
	assert_true(table && failed && words && table < failed && failed < words);
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

#define PLOTTED "queue --seconds 0.01 --rounds 1 --case 1P1C --only mutex --plot a.png"

/* gnuplot is a stand-in that writes a word into the file that the script names. */
static void test_pictures(void **state)
{
	(void)state;
	static const char *const nowhere[] = {"PATH=/nonexistent", NULL};
	assert_int_equal(stilb_code(nowhere, PLOTTED), 2);
	assert_error_lines(1);
	assert_said(run.err, "gnuplot-nox");

	char path[PATH_MAX + 32];
	snprintf(path, sizeof path, "PATH=%s:/usr/bin:/bin", stilb_folder);
	const char *const here[] = {path, NULL};
	write_program("gnuplot", "[ $1 = --version ] || echo drawn >$(sed -n \"s/^set output '\\(.*\\)'$/\\1/p\" $1)");
	assert_int_equal(stilb_code(here, PLOTTED), 0);
	char word[16] = "";
	FILE *picture = fopen("a.png", "r");
	assert_non_null(picture);
	assert_non_null(fgets(word, sizeof word, picture));
	fclose(picture);
	assert_string_equal(word, "drawn\n");
	write_program("gnuplot", "[ $1 = --version ]");
	assert_int_equal(stilb_code(here, PLOTTED), 1);
	assert_said(run.err, "stilb: cannot draw 'a.png': gnuplot failed");
}

static void test_what_is_not_built_is_named(void **state)
{
	(void)state;
	copy_program(stilb_path, "stilb-bench");
	assert_int_equal(copy_code(NULL, "queue --list"), 0);
	assert_said(run.out, "not built: needs libtbb-dev");
	assert_int_equal(copy_code(NULL, "queue --only tbb"), 2);
	assert_error_lines(1);
}

#define FRESH_TEST(name) cmocka_unit_test_setup(name, folder_fresh)

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		FRESH_TEST(test_help_and_list),
		FRESH_TEST(test_refusals),
		FRESH_TEST(test_small_run),
		FRESH_TEST(test_small_run_of_cull),
		FRESH_TEST(test_json_goes_where_it_is_told),
		FRESH_TEST(test_wrong_results_are_failures),
		FRESH_TEST(test_programs_that_hang_or_die),
		FRESH_TEST(test_three_sentences_at_the_end),
		FRESH_TEST(test_streams_do_not_tear_each_other),
		FRESH_TEST(test_pictures),
		FRESH_TEST(test_what_is_not_built_is_named),
	};
	if (argc != 3 || !realpath(argv[2], faulty_path) || !folder_enter(argv[1], "bench_cli")) {
		fprintf(stderr, "usage: test_bench_cli STILB-BENCH BENCH_FAULTY_QUEUE\n");
		return 2;
	}
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}
