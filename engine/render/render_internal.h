/*
 * Types and functions that the files of render/ and its devices share: commands and their memory, contexts and passes,
 * the interface of a device. Not for other modules.
 */
#ifndef STILB_RENDER_INTERNAL_H
#define STILB_RENDER_INTERNAL_H

#include "base/base_contract.h"
#include "gpu/gpu_internal.h"
#include "light/light.h"
#include "profiler/prof.h"
#include "render/combined/render_combined.h"
#include "render/device/render_device.h"
#include "render/maps/render_functions.h"
#include "render/render.h"
#include "render/render_panorama.h"
#include "render/render_resources.h"
#include "render/rows/render_rows.h"
#include "render/textures/render_loading.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>

/* ---- commands ---------------------------------------------------------------------------------------------------- */

/* One draw, plain data. The first 20 bytes are a VkDrawIndexedIndirectCommand, so the GPU can read a list of commands
 * as it is, with a stride of 32 bytes. */
typedef struct render_command {
	uint32_t index_count;
	uint32_t instance_count; /* 1 */
	uint32_t first_index;
	int32_t vertex_offset;
	uint32_t row;      /* the word of its row, and above it RENDER_DETAIL_...; the GPU reads it as firstInstance */
	uint32_t material; /* index into the table of materials */
	uint64_t key;      /* of stilb_render_draw_with_key */
} render_command;

static_assert(sizeof(render_command) == 32, "a command is half a cache line");
static_assert(offsetof(render_command, row) == 16, "laid out as VkDrawIndexedIndirectCommand");

/* The high bits of render_command.row. 0: none. With RENDER_STATE_FADE 1..31: the draw is in so many 32ths of the
 * pixels, 32 + 1..31: it is in the others. With RENDER_STATE_MORPH: how far it has morphed, in 64ths. With
 * RENDER_STATE_SHOW: 1 + its level, at most 63. */
#define RENDER_DETAIL_SHIFT 26u
#define RENDER_DETAIL_OUT 32u

static_assert(RENDER_ROW_FRAME << 1 == 1u << RENDER_DETAIL_SHIFT, "the word of a row lies below");

/* Its index, among the frame's rows or the scene's. */
static inline uint32_t render_command_row(const render_command *command)
{
	return command->row & (RENDER_MAX_ROWS - 1);
}

static inline uint32_t render_command_detail(const render_command *command)
{
	return command->row >> RENDER_DETAIL_SHIFT;
}

/* A light of a view as the shaders read it (shaders/mesh.glsl). */
typedef struct render_light {
	/* kind: stilb_scene_light_kind + 8 stilb_scene_light_falloff + 32 times 0, or, with shadow maps,
	 * 2 (1 + the first one), and one more where they are those of a cube; besides it 512 (1 + its place), where there
	 * is a buffer of shadows */
	float position[3], kind;
	float direction[3], reach;
	float intensity[3], cos_inner;
	float half_x[3], cos_outer;
	float half_y[3], radius;
} render_light;

static_assert(sizeof(render_light) == 80, "std430");
static_assert(STILB_SCENE_LIGHT_KINDS <= 6, "see render_light.kind and the bits below");

#define RENDER_LIGHT_SHADOW 32u                         /* what render_light.kind has of shadows comes in these */
#define RENDER_LIGHT_PLACE (512u * RENDER_LIGHT_SHADOW) /* and what it has of places in these */

/* RENDER_FORMULA_SHADOWS: how shadows are read and shown (shadow.glsl); of programs that draw maps _FLAT alone. */
#define RENDER_SHADOW_CASCADES 1u /* STILB_RENDER_SHOW_CASCADES */
#define RENDER_SHADOW_ACNE 2u     /* and _ACNE */
#define RENDER_SHADOW_NO_PLANE 4u /* as of stilb_render_shadow_reading */
#define RENDER_SHADOW_NO_WAY 8u
#define RENDER_SHADOW_FLAT 16u    /* stilb_render_view.shadow_flat */
#define RENDER_SHADOW_BUFFER 32u  /* shares come from the buffer */
#define RENDER_SHADOW_MASK 64u    /* besides _TERMS: there is STILB_RENDER_IMAGE_MASK */
#define RENDER_SHADOW_TERMS 128u  /* the buffer is drawn */
#define RENDER_SHADOW_THINGS 256u /* stilb_render_shadow_reading.things */
#define RENDER_SHADOW_TAPS 512u   /* so many comparisons come in these */
#define RENDER_SHADOW_LAYER 4u    /* lights of a layer of the buffer */
/* So many, above all these: a stilb_render_hdr, what the programs' light is kept in. */
#define RENDER_SHADOW_HDR (1u << 28)

#define RENDER_LIGHTS_END 64u            /* some have a falloff that is not physical */
#define RENDER_LIGHTS_GLOSS 128u         /* highlights mirror sky and ground */
#define RENDER_LIGHTS_PANORAMA 256u      /* the panorama's light in place of sky and ground */
#define RENDER_LIGHTS_SIDES 512u         /* no light, but stilb_render_view.both_sides */
#define RENDER_LIGHTS_ONE 1024u          /* there is exactly one */
#define RENDER_LIGHTS_DEPTH 2048u        /* nothing is lit: depth is drawn, and what is beside it. Besides it, _SIDES */
#define RENDER_LIGHTS_LISTS 8192u        /* lights that end somewhere are found by lists (render_lights.c) */
#define RENDER_LIGHTS_GBUFFER 16384u     /* surfaces are drawn, and lights left to a later pass (render_deferred.c) */
#define RENDER_LIGHTS_GBUFFER8 32768u    /* besides _GBUFFER, and of the passes that light: surfaces are in 8 bits */
#define RENDER_LIGHTS_ADDED 65536u       /* further lights are added to what has been drawn */
#define RENDER_LIGHTS_LAID (1u << 17)    /* surfaces are drawn where an earlier pass has drawn their depth */
#define RENDER_LIGHTS_TILES (1u << 18)   /* besides _LISTS: they are those of tiles (render_tiles.c) */
#define RENDER_LIGHTS_INDEXED (1u << 19) /* likewise: pixels have the places of theirs */
/* PREPASS and PRELIGHT, with _GBUFFER8 the former. Besides _GBUFFER: of surfaces one image is drawn; _LAID: their light
 * comes from images; else: it is added up. */
