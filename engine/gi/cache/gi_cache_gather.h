/* gi_cache_gather: makes a record: rays through every cell of the hemisphere above a surface, and what they bring. */
#ifndef STILB_GI_CACHE_GATHER_H
#define STILB_GI_CACHE_GATHER_H

#include "gi/cache/gi_cache.h"

/* A record at a surface; it is not added to the cache. point: its random numbers are branches of it.
 * worker < cache->worker_count. [any-thread], one thread a worker. */
gi_cache_record gi_cache_gather(gi_cache *cache, uint32_t worker, const gi_surface *surface, gi_point point);

#endif
