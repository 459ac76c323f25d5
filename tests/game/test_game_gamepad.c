/* stilb demo with a recorded gamepad: the same track, byte for byte, in every run, and the effects of its buttons. */
#include "input/hid/input_layout.h"
#include "input/input_recording.h"
#include "support/input_descriptors.h"
#include "support/stilb_program.h"

#include <inttypes.h>
#include <math.h>

#define FLIGHT "demo --headless --device null --models 100 --workers 0 "
#define MS 1000 /* microseconds in a millisecond */

/* ---- recordings -------------------------------------------------------------------------------------------------- */

/* A recording of a DualShock 4 over USB, and the report that it sends: bytes 1 to 4 are the sticks, 5 and 6 the
 * buttons, 8 and 9 the triggers. */
static stilb_input_recorder *recorder;
static uint8_t report[64];
static int64_t now_us;
static uint32_t pad;
static const char *node = "/dev/hidraw3";

static void plug(uint16_t bus, uint16_t product)
{
	stilb_input_pad_info info = {.bus = bus, .vendor = 0x054c, .product = product};
	snprintf(info.path, sizeof info.path, "%s", node);
	snprintf(info.name, sizeof info.name, "Wireless Controller");
	const input_test_descriptor *descriptor = input_test_descriptor_find(bus, 0x054c, product);
	assert_non_null(descriptor);
	info.descriptor_size = (uint16_t)descriptor->size;
	memcpy(info.descriptor, descriptor->bytes, descriptor->size);
	assert_int_equal(
		stilb_input_recorder_add(
			recorder,
			&(stilb_input_event){.kind = STILB_INPUT_PAD_ADDED, .pad = ++pad, .time_us = now_us, .info = &info}),
		STILB_OK);
}

static void unplug(void)
{
	assert_int_equal(
		stilb_input_recorder_add(recorder,
	                             &(stilb_input_event){.kind = STILB_INPUT_PAD_REMOVED, .pad = pad, .time_us = now_us}),
		STILB_OK);
}

static void let_go(void)
{
	memset(report, 0, sizeof report);
	report[0] = 1;
	memset(report + 1, 0x80, 4);
	report[5] = 8;
}

static void say_bytes(const uint8_t *bytes, uint32_t size)
{
	assert_int_equal(stilb_input_recorder_add(recorder, &(stilb_input_event){.kind = STILB_INPUT_PAD_REPORT,
	                                                                         .pad = pad,
	                                                                         .time_us = now_us,
	                                                                         .bytes = bytes,
	                                                                         .size = size}),
	                 STILB_OK);
}

/* Adds the present report to the recording for `ms` milliseconds, 250 times a second. */
static void say(int64_t ms)
{
	for (int64_t end = now_us + ms * MS; now_us < end; now_us += 4 * MS)
		say_bytes(report, sizeof report);
}

static void press(uint8_t byte, uint8_t bit)
{
	report[byte] |= bit;
	say(40);
	report[byte] &= (uint8_t)~bit;
	say(40);
}

static void record(const char *path)
{
	now_us = 0;
	pad = 0;
	let_go();
	assert_int_equal(stilb_input_recorder_create(path, &recorder), STILB_OK);
}

static void recorded(void)
{
	assert_int_equal(stilb_input_recorder_close(recorder), STILB_OK);
}

/* Records a flight: ahead for 0.5 s; ahead, faster and turning to the right for 0.3 s; upwards for 0.2 s; then at
 * rest. */
static void record_flight(const char *path)
{
	record(path);
	plug(STILB_INPUT_BUS_USB, 0x05c4);
	say(100);
	report[2] = 0;
	say(500);
	report[3] = 0xff;
	report[9] = 0x7f;
	say(300);
	let_go();
	report[6] = 2; /* R1, the right shoulder: upwards */
	say(200);
	let_go();
	say(400);
	recorded();
}

/* ---- tracks ------------------------------------------------------------------------------------------------------ */

typedef struct track_line {
	uint64_t frame;
	int64_t time_us;
	double place[3], yaw, pitch;
} track_line;

static track_line track[4096];
static uint32_t track_count;

