/*
 * Linearizability of every kind of queue: threads record their calls with time stamps, and job_history checks them. The
 * checker itself must agree with an exhaustive search on small runs, and find the faults of queues that are broken on
 * purpose.
 *
 * test_job_queue_linear [OPERATIONS]: number of pushes and pops of a run, besides pops that found the queue empty.
 */
#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "job_history.h"
#include "job_queue_kinds.h"
#include "job_random.h"
#include "jobs/job_sys.h"
#include "support/test.h"

#define OPERATIONS (TEST_EMULATED ? 25000 : 100000)
static uint32_t operations = OPERATIONS;

enum { MOST_THREADS = 16, MOST_BATCH = 8, CAPACITY = 3 };

/* ---- recording ---- */

typedef struct run {
	stilb_job_queue *queue;
	uint32_t producers, consumers, each; /* each: values of each producer */
	_Atomic uint32_t start;              /* relaxed: only makes all begin at about the same time */
	_Atomic uint32_t producers_left;     /* a producer's release at its end pairs with the consumers' acquire */
	_Atomic uint32_t threads_left;       /* relaxed: only tells when to stop disturbing */
} run;

typedef struct recorder {
	run *run;
	pthread_t thread;
	uint32_t number;
	uint64_t random;
	history_op *ops;
	size_t count, room;
	size_t empty_calls;
} recorder;

/* A value as a pointer that is not NULL. */
static void *item_of(uint32_t value)
{
	return (void *)((uintptr_t)value + 1);
}

static void record(recorder *self, history_call call, uint64_t begin, uint64_t end, void *item)
{
	uint32_t value = call == HISTORY_EMPTY ? 0 : (uint32_t)((uintptr_t)item - 1);
	/* only a queue that repeats values fills the array, and a full one is enough to show that */
	if (self->count < self->room)
		self->ops[self->count++] = (history_op){.begin = begin, .end = end, .value = value, .call = call};
}

static void pause_at_random(recorder *self)
{
	uint64_t draw = next_random(&self->random);
	if (draw % 64 == 0)
		for (uint32_t i = 0; i < draw / 64 % 256; i++)
			job_sys_pause();
}

/* Producers work in bursts, so that the queue becomes empty again and again. */
static void sleep_at_random(recorder *self)
{
	if (next_random(&self->random) % 128 == 0)
		nanosleep(&(struct timespec){.tv_nsec = 100000}, NULL);
}

/* After an unsuccessful call the other side may need the CPU; but often two such calls follow one another. */
static void yield_at_random(recorder *self)
{
	if (next_random(&self->random) % 4 == 0)
		sched_yield();
}

/* Sometimes several items in one call; each is recorded with the time of the whole call. */
static uint32_t batch_at_random(recorder *self)
{
	uint64_t draw = next_random(&self->random);
	return draw % 8 ? 1 : 1 + (uint32_t)(draw / 8 % MOST_BATCH);
}

static void *produce(void *data)
{
	recorder *self = data;
	run *r = self->run;
	while (!atomic_load_explicit(&r->start, memory_order_relaxed))
		job_sys_pause();
	for (uint32_t done = 0; done < r->each;) {
		uint32_t batch = batch_at_random(self);
		batch = batch < r->each - done ? batch : r->each - done;
		void *items[MOST_BATCH];
		for (uint32_t i = 0; i < batch; i++)
			items[i] = item_of(self->number * r->each + done + i);
		uint64_t begin = history_now();
		int pushed = batch == 1 ? !stilb_job_queue_push(r->queue, items[0], self->number)
		                        : stilb_job_queue_push_n(r->queue, items, batch, self->number);
		uint64_t end = history_now();
		for (int i = 0; i < pushed; i++)
			record(self, HISTORY_PUSH, begin, end, items[i]);
		if (pushed <= 0)
			yield_at_random(self);
		else
			done += (uint32_t)pushed;
		pause_at_random(self);
		sleep_at_random(self);
	}
	stilb_job_queue_rest(r->queue, self->number);
	atomic_fetch_sub_explicit(&r->producers_left, 1, memory_order_release);
	atomic_fetch_sub_explicit(&r->threads_left, 1, memory_order_relaxed);
	return NULL;
}

