/* input_control: pads, keys and mouse together: what each stick and button does, which pad leads (was touched last),
 * what is pressed, when the camera stands still, and the same path at every frame rate from the same reports. */
#include "actions.h"
#include "input/hid/input_layout.h"
#include "input/input_control.h"
#include "support/input_descriptors.h"
#include "support/test.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#define SECOND 1000000
#define BUTTON(name) (1u << STILB_INPUT_##name)

/* ---- a control that is spoken to --------------------------------------------------------------------------------- */

static stilb_input_table table;

/* The camera follows at once, the stick's response is linear, and the triggers double and halve once. */
static stilb_input_control_settings plain_settings(void)
{
	return (stilb_input_control_settings){
		.camera = {.speed = 1.0f, .turn_rate = 1.0f},
		.inner = 0.1f,
		.outer = 1.0f,
		.curve = 1.0f,
		.sensitivity = {1.0f, 1.0f, 1.0f, 1.0f},
		.boost = 1.0f,
		.table = &table,
	};
}

static stilb_input_control *control;
static const stilb_input_state no_keys;
static stilb_input_state out; /* the output of the last stilb_input_control_frame, as is `pose` */
static stilb_input_pose pose;

static int begin_with(const stilb_input_control_settings *settings)
{
	stilb_input_control_destroy(control);
	return stilb_input_control_create(settings, &(stilb_input_pose){{0}, 0, 0}, 0, &control) != STILB_OK;
}

static int begin(void **state)
{
	(void)state;
	stilb_input_control_settings settings = plain_settings();
	return begin_with(&settings);
}

static int end(void **state)
{
	(void)state;
	stilb_input_control_destroy(control);
	control = NULL;
	return 0;
}

/* A pad that the window library reads, which needs no descriptor. */
static void plug(uint32_t pad, int64_t time_us)
{
	stilb_input_pad_info info = {.path = "window:0", .name = "Made-up Pad"};
	stilb_input_control_event(
		control, &(stilb_input_event){.kind = STILB_INPUT_PAD_ADDED, .pad = pad, .time_us = time_us, .info = &info});
}

static void pull(uint32_t pad, int64_t time_us)
{
	stilb_input_control_event(control,
	                          &(stilb_input_event){.kind = STILB_INPUT_PAD_REMOVED, .pad = pad, .time_us = time_us});
}

static void touch(uint32_t pad, int64_t time_us, stilb_input_pad_state state)
{
	stilb_input_control_event(
		control, &(stilb_input_event){.kind = STILB_INPUT_PAD_STATE, .pad = pad, .time_us = time_us, .state = state});
}

static void press(uint32_t pad, int64_t time_us, uint32_t buttons)
{
	touch(pad, time_us, (stilb_input_pad_state){.buttons = buttons});
}

static void push(uint32_t pad, int64_t time_us, stilb_input_axis axis, float value)
{
	stilb_input_pad_state state = {0};
	state.axes[axis] = value;
	touch(pad, time_us, state);
}

static void frame_with(int64_t time_us, stilb_input_state keys)
{
	stilb_input_control_frame(control, time_us, &keys, true, &out, &pose);
}

static void frame(int64_t time_us)
{
	frame_with(time_us, no_keys);
}

static void assert_pose(float x, float y, float z, float yaw, float pitch)
{
	float wanted[5] = {x, y, z, yaw, pitch};
	float is[5] = {pose.position[0], pose.position[1], pose.position[2], pose.yaw, pose.pitch};
	for (int i = 0; i < 5; i++)
		if (!(fabsf(is[i] - wanted[i]) <= 1e-5f))
			fail_msg("%g %g %g, %g %g is not %g %g %g, %g %g", (double)is[0], (double)is[1], (double)is[2],
			         (double)is[3], (double)is[4], (double)x, (double)y, (double)z, (double)yaw, (double)pitch);
}

static uint32_t leader(void)
{
	return stilb_input_control_leader(control, NULL);
}

/* ---- the mapping ------------------------------------------------------------------------------------------------- */

