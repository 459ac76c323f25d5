/* Levels of meshes: manifolds stay manifolds, borders and seams stay, every level uses a prefix of the vertices, finer
 * triangles morph onto coarser ones, errors are bounds, the same bits for any number of workers; meshes of every bad
 * kind; no memory. */
#include "support/test.h"

#include "geometry/geometry_internal.h"
#include "geometry/geometry_levels.h"
#include "geometry/mesh_made.h"

static uint32_t allocations_left = UINT32_MAX;

void *__real_stilb_memory_alloc(size_t count, size_t size);
void *__wrap_stilb_memory_alloc(size_t count, size_t size);

void *__wrap_stilb_memory_alloc(size_t count, size_t size)
{
	if (allocations_left == 0)
		return NULL;
	if (allocations_left != UINT32_MAX) /* jobs only read it, as long as nothing is to fail */
		allocations_left--;
	return __real_stilb_memory_alloc(count, size);
}

static stilb_job_pool *pool_of(uint32_t workers)
{
	stilb_job_pool_desc desc = {.worker_count = workers, .affinity = STILB_JOB_AFFINITY_NONE};
	stilb_job_pool *pool;
	assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
	return pool;
}

static uint32_t *canonical_of(const stilb_scene_mesh *mesh)
{
	uint32_t *canonical = malloc(sizeof *canonical * (mesh->vertex_count + 1));
	assert_non_null(canonical);
	stilb_geometry_mesh view = {.vertex_count = mesh->vertex_count,
	                            .positions = mesh->vertices->position,
	                            .position_stride = sizeof *mesh->vertices};
	assert_true(geometry_weld(&view, NULL, 0, canonical));
	return canonical;
}

static void make_levels(stilb_scene_mesh *mesh)
{
	stilb_geometry_levels_desc desc = stilb_geometry_levels_desc_default();
	stilb_result result = stilb_geometry_levels(mesh, &desc, NULL, 0);
	if (result != STILB_OK)
		print_message("%s\n", stilb_error_message());
	assert_int_equal(result, STILB_OK);
}

static stilb_scene_mesh bumpy_torus(uint32_t w, uint32_t h)
{
	stilb_scene_mesh mesh = mesh_grid(w, h, mesh_place_torus);
	uint32_t *canonical = canonical_of(&mesh);
	mesh_smooth(&mesh, canonical);
	free(canonical);
	return mesh;
}

static stilb_scene_mesh hills(uint32_t side)
{
	stilb_scene_mesh mesh = mesh_grid(side, side, mesh_place_hills);
	uint32_t *canonical = canonical_of(&mesh);
	mesh_smooth(&mesh, canonical);
	free(canonical);
	return mesh;
}

static const uint32_t *level_indices(const stilb_scene_mesh *mesh, uint32_t level, uint32_t *count)
{
	*count = level > 0 ? mesh->levels[level - 1].index_count : mesh->index_count;
	return level > 0 ? mesh->level_indices + mesh->levels[level - 1].first_index : mesh->indices;
}

static uint32_t level_vertices(const stilb_scene_mesh *mesh, uint32_t level)
{
	return level > 0 ? mesh->levels[level - 1].vertex_count : mesh->vertex_count;
}

/* What holds of the levels of every mesh. */
static void check_ranges(const stilb_scene_mesh *mesh)
{
	uint32_t finer_count = mesh->index_count, finer_vertices = mesh->vertex_count;
	float finer_error = 0.0f;
	for (uint32_t l = 1; l <= mesh->level_count; l++) {
		uint32_t count, vertices = level_vertices(mesh, l), highest = 0;
		const uint32_t *indices = level_indices(mesh, l, &count);
		assert_in_range(count, 3, finer_count - 3);
		assert_int_equal(count % 3, 0);
		assert_in_range(vertices, 1, finer_vertices);
		for (uint32_t i = 0; i < count; i++)
			highest = indices[i] > highest ? indices[i] : highest;
		assert_true(highest < vertices);
		assert_true(mesh->levels[l - 1].error >= finer_error);
		finer_error = mesh->levels[l - 1].error;
		finer_count = count;
		finer_vertices = vertices;
	}
}

