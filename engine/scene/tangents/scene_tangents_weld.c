/* Vertices with equal values become one, by a hash table. */
#include "scene/tangents/scene_tangents_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct weld_table {
	uint32_t *slots; /* [mask + 1] vertices of work, or NONE; linear probing */
	uint32_t *known; /* [mesh->vertex_count] the vertex of work that one of the mesh became, or NONE */
	uint64_t mask;
} weld_table;

static void weld_read(const float *stream, size_t stride, uint32_t vertex, uint32_t count, float *out)
{
	memcpy(out, (const char *)stream + stride * vertex, count * sizeof *out);
	for (uint32_t i = 0; i < count; i++)
		out[i] += 0.0f; /* -0 becomes 0 */
}

static uint64_t weld_hash(const scene_tangents_vertex *vertex)
{
	uint64_t words[sizeof *vertex / 8], hash = 0;
	memcpy(words, vertex, sizeof words);
	for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
		hash = (hash ^ words[i]) * 0x9e3779b97f4a7c15u; /* 2^64 divided by the golden ratio */
		hash ^= hash >> 32;
	}
	return hash;
}

/* The vertex of work with these values; a new one if there is none. */
static uint32_t weld_find(weld_table *table, scene_tangents_work *work, const scene_tangents_vertex *vertex)
{
	uint64_t slot = weld_hash(vertex) & table->mask;
	for (; table->slots[slot] != SCENE_TANGENTS_NONE; slot = (slot + 1) & table->mask)
		if (memcmp(&work->vertices[table->slots[slot]], vertex, sizeof *vertex) == 0)
			return table->slots[slot];
	work->vertices[work->vertex_count] = *vertex;
	return table->slots[slot] = work->vertex_count++;
}

/* Unit, or zero. A normal that is unit within rounding keeps its bits. */
static void weld_clean_normal(float normal[3])
{
	double square = 0.0;
	for (int i = 0; i < 3; i++)
		square += (double)normal[i] * (double)normal[i];
	if (fabs(square - 1.0) <= 1e-5)
		return;
	double scale = square > 0.0 ? 1.0 / sqrt(square) : 0.0; /* 0 for an infinite one, too */
	for (int i = 0; i < 3; i++)
		normal[i] = scale > 0.0 ? (float)(scale * (double)normal[i]) : 0.0f;
}

static bool weld_start(const scene_tangents_mesh *mesh, scene_tangents_work *work, weld_table *table)
{
	uint32_t most = mesh->vertex_count < mesh->index_count ? mesh->vertex_count : mesh->index_count;
	uint64_t size = 4;
	while (size < (uint64_t)most + most / 2)
		size *= 2;
	work->corners = stilb_memory_alloc(mesh->index_count, sizeof *work->corners);
	work->vertices = stilb_memory_alloc(most, sizeof *work->vertices);
	table->slots = stilb_memory_alloc(size, sizeof *table->slots);
	table->known = stilb_memory_alloc(mesh->vertex_count, sizeof *table->known);
	table->mask = size - 1;
	if (!work->corners || !work->vertices || !table->slots || !table->known)
		return false;
	memset(table->slots, 0xff, size * sizeof *table->slots);
	memset(table->known, 0xff, mesh->vertex_count * sizeof *table->known);
	return true;
}

bool scene_tangents_weld(const scene_tangents_mesh *mesh, scene_tangents_work *work)
{
	weld_table table = {0};
	bool good = weld_start(mesh, work, &table);
	for (uint32_t c = 0; good && c < mesh->index_count; c++) {
		uint32_t index = mesh->indices[c];
		STILB_ASSERT(index < mesh->vertex_count);
		if (table.known[index] == SCENE_TANGENTS_NONE) {
			scene_tangents_vertex vertex;
			weld_read(mesh->positions, mesh->position_stride, index, 3, vertex.position);
			weld_read(mesh->normals, mesh->normal_stride, index, 3, vertex.normal);
			weld_read(mesh->uvs, mesh->uv_stride, index, 2, vertex.uv);
			table.known[index] = weld_find(&table, work, &vertex);
		}
		work->corners[c] = table.known[index];
	}
	for (uint32_t v = 0; good && v < work->vertex_count; v++)
		weld_clean_normal(work->vertices[v].normal);
	free(table.slots);
	free(table.known);
	return good;
}
