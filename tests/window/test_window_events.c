/*
 * The engine in a window under a virtual display. The test plays window manager and user through a second connection to
 * the display, so their actions fall into the middle of frames. All under Vulkan validation.
 */
#include "engine_internal.h"
#include "shading/shade_brdf.h"
#include "support/test.h"
#include "support/x11_window.h"
#include "tests/engine/stress_engine.h"

#include <X11/Xatom.h>
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

typedef struct fixture {
	stilb_engine *engine;
	Display *display; /* the test's own connection to the X server */
	Window window;
} fixture;

enum { FEWER = STILB_ENGINE_ACTIONS };
static const stilb_input_action actions[] = {{.name = "fewer", .typed = "-", .help = "fewer workers"}};

static int set_up(void **state)
{
	fixture *f = calloc(1, sizeof *f);
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.workers = 1;
	desc.width = 320;
	desc.height = 200;
	desc.window = true;
	desc.validate = true;
	desc.saves = true;
	desc.actions = actions;
	desc.action_count = sizeof actions / sizeof *actions;
	if (!f || stress_engine_create(&desc, &(stress_engine){.models = 25, .seed = 1}, &f->engine) != STILB_OK) {
		fprintf(stderr, "%s\n", stilb_error_message());
		return -1;
	}
	f->display = XOpenDisplay(NULL);
	f->window = f->display ? x11_window_find(f->display, "Stilb") : 0;
	*state = f;
	return f->window ? 0 : -1;
}

static int tear_down(void **state)
{
	fixture *f = *state;
	stress_engine_destroy(f->engine);
	XCloseDisplay(f->display);
	free(f);
	return 0;
}

static stilb_engine_report run_frame(fixture *f)
{
	stilb_engine_report report;
	stilb_result result = stilb_engine_frame(f->engine, &report);
	if (result != STILB_OK)
		fprintf(stderr, "%s\n", stilb_error_message());
	assert_int_equal(result, STILB_OK);
	assert_int_equal(stilb_engine_validation_messages(f->engine), 0);
	return report;
}

static void run_frames(fixture *f, int count)
{
	for (int i = 0; i < count; i++)
		run_frame(f);
}

/* Runs frames until the picture has this size, which it must have within a limit of frames. */
static void expect_size(fixture *f, uint32_t width, uint32_t height)
{
	uint32_t w = 0, h = 0;
	for (int i = 0; i < 10000 && (w != width || h != height); i++) {
		run_frame(f);
		stilb_engine_size(f->engine, &w, &h);
	}
	assert_int_equal(w, width);
	assert_int_equal(h, height);
}

/* The window shows the drawn picture: both the colour of the ground, on which the camera looks down, and others. */
static void test_shows_picture(void **state)
{
	fixture *f = *state;
	run_frames(f, 5);
	stilb_engine_report report;
	do /* several frames, because the copy of the last one to the window may not be done yet */
		report = run_frame(f);
	while (report.frame < 10);
	double gpu_ms;
	assert_int_equal(stilb_engine_wait(f->engine, &gpu_ms), STILB_OK);
	assert_true(gpu_ms > 0.0);
	const float *ground = stilb_engine_scene(f->engine)->surroundings.ground;
	assert_true(ground[0] > ground[2]); /* more red than blue, as is looked for below */
	XImage *image = NULL;
	int ground_pixels = 0, other_pixels = 0;
	for (int tries = 0; tries < 15000 && (ground_pixels == 0 || other_pixels == 0); tries++) {
		image = XGetImage(f->display, f->window, 0, 0, 320, 200, AllPlanes, ZPixmap);
		assert_non_null(image);
		unsigned long corner = XGetPixel(image, 0, 0);
		ground_pixels = other_pixels = 0;
		for (int i = 0; i < 320 * 200; i++)
			*(XGetPixel(image, i % 320, i / 320) == corner ? &ground_pixels : &other_pixels) += 1;
		unsigned blue = corner & 0xff, red = corner >> 16 & 0xff;
		XDestroyImage(image);
		if (red <= blue)
			ground_pixels = 0; /* the window is not drawn yet: look again */
		usleep(20000);
	}
	assert_true(ground_pixels > 320 * 200 / 20);
	assert_true(other_pixels > 320 * 200 / 20);
}

