/* The X server dies under stilb demo and stilb render --preview: they go on without it, and write what was asked for. */
#include "image/image.h"
#include "support/stilb_program.h"
#include "support/x11_server.h"

static x11_server server;

/* Starts a run on a server of its own, and kills the server when a window of this title can be seen. */
static void run_until_the_server_dies(const char *line, const char *title)
{
	char display[64];
	assert_true(x11_server_start(&server));
	snprintf(display, sizeof display, "DISPLAY=%s", server.name);
	const char *const environment[] = {display, "WAYLAND_DISPLAY", NULL};
	stilb_start(environment, -1, line);
	const bool shown = x11_server_shows(&server, title);
	x11_server_kill(&server);
	program_wait(&run);
	if (!shown)
		print_error("no window '%s': %s\n", title, run.err);
	assert_true(shown);
	assert_error_lines(1);
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

/* A demo that somebody would have closed has nobody left to close it. */
static void test_demo_without_end(void **state)
{
	(void)state;
	run_until_the_server_dies(DEMO, "Stilb: "); /* the title after the first frame */
	assert_said(run.err, "the display has gone after ");
	assert_said(run.err, "; ending, since nobody could close the window");
	assert_int_equal(run.code, 1);
	assert_demo_wrote_all();
	assert_true(stat_int("frames") > 0);
}

static void test_demo_goes_on_to_its_last_frame(void **state)
{
	(void)state;
	run_until_the_server_dies(DEMO "--frames 300", "Stilb: ");
	assert_said(run.err, "; running on headless");
	assert_int_equal(run.code, 0);
	assert_demo_wrote_all();
	assert_int_equal(stat_int("frames"), 300);
}

#define RENDER "render cornell --size 200x200 --spp 24 --workers 1 --seed 3 "

static void test_render_finishes_its_picture(void **state)
{
	(void)state;
	stilb_image before, after;
	run_until_the_server_dies(RENDER "--preview -o a.exr --stats s.json", "Stilb: cornell");
	assert_said(run.err, "has gone"); /* says the window, or the driver, whoever notices it first */
	assert_said(run.err, "without a preview");
	assert_int_equal(run.code, 0);
	read_stats("s.json");
	assert_string_equal(stat_text("end", '"'), "samples");
	stilb_good(RENDER "-o b.exr");
	assert_int_equal(stilb_image_load("a.exr", &after), STILB_OK);
	assert_int_equal(stilb_image_load("b.exr", &before), STILB_OK);
	assert_memory_equal(after.pixels, before.pixels, stilb_image_size(&before));
	stilb_image_finish(&after);
	stilb_image_finish(&before);
}

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup_teardown(test_demo_without_end, folder_fresh, server_end),
		cmocka_unit_test_setup_teardown(test_demo_goes_on_to_its_last_frame, folder_fresh, server_end),
		cmocka_unit_test_setup_teardown(test_render_finishes_its_picture, folder_fresh, server_end),
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
