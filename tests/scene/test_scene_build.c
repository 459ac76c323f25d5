/* A scene built by a program: the same as one made inside, each mistake told in words, nothing lost without memory. */
#include "scene/scene_build.h"
#include "scene/scene_internal.h"
#include "support/failing_memory.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>

void *__real_stilb_memory_alloc(size_t count, size_t size);
void *__wrap_stilb_memory_alloc(size_t count, size_t size);
void *__wrap_stilb_memory_alloc(size_t count, size_t size)
{
	return allocation_fails() ? NULL : __real_stilb_memory_alloc(count, size);
}

static stilb_mat4 moved(float x, float y, float z)
{
	return stilb_mat4_scale_translate(1.0f, x, y, z);
}

/* ---- the same scene ---------------------------------------------------------------------------------------------- */

/* Builds `from` anew, with a model for each of its parts. */
static stilb_result rebuild(const stilb_scene *from, stilb_scene **scene)
{
	stilb_scene_build *build = stilb_scene_build_begin();
	for (uint32_t i = 0; i < from->texture_count; i++)
		stilb_scene_build_texture(build, &from->textures[i]);
	for (uint32_t i = 0; i < from->mesh_count; i++)
		stilb_scene_build_mesh(build, &from->meshes[i]);
	for (uint32_t i = 0; i < from->material_count; i++)
		stilb_scene_build_material(build, &from->materials[i]);
	for (uint32_t p = 0; p < from->part_count; p++) {
		uint32_t node = stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &from->part_transform[p]);
		stilb_scene_build_part part = {from->part_mesh[p], from->part_material[p]};
		stilb_scene_build_model(build, node, &part, 1);
	}
	for (uint32_t i = 0; i < from->light_count; i++)
		stilb_scene_build_light(build, &from->lights[i]);
	stilb_scene_build_surroundings(build, &from->surroundings);
	stilb_scene_build_camera(build, &from->camera);
	return stilb_scene_build_end(build, scene);
}

static void assert_same(const stilb_scene *a, const stilb_scene *b)
{
	assert_int_equal(a->part_count, b->part_count);
	assert_memory_equal(a->part_mesh, b->part_mesh, a->part_count * sizeof *a->part_mesh);
	assert_memory_equal(a->part_material, b->part_material, a->part_count * sizeof *a->part_material);
	assert_memory_equal(a->part_transform, b->part_transform, a->part_count * sizeof *a->part_transform);
	assert_int_equal(a->material_count, b->material_count);
	assert_memory_equal(a->materials, b->materials, a->material_count * sizeof *a->materials);
	assert_int_equal(a->light_count, b->light_count);
	assert_true(a->light_count == 0 || memcmp(a->lights, b->lights, a->light_count * sizeof *a->lights) == 0);
	assert_memory_equal(a->surroundings.sky, b->surroundings.sky, 6 * sizeof(float));
	assert_int_equal(a->mesh_count, b->mesh_count);
	for (uint32_t i = 0; i < a->mesh_count; i++) {
		assert_int_equal(a->meshes[i].vertex_count, b->meshes[i].vertex_count);
		assert_int_equal(a->meshes[i].index_count, b->meshes[i].index_count);
		assert_memory_equal(a->meshes[i].vertices, b->meshes[i].vertices,
		                    a->meshes[i].vertex_count * sizeof *a->meshes[i].vertices);
		assert_memory_equal(a->meshes[i].indices, b->meshes[i].indices,
		                    a->meshes[i].index_count * sizeof *a->meshes[i].indices);
	}
	assert_memory_equal(&a->camera, &b->camera, sizeof a->camera);
}

static void built_in_scenes_are_built_the_same(void **state)
{
	(void)state;
	static const char *const names[] = {"cornell", "outdoor", "spheres", "plane-wall"};
	for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
		stilb_scene *from, *scene;
		assert_int_equal(stilb_scene_open(names[i], &from), STILB_OK);
		stilb_result result = rebuild(from, &scene);
		if (result != STILB_OK)
			fail_msg("%s: %s", names[i], stilb_error_message());
		assert_same(scene, from);
		assert_int_equal(scene->model_count, from->part_count);
		assert_true(scene_is_sound(scene));
		stilb_scene_destroy(from);
		stilb_scene_destroy(scene);
	}
}

/* ---- places ------------------------------------------------------------------------------------------------------ */