#define RENDER_LIGHTS_APART (1u << 20)
/* Two bits: what lights in place of sky, ground and panorama (stilb_render_ambient). */
#define RENDER_LIGHTS_DARK (1u << 21)      /* nothing */
#define RENDER_LIGHTS_SH_VERTEX (2u << 21) /* harmonics, summed by vertex */
#define RENDER_LIGHTS_SH_PIXEL (3u << 21)  /* and by pixel */
#define RENDER_LIGHTS_AMBIENT (3u << 21)   /* both bits */
#define RENDER_LIGHTS_COMBINED (1u << 23)  /* models have lights of their own (render_combined.h) */
#define RENDER_LIGHTS_COUNTED (1u << 24)   /* lights that are asked are counted in place of their light */
/* Four bits from this one on: nothing is lit, but 1 + a channel is shown. Besides it, _SIDES. */
#define RENDER_LIGHTS_CHANNEL_SHIFT 25u
#define RENDER_LIGHTS_CHANNEL 15u        /* so many, once shifted */
#define RENDER_LIGHTS_SHADOWS (1u << 30) /* maps keep some from surfaces; besides _DEPTH: such a map is drawn */

/* 1 + the stilb_scene_surface_channel that programs for these bits show; 0: light. */
static inline uint32_t render_lights_channel(uint32_t bits)
{
	return bits >> RENDER_LIGHTS_CHANNEL_SHIFT & RENDER_LIGHTS_CHANNEL;
}

static_assert(STILB_SCENE_CHANNELS < RENDER_LIGHTS_CHANNEL, "see RENDER_LIGHTS_CHANNEL_SHIFT");

/* ---- a frame's memory -----------------------------------------------------------------------------------------------
 * Commands, rows, 2D geometry and lights lie in memory of the device, one array of each kind for a frame. Contexts
 * claim elements with one fetch-add: commands and rows by the chunk, geometry as much as it needs. Claims below the
 * capacity are written in place; claims beyond it are written to the heap, and replay grows the array and copies them
 * to their place. Positions depend on which worker was faster; the order of the draws does not. */

#define RENDER_COMMAND_CHUNK 2048u /* 64 KiB */
#define RENDER_ROW_CHUNK 512u      /* 32 KiB */

typedef struct render_memory {
	_Alignas(STILB_CACHE_LINE) _Atomic uint32_t next; /* elements claimed so far; relaxed, see record_claim */
	_Alignas(STILB_CACHE_LINE) void *data; /* owned by the device; the pointer is constant while contexts record */
	uint32_t capacity;                     /* elements */
	uint32_t first_capacity;               /* elements that frame_begin allocates if its slot has none; 0: none */
	uint32_t element;                      /* bytes */
} render_memory;

typedef enum render_memory_kind {
	RENDER_MEMORY_COMMANDS,
	RENDER_MEMORY_ROWS,
	RENDER_MEMORY_VERTICES_2D,
	RENDER_MEMORY_INDICES_2D,
	RENDER_MEMORY_LIGHTS,
	RENDER_MEMORY_LIGHT_LISTS,
	RENDER_MEMORY_KINDS,
} render_memory_kind;

#define RENDER_FIRST_COMMANDS 32768u /* first_capacity */
#define RENDER_FIRST_ROWS 4096u

/* ---- contexts and lists ------------------------------------------------------------------------------------------ */

/* A run: consecutive draws that need the same bindings. They are commands first .. first + count - 1 of the frame. */
typedef struct render_run {
	uint32_t first, count;
	uint64_t state; /* as render_state makes it */
} render_run;

/* A claim of elements first .. first + count - 1 that lie beyond the capacity of the frame's memory: they are written
 * to `data`, on the heap, and render_memory_place copies them to where they belong. */
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

/* A recorded segment: runs first_run .. first_run + run_count - 1 of the context that recorded it. */
typedef struct render_segment {
	const stilb_render_context *context; /* NULL: not recorded yet */
	uint32_t first_run, run_count;
} render_segment;

/* One pass of the frame. Each segment is written by the one worker that records it; the job system's wait publishes
 * them to the main thread, which joins their runs at replay. */
typedef struct render_pass_lists {
	render_list_state state;
	stilb_render_pass_kind kind; /* set at replay */
	render_segment *segments;
	uint32_t segment_count, segment_capacity;
	render_run *runs;
	uint32_t run_count, run_capacity;
	uint64_t draws;
	uint64_t states; /* bitwise or of all runs' states: no texture bit set means no draw has a texture */
	uint32_t kinds;  /* 1 << render_state_detail of each run */
	stilb_render_detail_mode detail; /* that it was recorded with */
	uint16_t *history; /* [history_capacity] by part: its levels in the frames before, see render_detail.h */
	uint32_t history_capacity;
	uint8_t *impostors; /* [impostor_capacity] by model: whether it was drawn as its impostor, see render_detail.h */
	uint32_t impostor_capacity;
	render_combined_pass combined;
	/* Of the pass's view, set at replay. Lights: elements first_light .. first_light + light_count - 1. */
	stilb_render_shading shading;
	float sky[3], ground[3];
	uint32_t glossy, both_sides;       /* of the surroundings, + 2 ambient; of the view */
	uint32_t first_light, light_count; /* lights without the panorama's lamps */
	uint64_t panorama;                 /* render_panorama.key; 0: none */
	float rotation;                    /* of the panorama */
	bool shadow;                       /* it draws a shadow map */
} render_pass_lists;

/* Indices of clusters to draw, from the mesh's first one in the heap on. */
typedef struct render_cluster_range {
	uint32_t first_index, index_count;
	uint32_t depth; /* of its clusters, if asked for, else 0 */
} render_cluster_range;

/* What a worker needs to choose clusters (render_clusters.h). {0} is empty. */
typedef struct render_cluster_cut {
	uint32_t *suffices;           /* [word_capacity] a bit for each group */
	render_cluster_range *ranges; /* [range_count] what is drawn */
	uint32_t word_capacity, range_capacity, range_count;
} render_cluster_cut;

/* What one worker needs to record draws; written by one worker at a time. Aligned so that two workers never write the
 * same cache line (measured: such false sharing cost all that a second worker gains). */
