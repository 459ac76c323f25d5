/* Subjects of the suite `jobs`: Stilb's job pool with its two kinds of queue, with the queue of Sutter's article and
 * with a mutex queue (bench/subjects). */
#include "bench/harness/bench_child.h"
#include "bench/jobs/jobs_subject.h"
#include "bench/subjects/queue_subjects.h"
#include "jobs/job_graph.h"
#include "jobs/job_internal.h"
#include "jobs/range/job_range.h"
#include "jobs/range/job_sort.h"

static stilb_job_pool *pool;
static stilb_job_graph *graph;
static stilb_job_group group; /* contains the job of `submit` until `wait` returns */
static uint64_t last_steal;   /* ns; the thief writes it before the job runs, stolen_at reads it after `wait` */

static void note_steal(void *user, uint32_t worker, uint32_t victim)
{
	(void)user, (void)worker, (void)victim;
	last_steal = bench_child_now_ns();
}

static stilb_job_pool_desc describe(uint32_t threads, bool steals)
{
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	desc.worker_count = threads - 1;
	if (steals)
		desc.hooks.steal = note_steal;
	return desc;
}

static bool open_low_lock(uint32_t threads, bool steals)
{
	stilb_job_pool_desc desc = describe(threads, steals);
	desc.queue = STILB_JOB_QUEUE_LOW_LOCK;
	return stilb_job_pool_create(&desc, &pool) == 0;
}

static bool open_lock_free(uint32_t threads, bool steals)
{
	stilb_job_pool_desc desc = describe(threads, steals);
	desc.queue = STILB_JOB_QUEUE_LOCK_FREE;
	return stilb_job_pool_create(&desc, &pool) == 0;
}

static stilb_job_queue *make_sutter(void)
{
	stilb_job_queue_desc desc = stilb_job_queue_desc_default();
	stilb_job_queue *queue;
	return queue_sutter_create(&desc, &queue) == 0 ? queue : NULL;
}

static stilb_job_queue *make_mutex(void)
{
	stilb_job_queue_desc desc = stilb_job_queue_desc_default();
	stilb_job_queue *queue;
	return queue_mutex_create(&desc, &queue) == 0 ? queue : NULL;
}

static bool open_over_sutter(uint32_t threads, bool steals)
{
	stilb_job_pool_desc desc = describe(threads, steals);
	return job_pool_create_over(&desc, make_sutter, &pool) == 0;
}

static bool open_over_mutex(uint32_t threads, bool steals)
{
	stilb_job_pool_desc desc = describe(threads, steals);
	return job_pool_create_over(&desc, make_mutex, &pool) == 0;
}

static void close_pool(void)
{
	stilb_job_graph_destroy(graph);
	stilb_job_pool_destroy(pool);
}

static void must(int error)
{
	if (error)
		bench_child_fail("a call of the job system failed: %d", error);
}

static void spawn_as(jobs_fn *fn, char *data, uint32_t count, uint32_t worker)
{
	stilb_job_group jobs = {0};
	for (uint32_t i = 0; i < count; i++)
		must(stilb_job_submit(pool, fn, data + i, &jobs, worker));
	stilb_job_wait(pool, &jobs, worker);
}

static void spawn(jobs_fn *fn, char *data, uint32_t count)
{
	spawn_as(fn, data, count, 0);
}

static void outside(jobs_fn *fn, char *data, uint32_t count)
{
	spawn_as(fn, data, count, STILB_JOB_OUTSIDE);
}

static void batch(jobs_fn *fn, char *data, uint32_t count)
{
	stilb_job_group jobs = {0};
	must(stilb_job_submit_n(pool, fn, data, 1, count, &jobs, 0));
	stilb_job_wait(pool, &jobs, 0);
}

static void array(jobs_range_fn *fn, void *context, uint32_t count)
{
	stilb_job_group jobs = {0};
	must(stilb_job_submit_array(pool, count, 1, fn, context, &jobs, 0));
	stilb_job_wait(pool, &jobs, 0);
}

static void loop(jobs_range_fn *fn, void *context, uint32_t count)
{
	stilb_job_parallel_for(pool, count, 1, fn, context, 0);
}

static void range(jobs_range_64_fn *fn, void *context, uint64_t count)
{
	stilb_job_parallel_for_64(pool, count, 1, fn, context, 0);
}

typedef struct tile_call {
	jobs_tile_fn *fn;
	void *context;
} tile_call;

static void run_tile(stilb_job_tile tile, uint32_t worker, void *context)
{
	const tile_call *call = context;
	call->fn(tile.x_begin, tile.x_end, tile.y_begin, tile.y_end, worker, call->context);
}

