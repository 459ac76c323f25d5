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
 *               every enabled thread from every state that it has not seen: all interleavings, exhaustively.
 * Memory.       Each scenario chooses the machine that it runs on (model_memory). On a machine with store buffers a
 *               store waits in the buffer of its thread, and that it drains into memory is a step of its own, which the
 *               checker takes at every possible moment.
 * States.       All that the threads can see: their stacks, the heap, the scenario's data. A state is saved and
 *               restored byte by byte, and identified by a 64-bit hash; the chance that two of a million states have
 *               the same hash is about 3e-8.
 * It finds      failed checks; crashes; states in which no thread can run (lost wake-up, deadlock); states from which
 *               the end cannot be reached (livelock, waiting for a word that nobody changes); operations on freed
 *               memory or on the stack of a function that has returned.
 * Not modelled: loads out of their turn, so a missing acquire is not seen; plain accesses as steps: a plain store is in
 *               memory at once, so a missing release is not seen if what it publishes is plain (the thread sanitizer
 *               sees both in the interleavings that it meets); spurious failures of weak compare-exchange; more than
 *               MODEL_BUFFER stores that wait in one buffer.
 * x86-64 only:  the switch between coroutines is written in assembly.
 */
#ifndef JOB_MODEL_H
#define JOB_MODEL_H

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifndef MODEL_BUFFER
#define MODEL_BUFFER 3 /* stores that wait in a thread's buffer at most; the next one waits for room */
#endif

/*
 * Machines, from strong to weak: each can do all that those before it can, so what ends well on it ends well on them.
 *
 * MODEL_SC      Sequentially consistent: a store is in memory at once.
 * MODEL_TSO     x86: Owens, Sarkar and Sewell, "A Better x86 Memory Model: x86-TSO", TPHOLs 2009. A store waits in a
 *               first-in first-out buffer, and the thread's own loads see it there. A seq_cst store and every
 *               read-modify-write wait until the buffer is empty. So a load may happen before an earlier store to
 *               another word: the one thing that x86 reorders.
 * MODEL_PSO     Stores to different words also drain in any order, as on ARM, unless the orders that the source names
 *               forbid it: a release store drains after all earlier ones; a read-modify-write that is neither release
 *               nor seq_cst waits only for the stores to its own word. Loads stay in order, unlike on ARM.
 *
 * System calls: a futex wait and a futex wake are full barriers, as in Linux (kernel/futex: the barriers (A) and (B)
 * that its head describes), as are the creation and the end of a thread. Memory is freed after all earlier stores.
 */
typedef enum model_memory { MODEL_SC, MODEL_TSO, MODEL_PSO } model_memory;

typedef struct model_scenario {
	model_memory memory;
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

/* The arguments of a model test, each with those before it: "must-fail" or "ends-well"; a machine, "sc", "tso" or
 * "pso"; the number of a planted fault, 0 for none; the name of the scenarios to run. With must-fail some scenario must
 * fail; with ends-well, or without arguments, none may. */
typedef struct model_arguments {
	bool must_fail;
	model_memory memory;  /* MODEL_PSO without arguments */
	const char *scenario; /* NULL: all of them */
} model_arguments;
model_arguments model_arguments_of(int argc, char **argv);

/* True if the arguments choose the scenarios with this name. */
bool model_chosen(const model_arguments *arguments, const char *scenario);

/* The planted fault that is on (CMakeLists.txt numbers them), or 0. Set by model_arguments_of. */
extern int model_planted;

/* Checks all interleavings. With trace, the path to a failure is printed on stderr. */
model_result model_run(const model_scenario *scenario, bool trace);

/* False if the checker has no coroutines for this CPU. */
bool model_available(void);

/* Called by scenarios. */
void model_fail(const char *why); /* ends the run as a failure; does not return */
void model_spawn(void *(*fn)(void *), void *data);
void model_block_until(const uint32_t *word, uint32_t value); /* sleeps until *word is value */
uint32_t model_heap_blocks(void);                             /* number of blocks not freed */
void model_barrier(void);                                     /* waits until the thread's stores are in memory */

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

/* The thread stops, to go on when the checker chooses it: other threads may run before what it does next. */
void model_step(const volatile void *word, const char *what, int line);

/* A load and a store are two calls each: model_step, and then the access, so that a thread that has stopped keeps no
 * value of it on its stack. A load returns where the value is: the thread's own newest store to the word, or the word
 * itself. A store takes the low `size` bytes of value. */
void model_load_begin(const volatile void *word, int line);
void *model_load(const volatile void *word);
void model_store_begin(volatile void *word, memory_order order, int line);
void model_store(volatile void *word, size_t size, uint64_t value, memory_order order);

/* model_step before a read-modify-write, which then accesses the memory itself. */
void model_rmw(volatile void *word, const char *what, memory_order order, int line);

/* The stores of all threads are in memory: membarrier(MEMBARRIER_CMD_PRIVATE_EXPEDITED). */
void model_membarrier(void);

void model_futex_wait(_Atomic uint32_t *word, uint32_t expected);
void model_futex_wake_one(_Atomic uint32_t *word);
void *model_malloc(size_t size);
void *model_aligned_alloc(size_t alignment, size_t size);
void model_free(void *block);
int model_thread_create(pthread_t *thread, void *(*fn)(void *), void *data);
int model_thread_join(pthread_t thread);
pthread_t model_thread_self(void);

#endif