/* Pops once; false if the queue was empty. */
static bool consume_once(recorder *self)
{
	run *r = self->run;
	void *items[MOST_BATCH];
	uint32_t batch = batch_at_random(self);
	uint64_t begin = history_now();
	bool looked = batch == MOST_BATCH && stilb_job_queue_empty(r->queue, self->number);
	int popped = looked       ? 0
	             : batch == 1 ? !stilb_job_queue_pop(r->queue, items, self->number)
	                          : stilb_job_queue_pop_n(r->queue, items, batch, self->number);
	uint64_t end = history_now();
	for (int i = 0; i < popped; i++)
		record(self, HISTORY_POP, begin, end, items[i]);
	if (popped > 0)
		return true;
	/* Pops that found nothing change nothing, so records of them may be left out: they are at most half of all. */
	if (self->empty_calls * 2 <= self->count) {
		record(self, HISTORY_EMPTY, begin, end, NULL);
		self->empty_calls++;
	}
	return false;
}

static void *consume(void *data)
{
	recorder *self = data;
	run *r = self->run;
	while (!atomic_load_explicit(&r->start, memory_order_relaxed))
		job_sys_pause();
	for (bool last = false;; pause_at_random(self)) {
		bool all_pushed = !atomic_load_explicit(&r->producers_left, memory_order_acquire);
		if (consume_once(self))
			continue;
		if (last)
			break;
		last = all_pushed;
		yield_at_random(self);
	}
	stilb_job_queue_rest(r->queue, self->number);
	atomic_fetch_sub_explicit(&r->threads_left, 1, memory_order_relaxed);
	return NULL;
}

/* Signal handler: the thread sleeps wherever it is. */
static void sleep_here(int signal)
{
	(void)signal;
	int saved = errno;
	nanosleep(&(struct timespec){.tv_nsec = 20000}, NULL);
	errno = saved;
}

static void disturb(run *r, recorder *recorders, uint64_t random)
{
	while (atomic_load_explicit(&r->threads_left, memory_order_relaxed)) {
		nanosleep(&(struct timespec){.tv_nsec = (long)(next_random(&random) % 100000)}, NULL);
		pthread_kill(recorders[next_random(&random) % (r->producers + r->consumers)].thread, SIGUSR1);
	}
}

/* Runs `side` producers and as many consumers; returns the number of recorded calls. The caller frees *ops. */
static size_t record_run(stilb_job_queue *queue, uint32_t side, uint32_t values, uint64_t seed, history_op **ops)
{
	run r = {.queue = queue, .producers = side, .consumers = side, .each = values / side};
	r.producers_left = side;
	r.threads_left = 2 * side;
	recorder recorders[MOST_THREADS];
	for (uint32_t i = 0; i < 2 * side; i++) {
		size_t room =
			i < side ? r.each : (size_t)values * 2 + 2; /* any consumer may get all, and half as many empty pops */
		recorders[i] = (recorder){.run = &r, .number = i, .random = seed + i, .room = room};
		recorders[i].ops = malloc(room * sizeof(history_op));
		assert_non_null(recorders[i].ops);
		assert_int_equal(pthread_create(&recorders[i].thread, NULL, i < side ? produce : consume, &recorders[i]), 0);
	}
	atomic_store_explicit(&r.start, 1, memory_order_relaxed);
	disturb(&r, recorders, seed);
	size_t count = 0;
	for (uint32_t i = 0; i < 2 * side; i++) {
		pthread_join(recorders[i].thread, NULL);
		count += recorders[i].count;
	}
	history_op *next = *ops = malloc(count * sizeof **ops);
	assert_non_null(*ops);
	for (uint32_t i = 0; i < 2 * side; i++) {
		memcpy(next, recorders[i].ops, recorders[i].count * sizeof *next);
		next += recorders[i].count;
		free(recorders[i].ops);
	}
	return count;
}

