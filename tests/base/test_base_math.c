/* base_math against closed forms, and the frustum against clip space. */
#include "base/base.h"
#include "base/base_math.h"
#include "support/test.h"

#include <stddef.h>
#include <stdint.h>

#define PI 3.14159265358979323846f

static stilb_vec4 apply(const stilb_mat4 *matrix, float x, float y, float z, float w)
{
	const float *m = matrix->m;
	stilb_vec4 result;
	for (int row = 0; row < 4; row++)
		result[row] = m[row] * x + m[4 + row] * y + m[8 + row] * z + m[12 + row] * w;
	return result;
}

static void assert_vec3(stilb_vec3 v, float x, float y, float z, float bound)
{
	assert_float_equal(v[0], x, bound);
	assert_float_equal(v[1], y, bound);
	assert_float_equal(v[2], z, bound);
}

/* In [-1, 1); a new value at each call. */
static float random_signed(void)
{
	static uint64_t index;
	return 2.0f * stilb_random_float(11, index++) - 1.0f;
}

static stilb_mat4 random_matrix(void)
{
	stilb_mat4 matrix;
	for (int i = 0; i < 16; i++)
		matrix.m[i] = random_signed();
	return matrix;
}

static void test_vectors(void **state)
{
	(void)state;
	stilb_vec3 a = stilb_vec3_make(1.0f, 2.0f, 3.0f), b = stilb_vec3_make(-4.0f, 5.0f, 0.5f);
	assert_float_equal(stilb_vec3_dot(a, b), 7.5f, 0.0f);
	assert_vec3(stilb_vec3_cross(a, b), -14.0f, -12.5f, 13.0f, 0.0f);
	assert_vec3(stilb_vec3_cross(stilb_vec3_make(1, 0, 0), stilb_vec3_make(0, 1, 0)), 0.0f, 0.0f, 1.0f, 0.0f);
	assert_vec3(stilb_vec3_normalize(stilb_vec3_make(0.0f, -3.0f, 4.0f)), 0.0f, -0.6f, 0.8f, 1e-7f);
}

static void test_identity_and_scale_translate(void **state)
{
	(void)state;
	stilb_mat4 identity = stilb_mat4_identity();
	for (int i = 0; i < 16; i++)
		assert_float_equal(identity.m[i], (i % 5 == 0 ? 1.0f : 0.0f), 0.0f);
	stilb_mat4 matrix = stilb_mat4_scale_translate(2.0f, 10.0f, 20.0f, 30.0f);
	stilb_vec4 point = apply(&matrix, 1.0f, -2.0f, 3.0f, 1.0f);
	assert_vec3(point, 12.0f, 16.0f, 36.0f, 0.0f);
	assert_float_equal(point[3], 1.0f, 0.0f);
	assert_vec3(apply(&matrix, 1.0f, -2.0f, 3.0f, 0.0f), 2.0f, -4.0f, 6.0f, 0.0f);
}

static void test_multiply_lets_the_right_factor_act_first(void **state)
{
	(void)state;
	stilb_mat4 scale = stilb_mat4_scale_translate(2.0f, 0.0f, 0.0f, 0.0f);
	stilb_mat4 shift = stilb_mat4_scale_translate(1.0f, 1.0f, 2.0f, 3.0f);
	stilb_mat4 both = stilb_mat4_multiply(scale, shift);
	assert_vec3(apply(&both, 0.0f, 0.0f, 0.0f, 1.0f), 2.0f, 4.0f, 6.0f, 0.0f);
	for (int i = 0; i < 100; i++) {
		stilb_mat4 a = random_matrix(), b = random_matrix(), product = stilb_mat4_multiply(a, b);
		float x = random_signed(), y = random_signed(), z = random_signed(), w = random_signed();
		stilb_vec4 inner = apply(&b, x, y, z, w);
		stilb_vec4 expected = apply(&a, inner[0], inner[1], inner[2], inner[3]);
		stilb_vec4 got = apply(&product, x, y, z, w);
		assert_vec3(got, expected[0], expected[1], expected[2], 4e-6f);
		assert_float_equal(got[3], expected[3], 4e-6f);
	}
}

