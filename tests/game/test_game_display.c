/* The X server dies under stilb demo and stilb render --preview: they go on without it, and write what was asked for. */
#include "image/image.h"
#include "support/stilb_program.h"
#include "support/x11_server.h"

static x11_server server;

/* Starts a run on a server of its own, and kills the server when a window of this title can be seen. */
static void start_until_the_server_dies(const char *line, const char *title)
{
	char display[64];
	assert_true(x11_server_start(&server));
	snprintf(display, sizeof display, "DISPLAY=%s", server.name);
	const char *const environment[] = {display, "WAYLAND_DISPLAY", NULL};
	stilb_start(environment, -1, line);
	const bool shown = x11_server_shows(&server, title);
	x11_server_kill(&server);
	if (!shown)
		kill(run.pid, SIGKILL);
	assert_true(shown);
}

/* Once it has said that the display is gone, and has worked for a while since. */
static void interrupt_after_the_loss(void)
{
	struct stat said = {0};
	for (int i = 0; i < 3000 && said.st_size == 0; i++, usleep(10000))
		assert_int_equal(fstat(fileno(run.files[1]), &said), 0);
	const bool working = said.st_size > 0 && catches_interrupts(run.pid);
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

/* A demo that somebody would have closed has nobody left to close it. */
static void test_demo_without_end(void **state)
{
	(void)state;
	start_until_the_server_dies(DEMO, "Stilb: "); /* the title after the first frame */
	program_wait(&run);
	assert_error_lines(1);
	assert_said(run.err, "the display has gone after ");
	assert_said(run.err, "; ending, since nobody could close the window");
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

static void test_render_goes_on(void **state)
{
	(void)state;
	start_until_the_server_dies(
		"render cornell --size 100x100 --spp 65536 --workers 1 --preview -o a.png --stats s.json", "Stilb: cornell");
	interrupt_after_the_loss();
	assert_said(run.err,
	            "without a preview"); /* why is said by the window or by the driver, whoever notices it first */
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
