/* The table of known pads. A row is needed for a pad whose descriptor does not say what its bits mean, or that
 * input_layout_fields.c reads wrongly. docs/input.md tells how to add one.
 *
 * Sources of the layouts: Linux, drivers/hid/hid-playstation.c (DualShock 4, DualSense), hid-sony.c (DualShock 3) and
 * hid-nintendo.c (Switch Pro); SDL, src/joystick/hidapi. Sources of the product numbers: drivers/hid/hid-ids.h,
 * xpadneo. */
#include "input/hid/input_layout_internal.h"

/* ---- sources ----------------------------------------------------------------------------------------------------- */

/* Sources of a report. AXIS: `first` is its first bit, `from` and `to` its values at the ends of the range. In the
 * other macros `at` is a byte of the report, of which byte 0 is the report's id. */
#define AXIS(axis, first, size, from, to)                                                                              \
	{                                                                                                                  \
		.kind = STILB_INPUT_SOURCE_AXIS, .target = STILB_INPUT_##axis, .bit = (first), .bits = (size), .low = (from),  \
		.high = (to)                                                                                                   \
	}
#define BUTTON(at, number, button)                                                                                     \
	{                                                                                                                  \
		.kind = STILB_INPUT_SOURCE_BUTTON, .target = STILB_INPUT_##button, .bit = 8 * (at) + (number), .bits = 1,      \
		.low = 1, .high = 1                                                                                            \
	}
#define HAT(at)                                                                                                        \
	{                                                                                                                  \
		.kind = STILB_INPUT_SOURCE_HAT, .bit = 8 * (at), .bits = 4, .low = 0, .high = 7                                \
	}

/* Four bytes: left x, left y, right x, right y; 0 is left and up. */
#define STICKS(at)                                                                                                     \
	AXIS(LEFT_X, 8 * (at), 8, 0, 255), AXIS(LEFT_Y, 8 * (at) + 8, 8, 255, 0), AXIS(RIGHT_X, 8 * (at) + 16, 8, 0, 255), \
		AXIS(RIGHT_Y, 8 * (at) + 24, 8, 255, 0)
#define TRIGGERS(at) AXIS(LEFT_TRIGGER, 8 * (at), 8, 0, 255), AXIS(RIGHT_TRIGGER, 8 * (at) + 8, 8, 0, 255)

/* Three bytes with the d-pad and all buttons, the same on DualShock 4 and DualSense. */
#define PLAYSTATION_BUTTONS(at)                                                                                        \
	HAT(at), BUTTON(at, 4, WEST), BUTTON(at, 5, SOUTH), BUTTON(at, 6, EAST), BUTTON(at, 7, NORTH),                     \
		BUTTON((at) + 1, 0, LEFT_SHOULDER), BUTTON((at) + 1, 1, RIGHT_SHOULDER), BUTTON((at) + 1, 4, BACK),            \
		BUTTON((at) + 1, 5, START), BUTTON((at) + 1, 6, LEFT_STICK), BUTTON((at) + 1, 7, RIGHT_STICK),                 \
		BUTTON((at) + 2, 0, GUIDE), BUTTON((at) + 2, 1, EXTRA)

/* ---- DualShock 4, DualSense -------------------------------------------------------------------------------------- */

/* The short report that both send over Bluetooth until a feature report is read; its triggers are at the bytes of a
 * DualShock 4. */
#define PLAYSTATION_SHORT                                                                                              \
	{                                                                                                                  \
		.id = 0x01, .size = 10, .sources = { STICKS(1), PLAYSTATION_BUTTONS(5), TRIGGERS(8) }                          \
	}

static const stilb_input_layout_report ds4_usb[] = {
	{.id = 0x01, .size = 64, .sources = {STICKS(1), PLAYSTATION_BUTTONS(5), TRIGGERS(8)}},
	{.size = 0},
};

/* The wireless adaptor goes on reporting while its pad is off; then bit 2 of byte 31 is set. */
static const stilb_input_layout_report ds4_adaptor[] = {
	{.id = 0x01, .size = 64, .absent = 8 * 31 + 2, .sources = {STICKS(1), PLAYSTATION_BUTTONS(5), TRIGGERS(8)}},
	{.size = 0},
};

static const stilb_input_layout_report ds4_bluetooth[] = {
	{.id = 0x11, .size = 78, .crc = 74, .sources = {STICKS(3), PLAYSTATION_BUTTONS(7), TRIGGERS(10)}},
	PLAYSTATION_SHORT,
	{.size = 0},
};

