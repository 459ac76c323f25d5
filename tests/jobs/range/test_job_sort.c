/* stilb_job_sort against a stable sort by buckets, which shares nothing with it. */
#include "tests/jobs/job_pool_fixture.h"
#include "tests/jobs/job_random.h"

#include "jobs/range/job_sort.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>

static _Atomic bool no_memory; /* relaxed: set while no other thread allocates */

void *__real_aligned_alloc(size_t alignment, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size)
{
	return atomic_load_explicit(&no_memory, memory_order_relaxed) ? NULL : __real_aligned_alloc(alignment, size);
}

/* In the thread sanitizer's builds, and on an emulated processor. */
#define FEWER (TEST_TSAN || TEST_EMULATED)

#if FEWER /* the other pools show no more */
static const uint32_t worker_counts[] = {1, 3};
#else
static const uint32_t worker_counts[] = {0, 1, 2, 3, 8};
#endif

#define for_each_pool(pool)                                                                                            \
	for (size_t turn_ = 0; turn_ < sizeof worker_counts / sizeof *worker_counts; turn_++)                              \
		for (stilb_job_pool *pool = pool_with((shape){.workers = worker_counts[turn_]}); pool;                         \
		     stilb_job_pool_destroy(pool), pool = NULL)

/* ---- elements ---------------------------------------------------------------------------------------------------- */

/* An element begins with a 32-bit word, the key above the original index, and goes on with bytes that follow from the
 * word. One of a single byte has both in that, and of the index only the lowest bits. */
enum { INDEX_BITS = 17, KEYS = 1 << 15, BYTE_INDEX_BITS = 5, BYTE_KEYS = 1 << 3, COUNT_MOST = 100000, SIZE_MOST = 40 };

static const size_t sizes[] = {1, 4, 8, 12, 16, 40};

typedef struct order {
	size_t size;
	counter misaligned;
} order;

static uint32_t key_of(const unsigned char *element, size_t size)
{
	if (size == 1)
		return *element >> BYTE_INDEX_BITS;
	uint32_t word;
	memcpy(&word, element, sizeof word);
	return word >> INDEX_BITS;
}

static void make_element(unsigned char *element, size_t size, uint32_t key, uint32_t index)
{
	if (size == 1) {
		*element = (unsigned char)((key % BYTE_KEYS) << BYTE_INDEX_BITS | index % (1 << BYTE_INDEX_BITS));
		return;
	}
	uint32_t word = key << INDEX_BITS | index;
	memcpy(element, &word, sizeof word);
	for (size_t i = sizeof word; i < size; i++)
		element[i] = (unsigned char)(word * 31 + i);
}

static int by_key(const void *a, const void *b, void *context)
{
	order *o = context;
	uint32_t left = key_of(a, o->size), right = key_of(b, o->size);
	if (((uintptr_t)a | (uintptr_t)b) % (o->size & -o->size) != 0)
		count_up(&o->misaligned);
	return (left > right) - (left < right);
}

typedef enum pattern { RANDOM, ASCENDING, DESCENDING, FEW, EQUAL, ALL_BUT_LAST, ORGAN_PIPE, PATTERNS } pattern;

/* The other ones show no more there. */
enum { PATTERN_STEP = FEWER ? FEW : 1, SIZE_STEP = FEWER ? 3 : 1, COUNT_STEP = FEWER ? 3 : 1 };

static uint32_t key_at(pattern p, uint32_t i, uint32_t count, uint64_t *random)
{
	switch (p) {
	case RANDOM:
		return (uint32_t)(next_random(random) % KEYS);
	case ASCENDING:
		return (uint32_t)((uint64_t)i * KEYS / count);
	case DESCENDING: /* strictly, in arrays of up to KEYS elements */
		return (uint32_t)((uint64_t)(count - 1 - i) * KEYS / count);
	case FEW:
		return (uint32_t)(next_random(random) % 5);
	case ORGAN_PIPE:
		return (uint32_t)((uint64_t)(i < count - i ? i : count - i) * KEYS / count);
	case ALL_BUT_LAST: /* equal */
		return i < count - 1 ? 7 : 6;
	default:
		return 7;
	}
}

