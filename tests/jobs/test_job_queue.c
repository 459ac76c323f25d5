/* The promises of job_queue.h, with one thread at a time, for every kind of queue. */
#include <errno.h>
#include <limits.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "job_queue_kinds.h"
#include "job_random.h"
#include "support/test.h"

enum { THREADS = 8, MANY = 5000 }; /* MANY: more than several segments, not a multiple of a segment's size */

/* ---- memory ---- */

static struct {
	long live, most, calls; /* blocks not freed; the largest number of them; number of allocations */
	bool fails, fails_at_random;
	uint64_t random;
	long calls_until_failure; /* if not 0: the last one of this many calls fails */
	void (*meanwhile)(void);  /* called inside each allocation and each free, but not recursively */
} memory;

static void memory_meanwhile(void)
{
	void (*meanwhile)(void) = memory.meanwhile;
	memory.meanwhile = NULL;
	if (meanwhile)
		meanwhile();
	memory.meanwhile = meanwhile;
}

static bool memory_refuses(void)
{
	memory_meanwhile();
	memory.calls++;
	if (memory.fails || (memory.fails_at_random && next_random(&memory.random) % 2))
		return true;
	return memory.calls_until_failure > 0 && --memory.calls_until_failure == 0;
}

static void *memory_count(void *block)
{
	if (block && ++memory.live > memory.most)
		memory.most = memory.live;
	return block;
}

/* The program is linked with -Wl,--wrap for each of these functions, so that the library's calls come here. */
void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_aligned_alloc(size_t alignment, size_t size);
void __real_free(void *block);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size);
void __wrap_free(void *block);

void *__wrap_malloc(size_t size)
{
	return memory_refuses() ? NULL : memory_count(__real_malloc(size));
}

void *__wrap_calloc(size_t count, size_t size)
{
	return memory_refuses() ? NULL : memory_count(__real_calloc(count, size));
}

void *__wrap_aligned_alloc(size_t alignment, size_t size)
{
	return memory_refuses() ? NULL : memory_count(__real_aligned_alloc(alignment, size));
}

void __wrap_free(void *block)
{
	memory_meanwhile();
	memory.live -= block ? 1 : 0;
	__real_free(block);
}

/* ---- the tests, each run on every kind ---- */

static const queue_kind *kind;
static stilb_job_queue *queue;

static void start(size_t capacity)
{
	memset(&memory, 0, sizeof memory);
	queue = queue_kind_create(kind, capacity, THREADS);
}

/* Destroys the queue and asserts that everything was freed, whatever it contained. */
static void finish(void)
{
	stilb_job_queue_destroy(queue);
	assert_int_equal(memory.live, 0);
}

static void *item_of(uintptr_t value)
{
	return (void *)(value + 1);
}

static int push(uintptr_t value, uint32_t thread)
{
	return stilb_job_queue_push(queue, item_of(value), thread);
}

static int push_many(uintptr_t first, size_t count, uint32_t thread)
{
	static void *items[MANY];
	for (size_t i = 0; i < count; i++)
		items[i] = item_of(first + i);
	return stilb_job_queue_push_n(queue, items, count, thread);
}

static void pop_expect(uintptr_t value, uint32_t thread)
{
	void *item = NULL;
	assert_int_equal(stilb_job_queue_pop(queue, &item, thread), 0);
	assert_ptr_equal(item, item_of(value));
}

/* Pops the next `count` values, one by one or in batches, and asserts their order. */
static void drain_expect(uintptr_t first, size_t count, uint32_t thread)
{
	for (size_t i = 0; i < count; i++)
		pop_expect(first + i, thread);
}

static void empty_expect(int why, uint32_t thread)
{
	void *item = item_of(7), *items[2] = {item, item};
	assert_int_equal(stilb_job_queue_pop(queue, &item, thread), why);
	assert_int_equal(stilb_job_queue_pop_n(queue, items, 2, thread), why);
	assert_true(stilb_job_queue_empty(queue, thread));
}

static void test_fifo(void **state)
{
	(void)state;
	start(SIZE_MAX);
	empty_expect(-EAGAIN, 0);
	for (uintptr_t round = 0; round < 3; round++) {
		for (uintptr_t i = 0; i < MANY; i++)
			assert_int_equal(push(i, i % THREADS), 0);
		for (uintptr_t i = 0; i < MANY; i++) {
			assert_false(stilb_job_queue_empty(queue, i % 3));
			pop_expect(i, i % 5);
		}
		for (uint32_t thread = 0; thread < THREADS; thread++)
			empty_expect(-EAGAIN, thread);
	}
	finish();
}

