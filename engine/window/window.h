/*
 * window: the window, its keys and mouse, the gamepads that GLFW knows, and its Vulkan surface, through GLFW.
 *
 * Life cycle.  stilb_window_create -> stilb_window_poll once a frame -> stilb_window_destroy.
 * The display. An X server may end at any moment. The window is lost then, which stilb_window_state says: all calls are still
 *              allowed and do nothing, and no window can be opened again in this process.
 * Threads.     All [main-thread]: the one that created the window.
 */
#ifndef STILB_WINDOW_H
#define STILB_WINDOW_H

#include "base/base.h"

typedef struct stilb_window stilb_window;

/* Letters by their place on a US keyboard, so that WASD is a cross on every layout. */
typedef enum stilb_window_key {
	STILB_WINDOW_KEY_W,
	STILB_WINDOW_KEY_A,
	STILB_WINDOW_KEY_S,
	STILB_WINDOW_KEY_D,
	STILB_WINDOW_KEY_Q,
	STILB_WINDOW_KEY_E,
	STILB_WINDOW_KEY_P,
	STILB_WINDOW_KEY_V,
	STILB_WINDOW_KEY_F1,
	STILB_WINDOW_KEY_F2,
	STILB_WINDOW_KEY_F12,
	STILB_WINDOW_KEY_MINUS, /* typed, on any layout; never held */
	STILB_WINDOW_KEY_PLUS,  /* the same; '=' counts too, where + needs shift */
	STILB_WINDOW_KEY_SHIFT, /* either */
	STILB_WINDOW_KEY_CONTROL,
	STILB_WINDOW_KEY_SPACE,
	STILB_WINDOW_KEY_TAB,
	STILB_WINDOW_KEY_ENTER, /* either */
	STILB_WINDOW_KEY_LEFT,
	STILB_WINDOW_KEY_RIGHT,
	STILB_WINDOW_KEY_UP,
	STILB_WINDOW_KEY_DOWN,
	STILB_WINDOW_KEY_ESCAPE,
	STILB_WINDOW_KEY_COUNT
} stilb_window_key;

/* What happened since the poll before. */
typedef struct stilb_window_state {
	uint32_t width, height;                   /* of the picture, pixels; 0 while minimised */
	bool close;                               /* the user wants the window closed */
	bool lost;                                /* its display has gone; the rest is {0} */
	bool focused;                             /* keys come here; true until the window is told otherwise */
	bool held[STILB_WINDOW_KEY_COUNT];        /* is down now */
	uint8_t pressed[STILB_WINDOW_KEY_COUNT];  /* how often it went down */
	uint8_t repeated[STILB_WINDOW_KEY_COUNT]; /* how often it would have been typed again, being held */
	bool mouse_captured;                      /* the right button is held: the pointer is hidden and steers */
	float mouse_x, mouse_y;                   /* its way while captured, pixels, y down */
	bool pointer;                             /* not captured, and over the picture or pressed there and still held */
	float pointer_x, pointer_y;               /* where it is, pixels of the picture from the top left */
	bool button;                              /* the left button is held now */
	uint8_t clicks;                           /* how often it went down */
	float wheel;                              /* notches, away from the user is positive */
} stilb_window_state;

/* Opens a window of about this size, pixels. STILB_ERROR_WINDOW without a display, without Vulkan for windows, and after
 * a display has been lost. */
stilb_result stilb_window_create(const char *title, uint32_t width, uint32_t height, stilb_window **window);

/* NULL is fine. */
void stilb_window_destroy(stilb_window *window);

void stilb_window_title(stilb_window *window, const char *title);

/* Takes in events. Holding the right button captures the mouse; releasing it, or Escape, lets go. */
void stilb_window_poll(stilb_window *window, stilb_window_state *state);

/* Whether the right button captures, true at first: not while the pointer is over something that it belongs to. What has
 * been captured stays so. */
void stilb_window_set_capturing(stilb_window *window, bool capturing);

/* The same after waiting for an event, at most `seconds` (0 or less: not at all): for a minimised window. Returns at once when
 * the display is lost. */
void stilb_window_wait(stilb_window *window, double seconds, stilb_window_state *state);

/* A gamepad as GLFW maps it. The texts are valid until the next poll. */
typedef struct stilb_window_gamepad {
	const char *name; /* NULL: there is none at this place, or GLFW does not know its layout */
	const char *guid; /* 32 hexadecimal digits: bus, vendor, product, version */
	float axes[6]; /* in the order of GLFW_GAMEPAD_AXIS_...: sticks to the right and down, triggers; all in [-1, 1] */
	uint32_t buttons; /* bit 1 << GLFW_GAMEPAD_BUTTON_...: is down */
} stilb_window_gamepad;

#define STILB_WINDOW_GAMEPADS 16

/* As they are now. */
void stilb_window_gamepads(stilb_window *window, stilb_window_gamepad gamepads[STILB_WINDOW_GAMEPADS]);

/* The three calls that render's stilb_render_surface wants; user is the window, instance a VkInstance, *surface a
 * VkSurfaceKHR; returns a VkResult. */
const char *const *stilb_window_surface_extensions(void *user, uint32_t *count);
int32_t stilb_window_surface_create(void *user, void *instance, uint64_t *surface);

/* "3.3.8 X11 GLX ..." */
const char *stilb_window_library_version(void);

#endif
