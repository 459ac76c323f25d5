/* The checker of traces: a good trace passes, and each rule fails when it is broken. */
#include "support/test.h"
#include "support/trace_check.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

static const char *program; /* trace_check */

static const char good[] =
	"{\"displayTimeUnit\":\"ns\",\"traceEvents\":[\n"
	"{\"ph\":\"M\",\"pid\":7,\"tid\":1,\"name\":\"process_name\",\"args\":{\"name\":\"good\"}},\n"
	"{\"ph\":\"M\",\"pid\":7,\"tid\":1,\"name\":\"thread_name\",\"args\":{\"name\":\"frames\"}},\n"
	"{\"ph\":\"M\",\"pid\":7,\"tid\":1,\"name\":\"thread_sort_index\",\"args\":{\"sort_index\":1}},\n"
	"{\"ph\":\"M\",\"pid\":7,\"tid\":2,\"name\":\"thread_name\",\"args\":{\"name\":\"main\"}},\n"
	"{\"ph\":\"M\",\"pid\":7,\"tid\":2,\"name\":\"thread_sort_index\",\"args\":{\"sort_index\":2}},\n"
	"{\"ph\":\"M\",\"pid\":7,\"tid\":3,\"name\":\"thread_name\",\"args\":{\"name\":\"main: off the CPU\"}},\n"
	"{\"ph\":\"M\",\"pid\":7,\"tid\":3,\"name\":\"thread_sort_index\",\"args\":{\"sort_index\":3}},\n"
	"{\"ph\":\"M\",\"pid\":7,\"tid\":4,\"name\":\"thread_name\",\"args\":{\"name\":\"worker\"}},\n"
	"{\"ph\":\"M\",\"pid\":7,\"tid\":4,\"name\":\"thread_sort_index\",\"args\":{\"sort_index\":4}},\n"
	"{\"ph\":\"X\",\"pid\":7,\"tid\":1,\"ts\":0.000,\"dur\":9.9999,\"name\":\"frame\"},\n"
	"{\"ph\":\"i\",\"pid\":7,\"tid\":1,\"ts\":0.000,\"s\":\"g\",\"name\":\"frame\",\"args\":{\"number\":0}},\n"
	"{\"ph\":\"X\",\"pid\":7,\"tid\":1,\"ts\":10.000,\"dur\":5.000,\"name\":\"frame\"},\n"
	"{\"ph\":\"X\",\"pid\":7,\"tid\":2,\"ts\":1.000,\"dur\":6.500,\"name\":\"parent\"},\n"
	"{\"ph\":\"X\",\"pid\":7,\"tid\":2,\"ts\":1.000,\"dur\":1.9999,\"name\":\"child\"},\n"
	"{\"ph\":\"C\",\"pid\":7,\"tid\":2,\"ts\":1.000,\"name\":\"draws\",\"args\":{\"value\":-1.5e3}},\n"
	"{\"ph\":\"s\",\"pid\":7,\"tid\":2,\"ts\":2.000,\"name\":\"arrow\",\"cat\":\"flow\",\"id\":1},\n"
	"{\"ph\":\"s\",\"pid\":7,\"tid\":2,\"ts\":2.500,\"name\":\"other\",\"cat\":\"flow\",\"id\":2},\n"
	"{\"ph\":\"X\",\"pid\":7,\"tid\":2,\"ts\":3.000,\"dur\":0.000,\"name\":\"child\"},\n"
	"{\"ph\":\"X\",\"pid\":7,\"tid\":2,\"ts\":3.000,\"dur\":4.4999,\"name\":\"last\"},\n"
	"{\"ph\":\"B\",\"pid\":7,\"tid\":2,\"ts\":8.000,\"name\":\"closed\"},\n"
	"{\"ph\":\"X\",\"pid\":7,\"tid\":2,\"ts\":8.000,\"dur\":0.001,\"name\":\"child\"},\n"
	"{\"ph\":\"E\",\"pid\":7,\"tid\":2,\"ts\":9.000,\"name\":\"closed\"},\n"
	"{\"ph\":\"i\",\"pid\":7,\"tid\":4,\"ts\":1.000,\"s\":\"t\",\"name\":\"go\"},\n"
	"{\"ph\":\"f\",\"pid\":7,\"tid\":4,\"ts\":2.750,\"name\":\"arrow\",\"cat\":\"flow\",\"id\":1,\"bp\":\"e\"},\n"
	"{\"ph\":\"f\",\"pid\":7,\"tid\":4,\"ts\":2.800,\"name\":\"other\",\"cat\":\"flow\",\"id\":2,\"bp\":\"e\"},\n"
	"{\"ph\":\"X\",\"pid\":7,\"tid\":3,\"ts\":3.000,\"dur\":0.9999,\"name\":\"sleeping\"},\n"
	"{\"ph\":\"X\",\"pid\":7,\"tid\":3,\"ts\":4.000,\"dur\":0.500,\"name\":\"preempted\"},\n"
	"{\"ph\":\"B\",\"pid\":7,\"tid\":2,\"ts\":9.000,\"name\":\"open\"}\n"
	"],\"otherData\":{\"clock\":\"rdtsc\",\"hz\":2596000000,\"resolution_ns\":10.015,\"bias_ns\":20.500,"
	"\"zone_cost_ns\":18.700,\"epoch_ns\":1,\"begin_ns\":0,\"end_ns\":20000,\"events_recorded\":9,\"events_lost\":3,"
	"\"events_held\":6,\"too_deep\":0,\"without_ring\":0,\"zones_written\":7}}\n";

