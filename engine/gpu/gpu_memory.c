/* gpu: blocks of device memory. */
#include "gpu/gpu_memory_internal.h"

#include <stdlib.h>

bool gpu_memory_init(gpu_memory *memory, gpu_memory_source source)
{
	*memory = (gpu_memory){.source = source};
	memory->lock_made = stilb_lock_init(&memory->lock);
	for (uint32_t pool = 0; pool < GPU_MEMORY_POOLS; pool++)
		memory->pools[pool].most = GPU_MEMORY_BLOCK;
	return memory->lock_made;
}

void gpu_memory_pool_set(gpu_memory *memory, uint32_t pool, uint64_t heap_bytes)
{
	STILB_ASSERT(pool < GPU_MEMORY_POOLS);
	uint64_t most = GPU_MEMORY_BLOCK;
	while (most > heap_bytes / 16 && most > GPU_TLSF_UNIT)
		most /= 2;
	memory->pools[pool].most = most;
}

static void block_drop(gpu_memory *memory, gpu_memory_pool *pool, gpu_memory_block *block)
{
	memory->source.drop(memory->source.user, block->handle);
	gpu_tlsf_finish(&block->tlsf);
	*block = (gpu_memory_block){0};
	pool->made--;
}

void gpu_memory_finish(gpu_memory *memory)
{
	STILB_ASSERT(memory->allocations == 0 && "everything was given back");
	for (uint32_t p = 0; p < GPU_MEMORY_POOLS; p++) {
		gpu_memory_pool *pool = &memory->pools[p];
		for (uint32_t b = 0; b < pool->count; b++)
			if (pool->blocks[b].bytes > 0)
				block_drop(memory, pool, &pool->blocks[b]);
		free(pool->blocks);
	}
	if (memory->lock_made)
		stilb_lock_finish(&memory->lock);
	*memory = (gpu_memory){0};
}

/* ---- taking ------------------------------------------------------------------------------------------------------ */

/* An unused element for a block; NULL: no memory. */
static gpu_memory_block *pool_element(gpu_memory_pool *pool)
{
	for (uint32_t b = 0; b < pool->count; b++)
		if (pool->blocks[b].bytes == 0)
			return &pool->blocks[b];
	if (pool->count == pool->capacity) {
		uint32_t larger = pool->capacity ? pool->capacity * 2 : 4;
		gpu_memory_block *grown = realloc(pool->blocks, larger * sizeof *grown);
		if (!grown)
			return NULL;
		pool->blocks = grown;
		pool->capacity = larger;
	}
	pool->blocks[pool->count] = (gpu_memory_block){0};
	return &pool->blocks[pool->count++];
}

/* Bytes of a pool's next block, in which something of so many bytes fits. */
static uint64_t pool_next_bytes(const gpu_memory_pool *pool, uint64_t bytes)
{
	uint64_t next = GPU_MEMORY_FIRST_BLOCK;
	for (uint32_t b = 0; b < pool->made && next < pool->most; b++)
		next *= 2;
	while (next < 2 * bytes)
		next *= 2;
	return next < pool->most ? next : pool->most;
}

/* A new block of a pool, as large as it should be, or smaller if the driver has no more. */
static int32_t pool_grow(gpu_memory *memory, uint32_t index, uint64_t bytes, uint64_t align)
{
	gpu_memory_pool *pool = &memory->pools[index];
	gpu_memory_block *block = pool_element(pool);
	if (!block)
		return memory->source.no_memory;
	uint64_t least = bytes + align, next = pool_next_bytes(pool, bytes);
	int32_t result = memory->source.make(memory->source.user, index, next, &block->handle);
	while (result != 0 && next / 2 >= least && next / 2 >= GPU_TLSF_UNIT) {
		next /= 2;
		result = memory->source.make(memory->source.user, index, next, &block->handle);
	}
	if (result != 0)
		return result;
	if (!gpu_tlsf_create(&block->tlsf, next)) {
		memory->source.drop(memory->source.user, block->handle);
		block->handle = (gpu_memory_handle){0};
		return memory->source.no_memory;
	}
	block->bytes = next;
	pool->made++;
	return 0;
}

static bool pool_take(gpu_memory_pool *pool, uint64_t bytes, uint64_t align, gpu_memory_place *place)
{
	for (uint32_t b = pool->count; b-- > 0;) {
		gpu_memory_block *block = &pool->blocks[b];
		if (block->bytes == 0)
			continue;
		uint64_t offset;
		uint32_t range = gpu_tlsf_take(&block->tlsf, bytes, align, &offset);
		if (range == GPU_TLSF_NONE)
			continue;
		place->handle = block->handle;
		place->offset = offset;
		place->mapped = block->handle.mapped ? (uint8_t *)block->handle.mapped + offset : NULL;
		place->block = b;
		place->range = range;
		return true;
	}
	return false;
}

