/* Meshes that are cut at the bounds of lights (geometry_lights.h): the surface stays the same, point by point, no piece
 * has more lights than it must, edges have one vertex, and bad input is refused. */
#include "geometry/geometry_lights.h"

#include "support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LAMPS 18u

/* A floor of `side` x `side` squares, x and z in [0, 12], whose uv and colours are linear in x and z. */
static stilb_scene_mesh floor_made(uint32_t side)
{
	uint32_t row = side + 1;
	stilb_scene_mesh mesh = {.vertex_count = row * row, .index_count = 6 * side * side};
	mesh.vertices = calloc(mesh.vertex_count, sizeof *mesh.vertices);
	mesh.extras = calloc(mesh.vertex_count, sizeof *mesh.extras);
	mesh.indices = calloc(mesh.index_count, sizeof *mesh.indices);
	assert_true(mesh.vertices && mesh.extras && mesh.indices);
	for (uint32_t v = 0; v < mesh.vertex_count; v++) {
		float u = (float)(v % row) / (float)side, w = (float)(v / row) / (float)side;
		mesh.vertices[v] = (stilb_scene_vertex){.position = {12 * u, 0, 12 * w}, .normal = {0, 1, 0}, .uv = {u, w}};
		mesh.extras[v] =
			(stilb_scene_vertex_extra){.tangent = {1, 0, 0, -1}, .uv = {w, 2 * u}, .color = {u, w, 1 - u, 1}};
	}
	uint32_t *out = mesh.indices;
	for (uint32_t z = 0; z < side; z++)
		for (uint32_t x = 0; x < side; x++) {
			uint32_t a = z * row + x, square[6] = {a, a + row, a + row + 1, a, a + row + 1, a + 1};
			memcpy(out, square, sizeof square);
			out += 6;
		}
	return mesh;
}

static void lamps_made(stilb_sphere lamps[LAMPS], float reach)
{
	for (uint32_t l = 0; l < LAMPS; l++)
		lamps[l] =
			(stilb_sphere){12 * stilb_random_float(5, 2 * l), 1.0f, 12 * stilb_random_float(5, 2 * l + 1), reach};
}

/* Twice the area of a triangle seen from above, where it holds the point; else 0. */
static double holds(const stilb_scene_mesh *mesh, uint32_t triangle, double x, double z, double weights[3])
{
	double p[3][2], area = 0.0;
	for (int i = 0; i < 3; i++) {
		const float *at = mesh->vertices[mesh->indices[3 * triangle + (uint32_t)i]].position;
		p[i][0] = (double)at[0];
		p[i][1] = (double)at[2];
	}
	bool inside = true;
	for (int i = 0; i < 3; i++) {
		const double *a = p[(i + 1) % 3], *b = p[(i + 2) % 3];
		weights[i] = (b[0] - a[0]) * (z - a[1]) - (b[1] - a[1]) * (x - a[0]);
		area += weights[i];
	}
	for (int i = 0; i < 3; i++) {
		weights[i] /= area;
		inside &= weights[i] > 0.0;
	}
	return inside ? fabs(area) : 0.0;
}

static double area_of(const stilb_scene_mesh *mesh)
{
	double sum = 0.0;
	for (uint32_t i = 0; i < mesh->index_count; i += 3) {
		double e[2][3];
		for (int k = 0; k < 3; k++)
			for (int s = 0; s < 2; s++)
				e[s][k] = (double)mesh->vertices[mesh->indices[i + 1 + (uint32_t)s]].position[k] -
				          (double)mesh->vertices[mesh->indices[i]].position[k];
		double x = e[0][1] * e[1][2] - e[0][2] * e[1][1], y = e[0][2] * e[1][0] - e[0][0] * e[1][2];
		double z = e[0][0] * e[1][1] - e[0][1] * e[1][0];
		sum += sqrt(x * x + y * y + z * z) / 2.0;
	}
	return sum;
}

/* So many lights touch the box of a piece. */
static uint32_t reaching(const stilb_scene_mesh *mesh, const stilb_sphere *lamps)
{
	double low[3] = {1e30, 1e30, 1e30}, high[3] = {-1e30, -1e30, -1e30};
	for (uint32_t v = 0; v < mesh->vertex_count; v++)
		for (int k = 0; k < 3; k++) {
			low[k] = fmin(low[k], (double)mesh->vertices[v].position[k]);
			high[k] = fmax(high[k], (double)mesh->vertices[v].position[k]);
		}
	uint32_t count = 0;
	for (uint32_t l = 0; l < LAMPS; l++) {
		const double center[3] = {(double)lamps[l].x, (double)lamps[l].y, (double)lamps[l].z};
		double square = 0.0;
		for (int k = 0; k < 3; k++)
			square += pow(center[k] - fmin(fmax(center[k], low[k]), high[k]), 2.0);
		count += square < pow((double)lamps[l].radius, 2.0);
	}
	return count;
}