static void the_good_trace_passes(void **state)
{
	(void)state;
	trace_check_report report;
	if (trace_check_text(good, sizeof good - 1, &report) != 0)
		fail_msg("%s", report.error);
	assert_int_equal(report.zones, 7);
	assert_int_equal(report.open_zones, 1);
	assert_int_equal(report.frames, 2);
	assert_int_equal(report.marks, 1);
	assert_int_equal(report.threads, 2);
	assert_int_equal(report.counters, 1);
	assert_int_equal(report.instants, 1);
	assert_int_equal(report.flows, 2);
	assert_int_equal(report.flow_ends_outside, 2); /* the f events: no zone is around them */
	assert_int_equal(report.switches, 2);
	assert_int_equal(report.events_recorded, 9);
	assert_int_equal(report.events_lost, 3);
	assert_int_equal(trace_check_zones(&report, "main", "child"), 3);
	assert_int_equal(trace_check_zones(&report, NULL, "parent"), 1);
	assert_int_equal(trace_check_zones(&report, "main", NULL), 7);
	assert_int_equal(trace_check_zones(&report, "frames", NULL), 0);
	trace_check_finish(&report);
}

/* One change to the good trace, and what the checker must say. */
typedef struct breach {
	const char *from, *to, *says;
} breach;

static const breach breaches[] = {
	/* JSON */
	{"}}\n", "}} {}", "something after the end"},
	{"}}\n", "}", "',' or '}' expected"},
	{"\"name\":\"open\"}\n]", "\"name\":\"open\"},\n]", "'{' expected"},
	{"\"name\":\"open\"}\n]", "\"name\":\"open\",}\n]", "a string expected"},
	{"\"name\":\"open\"}\n]", "\"name\":\"open\"}\n}", "',' or ']' expected"},
	{"\"name\":\"last\"", "\"name\" \"last\"", "':' expected"},
	{"\"name\":\"last\"", "\"name\":last", "a string expected"},
	{"\"name\":\"last\"", "\"x\":nil,\"name\":\"last\"", "a value expected"},
	{"\"name\":\"last\"", "\"name\":\"la\nst\"", "line 20: control byte"},
	{"\"name\":\"last\"", "\"name\":\"\\x\"", "unknown escape"},
	{"\"name\":\"last\"", "\"name\":\"\\u12g4\"", "four hex digits"},
	{"\"name\":\"last\"", "\"name\":\"\\ud83d\"", "first half of a surrogate"},
	{"\"name\":\"last\"", "\"name\":\"\\ud83d\\u0041\"", "first half of a surrogate"},
	{"\"name\":\"last\"", "\"name\":\"\\udc1f\"", "second half of a surrogate"},
	{"\"name\":\"last\"", "\"name\":\"\\u0000\"", "\\u0000"},
	{"\"name\":\"last\"", "\"name\":\"\xff\"", "not UTF-8"},
	{"\"name\":\"last\"", "\"name\":\"\xc0\x80\"", "not UTF-8"},
	{"\"name\":\"last\"", "\"name\":\"\xe0\x80\x80\"", "not UTF-8"},
	{"\"name\":\"last\"", "\"name\":\"\xed\xa0\x80\"", "not UTF-8"},
	{"\"name\":\"last\"", "\"name\":\"\xf4\x90\x80\x80\"", "not UTF-8"},
	{"\"name\":\"last\"", "\"name\":\"\xe2\x82\"", "not UTF-8"},
	{"\"name\":\"last\"", "\"name\":\"last\",\"name\":\"last\"", "key \"name\" twice"},
	{"\"name\":\"last\"", "\"name\":\"last\",\"x\":01", "a number expected"},
	{"\"name\":\"last\"", "\"name\":\"last\",\"x\":1.", "digits expected after the point"},
	{"\"name\":\"last\"", "\"name\":\"last\",\"x\":1e", "digits expected in the exponent"},
	{"\"name\":\"last\"", "\"name\":\"last\",\"x\":+1", "a value expected"},
	{"\"ts\":8.000,\"dur\":0.001", "\"ts\":8,000,\"dur\":0,001", "a string expected"}, /* a decimal comma */
	/* members of the outermost object */
	{"\"displayTimeUnit\":\"ns\"", "\"displayTimeUnit\":\"ms\"", "displayTimeUnit"},
	{"\"displayTimeUnit\"", "\"displaytimeunit\"", "displayTimeUnit"},
	{"\"traceEvents\"", "\"events\"", "no traceEvents"},
	{"\"otherData\"", "\"metadata\"", "no otherData"},
	/* keys of events */
	{"{\"ph\":\"X\",\"pid\":7,\"tid\":2,\"ts\":1.000", "{\"pid\":7,\"tid\":2,\"ts\":1.000", "event without ph"},
	{"\"ph\":\"i\"", "\"ph\":\"Q\"", "unknown ph"},
	{",\"name\":\"last\"", "", "event without name"},
	{"\"pid\":7,\"tid\":2,\"ts\":3.000", "\"tid\":2,\"ts\":3.000", "without an integer pid"},
	{"\"pid\":7,\"tid\":2,\"ts\":3.000", "\"pid\":7.5,\"tid\":2,\"ts\":3.000", "without an integer pid"},
	{"\"tid\":2,\"ts\":3.000", "\"ts\":3.000", "without an integer tid"},
	{"\"args\":{\"name\":\"main\"}", "\"x\":0", "M event without args"},
	{"\"ts\":3.000,", "", "without a ts"},
	{"\"ts\":3.000", "\"ts\":3.00", "three decimals"},
	{"\"ts\":3.000", "\"ts\":3.0000", "three decimals"},
	{"\"ts\":3.000", "\"ts\":3.00001", "three decimals"},
	{"\"ts\":3.000", "\"ts\":3", "three decimals"},
	{"\"ts\":3.000", "\"ts\":-3.000", "three decimals"},
	{"\"dur\":4.4999,", "", "without a dur"},
	{"\"dur\":4.4999", "\"dur\":4.5", "three decimals"},
	{"\"dur\":4.4999", "\"dur\":-4.500", "three decimals"},
	{"\"s\":\"g\",", "", "without s \"g\""},
	{"\"s\":\"g\"", "\"s\":\"p\"", "without s \"g\""},
	{"\"args\":{\"value\":-1.5e3}", "\"args\":{}", "without a number args.value"},
	{"\"value\":-1.5e3", "\"value\":\"many\"", "a number expected"},
	{"\"cat\":\"flow\",\"id\":1}", "\"id\":1}", "s event without cat"},
	{"\"cat\":\"flow\",\"id\":1}", "\"cat\":\"flow\"}", "s event without cat and an integer id"},
	{"\"id\":1,\"bp\"", "\"id\":1.5,\"bp\"", "f event without cat and an integer id"},
	{",\"bp\":\"e\"", "", "without bp \"e\""},
	{"\"bp\":\"e\"", "\"bp\":\"s\"", "without bp \"e\""},
	/* pid, tid and names of threads */
	{"\"pid\":7,\"tid\":2,\"ts\":9.000,\"name\":\"open\"", "\"pid\":8,\"tid\":2,\"ts\":9.000,\"name\":\"open\"",
     "a second process"},
	{"\"process_name\"", "\"process_labels\"", "no process_name"},
	{"{\"name\":\"good\"}", "{}", "process_name without"},
	{"{\"name\":\"main\"}", "{}", "thread_name without"},
	{"{\"sort_index\":2}", "{}", "thread_sort_index without"},
	{"\"tid\":2,\"name\":\"thread_name\"", "\"tid\":1,\"name\":\"thread_name\"", "a second one of tid 1"},
	{"\"tid\":2,\"name\":\"thread_sort_index\"", "\"tid\":1,\"name\":\"thread_sort_index\"", "a second one of tid 1"},
	{"\"tid\":2,\"name\":\"thread_name\"", "\"tid\":2,\"name\":\"thread_label\"", "tid 2 without a thread_name"},
	{"\"tid\":2,\"name\":\"thread_sort_index\"", "\"tid\":2,\"name\":\"x\"", "tid 2 without a thread_sort_index"},
	{"{\"name\":\"frames\"}", "{\"name\":\"pictures\"}", "not one thread \"frames\" but 0"},
	{"{\"name\":\"worker\"}", "{\"name\":\"frames\"}", "not one thread \"frames\" but 2"},
	/* order and nesting */
	{"\"ts\":3.000,\"dur\":4.4999", "\"ts\":2.999,\"dur\":0.001", "ts goes back on tid 2"},
	{"\"ts\":1.000,\"dur\":6.500", "\"ts\":1.000,\"dur\":1.500", "parent \"child\" after its child \"parent\""},
	{"\"ts\":3.000,\"dur\":4.4999", "\"ts\":3.000,\"dur\":4.5001", "\"last\" sticks out of \"parent\""},
	{"\"dur\":6.500", "\"dur\":7.500", "\"closed\" sticks out of \"parent\""},
	{"\"ts\":8.000,\"dur\":0.001", "\"ts\":8.000,\"dur\":2.001", "E while \"child\" is open"},
	{"\"ts\":9.000,\"name\":\"closed\"", "\"ts\":9.000,\"name\":\"other\"", "E of \"other\" while \"closed\""},
	{"{\"ph\":\"B\",\"pid\":7,\"tid\":2,\"ts\":8.000", "{\"ph\":\"X\",\"pid\":7,\"tid\":2,\"dur\":0.100,\"ts\":8.000",
     "E without a B"},
	{"\"ts\":3.000,\"dur\":4.4999", "\"ts\":3.000,\"dur\":5.500", "\"last\" sticks out of \"parent\""},
	{"\"ts\":3.000,\"dur\":4.4999", "\"ts\":3.000,\"dur\":4.500", "\"last\" touches the end of its parent \"parent\""},
	{"\"dur\":1.9999", "\"dur\":2.000", "the end of \"child\" touches \"child\""},
	{"\"dur\":9.9999", "\"dur\":10.000", "the end of \"frame\" touches \"frame\""},
	{"\"ts\":0.000,\"dur\":9.9999", "\"ts\":0.000,\"dur\":10.001", "frames overlap"},
	{"\"dur\":0.9999", "\"dur\":1.0001", "times off the CPU overlap"},
	{"\"name\":\"sleeping\"", "\"name\":\"zone\"", "\"zone\" on an off-CPU thread"},
	{"main: off the CPU", "worker: off the CPU", "does not follow its thread"},
	{"\"s\":\"g\"", "\"s\":\"t\"", "i on the thread \"frames\""},
	{"{\"ph\":\"i\",\"pid\":7,\"tid\":4", "{\"ph\":\"i\",\"pid\":7,\"tid\":3", "i on the thread \"main: off the CPU\""},
	{"{\"ph\":\"C\",\"pid\":7,\"tid\":2", "{\"ph\":\"C\",\"pid\":7,\"tid\":3", "C on the thread \"main: off the CPU\""},
	/* arrows */
	{"\"id\":2}", "\"id\":1}", "a second s of flow 1"},
	{"\"id\":2}", "\"id\":0}", "not a number from 1 on"},
	{"\"id\":2}", "\"id\":999}", "not a number from 1 on"},
	{"\"id\":2}", "\"id\":3}", "f without an s"},
	{"\"id\":2,\"bp\"", "\"id\":3,\"bp\"", "s without an f"},
	{"\"arrow\",\"cat\":\"flow\",\"id\":1,", "\"bow\",\"cat\":\"flow\",\"id\":1,", "another name or cat"},
	{"\"ts\":2.750", "\"ts\":1.750", "flow 1 goes back in time"},
	{"\"dur\":5.000,\"name\":\"frame\"", "\"dur\":5.000,\"name\":\"zone\"", "\"zone\" on the thread \"frames\""},
	{"{\"ph\":\"i\",\"pid\":7,\"tid\":1", "{\"ph\":\"i\",\"pid\":7,\"tid\":2", "mark on a thread other than"},
	/* the numbers in otherData */
	{"\"clock\":\"rdtsc\",", "", "without clock"},
	{"\"hz\":2596000000,", "", "without hz"},
	{"\"hz\":2596000000", "\"hz\":0", "hz is 0"},
	{"\"resolution_ns\":10.015,", "", "without resolution_ns"},
	{"\"bias_ns\":20.500", "\"bias_ns\":-1", "bias_ns, or it is negative"},
	{"\"zone_cost_ns\":18.700,", "", "without zone_cost_ns"},
	{"\"epoch_ns\":1,", "", "without epoch_ns"},
	{"\"too_deep\":0,", "", "without too_deep"},
	{"\"without_ring\":0,", "", "without without_ring"},
	{"\"begin_ns\":0", "\"begin_ns\":20001", "without a window"},
	{"\"events_held\":6,", "", "without the accounts"},
	{"\"events_lost\":3", "\"events_lost\":2", "do not add up"},
	{"\"events_recorded\":9,\"events_lost\":3,\"events_held\":6",
     "\"events_recorded\":7,\"events_lost\":3,\"events_held\":4", "do not add up"},
	{"\"zones_written\":7", "\"zones_written\":6", "7 zones, but zones_written is 6"},
};

