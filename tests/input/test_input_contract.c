/* The asserts of the input headers, each made to fail on purpose: threads, states, ranges, numbers. */
#include "input/device/input_device_internal.h"
#include "input/device/input_pads.h"
#include "input/device/input_ring_internal.h"
#include "input/hid/input_layout.h"
#include "input/input_control.h"
#include "input/input_look.h"
#include "input/input_recording.h"
#include "input/input_text_internal.h"
#include "input/input_window.h"
#include "support/contract.h"
#include "support/test.h"

#include <math.h>
#include <pthread.h>

static const stilb_input_pose origin;

/* ---- threads ----------------------------------------------------------------------------------------------------- */

static void on_another_thread(void *(*run)(void *), void *object)
{
	pthread_t thread;
	if (pthread_create(&thread, NULL, run, object) == 0)
		pthread_join(thread, NULL);
}

static void *list_pads(void *control)
{
	stilb_input_control_pad pads[STILB_INPUT_PADS_MAX];
	stilb_input_control_pads(control, pads);
	return NULL;
}

static void *next_event(void *pads)
{
	stilb_input_event event;
	stilb_input_pads_next(pads, 0, &event);
	return NULL;
}

static void *close_recorder(void *recorder)
{
	stilb_input_recorder_close(recorder);
	return NULL;
}

/* The pads are created here, in the forked child, as they have a watcher thread, which a fork would not copy. */
static void pads_on_another_thread(void)
{
	stilb_input_pads *pads;
	if (stilb_input_pads_create(&(stilb_input_pads_desc){.sys = "/nowhere", .dev = "/tmp"}, &pads) == STILB_OK)
		on_another_thread(next_event, pads);
}

static void recorder_on_another_thread(void)
{
	stilb_input_recorder *recorder;
	if (stilb_input_recorder_create("/dev/null", &recorder) == STILB_OK)
		on_another_thread(close_recorder, recorder);
}

static void objects_belong_to_one_thread(void **state)
{
	(void)state;
	stilb_input_control *control;
	stilb_input_control_settings settings = stilb_input_control_settings_default();
	assert_int_equal(stilb_input_control_create(&settings, &origin, 0, &control), STILB_OK);
	contract_breaks("called on the owner's thread", (on_another_thread(list_pads, control), 0));
	contract_breaks("called on the owner's thread", (pads_on_another_thread(), 0));
	contract_breaks("called on the owner's thread", (recorder_on_another_thread(), 0));
	stilb_input_control_destroy(control);
}

/* ---- settings and states ----------------------------------------------------------------------------------------- */

static void create_with_sensitivity(float sensitivity)
{
	stilb_input_control *control;
	stilb_input_control_settings settings = stilb_input_control_settings_default();
	settings.sensitivity[2] = sensitivity;
	stilb_input_control_create(&settings, &origin, 0, &control);
}

static void camera_at(float x, float speed)
{
	stilb_input_camera_settings settings = stilb_input_camera_settings_default();
	settings.speed = speed;
	stilb_input_camera_make(&settings, &(stilb_input_pose){.position = {x}}, 0);
}

static void advance_what_was_not_made(void)
{
	stilb_input_camera camera = {0};
	stilb_input_camera_advance(&camera, 10);
}

static void a_camera_has_numbers(void **state)
{
	(void)state;
	float out[2];
	contract_breaks("the camera is somewhere", (camera_at(NAN, 1.0f), 0));
	contract_breaks("speeds and rates are at least 0", (camera_at(0.0f, -1.0f), 0));
	contract_breaks("made by stilb_input_camera_make", (advance_what_was_not_made(), 0));
	contract_breaks("has numbers", (stilb_input_follow(0.0, (double)NAN, 1.0, 1.0, NULL), 0));
	contract_breaks("a step goes towards the target", (stilb_input_step_towards(0.0f, 1.0f, -0.1f), 0));
	contract_breaks("a dead zone and a range", (stilb_input_stick((float[2]){0}, -0.1f, 1.0f, 1.0f, out), 0));
	contract_breaks("the response rises", (stilb_input_stick((float[2]){0}, 0.1f, 1.0f, 0.0f, out), 0));
	contract_breaks("the settings are in their ranges", (create_with_sensitivity(11.0f), 0));
}

/* ---- events ------------------------------------------------------------------------------------------------------ */

static stilb_input_control *control;

static void tell(stilb_input_event event)
{
	stilb_input_control_event(control, &event);
}

static void late_after(int64_t time_us)
{
	tell((stilb_input_event){.kind = STILB_INPUT_PAD_STATE, .pad = 1, .time_us = time_us});
	tell((stilb_input_event){.kind = STILB_INPUT_PAD_STATE, .pad = 1, .time_us = time_us - 1});
}

