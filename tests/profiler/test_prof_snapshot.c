/* Snapshots of what was recorded: the tree of zones, made from the order in which they end; times; windows (the last
 * frames alone); jobs charged to the frame that submitted them; flows, points, context switches; and their cost. */
#include "profiler/prof_internal.h"
#include "support/failing_memory.h"
#include "support/test.h"

#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>

/* ---- context switches made by hand ------------------------------------------------------------------------------- */

static const prof_switch_event *made_switches; /* copied in place of the kernel's; NULL: the kernel's are */
static uint32_t made_switch_count;

static const char made_page;

prof_switches __real_prof_switches_open(const char *name);
prof_switches __wrap_prof_switches_open(const char *name);
void __real_prof_switches_close(prof_switches *switches);
void __wrap_prof_switches_close(prof_switches *switches);
uint32_t __real_prof_switches_copy(const prof_switches *switches, uint64_t since_ns, prof_switch_event *events);
uint32_t __wrap_prof_switches_copy(const prof_switches *switches, uint64_t since_ns, prof_switch_event *events);

prof_switches __wrap_prof_switches_open(const char *name)
{
	return made_switches ? (prof_switches){.page = &made_page} : __real_prof_switches_open(name);
}

void __wrap_prof_switches_close(prof_switches *switches)
{
	if (switches->page != &made_page)
		__real_prof_switches_close(switches);
	*switches = (prof_switches){0};
}

uint32_t __wrap_prof_switches_copy(const prof_switches *switches, uint64_t since_ns, prof_switch_event *events)
{
	if (switches->page != &made_page)
		return __real_prof_switches_copy(switches, since_ns, events);
	memcpy(events, made_switches, made_switch_count * sizeof *events);
	return made_switch_count;
}

/* ------------------------------------------------------------------------------------------------------------------ */

static void sleep_ms(long ms)
{
	nanosleep(&(struct timespec){.tv_nsec = ms * 1000000}, NULL);
}

static stilb_prof_snapshot s; /* the snapshot that take() made last; {0} between tests */

static int begin_thread(void **state)
{
	(void)state;
	prof_clock_now();
	sleep_ms(11); /* the first snapshot would sleep until 10 ms have passed since the clock was first read */
	return stilb_prof_thread_begin("main");
}

static int shut_down(void **state)
{
	(void)state;
	fail_allocation = -1;
	made_switches = NULL;
	stilb_prof_snapshot_finish(&s);
	stilb_prof_switches_set(false);
	stilb_prof_shutdown();
	return 0;
}

static const char *label_name(uint32_t label)
{
	assert_true(label < s.label_count);
	return s.labels[label].name;
}

/* Checks what is true of every snapshot. */
static void check_lane(const stilb_prof_lane *lane)
{
	for (uint32_t i = 0; i < lane->zone_count; i++) {
		const stilb_prof_zone *zone = &lane->zones[i];
		uint64_t self_ns = zone->end_ns - zone->begin_ns, cursor = zone->begin_ns;
		uint32_t child = i + 1;
		assert_true(zone->begin_ns <= zone->end_ns);
		assert_true(zone->size >= 1 && i + zone->size <= lane->zone_count);
		assert_true(zone->label < s.label_count);
		assert_true(zone->frame == STILB_PROF_NONE || zone->frame < s.frame_count);
		while (child < i + zone->size) {
			const stilb_prof_zone *inner = &lane->zones[child];
			assert_int_equal(inner->parent, i);
			assert_int_equal(inner->level, zone->level + 1);
			assert_true(inner->begin_ns >= cursor && inner->end_ns <= zone->end_ns);
			cursor = inner->end_ns;
			self_ns -= inner->end_ns - inner->begin_ns;
			child += inner->size;
		}
		assert_int_equal(child, i + zone->size);
		assert_int_equal(zone->self_ns, self_ns);
		assert_true(zone->off_cpu_ns <= zone->end_ns - zone->begin_ns);
	}
	uint64_t cursor = 0;
	for (uint32_t i = 0; i < lane->zone_count; i += lane->zones[i].size) {
		assert_int_equal(lane->zones[i].parent, STILB_PROF_NONE);
		assert_int_equal(lane->zones[i].level, 0);
		assert_true(lane->zones[i].begin_ns >= cursor);
		cursor = lane->zones[i].end_ns;
	}
	for (uint32_t i = 0; i < lane->switch_count; i++) {
		assert_true(lane->switches[i].out_ns < lane->switches[i].in_ns);
		assert_true(i == 0 || lane->switches[i].out_ns >= lane->switches[i - 1].in_ns);
	}
}

static void check_snapshot(void)
{
	assert_true(s.begin_ns <= s.end_ns);
	assert_int_equal(s.events_recorded, s.events_lost + s.events_held);
	for (uint32_t i = 0; i < s.lane_count; i++)
		check_lane(&s.lanes[i]);
	for (uint32_t i = 0; i < s.frame_count; i++) {
		assert_true(s.frames[i].begin_ns <= s.frames[i].end_ns);
		assert_true(i == 0 || (s.frames[i].number == s.frames[i - 1].number + 1 &&
		                       s.frames[i].begin_ns == s.frames[i - 1].end_ns));
	}
	for (uint32_t i = 0; i < s.point_count; i++)
		assert_true(s.points[i].lane < s.lane_count && (i == 0 || s.points[i].ns >= s.points[i - 1].ns));
	for (uint32_t i = 0; i < s.flow_count; i++) {
		assert_true(s.flows[i].from_ns <= s.flows[i].to_ns);
		assert_true(i == 0 || s.flows[i].to_ns >= s.flows[i - 1].to_ns);
		assert_true(s.flows[i].from_lane < s.lane_count || s.flows[i].to_lane < s.lane_count);
	}
}

