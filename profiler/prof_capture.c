/*
 * Captures (files with the frames around a moment, prof_capture.h): requests for one, and the thread that writes them.
 *
 * Protocol. A request stores the number of its frame in a slot, asked or spike, and wakes the capturing thread, which
 * alone decides what is written when. To wait for the frames after, that thread stores the number of frames that must
 * have ended in awaited; the thread that marks frames compares with it once a frame. All wake-ups go through one
 * semaphore, since signal handlers may post it. A wake-up without a reason is harmless, so they are not counted.
 */
#include "profiler/prof_capture_internal.h"
#include "profiler/prof_frames.h"

#include <assert.h>
#include <errno.h>
#include <limits.h>
#include <math.h>
#include <semaphore.h>
#include <string.h>
#include <time.h>

#define PROF_STILL_NS UINT64_C(1000000000) /* after so long without a frame, stop waiting for more */
#define PROF_SUFFIX_MAX 16                 /* bytes added to a file's name: "-" and a number */

/* Used only by the thread that marks frames; initialised before prof_frame_hook_set. */
static struct {
	prof_frame_window window;
	uint64_t quiet; /* slow frames below this number start no capture: the cool-down after the last one */
} prof_marks;

static struct {
	/* Initialised before the thread starts, unchanged until it has ended. */
	stilb_prof_capture_desc desc;
	pthread_t thread;
	struct sigaction old_signal;
	sem_t wake;
	bool has_wake; /* initialised once and never destroyed: a signal handler may post it late */

	/* Shared between threads; orders are given at each use. asked and spike: frame number + 1; 0: no request. */
	uint32_t running;
	uint32_t stop;
	uint64_t asked;
	uint64_t spike;
	uint64_t spike_ns;     /* length of the slow frame */
	uint64_t spikes_left;  /* files that slow frames may still take */
	uint64_t whole;        /* frames that have ended so far */
	uint64_t awaited;      /* the capturing thread waits until as many have ended; UINT64_MAX: it does not wait */
	prof_exclusive caller; /* start or stop is running */
} prof_capture;

/* ---- asking for one ---------------------------------------------------------------------------------------------- */

/* Requests a capture around the frame with this number: writes it into *place, prof_capture.asked or .spike. If a
 * request is there already, this one is dropped: the earlier capture shows this moment too, or it has precedence. Safe
 * in signal handlers. */
static void prof_capture_ask(uint64_t *place, uint64_t frame)
{
	uint64_t none = 0;
	assert((place == &prof_capture.asked || place == &prof_capture.spike) && frame != UINT64_MAX);
	/* Release: pairs with the acquire load in prof_capture_next. */
	if (__atomic_compare_exchange_n(place, &none, frame + 1, false, __ATOMIC_RELEASE, __ATOMIC_RELAXED))
		sem_post(&prof_capture.wake);
}

int stilb_prof_capture_now(void)
{
	/* Acquire: pairs with stilb_prof_capture_start, which has set up the semaphore by then. */
	if (__atomic_load_n(&prof_capture.running, __ATOMIC_ACQUIRE) == 0)
		return -ESRCH;
	prof_capture_ask(&prof_capture.asked, prof_capture_frame());
	return 0;
}

static double prof_capture_limit_ms(void)
{
	switch (prof_capture.desc.spike) {
	case STILB_PROF_SPIKE_AUTO:
		return prof_frame_window_limit_ms(&prof_marks.window, prof_capture.desc.spike_ms);
	case STILB_PROF_SPIKE_FIXED:
		return prof_capture.desc.spike_ms;
	default:
		return (double)INFINITY;
	}
}

/* True if a slow frame may start a capture: no slow frame waits for its capture, and fewer than desc.spike_files files
 * of slow frames have been written. */
static bool prof_capture_has_room(void)
{
	/* Acquire: pairs with prof_capture_next, which has read spike_ns when it stores 0. Relaxed for spikes_left: no data
	 * depends on it. */
	return __atomic_load_n(&prof_capture.spike, __ATOMIC_ACQUIRE) == 0 &&
	       __atomic_load_n(&prof_capture.spikes_left, __ATOMIC_RELAXED) > 0;
}

