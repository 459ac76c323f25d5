/* What levels say of their errors, at a million random points of each surface. */
#include "support/test.h"

#include "geometry/geometry_levels.h"
#include "geometry/mesh_made.h"

#define POINTS 1000000u

static void check(stilb_scene_mesh *mesh)
{
	stilb_geometry_levels_desc desc = stilb_geometry_levels_desc_default();
	assert_int_equal(stilb_geometry_levels(mesh, &desc, NULL, 0), STILB_OK);
	assert_in_range(mesh->level_count, 6, STILB_SCENE_MAX_LEVELS);
	for (uint32_t l = 1; l < mesh->level_count; l += 3) {
		const stilb_scene_level *level = &mesh->levels[l];
		const uint32_t *indices = mesh->level_indices + level->first_index;
		float there = mesh_farthest(mesh, mesh->indices, mesh->index_count, indices, level->index_count, POINTS, l);
		float back = mesh_farthest(mesh, indices, level->index_count, mesh->indices, mesh->index_count, POINTS, 99);
		if (!(there <= level->error && back <= level->error))
			print_message("level of %u triangles: %g, %g > %g\n", level->index_count / 3, (double)there, (double)back,
			              (double)level->error);
		assert_true(there <= level->error && back <= level->error);
		assert_true(level->error <= 1.2f * fmaxf(there, back) + 1e-5f);
	}
	stilb_scene_mesh_finish(mesh);
}

static void test_sphere(void **state)
{
	(void)state;
	stilb_scene_mesh mesh;
	assert_int_equal(stilb_scene_mesh_sphere(5, &mesh), STILB_OK);
	check(&mesh);
}

static void test_torus(void **state)
{
	(void)state;
	stilb_scene_mesh mesh = mesh_grid(150, 70, mesh_place_torus);
	check(&mesh);
}

static void test_hills(void **state)
{
	(void)state;
	stilb_scene_mesh mesh = mesh_grid(90, 90, mesh_place_hills);
	check(&mesh);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_sphere),
		cmocka_unit_test(test_torus),
		cmocka_unit_test(test_hills),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
