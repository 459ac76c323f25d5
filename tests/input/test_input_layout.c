/* input_layout: decoding reports by a layout, and finding the layout of an unknown pad by its descriptor. */
#include "input/hid/input_layout.h"
#include "support/input_descriptors.h"
#include "support/test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- CRC --------------------------------------------------------------------------------------------------------- */

/* The CRC-32 by its definition, a bit at a time, to compare with. */
static uint32_t crc32_bit_by_bit(uint32_t crc, const uint8_t *bytes, size_t size)
{
	crc = ~crc;
	for (size_t i = 0; i < size; i++) {
		crc ^= bytes[i];
		for (int bit = 0; bit < 8; bit++)
			crc = crc & 1 ? crc >> 1 ^ 0xedb88320 : crc >> 1;
	}
	return ~crc;
}

static void test_crc(void **user)
{
	(void)user;
	assert_int_equal(stilb_input_crc32(0, "123456789", 9), 0xcbf43926);
	assert_int_equal(stilb_input_crc32(stilb_input_crc32(0, "1234", 4), "56789", 5), 0xcbf43926);
	assert_int_equal(stilb_input_crc32(0, "", 0), 0);
	uint8_t bytes[300];
	for (size_t i = 0; i < sizeof bytes; i++)
		bytes[i] = (uint8_t)stilb_random_u64(1, i);
	for (size_t size = 0; size <= sizeof bytes; size++)
		assert_int_equal(stilb_input_crc32((uint32_t)size, bytes, size), crc32_bit_by_bit((uint32_t)size, bytes, size));
}

static void test_names(void **user)
{
	(void)user;
	for (int i = 0; i < STILB_INPUT_AXIS_COUNT; i++) {
		assert_non_null(stilb_input_axis_names[i]);
		for (int k = 0; k < i; k++)
			assert_string_not_equal(stilb_input_axis_names[i], stilb_input_axis_names[k]);
	}
	for (int i = 0; i < STILB_INPUT_BUTTON_COUNT; i++) {
		assert_non_null(stilb_input_button_names[i]);
		for (int k = 0; k < i; k++)
			assert_string_not_equal(stilb_input_button_names[i], stilb_input_button_names[k]);
	}
}

/* ---- decode ------------------------------------------------------------------------------------------------------ */

/* A layout of one source in a report without number: 32 bits from the first byte on. */
static stilb_input_layout one_source(stilb_input_source source)
{
	return (stilb_input_layout){.report_count = 1, .reports[0] = {.size = 4, .source_count = 1, .sources[0] = source}};
}

static stilb_input_pad_state decode_u32(stilb_input_source source, uint32_t value)
{
	stilb_input_layout layout = one_source(source);
	uint8_t report[4] = {(uint8_t)value, (uint8_t)(value >> 8), (uint8_t)(value >> 16), (uint8_t)(value >> 24)};
	stilb_input_pad_state state = {0};
	assert_int_equal(stilb_input_decode(&layout, report, sizeof report, &state), STILB_INPUT_DECODED);
	return state;
}

/* The ends of an axis's range become exactly -1 (0 for triggers) and 1, its rest 0, and values beyond the range become
 * its ends. */
static void test_axes(void **user)
{
	(void)user;
	static const struct {
		stilb_input_axis axis;
		uint8_t bits;
		bool is_signed;
		int64_t low, high;
		uint32_t value;
		double expected;
	} cases[] = {
		{STILB_INPUT_LEFT_X, 8, false, 0, 255, 0, -1.0},
		{STILB_INPUT_LEFT_X, 8, false, 0, 255, 64, -0.5},
		{STILB_INPUT_LEFT_X, 8, false, 0, 255, 128, 0.0},
		{STILB_INPUT_LEFT_X, 8, false, 0, 255, 255, 1.0},
		{STILB_INPUT_LEFT_Y, 8, false, 255, 0, 0, 1.0},
		{STILB_INPUT_LEFT_Y, 8, false, 255, 0, 128, 0.0},
		{STILB_INPUT_LEFT_Y, 8, false, 255, 0, 255, -1.0},
		{STILB_INPUT_RIGHT_X, 8, true, -128, 127, 0x80, -1.0},
		{STILB_INPUT_RIGHT_X, 8, true, -128, 127, 0x00, 0.0},
		{STILB_INPUT_RIGHT_X, 8, true, -128, 127, 0x7f, 1.0},
		{STILB_INPUT_RIGHT_X, 8, true, -127, 127, 0x80, -1.0}, /* -128: beyond */
		{STILB_INPUT_RIGHT_Y, 16, true, 32767, -32768, 0x8000, 1.0},
		{STILB_INPUT_RIGHT_Y, 16, true, 32767, -32768, 0xffff, 1.0 / 32768},
		{STILB_INPUT_RIGHT_Y, 12, false, 500, 3500, 4095, 1.0},
		{STILB_INPUT_RIGHT_Y, 12, false, 500, 3500, 2000, 0.0},
		{STILB_INPUT_RIGHT_Y, 12, false, 500, 3500, 0, -1.0},
		{STILB_INPUT_LEFT_X, 32, true, INT32_MIN, INT32_MAX, 0x80000000, -1.0},
		{STILB_INPUT_LEFT_X, 32, true, INT32_MIN, INT32_MAX, 0, 0.0},
		{STILB_INPUT_LEFT_X, 32, false, 0, UINT32_MAX, 0xffffffff, 1.0},
		{STILB_INPUT_LEFT_X, 8, false, 7, 7, 9, 0.0}, /* no range: at rest */
		{STILB_INPUT_LEFT_TRIGGER, 8, false, 0, 255, 0, 0.0},
		{STILB_INPUT_LEFT_TRIGGER, 8, false, 0, 255, 51, 0.2},
		{STILB_INPUT_RIGHT_TRIGGER, 10, false, 0, 1023, 1023, 1.0},
		{STILB_INPUT_RIGHT_TRIGGER, 8, false, 255, 0, 255, 0.0},
		{STILB_INPUT_RIGHT_TRIGGER, 8, false, 20, 200, 10, 0.0},
		{STILB_INPUT_RIGHT_TRIGGER, 8, false, 20, 200, 250, 1.0},
		{STILB_INPUT_RIGHT_TRIGGER, 1, false, 0, 1, 1, 1.0},
		{STILB_INPUT_RIGHT_TRIGGER, 8, false, 7, 7, 9, 0.0},
	};
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		stilb_input_source source = {.kind = STILB_INPUT_SOURCE_AXIS,
		                             .target = (uint8_t)cases[i].axis,
		                             .bits = cases[i].bits,
		                             .is_signed = cases[i].is_signed,
		                             .low = cases[i].low,
		                             .high = cases[i].high};
		stilb_input_pad_state state = decode_u32(source, cases[i].value);
		if (state.axes[cases[i].axis] != (float)cases[i].expected)
			fail_msg("case %zu: %f instead of %f", i, (double)state.axes[cases[i].axis], cases[i].expected);
		for (int k = 0; k < STILB_INPUT_AXIS_COUNT; k++)
			assert_true(k == (int)cases[i].axis || state.axes[k] == 0.0f);
		assert_int_equal(state.buttons, 0);
	}
}

