/* input: keys and mouse of a window become a frame's requests (stilb_input_state), as a table of actions says. */
#include "actions.h"
#include "input/input.h"
#include "support/test.h"

#include <stddef.h>
#include <string.h>

static stilb_input_table table;

static stilb_input_state held(stilb_window_key key)
{
	stilb_window_state window = {0};
	window.held[key] = true;
	return stilb_input_from_window(&table, &window);
}

static stilb_input_state pressed(stilb_window_key key, uint8_t times)
{
	stilb_window_state window = {0};
	window.pressed[key] = times;
	return stilb_input_from_window(&table, &window);
}

static stilb_input_state typed(const char *text)
{
	stilb_window_state window = {0};
	for (; *text; text++)
		window.typed[window.typed_count++] = (uint32_t)*text;
	return stilb_input_from_window(&table, &window);
}

/* The number of actions, but for the camera's, that the input asks for. */
static int asked(stilb_input_state input)
{
	int count = 0;
	for (uint32_t row = STILB_INPUT_ACTIONS; row < STILB_INPUT_ACTIONS_MAX; row++)
		count += input.actions[row] > 0;
	return count;
}

static void test_keys(void **state)
{
	(void)state;
	static const struct {
		stilb_window_key key;
		int axis;
		float way;
	} moves[] = {{STILB_WINDOW_KEY_D, 0, 1},  {STILB_WINDOW_KEY_A, 0, -1}, {STILB_WINDOW_KEY_E, 1, 1},
	             {STILB_WINDOW_KEY_Q, 1, -1}, {STILB_WINDOW_KEY_W, 2, 1},  {STILB_WINDOW_KEY_S, 2, -1}};
	for (size_t i = 0; i < 6; i++) {
		stilb_input_state input = held(moves[i].key), wanted = {.move = {0}};
		wanted.move[moves[i].axis] = moves[i].way;
		assert_memory_equal(input.move, wanted.move, sizeof input.move);
		assert_true(asked(input) == 0 && !input.actions[STILB_INPUT_FASTER]);
		input = pressed(moves[i].key, 3); /* pressed three times since the last frame, and up again now */
		assert_true(input.move[0] == 0.0f && input.move[1] == 0.0f && input.move[2] == 0.0f);
	}
	stilb_window_state both = {.held = {[STILB_WINDOW_KEY_W] = true, [STILB_WINDOW_KEY_S] = true}};
	assert_true(stilb_input_from_window(&table, &both).move[2] == 0.0f);
	assert_true(held(STILB_WINDOW_KEY_SHIFT).actions[STILB_INPUT_FASTER]);
}

static void test_actions(void **state)
{
	(void)state;
	assert_int_equal(pressed(STILB_WINDOW_KEY_P, 1).actions[CAPTURE], 1);
	assert_int_equal(asked(held(STILB_WINDOW_KEY_P)), 0); /* held since an earlier frame: a press acts only once */
	assert_int_equal(pressed(STILB_WINDOW_KEY_F12, 2).actions[SCREENSHOT], 2);
	assert_int_equal(asked(held(STILB_WINDOW_KEY_F12)), 0);
	assert_true(pressed(STILB_WINDOW_KEY_F1, 1).actions[OVERLAY] == 1);
	assert_true(pressed(STILB_WINDOW_KEY_F1, 3).actions[OVERLAY] == 1);
	assert_int_equal(asked(pressed(STILB_WINDOW_KEY_F1, 2)), 0); /* opened and closed */
	assert_true(pressed(STILB_WINDOW_KEY_F2, 1).actions[INSPECTOR] && asked(pressed(STILB_WINDOW_KEY_F2, 1)) == 1);
	assert_int_equal(asked(pressed(STILB_WINDOW_KEY_F2, 2)) + asked(held(STILB_WINDOW_KEY_F2)), 0);
	assert_int_equal(pressed(STILB_WINDOW_KEY_V, 2).actions[NEXT_VIEW], 2);
	assert_int_equal(pressed(STILB_WINDOW_KEY_V, 255).actions[NEXT_VIEW], 255);
	stilb_window_state two = {.pressed = {[STILB_WINDOW_KEY_F] = 1, [STILB_WINDOW_KEY_HOME] = 2}}; /* keys of one row */
	assert_int_equal(stilb_input_from_window(&table, &two).actions[FRAME], 3);
	two.pressed[STILB_WINDOW_KEY_F] = 255;
	assert_int_equal(stilb_input_from_window(&table, &two).actions[FRAME], 255);
	stilb_input_state nothing = stilb_input_from_window(&table, &(stilb_window_state){0});
	assert_int_equal(asked(nothing), 0);
	assert_true(nothing.look[0] == 0.0f && nothing.look[1] == 0.0f);
}

