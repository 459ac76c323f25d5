#include "window/window.h"

#include "window/window_display.h"

#define GLFW_INCLUDE_VULKAN /* for glfwCreateWindowSurface; nothing else of Vulkan is used here */
#include <GLFW/glfw3.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct stilb_window {
	GLFWwindow *handle;
	uint8_t pressed[STILB_WINDOW_KEY_COUNT], repeated[STILB_WINDOW_KEY_COUNT]; /* since the last poll */
	uint8_t clicks;
	float wheel;
	bool focused;
	bool capturing; /* the right button captures */
	bool captured;
	bool fresh; /* captured since the last poll: the pointer jumped, its way does not count */
	double x, y;
};

/* GLFW reports errors through one callback; the last text is what a message can quote. [main-thread] */
static char window_error[512];

static void window_on_error(int code, const char *text)
{
	(void)code;
	snprintf(window_error, sizeof window_error, "%s", text);
}

/* The key of ours for a key of GLFW's; STILB_WINDOW_KEY_COUNT for the rest. */
static stilb_window_key window_key(int key)
{
	switch (key) {
	case GLFW_KEY_W:
		return STILB_WINDOW_KEY_W;
	case GLFW_KEY_A:
		return STILB_WINDOW_KEY_A;
	case GLFW_KEY_S:
		return STILB_WINDOW_KEY_S;
	case GLFW_KEY_D:
		return STILB_WINDOW_KEY_D;
	case GLFW_KEY_Q:
		return STILB_WINDOW_KEY_Q;
	case GLFW_KEY_E:
		return STILB_WINDOW_KEY_E;
	case GLFW_KEY_P:
		return STILB_WINDOW_KEY_P;
	case GLFW_KEY_V:
		return STILB_WINDOW_KEY_V;
	case GLFW_KEY_F1:
		return STILB_WINDOW_KEY_F1;
	case GLFW_KEY_F2:
		return STILB_WINDOW_KEY_F2;
	case GLFW_KEY_F12:
		return STILB_WINDOW_KEY_F12;
	case GLFW_KEY_LEFT_SHIFT:
	case GLFW_KEY_RIGHT_SHIFT:
		return STILB_WINDOW_KEY_SHIFT;
	case GLFW_KEY_LEFT_CONTROL:
	case GLFW_KEY_RIGHT_CONTROL:
		return STILB_WINDOW_KEY_CONTROL;
	case GLFW_KEY_SPACE:
		return STILB_WINDOW_KEY_SPACE;
	case GLFW_KEY_TAB:
		return STILB_WINDOW_KEY_TAB;
	case GLFW_KEY_ENTER:
	case GLFW_KEY_KP_ENTER:
		return STILB_WINDOW_KEY_ENTER;
	case GLFW_KEY_LEFT:
		return STILB_WINDOW_KEY_LEFT;
	case GLFW_KEY_RIGHT:
		return STILB_WINDOW_KEY_RIGHT;
	case GLFW_KEY_UP:
		return STILB_WINDOW_KEY_UP;
	case GLFW_KEY_DOWN:
		return STILB_WINDOW_KEY_DOWN;
	case GLFW_KEY_ESCAPE:
		return STILB_WINDOW_KEY_ESCAPE;
	default:
		return STILB_WINDOW_KEY_COUNT;
	}
}

static void window_capture(stilb_window *window, bool captured)
{
	if (window->captured == captured)
		return;
	window->captured = window->fresh = captured;
	glfwSetInputMode(window->handle, GLFW_CURSOR, captured ? GLFW_CURSOR_DISABLED : GLFW_CURSOR_NORMAL);
}

void stilb_window_set_capturing(stilb_window *window, bool capturing)
{
	window->capturing = capturing;
}

static void window_count(uint8_t *count)
{
	*count += *count < UINT8_MAX;
}

static void window_on_key(GLFWwindow *handle, int glfw_key, int scancode, int action, int modifiers)
{
	(void)scancode, (void)modifiers;
	stilb_window *window = glfwGetWindowUserPointer(handle);
	stilb_window_key key = window_key(glfw_key);
	if (key == STILB_WINDOW_KEY_COUNT || action == GLFW_RELEASE)
		return;
	window_count(action == GLFW_PRESS ? &window->pressed[key] : &window->repeated[key]);
	if (key == STILB_WINDOW_KEY_ESCAPE)
		window_capture(window, false);
}

/* - and + lie elsewhere on every layout: they count by what is typed. */
static void window_on_character(GLFWwindow *handle, unsigned character)
{
	stilb_window *window = glfwGetWindowUserPointer(handle);
	if (character == '-')
		window_count(&window->pressed[STILB_WINDOW_KEY_MINUS]);
	if (character == '+' || character == '=')
		window_count(&window->pressed[STILB_WINDOW_KEY_PLUS]);
}

