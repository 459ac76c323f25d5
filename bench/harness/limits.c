/* The program that measures the machine's limits (BENCH_LIMIT_... in bench.h). */
#include "bench/harness/bench.h"
#include "bench/harness/bench_child.h"
#include "jobs/job_sys.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#define ALIGNED _Alignas(128)
#define MAX_THREADS 64
#define PARKED_NS 120000 /* the sleeper sleeps at least this long before it is woken */
#define MAX_WAKES 20000

static uint64_t ns_from_now(double seconds)
{
	return bench_child_now_ns() + (uint64_t)(seconds * 1e9);
}

/* ---- atomics ----------------------------------------------------------------------------------------------------- */

/* The counter that all threads add to. Relaxed everywhere: it orders nothing, and is read after the threads were
 * joined. */
static ALIGNED _Atomic uint64_t shared_word;

#define ADDS_AT_ONCE 256

/* Adds 1 until end_ns; returns the number of additions. */
static uint64_t add(_Atomic uint64_t *word, uint64_t end_ns)
{
	uint64_t count = 0;
	do {
		for (int i = 0; i < ADDS_AT_ONCE; i++)
			atomic_fetch_add_explicit(word, 1, memory_order_relaxed);
		count += ADDS_AT_ONCE;
	} while (bench_child_now_ns() < end_ns);
	return count;
}

typedef struct adder {
	pthread_t thread;
	uint32_t cpu;
	uint64_t end_ns;
	uint64_t count;
} adder;

static void *adder_main(void *data)
{
	adder *self = data;
	bench_child_pin(self->cpu);
	self->count = add(&shared_word, self->end_ns);
	return NULL;
}

static void measure_atomics(double seconds)
{
	uint64_t begin = bench_child_now_ns();
	static ALIGNED _Atomic uint64_t own;
	uint64_t count = add(&own, ns_from_now(seconds));
	bench_child_metric(BENCH_LIMIT_UNCONTENDED, (double)(bench_child_now_ns() - begin) / (double)count);

	adder adders[MAX_THREADS];
	uint32_t threads = bench_child_cpu_count() < MAX_THREADS ? bench_child_cpu_count() : MAX_THREADS;
	begin = bench_child_now_ns();
	for (uint32_t i = 0; i < threads; i++) {
		adders[i] = (adder){.cpu = i, .end_ns = begin + (uint64_t)(seconds * 1e9)};
		if (pthread_create(&adders[i].thread, NULL, adder_main, &adders[i]) != 0)
			bench_child_fail("cannot create a thread");
	}
	count = 0;
	for (uint32_t i = 0; i < threads; i++) {
		pthread_join(adders[i].thread, NULL);
		count += adders[i].count;
	}
	bench_child_metric(BENCH_LIMIT_CONTENDED, (double)(bench_child_now_ns() - begin) / (double)count);
	if (atomic_load_explicit(&shared_word, memory_order_relaxed) != count)
		bench_child_fail("wrong result: the counter is not the number of additions");
}

static void measure_clock(void)
{
	enum { READS = 100000 };
	uint64_t begin = bench_child_now_ns(), sum = 0;
	for (int i = 0; i < READS; i++)
		sum += bench_child_ticks();
	__asm__ volatile("" ::"r"(sum)); /* the compiler must not drop the reads */
	bench_child_metric(BENCH_LIMIT_CLOCK, (double)(bench_child_now_ns() - begin) / READS);
}

/* ---- futex ------------------------------------------------------------------------------------------------------- */

static struct {
	/* 0: sleep, 1: wake up, 2: end. Release by the waker, pairs with the acquire in sleeper_main. */
	ALIGNED _Atomic uint32_t word;
	/* Number of times that the sleeper has gone to sleep. Release by it, pairs with the acquire in wait_until_slept. */
	ALIGNED _Atomic uint32_t slept;
	ALIGNED uint64_t awake_ns; /* when the sleeper last woke up; its next store to `slept` publishes it */
} bed;

static void *sleeper_main(void *unused)
{
	(void)unused;
	bench_child_pin(1);
	for (uint32_t slept = 1;; slept++) {
		atomic_store_explicit(&bed.slept, slept, memory_order_release);
		uint32_t word;
		while ((word = atomic_load_explicit(&bed.word, memory_order_acquire)) == 0)
			job_sys_futex_wait(&bed.word, 0);
		bed.awake_ns = bench_child_now_ns();
		if (word == 2)
			return NULL;
		atomic_store_explicit(&bed.word, 0, memory_order_relaxed); /* relaxed: the next store to `slept` publishes it */
	}
}

static void spin_for(uint64_t ns)
{
	for (uint64_t end = bench_child_now_ns() + ns; bench_child_now_ns() < end;)
		job_sys_pause();
}

static void wait_until_slept(uint32_t times)
{
	uint32_t turns = 0;
	while (atomic_load_explicit(&bed.slept, memory_order_acquire) < times)
		job_sys_relax(&turns);
}

static int compare_doubles(const void *a, const void *b)
{
	double x = *(const double *)a, y = *(const double *)b;
	return (x > y) - (x < y);
}

typedef struct waker {
	double seconds;
	uint32_t count;
	double wakes[MAX_WAKES];
} waker;

static void *waker_main(void *data)
{
	waker *self = data;
	bench_child_pin(0);
	uint64_t end = ns_from_now(self->seconds);
	while (self->count < MAX_WAKES && (self->count == 0 || bench_child_now_ns() < end)) {
		wait_until_slept(self->count + 1);
		spin_for(PARKED_NS);
		uint64_t begin = bench_child_now_ns();
		atomic_store_explicit(&bed.word, 1, memory_order_release);
		job_sys_futex_wake_one(&bed.word);
		wait_until_slept(self->count + 2);
		self->wakes[self->count++] = (double)(bed.awake_ns - begin);
	}
	return NULL;
}

static void measure_wake(double seconds)
{
	static waker work;
	work.seconds = seconds;
	pthread_t sleeper, other;
	if (pthread_create(&sleeper, NULL, sleeper_main, NULL) != 0 || pthread_create(&other, NULL, waker_main, &work) != 0)
		bench_child_fail("cannot create a thread");
	pthread_join(other, NULL);
	atomic_store_explicit(&bed.word, 2, memory_order_release);
	job_sys_futex_wake_one(&bed.word);
	pthread_join(sleeper, NULL);
	qsort(work.wakes, work.count, sizeof *work.wakes, compare_doubles);
	bench_child_metric(BENCH_LIMIT_WAKE, work.wakes[work.count / 2]);
	bench_child_metric(BENCH_LIMIT_WAKE_P99, work.wakes[work.count * 99 / 100]);
}

int main(int argc, char **argv)
{
	bench_child child = bench_child_args(argc, argv);
	measure_clock();
	measure_atomics(child.seconds * 0.2);
	measure_wake(child.seconds * 0.6);
	return 0;
}
