/* main of the programs of the suite `jobs`: runs one case (a workload) with one subject (a job system), verifies that
 * each job ran exactly once, prints the metrics. */
#include "bench/harness/bench_child.h"
#include "bench/jobs/jobs_arrays.h"
#include "bench/jobs/jobs_cases.h"
#include "bench/jobs/jobs_subject.h"

#include <dirent.h>
#include <pthread.h>
#include <sched.h>
#include <stdalign.h>
#include <stdatomic.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#define NS_PER_MS UINT64_C(1000000)
#define LINE 128                         /* two cache lines: the adjacent-line prefetcher pairs them */
#define MAX_THREADS 16                   /* outside threads of a case */
#define MAX_SAMPLES (1u << 20)           /* of a metric; later samples are dropped */
#define START_TIMEOUT (200 * NS_PER_MS)  /* the submitter then waits, and so helps, if no worker has started the job */
#define WARM_UP_TIMEOUT (50 * NS_PER_MS) /* the warm-up ends then, even if some thread has not run a job */
#define BURN_WINDOW (20 * NS_PER_MS)     /* the metric `burnt` is the CPU time used in this time after the last job */

/* ---- samples ------------------------------------------------------------------------------------------------- */

/* Measured times of one metric, ns; times from 2^32 ns on are stored as 2^32 - 1. */
typedef struct samples {
	uint32_t count;
	uint32_t at[MAX_SAMPLES];
} samples;

static void samples_add(samples *set, uint64_t ns)
{
	if (set->count < MAX_SAMPLES)
		set->at[set->count++] = ns < UINT32_MAX ? (uint32_t)ns : UINT32_MAX;
}

static int samples_order(const void *a, const void *b)
{
	uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
	return (x > y) - (x < y);
}

static void samples_sort(samples *set)
{
	qsort(set->at, set->count, sizeof set->at[0], samples_order);
}

/* The quantile `part` of sorted samples: 0 the least, 1 the largest; 0 if there are none. */
static double samples_quantile(const samples *set, double part)
{
	return set->count ? (double)set->at[(uint32_t)(part * (set->count - 1) + 0.5)] : 0.0;
}

static double samples_mean(const samples *set)
{
	double sum = 0.0;
	for (uint32_t i = 0; i < set->count; i++)
		sum += (double)set->at[i];
	return set->count ? sum / (double)set->count : 0.0;
}

/* ---- work, and its verification ------------------------------------------------------------------------------ */

/* Sums over the jobs that a thread has run. The sums of all threads differ from the expected ones if a job was lost,
 * repeated or replaced by another. Tallies form a list, one for each thread that has ever run a job. */
typedef struct tally {
	alignas(LINE) uint64_t count;
	uint64_t squares; /* sum of the squares of the jobs' numbers */
	uint64_t results;
	struct tally *next;
} tally;

static _Thread_local tally *own_tally;
static _Atomic(tally *) tallies;

static __attribute__((noinline)) tally *tally_create(void)
{
	tally *own = aligned_alloc(LINE, sizeof *own);
	if (!own)
		bench_child_fail("out of memory");
	*own = (tally){.next = atomic_load_explicit(&tallies, memory_order_relaxed)}; /* an old value fails the exchange */
	/* Release pairs with the acquires in tally_take and tally_count. */
	while (
		!atomic_compare_exchange_weak_explicit(&tallies, &own->next, own, memory_order_release, memory_order_relaxed))
		;
	return own_tally = own;
}

static inline tally *tally_own(void)
{
	return own_tally ? own_tally : tally_create();
}

static inline void tally_add(tally *own, uint64_t number, uint64_t result)
{
	own->count++;
	own->squares += number * number;
	own->results += result;
}

/* Returns the sums of all threads since the last call, and resets them. No job may run meanwhile: the job system's wait
 * for the jobs has made the threads' writes visible. */
static tally tally_take(void)
{
	tally sum = {0};
	for (tally *at = atomic_load_explicit(&tallies, memory_order_acquire); at; at = at->next) { /* see tally_create */
		sum.count += at->count;
		sum.squares += at->squares;
		sum.results += at->results;
		at->count = at->squares = at->results = 0;
	}
	return sum;
}

/* The number of threads that have ever run a job. */
static uint32_t tally_count(void)
{
	uint32_t count = 0;
	for (tally *at = atomic_load_explicit(&tallies, memory_order_acquire); at; at = at->next) /* see tally_create */
		count++;
	return count;
}

