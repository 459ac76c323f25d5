/* Stands in for stilb-bench-queue-own, the benchmark program of the queues named below, with faults that the check of
 * queue_load.h must notice: sutter returns an item twice, stilb-low-lock loses an item, stilb-lock-free changes an
 * item, which only the sums of the items show. mutex has no fault. */
#include <stdint.h>

typedef struct subject_queue {
	struct stilb_job_queue *queue;
	uint64_t pops; /* counted by the only consumer */
	char fault;    /* '1': an item comes twice, '0': one is lost, '~': one is changed, ' ': no fault */
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
