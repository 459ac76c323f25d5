/*
 * prof_capture: writes the frames around a moment to a file while the program runs on: when a frame was slow, when
 * asked (a key, a signal, another thread), or when the program crashes.
 *
 * What it is.   A thread of the lowest priority that takes a snapshot (prof_snapshot.h) and saves it (prof_trace.h).
 *               The rings hold what came before; it waits for the frames after. The thread that marks the frames copies
 *               nothing: it compares one number a frame, and when a frame was slow it notes which and wakes the other.
 * Life cycle.   stilb_prof_capture_start -> frames, stilb_prof_capture_now at any time -> stilb_prof_capture_stop
 *               before stilb_prof_shutdown.
 * Rings.        What is to be written must still be held when the frames after have passed: stilb_prof_ring_events_set.
 * Errors.       0 or a negative errno. Nothing here prints; done is told of every file, whether it was written or not.
 *               A file that could not be written whole is not there, and the next capture tries anew.
 */
#ifndef STILB_PROF_CAPTURE_H
#define STILB_PROF_CAPTURE_H

#include "prof_snapshot.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- captures ---------------------------------------------------------------------------------------------------- */

/* Which frames are written unasked. */
typedef enum stilb_prof_spike {
	STILB_PROF_SPIKE_OFF,
	STILB_PROF_SPIKE_AUTO,  /* slower than twice the median of the last 100 frames, and than spike_ms */
	STILB_PROF_SPIKE_FIXED, /* slower than spike_ms */
} stilb_prof_spike;

typedef enum stilb_prof_cause {
	STILB_PROF_CAUSE_ASKED, /* stilb_prof_capture_now or the signal */
	STILB_PROF_CAUSE_SPIKE,
	STILB_PROF_CAUSE_CRASH,
} stilb_prof_cause;

/* One capture, done or failed. */
typedef struct stilb_prof_captured {
	const char *path; /* the file; valid during the call */
	int error; /* 0: the whole file is there; else a negative errno, and it is not. -ENODATA: the rings went round */
	stilb_prof_cause cause;
	uint64_t frame;       /* the one that was slow, or in which it was asked for, or in which the program crashed */
	double frame_ms;      /* how long the slow frame took; 0 for other causes */
	uint32_t frame_count; /* whole frames in the file */
} stilb_prof_captured;

typedef struct stilb_prof_capture_desc {
	/* Of the first file; the second gets "-2" before the extension, and so on. No file that is there is replaced: its
	 * number is left out. A pipe, a device and "-" (stdout) are written again and again. The extension chooses the
	 * form: stilb_prof_trace_form. */
	const char *path;
	const char *process_name; /* in the file; NULL: the program's */
	uint32_t frames_before;   /* default 120 */
	uint32_t frames_after;    /* default 30 */
	stilb_prof_spike spike;   /* default off */
	double spike_ms;          /* default 1000 / 60 */
	uint32_t cool_down;       /* frames after a slow one that start no other capture; default 300 */
	uint32_t spike_files;     /* for slow frames at most; default 16. What is asked for is always written */
	int signal;               /* asks for a capture, SIGUSR1 for example; default 0: none */
	/* Also on the first SIGSEGV, SIGBUS, SIGILL, SIGFPE or SIGABRT, with the zones that are open. The thread that
	 * crashes waits for the file, two seconds at most; then what would have happened does. After an overflow of the
	 * stack this needs a sigaltstack. Default false. */
	bool crash;
	/* Called on a thread of the capture's own, for a crash on another one; NULL: nobody asks. */
	void (*done)(void *user, const stilb_prof_captured *captured);
	void *user;
} stilb_prof_capture_desc;

stilb_prof_capture_desc stilb_prof_capture_desc_default(void);

/* The strings are copied. The signal handlers are this library's until stop, which puts the old ones back. The caller
 * is the thread that marks the frames, or no frame is marked meanwhile; the same for stop.
 * -EINVAL: no path, a spike_ms that is no length of time, a signal that cannot be caught or is one of a crash;
 * -ENAMETOOLONG; -EALREADY: started; -EAGAIN or -ENOMEM: no thread. [one-writer] */
int stilb_prof_capture_start(const stilb_prof_capture_desc *desc);

/* Asks for a capture around this moment. Asking again before it is being written asks for nothing more. When no
 * frame ends for a second it is written with those that there are. -ESRCH: not started. Safe in signal handlers.
 * [any-thread] */
int stilb_prof_capture_now(void);

/* Writes what has been asked for with the frames that there are, then ends the thread. Without a start it does nothing;
 * -EDEADLK: called by done. [one-writer] */
int stilb_prof_capture_stop(void);

/* ---- frame times ------------------------------------------------------------------------------------------------- */

#define STILB_PROF_STATS_FRAMES 100

/* The last whole frames, 100 at most; all 0 when there are none. */
typedef struct stilb_prof_frame_stats {
	uint32_t count;
	uint64_t last;                      /* number of the last of them, counted from 0 */
	double ms[STILB_PROF_STATS_FRAMES]; /* the last one is at count - 1 */
	double mean_ms, p50_ms, p99_ms, max_ms;
	double limit_ms; /* max(2 x p50_ms, budget_ms): what is slower is a spike. Infinite with fewer than 20 frames */
	bool spike;      /* the last frame is one; a healthy program has none */
} stilb_prof_frame_stats;

/* Independent of captures. It costs some microseconds: once a frame is fine. [any-thread] */
void stilb_prof_frame_stats_take(stilb_prof_frame_stats *stats, double budget_ms);

/* The same of the first count of these frames, at most 100, which follow each other. [any-thread] */
void stilb_prof_frame_stats_make(stilb_prof_frame_stats *stats, const stilb_prof_frame *frames, uint32_t count,
                                 double budget_ms);

#ifdef __cplusplus
}
#endif
#endif
