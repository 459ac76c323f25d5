/* input_layout, known pads: every button, axis and hat value of every pad of the table, by recordings in the format of
 * hid-recorder (recordings/NAME.rec) and the states that they mean (recordings/NAME.txt); what is sent to a pad when it
 * is opened; what makes it rumble. The first argument is the folder of the recordings. */
#include "input/hid/input_layout.h"
#include "input/input_recording.h"
#include "support/input_descriptors.h"
#include "support/test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *folder;

static stilb_input_pad_info info_of(uint16_t bus, uint16_t vendor, uint16_t product)
{
	stilb_input_pad_info info = {.bus = bus, .vendor = vendor, .product = product, .name = "a pad"};
	const input_test_descriptor *descriptor = input_test_descriptor_find(bus, vendor, product);
	if (descriptor) {
		info.descriptor_size = (uint16_t)descriptor->size;
		memcpy(info.descriptor, descriptor->bytes, descriptor->size);
	}
	return info;
}

static void find(const stilb_input_pad_info *info, stilb_input_layout *layout)
{
	if (stilb_input_layout_find(info, layout) != STILB_OK)
		fail_msg("%04x:%04x: %s", info->vendor, info->product, stilb_error_message());
}

/* ---- recordings -------------------------------------------------------------------------------------------------- */

/* Writes a state like "left_x=-1.000000 south+up", without axes that are 0; "rest" if all is at rest. */
static void state_text(const stilb_input_pad_state *state, char text[512])
{
	int used = 0;
	for (int i = 0; i < STILB_INPUT_AXIS_COUNT; i++)
		if (state->axes[i] != 0.0f)
			used += sprintf(text + used, "%s%s=%.6f", used > 0 ? " " : "", stilb_input_axis_names[i],
			                (double)state->axes[i]);
	for (uint32_t i = 0, before = 0; i < STILB_INPUT_BUTTON_COUNT; i++)
		if (state->buttons >> i & 1)
			used += sprintf(text + used, "%s%s", before++ > 0 ? "+" : used > 0 ? " " : "", stilb_input_button_names[i]);
	if (used == 0)
		strcpy(text, "rest");
}

static FILE *open_text(const char *name, const char *kind, char *path, size_t size)
{
	snprintf(path, size, "%s/%s.%s", folder, name, kind);
	FILE *file = fopen(path, "r");
	if (!file)
		fail_msg("%s is missing", path);
	return file;
}

/* The next line that is not a remark, without its line end; false: there is none. */
static bool next_line(FILE *file, char line[512])
{
	while (fgets(line, 512, file)) {
		line[strcspn(line, "\n")] = '\0';
		if (line[0] != '#')
			return true;
	}
	return false;
}