static void test_sticks_and_triggers(void **state)
{
	static const struct {
		stilb_input_pad_state pad;
		float x, y, z, yaw, pitch; /* the camera's expected pose after a second */
	} rows[] = {
		{{.axes = {[STILB_INPUT_LEFT_X] = 1}}, 1, 0, 0, 0, 0},
		{{.axes = {[STILB_INPUT_LEFT_X] = -1}}, -1, 0, 0, 0, 0},
		{{.axes = {[STILB_INPUT_LEFT_Y] = 1}}, 0, 0, -1, 0, 0}, /* stick up is forward */
		{{.axes = {[STILB_INPUT_LEFT_Y] = -1}}, 0, 0, 1, 0, 0},
		{{.axes = {[STILB_INPUT_LEFT_X] = 0.55f}}, 0.5f, 0, 0, 0, 0},
		{{.axes = {[STILB_INPUT_LEFT_X] = 0.09f, [STILB_INPUT_RIGHT_Y] = -0.09f}}, 0, 0, 0, 0, 0},
		{{.axes = {[STILB_INPUT_RIGHT_X] = 1}}, 0, 0, 0, -1, 0},
		{{.axes = {[STILB_INPUT_RIGHT_X] = -1}}, 0, 0, 0, 1, 0},
		{{.axes = {[STILB_INPUT_RIGHT_Y] = 1}}, 0, 0, 0, 0, 1},
		{{.axes = {[STILB_INPUT_RIGHT_Y] = -1}}, 0, 0, 0, 0, -1},
		{{.buttons = BUTTON(RIGHT_SHOULDER)}, 0, 1, 0, 0, 0},
		{{.buttons = BUTTON(LEFT_SHOULDER)}, 0, -1, 0, 0, 0},
		{{.buttons = BUTTON(LEFT_SHOULDER) | BUTTON(RIGHT_SHOULDER)}, 0, 0, 0, 0, 0},
		{{.axes = {[STILB_INPUT_LEFT_X] = 1, [STILB_INPUT_RIGHT_TRIGGER] = 1}}, 2, 0, 0, 0, 0},
		{{.axes = {[STILB_INPUT_LEFT_X] = 1, [STILB_INPUT_LEFT_TRIGGER] = 1}}, 0.5f, 0, 0, 0, 0},
		{{.axes = {[STILB_INPUT_LEFT_X] = 1, [STILB_INPUT_RIGHT_TRIGGER] = 0.525f}}, 1.41421356f, 0, 0, 0, 0},
		{{.axes = {[STILB_INPUT_LEFT_X] = 1, [STILB_INPUT_RIGHT_TRIGGER] = 0.04f}}, 1, 0, 0, 0, 0}, /* dead zone */
		{{.axes = {[STILB_INPUT_LEFT_X] = 1, [STILB_INPUT_LEFT_TRIGGER] = 1, [STILB_INPUT_RIGHT_TRIGGER] = 1}},
	     1,
	     0,
	     0,
	     0,
	     0},
	};
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
		assert_int_equal(begin(state), 0);
		plug(1, 0);
		touch(1, 0, rows[i].pad);
		frame(SECOND);
		assert_pose(rows[i].x, rows[i].y, rows[i].z, rows[i].yaw, rows[i].pitch);
	}
}

static void test_settings(void **state)
{
	(void)state;
	stilb_input_control_settings settings = stilb_input_control_settings_default();
	assert_true(settings.inner == 0.12f && settings.outer == 0.95f && settings.curve == 2.0f && settings.boost == 3.0f);
	assert_true(settings.camera.speed == 12.0f && !settings.invert_y && settings.sensitivity[3] == 1.0f);
	settings = plain_settings();
	settings.invert_y = true;
	settings.sensitivity[0] = 0.5f;
	settings.sensitivity[2] = 2.0f;
	settings.sensitivity[3] = 0.25f;
	settings.boost = 3.0f;
	assert_int_equal(begin_with(&settings), 0);
	plug(1, 0);
	push(1, 0, STILB_INPUT_LEFT_X, 1);
	frame(SECOND);
	assert_pose(0.5f, 0, 0, 0, 0);
	push(1, SECOND, STILB_INPUT_RIGHT_Y, 1);
	frame(2 * SECOND);
	assert_pose(0.5f, 0, 0, 0, -0.25f);
	push(1, 2 * SECOND, STILB_INPUT_RIGHT_X, -1);
	frame(3 * SECOND);
	assert_pose(0.5f, 0, 0, 2.0f, -0.25f);
	touch(1, 3 * SECOND,
	      (stilb_input_pad_state){.axes = {[STILB_INPUT_RIGHT_TRIGGER] = 1}, .buttons = BUTTON(RIGHT_SHOULDER)});
	frame(4 * SECOND);
	assert_pose(0.5f, 8.0f, 0, 2.0f, -0.25f);
}

static void test_keys_and_pad_add_up(void **state)
{
	(void)state;
	stilb_input_state ahead = {.move = {0, 0, 1}};
	plug(1, 0);
	push(1, 0, STILB_INPUT_LEFT_X, 0.55f);
	frame_with(0, ahead);
	assert_pose(0, 0, 0, 0, 0);
	assert_float_equal(out.move[0], 0.5f, 1e-6f); /* the frame's output has the movement, too */
	assert_true(out.move[2] == 1.0f);
	frame_with(SECOND / 10, ahead);
	float s = 0.1f / hypotf(1.0f, 0.5f); /* stick and key together fly no faster than one */
	assert_pose(0.5f * s, 0, -s, 0, 0);
	push(1, SECOND / 10, STILB_INPUT_LEFT_Y, -1); /* stick back and key ahead cancel each other */
	frame_with(SECOND / 5, ahead);
	assert_pose(0.5f * s, 0, -s, 0, 0);
}