static void test_held_and_typed(void **state)
{
	(void)state;
	assert_int_equal(held(STILB_WINDOW_KEY_G).actions[GRAB], 1);
	assert_int_equal(asked(pressed(STILB_WINDOW_KEY_G, 3)), 0); /* up again now */
	assert_int_equal(typed("-").actions[FEWER], 1);
	stilb_input_state input = typed("+=-+x-");
	assert_int_equal(input.actions[MORE], 3); /* by either of its characters */
	assert_int_equal(input.actions[FEWER], 2);
	assert_int_equal(asked(input), 2);
	stilb_window_state window = {.typed = {0, 0x12b, 0x2b00}, .typed_count = 3}; /* none, and beyond ASCII */
	assert_int_equal(asked(stilb_input_from_window(&table, &window)), 0);
	window.typed[0] = '-'; /* typed in an earlier frame */
	window.typed_count = 0;
	assert_int_equal(asked(stilb_input_from_window(&table, &window)), 0);
}

/* A window without a camera: no key is the camera's, and help has only rows that were added. */
static void test_a_plain_table(void **state)
{
	(void)state;
	static const stilb_input_action rows[] = {
		{"west", STILB_INPUT_REPEAT, .keys = {STILB_WINDOW_KEY_A}, .help = "go west"},
		{"look", STILB_INPUT_MOTION, .mouse = STILB_INPUT_MOUSE_CLICK | STILB_INPUT_MOUSE_DOUBLE, .help = "look at it"},
	};
	stilb_input_table plain = stilb_input_table_plain();
	stilb_input_help line;
	uint32_t next = 0;
	stilb_window_state all = {0};
	assert_false(stilb_input_help_next(&plain, &next, &line));
	for (int key = 0; key < STILB_WINDOW_KEY_COUNT; key++)
		all.held[key] = key != STILB_WINDOW_KEY_S && key != STILB_WINDOW_KEY_A && key != STILB_WINDOW_KEY_Q;
	stilb_input_state input = stilb_input_from_window(&plain, &all);
	assert_true(input.move[0] == 0.0f && input.move[1] == 0.0f && input.move[2] == 0.0f);
	assert_false(input.actions[STILB_INPUT_FASTER]);
	assert_int_equal(stilb_input_table_add(&plain, rows, 2), STILB_OK); /* A is the camera's in other tables */
	all = (stilb_window_state){.pressed = {[STILB_WINDOW_KEY_A] = 2}, .repeated = {[STILB_WINDOW_KEY_A] = 5}};
	assert_int_equal(stilb_input_from_window(&plain, &all).actions[STILB_INPUT_ACTIONS], 7);
	assert_int_equal(stilb_input_from_window(&table, &all).actions[STILB_INPUT_LEFTWARD], 0);
	next = 0;
	assert_true(stilb_input_help_next(&plain, &next, &line));
	assert_true(strcmp(line.keys, "A") == 0 && strcmp(line.help, "go west") == 0);
	assert_true(stilb_input_help_next(&plain, &next, &line));
	assert_string_equal(line.mouse, "click, double click");
	assert_false(stilb_input_help_next(&plain, &next, &line));
}

/* Each key of the panels' table is one that a panel takes, and only those are. */
static void test_the_keys_of_panels_are_a_table(void **state)
{
	(void)state;
	stilb_input_table panels = stilb_input_table_panels();
	for (int key = 1; key < STILB_WINDOW_KEY_COUNT; key++) {
		stilb_input_action row = {.name = "one", .keys = {(stilb_window_key)key}, .help = "one"};
		stilb_input_table one = stilb_input_table_plain();
		assert_int_equal(stilb_input_table_add(&one, &row, 1), STILB_OK);
		stilb_window_state window = {0};
		window.pressed[key] = 1;
		window.held[key] = true;
		bool taken = asked(stilb_input_from_window(&panels, &window)) > 0;
		stilb_input_state left = stilb_input_without_keys(&one, stilb_input_from_window(&one, &window));
		assert_int_equal(asked(left), !taken);
	}
}