/* Called by each stilb_prof_frame_mark. */
static void prof_capture_on_frame(uint64_t number, uint64_t duration_ns)
{
	prof_frame_window_add(&prof_marks.window, duration_ns);
	if (1e-6 * (double)duration_ns > prof_capture_limit_ms() && number >= prof_marks.quiet && prof_capture_has_room()) {
		prof_marks.quiet = number + 1 + prof_capture.desc.cool_down;
		__atomic_store_n(&prof_capture.spike_ns, duration_ns, __ATOMIC_RELAXED); /* published by the store to spike */
		prof_capture_ask(&prof_capture.spike, number);
	}
	/* Sequentially consistent: this stores whole and then loads awaited, prof_capture_await stores awaited and then
	 * loads whole. So at least one of the two threads sees the other's store, and no wake-up is lost. */
	__atomic_store_n(&prof_capture.whole, number + 1, __ATOMIC_SEQ_CST);
	if (number + 1 >= __atomic_load_n(&prof_capture.awaited, __ATOMIC_SEQ_CST)) {
		__atomic_store_n(&prof_capture.awaited, UINT64_MAX, __ATOMIC_RELAXED); /* waking once is enough */
		sem_post(&prof_capture.wake);
	}
}

/* ---- the signal -------------------------------------------------------------------------------------------------- */

static void prof_signal_on_ask(int number)
{
	int error = errno;
	(void)number;
	stilb_prof_capture_now();
	errno = error;
}

/* True if desc->signal is 0 or a signal that can be caught and is not one of a crash that is watched for. */
static bool prof_signal_is_free(const stilb_prof_capture_desc *desc)
{
	struct sigaction now;
	bool crashes = false;
	for (size_t i = 0; desc->crash && i < PROF_CRASH_SIGNALS; i++)
		crashes |= prof_crash_signals[i] == desc->signal;
	return desc->signal == 0 ||
	       (!crashes && desc->signal != SIGKILL && desc->signal != SIGSTOP && sigaction(desc->signal, NULL, &now) == 0);
}

void prof_signal_restore(int number, void (*ours)(void), const struct sigaction *old)
{
	assert(ours && old);
	struct sigaction now;
	if (sigaction(number, NULL, &now) == 0 && (void (*)(void))now.sa_handler == ours)
		sigaction(number, old, NULL);
}

/* ---- the thread -------------------------------------------------------------------------------------------------- */

__thread bool prof_capture_is_thread __attribute__((tls_model("initial-exec")));

int prof_capture_thread_create(pthread_t *thread, void *(*run)(void *))
{
	assert(thread && run);
	sigset_t all, old;
	sigfillset(&all);
	for (size_t i = 0; i < PROF_CRASH_SIGNALS; i++)
		sigdelset(&all, prof_crash_signals[i]);
	pthread_sigmask(SIG_SETMASK, &all, &old);
	int error = pthread_create(thread, NULL, run, NULL);
	pthread_sigmask(SIG_SETMASK, &old, NULL);
	return -error;
}

static bool prof_capture_stops(void)
{
	return __atomic_load_n(&prof_capture.stop, __ATOMIC_ACQUIRE) != 0; /* pairs with stilb_prof_capture_stop */
}

