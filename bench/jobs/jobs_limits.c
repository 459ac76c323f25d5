/* References of the suite `jobs`, with which job systems are compared: the serial loop, one futex wake, one number
 * handed from one thread to another. */
#include "bench/harness/bench_child.h"
#include "bench/jobs/jobs_subject.h"

#include <linux/futex.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stddef.h>
#include <sys/syscall.h>
#include <unistd.h>

static bool serial_open(uint32_t threads, bool steals)
{
	(void)threads, (void)steals;
	return true;
}

static void serial_close(void)
{
}

static void serial_spawn(jobs_fn *fn, char *data, uint32_t count)
{
	for (uint32_t i = 0; i < count; i++)
		fn(data + i, 0);
}

static void serial_loop(jobs_range_fn *fn, void *context, uint32_t count)
{
	fn(0, count, 0, context);
}

static void serial_range(jobs_range_64_fn *fn, void *context, uint64_t count)
{
	fn(0, count, 0, context);
}

static void serial_tiles(jobs_tile_fn *fn, void *context, uint32_t width, uint32_t height)
{
	fn(0, width, 0, height, 0, context);
}

static double serial_reduce(jobs_fold_fn *fn, void *context, uint64_t count)
{
	double sum = 0.0;
	fn(0, count, &sum, context);
	return sum;
}

static int by_key(const void *a, const void *b, void *context)
{
	const jobs_element *left = a, *right = b;
	(void)context;
	return (left->key > right->key) - (left->key < right->key);
}

static void serial_sort(jobs_element *elements, uint32_t count)
{
	qsort_r(elements, count, sizeof *elements, by_key, NULL);
}

static uint64_t serial_fib(uint32_t n)
{
	return n < 2 ? n : serial_fib(n - 1) + serial_fib(n - 2);
}

/* The nodes are numbered in an order in which they may run. */
static struct {
	jobs_fn *fn;
	char *data;
	uint32_t count;
} serial_graph;

static void serial_graph_run(void)
{
	serial_spawn(serial_graph.fn, serial_graph.data, serial_graph.count);
}

static void serial_graph_make(jobs_fn *fn, char *data, uint32_t count, const uint32_t (*edge)[2], uint32_t edges)
{
	(void)edge, (void)edges;
	serial_graph.fn = fn;
	serial_graph.data = data;
	serial_graph.count = count;
	serial_graph_run();
}

static const jobs_subject serial = {.name = "serial",
                                    .open = serial_open,
                                    .close = serial_close,
                                    .spawn = serial_spawn,
                                    .array = serial_loop,
                                    .join = serial_loop,
                                    .loop = serial_loop,
                                    .range = serial_range,
                                    .tiles = serial_tiles,
                                    .reduce = serial_reduce,
                                    .sort = serial_sort,
                                    .fib = serial_fib,
                                    .graph_make = serial_graph_make,
                                    .graph_run = serial_graph_run};
static const jobs_subject ideal = {.name = "ideal",
                                   .ideal = true,
                                   .open = serial_open,
                                   .close = serial_close,
                                   .join = serial_loop,
                                   .loop = serial_loop,
                                   .range = serial_range};

/* A second thread that waits for a number to change, asleep on a futex or spinning, and then runs one job. */
static struct {
	/* Odd: a job is waiting or runs. Release in hand_give, pairs with the acquire in hand_main; release there, pairs
	 * with the acquire in hand_wait. */
	_Alignas(128) _Atomic uint32_t number;
	jobs_fn *fn;
	void *data;
	_Alignas(128) uint64_t seen;
	bool spin;
	_Atomic bool stop; /* relaxed: the release of `number` publishes it */
	pthread_t thread;
} hand;

static void *hand_main(void *unused)
{
	(void)unused;
	for (;;) {
		uint32_t number;
		while (!((number = atomic_load_explicit(&hand.number, memory_order_acquire)) & 1)) /* pairs with hand_give */
			if (!hand.spin)
				syscall(SYS_futex, &hand.number, FUTEX_WAIT_PRIVATE, number, NULL, NULL, 0);
		hand.seen = bench_child_now_ns();
		if (atomic_load_explicit(&hand.stop, memory_order_relaxed))
			return NULL;
		hand.fn(hand.data, 0);
		atomic_store_explicit(&hand.number, number + 1, memory_order_release); /* pairs with hand_wait */
	}
}

static bool hand_open(uint32_t threads, bool spin)
{
	hand.spin = spin;
	return threads == 2 && pthread_create(&hand.thread, NULL, hand_main, NULL) == 0;
}

static bool futex_open(uint32_t threads, bool steals)
{
	(void)steals;
	return hand_open(threads, false);
}

static bool counter_open(uint32_t threads, bool steals)
{
	(void)steals;
	return hand_open(threads, true);
}

static void hand_give(void)
{
	atomic_fetch_add_explicit(&hand.number, 1, memory_order_release); /* pairs with the acquire in hand_main */
	if (!hand.spin)
		syscall(SYS_futex, &hand.number, FUTEX_WAKE_PRIVATE, 1, NULL, NULL, 0);
}

static void hand_submit(jobs_fn *fn, void *data)
{
	hand.fn = fn;
	hand.data = data;
	hand_give();
}

static void hand_wait(void)
{
	while (atomic_load_explicit(&hand.number, memory_order_acquire) & 1) /* pairs with the release in hand_main */
		;
}

static uint64_t hand_seen(void)
{
	return hand.seen;
}

static void hand_close(void)
{
	atomic_store_explicit(&hand.stop, true, memory_order_relaxed);
	hand_give();
	pthread_join(hand.thread, NULL);
}

static const jobs_subject futex = {
	.name = "futex", .open = futex_open, .close = hand_close, .submit = hand_submit, .wait = hand_wait};
static const jobs_subject counter = {.name = "counter",
                                     .open = counter_open,
                                     .close = hand_close,
                                     .submit = hand_submit,
                                     .wait = hand_wait,
                                     .stolen_at = hand_seen};
const jobs_subject *const jobs_subjects[] = {&serial, &ideal, &futex, &counter, NULL};
