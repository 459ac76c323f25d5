/*
 * window: the window, its keys and mouse, the gamepads that GLFW knows, and its Vulkan surface, through GLFW.
 *
 * Life cycle.  stilb_window_create -> stilb_window_poll once a frame -> stilb_window_destroy:
 *
 *     stilb_window_create("Example", 1280, 720, &window);
 *     for (stilb_window_state state = {0}; !state.close && !state.lost;) {
 *         stilb_window_poll(window, &state);
 *         draw(state.width, state.height, state.held[STILB_WINDOW_KEY_W]);
 *     }
 *     stilb_window_destroy(window);
 *
 * The display. An X server may end at any moment. The window is then lost, which stilb_window_state says: all calls are
 *              still allowed and do nothing, and no window can be opened again in this process.
 * Threads.     [main-thread]: all calls from the thread that created the window, which is the process's main thread;
 *              asserted. There may be several windows: each poll handles the events of all of them, and gamepads are
 *              the process's.
 */
#ifndef STILB_WINDOW_H
#define STILB_WINDOW_H

#include "base/base.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

typedef struct stilb_window stilb_window;

/* Letters are keys by their position on a US keyboard, so that WASD is a cross on every layout; digits are those above
 * the letters. What stands elsewhere on other layouts, like + and -, is read as a character: stilb_window_state.typed.
 * SHIFT, CONTROL and ENTER are either of their two keys. NONE is no key. */
typedef enum stilb_window_key {
	STILB_WINDOW_KEY_NONE,
	STILB_WINDOW_KEY_A,
	STILB_WINDOW_KEY_B,
	STILB_WINDOW_KEY_C,
	STILB_WINDOW_KEY_D,
	STILB_WINDOW_KEY_E,
	STILB_WINDOW_KEY_F,
	STILB_WINDOW_KEY_G,
	STILB_WINDOW_KEY_H,
	STILB_WINDOW_KEY_I,
	STILB_WINDOW_KEY_J,
	STILB_WINDOW_KEY_K,
	STILB_WINDOW_KEY_L,
	STILB_WINDOW_KEY_M,
	STILB_WINDOW_KEY_N,
	STILB_WINDOW_KEY_O,
	STILB_WINDOW_KEY_P,
	STILB_WINDOW_KEY_Q,
	STILB_WINDOW_KEY_R,
	STILB_WINDOW_KEY_S,
	STILB_WINDOW_KEY_T,
	STILB_WINDOW_KEY_U,
	STILB_WINDOW_KEY_V,
	STILB_WINDOW_KEY_W,
	STILB_WINDOW_KEY_X,
	STILB_WINDOW_KEY_Y,
	STILB_WINDOW_KEY_Z,
	STILB_WINDOW_KEY_0,
	STILB_WINDOW_KEY_1,
	STILB_WINDOW_KEY_2,
	STILB_WINDOW_KEY_3,
	STILB_WINDOW_KEY_4,
	STILB_WINDOW_KEY_5,
	STILB_WINDOW_KEY_6,
	STILB_WINDOW_KEY_7,
	STILB_WINDOW_KEY_8,
	STILB_WINDOW_KEY_9,
	STILB_WINDOW_KEY_F1,
	STILB_WINDOW_KEY_F2,
	STILB_WINDOW_KEY_F3,
	STILB_WINDOW_KEY_F4,
	STILB_WINDOW_KEY_F5,
	STILB_WINDOW_KEY_F6,
	STILB_WINDOW_KEY_F7,
	STILB_WINDOW_KEY_F8,
	STILB_WINDOW_KEY_F9,
	STILB_WINDOW_KEY_F10,
	STILB_WINDOW_KEY_F11,
	STILB_WINDOW_KEY_F12,
	STILB_WINDOW_KEY_SHIFT,
	STILB_WINDOW_KEY_CONTROL,
	STILB_WINDOW_KEY_SPACE,
	STILB_WINDOW_KEY_TAB,
	STILB_WINDOW_KEY_ENTER,
	STILB_WINDOW_KEY_LEFT,
	STILB_WINDOW_KEY_RIGHT,
	STILB_WINDOW_KEY_UP,
	STILB_WINDOW_KEY_DOWN,
	STILB_WINDOW_KEY_PAGE_UP,
	STILB_WINDOW_KEY_PAGE_DOWN,
	STILB_WINDOW_KEY_HOME,
	STILB_WINDOW_KEY_END,
	STILB_WINDOW_KEY_INSERT,
	STILB_WINDOW_KEY_DELETE,
	STILB_WINDOW_KEY_BACKSPACE,
	STILB_WINDOW_KEY_ESCAPE,
	STILB_WINDOW_KEY_COUNT
} stilb_window_key;

/* Typed characters that one poll can hold; more are lost. */
#define STILB_WINDOW_TYPED 16

