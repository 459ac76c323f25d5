/* What the files of render/ and its devices share. */
#ifndef STILB_RENDER_INTERNAL_H
#define STILB_RENDER_INTERNAL_H

#include "profiler/prof.h"
#include "render/render.h"
#include "render/render_resources.h"

#include <stdatomic.h>

/* ---- commands ------------------------------------------------------------------------------------------------------ */

/* One draw, plain data. The first 20 bytes are what a GPU reads of an indirect draw (VkDrawIndexedIndirectCommand), so a
 * list of commands can be handed to it as it is, with a stride of 32. */
typedef struct render_command {
	uint32_t index_count;
	uint32_t instance_count; /* 1 */
	uint32_t first_index;
	int32_t vertex_offset;
	uint32_t row;      /* the first instance: of the frame's rows */
	uint32_t material; /* index */
	uint64_t key;      /* for passes that sort */
} render_command;

static_assert(sizeof(render_command) == 32, "a command is half a cache line");
static_assert(offsetof(render_command, row) == 16, "laid out as VkDrawIndexedIndirectCommand");

/* One draw as the vertex shader reads it (shaders/row.glsl): the three rows of the affine transform, then the material.
 * A 2D draw has its clip rectangle in the first row, and nothing else. */
typedef struct render_row {
	float transform[12];
	uint32_t material;
	uint32_t mesh; /* no shader reads it: the hash and the dump do */
	uint32_t unused[2];
} render_row;

static_assert(sizeof(render_row) == 64, "a row is a cache line");

/* ---- a frame's memory ------------------------------------------------------------------------------------------------
 * Commands, rows and 2D geometry lie in memory of the device, one piece each for a frame. Contexts claim it with one
 * fetch-add: by the chunk, geometry as much as it needs. What still fits is written in place; what lies beyond the
 * capacity is written to the heap, and replay grows the memory and moves it to its place. Which place is whose depends on
 * who was faster; the order of the draws does not. */

#define RENDER_COMMAND_CHUNK 2048u /* 64 KiB */
#define RENDER_ROW_CHUNK 512u      /* 32 KiB */

typedef struct render_memory {
	_Alignas(STILB_CACHE_LINE) _Atomic uint32_t next; /* relaxed fetch-add by contexts: claims, publishes nothing */
	_Alignas(STILB_CACHE_LINE) void *data; /* the device's; written by contexts, constant while they record */
	uint32_t capacity;                     /* elements */
	uint32_t first_capacity;               /* of a new frame; 0: none before it is claimed */
	uint32_t element;                      /* bytes */
} render_memory;

typedef enum render_memory_kind {
	RENDER_MEMORY_COMMANDS,
	RENDER_MEMORY_ROWS,
	RENDER_MEMORY_VERTICES_2D,
	RENDER_MEMORY_INDICES_2D,
	RENDER_MEMORY_KINDS,
} render_memory_kind;

#define RENDER_FIRST_CAPACITY 32768u /* commands and rows before a frame's memory has to grow */

/* ---- contexts and lists ------------------------------------------------------------------------------------------------ */

/* Draws that lie one after the other and need the same bindings: commands first .. first + count - 1 of the frame. */
typedef struct render_run {
	uint32_t first, count;
	uint64_t state; /* see render_state */
} render_run;

/* What was claimed and did not fit. */
typedef struct render_overflow {
	render_memory_kind kind;
	uint32_t first, count;
	void *data;
} render_overflow;

typedef enum render_list_state {
	RENDER_LIST_EMPTY,
	RENDER_LIST_RECORDING,
	RENDER_LIST_CLOSED,
	RENDER_LIST_REPLAYED,
} render_list_state;

/* Which of its context's runs are a segment's. */
typedef struct render_segment {
	const stilb_render_context *context;
	uint32_t first_run, run_count;
} render_segment;

/* One pass of the frame. Each segment is written by the one worker that records it; the job system's wait publishes all
 * of them to the main thread, which joins their runs when it replays them. */
typedef struct render_pass_lists {
	render_list_state state;
	stilb_render_pass_kind kind; /* once it is replayed */
	render_segment *segments;
	uint32_t segment_count, segment_capacity;
	render_run *runs;
	uint32_t run_count, run_capacity;
	uint64_t draws;
	uint64_t states;              /* of all runs, or-ed: 0 in its texture bits means that no draw has one */
	stilb_render_shading shading; /* of its view */
} render_pass_lists;

