/*
 * Many threads on every kind of queue: every item is popped once, those of one producer in order, and the producer's
 * writes before the push are visible after the pop. The items point to plain memory, so that a missing memory order in
 * the queue is a data race for the thread sanitizer.
 */
#include <errno.h>
#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <time.h>

#include "job_queue_kinds.h"
#include "job_random.h"
#include "support/test.h"

enum {
	SLOWER = TEST_TSAN || TEST_EMULATED ? 8
	         : TEST_ASAN                ? 4
	                                    : 1,
	SIDE_MOST = 8,
	THREADS = 2 * SIDE_MOST,
	ITEMS = 120000 / SLOWER,
	BATCH = 24,
	ROUNDS = 80 / SLOWER,
	INTERRUPTIONS = 40
};

static const queue_kind *kind;

/* The object that an item points to. Only the thread that has the item accesses it. */
typedef struct parcel {
	uint32_t producer, number;
	uint64_t seal;
	uint32_t popped;
} parcel;

static uint64_t seal_of(uint32_t producer, uint32_t number)
{
	uint64_t state = (uint64_t)producer << 32 | number;
	return next_random(&state);
}

typedef enum crowd_style {
	SINGLE,  /* one item in each call */
	BATCHES, /* up to BATCH items */
	MIXED,   /* alternating between the two */
	RESTING, /* as MIXED, and threads rest now and then */
	STYLES,
	WHOLE /* BATCH items in each push, fewer at the end; they must stay together */
} crowd_style;

typedef struct crowd {
	stilb_job_queue *queue;
	crowd_style style;
	uint32_t producers, consumers, each; /* each: parcels of each producer */
	parcel *parcels;
} crowd;

/* A thread and its observations, which are read after it was joined. */
typedef struct member {
	crowd *crowd;
	pthread_t thread;
	uint32_t number; /* thread number for the queue */
	uint64_t random;
	uint32_t producer, pushed, last; /* producers: own index; number of the next parcel; number after the last one */
	uint32_t popped, most;           /* consumers: number popped, and number wanted */
	uint32_t newest[SIDE_MOST];      /* consumers: the last number popped of each producer, plus one */
	const parcel *next_whole;        /* consumers: the next parcel, if pushes stay together */
	uint32_t disorder, damage, tears, surprises;
} member;

static size_t items_at_once(member *self, uint32_t most)
{
	uint64_t draw = next_random(&self->random);
	if (self->crowd->style == WHOLE)
		return most < BATCH ? most : BATCH;
	bool single = self->crowd->style == SINGLE || (self->crowd->style != BATCHES && draw % 2);
	size_t count = single ? 1 : 1 + draw / 2 % BATCH;
	return count < most ? count : most;
}

static void rest_at_random(member *self)
{
	if (self->crowd->style != RESTING || next_random(&self->random) % 256)
		return;
	stilb_job_queue_rest(self->crowd->queue, self->number);
	nanosleep(&(struct timespec){.tv_nsec = (long)(next_random(&self->random) % 100000)}, NULL);
}

static int push_some(member *self, parcel *parcels, size_t count)
{
	void *items[BATCH];
	for (size_t i = 0; i < count; i++)
		items[i] = &parcels[i];
	if (count > 1)
		return stilb_job_queue_push_n(self->crowd->queue, items, count, self->number);
	int error = stilb_job_queue_push(self->crowd->queue, items[0], self->number);
	return error ? error : 1;
}

/* Pushes until all its parcels are pushed or the queue is closed. */
static void *produce(void *data)
{
	member *self = data;
	parcel *own = self->crowd->parcels + (size_t)self->producer * self->crowd->each;
	while (self->pushed < self->last) {
		size_t count = items_at_once(self, self->last - self->pushed);
		for (uint32_t i = self->pushed; i < self->pushed + count; i++) {
			own[i].producer = self->producer;
			own[i].number = i;
			own[i].seal = seal_of(self->producer, i);
		}
		int pushed = push_some(self, own + self->pushed, count);
		if (pushed == -EPIPE)
			break;
		self->surprises += pushed <= 0 && pushed != -EAGAIN;
		if (pushed > 0)
			self->pushed += (uint32_t)pushed;
		else
			sched_yield();
		rest_at_random(self);
	}
	return NULL;
}

