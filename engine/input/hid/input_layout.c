#include "input/hid/input_layout_internal.h"
#include "input/input_pad_internal.h"

#include <stdio.h>
#include <string.h>

/* ---- CRC --------------------------------------------------------------------------------------------------------- */

uint32_t stilb_input_crc32(uint32_t crc, const void *data, size_t size)
{
	STILB_ASSERT(data || size == 0);
	/* CRCs of half bytes, a table of 64 bytes. A table for whole bytes saves half of the steps but has 1 KiB, which the
	 * cache would have dropped again in the 4 ms between two reports of a Bluetooth pad. */
	static const uint32_t table[16] = {0x00000000, 0x1db71064, 0x3b6e20c8, 0x26d930ac, 0x76dc4190, 0x6b6b51f4,
	                                   0x4db26158, 0x5005713c, 0xedb88320, 0xf00f9344, 0xd6d6a3e8, 0xcb61b38c,
	                                   0x9b64c2b0, 0x86d3d2d4, 0xa00ae278, 0xbdbdf21c};
	const uint8_t *bytes = data;
	crc = ~crc;
	for (size_t i = 0; i < size; i++) {
		crc ^= bytes[i];
		crc = table[crc & 15] ^ crc >> 4;
		crc = table[crc & 15] ^ crc >> 4;
	}
	return ~crc;
}

/* ---- decode ------------------------------------------------------------------------------------------------------ */

/* -1 at low, 1 at high, 0 in the middle: of an even number of values at the upper middle one, as pads have it (128 of
 * 0..255). Values outside the range count as its end. */
static float stick_value(int64_t value, int64_t low, int64_t high)
{
	int64_t least = low < high ? low : high, most = low < high ? high : low;
	int64_t rest = least + (most - least + 1) / 2;
	int64_t inside = value < least ? least : value > most ? most : value;
	int64_t side = inside >= rest ? most - rest : rest - least;
	float away = side > 0 ? (float)((double)(inside - rest) / (double)side) : 0.0f;
	return low < high ? away : 0.0f - away;
}

/* 0 at low, 1 at high. Values outside the range count as its end. */
static float trigger_value(int64_t value, int64_t low, int64_t high)
{
	double pressed = low == high ? 0.0 : (double)(value - low) / (double)(high - low);
	return (float)(pressed < 0.0 ? 0.0 : pressed > 1.0 ? 1.0 : pressed);
}

/* The d-pad buttons of a hat: low is up, the values follow clockwise; the value is rounded to one of eight
 * directions. */
static uint32_t hat_directions(int64_t value, int64_t low, int64_t high)
{
	enum {
		UP = 1u << STILB_INPUT_UP,
		DOWN = 1u << STILB_INPUT_DOWN,
		LEFT = 1u << STILB_INPUT_LEFT,
		RIGHT = 1u << STILB_INPUT_RIGHT
	};
	static const uint32_t directions[8] = {UP, UP | RIGHT, RIGHT, DOWN | RIGHT, DOWN, DOWN | LEFT, LEFT, UP | LEFT};
	if (value < low || value > high)
		return 0;
	int64_t steps = high - low + 1;
	return directions[((value - low) * 16 + steps) / (2 * steps) % 8];
}

/* told: bits 1 << stilb_input_button of the buttons that this report has sources for; down: those of them that are
 * down. */
typedef struct decoded_buttons {
	uint32_t told, down;
} decoded_buttons;

static void decode_source(const stilb_input_source *source, int64_t value, stilb_input_pad_state *state,
                          decoded_buttons *buttons)
{
	STILB_ASSERT(source->kind != STILB_INPUT_SOURCE_AXIS || source->target < STILB_INPUT_AXIS_COUNT);
	int64_t low = source->low, high = source->high;
	uint32_t every_direction =
		1u << STILB_INPUT_UP | 1u << STILB_INPUT_DOWN | 1u << STILB_INPUT_LEFT | 1u << STILB_INPUT_RIGHT;
	switch ((stilb_input_source_kind)source->kind) {
	case STILB_INPUT_SOURCE_AXIS:
		state->axes[source->target] =
			source->target < STILB_INPUT_LEFT_TRIGGER ? stick_value(value, low, high) : trigger_value(value, low, high);
		break;
	case STILB_INPUT_SOURCE_BUTTON:
		buttons->told |= 1u << source->target;
		buttons->down |= (uint32_t)(value >= low && value <= high) << source->target;
		break;
	case STILB_INPUT_SOURCE_HAT:
		buttons->told |= every_direction;
		buttons->down |= hat_directions(value, low, high);
		break;
	}
}

