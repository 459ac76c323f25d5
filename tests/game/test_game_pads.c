/* stilb pads without a pad: help and refusals, descriptors, recordings, and the picture in a terminal. */
#include "support/input_descriptors.h"
#include "support/stilb_program.h"

#include <pty.h>

static void write_file(const char *path, const void *bytes, size_t size)
{
	FILE *file = fopen(path, "wb");
	assert_non_null(file);
	assert_int_equal(fwrite(bytes, 1, size, file), size);
	assert_int_equal(fclose(file), 0);
}

static const input_test_descriptor *find(uint16_t bus, uint16_t vendor, uint16_t product)
{
	const input_test_descriptor *found = input_test_descriptor_find(bus, vendor, product);
	assert_non_null(found);
	return found;
}

static const input_test_descriptor *ds4_usb(void)
{
	return find(3, 0x054c, 0x05c4);
}

/* ---- words ------------------------------------------------------------------------------------------------------- */

static void test_help(void **state)
{
	(void)state;
	static const char *const flags[] = {"--watch",    "--record", "--replay", "--seconds", "--rumble",
	                                    "--describe", "--id",     "--bus",    "--backend", "--json"};
	stilb_good("pads --help");
	for (size_t i = 0; i < sizeof flags / sizeof *flags; i++) {
		char line[32];
		snprintf(line, sizeof line, "\n  %s ", flags[i]);
		assert_said(run.out, line);
	}
	for (const char *at = run.out, *end; (end = strchr(at, '\n')); at = end + 1)
		assert_true(end - at <= 110);
	stilb_good("--help");
	assert_said(run.out, "\n  pads ");
	assert_int_equal(folder_entries(), 0);
}

static const char *const refusals[][2] = {
	{"pads --bogus", "'--bogus'"},
	{"pads extra", "'extra'"},
	{"pads --backend evdev", "hidraw, hidapi"},
	{"pads --seconds 1", "--watch and --record"},
	{"pads --seconds -1 --watch", "'-1'"},
	{"pads --watch --seconds 100000", "0..86400"},
	{"pads --bus usb", "give --describe"},
	{"pads --id 054c:05c4", "give --describe"},
	{"pads --describe good.bin --id 054c", "'054c' is not vendor and product"},
	{"pads --describe good.bin --id 054c:05c4:3", "not vendor and product"},
	{"pads --describe good.bin --id 054c-05c4", "not vendor and product"},
	{"pads --describe good.bin --id 054c:05cx", "not vendor and product"},
	{"pads --describe good.bin --bus serial", "usb, bluetooth"},
	{"pads --describe good.bin --watch", "--watch cannot be combined with --describe"},
	{"pads --describe good.bin --replay good.rec", "--replay cannot be combined with --describe"},
	{"pads --describe good.bin --backend hidapi", "--backend cannot be combined with --describe"},
	{"pads --replay good.rec --rumble", "--rumble cannot be combined with --replay"},
	{"pads --replay good.rec --backend hidraw", "--backend cannot be combined with --replay"},
	{"pads --watch --json -", "--json cannot be combined with --watch"},
	{"pads --record a.rec --json b.json", "--replay FILE --json"},
	{"pads --record -  --watch", "give --record a file"},
	{"pads --record missing/a.rec", "does not exist"},
	{"pads --json missing/a.json", "does not exist"},
	{"pads --replay good.rec --record good.rec", "would replace"},
	{"pads --replay good.rec --json ./good.rec", "would replace"},
	{"pads --describe good.bin --json good.bin", "would replace"},
	{"pads --replay good.rec --record a --json a", "two outputs"},
	{"pads --replay missing.rec", "No such file"},
	{"pads --replay good.bin", "line 1: "},
	{"pads --replay good.rec", "'good.rec': it holds no report"},
	{"pads --describe letters.rec --id 054c:05c4", "--id cannot be combined with a recording"},
	{"pads --describe letters.rec", "'letters.rec': line 1: does not begin with"},
	{"pads --replay {}", "--replay"},
	{"pads --describe missing.bin", "No such file"},
	{"pads --describe empty.bin", "no bytes"},
	{"pads --describe large.bin", "too many bytes"},
	{"pads --describe broken.bin", "'broken.bin' is not a report descriptor: "},
	{"pads --describe /dev/hidraw999", "cannot look at '/dev/hidraw999'"},
	{"pads --describe /dev/hidraw9/../null", "is not the path of a hidraw node"},
	{"pads --describe /dev/hidraw", "is not the path of a hidraw node"},
};

