#include "window/window_display_internal.h"

#include "base/base_contract.h"

#include <dlfcn.h>
#include <setjmp.h>
#include <stdatomic.h>

/* Xlib's header is not included, because its macros (None, Bool, Status, ...) clash with other names; a Display is only
 * passed on here. */
typedef int x11_error_handler(void *connection);
typedef void x11_exit_handler(void *connection, void *data);
typedef x11_error_handler *x11_set_error(x11_error_handler *handler);
typedef void x11_set_exit(void *connection, x11_exit_handler *handler, void *data);

static struct {
	void *x11;                   /* libX11, never closed; NULL: there is none */
	void *connection;            /* GLFW's connection, a Display *; NULL: GLFW is opening it, or has none */
	x11_error_handler *previous; /* handles other connections of the process; NULL: there is none */
	stilb_owner owner;           /* the thread that calls GLFW */
	jmp_buf back;                /* where display_on_error jumps to, in window_display_call; set while `calling` */
	bool calling;                /* window_display_call runs a call to GLFW */
	/* The connection broke. Relaxed everywhere, because no other data is published with it. Written by the thread whose
	 * call failed, which may be one of the Vulkan driver's. */
	atomic_bool lost;
} display;

bool window_display_is_lost(void)
{
	return atomic_load_explicit(&display.lost, memory_order_relaxed); /* partner: display_on_error */
}

/* Replaces Xlib's handler of broken connections, which prints two lines, for GLFW's connection; the program learns of
 * the loss from stilb_window_state. Xlib has released its locks before it calls this. Within window_display_call the
 * handler jumps back there. On another thread, or outside of that call, it returns, display_on_exit returns too, and
 * Xlib gives its caller (the Vulkan driver) an error. While GLFW opens its connection display.connection is not known
 * yet: then a connection that breaks within window_display_call is taken for GLFW's. */
static int display_on_error(void *connection)
{
	bool calling = stilb_owner_is_me(&display.owner) && display.calling;
	bool ours = display.connection ? connection == display.connection : calling;
	if (!ours)
		return display.previous ? display.previous(connection) : 0;
	atomic_store_explicit(&display.lost, true, memory_order_relaxed); /* partner: window_display_is_lost */
	if (calling) {
		display.calling = false;
		longjmp(display.back, 1);
	}
	return 0;
}

/* Xlib calls this instead of exit(1) after display_on_error has returned. */
static void display_on_exit(void *connection, void *data)
{
	(void)connection, (void)data;
}

/* Xlib is looked up instead of linked, because GLFW loads it at run time and may run without it. */
void window_display_begin(void)
{
	STILB_ASSERT(!display.calling && "GLFW is not being called");
	if (!display.x11)
		display.x11 = dlopen("libX11.so.6", RTLD_LAZY | RTLD_LOCAL);
	x11_set_error *set_error = display.x11 ? (x11_set_error *)dlsym(display.x11, "XSetIOErrorHandler") : NULL;
	x11_error_handler *previous = set_error ? set_error(display_on_error) : NULL;
	if (previous != display_on_error)
		display.previous = previous;
	display.connection = NULL;
	stilb_owner_take(&display.owner);
}

void window_display_opened(void)
{
	STILB_ASSERT_OWNER(display.owner);
	void *(*connection_of_glfw)(void) = (void *(*)(void))dlsym(RTLD_DEFAULT, "glfwGetX11Display");
	x11_set_exit *set_exit = display.x11 ? (x11_set_exit *)dlsym(display.x11, "XSetIOErrorExitHandler") : NULL;
	display.connection = connection_of_glfw ? connection_of_glfw() : NULL;
	if (display.connection && set_exit)
		set_exit(display.connection, display_on_exit, NULL);
}

bool window_display_call(void (*call)(void *data), void *data)
{
	STILB_ASSERT(call);
	STILB_ASSERT_OWNER(display.owner);
	STILB_ASSERT(!display.calling && "calls are not nested");
	if (window_display_is_lost())
		return false;
	display.calling = true;
	if (setjmp(display.back) == 0)
		call(data);
	display.calling = false;
	return !window_display_is_lost();
}
