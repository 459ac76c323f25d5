/* The suite `queue`: which queues, under which loads. queue_load.h says what a run is. */
#include "bench/queue/bench_queue.h"

#define COUNT(array) (sizeof(array) / sizeof *(array))

/* What a subject can, and a case needs. */
enum {
	SINGLE = 1,     /* one item a call */
	BATCH = 2,      /* sixteen */
	ONE_TO_ONE = 4, /* one producer, one consumer */
	MANY = 8        /* more of both */
};

static const bench_subject subjects[] = {
	{"stilb-low-lock", "stilb-bench-queue-own", NULL, NULL, SINGLE | BATCH | ONE_TO_ONE | MANY, false},
	{"stilb-lock-free", "stilb-bench-queue-own", NULL, NULL, SINGLE | BATCH | ONE_TO_ONE | MANY, false},
	{"stilb-spsc", "stilb-bench-queue-spsc", NULL, "one producer and one consumer only", SINGLE | ONE_TO_ONE, false},
	{"sutter", "stilb-bench-queue-own", NULL, "the queue of the article (Dr. Dobb's Journal, November 2008)",
     SINGLE | ONE_TO_ONE | MANY, false},
	{"mutex", "stilb-bench-queue-own", NULL, "a list under one pthread mutex", SINGLE | ONE_TO_ONE | MANY, false},
	{"ck_fifo", "stilb-bench-queue-ck_fifo", "libck-dev", "its nodes are recycled without malloc, which flatters it",
     SINGLE | ONE_TO_ONE | MANY, false},
	{"boost", "stilb-bench-queue-boost", "libboost-dev", "boost::lockfree::queue", SINGLE | ONE_TO_ONE | MANY, false},
	{"tbb", "stilb-bench-queue-tbb", "libtbb-dev", "tbb::concurrent_queue; the part in its library as Debian built it",
     SINGLE | ONE_TO_ONE | MANY, false},
	{"moodycamel-implicit", "stilb-bench-queue-moodycamel", "libconcurrentqueue-dev",
     "a queue for each producer: no FIFO across producers", SINGLE | ONE_TO_ONE | MANY, false},
	{"moodycamel-tokens", "stilb-bench-queue-moodycamel-tokens", "libconcurrentqueue-dev",
     "the same with a token for each thread", SINGLE | ONE_TO_ONE | MANY, false},
	{"moodycamel-bulk", "stilb-bench-queue-moodycamel-tokens", "libconcurrentqueue-dev",
     "the same with tokens and its bulk calls", BATCH | ONE_TO_ONE | MANY, false},
	{"vyukov", "stilb-bench-queue-vyukov", NULL, "bounded: 4096 items", SINGLE | ONE_TO_ONE | MANY, false},
	{"ck_ring", "stilb-bench-queue-ck_ring", "libck-dev",
     "bounded: 4096 items; can take minutes when threads outnumber CPUs, then it is killed", SINGLE | ONE_TO_ONE | MANY,
     false},
	{"counter", "stilb-bench-queue-counter", NULL,
     "no queue: each call adds one to a number that all share; how steady the machine is", SINGLE | ONE_TO_ONE | MANY,
     true},
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

#define STALL_LENGTH 3.0 /* a stall every 22 ms: some seventy of them in a run */

#define THROUGHPUT(name, title, needs)                                                                                 \
	{                                                                                                                  \
		name, title, throughput, COUNT(throughput), needs, 1.0                                                         \
	}
static const bench_case cases[] = {
	THROUGHPUT("1P1C", "1 producer, 1 consumer", SINGLE | ONE_TO_ONE),
	THROUGHPUT("2P2C", "2 producers, 2 consumers", SINGLE | MANY),
	THROUGHPUT("4P4C", "4 producers, 4 consumers", SINGLE | MANY),
	THROUGHPUT("8P8C", "8 producers, 8 consumers", SINGLE | MANY),
	THROUGHPUT("pinned-1P1C", "1 producer, 1 consumer, each on its CPU", SINGLE | ONE_TO_ONE),
	THROUGHPUT("pinned-2P2C", "2 producers, 2 consumers, both kinds spread over the CPUs", SINGLE | MANY),
	THROUGHPUT("batch16-1P1C", "16 items a call, 1 producer, 1 consumer", BATCH | ONE_TO_ONE),
	THROUGHPUT("batch16-2P2C", "16 items a call, 2 producers, 2 consumers", BATCH | MANY),
	THROUGHPUT("batch16-4P4C", "16 items a call, 4 producers, 4 consumers", BATCH | MANY),
	THROUGHPUT("batch16-8P8C", "16 items a call, 8 producers, 8 consumers", BATCH | MANY),
	THROUGHPUT("batch16-pinned-1P1C", "the same, each on its CPU", BATCH | ONE_TO_ONE),
	THROUGHPUT("batch16-pinned-2P2C", "the same, both kinds spread over the CPUs", BATCH | MANY),
	{"latency-4P4C", "time of a call that succeeds, back to back, the clock's own time included", latency,
     COUNT(latency), SINGLE | MANY, 1.0},
	{"calm-4P4C", "longest time in which no thread completed a push, a pop; all yield every 256 calls", gaps,
     COUNT(gaps), SINGLE | MANY, 1.0},
	{"stall-4P4C", "the same while every 22 ms one thread sleeps 20 ms at any instruction", gaps, COUNT(gaps),
     SINGLE | MANY, STALL_LENGTH},
};

static const char *const single_cases[] = {"1P1C", "2P2C", "4P4C", "8P8C", "pinned-1P1C", "pinned-2P2C", NULL};
static const char *const batch_cases[] = {
	"batch16-1P1C", "batch16-2P2C", "batch16-4P4C", "batch16-8P8C", "batch16-pinned-1P1C", "batch16-pinned-2P2C", NULL};
static const char *const latency_cases[] = {"latency-4P4C", NULL};
static const char *const gap_cases[] = {"calm-4P4C", "stall-4P4C", NULL};

static const bench_panel panels[] = {
	{"single items", single_cases, "throughput", true},
	{"batches of 16", batch_cases, "throughput", true},
	{"push at 4P4C, 999 of 1000 calls take less", latency_cases, "push-p99.9", true},
	{"pop at 4P4C, 999 of 1000 calls take less", latency_cases, "pop-p99.9", true},
	{"longest time without a push", gap_cases, "push-gap", false},
	{"longest time without a pop", gap_cases, "pop-gap", false},
};

const bench_suite bench_queue_suite = {.name = "queue",
                                       .help = "queues of many producers and many consumers",
                                       .subjects = subjects,
                                       .subject_count = COUNT(subjects),
                                       .cases = cases,
                                       .case_count = COUNT(cases),
                                       .panels = panels,
                                       .panel_count = COUNT(panels),
                                       .goals = bench_queue_goals};
