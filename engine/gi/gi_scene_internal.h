/*
 * gi_scene_internal: the scene as rays see it: meshes, parts, materials, lights, and what an intersector is. Written while
 * it is created, then read by any thread.
 */
#ifndef STILB_GI_SCENE_INTERNAL_H
#define STILB_GI_SCENE_INTERNAL_H

#include "base/base_contract.h"
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
	stilb_owner owner; /* the thread that created it */
	const stilb_gi_intersector *intersector;
	gi_tracer tracer;
	uint32_t mesh_count, part_count, material_count, texture_count;
	gi_mesh *meshes;
	gi_part *parts;
	stilb_scene_material *materials;
	const stilb_image *textures;
	gi_lights lights;
	stilb_gi_scene_info info;
	stilb_scene_vertex *vertices; /* of all meshes, in their order */
	gi_triangle *triangles;       /* the same */
};

/* What an intersector is: it fills tracer for a scene whose meshes and parts are made. destroy accepts {0}. */
struct stilb_gi_intersector {
	const char *name;
	stilb_result (*create)(const stilb_gi_scene *gi, const stilb_gi_scene_desc *desc, gi_tracer *tracer,
	                       stilb_gi_scene_info *info);
	void (*destroy)(gi_tracer *tracer);
};

#endif
