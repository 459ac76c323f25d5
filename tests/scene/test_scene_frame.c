/* Cameras that frame a scene: closed cases, and the promise on projected vertices for every direction and shape; the
 * exposure that is metered, against closed forms. */
#include "scene/edit/scene_edit.h"
#include "scene/scene_build.h"
#include "scene/scene_internal.h"
#include "scene/scene_look.h"
#include "support/test.h"

#include <math.h>
#include <string.h>

#define HALF 0.3650285f /* tan(0.7 / 2): of the picture's height at the distance 1 */

/* A scene of one mesh with these corners, each a triangle of its own. */
static stilb_scene *scene_of(const float (*corners)[3], uint32_t count)
{
	stilb_scene_vertex vertices[16] = {0};
	uint32_t indices[48];
	assert_true(count <= 16);
	for (uint32_t i = 0; i < count; i++) {
		memcpy(vertices[i].position, corners[i], sizeof vertices[i].position);
		vertices[i].normal[2] = 1.0f;
		indices[3 * i] = indices[3 * i + 1] = indices[3 * i + 2] = i;
	}
	stilb_scene_mesh mesh = {.vertices = vertices, .indices = indices, .vertex_count = count, .index_count = 3 * count};
	static const float grey[3] = {0.5f, 0.5f, 0.5f}, none[3] = {0};
	stilb_scene_material material = stilb_scene_material_make(grey, none, 1.0f);
	stilb_mat4 here = stilb_mat4_identity();
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_build_part part = {stilb_scene_build_mesh(build, &mesh), stilb_scene_build_material(build, &material)};
	stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &here), &part, 1);
	stilb_scene *scene;
	assert_int_equal(stilb_scene_build_end(build, &scene), STILB_OK);
	assert_true(scene->framed);
	return scene;
}

/* The box that the scene's vertices fill in the picture: left, right, bottom, top, each in [-1, 1]. */
static void projected(const stilb_scene *scene, const stilb_scene_camera *camera, float aspect, float box[4])
{
	stilb_mat4 matrix = stilb_scene_camera_matrix(camera, aspect);
	box[0] = box[2] = 1e9f;
	box[1] = box[3] = -1e9f;
	for (uint32_t i = 0; i < scene->meshes[0].vertex_count; i++) {
		const float *p = scene->meshes[0].vertices[i].position, *m = matrix.m;
		float w = m[3] * p[0] + m[7] * p[1] + m[11] * p[2] + m[15];
		float x = (m[0] * p[0] + m[4] * p[1] + m[8] * p[2] + m[12]) / w;
		float y = -(m[1] * p[0] + m[5] * p[1] + m[9] * p[2] + m[13]) / w;
		assert_true(w > camera->near_z && w < camera->far_z);
		box[0] = fminf(box[0], x), box[1] = fmaxf(box[1], x), box[2] = fminf(box[2], y), box[3] = fmaxf(box[3], y);
	}
}

/* A square of side 2 at z = 0 seen along -Z fills .9 of the height: its half, 1, is .9 tan(.35) of the distance. */
static void square_from_the_front(void **state)
{
	(void)state;
	static const float corners[4][3] = {{4, 6, 0}, {6, 6, 0}, {6, 8, 0}, {4, 8, 0}};
	stilb_scene *scene = scene_of(corners, 4);
	stilb_scene_camera camera = stilb_scene_frame(scene, 0.0f, 0.0f, 1.0f);
	float distance = 1.0f / (0.9f * HALF);
	assert_true(fabsf(camera.position[0] - 5.0f) < 1e-4f && fabsf(camera.position[1] - 7.0f) < 1e-4f);
	assert_true(fabsf(camera.position[2] - distance) < 1e-4f);
	assert_true(fabsf(stilb_scene_camera_distance(scene, &camera) - distance) < 1e-4f);
	camera = stilb_scene_frame(scene, 0.0f, 0.0f, 4.0f); /* the height still decides */
	assert_true(fabsf(camera.position[2] - distance) < 1e-4f);
	camera = stilb_scene_frame(scene, 0.0f, 0.0f, 0.5f); /* the width does */
	assert_true(fabsf(camera.position[2] - 2.0f * distance) < 1e-4f);
	stilb_scene_destroy(scene);
}