static void fill(unsigned char *elements, size_t size, uint32_t count, pattern p)
{
	uint64_t random = count;
	for (uint32_t i = 0; i < count; i++)
		make_element(elements + i * size, size, key_at(p, i, count, &random), i);
}

/* The elements of `from` in `to`, those of each key together, in their order. Keys are below `keys`. */
static void sort_by_buckets(const unsigned char *from, unsigned char *to, size_t size, uint32_t count, uint32_t keys)
{
	static uint32_t place[KEYS + 1];
	memset(place, 0, (keys + 1) * sizeof *place);
	for (uint32_t i = 0; i < count; i++)
		place[key_of(from + i * size, size) + 1]++;
	for (uint32_t key = 0; key < keys; key++)
		place[key + 1] += place[key];
	for (uint32_t i = 0; i < count; i++)
		memcpy(to + place[key_of(from + i * size, size)]++ * size, from + i * size, size);
}

/* ---- the result -------------------------------------------------------------------------------------------------- */

static _Alignas(128) unsigned char input[COUNT_MOST * SIZE_MOST];
static _Alignas(128) unsigned char expected[COUNT_MOST * SIZE_MOST];
static _Alignas(128) unsigned char sorted[COUNT_MOST * SIZE_MOST];

static void check_sort(stilb_job_pool **pools, size_t size, uint32_t count, pattern p)
{
	fill(input, size, count, p);
	sort_by_buckets(input, expected, size, count, KEYS);
	for (size_t i = 0; i < sizeof worker_counts / sizeof *worker_counts; i++) {
		order o = {.size = size};
		memcpy(sorted, input, count * size);
		assert_int_equal(stilb_job_sort(pools[i], sorted, count, size, by_key, &o, 0), 0);
		assert_true(memcmp(sorted, expected, count * size) == 0);
		assert_int_equal(count_of(&o.misaligned), 0);
	}
}

/* Up to 4,095 elements are one chunk in every pool; from 4,096 on they are two, if there are workers, and from 8,192 on
 * four. */
static void arrays_of_any_size_are_sorted(void **state)
{
	(void)state;
	static const uint32_t counts[] = {0, 1, 2, 3, 8, 9, 15, 16, 17, 100, 4095, 4096, 4097, 8191, 8192, 8193, 20011};
	stilb_job_pool *pools[sizeof worker_counts / sizeof *worker_counts];
	for (size_t i = 0; i < sizeof worker_counts / sizeof *worker_counts; i++)
		pools[i] = pool_with((shape){.workers = worker_counts[i]});
	for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s += SIZE_STEP)
		for (size_t c = 0; c < sizeof counts / sizeof *counts; c += COUNT_STEP)
			for (pattern p = RANDOM; p < PATTERNS; p += PATTERN_STEP)
				if (counts[c] < 5000 || p == FEW || (p + c + s) % 4 == 0)
					check_sort(pools, sizes[s], counts[c], p);
	for (pattern p = RANDOM; p < PATTERNS; p += PATTERN_STEP)
		check_sort(pools, p % 2 ? 16 : 8, FEWER ? COUNT_MOST / 4 : COUNT_MOST, p);
	for (size_t i = 0; i < sizeof worker_counts / sizeof *worker_counts; i++)
		stilb_job_pool_destroy(pools[i]);
}

/* In a pool with workers, a tooth is one chunk, or several. */
static void chunks_in_order_make_no_array_in_order(void **state)
{
	(void)state;
	enum { COUNT = 8192, TOOTH = COUNT / 4 };
	for_each_pool(pool) for (int falling = 0; falling < 2; falling++)
	{
		order o = {.size = 8};
		for (uint32_t i = 0; i < COUNT; i++)
			make_element(sorted + i * 8, 8, falling ? TOOTH - i % TOOTH : i % TOOTH, i);
		sort_by_buckets(sorted, expected, 8, COUNT, TOOTH + 1);
		assert_int_equal(stilb_job_sort(pool, sorted, COUNT, 8, by_key, &o, 0), 0);
		assert_true(memcmp(sorted, expected, COUNT * 8) == 0);
	}
}