struct stilb_render_context {
	/* Used by every draw. */
	_Alignas(STILB_CACHE_LINE) render_command *command; /* the next to write; NULL: no chunk is claimed yet */
	render_command *command_end;                        /* end of the chunk that it lies in */
	render_row *row;                                    /* the next to write; NULL: no chunk is claimed yet */
	render_row *row_end;                                /* end of the chunk that it lies in */
	uint64_t state;         /* of the run being recorded; RENDER_NO_STATE before a segment's first draw */
	uint32_t row_index;     /* index of `row` among the frame's rows */
	uint32_t material_mask; /* see render_material_mask */
	bool stream_rows;       /* write rows with non-temporal stores */
	const render_mesh_slot *meshes;
	const uint32_t *materials;
	render_levels *const *levels;

	uint32_t command_chunk;  /* index of the first command of the chunk */
	uint32_t run_count;      /* in this frame */
	uint32_t run_capacity;   /* kept from frame to frame, as the arrays below */
	uint32_t overflow_count; /* in this frame */
	uint32_t overflow_capacity;
	bool failed;                /* out of memory: pass_end reports it */
	render_run *runs;           /* [run_count] of all segments that it has recorded in this frame */
	render_segment *segment;    /* being recorded, or NULL */
	uint32_t first_run;         /* index in `runs` of that segment's first */
	render_overflow *overflows; /* [overflow_count] */
	render_cluster_cut cut;     /* of the part that was recorded last */
	stilb_render *render;
	stilb_owner writer; /* the thread that began the segment */
};

#define RENDER_NO_STATE UINT64_MAX

/* ---- the state of a draw --------------------------------------------------------------------------------------------
 * One number that tells which bindings a draw needs. Bits 0..21: index of its texture, 0 for none. Bit 22: its material
 * has a surface, and they are its group's (render_groups.h). Bit 23: it is an
 * impostor, and the texture has its maps. Bits 24..55: by
 * --materials 0 (index), the material's index (bind), or its lowest bit (pipeline). Bit 56: a draw of a 2D pass, which
 * has no material. Bit 57: one of these that shows a picture pixel by pixel. Bits 58..60, of a scene pass: what the
 * shaders do with RENDER_DETAIL_SHIFT; at most one of them, none: nothing, and it is 0. Bit 61, of a scene pass: its
 * indices have 32 bits. Bit 62, of a scene pass: its vertices have extras, which matter with bit 22 alone. */

#define RENDER_STATE_MAPS UINT64_C(0x400000)
#define RENDER_STATE_IMPOSTOR UINT64_C(0x800000)
#define RENDER_STATE_2D (UINT64_C(1) << 56)
#define RENDER_STATE_PICTURE (UINT64_C(1) << 57)
#define RENDER_STATE_FADE (UINT64_C(1) << 58)
#define RENDER_STATE_MORPH (UINT64_C(1) << 59)
#define RENDER_STATE_SHOW (UINT64_C(1) << 60)
#define RENDER_STATE_WIDE (UINT64_C(1) << 61)
#define RENDER_STATE_EXTRAS (UINT64_C(1) << 62)
#define RENDER_STATE_DETAIL (RENDER_STATE_FADE | RENDER_STATE_MORPH | RENDER_STATE_SHOW)
#define RENDER_STATE_MESH (RENDER_STATE_WIDE | RENDER_STATE_EXTRAS) /* what depends on the mesh and its level */

/* The bits RENDER_STATE_MESH of a mesh in full. */
static inline uint64_t render_state_of_mesh(const render_mesh_slot *slot)
{
	static_assert((RENDER_STATE_MESH >> 60) == (RENDER_MESH_WIDE | RENDER_MESH_EXTRAS),
	              "a shift makes bits of the state of flags");
	return (uint64_t)(slot->flags & (RENDER_MESH_WIDE | RENDER_MESH_EXTRAS)) << 60;
}

/* The bit RENDER_STATE_WIDE of a level, 0: the mesh in full. */
static inline uint64_t render_state_of_level(const render_levels *levels, uint32_t level)
{
	return (uint64_t)(level < levels->wide) * RENDER_STATE_WIDE;
}

/* The state of a scene pass's draw. material_entry: the material's entry in render_resources.materials, whose low 24
 * bits are the lowest bits of the state; or these alone. */
static inline uint64_t render_state(uint32_t material_entry, uint32_t material, uint32_t material_mask)
{
	return (material_entry & RENDER_INDEX_MASK) | (uint64_t)(material & material_mask) << 24;
}

/* The bits of a material's index that are part of the state. */
static inline uint32_t render_material_mask(stilb_render_materials materials)
{
	return materials == STILB_RENDER_MATERIALS_BIND       ? RENDER_INDEX_MASK
	       : materials == STILB_RENDER_MATERIALS_PIPELINE ? 1u
	                                                      : 0u;
}

/* Index of the texture that a draw with this state needs; 0: none. */
static inline uint32_t render_state_texture(uint64_t state)
{
	return state & RENDER_STATE_MAPS ? 0 : (uint32_t)(state & (RENDER_STATE_MAPS - 1));
}

/* The group of a draw whose state has RENDER_STATE_MAPS. */
static inline uint32_t render_state_group(uint64_t state)
{
	STILB_ASSERT(state & RENDER_STATE_MAPS);
	return (uint32_t)(state & (RENDER_STATE_MAPS - 1));
}

/* The bits that the state has of its material's entry in render_resources.materials. */
static inline uint32_t render_state_entry(uint64_t state)
{
	return (uint32_t)state & RENDER_INDEX_MASK;
}

/* What the state of a scene pass's draw has of its material: the index with STILB_RENDER_MATERIALS_BIND, the index's
 * lowest bit, which is the number of a pipeline, with _PIPELINE, else 0. */
static inline uint32_t render_state_material(uint64_t state)
{
	return (uint32_t)(state >> 24);
}

/* Which of the mesh shaders' kinds a state needs: 0 none of the three below, 1 _FADE, 2 _MORPH, 3 _SHOW. */
#define RENDER_DETAIL_KINDS 4u
static inline uint32_t render_state_detail(uint64_t state)
{
	uint32_t bits = (uint32_t)(state >> 58 & 7u);
	return bits == 4 ? 3 : bits;
}

/* 1 << render_state_detail of what passes with this view draw, but for meshes that fade because they cannot morph. */
static inline uint32_t render_view_kinds(const stilb_render_view *view)
{
	if (view->show == STILB_RENDER_SHOW_LEVELS)
		return 1u << render_state_detail(RENDER_STATE_SHOW);
	if (view->detail.mode == STILB_RENDER_DETAIL_MORPH)
		return 1u << render_state_detail(RENDER_STATE_MORPH);
	return view->detail.mode == STILB_RENDER_DETAIL_FADE ? 1u | 1u << render_state_detail(RENDER_STATE_FADE) : 1u;
}

