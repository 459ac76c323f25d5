/*
 * Threads that are stopped at any instruction of a push or a pop, in a signal handler that waits for a byte from a
 * pipe. With a lock-free queue the other threads make progress meanwhile, even if only one is left. With the other
 * kinds they may have to wait, and continue when the stopped threads do; that this happens now and then shows that
 * threads are stopped inside critical sections.
 *
 * No result depends on the machine's speed: the test waits for progress, and only its absence for PATIENCE_S fails.
 *
 * test_job_queue_stall [ROUNDS]: with ROUNDS, so many rounds on all kinds of queue; without, a few on the library's.
 */
#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "job_queue_kinds.h"
#include "job_random.h"
#include "jobs/job_sys.h"
#include "support/test.h"

/* PROGRESS: items pushed and popped while threads are stopped; many segments. */
enum {
	THREADS = 4,
	ROUNDS = TEST_ASAN || TEST_EMULATED ? 40 : 100,
	PROGRESS = 20000,
	SOME = 200,
	PATIENCE_S = 30,
	STOP_MS = 5
};

static const queue_kind *kind;
static uint32_t rounds = ROUNDS;

typedef enum where { OUTSIDE, IN_PUSH, IN_POP, PLACES } where;

typedef struct walker {
	stilb_job_queue *queue;
	pthread_t thread;
	uint32_t number;
	_Atomic bool *stop;              /* relaxed: only ends the loop */
	_Atomic uint32_t pushed, popped; /* relaxed: successful calls, for other threads to watch */
	/* stopped in the handler. Release by this thread, pairs with the acquire of those that wait for it */
	_Atomic bool stands;
	volatile sig_atomic_t place; /* a value of `where`; written by the thread, read by its signal handler */
	volatile sig_atomic_t stood; /* the handler ran during the current call */
	/* how often the handler ran in each place; read while the thread is stopped, and at the end */
	uint32_t stops[PLACES];
	uint64_t pushed_sum, popped_sum; /* sums of values; read at the end */
	uint64_t longest;                /* the longest call without a stop, in ticks */
} walker;

static int gate[2]; /* a pipe; each byte releases one stopped thread */
static _Thread_local walker *own;

static void stand_still(int signal)
{
	(void)signal;
	int saved = errno;
	own->stops[own->place]++;
	own->stood = 1;
	atomic_store_explicit(&own->stands, true, memory_order_release);
	char byte;
	while (read(gate[0], &byte, 1) != 1)
		;
	atomic_store_explicit(&own->stands, false, memory_order_release);
	errno = saved;
}

static uint64_t call_begin(walker *self, where place)
{
	self->stood = 0;
	self->place = place;
	return job_sys_ticks();
}

static void call_end(walker *self, uint64_t begin)
{
	uint64_t took = job_sys_ticks() - begin;
	self->place = OUTSIDE;
	if (!self->stood && took > self->longest)
		self->longest = took;
}

static void *walk(void *data)
{
	walker *self = own = data;
	atomic_store_explicit(&self->stands, false, memory_order_release);
	for (uintptr_t value = self->number + 1; !atomic_load_explicit(self->stop, memory_order_relaxed);) {
		uint64_t begin = call_begin(self, IN_PUSH);
		int error = stilb_job_queue_push(self->queue, (void *)value, self->number);
		call_end(self, begin);
		if (!error) {
			self->pushed_sum += value;
			value += THREADS;
			atomic_fetch_add_explicit(&self->pushed, 1, memory_order_relaxed);
		}
		void *item = NULL;
		begin = call_begin(self, IN_POP);
		error = stilb_job_queue_pop(self->queue, &item, self->number);
		call_end(self, begin);
		if (!error) {
			self->popped_sum += (uintptr_t)item;
			atomic_fetch_add_explicit(&self->popped, 1, memory_order_relaxed);
		}
	}
	return NULL;
}

static uint64_t now_ms(void)
{
	struct timespec now;
	clock_gettime(CLOCK_MONOTONIC, &now);
	return (uint64_t)now.tv_sec * 1000 + (uint64_t)now.tv_nsec / 1000000;
}

static void sleep_us(uint64_t us)
{
	nanosleep(&(struct timespec){.tv_nsec = (long)us * 1000}, NULL);
}

/* Sums up the successful calls of walkers[first..THREADS) while they run. */
static void count_calls(walker *walkers, uint32_t first, uint32_t *pushed, uint32_t *popped)
{
	*pushed = *popped = 0;
	for (uint32_t i = first; i < THREADS; i++) {
		*pushed += atomic_load_explicit(&walkers[i].pushed, memory_order_relaxed);
		*popped += atomic_load_explicit(&walkers[i].popped, memory_order_relaxed);
	}
}

/* True as soon as these threads have pushed and popped so many items together; false after ms milliseconds. */
static bool progress_within(walker *walkers, uint32_t first, uint32_t wanted, uint64_t ms)
{
	uint32_t pushed, popped, pushed_before, popped_before;
	count_calls(walkers, first, &pushed_before, &popped_before);
	uint64_t end = now_ms() + ms;
	do {
		sleep_us(50);
		count_calls(walkers, first, &pushed, &popped);
		if (pushed - pushed_before >= wanted && popped - popped_before >= wanted)
			return true;
	} while (now_ms() <= end);
	return false;
}

