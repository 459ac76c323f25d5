/* Loops over 64-bit ranges and tiles reach every index once; reductions are the same on any number of threads. */
#include "tests/jobs/job_pool_fixture.h"
#include "tests/jobs/job_random.h"

#include "jobs/range/job_range.h"

#include <errno.h>
#include <stdlib.h>

static _Atomic bool no_memory; /* relaxed: set while no other thread allocates */

void *__real_aligned_alloc(size_t alignment, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size)
{
	return atomic_load_explicit(&no_memory, memory_order_relaxed) ? NULL : __real_aligned_alloc(alignment, size);
}

static const uint32_t worker_counts[] = {0, 1, 2, 3, 8};

#define for_each_pool(pool)                                                                                            \
	for (size_t turn_ = 0; turn_ < sizeof worker_counts / sizeof *worker_counts; turn_++)                              \
		for (stilb_job_pool *pool = pool_with((shape){.workers = worker_counts[turn_]}); pool;                         \
		     stilb_job_pool_destroy(pool), pool = NULL)

/* ---- 64-bit ranges ----------------------------------------------------------------------------------------------- */

typedef struct range_check {
	uint64_t count, grain;
	counter wrong, slices;
	counter seen[5000]; /* by number of the slice */
} range_check;

static void check_slice(uint64_t begin, uint64_t end, uint32_t worker, void *context)
{
	range_check *check = context;
	(void)worker;
	uint64_t number = begin / check->grain, left = check->count - begin;
	if (begin % check->grain != 0 || begin >= end || number >= 5000 ||
	    end - begin != (left < check->grain ? left : check->grain)) {
		count_up(&check->wrong);
		return;
	}
	count_up(&check->slices);
	count_up(&check->seen[number]);
}

static void check_range(stilb_job_pool *pool, uint64_t count, uint64_t grain, uint32_t worker)
{
	static range_check check;
	memset(&check, 0, sizeof check);
	check.count = count;
	check.grain = grain ? grain : 1;
	stilb_job_parallel_for_64(pool, count, grain, check_slice, &check, worker);
	uint32_t slices = (uint32_t)(count / check.grain + (count % check.grain > 0));
	assert_int_equal(count_of(&check.wrong), 0);
	assert_int_equal(count_of(&check.slices), slices);
	for (uint32_t i = 0; i < slices; i++)
		assert_int_equal(count_of(&check.seen[i]), 1);
}

static void ranges_reach_every_index_once(void **state)
{
	(void)state;
	uint64_t random = 1;
	for_each_pool(pool)
	{
		static const uint64_t edges[][2] = {{0, 0},
		                                    {0, 7},
		                                    {1, 0},
		                                    {1, UINT64_MAX},
		                                    {UINT32_MAX, 1u << 30},
		                                    {(uint64_t)1 << 32, 1u << 30},
		                                    {UINT64_MAX, UINT64_MAX},
		                                    {UINT64_MAX, UINT64_MAX - 1},
		                                    {UINT64_MAX, (uint64_t)1 << 63},
		                                    {UINT64_MAX, ((uint64_t)1 << 63) + 1},
		                                    {UINT64_MAX, (uint64_t)1 << 52},
		                                    {UINT64_MAX - 1, ((uint64_t)1 << 53) - 1},
		                                    {5000, 1}};
		for (size_t i = 0; i < sizeof edges / sizeof *edges; i++)
			check_range(pool, edges[i][0], edges[i][1], 0);
		for (int i = 0; i < 100; i++) {
			uint64_t count = next_random(&random) >> (next_random(&random) % 64);
			check_range(pool, count, count / (1 + next_random(&random) % 4999) + 1, 0);
		}
	}
}

/* ---- tiles ------------------------------------------------------------------------------------------------------- */

enum { SIDE = 128 };

typedef struct tile_check {
	uint32_t width, height, tile_width, tile_height;
	counter wrong, tiles;
	counter seen[SIDE][SIDE];
} tile_check;