static void take(uint32_t last_frames)
{
	stilb_prof_window window = {.last_frames = last_frames};
	assert_int_equal(stilb_prof_snapshot_take(&s, &window), 0);
	check_snapshot();
}

/* The names of a lane's zones, each in parentheses with those inside it: "a(b c)". */
static void assert_tree(uint32_t lane, const char *expected)
{
	char text[1024] = "";
	size_t used = 0;
	uint32_t level = 0;
	for (uint32_t i = 0; i < s.lanes[lane].zone_count; i++) {
		const stilb_prof_zone *zone = &s.lanes[lane].zones[i];
		for (; level > zone->level; level--)
			text[used++] = ')';
		if (i > 0)
			text[used++] = zone->level > level ? '(' : ' ';
		level = zone->level;
		used += (size_t)snprintf(text + used, sizeof text - used, "%s", label_name(zone->label));
	}
	for (; level > 0; level--)
		text[used++] = ')';
	text[used] = 0;
	assert_string_equal(text, expected);
}

static const stilb_prof_zone *find_zone(uint32_t lane, const char *name)
{
	for (uint32_t i = 0; i < s.lanes[lane].zone_count; i++)
		if (strcmp(label_name(s.lanes[lane].zones[i].label), name) == 0)
			return &s.lanes[lane].zones[i];
	fail_msg("no zone %s", name);
	return NULL;
}

/* ---- the tree: events made by hand ------------------------------------------------------------------------------- */

STILB_PROF_SITE(site_a, "a", 0x102030);
STILB_PROF_SITE(site_b, "b", 0);
STILB_PROF_SITE(site_c, "c", 0);
STILB_PROF_SITE(site_d, "d", 0);
STILB_PROF_FLOW(flow_job, "job flow", 0);

static void record(const stilb_prof_site *site, uint64_t begin, uint64_t end, uint32_t depth)
{
	stilb_prof_write(stilb_prof_thread_ring, site, begin, depth, end - begin);
}

static void record_flow(const stilb_prof_site *site, uint64_t time, uint32_t open, uint64_t id)
{
	stilb_prof_write(stilb_prof_thread_ring, site, time, open, id);
}

/* All zones begin in the same tick. Only their depths and the order of their ends tell that b lies in a, and that c,
 * with d in it, follows. */
static void ties_keep_the_tree(void **state)
{
	(void)state;
	uint64_t t = prof_clock_now();
	record(&site_b, t, t, 1);
	record(&site_a, t, t, 0);
	record(&site_d, t, t + 5000, 1);
	record(&site_c, t, t + 9000, 0);
	take(0);
	assert_tree(0, "a(b) c(d)");
	assert_int_equal(s.labels[find_zone(0, "a")->label].color, 0x102030);
	assert_string_equal(strrchr(s.labels[find_zone(0, "a")->label].file, '/') + 1, "test_prof_snapshot.c");
}

static void children_without_their_parent(void **state)
{
	(void)state;
	uint64_t t = prof_clock_now();
	record(&site_b, t + 100, t + 200, 2);
	record(&site_c, t + 300, t + 400, 2);
	record(&site_a, t + 250, t + 500, 1); /* the parent of c; the event of b's parent was overwritten */
	record(&site_d, t + 600, t + 700, 0);
	take(0);
	assert_tree(0, "b a(c) d");
}

/* Events that no correct program records still give a snapshot that passes check_snapshot. */
static void overlaps_are_cut(void **state)
{
	(void)state;
	uint64_t t = prof_clock_now();
	record(&site_a, t, t + 5000, 0);
	record(&site_b, t + 3000, t + 9000, 0);
	record(&site_c, t + 8000, t + 20000, 1);
	record(&site_d, t + 7000, t + 10000, 0);
	record(&site_a, t + 2000, t + 2000, 0); /* begins and ends before the zone that was recorded before it */
	take(0);
	assert_int_equal(s.lanes[0].zone_count, 5);
}

static uint64_t random_state = 1;

static uint64_t random_below(uint64_t limit)
{
	random_state = random_state * 6364136223846793005u + 1442695040888963407u;
	return (random_state >> 33) % limit;
}

/* The zones expected for a random tree, parents first. */
typedef struct expected_zone {
	uint32_t level;
	uint64_t ticks; /* the zone's length */
} expected_zone;

/* A random tree in the order of its ends; steps of 0 to 3 ticks, so that many times are equal, in ticks and in ns. */
static uint64_t record_tree(uint64_t t, uint32_t depth, int *left, expected_zone *expected, uint32_t *count)
{
	uint64_t begin = t + random_below(4);
	expected_zone *zone = &expected[(*count)++];
	t = begin;
	while (*left > 0 && depth < STILB_PROF_DEPTH_MAX - 1 && random_below(8) < 6) {
		(*left)--;
		t = record_tree(t, depth + 1, left, expected, count);
	}
	t += random_below(4);
	record(&site_a, begin, t, depth);
	*zone = (expected_zone){depth, t - begin};
	return t;
}