static void test_refusals(void **state)
{
	(void)state;
	static const uint8_t large[4097], broken[] = {0x05, 0x01, 0x09};
	const input_test_descriptor *ds4 = ds4_usb();
	write_file("good.bin", ds4->bytes, ds4->size);
	write_file("good.rec", "", 0);
	write_file("letters.rec", "Rubbish", 7);
	write_file("empty.bin", "", 0);
	write_file("large.bin", large, sizeof large);
	write_file("broken.bin", broken, sizeof broken);
	for (size_t i = 0; i < sizeof refusals / sizeof *refusals; i++) {
		int code = stilb_code(no_display, refusals[i][0]);
		if (code != 2)
			print_error("stilb %s: %d %s", refusals[i][0], code, run.err);
		assert_int_equal(code, 2);
		assert_string_equal(run.out, "");
		assert_error_lines(1);
		assert_said(run.err, refusals[i][1]);
		assert_int_equal(folder_entries(), 6);
	}
}

/* ---- descriptors ------------------------------------------------------------------------------------------------- */

static void test_describe(void **state)
{
	(void)state;
	const input_test_descriptor *ds4 = ds4_usb();
	write_file("ds4.bin", ds4->bytes, ds4->size);
	stilb_good("pads --describe ds4.bin --id 054c:05c4");
	assert_said(run.out, "ds4.bin: 507 bytes");
	assert_said(run.out, "USB, vendor 054c, product 05c4");
	assert_said(run.out, "\ninput   0x01    44  14x1    0..1                  Button / 1 .. 14\n");
	assert_said(run.out, "\ninput   0x01    40  1x4     0..7                  Generic Desktop / Hat switch, null\n");
	assert_said(run.out, "\ninput   0x01     64\n");
	assert_said(run.out, "\noutput  0x05     32\n");
	assert_said(run.out, "\nDualShock 4, USB: known pad 054c:05c4\nrumbles\n");
	assert_said(run.out, "  byte   2 bit 0   8 bits     255..0       left_y\n");
	assert_said(run.out, "  byte   5 bit 5   1 bit        1..1       south\n");
	stilb_good("pads --describe ds4.bin");
	assert_said(run.out, "because --id is not given");
	assert_said(run.out, "\nds4.bin, USB: ");
	assert_said(run.out, "no rumble\n");
	assert_false(strstr(run.out, "known pad 054c"));
	const input_test_descriptor *bluetooth = find(5, 0x054c, 0x05c4);
	write_file("ds4.bin", bluetooth->bytes, bluetooth->size);
	stilb_good("pads --describe ds4.bin --id 054c:05c4 --bus bluetooth");
	assert_said(run.out, "report 0x11, 78 bytes, the last four a CRC-32\n");
}

static void test_describe_json(void **state)
{
	(void)state;
	const input_test_descriptor *ds4 = ds4_usb();
	write_file("ds4.bin", ds4->bytes, ds4->size);
	stilb_good("pads --describe ds4.bin --id 054C:05C4 --json a.json");
	read_stats("a.json");
	assert_int_equal(stat_int("bytes"), 507);
	assert_string_equal(stat_text("vendor", '"'), "054c");
	assert_string_equal(stat_text("fields[0].usage", '"'), "Generic Desktop / X");
	assert_int_equal(stat_int("fields[0].bit"), 8);
	assert_int_equal(stat_int("fields[0].logical_max"), 255);
	assert_string_equal(stat_text("reports[0].kind", '"'), "input");
	assert_int_equal(stat_int("reports[0].bytes"), 64);
	assert_string_equal(stat_text("gamepad", 'w'), "true");
	assert_string_equal(stat_text("layout", '"'), "DualShock 4, USB");
	assert_int_equal(stat_int("mapping[0].report"), 1);
	assert_string_equal(stat_text("mapping[0].sources[0].target", '"'), "left_x");
	assert_string_equal(stat_text("mapping[0].sources[0].kind", '"'), "axis");
}

