/* A stable merge sort: chunks of the array are sorted at the same time, each by one thread; then passes merge pairs of
 * neighbours, each pair in pieces of equal length. Every pass moves all elements from one of two arrays, the caller's
 * and a copy, into the other at the same place. */
#include "jobs/range/job_sort.h"

#include "jobs/job_allocate.h"

#include <assert.h>
#include <errno.h>
#include <stdalign.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <string.h>

/* Elements that a chunk or a piece has at least: they take some 20 us or more. Tests set fewer. */
#ifndef JOB_SORT_CHUNK
#define JOB_SORT_CHUNK 2048
#endif

/* Chunks, and pieces of a pass, for each thread, so that threads finish together: two threads then sort a million
 * elements in 1/1.8 of the time of one, and with 4 chunks a thread in 1/1.6 (AMD EPYC, family 25, model 17). */
#define CHUNKS_A_THREAD 16

/* So many elements are sorted by insertion. */
#define LEAF_MOST 8

typedef unsigned char byte;

/* One call of stilb_job_sort. */
typedef struct sorting {
	stilb_job_compare_fn *compare;
	void *context;
	size_t count, size;
	/* Of a pass. */
	byte *from, *to;
	uint32_t runs;   /* in `from`, a power of two: chunks first, sorted runs later */
	uint32_t pieces; /* of each pair of runs, a power of two */
	bool across;     /* chunks end in `to`, not in `from` */
	/* What the chunks that have been looked at do not rule out for the array. Relaxed, both: they are read when the
	 * loop over the chunks has ended; in the loop, an old value costs time alone. */
	_Atomic bool ascending, descending;
} sorting;

/* ---- one thread ------------------------------------------------------------------------------------------------ */

/* Two sorted runs, and where they are merged to; left comes before right among equals. */
typedef struct merge {
	const byte *left, *right;
	size_t left_count, right_count;
	byte *to;
} merge;

/* Functions that end in _sized are inlined into callers that know the size: a copy then is one or two moves. */
#define SIZED static inline __attribute__((always_inline))

/* All bits set if *a, which stands before *b, must come after it; else 0. With masks instead of branches, of which half
 * would be mispredicted, a million random elements of 16 bytes take .56 of the time (AMD EPYC, family 25, model 17). */
SIZED size_t falls(const sorting *sort, const byte *a, const byte *b)
{
	return -(size_t)(sort->compare(a, b, sort->context) > 0);
}

/* Moves the first element of both runs, which are not empty and lie in the same array. */
SIZED void take_first(const sorting *sort, merge *m, size_t size)
{
	size_t mask = falls(sort, m->left, m->right);
	memcpy(m->to, m->left + ((size_t)(m->right - m->left) & mask), size);
	m->left += size & ~mask;
	m->right += size & mask;
	m->to += size;
}

/* Each comparison waits for the one before; two chains, from both ends, do so at the same time. */
SIZED void merge_sized(const sorting *sort, merge m, size_t size)
{
	const byte *left_end = m.left + m.left_count * size, *right_end = m.right + m.right_count * size;
	byte *to_end = m.to + (m.left_count + m.right_count) * size;
	for (;;) {
		size_t least = (size_t)(left_end - m.left < right_end - m.right ? left_end - m.left : right_end - m.right);
		size_t steps = least / size / 2; /* in which no run ends */
		if (steps == 0)
			break;
		for (; steps > 0; steps--) {
			take_first(sort, &m, size);
			size_t mask = falls(sort, left_end - size, right_end - size);
			to_end -= size;
			memcpy(to_end, right_end - size - ((size_t)(right_end - left_end) & mask), size);
			left_end -= size & mask;
			right_end -= size & ~mask;
		}
	}
	while (m.left < left_end && m.right < right_end)
		take_first(sort, &m, size);
	if (m.left < left_end)
		memcpy(m.to, m.left, (size_t)(left_end - m.left));
	else
		memcpy(m.to, m.right, (size_t)(right_end - m.right));
}

