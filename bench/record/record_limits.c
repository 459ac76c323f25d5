/* References of the suite `record`, with which the engine's recording and sorting are compared: writing the memory of a
 * list of draws in a loop, a radix sort, one atomic add for each draw, one malloc for each draw. */
#include "bench/record/record_child.h"

#include <stdatomic.h>
#if defined(__SSE2__)
#include <emmintrin.h>
#endif

/* As large as the two things that the engine writes for a draw, its command and its row (with the transform); the
 * content does not matter here. */
typedef struct limit_command {
	uint64_t key;
	uint32_t words[6];
} limit_command;

typedef struct limit_row {
	float m[16];
} limit_row;

static_assert(sizeof(limit_command) == 32 && sizeof(limit_row) == 64, "96 bytes a draw");

typedef struct limit_entry {
	uint64_t key;
	uint32_t sequence;
} limit_entry;

typedef struct limit_work {
	uint32_t count; /* draws */
	limit_row *source, *rows;
	limit_command *commands;
	limit_entry *entries, *sorted, *scratch;
	_Atomic uint64_t *word; /* relaxed: a count, which orders nothing */
} limit_work;

/* ---- writing ----------------------------------------------------------------------------------------------------- */

static inline limit_command command_make(uint32_t i)
{
	return (limit_command){i, {i, i & 1, i * 3, 960, i & 3, 1}};
}

/* Writes one command and one row for each draw. */
static void write_hot(limit_work *work)
{
	const limit_row *restrict source = work->source;
	limit_row *restrict rows = work->rows;
	limit_command *restrict commands = work->commands;
	for (uint32_t i = 0; i < work->count; i++) {
		rows[i] = source[i];
		commands[i] = command_make(i);
	}
}

/* Writes rows by non-temporal stores of whole cache lines, since only the GPU will read them. Commands are half a cache
 * line each, for which such stores would take five times as long. */
static void write_non_temporal(limit_work *work)
{
#if defined(__SSE2__)
	const limit_row *restrict source = work->source;
	limit_row *restrict rows = work->rows;
	limit_command *restrict commands = work->commands;
	for (uint32_t i = 0; i < work->count; i++) {
		for (int k = 0; k < 16; k += 4)
			_mm_stream_ps(rows[i].m + k, _mm_load_ps(source[i].m + k));
		commands[i] = command_make(i);
	}
	_mm_sfence();
#else
	write_hot(work);
#endif
}

static void check_written(const limit_work *work)
{
	for (uint32_t i = 0; i < work->count; i++) {
		limit_command command = command_make(i);
		if (memcmp(&work->rows[i], &work->source[i], sizeof *work->rows) != 0 ||
		    memcmp(&work->commands[i], &command, sizeof command) != 0)
			bench_child_fail("wrong result: draw %u was not written", i);
	}
}

/* ---- sorting ----------------------------------------------------------------------------------------------------- */

#define RADIX 256u

/* One pass of a stable radix sort by byte `digit`; counts[v] is the number of entries with the value v. */
static void radix_pass(const limit_entry *from, limit_entry *to, uint32_t count, uint32_t digit, const uint32_t *counts)
{
	uint32_t place[RADIX], sum = 0;
	for (uint32_t v = 0; v < RADIX; v++) {
		place[v] = sum;
		sum += counts[v];
	}
	for (uint32_t i = 0; i < count; i++)
		to[place[from[i].key >> (8 * digit) & (RADIX - 1)]++] = from[i];
}

/* Sorts by the three bytes of the keys that are used, lowest first. */
static void sort_radix(limit_work *work)
{
	uint32_t counts[3][RADIX] = {0};
	for (uint32_t i = 0; i < work->count; i++)
		for (uint32_t d = 0; d < 3; d++)
			counts[d][work->entries[i].key >> (8 * d) & (RADIX - 1)]++;
	radix_pass(work->entries, work->sorted, work->count, 0, counts[0]);
	radix_pass(work->sorted, work->scratch, work->count, 1, counts[1]);
	radix_pass(work->scratch, work->sorted, work->count, 2, counts[2]);
}