static void test_fast_keys(void **state)
{
	(void)state;
	stilb_input_state fast = {.move = {1, 0, 0}, .actions = {[STILB_INPUT_FASTER] = 1}};
	frame_with(0, fast);
	frame_with(SECOND / 10, fast);
	assert_pose(0.1f * STILB_INPUT_FAST, 0, 0, 0, 0);
}

static void test_mouse(void **state)
{
	(void)state;
	frame_with(0, (stilb_input_state){.look = {0.25f, -0.5f}});
	assert_pose(0, 0, 0, 0.25f, -0.5f);
	frame(SECOND); /* the mouse's movement is applied only once */
	assert_pose(0, 0, 0, 0.25f, -0.5f);
}

/* ---- actions ----------------------------------------------------------------------------------------------------- */

static void assert_actions(stilb_input_state wanted)
{
	for (uint32_t row = STILB_INPUT_ACTIONS; row < STILB_INPUT_ACTIONS_MAX; row++)
		assert_int_equal(out.actions[row], wanted.actions[row]);
}

static void test_buttons(void **state)
{
	static const struct {
		stilb_input_button button;
		stilb_input_state wanted;
	} rows[STILB_INPUT_BUTTON_COUNT] = {
		{STILB_INPUT_SOUTH, {.actions = {[FREEZE] = 1}}},
		{STILB_INPUT_EAST, {.actions = {[NEXT_VIEW] = 1}}},
		{STILB_INPUT_WEST, {.actions = {[CAPTURE] = 1}}},
		{STILB_INPUT_NORTH, {.actions = {[OVERLAY] = 1}}},
		{STILB_INPUT_LEFT_SHOULDER, {.actions = {0}}},
		{STILB_INPUT_RIGHT_SHOULDER, {.actions = {0}}},
		{STILB_INPUT_BACK, {.actions = {[SCREENSHOT] = 1}}},
		{STILB_INPUT_START, {.actions = {[INSPECTOR] = 1}}},
		{STILB_INPUT_GUIDE, {.actions = {0}}},
		{STILB_INPUT_LEFT_STICK, {.actions = {0}}},
		{STILB_INPUT_RIGHT_STICK, {.actions = {0}}},
		{STILB_INPUT_UP, {.actions = {[MORE] = 1}}},
		{STILB_INPUT_DOWN, {.actions = {[FEWER] = 1}}},
		{STILB_INPUT_LEFT, {.actions = {[GRAB] = 1}}},
		{STILB_INPUT_RIGHT, {.actions = {[NEXT_VIEW] = 1}}},
		{STILB_INPUT_EXTRA, {.actions = {[OVERLAY] = 1}}},
	};
	for (int i = 0; i < STILB_INPUT_BUTTON_COUNT; i++) {
		assert_int_equal(begin(state), 0);
		assert_int_equal(rows[i].button, i);
		plug(1, 0);
		press(1, 10, 1u << i);
		frame(20);
		assert_actions(rows[i].wanted);
		press(1, 30, 1u << i); /* still held: a press acts only once */
		frame(40);
		assert_actions(i == STILB_INPUT_LEFT ? rows[i].wanted : no_keys);
		press(1, 50, 0); /* a release is not a press */
		frame(60);
		assert_actions(no_keys);
	}
}

static void test_presses_between_frames_count(void **state)
{
	(void)state;
	plug(1, 0);
	for (int i = 0; i < 3; i++) {
		press(1, 10 * i, BUTTON(EAST) | BUTTON(NORTH) | BUTTON(UP) | BUTTON(WEST));
		press(1, 10 * i + 5, 0);
	}
	press(1, 40, BUTTON(START) | BUTTON(SOUTH));
	press(1, 41, 0);
	press(1, 42, BUTTON(START) | BUTTON(SOUTH));
	press(1, 43, 0);
	frame(50);
	assert_actions((stilb_input_state){.actions = {[NEXT_VIEW] = 3, [OVERLAY] = 1, [MORE] = 3, [CAPTURE] = 3}});
	/* Actions of keys and pad are combined; a switch that both toggle stays as it was. */
	press(1, 60, BUTTON(NORTH) | BUTTON(DOWN) | BUTTON(RIGHT) | BUTTON(SOUTH));
	frame_with(70, (stilb_input_state){
					   .actions = {[OVERLAY] = 1, [INSPECTOR] = 1, [MORE] = 4, [NEXT_VIEW] = 2, [SCREENSHOT] = 1}});
	assert_actions((stilb_input_state){
		.actions = {[INSPECTOR] = 1, [MORE] = 4, [FEWER] = 1, [NEXT_VIEW] = 3, [SCREENSHOT] = 1, [FREEZE] = 1}});
	frame(80);
	assert_actions(no_keys);
	press(1, 90, 0);
	press(1, 91, BUTTON(NORTH) | BUTTON(EXTRA)); /* both buttons of a switch at once */
	frame(100);
	assert_actions(no_keys);
}

