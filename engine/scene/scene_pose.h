/* Poses and products of matrices, where there are many. Inside scene/. */
#ifndef STILB_SCENE_POSE_H
#define STILB_SCENE_POSE_H

#include "scene/scene.h"

#include <string.h>

/* stilb_scene_pose_matrix. False: the sum of its elements' squares is not within 1e36. */
static inline bool scene_pose_matrix(const stilb_scene_pose *pose, stilb_mat4 *matrix)
{
	const float *t = pose->translation, *q = pose->rotation, *s = pose->scale;
	float x = q[0], y = q[1], z = q[2], w = q[3];
	stilb_vec4 columns[4] = {
		s[0] * (stilb_vec4){1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w), 0.0f},
		s[1] * (stilb_vec4){2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w), 0.0f},
		s[2] * (stilb_vec4){2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y), 0.0f},
		{t[0], t[1], t[2], 1.0f},
	};
	stilb_vec4 sum =
		(columns[0] * columns[0] + columns[1] * columns[1]) + (columns[2] * columns[2] + columns[3] * columns[3]);
	for (size_t c = 0; c < 4; c++) {
		for (size_t i = 0; i < 3; i++)
			matrix->m[4 * c + i] = columns[c][i];
		matrix->m[4 * c + 3] = c == 3 ? 1.0f : 0.0f;
	}
	return sum[0] + sum[1] + sum[2] + sum[3] < 1e36f;
}

/* The sums of stilb_mat4_multiply, in the same order. */
static inline void scene_multiply(const stilb_mat4 *a, const stilb_mat4 *b, stilb_mat4 *product)
{
	stilb_vec4 columns[4];
	memcpy(columns, a->m, sizeof columns);
	for (size_t i = 0; i < 4; i++) {
		const float *v = &b->m[4 * i];
		stilb_vec4 sum = ((columns[0] * v[0] + columns[1] * v[1]) + columns[2] * v[2]) + columns[3] * v[3];
		memcpy(&product->m[4 * i], &sum, sizeof sum);
	}
}

#endif
