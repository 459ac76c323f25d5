/* stilb view on a virtual display: the next file, a file that changes on disk and goes, and files that are dropped. */
#include "image/image.h"
#include "support/stilb_program.h"
#include "support/x11_server.h"

#include <X11/Xatom.h>
#include <X11/keysym.h>
#include <sys/resource.h>

static x11_server server;
static Display *display;
static Window window;

#define SQUARE "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nf 1 2 3\n"

static void write_text(const char *name, const char *text)
{
	FILE *file = fopen(name, "w");
	assert_non_null(file);
	fputs(text, file);
	fclose(file);
}

/* Waits until the run's stdout (0) or stderr (1) has this text. */
static bool await_in(int stream, const char *text)
{
	static char all[65536];
	for (int i = 0; i < 3000; i++, usleep(10000)) {
		ssize_t size = pread(fileno(run.files[stream]), all, sizeof all - 1, 0);
		all[size > 0 ? size : 0] = '\0';
		if (strstr(all, text))
			return true;
	}
	return false;
}

static bool await_said(const char *text)
{
	return await_in(1, text);
}

static bool await_told(const char *text)
{
	return await_in(0, text);
}

/* Sends the window a press and a release of the left button at a point of the picture. */
static void click(int x, int y)
{
	XButtonEvent button = {.type = ButtonPress,
	                       .display = display,
	                       .window = window,
	                       .root = DefaultRootWindow(display),
	                       .time = CurrentTime,
	                       .x = x,
	                       .y = y,
	                       .button = Button1,
	                       .same_screen = True};
	XWarpPointer(display, None, window, 0, 0, 0, 0, x, y);
	XSync(display, False);
	XSendEvent(display, window, True, ButtonPressMask, (XEvent *)&button);
	button.type = ButtonRelease;
	XSendEvent(display, window, True, ButtonReleaseMask, (XEvent *)&button);
	XSync(display, False);
}

/* ---- dropping, as the freedesktop.org protocol XDND has it ------------------------------------------------------- */

static void drop_tell(const char *kind, Window from, long a, long b, long c, long d)
{
	XEvent event = {0};
	event.xclient.type = ClientMessage;
	event.xclient.window = window;
	event.xclient.message_type = XInternAtom(display, kind, False);
	event.xclient.format = 32;
	const long values[5] = {(long)from, a, b, c, d};
	memcpy(event.xclient.data.l, values, sizeof values);
	XSendEvent(display, window, False, NoEventMask, &event);
	XFlush(display);
}

/* Hands the file's URI to who asks for the selection. */
static void drop_answer(const XSelectionRequestEvent *asked, const char *uri)
{
	XChangeProperty(display, asked->requestor, asked->property, asked->target, 8, PropModeReplace,
	                (const unsigned char *)uri, (int)strlen(uri));
	XEvent event = {0};
	event.xselection.type = SelectionNotify;
	event.xselection.requestor = asked->requestor;
	event.xselection.selection = asked->selection;
	event.xselection.target = asked->target;
	event.xselection.property = asked->property;
	event.xselection.time = asked->time;
	XSendEvent(display, asked->requestor, False, NoEventMask, &event);
	XFlush(display);
}

/* Drops the file of this name onto the window. False: nobody asked for it. */
static bool drop(const char *name)
{
	char path[PATH_MAX], uri[PATH_MAX + 16];
	assert_non_null(realpath(name, path));
	snprintf(uri, sizeof uri, "file://%s\r\n", path);
	Window from = XCreateSimpleWindow(display, DefaultRootWindow(display), 0, 0, 1, 1, 0, 0, 0);
	Atom selection = XInternAtom(display, "XdndSelection", False), list = XInternAtom(display, "text/uri-list", False);
	XSetSelectionOwner(display, selection, from, CurrentTime);
	drop_tell("XdndEnter", from, 5L << 24, (long)list, 0, 0);
	drop_tell("XdndPosition", from, 0, 10L << 16 | 10, CurrentTime,
	          (long)XInternAtom(display, "XdndActionCopy", False));
	drop_tell("XdndDrop", from, 0, CurrentTime, 0, 0);
	for (int i = 0; i < 3000; i++, usleep(10000))
		while (XPending(display) > 0) {
			XEvent event;
			XNextEvent(display, &event);
			if (event.type == SelectionRequest) {
				drop_answer(&event.xselectionrequest, uri);
				return true;
			}
		}
	return false;
}