/* ---- who leads --------------------------------------------------------------------------------------------------- */

static void test_the_last_touched_leads(void **state)
{
	(void)state;
	plug(1, 0);
	plug(2, 0);
	assert_int_equal(leader(), 0);
	push(1, 10, STILB_INPUT_LEFT_X, 0.05f); /* noise of a stick is not a touch */
	assert_int_equal(leader(), 0);
	push(1, 20, STILB_INPUT_LEFT_X, 1);
	assert_int_equal(leader(), 1);
	press(2, 30, 0);
	push(2, 40, STILB_INPUT_RIGHT_TRIGGER, 0.09f);
	assert_int_equal(leader(), 1);
	push(2, 50, STILB_INPUT_RIGHT_TRIGGER, 0.2f);
	assert_int_equal(leader(), 2);
	/* The other pad is ignored until it is touched again; holding its stick still is not a touch. */
	frame(60);
	stilb_input_pose before = pose;
	for (int i = 0; i < 100; i++)
		push(1, 60 + i * 4000, STILB_INPUT_LEFT_X, i % 2 ? 1.0f : 0.95f);
	frame(SECOND);
	assert_int_equal(leader(), 2);
	assert_memory_equal(&pose, &before, sizeof pose);
	press(1, SECOND, BUTTON(WEST)); /* a press makes the pad lead, and its action is taken at once */
	frame(SECOND);
	assert_int_equal(leader(), 1);
	assert_true(out.actions[CAPTURE]);
	press(2, SECOND + 1, 0); /* letting go of a trigger makes the pad lead, too */
	assert_int_equal(leader(), 2);
}

static void test_drift_is_no_touch(void **state)
{
	(void)state;
	plug(1, 0);
	plug(2, 0);
	press(1, 0, BUTTON(GUIDE));
	press(2, 0, 0);
	for (int i = 0; i <= 100; i++) { /* a stick that creeps to its end in 20 s */
		push(2, i * SECOND / 5, STILB_INPUT_LEFT_X, (float)i * 0.01f);
		assert_int_equal(leader(), 1);
	}
	push(2, 20 * SECOND + 250000, STILB_INPUT_LEFT_X, 0.8f); /* the stick is moved by a hand: a touch */
	assert_int_equal(leader(), 2);
}

/* With a dead zone of 0 a stick's noise moves the camera, but is no touch that would make the pad lead. */
static void test_without_dead_zone(void **state)
{
	(void)state;
	stilb_input_control_settings settings = plain_settings();
	settings.inner = 0.0f;
	assert_int_equal(begin_with(&settings), 0);
	plug(1, 0);
	plug(2, 0);
	push(1, 0, STILB_INPUT_LEFT_X, 1);
	push(2, 10, STILB_INPUT_LEFT_X, 0);
	push(2, 20, STILB_INPUT_LEFT_X, 0.05f);
	assert_int_equal(leader(), 1);
	push(2, 30, STILB_INPUT_LEFT_X, 0.2f);
	assert_int_equal(leader(), 2);
}

/* The first report of a pad that is plugged in while another pad leads is not a touch, because the pad may lie on its
 * sticks; if no pad leads, it is a touch. */
static void test_first_report(void **state)
{
	(void)state;
	plug(1, 0);
	push(1, 0, STILB_INPUT_LEFT_X, 1);
	assert_int_equal(leader(), 1);
	plug(2, 10);
	touch(2, 20, (stilb_input_pad_state){.axes = {0, 1, -1, 1, 1, 1}, .buttons = BUTTON(WEST)});
	touch(2, 30, (stilb_input_pad_state){.axes = {0, 1, -1, 1, 1, 1}, .buttons = BUTTON(WEST)});
	frame(40);
	assert_int_equal(leader(), 1);
	assert_false(out.actions[CAPTURE]);
	press(2, 50, BUTTON(WEST));
	assert_int_equal(leader(), 2);
}

/* ---- standing still ---------------------------------------------------------------------------------------------- */

