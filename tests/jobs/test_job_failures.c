/* Wrong use and failures: the pool refuses invalid calls, loses no job when memory or threads run out, and works again
 * afterwards. Also pools that are created and destroyed many times. */
#include "job_pool_fixture.h"

#include <errno.h>
#include <stdlib.h>

/* ---- failures on demand; linked with -Wl,--wrap= of each of these ------------------------------------------------ */

/* The number of calls that succeed before all later ones fail. Relaxed: the counters order nothing. */
static _Atomic int64_t allocations_to_grant = INT64_MAX;
static _Atomic int64_t blocks;
static _Atomic int64_t threads_to_grant = INT64_MAX;

static bool granted(_Atomic int64_t *left)
{
	return atomic_fetch_sub_explicit(left, 1, memory_order_relaxed) > 0;
}

static void grant_allocations(int64_t count)
{
	atomic_store_explicit(&allocations_to_grant, count, memory_order_relaxed);
}

static void *counted(void *block)
{
	if (block)
		atomic_fetch_add_explicit(&blocks, 1, memory_order_relaxed);
	return block;
}

void *__real_malloc(size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_malloc(size_t size)
{
	return granted(&allocations_to_grant) ? counted(__real_malloc(size)) : NULL;
}

void *__real_calloc(size_t count, size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_calloc(size_t count, size_t size)
{
	return granted(&allocations_to_grant) ? counted(__real_calloc(count, size)) : NULL;
}

void *__real_aligned_alloc(size_t alignment, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size)
{
	return granted(&allocations_to_grant) ? counted(__real_aligned_alloc(alignment, size)) : NULL;
}

void __real_free(void *block);
void __wrap_free(void *block);
void __wrap_free(void *block)
{
	if (block)
		atomic_fetch_sub_explicit(&blocks, 1, memory_order_relaxed);
	__real_free(block);
}

int __real_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*fn)(void *), void *data);
int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*fn)(void *), void *data);
int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*fn)(void *), void *data)
{
	return granted(&threads_to_grant) ? __real_pthread_create(thread, attributes, fn, data) : EAGAIN;
}

/* ---- refused calls --------------------------------------------------------------------------------------------- */

typedef struct work {
	stilb_job_pool *pool;
	stilb_job_group group;
	counter ran, wrong;
	counter accepted, refused;
	counter starts, stops; /* hooks start and stop of workers */
} work;

static void count_job(void *data, uint32_t worker)
{
	work *w = data;
	(void)worker;
	count_up(&w->ran);
}

static void do_nothing(void *data, uint32_t worker)
{
	(void)data;
	(void)worker;
}

static void count_slice(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	for (; begin < end; begin++)
		count_job(context, worker);
}

static void check_refused(stilb_job_pool_desc desc, int expected)
{
	stilb_job_pool *pool = (stilb_job_pool *)&desc;
	int64_t before = blocks;
	assert_int_equal(stilb_job_pool_create(&desc, &pool), expected);
	assert_null(pool);
	assert_int_equal(blocks, before);
}

static void test_create_refuses(void **state)
{
	(void)state;
	check_refused((stilb_job_pool_desc){.worker_count = STILB_JOB_MAX_WORKERS + 1}, -EINVAL);
	check_refused((stilb_job_pool_desc){.worker_count = 10000}, -EINVAL);
	check_refused((stilb_job_pool_desc){.worker_count = UINT32_MAX}, -EINVAL);
	check_refused((stilb_job_pool_desc){.queue = (stilb_job_queue_kind)2}, -EINVAL);
	check_refused((stilb_job_pool_desc){.queue = (stilb_job_queue_kind)-1}, -EINVAL);
	check_refused((stilb_job_pool_desc){.affinity = (stilb_job_affinity)3}, -EINVAL);
	check_refused((stilb_job_pool_desc){.affinity = (stilb_job_affinity)-1}, -EINVAL);
}

