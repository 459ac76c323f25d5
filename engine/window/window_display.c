#include "window/window_display.h"

#include "base/base.h"

#include <dlfcn.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdatomic.h>

/* Xlib's Display is only handed on; its header would bring its macros (None, Bool, Status, ...) along. */
typedef int x11_error_handler(void *connection);
typedef void x11_exit_handler(void *connection, void *data);

static struct {
	void *connection;            /* the Display; NULL: none is watched */
	x11_error_handler *previous; /* for other connections of the process; NULL: none */
	pthread_t owner;             /* who calls GLFW */
	jmp_buf back;                /* to the call that is being made */
	bool calling;                /* back is valid */
	/* A flag that nothing else hangs on, so relaxed everywhere. Written by the thread whose call broke, which may be one of
	 * the Vulkan driver's. */
	atomic_bool lost;
} display;

bool window_display_is_lost(void)
{
	return atomic_load_explicit(&display.lost, memory_order_relaxed); /* partner: display_on_exit */
}

/* In place of Xlib's own, which prints two lines: who lost the display says so. Other connections keep theirs. */
static int display_on_error(void *connection)
{
	return connection != display.connection && display.previous ? display.previous(connection) : 0;
}

/* In place of exit(1). Xlib has released its locks by now. Where no call of ours is left to return to, the driver gets its
 * error from Xlib. */
static void display_on_exit(void *connection, void *data)
{
	(void)connection, (void)data;
	atomic_store_explicit(&display.lost, true, memory_order_relaxed); /* partner: window_display_is_lost */
	if (display.calling && pthread_equal(pthread_self(), display.owner)) {
		display.calling = false;
		longjmp(display.back, 1);
	}
}

/* GLFW loads Xlib by itself, so this program is not linked with it: it is there if GLFW has it. */
void window_display_watch(void)
{
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
		display.owner = pthread_self();
		set_exit(connection, display_on_exit, NULL);
	}
	dlclose(x11); /* GLFW holds it */
}

bool window_display_call(void (*call)(void *data), void *data)
{
	STILB_ASSERT(!display.calling);
	if (window_display_is_lost())
		return false;
	display.calling = true;
	if (setjmp(display.back) == 0)
		call(data);
	display.calling = false;
	return !window_display_is_lost();
}