static void test_view_directions(void **state)
{
	(void)state;
	stilb_vec3 eye = stilb_vec3_make(3.0f, 4.0f, 5.0f);
	stilb_mat4 ahead = stilb_mat4_view(eye, 0.0f, 0.0f);
	assert_vec3(apply(&ahead, 3.0f, 4.0f, 5.0f, 1.0f), 0.0f, 0.0f, 0.0f, 0.0f);
	assert_vec3(apply(&ahead, 4.0f, 6.0f, -5.0f, 1.0f), 1.0f, 2.0f, -10.0f, 0.0f);
	/* A quarter turn to the left looks along -X; then +Z is on the left. */
	stilb_mat4 left = stilb_mat4_view(eye, 0.5f * PI, 0.0f);
	assert_vec3(apply(&left, 1.0f, 4.0f, 5.0f, 1.0f), 0.0f, 0.0f, -2.0f, 1e-5f);
	assert_vec3(apply(&left, 3.0f, 4.0f, 7.0f, 1.0f), -2.0f, 0.0f, 0.0f, 1e-5f);
	/* Pitch raises the view: straight up at a quarter turn. */
	stilb_mat4 up = stilb_mat4_view(eye, 0.0f, 0.5f * PI);
	assert_vec3(apply(&up, 3.0f, 9.0f, 5.0f, 1.0f), 0.0f, 0.0f, -5.0f, 1e-5f);
	/* Both at once: yaw turns about the world's +Y after pitch, so this looks up and to -X. */
	stilb_mat4 both = stilb_mat4_view(eye, 0.5f * PI, 0.25f * PI);
	assert_vec3(apply(&both, 2.0f, 5.0f, 5.0f, 1.0f), 0.0f, 0.0f, -sqrtf(2.0f), 1e-5f);
}

static void test_view_is_rigid(void **state)
{
	(void)state;
	for (int i = 0; i < 100; i++) {
		stilb_mat4 view = stilb_mat4_view(stilb_vec3_make(random_signed(), random_signed(), random_signed()),
		                                  4.0f * random_signed(), 1.5f * random_signed());
		stilb_vec3 columns[3];
		for (int c = 0; c < 3; c++)
			columns[c] = stilb_vec3_make(view.m[4 * c], view.m[4 * c + 1], view.m[4 * c + 2]);
		for (int c = 0; c < 3; c++) {
			assert_float_equal(stilb_vec3_dot(columns[c], columns[c]), 1.0f, 1e-6f);
			assert_float_equal(stilb_vec3_dot(columns[c], columns[(c + 1) % 3]), 0.0f, 1e-6f);
		}
		stilb_vec3 third = stilb_vec3_cross(columns[0], columns[1]); /* a rotation, not a reflection */
		assert_vec3(third, columns[2][0], columns[2][1], columns[2][2], 1e-6f);
	}
}

static void test_perspective_points(void **state)
{
	(void)state;
	float near_z = 0.5f, far_z = 200.0f, aspect = 2.0f, fov_y = 0.5f * PI; /* the edges are at 45 degrees */
	stilb_mat4 projection = stilb_mat4_perspective(fov_y, aspect, near_z, far_z);
	stilb_vec4 at_near = apply(&projection, 0.0f, 0.0f, -near_z, 1.0f);
	assert_float_equal(at_near[2] / at_near[3], 1.0f, 1e-6f);
	stilb_vec4 at_far = apply(&projection, 0.0f, 0.0f, -far_z, 1.0f);
	assert_float_equal(at_far[2] / at_far[3], 0.0f, 1e-6f);
	assert_float_equal(at_far[3], far_z, 0.0f); /* w is the distance along the view */
	/* depth = near (far - d) / (d (far - near)) in between */
	stilb_vec4 between = apply(&projection, 0.0f, 0.0f, -2.0f, 1.0f);
	assert_float_equal(between[2] / between[3], 0.5f * 198.0f / (2.0f * 199.5f), 1e-6f);
	/* The top edge is y = -1, the bottom edge +1; +x is right, the edge lies at aspect times the distance. */
	stilb_vec4 top = apply(&projection, 0.0f, 10.0f, -10.0f, 1.0f);
	assert_float_equal(top[1] / top[3], -1.0f, 1e-6f);
	stilb_vec4 bottom = apply(&projection, 0.0f, -10.0f, -10.0f, 1.0f);
	assert_float_equal(bottom[1] / bottom[3], 1.0f, 1e-6f);
	stilb_vec4 right = apply(&projection, 20.0f, 0.0f, -10.0f, 1.0f);
	assert_float_equal(right[0] / right[3], 1.0f, 1e-6f);
	/* Another angle: tan(fov / 2) at distance 1 is the edge. */
	stilb_mat4 narrow = stilb_mat4_perspective(0.7f, 1.0f, near_z, far_z);
	stilb_vec4 edge = apply(&narrow, 0.0f, tanf(0.35f), -1.0f, 1.0f);
	assert_float_equal(edge[1] / edge[3], -1.0f, 1e-6f);
}