static const stilb_input_layout_report dualsense_usb[] = {
	{.id = 0x01, .size = 64, .sources = {STICKS(1), TRIGGERS(5), PLAYSTATION_BUTTONS(8)}},
	{.size = 0},
};

static const stilb_input_layout_report dualsense_bluetooth[] = {
	{.id = 0x31, .size = 78, .crc = 74, .sources = {STICKS(2), TRIGGERS(6), PLAYSTATION_BUTTONS(9)}},
	PLAYSTATION_SHORT,
	{.size = 0},
};

/* Reading the calibration of the motion sensors makes the pad send its long reports. */
static const stilb_input_hello playstation_hello[] = {
	{.kind = STILB_INPUT_HELLO_GET_FEATURE, .size = 41, .bytes = {0x05}},
	{.kind = STILB_INPUT_HELLO_END},
};

/* ---- DualShock 3 ------------------------------------------------------------------------------------------------- */

static const stilb_input_layout_report ds3_usb[] = {
	{
		.id = 0x01,
		.size = 49,
		.sources =
			{
				BUTTON(2, 0, BACK),
				BUTTON(2, 1, LEFT_STICK),
				BUTTON(2, 2, RIGHT_STICK),
				BUTTON(2, 3, START),
				BUTTON(2, 4, UP),
				BUTTON(2, 5, RIGHT),
				BUTTON(2, 6, DOWN),
				BUTTON(2, 7, LEFT),
				BUTTON(3, 2, LEFT_SHOULDER),
				BUTTON(3, 3, RIGHT_SHOULDER),
				BUTTON(3, 4, NORTH),
				BUTTON(3, 5, EAST),
				BUTTON(3, 6, SOUTH),
				BUTTON(3, 7, WEST),
				BUTTON(4, 0, GUIDE),
				STICKS(6),
				TRIGGERS(18),
			},
	},
	{.size = 0},
};

/* Over USB the pad sends no reports before these two feature reports were read. */
static const stilb_input_hello ds3_hello[] = {
	{.kind = STILB_INPUT_HELLO_GET_FEATURE, .size = 17, .bytes = {0xf2}},
	{.kind = STILB_INPUT_HELLO_GET_FEATURE, .size = 8, .bytes = {0xf5}},
	{.kind = STILB_INPUT_HELLO_END},
};

/* ---- Switch Pro -------------------------------------------------------------------------------------------------- */

/* The range of a stick that hid-nintendo uses if the pad's calibration cannot be read; up is the larger value. */
#define SWITCH_STICK(bit, axis) AXIS(axis, bit, 12, 500, 3500)

/* A trigger that is a button: its axis is 0 or 1. */
#define SWITCH_TRIGGER(at, number, axis) AXIS(axis, 8 * (at) + (number), 1, 0, 1)

#define SWITCH_FULL                                                                                                    \
	BUTTON(3, 0, WEST), BUTTON(3, 1, NORTH), BUTTON(3, 2, SOUTH), BUTTON(3, 3, EAST), BUTTON(3, 6, RIGHT_SHOULDER),    \
		SWITCH_TRIGGER(3, 7, RIGHT_TRIGGER), BUTTON(4, 0, BACK), BUTTON(4, 1, START), BUTTON(4, 2, RIGHT_STICK),       \
		BUTTON(4, 3, LEFT_STICK), BUTTON(4, 4, GUIDE), BUTTON(4, 5, EXTRA), BUTTON(5, 0, DOWN), BUTTON(5, 1, UP),      \
		BUTTON(5, 2, RIGHT), BUTTON(5, 3, LEFT), BUTTON(5, 6, LEFT_SHOULDER), SWITCH_TRIGGER(5, 7, LEFT_TRIGGER),      \
		SWITCH_STICK(48, LEFT_X), SWITCH_STICK(60, LEFT_Y), SWITCH_STICK(72, RIGHT_X), SWITCH_STICK(84, RIGHT_Y)

static const stilb_input_layout_report switch_pro[] = {
	{.id = 0x30, .size = 49, .sources = {SWITCH_FULL}},
	{.id = 0x21, .size = 49, .sources = {SWITCH_FULL}}, /* the answer to a subcommand, which begins with the state */
	{
		.id = 0x3f, /* the simple report that it sends over Bluetooth until full ones are requested */
		.size = 12,
		.sources =
			{
				BUTTON(1, 0, SOUTH),
				BUTTON(1, 1, EAST),
				BUTTON(1, 2, WEST),
				BUTTON(1, 3, NORTH),
				BUTTON(1, 4, LEFT_SHOULDER),
				BUTTON(1, 5, RIGHT_SHOULDER),
				SWITCH_TRIGGER(1, 6, LEFT_TRIGGER),
				SWITCH_TRIGGER(1, 7, RIGHT_TRIGGER),
				BUTTON(2, 0, BACK),
				BUTTON(2, 1, START),
				BUTTON(2, 2, LEFT_STICK),
				BUTTON(2, 3, RIGHT_STICK),
				BUTTON(2, 4, GUIDE),
				BUTTON(2, 5, EXTRA),
				HAT(3),
				AXIS(LEFT_X, 32, 16, 0, 65535),
				AXIS(LEFT_Y, 48, 16, 65535, 0),
				AXIS(RIGHT_X, 64, 16, 0, 65535),
				AXIS(RIGHT_Y, 80, 16, 65535, 0),
			},
	},
	{.size = 0},
};