static void test_ends_interleaved(void **state)
{
	(void)state;
	start(SIZE_MAX);
	uintptr_t pushed = 0, popped = 0;
	for (uintptr_t i = 0; i < MANY; i++) {
		for (uintptr_t k = 0; k < i % 7; k++)
			assert_int_equal(push(pushed++, i % THREADS), 0);
		for (uintptr_t k = 0; k < i % 5 && popped < pushed; k++)
			pop_expect(popped++, (i + 1) % THREADS);
	}
	assert_true(popped < pushed);
	finish();
}

/* Batches of every size around a segment's end, beginning at every place in a segment. */
static void test_batches(void **state)
{
	(void)state;
	static const size_t sizes[] = {1, 2, 3, 15, 16, 17, 255, 511, 512, 513, 1023, 1024, 1025, 1537, 2 * 1024 + 1};
	enum { SIZES = sizeof sizes / sizeof *sizes };
	static void *items[MANY];
	start(SIZE_MAX);
	uintptr_t pushed = 0, popped = 0;
	for (size_t in = 0; in < SIZES; in++)
		for (size_t out = 0; out < SIZES; out++) {
			for (int i = 0; i < 3; i++, pushed += sizes[in])
				assert_int_equal(push_many(pushed, sizes[in], 0), sizes[in]);
			while (popped < pushed) {
				size_t left = pushed - popped, expected = left < sizes[out] ? left : sizes[out];
				assert_int_equal(stilb_job_queue_pop_n(queue, items, sizes[out], 1), expected);
				for (size_t i = 0; i < expected; i++)
					assert_ptr_equal(items[i], item_of(popped + i));
				popped += expected;
			}
			empty_expect(-EAGAIN, 1);
			assert_int_equal(push(pushed++, 0), 0); /* shifts the place at which the next batches begin */
			pop_expect(popped++, 1);
		}
	finish();
}

static void test_bounded(void **state)
{
	(void)state;
	if (!kind->bounded)
		skip();
	static const size_t capacities[] = {1, 2, 3, 511, 512, 513, 1023, 1024, 1025, 2048};
	for (size_t c = 0; c < sizeof capacities / sizeof *capacities; c++) {
		size_t capacity = capacities[c];
		start(capacity);
		uintptr_t pushed = 0, popped = 0;
		for (; pushed < capacity; pushed++)
			assert_int_equal(push(pushed, pushed % THREADS), 0);
		for (size_t i = 0; i < MANY / 2; i++) { /* full: pop one, push one */
			assert_int_equal(push(pushed, i % THREADS), -EAGAIN);
			assert_int_equal(push_many(pushed, 3, i % THREADS), -EAGAIN);
			pop_expect(popped++, (i + 1) % THREADS);
			assert_int_equal(push(pushed++, (i + 2) % THREADS), 0);
		}
		drain_expect(popped, capacity, 0);
		empty_expect(-EAGAIN, 0);
		popped = pushed;
		for (size_t i = 0; i < 20;
		     i++, pushed += capacity, popped += capacity) { /* more items at once than there is room for */
			assert_int_equal(push_many(pushed, capacity + 1 + i, i % THREADS), capacity);
			drain_expect(popped, capacity, (i + 1) % THREADS);
		}
		finish();
	}
}

static void test_refusals(void **state)
{
	(void)state;
	void *item = item_of(1), *items[3] = {item, NULL, item}, *good[3] = {item, item, item};
	start(SIZE_MAX);
	assert_int_equal(stilb_job_queue_push(queue, NULL, 0), -EINVAL);
	assert_int_equal(stilb_job_queue_push_n(queue, items, 3, 0), -EINVAL);
	assert_int_equal(stilb_job_queue_push_n(queue, good, (size_t)INT32_MAX + 1, 0), -EINVAL);
	assert_int_equal(stilb_job_queue_push_n(queue, good, SIZE_MAX, 0), -EINVAL);
	assert_int_equal(stilb_job_queue_push_n(queue, items, 0, 0), 0);
	assert_int_equal(stilb_job_queue_push_n(queue, NULL, 0, 0), 0);
	empty_expect(-EAGAIN, 0);
	assert_int_equal(push(0, 0), 0);
	assert_int_equal(stilb_job_queue_pop_n(queue, NULL, 0, 0), 0);
	assert_int_equal(stilb_job_queue_pop_n(queue, items, SIZE_MAX, 0), 1);
	finish();
}

