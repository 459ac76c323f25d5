/* The queue of queue_mutex.c (a linked list) behind a second lock, which enters the kernel for every lock and unlock,
 * as Windows' mutex objects do and uncontended pthread mutexes do not: a binary semaphore in an eventfd. */
#include "bench/subjects/queue_subjects.h"

#include <errno.h>
#include <stdlib.h>
#include <sys/eventfd.h>
#include <unistd.h>

typedef struct kernel_queue {
	stilb_job_queue base;
	stilb_job_queue *inner;
	int lock;
} kernel_queue;

static kernel_queue *lock(stilb_job_queue *base)
{
	kernel_queue *queue = (kernel_queue *)base;
	eventfd_t taken;
	while (eventfd_read(queue->lock, &taken) != 0) { /* again if a signal interrupted the read */
	}
	return queue;
}

static void unlock(kernel_queue *queue)
{
	while (eventfd_write(queue->lock, 1) != 0) {
	}
}

static int kernel_push_n(stilb_job_queue *base, void *const *items, size_t count, uint32_t thread)
{
	kernel_queue *queue = lock(base);
	int result = queue->inner->ops->push_n(queue->inner, items, count, thread);
	unlock(queue);
	return result;
}

static int kernel_push(stilb_job_queue *base, void *item, uint32_t thread)
{
	kernel_queue *queue = lock(base);
	int result = queue->inner->ops->push(queue->inner, item, thread);
	unlock(queue);
	return result;
}

static int kernel_pop_n(stilb_job_queue *base, void **items, size_t max, uint32_t thread)
{
	kernel_queue *queue = lock(base);
	int result = queue->inner->ops->pop_n(queue->inner, items, max, thread);
	unlock(queue);
	return result;
}

static int kernel_pop(stilb_job_queue *base, void **item, uint32_t thread)
{
	kernel_queue *queue = lock(base);
	int result = queue->inner->ops->pop(queue->inner, item, thread);
	unlock(queue);
	return result;
}

static bool kernel_empty(stilb_job_queue *base, uint32_t thread)
{
	kernel_queue *queue = lock(base);
	bool result = queue->inner->ops->empty(queue->inner, thread);
	unlock(queue);
	return result;
}

static void kernel_close(stilb_job_queue *base)
{
	kernel_queue *queue = lock(base);
	queue->inner->ops->close(queue->inner);
	unlock(queue);
}

static void kernel_rest(stilb_job_queue *base, uint32_t thread)
{
	(void)base, (void)thread;
}

static void kernel_destroy(stilb_job_queue *base)
{
	kernel_queue *queue = (kernel_queue *)base;
	stilb_job_queue_destroy(queue->inner);
	if (queue->lock >= 0)
		close(queue->lock);
	free(queue);
}

int queue_kernel_create(const stilb_job_queue_desc *desc, stilb_job_queue **queue)
{
	static const job_queue_ops ops = {kernel_push,  kernel_push_n, kernel_pop,  kernel_pop_n,
	                                  kernel_empty, kernel_close,  kernel_rest, kernel_destroy};
	kernel_queue *made = malloc(sizeof *made);
	*queue = NULL;
	if (!made)
		return -ENOMEM;
	*made = (kernel_queue){.base.ops = &ops, .lock = eventfd(1, EFD_SEMAPHORE | EFD_CLOEXEC)};
	int error = made->lock < 0 ? -errno : queue_mutex_create(desc, &made->inner);
	if (error) {
		kernel_destroy(&made->base);
		return error;
	}
	*queue = &made->base;
	return 0;
}