/* A triangle by the values of its corners, the least first, turned. */
typedef struct triangle_value {
	stilb_scene_vertex corner[3];
} triangle_value;

static int by_value(const void *a, const void *b)
{
	return memcmp(a, b, sizeof(triangle_value));
}

static void turn_to_least(triangle_value *triangle)
{
	for (int turn = 0; turn < 2; turn++) {
		triangle_value other = {{triangle->corner[1], triangle->corner[2], triangle->corner[0]}};
		triangle_value third = {{triangle->corner[2], triangle->corner[0], triangle->corner[1]}};
		if (by_value(&other, triangle) < 0)
			*triangle = other;
		if (by_value(&third, triangle) < 0)
			*triangle = third;
	}
}

/* With the vertices that a level drops at their morphs, the finer triangles are those of the level or nothing. */
static void check_morph(const stilb_scene_mesh *mesh)
{
	for (uint32_t l = 1; l <= mesh->level_count; l++) {
		uint32_t count, finer, kept = 0, vertices = level_vertices(mesh, l);
		const uint32_t *indices = level_indices(mesh, l, &count), *from = level_indices(mesh, l - 1, &finer);
		triangle_value *own = malloc(sizeof *own * finer), *all = malloc(sizeof *all * finer);
		assert_non_null(own);
		assert_non_null(all);
		for (uint32_t t = 0; t < finer / 3; t++) {
			triangle_value triangle;
			for (uint32_t k = 0; k < 3; k++) {
				uint32_t v = from[3 * t + k];
				triangle.corner[k] = v < vertices ? mesh->vertices[v] : mesh->morph[v];
			}
			bool is_flat = false;
			for (uint32_t k = 0; k < 3; k++)
				is_flat |= memcmp(triangle.corner[k].position, triangle.corner[(k + 1) % 3].position, 12) == 0;
			if (is_flat)
				continue;
			turn_to_least(&triangle);
			all[kept++] = triangle;
		}
		for (uint32_t t = 0; t < count / 3; t++) {
			for (uint32_t k = 0; k < 3; k++)
				own[t].corner[k] = mesh->vertices[indices[3 * t + k]];
			turn_to_least(&own[t]);
		}
		assert_int_equal(kept, count / 3);
		qsort(own, count / 3, sizeof *own, by_value);
		qsort(all, kept, sizeof *all, by_value);
		assert_memory_equal(own, all, kept * sizeof *own);
		free(own);
		free(all);
	}
}

static void check_errors(const stilb_scene_mesh *mesh, uint32_t samples)
{
	for (uint32_t l = 1; l <= mesh->level_count; l++) {
		uint32_t count;
		const uint32_t *indices = level_indices(mesh, l, &count);
		float there = mesh_farthest(mesh, mesh->indices, mesh->index_count, indices, count, samples, l);
		float back = mesh_farthest(mesh, indices, count, mesh->indices, mesh->index_count, samples, 100 + l);
		float farthest = fmaxf(there, back), error = mesh->levels[l - 1].error;
		if (farthest > error || (samples >= 10000 && error > 1.4f * farthest + 1e-4f))
			print_message("level %u of %u triangles: %g + %g > %g\n", l, count / 3, (double)there, (double)back,
			              (double)error);
		assert_true(farthest <= error);
		/* Of few samples none may be that far: the farthest point is at a vertex. */
		assert_true(samples < 10000 || error <= 1.4f * farthest + 1e-4f);
	}
}

static void check_shape(const stilb_scene_mesh *mesh, int euler, double border_length)
{
	uint32_t *canonical = canonical_of(mesh);
	for (uint32_t l = 0; l <= mesh->level_count; l++) {
		uint32_t count;
		const uint32_t *indices = level_indices(mesh, l, &count);
		mesh_shape shape = mesh_shape_of(mesh, canonical, indices, count);
		assert_int_equal(shape.odd, 0);
		assert_int_equal(shape.euler, euler);
		assert_true(fabs(shape.border_length - border_length) <= 0.01 * border_length);
		assert_true((shape.border == 0) == (border_length <= 0.0));
	}
	free(canonical);
}

