/*
 * A bounded queue whose ends wait for each other: loaders push pictures, and sleep while four of them lie in the queue;
 * one thread pops them, and sleeps while there are none. close tells it that no more will come.
 *
 * Prints: 200 pictures, never more than 4 in the queue
 */
#include <stilb/job_queue.h>

#include <pthread.h>
#include <stdio.h>

enum { LOADERS = 2, EACH = 100, MOST = 4 };

typedef struct loader {
	pthread_t thread;
	stilb_job_queue *queue;
	uint32_t number; /* of this thread, below thread_count: an argument of every call of the queue */
	int pictures[EACH];
} loader;

static void *load(void *data)
{
	loader *self = data;
	for (int i = 0; i < EACH; i++)
		if (stilb_job_queue_push_wait(self->queue, &self->pictures[i], self->number, UINT64_MAX) != 0)
			break; /* closed */
	return NULL;
}

static void *show(void *data)
{
	static int shown;
	void *picture;
	/* A timeout instead of UINT64_MAX would give the thread something to do when nothing arrives: -ETIMEDOUT. */
	while (stilb_job_queue_pop_wait(data, &picture, LOADERS, UINT64_MAX) == 0)
		shown++;
	return &shown;
}

int main(void)
{
	stilb_job_queue_desc desc = stilb_job_queue_desc_default();
	desc.capacity = MOST;
	desc.thread_count = LOADERS + 1;
	stilb_job_queue *queue;
	if (stilb_job_queue_create(&desc, &queue) != 0)
		return 1;
	static loader loaders[LOADERS];
	pthread_t viewer;
	if (pthread_create(&viewer, NULL, show, queue) != 0)
		return 1;
	for (uint32_t i = 0; i < LOADERS; i++) {
		loaders[i].queue = queue;
		loaders[i].number = i;
		if (pthread_create(&loaders[i].thread, NULL, load, &loaders[i]) != 0)
			return 1;
	}

	for (uint32_t i = 0; i < LOADERS; i++)
		pthread_join(loaders[i].thread, NULL);
	stilb_job_queue_close(queue);
	void *shown;
	pthread_join(viewer, &shown);
	stilb_job_queue_destroy(queue);
	printf("%d pictures, never more than %d in the queue\n", *(int *)shown, MOST);
	return 0;
}
