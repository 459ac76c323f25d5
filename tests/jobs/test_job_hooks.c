/* The hooks: which job runs where and who submitted it, who helps with which loop, who waits, who steals. With 0, 1, 2
 * and 8 workers and both kinds of shared queues. */
#include "job_pool_fixture.h"

enum { DEEPEST = 8, OUTSIDE = MOST_THREADS };

/* The state of each thread as its hooks report it. The last one is for outside threads. */
typedef struct thread_log {
	uint64_t next;         /* tag of the next job that it submits */
	uint64_t tag[DEEPEST]; /* [depth] of the jobs that it is inside of */
	uint32_t depth, deepest;
	counter waiting; /* also read by the main thread */
} thread_log;

typedef struct hook_log {
	stilb_job_pool *pool;
	counter submitted, begun, ended, waits, steals, wrong;
	thread_log thread[MOST_THREADS + 1];
} hook_log;

static thread_log *thread_of(hook_log *log, uint32_t worker)
{
	return &log->thread[worker == STILB_JOB_OUTSIDE ? OUTSIDE : worker];
}

static uint64_t on_submit(void *user, uint32_t worker)
{
	hook_log *log = user;
	count_up(&log->submitted);
	return thread_of(log, worker)->next;
}

static void on_job_begin(void *user, uint32_t worker, uint64_t tag)
{
	hook_log *log = user;
	thread_log *thread = thread_of(log, worker);
	count_up(&log->begun);
	if (thread->depth == DEEPEST) {
		count_up(&log->wrong);
		return;
	}
	thread->tag[thread->depth++] = tag;
	if (thread->depth > thread->deepest)
		thread->deepest = thread->depth;
}

static void on_job_end(void *user, uint32_t worker)
{
	hook_log *log = user;
	if (thread_of(log, worker)->depth-- == 0)
		count_up(&log->wrong);
	count_up(&log->ended);
}

static void on_wait_begin(void *user, uint32_t worker)
{
	hook_log *log = user;
	count_up(&log->waits);
	count_up(&thread_of(log, worker)->waiting);
}

static void on_wait_end(void *user, uint32_t worker)
{
	hook_log *log = user;
	if (atomic_fetch_sub_explicit(&thread_of(log, worker)->waiting, 1, memory_order_acq_rel) == 0)
		count_up(&log->wrong);
}

static void on_steal(void *user, uint32_t worker, uint32_t victim)
{
	hook_log *log = user;
	if (victim == worker || worker > stilb_job_pool_worker_count(log->pool) ||
	    victim > stilb_job_pool_worker_count(log->pool))
		count_up(&log->wrong);
	count_up(&log->steals);
}

static void log_start(hook_log *log, shape s)
{
	*log = (hook_log){0};
	log->pool = pool_with_hooks(s, (stilb_job_hooks){.user = log,
	                                                 .submit = on_submit,
	                                                 .job_begin = on_job_begin,
	                                                 .job_end = on_job_end,
	                                                 .wait_begin = on_wait_begin,
	                                                 .wait_end = on_wait_end,
	                                                 .steal = on_steal});
}

/* Ends the pool and asserts that no thread is inside a job or a wait any more. */
static void log_stop(hook_log *log)
{
	stilb_job_pool_destroy(log->pool);
	assert_int_equal(log->begun, log->ended);
	assert_int_equal(log->wrong, 0);
	for (int i = 0; i <= OUTSIDE; i++) {
		assert_int_equal(log->thread[i].depth, 0);
		assert_int_equal(log->thread[i].waiting, 0);
	}
}

/* Notes an error unless the innermost job that the thread is inside of has this tag. */
static void check_inside(hook_log *log, uint32_t worker, uint64_t tag)
{
	const thread_log *thread = thread_of(log, worker);
	if (thread->depth == 0 || thread->tag[thread->depth - 1] != tag)
		count_up(&log->wrong);
}

/* ---- jobs ------------------------------------------------------------------------------------------------------ */

typedef struct tagged {
	hook_log *log;
	uint64_t tag;
} tagged;

static void check_tag(void *data, uint32_t worker)
{
	const tagged *job = data;
	check_inside(job->log, worker, job->tag);
}