/* The good trace with the first occurrence of from replaced by to; the caller frees it. */
static char *broken_trace(const breach *b)
{
	const char *at = strstr(good, b->from);
	char *text = malloc(sizeof good + strlen(b->to));
	assert_non_null(at);
	assert_non_null(text);
	sprintf(text, "%.*s%s%s", (int)(at - good), good, b->to, at + strlen(b->from));
	return text;
}

static void each_rule_fails(void **state)
{
	(void)state;
	for (size_t i = 0; i < sizeof breaches / sizeof breaches[0]; i++) {
		trace_check_report report;
		char *text = broken_trace(&breaches[i]);
		int result = trace_check_text(text, strlen(text), &report);
		if (result != -1 || !strstr(report.error, breaches[i].says))
			fail_msg("%s -> %s: \"%s\" instead of \"%s\"", breaches[i].from, breaches[i].to, report.error,
			         breaches[i].says);
		trace_check_finish(&report);
		free(text);
	}
}

/* No proper prefix of the trace is a trace, and none makes the checker read beyond its end. */
static void each_beginning_fails(void **state)
{
	(void)state;
	for (size_t size = 0; size < sizeof good - 2; size++) { /* the last byte is white space */
		trace_check_report report;
		char *text = malloc(size + 1);
		assert_non_null(text);
		memcpy(text, good, size);
		text = realloc(text, size > 0 ? size : 1); /* no terminating zero: the address sanitizer guards the end */
		assert_int_equal(trace_check_text(text, size, &report), -1);
		assert_true(report.error[0] != 0);
		trace_check_finish(&report);
		free(text);
	}
}