/* A keyboard's descriptor, from standard input: it is described, and reported as no gamepad. */
static void test_describe_keyboard(void **state)
{
	(void)state;
	/* The keyboard of HID 1.11, appendix B.1, without its LEDs. */
	static const uint8_t keyboard[] = {0x05, 0x01, 0x09, 0x06, 0xa1, 0x01, 0x05, 0x07, 0x19, 0xe0, 0x29,
	                                   0xe7, 0x15, 0x00, 0x25, 0x01, 0x75, 0x01, 0x95, 0x08, 0x81, 0x02,
	                                   0x95, 0x01, 0x75, 0x08, 0x81, 0x01, 0x95, 0x06, 0x75, 0x08, 0x15,
	                                   0x00, 0x25, 0x65, 0x19, 0x00, 0x29, 0x65, 0x81, 0x00, 0xc0};
	write_file("keyboard.bin", keyboard, sizeof keyboard);
	int saved = dup(STDIN_FILENO), file = open("keyboard.bin", O_RDONLY | O_CLOEXEC);
	assert_true(file >= 0 && dup2(file, STDIN_FILENO) == STDIN_FILENO);
	stilb_good("pads --describe - --json keyboard.json");
	assert_true(dup2(saved, STDIN_FILENO) == STDIN_FILENO);
	close(saved);
	close(file);
	assert_said(run.out, "-: 43 bytes");
	assert_said(run.out, ", array");
	assert_said(run.out, "\nnot a gamepad: ");
	read_stats("keyboard.json");
	assert_string_equal(stat_text("gamepad", 'w'), "false");
	stat_text("why_not", '"');
}

/* ---- recordings -------------------------------------------------------------------------------------------------- */

/* Writes a recording of a DualShock 4: a report every 10 ms, in which only the right stick's x and the button south
 * change. */
static void write_recording(const char *path, int reports)
{
	const input_test_descriptor *ds4 = ds4_usb();
	FILE *file = fopen(path, "w");
	assert_non_null(file);
	fprintf(file, "R: %zu", ds4->size);
	for (size_t i = 0; i < ds4->size; i++)
		fprintf(file, " %02x", ds4->bytes[i]);
	fprintf(file, "\nN: Wireless Controller\nP: /dev/hidraw0\nI: 3 054c 05c4\n");
	for (int i = 0; i < reports; i++) {
		uint8_t report[64] = {1, 128, 128, 128, 128, 8};
		report[3] = i % 4 >= 2 ? 255 : 128;    /* right x */
		report[5] = i % 4 == 3 ? 8 | 0x20 : 8; /* south */
		fprintf(file, "E: 000000.%06d 64", i * 10000);
		for (size_t k = 0; k < sizeof report; k++)
			fprintf(file, " %02x", report[k]);
		fprintf(file, "\n");
	}
	fprintf(file, "# removed 000000.%06d\n", reports * 10000);
	assert_int_equal(fclose(file), 0);
}

/* Only reports that change the state of the pad are printed. */
static void test_replay(void **state)
{
	(void)state;
	write_recording("a.rec", 6);
	stilb_good("pads --replay a.rec");
	assert_string_equal(
		run.out, "    0.000000  1  added: /dev/hidraw0 Wireless Controller; DualShock 4, USB: known pad 054c:05c4\n"
				 "    0.020000  1  left +0.000 +0.000  right +1.000 +0.000  triggers 0.000 0.000  -\n"
				 "    0.030000  1  left +0.000 +0.000  right +1.000 +0.000  triggers 0.000 0.000  south\n"
				 "    0.040000  1  left +0.000 +0.000  right +0.000 +0.000  triggers 0.000 0.000  -\n"
				 "    0.060000  1  removed\n"
				 "6 reports of 1 pad in 0.060 s, 0 corrupt\n");
	stilb_good("pads --replay a.rec --record b.rec --seconds 0.035"); /* its first four reports */
	assert_string_equal(run.out,
	                    "    0.000000  1  added: /dev/hidraw0 Wireless Controller; DualShock 4, USB: known pad "
	                    "054c:05c4\n"
	                    "4 reports of 1 pad in 0.030 s, 0 corrupt\n"
	                    "recording: b.rec\n");
	stilb_good("pads --replay b.rec");
	assert_said(run.out, "4 reports of 1 pad in 0.030 s");
	assert_int_equal(folder_entries(), 2);
}

/* --describe shows the first pad of a recording, with the bus, vendor, product and name that it has there. */
static void test_describe_recording(void **state)
{
	(void)state;
	write_recording("a.rec", 1);
	stilb_good("pads --describe a.rec");
	assert_said(run.out, "a.rec: 507 bytes");
	assert_said(run.out, "; USB, vendor 054c, product 05c4\n");
	assert_said(run.out, "\nDualShock 4, USB: known pad 054c:05c4\n");
	stilb_good("pads --describe a.rec --json a.json");
	read_stats("a.json");
	assert_string_equal(stat_text("name", '"'), "Wireless Controller");
	assert_string_equal(stat_text("product", '"'), "05c4");
	assert_int_equal(stilb_code(no_display, "pads --describe a.rec --json -"), 0);
	assert_memory_equal(run.out, "{\n", 2); /* JSON on standard output replaces the table */
	assert_string_equal(run.err, "");
}