/* All arrays of up to 8 elements with 3 keys. */
static void short_arrays_are_sorted_whatever_their_order(void **state)
{
	(void)state;
	stilb_job_pool *pool = pool_with((shape){.workers = 1});
	for (uint32_t count = 0, orders = 1; count <= (FEWER ? 6 : 8); count++, orders *= 3) {
		for (uint32_t number = 0; number < orders; number++) {
			for (uint32_t i = 0, digits = number; i < count; i++, digits /= 3)
				make_element(sorted + i * 4, 4, digits % 3, i);
			sort_by_buckets(sorted, expected, 4, count, 3);
			order o = {.size = 4};
			assert_int_equal(stilb_job_sort(pool, sorted, count, 4, by_key, &o, 0), 0);
			assert_true(memcmp(sorted, expected, count * 4) == 0);
		}
	}
	stilb_job_pool_destroy(pool);
}

/* ---- comparisons ------------------------------------------------------------------------------------------------- */

static counter calls;

static int by_key_counted(const void *a, const void *b, void *context)
{
	count_up(&calls);
	return by_key(a, b, context);
}

#ifndef JOB_SORT_CHUNK /* cutting small chunks into pieces takes more */
static void comparisons_are_few(void **state)
{
	(void)state;
	for_each_pool(pool) for (uint32_t count = 1000; count <= (FEWER ? 5000 : 30000); count = count * 3 + 1)
	{
		for (pattern p = RANDOM; p < PATTERNS; p += PATTERN_STEP) {
			order o = {.size = 8};
			fill(sorted, 8, count, p);
			atomic_store_explicit(&calls, 0, memory_order_relaxed); /* no other thread counts */
			assert_int_equal(stilb_job_sort(pool, sorted, count, 8, by_key_counted, &o, 0), 0);
			assert_true(count_of(&calls) <= count * (log2(count) + 1));
			if (p == ASCENDING || p == DESCENDING || p == EQUAL) /* seen in each chunk, and where chunks meet */
				assert_true(count_of(&calls) <= count + count / 20);
			if (p == ORGAN_PIPE || p == ALL_BUT_LAST) /* runs in order are not merged */
				assert_true(count_of(&calls) <= count * log2(count) * 3 / 4);
		}
	}
}
#endif

/* Depends on the bytes of both, and is neither symmetric nor transitive. */
static int by_nothing(const void *a, const void *b, void *context)
{
	uint64_t words[2];
	(void)context;
	memcpy(&words[0], a, sizeof words[0]);
	memcpy(&words[1], b, sizeof words[1]);
	uint64_t mixed = words[0] * 3 ^ words[1];
	return (int)(next_random(&mixed) % 3) - 1;
}

static int by_chance(const void *a, const void *b, void *context)
{
	uint64_t seed = count_up(context);
	(void)a;
	(void)b;
	return (int)(next_random(&seed) % 3) - 1;
}

/* What compare breaks is the order and not the memory: with an answer for each pair, no element is lost. */
static void a_comparison_without_order_loses_no_element(void **state)
{
	(void)state;
	enum { COUNT = 20011 };
	static bool seen[COUNT];
	counter turns = 0;
	for_each_pool(pool)
	{
		fill(sorted, 8, COUNT, RANDOM);
		assert_int_equal(stilb_job_sort(pool, sorted, COUNT, 8, by_nothing, NULL, 0), 0);
		memset(seen, 0, sizeof seen);
		for (uint32_t i = 0; i < COUNT; i++) {
			uint32_t word;
			memcpy(&word, sorted + i * 8, sizeof word);
			uint32_t index = word % (1 << INDEX_BITS);
			assert_true(index < COUNT && !seen[index]);
			seen[index] = true;
		}
		assert_int_equal(stilb_job_sort(pool, sorted, COUNT, 8, by_chance, &turns, 0), 0);
	}
}

