/* Charts: nothing turned over, nothing covered twice, every triangle there once; stretch of shapes whose stretch is
 * known; meshes that are broken; the same bits for any number of workers. */
#include "bake_made.h"

#include "bake/unwrap/bake_patch.h"

static stilb_job_pool *pool;

static stilb_bake_uv unwrapped(const made_mesh *made)
{
	stilb_bake_uv uv;
	assert_int_equal(stilb_bake_unwrap(&made->mesh, NULL, pool, 0, &uv), STILB_OK);
	return uv;
}

/* ---- what always holds ------------------------------------------------------------------------------------------- */

static double uv_area(const stilb_bake_uv *uv, uint32_t t)
{
	const float(*p)[2] = (const float(*)[2]) & uv->corners[3 * (size_t)t];
	return 0.5 * ((double)(p[1][0] - p[0][0]) * (double)(p[2][1] - p[0][1]) -
	              (double)(p[1][1] - p[0][1]) * (double)(p[2][0] - p[0][0]));
}

static double own_area(const made_mesh *made, uint32_t t)
{
	double e[2][3], square = 0.0;
	for (int i = 0; i < 2; i++)
		for (int k = 0; k < 3; k++)
			e[i][k] = (double)made->positions[made->indices[3 * t + (uint32_t)i + 1]][k] -
			          (double)made->positions[made->indices[3 * t]][k];
	for (int k = 0; k < 3; k++) {
		double n = e[0][(k + 1) % 3] * e[1][(k + 2) % 3] - e[0][(k + 2) % 3] * e[1][(k + 1) % 3];
		square += n * n;
	}
	return 0.5 * sqrt(square);
}

/* True if the place is inside the triangle's map, by more than a little. */
static bool covers(const stilb_bake_uv *uv, uint32_t t, double x, double y)
{
	const float(*p)[2] = (const float(*)[2]) & uv->corners[3 * (size_t)t];
	for (int i = 0; i < 3; i++) {
		double ax = (double)p[i][0], ay = (double)p[i][1], bx = (double)p[(i + 1) % 3][0] - ax,
			   by = (double)p[(i + 1) % 3][1] - ay;
		if (bx * (y - ay) - by * (x - ax) <= 1e-4 * hypot(bx, by) * hypot(bx, by))
			return false;
	}
	return true;
}

#define RASTER 256

/* No place of a raster over the chart is covered twice. Found by all triangles, without the code that is tested. */
static void assert_covered_once(const stilb_bake_uv *uv, const stilb_bake_chart *chart)
{
	static uint32_t owner[RASTER][RASTER];
	memset(owner, 0xff, sizeof owner);
	double step = (double)chart->width / RASTER;
	for (uint32_t i = chart->first; i < chart->first + chart->count; i++) {
		uint32_t t = uv->triangles[i];
		const float(*p)[2] = (const float(*)[2]) & uv->corners[3 * (size_t)t];
		double low[2], high[2];
		for (int k = 0; k < 2; k++) {
			low[k] = (double)fminf(fminf(p[0][k], p[1][k]), p[2][k]) / step;
			high[k] = (double)fmaxf(fmaxf(p[0][k], p[1][k]), p[2][k]) / step;
		}
		for (uint32_t y = (uint32_t)low[1]; (double)y < high[1] && y < RASTER; y++)
			for (uint32_t x = (uint32_t)low[0]; (double)x < high[0] && x < RASTER; x++) {
				if (!covers(uv, t, ((double)x + 0.5) * step, ((double)y + 0.5) * step))
					continue;
				if (owner[y][x] != UINT32_MAX)
					fail_msg("triangles %u and %u have the same place", owner[y][x], t);
				owner[y][x] = t;
			}
	}
}

static void assert_sound(const made_mesh *made, const stilb_bake_uv *uv)
{
	uint32_t with = 0, end = 0;
	assert_int_equal(uv->triangle_count, made->mesh.triangle_count);
	for (uint32_t t = 0; t < uv->triangle_count; t++)
		with += uv->chart[t] != STILB_BAKE_NO_CHART;
	assert_int_equal(with + uv->flat + uv->invalid, uv->triangle_count);
	for (uint32_t c = 0; c < uv->chart_count; c++) {
		const stilb_bake_chart *chart = &uv->charts[c];
		double map = 0.0, own = 0.0;
		assert_true(chart->count > 0 && chart->width >= chart->height && chart->height > 0.0f);
		for (uint32_t i = chart->first; i < chart->first + chart->count; i++) {
			uint32_t t = uv->triangles[i];
			assert_int_equal(uv->chart[t], c);
			assert_true(uv_area(uv, t) > 0.0);
			map += uv_area(uv, t);
			own += own_area(made, t);
			for (int k = 0; k < 3; k++) {
				const float *at = uv->corners[3 * (size_t)t + (size_t)k];
				assert_true(at[0] >= 0.0f && at[0] <= chart->width && at[1] >= 0.0f && at[1] <= chart->height);
			}
		}
		assert_true(fabs(map / own - 1.0) < 1e-3);
		assert_covered_once(uv, chart);
		end += chart->count;
	}
	assert_int_equal(end, with);
}