/* Takes time: each multiplication depends on the one before, and the first on `before`, the result of the previous
 * chain; otherwise an out-of-order CPU would overlap two chains. */
static uint64_t chain(uint64_t x, uint64_t before, uint32_t multiplications)
{
	uint64_t nothing = 0;
	__asm__ volatile("" : "+r"(nothing)); /* hides the value from the compiler */
	x += before & nothing;
	for (uint32_t i = 0; i < multiplications; i++) {
		x = (x | 1) * UINT64_C(0x9E3779B97F4A7C15);
		__asm__ volatile("" : "+r"(x)); /* keeps the compiler from combining multiplications */
	}
	return x;
}

/* Multiplications in a microsecond: the fastest of 50 tries, since disturbances only make it slower. */
static double chain_rate(void)
{
	uint32_t multiplications = 100000;
	uint64_t best = UINT64_MAX;
	for (uint32_t i = 0; i < 50; i++) {
		uint64_t begin = bench_child_now_ns();
		chain(i, 0, multiplications);
		uint64_t time = bench_child_now_ns() - begin;
		best = time < best ? time : best;
	}
	return multiplications * 1e3 / (double)best;
}

/* ---- a run --------------------------------------------------------------------------------------------------- */

typedef struct run {
	const jobs_case *on;
	const jobs_subject *subject;
	uint64_t duration;  /* ns */
	double per_us;      /* multiplications in a microsecond */
	uint32_t chain;     /* multiplications in each job */
	bool is_short;      /* JOBS_LATE: the slices of late_slice take a microsecond and are not verified */
	uint64_t turns;     /* measured so far */
	uint32_t divisor;   /* all times are divided by it: 1, or for `ideal` the number of threads that can run at once */
	samples turn_times; /* the time of each turn */
	/* JOBS_WAKE, JOBS_STEAL: times from the call of submit until the job starts, until submit returns, and until
	 * another thread takes the job. */
	samples starts, submits, steals;
	/* The time at which the job of turn_start started, ns; 0 before. Release in start_job, pairs with the acquire in
	 * turn_start. */
	alignas(LINE) _Atomic uint64_t started;
} run;

static void empty_job(void *data, uint32_t worker)
{
	(void)worker;
	tally_add(tally_own(), (uintptr_t)data, 0);
}

static void empty_slice(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker, (void)context;
	for (uint32_t i = begin; i < end; i++)
		tally_add(tally_own(), i, 0);
}

static void chain_slice(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const run *r = context;
	tally *own = tally_own();
	(void)worker;
	for (uint32_t i = begin; i < end; i++)
		tally_add(own, i, chain(i, own->results, r->chain));
}

static void chain_range(uint64_t begin, uint64_t end, uint32_t worker, void *context)
{
	chain_slice((uint32_t)begin, (uint32_t)end, worker, context);
}

static void start_job(void *data, uint32_t worker)
{
	run *r = data;
	(void)worker;
	tally_add(tally_own(), 0, 0);
	atomic_store_explicit(&r->started, bench_child_now_ns(), memory_order_release); /* pairs with turn_start */
}

static void turn_spawn(run *r)
{
	r->subject->spawn(empty_job, NULL, r->on->count);
}

static void turn_batch(run *r)
{
	r->subject->batch(empty_job, NULL, r->on->count);
}

static void turn_array(run *r)
{
	r->subject->array(empty_slice, NULL, r->on->count);
}

static void turn_join(run *r)
{
	r->subject->join(chain_slice, r, r->on->count);
}

static void turn_loop(run *r)
{
	r->subject->loop(chain_slice, r, r->on->count);
}

static void short_slice(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const run *r = context;
	(void)worker;
	for (uint32_t i = begin; i < end; i++)
		chain(i, 0, (uint32_t)r->per_us);
}

static void late_slice(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const run *r = context;
	(r->is_short ? short_slice : chain_slice)(begin, end, worker, context);
}

/* The loops before each turn of JOBS_LATE, after which a job system may expect that the next is as short. */
static void run_short_loops(run *r)
{
	r->is_short = true;
	for (int i = 0; i < 1000; i++)
		r->subject->loop(r->on->other ? short_slice : late_slice, r, 2);
	r->is_short = false;
}

static void turn_late(run *r)
{
	r->subject->loop(late_slice, r, r->on->count);
}

static void turn_range(run *r)
{
	r->subject->range(chain_range, r, r->on->count);
}

static void turn_tiles(run *r)
{
	jobs_tiles_run(r->subject);
}

