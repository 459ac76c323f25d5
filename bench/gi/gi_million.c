/* A scene of as many well-shaped triangles as wanted, for comparisons with Embree. */
#include "bench/gi/gi_run.h"
#include "scene/scene_internal.h"

#include <stdlib.h>

#define BALLS_A_SIDE 3u
#define BALLS (BALLS_A_SIDE * BALLS_A_SIDE * BALLS_A_SIDE)
#define HALF 10.0f

static const float pi = 3.14159265f;

static void mesh_alloc(stilb_scene_mesh *mesh, uint32_t vertices, uint32_t indices)
{
	mesh->vertices = stilb_memory_alloc(vertices, sizeof *mesh->vertices);
	mesh->indices = stilb_memory_alloc(indices, sizeof *mesh->indices);
	if (!mesh->vertices || !mesh->indices)
		bench_child_fail("no memory for the scene");
	mesh->vertex_count = vertices;
	mesh->index_count = indices;
}

/* Makes ball `number`: a bumpy sphere of 4 rings^2 triangles. They leave out the poles, where triangles would have no
 * area. */
static void ball(stilb_scene_mesh *mesh, uint32_t number, uint32_t rings)
{
	uint32_t segments = 2 * rings;
	float center[3];
	for (uint32_t c = 0, rest = number; c < 3; c++, rest /= BALLS_A_SIDE)
		center[c] = 6.0f * ((float)(rest % BALLS_A_SIDE) - 1.0f);
	mesh_alloc(mesh, (rings + 1) * segments, rings * segments * 6);
	for (uint32_t r = 0; r <= rings; r++)
		for (uint32_t s = 0; s < segments; s++) {
			float theta = 0.01f + (pi - 0.02f) * (float)r / (float)rings, phi = 2.0f * pi * (float)s / (float)segments;
			float n[3] = {sinf(theta) * cosf(phi), cosf(theta), sinf(theta) * sinf(phi)};
			float bump = sinf(11.0f * n[0] + (float)number) * sinf(13.0f * n[1]) * sinf(12.0f * n[2]);
			stilb_scene_vertex *v = &mesh->vertices[r * segments + s];
			*v = (stilb_scene_vertex){.normal = {n[0], n[1], n[2]}};
			for (int c = 0; c < 3; c++)
				v->position[c] = center[c] + 2.2f * (1.0f + 0.1f * bump) * n[c];
		}
	uint32_t *index = mesh->indices;
	for (uint32_t r = 0; r < rings; r++)
		for (uint32_t s = 0; s < segments; s++) {
			uint32_t next = (s + 1) % segments;
			uint32_t a = r * segments + s, b = r * segments + next, c = a + segments, d = b + segments;
			const uint32_t quad[6] = {a, b, c, b, d, c};
			for (int i = 0; i < 6; i++)
				*index++ = quad[i];
		}
}

/* Faces [first, first + count) of the box, visible from inside; each is spanned by two axes on one side. */
static void faces(stilb_scene_mesh *mesh, uint32_t first, uint32_t count)
{
	static const struct {
		int u, v, n;
		float side;
	} face[6] = {{0, 2, 1, 1.0f}, {2, 0, 1, -1.0f}, {1, 2, 0, -1.0f},
	             {2, 1, 0, 1.0f}, {0, 1, 2, -1.0f}, {1, 0, 2, 1.0f}};
	static const float corner[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
	static const uint32_t quad[6] = {0, 1, 2, 0, 2, 3};
	mesh_alloc(mesh, 4 * count, 6 * count);
	for (uint32_t f = 0; f < count; f++) {
		for (uint32_t k = 0; k < 4; k++) {
			stilb_scene_vertex *v = &mesh->vertices[4 * f + k];
			*v = (stilb_scene_vertex){0};
			v->position[face[first + f].u] = HALF * corner[k][0];
			v->position[face[first + f].v] = HALF * corner[k][1];
			v->position[face[first + f].n] = HALF * face[first + f].side;
			v->normal[face[first + f].n] = -face[first + f].side;
		}
		for (uint32_t i = 0; i < 6; i++)
			mesh->indices[6 * f + i] = 4 * f + quad[i];
	}
}

stilb_scene *gi_run_balls(uint32_t rings)
{
	static const float grey[3] = {0.7f, 0.7f, 0.7f}, none[3] = {0};
	stilb_scene *scene;
	gi_run_check(scene_create(1, BALLS + 2, BALLS + 2, 2, &scene), "the scene");
	for (uint32_t i = 0; i < BALLS; i++)
		ball(&scene->meshes[i], i, rings);
	faces(&scene->meshes[BALLS], 1, 5);
	faces(&scene->meshes[BALLS + 1], 0, 1);
	for (uint32_t p = 0; p < BALLS + 2; p++) {
		scene->part_mesh[p] = p;
		scene->part_material[p] = p == BALLS + 1;
		scene->part_transform[p] = stilb_mat4_identity();
	}
	scene->first_part[1] = BALLS + 2;
	scene->bounds.radius[0] = 1.8f * HALF;
	for (int m = 0; m < 2; m++)
		scene->materials[m] = stilb_scene_material_make(grey, none, 1.0f);
	for (int c = 0; c < 3; c++)
		scene->materials[1].emission[c] = 4.0f;
	scene->camera = (stilb_scene_camera){
		.position = {9.0f, 8.0f, 9.5f}, .yaw = 0.75f, .pitch = -0.5f, .fov_y = 1.2f, .near_z = 0.1f, .far_z = 100.0f};
	return scene;
}

stilb_scene *gi_run_million(void)
{
	return gi_run_balls(98);
}