static void test_unplug_stops(void **state)
{
	(void)state;
	stilb_input_control_settings settings = stilb_input_control_settings_default(); /* with momentum */
	assert_int_equal(begin_with(&settings), 0);
	plug(1, 0);
	plug(2, 0);
	push(2, 0, STILB_INPUT_LEFT_X, 0.0f);
	touch(1, 0, (stilb_input_pad_state){.axes = {1, 1, 1, 1, 0, 1}});
	frame(SECOND / 2);
	pull(2, SECOND / 2); /* unplugs the pad that does not lead */
	assert_int_equal(leader(), 1);
	frame(SECOND);
	stilb_input_pose at_second = pose;
	pull(1, SECOND);
	assert_int_equal(leader(), 0);
	frame(2 * SECOND);
	assert_memory_equal(&pose, &at_second, sizeof pose); /* the camera stopped at once */
	stilb_input_state ahead = {.move = {0, 1, 0}};
	frame_with(2 * SECOND, ahead); /* the keyboard still works */
	frame_with(2 * SECOND + 90000, ahead);
	assert_true(pose.position[1] > at_second.position[1] + 0.1f && pose.position[0] == at_second.position[0]);
	frame(3 * SECOND);
	stilb_input_pose rest = pose;
	plug(3, 3 * SECOND); /* plugged in again, with another number */
	push(3, 3 * SECOND, STILB_INPUT_LEFT_X, 1);
	frame(4 * SECOND);
	assert_int_equal(leader(), 3);
	assert_true(pose.position[0] != rest.position[0]);
	touch(1, 4 * SECOND, (stilb_input_pad_state){.axes = {1}}); /* an event of a removed pad is ignored */
	assert_int_equal(leader(), 3);
}

static void test_keys_go_on_when_the_pad_is_pulled(void **state)
{
	(void)state;
	stilb_input_state right = {.move = {1, 0, 0}};
	plug(1, 0);
	push(1, 0, STILB_INPUT_LEFT_Y, 1);
	frame_with(0, right);
	pull(1, SECOND / 20);
	frame_with(SECOND / 10, right);
	float half = 0.05f * sqrtf(0.5f);
	assert_pose(half + 0.05f, 0, -half, 0, 0);
}

static void test_focus(void **state)
{
	(void)state;
	stilb_input_control_settings settings = stilb_input_control_settings_default();
	assert_int_equal(begin_with(&settings), 0);
	plug(1, 0);
	push(1, 0, STILB_INPUT_LEFT_X, 1);
	frame(SECOND);
	stilb_input_state keys = {.move = {0, 1, 0}, .look = {1, 1}};
	stilb_input_pose lost;
	stilb_input_control_frame(control, SECOND, &keys, false, &out, &lost);
	assert_memory_equal(&lost, &pose, sizeof pose);
	assert_true(out.move[0] == 0.0f && out.move[1] == 0.0f);
	touch(1, SECOND + 10, (stilb_input_pad_state){.axes = {1}, .buttons = BUTTON(WEST)});
	stilb_input_control_frame(control, 2 * SECOND, &keys, false, &out, &pose);
	assert_memory_equal(&lost, &pose, sizeof pose);
	assert_false(out.actions[CAPTURE]);
	frame(2 * SECOND); /* the focus is back: the stick moves the camera, presses made meanwhile are dropped */
	assert_false(out.actions[CAPTURE]);
	frame(3 * SECOND);
	assert_true(pose.position[0] > lost.position[0] + 10.0f);
}

/* During a stall keys count as released after 100 ms; a pad's reports have their own times. */
static void test_keys_end_in_a_stall(void **state)
{
	(void)state;
	stilb_input_state ahead = {.move = {0, 0, 1}};
	frame_with(0, ahead);
	frame_with(SECOND, ahead);
	assert_pose(0, 0, -0.1f, 0, 0);
	frame_with(SECOND + SECOND / 10, ahead); /* the next frame within 100 ms: held throughout */
	assert_pose(0, 0, -0.2f, 0, 0);
	plug(1, SECOND + SECOND / 10);
	push(1, 2 * SECOND, STILB_INPUT_LEFT_X, 1); /* reports come before the frame that ends the stall */
	frame_with(3 * SECOND, ahead);
	assert_pose(1, 0, -0.3f, 0, 0);
}

