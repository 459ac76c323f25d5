/*
 * gpu: device memory, taken from the driver in blocks that buffers and images share.
 *
 * A pool is memory of one type for one kind of use; things of different pools never lie in one block, so images and
 * buffers, which may not share a page on some devices (bufferImageGranularity), get different pools. The first block of
 * a pool is small, each further one twice as large, up to the pool's most. What is larger than half of that gets memory
 * of its own. An empty block goes back to the driver unless it is the pool's only one that is empty.
 *
 * Threads. [any-thread] but for init and finish.
 */
#ifndef STILB_GPU_MEMORY_INTERNAL_H
#define STILB_GPU_MEMORY_INTERNAL_H

#include "base/base_contract.h"
#include "gpu/gpu.h"
#include "gpu/gpu_tlsf_internal.h"

#define GPU_MEMORY_POOLS 64u
#define GPU_MEMORY_BLOCK ((uint64_t)64 << 20)      /* bytes of a block at most */
#define GPU_MEMORY_FIRST_BLOCK ((uint64_t)4 << 20) /* of a pool's first */

/* The driver's memory of a block, and where the CPU has it; NULL: it has not. */
typedef struct gpu_memory_handle {
	uint64_t memory;
	void *mapped;
} gpu_memory_handle;

/* How blocks are had. make returns 0, or what gpu_memory_take shall return. */
typedef struct gpu_memory_source {
	void *user;
	int32_t (*make)(void *user, uint32_t pool, uint64_t bytes, gpu_memory_handle *handle);
	void (*drop)(void *user, gpu_memory_handle handle);
	int32_t no_memory; /* what gpu_memory_take returns where the CPU has no memory */
} gpu_memory_source;

typedef struct gpu_memory_block {
	gpu_memory_handle handle;
	gpu_tlsf tlsf;
	uint64_t bytes; /* 0: this element of the array is unused */
} gpu_memory_block;

typedef struct gpu_memory_pool {
	gpu_memory_block *blocks; /* [capacity] */
	uint32_t count, capacity; /* blocks; some may be unused */
	uint32_t made;            /* blocks that there are */
	uint64_t most;            /* bytes of a block, a power of two */
} gpu_memory_pool;

typedef struct gpu_memory {
	stilb_lock lock;
	bool lock_made;
	gpu_memory_source source;
	gpu_memory_pool pools[GPU_MEMORY_POOLS];
	uint64_t alone, alone_bytes; /* things with memory of their own */
	uint64_t used_bytes, allocations;
} gpu_memory;

/* Where something lies. {0}: nowhere. */
typedef struct gpu_memory_place {
	gpu_memory_handle handle;
	uint64_t offset, bytes;
	void *mapped;                /* of the place itself */
	uint32_t pool, block, range; /* block GPU_TLSF_NONE: memory of its own */
} gpu_memory_place;

/* False: no memory. */
bool gpu_memory_init(gpu_memory *memory, gpu_memory_source source);
/* Everything has been given back. Leaves {0}; accepts {0}. */
void gpu_memory_finish(gpu_memory *memory);
/* Bytes of a pool's blocks for a heap of so many bytes: a sixteenth of it, at most GPU_MEMORY_BLOCK. */
void gpu_memory_pool_set(gpu_memory *memory, uint32_t pool, uint64_t heap_bytes);
/* bytes > 0; align: a power of two. 0, or the error; then *place is {0}. */
int32_t gpu_memory_take(gpu_memory *memory, uint32_t pool, uint64_t bytes, uint64_t align, gpu_memory_place *place);
/* Leaves {0}; accepts {0}. */
void gpu_memory_give(gpu_memory *memory, gpu_memory_place *place);
stilb_gpu_memory_report gpu_memory_measure(gpu_memory *memory);

#endif
