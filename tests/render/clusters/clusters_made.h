/*
 * A torus with clusters made by hand, whose every cut is closed; and whether what is drawn of a mesh is.
 *
 * The surface is TORUS_SIDE x TORUS_SIDE squares. Groups are square blocks of them, first of 8 squares a side, then of
 * twice as many, until one is all of it, which is the root. The coarser version of a block keeps the edges along its
 * outline, and has squares twice as large as before inside, with a ring of triangles in between.
 */
#ifndef RENDER_CLUSTERS_MADE_H
#define RENDER_CLUSTERS_MADE_H

#include "support/test.h"

#include "scene/scene.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define TORUS_SIDE 64u
#define TORUS_GROUPS (64u + 16u + 4u + 1u)
#define TORUS_CLUSTER_INDICES 96u /* at most */

/* What grows while the torus is made. */
typedef struct torus_made {
	stilb_scene_mesh *mesh;
	uint32_t coarser[TORUS_GROUPS][3 * 256]; /* triangles of each group's coarser version */
	uint32_t counts[TORUS_GROUPS];           /* their indices */
} torus_made;

static inline uint32_t torus_vertex(uint32_t x, uint32_t y)
{
	return y % TORUS_SIDE * TORUS_SIDE + x % TORUS_SIDE;
}

static inline stilb_scene_vertex torus_place(uint32_t x, uint32_t y)
{
	float u = 6.2831853f * (float)x / (float)TORUS_SIDE, v = 6.2831853f * (float)y / (float)TORUS_SIDE;
	float n[3] = {cosf(v) * cosf(u), sinf(v), cosf(v) * sinf(u)};
	return (stilb_scene_vertex){{2.0f * cosf(u) + n[0], n[1], 2.0f * sinf(u) + n[2]},
	                            {n[0], n[1], n[2]},
	                            {(float)x / (float)TORUS_SIDE, (float)y / (float)TORUS_SIDE}};
}

static inline void torus_triangle(torus_made *made, uint32_t group, uint32_t a, uint32_t b, uint32_t c)
{
	uint32_t *out = made->coarser[group] + made->counts[group];
	assert_true(made->counts[group] + 3 <= 3 * 256);
	out[0] = a;
	out[1] = b;
	out[2] = c;
	made->counts[group] += 3;
}

/* Two triangles; the outside of the torus is where y, then x, is counter-clockwise. */
static inline void torus_square(torus_made *made, uint32_t group, uint32_t x, uint32_t y, uint32_t step)
{
	uint32_t a = torus_vertex(x, y), b = torus_vertex(x + step, y), c = torus_vertex(x, y + step);
	torus_triangle(made, group, a, c, b);
	torus_triangle(made, group, b, c, torus_vertex(x + step, y + step));
}

/* The point number i of `count` a side on the outline of a square with corners at low and high from (x, y),
 * counter-clockwise as torus_square. */
static inline uint32_t torus_outline(uint32_t x, uint32_t y, uint32_t low, uint32_t high, uint32_t i, uint32_t count)
{
	uint32_t side = i / count % 4, along = i % count * ((high - low) / count);
	uint32_t px = side == 0 ? low : side == 1 ? low + along : side == 2 ? high : high - along;
	uint32_t py = side == 0 ? low + along : side == 1 ? high : side == 2 ? high - along : low;
	return torus_vertex(x + px, y + py);
}

/* The coarser version of the block of `size` squares a side at (x, y): squares of `step` inside. */
static inline void torus_simplify(torus_made *made, uint32_t group, uint32_t x, uint32_t y, uint32_t size,
                                  uint32_t step)
{
	for (uint32_t j = step; j < size - step; j += step)
		for (uint32_t i = step; i < size - step; i += step)
			torus_square(made, group, x + i, y + j, step);
	uint32_t few = (size - 2 * step) / step;
	for (uint32_t outer = 0, inner = 0; outer < 4 * size || inner < 4 * few;) {
		uint32_t o = torus_outline(x, y, 0, size, outer, size);
		uint32_t n = torus_outline(x, y, step, size - step, inner, few);
		if (outer * few <= inner * size && outer < 4 * size) {
			torus_triangle(made, group, o, torus_outline(x, y, 0, size, outer + 1, size), n);
			outer++;
		} else {
			torus_triangle(made, group, o, torus_outline(x, y, step, size - step, inner + 1, few), n);
			inner++;
		}
	}
}

