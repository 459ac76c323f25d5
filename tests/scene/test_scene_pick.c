/* scene_pick: rays whose hits are known in closed form, what they must not meet, and which of several they meet. */
#include "scene/edit/scene_edit.h"
#include "scene/scene_build.h"
#include "scene/scene_pick.h"
#include "support/test.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Adds a square of side 2, at z in its middle, that faces +Z if `front` is 1 and -Z if it is -1. */
static void add_square(stilb_scene_build *build, float x, float z, float front)
{
	stilb_scene_vertex vertices[4];
	uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
	static const float corners[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
	for (int i = 0; i < 4; i++)
		vertices[i] =
			(stilb_scene_vertex){.position = {front * corners[i][0], corners[i][1], 0}, .normal = {0, 0, front}};
	stilb_scene_mesh mesh = {.vertices = vertices, .indices = indices, .vertex_count = 4, .index_count = 6};
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
	scene->both_sides = true;
	assert_true(stilb_scene_pick(scene, &ray, &hit)); /* model 1, whose front is on the other side, is hidden */
	assert_int_equal(hit.model, 2);
	assert_float_equal(hit.distance, 12.0, 1e-12);
	assert_float_equal(hit.position[2], 2.0f, 0.0f);
	assert_int_equal(stilb_scene_set_model_flags(scene, 2, STILB_SCENE_MODEL_UNSEEN), STILB_OK);
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
		{0.5f, 0.25f, 4.0f}, 0.1f, -0.05f, 0.3f, 0.8f, 0.5f, 100.0f, 0.0f, 0}; /* every angle is used */
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

/* ---- with an index ----------------------------------------------------------------------------------------------- */

#define SIDE                                                                                                           \
	90u /* squares of the hilly field, across: 16,200 triangles, a hundred more than boxes of two levels hold */

static float hill(uint32_t seed, uint32_t x, uint32_t y)
{
	return stilb_random_float(seed, y * (SIDE + 1) + x);
}

/* A field of random hills, its triangles in rows, or in random order; a few are slivers, flat or not finite. */
static stilb_scene *field_scene(bool shuffled)
{
	uint32_t count = (SIDE + 1) * (SIDE + 1), triangles = 2 * SIDE * SIDE;
	stilb_scene_vertex *vertices = calloc(count, sizeof *vertices);
	uint32_t *indices = malloc(3 * triangles * sizeof *indices);
	for (uint32_t v = 0; v < count; v++)
		vertices[v] = (stilb_scene_vertex){
			.position = {(float)(v % (SIDE + 1)), (float)(v / (SIDE + 1)), hill(1, v % (SIDE + 1), v / (SIDE + 1))},
			.normal = {0, 0, 1}};
	for (uint32_t t = 0; t < triangles; t++) {
		uint32_t at = shuffled ? (uint32_t)(((uint64_t)t * 7919) % triangles) : t;
		uint32_t x = t / 2 % SIDE, y = t / 2 / SIDE, a = y * (SIDE + 1) + x;
		uint32_t corners[3] = {a, t % 2 ? a + SIDE + 2 : a + 1, t % 2 ? a + SIDE + 1 : a + SIDE + 2};
		memcpy(&indices[3 * at], corners, sizeof corners);
		if (t % 997 == 0)
			indices[3 * at + 2] = indices[3 * at]; /* no area */
	}
	vertices[count / 2].position[2] = 1e-7f;
	stilb_scene_mesh mesh = {
		.vertices = vertices, .indices = indices, .vertex_count = count, .index_count = 3 * triangles};
	stilb_scene_build *build = begin_scene();
	add_square(build, 3.0f, 0.4f, 1.0f);
	stilb_scene_build_part part = {.mesh = stilb_scene_build_mesh(build, &mesh)};
	for (int i = 0; i < 3; i++) { /* beside and above one another, turned, stretched, far away */
		stilb_mat4 place = stilb_mat4_scale_translate(i == 2 ? 300.0f : 1.0f, i == 2 ? 2e4f : 0.3f * (float)i,
		                                              0.2f * (float)i, -0.5f * (float)i);
		place.m[1] = 0.3f * (float)i;
		place.m[6] = -0.2f * (float)i;
		stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &place), &part, 1);
	}
	stilb_scene *scene = finish_scene(build);
	free(vertices);
	free(indices);
	return scene;
}

static uint32_t field_random; /* number of the next */

static double field_between(double low, double high)
{
	return low + (high - low) * (double)stilb_random_float(77, field_random++);
}