/* Saves pictures until one says that it was made under this environment. False: thirty said something else. */
static bool await_environment(const char *text)
{
	for (int i = 1; i <= 30; i++, usleep(100000)) {
		char name[32] = "stilb-view.png", told[64];
		if (i > 1)
			snprintf(name, sizeof name, "stilb-view-%d.png", i);
		snprintf(told, sizeof told, "picture: %s", name);
		x11_server_type(display, window, XK_F12);
		assert_true(await_told(told));
		if (says_in_png(name, "stilb:environment", text))
			return true;
	}
	return false;
}

/* ---- the run ----------------------------------------------------------------------------------------------------- */

/* Kills the run if the test has failed. */
static int run_end(void **state)
{
	(void)state;
	if (run.pid > 0 && waitpid(run.pid, NULL, WNOHANG) == 0) {
		kill(run.pid, SIGKILL);
		waitpid(run.pid, NULL, 0);
	}
	x11_server_kill(&server);
	return 0;
}

static rlim_t file_limit = RLIM_INFINITY; /* bytes of a file that the run may write */

static void open_window(const char *line, const char *title)
{
	char name[64];
	assert_true(x11_server_start(&server));
	snprintf(name, sizeof name, "DISPLAY=%s", server.name);
	const char *const environment[] = {name, "WAYLAND_DISPLAY", NULL};
	struct rlimit before, limit = {file_limit, RLIM_INFINITY};
	assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
	assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
	stilb_start(environment, -1, line);
	assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
	display = XOpenDisplay(server.name);
	assert_non_null(display);
	window = x11_server_await(display, title);
	assert_true(window);
}

static void files_come_and_go(void **state)
{
	(void)state;
	write_text("a.obj", SQUARE);
	write_text("b.obj", SQUARE);
	write_text("words.txt", "no scene");
	write_text("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\nl 2 3\nl 3 1\n");
	write_text("sky.hdr", "no picture");
	stilb_image sky;
	assert_int_equal(stilb_image_create(&sky, 4, 2, 3, STILB_IMAGE_F32_LINEAR), STILB_OK);
	assert_int_equal(stilb_image_save(&sky, "black.hdr"), STILB_OK);
	stilb_image_finish(&sky);
	open_window("view a.obj --size 160x120 --workers 1 --gamepad off --stats s.json --present mailbox", "Stilb: a.obj");
	x11_server_type(display, window, XK_Next);
	assert_true(x11_server_await(display, "Stilb: b.obj") == window);
	x11_server_type(display, window, XK_Prior); /* words.txt is not a neighbour */
	assert_true(x11_server_await(display, "Stilb: a.obj") == window);
	write_text("a.obj.lights.json", "{"); /* which was not there when a.obj was read */
	assert_true(await_said("a.obj.lights.json'"));
	assert_int_equal(unlink("a.obj.lights.json"), 0);
	assert_true(drop("words.txt"));
	assert_true(await_said("'a.obj' stays as it was"));
	assert_int_equal(mkdir("folder", 0777), 0);
	assert_true(drop("folder"));
	assert_true(await_said("folder': it is a folder, not a file; 'a.obj' stays"));
	assert_true(drop("points.obj"));
	assert_true(await_said("points.obj': it has no triangles, and nothing else is shown; 'a.obj' stays"));
	assert_true(drop("sky.hdr"));
	assert_true(await_said("sky.hdr'"));
	assert_true(drop("black.hdr"));
	assert_true(await_environment("black.hdr"));
	assert_true(drop("b.obj"));
	assert_true(x11_server_await(display, "Stilb: b.obj") == window);
	write_text("b.obj", "v -1 -1 0\nf 1 2"); /* as if its writer was not done */
	assert_true(await_said("b.obj' stays as it was"));
	write_text("b.obj", "o one\n" SQUARE "o two\nv 2 2 2\nv 3 2 2\nv 3 3 2\nf 4 5 6\n");
	sleep(1); /* a change is read 0.3 s after it */
	assert_int_equal(unlink("b.obj"), 0);
	assert_true(await_said("b.obj' has gone"));
	XCloseDisplay(display);
	kill(run.pid, SIGINT);
	program_wait(&run);
	assert_int_equal(run.code, 0);
	assert_null(strstr(run.err, "black.hdr"));
	read_stats("s.json");
	assert_int_equal(stat_int("models"), 2);
}

