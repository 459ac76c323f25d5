/* Clusters of large meshes: whatever groups are replaced, closed meshes stay closed and borders stay where they are,
 * errors are bounds, the same bits for any number of workers; meshes of every bad kind; no memory. Clusters are small
 * here, so that small meshes have many groups. */
#include "support/test.h"

#include "geometry/cuts_made.h"
#include "geometry/geometry_levels.h"
#include "scene/edit/scene_check.h"

#define CUTS (TEST_TSAN || TEST_ASAN ? 20u : 80u)

static uint32_t allocations_left = UINT32_MAX;

void *__real_stilb_memory_alloc(size_t count, size_t size);
void *__wrap_stilb_memory_alloc(size_t count, size_t size);

void *__wrap_stilb_memory_alloc(size_t count, size_t size)
{
	if (allocations_left == 0)
		return NULL;
	if (allocations_left != UINT32_MAX)
		allocations_left--;
	return __real_stilb_memory_alloc(count, size);
}

static void assert_sound(const stilb_scene_mesh *mesh)
{
	stilb_result result = scene_check_clusters(mesh, 0);
	if (result != STILB_OK)
		print_message("%s\n", stilb_error_message());
	assert_int_equal(result, STILB_OK);
}

/* Random cuts: edges are as in the mesh, and the coarsest of them has few triangles. */
static void check_cuts(const stilb_scene_mesh *mesh, double border_slack)
{
	assert_sound(mesh);
	uint32_t *canonical = canonical_of(mesh), least = UINT32_MAX, groups = 0;
	mesh_shape whole = mesh_shape_of(mesh, canonical, mesh->indices, mesh->index_count);
	cut c = cut_create(mesh);
	for (uint32_t i = 0; i < CUTS; i++) {
		cut_choose(mesh, i, &c);
		mesh_shape shape = mesh_shape_of(mesh, canonical, c.indices, c.count);
		if (shape.odd != whole.odd || shape.euler != whole.euler || (whole.border == 0 && shape.border > 0))
			print_message("cut %u: %u of %u triangles, border %u, odd %u, euler %d\n", i, c.count / 3,
			              mesh->index_count / 3, shape.border, shape.odd, shape.euler);
		assert_int_equal(shape.odd, whole.odd);
		assert_int_equal(shape.euler, whole.euler);
		assert_true(shape.border_length <= whole.border_length * 1.0001);
		assert_true(shape.border_length >= whole.border_length * (1.0 - border_slack) - 1e-6);
		least = c.count < least ? c.count : least;
		for (uint32_t g = 0; g < mesh->group_count; g++)
			groups += c.suffices[g] != c.suffices[0];
	}
	assert_in_range(least, 3, mesh->index_count / 8);
	assert_in_range(groups, 10 * CUTS, UINT32_MAX); /* cuts are not uniform */
	cut_finish(&c);
	free(canonical);
}

static void test_closed(void **state)
{
	(void)state;
	stilb_scene_mesh mesh = torus_of(64, 32);
	assert_true(make_clusters(&mesh));
	check_cuts(&mesh, 0.0);
	stilb_scene_mesh_finish(&mesh);
	assert_int_equal(stilb_scene_mesh_sphere(4, &mesh), STILB_OK);
	assert_true(make_clusters(&mesh));
	check_cuts(&mesh, 0.0);
	stilb_scene_mesh_finish(&mesh);
}

