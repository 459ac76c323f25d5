/*
 * jobs_subject: what the suite `jobs` asks of a job system.
 *
 * A subject is one job system behind the table below. Its program is that table linked with jobs_run.c, which runs
 * one case (jobs_cases.h) and verifies that each job ran exactly once and that the results are right. Jobs are C
 * functions called through a pointer, for every subject.
 */
#ifndef JOBS_SUBJECT_H
#define JOBS_SUBJECT_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* As in jobs/job.h; worker is 0 in subjects that do not number their threads. */
typedef void jobs_fn(void *data, uint32_t worker);
typedef void jobs_range_fn(uint32_t begin, uint32_t end, uint32_t worker, void *context);

/* All but outside are called by the main thread. A null function: the subject has no such thing, and its row stays
 * empty. */
typedef struct jobs_subject {
	const char *name;
	/* Its times are divided by the number of threads that can run at the same moment: the limit of a loop. */
	bool ideal;
	/* Starts the job system with so many threads in all, the caller included; steals: stolen_at will be called. */
	bool (*open)(uint32_t threads, bool steals);
	void (*close)(void);
	/* Calls body from where the calls below are cheapest for this subject (NULL: from anywhere). */
	void (*inside)(void (*body)(void *context), void *context);
	/* One job object after the other, fn(data + i) for i in [0, count); returns when all have run. */
	void (*spawn)(jobs_fn *fn, char *data, uint32_t count);
	/* The same from a thread that does not belong to the job system; several may call it at once. */
	void (*outside)(jobs_fn *fn, char *data, uint32_t count);
	/* The same jobs as one object: fn over [0, count), one index a job; returns when all have run. */
	void (*array)(jobs_range_fn *fn, void *context, uint32_t count);
	/* Fork-join of a few equal chunks, each one index of [0, count). */
	void (*join)(jobs_range_fn *fn, void *context, uint32_t count);
	/* A loop over many equal items; how to slice is left to the subject. */
	void (*loop)(jobs_range_fn *fn, void *context, uint32_t count);
	/* Naive Fibonacci: in each call one of the two calls below is a job, the other is direct, then a wait. */
	uint64_t (*fib)(uint32_t n);
	/* One job, without waiting for it; wait returns when it has run. */
	void (*submit)(jobs_fn *fn, void *data);
	void (*wait)(void);
	/* Between the two the subject may keep its threads awake. */
	void (*phase_begin)(void);
	void (*phase_end)(void);
	/* When a thread took the last job from another one, by bench_child_now_ns. */
	uint64_t (*stolen_at)(void);
} jobs_subject;

/* The subjects of this program, up to NULL. */
extern const jobs_subject *const jobs_subjects[];

#ifdef __cplusplus
}
#endif
#endif
