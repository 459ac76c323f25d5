/*
 * queue_load: the load under which the suite `queue` measures every subject (a queue). It is compiled into the program
 * of each queue, in C or C++, so that inline functions of a queue are inlined. A program defines, before it includes
 * this header,
 *
 *   typedef ... subject_queue;    the queue; one object, zero-initialised
 *   typedef ... subject_thread;   state of one thread: tokens, spare nodes; zero-initialised
 *   #define SUBJECT_BATCH 0       1 if it has subject_push_n and subject_pop_n
 *
 * and after it the subject_... functions declared below and a main that returns queue_load_main(argc, argv).
 *
 * Cases.    [batch16- | latency- | stall- | calm-][pinned-]<producers>P<consumers>C: throughput item by item or in
 *           batches of 16; the time of each call; the longest gap without a successful call, while threads are stopped
 *           at random (stall) or not (calm).
 * Run.      Producers push for the given time; then consumers take the rest. A thread whose push finds the queue full,
 *           or whose pop finds it empty, executes a pause instruction for the first 16 tries and yields after that.
 *           Threads are left to the scheduler or pinned: thread i, producers first, to CPU i modulo the number of CPUs.
 * Backlog.  Producers wait while the queue holds more than QUEUE_LOAD_BACKLOG items. Otherwise a queue whose producers
 *           run ahead would measure how fast the kernel hands out memory.
 * Check.    Items are distinct numbers. The number, the sum and the sum of squares of the items popped must equal those
 *           of the items pushed.
 *
 * Threads: subject_open and queue_load_main are [main-thread], the other subject_... functions are called by all
 * threads at once, each with its own subject_thread.
 */
#ifndef BENCH_QUEUE_LOAD_H
#define BENCH_QUEUE_LOAD_H

#include "bench/harness/bench_child.h"

#include <pthread.h>
#include <signal.h>
#include <stdbool.h>
#include <string.h>

#define QUEUE_LOAD_BATCH 16
#define QUEUE_LOAD_BOUNDED 4096 /* capacity of bounded queues */
#ifndef QUEUE_LOAD_BACKLOG
#define QUEUE_LOAD_BACKLOG 1000000 /* items */
#endif
#define QUEUE_LOAD_LOOK_EVERY                                                                                          \
	(QUEUE_LOAD_BACKLOG >= 100000 ? 1024 : 16) /* items between two looks of a producer at the backlog */
#define QUEUE_LOAD_STALL_BACKLOG 8000000       /* items: so many that no producer waits for a stopped consumer */
/* Calls between two yields when gaps are measured. Without yields the scheduler itself would cause gaps: time slices of
 * some milliseconds in which only producers, or only consumers, run. */
#define QUEUE_LOAD_YIELD_EVERY 256
#define QUEUE_LOAD_MAX_THREADS 1024
#define QUEUE_LOAD_STALL_EVERY_NS 22000000
#define QUEUE_LOAD_STALL_NS 20000000

/* Alignment by two cache lines, since the adjacent-line prefetcher fetches them in pairs. */
#define QUEUE_LOAD_ALIGNED __attribute__((aligned(128)))

typedef enum queue_load_mode {
	QUEUE_LOAD_PLAIN,   /* throughput */
	QUEUE_LOAD_LATENCY, /* time of every call that succeeds */
	QUEUE_LOAD_GAPS     /* longest time without a successful call of any thread */
} queue_load_mode;

typedef struct queue_load {
	const char *subject, *case_name;
	queue_load_mode mode;
	bool batch, pinned, stall;
	uint32_t producers, consumers;
	uint32_t threads; /* their number; thread indices: producers first, then consumers, the main thread last */
	double seconds;
} queue_load;

/* ---- defined by the program of a queue --------------------------------------------------------------------------- */

/* Creates the queue; exits with BENCH_CHILD_SKIP if it cannot take this load. */
static void subject_open(subject_queue *queue, const queue_load *load);
/* Called once by each thread, first; thread: 0..load->threads - 1. */
static void subject_enter(subject_queue *queue, subject_thread *self, uint32_t thread);
/* False: the queue is full. */
static inline bool subject_push(subject_queue *queue, subject_thread *self, void *item);
/* False: the queue is empty. */
static inline bool subject_pop(subject_queue *queue, subject_thread *self, void **item);
#if SUBJECT_BATCH
/* Return the number of items pushed or popped, 0..count. */
static inline size_t subject_push_n(subject_queue *queue, subject_thread *self, void **items, size_t count);
static inline size_t subject_pop_n(subject_queue *queue, subject_thread *self, void **items, size_t count);
#endif
#ifdef SUBJECT_ENDLESS
/* The subject is no queue but a counter that every call of push and pop increments; a pop always succeeds. True if the
 * counter is pushes + pops. */
