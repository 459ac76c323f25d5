/* Waits for jobs that lie between unrelated ones: in the middle of a deque, the thread's own or another's, or among
 * jobs of low priority. The unrelated jobs last until the wait has returned, so a wait that needs one of them to end or
 * to start hangs. With 1, 2 and 8 workers and both kinds of shared queues. */
#include "job_pool_fixture.h"
#include "job_random.h"

enum { ABOVE = 300, BELOW = 300, MINE = 20 }; /* more jobs than the first buffer of a deque holds */

typedef struct burial {
	stilb_job_pool *pool;
	blocker holding, stranger; /* hold the workers; what unrelated jobs are held by */
	stilb_job_group mine, strangers, held;
	counter ran, wrong, submitted;
} burial;

static void count_mine(void *data, uint32_t worker)
{
	burial *b = data;
	(void)worker;
	count_up(&b->ran);
}

static void submit_or_count(burial *b, stilb_job_fn *fn, void *data, stilb_job_group *group,
                            stilb_job_priority priority, uint32_t worker)
{
	stilb_job_options options = {.priority = priority};
	if (stilb_job_submit_with(b->pool, fn, data, group, &options, worker) != 0)
		count_up(&b->wrong);
}

/* Submits unrelated jobs and, spread among the lowest of them, those to wait for. */
static void submit_mixed(burial *b, stilb_job_priority priority, uint32_t worker)
{
	for (int i = 0; i < BELOW; i++) {
		submit_or_count(b, blocker_job, &b->stranger, &b->strangers, priority, worker);
		if (i % (BELOW / MINE) == 1)
			submit_or_count(b, count_mine, b, &b->mine, priority, worker);
	}
	for (int i = 0; i < ABOVE; i++)
		submit_or_count(b, blocker_job, &b->stranger, &b->strangers, priority, worker);
	count_up(&b->submitted);
}

/* Waits for the jobs of b->mine, then lets all others run. */
static void wait_and_end(burial *b, uint32_t workers)
{
	stilb_job_wait(b->pool, &b->mine, 0);
	assert_int_equal(count_of(&b->ran), MINE);
	assert_true(count_of(&b->stranger.inside) <= workers);
	count_up(&b->stranger.go);
	count_up(&b->holding.go);
	stilb_job_wait(b->pool, &b->held, 0);
	stilb_job_wait(b->pool, &b->strangers, 0);
	assert_int_equal(count_of(&b->stranger.inside), BELOW + ABOVE);
	assert_int_equal(b->wrong, 0);
	stilb_job_pool_destroy(b->pool);
}

/* Three batches, the one to wait for between unrelated ones; several jobs lie in a record. */
static void submit_batches(burial *b, uint32_t worker)
{
	if (stilb_job_submit_n(b->pool, blocker_job, &b->stranger, 0, BELOW, &b->strangers, worker) != 0 ||
	    stilb_job_submit_n(b->pool, count_mine, b, 0, MINE, &b->mine, worker) != 0 ||
	    stilb_job_submit_n(b->pool, blocker_job, &b->stranger, 0, ABOVE, &b->strangers, worker) != 0)
		count_up(&b->wrong);
	count_up(&b->submitted);
}

static void wait_in_own_deque(stilb_job_priority priority)
{
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		if (s.workers == 0)
			continue; /* the owner must then run unrelated jobs as well */
		burial b = {.pool = pool_with(s)};
		hold_workers(b.pool, &b.holding, &b.held, 1, s.workers);
		submit_mixed(&b, priority, 0);
		wait_and_end(&b, s.workers);
	}
}

static void test_between_own_jobs(void **state)
{
	(void)state;
	wait_in_own_deque(STILB_JOB_NORMAL);
}

static void test_of_low_priority(void **state)
{
	(void)state;
	wait_in_own_deque(STILB_JOB_LOW);
}

static void test_batch_between_own_jobs(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		if (s.workers == 0)
			continue; /* as in wait_in_own_deque */
		burial b = {.pool = pool_with(s)};
		hold_workers(b.pool, &b.holding, &b.held, 1, s.workers);
		submit_batches(&b, 0);
		wait_and_end(&b, s.workers);
	}
}

