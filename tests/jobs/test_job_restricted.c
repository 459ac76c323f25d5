/*
 * Waits run only the jobs that job.h allows them; and the classic failures of job systems: the lost wake-up, the full
 * queue while all threads sleep, waiting for a thread that never runs, the deadlock with one worker. All of them appear
 * as a test that does not end:
 * some tests give up after ten seconds, the others run into their time limit.
 */
#include "job_pool_fixture.h"

#include <stdlib.h>

/* ---- out of memory on demand; linked with -Wl,--wrap= of each of these ------------------------------------------- */

static _Atomic bool out_of_memory; /* relaxed: set while the pool is asleep or busy elsewhere */

void *__real_malloc(size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_malloc(size_t size)
{
	return atomic_load_explicit(&out_of_memory, memory_order_relaxed) ? NULL : __real_malloc(size);
}

void *__real_calloc(size_t count, size_t size);
void *__wrap_calloc(size_t count, size_t size); /* the compiler turns malloc and memset into calloc */
void *__wrap_calloc(size_t count, size_t size)
{
	return atomic_load_explicit(&out_of_memory, memory_order_relaxed) ? NULL : __real_calloc(count, size);
}

void *__real_aligned_alloc(size_t alignment, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size)
{
	return atomic_load_explicit(&out_of_memory, memory_order_relaxed) ? NULL : __real_aligned_alloc(alignment, size);
}

/* ---- jobs that record who ran them ----------------------------------------------------------------------------- */

typedef struct watched {
	stilb_job_pool *pool;
	stilb_job_group group;
	uint32_t waiter; /* the thread that must not run the jobs */
	counter ran, by_waiter, wrong;
} watched;

static void watched_job(void *data, uint32_t worker)
{
	watched *w = data;
	if (worker == w->waiter)
		count_up(&w->by_waiter);
	count_up(&w->ran);
}

static void *submit_watched(void *data)
{
	watched *w = data;
	stilb_job_options low = {.priority = STILB_JOB_LOW};
	for (int i = 0; i < 10; i++)
		if (stilb_job_submit(w->pool, watched_job, w, &w->group, STILB_JOB_OUTSIDE) != 0 ||
		    stilb_job_submit_with(w->pool, watched_job, w, &w->group, &low, STILB_JOB_OUTSIDE) != 0)
			count_up(&w->wrong);
	return NULL;
}

/* ---- waits are restricted -------------------------------------------------------------------------------------- */

/* The owner waits for a job that is held. Meanwhile there are jobs that it must not run: from outside and of low
 * priority, some before it waits and some while it sleeps; others in its own deque; one in a worker's deque. */
typedef struct restriction {
	watched unrelated;
	blocker held;      /* the job that the owner waits for */
	counter submitted; /* a worker has its job in its own deque */
	sleep_log log;
	uint32_t workers, free;
	uint32_t ran_early; /* number of unrelated jobs that ran before the held one had finished */
} restriction;

/* from outside, in the owner's deque, from outside again; one more is in a worker's deque */
enum { UNRELATED = 20 + 5 + 20 };

static void submit_and_be_held(void *data, uint32_t worker)
{
	restriction *r = data;
	if (stilb_job_submit(r->unrelated.pool, watched_job, &r->unrelated, &r->unrelated.group, worker) != 0)
		count_up(&r->unrelated.wrong);
	count_up(&r->submitted);
	blocker_job(&r->held, worker);
}

/* Runs on another thread while the owner sleeps. */
static void *look_on(void *data)
{
	restriction *r = data;
	if (!await(&r->log.asleep, 1 + r->free))
		count_up(&r->unrelated.wrong);
	if (r->free == 0)
		nap_us(2000); /* time for the owner to do something wrong */
	submit_watched(&r->unrelated);
	uint32_t wanted = UNRELATED + (r->workers > 1);
	if (r->free == 0)
		nap_us(2000);
	else if (!await(&r->unrelated.ran, wanted))
		count_up(&r->unrelated.wrong);
	r->ran_early = count_of(&r->unrelated.ran);
	blocker_release(&r->held);
	return NULL;
}

/* `free` workers are free, the others are busy and do not wait. */
static void check_restriction(shape s, uint32_t free)
{
	restriction r = {.workers = s.workers, .free = free};
	stilb_job_group group = {0};
	stilb_job_pool *pool = r.unrelated.pool = pool_with_hooks(s, sleep_log_hooks(&r.log));
	uint32_t busy = s.workers - free;
	hold_workers(pool, &r.held, &group, busy, busy);
	if (busy > 2)
		hold_workers(pool, &r.held, NULL, 2, busy - 1);
	if (s.workers > 1) {
		submit_pinned(pool, submit_and_be_held, &r, &r.unrelated.group, 1, 0);
		assert_true(await(&r.submitted, 1));
	}
	outside_run(submit_watched, &r.unrelated);
	for (int i = 0; i < 5; i++)
		assert_int_equal(stilb_job_submit(pool, watched_job, &r.unrelated, &r.unrelated.group, 0), 0);
	pthread_t onlooker = outside_start(look_on, &r);
	stilb_job_wait(pool, &group, 0);
	uint32_t by_waiter = count_of(&r.unrelated.by_waiter);
	pthread_join(onlooker, NULL);
	stilb_job_wait(pool, &r.unrelated.group, 0);
	assert_int_equal(by_waiter, 0);
	assert_int_equal(r.ran_early, free ? UNRELATED + (s.workers > 1) : 0);
	assert_int_equal(r.unrelated.ran, UNRELATED + (s.workers > 1));
	assert_int_equal(r.unrelated.wrong, 0);
	stilb_job_pool_destroy(pool);
}

static void test_wait_leaves_unrelated_jobs_to_busy_workers(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s))
		if (s.workers > 0)
			check_restriction(s, 0);
}

