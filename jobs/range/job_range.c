/* Loops over longer ranges and over tiles, as loops of job_for.c whose slices are ranges and tiles; and reductions. */
#include "jobs/range/job_range.h"

#include "jobs/job_allocate.h"

#include <assert.h>
#include <errno.h>
#include <stdalign.h>
#include <string.h>

/* ---- 64-bit ranges --------------------------------------------------------------------------------------------- */

/* So many slices of the 32-bit loop underneath are enough for any number of threads. Tests set fewer. */
#ifndef JOB_RANGE_PARTS
#define JOB_RANGE_PARTS ((uint64_t)1 << 31)
#endif

typedef struct range_loop {
	stilb_job_range_64_fn *fn;
	void *context;
	uint64_t count, grain;
	uint64_t slices, together; /* slices of the range, and how many of them make a part, a slice of the 32-bit loop */
} range_loop;

static void range_run(uint32_t part, uint32_t end, uint32_t worker, void *context)
{
	assert(end == part + 1 && "the loop of parts has grain 1");
	(void)end;
	const range_loop *loop = context;
	uint64_t slice = part * loop->together, slices = loop->slices - slice;
	uint64_t begin = slice * loop->grain;
	for (slices = slices < loop->together ? slices : loop->together; slices > 0; slices--, begin += loop->grain) {
		uint64_t left = loop->count - begin; /* begin has wrapped around only when it is not read any more */
		loop->fn(begin, begin + (left < loop->grain ? left : loop->grain), worker, loop->context);
	}
}

void stilb_job_parallel_for_64(stilb_job_pool *pool, uint64_t count, uint64_t grain, stilb_job_range_64_fn *fn,
                               void *context, uint32_t worker)
{
	assert(pool && fn);
	if (count == 0)
		return;
	range_loop loop = {.fn = fn, .context = context, .count = count, .grain = grain ? grain : 1};
	loop.slices = (count - 1) / loop.grain + 1;
	loop.together = (loop.slices - 1) / JOB_RANGE_PARTS + 1;
	stilb_job_parallel_for(pool, (uint32_t)((loop.slices - 1) / loop.together + 1), 1, range_run, &loop, worker);
}

/* ---- tiles ----------------------------------------------------------------------------------------------------- */

/* Tiles are ordered in bands of so many rows of tiles, column by column within a band: a run of 16 tiles is a square.
 * A band needs no power of two, has no holes, and a tile's place follows from its number by two divisions. Against one
 * row after another, on one thread of an AMD EPYC (family 25, model 17): a product of matrices of 1024 x 1024 floats in
 * tiles of 32 x 32 takes .92 of the time, a vertical blur of 4096 x 4096 as long, a transposition in tiles of 16 x 16
 * 1.06. */
#define BAND_ROWS 4

#define TILE_CHOSEN_MOST 64
#define TILE_CHOSEN_LEAST 8
#define TILES_A_THREAD 8 /* wanted at least, so that threads finish together */

typedef struct tile_loop {
	stilb_job_tile_fn *fn;
	void *context;
	uint32_t width, height, tile_width, tile_height;
	uint32_t columns, rows; /* of tiles */
} tile_loop;

static uint32_t tiles_of(uint32_t length, uint32_t tile)
{
	return (length - 1) / tile + 1;
}

static uint32_t end_of(uint32_t begin, uint32_t tile, uint32_t length)
{
	return length - begin < tile ? length : begin + tile;
}

static void tiles_run(uint64_t begin, uint64_t end, uint32_t worker, void *context)
{
	const tile_loop *loop = context;
	uint64_t band_tiles = (uint64_t)loop->columns * BAND_ROWS;
	for (uint64_t i = begin; i < end; i++) {
		uint32_t band = (uint32_t)(i / band_tiles) * BAND_ROWS; /* its first row of tiles */
		uint32_t rows = loop->rows - band < BAND_ROWS ? loop->rows - band : BAND_ROWS;
		uint64_t in_band = i % band_tiles;
		uint32_t x = (uint32_t)(in_band / rows) * loop->tile_width;
		uint32_t y = (band + (uint32_t)(in_band % rows)) * loop->tile_height;
		loop->fn((stilb_job_tile){x, end_of(x, loop->tile_width, loop->width), y,
		                          end_of(y, loop->tile_height, loop->height)},
		         worker, loop->context);
	}
}