/* Reads the source's bits as a number. False: the report is too short to hold them. */
static bool source_value(const stilb_input_source *source, const uint8_t *report, size_t size, int64_t *value)
{
	uint32_t bits;
	if (!stilb_input_bits(report, size, source->bit, source->bits, &bits))
		return false;
	int64_t sign = (int64_t)1 << (source->bits - 1);
	*value = source->is_signed ? (int64_t)(bits ^ (uint32_t)sign) - sign : (int64_t)bits;
	return true;
}

/* The layout of the report with this first byte, or NULL. */
static const stilb_input_layout_report *find_report(const stilb_input_layout *layout, uint8_t id)
{
	for (uint32_t i = 0; i < layout->report_count; i++)
		if (layout->reports[i].id == 0 || layout->reports[i].id == id)
			return &layout->reports[i];
	return NULL;
}

/* Bluetooth's header byte before an input report (HID data, input). hidraw does not give it, but the CRC covers it. */
static const uint8_t bluetooth_input = 0xa1;

static bool crc_holds(const stilb_input_layout_report *layout, const uint8_t *report, size_t size)
{
	size_t at = layout->crc;
	if (at == 0)
		return true;
	if (size < at + 4)
		return false;
	uint32_t told = (uint32_t)report[at] | (uint32_t)report[at + 1] << 8 | (uint32_t)report[at + 2] << 16 |
	                (uint32_t)report[at + 3] << 24;
	return stilb_input_crc32(stilb_input_crc32(0, &bluetooth_input, 1), report, at) == told;
}

stilb_input_decoded stilb_input_decode(const stilb_input_layout *layout, const uint8_t *report, size_t size,
                                       stilb_input_pad_state *state)
{
	STILB_ASSERT(layout && state && (report || size == 0));
	STILB_CHECK(input_layout_is_sound(layout));
	if (size == 0)
		return STILB_INPUT_CORRUPT;
	const stilb_input_layout_report *known = find_report(layout, report[0]);
	if (!known)
		return STILB_INPUT_OTHER;
	if (!crc_holds(known, report, size))
		return STILB_INPUT_CORRUPT;
	uint32_t absent;
	if (known->absent != 0 && stilb_input_bits(report, size, known->absent, 1, &absent) && absent) {
		*state = (stilb_input_pad_state){0};
		return STILB_INPUT_DECODED;
	}
	decoded_buttons buttons = {0};
	bool any = false;
	for (uint32_t i = 0; i < known->source_count; i++) {
		int64_t value;
		if (!source_value(&known->sources[i], report, size, &value))
			continue;
		decode_source(&known->sources[i], value, state, &buttons);
		any = true;
	}
	state->buttons = (state->buttons & ~buttons.told) | buttons.down;
	STILB_CHECK(input_pad_state_is_sound(state));
	return any ? STILB_INPUT_DECODED : STILB_INPUT_CORRUPT;
}

/* For STILB_CHECK: true if the source's kind and target exist, and its bits are within a report of report_bits bits. */
static bool source_is_sound(const stilb_input_source *source, uint32_t report_bits)
{
	uint32_t targets = source->kind == STILB_INPUT_SOURCE_AXIS ? STILB_INPUT_AXIS_COUNT : STILB_INPUT_BUTTON_COUNT;
	return source->kind <= STILB_INPUT_SOURCE_HAT && source->target < targets && source->bits >= 1 &&
	       source->bits <= 32 && source->bit + source->bits <= report_bits;
}

bool input_layout_is_sound(const stilb_input_layout *layout)
{
	bool sound = layout->report_count >= 1 && layout->report_count <= STILB_INPUT_LAYOUT_REPORTS_MAX;
	for (uint32_t i = 0; sound && i < layout->report_count; i++) {
		const stilb_input_layout_report *report = &layout->reports[i];
		sound =
			report->source_count <= STILB_INPUT_SOURCES_MAX && (report->crc == 0 || report->crc + 4u <= report->size);
		for (uint32_t k = 0; sound && k < report->source_count; k++)
			sound = source_is_sound(&report->sources[k], 8u * report->size);
	}
	return sound;
}

