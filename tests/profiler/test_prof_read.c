/* Trace files: what the writer wrote comes back exactly, other programs' are understood, bad ones get an error. */
#include "profiler/prof_read.h"

#include "profiler/prof_trace.h"
#include "support/failing_memory.h"
#include "support/prof_made.h"
#include "support/test.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stddef.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

/* ---- traces in memory -------------------------------------------------------------------------------------------- */

typedef struct bytes {
	char *text;
	size_t size;
} bytes;

static int bytes_write(void *user, const void *data, size_t size)
{
	bytes *b = user;
	b->text = realloc(b->text, b->size + size);
	assert_non_null(b->text);
	memcpy(b->text + b->size, data, size);
	b->size += size;
	return 0;
}

static bytes written(const stilb_prof_snapshot *snapshot)
{
	bytes b = {0};
	assert_int_equal(stilb_prof_trace_write_chrome(snapshot, "test", (stilb_prof_sink){bytes_write, &b}), 0);
	return b;
}

/* Reads a trace from a block of exactly that size, so that the address sanitizer sees reads beyond its end. */
static int parse_bytes(const char *text, size_t size, stilb_prof_snapshot *snapshot, char error[256])
{
	char *copy = malloc(size > 0 ? size : 1);
	assert_non_null(copy);
	memcpy(copy, text, size);
	error[0] = '\0';
	int result = stilb_prof_trace_parse(copy, size, "a.json", snapshot, error, 256);
	free(copy);
	if (result == 0)
		assert_true(made_holds(snapshot));
	else
		assert_true(!snapshot->memory && snapshot->lane_count == 0 && error[0] != '\0');
	return result;
}

static void parse(const char *text, stilb_prof_snapshot *snapshot)
{
	char error[256];
	if (parse_bytes(text, strlen(text), snapshot, error) != 0)
		fail_msg("%s", error);
}

/* ---- there and back ---------------------------------------------------------------------------------------------- */

static void assert_same_lane(const stilb_prof_snapshot *s, const stilb_prof_lane *a, const stilb_prof_snapshot *t,
                             const stilb_prof_lane *b)
{
	assert_string_equal(a->name, b->name);
	assert_int_equal(a->kind, b->kind);
	assert_int_equal(a->tid, b->tid);
	assert_int_equal(a->zone_count, b->zone_count);
	assert_int_equal(a->switch_count, b->switch_count);
	assert_int_equal(!a->no_switches, !b->no_switches);
	assert_int_equal(a->switches_ns, b->switches_ns);
	if (a->no_switches)
		assert_string_equal(a->no_switches, b->no_switches);
	for (uint32_t i = 0; i < a->zone_count; i++) {
		const stilb_prof_zone *x = &a->zones[i], *y = &b->zones[i];
		if (x->begin_ns != y->begin_ns || x->end_ns != y->end_ns || x->parent != y->parent || x->size != y->size ||
		    x->level != y->level || x->self_ns != y->self_ns || x->off_cpu_ns != y->off_cpu_ns ||
		    x->frame != y->frame || x->open != y->open ||
		    strcmp(s->labels[x->label].name, t->labels[y->label].name) != 0)
			fail_msg("zone %u of %s: %" PRIu64 "..%" PRIu64 " parent %d size %u self %" PRIu64 " off %" PRIu64
			         " frame %d, read back %" PRIu64 "..%" PRIu64 " parent %d size %u self %" PRIu64 " off %" PRIu64
			         " frame %d",
			         i, a->name, x->begin_ns, x->end_ns, (int)x->parent, x->size, x->self_ns, x->off_cpu_ns,
			         (int)x->frame, y->begin_ns, y->end_ns, (int)y->parent, y->size, y->self_ns, y->off_cpu_ns,
			         (int)y->frame);
	}
	for (uint32_t i = 0; i < a->switch_count; i++) {
		assert_true(a->switches[i].out_ns == b->switches[i].out_ns && a->switches[i].in_ns == b->switches[i].in_ns);
		assert_int_equal(a->switches[i].preempted, b->switches[i].preempted);
	}
}

