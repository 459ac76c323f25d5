/* The studio and what is shown behind models: against closed forms of the light that a floor loses, of the light that
 * emission gives, and of surroundings out of focus. */
#include "scene/scene_build.h"
#include "scene/scene_internal.h"
#include "scene/scene_look.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* A rectangle from its centre and halves of its sides; it faces along cross(half_x, half_y). */
typedef struct rectangle {
	float center[3], half_x[3], half_y[3];
	float emission;
} rectangle;

static stilb_scene *scene_of(const rectangle *rectangles, uint32_t count)
{
	static const float grey[3] = {0.5f, 0.5f, 0.5f}, none[3] = {0};
	stilb_mat4 here = stilb_mat4_identity();
	stilb_scene_build *build = stilb_scene_build_begin();
	for (uint32_t r = 0; r < count; r++) {
		stilb_scene_vertex vertices[4] = {
			{.normal = {0, 1, 0}}, {.normal = {0, 1, 0}}, {.normal = {0, 1, 0}}, {.normal = {0, 1, 0}}};
		uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
		for (int corner = 0; corner < 4; corner++)
			for (int i = 0; i < 3; i++)
				vertices[corner].position[i] = rectangles[r].center[i] +
				                               (corner == 1 || corner == 2 ? 1.0f : -1.0f) * rectangles[r].half_x[i] +
				                               (corner >= 2 ? 1.0f : -1.0f) * rectangles[r].half_y[i];
		stilb_scene_mesh mesh = {.vertices = vertices, .indices = indices, .vertex_count = 4, .index_count = 6};
		stilb_scene_material material = stilb_scene_material_make(grey, none, 1.0f);
		for (int i = 0; i < 3; i++)
			material.emission[i] = rectangles[r].emission;
		stilb_scene_build_part part = {stilb_scene_build_mesh(build, &mesh),
		                               stilb_scene_build_material(build, &material)};
		stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &here), &part, 1);
	}
	stilb_scene *scene;
	assert_int_equal(stilb_scene_build_end(build, &scene), STILB_OK);
	return scene;
}

/* True if it is lit by two squares of side 2 that face each other at a distance of 20, one of which emits. */
static bool lit_across(float emission, float turned)
{
	const rectangle two[] = {{{0, 0, 0}, {1, 0, 0}, {0, turned, 0}, emission}, {{0, 0, 20}, {-1, 0, 0}, {0, 1, 0}, 0}};
	stilb_scene *scene = scene_of(two, 2);
	bool lit = scene_is_lit(scene);
	stilb_scene_destroy(scene);
	return lit;
}

/* The other square gets L A / d^2 = L / 100, the mean of both is half of that. The studio gives a convex body a quarter
 * of its lights' 4.65 and all of its surroundings, pi 0.27: 2.011, a hundredth of which is reached with L = 4.02. */
static void emission_that_counts(void **state)
{
	(void)state;
	assert_false(lit_across(3.96f, 1));
	assert_true(lit_across(4.08f, 1));
	assert_false(lit_across(100.0f, -1)); /* it shines the other way */
	assert_false(lit_across(0.0f, 1));
	/* Light that goes another way does not count against what arrives: 8 x 4 x 4 / 400 / 3 / 4 on three squares. */
	static const rectangle three[] = {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 8},
	                                  {{0, 0, 20}, {-1, 0, 0}, {0, 1, 0}, 0},
	                                  {{0, 0, -5}, {-1, 0, 0}, {0, 1, 0}, 100}};
	stilb_scene *both = scene_of(three, 3);
	assert_true(scene_is_lit(both));
	stilb_scene_destroy(both);
	/* What is bright and convex lights nothing but the camera. */
	static const rectangle cube[] = {
		{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, 1e6f},  {{0, 0, -1}, {-1, 0, 0}, {0, 1, 0}, 1e6f},
		{{1, 0, 0}, {0, 0, -1}, {0, 1, 0}, 1e6f}, {{-1, 0, 0}, {0, 0, 1}, {0, 1, 0}, 1e6f},
		{{0, 1, 0}, {1, 0, 0}, {0, 0, -1}, 1e6f}, {{0, -1, 0}, {1, 0, 0}, {0, 0, 1}, 1e6f}};
	stilb_scene *scene = scene_of(cube, 6);
	assert_false(scene_is_lit(scene));
	stilb_scene_set_sky(scene, (const float[3]){0, 0, 1e-6f});
	assert_true(scene_is_lit(scene));
	stilb_scene_destroy(scene);
}

static stilb_scene *studio_of(const rectangle *rectangles, uint32_t count)
{
	stilb_scene *scene = scene_of(rectangles, count);
	assert_int_equal(stilb_scene_set_studio(scene, 0.3f), STILB_OK);
	assert_true(scene->studio && scene->light_count == 3 && scene->backdrop.floor);
	for (uint32_t i = 0; i < scene->light_count; i++)
		assert_null(stilb_scene_light_mistake(&scene->lights[i]));
	return scene;
}

