/* The forms of a trace, written from snapshots made by hand and from recorded ones; and errors while writing.
 * test_prof_file.c has the files. */
#include "profiler/prof_read.h"
#include "profiler/write/prof_text.h"
#include "support/failing_memory.h"
#include "support/test.h"
#include "test_prof_capture.h"

#include <errno.h>
#include <math.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <time.h>
#include <unistd.h>

/* ---- a locale that writes another decimal point (the linker's --wrap) -------------------------------------------- */

static const char *decimal_point = ".";

int __wrap_snprintf(char *text, size_t size, const char *format, ...) __attribute__((format(printf, 3, 4)));

int __wrap_snprintf(char *text, size_t size, const char *format, ...)
{
	char printed[1024];
	va_list arguments;
	va_start(arguments, format);
	int length = vsnprintf(printed, sizeof printed, format, arguments);
	va_end(arguments);
	char *point = strchr(printed, '.');
	if (strcmp(decimal_point, ".") != 0 && point) {
		memmove(point + strlen(decimal_point), point + 1, strlen(point));
		memcpy(point, decimal_point, strlen(decimal_point));
		length += (int)strlen(decimal_point) - 1;
	}
	assert_true(length >= 0 && (size_t)length < sizeof printed && (size_t)length < size);
	memcpy(text, printed, (size_t)length + 1);
	return length;
}

/* ---- snapshots made by hand -------------------------------------------------------------------------------------- */

enum { FRAME, JOB, WAIT, DRAWS, GO, PASS, LABELS };

static const stilb_prof_label labels[LABELS] = {
	[FRAME] = {.name = "frame work", .function = "", .file = ""},
	[JOB] = {.name = "job", .function = "", .file = ""},
	[WAIT] = {.name = "wait;really", .function = "", .file = ""},
	[DRAWS] = {.name = "draws", .function = "", .file = ""},
	[GO] = {.name = "go", .function = "", .file = ""},
	[PASS] = {.name = "a, \"pass\"", .function = "", .file = ""},
};

#define ZONE(begin, end, self, l, p, n, f, lv)                                                                         \
	{                                                                                                                  \
		.begin_ns = begin, .end_ns = end, .self_ns = self, .label = l, .parent = p, .size = n, .frame = f, .level = lv \
	}
#define ROOT STILB_PROF_NONE

static const stilb_prof_zone main_zones[] = {
	ZONE(1000, 9000, 2000, FRAME, ROOT, 3, 0, 0),
	ZONE(1000, 4000, 3000, JOB, 0, 1, 0, 1),
	ZONE(5000, 8000, 3000, WAIT, 0, 1, 0, 1),
	ZONE(11000, 12500, 1500, FRAME, ROOT, 1, 1, 0),
};
static const stilb_prof_zone worker_zones[] = {
	ZONE(2500, 3500, 1000, JOB, ROOT, 1, 0, 0),
	{.begin_ns = 12000,
     .end_ns = 20000,
     .self_ns = 8000,
     .label = WAIT,
     .parent = ROOT,
     .size = 1,
     .frame = 1,
     .open = true},
};
static const stilb_prof_zone gpu_zones[] = {ZONE(3000, 6001, 3001, PASS, ROOT, 1, 0, 0)};
static const stilb_prof_switch main_switches[] = {{5500, 7500, false}, {7500, 7900, true}};
static const stilb_prof_lane lanes[] = {
	{.name = "main",
     .tid = 77,
     .zones = main_zones,
     .zone_count = 4,
     .switches = main_switches,
     .switch_count = 2,
     .switches_ns = 5000},
	{.name = "worker", .tid = 78, .zones = worker_zones, .zone_count = 2, .no_switches = "refused"},
	{.name = "GPU", .kind = STILB_PROF_LANE_DEVICE, .zones = gpu_zones, .zone_count = 1},
};
static const stilb_prof_point points[] = {
	{.ns = 1000, .value = 12, .label = DRAWS, .lane = 0, .counter = true},
	{.ns = 2000, .label = GO, .lane = 1},
	{.ns = 6000, .value = -0.125, .label = DRAWS, .lane = 0, .counter = true},
	{.ns = 11000, .value = 1e300, .label = DRAWS, .lane = 0, .counter = true},
	{.ns = 11500, .value = (double)NAN, .label = DRAWS, .lane = 0, .counter = true},
};
static const stilb_prof_flow flows[] = {
	{.id = 7, .from_ns = 900, .to_ns = 900, .from_lane = ROOT, .to_lane = 1, .label = JOB, .frame = ROOT},
	{.id = 9, .from_ns = 1500, .to_ns = 2600, .from_lane = 0, .to_lane = 1, .label = JOB, .frame = 0},
	{.id = 9, .from_ns = 1500, .to_ns = 2700, .from_lane = 0, .to_lane = 1, .label = JOB, .frame = 0},
	{.id = 8, .from_ns = 3000, .to_ns = 3000, .from_lane = 0, .to_lane = ROOT, .label = JOB, .frame = 0},
};
static const stilb_prof_frame frames[] = {{41, 500, 10000}, {42, 10000, 15000}};
static const stilb_prof_snapshot made = {
	.labels = labels,
	.lanes = lanes,
	.points = points,
	.flows = flows,
	.frames = frames,
	.label_count = LABELS,
	.lane_count = 3,
	.point_count = 5,
	.flow_count = 4,
	.frame_count = 2,
	.begin_ns = 500,
	.end_ns = 20000,
	.epoch_ns = 123456789,
	.clock = "rdtsc",
	.hz = 2596000000.4,
	.resolution_ns = 10.0154,
	.bias_ns = 20.5,
	.zone_cost_ns = 18.7,
	.events_recorded = 20,
	.events_lost = 7,
	.events_held = 13,
	.too_deep = 3,
	.without_ring = 2,
};