/* A mesh of one triangle and a material, both with id 0. */
static stilb_scene_build *begin(void)
{
	stilb_scene_vertex vertices[3] = {
		{{0, 0, 0}, {0, 0, 1}, {0, 0}}, {{1, 0, 0}, {0, 0, 1}, {1, 0}}, {{0, 2, 0}, {0, 0, 1}, {0, 1}}};
	uint32_t indices[3] = {0, 1, 2};
	stilb_scene_build *build = stilb_scene_build_begin();
	assert_int_equal(
		stilb_scene_build_mesh(
			build, &(stilb_scene_mesh){.vertices = vertices, .indices = indices, .vertex_count = 3, .index_count = 3}),
		0);
	assert_int_equal(stilb_scene_build_material(build, &(stilb_scene_material){.roughness = 0.5f}), 0);
	return build;
}

static const stilb_scene_build_part first = {0, 0};

static void nodes_stand_in_their_parents(void **state)
{
	(void)state;
	stilb_scene_build *build = begin();
	stilb_mat4 local = stilb_mat4_scale_translate(2.0f, 10.0f, 0.0f, 0.0f), next = moved(0.0f, 1.0f, 0.0f);
	uint32_t root = stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &local);
	uint32_t child = stilb_scene_build_node(build, root, &next);
	uint32_t grandchild = stilb_scene_build_node(build, child, &next);
	stilb_scene_build_part two[] = {first, first};
	assert_int_equal(stilb_scene_build_model(build, root, two, 2), 0);
	assert_int_equal(stilb_scene_build_model(build, grandchild, &first, 1), 1);
	stilb_scene *scene;
	assert_int_equal(stilb_scene_build_end(build, &scene), STILB_OK);
	assert_int_equal(scene->part_count, 3);
	assert_int_equal(scene->first_part[1], 2);
	assert_int_equal(scene->first_part[2], 3);
	const float *m = scene->part_transform[2].m;
	assert_true(m[0] == 2.0f && m[5] == 2.0f && m[12] == 10.0f && m[13] == 4.0f && m[14] == 0.0f);
	assert_true(scene->part_transform[0].m[13] == 0.0f && scene->part_transform[1].m[12] == 10.0f);
	/* The triangle's corners, in the world, on the sphere about the middle of their box: 10..12, 4..8. */
	assert_true(scene->bounds.x[1] == 11.0f && scene->bounds.y[1] == 6.0f && scene->bounds.z[1] == 0.0f);
	assert_true(fabsf(scene->bounds.radius[1] - sqrtf(5.0f)) < 1e-4f);
	stilb_scene_destroy(scene);
}

/* Models have the flags that they were given last, and lists leave out those that have any of some. */
static void models_have_flags(void **state)
{
	(void)state;
	stilb_scene_build *build = begin();
	stilb_mat4 here = moved(0.0f, 0.0f, 0.0f);
	uint32_t node = stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &here);
	for (uint32_t m = 0; m < 6; m++) {
		assert_int_equal(stilb_scene_build_model(build, node, &first, 1), m);
		stilb_scene_build_model_flags(build, m, 7 - m);
		if (m < 5)
			stilb_scene_build_model_flags(build, m, m);
	}
	stilb_scene *scene;
	assert_int_equal(stilb_scene_build_end(build, &scene), STILB_OK);
	assert_int_equal(scene->flags_used, 7);
	assert_memory_equal(scene->model_flags, ((const uint8_t[]){0, 1, 2, 3, 4, 2}), 6);
	uint32_t ids[6] = {5, 0, 1, 3, 2, 4};
	assert_int_equal(stilb_scene_leave_out(scene, 0, ids, 6), 6);
	assert_int_equal(stilb_scene_leave_out(scene, STILB_SCENE_MODEL_UNSEEN, ids, 6), 4);
	assert_memory_equal(ids, ((const uint32_t[]){5, 0, 2, 4}), 4 * sizeof *ids);
	assert_int_equal(stilb_scene_leave_out(scene, 6, ids, 4), 1);
	assert_int_equal(ids[0], 0);
	assert_int_equal(stilb_scene_leave_out(scene, 7, NULL, 0), 0);
	stilb_scene_destroy(scene);
}