static void test_wait_leaves_unrelated_jobs_to_free_workers(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s))
		if (s.workers > 2)
			check_restriction(s, s.workers - 2);
}

/* As above, but the waiting thread is a worker, in a job that waits for its child. */
typedef struct waiting_job {
	watched unrelated;
	blocker child;
	stilb_job_group group;
} waiting_job;

static void wait_for_held_child(void *data, uint32_t worker)
{
	waiting_job *w = data;
	stilb_job_group group = {0};
	stilb_job_options options = {.pinned = true, .target = 2};
	if (stilb_job_submit_with(w->unrelated.pool, blocker_job, &w->child, &group, &options, worker) != 0)
		count_up(&w->unrelated.wrong);
	stilb_job_wait(w->unrelated.pool, &group, worker);
}

static void test_wait_of_a_job_is_restricted_too(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		if (s.workers != 2)
			continue;
		sleep_log log = {0};
		waiting_job w = {.unrelated = {.pool = pool_with_hooks(s, sleep_log_hooks(&log)), .waiter = 1}};
		submit_pinned(w.unrelated.pool, wait_for_held_child, &w, &w.group, 1, 0);
		assert_true(await(&w.child.inside, 1));
		assert_true(await(&log.asleep, 1));
		for (int i = 0; i < 5; i++)
			assert_int_equal(stilb_job_submit(w.unrelated.pool, watched_job, &w.unrelated, &w.unrelated.group, 0), 0);
		outside_run(submit_watched, &w.unrelated);
		nap_us(2000);
		assert_int_equal(count_of(&w.unrelated.ran), 0);
		blocker_release(&w.child);
		stilb_job_wait(w.unrelated.pool, &w.group, 0);
		stilb_job_pool_destroy(w.unrelated.pool);
		assert_int_equal(w.unrelated.ran, 25);
		assert_int_equal(w.unrelated.wrong, 0);
	}
}

static void test_without_workers_a_wait_does_everything(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		if (s.workers > 0)
			continue;
		watched w = {.pool = pool_with(s)};
		outside_run(submit_watched, &w);
		for (int i = 0; i < 5; i++)
			assert_int_equal(stilb_job_submit(w.pool, watched_job, &w, &w.group, 0), 0);
		submit_pinned(w.pool, watched_job, &w, &w.group, 0, 0);
		stilb_job_wait(w.pool, &w.group, 0);
		assert_int_equal(w.by_waiter, 26);
		assert_int_equal(w.wrong, 0);
		stilb_job_pool_destroy(w.pool);
	}
}

