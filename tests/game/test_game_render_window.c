/* stilb render --preview on a virtual display: the window shows the picture while it gets finer, and closing it ends
 * the run, which saves the picture. With the path of the module for MPI the same of ranks under mpirun, of which only
 * rank 0 has a window; skipped, with the reason, where Open MPI is missing. */
#include "image/image.h"
#include "support/stilb_program.h"
#include "support/x11_window.h"

#include <math.h>

#define TITLE "Stilb: cornell"
#define SIDE 400

static Display *display;

/* Waits until the window is visible. */
static Window wait_for_window(void)
{
	XWindowAttributes attributes = {.map_state = IsUnmapped};
	Window window = 0;
	for (int i = 0; i < 15000 && attributes.map_state != IsViewable; i++, usleep(20000)) {
		window = x11_window_find(display, TITLE);
		if (window)
			XGetWindowAttributes(display, window, &attributes);
	}
	assert_int_equal(attributes.map_state, IsViewable);
	return window;
}

static XImage *grab(Window window)
{
	XImage *image = XGetImage(display, window, 0, 0, SIDE, SIDE, AllPlanes, ZPixmap);
	assert_non_null(image);
	return image;
}

/* Reads the channels of a pixel, 0..255. */
static void channels(XImage *image, int x, int y, int out[3])
{
	unsigned long pixel = XGetPixel(image, x, y);
	for (int c = 0; c < 3; c++)
		out[c] = (int)(pixel >> (16 - 8 * c) & 0xff);
}

/* Waits until the left wall is red and the right one green: a complete, perhaps coarse, picture is shown. */
static bool shows_cornell(Window window)
{
	int left[3], right[3];
	for (int i = 0; i < 15000; i++, usleep(20000)) {
		XImage *image = grab(window);
		channels(image, SIDE / 20, SIDE / 2, left);
		channels(image, SIDE - SIDE / 20, SIDE / 2, right);
		XDestroyImage(image);
		if (left[0] > left[1] + 20 && right[1] > right[0] + 20)
			return true;
	}
	return false;
}

/* Closes the window as a window manager does. */
static void close_window(Window window)
{
	XEvent event = {0};
	event.xclient.type = ClientMessage;
	event.xclient.window = window;
	event.xclient.message_type = XInternAtom(display, "WM_PROTOCOLS", False);
	event.xclient.format = 32;
	event.xclient.data.l[0] = (long)XInternAtom(display, "WM_DELETE_WINDOW", False);
	XSendEvent(display, window, False, NoEventMask, &event);
	XSync(display, False);
}

/* Kills the run if a failed test has left it running. */
static int end_run(void **state)
{
	(void)state;
	if (run.pid > 0 && waitpid(run.pid, NULL, WNOHANG) == 0) {
		kill(run.pid, SIGKILL);
		waitpid(run.pid, NULL, 0);
	}
	return 0;
}

#define LONG "render cornell --size 400x400 --spp 4096 --workers 1 --preview "

static void test_closing_stops_and_saves(void **state)
{
	(void)state;
	stilb_start(NULL, -1, LONG "-o a.png --stats a.json");
	Window window = wait_for_window();
	assert_true(shows_cornell(window));
	close_window(window);
	program_wait(&run);
	forget_progress(run.err); /* of a slow machine */
	assert_string_equal(run.err, "");
	assert_int_equal(run.code, 0);
	assert_said(run.out, "picture: a.png");
	assert_true(access("a.png.checkpoint", F_OK) == 0);
	read_stats("a.json");
	assert_string_equal(stat_text("end", '"'), "stopped");
}

/* The window shows the picture that is saved, but for the samples between its last update and the stop. */
static void test_it_shows_what_is_saved(void **state)
{
	(void)state;
	stilb_start(NULL, -1, LONG "-o a.png");
	Window window = wait_for_window();
	assert_true(shows_cornell(window));
	usleep(1000000);
	XImage *shown = grab(window);
	close_window(window);
	program_wait(&run);
	stilb_image saved;
	assert_int_equal(stilb_image_load("a.png", &saved), STILB_OK);
	const uint8_t *pixels = saved.pixels;
	double difference = 0.0;
	for (int y = 0; y < SIDE; y++)
		for (int x = 0; x < SIDE; x++) {
			int window_pixel[3];
			channels(shown, x, y, window_pixel);
			for (int c = 0; c < 3; c++)
				difference += abs(window_pixel[c] - pixels[(y * SIDE + x) * 3 + c]);
		}
	difference /= 3.0 * SIDE * SIDE;
	if (difference > 12.0)
		print_error("the window differs from the file by %.1f codes on average\n", difference);
	assert_true(difference <= 12.0);
	XDestroyImage(shown);
	stilb_image_finish(&saved);
}

/* A run that finishes its picture closes its window at once. (Only if stderr is a terminal, so that a user is watching,
 * the window stays open until the user closes it; here it is a file.) */
