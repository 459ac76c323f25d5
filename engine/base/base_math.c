#include "base/base_math.h"

#include "base/base.h"

stilb_mat4 stilb_mat4_identity(void)
{
	return stilb_mat4_scale_translate(1.0f, 0.0f, 0.0f, 0.0f);
}

stilb_mat4 stilb_mat4_multiply(stilb_mat4 a, stilb_mat4 b)
{
	stilb_mat4 product;
	for (size_t column = 0; column < 4; column++) {
		const float *v = &b.m[column * 4];
		for (int row = 0; row < 4; row++)
			product.m[column * 4 + row] =
				a.m[row] * v[0] + a.m[4 + row] * v[1] + a.m[8 + row] * v[2] + a.m[12 + row] * v[3];
	}
	return product;
}

/* The determinant of what is left of m without row `row` and column `column`, with the sign of its place. */
static double mat4_cofactor(const stilb_mat4 *m, int row, int column)
{
	double a[3][3];
	for (int c = 0; c < 3; c++)
		for (int r = 0; r < 3; r++)
			a[c][r] = (double)m->m[4 * (c + (c >= column)) + r + (r >= row)];
	double minor = a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) -
	               a[1][0] * (a[0][1] * a[2][2] - a[0][2] * a[2][1]) +
	               a[2][0] * (a[0][1] * a[1][2] - a[0][2] * a[1][1]);
	return (row + column) % 2 == 0 ? minor : -minor;
}

stilb_mat4 stilb_mat4_inverse(const stilb_mat4 *m)
{
	stilb_mat4 inverse = {0};
	double determinant = 0.0;
	for (int r = 0; r < 4; r++)
		determinant += (double)m->m[r] * mat4_cofactor(m, r, 0);
	for (int c = 0; c < 4 && determinant != 0.0; c++)
		for (int r = 0; r < 4; r++)
			inverse.m[4 * c + r] = (float)(mat4_cofactor(m, c, r) / determinant);
	return inverse;
}

stilb_mat4 stilb_mat4_scale_translate(float scale, float x, float y, float z)
{
	stilb_mat4 matrix = {.m = {[0] = scale, [5] = scale, [10] = scale, [12] = x, [13] = y, [14] = z, [15] = 1.0f}};
	return matrix;
}

stilb_mat4 stilb_mat4_view(stilb_vec3 position, float yaw, float pitch)
{
	/* The camera's axes in the world are the columns of R_y(yaw) R_x(pitch). They are rows of the view matrix, because
	 * the inverse of a rotation is its transpose. The last axis points backwards: the camera looks along -Z. */
	float sin_yaw = sinf(yaw), cos_yaw = cosf(yaw), sin_pitch = sinf(pitch), cos_pitch = cosf(pitch);
	stilb_vec3 axes[3] = {
		stilb_vec3_make(cos_yaw, 0.0f, -sin_yaw),
		stilb_vec3_make(sin_yaw * sin_pitch, cos_pitch, cos_yaw * sin_pitch),
		stilb_vec3_make(sin_yaw * cos_pitch, -sin_pitch, cos_yaw * cos_pitch),
	};
	stilb_mat4 view = {.m = {[15] = 1.0f}};
	for (int row = 0; row < 3; row++) {
		view.m[row] = axes[row][0];
		view.m[4 + row] = axes[row][1];
		view.m[8 + row] = axes[row][2];
		view.m[12 + row] = -stilb_vec3_dot(axes[row], position);
	}
	return view;
}

stilb_mat4 stilb_mat4_perspective(float fov_y, float aspect, float near_z, float far_z)
{
	STILB_ASSERT(fov_y > 0.0f && fov_y < 3.1415927f);
	STILB_ASSERT(aspect > 0.0f);
	STILB_ASSERT(0.0f < near_z && near_z < far_z);
	/* In clip space w = -z, z in view space. Depth is (a z + b) / w; that it is 1 at z = -near_z and 0 at z = -far_z
	 * gives two linear equations for a and b. */
	float focal = 1.0f / tanf(0.5f * fov_y);
	float a = near_z / (far_z - near_z);
	float b = far_z * a;
	stilb_mat4 projection = {.m = {[0] = focal / aspect, [5] = -focal, [10] = a, [11] = -1.0f, [14] = b}};
	return projection;
}

/* The plane of the half space row . (p, 1) >= 0, p a point, scaled so that its normal (the first three numbers) is
 * unit. A row with a normal of 0 (the far plane of an infinite projection) stays as it is: then n.p + distance has one
 * sign everywhere. */
static stilb_plane base_plane_normalize(stilb_vec4 row)
{
	float length = sqrtf(stilb_vec3_dot(row, row));
	if (length > 0.0f)
		row *= 1.0f / length;
	return (stilb_plane){row[0], row[1], row[2], row[3]};
}

stilb_frustum stilb_frustum_from_matrix(const stilb_mat4 *view_projection)
{
	STILB_ASSERT(view_projection);
	stilb_vec4 rows[4];
	for (int row = 0; row < 4; row++)
		for (int column = 0; column < 4; column++)
			rows[row][column] = view_projection->m[column * 4 + row];
	/* A point is in view if its clip coordinates have -w <= x <= w, -w <= y <= w and 0 <= z <= w. y points down, so
	 * y <= w is the bottom edge; depth is reversed, so z <= w is the near plane. */
	stilb_frustum frustum = {{
		base_plane_normalize(rows[3] + rows[0]),
		base_plane_normalize(rows[3] - rows[0]),
		base_plane_normalize(rows[3] - rows[1]),
		base_plane_normalize(rows[3] + rows[1]),
		base_plane_normalize(rows[3] - rows[2]),
		base_plane_normalize(rows[2]),
	}};
	return frustum;
}