/* True if a point is inside a plane by its clip coordinates. *near_boundary: it is too close to the plane to tell. */
static bool clip_inside(stilb_vec4 clip, int plane, bool *near_boundary)
{
	float w = clip[3];
	float slack[6] = {w + clip[0], w - clip[0], w - clip[1], w + clip[1], w - clip[2], clip[2]};
	float scale = fabsf(w) + fabsf(clip[0]) + fabsf(clip[1]) + fabsf(clip[2]);
	*near_boundary = fabsf(slack[plane]) < 1e-4f * scale;
	return slack[plane] >= 0.0f;
}

static float plane_at(stilb_plane plane, float x, float y, float z)
{
	return plane.x * x + plane.y * y + plane.z * z + plane.distance;
}

static void test_frustum_against_clip_space(void **state)
{
	(void)state;
	int compared = 0, inside[6] = {0}, outside[6] = {0};
	for (int view = 0; view < 200; view++) {
		stilb_mat4 projection = stilb_mat4_perspective(1.2f + random_signed(), 1.5f + random_signed(),
		                                               1.1f + random_signed(), 20.0f + 10.0f * random_signed());
		stilb_vec3 eye = stilb_vec3_make(random_signed(), random_signed(), random_signed()) * 10.0f;
		stilb_mat4 matrix =
			stilb_mat4_multiply(projection, stilb_mat4_view(eye, 4.0f * random_signed(), random_signed()));
		stilb_frustum frustum = stilb_frustum_from_matrix(&matrix);
		for (int p = 0; p < 6; p++) {
			stilb_plane plane = frustum.planes[p];
			float square = plane.x * plane.x + plane.y * plane.y + plane.z * plane.z;
			assert_float_equal(square, 1.0f, 1e-6f);
		}
		for (int i = 0; i < 200; i++) {
			float x = 30.0f * random_signed(), y = 30.0f * random_signed(), z = 30.0f * random_signed();
			stilb_vec4 clip = apply(&matrix, x, y, z, 1.0f);
			for (int p = 0; p < 6; p++) {
				bool near_boundary, expected = clip_inside(clip, p, &near_boundary);
				if (near_boundary)
					continue;
				assert_int_equal(plane_at(frustum.planes[p], x, y, z) >= 0.0f, expected);
				(*(expected ? &inside[p] : &outside[p]))++;
				compared++;
			}
		}
	}
	assert_true(compared > 200 * 200 * 6 * 9 / 10); /* few were too close to tell */
	for (int p = 0; p < 6; p++) {
		assert_true(inside[p] > 1000);
		assert_true(outside[p] > 1000);
	}
}

/* Names and distances: a camera at the origin, square picture, edges at 45 degrees. */
static void test_frustum_planes_are_named(void **state)
{
	(void)state;
	stilb_mat4 matrix = stilb_mat4_perspective(0.5f * PI, 1.0f, 1.0f, 100.0f);
	stilb_frustum frustum = stilb_frustum_from_matrix(&matrix);
	float s = sqrtf(0.5f);
	const stilb_plane expected[6] = {
		{s, 0.0f, -s, 0.0f},  {-s, 0.0f, -s, 0.0f},       {0.0f, s, -s, 0.0f},
		{0.0f, -s, -s, 0.0f}, {0.0f, 0.0f, -1.0f, -1.0f}, {0.0f, 0.0f, 1.0f, 100.0f},
	};
	for (int p = 0; p < 6; p++) {
		stilb_plane plane = frustum.planes[p];
		assert_vec3(stilb_vec3_make(plane.x, plane.y, plane.z), expected[p].x, expected[p].y, expected[p].z, 1e-6f);
		assert_float_equal(plane.distance, expected[p].distance, 1e-4f);
	}
}