/* A file of valid items (the elements of a descriptor) that describe no field. */
static void test_describe_rubbish(void **state)
{
	(void)state;
	static const uint8_t zeros[16];
	write_file("zeros.bin", zeros, sizeof zeros);
	assert_int_equal(stilb_code(no_display, "pads --describe zeros.bin"), 1);
	assert_string_equal(run.out, "");
	assert_error_lines(1);
	assert_said(run.err, "'zeros.bin' is not a report descriptor: it has no fields");
}

static void test_replay_json(void **state)
{
	(void)state;
	write_recording("a.rec", 4);
	assert_int_equal(stilb_code(no_display, "pads --replay a.rec --json -"), 0);
	json_flat_finish(&stats);
	assert_true(json_flat_text(run.out, strlen(run.out), &stats));
	assert_string_equal(run.err, "");
	assert_string_equal(stat_text("recording", '"'), "a.rec");
	assert_string_equal(stat_text("events[0].event", '"'), "added");
	assert_string_equal(stat_text("events[0].layout", '"'), "DualShock 4, USB");
	assert_string_equal(stat_text("events[1].event", '"'), "state");
	assert_string_equal(stat_text("events[1].time", '0'), "0.020000");
	assert_string_equal(stat_text("events[1].right_x", '0'), "1.000000");
	assert_string_equal(stat_text("events[2].buttons[0]", '"'), "south");
	assert_string_equal(stat_text("events[3].event", '"'), "removed");
	assert_int_equal(stat_int("reports"), 4);
	assert_int_equal(stat_int("corrupt"), 0);
}

/* A recording without any gamepad fails with a message. Pads without path or name are fine, and so is one with a
 * damaged descriptor that is known by its vendor and product. */
static void test_replay_others(void **state)
{
	(void)state;
	static const char other[] = "R: 1 c0\nN: Keyboard\nI: 3 0001 0002\nE: 000000.000000 1 00\n",
					  known[] = "R: 2 26 ff\nI: 3 054c 05c4\nE: 000000.000000 10 01 80 80 80 80 28 00 00 00 00\n";
	write_file("a.rec", other, sizeof other - 1);
	assert_int_equal(stilb_code(no_display, "pads --replay a.rec"), 1);
	assert_error_lines(1);
	assert_said(run.err, "no pad of 'a.rec' is a gamepad");
	assert_said(run.out, "  1  added: Keyboard; 'Keyboard' (0001:0002) is not a gamepad: ");
	write_file("a.rec", known, sizeof known - 1);
	stilb_good("pads --replay a.rec");
	assert_said(run.out, "  1  added: ?; DualShock 4, USB: known pad 054c:05c4\n");
	assert_said(run.out, "  south\n");
}

/* A report with a wrong checksum is printed as corrupt, and does not change the state. */
static void test_replay_corrupt(void **state)
{
	(void)state;
	const input_test_descriptor *ds4 = find(5, 0x054c, 0x05c4);
	FILE *file = fopen("a.rec", "w");
	assert_non_null(file);
	fprintf(file, "R: %zu", ds4->size);
	for (size_t i = 0; i < ds4->size; i++)
		fprintf(file, " %02x", ds4->bytes[i]);
	fprintf(file, "\nN: pad\nI: 5 054c 05c4\nE: 000000.000000 78 11");
	for (int i = 1; i < 78; i++)
		fprintf(file, " ff");
	fprintf(file, "\n");
	fclose(file);
	stilb_good("pads --replay a.rec");
	assert_said(run.out, "    0.000000  1  corrupt\n1 reports of 1 pad in 0.000 s, 1 corrupt\n");
}