/* ---- good meshes ------------------------------------------------------------------------------------------------- */

/* Tangents and the rest stay with their vertices. */
static void test_extras(void **state)
{
	(void)state;
	stilb_scene_mesh mesh = bumpy_torus(40, 20);
	mesh.extras = stilb_memory_alloc(mesh.vertex_count, sizeof *mesh.extras);
	for (uint32_t v = 0; v < mesh.vertex_count; v++)
		mesh.extras[v] = (stilb_scene_vertex_extra){.uv = {mesh.vertices[v].position[0], mesh.vertices[v].uv[1]}};
	make_levels(&mesh);
	assert_true(mesh.level_count > 0);
	for (uint32_t v = 0; v < mesh.vertex_count; v++) {
		assert_true(mesh.extras[v].uv[0] == mesh.vertices[v].position[0]);
		assert_true(mesh.extras[v].uv[1] == mesh.vertices[v].uv[1]);
	}
	stilb_scene_mesh_finish(&mesh);
}

#define TILES 24u

/* A board of TILES x TILES tiles of four vertices each, dark and light by turns. */
static stilb_scene_mesh tiles_make(void)
{
	stilb_scene_mesh mesh = mesh_empty(4 * TILES * TILES, 6 * TILES * TILES);
	mesh.extras = stilb_memory_alloc(mesh.vertex_count, sizeof *mesh.extras);
	for (uint32_t t = 0; t < TILES * TILES; t++) {
		uint32_t x = t % TILES, z = t / TILES;
		const uint32_t square[6] = {4 * t, 4 * t + 2, 4 * t + 1, 4 * t + 1, 4 * t + 2, 4 * t + 3};
		for (uint32_t c = 0; c < 4; c++) {
			float shade = (x + z) % 2 ? 0.1f : 0.9f;
			mesh.vertices[4 * t + c] =
				(stilb_scene_vertex){{(float)(x + c % 2), 0.0f, (float)(z + c / 2)}, {0.0f, 1.0f, 0.0f}, {0.0f, 0.0f}};
			mesh.extras[4 * t + c] = (stilb_scene_vertex_extra){.color = {shade, shade, shade, 1.0f}};
		}
		memcpy(mesh.indices + 6 * t, square, sizeof square);
	}
	return mesh;
}

/* No level of a board shows another colour anywhere: triangles have one, and dark ones cover half of it. */
static void test_colors(void **state)
{
	(void)state;
	stilb_scene_mesh mesh = tiles_make();
	make_levels(&mesh);
	for (uint32_t l = 0; l < mesh.level_count; l++) {
		double dark = 0.0, all = 0.0;
		for (uint32_t i = 0; i < mesh.levels[l].index_count; i += 3) {
			const uint32_t *v = mesh.level_indices + mesh.levels[l].first_index + i;
			const float *a = mesh.vertices[v[0]].position, *b = mesh.vertices[v[1]].position,
						*c = mesh.vertices[v[2]].position;
			double area = 0.5 * fabs((double)((b[0] - a[0]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[0] - a[0])));
			assert_true(mesh.extras[v[0]].color[0] == mesh.extras[v[1]].color[0]);
			assert_true(mesh.extras[v[0]].color[0] == mesh.extras[v[2]].color[0]);
			dark += mesh.extras[v[0]].color[0] < 0.5f ? area : 0.0;
			all += area;
		}
		assert_true(fabs(dark - 0.5 * all) < 1e-3 * all);
	}
	stilb_scene_mesh_finish(&mesh);
	mesh = bumpy_torus(40, 20); /* even colours of each position forbid no level */
	mesh.extras = stilb_memory_alloc(mesh.vertex_count, sizeof *mesh.extras);
	for (uint32_t v = 0; v < mesh.vertex_count; v++)
		for (int c = 0; c < 3; c++)
			mesh.extras[v].color[c] = 0.5f + 0.2f * mesh.vertices[v].position[c];
	make_levels(&mesh);
	assert_true(mesh.level_count > 2);
	stilb_scene_mesh_finish(&mesh);
}

