/*
 * window_display: calls to GLFW that survive the end of the X server.
 *
 * When its connection breaks, Xlib by default ends the program by exit(1) within the call that noticed it. Here that
 * call is left by longjmp instead, out of Xlib and GLFW, and the connection is never used again: neither library is in
 * a state to be called, so window and GLFW are not shut down but abandoned. Without X11 there is nothing to protect;
 * with a libX11 before 1.7, a break that the Vulkan driver notices first still ends the program.
 *
 * Life cycle.  window_display_begin -> window_display_call(glfwInit, then window_display_opened) -> window_display_call
 *              around every other call to GLFW.
 * Threads.     [main-thread], the one that called window_display_begin; asserted.
 */
#ifndef STILB_WINDOW_DISPLAY_INTERNAL_H
#define STILB_WINDOW_DISPLAY_INTERNAL_H

#include <stdbool.h>

/* Installs the handler of broken connections: before each glfwInit, which may meet one already. */
void window_display_begin(void);

/* Tells which connection GLFW has opened: after each glfwInit. */
void window_display_opened(void);

/* Runs call(data), which may call GLFW. False: the display is lost, and call was left half-way or not begun. Must not
 * be nested; GLFW's callbacks during the call are protected by it already. */
bool window_display_call(void (*call)(void *data), void *data);

/* The display is lost, for the rest of the process. [any-thread] */
bool window_display_is_lost(void);

#endif
