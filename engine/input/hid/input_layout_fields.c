/* The layout of a pad that is not in the table, from the fields of its report descriptor. HID usages do not say which
 * axes are the right stick or which button is in which position; here it is assumed to be as on most pads. */
#include "input/hid/input_layout_internal.h"

#include <stdio.h>

enum {
	USAGE_JOYSTICK = 0x00010004,
	USAGE_GAME_PAD = 0x00010005,
	USAGE_X = 0x00010030,
	USAGE_Y = 0x00010031,
	USAGE_Z = 0x00010032,
	USAGE_RX = 0x00010033,
	USAGE_RY = 0x00010034,
	USAGE_RZ = 0x00010035,
	USAGE_HAT = 0x00010039,
	USAGE_START = 0x0001003d,
	USAGE_SELECT = 0x0001003e,
	USAGE_MAIN_MENU = 0x00010085,
	USAGE_DPAD_UP = 0x00010090,
	USAGE_DPAD_DOWN = 0x00010091,
	USAGE_DPAD_RIGHT = 0x00010092,
	USAGE_DPAD_LEFT = 0x00010093,
	USAGE_RUDDER = 0x000200ba,
	USAGE_ACCELERATOR = 0x000200c4,
	USAGE_BRAKE = 0x000200c5,
	USAGE_BUTTON_PAGE = 0x00090000,
	USAGE_CONSUMER_RECORD = 0x000c00b2,
	USAGE_CONSUMER_HOME = 0x000c0223,
	USAGE_CONSUMER_BACK = 0x000c0224,
	USAGE_MAGNITUDE = 0x000f0070
};

/* ---- orders of buttons ------------------------------------------------------------------------------------------- */

/* The order of DirectInput pads and of Sony's. */
static const input_button_order usual_order = {
	"in the usual order",
	14,
	{STILB_INPUT_WEST, STILB_INPUT_SOUTH, STILB_INPUT_EAST, STILB_INPUT_NORTH, STILB_INPUT_LEFT_SHOULDER,
     STILB_INPUT_RIGHT_SHOULDER, INPUT_BUTTON_LEFT_TRIGGER, INPUT_BUTTON_RIGHT_TRIGGER, STILB_INPUT_BACK,
     STILB_INPUT_START, STILB_INPUT_LEFT_STICK, STILB_INPUT_RIGHT_STICK, STILB_INPUT_GUIDE, STILB_INPUT_EXTRA},
};

/* The order of Linux's button codes from BTN_SOUTH on (linux/input-event-codes.h), which Android requires of pads. */
static const input_button_order android_order = {
	"in the Android order",
	15,
	{STILB_INPUT_SOUTH, STILB_INPUT_EAST, INPUT_BUTTON_NONE, STILB_INPUT_WEST, STILB_INPUT_NORTH, INPUT_BUTTON_NONE,
     STILB_INPUT_LEFT_SHOULDER, STILB_INPUT_RIGHT_SHOULDER, INPUT_BUTTON_LEFT_TRIGGER, INPUT_BUTTON_RIGHT_TRIGGER,
     STILB_INPUT_BACK, STILB_INPUT_START, STILB_INPUT_GUIDE, STILB_INPUT_LEFT_STICK, STILB_INPUT_RIGHT_STICK},
};

/* The order of Xbox pads with their first firmware; under the driver xpadneo all Xbox pads have it, with the last two
 * buttons added. */
static const input_button_order xbox_order = {
	"in the Xbox order",
	12,
	{STILB_INPUT_SOUTH, STILB_INPUT_EAST, STILB_INPUT_WEST, STILB_INPUT_NORTH, STILB_INPUT_LEFT_SHOULDER,
     STILB_INPUT_RIGHT_SHOULDER, STILB_INPUT_BACK, STILB_INPUT_START, STILB_INPUT_LEFT_STICK, STILB_INPUT_RIGHT_STICK,
     STILB_INPUT_GUIDE, STILB_INPUT_EXTRA},
};

/* ---- finding elements -------------------------------------------------------------------------------------------- */

/* One element of a field: one axis or button. */
typedef struct element {
	const stilb_input_field *field; /* NULL: there is no such element */
	uint32_t index;
} element;