/* Unwraps, and asserts what always holds, and these bounds. */
static void assert_unwraps(made_mesh made, double stretch, uint32_t charts)
{
	stilb_bake_uv uv = unwrapped(&made);
	assert_sound(&made, &uv);
	double found = stilb_bake_stretch(&made.mesh, &uv);
	if (found > stretch || uv.chart_count > charts)
		fail_msg("stretch %.4f in %u charts; at most %.4f and %u", found, uv.chart_count, stretch, charts);
	assert_true(found > 1.0 - 1e-5);
	stilb_bake_uv_finish(&uv);
	made_finish(&made);
}

/* ---- shapes ------------------------------------------------------------------------------------------------------ */

static void test_a_cube_is_six_squares(void **state)
{
	(void)state;
	made_mesh made = made_cube();
	stilb_bake_uv uv = unwrapped(&made);
	assert_sound(&made, &uv);
	assert_int_equal(uv.chart_count, 6);
	for (uint32_t c = 0; c < 6; c++) {
		assert_float_equal(uv.charts[c].width, 1.0f, 1e-6f);
		assert_float_equal(uv.charts[c].height, 1.0f, 1e-6f);
	}
	assert_true(fabs(stilb_bake_stretch(&made.mesh, &uv) - 1.0) < 1e-6);
	stilb_bake_uv_finish(&uv);
	made_finish(&made);
}

static void test_a_cylinder_unrolls(void **state)
{
	(void)state;
	assert_unwraps(made_grid(64, 12, made_place_cylinder), 1.002, 5);
}

static void test_round_shapes(void **state)
{
	(void)state;
	assert_unwraps(made_grid(48, 24, made_place_sphere), 1.06, 14);
	assert_unwraps(made_grid(96, 32, made_place_torus), 1.06, 24);
}

/* Made after the bounds of the others were found. */
static void test_land(void **state)
{
	(void)state;
	assert_unwraps(made_grid(80, 80, made_place_land), 1.08, 20);
}

/* A conformal map keeps angles: the annulus of a cone, cut open, is part of a ring, whose stretch is 1. */
static void place_cone(float s, float t, float p[3])
{
	float a = 1.8f * s, r = 0.4f + t;
	made_set(p, r * cosf(a), 0.5f * r, -r * sinf(a));
}

static void test_a_cone_is_a_sector(void **state)
{
	(void)state;
	assert_unwraps(made_grid(24, 16, place_cone), 1.001, 1);
}

/* ---- a strip that winds over itself ------------------------------------------------------------------------------ */

/* A spiral stair without steps: two turns, normals nearly up, so that it grows as one chart, and seen from above it
 * covers itself. */
static void place_spiral(float s, float t, float p[3])
{
	float a = 4.0f * MADE_PI * s, r = 1.0f + t;
	made_set(p, r * cosf(a), 0.3f * a, -r * sinf(a));
}

static void test_what_covers_itself_is_cut(void **state)
{
	(void)state;
	made_mesh made = made_grid(96, 4, place_spiral);
	stilb_bake_uv uv = unwrapped(&made);
	assert_sound(&made, &uv);
	assert_true(uv.chart_count > 1);
	stilb_bake_uv_finish(&uv);
	made_finish(&made);
}

/* Overhanging waves, with a cone of nearly half a circle: what grows together has triangles that no plane shows all of
 * the right way round. */
static void place_waves(float s, float t, float p[3])
{
	float a = 12.0f * s;
	made_set(p, 2.0f * s + 0.5f * sinf(2.0f * a) + 0.1f * sinf(9.0f * t), 0.6f * cosf(a) + 0.3f * sinf(7.0f * t),
	         -2.0f * t);
}

static void test_what_turns_over_is_cut(void **state)
{
	(void)state;
	made_mesh made = made_grid(40, 30, place_waves);
	stilb_bake_uv uv;
	stilb_bake_unwrap_options options = {.cone = 1.56f, .crease = 3.1f};
	assert_int_equal(stilb_bake_unwrap(&made.mesh, &options, pool, 0, &uv), STILB_OK);
	assert_sound(&made, &uv);
	stilb_bake_uv_finish(&uv);
	made_finish(&made);
}

static void place_flat(float s, float t, float p[3])
{
	made_set(p, s, 0.0f, -t);
}

/* A square of 4 x 4 whose middle vertex leaves its neighbours' reach: the border stays as it is, and triangles turn
 * over. One that only moves is fine. */
