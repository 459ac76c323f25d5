/* input_window: the window library's gamepads as states and events, and never a second time beside the same pad read
 * directly. */
#include "input/input_window.h"
#include "support/input_descriptors.h"
#include "support/test.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#define MS 1000
#define NEAR(a, b) assert_float_equal(a, b, 1e-6f)

/* GUIDs of gamepads as GLFW 3.3.8 writes them. */
#define GUID_XBOX_USB "030000005e0400008e02000010010000" /* xpad: no hidraw node */
#define GUID_XBOX_BLUETOOTH "050000005e040000fd02000003090000"
#define GUID_DS4_USB "030000004c050000c405000011810000"
#define GUID_DS4_BLUETOOTH "050000004c050000c405000000810000"
#define GUID_NAMELESS "03000000576972656c65737320436f00" /* no version: "Wireless Co" in place of the numbers */

static stilb_input_control *control;
static stilb_input_window window;
static stilb_window_gamepad gamepads[STILB_WINDOW_GAMEPADS];
static int64_t now_us;

static int set_up(void **state)
{
	(void)state;
	stilb_input_control_settings settings = stilb_input_control_settings_default();
	window = (stilb_input_window){0};
	memset(gamepads, 0, sizeof gamepads);
	now_us = 5000000;
	return stilb_input_control_create(&settings, &(stilb_input_pose){0}, now_us, &control);
}

static int tear_down(void **state)
{
	(void)state;
	stilb_input_control_destroy(control);
	return 0;
}

static stilb_window_gamepad at_rest(const char *guid, const char *name)
{
	return (stilb_window_gamepad){.name = name, .guid = guid, .axes = {0, 0, 0, 0, -1, -1}};
}

static void feed(int64_t later_us)
{
	now_us += later_us;
	stilb_input_window_feed(&window, gamepads, now_us, control);
}

/* The control's pads now; a pad read directly has a path in /dev. */
static uint32_t pads(stilb_input_control_pad out[STILB_INPUT_PADS_MAX])
{
	return stilb_input_control_pads(control, out);
}

static void direct(stilb_input_event_kind kind, uint32_t pad, uint16_t bus, uint16_t vendor, uint16_t product)
{
	stilb_input_pad_info info = {
		.path = "/dev/hidraw3", .name = "Wireless Controller", .bus = bus, .vendor = vendor, .product = product};
	const input_test_descriptor *descriptor = input_test_descriptor_find(bus, vendor, product);
	assert_non_null(descriptor);
	info.descriptor_size = (uint16_t)descriptor->size;
	memcpy(info.descriptor, descriptor->bytes, descriptor->size);
	stilb_input_control_event(control,
	                          &(stilb_input_event){.kind = kind, .pad = pad, .time_us = now_us, .info = &info});
}

/* ---- states ------------------------------------------------------------------------------------------------------ */

static void a_pad_at_rest_is_all_zero(void **state)
{
	(void)state;
	stilb_window_gamepad gamepad = at_rest(GUID_XBOX_USB, "X");
	stilb_input_pad_state got = stilb_input_window_state(&gamepad), rest = {0};
	assert_memory_equal(&got, &rest, sizeof got); /* no -0 either */
}

static void sticks_point_up_and_triggers_begin_at_zero(void **state)
{
	(void)state;
	stilb_window_gamepad gamepad = {.axes = {0.25f, 0.5f, -0.75f, -1.0f, 0.0f, 1.0f}};
	stilb_input_pad_state got = stilb_input_window_state(&gamepad);
	NEAR(got.axes[STILB_INPUT_LEFT_X], 0.25f);
	NEAR(got.axes[STILB_INPUT_LEFT_Y], -0.5f);
	NEAR(got.axes[STILB_INPUT_RIGHT_X], -0.75f);
	NEAR(got.axes[STILB_INPUT_RIGHT_Y], 1.0f);
	NEAR(got.axes[STILB_INPUT_LEFT_TRIGGER], 0.5f);
	NEAR(got.axes[STILB_INPUT_RIGHT_TRIGGER], 1.0f);
}

/* GLFW's buttons in the order of glfw3.h; it has none for STILB_INPUT_EXTRA. */
static void each_button_has_its_place(void **state)
{
	(void)state;
	static const stilb_input_button buttons[15] = {
		STILB_INPUT_SOUTH,          STILB_INPUT_EAST, STILB_INPUT_WEST,  STILB_INPUT_NORTH, STILB_INPUT_LEFT_SHOULDER,
		STILB_INPUT_RIGHT_SHOULDER, STILB_INPUT_BACK, STILB_INPUT_START, STILB_INPUT_GUIDE, STILB_INPUT_LEFT_STICK,
		STILB_INPUT_RIGHT_STICK,    STILB_INPUT_UP,   STILB_INPUT_RIGHT, STILB_INPUT_DOWN,  STILB_INPUT_LEFT};
	for (uint32_t b = 0; b < 15; b++) {
		stilb_window_gamepad gamepad = {.buttons = 1u << b};
		assert_int_equal(stilb_input_window_state(&gamepad).buttons, 1u << buttons[b]);
	}
	stilb_window_gamepad all = {.buttons = UINT32_MAX};
	assert_int_equal(stilb_input_window_state(&all).buttons,
	                 (1u << STILB_INPUT_BUTTON_COUNT) - 1 - (1u << STILB_INPUT_EXTRA));
}

