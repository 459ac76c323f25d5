/*
 * gi_world: what stands behind stilb_gi_scene, and the surface that a ray found. Read by the integrators. [any-thread]
 */
#ifndef STILB_GI_WORLD_H
#define STILB_GI_WORLD_H

#include "base/base_math.h"
#include "gi/gi_light.h"
#include "gi/gi_scene.h"
#include "gi/gi_trace.h"

/* Triangles in the world's space, or in the mesh's own where parts share it as instances. */
typedef struct gi_mesh {
	const float (*positions)[3];
	const float (*normals)[3]; /* of vertices */
	const float (*uvs)[2];
	const uint32_t (*triangles)[3];
	uint32_t vertex_count, triangle_count;
} gi_mesh;

#define GI_NO_LIGHT UINT32_MAX

typedef struct gi_part {
	uint32_t mesh, material;
	uint32_t first_light; /* of the material emits: its triangle k is light first_light + k; else GI_NO_LIGHT */
	bool instance;        /* transform is not yet in the mesh's numbers */
	stilb_mat4 to_world;
	float normal_to_world[9]; /* inverse transpose, columns */
} gi_part;

struct stilb_gi_scene {
	gi_tracer tracer;
	uint32_t mesh_count, part_count, material_count, texture_count;
	gi_mesh *meshes;
	gi_part *parts;
	stilb_scene_material *materials;
	const stilb_image *textures;
	gi_lights lights;
	stilb_gi_scene_info info;
	void *owned; /* memory behind the above: gi_scene.c's business */
};

/* The point where a ray ended, as shading needs it. */
typedef struct gi_surface {
	stilb_vec3 position;          /* on the triangle */
	stilb_vec3 geometric;         /* unit normal of the triangle, on the side the ray came from */
	stilb_vec3 normal;            /* shading normal, unit, on that side too */
	stilb_vec3 diffuse, specular; /* reflectance, textures included */
	stilb_vec3 emission;          /* towards the ray: 0 on the back */
	float roughness, anisotropy;
	float error; /* position is off the true triangle by at most this along geometric, metres */
	stilb_vec2 uv;
	uint32_t part, triangle;
	bool front;
} gi_surface;

/* gi_hit(ray) holds. */
void gi_surface_at(const stilb_gi_scene *scene, const RTCRayHit *ray, gi_surface *surface);

/* Where a ray into direction starts, so that it neither meets this triangle again nor passes through another: position
 * moved along geometric, to the side of direction, by more than its error. With it every ray has tnear = 0. */
stilb_vec3 gi_ray_origin(const gi_surface *surface, stilb_vec3 direction);

#endif