static void test_sphere(void **state)
{
	(void)state;
	stilb_scene_mesh mesh;
	assert_int_equal(stilb_scene_mesh_sphere(5, &mesh), STILB_OK);
	make_levels(&mesh);
	assert_in_range(mesh.level_count, 8, 11); /* from 20,480 to some 20 */
	assert_in_range(mesh.levels[mesh.level_count - 1].index_count / 3, 4, 40);
	check_ranges(&mesh);
	check_shape(&mesh, 2, 0.0);
	check_morph(&mesh);
	check_errors(&mesh, TEST_ASAN ? 2000 : 20000);
	stilb_scene_mesh_finish(&mesh);
}

/* No triangle reaches over a seam of the texture, and every vertex at a seam has its partner on the other side. */
static void check_torus_seams(const stilb_scene_mesh *mesh)
{
	for (uint32_t l = 0; l <= mesh->level_count; l++) {
		uint32_t count;
		const uint32_t *indices = level_indices(mesh, l, &count);
		double area = 0.0;
		for (uint32_t t = 0; t < count / 3; t++) {
			const float *uv[3];
			for (uint32_t k = 0; k < 3; k++)
				uv[k] = mesh->vertices[indices[3 * t + k]].uv;
			area += 0.5 * (double)((uv[1][0] - uv[0][0]) * (uv[2][1] - uv[0][1]) -
			                       (uv[1][1] - uv[0][1]) * (uv[2][0] - uv[0][0]));
		}
		/* The texture covers the surface once: its triangles are all of the unit square, and turned alike. */
		assert_true(fabs(fabs(area) - 1.0) < 1e-4);
	}
}

static void test_torus(void **state)
{
	(void)state;
	stilb_scene_mesh mesh = bumpy_torus(120, 60);
	make_levels(&mesh);
	assert_in_range(mesh.level_count, 6, 11);
	check_ranges(&mesh);
	check_shape(&mesh, 0, 0.0);
	check_torus_seams(&mesh);
	check_morph(&mesh);
	check_errors(&mesh, TEST_ASAN ? 2000 : 20000);
	stilb_scene_mesh_finish(&mesh);
}

static void test_hills(void **state)
{
	(void)state;
	stilb_scene_mesh mesh = hills(60);
	for (uint32_t v = 0; v < mesh.vertex_count; v++) /* a border that has a known length */
		if (mesh.vertices[v].uv[0] == 0.0f || mesh.vertices[v].uv[0] == 1.0f || mesh.vertices[v].uv[1] == 0.0f ||
		    mesh.vertices[v].uv[1] == 1.0f)
			mesh.vertices[v].position[1] = 0.0f;
	make_levels(&mesh);
	assert_in_range(mesh.level_count, 6, 10);
	check_ranges(&mesh);
	check_shape(&mesh, 1, 40.0);
	check_morph(&mesh);
	check_errors(&mesh, TEST_ASAN ? 2000 : 20000);
	stilb_scene_mesh_finish(&mesh);
}

/* Vertices of six or more different normals at each position. */
static void test_facets(void **state)
{
	(void)state;
	stilb_scene_mesh sphere, mesh;
	assert_int_equal(stilb_scene_mesh_sphere(3, &sphere), STILB_OK);
	mesh = mesh_facets(&sphere);
	make_levels(&mesh);
	assert_in_range(mesh.level_count, 4, 8);
	check_ranges(&mesh);
	check_shape(&mesh, 2, 0.0);
	check_morph(&mesh);
	stilb_scene_mesh_finish(&sphere);
	stilb_scene_mesh_finish(&mesh);
}

static bool is_edge_of_square(const stilb_scene_vertex *vertex)
{
	return vertex->uv[0] == 0.0f || vertex->uv[0] == 1.0f || vertex->uv[1] == 0.0f || vertex->uv[1] == 1.0f;
}

/* A torus whose texture is in pieces: each triangle belongs to one of three, drawn by lot for patches of the surface,
 * so that seams branch, end at each other and enclose single triangles. */
