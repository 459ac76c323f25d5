#include "window/window_display_internal.h"

#include "base/base_contract.h"

#include <dlfcn.h>
#include <setjmp.h>
#include <stdatomic.h>

/* Xlib's header is not included, because its macros (None, Bool, Status, ...) clash with other names; a Display is only
 * passed on here. */
typedef int x11_error_handler(void *connection);
typedef void x11_exit_handler(void *connection, void *data);

static struct {
	void *connection;            /* the Display; NULL: none is watched */
	x11_error_handler *previous; /* handles other connections of the process; NULL: there is none */
	stilb_owner owner;           /* the thread that calls GLFW */
	jmp_buf back;                /* into window_display_call, */
	bool calling;                /* while this is true */
	/* Relaxed everywhere, because no other data depends on it. Written by the thread whose call failed, which may be one of
	 * the Vulkan driver's. */
	atomic_bool lost;
} display;

bool window_display_is_lost(void)
{
	return atomic_load_explicit(&display.lost, memory_order_relaxed); /* partner: display_on_exit */
}

/* Replaces Xlib's handler, which prints two lines, for our connection: the caller of the window reports the loss. */
static int display_on_error(void *connection)
{
	return connection != display.connection && display.previous ? display.previous(connection) : 0;
}

/* Replaces exit(1). Xlib has released its locks before this. On another thread, or outside of window_display_call, it
 * returns, and Xlib gives its caller (the Vulkan driver) an error. */
static void display_on_exit(void *connection, void *data)
{
	(void)connection, (void)data;
	atomic_store_explicit(&display.lost, true, memory_order_relaxed); /* partner: window_display_is_lost */
	if (stilb_owner_is_me(&display.owner) && display.calling) {
		display.calling = false;
		longjmp(display.back, 1);
	}
}

/* Xlib is looked up instead of linked, because GLFW loads it at run time and may run without it. */
void window_display_watch(void)
{
	STILB_ASSERT(!display.calling && "GLFW is not being called");
	void *(*connection_of_glfw)(void) = (void *(*)(void))dlsym(RTLD_DEFAULT, "glfwGetX11Display");
	void *x11 = dlopen("libX11.so.6", RTLD_NOLOAD | RTLD_LAZY);
	if (!connection_of_glfw || !x11)
		return;
	x11_error_handler *(*set_error)(x11_error_handler *) =
		(x11_error_handler * (*)(x11_error_handler *)) dlsym(x11, "XSetIOErrorHandler");
	void (*set_exit)(void *, x11_exit_handler *, void *) =
		(void (*)(void *, x11_exit_handler *, void *))dlsym(x11, "XSetIOErrorExitHandler");
	void *connection = connection_of_glfw();
	if (set_error && set_exit && connection) {
		x11_error_handler *previous = set_error(display_on_error);
		if (previous != display_on_error)
			display.previous = previous;
		display.connection = connection;
		stilb_owner_take(&display.owner);
		set_exit(connection, display_on_exit, NULL);
	}
	dlclose(x11); /* GLFW keeps it loaded */
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
