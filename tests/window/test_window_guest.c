/* Engines with windows side by side, and an engine in a window of the program's own. All under Vulkan validation. */
#include "engine.h"
#include "engine_faults.h"
#include "engine_internal.h"
#include "image/image.h"
#include "shading/shade_brdf.h"
#include "support/test.h"
#include "support/x11_server.h"
#include "support/x11_window.h"
#include "tests/engine/stress_engine.h"

#define VK_USE_PLATFORM_XLIB_KHR
#include "tests/engine/pipeline_count.h"

#include <locale.h>
#include <vulkan/vulkan.h>

static const stress_engine stress = {.models = 25, .seed = 1};

static stilb_engine_desc window_desc(void)
{
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.workers = 1;
	desc.width = 160;
	desc.height = 100;
	desc.validate = true;
	return desc;
}

static stilb_engine *make_engine(const stilb_engine_desc *desc)
{
	stilb_engine *engine;
	if (stress_engine_create(desc, &stress, &engine) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return engine;
}

static void run_frames(stilb_engine *engine, int count)
{
	stilb_engine_report report;
	for (int i = 0; i < count; i++) {
		if (stilb_engine_frame(engine, &report) != STILB_OK)
			fail_msg("%s", stilb_error_message());
		assert_true(report.drawn && !report.lost && !report.close);
	}
	assert_int_equal(stilb_engine_validation_messages(engine), 0);
}

/* In place of the loader's function (--wrap): with fifo_only a window that offers nothing else. */
static bool fifo_only;

VKAPI_ATTR VkResult VKAPI_CALL __real_vkGetPhysicalDeviceSurfacePresentModesKHR(VkPhysicalDevice gpu,
                                                                                VkSurfaceKHR surface, uint32_t *count,
                                                                                VkPresentModeKHR *modes);
VKAPI_ATTR VkResult VKAPI_CALL __wrap_vkGetPhysicalDeviceSurfacePresentModesKHR(VkPhysicalDevice gpu,
                                                                                VkSurfaceKHR surface, uint32_t *count,
                                                                                VkPresentModeKHR *modes);

VKAPI_ATTR VkResult VKAPI_CALL __wrap_vkGetPhysicalDeviceSurfacePresentModesKHR(VkPhysicalDevice gpu,
                                                                                VkSurfaceKHR surface, uint32_t *count,
                                                                                VkPresentModeKHR *modes)
{
	if (!fifo_only)
		return __real_vkGetPhysicalDeviceSurfacePresentModesKHR(gpu, surface, count, modes);
	*count = 1;
	modes[0] = VK_PRESENT_MODE_FIFO_KHR;
	return VK_SUCCESS;
}

/* Likewise, to count the surfaces that exist. */
static int surfaces;

VKAPI_ATTR void VKAPI_CALL __real_vkDestroySurfaceKHR(VkInstance instance, VkSurfaceKHR surface,
                                                      const VkAllocationCallbacks *allocator);
VKAPI_ATTR void VKAPI_CALL __wrap_vkDestroySurfaceKHR(VkInstance instance, VkSurfaceKHR surface,
                                                      const VkAllocationCallbacks *allocator);

VKAPI_ATTR void VKAPI_CALL __wrap_vkDestroySurfaceKHR(VkInstance instance, VkSurfaceKHR surface,
                                                      const VkAllocationCallbacks *allocator)
{
	surfaces--;
	__real_vkDestroySurfaceKHR(instance, surface, allocator);
}

/* Of the log: a presentation that the window does not offer; a surface that was made anew. */
static uint32_t presentation_lines, surface_lines;

static void on_line(void *user, const char *line)
{
	(void)user;
	presentation_lines += strstr(line, "presentation") ? 1 : 0;
	surface_lines += strstr(line, "surface was lost") ? 1 : 0;
}

/* Three windows, each with a way of presentation; they end in the order in which they began. */
static void test_engines_with_windows(void **state)
{
	(void)state;
	stilb_engine *engines[3];
	uint32_t replaced = 0;
	stilb_log_set(on_line, NULL);
	for (int i = 0; i < 3; i++) {
		stilb_engine_desc desc = window_desc();
		desc.window = true;
		desc.presentation = (stilb_gpu_presentation)i;
		engines[i] = make_engine(&desc);
		replaced += stilb_engine_presentation(engines[i]) != desc.presentation;
	}
	assert_int_equal(presentation_lines, replaced); /* nothing is replaced in silence */
	assert_string_equal(setlocale(LC_ALL, NULL), "C");
	for (int i = 0; i < 3; i++)
		for (int frame = 0; frame < 2; frame++)
			run_frames(engines[(i + frame) % 3], 2);
	for (int i = 0; i < 3; i++) {
		stress_engine_destroy(engines[i]);
		for (int other = i + 1; other < 3; other++)
			run_frames(engines[other], 2);
	}
	stilb_log_set(NULL, NULL);
}

/* In a window, formulas that are new are compiled beside the frames, which show those before. */
static void test_other_formulas_stop_no_frame(void **state)
{
	(void)state;
	stilb_engine_desc desc = window_desc();
	desc.window = true;
	stilb_engine *engine = make_engine(&desc);
	run_frames(engine, 3);
	stilb_render_shading shading = stilb_engine_shading(engine);
	int before = pipeline_count;
	for (uint32_t step = 0; step < 2; step++) {
		uint64_t hash = stilb_engine_stream_hash(engine);
		shading.brdf = (shading.brdf + 1) % SHADE_BRDF_COUNT;
		stilb_engine_set_shading(engine, &shading);
		assert_int_equal(stilb_engine_shading(engine).brdf, shading.brdf);
		for (int i = 0; i < 10000 && stilb_engine_stream_hash(engine) == hash; i++)
			run_frames(engine, 1);
		assert_true(stilb_engine_stream_hash(engine) != hash);
	}
	assert_int_equal(pipeline_count, before);
	stress_engine_destroy(engine);
}

/* Likewise ways of lighting; several kinds of programs go with each. */
static void test_other_ways_of_lighting_stop_no_frame(void **state)
{
	(void)state;
	stilb_engine_desc desc = window_desc();
	desc.window = true;
	desc.samples = 1;
	desc.deferred.coverage = STILB_RENDER_COVERAGE_VOLUMES;
	stilb_engine *engine = make_engine(&desc);
	assert_int_equal(stilb_scene_stress_add_lamps(stilb_engine_scene(engine), 12), STILB_OK);
	run_frames(engine, 3);
	int before = pipeline_count;
	for (int way = STILB_RENDER_LIGHTING_WAYS - 1; way >= 0; way--) {
		stilb_engine_set_lighting(engine, (stilb_render_lighting)way);
		run_frames(engine, 1);
		if (way == STILB_RENDER_LIGHTING_WAYS - 1)
			assert_int_equal(engine->views[0].lighting, STILB_RENDER_LIGHTING_AUTO);
		for (int i = 0; i < 10000 && engine->views[0].lighting != (stilb_render_lighting)way; i++)
			run_frames(engine, 1);
		assert_int_equal(engine->views[0].lighting, way);
	}
	assert_int_equal(pipeline_count, before);
	stress_engine_destroy(engine);
}

/* A presentation that the window does not offer is replaced, and that is said once, however often the size changes. */
static void test_a_presentation_is_replaced(void **state)
{
	(void)state;
	stilb_engine_desc desc = window_desc();
	desc.window = true;
	desc.presentation = STILB_GPU_PRESENT_MAILBOX;
	fifo_only = true;
	presentation_lines = 0;
	stilb_log_set(on_line, NULL);
	stilb_engine *engine = make_engine(&desc);
	assert_int_equal(stilb_engine_presentation(engine), STILB_GPU_PRESENT_FIFO);
	run_frames(engine, 3);
	assert_int_equal(presentation_lines, 1);
	stress_engine_destroy(engine);
	stilb_log_set(NULL, NULL);
	fifo_only = false;
}

/* ---- a window of the program's own ------------------------------------------------------------------------------- */

typedef struct own {
	Display *display;
	Window window;
} own;

static const char *const *own_extensions(void *user, uint32_t *count)
{
	static const char *const names[] = {VK_KHR_SURFACE_EXTENSION_NAME, VK_KHR_XLIB_SURFACE_EXTENSION_NAME};
	(void)user;
	*count = 2;
	return names;
}

static int32_t own_create(void *user, void *instance, uint64_t *surface)
{
	own *o = user;
	VkXlibSurfaceCreateInfoKHR info = {
		.sType = VK_STRUCTURE_TYPE_XLIB_SURFACE_CREATE_INFO_KHR, .dpy = o->display, .window = o->window};
	VkSurfaceKHR made = VK_NULL_HANDLE;
	VkResult result = vkCreateXlibSurfaceKHR(instance, &info, NULL, &made);
	memcpy(surface, &made, sizeof *surface);
	surfaces += result == VK_SUCCESS;
	return result;
}

/* A window of which the system cannot make a surface. */
static int32_t own_create_in_vain(void *user, void *instance, uint64_t *surface)
{
	(void)user, (void)instance, (void)surface;
	return VK_ERROR_OUT_OF_HOST_MEMORY;
}

static void own_open(own *o)
{
	o->window =
		XCreateSimpleWindow(o->display, RootWindow(o->display, DefaultScreen(o->display)), 0, 0, 160, 100, 0, 0, 0);
	XMapWindow(o->display, o->window);
	XSync(o->display, False);
}

static void run_until_shown(stilb_engine *engine, const own *o)
{
	run_frames(engine, 5);
	for (int i = 0; i < 1000 && !x11_server_has_picture(o->display, o->window); i++)
		run_frames(engine, 1); /* the X server shows a picture a little later */
	assert_true(x11_server_has_picture(o->display, o->window));
}

/* The window goes while the engine draws: it says so from then on and draws to memory. */
static void lose_the_window(stilb_engine *engine, own *o)
{
	stilb_engine_report report;
	XDestroyWindow(o->display, o->window);
	XSync(o->display, False);
	for (int i = 0; i < 4; i++) {
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
		assert_true(report.lost && report.drawn);
	}
	assert_int_equal(stilb_engine_resize(engine, 90, 50), STILB_OK); /* memory has no size of its own */
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	assert_int_equal(stilb_engine_screenshot(engine, "test_window_guest.png"), STILB_OK);
	stilb_image image;
	assert_int_equal(stilb_image_load("test_window_guest.png", &image), STILB_OK);
	assert_true(image.width == 90 && image.height == 50);
	stilb_image_finish(&image);
	remove("test_window_guest.png");
}

/* A picture of what the engine draws, as bytes; to be freed. */
static uint8_t *take_picture(stilb_engine *engine)
{
	stilb_image image;
	assert_int_equal(stilb_engine_screenshot(engine, "test_window_guest.png"), STILB_OK);
	assert_int_equal(stilb_image_load("test_window_guest.png", &image), STILB_OK);
	assert_int_equal(stilb_image_size(&image), 160 * 100 * 3);
	uint8_t *bytes = image.pixels;
	image.pixels = NULL;
	stilb_image_finish(&image);
	remove("test_window_guest.png");
	return bytes;
}

/* The window goes, by itself or closed by the program in order, and another one comes: the engine goes on there with
 * the same scene. As often as one likes, with one surface at a time. */
static void test_another_window_for_the_same_engine(void **state)
{
	(void)state;
	own o = {.display = XOpenDisplay(NULL)};
	assert_non_null(o.display);
	own_open(&o);
	stilb_engine_desc desc = window_desc();
	stilb_gpu_surface surface = {&o, own_extensions, own_create};
	desc.surface = &surface;
	surfaces = 0;
	stilb_engine *engine = make_engine(&desc);
	run_until_shown(engine, &o);
	uint8_t *before = take_picture(engine);
	for (int round = 0; round < 6; round++) {
		stilb_engine_report report;
		bool in_order = round % 2;
		if (in_order)
			assert_int_equal(stilb_engine_set_surface(engine, NULL), STILB_OK);
		XDestroyWindow(o.display, o.window);
		XSync(o.display, False);
		for (int i = 0; i < 3; i++) {
			assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
			assert_true(report.drawn && report.lost == !in_order);
		}
		own_open(&o);
		assert_int_equal(stilb_engine_set_surface(engine, &surface), STILB_OK);
		run_until_shown(engine, &o);
		assert_int_equal(surfaces, 1);
	}
	uint8_t *after = take_picture(engine);
	assert_memory_equal(before, after, 160 * 100 * 3);
	free(before);
	free(after);
	stress_engine_destroy(engine);
	assert_int_equal(surfaces, 0);
	XDestroyWindow(o.display, o.window);
	XCloseDisplay(o.display);
}

/* A window that cannot be had is an error after which frames go on, and the next window is taken. */
static void test_a_window_that_cannot_be_had(void **state)
{
	(void)state;
	own o = {.display = XOpenDisplay(NULL)};
	assert_non_null(o.display);
	own_open(&o);
	stilb_engine_desc desc = window_desc();
	stilb_gpu_surface surface = {&o, own_extensions, own_create}, vain = {&o, own_extensions, own_create_in_vain};
	stilb_engine_report report;
	desc.surface = &surface;
	stilb_engine *engine = make_engine(&desc);
	assert_int_equal(stilb_engine_set_surface(engine, &vain), STILB_ERROR_WINDOW);
	for (int i = 0; i < 3; i++) {
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
		assert_true(report.lost && report.drawn);
	}
	assert_int_equal(stilb_engine_set_surface(engine, &surface), STILB_OK);
	run_until_shown(engine, &o);
	stress_engine_destroy(engine);

	desc.surface = NULL;
	engine = make_engine(&desc);
	assert_int_equal(stilb_engine_set_surface(engine, &surface), STILB_ERROR_WINDOW);
	assert_non_null(strstr(stilb_error_message(), "created without a window"));
	assert_int_equal(stilb_engine_set_surface(engine, NULL), STILB_OK);
	run_frames(engine, 2);
	stress_engine_destroy(engine);
	XDestroyWindow(o.display, o.window);
	XCloseDisplay(o.display);
}

/* The driver loses the surface of the engine's own window, which lives: the engine makes another one and shows its
 * pictures there, and the program hears of it in the log alone. */
static void test_the_engines_window_goes_on(void **state)
{
	(void)state;
	Display *display = XOpenDisplay(NULL);
	assert_non_null(display);
	stilb_engine_desc desc = window_desc();
	desc.window = true;
	stilb_engine_set_faults(&(stilb_render_faults){.surface_lost = 2});
	surface_lines = 0;
	stilb_log_set(on_line, NULL);
	stilb_engine *engine = make_engine(&desc);
	stilb_engine_set_faults(NULL);
	Window window = x11_window_find(display, "Stilb");
	run_frames(engine, 2);
	assert_int_equal(surface_lines, 1);
	XClearWindow(display, window); /* what the lost surface has shown */
	XSync(display, False);
	run_until_shown(engine, &(own){display, window});
	assert_int_equal(surface_lines, 1);
	stress_engine_destroy(engine);
	stilb_log_set(NULL, NULL);
	XCloseDisplay(display);
}

static void test_a_window_of_the_programs_own(void **state)
{
	(void)state;
	own o = {.display = XOpenDisplay(NULL)};
	assert_non_null(o.display);
	own_open(&o);
	stilb_engine_desc desc = window_desc();
	stilb_gpu_surface surface = {&o, own_extensions, own_create};
	uint32_t width, height;
	desc.surface = &surface;
	stilb_engine *engine = make_engine(&desc);
	run_until_shown(engine, &o);
	XResizeWindow(o.display, o.window, 200, 120);
	XSync(o.display, False);
	assert_int_equal(stilb_engine_resize(engine, 200, 120), STILB_OK);
	run_frames(engine, 5);
	stilb_engine_size(engine, &width, &height);
	assert_true(width == 200 && height == 120);
	lose_the_window(engine, &o);
	stress_engine_destroy(engine);
	own_open(&o);
	engine = make_engine(&desc);
	run_until_shown(engine, &o);
	stress_engine_destroy(engine);
	XDestroyWindow(o.display, o.window);
	XCloseDisplay(o.display);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_engines_with_windows),
		cmocka_unit_test(test_other_formulas_stop_no_frame),
		cmocka_unit_test(test_other_ways_of_lighting_stop_no_frame),
		cmocka_unit_test(test_a_presentation_is_replaced),
		cmocka_unit_test(test_a_window_of_the_programs_own),
		cmocka_unit_test(test_another_window_for_the_same_engine),
		cmocka_unit_test(test_a_window_that_cannot_be_had),
		cmocka_unit_test(test_the_engines_window_goes_on),
	};
	Display *held = XOpenDisplay(NULL); /* a display server without clients may start anew and refuse for a moment */
	if (!held) {
		printf("no X display: set DISPLAY, or install xvfb and use ./dev test\n");
		return 77;
	}
	setenv("LC_ALL", "C.UTF-8", 1); /* not the program's locale until it asks for it, which nobody here does */
	int failed = cmocka_run_group_tests(tests, NULL, NULL);
	XCloseDisplay(held);
	return failed;
}
