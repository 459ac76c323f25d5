/* gi_cache_file: the records of an irradiance cache in a file, together with what they depend on (the scene and the
 * settings), so that they are never used for another scene. */
#ifndef STILB_GI_CACHE_FILE_H
#define STILB_GI_CACHE_FILE_H

#include "gi/cache/gi_cache.h"

/* Replaces the records by those of the file; on an error the cache keeps its own. While nobody else uses the cache.
 * STILB_ERROR_FILE: it cannot be read, is not a cache, is damaged, or belongs to another scene or other settings;
 * STILB_ERROR_MEMORY. */
stilb_result gi_cache_load(gi_cache *cache, const char *path);

/* Writes the records, whole or not at all. While nobody adds. STILB_ERROR_FILE; STILB_ERROR_MEMORY where memory ran out
 * while the cache was filled, so that it has gaps. */
stilb_result gi_cache_save(const gi_cache *cache, const char *path);

#endif