/* ---- the queues ---- */

static size_t count_calls(const history_op *ops, size_t count, history_call call)
{
	size_t calls = 0;
	for (size_t i = 0; i < count; i++)
		calls += ops[i].call == call;
	return calls;
}

static void check_kind(const queue_kind *kind, uint32_t side, size_t capacity)
{
	uint32_t values = operations / 2 / side * side;
	stilb_job_queue *queue = queue_kind_create(kind, capacity, 2 * side);
	history_op *ops = NULL;
	size_t count = record_run(queue, side, values, side + capacity, &ops);
	history_violation violation = history_check(ops, count, values);
	size_t popped = count_calls(ops, count, HISTORY_POP), empty = count_calls(ops, count, HISTORY_EMPTY);
	free(ops);
	stilb_job_queue_destroy(queue);
	print_message("%s, %s, %uP%uC: %zu calls, %zu found nothing: %s\n", kind->name,
	              capacity == SIZE_MAX ? "unbounded" : "bounded", side, side, count, empty,
	              history_violation_name(violation));
	assert_int_equal(violation, HISTORY_LINEARISABLE);
	assert_int_equal(popped, values);
	assert_true(empty > 0); /* otherwise the run would prove nothing about empty queues */
}

static void test_kinds(void **state)
{
	(void)state;
	for (int kind = 0; kind < QUEUE_KINDS; kind++)
		for (uint32_t side = 1; side <= 4; side *= 2)
			check_kind(&queue_kinds[kind], side, SIZE_MAX);
}

static void test_kinds_bounded(void **state)
{
	(void)state;
	for (int kind = 0; kind < QUEUE_KINDS; kind++)
		for (uint32_t side = 2; queue_kinds[kind].bounded && side <= 4; side *= 2)
			check_kind(&queue_kinds[kind], side, CAPACITY);
}

/* ---- queues with planted faults ---- */

typedef enum queue_fault {
	FAULT_NONE,
	FAULT_FORGE, /* pops a value that was not pushed */
	FAULT_TWICE, /* pops a value without removing it */
	FAULT_LOSE,  /* drops a value */
	FAULT_SWAP,  /* exchanges the two newest values */
	FAULT_SIDES, /* keeps one FIFO for each producer, as some fast queues do */
	FAULT_LATE,  /* returns from a push before the item is visible to others */
	FAULT_SHY,   /* reports empty if it could not get the lock */
	FAULTS
} queue_fault;

enum { FAULT_EVERY = 997 };

typedef struct broken_queue {
	stilb_job_queue base;
	queue_fault fault;
	pthread_mutex_t lock;
	uint32_t calls, turn;
	struct broken_fifo {
		void **items;
		uint32_t head, tail;
	} fifos[MOST_THREADS];
	void *held_back[MOST_THREADS];
} broken_queue;

static bool broken_now(broken_queue *self, queue_fault fault)
{
	return self->fault == fault && ++self->calls % FAULT_EVERY == 0;
}

static int broken_push(stilb_job_queue *queue, void *item, uint32_t thread)
{
	broken_queue *self = (broken_queue *)queue;
	pthread_mutex_lock(&self->lock);
	struct broken_fifo *fifo = &self->fifos[self->fault == FAULT_SIDES ? thread : 0];
	if (self->fault == FAULT_LATE) {
		void *other = self->held_back[thread];
		self->held_back[thread] = item;
		item = other;
	}
	if (item && !broken_now(self, FAULT_LOSE))
		fifo->items[fifo->tail++] = item;
	if (fifo->tail - fifo->head >= 2 && broken_now(self, FAULT_SWAP)) {
		fifo->items[fifo->tail - 1] = fifo->items[fifo->tail - 2];
		fifo->items[fifo->tail - 2] = item;
	}
	pthread_mutex_unlock(&self->lock);
	return 0;
}