static void test_a_fold_inside_is_no_map(void **state)
{
	(void)state;
	made_mesh made = made_grid(4, 4, place_flat);
	bake_topology topology;
	bake_patch patch;
	uint32_t triangles[32], chart[32] = {0}, local[32];
	bool good;
	for (uint32_t t = 0; t < 32; t++)
		triangles[t] = t;
	assert_int_equal(bake_topology_create(&made.mesh, &topology), STILB_OK);
	assert_int_equal(bake_patch_begin(&topology, triangles, 32, chart, local, &patch), STILB_OK);
	assert_int_equal(patch.vertex_count, 25);
	assert_int_equal(patch.border_count, 16);
	bake_patch_project(&patch);
	assert_true(patch.level);
	static const double moves[3] = {0.0, 0.1, 0.4};
	for (int i = 0; i < 3; i++) {
		for (uint32_t v = 0; v < 25; v++) {
			const double *place = topology.place[patch.place_of[v]];
			if (fabs(place[0] - 0.5) < 1e-6 && fabs(place[2] + 0.5) < 1e-6)
				patch.at[v][0] += moves[i];
		}
		assert_int_equal(bake_patch_is_good(&patch, &good), STILB_OK);
		assert_int_equal(good, i < 2);
	}
	bake_patch_finish(&patch);
	bake_topology_finish(&topology);
	made_finish(&made);
}

/* ---- broken meshes ----------------------------------------------------------------------------------------------- */

static void test_broken_triangles_get_no_chart(void **state)
{
	(void)state;
	made_mesh made = made_empty(8, 7);
	made_set(made.positions[1], 1.0f, 0.0f, 0.0f);
	made_set(made.positions[2], 0.0f, 1.0f, 0.0f);
	made_set(made.positions[3], NAN, 1.0f, 0.0f);
	made_set(made.positions[4], 0.0f, INFINITY, 0.0f);
	made_set(made.positions[5], 0.0f, 0.0f, 3e10f);
	made_set(made.positions[6], 2.0f, 0.0f, 0.0f);
	made_set(made.positions[7], 1.0f, 1e-9f, 0.0f);
	const uint32_t indices[21] = {0, 1, 2, 0, 1, 3, 0, 1, 4, 0, 1, 5, 0, 1, 99, 0, 6, 7, 0, 0, 1};
	memcpy(made.indices, indices, sizeof indices);
	stilb_bake_uv uv = unwrapped(&made);
	assert_sound(&made, &uv);
	assert_int_equal(uv.invalid, 4);
	assert_int_equal(uv.flat, 2);
	assert_int_equal(uv.chart_count, 1);
	stilb_bake_uv_finish(&uv);
	made_finish(&made);
}

/* Three leaves of a book, a leaf there twice, and one that is turned over: each has a place of its own. */
/* A hundred thousand vertices that are nowhere: no two of them are the same, which is found without looking at all. */
static void test_many_vertices_are_nowhere(void **state)
{
	(void)state;
	made_mesh made = made_empty(100000, 100000);
	for (uint32_t v = 0; v < 100000; v++)
		made_set(made.positions[v], NAN, 0.0f, 0.0f);
	for (uint32_t i = 0; i < 300000; i++)
		made.indices[i] = i % 100000;
	stilb_bake_uv uv = unwrapped(&made);
	assert_int_equal(uv.invalid, 100000);
	assert_int_equal(uv.chart_count, 0);
	stilb_bake_uv_finish(&uv);
	made_finish(&made);
}

/* A flat star of 20,000 rays: sides of its border are as long as it is, and there is no room to look at all pairs. */
static void test_a_star(void **state)
{
	(void)state;
	enum { RAYS = 20000, CORNERS = 2 * RAYS };
	made_mesh made = made_empty(CORNERS + 1, CORNERS);
	for (uint32_t v = 0; v < CORNERS; v++) {
		double angle = 2.0 * M_PI * v / CORNERS, radius = v % 2 ? 1.0 : 0.01;
		made_set(made.positions[v + 1], (float)(radius * cos(angle)), (float)(radius * sin(angle)), 0.0f);
		made.indices[3 * v] = 0;
		made.indices[3 * v + 1] = v + 1;
		made.indices[3 * v + 2] = (v + 1) % CORNERS + 1;
	}
	stilb_bake_uv uv = unwrapped(&made);
	assert_int_equal(uv.invalid + uv.flat, 0);
	for (uint32_t t = 0; t < CORNERS; t++)
		assert_true(uv.chart[t] < uv.chart_count);
	assert_in_range(uv.chart_count, 2, RAYS);
	stilb_bake_uv_finish(&uv);
	made_finish(&made);
}

