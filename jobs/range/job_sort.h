/*
 * job_sort: sorts an array on the threads of a pool. The sort is stable: what compares equal keeps its order, and so
 * the result is the same on any number of threads.
 *
 * Example.
 *                   static int by_depth(const void *a, const void *b, void *context)
 *                   {
 *                       const draw *l = a, *r = b;
 *                       return (l->depth > r->depth) - (l->depth < r->depth);
 *                   }
 *
 *                   int error = stilb_job_sort(pool, draws, count, sizeof *draws, by_depth, NULL, 0);
 */
#ifndef STILB_JOB_SORT_H
#define STILB_JOB_SORT_H

#include <stilb/job.h>

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* Less than 0: *a comes before *b; 0: they are equal; more than 0: *b comes before *a. Only whether it is more than 0
 * is looked at. It is called by several threads
 * at a time, with pointers into the array or into a copy of it of the same alignment, up to 128. It must not change the
 * elements. */
typedef int stilb_job_compare_fn(const void *a, const void *b, void *context);

/* Arrays of this many bytes are sorted without any memory. */
#define STILB_JOB_SORT_STACK 4096

/* Sorts count elements of size bytes from base on, size at least 1, in ascending order of compare. Elements are copied
 * as bytes. Arrays of less than some 4,000 elements, and all in a pool without workers, are sorted by the calling
 * thread alone; others by loops of stilb_job_parallel_for, and what that says about nesting, cancelled pools and
 * outside threads holds here, too. compare is called at most count * (log2(count) + 2) times, and about count times if
 * the array is in order. If it is no order, for example of floats with NaN among them, but answers the same for the
 * same elements, all elements are still there, in some order. Allocates as many bytes as the array has, unless those
 * are STILB_JOB_SORT_STACK at most. -ENOMEM: there is no memory; compare was not called and the array is unchanged.
 * [any-thread] */
int stilb_job_sort(stilb_job_pool *pool, void *base, size_t count, size_t size, stilb_job_compare_fn *compare,
                   void *context, uint32_t worker);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif
#endif
