/*
 * job_model: a small explicit-state model checker for the real sources of jobs/.
 *
 * What it does. The test includes the .c files of the library after this header, which has put its own operations in
 *               the place of C11 atomics, futex, threads and malloc. Threads are coroutines. Before each such operation
 *               a thread stops, and the checker runs every enabled thread from every state it has not seen: all
 *               interleavings, exhaustively, as sequentially consistent steps.
 * A state.      All that the threads can see: their stacks, the heap, the scenario's data. It is saved and restored
 *               byte by byte and told from others by a 64-bit hash (two states with one hash would be taken for one;
 *               with a million states the chance of that is about 3e-8).
 * It finds      failed checks, states where nobody can go on (lost wake-up, deadlock), states from which no
 *               continuation reaches the end (livelock, waiting on a word that nobody changes any more), operations on
 *               freed memory or on the stack of a function that has returned.
 * Not modelled: weak memory (the comments in the sources argue that, TSan checks part of it), spurious failures of weak
 *               compare-exchange, plain accesses as steps of their own (TSan finds those that race).
 * x86-64 only: the switch between coroutines is a few lines of assembly.
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
	void (*check)(void); /* at the end of every run; may be NULL */
	void *data;          /* what the threads share beside the heap; zeroed at the start */
	size_t data_size;
	bool main_ends_all; /* a run is over when the first thread returns, whatever the others do */
	uint32_t
		may_stop; /* bit per thread: it may stop for ever before any of its steps; the others must end all the same */
	uint32_t max_states; /* more of them count as a failure: a check that is not exhaustive proves nothing */
} model_scenario;

typedef struct model_result {
	const char *failure; /* NULL: every interleaving ends well */
	uint32_t states;
	uint32_t steps; /* transitions between states */
	uint32_t depth; /* steps of the longest path tried */
} model_result;

/* With trace, the path to a failure goes to stderr. */
model_result model_run(const model_scenario *scenario, bool trace);

/* False where the checker has no coroutines. */
bool model_available(void);

/* For scenarios. */
void model_fail(const char *why); /* does not return */
void model_spawn(void *(*fn)(void *), void *data);
void model_block_until(const uint32_t *word, uint32_t value); /* sleeps and does nothing else */
uint32_t model_heap_blocks(void);                             /* blocks not freed */

/* Planted faults that the checker must find. */
typedef enum model_fault {
	MODEL_FAULT_NONE,
	MODEL_FAULT_NO_WAKE, /* the kernel is not asked to wake */
	MODEL_FAULT_NO_LOCK  /* locks exclude nobody */
} model_fault;
extern model_fault model_fault_now;

/* Around the condition of an assert. Loads of atomics in between are no steps: an assert is checked in every state and
 * adds none. */
void model_assert_begin(void);
void model_assert_end(bool holds, const char *condition);

/* The checker's versions of the operations. */
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