/* Without a camera, one from which all of the scene is in view. */
static void a_camera_sees_it_all(void **state)
{
	(void)state;
	stilb_scene_build *build = begin();
	for (int i = 0; i < 5; i++) {
		stilb_mat4 local = moved(100.0f * (float)i, -30.0f * (float)i, 7.0f);
		stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &local), &first, 1);
	}
	stilb_scene *scene;
	assert_int_equal(stilb_scene_build_end(build, &scene), STILB_OK);
	stilb_mat4 matrix = stilb_scene_camera_matrix(&scene->camera, 1.0f);
	for (uint32_t m = 0; m < scene->model_count; m++) {
		float p[4];
		const float center[4] = {scene->bounds.x[m], scene->bounds.y[m], scene->bounds.z[m], 1.0f};
		for (int r = 0; r < 4; r++) {
			p[r] = 0.0f;
			for (int c = 0; c < 4; c++)
				p[r] += matrix.m[4 * c + r] * center[c];
		}
		assert_true(p[3] > 0.0f && fabsf(p[0]) < p[3] && fabsf(p[1]) < p[3] && p[2] > 0.0f && p[2] < p[3]);
	}
	stilb_scene_destroy(scene);
	assert_int_equal(stilb_scene_build_end(begin(), &scene), STILB_OK); /* a scene without models */
	assert_int_equal(scene->model_count, 0);
	stilb_scene_destroy(scene);
}

/* ---- mistakes ---------------------------------------------------------------------------------------------------- */

/* Ends a build that has a mistake; what was added after it has the id 0 and changes nothing. */
static void assert_refused(stilb_scene_build *build, const char *words)
{
	stilb_scene *scene = (stilb_scene *)build;
	stilb_mat4 local = moved(0, 0, 0);
	assert_int_equal(stilb_scene_build_node(build, 77, &local), 0);
	assert_int_equal(stilb_scene_build_model(build, 99, &first, 1), 0);
	assert_int_equal(stilb_scene_build_end(build, &scene), STILB_ERROR_ARGUMENT);
	assert_null(scene);
	if (!strstr(stilb_error_message(), words))
		fail_msg("'%s' does not say '%s'", stilb_error_message(), words);
}

static void refuses_mesh(float x, float normal, float u, uint32_t index, uint32_t indices, const char *words)
{
	stilb_scene_vertex vertices[3] = {
		{{x, 0, 0}, {0, normal, 0}, {u, 0}}, {{0}, {0, 1, 0}, {0}}, {{0}, {1, 0, 0}, {0}}};
	uint32_t corners[6] = {0, 1, index, 0, 1, 2};
	stilb_scene_build *build = begin();
	assert_int_equal(
		stilb_scene_build_mesh(
			build,
			&(stilb_scene_mesh){.vertices = vertices, .indices = corners, .vertex_count = 3, .index_count = indices}),
		0);
	assert_refused(build, words);
}

static void mistakes_in_meshes(void **state)
{
	(void)state;
	refuses_mesh(NAN, 1, 0, 2, 3, "mesh 1: the position nan, 0, 0 of vertex 0");
	refuses_mesh(2e18f, 1, 0, 2, 3, "is not within 1e18 m");
	refuses_mesh(0, 1.02f, 0, 2, 3, "mesh 1: the normal 0, 1.02, 0 of vertex 0 is not unit");
	refuses_mesh(0, 0, 0, 2, 3, "is not unit");
	refuses_mesh(0, 1, INFINITY, 2, 3, "the uv inf, 0 of vertex 0 are not finite");
	refuses_mesh(0, 1, 0, 3, 3, "mesh 1: index 2 is vertex 3, but it has 3 vertices");
	refuses_mesh(0, 1, 0, 2, 4, "4 indices are no whole triangles");
	refuses_mesh(0, 1, 0, 2, 0, "mesh 1: it has no triangles");
	uint8_t grey[8] = {0};
	stilb_image image = {.width = 2, .height = 2, .channels = 1, .format = STILB_IMAGE_U8_SRGB, .pixels = grey};
	stilb_scene_build *build = begin();
	assert_int_equal(stilb_scene_build_texture(build, &image), 0);
	image.width = 16385;
	stilb_scene_build_texture(build, &image);
	assert_refused(build, "texture 1: 16385x2 pixels");
	build = begin();
	image.width = 2;
	image.format = STILB_IMAGE_FORMAT_COUNT;
	stilb_scene_build_texture(build, &image);
	assert_refused(build, "texture 0: 1 channels in format 14; there are 1..4 and 0..13");
	build = begin();
	image.format = STILB_IMAGE_BC4_LINEAR;
	assert_int_equal(stilb_scene_build_texture(build, &image), 0); /* a block of eight bytes */
	image.format = STILB_IMAGE_BC5_LINEAR;
	stilb_scene_build_texture(build, &image);
	assert_refused(build, "texture 1: 1 channels in blocks that have 2");
	image.format = STILB_IMAGE_U8_SRGB;
	build = begin();
	image.width = 2;
	image.channels = 5;
	stilb_scene_build_texture(build, &image);
	assert_refused(build, "texture 0: 5 channels in format 0");
}

