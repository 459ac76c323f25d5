/* Files of what takes long to make, by content. */
#include "base/base_cache.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define CACHE_KEY ((size_t)2 * 16)
#define CACHE_NAME (CACHE_KEY + 16) /* with the end */

/* ---- keys -------------------------------------------------------------------------------------------------------- */

#define CACHE_HASH_BLOCK 32u /* a word for each lane: the processor need not wait for one product before the next */

static uint64_t cache_mix(uint64_t sum, uint64_t word)
{
	sum = (sum ^ word) * 0x9e3779b97f4a7c15u;
	return sum ^ sum >> 32;
}

stilb_cache_hash stilb_cache_hash_start(void)
{
	return (stilb_cache_hash){{1, 2, 3, 4}};
}

void stilb_cache_hash_add(stilb_cache_hash *hash, const void *data, size_t size)
{
	STILB_ASSERT(hash && (data || size == 0));
	const unsigned char *from = data;
	uint64_t words[4];
	stilb_cache_hash sums = *hash;
	sums.lanes[0] = cache_mix(sums.lanes[0], size);
	for (size_t left = size; left > 0;) {
		size_t part = left < CACHE_HASH_BLOCK ? left : CACHE_HASH_BLOCK;
		if (part < CACHE_HASH_BLOCK)
			memset(words, 0, sizeof words);
		memcpy(words, from, part);
		for (int k = 0; k < 4; k++)
			sums.lanes[k] = cache_mix(sums.lanes[k], words[k]);
		from += part;
		left -= part;
	}
	*hash = sums;
}

void stilb_cache_hash_end(const stilb_cache_hash *hash, uint64_t key[2])
{
	key[0] = key[1] = 0;
	for (int k = 0; k < 4; k++) {
		key[0] = cache_mix(key[0], hash->lanes[k]);
		key[1] = cache_mix(key[1], hash->lanes[3 - k]);
	}
}

/* ---- places ------------------------------------------------------------------------------------------------------ */

/* Makes a folder, unless it is there. */
static bool cache_folder_make(const char *path)
{
	return mkdir(path, 0700) == 0 || errno == EEXIST;
}

/* The folder; with `make` it exists then. False: there can be none. */
static bool cache_folder(const stilb_cache *cache, char path[PATH_MAX], bool make)
{
	const char *base = getenv("XDG_CACHE_HOME"), *home = getenv("HOME"), *within = "", *off = getenv("STILB_CACHE");
	if (off && strcmp(off, "off") == 0)
		return false;
	if (!base || base[0] != '/') { /* relative paths are to be ignored: XDG Base Directory Specification */
		base = home;
		within = "/.cache";
	}
	if (!base || base[0] != '/')
		return false;
	const char *const parts[] = {within, "/stilb", "/", cache->folder};
	size_t length = (size_t)snprintf(path, PATH_MAX, "%s", base);
	for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
		if (length + strlen(parts[i]) + CACHE_NAME + 2 > PATH_MAX)
			return false;
		length += (size_t)snprintf(path + length, PATH_MAX - length, "%s", parts[i]);
		if (make && !cache_folder_make(path))
			return false;
	}
	return true;
}

static bool cache_path(const stilb_cache *cache, const uint64_t key[2], bool make, char path[PATH_MAX])
{
	STILB_ASSERT(cache && cache->folder && cache->ending && strlen(cache->ending) < CACHE_NAME - CACHE_KEY);
	if (!cache_folder(cache, path, make))
		return false;
	size_t length = strlen(path);
	return snprintf(path + length, PATH_MAX - length, "/%016llx%016llx%s", (unsigned long long)key[0],
	                (unsigned long long)key[1], cache->ending) < (int)(PATH_MAX - length);
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

FILE *stilb_cache_open(const stilb_cache *cache, const uint64_t key[2])
{
	char path[PATH_MAX];
	FILE *stream;
	if (!cache_path(cache, key, false, path) || access(path, R_OK) != 0 ||
	    stilb_file_read_open(path, &stream) != STILB_OK)
		return NULL;
	return stream;
}

void stilb_cache_used(const stilb_cache *cache, const uint64_t key[2])
{
	char path[PATH_MAX];
	if (cache_path(cache, key, false, path))
		utimensat(AT_FDCWD, path, NULL, 0); /* if it cannot be noted, it goes sooner */
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

typedef struct cache_file {
	char name[CACHE_NAME];
	struct timespec used;
	uint64_t size;
} cache_file;

static int by_use(const void *a, const void *b)
{
	const cache_file *l = a, *r = b;
	if (l->used.tv_sec != r->used.tv_sec)
		return l->used.tv_sec < r->used.tv_sec ? -1 : 1;
	if (l->used.tv_nsec != r->used.tv_nsec)
		return l->used.tv_nsec < r->used.tv_nsec ? -1 : 1;
	return strcmp(l->name, r->name);
}

/* Lists the cache's files. *count of them; free the list. NULL: there are none, or there is no memory. */
static cache_file *cache_list(const stilb_cache *cache, DIR *folder, size_t *count)
{
	cache_file *files = NULL;
	size_t room = 0;
	*count = 0;
	for (const struct dirent *entry; (entry = readdir(folder));) {
		size_t length = strlen(entry->d_name);
		struct stat status;
		if (length != CACHE_KEY + strlen(cache->ending) || strcmp(entry->d_name + CACHE_KEY, cache->ending) != 0 ||
		    fstatat(dirfd(folder), entry->d_name, &status, AT_SYMLINK_NOFOLLOW) != 0 || !S_ISREG(status.st_mode))
			continue;
		if (*count == room) {
			room = room * 2 + 64;
			cache_file *more = realloc(files, room * sizeof *files);
			if (!more)
				break;
			files = more;
		}
		cache_file *file = &files[(*count)++];
		*file = (cache_file){.used = status.st_mtim, .size = (uint64_t)status.st_size};
		memcpy(file->name, entry->d_name, length + 1);
	}
	return files;
}

/* Removes the files that were not used for longest, until the rest has at most cache->most bytes. */
static void cache_trim(const stilb_cache *cache)
{
	char path[PATH_MAX];
	DIR *folder = cache_folder(cache, path, false) ? opendir(path) : NULL;
	if (!folder)
		return;
	size_t count;
	uint64_t sum = 0;
	cache_file *files = cache_list(cache, folder, &count);
	for (size_t i = 0; i < count; i++)
		sum += files[i].size;
	if (sum > cache->most)
		qsort(files, count, sizeof *files, by_use);
	for (size_t i = 0; i < count && sum > cache->most; i++)
		if (unlinkat(dirfd(folder), files[i].name, 0) == 0)
			sum -= files[i].size;
	free(files);
	closedir(folder);
}

bool stilb_cache_begin(const stilb_cache *cache, const uint64_t key[2], stilb_file *file)
{
	char path[PATH_MAX];
	*file = (stilb_file){0};
	if (!cache_path(cache, key, true, path) || stilb_file_open(file, path) != STILB_OK)
		return false;
	file->unsynced = true;
	return true;
}

void stilb_cache_end(const stilb_cache *cache, stilb_file *file, bool whole)
{
	if (whole)
		stilb_file_commit(file); /* a full disk costs the next run its time, and nothing else */
	stilb_file_finish(file);
	cache_trim(cache);
}