/* Positions at which other than none or two edges of one triangle end, as the border passes twice, or ends. */
static uint32_t border_knots(const stilb_scene_mesh *mesh, const uint32_t *canonical, const cut *c)
{
	mesh_edge *edges = malloc(sizeof *edges * (c->count + 1));
	uint8_t *ends = calloc(mesh->vertex_count + 1, 1);
	assert_non_null(edges);
	assert_non_null(ends);
	for (uint32_t i = 0; i < c->count; i++) {
		uint32_t a = canonical[c->indices[i]], b = canonical[c->indices[i % 3 == 2 ? i - 2 : i + 1]];
		edges[i] = a < b ? (mesh_edge){a, b, 1} : (mesh_edge){b, a, -1};
	}
	qsort(edges, c->count, sizeof *edges, mesh_by_edge);
	for (uint32_t i = 0; i < c->count; i++)
		if ((i == 0 || mesh_by_edge(&edges[i - 1], &edges[i]) != 0) &&
		    (i + 1 == c->count || mesh_by_edge(&edges[i], &edges[i + 1]) != 0)) {
			ends[edges[i].low]++;
			ends[edges[i].high]++;
		}
	uint32_t knots = 0;
	for (uint32_t v = 0; v < mesh->vertex_count; v++)
		knots += ends[v] != 0 && ends[v] != 2;
	free(edges);
	free(ends);
	return knots;
}

/* Strips with teeth: triangles of which only one side has a neighbour, which the simplifier takes away. */
static void test_teeth(void **state)
{
	(void)state;
	stilb_scene_mesh mesh = mesh_grid(200, 20, mesh_place_hills);
	uint32_t kept = 0;
	for (uint32_t t = 0; t < mesh.index_count / 3; t++)
		if (t / 2 / 200 % 4 != 0 || t % 2 == 1) {
			memmove(mesh.indices + kept, mesh.indices + 3 * t, 12);
			kept += 3;
		}
	mesh.index_count = 0;
	for (uint32_t t = 0; t < kept / 3; t++) /* of each strip the side without teeth goes: strips are apart then */
		if (mesh.indices[3 * t] / 201 % 4 != 3) {
			memmove(mesh.indices + mesh.index_count, mesh.indices + 3 * t, 12);
			mesh.index_count += 3;
		}
	assert_true(make_clusters(&mesh));
	assert_sound(&mesh);
	uint32_t *canonical = canonical_of(&mesh), teeth = UINT32_MAX;
	cut c = cut_create(&mesh);
	for (uint32_t i = 0; i < CUTS; i++) {
		cut_choose(&mesh, i, &c);
		assert_int_equal(border_knots(&mesh, canonical, &c), 0);
		teeth = c.count < teeth ? c.count : teeth;
	}
	assert_in_range(teeth, 30, mesh.index_count / 8);
	cut_finish(&c);
	free(canonical);
	stilb_scene_mesh_finish(&mesh);
}

static void test_border(void **state)
{
	(void)state;
	stilb_scene_mesh mesh = mesh_grid(48, 48, mesh_place_hills);
	assert_true(make_clusters(&mesh));
	check_cuts(&mesh, 0.2);
	stilb_scene_mesh_finish(&mesh);
}

static void test_facets(void **state)
{
	(void)state;
	stilb_scene_mesh sphere;
	assert_int_equal(stilb_scene_mesh_sphere(4, &sphere), STILB_OK);
	stilb_scene_mesh mesh = mesh_facets(&sphere);
	assert_true(make_clusters(&mesh));
	check_cuts(&mesh, 0.0);
	stilb_scene_mesh_finish(&sphere);
	stilb_scene_mesh_finish(&mesh);
}

/* Spheres beside each other, some of them touching in a point. */
static void test_pieces(void **state)
{
	(void)state;
	stilb_scene_mesh sphere;
	assert_int_equal(stilb_scene_mesh_sphere(2, &sphere), STILB_OK);
	uint32_t count = 12;
	stilb_scene_mesh mesh = mesh_empty(count * sphere.vertex_count, count * sphere.index_count);
	for (uint32_t v = 0; v < mesh.vertex_count; v++) {
		uint32_t i = v / sphere.vertex_count;
		mesh.vertices[v] = sphere.vertices[v % sphere.vertex_count];
		mesh.vertices[v].position[1] += 2.0f * sphere.vertices[0].position[1] * (float)(i % 2);
		mesh.vertices[v].position[0] += 2.5f * (float)(i / 2);
	}
	for (uint32_t i = 0; i < mesh.index_count; i++)
		mesh.indices[i] = sphere.indices[i % sphere.index_count] + i / sphere.index_count * sphere.vertex_count;
	assert_true(make_clusters(&mesh));
	check_cuts(&mesh, 0.0);
	stilb_scene_mesh_finish(&sphere);
	stilb_scene_mesh_finish(&mesh);
}