static void check_tile(stilb_job_tile tile, uint32_t worker, void *context)
{
	tile_check *check = context;
	(void)worker;
	count_up(&check->tiles);
	if (tile.x_begin >= tile.x_end || tile.y_begin >= tile.y_end || tile.x_end > check->width ||
	    tile.y_end > check->height || (check->tile_width > 0 && tile.x_end - tile.x_begin > check->tile_width) ||
	    (check->tile_height > 0 && tile.y_end - tile.y_begin > check->tile_height)) {
		count_up(&check->wrong);
		return;
	}
	if (check->width > SIDE || check->height > SIDE)
		return;
	for (uint32_t y = tile.y_begin; y < tile.y_end; y++)
		for (uint32_t x = tile.x_begin; x < tile.x_end; x++)
			count_up(&check->seen[y][x]);
}

static uint32_t check_tiles(stilb_job_pool *pool, uint32_t width, uint32_t height, uint32_t tile_width,
                            uint32_t tile_height)
{
	static tile_check check;
	memset(&check, 0, sizeof check);
	check.width = width;
	check.height = height;
	check.tile_width = tile_width;
	check.tile_height = tile_height;
	stilb_job_parallel_for_tiles(pool, width, height, tile_width, tile_height, check_tile, &check, 0);
	assert_int_equal(count_of(&check.wrong), 0);
	if (tile_width > 0 && tile_height > 0 && width > 0 && height > 0)
		assert_int_equal(count_of(&check.tiles), ((width - 1) / tile_width + 1) * ((height - 1) / tile_height + 1));
	for (uint32_t y = 0; y < SIDE && height <= SIDE && width <= SIDE; y++)
		for (uint32_t x = 0; x < SIDE; x++)
			assert_int_equal(count_of(&check.seen[y][x]), x < width && y < height);
	return count_of(&check.tiles);
}

static void tiles_cover_every_point_once(void **state)
{
	(void)state;
	uint64_t random = 2;
	for_each_pool(pool)
	{
		assert_int_equal(check_tiles(pool, 0, 5, 1, 1), 0);
		assert_int_equal(check_tiles(pool, 5, 0, 0, 0), 0);
		assert_int_equal(check_tiles(pool, 1, 1, 0, 0), 1);
		assert_int_equal(check_tiles(pool, UINT32_MAX, UINT32_MAX, 1u << 31, UINT32_MAX), 2);
		assert_int_equal(check_tiles(pool, UINT32_MAX, UINT32_MAX, (1u << 31) + 1, (1u << 31) + 1), 4);
		assert_int_equal(check_tiles(pool, UINT32_MAX, 9, 1u << 27, 1), 32 * 9);
		for (int i = 0; i < (TEST_TSAN ? 10 : 50); i++)
			check_tiles(pool, (uint32_t)(next_random(&random) % SIDE + 1), (uint32_t)(next_random(&random) % SIDE + 1),
			            (uint32_t)(next_random(&random) % 20), (uint32_t)(next_random(&random) % 20));
	}
}

typedef struct tile_log {
	uint32_t count;
	stilb_job_tile tiles[64];
} tile_log;

static void log_tile(stilb_job_tile tile, uint32_t worker, void *context)
{
	tile_log *log = context;
	(void)worker;
	log->tiles[log->count++] = tile;
}

/* In a pool without workers the order is that of the numbers: any 16 tiles of a whole band are a square. */
static void neighbours_in_order_are_neighbours_in_the_rectangle(void **state)
{
	(void)state;
	stilb_job_pool *pool = pool_with((shape){.workers = 0});
	tile_log log = {0};
	stilb_job_parallel_for_tiles(pool, 32, 32, 4, 4, log_tile, &log, 0);
	assert_int_equal(log.count, 64);
	for (uint32_t first = 0; first < 64; first += 16)
		for (uint32_t i = first; i < first + 16; i++) {
			assert_int_equal(log.tiles[i].x_begin / 16, first / 16 % 2);
			assert_int_equal(log.tiles[i].y_begin / 16, first / 32);
		}
	stilb_job_pool_destroy(pool);
}