/* The whole text that is expected; %d stands for the pid. What touches the next zone is written a tenth of a nanosecond
 * shorter: the frames and the switches are, worker_zones are not. */
static const char made_text[] =
	"{\"displayTimeUnit\":\"ns\",\"traceEvents\":[\n"
	"{\"ph\":\"M\",\"pid\":%1$d,\"tid\":1,\"name\":\"process_name\",\"args\":{\"name\":\"made\"}},\n"
	"{\"ph\":\"M\",\"pid\":%1$d,\"tid\":1,\"name\":\"thread_sort_index\",\"args\":{\"sort_index\":1}},\n"
	"{\"ph\":\"M\",\"pid\":%1$d,\"tid\":1,\"name\":\"thread_name\",\"args\":{\"name\":\"frames\"}},\n"
	"{\"ph\":\"M\",\"pid\":%1$d,\"tid\":2,\"name\":\"thread_sort_index\",\"args\":{\"sort_index\":2}},\n"
	"{\"ph\":\"M\",\"pid\":%1$d,\"tid\":2,\"name\":\"thread_name\",\"args\":{\"name\":\"main\",\"tid\":77}},\n"
	"{\"ph\":\"M\",\"pid\":%1$d,\"tid\":3,\"name\":\"thread_sort_index\",\"args\":{\"sort_index\":3}},\n"
	"{\"ph\":\"M\",\"pid\":%1$d,\"tid\":3,\"name\":\"thread_name\",\"args\":{\"name\":\"main: off the CPU\","
	"\"switches_from\":5000}},\n"
	"{\"ph\":\"M\",\"pid\":%1$d,\"tid\":4,\"name\":\"thread_sort_index\",\"args\":{\"sort_index\":4}},\n"
	"{\"ph\":\"M\",\"pid\":%1$d,\"tid\":4,\"name\":\"thread_name\",\"args\":{\"name\":\"worker\",\"tid\":78,"
	"\"no_switches\":\"refused\"}},\n"
	"{\"ph\":\"M\",\"pid\":%1$d,\"tid\":6,\"name\":\"thread_sort_index\",\"args\":{\"sort_index\":6}},\n"
	"{\"ph\":\"M\",\"pid\":%1$d,\"tid\":6,\"name\":\"thread_name\",\"args\":{\"name\":\"GPU\",\"device\":true}},\n"
	"{\"ph\":\"X\",\"pid\":%1$d,\"tid\":1,\"ts\":0.500,\"dur\":9.4999,\"name\":\"frame\"},\n"
	"{\"ph\":\"i\",\"pid\":%1$d,\"tid\":1,\"ts\":0.500,\"s\":\"g\",\"name\":\"frame\",\"args\":{\"number\":41}},\n"
	"{\"ph\":\"X\",\"pid\":%1$d,\"tid\":1,\"ts\":10.000,\"dur\":5.000,\"name\":\"frame\"},\n"
	"{\"ph\":\"i\",\"pid\":%1$d,\"tid\":1,\"ts\":10.000,\"s\":\"g\",\"name\":\"frame\",\"args\":{\"number\":42}},\n"
	"{\"ph\":\"X\",\"pid\":%1$d,\"tid\":2,\"ts\":1.000,\"dur\":8.000,\"name\":\"frame work\"},\n"
	"{\"ph\":\"X\",\"pid\":%1$d,\"tid\":2,\"ts\":1.000,\"dur\":3.000,\"name\":\"job\"},\n"
	"{\"ph\":\"C\",\"pid\":%1$d,\"tid\":2,\"ts\":1.000,\"name\":\"draws\",\"args\":{\"value\":12}},\n"
	"{\"ph\":\"s\",\"pid\":%1$d,\"tid\":2,\"ts\":1.500,\"name\":\"job\",\"cat\":\"flow\",\"id\":2},\n"
	"{\"ph\":\"s\",\"pid\":%1$d,\"tid\":2,\"ts\":1.500,\"name\":\"job\",\"cat\":\"flow\",\"id\":3},\n"
	"{\"ph\":\"X\",\"pid\":%1$d,\"tid\":2,\"ts\":5.000,\"dur\":3.000,\"name\":\"wait;really\"},\n"
	"{\"ph\":\"C\",\"pid\":%1$d,\"tid\":2,\"ts\":6.000,\"name\":\"draws\",\"args\":{\"value\":-0.125}},\n"
	"{\"ph\":\"X\",\"pid\":%1$d,\"tid\":2,\"ts\":11.000,\"dur\":1.500,\"name\":\"frame work\"},\n"
	"{\"ph\":\"C\",\"pid\":%1$d,\"tid\":2,\"ts\":11.000,\"name\":\"draws\",\"args\":{\"value\":1e+300}},\n"
	"{\"ph\":\"X\",\"pid\":%1$d,\"tid\":3,\"ts\":5.500,\"dur\":1.9999,\"name\":\"sleeping\"},\n"
	"{\"ph\":\"X\",\"pid\":%1$d,\"tid\":3,\"ts\":7.500,\"dur\":0.400,\"name\":\"preempted\"},\n"
	"{\"ph\":\"i\",\"pid\":%1$d,\"tid\":4,\"ts\":2.000,\"name\":\"go\",\"s\":\"t\"},\n"
	"{\"ph\":\"X\",\"pid\":%1$d,\"tid\":4,\"ts\":2.500,\"dur\":1.000,\"name\":\"job\"},\n"
	"{\"ph\":\"f\",\"pid\":%1$d,\"tid\":4,\"ts\":2.600,\"name\":\"job\",\"cat\":\"flow\",\"id\":2,\"bp\":\"e\","
	"\"args\":{\"frame\":41}},\n"
	"{\"ph\":\"f\",\"pid\":%1$d,\"tid\":4,\"ts\":2.700,\"name\":\"job\",\"cat\":\"flow\",\"id\":3,\"bp\":\"e\","
	"\"args\":{\"frame\":41}},\n"
	"{\"ph\":\"B\",\"pid\":%1$d,\"tid\":4,\"ts\":12.000,\"name\":\"wait;really\"},\n"
	"{\"ph\":\"X\",\"pid\":%1$d,\"tid\":6,\"ts\":3.000,\"dur\":3.001,\"name\":\"a, \\\"pass\\\"\"}\n"
	"],\"otherData\":{\"clock\":\"rdtsc\",\"hz\":2596000000,\"resolution_ns\":10.015,\"bias_ns\":20.500,"
	"\"zone_cost_ns\":18.700,\"epoch_ns\":123456789,\"begin_ns\":500,\"end_ns\":20000,\"events_recorded\":20,"
	"\"events_lost\":7,\"events_held\":13,\"too_deep\":3,\"without_ring\":2,"
	"\"zones_written\":7,\"flows_cut\":2}}\n";