static void check_tag_and_wait(void *data, uint32_t worker)
{
	const tagged *job = data;
	tagged child[4];
	stilb_job_group group = {0};
	uint32_t depth = job->log->thread[worker].depth;
	check_tag(data, worker);
	for (uint64_t i = 0; i < 4; i++) {
		child[i] = (tagged){job->log, job->tag * 10 + i};
		job->log->thread[worker].next = child[i].tag;
		if (stilb_job_submit(job->log->pool, check_tag, &child[i], &group, worker) != 0)
			count_up(&job->log->wrong);
	}
	stilb_job_wait(job->log->pool, &group, worker);
	if (job->log->thread[worker].depth != depth)
		count_up(&job->log->wrong);
	check_tag(data, worker);
}

static void test_jobs_pair_and_nest(void **state)
{
	(void)state;
	static hook_log log;
	static tagged job[100];
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		log_start(&log, s);
		stilb_job_group group = {0};
		for (uint64_t i = 0; i < 100; i++) {
			job[i] = (tagged){&log, 1000 + i};
			log.thread[0].next = 1000 + i;
			assert_int_equal(stilb_job_submit(log.pool, check_tag_and_wait, &job[i], &group, 0), 0);
		}
		stilb_job_wait(log.pool, &group, 0);
		log_stop(&log);
		assert_int_equal(log.submitted, 500);
		assert_int_equal(log.begun, 500);
		if (s.workers == 0) {
			assert_int_equal(log.thread[0].deepest, 2);
			assert_int_equal(log.steals, 0);
		}
	}
}

typedef struct submitter {
	hook_log *log;
	uint32_t worker; /* of the calling thread */
	tagged job[6];
	stilb_job_group first, group;
} submitter;

/* Submits one job in each possible way. */
static void *submit_in_all_ways(void *data)
{
	submitter *m = data;
	uint32_t last = stilb_job_pool_worker_count(m->log->pool);
	const stilb_job_options options[] = {{.priority = STILB_JOB_NORMAL},   {.priority = STILB_JOB_HIGH},
	                                     {.priority = STILB_JOB_LOW},      {.pinned = true, .target = 0},
	                                     {.pinned = true, .target = last}, {.after = &m->first}};
	for (uint64_t i = 0; i < 6; i++) {
		m->job[i] = (tagged){m->log, 500 + i};
		thread_of(m->log, m->worker)->next = 500 + i;
		if (stilb_job_submit_with(m->log->pool, check_tag, &m->job[i], i == 0 ? &m->first : &m->group, &options[i],
		                          m->worker) != 0)
			count_up(&m->log->wrong);
	}
	return NULL;
}

static void test_every_way_of_submitting_has_its_tag(void **state)
{
	(void)state;
	static hook_log log;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		for (int outside = 0; outside < 2; outside++) {
			log_start(&log, s);
			submitter m = {.log = &log, .worker = outside ? STILB_JOB_OUTSIDE : 0};
			if (outside)
				outside_run(submit_in_all_ways, &m);
			else
				submit_in_all_ways(&m);
			stilb_job_wait(log.pool, &m.first, 0);
			stilb_job_wait(log.pool, &m.group, 0);
			log_stop(&log);
			assert_int_equal(log.submitted, 6);
			assert_int_equal(log.begun, 6);
		}
	}
}

/* Threads from outside that are held inside their submit until `open`. */
typedef struct crowd {
	stilb_job_pool *pool;
	counter inside, open, done;
} crowd;

static uint64_t hold_in_submit(void *user, uint32_t worker)
{
	crowd *c = user;
	(void)worker;
	count_up(&c->inside);
	while (!count_of(&c->open))
		nap_us(50);
	return 0;
}

static void do_nothing(void *data, uint32_t worker)
{
	(void)data, (void)worker;
}

static void *submit_in_crowd(void *data)
{
	crowd *c = data;
	if (stilb_job_submit(c->pool, do_nothing, NULL, NULL, STILB_JOB_OUTSIDE) == 0)
		count_up(&c->done);
	return NULL;
}

/* 32 threads from outside can be inside a submit at once; others wait until one of these leaves. The second crowd finds
 * all 32 places free again. */
static void test_a_crowd_from_outside(void **state)
{
	(void)state;
	enum { PLACES = 32, CROWD = PLACES + 4 };
	static crowd c;
	pthread_t thread[CROWD];
	c.pool = pool_with_hooks((shape){.workers = 1}, (stilb_job_hooks){.user = &c, .submit = hold_in_submit});
	for (int round = 0; round < 2; round++) {
		c.inside = c.open = c.done = 0;
		for (uint32_t i = 0; i < CROWD; i++)
			thread[i] = outside_start(submit_in_crowd, &c);
		assert_true(await(&c.inside, PLACES));
		nap_us(2000); /* the others look for a place meanwhile */
		assert_int_equal(count_of(&c.inside), PLACES);
		count_up(&c.open);
		assert_true(await(&c.done, CROWD));
		for (uint32_t i = 0; i < CROWD; i++)
			pthread_join(thread[i], NULL);
	}
	stilb_job_pool_destroy(c.pool);
}