/* Runs that are in order already, as in an array that was appended to, are copied. */
static void merge_runs(const sorting *sort, merge m)
{
	size_t size = sort->size;
	if (m.left_count == 0 || m.right_count == 0 ||
	    sort->compare(m.left + (m.left_count - 1) * size, m.right, sort->context) <= 0) {
		memcpy(m.to, m.left, m.left_count * size);
		memcpy(m.to + m.left_count * size, m.right, m.right_count * size);
		return;
	}
	switch (size) {
	case 4:
		merge_sized(sort, m, 4);
		break;
	case 8:
		merge_sized(sort, m, 8);
		break;
	case 16:
		merge_sized(sort, m, 16);
		break;
	default:
		merge_sized(sort, m, size);
	}
}

/* Inserts the elements of `from` one by one into the sorted ones of `to`. Their place is found by halving, which takes
 * 17 comparisons at most for 8 elements. */
SIZED void insert_sized(const sorting *sort, const byte *from, byte *to, size_t count, size_t size)
{
	for (size_t i = 0; i < count; i++) {
		const byte *element = from + i * size;
		size_t place = 0;
		for (size_t left = i; left > 0;) {
			size_t middle = left / 2, mask = falls(sort, to + (place + middle) * size, element);
			place += (middle + 1) & ~mask;
			left = (middle & mask) | ((left - middle - 1) & ~mask);
		}
		for (size_t k = i; k > place; k--)
			memcpy(to + k * size, to + (k - 1) * size, size);
		memcpy(to + place * size, element, size);
	}
}

static void insert_all(const sorting *sort, const byte *from, byte *to, size_t count)
{
	switch (sort->size) {
	case 4:
		insert_sized(sort, from, to, count, 4);
		break;
	case 8:
		insert_sized(sort, from, to, count, 8);
		break;
	case 16:
		insert_sized(sort, from, to, count, 16);
		break;
	default:
		insert_sized(sort, from, to, count, sort->size);
	}
}

/* Sorts count elements of `from`. They end in `to` if `across`, otherwise in `from`; the other place is overwritten. */
static void sort_serial(const sorting *sort, byte *from, byte *to, size_t count, bool across)
{
	if (count <= LEAF_MOST) {
		if (across) {
			insert_all(sort, from, to, count);
		} else {
			memcpy(to, from, count * sort->size);
			insert_all(sort, to, from, count);
		}
		return;
	}
	size_t half = count / 2, offset = half * sort->size;
	sort_serial(sort, from, to, half, !across);
	sort_serial(sort, from + offset, to + offset, count - half, !across);
	byte *source = across ? from : to;
	merge_runs(sort, (merge){source, source + offset, half, count - half, across ? to : from});
}

/* How a chunk is found: often in order, or in reverse. */
typedef enum chunk_order { ASCENDING, DESCENDING /* strictly */, MIXED } chunk_order;

static chunk_order order_of(const sorting *sort, const byte *elements, size_t count)
{
	chunk_order order = MIXED;
	for (size_t i = 1; i < count; i++) {
		const byte *element = elements + i * sort->size;
		bool falls = sort->compare(element - sort->size, element, sort->context) > 0;
		if (i > 1 && falls != (order == DESCENDING))
			return MIXED;
		order = falls ? DESCENDING : ASCENDING;
	}
	return order;
}

SIZED void reverse_sized(byte *left, byte *right, size_t pairs, byte *spare, size_t size)
{
	for (; pairs > 0; pairs--, left += size) {
		right -= size;
		memcpy(spare, left, size);
		memcpy(left, right, size);
		memcpy(right, spare, size);
	}
}

/* Swaps elements from `left` on with those before `right`, from there down. `spare` has room for one. */
static void reverse(const sorting *sort, byte *left, byte *right, size_t pairs, byte *spare)
{
	switch (sort->size) {
	case 4:
		reverse_sized(left, right, pairs, spare, 4);
		break;
	case 8:
		reverse_sized(left, right, pairs, spare, 8);
		break;
	case 16:
		reverse_sized(left, right, pairs, spare, 16);
		break;
	default:
		reverse_sized(left, right, pairs, spare, sort->size);
	}
}