static bool is_pad(const stilb_input_field *f)
{
	return f->collection == USAGE_GAME_PAD || f->collection == USAGE_JOYSTICK;
}

static bool is_array(const stilb_input_field *f)
{
	return !(f->flags & STILB_INPUT_VARIABLE);
}

/* True for input fields whose values are numbers, and absolute. */
static bool is_readable(const stilb_input_field *f)
{
	return f->kind == STILB_INPUT_FIELD_INPUT && !(f->flags & (STILB_INPUT_CONSTANT | STILB_INPUT_RELATIVE)) &&
	       f->size >= 1 && f->size <= 32 && (is_array(f) || f->logical_min < f->logical_max);
}

static uint32_t last_usage(const stilb_input_field *f)
{
	return f->usage_last > f->usage ? f->usage_last : f->usage;
}

/* The first element of this usage in the given report; if report is NULL, in any report. Arrays are not searched: their
 * elements have no fixed usage. */
static element find(const stilb_input_descriptor *descriptor, const stilb_input_report *report, uint32_t usage)
{
	for (uint32_t i = 0; i < descriptor->field_count; i++) {
		const stilb_input_field *f = &descriptor->fields[i];
		if (is_readable(f) && !is_array(f) && (!report || f->report_id == report->id) && usage >= f->usage &&
		    usage <= last_usage(f))
			return (element){f, usage - f->usage};
	}
	return (element){NULL, 0};
}

/* The first report with both axes of a stick, or NULL. An adaptor for several pads has such a report for each of them,
 * of which only the first is read. */
static const stilb_input_report *find_main_report(const stilb_input_descriptor *descriptor)
{
	for (uint32_t i = 0; i < descriptor->report_count; i++) {
		const stilb_input_report *r = &descriptor->reports[i];
		if (r->kind != STILB_INPUT_FIELD_INPUT)
			continue;
		element x = find(descriptor, r, USAGE_X), y = find(descriptor, r, USAGE_Y);
		if (x.field && y.field && is_pad(x.field))
			return r;
	}
	return NULL;
}

/* ---- adding sources ---------------------------------------------------------------------------------------------- */

typedef struct builder {
	const stilb_input_descriptor *descriptor;
	const stilb_input_report *main;
	stilb_input_layout *out;
	uint32_t axes, buttons; /* bit 1 << n is set if the axis or button n has a source */
	uint32_t numbered;      /* the highest number of a numbered button */
	bool z_is_trigger;      /* Z and Rz are the triggers, as on Xbox pads with their first firmware */
} builder;

/* The layout's report of this id, added if it is new; NULL: there are too many. */
static stilb_input_layout_report *layout_report(builder *b, uint8_t id)
{
	stilb_input_layout *out = b->out;
	for (uint32_t i = 0; i < out->report_count; i++)
		if (out->reports[i].id == id)
			return &out->reports[i];
	if (out->report_count == STILB_INPUT_LAYOUT_REPORTS_MAX)
		return NULL;
	stilb_input_layout_report *report = &out->reports[out->report_count++];
	*report = (stilb_input_layout_report){.id = id};
	for (uint32_t i = 0; i < b->descriptor->report_count; i++)
		if (b->descriptor->reports[i].kind == STILB_INPUT_FIELD_INPUT && b->descriptor->reports[i].id == id)
			report->size = (uint16_t)b->descriptor->reports[i].size;
	return report;
}

/* Adds a source. One that does not fit is left out: no pad needs 40 sources (STILB_INPUT_SOURCES_MAX) for 6 axes and 16
 * buttons. */