static stilb_scene_mesh torus_in_pieces(uint32_t seed, float patches)
{
	stilb_scene_mesh whole = bumpy_torus(24, 16), mesh = mesh_facets(&whole);
	for (uint32_t i = 0; i < mesh.index_count; i++) {
		const stilb_scene_vertex *first = &whole.vertices[whole.indices[i - i % 3]];
		uint32_t patch = (uint32_t)(first->uv[0] * patches) * 31u + (uint32_t)(first->uv[1] * patches);
		uint32_t piece = ((patch + seed * 977u) * 2654435769u >> 16) % 3;
		mesh.vertices[i] = whole.vertices[whole.indices[i]];
		mesh.vertices[i].uv[0] += 2.0f * (float)piece;
	}
	stilb_scene_mesh_finish(&whole);
	return mesh;
}

/* A collapse onto the end of a seam is looked at again when other collapses have brought more of the seam there. */
static void test_pieces(void **state)
{
	(void)state;
	static const float patches[] = {5.0f, 9.0f, 24.0f};
	for (uint32_t seed = 0; seed < (TEST_ASAN ? 6 : 24); seed++) {
		stilb_scene_mesh mesh = torus_in_pieces(seed, patches[seed % 3]);
		make_levels(&mesh);
		check_ranges(&mesh);
		check_shape(&mesh, 0, 0.0);
		stilb_scene_mesh_finish(&mesh);
	}
}

/* Positions that are locked stay in all levels. */
static void test_locks(void **state)
{
	(void)state;
	stilb_scene_mesh mesh = hills(32);
	uint8_t *locked = calloc(mesh.vertex_count, 1);
	assert_non_null(locked);
	uint32_t count = 0;
	for (uint32_t v = 0; v < mesh.vertex_count; v++)
		count += locked[v] = is_edge_of_square(&mesh.vertices[v]);
	stilb_geometry_levels_desc desc = stilb_geometry_levels_desc_default();
	desc.locked = locked;
	assert_int_equal(stilb_geometry_levels(&mesh, &desc, NULL, 0), STILB_OK);
	assert_in_range(mesh.level_count, 2, 6);
	check_ranges(&mesh);
	check_morph(&mesh);
	uint32_t index_count, seen = 0;
	const uint32_t *indices = level_indices(&mesh, mesh.level_count, &index_count);
	uint8_t *used = calloc(mesh.vertex_count, 1);
	assert_non_null(used);
	for (uint32_t i = 0; i < index_count; i++)
		used[indices[i]] = 1;
	for (uint32_t v = 0; v < mesh.vertex_count; v++)
		seen += used[v] && is_edge_of_square(&mesh.vertices[v]);
	assert_int_equal(seen, count);
	free(used);
	free(locked);
	stilb_scene_mesh_finish(&mesh);
}

/* ---- the same bits ----------------------------------------------------------------------------------------------- */

static void assert_same_mesh(const stilb_scene_mesh *a, const stilb_scene_mesh *b)
{
	assert_int_equal(a->level_count, b->level_count);
	assert_int_equal(a->level_index_count, b->level_index_count);
	assert_memory_equal(a->vertices, b->vertices, a->vertex_count * sizeof *a->vertices);
	assert_memory_equal(a->indices, b->indices, a->index_count * sizeof *a->indices);
	assert_memory_equal(a->levels, b->levels, a->level_count * sizeof *a->levels);
	assert_memory_equal(a->level_indices, b->level_indices, a->level_index_count * sizeof *a->level_indices);
	assert_memory_equal(a->morph, b->morph, a->vertex_count * sizeof *a->morph);
}