static void assert_same(const stilb_prof_snapshot *a, const stilb_prof_snapshot *b)
{
	assert_int_equal(a->lane_count, b->lane_count);
	assert_int_equal(a->frame_count, b->frame_count);
	assert_int_equal(a->point_count, b->point_count);
	assert_int_equal(a->flow_count, b->flow_count);
	assert_true(a->begin_ns == b->begin_ns && a->end_ns == b->end_ns && a->epoch_ns == b->epoch_ns);
	assert_string_equal(a->clock, b->clock);
	assert_true(a->hz == b->hz && a->resolution_ns == b->resolution_ns && a->bias_ns == b->bias_ns &&
	            a->zone_cost_ns == b->zone_cost_ns);
	assert_true(a->events_recorded == b->events_recorded && a->events_lost == b->events_lost &&
	            a->events_held == b->events_held && a->too_deep == b->too_deep && a->without_ring == b->without_ring);
	for (uint32_t i = 0; i < a->lane_count; i++)
		assert_same_lane(a, &a->lanes[i], b, &b->lanes[i]);
	for (uint32_t i = 0; i < a->frame_count; i++)
		assert_memory_equal(&a->frames[i], &b->frames[i], sizeof *a->frames);
	for (uint32_t i = 0; i < a->point_count; i++) {
		const stilb_prof_point *x = &a->points[i], *y = &b->points[i];
		assert_true(x->ns == y->ns && x->value == y->value && x->lane == y->lane && x->counter == y->counter);
		assert_string_equal(a->labels[x->label].name, b->labels[y->label].name);
	}
	for (uint32_t i = 0; i < a->flow_count; i++) {
		const stilb_prof_flow *x = &a->flows[i], *y = &b->flows[i];
		assert_true(x->from_ns == y->from_ns && x->to_ns == y->to_ns && x->from_lane == y->from_lane &&
		            x->to_lane == y->to_lane && x->frame == y->frame && x->id == y->id);
	}
}

static void what_was_written_comes_back(void **state)
{
	(void)state;
	char error[256];
	stilb_prof_snapshot back = {0};
	for (uint64_t seed = 0; seed < (TEST_ASAN || TEST_EMULATED ? 80 : 300); seed++) {
		made m;
		made_by_chance(&m, seed);
		assert_true(made_holds(&m.snapshot));
		bytes b = written(&m.snapshot);
		if (parse_bytes(b.text, b.size, &back, error) != 0)
			fail_msg("seed %" PRIu64 ": %s", seed, error);
		assert_same(&m.snapshot, &back);
		free(b.text);
		made_finish(&m);
	}
	stilb_prof_snapshot_finish(&back);
}

/* A snapshot that was recorded, not made by hand: zones, counters, instants and arrows of this process. Several of its
 * labels may have the same name. */
static void what_was_recorded_comes_back(void **state)
{
	(void)state;
	char error[256];
	stilb_prof_snapshot taken = {0}, back = {0};
	STILB_PROF_FLOW(arrow, "arrow", 0);
	assert_int_equal(stilb_prof_thread_begin("main"), 0);
	for (int i = 0; i < 50; i++) {
		stilb_prof_frame_mark();
		PROFILE("outer");
		uint64_t id = stilb_prof_flow_begin(arrow);
		for (int k = 0; k < 20; k++) {
			PROFILE("inner");
			PROFILE_COUNTER("counter", i + k / 4.0);
		}
		PROFILE_INSTANT("instant");
		stilb_prof_flow_end(arrow, id);
	}
	assert_int_equal(stilb_prof_snapshot_take(&taken, NULL), 0);
	stilb_prof_shutdown();
	assert_true(taken.lanes[0].zone_count >= 50 * 21 - 21 && taken.flow_count > 40 && taken.point_count > 1000);
	bytes b = written(&taken);
	assert_int_equal(parse_bytes(b.text, b.size, &back, error), 0);
	taken.hz = back.hz; /* written with three decimals */
	taken.resolution_ns = back.resolution_ns;
	taken.bias_ns = back.bias_ns;
	taken.zone_cost_ns = back.zone_cost_ns;
	for (uint32_t i = 0; i < taken.flow_count; i++) /* the writer numbers arrows anew */
		((stilb_prof_flow *)taken.flows)[i].id = back.flows[i].id;
	assert_same(&taken, &back);
	free(b.text);
	stilb_prof_snapshot_finish(&taken);
	stilb_prof_snapshot_finish(&back);
}

static void open_zones_stay_open(void **state)
{
	(void)state;
	char error[256];
	made m;
	stilb_prof_snapshot back = {0};
	made_init(&m, 1);
	made_push(&m, 0, 0, 100);
	made_push(&m, 0, 1, 200);
	made_pop(&m, 0, 300);
	made_push(&m, 0, 2, 300);
	made_pop(&m, 0, 500);
	made_pop(&m, 0, 500);
	m.zones[0][0].open = m.zones[0][2].open = true;
	m.snapshot.begin_ns = 50;
	m.snapshot.end_ns = 500;
	made_derive(&m);
	bytes b = written(&m.snapshot);
	assert_int_equal(parse_bytes(b.text, b.size, &back, error), 0);
	assert_same(&m.snapshot, &back);
	free(b.text);
	made_finish(&m);
	stilb_prof_snapshot_finish(&back);
}