/* ---- memory ------------------------------------------------------------------------------------------------------ */

static void without_memory_nothing_moves(void **state)
{
	(void)state;
	enum { COUNT = STILB_JOB_SORT_STACK / 8 };
	for_each_pool(pool) for (uint32_t count = COUNT; count <= 20 * COUNT; count += count == COUNT ? 1 : 19 * COUNT - 1)
	{
		order o = {.size = 8};
		fill(input, 8, count, RANDOM);
		memcpy(sorted, input, count * 8);
		sort_by_buckets(input, expected, 8, count, KEYS);
		atomic_store_explicit(&calls, 0, memory_order_relaxed); /* no other thread counts */
		atomic_store_explicit(&no_memory, true, memory_order_relaxed);
		int error = stilb_job_sort(pool, sorted, count, 8, by_key_counted, &o, 0);
		atomic_store_explicit(&no_memory, false, memory_order_relaxed);
		assert_int_equal(error, count == COUNT ? 0 : -ENOMEM);
		assert_true((count_of(&calls) == 0) == (count > COUNT));
		assert_true(memcmp(sorted, count == COUNT ? expected : input, count * 8) == 0);
		assert_int_equal(stilb_job_sort(pool, sorted, count, 8, by_key_counted, &o, 0), 0);
		assert_true(memcmp(sorted, expected, count * 8) == 0);
	}
}

/* ---- where it may be called -------------------------------------------------------------------------------------- */

enum { NESTED = 6, NESTED_COUNT = 9000 };

typedef struct nested {
	stilb_job_pool *pool;
	counter wrong, sorts;
	unsigned char arrays[NESTED][NESTED_COUNT * 8];
} nested;

static void sort_arrays(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	nested *n = context;
	for (uint32_t i = begin; i < end; i++) {
		order o = {.size = 8};
		memcpy(n->arrays[i], input, sizeof n->arrays[i]);
		int error = stilb_job_sort(n->pool, n->arrays[i], NESTED_COUNT, 8, by_key, &o, worker);
		if (error || memcmp(n->arrays[i], expected, sizeof n->arrays[i]) != 0)
			count_up(&n->wrong);
		count_up(&n->sorts);
	}
}

static void *sort_outside(void *context)
{
	sort_arrays(0, 1, STILB_JOB_OUTSIDE, context);
	return NULL;
}

static void sorts_nest_come_from_outside_and_outlive_a_cancel(void **state)
{
	(void)state;
	static nested n;
	n.pool = pool_with((shape){.workers = 2});
	fill(input, 8, NESTED_COUNT, RANDOM);
	sort_by_buckets(input, expected, 8, NESTED_COUNT, KEYS);
	for (int cancelled = 0; cancelled < 2; cancelled++) {
		stilb_job_parallel_for(n.pool, NESTED, 1, sort_arrays, &n, 0);
		outside_run(sort_outside, &n);
		stilb_job_pool_cancel(n.pool);
	}
	assert_int_equal(count_of(&n.sorts), 2 * (NESTED + 1));
	assert_int_equal(count_of(&n.wrong), 0);
	stilb_job_pool_destroy(n.pool);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(arrays_of_any_size_are_sorted),
		cmocka_unit_test(chunks_in_order_make_no_array_in_order),
		cmocka_unit_test(short_arrays_are_sorted_whatever_their_order),
#ifndef JOB_SORT_CHUNK
		cmocka_unit_test(comparisons_are_few),
#endif
		cmocka_unit_test(a_comparison_without_order_loses_no_element),
		cmocka_unit_test(without_memory_nothing_moves),
		cmocka_unit_test(sorts_nest_come_from_outside_and_outlive_a_cancel),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