static stilb_prof_sink sink_of(capture *c)
{
	return (stilb_prof_sink){capture_write, c};
}

static void a_made_snapshot_as_chrome_json(void **state)
{
	(void)state;
	char *expected = NULL;
	capture c = {0};
	assert_int_equal(stilb_prof_trace_write_chrome(&made, "made", sink_of(&c)), 0);
	assert_true(asprintf(&expected, made_text, (int)getpid()) > 0);
	assert_string_equal(c.text, expected);
	if (trace_check_text(c.text, c.size, &c.report) != 0)
		fail_msg("%s", c.report.error);
	assert_int_equal(c.report.threads, 3);
	assert_int_equal(c.report.zones, 7);
	assert_int_equal(c.report.open_zones, 1);
	assert_int_equal(c.report.frames + c.report.marks, 4);
	assert_int_equal(c.report.counters, 3);
	assert_int_equal(c.report.instants, 1);
	assert_int_equal(c.report.flows, 2);
	assert_int_equal(c.report.flow_ends_outside, 0);
	assert_int_equal(c.report.switches, 2);
	capture_finish(&c);
	free(expected);
}

static void a_made_snapshot_as_folded_stacks(void **state)
{
	(void)state;
	capture c = {0};
	assert_int_equal(stilb_prof_trace_write_folded(&made, sink_of(&c)), 0);
	assert_string_equal(c.text, "main;frame work 3500\n"
	                            "main;frame work;job 3000\n"
	                            "main;frame work;wait,really 3000\n"
	                            "worker;job 1000\n"
	                            "worker;wait,really 8000\n"
	                            "GPU;a, \"pass\" 3001\n");
	capture_finish(&c);
}

/* A zone nested in zones of its own name: one line for each depth. */
static void recursion_is_a_line_for_each_depth(void **state)
{
	(void)state;
	enum { DEPTH = 300 };
	static stilb_prof_zone zones[DEPTH];
	for (uint32_t i = 0; i < DEPTH; i++)
		zones[i] =
			(stilb_prof_zone)ZONE(i, 2 * DEPTH - i, 2, JOB, i - 1, DEPTH - i, ROOT, (uint16_t)i); /* ROOT is -1 */
	stilb_prof_lane lane = {.name = "main", .zones = zones, .zone_count = DEPTH};
	stilb_prof_snapshot s = made;
	s.lanes = &lane;
	s.lane_count = 1;
	capture c = {0};
	assert_int_equal(stilb_prof_trace_write_folded(&s, sink_of(&c)), 0);
	const char *line = c.text;
	for (size_t i = 0; i < DEPTH; i++, line = strchr(line, '\n') + 1)
		assert_int_equal(strcspn(line, "\n"), strlen("main") + (i + 1) * strlen(";job") + strlen(" 2"));
	assert_int_equal(*line, 0);
	capture_finish(&c);
}

/* Each zone around two of other names, 11 deep. */
static uint32_t fill_tree(stilb_prof_zone *zones, uint32_t at, uint32_t parent, uint16_t level)
{
	uint32_t first = at++;
	for (uint32_t i = 0; level < 10 && i < 2; i++)
		at = fill_tree(zones, at, first, level + 1);
	zones[first] = (stilb_prof_zone){.self_ns = 1, .parent = parent, .size = at - first, .frame = ROOT, .level = level};
	return at;
}

