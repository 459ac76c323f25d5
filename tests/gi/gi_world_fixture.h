/* What the tests of rays share: scenes made of a few meshes, made ready for rays. */
#ifndef GI_WORLD_FIXTURE_H
#define GI_WORLD_FIXTURE_H

#include "gi/gi_surface.h"
#include "gi/trace/gi_ray.h"
#include "scene/scene_internal.h"
#include "support/shade_proof.h"

#include <string.h>

typedef struct world_fixture {
	stilb_job_pool *pool;
	stilb_scene *scene; /* may be changed between make and trace */
	stilb_gi_scene *gi;
} world_fixture;

/* One model of `parts` parts of mesh 0 and material 0, at the origin; all materials are half grey, meshes are empty. */
static inline stilb_scene *world_scene(uint32_t parts, uint32_t meshes, uint32_t materials)
{
	stilb_scene *scene;
	assert_int_equal(scene_create(1, parts, meshes, materials, &scene), STILB_OK);
	scene->first_part[1] = parts;
	for (uint32_t part = 0; part < parts; part++)
		scene->part_transform[part] = stilb_mat4_identity();
	for (uint32_t i = 0; i < materials; i++)
		scene->materials[i] = (stilb_scene_material){.diffuse = {0.5f, 0.5f, 0.5f}, .roughness = 1.0f};
	return scene;
}

static inline world_fixture world_trace(stilb_scene *scene, const stilb_gi_intersector *intersector, uint32_t workers)
{
	world_fixture fixture = {.scene = scene};
	stilb_job_pool_desc pool = stilb_job_pool_desc_default();
	pool.worker_count = workers;
	assert_int_equal(stilb_job_pool_create(&pool, &fixture.pool), 0);
	stilb_gi_scene_desc desc = {.pool = fixture.pool, .intersector = intersector};
	if (stilb_gi_scene_create(scene, &desc, &fixture.gi) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return fixture;
}

/* Destroys the fixture but for its scene. */
static inline void world_untrace(world_fixture *fixture)
{
	stilb_gi_scene_destroy(fixture->gi);
	stilb_job_pool_destroy(fixture->pool);
}

static inline void world_finish(world_fixture *fixture)
{
	world_untrace(fixture);
	stilb_scene_destroy(fixture->scene);
}

/* Three vertices, (0, 0, 1) their normal, each its own uv: (0, 0), (1, 0), (0, 1). */
static inline void world_triangle(stilb_scene_mesh *mesh, const float corners[3][3])
{
	assert_int_equal(scene_mesh_create(mesh, 3, 3), STILB_OK);
	for (uint32_t i = 0; i < 3; i++) {
		mesh->vertices[i] = (stilb_scene_vertex){.normal = {0.0f, 0.0f, 1.0f}, .uv = {i == 1, i == 2}};
		memcpy(mesh->vertices[i].position, corners[i], sizeof mesh->vertices[i].position);
		mesh->indices[i] = i;
	}
}

/* A mesh of random triangles anywhere in [-1, 1]^3, of all sizes and shapes. */
static inline void world_soup(stilb_scene_mesh *mesh, uint32_t count, shade_proof_random *random)
{
	assert_int_equal(scene_mesh_create(mesh, 3 * count, 3 * count), STILB_OK);
	for (uint32_t i = 0; i < 3 * count; i++) {
		stilb_scene_vertex *vertex = &mesh->vertices[i];
		*vertex = (stilb_scene_vertex){.normal = {0.0f, 1.0f, 0.0f}};
		for (int k = 0; k < 3; k++)
			vertex->position[k] = shade_proof_range(random, -1.0f, 1.0f);
		mesh->indices[i] = i;
	}
}

static inline stilb_vec3 world_direction(shade_proof_random *random)
{
	for (;;) {
		stilb_vec3 v = {0};
		for (int k = 0; k < 3; k++)
			v[k] = shade_proof_range(random, -1.0f, 1.0f);
		float square = stilb_vec3_dot(v, v);
		if (square <= 1.0f && square > 1e-4f)
			return stilb_vec3_normalize(v);
	}
}

#endif
