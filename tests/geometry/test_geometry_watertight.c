/* Levels of closed meshes are closed: each edge of positions has two triangles that run against each other, and from
 * any side as many triangles face the viewer at a pixel as look away, for every level, and half-way between it and the
 * finer one. Also where several regions, seams and facets meet. */
#include "support/test.h"

#include "geometry/geometry_internal.h"
#include "geometry/geometry_levels.h"
#include "geometry/mesh_made.h"

#define SIDE 48     /* pixels */
#define STEPS 256   /* to which positions are rounded, of a pixel */
#define RADIUS 22.0 /* pixels: of the mesh */

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

typedef struct picture {
	int32_t winding[SIDE * SIDE]; /* triangles that face the viewer, less those that look away */
	uint32_t facing[SIDE * SIDE]; /* the former */
} picture;

typedef struct point2 {
	int64_t x, y;
} point2;

/* Positive on one side of an edge, and 0 on it counts for one of its two triangles. */
static bool is_inside(point2 a, point2 b, int64_t x, int64_t y)
{
	int64_t side = (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
	return side > 0 || (side == 0 && (a.y > b.y || (a.y == b.y && a.x < b.x)));
}

static int64_t clamp(int64_t value)
{
	return value < 0 ? 0 : value > SIDE - 1 ? SIDE - 1 : value;
}

static void draw(picture *out, point2 a, point2 b, point2 c)
{
	int64_t area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
	if (area == 0)
		return;
	if (area < 0) {
		point2 other = b;
		b = c;
		c = other;
	}
	int64_t left = a.x < b.x ? a.x : b.x, right = a.x > b.x ? a.x : b.x;
	int64_t low = a.y < b.y ? a.y : b.y, high = a.y > b.y ? a.y : b.y;
	left = clamp((left < c.x ? left : c.x) / STEPS);
	right = clamp((right > c.x ? right : c.x) / STEPS);
	low = clamp((low < c.y ? low : c.y) / STEPS);
	high = clamp((high > c.y ? high : c.y) / STEPS);
	for (int64_t j = low; j <= high; j++)
		for (int64_t i = left; i <= right; i++) {
			int64_t x = i * STEPS + STEPS / 2, y = j * STEPS + STEPS / 2;
			if (!is_inside(a, b, x, y) || !is_inside(b, c, x, y) || !is_inside(c, a, x, y))
				continue;
			out->winding[j * SIDE + i] += area > 0 ? 1 : -1;
			out->facing[j * SIDE + i] += area > 0;
		}
}

/* Two axes across a direction that is drawn by lot. */
static void draw_lots(uint64_t view, stilb_vec3 axes[2])
{
	float z = 2.0f * stilb_random_float(11, 3 * view) - 1.0f, turn = 6.2831853f * stilb_random_float(11, 3 * view + 1);
	float roll = 6.2831853f * stilb_random_float(11, 3 * view + 2), r = sqrtf(1.0f - z * z);
	stilb_vec3 x = stilb_vec3_make(-sinf(turn), cosf(turn), 0.0f);
	stilb_vec3 y = stilb_vec3_cross(stilb_vec3_make(r * cosf(turn), r * sinf(turn), z), x);
	axes[0] = x * cosf(roll) + y * sinf(roll);
	axes[1] = y * cosf(roll) - x * sinf(roll);
}

/* Where the vertices are: those from `fixed` on half-way to their morphs. */
static void project(const stilb_scene_mesh *mesh, uint32_t fixed, float radius, const stilb_vec3 axes[2], point2 *out)
{
	for (uint32_t v = 0; v < mesh->vertex_count; v++) {
		const float *p = mesh->vertices[v].position, *q = v < fixed ? p : mesh->morph[v].position;
		stilb_vec3 at = stilb_vec3_make(p[0] + q[0], p[1] + q[1], p[2] + q[2]) * 0.5f;
		double scale = RADIUS * STEPS / (double)radius;
		out[v].x = SIDE * STEPS / 2 + (int64_t)floor((double)stilb_vec3_dot(at, axes[0]) * scale);
		out[v].y = SIDE * STEPS / 2 + (int64_t)floor((double)stilb_vec3_dot(at, axes[1]) * scale);
	}
}

/* Draws one level as it is seen along a direction; returns the pixels that it covers, and in *holes those that it has a
 * hole at. */
static uint32_t look_at(const stilb_scene_mesh *mesh, uint32_t level, const point2 *points, uint32_t *holes)
{
	static picture out;
	out = (picture){0};
	const uint32_t *indices = level > 0 ? mesh->level_indices + mesh->levels[level - 1].first_index : mesh->indices;
	uint32_t count = level > 0 ? mesh->levels[level - 1].index_count : mesh->index_count, covered = 0;
	for (uint32_t i = 0; i < count; i += 3)
		draw(&out, points[indices[i]], points[indices[i + 1]], points[indices[i + 2]]);
	*holes = 0;
	for (uint32_t i = 0; i < SIDE * SIDE; i++) {
		covered += out.facing[i] > 0;
		*holes += out.winding[i] != 0;
	}
	return covered;
}

/* ---- checks ------------------------------------------------------------------------------------------------------ */

static void check_views(const stilb_scene_mesh *mesh, uint32_t views)
{
	float radius = 0.0f;
	point2 *points = malloc(sizeof *points * mesh->vertex_count);
	assert_non_null(points);
	for (uint32_t v = 0; v < mesh->vertex_count; v++) {
		const float *p = mesh->vertices[v].position;
		radius = fmaxf(radius, sqrtf(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]));
	}
	for (uint32_t view = 0; view < views; view++) {
		stilb_vec3 axes[2];
		draw_lots(view, axes);
		for (uint32_t level = 0; level <= mesh->level_count; level++) {
			uint32_t holes, vertices = mesh->vertex_count;
			project(mesh, vertices, radius, axes, points);
			uint32_t covered = look_at(mesh, level, points, &holes);
			assert_int_equal(holes, 0);
			assert_in_range(covered, 200, SIDE * SIDE);
			if (level == mesh->level_count)
				continue;
			project(mesh, mesh->levels[level].vertex_count, radius, axes, points);
			look_at(mesh, level, points, &holes);
			assert_int_equal(holes, 0);
		}
	}
	free(points);
}

