/*
 * The bytes of a frame dump, version 15. Inside render/.
 *
 * Little endian, IEEE 754 floats; all padding is in named members and zero. There is no table of contents: the offset
 * of each part and the length of the file follow from the header's counts, and a file of any other length is refused.
 * Each part is padded with zeros to a multiple of 8 bytes.
 *
 *   part       bytes each  how many              contents
 *   header            152  1                     render_dump_header
 *   views             168  header.views, 1..64   render_dump_view
 *   lights             96  header.lights         render_dump_light, of view 0, then of view 1, ...
 *   passes             88  header.passes, 1..64  render_dump_pass, in the order of the pass table
 *   targets            88  header.targets, 0..64 render_dump_target
 *   textures           16  header.textures       render_dump_texture, ids ascending, 1..4095
 *   materials          64  header.materials      render_dump_material, ids ascending, 0..2^24 - 1
 *   surfaces          760  header.surfaces       render_dump_surface, of the first material that has one, then of the
 *                                                next, ...
 *   functions         216  header.functions      render_dump_function, in the order in which surfaces name them first
 *   meshes             24  header.meshes         render_dump_mesh, ids ascending, 0..2^20 - 1
 *   levels             16  header.levels         render_dump_level, of mesh 0, then of mesh 1, ...
 *   segments            4  header.segments       number of draws of each segment; of pass 0, then of pass 1, ...
 *   draws              72  header.draws          render_dump_draw, as recorded: segment after segment
 *   vertices           32  header.vertices       the floats of stilb_scene_vertex_streams of mesh 0, then of 1, ...;
 *                                                of a mesh that morphs as many again: where they morph to. Normals as
 *                                                the device has them
 *   extras             24  header.extras         render_extra, of the vertices of the first mesh that has some, ...
 *   indices             4  header.indices        of mesh 0, of its levels, of its clusters' coarser versions, then of
 *                                                mesh 1, ...; below the number of vertices of the mesh or level
 *   pixels              1  header.pixel_bytes    of texture 0, top row first, four channels a pixel, or blocks, then
 *                                                its other levels; then of texture 1, ...; each padded to 8 bytes
 *   code                1  header.function_bytes SPIR-V of the functions, one code after the other
 *   backdrops           1  header.backdrop_bytes render_dump_backdrop of view 0, then of view 1, ...; then floats: the
 *                                                panorama, which all views with one share, top row first; of view 0 the
 *                                                map and the floor, then of view 1, ...; padded to 8 bytes together.
 *                                                0: the views show their sky and ground
 *   checksum            8  1                     FNV-1a 64 of all bytes before it
 *
 * "mesh 1" here, and the references of draws and materials, are positions in the tables above. The ids are those of the
 * renderer that saved the file: the stream hash covers them, and --materials pipeline depends on them.
 */
#ifndef STILB_RENDER_DUMP_FORMAT_H
#define STILB_RENDER_DUMP_FORMAT_H

#include "render/maps/render_functions.h"
#include "render/render_dump.h"
#include "render/render_resources.h"
#include "scene/scene_streams.h"

#define RENDER_DUMP_MAGIC "STILBDMP"
#define RENDER_DUMP_VERSION 15u
#define RENDER_DUMP_BYTE_ORDER 0x01020304u /* a little-endian file has the bytes 4 3 2 1 */
#define RENDER_DUMP_MAX_VIEWS 64u

typedef struct render_dump_header {
	char magic[8];
	uint32_t version, byte_order;
	uint64_t file_size;   /* bytes, the checksum included */
	uint64_t stream_hash; /* stilb_render_stream_hash of the frame */
	uint32_t width, height, samples;
	uint32_t output; /* stilb_render_output */
	uint32_t views, passes, segments, textures, materials, meshes;
	uint64_t draws, vertices, indices, pixel_bytes;
	uint32_t lights, backdrop_bytes, levels;
	uint32_t streams; /* render_dump_streams of the vertices' table */
	uint32_t targets, functions;
	uint64_t surfaces, extras, function_bytes;
} render_dump_header;

typedef struct render_dump_view {
	float view_projection[16];
	float camera_position[3];
	float sky[3], ground[3];
	float roughness, anisotropy, wrap, specular; /* the floats of stilb_render_shading */
	uint32_t brdf, ndf, g, f;                    /* its integers: constants of the shading headers */
	uint32_t lights;                             /* so many of the file's lights are this view's */
	uint32_t glossy;                             /* 0 or 1: stilb_scene_surroundings.glossy */
	uint32_t both_sides;                         /* 0 or 1: stilb_render_view.both_sides */
	float exposure;                              /* stops, -100..100 */
	uint32_t tone, dither;                       /* SHADE_TONE_..., stilb_render_dither */
	uint32_t target;                             /* 0: none, else 1 + its position in the table of targets */
	float time;                                  /* seconds, for functions of surfaces */
	uint32_t lighting;                           /* stilb_render_lighting, of _deferred.coverage << 8, .gbuffer << 16,
	                                                stilb_render_ambient << 24 */
	float light_tolerance, light_peak;           /* those of stilb_render_view */
	float light_fade;                            /* likewise */
	uint32_t light_fade_height;                  /* 1..16384, whatever the window of the replay; 0 without light_fade */
} render_dump_view;