/* A sphere that touches a plane from outside may be seen, one that does not reach it is not, nor one of no radius. */
static void test_frustum_may_see_spheres(void **state)
{
	(void)state;
	stilb_mat4 matrix = stilb_mat4_perspective(0.5f * PI, 1.0f, 1.0f, 100.0f);
	stilb_frustum frustum = stilb_frustum_from_matrix(&matrix);
	float s = sqrtf(0.5f);
	assert_true(stilb_frustum_may_see(&frustum, (stilb_sphere){0.0f, 0.0f, -50.0f, 0.0f}));
	assert_false(stilb_frustum_may_see(&frustum, (stilb_sphere){0.0f, 0.0f, -50.0f, (float)NAN}));
	for (int p = 0; p < 6; p++) {
		const float away[6] = {10.0f / s, 10.0f / s, 10.0f / s, 10.0f / s, 10.0f, 10.0f};
		float x = p == 0 ? -50.0f - away[0] : p == 1 ? 50.0f + away[1] : 0.0f;
		float y = p == 2 ? -50.0f - away[2] : p == 3 ? 50.0f + away[3] : 0.0f;
		float z = p == 4 ? -1.0f + away[4] : p == 5 ? -100.0f - away[5] : -50.0f;
		assert_true(stilb_frustum_may_see(&frustum, (stilb_sphere){x, y, z, 10.01f}));
		assert_false(stilb_frustum_may_see(&frustum, (stilb_sphere){x, y, z, 9.99f}));
	}
}

/* An infinite projection has no far plane: row 2 is (0, 0, 0, near), true everywhere and not NaN. */
static void test_frustum_without_far_plane(void **state)
{
	(void)state;
	stilb_mat4 matrix = {.m = {[0] = 1.0f, [5] = -1.0f, [11] = -1.0f, [14] = 0.1f}};
	stilb_frustum frustum = stilb_frustum_from_matrix(&matrix);
	assert_true(plane_at(frustum.planes[5], 1e9f, -1e9f, -1e30f) >= 0.0f);
	assert_true(plane_at(frustum.planes[4], 0.0f, 0.0f, -0.2f) >= 0.0f);
	assert_false(plane_at(frustum.planes[4], 0.0f, 0.0f, -0.05f) >= 0.0f);
}

/* Times its matrix it is the identity, also of matrices with very large or small numbers; of one without an inverse
 * it is all zeros. */
static void test_inverse(void **state)
{
	(void)state;
	const float scales[3] = {1.0f, 1e-12f, 1e12f};
	for (uint32_t k = 0; k < 300; k++) {
		stilb_mat4 m;
		float scale = scales[k % 3];
		for (uint32_t i = 0; i < 16; i++)
			m.m[i] = scale * (2.0f * stilb_random_float(9, 16 * k + i) - 1.0f + (i % 5 == 0 ? 3.0f : 0.0f));
		stilb_mat4 inverse = stilb_mat4_inverse(&m);
		for (int row = 0; row < 4; row++)
			for (int column = 0; column < 4; column++) {
				double sum = 0.0;
				for (int i = 0; i < 4; i++)
					sum += (double)inverse.m[4 * i + row] * (double)m.m[4 * column + i];
				assert_true(fabs(sum - (row == column)) < 1e-5);
			}
	}
	stilb_mat4 flat = stilb_mat4_identity(), zero = {0};
	flat.m[5] = 0.0f;
	stilb_mat4 none = stilb_mat4_inverse(&flat);
	assert_memory_equal(&none, &zero, sizeof zero);
	none = stilb_mat4_inverse(&zero);
	assert_memory_equal(&none, &zero, sizeof zero);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_vectors),
		cmocka_unit_test(test_identity_and_scale_translate),
		cmocka_unit_test(test_multiply_lets_the_right_factor_act_first),
		cmocka_unit_test(test_inverse),
		cmocka_unit_test(test_view_directions),
		cmocka_unit_test(test_view_is_rigid),
		cmocka_unit_test(test_perspective_points),
		cmocka_unit_test(test_frustum_against_clip_space),
		cmocka_unit_test(test_frustum_planes_are_named),
		cmocka_unit_test(test_frustum_without_far_plane),
		cmocka_unit_test(test_frustum_may_see_spheres),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
