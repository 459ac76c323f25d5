/*
 * prof_capture: writes the frames around a moment to a file while the program goes on running: after a slow frame, on
 * request (a key, a signal, another thread), or when the program crashes.
 *
 * What it is.   A thread of the lowest priority that takes a snapshot (prof_snapshot.h) and saves it (prof_trace.h).
 *               The rings still hold the frames before the moment; the thread waits for the frames after it. The thread
 *               that marks the frames copies nothing: once a frame it compares the frame's length with a limit, and
 *               after a slow frame it notes the frame's number and wakes the capturing thread.
 * Life cycle.   stilb_prof_capture_start -> frames; stilb_prof_capture_now at any time -> stilb_prof_capture_stop ->
 *               stilb_prof_shutdown.
 * Example.
 *                   stilb_prof_capture_desc desc = stilb_prof_capture_desc_default();
 *                   desc.path = "slow.json";
 *                   desc.spike = STILB_PROF_SPIKE_AUTO;
 *                   desc.signal = SIGUSR1;
 *                   int error = stilb_prof_capture_start(&desc);
 *                   ...                                    // frames
 *                   stilb_prof_capture_stop();
 *
 * Per frame.    Nothing besides stilb_prof_frame_mark (prof.h).
 * Rings.        A ring must hold all events of its thread from the first frame of the capture until the capture is
 *               copied, shortly after its last frame: see stilb_prof_ring_events_set. On a busy machine the copy may be
 *               late, because the thread has the lowest priority; if the frame itself is overwritten by then, the
 *               capture fails with -ENODATA.
 * Threads.      [any-thread] and [one-writer] as in prof.h.
 * Errors.       0 or a negative errno. Nothing here prints. The callback done is told of every capture, written or
 *               failed. A file that could not be written whole is not there, and the next capture tries again.
 */
#ifndef STILB_PROF_CAPTURE_H
#define STILB_PROF_CAPTURE_H

#include "prof_snapshot.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- captures ---------------------------------------------------------------------------------------------------- */

/* Which slow frames start a capture. */
typedef enum stilb_prof_spike {
	STILB_PROF_SPIKE_OFF,
	STILB_PROF_SPIKE_AUTO,  /* longer than twice the median of the last 100 frames, and longer than spike_ms */
	STILB_PROF_SPIKE_FIXED, /* longer than spike_ms */
} stilb_prof_spike;

/* Why a capture was made. */
typedef enum stilb_prof_cause {
	STILB_PROF_CAUSE_ASKED, /* stilb_prof_capture_now or the signal */
	STILB_PROF_CAUSE_SPIKE, /* a slow frame */
	STILB_PROF_CAUSE_CRASH, /* a signal such as SIGSEGV */
} stilb_prof_cause;

/* One capture, written or failed. */
typedef struct stilb_prof_captured {
	const char *path; /* of the file; valid during the call of done */
	/* 0: the file is complete; else a negative errno, and there is no file. -ENODATA: the frame was overwritten before
	 * it could be copied. */
	int error;
	stilb_prof_cause cause;
	uint64_t frame;       /* number of the slow frame, or of the one during which it was asked for or crashed */
	double frame_ms;      /* length of the slow frame in milliseconds; 0 for other causes */
	uint32_t frame_count; /* whole frames in the file */
} stilb_prof_captured;

