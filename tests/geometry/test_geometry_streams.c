/* The simplifier and its cache go by the table of vertex streams: a stream that a table has and another has not changes
 * what they do, without a line of theirs. */
#include "support/test.h"

#include "geometry/geometry_plan.h"
#include "geometry/mesh_made.h"

/* What vertices would be with tangents. */
typedef struct wide_vertex {
	stilb_scene_vertex base;
	float tangent[4];
} wide_vertex;

#define WIDE_STREAMS (STILB_SCENE_VERTEX_STREAMS + 1)

/* The table of such vertices, whose tangents are a seam or not. */
static stilb_scene_streams wide_table(stilb_scene_stream rows[WIDE_STREAMS], bool seam)
{
	memcpy(rows, stilb_scene_vertex_streams.streams, STILB_SCENE_VERTEX_STREAMS * sizeof *rows);
	rows[STILB_SCENE_VERTEX_STREAMS] = (stilb_scene_stream){.name = "tangent",
	                                                        .kind = STILB_SCENE_STREAM_VALUE,
	                                                        .components = 4,
	                                                        .offset = offsetof(wide_vertex, tangent),
	                                                        .weight = 0.5f,
	                                                        .seam = seam};
	return (stilb_scene_streams){WIDE_STREAMS, sizeof(wide_vertex), rows};
}

static void wide_weights(const stilb_scene_streams *table, float weights[WIDE_STREAMS])
{
	for (uint32_t s = 0; s < table->count; s++)
		weights[s] = table->streams[s].weight;
}

static void place_flat(stilb_scene_vertex *vertex)
{
	vertex->position[0] = vertex->uv[0];
	vertex->position[2] = vertex->uv[1];
	vertex->normal[1] = 1.0f;
}

/* A plane of 16 x 16 squares, cut along its middle: the vertices there are two each, of which the second belongs to the
 * half x > 0.5 and has another tangent, and all else the same. */
static stilb_scene_mesh cut_plane(wide_vertex **wide)
{
	stilb_scene_mesh plane = mesh_grid(16, 16, place_flat);
	stilb_scene_mesh mesh = mesh_empty(plane.vertex_count + 17, plane.index_count);
	memcpy(mesh.vertices, plane.vertices, plane.vertex_count * sizeof *plane.vertices);
	for (uint32_t i = 0; i < 17; i++)
		mesh.vertices[plane.vertex_count + i] = plane.vertices[17 * i + 8];
	for (uint32_t t = 0; t < plane.index_count; t += 3) {
		const uint32_t *corner = plane.indices + t;
		float middle =
			(plane.vertices[corner[0]].uv[0] + plane.vertices[corner[1]].uv[0] + plane.vertices[corner[2]].uv[0]) /
			3.0f;
		for (uint32_t c = 0; c < 3; c++)
			mesh.indices[t + c] =
				middle > 0.5f && corner[c] % 17 == 8 ? plane.vertex_count + corner[c] / 17 : corner[c];
	}
	*wide = calloc(mesh.vertex_count, sizeof **wide);
	assert_non_null(*wide);
	for (uint32_t v = 0; v < mesh.vertex_count; v++) {
		(*wide)[v].base = mesh.vertices[v];
		bool other = v >= plane.vertex_count || mesh.vertices[v].uv[0] > 0.5f;
		(*wide)[v].tangent[0] = other ? -1.0f : 1.0f;
	}
	stilb_scene_mesh_finish(&plane);
	return mesh;
}

static stilb_geometry_simplified simplify(const stilb_scene_mesh *mesh, const stilb_scene_streams *table,
                                          const void *vertices, uint32_t target)
{
	float weights[WIDE_STREAMS];
	stilb_geometry_stream streams[STILB_GEOMETRY_STREAMS];
	wide_weights(table, weights);
	stilb_geometry_mesh view = {.vertex_count = mesh->vertex_count,
	                            .index_count = mesh->index_count,
	                            .indices = mesh->indices,
	                            .positions = vertices,
	                            .position_stride = table->size,
	                            .stream_count = geometry_streams_of(table, vertices, weights, streams),
	                            .streams = streams};
	stilb_geometry_simplify_desc desc = {.target_triangles = target};
	stilb_geometry_simplified simplified;
	assert_int_equal(streams[0].components, 3);
	assert_string_equal(streams[view.stream_count - 1].name, table->streams[table->count - 1].name);
	assert_int_equal(stilb_geometry_simplify(&view, &desc, NULL, 0, &simplified), STILB_OK);
	return simplified;
}