/* ---- reductions -------------------------------------------------------------------------------------------------- */

/* A text does not commute: it shows the order, and that no slice is missing or twice. */
enum { TEXT_MOST = 1500 };

typedef struct text {
	uint32_t length;
	uint16_t at[TEXT_MOST];
} text;

static counter folds;

static void fold_text(uint64_t begin, uint64_t end, void *value, uint32_t worker, void *context)
{
	text *t = value;
	(void)worker;
	(void)context;
	count_up(&folds);
	for (uint64_t i = begin; i < end; i++)
		t->at[t->length++] = (uint16_t)i;
}

static void combine_text(void *left, const void *right, void *context)
{
	text *l = left;
	const text *r = right;
	(void)context;
	memcpy(l->at + l->length, r->at, r->length * sizeof *r->at);
	l->length += r->length;
}

static const text no_text;
static const stilb_job_reduction append = {
	.size = sizeof(text), .identity = &no_text, .fold = fold_text, .combine = combine_text};

static void values_are_combined_in_order(void **state)
{
	(void)state;
	static text result;
	for_each_pool(pool) for (uint32_t count = 0; count < TEXT_MOST; count = count * 3 + 1)
	{
		assert_int_equal(stilb_job_reduce(pool, count, count / 50, &append, &result, 0), 0);
		assert_int_equal(result.length, count);
		for (uint32_t i = 0; i < count; i++)
			assert_int_equal(result.at[i], i);
	}
}

static void fold_sum(uint64_t begin, uint64_t end, void *value, uint32_t worker, void *context)
{
	const float *values = context;
	(void)worker;
	for (uint64_t i = begin; i < end; i++)
		*(float *)value += values[i];
}

static void combine_sum(void *left, const void *right, void *context)
{
	(void)context;
	*(float *)left += *(const float *)right;
}

static float sum_of(stilb_job_pool *pool, float *values, uint64_t count, uint64_t grain, uint32_t worker)
{
	float zero = 0, sum = -1;
	stilb_job_reduction add = {
		.size = sizeof zero, .identity = &zero, .fold = fold_sum, .combine = combine_sum, .context = values};
	assert_int_equal(stilb_job_reduce(pool, count, grain, &add, &sum, worker), 0);
	return sum;
}

enum { FLOATS = 100000 };

static float floats[FLOATS];

static void sums_of_floats_are_the_same_bit_for_bit(void **state)
{
	(void)state;
	uint64_t random = 3;
	for (int i = 0; i < FLOATS; i++)
		floats[i] = (float)(next_random(&random) % 1000003) * 1e-3f;
	static const uint64_t grains[] = {0, 1, 999, FLOATS};
	float truth[4];
	for (int g = 0; g < 4; g++) { /* serial: slices of max(grain, 98) */
		uint64_t grain = grains[g] > 98 ? grains[g] : 98;
		truth[g] = 0;
		for (uint64_t begin = 0; begin < FLOATS; begin += grain) {
			float part = 0;
			for (uint64_t i = begin; i < begin + grain && i < FLOATS; i++)
				part += floats[i];
			truth[g] += part;
		}
	}
	assert_true(truth[0] != truth[3]); /* the slices matter */
	for_each_pool(pool) for (int round = 0; round < 5; round++) for (int g = 0; g < 4; g++)
	{
		float sum = sum_of(pool, floats, FLOATS, grains[g], 0);
		assert_memory_equal(&sum, &truth[g], sizeof sum);
	}
}

static void a_reduction_of_any_count(void **state)
{
	(void)state;
	static text result;
	stilb_job_pool *pool = pool_with((shape){.workers = 2});
	assert_true(sum_of(pool, floats, 0, 0, 0) == 0);
	assert_true(sum_of(pool, floats, 1, UINT64_MAX, 0) == floats[0]);
	result.length = 7;
	assert_int_equal(stilb_job_reduce(pool, 0, 0, &append, &result, 0), 0);
	assert_int_equal(result.length, 0);
	stilb_job_pool_destroy(pool);
}