/* Waits until awaited frames have ended, no frame has ended for PROF_STILL_NS, or captures are to stop. */
static void prof_capture_await(uint64_t awaited)
{
	assert(prof_capture_is_thread && awaited > 0);
	/* Sequentially consistent: as said in prof_capture_on_frame. */
	__atomic_store_n(&prof_capture.awaited, awaited, __ATOMIC_SEQ_CST);
	uint64_t whole = __atomic_load_n(&prof_capture.whole, __ATOMIC_SEQ_CST);
	uint64_t moved = stilb_prof_clock_monotonic();
	while (whole < awaited && !prof_capture_stops() && stilb_prof_clock_monotonic() - moved < PROF_STILL_NS) {
		uint64_t until = moved + PROF_STILL_NS;
		struct timespec time = {(time_t)(until / 1000000000), (long)(until % 1000000000)};
		sem_clockwait(&prof_capture.wake, CLOCK_MONOTONIC, &time);
		uint64_t now = __atomic_load_n(&prof_capture.whole, __ATOMIC_SEQ_CST);
		if (now != whole)
			moved = stilb_prof_clock_monotonic();
		whole = now;
	}
	__atomic_store_n(&prof_capture.awaited, UINT64_MAX, __ATOMIC_RELAXED); /* a wake-up too many is harmless */
}

/* Writes the capture that is requested in *place; false: none is. The request stays there until its frames have ended,
 * so that further requests meanwhile ask for the same capture. */
static bool prof_capture_next(uint64_t *place, stilb_prof_cause cause)
{
	uint32_t after = prof_capture.desc.frames_after;
	uint64_t frame = __atomic_load_n(place, __ATOMIC_ACQUIRE) - 1; /* pairs with prof_capture_ask */
	if (frame == UINT64_MAX)
		return false;
	prof_capture_await(frame + after + 1);
	bool slow = cause == STILB_PROF_CAUSE_SPIKE;
	uint64_t frame_ns = slow ? __atomic_load_n(&prof_capture.spike_ns, __ATOMIC_RELAXED) : 0; /* acquired with frame */
	__atomic_store_n(place, 0, __ATOMIC_RELEASE); /* pairs with prof_capture_has_room */
	if (prof_capture_write(cause, frame, frame_ns, after) == 0 && slow)
		__atomic_sub_fetch(&prof_capture.spikes_left, 1, __ATOMIC_RELAXED); /* no data depends on it */
	return true;
}

static void *prof_capture_run(void *user)
{
	(void)user;
	prof_capture_is_thread = true;
	prof_background_begin();
	pthread_setname_np(pthread_self(), "prof-capture");
	while (true) {
		bool stops = prof_capture_stops(); /* read first: requests made before the stop are still seen below */
		bool wrote = prof_capture_next(&prof_capture.asked, STILB_PROF_CAUSE_ASKED);
		wrote |= prof_capture_next(&prof_capture.spike, STILB_PROF_CAUSE_SPIKE);
		if (wrote)
			continue;
		if (stops)
			return NULL;
		while (sem_wait(&prof_capture.wake) != 0 && errno == EINTR)
			;
	}
}

/* ---- start and stop ---------------------------------------------------------------------------------------------- */

stilb_prof_capture_desc stilb_prof_capture_desc_default(void)
{
	return (stilb_prof_capture_desc){
		.frames_before = 120,
		.frames_after = 30,
		.spike = STILB_PROF_SPIKE_OFF,
		.spike_ms = 1000.0 / 60.0,
		.cool_down = 300,
		.spike_files = 16,
	};
}

static bool prof_capture_is_sound(const stilb_prof_capture_desc *desc)
{
	bool length = desc->spike == STILB_PROF_SPIKE_OFF || (desc->spike_ms >= 0 && desc->spike_ms < (double)INFINITY);
	return desc->path && desc->path[0] != 0 && desc->spike <= STILB_PROF_SPIKE_FIXED && length &&
	       prof_signal_is_free(desc);
}