static void submit_from_worker(void *data, uint32_t worker)
{
	submit_mixed(data, STILB_JOB_NORMAL, worker);
}

static void submit_batches_from_worker(void *data, uint32_t worker)
{
	submit_batches(data, worker);
}

/* The only worker that is free submits the jobs, and then begins with an unrelated one of them. */
static void wait_in_deque_of_worker(stilb_job_fn *submit)
{
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		if (s.workers == 0)
			continue;
		burial b = {.pool = pool_with(s)};
		if (s.workers > 1)
			hold_workers(b.pool, &b.holding, &b.held, 2, s.workers);
		submit_pinned(b.pool, submit, &b, NULL, 1, 0);
		assert_true(await(&b.submitted, 1));
		while (count_of(&b.stranger.inside) == 0)
			nap_us(50);
		wait_and_end(&b, s.workers);
	}
}

static void test_between_the_jobs_of_a_worker(void **state)
{
	(void)state;
	wait_in_deque_of_worker(submit_from_worker);
}

static void test_batch_between_the_jobs_of_a_worker(void **state)
{
	(void)state;
	wait_in_deque_of_worker(submit_batches_from_worker);
}

/* ---- at random ------------------------------------------------------------------------------------------------- */

enum { ROOTS = 8, ROUNDS = 40, JOBS = 400 };

typedef struct crowd {
	stilb_job_pool *pool;
	stilb_job_group root[ROOTS];
	counter ran[ROOTS], wrong;
} crowd;

typedef struct crowd_job {
	crowd *crowd;
	uint32_t root, children;
} crowd_job;

static void run_crowd_job(void *data, uint32_t worker)
{
	crowd_job *job = data;
	crowd *c = job->crowd;
	stilb_job_group inner = {0};
	crowd_job child[3];
	for (uint32_t i = 0; i < job->children; i++) {
		child[i] = (crowd_job){.crowd = c, .root = job->root, .children = job->children - 1};
		if (stilb_job_submit(c->pool, run_crowd_job, &child[i], &inner, worker) != 0)
			count_up(&c->wrong);
	}
	stilb_job_wait(c->pool, &inner, worker);
	count_up(&c->ran[job->root]);
}

/* Jobs of eight roots lie mixed in the owner's deque, and they submit and wait for children on all threads. */
static void test_many_roots(void **state)
{
	(void)state;
	static const uint32_t family[] = {1, 2, 5, 16}; /* the job and its descendants, for 0 to 3 children */
	uint64_t random = 1;
	static crowd_job job[JOBS];
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		crowd c = {.pool = pool_with(s)};
		for (int round = 0; round < ROUNDS; round++) {
			uint32_t wanted[ROOTS] = {0};
			for (uint32_t i = 0; i < JOBS; i++) {
				uint32_t bits = (uint32_t)next_random(&random);
				job[i] = (crowd_job){.crowd = &c, .root = bits % ROOTS, .children = bits / ROOTS % 4};
				wanted[job[i].root] += family[job[i].children];
				stilb_job_priority priority = bits >> 16 & 7 ? STILB_JOB_NORMAL : STILB_JOB_LOW;
				stilb_job_options options = {.priority = priority};
				assert_int_equal(
					stilb_job_submit_with(c.pool, run_crowd_job, &job[i], &c.root[job[i].root], &options, 0), 0);
			}
			for (uint32_t i = 0; i < ROOTS; i++) {
				uint32_t root = (i * 3 + (uint32_t)round) % ROOTS;
				stilb_job_wait(c.pool, &c.root[root], 0);
				assert_int_equal(count_of(&c.ran[root]), wanted[root]);
				atomic_store_explicit(&c.ran[root], 0, memory_order_relaxed);
			}
		}
		assert_int_equal(c.wrong, 0);
		stilb_job_pool_destroy(c.pool);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_between_own_jobs),
		cmocka_unit_test(test_batch_between_own_jobs),
		cmocka_unit_test(test_of_low_priority),
		cmocka_unit_test(test_between_the_jobs_of_a_worker),
		cmocka_unit_test(test_batch_between_the_jobs_of_a_worker),
		cmocka_unit_test(test_many_roots),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