static bool subject_verify(subject_queue *queue, uint64_t pushes, uint64_t pops);
#endif

/* ---- cases ------------------------------------------------------------------------------------------------------- */

/* Reads the case's name; exits with BENCH_CHILD_SKIP if it is none of those that the head of this file lists. */
static inline queue_load queue_load_parse(const bench_child *child)
{
	queue_load load;
	memset(&load, 0, sizeof load);
	load.subject = child->subject;
	load.case_name = child->case_name;
	const char *name = child->case_name, *digits = strrchr(name, '-');
	if (sscanf(digits ? digits + 1 : name, "%uP%uC", &load.producers, &load.consumers) != 2 || load.producers == 0 ||
	    load.consumers == 0 || load.producers + load.consumers >= QUEUE_LOAD_MAX_THREADS)
		exit(BENCH_CHILD_SKIP);
	load.stall = strstr(name, "stall-");
	load.batch = strstr(name, "batch16-");
	load.pinned = strstr(name, "pinned-");
	load.mode = strstr(name, "latency-")              ? QUEUE_LOAD_LATENCY
	            : load.stall || strstr(name, "calm-") ? QUEUE_LOAD_GAPS
	                                                  : QUEUE_LOAD_PLAIN;
	load.threads = load.producers + load.consumers + 1;
	load.seconds = child->seconds;
	return load;
}

/* ---- histogram of times: 64 equal buckets for each power of two -------------------------------------------------- */

#define QUEUE_LOAD_STEPS 64
#define QUEUE_LOAD_BUCKETS (QUEUE_LOAD_STEPS * 40)

static inline uint32_t queue_load_bucket(uint64_t ticks)
{
	if (ticks < QUEUE_LOAD_STEPS)
		return (uint32_t)ticks;
	uint32_t shift = 57u - (uint32_t)__builtin_clzll(ticks); /* so that ticks >> shift is 64..127 */
	uint32_t bucket = shift * QUEUE_LOAD_STEPS + (uint32_t)(ticks >> shift);
	return bucket < QUEUE_LOAD_BUCKETS ? bucket : QUEUE_LOAD_BUCKETS - 1;
}

/* The middle of a bucket, in ticks. */
static inline double queue_load_bucket_middle(uint32_t bucket)
{
	if (bucket < QUEUE_LOAD_STEPS)
		return bucket;
	uint32_t shift = bucket / QUEUE_LOAD_STEPS - 1;
	return ((double)(bucket - shift * QUEUE_LOAD_STEPS) + 0.5) * (double)(UINT64_C(1) << shift);
}

/* ---- threads ----------------------------------------------------------------------------------------------------- */

#define QUEUE_LOAD_MARK_SHIFT 15 /* gaps have a resolution of 2^15 ticks, some 10 us */

/* Sums over a set of items, modulo 2^64, that differ if an item is lost, repeated or changed. */
typedef struct queue_load_sums {
	uint64_t sum, squares;
} queue_load_sums;

typedef struct QUEUE_LOAD_ALIGNED queue_load_thread {
	/* Items pushed or popped. Relaxed: producers only estimate the backlog from it, so an old value is harmless. */
	uint64_t count;
	queue_load_sums sums; /* sums over the items that a consumer has popped */
	subject_thread own;
	uint32_t index;
	uint64_t end_ns;
	uint32_t *times; /* [QUEUE_LOAD_BUCKETS] histogram of call times, or NULL */
	uint8_t *marks;  /* [load_mark_count] or NULL: 1 for each step of 2^QUEUE_LOAD_MARK_SHIFT ticks with a success */
	pthread_t thread;
} queue_load_thread;

