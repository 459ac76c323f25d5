/* stilb pads with a pad that umockdev simulates: sysfs, the device node and its reports. */
#include "support/input_descriptors.h"
#include "support/stilb_program.h"

/* ---- the pad --------------------------------------------------------------------------------------------------- */

/* Writes a device with its descriptor in umockdev's text format. */
static void write_device(const char *path, const char *name, uint16_t vendor, uint16_t product, const uint8_t *bytes,
                         size_t size)
{
	FILE *file = fopen(path, "w");
	assert_non_null(file);
	fprintf(file,
	        "P: /devices/usb1/1-1/1-1:1.0/0003:%04X:%04X.0001\n"
	        "E: SUBSYSTEM=hid\n"
	        "A: uevent=DRIVER=hid-generic\\nHID_ID=0003:0000%04X:0000%04X\\nHID_NAME=%s\\nHID_UNIQ=a4:53:85:01:02:03\n"
	        "H: report_descriptor=",
	        vendor, product, vendor, product, name);
	for (size_t i = 0; i < size; i++)
		fprintf(file, "%02X", bytes[i]);
	fprintf(file,
	        "\n\nP: /devices/usb1/1-1/1-1:1.0/0003:%04X:%04X.0001/hidraw/hidraw7\n"
	        "N: hidraw7\n"
	        "E: DEVNAME=/dev/hidraw7\n"
	        "E: SUBSYSTEM=hidraw\n"
	        "L: device=../../../0003:%04X:%04X.0001\n",
	        vendor, product, vendor, product);
	assert_int_equal(fclose(file), 0);
	file = fopen("node.ioctl", "w");
	assert_non_null(file);
	fprintf(file, "@DEV /dev/hidraw7\nHIDIOCGRDESCSIZE 0 %02X%02X0000\n", (unsigned)size & 255, (unsigned)size >> 8);
	assert_int_equal(fclose(file), 0);
}

static void write_pad(void)
{
	const input_test_descriptor *ds4 = input_test_descriptor_find(3, 0x054c, 0x05c4);
	assert_non_null(ds4);
	write_device("pad.umockdev", "Wireless Controller", 0x054c, 0x05c4, ds4->bytes, ds4->size);
}

#define REPORTS 6

/* Writes reports from 300 ms on, slowly: umockdev's node is a terminal, in which reports that have not been read yet
 * are joined. The last ones are equal, so that at least one of them is read alone. */
static void write_script(void)
{
	FILE *file = fopen("pad.script", "w");
	assert_non_null(file);
	fprintf(file, "d 0 /dev/hidraw7\n");
	for (int i = 0; i < REPORTS; i++) {
		uint8_t report[64] = {1, 128, 128, 128, 128, 8};
		report[1] = (uint8_t)(i < 3 ? 128 + i : 131); /* left x */
		report[5] = i < 3 ? 8 : 8 | 0x20;             /* south */
		fprintf(file, "r %d ", i == 0 ? 300 : 40);
		for (size_t k = 0; k < sizeof report; k++)
			fprintf(file, report[k] < 32 ? "^%c" : "%c", report[k] < 32 ? report[k] + 64 : report[k]);
		fprintf(file, "\n");
	}
	assert_int_equal(fclose(file), 0);
}

/* Runs the shell command `words`, in which "STILB " stands for the program's path, among the devices that `devices`,
 * the arguments of umockdev-run, simulates. Returns the exit code. */
static int live_code(const char *devices, const char *words)
{
	char line[2 * PATH_MAX];
	const char *const shell[] = {"/bin/sh", "-c", line, NULL};
	static const char *const environment[] = {NO_DISPLAY, NULL};
	snprintf(line, sizeof line,
	         "ASAN_OPTIONS=\"$ASAN_OPTIONS:verify_asan_link_order=0\" exec umockdev-run %s -- sh -c '%s'", devices,
	         words);
	for (char *at; (at = strstr(line, "STILB "));) {
		size_t rest = strlen(at + 5) + 1, length = strlen(stilb_path);
		assert_true(strlen(line) + length < sizeof line);
		memmove(at + length, at + 5, rest);
		memcpy(at, stilb_path, length);
	}
	assert_true(program_start(&run, shell, environment, -1));
	program_wait(&run);
	if (run.code != 0)
		print_message("%s\n%d\n%s%s", line, run.code, run.out, run.err);
	return run.code;
}

