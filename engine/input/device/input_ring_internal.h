/*
 * input_ring: the queue of reports from the thread that reads a pad (the producer) to the frame (the consumer): records
 * (a report with its time) of varying size in memory of fixed size, single producer, single consumer, wait-free. A push
 * into a full ring fails.
 *
 * Life cycle.  init -> push by one thread, peek and pop by one other -> finish when both are done.
 * Threads.     init and finish while nobody else uses the ring; the others as each one says.
 */
#ifndef STILB_INPUT_RING_INTERNAL_H
#define STILB_INPUT_RING_INTERNAL_H

#include "base/base.h"

typedef struct input_record {
	int64_t time_us;
	uint64_t flow; /* the profiler's id of the arrow to the frame that takes it; 0: none */
	uint32_t size; /* bytes */
	uint8_t bytes[];
} input_record;

/* Positions count bytes since init; position p is at memory[p % capacity]. head - tail bytes are in use. */
typedef struct input_ring {
	uint8_t *memory;
	uint64_t capacity;                        /* bytes, a power of two */
	uint32_t record_max;                      /* bytes of the longest record */
	_Alignas(STILB_CACHE_LINE) uint64_t head; /* written by the producer: position of the next record */
	uint64_t tail_seen;                       /* the producer's own: tail, as it last read it */
	_Alignas(STILB_CACHE_LINE) uint64_t tail; /* written by the consumer: position of the oldest record */
} input_ring;

/* For records of up to record_max bytes. capacity is a power of two, enough for two of the longest records. -ENOMEM. */
int input_ring_init(input_ring *ring, uint64_t capacity, uint32_t record_max);
void input_ring_finish(input_ring *ring);

/* Appends a record; false: there is no room, and nothing has changed. Asserts size <= record_max. [one-writer], the
 * producer */
bool input_ring_push(input_ring *ring, int64_t time_us, uint64_t flow, const uint8_t *bytes, uint32_t size);

/* The oldest record, or NULL; it is valid until it is popped. [one-writer], the consumer */
const input_record *input_ring_peek(const input_ring *ring);

/* Removes the oldest record; asserts that there is one. [one-writer], the consumer */
void input_ring_pop(input_ring *ring);

#endif