/* The settings; start from stilb_prof_capture_desc_default. */
typedef struct stilb_prof_capture_desc {
	/* Path of the first file; the second gets "-2" before its extension, and so on. No existing file is replaced: its
	 * number is skipped. A pipe, a device and "-" (stdout) take all captures. The extension chooses the format, as in
	 * stilb_prof_trace_form. Not NULL, not empty; copied by stilb_prof_capture_start. */
	const char *path;
	const char *process_name; /* written into the file; NULL: the program's name. Copied */
	uint32_t frames_before;   /* whole frames before the moment; default 120 */
	uint32_t frames_after;    /* whole frames after it; default 30 */
	stilb_prof_spike spike;   /* default STILB_PROF_SPIKE_OFF */
	double spike_ms;          /* milliseconds, finite and not negative; default 1000 / 60 */
	uint32_t cool_down;       /* this many frames after a slow one start no capture; default 300 */
	uint32_t spike_files;     /* at most this many files of slow frames; default 16. What is asked for has no limit */
	int signal;               /* asks for a capture, for example SIGUSR1; default 0: none */
	/* Also capture the first SIGSEGV, SIGBUS, SIGILL, SIGFPE or SIGABRT, with the zones that are open. The crashing
	 * thread waits for the file for at most two seconds; then the signal takes its usual course. After an overflow of
	 * the stack this needs a sigaltstack. Default false. */
	bool crash;
	/* Called after each capture on the capturing thread, after a crash on a second one. It must not call
	 * stilb_prof_capture_start (asserted). NULL: not called. */
	void (*done)(void *user, const stilb_prof_captured *captured);
	void *user; /* the first argument of done */
} stilb_prof_capture_desc;

/* The defaults named above; path is NULL and must be set. [any-thread] */
stilb_prof_capture_desc stilb_prof_capture_desc_default(void);

/* Starts capturing. The handlers of desc->signal and of crashes are this library's until stop, which puts the old ones
 * back. Call it on the thread that marks the frames, or while no frame is marked; stilb_prof_capture_stop likewise.
 * Returns 0; -EINVAL: no path, a spike_ms that is negative or not finite, a spike out of range, or a signal that cannot
 * be caught or is one of a crash; -ENAMETOOLONG: the path; -EALREADY: already started; -EAGAIN or -ENOMEM: the thread
 * could not be created. After an error nothing has changed. [one-writer] */
int stilb_prof_capture_start(const stilb_prof_capture_desc *desc);

/* Asks for a capture around this moment. Asking again before that capture is written changes nothing. If no frame ends
 * for a second, the capture is written with the frames that there are. Returns 0, or -ESRCH: not started. Safe in
 * signal handlers. [any-thread] */
int stilb_prof_capture_now(void);

/* Writes captures that were asked for, with the frames that there are, and ends the thread. Waits for both. Does
 * nothing if not started. Returns 0, or -EDEADLK: called by done. [one-writer] */
int stilb_prof_capture_stop(void);

/* ---- frame times ------------------------------------------------------------------------------------------------- */

#define STILB_PROF_STATS_FRAMES 100

/* Lengths of the last whole frames, 100 at most; all 0 if there are none. Percentiles are by nearest rank. */
typedef struct stilb_prof_frame_stats {
	uint32_t count;                     /* frames in ms */
	uint64_t last;                      /* number of the newest of them, counted from 0 */
	double ms[STILB_PROF_STATS_FRAMES]; /* milliseconds, oldest first; the newest is at count - 1 */
	double mean_ms, p50_ms, p99_ms, max_ms;
	double limit_ms; /* max(2 x p50_ms, budget_ms): longer frames are spikes. Infinite with fewer than 20 frames */
	bool spike;      /* the newest frame is a spike. A program that runs smoothly has none */
} stilb_prof_frame_stats;

/* Computes stats from the frame marks, with or without captures. budget_ms >= 0 (asserted). Takes a few microseconds:
 * once a frame is fine. [any-thread] */
void stilb_prof_frame_stats_take(stilb_prof_frame_stats *stats, double budget_ms);

/* Computes stats from frames[0..count), consecutive frames of a snapshot; only the first 100 are used. Each ends after
 * it begins, and budget_ms >= 0 (asserted). frames may be NULL if count is 0. [any-thread] */
void stilb_prof_frame_stats_make(stilb_prof_frame_stats *stats, const stilb_prof_frame *frames, uint32_t count,
                                 double budget_ms);

#ifdef __cplusplus
}
#endif
#endif