/* High and pinned jobs run inside a wait although they do not belong to its group, and wake the waiting thread. */
static void *submit_high_and_pinned(void *data)
{
	restriction *r = data;
	stilb_job_options high = {.priority = STILB_JOB_HIGH}, pinned = {.pinned = true, .target = 0};
	watched *w = &r->unrelated;
	for (uint32_t i = 1; i <= 10; i++) {
		if (!await(&r->log.asleep, 1) ||
		    stilb_job_submit_with(w->pool, watched_job, w, NULL, i % 2 ? &high : &pinned, STILB_JOB_OUTSIDE) != 0 ||
		    !await(&w->ran, i))
			count_up(&w->wrong);
	}
	blocker_release(&r->held);
	return NULL;
}

static void test_wait_runs_high_and_pinned_jobs(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		if (s.workers == 0)
			continue;
		restriction r = {0};
		stilb_job_group group = {0};
		r.unrelated.pool = pool_with_hooks(s, sleep_log_hooks(&r.log));
		hold_workers(r.unrelated.pool, &r.held, &group, 1, s.workers);
		pthread_t outside = outside_start(submit_high_and_pinned, &r);
		stilb_job_wait(r.unrelated.pool, &group, 0);
		pthread_join(outside, NULL);
		assert_int_equal(r.unrelated.by_waiter, 10);
		assert_int_equal(r.unrelated.wrong, 0);
		stilb_job_pool_destroy(r.unrelated.pool);
	}
}

/* ---- when every worker waits ----------------------------------------------------------------------------------- */

/* Each worker is in a job that waits for a job of low priority, which waits must not run, and which may come late. */
typedef struct rescue {
	stilb_job_pool *pool;
	stilb_job_group jobs, gate;
	uint32_t levels; /* number of nested levels of low jobs that wait for low jobs */
	bool late;
	counter begun, ran, wrong;
} rescue;

typedef struct rescue_level {
	rescue *rescue;
	uint32_t levels;
} rescue_level;

static void wait_for_low(void *data, uint32_t worker)
{
	const rescue_level *outer = data;
	rescue *r = outer->rescue;
	count_up(&r->ran);
	if (outer->levels == 0)
		return;
	rescue_level inner = {r, outer->levels - 1};
	stilb_job_group group = {0};
	stilb_job_options low = {.priority = STILB_JOB_LOW, .after = r->late ? &r->gate : NULL};
	if (stilb_job_submit_with(r->pool, wait_for_low, &inner, &group, &low, worker) != 0)
		count_up(&r->wrong);
	stilb_job_wait(r->pool, &group, worker);
}

static void do_nothing(void *data, uint32_t worker)
{
	(void)data;
	(void)worker;
}

static void test_when_all_wait_somebody_does_the_rest(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s))
		for (int way = 0; way < 4; way++) {
			bool late = way & 1, owner_waits = way & 2;
			sleep_log log = {0};
			rescue r = {.pool = pool_with_hooks(s, sleep_log_hooks(&log)), .late = late};
			rescue_level top = {&r, 3};
			if (late && s.workers > 0)
				submit_pinned(r.pool, do_nothing, NULL, &r.gate, 0, 0); /* keeps the gate closed */
			for (uint32_t i = 0; i <= s.workers; i++)
				if (i > 0 || s.workers == 0)
					submit_pinned(r.pool, wait_for_low, &top, &r.jobs, i, 0);
			uint32_t waiting = s.workers > 0 ? s.workers : 1;
			if (late && s.workers > 0) {
				assert_true(await(&r.ran, waiting)); /* the first job of each; then all sleep again inside them */
				assert_true(await(&log.asleep, s.workers));
				assert_int_equal(count_of(&r.ran), waiting);
				assert_int_equal(stilb_job_run_pinned(r.pool, 0), 1); /* finishes the gate */
			}
			if (owner_waits || s.workers == 0)
				stilb_job_wait(r.pool, &r.jobs, 0);
			else
				assert_true(await(&r.ran, 4 * waiting));
			stilb_job_wait(r.pool, &r.jobs, 0);
			assert_int_equal(r.ran, 4 * waiting);
			assert_int_equal(r.wrong, 0);
			stilb_job_pool_destroy(r.pool);
		}
}

/* The caller of a loop waits for a slice on a helper, and may run loops only. The helper waits for a low job. */
static void slice_waits_for_low(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)begin;
	(void)end;
	wait_for_low(context, worker);
}

