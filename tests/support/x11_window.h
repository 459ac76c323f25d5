/* For tests that play the user: the window, as another connection to the display sees it. */
#ifndef X11_WINDOW_H
#define X11_WINDOW_H

#include <X11/Xlib.h>
#include <X11/Xutil.h>
#include <string.h>

/* The top-level window of this title; 0: there is none, or not yet. */
static inline Window x11_window_find(Display *display, const char *title)
{
	Window root, parent, *children = NULL, found = 0;
	unsigned count = 0;
	XQueryTree(display, DefaultRootWindow(display), &root, &parent, &children, &count);
	for (unsigned i = 0; i < count && !found; i++) {
		char *name = NULL;
		if (XFetchName(display, children[i], &name) && name && strcmp(name, title) == 0)
			found = children[i];
		if (name)
			XFree(name);
	}
	if (children)
		XFree(children);
	return found;
}

#endif
