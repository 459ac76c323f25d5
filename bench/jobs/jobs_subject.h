/*
 * jobs_subject: the interface between the suite `jobs` and a subject, which is a job system. C and C++.
 *
 * A subject fills the table below; its program is that table linked with jobs_run.c, which runs one case (a workload,
 * jobs_cases.h) and verifies that each job ran exactly once with the right result. Jobs are C functions called through
 * a pointer, for every subject.
 */
#ifndef JOBS_SUBJECT_H
#define JOBS_SUBJECT_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The job functions of jobs/job.h. worker is 0 in subjects that do not number their threads. */
typedef void jobs_fn(void *data, uint32_t worker);
typedef void jobs_range_fn(uint32_t begin, uint32_t end, uint32_t worker, void *context);
typedef void jobs_range_64_fn(uint64_t begin, uint64_t end, uint32_t worker, void *context);

/* Works on the columns x_begin <= x < x_end of the rows y_begin <= y < y_end. */
typedef void jobs_tile_fn(uint32_t x_begin, uint32_t x_end, uint32_t y_begin, uint32_t y_end, uint32_t worker,
                          void *context);

/* Adds what indices begin <= i < end contribute to *sum. */
typedef void jobs_fold_fn(uint64_t begin, uint64_t end, double *sum, void *context);
#define JOBS_REDUCE_GRAIN 16384 /* indices of a call, for subjects that choose it */

typedef struct jobs_element {
	uint32_t key, index;
} jobs_element;

/* `outside` is called by threads of jobs_run.c, all other functions by the main thread. NULL: the subject cannot do it,
 * and is skipped in cases that need it. */
typedef struct jobs_subject {
	const char *name;
	/* True for a serial loop that stands for an ideal job system: its times are divided by the number of threads that
	 * can run at once, which gives the lower bound of a parallel loop. */
	bool ideal;
	/* Starts the job system with `threads` threads, the caller included; false if it failed. steals: stolen_at will be
	 * called. */
	bool (*open)(uint32_t threads, bool steals);
	void (*close)(void);
	/* Calls body(context) in the environment that the calls below need to be cheap, for example in a task arena; NULL:
	 * not needed. */
	void (*inside)(void (*body)(void *context), void *context);
	/* Submits jobs fn(data + i), i in [0, count), one by one; returns when all have run. */
	void (*spawn)(jobs_fn *fn, char *data, uint32_t count);
	/* The same as spawn, but all are submitted in one call. */
	void (*batch)(jobs_fn *fn, char *data, uint32_t count);
	/* The same as spawn, called by a thread that does not belong to the job system. [any-thread]: several call it at
	 * once. */
	void (*outside)(jobs_fn *fn, char *data, uint32_t count);
	/* Submits the jobs fn(i, i + 1), i in [0, count), in one call; returns when all have run. */
	void (*array)(jobs_range_fn *fn, void *context, uint32_t count);
	/* Runs fn over [0, count), a few equal chunks of one index each; returns when all have run. */
	void (*join)(jobs_range_fn *fn, void *context, uint32_t count);
	/* Runs fn over [0, count), many equal items, in slices of the subject's choice; returns when all have run. */
	void (*loop)(jobs_range_fn *fn, void *context, uint32_t count);
	/* loop with 64-bit indices. */
	void (*range)(jobs_range_64_fn *fn, void *context, uint64_t count);
	/* Runs fn over a rectangle in tiles of the subject's choice; returns when all have run. */
	void (*tiles)(jobs_tile_fn *fn, void *context, uint32_t width, uint32_t height);
	/* The sum of what fn adds up for 0 <= i < count. */
	double (*reduce)(jobs_fold_fn *fn, void *context, uint64_t count);
	/* Sorts by key, in the way that is usual with the subject: C subjects call a function for each comparison, C++
	 * inlines it. */
	void (*sort)(jobs_element *elements, uint32_t count);
	/* The n-th Fibonacci number by recursion: one of the two calls is a job, the other a function call, then a wait. */
	uint64_t (*fib)(uint32_t n);
	/* Makes a graph of the nodes fn(data + i), i in [0, count), in which node edge[k][1] runs after node edge[k][0],
	 * and runs it once. Called once; nodes are numbered so that edge[k][0] < edge[k][1]. */
	void (*graph_make)(jobs_fn *fn, char *data, uint32_t count, const uint32_t (*edge)[2], uint32_t edges);
	/* Runs the graph again; returns when all nodes have run. */
	void (*graph_run)(void);
	/* Submits one job without waiting for it; `wait` returns when it has run. */
	void (*submit)(jobs_fn *fn, void *data);
	void (*wait)(void);
	/* Begin and end a phase, in which the subject may keep its threads awake. */
	void (*phase_begin)(void);
	void (*phase_end)(void);
	/* The time (bench_child_now_ns) at which a thread took the last job from another thread's queue. */
	uint64_t (*stolen_at)(void);
} jobs_subject;

/* The subjects of this program, NULL-terminated. */
extern const jobs_subject *const jobs_subjects[];

#ifdef __cplusplus
}
#endif
#endif
