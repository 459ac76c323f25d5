#include "jobs/job_allocate.h"
#include "jobs/job_contract.h"
#include "jobs/queue/job_queue_internal.h"

#include <errno.h>

stilb_job_queue_desc stilb_job_queue_desc_default(void)
{
	return (stilb_job_queue_desc){
		.kind = STILB_JOB_QUEUE_LOW_LOCK, .capacity = SIZE_MAX, .thread_count = STILB_JOB_QUEUE_MAX_THREADS};
}

int stilb_job_queue_create(const stilb_job_queue_desc *desc, stilb_job_queue **queue)
{
	assert(desc && queue);
	*queue = NULL;
	if (desc->capacity == 0 || desc->thread_count == 0 || desc->thread_count > STILB_JOB_QUEUE_MAX_THREADS ||
	    !job_allocator_is_whole(desc->allocator))
		return -EINVAL;
	switch (desc->kind) {
	case STILB_JOB_QUEUE_LOW_LOCK:
		return job_queue_low_lock_create(desc, queue);
	case STILB_JOB_QUEUE_LOCK_FREE:
		return job_queue_lock_free_create(desc, queue);
	}
	return -EINVAL;
}

/* For asserts: no call is waiting. */
static bool nobody_waits(stilb_job_queue *queue)
{
	/* Relaxed, both: no other call is in progress. */
	return atomic_load_explicit(&queue->items.waiters, memory_order_relaxed) == 0 &&
	       atomic_load_explicit(&queue->space.waiters, memory_order_relaxed) == 0;
}

void stilb_job_queue_destroy(stilb_job_queue *queue)
{
	if (!queue)
		return;
	JOB_CHECK(nobody_waits(queue));
	queue->ops->destroy(queue);
}

int stilb_job_queue_push(stilb_job_queue *queue, void *item, uint32_t thread)
{
	assert(queue);
	return item ? queue->ops->push(queue, item, thread) : -EINVAL;
}

int stilb_job_queue_push_n(stilb_job_queue *queue, void *const *items, size_t count, uint32_t thread)
{
	assert(queue && (items || count == 0));
	if (count > INT32_MAX)
		return -EINVAL;
	for (size_t i = 0; i < count; i++)
		if (!items[i])
			return -EINVAL;
	return count == 0 ? 0 : queue->ops->push_n(queue, items, count, thread);
}

int stilb_job_queue_pop(stilb_job_queue *queue, void **item, uint32_t thread)
{
	assert(queue && item);
	return queue->ops->pop(queue, item, thread);
}

int stilb_job_queue_pop_n(stilb_job_queue *queue, void **items, size_t max, uint32_t thread)
{
	assert(queue && (items || max == 0));
	size_t most = max < INT32_MAX ? max : INT32_MAX;
	return max == 0 ? 0 : queue->ops->pop_n(queue, items, most, thread);
}

/* The arguments of a call that waits. */
typedef struct waiting_call {
	stilb_job_queue *queue;
	void **item;
	uint32_t thread;
} waiting_call;

static int push_again(void *context)
{
	const waiting_call *call = context;
	return stilb_job_queue_push(call->queue, *call->item, call->thread);
}

int stilb_job_queue_push_wait(stilb_job_queue *queue, void *item, uint32_t thread, uint64_t timeout_ns)
{
	int error = stilb_job_queue_push(queue, item, thread);
	if (error != -EAGAIN)
		return error;
	return job_event_wait(&queue->space, push_again, &(waiting_call){queue, &item, thread}, timeout_ns);
}

static int pop_again(void *context)
{
	const waiting_call *call = context;
	return stilb_job_queue_pop(call->queue, call->item, call->thread);
}

int stilb_job_queue_pop_wait(stilb_job_queue *queue, void **item, uint32_t thread, uint64_t timeout_ns)
{
	int error = stilb_job_queue_pop(queue, item, thread);
	if (error != -EAGAIN)
		return error;
	return job_event_wait(&queue->items, pop_again, &(waiting_call){queue, item, thread}, timeout_ns);
}

bool stilb_job_queue_empty(stilb_job_queue *queue, uint32_t thread)
{
	assert(queue);
	return queue->ops->empty(queue, thread);
}

void stilb_job_queue_close(stilb_job_queue *queue)
{
	assert(queue);
	queue->ops->close(queue);
	job_event_signal(&queue->items, JOB_EVENT_ALL);
	job_event_signal(&queue->space, JOB_EVENT_ALL);
}

void stilb_job_queue_rest(stilb_job_queue *queue, uint32_t thread)
{
	assert(queue);
	queue->ops->rest(queue, thread);
}
