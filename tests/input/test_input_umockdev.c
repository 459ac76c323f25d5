/* input_pads on devices that umockdev simulates: sysfs, nodes and ioctls as programs see them, in the
 * directories that the engine uses. With STILB_TEST_HIDAPI unmodified hidapi reads them, else the kernel's
 * interface. */
#include "input/device/input_reader_internal.h"
#include "input/hid/input_layout.h"
#include "support/input_descriptors.h"
#include "support/test.h"
#include "support/umockdev.h"

#include <errno.h>
#include <limits.h>
#include <stddef.h>
#include <sys/eventfd.h>

#ifdef STILB_TEST_HIDAPI
#include <hidapi/hidapi.h>
#define BACKEND STILB_INPUT_BACKEND_HIDAPI
#define DEVICE_BACKEND input_backend_hidapi
#else
#define BACKEND STILB_INPUT_BACKEND_HIDRAW
#define DEVICE_BACKEND input_backend_hidraw
const input_backend input_backend_hidapi = {.name = "none"}; /* so that the program loads no hidapi */
#endif

#define NODE "/dev/hidraw7"
#define NAME "Sony Computer Entertainment Wireless Controller"
#define REPORTS 8u /* before the script expects rumble, and as many after it */
#define SIZE 64u

static const uint8_t feature[37] = {0x02, 0xab, 0xcd, 0xef};

static void make_report(uint32_t number, uint8_t report[SIZE])
{
	memset(report, 0, SIZE);
	memcpy(report, (const uint8_t[]){1, 128, 128, 128, 128, 8}, 6);
	report[40] = (uint8_t)number;
}

/* ---- in the test bed --------------------------------------------------------------------------------------------- */

/* The bytes read so far. The simulated node is a terminal, so reports that were sent before a read arrive as one. While
 * nobody has it open, the script starts again when it comes to the point at which it expects a write. */
typedef struct stream {
	uint8_t report[SIZE];
	size_t filled;
	uint32_t next; /* the number of the report that must follow */
} stream;

static void stream_add(stream *got, const uint8_t *bytes, size_t size)
{
	for (size_t i = 0; i < size; i++) {
		uint8_t wanted[SIZE];
		got->report[got->filled++] = bytes[i];
		if (got->filled < SIZE)
			continue;
		if (got->next == REPORTS && got->report[40] == 0)
			got->next = 0;
		make_report(got->next, wanted);
		assert_memory_equal(got->report, wanted, SIZE);
		got->filled = 0;
		got->next++;
	}
}

static stilb_input_event next_event(stilb_input_pads *pads)
{
	stilb_input_event event;
	int64_t until_us = input_now_us() + 10000000;
	while (!stilb_input_pads_next(pads, input_now_us(), &event)) {
		assert_true(input_now_us() < until_us);
		stilb_input_pads_wait(pads, 100);
	}
	return event;
}

static void read_reports(stilb_input_pads *pads, stream *got, uint32_t reports)
{
	while (got->next < reports) {
		stilb_input_event event = next_event(pads);
		assert_int_equal(event.kind, STILB_INPUT_PAD_REPORT);
		stream_add(got, event.bytes, event.size);
	}
}

/* The pad is found, reports and rumbles: the simulated device goes on only if the bytes are right. */
static void live_with(stilb_input_pads *pads)
{
	static stream got;
	stilb_input_event added = next_event(pads);
	assert_int_equal(added.kind, STILB_INPUT_PAD_ADDED);
	assert_string_equal(added.info->path, NODE);
	assert_string_equal(added.info->name, NAME);
	assert_int_equal(added.info->product, 0x05c4);
	read_reports(pads, &got, REPORTS);
	stilb_input_pads_rumble(pads, added.pad, 1.0f, 0.5f, 5000);
	read_reports(pads, &got, 2 * REPORTS);
	assert_int_equal(stilb_input_pads_stats_get(pads).lost, 0);
}

static void a_pad_lives(void **state)
{
	(void)state;
	stilb_input_pads *pads;
	assert_int_equal(stilb_input_pads_create(&(stilb_input_pads_desc){.backend = BACKEND}, &pads), STILB_OK);
	live_with(pads);
	stilb_input_pads_destroy(pads);
}