/* A box of depth 2 and side 2 along -Z: its front face decides, 1 m before its middle. */
static void near_faces_decide(void **state)
{
	(void)state;
	static const float corners[8][3] = {{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {1, 1, -1},
	                                    {-1, -1, 1},  {1, -1, 1},  {-1, 1, 1},  {1, 1, 1}};
	stilb_scene *scene = scene_of(corners, 8);
	stilb_scene_camera camera = stilb_scene_frame(scene, 0.0f, 0.0f, 1.0f);
	assert_true(fabsf(camera.position[2] - (1.0f + 1.0f / (0.9f * HALF))) < 1e-4f);
	stilb_scene_destroy(scene);
}

static void fills_from_every_direction(void **state)
{
	(void)state;
	/* Far from symmetric: something near on one side, something far on the other. */
	static const float corners[6][3] = {{-3, 0, 2}, {1, 0.2f, -9}, {1.5f, 4, 0}, {0, -1, 1}, {0.3f, 2, 5}, {-1, 1, -2}};
	static const float aspects[] = {0.4f, 1.0f, 1.7778f, 5.0f};
	stilb_scene *scene = scene_of(corners, 6);
	for (int yaw = -3; yaw <= 3; yaw++)
		for (int pitch = -3; pitch <= 3; pitch++)
			for (int a = 0; a < 4; a++) {
				float box[4];
				stilb_scene_camera camera = stilb_scene_frame(scene, (float)yaw, 0.5f * (float)pitch, aspects[a]);
				projected(scene, &camera, aspects[a], box);
				assert_true(camera.yaw == (float)yaw && camera.pitch == 0.5f * (float)pitch);
				float filled = fmaxf(box[1] - box[0], box[3] - box[2]) / 2.0f;
				assert_true(filled > 0.8f && filled < 0.901f);
				assert_true(fabsf(box[0] + box[1]) < 2e-3f && fabsf(box[2] + box[3]) < 2e-3f);
			}
	stilb_scene_destroy(scene);
}

/* A point, a line along the view, no vertices at all and hidden models give a camera that works. */
static void nothing_to_fill(void **state)
{
	(void)state;
	static const float point[1][3] = {{2, 3, 4}}, line[2][3] = {{0, 0, 0}, {0, 0, -8}};
	stilb_scene *scene = scene_of(point, 1);
	stilb_scene_camera camera = stilb_scene_frame(scene, 0.0f, 0.0f, 1.0f);
	assert_true(fabsf(camera.position[0] - 2.0f) < 1e-5f && fabsf(camera.position[1] - 3.0f) < 1e-5f);
	assert_true(camera.position[2] == 5.0f);
	assert_true(fabsf(stilb_scene_camera_distance(scene, &camera) - 1.0f) < 1e-5f);
	scene->bounds.radius[0] = NAN; /* hidden */
	camera = stilb_scene_frame(scene, 0.0f, 0.0f, 1.0f);
	assert_true(camera.position[0] == 0.0f && camera.position[2] == 1.0f);
	stilb_scene_destroy(scene);
	scene = scene_of(line, 2);
	camera = stilb_scene_frame(scene, 0.0f, 0.0f, 1.0f);
	assert_true(camera.position[2] > 0.3f && camera.position[2] < 0.5f && camera.near_z < 0.3f);
	stilb_scene_destroy(scene);
}

/* ---- exposure ---------------------------------------------------------------------------------------------------- */

/* A square of side 2 at z = 0 that faces +Z and emits, seen from the front, with this light and these surroundings. */
static stilb_scene *lit_square(const stilb_scene_light *light, const stilb_scene_surroundings *around, float emission)
{
	static const float grey[3] = {0.5f, 0.5f, 0.5f}, none[3] = {0};
	stilb_scene_vertex vertices[4] = {{{-1, -1, 0}, {0, 0, 1}, {0}},
	                                  {{1, -1, 0}, {0, 0, 1}, {0}},
	                                  {{1, 1, 0}, {0, 0, 1}, {0}},
	                                  {{-1, 1, 0}, {0, 0, 1}, {0}}};
	uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
	stilb_scene_mesh mesh = {.vertices = vertices, .indices = indices, .vertex_count = 4, .index_count = 6};
	stilb_scene_material material = stilb_scene_material_make(grey, none, 1.0f);
	for (int i = 0; i < 3; i++)
		material.emission[i] = emission;
	stilb_mat4 here = stilb_mat4_identity();
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_build_part part = {stilb_scene_build_mesh(build, &mesh), stilb_scene_build_material(build, &material)};
	stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &here), &part, 1);
	if (light)
		stilb_scene_build_light(build, light);
	if (around)
		stilb_scene_build_surroundings(build, around);
	stilb_scene *scene;
	assert_int_equal(stilb_scene_build_end(build, &scene), STILB_OK);
	scene->camera = stilb_scene_frame(scene, 0.0f, 0.0f, 1.0f);
	return scene;
}