/* Checks that every report of recordings/NAME.rec decodes to the state in the next line of recordings/NAME.txt. */
static void replay(const char *name)
{
	static stilb_input_layout layout;
	static const char *const words[] = {
		[STILB_INPUT_DECODED] = NULL, [STILB_INPUT_OTHER] = "other", [STILB_INPUT_CORRUPT] = "corrupt"};
	char path[512], line[512], expected_path[512];
	snprintf(path, sizeof path, "%s/%s.rec", folder, name);
	FILE *expected = open_text(name, "txt", expected_path, sizeof expected_path);
	stilb_input_recording *recording;
	if (stilb_input_recording_load(path, &recording) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stilb_input_pad_state state = {0};
	stilb_input_event event;
	uint32_t reports = 0;
	while (stilb_input_recording_next(recording, INT64_MAX, &event)) {
		if (event.kind == STILB_INPUT_PAD_ADDED)
			find(event.info, &layout);
		if (event.kind != STILB_INPUT_PAD_REPORT)
			continue;
		char text[600], what[512];
		stilb_input_pad_state before = state;
		stilb_input_decoded decoded = stilb_input_decode(&layout, event.bytes, event.size, &state);
		state_text(&state, what);
		snprintf(text, sizeof text, "%06d.%06d %s", (int)(event.time_us / 1000000), (int)(event.time_us % 1000000),
		         words[decoded] ? words[decoded] : what);
		if (!next_line(expected, line))
			fail_msg("%s ends before report %u", expected_path, reports);
		if (strcmp(text, line) != 0)
			fail_msg("%s, report %u:\n  is     %s\n  should %s", name, reports, text, line);
		if (decoded != STILB_INPUT_DECODED)
			assert_memory_equal(&state, &before, sizeof state);
		reports++;
	}
	assert_false(next_line(expected, line));
	assert_true(reports >= 40);
	stilb_input_recording_free(recording);
	fclose(expected);
}

static void test_recordings(void **user)
{
	(void)user;
	static const char *const names[] = {"ds4_usb",    "ds4_bluetooth",    "dualsense_usb", "dualsense_bluetooth",
	                                    "ds3_usb",    "xbox_02e0",        "xbox_02fd",     "xbox_0b13",
	                                    "switch_usb", "switch_bluetooth", "asus",          "raptor"};
	for (size_t i = 0; i < sizeof names / sizeof *names; i++)
		replay(names[i]);
}

/* ---- the table --------------------------------------------------------------------------------------------------- */

static const struct {
	uint16_t bus, vendor, product;
	const char *name, *recognised;
	stilb_input_rumble_kind rumble;
} pads[] = {
	{3, 0x054c, 0x05c4, "DualShock 4, USB", "known pad 054c:05c4", STILB_INPUT_RUMBLE_DS4_USB},
	{3, 0x054c, 0x09cc, "DualShock 4, USB", "known pad 054c:09cc", STILB_INPUT_RUMBLE_DS4_USB},
	{3, 0x054c, 0x0ba0, "DualShock 4 wireless adaptor, USB", "known pad 054c:0ba0", STILB_INPUT_RUMBLE_DS4_USB},
	{5, 0x054c, 0x05c4, "DualShock 4, Bluetooth", "known pad 054c:05c4", STILB_INPUT_RUMBLE_DS4_BLUETOOTH},
	{5, 0x054c, 0x09cc, "DualShock 4, Bluetooth", "known pad 054c:09cc", STILB_INPUT_RUMBLE_DS4_BLUETOOTH},
	{3, 0x054c, 0x0ce6, "DualSense, USB", "known pad 054c:0ce6", STILB_INPUT_RUMBLE_DUALSENSE_USB},
	{5, 0x054c, 0x0ce6, "DualSense, Bluetooth", "known pad 054c:0ce6", STILB_INPUT_RUMBLE_DUALSENSE_BLUETOOTH},
	{3, 0x054c, 0x0df2, "DualSense Edge, USB", "known pad 054c:0df2", STILB_INPUT_RUMBLE_DUALSENSE_USB},
	{5, 0x054c, 0x0df2, "DualSense Edge, Bluetooth", "known pad 054c:0df2", STILB_INPUT_RUMBLE_DUALSENSE_BLUETOOTH},
	{3, 0x054c, 0x0268, "DualShock 3, USB", "known pad 054c:0268", STILB_INPUT_RUMBLE_NONE},
	{3, 0x057e, 0x2009, "Switch Pro Controller, USB", "known pad 057e:2009", STILB_INPUT_RUMBLE_SWITCH},
	{5, 0x057e, 0x2009, "Switch Pro Controller, Bluetooth", "known pad 057e:2009", STILB_INPUT_RUMBLE_SWITCH},
	{5, 0x045e, 0x02e0, "Xbox One S Controller, Bluetooth",
     "known pad, its descriptor: two sticks, triggers, 15 buttons in the Xbox order",
     STILB_INPUT_RUMBLE_XBOX_BLUETOOTH},
	{5, 0x045e, 0x02fd, "Xbox One S Controller, Bluetooth",
     "known pad, its descriptor: two sticks, triggers, 15 buttons in the Android order",
     STILB_INPUT_RUMBLE_XBOX_BLUETOOTH},
	{5, 0x045e, 0x0b05, "Xbox Elite Controller 2, Bluetooth",
     "known pad, its descriptor: two sticks, triggers, 15 buttons in the Android order",
     STILB_INPUT_RUMBLE_XBOX_BLUETOOTH},
	{5, 0x045e, 0x0b13, "Xbox Series Controller, Bluetooth",
     "known pad, its descriptor: two sticks, triggers, 16 buttons in the Android order",
     STILB_INPUT_RUMBLE_XBOX_BLUETOOTH},
};

/* A row of the table that gives the reports needs no descriptor of the pad, which sysfs may lack. */
static void test_names(void **user)
{
	(void)user;
	static stilb_input_layout layout;
	for (size_t i = 0; i < sizeof pads / sizeof *pads; i++) {
		stilb_input_pad_info info = info_of(pads[i].bus, pads[i].vendor, pads[i].product);
		find(&info, &layout);
		assert_string_equal(layout.name, pads[i].name);
		assert_string_equal(layout.recognised, pads[i].recognised);
		assert_int_equal(layout.rumble, pads[i].rumble);
		assert_true(layout.known);
		for (uint32_t k = 0; k < layout.report_count; k++)
			for (uint32_t n = 0; n < layout.reports[k].source_count; n++)
				assert_true(layout.reports[k].sources[n].bit + layout.reports[k].sources[n].bits <=
				            8u * layout.reports[k].size);
	}
}

static void assert_same_reports(const stilb_input_layout *a, const stilb_input_layout *b)
{
	assert_int_equal(a->report_count, b->report_count);
	for (uint32_t i = 0; i < a->report_count; i++) {
		assert_int_equal(a->reports[i].id, b->reports[i].id);
		assert_int_equal(a->reports[i].size, b->reports[i].size);
		assert_int_equal(a->reports[i].source_count, b->reports[i].source_count);
		assert_memory_equal(a->reports[i].sources, b->reports[i].sources, sizeof a->reports[i].sources);
	}
}

/* An Xbox pad with the first firmware's descriptor and a newer pad's product number, and the other way round, is read
 * by its descriptor. */
static void test_xbox_by_its_descriptor(void **user)
{
	(void)user;
	static stilb_input_layout layout, same;
	stilb_input_pad_info old = info_of(5, 0x045e, 0x02e0), new = info_of(5, 0x045e, 0x02fd);
	find(&old, &layout);
	old.product = 0x02fd;
	find(&old, &same);
	assert_same_reports(&same, &layout);
	find(&new, &layout);
	new.product = 0x02e0;
	find(&new, &same);
	assert_same_reports(&same, &layout);
	new.vendor = 0x1234; /* another vendor's, compatible with Microsoft's */
	find(&new, &same);
	assert_same_reports(&same, &layout);
	assert_int_equal(same.rumble, STILB_INPUT_RUMBLE_XBOX_BLUETOOTH);
	assert_false(same.known);
}

/* A copy with a DualShock's numbers and the Asus pad's reports is read by its descriptor; so is one on another bus. */
static void test_copies(void **user)
{
	(void)user;
	static stilb_input_layout layout;
	stilb_input_pad_info info = info_of(3, 0x18d1, 0x2c40);
	info.vendor = 0x054c;
	info.product = 0x05c4;
	find(&info, &layout);
	assert_false(layout.known);
	assert_string_equal(layout.name, "a pad, USB");
	assert_string_equal(layout.recognised, "its descriptor: two sticks, triggers, 14 buttons in the Android order");
	assert_int_equal(layout.rumble, STILB_INPUT_RUMBLE_NONE);
	assert_int_equal(layout.hello[0].kind, STILB_INPUT_HELLO_END);
	info.bus = STILB_INPUT_BUS_BLUETOOTH;
	find(&info, &layout);
	assert_false(layout.known);
	info.bus = STILB_INPUT_BUS_USB;
	/* The row needs an input report of its id and size; an output report like it does not suffice. */
	static const uint8_t small[] = {0x05, 0x01, 0x09, 0x05, 0xa1, 0x01, 0x85, 0x01, 0x75, 0x08, 0x95,
	                                0x3f, 0x09, 0x01, 0x91, 0x02, 0x09, 0x30, 0x09, 0x31, 0x15, 0x00,
	                                0x26, 0xff, 0x00, 0x95, 0x02, 0x81, 0x02, 0x05, 0x09, 0x19, 0x01,
	                                0x29, 0x08, 0x25, 0x01, 0x75, 0x01, 0x95, 0x08, 0x81, 0x02, 0xc0};
	memcpy(info.descriptor, small, sizeof small);
	info.descriptor_size = sizeof small;
	find(&info, &layout);
	assert_false(layout.known);
	info = info_of(3, 0x054c, 0x05c4);
	info.bus = 0x18;
	find(&info, &layout);
	assert_false(layout.known);
	assert_string_equal(layout.name, "a pad");
}

/* A broken descriptor does no harm to a pad whose row in the table gives the reports. */
static void test_broken_descriptors(void **user)
{
	(void)user;
	static stilb_input_layout layout;
	stilb_input_pad_info info = info_of(3, 0x054c, 0x05c4);
	info.descriptor_size = 2;
	info.descriptor[1] = 0xff;
	info.descriptor[0] = 0x26; /* two bytes of data, of which there is one */
	find(&info, &layout);
	assert_string_equal(layout.name, "DualShock 4, USB");
	info = info_of(5, 0x045e, 0x02e0);
	info.descriptor_size = 300;
	assert_int_equal(stilb_input_layout_find(&info, &layout), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "'a pad' (045e:02e0) is not a gamepad: report descriptor, byte "));
}

