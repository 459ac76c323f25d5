/* The suite `queue` of stilb-bench: compares concurrent queues of Stilb and of other libraries. queue_load.h describes
 * the load under which each of them is measured. */
#include "bench/queue/bench_queue.h"

#define COUNT(array) (sizeof(array) / sizeof *(array))

/* Bits of bench_subject.abilities and bench_case.needs: the kinds of load that a queue can take. */
enum {
	SINGLE = 1,     /* push and pop of one item */
	BATCH = 2,      /* push and pop of sixteen items in one call */
	ONE_TO_ONE = 4, /* one producer, one consumer */
	MANY = 8        /* several producers and several consumers */
};

static const bench_subject subjects[] = {
	{"stilb-low-lock", "stilb-bench-queue-own", NULL,
     "Stilb's default queue: one lock for producers, one for consumers, reused segments",
     SINGLE | BATCH | ONE_TO_ONE | MANY, false},
	{"stilb-lock-free", "stilb-bench-queue-own", NULL, "Stilb's queue without locks",
     SINGLE | BATCH | ONE_TO_ONE | MANY, false},
	{"stilb-spsc", "stilb-bench-queue-spsc", NULL, "Stilb's queue for one producer and one consumer",
     SINGLE | ONE_TO_ONE, false},
	{"sutter", "stilb-bench-queue-own", NULL,
     "the two-lock queue of Herb Sutter's article (Dr. Dobb's Journal, November 2008)", SINGLE | ONE_TO_ONE | MANY,
     false},
	{"mutex", "stilb-bench-queue-own", NULL, "a linked list under one pthread mutex", SINGLE | ONE_TO_ONE | MANY,
     false},
	{"ck_fifo", "stilb-bench-queue-ck_fifo", "libck-dev",
     "Concurrency Kit; nodes are recycled instead of allocated, an advantage over the others",
     SINGLE | ONE_TO_ONE | MANY, false},
	{"boost", "stilb-bench-queue-boost", "libboost-dev", "boost::lockfree::queue, unbounded",
     SINGLE | ONE_TO_ONE | MANY, false},
	{"tbb", "stilb-bench-queue-tbb", "libtbb-dev",
     "tbb::concurrent_queue; its library part with Debian's compiler flags", SINGLE | ONE_TO_ONE | MANY, false},
	{"moodycamel-implicit", "stilb-bench-queue-moodycamel", "libconcurrentqueue-dev",
     "moodycamel::ConcurrentQueue: one queue for each producer, no FIFO order across producers",
     SINGLE | ONE_TO_ONE | MANY, false},
	{"moodycamel-tokens", "stilb-bench-queue-moodycamel-tokens", "libconcurrentqueue-dev",
     "moodycamel::ConcurrentQueue with a token for each thread", SINGLE | ONE_TO_ONE | MANY, false},
	{"moodycamel-bulk", "stilb-bench-queue-moodycamel-tokens", "libconcurrentqueue-dev",
     "moodycamel::ConcurrentQueue with tokens and bulk calls", BATCH | ONE_TO_ONE | MANY, false},
	{"vyukov", "stilb-bench-queue-vyukov", NULL, "Vyukov's bounded queue of 4096 items", SINGLE | ONE_TO_ONE | MANY,
     false},
	{"ck_ring", "stilb-bench-queue-ck_ring", "libck-dev",
     "Concurrency Kit's ring of 4096 items; with more threads than CPUs it may not end, and is then killed",
     SINGLE | ONE_TO_ONE | MANY, false},
	{"counter", "stilb-bench-queue-counter", NULL,
     "no queue: each call is an atomic add of one shared number; shows how steady the machine is",
     SINGLE | ONE_TO_ONE | MANY, true},
};

static const bench_metric throughput[] = {
	{"throughput", "Mops/s", false, BENCH_LIMIT_CONTENDED},
	{BENCH_METRIC_ITEMS, "items", false, NULL},
};

static const bench_metric latency[] = {
	{"push-p50", "ns", true, BENCH_LIMIT_UNCONTENDED},      {"push-p99", "ns", true, BENCH_LIMIT_UNCONTENDED},
	{"push-p99.9", "ns", true, BENCH_LIMIT_UNCONTENDED},    {"pop-p50", "ns", true, BENCH_LIMIT_UNCONTENDED},
	{"pop-p99", "ns", true, BENCH_LIMIT_UNCONTENDED},       {"pop-p99.9", "ns", true, BENCH_LIMIT_UNCONTENDED},
	{"throughput", "Mops/s", false, BENCH_LIMIT_CONTENDED}, {BENCH_METRIC_ITEMS, "items", false, NULL},
};