static void test_resize(void **state)
{
	static const unsigned sizes[][2] = {{640, 480}, {1, 1}, {801, 603}, {33, 700}, {320, 200}};
	fixture *f = *state;
	run_frames(f, 3);
	for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
		XResizeWindow(f->display, f->window, sizes[i][0], sizes[i][1]);
		XSync(f->display, False);
		expect_size(f, sizes[i][0], sizes[i][1]);
		run_frames(f, 3);
	}
}

typedef struct shaker {
	Window window;
	_Atomic bool stop; /* relaxed in both threads: it only ends the loop, and no other data depends on it */
} shaker;

static void *shake(void *data)
{
	shaker *s = data;
	Display *display = XOpenDisplay(NULL);
	for (unsigned i = 0; display && !atomic_load_explicit(&s->stop, memory_order_relaxed); i++) {
		XResizeWindow(display, s->window, 100 + i * 37 % 300, 100 + i * 53 % 200);
		XSync(display, False);
		usleep(500 + i * 911 % 3000);
	}
	if (display)
		XCloseDisplay(display);
	return NULL;
}

/* The window is resized from another thread, at any point of a frame: between polling and presenting, too. */
static void test_resize_during_frames(void **state)
{
	fixture *f = *state;
	shaker s = {.window = f->window};
	pthread_t thread;
	assert_int_equal(pthread_create(&thread, NULL, shake, &s), 0);
	for (int i = 0; i < (TEST_ASAN ? 60 : 150); i++) {
		stilb_engine_report report;
		if (stilb_engine_frame(f->engine, &report) != STILB_OK || stilb_engine_validation_messages(f->engine) > 0)
			break;
	}
	atomic_store_explicit(&s.stop, true, memory_order_relaxed);
	pthread_join(thread, NULL);
	XResizeWindow(f->display, f->window, 320, 200);
	XSync(f->display, False);
	expect_size(f, 320, 200);
}

/* Minimises as a window manager does: the state becomes iconic, and the window is unmapped. */
static void set_iconic(fixture *f, bool iconic)
{
	Atom wm_state = XInternAtom(f->display, "WM_STATE", False);
	unsigned long value[2] = {iconic ? IconicState : NormalState, 0};
	XChangeProperty(f->display, f->window, wm_state, wm_state, 32, PropModeReplace, (unsigned char *)value, 2);
	if (iconic)
		XUnmapWindow(f->display, f->window);
	else
		XMapWindow(f->display, f->window);
	XSync(f->display, False);
}

static void test_minimise(void **state)
{
	fixture *f = *state;
	run_frames(f, 3);
	set_iconic(f, true);
	stilb_engine_report report = run_frame(f);
	for (int i = 0; i < 10000 && report.drawn; i++)
		report = run_frame(f);
	assert_false(report.drawn);
	uint64_t frames = report.frame;
	for (int i = 0; i < 3; i++)
		report = run_frame(f);
	assert_false(report.drawn);
	assert_int_equal(report.frame, frames);
	set_iconic(f, false);
	for (int i = 0; i < 10000 && !report.drawn; i++)
		report = run_frame(f);
	assert_true(report.drawn);
	run_frames(f, 3);
}

/* state: the modifier keys that are held, as in XKeyEvent. */
static void send_key_with(fixture *f, KeySym key, unsigned state, bool down)
{
	XKeyEvent event = {
		.state = state,
		.type = down ? KeyPress : KeyRelease,
		.display = f->display,
		.window = f->window,
		.root = DefaultRootWindow(f->display),
		.time = CurrentTime,
		.same_screen = True,
		.keycode = XKeysymToKeycode(f->display, key),
	};
	XSendEvent(f->display, f->window, True, down ? KeyPressMask : KeyReleaseMask, (XEvent *)&event);
	XSync(f->display, False);
}