static void turn_reduce(run *r)
{
	jobs_reduce_run(r->subject);
}

static void turn_sort(run *r)
{
	jobs_sort_run(r->subject);
}

static void turn_fib(run *r)
{
	if (r->subject->fib(20) != 6765)
		bench_child_fail("fib(20) is wrong");
}

static const run *graph_of; /* the run whose nodes graph_node works for */

static void graph_node(void *data, uint32_t worker)
{
	tally *own = tally_own();
	uint64_t number = (uintptr_t)data;
	(void)worker;
	tally_add(own, number, graph_of->chain ? chain(number, own->results, graph_of->chain) : 0);
}

static void turn_graph(run *r)
{
	r->subject->graph_run();
}

/* The next number of an additive sequence whose high bits serve as random numbers. */
static uint32_t graph_random(uint64_t *state, uint32_t limit)
{
	*state = *state * UINT64_C(6364136223846793005) + 1; /* Knuth, The Art of Computer Programming 2, 3.3.4 */
	return (uint32_t)((*state >> 32) * limit >> 32);
}

static void graph_edge(uint32_t (*edge)[2], uint32_t *edges, uint32_t before, uint32_t after)
{
	edge[*edges][0] = before;
	edge[(*edges)++][1] = after;
}

/* Stores the edges of a graph of this shape and returns their number, at most three a node. */
static uint32_t graph_edges(jobs_graph_shape shape, uint32_t count, uint32_t (*edge)[2])
{
	enum { LAYER = 100, BEFORE = 3 };
	uint32_t edges = 0;
	uint64_t state = 1;
	for (uint32_t i = 1; i < count && shape == JOBS_CHAIN; i++)
		graph_edge(edge, &edges, i - 1, i);
	for (uint32_t i = 1; i < count - 1 && shape == JOBS_FAN; i++) {
		graph_edge(edge, &edges, 0, i);
		graph_edge(edge, &edges, i, count - 1);
	}
	for (uint32_t i = LAYER; i < count && shape == JOBS_LAYERS; i++)
		for (uint32_t k = 0; k < BEFORE; k++)
			graph_edge(edge, &edges, i / LAYER * LAYER - LAYER + graph_random(&state, LAYER), i);
	return edges;
}

static void graph_prepare(run *r)
{
	uint32_t count = r->on->count;
	uint32_t(*edge)[2] = malloc(3 * count * sizeof *edge);
	if (!edge)
		bench_child_fail("out of memory");
	graph_of = r;
	r->subject->graph_make(graph_node, NULL, count, edge, graph_edges(r->on->shape, count, edge));
	free(edge);
}

static void *outside_main(void *data)
{
	const run *r = data;
	r->subject->outside(empty_job, NULL, r->on->count);
	return NULL;
}

static void turn_outside(run *r)
{
	pthread_t threads[MAX_THREADS];
	for (uint32_t i = 0; i < r->on->outside; i++)
		if (pthread_create(&threads[i], NULL, outside_main, r) != 0)
			bench_child_fail("cannot create a thread");
	for (uint32_t i = 0; i < r->on->outside; i++)
		pthread_join(threads[i], NULL);
}

/* One turn of JOBS_WAKE and JOBS_STEAL: submits one job for another thread. The submitter watches r->started instead of
 * waiting, since a wait would run the job here. */
static void turn_start(run *r)
{
	const jobs_subject *subject = r->subject;
	atomic_store_explicit(&r->started, 0, memory_order_relaxed); /* relaxed: submitting the job publishes it */
	uint64_t before = bench_child_now_ns();
	subject->submit(start_job, r);
	uint64_t after = bench_child_now_ns();
	/* Acquire pairs with the release in start_job. */
	while (!atomic_load_explicit(&r->started, memory_order_acquire) && bench_child_now_ns() - before < START_TIMEOUT)
		;
	subject->wait();
	uint64_t started = atomic_load_explicit(&r->started, memory_order_relaxed); /* relaxed: ordered by wait */
	samples_add(&r->starts, started - before);
	samples_add(&r->submits, after - before);
	if (subject->stolen_at)
		samples_add(&r->steals, subject->stolen_at() - before);
}

static void sleep_ns(uint64_t ns)
{
	nanosleep(&(struct timespec){.tv_sec = (time_t)(ns / 1000000000u), .tv_nsec = (long)(ns % 1000000000u)}, NULL);
}