#define PAD "-d pad.umockdev -i /dev/hidraw7=node.ioctl"

/* ---- tests ----------------------------------------------------------------------------------------------------- */

static void test_list(void **state)
{
	(void)state;
	static const char *const backends[] = {"hidraw", "hidapi"};
	write_pad();
	for (int i = 0; i < 2; i++) {
		char line[128];
		snprintf(line, sizeof line, "STILB pads --backend %s --json a.json", backends[i]);
		assert_int_equal(live_code(PAD, line), 0);
		assert_said(run.out, "Wireless Controller\n"
		                     "  path        /dev/hidraw7\n"
		                     "  bus         USB, vendor 054c, product 05c4\n"
		                     "  serial      a4:53:85:01:02:03\n"
		                     "  recognised  DualShock 4, USB: known pad 054c:05c4\n"
		                     "  read by     hid");
		assert_string_equal(run.err, "");
		read_stats("a.json");
		assert_string_equal(stat_text("backend", '"'), backends[i]);
		assert_string_equal(stat_text("pads[0].path", '"'), "/dev/hidraw7");
		assert_string_equal(stat_text("pads[0].product", '"'), "05c4");
		assert_string_equal(stat_text("pads[0].serial", '"'), "a4:53:85:01:02:03");
		assert_said(stat_text("pads[0].device", '"'), "/devices/usb1/1-1/1-1:1.0/0003:054C:05C4.0001");
		assert_string_equal(stat_text("pads[0].permission", 'w'), "true");
		assert_null(json_flat_find(&stats, "pads[1]"));
	}
	assert_int_equal(live_code(PAD, "STILB pads --describe /dev/hidraw7"), 0);
	assert_said(run.out, "/dev/hidraw7: 507 bytes");
	assert_said(run.out, "DualShock 4, USB: known pad");
}

static void test_none(void **state)
{
	(void)state;
	assert_int_equal(live_code("", "STILB pads"), 0);
	assert_said(run.out, "No gamepad was found.");
	assert_string_equal(run.err, "");
	assert_int_equal(live_code("", "STILB pads --watch --seconds 0.2"), 0);
	assert_string_equal(run.err, "watching; Ctrl-C ends it\nno gamepad yet; waiting\n");
	assert_said(run.out, "0 reports of 0 pads in 0.");
	assert_false(strstr(run.out, " in 0.000 s"));
}

/* An old recording stays if nothing was recorded. */
static void test_record_nothing(void **state)
{
	(void)state;
	char text[16] = "";
	FILE *file = fopen("a.rec", "w");
	assert_non_null(file);
	fputs("old", file);
	fclose(file);
	assert_int_equal(live_code("", "STILB pads --record a.rec --seconds 0.2"), 1);
	assert_said(run.err, "no gamepad sent a report: 'a.rec' is not written\n");
	file = fopen("a.rec", "r");
	assert_non_null(file);
	assert_non_null(fgets(text, sizeof text, file));
	fclose(file);
	assert_string_equal(text, "old");
	assert_int_equal(folder_entries(), 1);
}

/* --rumble prints a result for each pad. */
static void test_rumble(void **state)
{
	(void)state;
	const input_test_descriptor *asus = input_test_descriptor_find(3, 0x18d1, 0x2c40);
	assert_non_null(asus);
	write_pad();
	assert_int_equal(live_code(PAD, "STILB pads --rumble"), 0);
	assert_said(run.out, "\n/dev/hidraw7, Wireless Controller: rumbled\n");
	write_device("pad.umockdev", "Pad", asus->vendor, asus->product, asus->bytes, asus->size);
	assert_int_equal(live_code(PAD, "STILB pads --rumble"), 0);
	assert_said(run.out, "\n  recognised  its descriptor: two sticks");
	assert_said(run.out, "\n/dev/hidraw7, Pad: has no known motors\n");
}