static void test_another_order_of_buttons(void **user)
{
	(void)user;
	static stilb_input_layout layout;
	stilb_input_pad_info info = info_of(3, 0x054c, 0x0268); /* a pad whose descriptor leaves the buttons open */
	info.vendor = 0x0079;
	info.product = 0x0006;
	find(&info, &layout);
	assert_true(layout.known);
	assert_string_equal(layout.recognised,
	                    "known pad, its descriptor: two sticks, triggers, 10 buttons counted from the top one");
	uint8_t report[49] = {0x01, 0, 0x04, 0, 0, 0, 128, 128, 128, 128};
	stilb_input_pad_state state = {0};
	assert_int_equal(stilb_input_decode(&layout, report, sizeof report, &state), STILB_INPUT_DECODED);
	assert_int_equal(state.buttons, 1u << STILB_INPUT_SOUTH);
}

/* While its pad is off a wireless adaptor repeats the pad's last state. */
static void test_adaptor_without_its_pad(void **user)
{
	(void)user;
	static stilb_input_layout layout;
	stilb_input_pad_info info = info_of(3, 0x054c, 0x0ba0);
	find(&info, &layout);
	uint8_t report[64] = {0x01, 255, 128, 128, 128, 0x28, 0, 0, 255};
	stilb_input_pad_state state = {0};
	stilb_input_pad_state rest = {0};
	assert_int_equal(stilb_input_decode(&layout, report, sizeof report, &state), STILB_INPUT_DECODED);
	assert_true(state.axes[STILB_INPUT_LEFT_X] == 1.0f && state.axes[STILB_INPUT_LEFT_TRIGGER] == 1.0f);
	assert_int_equal(state.buttons, 1u << STILB_INPUT_SOUTH);
	report[31] = 0x04;
	assert_int_equal(stilb_input_decode(&layout, report, sizeof report, &state), STILB_INPUT_DECODED);
	assert_memory_equal(&state, &rest, sizeof state);
}