/* Over USB four commands: handshake, 3 Mbit/s, handshake, no timeout. Then two subcommands: full reports, motors on; a
 * subcommand follows the packet's number and eight bytes of motor data, here at rest. The pad answers within some 30
 * ms. */
#define SWITCH_COMMAND(command)                                                                                        \
	{                                                                                                                  \
		.kind = STILB_INPUT_HELLO_WRITE, .size = 2, .pause_ms = 30, .bytes = { 0x80, (command) }                       \
	}
#define SWITCH_SUBCOMMAND(number, subcommand, argument)                                                                \
	{                                                                                                                  \
		.kind = STILB_INPUT_HELLO_WRITE, .size = 12, .pause_ms = 30, .bytes = {                                        \
			0x01,                                                                                                      \
			(number),                                                                                                  \
			0x00,                                                                                                      \
			0x01,                                                                                                      \
			0x40,                                                                                                      \
			0x40,                                                                                                      \
			0x00,                                                                                                      \
			0x01,                                                                                                      \
			0x40,                                                                                                      \
			0x40,                                                                                                      \
			(subcommand),                                                                                              \
			(argument)                                                                                                 \
		}                                                                                                              \
	}

static const stilb_input_hello switch_usb_hello[] = {
	SWITCH_COMMAND(0x02),
	SWITCH_COMMAND(0x03),
	SWITCH_COMMAND(0x02),
	SWITCH_COMMAND(0x04),
	SWITCH_SUBCOMMAND(0, 0x03, 0x30),
	SWITCH_SUBCOMMAND(1, 0x48, 0x01),
	{.kind = STILB_INPUT_HELLO_END},
};

static const stilb_input_hello switch_bluetooth_hello[] = {
	SWITCH_SUBCOMMAND(0, 0x03, 0x30),
	SWITCH_SUBCOMMAND(1, 0x48, 0x01),
	{.kind = STILB_INPUT_HELLO_END},
};

/* ---- orders of buttons ------------------------------------------------------------------------------------------- */

/* Triangle, circle, cross, square: the order of adaptors for PlayStation 2 pads and of pads built like them. Source:
 * the mapping of 0079:0006 in SDL_GameControllerDB. */
static const input_button_order from_the_top = {
	"counted from the top one",
	12,
	{STILB_INPUT_NORTH, STILB_INPUT_EAST, STILB_INPUT_SOUTH, STILB_INPUT_WEST, STILB_INPUT_LEFT_SHOULDER,
     STILB_INPUT_RIGHT_SHOULDER, INPUT_BUTTON_LEFT_TRIGGER, INPUT_BUTTON_RIGHT_TRIGGER, STILB_INPUT_BACK,
     STILB_INPUT_START, STILB_INPUT_LEFT_STICK, STILB_INPUT_RIGHT_STICK},
};

/* ---- the table --------------------------------------------------------------------------------------------------- */

#define SONY 0x054c
#define MICROSOFT 0x045e
#define NINTENDO 0x057e
#define DRAGONRISE 0x0079

