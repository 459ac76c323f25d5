/* The asserts of window.h, each made to fail on purpose. No display is needed: they come before GLFW is called. */
#include "support/contract.h"
#include "support/test.h"
#include "window/window.h"
#include "window/window_display_internal.h"

#include <math.h>

static void nothing(void *data)
{
	(void)data;
}

static void call_within_a_call(void *data)
{
	window_display_call(nothing, data);
}

static void begin_within_a_call(void *data)
{
	(void)data;
	window_display_begin();
}

static void a_window_has_a_title_and_a_size(void **state)
{
	(void)state;
	stilb_window *window;
	contract_breaks("title && out", stilb_window_create(NULL, 320, 200, &window));
	contract_breaks("title && out", stilb_window_create("t", 320, 200, NULL));
	contract_breaks("a width in pixels", stilb_window_create("t", 0, 200, &window));
	contract_breaks("a height in pixels", stilb_window_create("t", 320, 16385, &window));
}

static void calls_want_a_window_and_a_place(void **state)
{
	(void)state;
	static char memory[4096] __attribute__((aligned(64))); /* a window of zeros: no thread is its owner */
	stilb_window *window = (stilb_window *)memory;
	stilb_window_state seen;
	stilb_window_gamepad gamepads[STILB_WINDOW_GAMEPADS];
	contract_breaks("window && title", (stilb_window_title(NULL, "t"), 0));
	contract_breaks("window && title", (stilb_window_title(window, NULL), 0));
	contract_breaks("`window' failed", (stilb_window_set_capturing(NULL, true), 0));
	contract_breaks("window && state", (stilb_window_poll(NULL, &seen), 0));
	contract_breaks("window && state", (stilb_window_poll(window, NULL), 0));
	contract_breaks("a time to wait", (stilb_window_wait(window, (double)NAN, &seen), 0));
	contract_breaks("window && gamepads", (stilb_window_gamepads(NULL, gamepads), 0));
	contract_breaks("window && gamepads", (stilb_window_gamepads(window, NULL), 0));
	contract_breaks("user && count", stilb_window_surface_extensions(window, NULL));
	contract_breaks("user && surface", stilb_window_surface_create(window, memory, NULL));
}

static void calls_to_the_display_are_not_nested(void **state)
{
	(void)state;
	contract_breaks("calls are not nested", window_display_call(call_within_a_call, NULL));
	contract_breaks("GLFW is not being called", window_display_call(begin_within_a_call, NULL));
	contract_breaks("`call' failed", window_display_call(NULL, NULL));
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_window_has_a_title_and_a_size),
		cmocka_unit_test(calls_want_a_window_and_a_place),
		cmocka_unit_test(calls_to_the_display_are_not_nested),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
