/* Translation, rotation and scale, and the matrices that they make. */
#include "scene/scene_pose.h"

#include <math.h>

stilb_scene_pose stilb_scene_pose_identity(void)
{
	return (stilb_scene_pose){.rotation = {[3] = 1.0f}, .scale = {1.0f, 1.0f, 1.0f}};
}

stilb_mat4 stilb_scene_pose_matrix(const stilb_scene_pose *pose)
{
	STILB_ASSERT(pose);
	stilb_mat4 matrix;
	scene_pose_matrix(pose, &matrix);
	return matrix;
}

/* The unit quaternion of three unit axes, right-handed and perpendicular to each other: the largest component comes
 * from the diagonal, the others from it (Shepperd, "Quaternion from rotation matrix", 1978). */
static void pose_quaternion(const stilb_vec3 axes[3], float q[4])
{
	float trace = axes[0][0] + axes[1][1] + axes[2][2], most = trace;
	int largest = 3;
	for (int i = 0; i < 3; i++)
		if (axes[i][i] > most) {
			most = axes[i][i];
			largest = i;
		}
	float twice = sqrtf(fmaxf(1.0f + 2.0f * most - trace, 0.0f)), share = twice > 0.0f ? 0.5f / twice : 0.0f;
	int i = largest < 3 ? largest : 0, j = (i + 1) % 3, k = (i + 2) % 3;
	q[largest] = 0.5f * twice;
	if (largest == 3) {
		q[0] = (axes[1][2] - axes[2][1]) * share;
		q[1] = (axes[2][0] - axes[0][2]) * share;
		q[2] = (axes[0][1] - axes[1][0]) * share;
		return;
	}
	q[3] = (axes[j][k] - axes[k][j]) * share;
	q[j] = (axes[i][j] + axes[j][i]) * share;
	q[k] = (axes[i][k] + axes[k][i]) * share;
}

static float pose_length(stilb_vec3 v)
{
	return sqrtf(stilb_vec3_dot(v, v));
}

/* A unit vector along v. False: it has no length. */
static bool pose_along(stilb_vec3 v, stilb_vec3 *axis)
{
	float largest = fmaxf(fmaxf(fabsf(v[0]), fabsf(v[1])), fabsf(v[2]));
	*axis = largest > 0.0f ? stilb_vec3_normalize(v * (1.0f / largest)) : stilb_vec3_make(1, 0, 0);
	return largest > 0.0f;
}

/* The part of v that is perpendicular to a unit vector. */
static stilb_vec3 pose_across(stilb_vec3 v, stilb_vec3 axis)
{
	return v - axis * stilb_vec3_dot(axis, v);
}

/* Unit axes, right-handed and perpendicular to each other, along the columns as far as these have lengths. Returns the
 * index of the axis that follows from the other two. */
static int pose_axes(const stilb_vec3 columns[3], stilb_vec3 axes[3])
{
	int i = 0;
	while (i < 2 && !pose_along(columns[i], &axes[i]))
		i++;
	int j = (i + 1) % 3, k = (i + 2) % 3;
	if (i == 2)
		pose_along(columns[2], &axes[2]);
	if (!pose_along(pose_across(columns[j], axes[i]), &axes[j])) {
		stilb_vec3 other = fabsf(axes[i][0]) < 0.7f ? stilb_vec3_make(1, 0, 0) : stilb_vec3_make(0, 1, 0);
		if (!pose_along(pose_across(columns[k], axes[i]), &axes[k]))
			pose_along(pose_across(other, axes[i]), &axes[k]);
		axes[j] = stilb_vec3_cross(axes[k], axes[i]);
	}
	axes[k] = stilb_vec3_cross(axes[i], axes[j]);
	return k;
}

stilb_scene_pose stilb_scene_pose_of(const stilb_mat4 *matrix)
{
	STILB_ASSERT(matrix);
	const float *m = matrix->m;
	stilb_vec3 columns[3], axes[3];
	for (size_t i = 0; i < 3; i++)
		columns[i] = stilb_vec3_make(m[4 * i], m[4 * i + 1], m[4 * i + 2]);
	int last = pose_axes(columns, axes);
	stilb_scene_pose pose = {.translation = {m[12], m[13], m[14]}};
	for (int i = 0; i < 3; i++)
		pose.scale[i] = pose_length(columns[i]);
	if (stilb_vec3_dot(axes[last], columns[last]) < 0.0f)
		pose.scale[last] = -pose.scale[last];
	pose_quaternion(axes, pose.rotation);
	return pose;
}
