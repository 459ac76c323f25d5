/* Zones: sites, nesting, what is recorded and how it reads in a trace. */
#include "test_prof_capture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>

#include <cmocka.h>

static int begin_thread(void **state)
{
	(void)state;
	return stilb_prof_thread_begin("main");
}

static int shut_down(void **state)
{
	(void)state;
	stilb_prof_shutdown();
	return 0;
}

/* The names of zones in the order of the text, joined by spaces. */
static void zone_names(const char *text, char *names, size_t size)
{
	size_t used = 0;
	names[0] = 0;
	for (const char *line = text; (line = strchr(line, '\n')) != NULL; line++) {
		const char *name = strstr(line, "\"name\":\"");
		if (strncmp(line + 1, "{\"ph\":\"X\"", 9) != 0 && strncmp(line + 1, "{\"ph\":\"B\"", 9) != 0)
			continue;
		name += strlen("\"name\":\"");
		used +=
			(size_t)snprintf(names + used, size - used, "%s%.*s", used > 0 ? " " : "", (int)strcspn(name, "\""), name);
	}
}

static void assert_names(const char *expected)
{
	char names[1024];
	capture c;
	assert_trace(&c, 0);
	zone_names(c.text, names, sizeof names);
	capture_finish(&c);
	assert_string_equal(names, expected);
}

/* ---- sites ------------------------------------------------------------------------------------------------------ */

__attribute__((noinline, used)) static void never_called(void)
{
	PROFILE_COLOR("listed before it runs", 0x123456);
}

static void sites_form_an_array(void **state)
{
	(void)state;
	size_t count = 0, found = 0;
	const stilb_prof_site *sites = stilb_prof_sites(&count);
	assert_int_equal(sizeof(stilb_prof_site), 64);
	assert_int_equal(_Alignof(stilb_prof_site), 64);
	for (size_t i = 0; i < count; i++) {
		assert_non_null(sites[i].name);
		if (strcmp(sites[i].name, "listed before it runs") != 0)
			continue;
		found++;
		assert_string_equal(sites[i].function, "never_called");
		assert_string_equal(strrchr(sites[i].file, '/') + 1, "test_prof_zones.c");
		assert_int_equal(sites[i].color, 0x123456);
		assert_true(sites[i].line > 0);
	}
	assert_int_equal(found, 1);
}

/* ---- recording -------------------------------------------------------------------------------------------------- */

__attribute__((noinline)) static void function_zone(void)
{
	PROFILE_FUNCTION();
	PROFILE("second");
	PROFILE("third");
}

static int leave_by_return(int i)
{
	PROFILE("loop");
	while (true) {
		PROFILE("pass");
		if (i-- == 0)
			return 1;
	}
}

static void scopes_nest(void **state)
{
	(void)state;
	function_zone();
	leave_by_return(1);
	assert_names("function_zone second third loop pass pass");
	capture c;
	assert_trace(&c, 0);
	assert_int_equal(c.report.zones, 6);
	assert_int_equal(c.report.open_zones, 0);
	assert_int_equal(trace_check_zones(&c.report, "main", "pass"), 2);
	capture_finish(&c);
}

STILB_PROF_SITE(hook_site, "hook", 0);
STILB_PROF_SITE(deep_site, "deep", 0);

static void without_a_ring_nothing_is_recorded(void **state)
{
	(void)state;
	stilb_prof_thread_end();
	{
		PROFILE("unseen");
		assert_int_equal(stilb_prof_thread_begin("main"), 0);
		{
			PROFILE("seen");
		}
	}
	assert_names("seen");
	{
		PROFILE("cut off");
		stilb_prof_thread_end();
	}
	assert_names("seen");
	assert_int_equal(stilb_prof_thread_begin("main"), 0);
	{
		PROFILE("again");
	}
	assert_names("seen again");
}

static void a_zone_older_than_its_ring_is_dropped(void **state)
{
	(void)state;
	stilb_prof_thread_end();
	{
		PROFILE("unseen");
		assert_int_equal(stilb_prof_thread_begin("main"), 0);
		stilb_prof_zone_begin(&hook_site);
	}
	stilb_prof_zone_end();
	assert_names("hook");
}

static void zones_of_another_ring_are_dropped(void **state)
{
	(void)state;
	capture c;
	{
		PROFILE("outer");
		PROFILE("inner");
		stilb_prof_thread_end();
		assert_int_equal(stilb_prof_thread_begin("another"), 0);
		{
			PROFILE("whole");
		}
	}
	assert_int_equal(stilb_prof_thread_ring->depth, 0);
	assert_trace(&c, 0);
	assert_int_equal(c.report.zones, 1);
	assert_int_equal(trace_check_zones(&c.report, "another", "whole"), 1);
	capture_finish(&c);
}