/* Sphere around triangles: about the middle of their box. */
static inline void torus_sphere(const stilb_scene_mesh *mesh, const uint32_t *indices, uint32_t count, float center[3],
                                float *radius)
{
	float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY}, most = 0.0f;
	for (uint32_t i = 0; i < count; i++)
		for (int k = 0; k < 3; k++) {
			low[k] = fminf(low[k], mesh->vertices[indices[i]].position[k]);
			high[k] = fmaxf(high[k], mesh->vertices[indices[i]].position[k]);
		}
	for (int k = 0; k < 3; k++)
		center[k] = 0.5f * (low[k] + high[k]);
	for (uint32_t i = 0; i < count; i++) {
		float square = 0.0f;
		for (int k = 0; k < 3; k++) {
			float d = mesh->vertices[indices[i]].position[k] - center[k];
			square += d * d;
		}
		most = fmaxf(most, sqrtf(square));
	}
	*radius = most * 1.00001f;
}

/* Appends clusters of these triangles to the mesh's last group. from: STILB_SCENE_NONE, or a group. */
static inline void torus_add(stilb_scene_mesh *mesh, const uint32_t *indices, uint32_t count, uint32_t from)
{
	bool own = from == STILB_SCENE_NONE;
	uint32_t *to = own ? mesh->indices : mesh->cluster_indices;
	uint32_t *at = own ? &mesh->index_count : &mesh->cluster_index_count;
	for (uint32_t done = 0; done < count;) {
		uint32_t part = count - done < TORUS_CLUSTER_INDICES ? count - done : TORUS_CLUSTER_INDICES;
		stilb_scene_cluster *cluster = &mesh->clusters[mesh->cluster_count++];
		*cluster = (stilb_scene_cluster){.first_index = *at, .index_count = part, .from = from};
		memcpy(to + *at, indices + done, part * sizeof *to);
		torus_sphere(mesh, indices + done, part, cluster->center, &cluster->radius);
		mesh->groups[mesh->group_count].cluster_count++;
		*at += part;
		done += part;
	}
}

/* Ends the mesh's last group: its sphere is about all that its clusters are from. */
static inline void torus_close(stilb_scene_mesh *mesh, uint32_t first_cluster, float error)
{
	stilb_scene_cluster_group *group = &mesh->groups[mesh->group_count++];
	group->first_cluster = first_cluster;
	group->error = error;
	for (uint32_t c = first_cluster; c < mesh->cluster_count; c++)
		for (int k = 0; k < 3; k++)
			group->center[k] += mesh->clusters[c].center[k] / (float)(mesh->cluster_count - first_cluster);
	for (uint32_t c = first_cluster; c < mesh->cluster_count; c++) {
		const stilb_scene_cluster *cluster = &mesh->clusters[c];
		bool own = cluster->from == STILB_SCENE_NONE;
		const float *center = own ? cluster->center : mesh->groups[cluster->from].center;
		float radius = own ? cluster->radius : mesh->groups[cluster->from].radius, square = 0.0f;
		for (int k = 0; k < 3; k++)
			square += (center[k] - group->center[k]) * (center[k] - group->center[k]);
		group->radius = fmaxf(group->radius, (sqrtf(square) + radius) * 1.00001f);
	}
}

