/* Pools and queues take all their memory from a program's allocator and give all of it back. The allocator's blocks are
 * no better aligned than demanded, and have any contents. */
#include "jobs/job_graph.h"
#include "jobs/job_spsc.h"
#include "jobs/range/job_range.h"
#include "jobs/range/job_sort.h"
#include "tests/jobs/job_pool_fixture.h"

#include <errno.h>
#include <stdlib.h>

/* ---- the C library's functions; linked with -Wl,--wrap= of each of these ----------------------------------------- */

static counter c_calls;

void *__real_malloc(size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_malloc(size_t size)
{
	count_up(&c_calls);
	return __real_malloc(size);
}

void *__real_aligned_alloc(size_t alignment, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size)
{
	count_up(&c_calls);
	return __real_aligned_alloc(alignment, size);
}

void __real_free(void *block);
void __wrap_free(void *block);
void __wrap_free(void *block)
{
	count_up(&c_calls);
	__real_free(block);
}

/* ---- an allocator ------------------------------------------------------------------------------------------------ */

typedef struct memory {
	counter calls, blocks, wrong;
	uint32_t grant;    /* calls of allocate after which all fail */
	uint32_t fail_nth; /* every such call fails */
} memory;

/* Lies before each block. */
typedef struct header {
	size_t size;
	void *base;
	memory *from;
} header;

enum { EDGE = 2 * STILB_JOB_MAX_ALIGNMENT };

static void *take(void *user, size_t size, size_t alignment)
{
	memory *m = user;
	uint32_t call = count_up(&m->calls) + 1;
	if (size == 0 || alignment == 0 || (alignment & (alignment - 1)) != 0 || alignment > STILB_JOB_MAX_ALIGNMENT)
		count_up(&m->wrong);
	if (call > m->grant || (m->fail_nth > 0 && call % m->fail_nth == 0))
		return NULL;
	char *base = __real_aligned_alloc(EDGE, (size + 2 * EDGE - 1) / EDGE * EDGE + EDGE);
	if (!base)
		return NULL;
	char *block = base + STILB_JOB_MAX_ALIGNMENT + alignment; /* no multiple of 2 * alignment, but for the largest */
	if (alignment == STILB_JOB_MAX_ALIGNMENT)
		block -= alignment;
	memcpy(block - sizeof(header), &(header){size, base, m}, sizeof(header));
	memset(block, 0xa5, size);
	count_up(&m->blocks);
	return block;
}

static void give(void *user, void *block, size_t size)
{
	memory *m = user;
	header own;
	memcpy(&own, (char *)block - sizeof own, sizeof own);
	if (own.size != size || own.from != m)
		count_up(&m->wrong);
	memset(block, 0xdd, size);
	atomic_fetch_sub_explicit(&m->blocks, 1, memory_order_acq_rel);
	__real_free(own.base);
}

/* Fails every fail_nth allocation, 0: none, and all after `grant`. */
static memory memory_of(uint32_t grant, uint32_t fail_nth)
{
	return (memory){.grant = grant, .fail_nth = fail_nth};
}

static void assert_balanced(memory *m)
{
	assert_int_equal(count_of(&m->blocks), 0);
	assert_int_equal(count_of(&m->wrong), 0);
	assert_int_equal(count_of(&c_calls), 0);
}

/* ---- pools ------------------------------------------------------------------------------------------------------- */

enum { JOBS = 1000, KEYS = 5000, WIDE = 5000 };

typedef struct work {
	stilb_job_pool *pool;
	stilb_job_group group;
	counter ran, accepted, wrong;
} work;

static void count_job(void *data, uint32_t worker)
{
	work *w = data;
	(void)worker;
	count_up(&w->ran);
}

static int create(shape s, memory *m, stilb_job_pool **pool)
{
	uint32_t cpu = 0;
	stilb_job_allocator allocator = {take, give, m};
	stilb_job_pool_desc desc = {.worker_count = s.workers,
	                            .queue = s.queue,
	                            .affinity = STILB_JOB_AFFINITY_NONE, /* AUTO has lists of CPUs from the C library */
	                            .cpus = &cpu,
	                            .cpu_count = s.workers == 2,
	                            .allocator = &allocator};
	int error = stilb_job_pool_create(&desc, pool);
	allocator = (stilb_job_allocator){0}; /* it has been copied */
	return error;
}

static void note(work *w, int error)
{
	if (error == 0)
		count_up(&w->accepted);
	else if (error != -ENOMEM)
		count_up(&w->wrong);
}

static void *submit_outside(void *data)
{
	work *w = data;
	for (int i = 0; i < JOBS; i++)
		note(w, stilb_job_submit(w->pool, count_job, w, &w->group, STILB_JOB_OUTSIDE));
	return NULL;
}

/* Makes deques, the store of records and the shared queues grow. */
static void submit_all(work *w)
{
	stilb_job_options high = {.priority = STILB_JOB_HIGH};
	for (int i = 0; i < JOBS; i++) {
		note(w, stilb_job_submit(w->pool, count_job, w, &w->group, 0));
		note(w, stilb_job_submit_with(w->pool, count_job, w, &w->group, &high, 0));
	}
	outside_run(submit_outside, w);
	stilb_job_wait(w->pool, &w->group, 0);
	assert_int_equal(count_of(&w->ran), count_of(&w->accepted));
	assert_int_equal(count_of(&w->wrong), 0);
}

static int compare(const void *a, const void *b, void *context)
{
	uint32_t l, r;
	(void)context;
	memcpy(&l, a, sizeof l);
	memcpy(&r, b, sizeof r);
	return (l > r) - (l < r);
}

/* Returns the sort's error. */
static int sort_keys(stilb_job_pool *pool)
{
	static uint32_t keys[KEYS];
	for (uint32_t i = 0; i < KEYS; i++)
		keys[i] = KEYS - i;
	int error = stilb_job_sort(pool, keys, KEYS, sizeof *keys, compare, NULL, 0);
	for (uint32_t i = 0; i < KEYS; i++)
		assert_int_equal(keys[i], error ? KEYS - i : i + 1);
	return error;
}

static void fold_wide(uint64_t begin, uint64_t end, void *value, uint32_t worker, void *context)
{
	(void)worker, (void)context;
	((uint8_t *)value)[WIDE - 1] += (uint8_t)(end - begin);
}

static void combine_wide(void *left, const void *right, void *context)
{
	(void)context;
	((uint8_t *)left)[WIDE - 1] += ((const uint8_t *)right)[WIDE - 1];
}

/* Returns the reduction's error. The values need memory. */
static int reduce_wide(stilb_job_pool *pool)
{
	static uint8_t zero[WIDE], sum[WIDE];
	stilb_job_reduction reduction = {.size = WIDE, .identity = zero, .fold = fold_wide, .combine = combine_wide};
	sum[WIDE - 1] = 1;
	int error = stilb_job_reduce(pool, 100, 1, &reduction, sum, 0);
	assert_int_equal(sum[WIDE - 1], error ? 1 : 100);
	return error;
}

static void test_pools_use_nothing_else(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		memory m = memory_of(UINT32_MAX, 0);
		work w = {0};
		assert_int_equal(create(s, &m, &w.pool), 0);
		uint32_t at_first = count_of(&m.calls);
		assert_true(at_first >= 3 + s.workers); /* the pool, two queues, deques */
		submit_all(&w);
		assert_int_equal(count_of(&w.ran), 3 * JOBS);
		assert_true(count_of(&m.calls) > at_first);
		uint32_t before = count_of(&m.calls);
		assert_int_equal(sort_keys(w.pool), 0);
		assert_int_equal(count_of(&m.calls), before + 1);
		assert_int_equal(reduce_wide(w.pool), 0);
		assert_int_equal(count_of(&m.calls), before + 2);
		stilb_job_pool_destroy(w.pool);
		assert_balanced(&m);
	}
}

