/* The frame's part: gathers what all threads have drawn, sorts it by what it is, so that nothing depends on who drew
 * when, and writes it for the device. */
#include "debug/debug_internal.h"
#include "jobs/range/job_sort.h"
#include "profiler/prof.h"
#include "render/device/render_images.h"

#include <stdio.h>
#include <string.h>

#define FRAME_SLICE 16384u                   /* records that a job copies */
#define FRAME_MOST ((uint32_t)INT32_MAX / 4) /* records: their vertices are numbered */

static stilb_result frame_no_memory(void)
{
	return stilb_fail(STILB_ERROR_MEMORY, "no memory for debug drawing; draw fewer lines");
}

/* ---- what stays -------------------------------------------------------------------------------------------------- */

/* Adds what stays from now on; false: no memory. */
static bool frame_keep(stilb_debug *debug, double now)
{
	const debug_blocks *stays = &debug->stays;
	uint64_t count = debug->kept_count;
	for (uint32_t b = 0; b < stays->count; b++)
		count += stays->blocks[b].count / 2;
	if (!debug_reserve((void **)&debug->kept, &debug->kept_capacity, count, sizeof *debug->kept) ||
	    !debug_reserve((void **)&debug->ends, &debug->ends_capacity, count, sizeof *debug->ends))
		return false;
	for (uint32_t b = 0; b < stays->count; b++)
		for (const debug_record *r = stays->blocks[b].records, *end = r + stays->blocks[b].count; r < end; r += 2) {
			debug->kept[debug->kept_count] = r[0];
			debug->ends[debug->kept_count++] = now + (double)r[1].from[0];
		}
	return true;
}

static void frame_expire(stilb_debug *debug, double now)
{
	uint32_t kept = 0;
	for (uint32_t r = 0; r < debug->kept_count; r++) {
		if (!(debug->ends[r] > now))
			continue;
		debug->kept[kept] = debug->kept[r];
		debug->ends[kept++] = debug->ends[r];
	}
	debug->kept_count = kept;
}

/* ---- order ------------------------------------------------------------------------------------------------------- */

/* Adds what stays to the frame's blocks, counts their records, and makes room for sorting them; false: no memory. */
static bool frame_count(stilb_debug *debug)
{
	debug_blocks *once = &debug->once;
	uint64_t count = 0;
	for (uint32_t r = 0; r < debug->kept_count; r += DEBUG_CHUNK) {
		uint32_t some = debug->kept_count - r < DEBUG_CHUNK ? debug->kept_count - r : DEBUG_CHUNK;
		if (!debug_blocks_add(once, debug->kept + r, some))
			return false;
	}
	for (uint32_t b = 0; b < once->count && count <= FRAME_MOST; b++) {
		once->blocks[b].first = (uint32_t)count;
		count += once->blocks[b].count;
	}
	if (count > FRAME_MOST ||
	    !debug_reserve((void **)&debug->items, &debug->item_capacity, count, sizeof *debug->items) ||
	    !debug_reserve((void **)&debug->spare, &debug->spare_capacity, count, sizeof *debug->spare))
		return false;
	debug->count = (uint32_t)count;
	return true;
}

static const debug_record *frame_record(const stilb_debug *debug, debug_item item)
{
	uint32_t index = (uint32_t)item;
	return debug->once.blocks[index >> DEBUG_CHUNK_BITS].records + (index & (DEBUG_CHUNK - 1));
}

/* What is drawn later has the larger key: by the word's two highest bits, then the nearer one, then letters after the
 * halos of their text. */
static uint32_t frame_key(const float depth[4], const debug_record *record)
{
	float x = record->from[0], y = record->from[1], z = record->from[2];
	if (!(record->word & DEBUG_LETTER)) {
		x = 0.5f * (x + record->to[0]);
		y = 0.5f * (y + record->to[1]);
		z = 0.5f * (z + record->to[2]);
	}
	float far = depth[0] * x + depth[1] * y + depth[2] * z + depth[3];
	uint32_t bits = 0;
	if (far > 0.0f)
		memcpy(&bits, &far, sizeof bits); /* positive floats are ordered as their bits are */
	uint32_t near = 0x1fffffffu - (bits >> 2);
	return (record->word & (DEBUG_ON_TOP | DEBUG_LETTER)) | near << 1 | !(record->word & DEBUG_HALO);
}