static void deep_nesting_fails(void **state)
{
	(void)state;
	trace_check_report report;
	char text[100000];
	memset(text, '[', sizeof text);
	memcpy(text, "{\"x\":", 5);
	assert_int_equal(trace_check_text(text, sizeof text, &report), -1);
	assert_non_null(strstr(report.error, "nested too deep"));
	trace_check_finish(&report);
}

/* ---- the program ------------------------------------------------------------------------------------------------- */

static int run_program(const char *argument)
{
	int status = -1;
	pid_t child = fork();
	if (child == 0) {
		if (freopen("/dev/null", "w", stdout) && freopen("/dev/null", "w", stderr))
			execl(program, program, argument, (char *)NULL);
		_exit(99);
	}
	assert_int_equal(waitpid(child, &status, 0), child);
	return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

static void write_file(const char *path, const char *text)
{
	FILE *file = fopen(path, "wb");
	assert_non_null(file);
	assert_true(fputs(text, file) >= 0);
	assert_int_equal(fclose(file), 0);
}

static void the_program_says_it_by_its_status(void **state)
{
	(void)state;
	char path[] = "test_prof_check_XXXXXX";
	int descriptor = mkstemp(path);
	assert_true(descriptor >= 0);
	close(descriptor);
	write_file(path, good);
	assert_int_equal(run_program(path), 0);
	char *text = broken_trace(&breaches[0]);
	write_file(path, text);
	free(text);
	assert_int_equal(run_program(path), 1);
	assert_int_equal(remove(path), 0);
	assert_int_equal(run_program(path), 1); /* no such file */
	assert_int_equal(run_program(NULL), 1); /* no argument */
}

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_good_trace_passes),
		cmocka_unit_test(each_rule_fails),
		cmocka_unit_test(each_beginning_fails),
		cmocka_unit_test(deep_nesting_fails),
		cmocka_unit_test(the_program_says_it_by_its_status),
	};
	program = argc > 1 ? argv[1] : "trace_check";
	return cmocka_run_group_tests(tests, NULL, NULL);
}
