/* The X server dies during stilb demo and stilb render --preview: they continue without a window and write their
 * outputs. */
#include "image/image.h"
#include "support/stilb_program.h"
#include "support/x11_server.h"

#include <X11/Xutil.h>
#include <X11/keysym.h>

static x11_server server;

/* Starts a run on an X server of its own, and kills the server once a window with this title is visible. */
static void start_until_the_server_dies(const char *line, const char *title)
{
	char display[64];
	assert_true(x11_server_start(&server));
	snprintf(display, sizeof display, "DISPLAY=%s", server.name);
	const char *const environment[] = {display, "WAYLAND_DISPLAY", NULL};
	stilb_start(environment, -1, line);
	bool shown = x11_server_shows(&server, title);
	x11_server_kill(&server);
	if (!shown)
		kill(run.pid, SIGKILL);
	assert_true(shown);
}

/* Waits until the run has reported that the display is gone and has worked on for a while; then interrupts it. */
static void interrupt_after_the_loss(void)
{
	struct stat said = {0};
	for (int i = 0; i < 3000 && said.st_size == 0; i++, usleep(10000))
		assert_int_equal(fstat(fileno(run.files[1]), &said), 0);
	bool working = said.st_size > 0 && catches_interrupts(run.pid);
	kill(run.pid, working ? SIGINT : SIGKILL);
	program_wait(&run);
	assert_true(working);
	assert_error_lines(1);
	assert_int_equal(run.code, 0);
}

static int server_end(void **state)
{
	(void)state;
	x11_server_kill(&server);
	return 0;
}

#define DEMO                                                                                                           \
	"demo --models 200 --size 160x120 --workers 2 --trace t.json --stats s.json --screenshot p.png --track k.csv "

static void assert_demo_wrote_all(void)
{
	stilb_image picture;
	trace_check_report report;
	trace_check_file("t.json", &report);
	assert_string_equal(report.error, "");
	trace_check_finish(&report);
	assert_int_equal(stilb_image_load("p.png", &picture), STILB_OK);
	assert_int_equal(picture.width, 160);
	stilb_image_finish(&picture);
	assert_int_equal(access("k.csv", F_OK), 0);
	assert_int_equal(folder_entries(), 4);
	read_stats("s.json");
}

/* A demo without --frames ends with its window, because nobody could end it any more. */
static void test_demo_without_end(void **state)
{
	(void)state;
	start_until_the_server_dies(DEMO, "Stilb: "); /* so the title begins after the first frame */
	program_wait(&run);
	assert_error_lines(1);
	assert_said(run.err, "the display has gone after ");
	assert_said(run.err, "; ending the run, because no window is left to close");
	assert_int_equal(run.code, 1);
	assert_demo_wrote_all();
	assert_true(stat_int("frames") > 0);
}

