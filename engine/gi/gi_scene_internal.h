/*
 * gi_scene_internal: the scene in the form that rays are traced in: meshes, parts, materials, lights, and the
 * interface of intersectors. Written by stilb_gi_scene_create and _update, then read by any thread.
 */
#ifndef STILB_GI_SCENE_INTERNAL_H
#define STILB_GI_SCENE_INTERNAL_H

#include "base/base_contract.h"
#include "base/base_math.h"
#include "gi/gi_scene.h"
#include "gi/light/gi_light.h"
#include "gi/trace/gi_trace.h"

/* A triangle of a gi_mesh. Its corners are counter-clockwise seen from its front. */
typedef struct gi_triangle {
	uint32_t vertex[3]; /* indices in the mesh's vertices */
	float error;        /* gi_triangle_shape_error, metres in the mesh's space */
} gi_triangle;

/* Triangles in world space, or in the mesh's own space if instances share it; none is degenerate. A vertex is 32
 * bytes and aligned to 32. Its normal is unit, or 0 if the file has none: then the triangle's normal is used. */
typedef struct gi_mesh {
	const stilb_scene_vertex *vertices;
	/* [vertex_count] in the same space; a tangent is unit, or 0 if there is none. NULL: the mesh has none. */
	const stilb_scene_vertex_extra *extras;
	const gi_triangle *triangles;
	uint32_t vertex_count, triangle_count;
	uint32_t triangle_room; /* triangles that its array has room for: those that it was made of */
	uint32_t invalid_count; /* triangles left out because a corner is NaN, infinite, too far away or missing */
	uint32_t source;        /* index in the scene of the mesh that it was made of; STILB_SCENE_NONE: of none */
	bool colored;           /* the vertices have colours */
	bool sieved;            /* some part of it has gi_part.sieve */
	bool fresh;             /* the update that runs has made it anew, with its place in the arrays */
	float low[3], high[3];  /* box around its triangles; low > high: there are none */
} gi_mesh;

#define GI_NO_LIGHT UINT32_MAX

typedef struct gi_part {
	const stilb_scene_vertex *vertices; /* those of its mesh, as extras and triangles are */
	const stilb_scene_vertex_extra *extras;
	const gi_triangle *triangles;
	uint32_t mesh, material;
	uint32_t surface;     /* 1 + the index in surfaces of what is read at each point; 0: the material is all */
	uint32_t sieve;       /* the same of one that rays may go through: gi_cover.h; 0: rays end at the part */
	uint32_t first_light; /* of an emitting part: its triangle k is emitter first_light + k; else GI_NO_LIGHT */
	bool instance;        /* triangles are in the mesh's space, not in the world's; false for all emitting parts */
	bool hidden;          /* rays do not see it */
	uint32_t mask;        /* GI_MASK_... of the rays that meet it; GI_MASK_ALL: its model is seen and casts shadows */
	uint32_t lit_by;      /* the mask of rays from it towards lights: GI_MASK_LIGHT, or 0: it receives no shadows */
	bool passes;          /* light goes through it: gi_through.h */
	bool mirrored;        /* an instance whose to_world turns right hands into left ones */
	bool plain;           /* not textured: gi_primary shades it without calling gi_surface_at */
	float albedo[4];      /* of a plain part: diffuse + specular */
	float stretch;        /* of an instance: upper bound of the factor by which to_world lengthens a vector */
	stilb_mat4 to_world;
	float normal_to_world[9]; /* transposed inverse of to_world, column by column */
} gi_part;

#define GI_SURROUNDINGS_TEXT 160

/* Whether a texture has light in it. */
typedef enum gi_darkness { GI_DARKNESS_UNKNOWN, GI_DARKNESS_DARK, GI_DARKNESS_NONE } gi_darkness;

/* What was found of textures and of triangles that glow. Updates keep it, those that build all else anew too. */
typedef struct gi_found {
	stilb_image *textures; /* [texture_count] those of the scene as rays read them: gi_scene_textures.h */
	bool *decoded;         /* [texture_count] the texture's pixels are its own */
	uint32_t texture_count;
	uint64_t textures_hash; /* of the scene's */
	uint8_t *dark;          /* [dark_count] of the scene's textures: gi_darkness */
	uint32_t dark_count;
	uint64_t dark_hash;  /* of the textures that this was found of */
	float (*means)[3];   /* [emitter_count] of glows */
	uint64_t means_hash; /* of all that they are means of; 0: there are none */
} gi_found;

typedef struct gi_backdrop gi_backdrop; /* integrate/gi_backdrop.h */

struct stilb_gi_scene {
	stilb_owner owner; /* the thread that created it */
	const stilb_gi_intersector *intersector;
	gi_tracer tracer;
	const struct gi_lanes_kernels *lanes; /* for the instruction set of this CPU, or the one that is asked for */
	bool passes;                          /* some part has gi_part.passes */
	bool flagged; /* some part has other masks than most: lights are found by other rays than surfaces are */
	bool blends;  /* some part lets rays through by chance, so that they need a number: gi_ray.time */
	uint32_t mesh_count, part_count, material_count, surface_count, texture_count;
	gi_mesh *meshes;
	gi_part *parts;
	stilb_scene_material *materials; /* of one that has a surface the constants are the surface's, without its maps */
	stilb_scene_surface *surfaces;
	const stilb_image *textures; /* found.textures */
	gi_lights lights;
	gi_lights open_lights;                   /* of settings.no_shadows */
	gi_backdrop *backdrop;                   /* never NULL */
	char surroundings[GI_SURROUNDINGS_TEXT]; /* in words, for files */
	stilb_gi_scene_info info;
	stilb_scene_vertex *vertices;     /* of all meshes, in their order */
	stilb_scene_vertex_extra *extras; /* of those that have them */
	uint64_t extra_count;
	gi_triangle *triangles; /* likewise of all */
	uint64_t own_bytes;     /* of these arrays, meshes and parts */
	uint32_t emitter_count; /* triangles of parts that are lights, those that do not glow included */
	/* What it was made of, and how, for updates. */
	gi_found found;
	bool movable, broken;     /* broken: the last update failed */
	uint64_t geometry, poses; /* the scene's counts of changes of its meshes: without those by poses, and these */
	uint64_t lights_hash;     /* of all that lights were made of */
	uint32_t lacking[STILB_SCENE_MAX_FUNCTIONS / 32 + 1]; /* by id, a bit each: that a function is left out was told */
};

/* An intersector: a method to find what rays hit. create builds its acceleration structure for a scene whose meshes and
 * parts are complete, and fills tracer and info's build_s, isa and bytes. After an error of create the caller calls
 * destroy as well, which accepts {0}. */
struct stilb_gi_intersector {
	const char *name;
	stilb_result (*create)(const stilb_gi_scene *gi, const stilb_gi_scene_desc *desc, gi_tracer *tracer,
	                       stilb_gi_scene_info *info);
	/* After these parts have moved, been hidden or shown again, or have a mesh with gi_mesh.fresh, of which all parts
	 * are among them; in a scene that is not movable meshes alone are others. Lights have been made anew. Only destroy
	 * may follow an error. */
	stilb_result (*update)(const stilb_gi_scene *gi, const uint32_t *moved, uint32_t moved_count,
	                       const stilb_gi_scene_desc *desc, gi_tracer *tracer, stilb_gi_scene_info *info);
	void (*destroy)(gi_tracer *tracer);
};

#endif