/* ---- find -------------------------------------------------------------------------------------------------------- */

static const char *bus_text(uint16_t bus)
{
	return bus == STILB_INPUT_BUS_USB ? ", USB" : bus == STILB_INPUT_BUS_BLUETOOTH ? ", Bluetooth" : "";
}

static const char *name_or(const stilb_input_pad_info *info, const char *otherwise)
{
	return info->name[0] != '\0' ? info->name : otherwise;
}

/* Copies the reports of a row of the table of known pads, which end with one of size 0 and their sources with one of 0
 * bits. */
static void copy_reports(const stilb_input_layout_report *reports, stilb_input_layout *out)
{
	while (out->report_count < STILB_INPUT_LAYOUT_REPORTS_MAX && reports[out->report_count].size != 0) {
		stilb_input_layout_report *report = &out->reports[out->report_count];
		*report = reports[out->report_count++];
		while (report->source_count < STILB_INPUT_SOURCES_MAX && report->sources[report->source_count].bits != 0)
			report->source_count++;
	}
}

static void copy_hello(const stilb_input_hello *hello, stilb_input_layout *out)
{
	for (uint32_t i = 0; i + 1 < STILB_INPUT_HELLO_MAX && hello[i].kind != STILB_INPUT_HELLO_END; i++)
		out->hello[i] = hello[i];
}

/* Fails with a message like "'Mouse' (046d:c077) is not a gamepad: ...". */
static stilb_result not_a_gamepad(const stilb_input_pad_info *info, const char *why)
{
	return stilb_fail(STILB_ERROR_ARGUMENT, "'%s' (%04x:%04x) is not a gamepad: %s", name_or(info, "this device"),
	                  info->vendor, info->product, why);
}

static stilb_result not_of_a_gamepad(const stilb_input_pad_info *info, const stilb_input_descriptor *descriptor)
{
	char usage[64], why[160];
	if (descriptor->field_count == 0)
		return not_a_gamepad(info, "its report descriptor has no fields");
	snprintf(why, sizeof why, "its report descriptor has no stick with buttons, it is that of %s",
	         stilb_input_usage_text(descriptor->fields[0].collection, usage, sizeof usage));
	return not_a_gamepad(info, why);
}

static stilb_result find_by_fields(const stilb_input_pad_info *info, const stilb_input_descriptor *descriptor,
                                   const input_known *row, stilb_input_layout *out)
{
	char found[64];
	if (!input_layout_from_fields(descriptor, row ? row->buttons : NULL, out, found, sizeof found))
		return not_of_a_gamepad(info, descriptor);
	snprintf(out->recognised, sizeof out->recognised, "%sits descriptor: %s", row ? "known pad, " : "", found);
	return STILB_OK;
}

stilb_result stilb_input_layout_find(const stilb_input_pad_info *info, stilb_input_layout *out)
{
	STILB_ASSERT(info && out && info->descriptor_size <= STILB_INPUT_DESCRIPTOR_MAX);
	stilb_input_descriptor descriptor = {0};
	bool has = info->descriptor_size > 0;
	bool readable =
		has && stilb_input_descriptor_parse(info->descriptor, info->descriptor_size, &descriptor) == STILB_OK;
	const input_known *row = input_known_find(info, readable ? &descriptor : NULL);
	*out = (stilb_input_layout){.known = row};
	if (!row)
		snprintf(out->name, sizeof out->name, "%.50s%s", name_or(info, "gamepad"), bus_text(info->bus));
	else
		snprintf(out->name, sizeof out->name, "%s%s", row->name, bus_text(info->bus));
	if (row && row->reports) {
		copy_reports(row->reports, out);
		out->rumble = row->rumble;
		if (row->hello)
			copy_hello(row->hello, out);
		snprintf(out->recognised, sizeof out->recognised, "known pad %04x:%04x", info->vendor, info->product);
		return STILB_OK;
	}
	if (readable)
		return find_by_fields(info, &descriptor, row, out);
	if (!has)
		return not_a_gamepad(info, "it has no report descriptor");
	char why[256];
	snprintf(why, sizeof why, "%s", stilb_error_message());
	return not_a_gamepad(info, why);
}