static void read_track(const char *path)
{
	char line[256];
	FILE *file = fopen(path, "r");
	assert_non_null(file);
	assert_non_null(fgets(line, sizeof line, file));
	assert_int_equal(line[0], '#');
	for (track_count = 0; fgets(line, sizeof line, file); track_count++) {
		track_line *t = &track[track_count];
		assert_in_range(track_count, 0, 4095);
		assert_int_equal(sscanf(line, "%" SCNu64 " %" SCNd64 " %lf %lf %lf %lf %lf\n", &t->frame, &t->time_us,
		                        &t->place[0], &t->place[1], &t->place[2], &t->yaw, &t->pitch),
		                 7);
		assert_int_equal(t->frame, track_count + 1);
		assert_int_equal(t->time_us, (int64_t)track_count * 1000000 / 60);
	}
	fclose(file);
}

/* The first pose of the track at or after this time. */
static const track_line *at_ms(int64_t ms)
{
	for (uint32_t i = 0; i < track_count; i++)
		if (track[i].time_us >= ms * MS)
			return &track[i];
	fail_msg("the track ends before %d ms", (int)ms);
	return NULL;
}

static void test_the_flight(void **state)
{
	(void)state;
	record_flight("flight.rec");
	stilb_good(FLIGHT "--gamepad replay:flight.rec --track a.txt --stats a.json");
	assert_said(run.out, "gamepad: DualShock 4, USB at /dev/hidraw3, ");
	assert_said(run.out, "recording ended");
	assert_null(strstr(run.out, "gamepad gone: ")); /* it was not unplugged */
	assert_said(run.out, "track: a.txt");
	assert_said(run.out, "375 reports, 0 corrupt, 0 lost");
	read_track("a.txt");
	assert_in_range(track[track_count - 1].time_us, 1490000, 1520000); /* the run ends with the recording */
	const track_line *start = at_ms(90), *ahead = at_ms(590), *turned = at_ms(890), *up = at_ms(1090);
	for (int i = 0; i < 3; i++)
		assert_true(start->place[i] == track[0].place[i]);
	assert_true(ahead->yaw == start->yaw && ahead->pitch == start->pitch);
	double way = 0.0, faster = 0.0;
	for (int i = 0; i < 3; i++) {
		way += (ahead->place[i] - start->place[i]) * (ahead->place[i] - start->place[i]);
		faster += (turned->place[i] - ahead->place[i]) * (turned->place[i] - ahead->place[i]);
	}
	assert_true(way > 9.0 && way < 36.0); /* 12 m/s for 0.5 s, from rest */
	assert_true(faster > 36.0);           /* the trigger makes it 2^1.5 times as fast */
	assert_true(turned->yaw < ahead->yaw - 0.3);
	assert_true(up->place[1] > at_ms(1000)->place[1] + 0.5);
	const track_line *last = &track[track_count - 1], *before = last - 1;
	for (int i = 0; i < 3; i++)
		assert_true(fabs(last->place[i] - before->place[i]) < 0.01); /* the camera is at rest */
	read_stats("a.json");
	assert_int_equal(stat_int("gamepads.reports"), 375);
	assert_int_equal(stat_int("gamepads.corrupt"), 0);
	assert_int_equal(stat_int("gamepads.lost"), 0);
	assert_true(stat_ms("gamepads.latency_ms.median") == 0.0); /* replays have no latency */
}

static void test_every_run_is_the_same(void **state)
{
	(void)state;
	static const char *const ways[] = {"",          "--workers 2",         "--animate",
	                                   "--overlay", "--models 1 --seed 9", "--no-profile --frames 100"};
	record_flight("flight.rec");
	stilb_good(FLIGHT "--gamepad replay:flight.rec --track a.txt");
	stilb_good(FLIGHT "--gamepad=replay:flight.rec --track b.txt --frames 91 --stats b.json");
	uint64_t hash = stat_hash("b.json");
	assert_true(same_file("a.txt", "b.txt"));
	for (size_t i = 0; i < 3; i++) {
		stilb_good(FLIGHT "--gamepad replay:flight.rec --frames 91 --track b.txt --stats b.json %s", ways[i]);
		assert_true(same_file("a.txt", "b.txt"));
		assert_true(i == 2 || stat_hash("b.json") == hash);
	}
	stilb_good(FLIGHT "--gamepad replay:flight.rec --track b.txt --frames 91 --invert-y --sensitivity 0.5");
	assert_false(same_file("a.txt", "b.txt"));
	stilb_good(FLIGHT "--frames 91 --track b.txt --stats b.json"); /* without a gamepad */
	assert_false(same_file("a.txt", "b.txt"));
	assert_true(stat_hash("b.json") != hash);
	read_track("b.txt");
	assert_int_equal(track_count, 91);
	for (uint32_t i = 1; i < track_count; i++)
		assert_memory_equal(track[i].place, track[0].place, 5 * sizeof(double));
}