static stilb_geometry_pieces cut(const stilb_scene_mesh *mesh, const stilb_sphere *lamps, uint32_t enough, float least)
{
	stilb_geometry_pieces pieces;
	stilb_geometry_lights_desc desc = {.lights = lamps, .light_count = LAMPS, .enough = enough, .least = least};
	if (stilb_geometry_cut_at_lights(mesh, &desc, &pieces) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return pieces;
}

/* Every point of the floor is in one triangle of one piece, which has the uv and colour of the place. */
static void the_floor_stays_the_floor(void **state)
{
	(void)state;
	stilb_sphere lamps[LAMPS];
	lamps_made(lamps, 3.0f);
	for (uint32_t side = 1; side <= 7; side += 3) {
		stilb_scene_mesh mesh = floor_made(side);
		stilb_geometry_pieces pieces = cut(&mesh, lamps, 4, 0.25f);
		assert_true(pieces.count > 8);
		double area = 0.0;
		uint32_t triangles = 0;
		for (uint32_t p = 0; p < pieces.count; p++) {
			area += area_of(&pieces.meshes[p]);
			triangles += pieces.meshes[p].index_count / 3;
		}
		assert_true(fabs(area - 144.0) < 1e-4);
		assert_int_equal(triangles, pieces.triangles);
		for (uint32_t i = 0; i < 300; i++) {
			double x = 12.0 * (double)stilb_random_float(9, 2 * i), z = 12.0 * (double)stilb_random_float(9, 2 * i + 1);
			uint32_t found = 0;
			for (uint32_t p = 0; p < pieces.count; p++)
				for (uint32_t t = 0; t < pieces.meshes[p].index_count / 3; t++) {
					const stilb_scene_mesh *m = &pieces.meshes[p];
					double weights[3], u = 0.0, color = 0.0, second = 0.0;
					if (!(holds(m, t, x, z, weights) > 0.0))
						continue;
					found++;
					for (int k = 0; k < 3; k++) {
						uint32_t v = m->indices[3 * t + (uint32_t)k];
						u += weights[k] * (double)m->vertices[v].uv[0];
						second += weights[k] * (double)m->extras[v].uv[1];
						color += weights[k] * (double)m->extras[v].color[1];
						assert_true(m->extras[v].tangent[0] == 1.0f && m->extras[v].tangent[3] == -1.0f);
						assert_true(m->vertices[v].normal[1] == 1.0f);
					}
					assert_true(fabs(u - x / 12.0) < 1e-5 && fabs(second - x / 6.0) < 1e-5);
					assert_true(fabs(color - z / 12.0) < 1e-5);
				}
			if (found != 1)
				fail_msg("%.4f, %.4f is in %u triangles", x, z, found);
		}
		stilb_geometry_pieces_finish(&pieces);
		stilb_scene_mesh_finish(&mesh);
	}
}

/* Lamps far from each other: each piece has at most one. Where more lamps than enough reach a point there are more. */
static void few_lights_at_a_piece(void **state)
{
	(void)state;
	stilb_sphere lamps[LAMPS];
	for (uint32_t l = 0; l < LAMPS; l++)
		lamps[l] = (stilb_sphere){1.0f + 2.1f * (float)(l % 6), 0.4f, 1.0f + 4.0f * (float)(l / 6), 1.0f};
	stilb_scene_mesh mesh = floor_made(1);
	stilb_geometry_pieces pieces = cut(&mesh, lamps, 1, 0.05f);
	uint32_t most = 0;
	for (uint32_t p = 0; p < pieces.count; p++)
		most = reaching(&pieces.meshes[p], lamps) > most ? reaching(&pieces.meshes[p], lamps) : most;
	assert_int_equal(most, 1);
	assert_int_equal(pieces.most, 1);
	stilb_geometry_pieces_finish(&pieces);
	lamps_made(lamps, 3.0f);
	uint32_t counts[2];
	for (int few = 0; few < 2; few++) {
		pieces = cut(&mesh, lamps, few ? 4 : LAMPS, 0.25f);
		counts[few] = pieces.count;
		uint32_t here = 0;
		for (uint32_t p = 0; p < pieces.count; p++)
			here = reaching(&pieces.meshes[p], lamps) > here ? reaching(&pieces.meshes[p], lamps) : here;
		assert_int_equal(here, pieces.most);
		assert_true(few ? here < LAMPS / 2 : here == LAMPS);
		stilb_geometry_pieces_finish(&pieces);
	}
	assert_int_equal(counts[0], 1);
	assert_true(counts[1] > 8);
	stilb_scene_mesh_finish(&mesh);
}

/* Of a ball the parts are as large as the whole, and an edge that is cut has the same point on both sides: each edge of
 * the pieces of one cut, but for the plane's, is there in both directions. */
static void edges_have_one_vertex(void **state)
{
	(void)state;
	stilb_scene_mesh ball;
	assert_int_equal(stilb_scene_mesh_sphere(3, &ball), STILB_OK);
	stilb_sphere lamps[LAMPS];
	memset(lamps, 0, sizeof lamps);
	lamps[0] = (stilb_sphere){1.13f, 0.0f, 0.0f, 1.0f};
	for (uint32_t l = 1; l < LAMPS; l++)
		lamps[l].radius = -1.0f;
	stilb_geometry_pieces pieces = cut(&ball, lamps, 0, 0.2f);
	double area = 0.0;
	uint32_t alone = 0, in_plane = 0;
	assert_int_equal(pieces.count, 2);
	for (uint32_t p = 0; p < pieces.count; p++) {
		const stilb_scene_mesh *m = &pieces.meshes[p];
		area += area_of(m);
		for (uint32_t i = 0; i < m->index_count; i++) {
			uint32_t a = m->indices[i], b = m->indices[i % 3 == 2 ? i - 2 : i + 1];
			bool both = false;
			for (uint32_t j = 0; j < m->index_count; j++)
				both |= m->indices[j] == b && m->indices[j % 3 == 2 ? j - 2 : j + 1] == a;
			bool cut_here =
				fabsf(m->vertices[a].position[0] - 0.13f) < 1e-6f && fabsf(m->vertices[b].position[0] - 0.13f) < 1e-6f;
			in_plane += !both && cut_here;
			alone += !both && !cut_here;
		}
		for (uint32_t v = 0; v < m->vertex_count; v++) {
			const float *n = m->vertices[v].normal;
			assert_true(fabsf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1.0f) < 1e-5f);
		}
	}
	/* u jumps at one meridian, where vertices are not shared: its edges are open in the ball itself. */
	uint32_t open = 0;
	for (uint32_t i = 0; i < ball.index_count; i++) {
		uint32_t a = ball.indices[i], b = ball.indices[i % 3 == 2 ? i - 2 : i + 1];
		bool both = false;
		for (uint32_t j = 0; j < ball.index_count; j++)
			both |= ball.indices[j] == b && ball.indices[j % 3 == 2 ? j - 2 : j + 1] == a;
		open += !both;
	}
	assert_int_equal(alone, open);
	assert_true(in_plane > 20 && in_plane % 2 == 0);
	assert_true(fabs(area - area_of(&ball)) < 1e-4);
	stilb_geometry_pieces_finish(&pieces);
	stilb_scene_mesh_finish(&ball);
}