static void test_pools_that_cannot_be_created(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s))
		for (uint32_t grant = 0;; grant++) {
			memory m = memory_of(grant, 0);
			stilb_job_pool *pool = (stilb_job_pool *)&pool;
			int error = create(s, &m, &pool);
			if (error == 0) {
				assert_true(grant >= 3 + s.workers);
				stilb_job_pool_destroy(pool);
				assert_balanced(&m);
				break;
			}
			assert_int_equal(error, -ENOMEM);
			assert_null(pool);
			assert_balanced(&m);
		}
}

/* Accepted jobs run, refused ones do not, and what needs memory says that there is none. */
static void test_every_nth_allocation_fails(void **state)
{
	(void)state;
	uint32_t refused = 0;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s))
		for (uint32_t n = 1; n < 40; n += 1 + n / 4) {
			memory m = memory_of(UINT32_MAX, n);
			work w = {0};
			if (create(s, &m, &w.pool) != 0) {
				assert_balanced(&m);
				continue;
			}
			submit_all(&w);
			refused += 3 * JOBS - count_of(&w.ran);
			m.fail_nth = 1;
			assert_int_equal(sort_keys(w.pool), -ENOMEM);
			assert_int_equal(reduce_wide(w.pool), -ENOMEM);
			stilb_job_pool_destroy(w.pool);
			assert_balanced(&m);
		}
	assert_true(refused > 0);
}