/* ---- numbers ----------------------------------------------------------------------------------------------------- */

static const struct {
	const char *text;
	uint64_t ns;
} times[] = {
	{"0", 0},
	{"-0", 0},
	{"1", 1000},
	{"1.5", 1500},
	{"0.001", 1},
	{"12345678.901", 12345678901},
	{"1.9999", 2000},
	{"1.9995", 2000},
	{"1.9994", 1999},
	{"1.99949999999", 1999},
	{"1.000499999999999999999999999999999999999999", 1000},
	{"0.0004", 0},
	{"0.0005", 1},
	{"00001.5", 1500},
	{"1e3", 1000000},
	{"1.5E+3", 1500000},
	{"1234567e-6", 1235},
	{"123456789012.345", 123456789012345},
	{"1732200000123456.789", 1732200000123456789},
	{"1732200000123456789e-3", 1732200000123456789},
	{"0e999999999999", 0},
	{"1e-999999999999", 0},
	{"0.0000000000000000000000000000000001e34", 1000},
};

static void times_are_exact(void **state)
{
	(void)state;
	stilb_prof_snapshot s = {0};
	char text[256];
	for (size_t i = 0; i < sizeof times / sizeof *times; i++) {
		snprintf(text, sizeof text, "[{\"ph\":\"X\",\"ts\":%s,\"dur\":0},{\"ph\":\"X\",\"ts\":0,\"dur\":%s}]",
		         times[i].text, times[i].text);
		parse(text, &s);
		assert_int_equal(s.lanes[0].zone_count, 2);
		if (s.end_ns != times[i].ns)
			fail_msg("%s: %" PRIu64, times[i].text, s.end_ns);
		assert_true(s.lanes[0].zones[1].begin_ns == times[i].ns || s.lanes[0].zones[0].begin_ns == times[i].ns);
	}
	stilb_prof_snapshot_finish(&s);
}

static void times_before_zero_are_shifted(void **state)
{
	(void)state;
	stilb_prof_snapshot s = {0};
	parse("[{\"ph\":\"X\",\"ts\":-2.5,\"dur\":1},{\"ph\":\"X\",\"ts\":-1.0004,\"dur\":1.0004},{\"ph\":\"i\",\"ts\":3}]",
	      &s);
	assert_int_equal(s.lanes[0].zones[0].begin_ns, 0);
	assert_int_equal(s.lanes[0].zones[0].end_ns, 1000);
	assert_int_equal(s.lanes[0].zones[1].begin_ns, 1500);
	assert_int_equal(s.lanes[0].zones[1].end_ns, 2500);
	assert_int_equal(s.points[0].ns, 5500);
	stilb_prof_snapshot_finish(&s);
}

static void values_are_doubles(void **state)
{
	(void)state;
	static const char *const values[] = {"0",     "-1",        "17179869184",        "0.1",
	                                     "1e308", "-4.9e-324", "123456789012345678", "1e400"};
	stilb_prof_snapshot s = {0};
	char text[128];
	for (size_t i = 0; i < sizeof values / sizeof *values; i++) {
		snprintf(text, sizeof text, "[{\"ph\":\"C\",\"name\":\"c\",\"ts\":1,\"args\":{\"value\":%s}}]", values[i]);
		parse(text, &s);
		assert_true(s.points[0].value == strtod(values[i], NULL));
		assert_int_equal(s.points[0].lane, STILB_PROF_NONE);
	}
	stilb_prof_snapshot_finish(&s);
}

/* ---- other programs' files --------------------------------------------------------------------------------------- */

static void assert_zone(const stilb_prof_snapshot *s, uint32_t lane, uint32_t zone, const char *name, uint64_t begin_ns,
                        uint64_t end_ns, uint32_t level)
{
	assert_true(lane < s->lane_count && zone < s->lanes[lane].zone_count);
	const stilb_prof_zone *z = &s->lanes[lane].zones[zone];
	assert_string_equal(s->labels[z->label].name, name);
	assert_int_equal(z->begin_ns, begin_ns);
	assert_int_equal(z->end_ns, end_ns);
	assert_int_equal(z->level, level);
}