static void refuses_material(stilb_scene_material material, const char *words)
{
	stilb_scene_build *build = begin();
	assert_int_equal(stilb_scene_build_material(build, &material), 0);
	assert_refused(build, words);
}

static void mistakes_in_materials(void **state)
{
	(void)state;
	refuses_material((stilb_scene_material){.diffuse = {0, -0.1f, 0}}, "material 1: diffuse and specular");
	refuses_material((stilb_scene_material){.specular = {0, 0, NAN}}, "are not within 0..1");
	refuses_material((stilb_scene_material){.diffuse = {0, 0.6f, 0}, .specular = {0, 0.5f, 0}},
	                 "diffuse + specular is 1.1");
	refuses_material((stilb_scene_material){.roughness = 1.5f}, "roughness 1.5");
	refuses_material((stilb_scene_material){.wrap = -1}, "wrap -1");
	refuses_material((stilb_scene_material){.anisotropy = 1}, "anisotropy 1");
	refuses_material((stilb_scene_material){.emission = {INFINITY}}, "emission");
	refuses_material((stilb_scene_material){.diffuse_texture = 1}, "there is no texture 0");
}

/* One member of a surface is out of its range. */
#define REFUSES_SURFACE(change, words)                                                                                 \
	do {                                                                                                               \
		stilb_scene_surface s = stilb_scene_surface_make();                                                            \
		change;                                                                                                        \
		stilb_scene_build *build = begin();                                                                            \
		assert_int_equal(stilb_scene_build_surface(build, &s), 0);                                                     \
		assert_refused(build, words);                                                                                  \
	} while (0)

static void mistakes_in_surfaces(void **state)
{
	(void)state;
	REFUSES_SURFACE(s.maps[STILB_SCENE_MAP_NORMAL].texture = 1, "surface 0: there is no texture 0 for its map normal");
	REFUSES_SURFACE(s.maps[3].set = 2, "neither of the two uv");
	REFUSES_SURFACE(s.maps[4].wrap_v = STILB_SCENE_WRAPS, "a map's wrap");
	REFUSES_SURFACE(s.maps[14].to_v[2] = 2e6f, "a map's transform");
	REFUSES_SURFACE(s.workflow = STILB_SCENE_WORKFLOWS, "workflow");
	REFUSES_SURFACE(s.alpha = STILB_SCENE_ALPHAS, "alpha is unknown");
	REFUSES_SURFACE(s.color[3] = 1.5f, "a colour");
	REFUSES_SURFACE(s.sheen_color[1] = -1, "a colour");
	REFUSES_SURFACE((s.workflow = STILB_SCENE_SPECULAR, s.specular[0] = 1.5f), "specular colour");
	REFUSES_SURFACE(s.metalness = NAN, "a factor");
	REFUSES_SURFACE(s.transmission = 2, "a factor");
	REFUSES_SURFACE(s.normal_scale = INFINITY, "a scale");
	REFUSES_SURFACE(s.emission[2] = -1, "emission");
	REFUSES_SURFACE(s.ior = 0.5f, "index of refraction");
	REFUSES_SURFACE(s.cutoff = -1, "cutoff");
	REFUSES_SURFACE(s.thickness = -1, "thickness");
	REFUSES_SURFACE(s.attenuation[0] = 0, "attenuation");
	REFUSES_SURFACE(s.attenuation_distance = 0, "attenuation");
	refuses_material((stilb_scene_material){.surface = 1}, "material 1: there is no surface 0");
	stilb_scene_surface mirror = stilb_scene_surface_make();
	mirror.ior = 0.0f;
	mirror.specular[0] = 7.0f; /* of METALLIC it is a tint */
	assert_null(stilb_scene_surface_mistake(&mirror));
}

