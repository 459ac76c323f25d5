/*
 * gpu: which bytes of a block of memory are in use. Two-level segregated fit (Masmano, Ripoll, Crespo, Real: TLSF: a
 * new dynamic memory allocator for real-time systems, 2004): free ranges lie in lists by size, 16 for each power of
 * two, and two levels of bits tell which lists are not empty, so taking and giving cost the same however many ranges
 * there are.
 *
 * The block's bytes are never touched: what is known of a range lies in an array beside them. One thread at a time.
 */
#ifndef STILB_GPU_TLSF_INTERNAL_H
#define STILB_GPU_TLSF_INTERNAL_H

#include "base/base.h"

#define GPU_TLSF_UNIT 256u /* bytes: each range starts at a multiple of it, and is one long */
#define GPU_TLSF_FIRST 32u /* powers of two of units */
#define GPU_TLSF_SECOND 16u
#define GPU_TLSF_NONE UINT32_MAX

/* A range of the block, used or free. Indices of others; GPU_TLSF_NONE: there is none. */
typedef struct gpu_tlsf_range {
	uint32_t first, count;   /* units */
	uint32_t before, behind; /* ranges that touch it */
	uint32_t last, next;     /* of its list, if free; next also of unused elements of the array */
	bool free;
} gpu_tlsf_range;

typedef struct gpu_tlsf {
	gpu_tlsf_range *ranges; /* [capacity] */
	uint32_t capacity, unused;
	uint32_t units, free_units, used_ranges;
	uint32_t first_bits;
	uint16_t second_bits[GPU_TLSF_FIRST];
	uint32_t lists[GPU_TLSF_FIRST][GPU_TLSF_SECOND];
} gpu_tlsf;

/* bytes: a multiple of the unit, at most 2^32 - 1 units. False: no memory. */
bool gpu_tlsf_create(gpu_tlsf *tlsf, uint64_t bytes);
/* Leaves {0}; accepts {0}. */
void gpu_tlsf_finish(gpu_tlsf *tlsf);
/* A range of at least so many bytes, > 0, whose offset is a multiple of align, a power of two. GPU_TLSF_NONE: there is
 * no such hole, or no memory. A hole that only fits by chance, because its start is aligned, may not be found. */
uint32_t gpu_tlsf_take(gpu_tlsf *tlsf, uint64_t bytes, uint64_t align, uint64_t *offset);
/* Ends the use of a range; it becomes one hole with free neighbours. */
void gpu_tlsf_give(gpu_tlsf *tlsf, uint32_t range);
/* Bytes of the largest hole. Looks at one list. */
uint64_t gpu_tlsf_largest(const gpu_tlsf *tlsf);

#endif