/* Memory of its own. */
static int32_t memory_take_alone(gpu_memory *memory, uint32_t pool, uint64_t bytes, gpu_memory_place *place)
{
	int32_t result = memory->source.make(memory->source.user, pool, bytes, &place->handle);
	if (result != 0)
		return result;
	place->block = GPU_TLSF_NONE;
	place->mapped = place->handle.mapped;
	memory->alone++;
	memory->alone_bytes += bytes;
	return 0;
}

int32_t gpu_memory_take(gpu_memory *memory, uint32_t pool, uint64_t bytes, uint64_t align, gpu_memory_place *place)
{
	STILB_ASSERT(pool < GPU_MEMORY_POOLS && bytes > 0 && align > 0 && (align & (align - 1)) == 0);
	*place = (gpu_memory_place){.pool = pool, .bytes = bytes};
	stilb_lock_take(&memory->lock);
	int32_t result = 0;
	gpu_memory_pool *from = &memory->pools[pool];
	if (bytes > from->most / 2 || align > from->most / 4)
		result = memory_take_alone(memory, pool, bytes, place);
	else if (!pool_take(from, bytes, align, place)) {
		result = pool_grow(memory, pool, bytes, align);
		if (result == 0 && !pool_take(from, bytes, align, place))
			result = memory->source.no_memory; /* for the array of ranges */
	}
	if (result == 0) {
		memory->used_bytes += bytes;
		memory->allocations++;
	} else
		*place = (gpu_memory_place){0};
	stilb_lock_give(&memory->lock);
	return result;
}

/* ---- giving ------------------------------------------------------------------------------------------------------ */

/* Drops a block that has become empty if the pool has another empty one. */
static void pool_tidy(gpu_memory *memory, gpu_memory_pool *pool, gpu_memory_block *emptied)
{
	for (uint32_t b = 0; b < pool->count; b++) {
		gpu_memory_block *block = &pool->blocks[b];
		if (block != emptied && block->bytes > 0 && block->tlsf.used_ranges == 0) {
			block_drop(memory, pool, block->bytes < emptied->bytes ? block : emptied);
			return;
		}
	}
}

void gpu_memory_give(gpu_memory *memory, gpu_memory_place *place)
{
	if (place->bytes == 0)
		return;
	stilb_lock_take(&memory->lock);
	gpu_memory_pool *pool = &memory->pools[place->pool];
	memory->used_bytes -= place->bytes;
	memory->allocations--;
	if (place->block == GPU_TLSF_NONE) {
		memory->source.drop(memory->source.user, place->handle);
		memory->alone--;
		memory->alone_bytes -= place->bytes;
	} else {
		gpu_memory_block *block = &pool->blocks[place->block];
		gpu_tlsf_give(&block->tlsf, place->range);
		if (block->tlsf.used_ranges == 0)
			pool_tidy(memory, pool, block);
	}
	stilb_lock_give(&memory->lock);
	*place = (gpu_memory_place){0};
}

stilb_gpu_memory_report gpu_memory_measure(gpu_memory *memory)
{
	stilb_lock_take(&memory->lock);
	stilb_gpu_memory_report report = {
		.blocks = memory->alone,
		.block_bytes = memory->alone_bytes,
		.used_bytes = memory->used_bytes,
		.allocations = memory->allocations,
	};
	uint64_t free_bytes = 0;
	for (uint32_t p = 0; p < GPU_MEMORY_POOLS; p++)
		for (uint32_t b = 0; b < memory->pools[p].count; b++) {
			const gpu_memory_block *block = &memory->pools[p].blocks[b];
			if (block->bytes == 0)
				continue;
			uint64_t largest = gpu_tlsf_largest(&block->tlsf);
			report.blocks++;
			report.block_bytes += block->bytes;
			report.largest_free_bytes = largest > report.largest_free_bytes ? largest : report.largest_free_bytes;
			free_bytes += (uint64_t)block->tlsf.free_units * GPU_TLSF_UNIT;
		}
	stilb_lock_give(&memory->lock);
	report.fragmentation = free_bytes > 0 ? 1.0 - (double)report.largest_free_bytes / (double)free_bytes : 0.0;
	return report;
}