static void begins_and_ends(void **state)
{
	(void)state;
	stilb_prof_snapshot s = {0};
	parse("[{\"ph\":\"E\",\"ts\":0},"
	      "{\"name\":\"a\",\"ph\":\"B\",\"ts\":1,\"pid\":1,\"tid\":7},"
	      "{\"name\":\"b\",\"ph\":\"B\",\"ts\":2,\"pid\":1,\"tid\":7},"
	      "{\"name\":\"c\",\"ph\":\"X\",\"ts\":2.5,\"dur\":0.25,\"pid\":1,\"tid\":7},"
	      "{\"ph\":\"E\",\"ts\":3,\"pid\":1,\"tid\":7},"
	      "{\"name\":\"d\",\"ph\":\"B\",\"ts\":3,\"pid\":1,\"tid\":7},"
	      "{\"name\":\"late\",\"ph\":\"i\",\"ts\":9,\"pid\":1,\"tid\":7},",
	      &s);
	assert_int_equal(s.lane_count, 1);
	assert_string_equal(s.lanes[0].name, "thread 7");
	assert_int_equal(s.lanes[0].zone_count, 4);
	assert_zone(&s, 0, 0, "a", 1000, 9000, 0);
	assert_zone(&s, 0, 1, "b", 2000, 3000, 1);
	assert_zone(&s, 0, 2, "c", 2500, 2750, 2);
	assert_zone(&s, 0, 3, "d", 3000, 9000, 1);
	assert_true(s.lanes[0].zones[0].open && !s.lanes[0].zones[1].open && s.lanes[0].zones[3].open);
	assert_int_equal(s.lanes[0].zones[0].self_ns, 8000 - 1000 - 6000);
	stilb_prof_snapshot_finish(&s);
}

static void any_order(void **state)
{
	(void)state;
	stilb_prof_snapshot s = {0};
	parse("{\"otherData\":{\"version\":\"x\"},\"traceEvents\":["
	      "{\"dur\":1,\"ts\":5,\"name\":\"inner\",\"tid\":1,\"ph\":\"X\"},"
	      "{\"dur\":1,\"ts\":8,\"name\":\"later\",\"tid\":1,\"ph\":\"X\"},"
	      "{\"dur\":5,\"ts\":5,\"name\":\"outer\",\"tid\":1,\"ph\":\"X\"},"
	      "{\"dur\":1,\"ts\":1,\"name\":\"first\",\"tid\":1,\"ph\":\"X\"}],\"more\":[1,{\"a\":[]}]}",
	      &s);
	assert_zone(&s, 0, 0, "first", 1000, 2000, 0);
	assert_zone(&s, 0, 1, "outer", 5000, 10000, 0);
	assert_zone(&s, 0, 2, "inner", 5000, 6000, 1);
	assert_zone(&s, 0, 3, "later", 8000, 9000, 1);
	stilb_prof_snapshot_finish(&s);
}

/* Zones in a file that list children before parents: of two with the same begin the longer one is the parent. A zone
 * that extends beyond its parent by more than a rounding error is cut. */
static void what_overlaps(void **state)
{
	(void)state;
	stilb_prof_snapshot s = {0};
	parse("[{\"ph\":\"X\",\"name\":\"a\",\"ts\":1,\"dur\":4},{\"ph\":\"X\",\"name\":\"b\",\"ts\":3,\"dur\":4},"
	      "{\"ph\":\"X\",\"name\":\"c\",\"ts\":10.0006,\"dur\":2.0006},"
	      "{\"ph\":\"X\",\"name\":\"d\",\"ts\":12.0009,\"dur\":2},"
	      "{\"ph\":\"X\",\"name\":\"e\",\"ts\":12.0009,\"dur\":1}]",
	      &s);
	assert_zone(&s, 0, 0, "a", 1000, 5000, 0);
	assert_zone(&s, 0, 1, "b", 3000, 5000, 1);
	assert_zone(&s, 0, 2, "c", 10001, 12002, 0);
	assert_zone(&s, 0, 3, "d", 12002, 14001, 0);
	assert_zone(&s, 0, 4, "e", 12002, 13001, 1);
	stilb_prof_snapshot_finish(&s);
}

