/* input: keys and mouse become wishes, wishes become a pose. */
#include "base/base_math.h"
#include "input/input.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#define PI 3.14159265358979323846f

static void assert_position(const stilb_input_pose *pose, float x, float y, float z)
{
	assert_float_equal(pose->position[0], x, 1e-4f);
	assert_float_equal(pose->position[1], y, 1e-4f);
	assert_float_equal(pose->position[2], z, 1e-4f);
}

/* From the origin with this direction, a second of these moves. */
static stilb_input_pose flown(float yaw, float pitch, float right, float up, float forward)
{
	stilb_input_state input = {.move = {right, up, forward}};
	return stilb_input_fly((stilb_input_pose){.yaw = yaw, .pitch = pitch}, &input, 1.0f);
}

static void test_axes(void **state)
{
	(void)state;
	const float s = STILB_INPUT_SPEED, r = s * sqrtf(0.5f);
	stilb_input_pose pose = flown(0, 0, 0, 0, 1);
	assert_position(&pose, 0, 0, -s);
	pose = flown(0, 0, 1, 0, 0);
	assert_position(&pose, s, 0, 0);
	pose = flown(0, 0, 0, 1, 0);
	assert_position(&pose, 0, s, 0);
	pose = flown(PI / 2, 0, 0, 0, 1); /* turned to the left: along -X */
	assert_position(&pose, -s, 0, 0);
	pose = flown(PI / 2, 0, 1, 0, 0);
	assert_position(&pose, 0, 0, -s);
	pose = flown(0, 0, 1, 0, 1); /* a diagonal is no faster */
	assert_position(&pose, r, 0, -r);
	pose = flown(0, 0, 0.5f, 0, 0); /* half a push is half as fast */
	assert_position(&pose, s / 2, 0, 0);
	pose = flown(0, PI / 4, 0, 0, 1); /* looking up: forward climbs */
	assert_position(&pose, 0, r, -r);
	pose = flown(0, PI / 4, 1, 0, 0); /* no roll: right stays level */
	assert_position(&pose, s, 0, 0);
	pose = flown(1.0f, 1.0f, 0, 1, 0); /* up is the world's */
	assert_position(&pose, 0, s, 0);
	pose = flown(0.3f, -0.4f, -1, -1, -1);
	stilb_input_pose back = flown(0.3f, -0.4f, 1, 1, 1);
	assert_position(&pose, -back.position[0], -back.position[1], -back.position[2]);
}

/* Forward is where the camera with this yaw and pitch looks. */
static void test_forward_is_the_views(void **state)
{
	(void)state;
	for (int i = 0; i < 50; i++) {
		float yaw = 6.0f * stilb_random_float(1, (uint64_t)i) - 3.0f,
			  pitch = 3.0f * stilb_random_float(2, (uint64_t)i) - 1.5f;
		stilb_mat4 view = stilb_mat4_view(stilb_vec3_make(0, 0, 0), yaw, pitch);
		stilb_input_pose pose = flown(yaw, pitch, 0, 0, 1.0f / STILB_INPUT_SPEED);
		assert_position(&pose, -view.m[2], -view.m[6], -view.m[10]);
		pose = flown(yaw, pitch, 1.0f / STILB_INPUT_SPEED, 0, 0);
		assert_position(&pose, view.m[0], view.m[4], view.m[8]);
	}
}

static void test_speed(void **state)
{
	(void)state;
	stilb_input_state input = {.move = {0, 0, 1}};
	stilb_input_pose start = {.position = {1, 2, 3}};
	stilb_input_pose pose = stilb_input_fly(start, &input, 0.5f);
	assert_position(&pose, 1, 2, 3 - 0.5f * STILB_INPUT_SPEED);
	input.fast = true;
	pose = stilb_input_fly(start, &input, 0.5f);
	assert_position(&pose, 1, 2, 3 - 0.5f * STILB_INPUT_SPEED * STILB_INPUT_FAST);
	pose = stilb_input_fly(start, &input, 0.0f);
	assert_memory_equal(&pose, &start, sizeof pose);
	input = (stilb_input_state){.fast = true, .capture = true, .workers = 3};
	pose = stilb_input_fly(start, &input, 1.0f); /* nothing moves: the same bits */
	assert_memory_equal(&pose, &start, sizeof pose);
}

static void test_look_turns_first(void **state)
{
	(void)state;
	stilb_input_state input = {.move = {0, 0, 1}, .look = {PI / 2, 0}};
	stilb_input_pose pose = stilb_input_fly((stilb_input_pose){0}, &input, 1.0f);
	assert_float_equal(pose.yaw, PI / 2, 1e-6f);
	assert_position(&pose, -STILB_INPUT_SPEED, 0, 0);
	input = (stilb_input_state){.look = {0, 0.25f}};
	pose = stilb_input_fly((stilb_input_pose){.pitch = 0.5f}, &input, 0.0f); /* the mouse knows no time */
	assert_float_equal(pose.pitch, 0.75f, 1e-6f);
}

