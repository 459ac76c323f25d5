#include "input/device/input_ring_internal.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/*
 * A record is contiguous: one that begins before the end of the capacity continues beyond it, into a margin as long as
 * the longest record, instead of wrapping to the beginning. At most `capacity` positions are in use, so only one record
 * at a time can be in the margin, and the bytes at the beginning of the memory that belong to its positions stay
 * unused.
 *
 *   producer   writes the record, then publishes head
 *   consumer   reads the record, then publishes tail
 *
 * All other memory is not atomic: what one side reads of it the other wrote before it published.
 */

/* Bytes that a record takes, rounded up so that the next one is aligned too. */
static uint64_t ring_length(uint32_t size)
{
	return (sizeof(input_record) + size + 7) & ~UINT64_C(7);
}

/* For STILB_CHECK, by producer or consumer: positions are aligned, and no more bytes are in use than the capacity. */
static bool ring_is_sound(const input_ring *ring, uint64_t head, uint64_t tail)
{
	return ring->memory && head - tail <= ring->capacity && head % 8 == 0 && tail % 8 == 0;
}

static input_record *ring_at(const input_ring *ring, uint64_t position)
{
	return (input_record *)(ring->memory + (position & (ring->capacity - 1)));
}

int input_ring_init(input_ring *ring, uint64_t capacity, uint32_t record_max)
{
	STILB_ASSERT((capacity & (capacity - 1)) == 0 && capacity >= 2 * ring_length(record_max));
	*ring = (input_ring){
		.memory = malloc(capacity + ring_length(record_max)), .capacity = capacity, .record_max = record_max};
	return ring->memory ? 0 : -ENOMEM;
}

void input_ring_finish(input_ring *ring)
{
	free(ring->memory);
	ring->memory = NULL;
}

bool input_ring_push(input_ring *ring, int64_t time_us, uint64_t flow, const uint8_t *bytes, uint32_t size)
{
	STILB_ASSERT(size <= ring->record_max && (bytes || size == 0));
	uint64_t head = __atomic_load_n(&ring->head, __ATOMIC_RELAXED); /* written by this thread alone */
	STILB_CHECK(ring_is_sound(ring, head, ring->tail_seen));
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
	uint64_t head = __atomic_load_n(&ring->head, __ATOMIC_ACQUIRE); /* pairs with input_ring_push */
	STILB_CHECK(ring_is_sound(ring, head, tail));
	return head != tail ? ring_at(ring, tail) : NULL;
}

void input_ring_pop(input_ring *ring)
{
	uint64_t tail = __atomic_load_n(&ring->tail, __ATOMIC_RELAXED); /* written by this thread alone */
	/* Relaxed: head is only compared here; reading the record is allowed since input_ring_peek has acquired it. */
	STILB_ASSERT(__atomic_load_n(&ring->head, __ATOMIC_RELAXED) != tail && "there is a record to remove");
	/* Release: pairs with input_ring_push, which may overwrite the record from here on. */
	__atomic_store_n(&ring->tail, tail + ring_length(ring_at(ring, tail)->size), __ATOMIC_RELEASE);
}
