#include "scene/scene_internal.h"

#include <stdlib.h>
#include <string.h>

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

stilb_result scene_mesh_add_extras(stilb_scene_mesh *mesh)
{
	STILB_ASSERT(mesh && !mesh->extras);
	mesh->extras = stilb_memory_alloc(mesh->vertex_count, sizeof *mesh->extras);
	if (!mesh->extras)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for tangents of a mesh of %u vertices", mesh->vertex_count);
	for (uint32_t v = 0; v < mesh->vertex_count; v++)
		mesh->extras[v] = (stilb_scene_vertex_extra){.color = {1, 1, 1, 1}};
	return STILB_OK;
}

stilb_result scene_mesh_add_levels(stilb_scene_mesh *mesh, uint32_t level_count, uint32_t level_index_count, bool morph)
{
	STILB_ASSERT(mesh && mesh->level_count == 0 && level_count > 0 && level_index_count > 0);
	mesh->levels = stilb_memory_alloc(level_count, sizeof *mesh->levels);
	mesh->level_indices = stilb_memory_alloc(level_index_count, sizeof *mesh->level_indices);
	mesh->morph = morph ? stilb_memory_alloc(mesh->vertex_count, sizeof *mesh->morph) : NULL;
	if (!mesh->levels || !mesh->level_indices || (morph && !mesh->morph))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the %u levels of a mesh", level_count);
	if (morph && mesh->vertex_count > 0)
		memset(mesh->morph, 0, mesh->vertex_count * sizeof *mesh->morph);
	mesh->level_count = level_count;
	mesh->level_index_count = level_index_count;
	return STILB_OK;
}

stilb_result scene_mesh_add_clusters(stilb_scene_mesh *mesh, uint32_t cluster_count, uint32_t group_count,
                                     uint32_t cluster_index_count)
{
	STILB_ASSERT(mesh && mesh->cluster_count == 0 && cluster_count > 0 && group_count > 0);
	mesh->clusters = stilb_memory_alloc(cluster_count, sizeof *mesh->clusters);
	mesh->groups = stilb_memory_alloc(group_count, sizeof *mesh->groups);
	mesh->cluster_indices = stilb_memory_alloc(cluster_index_count, sizeof *mesh->cluster_indices);
	if (!mesh->clusters || !mesh->groups || !mesh->cluster_indices)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the %u clusters of a mesh", cluster_count);
	mesh->cluster_count = cluster_count;
	mesh->group_count = group_count;
	mesh->cluster_index_count = cluster_index_count;
	return STILB_OK;
}

void stilb_scene_mesh_drop_levels(stilb_scene_mesh *mesh)
{
	free(mesh->levels);
	free(mesh->level_indices);
	free(mesh->morph);
	mesh->levels = NULL;
	mesh->level_indices = NULL;
	mesh->morph = NULL;
	mesh->level_count = mesh->level_index_count = 0;
	free(mesh->clusters);
	free(mesh->groups);
	free(mesh->cluster_indices);
	mesh->clusters = NULL;
	mesh->groups = NULL;
	mesh->cluster_indices = NULL;
	mesh->cluster_count = mesh->group_count = mesh->cluster_index_count = 0;
}

