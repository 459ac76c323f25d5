/* What the files of render/ and its devices share. */
#ifndef STILB_RENDER_INTERNAL_H
#define STILB_RENDER_INTERNAL_H

#include "render/render.h"

#include <stdatomic.h>

/* ---- commands ------------------------------------------------------------------------------------------------------ */

/* One draw, plain data. A mesh's place in the device's buffers is looked up at record time. */
typedef struct render_command {
	uint64_t key; /* room for a sort key; zero today: the order is the scene's */
	uint32_t row; /* of the frame's row buffer: transform and material as the shader reads them */
	uint32_t mesh;
	uint32_t material;
	uint32_t index_count;
	uint32_t first_index;
	int32_t vertex_offset;
} render_command;

static_assert(sizeof(render_command) == 32, "a command is half a cache line");

/* One draw as the vertex shader reads it (shaders/mesh.glsl): the three rows of the affine transform, then the material. */
typedef struct render_row {
	float transform[12];
	uint32_t material;
	uint32_t unused[3];
} render_row;

static_assert(sizeof(render_row) == 64, "a row is a cache line");

/* VkDrawIndexedIndirectCommand, written by the null device too. */
typedef struct render_indirect {
	uint32_t index_count, instance_count, first_index;
	int32_t vertex_offset;
	uint32_t first_instance;
} render_indirect;

/* ---- the frame's rows -------------------------------------------------------------------------------------------------
 * Contexts claim ROW_CHUNK rows at a time with one fetch-add. A chunk that still fits is written in place, in memory the
 * device reads; one beyond the capacity is written to the heap, and replay grows the buffer and moves it to its rows.
 * Row numbers depend on who was faster; what is in them does not. */

#define RENDER_ROW_CHUNK 512u

typedef struct render_rows {
	_Alignas(STILB_CACHE_LINE) _Atomic uint32_t next; /* relaxed fetch-add by contexts: claims, publishes nothing */
	_Alignas(STILB_CACHE_LINE) render_row *memory; /* the device's; written by contexts, constant while they record */
	uint32_t capacity;
} render_rows;

/* ---- contexts and lists ------------------------------------------------------------------------------------------------ */

#define RENDER_BLOCK_COMMANDS 2048u /* 64 KiB */

typedef struct render_block {
	render_command commands[RENDER_BLOCK_COMMANDS];
} render_block;

/* A chunk of rows that did not fit. */
typedef struct render_overflow {
	render_row *rows;
	uint32_t first;
} render_overflow;

typedef enum render_list_state {
	RENDER_LIST_EMPTY,
	RENDER_LIST_RECORDING,
	RENDER_LIST_CLOSED,
} render_list_state;

/* Where a segment's commands lie: count commands from (block, first) on, running over into the blocks that follow. */
typedef struct render_segment {
	const stilb_render_context *context;
	uint32_t block, first, count;
} render_segment;

/* One pass of the frame. Each segment is written by the one worker that records it; the job system's wait publishes all
 * of them to the main thread. */
typedef struct render_pass_lists {
	render_list_state state;
	render_segment *segments;
	uint32_t segment_count, segment_capacity;
} render_pass_lists;

/* Written by one worker at a time. Aligned so that two workers never share a line (sharing one cost all of the gain). */
struct stilb_render_context {
	_Alignas(STILB_CACHE_LINE) render_command *command; /* the next to write, in block blocks[block] */
	render_command *block_end;
	render_row *row; /* the next to write */
	render_row *row_end;
	uint32_t row_index;
	uint32_t block;
	render_segment *segment; /* being recorded, or NULL */
	bool failed;             /* out of memory: pass_end reports it */
	stilb_render *render;
	render_block **blocks; /* kept from frame to frame */
	uint32_t block_count, block_capacity;
	render_overflow *overflows; /* of this frame: the first overflow_count hold chunks */
	uint32_t overflow_count, overflow_capacity;
};

/* ---- meshes ------------------------------------------------------------------------------------------------------------ */

/* A mesh's place in the device's shared vertex and index buffers. */
typedef struct render_mesh {
	uint32_t first_index, index_count;
	int32_t vertex_offset;
} render_mesh;

/* A material as the fragment shader reads it (shaders/mesh.glsl). */
typedef struct render_material {
	float diffuse[3], shininess;
	float specular[3], unused;
} render_material;

static_assert(sizeof(render_material) == 32, "std430: two vec4");

/* ---- devices ------------------------------------------------------------------------------------------------------------ */

typedef struct render_device render_device;

/* All on the main thread. A frame: frame_begin, then per pass pass_begin, draws..., pass_end, then submit, present. */
typedef struct render_device_functions {
	void (*destroy)(render_device *device);
	stilb_result (*upload)(render_device *device, const stilb_scene *scene, const render_material *materials);
	stilb_result (*resize)(render_device *device, uint32_t width, uint32_t height);
	/* Waits for the frame's memory to be free and points rows at it. */
	stilb_result (*frame_begin)(render_device *device, render_rows *rows);
	/* Gives rows at least this capacity, keeping what has been written. */
	stilb_result (*rows_grow)(render_device *device, render_rows *rows, uint32_t capacity);
	stilb_result (*pass_begin)(render_device *device, const stilb_render_pass *pass, const stilb_render_view *view,
	                           uint64_t draw_count);
	/* The next count draws of the pass, in order. */
	void (*draws)(render_device *device, const render_command *commands, uint32_t count);
	void (*pass_end)(render_device *device);
	stilb_result (*submit)(render_device *device);
	stilb_result (*present)(render_device *device);
	stilb_result (*wait)(render_device *device);
	stilb_result (*read_image)(render_device *device, stilb_image *image);
} render_device_functions;

struct render_device {
	const render_device_functions *functions;
	char name[256];
	bool software;
	uint32_t width, height, samples;
	uint32_t validation_messages;
	stilb_render_replay_mode replay;
	stilb_render_stats stats;
};

stilb_result render_null_create(const stilb_render_desc *desc, render_device **device);
stilb_result render_vulkan_create(const stilb_render_desc *desc, render_device **device);

/* Writes count indirect commands for commands. */
void render_write_indirect(render_indirect *indirect, const render_command *commands, uint32_t count);

/* ---- the module itself --------------------------------------------------------------------------------------------------- */

struct stilb_render {
	render_device *device;
	stilb_render_context *contexts;
	uint32_t context_count;
	render_mesh *meshes;
	uint32_t mesh_count;
	uint32_t material_count;
	render_rows rows;
	render_pass_lists passes[STILB_RENDER_MAX_PASSES];
	uint32_t replayed[STILB_RENDER_MAX_PASSES]; /* this frame's passes in the order of their replay */
	uint32_t replayed_count;
};

/* Forgets the frame's passes. */
void render_passes_rewind(stilb_render *render);
/* Makes contexts empty again, keeping their memory. */
void render_contexts_rewind(stilb_render *render);
/* Replaces the contexts; after an error the old ones are still there. */
stilb_result render_contexts_create(stilb_render *render, uint32_t count);
void render_contexts_destroy(stilb_render *render);

/* Moves overflow chunks into the device's rows, grown to hold all. */
stilb_result render_rows_place(stilb_render *render);

/* The row that a command names, in the device's memory or in an overflow chunk already placed there. */
static inline const render_row *render_row_at(const stilb_render *render, uint32_t row)
{
	return &render->rows.memory[row];
}

#endif
