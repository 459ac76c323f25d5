/*
 * Gamepads in a window: one that only the window's library can read (an Xbox pad over USB has no hidraw node), and one
 * that both can. umockdev makes the kernel's input devices up, in which GLFW looks; sockets stand in for the hidraw
 * node. The test starts itself again under umockdev-run.
 */
#include "engine_internal.h"
#include "support/fake_hidraw.h"
#include "support/test.h"
#include "support/umockdev.h"
#include "tests/engine/stress_engine.h"

#include <linux/input.h>
#include <stddef.h>

#define NODE 3
#define TRIES 100000 /* frames of a few milliseconds after which a wait fails: a limit against hangs only */

/* ---- what umockdev is told --------------------------------------------------------------------------------------- */

typedef struct evdev_pad {
	int event; /* /dev/input/event<this> */
	const char *name;
	struct input_id id;
	const char *events; /* the events that it sends first, in umockdev's format, times in seconds */
	int pressed;        /* button that it presses after those, again and again, so that none misses it; 0: none */
} evdev_pad;

/* The events have no SYN_REPORT: after one GLFW asks for all axes, and umockdev would answer their first values. */
static const evdev_pad evdev_pads[] = {
	{5,
     "Microsoft X-Box 360 pad",
     {BUS_USB, 0x045e, 0x028e, 0x0110},
     "E: 0.000000 0003 0001 32768\n"
     "E: 1.200000 0003 0001 0\n", /* the left stick goes up */
     BTN_EAST},
	{6, "Wireless Controller", {BUS_USB, 0x054c, 0x05c4, 0x8111}, "E: 0.000000 0003 0001 32768\n", 0},
};
#define EVDEV_PADS (sizeof evdev_pads / sizeof *evdev_pads)

static void put_bytes(FILE *file, const char *what, int result, const void *bytes, size_t size)
{
	fprintf(file, "%s %d ", what, result);
	for (size_t i = 0; i < size; i++)
		fprintf(file, "%02X", ((const uint8_t *)bytes)[i]);
	fputc('\n', file);
}

/* Writes the first `size` bytes of a set of bits, as answer to the ioctl `what`. */
static void put_bits(FILE *file, const char *what, const int *bits, size_t count, size_t size)
{
	uint8_t bytes[96] = {0};
	for (size_t i = 0; i < count; i++)
		bytes[bits[i] / 8] |= (uint8_t)(1 << bits[i] % 8);
	put_bytes(file, what, (int)size, bytes, size);
}

/* Answers of the device to the ioctls of linux/input.h: a pad with two sticks, two triggers, a hat, 13 buttons. */
static void put_answers(FILE *file, const evdev_pad *pad)
{
	static const int types[] = {EV_SYN, EV_KEY, EV_ABS};
	static const int keys[] = {BTN_SOUTH, BTN_EAST,   BTN_NORTH, BTN_WEST, BTN_TL,     BTN_TR,    BTN_TL2,
	                           BTN_TR2,   BTN_SELECT, BTN_START, BTN_MODE, BTN_THUMBL, BTN_THUMBR};
	static const int axes[] = {ABS_X, ABS_Y, ABS_Z, ABS_RX, ABS_RY, ABS_RZ, ABS_HAT0X, ABS_HAT0Y};
	char name[256] = "";
	snprintf(name, sizeof name, "%s", pad->name);
	put_bytes(file, "EVIOCGID", 0, &pad->id, sizeof pad->id);
	put_bytes(file, "EVIOCGNAME(0)", (int)strlen(name) + 1, name, sizeof name);
	put_bits(file, "EVIOCGBIT(0)", types, sizeof types / sizeof *types, 4);
	put_bits(file, "EVIOCGBIT(1)", keys, sizeof keys / sizeof *keys, 96);
	put_bits(file, "EVIOCGBIT(3)", axes, sizeof axes / sizeof *axes, 8);
	for (size_t i = 0; i < sizeof axes / sizeof *axes; i++) {
		char what[32];
		struct input_absinfo range = {.value = 32768, .maximum = 65535};
		if (axes[i] == ABS_Z || axes[i] == ABS_RZ)
			range.value = 0;
		if (axes[i] >= ABS_HAT0X)
			range = (struct input_absinfo){.minimum = -1, .maximum = 1};
		snprintf(what, sizeof what, "EVIOCGABS(%d)", axes[i]);
		put_bytes(file, what, 0, &range, sizeof range);
	}
}

