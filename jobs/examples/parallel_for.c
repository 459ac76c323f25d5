/*
 * A parallel loop with one sum for each thread: the worker index of a slice picks the slot, so no atomics are needed.
 * Slots lie 128 bytes apart, so that no two threads write to the same cache line.
 *
 * Prints: sum of squares 333332833333500000
 */
#include <stilb/job.h>

#include <stdio.h>
#include <stdlib.h>

enum { NUMBERS = 1000000, GRAIN = 4096 };

typedef struct slot {
	_Alignas(128) uint64_t sum;
} slot;

static void add_squares(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	slot *slots = context;
	uint64_t sum = 0;
	for (uint64_t i = begin; i < end; i++)
		sum += i * i;
	slots[worker].sum += sum;
}

int main(void)
{
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	stilb_job_pool *pool;
	if (stilb_job_pool_create(&desc, &pool) != 0)
		return 1;
	uint32_t threads = stilb_job_pool_worker_count(pool) + 1; /* the calling thread, index 0, takes part */
	slot *slots = aligned_alloc(_Alignof(slot), threads * sizeof *slots);
	if (!slots)
		return 1;
	for (uint32_t i = 0; i < threads; i++)
		slots[i].sum = 0;

	stilb_job_parallel_for(pool, NUMBERS, GRAIN, add_squares, slots, 0);

	uint64_t sum = 0;
	for (uint32_t i = 0; i < threads; i++)
		sum += slots[i].sum;
	printf("sum of squares %llu\n", (unsigned long long)sum);
	free(slots);
	stilb_job_pool_destroy(pool);
	return 0;
}
