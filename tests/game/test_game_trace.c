/* stilb trace top and diff: tables, JSON, exit codes, and messages on files that are no traces. */
#include "profiler/prof_trace.h"
#include "support/prof_made.h"
#include "support/stilb_program.h"

static const char *lines_find(const char *name)
{
	static char line[512];
	for (const char *at = run.out, *end; (end = strchr(at, '\n')); at = end + 1) {
		snprintf(line, sizeof line, "%.*s", (int)(end - at), at);
		size_t size = strlen(line), name_size = strlen(name);
		if (size > name_size + 2 && strcmp(line + size - name_size, name) == 0 && line[size - name_size - 1] == ' ')
			return line;
	}
	print_error("no line of '%s' in\n%s\n", name, run.out);
	fail();
	return NULL;
}

static void save(const made *m, const char *path)
{
	assert_int_equal(stilb_prof_trace_save(&m->snapshot, "test", path), 0);
}

/* Writes a trace of the frames 100 to 139, in which the zone cull takes about cull_ns and record 5,000 ns, but 35,000
 * ns in frame 120. */
static void make_trace(const char *path, uint64_t seed, uint64_t cull_ns)
{
	made m;
	made_random random = {.state = seed};
	uint64_t at = 5000;
	made_init(&m, 3);
	m.lanes[2].kind = STILB_PROF_LANE_DEVICE;
	for (uint64_t f = 0; f < 40; f++) {
		uint64_t begin = at;
		made_push(&m, 0, 0, at);
		made_push(&m, 0, 1, at += 10);
		made_pop(&m, 0, at += cull_ns + made_below(&random, 50));
		made_push(&m, 0, 2, at);
		made_push(&m, 1, 11, at + 100);
		made_flow(&m, (stilb_prof_flow){
						  .id = f + 1, .from_ns = at, .to_ns = at + 490 - 10 * f, .to_lane = 1, .frame = (uint32_t)f});
		made_pop(&m, 1, at + 4000);
		made_pop(&m, 0, at += 5000 + made_below(&random, 50) + (f == 20 ? 30000 : 0));
		made_push(&m, 2, 2, begin);
		made_pop(&m, 2, begin + 1000);
		made_pop(&m, 0, at += 100);
		made_frame(&m, 100 + f, begin, at);
	}
	made_switch(&m, 0, 6000, 8000, false);
	m.snapshot.begin_ns = 5000;
	m.snapshot.end_ns = at;
	made_derive(&m);
	save(&m, path);
	made_finish(&m);
}

static void test_top(void **state)
{
	(void)state;
	make_trace("a.json", 1, 2000);
	stilb_good("trace top a.json");
	assert_said(run.out, "a.json: 0.3");
	assert_said(run.out, "3 lanes, 200 zones, 40 frames");
	assert_said(run.out, "the slowest is 120 with 0.037 ms");
	assert_said(run.out, "400 older events were overwritten, 3 zones nested too deep");
	assert_said(run.out, "2 zones and other events are missing: there was no memory to record their threads");
	long long calls;
	double total, self, share, off_cpu, p50;
	assert_int_equal(
		sscanf(lines_find("cull"), "%lld %lf %lf %lf %lf %lf", &calls, &total, &self, &share, &off_cpu, &p50), 6);
	assert_int_equal(calls, 40);
	assert_true(total > 0.080 && total < 0.082 && self == total && p50 >= 2.0 && p50 < 2.05 && share > 10.0);
	assert_true(off_cpu == 0.001);
	lines_find("record (device)");
	assert_said(run.out, "40 jobs ran after a delay of p50 0.290 us, p99 0.490 us, max 0.490 us in the queue");
	stilb_good("trace top a.json --frame slowest --lane main --sort name");
	assert_said(run.out, "frame 120: 0.037 ms");
	assert_false(strstr(run.out, "record segment"));
	assert_true(strstr(run.out, " cull\n") < strstr(run.out, " frame\n") &&
	            strstr(run.out, " frame\n") < strstr(run.out, " record\n"));
	assert_int_equal(sscanf(lines_find("record"), "%lld %lf", &calls, &total), 2);
	assert_true(calls == 1 && total > 0.034);
	assert_false(strstr(run.out, "in the queue")); /* no job ran on that lane */
	stilb_good("trace top a.json --frame 101");
	assert_said(run.out, "1 job ran after a delay of p50 0.480 us");
	stilb_good("trace top a.json --frame 139 --lines 2");
	assert_said(run.out, "frame 139: 0.007 ms");
	assert_said(run.out, "and 3 more: --lines 5");
}

static void test_top_json(void **state)
{
	(void)state;
	make_trace("a.json", 1, 2000);
	stilb_good("trace top a.json --json top.json --sort calls");
	read_stats("top.json");
	assert_string_equal(stat_text("file", '"'), "a.json");
	assert_int_equal(stat_int("frames"), 40);
	assert_int_equal(stat_int("zones"), 200);
	assert_string_equal(stat_text("rows[0].zone", '"'), "cull");
	assert_int_equal(stat_int("rows[0].calls"), 40);
	assert_in_range(stat_int("rows[0].p50_ns"), 2000, 2050);
	assert_int_equal(stilb_code(no_display, "trace top a.json --json -"), 0);
	json_flat_finish(&stats);
	assert_true(json_flat_text(run.out, strlen(run.out), &stats)); /* nothing but JSON */
	assert_said(run.err, "off-CPU ms");
}