static void a_pad_is_plugged_in(void **state)
{
	(void)state;
	char away[PATH_MAX], node[PATH_MAX];
	stilb_input_pads *pads;
	snprintf(away, sizeof away, "%s/away", umockdev_root());
	snprintf(node, sizeof node, "%s%s", umockdev_root(), NODE);
	assert_int_equal(rename(node, away), 0);
	assert_int_equal(stilb_input_pads_create(&(stilb_input_pads_desc){.backend = BACKEND}, &pads), STILB_OK);
	stilb_input_pads_wait(pads, 5000);
	stilb_input_event event;
	assert_false(stilb_input_pads_next(pads, INT64_MAX, &event));
	assert_int_equal(rename(away, node), 0);
	live_with(pads);
	stilb_input_pads_destroy(pads);
}

static void a_device_is_read_and_asked(void **state)
{
	(void)state;
	stream got = {.next = 0};
	uint8_t report[4 * SIZE] = {feature[0]};
	input_device device;
	int wake_fd = eventfd(1, EFD_NONBLOCK);
	assert_int_equal(input_device_open(&DEVICE_BACKEND, NODE, &device), 0);
	assert_int_equal(DEVICE_BACKEND.get_feature(&device, report, sizeof feature), sizeof feature);
	assert_memory_equal(report, feature, sizeof feature);
	eventfd_t woken;
	int size = 0;
	while ((size = DEVICE_BACKEND.read(&device, wake_fd, -1, report, sizeof report)) > 0)
		stream_add(&got, report, (size_t)size);
	assert_int_equal(size, 0); /* read returned without a report, because wake_fd was written */
	assert_int_equal(eventfd_read(wake_fd, &woken), 0);
	while (got.next < REPORTS) {
		size = DEVICE_BACKEND.read(&device, wake_fd, 5000, report, sizeof report);
		assert_true(size > 0);
		stream_add(&got, report, (size_t)size);
	}
	int64_t before_us;
	size = 0;
	do { /* until the simulated device waits for a write */
		stream_add(&got, report, (size_t)size);
		before_us = input_now_us();
		size = DEVICE_BACKEND.read(&device, wake_fd, 100, report, sizeof report);
	} while (size > 0);
	assert_int_equal(size, 0);
	assert_true(input_now_us() - before_us >= 100000);
	assert_int_equal(got.next, REPORTS);
	DEVICE_BACKEND.close(&device);
	close(wake_fd);
}

/* Files that are no hidraw nodes: hidapi 0.13.1 crashes when it opens them, so it must not get them. */
static void what_is_no_hidraw_is_not_opened(void **state)
{
	(void)state;
	static const char *const paths[] = {"/dev/null", "/dev/zero", "/dev/hidraw8", "/etc/passwd", "/dev"};
	for (size_t i = 0; i < sizeof paths / sizeof *paths; i++) {
		input_device device;
		int error = input_device_open(&DEVICE_BACKEND, paths[i], &device);
		assert_true(error == -ENODEV || error == -EISDIR);
	}
}

#ifdef STILB_TEST_HIDAPI
/* hidapi finds the simulated pad. */
static void hidapi_enumerates_the_pad(void **state)
{
	(void)state;
	struct hid_device_info *found = hid_enumerate(0x054c, 0x05c4);
	assert_non_null(found);
	assert_string_equal(found->path, NODE);
	hid_free_enumeration(found);
	hid_exit();
}
#endif

/* ---- outside ----------------------------------------------------------------------------------------------------- */

static const struct CMUnitTest cases[] = {
	cmocka_unit_test(a_pad_lives),
	cmocka_unit_test(a_pad_is_plugged_in),
	cmocka_unit_test(a_device_is_read_and_asked),
	cmocka_unit_test(what_is_no_hidraw_is_not_opened),
#ifdef STILB_TEST_HIDAPI
	cmocka_unit_test(hidapi_enumerates_the_pad),
#endif
};
#define CASES (sizeof cases / sizeof *cases)

static const char *program;
static char bed_devices[8192], bed_ioctls[512], bed_script[16384];
static size_t bed_script_size;

static size_t write_hex(char *out, const uint8_t *bytes, size_t size)
{
	for (size_t i = 0; i < size; i++)
		sprintf(out + 2 * i, "%02X", bytes[i]);
	return 2 * size;
}