/* The axis rises strictly with the value and stays within its range. */
static void test_axes_rise(void **user)
{
	(void)user;
	for (uint32_t top = 2; top < 300; top++) {
		float before[2] = {-2.0f, -2.0f};
		for (uint32_t value = 0; value <= top; value++)
			for (int k = 0; k < 2; k++) {
				stilb_input_axis axis = k == 0 ? STILB_INPUT_LEFT_X : STILB_INPUT_LEFT_TRIGGER;
				stilb_input_source source = {
					.kind = STILB_INPUT_SOURCE_AXIS, .target = (uint8_t)axis, .bits = 16, .high = top};
				float now = decode_u32(source, value).axes[axis];
				assert_true(now > before[k] && now >= (k == 0 ? -1.0f : 0.0f) && now <= 1.0f);
				before[k] = now;
			}
		assert_true(before[0] == 1.0f && before[1] == 1.0f);
	}
}

enum {
	UP = 1 << STILB_INPUT_UP,
	DOWN = 1 << STILB_INPUT_DOWN,
	LEFT = 1 << STILB_INPUT_LEFT,
	RIGHT = 1 << STILB_INPUT_RIGHT
};
static const uint32_t around[8] = {UP, UP | RIGHT, RIGHT, DOWN | RIGHT, DOWN, DOWN | LEFT, LEFT, UP | LEFT};

static uint32_t hat_buttons(int64_t low, int64_t high, uint32_t value)
{
	stilb_input_source source = {.kind = STILB_INPUT_SOURCE_HAT, .bits = 16, .low = low, .high = high};
	return decode_u32(source, value).buttons;
}

static void test_hats(void **user)
{
	(void)user;
	for (uint32_t i = 0; i < 8; i++) {
		assert_int_equal(hat_buttons(0, 7, i), around[i]);
		assert_int_equal(hat_buttons(1, 8, i + 1), around[i]);
		for (uint32_t k = 0; k < 45; k++) {              /* an angle is rounded to the nearest direction */
			uint32_t degrees = (45 * i + k + 338) % 360; /* from 22 degrees below direction i to 22 above */
			assert_int_equal(hat_buttons(0, 359, degrees), around[i]);
		}
	}
	for (uint32_t i = 0; i < 4; i++)
		assert_int_equal(hat_buttons(0, 3, i), around[2 * i]);
	for (uint32_t i = 8; i < 16; i++)
		assert_int_equal(hat_buttons(0, 7, i), 0);
	assert_int_equal(hat_buttons(1, 8, 0), 0);
	assert_int_equal(hat_buttons(0, 359, 360), 0);
	assert_int_equal(hat_buttons(0, 3, 4), 0);
}

/* Two elements of an array, each of which may name either of two buttons. */
static void test_buttons_of_several_sources(void **user)
{
	(void)user;
	stilb_input_layout layout = {.report_count = 1, .reports[0] = {.size = 2, .source_count = 4}};
	for (uint32_t i = 0; i < 4; i++)
		layout.reports[0].sources[i] = (stilb_input_source){.kind = STILB_INPUT_SOURCE_BUTTON,
		                                                    .target = i < 2 ? STILB_INPUT_SOUTH : STILB_INPUT_EAST,
		                                                    .bits = 8,
		                                                    .bit = 8 * (i % 2),
		                                                    .low = i < 2 ? 1 : 2,
		                                                    .high = i < 2 ? 1 : 2};
	static const uint8_t reports[5][2] = {{0, 0}, {1, 0}, {0, 1}, {2, 1}, {3, 2}};
	static const uint32_t expected[5] = {0, 1, 1, 3, 2};
	stilb_input_pad_state state = {.buttons = 1u << STILB_INPUT_GUIDE}; /* this report has no source for it */
	for (uint32_t i = 0; i < 5; i++) {
		assert_int_equal(stilb_input_decode(&layout, reports[i], 2, &state), STILB_INPUT_DECODED);
		assert_int_equal(state.buttons, expected[i] | 1u << STILB_INPUT_GUIDE);
	}
}

static stilb_input_source axis_byte(stilb_input_axis axis, uint32_t byte)
{
	return (stilb_input_source){
		.kind = STILB_INPUT_SOURCE_AXIS, .target = (uint8_t)axis, .bits = 8, .bit = 8 * byte, .high = 255};
}

/* A short report leaves the axes and buttons that it lacks as they were; one that lacks all is corrupt and changes
 * nothing. */
