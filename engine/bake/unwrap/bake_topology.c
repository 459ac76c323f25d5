#include "bake/unwrap/bake_topology.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Coordinates beyond are errors of a file; rays leave such triangles out as well. */
#define FARTHEST 1e10
/* A triangle whose height over its longest side is less than this share of that side has no area. */
#define THINNEST 1e-6

/* ---- vertices ---------------------------------------------------------------------------------------------------- */

static const float *position_of(const stilb_bake_mesh *mesh, uint32_t vertex)
{
	return (const float *)((const char *)mesh->positions + vertex * mesh->position_step);
}

static uint64_t position_hash(const float position[3])
{
	uint64_t hash = STILB_FNV1A64_START;
	for (int i = 0; i < 3; i++) {
		float value = position[i] + 0.0f; /* -0 becomes 0 */
		uint32_t bits;
		memcpy(&bits, &value, sizeof bits);
		hash = stilb_random_u64(hash, bits);
	}
	return hash;
}

static bool same_position(const float a[3], const float b[3])
{
	return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

/* A power of two that is at least twice the count. */
static size_t table_size(size_t count)
{
	size_t size = 16;
	while (size < 2 * count)
		size *= 2;
	return size;
}

static bool is_place(const float position[3])
{
	for (int i = 0; i < 3; i++)
		if (!(fabsf(position[i]) <= (float)FARTHEST))
			return false;
	return true;
}

/* [vertex_count] the first vertex at the same position; NULL: no memory. */
static uint32_t *first_vertices(const stilb_bake_mesh *mesh)
{
	size_t size = table_size(mesh->vertex_count);
	uint32_t *first = stilb_memory_alloc(mesh->vertex_count, sizeof *first);
	uint32_t *table = stilb_memory_alloc(size, sizeof *table);
	if (first && table) {
		memset(table, 0xff, size * sizeof *table);
		for (uint32_t v = 0; v < mesh->vertex_count; v++) {
			const float *position = position_of(mesh, v);
			first[v] = v;
			if (!is_place(position)) /* NaN is nowhere, not even where another NaN is */
				continue;
			size_t at = position_hash(position) & (size - 1);
			while (table[at] != BAKE_NONE && !same_position(position_of(mesh, table[at]), position))
				at = (at + 1) & (size - 1);
			if (table[at] == BAKE_NONE)
				table[at] = v;
			first[v] = table[at];
		}
	} else {
		free(first);
		first = NULL;
	}
	free(table);
	return first;
}

/* ---- triangles --------------------------------------------------------------------------------------------------- */

/* Fills place, normal and area. */
static void measure_triangle(const stilb_bake_mesh *mesh, uint32_t t, bake_topology *topology)
{
	double(*place)[3] = &topology->place[3 * (size_t)t], e[2][3], longest = 0.0;
	topology->area[t] = 0.0;
	for (int i = 0; i < 3; i++) {
		uint32_t vertex = mesh->indices[3 * (size_t)t + (size_t)i];
		if (vertex >= mesh->vertex_count || !is_place(position_of(mesh, vertex))) {
			topology->invalid++;
			return;
		}
		for (int k = 0; k < 3; k++)
			place[i][k] = (double)position_of(mesh, vertex)[k];
	}
	for (int k = 0; k < 3; k++) {
		e[0][k] = place[1][k] - place[0][k];
		e[1][k] = place[2][k] - place[0][k];
	}
	double n[3] = {e[0][1] * e[1][2] - e[0][2] * e[1][1], e[0][2] * e[1][0] - e[0][0] * e[1][2],
	               e[0][0] * e[1][1] - e[0][1] * e[1][0]};
	for (int i = 0; i < 3; i++) {
		double square = 0.0;
		for (int k = 0; k < 3; k++) {
			double side = place[(i + 1) % 3][k] - place[i][k];
			square += side * side;
		}
		longest = fmax(longest, square);
	}
	double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
	if (!(length > THINNEST * longest) || !(length > 0.0)) {
		topology->flat++;
		return;
	}
	topology->area[t] = 0.5 * length;
	for (int k = 0; k < 3; k++)
		topology->normal[t][k] = n[k] / length;
}

/* ---- edges ------------------------------------------------------------------------------------------------------- */

/* The half-edges of good triangles by their ends. A slot holds the first half-edge of its ends and direction. */
typedef struct edge_table {
	const stilb_bake_mesh *mesh;
	const uint32_t *first; /* first_vertices */
	uint32_t *slots;
	size_t mask;
} edge_table;

static void edge_ends(const edge_table *table, uint32_t half_edge, uint32_t ends[2])
{
	ends[0] = table->first[table->mesh->indices[half_edge]];
	ends[1] = table->first[table->mesh->indices[bake_next(half_edge)]];
}

/* The slot of the half-edge from a to b, or the free one where it would be. */
static uint32_t *edge_slot(const edge_table *table, uint32_t a, uint32_t b)
{
	size_t at = stilb_random_u64(a, b) & table->mask;
	for (;; at = (at + 1) & table->mask) {
		uint32_t ends[2];
		if (table->slots[at] == BAKE_NONE)
			return &table->slots[at];
		edge_ends(table, table->slots[at], ends);
		if (ends[0] == a && ends[1] == b)
			return &table->slots[at];
	}
}

/* Marks half-edges whose ends and direction another one has, too: odd[h]. */
static void find_edges(edge_table *table, const bake_topology *topology, uint8_t *odd)
{
	for (uint32_t h = 0; h < 3 * topology->triangle_count; h++) {
		uint32_t ends[2];
		if (!(topology->area[h / 3] > 0.0))
			continue;
		edge_ends(table, h, ends);
		uint32_t *slot = edge_slot(table, ends[0], ends[1]);
		if (*slot == BAKE_NONE)
			*slot = h;
		else
			odd[*slot] = odd[h] = 1;
	}
}

static void join_twins(const edge_table *table, bake_topology *topology, const uint8_t *odd)
{
	for (uint32_t h = 0; h < 3 * topology->triangle_count; h++) {
		uint32_t ends[2];
		topology->twin[h] = BAKE_NONE;
		if (!(topology->area[h / 3] > 0.0))
			continue;
		edge_ends(table, h, ends);
		uint32_t other = *edge_slot(table, ends[1], ends[0]);
		if (odd[h] || (other != BAKE_NONE && odd[other]))
			topology->odd_edges++;
		else
			topology->twin[h] = other;
	}
}

static bool join_edges(const stilb_bake_mesh *mesh, bake_topology *topology)
{
	size_t size = table_size(3 * (size_t)topology->triangle_count);
	uint32_t *first = first_vertices(mesh);
	edge_table table = {mesh, first, stilb_memory_alloc(size, sizeof *table.slots), size - 1};
	uint8_t *odd = calloc(3 * (size_t)topology->triangle_count + 1, 1);
	bool good = first && table.slots && odd;
	if (good) {
		memset(table.slots, 0xff, size * sizeof *table.slots);
		find_edges(&table, topology, odd);
		join_twins(&table, topology, odd);
	}
	free(odd);
	free(table.slots);
	free(first);
	return good;
}

stilb_result bake_topology_create(const stilb_bake_mesh *mesh, bake_topology *topology)
{
	size_t count = mesh->triangle_count;
	*topology = (bake_topology){.triangle_count = mesh->triangle_count};
	topology->twin = stilb_memory_alloc(3 * count, sizeof *topology->twin);
	topology->place = stilb_memory_alloc(3 * count, sizeof *topology->place);
	topology->normal = stilb_memory_alloc(count, sizeof *topology->normal);
	topology->area = stilb_memory_alloc(count, sizeof *topology->area);
	bool good = topology->twin && topology->place && topology->normal && topology->area;
	for (uint32_t t = 0; t < mesh->triangle_count && good; t++)
		measure_triangle(mesh, t, topology);
	if (good && join_edges(mesh, topology))
		return STILB_OK;
	bake_topology_finish(topology);
	return stilb_fail(STILB_ERROR_MEMORY, "out of memory to unwrap %u triangles", mesh->triangle_count);
}

void bake_topology_finish(bake_topology *topology)
{
	free(topology->twin);
	free(topology->place);
	free(topology->normal);
	free(topology->area);
	*topology = (bake_topology){0};
}