static void test_cancelled_jobs_do_not_begin(void **state)
{
	(void)state;
	static hook_log log;
	tagged job = {&log, 7};
	log_start(&log, (shape){.workers = 0});
	for (int i = 0; i < 10; i++)
		assert_int_equal(stilb_job_submit(log.pool, check_tag, &job, NULL, 0), 0);
	stilb_job_pool_cancel(log.pool);
	log_stop(&log);
	assert_int_equal(log.submitted, 10);
	assert_int_equal(log.begun, 0);
}

static void test_without_submit_tags_are_zero(void **state)
{
	(void)state;
	static hook_log log;
	log = (hook_log){0};
	log.pool = pool_with_hooks((shape){.workers = 2},
	                           (stilb_job_hooks){.user = &log, .job_begin = on_job_begin, .job_end = on_job_end});
	tagged job = {&log, 0};
	stilb_job_group group = {0};
	for (int i = 0; i < 100; i++)
		assert_int_equal(stilb_job_submit(log.pool, check_tag, &job, &group, 0), 0);
	stilb_job_wait(log.pool, &group, 0);
	log_stop(&log);
	assert_int_equal(log.begun, 100);
}

/* ---- loops ----------------------------------------------------------------------------------------------------- */

enum { SLICES = 32, OUTER_TAG = 90, INNER_TAG = 900 };

typedef struct loops {
	hook_log *log;
	counter helped, inner_helped, ran;
} loops;

typedef struct inner_loop {
	loops *loops;
	uint32_t caller, depth; /* depth: number of jobs that the caller was inside of when it opened the loop */
	uint64_t tag;
} inner_loop;

static void inner_slice(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const inner_loop *inner = context;
	loops *l = inner->loops;
	count_up(&l->ran);
	nap_us(20 * (end - begin));
	if (worker != inner->caller) {
		count_up(&l->inner_helped);
		check_inside(l->log, worker, inner->tag);
	} else if (l->log->thread[worker].depth != inner->depth) {
		count_up(&l->log->wrong); /* the caller's own slices belong to the job that opened the loop */
	}
}

static void outer_slice(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	loops *l = context;
	(void)end;
	if (worker > 0) {
		count_up(&l->helped);
		check_inside(l->log, worker, OUTER_TAG);
	} else if (l->log->thread[0].depth != 0) {
		count_up(&l->log->wrong);
	}
	inner_loop inner = {l, worker, l->log->thread[worker].depth, INNER_TAG + begin};
	l->log->thread[worker].next = inner.tag;
	stilb_job_parallel_for(l->log->pool, SLICES, 1, inner_slice, &inner, worker);
}

static void test_helpers_of_a_loop_know_its_tag(void **state)
{
	(void)state;
	static hook_log log;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		log_start(&log, s);
		loops l = {.log = &log};
		uint64_t start = now_ns();
		uint32_t rounds = 0;
		do { /* repeated, since it depends on the scheduler who helps */
			log.thread[0].next = OUTER_TAG;
			stilb_job_parallel_for(log.pool, SLICES, 1, outer_slice, &l, 0);
			rounds++;
		} while (s.workers > 0 && (count_of(&l.helped) == 0 || (s.workers > 1 && count_of(&l.inner_helped) == 0)) &&
		         now_ns() - start < 10000000000u);
		log_stop(&log);
		assert_int_equal(l.ran, rounds * SLICES * SLICES);
		assert_true(log.begun <= l.helped + l.inner_helped);
		if (s.workers == 0) {
			assert_int_equal(log.submitted, 0); /* no helpers: the loop was not announced */
			assert_int_equal(log.begun, 0);
		} else {
			assert_true(l.helped > 0);
			assert_true(log.submitted >= rounds);
		}
	}
}

/* An array is one job that opens a loop. */
static void test_arrays_are_a_job_and_a_loop(void **state)
{
	(void)state;
	static hook_log log;
	log_start(&log, (shape){.workers = 2});
	loops l = {.log = &log};
	inner_loop inner = {.loops = &l, .caller = UINT32_MAX, .tag = 77};
	stilb_job_group group = {0};
	for (int i = 0; i <= 2; i++)
		log.thread[i].next = 77;
	assert_int_equal(stilb_job_submit_array(log.pool, 200, 1, inner_slice, &inner, &group, 0), 0);
	stilb_job_wait(log.pool, &group, 0);
	log_stop(&log);
	assert_int_equal(l.ran, 200);
	assert_int_equal(log.submitted, 2);
	assert_true(log.begun >= 1);
}

