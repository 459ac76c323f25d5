/* Levels of meshes on disk. */
#include "base/base_cache.h"
#include "geometry/geometry_plan.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* Counts up with every change of what levels are made of the same mesh, or of the file. */
#define CACHE_VERSION 11u

static const stilb_cache cache_levels = {"levels", ".levels", STILB_GEOMETRY_CACHE_BYTES};

typedef struct cache_header {
	char magic[8];
	uint32_t version, endian;
	uint64_t key[2];
	uint32_t vertex_count, index_count, level_count, level_index_count, cluster_count, group_count, cluster_index_count;
	uint32_t zero;
	uint64_t checksum; /* of the rest of the file */
} cache_header;

static const char cache_magic[8] = "STILBLV";

/* ---- keys -------------------------------------------------------------------------------------------------------- */

/* What levels depend on of the streams, but for values. */
static void cache_add_streams(stilb_cache_hash *hash, const stilb_scene_streams *table, const float *weights)
{
	for (uint32_t s = 0; s < table->count; s++) {
		const stilb_scene_stream *stream = &table->streams[s];
		const uint32_t numbers[4] = {stream->kind, stream->components, stream->offset, stream->seam};
		stilb_cache_hash_add(hash, stream->name, strlen(stream->name) + 1);
		stilb_cache_hash_add(hash, numbers, sizeof numbers);
		stilb_cache_hash_add(hash, &weights[s], sizeof weights[s]);
	}
}

void geometry_cache_key(const stilb_scene_streams *table, const void *vertices, const float *weights,
                        const stilb_scene_mesh *mesh, const stilb_geometry_levels_desc *desc, uint64_t key[2])
{
	stilb_cache_hash hash = stilb_cache_hash_start();
	const uint32_t numbers[8] = {CACHE_VERSION,       mesh->vertex_count,   mesh->index_count, desc->least,
	                             desc->cluster_least, desc->locked ? 1 : 0, table->count,      mesh->extras ? 1 : 0};
	stilb_cache_hash_add(&hash, numbers, sizeof numbers);
	stilb_cache_hash_add(&hash, &desc->ratio, sizeof desc->ratio);
	cache_add_streams(&hash, table, weights);
	stilb_cache_hash_add(&hash, vertices, (size_t)mesh->vertex_count * table->size);
	if (mesh->extras)
		stilb_cache_hash_add(&hash, mesh->extras, (size_t)mesh->vertex_count * sizeof *mesh->extras);
	stilb_cache_hash_add(&hash, mesh->indices, mesh->index_count * sizeof *mesh->indices);
	if (desc->locked)
		stilb_cache_hash_add(&hash, desc->locked, mesh->vertex_count);
	stilb_cache_hash_end(&hash, key);
}