static void loop_of_waits(void *data, uint32_t worker)
{
	rescue_level *top = data;
	stilb_job_parallel_for(top->rescue->pool, 4, 1, slice_waits_for_low, top, worker);
}

static void test_when_all_wait_in_loops_too(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s))
		for (int round = 0; round < 5; round++) {
			rescue r = {.pool = pool_with(s)};
			rescue_level top = {&r, 2};
			for (uint32_t i = 0; i <= s.workers; i++)
				submit_pinned(r.pool, loop_of_waits, &top, &r.jobs, i, 0);
			stilb_job_wait(r.pool, &r.jobs, 0);
			assert_int_equal(r.ran, 12 * (s.workers + 1));
			assert_int_equal(r.wrong, 0);
			stilb_job_pool_destroy(r.pool);
		}
}

/* As above, but the helper waits for a job that only the caller of the loop may run. */
typedef struct slice_log {
	stilb_job_pool *pool;
	counter inside, ran, wrong;
} slice_log;

static void count_on_owner(void *data, uint32_t worker)
{
	slice_log *log = data;
	if (worker != 0)
		count_up(&log->wrong);
	count_up(&log->ran);
}

static void slice_waits_for_owner(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	slice_log *log = context;
	(void)begin;
	(void)end;
	count_up(&log->inside);
	for (int i = 0; i < 1000 && worker == 0 && count_of(&log->inside) < 2; i++)
		nap_us(50); /* time for a helper to come; there may be none */
	stilb_job_group group = {0};
	stilb_job_options pinned = {.pinned = true, .target = 0};
	if (worker > 0) {
		if (stilb_job_submit_with(log->pool, count_on_owner, log, &group, &pinned, worker) != 0)
			count_up(&log->wrong);
		stilb_job_wait(log->pool, &group, worker);
	}
}

static void test_slice_waits_for_the_owner(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s))
		for (int i = 0; i < 20 && s.workers > 0; i++) {
			slice_log log = {.pool = pool_with(s)};
			stilb_job_parallel_for(log.pool, 2, 1, slice_waits_for_owner, &log, 0);
			assert_in_range(log.ran, 1, 2);
			assert_int_equal(log.wrong, 0);
			stilb_job_pool_destroy(log.pool);
		}
}

/* ---- stack depth ----------------------------------------------------------------------------------------------- */

/* Number of jobs on each thread's stack; written by that thread only. */
typedef struct depth_log {
	stilb_job_pool *pool;
	counter ran, wrong;
	struct {
		uint32_t now, most;
		char pad[56];
	} thread[MOST_THREADS];
} depth_log;

typedef struct level {
	depth_log *log;
	uint32_t below; /* number of levels */
	uint32_t width;
	stilb_job_options child; /* options for submitting children */
} level;

static void descend(void *data, uint32_t worker)
{
	level *outer = data;
	depth_log *log = outer->log;
	if (++log->thread[worker].now > log->thread[worker].most)
		log->thread[worker].most = log->thread[worker].now;
	if (outer->below > 0) {
		level inner = {log, outer->below - 1, outer->width, outer->child};
		stilb_job_group group = {0};
		for (uint32_t i = 0; i < outer->width; i++)
			if (stilb_job_submit_with(log->pool, descend, &inner, &group, &outer->child, worker) != 0)
				count_up(&log->wrong);
		stilb_job_wait(log->pool, &group, worker);
	} else {
		count_up(&log->ran);
	}
	log->thread[worker].now--;
}

/* The most rescues (unrelated jobs that a waiting thread runs because every worker waits, job_internal.h) that may lie
 * on top of one waiting job: a few, not all 200. */
enum { RESCUES = 32 };

/* Submits so many siblings, each with a tree of so many levels below it; every job waits for its children. */
static void check_depth(shape s, uint32_t siblings, stilb_job_priority priority, uint32_t below, uint32_t width,
                        stilb_job_priority child)
{
	depth_log log = {.pool = pool_with(s)};
	level top = {&log, below, width, {.priority = child}};
	stilb_job_group group = {0};
	uint32_t leaves = siblings;
	for (uint32_t i = 0; i < below; i++)
		leaves *= width;
	for (uint32_t i = 0; i < siblings; i++)
		submit_priority(log.pool, descend, &top, &group, priority, 0);
	stilb_job_wait(log.pool, &group, 0);
	assert_int_equal(log.ran, leaves);
	assert_int_equal(log.wrong, 0);
	stilb_job_pool_destroy(log.pool);
	for (uint32_t i = 0; i <= s.workers; i++) {
		assert_int_equal(log.thread[i].now, 0);
		assert_in_range(log.thread[i].most, 0, 1 + below + (s.workers > 0 ? RESCUES : 0));
	}
}

