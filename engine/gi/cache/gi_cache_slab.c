#include "gi/cache/gi_cache_slab.h"

#include "base/base.h"

#include <stdlib.h>
#include <string.h>

void gi_cache_slab_init(gi_cache_slab *slab, size_t size)
{
	STILB_ASSERT(size > 0 && size % 16 == 0);
	*slab = (gi_cache_slab){.size = size};
}

void gi_cache_slab_finish(gi_cache_slab *slab)
{
	for (uint32_t i = 0; i < GI_CACHE_SLAB_BLOCKS; i++)
		free(atomic_load_explicit(&slab->blocks[i], memory_order_relaxed)); /* relaxed: no other thread uses it now */
}

/* The block that holds an item, and the item's index in it. Block b holds GI_CACHE_SLAB_FIRST << b items, so item /
 * FIRST + 1 has b + 1 bits. */
static uint32_t block_of(uint32_t item, uint32_t *place)
{
	uint32_t block = 31u - (uint32_t)__builtin_clz(item / GI_CACHE_SLAB_FIRST + 1u);
	*place = item - GI_CACHE_SLAB_FIRST * ((1u << block) - 1u);
	return block;
}

/* The block, allocated if nobody has done so yet; NULL: no memory. */
static char *block_want(gi_cache_slab *slab, uint32_t block)
{
	STILB_ASSERT(block < GI_CACHE_SLAB_BLOCKS);
	/* acquire: pairs with the release below, so that the block is seen zeroed */
	char *there = atomic_load_explicit(&slab->blocks[block], memory_order_acquire);
	if (there)
		return there;
	size_t bytes = slab->size * (GI_CACHE_SLAB_FIRST << block);
	char *made = stilb_memory_alloc(1, bytes);
	if (!made)
		return NULL;
	memset(made, 0, bytes);
	/* release: who sees the block sees its zeros. On failure another thread has allocated the block meanwhile, and that
	 * one is used: acquire as above. */
	if (atomic_compare_exchange_strong_explicit(&slab->blocks[block], &there, made, memory_order_release,
	                                            memory_order_acquire))
		return made;
	free(made);
	return there;
}

void *gi_cache_slab_take(gi_cache_slab *slab)
{
	STILB_ASSERT(slab->size > 0 && "after init");
	/* relaxed: all that matters is that each thread gets another number. A block is made visible by block_want, an
	 * item's contents by the thread that took and wrote it. */
	uint32_t item = atomic_load_explicit(&slab->taken, memory_order_relaxed);
	uint32_t place, block;
	do {
		block = block_of(item, &place);
		if (block >= GI_CACHE_SLAB_BLOCKS)
			return NULL;
	} while (!atomic_compare_exchange_weak_explicit(&slab->taken, &item, item + 1u, memory_order_relaxed,
	                                                memory_order_relaxed));
	char *there = block_want(slab, block);
	return there ? there + slab->size * place : NULL;
}

uint32_t gi_cache_slab_count(const gi_cache_slab *slab)
{
	/* relaxed: the callers display the number, where an old one does no harm, or call when no thread takes items */
	return atomic_load_explicit(&slab->taken, memory_order_relaxed);
}

void *gi_cache_slab_item(const gi_cache_slab *slab, uint32_t i)
{
	STILB_ASSERT(i < gi_cache_slab_count(slab));
	uint32_t place;
	uint32_t block = block_of(i, &place);
	/* acquire: pairs with the release in block_want, so that the block is seen zeroed or later */
	char *there = atomic_load_explicit(&slab->blocks[block], memory_order_acquire);
	return there ? there + slab->size * place : NULL;
}