/* Files are limited to a kilobyte, as if the disk was full: a picture that cannot be written is told, the run goes on,
 * and nothing is left of it. */
static void a_full_disk_is_told(void **state)
{
	(void)state;
	write_text("a.obj", SQUARE);
	signal(SIGXFSZ, SIG_IGN);
	file_limit = 1024;
	open_window("view a.obj --size 320x240 --workers 1 --gamepad off --quiet", "Stilb: a.obj");
	file_limit = RLIM_INFINITY;
	x11_server_type(display, window, XK_F12);
	assert_true(await_said("cannot write 'stilb-view.png'"));
	assert_int_equal(access("stilb-view.png", F_OK), -1);
	XCloseDisplay(display);
	kill(run.pid, SIGINT);
	program_wait(&run);
	assert_int_equal(run.code, 0);
}

/* A black triangle of side 2 across Z, as glTF, with the variants red and green. */
#define VARIED                                                                                                         \
	"{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],"              \
	"\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":0,\"extensions\":{"                    \
	"\"KHR_materials_variants\":{\"mappings\":[{\"material\":1,\"variants\":[0]},{\"material\":2,\"variants\":[1]}]}"  \
	"}}]}],\"materials\":[" PAINT("0,0,0") "," PAINT("1,0,0") "," PAINT(                                               \
		"0,1,0") "],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\","            \
				 "\"min\":[-1,-1,0],\"max\":[1,1,0]}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"buffers\":" \
				 "[{"                                                                                                  \
				 "\"byteLength\":36,\"uri\":\"data:application/octet-stream;base64,"                                   \
				 "AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8AAAAA\"}],\"extensionsUsed\":[\"KHR_materials_"           \
				 "variants\"],"                                                                                        \
				 "\"extensions\":{\"KHR_materials_variants\":{\"variants\":[{\"name\":\"red\"},{\"name\":\"green\"}]}" \
				 "}}"
#define PAINT(color) "{\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"baseColorFactor\":[" color ",1]}}"

/* The middle of the picture is green. */
static void assert_green(const char *path)
{
	stilb_image image;
	assert_int_equal(stilb_image_load(path, &image), STILB_OK);
	const uint8_t *middle =
		(const uint8_t *)image.pixels + image.channels * (image.height / 2 * image.width + image.width / 2);
	assert_true(middle[1] > middle[0] + 60 && middle[1] > middle[2] + 60);
	stilb_image_finish(&image);
}

/* The path tracer takes over, follows an edit (another variant of the materials), goes on with other workers and with
 * another file, gives the window back, and ends with a signal while it traces. */
static void rays_take_over(void **state)
{
	(void)state;
	write_text("a.gltf", VARIED);
	write_text("b.obj", SQUARE);
	open_window("view a.gltf --size 160x120 --workers 1 --gamepad off", "Stilb: a.gltf");
	x11_server_type(display, window, XK_t);
	x11_server_type(display, window, XK_v); /* perhaps while the tree is built */
	assert_true(await_in(0, "variant 1 of 2: red"));
	assert_true(x11_server_await(display, "Stilb: a.gltf, path traced") == window);
	x11_server_type(display, window, XK_v);
	assert_true(await_in(0, "variant 2 of 2: green"));
	x11_server_type(display, window, XK_minus); /* no workers: a thread of its own traces */
	assert_true(await_in(0, "workers: 0"));
	assert_true(x11_server_await(display, "Stilb: a.gltf, path traced") == window);
	x11_server_type(display, window, XK_F12);
	assert_true(await_in(0, "picture: "));
	assert_green("stilb-view.png");
	x11_server_type(display, window, XK_Next);
	assert_true(x11_server_await(display, "Stilb: b.obj, path traced") == window);
	x11_server_type(display, window, XK_t);
	assert_true(x11_server_await(display, "Stilb: b.obj, frame") == window);
	x11_server_type(display, window, XK_t);
	assert_true(x11_server_await(display, "Stilb: b.obj, path traced") == window);
	XCloseDisplay(display);
	kill(run.pid, SIGINT);
	program_wait(&run);
	assert_int_equal(run.code, 0);
}