static void test_nested_waits(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s))
		check_depth(s, 3, STILB_JOB_NORMAL, 5, 3, STILB_JOB_NORMAL);
}

static void test_waits_do_not_pile_up(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s))
		for (int round = 0; round < 3; round++) {
			check_depth(s, 200, STILB_JOB_NORMAL, 1, 1, STILB_JOB_NORMAL);
			check_depth(s, 200, STILB_JOB_NORMAL, 2, 2, STILB_JOB_NORMAL);
			check_depth(s, 200, STILB_JOB_NORMAL, 1, 1, STILB_JOB_HIGH);
			check_depth(s, 200, STILB_JOB_NORMAL, 1, 1, STILB_JOB_LOW);
			check_depth(s, 200, STILB_JOB_HIGH, 1, 1, STILB_JOB_NORMAL);
		}
}

/* The owner's siblings are available, in the same group and not deeper, while the child that one of them waits for is
 * held. */
static void *release_when_asleep(void *data)
{
	restriction *r = data;
	if (!await(&r->log.asleep, 1))
		count_up(&r->unrelated.wrong);
	nap_us(1000);
	blocker_release(&r->held);
	return NULL;
}

static void test_wait_leaves_siblings_alone(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		if (s.workers != 1)
			continue;
		restriction r = {0};
		depth_log log = {.pool = pool_with_hooks(s, sleep_log_hooks(&r.log))};
		level top = {&log, 1, 1, {.pinned = true, .target = 1}};
		stilb_job_group group = {0};
		hold_workers(log.pool, &r.held, NULL, 1, 1);
		for (int i = 0; i < 200; i++)
			assert_int_equal(stilb_job_submit(log.pool, descend, &top, &group, 0), 0);
		pthread_t outside = outside_start(release_when_asleep, &r);
		stilb_job_wait(log.pool, &group, 0);
		pthread_join(outside, NULL);
		assert_int_equal(log.ran, 200);
		assert_in_range(log.thread[0].most, 0, 1);
		assert_in_range(log.thread[1].most, 0, 2);
		assert_int_equal(log.wrong + r.unrelated.wrong, 0);
		stilb_job_pool_destroy(log.pool);
	}
}

typedef struct family {
	stilb_job_pool *pool;
	stilb_job_group group, children;
	counter ran, wrong;
} family;

static void count_child(void *data, uint32_t worker)
{
	family *f = data;
	(void)worker;
	count_up(&f->ran);
}

static void wait_for_nothing(void *data, uint32_t worker)
{
	family *f = data;
	stilb_job_group finished = {0};
	if (stilb_job_submit(f->pool, count_child, f, &f->children, worker) != 0)
		count_up(&f->wrong);
	stilb_job_wait(f->pool, &finished, worker);
	if (count_of(&f->ran) != 0)
		count_up(&f->wrong);
	stilb_job_wait(f->pool, &f->children, worker);
}

/* It returns at once, although it might run the newest job of its thread. */
static void test_wait_for_a_finished_group_runs_nothing(void **state)
{
	(void)state;
	family f = {.pool = pool_with(shape_first())};
	assert_int_equal(stilb_job_submit(f.pool, wait_for_nothing, &f, &f.group, 0), 0);
	stilb_job_wait(f.pool, &f.group, 0);
	assert_int_equal(f.ran, 1);
	assert_int_equal(f.wrong, 0);
	stilb_job_pool_destroy(f.pool);
}

/* ---- the lost wake-up ------------------------------------------------------------------------------------------ */

enum { ROUNDS = 800 };

typedef struct round {
	stilb_job_pool *pool;
	stilb_job_group group;
	counter ran;
	counter wrong, go, over;
} round;

static void count_round(void *data, uint32_t worker)
{
	round *r = data;
	(void)worker;
	count_up(&r->ran);
}

static void count_round_slice(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)begin;
	(void)end;
	count_round(context, worker);
}