/* sort_serial for elements that may be in order already, or in reverse. */
static void sort_chunk(const sorting *sort, byte *from, byte *to, size_t count, bool across)
{
	chunk_order order = order_of(sort, from, count);
	if (order == MIXED) {
		sort_serial(sort, from, to, count, across);
		return;
	}
	if (order == DESCENDING)
		reverse(sort, from, from + count * sort->size, count / 2, to);
	if (across)
		memcpy(to, from, count * sort->size);
}

/* ---- all threads ----------------------------------------------------------------------------------------------- */

/* The first element of run number i of `runs`. Halves of halves: two neighbours of 2 * runs make a run of these. The
 * product does not overflow: there are 2^13 runs at most, and no object has over 2^47 bytes. */
static size_t run_begin(const sorting *sort, uint32_t i, uint32_t runs)
{
	return sort->count * i / runs;
}

/* Finds out whether chunks are in order or in reverse, each together with the first element of the next one. */
static void look_at_chunks(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	sorting *sort = context;
	(void)worker;
	for (uint32_t i = begin; i < end; i++) {
		bool ascending = atomic_load_explicit(&sort->ascending, memory_order_relaxed); /* see the fields, all */
		bool descending = atomic_load_explicit(&sort->descending, memory_order_relaxed);
		if (!ascending && !descending)
			return;
		size_t first = run_begin(sort, i, sort->runs), last = run_begin(sort, i + 1, sort->runs);
		chunk_order order = order_of(sort, sort->from + first * sort->size, last - first + (last < sort->count));
		if (ascending && order != ASCENDING)
			atomic_store_explicit(&sort->ascending, false, memory_order_relaxed);
		if (descending && order != DESCENDING)
			atomic_store_explicit(&sort->descending, false, memory_order_relaxed);
	}
}

/* Reverses the whole array, each slice as many pairs as half a chunk has elements. */
static void reverse_chunks(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const sorting *sort = context;
	size_t pairs = sort->count / 2;
	(void)worker;
	for (uint32_t i = begin; i < end; i++) {
		size_t first = pairs * i / sort->runs, last = pairs * (i + 1) / sort->runs;
		reverse(sort, sort->from + first * sort->size, sort->from + (sort->count - first) * sort->size, last - first,
		        sort->to + first * sort->size);
	}
}

static void sort_chunks(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const sorting *sort = context;
	(void)worker;
	for (uint32_t i = begin; i < end; i++) {
		size_t first = run_begin(sort, i, sort->runs), last = run_begin(sort, i + 1, sort->runs);
		sort_chunk(sort, sort->from + first * sort->size, sort->to + first * sort->size, last - first, sort->across);
	}
}

/* Cuts a merge in two halves that do not depend on each other, and returns one. How many of the first elements come
 * from the left run is found by halving; among equals those of the left run come first. Whatever compare returns, the
 * halves are parts of the merge and share no element. Source: Odeh, Green, Mwassi, Shmueli, Birk, "Merge Path: Parallel
 * Merging Made Simple", IPDPS Workshops 2012. */
static merge half_of(const sorting *sort, merge m, bool second)
{
	size_t first = (m.left_count + m.right_count) / 2; /* elements of the first half */
	size_t least = first > m.right_count ? first - m.right_count : 0;
	size_t most = first < m.left_count ? first : m.left_count;
	while (least < most) {
		size_t middle = (least + most) / 2;
		const byte *left = m.left + middle * sort->size, *right = m.right + (first - middle - 1) * sort->size;
		if (sort->compare(left, right, sort->context) <= 0)
			least = middle + 1;
		else
			most = middle;
	}
	size_t from_left = least, from_right = first - least;
	if (!second)
		return (merge){m.left, m.right, from_left, from_right, m.to};
	return (merge){m.left + from_left * sort->size, m.right + from_right * sort->size, m.left_count - from_left,
	               m.right_count - from_right, m.to + first * sort->size};
}