static void receive(member *self, parcel *got)
{
	self->damage += got->producer >= self->crowd->producers || got->seal != seal_of(got->producer, got->number);
	uint32_t *newest = &self->newest[got->producer % SIDE_MOST];
	self->disorder += got->number < *newest;
	*newest = got->number + 1;
	/* In this style there is one consumer: after an item that is not the last one of its push comes the next one of
	 * that push. */
	self->tears += self->crowd->style == WHOLE && self->next_whole && self->next_whole != got;
	self->next_whole = (got->number + 1) % BATCH && got->number + 1 < self->crowd->each ? got + 1 : NULL;
	got->popped++;
	self->popped++;
}

static int pop_some(member *self)
{
	void *items[BATCH];
	size_t max = items_at_once(self, self->most - self->popped);
	int popped = max > 1 ? stilb_job_queue_pop_n(self->crowd->queue, items, max, self->number)
	                     : stilb_job_queue_pop(self->crowd->queue, items, self->number);
	if (max == 1 && popped == 0)
		popped = 1;
	for (int i = 0; i < popped; i++)
		receive(self, items[i]);
	return popped;
}

/* Pops until it has the number wanted, or the queue is closed and empty. */
static void *consume(void *data)
{
	member *self = data;
	while (self->popped < self->most) {
		int popped = pop_some(self);
		if (popped == -EPIPE)
			break;
		self->surprises += popped < 0 && popped != -EAGAIN;
		if (popped < 0)
			sched_yield();
		rest_at_random(self);
	}
	for (int i = 0; i < 20 && self->popped < self->most; i++) { /* a closed and empty queue stays so */
		sched_yield();
		self->surprises += pop_some(self) != -EPIPE;
	}
	return NULL;
}

/* ---- running all threads --------------------------------------------------------------------------------------- */

static crowd crowd_create(uint32_t producers, uint32_t consumers, crowd_style style, size_t capacity)
{
	crowd all = {.producers = producers, .consumers = consumers, .style = style, .each = ITEMS / producers};
	all.queue = queue_kind_create(kind, capacity, producers + consumers);
	all.parcels = calloc((size_t)producers * all.each, sizeof *all.parcels);
	assert_non_null(all.parcels);
	return all;
}

static void member_start(member *self, void *(*role)(void *))
{
	assert_int_equal(pthread_create(&self->thread, NULL, role, self), 0);
}

static void crowd_start(crowd *all, member *members, uint64_t seed)
{
	for (uint32_t i = 0; i < all->producers + all->consumers; i++) {
		members[i] = (member){.crowd = all, .number = i, .random = seed * THREADS + i, .most = UINT32_MAX};
		members[i].producer = i;
		members[i].last = all->each;
		member_start(&members[i], i < all->producers ? produce : consume);
	}
}

static void member_join(member *self)
{
	pthread_join(self->thread, NULL);
	assert_int_equal(self->disorder, 0);
	assert_int_equal(self->damage, 0);
	assert_int_equal(self->tears, 0);
	assert_int_equal(self->surprises, 0);
}

static void crowd_destroy(crowd *all)
{
	stilb_job_queue_destroy(all->queue);
	free(all->parcels);
}

/* Asserts that exactly the accepted items were popped, each once. */
static void crowd_finish(crowd *all, member *members)
{
	uint64_t pushed = 0, popped = 0;
	for (uint32_t i = 0; i < all->producers; i++) {
		pushed += members[i].pushed;
		for (uint32_t k = 0; k < all->each; k++)
			assert_int_equal(all->parcels[(size_t)i * all->each + k].popped, k < members[i].pushed);
	}
	for (uint32_t i = 0; i < all->consumers; i++)
		popped += members[all->producers + i].popped;
	assert_int_equal(pushed, popped);
	crowd_destroy(all);
}