/* Submits one job for the worker, in the way with this index. */
static int submit_by(round *r, uint32_t way, uint32_t thread)
{
	stilb_job_options options[] = {
		{.priority = STILB_JOB_HIGH}, {.priority = STILB_JOB_LOW}, {.pinned = true, .target = 1}};
	if (way < 3)
		return stilb_job_submit_with(r->pool, count_round, r, NULL, &options[way], thread);
	if (way == 3)
		return stilb_job_submit_array(r->pool, 1, 1, count_round_slice, r, NULL, thread);
	return stilb_job_submit(r->pool, count_round, r, NULL, thread);
}

static void spin_ns(uint64_t nanoseconds)
{
	uint64_t start = now_ns();
	while (now_ns() - start < nanoseconds)
		;
}

/* Every job comes around the time at which the worker goes to sleep: before, after, or just then. Nobody helps, so a
 * lost wake-up is a job that never runs. */
static bool rounds_are_run(round *r, uint32_t rounds, uint32_t thread)
{
	for (uint32_t i = 1; i <= rounds; i++) {
		spin_ns(i * 37 % 50000);
		if (submit_by(r, i % 5, thread) != 0 || !await(&r->ran, i))
			return false;
	}
	return true;
}

static void *rounds_from_outside(void *data)
{
	round *r = data;
	if (!rounds_are_run(r, ROUNDS, STILB_JOB_OUTSIDE))
		count_up(&r->wrong);
	return NULL;
}

static void test_lost_wake_up(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		if (s.workers != 1 && s.workers != 2)
			continue;
		round r = {.pool = pool_with(s)};
		assert_true(rounds_are_run(&r, ROUNDS, 0));
		r.ran = 0;
		outside_run(rounds_from_outside, &r);
		assert_int_equal(r.wrong, 0);
		stilb_job_pool_destroy(r.pool);
	}
}

static void last_some_time(void *data, uint32_t worker)
{
	uint32_t *turn = data;
	(void)worker;
	spin_ns((*turn)++ * 41 % 60000);
}

/* The opposite of rounds_are_run: not a worker but a thread that waits, the owner or an outside thread, goes to sleep,
 * around the time at which its group finishes. */
typedef struct tired {
	stilb_job_pool *pool;
	uint32_t turn;
	uint32_t worker;
	counter wrong;
} tired;

static void *wait_while_tired(void *data)
{
	tired *t = data;
	for (int i = 0; i < ROUNDS; i++) {
		stilb_job_group group = {0};
		stilb_job_options pinned = {.pinned = true, .target = 1};
		if (stilb_job_submit_with(t->pool, last_some_time, &t->turn, &group, &pinned, t->worker) != 0)
			count_up(&t->wrong);
		stilb_job_wait(t->pool, &group, t->worker);
	}
	return NULL;
}

static void test_lost_wake_up_of_who_waits(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		if (s.workers != 1)
			continue;
		tired t = {.pool = pool_with(s)};
		wait_while_tired(&t);
		t.worker = STILB_JOB_OUTSIDE;
		outside_run(wait_while_tired, &t);
		assert_int_equal(t.wrong, 0);
		stilb_job_pool_destroy(t.pool);
	}
}

/* ---- full queues while all threads sleep ------------------------------------------------------------------------- */

enum { BURST = 5000 }; /* many times the initial size of a deque */

/* All workers sleep; the owner submits more jobs than its deque holds, and does not help. Without memory neither the
 * deque nor the shared queue for the rest can grow: no job may be lost or left where nobody looks. */
static void check_burst(shape s, bool memory)
{
	sleep_log log = {0};
	round r = {.pool = pool_with_hooks(s, sleep_log_hooks(&log))};
	blocker b = {0};
	hold_workers(r.pool, &b, NULL, 1, s.workers);
	for (uint32_t i = 0; i < BURST; i++) /* leaves free records behind, but no larger deque */
		submit_priority(r.pool, count_round, &r, &r.group, STILB_JOB_LOW, 0);
	blocker_release(&b);
	stilb_job_wait(r.pool, &r.group, 0);
	assert_int_equal(r.ran, BURST);
	r.ran = 0;
	assert_true(s.workers == 0 || await(&log.asleep, s.workers));
	uint32_t submitted = 0;
	int error = 0;
	atomic_store_explicit(&out_of_memory, !memory, memory_order_relaxed);
	for (; submitted < BURST && error == 0; submitted += error == 0)
		error = stilb_job_submit(r.pool, count_round, &r, &r.group, 0);
	if (s.workers == 0)
		stilb_job_wait(r.pool, &r.group, 0);
	bool all = await(&r.ran, submitted);
	atomic_store_explicit(&out_of_memory, false, memory_order_relaxed);
	assert_true(all);
	assert_true(error == 0 || !memory);
	assert_true(submitted > BURST / 2);
	stilb_job_wait(r.pool, &r.group, 0);
	stilb_job_pool_destroy(r.pool);
	assert_int_equal(r.ran, submitted);
}