static void test_keys_of_a_user_interface(void **state)
{
	(void)state;
	stilb_window_state window = {
		.mouse_captured = true, .mouse_x = 5.0f, .mouse_y = -7.0f, .typed = {'+'}, .typed_count = 1};
	for (int key = 0; key < STILB_WINDOW_KEY_COUNT; key++) {
		window.held[key] = key != STILB_WINDOW_KEY_S && key != STILB_WINDOW_KEY_A && key != STILB_WINDOW_KEY_Q;
		window.pressed[key] = 1;
	}
	stilb_input_state all = stilb_input_from_window(&table, &window), without = stilb_input_without_keys(&table, all);
	assert_true(all.move[0] == 1.0f && all.move[1] == 1.0f && all.move[2] == 1.0f);
	assert_true(all.actions[STILB_INPUT_FASTER] && all.actions[FREEZE] && all.actions[CANCEL] && all.actions[GRAB]);
	assert_true(without.move[0] == 0.0f && without.move[1] == 0.0f && without.move[2] == 0.0f);
	assert_false(without.actions[STILB_INPUT_FASTER] || without.actions[FREEZE] || without.actions[CANCEL] ||
	             without.actions[GRAB]);
	assert_true(without.actions[CAPTURE] && without.actions[SCREENSHOT] && without.actions[OVERLAY]);
	assert_true(without.actions[INSPECTOR] && without.actions[MORE] == 1 && without.actions[NEXT_VIEW] == 1);
	assert_memory_equal(without.look, all.look, sizeof all.look);
}

/* The mouse to the right turns the view right, the mouse down (larger y) lowers it. */
static void test_mouse(void **state)
{
	(void)state;
	stilb_window_state window = {.mouse_captured = true, .mouse_x = 10.0f, .mouse_y = 4.0f};
	stilb_input_state input = stilb_input_from_window(&table, &window);
	assert_float_equal(input.look[0], -10.0f * STILB_INPUT_TURN, 1e-7f);
	assert_float_equal(input.look[1], -4.0f * STILB_INPUT_TURN, 1e-7f);
}

/* A drag counts in heights of the window, of the button that is held; a user interface takes it under the pointer. */
static void test_drags(void **state)
{
	(void)state;
	stilb_window_state window = {.height = 200, .button = true, .moved_x = 50.0f, .moved_y = -20.0f, .wheel = 2.0f};
	stilb_input_state input = stilb_input_from_window(&table, &window);
	assert_true(input.drag[0] == 0.25f && input.drag[1] == -0.1f && input.zoom == 2.0f);
	assert_true(input.pan[0] == 0.0f && input.pan[1] == 0.0f);
	window.button = false;
	window.middle = true;
	input = stilb_input_from_window(&table, &window);
	assert_true(input.drag[0] == 0.0f && input.pan[0] == 0.25f && input.pan[1] == -0.1f);
	input = stilb_input_without_pointer(input);
	assert_true(input.pan[0] == 0.0f && input.pan[1] == 0.0f && input.zoom == 0.0f);
}

/* ---- tables ------------------------------------------------------------------------------------------------------ */

/* Adding this row after that one is refused with this message, and the table stays. */
static void refused(const char *message, stilb_input_action that, stilb_input_action row)
{
	stilb_input_action rows[2] = {that, row};
	stilb_input_table one = stilb_input_table_camera(), before;
	if (that.name)
		assert_int_equal(stilb_input_table_add(&one, rows, 1), STILB_OK);
	before = one;
	assert_int_equal(stilb_input_table_add(&one, rows + 1, 1), STILB_ERROR_ARGUMENT);
	assert_string_equal(stilb_error_message(), message);
	assert_true(one.count == before.count && one.newest == before.newest);
	one = stilb_input_table_camera(); /* both at once */
	assert_int_equal(stilb_input_table_add(&one, that.name ? rows : rows + 1, that.name ? 2 : 1), STILB_ERROR_ARGUMENT);
	assert_string_equal(stilb_error_message(), message);
	assert_int_equal(one.count, STILB_INPUT_ACTIONS);
}