static void random_trees_come_back(void **state)
{
	(void)state;
	expected_zone *expected = calloc(70000, sizeof *expected);
	uint64_t t = prof_clock_now();
	uint32_t count = 0;
	for (int left = 30000; left > 0;)
		t = record_tree(t, 0, &left, expected, &count);
	take(0);
	assert_int_equal(s.lanes[0].zone_count, count);
	for (uint32_t i = 0; i < count; i++) {
		const stilb_prof_zone *zone = &s.lanes[0].zones[i];
		double ns = (double)expected[i].ticks * 1e9 / s.hz;
		assert_int_equal(zone->level, expected[i].level);
		double error = (double)(zone->end_ns - zone->begin_ns) - ns;
		if (error < -2 || error > 2)
			fail_msg("zone %u: %g ns off", i, error);
	}
	free(expected);
}

/* Zones that began in the window's frames are there with their parents, whatever the window. */
static void open_zones(void **state)
{
	(void)state;
	{
		PROFILE("outer");
		{
			PROFILE("done");
		}
		PROFILE("inner");
		take(0);
		assert_tree(0, "outer(done inner)");
		assert_true(find_zone(0, "outer")->open && find_zone(0, "inner")->open && !find_zone(0, "done")->open);
		assert_int_equal(find_zone(0, "outer")->end_ns, s.end_ns);
		assert_int_equal(find_zone(0, "inner")->end_ns, s.end_ns);
		assert_int_equal(find_zone(0, "outer")->begin_ns, s.begin_ns);
	}
	take(0);
	assert_tree(0, "outer(done inner)");
	assert_false(find_zone(0, "outer")->open);
}

/* A zone is recorded between two reads of another clock, with two more reads inside of it: its length and its begin lie
 * between what these give. */
static void times_are_true(void **state)
{
	(void)state;
	uint64_t t[4];
	t[0] = stilb_prof_clock_monotonic();
	{
		PROFILE("sleep");
		t[1] = stilb_prof_clock_monotonic();
		sleep_ms(20);
		t[2] = stilb_prof_clock_monotonic();
	}
	t[3] = stilb_prof_clock_monotonic();
	take(0);
	const stilb_prof_zone *zone = find_zone(0, "sleep");
	assert_in_range(zone->begin_ns + s.epoch_ns, t[0] - 2000, t[1] + 2000);
	assert_in_range(zone->end_ns + s.epoch_ns, t[2] - 2000, t[3] + 2000);
	assert_true(zone->end_ns - zone->begin_ns >= 20000000 - 2000);
}

/* ---- windows ----------------------------------------------------------------------------------------------------- */

static void nothing_recorded(void **state)
{
	(void)state;
	stilb_prof_shutdown();
	take(0);
	assert_int_equal(s.lane_count + s.frame_count + s.point_count + s.flow_count, 0);
	assert_non_null(s.clock);
	assert_true(s.hz > 0 && s.resolution_ns > 0 && s.zone_cost_ns > 0);
}

static void the_last_frames_are_remembered(void **state)
{
	(void)state;
	for (int i = 0; i < 3000; i++)
		stilb_prof_frame_mark();
	take(0);
	assert_int_equal(s.frame_count, PROF_FRAMES_MAX - 2); /* not all: the oldest mark may be about to be overwritten */
	assert_int_equal(s.frames[s.frame_count - 1].number, 2998);
	assert_int_equal(s.begin_ns, s.frames[0].begin_ns);
	PROFILE("open");
	for (uint64_t first = 0; first < 5000; first += 4000) { /* frames that are forgotten by now; that have not begun */
		stilb_prof_window window = {.first_frame = first, .frame_count = 2};
		assert_int_equal(stilb_prof_snapshot_take(&s, &window), 0);
		check_snapshot();
		assert_int_equal(s.frame_count, 0);
		assert_int_equal(s.lanes[0].zone_count, 0);
	}
}

static void last_frames_leaves_the_rest_out(void **state)
{
	(void)state;
	static const uint32_t asked[] = {1, 3, 9, 10, 1000, 0};
	static const uint32_t frames[] = {1, 3, 9, 9, 9, 9}; /* ten marks make nine whole frames */
	static const uint32_t zones[] = {4, 8, 20, 21, 21, 21};
	{
		PROFILE("before the first");
	}
	for (int i = 0; i < 10; i++) {
		stilb_prof_frame_mark();
		PROFILE("outer");
		PROFILE("inner");
	}
	for (size_t i = 0; i < sizeof asked / sizeof asked[0]; i++) {
		take(asked[i]);
		assert_int_equal(s.frame_count, frames[i]);
		assert_int_equal(s.frames[0].number, 9 - frames[i]);
		assert_int_equal(s.lanes[0].zone_count, zones[i]);
		assert_int_equal(s.events_held, 21); /* counts what the rings hold, whatever the window */
	}
}

/* A frame is from its mark on, up to the next: what begins with it is in it. */
static void a_zone_that_begins_with_its_frame(void **state)
{
	(void)state;
	static prof_copy copy;
	for (int i = 0; i < 3; i++) {
		stilb_prof_frame_mark();
		sleep_ms(1);
	}
	assert_int_equal(prof_copy_take(&copy, NULL), 0);
	record(&site_a, copy.frames[0].ticks, copy.frames[1].ticks, 0);
	record(&site_b, copy.frames[1].ticks, copy.frames[2].ticks, 0);
	record(&site_c, copy.frames[2].ticks, copy.frames[2].ticks + 1, 0);
	prof_copy_free(&copy);
	take(0);
	assert_int_equal(find_zone(0, "a")->frame, 0);
	assert_int_equal(find_zone(0, "b")->frame, 1);
	assert_int_equal(find_zone(0, "c")->frame, STILB_PROF_NONE);
	assert_int_equal(find_zone(0, "b")->begin_ns, s.frames[1].begin_ns);
}