/* Extras and surfaces are copied; tangents are unit, or none. */
static void meshes_have_extras(void **state)
{
	(void)state;
	stilb_scene_vertex vertices[3] = {{{0}, {0, 1, 0}, {0}}, {{1, 0, 0}, {0, 1, 0}, {0}}, {{0, 0, 1}, {0, 1, 0}, {0}}};
	stilb_scene_vertex_extra extras[3] = {
		{{1, 0, 0, -1}, {0.5f, 2}, {1, 0, 0, 0.5f}}, {{0}, {0}, {1, 1, 1, 1}}, {{0}, {0}, {0}}};
	uint32_t indices[3] = {0, 1, 2}, texture = 0;
	stilb_scene_mesh mesh = {
		.vertices = vertices, .extras = extras, .indices = indices, .vertex_count = 3, .index_count = 3};
	uint8_t grey[4] = {0};
	stilb_image image = {.width = 2, .height = 2, .channels = 1, .format = STILB_IMAGE_U8_LINEAR, .pixels = grey};
	stilb_scene_surface surface = stilb_scene_surface_make();
	stilb_scene_material paint = {.roughness = 0.5f, .surface = 1};
	stilb_scene_build *build = begin();
	texture = stilb_scene_build_texture(build, &image);
	surface.maps[STILB_SCENE_MAP_OCCLUSION].texture = 1 + texture;
	assert_int_equal(stilb_scene_build_surface(build, &surface), 0);
	uint32_t id = stilb_scene_build_mesh(build, &mesh);
	stilb_scene_build_part part = {id, stilb_scene_build_material(build, &paint)};
	stilb_mat4 here = moved(0, 0, 0);
	stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &here), &part, 1);
	stilb_scene *scene;
	assert_int_equal(stilb_scene_build_end(build, &scene), STILB_OK);
	assert_memory_equal(scene->meshes[id].extras, extras, sizeof extras);
	assert_int_equal(scene->surface_count, 1);
	assert_memory_equal(scene->surfaces, &surface, sizeof surface);
	assert_int_equal(scene->materials[part.material].surface, 1);
	stilb_scene_destroy(scene);
	static const float wrong[][4] = {{1, 0, 0, 0}, {1, 1, 0, 1}, {0, 0, 0, 1}, {NAN, 0, 0, 1}, {1, 0, 0, 2}};
	for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
		memcpy(extras[1].tangent, wrong[i], sizeof wrong[i]);
		build = begin();
		assert_int_equal(stilb_scene_build_mesh(build, &mesh), 0);
		assert_refused(build, "mesh 1: vertex 1 has a tangent that is not unit");
	}
	memset(extras[1].tangent, 0, sizeof extras[1].tangent);
	extras[2].uv[1] = NAN;
	build = begin();
	assert_int_equal(stilb_scene_build_mesh(build, &mesh), 0);
	assert_refused(build, "mesh 1: vertex 2 has");
}

static void mistakes_in_flags(void **state)
{
	(void)state;
	stilb_mat4 here = moved(0.0f, 0.0f, 0.0f);
	for (uint32_t m = 0; m < 2; m++) {
		stilb_scene_build *build = begin();
		stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &here), &first, 1);
		stilb_scene_build_model_flags(build, m, 8);
		assert_refused(build, m ? "there is no model 1" : "model 0: its flags are 8");
	}
}

static void mistakes_in_places(void **state)
{
	(void)state;
	stilb_mat4 local = moved(0, 0, 0), skewed = local, far = moved(9e17f, 0, 0);
	stilb_scene_build *build = begin();
	stilb_scene_build_node(build, 0, &local);
	assert_refused(build, "node 0: there is no node 0 before it");
	skewed.m[7] = 0.1f;
	build = begin();
	stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &skewed);
	assert_refused(build, "node 0: its transform is not affine");
	build = begin();
	stilb_scene_build_node(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &far), &far);
	assert_refused(build, "node 1: its transform is not affine, or not within 1e18");
	build = begin();
	stilb_scene_build_model(build, 0, &first, 1);
	assert_refused(build, "model 0: there is no node 0");
	build = begin();
	stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &local), NULL, 0);
	assert_refused(build, "model 0: it has no parts");
	build = begin();
	stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &local);
	stilb_scene_build_model(build, 0, &(stilb_scene_build_part){1, 0}, 1);
	assert_refused(build, "model 0: there is no mesh 1");
	build = begin();
	stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &local);
	stilb_scene_build_model(build, 0, &(stilb_scene_build_part){0, 1}, 1);
	assert_refused(build, "model 0: there is no material 1");
	build = begin();
	stilb_mat4 large = stilb_mat4_scale_translate(8e17f, 0, 0, 0);
	stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &large);
	stilb_scene_build_model(build, 0, &first, 1);
	assert_refused(build, "model 0: mesh 0 reaches farther than 1e18 m there");
}