static FILE *create(const char *folder, const char *kind, int event)
{
	char path[128];
	snprintf(path, sizeof path, "%s/%s%d", folder, kind, event);
	FILE *file = fopen(path, "w");
	if (!file)
		abort();
	return file;
}

static void write_pad(const char *folder, const evdev_pad *pad)
{
	FILE *file = create(folder, "device", pad->event);
	fprintf(file,
	        "P: /devices/pad/input/input%d/event%d\nN: input/event%d\nE: DEVNAME=/dev/input/event%d\n"
	        "E: SUBSYSTEM=input\nE: MAJOR=13\nE: MINOR=%d\nA: dev=13:%d\n\n",
	        pad->event, pad->event, pad->event, pad->event, 64 + pad->event, 64 + pad->event);
	fclose(file);
	file = create(folder, "answers", pad->event);
	put_answers(file, pad);
	fclose(file);
	file = create(folder, "events", pad->event);
	fputs(pad->events, file);
	for (int i = 0; pad->pressed && i < 200; i++)
		fprintf(file, "E: %d.%d00000 0001 %04x %d\n", 1 + (5 + i) / 5, (5 + i) % 5 * 2, pad->pressed, i % 2);
	fclose(file);
}

/* ---- the test ---------------------------------------------------------------------------------------------------- */

static stilb_engine *engine;
static stilb_engine_report report;
static stilb_input_control_pad pads[STILB_INPUT_PADS_MAX];
static uint32_t pad_count, views;

static const stilb_input_action next_view = {.name = "next view",
                                             .pad = STILB_INPUT_PAD(EAST) | STILB_INPUT_PAD(RIGHT)};

static int set_up(void **state)
{
	(void)state;
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.workers = 0;
	desc.width = 160;
	desc.height = 100;
	desc.window = true;
	desc.validate = true;
	desc.gamepad_sys = fake.sys;
	desc.gamepad_dev = fake.dev;
	desc.actions = &next_view;
	desc.action_count = 1;
	if (stress_engine_create(&desc, &(stress_engine){.models = 25, .seed = 1}, &engine) == STILB_OK)
		return 0;
	fprintf(stderr, "%s\n", stilb_error_message());
	return -1;
}

static int tear_down(void **state)
{
	(void)state;
	stress_engine_destroy(engine);
	return 0;
}

static void run_frame(void)
{
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	assert_int_equal(stilb_engine_validation_messages(engine), 0);
	views += report.input.actions[STILB_ENGINE_ACTIONS];
	pad_count = stilb_engine_gamepads(engine, pads);
}

static bool moved_since(const stilb_input_pose *before)
{
	stilb_input_pose now = stilb_engine_pose(engine);
	return memcmp(&now, before, sizeof now) != 0;
}

static void expect_moves(const stilb_input_pose *before)
{
	for (int i = 0; i < TRIES && !moved_since(before); i++)
		run_frame();
	assert_true(moved_since(before));
}

static const stilb_input_control_pad *leader(void)
{
	for (uint32_t i = 0; i < pad_count; i++)
		if (pads[i].leads)
			return &pads[i];
	return NULL;
}

/* True if there are `count` pads, of which `windows` are read through the window's library. */
static bool there_are(uint32_t count, uint32_t windows)
{
	for (uint32_t i = 0; i < pad_count; i++)
		windows -= strncmp(pads[i].info->path, "window:", 7) == 0;
	return pad_count == count && windows == 0;
}

static void expect_pads(uint32_t count, uint32_t windows)
{
	for (int i = 0; i < TRIES && !there_are(count, windows); i++) {
		run_frame();
		assert_true(pad_count <= 2);
	}
	assert_true(there_are(count, windows));
}

static void pull_evdev(int event)
{
	char path[PATH_MAX];
	snprintf(path, sizeof path, "%s/dev/input/event%d", getenv("UMOCKDEV_DIR"), event);
	assert_int_equal(unlink(path), 0);
}