static void test_refused_rows(void **state)
{
	(void)state;
	stilb_input_action none = {0}, up = {.name = "up", .keys = {STILB_WINDOW_KEY_F5, STILB_WINDOW_KEY_PAGE_UP}};
	stilb_input_action quiz = {.name = "quiz", .typed = "!?"};
	refused("actions 'up' and 'rise' both have 'Page Up'; give one another key", up,
	        (stilb_input_action){.name = "rise",
	                             .keys = {STILB_WINDOW_KEY_R, STILB_WINDOW_KEY_NONE, STILB_WINDOW_KEY_PAGE_UP}});
	refused("actions 'fly left' and 'again' both have 'A'; give one another key", none,
	        (stilb_input_action){.name = "again", .keys = {STILB_WINDOW_KEY_A}});
	refused("actions 'fly left' and 'again' both have 'a'; give one another key", none,
	        (stilb_input_action){.name = "again", .typed = "a"});
	refused("actions 'two' and 'pair' both have '2'; give one another key",
	        (stilb_input_action){.name = "two", .typed = "2"},
	        (stilb_input_action){.name = "pair", .keys = {STILB_WINDOW_KEY_2}});
	refused("actions 'quiz' and 'help' both have '?'; give one another key", quiz,
	        (stilb_input_action){.name = "help", .typed = "h?"});
	refused("actions 'jump' and 'duck' both have 'B/circle'; give one another key",
	        (stilb_input_action){.name = "jump", .pad = STILB_INPUT_PAD(EAST) | STILB_INPUT_PAD(UP)},
	        (stilb_input_action){.name = "duck", .pad = STILB_INPUT_PAD(EAST) | STILB_INPUT_PAD(DOWN)});
	refused("actions 'look' and 'shake' both have 'right drag'; give one another key", none,
	        (stilb_input_action){.name = "shake", .kind = STILB_INPUT_MOTION, .mouse = STILB_INPUT_MOUSE_RIGHT});
	refused("actions 'fly' and 'walk' both have 'left stick'; give one another key", none,
	        (stilb_input_action){.name = "walk", .kind = STILB_INPUT_MOTION, .pad = STILB_INPUT_PAD_AXIS(LEFT_Y)});
	refused("two actions are named 'up'", up, (stilb_input_action){.name = "up"});
	refused("an action of the table has no name", none, (stilb_input_action){.keys = {STILB_WINDOW_KEY_Z}});
	refused("action 'fire' is held, which typed characters cannot be; give it a key or another kind", none,
	        (stilb_input_action){.name = "fire", .kind = STILB_INPUT_HELD, .typed = "!"});
	refused("action 'zoom' has a part of the mouse; only a motion can", none,
	        (stilb_input_action){.name = "zoom", .mouse = STILB_INPUT_MOUSE_WHEEL});
	refused("action 'zoom' is a motion, which has no keys and buttons", none,
	        (stilb_input_action){.name = "zoom", .kind = STILB_INPUT_MOTION, .pad = STILB_INPUT_PAD(SOUTH)});
	refused("action 'help' has 'h' as a key and as a character", none,
	        (stilb_input_action){.name = "help", .keys = {STILB_WINDOW_KEY_H}, .typed = "?h"});
	refused("action 'umlaut' is typed by a character that is not ASCII", none,
	        (stilb_input_action){.name = "umlaut", .typed = "\xc3\xa4"});
}

static void test_full_table(void **state)
{
	(void)state;
	static char names[STILB_INPUT_ACTIONS_MAX][4];
	stilb_input_action rows[STILB_INPUT_ACTIONS_MAX] = {{.name = ""}};
	stilb_input_table full = stilb_input_table_camera();
	for (uint32_t i = 0; i < STILB_INPUT_ACTIONS_MAX; i++) {
		names[i][0] = (char)('a' + i / 26);
		names[i][1] = (char)('a' + i % 26);
		rows[i] = (stilb_input_action){.name = names[i]};
	}
	assert_int_equal(stilb_input_table_add(&full, rows, STILB_INPUT_ACTIONS_MAX - STILB_INPUT_ACTIONS + 1),
	                 STILB_ERROR_ARGUMENT);
	assert_string_equal(stilb_error_message(), "56 actions are more than 64, with the 9 that there are");
	assert_int_equal(stilb_input_table_add(&full, rows, STILB_INPUT_ACTIONS_MAX - STILB_INPUT_ACTIONS), STILB_OK);
	rows[0] = (stilb_input_action){.name = "last", .keys = {STILB_WINDOW_KEY_9}};
	full.count--;
	assert_int_equal(stilb_input_table_add(&full, rows, 1), STILB_OK);
	stilb_window_state window = {.pressed = {[STILB_WINDOW_KEY_9] = 7}};
	assert_int_equal(stilb_input_from_window(&full, &window).actions[STILB_INPUT_ACTIONS_MAX - 1], 7);
}

