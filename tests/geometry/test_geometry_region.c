/* The rules of single collapses, on meshes of a few triangles in which one position may go and the others are locked;
 * and the tree of boxes against all triangles one by one. */
#include "support/test.h"

#include "geometry/geometry_region.h"
#include "geometry/mesh_made.h"

#define MOST 64

typedef struct few {
	float position[MOST][3], uv[MOST][2];
	uint32_t indices[MOST * 3], canonical[MOST], owner[MOST];
	uint8_t locked[MOST];
	uint32_t vertices, triangles;
} few;

static uint32_t add_vertex(few *f, float x, float y, float z)
{
	uint32_t v = f->vertices++;
	f->position[v][0] = x;
	f->position[v][1] = y;
	f->position[v][2] = z;
	f->uv[v][0] = x;
	f->uv[v][1] = y;
	f->canonical[v] = v;
	f->locked[v] = 1;
	return v;
}

static void add_triangle(few *f, uint32_t a, uint32_t b, uint32_t c)
{
	uint32_t *out = &f->indices[3 * f->triangles++];
	out[0] = a;
	out[1] = b;
	out[2] = c;
}

/* The vertices around the origin, which is vertex 0 and may go; radii[i] of the i-th of n. */
static few fan(uint32_t n, const float *radii, bool closed)
{
	few f = {0};
	add_vertex(&f, 0.0f, 0.0f, 0.0f);
	f.locked[0] = 0;
	for (uint32_t i = 0; i < n; i++) {
		float angle = 6.2831853f * (float)i / (float)(closed ? n : 2 * (n - 1)), r = radii ? radii[i] : 1.0f;
		add_vertex(&f, r * cosf(angle), r * sinf(angle), 0.0f);
	}
	for (uint32_t i = 0; i < n - !closed; i++)
		add_triangle(&f, 0, 1 + i, 1 + (i + 1) % n);
	return f;
}

/* How many collapses are made, and onto which vertex the first leads. */
static uint32_t collapses(const few *f, bool regions, uint32_t *to)
{
	stilb_geometry_stream stream = {"uv", STILB_GEOMETRY_TEXTURE, 2, 1.0f, true, &f->uv[0][0], sizeof f->uv[0]};
	stilb_geometry_mesh mesh = {.vertex_count = f->vertices,
	                            .index_count = 3 * f->triangles,
	                            .indices = f->indices,
	                            .positions = &f->position[0][0],
	                            .position_stride = sizeof f->position[0],
	                            .stream_count = 1,
	                            .streams = &stream};
	geometry_round round = {.mesh = &mesh,
	                        .canonical = f->canonical,
	                        .locked = f->locked,
	                        .owner = regions ? f->owner : NULL,
	                        .scale = {1.0f},
	                        .value_limit = 1e6f,
	                        .groups = 1};
	geometry_record record;
	geometry_stop stop = {.triangles = 0, .cost = 1e30f};
	assert_true(geometry_region_collapse(&round, 0, (const uint32_t(*)[3])f->indices, f->triangles, stop, &record));
	uint32_t count = record.count;
	if (to && count > 0)
		*to = record.to[0];
	geometry_record_finish(&record);
	return count;
}

static void test_fan(void **state)
{
	(void)state;
	few f = fan(6, NULL, true);
	assert_int_equal(collapses(&f, false, NULL), 1);
	f.locked[0] = 1;
	assert_int_equal(collapses(&f, false, NULL), 0);
	f.triangles = 0;
	assert_int_equal(collapses(&f, false, NULL), 0);
}

/* A collapse that would make an edge between two vertices which another region joins already. */
static void test_shared(void **state)
{
	(void)state;
	few f = fan(4, NULL, true);
	for (uint32_t v = 1; v <= 4; v++)
		f.owner[v] = 1000;
	f.owner[1] = f.owner[3] = GEOMETRY_SHARED;
	f.locked[2] = f.locked[4] = 1;
	f.owner[2] = f.owner[4] = 0;
	/* Onto 2 and 4, which are this region's alone, it may go; onto 1 and 3 not, since both are shared. */
	uint32_t to = 0;
	assert_int_equal(collapses(&f, true, &to), 1);
	assert_true(to == 2 || to == 4);
	f.owner[2] = f.owner[4] = GEOMETRY_SHARED;
	assert_int_equal(collapses(&f, true, NULL), 0);
}

static void test_tetrahedron(void **state)
{
	(void)state;
	few f = fan(3, NULL, true);
	f.position[0][2] = 1.0f;
	add_triangle(&f, 3, 2, 1);
	for (uint32_t v = 0; v < 4; v++)
		f.locked[v] = 0;
	assert_int_equal(collapses(&f, false, NULL), 0);
}

/* A vertex inside that borders on both sides of a seam which begins at its neighbour. */
static void test_seam_end(void **state)
{
	(void)state;
	few f = fan(6, NULL, true);
	uint32_t other = add_vertex(&f, 1.0f, 0.0f, 0.0f); /* the other side of vertex 1 */
	f.canonical[other] = 1;
	f.uv[other][0] = 7.0f;
	f.indices[3 * 5 + 2] = other; /* the last triangle */
	f.uv[1][1] = 0.001f;          /* cheapest */
	uint32_t to = 0;
	assert_int_equal(collapses(&f, false, &to), 1);
	assert_true(to != 1 && to != other);
	for (uint32_t v = 2; v <= 6; v++)
		f.uv[v][1] += 3.0f; /* still not, when all others are dear */
	assert_int_equal(collapses(&f, false, &to), 1);
	assert_true(to != 1 && to != other);
}