/* The RENDER_STATE_... of such a kind. */
static inline uint64_t render_state_of_detail(uint32_t kind)
{
	return kind == 0 ? 0 : RENDER_STATE_FADE << (kind - 1);
}

typedef enum render_bind {
	RENDER_BIND_PIPELINE = 1,
	RENDER_BIND_BUFFERS = 2,
	RENDER_BIND_MATERIAL = 4, /* the material, and its texture */
	RENDER_BIND_INDICES = 8,  /* of a scene pass: the other heap of indices */
} render_bind;

/* The render_bind bits of everything to bind for a draw with state `to` after one with state `from`; RENDER_NO_STATE:
 * `to` is the first of its command buffer. */
static inline uint32_t render_binds_between(stilb_render_materials materials, uint64_t from, uint64_t to)
{
	if (from == to)
		return 0;
	if (from == RENDER_NO_STATE) /* which binds indices, too */
		return RENDER_BIND_PIPELINE | RENDER_BIND_BUFFERS | RENDER_BIND_MATERIAL;
	uint32_t from_texture = render_state_entry(from), to_texture = render_state_entry(to);
	uint32_t binds = to_texture && to_texture != from_texture ? RENDER_BIND_MATERIAL : 0;
	uint64_t kinds = RENDER_STATE_PICTURE | RENDER_STATE_DETAIL | RENDER_STATE_IMPOSTOR | RENDER_STATE_MAPS;
	/* Pipelines with and without a texture, of pictures, fades, impostors and surfaces differ. */
	if (!from_texture != !to_texture || ((from ^ to) & kinds))
		binds |= RENDER_BIND_PIPELINE;
	if (to & RENDER_STATE_MAPS && (from ^ to) & RENDER_STATE_EXTRAS)
		binds |= RENDER_BIND_PIPELINE;
	if ((from ^ to) & RENDER_STATE_WIDE)
		binds |= RENDER_BIND_INDICES;
	if (render_state_material(from) != render_state_material(to))
		binds |= materials == STILB_RENDER_MATERIALS_PIPELINE ? RENDER_BIND_PIPELINE : RENDER_BIND_MATERIAL;
	return binds;
}

/* ---- devices ----------------------------------------------------------------------------------------------------- */

/* The lights of a view in the frame's memory: elements first .. first + count - 1. First come the panorama's lamps,
 * then lights that end nowhere, then the others, each kind in the scene's order. With RENDER_LIGHTS_LISTS these are
 * those that the view has, and of the others a pixel asks those in the list of its cell. */
typedef struct render_view_lights {
	uint32_t first, count;
	uint32_t endless;     /* so many of them end nowhere */
	uint32_t everywhere;  /* so many of them are asked by every pixel: with lists the endless ones, else all */
	uint32_t bits;        /* RENDER_LIGHTS_..., and 1 << stilb_scene_light_kind for each kind among the view's lights */
	uint32_t lists;       /* element of RENDER_MEMORY_LIGHT_LISTS where render_light_lists lies, or models' words */
	uint32_t shadows;     /* and where the render_shadow_map lie */
	uint32_t terms;       /* lights in the buffer of shadows; 0: there is none */
	uint32_t term_list;   /* and where their places among the view's lie, in the order of the buffer */
	uint32_t shadow_bits; /* RENDER_SHADOW_... */
	uint32_t list_ids;    /* of all lists together; by compute the room for them */
	uint32_t cells;   /* 1 + the pass's number: its lists are made by compute, of the stilb_light_cells at `lists` */
	uint32_t reached; /* and of the stilb_light_reached at this element; 0: jobs have made them */
	uint32_t grid[2]; /* columns | rows << 16, of tiles; log2 of a tile's pixels | slices << 8 */
} render_view_lights;

/* The lists of a view's cells as shaders read them (mesh.glsl): this; then for each cell where its list begins, and
 * once more where the last one ends; then the lists, of places among the lights that do not reach everywhere. */
typedef struct render_light_lists {
	float depth_plane[4]; /* as of stilb_light_lists */
	float slice_scale, slice_bias;
	uint32_t room; /* for so many places of lights; a longer list is that of all. By jobs UINT32_MAX */
	uint32_t all;  /* so many lights has the list of all, before the others; by jobs 0 */
	uint32_t words[];
} render_light_lists;

/* A shadow map as shaders read it (mesh.glsl). */
typedef struct render_shadow_map {
	float rows[4][4];                 /* the world to x and y in texels of its layer, depth, w */
	float area[4];                    /* left, top, right, bottom, texels; of a directional light: shadow_end */
	float layer, blend, left, filter; /* left: how many maps its light has from this one on */
	float map_error, view_error; /* metres at w = 1 of clip space; and at a distance of one metre from the camera */
	float widening;              /* texels that a lamp's size widens an edge by, over the difference of depths */
	float strength;              /* how dark a lamp's shadow is, 1: black */
} render_shadow_map;

static_assert(sizeof(render_shadow_map) == 112, "std430");
#define RENDER_MAX_SHADOW_MAPS 65536u

/* A stream: one pass as the device gets it, with its draws in their final order. */
typedef struct render_stream {
	const stilb_render_pass *pass;
	const stilb_render_view *view;  /* NULL: a 2D pass */
	const render_command *commands; /* of the frame; runs index into them */
	const render_run *runs;
	uint32_t run_count;
	const render_rows *rows; /* the scene's; NULL: no draw of the frame has one of these */
	uint64_t draws;          /* of all runs together */
	uint64_t states;         /* bitwise or of all runs' states */
	uint32_t kinds;          /* 1 << render_state_detail of the runs, and of those that passes like it will soon have */
	render_view_lights lights;       /* the view's */
	const render_light *written;     /* [lights.count] these, in the frame's memory */
	uint32_t beside;                 /* RENDER_BESIDE_... of rows that draw surfaces */
	const render_panorama *panorama; /* of the view; NULL: sky and ground */
} render_stream;

/* How a stream is replayed on this device. 2D passes have too few draws to gain from secondary command buffers. */
static inline stilb_render_replay_mode render_stream_mode(const render_device *device, const render_stream *stream)
{
	bool few = stream->pass->kind == STILB_RENDER_PASS_2D;
	return few && device->replay == STILB_RENDER_REPLAY_SECONDARY ? STILB_RENDER_REPLAY_DIRECT : device->replay;
}