static void run_crowd(uint32_t producers, uint32_t consumers, crowd_style style, size_t capacity)
{
	member members[THREADS];
	crowd all = crowd_create(producers, consumers, style, capacity);
	crowd_start(&all, members, style);
	for (uint32_t i = 0; i < producers; i++) {
		member_join(&members[i]);
		assert_int_equal(members[i].pushed, all.each);
	}
	stilb_job_queue_close(all.queue);
	for (uint32_t i = producers; i < producers + consumers; i++)
		member_join(&members[i]);
	crowd_finish(&all, members);
}

static void test_crowds(void **state)
{
	(void)state;
	for (crowd_style style = SINGLE; style < STYLES; style++)
		for (uint32_t side = 1; side <= SIDE_MOST; side *= 2)
			run_crowd(side, side, style, SIZE_MAX);
}

static void test_lopsided_crowds(void **state)
{
	(void)state;
	run_crowd(1, SIDE_MOST, MIXED, SIZE_MAX);
	run_crowd(SIDE_MOST, 1, MIXED, SIZE_MAX);
}

static void test_bounded_crowds(void **state)
{
	(void)state;
	if (!kind->bounded)
		skip();
	run_crowd(4, 4, MIXED, 5);
	run_crowd(2, 2, SINGLE, 64);
	run_crowd(4, 4, BATCHES, 513);
	run_crowd(4, 4, RESTING, 1500);
}

static void test_close_under_load(void **state)
{
	(void)state;
	uint64_t random = 1;
	for (int round = 0; round < ROUNDS; round++) {
		member members[THREADS];
		uint32_t side = 1u << round % 3;
		crowd all = crowd_create(side, side, (crowd_style)(round % 3), SIZE_MAX);
		crowd_start(&all, members, (uint64_t)round);
		nanosleep(&(struct timespec){.tv_nsec = (long)(next_random(&random) % 1000000)}, NULL);
		stilb_job_queue_close(all.queue);
		for (uint32_t i = 0; i < 2 * side; i++)
			member_join(&members[i]);
		crowd_finish(&all, members);
	}
}

/* Threads end and new ones reuse their numbers in other roles, with or without a rest in between. Items left in the
 * queue are popped by the next generation. */
static void test_numbers_reused(void **state)
{
	(void)state;
	enum { SIDE = 2, GENERATIONS = 40 };
	crowd all = crowd_create(SIDE, SIDE, MIXED, SIZE_MAX);
	uint32_t each = all.each / GENERATIONS / 2 * 2;
	for (uint32_t generation = 0; generation <= GENERATIONS; generation++) {
		member members[2 * SIDE];
		bool last = generation == GENERATIONS;
		if (last)
			stilb_job_queue_close(all.queue);
		for (uint32_t i = 0; i < 2 * SIDE; i++) {
			member *self = &members[i];
			*self =
				(member){.crowd = &all, .number = (i + generation) % (2 * SIDE), .random = generation, .producer = i};
			self->pushed = each * generation;
			self->last = last ? 0 : each * (generation + 1);
			self->most = last ? UINT32_MAX : generation == 0 ? each / 2 : each;
			member_start(self, i < SIDE ? produce : consume);
		}
		for (uint32_t i = 0; i < 2 * SIDE; i++)
			member_join(&members[i]);
		if (generation % 2)
			for (uint32_t number = 0; number < 2 * SIDE; number++)
				stilb_job_queue_rest(all.queue, number);
	}
	for (uint32_t i = 0; i < SIDE; i++)
		for (uint32_t k = 0; k < all.each; k++)
			assert_int_equal(all.parcels[(size_t)i * all.each + k].popped, k < each * GENERATIONS);
	crowd_destroy(&all);
}

/* Kinds that promise it keep the items of one push_n together. */
static void test_whole_pushes(void **state)
{
	(void)state;
	if (!kind->whole_pushes)
		skip();
	member members[4];
	crowd all = crowd_create(3, 1, WHOLE, SIZE_MAX);
	crowd_start(&all, members, 1);
	for (uint32_t i = 0; i < 3; i++)
		member_join(&members[i]);
	stilb_job_queue_close(all.queue);
	member_join(&members[3]);
	crowd_finish(&all, members);
}

