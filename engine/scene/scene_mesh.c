#include "scene/scene_internal.h"

#include <stdlib.h>

stilb_result scene_mesh_create(stilb_scene_mesh *mesh, uint32_t vertex_count, uint32_t index_count)
{
	STILB_ASSERT(mesh);
	STILB_ASSERT(index_count % 3 == 0);
	*mesh = (stilb_scene_mesh){
		.vertices = stilb_memory_alloc(vertex_count, sizeof(stilb_scene_vertex)),
		.indices = stilb_memory_alloc(index_count, sizeof(uint32_t)),
		.vertex_count = vertex_count,
		.index_count = index_count,
	};
	if (mesh->vertices && mesh->indices)
		return STILB_OK;
	stilb_scene_mesh_finish(mesh);
	return stilb_fail(STILB_ERROR_MEMORY, "no memory for a mesh of %u vertices", vertex_count);
}

void stilb_scene_mesh_finish(stilb_scene_mesh *mesh)
{
	STILB_ASSERT(mesh);
	free(mesh->vertices);
	free(mesh->indices);
	*mesh = (stilb_scene_mesh){0};
}

stilb_result stilb_scene_mesh_plane(stilb_scene_mesh *mesh)
{
	static const float corners[4][2] = {{-1, -1}, {-1, 1}, {1, 1}, {1, -1}};
	static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
	stilb_result result = scene_mesh_create(mesh, 4, 6);
	if (result != STILB_OK)
		return result;
	for (int i = 0; i < 4; i++) {
		float x = corners[i][0], z = corners[i][1];
		mesh->vertices[i] = (stilb_scene_vertex){{x, 0.0f, z}, {0.0f, 1.0f, 0.0f}, {0.5f * x + 0.5f, 0.5f * z + 0.5f}};
	}
	for (int i = 0; i < 6; i++)
		mesh->indices[i] = indices[i];
	return STILB_OK;
}

/* ---- the sphere: an icosahedron whose triangles are split into four, the new vertices moved onto the sphere ------ */

#define MESH_EDGES 6 /* a vertex has at most this many */

/* The edges that have been given a vertex in their middle already. An edge is listed at that one of its two end
 * vertices which has the smaller index. */
typedef struct mesh_edges {
	uint32_t (*other)[MESH_EDGES];  /* [vertex]: the edge's other end */
	uint32_t (*middle)[MESH_EDGES]; /* [vertex]: the vertex in its middle */
	uint8_t *used;                  /* [vertex]: entries in use */
} mesh_edges;

/* Adds a vertex: the point of the unit sphere in the direction p. */
static void mesh_add_vertex(stilb_scene_mesh *mesh, stilb_vec3 p)
{
	p = stilb_vec3_normalize(p);
	float u = 0.5f + atan2f(p[0], p[2]) * 0.15915494309189535f; /* 1 / (2 pi) */
	float v = acosf(p[1] < -1.0f ? -1.0f : p[1] > 1.0f ? 1.0f : p[1]) * 0.31830988618379067f;
	mesh->vertices[mesh->vertex_count++] = (stilb_scene_vertex){{p[0], p[1], p[2]}, {p[0], p[1], p[2]}, {u, v}};
}

/* The vertex in the middle of an edge, made if there is none yet. */
static uint32_t mesh_edge_middle(stilb_scene_mesh *mesh, mesh_edges *edges, uint32_t a, uint32_t b)
{
	uint32_t low = a < b ? a : b, high = a < b ? b : a;
	for (int i = 0; i < edges->used[low]; i++)
		if (edges->other[low][i] == high)
			return edges->middle[low][i];
	const float *p = mesh->vertices[low].position, *q = mesh->vertices[high].position;
	STILB_ASSERT(low < high && edges->used[low] < MESH_EDGES);
	uint32_t slot = edges->used[low]++;
	edges->other[low][slot] = high;
	edges->middle[low][slot] = mesh->vertex_count;
	mesh_add_vertex(mesh, stilb_vec3_make(p[0] + q[0], p[1] + q[1], p[2] + q[2]));
	return edges->middle[low][slot];
}