/* ---- errors ------------------------------------------------------------------------------------------------------ */

static void test_errors(void **state)
{
	(void)state;
	stilb_scene_mesh mesh = torus_of(64, 32);
	assert_true(make_clusters(&mesh));
	check_errors(&mesh, 2, 10000);
	stilb_scene_mesh_finish(&mesh);
	mesh = mesh_grid(40, 40, mesh_place_hills);
	assert_true(make_clusters(&mesh));
	check_errors(&mesh, 2, 10000);
	stilb_scene_mesh_finish(&mesh);
}

/* A needle on a hexagon, replaced by the flat hexagon: only the vertex that is gone is far. */
static void test_needle(void **state)
{
	(void)state;
	float positions[7][3] = {{0.0f, 0.5f, 0.0f}};
	uint32_t finer[6][3];
	for (uint32_t i = 0; i < 6; i++) {
		positions[i + 1][0] = cosf(1.0471976f * (float)i);
		positions[i + 1][2] = -sinf(1.0471976f * (float)i);
		finer[i][0] = 0;
		finer[i][1] = i + 1;
		finer[i][2] = (i + 1) % 6 + 1;
	}
	const uint32_t coarser[4][3] = {{1, 2, 3}, {1, 3, 4}, {1, 4, 5}, {1, 5, 6}};
	const uint32_t canonical[7] = {0, 1, 2, 3, 4, 5, 6}, gone = 0;
	stilb_geometry_mesh mesh = {.vertex_count = 7, .positions = positions[0], .position_stride = sizeof *positions};
	geometry_replaced replaced = {.mesh = &mesh,
	                              .canonical = canonical,
	                              .finer = (const uint32_t(*)[3])finer,
	                              .finer_count = 6,
	                              .coarser = coarser,
	                              .coarser_count = 4,
	                              .gone = &gone,
	                              .gone_count = 1};
	float bound;
	assert_true(geometry_replaced_distance(&replaced, &bound));
	assert_true(bound >= 0.5f && bound <= 0.54f);
}

/* ---- levels and clusters together -------------------------------------------------------------------------------- */

static stilb_job_pool *pool_of(uint32_t workers)
{
	stilb_job_pool_desc desc = {.worker_count = workers, .affinity = STILB_JOB_AFFINITY_NONE};
	stilb_job_pool *pool;
	assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
	return pool;
}

static void test_levels(void **state)
{
	(void)state;
	stilb_scene_mesh original = TEST_TSAN ? torus_of(100, 40) : torus_of(160, 80), first = mesh_copy(&original);
	stilb_geometry_levels_desc desc = stilb_geometry_levels_desc_default();
	desc.cluster_least = 3000;
	assert_int_equal(stilb_geometry_levels(&first, &desc, NULL, 0), STILB_OK);
	assert_int_equal(scene_check_mesh(&first, 0), STILB_OK);
	assert_null(first.morph);
	assert_in_range(first.level_count, 5, STILB_SCENE_MAX_LEVELS);
	assert_in_range(first.levels[0].index_count, 3 * 1000, 3 * 3000);
	const uint32_t workers[] = {0, 1, 3, 8};
	for (size_t i = 0; i < sizeof workers / sizeof *workers; i++) {
		if ((TEST_TSAN || TEST_ASAN) && workers[i] != 3)
			continue;
		stilb_job_pool *pool = pool_of(workers[i]);
		stilb_scene_mesh again = mesh_copy(&original);
		assert_int_equal(stilb_geometry_levels(&again, &desc, pool, 0), STILB_OK);
		assert_int_equal(first.cluster_count, again.cluster_count);
		assert_int_equal(first.group_count, again.group_count);
		assert_int_equal(first.cluster_index_count, again.cluster_index_count);
		assert_memory_equal(first.vertices, again.vertices, first.vertex_count * sizeof *first.vertices);
		assert_memory_equal(first.indices, again.indices, first.index_count * sizeof *first.indices);
		assert_memory_equal(first.level_indices, again.level_indices, first.level_index_count * 4);
		assert_memory_equal(first.clusters, again.clusters, first.cluster_count * sizeof *first.clusters);
		assert_memory_equal(first.groups, again.groups, first.group_count * sizeof *first.groups);
		assert_memory_equal(first.cluster_indices, again.cluster_indices, first.cluster_index_count * 4);
		stilb_scene_mesh_finish(&again);
		stilb_job_pool_destroy(pool);
	}
	uint32_t *canonical = canonical_of(&first);
	for (uint32_t l = 0; l < first.level_count; l++) {
		const stilb_scene_level *level = &first.levels[l];
		const uint32_t *indices = first.level_indices + level->first_index;
		mesh_shape shape = mesh_shape_of(&first, canonical, indices, level->index_count);
		assert_int_equal(shape.border + shape.odd, 0);
		assert_true(mesh_farthest(&first, indices, level->index_count, first.indices, first.index_count, 20000, l) <=
		            level->error);
	}
	free(canonical);
	stilb_scene_mesh_finish(&original);
	stilb_scene_mesh_finish(&first);
}