static void zones_of_two_functions(void **state)
{
	(void)state;
	stilb_prof_zone_end(); /* without a begin */
	stilb_prof_zone_begin(&hook_site);
	{
		PROFILE("inside");
		stilb_prof_zone_begin(&deep_site);
		stilb_prof_zone_end();
	}
	stilb_prof_zone_end();
	stilb_prof_zone_end();
	assert_names("hook inside deep");
}

static void recurse(int depth)
{
	PROFILE("recurse");
	if (depth > 1)
		recurse(depth - 1);
}

static void deeper_than_the_stack(void **state)
{
	(void)state;
	capture c;
	for (int i = 0; i < 100; i++)
		stilb_prof_zone_begin(&deep_site);
	for (int i = 0; i < 100; i++)
		stilb_prof_zone_end();
	recurse(100);
	recurse(3);
	assert_int_equal(stilb_prof_thread_ring->depth, 0);
	assert_trace(&c, 0);
	assert_int_equal(trace_check_zones(&c.report, NULL, "deep"), STILB_PROF_DEPTH_MAX);
	assert_int_equal(trace_check_zones(&c.report, NULL, "recurse"), 103);
	capture_finish(&c);
}

static void record(const stilb_prof_site *site, uint64_t begin, uint64_t end, uint32_t depth)
{
	stilb_prof_close(stilb_prof_thread_ring, site, begin, end, depth);
	stilb_prof_thread_ring->depth = 0; /* nothing was opened */
}

STILB_PROF_SITE(site_a, "a", 0);
STILB_PROF_SITE(site_b, "b", 0);
STILB_PROF_SITE(site_c, "c", 0);
STILB_PROF_SITE(site_d, "d", 0);

/* Depths are not told apart there: the times must do. */
static void deeper_than_depths_are_kept(void **state)
{
	(void)state;
	const uint64_t t = prof_clock_now();
	record(&site_c, t + 200, t + 300, 102);
	record(&site_b, t + 100, t + 400, 101);
	record(&site_d, t + 500, t + 600, 101);
	record(&site_a, t, t + 700, 100);
	assert_names("a b c d");
}

static void open_zones_are_begun(void **state)
{
	(void)state;
	{
		PROFILE("outer");
		{
			PROFILE("done");
		}
		PROFILE("inner");
		capture c;
		assert_trace(&c, 0);
		assert_int_equal(c.report.open_zones, 2);
		assert_non_null(strstr(c.text, "{\"ph\":\"B\""));
		capture_finish(&c);
		assert_names("outer done inner");
	}
	capture c;
	assert_trace(&c, 0);
	assert_int_equal(c.report.open_zones, 0);
	assert_int_equal(c.report.zones, 3);
	capture_finish(&c);
	assert_names("outer done inner");
}

/* ---- order: events made by hand ----------------------------------------------------------------------------------- */

/* All begin in one tick; only depth and order tell b inside a, then c with d inside. */
static void ties_keep_the_tree(void **state)
{
	(void)state;
	const uint64_t t = prof_clock_now();
	record(&site_b, t, t, 1);
	record(&site_a, t, t, 0);
	record(&site_d, t, t + 5000, 1);
	record(&site_c, t, t + 9000, 0);
	assert_names("a b c d");
}

static void children_without_their_parent(void **state)
{
	(void)state;
	const uint64_t t = prof_clock_now();
	record(&site_b, t + 100, t + 200, 2);
	record(&site_c, t + 300, t + 400, 2);
	record(&site_a, t + 250, t + 500, 1); /* c is its child, b was of another whose event is gone */
	record(&site_d, t + 600, t + 700, 0);
	assert_names("b a c d");
}

/* What no correct program makes: the trace must still keep every rule. */
static void overlaps_are_cut(void **state)
{
	(void)state;
	const uint64_t t = prof_clock_now();
	record(&site_a, t, t + 5000, 0);
	record(&site_b, t + 3000, t + 9000, 0);
	record(&site_c, t + 8000, t + 20000, 1);
	record(&site_d, t + 7000, t + 10000, 0);
	record(&site_a, t + 2000, t + 1000, 0); /* ends before it begins */
	capture c;
	assert_trace(&c, 0);
	assert_int_equal(c.report.zones, 5);
	capture_finish(&c);
}

static void durations_saturate(void **state)
{
	(void)state;
	const uint64_t t = prof_clock_now();
	stilb_prof_ring *ring = stilb_prof_thread_ring;
	record(&site_a, t, t + (UINT64_C(1) << 50), 0);
	assert_int_equal(ring->events[0].end >> 18, STILB_PROF_DURATION_MAX);
	record(&site_b, t, t - 1, 0);
	assert_int_equal(ring->events[1].end >> 18, 0);
}