static void send_key(fixture *f, KeySym key, bool down)
{
	send_key_with(f, key, 0, down);
}

static void await_card(fixture *f, bool open)
{
	for (int i = 0; i < 10000 && f->engine->overlay.keys.open != open; i++)
		run_frame(f);
	assert_int_equal(f->engine->overlay.keys.open, open);
	run_frames(f, 2);
}

/* The card is opened by the key H and by the character ?, wherever the layout has it. */
static void test_key_card(void **state)
{
	fixture *f = *state;
	run_frames(f, 3);
	send_key(f, XK_h, true);
	send_key(f, XK_h, false);
	await_card(f, true);
	send_key_with(f, XK_question, ShiftMask, true);
	send_key_with(f, XK_question, ShiftMask, false);
	await_card(f, false);
}

static void test_keys(void **state)
{
	fixture *f = *state;
	run_frames(f, 3);
	send_key(f, XK_p, true);
	send_key(f, XK_p, false);
	send_key(f, XK_F12, true);
	send_key(f, XK_F12, false);
	send_key(f, XK_minus, true);
	send_key(f, XK_minus, false);
	bool capture = false, screenshot = false;
	uint32_t fewer = 0;
	for (int i = 0; i < 50 && !(capture && screenshot && fewer); i++) {
		stilb_engine_report report = run_frame(f);
		capture |= report.input.actions[STILB_ENGINE_CAPTURE] > 0;
		screenshot |= report.input.actions[STILB_ENGINE_PICTURE] > 0;
		fewer += report.input.actions[FEWER];
	}
	assert_true(capture);
	assert_true(screenshot);
	assert_int_equal(fewer, 1);

	const stilb_scene_camera *camera = &stilb_engine_scene(f->engine)->camera;
	float before = camera->position[2];
	send_key(f, XK_w, true);
	for (int i = 0; i < 10000 && camera->position[2] == before; i++)
		run_frame(f);
	send_key(f, XK_w, false);
	assert_true(camera->position[2] < before); /* forward is -Z */
	float way = 1.0f, rest;
	for (int i = 0; i < 10000 && way > 1e-5f; i++) { /* the key is released: the camera slows down and stands still */
		rest = camera->position[2];
		run_frames(f, 30);
		way = fabsf(camera->position[2] - rest);
	}
	assert_true(way <= 1e-5f);
}

/* The window loses the keyboard while a key is held: the camera does not glide on. */
static void test_focus(void **state)
{
	fixture *f = *state;
	const stilb_scene_camera *camera = &stilb_engine_scene(f->engine)->camera;
	Window other = XCreateSimpleWindow(f->display, DefaultRootWindow(f->display), 400, 0, 10, 10, 0, 0, 0);
	XMapWindow(f->display, other);
	XSetInputFocus(f->display, f->window, RevertToParent, CurrentTime);
	run_frames(f, 3);
	float before = camera->position[2];
	send_key(f, XK_w, true);
	for (int i = 0; i < 10000 && camera->position[2] == before; i++)
		run_frame(f);
	assert_true(camera->position[2] < before);
	XSetInputFocus(f->display, other, RevertToParent, CurrentTime);
	XSync(f->display, False);
	for (int i = 0; i < 10000 && f->engine->input.focused; i++)
		run_frame(f);
	assert_false(f->engine->input.focused);
	before = camera->position[2];
	run_frames(f, 5);
	assert_true(camera->position[2] == before);
	XDestroyWindow(f->display, other);
}

static void send_button(fixture *f, unsigned button, bool down)
{
	XButtonEvent event = {
		.type = down ? ButtonPress : ButtonRelease,
		.display = f->display,
		.window = f->window,
		.root = DefaultRootWindow(f->display),
		.time = CurrentTime,
		.same_screen = True,
		.button = button,
	};
	XSendEvent(f->display, f->window, True, down ? ButtonPressMask : ButtonReleaseMask, (XEvent *)&event);
	XSync(f->display, False);
}

static void type_key(fixture *f, KeySym key)
{
	send_key(f, key, true);
	send_key(f, key, false);
}

