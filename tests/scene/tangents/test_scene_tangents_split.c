/* scene_tangents_split: one vertex for each pair of a vertex and a tangent, in the order of the indices. */
#include "support/failing_alloc.h"
#include "support/test.h"
#include "tangents_meshes.h"

#include <string.h>

static tangents_mesh the_mesh;
static float the_tangents[TANGENTS_MOST_INDICES][4];

/* Vertex 1 has the tangents a, b, c, vertex 2 b and c, vertex 4 the tangent a, which vertex 1 has too; 0 and 3 have
 * none. b and c differ in w alone. */
static void test_a_small_mesh(void **state)
{
	(void)state;
	static const float a[4] = {1, 0, 0, 1}, b[4] = {0, 1, 0, 1}, c[4] = {0, 1, 0, -1};
	static const uint32_t indices[9] = {1, 2, 4, 4, 1, 2, 1, 1, 2};
	static const float *const corner[9] = {a, b, a, a, b, c, c, a, c};
	float tangents[9][4];
	for (int i = 0; i < 9; i++)
		memcpy(tangents[i], corner[i], sizeof tangents[i]);
	scene_tangents_mesh mesh = {.indices = indices, .vertex_count = 5, .index_count = 9};
	scene_tangents_split split;
	assert_int_equal(scene_tangents_split_make(&mesh, (const float(*)[4])tangents, &split), STILB_OK);
	static const uint32_t sources[8] = {0, 1, 2, 3, 4, 1, 2, 1}, expected[9] = {1, 2, 4, 4, 5, 6, 7, 1, 6};
	static const float *const vertex[8] = {a, a, b, a, a, b, c, c}; /* unused vertices have a by chance */
	assert_int_equal(split.vertex_count, 8);
	assert_memory_equal(split.sources, sources, sizeof sources);
	assert_memory_equal(split.indices, expected, sizeof expected);
	for (int v = 0; v < 8; v++)
		assert_memory_equal(split.tangents[v], vertex[v], sizeof a);
	scene_tangents_split_finish(&split);
	assert_null(split.sources);
	scene_tangents_split_finish(&split);
}

/* Every corner has its vertex and its tangent back, and no two vertices are alike. */
static void test_random_meshes(void **state)
{
	(void)state;
	uint32_t copies = 0;
	for (uint32_t seed = 0; seed < 200; seed++) {
		tangents_random(&the_mesh, seed);
		scene_tangents_mesh mesh = tangents_view(&the_mesh);
		scene_tangents_split split;
		assert_int_equal(scene_tangents_make(&mesh, the_tangents), STILB_OK);
		assert_int_equal(scene_tangents_split_make(&mesh, (const float(*)[4])the_tangents, &split), STILB_OK);
		uint32_t known = mesh.vertex_count; /* copies come in the order of the indices */
		for (uint32_t c = 0; c < mesh.index_count; c++) {
			uint32_t v = split.indices[c];
			assert_true(v <= known && v < split.vertex_count);
			known += v == known ? 1 : 0;
			assert_int_equal(split.sources[v], mesh.indices[c]);
			assert_memory_equal(split.tangents[v], the_tangents[c], sizeof *split.tangents);
		}
		assert_int_equal(known, split.vertex_count);
		for (uint32_t v = 0; v < split.vertex_count; v++) {
			assert_true(v >= mesh.vertex_count || split.sources[v] == v);
			for (uint32_t w = 0; w < v; w++)
				assert_true(split.sources[v] != split.sources[w] ||
				            memcmp(split.tangents[v], split.tangents[w], sizeof *split.tangents) != 0);
		}
		copies += split.vertex_count - mesh.vertex_count;
		scene_tangents_split_finish(&split);
	}
	assert_true(copies > 1000);
}

static void test_without_memory(void **state)
{
	(void)state;
	static const uint32_t indices[3];
	static const float tangents[3][4];
	scene_tangents_mesh mesh = {.indices = indices, .vertex_count = 7, .index_count = 3};
	scene_tangents_split split;
	allocated = 0;
	assert_int_equal(scene_tangents_split_make(&mesh, tangents, &split), STILB_OK);
	scene_tangents_split_finish(&split);
	int count = allocated;
	assert_int_equal(count, 4);
	for (int i = 0; i < count; i++) {
		fail_after = i;
		assert_int_equal(scene_tangents_split_make(&mesh, tangents, &split), STILB_ERROR_MEMORY);
		assert_string_equal(stilb_error_message(), "no memory for a mesh of 7 vertices and 3 indices with tangents");
		assert_true(!split.sources && !split.tangents && !split.indices && split.vertex_count == 0);
	}
	fail_after = -1;
}

/* 2^32 - 1 vertices leave no number for a copy. */
static void test_more_vertices_than_numbers(void **state)
{
	(void)state;
	static const uint32_t indices[3];
	static const float tangents[3][4];
	scene_tangents_mesh mesh = {.indices = indices, .vertex_count = UINT32_MAX, .index_count = 3};
	scene_tangents_split split;
	allocated = 0;
	assert_int_equal(scene_tangents_split_make(&mesh, tangents, &split), STILB_ERROR_MEMORY);
	assert_int_equal(allocated, 0);
	assert_null(split.sources);
}

static void test_no_triangles(void **state)
{
	(void)state;
	scene_tangents_mesh mesh = {.vertex_count = 2};
	scene_tangents_split split;
	assert_int_equal(scene_tangents_split_make(&mesh, NULL, &split), STILB_OK);
	assert_int_equal(split.vertex_count, 2);
	assert_int_equal(split.sources[1], 1);
	scene_tangents_split_finish(&split);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(test_a_small_mesh),   cmocka_unit_test(test_random_meshes),
		cmocka_unit_test(test_without_memory), cmocka_unit_test(test_more_vertices_than_numbers),
		cmocka_unit_test(test_no_triangles),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
