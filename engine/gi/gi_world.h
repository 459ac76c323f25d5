/*
 * gi_world: what stands behind stilb_gi_scene, and the surface that a ray found. [any-thread]
 */
#ifndef STILB_GI_WORLD_H
#define STILB_GI_WORLD_H

#include "base/base_math.h"
#include "gi/gi_scene.h"
#include "gi/light/gi_light.h"
#include "gi/trace/gi_trace.h"

/* Counter-clockwise seen from the front. */
typedef struct gi_triangle {
	uint32_t vertex[3];
	float error; /* of a hit's distance from the plane, as far as the triangle's shape decides: metres, in its space */
} gi_triangle;

/* Triangles in the world's space, or in the mesh's own where parts share it as instances; none is degenerate. A vertex is 32
 * bytes and lies on a multiple of that. A normal is unit, or 0 where the file's is none: then the triangle's own counts. */
typedef struct gi_mesh {
	const stilb_scene_vertex *vertices;
	const gi_triangle *triangles;
	uint32_t vertex_count, triangle_count;
	uint32_t invalid_count; /* triangles left out because a corner is NaN, infinite, too far away or missing */
	float low[3], high[3];  /* the box around its triangles; low > high: there are none */
} gi_mesh;

#define GI_NO_LIGHT UINT32_MAX

typedef struct gi_part {
	const stilb_scene_vertex *vertices; /* of its mesh */
	const gi_triangle *triangles;
	uint32_t mesh, material;
	uint32_t first_light; /* if the material emits: its triangle k is light first_light + k; else GI_NO_LIGHT */
	bool instance;        /* of a mesh in its own space; emitting parts are none */
	bool plain;           /* neither that nor textured */
	float albedo[4];      /* plain: diffuse + specular */
	float stretch;        /* instance: to_world makes nothing longer than so many times */
	stilb_mat4 to_world;
	float normal_to_world[9]; /* transposed inverse, columns */
} gi_part;

struct stilb_gi_scene {
	const stilb_gi_intersector *intersector;
	gi_tracer tracer;
	uint32_t mesh_count, part_count, material_count, texture_count;
	gi_mesh *meshes;
	gi_part *parts;
	stilb_scene_material *materials;
	const stilb_image *textures;
	gi_lights lights;
	stilb_gi_scene_info info;
	stilb_scene_vertex *vertices; /* of all meshes */
	gi_triangle *triangles;
};

/* What an intersector is: it fills tracer for a world whose meshes and parts are made. destroy accepts {0}. */
struct stilb_gi_intersector {
	const char *name;
	stilb_result (*create)(const stilb_gi_scene *world, const stilb_gi_scene_desc *desc, gi_tracer *tracer,
	                       stilb_gi_scene_info *info);
	void (*destroy)(gi_tracer *tracer);
};

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
	float end = distance - (error + 0x1p-21f * distance) / cosine;
	return end > 0.0f ? end : 0.0f;
}

#endif
