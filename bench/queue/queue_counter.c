/* The subject `counter` of the suite `queue`, which is no queue: every push and every pop is an atomic add to one
 * number that all threads share. An upper bound of the throughput of every queue that writes a shared word in each
 * call, and a measure of how steady the machine is. */
#include <stdint.h>

typedef uint64_t subject_queue;
typedef char subject_thread;
#define SUBJECT_BATCH 0
#define SUBJECT_ENDLESS
#include "bench/queue/queue_load.h"

static void subject_open(subject_queue *queue, const queue_load *load)
{
	(void)queue, (void)load;
}

static void subject_enter(subject_queue *queue, subject_thread *self, uint32_t thread)
{
	(void)queue, (void)self, (void)thread;
}

static inline bool subject_push(subject_queue *queue, subject_thread *self, void *item)
{
	(void)self, (void)item;
	__atomic_fetch_add(queue, 1, __ATOMIC_RELAXED); /* relaxed: read after the threads were joined */
	return true;
}

static inline bool subject_pop(subject_queue *queue, subject_thread *self, void **item)
{
	(void)self;
	*item = (void *)__atomic_fetch_add(queue, 1, __ATOMIC_RELAXED); /* relaxed: as in subject_push */
	return true;
}

static bool subject_verify(subject_queue *queue, uint64_t pushes, uint64_t pops)
{
	return *queue == pushes + pops;
}

int main(int argc, char **argv)
{
	return queue_load_main(argc, argv);
}