/* A device that is no gamepad is listed with the reason. */
static void test_others(void **state)
{
	(void)state;
	static const uint8_t mouse[] = {0x05, 0x01, 0x09, 0x02, 0xa1, 0x01, 0x05, 0x09, 0x19, 0x01, 0x29, 0x03,
	                                0x15, 0x00, 0x25, 0x01, 0x75, 0x01, 0x95, 0x08, 0x81, 0x02, 0xc0};
	write_device("pad.umockdev", "Mouse", 0x046d, 0xc077, mouse, sizeof mouse);
	assert_int_equal(live_code(PAD, "STILB pads"), 0);
	assert_said(run.out, "No gamepad was found.");
	assert_said(run.out, "\nnot gamepads:\n  /dev/hidraw7, Mouse\n    'Mouse' (046d:c077) is not a gamepad: ");
	for (const char *at = run.out, *end; (end = strchr(at, '\n')); at = end + 1)
		assert_true(end - at <= 80);
}

/* A node without permission is named, with the udev rule that helps. Root may open every node, so the test drops root's
 * capabilities. */
static void test_denied(void **state)
{
	(void)state;
	write_pad();
	assert_int_equal(live_code(PAD,
	                           "rm $UMOCKDEV_DIR/dev/hidraw7 && echo > $UMOCKDEV_DIR/dev/hidraw7 && "
	                           "chmod 0 $UMOCKDEV_DIR/dev/hidraw7 && "
	                           "exec setpriv --bounding-set=-all --inh-caps=-all STILB pads --rumble --json a.json"),
	                 0);
	assert_said(run.out, "  no permission to read /dev/hidraw7.");
	assert_said(run.out, "/etc/udev/rules.d/");
	assert_said(run.out, "TAG+=\"uaccess\"");
	assert_said(run.out, "\n/dev/hidraw7, Wireless Controller: no permission\n");
	read_stats("a.json");
	assert_string_equal(stat_text("pads[0].permission", 'w'), "false");
	assert_said(stat_text("pads[0].udev_rule", '"'), "054C:05C4");
}

/* The live states are printed, and are the same when the recording is replayed. */
static void test_watch_and_record(void **state)
{
	(void)state;
	char summary[128];
	write_pad();
	write_script();
	assert_int_equal(live_code(PAD " -s /dev/hidraw7=pad.script", "STILB pads --watch --record a.rec --seconds 0.8"),
	                 0);
	assert_string_equal(run.err, "recording; Ctrl-C ends it\n");
	assert_said(run.out, "  1  added: /dev/hidraw7 Wireless Controller; DualShock 4, USB: known pad 054c:05c4\n");
	assert_said(run.out, "  1  left +0.024 +0.000  right +0.000 +0.000  triggers 0.000 0.000  south\n");
	assert_said(run.out, " 0 corrupt, 0 lost\nrecording: a.rec\n");
	const char *last = strstr(run.out, " reports of");
	int reports = 0;
	while (last > run.out && last[-1] != '\n')
		last--;
	assert_int_equal(sscanf(last, "%d", &reports), 1);
	assert_in_range(reports, 1, REPORTS);
	int lines = program_lines(run.out);
	stilb_good("pads --replay a.rec");
	assert_int_equal(program_lines(run.out), lines - 1); /* all but the line that names the recording */
	snprintf(summary, sizeof summary, "\n%d reports of 1 pad in 0.", reports);
	assert_said(run.out, summary);
	assert_said(run.out, "triggers 0.000 0.000  south\n");
}

int main(int argc, char **argv)
{
	if (system("test -n \"$(command -v umockdev-run)\"") != 0) {
		puts("skipped: no umockdev-run; it comes with Debian's package umockdev");
		return 77;
	}
	if (!folder_enter(argc > 1 ? argv[1] : NULL, "test_game_pads_live"))
		return 1;
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup(test_list, folder_fresh),
		cmocka_unit_test_setup(test_none, folder_fresh),
		cmocka_unit_test_setup(test_record_nothing, folder_fresh),
		cmocka_unit_test_setup(test_rumble, folder_fresh),
		cmocka_unit_test_setup(test_others, folder_fresh),
		cmocka_unit_test_setup(test_denied, folder_fresh),
		cmocka_unit_test_setup(test_watch_and_record, folder_fresh),
	};
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}