/* A ray at the field, at random: from above, along it, from far away, exactly along an axis. */
static stilb_scene_ray field_ray(uint32_t i)
{
	double far = i % 5 == 0 ? 1e5 : 30.0;
	stilb_scene_ray ray = {.near_t = 0.0, .far_t = i % 7 == 0 ? 31.0 : HUGE_VAL};
	double at[3] = {field_between(-2, 94), field_between(-2, 94), field_between(-1, 2)};
	if (i % 11 == 0)
		at[0] = 2e4 + 300.0 * at[0];
	for (int c = 0; c < 3; c++) {
		ray.origin[c] = at[c] + (c == 2 ? far : i % 3 == 0 ? 0.0 : field_between(-20, 20));
		ray.direction[c] = at[c] - ray.origin[c];
	}
	return ray;
}

static bool same_hit(const stilb_scene_hit *a, const stilb_scene_hit *b)
{
	return a->model == b->model && a->part == b->part && a->triangle == b->triangle && a->distance == b->distance &&
	       a->u == b->u && a->v == b->v && memcmp(a->position, b->position, sizeof a->position) == 0;
}

/* A ray straight down, a hair inside of a corner at the edge of the field as floats round it. */
static stilb_scene_ray edge_ray(const stilb_scene *scene, uint32_t i)
{
	uint32_t along = i * 13 % (SIDE + 1), far_edge = i % 2 ? along * (SIDE + 1) + SIDE : SIDE * (SIDE + 1) + along;
	const float *p = scene->meshes[1].vertices[far_edge].position;
	const float *m = scene->part_transform[1 + i % 3].m;
	stilb_scene_ray ray = {.direction = {0.0, 0.0, -1.0}, .far_t = HUGE_VAL};
	for (int row = 0; row < 3; row++)
		ray.origin[row] = (double)(m[row] * p[0] + m[4 + row] * p[1] + m[8 + row] * p[2] + m[12 + row]);
	ray.origin[0] += 1e-8 * ((double)scene->bounds.x[1 + i % 3] - ray.origin[0]);
	ray.origin[1] += 1e-8 * ((double)scene->bounds.y[1 + i % 3] - ray.origin[1]);
	ray.origin[2] += 30.0;
	return ray;
}

/* Returns how many rays hit. */
static uint32_t compare_picks(const stilb_scene *scene, stilb_scene_pick_index *index, uint32_t rays)
{
	uint32_t hits = 0;
	for (uint32_t i = 0; i < rays; i++) {
		stilb_scene_ray ray = i % 2 ? field_ray(i / 2) : edge_ray(scene, i / 2);
		stilb_scene_hit plain, indexed;
		bool found = stilb_scene_pick(scene, &ray, &plain);
		assert_int_equal(stilb_scene_pick_indexed(scene, &ray, index, &indexed), found);
		assert_true(!found || same_hit(&plain, &indexed));
		hits += found;
	}
	return hits;
}

static void test_an_index_changes_nothing(void **state)
{
	(void)state;
	for (int shuffled = 0; shuffled < 2; shuffled++) {
		stilb_scene *scene = field_scene(shuffled);
		stilb_scene_pick_index *index = stilb_scene_pick_index_create();
		assert_true(compare_picks(scene, index, 150) > 100);
		/* A mountain: the index must forget the mesh to see it. */
		stilb_scene_vertex peak = {.position = {45.0f, 45.0f, 20.0f}, .normal = {0, 0, 1}};
		assert_int_equal(stilb_scene_set_vertices(scene, 1, 45 * (SIDE + 1) + 45, 1, &peak), STILB_OK);
		stilb_scene_changes_read(scene);
		stilb_scene_ray ray = {{45.1, 80.0, 15.0}, {0.0, -1.0, 0.0}, 0.0, HUGE_VAL};
		stilb_scene_hit hit;
		assert_true(stilb_scene_pick(scene, &ray, &hit));
		assert_false(stilb_scene_pick_indexed(scene, &ray, index, &hit));
		stilb_scene_pick_index_forget(index, 1);
		assert_true(stilb_scene_pick_indexed(scene, &ray, index, &hit));
		assert_true(compare_picks(scene, index, 60) > 30);
		stilb_scene_pick_index_destroy(index);
		stilb_scene_destroy(scene);
	}
	stilb_scene_pick_index_destroy(NULL);
	stilb_scene_pick_index_clear(NULL);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_the_nearest_front_is_met), cmocka_unit_test(test_segments_and_ties),
		cmocka_unit_test(test_the_cameras_rays),         cmocka_unit_test(test_bounds_hide_nothing),
		cmocka_unit_test(test_an_index_changes_nothing),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