static void every_stack_has_its_line(void **state)
{
	(void)state;
	enum { ZONES = (1 << 11) - 1 };
	static stilb_prof_zone zones[ZONES];
	assert_int_equal(fill_tree(zones, 0, ROOT, 0), ZONES);
	for (uint32_t i = 1; i < ZONES; i++) /* of two siblings the first comes right after their parent in the array */
		zones[i].label = zones[i].parent == i - 1 ? JOB : WAIT;
	stilb_prof_lane lane = {.name = "main", .zones = zones, .zone_count = ZONES};
	stilb_prof_snapshot s = made;
	s.lanes = &lane;
	s.lane_count = 1;
	capture c = {0};
	assert_int_equal(stilb_prof_trace_write_folded(&s, sink_of(&c)), 0);
	uint32_t lines = 0;
	for (const char *line = c.text; *line != 0; line = strchr(line, '\n') + 1, lines++) {
		uint32_t names = 0;
		for (size_t i = 0; line[i] != '\n'; i++)
			names += line[i] == ';';
		assert_int_equal(names, zones[lines].level + 1);
	}
	assert_int_equal(lines, ZONES);
	capture_finish(&c);
}

static void a_made_snapshot_as_csv(void **state)
{
	(void)state;
	capture c = {0};
	assert_int_equal(stilb_prof_trace_write_frames_csv(&made, sink_of(&c)), 0);
	assert_string_equal(c.text,
	                    "frame,begin_ms,ms,\"frame work\",\"job\",\"wait;really\",\"a, \"\"pass\"\"\",\"draws\"\r\n"
	                    "41,0.000500,0.009500,0.008000,0.004000,0.003000,0.003001,-0.125\r\n"
	                    "42,0.010000,0.005000,0.001500,0.000000,0.008000,0.000000,1e+300\r\n");
	capture_finish(&c);
}

/* A zone inside another of its name is not added again; but if it is charged to another frame, as in a job, it counts
 * in that frame. */
static void recursion_counts_once_in_csv(void **state)
{
	(void)state;
	stilb_prof_zone zones[] = {
		ZONE(1000, 9000, 4000, JOB, ROOT, 3, 0, 0),
		ZONE(2000, 6000, 1000, WAIT, 0, 2, 0, 1),
		ZONE(3000, 6000, 3000, JOB, 1, 1, 0, 2),
		ZONE(9000, 9500, 500, JOB, ROOT, 1, 0, 0),
	};
	stilb_prof_lane lane = {.name = "main", .zones = zones, .zone_count = 4};
	stilb_prof_snapshot s = made;
	s.lanes = &lane;
	s.lane_count = s.frame_count = 1;
	s.point_count = s.flow_count = 0;
	capture c = {0};
	assert_int_equal(stilb_prof_trace_write_frames_csv(&s, sink_of(&c)), 0);
	assert_string_equal(c.text, "frame,begin_ms,ms,\"job\",\"wait;really\"\r\n"
	                            "41,0.000500,0.009500,0.008500,0.004000\r\n");
	capture_finish(&c);
}

static void an_empty_snapshot_is_a_file(void **state)
{
	(void)state;
	stilb_prof_snapshot empty = {.clock = "rdtsc", .hz = 1};
	capture c = {0};
	assert_int_equal(stilb_prof_trace_write_chrome(&empty, "empty", sink_of(&c)), 0);
	if (trace_check_text(c.text, c.size, &c.report) != 0)
		fail_msg("%s", c.report.error);
	assert_int_equal(c.report.zones + c.report.threads + c.report.frames, 0);
	capture_finish(&c);
	assert_int_equal(stilb_prof_trace_write_folded(&empty, sink_of(&c)), 0);
	assert_int_equal(c.size, 0);
	assert_int_equal(stilb_prof_trace_write_frames_csv(&empty, sink_of(&c)), 0);
	assert_string_equal(c.text, "frame,begin_ms,ms\r\n");
	capture_finish(&c);
}

/* ---- ends that touch --------------------------------------------------------------------------------------------- */

/* A time as a reader rounds it: to the nearest nanosecond. */
static uint64_t rounded_ns(const char *text, const char *key)
{
	const char *at = strstr(text, key);
	assert_non_null(at);
	return (uint64_t)llround(strtod(at + strlen(key), NULL) * 1000);
}

/* The end of a zone as viewers compute it: the sum of two doubles. */
static double end_us(const char *line)
{
	return strtod(strstr(line, "\"ts\":") + 5, NULL) + strtod(strstr(line, "\"dur\":") + 6, NULL);
}

#define TOUCHING 6