static void test_most_workers(void **state)
{
	(void)state;
	for (int queue = 0; queue < 2; queue++) {
		work w = {.pool = pool_with((shape){.workers = STILB_JOB_MAX_WORKERS, .queue = (stilb_job_queue_kind)queue})};
		for (int i = 0; i < 1000; i++)
			assert_int_equal(stilb_job_submit(w.pool, count_job, &w, &w.group, 0), 0);
		stilb_job_wait(w.pool, &w.group, 0);
		assert_int_equal(w.ran, 1000);
		stilb_job_pool_destroy(w.pool);
	}
}

static void test_submit_refuses(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		work w = {.pool = pool_with(s)};
		const stilb_job_options bad[] = {{.priority = (stilb_job_priority)3},
		                                 {.priority = (stilb_job_priority)-1},
		                                 {.pinned = true, .target = s.workers + 1},
		                                 {.pinned = true, .target = STILB_JOB_OUTSIDE},
		                                 {.after = &w.group}}; /* the job would wait for itself */
		for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
			for (int outside = 0; outside < 2; outside++)
				assert_int_equal(
					stilb_job_submit_with(w.pool, count_job, &w, &w.group, &bad[i], outside ? STILB_JOB_OUTSIDE : 0),
					-EINVAL);
		assert_int_equal(w.group.state, 0);
		stilb_job_options unused_target = {.target = 10000}; /* ignored, since the job is not pinned */
		assert_int_equal(stilb_job_submit_with(w.pool, count_job, &w, &w.group, &unused_target, 0), 0);
		stilb_job_wait(w.pool, &w.group, 0);
		assert_int_equal(w.ran, 1);
		stilb_job_pool_destroy(w.pool);
	}
}

/* ---- out of threads, out of memory ----------------------------------------------------------------------------- */

static void on_start(void *user, uint32_t worker)
{
	work *w = user;
	(void)worker;
	count_up(&w->starts);
}

static void on_stop(void *user, uint32_t worker)
{
	work *w = user;
	(void)worker;
	count_up(&w->stops);
}

static stilb_job_pool_desc desc_of(shape s, work *w)
{
	return (stilb_job_pool_desc){.worker_count = s.workers,
	                             .queue = s.queue,
	                             .hooks = {.user = w, .thread_start = on_start, .thread_stop = on_stop}};
}

static void check_works(const stilb_job_pool_desc *desc, work *w)
{
	assert_int_equal(stilb_job_pool_create(desc, &w->pool), 0);
	assert_int_equal(stilb_job_submit(w->pool, count_job, w, &w->group, 0), 0);
	stilb_job_wait(w->pool, &w->group, 0);
	stilb_job_pool_destroy(w->pool);
	assert_int_equal(w->ran, 1);
}

static void test_create_without_threads(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		for (uint32_t threads = 0; threads < s.workers; threads++) {
			work w = {0};
			atomic_store_explicit(&threads_to_grant, threads, memory_order_relaxed);
			check_refused(desc_of(s, &w), -EAGAIN);
			atomic_store_explicit(&threads_to_grant, INT64_MAX, memory_order_relaxed);
			assert_int_equal(w.starts, threads); /* the threads that had started were joined */
			assert_int_equal(w.stops, threads);
		}
		work w = {0};
		stilb_job_pool_desc desc = desc_of(s, &w);
		check_works(&desc, &w);
	}
}

static void test_create_without_memory(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		int64_t before = blocks, allocations = 0;
		for (;; allocations++) {
			work w = {0};
			stilb_job_pool_desc desc = desc_of(s, &w);
			stilb_job_pool *pool = (stilb_job_pool *)&desc;
			grant_allocations(allocations);
			int error = stilb_job_pool_create(&desc, &pool);
			grant_allocations(INT64_MAX);
			if (error == 0) {
				stilb_job_pool_destroy(pool);
				break;
			}
			assert_int_equal(error, -ENOMEM);
			assert_null(pool);
			assert_int_equal(w.starts, 0);
			assert_int_equal(blocks, before);
		}
		assert_in_range(allocations, 3 + s.workers, 1000); /* the pool, two queues, a deque for each thread */
		assert_int_equal(blocks, before);
		work w = {0};
		stilb_job_pool_desc desc = desc_of(s, &w);
		check_works(&desc, &w);
	}
}

