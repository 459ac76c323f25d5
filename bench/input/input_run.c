/* The program of the suite `input`, which measures the handling of gamepads. Every measured call is checked for its
 * result. */
#include "bench/harness/bench_child.h"

#include "input/hid/input_layout.h"
#include "input/input_control.h"
#include "support/input_descriptors.h"

#include <math.h>
#include <string.h>

/* ---- pads -------------------------------------------------------------------------------------------------------- */

static stilb_input_pad_info pad_info(uint16_t bus, uint16_t vendor, uint16_t product)
{
	const input_test_descriptor *found = input_test_descriptor_find(bus, vendor, product);
	if (!found)
		bench_child_fail("no descriptor of %04x:%04x", vendor, product);
	stilb_input_pad_info info = {.path = "/dev/hidraw0",
	                             .bus = bus,
	                             .vendor = vendor,
	                             .product = product,
	                             .descriptor_size = (uint16_t)found->size};
	memcpy(info.descriptor, found->bytes, found->size);
	return info;
}

static void check(bool condition, const char *what)
{
	if (!condition)
		bench_child_fail("%s is wrong", what);
}

/* ---- time -------------------------------------------------------------------------------------------------------- */

#define BATCH_NS 100000.0

/* The time of one call of step, ns: the least mean of a batch of calls. A batch takes about BATCH_NS, much longer than
 * the clock's resolution. */
static double least_ns(double seconds, void (*step)(void *), void *user)
{
	uint32_t calls = 1;
	double least = (double)INFINITY, batch = 0.0;
	uint64_t end = bench_child_now_ns() + (uint64_t)(seconds * 1e9);
	do {
		uint64_t begin = bench_child_now_ns();
		for (uint32_t i = 0; i < calls; i++)
			step(user);
		batch = (double)(bench_child_now_ns() - begin);
		if (batch < BATCH_NS)
			calls *= 2;
		else
			least = fmin(least, batch / calls);
	} while (batch < BATCH_NS || bench_child_now_ns() < end);
	return least;
}

/* ---- descriptors ------------------------------------------------------------------------------------------------- */

typedef struct parse_step {
	const uint8_t *bytes;
	size_t size;
	stilb_input_descriptor out;
} parse_step;

static void parse(void *user)
{
	parse_step *step = user;
	check(stilb_input_descriptor_parse(step->bytes, step->size, &step->out) == STILB_OK, "the descriptor");
}

static double parse_us(double seconds, const uint8_t *bytes, size_t size, uint32_t fields)
{
	static parse_step step;
	step = (parse_step){.bytes = bytes, .size = size};
	double ns = least_ns(seconds, parse, &step);
	check(step.out.field_count == fields, "the number of fields");
	return 1e-3 * ns;
}

/* Makes a report descriptor with as many fields as are allowed, whose usages no gamepad layout knows; returns its size
 * in bytes. */
static size_t fullest(uint8_t bytes[STILB_INPUT_DESCRIPTOR_MAX])
{
	static const uint8_t begin[] = {0x25, 0x01, 0x75, 0x01, 0x95, 0x01}, field[] = {0x09, 0x30, 0x81, 0x02};
	size_t size = sizeof begin;
	memcpy(bytes, begin, sizeof begin);
	for (uint32_t i = 0; i < STILB_INPUT_FIELDS_MAX; i++, size += sizeof field)
		memcpy(bytes + size, field, sizeof field);
	for (; size + 2 <= STILB_INPUT_DESCRIPTOR_MAX; size += 2)
		memcpy(bytes + size, size % 64 ? field : (const uint8_t[]){0x81, 0x03}, 2);
	return size;
}

