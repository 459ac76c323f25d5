/* The built-in scenes against their descriptions, the camera's roll, and environments from pictures. */
#include "scene/scene.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static stilb_scene *open_scene(const char *name)
{
	stilb_scene *scene;
	assert_int_equal(stilb_scene_open(name, &scene), STILB_OK);
	return scene;
}

static stilb_vec3 vector(const float p[3])
{
	return stilb_vec3_make(p[0], p[1], p[2]);
}

static float length(stilb_vec3 v)
{
	return sqrtf(stilb_vec3_dot(v, v));
}

static uint64_t triangle_count(const stilb_scene *scene)
{
	uint64_t count = 0;
	for (uint32_t p = 0; p < scene->part_count; p++)
		count += scene->meshes[scene->part_mesh[p]].index_count / 3;
	return count;
}

/* The vertices of a triangle. */
static void corners(const stilb_scene_mesh *mesh, uint32_t triangle, const stilb_scene_vertex *v[3])
{
	for (uint32_t i = 0; i < 3; i++)
		v[i] = &mesh->vertices[mesh->indices[3 * triangle + i]];
}

static stilb_vec3 face_normal(const stilb_scene_vertex *const v[3])
{
	stilb_vec3 p = vector(v[0]->position);
	return stilb_vec3_normalize(stilb_vec3_cross(vector(v[1]->position) - p, vector(v[2]->position) - p));
}

/* Every edge, as a pair of positions, also occurs in the opposite direction: the surface has no hole. */
static void assert_closed(const stilb_scene_mesh *mesh)
{
	for (uint32_t t = 0; t < mesh->index_count / 3; t++) {
		const stilb_scene_vertex *v[3], *w[3];
		corners(mesh, t, v);
		for (int e = 0; e < 3; e++) {
			const float *from = v[e]->position, *to = v[(e + 1) % 3]->position;
			int ways = 0, backs = 0;
			for (uint32_t o = 0; o < mesh->index_count / 3; o++) {
				corners(mesh, o, w);
				for (int f = 0; f < 3; f++) {
					const float *a = w[f]->position, *b = w[(f + 1) % 3]->position;
					ways += memcmp(a, from, 12) == 0 && memcmp(b, to, 12) == 0;
					backs += memcmp(b, from, 12) == 0 && memcmp(a, to, 12) == 0;
				}
			}
			assert_int_equal(ways, 1);
			assert_int_equal(backs, 1);
		}
	}
}

/* Checks what holds for every scene: indices in range, unit normals, materials that conserve energy, bounds. */
static void assert_sound(const stilb_scene *scene)
{
	assert_int_equal(scene->first_part[0], 0);
	assert_int_equal(scene->first_part[scene->model_count], scene->part_count);
	for (uint32_t p = 0; p < scene->part_count; p++) {
		assert_true(scene->part_mesh[p] < scene->mesh_count);
		assert_true(scene->part_material[p] < scene->material_count);
	}
	for (uint32_t m = 0; m < scene->mesh_count; m++) {
		const stilb_scene_mesh *mesh = &scene->meshes[m];
		assert_int_equal(mesh->index_count % 3, 0);
		for (uint32_t i = 0; i < mesh->index_count; i++)
			assert_true(mesh->indices[i] < mesh->vertex_count);
		for (uint32_t v = 0; v < mesh->vertex_count; v++)
			assert_true(fabsf(length(vector(mesh->vertices[v].normal)) - 1.0f) < 1e-5f);
	}
	for (uint32_t m = 0; m < scene->material_count; m++) {
		const stilb_scene_material *material = &scene->materials[m];
		assert_true(material->diffuse_texture <= scene->texture_count);
		for (int i = 0; i < 3; i++)
			assert_true(material->diffuse[i] >= 0.0f && material->specular[i] >= 0.0f &&
			            material->diffuse[i] + material->specular[i] <= 1.0001f && material->emission[i] >= 0.0f);
	}
	for (uint32_t m = 0; m < scene->model_count; m++)
		for (uint32_t p = scene->first_part[m]; p < scene->first_part[m + 1]; p++) {
			const stilb_scene_mesh *mesh = &scene->meshes[scene->part_mesh[p]];
			const float *t = scene->part_transform[p].m;
			for (uint32_t v = 0; v < mesh->vertex_count; v += 7) {
				const float *q = mesh->vertices[v].position;
				stilb_vec3 away =
					stilb_vec3_make(t[0] * q[0] + t[4] * q[1] + t[8] * q[2] + t[12] - scene->bounds.x[m],
				                    t[1] * q[0] + t[5] * q[1] + t[9] * q[2] + t[13] - scene->bounds.y[m],
				                    t[2] * q[0] + t[6] * q[1] + t[10] * q[2] + t[14] - scene->bounds.z[m]);
				assert_true(length(away) <= scene->bounds.radius[m]);
			}
		}
	assert_true(scene->camera.fov_y > 0.0f && scene->camera.near_z > 0.0f &&
	            scene->camera.far_z > scene->camera.near_z);
}