static void ends_that_touch_stay_apart_and_exact(void **state)
{
	(void)state;
	/* a(b(c(d))): all four end when the next zone begins; and a zone without length at its parent's end. */
	uint64_t t = UINT64_C(86400000000123); /* about a day, in ns: doubles of microseconds are coarse there */
	stilb_prof_zone zones[TOUCHING] = {
		ZONE(t, t + 50, 20, JOB, ROOT, 4, 0, 0),     ZONE(t + 20, t + 50, 10, WAIT, 0, 3, 0, 1),
		ZONE(t + 30, t + 50, 20, JOB, 1, 2, 0, 2),   ZONE(t + 50, t + 50, 0, JOB, 2, 1, 0, 3),
		ZONE(t + 50, t + 51, 1, JOB, ROOT, 1, 0, 0), ZONE(t + 51, t + 51, 0, JOB, ROOT, 1, 0, 0),
	};
	stilb_prof_lane lane = {.name = "main", .zones = zones, .zone_count = TOUCHING};
	stilb_prof_snapshot s = made;
	s.lanes = &lane;
	s.lane_count = 1;
	s.point_count = s.flow_count = s.frame_count = 0;
	s.end_ns = t + 100;
	capture c = {0};
	assert_int_equal(stilb_prof_trace_write_chrome(&s, "touching", sink_of(&c)), 0);
	if (trace_check_text(c.text, c.size, &c.report) != 0)
		fail_msg("%s", c.report.error);
	const char *line = strstr(c.text, "{\"ph\":\"X\"");
	double ends[TOUCHING];
	for (int i = 0; i < TOUCHING; i++, line = strstr(line + 1, "{\"ph\":\"X\"")) {
		uint64_t begin = rounded_ns(line, "\"ts\":");
		assert_int_equal(begin, zones[i].begin_ns);
		assert_int_equal(begin + rounded_ns(line, "\"dur\":"), zones[i].end_ns);
		ends[i] = end_us(line);
	}
	assert_true(ends[2] < ends[1] && ends[1] < ends[0]);
	assert_non_null(strstr(c.text, "\"dur\":0.0001,")); /* of the last zone: speedscope leaves out zones of length 0 */
	assert_true(ends[0] < (double)(t + 50) / 1000);
	capture_finish(&c);
}

/* ---- what is recorded, as text ----------------------------------------------------------------------------------- */

static int begin_thread(void **state)
{
	(void)state;
	return stilb_prof_thread_begin("main");
}

static int shut_down(void **state)
{
	(void)state;
	fail_allocation = -1;
	stilb_prof_shutdown();
	return 0;
}

STILB_PROF_SITE(site_a, "a", 0);
STILB_PROF_SITE(site_odd, "a\"b\\c/\b\f\n\r\t\x1f \xe2\x82\xac", 0);
STILB_PROF_SITE(site_bad, "bad\xff|\xc0\x80|\xed\xa0\x80|\xf5|\xe2\x82", 0);
STILB_PROF_FLOW(flow_job, "job flow", 0);

static void everything_recorded_is_written(void **state)
{
	(void)state;
	capture c;
	for (int i = 0; i < 5; i++) {
		stilb_prof_frame_mark();
		PROFILE("outer");
		PROFILE_COUNTER("i", i);
		PROFILE_INSTANT("now");
		uint64_t id = stilb_prof_flow_begin(flow_job);
		PROFILE_BEGIN("one");
		stilb_prof_flow_end(flow_job, id);
		PROFILE_NEXT("two");
		PROFILE_NEXT("three");
		PROFILE_END();
	}
	PROFILE("open");
	assert_int_not_equal(stilb_prof_flow_begin(flow_job), 0); /* a flow that never ends: no arrow is written */
	assert_trace(&c, 0);
	assert_int_equal(c.report.zones, 21);
	assert_int_equal(c.report.open_zones, 1);
	assert_int_equal(c.report.frames, 4);
	assert_int_equal(c.report.marks, 4);
	assert_int_equal(c.report.counters, 5);
	assert_int_equal(c.report.instants, 5);
	assert_int_equal(c.report.flows, 5);
	assert_int_equal(c.report.flow_ends_outside, 0);
	assert_int_equal(trace_check_zones(&c.report, "main", "three"), 5);
	capture_finish(&c);
	assert_trace(&c, 2);
	assert_int_equal(c.report.frames, 2);
	assert_int_equal(trace_check_zones(&c.report, "main", "three"), 3);
	capture_finish(&c);
}

static uint64_t random_state = 1;

static uint64_t random_below(uint64_t limit)
{
	random_state = random_state * 6364136223846793005u + 1442695040888963407u;
	return (random_state >> 33) % limit;
}

/* A random tree in the order of its ends. Half of all steps between its times are 0, in ticks and so in ns. */
typedef struct random_tree {
	uint64_t step;
	uint32_t depths;
	bool lasting; /* zones that have children are longer than 0 */
	int left;     /* number of zones that are still to be made */
} random_tree;

static uint64_t record_tree(random_tree *tree, uint64_t t, uint32_t depth)
{
	uint64_t begin = t + tree->step * random_below(2);
	int left = tree->left;
	t = begin;
	while (tree->left > 0 && depth + 1 < tree->depths && random_below(8) < 6) {
		tree->left--;
		t = record_tree(tree, t, depth + 1);
	}
	t += tree->step * (tree->lasting && t == begin && tree->left < left ? 1 : random_below(2));
	stilb_prof_write(stilb_prof_thread_ring, &site_a, begin, depth, t - begin);
	return t;
}

static int record_trees(random_tree tree)
{
	uint64_t t = prof_clock_now();
	int zones = tree.left;
	for (; tree.left > 0; zones++)
		t = record_tree(&tree, t, 0);
	return zones;
}