/* A mesh of several regions. */
static void test_same_bits(void **state)
{
	(void)state;
	stilb_scene_mesh original = TEST_TSAN ? bumpy_torus(120, 80) : bumpy_torus(160, 80), first = mesh_copy(&original);
	make_levels(&first);
	check_shape(&first, 0, 0.0);
	check_torus_seams(&first);
	const uint32_t workers[] = {0, 1, 2, 3, 8};
	for (size_t i = 0; i < sizeof workers / sizeof *workers; i++) {
		if ((TEST_TSAN || TEST_ASAN) && workers[i] != 3)
			continue;
		stilb_job_pool *pool = pool_of(workers[i]);
		stilb_scene_mesh again = mesh_copy(&original);
		stilb_geometry_levels_desc desc = stilb_geometry_levels_desc_default();
		assert_int_equal(stilb_geometry_levels(&again, &desc, pool, 0), STILB_OK);
		assert_same_mesh(&first, &again);
		stilb_scene_mesh_finish(&again);
		stilb_job_pool_destroy(pool);
	}
	stilb_scene_mesh_finish(&original);
	stilb_scene_mesh_finish(&first);
}

/* ---- bad meshes -------------------------------------------------------------------------------------------------- */

static void test_empty(void **state)
{
	(void)state;
	stilb_scene_mesh mesh = {0};
	make_levels(&mesh);
	assert_int_equal(mesh.level_count, 0);
	mesh = mesh_empty(3, 3);
	mesh.vertices[1].position[0] = mesh.vertices[2].position[1] = 1.0f;
	mesh.indices[1] = 1;
	mesh.indices[2] = 2;
	make_levels(&mesh);
	assert_int_equal(mesh.level_count, 0);
	assert_int_equal(mesh.index_count, 3);
	stilb_geometry_simplify_desc desc = {.target_triangles = 0};
	stilb_geometry_mesh view = {.vertex_count = 3,
	                            .index_count = 3,
	                            .indices = mesh.indices,
	                            .positions = mesh.vertices->position,
	                            .position_stride = sizeof *mesh.vertices};
	stilb_geometry_simplified simplified;
	assert_int_equal(stilb_geometry_simplify(&view, &desc, NULL, 0, &simplified), STILB_OK);
	assert_int_equal(simplified.index_count, 3); /* nothing would be left */
	stilb_geometry_simplified_finish(&simplified);
	stilb_scene_mesh_finish(&mesh);
}

/* Makes levels of hills after something was done to them. */
static void check_damaged(void (*damage)(stilb_scene_mesh *mesh))
{
	stilb_scene_mesh mesh = hills(24);
	damage(&mesh);
	stilb_scene_mesh before = mesh_copy(&mesh);
	make_levels(&mesh);
	check_ranges(&mesh);
	assert_int_equal(mesh.index_count, before.index_count);
	stilb_scene_mesh_finish(&before);
	stilb_scene_mesh_finish(&mesh);
}

static void damage_nan(stilb_scene_mesh *mesh)
{
	for (uint32_t v = 7; v < mesh->vertex_count; v += 50) {
		mesh->vertices[v].position[v % 3] = v % 2 ? NAN : INFINITY;
		mesh->vertices[v + 1].normal[0] = NAN;
		mesh->vertices[v + 2].uv[1] = -INFINITY;
	}
}

static void damage_all_nan(stilb_scene_mesh *mesh)
{
	for (uint32_t v = 0; v < mesh->vertex_count; v++)
		mesh->vertices[v].position[0] = NAN;
}

static void damage_huge(stilb_scene_mesh *mesh)
{
	for (uint32_t v = 0; v < mesh->vertex_count; v++)
		for (int axis = 0; axis < 3; axis++)
			mesh->vertices[v].position[axis] *= 1e16f;
}

/* All triangles at one vertex: more neighbours than the simplifier looks at. */
static void damage_star(stilb_scene_mesh *mesh)
{
	for (uint32_t t = 0; t < mesh->index_count / 3; t++) {
		mesh->indices[3 * t] = 0;
		mesh->indices[3 * t + 1] = 1 + t % (mesh->vertex_count - 2);
		mesh->indices[3 * t + 2] = 2 + t % (mesh->vertex_count - 2);
	}
}

static void test_damaged(void **state)
{
	(void)state;
	check_damaged(damage_nan);
	check_damaged(damage_all_nan);
	check_damaged(damage_one_point);
	check_damaged(damage_one_line);
	check_damaged(damage_huge);
	check_damaged(damage_tiny);
	check_damaged(damage_indices);
	check_damaged(damage_twice);
	check_damaged(damage_star);
}

