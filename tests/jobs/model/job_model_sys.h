/*
 * The operations of job_model.h under the names that the sources of jobs/ use. Include it once, before those sources
 * and after all other headers.
 */
#include "job_model.h"

/* NDEBUG leaves out the owners and holders that builds with asserts record: recording them would add steps. */
#ifndef NDEBUG
#define NDEBUG
#endif
#include "jobs/job_contract.h"
#undef assert
#undef JOB_CHECK
#define assert(condition) (model_assert_begin(), model_assert_end((condition) ? true : false, #condition))
#define JOB_CHECK(condition) assert(condition)

#include <errno.h>
#include <sched.h>
#include <stdalign.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#define STILB_JOB_SYS_H /* instead of jobs/job_sys.h */
#define job_sys_pause() ((void)0)
#define job_sys_relax(turns) ((void)(turns))
#define job_sys_ticks() UINT64_C(0)
#define job_sys_ticks_in(nanoseconds) ((void)(nanoseconds), model_spin_ticks)
#define job_sys_clock_ns() UINT64_C(0)
#define JOB_LOCK_YIELDS 0
#define job_sys_futex_wait model_futex_wait
/* A futex wait without its timeout, since no time passes in the model. */
#define job_sys_futex_wait_for(word, expected, nanoseconds) ((void)(nanoseconds), model_futex_wait(word, expected))
#define job_sys_futex_wake_one model_futex_wake_one
#define job_sys_compiler_barrier() ((void)0)
#define job_sys_membarrier() (model_membarrier(), true)
#define job_sys_nap(nanoseconds) ((void)0)
#define job_sys_cpu() 0u
#define job_sys_thread() 0
#define job_sys_bind(thread, cpu) ((void)(thread), (void)(cpu), false)

/* Time stands still, so a thread that waits for a lock spins until it gets it. With 0 it sleeps at once, which makes
 * more states. */
static __attribute__((unused)) uint64_t model_spin_ticks = 1; /* not used by tests without locks */

#include "jobs/job.h"
#undef STILB_JOB_MAX_WORKERS
#define STILB_JOB_MAX_WORKERS 3 /* keeps states small */

#undef atomic_load_explicit
#undef atomic_store_explicit
#undef atomic_exchange_explicit
#undef atomic_fetch_add_explicit
#undef atomic_fetch_sub_explicit
#undef atomic_fetch_or_explicit
#undef atomic_fetch_and_explicit
#undef atomic_compare_exchange_strong_explicit
#undef atomic_compare_exchange_weak_explicit

#define atomic_load_explicit(p, order) (model_load_begin(p, __LINE__), *(__typeof__(&*(p)))model_load(p))
#define atomic_store_explicit(p, value, order)                                                                         \
	(model_store_begin(p, order, __LINE__), model_store(p, sizeof *(p), (uint64_t)(uintptr_t)(value), order))
/* Exchanges *(p), called old_ there, for `result`. */
#define MODEL_RMW(p, what, result, order)                                                                              \
	__extension__({                                                                                                    \
		model_rmw(p, what, order, __LINE__);                                                                           \
		__typeof__(((void)0, *(p))) old_ = *(p);                                                                       \
		*(p) = result;                                                                                                 \
		old_;                                                                                                          \
	})
#define atomic_exchange_explicit(p, value, order) MODEL_RMW(p, "exchange", value, order)
#define MODEL_FETCH(p, change, order) MODEL_RMW(p, "fetch_add", old_ + (__typeof__(old_))(change), order)
#define atomic_fetch_add_explicit(p, value, order) MODEL_FETCH(p, value, order)
#define atomic_fetch_sub_explicit(p, value, order) MODEL_FETCH(p, -(uint64_t)(value), order)
#define atomic_fetch_or_explicit(p, bits, order) MODEL_RMW(p, "fetch_or", old_ | (bits), order)
#define atomic_fetch_and_explicit(p, bits, order) MODEL_RMW(p, "fetch_and", old_ &(bits), order)
#define atomic_compare_exchange_strong_explicit(p, expected, value, success, failure)                                  \
	__extension__({                                                                                                    \
		model_rmw(p, "compare_exchange", success, __LINE__);                                                           \
		__typeof__(((void)0, *(p))) seen_ = *(p);                                                                      \
		bool same_ = seen_ == *(expected);                                                                             \
		if (same_)                                                                                                     \
			*(p) = (value);                                                                                            \
		else                                                                                                           \
			*(expected) = seen_;                                                                                       \
		same_;                                                                                                         \
	})
#define atomic_compare_exchange_weak_explicit atomic_compare_exchange_strong_explicit

#define malloc model_malloc
#define aligned_alloc model_aligned_alloc
#define free model_free
#define pthread_create(thread, attributes, fn, data) model_thread_create(thread, fn, data)
#define pthread_join(thread, result) model_thread_join(thread)
#define pthread_self model_thread_self
#define pthread_equal(a, b) ((a) == (b))
#define pthread_setname_np(thread, name) ((void)(name))
#undef snprintf /* a macro with _FORTIFY_SOURCE and clang */
#define snprintf(text, size, format, ...) ((void)(text), (void)(__VA_ARGS__))