/* ---- which is which ---------------------------------------------------------------------------------------------- */

static bool same(const char *guid, const char *name, uint16_t bus, uint16_t vendor, uint16_t product,
                 const char *direct_name)
{
	stilb_input_pad_info info = {.bus = bus, .vendor = vendor, .product = product};
	snprintf(info.name, sizeof info.name, "%s", direct_name);
	return stilb_input_window_same(guid, name, &info);
}

static void guids_say_which_pad_it_is(void **state)
{
	(void)state;
	assert_true(same(GUID_DS4_USB, "Sony Wireless Controller", 3, 0x054c, 0x05c4, "Wireless Controller"));
	assert_false(
		same(GUID_DS4_USB, "Wireless Controller", 5, 0x054c, 0x05c4, "Wireless Controller")); /* over Bluetooth */
	assert_true(same(GUID_DS4_BLUETOOTH, "Wireless Controller", 5, 0x054c, 0x05c4, ""));
	assert_false(same(GUID_DS4_USB, "DUALSHOCK", 3, 0x054c, 0x0ce6, "DualSense"));
	assert_false(same(GUID_XBOX_USB, "X-Box 360 pad", 3, 0x054c, 0x028e, "X-Box 360 pad"));
	/* A driver has changed the product, the name stayed. */
	assert_true(same(GUID_XBOX_BLUETOOTH, "Xbox Wireless Controller", 5, 0x045e, 0x0b13, "Xbox Wireless Controller"));
	assert_false(same(GUID_XBOX_BLUETOOTH, "Xbox Wireless Controller", 5, 0x045e, 0x0b13, ""));
	/* No numbers: the name alone, and what the kernel appends to it. */
	assert_true(same(GUID_NAMELESS, "Wireless Co Gamepad", 3, 0x1234, 0x0001, "Wireless Co"));
	assert_false(same(GUID_NAMELESS, "Wireless Co", 3, 0x1234, 0x0001, "Wireless Co 2"));
	assert_false(same(GUID_NAMELESS, "Wireless Co", 3, 0x1234, 0x0001, ""));
	assert_false(same("", "a", 3, 0, 0, "b"));
	assert_false(same("zz", "a", 3, 0, 0, "b"));
}

/* ---- events ------------------------------------------------------------------------------------------------------ */

static void a_pad_comes_acts_and_goes(void **state)
{
	(void)state;
	stilb_input_control_pad now[STILB_INPUT_PADS_MAX];
	gamepads[3] = at_rest(GUID_XBOX_USB, "Microsoft X-Box 360 pad");
	feed(0);
	feed(STILB_INPUT_WINDOW_WAIT_US - 1);
	assert_int_equal(pads(now), 0); /* not added yet: input_pads may still open it directly */
	feed(1);
	assert_int_equal(pads(now), 1);
	assert_string_equal(now[0].info->path, "window:3");
	assert_string_equal(now[0].name, "Microsoft X-Box 360 pad");
	assert_int_equal(now[0].info->bus, STILB_INPUT_BUS_USB);
	assert_int_equal(now[0].info->vendor, 0x045e);
	assert_int_equal(now[0].info->product, 0x028e);
	assert_false(now[0].denied || now[0].leads);
	uint32_t number = now[0].pad;

	gamepads[3].axes[1] = -1.0f; /* ahead */
	feed(4 * MS);
	assert_int_equal(pads(now), 1);
	assert_true(now[0].leads);
	NEAR(now[0].state.axes[STILB_INPUT_LEFT_Y], 1.0f);
	assert_int_equal(now[0].last_us, now_us);
	feed(4 * MS); /* nothing changed: no event */
	pads(now);
	assert_int_equal(now[0].last_us, now_us - 4 * MS);

	gamepads[3] = (stilb_window_gamepad){0};
	feed(4 * MS);
	assert_int_equal(pads(now), 0);
	assert_int_equal(stilb_input_control_leader(control, NULL), 0);

	gamepads[3] = at_rest(GUID_XBOX_USB, "Microsoft X-Box 360 pad"); /* plugged in again: another number */
	feed(4 * MS);
	feed(STILB_INPUT_WINDOW_WAIT_US);
	assert_int_equal(pads(now), 1);
	assert_true(now[0].pad != number);
}