static int broken_pop(stilb_job_queue *queue, void **item, uint32_t thread)
{
	(void)thread;
	broken_queue *self = (broken_queue *)queue;
	if (self->fault != FAULT_SHY)
		pthread_mutex_lock(&self->lock);
	else if (pthread_mutex_trylock(&self->lock) != 0)
		return -EAGAIN;
	struct broken_fifo *fifo = self->fifos;
	for (uint32_t i = 0; i < MOST_THREADS && fifo->head == fifo->tail; i++)
		fifo = &self->fifos[self->turn++ % MOST_THREADS];
	int result = -EAGAIN;
	if (broken_now(self, FAULT_FORGE)) {
		*item = item_of(UINT32_MAX - 1);
		result = 0;
	} else if (fifo->head < fifo->tail) {
		*item = fifo->items[fifo->head];
		fifo->head += !broken_now(self, FAULT_TWICE);
		result = 0;
	}
	pthread_mutex_unlock(&self->lock);
	return result;
}

static int broken_push_n(stilb_job_queue *queue, void *const *items, size_t count, uint32_t thread)
{
	for (size_t i = 0; i < count; i++)
		broken_push(queue, items[i], thread);
	return (int)count;
}

static int broken_pop_n(stilb_job_queue *queue, void **items, size_t max, uint32_t thread)
{
	(void)max;
	return broken_pop(queue, items, thread) == 0 ? 1 : -EAGAIN;
}

static bool broken_empty(stilb_job_queue *queue, uint32_t thread)
{
	(void)queue;
	(void)thread;
	return false;
}

static void broken_rest(stilb_job_queue *queue, uint32_t thread)
{
	(void)queue;
	(void)thread;
}

static history_violation check_broken(queue_fault fault, uint64_t seed)
{
	static const job_queue_ops ops = {.push = broken_push,
	                                  .push_n = broken_push_n,
	                                  .pop = broken_pop,
	                                  .pop_n = broken_pop_n,
	                                  .empty = broken_empty,
	                                  .rest = broken_rest};
	enum { SIDE = 2, VALUES = 20000 };
	broken_queue queue = {.base.ops = &ops, .fault = fault, .lock = PTHREAD_MUTEX_INITIALIZER};
	for (uint32_t i = 0; i < MOST_THREADS; i++)
		queue.fifos[i].items = malloc(VALUES * sizeof(void *));
	history_op *history = NULL;
	size_t count = record_run(&queue.base, SIDE, VALUES, seed, &history);
	history_violation violation = history_check(history, count, VALUES);
	free(history);
	for (uint32_t i = 0; i < MOST_THREADS; i++)
		free(queue.fifos[i].items);
	return violation;
}

/* The interleaving differs from run to run: a fault must show in one of many runs. */
static void test_broken_queues(void **state)
{
	(void)state;
	enum { RUNS = 100 };
	static const history_violation expected[FAULTS] = {
		[FAULT_FORGE] = HISTORY_FRESH,     [FAULT_TWICE] = HISTORY_REPEATED,  [FAULT_LOSE] = HISTORY_OVERTAKEN,
		[FAULT_SWAP] = HISTORY_OVERTAKEN,  [FAULT_SIDES] = HISTORY_OVERTAKEN, [FAULT_LATE] = HISTORY_OVERTAKEN,
		[FAULT_SHY] = HISTORY_NEVER_EMPTY,
	};
	for (uint64_t seed = 0; seed < RUNS / 5; seed++)
		assert_int_equal(check_broken(FAULT_NONE, seed), HISTORY_LINEARISABLE);
	for (queue_fault fault = FAULT_NONE + 1; fault < FAULTS; fault++) {
		uint64_t seed = 0;
		while (seed < RUNS && check_broken(fault, seed) != expected[fault])
			seed++;
		print_message("fault %d found in run %u\n", fault, (unsigned)seed);
		assert_true(seed < RUNS);
	}
}

/* ---- the checker on hand-made runs ---- */

typedef struct example {
	const char *what;
	history_violation expected;
	uint32_t count;
	history_op ops[8];
} example;

#define PUSH(v, b, e)                                                                                                  \
	{                                                                                                                  \
		.begin = (b), .end = (e), .value = (v), .call = HISTORY_PUSH                                                   \
	}