static bool overlay_is_open(const fixture *f)
{
	return f->engine->overlay.profiler_open;
}

static bool overlay_is_frozen(const fixture *f)
{
	return f->engine->overlay.profiler_open && stilb_ui_profiler_frozen(f->engine->overlay.profiler);
}

static bool overlay_wants_mouse(const fixture *f)
{
	return stilb_ui_wants_mouse(f->engine->overlay.ui);
}

static bool overlay_wants_keys(const fixture *f)
{
	return stilb_ui_wants_keys(f->engine->overlay.ui);
}

static bool overlay_feels_wheel(const fixture *f)
{
	return f->engine->overlay.input.wheel == 1.0f && f->engine->overlay.input.mouse_y == 400.0f;
}

/* Runs frames until what(f) == wanted. */
static void expect(fixture *f, bool (*what)(const fixture *f), bool wanted)
{
	for (int i = 0; i < 10000 && what(f) != wanted; i++)
		run_frame(f);
	assert_true(what(f) == wanted);
}

/* F1 opens and closes the profiler, space freezes it; mouse and keys that are used in it do not move the camera. */
static void test_overlay(void **state)
{
	fixture *f = *state;
	const stilb_scene_camera *camera = &stilb_engine_scene(f->engine)->camera;
	XSetInputFocus(f->display, f->window, RevertToParent, CurrentTime); /* as a window manager would */
	XResizeWindow(f->display, f->window, 640, 480); /* in a small window the profiler is words alone */
	XSync(f->display, False);
	expect_size(f, 640, 480);
	run_frames(f, 3);
	assert_false(overlay_is_open(f));
	type_key(f, XK_F1);
	expect(f, overlay_is_open, true);
	run_frames(f, 10);
	type_key(f, XK_space);
	expect(f, overlay_is_frozen, true);
	run_frames(f, 3);
	type_key(f, XK_space);
	expect(f, overlay_is_frozen, false);

	XWarpPointer(f->display, None, f->window, 0, 0, 0, 0, 320, 400);
	XSync(f->display, False);
	expect(f, overlay_wants_mouse, true);
	send_button(f, 4, true);
	send_button(f, 4, false);
	expect(f, overlay_feels_wheel, true);
	float yaw = camera->yaw;
	send_button(f, 3, true);
	XWarpPointer(f->display, None, f->window, 0, 0, 0, 0, 350, 410);
	XSync(f->display, False);
	run_frames(f, 5);
	assert_true(camera->yaw == yaw); /* over the profiler the right button does not turn the camera */
	send_button(f, 3, false);

	type_key(f, XK_Tab);
	expect(f, overlay_wants_keys, true);
	float before = camera->position[2];
	send_key(f, XK_w, true);
	run_frames(f, 5);
	assert_true(camera->position[2] == before);
	type_key(f, XK_Escape);
	expect(f, overlay_wants_keys, false);
	for (int i = 0; i < 10000 && camera->position[2] == before; i++)
		run_frame(f);
	send_key(f, XK_w, false);
	assert_true(camera->position[2] < before); /* the key is still held: now the camera flies */

	type_key(f, XK_F1);
	expect(f, overlay_is_open, false);
	send_button(f, 3, true);
	run_frames(f, 3);
	for (int i = 0; i < 10000 && camera->yaw == yaw; i++) {
		XWarpPointer(f->display, None, f->window, 0, 0, 0, 0, 160 + i % 2 * 40, 100);
		XSync(f->display, False);
		run_frame(f);
	}
	send_button(f, 3, false);
	assert_true(camera->yaw != yaw);
	run_frames(f, 3);
}

static bool inspector_is_open(const fixture *f)
{
	return f->engine->overlay.inspector_open;
}

static bool shades_as_microfacets(const fixture *f)
{
	return stilb_engine_shading(f->engine).brdf == SHADE_BRDF_MICROFACET;
}

static bool shades_with_blinn(const fixture *f)
{
	return stilb_engine_shading(f->engine).ndf == SHADE_NDF_BLINN;
}