/* ---- what is said at first --------------------------------------------------------------------------------------- */

static void test_hello(void **user)
{
	(void)user;
	static stilb_input_layout layout;
	static const uint16_t features[][4] = {{5, 0x05c4, 0x05, 41}, {5, 0x0ce6, 0x05, 41}, {3, 0x0268, 0xf2, 17}};
	for (size_t i = 0; i < 3; i++) {
		stilb_input_pad_info info = info_of(features[i][0], 0x054c, features[i][1]);
		find(&info, &layout);
		assert_int_equal(layout.hello[0].kind, STILB_INPUT_HELLO_GET_FEATURE);
		assert_int_equal(layout.hello[0].bytes[0], features[i][2]);
		assert_int_equal(layout.hello[0].size, features[i][3]);
	}
	stilb_input_pad_info info = info_of(3, 0x057e, 0x2009);
	find(&info, &layout);
	static const uint8_t commands[4] = {0x02, 0x03, 0x02, 0x04};
	static const uint8_t full[12] = {0x01, 0x00, 0x00, 0x01, 0x40, 0x40, 0x00, 0x01, 0x40, 0x40, 0x03, 0x30};
	for (size_t i = 0; i < 4; i++) {
		assert_int_equal(layout.hello[i].kind, STILB_INPUT_HELLO_WRITE);
		assert_int_equal(layout.hello[i].size, 2);
		assert_int_equal(layout.hello[i].bytes[0], 0x80);
		assert_int_equal(layout.hello[i].bytes[1], commands[i]);
	}
	assert_int_equal(layout.hello[4].size, 12);
	assert_memory_equal(layout.hello[4].bytes, full, 12);
	assert_int_equal(layout.hello[5].bytes[10], 0x48);
	assert_int_equal(layout.hello[6].kind, STILB_INPUT_HELLO_END);
	info = info_of(5, 0x057e, 0x2009);
	find(&info, &layout);
	assert_memory_equal(layout.hello[0].bytes, full, 12);
	info = info_of(3, 0x054c, 0x05c4);
	find(&info, &layout);
	assert_int_equal(layout.hello[0].kind, STILB_INPUT_HELLO_END);
}

