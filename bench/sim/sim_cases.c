#include "bench/sim/sim_cases.h"

#include "jobs/job_internal.h"

#include <stdatomic.h>
#include <stdio.h>

#define FALL_ASLEEP_NS 100e6 /* after this long without work every worker sleeps, also the one that watches for loops */
#define GIVE_UP_NS 50e6

uint32_t sim_pool_threads;

static struct {
	/* Workers that have woken up since the case began to count. Release in on_wake, pairs with the acquire in
	 * wait_awake. */
	_Atomic uint32_t awake;
	_Atomic double last; /* when the last of them did; relaxed: `awake` publishes it */
} woken;

static void on_wake(void *user, uint32_t worker)
{
	(void)user, (void)worker;
	double now = sim_now(), last = atomic_load_explicit(&woken.last, memory_order_relaxed);
	while (last < now &&
	       !atomic_compare_exchange_weak_explicit(&woken.last, &last, now, memory_order_relaxed, memory_order_relaxed))
		;
	atomic_fetch_add_explicit(&woken.awake, 1, memory_order_release);
}

static stilb_job_pool *pool_create(void)
{
	uint32_t threads = sim_pool_threads > 0 ? sim_pool_threads : sim_cpus();
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	desc.worker_count = threads - 1;
	desc.hooks.wake = on_wake;
	stilb_job_pool *pool;
	if (stilb_job_pool_create(&desc, &pool) != 0) {
		fprintf(stderr, "stilb-bench-sim: no pool\n");
		return NULL;
	}
	sim_sleep(FALL_ASLEEP_NS);
	atomic_store_explicit(&woken.awake, 0, memory_order_relaxed); /* relaxed: all others sleep */
	return pool;
}

/* Waits until all workers that a phase wakes, one for each CPU but the caller's, have woken up, and returns how long
 * that took since `begin`; 0 if it wakes none. */
static double wait_awake(stilb_job_pool *pool, double begin)
{
	uint32_t workers = stilb_job_pool_worker_count(pool), others = sim_cpus() > 2 ? sim_cpus() - 1 : 1;
	uint32_t expected = workers < others ? workers : others;
	/* Acquire pairs with the release in on_wake. */
	while (atomic_load_explicit(&woken.awake, memory_order_acquire) < expected && sim_now() < begin + GIVE_UP_NS)
		sim_work(500.0);
	double last = atomic_load_explicit(&woken.last, memory_order_relaxed);
	return expected > 0 ? last - begin : 0.0;
}

/* The beginning of what a case measures. */
static double begin_counting(void)
{
	sim_lines_reset();
	return sim_now();
}

static void phase_begin(void *result)
{
	stilb_job_pool *pool = pool_create();
	double begin = begin_counting();
	stilb_job_phase_begin(pool);
	*(double *)result = wait_awake(pool, begin) / 1000.0;
	stilb_job_phase_end(pool);
	stilb_job_pool_destroy(pool);
}

/* The time of one look for work of the owner. */
static double look(stilb_job_pool *pool)
{
	enum { LOOKS = 64 };
	double begin = 0.0;
	for (int i = -LOOKS; i < LOOKS; i++) {
		if (i == 0)
			begin = begin_counting();
		job_work_help(&pool->slot[0], &job_scope_all, NULL);
	}
	return (sim_now() - begin) / LOOKS;
}

static void look_alone(void *result)
{
	stilb_job_pool *pool = pool_create();
	*(double *)result = look(pool);
	stilb_job_pool_destroy(pool);
}

static void look_together(void *result)
{
	stilb_job_pool *pool = pool_create();
	stilb_job_phase_begin(pool);
	wait_awake(pool, sim_now());
	*(double *)result = look(pool);
	stilb_job_phase_end(pool);
	stilb_job_pool_destroy(pool);
}

static void slice_empty(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)begin, (void)end, (void)worker, (void)context;
}

static void slice_1us(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker, (void)context;
	sim_work(1000.0 * (end - begin));
}

static void slice_200ns(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker, (void)context;
	sim_work(200.0 * (end - begin));
}

/* The time of a loop, in us, when others have just run before it. */
static double loops(uint32_t slices, stilb_job_range_fn *fn, bool phase)
{
	enum { WARM = 12, LOOPS = 16 };
	stilb_job_pool *pool = pool_create();
	if (phase) {
		stilb_job_phase_begin(pool);
		wait_awake(pool, sim_now());
	}
	double begin = 0.0;
	for (int i = -WARM; i < LOOPS; i++) {
		if (i == 0)
			begin = begin_counting();
		stilb_job_parallel_for(pool, slices, 1, fn, NULL, 0);
	}
	double time = (sim_now() - begin) / LOOPS;
	if (phase)
		stilb_job_phase_end(pool);
	stilb_job_pool_destroy(pool);
	return time / 1000.0;
}