/* Two cones that touch in their points. */
static void test_two_fans(void **state)
{
	(void)state;
	few f = fan(4, NULL, true);
	for (uint32_t v = 1; v <= 4; v++)
		f.position[v][2] = 1.0f;
	for (uint32_t i = 0; i < 4; i++)
		add_vertex(&f, f.position[1 + i][0], f.position[1 + i][1], -1.0f);
	for (uint32_t i = 0; i < 4; i++)
		add_triangle(&f, 0, 5 + (i + 1) % 4, 5 + i);
	assert_int_equal(collapses(&f, false, NULL), 0);
}

/* A pinwheel: from no corner can all others be seen. */
static void test_turning(void **state)
{
	(void)state;
	few f = {0};
	add_vertex(&f, 0.0f, 0.0f, 0.0f);
	f.locked[0] = 0;
	for (uint32_t i = 0; i < 8; i++) {
		float angle = 6.2831853f * ((float)(i / 2) + (i % 2 ? 0.92f : 0.0f)) / 4.0f, r = i % 2 ? 0.3f : 1.0f;
		add_vertex(&f, r * cosf(angle), r * sinf(angle), 0.0f);
	}
	for (uint32_t i = 0; i < 8; i++)
		add_triangle(&f, 0, 1 + i, 1 + (i + 1) % 8);
	assert_int_equal(collapses(&f, false, NULL), 0);
}

/* A position at a border goes along it, however dear that is. */
static void test_border(void **state)
{
	(void)state;
	few f = fan(5, NULL, false);
	const float places[4][2] = {{1.0f, 0.0f}, {0.3f, 0.3f}, {0.0f, 0.3f}, {-0.3f, 0.3f}};
	for (uint32_t v = 1; v < 5; v++)
		memcpy(f.position[v], places[v - 1], sizeof places[0]);
	f.uv[1][0] += 5.0f;
	f.uv[5][0] -= 5.0f;
	uint32_t to = 0;
	assert_int_equal(collapses(&f, false, &to), 1);
	assert_true(to == 1 || to == 5);
}

/* ---- the tree ---------------------------------------------------------------------------------------------------- */

static float brute_distance(const stilb_scene_mesh *mesh, uint32_t triangle, const double p[3])
{
	/* By subdivision of the triangle's edges and inside, in double: the nearest of points close to one another. */
	double best = 1e300;
	const uint32_t *corner = &mesh->indices[3 * triangle];
	for (int i = 0; i <= 40; i++)
		for (int j = 0; i + j <= 40; j++) {
			double square = 0.0;
			for (int axis = 0; axis < 3; axis++) {
				double at = ((double)mesh->vertices[corner[0]].position[axis] * (40 - i - j) +
				             (double)mesh->vertices[corner[1]].position[axis] * i +
				             (double)mesh->vertices[corner[2]].position[axis] * j) /
				            40.0;
				square += (at - p[axis]) * (at - p[axis]);
			}
			best = square < best ? square : best;
		}
	return (float)sqrt(best);
}

static void test_tree(void **state)
{
	(void)state;
	stilb_scene_mesh mesh = mesh_grid(9, 7, mesh_place_torus);
	geometry_tree tree;
	assert_true(geometry_tree_create(mesh.vertices->position, sizeof *mesh.vertices, mesh.indices, mesh.index_count / 3,
	                                 NULL, 0, &tree));
	assert_int_equal(tree.count, 126);
	for (uint32_t i = 0; i < 60; i++) {
		double p[3];
		float nearest = FLT_MAX;
		for (uint32_t axis = 0; axis < 3; axis++)
			p[axis] = (double)(4.0f * stilb_random_float(5, 3 * i + axis) - 2.0f);
		for (uint32_t t = 0; t < tree.count; t++)
			nearest = fminf(nearest, brute_distance(&mesh, t, p));
		stilb_vec3 point = stilb_vec3_make((float)p[0], (float)p[1], (float)p[2]);
		geometry_nearest found = geometry_tree_nearest(&tree, point, FLT_MAX, -1.0f, UINT32_MAX);
		assert_true(sqrtf(found.square) <= nearest + 1e-5f && sqrtf(found.square) >= nearest - 0.03f);
		geometry_nearest hinted = geometry_tree_nearest(&tree, point, FLT_MAX, -1.0f, i * 2);
		assert_true(hinted.square == found.square);
		/* The point that it names is there. */
		const geometry_tree_triangle *triangle = &tree.triangles[found.triangle];
		float square = 0.0f;
		for (int axis = 0; axis < 3; axis++) {
			float at = triangle->corner[0][axis] +
			           found.at[0] * (triangle->corner[1][axis] - triangle->corner[0][axis]) +
			           found.at[1] * (triangle->corner[2][axis] - triangle->corner[0][axis]) - point[axis];
			square += at * at;
		}
		assert_true(fabsf(square - found.square) < 1e-4f);
		geometry_nearest any = geometry_tree_nearest(&tree, point, FLT_MAX, 4.0f * found.square, UINT32_MAX);
		assert_true(any.square >= found.square && any.square <= 4.0f * found.square);
		assert_int_equal(geometry_tree_nearest(&tree, point, 0.99f * found.square, -1.0f, UINT32_MAX).triangle,
		                 UINT32_MAX);
	}
	geometry_tree_finish(&tree);
	stilb_scene_mesh_finish(&mesh);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_fan),      cmocka_unit_test(test_shared),   cmocka_unit_test(test_tetrahedron),
		cmocka_unit_test(test_seam_end), cmocka_unit_test(test_two_fans), cmocka_unit_test(test_turning),
		cmocka_unit_test(test_border),   cmocka_unit_test(test_tree),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