static uint64_t random_state = 1;

static uint64_t random_below(uint64_t limit)
{
	random_state = random_state * 6364136223846793005u + 1442695040888963407u;
	return (random_state >> 33) % limit;
}

/* A random tree in the order of its ends; steps of 0 to 3 ticks, so that many times are equal, in ticks and in ns. */
static uint64_t record_tree(uint64_t t, uint32_t depth, int *left)
{
	const uint64_t begin = t + random_below(4);
	t = begin;
	while (*left > 0 && depth < 70 && random_below(8) < 6) {
		--*left;
		t = record_tree(t, depth + 1, left);
	}
	t += random_below(4);
	record(&site_a, begin, t, depth);
	return t;
}

static void random_trees_keep_every_rule(void **state)
{
	(void)state;
	uint64_t t = prof_clock_now();
	int left = 30000, roots = 0;
	for (; left > 0; roots++)
		t = record_tree(t, 0, &left);
	capture c;
	assert_trace(&c, 0);
	assert_int_equal(c.report.zones, 30000 + roots);
	capture_finish(&c);
}

/* g++ cannot put its sites into the section: they lie anywhere in the image. */
static void sites_outside_the_section(void **state)
{
	(void)state;
	static const stilb_prof_site elsewhere = STILB_PROF_SITE_INIT_("elsewhere", "", 0);
	static stilb_prof_site writable = STILB_PROF_SITE_INIT_("writable", "", 0);
	const uint64_t t = prof_clock_now();
	record(&elsewhere, t, t + 1, 0);
	record(&writable, t + 2, t + 3, 0);
	assert_names("elsewhere writable");
}

/* ---- names -------------------------------------------------------------------------------------------------------- */

static void names_are_escaped(void **state)
{
	(void)state;
	capture c;
	stilb_prof_thread_end();
	assert_int_equal(stilb_prof_thread_begin("\"t\"\\\t\n\x01\x7f \xc3\xa4 \xf0\x9f\x90\x9f"), 0);
	{
		PROFILE("a\"b\\c/\b\f\n\r\t\x1f \xe2\x82\xac");
	}
	{
		PROFILE("bad\xff|\xc0\x80|\xed\xa0\x80|\xf5|\xe2\x82");
	}
	assert_trace(&c, 0);
	assert_int_equal(trace_check_zones(&c.report, "\"t\"\\\t\n\x01\x7f \xc3\xa4 \xf0\x9f\x90\x9f",
	                                   "a\"b\\c/\b\f\n\r\t\x1f \xe2\x82\xac"),
	                 1);
#define BAD "\xef\xbf\xbd"
	assert_int_equal(trace_check_zones(&c.report, NULL, "bad" BAD "|" BAD BAD "|" BAD BAD BAD "|" BAD "|" BAD BAD), 1);
	capture_finish(&c);
}

static void long_thread_names_are_cut(void **state)
{
	(void)state;
	char name[200], cut[PROF_NAME_MAX];
	capture c;
	memset(name, 'n', sizeof name);
	name[sizeof name - 1] = 0;
	memset(cut, 'n', sizeof cut);
	cut[sizeof cut - 1] = 0;
	stilb_prof_thread_end();
	assert_int_equal(stilb_prof_thread_begin(name), 0);
	{
		PROFILE("zone");
	}
	assert_trace(&c, 0);
	assert_int_equal(trace_check_zones(&c.report, cut, "zone"), 1);
	capture_finish(&c);
}

#define ZONE_TEST(f) cmocka_unit_test_setup_teardown(f, begin_thread, shut_down)

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(sites_form_an_array),
		ZONE_TEST(scopes_nest),
		ZONE_TEST(without_a_ring_nothing_is_recorded),
		ZONE_TEST(a_zone_older_than_its_ring_is_dropped),
		ZONE_TEST(zones_of_another_ring_are_dropped),
		ZONE_TEST(zones_of_two_functions),
		ZONE_TEST(deeper_than_the_stack),
		ZONE_TEST(deeper_than_depths_are_kept),
		ZONE_TEST(open_zones_are_begun),
		ZONE_TEST(ties_keep_the_tree),
		ZONE_TEST(children_without_their_parent),
		ZONE_TEST(overlaps_are_cut),
		ZONE_TEST(durations_saturate),
		ZONE_TEST(random_trees_keep_every_rule),
		ZONE_TEST(sites_outside_the_section),
		ZONE_TEST(names_are_escaped),
		ZONE_TEST(long_thread_names_are_cut),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
