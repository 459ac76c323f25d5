/* A camera that orbits a point: what it looks at stays, what is dragged follows, and it can be undone. */
#include "base/base_math.h"
#include "input/input_orbit.h"
#include "support/test.h"

#include <math.h>

/* The point that the camera looks at. */
static stilb_vec3 pivot(const stilb_input_pose *pose, float distance)
{
	stilb_mat4 view = stilb_mat4_view((stilb_vec3){0}, pose->yaw, pose->pitch);
	stilb_vec3 at = {0};
	for (int i = 0; i < 3; i++)
		at[i] = pose->position[i] - distance * view.m[4 * i + 2];
	return at;
}

static void assert_near(stilb_vec3 a, stilb_vec3 b, float limit)
{
	for (int i = 0; i < 3; i++)
		assert_true(fabsf(a[i] - b[i]) <= limit);
}

/* From (0, 0, 5) a quarter turn to the left about the origin leads to (5, 0, 0), from where it is seen along -X. */
static void turns_about_the_point(void **state)
{
	(void)state;
	stilb_input_pose pose = {.position = {0, 0, 5}};
	float distance = 5.0f;
	stilb_input_orbit_move(&(stilb_input_orbit){.turn = {1.5707963f, 0}}, &pose, &distance);
	assert_near(stilb_vec3_make(pose.position[0], pose.position[1], pose.position[2]), stilb_vec3_make(5, 0, 0), 1e-5f);
	assert_near(pivot(&pose, distance), stilb_vec3_make(0, 0, 0), 1e-5f);
	for (int i = 0; i < 1000; i++)
		stilb_input_orbit_move(&(stilb_input_orbit){.turn = {0.1f, i % 7 < 3 ? 0.3f : -0.2f}}, &pose, &distance);
	assert_near(pivot(&pose, distance), stilb_vec3_make(0, 0, 0), 1e-3f);
	assert_true(fabsf(pose.yaw) <= 3.1415928f && fabsf(pose.pitch) <= STILB_INPUT_PITCH_LIMIT);
	stilb_input_orbit_move(&(stilb_input_orbit){.turn = {0, 9.0f}}, &pose, &distance);
	assert_true(pose.pitch == STILB_INPUT_PITCH_LIMIT);
}

static void pans_and_comes_closer(void **state)
{
	(void)state;
	stilb_input_pose pose = {.position = {1, 2, 3}};
	float distance = 4.0f;
	stilb_input_orbit_move(&(stilb_input_orbit){.pan = {0.5f, -0.25f}}, &pose, &distance);
	assert_near(pivot(&pose, distance), stilb_vec3_make(3, 1, -1), 1e-5f);
	stilb_input_orbit_move(&(stilb_input_orbit){.closer = 2.0f}, &pose, &distance);
	assert_true(fabsf(distance - 4.0f * STILB_INPUT_ORBIT_STEP * STILB_INPUT_ORBIT_STEP) < 1e-5f);
	assert_near(pivot(&pose, distance), stilb_vec3_make(3, 1, -1), 1e-5f);
	stilb_input_orbit_move(&(stilb_input_orbit){.closer = -2.0f}, &pose, &distance);
	assert_true(fabsf(distance - 4.0f) < 1e-5f);
	for (int i = 0; i < 100; i++)
		stilb_input_orbit_move(&(stilb_input_orbit){.closer = 1e9f}, &pose, &distance);
	assert_true(distance == STILB_INPUT_ORBIT_NEAREST);
	stilb_input_orbit_move(&(stilb_input_orbit){.closer = -1e9f}, &pose, &distance);
	assert_true(distance == STILB_INPUT_ORBIT_FARTHEST);
}

static void numbers_that_are_not_finite(void **state)
{
	(void)state;
	stilb_input_pose pose = {.position = {1, 2, 3}, .yaw = 0.5f, .pitch = -1.5707963f}, before = pose;
	float distance = 2.0f;
	stilb_input_orbit_move(&(stilb_input_orbit){{NAN, INFINITY}, {NAN, -INFINITY}, NAN}, &pose, &distance);
	assert_true(distance == 2.0f && pose.yaw == before.yaw && pose.pitch == before.pitch);
	for (int i = 0; i < 3; i++)
		assert_true(fabsf(pose.position[i] - before.position[i]) < 1e-6f);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(turns_about_the_point),
		cmocka_unit_test(pans_and_comes_closer),
		cmocka_unit_test(numbers_that_are_not_finite),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