static QUEUE_LOAD_ALIGNED subject_queue load_queue;
static queue_load_thread load_threads[QUEUE_LOAD_MAX_THREADS];
/* Tells producers to end; set once by the main thread. Relaxed: it orders nothing, and a few pushes more do no harm. */
static QUEUE_LOAD_ALIGNED bool load_stop;
/* Set by the main thread after it joined all producers. Release, pairs with the acquire of the consumers: a queue that
 * is then empty stays empty. */
static bool load_drain;
static QUEUE_LOAD_ALIGNED queue_load load_setup;
static int64_t load_backlog;
static uint64_t load_start_ticks;
static uint64_t load_mark_count;
static pthread_barrier_t load_barrier;

static inline void load_wait(uint32_t *turns)
{
	if (*turns < 16) {
		(*turns)++;
#if defined(__x86_64__)
		__builtin_ia32_pause();
#endif
	} else {
		sched_yield();
	}
}

static inline void load_count(queue_load_thread *self, uint64_t items)
{
	__atomic_store_n(&self->count, self->count + items, __ATOMIC_RELAXED);
}

static inline void load_take(queue_load_thread *self, void *item)
{
	self->sums.sum += (uint64_t)item;
	self->sums.squares += (uint64_t)item * (uint64_t)item;
}

/* Producer i pushes the items (i + 1) * 2^40 + 1, + 2, + 3, ...: distinct numbers. Returns the number before the
 * first. */
static inline uint64_t load_first_item(const queue_load_thread *self)
{
	return (uint64_t)(self->index + 1) << 40;
}

/* Notes a successful call in the thread's histogram or marks. begin, in ticks, is when it began, for latencies. */
static inline void load_note(queue_load_thread *self, queue_load_mode mode, uint64_t begin)
{
	if (mode == QUEUE_LOAD_LATENCY) {
		self->times[queue_load_bucket(bench_child_ticks() - begin)]++;
	} else if (mode == QUEUE_LOAD_GAPS) {
		uint64_t mark = (bench_child_ticks() - load_start_ticks) >> QUEUE_LOAD_MARK_SHIFT;
		if (mark < load_mark_count)
			self->marks[mark] = 1;
		if (self->count % QUEUE_LOAD_YIELD_EVERY == 0)
			sched_yield();
	}
}

static uint64_t load_sum_counts(uint32_t first, uint32_t end)
{
	uint64_t sum = 0;
	for (uint32_t i = first; i < end; i++)
		sum += __atomic_load_n(&load_threads[i].count, __ATOMIC_RELAXED);
	return sum;
}

/* Waits while the backlog, the number of items pushed but not yet popped, is larger than load_backlog. */
static void load_throttle(void)
{
	uint32_t turns = 0, producers = load_setup.producers;
	while ((int64_t)(load_sum_counts(0, producers) - load_sum_counts(producers, load_setup.threads)) > load_backlog)
		load_wait(&turns);
}

#define LOAD_INLINE static inline __attribute__((always_inline))

LOAD_INLINE void load_produce(queue_load_thread *self, queue_load_mode mode)
{
	uint64_t item = load_first_item(self);
	do { /* at least once: on a busy machine a short run may be over before this thread gets a CPU */
		uint32_t turns = 0;
		uint64_t begin =
			mode == QUEUE_LOAD_LATENCY ? bench_child_ticks() : 0; /* waiting while the queue is full is included */
		while (!subject_push(&load_queue, &self->own, (void *)++item))
			item--, load_wait(&turns);
		load_note(self, mode, begin);
		load_count(self, 1);
		if (item % QUEUE_LOAD_LOOK_EVERY == 0)
			load_throttle();
	} while (!__atomic_load_n(&load_stop, __ATOMIC_RELAXED));
}

LOAD_INLINE void load_consume(queue_load_thread *self, queue_load_mode mode)
{
	for (uint32_t turns = 0;;) {
		bool last = __atomic_load_n(&load_drain, __ATOMIC_ACQUIRE);
		uint64_t begin = mode == QUEUE_LOAD_LATENCY ? bench_child_ticks() : 0;
		void *item = NULL;
		if (subject_pop(&load_queue, &self->own, &item)) {
			load_note(self, mode, begin);
			load_count(self, 1);
			load_take(self, item);
			turns = 0;
#ifdef SUBJECT_ENDLESS
			if (last)
				return;
#endif
		} else if (last) {
			return;
		} else {
			load_wait(&turns);
		}
	}
}

