/*
 * job_park: how threads sleep without missing what they sleep for.
 *
 * A parker is one thread's bed: a word that holds a token or not. Waking means leaving the token, sleeping means
 * waiting for it, so a wake-up that comes before the sleep is kept, not lost.
 *
 * The idle list says which threads are in bed or on their way, and what work each would get up for. Who has new work
 * wakes one of them, and takes it off the list while doing so: two submits never wake the same thread.
 *
 * Why no wake-up is lost. A thread goes to sleep in this order:    (1) enter the list, (2) look for work again, (3) sleep.
 * A thread that has work goes in this order:                       (a) publish the work, (b) read the list's count.
 * (1) and (b) are both read-modify-writes of the one word `count`, hence one comes first, and each later one sees and
 * synchronises with each earlier one.  If (1) came first, (b) sees the sleeper and gives it a token. If (b) came first,
 * then (a) happened before (2), which finds the work. There is no third case, on any memory model of C11.
 * If the sleeper seen in (1) has been taken off by somebody else meanwhile, it is awake and goes through (1) and (2) again
 * before it sleeps again.
 *
 * A parker's word also serves stilb_job_wait: the thread that finishes a group's last job leaves a token for the thread
 * that waits. That token can come late, when the waiter has seen the group finished by itself; then one later sleep
 * ends at once and the thread looks for work once in vain. Every sleeper looks again in a loop, so that is all.
 */
#ifndef STILB_JOB_PARK_H
#define STILB_JOB_PARK_H

#include "jobs/job.h"
#include "jobs/job_lock.h"

#include <stdalign.h>

typedef struct job_parker {
	_Atomic uint32_t state;
} job_parker;

/* Sleeps until the token is there and takes it. Everything done before the token was left is visible. [its thread] */
void job_parker_sleep(job_parker *parker);

/* Takes the token if it is there, never sleeps. [its thread] */
void job_parker_clear(job_parker *parker);

/* Leaves the token and wakes the thread if it sleeps. Two tokens are one. [any-thread] */
void job_parker_wake(job_parker *parker);

/* What there is to do: a job, or a slice of a loop with this nesting level (1, 2, ...). */
#define JOB_WORK_JOB 0u

/* A thread on the list takes loops nested deeper than level, and jobs if jobs is set (see job_internal.h). */
typedef struct job_idler {
	job_parker *parker;
	uint32_t level;
	bool jobs;
} job_idler;

typedef struct job_idle_list {
	alignas(JOB_LINE) _Atomic uint32_t count; /* of idlers; changed under the lock, and always by read-modify-writes */
	alignas(JOB_LINE) job_lock lock;
	job_idler idler[STILB_JOB_MAX_WORKERS + 1]; /* a stack: who came last has the warmest caches and goes first */
} job_idle_list;

void job_idle_init(job_idle_list *list);

/* Step (1). A thread is on the list at most once. [any-thread] */
void job_idle_enter(job_idle_list *list, job_idler idler);

/* After the sleep, or instead of it. True if somebody took this thread off the list to give it work: then it takes
 * work, or passes the wake-up on. Clears the parker. [any-thread] */
bool job_idle_leave(job_idle_list *list, job_parker *parker);

/* Step (b), after the work was published: takes one idler that would do such work off the list and wakes it; false if
 * there is none. A wake-up costs the caller some 7 us, an empty list one read-modify-write. [any-thread] */
bool job_idle_wake(job_idle_list *list, uint32_t work);

/* A guess, relaxed: is anybody on the list? [any-thread] */
bool job_idle_any(const job_idle_list *list);

#endif
