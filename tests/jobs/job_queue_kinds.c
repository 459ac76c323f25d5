#include "job_queue_kinds.h"

#include <stddef.h>
#include <stdint.h>

#include "bench/subjects/queue_subjects.h"
#include "support/test.h"

static int create_low_lock(const stilb_job_queue_desc *desc, stilb_job_queue **queue)
{
	stilb_job_queue_desc low_lock = *desc;
	low_lock.kind = STILB_JOB_QUEUE_LOW_LOCK;
	return stilb_job_queue_create(&low_lock, queue);
}

static int create_lock_free(const stilb_job_queue_desc *desc, stilb_job_queue **queue)
{
	stilb_job_queue_desc lock_free = *desc;
	lock_free.kind = STILB_JOB_QUEUE_LOCK_FREE;
	return stilb_job_queue_create(&lock_free, queue);
}

const queue_kind queue_kinds[QUEUE_KINDS] = {
	{.name = "low-lock", .create = create_low_lock, .bounded = true, .whole_pushes = true, .recycles = true},
	{.name = "lock-free", .create = create_lock_free, .bounded = true, .recycles = true, .lock_free = true},
	{.name = "sutter", .create = queue_sutter_create},
	{.name = "mutex", .create = queue_mutex_create, .bounded = true},
};

stilb_job_queue *queue_kind_create(const queue_kind *kind, size_t capacity, uint32_t thread_count)
{
	stilb_job_queue *queue = NULL;
	stilb_job_queue_desc desc = {.capacity = capacity, .thread_count = thread_count};
	assert_int_equal(kind->create(&desc, &queue), 0);
	assert_non_null(queue);
	return queue;
}