/* Initialises everything but the threads, the signal handlers and the hook. 0 or -ENOMEM. */
static int prof_capture_set_up(const stilb_prof_capture_desc *desc)
{
	/* Relaxed: only start and stop write it, and no two of their calls overlap (prof_capture.caller). */
	assert(__atomic_load_n(&prof_capture.running, __ATOMIC_RELAXED) == 0);
	int error = prof_capture_file_set_up(desc);
	if (error != 0)
		return error;
	if (!prof_capture.has_wake)
		sem_init(&prof_capture.wake, 0, 0);
	prof_capture.has_wake = true;
	prof_capture.desc = *desc;
	prof_capture.desc.path = prof_capture.desc.process_name = NULL; /* prof_capture_file.c has copies */
	memset(&prof_marks, 0, sizeof prof_marks);
	/* Relaxed: the thread is created later, and other threads check running or the hook first. */
	__atomic_store_n(&prof_capture.stop, 0, __ATOMIC_RELAXED);
	__atomic_store_n(&prof_capture.asked, 0, __ATOMIC_RELAXED);
	__atomic_store_n(&prof_capture.spike, 0, __ATOMIC_RELAXED);
	__atomic_store_n(&prof_capture.spikes_left, desc->spike_files, __ATOMIC_RELAXED);
	__atomic_store_n(&prof_capture.whole, 0, __ATOMIC_RELAXED);
	__atomic_store_n(&prof_capture.awaited, UINT64_MAX, __ATOMIC_RELAXED);
	return 0;
}

static void prof_capture_end(void)
{
	assert(!prof_capture_is_thread && "a thread does not wait for itself");
	__atomic_store_n(&prof_capture.stop, 1, __ATOMIC_RELEASE); /* pairs with prof_capture_stops */
	sem_post(&prof_capture.wake);
	pthread_join(prof_capture.thread, NULL);
	prof_capture_file_forget();
}

/* Does the work of stilb_prof_capture_start. Returns 0 or a negative errno, after which nothing has changed. */
static int prof_capture_begin(const stilb_prof_capture_desc *desc)
{
	if (__atomic_load_n(&prof_capture.running, __ATOMIC_RELAXED) != 0) /* only start and stop write it, one at a time */
		return -EALREADY;
	if (!prof_capture_is_sound(desc))
		return -EINVAL;
	if (strlen(desc->path) + PROF_SUFFIX_MAX >= PATH_MAX)
		return -ENAMETOOLONG;
	int error = prof_capture_set_up(desc);
	if (error != 0)
		return error;
	error = prof_capture_thread_create(&prof_capture.thread, prof_capture_run);
	if (error != 0) {
		prof_capture_file_forget();
		return error;
	}
	error = desc->crash ? prof_crash_start() : 0;
	if (error != 0) {
		prof_capture_end();
		return error;
	}
	if (desc->signal != 0)
		sigaction(desc->signal, &(struct sigaction){.sa_handler = prof_signal_on_ask, .sa_flags = SA_RESTART},
		          &prof_capture.old_signal);
	/* Release: pairs with the handlers and stilb_prof_capture_now. */
	__atomic_store_n(&prof_capture.running, 1, __ATOMIC_RELEASE);
	prof_frame_hook_set(prof_capture_on_frame);
	return 0;
}

int stilb_prof_capture_start(const stilb_prof_capture_desc *desc)
{
	assert(desc && !prof_capture_is_thread && "not from done");
	prof_exclusive_begin(&prof_capture.caller);
	int error = prof_capture_begin(desc);
	prof_exclusive_end(&prof_capture.caller);
	return error;
}

int stilb_prof_capture_stop(void)
{
	/* Relaxed: only start and stop write it, and by the rules of prof_capture.h no two of their calls overlap. */
	if (__atomic_load_n(&prof_capture.running, __ATOMIC_RELAXED) == 0)
		return 0;
	if (prof_capture_is_thread)
		return -EDEADLK;
	prof_exclusive_begin(&prof_capture.caller);
	prof_frame_hook_set(NULL);
	if (prof_capture.desc.signal != 0)
		prof_signal_restore(prof_capture.desc.signal, (void (*)(void))prof_signal_on_ask, &prof_capture.old_signal);
	__atomic_store_n(&prof_capture.running, 0, __ATOMIC_RELAXED); /* publishes no other data */
	prof_crash_stop();
	prof_capture_end();
	prof_exclusive_end(&prof_capture.caller);
	return 0;
}