/* ---- rumble ------------------------------------------------------------------------------------------------------ */

/* Checks a rumble report: its first `known` bytes are these, and zeros follow. The CRC at the end of a Sony pad's
 * report over Bluetooth is left to test_rumble_crc. */
static void rumble_is(uint16_t bus, uint16_t vendor, uint16_t product, float heavy, float light, uint32_t sequence,
                      size_t size, const uint8_t *bytes, size_t known)
{
	static stilb_input_layout layout;
	uint8_t report[STILB_INPUT_OUTPUT_MAX], expected[STILB_INPUT_OUTPUT_MAX] = {0};
	stilb_input_pad_info info = info_of(bus, vendor, product);
	find(&info, &layout);
	memset(report, 0x5a, sizeof report);
	assert_int_equal(stilb_input_rumble_report(&layout, heavy, light, sequence, report), size);
	memcpy(expected, bytes, known);
	bool crc = bus == STILB_INPUT_BUS_BLUETOOTH && vendor == 0x054c;
	assert_memory_equal(report, expected, crc ? size - 4 : size);
}

#define RUMBLE(bus, vendor, product, heavy, light, sequence, size, ...)                                                \
	rumble_is(bus, vendor, product, heavy, light, sequence, size, (const uint8_t[]){__VA_ARGS__},                      \
	          sizeof((const uint8_t[]){__VA_ARGS__}))