/* ---- queues ------------------------------------------------------------------------------------------------------ */

enum { ITEMS = 10000 };

/* Pushes and pops so that the queue grows and empties twice. Returns how many items were refused. */
static uint32_t pass_items(stilb_job_queue *queue)
{
	static char items[ITEMS];
	uint32_t pushed = 0, popped = 0;
	void *item;
	for (uint32_t i = 0; i < ITEMS; i++) {
		int error = stilb_job_queue_push(queue, &items[i], 0);
		assert_true(error == 0 || error == -ENOMEM);
		pushed += error == 0;
		while (i % (ITEMS / 2) == ITEMS / 4 && stilb_job_queue_pop(queue, &item, 0) == 0)
			popped++;
	}
	assert_true(popped <= pushed); /* destroy releases what the others lie in */
	return ITEMS - pushed;
}

static void test_queues(void **state)
{
	(void)state;
	for (int kind = 0; kind < 2; kind++) {
		uint32_t refused = 0;
		for (uint32_t n = 0; n < 20; n++) {
			memory m = memory_of(UINT32_MAX, n);
			stilb_job_allocator allocator = {take, give, &m};
			stilb_job_queue_desc desc = {
				.kind = (stilb_job_queue_kind)kind, .capacity = SIZE_MAX, .thread_count = 3, .allocator = &allocator};
			stilb_job_queue *queue;
			int error = stilb_job_queue_create(&desc, &queue);
			allocator = (stilb_job_allocator){0};                    /* it has been copied */
			assert_int_equal(error, n == 1 || n == 2 ? -ENOMEM : 0); /* a queue begins with two blocks */
			if (error == 0) {
				uint32_t some = pass_items(queue);
				assert_true(n > 0 || some == 0);
				refused += some;
			}
			stilb_job_queue_destroy(queue);
			assert_balanced(&m);
		}
		assert_true(refused > 0);
	}
}

static void test_spsc(void **state)
{
	(void)state;
	static char item;
	for (uint32_t n = 0; n < 10; n++) {
		memory m = memory_of(UINT32_MAX, n);
		stilb_job_allocator allocator = {take, give, &m};
		stilb_job_spsc *queue;
		int error = stilb_job_spsc_create_with(&allocator, &queue);
		allocator = (stilb_job_allocator){0};
		assert_int_equal(error, n == 1 || n == 2 ? -ENOMEM : 0);
		uint32_t refused = 0;
		for (int i = 0; i < ITEMS && error == 0; i++)
			refused += stilb_job_spsc_push(queue, &item) == -ENOMEM;
		assert_true((refused > 0) == (n > 2));
		stilb_job_spsc_destroy(queue);
		assert_balanced(&m);
	}
}

/* ---- graphs ------------------------------------------------------------------------------------------------------ */

enum { STAGES = 6, STAGE_NODES = 7 };

