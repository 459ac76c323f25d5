/* What levels and clusters say of their errors, at a million random points of each surface; a thousand cuts of a closed
 * mesh. */
#include "support/test.h"

#include "geometry/cuts_made.h"
#include "geometry/geometry_levels.h"

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

/* Clusters as large as they are in the program. */
static void check_clusters(stilb_scene_mesh *mesh)
{
	stilb_geometry_levels_desc desc = stilb_geometry_levels_desc_default();
	desc.cluster_least = 5000;
	assert_int_equal(stilb_geometry_levels(mesh, &desc, NULL, 0), STILB_OK);
	assert_in_range(mesh->group_count, 10, 100);
	check_errors(mesh, 2, POINTS);
	for (uint32_t l = 0; l < mesh->level_count; l += 3) {
		const stilb_scene_level *level = &mesh->levels[l];
		const uint32_t *indices = mesh->level_indices + level->first_index;
		float there = mesh_farthest(mesh, mesh->indices, mesh->index_count, indices, level->index_count, POINTS, l);
		float back = mesh_farthest(mesh, indices, level->index_count, mesh->indices, mesh->index_count, POINTS, 99);
		assert_true(there <= level->error && back <= level->error);
	}
	stilb_scene_mesh_finish(mesh);
}

static void place_noise(stilb_scene_vertex *vertex)
{
	mesh_place_hills(vertex);
	vertex->position[1] +=
		0.1f * stilb_random_float((uint64_t)(vertex->uv[0] * 1e6f), (uint64_t)(vertex->uv[1] * 1e6f));
}

static void test_clusters(void **state)
{
	(void)state;
	stilb_scene_mesh mesh = mesh_grid(160, 80, mesh_place_torus);
	check_clusters(&mesh);
	mesh = mesh_grid(110, 110, place_noise);
	check_clusters(&mesh);
	assert_int_equal(stilb_scene_mesh_sphere(5, &mesh), STILB_OK);
	stilb_scene_mesh facets = mesh_facets(&mesh);
	stilb_scene_mesh_finish(&mesh);
	check_clusters(&facets);
}

static void test_cuts(void **state)
{
	(void)state;
	stilb_scene_mesh mesh = torus_of(64, 32);
	assert_true(make_clusters(&mesh));
	uint32_t *canonical = canonical_of(&mesh);
	cut c = cut_create(&mesh);
	for (uint32_t i = 0; i < 1000; i++) {
		cut_choose(&mesh, 1000 + i, &c);
		mesh_shape shape = mesh_shape_of(&mesh, canonical, c.indices, c.count);
		assert_int_equal(shape.border + shape.odd, 0);
		assert_int_equal(shape.euler, 0);
	}
	cut_finish(&c);
	free(canonical);
	stilb_scene_mesh_finish(&mesh);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_sphere),   cmocka_unit_test(test_torus), cmocka_unit_test(test_hills),
		cmocka_unit_test(test_clusters), cmocka_unit_test(test_cuts),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
