/*
 * job_park: how threads sleep without missing what they sleep for. An eventcount: prepare, look again, commit.
 *
 * The idle list says which threads sleep or are about to, and what each would get up for: a worker without work for anything,
 * a thread that waits for a group or a loop only for what belongs to it. Each sleeps on a futex word of its own, its
 * parker, which holds a token or not. Waking means leaving the token, so a wake-up that comes before the sleep is kept.
 * One word for each thread, not one for all, because the waker then chooses: who may do the work, of those who came last,
 * whose caches are warmest; the kernel would take any.
 *
 * Spinners are workers that look for work before they sleep, or that have just been woken for some. Outside a phase there
 * is at most one. While there is one, new work wakes nobody: the spinner will find it, and wakes the next before it
 * starts on what it found. So a burst of submits costs one system call, and the workers wake one another as long as
 * there is something left to do.
 *
 * `state` counts idlers and spinners in one word. Why no wake-up is lost:
 * A thread goes to sleep in this order:      (1) count itself in as an idler, and out as a spinner,
 *                                            (2) look for work again, (3) sleep.
 * A thread that has work goes in this order: (a) publish the work, (b) read the word.
 * All four are seq_cst, so there is one order of them. If (1) came before (b), then (b) sees an idler, and either
 * wakes one or sees a spinner too. If (b) came before (1), then (a) came before (2), which finds the work. A spinner
 * seen in (b) has not yet done its own (1), or has not yet counted itself out because it found other work, after which it
 * looks for more: either way it looks after (a). Publishing by a seq_cst read-modify-write on the work's own word (a deque, an
 * inbox) leaves (b) a load; where publishing is weaker (the shared queues), (b) is a read-modify-write of the word that
 * changes nothing, and orders itself against (1), being one, too.
 */
#ifndef STILB_JOB_PARK_H
#define STILB_JOB_PARK_H

#include "jobs/job.h"
#include "jobs/job_lock.h"

#include <stdalign.h>

typedef struct job_parker {
	_Atomic uint32_t state;
	/* Guarded by the list's lock. */
	bool rescue;    /* woken to do anything there is */
	bool bound;     /* its thread is bound to one CPU */
	uint32_t cpu;   /* that one */
	int32_t thread; /* kernel's number of it */
} job_parker;

/* Sleeps until the token is there and takes it. Everything done before the token was left is visible. [its thread] */
void job_parker_sleep(job_parker *parker);

/* Takes the token if it is there, never sleeps. [its thread] */
void job_parker_clear(job_parker *parker);

/* Leaves the token and wakes the thread if it sleeps. Two tokens are one. [any-thread] */
void job_parker_wake(job_parker *parker);

/* What a thread may do, and what work there is (see job_internal.h). */
typedef struct job_scope {
	bool all;       /* anything */
	bool jobs;      /* jobs as well as loops */
	bool high;      /* jobs of high priority */
	uintptr_t root; /* else what descends from this root */
	uint32_t level; /* and is nested deeper than this */
} job_scope;

typedef enum job_work_kind { JOB_WORK_OWN, JOB_WORK_JOB, JOB_WORK_HIGH, JOB_WORK_LOOP, JOB_WORK_SHARED } job_work_kind;

typedef struct job_work {
	job_work_kind kind;
	uintptr_t root; /* of a job in a deque and of a loop */
	uint32_t level;
} job_work;

typedef struct job_idler {
	job_parker *parker;
	job_scope scope;
	bool worker; /* not the owner */
} job_idler;

#define JOB_IDLE_SPINNER (1u << 16) /* in the state word; idlers are what is below */

typedef struct job_idle_list {
	alignas(JOB_LINE) _Atomic uint32_t state; /* idlers, and spinners << 16; idlers change under the lock */
	alignas(JOB_LINE) job_lock lock;
	bool spare;         /* there is a CPU that no worker is bound to */
	uint32_t spare_cpu; /* that one */
	uint32_t workers;   /* of the pool */
	uint32_t waiting; /* of them, those on the list that wait for something: when all do, one of them may do anything */
	job_idler idler[STILB_JOB_MAX_WORKERS + 1]; /* a stack: who came last has the warmest caches and goes first */
} job_idle_list;

void job_idle_init(job_idle_list *list, uint32_t workers);

/* Says which CPU the thread of parker, the calling one, is bound to. */
void job_idle_bound(job_idle_list *list, job_parker *parker, uint32_t cpu);

/* Counts this worker as a spinner unless there are limit already. [any-thread] */
bool job_idle_spin_start(job_idle_list *list, uint32_t limit);

/* No spinner any more, for it has found work. It looks for more work afterwards and wakes somebody for that. [any-thread] */
void job_idle_spin_stop(job_idle_list *list);

/* Step (1). True if now every worker waits: then this thread does whatever there is instead of sleeping. A thread is on
 * the list at most once. [any-thread] */
bool job_idle_enter(job_idle_list *list, const job_idler *idler, bool spinning);

typedef enum job_idle_fate {
	JOB_IDLE_UNMOVED, /* was still on the list: nobody had anything for this thread */
	JOB_IDLE_CHOSEN, /* somebody had: it takes work or sees to it that another does; one that may do all is a spinner now */
	JOB_IDLE_RESCUE /* chosen to do anything there is, as every worker waited */
} job_idle_fate;

/* Takes one worker off the list that may do anything and wakes it as a spinner, unless there are limit already. [any-thread] */
bool job_idle_wake_spinner(job_idle_list *list, uint32_t limit);

/* After the sleep, or instead of it. [any-thread] */
job_idle_fate job_idle_leave(job_idle_list *list, job_parker *parker);

static inline bool job_idle_state_wanted(uint32_t state)
{
	return (state & (JOB_IDLE_SPINNER - 1)) > 0 && state < JOB_IDLE_SPINNER;
}

/* Step (b) for work published by a seq_cst read-modify-write: is there an idler, and no spinner? [any-thread] */
static inline bool job_idle_wanted(const job_idle_list *list)
{
	return job_idle_state_wanted(atomic_load_explicit(&list->state, memory_order_seq_cst)); /* partner of (1) */
}

/* Step (b) for other work. A read-modify-write. [any-thread] */
static inline bool job_idle_wanted_strict(job_idle_list *list)
{
	return job_idle_state_wanted(atomic_fetch_add_explicit(&list->state, 0, memory_order_seq_cst)); /* partner of (1) */
}

/* A guess, relaxed, of job_idle_wanted. [any-thread] */
static inline bool job_idle_maybe_wanted(const job_idle_list *list)
{
	return job_idle_state_wanted(atomic_load_explicit(&list->state, memory_order_relaxed));
}

/* A guess, relaxed: workers that do not sleep, less one for the owner if that does. [any-thread] */
static inline uint32_t job_idle_awake(const job_idle_list *list)
{
	uint32_t idlers = atomic_load_explicit(&list->state, memory_order_relaxed) & (JOB_IDLE_SPINNER - 1);
	return idlers < list->workers ? list->workers - idlers : 0;
}

/* Takes one idler that would do such work off the list and wakes it; false if there is none. A wake-up costs the caller some
 * 7 us. [any-thread] */
bool job_idle_wake(job_idle_list *list, const job_work *work);

/* The same for one thread and work that nobody else may do. Step (b) included. [any-thread] */
void job_idle_wake_thread(job_idle_list *list, job_parker *parker);

#endif