/* Replaces every triangle by four. Goes from the last triangle to the first: the four overwrite no triangle that is
 * still to be split. */
static void mesh_split(stilb_scene_mesh *mesh, mesh_edges *edges)
{
	uint32_t triangles = mesh->index_count / 3;
	for (uint32_t v = 0; v < mesh->vertex_count; v++)
		edges->used[v] = 0;
	for (uint32_t t = triangles; t-- > 0;) {
		uint32_t corner[3], middle[3], *out = &mesh->indices[(size_t)12 * t];
		for (int i = 0; i < 3; i++)
			corner[i] = mesh->indices[3 * t + (uint32_t)i];
		for (int i = 0; i < 3; i++)
			middle[i] = mesh_edge_middle(mesh, edges, corner[i], corner[(i + 1) % 3]);
		const uint32_t split[12] = {corner[0], middle[0], middle[2], middle[0], corner[1], middle[1],
		                            middle[2], middle[1], corner[2], middle[0], middle[1], middle[2]};
		for (int i = 0; i < 12; i++)
			out[i] = split[i];
	}
	mesh->index_count *= 4;
}

static void mesh_icosahedron(stilb_scene_mesh *mesh)
{
	/* Poles on the Y axis; two rings of five at latitude +-atan(1/2). */
	float y = 0.44721359549995794f, r = 0.8944271909999159f, turn = 0.62831853071795865f;
	mesh_add_vertex(mesh, stilb_vec3_make(0, 1, 0));
	for (int ring = 0; ring < 2; ring++)
		for (int i = 0; i < 5; i++) {
			float angle = turn * (float)(2 * i + ring);
			mesh_add_vertex(mesh, stilb_vec3_make(r * sinf(angle), ring ? -y : y, r * cosf(angle)));
		}
	mesh_add_vertex(mesh, stilb_vec3_make(0, -1, 0));
	uint32_t *out = mesh->indices;
	for (uint32_t i = 0; i < 5; i++) {
		uint32_t upper = 1 + i, upper_next = 1 + (i + 1) % 5, lower = 6 + i, lower_next = 6 + (i + 1) % 5;
		const uint32_t triangles[12] = {0,     upper,      upper_next, upper, lower,      upper_next,
		                                lower, lower_next, upper_next, 11,    lower_next, lower};
		for (int k = 0; k < 12; k++)
			*out++ = triangles[k];
	}
	mesh->index_count = 60;
}

stilb_result stilb_scene_mesh_sphere(uint32_t splits, stilb_scene_mesh *mesh)
{
	STILB_ASSERT(splits <= 6 && mesh);
	uint32_t triangles = 20u << (2 * splits), vertices = triangles / 2 + 2; /* Euler's formula for triangles */
	stilb_result result = scene_mesh_create(mesh, vertices, triangles * 3);
	if (result != STILB_OK)
		return result;
	mesh_edges edges = {
		.other = stilb_memory_alloc(vertices, sizeof *edges.other),
		.middle = stilb_memory_alloc(vertices, sizeof *edges.middle),
		.used = stilb_memory_alloc(vertices, 1),
	};
	if (edges.other && edges.middle && edges.used) {
		mesh->vertex_count = 0;
		mesh_icosahedron(mesh);
		for (uint32_t i = 0; i < splits; i++)
			mesh_split(mesh, &edges);
		STILB_ASSERT(mesh->vertex_count == vertices && mesh->index_count == 3 * triangles);
		STILB_CHECK(scene_mesh_is_sound(mesh));
	} else {
		stilb_scene_mesh_finish(mesh);
		result = stilb_fail(STILB_ERROR_MEMORY, "no memory for a sphere of %u triangles", triangles);
	}
	free(edges.other);
	free(edges.middle);
	free(edges.used);
	return result;
}