enum { SUBMITS = 1000 };

/* Submits jobs in every way, and counts the calls that succeeded. */
static void submit_all(work *w, uint32_t thread)
{
	const stilb_job_options options[] = {{.priority = STILB_JOB_HIGH},
	                                     {.priority = STILB_JOB_LOW},
	                                     {.pinned = true, .target = stilb_job_pool_worker_count(w->pool)}};
	for (uint32_t i = 0; i < SUBMITS; i++) {
		int error;
		if (i % 5 < 3)
			error = stilb_job_submit_with(w->pool, count_job, w, &w->group, &options[i % 5], thread);
		else if (i % 5 == 3)
			error = stilb_job_submit_array(w->pool, 1, 1, count_slice, w, &w->group, thread);
		else
			error = stilb_job_submit(w->pool, count_job, w, &w->group, thread);
		if (error == 0)
			count_up(&w->accepted);
		else if (error == -ENOMEM)
			count_up(&w->refused);
		else
			count_up(&w->wrong);
	}
}

static void *submit_from_outside(void *data)
{
	submit_all(data, STILB_JOB_OUTSIDE);
	return NULL;
}

static void submit_from_job(void *data, uint32_t worker)
{
	submit_all(data, worker);
}

/* With little memory some jobs get a record but no place in a queue, and others no record. Accepted jobs must run once,
 * refused ones never. */
static void check_submits(shape s, int64_t allocations, int from)
{
	int64_t before = blocks;
	work w = {.pool = pool_with(s)};
	blocker b = {0};
	stilb_job_group outer = {0};
	hold_workers(w.pool, &b, &outer, 1, s.workers - (s.workers > 0));
	submit_pinned(w.pool, do_nothing, NULL, &w.group, 0, 0); /* so that the owner has free records */
	stilb_job_run_pinned(w.pool, 0);
	grant_allocations(allocations);
	if (from == 0)
		submit_all(&w, 0);
	else if (from == 1)
		outside_run(submit_from_outside, &w);
	else
		submit_pinned(w.pool, submit_from_job, &w, &outer, s.workers, 0);
	blocker_release(&b);
	stilb_job_wait(w.pool, &outer, 0);
	grant_allocations(INT64_MAX);
	stilb_job_wait(w.pool, &w.group, 0); /* would hang if a refused job was counted */
	assert_int_equal(w.ran, w.accepted);
	assert_int_equal(w.accepted + w.refused, SUBMITS);
	assert_true(w.refused > 0 || allocations > 0);
	assert_int_equal(w.wrong, 0);
	assert_int_equal(w.group.state, 0);
	uint32_t so_far = w.ran;
	submit_all(&w, 0); /* memory is available again */
	stilb_job_wait(w.pool, &w.group, 0);
	assert_int_equal(w.ran, so_far + SUBMITS);
	stilb_job_pool_destroy(w.pool);
	assert_int_equal(blocks, before);
}

static void test_submit_without_memory(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s))
		for (int from = 0; from < 3; from++)
			for (int64_t allocations = 0; allocations < 20; allocations += 1 + allocations / 2)
				check_submits(s, allocations, from);
}

static uint64_t no_tag(void *user, uint32_t worker)
{
	(void)user, (void)worker;
	return 0;
}

/* Either all jobs of a batch are accepted or none; records that were taken in vain are used again. With tags, each job
 * needs a record. */