static void check(stilb_scene_mesh *mesh, int euler, uint32_t least, uint32_t views)
{
	stilb_geometry_levels_desc desc = stilb_geometry_levels_desc_default();
	assert_int_equal(stilb_geometry_levels(mesh, &desc, NULL, 0), STILB_OK);
	assert_in_range(mesh->level_count, least, STILB_SCENE_MAX_LEVELS);
	uint32_t *canonical = malloc(sizeof *canonical * mesh->vertex_count);
	assert_non_null(canonical);
	stilb_geometry_mesh view = {.vertex_count = mesh->vertex_count,
	                            .positions = mesh->vertices->position,
	                            .position_stride = sizeof *mesh->vertices};
	assert_true(geometry_weld(&view, NULL, 0, canonical));
	for (uint32_t l = 0, finer = mesh->index_count / 3; l < mesh->level_count; l++) {
		const stilb_scene_level *level = &mesh->levels[l];
		if (finer > 500) /* two triangles go at a time, and where there are many, as many as wanted */
			assert_in_range(level->index_count / 3, finer / 2 - 1, finer / 2);
		finer = level->index_count / 3;
		mesh_shape shape = mesh_shape_of(mesh, canonical, mesh->level_indices + level->first_index, level->index_count);
		assert_int_equal(shape.border, 0);
		assert_int_equal(shape.odd, 0);
		assert_int_equal(shape.euler, euler);
	}
	free(canonical);
	check_views(mesh, TEST_ASAN ? views / 20 : views);
	stilb_scene_mesh_finish(mesh);
}

/* Seams of the texture at two circles; 1,000 views. */
static void test_torus(void **state)
{
	(void)state;
	stilb_scene_mesh mesh = mesh_grid(40, 20, mesh_place_torus);
	check(&mesh, 0, 5, 1000);
}

static void test_facets(void **state)
{
	(void)state;
	stilb_scene_mesh sphere, mesh;
	assert_int_equal(stilb_scene_mesh_sphere(3, &sphere), STILB_OK);
	mesh = mesh_facets(&sphere);
	stilb_scene_mesh_finish(&sphere);
	check(&mesh, 2, 4, 200);
}

/* Three regions. */
static void test_regions(void **state)
{
	(void)state;
	stilb_scene_mesh mesh;
	assert_int_equal(stilb_scene_mesh_sphere(5, &mesh), STILB_OK);
	check(&mesh, 2, 8, 20);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_torus),
		cmocka_unit_test(test_facets),
		cmocka_unit_test(test_regions),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