/* Every key has a name of its own, and the camera's rows and these are told once each, the newest rows first. */
static void test_help(void **state)
{
	(void)state;
	for (int a = STILB_WINDOW_KEY_NONE + 1; a < STILB_WINDOW_KEY_COUNT; a++) {
		const char *name = stilb_input_key_name((stilb_window_key)a);
		assert_true(name && name[0]);
		for (int b = STILB_WINDOW_KEY_NONE; b < a; b++)
			assert_string_not_equal(name, stilb_input_key_name((stilb_window_key)b));
	}
	static const stilb_input_help wanted[] = {
		{"P", "", "X/square", "capture", "save a trace", CAPTURE, false},
		{"F12", "", "view/share", "screenshot", "save a picture", SCREENSHOT, true},
		{"F1", "", "Y/triangle, extra", "overlay", "the profiler", OVERLAY, false},
		{"F2", "", "menu/options", "inspector", "the materials", INSPECTOR, false},
		{"Space", "", "A/cross", "freeze", "freeze", FREEZE, false},
		{"V", "", "B/circle, d-pad right", "next view", "next view", NEXT_VIEW, false},
		{"+, -", "", "d-pad up, d-pad down", "more", "workers", MORE, false},
		{"F, Home", "", "", "frame", "frame", FRAME, false},
		{"Esc", "", "", "cancel", "give up", CANCEL, false},
		{"G", "", "d-pad left", "grab", "grab", GRAB, false},
		{"W, A, S, D", "", "left stick", "fly", "fly", STILB_INPUT_FORWARD, true},
		{"Q, E", "", "left shoulder, right shoulder", "fly down", "fly down, up", STILB_INPUT_DOWNWARD, false},
		{"Shift", "", "", "faster", "fly faster", STILB_INPUT_FASTER, false},
		{"", "", "left trigger, right trigger", "speed", "fly slower, faster", STILB_INPUT_SPEED, false},
		{"", "right drag", "right stick", "look", "look around", STILB_INPUT_LOOK, false},
	};
	stilb_input_help line;
	uint32_t next = 0;
	for (size_t i = 0; i < sizeof wanted / sizeof *wanted; i++) {
		assert_true(stilb_input_help_next(&table, &next, &line));
		assert_string_equal(line.keys, wanted[i].keys);
		assert_string_equal(line.mouse, wanted[i].mouse);
		assert_string_equal(line.pad, wanted[i].pad);
		assert_string_equal(line.name, wanted[i].name);
		assert_string_equal(line.help, wanted[i].help);
		assert_int_equal(line.row, wanted[i].row);
		assert_int_equal(line.main, wanted[i].main);
	}
	assert_false(stilb_input_help_next(&table, &next, &line));
	/* Of many keys the first and the last are named; a row without help is not told. */
	stilb_input_action rows[] = {
		{.name = "one", .keys = {STILB_WINDOW_KEY_1, STILB_WINDOW_KEY_2, STILB_WINDOW_KEY_3}, .help = "choose"},
		{.name = "two", .keys = {STILB_WINDOW_KEY_4, STILB_WINDOW_KEY_5}, .help = "choose"},
		{.name = "hidden", .keys = {STILB_WINDOW_KEY_6}},
	};
	stilb_input_table many = stilb_input_table_camera();
	assert_int_equal(stilb_input_table_add(&many, rows, 3), STILB_OK);
	next = 0;
	assert_true(stilb_input_help_next(&many, &next, &line));
	assert_string_equal(line.keys, "1 ... 5");
	assert_true(stilb_input_help_next(&many, &next, &line));
	assert_string_equal(line.keys, "W, A, S, D");
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
		cmocka_unit_test(test_keys),           cmocka_unit_test(test_actions),
		cmocka_unit_test(test_held_and_typed), cmocka_unit_test(test_keys_of_a_user_interface),
		cmocka_unit_test(test_a_plain_table),  cmocka_unit_test(test_the_keys_of_panels_are_a_table),
		cmocka_unit_test(test_mouse),          cmocka_unit_test(test_drags),
		cmocka_unit_test(test_refused_rows),   cmocka_unit_test(test_full_table),
		cmocka_unit_test(test_help),
	};
	return cmocka_run_group_tests(tests, make_table, NULL);
}