#if SUBJECT_BATCH
static void load_produce_batches(queue_load_thread *self)
{
	uint64_t item = load_first_item(self);
	do { /* at least once, as in load_produce */
		void *items[QUEUE_LOAD_BATCH];
		for (size_t i = 0; i < QUEUE_LOAD_BATCH; i++)
			items[i] = (void *)++item;
		uint32_t turns = 0;
		for (size_t done = 0, more; done < QUEUE_LOAD_BATCH; done += more) {
			more = subject_push_n(&load_queue, &self->own, items + done, QUEUE_LOAD_BATCH - done);
			if (more == 0)
				load_wait(&turns);
		}
		load_count(self, QUEUE_LOAD_BATCH);
		if (item % QUEUE_LOAD_LOOK_EVERY == 0)
			load_throttle();
	} while (!__atomic_load_n(&load_stop, __ATOMIC_RELAXED));
}

static void load_consume_batches(queue_load_thread *self)
{
	for (uint32_t turns = 0;;) {
		bool last = __atomic_load_n(&load_drain, __ATOMIC_ACQUIRE);
		void *items[QUEUE_LOAD_BATCH];
		size_t count = subject_pop_n(&load_queue, &self->own, items, QUEUE_LOAD_BATCH);
		for (size_t i = 0; i < count; i++)
			load_take(self, items[i]);
		if (count > 0) {
			load_count(self, count);
			turns = 0;
		} else if (last) {
			return;
		} else {
			load_wait(&turns);
		}
	}
}
#endif

static void load_work(queue_load_thread *self)
{
	bool producer = self->index < load_setup.producers;
#if SUBJECT_BATCH
	if (load_setup.batch) {
		(producer ? load_produce_batches : load_consume_batches)(self);
		return;
	}
#endif
	switch (load_setup.mode) { /* each inlined call has a constant mode, so its loop does not test the mode */
	case QUEUE_LOAD_PLAIN:
		if (producer)
			load_produce(self, QUEUE_LOAD_PLAIN);
		else
			load_consume(self, QUEUE_LOAD_PLAIN);
		break;
	case QUEUE_LOAD_LATENCY:
		if (producer)
			load_produce(self, QUEUE_LOAD_LATENCY);
		else
			load_consume(self, QUEUE_LOAD_LATENCY);
		break;
	case QUEUE_LOAD_GAPS:
		if (producer)
			load_produce(self, QUEUE_LOAD_GAPS);
		else
			load_consume(self, QUEUE_LOAD_GAPS);
		break;
	}
}

static void *load_thread_main(void *data)
{
	queue_load_thread *self = (queue_load_thread *)data;
	if (load_setup.pinned)
		bench_child_pin(self->index);
	subject_enter(&load_queue, &self->own, self->index);
	pthread_barrier_wait(&load_barrier);
	load_work(self);
	self->end_ns = bench_child_now_ns();
	return NULL;
}

/* ---- the main thread --------------------------------------------------------------------------------------------- */

static void *load_allocate(size_t size)
{
	void *made = malloc(size);
	if (!made)
		bench_child_fail("out of memory");
	memset(made, 0, size); /* page faults happen now, not during the run */
	return made;
}

static void load_start(uint32_t workers)
{
	for (uint32_t i = 0; i < workers; i++) {
		queue_load_thread *t = &load_threads[i];
		t->index = i;
		if (load_setup.mode == QUEUE_LOAD_LATENCY)
			t->times = (uint32_t *)load_allocate(QUEUE_LOAD_BUCKETS * sizeof *t->times);
		if (load_setup.mode == QUEUE_LOAD_GAPS)
			t->marks = (uint8_t *)load_allocate(load_mark_count);
		if (pthread_create(&t->thread, NULL, load_thread_main, t) != 0)
			bench_child_fail("cannot create thread %u", i);
	}
}

static void load_sleep(uint64_t nanoseconds)
{
	struct timespec time;
	time.tv_sec = (time_t)(nanoseconds / 1000000000u);
	time.tv_nsec = (long)(nanoseconds % 1000000000u);
	nanosleep(&time, NULL);
}

/* Signal handler that stops its thread for QUEUE_LOAD_STALL_NS, wherever in a push or pop it happens to be. */
static void load_fall_asleep(int number)
{
	(void)number;
	load_sleep(QUEUE_LOAD_STALL_NS);
}