static void join_8_empty(void *result)
{
	*(double *)result = loops(8, slice_empty, true);
}

static void join_8(void *result)
{
	*(double *)result = loops(8, slice_1us, true);
}

static void join_64_empty(void *result)
{
	*(double *)result = loops(64, slice_empty, true);
}

static void join_64(void *result)
{
	*(double *)result = loops(64, slice_1us, true);
}

static void loop_20000(void *result)
{
	stilb_job_pool *pool = pool_create();
	double begin = 0.0;
	for (int i = -2; i < 4; i++) {
		if (i == 0)
			begin = begin_counting();
		stilb_job_parallel_for(pool, 20000, 1, slice_200ns, NULL, 0);
	}
	*(double *)result = (sim_now() - begin) / 4e6;
	stilb_job_pool_destroy(pool);
}

static void job_empty(void *data, uint32_t worker)
{
	(void)data, (void)worker;
}

static void spawn(void *result)
{
	enum { JOBS = 10000 };
	stilb_job_pool *pool = pool_create();
	double begin = 0.0;
	for (int i = -1; i < 2; i++) {
		stilb_job_group group = {0};
		if (i == 0)
			begin = begin_counting();
		for (int j = 0; j < JOBS; j++)
			stilb_job_submit(pool, job_empty, NULL, &group, 0);
		stilb_job_wait(pool, &group, 0);
	}
	*(double *)result = (sim_now() - begin) / (2.0 * JOBS);
	stilb_job_pool_destroy(pool);
}

typedef struct fib_job {
	stilb_job_pool *pool;
	uint32_t n;
	uint64_t result;
} fib_job;

static void fib(void *data, uint32_t worker)
{
	fib_job *job = data;
	if (job->n < 2) {
		job->result = job->n;
		return;
	}
	fib_job one = {job->pool, job->n - 1, 0}, two = {job->pool, job->n - 2, 0};
	stilb_job_group group = {0};
	stilb_job_submit(job->pool, fib, &one, &group, worker);
	fib(&two, worker);
	stilb_job_wait(job->pool, &group, worker);
	job->result = one.result + two.result;
}

/* The median of several runs: if there are more threads than CPUs, a run takes one of two times, as a worker comes to
 * help or not. */
static void fib_18(void *result)
{
	enum { RUNS = 9 };
	double times[RUNS];
	fib_job job = {pool_create(), 18, 0};
	fib(&job, 0); /* warms up */
	for (int i = 0; i < RUNS; i++) {
		double begin = begin_counting();
		fib(&job, 0);
		double time = (sim_now() - begin) / 1000.0;
		int at = i;
		for (; at > 0 && times[at - 1] > time; at--)
			times[at] = times[at - 1];
		times[at] = time;
	}
	*(double *)result = times[RUNS / 2];
	if (job.result != 2584)
		fprintf(stderr, "stilb-bench-sim: wrong fib\n");
	stilb_job_pool_destroy(job.pool);
}

const sim_case sim_cases[] = {
	{"phase", "from the begin of a phase until all workers have woken up", "us", phase_begin},
	{"look", "a look for work that finds none, all others asleep", "ns", look_alone},
	{"look-phase", "a look for work that finds none, all others looking, too", "ns", look_together},
	{"join-8-empty", "fork-join of 8 empty slices in a phase", "us", join_8_empty},
	{"join-64-empty", "fork-join of 64 empty slices in a phase", "us", join_64_empty},
	{"join-8", "fork-join of 8 slices of 1 us in a phase", "us", join_8},
	{"join-64", "fork-join of 64 slices of 1 us in a phase", "us", join_64},
	{"spawn", "one of 10,000 empty jobs submitted by one thread", "ns", spawn},
	{"fib", "fib(18) by jobs", "us", fib_18},
	{"loop", "20,000 slices of 200 ns", "ms", loop_20000},
};
const size_t sim_case_count = sizeof sim_cases / sizeof *sim_cases;

double sim_case_run(const sim_case *which, const sim_machine *machine, uint32_t cpus)
{
	double result = 0.0;
	sim_run(machine, cpus, which->run, &result);
	return result;
}