static void run_parse(const bench_child *child)
{
	const input_test_descriptor *joystick = input_test_descriptor_find(STILB_INPUT_BUS_USB, 0x06a3, 0xff0d);
	const input_test_descriptor *pad = input_test_descriptor_find(STILB_INPUT_BUS_USB, 0x054c, 0x05c4);
	uint8_t full[STILB_INPUT_DESCRIPTOR_MAX];
	size_t full_size = fullest(full);
	check(joystick->size == 625 && pad->size == 507, "a descriptor's size");
	bench_child_metric("joystick", parse_us(child->seconds / 3, joystick->bytes, joystick->size, 52));
	bench_child_metric("pad", parse_us(child->seconds / 3, pad->bytes, pad->size, 59));
	bench_child_metric("fullest", parse_us(child->seconds / 3, full, full_size, STILB_INPUT_FIELDS_MAX));
}

/* ---- layouts ----------------------------------------------------------------------------------------------------- */

typedef struct find_step {
	stilb_input_pad_info info;
	stilb_input_layout layout;
} find_step;

static void find(void *user)
{
	find_step *step = user;
	check(stilb_input_layout_find(&step->info, &step->layout) == STILB_OK, "the layout");
}

static void run_find(const bench_child *child)
{
	static find_step known, fields;
	known.info = pad_info(STILB_INPUT_BUS_USB, 0x054c, 0x05c4);
	fields.info = pad_info(STILB_INPUT_BUS_USB, 0x18d1, 0x2c40);
	bench_child_metric("known", 1e-3 * least_ns(child->seconds / 2, find, &known));
	bench_child_metric("fields", 1e-3 * least_ns(child->seconds / 2, find, &fields));
	check(known.layout.known && !fields.layout.known, "how the pads were found");
}

/* ---- reports ----------------------------------------------------------------------------------------------------- */

typedef struct decode_step {
	stilb_input_layout layout;
	uint8_t report[78];
	size_t size;
	stilb_input_pad_state state;
} decode_step;

static void decode(void *user)
{
	decode_step *step = user;
	check(stilb_input_decode(&step->layout, step->report, step->size, &step->state) == STILB_INPUT_DECODED,
	      "the report");
}

static volatile uint32_t crc_seen;

static void crc(void *user)
{
	const decode_step *step = user;
	crc_seen = stilb_input_crc32(0, step->report, 74);
}

/* The layout and a report of a DualShock 4 with the left stick fully to the right, everything else at rest. */
static decode_step dualshock(uint16_t bus)
{
	bool usb = bus == STILB_INPUT_BUS_USB;
	stilb_input_pad_info info = pad_info(bus, 0x054c, 0x05c4);
	decode_step step = {.size = usb ? 64 : 78};
	check(stilb_input_layout_find(&info, &step.layout) == STILB_OK, "the layout");
	uint8_t *state = step.report + (usb ? 1 : 3);
	step.report[0] = usb ? 0x01 : 0x11;
	if (!usb)
		step.report[1] = 0xc0;
	memcpy(state, (const uint8_t[]){0xff, 0x80, 0x80, 0x80, 0x08}, 5);
	if (!usb) {
		uint8_t kind = 0xa1;
		uint32_t sum = stilb_input_crc32(stilb_input_crc32(0, &kind, 1), step.report, 74);
		memcpy(step.report + 74, &sum, sizeof sum);
	}
	return step;
}