static void tiles(jobs_tile_fn *fn, void *context, uint32_t width, uint32_t height)
{
	stilb_job_parallel_for_tiles(pool, width, height, 0, 0, run_tile, &(tile_call){fn, context}, 0);
}

typedef struct fold_call {
	jobs_fold_fn *fn;
	void *context;
} fold_call;

static void fold(uint64_t begin, uint64_t end, void *value, uint32_t worker, void *context)
{
	const fold_call *call = context;
	(void)worker;
	call->fn(begin, end, value, call->context);
}

static void combine(void *left, const void *right, void *context)
{
	(void)context;
	*(double *)left += *(const double *)right;
}

static double reduce(jobs_fold_fn *fn, void *context, uint64_t count)
{
	double zero = 0.0, sum = 0.0;
	fold_call call = {fn, context};
	stilb_job_reduction reduction = {
		.size = sizeof sum, .identity = &zero, .fold = fold, .combine = combine, .context = &call};
	must(stilb_job_reduce(pool, count, JOBS_REDUCE_GRAIN, &reduction, &sum, 0));
	return sum;
}

static int by_key(const void *a, const void *b, void *context)
{
	const jobs_element *left = a, *right = b;
	(void)context;
	return (left->key > right->key) - (left->key < right->key);
}

static void sort(jobs_element *elements, uint32_t count)
{
	must(stilb_job_sort(pool, elements, count, sizeof *elements, by_key, NULL, 0));
}

/* The data of one job of fib, on the stack of the call that waits for it. */
typedef struct fib_call {
	uint32_t n;
	uint64_t result;
} fib_call;

static uint64_t fib_on(uint32_t n, uint32_t worker);

static void fib_job(void *data, uint32_t worker)
{
	fib_call *call = data;
	call->result = fib_on(call->n, worker);
}

static uint64_t fib_on(uint32_t n, uint32_t worker)
{
	if (n < 2)
		return n;
	stilb_job_group jobs = {0};
	fib_call first = {.n = n - 1};
	must(stilb_job_submit(pool, fib_job, &first, &jobs, worker));
	uint64_t second = fib_on(n - 2, worker);
	stilb_job_wait(pool, &jobs, worker);
	return first.result + second;
}

static uint64_t fib(uint32_t n)
{
	return fib_on(n, 0);
}

static void graph_run(void)
{
	stilb_job_group run = {0};
	must(stilb_job_graph_run(graph, pool, &run, 0));
	stilb_job_wait(pool, &run, 0);
}

static void graph_make(jobs_fn *fn, char *data, uint32_t count, const uint32_t (*edge)[2], uint32_t edges)
{
	must(stilb_job_graph_create(&graph));
	for (uint32_t i = 0, node; i < count; i++)
		must(stilb_job_graph_add_node(graph, fn, data + i, NULL, &node));
	for (uint32_t i = 0; i < edges; i++)
		must(stilb_job_graph_add_edge(graph, edge[i][0], edge[i][1]));
	must(stilb_job_graph_build(graph, NULL, 0));
	graph_run();
}

static void submit(jobs_fn *fn, void *data)
{
	must(stilb_job_submit(pool, fn, data, &group, 0));
}

static void wait(void)
{
	stilb_job_wait(pool, &group, 0);
}

static void phase_begin(void)
{
	stilb_job_phase_begin(pool);
}

static void phase_end(void)
{
	stilb_job_phase_end(pool);
}

static uint64_t stolen_at(void)
{
	return last_steal;
}

#define POOL(NAME, OPEN)                                                                                               \
	{                                                                                                                  \
		.name = NAME, .open = OPEN, .close = close_pool, .spawn = spawn, .outside = outside, .batch = batch,           \
		.array = array, .join = loop, .loop = loop, .fib = fib, .graph_make = graph_make, .graph_run = graph_run,      \
		.submit = submit, .wait = wait, .phase_begin = phase_begin, .phase_end = phase_end, .stolen_at = stolen_at,    \
		.range = range, .tiles = tiles, .reduce = reduce, .sort = sort                                                 \
	}

static const jobs_subject pools[] = {
	POOL("stilb", open_low_lock),
	POOL("stilb-lock-free", open_lock_free),
	POOL("stilb-over-sutter", open_over_sutter),
	POOL("stilb-over-mutex", open_over_mutex),
};
const jobs_subject *const jobs_subjects[] = {&pools[0], &pools[1], &pools[2], &pools[3], NULL};