static void test_short_reports(void **user)
{
	(void)user;
	stilb_input_layout layout = {.report_count = 1, .reports[0] = {.id = 3, .size = 3, .source_count = 2}};
	layout.reports[0].sources[0] = axis_byte(STILB_INPUT_LEFT_X, 1);
	layout.reports[0].sources[1] = axis_byte(STILB_INPUT_RIGHT_X, 2);
	uint8_t report[3] = {3, 0, 0};
	stilb_input_pad_state state = {.axes = {0.25f, 0, 0.25f}};
	assert_int_equal(stilb_input_decode(&layout, NULL, 0, &state), STILB_INPUT_CORRUPT);
	assert_int_equal(stilb_input_decode(&layout, report, 1, &state), STILB_INPUT_CORRUPT);
	assert_true(state.axes[STILB_INPUT_LEFT_X] == 0.25f && state.axes[STILB_INPUT_RIGHT_X] == 0.25f);
	assert_int_equal(stilb_input_decode(&layout, report, 2, &state), STILB_INPUT_DECODED);
	assert_true(state.axes[STILB_INPUT_LEFT_X] == -1.0f && state.axes[STILB_INPUT_RIGHT_X] == 0.25f);
	assert_int_equal(stilb_input_decode(&layout, report, 3, &state), STILB_INPUT_DECODED);
	assert_true(state.axes[STILB_INPUT_RIGHT_X] == -1.0f);
	uint8_t other[3] = {4, 255, 255};
	assert_int_equal(stilb_input_decode(&layout, other, 3, &state), STILB_INPUT_OTHER);
	assert_true(state.axes[STILB_INPUT_LEFT_X] == -1.0f);
	layout.reports[0].id = 0; /* without ids the first byte belongs to the state */
	layout.reports[0].sources[0].bit = 0;
	assert_int_equal(stilb_input_decode(&layout, other, 3, &state), STILB_INPUT_DECODED);
	assert_true(state.axes[STILB_INPUT_LEFT_X] == (float)(4 - 128) / 128.0f);
}

/* Every wrong bit is detected, in the report and in the CRC; so is every short report. */
static void test_corrupt_reports(void **user)
{
	(void)user;
	stilb_input_layout layout = {.report_count = 1, .reports[0] = {.id = 7, .size = 9, .crc = 5, .source_count = 1}};
	layout.reports[0].sources[0] = axis_byte(STILB_INPUT_LEFT_X, 1);
	uint8_t report[10] = {0xa1, 7, 255, 1, 2, 3};
	uint32_t crc = crc32_bit_by_bit(0, report, 6);
	for (int i = 0; i < 4; i++)
		report[6 + i] = (uint8_t)(crc >> 8 * i);
	stilb_input_pad_state state = {0};
	for (uint32_t bit = 8; bit < 72; bit++) { /* all bits but those of the id */
		report[1 + bit / 8] ^= (uint8_t)(1u << bit % 8);
		assert_int_equal(stilb_input_decode(&layout, report + 1, 9, &state), STILB_INPUT_CORRUPT);
		report[1 + bit / 8] ^= (uint8_t)(1u << bit % 8);
	}
	for (size_t size = 1; size < 9; size++)
		assert_int_equal(stilb_input_decode(&layout, report + 1, size, &state), STILB_INPUT_CORRUPT);
	assert_true(state.axes[STILB_INPUT_LEFT_X] == 0.0f);
	assert_int_equal(stilb_input_decode(&layout, report + 1, 9, &state), STILB_INPUT_DECODED);
	assert_true(state.axes[STILB_INPUT_LEFT_X] == 1.0f);
}

/* ---- made-up descriptors ----------------------------------------------------------------------------------------- */

#define PAGE(page) 0x05, (page)
#define USAGE(usage) 0x09, (usage)
#define USAGES(first, last) 0x19, (first), 0x29, (last)
#define LOGICAL(low, high) 0x15, (low)&0xff, 0x26, (high)&0xff, (high) >> 8 & 0xff
#define SIZE(bits, count) 0x75, (bits), 0x95, (count)
#define ID(id) 0x85, (id)
#define VARIABLE 0x81, 0x02
#define ARRAY 0x81, 0x00
#define PADDING 0x81, 0x01
#define HAT_INPUT 0x81, 0x42
#define PHYSICAL 0xa1, 0x00
#define APPLICATION 0xa1, 0x01
#define END 0xc0
#define GAME_PAD PAGE(1), USAGE(5), APPLICATION
#define JOYSTICK PAGE(1), USAGE(4), APPLICATION
#define X_AND_Y PAGE(1), USAGE(0x30), USAGE(0x31), LOGICAL(0, 255), SIZE(8, 2), VARIABLE
#define BUTTONS(count) PAGE(9), USAGES(1, count), LOGICAL(0, 1), SIZE(1, count), VARIABLE

static stilb_result find_bytes(const uint8_t *bytes, size_t size, stilb_input_layout *layout)
{
	static stilb_input_pad_info info;
	info = (stilb_input_pad_info){.name = "thing", .vendor = 0x1234, .product = 0x5678, .bus = STILB_INPUT_BUS_USB};
	info.descriptor_size = (uint16_t)size;
	if (size > 0)
		memcpy(info.descriptor, bytes, size);
	return stilb_input_layout_find(&info, layout);
}

/* Writes a layout as text, a line for each report: its id:size, then each source as target@bit+bits[low,high], with s
 * in place of + for signed values; the usual range of a single bit is left out. */
static void layout_text(const stilb_input_layout *layout, char *text)
{
	*text = '\0';
	for (uint32_t i = 0; i < layout->report_count; i++) {
		const stilb_input_layout_report *report = &layout->reports[i];
		text += sprintf(text, "%s%x:%u", i > 0 ? "\n" : "", report->id, report->size);
		for (uint32_t k = 0; k < report->source_count; k++) {
			const stilb_input_source *s = &report->sources[k];
			const char *name = s->kind == STILB_INPUT_SOURCE_AXIS     ? stilb_input_axis_names[s->target]
			                   : s->kind == STILB_INPUT_SOURCE_BUTTON ? stilb_input_button_names[s->target]
			                                                          : "hat";
			text += sprintf(text, " %s@%u%s%u", name, s->bit, s->is_signed ? "s" : "+", s->bits);
			if (s->bits > 1 || s->low != (s->kind == STILB_INPUT_SOURCE_BUTTON) || s->high != 1)
				text += sprintf(text, "[%d,%d]", (int)s->low, (int)s->high);
		}
	}
}

