// A subject of the suite `queue`: boost::lockfree::queue, unbounded; QUEUE_LOAD_BOUNDED nodes are allocated in advance.
#include <boost/lockfree/queue.hpp>

typedef boost::lockfree::queue<void *> *subject_queue;
typedef char subject_thread;
#define SUBJECT_BATCH 0
#include "bench/queue/queue_load.h"

static void subject_open(subject_queue *queue, const queue_load *)
{
	*queue = new boost::lockfree::queue<void *>(QUEUE_LOAD_BOUNDED);
}

static void subject_enter(subject_queue *, subject_thread *, uint32_t)
{
}

static inline bool subject_push(subject_queue *queue, subject_thread *, void *item)
{
	return (*queue)->push(item);
}

static inline bool subject_pop(subject_queue *queue, subject_thread *, void **item)
{
	return (*queue)->pop(*item);
}

int main(int argc, char **argv)
{
	return queue_load_main(argc, argv);
}