/* The members of stilb_scene_light; a dump has no scene, so there is no face. */
typedef struct render_dump_light {
	uint32_t kind, unit, falloff, use, unused;
	float position[3], direction[3], intensity[3], cos_inner, cos_outer, radius, half_x[3], half_y[3], reach;
} render_dump_light;

/* Of a view: stilb_scene_backdrop, and the panorama of its surroundings. */
typedef struct render_dump_backdrop {
	uint32_t kind;                    /* stilb_scene_backdrop_kind */
	float color[3];                   /* radiance */
	float rotation;                   /* of the panorama, radians */
	uint32_t map, floor;              /* 0 or 1: the view has one, [32][64][3] and stilb_scene_floor */
	uint32_t width, height, channels; /* of the panorama; 0: the view has none */
} render_dump_backdrop;

typedef struct render_dump_pass {
	char name[64]; /* at most 63 bytes, padded with zeros */
	uint32_t view, order, sort;
	uint32_t segments;
	uint64_t draws;
} render_dump_pass;

/* The members of stilb_render_target. */
typedef struct render_dump_target {
	char name[56]; /* at most STILB_RENDER_TARGET_NAME bytes, padded with zeros */
	uint32_t kind, width, height, output;
	uint16_t place[4];
	uint32_t border, unused;
} render_dump_target;

typedef struct render_dump_texture {
	uint32_t id, width, height;
	uint32_t format;         /* stilb_image_format, but U16_SRGB */
	uint32_t levels, unused; /* mip levels that its picture had, 1 or more; further ones are made of the last */
} render_dump_texture;

typedef struct render_dump_material {
	uint32_t id;
	uint32_t texture; /* 0: none, else 1 + its position in the table of textures */
	float diffuse[3], specular[3];
	float roughness, anisotropy, wrap, emission[3];
	uint32_t impostor; /* 1: of an impostor, and the texture has its maps */
	uint32_t surface;  /* 0: none, else 1 + its position in the table of surfaces, and there is no texture */
} render_dump_material;

/* What a material has of its surface (maps/render_maps.h). */
typedef struct render_dump_surface {
	render_maps_record record;
	uint32_t bits;                  /* RENDER_MAPS_... but _EXTRAS */
	uint32_t textures[RENDER_MAPS]; /* 0: none, else 1 + its position in the table of textures */
	uint8_t samplers[RENDER_MAPS];  /* below RENDER_MAPS_SAMPLERS */
	uint8_t unused[1];
	uint32_t function; /* 0: none, else 1 + its position in the table of functions */
	float parameters[STILB_SCENE_PARAMETERS][4];
	uint32_t also_unused;
} render_dump_surface;

/* A stilb_scene_function. */
typedef struct render_dump_function {
	char name[STILB_SCENE_FUNCTION_NAME + 1]; /* padded with zeros */
	uint64_t shaders;
	uint32_t bytes[STILB_SCENE_FUNCTION_CODES]; /* of its codes */
} render_dump_function;

typedef struct render_dump_mesh {
	uint32_t id, vertices, indices; /* of the mesh itself */
	uint32_t levels;   /* so many of the file's levels are this mesh's; bit 31: it morphs; bit 30: it has clusters */
	uint32_t clusters; /* indices of their coarser versions */
	uint32_t extras;   /* 1: its vertices have extras */
} render_dump_mesh;

#define RENDER_DUMP_MORPHS (1u << 31)
#define RENDER_DUMP_CLUSTERS (1u << 30)

static inline uint32_t render_dump_mesh_levels(const render_dump_mesh *mesh)
{
	return mesh->levels & ~(RENDER_DUMP_MORPHS | RENDER_DUMP_CLUSTERS);
}

typedef struct render_dump_level {
	uint32_t indices, vertices; /* it uses the mesh's first ones */
	float error;                /* metres, >= 0, ascending */
	uint32_t unused;
} render_dump_level;