static void test_odd_edges_end_charts(void **state)
{
	(void)state;
	made_mesh made = made_empty(5, 6);
	made_set(made.positions[1], 0.0f, 1.0f, 0.0f);
	made_set(made.positions[2], 1.0f, 0.0f, 0.0f);
	made_set(made.positions[3], -1.0f, 0.0f, 0.1f);
	made_set(made.positions[4], 0.9f, 0.0f, 0.2f);
	const uint32_t indices[18] = {0, 1, 2, 1, 0, 3, 0, 1, 4, 0, 1, 2, 0, 2, 1, 1, 0, 3};
	memcpy(made.indices, indices, sizeof indices);
	stilb_bake_uv uv = unwrapped(&made);
	assert_sound(&made, &uv);
	assert_int_equal(uv.flat + uv.invalid, 0);
	assert_true(uv.odd_edges > 0);
	assert_int_equal(uv.chart_count, 6);
	stilb_bake_uv_finish(&uv);
	made_finish(&made);
}

static void test_nothing_and_one(void **state)
{
	(void)state;
	made_mesh made = made_empty(3, 0);
	stilb_bake_uv uv = unwrapped(&made);
	assert_int_equal(uv.chart_count, 0);
	assert_true(stilb_bake_stretch(&made.mesh, &uv) >= 1.0);
	stilb_bake_uv_finish(&uv);
	made_finish(&made);
	made = made_empty(3, 1);
	made_set(made.positions[1], 1e-12f, 0.0f, 1e-13f);
	made_set(made.positions[2], 0.0f, 2e-12f, 0.0f);
	made.indices[1] = 1;
	made.indices[2] = 2;
	assert_unwraps(made, 1.0 + 1e-5, 1);
}

/* Triangles of all sizes anywhere, some of which share vertices by chance. */
static void test_soup(void **state)
{
	(void)state;
	uint64_t random = 7;
	made_mesh made = made_empty(60, 400);
	for (uint32_t v = 0; v < 60; v++)
		for (int k = 0; k < 3; k++)
			made.positions[v][k] = 2.0f * made_random(&random) - 1.0f;
	for (uint32_t i = 0; i < 1200; i++)
		made.indices[i] = (uint32_t)(60.0f * made_random(&random));
	stilb_bake_uv uv = unwrapped(&made);
	assert_sound(&made, &uv);
	stilb_bake_uv_finish(&uv);
	made_finish(&made);
}

/* ---- bits -------------------------------------------------------------------------------------------------------- */

static uint64_t bits_of(const made_mesh *made, uint32_t workers)
{
	stilb_job_pool *own = made_pool(workers);
	stilb_bake_uv uv;
	assert_int_equal(stilb_bake_unwrap(&made->mesh, NULL, own, 0, &uv), STILB_OK);
	uint64_t hash = stilb_hash_fnv1a64(STILB_FNV1A64_START, uv.corners, 3 * uv.triangle_count * sizeof *uv.corners);
	hash = stilb_hash_fnv1a64(hash, uv.chart, uv.triangle_count * sizeof *uv.chart);
	hash = stilb_hash_fnv1a64(hash, uv.charts, uv.chart_count * sizeof *uv.charts);
	stilb_bake_uv_finish(&uv);
	stilb_job_pool_destroy(own);
	return hash;
}

static void test_the_same_bits_for_any_workers(void **state)
{
	(void)state;
	made_mesh made = TEST_TSAN ? made_grid(24, 12, made_place_torus) : made_grid(96, 4, place_spiral);
	uint64_t alone = bits_of(&made, 0);
	assert_true(alone == bits_of(&made, 1));
	assert_true(alone == bits_of(&made, 3));
	made_finish(&made);
}

static int begin(void **state)
{
	(void)state;
	pool = made_pool(1);
	return 0;
}

static int end(void **state)
{
	(void)state;
	stilb_job_pool_destroy(pool);
	return 0;
}

int main(void)
{
	static const struct CMUnitTest tests[] = {
		test_one_thread(test_a_cube_is_six_squares),
		test_one_thread(test_a_cylinder_unrolls),
		test_one_thread(test_round_shapes),
		test_one_thread(test_land),
		test_one_thread(test_a_cone_is_a_sector),
		test_one_thread(test_what_covers_itself_is_cut),
		test_one_thread(test_what_turns_over_is_cut),
		test_one_thread(test_a_fold_inside_is_no_map),
		test_one_thread(test_broken_triangles_get_no_chart),
		test_one_thread(test_many_vertices_are_nowhere),
		test_one_thread(test_a_star),
		test_one_thread(test_odd_edges_end_charts),
		test_one_thread(test_nothing_and_one),
		test_one_thread(test_soup),
		cmocka_unit_test(test_the_same_bits_for_any_workers),
	};
	return cmocka_run_group_tests(tests, begin, end);
}