static void test_rumble(void **user)
{
	(void)user;
	RUMBLE(3, 0x054c, 0x05c4, 1.0f, 0.5f, 7, 32, 0x05, 0x01, 0, 0, 128, 255);
	RUMBLE(3, 0x054c, 0x05c4, 0.0f, 0.0f, 8, 32, 0x05, 0x01);
	RUMBLE(5, 0x054c, 0x05c4, 0.25f, 1.0f, 7, 78, 0x11, 0xc0, 0, 0x01, 0, 0, 255, 64);
	RUMBLE(3, 0x054c, 0x0ce6, 1.0f, 0.5f, 7, 48, 0x02, 0x03, 0, 128, 255);
	RUMBLE(5, 0x054c, 0x0ce6, 1.0f, 0.5f, 7, 78, 0x31, 0x70, 0x10, 0x03, 0, 128, 255);
	RUMBLE(5, 0x054c, 0x0ce6, 1.0f, 0.5f, 0x13, 78, 0x31, 0x30, 0x10, 0x03, 0, 128, 255);
	RUMBLE(5, 0x045e, 0x02e0, 1.0f, 0.5f, 7, 9, 0x03, 0x03, 0, 0, 100, 50, 0xff, 0, 0xff);
	RUMBLE(5, 0x045e, 0x02fd, 0.0f, 0.01f, 7, 9, 0x03, 0x03, 0, 0, 0, 1, 0xff, 0, 0xff);
	RUMBLE(3, 0x057e, 0x2009, 0.0f, 0.0f, 0x1f, 10, 0x10, 0x0f, 0x00, 0x01, 0x40, 0x40, 0x00, 0x01, 0x40, 0x40);
	/* amplitudes 1.003 (bytes 0xc8, 0x0072) and 0.501 (0x88, 0x0062) of hid-nintendo's table */
	RUMBLE(5, 0x057e, 0x2009, 1.0f, 0.501f, 2, 10, 0x10, 0x02, 0x00, 0xc9, 0x40, 0x72, 0x00, 0x89, 0x40, 0x62);
	/* 0.112 (0x1e, 0x8047) and 0.020 (0x0a, 0x8042) */
	RUMBLE(5, 0x057e, 0x2009, 0.112f, 0.020f, 2, 10, 0x10, 0x02, 0x00, 0x1f, 0xc0, 0x47, 0x00, 0x0b, 0xc0, 0x42);
	/* 0.173 (0x32, 0x804c) and 0.355 (0x68, 0x005a); less than the table's first row */
	RUMBLE(5, 0x057e, 0x2009, 0.173f, 0.355f, 2, 10, 0x10, 0x02, 0x00, 0x33, 0xc0, 0x4c, 0x00, 0x69, 0x40, 0x5a);
	RUMBLE(5, 0x057e, 0x2009, 0.009f, 0.004f, 2, 10, 0x10, 0x02, 0x00, 0x01, 0x40, 0x40, 0x00, 0x01, 0x40, 0x40);
	/* strengths beyond 0..1 */
	RUMBLE(3, 0x054c, 0x05c4, 9.0f, -1.0f, 7, 32, 0x05, 0x01, 0, 0, 0, 255);
	RUMBLE(5, 0x057e, 0x2009, -1.0f, 9.0f, 0, 10, 0x10, 0x00, 0x00, 0x01, 0x40, 0x40, 0x00, 0xc9, 0x40, 0x72);
	RUMBLE(3, 0x054c, 0x0268, 1.0f, 1.0f, 7, 0, 0);
}

/* The whole of two Bluetooth reports; the CRCs are zlib's, of 0xa2 and the bytes before. */
static void test_rumble_crc(void **user)
{
	(void)user;
	static stilb_input_layout layout;
	uint8_t report[STILB_INPUT_OUTPUT_MAX];
	static const uint8_t ds4_crc[4] = {0xa3, 0xc2, 0xc5, 0x53}, dualsense_crc[4] = {0xcf, 0x9c, 0x0e, 0xce};
	stilb_input_pad_info info = info_of(5, 0x054c, 0x05c4);
	find(&info, &layout);
	assert_int_equal(stilb_input_rumble_report(&layout, 1.0f, 0.5f, 0, report), 78);
	assert_memory_equal(report + 74, ds4_crc, 4);
	info = info_of(5, 0x054c, 0x0ce6);
	find(&info, &layout);
	assert_int_equal(stilb_input_rumble_report(&layout, 1.0f, 0.5f, 3, report), 78);
	assert_memory_equal(report + 74, dualsense_crc, 4);
}

int main(int argc, char **argv)
{
	if (argc != 2) {
		fprintf(stderr, "usage: test_input_known FOLDER\n");
		return 1;
	}
	folder = argv[1];
	struct CMUnitTest tests[] = {
		cmocka_unit_test(test_recordings),
		cmocka_unit_test(test_names),
		cmocka_unit_test(test_xbox_by_its_descriptor),
		cmocka_unit_test(test_copies),
		cmocka_unit_test(test_broken_descriptors),
		cmocka_unit_test(test_another_order_of_buttons),
		cmocka_unit_test(test_adaptor_without_its_pad),
		cmocka_unit_test(test_hello),
		cmocka_unit_test(test_rumble),
		cmocka_unit_test(test_rumble_crc),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