/* Adds stages whose nodes all come before those of the next one, so that build makes joins. Returns the first error. */
static int make_graph(stilb_job_graph *graph, work *w)
{
	uint32_t node[STAGES * STAGE_NODES];
	int error = 0;
	for (int i = 0; i < STAGES * STAGE_NODES && error == 0; i++)
		error = stilb_job_graph_add_node(graph, count_job, w, i % 3 ? "a name" : NULL, &node[i]);
	for (int i = 0; i < (STAGES - 1) * STAGE_NODES * STAGE_NODES && error == 0; i++) {
		int before = i / STAGE_NODES, next = before / STAGE_NODES * STAGE_NODES + STAGE_NODES;
		error = stilb_job_graph_add_edge(graph, node[before], node[next + i % STAGE_NODES]);
	}
	return error ? error : stilb_job_graph_build(graph, NULL, 0);
}

static void test_graphs(void **state)
{
	(void)state;
	memory pools = memory_of(UINT32_MAX, 0);
	work w = {0};
	assert_int_equal(create((shape){.workers = 1}, &pools, &w.pool), 0);
	uint32_t made = 0;
	for (uint32_t n = 0; n < 60; n++) {
		memory m = memory_of(UINT32_MAX, n);
		stilb_job_allocator allocator = {take, give, &m};
		stilb_job_graph *graph;
		int error = stilb_job_graph_create_with(&allocator, &graph);
		allocator = (stilb_job_allocator){0}; /* it has been copied */
		assert_int_equal(error, n == 1 ? -ENOMEM : 0);
		if (n == 0)
			assert_int_equal(stilb_job_graph_build(graph, NULL, 0), 0); /* while it is empty */
		if (error == 0 && (error = make_graph(graph, &w)) == 0) {
			uint32_t calls = count_of(&m.calls);
			assert_int_equal(stilb_job_graph_run(graph, w.pool, &w.group, 0), 0);
			stilb_job_wait(w.pool, &w.group, 0);
			assert_int_equal(count_of(&w.ran), ++made * STAGES * STAGE_NODES);
			assert_int_equal(count_of(&m.calls), calls); /* a run takes records of the pool */
		}
		assert_true(error == 0 || (error == -ENOMEM && n > 0));
		stilb_job_graph_destroy(graph);
		assert_balanced(&m);
	}
	assert_in_range(made, 2, 30); /* without failures, and with failures that come after the last allocation */
	stilb_job_pool_destroy(w.pool);
	assert_balanced(&pools);
}

static void test_half_an_allocator(void **state)
{
	(void)state;
	memory m = memory_of(UINT32_MAX, 0);
	const stilb_job_allocator halves[] = {{.allocate = take, .user = &m}, {.release = give, .user = &m}};
	for (size_t i = 0; i < sizeof halves / sizeof *halves; i++) {
		stilb_job_queue_desc desc = stilb_job_queue_desc_default();
		desc.allocator = &halves[i];
		stilb_job_queue *queue = (stilb_job_queue *)&queue;
		assert_int_equal(stilb_job_queue_create(&desc, &queue), -EINVAL);
		assert_null(queue);
		stilb_job_spsc *spsc = (stilb_job_spsc *)&spsc;
		assert_int_equal(stilb_job_spsc_create_with(&halves[i], &spsc), -EINVAL);
		assert_null(spsc);
		stilb_job_graph *graph = (stilb_job_graph *)&graph;
		assert_int_equal(stilb_job_graph_create_with(&halves[i], &graph), -EINVAL);
		assert_null(graph);
		stilb_job_pool_desc pool_desc = {.allocator = &halves[i]};
		assert_string_equal(stilb_job_pool_desc_error(&pool_desc), "allocator has only one of its functions");
	}
	assert_balanced(&m);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_pools_use_nothing_else),
		cmocka_unit_test(test_pools_that_cannot_be_created),
		cmocka_unit_test(test_every_nth_allocation_fails),
		cmocka_unit_test(test_queues),
		cmocka_unit_test(test_spsc),
		cmocka_unit_test(test_graphs),
		cmocka_unit_test(test_half_an_allocator),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