/* ---- the module itself ------------------------------------------------------------------------------------------- */

/* Where the current frame stands; passes can be recorded in BEGUN alone. */
typedef enum render_frame_state {
	RENDER_FRAME_NONE,
	RENDER_FRAME_BEGUN,
	RENDER_FRAME_REPLAYED,
} render_frame_state;

/* A texture, with what tells whether another image fits into it. */
typedef struct render_scene_texture {
	stilb_render_texture texture;
	uint32_t width, height, levels; /* of its picture */
	stilb_image_format format;
	bool mapped, mips;         /* a surface has named it; so it was made with mips */
	bool as_normals, as_other; /* a surface has named it as a map of normals; as another map */
	render_mips_kind kind;
	bool arrived;                /* it has taken its stand-in's place; materials do not know yet */
	uint8_t loading;             /* render_loading_state; if not DONE `texture` is a stand-in */
	stilb_render_texture coming; /* COPIED: that which takes its place */
	stilb_image picture;         /* WAITS, MADE: the scene's, not owned */
	stilb_image refused; /* during an update that is made again: the image that the device does not take, not owned */
} render_scene_texture;

/* A function of the scene. */
typedef struct render_scene_function_entry {
	uint32_t index; /* of render_functions.h; 0: there is none, or the device did not take it */
	uint64_t hash;  /* render_function_hash of what the scene has; 0: nothing */
} render_scene_function_entry;

/* Handles of the resources of the scene that was set, by id in the scene; {0}: there is none with this id. */
struct render_scene {
	bool refused;                           /* an image of a texture */
	stilb_render_mesh *meshes;              /* [mesh_count] */
	stilb_render_material *materials;       /* [material_count] */
	render_scene_texture *textures;         /* [texture_count] */
	render_scene_function_entry *functions; /* [function_count] */
	uint32_t mesh_count, material_count, texture_count, function_count;
	uint32_t mesh_capacity, material_capacity, texture_capacity, function_capacity;
	stilb_render_impostor *impostors; /* [impostor_count] */
	uint32_t impostor_count, impostor_capacity;
	uint64_t impostors_removed; /* stilb_scene.impostors_removed of these */
	render_places places;       /* of its parts */
	render_loading *loading;    /* NULL: no texture ever was one that is loaded */
};

/* Frees the arrays of handles and destroys nothing, since that needs the device; leaves {0}. */
void render_scene_finish(render_scene *scene);

/* The parts of which a scene is made on the device; [any-thread], one at a time for each tables. */

/* Destroys what the scene holds. */
void render_scene_destroy(stilb_render *render, render_scene *tables);
/* Makes the tables as long as the scene's. */
stilb_result render_scene_fit(render_scene *tables, const stilb_scene *scene);
/* Textures that surfaces name get mips when they are made, which is announced. */
void render_scene_mark(stilb_render *render, render_scene *tables, const stilb_scene *scene);
/* Replaces a mesh; one without vertices is no mesh. On failure the one before stays. */
stilb_result render_scene_mesh(stilb_render *render, render_scene *tables, const stilb_scene *scene, uint32_t id);
/* A part may not name a mesh that was removed. */
stilb_result render_scene_check_parts(const stilb_scene *scene, const render_scene *tables);
/* Makes a texture that is not drawn before render_resources_hurry; or begins one that comes later. */
stilb_result render_scene_texture_patient(stilb_render *render, render_scene *tables, const stilb_scene *scene,
                                          uint32_t id);
stilb_result render_scene_function(stilb_render *render, render_scene *tables, const stilb_scene *scene, uint32_t id);
stilb_result render_scene_material(stilb_render *render, render_scene *tables, const stilb_scene *scene, uint32_t id);
/* Creates the scene's impostors that are new, after destroying all if they were removed. Their names, which the stream
 * hash and dumps have, come behind those of meshes and materials, whose number may have changed. */
stilb_result render_scene_impostors(stilb_render *render, render_scene *tables, const stilb_scene *scene);
/* Shows this scene in place of the one before, which is destroyed. [main-thread] */
void render_scene_replace(stilb_render *render, render_scene *next);

/* True if its passes draw depth alone. */
static inline bool render_view_is_depth(const stilb_render_view *view)
{
	return view->target && view->target->kind == STILB_RENDER_TARGET_DEPTH;
}

/* 1 + the channel that it shows in the place of light; 0: none. */
static inline uint32_t render_view_channel(const stilb_render_view *view)
{
	stilb_scene_surface_channel channel;
	return stilb_render_show_channel(view->show, &channel) && !render_view_is_depth(view) ? 1 + (uint32_t)channel : 0;
}

/* True if its passes draw light. */
static inline bool render_view_is_lit(const stilb_render_view *view)
{
	return !render_view_is_depth(view) && render_view_channel(view) == 0;
}

/* True if lights are counted in the place of light. */
static inline bool render_view_counts(const stilb_render_view *view)
{
	return view->show == STILB_RENDER_SHOW_LIGHTS && !render_view_is_depth(view);
}

/* True if there is something else in the place of radiance. */
static inline bool render_view_is_data(const stilb_render_view *view)
{
	return render_view_channel(view) > 0 || render_view_counts(view);
}

/* How the picture shows the view's radiance, or what is in its place: SHADE_TONE_... or RENDER_TONE_... */
static inline uint32_t render_view_tone(const stilb_render_view *view)
{
	static const uint32_t tones[] = {[STILB_SCENE_CHANNEL_LIGHT] = SHADE_TONE_NONE,
	                                 [STILB_SCENE_CHANNEL_DATA] = RENDER_TONE_DATA,
	                                 [STILB_SCENE_CHANNEL_COUNT] = RENDER_TONE_COUNT};
	uint32_t channel = render_view_channel(view);
	if (render_view_counts(view))
		return RENDER_TONE_LIGHTS;
	if (view->show == STILB_RENDER_SHOW_ERROR)
		return RENDER_TONE_ERROR;
	return channel == 0 ? view->tone : tones[stilb_scene_channel_kind_of((stilb_scene_surface_channel)(channel - 1))];
}

/* ---- device/render_ways.c ---- */

/* What a way of lighting does with the surfaces that can be lit later. */
typedef struct render_way {
	bool surfaces; /* draws them into images, which passes over the picture light */
	bool laid;     /* draws their depth first, and then what is seen of them */
	bool apart;    /* besides laid: adds up their light between the two */
	bool tiles;    /* makes lists of tiles between the two */
	bool indexed;  /* or the places of each pixel's lights */
} render_way;

