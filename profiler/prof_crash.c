/*
 * Captures of crashes: the crashing thread asks another thread for the file and waits, since a signal handler must not
 * take locks or allocate, and its thread may hold any lock. That other thread is not the capturing thread, but one for
 * crashes alone, at normal priority: the capturing thread would come last on a busy machine, and may be writing another
 * file.
 */
#include "profiler/prof_capture_internal.h"

#include <assert.h>
#include <errno.h>
#include <poll.h>
#include <semaphore.h>
#include <unistd.h>

#define PROF_CRASH_NS UINT64_C(2000000000) /* a crashing thread waits for the file at most so long */

const int prof_crash_signals[PROF_CRASH_SIGNALS] = {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT};

/* The state of the only crash that is written, the first: when its thread has waited, the process ends, which would cut
 * off the file of a second one. */
enum prof_crash_state { PROF_CRASH_NONE, PROF_CRASH_ASKED, PROF_CRASH_WRITTEN };

static struct {
	pthread_t thread;
	int process; /* the process of the thread: its children by fork do not have the thread */
	sem_t wake;
	bool has_wake; /* initialised once and never destroyed: a signal handler may post it late */
	uint32_t running;
	uint32_t stop;
	uint32_t state; /* prof_crash_state */
	struct sigaction old[PROF_CRASH_SIGNALS];
} prof_crash;

/* ---- the crashing thread ----------------------------------------------------------------------------------------- */

/* True if a crash of the calling thread is to be written: crashes are watched for, and it is not a capturing thread. */
static bool prof_crash_is_seen(void)
{
	/* Acquire: pairs with prof_crash_start. */
	return __atomic_load_n(&prof_crash.running, __ATOMIC_ACQUIRE) != 0 && getpid() == prof_crash.process &&
	       !prof_capture_is_thread;
}

/* Asks for the file, unless another thread has asked, and waits for it. Calls only async-signal-safe functions. */
static void prof_crash_wait(void)
{
	uint64_t begin = stilb_prof_clock_monotonic();
	uint32_t none = PROF_CRASH_NONE;
	/* Release and acquire: pair with prof_crash_run. */
	if (__atomic_compare_exchange_n(&prof_crash.state, &none, PROF_CRASH_ASKED, false, __ATOMIC_RELEASE,
	                                __ATOMIC_RELAXED))
		sem_post(&prof_crash.wake);
	while (__atomic_load_n(&prof_crash.state, __ATOMIC_ACQUIRE) == PROF_CRASH_ASKED &&
	       stilb_prof_clock_monotonic() - begin < PROF_CRASH_NS)
		poll(NULL, 0, 1);
}

static void prof_crash_handler(int number, siginfo_t *info, void *context)
{
	int error = errno;
	(void)context;
	if (prof_crash_is_seen())
		prof_crash_wait();
	/* Restore the old handlers, so that the crash takes its usual course: a faulting instruction is executed again
	 * after the return, and a signal that was sent is sent again. */
	for (size_t i = 0; i < PROF_CRASH_SIGNALS; i++)
		if (prof_crash_signals[i] == number)
			sigaction(number, &prof_crash.old[i], NULL);
	if (info->si_code <= 0)
		raise(number);
	errno = error;
}

/* ---- the thread that writes -------------------------------------------------------------------------------------- */

static void *prof_crash_run(void *user)
{
	(void)user;
	prof_capture_is_thread = true;
	do {
		while (sem_wait(&prof_crash.wake) != 0 && errno == EINTR)
			;
		/* Acquire and release: pair with prof_crash_wait. */
		if (__atomic_load_n(&prof_crash.state, __ATOMIC_ACQUIRE) == PROF_CRASH_ASKED) {
			prof_capture_write(STILB_PROF_CAUSE_CRASH, prof_capture_frame(), 0, 0);
			__atomic_store_n(&prof_crash.state, PROF_CRASH_WRITTEN, __ATOMIC_RELEASE);
		}
	} while (__atomic_load_n(&prof_crash.stop, __ATOMIC_RELAXED) ==
	         0); /* pairs with prof_crash_stop; no other data depends on it */
	return NULL;
}

int prof_crash_start(void)
{
	/* Relaxed: only prof_crash_start and prof_crash_stop write it, and no two of their calls overlap. */
	assert(__atomic_load_n(&prof_crash.running, __ATOMIC_RELAXED) == 0 && "started once");
	struct sigaction crash = {.sa_sigaction = prof_crash_handler, .sa_flags = SA_SIGINFO | SA_ONSTACK};
	if (!prof_crash.has_wake)
		sem_init(&prof_crash.wake, 0, 0);
	prof_crash.has_wake = true;
	prof_crash.process = getpid();
	/* Relaxed: the thread that reads these starts later, and crash handlers load `running` first, with acquire. */
	__atomic_store_n(&prof_crash.stop, 0, __ATOMIC_RELAXED);
	__atomic_store_n(&prof_crash.state, PROF_CRASH_NONE, __ATOMIC_RELAXED);
	int error = prof_capture_thread_create(&prof_crash.thread, prof_crash_run);
	if (error != 0)
		return error;
	pthread_setname_np(prof_crash.thread, "prof-crash");
	for (size_t i = 0; i < PROF_CRASH_SIGNALS; i++)
		sigaction(prof_crash_signals[i], &crash, &prof_crash.old[i]);
	__atomic_store_n(&prof_crash.running, 1, __ATOMIC_RELEASE); /* pairs with prof_crash_is_seen */
	return 0;
}

/* If some thread is crashing at this moment, the file of its crash is written before the writing thread ends. */
void prof_crash_stop(void)
{
	if (__atomic_load_n(&prof_crash.running, __ATOMIC_RELAXED) == 0) /* written only here and by prof_crash_start */
		return;
	for (size_t i = 0; i < PROF_CRASH_SIGNALS; i++)
		prof_signal_restore(prof_crash_signals[i], (void (*)(void))prof_crash_handler, &prof_crash.old[i]);
	/* Relaxed: running and stop publish no other data. */
	__atomic_store_n(&prof_crash.running, 0, __ATOMIC_RELAXED);
	__atomic_store_n(&prof_crash.stop, 1, __ATOMIC_RELAXED);
	sem_post(&prof_crash.wake);
	pthread_join(prof_crash.thread, NULL);
}