/* Makes the graph or the arrays of a case. */
static void prepare(run *r)
{
	const jobs_case *on = r->on;
	if (on->kind == JOBS_GRAPH)
		graph_prepare(r);
	else if (on->kind == JOBS_TILES)
		jobs_tiles_make(on->count);
	else if (on->kind == JOBS_REDUCE)
		jobs_reduce_make(on->count);
	else if (on->kind == JOBS_SORT)
		jobs_sort_make(on->count, on->ordered);
}

/* Ends the program if the last turn has left a wrong result in an array. */
static void verify_arrays(jobs_kind kind)
{
	if ((kind == JOBS_TILES && !jobs_tiles_right()) || (kind == JOBS_REDUCE && !jobs_reduce_right()) ||
	    (kind == JOBS_SORT && !jobs_sort_right()))
		bench_child_fail("wrong result");
}

/* Ends the program if the sums over all threads are not those of the jobs of all measured turns. */
static void verify(const run *r)
{
	const jobs_case *on = r->on;
	verify_arrays(on->kind);
	if (on->kind == JOBS_FIB || on->kind == JOBS_TILES || on->kind == JOBS_REDUCE || on->kind == JOBS_SORT)
		return; /* turn_fib checks the result, and jobs_arrays.c has its own */
	uint64_t count = on->kind == JOBS_WAKE || on->kind == JOBS_STEAL ? 1 : on->count;
	tally expected = {.count = count}, sum = tally_take();
	for (uint64_t i = 0; i < count; i++) {
		expected.squares += i * i;
		expected.results += r->chain ? chain(i, 0, r->chain) : 0;
	}
	uint64_t times = r->turns * (on->outside ? on->outside : 1);
	if (sum.count != times * expected.count || sum.squares != times * expected.squares ||
	    sum.results != times * expected.results)
		bench_child_fail("wrong result: %llu jobs ran in %llu turns, or their results differ",
		                 (unsigned long long)sum.count, (unsigned long long)r->turns);
}

/* What comes before each turn and is not measured; false if nothing does. */
static bool before_turn(run *r)
{
	if (r->on->kind == JOBS_LATE)
		run_short_loops(r);
	if (r->on->pause_us)
		sleep_ns(r->on->pause_us * UINT64_C(1000));
	if (r->on->kind == JOBS_SORT)
		jobs_sort_fill();
	return r->on->pause_us || r->on->kind == JOBS_SORT;
}

/* Repeats `turn` for the run's duration, at least three times, and notes the time of each. */
static void measure(run *r, void (*turn)(run *r))
{
	before_turn(r);
	turn(r); /* not measured, since it takes the page faults */
	verify_arrays(r->on->kind);
	tally_take();
	r->starts.count = r->submits.count = r->steals.count = 0;
	uint64_t now = bench_child_now_ns(), until = now + r->duration;
	while (now < until || r->turns < 3) {
		if (before_turn(r))
			now = bench_child_now_ns();
		turn(r);
		uint64_t end = bench_child_now_ns();
		samples_add(&r->turn_times, (end - now) / r->divisor);
		now = end;
		r->turns++;
	}
	verify(r);
}

/* CPU time of all threads but this one, ns. The process' own CPU clock lags behind its threads' by up to a tick. */
static uint64_t cpu_time_of_others(void)
{
	uint64_t sum = 0;
	DIR *tasks = opendir("/proc/self/task");
	if (!tasks)
		bench_child_fail("cannot read /proc/self/task");
	for (struct dirent *entry; (entry = readdir(tasks));) {
		int tid = atoi(entry->d_name);
		struct timespec used;
		/* Linux' clock id of a thread's CPU time: ~tid << 3, with 4 (per thread) and 2 (scheduler time). */
		if (tid > 0 && tid != gettid() && clock_gettime((clockid_t)(~(unsigned)tid << 3 | 6), &used) == 0)
			sum += (uint64_t)used.tv_sec * 1000000000u + (uint64_t)used.tv_nsec;
	}
	closedir(tasks);
	return sum;
}

/* Lets the job system work for 5 ms and then be idle, and measures the CPU time of its threads in the first 20 ms of
 * idleness (metric burnt) and in the rest (idle). */
