/* Meshes that are made, and what can be said of any mesh: its edges, its border, the distance of surfaces. */
#ifndef GEOMETRY_MESH_MADE_H
#define GEOMETRY_MESH_MADE_H

#include "support/test.h"

#include "base/base.h"
#include "base/base_math.h"
#include "geometry/geometry_tree.h"
#include "scene/scene.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static inline stilb_scene_mesh mesh_empty(uint32_t vertex_count, uint32_t index_count)
{
	stilb_scene_mesh mesh = {.vertex_count = vertex_count, .index_count = index_count};
	mesh.vertices = calloc(vertex_count + 1, sizeof *mesh.vertices);
	mesh.indices = calloc(index_count + 1, sizeof *mesh.indices);
	assert_non_null(mesh.vertices);
	assert_non_null(mesh.indices);
	return mesh;
}

/* The same vertices and triangles once more, without levels. */
static inline stilb_scene_mesh mesh_copy(const stilb_scene_mesh *mesh)
{
	stilb_scene_mesh copy = mesh_empty(mesh->vertex_count, mesh->index_count);
	memcpy(copy.vertices, mesh->vertices, mesh->vertex_count * sizeof *mesh->vertices);
	memcpy(copy.indices, mesh->indices, mesh->index_count * sizeof *mesh->indices);
	return copy;
}

/* w x h squares of two triangles over uv in [0, 1]. place computes position and normal from uv. */
static inline stilb_scene_mesh mesh_grid(uint32_t w, uint32_t h, void (*place)(stilb_scene_vertex *vertex))
{
	stilb_scene_mesh mesh = mesh_empty((w + 1) * (h + 1), w * h * 6);
	uint32_t *out = mesh.indices;
	for (uint32_t j = 0; j <= h; j++)
		for (uint32_t i = 0; i <= w; i++) {
			stilb_scene_vertex *v = &mesh.vertices[j * (w + 1) + i];
			v->uv[0] = (float)i / (float)w;
			v->uv[1] = (float)j / (float)h;
			place(v);
		}
	for (uint32_t j = 0; j < h; j++)
		for (uint32_t i = 0; i < w; i++) {
			uint32_t a = j * (w + 1) + i, b = a + 1, c = a + w + 1, d = c + 1;
			const uint32_t square[6] = {a, c, b, b, c, d};
			memcpy(out, square, sizeof square);
			out += 6;
		}
	return mesh;
}

/* Normals of the surface: area-weighted means over all triangles at a position, the same for all its vertices. */
static inline void mesh_smooth(stilb_scene_mesh *mesh, const uint32_t *canonical)
{
	for (uint32_t v = 0; v < mesh->vertex_count; v++)
		memset(mesh->vertices[v].normal, 0, sizeof mesh->vertices[v].normal);
	for (uint32_t t = 0; t < mesh->index_count / 3; t++) {
		stilb_vec3 p[3];
		for (int k = 0; k < 3; k++) {
			const float *at = mesh->vertices[mesh->indices[3 * t + (uint32_t)k]].position;
			p[k] = stilb_vec3_make(at[0], at[1], at[2]);
		}
		stilb_vec3 n = stilb_vec3_cross(p[1] - p[0], p[2] - p[0]);
		for (int k = 0; k < 3; k++)
			for (int axis = 0; axis < 3; axis++)
				mesh->vertices[canonical[mesh->indices[3 * t + (uint32_t)k]]].normal[axis] += n[axis];
	}
	for (uint32_t v = 0; v < mesh->vertex_count; v++) {
		float *n = mesh->vertices[v].normal;
		if (canonical[v] != v) {
			memcpy(n, mesh->vertices[canonical[v]].normal, sizeof mesh->vertices[v].normal);
			continue;
		}
		float length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
		for (int axis = 0; axis < 3 && length > 0.0f; axis++)
			n[axis] /= length;
	}
}

/* A bumpy torus, closed, with two seams of the texture. u = 1 and v = 1 are at the places of 0. */
static inline void mesh_place_torus(stilb_scene_vertex *vertex)
{
	float a = 6.2831853f * (vertex->uv[0] == 1.0f ? 0.0f : vertex->uv[0]);
	float b = 6.2831853f * (vertex->uv[1] == 1.0f ? 0.0f : vertex->uv[1]);
	float r = 0.4f * (1.0f + 0.1f * sinf(9.0f * a) * sinf(6.0f * b));
	vertex->position[0] = (1.0f + r * cosf(b)) * cosf(a);
	vertex->position[1] = r * sinf(b);
	vertex->position[2] = (1.0f + r * cosf(b)) * sinf(a);
	vertex->normal[0] = cosf(b) * cosf(a);
	vertex->normal[1] = sinf(b);
	vertex->normal[2] = cosf(b) * sinf(a);
}

/* A hilly square with a border, side 10. */
static inline void mesh_place_hills(stilb_scene_vertex *vertex)
{
	float u = vertex->uv[0], v = vertex->uv[1];
	vertex->position[0] = 10.0f * u;
	vertex->position[1] = 0.4f * sinf(17.0f * u) * cosf(13.0f * v) + 0.05f * sinf(61.0f * u + 7.0f * v);
	vertex->position[2] = 10.0f * v;
	vertex->normal[1] = 1.0f;
}

/* Gives each triangle vertices of its own with its own normal, as in files without shared vertices. */
static inline stilb_scene_mesh mesh_facets(const stilb_scene_mesh *mesh)
{
	stilb_scene_mesh facets = mesh_empty(mesh->index_count, mesh->index_count);
	for (uint32_t i = 0; i < mesh->index_count; i++) {
		facets.vertices[i] = mesh->vertices[mesh->indices[i]];
		facets.indices[i] = i;
	}
	uint32_t *same = malloc(sizeof *same * (mesh->index_count + 1));
	assert_non_null(same);
	for (uint32_t i = 0; i < mesh->index_count; i++)
		same[i] = i;
	mesh_smooth(&facets, same);
	free(same);
	return facets;
}