static void run_decode(const bench_child *child)
{
	decode_step usb = dualshock(STILB_INPUT_BUS_USB), bluetooth = dualshock(STILB_INPUT_BUS_BLUETOOTH);
	bench_child_metric("usb", least_ns(child->seconds / 3, decode, &usb));
	bench_child_metric("bluetooth", least_ns(child->seconds / 3, decode, &bluetooth));
	bench_child_metric("crc", least_ns(child->seconds / 3, crc, &bluetooth));
	check(usb.state.axes[STILB_INPUT_LEFT_X] == 1.0f && usb.state.buttons == 0, "the state");
	check(memcmp(&usb.state, &bluetooth.state, sizeof usb.state) == 0, "the state by Bluetooth");
	check(stilb_input_crc32(0, "123456789", 9) == 0xcbf43926u, "the CRC");
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

#define FRAME_US 16667

typedef struct frame_step {
	stilb_input_control *control;
	decode_step pad;
	uint32_t reports; /* number of reports that the pad sends in each frame */
	int64_t time_us;
	stilb_input_pose pose;
} frame_step;

static void frame(void *user)
{
	frame_step *step = user;
	stilb_input_state keys = {0};
	stilb_input_state out;
	for (uint32_t i = 0; i < step->reports; i++) {
		step->pad.report[1] = (uint8_t)(255 - i % 64); /* the stick moves in every report */
		stilb_input_event event = {.kind = STILB_INPUT_PAD_REPORT,
		                           .pad = 1,
		                           .time_us = step->time_us + (int64_t)i * FRAME_US / step->reports,
		                           .bytes = step->pad.report,
		                           .size = (uint32_t)step->pad.size};
		stilb_input_control_event(step->control, &event);
	}
	step->time_us += FRAME_US;
	stilb_input_control_frame(step->control, step->time_us, &keys, true, &out, &step->pose);
}

static double frame_us(double seconds, uint32_t reports)
{
	frame_step step = {.pad = dualshock(STILB_INPUT_BUS_USB), .reports = reports};
	stilb_input_control_settings settings = stilb_input_control_settings_default();
	stilb_input_pad_info info = pad_info(STILB_INPUT_BUS_USB, 0x054c, 0x05c4);
	stilb_input_event added = {.kind = STILB_INPUT_PAD_ADDED, .pad = 1, .info = &info};
	check(stilb_input_control_create(&settings, &step.pose, 0, &step.control) == STILB_OK, "the control");
	stilb_input_control_event(step.control, &added);
	double ns = least_ns(seconds, frame, &step);
	check(reports == 0 || step.pose.position[0] > 0.0f, "the flight");
	stilb_input_control_destroy(step.control);
	return 1e-3 * ns;
}

static void run_frame(const bench_child *child)
{
	bench_child_metric("idle", frame_us(child->seconds / 3, 0));
	bench_child_metric("reports-16", frame_us(child->seconds / 3, 16));
	bench_child_metric("reports-500", frame_us(child->seconds / 3, 500));
}

/* ---- the camera -------------------------------------------------------------------------------------------------- */

typedef struct camera_step {
	stilb_input_camera camera;
	int64_t time_us;
	stilb_input_pose pose;
} camera_step;

static void camera(void *user)
{
	camera_step *step = user;
	float turn = step->time_us / FRAME_US % 2 ? 0.5f : 0.6f;
	stilb_input_wish wish = {.move = {0.0f, 0.0f, 1.0f}, .turn = {turn, 0.0f}};
	stilb_input_camera_steer(&step->camera, step->time_us, &wish);
	step->time_us += FRAME_US;
	stilb_input_camera_advance(&step->camera, step->time_us);
	step->pose = stilb_input_camera_at(&step->camera, step->time_us);
}

static void run_camera(const bench_child *child)
{
	camera_step step = {0};
	stilb_input_camera_settings settings = stilb_input_camera_settings_default();
	step.camera = stilb_input_camera_make(&settings, &step.pose, 0);
	bench_child_metric("frame", least_ns(child->seconds, camera, &step));
	check(step.pose.yaw != 0.0f && isfinite(step.pose.position[0]), "the flight");
}

int main(int argc, char **argv)
{
	static const struct {
		const char *name;
		void (*run)(const bench_child *child);
	} runs[] = {
		{"parse", run_parse}, {"find", run_find}, {"decode", run_decode}, {"frame", run_frame}, {"camera", run_camera},
	};
	bench_child child = bench_child_args(argc, argv);
	for (size_t i = 0; i < sizeof runs / sizeof *runs; i++) {
		if (strcmp(child.case_name, runs[i].name) != 0)
			continue;
		runs[i].run(&child);
		return 0;
	}
	return BENCH_CHILD_SKIP;
}