/* ---- two threads on one CPU: the one that wakes up interrupts the other anywhere, and makes several calls at once */

typedef struct pair {
	stilb_job_queue *queue;
	_Atomic bool stop; /* relaxed: only ends the loop */
	uint32_t found;
} pair;

static cpu_set_t share_one_cpu(void)
{
	cpu_set_t all, one;
	assert_int_equal(sched_getaffinity(0, sizeof all, &all), 0);
	CPU_ZERO(&one);
	int cpu = 0;
	while (!CPU_ISSET(cpu, &all))
		cpu++;
	CPU_SET(cpu, &one);
	assert_int_equal(sched_setaffinity(0, sizeof one, &one), 0); /* inherited by threads created from now on */
	return all;
}

static void sleep_a_little(void)
{
	nanosleep(&(struct timespec){.tv_nsec = 1000}, NULL);
}

static void *look_for_emptiness(void *data)
{
	pair *self = data;
	while (!atomic_load_explicit(&self->stop, memory_order_relaxed))
		self->found += stilb_job_queue_empty(self->queue, 0);
	return NULL;
}

/* A queue that always contains an item, though not always the same one, is never reported empty. */
static void test_never_empty(void **state)
{
	(void)state;
	cpu_set_t cpus = share_one_cpu();
	pair both = {.queue = queue_kind_create(kind, SIZE_MAX, 2)};
	pthread_t other;
	void *item = &both;
	assert_int_equal(stilb_job_queue_push(both.queue, item, 1), 0);
	assert_int_equal(pthread_create(&other, NULL, look_for_emptiness, &both), 0);
	for (int i = 0; i < INTERRUPTIONS; i++) {
		sleep_a_little();
		assert_int_equal(stilb_job_queue_push(both.queue, item, 1), 0);
		assert_int_equal(stilb_job_queue_pop(both.queue, &item, 1), 0);
	}
	atomic_store_explicit(&both.stop, true, memory_order_relaxed);
	pthread_join(other, NULL);
	stilb_job_queue_destroy(both.queue);
	sched_setaffinity(0, sizeof cpus, &cpus);
	assert_int_equal(both.found, 0);
}

static void *pop_to_the_end(void *data)
{
	pair *self = data;
	void *item;
	for (int error = 0; error != -EPIPE;) {
		error = stilb_job_queue_pop(self->queue, &item, 0);
		self->found += error == 0;
	}
	return NULL;
}

/* A thread that learns that the queue is closed and empty, after a push and the following close, has seen that push. */
static void test_close_after_push(void **state)
{
	(void)state;
	cpu_set_t cpus = share_one_cpu();
	uint32_t found = 0;
	for (int i = 0; i < INTERRUPTIONS; i++) {
		pair both = {.queue = queue_kind_create(kind, SIZE_MAX, 2)};
		pthread_t other;
		assert_int_equal(pthread_create(&other, NULL, pop_to_the_end, &both), 0);
		sleep_a_little();
		assert_int_equal(stilb_job_queue_push(both.queue, &both, 1), 0);
		stilb_job_queue_close(both.queue);
		pthread_join(other, NULL);
		stilb_job_queue_destroy(both.queue);
		found += both.found;
	}
	sched_setaffinity(0, sizeof cpus, &cpus);
	assert_int_equal(found, INTERRUPTIONS);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_crowds),         cmocka_unit_test(test_lopsided_crowds),
		cmocka_unit_test(test_bounded_crowds), cmocka_unit_test(test_close_under_load),
		cmocka_unit_test(test_numbers_reused), cmocka_unit_test(test_whole_pushes),
		cmocka_unit_test(test_never_empty),    cmocka_unit_test(test_close_after_push),
	};
	int failed = 0;
	for (int i = 0; i < QUEUE_KINDS; i++) {
		kind = &queue_kinds[i];
		failed += cmocka_run_group_tests_name(kind->name, tests, NULL, NULL);
	}
	return failed;
}