static void layout_is(const char *expected, const uint8_t *bytes, size_t size)
{
	static stilb_input_layout layout;
	static char text[8192];
	if (find_bytes(bytes, size, &layout) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	layout_text(&layout, text);
	assert_string_equal(text, expected);
}

#define LAYOUT_IS(expected, ...)                                                                                       \
	layout_is(expected, (const uint8_t[]){__VA_ARGS__}, sizeof((const uint8_t[]){__VA_ARGS__}))

static void refused(const char *why, const uint8_t *bytes, size_t size)
{
	static stilb_input_layout layout;
	assert_int_equal(find_bytes(bytes, size, &layout), STILB_ERROR_ARGUMENT);
	if (!strstr(stilb_error_message(), why) || !strstr(stilb_error_message(), "'thing' (1234:5678)"))
		fail_msg("'%s' instead of '%s'", stilb_error_message(), why);
}

#define REFUSED(why, ...) refused(why, (const uint8_t[]){__VA_ARGS__}, sizeof((const uint8_t[]){__VA_ARGS__}))

static void test_refusals(void **user)
{
	(void)user;
	/* the boot keyboard and the boot mouse of HID 1.11, appendix B */
	REFUSED("Generic Desktop / Keyboard", PAGE(1), USAGE(6), APPLICATION, PAGE(7), USAGES(0xe0, 0xe7), LOGICAL(0, 1),
	        SIZE(1, 8), VARIABLE, SIZE(8, 6), LOGICAL(0, 101), USAGES(0, 101), ARRAY, END);
	REFUSED("Generic Desktop / Mouse", PAGE(1), USAGE(2), APPLICATION, USAGE(1), PHYSICAL, BUTTONS(3), SIZE(5, 1),
	        PADDING, PAGE(1), USAGE(0x30), USAGE(0x31), LOGICAL(0, 127), SIZE(8, 2), 0x81, 0x06, END, END);
	/* a touch pad: X and Y are absolute */
	REFUSED("no stick with buttons", PAGE(0x0d), USAGE(5), APPLICATION, BUTTONS(3), SIZE(5, 1), PADDING, X_AND_Y, END);
	REFUSED("no stick with buttons", GAME_PAD, BUTTONS(8), END);
	REFUSED("no stick with buttons", GAME_PAD, X_AND_Y, END);
	REFUSED("no stick with buttons", GAME_PAD, PAGE(1), USAGE(0x30), USAGE(0x31), LOGICAL(0, 127), SIZE(8, 2), 0x81,
	        0x06, BUTTONS(8), END);
	REFUSED("no stick with buttons", GAME_PAD, PAGE(1), USAGE(0x30), USAGE(0x31), LOGICAL(5, 5), SIZE(8, 2), VARIABLE,
	        BUTTONS(8), END);
	REFUSED("has no fields", GAME_PAD, END);
	refused("it has no report descriptor", NULL, 0);
	refused("byte 6: the item is cut off", (const uint8_t[]){GAME_PAD, X_AND_Y}, 7); /* cut off inside an item */
}

/* ---- sticks and triggers ----------------------------------------------------------------------------------------- */

#define AXES(...) PAGE(1), __VA_ARGS__

static void test_plain_pads(void **user)
{
	(void)user;
	/* without report ids, without a second stick */
	LAYOUT_IS("0:3 left_x@0+8[0,255] left_y@8+8[255,0] west@16+1 south@17+1", GAME_PAD, X_AND_Y, BUTTONS(2), SIZE(6, 1),
	          PADDING, END);
	/* Z and Rz have the range of X and Y, so they are a stick; with signed values */
	LAYOUT_IS("0:5 left_x@0s8[-127,127] left_y@8s8[127,-127] right_x@16s8[-127,127] right_y@24s8[127,-127] west@32+1",
	          JOYSTICK,
	          AXES(USAGE(0x30), USAGE(0x31), USAGE(0x32), USAGE(0x35), LOGICAL(-127, 127), SIZE(8, 4), VARIABLE),
	          BUTTONS(1), SIZE(7, 1), PADDING, END);
	/* Rx and Ry are the right stick if there is no Z and Rz */
	LAYOUT_IS("0:5 left_x@0+8[0,255] left_y@8+8[255,0] right_x@16+8[0,255] right_y@24+8[255,0] west@32+1", GAME_PAD,
	          X_AND_Y, USAGE(0x33), USAGE(0x34), VARIABLE, BUTTONS(1), SIZE(7, 1), PADDING, END);
}

/* The pairs Z, Rz and Rx, Ry both have the range of a stick: only their collections tell which is the right stick. */
static void test_pairs(void **user)
{
	(void)user;
	LAYOUT_IS("0:7 left_x@0+8[0,255] left_y@8+8[255,0] right_x@16+8[0,255] right_y@24+8[255,0] left_trigger@32+8[0,255]"
	          " right_trigger@40+8[0,255] west@48+1",
	          GAME_PAD, X_AND_Y, USAGE(0x32), USAGE(0x35), USAGE(0x33), USAGE(0x34), SIZE(8, 4), VARIABLE, BUTTONS(1),
	          SIZE(7, 1), PADDING, END);
	LAYOUT_IS("0:7 left_x@0+8[0,255] left_y@8+8[255,0] right_x@32+8[0,255] right_y@40+8[255,0] left_trigger@16+8[0,255]"
	          " right_trigger@24+8[0,255] south@48+1",
	          GAME_PAD, USAGE(1), PHYSICAL, X_AND_Y, END, USAGE(0x32), USAGE(0x35), VARIABLE, USAGE(1), PHYSICAL,
	          USAGE(0x33), USAGE(0x34), VARIABLE, END, BUTTONS(1), SIZE(7, 1), PADDING, END);
	/* a pair in the left stick's collection, and two pairs with a collection each, count as if there were none */
	LAYOUT_IS("0:7 left_x@0+8[0,255] left_y@8+8[255,0] right_x@32+8[0,255] right_y@40+8[255,0] left_trigger@16+8[0,255]"
	          " right_trigger@24+8[0,255] west@48+1",
	          GAME_PAD, USAGE(1), PHYSICAL, X_AND_Y, USAGE(0x33), USAGE(0x34), VARIABLE, END, USAGE(0x32), USAGE(0x35),
	          VARIABLE, BUTTONS(1), SIZE(7, 1), PADDING, END);
	LAYOUT_IS("0:7 left_x@0+8[0,255] left_y@8+8[255,0] right_x@16+8[0,255] right_y@24+8[255,0] left_trigger@32+8[0,255]"
	          " right_trigger@40+8[0,255] west@48+1",
	          GAME_PAD, X_AND_Y, USAGE(1), PHYSICAL, USAGE(0x32), USAGE(0x35), VARIABLE, END, USAGE(1), PHYSICAL,
	          USAGE(0x33), USAGE(0x34), VARIABLE, END, BUTTONS(1), SIZE(7, 1), PADDING, END);
	/* brake and accelerator are the triggers rather than the pair of axes that is not a stick */
	LAYOUT_IS("0:9 left_x@0+8[0,255] left_y@8+8[255,0] right_x@16+8[0,255] right_y@24+8[255,0] left_trigger@48+8[0,255]"
	          " right_trigger@56+8[0,255] south@64+1",
	          GAME_PAD, X_AND_Y, USAGE(0x32), USAGE(0x35), USAGE(0x33), USAGE(0x34), SIZE(8, 4), VARIABLE, PAGE(2),
	          USAGE(0xc5), USAGE(0xc4), SIZE(8, 2), VARIABLE, BUTTONS(1), SIZE(7, 1), PADDING, END);
}

/* A pair of axes with another range than the left stick is the triggers of a gamepad; on a joystick it is a throttle or
 * the like and is not read. */
static void test_other_ranges(void **user)
{
	(void)user;
	LAYOUT_IS("0:9 left_x@0+8[0,255] left_y@8+8[255,0] right_x@16+8[0,255] right_y@24+8[255,0]"
	          " left_trigger@32+16[0,1023] right_trigger@48+16[0,1023] south@64+1",
	          GAME_PAD, X_AND_Y, USAGE(0x33), USAGE(0x34), VARIABLE, USAGE(0x32), USAGE(0x35), LOGICAL(0, 1023),
	          SIZE(16, 2), VARIABLE, BUTTONS(1), SIZE(7, 1), PADDING, END);
	LAYOUT_IS("0:7 left_x@0+8[0,255] left_y@8+8[255,0] right_x@16+8[0,255] right_y@24+8[255,0] west@48+1", JOYSTICK,
	          X_AND_Y, USAGE(0x32), USAGE(0x35), USAGE(0x33), USAGE(0x34), SIZE(8, 4), VARIABLE, BUTTONS(1), SIZE(7, 1),
	          PADDING, END);
	LAYOUT_IS(
		"0:7 left_x@0+8[0,255] left_y@8+8[255,0] left_trigger@16+16[0,1023] right_trigger@32+16[0,1023] south@48+1",
		GAME_PAD, X_AND_Y, USAGE(0x32), USAGE(0x35), LOGICAL(0, 1023), SIZE(16, 2), VARIABLE, BUTTONS(1), SIZE(7, 1),
		PADDING, END);
	/* the same range in more bits; the same bits with another minimum */
	LAYOUT_IS("0:7 left_x@0+8[0,255] left_y@8+8[255,0] left_trigger@16+16[0,255] right_trigger@32+16[0,255] south@48+1",
	          GAME_PAD, X_AND_Y, USAGE(0x32), USAGE(0x35), SIZE(16, 2), VARIABLE, BUTTONS(1), SIZE(7, 1), PADDING, END);
	LAYOUT_IS(
		"0:5 left_x@0s8[-127,127] left_y@8s8[127,-127] left_trigger@16+8[0,127] right_trigger@24+8[0,127] south@32+1",
		GAME_PAD, AXES(USAGE(0x30), USAGE(0x31), LOGICAL(-127, 127), SIZE(8, 2), VARIABLE), USAGE(0x32), USAGE(0x35),
		LOGICAL(0, 127), VARIABLE, BUTTONS(1), SIZE(7, 1), PADDING, END);
	/* signed: they do not rest at their lowest value */
	LAYOUT_IS("0:7 left_x@0s8[-127,127] left_y@8s8[127,-127] right_x@16s8[-127,127] right_y@24s8[127,-127] west@48+1",
	          GAME_PAD,
	          AXES(USAGE(0x30), USAGE(0x31), USAGE(0x32), USAGE(0x35), USAGE(0x33), USAGE(0x34), LOGICAL(-127, 127),
	               SIZE(8, 6), VARIABLE),
	          BUTTONS(1), SIZE(7, 1), PADDING, END);
	/* a joystick that turns: by Rz, by a rudder */
	LAYOUT_IS("0:4 left_x@0+8[0,255] left_y@8+8[255,0] right_x@16+8[0,63] west@24+1", JOYSTICK, X_AND_Y, USAGE(0x35),
	          LOGICAL(0, 63), SIZE(8, 1), VARIABLE, BUTTONS(1), SIZE(7, 1), PADDING, END);
	LAYOUT_IS("0:4 left_x@0+8[0,255] left_y@8+8[255,0] right_x@16+8[0,255] west@24+1", JOYSTICK, X_AND_Y, PAGE(2),
	          USAGE(0xba), SIZE(8, 1), VARIABLE, BUTTONS(1), SIZE(7, 1), PADDING, END);
}

/* ---- hats -------------------------------------------------------------------------------------------------------- */

#define ONE_HAT(expected, low, high)                                                                                   \
	LAYOUT_IS("0:4 left_x@0+8[0,255] left_y@8+8[255,0] hat@16+8" expected " west@24+1", GAME_PAD, X_AND_Y,             \
	          USAGE(0x39), LOGICAL(low, high), SIZE(8, 1), HAT_INPUT, BUTTONS(1), SIZE(7, 1), PADDING, END)

static void test_hat_ranges(void **user)
{
	(void)user;
	ONE_HAT("[0,7]", 0, 7);
	ONE_HAT("[1,8]", 1, 8);
	ONE_HAT("[0,3]", 0, 3);
	ONE_HAT("[0,7]", 0, 8);  /* the descriptor declares 0..8: 8 is the hat at rest, no direction */
	ONE_HAT("[0,7]", 0, 15); /* it declares all values of four bits: 8..15 are no directions */
	ONE_HAT("[0,359]", 0, 359);
	LAYOUT_IS("0:3 left_x@0+8[0,255] left_y@8+8[255,0] up@16+1 down@17+1 left@19+1 right@18+1 west@20+1 south@21+1"
	          " east@22+1 north@23+1",
	          GAME_PAD, X_AND_Y, USAGES(0x90, 0x93), LOGICAL(0, 1), SIZE(1, 4), VARIABLE, BUTTONS(4), END);
}

/* ---- buttons ----------------------------------------------------------------------------------------------------- */

static void test_orders(void **user)
{
	(void)user;
	LAYOUT_IS("0:4 left_x@0+8[0,255] left_y@8+8[255,0] west@16+1 south@17+1 east@18+1 north@19+1 left_shoulder@20+1"
	          " right_shoulder@21+1 left_trigger@22+1 right_trigger@23+1 back@24+1 start@25+1 left_stick@26+1"
	          " right_stick@27+1 guide@28+1 extra@29+1",
	          GAME_PAD, X_AND_Y, BUTTONS(16), END);
	LAYOUT_IS("0:6 left_x@0+8[0,255] left_y@8+8[255,0] left_trigger@16+8[0,255] right_trigger@24+8[0,255] south@32+1"
	          " east@33+1 west@35+1 north@36+1 left_shoulder@38+1 right_shoulder@39+1 back@42+1 start@43+1 guide@44+1"
	          " left_stick@45+1 right_stick@46+1",
	          GAME_PAD, X_AND_Y, PAGE(2), USAGE(0xc5), USAGE(0xc4), VARIABLE, BUTTONS(16), END);
	LAYOUT_IS("0:6 left_x@0+8[0,255] left_y@8+8[255,0] left_trigger@16+8[0,255] right_trigger@24+8[0,255] south@32+1"
	          " east@33+1 west@34+1 north@35+1 left_shoulder@36+1 right_shoulder@37+1 back@38+1 start@39+1"
	          " left_stick@40+1 right_stick@41+1 guide@42+1 extra@43+1",
	          GAME_PAD, X_AND_Y, PAGE(2), USAGE(0xc5), USAGE(0xc4), VARIABLE, BUTTONS(12), SIZE(4, 1), PADDING, END);
}

static void test_odd_buttons(void **user)
{
	(void)user;
	/* buttons with pressure */
	LAYOUT_IS("0:4 left_x@0+8[0,255] left_y@8+8[255,0] west@16+8[128,255] south@24+8[128,255]", GAME_PAD, X_AND_Y,
	          PAGE(9), USAGES(1, 2), SIZE(8, 2), VARIABLE, END);
	/* a bit whose range is a byte's */
	LAYOUT_IS("0:3 left_x@0+8[0,255] left_y@8+8[255,0] west@16+1", GAME_PAD, X_AND_Y, PAGE(9), USAGE(1), SIZE(1, 1),
	          VARIABLE, SIZE(7, 1), PADDING, END);
	LAYOUT_IS("0:3 left_x@0s8[-127,127] left_y@8s8[127,-127] west@16+1", GAME_PAD,
	          AXES(USAGE(0x30), USAGE(0x31), LOGICAL(-127, 127), SIZE(8, 2), VARIABLE), PAGE(9), USAGE(1), SIZE(1, 1),
	          VARIABLE, SIZE(7, 1), PADDING, END);
	/* 0 is not a button's number; a field of two bits has two buttons, however many usages it names */
	LAYOUT_IS("0:3 left_x@0+8[0,255] left_y@8+8[255,0] west@17+1 south@18+1", GAME_PAD, X_AND_Y, PAGE(9), USAGES(0, 2),
	          LOGICAL(0, 1), SIZE(1, 3), VARIABLE, SIZE(5, 1), PADDING, END);
	LAYOUT_IS("0:3 left_x@0+8[0,255] left_y@8+8[255,0] west@16+1 south@17+1", GAME_PAD, X_AND_Y, PAGE(9), USAGES(1, 8),
	          LOGICAL(0, 1), SIZE(1, 2), VARIABLE, SIZE(6, 1), PADDING, END);
	/* an array: each element's value names the button that is down, 0 none; a trigger among them is left out */
	LAYOUT_IS("0:3 left_x@0+8[0,255] left_y@8+8[255,0] west@16+4[1,1] west@20+4[1,1] south@16+4[2,2] south@20+4[2,2]",
	          GAME_PAD, X_AND_Y, PAGE(9), USAGES(1, 2), LOGICAL(1, 2), SIZE(4, 2), ARRAY, END);
	LAYOUT_IS("0:3 left_x@0+8[0,255] left_y@8+8[255,0] right_shoulder@16+8[1,1] back@16+8[4,4]", GAME_PAD, X_AND_Y,
	          PAGE(9), USAGES(6, 9), LOGICAL(1, 4), SIZE(8, 1), ARRAY, END);
	LAYOUT_IS("0:3 left_x@0+8[0,255] left_y@8+8[255,0] west@16+8[1,1] south@16+8[2,2]", GAME_PAD, X_AND_Y, PAGE(9),
	          USAGES(1, 4), LOGICAL(1, 2), SIZE(8, 1), ARRAY, END);
	LAYOUT_IS("0:3 left_x@0+8[0,255] left_y@8+8[255,0] right_shoulder@16+8[1,1] south@16+8[2,2]", GAME_PAD, X_AND_Y,
	          PAGE(9), USAGE(6), USAGE(2), LOGICAL(1, 2), SIZE(8, 1), ARRAY, END);
	/* directions in an array are not read; no known pad has them */
	LAYOUT_IS("0:4 left_x@0+8[0,255] left_y@8+8[255,0] west@16+1", GAME_PAD, X_AND_Y, BUTTONS(1), SIZE(7, 1), PADDING,
	          PAGE(1), USAGES(0x90, 0x93), LOGICAL(1, 4), SIZE(8, 1), ARRAY, END);
	/* usages of system and consumer controls, in a report of their own */
	LAYOUT_IS("1:4 left_x@8+8[0,255] left_y@16+8[255,0] start@25+1 west@24+1\n2:2 guide@8+1", GAME_PAD, ID(1), X_AND_Y,
	          BUTTONS(1), PAGE(1), USAGE(0x3d), SIZE(1, 1), VARIABLE, SIZE(6, 1), PADDING, ID(2), USAGE(0x85),
	          SIZE(1, 1), VARIABLE, SIZE(7, 1), PADDING, END);
	/* bits that all share the last usage are not buttons of their own */
	LAYOUT_IS("0:3 left_x@0+8[0,255] left_y@8+8[255,0] west@16+1 south@17+1", GAME_PAD, X_AND_Y, PAGE(9), USAGES(1, 2),
	          LOGICAL(0, 1), SIZE(1, 8), VARIABLE, END);
}

/* Of an adaptor for two pads only the first pad is read; else the second one would press the first one's buttons. */
static void test_two_pads_in_one(void **user)
{
	(void)user;
	LAYOUT_IS("1:4 left_x@8+8[0,255] left_y@16+8[255,0] west@24+1 south@25+1", JOYSTICK, ID(1), X_AND_Y, BUTTONS(2),
	          SIZE(6, 1), PADDING, END, JOYSTICK, ID(2), X_AND_Y, BUTTONS(2), SIZE(6, 1), PADDING, END);
	LAYOUT_IS("1:4 left_x@8+8[0,255] left_y@16+8[255,0] west@24+1", JOYSTICK, ID(1), X_AND_Y, BUTTONS(1), SIZE(7, 1),
	          PADDING, END, JOYSTICK, ID(2), PAGE(1), USAGES(0x90, 0x93), LOGICAL(0, 1), SIZE(1, 4), VARIABLE,
	          SIZE(4, 1), PADDING, END);
	/* a keyboard before the pad does not hide it */
	LAYOUT_IS("2:4 left_x@8+8[0,255] left_y@16+8[255,0] west@24+1 south@25+1", PAGE(1), USAGE(6), APPLICATION, ID(1),
	          PAGE(7), USAGES(0xe0, 0xe7), LOGICAL(0, 1), SIZE(1, 8), VARIABLE, END, GAME_PAD, ID(2), X_AND_Y,
	          BUTTONS(2), SIZE(6, 1), PADDING, END);
}

#define ONE_AXIS(usage) PAGE(1), USAGE(usage), LOGICAL(0, 255), SIZE(8, 1), VARIABLE

/* A report with X or Y alone (a wheel, a pedal) is no stick: the pad is in the report that has both. */
static void test_half_a_stick(void **user)
{
	(void)user;
	LAYOUT_IS("3:4 left_x@8+8[0,255] left_y@16+8[255,0] west@24+1 south@25+1", GAME_PAD, ID(1), ONE_AXIS(0x30),
	          BUTTONS(8), ID(2), ONE_AXIS(0x31), BUTTONS(8), ID(3), X_AND_Y, BUTTONS(2), SIZE(6, 1), PADDING, END);
	REFUSED("no stick with buttons", GAME_PAD, ONE_AXIS(0x30), BUTTONS(8), END);
	REFUSED("no stick with buttons", GAME_PAD, ONE_AXIS(0x31), BUTTONS(8), END);
}

/* Of more sources than a layout holds, the first ones are kept. */
static void test_too_many_sources(void **user)
{
	(void)user;
	static stilb_input_layout layout;
	static const uint8_t bytes[] = {GAME_PAD, X_AND_Y, PAGE(9), USAGES(1, 14), LOGICAL(1, 14), SIZE(4, 8), ARRAY, END};
	assert_int_equal(find_bytes(bytes, sizeof bytes, &layout), STILB_OK);
	assert_int_equal(layout.reports[0].source_count, STILB_INPUT_SOURCES_MAX);
	uint8_t report[6] = {128, 128, 0, 0, 0, 0x20};
	stilb_input_pad_state state = {0};
	assert_int_equal(stilb_input_decode(&layout, report, sizeof report, &state), STILB_INPUT_DECODED);
	assert_int_equal(state.buttons, 1u << STILB_INPUT_SOUTH);
	static const uint8_t reports[] = {
		GAME_PAD, ID(1), X_AND_Y,  BUTTONS(8), PAGE(0x0c), LOGICAL(0, 1), SIZE(8, 1),  ID(2),    0x0a,
		0x23,     0x02,  VARIABLE, ID(3),      0x0a,       0x24,          0x02,        VARIABLE, ID(4),
		0x0a,     0xb2,  0x00,     VARIABLE,   PAGE(1),    ID(5),         USAGE(0x85), VARIABLE, END};
	assert_int_equal(find_bytes(reports, sizeof reports, &layout), STILB_OK);
	assert_int_equal(layout.report_count, STILB_INPUT_LAYOUT_REPORTS_MAX);
}

/* Only an output report like an Xbox pad's makes a pad rumble like one. */
static void test_xbox_rumble(void **user)
{
	(void)user;
#define MAGNITUDES(id, before, most)                                                                                   \
	GAME_PAD, ID(1), X_AND_Y, BUTTONS(8), ID(id), PAGE(0x0f), SIZE(before, 1), 0x91, 0x01, USAGE(0x70),                \
		LOGICAL(0, most), SIZE(8, 4), 0x91, 0x02, SIZE(8, 3), 0x91, 0x01, END
	static stilb_input_layout layout;
	static const uint8_t right[] = {MAGNITUDES(3, 8, 100)}, wrong[3][sizeof right] = {{MAGNITUDES(4, 8, 100)},
	                                                                                  {MAGNITUDES(3, 16, 100)},
	                                                                                  {MAGNITUDES(3, 8, 255)}};
	assert_int_equal(find_bytes(right, sizeof right, &layout), STILB_OK);
	assert_int_equal(layout.rumble, STILB_INPUT_RUMBLE_XBOX_BLUETOOTH);
	for (int i = 0; i < 3; i++) {
		assert_int_equal(find_bytes(wrong[i], sizeof wrong[i], &layout), STILB_OK);
		assert_int_equal(layout.rumble, STILB_INPUT_RUMBLE_NONE);
	}
}

/* ---- descriptors of real pads ------------------------------------------------------------------------------------ */

static void find_as_unknown(const input_test_descriptor *descriptor, stilb_input_layout *layout)
{
	if (find_bytes(descriptor->bytes, descriptor->size, layout) != STILB_OK)
		fail_msg("%s: %s", descriptor->name, stilb_error_message());
	assert_false(layout->known);
	assert_string_equal(layout->name, "thing, USB");
}

/* Each known pad is also recognised by its descriptor alone, with stick and buttons at the right bits. */
static void test_every_descriptor(void **user)
{
	(void)user;
	static stilb_input_layout layout;
	for (size_t i = 0; i < input_test_descriptor_count; i++) {
		find_as_unknown(&input_test_descriptors[i], &layout);
		assert_true(layout.report_count >= 1 && layout.reports[0].source_count >= 14);
		for (uint32_t r = 0; r < layout.report_count; r++)
			for (uint32_t k = 0; k < layout.reports[r].source_count; k++) {
				const stilb_input_source *s = &layout.reports[r].sources[k];
				assert_true(s->bits >= 1 && s->bits <= 32 && s->bit + s->bits <= 8u * layout.reports[r].size);
			}
	}
	const input_test_descriptor *saitek = input_test_descriptor_find(3, 0x06a3, 0xff0d);
	layout_is(
		"1:7 left_x@8+8[0,255] left_y@16+8[255,0] right_x@24+8[0,255] hat@52+4[0,7] west@40+1 south@41+1 east@42+1"
		" north@43+1 left_shoulder@44+1 right_shoulder@45+1 left_trigger@46+1 right_trigger@47+1 back@48+1 start@49+1"
		" left_stick@50+1 right_stick@51+1",
		saitek->bytes, saitek->size);
}

/* The driver xpadneo (hid-xpadneo.c, xpadneo_report_fixup) calls the axes of newer Xbox pads as the first firmware did,
 * sorts the buttons, and gives the pad the number of another. */
static void test_a_driver_that_rewrites(void **user)
{
	(void)user;
	static const uint8_t changes[][3] = {{35, 0x32, 0x33},  {37, 0x35, 0x34},  {53, 0x02, 0x01},
	                                     {55, 0xc5, 0x32},  {78, 0x02, 0x01},  {80, 0xc4, 0x35},
	                                     {145, 0x0f, 0x0c}, {153, 0x0f, 0x0c}, {163, 0x01, 0x04}};
	const input_test_descriptor *xbox = input_test_descriptor_find(5, 0x045e, 0x0b13);
	uint8_t bytes[283];
	assert_int_equal(xbox->size, sizeof bytes);
	memcpy(bytes, xbox->bytes, sizeof bytes);
	for (size_t i = 0; i < sizeof changes / sizeof *changes; i++) {
		assert_int_equal(bytes[changes[i][0]], changes[i][1]);
		bytes[changes[i][0]] = changes[i][2];
	}
	layout_is(
		"1:17 left_x@8+16[0,65535] left_y@24+16[65535,0] right_x@40+16[0,65535] right_y@56+16[65535,0]"
		" left_trigger@72+10[0,1023] right_trigger@88+10[0,1023] hat@104+4[1,8] extra@128+1 south@112+1 east@113+1"
		" west@114+1 north@115+1 left_shoulder@116+1 right_shoulder@117+1 back@118+1 start@119+1 left_stick@120+1"
		" right_stick@121+1 guide@122+1 extra@123+1",
		bytes, sizeof bytes);
}

/* A descriptor from a file comes without a name. */
static void test_nameless(void **user)
{
	(void)user;
	static stilb_input_layout layout;
	static stilb_input_pad_info info;
	const input_test_descriptor *asus = input_test_descriptor_find(3, 0x18d1, 0x2c40);
	memcpy(info.descriptor, asus->bytes, asus->size);
	info.descriptor_size = (uint16_t)asus->size;
	assert_int_equal(stilb_input_layout_find(&info, &layout), STILB_OK);
	assert_string_equal(layout.name, "gamepad");
	info.descriptor_size = 0;
	assert_int_equal(stilb_input_layout_find(&info, &layout), STILB_ERROR_ARGUMENT);
	assert_string_equal(stilb_error_message(),
	                    "'this device' (0000:0000) is not a gamepad: it has no report descriptor");
}

/* For these pads descriptor and table agree: any report decodes to the same state by both. */
static void test_fields_agree_with_the_table(void **user)
{
	(void)user;
	static const struct {
		uint16_t bus, vendor, product;
		uint8_t id;
		size_t size;
	} cases[] = {{3, 0x054c, 0x05c4, 0x01, 64},
	             {5, 0x054c, 0x05c4, 0x01, 10},
	             {3, 0x054c, 0x0ce6, 0x01, 64},
	             {5, 0x054c, 0x0ce6, 0x01, 10}};
	static stilb_input_layout by_table, by_fields;
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		const input_test_descriptor *d = input_test_descriptor_find(cases[i].bus, cases[i].vendor, cases[i].product);
		stilb_input_pad_info info = {.bus = cases[i].bus, .vendor = cases[i].vendor, .product = cases[i].product};
		assert_int_equal(stilb_input_layout_find(&info, &by_table), STILB_OK);
		assert_true(by_table.known);
		find_as_unknown(d, &by_fields);
		stilb_input_pad_state a = {0}, b = {0};
		for (uint64_t n = 0; n < 1000; n++) {
			uint8_t report[64] = {cases[i].id};
			for (size_t k = 1; k < cases[i].size; k++)
				report[k] = (uint8_t)stilb_random_u64(n, k);
			assert_int_equal(stilb_input_decode(&by_table, report, cases[i].size, &a), STILB_INPUT_DECODED);
			assert_int_equal(stilb_input_decode(&by_fields, report, cases[i].size, &b), STILB_INPUT_DECODED);
			assert_memory_equal(&a, &b, sizeof a);
		}
	}
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(test_crc),
		cmocka_unit_test(test_names),
		cmocka_unit_test(test_axes),
		cmocka_unit_test(test_axes_rise),
		cmocka_unit_test(test_hats),
		cmocka_unit_test(test_buttons_of_several_sources),
		cmocka_unit_test(test_short_reports),
		cmocka_unit_test(test_corrupt_reports),
		cmocka_unit_test(test_refusals),
		cmocka_unit_test(test_plain_pads),
		cmocka_unit_test(test_pairs),
		cmocka_unit_test(test_other_ranges),
		cmocka_unit_test(test_hat_ranges),
		cmocka_unit_test(test_orders),
		cmocka_unit_test(test_odd_buttons),
		cmocka_unit_test(test_two_pads_in_one),
		cmocka_unit_test(test_half_a_stick),
		cmocka_unit_test(test_too_many_sources),
		cmocka_unit_test(test_xbox_rumble),
		cmocka_unit_test(test_every_descriptor),
		cmocka_unit_test(test_a_driver_that_rewrites),
		cmocka_unit_test(test_nameless),
		cmocka_unit_test(test_fields_agree_with_the_table),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