#define POP(v, b, e)                                                                                                   \
	{                                                                                                                  \
		.begin = (b), .end = (e), .value = (v), .call = HISTORY_POP                                                    \
	}
#define EMPTY(b, e)                                                                                                    \
	{                                                                                                                  \
		.begin = (b), .end = (e), .call = HISTORY_EMPTY                                                                \
	}

static void test_examples(void **state)
{
	(void)state;
	enum { VALUES = 4 };
	static const example examples[] = {
		{"nothing", HISTORY_LINEARISABLE, 0, {{0}}},
		{"one after the other", HISTORY_LINEARISABLE, 4, {PUSH(0, 1, 2), PUSH(1, 3, 4), POP(0, 5, 6), POP(1, 7, 8)}},
		{"pushes overlap", HISTORY_LINEARISABLE, 4, {PUSH(0, 1, 4), PUSH(1, 2, 3), POP(1, 5, 6), POP(0, 7, 8)}},
		{"pops overlap", HISTORY_LINEARISABLE, 4, {PUSH(0, 1, 2), PUSH(1, 3, 4), POP(1, 5, 7), POP(0, 6, 8)}},
		{"left behind, in order", HISTORY_LINEARISABLE, 3, {PUSH(0, 1, 2), PUSH(1, 3, 4), POP(0, 5, 6)}},
		{"popped while it is pushed", HISTORY_LINEARISABLE, 2, {PUSH(0, 1, 4), POP(0, 2, 3)}},
		{"never pushed", HISTORY_FRESH, 1, {POP(0, 1, 2)}},
		{"out of range", HISTORY_FRESH, 1, {POP(VALUES, 1, 2)}},
		{"popped before it is pushed", HISTORY_FRESH, 2, {POP(0, 1, 2), PUSH(0, 3, 4)}},
		{"popped twice", HISTORY_REPEATED, 3, {PUSH(0, 1, 2), POP(0, 3, 4), POP(0, 5, 6)}},
		{"overtaken", HISTORY_OVERTAKEN, 4, {PUSH(0, 1, 2), PUSH(1, 3, 4), POP(1, 5, 6), POP(0, 7, 8)}},
		{"lost", HISTORY_OVERTAKEN, 3, {PUSH(0, 1, 2), PUSH(1, 3, 4), POP(1, 5, 6)}},
		{"overtaken, with others between",
	     HISTORY_OVERTAKEN,
	     6,
	     {PUSH(0, 1, 2), PUSH(2, 3, 10), PUSH(1, 4, 5), POP(1, 6, 7), POP(2, 8, 9), POP(0, 11, 12)}},
		{"empty at the start", HISTORY_LINEARISABLE, 2, {EMPTY(1, 3), PUSH(0, 2, 4)}},
		{"empty between two values",
	     HISTORY_LINEARISABLE,
	     5,
	     {PUSH(0, 1, 2), POP(0, 4, 7), EMPTY(3, 9), PUSH(1, 6, 8), POP(1, 10, 11)}},
		{"not empty", HISTORY_NEVER_EMPTY, 3, {PUSH(0, 1, 2), EMPTY(3, 4), POP(0, 5, 6)}},
		{"not empty, and nothing popped", HISTORY_NEVER_EMPTY, 2, {PUSH(0, 1, 2), EMPTY(3, 4)}},
		{"one value or the other all the time",
	     HISTORY_NEVER_EMPTY,
	     5,
	     {PUSH(0, 1, 2), PUSH(1, 4, 5), POP(0, 6, 7), EMPTY(3, 8), POP(1, 9, 10)}},
	};
	for (size_t i = 0; i < sizeof examples / sizeof *examples; i++) {
		history_violation violation = history_check(examples[i].ops, examples[i].count, VALUES);
		if (violation != examples[i].expected)
			fail_msg("%s: %s", examples[i].what, history_violation_name(violation));
	}
}

/* ---- the checker compared with an exhaustive search ---- */