static void expect_rest(void)
{
	stilb_input_pose rest = stilb_engine_pose(engine);
	for (int i = 0; i < 5; i++)
		run_frame();
	assert_false(moved_since(&rest));
}

static void test_both_ways_to_a_pad(void **state)
{
	(void)state;
	const input_test_descriptor *dualshock = input_test_descriptor_find(BUS_USB, 0x054c, 0x05c4);
	uint8_t bytes[64] = {1, 0x80, 0, 0x80, 0x80, 8};
	stilb_input_pose pose = stilb_engine_pose(engine);
	fake_plug(NODE, dualshock);
	expect_pads(2, 1); /* the Xbox pad, and the DualShock once */
	expect_moves(&pose);
	assert_non_null(leader());
	assert_string_equal(leader()->name, "Microsoft X-Box 360 pad");
	for (int i = 0; i < TRIES && views == 0; i++)
		run_frame();
	assert_true(views > 0);

	pull_evdev(5); /* unplugged while its stick is pushed */
	expect_pads(1, 0);
	expect_rest();

	pose = stilb_engine_pose(engine);
	assert_true(fake_send(NODE, bytes, sizeof bytes));
	expect_moves(&pose);
	assert_non_null(strstr(leader()->info->path, "hidraw3"));
	fake_unplug(NODE);
	expect_pads(1, 1); /* its evdev node is still there */
	fake_plug_mode(NODE, dualshock, 0);
	expect_pads(2, 1); /* the hidraw node is denied, so the pad is still read through the window's library */
	assert_int_equal(engine->overlay.notice.pad_count, 1);
	fake_chmod(NODE, 0600);
	expect_pads(1, 0);
	assert_int_equal(engine->overlay.notice.pad_count, 0);
	pull_evdev(6);
	fake_unplug(NODE);
	expect_pads(0, 0);
	expect_rest();
}

static int run_inside(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test_setup_teardown(test_both_ways_to_a_pad, set_up, tear_down),
	};
	fake_begin();
	int failed = cmocka_run_group_tests(tests, NULL, NULL);
	fake_end();
	return failed;
}

/* ---- the same program under umockdev-run ------------------------------------------------------------------------- */

static int run_outside(const char *self)
{
	static const char *const files[] = {"device", "answers", "events"};
	char folder[] = "/tmp/stilb-window-pads-XXXXXX", arguments[EVDEV_PADS][3][128];
	const char *words[2 + 6 * EVDEV_PADS + 3] = {UMOCKDEV_RUN};
	size_t count = 1;
	if (!mkdtemp(folder))
		return 1;
	for (size_t i = 0; i < EVDEV_PADS; i++) {
		int event = evdev_pads[i].event;
		write_pad(folder, &evdev_pads[i]);
		snprintf(arguments[i][0], sizeof arguments[i][0], "%s/device%d", folder, event);
		for (int k = 1; k < 3; k++)
			snprintf(arguments[i][k], sizeof arguments[i][k], "/dev/input/event%d=%s/%s%d", event, folder, files[k],
			         event);
		for (int k = 0; k < 3; k++) {
			words[count++] = (const char *const[]){"-d", "-i", "-e"}[k];
			words[count++] = arguments[i][k];
		}
	}
	words[count++] = "--";
	words[count++] = self;
	program_run run;
	if (program_start(&run, words, NULL, -1))
		program_wait(&run);
	printf("%s", run.out);
	fprintf(stderr, "%s", run.err);
	for (size_t i = 0; i < EVDEV_PADS; i++)
		for (int k = 0; k < 3; k++) {
			char path[128];
			snprintf(path, sizeof path, "%s/%s%d", folder, files[k], evdev_pads[i].event);
			unlink(path);
		}
	rmdir(folder);
	return run.code;
}

int main(int argc, char **argv)
{
	(void)argc;
	if (umockdev_root())
		return run_inside();
	if (!getenv("DISPLAY")) {
		printf("no X display: set DISPLAY, or install xvfb and use ./dev test\n");
		return 77;
	}
	if (!umockdev_is_installed()) {
		printf("skipped: no umockdev-run; the package umockdev has it\n");
		return 77;
	}
	return run_outside(argv[0]);
}