static void frames_by_number(void **state)
{
	(void)state;
	for (int i = 0; i < 10; i++) {
		stilb_prof_frame_mark();
		PROFILE_COUNTER("i", i);
		PROFILE("zone");
	}
	PROFILE("still open");
	stilb_prof_window window = {.first_frame = 3, .frame_count = 2};
	assert_int_equal(stilb_prof_snapshot_take(&s, &window), 0);
	check_snapshot();
	assert_int_equal(s.frame_count, 2);
	assert_int_equal(s.frames[0].number, 3);
	assert_tree(0, "zone zone");
	assert_int_equal(s.lanes[0].zones[0].frame, 0);
	assert_int_equal(s.lanes[0].zones[1].frame, 1);
	assert_int_equal(s.point_count, 2);
	assert_true(s.points[0].value == 3 && s.points[1].value == 4);
	assert_int_equal(s.begin_ns, s.frames[0].begin_ns);
	assert_int_equal(s.end_ns, s.frames[1].end_ns);
}

/* Parents that began before the window and ended in it are there; children that ended before are not. */
static void a_zone_across_the_windows_begin(void **state)
{
	(void)state;
	stilb_prof_frame_mark();
	{
		PROFILE("across");
		{
			PROFILE("early");
		}
		stilb_prof_frame_mark();
		{
			PROFILE("late");
		}
	}
	stilb_prof_frame_mark();
	take(1);
	assert_tree(0, "across(late)");
	assert_int_equal(find_zone(0, "across")->frame, STILB_PROF_NONE);
	assert_int_equal(find_zone(0, "late")->frame, 0);
	assert_true(find_zone(0, "across")->begin_ns < s.begin_ns);
}

/* ---- points and flows -------------------------------------------------------------------------------------------- */

static void *count_on_another_thread(void *unused)
{
	(void)unused;
	stilb_prof_thread_begin("other");
	for (int i = 0; i < 100; i++) {
		PROFILE_COUNTER("other", i);
		PROFILE("zone");
	}
	stilb_prof_thread_end();
	return NULL;
}

static void points_of_all_threads_in_order(void **state)
{
	(void)state;
	pthread_t thread;
	double next[2] = {0};
	PROFILE_INSTANT("first");
	assert_int_equal(pthread_create(&thread, NULL, count_on_another_thread, NULL), 0);
	for (int i = 0; i < 100; i++)
		PROFILE_COUNTER("mine", i / 4.0);
	pthread_join(thread, NULL);
	PROFILE_INSTANT("last");
	take(0);
	assert_int_equal(s.point_count, 202);
	assert_string_equal(label_name(s.points[0].label), "first");
	assert_string_equal(label_name(s.points[201].label), "last");
	assert_int_equal(s.begin_ns, s.points[0].ns);
	assert_int_equal(s.lanes[1].switch_count, 0); /* switches were not asked for (stilb_prof_switches_set) */
	assert_non_null(s.lanes[1].no_switches);
	assert_false(s.points[0].counter || s.points[201].counter);
	for (uint32_t i = 1; i < 201; i++) {
		const stilb_prof_point *point = &s.points[i];
		assert_true(point->counter);
		assert_string_equal(label_name(point->label), point->lane == 0 ? "mine" : "other");
		assert_true(point->value == (point->lane == 0 ? next[0] / 4.0 : next[1]));
		next[point->lane]++;
	}
}

/* A job of frame 0 that runs in frame 1, with a job of frame 1 inside it. */
static void jobs_are_charged_to_who_submitted_them(void **state)
{
	(void)state;
	stilb_prof_frame_mark();
	uint64_t first, second;
	{
		PROFILE("submit");
		first = stilb_prof_flow_begin(flow_job);
	}
	stilb_prof_frame_mark();
	second = stilb_prof_flow_begin(flow_job);
	{
		PROFILE("a");
		stilb_prof_flow_end(flow_job, first);
		{
			PROFILE("b");
		}
		{
			PROFILE("c");
			stilb_prof_flow_end(flow_job, second);
			PROFILE("d");
		}
	}
	{
		PROFILE("after");
	}
	stilb_prof_frame_mark();
	take(0);
	assert_tree(0, "submit a(b c(d)) after");
	assert_int_equal(find_zone(0, "submit")->frame, 0);
	assert_int_equal(find_zone(0, "a")->frame, 0);
	assert_int_equal(find_zone(0, "b")->frame, 0);
	assert_int_equal(find_zone(0, "c")->frame, 1);
	assert_int_equal(find_zone(0, "d")->frame, 1);
	assert_int_equal(find_zone(0, "after")->frame, 1);
	assert_int_equal(s.flow_count, 2);
	assert_int_equal(s.flows[0].id, first);
	assert_int_equal(s.flows[0].frame, 0);
	assert_int_equal(s.flows[1].id, second);
	assert_int_equal(s.flows[1].frame, 1);
	assert_string_equal(label_name(s.flows[0].label), "job flow");
	take(1); /* frame 0 is not in the window, so its job is charged to no frame */
	assert_int_equal(find_zone(0, "a")->frame, STILB_PROF_NONE);
	assert_int_equal(find_zone(0, "d")->frame, 0);
}

