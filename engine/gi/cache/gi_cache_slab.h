/*
 * gi_cache_slab: an allocator of items of one size, which stay where they are and are freed all at once. Any thread
 * takes items, without a lock. [any-thread] except init and finish.
 */
#ifndef STILB_GI_CACHE_SLAB_H
#define STILB_GI_CACHE_SLAB_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define GI_CACHE_SLAB_FIRST 1024u /* items in the first block; each further block has twice as many */
#define GI_CACHE_SLAB_BLOCKS 20u

typedef struct gi_cache_slab {
	size_t size; /* of an item, a multiple of 16 */
	_Atomic(char *) blocks[GI_CACHE_SLAB_BLOCKS];
	atomic_uint taken;
} gi_cache_slab;

void gi_cache_slab_init(gi_cache_slab *slab, size_t size);
void gi_cache_slab_finish(gi_cache_slab *slab);

/* Takes the next item, all bytes 0. NULL: no memory; the item's number is used up, and the item is lost. */
void *gi_cache_slab_take(gi_cache_slab *slab);

/* Number of items taken, lost ones included. */
uint32_t gi_cache_slab_count(const gi_cache_slab *slab);

/* Item i < count; NULL: it was lost. Only when its taker has finished writing it. */
void *gi_cache_slab_item(const gi_cache_slab *slab, uint32_t i);

#endif