static bool give_up(void *user)
{
	uint32_t *left = user;
	return (*left)-- == 0;
}

static void test_give_up(void **state)
{
	(void)state;
	stilb_scene_mesh mesh = torus_of(64, 32), before = mesh_copy(&mesh);
	stilb_geometry_levels_desc desc = stilb_geometry_levels_desc_default();
	desc.cluster_least = 1000;
	desc.give_up = give_up;
	for (uint32_t times = 0; times < 3; times++) {
		uint32_t left = times;
		desc.user = &left;
		assert_int_equal(stilb_geometry_levels(&mesh, &desc, NULL, 0), STILB_ERROR_GIVEN_UP);
		assert_memory_equal(mesh.indices, before.indices, mesh.index_count * sizeof *mesh.indices);
		assert_int_equal(mesh.cluster_count + mesh.level_count, 0);
	}
	stilb_scene_mesh_finish(&before);
	stilb_scene_mesh_finish(&mesh);
}

static void test_no_memory(void **state)
{
	(void)state;
	stilb_scene_mesh mesh = torus_of(60, 30), before = mesh_copy(&mesh);
	stilb_geometry_levels_desc desc = stilb_geometry_levels_desc_default();
	desc.cluster_least = 500;
	stilb_result result = STILB_ERROR_MEMORY;
	uint32_t allowed = 0;
	for (; result != STILB_OK && allowed < 2000; allowed += allowed < 60 ? 1 : allowed / 8) {
		allocations_left = allowed;
		result = stilb_geometry_levels(&mesh, &desc, NULL, 0);
		allocations_left = UINT32_MAX;
		assert_true(result == STILB_OK || result == STILB_ERROR_MEMORY);
		if (result != STILB_OK) {
			assert_int_equal(mesh.level_count + mesh.cluster_count, 0);
			assert_memory_equal(mesh.indices, before.indices, mesh.index_count * sizeof *mesh.indices);
			assert_memory_equal(mesh.vertices, before.vertices, mesh.vertex_count * sizeof *mesh.vertices);
		}
	}
	assert_in_range(allowed, 30, 1999);
	assert_in_range(mesh.cluster_count, 10, 100);
	stilb_scene_mesh_finish(&before);
	stilb_scene_mesh_finish(&mesh);
}

/* ---- bad meshes -------------------------------------------------------------------------------------------------- */

static void damage_nan(stilb_scene_mesh *mesh)
{
	for (uint32_t v = 7; v < mesh->vertex_count; v += 50)
		mesh->vertices[v].position[v % 3] = v % 2 ? NAN : INFINITY;
}

static void damage_huge(stilb_scene_mesh *mesh)
{
	for (uint32_t v = 0; v < mesh->vertex_count; v++)
		for (int axis = 0; axis < 3; axis++)
			mesh->vertices[v].position[axis] *= 1e15f;
}