/* Sleeps for the length of the run; in stall cases it stops a random thread every QUEUE_LOAD_STALL_EVERY_NS. */
static void load_pass_time(uint32_t workers, uint32_t seed)
{
	uint64_t end = bench_child_now_ns() + (uint64_t)(load_setup.seconds * 1e9), now;
	uint64_t random = seed + 1;
	while ((now = bench_child_now_ns()) < end) {
		if (!load_setup.stall) {
			load_sleep(end - now);
			continue;
		}
		load_sleep(QUEUE_LOAD_STALL_EVERY_NS);
		random = random * 6364136223846793005u + 1442695040888963407u; /* Knuth's MMIX generator */
		pthread_kill(load_threads[(random >> 33) % workers].thread, SIGUSR1);
	}
}

static void load_join(uint32_t first, uint32_t end)
{
	for (uint32_t i = first; i < end; i++)
		pthread_join(load_threads[i].thread, NULL);
}

/* Pops items that remain after all consumers have ended, by the main thread alone: some queues report "empty" to a
 * consumer while another consumer still returns an item. */
static void load_sweep(queue_load_thread *self)
{
#ifdef SUBJECT_ENDLESS
	(void)self;
#else
	void *item = NULL;
	subject_enter(&load_queue, &self->own, self->index);
	while (subject_pop(&load_queue, &self->own, &item)) {
		load_count(self, 1);
		load_take(self, item);
	}
#endif
}

#ifdef SUBJECT_ENDLESS

/* The subject is a counter of calls: `in` calls of push and `out` calls of pop were made. Ends the program with an
 * error if the counter is not their sum; returns half the sum, since a queue needs a push and a pop for each item. */
static uint64_t load_verify(uint64_t in, uint64_t out)
{
	if (!subject_verify(&load_queue, in, out))
		bench_child_fail("wrong result: the counter is not the number of calls");
	return (in + out) / 2;
}

#else

/* The sums of first + 1, first + 2, ... first + count, in closed form. */
static queue_load_sums load_sums_of_range(uint64_t first, uint64_t count)
{
	unsigned __int128 n = count, numbers = n * (n + 1) / 2, squares = n * (n + 1) * (2 * n + 1) / 6;
	queue_load_sums sums = {(uint64_t)(n * first + numbers),
	                        (uint64_t)(n * first * first + 2 * first * numbers + squares)};
	return sums;
}

static void load_add_sums(queue_load_sums *total, queue_load_sums more)
{
	total->sum += more.sum;
	total->squares += more.squares;
}

/* The threads counted `in` items pushed and `out` items popped. Ends the program with an error if the items popped are
 * not those pushed; returns their number. */
static uint64_t load_verify(uint64_t in, uint64_t out)
{
	queue_load_sums pushed = {0, 0}, popped = {0, 0};
	for (uint32_t i = 0; i < load_setup.producers; i++)
		load_add_sums(&pushed, load_sums_of_range(load_first_item(&load_threads[i]), load_threads[i].count));
	for (uint32_t i = load_setup.producers; i < load_setup.threads; i++)
		load_add_sums(&popped, load_threads[i].sums);
	if (in != out || pushed.sum != popped.sum || pushed.squares != popped.squares)
		bench_child_fail("wrong result: %llu items in, %llu out, sums %s", (unsigned long long)in,
		                 (unsigned long long)out, pushed.sum == popped.sum ? "equal" : "differ");
	if (in == 0)
		bench_child_fail("no item was pushed");
	return out;
}

#endif

/* Prints percentiles of the call times of threads [first, end), from their histograms: each is the middle of the bucket
 * that it falls into. */
static void load_report_times(const char *call, uint32_t first, uint32_t end, double ns_per_tick)
{
	static const struct {
		const char *name;
		double share;
	} points[] = {{"p50", 0.5}, {"p99", 0.99}, {"p99.9", 0.999}};
	uint64_t total = 0;
	for (uint32_t i = first; i < end; i++)
		for (uint32_t b = 0; b < QUEUE_LOAD_BUCKETS; b++)
			total += load_threads[i].times[b];
	for (size_t p = 0; p < sizeof points / sizeof *points; p++) {
		uint64_t below = 0;
		uint32_t bucket = 0;
		for (; bucket < QUEUE_LOAD_BUCKETS - 1; bucket++) {
			for (uint32_t i = first; i < end; i++)
				below += load_threads[i].times[bucket];
			if ((double)below >= points[p].share * (double)total)
				break;
		}
		char name[32];
		snprintf(name, sizeof name, "%s-%s", call, points[p].name);
		bench_child_metric(name, queue_load_bucket_middle(bucket) * ns_per_tick);
	}
}