static void another_pad_at_the_same_place(void **state)
{
	(void)state;
	stilb_input_control_pad now[STILB_INPUT_PADS_MAX];
	gamepads[0] = at_rest(GUID_XBOX_USB, "first");
	feed(0);
	feed(STILB_INPUT_WINDOW_WAIT_US);
	gamepads[0] = at_rest(GUID_DS4_USB, "second");
	feed(4 * MS);
	assert_int_equal(pads(now), 0);
	feed(STILB_INPUT_WINDOW_WAIT_US);
	assert_int_equal(pads(now), 1);
	assert_string_equal(now[0].name, "second");
}

/* One pad that can be read in two ways: whichever comes first, the direct one stays. */
static void a_pad_never_appears_twice(void **state)
{
	(void)state;
	stilb_input_control_pad now[STILB_INPUT_PADS_MAX];
	gamepads[0] = at_rest(GUID_DS4_USB, "Wireless Controller");
	gamepads[1] = at_rest(GUID_XBOX_USB, "Microsoft X-Box 360 pad");
	direct(STILB_INPUT_PAD_ADDED, 1, STILB_INPUT_BUS_USB, 0x054c, 0x05c4);
	feed(0);
	feed(STILB_INPUT_WINDOW_WAIT_US);
	assert_int_equal(pads(now), 2);
	for (uint32_t i = 0; i < 2; i++)
		assert_string_equal(now[i].info->path, now[i].pad == 1 ? "/dev/hidraw3" : "window:1");

	direct(STILB_INPUT_PAD_REMOVED, 1, STILB_INPUT_BUS_USB, 0x054c, 0x05c4); /* as if its udev rule was removed */
	feed(4 * MS);
	assert_int_equal(pads(now), 2); /* the library's pad has been there for the waiting time already */
	direct(STILB_INPUT_PAD_ADDED, 2, STILB_INPUT_BUS_USB, 0x054c, 0x05c4);
	feed(4 * MS);
	assert_int_equal(pads(now), 2);
	for (uint32_t i = 0; i < 2; i++)
		assert_string_equal(now[i].info->path, now[i].pad == 2 ? "/dev/hidraw3" : "window:1");
}

/* A pad whose hidraw node may not be opened is read through the window's library. */
static void a_denied_pad_is_read_through_the_window(void **state)
{
	(void)state;
	stilb_input_control_pad now[STILB_INPUT_PADS_MAX];
	gamepads[0] = at_rest(GUID_DS4_USB, "Wireless Controller");
	direct(STILB_INPUT_PAD_DENIED, 1, STILB_INPUT_BUS_USB, 0x054c, 0x05c4);
	feed(0);
	feed(STILB_INPUT_WINDOW_WAIT_US);
	assert_int_equal(pads(now), 2);
	direct(STILB_INPUT_PAD_REMOVED, 1, STILB_INPUT_BUS_USB, 0x054c, 0x05c4); /* permission came */
	direct(STILB_INPUT_PAD_ADDED, 2, STILB_INPUT_BUS_USB, 0x054c, 0x05c4);
	feed(4 * MS);
	assert_int_equal(pads(now), 1);
	assert_string_equal(now[0].info->path, "/dev/hidraw3");
	assert_false(now[0].denied);
}

static void all_places_at_once(void **state)
{
	(void)state;
	stilb_input_control_pad now[STILB_INPUT_PADS_MAX];
	for (int i = 0; i < STILB_WINDOW_GAMEPADS; i++)
		gamepads[i] = at_rest(i % 2 ? GUID_XBOX_USB : GUID_DS4_BLUETOOTH, "equal");
	feed(0);
	feed(STILB_INPUT_WINDOW_WAIT_US);
	assert_int_equal(pads(now), STILB_INPUT_PADS_MAX);
	for (uint32_t i = 0; i < STILB_INPUT_PADS_MAX; i++)
		for (uint32_t k = 0; k < i; k++)
			assert_true(now[i].pad != now[k].pad);
	direct(STILB_INPUT_PAD_ADDED, 1, STILB_INPUT_BUS_BLUETOOTH, 0x054c, 0x05c4); /* no free entry: it is ignored */
	feed(4 * MS);
	assert_int_equal(pads(now), STILB_INPUT_PADS_MAX);
	memset(gamepads, 0, sizeof gamepads);
	feed(4 * MS);
	assert_int_equal(pads(now), 0);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
	struct CMUnitTest tests[] = {
		TEST(a_pad_at_rest_is_all_zero), TEST(sticks_point_up_and_triggers_begin_at_zero),
		TEST(each_button_has_its_place), TEST(guids_say_which_pad_it_is),
		TEST(a_pad_comes_acts_and_goes), TEST(another_pad_at_the_same_place),
		TEST(a_pad_never_appears_twice), TEST(a_denied_pad_is_read_through_the_window),
		TEST(all_places_at_once),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