/* Written by one worker at a time. Aligned so that two workers never share a line (sharing one cost all of the gain). */
struct stilb_render_context {
	/* Every draw reads and writes these. */
	_Alignas(STILB_CACHE_LINE) render_command *command; /* the next to write */
	render_command *command_end;                        /* of its chunk */
	render_row *row;                                    /* the next to write */
	render_row *row_end;
	uint64_t state;         /* of the run being recorded; RENDER_NO_STATE before a segment's first draw */
	uint32_t row_index;     /* of row */
	uint32_t material_mask; /* bits of a material's index that are part of the state */
	bool stream_rows;       /* write rows past the caches */
	const render_mesh_slot *meshes;
	const uint32_t *materials;

	uint32_t command_chunk;  /* index of the first command of the chunk */
	uint32_t run_count;      /* of this frame */
	uint32_t run_capacity;   /* kept from frame to frame, as the arrays below */
	uint32_t overflow_count; /* of this frame */
	uint32_t overflow_capacity;
	bool failed;                /* out of memory: pass_end reports it */
	render_run *runs;           /* [run_count] */
	render_segment *segment;    /* being recorded, or NULL */
	uint32_t first_run;         /* of that */
	render_overflow *overflows; /* [overflow_count] */
	stilb_render *render;
};

#define RENDER_NO_STATE UINT64_MAX

/* ---- what a draw must have bound ---------------------------------------------------------------------------------------
 * The texture in the low 24 bits, above it what --materials makes depend on the material: nothing (index), its index
 * (bind), or whether that is odd (pipeline). Draws of 2D passes have a bit of their own, and no material. */

#define RENDER_STATE_2D (UINT64_C(1) << 56)

static inline uint64_t render_state(uint32_t material_entry, uint32_t material, uint32_t material_mask)
{
	return (material_entry & RENDER_INDEX_MASK) | (uint64_t)(material & material_mask) << 24;
}

static inline uint32_t render_material_mask(stilb_render_materials materials)
{
	return materials == STILB_RENDER_MATERIALS_BIND       ? RENDER_INDEX_MASK
	       : materials == STILB_RENDER_MATERIALS_PIPELINE ? 1u
	                                                      : 0u;
}

static inline uint32_t render_state_texture(uint64_t state)
{
	return (uint32_t)state & RENDER_INDEX_MASK;
}

/* The material with BIND, the pipeline's number with PIPELINE, else 0. */
static inline uint32_t render_state_material(uint64_t state)
{
	return (uint32_t)(state >> 24);
}

typedef enum render_bind {
	RENDER_BIND_PIPELINE = 1,
	RENDER_BIND_BUFFERS = 2,
	RENDER_BIND_MATERIAL = 4, /* its descriptor set and its texture's */
} render_bind;

/* What has to be bound for a draw with state `to` after one with state `from`, RENDER_NO_STATE before the first. */
static inline uint32_t render_binds_between(stilb_render_materials materials, uint64_t from, uint64_t to)
{
	if (from == to)
		return 0;
	if (from == RENDER_NO_STATE)
		return RENDER_BIND_PIPELINE | RENDER_BIND_BUFFERS | RENDER_BIND_MATERIAL;
	uint32_t from_texture = render_state_texture(from), to_texture = render_state_texture(to);
	uint32_t binds = to_texture && to_texture != from_texture ? RENDER_BIND_MATERIAL : 0;
	if (!from_texture != !to_texture)
		binds |= RENDER_BIND_PIPELINE; /* one that reads a texture, or one that does not */
	if (render_state_material(from) != render_state_material(to))
		binds |= materials == STILB_RENDER_MATERIALS_PIPELINE ? RENDER_BIND_PIPELINE : RENDER_BIND_MATERIAL;
	return binds;
}

/* ---- devices ------------------------------------------------------------------------------------------------------------ */

typedef struct render_device render_device;

/* A pass as it is replayed: its draws in order. */
typedef struct render_stream {
	const stilb_render_pass *pass;
	const stilb_render_view *view;  /* NULL: a 2D pass */
	const stilb_prof_site *site;    /* the pass's name in the profiler */
	const render_command *commands; /* the frame's; runs index into them */
	const render_run *runs;
	uint32_t run_count;
	uint64_t draws;
	uint64_t states;      /* of all runs, or-ed */
	stilb_job_pool *pool; /* for secondary command buffers, one a worker */
	uint32_t worker;      /* the caller's index in pool */
} render_stream;

/* Part of a stream: count draws, from draw `offset` of run `run` on. */
typedef struct render_part {
	uint32_t run, offset;
	uint64_t count;
} render_part;