static void measure_idle(run *r)
{
	const jobs_subject *subject = r->subject;
	for (int i = 0; i < 5; i++) {
		if (subject->phase_begin)
			subject->phase_begin();
		for (uint64_t until = bench_child_now_ns() + 5 * NS_PER_MS; bench_child_now_ns() < until; r->turns++)
			turn_join(r);
		if (subject->phase_end)
			subject->phase_end();
		uint64_t before = cpu_time_of_others();
		sleep_ns(BURN_WINDOW);
		samples_add(&r->turn_times, cpu_time_of_others() - before);
	}
	samples_sort(&r->turn_times);
	bench_child_metric("burnt", samples_quantile(&r->turn_times, 0.5) * 1e-6);
	bench_child_metric("burnt-worst", samples_quantile(&r->turn_times, 1) * 1e-6);
	uint64_t used = cpu_time_of_others(), begin = bench_child_now_ns();
	sleep_ns(r->duration);
	used = cpu_time_of_others() - used;
	bench_child_metric("idle", 100.0 * (double)used / (double)(bench_child_now_ns() - begin));
	verify(r);
}

/* ---- metrics ------------------------------------------------------------------------------------------------- */

static void print_rate(run *r)
{
	double jobs = (double)r->on->count * (r->on->outside ? r->on->outside : 1);
	samples_sort(&r->turn_times);
	bench_child_metric("rate", jobs * 1e3 / samples_quantile(&r->turn_times, 0.5));
	bench_child_metric("slowest", jobs * 1e3 / samples_quantile(&r->turn_times, 1));
}

static void print_time(samples *set, const char *prefix, double ns_per_unit)
{
	static const struct {
		const char *name;
		double part;
	} quantiles[] = {{"p50", 0.5}, {"p99", 0.99}, {"worst", 1.0}};
	samples_sort(set);
	for (size_t i = 0; i < sizeof quantiles / sizeof *quantiles; i++) {
		char metric[48];
		snprintf(metric, sizeof metric, "%s%s", prefix, quantiles[i].name);
		bench_child_metric(metric, samples_quantile(set, quantiles[i].part) / ns_per_unit);
	}
}

static void print_times_us(run *r)
{
	print_time(&r->turn_times, "", 1e3);
}

static void print_times_ms(run *r)
{
	print_time(&r->turn_times, "", 1e6);
}

static void print_late(run *r)
{
	samples_sort(&r->turn_times);
	bench_child_metric("p50", samples_quantile(&r->turn_times, 0.5) / 1e6);
	bench_child_metric("p97", samples_quantile(&r->turn_times, 39.0 / 40.0) / 1e6);
	bench_child_metric("worst", samples_quantile(&r->turn_times, 1.0) / 1e6);
}

static void print_wake(run *r)
{
	print_time(&r->starts, "start-", 1e3);
	print_time(&r->submits, "submit-", 1e3);
}

static void print_steal(run *r)
{
	print_time(&r->starts, "start-", 1.0);
	if (r->subject->stolen_at) {
		bench_child_metric("taken-mean", samples_mean(&r->steals));
		print_time(&r->steals, "taken-", 1.0);
	}
}

/* ---- the program --------------------------------------------------------------------------------------------- */

/* Pins thread i of the process to the i-th CPU that it may use, modulo their number; the main thread is number 0. */
static void pin_threads(void)
{
	cpu_set_t allowed;
	DIR *tasks = opendir("/proc/self/task");
	if (!tasks || sched_getaffinity(0, sizeof allowed, &allowed) != 0)
		bench_child_fail("cannot pin threads");
	int cpu = -1;
	for (struct dirent *entry; (entry = readdir(tasks));) {
		int tid = atoi(entry->d_name);
		if (tid <= 0)
			continue;
		do
			cpu = (cpu + 1) % CPU_SETSIZE;
		while (!CPU_ISSET(cpu, &allowed));
		cpu_set_t one;
		CPU_ZERO(&one);
		CPU_SET(cpu, &one);
		sched_setaffinity(tid, sizeof one, &one);
	}
	closedir(tasks);
}

/* Runs jobs until every thread has run one, since some subjects create their threads late. */
static void warm_up(run *r)
{
	if (!r->subject->join || r->subject->ideal)
		return;
	uint32_t usual = r->chain;
	r->chain = (uint32_t)(10.0 * r->per_us);
	for (uint64_t until = bench_child_now_ns() + WARM_UP_TIMEOUT;
	     tally_count() < r->on->threads && bench_child_now_ns() < until;)
		r->subject->join(chain_slice, r, 2 * r->on->threads);
	r->chain = usual;
	tally_take();
}