/* Prints the longest time, after the first success, in which none of threads [first, end) had a success. */
static void load_report_gap(const char *name, uint32_t first, uint32_t end, uint64_t marks, double ns_per_tick)
{
	uint64_t longest = 0, current = 0;
	bool begun = false;
	for (uint64_t m = 0; m < marks; m++) {
		bool marked = false;
		for (uint32_t i = first; i < end; i++)
			marked |= load_threads[i].marks[m] != 0;
		begun |= marked;
		current = marked ? 0 : current + begun;
		longest = current > longest ? current : longest;
	}
	bench_child_metric(name, (double)(longest << QUEUE_LOAD_MARK_SHIFT) * ns_per_tick * 1e-6);
}

static void load_report(uint64_t items, double elapsed_ns, uint64_t stop_ticks, double ns_per_tick)
{
	uint32_t producers = load_setup.producers, workers = load_setup.threads - 1;
	if (load_setup.mode == QUEUE_LOAD_LATENCY) {
		load_report_times("push", 0, producers, ns_per_tick);
		load_report_times("pop", producers, workers, ns_per_tick);
	} else if (load_setup.mode == QUEUE_LOAD_GAPS) {
		uint64_t marks = (stop_ticks - load_start_ticks) >> QUEUE_LOAD_MARK_SHIFT;
		marks = marks < load_mark_count ? marks : load_mark_count;
		load_report_gap("push-gap", 0, producers, marks, ns_per_tick);
		load_report_gap("pop-gap", producers, workers, marks, ns_per_tick);
	}
	bench_child_metric("throughput", (double)items * 1e3 / elapsed_ns);
	bench_child_metric("items", (double)items);
}

static int queue_load_main(int argc, char **argv)
{
	bench_child child = bench_child_args(argc, argv);
	load_setup = queue_load_parse(&child);
	if (load_setup.batch && !SUBJECT_BATCH)
		return BENCH_CHILD_SKIP;
	uint32_t workers = load_setup.threads - 1;
	load_backlog = load_setup.mode == QUEUE_LOAD_GAPS ? QUEUE_LOAD_STALL_BACKLOG : QUEUE_LOAD_BACKLOG;
	load_mark_count = (uint64_t)(load_setup.seconds * 6e9) >> QUEUE_LOAD_MARK_SHIFT; /* enough if ticks are < 6 GHz */
	load_threads[workers].index = workers;
	struct sigaction action;
	memset(&action, 0, sizeof action);
	action.sa_handler = load_fall_asleep;
	action.sa_flags = SA_RESTART;
	sigaction(SIGUSR1, &action, NULL);
	subject_open(&load_queue, &load_setup);
	pthread_barrier_init(&load_barrier, NULL, workers + 1);
	load_start(workers);

	uint64_t start_ns = bench_child_now_ns(), end_ns = start_ns;
	load_start_ticks = bench_child_ticks(); /* the barrier publishes it to the threads */
	pthread_barrier_wait(&load_barrier);
	load_pass_time(workers, child.round);
	uint64_t stop_ticks = bench_child_ticks();
	double ns_per_tick = (double)(bench_child_now_ns() - start_ns) / (double)(stop_ticks - load_start_ticks);
	__atomic_store_n(&load_stop, true, __ATOMIC_RELAXED);
	load_join(0, load_setup.producers);
	__atomic_store_n(&load_drain, true, __ATOMIC_RELEASE);
	load_join(load_setup.producers, workers);
	for (uint32_t i = 0; i < workers; i++)
		end_ns = load_threads[i].end_ns > end_ns ? load_threads[i].end_ns : end_ns;
	load_sweep(&load_threads[workers]);
	uint32_t producers = load_setup.producers;
	uint64_t items = load_verify(load_sum_counts(0, producers), load_sum_counts(producers, load_setup.threads));
	load_report(items, (double)(end_ns - start_ns), stop_ticks, ns_per_tick);
	return 0;
}

#endif
