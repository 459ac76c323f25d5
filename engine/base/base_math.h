/*
 * base_math: vectors, matrices, planes. Small values, passed and returned by value; all functions are [any-thread].
 *
 * Conventions (docs/design.md): right-handed, +Y up, the camera looks along -Z; column vectors, column-major matrices
 * (column 3 = translation); clip space is Vulkan's with reversed depth (near 1, far 0).
 */
#ifndef STILB_BASE_MATH_H
#define STILB_BASE_MATH_H

#include <math.h>
#include <stdint.h>

/* The vector types that engine/base/glsl_types.h and the shading headers use too. Lane 3 of a vec3 is unspecified. */
typedef float stilb_vec2 __attribute__((vector_size(8)));
typedef float stilb_vec3 __attribute__((vector_size(16)));
typedef float stilb_vec4 __attribute__((vector_size(16)));

/* Column-major 4x4: m[column * 4 + row]. */
typedef struct stilb_mat4 {
	float m[16];
} stilb_mat4;

/* A sphere in metres. */
typedef struct stilb_sphere {
	float x, y, z, radius;
} stilb_sphere;

/* The half space n.p + distance >= 0; n is unit length and points to the inside. */
typedef struct stilb_plane {
	float x, y, z, distance;
} stilb_plane;

/* Six half spaces whose intersection is what a view sees: left, right, bottom, top, near, far. */
typedef struct stilb_frustum {
	stilb_plane planes[6];
} stilb_frustum;

static inline stilb_vec3 stilb_vec3_make(float x, float y, float z)
{
	return (stilb_vec3){x, y, z, 0.0f};
}

static inline float stilb_vec3_dot(stilb_vec3 a, stilb_vec3 b)
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline stilb_vec3 stilb_vec3_cross(stilb_vec3 a, stilb_vec3 b)
{
	return stilb_vec3_make(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]);
}

static inline stilb_vec3 stilb_vec3_normalize(stilb_vec3 v)
{
	return v * (1.0f / sqrtf(stilb_vec3_dot(v, v)));
}

stilb_mat4 stilb_mat4_identity(void);

/* a * b: b acts first. */
stilb_mat4 stilb_mat4_multiply(stilb_mat4 a, stilb_mat4 b);

/* Uniform scale, then translation. */
stilb_mat4 stilb_mat4_scale_translate(float scale, float x, float y, float z);

/* World to view for a camera at position; yaw turns about +Y (0 looks along -Z, positive to the left), pitch raises the
 * view. Radians. */
stilb_mat4 stilb_mat4_view(stilb_vec3 position, float yaw, float pitch);

/* View to Vulkan clip space: y down, depth 1 at near_z and 0 at far_z. fov_y in radians, aspect = width / height,
 * 0 < near_z < far_z. */
stilb_mat4 stilb_mat4_perspective(float fov_y, float aspect, float near_z, float far_z);

/* The six planes of a world-to-clip matrix, unit normals. Source: Gribb and Hartmann, "Fast extraction of viewing
 * frustum planes from the world-view-projection matrix", 2001, with the signs of Vulkan's reversed depth. */
stilb_frustum stilb_frustum_from_matrix(const stilb_mat4 *view_projection);

#endif
