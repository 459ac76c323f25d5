/*
 * scene_surface: what a material has beyond constants, as files mean it: maps, alpha, clear coat, sheen, transmission.
 * The members and their ranges are those of glTF 2.0 and its extensions KHR_materials_*, KHR_texture_transform.
 *
 * Use.         stilb_scene_material.surface names one of stilb_scene.surfaces. The material's own constants are then
 *              the means of what the surface says: who reads no maps (impostors, the meter) goes by them; whoever draws
 *              or traces the surface does not. shade_gltf.h turns factors and texels into what is shaded.
 * Spaces.      A map takes one of two places of a vertex, stilb_scene_vertex.uv or stilb_scene_vertex_extra.uv, by a
 *              transform of its own. The maps of normals are in the frame of stilb_scene_vertex_extra.tangent; without
 *              one they are left out.
 * Colour.      Maps of colours are pictures of colours, sRGB or linear floats; the others hold data
 *              (STILB_IMAGE_U8_LINEAR, ...) whose codes are the numbers.
 * Threads.     Plain data, as of scene.h. [any-thread]
 */
#ifndef STILB_SCENE_SURFACE_H
#define STILB_SCENE_SURFACE_H

#include "base/base.h"
#include "scene/function/scene_function.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* What a map does to a place outside of [0, 1]. */
typedef enum stilb_scene_wrap {
	STILB_SCENE_REPEAT,
	STILB_SCENE_MIRROR, /* every second time turned over */
	STILB_SCENE_CLAMP,  /* to the outermost texel */
	STILB_SCENE_WRAPS,
} stilb_scene_wrap;

/* A texture on a surface. */
typedef struct stilb_scene_map {
	uint32_t texture;       /* 1 + the index in stilb_scene.textures; 0: there is none, and all its channels are 1 */
	uint8_t set;            /* 0: the place is the vertex's uv, 1: its extra's */
	uint8_t wrap_u, wrap_v; /* stilb_scene_wrap */
	bool nearest;           /* seen from near, texels are squares; false: bilinear */
	float to_u[3], to_v[3]; /* where on the texture: u = to_u . (place, 1), v = to_v . (place, 1); within 1e6 */
} stilb_scene_map;

/* The maps of a surface, and the channels that count: X(ENUM, identifier, channels, is of colours). */
#define STILB_SCENE_MAPS_OF_SURFACES(X)                                                                                \
	X(COLOR, color, "rgb multiplies color, a alpha", true)                                                             \
	X(REFLECTION, reflection, "METALLIC: g multiplies roughness, b metalness; SPECULAR: rgb specular, a gloss", false) \
	X(NORMAL, normal, "rgb from 0..1 to -1..1: along tangent, bitangent, normal; of two channels the third is made",   \
	  false)                                                                                                           \
	X(OCCLUSION, occlusion, "r: the share of even light that arrives; frames alone", false)                            \
	X(EMISSION, emission, "rgb multiplies emission", true)                                                             \
	X(CLEARCOAT, clearcoat, "r multiplies clearcoat", false)                                                           \
	X(CLEARCOAT_ROUGHNESS, clearcoat_roughness, "g multiplies clearcoat_roughness", false)                             \
	X(CLEARCOAT_NORMAL, clearcoat_normal, "as NORMAL, of the coat", false)                                             \
	X(SPECULAR, specular, "a multiplies specular_weight", false)                                                       \
	X(SPECULAR_COLOR, specular_color, "rgb multiplies specular", true)                                                 \
	X(SHEEN_COLOR, sheen_color, "rgb multiplies sheen_color", true)                                                    \
	X(SHEEN_ROUGHNESS, sheen_roughness, "a multiplies sheen_roughness", false)                                         \
	X(ANISOTROPY, anisotropy, "rg from 0..1 to -1..1: direction, turned by anisotropy_rotation; b multiplies it",      \
	  false)                                                                                                           \
	X(TRANSMISSION, transmission, "r multiplies transmission", false)                                                  \
	X(THICKNESS, thickness, "g multiplies thickness", false)