static void names_and_lanes(void **state)
{
	(void)state;
	stilb_prof_snapshot s = {0};
	parse(" [ "
	      "{\"ph\":\"X\",\"ts\":1,\"dur\":1,\"pid\":\"p\",\"tid\":\"t\",\"name\":"
	      "\"\\u00e9\\ud83d\\ude00\\n\\u0000\\ud800\"},\n"
	      "{\"ph\":\"X\",\"ts\":1,\"dur\":1,\"pid\":\"p\",\"tid\":3,\"name\":\"\xc3\xa9\"},"
	      "{\"ph\":\"X\",\"ts\":3,\"dur\":1,\"pid\":\"p\",\"tid\":3,\"name\":\"\\u00E9\"},"
	      "{\"ph\":\"X\",\"ts\":5,\"dur\":1,\"pid\":\"p\",\"tid\":3},"
	      "{\"ph\":\"M\",\"pid\":\"p\",\"tid\":3,\"name\":\"thread_name\",\"args\":{\"name\":\"frames\"}},"
	      "{\"ph\":\"M\",\"pid\":\"p\",\"tid\":3,\"name\":\"thread_sort_index\",\"args\":{\"sort_index\":-5}},"
	      "{\"ph\":\"M\",\"pid\":\"p\",\"tid\":4,\"name\":\"thread_name\",\"args\":{\"name\":\"idle\"}},"
	      "{\"ph\":\"b\",\"id\":{\"x\":1},\"ts\":1},{\"ph\":\"Q\"},{}]",
	      &s);
	assert_int_equal(s.lane_count, 3);
	assert_string_equal(s.lanes[0].name, "frames"); /* of another program: a thread like others */
	assert_string_equal(s.lanes[1].name, "thread #1");
	assert_string_equal(s.lanes[2].name, "idle");
	assert_string_equal(s.labels[s.lanes[1].zones[0].label].name, "\xc3\xa9\xf0\x9f\x98\x80\n\xef\xbf\xbd\xef\xbf\xbd");
	assert_int_equal(s.lanes[0].zones[0].label, s.lanes[0].zones[1].label);
	assert_string_equal(s.labels[s.lanes[0].zones[2].label].name, "");
	assert_int_equal(s.lanes[2].zone_count, 0);
	assert_string_equal(s.lanes[0].no_switches, "the file does not tell");
	stilb_prof_snapshot_finish(&s);
}

static void counters_of_several_series(void **state)
{
	(void)state;
	stilb_prof_snapshot s = {0};
	parse("[{\"ph\":\"C\",\"name\":\"memory\",\"ts\":2,\"args\":{\"used\":1,\"free\":-2.5,\"unit\":\"MiB\"}},"
	      "{\"ph\":\"I\",\"name\":\"mark\",\"ts\":1,\"tid\":1}]",
	      &s);
	assert_int_equal(s.point_count, 3);
	assert_string_equal(s.labels[s.points[0].label].name, "mark");
	assert_true(!s.points[0].counter && s.points[0].lane == 0);
	assert_string_equal(s.labels[s.points[1].label].name, "memory used");
	assert_string_equal(s.labels[s.points[2].label].name, "memory free");
	assert_true(s.points[2].value == -2.5);
	stilb_prof_snapshot_finish(&s);
}

/* Flow events s, t and f of one id make two arrows, s to t and t to f. An id may be used again; one begin may have
 * several ends, or none, and an end may have no begin. */
static void arrows(void **state)
{
	(void)state;
	stilb_prof_snapshot s = {0};
	parse("[{\"ph\":\"f\",\"bp\":\"e\",\"id\":\"0x1f\",\"name\":\"n\",\"ts\":30,\"tid\":3},"
	      "{\"ph\":\"s\",\"id\":\"0x1f\",\"name\":\"n\",\"ts\":10,\"tid\":1},"
	      "{\"ph\":\"t\",\"id\":\"0x1f\",\"name\":\"n\",\"ts\":20,\"tid\":2},"
	      "{\"ph\":\"s\",\"id\":\"0x1f\",\"name\":\"n\",\"ts\":40,\"tid\":1},"
	      "{\"ph\":\"f\",\"id\":\"0x1f\",\"name\":\"n\",\"ts\":50,\"tid\":2},"
	      "{\"ph\":\"f\",\"id\":\"0x1f\",\"name\":\"n\",\"ts\":60,\"tid\":3},"
	      "{\"ph\":\"s\",\"id\":7,\"name\":\"n\",\"ts\":70,\"tid\":1},"
	      "{\"ph\":\"f\",\"id\":8,\"name\":\"n\",\"ts\":80,\"tid\":1},"
	      "{\"ph\":\"s\",\"id\":8,\"name\":\"other\",\"ts\":75,\"tid\":1}]",
	      &s);
	static const uint64_t expected[][4] = {/* from, to, lanes */
	                                       {10000, 20000, 1, 2},
	                                       {20000, 30000, 2, 0},
	                                       {40000, 50000, 1, 2},
	                                       {40000, 60000, 1, 0},
	                                       {70000, 70000, 1, STILB_PROF_NONE},
	                                       {75000, 75000, 1, STILB_PROF_NONE},
	                                       {80000, 80000, STILB_PROF_NONE, 1}};
	assert_int_equal(s.flow_count, sizeof expected / sizeof *expected);
	for (uint32_t i = 0; i < s.flow_count; i++) {
		assert_int_equal(s.flows[i].from_ns, expected[i][0]);
		assert_int_equal(s.flows[i].to_ns, expected[i][1]);
		assert_int_equal(s.flows[i].from_lane, expected[i][2]);
		assert_int_equal(s.flows[i].to_lane, expected[i][3]);
	}
	stilb_prof_snapshot_finish(&s);
}

