/* jobs_cases: the cases (workloads) of the suite `jobs`; included by stilb-bench and by the programs that it starts,
 * which measure the subjects (job systems). */
#ifndef JOBS_CASES_H
#define JOBS_CASES_H

#include <stdbool.h>
#include <stdint.h>

/* The kinds of measurement. */
typedef enum jobs_kind {
	JOBS_SPAWN,   /* jobs a second, for empty jobs submitted one by one from one thread */
	JOBS_ARRAY,   /* the same for empty jobs submitted in one call */
	JOBS_BATCH,   /* the same for empty jobs submitted in one call, each of them a job of its own */
	JOBS_OUTSIDE, /* the same for empty jobs submitted one by one by threads that do not belong to the job system */
	JOBS_JOIN,    /* time of a fork-join of a few chunks of 1 us */
	JOBS_LOOP,    /* time of a loop over 20,000 items of 200 ns */
	JOBS_LATE,    /* time of a loop of few long slices, after 1,000 loops of short ones and a pause */
	JOBS_FIB,     /* time of fib(20): 10,945 jobs that submit jobs and wait for them */
	JOBS_WAKE,    /* one job for a sleeping worker: time until it starts, and time that submit takes */
	JOBS_STEAL,   /* one job for a worker that looks for work: time until it is taken, if known, and until it starts */
	JOBS_GRAPH,   /* time of a run of a graph of jobs that has been built before */
	JOBS_RANGE,   /* JOBS_LOOP with 64-bit indices */
	JOBS_TILES,   /* time to transpose a square matrix of floats in tiles */
	JOBS_REDUCE,  /* time to add floats up */
	JOBS_SORT,    /* time to sort elements of 8 bytes by a 32-bit key */
	JOBS_IDLE     /* CPU time that the job system's threads use after all work is done */
} jobs_kind;

/* The graphs of JOBS_GRAPH. */
typedef enum jobs_graph_shape {
	JOBS_CHAIN, /* each node after the one before */
	JOBS_FAN,   /* one node, then all but two at the same time, then one */
	JOBS_LAYERS /* layers of 100 nodes, each node after three random ones of the layer before */
} jobs_graph_shape;

typedef struct jobs_case {
	const char *name;
	jobs_kind kind;
	/* Of the job system, the caller included; JOBS_OUTSIDE: without the outside threads; 0: one for each CPU. */
	uint32_t threads;
	uint32_t count;   /* jobs, chunks, items, nodes, rows, floats or elements; JOBS_OUTSIDE: for each outside thread */
	uint32_t outside; /* number of outside threads */
	jobs_graph_shape shape;
	double microseconds; /* of work in each job, chunk, item or node */
	uint32_t pause_us;   /* the caller sleeps this long before each turn */
	bool other;          /* JOBS_LATE: the short slices are another function's */
	bool phase;          /* in a phase, which keeps threads awake (jobs_subject.phase_begin), if the subject has it */
	bool ordered;        /* of JOBS_SORT: the elements are in order already */
	bool pinned;         /* thread i of the process is pinned to CPU i modulo their number; else left to the library */
} jobs_case;