static void test_closing(void **state)
{
	(void)state;
	for (size_t inside = 0; inside < MANY; inside = inside * 2 + 1) {
		start(SIZE_MAX);
		assert_int_equal(push_many(0, inside, 0), inside);
		stilb_job_queue_close(queue);
		for (uint32_t thread = 0; thread < THREADS; thread++) {
			assert_int_equal(push(0, thread), -EPIPE);
			assert_int_equal(push_many(0, 3, thread), -EPIPE);
		}
		assert_int_equal(stilb_job_queue_empty(queue, 1), inside == 0);
		drain_expect(0, inside / 2, 1);
		stilb_job_queue_close(queue); /* closing twice is allowed */
		drain_expect(inside / 2, inside - inside / 2, 2);
		for (uint32_t thread = 0; thread < THREADS; thread++) {
			empty_expect(-EPIPE, thread);
			assert_int_equal(push(0, thread), -EPIPE);
		}
		finish();
	}
}

static void test_closing_full(void **state)
{
	(void)state;
	if (!kind->bounded)
		skip();
	start(3);
	assert_int_equal(push_many(0, 4, 0), 3);
	stilb_job_queue_close(queue);
	assert_int_equal(push(4, 0), -EPIPE); /* with -EAGAIN the caller would retry for ever */
	drain_expect(0, 3, 1);
	assert_int_equal(push(4, 0), -EPIPE);
	empty_expect(-EPIPE, 1);
	finish();
}

static void test_items_left_behind(void **state)
{
	(void)state;
	for (size_t left = 0; left < MANY; left = left * 3 + 1) {
		start(SIZE_MAX);
		assert_int_equal(push_many(0, MANY, 0), MANY);
		drain_expect(0, MANY - left, 1);
		finish();
	}
}

/* A short queue reuses its memory, whichever threads use it or have used it. */
static void test_memory_goes_round(void **state)
{
	(void)state;
	enum { SEGMENTS = 64, ITEMS = SEGMENTS * 1024 };
	start(SIZE_MAX);
	for (uint32_t thread = 0; thread < THREADS; thread++) {
		assert_int_equal(push(0, thread), 0); /* and makes no further call, except below */
		pop_expect(0, thread);
		if (thread % 2)
			stilb_job_queue_rest(queue, thread);
	}
	long warm_calls = 0;
	memory.most = memory.live;
	for (uintptr_t i = 0; i < ITEMS; i++) {
		if (i == ITEMS / 2)
			warm_calls = memory.calls;
		assert_int_equal(push(i, i / 1500 % 2), 0);
		pop_expect(i, 2 + i / 1900 % 2);
		if (i % 3000 == 0)
			stilb_job_queue_rest(queue, (uint32_t)(i / 3000 % 4));
	}
	assert_true(memory.most < SEGMENTS);
	if (kind->recycles)
		assert_int_equal(memory.calls, warm_calls);
	finish();
}

static void test_out_of_memory_in_create(void **state)
{
	(void)state;
	int error = -ENOMEM;
	for (long call = 1; error; call++) {
		stilb_job_queue_desc desc = {.capacity = SIZE_MAX, .thread_count = THREADS};
		stilb_job_queue *made = (stilb_job_queue *)&desc;
		memset(&memory, 0, sizeof memory);
		memory.calls_until_failure = call;
		error = kind->create(&desc, &made);
		bool failed = memory.calls_until_failure == 0;
		memory.calls_until_failure = 0;
		assert_int_equal(error, failed ? -ENOMEM : 0);
		if (error)
			assert_null(made);
		stilb_job_queue_destroy(made);
		assert_int_equal(memory.live, 0);
		assert_true(call < 100);
	}
}

/* Pushes until memory runs out: every accepted item is popped, and afterwards the queue works again. */
static void test_out_of_memory_in_push(void **state)
{
	(void)state;
	for (size_t batch = 1; batch < MANY; batch = batch * 5 + 2) {
		start(SIZE_MAX);
		assert_int_equal(push_many(0, 700, 0), 700);
		uintptr_t pushed = 700, popped = 0;
		for (int round = 0; round < 3; round++) {
			memory.fails = true;
			int result = 0;
			for (int tries = 0; result != -ENOMEM; pushed += result > 0 ? (uintptr_t)result : 0, tries++) {
				result = push_many(pushed, batch, 0);
				assert_true(result > 0 || result == -ENOMEM);
				assert_true(tries < MANY);
			}
			int single = push(pushed, 0); /* may succeed where several items did not, if push_n is all or nothing */
			pushed += single == 0;
			assert_true(single == 0 || single == -ENOMEM);
			assert_false(stilb_job_queue_empty(queue, 1));
			drain_expect(popped, 300, 1); /* popping needs no memory */
			popped += 300;
			memory.fails = false;
			assert_int_equal(push_many(pushed, 600, 0), 600);
			pushed += 600;
		}
		drain_expect(popped, pushed - popped, 1);
		empty_expect(-EAGAIN, 1);
		finish();
	}
}

