/* Poses and products of matrices, where there are many. Inside scene/. */
#ifndef STILB_SCENE_POSE_H
#define STILB_SCENE_POSE_H

#include "scene/scene.h"

#include <string.h>

/* stilb_scene_pose_matrix of vectors: of t and s three lanes count. False: the sum of the elements' squares is not
 * within 1e36. */
static inline bool scene_pose_columns(stilb_vec4 t, stilb_vec4 q, stilb_vec4 s, stilb_mat4 *matrix)
{
	typedef int32_t lanes __attribute__((vector_size(16)));
	lanes three = {-1, -1, -1, 0};
	stilb_vec4 twice = q + q, squares = q * twice;
	stilb_vec4 diagonal = 1.0f - (__builtin_shufflevector(squares, squares, 1, 0, 0, 0) +
	                              __builtin_shufflevector(squares, squares, 2, 2, 1, 1));
	stilb_vec4 mixed = __builtin_shufflevector(q, q, 0, 0, 1, 1) * __builtin_shufflevector(twice, twice, 1, 2, 2, 2);
	stilb_vec4 real = __builtin_shufflevector(q, q, 2, 1, 0, 0) * twice[3];
	stilb_vec4 sum = mixed + real, rest = mixed - real; /* of xy and zw, xz and yw, yz and xw */
	stilb_vec4 first = __builtin_shufflevector(diagonal, sum, 0, 4, 1, 5);
	stilb_vec4 second = __builtin_shufflevector(rest, diagonal, 0, 0, 5, 5);
	stilb_vec4 third = __builtin_shufflevector(sum, rest, 1, 1, 6, 6);
	stilb_vec4 columns[4] = {
		s[0] * __builtin_shufflevector(first, rest, 0, 1, 5, 5),
		s[1] * __builtin_shufflevector(second, sum, 0, 2, 6, 6),
		s[2] * __builtin_shufflevector(third, diagonal, 0, 2, 6, 6),
		t,
	};
	for (int c = 0; c < 4; c++)
		columns[c] = (stilb_vec4)((lanes)columns[c] & three);
	columns[3] += (stilb_vec4){0.0f, 0.0f, 0.0f, 1.0f};
	memcpy(matrix->m, columns, sizeof columns);
	sum = (columns[0] * columns[0] + columns[1] * columns[1]) + (columns[2] * columns[2] + columns[3] * columns[3]);
	return sum[0] + sum[1] + sum[2] + sum[3] < 1e36f;
}

static inline bool scene_pose_matrix(const stilb_scene_pose *pose, stilb_mat4 *matrix)
{
	const float *t = pose->translation, *q = pose->rotation, *s = pose->scale;
	return scene_pose_columns((stilb_vec4){t[0], t[1], t[2]}, (stilb_vec4){q[0], q[1], q[2], q[3]},
	                          (stilb_vec4){s[0], s[1], s[2]}, matrix);
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
