/* shade_impostor.h: the octahedral map against its definition in double, three pictures whose blend is the direction
 * asked for, and plates. */
#include "shading/shade_impostor.h"
#include "support/shade_proof.h"

static stilb_vec3 direction_of(uint32_t i)
{
	float z = 2.0f * stilb_random_float(1, 2 * (uint64_t)i) - 1.0f;
	float a = 6.2831853f * stilb_random_float(1, 2 * (uint64_t)i + 1), r = sqrtf(1.0f - z * z);
	return stilb_vec3_normalize(stilb_vec3_make(r * cosf(a), r * sinf(a), z));
}

/* The point of the octahedron on the ray, and the lower half's mirrored at the line |x| + |y| = 1 of its quadrant. */
static void octahedral_in_double(stilb_vec3 n, double e[2])
{
	double x = (double)n[0], y = (double)n[1], z = (double)n[2], sum = fabs(x) + fabs(y) + fabs(z);
	e[0] = x / sum;
	e[1] = y / sum;
	if (z < 0.0) {
		double u = (1.0 - fabs(e[1])) * (x < 0.0 ? -1.0 : 1.0), v = (1.0 - fabs(e[0])) * (y < 0.0 ? -1.0 : 1.0);
		e[0] = u;
		e[1] = v;
	}
}

static void the_map_is_the_octahedron(void **state)
{
	(void)state;
	for (uint32_t i = 0; i < 2000; i++) {
		stilb_vec3 n = direction_of(i);
		double e[2];
		octahedral_in_double(n, e);
		stilb_vec2 found = shade_octahedral_from_direction(n);
		stilb_vec3 back = shade_direction_from_octahedral((stilb_vec2){(float)e[0], (float)e[1]});
		assert_float_equal(found[0], (float)e[0], 3e-7f);
		assert_float_equal(found[1], (float)e[1], 3e-7f);
		for (int c = 0; c < 3; c++)
			assert_float_equal(back[c], n[c], 1e-6f);
	}
}

/* The grid's corners, edges and middle are the axes. */
static void axes_are_corners(void **state)
{
	(void)state;
	static const float place[6][5] = {{1, 0.5f, 1, 0, 0},  {0, 0.5f, -1, 0, 0},   {0.5f, 1, 0, 1, 0},
	                                  {0.5f, 0, 0, -1, 0}, {0.5f, 0.5f, 0, 0, 1}, {1, 0, 0, 0, -1}};
	for (int i = 0; i < 6; i++) {
		stilb_vec3 n = shade_impostor_direction((stilb_vec2){8.0f * place[i][0], 8.0f * place[i][1]}, 9.0f);
		for (int c = 0; c < 3; c++)
			assert_float_equal(n[c], place[i][2 + c], 1e-7f);
	}
	/* A quarter of the way along an edge of the octahedron: (3, 1, 0) / sqrt(10). */
	stilb_vec3 n = shade_impostor_direction((stilb_vec2){7.0f, 5.0f}, 9.0f);
	assert_float_equal(n[0], 3.0f / sqrtf(10.0f), 1e-6f);
	assert_float_equal(n[1], 1.0f / sqrtf(10.0f), 1e-6f);
	assert_float_equal(n[2], 0.0f, 1e-6f);
}

/* Three corners of the grid, at most a step apart; the weights are those of the point between them. */
static void check_views(stilb_vec3 n, float grid)
{
	shade_impostor_views views = shade_impostor_views_of(n, grid);
	stilb_vec2 places[3] = {views.a, views.b, views.c};
	double e[2], sum = 0.0, at[2] = {0.0};
	octahedral_in_double(n, e);
	for (int v = 0; v < 3; v++) {
		assert_true(views.weights[v] >= -4e-6f && views.weights[v] <= 1.0f + 4e-6f);
		sum += (double)views.weights[v];
		for (int axis = 0; axis < 2; axis++) {
			assert_true(places[v][axis] >= 0.0f && places[v][axis] <= grid - 1.0f);
			assert_true(places[v][axis] == floorf(places[v][axis]));
			assert_true(fabsf(places[v][axis] - places[(v + 1) % 3][axis]) <= 1.0f);
			at[axis] += (double)views.weights[v] * (double)places[v][axis];
		}
	}
	assert_float_equal((float)sum, 1.0f, 1e-6f);
	for (int axis = 0; axis < 2; axis++)
		assert_float_equal((float)at[axis], (float)((e[axis] * 0.5 + 0.5) * ((double)grid - 1.0)), 1e-6f * grid);
}