static void test_submit_n_without_memory(void **state)
{
	(void)state;
	enum { JOBS = 1000 };
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s))
		for (int64_t allocations = 0; allocations < 30; allocations += TEST_TSAN || TEST_EMULATED ? 3 : 1) {
			int64_t before = blocks;
			stilb_job_hooks hooks = {.submit = allocations % 4 < 2 ? no_tag : NULL};
			work w = {.pool = pool_with_hooks(s, hooks)};
			uint32_t worker = allocations % 2 ? STILB_JOB_OUTSIDE : 0;
			grant_allocations(allocations);
			int error = stilb_job_submit_n(w.pool, count_job, &w, 0, JOBS, &w.group, worker);
			int64_t left = allocations_to_grant;
			grant_allocations(INT64_MAX);
			assert_true(error == 0 || (error == -ENOMEM && left < 0));
			stilb_job_wait(w.pool, &w.group, 0); /* would hang if a refused job was counted */
			assert_int_equal(w.ran, error ? 0 : JOBS);
			assert_int_equal(stilb_job_submit_n(w.pool, count_job, &w, 0, JOBS, &w.group, worker), 0);
			stilb_job_wait(w.pool, &w.group, 0);
			assert_int_equal(w.ran, error ? JOBS : 2 * JOBS);
			stilb_job_pool_destroy(w.pool);
			assert_int_equal(blocks, before);
		}
}

static void *loop_outside(void *data)
{
	work *w = data;
	stilb_job_parallel_for(w->pool, 1000, 1, count_slice, w, STILB_JOB_OUTSIDE);
	return NULL;
}

/* A loop of an outside thread waits for memory, and then runs once. */
static void test_outside_loop_without_memory(void **state)
{
	(void)state;
	work w = {.pool = pool_with((shape){.workers = 1})};
	pthread_t thread;
	assert_int_equal(pthread_create(&thread, NULL, loop_outside, &w), 0);
	pthread_join(thread, NULL); /* so that the C library has its memory for threads */
	assert_int_equal(count_of(&w.ran), 1000);
	stilb_job_pool_destroy(w.pool);
	w = (work){.pool = pool_with((shape){.workers = 1})};
	grant_allocations(0);
	assert_int_equal(pthread_create(&thread, NULL, loop_outside, &w), 0);
	while (allocations_to_grant > -3) /* it has tried three times */
		nap_us(100);
	assert_int_equal(count_of(&w.ran), 0);
	grant_allocations(INT64_MAX);
	pthread_join(thread, NULL);
	assert_int_equal(count_of(&w.ran), 1000);
	stilb_job_pool_destroy(w.pool);
}

/* ---- pools created and destroyed ------------------------------------------------------------------------------- */

static void test_thousand_pools(void **state)
{
	(void)state;
	int64_t before = blocks;
	for (uint32_t i = 0; i < (TEST_TSAN || TEST_EMULATED ? 240 : 1000); i++) {
		shape s = {.workers = i % 4, .queue = (stilb_job_queue_kind)(i / 4 % 2)};
		work w = {.pool = pool_with(s)};
		uint32_t jobs = i % 3 * 20;
		for (uint32_t k = 0; k < jobs; k++)
			assert_int_equal(stilb_job_submit(w.pool, count_job, &w, &w.group, k % 2 ? STILB_JOB_OUTSIDE : 0), 0);
		if (i % 5 == 0)
			stilb_job_wait(w.pool, &w.group, 0);
		stilb_job_pool_destroy(w.pool); /* runs the queued jobs */
		assert_int_equal(w.ran, jobs);
		assert_int_equal(w.group.state, 0);
	}
	assert_int_equal(blocks, before);
	stilb_job_pool_destroy(NULL);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_create_refuses),          cmocka_unit_test(test_most_workers),
		cmocka_unit_test(test_submit_refuses),          cmocka_unit_test(test_create_without_threads),
		cmocka_unit_test(test_create_without_memory),   cmocka_unit_test(test_submit_without_memory),
		cmocka_unit_test(test_submit_n_without_memory), cmocka_unit_test(test_outside_loop_without_memory),
		cmocka_unit_test(test_thousand_pools),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