/* ---- bad files --------------------------------------------------------------------------------------------------- */

static const struct {
	const char *text;
	const char *said;
} bad[] = {
	{"", "byte 1 of 0: expected a trace, but the file ends"},
	{" \n ", "expected a trace, but the file ends"},
	{"hello", "line 1, byte 1 of 5: expected a Chrome trace: '{' or '[', but there is 'h'"},
	{"{", "expected a string, but the file ends"},
	{"{}", "expected \"traceEvents\" before the end of the object"},
	{"{\"traceEvents\":{}}", "expected an array of events, but there is '{'"},
	{"{\"traceEvents\":[", "an event: '{', but the file ends"},
	{"{\"traceEvents\":[]", "',' or '}', but the file ends"},
	{"{\"traceEvents\":[]}x", "byte 19 of 19: expected nothing after the trace, but there is 'x'"},
	{"[1]", "an event: '{', but there is '1'"},
	{"[{}{}]", "',' or ']' after an event"},
	{"[{\"ph\":\"X\",\"dur\":1}]", "byte 2 of 20: expected an event with \"ts\""},
	{"[\n\n{\"ph\":\"X\",\"ts\":1}]", "line 3, byte 4 of 21: expected an X event with \"dur\""},
	{"[{\"ph\":\"X\",\"ts\":1,\"dur\":-1}]", "a duration of 0 or more"},
	{"[{\"ph\":\"X\",\"ts\":1e308,\"dur\":1}]", "a time below 2.3e15 microseconds (70 years), but there is '1e308'"},
	{"[{\"ph\":\"X\",\"ts\":99999999999999999999999,\"dur\":1}]", "but there is '99999999999999999999999'"},
	{"[{\"ph\":\"X\",\"ts\":9999999999999999999999999,\"dur\":1}]", "but there is '999999999999999999999999'"},
	{"[{\"ph\":\"X\",\"ts\":\"1\"}]", "a number, but there is '\"'"},
	{"[{\"ph\":\"X\",\"ts\":1.}]", "a digit, but there is '}'"},
	{"[{\"ph\":\"X\",\"ts\":1e}]", "a digit"},
	{"[{\"ph\":\"X\",\"ts\":-}]", "a number, but there is '-'"},
	{"[{\"ph\":1}]", "a string, but there is '1'"},
	{"[{\"ph\" \"X\"}]", "':', but there is '\"'"},
	{"[{\"a\":tru}]", "a value, but there is 't'"},
	{"[{\"a\":[1 2]}]", "',' or ']'"},
	{"[{\"a\":1,}]", "a string, but there is '}'"},
	{"[{\"a\":\"\t\"}]", "no control byte in a string, but there is byte 0x09"},
	{"[{\"a\":\"0123456789\n0123456789\"}]", "byte 18 of 31: expected no control byte in a string"},
	{"[{\"a\":\"\\x\"}]", "after a backslash"},
	{"[{\"a\":\"\\u12g4\"}]", "four hex digits after \\u, but there is 'g'"},
	{"[{\"a\":\"b", "the end of the string that begins before, but the file ends"},
};

static void bad_text_is_told(void **state)
{
	(void)state;
	char error[256];
	stilb_prof_snapshot s = {0};
	for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
		if (parse_bytes(bad[i].text, strlen(bad[i].text), &s, error) != -EBADMSG || !strstr(error, bad[i].said) ||
		    strncmp(error, "'a.json', line ", 15) != 0)
			fail_msg("%s: %s\nnot: %s", bad[i].text, error, bad[i].said);
	}
	assert_int_equal(stilb_prof_trace_parse("[", 1, "a", &s, NULL, 0), 0);
	assert_int_equal(stilb_prof_trace_parse("x", 1, "a", &s, NULL, 0), -EBADMSG);
	assert_int_equal(stilb_prof_trace_parse("x", 1, "abcdefgh", &s, error, 5), -EBADMSG);
	assert_string_equal(error, "'abc");
}

