// Two subjects of the suite `queue`: moodycamel::ConcurrentQueue; with MOODYCAMEL_TOKENS 1 every thread has a token,
// the library's object for a thread's faster access to the queue, and batches use the bulk calls.
#include <concurrentqueue/concurrentqueue.h>

typedef moodycamel::ConcurrentQueue<void *> queue_type;
typedef queue_type *subject_queue;
#define SUBJECT_BATCH MOODYCAMEL_TOKENS

#if MOODYCAMEL_TOKENS

struct subject_thread {
	moodycamel::ProducerToken *producer;
	moodycamel::ConsumerToken *consumer;
};
#include "bench/queue/queue_load.h"

static void subject_enter(subject_queue *queue, subject_thread *self, uint32_t thread)
{
	if (thread < load_setup.producers)
		self->producer = new moodycamel::ProducerToken(**queue);
	else
		self->consumer = new moodycamel::ConsumerToken(**queue);
}

static inline bool subject_push(subject_queue *queue, subject_thread *self, void *item)
{
	return (*queue)->enqueue(*self->producer, item);
}

static inline bool subject_pop(subject_queue *queue, subject_thread *self, void **item)
{
	return (*queue)->try_dequeue(*self->consumer, *item);
}

static inline size_t subject_push_n(subject_queue *queue, subject_thread *self, void **items, size_t count)
{
	return (*queue)->enqueue_bulk(*self->producer, items, count) ? count : 0;
}

static inline size_t subject_pop_n(subject_queue *queue, subject_thread *self, void **items, size_t count)
{
	return (*queue)->try_dequeue_bulk(*self->consumer, items, count);
}

#else

typedef char subject_thread;
#include "bench/queue/queue_load.h"

static void subject_enter(subject_queue *, subject_thread *, uint32_t)
{
}

static inline bool subject_push(subject_queue *queue, subject_thread *, void *item)
{
	return (*queue)->enqueue(item);
}

static inline bool subject_pop(subject_queue *queue, subject_thread *, void **item)
{
	return (*queue)->try_dequeue(*item);
}

#endif

static void subject_open(subject_queue *queue, const queue_load *)
{
	*queue = new queue_type;
}

int main(int argc, char **argv)
{
	return queue_load_main(argc, argv);
}