/* True if the ways of lighting are some of the enumerations. */
bool render_view_lighting_is_known(const stilb_render_view *view);
/* Of the view's first pass into its target; {0}: all is drawn and lit at once. */
render_way render_view_way(const render_device *device, const stilb_render_view *view);
/* Which program shortens the lists of a view's way, that has lists of tiles or of pixels. */
render_tiles render_view_tiles(const render_device *device, const stilb_render_view *view);
/* True if a pass over the picture that lights the view's surfaces asks lights by bodies around them. */
bool render_view_has_volumes(const render_device *device, const stilb_render_view *view);
/* True if surfaces with these RENDER_MAPS_... can be lit later, or in several passes. */
bool render_maps_are_plain(uint64_t bits);
/* The bits (render_view_lights.bits) of the programs of a view with light_bits that draw its surfaces again for further
 * lights; 0: it is not lit so. */
uint32_t render_added_bits(const stilb_render_view *view, uint32_t light_bits);
/* The bits of programs that draw its surfaces into images. */
uint32_t render_gbuffer_bits(const stilb_render_view *view, uint32_t light_bits);
/* The bits of the passes over the picture that light what these images hold. */
uint32_t render_deferred_bits(const stilb_render_view *view, uint32_t light_bits);
/* How many images passes with such bits draw into. */
static inline uint32_t render_deferred_colors(uint32_t deferred_bits)
{
	return deferred_bits & RENDER_LIGHTS_APART && !(deferred_bits & RENDER_LIGHTS_GBUFFER8) ? RENDER_APART_IMAGES : 1;
}
/* The bits of programs that draw its surfaces where their depth has been drawn. */
uint32_t render_laid_bits(const stilb_render_view *view, uint32_t light_bits);
/* True if the view's first pass into its target draws the surroundings' light on what is plain apart. */
bool render_view_is_apart(const render_device *device, const stilb_render_view *view);
/* The bits of programs that draw it; and as light_bits, of what draws all other light. */
uint32_t render_around_bits(uint32_t light_bits);
uint32_t render_unlit_around_bits(uint32_t light_bits);
/* What a view's passes keep its light in, if what they draw allows it. */
stilb_render_hdr render_view_hdr(const stilb_render_view *view);
/* RENDER_SHADOW_... of programs that draw a view's surfaces and read maps, or that draw maps. */
uint32_t render_shadow_bits(const stilb_render_view *view);
/* True if the view's shadows are read from a buffer, if it has no more lights than that holds. */
bool render_view_has_buffer(const render_device *device, const stilb_render_view *view);
/* RENDER_SHADOW_... of programs that draw that; mask: they read STILB_RENDER_IMAGE_MASK. */
uint32_t render_terms_shadow_bits(uint32_t shadow_bits, bool mask);
/* Bits of these programs; _image: of the one that draws it by the images of surfaces, where the view has these. */
uint32_t render_terms_bits(uint32_t light_bits);
uint32_t render_terms_image_bits(const stilb_render_view *view, uint32_t light_bits);

/* ---- device/render_deferred.c ---- */

/* Adds the images of surfaces to a row: behind the target's radiance, or, of a way that is apart, alone. */
void render_deferred_attach(render_device *device, const stilb_render_view *view, render_frame_target *target,
                            stilb_gpu_pass *row);
/* render_view_data.far of the view. */
float render_deferred_far(const stilb_render_view *view);
/* Adds the images of surfaces and their depth to a row that lights them: its first uses. bits: render_deferred_bits. */
void render_deferred_use_surfaces(const render_frame_target *target, uint32_t bits, stilb_gpu_pass *row);
/* Adds the rows of the stream's lights. */
stilb_result render_deferred_lights(render_device *device, const struct render_stream *stream,
                                    render_frame_target *target, const render_push *push);
/* Adds the uses of what those rows of a way that is apart have added up, from the binding `slot` on. */
void render_deferred_use(const render_frame_target *target, uint8_t slot, stilb_gpu_pass *row);

/* By how much the matrix scales across (row 0) or up (row 1): that row is a unit direction of the camera times it, and,
 * where the camera looks beside the picture's middle, some of the way ahead. */
static inline float render_view_scale(const stilb_mat4 *view_projection, size_t row)
{
	const float *m = view_projection->m;
	float x = m[row], y = m[4 + row], z = m[8 + row];
	float along = x * m[3] + y * m[7] + z * m[11], ahead = m[3] * m[3] + m[7] * m[7] + m[11] * m[11];
	float square = x * x + y * y + z * z, beside = ahead > 0.0f ? along * along / ahead : 0.0f;
	return sqrtf(beside > 1e-8f * square ? square - beside : square); /* less is rounding */
}

/* Pixels of a picture of this height that a length of 1 at a distance of 1 has. */
static inline float render_view_pixels(const stilb_render_view *view, uint32_t height)
{
	return 0.5f * (float)height * render_view_scale(&view->view_projection, 1);
}

/* Writes the maps of the view's lights, if any has some, to the frame's memory, before it is placed. */
stilb_result render_shadows_place(stilb_render *render, const stilb_render_view *view, render_view_lights *lights);

/* ---- lights/render_shadows.c ---- */

/* Gives the view's lights out[0 .. lights->count - 1] that have maps their places in it, and writes the list. */
stilb_result render_shadows_list(stilb_render *render, const stilb_render_view *view, render_light *out,
                                 render_view_lights *lights);

/* ---- device/render_shadow.c ---- */

/* The image STILB_RENDER_IMAGE_MASK, if there is one and it is of this target; 0: there is none.
 * STILB_ERROR_ARGUMENT: it is of another size or format. */
stilb_result render_terms_mask(const render_device *device, const render_frame_target *target, uint16_t *mask);

/* Adds the images that a row reads which draws it, and, `layer` of it, what it draws into. mask: 0: there is none. */
stilb_result render_terms_attach(render_device *device, const struct render_stream *stream, render_frame_target *target,
                                 uint16_t mask, uint16_t layer, stilb_gpu_pass *row);

/* Adds the use of their image, or of one in its place, to a row whose uses so far are images. */
stilb_result render_shadow_use(render_device *device, const struct render_stream *stream,
                               const render_frame_target *target, stilb_gpu_pass *row);

