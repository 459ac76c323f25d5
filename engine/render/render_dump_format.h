/*
 * The bytes of a frame dump, version 2. Inside render/.
 *
 * Little endian, IEEE 754 floats; no padding but what is named, and that is zero. The parts follow each other without a
 * table: where each begins and how long the file is follow from the header's counts, and a file of any other length is
 * refused. Each part is filled up with zeros to a multiple of 8 bytes.
 *
 *   part       bytes each  how many              what
 *   header            104  1                     render_dump_header
 *   views             208  header.views, 1..16   render_dump_view
 *   passes             96  header.passes, 1..16  render_dump_pass, in the order of the pass table
 *   textures           16  header.textures       render_dump_texture, ids ascending, 1..4095
 *   materials          48  header.materials      render_dump_material, ids ascending, 0..2^24 - 1
 *   meshes             16  header.meshes         render_dump_mesh, ids ascending, 0..2^20 - 1
 *   segments            4  header.segments       draws of the segment; those of pass 0, then of pass 1, ...
 *   draws              64  header.draws          render_dump_draw, as recorded: segment after segment
 *   vertices           32  header.vertices       position (3 floats), normal (3), uv (2) of mesh 0, then of 1, ...
 *   indices             4  header.indices        of mesh 0, then of mesh 1, ...; below its vertex count
 *   pixels              1  header.pixel_bytes    four channels a pixel, top row first; each texture filled to 8 bytes
 *   checksum            8  1                     FNV-1a 64 of all bytes before it
 *
 * "mesh 1" here and in draws and materials is a place in the tables above; ids are what the stream hash covers, and
 * what --materials pipeline goes by.
 */
#ifndef STILB_RENDER_DUMP_FORMAT_H
#define STILB_RENDER_DUMP_FORMAT_H

#include "render/render_dump.h"

#define RENDER_DUMP_MAGIC "STILBDMP"
#define RENDER_DUMP_VERSION 2u
#define RENDER_DUMP_BYTE_ORDER 0x01020304u /* the bytes 4 3 2 1 */
#define RENDER_DUMP_MAX_VIEWS 16u

typedef struct render_dump_header {
	char magic[8];
	uint32_t version, byte_order;
	uint64_t file_size;   /* bytes, the checksum included */
	uint64_t stream_hash; /* stilb_render_stream_hash of the frame */
	uint32_t width, height, samples;
	uint32_t output; /* stilb_render_output */
	uint32_t views, passes, segments, textures, materials, meshes;
	uint64_t draws, vertices, indices, pixel_bytes;
} render_dump_header;

typedef struct render_dump_view {
	float view_projection[16];
	float camera_position[3];
	float sun_direction[3], sun_irradiance[3];
	float sky[3], ground[3];
	float lamp_position[3], lamp_axis[3], lamp_intensity[3], lamp_radius, lamp_reach;
	float roughness, anisotropy, wrap, specular; /* of stilb_render_shading: added to every material's */
	uint32_t brdf, ndf, g, f, light;             /* the same: numbers of the shading headers */
	uint32_t unused;
} render_dump_view;

typedef struct render_dump_pass {
	char name[64]; /* ends with at least one zero, zeros to the end */
	uint32_t view, target, order, sort;
	uint32_t segments, unused;
	uint64_t draws;
} render_dump_pass;

typedef struct render_dump_texture {
	uint32_t id, width, height;
	uint32_t format; /* stilb_image_format */
} render_dump_texture;

typedef struct render_dump_material {
	uint32_t id;
	uint32_t texture; /* 0: none, else 1 + its place */
	float diffuse[3], specular[3];
	float roughness, anisotropy, wrap;
	uint32_t unused;
} render_dump_material;

typedef struct render_dump_mesh {
	uint32_t id, vertices, indices, unused;
} render_dump_mesh;

typedef struct render_dump_draw {
	uint64_t key;
	uint32_t mesh, material; /* places */
	float transform[12];     /* the three rows of the affine transform */
} render_dump_draw;

static_assert(sizeof(render_dump_header) == 104 && sizeof(render_dump_view) == 208 && sizeof(render_dump_pass) == 96 &&
                  sizeof(render_dump_texture) == 16 && sizeof(render_dump_material) == 48 &&
                  sizeof(render_dump_mesh) == 16 && sizeof(render_dump_draw) == 64 && sizeof(stilb_scene_vertex) == 32,
              "the table above");

typedef enum render_dump_part {
	RENDER_DUMP_HEADER,
	RENDER_DUMP_VIEWS,
	RENDER_DUMP_PASSES,
	RENDER_DUMP_TEXTURES,
	RENDER_DUMP_MATERIALS,
	RENDER_DUMP_MESHES,
	RENDER_DUMP_SEGMENTS,
	RENDER_DUMP_DRAWS,
	RENDER_DUMP_VERTICES,
	RENDER_DUMP_INDICES,
	RENDER_DUMP_PIXELS,
	RENDER_DUMP_CHECKSUM,
	RENDER_DUMP_PARTS,
} render_dump_part;

/* Where each part begins; [RENDER_DUMP_PARTS] is the end of the file. False: more than 2^64 bytes. */
bool render_dump_layout(const render_dump_header *header, uint64_t begin[RENDER_DUMP_PARTS + 1]);

/* Bytes of a texture's pixels without the zeros behind them; format is valid, sides are at most 16384. */
uint64_t render_dump_pixel_bytes(const render_dump_texture *texture);

static inline uint64_t render_dump_fill(uint64_t bytes)
{
	return (bytes + 7) & ~(uint64_t)7;
}

/* A draw as it is recorded again. */
typedef struct render_dump_ready {
	stilb_mat4 transform;
	uint64_t key;
	stilb_render_mesh mesh;
	stilb_render_material material;
} render_dump_ready;

/* A file in memory, checked. */
struct stilb_render_dump {
	uint8_t *bytes; /* the file; what follows points into it */
	const render_dump_header *header;
	const render_dump_view *views;
	const render_dump_pass *passes;
	const render_dump_texture *textures;
	const render_dump_material *materials;
	const render_dump_mesh *meshes;
	const uint32_t *segments;
	const render_dump_draw *draws;
	const stilb_scene_vertex *vertices;
	const uint32_t *indices;
	const uint8_t *pixels;

	/* Made by upload. */
	stilb_render_pass pass_table[STILB_RENDER_MAX_PASSES];
	stilb_render_view view_table[RENDER_DUMP_MAX_VIEWS];
	render_dump_ready *ready; /* [header->draws] */
	uint32_t *first_draw;     /* [header->segments + 1] */
};

/* Takes over bytes, which come from malloc; after an error they are freed. name is for the message. */
stilb_result render_dump_read(uint8_t *bytes, size_t size, const char *name, stilb_render_dump **dump);

#endif