typedef struct search {
	const history_op *ops;
	uint32_t count, done; /* done: a bit for each call that has its place in the order already */
	uint32_t fifo[8], head, tail;
} search;

/* Searches for an order: next may be any call that began before all other remaining calls ended. Source: Wing, Gong,
 * "Testing and Verifying Concurrent Objects", Journal of Parallel and Distributed Computing 17, 1993. */
static bool some_order(search s)
{
	uint64_t first_end = UINT64_MAX;
	for (uint32_t i = 0; i < s.count; i++)
		if (!(s.done >> i & 1) && s.ops[i].end < first_end)
			first_end = s.ops[i].end;
	for (uint32_t i = 0; i < s.count; i++) {
		const history_op *op = &s.ops[i];
		if (s.done >> i & 1 || op->begin > first_end)
			continue;
		search next = s;
		next.done |= 1u << i;
		bool possible = true;
		if (op->call == HISTORY_PUSH)
			next.fifo[next.tail++] = op->value;
		else if (op->call == HISTORY_EMPTY)
			possible = s.head == s.tail;
		else
			possible = s.head < s.tail && s.fifo[next.head++] == op->value;
		if (possible && some_order(next))
			return true;
	}
	return s.done == (1u << s.count) - 1;
}

/* A run of calls at random times, with values pushed once. Half of the runs follow a FIFO, with at most one change. */
static uint32_t random_run(uint64_t *random, history_op *ops)
{
	uint32_t count = 2 + (uint32_t)(next_random(random) % 6), pushed = 0, popped = 0;
	for (uint32_t i = 0; i < count; i++) {
		uint64_t draw = next_random(random), middle = 20 * (i + 3);
		ops[i] = (history_op){.begin = middle - draw % 40, .end = middle + draw / 64 % 40};
		draw /= 4096;
		if (popped == pushed ? draw % 4 == 0 : draw % 16 == 0)
			ops[i].call = HISTORY_EMPTY;
		else if (popped == pushed || draw % 2)
			ops[i] = (history_op){ops[i].begin, ops[i].end, pushed++, HISTORY_PUSH};
		else
			ops[i] = (history_op){ops[i].begin, ops[i].end, popped++, HISTORY_POP};
	}
	uint64_t draw = next_random(random);
	history_op *a = &ops[draw / 2 % count], *b = &ops[draw / 64 % count];
	if (draw % 2 && a->call == b->call) {
		uint32_t value = a->value;
		a->value = b->value;
		b->value = value;
	}
	return count;
}

static void test_against_search(void **state)
{
	(void)state;
	uint32_t verdicts[HISTORY_NO_MEMORY] = {0};
	uint64_t random = 1;
	for (uint32_t i = 0; i < (TEST_EMULATED ? 100000 : 200000); i++) {
		history_op ops[8];
		uint32_t count = random_run(&random, ops);
		history_violation violation = history_check(ops, count, 8);
		assert_int_equal(violation == HISTORY_LINEARISABLE, some_order((search){.ops = ops, .count = count}));
		verdicts[violation]++;
	}
	print_message("linearisable %u, fresh %u, overtaken %u, never empty %u\n", verdicts[HISTORY_LINEARISABLE],
	              verdicts[HISTORY_FRESH], verdicts[HISTORY_OVERTAKEN], verdicts[HISTORY_NEVER_EMPTY]);
	assert_true(verdicts[HISTORY_LINEARISABLE] > 1000 && verdicts[HISTORY_FRESH] > 1000);
	assert_true(verdicts[HISTORY_OVERTAKEN] > 1000 && verdicts[HISTORY_NEVER_EMPTY] > 1000);
}

int main(int argc, char **argv)
{
	if (argc > 1)
		operations = (uint32_t)strtoul(argv[1], NULL, 10);
	sigaction(SIGUSR1, &(struct sigaction){.sa_handler = sleep_here, .sa_flags = SA_RESTART}, NULL);
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_examples), cmocka_unit_test(test_against_search), cmocka_unit_test(test_broken_queues),
		cmocka_unit_test(test_kinds),    cmocka_unit_test(test_kinds_bounded),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