/* ---- what may happen to a pad ------------------------------------------------------------------------------------ */

static void test_pulled_in_flight(void **state)
{
	(void)state;
	record("pulled.rec");
	plug(STILB_INPUT_BUS_USB, 0x05c4);
	report[2] = 0;
	say(500);
	unplug(); /* while the stick is pushed */
	now_us += 500 * MS;
	plug(STILB_INPUT_BUS_USB, 0x05c4);
	say(500);
	recorded();
	stilb_good(FLIGHT "--gamepad replay:pulled.rec --track a.txt --frames 120");
	assert_said(run.out, "gamepad gone: DualShock 4, USB");
	assert_said(run.out, "recording ended");
	read_track("a.txt");
	const track_line *pulled = at_ms(517), *back = at_ms(983);
	assert_memory_equal(pulled->place, back->place, sizeof pulled->place); /* the camera stops at once */
	assert_true(fabs(at_ms(1480)->place[2] - back->place[2]) > 2.0);       /* and moves again later */
	/* The recording also ends while the stick is pushed. */
	assert_memory_equal(at_ms(1520)->place, track[track_count - 1].place, sizeof pulled->place);
}

static void test_a_pad_without_a_path(void **state)
{
	(void)state;
	node = "";
	record("nowhere.rec");
	plug(STILB_INPUT_BUS_USB, 0x05c4);
	say(40);
	recorded();
	node = "/dev/hidraw3";
	stilb_good(FLIGHT "--gamepad replay:nowhere.rec");
	assert_said(run.out, "gamepad: DualShock 4, USB, known pad");
}

/* Bluetooth reports with a wrong checksum, which would turn the camera, are ignored. In the other reports the sticks
 * are at rest. */
static void test_corrupt_reports(void **state)
{
	(void)state;
	uint8_t radio[78] = {0x11, 0xc0, 0, 0x80, 0x80, 0x80, 0x80, 8};
	record("corrupt.rec");
	plug(STILB_INPUT_BUS_BLUETOOTH, 0x05c4);
	for (int i = 0; i < 100; i++, now_us += 4 * MS) {
		bool corrupt = i % 10 == 7;
		radio[3] = corrupt ? 0 : 0x80;
		uint32_t crc = stilb_input_crc32(stilb_input_crc32(0, &(uint8_t){0xa1}, 1), radio, 74) ^ corrupt;
		for (int b = 0; b < 4; b++)
			radio[74 + b] = (uint8_t)(crc >> 8 * b);
		say_bytes(radio, sizeof radio);
	}
	recorded();
	stilb_good(FLIGHT "--gamepad replay:corrupt.rec --track a.txt --stats a.json");
	read_stats("a.json");
	assert_int_equal(stat_int("gamepads.reports"), 100);
	assert_int_equal(stat_int("gamepads.corrupt"), 10);
	read_track("a.txt");
	for (uint32_t i = 1; i < track_count; i++)
		assert_memory_equal(track[i].place, track[0].place, 5 * sizeof(double));
}

/* ---- buttons ----------------------------------------------------------------------------------------------------- */

static void test_buttons(void **state)
{
	(void)state;
	record("buttons.rec");
	plug(STILB_INPUT_BUS_USB, 0x05c4);
	say(100);
	press(5, 0x40); /* circle: the next view */
	press(5, 0x10); /* square: captures a trace */
	press(5, 0x80); /* triangle: shows the profiler */
	press(5, 0x40);
	press(5, 0x40); /* back to the first view */
	recorded();
	stilb_good(FLIGHT "--gamepad replay:buttons.rec --track a.txt --capture c.json --stats a.json");
	assert_said(run.out, "trace: c.json");
	read_track("a.txt");
	const track_line *half = at_ms(175), *few = at_ms(415), *last = &track[track_count - 1];
	assert_memory_not_equal(half->place, track[0].place, sizeof half->place);
	assert_memory_not_equal(half->place, few->place, sizeof half->place);
	assert_memory_equal(last->place, track[0].place, 5 * sizeof(double));
	stilb_good(FLIGHT "--frames 2 --view half --track b.txt");
	track_line seen = *half;
	read_track("b.txt");
	assert_memory_equal(seen.place, track[0].place, 5 * sizeof(double)); /* the pose of --view half */
	assert_int_equal(folder_entries(), 5);
}

