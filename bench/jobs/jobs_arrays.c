#include "bench/jobs/jobs_arrays.h"
#include "bench/harness/bench_child.h"

#include <string.h>

static void *allocate(size_t count, size_t size)
{
	void *array = malloc(count * size);
	if (!array)
		bench_child_fail("out of memory");
	return array;
}

/* ---- tiles ----------------------------------------------------------------------------------------------------- */

static struct {
	uint32_t side;
	float *from, *to; /* row by row; to: from, transposed */
} matrix;

static void transpose_tile(uint32_t x_begin, uint32_t x_end, uint32_t y_begin, uint32_t y_end, uint32_t worker,
                           void *context)
{
	size_t side = matrix.side;
	(void)worker, (void)context;
	for (uint32_t y = y_begin; y < y_end; y++)
		for (uint32_t x = x_begin; x < x_end; x++)
			matrix.to[x * side + y] = matrix.from[y * side + x];
}

void jobs_tiles_make(uint32_t side)
{
	size_t count = (size_t)side * side;
	matrix.side = side;
	matrix.from = allocate(count, sizeof *matrix.from);
	matrix.to = allocate(count, sizeof *matrix.to);
	for (size_t i = 0; i < count; i++)
		matrix.from[i] = (float)(i % 1000003);
}

void jobs_tiles_run(const jobs_subject *subject)
{
	subject->tiles(transpose_tile, NULL, matrix.side, matrix.side);
}

/* Destroys the result, so that the next run must make it again. */
bool jobs_tiles_right(void)
{
	size_t side = matrix.side;
	bool right = true;
	for (size_t y = 0; y < side; y++)
		for (size_t x = 0; x < side; x++)
			right = right && matrix.to[x * side + y] == matrix.from[y * side + x];
	memset(matrix.to, 0xff, side * side * sizeof *matrix.to);
	return right;
}

/* ---- reductions ------------------------------------------------------------------------------------------------ */

static struct {
	uint32_t count;
	float *values;
	double expected, sum;
} floats;

static void add_floats(uint64_t begin, uint64_t end, double *sum, void *context)
{
	const float *values = context;
	for (uint64_t i = begin; i < end; i++)
		*sum += (double)values[i];
}

/* The values are whole numbers and their sum is below 2^53, so that it is the same in any order. */
void jobs_reduce_make(uint32_t count)
{
	floats.count = count;
	floats.values = allocate(count, sizeof *floats.values);
	for (uint32_t i = 0; i < count; i++)
		floats.values[i] = (float)(i * 7 % 1009);
	add_floats(0, count, &floats.expected, floats.values);
}

void jobs_reduce_run(const jobs_subject *subject)
{
	floats.sum = subject->reduce(add_floats, floats.values, floats.count);
}

bool jobs_reduce_right(void)
{
	bool right = floats.sum == floats.expected;
	floats.sum = 0.0;
	return right;
}

/* ---- sorts ----------------------------------------------------------------------------------------------------- */

static struct {
	uint32_t count;
	bool ordered;
	uint64_t random;
	jobs_element *unsorted, *elements;
} array;

void jobs_sort_make(uint32_t count, bool ordered)
{
	array.count = count;
	array.ordered = ordered;
	array.random = 1;
	array.unsorted = allocate(count, sizeof *array.unsorted);
	array.elements = allocate(count, sizeof *array.elements);
}

/* Other elements each time: of an array that comes again the CPU would learn which way the branches go. */
void jobs_sort_fill(void)
{
	uint64_t random = array.random;
	for (uint32_t i = 0; i < array.count; i++) {
		random = random * UINT64_C(6364136223846793005) + 1; /* Knuth, The Art of Computer Programming 2, 3.3.4 */
		array.unsorted[i] = (jobs_element){.key = array.ordered ? i / 2 : (uint32_t)(random >> 44), .index = i};
	}
	array.random = random;
	memcpy(array.elements, array.unsorted, array.count * sizeof *array.elements);
}

void jobs_sort_run(const jobs_subject *subject)
{
	subject->sort(array.elements, array.count);
}

/* In order, and each element once: equal keys may lie in any order, since some subjects are not stable. */
bool jobs_sort_right(void)
{
	bool *seen = calloc(array.count, sizeof *seen), right = true;
	if (!seen)
		bench_child_fail("out of memory");
	for (uint32_t i = 0; i < array.count && right; i++) {
		const jobs_element *element = &array.elements[i];
		right = element->index < array.count && !seen[element->index] &&
		        element->key == array.unsorted[element->index].key && (i == 0 || element[-1].key <= element->key);
		if (right)
			seen[element->index] = true;
	}
	free(seen);
	return right;
}