static void random_trees_keep_every_rule(void **state)
{
	(void)state;
	int zones = record_trees((random_tree){.step = 1, .depths = STILB_PROF_DEPTH_MAX, .left = 30000});
	capture c;
	assert_trace(&c, 0);
	assert_int_equal(c.report.zones, zones);
	capture_finish(&c);
}

static void overlaps_keep_every_rule(void **state)
{
	(void)state;
	uint64_t t = prof_clock_now();
	for (int i = 0; i < 20000; i++)
		stilb_prof_write(stilb_prof_thread_ring, &site_a, t + random_below(5000), random_below(20), random_below(5000));
	capture c;
	assert_trace(&c, 0);
	assert_int_equal(c.report.zones, 20000);
	capture_finish(&c);
}

static void names_are_escaped(void **state)
{
	(void)state;
	capture c;
	stilb_prof_thread_end();
	assert_int_equal(stilb_prof_thread_begin("\"t\"\\\t\n\x01\x7f \xc3\xa4 \xf0\x9f\x90\x9f"), 0);
	stilb_prof_zone_begin(&site_odd);
	stilb_prof_zone_end();
	stilb_prof_zone_begin(&site_bad);
	stilb_prof_zone_end();
	assert_trace(&c, 0);
	assert_int_equal(trace_check_zones(&c.report, "\"t\"\\\t\n\x01\x7f \xc3\xa4 \xf0\x9f\x90\x9f",
	                                   "a\"b\\c/\b\f\n\r\t\x1f \xe2\x82\xac"),
	                 1);
#define BAD "\xef\xbf\xbd"
	assert_int_equal(trace_check_zones(&c.report, NULL, "bad" BAD "|" BAD BAD "|" BAD BAD BAD "|" BAD "|" BAD BAD), 1);
	capture_finish(&c);
}

static void the_process_has_a_name(void **state)
{
	(void)state;
	capture c = {0};
	assert_int_equal(stilb_prof_trace_write_chrome(&made, NULL, sink_of(&c)), 0);
	assert_non_null(strstr(c.text, "\"process_name\",\"args\":{\"name\":\"test_prof_trace\"}"));
	capture_finish(&c);
	assert_int_equal(stilb_prof_trace_write_chrome(&made, "\"quoted\"", sink_of(&c)), 0);
	assert_non_null(strstr(c.text, "\"process_name\",\"args\":{\"name\":\"\\\"quoted\\\"\"}"));
	capture_finish(&c);
}

static void the_locale_changes_nothing(void **state)
{
	(void)state;
	static const char *const points_of_locales[] = {",", "\xd9\xab"}; /* U+066B */
	for (size_t i = 0; i < 2; i++) {
		capture c = {0};
		decimal_point = points_of_locales[i];
		assert_int_equal(stilb_prof_trace_write_chrome(&made, "made", sink_of(&c)), 0);
		decimal_point = ".";
		assert_non_null(strstr(c.text, "{\"value\":-0.125}"));
		capture_finish(&c);
	}
}

/* ---- read back by prof_read.h ------------------------------------------------------------------------------------ */

static void assert_same_label(const stilb_prof_snapshot *a, uint32_t i, const stilb_prof_snapshot *b, uint32_t k)
{
	assert_true(i < a->label_count && k < b->label_count);
	assert_string_equal(a->labels[i].name, b->labels[k].name);
}

static uint64_t frame_number(const stilb_prof_snapshot *s, uint32_t frame)
{
	return frame != STILB_PROF_NONE ? s->frames[frame].number : UINT64_MAX;
}

static void assert_same_lane(const stilb_prof_snapshot *a, const stilb_prof_snapshot *b, uint32_t lane)
{
	const stilb_prof_lane *x = &a->lanes[lane], *y = &b->lanes[lane];
	assert_string_equal(x->name, y->name);
	assert_int_equal(x->kind, y->kind);
	assert_int_equal(x->tid, y->tid);
	assert_int_equal(!x->no_switches, !y->no_switches);
	assert_int_equal(x->zone_count, y->zone_count);
	for (uint32_t i = 0; i < x->zone_count; i++) {
		const stilb_prof_zone *p = &x->zones[i], *q = &y->zones[i];
		assert_same_label(a, p->label, b, q->label);
		assert_int_equal(p->begin_ns, q->begin_ns);
		assert_int_equal(p->end_ns, q->end_ns);
		assert_int_equal(p->self_ns, q->self_ns);
		assert_int_equal(p->off_cpu_ns, q->off_cpu_ns);
		assert_int_equal(p->parent, q->parent);
		assert_int_equal(p->size, q->size);
		assert_int_equal(p->level, q->level);
		assert_int_equal(p->open, q->open);
		assert_int_equal(frame_number(a, p->frame), frame_number(b, q->frame));
	}
	assert_int_equal(x->switch_count, y->switch_count);
	for (uint32_t i = 0; i < x->switch_count; i++) {
		assert_int_equal(x->switches[i].out_ns, y->switches[i].out_ns);
		assert_int_equal(x->switches[i].in_ns, y->switches[i].in_ns);
		assert_int_equal(x->switches[i].preempted, y->switches[i].preempted);
	}
}

