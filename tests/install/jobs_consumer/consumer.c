/* Writes numbers on the worker pool, passes them through both kinds of queue, and adds them up. Compiled as C, and as
 * C++ by way of consumer.cpp. */
#include <stilb/job.h>
#include <stilb/job_queue.h>
#include <stilb/job_spsc.h>

#include <stdio.h>

#define COUNT 1000

static void take_over(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	for (uint32_t i = begin; i < end; i++)
		((uint32_t *)context)[i] = i;
}

int main(void)
{
	static uint32_t numbers[COUNT];
	stilb_job_pool_desc pool_desc = stilb_job_pool_desc_default();
	stilb_job_queue_desc queue_desc = stilb_job_queue_desc_default();
	stilb_job_pool *pool;
	stilb_job_queue *queue;
	stilb_job_spsc *spsc;
	void *item;
	uint32_t sum = 0;
	if (stilb_job_pool_create(&pool_desc, &pool) || stilb_job_queue_create(&queue_desc, &queue) ||
	    stilb_job_spsc_create(&spsc))
		return 1;
	stilb_job_parallel_for(pool, COUNT, 10, take_over, numbers, 0);
	for (int i = 0; i < COUNT; i++)
		if (stilb_job_queue_push(queue, &numbers[i], 0))
			return 1;
	while (stilb_job_queue_pop(queue, &item, 0) == 0)
		if (stilb_job_spsc_push(spsc, item))
			return 1;
	while (stilb_job_spsc_pop(spsc, &item) == 0)
		sum += *(uint32_t *)item;
	stilb_job_spsc_destroy(spsc);
	stilb_job_queue_destroy(queue);
	stilb_job_pool_destroy(pool);
	printf("sum %u\n", sum);
	return 0;
}