/* What models hide from the floor at this place, metres from its centre. */
static double covered_at(const stilb_scene *scene, float x, float z)
{
	const stilb_scene_floor *floor = scene->backdrop.floor;
	float scale = 0.5f * STILB_SCENE_FLOOR_SIDE / (STILB_SCENE_FLOOR_REACH * floor->radius);
	int column = (int)floorf(x * scale + 0.5f * STILB_SCENE_FLOOR_SIDE);
	int row = (int)floorf(z * scale + 0.5f * STILB_SCENE_FLOOR_SIDE);
	assert_in_range(column, 0, STILB_SCENE_FLOOR_SIDE - 1);
	assert_in_range(row, 0, STILB_SCENE_FLOOR_SIDE - 1);
	return (double)floor->covered[row][column];
}

static void assert_near(double value, double wanted, double error)
{
	if (!(fabs(value - wanted) <= error))
		print_error("%g where %g is right\n", value, wanted);
	assert_true(fabs(value - wanted) <= error);
}

/* What a wall of height 1 without ends hides from the floor at the distance d. */
static double behind_wall(double d)
{
	return 0.5 * (1.0 - d / sqrt(d * d + 1.0));
}

/* A wall along x; cells know it to half a cell. */
static void a_wall_darkens_the_floor(void **state)
{
	(void)state;
	static const rectangle wall = {{0, 5.5f, 0}, {10, 0, 0}, {0, 0.5f, 0}, 0};
	stilb_scene *scene = studio_of(&wall, 1);
	float cell = STILB_SCENE_FLOOR_REACH * scene->backdrop.floor->radius * 2.0f / STILB_SCENE_FLOOR_SIDE;
	assert_near((double)scene->backdrop.floor->center[1], 5.0, 1e-6);
	for (int i = 1; i < 5; i++) { /* a mean of three cells, of weights 1 2 1 */
		double wanted = 0.0, error = 0.01;
		for (int k = -1; k <= 1; k++) {
			double d = (double)cell * (0.5 + i + k), half = 0.5 * (double)cell, weight = k == 0 ? 0.5 : 0.25;
			wanted += weight * 0.5 * (behind_wall(d) + behind_wall(d + half));
			error += weight * 0.5 * (behind_wall(d) - behind_wall(d + half));
		}
		assert_near(covered_at(scene, 0, -(float)cell * (0.5f + (float)i)), wanted, error);
	}
	assert_true(covered_at(scene, 0, -15) < 0.01 && covered_at(scene, 0, 15) < 0.01);
	stilb_scene_destroy(scene);
}

/* Under the middle of a board of the half side a at the height h, which a thin leg carries: nearly as under a disk,
 * a^2 / (a^2 + h^2); on the floor all of it. */
static void a_board_darkens_the_floor(void **state)
{
	(void)state;
	static const rectangle table[] = {{{0, 2, 0}, {4, 0, 0}, {0, 0, -4}, 0},
	                                  {{3.9f, 1, 3.9f}, {0.05f, 0, 0}, {0, 1, 0}, 0}};
	stilb_scene *scene = studio_of(table, 2);
	assert_near(covered_at(scene, 0.01f, 0.01f), 1.1 * 16.0 / 20.0, 0.06); /* a square has corners, too */
	assert_true(covered_at(scene, 7, 0) < covered_at(scene, 5, 0) && covered_at(scene, 5, 0) < 0.5);
	scene->model_flags[0] = STILB_SCENE_MODEL_CASTS_NO_SHADOW;
	assert_int_equal(stilb_scene_set_studio(scene, 0.3f), STILB_OK);
	assert_true(covered_at(scene, 0.01f, 0.01f) < 0.05); /* the leg's */
	stilb_scene_destroy(scene);
	static const rectangle mat = {{0, 0, 0}, {4, 0, 0}, {0, 0, -4}, 0};
	scene = studio_of(&mat, 1);
	assert_near(covered_at(scene, 1, 1), 1.0, 1e-6);
	assert_true(covered_at(scene, 6, 0) == 0.0); /* it has no height */
	stilb_scene_destroy(scene);
}

static const float *map_at(const stilb_scene *scene, int x, int y)
{
	return scene->backdrop.map + 3 * (size_t)(y * STILB_SCENE_BACKDROP_WIDTH + x);
}

static void says_surroundings(const stilb_scene_surroundings *surroundings, const char *words)
{
	char said[160];
	stilb_scene_environment_words(surroundings, said, sizeof said);
	assert_string_equal(said, words);
}

