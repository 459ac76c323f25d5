/* What the tests of surfaces with maps share: squares whose surfaces are made by scene_build.h, made ready for rays. */
#ifndef GI_MAPS_FIXTURE_H
#define GI_MAPS_FIXTURE_H

#include "gi/gi_world_fixture.h"

#include "scene/scene_build.h"

/* A mesh with its vertices, so that it lasts as long as its owner. */
typedef struct maps_square {
	stilb_scene_vertex vertices[4];
	stilb_scene_vertex_extra extras[4];
	uint32_t indices[6];
	stilb_scene_mesh mesh;
} maps_square;

/* [-1, 1]^2 at z = 0 facing +Z. Both uv are (0, 0) at (-1, 1), the top left, and (1, 1) at (1, -1); sign -1: u of the
 * first runs the other way, and the tangent with it. */
static inline void maps_square_make(maps_square *square, float sign)
{
	*square = (maps_square){.indices = {0, 1, 2, 2, 1, 3}};
	for (uint32_t i = 0; i < 4; i++) {
		float x = i & 1 ? 1.0f : -1.0f, y = i & 2 ? 1.0f : -1.0f;
		square->vertices[i] = (stilb_scene_vertex){
			.position = {x, y, 0.0f}, .normal = {0.0f, 0.0f, 1.0f}, .uv = {0.5f + 0.5f * sign * x, 0.5f - 0.5f * y}};
		square->extras[i] = (stilb_scene_vertex_extra){.tangent = {sign, 0.0f, 0.0f, sign},
		                                               .uv = {0.5f + 0.5f * x, 0.5f - 0.5f * y},
		                                               .color = {1.0f, 1.0f, 1.0f, 1.0f}};
	}
	square->mesh = (stilb_scene_mesh){.vertices = square->vertices,
	                                  .extras = square->extras,
	                                  .indices = square->indices,
	                                  .vertex_count = 4,
	                                  .index_count = 6};
}

/* Adds a model of one part with a material of this surface. */
static inline void maps_add(stilb_scene_build *build, const stilb_scene_mesh *mesh, const stilb_scene_surface *surface,
                            const stilb_mat4 *place)
{
	stilb_scene_material material = {.roughness = 1.0f, .surface = 1 + stilb_scene_build_surface(build, surface)};
	stilb_scene_build_part part = {stilb_scene_build_mesh(build, mesh), stilb_scene_build_material(build, &material)};
	stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, place), &part, 1);
}

static inline stilb_scene *maps_end(stilb_scene_build *build)
{
	stilb_scene *scene;
	if (stilb_scene_build_end(build, &scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return scene;
}

/* One square of this surface at a place, with its textures. */
static inline stilb_scene *maps_scene(const maps_square *square, const stilb_scene_surface *surface,
                                      const stilb_image *textures, uint32_t texture_count, const stilb_mat4 *place)
{
	stilb_scene_build *build = stilb_scene_build_begin();
	for (uint32_t i = 0; i < texture_count; i++)
		stilb_scene_build_texture(build, &textures[i]);
	maps_add(build, &square->mesh, surface, place);
	return maps_end(build);
}

static inline world_fixture maps_trace(stilb_scene *scene, bool movable)
{
	world_fixture fixture = {.scene = scene};
	stilb_job_pool_desc pool = stilb_job_pool_desc_default();
	pool.worker_count = 0;
	assert_int_equal(stilb_job_pool_create(&pool, &fixture.pool), 0);
	stilb_gi_scene_desc desc = {.pool = fixture.pool, .intersector = &stilb_gi_embree, .movable = movable};
	if (stilb_gi_scene_create(scene, &desc, &fixture.gi) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return fixture;
}

/* What a ray from there finds, which must be something. */
static inline gi_surface maps_look(const stilb_gi_scene *gi, stilb_vec3 origin, stilb_vec3 direction)
{
	gi_ray_hit ray = gi_ray_hit_make(origin, stilb_vec3_normalize(direction));
	gi_surface surface;
	gi->tracer.intersect(&gi->tracer, &ray);
	assert_true(gi_is_hit(&ray));
	gi_surface_at(gi, &ray, &surface);
	return surface;
}

/* Straight down onto (x, y) of a square that was not moved. */
static inline gi_surface maps_at_point(const stilb_gi_scene *gi, float x, float y)
{
	return maps_look(gi, stilb_vec3_make(x, y, 1.0f), stilb_vec3_make(0.0f, 0.0f, -1.0f));
}

#endif
