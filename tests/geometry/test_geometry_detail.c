/* Levels of a scene's meshes, made beside the one who shows it: each is given once, nothing else changes, giving up
 * ends soon. */
#include "support/test.h"

#include "geometry/geometry_detail.h"
#include "geometry/mesh_made.h"
#include "scene/edit/scene_edit.h"
#include "scene/scene_build.h"

#include <stdio.h>
#include <time.h>

static char folder[] = "/tmp/test_geometry_detail.XXXXXX";

/* A torus, a plane, a sphere with levels of its own, and a smaller torus. */
static stilb_scene *make_scene(void)
{
	stilb_scene_mesh torus = mesh_grid(60, 30, mesh_place_torus), plane, sphere,
					 small = mesh_grid(20, 15, mesh_place_torus);
	assert_int_equal(stilb_scene_mesh_plane(&plane), STILB_OK);
	assert_int_equal(stilb_scene_mesh_sphere(3, &sphere), STILB_OK);
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_material grey = stilb_scene_material_make((float[3]){0.5f, 0.5f, 0.5f}, (float[3]){0}, 0.5f);
	const stilb_scene_mesh *meshes[] = {&torus, &plane, &sphere, &small};
	stilb_mat4 here = stilb_mat4_identity();
	uint32_t material = stilb_scene_build_material(build, &grey),
			 node = stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &here);
	for (size_t i = 0; i < sizeof meshes / sizeof *meshes; i++) {
		stilb_scene_build_part part = {stilb_scene_build_mesh(build, meshes[i]), material};
		stilb_scene_build_model(build, node, &part, 1);
	}
	stilb_scene *scene;
	stilb_result result = stilb_scene_build_end(build, &scene);
	if (result != STILB_OK)
		print_message("%s\n", stilb_error_message());
	assert_int_equal(result, STILB_OK);
	stilb_scene_mesh_finish(&torus);
	stilb_scene_mesh_finish(&plane);
	stilb_scene_mesh_finish(&sphere);
	stilb_scene_mesh_finish(&small);
	return scene;
}

static void give_all(stilb_geometry_detail *detail, stilb_scene *scene)
{
	uint32_t calls = 0;
	while (!stilb_geometry_detail_give(detail, scene)) {
		nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
		assert_true(++calls < 60000);
	}
}

static void check_scene(const stilb_scene *scene, uint32_t sphere_levels)
{
	assert_true(scene->meshes[0].level_count >= 5);
	assert_int_equal(scene->meshes[1].level_count, 0);
	assert_int_equal(scene->meshes[2].level_count, sphere_levels);
	assert_true(scene->meshes[3].level_count >= 3);
	assert_int_equal(scene->meshes[0].index_count, 60 * 30 * 6);
}

static void test_beside(void **state)
{
	(void)state;
	stilb_scene *scene = make_scene();
	uint32_t sphere_levels = scene->meshes[2].level_count;
	stilb_geometry_detail *detail;
	assert_int_equal(stilb_geometry_detail_start(scene, &detail), STILB_OK);
	assert_non_null(detail);
	give_all(detail, scene);
	assert_true(stilb_geometry_detail_give(detail, scene));
	stilb_geometry_detail_end(detail);
	check_scene(scene, sphere_levels);
	/* Nothing is left to do. */
	assert_int_equal(stilb_geometry_detail_start(scene, &detail), STILB_OK);
	assert_null(detail);
	assert_true(stilb_geometry_detail_give(detail, scene));
	stilb_geometry_detail_end(detail);
	stilb_scene_destroy(scene);
}

static void test_at_once(void **state)
{
	(void)state;
	stilb_scene *made = make_scene(), *found = make_scene();
	uint32_t sphere_levels = made->meshes[2].level_count;
	stilb_geometry_detail_make(made);
	check_scene(made, sphere_levels);
	stilb_geometry_detail_find(found); /* of those that are kept on disk */
	assert_int_equal(found->meshes[0].level_count, made->meshes[0].level_count);
	assert_int_equal(found->meshes[3].level_count, 0);
	stilb_scene_destroy(made);
	stilb_scene_destroy(found);
}

/* A mesh that was replaced by one of another size meanwhile keeps what it was given. */
static void test_replaced(void **state)
{
	(void)state;
	stilb_scene *scene = make_scene();
	stilb_scene_mesh other = mesh_grid(10, 10, mesh_place_torus);
	stilb_geometry_detail *detail;
	assert_int_equal(stilb_geometry_detail_start(scene, &detail), STILB_OK);
	assert_int_equal(stilb_scene_set_mesh(scene, 0, &other), STILB_OK);
	assert_int_equal(stilb_scene_remove_mesh(scene, 1), STILB_ERROR_ARGUMENT); /* a model shows it */
	give_all(detail, scene);
	stilb_geometry_detail_end(detail);
	assert_int_equal(scene->meshes[0].index_count, other.index_count);
	assert_int_equal(scene->meshes[0].level_count, 0);
	assert_true(scene->meshes[3].level_count >= 3);
	stilb_scene_mesh_finish(&other);
	stilb_scene_destroy(scene);
}

static void test_given_up(void **state)
{
	(void)state;
	setenv("XDG_CACHE_HOME", "/dev/null", 1);
	for (uint32_t i = 0; i < 5; i++) {
		stilb_scene *scene = make_scene();
		stilb_geometry_detail *detail;
		assert_int_equal(stilb_geometry_detail_start(scene, &detail), STILB_OK);
		nanosleep(&(struct timespec){.tv_nsec = 1000000 * i}, NULL);
		stilb_geometry_detail_give(detail, scene);
		stilb_geometry_detail_end(detail);
		stilb_scene_destroy(scene);
	}
	stilb_geometry_detail_end(NULL);
	setenv("XDG_CACHE_HOME", folder, 1);
}

static int start(void **state)
{
	(void)state;
	return mkdtemp(folder) ? setenv("XDG_CACHE_HOME", folder, 1) : -1;
}

static int finish(void **state)
{
	(void)state;
	char command[128];
	snprintf(command, sizeof command, "rm -rf %s", folder);
	return system(command) == 0 ? 0 : -1;
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_beside),
		cmocka_unit_test(test_at_once),
		cmocka_unit_test(test_replaced),
		cmocka_unit_test(test_given_up),
	};
	return cmocka_run_group_tests(tests, start, finish);
}
