#include "input/input.h"

#include <math.h>

static float input_axis(const bool *held, stilb_window_key plus, stilb_window_key minus)
{
	return (float)held[plus] - (float)held[minus];
}

stilb_input_state stilb_input_from_window(const stilb_window_state *window)
{
	const bool *held = window->held;
	return (stilb_input_state){
		.move = {input_axis(held, STILB_WINDOW_KEY_D, STILB_WINDOW_KEY_A),
	             input_axis(held, STILB_WINDOW_KEY_E, STILB_WINDOW_KEY_Q),
	             input_axis(held, STILB_WINDOW_KEY_W, STILB_WINDOW_KEY_S)},
		.look = {-window->mouse_x * STILB_INPUT_TURN, -window->mouse_y * STILB_INPUT_TURN},
		.fast = held[STILB_WINDOW_KEY_SHIFT],
		.capture = window->pressed[STILB_WINDOW_KEY_P] > 0,
		.screenshot = window->pressed[STILB_WINDOW_KEY_F12] > 0,
		.overlay = window->pressed[STILB_WINDOW_KEY_F1] % 2 > 0,
		.inspector = window->pressed[STILB_WINDOW_KEY_F2] % 2 > 0,
		.freeze = window->pressed[STILB_WINDOW_KEY_SPACE] % 2 > 0,
		.workers = window->pressed[STILB_WINDOW_KEY_PLUS] - window->pressed[STILB_WINDOW_KEY_MINUS],
	};
}

stilb_input_state stilb_input_without_keys(stilb_input_state input)
{
	input.move[0] = input.move[1] = input.move[2] = 0.0f;
	input.fast = input.freeze = false;
	return input;
}

stilb_input_pose stilb_input_fly(stilb_input_pose pose, const stilb_input_state *input, float seconds)
{
	pose.yaw = remainderf(pose.yaw + input->look[0], 6.28318530717958647692f);
	pose.pitch = fmaxf(-STILB_INPUT_PITCH_LIMIT, fminf(STILB_INPUT_PITCH_LIMIT, pose.pitch + input->look[1]));
	float right[3] = {cosf(pose.yaw), 0.0f, -sinf(pose.yaw)};
	float forward[3] = {-sinf(pose.yaw) * cosf(pose.pitch), sinf(pose.pitch), -cosf(pose.yaw) * cosf(pose.pitch)};
	/* A keyboard's diagonal is no faster; a stick that is pushed half way stays slow. */
	float length =
		sqrtf(input->move[0] * input->move[0] + input->move[1] * input->move[1] + input->move[2] * input->move[2]);
	float way = STILB_INPUT_SPEED * (input->fast ? STILB_INPUT_FAST : 1.0f) * seconds / fmaxf(length, 1.0f);
	for (int i = 0; i < 3; i++)
		pose.position[i] += way * (right[i] * input->move[0] + forward[i] * input->move[2]);
	pose.position[1] += way * input->move[1];
	return pose;
}