static void bad_input(void **state)
{
	(void)state;
	stilb_scene_mesh mesh = floor_made(1);
	stilb_geometry_pieces pieces;
	stilb_geometry_lights_desc desc = {.enough = 4};
	assert_int_equal(stilb_geometry_cut_at_lights(&mesh, &desc, &pieces), STILB_ERROR_ARGUMENT);
	desc.least = NAN;
	assert_int_equal(stilb_geometry_cut_at_lights(&mesh, &desc, &pieces), STILB_ERROR_ARGUMENT);
	desc.least = 1.0f;
	mesh.indices[2] = 4;
	assert_int_equal(stilb_geometry_cut_at_lights(&mesh, &desc, &pieces), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "index 2 is 4"));
	mesh.indices[2] = 3;
	mesh.vertices[1].position[1] = INFINITY;
	assert_int_equal(stilb_geometry_cut_at_lights(&mesh, &desc, &pieces), STILB_ERROR_ARGUMENT);
	assert_true(pieces.count == 0 && !pieces.meshes);
	mesh.vertices[1].position[1] = 0.0f;
	assert_int_equal(stilb_geometry_cut_at_lights(&mesh, &desc, &pieces), STILB_OK); /* no lights: one piece */
	assert_int_equal(pieces.count, 1);
	stilb_geometry_pieces_finish(&pieces);
	stilb_geometry_pieces_finish(&pieces);
	uint32_t count = mesh.index_count;
	mesh.index_count = 0;
	assert_int_equal(stilb_geometry_cut_at_lights(&mesh, &desc, &pieces), STILB_OK);
	assert_int_equal(pieces.count, 0);
	mesh.index_count = count;
	stilb_scene_mesh_finish(&mesh);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_floor_stays_the_floor),
		cmocka_unit_test(few_lights_at_a_piece),
		cmocka_unit_test(edges_have_one_vertex),
		cmocka_unit_test(bad_input),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
