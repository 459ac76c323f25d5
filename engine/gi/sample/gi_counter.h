/* gi_counter: numbers of a worker, read by whoever asks for progress. */
#ifndef STILB_GI_COUNTER_H
#define STILB_GI_COUNTER_H

#include <stdatomic.h>
#include <stdint.h>

/* [one-writer] So no read-modify-write. Relaxed, as its readers' loads: a number to show, that orders nothing. */
static inline void gi_counter_add(_Atomic uint64_t *counter, uint64_t more)
{
	const uint64_t now = atomic_load_explicit(counter, memory_order_relaxed);
	atomic_store_explicit(counter, now + more, memory_order_relaxed);
}

#endif
