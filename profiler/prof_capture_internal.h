/* Declarations shared by prof_capture.c (requests, and the thread that waits for their frames), prof_crash.c (the same
 * for crashes) and prof_capture_file.c (writing a capture). */
#ifndef STILB_PROF_CAPTURE_INTERNAL_H
#define STILB_PROF_CAPTURE_INTERNAL_H

#include "profiler/prof_capture.h"
#include "profiler/prof_internal.h"

#include <pthread.h>
#include <signal.h>

/* ---- prof_capture_file.c ----------------------------------------------------------------------------------------- */

/* Copies desc and its strings; prof_capture_file_forget frees them. 0 or -ENOMEM. [one-writer], while no capture is
 * written */
int prof_capture_file_set_up(const stilb_prof_capture_desc *desc);
void prof_capture_file_forget(void);

/* Takes a snapshot of the frame with number `frame`, of desc.frames_before frames before it and of `after` frames after
 * it, saves it and calls desc.done. frame_ns is the length of a slow frame, else 0. 0 or a negative errno. Called by
 * the capturing threads alone (asserted). */
int prof_capture_write(stilb_prof_cause cause, uint64_t frame, uint64_t frame_ns, uint32_t after);

/* The number of the current frame; 0 before the first mark. Safe in signal handlers. [any-thread] */
uint64_t prof_capture_frame(void);

/* ---- prof_capture.c ---------------------------------------------------------------------------------------------- */

/* True in the capturing threads. */
extern __thread bool prof_capture_is_thread __attribute__((tls_model("initial-exec")));

/* Creates a thread that calls run(NULL), with all signals blocked except those of its own crashes. 0 or a negative
 * errno. */
int prof_capture_thread_create(pthread_t *thread, void *(*run)(void *));

/* Sets the old handler of a signal again, unless the current one is not ours any more. */
void prof_signal_restore(int number, void (*ours)(void), const struct sigaction *old);

/* ---- prof_crash.c ------------------------------------------------------------------------------------------------ */

#define PROF_CRASH_SIGNALS 5
extern const int prof_crash_signals[PROF_CRASH_SIGNALS];

/* Installs the handlers of crashes and creates the thread that writes their capture. 0 or a negative errno.
 * [one-writer] */
int prof_crash_start(void);

/* Removes the handlers and ends the thread; waits for the capture of a crash in progress. Does nothing if not started.
 * [one-writer] */
void prof_crash_stop(void);

#endif