/* ---- edges ------------------------------------------------------------------------------------------------------- */

typedef struct mesh_edge {
	uint32_t low, high;
	int direction; /* 1: from low to high */
} mesh_edge;

static inline int mesh_by_edge(const void *a, const void *b)
{
	const mesh_edge *l = a, *r = b;
	return l->low != r->low ? (l->low < r->low ? -1 : 1) : (l->high > r->high) - (l->high < r->high);
}

typedef struct mesh_shape {
	uint32_t border, odd; /* edges with one triangle; with more than two, or two that run the same way */
	int euler;            /* positions - edges + triangles */
	double border_length;
} mesh_shape;

/* canonical[v]: the number of a vertex's position. */
static inline mesh_shape mesh_shape_of(const stilb_scene_mesh *mesh, const uint32_t *canonical, const uint32_t *indices,
                                       uint32_t count)
{
	mesh_shape shape = {.euler = (int)(count / 3)};
	mesh_edge *edges = malloc(sizeof *edges * (count + 1));
	uint8_t *used = calloc(mesh->vertex_count + 1, 1);
	assert_non_null(edges);
	assert_non_null(used);
	for (uint32_t i = 0; i < count; i++) {
		uint32_t a = canonical[indices[i]], b = canonical[indices[i % 3 == 2 ? i - 2 : i + 1]];
		assert_int_not_equal(a, b);
		edges[i] = a < b ? (mesh_edge){a, b, 1} : (mesh_edge){b, a, -1};
		shape.euler += used[a] == 0;
		used[a] = 1;
	}
	qsort(edges, count, sizeof *edges, mesh_by_edge);
	for (uint32_t i = 0; i < count;) {
		uint32_t n = 1;
		int sum = edges[i].direction;
		for (; i + n < count && mesh_by_edge(&edges[i], &edges[i + n]) == 0; n++)
			sum += edges[i + n].direction;
		shape.euler--;
		shape.odd += n > 2 || (n == 2 && sum != 0);
		if (n == 1) {
			const float *p = mesh->vertices[edges[i].low].position, *q = mesh->vertices[edges[i].high].position;
			shape.border++;
			shape.border_length += (double)sqrtf((p[0] - q[0]) * (p[0] - q[0]) + (p[1] - q[1]) * (p[1] - q[1]) +
			                                     (p[2] - q[2]) * (p[2] - q[2]));
		}
		i += n;
	}
	free(edges);
	free(used);
	return shape;
}

/* ---- distances --------------------------------------------------------------------------------------------------- */

/* The farthest of `samples` random points of surface a from surface b; every triangle has at least one of them. */
static inline float mesh_farthest(const stilb_scene_mesh *mesh, const uint32_t *a, uint32_t a_count, const uint32_t *b,
                                  uint32_t b_count, uint32_t samples, uint64_t seed)
{
	geometry_tree tree;
	assert_true(geometry_tree_create(mesh->vertices->position, sizeof *mesh->vertices, b, b_count / 3, NULL, 0, &tree));
	float farthest = 0.0f;
	uint32_t each = samples / (a_count / 3) + 1, hint = UINT32_MAX;
	for (uint32_t i = 0; i < a_count / 3 * each; i++) {
		const uint32_t *corner = &a[3 * (i / each)];
		float u = stilb_random_float(seed, 2 * (uint64_t)i), v = stilb_random_float(seed, 2 * (uint64_t)i + 1);
		if (u + v > 1.0f) {
			u = 1.0f - u;
			v = 1.0f - v;
		}
		stilb_vec3 p = {0};
		for (int axis = 0; axis < 3; axis++)
			p[axis] = mesh->vertices[corner[0]].position[axis] * (1.0f - u - v) +
			          mesh->vertices[corner[1]].position[axis] * u + mesh->vertices[corner[2]].position[axis] * v;
		geometry_nearest nearest = geometry_tree_nearest(&tree, p, FLT_MAX, farthest, hint); /* or any that is nearer */
		hint = nearest.triangle;
		farthest = fmaxf(farthest, nearest.square);
	}
	geometry_tree_finish(&tree);
	return sqrtf(farthest);
}

/* ---- meshes with faults ------------------------------------------------------------------------------------------ */

static inline void damage_one_point(stilb_scene_mesh *mesh)
{
	for (uint32_t v = 0; v < mesh->vertex_count; v++)
		memset(mesh->vertices[v].position, 0, 12);
}

static inline void damage_one_line(stilb_scene_mesh *mesh)
{
	for (uint32_t v = 0; v < mesh->vertex_count; v++)
		mesh->vertices[v].position[1] = mesh->vertices[v].position[2] = 0.0f;
}

static inline void damage_tiny(stilb_scene_mesh *mesh)
{
	for (uint32_t v = 0; v < mesh->vertex_count; v++)
		for (int axis = 0; axis < 3; axis++)
			mesh->vertices[v].position[axis] *= 1e-30f;
}

static inline void damage_twice(stilb_scene_mesh *mesh)
{
	memcpy(mesh->indices + mesh->index_count / 2, mesh->indices, mesh->index_count / 2 * sizeof *mesh->indices);
}

/* Random indices: edges with many triangles, triangles twice, fans that touch in a point. */
static inline void damage_indices(stilb_scene_mesh *mesh)
{
	for (uint32_t i = 0; i < mesh->index_count; i++)
		mesh->indices[i] = (uint32_t)(stilb_random_u64(3, i) % (i % 2 ? 40 : mesh->vertex_count));
}

#endif
