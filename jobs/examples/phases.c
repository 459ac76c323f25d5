/*
 * A frame loop: loops follow one another closely inside a frame, and there is no work between frames. In a phase the
 * workers spin between loops, so each starts at once; outside they sleep and cost nothing.
 *
 * Prints: 30 frames, 90000 updates, 60000 draws
 */
#include <stilb/job.h>

#include <stdio.h>
#include <time.h>

enum { FRAMES = 30, MODELS = 3000, DRAWS = 2000, GRAIN = 128 };

static void count_each(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	uint32_t *counts = context;
	for (uint32_t i = begin; i < end; i++)
		counts[i]++; /* one thread runs the slice, and the return of the loop orders it before the next loop */
}

static uint64_t sum(const uint32_t *counts, uint32_t count)
{
	uint64_t total = 0;
	for (uint32_t i = 0; i < count; i++)
		total += counts[i];
	return total;
}

int main(void)
{
	static uint32_t updates[MODELS], draws[DRAWS];
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	stilb_job_pool *pool;
	if (stilb_job_pool_create(&desc, &pool) != 0)
		return 1;
	for (int frame = 0; frame < FRAMES; frame++) {
		stilb_job_phase_begin(pool);
		stilb_job_parallel_for(pool, MODELS, GRAIN, count_each, updates, 0);
		stilb_job_parallel_for(pool, DRAWS, GRAIN, count_each, draws, 0);
		stilb_job_phase_end(pool);
		nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL); /* waits for the screen */
	}
	printf("%d frames, %llu updates, %llu draws\n", FRAMES, (unsigned long long)sum(updates, MODELS),
	       (unsigned long long)sum(draws, DRAWS));
	stilb_job_pool_destroy(pool);
	return 0;
}