static void window_on_button(GLFWwindow *handle, int button, int action, int modifiers)
{
	(void)modifiers;
	stilb_window *window = glfwGetWindowUserPointer(handle);
	if (button == GLFW_MOUSE_BUTTON_LEFT && action == GLFW_PRESS)
		window_count(&window->clicks);
	if (button == GLFW_MOUSE_BUTTON_RIGHT)
		window_capture(window, action == GLFW_PRESS && window->capturing);
}

static void window_on_wheel(GLFWwindow *handle, double sideways, double notches)
{
	(void)sideways;
	stilb_window *window = glfwGetWindowUserPointer(handle);
	window->wheel += (float)notches;
}

/* Told, not asked for: without a window manager keys also come to a window that the display server calls unfocused. */
static void window_on_focus(GLFWwindow *handle, int focused)
{
	stilb_window *window = glfwGetWindowUserPointer(handle);
	window->focused = focused;
}

/* What one guarded call takes and gives back. */
typedef struct window_call {
	stilb_window *window;
	stilb_window_state *state;
	const char *title;
	uint32_t width, height;
	double seconds;
	VkInstance instance;
	VkSurfaceKHR surface;
	VkResult result;
} window_call;

static void window_call_terminate(void *data)
{
	(void)data;
	glfwTerminate();
}

static stilb_result window_fail(const char *what)
{
	stilb_result result = stilb_fail(STILB_ERROR_WINDOW, "cannot %s: %s", what, window_error);
	window_display_call(window_call_terminate, NULL);
	return result;
}

static void window_call_create(void *data)
{
	window_call *call = data;
	stilb_window *window = call->window;
	GLFWwindow *handle = glfwCreateWindow((int)call->width, (int)call->height, call->title, NULL, NULL);
	if (!handle)
		return;
	glfwSetWindowUserPointer(handle, window);
	glfwSetKeyCallback(handle, window_on_key);
	glfwSetCharCallback(handle, window_on_character);
	glfwSetMouseButtonCallback(handle, window_on_button);
	glfwSetScrollCallback(handle, window_on_wheel);
	glfwSetWindowFocusCallback(handle, window_on_focus);
	window->handle = handle;
}

stilb_result stilb_window_create(const char *title, uint32_t width, uint32_t height, stilb_window **out)
{
	*out = NULL;
	snprintf(window_error, sizeof window_error, "the display has gone; start the program again");
	if (window_display_is_lost())
		return window_fail("open a window");
	snprintf(window_error, sizeof window_error, "no reason given");
	glfwSetErrorCallback(window_on_error);
	if (!glfwInit())
		return window_fail("open a window");
	window_display_watch();
	snprintf(window_error, sizeof window_error, "no Vulkan driver that can draw to windows");
	if (!glfwVulkanSupported())
		return window_fail("open a window");
	snprintf(window_error, sizeof window_error, "out of memory");
	stilb_window *window = calloc(1, sizeof *window);
	window_call call = {.window = window, .title = title, .width = width, .height = height};
	glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
	if (window && !window_display_call(window_call_create, &call))
		snprintf(window_error, sizeof window_error, "the display has gone");
	if (!window || !window->handle) {
		free(window);
		return window_fail("open a window");
	}
	window->focused = window->capturing = true;
	*out = window;
	return STILB_OK;
}

static void window_call_destroy(void *data)
{
	stilb_window *window = data;
	glfwDestroyWindow(window->handle);
	glfwTerminate();
}

void stilb_window_destroy(stilb_window *window)
{
	if (!window)
		return;
	window_display_call(window_call_destroy, window);
	free(window);
}

static void window_call_title(void *data)
{
	window_call *call = data;
	glfwSetWindowTitle(call->window->handle, call->title);
}

void stilb_window_title(stilb_window *window, const char *title)
{
	window_call call = {.window = window, .title = title};
	window_display_call(window_call_title, &call);
}

static bool window_is_down(GLFWwindow *handle, int key)
{
	return glfwGetKey(handle, key) == GLFW_PRESS;
}

static void window_read_keys(stilb_window *window, stilb_window_state *state)
{
	for (int key = GLFW_KEY_SPACE; key <= GLFW_KEY_LAST; key++) {
		stilb_window_key ours = window_key(key);
		if (ours != STILB_WINDOW_KEY_COUNT)
			state->held[ours] |= window_is_down(window->handle, key);
	}
	for (int key = 0; key < STILB_WINDOW_KEY_COUNT; key++) {
		state->pressed[key] = window->pressed[key];
		state->repeated[key] = window->repeated[key];
		window->pressed[key] = window->repeated[key] = 0;
	}
}

