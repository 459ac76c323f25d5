#include "window/window.h"

#include "base/base_contract.h"
#include "window/window_display_internal.h"

#define GLFW_INCLUDE_VULKAN /* for glfwCreateWindowSurface; nothing else of Vulkan is used here */
#include <GLFW/glfw3.h>

#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WINDOW_SIZE_MAX 16384u /* pixels a side: the largest picture of common GPUs */

struct stilb_window {
	stilb_owner owner;
	GLFWwindow *handle;
	uint8_t pressed[STILB_WINDOW_KEY_COUNT], repeated[STILB_WINDOW_KEY_COUNT]; /* since the last poll */
	uint32_t typed[STILB_WINDOW_TYPED], typed_count;                           /* [typed_count], since then */
	uint8_t clicks;
	float wheel;
	bool focused;
	bool capturing; /* pressing the right button captures the mouse */
	bool captured;
	bool fresh;  /* captured since the last poll: the next movement is ignored, as capturing itself moves the pointer */
	double x, y; /* of the pointer at the last poll */
	bool pointer; /* as the last poll reported it, with its position in pixels */
	float pointer_x, pointer_y;
	char **dropped; /* [dropped_count], of the events of the last poll */
	uint32_t dropped_count;
};

#define WINDOW_GONE "the display has gone"

/* Open windows. GLFW, one for the process, is initialised before the first and terminated after the last.
 * [main-thread] */
static uint32_t window_open_count;

/* The text of GLFW's last error, for messages: GLFW reports errors through one callback. [main-thread] */
static char window_error[512];

static void window_on_error(int code, const char *text)
{
	(void)code;
	snprintf(window_error, sizeof window_error, "%s", text);
}

/* GLFW's number of each key of stilb_window_key; several of GLFW's may be one key here. A row is `count` keys that
 * follow one another in both. */
static const struct {
	int glfw;
	stilb_window_key key;
	int count;
} window_keys[] = {
	{GLFW_KEY_A, STILB_WINDOW_KEY_A, 26},
	{GLFW_KEY_0, STILB_WINDOW_KEY_0, 10},
	{GLFW_KEY_F1, STILB_WINDOW_KEY_F1, 12},
	{GLFW_KEY_LEFT_SHIFT, STILB_WINDOW_KEY_SHIFT, 1},
	{GLFW_KEY_RIGHT_SHIFT, STILB_WINDOW_KEY_SHIFT, 1},
	{GLFW_KEY_LEFT_CONTROL, STILB_WINDOW_KEY_CONTROL, 1},
	{GLFW_KEY_RIGHT_CONTROL, STILB_WINDOW_KEY_CONTROL, 1},
	{GLFW_KEY_SPACE, STILB_WINDOW_KEY_SPACE, 1},
	{GLFW_KEY_TAB, STILB_WINDOW_KEY_TAB, 1},
	{GLFW_KEY_ENTER, STILB_WINDOW_KEY_ENTER, 1},
	{GLFW_KEY_KP_ENTER, STILB_WINDOW_KEY_ENTER, 1},
	{GLFW_KEY_LEFT, STILB_WINDOW_KEY_LEFT, 1},
	{GLFW_KEY_RIGHT, STILB_WINDOW_KEY_RIGHT, 1},
	{GLFW_KEY_UP, STILB_WINDOW_KEY_UP, 1},
	{GLFW_KEY_DOWN, STILB_WINDOW_KEY_DOWN, 1},
	{GLFW_KEY_PAGE_UP, STILB_WINDOW_KEY_PAGE_UP, 1},
	{GLFW_KEY_PAGE_DOWN, STILB_WINDOW_KEY_PAGE_DOWN, 1},
	{GLFW_KEY_HOME, STILB_WINDOW_KEY_HOME, 1},
	{GLFW_KEY_END, STILB_WINDOW_KEY_END, 1},
	{GLFW_KEY_INSERT, STILB_WINDOW_KEY_INSERT, 1},
	{GLFW_KEY_DELETE, STILB_WINDOW_KEY_DELETE, 1},
	{GLFW_KEY_BACKSPACE, STILB_WINDOW_KEY_BACKSPACE, 1},
	{GLFW_KEY_ESCAPE, STILB_WINDOW_KEY_ESCAPE, 1},
};
#define WINDOW_KEYS (sizeof window_keys / sizeof *window_keys)
static_assert(STILB_WINDOW_KEY_Z - STILB_WINDOW_KEY_A == 25 && STILB_WINDOW_KEY_9 - STILB_WINDOW_KEY_0 == 9 &&
                  STILB_WINDOW_KEY_F12 - STILB_WINDOW_KEY_F1 == 11,
              "they follow one another, as GLFW's do");

/* The key with this number of GLFW's; NONE: it is not in the table. */
static stilb_window_key window_key(int glfw)
{
	for (size_t i = 0; i < WINDOW_KEYS; i++)
		if (glfw >= window_keys[i].glfw && glfw < window_keys[i].glfw + window_keys[i].count)
			return (stilb_window_key)((int)window_keys[i].key + glfw - window_keys[i].glfw);
	return STILB_WINDOW_KEY_NONE;
}

