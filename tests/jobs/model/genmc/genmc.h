/*
 * The real sources of jobs/ under GenMC (Kokologiannakis and Vafeiadis, "GenMC: A Model Checker for Weak Memory
 * Models", CAV 2021), which explores all executions of a small program that the C11 memory model (RC11) allows, and
 * finds races of plain accesses: so it sees the missing acquires and releases that the checker of job_model.h does not
 * see. With --imm the model is IMM, which has also the executions that compilers for ARMv8, POWER and RISC-V may leave
 * (Podkopaev, Lahav and Vafeiadis, "Bridging the Gap between Programming Languages and Hardware Weak Memory Models",
 * POPL 2019). It is not part of the build. With GenMC 0.10.3 and clang 14, from the top of the repository:
 *
 *   genmc --rc11 --disable-estimation -- -O0 -w -std=gnu17 -D_GNU_SOURCE -I. tests/jobs/model/genmc/genmc_spsc.c
 *
 * It must end with "No errors were detected", after eight seconds at most, and with --imm after forty. genmc_deque.c,
 * genmc_group.c, genmc_loop.c and genmc_park.c need -O1 -fno-builtin instead of -O0, since GenMC does not copy structs
 * through pointers.
 *
 * Tried, with both models, one at a time. It reports an error if
 * - the deque's push is a release store or acquire-release, its pop a release store, or what hides records while the
 *   owner digs a release store; if top or bottom is read weaker than seq_cst by a pop, a thief, a dig, or a thread that
 *   goes to sleep; if a new buffer is published or read relaxed;
 * - job_idle_wanted_strict is a load; either side of the idle list is relaxed; the lock is given or taken relaxed;
 * - a hazard pointer is set by a release store or an acquire-release exchange, or anything else that the argument in
 *   job_queue_lock_free.c names as seq_cst is weaker, but for the load of used_count in segment_in_use; if cells or
 *   links of that queue are changed relaxed;
 * - one of the counts of the low-lock queue is published relaxed, or read relaxed by a push;
 * - a release or acquire of the SPSC queue is relaxed (all but those of close);
 * - a job leaves its group by a release, an acquire or a relaxed exchange, or the count is read relaxed by a wait or by
 *   a submit of a follower;
 * - a loop is opened, claimed or counted as done relaxed, or looked at relaxed by its caller.
 * It finds nothing, because another operation orders the same accesses, if the deque's bottom is put back relaxed after
 * the last pop, if a push reads top relaxed, if a pop of the low-lock queue reads the producers' count relaxed (it has
 * acquired it before the lock), or if an end of the lock-free queue is moved in vain relaxed. It finds nothing, because
 * the programs are too short, for that load of used_count, for the slots of retired segments, for cells, links and
 * used_count when the exchange fails, and for the acquire of a loop's done, which wide loops need.
 *
 * Include this first. GenMC has no memset and memcpy, and takes no accesses of several sizes to one place, so the
 * programs initialise what they check themselves.
 */
#ifndef GENMC_H
#define GENMC_H

#define NDEBUG /* for the sources: their asserts and checks are run by the model tests */
#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#undef static_assert
#define static_assert _Static_assert

/* size is a multiple of 8. */
static inline void genmc_zero(void *at, size_t size)
{
	for (size_t i = 0; i < size / sizeof(uint64_t); i++)
		((uint64_t *)at)[i] = 0;
}
#undef memset
#define memset(at, byte, size) genmc_zero(at, size)

/* Of pointers alone. */
static inline void genmc_copy(void **to, void *const *from, size_t size)
{
	for (size_t i = 0; i < size / sizeof *to; i++)
		to[i] = from[i];
}
#undef memcpy
#define memcpy(to, from, size) genmc_copy((void **)(to), (void *const *)(from), size)

/* Instead of jobs/job_sys.h. An execution ends where a thread would sleep: what it could see after that, it also sees
 * in executions in which it comes later and need not sleep. */
void __VERIFIER_assume(bool);
#define STILB_JOB_SYS_H
#define JOB_LOCK_YIELDS 0
#define job_sys_pause() ((void)0)
#define job_sys_ticks() UINT64_C(0)
#define job_sys_ticks_in(nanoseconds) UINT64_C(0)
#define job_sys_compiler_barrier() ((void)0)
#define job_sys_membarrier() false
#define job_sys_thread() 0
#define job_sys_bind(thread, cpu) false
#define job_sys_cpu() 0u
#define job_sys_futex_wait(word, expected) __VERIFIER_assume(false)
#define job_sys_futex_wait_for(word, expected, nanoseconds) __VERIFIER_assume(false)
#define job_sys_futex_wake_one(word) ((void)0)

/* GenMC gives a compare-exchange that fails the order of success. Here it fails by a load of its own order. */
#define GENMC_COMPARE_EXCHANGE(word, expected, value, success, failure)                                                \
	__extension__({                                                                                                    \
		__typeof__(((void)0, *(word))) seen_ = atomic_load_explicit(word, failure);                                    \
		bool same_ = seen_ == *(expected);                                                                             \
		if (!same_)                                                                                                    \
			*(expected) = seen_;                                                                                       \
		same_ &&__c11_atomic_compare_exchange_strong(word, expected, value, success, failure);                         \
	})
#undef atomic_compare_exchange_strong_explicit
#undef atomic_compare_exchange_weak_explicit
#define atomic_compare_exchange_strong_explicit GENMC_COMPARE_EXCHANGE
#define atomic_compare_exchange_weak_explicit GENMC_COMPARE_EXCHANGE

/* Instead of jobs/queue/job_event.h, which sleeps in the kernel. */
#define STILB_JOB_EVENT_H
#define JOB_EVENT_ALL 1
#define job_event_awaited(event) false
#define job_event_signal(event, count) ((void)(event))
#define job_event_wait(...) (-ETIMEDOUT)
typedef struct job_event {
	uint32_t waiters;
} job_event;

#endif
