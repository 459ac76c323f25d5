/* A subject of the suite `queue`: stilb_job_spsc, Stilb's queue for a single producer and a single consumer. */
#include "jobs/job_spsc.h"

typedef stilb_job_spsc *subject_queue;
typedef char subject_thread;
#define SUBJECT_BATCH 0
#include "bench/queue/queue_load.h"

static void subject_open(subject_queue *queue, const queue_load *load)
{
	if (load->producers != 1 || load->consumers != 1)
		exit(BENCH_CHILD_SKIP);
	if (stilb_job_spsc_create(queue) != 0)
		bench_child_fail("cannot create the queue: out of memory");
}

static void subject_enter(subject_queue *queue, subject_thread *self, uint32_t thread)
{
	(void)queue, (void)self, (void)thread;
}

static inline bool subject_push(subject_queue *queue, subject_thread *self, void *item)
{
	(void)self;
	if (stilb_job_spsc_push(*queue, item) != 0)
		bench_child_fail("push: out of memory");
	return true;
}

static inline bool subject_pop(subject_queue *queue, subject_thread *self, void **item)
{
	(void)self;
	return stilb_job_spsc_pop(*queue, item) == 0;
}

int main(int argc, char **argv)
{
	return queue_load_main(argc, argv);
}
