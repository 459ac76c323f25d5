/*
 * gi_surface: the point that a ray hit, as shading needs it, and where the next ray may start. [any-thread]
 */
#ifndef STILB_GI_SURFACE_H
#define STILB_GI_SURFACE_H

#include "gi/gi_scene_internal.h"

/* The point where a ray ended, as shading needs it. */
typedef struct gi_surface {
	stilb_vec3 position;          /* on the triangle */
	stilb_vec3 geometric;         /* unit normal of the triangle, on the side the ray came from */
	stilb_vec3 normal;            /* shading normal, unit, on that side too */
	stilb_vec3 diffuse, specular; /* reflectance, textures included */
	stilb_vec3 emission;          /* towards the ray: 0 on the back */
	float roughness, anisotropy;
	float error; /* how far off the triangle, along geometric, the position may be and a ray still meet it, metres */
	stilb_vec2 uv;
	uint32_t part, triangle;
	bool front;
} gi_surface;

#define GI_NORMAL_NONE 1e-12f  /* square of an interpolated normal: below this the triangle's own counts */
#define GI_NORMAL_LOWEST 1e-3f /* cosine of the shading normal to the viewer, at least */

/* gi_is_hit(ray) holds. */
void gi_surface_at(const stilb_gi_scene *scene, const gi_ray_hit *ray, gi_surface *surface);

/* Where a ray into direction starts, so that it neither meets this triangle again nor passes through another: position
 * moved along geometric, to the side of direction, by the error and no more. With it every ray has t_min = 0. */
stilb_vec3 gi_surface_ray_origin(const gi_surface *surface, stilb_vec3 direction);

/* gi_triangle.error. */
float gi_triangle_shape_error(const float v0[3], const float v1[3], const float v2[3]);

/* gi_surface.error for any point of a triangle in the world's space. */
float gi_triangle_error(const float v0[3], const float v1[3], const float v2[3]);

/* t_max of a shadow ray to a point at this distance on a triangle of that error, which the ray meets under this cosine > 0:
 * so short of it that it does not meet the triangle, and no shorter. The direction's own rounding counts too. */
static inline float gi_shadow_distance(float distance, float error, float cosine)
{
	STILB_ASSERT(distance >= 0.0f && error >= 0.0f && cosine >= 0.0f);
	float end = distance - (error + 0x1p-21f * distance) / cosine;
	return end > 0.0f ? end : 0.0f;
}

#endif
