/* window [FRAMES]: the engine draws into a window of the program's own, made by GLFW, from the program's own loop. That
 * gives the engine keys and size: W A S D fly, F1 shows the profiler, Escape ends. With FRAMES it ends after so many,
 * and halfway it makes the window smaller. */
#define GLFW_INCLUDE_VULKAN
#include <GLFW/glfw3.h>
#include <stdio.h>
#include <stdlib.h>
#include <stilb/engine.h>

static const char *const *surface_extensions(void *user, uint32_t *count)
{
	(void)user;
	return glfwGetRequiredInstanceExtensions(count);
}

static int32_t surface_create(void *user, void *instance, uint64_t *surface)
{
	VkSurfaceKHR made = VK_NULL_HANDLE;
	VkResult result = glfwCreateWindowSurface(instance, user, NULL, &made);
	*surface = (uint64_t)made; /* the engine destroys it */
	return result;
}

/* What the engine's camera and panels need of the window's events: keys and size here, the mouse could follow. False:
 * the window is minimised. */
static bool read_window(GLFWwindow *window, stilb_window_state *state)
{
	static const int keys[][2] = {{GLFW_KEY_W, STILB_WINDOW_KEY_W},
	                              {GLFW_KEY_A, STILB_WINDOW_KEY_A},
	                              {GLFW_KEY_S, STILB_WINDOW_KEY_S},
	                              {GLFW_KEY_D, STILB_WINDOW_KEY_D},
	                              {GLFW_KEY_F1, STILB_WINDOW_KEY_F1}};
	int width, height;
	for (size_t i = 0; i < sizeof keys / sizeof *keys; i++) {
		bool down = glfwGetKey(window, keys[i][0]) == GLFW_PRESS;
		state->pressed[keys[i][1]] = down && !state->held[keys[i][1]];
		state->held[keys[i][1]] = down;
	}
	state->focused = glfwGetWindowAttrib(window, GLFW_FOCUSED);
	state->close = glfwWindowShouldClose(window) || glfwGetKey(window, GLFW_KEY_ESCAPE) == GLFW_PRESS;
	glfwGetFramebufferSize(window, &width, &height);
	state->width = width > 0 ? (uint32_t)width : 0;
	state->height = height > 0 ? (uint32_t)height : 0;
	return state->width > 0 && state->height > 0;
}

static stilb_result loop(GLFWwindow *window, stilb_engine *engine, uint64_t frames)
{
	stilb_window_state state = {0};
	stilb_engine_report report = {0};
	stilb_result result = STILB_OK;
	while (result == STILB_OK && !report.lost && !state.close && (frames == 0 || report.frame < frames)) {
		glfwPollEvents();
		if (frames > 0 && report.frame == frames / 2)
			glfwSetWindowSize(window, 320, 200);
		if (!read_window(window, &state)) {
			glfwWaitEvents();
			continue;
		}
		result = stilb_engine_input(engine, &state);
		if (result == STILB_OK)
			result = stilb_engine_frame(engine, &report);
	}
	uint32_t width, height;
	stilb_engine_size(engine, &width, &height);
	if (result == STILB_OK)
		printf("%u frames, the last of %u x %u%s\n", (unsigned)report.frame, width, height,
		       report.lost ? ", then the window was lost" : "");
	return result;
}

static stilb_result show(GLFWwindow *window, stilb_scene *scene, uint64_t frames)
{
	stilb_gpu_surface surface = {.user = window, .extensions = surface_extensions, .create = surface_create};
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.surface = &surface;
	desc.width = 480;
	desc.height = 270;
	stilb_engine *engine;
	stilb_result result = stilb_engine_create(&desc, &engine);
	if (result == STILB_OK)
		result = stilb_engine_set_scene(engine, scene);
	if (result == STILB_OK)
		result = loop(window, engine, frames);
	stilb_engine_destroy(engine); /* before the window and the scene */
	return result;
}

int main(int argc, char **argv)
{
	const char *why = "it is not known why";
	stilb_scene *scene;
	if (!glfwInit() || !glfwVulkanSupported()) {
		glfwGetError(&why);
		fprintf(stderr, "window: no display, or no Vulkan: %s\n", why);
		return 1;
	}
	glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API); /* the engine brings Vulkan */
	GLFWwindow *window = glfwCreateWindow(480, 270, "A window of its own", NULL, NULL);
	stilb_result result = window ? stilb_scene_open("spheres", &scene) : STILB_ERROR_WINDOW;
	if (result == STILB_OK) {
		result = show(window, scene, argc > 1 ? strtoull(argv[1], NULL, 10) : 0);
		stilb_scene_destroy(scene);
	}
	if (result != STILB_OK)
		fprintf(stderr, "window: %s\n", window ? stilb_error_message() : "no window");
	glfwTerminate();
	return result != STILB_OK;
}