/* True if all corners of each triangle are of one half, by their tangents. */
static bool halves_stay(const stilb_geometry_simplified *simplified, const wide_vertex *wide)
{
	for (uint32_t i = 0; i < simplified->index_count; i++)
		if (wide[simplified->indices[i]].tangent[0] != wide[simplified->indices[i / 3 * 3]].tangent[0])
			return false;
	return simplified->index_count > 0;
}

static void test_a_new_seam_is_kept(void **state)
{
	(void)state;
	wide_vertex *wide;
	stilb_scene_stream rows[WIDE_STREAMS];
	stilb_scene_mesh mesh = cut_plane(&wide);
	stilb_scene_streams table = wide_table(rows, true);
	rows[STILB_SCENE_VERTEX_STREAMS].weight = 0.0f; /* so that the seam alone counts */
	stilb_geometry_simplified without = simplify(&mesh, &stilb_scene_vertex_streams, mesh.vertices, 8);
	stilb_geometry_simplified with = simplify(&mesh, &table, wide, 8);
	assert_false(halves_stay(&without, wide));
	assert_true(halves_stay(&with, wide));
	assert_in_range(with.index_count / 3, 4, 8);
	stilb_geometry_simplified_finish(&without);
	stilb_geometry_simplified_finish(&with);
	stilb_scene_mesh_finish(&mesh);
	free(wide);
}

/* Each of these has another key. */
static void test_a_new_stream_has_another_key(void **state)
{
	(void)state;
	wide_vertex *wide;
	stilb_scene_stream rows[WIDE_STREAMS];
	float weights[WIDE_STREAMS];
	uint64_t keys[8][2];
	stilb_scene_mesh mesh = cut_plane(&wide);
	stilb_geometry_levels_desc desc = stilb_geometry_levels_desc_default();
	geometry_cache_key(&stilb_scene_vertex_streams, mesh.vertices, desc.weights, &mesh, &desc, keys[0]);
	stilb_scene_streams table = wide_table(rows, false);
	wide_weights(&table, weights);
	geometry_cache_key(&table, wide, weights, &mesh, &desc, keys[1]);
	wide[3].tangent[2] = 0.25f;
	geometry_cache_key(&table, wide, weights, &mesh, &desc, keys[2]);
	rows[STILB_SCENE_VERTEX_STREAMS].seam = true;
	geometry_cache_key(&table, wide, weights, &mesh, &desc, keys[3]);
	rows[STILB_SCENE_VERTEX_STREAMS].name = "colour";
	geometry_cache_key(&table, wide, weights, &mesh, &desc, keys[4]);
	rows[STILB_SCENE_VERTEX_STREAMS].kind = STILB_SCENE_STREAM_TEXTURE;
	geometry_cache_key(&table, wide, weights, &mesh, &desc, keys[5]);
	weights[STILB_SCENE_VERTEX_STREAMS] = 0.75f;
	geometry_cache_key(&table, wide, weights, &mesh, &desc, keys[6]);
	rows[STILB_SCENE_VERTEX_STREAMS].components = 3;
	geometry_cache_key(&table, wide, weights, &mesh, &desc, keys[7]);
	for (uint32_t a = 0; a < 8; a++)
		for (uint32_t b = 0; b < a; b++)
			assert_true(keys[a][0] != keys[b][0] && keys[a][1] != keys[b][1]);
	geometry_cache_key(&stilb_scene_vertex_streams, mesh.vertices, desc.weights, &mesh, &desc, keys[1]);
	assert_memory_equal(keys[0], keys[1], sizeof keys[0]);
	stilb_scene_mesh_finish(&mesh);
	free(wide);
}

/* Each byte of a vertex belongs to one stream, and names are told apart. */
static void test_the_table(void **state)
{
	(void)state;
	const stilb_scene_streams *table = &stilb_scene_vertex_streams;
	uint32_t at = 0;
	assert_int_equal(table->streams[0].kind, STILB_SCENE_STREAM_POSITION);
	for (uint32_t s = 0; s < table->count; s++) {
		assert_int_equal(table->streams[s].offset, at);
		at += table->streams[s].components * (uint32_t)sizeof(float);
		assert_in_range(strlen(table->streams[s].name), 1, 15);
		for (uint32_t other = 0; other < s; other++)
			assert_string_not_equal(table->streams[s].name, table->streams[other].name);
	}
	assert_int_equal(at, table->size);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_the_table),
		cmocka_unit_test(test_a_new_seam_is_kept),
		cmocka_unit_test(test_a_new_stream_has_another_key),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