/* X(name, title, KIND, more fields of jobs_case...) */
#define JOBS_CASES(X)                                                                                                  \
	X("spawn-1", "100,000 empty jobs one by one, 1 thread", SPAWN, .threads = 1, .count = 100000)                      \
	X("spawn", "100,000 empty jobs one by one, 2 threads", SPAWN, .threads = 2, .count = 100000)                       \
	X("spawn-pinned", "100,000 empty jobs one by one, 2 threads, pinned", SPAWN, .threads = 2, .count = 100000,        \
	  .pinned = true)                                                                                                  \
	X("batch", "100,000 empty jobs as one batch, 2 threads", BATCH, .threads = 2, .count = 100000)                     \
	X("batch-pinned", "100,000 empty jobs as one batch, 2 threads, pinned", BATCH, .threads = 2, .count = 100000,      \
	  .pinned = true)                                                                                                  \
	X("array-1", "100,000 empty jobs as one array, 1 thread", ARRAY, .threads = 1, .count = 100000)                    \
	X("array", "100,000 empty jobs as one array, 2 threads", ARRAY, .threads = 2, .count = 100000)                     \
	X("array-pinned", "100,000 empty jobs as one array, 2 threads, pinned", ARRAY, .threads = 2, .count = 100000,      \
	  .pinned = true)                                                                                                  \
	X("outside", "50,000 empty jobs one by one from a thread outside of the pool, 1 worker", OUTSIDE, .threads = 2,    \
	  .count = 50000, .outside = 1)                                                                                    \
	X("outside-4", "50,000 empty jobs one by one from 4 threads outside of the pool, 2 workers", OUTSIDE,              \
	  .threads = 3, .count = 12500, .outside = 4)                                                                      \
	X("join2", "fork-join of 2 x 1 us, 2 threads", JOIN, .threads = 2, .count = 2, .microseconds = 1)                  \
	X("join8", "fork-join of 8 x 1 us, 2 threads", JOIN, .threads = 2, .count = 8, .microseconds = 1)                  \
	X("join64", "fork-join of 64 x 1 us, 2 threads", JOIN, .threads = 2, .count = 64, .microseconds = 1)               \
	X("join2-pinned", "fork-join of 2 x 1 us, 2 threads, pinned", JOIN, .threads = 2, .count = 2, .microseconds = 1,   \
	  .pinned = true)                                                                                                  \
	X("join8-pinned", "fork-join of 8 x 1 us, 2 threads, pinned", JOIN, .threads = 2, .count = 8, .microseconds = 1,   \
	  .pinned = true)                                                                                                  \
	X("join64-pinned", "fork-join of 64 x 1 us, 2 threads, pinned", JOIN, .threads = 2, .count = 64,                   \
	  .microseconds = 1, .pinned = true)                                                                               \
	X("join8-phase", "fork-join of 8 x 1 us, 2 threads, in a phase", JOIN, .threads = 2, .count = 8,                   \
	  .microseconds = 1, .phase = true)                                                                                \
	X("join8-idle", "fork-join of 8 x 1 us after 2 ms of idleness, 2 threads", JOIN, .threads = 2, .count = 8,         \
	  .microseconds = 1, .pause_us = 2000)                                                                             \
	X("join64-idle", "fork-join of 64 x 1 us after 2 ms of idleness, 2 threads", JOIN, .threads = 2, .count = 64,      \
	  .microseconds = 1, .pause_us = 2000)                                                                             \
	X("join8-idle-phase", "fork-join of 8 x 1 us after 2 ms of idleness, in a phase", JOIN, .threads = 2, .count = 8,  \
	  .microseconds = 1, .pause_us = 2000, .phase = true)                                                              \
	X("join64-idle-phase", "fork-join of 64 x 1 us after 2 ms of idleness, in a phase", JOIN, .threads = 2,            \
	  .count = 64, .microseconds = 1, .pause_us = 2000, .phase = true)                                                 \
	X("loop-1", "loop over 20,000 items of 200 ns, 1 thread", LOOP, .threads = 1, .count = 20000, .microseconds = 0.2) \
	X("loop-2", "loop over 20,000 items of 200 ns, 2 threads", LOOP, .threads = 2, .count = 20000,                     \
	  .microseconds = 0.2)                                                                                             \
	X("loop-4", "loop over 20,000 items of 200 ns, 4 threads", LOOP, .threads = 4, .count = 20000,                     \
	  .microseconds = 0.2)                                                                                             \
	X("loop-8", "loop over 20,000 items of 200 ns, 8 threads", LOOP, .threads = 8, .count = 20000,                     \
	  .microseconds = 0.2)                                                                                             \
	X("late-2", "2 slices of 50 ms after 1,000 short loops of the function and 5 ms of sleep, 2 threads", LATE,        \
	  .threads = 2, .count = 2, .microseconds = 50000, .pause_us = 5000)                                               \
	X("late-8", "8 slices of 10 ms after the same, 2 threads", LATE, .threads = 2, .count = 8, .microseconds = 10000,  \
	  .pause_us = 5000)                                                                                                \
	X("late-2-other", "2 slices of 50 ms after 1,000 short loops of another function, 2 threads", LATE, .threads = 2,  \
	  .count = 2, .microseconds = 50000, .pause_us = 5000, .other = true)                                              \
	X("late-8-other", "8 slices of 10 ms after the same, 2 threads", LATE, .threads = 2, .count = 8,                   \
	  .microseconds = 10000, .pause_us = 5000, .other = true)                                                          \
	X("fib-1", "fib(20), each call a job, 1 thread", FIB, .threads = 1)                                                \
	X("fib", "fib(20), each call a job, 2 threads", FIB, .threads = 2)                                                 \
	X("graph-chain", "graph of 10,000 empty nodes in a chain, 2 threads", GRAPH, .threads = 2, .count = 10000,         \
	  .shape = JOBS_CHAIN)                                                                                             \
	X("graph-fan", "graph of 10,000 empty nodes, all but two at once, 2 threads", GRAPH, .threads = 2, .count = 10000, \
	  .shape = JOBS_FAN)                                                                                               \
	X("graph-1", "graph of 100 layers of 100 empty nodes, 1 thread", GRAPH, .threads = 1, .count = 10000,              \
	  .shape = JOBS_LAYERS)                                                                                            \
	X("graph", "graph of 100 layers of 100 empty nodes, 2 threads", GRAPH, .threads = 2, .count = 10000,               \
	  .shape = JOBS_LAYERS)                                                                                            \
	X("graph-us", "graph of 100 layers of 100 nodes of 1 us, 2 threads", GRAPH, .threads = 2, .count = 10000,          \
	  .shape = JOBS_LAYERS, .microseconds = 1)                                                                         \
	X("range", "loop over 20,000 items of 200 ns with 64-bit indices, 2 threads", RANGE, .threads = 2, .count = 20000, \
	  .microseconds = 0.2)                                                                                             \
	X("tiles-1", "transposition of 2,000 x 2,000 floats in tiles, 1 thread", TILES, .threads = 1, .count = 2000)       \
	X("tiles", "transposition of 2,000 x 2,000 floats in tiles, 2 threads", TILES, .threads = 2, .count = 2000)        \
	X("reduce-1", "sum of 4,000,000 floats, 1 thread", REDUCE, .threads = 1, .count = 4000000)                         \
	X("reduce", "sum of 4,000,000 floats, 2 threads", REDUCE, .threads = 2, .count = 4000000)                          \
	X("sort-1", "sort of 1,000,000 random elements, 1 thread", SORT, .threads = 1, .count = 1000000)                   \
	X("sort", "sort of 1,000,000 random elements, 2 threads", SORT, .threads = 2, .count = 1000000)                    \
	X("sort-10000", "sort of 10,000 random elements, 2 threads", SORT, .threads = 2, .count = 10000)                   \
	X("sort-ordered", "sort of 1,000,000 elements in order, 2 threads", SORT, .threads = 2, .count = 1000000,          \
	  .ordered = true)                                                                                                 \
	X("wake", "one job for a sleeping worker after 2 ms of idleness", WAKE, .threads = 2, .pause_us = 2000)            \
	X("wake-pinned", "one job for a sleeping worker after 2 ms of idleness, pinned", WAKE, .threads = 2,               \
	  .pause_us = 2000, .pinned = true)                                                                                \
	X("steal", "one job for a worker that is looking for work", STEAL, .threads = 2, .phase = true)                    \
	X("steal-pinned", "one job for a worker that is looking for work, pinned", STEAL, .threads = 2, .phase = true,     \
	  .pinned = true)                                                                                                  \
	X("spawn-all", "100,000 empty jobs one by one, a thread for each CPU", SPAWN, .count = 100000)                     \
	X("join64-all", "fork-join of 64 x 1 us, a thread for each CPU", JOIN, .count = 64, .microseconds = 1)             \
	X("join64-all-phase", "fork-join of 64 x 1 us in a phase, a thread for each CPU", JOIN, .count = 64,               \
	  .microseconds = 1, .phase = true)                                                                                \
	X("loop-all", "loop over 20,000 items of 200 ns, a thread for each CPU", LOOP, .count = 20000,                     \
	  .microseconds = 0.2)                                                                                             \
	X("fib-all", "fib(20), each call a job, a thread for each CPU", FIB)                                               \
	X("graph-us-all", "graph of 100 layers of 100 nodes of 1 us, a thread for each CPU", GRAPH, .count = 10000,        \
	  .shape = JOBS_LAYERS, .microseconds = 1)                                                                         \
	X("reduce-all", "sum of 4,000,000 floats, a thread for each CPU", REDUCE, .count = 4000000)                        \
	X("sort-all", "sort of 1,000,000 random elements, a thread for each CPU", SORT, .count = 1000000)                  \
	X("idle", "CPU time of the other threads after all work is done", IDLE, .threads = 2, .count = 64,                 \
	  .microseconds = 1, .phase = true)

#endif
