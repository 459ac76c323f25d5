/* In place of stilb-bench-queue-own: what the load must notice. mutex is right; sutter hands one item out twice;
 * stilb-low-lock loses one; stilb-lock-free swaps one for another: the number is right and the items are not. */
#include <stdint.h>

typedef struct subject_queue {
	struct stilb_job_queue *queue;
	uint64_t pops; /* counted by one consumer: all cases here have one */
	char fault;    /* '1' again, '0' lost, '~' swapped, ' ' none */
} subject_queue;

typedef char subject_thread;
#define SUBJECT_BATCH 0
#include "bench/queue/queue_load.h"

#include "bench/subjects/queue_subjects.h"

#define FAULTY_POP 1000

static void subject_open(subject_queue *subject, const queue_load *load)
{
	stilb_job_queue_desc desc = stilb_job_queue_desc_default();
	if (load->consumers != 1 || queue_mutex_create(&desc, &subject->queue) != 0)
		exit(BENCH_CHILD_SKIP);
	subject->fault = strcmp(load->subject, "sutter") == 0            ? '1'
	                 : strcmp(load->subject, "stilb-low-lock") == 0  ? '0'
	                 : strcmp(load->subject, "stilb-lock-free") == 0 ? '~'
	                                                                 : ' ';
}

static void subject_enter(subject_queue *subject, subject_thread *self, uint32_t thread)
{
	(void)subject, (void)self, (void)thread;
}

static inline bool subject_push(subject_queue *subject, subject_thread *self, void *item)
{
	(void)self;
	return stilb_job_queue_push(subject->queue, item, 0) == 0;
}

static inline bool subject_pop(subject_queue *subject, subject_thread *self, void **item)
{
	static void *last;
	(void)self;
	bool now = subject->pops == FAULTY_POP;
	if (now && subject->fault == '1') {
		*item = last;
	} else {
		if (now && subject->fault == '0' && stilb_job_queue_pop(subject->queue, item, 0) != 0)
			return false;
		if (stilb_job_queue_pop(subject->queue, item, 0) != 0)
			return false;
		last = *item;
		if (now && subject->fault == '~')
			*item = (void *)((uint64_t)last ^ 1);
	}
	subject->pops++;
	return true;
}

int main(int argc, char **argv)
{
	return queue_load_main(argc, argv);
}