static void test_it_ends_by_itself(void **state)
{
	(void)state;
	assert_int_equal(stilb_code(NULL, "render cornell --size 64x64 --spp 4 --preview -o a.exr"), 0);
	forget_progress(run.err); /* of a slow machine */
	assert_string_equal(run.err, "");
	assert_int_equal(stilb_code(no_display, "render cornell --size 64x64 --spp 4 -o b.exr"), 0);
	stilb_image a, b;
	assert_int_equal(stilb_image_load("a.exr", &a), STILB_OK);
	assert_int_equal(stilb_image_load("b.exr", &b), STILB_OK);
	assert_memory_equal(a.pixels, b.pixels, stilb_image_size(&a)); /* the preview does not change the picture */
	stilb_image_finish(&a);
	stilb_image_finish(&b);
}

static void test_without_an_output_it_is_only_looked_at(void **state)
{
	(void)state;
	stilb_start(NULL, -1, LONG);
	Window window = wait_for_window();
	close_window(window);
	program_wait(&run);
	assert_int_equal(run.code, 0);
	assert_int_equal(folder_entries(), 0);
}

/* ---- ranks ------------------------------------------------------------------------------------------------------- */

static const char *const of_ranks[] = {RANKS_ENVIRONMENT, NULL};

#define RANKS "-n 3 @ cornell --size 400x400 --spp 4096 --workers 1 --preview "

static uint32_t windows_of_this_title(void)
{
	Window root, parent, *children = NULL;
	unsigned count = 0, found = 0;
	XQueryTree(display, DefaultRootWindow(display), &root, &parent, &children, &count);
	for (unsigned i = 0; i < count; i++) {
		char *name = NULL;
		found += XFetchName(display, children[i], &name) && name && strcmp(name, TITLE) == 0;
		if (name)
			XFree(name);
	}
	XFree(children);
	return found;
}

static void test_ranks_have_one_window(void **state)
{
	(void)state;
	ranks_start(of_ranks, RANKS "-o a.png --stats a.json");
	Window window = wait_for_window();
	for (int i = 0; i < 50; i++, usleep(20000)) /* the others would have theirs by then */
		assert_int_equal(windows_of_this_title(), 1);
	assert_true(shows_cornell(window));
	close_window(window);
	program_wait(&run);
	forget_progress(run.err); /* of a slow machine */
	assert_string_equal(run.err, "");
	assert_int_equal(run.code, 0);
	assert_said(run.out, "picture: a.png");
	assert_true(access("a.png.checkpoint", F_OK) == 0);
	read_stats("a.json");
	assert_string_equal(stat_text("end", '"'), "stopped");
	assert_int_equal(stat_int("ranks"), 3);
}

/* The preview does not change the picture, and neither does its lack, of which rank 0 tells once. */
static void test_ranks_make_the_same_picture(void **state)
{
	static const char *const broken[] = {"DISPLAY=:987654", "WAYLAND_DISPLAY", RANKS_ENVIRONMENT, NULL};
	(void)state;
	stilb_good("render cornell --size 72x48 --spp 8 -o whole.exr");
	ranks_start(of_ranks, "-n 3 @ cornell --size 72x48 --spp 8 --preview -o ranks.exr");
	program_wait(&run);
	forget_progress(run.err); /* of a slow machine */
	assert_string_equal(run.err, "");
	assert_int_equal(run.code, 0);
	assert_true(same_file("whole.exr", "ranks.exr"));
	ranks_start(broken, "-n 3 @ cornell --size 72x48 --spp 8 --preview -o blind.exr");
	program_wait(&run);
	assert_said(run.err, "rendering without a preview");
	assert_int_equal(program_lines(run.err), 1);
	assert_int_equal(run.code, 0);
	assert_true(same_file("whole.exr", "blind.exr"));
}

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup_teardown(test_closing_stops_and_saves, folder_fresh, end_run),
		cmocka_unit_test_setup_teardown(test_it_shows_what_is_saved, folder_fresh, end_run),
		cmocka_unit_test_setup_teardown(test_it_ends_by_itself, folder_fresh, end_run),
		cmocka_unit_test_setup_teardown(test_without_an_output_it_is_only_looked_at, folder_fresh, end_run),
	};
	const struct CMUnitTest of_mpi[] = {
		cmocka_unit_test_setup_teardown(test_ranks_have_one_window, folder_fresh, end_run),
		cmocka_unit_test_setup_teardown(test_ranks_make_the_same_picture, folder_fresh, end_run),
	};
	if (argc > 2 && ranks_are_missing(argv[2]))
		return 77;
	display = XOpenDisplay(NULL);
	if (!display) {
		printf("no X display: set DISPLAY, or install xvfb and use ./dev test\n");
		return 77;
	}
	if (!folder_enter(argc > 1 ? argv[1] : NULL, argc > 2 ? "game_render_window_mpi" : "game_render_window")) {
		fprintf(stderr, "usage: %s PATH-OF-STILB [PATH-OF-MODULE]\n", argv[0]);
		return 2;
	}
	int failed = argc > 2 ? cmocka_run_group_tests(of_mpi, NULL, folder_leave)
	                      : cmocka_run_group_tests(tests, NULL, folder_leave);
	XCloseDisplay(display);
	return failed;
}