static void refuses_light(stilb_scene_light light, const char *words)
{
	stilb_scene_build *build = begin();
	assert_int_equal(stilb_scene_build_light(build, &light), 0);
	assert_refused(build, words);
}

static void refuses_surroundings(stilb_scene_surroundings surroundings, const char *words)
{
	stilb_scene_build *build = begin();
	stilb_scene_build_surroundings(build, &surroundings);
	assert_refused(build, words);
}

static void refuses_camera(stilb_scene_camera camera, const char *words)
{
	stilb_scene_build *build = begin();
	stilb_scene_build_camera(build, &camera);
	assert_refused(build, words);
}

static void mistakes_in_lights_and_cameras(void **state)
{
	(void)state;
	refuses_light((stilb_scene_light){.kind = STILB_SCENE_LIGHT_KINDS}, "light 0: its kind is unknown");
	refuses_light((stilb_scene_light){.unit = STILB_SCENE_LIGHT_UNITS}, "light 0: its unit or its use is unknown");
	refuses_light((stilb_scene_light){.use = STILB_SCENE_LIGHT_USES}, "light 0: its unit or its use is unknown");
	refuses_light((stilb_scene_light){.falloff = STILB_SCENE_LIGHT_FALLOFFS}, "light 0: its falloff is unknown");
	refuses_light((stilb_scene_light){.face = 1}, "light 0: there is no part 0");
	refuses_light((stilb_scene_light){.intensity = {-1}}, "light 0: its intensity is negative");
	refuses_light((stilb_scene_light){.position = {NAN}}, "light 0: its position");
	refuses_light((stilb_scene_light){.kind = STILB_SCENE_LIGHT_DIRECTIONAL}, "light 0: its direction is not unit");
	refuses_light((stilb_scene_light){.kind = STILB_SCENE_LIGHT_SPOT, .direction = {1}, .cos_outer = 0.5f},
	              "light 0: the cosines of its cone");
	refuses_light((stilb_scene_light){.kind = STILB_SCENE_LIGHT_SPHERE}, "light 0: its radius is not between");
	refuses_light((stilb_scene_light){.kind = STILB_SCENE_LIGHT_DISK, .direction = {1}}, "light 0: its radius");
	refuses_light((stilb_scene_light){.kind = STILB_SCENE_LIGHT_RECTANGLE, .direction = {1}, .half_x = {0, 1, 0}},
	              "light 0: a half of its sides is not between");
	refuses_light(
		(stilb_scene_light){
			.kind = STILB_SCENE_LIGHT_RECTANGLE, .direction = {1}, .half_x = {0, 1, 0}, .half_y = {0.1f, 0, 1}},
		"light 0: its sides and its direction are not perpendicular");
	refuses_light((stilb_scene_light){.falloff = STILB_SCENE_LIGHT_WINDOWED}, "light 0: its reach is not above");
	refuses_light(
		(stilb_scene_light){
			.kind = STILB_SCENE_LIGHT_SPHERE, .falloff = STILB_SCENE_LIGHT_SUBTRACTED, .radius = 2.0f, .reach = 2.0f},
		"light 0: its reach is not above");
	refuses_light((stilb_scene_light){.falloff = STILB_SCENE_LIGHT_WINDOWED, .reach = 1.0f, .face = 1},
	              "light 0: it has a face and a falloff that is not physical");
	refuses_surroundings((stilb_scene_surroundings){.sky = {0, -1, 0}}, "surroundings: a radiance is negative");
	refuses_surroundings((stilb_scene_surroundings){.ground = {NAN}}, "surroundings: a radiance is negative");
	refuses_surroundings((stilb_scene_surroundings){.rotation = INFINITY}, "surroundings: the rotation is not finite");
	uint8_t byte[3] = {0};
	refuses_surroundings((stilb_scene_surroundings){.panorama = {1, 1, 3, STILB_IMAGE_U8_SRGB, byte, 0}},
	                     "surroundings: the panorama has not three channels of linear floats");
	refuses_camera((stilb_scene_camera){.position = {INFINITY}}, "camera: its position");
	refuses_camera((stilb_scene_camera){.fov_y = 0.0f}, "camera: the field of view 0");
	refuses_camera((stilb_scene_camera){.fov_y = 1.0f, .near_z = 2.0f, .far_z = 1.0f}, "camera: near 2 and far 1");
	stilb_scene *scene;
	assert_int_equal(stilb_scene_build_end(NULL, &scene), STILB_ERROR_MEMORY);
	assert_null(scene);
}