static void without_memory_the_result_is_the_same(void **state)
{
	(void)state;
	static struct {
		text text;
		unsigned char more[STILB_JOB_REDUCE_STACK];
	} large, none;
	static text result;
	for_each_pool(pool)
	{
		float sum = sum_of(pool, floats, FLOATS, 0, 0), again;
		atomic_store_explicit(&no_memory, true, memory_order_relaxed);
		again = sum_of(pool, floats, FLOATS, 0, 0);
		int small_error = stilb_job_reduce(pool, 1000, 7, &append, &result, 0);
		uint32_t before = count_of(&folds);
		stilb_job_reduction too_large = append;
		too_large.size = sizeof large;
		too_large.identity = &none;
		large.text.length = 7;
		int large_error = stilb_job_reduce(pool, 1000, 0, &too_large, &large, 0);
		atomic_store_explicit(&no_memory, false, memory_order_relaxed);
		assert_memory_equal(&sum, &again, sizeof sum);
		assert_int_equal(small_error, 0);
		assert_int_equal(result.length, 1000);
		for (uint32_t i = 0; i < 1000; i++)
			assert_int_equal(result.at[i], i);
		assert_int_equal(large_error, -ENOMEM);
		assert_int_equal(large.text.length, 7);
		assert_int_equal(count_of(&folds), before);
		assert_int_equal(stilb_job_reduce(pool, 1000, 0, &too_large, &large, 0), 0);
		assert_int_equal(large.text.length, 1000);
	}
}

/* ---- where they may be called ------------------------------------------------------------------------------------ */

typedef struct nested {
	stilb_job_pool *pool;
	float expected;
	counter wrong, slices;
} nested;

static void sum_again(uint64_t begin, uint64_t end, uint32_t worker, void *context)
{
	nested *n = context;
	(void)begin;
	(void)end;
	count_up(&n->slices);
	if (sum_of(n->pool, floats, FLOATS, 5000, worker) != n->expected)
		count_up(&n->wrong);
}

static void *sum_outside(void *context)
{
	nested *n = context;
	check_range(n->pool, UINT64_MAX, (uint64_t)1 << 55, STILB_JOB_OUTSIDE);
	stilb_job_parallel_for_64(n->pool, 4, 1, sum_again, n, STILB_JOB_OUTSIDE);
	if (sum_of(n->pool, floats, FLOATS, 5000, STILB_JOB_OUTSIDE) != n->expected)
		count_up(&n->wrong);
	return NULL;
}

static void they_nest_come_from_outside_and_outlive_a_cancel(void **state)
{
	(void)state;
	nested n = {.pool = pool_with((shape){.workers = 2})};
	n.expected = sum_of(n.pool, floats, FLOATS, 5000, 0);
	stilb_job_parallel_for_64(n.pool, 20, 1, sum_again, &n, 0);
	outside_run(sum_outside, &n);
	stilb_job_pool_cancel(n.pool);
	stilb_job_parallel_for_64(n.pool, 20, 1, sum_again, &n, 0);
	outside_run(sum_outside, &n);
	assert_int_equal(count_of(&n.slices), 48);
	assert_int_equal(count_of(&n.wrong), 0);
	stilb_job_pool_destroy(n.pool);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(ranges_reach_every_index_once),
		cmocka_unit_test(tiles_cover_every_point_once),
		cmocka_unit_test(neighbours_in_order_are_neighbours_in_the_rectangle),
		cmocka_unit_test(values_are_combined_in_order),
		cmocka_unit_test(sums_of_floats_are_the_same_bit_for_bit),
		cmocka_unit_test(a_reduction_of_any_count),
		cmocka_unit_test(without_memory_the_result_is_the_same),
		cmocka_unit_test(they_nest_come_from_outside_and_outlive_a_cancel),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
