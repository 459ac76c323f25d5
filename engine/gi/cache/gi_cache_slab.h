/*
 * gi_cache_slab: items of one size that stay where they are, taken one by one by any thread without a lock and given
 * back all at once. [any-thread] but for init and finish.
 */
#ifndef STILB_GI_CACHE_SLAB_H
#define STILB_GI_CACHE_SLAB_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define GI_CACHE_SLAB_FIRST 1024u /* items in the first block; every other is twice as large as the one before */
#define GI_CACHE_SLAB_BLOCKS 20u

typedef struct gi_cache_slab {
	size_t size; /* of an item, a multiple of 16 */
	_Atomic(char *) blocks[GI_CACHE_SLAB_BLOCKS];
	atomic_uint taken;
} gi_cache_slab;

void gi_cache_slab_init(gi_cache_slab *slab, size_t size);
void gi_cache_slab_finish(gi_cache_slab *slab);

/* All bytes 0. NULL: no memory is left; the item is lost. */
void *gi_cache_slab_take(gi_cache_slab *slab);

/* How many were taken or lost. */
uint32_t gi_cache_slab_count(const gi_cache_slab *slab);

/* i < count; NULL: it was lost. Whoever took it has finished with it. */
void *gi_cache_slab_item(const gi_cache_slab *slab, uint32_t i);

#endif
