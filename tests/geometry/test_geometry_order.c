/* The order of triangles of each level, as libmeshoptimizer's analysis sees it beside its own orders: vertices that are
 * transformed for a triangle (ACMR, a cache of 16), pixels that are drawn for one that stays, and bytes of vertices
 * that are fetched for one that is used. */
#include "support/test.h"

#include "geometry/geometry_levels.h"
#include "geometry/mesh_made.h"

#include <meshoptimizer.h>

/* Times what libmeshoptimizer reaches. Vertices lie in the order of the coarsest level that uses them, which costs the
 * finest ones some fetches. */
#define ACMR 1.1
#define OVERDRAW 1.1
#define OVERFETCH 1.2

typedef struct seen {
	double acmr, overdraw, overfetch;
} seen;

static seen analyze(const stilb_scene_mesh *mesh, const uint32_t *indices, uint32_t count)
{
	size_t vertices = mesh->vertex_count, stride = sizeof *mesh->vertices;
	return (seen){
		.acmr = (double)meshopt_analyzeVertexCache(indices, count, vertices, 16, 0, 0).acmr,
		.overdraw =
			(double)meshopt_analyzeOverdraw(indices, count, mesh->vertices->position, vertices, stride).overdraw,
		.overfetch = (double)meshopt_analyzeVertexFetch(indices, count, vertices, stride).overfetch,
	};
}

/* What libmeshoptimizer makes of the same triangles: first for the cache, then within 5 % of that against overdraw. */
static seen analyze_peer(const stilb_scene_mesh *mesh, const uint32_t *indices, uint32_t count)
{
	stilb_scene_mesh other = mesh_empty(mesh->vertex_count, count);
	meshopt_optimizeVertexCache(other.indices, indices, count, mesh->vertex_count);
	meshopt_optimizeOverdraw(other.indices, other.indices, count, mesh->vertices->position, mesh->vertex_count,
	                         sizeof *mesh->vertices, 1.05f);
	meshopt_optimizeVertexFetch(other.vertices, other.indices, count, mesh->vertices, mesh->vertex_count,
	                            sizeof *mesh->vertices);
	seen of = analyze(&other, other.indices, count);
	stilb_scene_mesh_finish(&other);
	return of;
}

static void check(stilb_scene_mesh *mesh)
{
	stilb_geometry_levels_desc desc = stilb_geometry_levels_desc_default();
	assert_int_equal(stilb_geometry_levels(mesh, &desc, NULL, 0), STILB_OK);
	assert_true(mesh->level_count >= 6);
	for (uint32_t l = 0; l <= mesh->level_count; l++) {
		uint32_t count = l > 0 ? mesh->levels[l - 1].index_count : mesh->index_count;
		const uint32_t *indices = l > 0 ? mesh->level_indices + mesh->levels[l - 1].first_index : mesh->indices;
		if (count / 3 < 500) /* of few triangles all is in the cache */
			break;
		seen own = analyze(mesh, indices, count), peer = analyze_peer(mesh, indices, count);
		bool good = own.acmr <= ACMR * peer.acmr && own.overdraw <= OVERDRAW * peer.overdraw &&
		            own.overfetch <= OVERFETCH * peer.overfetch;
		if (!good)
			print_message("%u triangles: acmr %.3f of %.3f, overdraw %.3f of %.3f, overfetch %.2f of %.2f\n", count / 3,
			              own.acmr, peer.acmr, own.overdraw, peer.overdraw, own.overfetch, peer.overfetch);
		assert_true(good);
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
