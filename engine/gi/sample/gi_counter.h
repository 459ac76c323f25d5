/* gi_counter: counters of a worker that any thread may read for progress. */
#ifndef STILB_GI_COUNTER_H
#define STILB_GI_COUNTER_H

#include <stdatomic.h>
#include <stdint.h>

/* [one-writer]: only the worker itself adds, so it needs no atomic read-modify-write. Relaxed, like the readers' loads:
 * no other data is read because of the number, and an old one does no harm in a display of progress. */
static inline void gi_counter_add(_Atomic uint64_t *counter, uint64_t more)
{
	uint64_t now = atomic_load_explicit(counter, memory_order_relaxed);
	atomic_store_explicit(counter, now + more, memory_order_relaxed);
}

#endif
