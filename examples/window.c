/* window [FRAMES]: the engine draws into a window of the program's own, made by GLFW, from the program's own loop. That
 * has the events: A and D turn the camera, Escape ends. With FRAMES it ends after so many, and halfway it makes the
 * window smaller. */
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

/* Follows the size of the window. False: it has none, because it is minimised. */
static bool follow_size(GLFWwindow *window, stilb_engine *engine, stilb_result *result)
{
	int width, height;
	uint32_t drawn_width, drawn_height;
	glfwGetFramebufferSize(window, &width, &height);
	if (width <= 0 || height <= 0)
		return false;
	stilb_engine_size(engine, &drawn_width, &drawn_height);
	if ((uint32_t)width != drawn_width || (uint32_t)height != drawn_height)
		*result = stilb_engine_resize(engine, (uint32_t)width, (uint32_t)height);
	return *result == STILB_OK;
}

static void turn_camera(GLFWwindow *window, stilb_scene *scene)
{
	if (glfwGetKey(window, GLFW_KEY_A) == GLFW_PRESS)
		scene->camera.yaw += 0.02f;
	if (glfwGetKey(window, GLFW_KEY_D) == GLFW_PRESS)
		scene->camera.yaw -= 0.02f;
}

static stilb_result loop(GLFWwindow *window, stilb_engine *engine, uint64_t frames)
{
	stilb_engine_report report = {0};
	stilb_result result = STILB_OK;
	while (result == STILB_OK && !report.lost && !glfwWindowShouldClose(window) &&
	       (frames == 0 || report.frame < frames)) {
		glfwPollEvents();
		if (frames > 0 && report.frame == frames / 2)
			glfwSetWindowSize(window, 320, 200);
		if (glfwGetKey(window, GLFW_KEY_ESCAPE) == GLFW_PRESS)
			glfwSetWindowShouldClose(window, GLFW_TRUE);
		turn_camera(window, stilb_engine_scene(engine));
		if (follow_size(window, engine, &result))
			result = stilb_engine_frame(engine, &report);
		else if (result == STILB_OK)
			glfwWaitEvents();
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
	stilb_render_surface surface = {.user = window, .extensions = surface_extensions, .create = surface_create};
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