static void check_sorted(const limit_work *work)
{
	for (uint32_t i = 1; i < work->count; i++) {
		const limit_entry *a = &work->sorted[i - 1], *b = &work->sorted[i];
		if (a->key > b->key || (a->key == b->key && a->sequence >= b->sequence))
			bench_child_fail("wrong result: draw %u is not in order", i);
	}
}

/* ---- costs that a list avoids ------------------------------------------------------------------------------------ */

static void add_atomic(limit_work *work)
{
	for (uint32_t i = 0; i < work->count; i++)
		atomic_fetch_add_explicit(work->word, 1, memory_order_relaxed);
}

static void check_added(const limit_work *work)
{
	if (atomic_load_explicit(work->word, memory_order_relaxed) % work->count != 0)
		bench_child_fail("wrong result: additions are missing");
}

static void allocate_each(limit_work *work)
{
	for (uint32_t i = 0; i < work->count; i++) {
		limit_command *command = malloc(sizeof(limit_command) + sizeof(limit_row));
		if (!command)
			bench_child_fail("out of memory");
		*command = command_make(i);
		__asm__ volatile("" ::"r"(command) : "memory"); /* else the compiler removes malloc and free */
		free(command);
	}
}

static void check_nothing(const limit_work *work)
{
	(void)work;
}

/* ---- the program ------------------------------------------------------------------------------------------------- */

static const struct limit {
	const char *name;
	void (*turn)(limit_work *work);
	void (*check)(const limit_work *work);
	const char *metric;
} limits[] = {
	{"write", write_hot, check_written, "record"}, {"write-non-temporal", write_non_temporal, check_written, "record"},
	{"atomic", add_atomic, check_added, "record"}, {"malloc", allocate_each, check_nothing, "record"},
	{"radix", sort_radix, check_sorted, "sort"},
};

static limit_work work_make(uint32_t count)
{
	limit_work work = {
		.count = count,
		.source = record_alloc(count, sizeof *work.source),
		.rows = record_alloc(count, sizeof *work.rows),
		.commands = record_alloc(count, sizeof *work.commands),
		.entries = record_alloc(count, sizeof *work.entries),
		.sorted = record_alloc(count, sizeof *work.sorted),
		.scratch = record_alloc(count, sizeof *work.scratch),
		.word = record_alloc(1, sizeof *work.word),
	};
	atomic_init(work.word, 0);
	for (uint32_t i = 0; i < count; i++) {
		for (uint32_t k = 0; k < 16; k++)
			work.source[i].m[k] = (float)(i + k);
		work.entries[i] = (limit_entry){stilb_random_u64(1, i) & 0xffffff, i};
	}
	return work;
}

static void work_finish(limit_work *work)
{
	free(work->source);
	free(work->rows);
	free(work->commands);
	free(work->entries);
	free(work->sorted);
	free(work->scratch);
	free((void *)work->word);
}

int main(int argc, char **argv)
{
	static record_samples times;
	bench_child child = bench_child_args(argc, argv);
	const record_case *on = record_case_find(child.case_name);
	const struct limit *limit = limits, *end = limits + sizeof limits / sizeof *limits;
	while (limit < end && strcmp(limit->name, child.subject) != 0)
		limit++;
	if (limit == end)
		bench_child_fail("no subject %s", child.subject);
	limit_work work = work_make(2 * on->models);
	limit->turn(&work); /* not measured, since it takes the page faults */
	for (uint64_t until = record_deadline(child.seconds), now = 0; now < until || times.count < 3;) {
		uint64_t begin = bench_child_now_ns();
		limit->turn(&work);
		now = bench_child_now_ns();
		record_samples_add(&times, now - begin);
	}
	limit->check(&work);
	bench_child_metric(limit->metric, record_samples_median(&times) / work.count);
	work_finish(&work);
	return 0;
}