/* ---- memory ------------------------------------------------------------------------------------------------------ */

static void without_memory_nothing_is_lost(void **state)
{
	(void)state;
	stilb_scene *from, *scene;
	assert_int_equal(stilb_scene_open("spheres", &from), STILB_OK);
	assert_int_equal(from->texture_count, 1);
	int failed = 0;
	for (;; failed++) {
		fail_allocation = failed;
		stilb_result result = rebuild(from, &scene);
		fail_allocation = -1;
		if (result == STILB_OK)
			break;
		assert_int_equal(result, STILB_ERROR_MEMORY);
		assert_null(scene);
	}
	assert_true(failed > 20);
	assert_same(scene, from);
	assert_memory_equal(scene->textures[0].pixels, from->textures[0].pixels, stilb_image_size(from->textures));
	stilb_scene_destroy(scene);
	stilb_scene_destroy(from);
}

/* ---- a mesh that is placed often --------------------------------------------------------------------------------- */

/* A row of spheres along x, too many vertices to walk for each place: bounds and camera come from boxes. */
static void a_mesh_is_placed_often(void **state)
{
	(void)state;
	enum { ROW = 600 };
	stilb_scene_mesh sphere;
	stilb_scene *scene;
	assert_int_equal(stilb_scene_mesh_sphere(6, &sphere), STILB_OK);
	assert_true((uint64_t)ROW * sphere.index_count > SCENE_PLACED_OFTEN);
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_material grey = stilb_scene_material_make((float[3]){0.5f, 0.5f, 0.5f}, (float[3]){0}, 1.0f);
	stilb_scene_build_part part = {stilb_scene_build_mesh(build, &sphere), stilb_scene_build_material(build, &grey)};
	for (int i = 0; i < ROW; i++) {
		stilb_mat4 place = moved(3.0f * (float)i, 1.0f, -2.0f);
		stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &place), &part, 1);
	}
	assert_int_equal(stilb_scene_build_end(build, &scene), STILB_OK);
	for (uint32_t i = 0; i < ROW; i++) {
		assert_true(fabsf(scene->bounds.x[i] - 3.0f * (float)i) < 1e-3f && fabsf(scene->bounds.y[i] - 1.0f) < 1e-3f &&
		            fabsf(scene->bounds.z[i] + 2.0f) < 1e-3f);
		assert_true(scene->bounds.radius[i] >= 1.0f && scene->bounds.radius[i] < 1.7325f);
	}
	/* The row fills nine tenths of the picture's width, but for the corners that stand for the spheres at its ends. */
	stilb_scene_camera camera = stilb_scene_frame(scene, 0.0f, 0.0f, 1.0f);
	float filled = 0.5f * 1799.0f / ((camera.position[2] + 2.0f) * tanf(0.5f * camera.fov_y));
	assert_true(fabsf(camera.position[0] - 898.5f) < 0.5f && fabsf(camera.position[1] - 1.0f) < 0.5f);
	assert_true(filled > 0.89f && filled < 0.901f);
	stilb_scene_destroy(scene);
	stilb_scene_mesh_finish(&sphere);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(built_in_scenes_are_built_the_same),
		cmocka_unit_test(nodes_stand_in_their_parents),
		cmocka_unit_test(models_have_flags),
		cmocka_unit_test(a_camera_sees_it_all),
		cmocka_unit_test(mistakes_in_meshes),
		cmocka_unit_test(mistakes_in_materials),
		cmocka_unit_test(mistakes_in_surfaces),
		cmocka_unit_test(meshes_have_extras),
		cmocka_unit_test(mistakes_in_flags),
		cmocka_unit_test(mistakes_in_places),
		cmocka_unit_test(mistakes_in_lights_and_cameras),
		cmocka_unit_test(a_mesh_is_placed_often),
		cmocka_unit_test(without_memory_nothing_is_lost),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
