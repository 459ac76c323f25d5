/* Corner tangents become vertices, by a hash table over pairs of a vertex and a tangent. */
#include "scene/tangents/scene_tangents_internal.h"

#include <stdlib.h>
#include <string.h>

typedef struct split_table {
	uint32_t *slots; /* [mask + 1] vertices of the split, or NONE; linear probing */
	uint64_t mask;
} split_table;

static uint64_t split_hash(uint32_t vertex, const float tangent[4])
{
	uint64_t words[2], hash = vertex;
	memcpy(words, tangent, sizeof words);
	for (int i = 0; i < 2; i++) {
		hash = (hash ^ words[i]) * 0x9e3779b97f4a7c15u; /* 2^64 divided by the golden ratio */
		hash ^= hash >> 32;
	}
	return hash;
}

/* The slot of the pair, or the empty one where it belongs. */
static uint32_t *split_find(const split_table *table, const scene_tangents_split *split, uint32_t vertex,
                            const float tangent[4])
{
	uint64_t slot = split_hash(vertex, tangent) & table->mask;
	for (; table->slots[slot] != SCENE_TANGENTS_NONE; slot = (slot + 1) & table->mask) {
		uint32_t v = table->slots[slot];
		if (split->sources[v] == vertex && memcmp(split->tangents[v], tangent, sizeof *split->tangents) == 0)
			break;
	}
	return &table->slots[slot];
}

static bool split_start(const scene_tangents_mesh *mesh, scene_tangents_split *split, split_table *table)
{
	uint64_t most = (uint64_t)mesh->vertex_count + mesh->index_count, size = 4;
	if (most > UINT32_MAX)
		return false;
	while (size < (uint64_t)mesh->index_count + mesh->index_count / 2)
		size *= 2;
	split->sources = stilb_memory_alloc(most, sizeof *split->sources);
	split->tangents = stilb_memory_alloc(most, sizeof *split->tangents);
	split->indices = stilb_memory_alloc(mesh->index_count, sizeof *split->indices);
	table->slots = stilb_memory_alloc(size, sizeof *table->slots);
	table->mask = size - 1;
	if (!split->sources || !split->tangents || !split->indices || !table->slots)
		return false;
	memset(table->slots, 0xff, size * sizeof *table->slots);
	return true;
}

/* Numbers the vertices. A vertex that has no tangent yet has NONE as its source. */
static void split_number(const scene_tangents_mesh *mesh, const float (*tangents)[4], const split_table *table,
                         scene_tangents_split *split)
{
	split->vertex_count = mesh->vertex_count;
	memset(split->sources, 0xff, mesh->vertex_count * sizeof *split->sources);
	for (uint32_t c = 0; c < mesh->index_count; c++) {
		uint32_t index = mesh->indices[c];
		STILB_ASSERT(index < mesh->vertex_count);
		uint32_t *slot = split_find(table, split, index, tangents[c]);
		if (*slot == SCENE_TANGENTS_NONE) {
			*slot = split->sources[index] == SCENE_TANGENTS_NONE ? index : split->vertex_count++;
			split->sources[*slot] = index;
			memcpy(split->tangents[*slot], tangents[c], sizeof *split->tangents);
		}
		split->indices[c] = *slot;
	}
	for (uint32_t v = 0; v < mesh->vertex_count; v++)
		if (split->sources[v] == SCENE_TANGENTS_NONE) {
			split->sources[v] = v;
			memcpy(split->tangents[v], (const float[4]){1, 0, 0, 1}, sizeof *split->tangents);
		}
}

stilb_result scene_tangents_split_make(const scene_tangents_mesh *mesh, const float (*tangents)[4],
                                       scene_tangents_split *split)
{
	STILB_ASSERT(mesh && split && ((mesh->indices && tangents) || mesh->index_count == 0));
	split_table table = {0};
	*split = (scene_tangents_split){0};
	bool good = split_start(mesh, split, &table);
	if (good)
		split_number(mesh, tangents, &table, split);
	else
		scene_tangents_split_finish(split);
	free(table.slots);
	return good ? STILB_OK
	            : stilb_fail(STILB_ERROR_MEMORY, "no memory for a mesh of %u vertices and %u indices with tangents",
	                         mesh->vertex_count, mesh->index_count);
}

void scene_tangents_split_finish(scene_tangents_split *split)
{
	STILB_ASSERT(split);
	free(split->sources);
	free(split->tangents);
	free(split->indices);
	*split = (scene_tangents_split){0};
}