static void test_full_queue_with_sleeping_workers(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s))
		for (int round_number = 0; round_number < (TEST_TSAN ? 1 : 3); round_number++) {
			check_burst(s, true);
			check_burst(s, false);
		}
}

/* Here the workers sleep in waits, for a group that finishes only when the owner gets there. */
static void wait_for_gate(void *data, uint32_t worker)
{
	rescue *r = data;
	count_up(&r->begun);
	stilb_job_wait(r->pool, &r->gate, worker);
	count_up(&r->ran);
}

static void test_full_queue_with_waiting_workers(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s))
		for (int memory = 0; memory < 2; memory++) {
			sleep_log log = {0};
			rescue r = {.pool = pool_with_hooks(s, sleep_log_hooks(&log))};
			round burst = {.pool = r.pool};
			submit_pinned(r.pool, do_nothing, NULL, &r.gate, 0, 0);
			for (uint32_t i = 1; i <= s.workers; i++)
				submit_pinned(r.pool, wait_for_gate, &r, &r.jobs, i, 0);
			assert_true(await(&r.begun, s.workers));
			assert_true(await(&log.asleep, s.workers));
			uint32_t submitted = 0;
			atomic_store_explicit(&out_of_memory, !memory, memory_order_relaxed);
			while (submitted < BURST / 4 && stilb_job_submit(r.pool, count_round, &burst, &burst.group, 0) == 0)
				submitted++;
			atomic_store_explicit(&out_of_memory, false, memory_order_relaxed);
			assert_true(s.workers == 0 ||
			            await(&burst.ran, submitted)); /* every worker waits: one of them runs it as a rescue */
			stilb_job_wait(r.pool, &burst.group, 0);
			assert_int_equal(burst.ran, submitted);
			stilb_job_run_pinned(r.pool, 0);
			stilb_job_wait(r.pool, &r.jobs, 0);
			assert_int_equal(r.ran, s.workers);
			stilb_job_pool_destroy(r.pool);
		}
}

/* ---- waiting for a thread that never runs ------------------------------------------------------------------------ */

/* All workers are held until the owner's waits have returned, so a wait that relies on a worker would never end. */
static void test_waiting_on_a_thread_that_never_runs(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		blocker b = {0};
		stilb_job_group own = {0}, other = {0}, follow = {0}, held = {0};
		depth_log log = {.pool = pool_with(s)};
		level top = {&log, 2, 3, {0}};
		watched unrelated = {.pool = log.pool};
		hold_workers(log.pool, &b, &held, 1, s.workers);

		stilb_job_options after = {.after = &own};
		for (int i = 0; i < 10; i++)
			assert_int_equal(stilb_job_submit(log.pool, descend, &top, &own, 0), 0);
		assert_int_equal(stilb_job_submit_with(log.pool, descend, &top, &follow, &after, 0), 0);
		submit_pinned(log.pool, descend, &top, &own, 0, 0);
		/* And while a job that is unrelated to the wait is in the owner's deque. */
		assert_int_equal(stilb_job_submit(log.pool, watched_job, &unrelated, &other, 0), 0);
		stilb_job_wait(log.pool, &own, 0);
		assert_true(s.workers == 0 || count_of(&unrelated.ran) == 0);
		stilb_job_wait(log.pool, &other, 0);
		assert_int_equal(unrelated.ran, 1);
		stilb_job_wait(log.pool, &follow, 0);
		assert_int_equal(log.ran, 12 * 9);

		round r = {.pool = log.pool};
		assert_int_equal(stilb_job_submit_array(log.pool, 1000, 1, count_round_slice, &r, &r.group, 0), 0);
		stilb_job_wait(log.pool, &r.group, 0);
		stilb_job_parallel_for(log.pool, 1000, 1, count_round_slice, &r, 0);
		assert_int_equal(r.ran, 2000);
		blocker_release(&b);
		stilb_job_wait(log.pool, &held, 0);
		stilb_job_pool_destroy(log.pool);
	}
}

