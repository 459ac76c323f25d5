/*
 * window_display: calls to GLFW that survive the end of the X server.
 *
 * When its connection breaks, Xlib ends the program by default: exit(1) in the middle of whatever call noticed it. Here that
 * call is left by longjmp instead, out of Xlib and GLFW, and from then on the connection is never used again: neither of the
 * two is in a state to be called, so the window and GLFW are not shut down but left as they are.
 * Without X11, or with a libX11 before 1.7, the calls are made as they are.
 * Threads: [main-thread], the one that called window_display_watch.
 */
#ifndef STILB_WINDOW_DISPLAY_H
#define STILB_WINDOW_DISPLAY_H

#include <stdbool.h>

/* After glfwInit, each time: watches over the connection that GLFW has opened. */
void window_display_watch(void);

/* Runs call(data), which may call GLFW. False if the display is gone: call was left half-way, or not begun at all. Not
 * nested: callbacks of GLFW within call need no other. */
bool window_display_call(void (*call)(void *data), void *data);

/* The display is gone, for the rest of the process. */
bool window_display_is_lost(void);

#endif
