/* x11_server: an X server of a test's own, so that it can be killed. */
#ifndef X11_SERVER_H
#define X11_SERVER_H

#include <X11/Xlib.h>
#include <X11/Xutil.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

typedef struct x11_server {
	pid_t pid;
	char name[32]; /* ":7" */
} x11_server;

/* Starts Xvfb on a free display. False: it is not installed, or does not start. */
static inline bool x11_server_start(x11_server *server)
{
	int ready[2];
	char number[16], end[16];
	if (pipe(ready) != 0)
		return false;
	server->pid = fork();
	if (server->pid == 0) {
		prctl(PR_SET_PDEATHSIG, SIGKILL);
		close(ready[0]);
		snprintf(end, sizeof end, "%d", ready[1]);
		if (!freopen("/dev/null", "w", stderr))
			_exit(126);
		execlp("Xvfb", "Xvfb", "-displayfd", end, "-screen", "0", "800x600x24", "-nolisten", "tcp", (char *)NULL);
		_exit(127);
	}
	close(ready[1]);
	ssize_t length = 0, got;
	while (length < (ssize_t)sizeof number - 1 && (length == 0 || number[length - 1] != '\n') &&
	       (got = read(ready[0], number + length, 1)) > 0)
		length += got;
	close(ready[0]);
	if (length < 2 || number[length - 1] != '\n') {
		waitpid(server->pid, NULL, 0);
		return false;
	}
	number[length - 1] = '\0';
	snprintf(server->name, sizeof server->name, ":%s", number);
	return true;
}

/* Kills the server without warning its clients, as a crash would. */
static inline void x11_server_kill(x11_server *server)
{
	if (server->pid > 0) {
		kill(server->pid, SIGKILL);
		waitpid(server->pid, NULL, 0);
	}
	server->pid = 0;
}

/* Waits up to five minutes for a window to be seen whose title begins so; 0: there is none. */
static inline Window x11_server_await(Display *display, const char *title)
{
	Window found = 0;
	for (int i = 0; !found && i < 15000; i++, usleep(20000)) {
		Window root, parent, *children = NULL;
		unsigned count = 0;
		XQueryTree(display, DefaultRootWindow(display), &root, &parent, &children, &count);
		for (unsigned c = 0; c < count && !found; c++) {
			XWindowAttributes attributes;
			char *name = NULL;
			if (XFetchName(display, children[c], &name) && name && strncmp(name, title, strlen(title)) == 0 &&
			    XGetWindowAttributes(display, children[c], &attributes) && attributes.map_state == IsViewable)
				found = children[c];
			if (name)
				XFree(name);
		}
		if (children)
			XFree(children);
	}
	return found;
}

/* True if the window, which lies within the screen, does not have one colour alone. */
static inline bool x11_server_has_picture(Display *display, Window window)
{
	XWindowAttributes at;
	XGetWindowAttributes(display, window, &at);
	XImage *image = XGetImage(display, window, 0, 0, (unsigned)at.width, (unsigned)at.height, AllPlanes, ZPixmap);
	bool differs = false;
	for (int y = 0; image && y < at.height && !differs; y++)
		for (int x = 0; x < at.width && !differs; x++)
			differs = XGetPixel(image, x, y) != XGetPixel(image, 0, 0);
	if (image)
		XDestroyImage(image);
	return differs;
}

/* Waits up to ten minutes for a window with this beginning of its title, and for the first picture in it. Until then
 * the Vulkan driver may still be opening its connection, and Mesa 22.3 crashes if the server dies in that moment: it
 * reads XFixes' answer, which does not come. */
static inline bool x11_server_shows(const x11_server *server, const char *title)
{
	Display *display = XOpenDisplay(server->name);
	Window window = display ? x11_server_await(display, title) : 0;
	bool shown = false;
	for (int i = 0; window && !shown && i < 15000; i++, usleep(20000))
		shown = x11_server_has_picture(display, window);
	if (display)
		XCloseDisplay(display);
	return shown;
}

/* Sends the window a press and a release of the key, as if the user had typed it. */
static inline void x11_server_type(Display *display, Window window, KeySym key)
{
	XKeyEvent event = {.type = KeyPress,
	                   .display = display,
	                   .window = window,
	                   .root = DefaultRootWindow(display),
	                   .time = CurrentTime,
	                   .same_screen = True,
	                   .keycode = XKeysymToKeycode(display, key)};
	XSendEvent(display, window, True, KeyPressMask, (XEvent *)&event);
	event.type = KeyRelease;
	XSendEvent(display, window, True, KeyReleaseMask, (XEvent *)&event);
	XSync(display, False);
}

#endif
