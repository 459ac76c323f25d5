/*
 * job_memory: where pools, graphs and queues get their memory. That is the C library, unless the program passes
 * functions of its own when it creates a pool (job.h), a graph (job_graph.h) or a queue (job_queue.h, job_spsc.h), for
 * example to count the memory, or to take it from a block of fixed size.
 *
 * Example.
 *                   static void *arena_allocate(void *arena, size_t size, size_t alignment);
 *                   static void arena_release(void *arena, void *block, size_t size);
 *
 *                   stilb_job_allocator memory = {arena_allocate, arena_release, &arena};
 *                   desc.allocator = &memory; // copied; what user points to must outlive the pool
 *
 * What.         Of a pool: itself, its deques, the records of jobs, its shared queues, and the arrays of
 *               stilb_job_sort and stilb_job_reduce. Of a graph and a queue: all; a run of a graph uses records of its
 *               pool. Not threads and their stacks, and lists of CPUs, which exist only while a pool is created.
 * When.         When a pool, graph or queue is created, and when a graph is changed or built. When a pool or queue
 *               needs more than it ever has: in submits, pushes, waits and runs of graphs. In stilb_job_sort and
 *               stilb_job_reduce. Pops from lock-free queues, also a pool's, may release some of it; the rest is
 *               released by destroy.
 * Threads.      Any thread that makes such a call, workers among them, several at a time: both functions must be
 *               thread-safe. The library holds no lock when it calls them. They must not call the pool, graph or
 *               queue.
 * Out of memory.
 *               NULL from allocate has the same consequences as NULL from malloc: each function says which.
 */
#ifndef STILB_JOB_MEMORY_H
#define STILB_JOB_MEMORY_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* The largest alignment that is asked for, in bytes. */
#define STILB_JOB_MAX_ALIGNMENT 128

/* Without functions: the C library. One without the other is refused with -EINVAL. */
typedef struct stilb_job_allocator {
	/* Returns a block of size bytes, at least 1, with any contents; its address is a multiple of alignment, a power of
	 * two up to STILB_JOB_MAX_ALIGNMENT (asserted). NULL: there is no memory. */
	void *(*allocate)(void *user, size_t size, size_t alignment);
	/* Takes back a block of this many bytes, which allocate has returned for this size. block is not NULL. */
	void (*release)(void *user, void *block, size_t size);
	void *user; /* the first argument of both */
} stilb_job_allocator;

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#endif
