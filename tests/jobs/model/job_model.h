/*
 * job_model: a small explicit-state model checker for the real sources of jobs/.
 *
 *   #include "job_model_sys.h"        replaces atomics, futex, threads and malloc by the checker's operations
 *   #include "jobs/job_lock.c"        the sources under test
 *   ...
 *   model_scenario scenario = {.main = first, .data = &shared, .data_size = sizeof shared, .max_states = 100000};
 *   model_result result = model_run(&scenario, true);
 *
 * Method.       Threads are coroutines. Before each operation on shared memory a thread stops, and the checker runs
 *               every enabled thread from every state that it has not seen: all interleavings, exhaustively, as
 *               sequentially consistent steps.
 * States.       All that the threads can see: their stacks, the heap, the scenario's data. A state is saved and
 *               restored byte by byte, and identified by a 64-bit hash; the chance that two of a million states have
 *               the same hash is about 3e-8.
 * It finds      failed checks; states in which no thread can run (lost wake-up, deadlock); states from which the end
 *               cannot be reached (livelock, waiting for a word that nobody changes); operations on freed memory or on
 *               the stack of a function that has returned.
 * Not modelled: weak memory (argued in the comments of the sources, partly checked by the thread sanitizer), spurious
 *               failures of weak compare-exchange, plain accesses as separate steps (the thread sanitizer finds racing
 *               ones).
 * x86-64 only:  the switch between coroutines is written in assembly.
 */
#ifndef JOB_MODEL_H
#define JOB_MODEL_H

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct model_scenario {
	void (*main)(void);  /* the first thread */
	void (*check)(void); /* called at the end of every run; may be NULL */
	void *data;          /* shared by the threads, besides the heap; zeroed at the start */
	size_t data_size;
	bool main_ends_all;  /* a run ends when the first thread returns, whatever the others do */
	uint32_t may_stop;   /* a bit for each thread that may stop for ever before any step; the others must still end */
	uint32_t max_states; /* exceeding it is a failure, since the check would not be exhaustive */
} model_scenario;

typedef struct model_result {
	const char *failure; /* NULL: every interleaving ends well */
	uint32_t states;
	uint32_t steps; /* transitions between states */
	uint32_t depth; /* number of steps of the longest path */
} model_result;

/* Checks all interleavings. With trace, the path to a failure is printed on stderr. */
model_result model_run(const model_scenario *scenario, bool trace);

/* False if the checker has no coroutines for this CPU. */
bool model_available(void);

/* Called by scenarios. */
void model_fail(const char *why); /* ends the run as a failure; does not return */
void model_spawn(void *(*fn)(void *), void *data);
void model_block_until(const uint32_t *word, uint32_t value); /* sleeps until *word is value */
uint32_t model_heap_blocks(void);                             /* number of blocks not freed */

/* Faults of the checker's own operations, which it must find. */
typedef enum model_fault {
	MODEL_FAULT_NONE,
	MODEL_FAULT_NO_WAKE, /* futex wake does nothing */
	MODEL_FAULT_NO_LOCK  /* locks do not exclude */
} model_fault;
extern model_fault model_fault_now;

/* Called around the condition of an assert. Loads of atomics in between are no steps: an assert is checked in every
 * state and adds none. */
void model_assert_begin(void);
void model_assert_end(bool holds, const char *condition);

/* The checker's operations. */
void model_step(const volatile void *word, const char *what, int line);
void model_futex_wait(_Atomic uint32_t *word, uint32_t expected);
void model_futex_wake_one(_Atomic uint32_t *word);
void *model_malloc(size_t size);
void *model_aligned_alloc(size_t alignment, size_t size);
void model_free(void *block);
int model_thread_create(pthread_t *thread, void *(*fn)(void *), void *data);
int model_thread_join(pthread_t thread);
pthread_t model_thread_self(void);

#endif