/* For STILB_CHECK: `fresh` is set only while the mouse is captured, and NONE is never counted. */
static bool window_is_sound(const stilb_window *window)
{
	return window->handle && (!window->fresh || window->captured) && !window->pressed[STILB_WINDOW_KEY_NONE] &&
	       !window->repeated[STILB_WINDOW_KEY_NONE];
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
	STILB_ASSERT(window);
	STILB_ASSERT_OWNER(window->owner);
	window->capturing = capturing;
}

/* Counts up to 255. */
static void window_count(uint8_t *count)
{
	*count += *count < UINT8_MAX;
}

static void window_on_key(GLFWwindow *handle, int glfw_key, int scancode, int action, int modifiers)
{
	(void)scancode, (void)modifiers;
	stilb_window *window = glfwGetWindowUserPointer(handle);
	stilb_window_key key = window_key(glfw_key);
	if (key == STILB_WINDOW_KEY_NONE || action == GLFW_RELEASE)
		return;
	window_count(action == GLFW_PRESS ? &window->pressed[key] : &window->repeated[key]);
	if (key == STILB_WINDOW_KEY_ESCAPE)
		window_capture(window, false);
}

static void window_on_character(GLFWwindow *handle, unsigned character)
{
	stilb_window *window = glfwGetWindowUserPointer(handle);
	if (window->typed_count < STILB_WINDOW_TYPED)
		window->typed[window->typed_count++] = character;
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

static void window_forget_dropped(stilb_window *window)
{
	for (uint32_t i = 0; i < window->dropped_count; i++)
		free(window->dropped[i]);
	free(window->dropped);
	window->dropped = NULL;
	window->dropped_count = 0;
}

/* Adds the files of one drop to those of this poll; without memory some are lost. */
static void window_on_drop(GLFWwindow *handle, int count, const char **paths)
{
	stilb_window *window = glfwGetWindowUserPointer(handle);
	char **dropped = realloc(window->dropped, (window->dropped_count + (size_t)count) * sizeof *dropped);
	if (!dropped)
		return;
	window->dropped = dropped;
	for (int i = 0; i < count; i++)
		if ((window->dropped[window->dropped_count] = strdup(paths[i])))
			window->dropped_count++;
}

/* The window counts as focused until this reports that it is not. glfwGetWindowAttrib is not asked, because without a
 * window manager it calls a window unfocused that gets keys all the same. */
static void window_on_focus(GLFWwindow *handle, int focused)
{
	stilb_window *window = glfwGetWindowUserPointer(handle);
	window->focused = focused;
}

/* Arguments and results of the functions that run within window_display_call. */
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
	if (window_open_count == 0)
		window_display_call(window_call_terminate, NULL);
	return result;
}

/* On X11, GLFW sets the process's locale for characters from the environment if it is "C", to learn from the system
 * which characters are typed. Here the program's locale is put back: - + and = are the same in each. */
static void window_call_init(void *data)
{
	bool *started = data;
	char locale[256];
	const char *before = setlocale(LC_CTYPE, NULL);
	int length = snprintf(locale, sizeof locale, "%s", before ? before : "");
	bool success = glfwInit();
	if (length > 0 && (size_t)length < sizeof locale)
		setlocale(LC_CTYPE, locale);
	if (!success)
		return;
	window_display_opened();
	*started = true;
}

/* Initialises GLFW for the first window. False: it cannot be, and window_error says why. */
static bool window_start(void)
{
	if (window_open_count > 0)
		return true;
	bool started = false;
	window_display_begin();
	if (!window_display_call(window_call_init, &started))
		snprintf(window_error, sizeof window_error, WINDOW_GONE);
	return started;
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
	glfwSetDropCallback(handle, window_on_drop);
	glfwSetWindowFocusCallback(handle, window_on_focus);
	window->handle = handle;
}

stilb_result stilb_window_create(const char *title, uint32_t width, uint32_t height, stilb_window **out)
{
	STILB_ASSERT(title && out);
	STILB_ASSERT(width >= 1 && width <= WINDOW_SIZE_MAX && "a width in pixels");
	STILB_ASSERT(height >= 1 && height <= WINDOW_SIZE_MAX && "a height in pixels");
	*out = NULL;
	snprintf(window_error, sizeof window_error, WINDOW_GONE "; start the program again");
	if (window_display_is_lost())
		return window_fail("open a window");
	snprintf(window_error, sizeof window_error, "no reason given");
	glfwSetErrorCallback(window_on_error);
	if (!window_start())
		return window_fail("open a window");
	snprintf(window_error, sizeof window_error, "no Vulkan driver that can draw to windows");
	if (!glfwVulkanSupported())
		return window_fail("open a window");
	snprintf(window_error, sizeof window_error, "out of memory");
	stilb_window *window = calloc(1, sizeof *window);
	window_call call = {.window = window, .title = title, .width = width, .height = height};
	glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
	if (window && !window_display_call(window_call_create, &call))
		snprintf(window_error, sizeof window_error, WINDOW_GONE);
	if (!window || !window->handle) {
		free(window);
		return window_fail("open a window");
	}
	window_open_count++;
	stilb_owner_take(&window->owner);
	window->focused = window->capturing = true;
	*out = window;
	return STILB_OK;
}