static void add(builder *b, element e, stilb_input_source_kind kind, uint32_t target, int64_t low, int64_t high)
{
	STILB_ASSERT(e.field && e.index < e.field->count && e.field->size <= 32);
	stilb_input_layout_report *report = layout_report(b, e.field->report_id);
	if (!report || report->source_count == STILB_INPUT_SOURCES_MAX)
		return;
	report->sources[report->source_count++] = (stilb_input_source){
		.kind = (uint8_t)kind,
		.target = (uint8_t)target,
		.bits = (uint8_t)e.field->size,
		.is_signed = e.field->logical_min < 0 && e.field->size > 1,
		.bit = e.field->bit + e.index * e.field->size,
		.low = low,
		.high = high,
	};
	if (kind == STILB_INPUT_SOURCE_AXIS)
		b->axes |= 1u << target;
	else if (kind == STILB_INPUT_SOURCE_BUTTON)
		b->buttons |= 1u << target;
	else
		b->buttons |= 1u << STILB_INPUT_UP | 1u << STILB_INPUT_DOWN | 1u << STILB_INPUT_LEFT | 1u << STILB_INPUT_RIGHT;
}

static void add_axis(builder *b, element e, stilb_input_axis axis)
{
	bool down_is_more = axis == STILB_INPUT_LEFT_Y || axis == STILB_INPUT_RIGHT_Y;
	if (e.field && !(b->axes >> axis & 1))
		add(b, e, STILB_INPUT_SOURCE_AXIS, axis, down_is_more ? e.field->logical_max : e.field->logical_min,
		    down_is_more ? e.field->logical_min : e.field->logical_max);
}

/* A button is down from the middle of its range on, because some buttons are a byte of pressure. A button of one bit
 * may declare any range; its values are 0 and 1. */
static void add_button(builder *b, element e, uint32_t target)
{
	const stilb_input_field *f = e.field;
	bool is_bit = f->size == 1;
	int64_t low = is_bit ? 0 : f->logical_min, high = is_bit ? 1 : f->logical_max;
	if (target < STILB_INPUT_BUTTON_COUNT)
		add(b, e, STILB_INPUT_SOURCE_BUTTON, target, low + (high - low + 1) / 2, high);
	else if (target == INPUT_BUTTON_LEFT_TRIGGER && !(b->axes >> STILB_INPUT_LEFT_TRIGGER & 1))
		add(b, e, STILB_INPUT_SOURCE_AXIS, STILB_INPUT_LEFT_TRIGGER, low, high);
	else if (target == INPUT_BUTTON_RIGHT_TRIGGER && !(b->axes >> STILB_INPUT_RIGHT_TRIGGER & 1))
		add(b, e, STILB_INPUT_SOURCE_AXIS, STILB_INPUT_RIGHT_TRIGGER, low, high);
}

/* ---- sticks and triggers ----------------------------------------------------------------------------------------- */

static bool same_range(element a, element b)
{
	return a.field && b.field && a.field->size == b.field->size && a.field->logical_min == b.field->logical_min &&
	       a.field->logical_max == b.field->logical_max;
}

/* True if the axes a and b are in one physical collection, and x, the left stick's axis, is not in it. */
static bool is_grouped(element a, element b, element x)
{
	return a.field->group != 0 && a.field->group == b.field->group && a.field->group != x.field->group;
}

/* Makes the pair of axes that is not a stick the triggers, if they may be triggers: of a gamepad, and without negative
 * values. A joystick's throttle and rudder are not. False: nothing was added. */
static bool add_trigger_pair(builder *b, element left, element right)
{
	if (!same_range(left, right) || left.field->logical_min < 0 || left.field->collection != USAGE_GAME_PAD)
		return false;
	add_axis(b, left, STILB_INPUT_LEFT_TRIGGER);
	add_axis(b, right, STILB_INPUT_RIGHT_TRIGGER);
	return true;
}

/* Of the pairs Z, Rz and Rx, Ry the right stick is the one with the range of the left stick. If both have it, it is Rx,
 * Ry if only these are in a physical collection of their own, else Z, Rz as on Sony's pads. The triggers are brake and
 * accelerator, else the other pair. */
