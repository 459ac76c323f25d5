/*
 * Several producers and consumers on one queue. The producers' end is signalled with close: pushes are
 * refused from then on, and consumers pop what is left and then get -EPIPE.
 *
 * Prints: 20000 items, sum 200010000
 */
#include <stilb/job_queue.h>

#include <errno.h>
#include <pthread.h>
#include <sched.h>
#include <stdio.h>

enum { PRODUCERS = 2, CONSUMERS = 2, EACH = 10000 };

typedef struct member {
	pthread_t thread;
	stilb_job_queue *queue;
	uint32_t number; /* of this thread, below thread_count: an argument of every call of the queue */
	uint64_t *items, count, sum;
} member;

static void *produce(void *data)
{
	member *self = data;
	for (int i = 0; i < EACH; i++)
		if (stilb_job_queue_push(self->queue, &self->items[i], self->number) == 0)
			self->count++;
	return NULL;
}

static void *consume(void *data)
{
	member *self = data;
	void *item;
	int error;
	while ((error = stilb_job_queue_pop(self->queue, &item, self->number)) != -EPIPE) {
		if (error == -EAGAIN) { /* empty, but more may come */
			sched_yield();
			continue;
		}
		self->sum += *(uint64_t *)item;
		self->count++;
	}
	return NULL;
}

int main(void)
{
	static uint64_t items[PRODUCERS * EACH];
	for (uint64_t i = 0; i < PRODUCERS * EACH; i++)
		items[i] = i + 1;

	member members[PRODUCERS + CONSUMERS] = {0};
	stilb_job_queue_desc desc = stilb_job_queue_desc_default();
	desc.thread_count = PRODUCERS + CONSUMERS;
	stilb_job_queue *queue;
	if (stilb_job_queue_create(&desc, &queue) != 0)
		return 1;
	for (uint32_t i = 0; i < PRODUCERS + CONSUMERS; i++) {
		members[i] = (member){.queue = queue, .number = i, .items = &items[i < PRODUCERS ? i * EACH : 0]};
		if (pthread_create(&members[i].thread, NULL, i < PRODUCERS ? produce : consume, &members[i]) != 0)
			return 1;
	}

	uint64_t count = 0, sum = 0;
	for (uint32_t i = 0; i < PRODUCERS + CONSUMERS; i++) {
		if (i == PRODUCERS)
			stilb_job_queue_close(queue); /* the producers have been joined */
		pthread_join(members[i].thread, NULL);
		count += i < PRODUCERS ? 0 : members[i].count;
		sum += members[i].sum;
	}
	stilb_job_queue_destroy(queue);
	printf("%llu items, sum %llu\n", (unsigned long long)count, (unsigned long long)sum);
	return 0;
}