static void three_views_blend_to_the_direction(void **state)
{
	(void)state;
	for (uint32_t i = 0; i < 4000; i++)
		check_views(direction_of(i), (float)(3 + 2 * (i % 16)));
	/* On and beside the corners, the edges and the diagonals of cells. */
	for (uint32_t i = 0; i < 4000; i++) {
		float x = (float)(i % 17) * 0.125f - 1.0f, y = (float)(i / 17 % 17) * 0.125f - 1.0f;
		float beside = 4e-4f * (stilb_random_float(2, i) - 0.5f);
		stilb_vec2 e = {fminf(fmaxf(x + beside, -1.0f), 1.0f), y};
		check_views(shade_direction_from_octahedral(e), 9.0f);
		check_views(shade_direction_from_octahedral((stilb_vec2){x, y}), 9.0f);
	}
}

/* No triangle crosses the octahedron's edges, where the map bends: directions of the corners stay on one face. */
static void triangles_stay_on_a_face(void **state)
{
	(void)state;
	for (uint32_t i = 0; i < 4000; i++) {
		stilb_vec3 n = direction_of(i);
		float grid = (float)(3 + 2 * (i % 8));
		shade_impostor_views views = shade_impostor_views_of(n, grid);
		stilb_vec2 places[3] = {views.a, views.b, views.c};
		for (int v = 0; v < 3; v++) {
			stilb_vec3 corner = shade_impostor_direction(places[v], grid);
			for (int c = 0; c < 3; c++)
				assert_true(fabsf(n[c]) < 1e-5f || corner[c] * n[c] > -1e-6f);
		}
	}
}

static void plates_have_a_margin(void **state)
{
	(void)state;
	for (float side = 4.0f; side < 70.0f; side += 11.0f) {
		stilb_vec2 right = shade_impostor_texel((stilb_vec2){1.0f, 1.0f}, side);
		stilb_vec2 left = shade_impostor_texel((stilb_vec2){-1.0f, -0.5f}, side);
		assert_float_equal(right[0], side - 1.0f, 1e-5f);
		assert_float_equal(right[1], 1.0f, 1e-5f);
		assert_float_equal(left[0], 1.0f, 1e-5f);
		assert_float_equal(left[1], side / 2.0f + (side - 2.0f) / 4.0f, 1e-5f);
		stilb_vec2 back = shade_impostor_plate(left, side);
		assert_float_equal(back[0], -1.0f, 1e-6f);
		assert_float_equal(back[1], -0.5f, 1e-6f);
	}
}

/* The blend of the three directions with their weights is close to the direction: by the square of the step. */
static void blends_are_close(void **state)
{
	(void)state;
	for (uint32_t i = 0; i < 20000; i++) {
		stilb_vec3 n = direction_of(i);
		float grid = (float)(9 + 2 * (i % 8)), step = 5.0f / (grid - 1.0f);
		shade_impostor_views views = shade_impostor_views_of(n, grid);
		stilb_vec2 places[3] = {views.a, views.b, views.c};
		stilb_vec3 blended = stilb_vec3_make(0, 0, 0);
		for (int v = 0; v < 3; v++) {
			stilb_vec3 corner = shade_impostor_direction(places[v], grid);
			assert_true(stilb_vec3_dot(corner, n) > cosf(step));
			blended += corner * views.weights[v];
		}
		assert_true(stilb_vec3_dot(stilb_vec3_normalize(blended), n) > cosf(0.5f * step * step));
	}
}

int main(void)
{
	const struct CMUnitTest exactness[] = {
		cmocka_unit_test(the_map_is_the_octahedron),
		cmocka_unit_test(axes_are_corners),
		cmocka_unit_test(three_views_blend_to_the_direction),
		cmocka_unit_test(triangles_stay_on_a_face),
		cmocka_unit_test(plates_have_a_margin),
	};
	const struct CMUnitTest properties[] = {
		cmocka_unit_test(blends_are_close),
	};
	return SHADE_PROOF_RUN(exactness, properties);
}
