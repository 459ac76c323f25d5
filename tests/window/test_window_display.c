/* A window whose X server dies: every call still returns, the state says it, and nothing ends the program. */
#include "support/test.h"
#include "support/x11_server.h"
#include "window/window.h"

static x11_server server;
static Display *other; /* the test's own connection: broken too, so never closed */
static char error[64]; /* name of the display that was given to the test's own handler of broken connections */

static int other_lost(Display *display)
{
	snprintf(error, sizeof error, "%s", DisplayString(display));
	return 0;
}

static void other_exit(Display *display, void *data)
{
	(void)display;
	*(bool *)data = true;
}

static void test_every_call_outlives_the_display(void **state)
{
	(void)state;
	stilb_window *window, *second;
	stilb_window_state now;
	stilb_window_gamepad pads[STILB_WINDOW_GAMEPADS];
	uint64_t surface = 1;
	bool other_ended = false;
	assert_true(x11_server_start(&server));
	assert_int_equal(setenv("DISPLAY", server.name, 1), 0);
	other = XOpenDisplay(server.name);
	assert_non_null(other);
	XSetIOErrorHandler(other_lost);
	XSetIOErrorExitHandler(other, other_exit, &other_ended);
	assert_int_equal(stilb_window_create("display", 200, 100, &window), STILB_OK);
	stilb_window_poll(window, &now);
	assert_false(now.lost);
	assert_true(now.width > 0);
	x11_server_kill(&server);
	stilb_window_wait(window, 600.0, &now); /* returns at once, as the display is lost */
	assert_true(now.lost);
	assert_int_equal(now.width, 0);
	assert_false(now.close);
	assert_string_equal(error, "");
	stilb_window_poll(window, &now);
	assert_true(now.lost);
	stilb_window_title(window, "gone");
	stilb_window_set_capturing(window, false);
	stilb_window_gamepads(window, pads);
	assert_null(pads[0].name);
	assert_int_not_equal(stilb_window_surface_create(window, NULL, &surface), 0);
	assert_int_equal(surface, 0);
	stilb_window_destroy(window);
	assert_int_equal(stilb_window_create("again", 200, 100, &second), STILB_ERROR_WINDOW);
	assert_null(second);
	assert_non_null(strstr(stilb_error_message(), "display has gone"));
	XSync(other, False); /* the test's own connection breaks, too: its own handlers must be called */
	assert_string_equal(error, server.name);
	assert_true(other_ended);
}

int main(void)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(test_every_call_outlives_the_display)};
	if (!x11_server_start(&server)) {
		printf("no Xvfb: install xvfb\n");
		return 77;
	}
	x11_server_kill(&server);
	return cmocka_run_group_tests(tests, NULL, NULL);
}