static void events_are_of_pads_in_time_order(void **state)
{
	(void)state;
	stilb_input_pad_info info = {.name = "Made-up Pad"};
	stilb_input_control_settings settings = stilb_input_control_settings_default();
	assert_int_equal(stilb_input_control_create(&settings, &origin, 0, &control), STILB_OK);
	tell((stilb_input_event){.kind = STILB_INPUT_PAD_ADDED, .pad = 1, .info = &info});
	contract_breaks("pads are numbered from 1", (tell((stilb_input_event){.pad = 0, .info = &info}), 0));
	contract_breaks("a pad is added once", (tell((stilb_input_event){.pad = 1, .info = &info}), 0));
	contract_breaks("ADDED and DENIED say what the pad is", (tell((stilb_input_event){.pad = 2}), 0));
	contract_breaks("a pad's events come in time order", (late_after(100), 0));
	contract_breaks(
		"input_pad_state_is_sound",
		(tell((stilb_input_event){.kind = STILB_INPUT_PAD_STATE, .pad = 1, .time_us = 1, .state.axes = {1.5f}}), 0));
	stilb_input_control_destroy(control);
}

static void add_twice(void)
{
	stilb_input_recorder *recorder;
	stilb_input_pad_info info = {.descriptor_size = 1};
	stilb_input_event event = {.kind = STILB_INPUT_PAD_ADDED, .pad = 1, .info = &info};
	if (stilb_input_recorder_create("/dev/null", &recorder) != STILB_OK)
		return;
	stilb_input_recorder_add(recorder, &event);
	stilb_input_recorder_add(recorder, &event);
}

static void read_without_rows(void)
{
	stilb_input_from_window(&(stilb_input_table){0}, &(stilb_window_state){0});
}

/* Reads help of a table without the camera's rows. */
static void help_without_rows(void)
{
	uint32_t next = 0;
	stilb_input_help line;
	stilb_input_help_next(&(stilb_input_table){0}, &next, &line);
}

static void add_to_a_long_table(void)
{
	stilb_input_table table = {.count = STILB_INPUT_ACTIONS_MAX + 1};
	stilb_input_table_add(&table, NULL, 0);
}

static void feed_a_gamepad_without_guid(void)
{
	stilb_input_window window = {0};
	stilb_window_gamepad gamepads[STILB_WINDOW_GAMEPADS] = {{.name = "Pad"}};
	stilb_input_control_settings settings = stilb_input_control_settings_default();
	if (stilb_input_control_create(&settings, &origin, 0, &control) == STILB_OK)
		stilb_input_window_feed(&window, gamepads, 0, control);
}

static void sources_keep_their_promises(void **state)
{
	(void)state;
	contract_breaks("a pad is added once", (add_twice(), 0));
	contract_breaks("the camera's rows are there", (read_without_rows(), 0));
	contract_breaks("table && next && line", stilb_input_help_next(NULL, NULL, NULL));
	contract_breaks("table->count >= ", (help_without_rows(), 0));
	contract_breaks("rows || count == 0", stilb_input_table_add(&(stilb_input_table){0}, NULL, 1));
	contract_breaks("table->count <= ", (add_to_a_long_table(), 0));
	contract_breaks("`table'", (stilb_input_without_keys(NULL, (stilb_input_state){0}), 0));
	contract_breaks("a gamepad has a GUID", (feed_a_gamepad_without_guid(), 0));
}

/* ---- bytes ------------------------------------------------------------------------------------------------------- */

static void decode_a_source_outside_of_its_report(void)
{
	stilb_input_layout layout = {.report_count = 1, .reports[0] = {.size = 2, .source_count = 1}};
	layout.reports[0].sources[0] = (stilb_input_source){.bits = 8, .bit = 9, .high = 255};
	stilb_input_pad_state state = {0};
	stilb_input_decode(&layout, (const uint8_t[]){0, 0}, 2, &state);
}

static void push_a_long_record(void)
{
	input_ring ring;
	if (input_ring_init(&ring, 4096, 64) == 0)
		input_ring_push(&ring, 0, 0, (const uint8_t[65]){0}, 65);
}

static void pop_nothing(void)
{
	input_ring ring;
	if (input_ring_init(&ring, 4096, 64) == 0)
		input_ring_pop(&ring);
}

static void bytes_stay_where_they_are(void **state)
{
	(void)state;
	char text[8];
	stilb_input_pad_info info;
	input_ring ring;
	contract_breaks("input_layout_is_sound", (decode_a_source_outside_of_its_report(), 0));
	contract_breaks("capacity & (capacity - 1)", input_ring_init(&ring, 4097, 64));
	contract_breaks("size <= ring->record_max", (push_a_long_record(), 0));
	contract_breaks("there is a record to remove", (pop_nothing(), 0));
	contract_breaks("to && size > 0", (input_text_copy(text, 0, "a", 1), 0));
	contract_breaks("text && size > 0", (stilb_input_usage_text(0x10030, text, 0), 0));
	contract_breaks("path && info", stilb_input_look(NULL, &info));
	contract_breaks("the name of a node, no path", input_device_info(&(input_roots){"/sys", "/dev"}, "../mem", &info));
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(objects_belong_to_one_thread),     cmocka_unit_test(a_camera_has_numbers),
		cmocka_unit_test(events_are_of_pads_in_time_order), cmocka_unit_test(sources_keep_their_promises),
		cmocka_unit_test(bytes_stay_where_they_are),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