/* Fills in the sides of tiles that the caller has left open. */
static void choose_tile(tile_loop *loop, uint32_t threads)
{
	uint32_t chosen = TILE_CHOSEN_MOST;
	for (; chosen > TILE_CHOSEN_LEAST; chosen /= 2) {
		uint64_t columns = tiles_of(loop->width, loop->tile_width ? loop->tile_width : chosen);
		if (columns * tiles_of(loop->height, loop->tile_height ? loop->tile_height : chosen) >=
		    (uint64_t)threads * TILES_A_THREAD)
			break;
	}
	loop->tile_width = loop->tile_width ? loop->tile_width : chosen;
	loop->tile_height = loop->tile_height ? loop->tile_height : chosen;
}

void stilb_job_parallel_for_tiles(stilb_job_pool *pool, uint32_t width, uint32_t height, uint32_t tile_width,
                                  uint32_t tile_height, stilb_job_tile_fn *fn, void *context, uint32_t worker)
{
	assert(pool && fn);
	if (width == 0 || height == 0)
		return;
	tile_loop loop = {.fn = fn,
	                  .context = context,
	                  .width = width,
	                  .height = height,
	                  .tile_width = tile_width,
	                  .tile_height = tile_height};
	choose_tile(&loop, stilb_job_pool_worker_count(pool) + 1);
	loop.columns = tiles_of(width, loop.tile_width);
	loop.rows = tiles_of(height, loop.tile_height);
	stilb_job_parallel_for_64(pool, (uint64_t)loop.columns * loop.rows, 1, tiles_run, &loop, worker);
}

/* ---- reductions ------------------------------------------------------------------------------------------------ */

/* Values up to this size are folded on the stack of the thread that does so, and copied to the others when complete:
 * values of neighbouring slices share cache lines. */
#define FOLD_APART 256

typedef struct reduce_loop {
	const stilb_job_reduction *reduction;
	unsigned char *values; /* of the slices from index `first` on */
	uint64_t count, grain, first;
} reduce_loop;

static void reduce_slice(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const reduce_loop *loop = context;
	const stilb_job_reduction *reduction = loop->reduction;
	size_t size = reduction->size;
	alignas(JOB_LINE) unsigned char apart[FOLD_APART];
	for (uint32_t i = begin; i < end; i++) {
		uint64_t from = (loop->first + i) * loop->grain, left = loop->count - from;
		unsigned char *stored = loop->values + i * size, *value = size <= sizeof apart ? apart : stored;
		memcpy(value, reduction->identity, size);
		reduction->fold(from, from + (left < loop->grain ? left : loop->grain), value, worker, reduction->context);
		if (value == apart)
			memcpy(stored, apart, size);
	}
}

/* Folds and combines as many slices at a time as there is memory for values. */
static void reduce_all(stilb_job_pool *pool, reduce_loop *loop, uint64_t slices, size_t values, void *result,
                       uint32_t worker)
{
	const stilb_job_reduction *reduction = loop->reduction;
	memcpy(result, reduction->identity, reduction->size);
	for (; loop->first < slices; loop->first += values) {
		uint64_t left = slices - loop->first;
		uint32_t here = (uint32_t)(left < values ? left : values);
		stilb_job_parallel_for(pool, here, 1, reduce_slice, loop, worker);
		for (uint32_t i = 0; i < here; i++)
			reduction->combine(result, loop->values + i * reduction->size, reduction->context);
	}
}

int stilb_job_reduce(stilb_job_pool *pool, uint64_t count, uint64_t grain, const stilb_job_reduction *reduction,
                     void *result, uint32_t worker)
{
	assert(pool && result);
	assert(reduction && reduction->fold && reduction->combine && reduction->identity && "a reduction is whole");
	assert(reduction->size > 0 && "a value has a size");
	uint64_t least = count / STILB_JOB_REDUCE_SLICES + (count % STILB_JOB_REDUCE_SLICES > 0);
	reduce_loop loop = {.reduction = reduction, .count = count, .grain = grain > least ? grain : least};
	uint64_t slices = count > 0 ? (count - 1) / loop.grain + 1 : 0;
	alignas(JOB_LINE) unsigned char stack[STILB_JOB_REDUCE_STACK];
	size_t values = sizeof stack / reduction->size;
	unsigned char *block = NULL;
	/* The product does not overflow: `identity` is an object of this size, and no object has over 2^47 bytes. */
	if (values < slices) {
		block = job_allocate(job_pool_memory(pool), slices * reduction->size, JOB_LINE);
		if (!block && values == 0)
			return -ENOMEM;
	}
	loop.values = block ? block : stack;
	reduce_all(pool, &loop, slices, block ? slices : values, result, worker);
	job_release(job_pool_memory(pool), block, slices * reduction->size);
	return 0;
}
