/*
 * job_allocate: memory from a program's allocator (job_memory.h) or from the C library. Pools, graphs and queues keep a
 * copy of the allocator; all zero: the C library.
 */
#ifndef STILB_JOB_ALLOCATE_H
#define STILB_JOB_ALLOCATE_H

#include "jobs/job_contract.h"
#include "jobs/job_line.h"
#include "jobs/job_memory.h"

#include <stdalign.h>
#include <stdlib.h>
#include <string.h>

static_assert(JOB_LINE <= STILB_JOB_MAX_ALIGNMENT, "the largest alignment in use");

struct stilb_job_pool;

/* The allocator of a pool, valid as long as the pool. In job_pool.c. */
const stilb_job_allocator *job_pool_memory(const struct stilb_job_pool *pool);

/* False if it has only one of its functions. allocator may be NULL. */
static inline bool job_allocator_is_whole(const stilb_job_allocator *allocator)
{
	return !allocator || !allocator->allocate == !allocator->release;
}

/* A copy to be kept. allocator may be NULL. */
static inline stilb_job_allocator job_allocator_of(const stilb_job_allocator *allocator)
{
	return allocator ? *allocator : (stilb_job_allocator){0};
}

/* A block of size bytes, or NULL. */
static inline void *job_allocate(const stilb_job_allocator *memory, size_t size, size_t alignment)
{
	assert(size > 0 && alignment <= STILB_JOB_MAX_ALIGNMENT && (alignment & (alignment - 1)) == 0);
	if (!memory->allocate)
		return alignment <= alignof(max_align_t)
		           ? malloc(size)
		           : aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
	void *block = memory->allocate(memory->user, size, alignment);
	assert((uintptr_t)block % alignment == 0 && "the allocator returns aligned blocks");
	return block;
}

/* A block of `to` bytes with the contents of `block`, which has `from` bytes, fewer, and is then released; NULL: no
 * memory, and block is unchanged. block may be NULL. The alignment is that of malloc at most. */
static inline void *job_reallocate(const stilb_job_allocator *memory, void *block, size_t from, size_t to,
                                   size_t alignment)
{
	assert(from < to && alignment <= alignof(max_align_t));
	if (!memory->allocate)
		return realloc(block, to);
	void *larger = job_allocate(memory, to, alignment);
	if (larger && block) {
		memcpy(larger, block, from);
		memory->release(memory->user, block, from);
	}
	return larger;
}

/* Gives back a block of job_allocate with the same size; block may be NULL. */
static inline void job_release(const stilb_job_allocator *memory, void *block, size_t size)
{
	if (!memory->release)
		free(block);
	else if (block)
		memory->release(memory->user, block, size);
}

#endif