static void add_axes(builder *b)
{
	const stilb_input_descriptor *d = b->descriptor;
	element x = find(d, b->main, USAGE_X), y = find(d, b->main, USAGE_Y), z = find(d, b->main, USAGE_Z),
			rx = find(d, b->main, USAGE_RX), ry = find(d, b->main, USAGE_RY), rz = find(d, b->main, USAGE_RZ);
	bool z_stick = same_range(z, x) && same_range(rz, x), r_stick = same_range(rx, x) && same_range(ry, x);
	bool r_is_right = r_stick && (!z_stick || (is_grouped(rx, ry, x) && !is_grouped(z, rz, x)));
	add_axis(b, x, STILB_INPUT_LEFT_X);
	add_axis(b, y, STILB_INPUT_LEFT_Y);
	if (r_is_right || z_stick) {
		add_axis(b, r_is_right ? rx : z, STILB_INPUT_RIGHT_X);
		add_axis(b, r_is_right ? ry : rz, STILB_INPUT_RIGHT_Y);
	} else if (x.field && x.field->collection == USAGE_JOYSTICK) {
		add_axis(b, rz, STILB_INPUT_RIGHT_X); /* of a joystick: twisting the stick */
		add_axis(b, find(d, b->main, USAGE_RUDDER), STILB_INPUT_RIGHT_X);
	}
	add_axis(b, find(d, b->main, USAGE_BRAKE), STILB_INPUT_LEFT_TRIGGER);
	add_axis(b, find(d, b->main, USAGE_ACCELERATOR), STILB_INPUT_RIGHT_TRIGGER);
	if (z_stick && !r_is_right)
		add_trigger_pair(b, rx, ry);
	else
		b->z_is_trigger = add_trigger_pair(b, z, rz);
}

/* ---- buttons ----------------------------------------------------------------------------------------------------- */

/* Adds the d-pad's hat: eight directions clockwise from up, or four, or an angle. If the descriptor declares 9 or 16
 * values, only the first eight are directions; the others mean that nothing is pressed. */
static void add_hat(builder *b)
{
	element hat = find(b->descriptor, b->main, USAGE_HAT);
	if (!hat.field)
		return;
	int64_t first = hat.field->logical_min, values = hat.field->logical_max - first + 1;
	bool has_more = values == 9 || values == 16;
	add(b, hat, STILB_INPUT_SOURCE_HAT, STILB_INPUT_UP, first, has_more ? first + 7 : hat.field->logical_max);
}

/* Adds the buttons that have a usage of their own. Some firmware sends the home button by its usage in a separate
 * report, some by its number among the numbered buttons; as the descriptor has both, either puts the button down. */
static void add_named_buttons(builder *b)
{
	static const struct {
		uint32_t usage;
		stilb_input_button button;
		bool anywhere; /* in any report, also in one of another collection */
	} named[] = {
		{USAGE_DPAD_UP, STILB_INPUT_UP, false},        {USAGE_DPAD_DOWN, STILB_INPUT_DOWN, false},
		{USAGE_DPAD_LEFT, STILB_INPUT_LEFT, false},    {USAGE_DPAD_RIGHT, STILB_INPUT_RIGHT, false},
		{USAGE_START, STILB_INPUT_START, false},       {USAGE_SELECT, STILB_INPUT_BACK, false},
		{USAGE_MAIN_MENU, STILB_INPUT_GUIDE, true},    {USAGE_CONSUMER_HOME, STILB_INPUT_GUIDE, true},
		{USAGE_CONSUMER_BACK, STILB_INPUT_BACK, true}, {USAGE_CONSUMER_RECORD, STILB_INPUT_EXTRA, true},
	};
	for (size_t i = 0; i < sizeof named / sizeof *named; i++) {
		element e = find(b->descriptor, named[i].anywhere ? NULL : b->main, named[i].usage);
		if (e.field)
			add_button(b, e, named[i].button);
	}
}

static bool is_numbered(const builder *b, const stilb_input_field *f)
{
	return is_readable(f) && f->report_id == b->main->id && (f->usage & 0xffff0000) == USAGE_BUTTON_PAGE;
}

/* The first and the last of a field's button numbers. */
static uint32_t first_number(const stilb_input_field *f)
{
	return f->usage & 0xffff;
}

static uint32_t last_number(const stilb_input_field *f)
{
	return last_usage(f) & 0xffff;
}

/* The highest number of a numbered button; 0: there is none. */
static uint32_t count_numbered(const builder *b)
{
	uint32_t most = 0;
	for (uint32_t i = 0; i < b->descriptor->field_count; i++) {
		const stilb_input_field *f = &b->descriptor->fields[i];
		if (is_numbered(b, f) && last_number(f) > most)
			most = last_number(f);
	}
	return most;
}