static const input_known known[] = {
	{
		.name = "DualShock 4",
		.bus = STILB_INPUT_BUS_USB,
		.vendor = SONY,
		.products = {0x05c4, 0x09cc},
		.reports = ds4_usb,
		.rumble = STILB_INPUT_RUMBLE_DS4_USB,
	},
	{
		.name = "DualShock 4 wireless adaptor",
		.bus = STILB_INPUT_BUS_USB,
		.vendor = SONY,
		.products = {0x0ba0},
		.reports = ds4_adaptor,
		.rumble = STILB_INPUT_RUMBLE_DS4_USB,
	},
	{
		.name = "DualShock 4",
		.bus = STILB_INPUT_BUS_BLUETOOTH,
		.vendor = SONY,
		.products = {0x05c4, 0x09cc},
		.reports = ds4_bluetooth,
		.rumble = STILB_INPUT_RUMBLE_DS4_BLUETOOTH,
		.hello = playstation_hello,
	},
	{
		.name = "DualSense",
		.bus = STILB_INPUT_BUS_USB,
		.vendor = SONY,
		.products = {0x0ce6},
		.reports = dualsense_usb,
		.rumble = STILB_INPUT_RUMBLE_DUALSENSE_USB,
	},
	{
		.name = "DualSense",
		.bus = STILB_INPUT_BUS_BLUETOOTH,
		.vendor = SONY,
		.products = {0x0ce6},
		.reports = dualsense_bluetooth,
		.rumble = STILB_INPUT_RUMBLE_DUALSENSE_BLUETOOTH,
		.hello = playstation_hello,
	},
	{
		.name = "DualSense Edge",
		.bus = STILB_INPUT_BUS_USB,
		.vendor = SONY,
		.products = {0x0df2},
		.reports = dualsense_usb,
		.rumble = STILB_INPUT_RUMBLE_DUALSENSE_USB,
	},
	{
		.name = "DualSense Edge",
		.bus = STILB_INPUT_BUS_BLUETOOTH,
		.vendor = SONY,
		.products = {0x0df2},
		.reports = dualsense_bluetooth,
		.rumble = STILB_INPUT_RUMBLE_DUALSENSE_BLUETOOTH,
		.hello = playstation_hello,
	},
	{
		.name = "DualShock 3",
		.bus = STILB_INPUT_BUS_USB,
		.vendor = SONY,
		.products = {0x0268},
		.reports = ds3_usb,
		.hello = ds3_hello,
	},
	{
		.name = "Switch Pro Controller",
		.bus = STILB_INPUT_BUS_USB,
		.vendor = NINTENDO,
		.products = {0x2009},
		.reports = switch_pro,
		.rumble = STILB_INPUT_RUMBLE_SWITCH,
		.hello = switch_usb_hello,
	},
	{
		.name = "Switch Pro Controller",
		.bus = STILB_INPUT_BUS_BLUETOOTH,
		.vendor = NINTENDO,
		.products = {0x2009},
		.reports = switch_pro,
		.rumble = STILB_INPUT_RUMBLE_SWITCH,
		.hello = switch_bluetooth_hello,
	},
	/* Firmware updates change the reports without changing the product number, so the row gives no reports: they are
	 * found by the descriptor's fields. */
	{
		.name = "Xbox One S Controller",
		.bus = STILB_INPUT_BUS_BLUETOOTH,
		.vendor = MICROSOFT,
		.products = {0x02e0, 0x02fd, 0x0b20},
	},
	{
		.name = "Xbox Elite Controller 2",
		.bus = STILB_INPUT_BUS_BLUETOOTH,
		.vendor = MICROSOFT,
		.products = {0x0b05, 0x0b22},
	},
	{
		.name = "Xbox Series Controller",
		.bus = STILB_INPUT_BUS_BLUETOOTH,
		.vendor = MICROSOFT,
		.products = {0x0b13},
	},
	{
		.name = "Xbox Adaptive Controller",
		.bus = STILB_INPUT_BUS_BLUETOOTH,
		.vendor = MICROSOFT,
		.products = {0x0b0c, 0x0b21},
	},
	{
		.name = "DragonRise pad",
		.vendor = DRAGONRISE,
		.products = {0x0006},
		.buttons = &from_the_top,
	},
};

static bool is_product(const input_known *row, uint16_t product)
{
	for (size_t i = 0; i < sizeof row->products / sizeof *row->products && row->products[i] != 0; i++)
		if (row->products[i] == product)
			return true;
	return false;
}

/* True if the descriptor has this report. A copy of a known pad may have its vendor and product but other reports: then
 * the row is not used, and the reports are found by the descriptor's fields. */
static bool has_report(const stilb_input_descriptor *descriptor, const stilb_input_layout_report *report)
{
	for (uint32_t i = 0; i < descriptor->report_count; i++) {
		const stilb_input_report *r = &descriptor->reports[i];
		if (r->kind == STILB_INPUT_FIELD_INPUT && r->id == report->id)
			return r->size >= report->size;
	}
	return false;
}

const input_known *input_known_find(const stilb_input_pad_info *info, const stilb_input_descriptor *descriptor)
{
	STILB_ASSERT(info);
	for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
		const input_known *row = &known[i];
		if (row->vendor == info->vendor && (row->bus == 0 || row->bus == info->bus) && is_product(row, info->product) &&
		    (!row->reports || !descriptor || has_report(descriptor, row->reports)))
			return row;
	}
	return NULL;
}