/* What is not a manifold is kept, and what hangs on it is simplified: two spheres that touch in a point, and three
 * sheets along one line. */
static void test_touching(void **state)
{
	(void)state;
	stilb_scene_mesh sphere;
	assert_int_equal(stilb_scene_mesh_sphere(3, &sphere), STILB_OK);
	stilb_scene_mesh mesh = mesh_empty(2 * sphere.vertex_count, 2 * sphere.index_count);
	for (uint32_t v = 0; v < 2 * sphere.vertex_count; v++) {
		mesh.vertices[v] = sphere.vertices[v % sphere.vertex_count];
		if (v >= sphere.vertex_count) /* the pole of one is at that of the other */
			mesh.vertices[v].position[1] += 2.0f;
	}
	for (uint32_t i = 0; i < 2 * sphere.index_count; i++)
		mesh.indices[i] = sphere.indices[i % sphere.index_count] + (i < sphere.index_count ? 0 : sphere.vertex_count);
	make_levels(&mesh);
	check_ranges(&mesh);
	assert_in_range(mesh.level_count, 4, 8);
	check_shape(&mesh, 3, 0.0); /* two spheres that share a point */
	stilb_scene_mesh_finish(&sphere);
	stilb_scene_mesh_finish(&mesh);
}

static void test_refusals(void **state)
{
	(void)state;
	stilb_scene_mesh mesh = hills(8);
	stilb_geometry_levels_desc desc = stilb_geometry_levels_desc_default();
	desc.ratio = 0.95f;
	assert_int_equal(stilb_geometry_levels(&mesh, &desc, NULL, 0), STILB_ERROR_ARGUMENT);
	desc = stilb_geometry_levels_desc_default();
	desc.weights[STILB_SCENE_VERTEX_UV] = -1.0f;
	assert_int_equal(stilb_geometry_levels(&mesh, &desc, NULL, 0), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "'uv'"));
	desc = stilb_geometry_levels_desc_default();
	mesh.indices[5] = mesh.vertex_count;
	assert_int_equal(stilb_geometry_levels(&mesh, &desc, NULL, 0), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "index 5"));
	mesh.index_count--;
	assert_int_equal(stilb_geometry_levels(&mesh, &desc, NULL, 0), STILB_ERROR_ARGUMENT);
	assert_int_equal(mesh.level_count, 0);
	stilb_scene_mesh_finish(&mesh);
}

static void test_no_memory(void **state)
{
	(void)state;
	stilb_scene_mesh mesh = bumpy_torus(92, 46), before = mesh_copy(&mesh); /* two regions */
	stilb_geometry_levels_desc desc = stilb_geometry_levels_desc_default();
	stilb_result result = STILB_ERROR_MEMORY;
	uint32_t allowed = 0;
	for (; result != STILB_OK && allowed < 2000; allowed += allowed < 16 ? 1 : allowed / 4) {
		allocations_left = allowed;
		result = stilb_geometry_levels(&mesh, &desc, NULL, 0);
		allocations_left = UINT32_MAX;
		assert_true(result == STILB_OK || result == STILB_ERROR_MEMORY);
		if (result != STILB_OK) {
			assert_int_equal(mesh.level_count, 0);
			assert_memory_equal(mesh.indices, before.indices, mesh.index_count * sizeof *mesh.indices);
			assert_memory_equal(mesh.vertices, before.vertices, mesh.vertex_count * sizeof *mesh.vertices);
		}
	}
	assert_in_range(allowed, 40, 1999);
	stilb_scene_mesh_finish(&before);
	stilb_scene_mesh_finish(&mesh);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		test_one_thread(test_extras),   test_one_thread(test_colors),    test_one_thread(test_sphere),
		test_one_thread(test_torus),    test_one_thread(test_hills),     test_one_thread(test_facets),
		test_one_thread(test_pieces),   test_one_thread(test_locks),     cmocka_unit_test(test_same_bits),
		test_one_thread(test_empty),    test_one_thread(test_damaged),   test_one_thread(test_touching),
		test_one_thread(test_refusals), test_one_thread(test_no_memory),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
