/*
 * Surfaces of a scene (scene/scene_surface.h) as the device has them. Inside render/.
 *
 * Maps.      What a material with a surface has besides its constants: a record that shaders read by address, and
 *            layers of a set of images, in the order of stilb_scene_map_kind: the first RENDER_MAPS_PLAIN ones, or of
 *            materials with RENDER_MAPS_LAYERS all. A map that is missing is a white texel that no shader reads: what a
 *            program reads is compiled into it (RENDER_MAPS_...).
 * Owner.     Each material owns its maps; they come, change and go with it. The images are those of its group.
 * Extras.    Tangents, second uv and colours of vertices lie in a heap of their own, in the order of the vertices. A
 *            table by mesh says where a mesh's begin. Meshes without extras have nothing there.
 * Layers.    Clear coat, sheen, brushed metal, transmission (shading/shade_layers.h), and the maps that only they or
 *            tinted highlights have. Their programs have shaders of their own: what a material without them costs does
 *            not change.
 */
#ifndef RENDER_MAPS_H
#define RENDER_MAPS_H

#include "gpu/gpu.h"
#include "render/render.h"
#include "scene/scene_surface.h"

#define RENDER_MAPS 15u
#define RENDER_MAPS_PLAIN 5u /* color, reflection, normal, occlusion, emission */

static_assert(STILB_SCENE_MAPS == RENDER_MAPS && STILB_SCENE_MAP_EMISSION + 1 == RENDER_MAPS_PLAIN, "maps of surfaces");

/* A material's maps at most. */
#define RENDER_MAX_MAPS (1u << 20)

/* What a program is compiled for. Bits 0 .. RENDER_MAPS - 1: 1 << stilb_scene_map_kind of each map that there is. */
#define RENDER_MAPS_MASK (1u << 15)
#define RENDER_MAPS_BLEND (1u << 16)
#define RENDER_MAPS_ONE_SIDED (1u << 17)
#define RENDER_MAPS_UNLIT (1u << 18)
#define RENDER_MAPS_SPECULAR (1u << 19) /* STILB_SCENE_SPECULAR */
#define RENDER_MAPS_TWO (1u << 20)      /* the map of normals has two channels: red, and what is alpha on the device */
#define RENDER_MAPS_TOGETHER (1u << 21) /* all maps lie in one way: one place is enough */
#define RENDER_MAPS_LAYERS (1u << 22)   /* one of the next five, or a map behind the first RENDER_MAPS_PLAIN */
#define RENDER_MAPS_COAT (1u << 23)
#define RENDER_MAPS_SHEEN (1u << 24)
#define RENDER_MAPS_BRUSHED (1u << 25)  /* anisotropy */
#define RENDER_MAPS_THROUGH (1u << 26)  /* transmission */
#define RENDER_MAPS_SOLID (1u << 27)    /* besides _THROUGH: it has a thickness */
#define RENDER_MAPS_COAT_TWO (1u << 28) /* as _TWO, of the coat */
#define RENDER_MAPS_SPREAD (1u << 29)   /* the map of normals is of RENDER_MIPS_NORMALS or _TWO */
#define RENDER_MAPS_COAT_SPREAD (1u << 30)
#define RENDER_MAPS_EXTRAS (1u << 31) /* of the mesh: its vertices have extras. No material has it */
#define RENDER_MAPS_FUNCTION_SHIFT 32 /* above: the index of its function (render_functions.h); 0: there is none */

/* How a map lies on the surface. */
typedef struct render_maps_place {
	float to_u[3], set; /* set: 0 or 1 */
	float to_v[3];
	uint32_t name; /* 1 + the texture's id in the scene; 0: it has none. No shader reads it */
} render_maps_place;

/* As shaders read it (shaders/maps.glsl). */
typedef struct render_maps_record {
	float color[4];
	float specular[3]; /* METALLIC: the dielectric's reflectance at normal incidence; with maps of it before it is
	                      limited to 1 and weighted */
	float roughness;
	float emission[3], metalness;
	float normal_scale, occlusion, cutoff, ior;
	float coat, coat_roughness, coat_normal_scale;
	float specular_weight; /* what specular lacks: 1 without maps of it */
	float sheen[3], sheen_roughness;
	float brushed, brushed_turn[2]; /* anisotropy; cosine and sine of its rotation */
	float transmission;
	float absorption[3]; /* per metre of the mesh's space */
	float thickness;
	render_maps_place places[RENDER_MAPS];
} render_maps_record;

static_assert(sizeof(render_maps_record) == 128 + 32 * RENDER_MAPS, "std430: vec4s");

static inline uint32_t render_maps_function(uint64_t bits)
{
	return (uint32_t)(bits >> RENDER_MAPS_FUNCTION_SHIFT);
}

/* With what the device knows alone: so it lies in its heap. */
typedef struct render_maps_stored {
	render_maps_record record;
	float layers[RENDER_MAPS], unused;           /* of the images of its group (render_groups.h) */
	float parameters[STILB_SCENE_PARAMETERS][4]; /* of its function */
} render_maps_stored;

static_assert(sizeof(render_maps_stored) == 736, "std430: MAPS_PARTS vec4s");