/* The groups of blocks of `size` squares a side. */
static inline void torus_round(torus_made *made, uint32_t size, uint32_t step)
{
	stilb_scene_mesh *mesh = made->mesh;
	uint32_t side = TORUS_SIDE / size, first = mesh->group_count;
	for (uint32_t b = 0; b < side * side; b++) {
		uint32_t group = first + b, x = b % side * size, y = b / side * size, first_cluster = mesh->cluster_count;
		if (size == 8) {
			/* The block itself, as if it were the coarser version of something, in four quarters. */
			for (uint32_t q = 0; q < 4; q++) {
				made->counts[group] = 0;
				for (uint32_t i = 0; i < 16; i++)
					torus_square(made, group, x + q % 2 * 4 + i % 4, y + q / 2 * 4 + i / 4, 1);
				torus_add(mesh, made->coarser[group], made->counts[group], STILB_SCENE_NONE);
			}
			made->counts[group] = 0;
		} else {
			uint32_t below = first - 4 * side * side, wide = 2 * side; /* the groups of half the size */
			for (uint32_t q = 0; q < 4; q++) {
				uint32_t from = below + (b / side * 2 + q / 2) * wide + b % side * 2 + q % 2;
				torus_add(mesh, made->coarser[from], made->counts[from], from);
			}
		}
		bool root = side == 1;
		torus_close(mesh, first_cluster, root ? INFINITY : 0.004f * (float)(step * step));
		if (!root)
			torus_simplify(made, group, x, y, size, step);
	}
}

/* Makes the torus: radius 3 about the Y axis, 1 thick, closed. stilb_scene_mesh_finish frees it. */
static inline stilb_scene_mesh torus_make(void)
{
	stilb_scene_mesh mesh = {.vertex_count = TORUS_SIDE * TORUS_SIDE};
	torus_made *made = calloc(1, sizeof *made);
	mesh.vertices = calloc(mesh.vertex_count, sizeof *mesh.vertices);
	mesh.indices = calloc(6 * TORUS_SIDE * TORUS_SIDE, sizeof *mesh.indices);
	mesh.clusters = calloc(2048, sizeof *mesh.clusters);
	mesh.groups = calloc(TORUS_GROUPS, sizeof *mesh.groups);
	mesh.cluster_indices = calloc((size_t)TORUS_GROUPS * 3 * 256, sizeof *mesh.cluster_indices);
	assert_true(made && mesh.vertices && mesh.indices && mesh.clusters && mesh.groups && mesh.cluster_indices);
	for (uint32_t v = 0; v < mesh.vertex_count; v++)
		mesh.vertices[v] = torus_place(v % TORUS_SIDE, v / TORUS_SIDE);
	made->mesh = &mesh;
	for (uint32_t size = 8, step = 2; size <= TORUS_SIDE; size *= 2, step *= 2)
		torus_round(made, size, step);
	assert_int_equal(mesh.group_count, TORUS_GROUPS);
	free(made);
	return mesh;
}

static inline int closed_by_value(const void *a, const void *b)
{
	uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
	return (x > y) - (x < y);
}

/* True if each edge of these triangles is there once in each direction: the surface is closed, and no two pieces of it
 * overlap. */
static inline bool is_closed(const uint32_t *indices, uint32_t count)
{
	uint64_t *edges = malloc((2 * (size_t)count + 1) * sizeof *edges), *back = edges + count;
	assert_non_null(edges);
	for (uint32_t t = 0; t < count; t += 3)
		for (uint32_t k = 0; k < 3; k++) {
			uint64_t a = indices[t + k], b = indices[t + (k + 1) % 3];
			edges[t + k] = a << 32 | b;
			back[t + k] = b << 32 | a;
		}
	qsort(edges, count, sizeof *edges, closed_by_value);
	qsort(back, count, sizeof *back, closed_by_value);
	bool closed = memcmp(edges, back, count * sizeof *edges) == 0;
	for (uint32_t i = 1; i < count; i++)
		closed = closed && edges[i] != edges[i - 1];
	free(edges);
	return closed;
}

#endif