/* ---- device/render_cells.c ---- */

/* Takes note of how many pairs the lists by compute had in the frame that the slot had before, before a frame's lights
 * are placed. */
void render_cells_read(render_device *device);
/* Takes note of how many the pass's lists by jobs have, which is newer than what frames on the device count. */
/* The frame does not run: what its programs would have counted is not known. */
void render_cells_forget(render_device *device);
void render_cells_know(render_device *device, uint32_t pass, uint32_t pairs);
/* Room for the lists of pass `pass`; 0: it is unknown how much they need, and jobs make them. */
uint32_t render_cells_room(render_device *device, uint32_t pass);
/* Adds the rows that make the stream's lists, and sets frame.light_lists; to 0 if jobs have made them. */
stilb_result render_cells_make(render_device *device, const struct render_stream *stream);
/* Adds the use of these to a row, if there are any. slot: where the row's constants have their address. */
void render_cells_use(const render_device *device, uint16_t slot, stilb_gpu_pass *row);

/* ---- device/render_programs.c ---- */

/* The program that makes what programs with _TILES or _INDEXED read, of a view with these bits that has lists;
 * compiled. [any-thread] */
stilb_result render_programs_tiles_of(render_device *device, const stilb_render_view *view, uint32_t light_bits,
                                      stilb_gpu_program *program);

/* ---- device/render_tiles.c ---- */

/* Adds the row that makes what programs with _TILES or _INDEXED read, and its use by such a row. The view has lists. */
stilb_result render_tiles_make(render_device *device, const struct render_stream *stream, render_frame_target *target,
                               const render_push *push, stilb_gpu_use *use);

/* ---- device/render_volumes.c ---- */

/* Adds the row that adds each light of the stream that ends, where its body encloses what is seen. row: its colours,
 * uses and constants. */
stilb_result render_volumes_add(render_device *device, const struct render_stream *stream, render_frame_target *target,
                                const render_formula_programs *choice, stilb_gpu_pass *row);

/* ---- panorama/render_panorama_ambient.c ---- */

/* What shaders read of what lights in place of the surroundings (mesh.glsl): radiance; the fourth of each is 0. */
typedef struct render_ambient {
	float sky[4], ground[4];
	float harmonics[9][4]; /* of SH_VERTEX and SH_PIXEL; else 0, as the next ones */
	float mirrored[4];     /* the share of each of their bands that highlights have at most */
} render_ambient;

/* Of a view and the panorama that it shows; NULL: its sky and ground. */
void render_ambient_of(const stilb_render_view *view, const render_panorama *panorama, render_ambient *out);

/* ---- lights/ ---- */

/* render_view_lights.bits of a view that shows a panorama with so many lamps, or none. */
uint32_t render_light_bits(const stilb_render_view *view, bool panorama, uint32_t lamps);

/* So many of the view's lights are lamps of the panorama that it shows; NULL: it shows none. */
static inline uint32_t render_view_lamps(const stilb_render_view *view, const render_panorama *panorama)
{
	return panorama && view->ambient != STILB_RENDER_AMBIENT_NONE ? panorama->lamp_count : 0;
}

/* What the frame needs of the view's panorama; NULL: it has none, or another than the frame. */
const render_panorama *render_view_panorama(const stilb_render *render, const stilb_render_view *view);

/* Writes the lights of the views that passes show to the frame's memory, before it is placed. placed: by pass. */
stilb_result render_lights_place(stilb_render *render, const stilb_render_pass *passes, uint32_t pass_count,
                                 const stilb_render_view *views, render_view_lights placed[STILB_RENDER_MAX_PASSES],
                                 stilb_job_pool *pool, uint32_t worker);

/* So many lights a pixel of a software device asks in one pass at most, as is measured: render_lights.c. */
#define RENDER_LIGHTS_LOOP 10922u

/* How large a view's lights are seen. */
typedef struct render_lights_fade {
	float pixels;       /* below which lights are gone; 0: none fades */
	float scale, apart; /* pixels of a metre: scale, divided by the distance where apart is 1 */
	const float *eye;
} render_lights_fade;

render_lights_fade render_lights_fade_of(const stilb_render *render, const stilb_render_view *view);
/* What distance leaves of a light, [0, 1]. */
float render_light_left(const render_lights_fade *fade, const stilb_scene_light *light);
/* The size of what the view draws into, pixels. */
void render_view_size(const stilb_render *render, const stilb_render_view *view, uint32_t *width, uint32_t *height);
/* Pixels of height at which the view's lights fade. */
uint32_t render_view_fade_height(const stilb_render *render, const stilb_render_view *view);

/* True if the light sends nothing beyond its reach. */
static inline bool render_light_ends(const stilb_scene_light *light)
{
	return light->kind != STILB_SCENE_LIGHT_DIRECTIONAL && light->falloff != STILB_SCENE_LIGHT_PHYSICAL;
}

/* ---- combined/render_combined.c ---- */

/* Chooses the lights of the pass's models among those of the view, which lie in the frame's memory as `lights` says,
 * and writes them there, before it is placed; sets lights->lists. STILB_ERROR_MEMORY. [main-thread] */
stilb_result render_combined_place(stilb_render *render, const stilb_render_view *view, const render_panorama *panorama,
                                   render_combined_pass *pass, render_view_lights *lights, stilb_job_pool *pool,
                                   uint32_t worker);

/* As render_light_bits, of rows that draw the view's velocities alone. */
static inline uint32_t render_velocity_bits(const stilb_render_view *view)
{
	return RENDER_LIGHTS_DEPTH | (view->both_sides ? RENDER_LIGHTS_SIDES : 0);
}

/* A draw that blends. */
typedef struct render_blend_item {
	float nearness;          /* larger: nearer */
	uint32_t material, mesh; /* names */
	uint32_t place;          /* in the order of recording */
	uint32_t command;        /* index among the frame's commands */
	uint64_t state;
} render_blend_item;

/* The draws of a class of groups in a pass. */
typedef struct render_order_class {
	uint32_t class;
	uint32_t draws;       /* how many; then where the next one goes */
	uint32_t first, last; /* 1 + those of its runs that are complete, in render_order_memory.moved; 0: none so far */
	render_run open;      /* the run that draws of its state join, without its count; state 0: none so far */
} render_order_class;

/* A run of a class, and 1 + the next one; 0: none. */
typedef struct render_order_run {
	render_run run;
	uint32_t next;
} render_order_run;