/* Adds a line of umockdev's script format: bytes below 32 are written as ^ and a letter, ^ itself as ^`. */
static void script_add(char operation, const uint8_t *bytes, size_t size)
{
	char *at = bed_script + bed_script_size;
	at += sprintf(at, "%c 5 ", operation);
	for (size_t i = 0; i < size; i++) {
		bool is_escaped = bytes[i] <= 32 || bytes[i] == '^';
		if (is_escaped)
			*at++ = '^';
		*at++ = (char)(bytes[i] == '^' ? '`' : is_escaped ? bytes[i] + 64 : bytes[i]);
	}
	*at++ = '\n';
	bed_script_size = (size_t)(at - bed_script);
}

static int make_bed(void **state)
{
	(void)state;
	const input_test_descriptor *pad = input_test_descriptor_find(STILB_INPUT_BUS_USB, 0x054c, 0x05c4);
	static stilb_input_pad_info info;
	stilb_input_layout layout;
	info = (stilb_input_pad_info){
		.bus = pad->bus, .vendor = pad->vendor, .product = pad->product, .descriptor_size = (uint16_t)pad->size};
	memcpy(info.descriptor, pad->bytes, pad->size);
	if (stilb_input_layout_find(&info, &layout) != STILB_OK)
		return -1;
	char *at = bed_devices;
	at += sprintf(at, "P: /devices/pci0000:00/usb1/0003:054C:05C4.0001\nE: SUBSYSTEM=hid\n"
	                  "E: HID_ID=0003:0000054C:000005C4\nE: HID_NAME=" NAME "\nE: HID_UNIQ=\nH: report_descriptor=");
	at += write_hex(at, pad->bytes, pad->size);
	sprintf(at, "\n\nP: /devices/pci0000:00/usb1/0003:054C:05C4.0001/hidraw/hidraw7\nN: hidraw7\nE: DEVNAME=" NODE
	            "\nE: MAJOR=242\nE: MINOR=7\nE: SUBSYSTEM=hidraw\nL: device=../../../0003:054C:05C4.0001\n\n");
	at = bed_ioctls + sprintf(bed_ioctls, "HIDIOCGRDESCSIZE 0 FB010000\nHIDIOCGFEATURE %zu ", sizeof feature);
	at += write_hex(at, feature, sizeof feature);
	sprintf(at, "\n");
	for (uint32_t i = 0; i < 2 * REPORTS; i++) {
		uint8_t report[SIZE], rumble[STILB_INPUT_OUTPUT_MAX];
		if (i == REPORTS)
			script_add('w', rumble, stilb_input_rumble_report(&layout, 1.0f, 0.5f, 0, rumble));
		make_report(i, report);
		script_add('r', report, sizeof report);
	}
	return 0;
}

static void run_case(void **state)
{
	char folder[] = "/tmp/stilb-umockdev-XXXXXX";
	program_run run;
	umockdev_bed bed = {.node = NODE,
	                    .devices = bed_devices,
	                    .ioctls = bed_ioctls,
	                    .script = bed_script,
	                    .script_size = bed_script_size};
	assert_non_null(mkdtemp(folder));
	bool is_run = umockdev_run(&run, &bed, folder, (const char *const[]){program, *state, NULL});
	rmdir(folder);
	assert_true(is_run);
	if (run.code != 0)
		fail_msg("in the test bed:\n%s%s", run.out, run.err);
}

int main(int argc, char **argv)
{
	program = argv[0];
	if (argc > 1) {
		const struct CMUnitTest *one = &cases[strtoul(argv[1], NULL, 10) % CASES];
		return _cmocka_run_group_tests("input_umockdev, inside", one, 1, NULL, NULL);
	}
	if (!umockdev_is_installed()) {
		printf("skipped: no umockdev-run; the package umockdev has it\n");
		return 77;
	}
	struct CMUnitTest runs[CASES];
	static char numbers[CASES][4];
	for (size_t i = 0; i < CASES; i++) {
		snprintf(numbers[i], sizeof numbers[i], "%zu", i);
		runs[i] = (struct CMUnitTest){.name = cases[i].name, .test_func = run_case, .initial_state = numbers[i]};
	}
	return _cmocka_run_group_tests("input_umockdev", runs, CASES, make_bed, NULL);
}
