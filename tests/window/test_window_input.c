/* The window's keys, pointer and wheel under a virtual display: a second connection to it plays the user. */
#include "support/test.h"
#include "support/x11_window.h"
#include "window/window.h"

#include <X11/keysym.h>
#include <stdio.h>
#include <unistd.h>

static stilb_window *window;
static Display *display; /* the user's connection */
static Window target;

static int set_up(void **state)
{
	(void)state;
	if (stilb_window_create("Stilb input", 320, 200, &window) != STILB_OK) {
		fprintf(stderr, "%s\n", stilb_error_message());
		return -1;
	}
	target = x11_window_find(display, "Stilb input");
	if (target) /* as a window manager would; else the keys go where the pointer is */
		XSetInputFocus(display, target, RevertToParent, CurrentTime);
	return target ? 0 : -1;
}

static int tear_down(void **state)
{
	(void)state;
	stilb_window_destroy(window);
	return 0;
}

/* Polls until there(state) is true: events that the test sends travel through the X server. */
static stilb_window_state polled(bool (*there)(const stilb_window_state *state))
{
	stilb_window_state state;
	XSync(display, False);
	for (int i = 0; i < 60000; i++) {
		stilb_window_poll(window, &state);
		if (there(&state))
			return state;
		usleep(5000);
	}
	fail_msg("it never came");
	return state;
}

static void send_key(KeySym key, bool down)
{
	XKeyEvent event = {
		.type = down ? KeyPress : KeyRelease,
		.display = display,
		.window = target,
		.root = DefaultRootWindow(display),
		.time = CurrentTime,
		.same_screen = True,
		.keycode = XKeysymToKeycode(display, key),
	};
	XSendEvent(display, target, True, down ? KeyPressMask : KeyReleaseMask, (XEvent *)&event);
}

static void send_button(unsigned button, bool down)
{
	XButtonEvent event = {
		.type = down ? ButtonPress : ButtonRelease,
		.display = display,
		.window = target,
		.root = DefaultRootWindow(display),
		.time = CurrentTime,
		.same_screen = True,
		.button = button,
	};
	XSendEvent(display, target, True, down ? ButtonPressMask : ButtonReleaseMask, (XEvent *)&event);
}

static const stilb_window_state nothing; /* the expected state without new events, but for the pointer's place */

static void assert_quiet(void)
{
	stilb_window_state state;
	stilb_window_poll(window, &state);
	assert_memory_equal(state.pressed, nothing.pressed, sizeof state.pressed);
	assert_memory_equal(state.repeated, nothing.repeated, sizeof state.repeated);
	assert_true(state.clicks == 0 && state.wheel == 0.0f);
}

/* ---- keys -------------------------------------------------------------------------------------------------------- */

static stilb_window_key awaited;

static bool key_came(const stilb_window_state *state)
{
	return state->pressed[awaited] > 0;
}

static bool key_repeated(const stilb_window_state *state)
{
	return state->repeated[awaited] > 0;
}

static bool key_went(const stilb_window_state *state)
{
	return !state->held[awaited];
}

static void test_each_key(void **state)
{
	(void)state;
	static const struct {
		KeySym symbol;
		stilb_window_key key;
	} keys[] = {{XK_F1, STILB_WINDOW_KEY_F1},
	            {XK_F2, STILB_WINDOW_KEY_F2},
	            {XK_space, STILB_WINDOW_KEY_SPACE},
	            {XK_Tab, STILB_WINDOW_KEY_TAB},
	            {XK_Return, STILB_WINDOW_KEY_ENTER},
	            {XK_KP_Enter, STILB_WINDOW_KEY_ENTER},
	            {XK_Left, STILB_WINDOW_KEY_LEFT},
	            {XK_Right, STILB_WINDOW_KEY_RIGHT},
	            {XK_Up, STILB_WINDOW_KEY_UP},
	            {XK_Down, STILB_WINDOW_KEY_DOWN},
	            {XK_Control_L, STILB_WINDOW_KEY_CONTROL},
	            {XK_Control_R, STILB_WINDOW_KEY_CONTROL},
	            {XK_Shift_L, STILB_WINDOW_KEY_SHIFT},
	            {XK_Escape, STILB_WINDOW_KEY_ESCAPE},
	            {XK_p, STILB_WINDOW_KEY_P},
	            {XK_v, STILB_WINDOW_KEY_V},
	            {XK_w, STILB_WINDOW_KEY_W},
	            {XK_F12, STILB_WINDOW_KEY_F12}};
	for (size_t i = 0; i < sizeof keys / sizeof *keys; i++) {
		awaited = keys[i].key;
		send_key(keys[i].symbol, true);
		stilb_window_state now = polled(key_came), expected = nothing;
		assert_true(now.held[awaited]);
		expected.pressed[awaited] = 1;
		assert_memory_equal(now.pressed, expected.pressed, sizeof now.pressed);
		send_key(keys[i].symbol, false);
		polled(key_went);
		assert_quiet();
	}
}

static void test_held_key_repeats(void **state)
{
	(void)state;
	awaited = STILB_WINDOW_KEY_DOWN;
	send_key(XK_Down, true);
	assert_int_equal(polled(key_came).repeated[awaited], 0);
	send_key(XK_Down, true); /* a second press without a release: so a keyboard repeats a held key */
	stilb_window_state now = polled(key_repeated);
	assert_int_equal(now.pressed[awaited], 0);
	assert_int_equal(now.repeated[awaited], 1);
	send_key(XK_Down, false);
	polled(key_went);
	assert_quiet();
}

/* What has come before a poll is in its state, although Xlib still holds older events: those of a new title, which come
 * with the answers to what the poll before asks the server. */