/* For each kind of case the function that runs one turn, and the one that prints the metrics. */
static const struct {
	void (*turn)(run *r);
	void (*print)(run *r);
} kinds[] = {
	[JOBS_SPAWN] = {turn_spawn, print_rate},       [JOBS_ARRAY] = {turn_array, print_rate},
	[JOBS_OUTSIDE] = {turn_outside, print_rate},   [JOBS_JOIN] = {turn_join, print_times_us},
	[JOBS_LOOP] = {turn_loop, print_times_ms},     [JOBS_FIB] = {turn_fib, print_times_ms},
	[JOBS_GRAPH] = {turn_graph, print_times_us},   [JOBS_WAKE] = {turn_start, print_wake},
	[JOBS_STEAL] = {turn_start, print_steal},      [JOBS_IDLE] = {NULL, NULL},
	[JOBS_BATCH] = {turn_batch, print_rate},       [JOBS_LATE] = {turn_late, print_late},
	[JOBS_RANGE] = {turn_range, print_times_ms},   [JOBS_TILES] = {turn_tiles, print_times_ms},
	[JOBS_REDUCE] = {turn_reduce, print_times_ms}, [JOBS_SORT] = {turn_sort, print_times_ms},
};

/* True if the subject has the functions for cases of this kind. */
static bool able(const jobs_subject *subject, jobs_kind kind)
{
	switch (kind) {
	case JOBS_SPAWN:
		return subject->spawn;
	case JOBS_ARRAY:
		return subject->array;
	case JOBS_BATCH:
		return subject->batch;
	case JOBS_OUTSIDE:
		return subject->outside;
	case JOBS_JOIN:
	case JOBS_IDLE:
		return subject->join;
	case JOBS_LOOP:
	case JOBS_LATE:
		return subject->loop;
	case JOBS_FIB:
		return subject->fib;
	case JOBS_GRAPH:
		return subject->graph_make;
	case JOBS_RANGE:
		return subject->range;
	case JOBS_TILES:
		return subject->tiles;
	case JOBS_REDUCE:
		return subject->reduce;
	case JOBS_SORT:
		return subject->sort;
	case JOBS_WAKE:
	case JOBS_STEAL:
		return subject->submit;
	}
	return false;
}

static void run_inside(void *context)
{
	run *r = context;
	bool phase = r->on->phase && r->on->kind != JOBS_IDLE && r->subject->phase_begin;
	warm_up(r);
	prepare(r);
	if (r->on->pinned)
		pin_threads();
	if (r->on->kind == JOBS_IDLE) {
		measure_idle(r);
		return;
	}
	if (phase)
		r->subject->phase_begin();
	measure(r, kinds[r->on->kind].turn);
	if (phase)
		r->subject->phase_end();
	kinds[r->on->kind].print(r);
}

static const jobs_case cases[] = {
#define CASE(NAME, TITLE, KIND, ...) {.name = NAME, .kind = JOBS_##KIND, __VA_ARGS__},
	JOBS_CASES(CASE)
#undef CASE
};

static jobs_case find_case(const char *name, uint32_t cpus)
{
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
		if (strcmp(cases[i].name, name) == 0) {
			jobs_case found = cases[i];
			found.threads = found.threads ? found.threads : cpus;
			return found;
		}
	bench_child_fail("no case %s", name);
}

static const jobs_subject *find_subject(const char *name)
{
	for (const jobs_subject *const *at = jobs_subjects; *at; at++)
		if (strcmp((*at)->name, name) == 0)
			return *at;
	bench_child_fail("no subject %s", name);
}

int main(int argc, char **argv)
{
	static run r;
	bench_child child = bench_child_args(argc, argv);
	if (strcmp(child.case_name, "calibrate") == 0) {
		bench_child_metric("per-us", chain_rate());
		return 0;
	}
	uint32_t cpus = bench_child_cpu_count();
	jobs_case on = find_case(child.case_name, cpus);
	r.on = &on;
	r.subject = find_subject(child.subject);
	r.duration = (uint64_t)(child.seconds * 1e9);
	r.per_us = child.argument ? strtod(child.argument, NULL) : chain_rate();
	r.chain = (uint32_t)(r.on->microseconds * r.per_us);
	r.divisor = !r.subject->ideal ? 1 : r.on->threads < cpus ? r.on->threads : cpus;
	if (!able(r.subject, r.on->kind))
		return BENCH_CHILD_SKIP;
	if (!r.subject->open(r.on->threads, r.on->kind == JOBS_STEAL))
		bench_child_fail("cannot start the job system");
	if (r.subject->inside)
		r.subject->inside(run_inside, &r);
	else
		run_inside(&r);
	r.subject->close();
	return 0;
}