/* The window as it is now, and what happened since the last poll. Counts stop at 255. */
typedef struct stilb_window_state {
	/* Size of the picture, pixels; 0 while the window is minimised. */
	uint32_t width, height;
	/* The user wants the window closed. */
	bool close;
	/* The display has gone; everything else is {0}. */
	bool lost;
	/* The window has the keyboard; true until the system reports that it has not. */
	bool focused;
	/* True for each key that is down now. */
	bool held[STILB_WINDOW_KEY_COUNT];
	/* Number of times that the key was pressed, and number of times that it was repeated while it was held. */
	uint8_t pressed[STILB_WINDOW_KEY_COUNT], repeated[STILB_WINDOW_KEY_COUNT];
	/* The characters that were typed, Unicode, in their order: on any layout, repeats of a held key included. */
	uint32_t typed[STILB_WINDOW_TYPED], typed_count;
	/* The right button is held: the pointer is hidden and its movement turns the camera. */
	bool mouse_captured;
	/* Movement of the captured pointer, pixels, y down. */
	float mouse_x, mouse_y;
	/* The pointer is visible and over the picture, or the left button was pressed there and is still held. */
	bool pointer;
	/* The pointer's position, pixels of the picture from the top left; 0 if `pointer` is false. */
	float pointer_x, pointer_y;
	/* Movement of the visible pointer since the last poll, pixels, y down; 0 if `pointer` was false then or is now. */
	float moved_x, moved_y;
	/* The left button is down now, the middle one is. */
	bool button, middle;
	/* Number of times that the left button was pressed. */
	uint8_t clicks;
	/* Notches of the wheel; turning it away from the user is positive. */
	float wheel;
	/* Paths of the files that the user dropped onto the window, UTF-8 as the file manager gave them; valid until the
	 * next poll. */
	const char *const *dropped;
	uint32_t dropped_count;
} stilb_window_state;

/* Opens a window whose picture has about width x height pixels, both 1..16384, which the system may change. title is
 * UTF-8. STILB_ERROR_WINDOW: there is no display, no Vulkan driver for windows, or the display was lost earlier in this
 * process, after which GLFW is not called any more; *window is then NULL. The calling thread becomes the owner.
 * [main-thread] */
stilb_result stilb_window_create(const char *title, uint32_t width, uint32_t height, stilb_window **window);

/* NULL is allowed. Surfaces of the window must be destroyed before. [main-thread] */
void stilb_window_destroy(stilb_window *window);

/* title is UTF-8. [main-thread] */
void stilb_window_title(stilb_window *window, const char *title);

/* Handles all events and fills *state. Holding the right button captures the mouse; releasing it, or Escape, ends that.
 * Does not wait. [main-thread] */
void stilb_window_poll(stilb_window *window, stilb_window_state *state);

/* True, as at first: pressing the right button captures the mouse. The program sets false while the pointer is over a
 * part of its user interface that takes clicks itself. A mouse that is already captured stays so. [main-thread] */
void stilb_window_set_capturing(stilb_window *window, bool capturing);

/* As stilb_window_poll, after waiting for an event for at most `seconds` (0 or less: not at all): for a minimised
 * window. Returns at once when the display is lost. Asserts that seconds is not NaN. [main-thread] */
void stilb_window_wait(stilb_window *window, double seconds, stilb_window_state *state);

/* A gamepad as GLFW maps it. The texts are valid until the next poll. */
typedef struct stilb_window_gamepad {
	/* UTF-8, as the device gives it; NULL: there is no gamepad here, or GLFW does not know its layout. */
	const char *name;
	/* 32 hexadecimal digits: bus, vendor, product, version; see glfwGetJoystickGUID. */
	const char *guid;
	/* In the order of GLFW_GAMEPAD_AXIS_...: left x, left y, right x, right y, left and right trigger; each in [-1, 1],
	 * sticks positive to the right and DOWN, triggers -1 at rest. */
	float axes[6];
	/* Bit 1 << GLFW_GAMEPAD_BUTTON_... is set while the button is down. */
	uint32_t buttons;
} stilb_window_gamepad;

/* Gamepads at a time: GLFW_JOYSTICK_LAST + 1. */
#define STILB_WINDOW_GAMEPADS 16

/* Fills all entries with GLFW's gamepads, entry i with joystick number i, as of the last poll. [main-thread] */
void stilb_window_gamepads(stilb_window *window, stilb_window_gamepad gamepads[STILB_WINDOW_GAMEPADS]);

/* For stilb_gpu_surface, user being the window: the names of the Vulkan instance extensions that a surface needs,
 * owned by GLFW; *count is their number. NULL: Vulkan cannot draw to windows. [main-thread] */
const char *const *stilb_window_surface_extensions(void *user, uint32_t *count);

/* For stilb_gpu_surface, user being the window: creates a surface. instance is a VkInstance with the extensions
 * above, *surface a VkSurfaceKHR that the caller destroys. Returns a VkResult; VK_ERROR_SURFACE_LOST_KHR if the display
 * is lost. [main-thread] */
int32_t stilb_window_surface_create(void *user, void *instance, uint64_t *surface);

/* GLFW's version and what it was built with, like "3.3.8 X11 GLX ..."; a static string. [any-thread] */
const char *stilb_window_library_version(void);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