static float metered(stilb_scene *scene)
{
	float exposure = NAN;
	assert_int_equal(stilb_scene_meter(scene, &scene->camera, &exposure), STILB_OK);
	return exposure;
}

static float metered_once(const stilb_scene_light *light, const stilb_scene_surroundings *around, float emission)
{
	stilb_scene *scene = lit_square(light, around, emission);
	float exposure = metered(scene);
	stilb_scene_destroy(scene);
	return exposure;
}

static void assert_stops(float exposure, double wanted)
{
	if (!(fabs((double)exposure - wanted) < 0.0051))
		print_error("%.4f stops where %.4f are right\n", (double)exposure, wanted);
	assert_true(fabs((double)exposure - wanted) < 0.0051);
}

/* log2(pi / E), E by the closed form of each light. */
static void meters_the_light(void **state)
{
	(void)state;
	stilb_scene_light sun = {
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {0.6f, 0, -0.8f}, .intensity = {100, 100, 100}};
	assert_stops(metered_once(&sun, NULL, 0), log2(M_PI / 80.0));
	sun.intensity[0] = sun.intensity[2] = 0; /* green has .7152 of the luminance */
	assert_stops(metered_once(&sun, NULL, 0), log2(M_PI / (80.0 * 0.7152)));
	stilb_scene_light lamp = {.position = {0, 0, 100}, .intensity = {5e5f, 5e5f, 5e5f}}; /* far enough to be even */
	assert_stops(metered_once(&lamp, NULL, 0), log2(M_PI / 50.0));
	lamp.position[2] = -100; /* from behind: nothing is lit, and the lamp's own brightness is not seen */
	assert_true(metered_once(&lamp, NULL, 0) == 0.0f);
	stilb_scene_surroundings around = {.sky = {3, 3, 3}, .ground = {1, 1, 1}};
	assert_stops(metered_once(NULL, &around, 0), -1.0); /* half of each: pi 2 */
	assert_stops(metered_once(NULL, NULL, 16), -4.0);   /* what shines where there is no light */
	assert_stops(metered_once(NULL, &around, 16), -1.0);
	assert_true(metered_once(NULL, NULL, 0) == 0.0f);
}