void stilb_scene_mesh_finish(stilb_scene_mesh *mesh)
{
	STILB_ASSERT(mesh);
	stilb_scene_mesh_drop_levels(mesh);
	free(mesh->vertices);
	free(mesh->extras);
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

/* What interpolation gives in the middle between two vertices. */
static stilb_scene_vertex mesh_vertex_between(const stilb_scene_vertex *p, const stilb_scene_vertex *q)
{
	stilb_scene_vertex mean;
	for (int i = 0; i < 3; i++) {
		mean.position[i] = 0.5f * (p->position[i] + q->position[i]);
		mean.normal[i] = 0.5f * (p->normal[i] + q->normal[i]);
	}
	for (int i = 0; i < 2; i++)
		mean.uv[i] = 0.5f * (p->uv[i] + q->uv[i]);
	return mean;
}

/* The vertex in the middle of an edge, made if there is none yet. */
static uint32_t mesh_edge_middle(stilb_scene_mesh *mesh, mesh_edges *edges, uint32_t a, uint32_t b)
{
	uint32_t low = a < b ? a : b, high = a < b ? b : a;
	for (int i = 0; i < edges->used[low]; i++)
		if (edges->other[low][i] == high)
			return edges->middle[low][i];
	const stilb_scene_vertex *p = &mesh->vertices[low], *q = &mesh->vertices[high];
	STILB_ASSERT(low < high && edges->used[low] < MESH_EDGES && mesh->morph);
	uint32_t slot = edges->used[low]++;
	edges->other[low][slot] = high;
	edges->middle[low][slot] = mesh->vertex_count;
	mesh->morph[mesh->vertex_count] = mesh_vertex_between(p, q);
	mesh_add_vertex(mesh, stilb_vec3_make(p->position[0] + q->position[0], p->position[1] + q->position[1],
	                                      p->position[2] + q->position[2]));
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

/* Vertices v and v + 6, for v below 6, are the ends of an edge, and no triangle has two of these six edges. With each
 * drawn together at vertex v, the 12 triangles beside them vanish, and 8 are left: an octahedron, whose faces are as
 * near to the sphere as those of any that has six of the icosahedron's vertices. */
static void mesh_icosahedron(stilb_scene_mesh *mesh)
{
	/* Poles on the Y axis; two rings of five at latitude +-atan(1/2). */
	float y = 0.44721359549995794f, r = 0.8944271909999159f, turn = 0.62831853071795865f;
	float places[12][3] = {{0.0f, 1.0f, 0.0f}, [11] = {0.0f, -1.0f, 0.0f}};
	for (int ring = 0; ring < 2; ring++)
		for (int i = 0; i < 5; i++) {
			float angle = turn * (float)(2 * i + ring), *place = places[1 + 5 * ring + i];
			place[0] = r * sinf(angle);
			place[1] = ring ? -y : y;
			place[2] = r * cosf(angle);
		}
	for (uint32_t v = 0; v < 12; v++) {
		const float *place = places[v < 6 ? 2 * v + 1 : 2 * (v - 6)];
		mesh_add_vertex(mesh, stilb_vec3_make(place[0], place[1], place[2]));
	}
	for (uint32_t v = 6; v < 12 && mesh->morph; v++)
		mesh->morph[v] = mesh->vertices[v - 6];
	uint32_t *out = mesh->indices;
	for (uint32_t i = 0; i < 5; i++) {
		uint32_t upper = 1 + i, upper_next = 1 + (i + 1) % 5, lower = 6 + i, lower_next = 6 + (i + 1) % 5;
		const uint32_t triangles[12] = {0,     upper,      upper_next, upper, lower,      upper_next,
		                                lower, lower_next, upper_next, 11,    lower_next, lower};
		for (int k = 0; k < 12; k++)
			*out++ = triangles[k] % 2 == 1 ? triangles[k] / 2 : 6 + triangles[k] / 2;
	}
	mesh->index_count = 60;
}

#define MESH_COARSEST_INDICES 24u

/* Keeps what the icosahedron becomes with its six edges drawn together as the coarsest level. */
static void mesh_keep_coarsest(stilb_scene_mesh *mesh)
{
	uint32_t *out = mesh->level_indices;
	STILB_ASSERT(mesh->index_count == 60 && mesh->level_count > 0);
	for (uint32_t t = 0; t < 60; t += 3) {
		uint32_t corner[3];
		for (uint32_t c = 0; c < 3; c++)
			corner[c] = mesh->indices[t + c] % 6;
		if (corner[0] != corner[1] && corner[1] != corner[2] && corner[2] != corner[0])
			for (int c = 0; c < 3; c++)
				*out++ = corner[c];
	}
	STILB_ASSERT(out == mesh->level_indices + MESH_COARSEST_INDICES);
	mesh->levels[mesh->level_count - 1] = (stilb_scene_level){.index_count = MESH_COARSEST_INDICES, .vertex_count = 6};
}

/* Keeps the triangles so far as level number `level`, behind those of the coarser ones. */
static void mesh_keep_level(stilb_scene_mesh *mesh, uint32_t level, uint32_t first_index)
{
	STILB_ASSERT(level < mesh->level_count && first_index + mesh->index_count <= mesh->level_index_count);
	mesh->levels[level] = (stilb_scene_level){
		.first_index = first_index, .index_count = mesh->index_count, .vertex_count = mesh->vertex_count};
	for (uint32_t i = 0; i < mesh->index_count; i++)
		mesh->level_indices[first_index + i] = mesh->indices[i];
}

/* How far vertices of the sphere lie outside of the plane of a level's triangle, along the line to the centre, at most;
 * 0: all are inside. */
static float mesh_sphere_error(const stilb_scene_mesh *mesh, const uint32_t corners[3], const uint32_t *indices,
                               uint32_t count)
{
	stilb_vec3 p[3];
	for (int i = 0; i < 3; i++) {
		const float *position = mesh->vertices[corners[i]].position;
		p[i] = stilb_vec3_make(position[0], position[1], position[2]);
	}
	stilb_vec3 normal = stilb_vec3_cross(p[1] - p[0], p[2] - p[0]);
	float distance = stilb_vec3_dot(normal, p[0]), error = 0.0f;
	for (uint32_t i = 0; i < count; i++) {
		const float *v = mesh->vertices[indices[i]].position;
		float along = normal[0] * v[0] + normal[1] * v[1] + normal[2] * v[2];
		if (along > 0.0f)
			error = fmaxf(error, 1.0f - distance / along);
	}
	return error;
}

/* The levels' errors. Level and sphere are convex, and the level lies inside the sphere, since its vertices are some of
 * the sphere's. The largest distance between the surfaces of two such bodies is that of a point of the outer one from
 * the inner one (Schneider, "Convex Bodies" (1993), lemma 1.8.1), which is a convex function and so largest at a
 * vertex. The way from there towards the centre to the level is no shorter, and ends at the plane that it meets first.
 * Of the levels that were split, that is the plane of the triangle from which the vertex comes; of the coarsest one all
 * planes are tried. */
static void mesh_sphere_errors(stilb_scene_mesh *mesh)
{
	for (uint32_t l = 0; l < mesh->level_count; l++) {
		stilb_scene_level *level = &mesh->levels[l];
		bool coarsest = l + 1 == mesh->level_count;
		uint32_t triangles = level->index_count / 3,
				 inner = coarsest ? 0 : 3 * (mesh->index_count / level->index_count);
		for (uint32_t t = 0; t < triangles; t++)
			level->error =
				fmaxf(level->error,
			          mesh_sphere_error(mesh, mesh->level_indices + level->first_index + (size_t)3 * t,
			                            mesh->indices + (size_t)inner * t, coarsest ? mesh->index_count : inner));
		level->error += 1e-6f; /* for rounding */
	}
}

static stilb_result mesh_sphere_create(uint32_t splits, stilb_scene_mesh *mesh)
{
	uint32_t triangles = 20u << (2 * splits), vertices = triangles / 2 + 2; /* Euler's formula for triangles */
	stilb_result result = scene_mesh_create(mesh, vertices, triangles * 3);
	if (result != STILB_OK || splits == 0)
		return result;
	/* 3 * 20 (1 + 4 + 16 + ...), and the coarsest one */
	result = scene_mesh_add_levels(mesh, splits + 1, triangles - 20 + MESH_COARSEST_INDICES, true);
	if (result != STILB_OK)
		stilb_scene_mesh_finish(mesh);
	return result;
}

stilb_result stilb_scene_mesh_sphere(uint32_t splits, stilb_scene_mesh *mesh)
{
	STILB_ASSERT(splits <= 6 && mesh);
	stilb_result result = mesh_sphere_create(splits, mesh);
	if (result != STILB_OK)
		return result;
	uint32_t vertices = mesh->vertex_count, indices = mesh->index_count, first_index = MESH_COARSEST_INDICES;
	mesh_edges edges = {
		.other = stilb_memory_alloc(vertices, sizeof *edges.other),
		.middle = stilb_memory_alloc(vertices, sizeof *edges.middle),
		.used = stilb_memory_alloc(vertices, 1),
	};
	if (edges.other && edges.middle && edges.used) {
		mesh->vertex_count = 0;
		mesh_icosahedron(mesh);
		if (splits > 0)
			mesh_keep_coarsest(mesh);
		for (uint32_t i = 0; i < splits; i++) {
			mesh_keep_level(mesh, splits - 1 - i, first_index);
			first_index += mesh->index_count;
			mesh_split(mesh, &edges);
		}
		STILB_ASSERT(mesh->vertex_count == vertices && mesh->index_count == indices);
		mesh_sphere_errors(mesh);
		STILB_CHECK(scene_mesh_is_sound(mesh));
	} else {
		stilb_scene_mesh_finish(mesh);
		result = stilb_fail(STILB_ERROR_MEMORY, "no memory for a sphere of %u triangles", indices / 3);
	}
	free(edges.other);
	free(edges.middle);
	free(edges.used);
	return result;
}