static void window_call_destroy(void *data)
{
	stilb_window *window = data;
	glfwDestroyWindow(window->handle);
	if (window_open_count == 0)
		glfwTerminate();
}

void stilb_window_destroy(stilb_window *window)
{
	if (!window)
		return;
	STILB_ASSERT_OWNER(window->owner);
	STILB_ASSERT(window_open_count > 0);
	window_open_count--;
	window_display_call(window_call_destroy, window);
	window_forget_dropped(window);
	free(window);
}

static void window_call_title(void *data)
{
	window_call *call = data;
	glfwSetWindowTitle(call->window->handle, call->title);
}

void stilb_window_title(stilb_window *window, const char *title)
{
	STILB_ASSERT(window && title);
	STILB_ASSERT_OWNER(window->owner);
	window_call call = {.window = window, .title = title};
	window_display_call(window_call_title, &call);
}

static bool window_is_down(GLFWwindow *handle, int key)
{
	return glfwGetKey(handle, key) == GLFW_PRESS;
}

static void window_read_keys(stilb_window *window, stilb_window_state *state)
{
	for (size_t i = 0; i < WINDOW_KEYS; i++)
		for (int k = 0; k < window_keys[i].count; k++)
			state->held[(int)window_keys[i].key + k] |= window_is_down(window->handle, window_keys[i].glfw + k);
	for (int key = 0; key < STILB_WINDOW_KEY_COUNT; key++) {
		state->pressed[key] = window->pressed[key];
		state->repeated[key] = window->repeated[key];
		window->pressed[key] = window->repeated[key] = 0;
	}
	memcpy(state->typed, window->typed, sizeof state->typed);
	state->typed_count = window->typed_count;
	window->typed_count = 0;
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
	glfwGetWindowSize(window->handle, &width,
	                  &height); /* in the unit of the pointer's position, which may differ from a pixel */
	state->button = glfwGetMouseButton(window->handle, GLFW_MOUSE_BUTTON_LEFT) == GLFW_PRESS;
	state->middle = glfwGetMouseButton(window->handle, GLFW_MOUSE_BUTTON_MIDDLE) == GLFW_PRESS;
	state->pointer =
		!window->captured && (state->button || state->middle || glfwGetWindowAttrib(window->handle, GLFW_HOVERED));
	if (state->pointer && width > 0 && height > 0) {
		state->pointer_x = (float)(window->x * state->width / width);
		state->pointer_y = (float)(window->y * state->height / height);
	}
	if (state->pointer && window->pointer) {
		state->moved_x = state->pointer_x - window->pointer_x;
		state->moved_y = state->pointer_y - window->pointer_y;
	}
	window->pointer = state->pointer;
	window->pointer_x = state->pointer_x;
	window->pointer_y = state->pointer_y;
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
	state->dropped = (const char *const *)window->dropped;
	state->dropped_count = window->dropped_count;
	STILB_CHECK(window_is_sound(window));
}

static void window_call_poll(void *data)
{
	window_call *call = data;
	window_forget_dropped(call->window);
	if (call->seconds > 0.0)
		glfwWaitEventsTimeout(call->seconds);
	else
		glfwPollEvents();
	/* On X11 that may have been only what came with the answers to the last poll's questions: Xlib looks for newer
	 * events when it holds none. */
	glfwPollEvents();
	window_read(call->window, call->state);
}

void stilb_window_poll(stilb_window *window, stilb_window_state *state)
{
	stilb_window_wait(window, 0.0, state);
}

void stilb_window_wait(stilb_window *window, double seconds, stilb_window_state *state)
{
	STILB_ASSERT(window && state);
	STILB_ASSERT(!isnan(seconds) && "a time to wait");
	STILB_ASSERT_OWNER(window->owner);
	window_call call = {.window = window, .state = state, .seconds = seconds};
	if (!window_display_call(window_call_poll, &call))
		*state = (stilb_window_state){.lost = true};
}

void stilb_window_gamepads(stilb_window *window, stilb_window_gamepad gamepads[STILB_WINDOW_GAMEPADS])
{
	STILB_ASSERT(window && gamepads);
	STILB_ASSERT_OWNER(window->owner); /* the only use of `window`: GLFW has one set of gamepads for the process */
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
	STILB_ASSERT(user && count);
	return glfwGetRequiredInstanceExtensions(count);
}

static void window_call_surface(void *data)
{
	window_call *call = data;
	call->result = glfwCreateWindowSurface(call->instance, call->window->handle, NULL, &call->surface);
}

int32_t stilb_window_surface_create(void *user, void *instance, uint64_t *surface)
{
	STILB_ASSERT(user && surface);
	STILB_ASSERT_OWNER(((stilb_window *)user)->owner);
	window_call call = {.window = user, .instance = instance, .result = VK_ERROR_SURFACE_LOST_KHR};
	window_display_call(window_call_surface, &call);
	*surface = (uint64_t)call.surface;
	return call.result;
}

const char *stilb_window_library_version(void)
{
	return glfwGetVersionString();
}