static void a_flow_has_any_number_of_ends(void **state)
{
	(void)state;
	uint64_t t = prof_clock_now();
	uint64_t lost = prof_flow_id(0, 5, 1), loop = prof_flow_id(0, 5, 2), waits = prof_flow_id(0, 5, 3);
	record_flow(&flow_job[1], t + 1000, 0, lost); /* the end of a flow whose begin was overwritten */
	record_flow(&flow_job[0], t + 2000, 0, loop);
	record_flow(&flow_job[0], t + 30000, 0, waits); /* the begin of a flow whose job has not run yet */
	stilb_prof_thread_end();
	assert_int_equal(stilb_prof_thread_begin("worker"), 0);
	record_flow(&flow_job[1], t + 20000, 0, loop);
	record_flow(&flow_job[1], t + 40000, 0, loop);
	take(0);
	assert_int_equal(s.flow_count, 4);
	assert_int_equal(s.flows[0].id, lost);
	assert_int_equal(s.flows[0].from_lane, STILB_PROF_NONE);
	assert_int_equal(s.flows[0].to_lane, 0);
	assert_int_equal(s.flows[0].from_ns, s.flows[0].to_ns);
	for (int i = 1; i < 4; i += 2) {
		assert_int_equal(s.flows[i].id, loop);
		assert_int_equal(s.flows[i].from_lane, 0);
		assert_int_equal(s.flows[i].to_lane, 1);
		assert_int_equal(s.flows[i].from_ns, s.flows[1].from_ns);
		assert_true(s.flows[i].to_ns > s.flows[i].from_ns);
	}
	assert_int_equal(s.flows[2].id, waits);
	assert_int_equal(s.flows[2].to_lane, STILB_PROF_NONE);
}

/* Clocks of two CPUs may differ; an arrow goes forward all the same. */
static void no_flow_goes_back_in_time(void **state)
{
	(void)state;
	uint64_t t = prof_clock_now(), id = prof_flow_id(0, 0, 1);
	record_flow(&flow_job[1], t + 1000, 0, id);
	record_flow(&flow_job[0], t + 2000, 0, id);
	take(0);
	assert_int_equal(s.flow_count, 1);
	assert_int_equal(s.flows[0].from_ns, s.flows[0].to_ns);
}

/* The flow ends in the tick in which its zone ends: viewers would put the arrow outside of the zone. */
static void a_flow_lies_inside_its_zone(void **state)
{
	(void)state;
	uint64_t t = prof_clock_now();
	uint64_t id = prof_flow_id(0, 0, 1);
	record_flow(&flow_job[0], t + 9000, 1, id);
	record(&site_a, t, t + 9000, 0);
	record_flow(&flow_job[1], t + 18000, 1, id);
	record(&site_b, t + 18000, t + 18000, 0); /* a zone without length: the flow keeps its time */
	take(0);
	assert_int_equal(s.flows[0].from_ns, find_zone(0, "a")->end_ns - 1);
	assert_int_equal(s.flows[0].to_ns, find_zone(0, "b")->end_ns);
}

/* Two flows at the end of a zone: the first lies in a child without length, the second in the zone itself, so that it
 * is moved before the zone's end. It must not pass the first. */
static void flows_stay_in_order(void **state)
{
	(void)state;
	uint64_t t = prof_clock_now();
	record_flow(&flow_job[1], t + 9000, 2, prof_flow_id(0, 0, 1));
	record(&site_b, t + 9000, t + 9000, 1);
	record_flow(&flow_job[1], t + 9000, 1, prof_flow_id(0, 0, 2));
	record(&site_a, t, t + 9000, 0);
	take(0);
	assert_tree(0, "a(b)");
	assert_int_equal(s.flows[0].id, prof_flow_id(0, 0, 1));
}

static void many_flows_are_joined(void **state)
{
	(void)state;
	enum { FLOWS = 10000 };
	uint64_t ids[FLOWS];
	stilb_prof_frame_mark();
	for (int i = 0; i < FLOWS; i++)
		ids[i] = stilb_prof_flow_begin(flow_job);
	for (int i = FLOWS; i-- > 0;)
		stilb_prof_flow_end(flow_job, ids[i]);
	take(0);
	assert_int_equal(s.flow_count, FLOWS);
	for (int i = 0; i < FLOWS; i++) {
		assert_int_equal(s.flows[i].id, ids[FLOWS - 1 - i]);
		assert_true(s.flows[i].from_lane == 0 && s.flows[i].to_lane == 0);
		assert_true(i == 0 || s.flows[i].from_ns <= s.flows[i - 1].from_ns);
	}
}

/* ---- devices and switches ---------------------------------------------------------------------------------------- */

static void devices_keep_their_own_time(void **state)
{
	(void)state;
	stilb_prof_lane_handle *lane;
	assert_int_equal(stilb_prof_lane_create("GPU", &lane), 0);
	uint64_t now = stilb_prof_clock_monotonic();
	stilb_prof_lane_zone(lane, &site_b, 1, now - 900, now - 500);
	stilb_prof_lane_zone(lane, &site_c, 1, now - 500, now - 100);
	stilb_prof_lane_zone(lane, &site_a, 0, now - 1000, now);
	stilb_prof_lane_destroy(lane);
	take(0);
	assert_int_equal(s.lane_count, 2);
	assert_string_equal(s.lanes[1].name, "GPU");
	assert_int_equal(s.lanes[1].kind, STILB_PROF_LANE_DEVICE);
	assert_int_equal(s.lanes[1].tid, 0);
	assert_tree(1, "a(b c)");
	assert_int_equal(find_zone(1, "a")->end_ns + s.epoch_ns, now);
	assert_int_equal(find_zone(1, "b")->begin_ns + s.epoch_ns, now - 900);
	assert_int_equal(find_zone(1, "a")->self_ns, 200);
}

/* Begins a thread with these switches, whose times are given relative to now. */
static void begin_thread_with_switches(prof_switch_event *events, uint32_t count)
{
	stilb_prof_thread_end();
	made_switches = events;
	made_switch_count = count;
	assert_int_equal(stilb_prof_thread_begin("switched"), 0);
	uint64_t now = stilb_prof_clock_monotonic();
	for (uint32_t i = 0; i < count; i++)
		events[i].ns += now;
}