/* While one thread allocates or frees memory inside a call of the queue, another one pushes and pops: that succeeds,
 * since the queue holds no lock meanwhile. */
static uintptr_t inner_pushed, inner_popped;

static void push_and_pop(void)
{
	void *item = NULL;
	inner_pushed += push(1000000 + inner_pushed, 3) == 0;
	inner_popped += stilb_job_queue_pop(queue, &item, 4) == 0;
}

static void test_no_lock_while_allocating(void **state)
{
	(void)state;
	start(SIZE_MAX);
	inner_pushed = inner_popped = 0;
	uintptr_t outer_pushed = 0, outer_popped = 0;
	void *item = NULL;
	memory.meanwhile = push_and_pop;
	for (uintptr_t i = 0; i < 4 * MANY; i++) {
		outer_pushed += push(i, 0) == 0;
		if (i % 3 == 0)
			outer_popped += stilb_job_queue_pop(queue, &item, 1) == 0;
	}
	while (stilb_job_queue_pop(queue, &item, 1) == 0)
		outer_popped++;
	memory.meanwhile = NULL;
	assert_true(inner_pushed > 0);
	assert_int_equal(outer_pushed, 4 * MANY);
	while (stilb_job_queue_pop(queue, &item, 1) == 0)
		outer_popped++; /* items that were pushed while the last one was being freed */
	assert_int_equal(outer_popped + inner_popped, outer_pushed + inner_pushed);
	finish();
}

/* ---- random calls, compared with a simple model ---- */

typedef struct believed {
	uintptr_t pushed, popped; /* values are numbered in the order of pushes */
	size_t capacity;
	bool closed;
} believed;

static void random_push(believed *model, uint64_t draw, uint32_t thread)
{
	size_t count = draw % 4 ? 1 : draw / 4 % 900, room = model->capacity - (model->pushed - model->popped);
	size_t most = count < room ? count : room;
	int result = draw % 4 ? push(model->pushed, thread) : push_many(model->pushed, count, thread);
	if (draw % 4 && result == 0)
		result = 1;
	if (count == 0)
		assert_int_equal(result, 0);
	else if (memory.fails_at_random && result == -ENOMEM)
		; /* also if the push would have been refused anyway, since some kinds allocate first */
	else if (model->closed)
		assert_int_equal(result, -EPIPE);
	else if (memory.fails_at_random && result > 0)
		assert_true((size_t)result <= most);
	else
		assert_int_equal(result, most > 0 ? (int)most : -EAGAIN);
	model->pushed += result > 0 ? (uintptr_t)result : 0;
}

static void random_pop(believed *model, uint64_t draw, uint32_t thread)
{
	static void *items[MANY];
	size_t max = draw % 4 ? 1 : 1 + draw / 4 % 900, inside = model->pushed - model->popped;
	size_t most = max < inside ? max : inside;
	int result =
		draw % 4 ? stilb_job_queue_pop(queue, items, thread) : stilb_job_queue_pop_n(queue, items, max, thread);
	if (draw % 4 && result == 0)
		result = 1;
	assert_int_equal(result, most > 0 ? (int)most : model->closed ? -EPIPE : -EAGAIN);
	for (int i = 0; i < result; i++)
		assert_ptr_equal(items[i], item_of(model->popped++));
}

static void random_calls_with(uint64_t random, size_t capacity)
{
	believed model = {.capacity = capacity};
	start(capacity);
	memory.fails_at_random = random % 2;
	for (int i = 0; i < MANY; i++) {
		uint64_t draw = next_random(&random);
		uint32_t thread = draw % THREADS;
		draw /= THREADS;
		if (draw % 64 == 0)
			stilb_job_queue_rest(queue, thread);
		else if (draw % 64 < 5)
			assert_int_equal(stilb_job_queue_empty(queue, thread), model.pushed == model.popped);
		else if (draw / 64 % 2048 == 0 && i > MANY / 2) {
			stilb_job_queue_close(queue);
			model.closed = true;
		} else if (draw % 64 < 35)
			random_push(&model, draw / 64, thread);
		else
			random_pop(&model, draw / 64, thread);
	}
	memory.fails_at_random = false;
	drain_expect(model.popped, model.pushed - model.popped, 0);
	empty_expect(model.closed ? -EPIPE : -EAGAIN, 0);
	finish();
}

