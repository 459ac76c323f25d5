/*
 * base_cache: files of what takes long to make and is made again and again, such as levels of meshes: each under a hash
 * of all that it is made of, in the folder stilb/<name> of $XDG_CACHE_HOME, else of $HOME/.cache.
 *
 * A cache may be lost at any time, and its files may be damaged or somebody else's: the caller checks all that it
 * reads, with a checksum of its own. A file is whole or not there while the system runs; after a power cut it may be
 * anything, since waiting for the disk would take longer than making some of them. A full disk, a folder that cannot be
 * written, neither of the two variables, or STILB_CACHE=off in the environment only cost the time of the next run: no
 * function here has a message.
 *
 * Life cycle.  Key: stilb_cache_hash_start -> _add, any number -> _end. Reading: stilb_cache_open -> fread, fclose ->
 *              stilb_cache_used if it was good. Writing: stilb_cache_begin -> stilb_file_write, any number ->
 *              stilb_cache_end.
 * Threads.     [any-thread] Processes and threads may read and write the same file at the same time.
 */
#ifndef STILB_BASE_CACHE_H
#define STILB_BASE_CACHE_H

#include "base/base_file.h"

/* What the files of one kind have in common. */
typedef struct stilb_cache {
	const char *folder; /* the name of their folder, "levels" */
	const char *ending; /* of their names, ".levels"; at most 15 bytes */
	uint64_t most;      /* bytes: files that were not used for longest go beyond this */
} stilb_cache;

/* Four sums over words in turn. Each step can be undone, so that two contents which differ in one word have different
 * sums. About 3 bytes a nanosecond. */
typedef struct stilb_cache_hash {
	uint64_t lanes[4];
} stilb_cache_hash;

stilb_cache_hash stilb_cache_hash_start(void);

/* Adds bytes, and how many they are; data may be NULL if size is 0. */
void stilb_cache_hash_add(stilb_cache_hash *hash, const void *data, size_t size);

/* Each bit of the sums has a part in both numbers. */
void stilb_cache_hash_end(const stilb_cache_hash *hash, uint64_t key[2]);

/* Opens the file of this key for reading; the caller closes it with fclose. NULL: there is none. */
FILE *stilb_cache_open(const stilb_cache *cache, const uint64_t key[2]);

/* Notes that the file was used, so that others go before it. */
void stilb_cache_used(const stilb_cache *cache, const uint64_t key[2]);

/* Opens the file of this key for writing, and makes the folders that are missing. False: there can be none; file is {0}
 * then. */
bool stilb_cache_begin(const stilb_cache *cache, const uint64_t key[2], stilb_file *file);

/* Puts the file into its place, unless it is not whole or could not be written, and removes what is too much. */
void stilb_cache_end(const stilb_cache *cache, stilb_file *file, bool whole);

#endif