/* A file that was cut anywhere is an error that names the place, but for a bare array after an event. */
static void truncated(void **state)
{
	(void)state;
	char error[256];
	made m;
	stilb_prof_snapshot s = {0};
	made_by_chance(&m, 7);
	bytes b = written(&m.snapshot);
	assert_true(b.size > 5000);
	for (size_t size = 0; size + 1 < b.size; size++) { /* without the newline at its end it is whole */
		if (parse_bytes(b.text, size, &s, error) != -EBADMSG || !strstr(error, "expected "))
			fail_msg("%zu bytes of %zu: %s", size, b.size, error);
	}
	char *events = strchr(b.text, '['), *end = b.text + b.size;
	size_t good = 0;
	for (size_t size = 1; events + size < end && good < 200; size++)
		good += parse_bytes(events, size, &s, error) == 0;
	assert_true(good > 100);
	stilb_prof_snapshot_finish(&s);
	free(b.text);
	made_finish(&m);
}

/* With one byte changed, a trace gives an error or a sound snapshot, which parse_bytes checks. */
static void damaged(void **state)
{
	(void)state;
	char error[256];
	made m;
	made_random random = {.state = 1};
	stilb_prof_snapshot s = {0};
	made_by_chance(&m, 7);
	bytes b = written(&m.snapshot);
	for (int i = 0; i < 20000; i++) {
		char *byte = &b.text[made_below(&random, b.size)], before = *byte;
		*byte = "\"\\,:{}[]0159.-eXBE\x01\xff"[made_below(&random, 21)];
		parse_bytes(b.text, b.size, &s, error);
		*byte = before;
	}
	stilb_prof_snapshot_finish(&s);
	free(b.text);
	made_finish(&m);
}

static void nested_without_end(void **state)
{
	(void)state;
	enum { DEPTH = 200000 };
	char error[256], *text = malloc(100 * DEPTH), *at = text;
	stilb_prof_snapshot s = {0};
	assert_non_null(text);
	memset(text, '[', DEPTH);
	memcpy(text, "[{\"a\":", 6);
	assert_int_equal(parse_bytes(text, DEPTH, &s, error), -EBADMSG);
	assert_non_null(strstr(error, "less than 256 deep"));
	at += sprintf(at, "[");
	for (int i = 0; i < DEPTH; i++) /* zones, and an arrow into each */
		at += sprintf(at,
		              "{\"ph\":\"B\",\"ts\":%d},{\"ph\":\"s\",\"id\":%d,\"ts\":0},{\"ph\":\"f\",\"id\":%d,\"ts\":%d},",
		              i, i, i, i);
	assert_int_equal(parse_bytes(text, (size_t)(at - text), &s, error), 0);
	assert_int_equal(s.lanes[0].zone_count, DEPTH);
	assert_int_equal(s.lanes[0].zones[DEPTH - 1].level, UINT16_MAX);
	assert_int_equal(s.lanes[0].zones[0].size, DEPTH);
	stilb_prof_snapshot_finish(&s);
	free(text);
}

static void many_lanes_and_labels(void **state)
{
	(void)state;
	enum { COUNT = 50000 };
	char error[256], *text = malloc(100 * COUNT), *at = text;
	stilb_prof_snapshot s = {0};
	assert_non_null(text);
	at += sprintf(at, "[");
	for (int i = 0; i < COUNT; i++)
		at += sprintf(at, "{\"ph\":\"X\",\"ts\":%d,\"dur\":1,\"tid\":%d,\"name\":\"n%d\"},", i, COUNT - i, i);
	assert_int_equal(parse_bytes(text, (size_t)(at - text), &s, error), 0);
	assert_int_equal(s.lane_count, COUNT);
	assert_int_equal(s.label_count, COUNT);
	assert_string_equal(s.labels[s.lanes[COUNT - 1].zones[0].label].name, "n49999");
	stilb_prof_snapshot_finish(&s);
	free(text);
}