static void record_ns(const stilb_prof_site *site, uint32_t depth, uint64_t now_ns, int64_t begin, int64_t end)
{
	prof_anchor anchor = prof_clock_anchor();
	double ticks = s.hz / 1e9, offset = (double)now_ns - (double)anchor.ns;
	record(site, anchor.ticks + (uint64_t)(int64_t)(ticks * (offset + (double)begin)),
	       anchor.ticks + (uint64_t)(int64_t)(ticks * (offset + (double)end)), depth);
}

/* A zone of 10 ms: the thread was out when it began, came back, was out for a while in the middle, and again at its
 * end. */
static void switches_become_time_off_the_cpu(void **state)
{
	(void)state;
	enum { US = 1000, MARGIN = 500 };
	prof_switch_event events[] = {
		{.ns = 100 * US, .in = true}, /* comes back; since when it was out is not known */
		{.ns = 500 * US, .preempted = true},
		{.ns = 3000 * US, .in = true},
		{.ns = 6000 * US},
		{.ns = 7000 * US, .in = true},
		{.ns = 10000 * US},
	};
	take(0); /* only for s.hz */
	begin_thread_with_switches(events, 6);
	uint64_t t = events[0].ns + 900 * US;
	record_ns(&site_b, 1, t, 3000 * US, 4000 * US);
	record_ns(&site_c, 1, t, 4500 * US, 7500 * US);
	record_ns(&site_a, 0, t, 0, 10000 * US);
	sleep_ms(12);
	take(0);
	const stilb_prof_lane *lane = &s.lanes[1];
	assert_int_equal(lane->switch_count, 3);
	assert_int_equal(lane->switches[0].out_ns + s.epoch_ns, events[1].ns);
	assert_int_equal(lane->switches[0].in_ns + s.epoch_ns, events[2].ns);
	assert_true(lane->switches[0].preempted && !lane->switches[1].preempted);
	assert_int_equal(lane->switches[2].in_ns, s.end_ns); /* it is still off the CPU */
	assert_in_range(find_zone(1, "a")->off_cpu_ns, 4000 * US - MARGIN, 4000 * US + MARGIN); /* 2 + 1 + 1 ms */
	assert_int_equal(find_zone(1, "b")->off_cpu_ns, 0);
	assert_int_equal(find_zone(1, "c")->off_cpu_ns, 1000 * US);
	stilb_prof_frame_mark();
	sleep_ms(1);
	stilb_prof_frame_mark();
	take(1);
	assert_int_equal(s.lanes[1].switch_count, 1); /* the other switches were over before the frame began */
	assert_true(s.lanes[1].switches[0].out_ns < s.begin_ns);
}

/* Two frames of 5 ms; a thread was out from the first to the second, another began when they were over. */
static void a_closed_window_cuts_switches(void **state)
{
	(void)state;
	prof_switch_event events[] = {{.ns = 2000000}, {.ns = UINT64_C(7000000000), .in = true}};
	stilb_prof_frame_mark();
	begin_thread_with_switches(events, 2);
	sleep_ms(5);
	stilb_prof_frame_mark();
	sleep_ms(5);
	stilb_prof_thread_end();
	assert_int_equal(stilb_prof_thread_begin("late"), 0);
	stilb_prof_window window = {.first_frame = 0, .frame_count = 1};
	assert_int_equal(stilb_prof_snapshot_take(&s, &window), 0);
	check_snapshot();
	assert_int_equal(s.lanes[1].switch_count, 2); /* the time before it began, and the switch */
	assert_int_equal(s.lanes[1].switches[1].out_ns + s.epoch_ns, events[0].ns);
	assert_int_equal(s.lanes[1].switches[1].in_ns, s.end_ns);
	assert_int_equal(s.lanes[2].switch_count, 1);
	assert_int_equal(s.lanes[2].switches[0].out_ns, s.begin_ns);
	assert_int_equal(s.lanes[2].switches[0].in_ns, s.end_ns);
}

/* Before it begins and after it has ended a thread does not run; what an earlier thread of the name did stays as it
 * was. */
static void threads_that_come_and_go(void **state)
{
	(void)state;
	{
		PROFILE("main");
		sleep_ms(2);
	}
	begin_thread_with_switches((prof_switch_event[1]){{0}}, 0);
	{
		PROFILE("late");
		sleep_ms(1);
	}
	stilb_prof_thread_end();
	sleep_ms(2);
	take(0);
	const stilb_prof_lane *lane = &s.lanes[1];
	stilb_prof_zone late = *find_zone(1, "late");
	assert_int_equal(lane->switch_count, 2);
	assert_int_equal(lane->switches[0].out_ns, s.begin_ns);
	assert_in_range(lane->switches[0].in_ns, s.begin_ns + 2000000, late.begin_ns);
	assert_in_range(lane->switches[1].out_ns, late.end_ns, s.end_ns - 2000000);
	assert_int_equal(lane->switches[1].in_ns, s.end_ns);
	assert_int_equal(late.off_cpu_ns, 0);
	assert_int_equal(stilb_prof_thread_begin("switched"), 0); /* takes over the ring */
	{
		PROFILE("later");
	}
	take(0);
	lane = &s.lanes[1];
	assert_int_equal(lane->zone_count, 2);
	assert_int_equal(lane->switch_count, 1);
	assert_int_equal(lane->switches[0].out_ns, find_zone(1, "late")->end_ns);
	assert_in_range(lane->switches[0].in_ns, late.end_ns + 2000000, find_zone(1, "later")->begin_ns);
	assert_int_equal(find_zone(1, "late")->off_cpu_ns, 0);
	stilb_prof_thread_end();
	for (int i = 0; i < 2; i++) {
		sleep_ms(1);
		stilb_prof_frame_mark();
	}
	take(1); /* the thread had ended before this window begins */
	lane = &s.lanes[1];
	assert_int_equal(lane->switch_count, 1);
	assert_int_equal(lane->switches[0].out_ns, s.begin_ns);
	assert_int_equal(lane->switches[0].in_ns, s.end_ns);
}

