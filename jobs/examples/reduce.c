/*
 * A reduction: the sum of the first ten million terms of the series of pi / 4. Its slices and their order are the same
 * on any number of threads, and so is every bit of the sum.
 *
 * Prints: pi is about 3.1415926
 */
#include <stilb/job_range.h>

#include <stdio.h>

static void add_terms(uint64_t begin, uint64_t end, void *sum, uint32_t worker, void *context)
{
	(void)worker;
	(void)context;
	double own = 0;
	for (uint64_t i = begin; i < end; i++)
		own += (i % 2 ? -1.0 : 1.0) / (double)(2 * i + 1);
	*(double *)sum += own;
}

static void add(void *left, const void *right, void *context)
{
	(void)context;
	*(double *)left += *(const double *)right;
}

int main(void)
{
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	stilb_job_pool *pool;
	if (stilb_job_pool_create(&desc, &pool) != 0)
		return 1;
	double zero = 0, sum;
	stilb_job_reduction terms = {.size = sizeof sum, .identity = &zero, .fold = add_terms, .combine = add};
	int error = stilb_job_reduce(pool, 10000000, 0, &terms, &sum, 0);
	stilb_job_pool_destroy(pool);
	if (error)
		return 1;
	printf("pi is about %.7f\n", 4 * sum);
	return 0;
}
