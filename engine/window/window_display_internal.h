/*
 * window_display: calls to GLFW that survive the end of the X server.
 *
 * When the connection to the X server breaks, Xlib by default ends the program by exit(1) within the call that noticed
 * it. Here that call is left by longjmp instead, out of Xlib and GLFW, and the connection is never used again: neither
 * library is in a state to be called, so window and GLFW are not shut down but abandoned. Without X11 there is nothing
 * to protect. A libX11 before 1.7 cannot be kept from exit(1) if the Vulkan driver is first to notice the break.
 *
 * Life cycle.  window_display_begin -> window_display_call(glfwInit, then window_display_opened) -> window_display_call
 *              around every other call to GLFW.
 * Threads.     [main-thread], the one that called window_display_begin; asserted.
 */
#ifndef STILB_WINDOW_DISPLAY_INTERNAL_H
#define STILB_WINDOW_DISPLAY_INTERNAL_H

#include <stdbool.h>

/* Installs the handler of broken connections. Called before each glfwInit, within which the connection may break. */
void window_display_begin(void);

/* Asks GLFW for the connection that it has opened, so that its break is told from those of other connections. Called
 * after each glfwInit. */
void window_display_opened(void);

/* Runs call(data), which may call GLFW. False: the display is lost, and call was left half-way or not begun. Must not
 * be nested; GLFW's callbacks during the call are protected by it already. */
bool window_display_call(void (*call)(void *data), void *data);

/* True once the display is lost, for the rest of the process. [any-thread] */
bool window_display_is_lost(void);

#endif
