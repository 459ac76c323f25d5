/*
 * gi_cache_file: reads and writes the records of an irradiance cache. The file is: a line that identifies the format;
 * cache_header; the records as they are in memory; the FNV-1a hash of header and records. Byte order and floats are
 * the machine's.
 */
#include "gi/cache/gi_cache_file.h"

#include "base/base_file.h"
#include "gi/gi_scene_hash.h"
#include "profiler/prof.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char magic[] = "stilb irradiance cache 2\n";
#define MAGIC_SIZE (sizeof magic - 1)

/* What the records in the file depend on. All but count must be equal to what the cache at hand has, or the file is
 * refused. */
typedef struct cache_header {
	uint64_t scene; /* gi_scene_hash */
	uint32_t depth, radius, gradients;
	float error;
	uint32_t count, record_size; /* number of records, and bytes of one */
	shade_brdf_model model;      /* BRDF of the highlights, which reflect light that records gather */
} cache_header;

static cache_header header_make(const gi_cache *cache)
{
	const stilb_gi_settings *settings = &cache->view->settings;
	return (cache_header){.scene = gi_scene_hash(cache->view->scene),
	                      .depth = settings->depth,
	                      .radius = settings->cache.radius,
	                      .gradients = settings->cache.gradients,
	                      .error = settings->cache.error,
	                      .count = gi_cache_octree_count(cache->octree),
	                      .record_size = sizeof(gi_cache_record),
	                      .model = settings->model};
}

/* ---- save -------------------------------------------------------------------------------------------------------- */

/* Writes data and returns the hash continued over it. A failure of the write is reported by stilb_file_commit later. */
static uint64_t cache_write_hashed(stilb_file *file, uint64_t hash, const void *data, size_t size)
{
	stilb_file_write(file, data, size);
	return stilb_hash_fnv1a64(hash, data, size);
}

stilb_result gi_cache_save(const gi_cache *cache, const char *path)
{
	STILB_ASSERT(cache && path);
	PROFILE("gi.cache.save");
	stilb_file file;
	stilb_result result = stilb_file_open(&file, path);
	if (result != STILB_OK)
		return result;
	cache_header header = header_make(cache);
	stilb_file_write(&file, magic, MAGIC_SIZE);
	uint64_t hash = cache_write_hashed(&file, STILB_FNV1A64_START, &header, sizeof header);
	for (uint32_t i = 0; i < header.count; i++) {
		const gi_cache_record *record = gi_cache_octree_record(cache->octree, i);
		if (!record) {
			stilb_file_finish(&file);
			return stilb_fail(STILB_ERROR_MEMORY, "memory ran out while the cache was filled: %s is not written", path);
		}
		hash = cache_write_hashed(&file, hash, record, sizeof *record);
	}
	stilb_file_write(&file, &hash, sizeof hash);
	return stilb_file_commit(&file);
}

/* ---- load -------------------------------------------------------------------------------------------------------- */

static stilb_result refuse(const char *path, const char *what)
{
	return stilb_fail(STILB_ERROR_FILE, "irradiance cache %s %s; make a new one", path, what);
}

static stilb_result check_header(const char *path, const cache_header *header, const cache_header *wanted)
{
	if (header->record_size != wanted->record_size)
		return refuse(path, "was written by another version");
	if (header->scene != wanted->scene)
		return refuse(path, "belongs to another scene");
	if (header->depth != wanted->depth)
		return refuse(path, "was made with another depth");
	if (header->radius != wanted->radius)
		return refuse(path, "was made with another kind of radius");
	if (header->gradients != wanted->gradients)
		return refuse(path, header->gradients ? "was made with gradients" : "was made without gradients");
	if (header->error != wanted->error)
		return refuse(path, "was made with another error");
	if (memcmp(&header->model, &wanted->model, sizeof wanted->model) != 0)
		return refuse(path, "was made with other highlights (--brdf, --ndf, --g, --f)");
	return STILB_OK;
}

/* True if all numbers of a record that was read are finite and all its radii positive. */
static bool record_is_sound(const gi_cache_record *record)
{
	const float *numbers = (const float *)record;
	for (size_t i = 0; i < sizeof(*record) / sizeof(float); i++)
		if (!isfinite(numbers[i]))
			return false;
	return record->position[3] > 0.0f && record->normal[3] > 0.0f && record->tangent[3] > 0.0f &&
	       record->irradiance[3] > 0.0f;
}

static bool cache_read_hashed(FILE *stream, uint64_t *hash, void *data, size_t size)
{
	if (fread(data, 1, size, stream) != size)
		return false;
	*hash = stilb_hash_fnv1a64(*hash, data, size);
	return true;
}

/* The whole file is checked before the cache is changed. */
static stilb_result read_records(gi_cache *cache, FILE *stream, const char *path)
{
	char line[MAGIC_SIZE];
	if (fread(line, 1, MAGIC_SIZE, stream) != MAGIC_SIZE || memcmp(line, magic, MAGIC_SIZE) != 0)
		return refuse(path, "is not an irradiance cache");
	uint64_t hash = STILB_FNV1A64_START;
	cache_header header, wanted = header_make(cache);
	if (!cache_read_hashed(stream, &hash, &header, sizeof header))
		return refuse(path, "is cut short");
	stilb_result result = check_header(path, &header, &wanted);
	if (result != STILB_OK)
		return result;
	gi_cache_octree *octree;
	result = gi_cache_octree_create(cache->view->scene->info.low, cache->view->scene->info.high, &octree);
	if (result != STILB_OK)
		return result;
	for (uint32_t i = 0; i < header.count && result == STILB_OK; i++) {
		gi_cache_record record;
		if (!cache_read_hashed(stream, &hash, &record, sizeof record))
			result = refuse(path, "is cut short");
		else if (!record_is_sound(&record))
			result = refuse(path, "is damaged");
		else if (!gi_cache_octree_insert(octree, &record))
			result = stilb_fail(STILB_ERROR_MEMORY, "no memory for the %u records of %s", header.count, path);
	}
	uint64_t written;
	if (result == STILB_OK && fread(&written, 1, sizeof written, stream) != sizeof written)
		result = refuse(path, "is cut short");
	if (result == STILB_OK && written != hash)
		result = refuse(path, "is damaged");
	if (result != STILB_OK) {
		gi_cache_octree_destroy(octree);
		return result;
	}
	gi_cache_octree_destroy(cache->octree);
	cache->octree = octree;
	return STILB_OK;
}

stilb_result gi_cache_load(gi_cache *cache, const char *path)
{
	STILB_ASSERT(cache && path);
	PROFILE("gi.cache.load");
	FILE *stream;
	stilb_result result = stilb_file_read_open(path, &stream);
	if (result != STILB_OK)
		return result;
	result = read_records(cache, stream, path);
	fclose(stream);
	return result;
}