/* Adds the button number nth, from 0, of an array: it is down while any of the array's elements has the value
 * logical_min + nth. */
static void add_array_button(builder *b, const stilb_input_field *f, uint32_t nth, uint32_t target)
{
	int64_t value = f->logical_min + nth;
	if (target >= STILB_INPUT_BUTTON_COUNT)
		return;
	for (uint32_t i = 0; i < f->count && i < STILB_INPUT_SOURCES_MAX; i++)
		add(b, (element){f, i}, STILB_INPUT_SOURCE_BUTTON, target, value, value);
}

static void add_numbered_buttons(builder *b, const input_button_order *order)
{
	for (uint32_t i = 0; i < b->descriptor->field_count; i++) {
		const stilb_input_field *f = &b->descriptor->fields[i];
		if (!is_numbered(b, f))
			continue;
		uint32_t first = first_number(f), last = last_number(f);
		for (uint32_t number = first > 0 ? first : 1; number <= last && number <= order->count; number++) {
			uint32_t target = order->targets[number - 1];
			if (is_array(f))
				add_array_button(b, f, number - first, target);
			else
				add_button(b, (element){f, number - first}, target);
		}
	}
}

/* Pads whose triggers are called brake and accelerator have Android's order, or that of the first Xbox firmware if they
 * have at most 12 numbered buttons. */
static const input_button_order *likely_order(const builder *b)
{
	bool has_brake = find(b->descriptor, b->main, USAGE_BRAKE).field;
	if (b->numbered > 12 && has_brake)
		return &android_order;
	if (b->numbered <= 12 && (b->z_is_trigger || has_brake))
		return &xbox_order;
	return &usual_order;
}

/* ---- the whole layout -------------------------------------------------------------------------------------------- */

/* True for Xbox pads and compatible ones, told by the output report with the id 3: from its byte 2 on it has the
 * strengths of four motors (left and right trigger, heavy, light), a byte each, in per cent. */
static bool has_xbox_rumble(const stilb_input_descriptor *descriptor)
{
	for (uint32_t i = 0; i < descriptor->field_count; i++) {
		const stilb_input_field *f = &descriptor->fields[i];
		if (f->kind == STILB_INPUT_FIELD_OUTPUT && f->usage == USAGE_MAGNITUDE && f->report_id == 3 && f->bit == 16 &&
		    f->size == 8 && f->count == 4 && f->logical_min == 0 && f->logical_max == 100)
			return true;
	}
	return false;
}

static void describe(const builder *b, const input_button_order *order, char *text, size_t size)
{
	bool right = b->axes >> STILB_INPUT_RIGHT_Y & 1, triggers = b->axes >> STILB_INPUT_LEFT_TRIGGER & 1;
	snprintf(text, size, "%s%s, %d buttons %s", right ? "two sticks" : "one stick", triggers ? ", triggers" : "",
	         __builtin_popcount(b->buttons), order->words);
}

bool input_layout_from_fields(const stilb_input_descriptor *descriptor, const input_button_order *order,
                              stilb_input_layout *out, char *found, size_t size)
{
	STILB_ASSERT(descriptor && out && found && size > 0);
	STILB_ASSERT(!order || order->count <= INPUT_BUTTONS_MAX);
	builder b = {.descriptor = descriptor, .main = find_main_report(descriptor), .out = out};
	out->report_count = 0;
	if (!b.main)
		return false;
	b.numbered = count_numbered(&b);
	if (b.numbered == 0)
		return false;
	add_axes(&b);
	if (!order)
		order = likely_order(&b);
	add_hat(&b);
	add_named_buttons(&b);
	add_numbered_buttons(&b, order);
	out->rumble = has_xbox_rumble(descriptor) ? STILB_INPUT_RUMBLE_XBOX_BLUETOOTH : STILB_INPUT_RUMBLE_NONE;
	describe(&b, order, found, size);
	STILB_CHECK(input_layout_is_sound(out));
	return true;
}