#define STILB_SCENE_MAP_ENUM(id, name, channels, is_color) STILB_SCENE_MAP_##id,
typedef enum stilb_scene_map_kind {
	STILB_SCENE_MAPS_OF_SURFACES(STILB_SCENE_MAP_ENUM) STILB_SCENE_MAPS
} stilb_scene_map_kind;
#undef STILB_SCENE_MAP_ENUM

/* How colour and reflectance are given. */
typedef enum stilb_scene_workflow {
	STILB_SCENE_METALLIC, /* color is of a metal's highlight or of a non-metal's diffuse light, by metalness */
	STILB_SCENE_SPECULAR, /* color is diffuse, specular is the highlight's: KHR_materials_pbrSpecularGlossiness */
	STILB_SCENE_WORKFLOWS,
} stilb_scene_workflow;

typedef enum stilb_scene_alpha {
	STILB_SCENE_OPAQUE,
	STILB_SCENE_MASK,  /* nothing is there where alpha < cutoff */
	STILB_SCENE_BLEND, /* covers what is behind it by alpha, light and highlight alike */
	STILB_SCENE_ALPHAS,
} stilb_scene_alpha;

typedef struct stilb_scene_surface {
	stilb_scene_map maps[STILB_SCENE_MAPS];
	stilb_scene_workflow workflow;
	float color[4];        /* [0, 1]; the fourth is alpha */
	float metalness;       /* [0, 1]; METALLIC */
	float roughness;       /* [0, 1]; SPECULAR: 1 - gloss, and the map's gloss multiplies 1 - roughness */
	float specular[3];     /* METALLIC: tints the dielectric's reflectance at normal incidence, >= 0. SPECULAR: that
	                         reflectance, [0, 1] */
	float specular_weight; /* [0, 1] METALLIC: multiplies the dielectric's reflectance, also at grazing angles */
	float ior;             /* of the dielectric, >= 1, 1.5 if a file does not say; 0: reflects as a mirror would */
	float emission[3];     /* radiance, >= 0 */
	float normal_scale;    /* multiplies a normal's x and y before it is unit */
	float occlusion;       /* [0, 1]: how strong the map of occlusion is */
	stilb_scene_alpha alpha;
	float cutoff;                          /* of MASK, >= 0 */
	bool one_sided;                        /* nothing is seen of it from behind */
	bool unlit;                            /* shows color, whatever the light: KHR_materials_unlit */
	float anisotropy, anisotropy_rotation; /* [0, 1]; radians from the tangent, counter-clockwise */
	float clearcoat, clearcoat_roughness;  /* [0, 1] */
	float clearcoat_normal_scale;
	float sheen_color[3], sheen_roughness; /* [0, 1] */
	float transmission;                    /* [0, 1]: the share of diffuse light that goes through instead */
	float thickness;            /* metres in the mesh's space, >= 0; 0: a thin wall, at which light does not turn */
	float attenuation[3];       /* what is left of light after attenuation_distance inside, (0, 1] */
	float attenuation_distance; /* metres, > 0; INFINITY: nothing is absorbed */
	/* Frames alone have what follows. The program's own function, which changes what all of the above says, and what it
	 * is given (scene_function.h). */
	uint32_t function; /* 1 + the index in stilb_scene.functions; 0: there is none */
	float parameters[STILB_SCENE_PARAMETERS][4];
} stilb_scene_surface;

/* A rough white dielectric without maps: each member is what glTF says where a file says nothing, but for metalness 0;
 * maps without texture lie on the first uv as it is, and repeat. [any-thread] */
stilb_scene_surface stilb_scene_surface_make(void);

/* The names of the maps by stilb_scene_map_kind: "color", "reflection", ... NULL-terminated. */
extern const char *const stilb_scene_map_names[];

/* True if the kind's texture is of colours in surfaces of this workflow. [any-thread] */
bool stilb_scene_map_is_color(stilb_scene_map_kind kind, stilb_scene_workflow workflow);

/* What is wrong with a surface's members, in words; NULL: nothing. Does not look at textures and functions.
 * [any-thread] */
const char *stilb_scene_surface_mistake(const stilb_scene_surface *surface);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