/* A triangle that a clip moves to the right in a second, again and again. */
#define SLIDING                                                                                                        \
	"{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],\"scene\":0,\"nodes\":[{\"mesh\":0}],"              \
	"\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\"animations\":[{\"name\":\"slide\","           \
	"\"samplers\":["                                                                                                   \
	"{\"input\":1,\"output\":2}],\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"translation\"}}]}],"   \
	"\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"min\":[-1,-1,0],"         \
	"\"max\":[1,1,0]},{\"bufferView\":1,\"componentType\":5126,\"count\":2,\"type\":\"SCALAR\",\"min\":[0],"           \
	"\"max\":[1]},{\"bufferView\":2,\"componentType\":5126,\"count\":2,\"type\":\"VEC3\"}],\"bufferViews\":["          \
	"{\"buffer\":0,\"byteLength\":36},{\"buffer\":0,\"byteOffset\":36,\"byteLength\":8},"                              \
	"{\"buffer\":0,\"byteOffset\":44,\"byteLength\":24}],\"buffers\":[{\"byteLength\":68,\"uri\":"                     \
	"\"data:application/octet-stream;base64,AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8A"                              \
	"AAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAA=\"}]}"

/* Rays wait while a clip plays, say so, and come when it is paused; it plays on, and they wait again. */
static void rays_wait_for_clips(void **state)
{
	(void)state;
	write_text("a.gltf", SLIDING);
	open_window("view a.gltf --size 160x120 --workers 1 --gamepad off", "Stilb: a.gltf");
	x11_server_type(display, window, XK_t);
	for (int i = 0; i < 2; i++) {
		assert_true(x11_server_await(display, "Stilb: a.gltf, playing; path traced when paused") == window);
		x11_server_type(display, window, XK_space);
		assert_true(x11_server_await(display, "Stilb: a.gltf, path traced") == window);
		x11_server_type(display, window, XK_space);
	}
	XCloseDisplay(display);
	kill(run.pid, SIGINT);
	program_wait(&run);
	assert_int_equal(run.code, 0);
}

/* Keys, a click, and a file that the scene names: its number of triangles grows. */
static void keys_clicks_and_materials(void **state)
{
	(void)state;
	write_text("a.mtl", "newmtl grey\nKd .5 .5 .5\n");
	write_text("a.obj", "mtllib a.mtl\nusemtl grey\n" SQUARE);
	open_window("view a.obj --size 160x120 --workers 1 --gamepad off", "Stilb: a.obj");
	assert_true(x11_server_shows(&server, "Stilb: a.obj, frame"));
	x11_server_type(display, window, XK_2);
	assert_true(await_told("the file has no cameras"));
	click(90, 70);
	assert_true(await_told("material grey: colour 0.50 0.50 0.50, roughness"));
	write_text("a.mtl", "newmtl grey\nKd .5 .5 .5\nmap_Kd none.png\n");
	assert_true(await_said("none.png"));
	XCloseDisplay(display);
	kill(run.pid, SIGINT);
	program_wait(&run);
	assert_int_equal(run.code, 0);
}

/* The first scene must open: the run ends as one that was refused. */
static void the_first_must_open(void **state)
{
	(void)state;
	char name[64];
	assert_true(x11_server_start(&server));
	snprintf(name, sizeof name, "DISPLAY=%s", server.name);
	const char *const environment[] = {name, "WAYLAND_DISPLAY", NULL};
	write_text("words.txt", "no scene");
	assert_int_equal(stilb_code(environment, "view words.txt --size 160x120 --gamepad off"), 2);
	assert_said(run.err, "cannot read 'words.txt'");
}

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup_teardown(files_come_and_go, folder_fresh, run_end),
		cmocka_unit_test_setup_teardown(a_full_disk_is_told, folder_fresh, run_end),
		cmocka_unit_test_setup_teardown(rays_take_over, folder_fresh, run_end),
		cmocka_unit_test_setup_teardown(rays_wait_for_clips, folder_fresh, run_end),
		cmocka_unit_test_setup_teardown(keys_clicks_and_materials, folder_fresh, run_end),
		cmocka_unit_test_setup_teardown(the_first_must_open, folder_fresh, run_end),
	};
	if (!x11_server_start(&server)) {
		printf("no Xvfb: install xvfb\n");
		return 77;
	}
	x11_server_kill(&server);
	if (!folder_enter(argc > 1 ? argv[1] : NULL, "game_view_window")) {
		fprintf(stderr, "usage: %s PATH-OF-STILB\n", argv[0]);
		return 2;
	}
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}