static void cache_key(const stilb_scene_mesh *mesh, const stilb_geometry_levels_desc *desc, uint64_t key[2])
{
	geometry_cache_key(&stilb_scene_vertex_streams, mesh->vertices, desc->weights, mesh, desc, key);
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

/* True if all of count numbers are below `end`. */
static bool are_below(const uint32_t *numbers, uint32_t count, uint32_t end)
{
	for (uint32_t i = 0; i < count; i++)
		if (numbers[i] >= end)
			return false;
	return true;
}

/* True if each vertex stands once in the order. */
static bool is_order(const geometry_plan *plan)
{
	uint8_t *seen = calloc(plan->vertex_count + 1u, 1);
	bool once = seen && are_below(plan->order, plan->vertex_count, plan->vertex_count);
	for (uint32_t v = 0; once && v < plan->vertex_count; v++)
		once = !seen[plan->order[v]]++;
	free(seen);
	return once;
}

static bool levels_are_sound(const geometry_plan *plan)
{
	stilb_scene_level finer = {.index_count = plan->index_count, .vertex_count = plan->vertex_count};
	uint32_t first = 0;
	for (uint32_t l = 0; l < plan->level_count; l++) {
		const stilb_scene_level *level = &plan->levels[l];
		if (level->first_index != first || level->index_count == 0 || level->index_count % 3 != 0 ||
		    level->index_count >= finer.index_count || level->index_count > plan->level_index_count - first ||
		    level->vertex_count == 0 || level->vertex_count > finer.vertex_count ||
		    !(level->error >= finer.error && level->error <= 1e18f) ||
		    !are_below(plan->level_indices + first, level->index_count, level->vertex_count))
			return false;
		first += level->index_count;
		finer = *level;
	}
	return first == plan->level_index_count;
}

static bool is_sphere(const float center[3], float radius)
{
	return fabsf(center[0]) <= 1e18f && fabsf(center[1]) <= 1e18f && fabsf(center[2]) <= 1e18f && radius >= 0.0f &&
	       radius <= 1e19f;
}

/* True if clusters lie one after the other, of their groups and of their indices, and groups are from finer ones. */
static bool clusters_are_sound(const geometry_plan *plan)
{
	uint32_t next = 0, own = 0, coarser = 0;
	for (uint32_t g = 0; g < plan->group_count; g++) {
		const stilb_scene_cluster_group *group = &plan->groups[g];
		if (group->first_cluster != next || group->cluster_count == 0 ||
		    group->cluster_count > plan->cluster_count - next ||
		    !(group->error >= 0.0f && is_sphere(group->center, group->radius)))
			return false;
		for (uint32_t end = next + group->cluster_count; next < end; next++) {
			const stilb_scene_cluster *cluster = &plan->clusters[next];
			bool leaf = cluster->from == STILB_SCENE_NONE;
			uint32_t *first = leaf ? &own : &coarser, most = leaf ? plan->index_count : plan->cluster_index_count;
			if (cluster->first_index != *first || cluster->index_count == 0 || cluster->index_count % 3 != 0 ||
			    cluster->index_count > most - *first || !is_sphere(cluster->center, cluster->radius) ||
			    (!leaf && (cluster->from >= g || !(plan->groups[cluster->from].error <= group->error))))
				return false;
			*first += cluster->index_count;
		}
	}
	return next == plan->cluster_count && own == (plan->cluster_count > 0 ? plan->index_count : 0) &&
	       coarser == plan->cluster_index_count;
}

/* True if a plan that was read fits to a mesh of these counts, and nothing in it leads out of them. */
static bool plan_is_sound(const geometry_plan *plan)
{
	return (!plan->to || are_below(plan->to, plan->vertex_count, plan->vertex_count)) &&
	       are_below(plan->indices, plan->index_count, plan->vertex_count) &&
	       are_below(plan->cluster_indices, plan->cluster_index_count, plan->vertex_count) && is_order(plan) &&
	       levels_are_sound(plan) && clusters_are_sound(plan);
}

static bool cache_read_header(FILE *stream, const stilb_scene_mesh *mesh, const uint64_t key[2], cache_header *header)
{
	if (fread(header, sizeof *header, 1, stream) != 1 || memcmp(header->magic, cache_magic, sizeof cache_magic) != 0 ||
	    header->version != CACHE_VERSION || header->endian != 1 || header->zero != 0 ||
	    memcmp(header->key, key, sizeof header->key) != 0)
		return false;
	if (header->level_count == 0 && header->cluster_count == 0)
		return header->vertex_count == 0 && header->index_count == 0 && header->level_index_count == 0 &&
		       header->group_count == 0 && header->cluster_index_count == 0;
	uint64_t most = (uint64_t)mesh->index_count * STILB_SCENE_MAX_LEVELS;
	return header->vertex_count == mesh->vertex_count && header->index_count == mesh->index_count &&
	       header->level_count <= STILB_SCENE_MAX_LEVELS && header->level_index_count <= most &&
	       header->cluster_index_count <= most && header->cluster_count <= most &&
	       header->group_count <= header->cluster_count;
}

static bool cache_read_plan(FILE *stream, const cache_header *header, geometry_plan *plan)
{
	*plan = (geometry_plan){.vertex_count = header->vertex_count,
	                        .index_count = header->index_count,
	                        .level_count = header->level_count,
	                        .level_index_count = header->level_index_count,
	                        .cluster_count = header->cluster_count,
	                        .group_count = header->group_count,
	                        .cluster_index_count = header->cluster_index_count};
	struct stat status;
	geometry_plan_part parts[GEOMETRY_PLAN_PARTS];
	geometry_plan_parts(plan, parts);
	uint64_t size = sizeof *header, checksum = STILB_FNV1A64_START;
	for (size_t i = 0; i < GEOMETRY_PLAN_PARTS; i++)
		size += parts[i].size;
	if (fstat(fileno(stream), &status) != 0 || (uint64_t)status.st_size != size || !geometry_plan_allocate(plan))
		return false;
	geometry_plan_parts(plan, parts);
	for (size_t i = 0; i < GEOMETRY_PLAN_PARTS; i++) {
		if (parts[i].size > 0 && fread(parts[i].data, parts[i].size, 1, stream) != 1)
			return false;
		checksum = stilb_hash_fnv1a64(checksum, parts[i].data, parts[i].size);
	}
	return checksum == header->checksum && plan_is_sound(plan);
}

/* Reads the plan of a mesh. False: there is none that is sound. */
static bool cache_read(const stilb_scene_mesh *mesh, const uint64_t key[2], geometry_plan *plan)
{
	*plan = (geometry_plan){0};
	FILE *stream = stilb_cache_open(&cache_levels, key);
	if (!stream)
		return false;
	cache_header header;
	bool read = cache_read_header(stream, mesh, key, &header) && cache_read_plan(stream, &header, plan);
	fclose(stream);
	if (read)
		stilb_cache_used(&cache_levels, key);
	else
		geometry_plan_finish(plan);
	return read;
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

static void cache_write(const uint64_t key[2], const geometry_plan *plan)
{
	stilb_file file;
	if (!stilb_cache_begin(&cache_levels, key, &file))
		return;
	cache_header header = {.version = CACHE_VERSION,
	                       .endian = 1,
	                       .key = {key[0], key[1]},
	                       .vertex_count = plan->vertex_count,
	                       .index_count = plan->index_count,
	                       .level_count = plan->level_count,
	                       .level_index_count = plan->level_index_count,
	                       .cluster_count = plan->cluster_count,
	                       .group_count = plan->group_count,
	                       .cluster_index_count = plan->cluster_index_count,
	                       .checksum = STILB_FNV1A64_START};
	memcpy(header.magic, cache_magic, sizeof header.magic);
	geometry_plan_part parts[GEOMETRY_PLAN_PARTS];
	geometry_plan_parts(plan, parts);
	for (size_t i = 0; i < GEOMETRY_PLAN_PARTS; i++)
		header.checksum = stilb_hash_fnv1a64(header.checksum, parts[i].data, parts[i].size);
	bool written = stilb_file_write(&file, &header, sizeof header) == 0;
	for (size_t i = 0; i < GEOMETRY_PLAN_PARTS && written; i++)
		written = parts[i].size == 0 || stilb_file_write(&file, parts[i].data, parts[i].size) == 0;
	stilb_cache_end(&cache_levels, &file, written);
}

/* ---- the whole --------------------------------------------------------------------------------------------------- */

bool stilb_geometry_levels_find(stilb_scene_mesh *mesh, const stilb_geometry_levels_desc *desc)
{
	STILB_ASSERT(mesh && desc);
	uint64_t key[2];
	geometry_plan plan;
	if (mesh->index_count / 3 < STILB_GEOMETRY_CACHE_LEAST)
		return false;
	cache_key(mesh, desc, key);
	if (!cache_read(mesh, key, &plan))
		return false;
	bool applied = geometry_plan_apply(&plan, mesh) == STILB_OK;
	geometry_plan_finish(&plan);
	return applied;
}

stilb_result stilb_geometry_levels_cached(stilb_scene_mesh *mesh, const stilb_geometry_levels_desc *desc,
                                          stilb_job_pool *pool, uint32_t worker)
{
	STILB_ASSERT(mesh && desc);
	if (mesh->index_count / 3 < STILB_GEOMETRY_CACHE_LEAST)
		return stilb_geometry_levels(mesh, desc, pool, worker);
	stilb_result result = geometry_levels_check(mesh, desc);
	if (result != STILB_OK)
		return result;
	uint64_t key[2];
	geometry_plan plan;
	cache_key(mesh, desc, key);
	if (!cache_read(mesh, key, &plan)) {
		result = geometry_plan_make(mesh, desc, pool, worker, &plan);
		if (result == STILB_OK)
			cache_write(key, &plan);
	}
	if (result == STILB_OK)
		result = geometry_plan_apply(&plan, mesh);
	geometry_plan_finish(&plan);
	return result;
}