static void assert_same_flows(const stilb_prof_snapshot *a, const stilb_prof_snapshot *b)
{
	assert_int_equal(a->flow_count, b->flow_count);
	for (uint32_t i = 0; i < a->flow_count; i++) {
		const stilb_prof_flow *p = &a->flows[i], *q = &b->flows[i];
		assert_int_equal(p->from_ns, q->from_ns);
		assert_int_equal(p->to_ns, q->to_ns);
		assert_int_equal(p->from_lane, q->from_lane);
		assert_int_equal(p->to_lane, q->to_lane);
		assert_same_label(a, p->label, b, q->label);
		assert_int_equal(frame_number(a, p->frame), frame_number(b, q->frame));
	}
}

static void assert_same(const stilb_prof_snapshot *a, const stilb_prof_snapshot *b)
{
	assert_int_equal(a->lane_count, b->lane_count);
	for (uint32_t i = 0; i < a->lane_count; i++)
		assert_same_lane(a, b, i);
	assert_int_equal(a->frame_count, b->frame_count);
	for (uint32_t i = 0; i < a->frame_count; i++)
		assert_memory_equal(&a->frames[i], &b->frames[i], sizeof a->frames[i]);
	assert_int_equal(a->point_count, b->point_count);
	for (uint32_t i = 0; i < a->point_count; i++) {
		const stilb_prof_point *p = &a->points[i], *q = &b->points[i];
		assert_true(p->ns == q->ns && p->value == q->value && p->lane == q->lane && p->counter == q->counter);
		assert_same_label(a, p->label, b, q->label);
	}
	assert_same_flows(a, b);
	assert_int_equal(a->begin_ns, b->begin_ns);
	assert_int_equal(a->end_ns, b->end_ns);
	assert_int_equal(a->epoch_ns, b->epoch_ns);
	assert_string_equal(a->clock, b->clock);
	assert_int_equal(a->events_recorded, b->events_recorded);
	assert_int_equal(a->events_lost, b->events_lost);
	assert_int_equal(a->events_held, b->events_held);
	assert_int_equal(a->too_deep, b->too_deep);
	assert_int_equal(a->without_ring, b->without_ring);
}

static void assert_reads_back(const stilb_prof_snapshot *s)
{
	char error[256] = "";
	stilb_prof_snapshot back = {0};
	capture c = {0};
	assert_int_equal(stilb_prof_trace_write_chrome(s, "test", sink_of(&c)), 0);
	if (trace_check_text(c.text, c.size, &c.report) != 0)
		fail_msg("%s", c.report.error);
	if (stilb_prof_trace_parse(c.text, c.size, "memory", &back, error, sizeof error) != 0)
		fail_msg("%s", error);
	assert_same(s, &back);
	stilb_prof_snapshot_finish(&back);
	capture_finish(&c);
}

/* Two threads, jobs from one to the other, zones that touch, a device, all kinds of points, a sleep, an open zone. */
static void *run_jobs(void *ids)
{
	const uint64_t *id = ids;
	stilb_prof_thread_begin("worker");
	for (int i = 0; i < 200; i++) {
		PROFILE("job");
		stilb_prof_flow_end(flow_job, id[199 - i]);
		PROFILE_COUNTER("load", i / 3.0);
		PROFILE("inside");
		PROFILE_NEXT("next");
		if (i == 100)
			nanosleep(&(struct timespec){.tv_nsec = 2000000}, NULL);
	}
	stilb_prof_thread_end();
	return NULL;
}

static void record_everything(void)
{
	uint64_t ids[200];
	pthread_t thread;
	stilb_prof_lane_handle *gpu;
	assert_int_equal(stilb_prof_lane_create("GPU", &gpu), 0);
	for (int i = 0; i < 200; i++) {
		if (i % 10 == 0)
			stilb_prof_frame_mark();
		PROFILE("submit");
		ids[i] = stilb_prof_flow_begin(flow_job);
		PROFILE_INSTANT("submitted");
		uint64_t now = stilb_prof_clock_monotonic();
		stilb_prof_lane_zone(gpu, &site_a, 0, now - 100, now);
	}
	stilb_prof_frame_mark();
	assert_int_equal(pthread_create(&thread, NULL, run_jobs, ids), 0);
	pthread_join(thread, NULL);
	stilb_prof_frame_mark();
	stilb_prof_lane_destroy(gpu);
}

static void what_is_written_reads_back(void **state)
{
	(void)state;
	stilb_prof_snapshot s = {0};
	stilb_prof_switches_set(true);
	record_everything();
	stilb_prof_switches_set(false);
	PROFILE("open");
	assert_int_equal(stilb_prof_snapshot_take(&s, NULL), 0);
	assert_int_equal(s.lane_count, 3);
	assert_int_equal(s.flow_count, 200);
	assert_reads_back(&s);
	stilb_prof_snapshot_finish(&s);
}

/* Random trees are read back exactly: with the steps that the clock really has, and four levels, since tenths of
 * nanoseconds tell no more levels apart (prof_trace.h). Zones that have children are longer than 0, since a file does
 * not say which of two zones of length 0 at the same time lies in the other. */