/* ---- waits ----------------------------------------------------------------------------------------------------- */

typedef struct until_waiting {
	hook_log *log;
	uint32_t waiter;
	counter inside;
} until_waiting;

/* Returns when the thread has called the hook wait_begin. */
static void end_when_waited_for(void *data, uint32_t worker)
{
	until_waiting *u = data;
	(void)worker;
	if (!await(&thread_of(u->log, u->waiter)->waiting, 1))
		count_up(&u->log->wrong);
}

static void *wait_from_outside(void *data)
{
	until_waiting *u = data;
	stilb_job_group group = {0};
	stilb_job_options on_first = {.pinned = true, .target = 1};
	if (stilb_job_submit_with(u->log->pool, end_when_waited_for, u, &group, &on_first, STILB_JOB_OUTSIDE) != 0)
		count_up(&u->log->wrong);
	stilb_job_wait(u->log->pool, &group, STILB_JOB_OUTSIDE);
	stilb_job_wait(u->log->pool, &group, STILB_JOB_OUTSIDE); /* the group has finished before the wait begins */
	return NULL;
}

static void test_waits_for_groups(void **state)
{
	(void)state;
	static hook_log log;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		if (s.workers == 0)
			continue;
		log_start(&log, s);
		until_waiting u = {.log = &log, .waiter = 0};
		stilb_job_group group = {0};
		submit_pinned(log.pool, end_when_waited_for, &u, &group, s.workers, 0);
		stilb_job_wait(log.pool, &group, 0);
		uint32_t waits = log.waits;
		assert_true(waits >= 1);
		stilb_job_wait(log.pool, &group, 0);
		assert_int_equal(log.waits, waits);
		u.waiter = STILB_JOB_OUTSIDE;
		outside_run(wait_from_outside, &u);
		assert_int_equal(log.waits, waits + 1);
		log_stop(&log);
	}
}

/* The caller waits after its own slice, if the other slice is still running on a helper. */
static void slice_of_two(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	until_waiting *u = context;
	(void)begin, (void)end;
	if (worker == u->waiter) {
		if (!await(&u->inside, 1))
			count_up(&u->log->wrong);
	} else {
		count_up(&u->inside);
		end_when_waited_for(u, worker);
	}
}

static void test_waits_for_loops(void **state)
{
	(void)state;
	static hook_log log;
	log_start(&log, (shape){.workers = 1});
	stilb_job_phase_begin(log.pool); /* the worker stays awake, since a loop that seems short wakes none */
	for (uint32_t i = 0; i < 20; i++) {
		until_waiting u = {.log = &log, .waiter = 0};
		stilb_job_parallel_for(log.pool, 2, 1, slice_of_two, &u, 0);
		assert_int_equal(log.waits, i + 1);
		assert_int_equal(log.begun, i + 1);
	}
	stilb_job_phase_end(log.pool);
	log_stop(&log);
}

/* ---- steals ---------------------------------------------------------------------------------------------------- */

static void count_job(void *data, uint32_t worker)
{
	hook_log *log = data;
	if (worker != 1 || log->thread[1].tag[0] != 3)
		count_up(&log->wrong);
}

static void test_every_steal_is_reported(void **state)
{
	(void)state;
	static hook_log log;
	log_start(&log, (shape){.workers = 1});
	log.thread[0].next = 3;
	for (int i = 0; i < 50; i++)
		assert_int_equal(stilb_job_submit(log.pool, count_job, &log, NULL, 0), 0);
	assert_true(await(&log.ended, 50)); /* the owner runs none of them */
	assert_int_equal(log.steals, 50);
	log_stop(&log);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_jobs_pair_and_nest),
		cmocka_unit_test(test_every_way_of_submitting_has_its_tag),
		cmocka_unit_test(test_a_crowd_from_outside),
		cmocka_unit_test(test_cancelled_jobs_do_not_begin),
		cmocka_unit_test(test_without_submit_tags_are_zero),
		cmocka_unit_test(test_helpers_of_a_loop_know_its_tag),
		cmocka_unit_test(test_arrays_are_a_job_and_a_loop),
		cmocka_unit_test(test_waits_for_groups),
		cmocka_unit_test(test_waits_for_loops),
		cmocka_unit_test(test_every_steal_is_reported),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