/* Memory of render_maps_order, kept from pass to pass. */
typedef struct render_order_memory {
	uint32_t *places;            /* [place_capacity] by class: 1 + its place in `classes`; between passes 0 */
	render_order_class *classes; /* [count] in the order in which they come first */
	uint32_t *of;                /* by run: place of its class; UINT32_MAX: it stays */
	render_order_run *moved;     /* [moved_count], runs of classes in the order in which they were complete */
	render_blend_item *items;
	uint32_t place_capacity, capacity, of_capacity, moved_capacity, item_capacity;
	uint32_t count, draws, runs, stretches; /* of all classes */
	uint32_t moved_count;
} render_order_memory;

/* Frees it. */
void render_order_finish(render_order_memory *order);

struct stilb_render {
	stilb_owner owner; /* the main thread */
	render_device *device;
	stilb_render_output output;
	stilb_render_specular_aa specular_aa;
	stilb_render_context *contexts;
	uint32_t context_count;
	render_resources resources;
	render_scene scene;
	stilb_job_pool *pool;       /* stilb_render_set_pool; NULL: none */
	atomic_int textures;        /* stilb_render_textures; relaxed: what is made by it is handed over by other means */
	render_rows *shown_rows;    /* the scene's, of which the last frame's draws are; NULL: it has none of a scene yet */
	render_rows *replaced_rows; /* tables of scenes before, which frames in flight may use */
	render_panorama panorama;   /* of the last frame that showed one */
	stilb_light_lists lists;    /* scratch memory of render_lights_place */
	bool told_loop;             /* that the device cannot ask all lights of a pixel */
	render_combined combined;   /* likewise */
	render_memory memory[RENDER_MEMORY_KINDS];
	render_pass_lists passes[STILB_RENDER_MAX_PASSES];
	uint32_t replayed[STILB_RENDER_MAX_PASSES]; /* this frame's passes in the order of their replay */
	uint32_t replayed_count;
	render_frame_state state;
	render_order_memory order;
	void *sort_items; /* [sort_capacity] scratch memory of render_sort */
	uint64_t sort_capacity;
};

/* How textures of scenes come now. [any-thread] */
static inline stilb_render_textures render_textures_mode(const stilb_render *render)
{
	/* partner: stilb_render_set_textures */
	return (stilb_render_textures)atomic_load_explicit(&render->textures, memory_order_relaxed);
}

/* Forgets the frame's passes. */
void render_passes_rewind(stilb_render *render);
/* Makes contexts empty again, keeping their memory. */
void render_contexts_rewind(stilb_render *render);
/* Replaces the contexts; after an error the old ones are still there. */
stilb_result render_contexts_create(stilb_render *render, uint32_t count);
void render_contexts_destroy(stilb_render *render);

/* stilb_render_stream_hash as a dump without the panorama replays the frame. */
uint64_t render_hash_plain(const stilb_render *render);

/* Grows the frame's memory to hold every claim, and copies into it those that had to go to the heap
 * (render_overflow). */
stilb_result render_memory_place(stilb_render *render);

/* Claims count > 0 elements of the frame's memory for the main thread, before render_memory_place; *first is their
 * position in it. Returns where to write them; NULL: no memory. */
void *render_claim(stilb_render *render, render_memory_kind kind, uint32_t count, uint32_t *first);

/* As stilb_render_draw_with_key, of a level of the mesh (0: the mesh in full; at most as many as it has), with the high
 * bits of its command's row word, and what they mean: render_state_detail. [one-writer] */
void render_draw_level(stilb_render_context *context, uint64_t key, stilb_render_mesh mesh,
                       stilb_render_material material, const stilb_mat4 *transform, uint32_t level, uint32_t detail,
                       uint32_t kind);

/* The same for a piece of a mesh with clusters: indices of the mesh itself, or, counted from behind its last one, of
 * its clusters' coarser versions. index_count > 0. [one-writer] */
void render_draw_clusters(stilb_render_context *context, uint64_t key, stilb_render_mesh mesh,
                          stilb_render_material material, const stilb_mat4 *transform, render_cluster_range range,
                          uint32_t detail, uint32_t kind);

/* Joins the runs of a recorded pass in replay order, and sorts them if the pass asks for it. */
stilb_result render_order(stilb_render *render, const stilb_render_pass *pass, render_pass_lists *lists);

/* Claims count commands behind the frame's commands; *first is the index of the first. */
stilb_result render_sort_claim(stilb_render *render, uint32_t count, uint32_t *first);

/* Moves the draws with maps of an ordered pass behind the others: those of each material together, unless the pass was
 * sorted, then those with transmission, and then what blends, from the farthest to the nearest as the view sees the
 * middle of their meshes. What blends and has transmission counts as the latter. */
stilb_result render_maps_order(stilb_render *render, const stilb_render_view *view, bool sorted,
                               render_pass_lists *lists);

/* Replaces a pass's runs by runs in ascending order of key; stable. */
stilb_result render_sort(stilb_render *render, render_pass_lists *lists);

/* Makes *array, which malloc or NULL made, hold at least count elements of `size` bytes, by doubling; contents are
 * kept. False: no memory, nothing has changed. */
static inline bool render_reserve(void **array, uint32_t *capacity, uint32_t count, size_t size)
{
	STILB_ASSERT(size > 0 && !*array == (*capacity == 0));
	if (count <= *capacity)
		return true;
	uint32_t larger = *capacity ? *capacity : 16;
	while (larger < count)
		larger = larger <= UINT32_MAX / 2 ? larger * 2 : UINT32_MAX;
	void *grown = realloc(*array, larger * size);
	if (!grown)
		return false;
	*array = grown;
	*capacity = larger;
	return true;
}

/* The frame's commands and rows, and the row of a command, for reading: after render_memory_place. */
static inline const render_command *render_commands(const stilb_render *render)
{
	return render->memory[RENDER_MEMORY_COMMANDS].data;
}

static inline const render_row *render_row_of(const stilb_render *render, const render_command *command)
{
	uint32_t index = render_command_row(command);
	if (command->row & RENDER_ROW_FRAME) {
		STILB_ASSERT(index < render->memory[RENDER_MEMORY_ROWS].capacity);
		return (const render_row *)render->memory[RENDER_MEMORY_ROWS].data + index;
	}
	STILB_ASSERT(render->shown_rows && index < render->shown_rows->capacity);
	return &render->shown_rows->data[index];
}

#endif