/* Writes the items of blocks begin .. end - 1. */
static void frame_slice_keys(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	stilb_debug *debug = context;
	const float *m = debug->views[0].view_projection.m;
	const float depth[4] = {m[3], m[7], m[11], m[15]};
	(void)worker;
	for (uint32_t b = begin; b < end; b++) {
		const debug_block *block = &debug->once.blocks[b];
		for (uint32_t r = 0; r < block->count; r++)
			debug->items[block->first + r] =
				(debug_item)frame_key(depth, &block->records[r]) << 32 | (b << DEBUG_CHUNK_BITS) | r;
	}
}

#define RADIX_BITS 11u
#define RADIX (1u << RADIX_BITS)
#define RADIX_PASSES 3u

/* Sorts items[0 .. count - 1] by their keys, a few bits at a time, from the lowest: each pass keeps the order of the
 * one before. spare: as many, which are overwritten. */
static void frame_sort(debug_item *items, debug_item *spare, uint32_t count)
{
	static_assert(RADIX_PASSES * RADIX_BITS >= 32, "all of the key");
	uint32_t places[RADIX_PASSES][RADIX] = {{0}};
	debug_item *from = items, *to = spare;
	for (uint32_t i = 0; i < count; i++)
		for (uint32_t p = 0; p < RADIX_PASSES; p++)
			places[p][items[i] >> (32 + p * RADIX_BITS) & (RADIX - 1)]++;
	for (uint32_t p = 0; p < RADIX_PASSES; p++) {
		uint32_t sum = 0, shift = 32 + p * RADIX_BITS;
		for (uint32_t d = 0; d < RADIX; d++) {
			uint32_t some = places[p][d];
			places[p][d] = sum;
			sum += some;
		}
		for (uint32_t i = 0; i < count; i++)
			to[places[p][from[i] >> shift & (RADIX - 1)]++] = from[i];
		debug_item *other = from;
		from = to;
		to = other;
	}
	if (from != items)
		memcpy(items, from, count * sizeof *items);
}

static int frame_compare(const void *a, const void *b, void *context)
{
	const stilb_debug *debug = context;
	return memcmp(frame_record(debug, *(const debug_item *)a), frame_record(debug, *(const debug_item *)b),
	              sizeof(debug_record));
}

/* The end of the items that have the key of item `first`. */
static uint32_t frame_equal(const debug_item *items, uint32_t first, uint32_t count)
{
	uint32_t end = first + 1;
	while (end < count && items[end] >> 32 == items[first] >> 32)
		end++;
	return end;
}

/* Orders items of equal keys by their bytes. */
static stilb_result frame_sort_bytes(stilb_debug *debug, debug_item *items, uint32_t count, stilb_job_pool *pool,
                                     uint32_t worker)
{
	for (uint32_t first = 0, end; first < count; first = end) {
		end = frame_equal(items, first, count);
		if (end - first > 1 &&
		    stilb_job_sort(pool, items + first, end - first, sizeof *items, frame_compare, debug, worker) != 0)
			return frame_no_memory();
	}
	return STILB_OK;
}

#define FRAME_HASHED 64u /* so many of an equal key or more are sorted by a hash first: bytes are far away in memory */

/* Gives items the hash of their records as keys, and sorts them by that. */
static void frame_sort_hash(stilb_debug *debug, debug_item *items, uint32_t count)
{
	for (uint32_t i = 0; i < count; i++) {
		uint64_t words[4], hash = 0;
		memcpy(words, frame_record(debug, items[i]), sizeof words);
		for (int w = 0; w < 4; w++)
			hash = ((hash ^ words[w]) * 0x9e3779b97f4a7c15u) ^ hash >> 29;
		items[i] = hash << 32 | (uint32_t)items[i];
	}
	frame_sort(items, debug->spare, count);
}

