/*
 * Jobs that submit jobs and wait for them: a merge sort. Each call has a group on its own stack; while it waits it runs
 * the jobs it waits for, so no thread idles, and a pool without workers sorts as well.
 *
 * Prints: 100000 numbers in order
 */
#include <stilb/job.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { NUMBERS = 100000, SMALL = 2000 };

typedef struct part {
	stilb_job_pool *pool;
	int *numbers, *scratch;
	size_t count;
} part;

static int compare(const void *a, const void *b)
{
	return *(const int *)a - *(const int *)b;
}

static void merge(const part *whole, size_t half)
{
	size_t left = 0, right = half;
	for (size_t i = 0; i < whole->count; i++) {
		bool take_left = right == whole->count || (left < half && whole->numbers[left] <= whole->numbers[right]);
		whole->scratch[i] = whole->numbers[take_left ? left++ : right++];
	}
	memcpy(whole->numbers, whole->scratch, whole->count * sizeof *whole->numbers);
}

static void sort(void *data, uint32_t worker)
{
	part *whole = data;
	if (whole->count <= SMALL) {
		qsort(whole->numbers, whole->count, sizeof *whole->numbers, compare);
		return;
	}
	size_t half = whole->count / 2;
	part left = {whole->pool, whole->numbers, whole->scratch, half};
	part right = {whole->pool, whole->numbers + half, whole->scratch + half, whole->count - half};
	stilb_job_group group = {0};
	if (stilb_job_submit(whole->pool, sort, &left, &group, worker) != 0)
		sort(&left, worker); /* no memory: sort on this thread */
	sort(&right, worker);
	stilb_job_wait(whole->pool, &group, worker);
	merge(whole, half);
}

int main(void)
{
	static int numbers[NUMBERS], scratch[NUMBERS];
	uint32_t random = 1;
	for (int i = 0; i < NUMBERS; i++)
		numbers[i] = (int)((random = random * 1664525u + 1013904223u) >> 8); /* Numerical Recipes' generator */
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	part all = {.numbers = numbers, .scratch = scratch, .count = NUMBERS};
	if (stilb_job_pool_create(&desc, &all.pool) != 0)
		return 1;
	sort(&all, 0);
	int ordered = 1;
	while (ordered < NUMBERS && numbers[ordered - 1] <= numbers[ordered])
		ordered++;
	printf("%d numbers in order\n", ordered);
	stilb_job_pool_destroy(all.pool);
	return 0;
}