/* ---- scenes ------------------------------------------------------------------------------------------------------ */

static void all_that_are_named_open(void **state)
{
	(void)state;
	static const char *const names[] = {"cornell", "outdoor", "furnace:0.5", "plane-wall", "stress", "spheres"};
	const char *listed = stilb_scene_builtin_names();
	assert_string_equal(listed, "cornell, outdoor, furnace:RHO, plane-wall, stress, spheres");
	for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
		stilb_scene *scene = open_scene(names[i]);
		if (strcmp(names[i], "stress") != 0) /* test_scene_stress.c checks it */
			assert_sound(scene);
		stilb_scene_destroy(scene);
	}
	stilb_scene_destroy(NULL);
}

static void cornell_is_the_reference_scene(void **state)
{
	(void)state;
	stilb_scene *scene = open_scene("cornell");
	static const float materials[4][4] = {
		{0.73f, 0.73f, 0.73f, 0}, {0.63f, 0.065f, 0.05f, 0}, {0.14f, 0.45f, 0.091f, 0}, {0, 0, 0, 15}};
	uint64_t hash = STILB_FNV1A64_START;
	assert_int_equal(triangle_count(scene), 38);
	assert_int_equal(scene->part_count, 4);
	for (uint32_t p = 0; p < 4; p++) {
		const stilb_scene_mesh *mesh = &scene->meshes[scene->part_mesh[p]];
		const stilb_scene_material *material = &scene->materials[scene->part_material[p]];
		for (uint32_t v = 0; v < mesh->vertex_count; v++)
			hash = stilb_hash_fnv1a64(hash, mesh->vertices[v].position, 12);
		for (int i = 0; i < 3; i++) {
			assert_true(material->diffuse[i] == materials[p][i]);
			assert_true(material->emission[i] == materials[p][3]);
			assert_true(material->specular[i] == 0.0f);
		}
	}
	/* The corners of the file that the reference picture was made from, as floats, white first, the light last. */
	assert_true(hash == 0xc25078418a5527a6u);
	assert_true(scene->meshes[3].vertices[0].normal[1] == -1.0f); /* the light shines down */
	assert_true(fabsf(tanf(0.5f * scene->camera.fov_y) - 0.5f / 1.4f) < 1e-6f);
	assert_true(scene->camera.position[0] == 0.5f && scene->camera.position[1] == 0.5f &&
	            scene->camera.position[2] == 2.4f);
	assert_true(scene->camera.yaw == 0.0f && scene->camera.pitch == 0.0f && scene->camera.roll == 0.0f);
	for (int i = 0; i < 3; i++)
		assert_true(scene->surroundings.sky[i] == 0.0f && scene->surroundings.ground[i] == 0.0f);
	stilb_scene_destroy(scene);
}