static void test_random_calls(void **state)
{
	(void)state;
	static const size_t capacities[] = {SIZE_MAX, 1, 100, 512, 1500};
	for (uint64_t seed = 0; seed < (TEST_EMULATED ? 20 : TEST_ASAN ? 30 : 100); seed++)
		random_calls_with(seed, kind->bounded ? capacities[seed / 2 % 5] : SIZE_MAX);
}

/* The largest allowed thread number works like any other. */
static void test_most_threads(void **state)
{
	(void)state;
	memset(&memory, 0, sizeof memory);
	queue = queue_kind_create(kind, SIZE_MAX, STILB_JOB_QUEUE_MAX_THREADS);
	for (uint32_t thread = 0; thread < STILB_JOB_QUEUE_MAX_THREADS; thread++)
		assert_int_equal(push(thread, thread), 0);
	for (uint32_t thread = 0; thread < STILB_JOB_QUEUE_MAX_THREADS; thread++)
		pop_expect(thread, STILB_JOB_QUEUE_MAX_THREADS - 1 - thread);
	empty_expect(-EAGAIN, 0);
	finish();
}

/* ---- creation, whose arguments only the library's kinds check ---- */

static void test_create(void **state)
{
	(void)state;
	stilb_job_queue *made = NULL;
	stilb_job_queue_desc desc = stilb_job_queue_desc_default();
	assert_int_equal(desc.kind, STILB_JOB_QUEUE_LOW_LOCK);
	assert_int_equal(desc.thread_count, STILB_JOB_QUEUE_MAX_THREADS);
	assert_true(desc.capacity == SIZE_MAX);
	const stilb_job_queue_desc bad[] = {
		{.kind = STILB_JOB_QUEUE_LOW_LOCK, .capacity = 0, .thread_count = 1},
		{.kind = STILB_JOB_QUEUE_LOCK_FREE, .capacity = 0, .thread_count = 1},
		{.kind = STILB_JOB_QUEUE_LOW_LOCK, .capacity = 1, .thread_count = 0},
		{.kind = STILB_JOB_QUEUE_LOCK_FREE, .capacity = 1, .thread_count = 0},
		{.kind = STILB_JOB_QUEUE_LOW_LOCK, .capacity = 1, .thread_count = STILB_JOB_QUEUE_MAX_THREADS + 1},
		{.kind = STILB_JOB_QUEUE_LOCK_FREE, .capacity = 1, .thread_count = STILB_JOB_QUEUE_MAX_THREADS + 1},
		{.kind = STILB_JOB_QUEUE_LOCK_FREE, .capacity = 1, .thread_count = UINT32_MAX},
		{.kind = (stilb_job_queue_kind)2, .capacity = 1, .thread_count = 1},
		{.kind = (stilb_job_queue_kind)-1, .capacity = 1, .thread_count = 1},
	};
	for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
		made = (stilb_job_queue *)&desc;
		assert_int_equal(stilb_job_queue_create(&bad[i], &made), -EINVAL);
		assert_null(made);
	}
	stilb_job_queue_destroy(NULL);
}

int main(void)
{
	const struct CMUnitTest create[] = {cmocka_unit_test(test_create)};
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_fifo),
		cmocka_unit_test(test_ends_interleaved),
		cmocka_unit_test(test_batches),
		cmocka_unit_test(test_bounded),
		cmocka_unit_test(test_refusals),
		cmocka_unit_test(test_closing),
		cmocka_unit_test(test_closing_full),
		cmocka_unit_test(test_items_left_behind),
		cmocka_unit_test(test_most_threads),
		cmocka_unit_test(test_memory_goes_round),
		cmocka_unit_test(test_out_of_memory_in_create),
		cmocka_unit_test(test_out_of_memory_in_push),
		cmocka_unit_test(test_no_lock_while_allocating),
		cmocka_unit_test(test_random_calls),
	};
	int failed = cmocka_run_group_tests_name("create", create, NULL, NULL);
	for (int i = 0; i < QUEUE_KINDS; i++) {
		kind = &queue_kinds[i];
		failed += cmocka_run_group_tests_name(kind->name, tests, NULL, NULL);
	}
	return failed;
}