static void test_diff(void **state)
{
	(void)state;
	make_trace("a.json", 1, 2000);
	make_trace("b.json", 2, 2000);
	make_trace("c.json", 3, 2600);
	stilb_good("trace diff a.json b.json");
	assert_said(run.out, "\n0 of 5 zones are slower by more than 5 % (alpha 0.01)\n");
	assert_int_equal(stilb_code(no_display, "trace diff a.json c.json --json d.json"), 1);
	assert_string_equal(run.err, "");
	assert_said(run.out, "\n2 of 5 zones are slower"); /* cull and the frame around it */
	assert_true(strncmp(lines_find("cull"), "slower ", 7) == 0);
	assert_said(lines_find("cull"), " +29.");
	assert_true(strncmp(lines_find("record"), "same ", 5) == 0);
	read_stats("d.json");
	assert_int_equal(stat_int("slower"), 2);
	assert_string_equal(stat_text("rows[1].zone", '"'), "cull");
	assert_string_equal(stat_text("rows[1].verdict", '"'), "slower");
	assert_in_range(stat_int("rows[1].b.p50_ns"), 2600, 2650);
	assert_true(stat_ms("rows[1].ratio") > 1.27 && stat_ms("rows[1].ratio") < 1.32);
	stilb_good("trace diff c.json a.json");
	assert_true(strncmp(lines_find("cull"), "faster ", 7) == 0);
	stilb_good("trace diff a.json c.json --threshold 50.5");
	stilb_good("trace diff a.json c.json --alpha 0");
	assert_int_equal(stilb_code(no_display, "trace diff a.json c.json --per frame --threshold 20"), 1);
	assert_said(run.out, "a zone's time in a frame");
}

/* A trace that stilb demo wrote: as a table, by name and on standard input, and compared with itself. */
static void test_of_the_demo(void **state)
{
	(void)state;
	char command[3 * PATH_MAX];
	stilb_good("demo --headless --device null --frames 20 --models 400 --size 320x180 --trace t.json");
	stilb_good("trace top t.json --sort total");
	assert_said(run.out, " frames (");
	lines_find("record");
	snprintf(command, sizeof command, "'%s' trace top - < t.json > said", stilb_path);
	assert_int_equal(system(command), 0);
	assert_int_equal(system("grep -q 'record' said"), 0);
	stilb_good("trace diff t.json t.json");
	assert_said(run.out, "\n0 of ");
}

static void test_names_are_harmless(void **state)
{
	(void)state;
	FILE *file = fopen("a.json", "w");
	assert_non_null(file);
	fputs("[{\"ph\":\"X\",\"ts\":1,\"dur\":1,\"name\":\"a\\u001b[2Jb\\u009bc\\n\xc3\xa9\"}]", file);
	fclose(file);
	stilb_good("trace top a.json");
	assert_said(run.out, "  a?[2Jb?c?\xc3\xa9\n");
}

static void test_help(void **state)
{
	(void)state;
	static const char *const lines[][2] = {
		{"trace --help", "  top FILE "},
		{"trace --help", "  diff A B "},
		{"trace top --help", "\n  --sort "},
		{"trace top --help", "\n  --frame "},
		{"trace top --help", "\n  --lane "},
		{"trace top a.json --help", "\n  --json "},
		{"trace diff --help", "\n  --threshold "},
		{"trace diff --help", "\n  --alpha "},
		{"trace diff --help", "\n  --per "},
		{"trace diff a b --help", "Exit status 0"},
		{"--help", "  trace "},
	};
	for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) {
		stilb_good("%s", lines[i][0]);
		assert_said(run.out, lines[i][1]);
		for (const char *at = run.out, *end; (end = strchr(at, '\n')); at = end + 1)
			assert_true(end - at <= 110); /* columns of a usual terminal window */
	}
}