/* The brightest tenth decides, wherever the camera is rolled or the model cut. */
static void meters_what_is_seen(void **state)
{
	(void)state;
	/* A lamp at the height 1 before the square of area 4: I / (1 + r^2)^(3/2) where pi r^2 is a tenth of the area. */
	stilb_scene_light near = {.position = {0, 0, 1}, .intensity = {20, 20, 20}};
	double brightest = (double)metered_once(&near, NULL, 0), right = log2(M_PI / (20.0 * pow(1.0 + 0.4 / M_PI, -1.5)));
	if (!(fabs(brightest - right) < 0.02))
		print_error("%g stops where %g are right\n", brightest, right);
	assert_true(fabs(brightest - right) < 0.02);
	stilb_scene_light sun = {.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {0, 0, -1}, .intensity = {10, 10, 10}};
	stilb_scene *scene = lit_square(&sun, NULL, 0);
	float plain = metered(scene);
	scene->camera.roll = 1.0f;
	assert_true(metered(scene) == plain);
	scene->camera.position[2] = 0.5f; /* inside of the square's outline */
	scene->camera.pitch = 1.2f;       /* one corner of it is behind the camera */
	assert_true(metered(scene) == plain);
	sun.direction[2] = 1; /* from behind, where the square is seen from, too */
	scene->lights[0] = sun;
	scene->camera =
		(stilb_scene_camera){.position = {0, 0, -3}, .yaw = 3.14159265f, .fov_y = 0.7f, .near_z = 0.1f, .far_z = 10.0f};
	assert_true(metered(scene) == plain);
	scene->model_flags[0] = STILB_SCENE_MODEL_UNSEEN;
	assert_true(metered(scene) == 0.0f);
	scene->model_flags[0] = 0;
	scene->camera.position[2] = 3.0f; /* it looks away */
	scene->camera.pitch = 0.0f;
	assert_true(metered(scene) == 0.0f);
	scene->camera = stilb_scene_frame(scene, 0.0f, 0.0f, 1.0f);
	scene->bounds.radius[0] = NAN; /* hidden */
	assert_true(metered(scene) == 0.0f);
	stilb_scene_destroy(scene);
	/* What is lit is seen through triangles that reach behind the camera. */
	stilb_scene_light small = {.kind = STILB_SCENE_LIGHT_SPOT,
	                           .position = {0, 0.789f, 10},
	                           .direction = {0, 0, -1},
	                           .cos_inner = cosf(0.008f),
	                           .cos_outer = cosf(0.008f),
	                           .intensity = {1e3f, 1e3f, 1e3f}};
	scene = lit_square(&small, NULL, 0);
	scene->camera = (stilb_scene_camera){
		.position = {0, 0.2f, 0.3f}, .pitch = 1.1f, .fov_y = 0.7f, .near_z = 0.01f, .far_z = 10.0f};
	assert_stops(metered(scene), log2(M_PI / 10.0));
	stilb_scene_destroy(scene);
	/* A spot lights a small part of the square, evenly: the rest, which is dark, does not count. */
	stilb_scene_light spot = {.kind = STILB_SCENE_LIGHT_SPOT,
	                          .position = {0, 0, 100},
	                          .direction = {0, 0, -1},
	                          .cos_inner = cosf(0.003f),
	                          .cos_outer = cosf(0.003f),
	                          .intensity = {1e5f, 1e5f, 1e5f}};
	assert_stops(metered_once(&spot, NULL, 0), log2(M_PI / 10.0));
}

/* Models that are gone, or unseen, are not framed. */
static void frames_what_is_left(void **state)
{
	(void)state;
	static const float corners[4][3] = {{4, 6, 0}, {6, 6, 0}, {6, 8, 0}, {4, 8, 0}};
	stilb_scene *scene = scene_of(corners, 4);
	stilb_scene_camera before = stilb_scene_frame(scene, 0.4f, -0.3f, 1.5f), after;
	stilb_scene_build_part part = {0, 0};
	stilb_mat4 far = stilb_mat4_scale_translate(1.0f, 100.0f, 0.0f, 0.0f);
	uint32_t model;
	assert_int_equal(stilb_scene_add_model(scene, &far, &part, 1, &model), STILB_OK);
	after = stilb_scene_frame(scene, 0.4f, -0.3f, 1.5f);
	assert_true(fabsf(after.position[2] - before.position[2]) > 10.0f);
	assert_int_equal(stilb_scene_set_model_flags(scene, model, STILB_SCENE_MODEL_UNSEEN), STILB_OK);
	after = stilb_scene_frame(scene, 0.4f, -0.3f, 1.5f);
	assert_memory_equal(after.position, before.position, sizeof after.position);
	assert_int_equal(stilb_scene_remove_model(scene, model), STILB_OK);
	after = stilb_scene_frame(scene, 0.4f, -0.3f, 1.5f);
	assert_memory_equal(after.position, before.position, sizeof after.position);
	stilb_scene_destroy(scene);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(square_from_the_front),      cmocka_unit_test(near_faces_decide),
		cmocka_unit_test(fills_from_every_direction), cmocka_unit_test(nothing_to_fill),
		cmocka_unit_test(meters_the_light),           cmocka_unit_test(meters_what_is_seen),
		cmocka_unit_test(frames_what_is_left),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
