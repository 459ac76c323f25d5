/* Subjects of the suite `queue` with the interface stilb_job_queue: Stilb's two kinds of queue, and Sutter's and the
 * mutex queue of bench/subjects. */
#include "bench/subjects/queue_subjects.h"

#include <errno.h>

typedef stilb_job_queue *subject_queue;
typedef uint32_t subject_thread; /* the thread's index, which stilb_job_queue asks for */
#define SUBJECT_BATCH 1
#include "bench/queue/queue_load.h"

static void subject_open(subject_queue *queue, const queue_load *load)
{
	stilb_job_queue_desc desc = stilb_job_queue_desc_default();
	desc.thread_count = load->threads;
	int error;
	if (strcmp(load->subject, "sutter") == 0) {
		error = queue_sutter_create(&desc, queue);
	} else if (strcmp(load->subject, "mutex") == 0) {
		error = queue_mutex_create(&desc, queue);
	} else {
		bool lock_free = strcmp(load->subject, "stilb-lock-free") == 0;
		desc.kind = lock_free ? STILB_JOB_QUEUE_LOCK_FREE : STILB_JOB_QUEUE_LOW_LOCK;
		error = stilb_job_queue_create(&desc, queue);
	}
	if (error)
		bench_child_fail("cannot create %s: %s", load->subject, strerror(-error));
}

static void subject_enter(subject_queue *queue, subject_thread *self, uint32_t thread)
{
	(void)queue;
	*self = thread;
}

static inline bool subject_push(subject_queue *queue, subject_thread *self, void *item)
{
	int error = stilb_job_queue_push(*queue, item, *self);
	if (error && error != -EAGAIN)
		bench_child_fail("push: %s", strerror(-error));
	return error == 0;
}

static inline bool subject_pop(subject_queue *queue, subject_thread *self, void **item)
{
	return stilb_job_queue_pop(*queue, item, *self) == 0;
}

static inline size_t subject_push_n(subject_queue *queue, subject_thread *self, void **items, size_t count)
{
	int done = stilb_job_queue_push_n(*queue, items, count, *self);
	if (done < 0 && done != -EAGAIN)
		bench_child_fail("push_n: %s", strerror(-done));
	return done < 0 ? 0 : (size_t)done;
}

static inline size_t subject_pop_n(subject_queue *queue, subject_thread *self, void **items, size_t count)
{
	int done = stilb_job_queue_pop_n(*queue, items, count, *self);
	return done < 0 ? 0 : (size_t)done;
}

int main(int argc, char **argv)
{
	return queue_load_main(argc, argv);
}