/* What is made of a surface. */
typedef struct render_maps {
	render_maps_record record;
	uint64_t bits; /* RENDER_MAPS_... */
	float parameters[STILB_SCENE_PARAMETERS][4];
	uint64_t function_hash;         /* render_function.hash; 0: there is none */
	uint32_t textures[RENDER_MAPS]; /* stilb_render_texture.id; 0: none */
	uint8_t samplers[RENDER_MAPS];  /* wrap_u + 3 wrap_v + 9 nearest: below RENDER_MAPS_SAMPLERS */
} render_maps;

#define RENDER_MAPS_SAMPLERS 18u

/* Without textures and function. channels: of the textures of normals and of the coat's normals; 0: there is none.
 * [any-thread] */
render_maps render_maps_make(const stilb_scene_surface *surface, uint32_t channels, uint32_t coat_channels);

/* What the program of a draw is compiled for: its maps' bits; whether its vertices have extras; whether triangles are
 * seen from both sides; whether depth alone is drawn, where RENDER_MAPS_BLEND stands for a draw that is left out, and 0
 * for one that needs nothing of its maps. [any-thread] */
uint64_t render_maps_program_bits(uint64_t bits, bool extras, bool sides, bool depth);

/* What the stream hash has of them. [any-thread] */
uint64_t render_maps_hash(const render_maps *maps);

/* The entry of a material's maps. */
typedef struct render_maps_slot {
	uint64_t hash;
	uint64_t bits;
	uint32_t group; /* 1 + that which its material is in; 0: none */
	uint32_t textures[RENDER_MAPS];
	uint8_t samplers[RENDER_MAPS];
} render_maps_slot;

/* ---- extras of vertices ------------------------------------------------------------------------------------------ */

/* A vertex's extra as shaders read it. */
typedef struct render_extra {
	uint32_t tangent; /* as packed normals have it (render_vertex.h) */
	float sign;       /* 1, -1; 0: there is no tangent */
	float uv[2];
	uint16_t color[4]; /* halves */
} render_extra;

static_assert(sizeof(render_extra) == 24, "std430: three uvec2");

/* Where a mesh's extras are: that of vertex number v of the heap is number extra + ((v - vertex) >> pairs). */
typedef struct render_extra_place {
	uint32_t vertex;
	uint32_t extra_pairs; /* bit 31: pairs, 1 for a mesh whose vertices lie in pairs */
} render_extra_place;

#define RENDER_EXTRA_PAIRS (1u << 31)

/* [any-thread] */
void render_extras_pack(const stilb_scene_vertex_extra *extras, size_t count, render_extra *out);
/* The inverse, but for what packing rounds; packing the result again gives the same bytes. [any-thread] */
void render_extras_unpack(const render_extra *packed, size_t count, stilb_scene_vertex_extra *out);

/* ---- mips -------------------------------------------------------------------------------------------------------- */

/* How many mips a picture of that size has, down to one texel. */
uint32_t render_mip_count(uint32_t width, uint32_t height);

/* Texels of so many levels of such a picture. */
uint64_t render_mip_texels(uint32_t width, uint32_t height, uint32_t levels);

/* A table is asked for sRGB codes: at least 255 * 12.92 steps, so that a step has one border at most. */
#define RENDER_MIPS_STEPS 4096u

/* What mips hold. */
typedef enum render_mips_kind {
	RENDER_MIPS_MEANS,
	/* Means; and in the place of alpha, which nothing reads of a map of normals: 1 - the spread of the normals, [0, 1],
	 * which shade_gltf_widened takes. */
	RENDER_MIPS_NORMALS,
	RENDER_MIPS_NORMALS_TWO, /* of a map of two channels, red and alpha: in the place of green */
} render_mips_kind;

/* How light becomes codes of a format, and those of 8 bits light. */
typedef struct render_mips_codes {
	stilb_image_format format;
	render_mips_kind kind;
	stilb_render_specular_aa spread; /* how the normals' variance becomes a spread */
	float variances[256]; /* U8 and a kind of normals: of the normals of a texel, by the code of its spread */
	/* U8_SRGB: the light from which on a code is that or more; of code 0: below all; [256]: above all. */
	float borders[257];
	uint8_t first[RENDER_MIPS_STEPS + 1]; /* the code of light i / RENDER_MIPS_STEPS */
	float lights[2][256];                 /* U8: of red, green and blue; of alpha */
} render_mips_codes;

/* spread: not OFF for a kind of normals, whose formats are not U8_SRGB. */
void render_mips_codes_make(stilb_image_format format, render_mips_kind kind, stilb_render_specular_aa spread,
                            render_mips_codes *codes);

/* Writes "no spread" where mips of that kind have it: what the picture itself has. Four channels. [any-thread] */
void render_mips_prepare(const stilb_image *image, render_mips_kind kind);

/* Makes rows begin .. end - 1 of the mip `to` after `from`: pictures of four channels in the format of codes, no
 * U16_SRGB and no blocks. A texel is the mean of those that it covers, in light; where `from` has an odd number, of
 * three in a row by how much of each. pool: whose threads help, the caller is its owner; NULL: the caller works alone.
 * [any-thread] */
void render_mips_rows(const render_mips_codes *codes, const stilb_image *from, uint32_t begin, uint32_t end,
                      stilb_job_pool *pool, const stilb_image *to);

#endif
