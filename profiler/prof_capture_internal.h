/* What the files of captures share: prof_capture.c (what starts one, and the thread that waits for its frames),
 * prof_crash.c (the same for crashes) and prof_capture_file.c (writing it). */
#ifndef STILB_PROF_CAPTURE_INTERNAL_H
#define STILB_PROF_CAPTURE_INTERNAL_H

#include "profiler/prof_capture.h"
#include "profiler/prof_internal.h"

#include <pthread.h>
#include <signal.h>

/* ---- prof_capture_file.c ----------------------------------------------------------------------------------------- */

/* Copies what files need of desc. 0 or -ENOMEM. [one-writer], when nobody writes */
int prof_capture_file_set_up(const stilb_prof_capture_desc *desc);
void prof_capture_file_forget(void);

/* Takes a snapshot of the frames around this one, after of them after it, saves it and tells done. 0 or a negative
 * errno. [any-thread] */
int prof_capture_write(stilb_prof_cause cause, uint64_t frame, uint64_t frame_ns, uint32_t after);

/* The number of the frame that is under way. Safe in signal handlers. [any-thread] */
uint64_t prof_capture_frame(void);

/* ---- prof_capture.c ---------------------------------------------------------------------------------------------- */

/* Whether this is one of the threads below. */
extern __thread bool prof_capture_is_thread __attribute__((tls_model("initial-exec")));

/* A thread that runs run, with all signals blocked but those of a crash of its own. 0 or a negative errno. */
int prof_capture_thread_create(pthread_t *thread, void *(*run)(void *));

/* Puts the old handler back, unless somebody has set another meanwhile. */
void prof_signal_restore(int number, void (*ours)(void), const struct sigaction *old);

/* ---- prof_crash.c ------------------------------------------------------------------------------------------------ */

#define PROF_CRASH_SIGNALS 5
extern const int prof_crash_signals[PROF_CRASH_SIGNALS];

/* From here on crashes are written. 0 or a negative errno. [one-writer] */
int prof_crash_start(void);

/* Without a start it does nothing. [one-writer] */
void prof_crash_stop(void);

#endif