/* ---- what is refused --------------------------------------------------------------------------------------------- */

static void refused(const char *line, int code, const char *words)
{
	assert_int_equal(stilb_code(no_display, line), code);
	assert_error_lines(1);
	assert_said(run.err, words);
}

static void test_refusals(void **state)
{
	(void)state;
	refused(FLIGHT "--gamepad joystick", 2, "'joystick' is not known; give auto, off, hidraw, hidapi or replay:FILE");
	refused(FLIGHT "--gamepad replay:", 2, "'replay:' is not known");
	refused(FLIGHT "--gamepad replay", 2, "'replay' is not known");
	refused(FLIGHT "--sensitivity 11", 2, "--sensitivity");
	refused(FLIGHT "--sensitivity -1", 2, "--sensitivity");
	refused(FLIGHT "--track nowhere/a.txt", 2, "nowhere");
	refused(FLIGHT "--track a.txt --stats a.txt", 2, "two outputs would go to 'a.txt'");
	refused(FLIGHT "--gamepad replay:none.rec", 2, "--gamepad: cannot read 'none.rec'");
	refused(FLIGHT "--gamepad replay:.", 2, "--gamepad: ");
	FILE *broken = fopen("broken.rec", "w");
	assert_non_null(broken);
	fputs("R: 3 05 01 09\nE: 000000.000000 4 01 02\n", broken);
	fclose(broken);
	refused(FLIGHT "--gamepad replay:broken.rec", 2, "broken.rec");
	refused(FLIGHT "--gamepad replay:/dev/null", 2, "/dev/null"); /* a device is checked only when it is read */
	assert_int_equal(folder_entries(), 1);
	refused(FLIGHT "--frames 3 --track /dev/full", 1, "/dev/full");
}

static void test_an_output_never_replaces_the_recording(void **state)
{
	(void)state;
	static const char *const flags[] = {"--trace", "--stats", "--dump", "--capture", "--track", "--plan"};
	record_flight("flight.json");
	record_flight("same.rec");
	assert_int_equal(symlink("flight.json", "other.rec"), 0);
	for (size_t i = 0; i < sizeof flags / sizeof *flags; i++) {
		char line[256], words[256];
		snprintf(line, sizeof line, FLIGHT "--gamepad replay:other.rec %s ./flight.json", flags[i]);
		snprintf(words, sizeof words, "%s: './flight.json' would replace the recording 'other.rec'", flags[i]);
		refused(line, 2, words);
	}
	record_flight("flight.png");
	refused("demo --headless --gamepad replay:flight.png --screenshot flight.png", 2,
	        "--screenshot: 'flight.png' would replace");
	assert_true(same_file("flight.json", "same.rec"));
	assert_true(same_file("flight.png", "same.rec"));
}

/* A headless run accepts every source of live gamepads, and works although none is plugged in. */
static void test_live_and_headless(void **state)
{
	(void)state;
	static const char *const sources[] = {"auto", "off", "hidraw", "hidapi"};
	for (size_t i = 0; i < sizeof sources / sizeof *sources; i++) {
		char line[256];
		snprintf(line, sizeof line, FLIGHT "--frames 3 --gamepad %s --stats a.json", sources[i]);
		assert_int_equal(stilb_code(no_display, line), 0);
		read_stats("a.json");
		assert_int_equal(stat_int("frames"), 3);
	}
}

#define FRESH_TEST(name) cmocka_unit_test_setup(name, folder_fresh)

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		FRESH_TEST(test_the_flight),
		FRESH_TEST(test_every_run_is_the_same),
		FRESH_TEST(test_pulled_in_flight),
		FRESH_TEST(test_corrupt_reports),
		FRESH_TEST(test_buttons),
		FRESH_TEST(test_refusals),
		FRESH_TEST(test_live_and_headless),
		FRESH_TEST(test_a_pad_without_a_path),
		FRESH_TEST(test_an_output_never_replaces_the_recording),
	};
	if (argc != 2 || !folder_enter(argv[1], "test_game_gamepad")) {
		fprintf(stderr, "usage: test_game_gamepad STILB\n");
		return 1;
	}
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}