static const bench_metric gaps[] = {
	{"push-gap", "ms", true, NULL},
	{"pop-gap", "ms", true, NULL},
	{"throughput", "Mops/s", false, BENCH_LIMIT_CONTENDED},
	{BENCH_METRIC_ITEMS, "items", false, NULL},
};

#define STALL_LENGTH 3.0 /* times --seconds (0.5 s): some seventy stalls in a run, one every 22 ms */

#define THROUGHPUT(name, title, needs)                                                                                 \
	{                                                                                                                  \
		name, title, throughput, COUNT(throughput), needs, 1.0                                                         \
	}
static const bench_case cases[] = {
	THROUGHPUT("1P1C", "1 producer, 1 consumer", SINGLE | ONE_TO_ONE),
	THROUGHPUT("2P2C", "2 producers, 2 consumers", SINGLE | MANY),
	THROUGHPUT("4P4C", "4 producers, 4 consumers", SINGLE | MANY),
	THROUGHPUT("8P8C", "8 producers, 8 consumers", SINGLE | MANY),
	THROUGHPUT("pinned-1P1C", "1 producer, 1 consumer, threads pinned to CPUs", SINGLE | ONE_TO_ONE),
	THROUGHPUT("pinned-2P2C", "2 producers, 2 consumers, threads pinned to CPUs", SINGLE | MANY),
	THROUGHPUT("batch16-1P1C", "16 items in each call, 1 producer, 1 consumer", BATCH | ONE_TO_ONE),
	THROUGHPUT("batch16-2P2C", "16 items in each call, 2 producers, 2 consumers", BATCH | MANY),
	THROUGHPUT("batch16-4P4C", "16 items in each call, 4 producers, 4 consumers", BATCH | MANY),
	THROUGHPUT("batch16-8P8C", "16 items in each call, 8 producers, 8 consumers", BATCH | MANY),
	THROUGHPUT("batch16-pinned-1P1C", "16 items in each call, 1 producer, 1 consumer, threads pinned to CPUs",
               BATCH | ONE_TO_ONE),
	THROUGHPUT("batch16-pinned-2P2C", "16 items in each call, 2 producers, 2 consumers, threads pinned to CPUs",
               BATCH | MANY),
	{"latency-4P4C", "time of each successful call, reading the clock included", latency, COUNT(latency), SINGLE | MANY,
     1.0},
	{"calm-4P4C", "longest time without a successful push, or pop, by any thread; all yield every 256 calls", gaps,
     COUNT(gaps), SINGLE | MANY, 1.0},
	{"stall-4P4C", "longest time without a successful push, or pop, while every 22 ms a thread is stopped for 20 ms",
     gaps, COUNT(gaps), SINGLE | MANY, STALL_LENGTH},
};

static const char *const single_cases[] = {"1P1C", "2P2C", "4P4C", "8P8C", "pinned-1P1C", "pinned-2P2C", NULL};
static const char *const batch_cases[] = {
	"batch16-1P1C", "batch16-2P2C", "batch16-4P4C", "batch16-8P8C", "batch16-pinned-1P1C", "batch16-pinned-2P2C", NULL};
static const char *const latency_cases[] = {"latency-4P4C", NULL};
static const char *const gap_cases[] = {"calm-4P4C", "stall-4P4C", NULL};

static const bench_panel panels[] = {
	{"single items", single_cases, "throughput", true},
	{"batches of 16", batch_cases, "throughput", true},
	{"latency of push with 4 producers and 4 consumers, 99.9th percentile", latency_cases, "push-p99.9", true},
	{"latency of pop with 4 producers and 4 consumers, 99.9th percentile", latency_cases, "pop-p99.9", true},
	{"longest time without a successful push", gap_cases, "push-gap", false},
	{"longest time without a successful pop", gap_cases, "pop-gap", false},
};

const bench_suite bench_queue_suite = {.name = "queue",
                                       .help = "concurrent queues: throughput, latency, stalls",
                                       .subjects = subjects,
                                       .subject_count = COUNT(subjects),
                                       .cases = cases,
                                       .case_count = COUNT(cases),
                                       .panels = panels,
                                       .panel_count = COUNT(panels),
                                       .goals = bench_queue_goals};