static double seconds_now(void)
{
	struct timespec now;
	clock_gettime(CLOCK_MONOTONIC, &now);
	return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* With --watch a recording is replayed at its own pace; without, in a few milliseconds. */
static void test_replay_pace(void **state)
{
	(void)state;
	write_recording("a.rec", 25);
	double start = seconds_now();
	stilb_good("pads --replay a.rec --watch");
	assert_true(seconds_now() - start >= 0.25);
	assert_said(run.out, "25 reports of 1 pad in 0.250 s");
}

static void test_full_disk(void **state)
{
	(void)state;
	write_recording("a.rec", 4);
	assert_int_equal(stilb_code(no_display, "pads --replay a.rec --record /dev/full"), 1);
	assert_error_lines(1);
	assert_said(run.err, "/dev/full");
	assert_int_equal(stilb_code(no_display, "pads --replay a.rec --json /dev/full"), 1);
	assert_error_lines(1);
}

/* stilb pads ends when its standard output is closed. */
static void test_closed_pipe(void **state)
{
	(void)state;
	int ends[2];
	write_recording("a.rec", 99);
	FILE *file = fopen("a.rec", "a");
	assert_non_null(file);
	fputs("D: 1\n# added 000030.000000\nR: 1 c0\nI: 3 1 2\n", file); /* 30 s later: not waited for */
	fclose(file);
	double start = seconds_now();
	assert_int_equal(pipe2(ends, O_CLOEXEC), 0);
	close(ends[0]);
	stilb_start(no_display, ends[1], "pads --watch --replay a.rec");
	program_wait(&run);
	close(ends[1]);
	assert_true(seconds_now() - start < 15.0);
	assert_int_equal(run.code, 1);
	assert_said(run.err, "standard output");
}

/* ---- the terminal ------------------------------------------------------------------------------------------------ */

/* Runs stilb in a terminal of 24 lines, interrupts it when it has drawn `until`, and returns what it drew. */
static const char *terminal_run(const char *words, const char *until, int *status)
{
	static char drawn[65536];
	struct winsize size = {.ws_row = 24, .ws_col = 100};
	char copy[256], *rest = NULL, *arguments[16] = {stilb_path};
	size_t length = 0;
	int terminal, count = 1;
	snprintf(copy, sizeof copy, "%s", words);
	for (char *word = strtok_r(copy, " ", &rest); word; word = strtok_r(NULL, " ", &rest))
		arguments[count++] = word;
	pid_t pid = forkpty(&terminal, NULL, NULL, &size);
	if (pid == 0) {
		execv(stilb_path, arguments);
		_exit(127);
	}
	assert_true(pid > 0);
	bool interrupted = false;
	for (ssize_t got = 1; got > 0 && length<sizeof drawn - 1; length += got> 0 ? (size_t)got : 0) {
		drawn[length] = '\0';
		if (!interrupted && strstr(drawn, until))
			interrupted = kill(pid, SIGINT) == 0;
		got = read(terminal, drawn + length, sizeof drawn - 1 - length);
	}
	drawn[length] = '\0';
	assert_int_equal(waitpid(pid, status, 0), pid);
	close(terminal);
	return drawn;
}

/* Each update of the live view is drawn over the one before, and Ctrl-C shows the cursor again. */
static void test_terminal(void **state)
{
	(void)state;
	int status;
	write_recording("a.rec", 99);
	const char *drawn = terminal_run("pads --watch --replay a.rec", "\033[7A", &status);
	assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
	assert_said(drawn, "\033[?25l");
	assert_said(drawn, "\033[7A");
	assert_said(drawn, "Wireless Controller (DualShock 4, USB) /dev/hidraw0");
	assert_said(drawn, "left stick   x +0.00 [..........#..........]  y +0.00 [..........#..........]\033[K");
	assert_said(drawn, "triggers     l  0.00 [#....................]");
	assert_said(drawn, "Ctrl-C ends\033[K");
	const char *finish = strstr(drawn, "\033[?25h");
	assert_non_null(finish);
	assert_said(finish, "reports of 1 pad in");
}

int main(int argc, char **argv)
{
	if (!folder_enter(argc > 1 ? argv[1] : NULL, "test_game_pads"))
		return 1;
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup(test_help, folder_fresh),
		cmocka_unit_test_setup(test_refusals, folder_fresh),
		cmocka_unit_test_setup(test_describe, folder_fresh),
		cmocka_unit_test_setup(test_describe_json, folder_fresh),
		cmocka_unit_test_setup(test_describe_keyboard, folder_fresh),
		cmocka_unit_test_setup(test_replay, folder_fresh),
		cmocka_unit_test_setup(test_replay_json, folder_fresh),
		cmocka_unit_test_setup(test_describe_recording, folder_fresh),
		cmocka_unit_test_setup(test_describe_rubbish, folder_fresh),
		cmocka_unit_test_setup(test_replay_others, folder_fresh),
		cmocka_unit_test_setup(test_replay_corrupt, folder_fresh),
		cmocka_unit_test_setup(test_replay_pace, folder_fresh),
		cmocka_unit_test_setup(test_full_disk, folder_fresh),
		cmocka_unit_test_setup(test_closed_pipe, folder_fresh),
		cmocka_unit_test_setup(test_terminal, folder_fresh),
	};
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}