static void test_pitch_stops(void **state)
{
	(void)state;
	stilb_input_state up = {.look = {0, 0.4f}}, down = {.look = {0, -0.4f}};
	stilb_input_pose pose = {0};
	for (int i = 0; i < 10; i++) {
		pose = stilb_input_fly(pose, &up, 0.1f);
		assert_true(pose.pitch <= STILB_INPUT_PITCH_LIMIT);
	}
	assert_true(pose.pitch == STILB_INPUT_PITCH_LIMIT && STILB_INPUT_PITCH_LIMIT < PI / 2);
	pose = stilb_input_fly(pose, &down, 0.1f); /* comes back at once: no turning beyond the stop is stored */
	assert_float_equal(pose.pitch, STILB_INPUT_PITCH_LIMIT - 0.4f, 1e-6f);
	for (int i = 0; i < 10; i++)
		pose = stilb_input_fly(pose, &down, 0.1f);
	assert_true(pose.pitch == -STILB_INPUT_PITCH_LIMIT);
}

static void test_yaw_wraps(void **state)
{
	(void)state;
	stilb_input_state left = {.look = {0.1f, 0}};
	stilb_input_pose pose = {0};
	for (int i = 1; i <= 1000; i++) {
		pose = stilb_input_fly(pose, &left, 0.1f);
		assert_true(fabsf(pose.yaw) <= PI + 1e-5f);
		assert_float_equal(cosf(pose.yaw), cosf(0.1f * (float)i), 1e-3f);
		assert_float_equal(sinf(pose.yaw), sinf(0.1f * (float)i), 1e-3f);
	}
	left.look[0] = -1000.0f;
	pose = stilb_input_fly((stilb_input_pose){0}, &left, 0.1f);
	assert_true(fabsf(pose.yaw) <= PI + 1e-5f);
}

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
		input = pressed(moves[i].key, 3); /* it is up again */
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
	assert_false(held(STILB_WINDOW_KEY_P).capture); /* once per press */
	assert_true(pressed(STILB_WINDOW_KEY_F12, 2).screenshot);
	assert_false(held(STILB_WINDOW_KEY_F12).screenshot);
	assert_true(pressed(STILB_WINDOW_KEY_F1, 1).overlay && pressed(STILB_WINDOW_KEY_F1, 3).overlay);
	assert_false(pressed(STILB_WINDOW_KEY_F1, 2).overlay); /* opened and closed */
	assert_true(pressed(STILB_WINDOW_KEY_F2, 1).inspector && !pressed(STILB_WINDOW_KEY_F2, 1).overlay);
	assert_false(pressed(STILB_WINDOW_KEY_F2, 2).inspector || held(STILB_WINDOW_KEY_F2).inspector);
	assert_true(pressed(STILB_WINDOW_KEY_SPACE, 1).freeze);
	assert_false(pressed(STILB_WINDOW_KEY_SPACE, 2).freeze || held(STILB_WINDOW_KEY_SPACE).freeze);
	assert_int_equal(pressed(STILB_WINDOW_KEY_PLUS, 3).workers, 3);
	assert_int_equal(pressed(STILB_WINDOW_KEY_MINUS, 2).workers, -2);
	assert_int_equal(pressed(STILB_WINDOW_KEY_MINUS, 255).workers, -255);
	stilb_window_state both = {.pressed = {[STILB_WINDOW_KEY_PLUS] = 5, [STILB_WINDOW_KEY_MINUS] = 2}};
	assert_int_equal(stilb_input_from_window(&both).workers, 3);
	stilb_input_state nothing = stilb_input_from_window(&(stilb_window_state){0});
	assert_false(nothing.fast || nothing.capture || nothing.screenshot || nothing.workers);
	assert_false(nothing.overlay || nothing.inspector || nothing.freeze);
	assert_true(nothing.look[0] == 0.0f && nothing.look[1] == 0.0f);
}

static void test_keys_of_a_user_interface(void **state)
{
	(void)state;
	stilb_window_state window = {.mouse_captured = true, .mouse_x = 5.0f, .mouse_y = -7.0f};
	for (int key = 0; key < STILB_WINDOW_KEY_COUNT; key++) {
		window.held[key] = key != STILB_WINDOW_KEY_S && key != STILB_WINDOW_KEY_A && key != STILB_WINDOW_KEY_Q;
		window.pressed[key] = key != STILB_WINDOW_KEY_MINUS;
	}
	stilb_input_state all = stilb_input_from_window(&window), without = stilb_input_without_keys(all);
	assert_true(all.move[0] == 1.0f && all.move[1] == 1.0f && all.move[2] == 1.0f && all.fast && all.freeze);
	assert_true(without.move[0] == 0.0f && without.move[1] == 0.0f && without.move[2] == 0.0f);
	assert_false(without.fast || without.freeze);
	assert_true(without.capture && without.screenshot && without.overlay && without.inspector && without.workers == 1);
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
	stilb_input_pose pose = stilb_input_fly((stilb_input_pose){0}, &input, 0.0f);
	assert_true(pose.yaw < 0.0f && pose.pitch < 0.0f);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_axes),
		cmocka_unit_test(test_forward_is_the_views),
		cmocka_unit_test(test_speed),
		cmocka_unit_test(test_look_turns_first),
		cmocka_unit_test(test_pitch_stops),
		cmocka_unit_test(test_yaw_wraps),
		cmocka_unit_test(test_keys),
		cmocka_unit_test(test_actions),
		cmocka_unit_test(test_keys_of_a_user_interface),
		cmocka_unit_test(test_mouse),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
