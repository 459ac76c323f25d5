/*
 * job_range: parallel loops over 64-bit ranges and over rectangles, and reductions whose result does not depend on the
 * number of threads. All of them are loops of job.h underneath: what its head says about threads, nesting and waiting,
 * and what stilb_job_parallel_for says about cancelled pools and outside threads, holds for them, too.
 *
 * Example.      The sum of an array, the same bit for bit on any number of workers.
 *
 *                   static void add(uint64_t begin, uint64_t end, void *sum, uint32_t worker, void *context)
 *                   {
 *                       const float *values = context;
 *                       for (uint64_t i = begin; i < end; i++)
 *                           *(double *)sum += values[i];
 *                   }
 *                   static void join(void *left, const void *right, void *context)
 *                   {
 *                       *(double *)left += *(const double *)right;
 *                   }
 *
 *                   double zero = 0, sum;
 *                   stilb_job_reduction add_up = {
 *                       .size = sizeof sum, .identity = &zero, .fold = add, .combine = join, .context = values};
 *                   stilb_job_reduce(pool, count, 0, &add_up, &sum, 0); // cannot fail: sum is small
 */
#ifndef STILB_JOB_RANGE_H
#define STILB_JOB_RANGE_H

#include <stilb/job.h>

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* The part of a loop that covers indices begin <= i < end; worker and context as in stilb_job_range_fn. */
typedef void stilb_job_range_64_fn(uint64_t begin, uint64_t end, uint32_t worker, void *context);

/* stilb_job_parallel_for for up to 2^64 - 1 indices. Of more than 2^31 slices, neighbours are handed out together; each
 * is still a call of fn. [any-thread] */
void stilb_job_parallel_for_64(stilb_job_pool *pool, uint64_t count, uint64_t grain, stilb_job_range_64_fn *fn,
                               void *context, uint32_t worker);

/* The columns x_begin <= x < x_end of the rows y_begin <= y < y_end. */
typedef struct stilb_job_tile {
	uint32_t x_begin, x_end, y_begin, y_end;
} stilb_job_tile;

/* The part of a loop that covers a tile, which is never empty; worker and context as in stilb_job_range_fn. */
typedef void stilb_job_tile_fn(stilb_job_tile tile, uint32_t worker, void *context);

/* Calls fn for tiles that together cover the rectangle 0 <= x < width, 0 <= y < height, as stilb_job_parallel_for does
 * for slices. Tiles are tile_width x tile_height, smaller at the right and lower edges. 0: chosen for this side from
 * its length and the pool's threads, a power of two from 8 to 64. Tiles that follow one another, which a thread often
 * claims together, form blocks of about 4 x 4 tiles and not long rows: what they share stays in the cache.
 * [any-thread] */
void stilb_job_parallel_for_tiles(stilb_job_pool *pool, uint32_t width, uint32_t height, uint32_t tile_width,
                                  uint32_t tile_height, stilb_job_tile_fn *fn, void *context, uint32_t worker);

/* Adds what indices begin <= i < end contribute to *value. */
typedef void stilb_job_fold_fn(uint64_t begin, uint64_t end, void *value, uint32_t worker, void *context);

/* Makes *left the combination of *left and *right, in this order: left comes from smaller indices. */
typedef void stilb_job_combine_fn(void *left, const void *right, void *context);

/* How a range becomes one value. Values are copied as bytes. */
typedef struct stilb_job_reduction {
	size_t size;                   /* sizeof of the type of the values, at least 1; its alignment is 128 at most */
	const void *identity;          /* the value of an empty range */
	stilb_job_fold_fn *fold;       /* on any thread that stilb_job_parallel_for uses, on several at a time */
	stilb_job_combine_fn *combine; /* on the calling thread, in the order of the indices; associative, as far as the
	                                * program cares */
	void *context;                 /* passed to both */
} stilb_job_reduction;

/* The most slices of a reduction. */
#define STILB_JOB_REDUCE_SLICES 1024

/* Values of this many bytes are reduced without any memory if there is none. */
#define STILB_JOB_REDUCE_STACK 4096

/* Cuts 0 <= i < count into slices of grain indices, or of more if there were over STILB_JOB_REDUCE_SLICES; grain 0
 * means 1. Folds each slice into a copy of the identity, and stores the identity combined with all slices, from first
 * to last, in *result. Slices and order depend on count and grain alone, and so the result is the same for any number
 * of threads, also if it is a sum of floats. Allocates STILB_JOB_REDUCE_SLICES values at most, and nothing for values
 * that fit into STILB_JOB_REDUCE_STACK bytes together; without that memory it works on fewer slices at a time, with the
 * same result. -ENOMEM: a value is larger than STILB_JOB_REDUCE_STACK and there is no memory; no function was called
 * and *result is unchanged. [any-thread] */
int stilb_job_reduce(stilb_job_pool *pool, uint64_t count, uint64_t grain, const stilb_job_reduction *reduction,
                     void *result, uint32_t worker);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#endif
