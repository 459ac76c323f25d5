/*
 * Meshes, textures and materials: handles, and what the device must be told of. Inside render/.
 *
 * Handles.  The low 24 bits index a table, the high 8 are the entry's generation, so that a stale handle is noticed. Tables
 *           are reserved at their full size and never move: recording reads an entry without a lock.
 * Heaps.    Vertices, indices and materials lie in three arrays, in the same places as on the device. Whoever creates
 *           writes here, under the lock, and marks the range dirty; replay hands dirty ranges to the device.
 * Retiring. What is destroyed may be in a frame that the device still draws: it is released when that frame is done.
 */
#ifndef STILB_RENDER_RESOURCES_H
#define STILB_RENDER_RESOURCES_H

#include "base/base_contract.h"
#include "render/render.h"

#define RENDER_INDEX_MASK 0xffffffu
#define RENDER_GENERATION_SHIFT 24u

/* A mesh's place in the vertex and index heaps. The first 16 bytes are those of its draws' commands. */
typedef struct render_mesh_slot {
	_Alignas(32) uint32_t index_count;
	uint32_t instance_count; /* 1 */
	uint32_t first_index;
	int32_t vertex_offset;
	uint32_t vertex_count;
	uint32_t generation; /* of the handles that name it */
} render_mesh_slot;

/* A material as the fragment shader reads it (shaders/mesh.glsl). */
typedef struct render_material {
	float diffuse[3], roughness;
	float specular[3], anisotropy;
	float wrap, unused[3];
} render_material;

static_assert(sizeof(render_material) == 48, "std430: three vec4");

/* Disjoint ranges, ascending; neighbours that touch are one. */
typedef struct render_range {
	uint32_t first, count;
} render_range;

typedef struct render_ranges {
	render_range *items;
	uint32_t count, capacity;
} render_ranges;

typedef enum render_heap_kind {
	RENDER_HEAP_VERTICES,
	RENDER_HEAP_INDICES,
	RENDER_HEAP_MATERIALS,
	RENDER_HEAPS,
} render_heap_kind;

typedef struct render_heap {
	uint8_t *data;
	uint32_t element;        /* bytes */
	uint32_t size, capacity; /* elements; all ever used lie below size */
	render_ranges free, dirty;
} render_heap;

typedef enum render_resource_kind {
	RENDER_RESOURCE_MESH,
	RENDER_RESOURCE_TEXTURE,
	RENDER_RESOURCE_MATERIAL,
	RENDER_RESOURCE_KINDS,
} render_resource_kind;

/* The indices of one kind of resource. */
typedef struct render_indices {
	uint32_t next, most; /* never used yet; how many there can be */
	uint32_t *free;      /* a stack with room for all below next, so that releasing cannot fail */
	uint32_t free_count, free_capacity;
} render_indices;

/* Pixels on their way to a texture: four channels. */
typedef struct render_texture_upload {
	uint32_t texture;
	stilb_image image;
} render_texture_upload;

typedef struct render_retired {
	uint64_t frame; /* the last that may use it */
	render_resource_kind kind;
	uint32_t index;
} render_retired;

typedef struct render_resources {
	/* Read by draws without the lock; an entry is written before its handle exists, and after it is released. */
	render_mesh_slot *meshes; /* [STILB_RENDER_MAX_MESHES] */
	uint32_t *materials;      /* [STILB_RENDER_MAX_MATERIALS]: generation above, index of the texture below, 0: none */
	uint32_t *textures;       /* [STILB_RENDER_MAX_TEXTURES]: generation */

	stilb_lock lock; /* guards everything below */
	bool lock_made;
	render_indices indices[RENDER_RESOURCE_KINDS];
	render_heap heaps[RENDER_HEAPS];
	render_texture_upload *uploads;
	uint32_t upload_count, upload_capacity;
	uint32_t uploads_sent;   /* the first ones, with the frame that is being replayed */
	stilb_image *pictures;   /* [STILB_RENDER_MAX_TEXTURES] what was sent; NULL: not kept */
	render_retired *retired; /* room for all that live */
	uint32_t retired_count, retired_capacity;
	uint32_t live;  /* not yet released */
	uint64_t frame; /* frames begun */
} render_resources;

stilb_result render_resources_create(render_resources *resources, bool keep_pictures);
/* Accepts {0}. */
void render_resources_destroy(render_resources *resources);

/* A frame has begun, and the device is done with the one RENDER_FRAMES_IN_FLIGHT before: releases what was destroyed in
 * that frame or before. [main-thread] */
void render_resources_frame(stilb_render *render);

/* Gives the device what is dirty, as a part of the frame. [main-thread] */
stilb_result render_resources_update(stilb_render *render);

/* After the end of such a frame: was it handed over? If not, all is dirty again. [main-thread] */
void render_resources_sent(stilb_render *render, bool good);

/* ranges: adding what touches or overlaps joins it. False without memory. */
bool render_ranges_add(render_ranges *ranges, render_range range);
/* Takes `count` from the first range that has as many; false: none has. */
bool render_ranges_take(render_ranges *ranges, uint32_t count, uint32_t *first);

#endif