/* All on the main thread but for texture_create. A frame: frame_begin, update, pass..., submit, present. */
typedef struct render_device_functions {
	void (*destroy)(render_device *device);
	stilb_result (*resize)(render_device *device, uint32_t width, uint32_t height);
	/* Waits until the frame's memory is free, and points memory[RENDER_MEMORY_KINDS] at it. */
	stilb_result (*frame_begin)(render_device *device, render_memory *memory);
	/* Gives memory, which is of this kind, at least this capacity, and keeps its first elements. */
	stilb_result (*grow)(render_device *device, render_memory *memory, render_memory_kind kind, uint32_t capacity,
	                     uint32_t keep);
	/* A texture for such a picture; what is in it comes with update. [any-thread] */
	stilb_result (*texture_create)(render_device *device, uint32_t texture, const stilb_image *image);
	/* No frame uses it any longer. */
	void (*texture_destroy)(render_device *device, uint32_t texture);
	/* Brings over what is dirty. The lock of resources is held. */
	stilb_result (*update)(render_device *device, const render_resources *resources);
	stilb_result (*pass)(render_device *device, const render_stream *stream);
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
	stilb_render_materials materials;
	stilb_render_faults faults;
	_Atomic uint32_t allocations; /* relaxed counter: any thread creates textures */
	uint32_t frames;              /* handed over so far */
	stilb_render_stats stats;
};

#define RENDER_FRAMES_IN_FLIGHT 2 /* slots of every device */

stilb_result render_null_create(const stilb_render_desc *desc, render_device **device);
stilb_result render_vulkan_create(const stilb_render_desc *desc, render_device **device);

/* True when this allocation, which the device counts with each call, is to fail on purpose. [any-thread] */
bool render_fault_allocation(render_device *device);
/* True when the device is to be lost with the frame that is handed over now. */
bool render_fault_lost(const render_device *device);

/* How a stream is replayed on this device: 2D passes have so few draws that jobs would only cost. */
static inline stilb_render_replay_mode render_stream_mode(const render_device *device, const render_stream *stream)
{
	bool few = stream->pass->kind == STILB_RENDER_PASS_2D;
	return few && device->replay == STILB_RENDER_REPLAY_SECONDARY ? STILB_RENDER_REPLAY_DIRECT : device->replay;
}

/* Cuts a stream into `count` parts with as many draws each, give or take one. */
void render_split(const render_stream *stream, uint32_t count, render_part *parts);

/* ---- the module itself --------------------------------------------------------------------------------------------------- */

/* Passes are recorded between the frame's begin and its replay. */
typedef enum render_frame_state {
	RENDER_FRAME_NONE,
	RENDER_FRAME_BEGUN,
	RENDER_FRAME_REPLAYED,
} render_frame_state;

struct stilb_render {
	render_device *device;
	stilb_render_output output;
	stilb_render_context *contexts;
	uint32_t context_count;
	render_resources resources;
	uint32_t scene_meshes, scene_materials; /* handles of the scene's first mesh and material; the others follow */
	render_memory memory[RENDER_MEMORY_KINDS];
	render_pass_lists passes[STILB_RENDER_MAX_PASSES];
	uint32_t replayed[STILB_RENDER_MAX_PASSES]; /* this frame's passes in the order of their replay */
	uint32_t replayed_count;
	const stilb_prof_site *sites[STILB_RENDER_MAX_PASSES]; /* of the names that passes had last */
	render_frame_state state;
	void *sort_items; /* [sort_capacity] scratch of render_sort */
	uint64_t sort_capacity;
};

/* Forgets the frame's passes. */
void render_passes_rewind(stilb_render *render);
/* Makes contexts empty again, keeping their memory. */
void render_contexts_rewind(stilb_render *render);
/* Replaces the contexts; after an error the old ones are still there. */
stilb_result render_contexts_create(stilb_render *render, uint32_t count);
void render_contexts_destroy(stilb_render *render);

/* Moves what did not fit into the device's memory, grown to hold all. */
stilb_result render_memory_place(stilb_render *render);

/* Brings a closed pass's runs into the order of the replay. */
stilb_result render_order(stilb_render *render, const stilb_render_pass *pass, render_pass_lists *lists);

/* Replaces a pass's runs by ones whose draws go by ascending key, equal keys as they were. */
stilb_result render_sort(stilb_render *render, render_pass_lists *lists);

/* Room for count elements in an array that doubles, contents kept; false without memory. */
bool render_reserve(void **array, uint32_t *capacity, uint32_t count, size_t size);

/* After replay, and during it for what has been placed. */
static inline const render_command *render_commands(const stilb_render *render)
{
	return render->memory[RENDER_MEMORY_COMMANDS].data;
}

static inline const render_row *render_rows(const stilb_render *render)
{
	return render->memory[RENDER_MEMORY_ROWS].data;
}

#endif
