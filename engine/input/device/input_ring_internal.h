/*
 * input_ring: reports on their way from the thread that reads a pad to the frame: a queue of records of any size in a
 * piece of memory of fixed size. It waits for nothing: a push that finds no room says so.
 *
 * Life cycle.  init -> push by one thread, peek and pop by one other -> finish when both are done.
 */
#ifndef STILB_INPUT_RING_INTERNAL_H
#define STILB_INPUT_RING_INTERNAL_H

#include "base/base.h"

typedef struct input_record {
	int64_t time_us;
	uint64_t flow; /* the profiler's number of its arrow to the frame; 0: none */
	uint32_t size; /* of the bytes */
	uint8_t bytes[];
} input_record;

/* Positions count bytes since the start; a position's place in memory is its remainder by capacity. */
typedef struct input_ring {
	uint8_t *memory;
	uint64_t capacity;                        /* a power of two */
	_Alignas(STILB_CACHE_LINE) uint64_t head; /* written by the reader: where the next record goes */
	uint64_t tail_seen;                       /* the reader's own: tail, when it last looked */
	_Alignas(STILB_CACHE_LINE) uint64_t tail; /* written by the frame: the oldest record */
} input_ring;

/* For records of up to record_max bytes, several of which fit. -ENOMEM. */
int input_ring_init(input_ring *ring, uint64_t capacity, uint32_t record_max);
void input_ring_finish(input_ring *ring);

/* False: there is no room, and nothing has changed. [one-writer], the reader */
bool input_ring_push(input_ring *ring, int64_t time_us, uint64_t flow, const uint8_t *bytes, uint32_t size);

/* The oldest record, NULL: there is none. It stays as it is until it is popped. [one-writer], the frame */
const input_record *input_ring_peek(const input_ring *ring);
void input_ring_pop(input_ring *ring);

#endif