static void test_newest_behind_older(void **state)
{
	(void)state;
	stilb_window_state now;
	awaited = STILB_WINDOW_KEY_W;
	for (int i = 0; i < 10; i++) {
		stilb_window_title(window, i % 2 == 0 ? "one" : "another");
		stilb_window_poll(window, &now);
		send_key(XK_w, i % 2 == 0);
		for (int k = 0; k < 3; k++)
			XSync(display, False); /* the server sends events to others before it reads a second request from here */
		stilb_window_poll(window, &now);
		assert_int_equal(now.held[awaited], i % 2 == 0);
	}
	stilb_window_title(window, "Stilb input");
	stilb_window_poll(window, &now);
}

static bool focused(const stilb_window_state *state)
{
	return state->focused;
}

static bool unfocused(const stilb_window_state *state)
{
	return !state->focused;
}

static void test_focus(void **state)
{
	(void)state;
	Window other = XCreateSimpleWindow(display, DefaultRootWindow(display), 400, 0, 10, 10, 0, 0, 0);
	XMapWindow(display, other);
	polled(focused);
	XSetInputFocus(display, other, RevertToParent, CurrentTime);
	polled(unfocused);
	XSetInputFocus(display, target, RevertToParent, CurrentTime);
	polled(focused);
	XDestroyWindow(display, other);
	assert_quiet();
}

/* ---- mouse ------------------------------------------------------------------------------------------------------- */

static float wanted_x, wanted_y;

static bool pointer_came(const stilb_window_state *state)
{
	return state->pointer && state->pointer_x == wanted_x && state->pointer_y == wanted_y;
}

static bool pointer_left(const stilb_window_state *state)
{
	return !state->pointer;
}

static void move_pointer(Window to, int x, int y)
{
	XWarpPointer(display, None, to, 0, 0, 0, 0, x, y);
}

static void test_pointer(void **state)
{
	(void)state;
	static const int places[][2] = {{0, 0}, {17, 123}, {319, 199}};
	for (int i = 0; i < 3; i++) {
		move_pointer(target, places[i][0], places[i][1]);
		wanted_x = (float)places[i][0];
		wanted_y = (float)places[i][1];
		stilb_window_state now = polled(pointer_came);
		assert_false(now.button || now.mouse_captured);
	}
	move_pointer(DefaultRootWindow(display), 1000, 700);
	polled(pointer_left);
}

static bool clicked(const stilb_window_state *state)
{
	return state->clicks >= 2;
}

static bool button_down(const stilb_window_state *state)
{
	return state->button;
}

static bool button_up(const stilb_window_state *state)
{
	return !state->button;
}

static void test_left_button(void **state)
{
	(void)state;
	stilb_window_state now;
	send_button(1, true); /* both clicks in one frame */
	send_button(1, false);
	send_button(1, true);
	send_button(1, false);
	XSync(display, False);
	usleep(200000);
	stilb_window_poll(window, &now);
	assert_true(clicked(&now) && !now.button && now.clicks == 2);
	assert_quiet();
	send_button(1, true);
	now = polled(button_down);
	assert_int_equal(now.clicks, 1);
	move_pointer(DefaultRootWindow(display), 1000, 700); /* outside, but with the button held it is the window's */
	assert_true(polled(button_down).pointer);
	assert_quiet();
	send_button(1, false);
	polled(button_up);
	assert_quiet();
}

static bool wheel_came(const stilb_window_state *state)
{
	return state->wheel != 0.0f;
}

static void test_wheel(void **state)
{
	(void)state;
	for (unsigned button = 4; button <= 5; button++) { /* X reports the wheel as the buttons 4 (up) and 5 (down) */
		for (int i = 0; i < 3; i++) {
			send_button(button, true);
			send_button(button, false);
		}
		float turned = 0.0f;
		for (int i = 0; i < 100 && turned != (button == 4 ? 3.0f : -3.0f); i++)
			turned += polled(wheel_came).wheel;
		assert_quiet();
	}
}

static bool captured(const stilb_window_state *state)
{
	return state->mouse_captured;
}

static bool released(const stilb_window_state *state)
{
	return !state->mouse_captured;
}

static void test_right_button_captures(void **state)
{
	(void)state;
	stilb_window_state now;
	stilb_window_set_capturing(window, false);
	send_button(3, true);
	send_button(3, false);
	send_button(3, true);
	XSync(display, False);
	for (int i = 0; i < 10; i++, usleep(5000)) {
		stilb_window_poll(window, &now);
		assert_false(now.mouse_captured);
	}
	send_button(3, false);
	stilb_window_set_capturing(window, true);
	send_button(3, true);
	now = polled(captured);
	assert_false(now.pointer);
	stilb_window_set_capturing(window, false); /* a mouse that is captured already stays captured */
	stilb_window_poll(window, &now);
	assert_true(now.mouse_captured);
	send_button(3, false);
	polled(released);
}

int main(void)
{
	display = XOpenDisplay(NULL);
	if (!display) {
		printf("no X display: set DISPLAY, or install xvfb and use ./dev test\n");
		return 77;
	}
	struct CMUnitTest tests[] = {
		cmocka_unit_test(test_each_key),
		cmocka_unit_test(test_held_key_repeats),
		cmocka_unit_test(test_newest_behind_older),
		cmocka_unit_test(test_focus),
		cmocka_unit_test(test_pointer),
		cmocka_unit_test(test_left_button),
		cmocka_unit_test(test_wheel),
		cmocka_unit_test(test_right_button_captures),
	};
	int failed = cmocka_run_group_tests_name("window input", tests, set_up, tear_down);
	XCloseDisplay(display);
	return failed;
}
