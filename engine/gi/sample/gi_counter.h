/* gi_counter: counters of a worker that any thread may read for progress. */
#ifndef STILB_GI_COUNTER_H
#define STILB_GI_COUNTER_H

#include <stdatomic.h>
#include <stdint.h>

/* [one-writer], so it needs no atomic read-modify-write. Relaxed, like the readers' loads: the number orders
 * nothing. */
static inline void gi_counter_add(_Atomic uint64_t *counter, uint64_t more)
{
	uint64_t now = atomic_load_explicit(counter, memory_order_relaxed);
	atomic_store_explicit(counter, now + more, memory_order_relaxed);
}

#endif