/* The lamps of cornell, outdoor and spheres stand in the list, each with the shape and the radiance of its face. */
static void lamps_are_their_faces(void **state)
{
	(void)state;
	static const char *const names[] = {"cornell", "outdoor", "spheres"};
	for (int s = 0; s < 3; s++) {
		stilb_scene *scene;
		assert_int_equal(stilb_scene_open(names[s], &scene), STILB_OK);
		assert_int_equal(scene->light_count, 1);
		const stilb_scene_light *light = scene->lights;
		assert_int_equal(light->kind, STILB_SCENE_LIGHT_RECTANGLE);
		assert_true(light->face > 0 && light->face <= scene->part_count);
		const stilb_scene_mesh *face = &scene->meshes[scene->part_mesh[light->face - 1]];
		const stilb_scene_material *material = &scene->materials[scene->part_material[light->face - 1]];
		assert_int_equal(face->vertex_count, 4);
		for (uint32_t v = 0; v < 4; v++) {
			float along[2] = {0}, sizes[2] = {0}; /* position from the centre, in halves of the sides */
			for (int i = 0; i < 3; i++) {
				float away = face->vertices[v].position[i] - light->position[i];
				along[0] += away * light->half_x[i];
				along[1] += away * light->half_y[i];
				sizes[0] += light->half_x[i] * light->half_x[i];
				sizes[1] += light->half_y[i] * light->half_y[i];
				assert_float_equal(face->vertices[v].normal[i], light->direction[i], 1e-6f);
			}
			assert_float_equal(fabsf(along[0] / sizes[0]), 1.0f, 1e-5f);
			assert_float_equal(fabsf(along[1] / sizes[1]), 1.0f, 1e-5f);
			float area = 4.0f * sqrtf(sizes[0] * sizes[1]);
			for (int i = 0; i < 3; i++)
				assert_float_equal(light->intensity[i], material->emission[i] * area, 1e-5f * light->intensity[i]);
		}
		stilb_scene_destroy(scene);
	}
}

static void furnace_is_closed_and_faces_inward(void **state)
{
	(void)state;
	static const struct {
		const char *name;
		float reflectance;
	} rows[] = {{"furnace:0", 0.0f}, {"furnace:.2", 0.2f}, {"furnace:0.95", 0.95f}, {"furnace:5e-1", 0.5f}};
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
		stilb_scene *scene = open_scene(rows[i].name);
		for (int c = 0; c < 3; c++) {
			assert_true(scene->materials[0].diffuse[c] == rows[i].reflectance);
			assert_true(scene->materials[0].emission[c] == 1.0f);
			assert_true(scene->materials[0].specular[c] == 0.0f);
		}
		const stilb_scene_mesh *mesh = &scene->meshes[0];
		for (uint32_t t = 0; t < mesh->index_count / 3; t++) {
			const stilb_scene_vertex *v[3];
			corners(mesh, t, v);
			stilb_vec3 normal = face_normal(v);
			assert_true(stilb_vec3_dot(normal, vector(v[0]->position)) < -0.9f);
			for (int k = 0; k < 3; k++)
				assert_true(length(vector(v[k]->normal) - normal) < 1e-6f); /* the geometric normal: no light is lost */
		}
		if (i == 0)
			assert_closed(mesh);
		stilb_scene_destroy(scene);
	}
}

static void refused_names_say_why(void **state)
{
	(void)state;
	static const struct {
		const char *name, *says;
	} rows[] = {
		{"furnace:1", "below 1"},       {"furnace:", "try furnace:0.5"},
		{"furnace:-0.1", "at least 0"}, {"furnace:nan", "below 1"},
		{"furnace:0.5x", "below 1"},    {"furnace", "no such file"},
		{"cornell2", "cornell, out"},   {"", "no such file"},
	};
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
		stilb_scene *scene = (stilb_scene *)&scene;
		assert_int_equal(stilb_scene_open(rows[i].name, &scene), STILB_ERROR_ARGUMENT);
		assert_null(scene);
		assert_non_null(strstr(stilb_error_message(), rows[i].says));
	}
}