static void test_place(void **state)
{
	(void)state;
	stilb_input_control_settings settings = stilb_input_control_settings_default();
	assert_int_equal(begin_with(&settings), 0);
	plug(1, 0);
	touch(1, 0, (stilb_input_pad_state){.axes = {1, 1, 1, 1}});
	frame(SECOND);
	press(1, SECOND, 0);
	stilb_input_pose place = {.position = {0.1f, -1e5f, 3.3f}, .yaw = -3.1f, .pitch = 1.5f};
	stilb_input_control_place(control, SECOND, &place);
	for (int i = 0; i < 100; i++) {
		frame(SECOND + i * 16667);
		assert_memory_equal(&pose, &place, sizeof pose);
	}
	push(1, 3 * SECOND, STILB_INPUT_LEFT_X, 1);
	stilb_input_control_place(control, 3 * SECOND, &place); /* the held input goes on to move it, from rest */
	frame(3 * SECOND);
	assert_memory_equal(&pose, &place, sizeof pose);
	frame(4 * SECOND);
	stilb_input_pose flown = pose;
	stilb_input_control_place(control, 4 * SECOND, &place);
	frame(5 * SECOND);
	assert_true(pose.position[2] != place.position[2]);
	assert_memory_equal(&pose, &flown, sizeof pose);
}

/* ---- the list ---------------------------------------------------------------------------------------------------- */

static void add(uint32_t pad, stilb_input_event_kind kind, const stilb_input_pad_info *info)
{
	stilb_input_control_event(control, &(stilb_input_event){.kind = kind, .pad = pad, .info = info});
}

static stilb_input_pad_info info_of(uint16_t bus, uint16_t vendor, uint16_t product)
{
	const input_test_descriptor *descriptor = input_test_descriptor_find(bus, vendor, product);
	assert_non_null(descriptor);
	stilb_input_pad_info info = {.path = "/dev/hidraw3",
	                             .name = "Wireless Controller",
	                             .bus = bus,
	                             .vendor = vendor,
	                             .product = product,
	                             .descriptor_size = (uint16_t)descriptor->size};
	memcpy(info.descriptor, descriptor->bytes, descriptor->size);
	return info;
}

static void test_list(void **state)
{
	(void)state;
	stilb_input_control_pad pads[STILB_INPUT_PADS_MAX];
	assert_int_equal(stilb_input_control_pads(control, pads), 0);
	int64_t last_us = 77;
	assert_true(stilb_input_control_leader(control, &last_us) == 0 && last_us == 77);

	plug(5, 100);
	stilb_input_pad_info ds4 = info_of(STILB_INPUT_BUS_USB, 0x054c, 0x05c4);
	add(6, STILB_INPUT_PAD_DENIED, &ds4);
	stilb_input_pad_info broken = {.name = "Broken", .descriptor_size = 2, .descriptor = {0x26, 0x01}};
	add(7, STILB_INPUT_PAD_ADDED, &broken);
	push(5, 200, STILB_INPUT_LEFT_Y, -0.5f);
	assert_int_equal(stilb_input_control_pads(control, pads), 3);
	assert_int_equal(pads[0].pad, 5);
	assert_string_equal(pads[0].name, "Made-up Pad");
	assert_string_equal(pads[0].recognised, "by the window library");
	assert_string_equal(pads[0].info->path, "window:0");
	assert_true(pads[0].leads && !pads[0].denied && pads[0].reports == 1 && pads[0].corrupt == 0);
	assert_true(pads[0].last_us == 200 && pads[0].state.axes[STILB_INPUT_LEFT_Y] == -0.5f);
	assert_true(stilb_input_control_leader(control, &last_us) == 5 && last_us == 200);
	assert_true(pads[1].denied && !pads[1].leads && pads[1].pad == 6);
	assert_non_null(strstr(pads[1].name, "DualShock 4")); /* recognised without being opened */
	assert_string_equal(pads[2].name, "Broken");
	assert_true(strlen(pads[2].recognised) > 10); /* the reason why it has no layout */
	/* Reports of a pad without a layout are ignored. */
	stilb_input_control_event(control, &(stilb_input_event){.kind = STILB_INPUT_PAD_REPORT,
	                                                        .pad = 7,
	                                                        .time_us = 300,
	                                                        .bytes = (const uint8_t *)"\1\377\377",
	                                                        .size = 3});
	assert_int_equal(leader(), 5);

	pull(6, 350); /* the permission came: it is added under another number */
	add(8, STILB_INPUT_PAD_ADDED, &ds4);
	assert_int_equal(stilb_input_control_pads(control, pads), 3);
	assert_false(pads[1].denied);
	pull(5, 400);
	assert_int_equal(stilb_input_control_pads(control, pads), 2);
	pull(5, 500);
	pull(4711, 500);
	press(4711, 600, BUTTON(WEST));
	frame(700);
	assert_false(out.actions[CAPTURE]);
	assert_int_equal(stilb_input_control_pads(control, pads), 2);
}

static void test_too_many(void **state)
{
	(void)state;
	stilb_input_control_pad pads[STILB_INPUT_PADS_MAX];
	for (uint32_t pad = 1; pad <= STILB_INPUT_PADS_MAX + 4; pad++)
		plug(pad, 0);
	assert_int_equal(stilb_input_control_pads(control, pads), STILB_INPUT_PADS_MAX);
	press(STILB_INPUT_PADS_MAX + 1, 10, BUTTON(WEST));
	assert_int_equal(leader(), 0);
	press(STILB_INPUT_PADS_MAX, 20, BUTTON(WEST));
	assert_int_equal(leader(), STILB_INPUT_PADS_MAX);
}