static void await_walkers(walker *walkers, uint32_t count, bool stand)
{
	for (uint32_t i = 0; i < count; i++)
		while (atomic_load_explicit(&walkers[i].stands, memory_order_acquire) != stand)
			sleep_us(20);
}

/* Stops the first `count` threads one after the other; returns when all are stopped. */
static void stop_walkers(walker *walkers, uint32_t count, uint64_t *random)
{
	for (uint32_t i = 0; i < count; i++) {
		for (uint64_t pauses = next_random(random) % 64; pauses > 0; pauses--)
			job_sys_pause();
		pthread_kill(walkers[i].thread, SIGUSR1);
		await_walkers(walkers + i, 1, true);
	}
}

static void release_walkers(walker *walkers, uint32_t count)
{
	for (uint32_t i = 0; i < count; i++)
		assert_int_equal(write(gate[1], "", 1), 1);
	await_walkers(walkers, count, false);
}

/* Stops threads and watches the others; returns how many times the others had to wait. Threads of the low-lock queue
 * are stopped more often until one was that held a lock, which may take long on a busy machine. */
static uint32_t stop_and_watch(walker *walkers)
{
	enum { MOST = 50 };
	uint32_t waits = 0;
	uint64_t random = 1;
	for (uint32_t round = 0; round < rounds || (!kind->lock_free && waits == 0 && round < MOST * rounds); round++) {
		uint32_t stopped = 1 + round % (THREADS - 1);
		stop_walkers(walkers, stopped, &random);
		bool goes_on = kind->lock_free ? progress_within(walkers, stopped, PROGRESS, PATIENCE_S * 1000)
		                               : progress_within(walkers, stopped, SOME, STOP_MS);
		release_walkers(walkers, stopped);
		waits += !goes_on;
		if (!goes_on && kind->lock_free)
			fail_msg("round %u: %u stopped, and the rest with them", round, stopped);
		if (!progress_within(walkers, 0, SOME, PATIENCE_S * 1000))
			fail_msg("round %u: %u went on, but nothing else does", round, stopped);
	}
	return waits;
}

static void run_walkers(size_t capacity)
{
	_Atomic bool stop = false;
	static walker walkers[THREADS];
	memset(walkers, 0, sizeof walkers);
	stilb_job_queue *queue = queue_kind_create(kind, capacity, THREADS);
	for (uint32_t i = 0; i < THREADS; i++) {
		walkers[i].queue = queue;
		walkers[i].number = i;
		walkers[i].stop = &stop;
		atomic_init(&walkers[i].stands, true); /* true until the thread can be stopped */
		assert_int_equal(pthread_create(&walkers[i].thread, NULL, walk, &walkers[i]), 0);
	}
	await_walkers(walkers, THREADS, false);
	uint32_t waits = stop_and_watch(walkers);
	atomic_store_explicit(&stop, true, memory_order_relaxed);
	uint64_t pushed = 0, popped = 0, longest = 0;
	uint32_t stops[PLACES] = {0};
	for (uint32_t i = 0; i < THREADS; i++) {
		pthread_join(walkers[i].thread, NULL);
		pushed += walkers[i].pushed_sum;
		popped += walkers[i].popped_sum;
		longest = walkers[i].longest > longest ? walkers[i].longest : longest;
		for (int place = 0; place < PLACES; place++)
			stops[place] += walkers[i].stops[place];
	}
	void *item = NULL;
	while (stilb_job_queue_pop(queue, &item, 0) == 0)
		popped += (uintptr_t)item;
	stilb_job_queue_destroy(queue);
	print_message("%s: stopped in push %u, in pop %u, elsewhere %u times; the others stopped too in %u of %u rounds; "
	              "longest call of a thread that was not stopped: %.3f ms\n",
	              kind->name, stops[IN_PUSH], stops[IN_POP], stops[OUTSIDE], waits, rounds,
	              (double)longest / (double)job_sys_ticks_in(1000000));
	assert_int_equal(popped, pushed);
	assert_true(stops[IN_PUSH] > 0 && stops[IN_POP] > 0);
	if (!kind->lock_free)
		assert_true(waits > 0);
}

static void test_stall(void **state)
{
	(void)state;
	run_walkers(SIZE_MAX);
}

static void test_stall_bounded(void **state)
{
	(void)state;
	if (!kind->bounded)
		skip();
	run_walkers(THREADS);
}

int main(int argc, char **argv)
{
	if (argc > 1)
		rounds = (uint32_t)strtoul(argv[1], NULL, 10);
	if (pipe(gate) != 0)
		return 1;
	sigaction(SIGUSR1, &(struct sigaction){.sa_handler = stand_still, .sa_flags = SA_RESTART}, NULL);
	const struct CMUnitTest tests[] = {cmocka_unit_test(test_stall), cmocka_unit_test(test_stall_bounded)};
	int failed = 0;
	for (int i = 0; i < (argc > 1 ? QUEUE_KINDS : QUEUE_KINDS_OURS); i++) {
		kind = &queue_kinds[i];
		failed += cmocka_run_group_tests_name(kind->name, tests, NULL, NULL);
	}
	return failed;
}