static void plane_wall_looks_at_the_point(void **state)
{
	(void)state;
	stilb_scene *scene = open_scene("plane-wall");
	stilb_mat4 matrix = stilb_scene_camera_matrix(&scene->camera, 1.5f);
	const float *m = matrix.m; /* times (1, 0, 0, 1): the middle of the picture */
	assert_true(fabsf(m[0] + m[12]) < 1e-5f && fabsf(m[1] + m[13]) < 1e-5f && m[3] + m[15] > 0.0f);
	const stilb_scene_mesh *wall = &scene->meshes[1];
	for (uint32_t v = 0; v < wall->vertex_count; v++) {
		assert_true(wall->vertices[v].position[0] == 0.0f && wall->vertices[v].normal[0] == 1.0f);
		assert_true(wall->vertices[v].position[1] == 0.0f || wall->vertices[v].position[1] == 1.0f);
	}
	for (int i = 0; i < 3; i++)
		assert_true(scene->surroundings.sky[i] == 1.0f && scene->materials[0].diffuse[i] == 0.5f &&
		            scene->materials[1].diffuse[i] == 0.0f);
	stilb_scene_destroy(scene);
}

/* It has the number of triangles that docs name, and normals that fit the bumps. */
static void outdoor_has_bumps_with_their_normals(void **state)
{
	(void)state;
	stilb_scene *scene = open_scene("outdoor");
	assert_int_equal(triangle_count(scene), 173884);
	const stilb_scene_mesh *mesh = &scene->meshes[2];
	double worst = 1.0, mean = 0.0;
	for (uint32_t t = 0; t < mesh->index_count / 3; t++) {
		const stilb_scene_vertex *v[3];
		corners(mesh, t, v);
		stilb_vec3 face = face_normal(v);
		assert_true(stilb_vec3_dot(face, vector(v[0]->position)) > 0.0f); /* outward */
		for (int k = 0; k < 3; k++) {
			double cosine = (double)stilb_vec3_dot(face, vector(v[k]->normal));
			worst = cosine < worst ? cosine : worst;
			mean += cosine / mesh->index_count;
		}
	}
	assert_true(worst > 0.95);
	assert_true(mean > 0.996);
	/* The seam: the first and the last column have the same positions. */
	for (uint32_t row = 0; row <= 70; row++)
		assert_memory_equal(mesh->vertices[row * 141].position, mesh->vertices[row * 141 + 140].position, 12);
	assert_true(scene->meshes[1].vertices[0].normal[1] == -1.0f); /* the sun's face is below */
	assert_true(scene->materials[1].emission[0] == 400.0f);
	stilb_scene_destroy(scene);
}

static void spheres_show_seven_materials(void **state)
{
	(void)state;
	stilb_scene *scene = open_scene("spheres");
	assert_int_equal(scene->part_count, 9);
	for (uint32_t p = 2; p < 9; p++)
		for (uint32_t q = 2; q < p; q++)
			assert_memory_not_equal(&scene->materials[scene->part_material[p]],
			                        &scene->materials[scene->part_material[q]], sizeof *scene->materials);
	assert_int_equal(scene->texture_count, 1);
	assert_int_equal(scene->materials[0].diffuse_texture, 1);
	assert_int_equal(scene->textures[0].channels, 3);
	assert_true(scene->meshes[1].vertices[0].normal[1] < 0.0f); /* the lamp shines down */
	stilb_scene_destroy(scene);
}

/* ---- camera ------------------------------------------------------------------------------------------------------ */

/* Projects a point 1 m ahead, `right` to the right and `up` above the camera without roll; out has y up. */
static void rolled(float roll, float right, float up, float out[2])
{
	stilb_scene_camera camera = {.fov_y = 1.5707963f, .near_z = 0.1f, .far_z = 10.0f, .roll = roll};
	stilb_mat4 matrix = stilb_scene_camera_matrix(&camera, 1.0f);
	float w = matrix.m[3] * right + matrix.m[7] * up - matrix.m[11] + matrix.m[15];
	for (int i = 0; i < 2; i++)
		out[i] = (matrix.m[i] * right + matrix.m[4 + i] * up - matrix.m[8 + i] + matrix.m[12 + i]) / w;
	out[1] = -out[1];
}