static void random_trees_read_back(void **state)
{
	(void)state;
	stilb_prof_snapshot s = {0};
	record_trees((random_tree){.step = 26, .depths = 4, .lasting = true, .left = 30000});
	assert_int_equal(stilb_prof_snapshot_take(&s, NULL), 0);
	assert_reads_back(&s);
	stilb_prof_snapshot_finish(&s);
}

/* ---- errors ------------------------------------------------------------------------------------------------------ */

typedef int writer(const stilb_prof_snapshot *snapshot, stilb_prof_sink sink);

static int write_chrome(const stilb_prof_snapshot *snapshot, stilb_prof_sink sink)
{
	return stilb_prof_trace_write_chrome(snapshot, "test", sink);
}

static writer *const writers[] = {write_chrome, stilb_prof_trace_write_folded, stilb_prof_trace_write_frames_csv};

typedef struct full_disk {
	int room; /* number of calls of write that still succeed */
	int after_error;
	size_t longest; /* bytes of the longest piece written */
} full_disk;

static int full_disk_write(void *user, const void *data, size_t size)
{
	full_disk *disk = user;
	(void)data;
	disk->longest = size > disk->longest ? size : disk->longest;
	if (disk->room < 0)
		disk->after_error++;
	return disk->room-- > 0 ? 0 : -ENOSPC;
}

static void a_failed_write_is_returned(void **state)
{
	(void)state;
	stilb_prof_snapshot s = {0};
	int blocks = 0;
	for (int i = 0; i < 1000; i++) {
		stilb_prof_frame_mark();
		for (int k = 0; k < 10; k++) {
			PROFILE("a zone with a name that makes the trace longer than one block, and so that it needs many of them");
		}
	}
	assert_int_equal(stilb_prof_snapshot_take(&s, NULL), 0);
	for (;; blocks++) {
		full_disk disk = {.room = blocks};
		int error = stilb_prof_trace_write_chrome(&s, NULL, (stilb_prof_sink){full_disk_write, &disk});
		if (error == 0) {
			assert_int_equal(disk.room, 0); /* all calls succeeded */
			assert_in_range(disk.longest, PROF_TEXT_SIZE / 2, PROF_TEXT_SIZE);
			break;
		}
		assert_int_equal(error, -ENOSPC);
		assert_int_equal(disk.after_error, 0);
	}
	assert_true(blocks > 3);
	for (size_t i = 0; i < 3; i++) {
		full_disk disk = {0};
		assert_int_equal(writers[i](&s, (stilb_prof_sink){full_disk_write, &disk}), -ENOSPC);
		assert_int_equal(disk.after_error, 0);
	}
	stilb_prof_snapshot_finish(&s);
}

typedef struct pieces {
	size_t sizes[4], count;
} pieces;

static int count_piece(void *user, const void *data, size_t size)
{
	pieces *all = user;
	(void)data;
	all->sizes[all->count++] = size;
	return 0;
}

static void blocks_are_filled(void **state)
{
	(void)state;
	static const char zeros[2 * PROF_TEXT_SIZE];
	pieces all = {0};
	prof_text *text = prof_text_create((stilb_prof_sink){count_piece, &all});
	prof_text_bytes(text, zeros, PROF_TEXT_SIZE - 10);
	prof_text_bytes(text, zeros, 11);
	prof_text_bytes(text, zeros, PROF_TEXT_SIZE - 1);
	assert_int_equal(prof_text_finish(text, 0), 0);
	assert_int_equal(all.count, 2);
	assert_int_equal(all.sizes[0], PROF_TEXT_SIZE);
	assert_int_equal(all.sizes[1], PROF_TEXT_SIZE);
}

static void no_memory(void **state)
{
	(void)state;
	for (size_t i = 0; i < 3; i++) {
		int failures = 0;
		for (;; failures++) {
			full_disk disk = {.room = 1000};
			fail_allocation = failures;
			int error = writers[i](&made, (stilb_prof_sink){full_disk_write, &disk});
			bool failed = fail_allocation < 0;
			fail_allocation = -1;
			if (!failed)
				break;
			assert_int_equal(error, -ENOMEM);
		}
		assert_true(failures >= 4);
	}
}

#define TRACE_TEST(f) cmocka_unit_test_setup_teardown(f, begin_thread, shut_down)

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_made_snapshot_as_chrome_json),
		cmocka_unit_test(a_made_snapshot_as_folded_stacks),
		cmocka_unit_test(recursion_is_a_line_for_each_depth),
		cmocka_unit_test(every_stack_has_its_line),
		cmocka_unit_test(a_made_snapshot_as_csv),
		cmocka_unit_test(recursion_counts_once_in_csv),
		cmocka_unit_test(an_empty_snapshot_is_a_file),
		cmocka_unit_test(ends_that_touch_stay_apart_and_exact),
		TRACE_TEST(everything_recorded_is_written),
		TRACE_TEST(random_trees_keep_every_rule),
		TRACE_TEST(overlaps_keep_every_rule),
		TRACE_TEST(names_are_escaped),
		TRACE_TEST(what_is_written_reads_back),
		TRACE_TEST(random_trees_read_back),
		cmocka_unit_test(the_process_has_a_name),
		cmocka_unit_test(the_locale_changes_nothing),
		TRACE_TEST(a_failed_write_is_returned),
		cmocka_unit_test(blocks_are_filled),
		cmocka_unit_test(no_memory),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
