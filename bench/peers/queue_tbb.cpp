// A subject of the suite `queue`: oneTBB's tbb::concurrent_queue, unbounded.
#include <tbb/concurrent_queue.h>

typedef tbb::concurrent_queue<void *> *subject_queue;
typedef char subject_thread;
#define SUBJECT_BATCH 0
#include "bench/queue/queue_load.h"

static void subject_open(subject_queue *queue, const queue_load *)
{
	*queue = new tbb::concurrent_queue<void *>;
}

static void subject_enter(subject_queue *, subject_thread *, uint32_t)
{
}

static inline bool subject_push(subject_queue *queue, subject_thread *, void *item)
{
	(*queue)->push(item);
	return true;
}

static inline bool subject_pop(subject_queue *queue, subject_thread *, void **item)
{
	return (*queue)->try_pop(*item);
}

int main(int argc, char **argv)
{
	return queue_load_main(argc, argv);
}