static void no_memory(void **state)
{
	(void)state;
	char error[256];
	made m;
	stilb_prof_snapshot s = {0};
	made_by_chance(&m, 11);
	bytes b = written(&m.snapshot);
	int failures = 0;
	for (;; failures++) {
		fail_allocation = failures;
		int result = stilb_prof_trace_parse(b.text, b.size, "a.json", &s, error, sizeof error);
		bool failed = fail_allocation < 0;
		fail_allocation = -1;
		if (!failed)
			break;
		assert_int_equal(result, -ENOMEM);
		assert_null(s.memory);
		assert_non_null(strstr(error, "'a.json': no memory"));
	}
	assert_true(failures > 20);
	stilb_prof_snapshot_finish(&s);
	free(b.text);
	made_finish(&m);
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

static void assert_unreadable(const char *path, int result, const char *said)
{
	char error[256] = "";
	stilb_prof_snapshot s = {0};
	assert_int_equal(stilb_prof_trace_read(path, &s, error, sizeof error), result);
	if (!strstr(error, path) || !strstr(error, said))
		fail_msg("%s: %s", path, error);
	assert_null(s.memory);
}

static void files(void **state)
{
	(void)state;
	char path[] = "test_prof_read_XXXXXX", error[256];
	made m;
	stilb_prof_snapshot s = {0};
	made_by_chance(&m, 3);
	bytes b = written(&m.snapshot);
	int file = mkstemp(path);
	assert_true(file >= 0 && write(file, b.text, b.size) == (ssize_t)b.size);
	assert_int_equal(stilb_prof_trace_read(path, &s, error, sizeof error), 0);
	assert_same(&m.snapshot, &s);
	assert_int_equal(lseek(file, 0, SEEK_SET), 0);
	int input = dup(STDIN_FILENO);
	assert_int_equal(dup2(file, STDIN_FILENO), STDIN_FILENO);
	assert_int_equal(stilb_prof_trace_read("-", &s, error, sizeof error), 0);
	assert_same(&m.snapshot, &s);
	dup2(input, STDIN_FILENO);
	close(input);
	assert_int_equal(ftruncate(file, 100), 0);
	assert_unreadable(path, -EBADMSG, "of 100: expected ");
	assert_int_equal(ftruncate(file, 0), 0);
	assert_unreadable(path, -EBADMSG, "expected a trace, but the file ends");
	close(file);
	unlink(path);
	assert_unreadable(path, -ENOENT, "No such file");
	assert_unreadable(".", -EISDIR, "directory");
	assert_unreadable("/dev/zero", -ESPIPE, "a device or a pipe; give a regular file");
	assert_unreadable("/dev/null", -ESPIPE, "a device or a pipe");
	assert_int_equal(mkfifo(path, 0600), 0); /* that nobody writes */
	assert_unreadable(path, -ESPIPE, "a device or a pipe");
	unlink(path);
	int zero = open("/dev/zero", O_RDONLY), kept = dup(STDIN_FILENO); /* standard input is read whatever it is, */
	dup2(zero, STDIN_FILENO);
	assert_unreadable("-", -EBADMSG, "there is byte 0x00"); /* but not for ever */
	dup2(kept, STDIN_FILENO);
	close(zero);
	close(kept);
	stilb_prof_snapshot_finish(&s);
	free(b.text);
	made_finish(&m);
}

/* ---- speed ------------------------------------------------------------------------------------------------------- */

/* Printed, not asserted: the machine may be busy. */
static void speed(void **state)
{
	(void)state;
	struct timespec from, to;
	made m;
	stilb_prof_snapshot s = {0};
	char error[256];
	made_init(&m, 1);
	for (uint64_t i = 0; i < (TEST_ASAN || TEST_EMULATED ? 50000 : 200000); i++) {
		made_push(&m, 0, i % 8, 3000 * i);
		made_pop(&m, 0, 3000 * i + 2000);
	}
	bytes b = written(&m.snapshot);
	clock_gettime(CLOCK_MONOTONIC, &from);
	assert_int_equal(stilb_prof_trace_parse(b.text, b.size, "a.json", &s, error, sizeof error), 0);
	clock_gettime(CLOCK_MONOTONIC, &to);
	double seconds = (double)(to.tv_sec - from.tv_sec) + 1e-9 * (double)(to.tv_nsec - from.tv_nsec);
	print_message("%zu bytes, %.0f MB/s\n", b.size, (double)b.size / seconds * 1e-6);
	stilb_prof_snapshot_finish(&s);
	free(b.text);
	made_finish(&m);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(what_was_written_comes_back),
		cmocka_unit_test(what_was_recorded_comes_back),
		cmocka_unit_test(open_zones_stay_open),
		cmocka_unit_test(times_are_exact),
		cmocka_unit_test(times_before_zero_are_shifted),
		cmocka_unit_test(values_are_doubles),
		cmocka_unit_test(begins_and_ends),
		cmocka_unit_test(any_order),
		cmocka_unit_test(what_overlaps),
		cmocka_unit_test(names_and_lanes),
		cmocka_unit_test(counters_of_several_series),
		cmocka_unit_test(arrows),
		cmocka_unit_test(bad_text_is_told),
		cmocka_unit_test(truncated),
		cmocka_unit_test(damaged),
		cmocka_unit_test(nested_without_end),
		cmocka_unit_test(many_lanes_and_labels),
		cmocka_unit_test(no_memory),
		cmocka_unit_test(files),
		cmocka_unit_test(speed),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
