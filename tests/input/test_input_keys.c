/* input: keys and mouse of a window become a frame's requests (stilb_input_state). */
#include "input/input.h"
#include "support/test.h"

#include <stddef.h>
#include <string.h>

static stilb_input_state held(stilb_window_key key)
{
	stilb_window_state window = {0};
	window.held[key] = true;
	return stilb_input_from_window(&window);
}

static stilb_input_state pressed(stilb_window_key key, uint8_t times)
{
	stilb_window_state window = {0};
	window.pressed[key] = times;
	return stilb_input_from_window(&window);
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
		assert_false(input.fast || input.capture || input.screenshot || input.workers);
		input = pressed(moves[i].key, 3); /* pressed three times since the last frame, and up again now */
		assert_true(input.move[0] == 0.0f && input.move[1] == 0.0f && input.move[2] == 0.0f);
	}
	stilb_window_state both = {.held = {[STILB_WINDOW_KEY_W] = true, [STILB_WINDOW_KEY_S] = true}};
	assert_true(stilb_input_from_window(&both).move[2] == 0.0f);
	assert_true(held(STILB_WINDOW_KEY_SHIFT).fast);
}

static void test_actions(void **state)
{
	(void)state;
	assert_true(pressed(STILB_WINDOW_KEY_P, 1).capture);
	assert_false(held(STILB_WINDOW_KEY_P).capture); /* held since an earlier frame: a press acts only once */
	assert_true(pressed(STILB_WINDOW_KEY_F12, 2).screenshot);
	assert_false(held(STILB_WINDOW_KEY_F12).screenshot);
	assert_true(pressed(STILB_WINDOW_KEY_F1, 1).overlay && pressed(STILB_WINDOW_KEY_F1, 3).overlay);
	assert_false(pressed(STILB_WINDOW_KEY_F1, 2).overlay); /* opened and closed */
	assert_true(pressed(STILB_WINDOW_KEY_F2, 1).inspector && !pressed(STILB_WINDOW_KEY_F2, 1).overlay);
	assert_false(pressed(STILB_WINDOW_KEY_F2, 2).inspector || held(STILB_WINDOW_KEY_F2).inspector);
	assert_true(pressed(STILB_WINDOW_KEY_SPACE, 1).freeze);
	assert_false(pressed(STILB_WINDOW_KEY_SPACE, 2).freeze || held(STILB_WINDOW_KEY_SPACE).freeze);
	assert_int_equal(pressed(STILB_WINDOW_KEY_V, 2).next_view, 2);
	assert_int_equal(held(STILB_WINDOW_KEY_V).next_view, 0);
	assert_int_equal(pressed(STILB_WINDOW_KEY_PLUS, 3).workers, 3);
	assert_int_equal(pressed(STILB_WINDOW_KEY_MINUS, 2).workers, -2);
	assert_int_equal(pressed(STILB_WINDOW_KEY_MINUS, 255).workers, -255);
	stilb_window_state both = {.pressed = {[STILB_WINDOW_KEY_PLUS] = 5, [STILB_WINDOW_KEY_MINUS] = 2}};
	assert_int_equal(stilb_input_from_window(&both).workers, 3);
	stilb_input_state nothing = stilb_input_from_window(&(stilb_window_state){0});
	assert_false(nothing.fast || nothing.capture || nothing.screenshot || nothing.workers);
	assert_false(nothing.overlay || nothing.inspector || nothing.freeze || nothing.next_view);
	assert_true(nothing.look[0] == 0.0f && nothing.look[1] == 0.0f);
}

static void test_keys_of_a_user_interface(void **state)
{
	(void)state;
	stilb_window_state window = {.mouse_captured = true, .mouse_x = 5.0f, .mouse_y = -7.0f};
	for (int key = 0; key < STILB_WINDOW_KEY_COUNT; key++) {
		bool typed = key == STILB_WINDOW_KEY_MINUS || key == STILB_WINDOW_KEY_PLUS; /* can be pressed, but not held */
		window.held[key] =
			!typed && key != STILB_WINDOW_KEY_S && key != STILB_WINDOW_KEY_A && key != STILB_WINDOW_KEY_Q;
		window.pressed[key] = key != STILB_WINDOW_KEY_MINUS;
	}
	stilb_input_state all = stilb_input_from_window(&window), without = stilb_input_without_keys(all);
	assert_true(all.move[0] == 1.0f && all.move[1] == 1.0f && all.move[2] == 1.0f && all.fast && all.freeze);
	assert_true(without.move[0] == 0.0f && without.move[1] == 0.0f && without.move[2] == 0.0f);
	assert_false(without.fast || without.freeze);
	assert_true(without.capture && without.screenshot && without.overlay && without.inspector && without.workers == 1);
	assert_true(without.next_view == 1);
	assert_memory_equal(without.look, all.look, sizeof all.look);
}

/* The mouse to the right turns the view right, the mouse down (larger y) lowers it. */
static void test_mouse(void **state)
{
	(void)state;
	stilb_window_state window = {.mouse_captured = true, .mouse_x = 10.0f, .mouse_y = 4.0f};
	stilb_input_state input = stilb_input_from_window(&window);
	assert_float_equal(input.look[0], -10.0f * STILB_INPUT_TURN, 1e-7f);
	assert_float_equal(input.look[1], -4.0f * STILB_INPUT_TURN, 1e-7f);
}

/* A drag counts in heights of the window, of the button that is held; a user interface takes it under the pointer. */
static void test_drags(void **state)
{
	(void)state;
	stilb_window_state window = {.height = 200, .button = true, .moved_x = 50.0f, .moved_y = -20.0f, .wheel = 2.0f};
	stilb_input_state input = stilb_input_from_window(&window);
	assert_true(input.drag[0] == 0.25f && input.drag[1] == -0.1f && input.zoom == 2.0f);
	assert_true(input.pan[0] == 0.0f && input.pan[1] == 0.0f);
	window.button = false;
	window.middle = true;
	input = stilb_input_from_window(&window);
	assert_true(input.drag[0] == 0.0f && input.pan[0] == 0.25f && input.pan[1] == -0.1f);
	input = stilb_input_without_pointer(input);
	assert_true(input.pan[0] == 0.0f && input.pan[1] == 0.0f && input.zoom == 0.0f);
	assert_true(pressed(STILB_WINDOW_KEY_F, 1).frame && pressed(STILB_WINDOW_KEY_HOME, 1).home);
	assert_true(pressed(STILB_WINDOW_KEY_ESCAPE, 1).cancel);
	assert_int_equal(pressed(STILB_WINDOW_KEY_PAGE_DOWN, 2).next_file, 2);
	assert_int_equal(pressed(STILB_WINDOW_KEY_PAGE_UP, 1).next_file, -1);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(test_keys),  cmocka_unit_test(test_actions), cmocka_unit_test(test_keys_of_a_user_interface),
		cmocka_unit_test(test_mouse), cmocka_unit_test(test_drags),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