/* The kernel has overwritten the oldest switches in its ring: before the oldest one left, it is unknown whether the
 * thread ran; the snapshot must not say that it did. */
static void switches_that_are_lost_are_not_known(void **state)
{
	(void)state;
	static prof_switch_event events[PROF_SWITCHES_MAX - 1];
	for (uint32_t i = 0; i < PROF_SWITCHES_MAX - 1; i++)
		events[i] = (prof_switch_event){.ns = 200000000 + 100 * (uint64_t)i, .in = i % 2 == 0};
	begin_thread_with_switches(events, PROF_SWITCHES_MAX - 1);
	{
		PROFILE("zone"); /* begins before events[0], which is 200 ms from now, on a busy machine too */
		sleep_ms(210);
	}
	take(0);
	assert_int_equal(s.lanes[1].switches_ns + s.epoch_ns, events[0].ns);
	assert_int_equal(s.lanes[1].switch_count, (PROF_SWITCHES_MAX - 1) / 2);
	assert_true(find_zone(1, "zone")->begin_ns < s.lanes[1].switches_ns);
	made_switch_count /= 2; /* the ring was not full: there have been no others */
	take(0);
	assert_int_equal(s.lanes[1].switches_ns, s.begin_ns);
}

static void a_thread_alone(void **state)
{
	(void)state;
	begin_thread_with_switches((prof_switch_event[1]){{0}}, 0);
	sleep_ms(1);
	take(0);
	assert_true(s.end_ns - s.begin_ns >= 1000000);
}

static void sleep_is_off_the_cpu(void **state)
{
	(void)state;
	stilb_prof_thread_end();
	stilb_prof_switches_set(true);
	assert_int_equal(stilb_prof_thread_begin("sleeper"), 0);
	{
		PROFILE("around");
		{
			PROFILE("before");
		}
		{
			PROFILE("sleep");
			sleep_ms(5);
		}
		sleep_ms(3);
	}
	take(0);
	const stilb_prof_lane *lane = &s.lanes[s.lane_count - 1];
	assert_string_equal(lane->name, "sleeper");
	assert_true(lane->tid > 0);
	if (lane->no_switches) {
		print_message("no context switches: %s\n", lane->no_switches);
		return;
	}
	uint64_t sleep = find_zone(s.lane_count - 1, "sleep")->off_cpu_ns;
	uint64_t around = find_zone(s.lane_count - 1, "around")->off_cpu_ns;
	assert_true(lane->switch_count >= 2);
	assert_true(sleep >= 4900000);
	assert_true(around >= sleep + 2900000);
}

/* ---- cost -------------------------------------------------------------------------------------------------------- */

static void work_through_frames(int frames)
{
	for (int i = 0; i < frames; i++) {
		stilb_prof_frame_mark();
		for (int k = 0; k < 50; k++) {
			PROFILE("outer");
			PROFILE_COUNTER("k", k);
			stilb_prof_flow_end(flow_job, stilb_prof_flow_begin(flow_job));
			PROFILE("inner");
		}
	}
}

static void memory_is_used_again(void **state)
{
	(void)state;
	work_through_frames(10);
	take(2);
	uint32_t labels = s.label_count;
	allocations = 0;
	for (int i = 0; i < 100; i++) {
		work_through_frames(1);
		assert_int_equal(stilb_prof_snapshot_take(&s, &(stilb_prof_window){.last_frames = 2}), 0);
	}
	assert_int_equal(allocations, 0);
	assert_int_equal(s.label_count, labels);
	check_snapshot();
}

static void no_memory(void **state)
{
	(void)state;
	int failures = 0;
	work_through_frames(3);
	stilb_prof_switches_set(true);
	take(0); /* measures the costs of the clock, which is done once */
	stilb_prof_snapshot_finish(&s);
	for (;; failures++) {
		fail_allocation = failures;
		int error = stilb_prof_snapshot_take(&s, NULL);
		bool failed = fail_allocation < 0;
		fail_allocation = -1;
		if (!failed)
			break;
		assert_int_equal(error, -ENOMEM);
		assert_null(s.memory);
		assert_int_equal(s.lane_count + s.label_count, 0);
	}
	assert_true(failures > 10);
	check_snapshot();
	assert_int_equal(s.lanes[0].zone_count, 300);
	assert_int_equal(s.point_count, 150);
	assert_int_equal(s.flow_count, 150);
}

/* Counters and flows in such a number that the array of points (or of marks) grows, and so moves, for the same event
 * for which the array of labels does: both arrays begin with room for 64, the labels' with one place kept free. */
#define GROWING_LABELS 64
static const stilb_prof_site growing_counters[GROWING_LABELS] STILB_PROF_SECTION_ = {
	[0 ... GROWING_LABELS - 1] = STILB_PROF_SITE_INIT_("counter", "", 0, STILB_PROF_KIND_COUNTER)};