static void roll_lowers_the_right_side(void **state)
{
	(void)state;
	float out[2];
	rolled(0.0f, 0.5f, 0.25f, out);
	assert_true(fabsf(out[0] - 0.5f) < 1e-6f && fabsf(out[1] - 0.25f) < 1e-6f);
	rolled(1.5707963f, 0.0f, -0.5f, out); /* a quarter: what was below is to the right */
	assert_true(fabsf(out[0] - 0.5f) < 1e-6f && fabsf(out[1]) < 1e-6f);
	rolled(0.3f, cosf(0.3f), -sinf(0.3f), out); /* the axis to the right, as scene.h gives it */
	assert_true(fabsf(out[0] - 1.0f) < 1e-6f && fabsf(out[1]) < 1e-6f);
}

/* ---- surroundings ------------------------------------------------------------------------------------------------ */

static void environment_is_light(void **state)
{
	(void)state;
	stilb_scene *scene = open_scene("cornell");
	stilb_image picture;
	char exr[] = "/tmp/test_scene_builtin_XXXXXX.exr", png[] = "/tmp/test_scene_builtin_XXXXXX.png";
	close(mkstemps(exr, 4));
	close(mkstemps(png, 4));
	assert_int_equal(stilb_image_create(&picture, 2, 1, 4, STILB_IMAGE_F32_LINEAR), STILB_OK);
	memcpy(picture.pixels, (const float[]){1.5f, NAN, -3.0f, 0.5f, 0.0f, 2.0f, 1e4f, 1.0f}, 32);
	assert_int_equal(stilb_image_save(&picture, exr), STILB_OK);
	assert_int_equal(stilb_scene_set_environment(scene, exr), STILB_OK);
	static const float light[6] = {1.5f, 0, 0, 0, 2.0f, 1e4f};
	assert_int_equal(scene->surroundings.panorama.channels, 3);
	assert_int_equal(scene->surroundings.panorama.format, STILB_IMAGE_F32_LINEAR);
	assert_memory_equal(scene->surroundings.panorama.pixels, light, sizeof light);
	stilb_image_finish(&picture);

	assert_int_equal(stilb_image_create(&picture, 3, 1, 1, STILB_IMAGE_U8_SRGB), STILB_OK);
	memcpy(picture.pixels, (const uint8_t[]){0, 188, 255}, 3);
	assert_int_equal(stilb_image_save(&picture, png), STILB_OK);
	assert_int_equal(stilb_scene_set_environment(scene, png), STILB_OK);
	const float *grey = scene->surroundings.panorama.pixels;
	assert_true(fabsf(scene->surroundings.sky[1] - (0.5029f + 1.0f) / 3.0f) < 1e-3f); /* the mean, for frames */
	assert_true(scene->surroundings.ground[2] == scene->surroundings.sky[1]);         /* its only row is both halves */
	assert_true(grey[0] == 0.0f && fabsf(grey[4] - 0.5029f) < 1e-3f && grey[3] == grey[5] && grey[8] == 1.0f);
	stilb_image_finish(&picture);

	assert_int_equal(stilb_scene_set_environment(scene, "/nonexistent/sky.hdr"), STILB_ERROR_FILE);
	assert_non_null(strstr(stilb_error_message(), "/nonexistent/sky.hdr"));
	assert_int_equal(scene->surroundings.panorama.width, 3); /* as before */
	stilb_scene_set_sky(scene, (const float[3]){1, 2, 3});
	assert_null(scene->surroundings.panorama.pixels);
	assert_true(scene->surroundings.sky[2] == 3.0f && scene->surroundings.ground[0] == 1.0f);
	unlink(exr);
	unlink(png);
	stilb_scene_destroy(scene);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(all_that_are_named_open),
		cmocka_unit_test(cornell_is_the_reference_scene),
		cmocka_unit_test(lamps_are_their_faces),
		cmocka_unit_test(furnace_is_closed_and_faces_inward),
		cmocka_unit_test(refused_names_say_why),
		cmocka_unit_test(plane_wall_looks_at_the_point),
		cmocka_unit_test(outdoor_has_bumps_with_their_normals),
		cmocka_unit_test(spheres_show_seven_materials),
		cmocka_unit_test(roll_lowers_the_right_side),
		cmocka_unit_test(environment_is_light),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