static void test_demo_with_frames_to_draw_goes_on(void **state)
{
	(void)state;
	start_until_the_server_dies(DEMO "--frames 1000000", "Stilb: ");
	interrupt_after_the_loss();
	const char *after = strstr(run.err, "the display has gone after ");
	assert_non_null(after);
	assert_said(run.err, " frames; running on headless");
	assert_demo_wrote_all();
	assert_true(stat_int("frames") > atoll(after + strlen("the display has gone after ")));
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

static bool await_whole(const char *path)
{
	stilb_image picture;
	for (int i = 0; i < 15000; i++, usleep(20000))
		if (access(path, F_OK) == 0 && stilb_image_load(path, &picture) == STILB_OK) {
			stilb_image_finish(&picture);
			return true;
		}
	return false;
}

/* Each picture by F12 gets a new file, which is neither an older one nor that of --screenshot; the trace shows the time
 * that its frame takes. */
static void test_pictures_are_numbered(void **state)
{
	(void)state;
	char display_name[64], text[16] = "";
	assert_true(x11_server_start(&server));
	snprintf(display_name, sizeof display_name, "DISPLAY=%s", server.name);
	const char *const environment[] = {display_name, "WAYLAND_DISPLAY", NULL};
	FILE *file = fopen("p-3.png", "w");
	assert_non_null(file);
	fputs("mine", file);
	fclose(file);
	stilb_start(environment, -1, "demo --models 200 --size 160x120 --workers 1 --trace t.json --screenshot p.png");
	Display *display = XOpenDisplay(server.name);
	assert_non_null(display);
	Window window = x11_server_await(display, "Stilb: ");
	bool taken = window != 0;
	static const char *const names[] = {"p-2.png", "p-4.png"};
	for (int i = 0; taken && i < 2; i++) {
		x11_server_type(display, window, XK_F12);
		taken = await_whole(names[i]);
	}
	kill(run.pid, SIGINT);
	program_wait(&run);
	XCloseDisplay(display);
	assert_true(taken);
	assert_int_equal(run.code, 0);
	assert_said(run.out, "picture: p-2.png\n");
	assert_said(run.out, "picture: p-4.png\n");
	assert_true(await_whole("p.png"));
	file = fopen("p-3.png", "r");
	assert_true(file && fread(text, 1, sizeof text - 1, file) == 4);
	fclose(file);
	assert_string_equal(text, "mine");
	trace_check_report report;
	trace_check_file("t.json", &report);
	assert_string_equal(report.error, "");
	assert_int_equal(trace_check_zones(&report, "main", "take the picture"), 2); /* by F12 */
	assert_int_equal(trace_check_zones(&report, "pictures", "write the picture"), 2);
	assert_int_equal(trace_check_zones(&report, "main", "write the picture"), 1); /* the one at the end */
	trace_check_finish(&report);
	assert_int_equal(folder_entries(), 5);
}

/* A number that two equal pictures of the window share. */
static uint64_t window_hash(Display *display, Window window)
{
	XImage *image = XGetImage(display, window, 0, 0, 160, 120, AllPlanes, ZPixmap);
	uint64_t hash = 14695981039346656037u; /* FNV-1a */
	for (int i = 0; image && i < image->bytes_per_line * image->height; i++)
		hash = (hash ^ (uint8_t)image->data[i]) * 1099511628211u;
	if (image)
		XDestroyImage(image);
	return hash;
}

/* The scene stands still, so that the toast is all that changes in the window. */
static bool await_change(Display *display, Window window, uint64_t from)
{
	for (int i = 0; i < 3000; i++, usleep(10000))
		if (window_hash(display, window) != from)
			return true;
	return false;
}

/* The window says that a picture was written, and the next picture is saved without those words. */
static void test_toast_is_not_in_pictures(void **state)
{
	(void)state;
	char display_name[64];
	stilb_image pictures[2] = {{0}};
	assert_true(x11_server_start(&server));
	snprintf(display_name, sizeof display_name, "DISPLAY=%s", server.name);
	const char *const environment[] = {display_name, "WAYLAND_DISPLAY", NULL};
	stilb_start(environment, -1, "demo --models 200 --size 160x120 --workers 1");
	Display *display = XOpenDisplay(server.name);
	assert_non_null(display);
	Window window = x11_server_await(display, "Stilb: ");
	bool told = window != 0;
	for (int i = 0; told && !x11_server_has_picture(display, window); i++, usleep(10000))
		told = i < 3000;
	uint64_t before = told ? window_hash(display, window) : 0;
	if (told)
		x11_server_type(display, window, XK_F12);
	told = told && await_whole("stilb-demo.png") && await_change(display, window, before);
	if (told)
		x11_server_type(display, window, XK_F12);
	told = told && await_whole("stilb-demo-2.png");
	kill(run.pid, SIGINT);
	program_wait(&run);
	XCloseDisplay(display);
	assert_true(told);
	assert_int_equal(run.code, 0);
	assert_int_equal(stilb_image_load("stilb-demo.png", &pictures[0]), STILB_OK);
	assert_int_equal(stilb_image_load("stilb-demo-2.png", &pictures[1]), STILB_OK);
	assert_int_equal(stilb_image_size(&pictures[0]), stilb_image_size(&pictures[1]));
	assert_memory_equal(pictures[0].pixels, pictures[1].pixels, stilb_image_size(&pictures[0]));
	stilb_image_finish(&pictures[0]);
	stilb_image_finish(&pictures[1]);
}

static void test_render_goes_on(void **state)
{
	(void)state;
	start_until_the_server_dies(
		"render cornell --size 100x100 --spp 65536 --workers 1 --preview -o a.png --stats s.json", "Stilb: cornell");
	interrupt_after_the_loss();
	assert_said(run.err, "without a preview"); /* either the window or the driver notices first, and gives the reason */
	read_stats("s.json");
	assert_string_equal(stat_text("end", '"'), "stopped");
	assert_true(stat_int("camera_rays") > 0);
	stilb_image picture;
	assert_int_equal(stilb_image_load("a.png", &picture), STILB_OK);
	stilb_image_finish(&picture);
}

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup_teardown(test_demo_without_end, folder_fresh, server_end),
		cmocka_unit_test_setup_teardown(test_demo_with_frames_to_draw_goes_on, folder_fresh, server_end),
		cmocka_unit_test_setup_teardown(test_render_goes_on, folder_fresh, server_end),
		cmocka_unit_test_setup_teardown(test_pictures_are_numbered, folder_fresh, server_end),
		cmocka_unit_test_setup_teardown(test_toast_is_not_in_pictures, folder_fresh, server_end),
	};
	if (!x11_server_start(&server)) {
		printf("no Xvfb: install xvfb\n");
		return 77;
	}
	x11_server_kill(&server);
	if (!folder_enter(argc > 1 ? argv[1] : NULL, "game_display")) {
		fprintf(stderr, "usage: %s PATH-OF-STILB\n", argv[0]);
		return 2;
	}
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}