/* Orders items of equal keys by what they are, in any way that is the same each time. */
static stilb_result frame_sort_equal(stilb_debug *debug, stilb_job_pool *pool, uint32_t worker)
{
	stilb_result result = STILB_OK;
	for (uint32_t first = 0, end; first < debug->count && result == STILB_OK; first = end) {
		end = frame_equal(debug->items, first, debug->count);
		if (end - first >= FRAME_HASHED)
			frame_sort_hash(debug, debug->items + first, end - first);
		if (end - first > 1)
			result = frame_sort_bytes(debug, debug->items + first, end - first, pool, worker);
	}
	return result;
}

/* ---- the frame --------------------------------------------------------------------------------------------------- */

typedef struct frame_copy {
	const stilb_debug *debug;
	debug_record *to;
} frame_copy;

static void frame_slice_copy(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const frame_copy *copy = context;
	(void)worker;
	for (uint32_t i = begin; i < end; i++)
		copy->to[i] = *frame_record(copy->debug, copy->debug->items[i]);
}

static stilb_result frame_write(stilb_debug *debug, stilb_job_pool *pool, uint32_t worker)
{
	frame_copy copy = {.debug = debug};
	stilb_result result = debug_device_begin(debug, debug->count, &copy.to);
	if (result != STILB_OK)
		return result;
	stilb_job_parallel_for(pool, debug->once.count, 16, frame_slice_keys, debug, worker);
	{
		PROFILE("sort");
		frame_sort(debug->items, debug->spare, debug->count);
		result = frame_sort_equal(debug, pool, worker);
		if (result != STILB_OK)
			return result;
	}
	stilb_job_parallel_for(pool, debug->count, FRAME_SLICE, frame_slice_copy, &copy, worker);
	debug_device_end(debug, debug->count);
	return STILB_OK;
}

/* Notes the view, if the picture shows it. */
static void frame_view(stilb_debug *debug, const stilb_render_view *view)
{
	const stilb_render_target *target = view->target;
	if (target && (target->kind != STILB_RENDER_TARGET_LIGHT || target->place[2] == 0))
		return;
	debug_view *out = &debug->views[debug->view_count++];
	uint32_t width, height;
	stilb_render_size(debug->render, &width, &height);
	*out = (debug_view){.view_projection = view->view_projection,
	                    .depth = STILB_RENDER_IMAGE_DEPTH,
	                    .place = {0, 0, (uint16_t)width, (uint16_t)height}};
	if (!target)
		return;
	memcpy(out->place, target->place, sizeof out->place);
	out->border = target->border;
	if (strcmp(target->name, STILB_RENDER_IMAGE_COLOR) != 0)
		snprintf(out->depth, sizeof out->depth, "%s depth", target->name);
}

stilb_result stilb_debug_frame(stilb_debug *debug, const stilb_render_view *views, uint32_t view_count, double seconds,
                               stilb_job_pool *pool, uint32_t worker)
{
	STILB_ASSERT_OWNER(debug->owner);
	STILB_ASSERT(pool && view_count <= STILB_RENDER_MAX_PASSES && (views || view_count == 0));
	PROFILE("debug drawing");
	debug->view_count = 0;
	for (uint32_t v = 0; v < view_count; v++)
		frame_view(debug, &views[v]);
	debug->ready = false;
	debug->count = 0;
	frame_expire(debug, seconds);
	bool done = debug_take(debug) && frame_keep(debug, seconds) && (debug->view_count == 0 || frame_count(debug));
	/* Relaxed: see their declaration. */
	done &= !atomic_exchange_explicit(&debug->failed, false, memory_order_relaxed);
	bool too_many = atomic_exchange_explicit(&debug->too_many, false, memory_order_relaxed);
	stilb_result result = STILB_OK;
	if (too_many)
		result = stilb_fail(STILB_ERROR_THREAD, "debug drawing: more than %u threads draw; let some of them end first",
		                    STILB_DEBUG_THREADS);
	else if (!done)
		result = frame_no_memory();
	else if (debug->count > 0)
		result = frame_write(debug, pool, worker);
	debug_give(debug);
	return result;
}

uint32_t stilb_debug_count(const stilb_debug *debug)
{
	STILB_ASSERT_OWNER(debug->owner);
	return debug->count;
}