typedef struct render_dump_draw {
	uint64_t key;
	/* Positions in their tables, of meshes in bits 0..19, of materials in bits 0..23. Bits 20..25 of mesh: the level,
	 * 0: the mesh itself, RENDER_DUMP_SOME: some of its clusters. Bits 26..31 of mesh: render_command_detail; 24..31 of
	 * material: render_state_detail. */
	uint32_t mesh, material;
	float transform[12]; /* the three rows of the affine transform */
	/* RENDER_DUMP_SOME: where they are among the indices of the mesh itself and, behind these, those of its clusters'
	 * coarser versions; else 0. */
	uint32_t first_index, index_count;
} render_dump_draw;

#define RENDER_DUMP_SOME 63u

static inline uint32_t render_dump_draw_mesh(const render_dump_draw *draw)
{
	return draw->mesh & (STILB_RENDER_MAX_MESHES - 1);
}

static inline uint32_t render_dump_draw_material(const render_dump_draw *draw)
{
	return draw->material & (STILB_RENDER_MAX_MATERIALS - 1);
}

static inline uint32_t render_dump_draw_level(const render_dump_draw *draw)
{
	return draw->mesh >> 20 & 63u;
}

static_assert(sizeof(render_dump_header) == 152 && sizeof(render_dump_view) == 184 && sizeof(render_dump_light) == 96 &&
                  sizeof(render_dump_pass) == 88 && sizeof(render_dump_target) == 88 &&
                  sizeof(render_dump_texture) == 24 && sizeof(render_dump_material) == 64 &&
                  sizeof(render_dump_mesh) == 24 && sizeof(render_dump_level) == 16 && sizeof(render_dump_draw) == 72 &&
                  sizeof(render_dump_backdrop) == 40 && sizeof(stilb_scene_vertex) == 32,
              "the table above");

static_assert(sizeof(render_dump_surface) == 760 && sizeof(render_dump_function) == 216, "no padding");

typedef enum render_dump_part {
	RENDER_DUMP_HEADER,
	RENDER_DUMP_VIEWS,
	RENDER_DUMP_LIGHTS,
	RENDER_DUMP_PASSES,
	RENDER_DUMP_TARGETS,
	RENDER_DUMP_TEXTURES,
	RENDER_DUMP_MATERIALS,
	RENDER_DUMP_SURFACES,
	RENDER_DUMP_FUNCTIONS,
	RENDER_DUMP_MESHES,
	RENDER_DUMP_LEVELS,
	RENDER_DUMP_SEGMENTS,
	RENDER_DUMP_DRAWS,
	RENDER_DUMP_VERTICES,
	RENDER_DUMP_EXTRAS,
	RENDER_DUMP_INDICES,
	RENDER_DUMP_PIXELS,
	RENDER_DUMP_CODE,
	RENDER_DUMP_BACKDROPS,
	RENDER_DUMP_CHECKSUM,
	RENDER_DUMP_PARTS,
} render_dump_part;

/* What tells vertices of these streams from others: a hash of names, meanings, components and places. [any-thread] */
uint32_t render_dump_streams(const stilb_scene_streams *table);

/* Fills in the offset of each part, bytes; begin[RENDER_DUMP_PARTS] is the end of the file. False: more than 2^64
 * bytes. */
bool render_dump_layout(const render_dump_header *header, uint64_t begin[RENDER_DUMP_PARTS + 1]);

/* Bytes of a texture's pixels without the padding. The format must be valid and a side at most 16384. */
uint64_t render_dump_pixel_bytes(const render_dump_texture *texture);

/* A number of bytes with its padding: rounded up to a multiple of 8. */
static inline uint64_t render_dump_fill(uint64_t bytes)
{
	STILB_ASSERT(bytes <= UINT64_MAX - 7);
	return (bytes + 7) & ~(uint64_t)7;
}

/* A draw in the form in which it is recorded again. */
typedef struct render_dump_ready {
	stilb_mat4 transform;
	uint64_t key;
	stilb_render_mesh mesh;
	stilb_render_material material;
	uint32_t level, detail, kind;      /* see render_draw_level */
	uint32_t first_index, index_count; /* RENDER_DUMP_SOME: see render_draw_clusters */
} render_dump_ready;

/* A checked file in memory. */
struct stilb_render_dump {
	uint8_t *bytes; /* the file; the pointers below point into it */
	const render_dump_header *header;
	const render_dump_view *views;
	const render_dump_light *lights;
	const render_dump_pass *passes;
	const render_dump_target *targets;
	const render_dump_texture *textures;
	const render_dump_material *materials;
	const render_dump_surface *surfaces;
	const render_dump_function *functions;
	const uint8_t *code; /* of the functions */
	const render_dump_mesh *meshes;
	const render_dump_level *levels;
	const uint32_t *segments;
	const render_dump_draw *draws;
	const stilb_scene_vertex *vertices;
	const render_extra *extras;
	const uint32_t *indices;
	const uint8_t *pixels;
	const render_dump_backdrop *backdrops; /* [header->views] if header->backdrop_bytes > 0 */

