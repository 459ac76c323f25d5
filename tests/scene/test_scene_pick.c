/* scene_pick: rays whose hits are known in closed form, what they must not meet, and which of several they meet. */
#include "scene/scene_build.h"
#include "scene/scene_pick.h"
#include "support/test.h"

#include <float.h>
#include <math.h>

/* Adds a square of side 2, at z in its middle, that faces +Z if `front` is 1 and -Z if it is -1. */
static void add_square(stilb_scene_build *build, float x, float z, float front)
{
	stilb_scene_vertex vertices[4];
	uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
	static const float corners[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
	for (int i = 0; i < 4; i++)
		vertices[i] =
			(stilb_scene_vertex){.position = {front * corners[i][0], corners[i][1], 0}, .normal = {0, 0, front}};
	stilb_scene_mesh mesh = {vertices, indices, 4, 6};
	stilb_mat4 place = stilb_mat4_scale_translate(1.0f, x, 0.0f, z);
	stilb_scene_build_part part = {.mesh = stilb_scene_build_mesh(build, &mesh)};
	stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &place), &part, 1);
}

static stilb_scene *finish_scene(stilb_scene_build *build)
{
	stilb_scene *scene;
	stilb_scene_camera camera = {.position = {0, 0, 10}, .fov_y = 1.0f, .near_z = 0.5f, .far_z = 100.0f};
	stilb_scene_build_camera(build, &camera);
	if (stilb_scene_build_end(build, &scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return scene;
}

static stilb_scene_build *begin_scene(void)
{
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_build_material(build, &(stilb_scene_material){.diffuse = {0.5f, 0.5f, 0.5f}});
	return build;
}

static stilb_scene_ray straight(double x, double y)
{
	return (stilb_scene_ray){{x, y, 10.0}, {0.0, 0.0, -2.0}, 0.0, HUGE_VAL};
}

static void test_the_nearest_front_is_met(void **state)
{
	(void)state;
	stilb_scene_build *build = begin_scene();
	add_square(build, 0.0f, 3.0f, -1.0f); /* model 0 is nearest, but turned away */
	add_square(build, 0.0f, -4.0f, 1.0f);
	add_square(build, 0.5f, 2.0f, 1.0f);
	stilb_scene *scene = finish_scene(build);
	stilb_scene_hit hit;
	stilb_scene_ray ray = straight(0.25, -0.5);
	assert_true(stilb_scene_pick(scene, &ray, &hit));
	assert_int_equal(hit.model, 2);
	assert_int_equal(hit.part, 2);
	assert_int_equal(hit.triangle, 0); /* below its diagonal */
	assert_float_equal(hit.distance, 8.0, 1e-12);
	assert_float_equal(hit.position[0], 0.25f, 0.0f);
	assert_float_equal(hit.position[1], -0.5f, 0.0f);
	assert_float_equal(hit.position[2], 2.0f, 0.0f);
	ray = straight(-0.75, 0.5); /* beside model 2 */
	assert_true(stilb_scene_pick(scene, &ray, &hit));
	assert_int_equal(hit.model, 1);
	assert_int_equal(hit.triangle, 1);
	assert_float_equal(hit.distance, 14.0, 1e-12);
	/* (1 - u - v) a + u b + v c of corners 0, 2, 3 of the square */
	assert_float_equal(-(1.0f - hit.u - hit.v) + hit.u - hit.v, -0.75f, 1e-6f);
	assert_float_equal(-(1.0f - hit.u - hit.v) + hit.u + hit.v, 0.5f, 1e-6f);
	scene->bounds.radius[1] = (double)NAN; /* hidden */
	assert_false(stilb_scene_pick(scene, &ray, &hit));
	ray = straight(1.75, 0.0);
	assert_false(stilb_scene_pick(scene, &ray, &hit));
	assert_int_equal(hit.model, 1);                                             /* as before */
	ray = (stilb_scene_ray){{0.0, 0.0, -10.0}, {0.0, 0.0, 1.0}, 0.0, HUGE_VAL}; /* from behind: only model 0 faces it */
	assert_true(stilb_scene_pick(scene, &ray, &hit));
	assert_int_equal(hit.model, 0);
	stilb_scene_destroy(scene);
}

static void test_segments_and_ties(void **state)
{
	(void)state;
	stilb_scene_build *build = begin_scene();
	add_square(build, 0.0f, 1.0f, 1.0f);
	add_square(build, 0.0f, 1.0f, 1.0f); /* in the same place */
	add_square(build, 0.0f, 0.0f, 1.0f);
	stilb_scene *scene = finish_scene(build);
	stilb_scene_hit hit;
	stilb_scene_ray ray = straight(0.0, 0.0); /* on the diagonal of all squares; 9 m and 10 m are t 4.5 and 5 */
	assert_true(stilb_scene_pick(scene, &ray, &hit));
	assert_int_equal(hit.model, 0);
	assert_int_equal(hit.triangle, 0);
	ray.near_t = 4.5;
	assert_true(stilb_scene_pick(scene, &ray, &hit));
	assert_int_equal(hit.model, 2);
	ray.far_t = 5.0;
	assert_true(stilb_scene_pick(scene, &ray, &hit));
	ray.far_t = nextafter(5.0, 0.0);
	assert_false(stilb_scene_pick(scene, &ray, &hit));
	ray = straight(0.0, 0.0);
	ray.direction[2] = (double)NAN;
	assert_false(stilb_scene_pick(scene, &ray, &hit));
	ray = straight((double)NAN, 0.0);
	assert_false(stilb_scene_pick(scene, &ray, &hit));
	ray = straight(HUGE_VAL, 0.0);
	assert_false(stilb_scene_pick(scene, &ray, &hit));
	stilb_scene_destroy(scene);
}

/* The ray through a pixel meets the point that the camera's matrix takes to that pixel. */
static void test_the_cameras_rays(void **state)
{
	(void)state;
	stilb_scene_build *build = begin_scene();
	add_square(build, 0.0f, 0.0f, 1.0f);
	stilb_scene *scene = finish_scene(build);
	scene->camera = (stilb_scene_camera){
		{0.5f, 0.25f, 4.0f}, 0.1f, -0.05f, 0.3f, 0.8f, 0.5f, 100.0f, 0.0f}; /* every angle is used */
	stilb_mat4 clip = stilb_scene_camera_matrix(&scene->camera, 640.0f / 360.0f);
	const float *m = clip.m;
	uint32_t hits = 0;
	for (uint32_t y = 0; y < 360; y += 24)
		for (uint32_t x = 0; x < 640; x += 32) {
			stilb_scene_ray ray = stilb_scene_camera_ray(&scene->camera, 640, 360, x + 0.5, y + 0.5);
			stilb_scene_hit hit;
			if (!stilb_scene_pick(scene, &ray, &hit))
				continue;
			const float *p = hit.position;
			float w = m[3] * p[0] + m[7] * p[1] + m[11] * p[2] + m[15];
			float cx = (m[0] * p[0] + m[4] * p[1] + m[8] * p[2] + m[12]) / w;
			float cy = (m[1] * p[0] + m[5] * p[1] + m[9] * p[2] + m[13]) / w;
			assert_float_equal((cx + 1.0f) * 320.0f, (float)x + 0.5f, 1e-3f);
			assert_float_equal((cy + 1.0f) * 180.0f, (float)y + 0.5f, 1e-3f);
			assert_float_equal(p[2], 0.0f, 1e-6f);
			hits++;
		}
	assert_in_range(hits, 40, 200);
	stilb_scene_ray ray = stilb_scene_camera_ray(&scene->camera, 640, 360, 320.0, 180.0);
	assert_true(ray.near_t == 0.5 && ray.far_t == 100.0);
	stilb_scene_destroy(scene);
}

/* A model whose vertices lie on its bounding sphere, far from the origin, where bounds are rounded: rays at its rim
 * meet it although the sphere in float may be too small. */
static void test_bounds_hide_nothing(void **state)
{
	(void)state;
	stilb_scene_build *build = begin_scene();
	add_square(build, 30000.0f, 0.0f, 1.0f);
	stilb_scene *scene = finish_scene(build);
	stilb_scene_hit hit;
	scene->bounds.radius[0] = 1.41421354f; /* the float below the square root of two */
	for (int i = 0; i < 4; i++) {
		stilb_scene_ray ray = straight(30000.0 + (i & 1 ? 1.0 : -1.0), i & 2 ? 1.0 : -1.0);
		assert_true(stilb_scene_pick(scene, &ray, &hit));
	}
	scene->bounds.radius[0] = 0.5f; /* the bounds do decide: a corner lies outside these */
	stilb_scene_ray ray = straight(30001.0, 1.0);
	assert_false(stilb_scene_pick(scene, &ray, &hit));
	stilb_scene_destroy(scene);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_the_nearest_front_is_met),
		cmocka_unit_test(test_segments_and_ties),
		cmocka_unit_test(test_the_cameras_rays),
		cmocka_unit_test(test_bounds_hide_nothing),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
