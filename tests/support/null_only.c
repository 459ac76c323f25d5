/*
 * Stands in for everything that would load Vulkan, GLFW, libpng, OpenEXR or hidapi: linked into the tests of the null
 * device, so that no third-party library is there and the thread sanitizer sees all that runs. Each call fails as on a
 * bare machine.
 */
#include "gpu/gpu_internal.h"
#include "image/image_internal.h"
#include "input/device/input_device_internal.h"
#include "window/window.h"

#include <string.h>

stilb_result gpu_vulkan_open(const stilb_gpu_desc *desc, stilb_gpu **gpu)
{
	(void)desc, (void)gpu;
	return stilb_fail(STILB_ERROR_DEVICE, "no Vulkan in this test");
}

const char *stilb_gpu_vulkan_version(void)
{
	return "none";
}

stilb_result stilb_window_create(const char *title, uint32_t width, uint32_t height, stilb_window **window)
{
	(void)title, (void)width, (void)height;
	*window = NULL;
	return stilb_fail(STILB_ERROR_WINDOW, "no windows in this test");
}

void stilb_window_destroy(stilb_window *window)
{
	STILB_ASSERT(!window);
}

void stilb_window_title(stilb_window *window, const char *title)
{
	(void)window, (void)title;
}

void stilb_window_poll(stilb_window *window, stilb_window_state *state)
{
	(void)window;
	memset(state, 0, sizeof *state);
}

void stilb_window_wait(stilb_window *window, double seconds, stilb_window_state *state)
{
	(void)seconds;
	stilb_window_poll(window, state);
}

void stilb_window_set_capturing(stilb_window *window, bool capturing)
{
	(void)window, (void)capturing;
}

void stilb_window_gamepads(stilb_window *window, stilb_window_gamepad gamepads[STILB_WINDOW_GAMEPADS])
{
	(void)window;
	memset(gamepads, 0, STILB_WINDOW_GAMEPADS * sizeof *gamepads);
}

const char *const *stilb_window_surface_extensions(void *user, uint32_t *count)
{
	(void)user;
	*count = 0;
	return NULL;
}

int32_t stilb_window_surface_create(void *user, void *instance, uint64_t *surface)
{
	(void)user, (void)instance, (void)surface;
	return -1;
}

const char *stilb_window_library_version(void)
{
	return "none";
}

const input_backend input_backend_hidapi = {.name = "none"};

/* Pictures cannot be saved: the functions are not there. */
const image_codec image_codec_png = {.extension = ".png"}, image_codec_exr = {.extension = ".exr"},
				  image_codec_hdr = {.extension = ".hdr"};