/* ---- deadlock with one worker ------------------------------------------------------------------------------------ */

/* A job on the only worker waits, in every possible way, for a job that can run only there; the owner does not help. */
typedef struct lonely {
	stilb_job_pool *pool;
	counter ran, wrong, done;
} lonely;

static void count_lonely(void *data, uint32_t worker)
{
	lonely *l = data;
	if (worker != 1)
		count_up(&l->wrong);
	count_up(&l->ran);
}

static void lonely_slice(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	for (; begin < end; begin++)
		count_lonely(context, worker);
}

typedef struct outside_job {
	lonely *lonely;
	stilb_job_group *group;
} outside_job;

static void *submit_from_outside(void *data)
{
	outside_job *job = data;
	if (stilb_job_submit(job->lonely->pool, count_lonely, job->lonely, job->group, STILB_JOB_OUTSIDE) != 0)
		count_up(&job->lonely->wrong);
	return NULL;
}

static void wait_in_every_way(void *data, uint32_t worker)
{
	lonely *l = data;
	stilb_job_options pinned = {.pinned = true, .target = 1};
	for (uint32_t way = 0; way < 7; way++) {
		stilb_job_group group = {0}, then = {0};
		stilb_job_options options = {.priority = (stilb_job_priority)(way % 3), .after = way == 6 ? &then : NULL};
		int error = 0;
		if (way < 3)
			error = stilb_job_submit_with(l->pool, count_lonely, l, &group, &options, worker);
		else if (way == 3)
			error = stilb_job_submit_with(l->pool, count_lonely, l, &group, &pinned, worker);
		else if (way == 4)
			error = stilb_job_submit_array(l->pool, 1, 1, lonely_slice, l, &group, worker);
		else if (way == 5)
			submit_from_outside(&(outside_job){l, &group}); /* as a library with its own thread might do */
		else
			error = stilb_job_submit(l->pool, count_lonely, l, &then, worker) |
			        stilb_job_submit_with(l->pool, count_lonely, l, &group, &options, worker);
		stilb_job_wait(l->pool, &group, worker);
		if (error || count_of(&l->ran) != way + 1 + (way == 6))
			count_up(&l->wrong);
	}
	count_up(&l->done);
}

static void test_deadlock_with_one_worker(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		if (s.workers != 1)
			continue;
		for (int i = 0; i < 20; i++) {
			lonely l = {.pool = pool_with(s)};
			assert_int_equal(stilb_job_submit(l.pool, wait_in_every_way, &l, NULL, 0), 0);
			assert_true(await(&l.done, 1));
			assert_int_equal(l.ran, 8);
			assert_int_equal(l.wrong, 0);
			stilb_job_pool_destroy(l.pool);
		}
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_wait_leaves_unrelated_jobs_to_busy_workers),
		cmocka_unit_test(test_wait_leaves_unrelated_jobs_to_free_workers),
		cmocka_unit_test(test_wait_of_a_job_is_restricted_too),
		cmocka_unit_test(test_without_workers_a_wait_does_everything),
		cmocka_unit_test(test_wait_runs_high_and_pinned_jobs),
		cmocka_unit_test(test_when_all_wait_somebody_does_the_rest),
		cmocka_unit_test(test_when_all_wait_in_loops_too),
		cmocka_unit_test(test_slice_waits_for_the_owner),
		cmocka_unit_test(test_nested_waits),
		cmocka_unit_test(test_waits_do_not_pile_up),
		cmocka_unit_test(test_wait_leaves_siblings_alone),
		cmocka_unit_test(test_wait_for_a_finished_group_runs_nothing),
		cmocka_unit_test(test_lost_wake_up),
		cmocka_unit_test(test_lost_wake_up_of_who_waits),
		cmocka_unit_test(test_full_queue_with_sleeping_workers),
		cmocka_unit_test(test_full_queue_with_waiting_workers),
		cmocka_unit_test(test_waiting_on_a_thread_that_never_runs),
		cmocka_unit_test(test_deadlock_with_one_worker),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