/* Merges one piece of a pair: all pieces of a pair halve it in the same way, each as far as itself. */
static void merge_pieces(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const sorting *sort = context;
	(void)worker;
	for (uint32_t i = begin; i < end; i++) {
		uint32_t run = i / sort->pieces * 2;
		size_t left = run_begin(sort, run, sort->runs), right = run_begin(sort, run + 1, sort->runs);
		merge piece = {sort->from + left * sort->size, sort->from + right * sort->size, right - left,
		               run_begin(sort, run + 2, sort->runs) - right, sort->to + left * sort->size};
		for (uint32_t bit = sort->pieces / 2; bit > 0; bit /= 2)
			piece = half_of(sort, piece, i & bit);
		merge_runs(sort, piece);
	}
}

/* A power of two: CHUNKS_A_THREAD for each thread, or up to twice as many, unless chunks would be smaller than
 * JOB_SORT_CHUNK; one for one thread. */
static uint32_t chunks_of(size_t count, uint32_t threads)
{
	uint32_t chunks = 1;
	while (threads > 1 && chunks < threads * CHUNKS_A_THREAD && count / chunks / 2 >= JOB_SORT_CHUNK)
		chunks *= 2;
	return chunks;
}

/* Brings an array into order that is in order already or in reverse; false if it is neither. */
static bool sort_ordered(stilb_job_pool *pool, sorting *sort, uint32_t worker)
{
	atomic_init(&sort->ascending, true);
	atomic_init(&sort->descending, true);
	stilb_job_parallel_for(pool, sort->runs, 1, look_at_chunks, sort, worker);
	bool descending = atomic_load_explicit(&sort->descending, memory_order_relaxed); /* see the fields */
	if (descending)
		stilb_job_parallel_for(pool, sort->runs, 1, reverse_chunks, sort, worker);
	return descending || atomic_load_explicit(&sort->ascending, memory_order_relaxed);
}

static void sort_parallel(stilb_job_pool *pool, sorting *sort, byte *base, byte *copy, uint32_t worker)
{
	uint32_t chunks = sort->runs;
	sort->from = base;
	sort->to = copy;
	if (sort_ordered(pool, sort, worker))
		return;
	for (uint32_t runs = chunks; runs > 1; runs /= 2) /* each pass changes sides, the last one ends in base */
		sort->across = !sort->across;
	stilb_job_parallel_for(pool, chunks, 1, sort_chunks, sort, worker);
	sort->from = sort->across ? copy : base;
	sort->to = sort->across ? base : copy;
	for (; sort->runs > 1; sort->runs /= 2) {
		sort->pieces = chunks / (sort->runs / 2);
		stilb_job_parallel_for(pool, chunks, 1, merge_pieces, sort, worker);
		byte *sorted = sort->to;
		sort->to = sort->from;
		sort->from = sorted;
	}
	assert(sort->from == base && "the last pass ends in the caller's array");
}

int stilb_job_sort(stilb_job_pool *pool, void *base, size_t count, size_t size, stilb_job_compare_fn *compare,
                   void *context, uint32_t worker)
{
	assert(pool && compare && (base || count == 0));
	assert(size > 0 && "an element has a size");
	assert(count <= PTRDIFF_MAX / size && "the array is an object");
	if (count < 2)
		return 0;
	alignas(JOB_LINE) byte stack[STILB_JOB_SORT_STACK];
	byte *block = NULL;
	if (count * size > sizeof stack) {
		block = job_allocate(job_pool_memory(pool), count * size, JOB_LINE);
		if (!block)
			return -ENOMEM;
	}
	byte *copy = block ? block : stack;
	sorting sort = {.compare = compare, .context = context, .count = count, .size = size};
	sort.runs = chunks_of(count, stilb_job_pool_worker_count(pool) + 1);
	if (sort.runs == 1)
		sort_chunk(&sort, base, copy, count, false);
	else
		sort_parallel(pool, &sort, base, copy, worker);
	job_release(job_pool_memory(pool), block, count * size);
	return 0;
}
