/*
 * base_math: vectors, matrices, planes. Plain values without a life cycle, passed and returned by value.
 *
 * Conventions (docs/design.md).  Right-handed, +Y up, the camera looks along -Z; metres and radians; column vectors,
 *           column-major matrices (column 3 is the translation); clip space is Vulkan's, y down, with reversed depth
 *           (near 1, far 0).
 * Errors.   None: NaN and infinity go through as IEEE 754 has it, unless a function asserts a range.
 * Threads.  Pure functions: [any-thread].
 * Example.  What a camera at (0, 1, 5) sees:
 *
 *   stilb_mat4 view = stilb_mat4_view(stilb_vec3_make(0, 1, 5), 0.0f, 0.0f);
 *   stilb_mat4 clip = stilb_mat4_multiply(stilb_mat4_perspective(0.8f, 16.0f / 9.0f, 0.1f, 100.0f), view);
 *   stilb_frustum frustum = stilb_frustum_from_matrix(&clip);
 */
#ifndef STILB_BASE_MATH_H
#define STILB_BASE_MATH_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* Also the vector types of engine/base/glsl_types.h and the shading headers. v[0] is x. A vec3 has four lanes; the last
 * is unspecified, and no function here lets it reach a result. */
typedef float stilb_vec2 __attribute__((vector_size(8)));
typedef float stilb_vec3 __attribute__((vector_size(16)));
typedef float stilb_vec4 __attribute__((vector_size(16)));

/* Column-major 4x4: m[column * 4 + row]. */
typedef struct stilb_mat4 {
	float m[16];
} stilb_mat4;

/* Centre and radius, metres; radius >= 0. */
typedef struct stilb_sphere {
	float x, y, z, radius;
} stilb_sphere;

/* The half space n.p + distance >= 0 with n = (x, y, z), unit length, pointing to the inside; distance in metres. */
typedef struct stilb_plane {
	float x, y, z, distance;
} stilb_plane;

/* Six half spaces whose intersection is what a camera sees, in the order left, right, bottom, top, near, far. */
typedef struct stilb_frustum {
	stilb_plane planes[6];
} stilb_frustum;

/* (x, y, z) with lane 3 = 0. */
static inline stilb_vec3 stilb_vec3_make(float x, float y, float z)
{
	return (stilb_vec3){x, y, z, 0.0f};
}

/* The scalar product of three lanes. */
static inline float stilb_vec3_dot(stilb_vec3 a, stilb_vec3 b)
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The cross product, perpendicular to both: that of the X and the Y axis is the Z axis. Lane 3 is 0. */
static inline stilb_vec3 stilb_vec3_cross(stilb_vec3 a, stilb_vec3 b)
{
	return stilb_vec3_make(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]);
}

/* v / |v|. NaN or infinite if |v|^2 underflows to 0 or overflows: the caller excludes these. */
static inline stilb_vec3 stilb_vec3_normalize(stilb_vec3 v)
{
	return v * (1.0f / sqrtf(stilb_vec3_dot(v, v)));
}

/* The matrix that changes nothing: ones on the diagonal, else zeros. */
stilb_mat4 stilb_mat4_identity(void);

/* The product a * b, which applies b first, then a. */
stilb_mat4 stilb_mat4_multiply(stilb_mat4 a, stilb_mat4 b);

/* The inverse, computed in double by cofactors; of a matrix without one all zeros. [any-thread] */
stilb_mat4 stilb_mat4_inverse(const stilb_mat4 *m);

/* Scales by `scale` along all axes, then translates by (x, y, z) metres. */
stilb_mat4 stilb_mat4_scale_translate(float scale, float x, float y, float z);

/* World to view for a camera at position, metres. yaw turns it about +Y (0 looks along -Z, positive to the left), then
 * pitch raises its view (positive up). Radians, of any size. */
stilb_mat4 stilb_mat4_view(stilb_vec3 position, float yaw, float pitch);

/* View to Vulkan clip space: y down, w = -z, depth 1 at near_z and 0 at far_z. fov_y is the angle of the whole height,
 * in (0, pi) radians; aspect = width / height > 0; 0 < near_z < far_z, metres. */
stilb_mat4 stilb_mat4_perspective(float fov_y, float aspect, float near_z, float far_z);

/* The six planes of a world-to-clip matrix, in world space, with unit normals. A plane that the matrix does not have
 * (far, of an infinite projection) keeps a normal of 0 and contains everything. Source: Gribb and Hartmann, "Fast
 * extraction of viewing frustum planes from the world-view-projection matrix", 2001, with the signs of Vulkan's
 * reversed depth. */
stilb_frustum stilb_frustum_from_matrix(const stilb_mat4 *view_projection);

/* False: no part of the sphere lies within the frustum, or its radius is NaN. True also of some that lie outside, near
 * its edges. */
static inline bool stilb_frustum_may_see(const stilb_frustum *frustum, stilb_sphere sphere)
{
	for (int p = 0; p < 6; p++) {
		const stilb_plane *plane = &frustum->planes[p];
		if (plane->x * sphere.x + plane->y * sphere.y + plane->z * sphere.z + plane->distance < -sphere.radius)
			return false;
	}
	return sphere.radius >= 0.0f;
}

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
