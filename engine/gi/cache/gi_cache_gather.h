/* gi_cache_gather: makes a record of the irradiance cache: traces a ray through every cell of the hemisphere above a
 * surface and sums the light that they find. */
#ifndef STILB_GI_CACHE_GATHER_H
#define STILB_GI_CACHE_GATHER_H

#include "gi/cache/gi_cache.h"

/* Makes a record at a surface; does not add it to the cache. point: the random numbers, of which each ray takes a
 * branch (gi_sampler_branch). worker < cache->worker_count: whose memory is used; only one thread at a time may use it.
 * [any-thread] */
gi_cache_record gi_cache_gather(gi_cache *cache, uint32_t worker, const gi_surface *surface, gi_point point);

#endif