	/* Made by stilb_render_dump_upload; NULL before. */
	stilb_render_pass pass_table[STILB_RENDER_MAX_PASSES];
	stilb_render_view view_table[RENDER_DUMP_MAX_VIEWS];
	stilb_render_target target_table[STILB_RENDER_MAX_PASSES];
	stilb_scene_light *light_table; /* [header->lights] */
	render_dump_ready *ready;       /* [header->draws] */
	uint32_t *first_draw; /* [header->segments + 1]: segment s has draws first_draw[s] .. first_draw[s + 1] - 1 */
};

/* A light of the file as one of a scene. [any-thread] */
stilb_scene_light render_dump_light_get(const render_dump_light *light);

/* render_dump_backdrop.c: the bytes of the part, for records whose panoramas have the same size. */
uint64_t render_dump_backdrop_bytes(const render_dump_backdrop *records, uint32_t views);

/* Fills in the records of the last frame's views. False: they show sky and ground alone, and need no records.
 * without_panorama: a view has one that frames do not show yet, or another than the first. */
bool render_dump_backdrops_fill(const stilb_render *render, const stilb_render_view *views, uint32_t count,
                                render_dump_backdrop *records, bool *without_panorama);

/* Writes the part, whose bytes are zero. */
void render_dump_backdrops_put(const render_dump_backdrop *records, const stilb_render_view *views, uint32_t count,
                               uint8_t *out);

/* Checks the part of a file whose header and views are sound. STILB_ERROR_FILE; the message is the reason alone. */
stilb_result render_dump_check_backdrops(const stilb_render_dump *dump);

/* Sets backdrop and panorama of a view, which point into the file's bytes. */
void render_dump_backdrop_get(const stilb_render_dump *dump, uint32_t view, stilb_render_view *out);

/* render_dump_surfaces.c; saving, under the lock of resources: the indices of the textures of a material's maps, 0:
 * none; false: it has no surface. */
bool render_dump_surface_textures(const render_resources *resources, uint32_t material, uint32_t textures[RENDER_MAPS]);
/* Index of the function of a material's surface; 0: it has none. */
uint32_t render_dump_surface_function(const render_resources *resources, uint32_t material);
/* Writes the surface of a material that has one; places, functions: of textures and functions in the file, by index. */
void render_dump_surface_put(const render_resources *resources, uint32_t material, const uint32_t *places,
                             const uint16_t *functions, render_dump_surface *out);
/* Writes the extras of a mesh, if it has some. Returns the end. */
render_extra *render_dump_extras_put(const render_resources *resources, uint32_t mesh, render_extra *out);

/* Checks surfaces and extras of a file whose other parts are sound. STILB_ERROR_FILE; the message is the reason alone.
 */
stilb_result render_dump_check_surfaces(const stilb_render_dump *dump);
/* How to make the texture at this position of the table: with mips if a surface names it, of the kind that it needs. */
render_texture_way render_dump_texture_way(const stilb_render_dump *dump, uint32_t texture);
/* The surface in a renderer whose textures and functions are these, by position. */
render_maps render_dump_surface_get(const stilb_render *render, const render_dump_surface *from,
                                    const stilb_render_texture *textures, const uint32_t *functions);

/* render_dump_functions.c: the functions of the materials that are saved. */
typedef struct render_dump_functions {
	uint32_t count;
	uint64_t bytes;                       /* of their code */
	uint16_t index[RENDER_MAX_FUNCTIONS]; /* [count] */
	uint16_t place[RENDER_MAX_FUNCTIONS]; /* by index: 1 + the position in `index`; 0: it is not saved */
} render_dump_functions;

/* Adds that of a material, if it has one that is not there. Under the lock of resources, as the next one. */
void render_dump_functions_note(const stilb_render *render, uint32_t material, render_dump_functions *functions);
/* Writes both parts. */
void render_dump_functions_put(const stilb_render *render, const render_dump_functions *functions,
                               render_dump_function *out, uint8_t *code);
/* Checks both parts. STILB_ERROR_FILE; the message is the reason alone. */
stilb_result render_dump_check_functions(const stilb_render_dump *dump);
/* Makes them; *indices: [header->functions]. */
stilb_result render_dump_functions_upload(const stilb_render_dump *dump, stilb_render *render, uint32_t *indices);

/* Checks a file in memory. Takes over bytes, which malloc made, and frees them on error. name is for the message. */
stilb_result render_dump_read(uint8_t *bytes, size_t size, const char *name, stilb_render_dump **dump);

#endif