/* ---- real reports ------------------------------------------------------------------------------------------------ */

static void report(uint32_t pad, int64_t time_us, const uint8_t *bytes, size_t size)
{
	stilb_input_control_event(
		control,
		&(stilb_input_event){
			.kind = STILB_INPUT_PAD_REPORT, .pad = pad, .time_us = time_us, .bytes = bytes, .size = (uint32_t)size});
}

/* A DualShock 4's sticks, 0..255, up is 0. */
typedef struct ds4_sticks {
	uint8_t lx, ly, rx, ry;
} ds4_sticks;

static const ds4_sticks ds4_rest = {128, 128, 128, 128};

static void ds4_usb(uint8_t bytes[64], ds4_sticks sticks)
{
	memset(bytes, 0, 64);
	uint8_t head[] = {0x01, sticks.lx, sticks.ly, sticks.rx, sticks.ry, 0x08};
	memcpy(bytes, head, sizeof head);
}

static void ds4_bluetooth(uint8_t bytes[78], ds4_sticks sticks)
{
	memset(bytes, 0, 78);
	uint8_t head[] = {0x11, 0xc0, 0x00, sticks.lx, sticks.ly, sticks.rx, sticks.ry, 0x08};
	memcpy(bytes, head, sizeof head);
	uint8_t seed = 0xa1;
	uint32_t crc = stilb_input_crc32(stilb_input_crc32(0, &seed, 1), bytes, 74);
	for (int i = 0; i < 4; i++)
		bytes[74 + i] = (uint8_t)(crc >> 8 * i);
}

static void test_corrupt_reports_move_nothing(void **state)
{
	(void)state;
	stilb_input_pad_info info = info_of(STILB_INPUT_BUS_BLUETOOTH, 0x054c, 0x05c4);
	add(1, STILB_INPUT_PAD_ADDED, &info);
	uint8_t bytes[78];
	ds4_bluetooth(bytes, ds4_rest);
	report(1, 0, bytes, sizeof bytes);
	for (int i = 1; i <= 10; i++) {
		ds4_bluetooth(bytes, (ds4_sticks){255, 0, 255, 0});
		bytes[i % 2 ? 74 + i % 4 : 3 + i] ^= (uint8_t)(1u << i % 8); /* in the CRC and in the bytes it covers */
		report(1, i * 4000, bytes, sizeof bytes);
		frame(i * 4000);
	}
	frame(SECOND);
	assert_pose(0, 0, 0, 0, 0);
	assert_int_equal(leader(), 0);
	stilb_input_control_pad pads[STILB_INPUT_PADS_MAX];
	assert_int_equal(stilb_input_control_pads(control, pads), 1);
	assert_true(pads[0].corrupt == 10 && pads[0].reports == 1 && pads[0].last_us == 0);
	ds4_bluetooth(bytes, (ds4_sticks){255, 128, 128, 128});
	report(1, SECOND, bytes, sizeof bytes); /* a valid report moves the camera */
	frame(2 * SECOND);
	assert_pose(1, 0, 0, 0, 0);
}

/* ---- the path ---------------------------------------------------------------------------------------------------- */

#define SECONDS 4
#define REPORTS (SECONDS * 250)

typedef struct timed_report {
	int64_t time_us;
	uint8_t bytes[64];
} timed_report;

/* Two sticks that rotate at different rates, at some 250 reports a second with jitter; at rest now and then. */
static void record(timed_report reports[REPORTS])
{
	for (int i = 0; i < REPORTS; i++) {
		double t = i * 0.004;
		bool rest = i % 250 > 200;
		ds4_sticks sticks = {
			(uint8_t)(128 + (rest ? 0 : 127 * sin(3.0 * t))), (uint8_t)(128 + (rest ? 0 : 127 * cos(4.1 * t))),
			(uint8_t)(128 + (rest ? 0 : 127 * sin(1.7 * t))), (uint8_t)(128 + (rest ? 0 : 60 * cos(2.3 * t)))};
		ds4_usb(reports[i].bytes, sticks);
		reports[i].bytes[8] = (uint8_t)(rest ? 0 : i % 256); /* a trigger that is pulled again and again */
		reports[i].time_us = i * 4000 + (int64_t)(stilb_random_u64(3, (uint64_t)i) % 3000);
	}
}

/* The time of the frame after this one; the last frame is at SECONDS. */
typedef int64_t next_frame(int64_t time_us, uint64_t frame, int rate);