static const char *const refusals[][2] = {
	{"trace", "no part; give top, diff or show"},
	{"trace flop a.json", "'flop' is not known; give top, diff or show"},
	{"trace top", "no file"},
	{"trace top {}", "no file"},
	{"trace diff a.json", "stilb trace diff A B"},
	{"trace diff a.json {}", "no file"},
	{"trace top --lines 3 a.json", "give stilb trace top FILE [FLAGS]"},
	{"trace show --size 10x10 a.json", "give stilb trace show FILE [FLAGS]"},
	{"trace show none.json --screenshot x.png", "none.json"},
	{"trace show a.json --screenshot x.gif", "x.gif"},
	{"trace show a.json --frame 7", "100..139"},
	{"trace top a.json b.json", "'b.json'"},
	{"trace top a.json --bogus", "'--bogus'"},
	{"trace top a.json --sort size", "total, self, off-cpu"},
	{"trace top a.json --lines 0", "1..1000000"},
	{"trace top a.json --frame 99", "100..139"},
	{"trace top a.json --frame -1", "'-1'"},
	{"trace top a.json --frame fast", "'slowest'"},
	{"trace top bare.json --frame 1", "no whole frames in 'bare.json'"},
	{"trace top a.json --lane worker", "no thread or device 'worker'"},
	{"trace top a.json --json missing/b.json", "does not exist"},
	{"trace top a.json --json ./a.json", "would replace 'a.json'"},
	{"trace diff a.json bare.json --json bare.json", "would replace 'bare.json'"},
	{"trace diff a.json bare.json --per frame", "'bare.json'; use --per call"},
	{"trace diff a.json a.json --threshold -5", "'-5'"},
	{"trace diff a.json a.json --threshold 1e3", "'1e3'"},
	{"trace diff a.json a.json --alpha 1.5", "0..1"},
	{"trace diff a.json a.json --alpha .", "'.'"},
	{"trace diff a.json a.json --per zone", "call, frame"},
	{"trace top missing.json", "cannot read 'missing.json'"},
	{"trace top folder", "cannot read 'folder': Is a directory"},
	{"trace diff a.json missing.json", "'missing.json'"},
	{"trace top empty.json", "'empty.json', line 1, byte 1 of 0: expected a trace"},
	{"trace top text.json", "expected a Chrome trace: '{' or '[', but there is 'n'"},
	{"trace diff text.json a.json", "'text.json'"},
	{"trace top none.json", "'none.json' is a trace without zones"},
	{"trace diff a.json none.json", "'none.json' is a trace without zones"},
	{"trace top short.json", "but the file ends"},
	{"trace top /dev/null", "cannot read '/dev/null': it is a device or a pipe; give a regular file"},
	{"trace top pipe", "cannot read 'pipe': it is a device or a pipe"},
	{"trace show pipe --screenshot x.png", "cannot read 'pipe': it is a device or a pipe"},
	{"trace diff a.json pipe", "cannot read 'pipe': it is a device or a pipe"},
};

static void write_text(const char *path, const char *text)
{
	FILE *file = fopen(path, "w");
	assert_non_null(file);
	fputs(text, file);
	fclose(file);
}

static void test_refusals(void **state)
{
	(void)state;
	make_trace("a.json", 1, 2000);
	write_text("bare.json", "[{\"ph\":\"X\",\"ts\":1,\"dur\":1}]");
	write_text("empty.json", "");
	write_text("none.json", "{\"traceEvents\":[]}");
	write_text("text.json", "no trace");
	assert_int_equal(system("head -c 3000 a.json > short.json"), 0);
	assert_int_equal(mkdir("folder", 0777), 0);
	assert_int_equal(mkfifo("pipe", 0600), 0); /* without a writer: a reader would wait for ever */
	int entries = folder_entries();
	for (size_t i = 0; i < sizeof refusals / sizeof *refusals; i++) {
		int code = stilb_code(no_display, refusals[i][0]);
		if (code != 2 || !strstr(run.err, refusals[i][1]))
			print_error("stilb %s: %d %s", refusals[i][0], code, run.err);
		assert_int_equal(code, 2);
		assert_string_equal(run.out, "");
		assert_error_lines(1);
		assert_said(run.err, refusals[i][1]);
		assert_int_equal(folder_entries(), entries); /* no new file */
	}
}

/* On a full disk trace top ends with 1 and trace diff with 2, since its 1 means that a zone is slower. */
static void test_full_disk(void **state)
{
	(void)state;
	make_trace("a.json", 1, 2000);
	assert_int_equal(stilb_code(no_display, "trace top a.json --json /dev/full"), 1);
	assert_error_lines(1);
	assert_int_equal(stilb_code(no_display, "trace diff a.json a.json --json /dev/full"), 2);
	assert_error_lines(1);
	int full = open("/dev/full", O_WRONLY | O_CLOEXEC);
	stilb_start(no_display, full, "trace diff a.json a.json");
	program_wait(&run);
	assert_int_equal(run.code, 2);
	assert_error_lines(1);
	stilb_start(no_display, full, "trace top a.json");
	program_wait(&run);
	assert_int_equal(run.code, 1);
	assert_error_lines(1);
	close(full);
}

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup(test_top, folder_fresh),
		cmocka_unit_test_setup(test_top_json, folder_fresh),
		cmocka_unit_test_setup(test_diff, folder_fresh),
		cmocka_unit_test_setup(test_of_the_demo, folder_fresh),
		cmocka_unit_test_setup(test_names_are_harmless, folder_fresh),
		cmocka_unit_test_setup(test_help, folder_fresh),
		cmocka_unit_test_setup(test_refusals, folder_fresh),
		cmocka_unit_test_setup(test_full_disk, folder_fresh),
	};
	if (!folder_enter(argc > 1 ? argv[1] : NULL, "test_game_trace"))
		return 1;
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}
