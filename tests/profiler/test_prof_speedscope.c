/* Every zone that a trace holds comes back from a viewer that many use: speedscope, in a headless Chromium. */
#include "profiler/prof_trace.h"
#include "support/prof_made.h"
#include "support/program.h"
#include "support/test.h"

#include <errno.h>
#include <inttypes.h>
#include <limits.h>
#include <math.h>
#include <stddef.h>
#include <sys/stat.h>

static const char *node, *script, *modules, *chromium;

/* The output of speedscope, read line by line. */
typedef struct said {
	FILE *file;
	char line[512];
	uint64_t zones;
} said;

static bool said_next(said *s)
{
	bool more = fgets(s->line, sizeof s->line, s->file);
	s->line[more ? strcspn(s->line, "\n") : 0] = '\0';
	return more;
}

static said open_in_speedscope(const made *m)
{
	static program_run run;
	said s = {.file = tmpfile()};
	assert_non_null(s.file);
	assert_true(mkdir("test_prof_speedscope_files", 0777) == 0 || errno == EEXIST);
	assert_int_equal(stilb_prof_trace_save(&m->snapshot, "test", "test_prof_speedscope_files/t.json"), 0);
	char *folder = realpath("test_prof_speedscope_files", NULL), trace[PATH_MAX];
	assert_non_null(folder);
	snprintf(trace, sizeof trace, "%s/t.json", folder);
	const char *const words[] = {node, script, modules, chromium, trace, folder, NULL};
	assert_true(program_start(&run, words, NULL, fileno(s.file)));
	program_wait(&run);
	free(folder);
	if (run.code != 0)
		fail_msg("node: %d\n%s", run.code, run.err);
	rewind(s.file);
	return s;
}

/* Reads the next line and asserts its event: type 'O' (opens) or 'C' (closes), time and name. */
static void assert_event(said *s, char type, uint64_t ns, const char *name)
{
	double at = 0.0;
	int used = 0;
	assert_true(said_next(s));
	if (s->line[0] != type || sscanf(s->line + 1, " %lf %n", &at, &used) != 1 ||
	    strcmp(s->line + 1 + used, name) != 0 || fabs(at * 1000.0 - (double)ns) > 0.6)
		fail_msg("'%s' instead of %c %" PRIu64 " ns %s", s->line, type, ns, name);
}

/* Zones as opening and closing events, in the order of the tree; times count from the first. */
static void assert_lane(said *s, const stilb_prof_snapshot *snapshot, const stilb_prof_lane *lane)
{
	uint32_t open = STILB_PROF_NONE;
	uint64_t first = lane->zones[0].begin_ns;
	for (uint32_t i = 0; i <= lane->zone_count; i++) {
		uint32_t parent = i < lane->zone_count ? lane->zones[i].parent : STILB_PROF_NONE;
		for (; open != parent; open = lane->zones[open].parent)
			assert_event(s, 'C', lane->zones[open].end_ns - first, snapshot->labels[lane->zones[open].label].name);
		if (i < lane->zone_count) {
			assert_event(s, 'O', lane->zones[i].begin_ns - first, snapshot->labels[lane->zones[i].label].name);
			open = i;
			s->zones++;
		}
	}
}

/* Moves to the profile of a lane in the output; profiles may stand in any order. False: there is none. */
static bool find_profile(said *s, const char *name, uint32_t tid)
{
	char end[64];
	snprintf(end, sizeof end, "), %s (tid %" PRIu32 ")", name, tid);
	rewind(s->file);
	while (said_next(s)) {
		size_t size = strlen(s->line), end_size = strlen(end);
		if (strncmp(s->line, "profile ", 8) == 0 && size > end_size && strcmp(s->line + size - end_size, end) == 0)
			return true;
	}
	return false;
}

static void assert_all_lanes(const made *m, uint64_t *zones)
{
	said s = open_in_speedscope(m);
	for (uint32_t i = 0; i < m->snapshot.lane_count; i++)
		if (m->lanes[i].zone_count > 0) {
			if (!find_profile(&s, m->lanes[i].name, 2 + 2 * i))
				fail_msg("speedscope has no thread %s", m->lanes[i].name);
			assert_lane(&s, &m->snapshot, &m->lanes[i]);
		}
	*zones += s.zones;
	fclose(s.file);
}

static void zones_by_chance(void **state)
{
	(void)state;
	uint64_t zones = 0;
	for (uint64_t seed = 30; seed < 40; seed++) {
		made m;
		made_by_chance_from(&m, (made_random){.state = seed, .no_empty = true}); /* which speedscope leaves out */
		assert_all_lanes(&m, &zones);
		made_finish(&m);
	}
	assert_true(zones > 300);
	print_message("%" PRIu64 " zones came back\n", zones);
}

static void many_zones(void **state)
{
	(void)state;
	uint64_t zones = 0;
	made m;
	made_init(&m, 2);
	for (uint32_t lane = 0; lane < 2; lane++)
		for (uint64_t f = 0; f < 30; f++) {
			made_push(&m, lane, 0, 20000000 * f);
			for (uint64_t i = 0; i < 300; i++) { /* each touches the next */
				made_push(&m, lane, 1 + i % 3, 20000000 * f + 60000 * i);
				made_push(&m, lane, 6, 20000000 * f + 60000 * i);
				made_pop(&m, lane, 20000000 * f + 60000 * i + 60000);
				made_pop(&m, lane, 20000000 * f + 60000 * i + 60000);
			}
			made_pop(&m, lane, 20000000 * (f + 1));
		}
	made_derive(&m);
	assert_all_lanes(&m, &zones);
	assert_int_equal(zones, 2 * 30 * 601);
	print_message("%" PRIu64 " zones came back\n", zones);
	made_finish(&m);
}

/* True if CMake has not found that program or folder. */
static bool is_missing(const char *path)
{
	return strstr(path, "NOTFOUND");
}

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(zones_by_chance),
		cmocka_unit_test(many_zones),
	};
	if (argc != 5) {
		fprintf(stderr, "usage: test_prof_speedscope NODE SCRIPT MODULES CHROMIUM\n");
		return 1;
	}
	node = argv[1];
	script = argv[2];
	modules = argv[3];
	chromium = argv[4];
	if (is_missing(node) || is_missing(modules) || is_missing(chromium)) {
		printf("skipped: no %s; npm install speedscope puppeteer-core, apt-get install chromium-headless-shell\n",
		       is_missing(node)      ? "node"
		       : is_missing(modules) ? "speedscope in STILB_NODE_MODULES"
		                             : "Chromium");
		return 77;
	}
	return cmocka_run_group_tests(tests, NULL, NULL);
}