static const stilb_prof_site growing_flows[GROWING_LABELS] STILB_PROF_SECTION_ = {
	[0 ... GROWING_LABELS - 1] = STILB_PROF_SITE_INIT_("flow", "", 0, STILB_PROF_KIND_FLOW_BEGIN)};

/* Fails each allocation of a first snapshot in turn. */
static void fail_each_allocation(void)
{
	for (int failures = 0;; failures++) {
		fail_allocation = failures;
		int error = stilb_prof_snapshot_take(&s, NULL);
		bool failed = fail_allocation < 0;
		fail_allocation = -1;
		if (!failed)
			break;
		assert_int_equal(error, -ENOMEM);
		assert_null(s.memory);
	}
	check_snapshot();
	assert_int_equal(s.label_count, GROWING_LABELS);
}

static void no_memory_for_a_label_when_points_have_moved(void **state)
{
	(void)state;
	for (int i = GROWING_LABELS - 1; i >= 0; i--) /* read back from the last */
		stilb_prof_counter(&growing_counters[i], i);
	stilb_prof_counter(&growing_counters[0], 0);
	fail_each_allocation();
	assert_int_equal(s.point_count, GROWING_LABELS + 1);
}

static void no_memory_for_a_label_when_flows_have_moved(void **state)
{
	(void)state;
	for (int i = GROWING_LABELS - 1; i >= 0; i--)
		stilb_prof_flow_begin(&growing_flows[i]);
	stilb_prof_flow_begin(&growing_flows[0]);
	fail_each_allocation();
	assert_int_equal(s.flow_count, GROWING_LABELS + 1);
}

/* ---- a thread that records meanwhile ----------------------------------------------------------------------------- */

static volatile bool stop;

static void *be_busy(void *unused)
{
	(void)unused;
	uint64_t id = 0;
	stilb_prof_thread_begin("busy");
	/* Relaxed: the flag only ends the loop, and no other data is published with it. */
	while (!__atomic_load_n(&stop, __ATOMIC_RELAXED)) {
		PROFILE("outer");
		stilb_prof_flow_end(flow_job, id);
		id = stilb_prof_flow_begin(flow_job);
		for (int i = 0; i < 10; i++) {
			PROFILE("middle");
			PROFILE_COUNTER("i", i);
			PROFILE("inner");
			PROFILE_NEXT("next");
		}
	}
	stilb_prof_thread_end();
	return NULL;
}

static void snapshots_of_a_busy_thread(void **state)
{
	(void)state;
	pthread_t thread;
	assert_int_equal(stilb_prof_ring_events_set(256), 0);
	__atomic_store_n(&stop, false, __ATOMIC_RELAXED); /* the thread that reads it starts later */
	assert_int_equal(pthread_create(&thread, NULL, be_busy, NULL), 0);
	for (int i = 0; i < 300 || s.events_lost == 0; i++) { /* the thread may begin late */
		stilb_prof_frame_mark();
		take(i % 2 == 0 ? 0 : 2);
	}
	__atomic_store_n(&stop, true, __ATOMIC_RELAXED); /* read by be_busy; no data depends on it */
	pthread_join(thread, NULL);
	take(0);
	assert_int_equal(s.lane_count, 2);
	assert_true(s.lanes[1].zone_count > 100);
	assert_true(s.events_lost > 0);
}

#define SNAPSHOT_TEST(f) cmocka_unit_test_setup_teardown(f, begin_thread, shut_down)

int main(void)
{
	const struct CMUnitTest tests[] = {
		SNAPSHOT_TEST(ties_keep_the_tree),
		SNAPSHOT_TEST(children_without_their_parent),
		SNAPSHOT_TEST(overlaps_are_cut),
		SNAPSHOT_TEST(random_trees_come_back),
		SNAPSHOT_TEST(open_zones),
		SNAPSHOT_TEST(times_are_true),
		SNAPSHOT_TEST(nothing_recorded),
		SNAPSHOT_TEST(the_last_frames_are_remembered),
		SNAPSHOT_TEST(last_frames_leaves_the_rest_out),
		SNAPSHOT_TEST(a_zone_that_begins_with_its_frame),
		SNAPSHOT_TEST(frames_by_number),
		SNAPSHOT_TEST(a_zone_across_the_windows_begin),
		SNAPSHOT_TEST(points_of_all_threads_in_order),
		SNAPSHOT_TEST(jobs_are_charged_to_who_submitted_them),
		SNAPSHOT_TEST(a_flow_has_any_number_of_ends),
		SNAPSHOT_TEST(no_flow_goes_back_in_time),
		SNAPSHOT_TEST(a_flow_lies_inside_its_zone),
		SNAPSHOT_TEST(flows_stay_in_order),
		SNAPSHOT_TEST(many_flows_are_joined),
		SNAPSHOT_TEST(devices_keep_their_own_time),
		SNAPSHOT_TEST(switches_become_time_off_the_cpu),
		SNAPSHOT_TEST(a_closed_window_cuts_switches),
		SNAPSHOT_TEST(threads_that_come_and_go),
		SNAPSHOT_TEST(switches_that_are_lost_are_not_known),
		SNAPSHOT_TEST(a_thread_alone),
		SNAPSHOT_TEST(sleep_is_off_the_cpu),
		SNAPSHOT_TEST(memory_is_used_again),
		SNAPSHOT_TEST(no_memory),
		SNAPSHOT_TEST(no_memory_for_a_label_when_points_have_moved),
		SNAPSHOT_TEST(no_memory_for_a_label_when_flows_have_moved),
		SNAPSHOT_TEST(snapshots_of_a_busy_thread),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