/* One half of the triangles has two corners at one place. */
static void damage_flat(stilb_scene_mesh *mesh)
{
	for (uint32_t t = 0; t < mesh->index_count / 6; t++)
		mesh->indices[3 * t + 1] = mesh->indices[3 * t];
}

/* The indices once more in some order: each triangle of the mesh is there as often as before. */
static uint64_t sum_of_triangles(const stilb_scene_mesh *mesh)
{
	uint64_t sum = 0;
	for (uint32_t i = 0; i < mesh->index_count; i += 3) {
		uint64_t hash = stilb_hash_fnv1a64(STILB_FNV1A64_START, mesh->indices + i, 12);
		sum += hash * hash;
	}
	return sum;
}

static void check_damaged(void (*damage)(stilb_scene_mesh *mesh), bool finite)
{
	stilb_scene_mesh mesh = mesh_grid(40, 40, mesh_place_hills);
	damage(&mesh);
	uint64_t sum = sum_of_triangles(&mesh);
	if (make_clusters(&mesh)) {
		if (finite)
			assert_sound(&mesh);
		assert_true(sum_of_triangles(&mesh) == sum);
		cut c = cut_create(&mesh);
		for (uint32_t i = 0; i < 20; i++)
			cut_choose(&mesh, i, &c);
		cut_finish(&c);
	}
	stilb_scene_mesh_finish(&mesh);
	mesh = mesh_grid(40, 40, mesh_place_hills);
	damage(&mesh);
	stilb_geometry_levels_desc desc = stilb_geometry_levels_desc_default();
	desc.cluster_least = 100;
	assert_int_equal(stilb_geometry_levels(&mesh, &desc, NULL, 0), STILB_OK);
	stilb_scene_mesh_finish(&mesh);
}

static void test_damaged(void **state)
{
	(void)state;
	check_damaged(damage_nan, false);
	check_damaged(damage_one_point, true);
	check_damaged(damage_one_line, true);
	check_damaged(damage_huge, false);
	check_damaged(damage_tiny, true);
	check_damaged(damage_indices, true);
	check_damaged(damage_twice, true);
	check_damaged(damage_flat, true);
}

/* ---- splitting --------------------------------------------------------------------------------------------------- */

static int by_id(const void *a, const void *b)
{
	const geometry_spot *l = a, *r = b;
	return (l->id > r->id) - (l->id < r->id);
}

/* On a line, parts are intervals of the same size; equal places are no trouble. */
static void test_split(void **state)
{
	(void)state;
	geometry_spot spots[1000];
	for (uint32_t same = 1; same < 2000; same += 250)
		for (uint32_t jitter = 0; jitter < 3; jitter++) {
			for (uint32_t i = 0; i < 1000; i++)
				spots[i] = (geometry_spot){{(float)(i * 7919u % 1000u / same), 0.0f, 0.0f}, i};
			geometry_split(spots, 1000, 13, jitter);
			for (uint32_t part = 0; part < 12; part++) {
				float highest = -1.0f, lowest = 2000.0f;
				for (uint32_t i = 1000 * part / 13; i < 1000 * (part + 1) / 13; i++)
					highest = fmaxf(highest, spots[i].at[0]);
				for (uint32_t i = 1000 * (part + 1) / 13; i < 1000 * (part + 2) / 13; i++)
					lowest = fminf(lowest, spots[i].at[0]);
				assert_true(highest <= lowest);
			}
			qsort(spots, 1000, sizeof *spots, by_id);
			for (uint32_t i = 0; i < 1000; i++)
				assert_int_equal(spots[i].id, i);
		}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		test_one_thread(test_closed),    test_one_thread(test_border),  test_one_thread(test_teeth),
		test_one_thread(test_facets),    test_one_thread(test_pieces),  test_one_thread(test_errors),
		test_one_thread(test_needle),    cmocka_unit_test(test_levels), test_one_thread(test_give_up),
		test_one_thread(test_no_memory), test_one_thread(test_damaged), test_one_thread(test_split),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