static void window_read_mouse(stilb_window *window, stilb_window_state *state)
{
	double x, y;
	glfwGetCursorPos(window->handle, &x, &y);
	if (window->captured && !window->fresh) {
		state->mouse_x = (float)(x - window->x);
		state->mouse_y = (float)(y - window->y);
	}
	window->fresh = false;
	window->x = x;
	window->y = y;
	state->mouse_captured = window->captured;
}

static void window_read_pointer(stilb_window *window, stilb_window_state *state)
{
	int width, height;
	glfwGetWindowSize(window->handle, &width, &height); /* in the units of the pointer, which need not be pixels */
	state->button = glfwGetMouseButton(window->handle, GLFW_MOUSE_BUTTON_LEFT) == GLFW_PRESS;
	state->pointer = !window->captured && (state->button || glfwGetWindowAttrib(window->handle, GLFW_HOVERED));
	if (state->pointer && width > 0 && height > 0) {
		state->pointer_x = (float)(window->x * state->width / width);
		state->pointer_y = (float)(window->y * state->height / height);
	}
	state->clicks = window->clicks;
	state->wheel = window->wheel;
	window->clicks = 0;
	window->wheel = 0.0f;
}

static void window_read(stilb_window *window, stilb_window_state *state)
{
	int width, height;
	*state = (stilb_window_state){.close = glfwWindowShouldClose(window->handle), .focused = window->focused};
	glfwGetFramebufferSize(window->handle, &width, &height);
	bool minimised = glfwGetWindowAttrib(window->handle, GLFW_ICONIFIED);
	state->width = minimised || width < 0 ? 0 : (uint32_t)width;
	state->height = minimised || height < 0 ? 0 : (uint32_t)height;
	window_read_keys(window, state);
	window_read_mouse(window, state);
	window_read_pointer(window, state);
}

static void window_call_poll(void *data)
{
	window_call *call = data;
	if (call->seconds > 0.0)
		glfwWaitEventsTimeout(call->seconds);
	else
		glfwPollEvents();
	window_read(call->window, call->state);
}

void stilb_window_poll(stilb_window *window, stilb_window_state *state)
{
	stilb_window_wait(window, 0.0, state);
}

void stilb_window_wait(stilb_window *window, double seconds, stilb_window_state *state)
{
	window_call call = {.window = window, .state = state, .seconds = seconds};
	if (!window_display_call(window_call_poll, &call))
		*state = (stilb_window_state){.lost = true};
}

void stilb_window_gamepads(stilb_window *window, stilb_window_gamepad gamepads[STILB_WINDOW_GAMEPADS])
{
	(void)window; /* GLFW's gamepads are the process's, and are there while a window is */
	static_assert(STILB_WINDOW_GAMEPADS == GLFW_JOYSTICK_LAST + 1, "a place for each");
	for (int i = 0; i < STILB_WINDOW_GAMEPADS; i++) {
		stilb_window_gamepad *pad = &gamepads[i];
		GLFWgamepadstate state;
		*pad = (stilb_window_gamepad){0};
		if (window_display_is_lost() || !glfwGetGamepadState(i, &state))
			continue;
		static_assert(sizeof pad->axes == sizeof state.axes, "all axes");
		memcpy(pad->axes, state.axes, sizeof pad->axes);
		for (uint32_t b = 0; b <= GLFW_GAMEPAD_BUTTON_LAST; b++)
			pad->buttons |= (uint32_t)(state.buttons[b] == GLFW_PRESS) << b;
		pad->guid = glfwGetJoystickGUID(i);
		pad->name = pad->guid ? glfwGetJoystickName(i) : NULL;
	}
}

const char *const *stilb_window_surface_extensions(void *user, uint32_t *count)
{
	(void)user;
	return glfwGetRequiredInstanceExtensions(count);
}

static void window_call_surface(void *data)
{
	window_call *call = data;
	call->result = glfwCreateWindowSurface(call->instance, call->window->handle, NULL, &call->surface);
}

int32_t stilb_window_surface_create(void *user, void *instance, uint64_t *surface)
{
	window_call call = {.window = user, .instance = instance, .result = VK_ERROR_SURFACE_LOST_KHR};
	window_display_call(window_call_surface, &call);
	*surface = (uint64_t)call.surface;
	return call.result;
}

const char *stilb_window_library_version(void)
{
	return glfwGetVersionString();
}
