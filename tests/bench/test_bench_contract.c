/* Breaks the contracts of the benchmark harness (bench/harness) on purpose, and expects the assertion that names each:
 * unsound tables of suites, wrong options, wrong rows, wrong calls to run a child process. */
#include "support/test.h"

#include "support/contract.h"

#include "bench/harness/bench_internal.h"

static const bench_metric metrics[] = {{"p50", "ns", true, NULL}};
static const bench_metric spaced_metrics[] = {{"p 50", "ns", true, NULL}};
static const bench_case cases[] = {{.name = "one", .title = "one", .metrics = metrics, .metric_count = 1},
                                   {.name = "two", .title = "two", .metrics = metrics, .metric_count = 1}};
static const bench_subject subjects[] = {{.name = "stilb", .program = "stilb-bench-none"},
                                         {.name = "other", .program = "stilb-bench-none"}};
static const char *const panel_cases[] = {"one", "two", NULL};
static const bench_panel panels[] = {{"panel", panel_cases, "p50", false}};
static const bench_suite sound = {.name = "sound",
                                  .help = "a suite",
                                  .subjects = subjects,
                                  .subject_count = 2,
                                  .cases = cases,
                                  .case_count = 2,
                                  .panels = panels,
                                  .panel_count = 1};
static const bench_options options = {.rounds = 1, .seconds = 0.1, .give_up = 1};

static int run_suite(bench_suite suite)
{
	bench_options list = options;
	list.list = true;
	return bench_run(&suite, &list);
}

static void test_sound_suite(void **state)
{
	(void)state;
	assert_int_equal(run_suite(sound), 0);
}

static void test_unsound_suites(void **state)
{
	(void)state;
	static const char *const unknown_cases[] = {"one", "three", NULL};
	static const bench_panel unknown_case = {"panel", unknown_cases, "p50", false};
	static const bench_panel unknown_metric = {"panel", panel_cases, "p99", false};
	static const bench_case same_cases[] = {{.name = "one", .title = "one", .metrics = metrics, .metric_count = 1},
	                                        {.name = "one", .title = "two", .metrics = metrics, .metric_count = 1}};
	static const bench_case no_metric = {.name = "one", .title = "one"};
	static const bench_case spaced = {.name = "one", .title = "one", .metrics = spaced_metrics, .metric_count = 1};
	static const bench_subject path = {.name = "stilb", .program = "../stilb-bench-none"};
	bench_suite suite = sound;
	suite.panels = &unknown_case;
	contract_breaks("suite_is_sound(suite)", run_suite(suite));
	suite.panels = &unknown_metric;
	contract_breaks("suite_is_sound(suite)", run_suite(suite));
	suite = sound;
	suite.panel_count = 0;
	suite.cases = same_cases;
	contract_breaks("suite_is_sound(suite)", run_suite(suite));
	suite.cases = &no_metric;
	suite.case_count = 1;
	contract_breaks("suite_is_sound(suite)", run_suite(suite));
	suite.cases = &spaced;
	contract_breaks("suite_is_sound(suite)", run_suite(suite));
	suite = sound;
	suite.subjects = &path;
	suite.subject_count = 1;
	contract_breaks("suite_is_sound(suite)", run_suite(suite));
	suite = sound;
	suite.report_alone = true;
	contract_breaks("suite_is_sound(suite)", run_suite(suite));
}

static void test_options(void **state)
{
	(void)state;
	bench_options wrong = options;
	wrong.rounds = 0;
	contract_breaks("options->rounds >= 1", bench_run(&sound, &wrong));
	wrong = options;
	wrong.seconds = 0.0;
	contract_breaks("only --quick chooses the length", bench_run(&sound, &wrong));
	wrong = options;
	wrong.traces = "folder";
	contract_breaks("the suite's programs write timelines", bench_run(&sound, &wrong));
	contract_breaks("suite && options", bench_run(NULL, &options));
}

static void test_rows(void **state)
{
	(void)state;
	bench_results results = {.suite = &sound, .options = &options};
	assert_int_equal(bench_add_row(&results, &cases[0], &subjects[0], &metrics[0]), STILB_OK);
	contract_breaks("the round has begun", (bench_set_value(&results, &cases[0], &subjects[0], "p50", 0, 1.0), 0));
	results.rounds = 1;
	bench_set_value(&results, &cases[0], &subjects[0], "p50", 0, 1.0);
	bench_summarise(&results);
	const bench_row *row = bench_find(&results, "one", "stilb", "p50");
	assert_non_null(row);
	assert_true(row->median == 1.0);
	contract_breaks("rows are added before the first round",
	                bench_add_row(&results, &cases[1], &subjects[0], &metrics[0]));
	contract_breaks("a case and a subject, or neither", !bench_find(&results, "one", NULL, "p50"));
	bench_row rate = *row;
	rate.unit = "Mops/s";
	contract_breaks("strcmp(limit->unit, \"ns\") == 0", bench_of_limit(row, &rate) > 0.0);
	contract_breaks("numerator && denominator && ratio", bench_paired_ratio(&results, row, NULL, &(bench_ratio){0}));
	free((double *)results.rows[0].values);
	free(results.rows);
}

static void test_child(void **state)
{
	(void)state;
	bench_child_result result;
	bench_limit limit = {1.0, 1.0}, none = {0.0, 1.0};
	bench_child_run("stilb-bench-none", "stilb", "one", 0.1, 0, NULL, limit, &result);
	assert_int_equal(result.state, BENCH_CHILD_FAILED);
	assert_non_null(strstr(result.message, "stilb-bench-none is not in the folder"));
	contract_breaks("strchr(program, '/')", (bench_child_run("/bin/true", "a", "b", 0.1, 0, NULL, limit, &result), 0));
	contract_breaks("limit.cpu_seconds > 0.0", (bench_child_run("true", "a", "b", 0.1, 0, NULL, none, &result), 0));
	contract_breaks("seconds >= 0.0", (bench_child_run("true", "a", "b", -1.0, 0, NULL, limit, &result), 0));
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_sound_suite), cmocka_unit_test(test_unsound_suites), cmocka_unit_test(test_options),
		cmocka_unit_test(test_rows),        cmocka_unit_test(test_child),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
