/*
 * An array of jobs is a parallel loop submitted as one job. Two of them run at the same time, and the
 * submitter is free until it waits.
 *
 * Prints: 50000 of 50000 doubled, 50000 of 50000 cleared
 */
#include <stilb/job.h>

#include <stdio.h>

enum { NUMBERS = 50000, GRAIN = 64 };

static void twice(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	uint32_t *numbers = context;
	for (uint32_t i = begin; i < end; i++)
		numbers[i] *= 2;
}

static void clear(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	uint32_t *numbers = context;
	for (uint32_t i = begin; i < end; i++)
		numbers[i] = 0;
}

int main(void)
{
	static uint32_t doubled[NUMBERS], cleared[NUMBERS];
	for (uint32_t i = 0; i < NUMBERS; i++)
		doubled[i] = cleared[i] = i + 1;
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	stilb_job_pool *pool;
	if (stilb_job_pool_create(&desc, &pool) != 0)
		return 1;
	stilb_job_group group = {0};
	if (stilb_job_submit_array(pool, NUMBERS, GRAIN, twice, doubled, &group, 0) != 0 ||
	    stilb_job_submit_array(pool, NUMBERS, GRAIN, clear, cleared, &group, 0) != 0)
		return 1;
	/* ... the submitter does something else ... */
	stilb_job_wait(pool, &group, 0);

	int right_doubled = 0, right_cleared = 0;
	for (uint32_t i = 0; i < NUMBERS; i++) {
		right_doubled += doubled[i] == 2 * (i + 1);
		right_cleared += cleared[i] == 0;
	}
	printf("%d of %d doubled, %d of %d cleared\n", right_doubled, NUMBERS, right_cleared, NUMBERS);
	stilb_job_pool_destroy(pool);
	return 0;
}
