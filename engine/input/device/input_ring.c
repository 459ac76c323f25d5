#include "input/device/input_ring_internal.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/*
 * A record lies in one piece: one that begins before the memory's end may reach beyond capacity, into a margin as long
 * as the longest record. As at most `capacity` bytes of positions are in use, only one record can reach there at a
 * time, and the places that it leaves out at the memory's beginning are nobody's.
 *
 *   reader   writes the record, then publishes head
 *   frame    reads the record, then publishes tail
 *
 * All other memory is plain: what one side reads of it was written before the other published.
 */

/* What a record takes: the next one is aligned as well. */
static uint64_t ring_length(uint32_t size)
{
	return (sizeof(input_record) + size + 7) & ~UINT64_C(7);
}

static input_record *ring_at(const input_ring *ring, uint64_t position)
{
	return (input_record *)(ring->memory + (position & (ring->capacity - 1)));
}

int input_ring_init(input_ring *ring, uint64_t capacity, uint32_t record_max)
{
	STILB_ASSERT((capacity & (capacity - 1)) == 0 && capacity >= 2 * ring_length(record_max));
	*ring = (input_ring){.memory = malloc(capacity + ring_length(record_max)), .capacity = capacity};
	return ring->memory ? 0 : -ENOMEM;
}

void input_ring_finish(input_ring *ring)
{
	free(ring->memory);
	ring->memory = NULL;
}

bool input_ring_push(input_ring *ring, int64_t time_us, uint64_t flow, const uint8_t *bytes, uint32_t size)
{
	uint64_t head = __atomic_load_n(&ring->head, __ATOMIC_RELAXED); /* written by this thread alone */
	uint64_t end = head + ring_length(size);
	if (end - ring->tail_seen > ring->capacity)
		ring->tail_seen = __atomic_load_n(&ring->tail, __ATOMIC_ACQUIRE); /* pairs with input_ring_pop */
	if (end - ring->tail_seen > ring->capacity)
		return false;
	input_record *record = ring_at(ring, head);
	record->time_us = time_us;
	record->flow = flow;
	record->size = size;
	memcpy(record->bytes, bytes, size);
	__atomic_store_n(&ring->head, end, __ATOMIC_RELEASE); /* pairs with input_ring_peek */
	return true;
}

const input_record *input_ring_peek(const input_ring *ring)
{
	uint64_t tail = __atomic_load_n(&ring->tail, __ATOMIC_RELAXED); /* written by this thread alone */
	/* Acquire: pairs with input_ring_push. */
	return __atomic_load_n(&ring->head, __ATOMIC_ACQUIRE) != tail ? ring_at(ring, tail) : NULL;
}

void input_ring_pop(input_ring *ring)
{
	uint64_t tail = __atomic_load_n(&ring->tail, __ATOMIC_RELAXED); /* written by this thread alone */
	/* Release: pairs with input_ring_push, which writes to the record's place only now. */
	__atomic_store_n(&ring->tail, tail + ring_length(ring_at(ring, tail)->size), __ATOMIC_RELEASE);
}