static void click_at(fixture *f, float x, float y)
{
	XWarpPointer(f->display, None, f->window, 0, 0, 0, 0, (int)x, (int)y);
	XSync(f->display, False);
	expect(f, overlay_wants_mouse, true);
	send_button(f, 1, true);
	send_button(f, 1, false);
}

/* F2 opens and closes the materials' window; a click in it changes the formulas of the frames that follow. */
static void test_inspector(void **state)
{
	fixture *f = *state;
	XSetInputFocus(f->display, f->window, RevertToParent, CurrentTime);
	XResizeWindow(f->display, f->window, 640, 480);
	XSync(f->display, False);
	expect_size(f, 640, 480);
	run_frames(f, 3);
	assert_false(inspector_is_open(f));
	type_key(f, XK_F2);
	expect(f, inspector_is_open, true);
	assert_false(overlay_is_open(f));
	run_frames(f, 2);
	type_key(f, XK_space); /* has no effect in the materials' window */
	run_frames(f, 2);
	uint64_t hash = stilb_engine_stream_hash(f->engine);
	stilb_ui_rect place = f->engine->overlay.inspector.place;
	const stilb_ui_style *style = stilb_ui_style_get(f->engine->overlay.ui);
	/* In so low a picture there are three columns: the first row of the middle one, below the title and a heading. */
	click_at(f, 0.5f * (place.x0 + place.x1),
	         place.y0 + style->title_height + style->margin + 1.5f * style->row_height);
	expect(f, shades_as_microfacets, true);
	assert_true(shades_with_blinn(f));
	for (int i = 0; i < 10000 && stilb_engine_stream_hash(f->engine) == hash; i++)
		run_frames(f, 1); /* they show the formulas before until others are compiled */
	assert_true(stilb_engine_stream_hash(f->engine) != hash);

	type_key(f, XK_F1); /* the profiler, beside the materials' window */
	expect(f, overlay_is_open, true);
	assert_true(inspector_is_open(f));
	run_frames(f, 3);
	type_key(f, XK_F2);
	expect(f, inspector_is_open, false);
	assert_true(overlay_is_open(f));
	type_key(f, XK_F1);
	expect(f, overlay_is_open, false);
	assert_true(shades_as_microfacets(f)); /* the choice stays when the window is closed */
	type_key(f, XK_F2);
	expect(f, inspector_is_open, true);
	run_frames(f, 2);
	click_at(f, place.x1 - 14.0f, place.y0 + 13.0f); /* the box with the cross */
	expect(f, inspector_is_open, false);
	run_frames(f, 2);
}

static void test_close(void **state)
{
	fixture *f = *state;
	run_frames(f, 2);
	XClientMessageEvent event = {
		.type = ClientMessage,
		.window = f->window,
		.message_type = XInternAtom(f->display, "WM_PROTOCOLS", False),
		.format = 32,
		.data.l = {(long)XInternAtom(f->display, "WM_DELETE_WINDOW", False)},
	};
	XSendEvent(f->display, f->window, False, NoEventMask, (XEvent *)&event);
	XSync(f->display, False);
	stilb_engine_report report = run_frame(f);
	for (int i = 0; i < 10000 && !report.close; i++)
		report = run_frame(f);
	assert_true(report.close);
}

int main(void)
{
	Display *display = XOpenDisplay(NULL);
	if (!display) {
		printf("no X display: set DISPLAY, or install xvfb and use ./dev test\n");
		return 77;
	}
	struct CMUnitTest tests[] = {
		cmocka_unit_test_setup_teardown(test_shows_picture, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_resize, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_resize_during_frames, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_minimise, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_keys, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_key_card, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_focus, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_overlay, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_inspector, set_up, tear_down),
		cmocka_unit_test_setup_teardown(test_close, set_up, tear_down),
	};
	int failed = cmocka_run_group_tests_name("window events", tests, NULL, NULL);
	XCloseDisplay(
		display); /* held until here: a display server without clients may start anew and refuse for a moment */
	return failed;
}