static void surroundings_in_words(void **state)
{
	(void)state;
	static const rectangle mat = {{0, 0, 0}, {4, 0, 0}, {0, 0, -4}, 0};
	stilb_scene *scene = scene_of(&mat, 1);
	scene->surroundings = (stilb_scene_surroundings){.sky = {1, 0.5f, 2}, .ground = {1, 0.5f, 2}};
	says_surroundings(&scene->surroundings, "1,0.5,2");
	scene->surroundings.ground[2] = 0.1f;
	says_surroundings(&scene->surroundings, "1,0.5,2 over 1,0.5,0.1");
	assert_int_equal(stilb_scene_set_studio(scene, 0.0f), STILB_OK);
	says_surroundings(&scene->surroundings, "studio");
	stilb_image *panorama = &scene->surroundings.panorama, map;
	assert_int_equal(stilb_image_create(&map, 8, 4, 3, STILB_IMAGE_F32_LINEAR), STILB_OK);
	assert_int_equal(stilb_image_save(&map, "look \x01.hdr"), STILB_OK);
	stilb_image_finish(&map);
	assert_int_equal(stilb_scene_set_environment(scene, "./look \x01.hdr"), STILB_OK);
	remove("look \x01.hdr");
	says_surroundings(&scene->surroundings, "look  .hdr");
	scene->surroundings.rotation = -1.5707963f;
	says_surroundings(&scene->surroundings, "look  .hdr turned by -90 degrees");
	scene->surroundings.name[0] = '\0';
	says_surroundings(&scene->surroundings, "a panorama turned by -90 degrees");
	stilb_image_finish(panorama);
	stilb_scene_set_sky(scene, (const float[3]){2, 2, 2});
	says_surroundings(&scene->surroundings, "2,2,2");
	stilb_scene_destroy(scene);
}

static void surroundings_out_of_focus(void **state)
{
	(void)state;
	static const rectangle mat = {{0, 0, 0}, {4, 0, 0}, {0, 0, -4}, 0};
	stilb_scene *scene = scene_of(&mat, 1);
	scene->surroundings = (stilb_scene_surroundings){.sky = {3, 3, 3}, .ground = {1, 1, 1}};
	assert_int_equal(stilb_scene_show_surroundings(scene, true), STILB_OK);
	assert_int_equal(scene->backdrop.kind, STILB_SCENE_BACKDROP_MAP);
	assert_near((double)map_at(scene, 9, 0)[1], 3.0, 1e-5);
	assert_near((double)map_at(scene, 9, 31)[1], 1.0, 1e-5);
	assert_near((double)map_at(scene, 9, 15)[1] + (double)map_at(scene, 40, 16)[1], 4.0, 1e-4); /* about the horizon */
	assert_true(map_at(scene, 9, 15)[1] < 2.6f && map_at(scene, 9, 15)[1] > 2.0f);
	/* A bright pixel at +X, of a panorama that is turned by a quarter to the left, to -Z: the map's middle. */
	stilb_image *panorama = &scene->surroundings.panorama;
	assert_int_equal(stilb_image_create(panorama, 128, 64, 3, STILB_IMAGE_F32_LINEAR), STILB_OK);
	((float *)panorama->pixels)[3 * (32 * 128 + 96)] = 1000;
	scene->surroundings.rotation = 1.5707963f;
	assert_int_equal(stilb_scene_show_surroundings(scene, true), STILB_OK);
	float largest = 0;
	for (int i = 0; i < STILB_SCENE_BACKDROP_WIDTH * STILB_SCENE_BACKDROP_HEIGHT; i++)
		largest = fmaxf(largest, scene->backdrop.map[3 * i]);
	assert_true(largest > 1.0f && map_at(scene, 32, 16)[0] > 0.97f * largest &&
	            map_at(scene, 48, 16)[0] < 0.01f * largest);
	assert_true(map_at(scene, 32, 16)[1] == 0.0f);
	/* Near the pole, where cells are small, light stays as much as it was: the mean of all directions. */
	memset(panorama->pixels, 0, stilb_image_size(panorama));
	((float *)panorama->pixels)[3 * (4 * 128 + 20)] = 1000;
	assert_int_equal(stilb_scene_show_surroundings(scene, true), STILB_OK);
	double mean = 0, given = 250.0 * sin(M_PI * 2.5 / 32) / (64 * 32); /* a quarter of a cell */
	for (int y = 0; y < STILB_SCENE_BACKDROP_HEIGHT; y++)
		for (int x = 0; x < STILB_SCENE_BACKDROP_WIDTH; x++)
			mean += (double)map_at(scene, x, y)[0] * sin(M_PI * (y + 0.5) / STILB_SCENE_BACKDROP_HEIGHT) /
			        (STILB_SCENE_BACKDROP_WIDTH * STILB_SCENE_BACKDROP_HEIGHT);
	assert_near(mean, given, 0.1 * given);
	assert_int_equal(stilb_scene_show_surroundings(scene, false), STILB_OK);
	assert_true(scene->backdrop.kind == STILB_SCENE_BACKDROP_SURROUNDINGS && !scene->backdrop.map);
	/* Somebody who follows the scene learns of it. */
	uint64_t before = stilb_scene_revisions_read(scene).surroundings;
	stilb_scene_set_backdrop(scene, NULL);
	assert_true(stilb_scene_revisions_read(scene).surroundings != before);
	stilb_scene_destroy(scene);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(emission_that_counts),      cmocka_unit_test(a_wall_darkens_the_floor),
		cmocka_unit_test(a_board_darkens_the_floor), cmocka_unit_test(surroundings_in_words),
		cmocka_unit_test(surroundings_out_of_focus),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