static int64_t next_at_rate(int64_t time_us, uint64_t frame, int rate)
{
	(void)time_us;
	return (int64_t)(frame + 1) * SECOND / rate;
}

/* Frames of random length between 0 and 40 ms, every thirtieth half a second longer; there is a frame at each whole
 * second. */
static int64_t next_at_odd_times(int64_t time_us, uint64_t frame, int rate)
{
	(void)rate;
	int64_t step = frame % 30 == 29 ? SECOND / 2 : (int64_t)(stilb_random_u64(11, frame) % 40000);
	int64_t second = (time_us / SECOND + 1) * SECOND;
	return time_us + step < second ? time_us + step : second;
}

/* Gives the reports to a control, with frames at the times of `next`; poses[i] is the pose after i + 1 seconds. */
static void play(const timed_report reports[REPORTS], next_frame *next, int rate, stilb_input_pose poses[SECONDS])
{
	stilb_input_control_settings settings = stilb_input_control_settings_default();
	assert_int_equal(begin_with(&settings), 0);
	stilb_input_pad_info info = info_of(STILB_INPUT_BUS_USB, 0x054c, 0x05c4);
	stilb_input_control_event(control, &(stilb_input_event){.kind = STILB_INPUT_PAD_ADDED, .pad = 1, .info = &info});
	int report_next = 0;
	int64_t time = 0;
	for (uint64_t n = 0; time < SECONDS * SECOND; n++) {
		time = next(time, n, rate);
		for (; report_next < REPORTS && reports[report_next].time_us <= time; report_next++)
			report(1, reports[report_next].time_us, reports[report_next].bytes, sizeof reports->bytes);
		frame(time);
		int64_t last_us;
		if (stilb_input_control_leader(control, &last_us))
			assert_true(time - last_us < 7000); /* however late the frame, the leader's last report is recent */
		if (time % SECOND == 0)
			poses[time / SECOND - 1] = pose;
	}
}

static void test_path_is_the_same_at_every_rate(void **state)
{
	(void)state;
	static timed_report reports[REPORTS];
	record(reports);
	stilb_input_pose wanted[SECONDS], poses[SECONDS];
	play(reports, next_at_rate, 60, wanted);
	for (int i = 1; i < SECONDS; i++)
		assert_true(fabsf(wanted[i].position[0] - wanted[i - 1].position[0]) > 0.1f &&
		            wanted[i].yaw != wanted[i - 1].yaw);
	static const int rates[] = {60, 20, 30, 144, 1000};
	for (size_t i = 0; i < sizeof rates / sizeof *rates; i++) {
		play(reports, next_at_rate, rates[i], poses);
		assert_memory_equal(poses, wanted, sizeof poses);
	}
	play(reports, next_at_odd_times, 0, poses);
	assert_memory_equal(poses, wanted, sizeof poses);
}

static int make_table(void **state)
{
	(void)state;
	table = action_table();
	return table.count == END ? 0 : -1;
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test_setup_teardown(test_sticks_and_triggers, begin, end),
		cmocka_unit_test_setup_teardown(test_settings, begin, end),
		cmocka_unit_test_setup_teardown(test_keys_and_pad_add_up, begin, end),
		cmocka_unit_test_setup_teardown(test_fast_keys, begin, end),
		cmocka_unit_test_setup_teardown(test_mouse, begin, end),
		cmocka_unit_test_setup_teardown(test_buttons, begin, end),
		cmocka_unit_test_setup_teardown(test_presses_between_frames_count, begin, end),
		cmocka_unit_test_setup_teardown(test_the_last_touched_leads, begin, end),
		cmocka_unit_test_setup_teardown(test_drift_is_no_touch, begin, end),
		cmocka_unit_test_setup_teardown(test_without_dead_zone, begin, end),
		cmocka_unit_test_setup_teardown(test_first_report, begin, end),
		cmocka_unit_test_setup_teardown(test_unplug_stops, begin, end),
		cmocka_unit_test_setup_teardown(test_keys_go_on_when_the_pad_is_pulled, begin, end),
		cmocka_unit_test_setup_teardown(test_focus, begin, end),
		cmocka_unit_test_setup_teardown(test_keys_end_in_a_stall, begin, end),
		cmocka_unit_test_setup_teardown(test_place, begin, end),
		cmocka_unit_test_setup_teardown(test_list, begin, end),
		cmocka_unit_test_setup_teardown(test_too_many, begin, end),
		cmocka_unit_test_setup_teardown(test_corrupt_reports_move_nothing, begin, end),
		cmocka_unit_test_setup_teardown(test_path_is_the_same_at_every_rate, begin, end),
	};
	return cmocka_run_group_tests(tests, make_table, NULL);
}
