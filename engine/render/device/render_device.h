/*
 * What render has on a device of gpu, and how a frame becomes a plan there: one row for each pass, and rows of its own
 * for the backdrop, the resolve and the tone map.
 *
 * Draws.     Vertices, indices, materials and rows are read by address or as vertex buffers, so that all draws of one
 *            kind of surface need the same bindings. A texture is a set with one image.
 * Images.    color gets the scene's linear radiance, picture what is shown; see device/render_images.h.
 * Threads.   [main-thread] but where it says another.
 */
#ifndef STILB_RENDER_DEVICE_H
#define STILB_RENDER_DEVICE_H

#include "base/base_contract.h"
#include "gpu/gpu_internal.h"
#include "render/device/render_arrays.h"
#include "render/render.h"
#include "render/render_panorama.h"
#include "render/render_resources.h"
#include "render/rows/render_rows.h"
#include "shading/shade_tonemap.h"

#include <pthread.h>
#include <stdatomic.h>

struct render_stream;
struct render_memory;

/* A buffer with what is asked of it often. {0}: none. */
typedef struct render_buffer {
	stilb_gpu_buffer buffer;
	uint64_t bytes, address;
	void *mapped;
} render_buffer;

/* A view as the shaders read it (shaders/mesh.glsl): what is in a buffer, and what is in constants. */
typedef struct render_view_data {
	float view_projection[16];
	float sky[4]; /* these two, harmonics and mirrored: of render_ambient */
	float ground[4];
	uint64_t extras, extra_places;  /* of the heaps of these */
	float time;                     /* seconds, for functions of surfaces */
	float half_size[2];             /* of what is drawn into, pixels */
	float far;                      /* the largest w of clip space that surfaces in 8 bits have */
	float last_view_projection[16]; /* for velocities alone */
	uint64_t last_vertices;         /* the heap of these */
	uint64_t shadows;               /* render_shadow_map */
	float from_clip[16];            /* clip space to the world */
	float harmonics[9][4];
	float mirrored[4];
	float jitter[2]; /* stilb_render_view.jitter */
	float exposure;  /* factor of radiance, where light is kept as exposed (stilb_render_hdr) */
	float unused;
} render_view_data;

static_assert(sizeof(render_view_data) == 448, "std430");

typedef struct render_view_push {
	float camera_position[4];
	float added[4];       /* added to every material's roughness, anisotropy, wrap and specular */
	float turn[2];        /* sine and cosine of the panorama's rotation */
	uint32_t light_count; /* that every pixel asks */
	float pixels;         /* of the picture's height that a length of 1 has at a distance of 1; of parallel views any */
	uint64_t lights, maps; /* the heap of these */
	uint64_t panorama;     /* of device.panorama: its table */
	uint64_t rest;         /* render_view_data */
	uint64_t lists;        /* render_light_lists */
	uint32_t grid[2];      /* of render_view_lights */
} render_view_push;

/* Constants of scene passes (shaders/mesh.glsl). With STILB_RENDER_MATERIALS_BIND `materials` is that of one material,
 * and each run has its own. */
typedef struct render_push {
	render_view_push view;
	uint64_t rows, materials, vertices, frame_rows;
} render_push;

static_assert(sizeof(render_push) == 128, "std430");

/* Constants of 2D passes (shaders/flat.vert). */
typedef struct render_push_2d {
	float scale[2]; /* pixels to clip space */
	uint64_t rows;
} render_push_2d;

/* What a backdrop that is more than a colour shows. */
typedef enum render_backdrop_kind {
	RENDER_BACKDROP_FLOOR, /* a colour, and a floor that models darken */
	RENDER_BACKDROP_SKY,   /* sky and ground */
	RENDER_BACKDROP_PANORAMA,
	RENDER_BACKDROP_MAP,
	RENDER_BACKDROPS,
} render_backdrop_kind;

/* Constants of shaders/backdrop.frag. */
typedef struct render_backdrop_push {
	float ahead[4], across[4], down[4];
	float camera[4];       /* of a floor */
	float color[4];        /* of a floor; of a sky that above */
	float floor_radius[4]; /* of a floor its center and radius; of a sky the ground's colour */
	float turn[2];         /* of a panorama: sine and cosine of its rotation */
	uint64_t data;         /* of a floor and a map: backdrop_data */
	float exposure;        /* factor of radiance, where light is kept as exposed */
	float padding;
} render_backdrop_push;

/* Constants of shaders/velocity/velocity_far.frag. */
typedef struct render_velocity_push {
	float ahead[4], across[4], down[4];
	float camera[4];
	float floor_radius[4]; /* center and radius of a studio's floor; radius 0: there is none */
	float half_size[2];    /* of the picture, pixels */
	uint64_t last;         /* render_view_data.last_view_projection */
} render_velocity_push;

/* Constants of shaders/resolve.frag and tone.frag. */
typedef struct render_tone_push {
	float exposure;                   /* factor of radiance */
	uint32_t dither;                  /* stilb_render_dither */
	int32_t left, top, width, height; /* of the rectangle of the picture that is filled */
	int32_t border;
	int32_t grade_size;
	float grade_low[4], grade_scale[4]; /* codes to entries: (code - low) scale */
} render_tone_push;

/* ---- programs ---------------------------------------------------------------------------------------------------- */

/* What the draws of a mesh program show. */
typedef enum render_surface {
	RENDER_SURFACE_PLAIN,    /* meshes whose material has no texture */
	RENDER_SURFACE_TEXTURE,  /* meshes with one */
	RENDER_SURFACE_IMPOSTOR, /* impostors, which always have one */
	RENDER_SURFACES,
} render_surface;

/* The materials that a mesh program draws (shaders/lit.glsl). */
typedef enum render_drawn {
	RENDER_DRAWN_ALL,
	RENDER_DRAWN_EVEN, /* STILB_RENDER_MATERIALS_PIPELINE: those with an even index */
	RENDER_DRAWN_ODD,
	RENDER_DRAWN_BOUND, /* STILB_RENDER_MATERIALS_BIND: the one whose address is bound */
	RENDER_DRAWN_KINDS,
} render_drawn;

/* Programs of 2D passes. */
typedef enum render_flat {
	RENDER_FLAT_PLAIN,
	RENDER_FLAT_TEXTURE,
	RENDER_FLAT_PICTURE, /* stilb_render_draw_picture */
	RENDER_FLATS,
} render_flat;

/* render_shaders.c */
extern const stilb_gpu_shader render_mesh_vertex[2][RENDER_SURFACES]; /* [1: vertices are packed] */
/* [1: highlights mirror the panorama] */
extern const stilb_gpu_shader render_mesh_fragment[2][RENDER_SURFACES];
/* Of meshes with maps: [1: vertices have extras]. Where depth alone is drawn those with a mask have _depth. */
extern const stilb_gpu_shader render_maps_vertex[2][2][2]; /* [1: with layers][1: vertices are packed] */
/* [1: with layers][1: see _mesh_fragment][1: a mask, several samples] */
extern const stilb_gpu_shader render_maps_fragment[2][2][2][2];
extern const stilb_gpu_shader render_through_fragment[2][2]; /* of draws with transmission: [1: see _mesh_fragment] */
extern const stilb_gpu_shader render_behind_fragment[2], render_behind_half_fragment; /* [1: several samples] */
extern const stilb_gpu_shader render_maps_depth[2][2];                                /* [1: velocities] */
/* Of materials with a function, whose fragment shaders come with it: as render_maps_vertex; as render_channel_vertex of
 * maps. */
extern const stilb_gpu_shader render_function_vertex[2][2][2], render_function_channel_vertex[2][2];

/* Of surfaces that are lit later, as render_mesh_fragment and [gloss][extras]; and of the pass that does. */
extern const stilb_gpu_shader render_gbuffer_mesh_fragment[2][RENDER_SURFACES], render_gbuffer_maps_fragment[2][2];
extern const stilb_gpu_shader render_deferred_fragment[2]; /* [1: whose surfaces are drawn again] */
extern const stilb_gpu_shader render_deferred_terms_fragment[2];
/* Of surfaces whose light is added up before they are drawn again: of the first time without what mirrors the panorama;
 * of the second as _gbuffer_... */
extern const stilb_gpu_shader render_slim_mesh_fragment[RENDER_SURFACES], render_slim_maps_fragment[2];
/* Of surfaces whose shares of light are drawn (stilb_render_shadow_reading.buffer). */
extern const stilb_gpu_shader render_terms_mesh_fragment[RENDER_SURFACES], render_terms_maps_fragment[2];
extern const stilb_gpu_shader render_images_mesh_fragment[2][RENDER_SURFACES], render_images_maps_fragment[2][2];
/* By render_cells. */
extern const stilb_gpu_shader render_cells_compute[];
/* The surroundings' light added to all other. */
extern const stilb_gpu_shader render_around_fragment;
/* How far two images are apart. */
extern const stilb_gpu_shader render_difference_fragment;
/* Velocities, normals and ids: [extras]. */
extern const stilb_gpu_shader render_seen_mesh_fragment[RENDER_SURFACES], render_seen_maps_fragment[2];
/* By render_tiles. */
extern const stilb_gpu_shader render_tiles_compute[];
/* Of bodies around lights, and of the depth that these are compared with. */
extern const stilb_gpu_shader render_volume_vertex, render_volume_depth_fragment;
/* Of channels in the place of light. Impostors keep their vertex shader. */
enum { RENDER_CHANNEL_MESH, RENDER_CHANNEL_MAPS, RENDER_CHANNEL_MAPS_EXTRAS, RENDER_CHANNEL_VERTICES };
extern const stilb_gpu_shader render_channel_vertex[2][RENDER_CHANNEL_VERTICES]; /* [1: packed] */
extern const stilb_gpu_shader render_channel_mesh_fragment[RENDER_SURFACES];
extern const stilb_gpu_shader render_channel_maps_fragment[2][2];   /* as render_maps_fragment[0] */
extern const stilb_gpu_shader render_flat_shaders[RENDER_FLATS][2]; /* [0: vertex shader, 1: fragment shader] */
/* Where depth alone is drawn. [1: velocities, too] */
extern const stilb_gpu_shader render_depth_fragment[2], render_impostor_depth_fragment[2], render_velocity_far_fragment;
extern const stilb_gpu_shader render_backdrop_fragment[2];                      /* [1: of a panorama] */
extern const stilb_gpu_shader render_resolve_fragment, render_tone_fragment[2]; /* [1: with a grade] */
extern const stilb_gpu_shader render_decode_fragment;                           /* of light in 8 bits */

/* The formulas that a program is compiled with, in the order of the shaders' specialization constants 2, 3, .... */
typedef enum render_formula {
	RENDER_FORMULA_BRDF,
	RENDER_FORMULA_NDF,
	RENDER_FORMULA_G,
	RENDER_FORMULA_F,
	RENDER_FORMULA_LIGHTS,  /* render_view_lights.bits */
	RENDER_FORMULA_SHADOWS, /* RENDER_SHADOW_... but RENDER_SHADOW_HDR; in shaders number 11 */
	RENDER_FORMULA_BESIDE,  /* RENDER_BESIDE_...; in shaders number 12 */
	RENDER_FORMULA_HDR,     /* a stilb_render_hdr: what light is kept in; in shaders number 13 */
	RENDER_FORMULAS,
} render_formula;

/* What programs draw beside the picture, each into images of its own (render_beside.c); beside depth the first three
 * and no picture (shaders/velocity/beside.glsl). */
#define RENDER_BESIDE_VELOCITY 1u
#define RENDER_BESIDE_ID 2u
#define RENDER_BESIDE_NORMAL 4u
#define RENDER_BESIDE_SEEN 7u   /* all three */
#define RENDER_BESIDE_AROUND 8u /* what surfaces send on of the surroundings' light, which is not in the picture then */
#define RENDER_BESIDE_MIRROR 16u /* besides it: how they mirror it */
#define RENDER_BESIDE_ALONE 32u  /* besides it: and no picture */

/* Those images, in the order of their places. */
typedef enum render_beside {
	RENDER_BESIDE_IMAGE_VELOCITY,
	RENDER_BESIDE_IMAGE_ID,
	RENDER_BESIDE_IMAGE_NORMAL,
	RENDER_BESIDE_IMAGE_AMBIENT,
	RENDER_BESIDE_IMAGE_REFLECTION,
	RENDER_BESIDE_IMAGE_MIRROR,
	RENDER_BESIDE_IMAGE_MIRROR_NORMAL,
	RENDER_BESIDE_IMAGES,
} render_beside;

#define RENDER_PROGRAM_KINDS 4u /* RENDER_DETAIL_KINDS */

/* Programs that make the lists of cells, in their order (render_cells.c). */
typedef enum render_cells {
	RENDER_CELLS_COUNT,
	RENDER_CELLS_SUM,
	RENDER_CELLS_FILL,
	RENDER_CELLS_PASSES,
} render_cells;

/* Programs that shorten lists by what is seen (render_tiles.c). */
typedef enum render_tiles {
	RENDER_TILES_DEPTH,   /* of tiles */
	RENDER_TILES_NORMALS, /* with the images of surfaces */
	RENDER_TILES_GLOSS,   /* with them and stilb_render_view.light_tolerance, for the view's formulas */
	RENDER_TILES_INDICES, /* of pixels */
	RENDER_TILES_KINDS,
} render_tiles;

/* A program of meshes whose material has maps. */
typedef struct render_maps_program {
	uint64_t key; /* render_maps_key */
	stilb_gpu_program program;
} render_maps_program;

/* bits: RENDER_MAPS_...; detail: render_state_detail. */
static inline uint64_t render_maps_key(uint64_t bits, uint32_t detail, render_drawn drawn)
{
	return (bits << 2 | detail) << 3 | drawn;
}

/* The mesh programs of one choice of formulas, by render_state_detail; {0}: not needed so far. */
typedef struct render_formula_programs {
	uint32_t formulas[RENDER_FORMULAS];
	stilb_gpu_program programs[RENDER_PROGRAM_KINDS][RENDER_SURFACES][RENDER_DRAWN_KINDS];
	/* Bit kind * RENDER_SURFACES + surface: made and compiled. Release when that is done, acquire by who needs them. */
	_Atomic uint32_t ready;
	render_maps_program *maps; /* [map_count] under the lock of programs */
	/* Under the lock: of passes over the picture with these lights, over bodies around them, and RENDER_TILES_GLOSS;
	 * {0}: not needed so far. */
	stilb_gpu_program deferred, volumes, gloss;
	uint32_t map_count, map_capacity;
} render_formula_programs;

/* True if they draw depth alone, or velocities with it. */
bool render_formulas_are_depth(const render_formula_programs *programs);
bool render_formulas_are_velocity(const render_formula_programs *programs);
/* True if they draw models with velocities. */
bool render_formulas_are_seen(const render_formula_programs *programs);
/* True if they draw surfaces whose lights come later. */
bool render_formulas_are_gbuffer(const render_formula_programs *programs);
/* True if they add up lights, so that they read the image of shadow maps, or one in its place. */
bool render_formulas_have_shadows(const render_formula_programs *programs);
/* True if their highlights mirror the panorama: they read the pass's three images of it (render_device_gloss). */
bool render_formulas_are_gloss(const render_formula_programs *programs);

/* What the tone map shows besides SHADE_TONE_...: channels in the place of light (stilb_scene_channel_kind). */
#define RENDER_TONE_DATA SHADE_TONE_COUNT
#define RENDER_TONE_COUNT (SHADE_TONE_COUNT + 1)
#define RENDER_TONE_LIGHTS (SHADE_TONE_COUNT + 2) /* and lights that were counted */
#define RENDER_TONE_ERROR (SHADE_TONE_COUNT + 3)  /* and how far light is from that of another view */
#define RENDER_TONES (SHADE_TONE_COUNT + 4)

typedef struct render_programs {
	pthread_mutex_t lock; /* guards all below */
	bool lock_made;
	render_formula_programs **choices; /* [choice_count] each stays where it is */
	uint32_t choice_count, choice_capacity;
	stilb_gpu_program flats[RENDER_FLATS], behind, behind_half, velocity_far;
	stilb_gpu_program backdrops[STILB_RENDER_HDRS][RENDER_BACKDROPS];
	stilb_gpu_program resolves[STILB_RENDER_HDRS], decodes[STILB_RENDER_HDRS]; /* of several samples, of one */
	stilb_gpu_program around, difference;
	stilb_gpu_program volume_depth, volume_count[2]; /* [1: with the bindings of what is apart] */
	stilb_gpu_program cells[RENDER_CELLS_PASSES];
	stilb_gpu_program tiles[RENDER_TILES_KINDS][2];   /* [1: with RENDER_LIGHTS_GBUFFER8] but for _GLOSS */
	stilb_gpu_program tones[2][RENDER_TONES];         /* [1: of an image with a place in the picture] */
	stilb_gpu_program grades[2][SHADE_TONE_COUNT][2]; /* likewise, with a table [1: of curves] after the tone map */
	struct render_function **functions;               /* [RENDER_MAX_FUNCTIONS] NULL: there is none with this index */
	stilb_gpu_program shows[3][4]; /* of floats, several samples, integers; by channels - 1; of the main thread */
	stilb_gpu_program show_layers; /* likewise, of all layers of an array */
} render_programs;

/* ---- the device -------------------------------------------------------------------------------------------------- */

/* What a frame in flight has of its own. */
typedef struct render_slot {
	render_buffer memory[6];               /* by render_memory_kind */
	render_buffer pairs;                   /* of lists by compute, by pass; {0}: none so far (render_cells.c) */
	bool counted[STILB_RENDER_MAX_PASSES]; /* the slot's last frame writes them */
	render_buffer views;                   /* render_view_data[STILB_RENDER_MAX_PASSES] */
	render_buffer backdrops[STILB_RENDER_MAX_PASSES]; /* what shaders/backdrop.frag reads; {0}: not needed so far */
} render_slot;

typedef struct render_device_texture {
	stilb_gpu_image image; /* its own, or the array's */
	stilb_gpu_set set;     /* {0}: not needed so far */
	uint32_t array;        /* 1 + render_arrays.items; 0: it has an image of its own, without mips */
	uint16_t layer;
} render_device_texture;

/* What draws of a group of maps bind. */
typedef struct render_device_maps {
	stilb_gpu_set set;
	uint64_t bits; /* RENDER_MAPS_... without _EXTRAS */
} render_device_maps;

/* Of a scene pass: all that a list can bind but maps, by detail, surface, width of the indices and half of the
 * materials. */
#define RENDER_BINDINGS (RENDER_PROGRAM_KINDS * RENDER_SURFACES * 2 * 2)

/* Of a frame: for each pass two of surfaces that are lit later or again (render_ways.c), one of the buffer of shadows,
 * one of the surroundings' light
 * (render_around.c), one of bodies around lights (render_volumes.c), up to three of others (render_through.c) and one
 * of velocities, one that shows nothing, and those of features. */
#define RENDER_MAX_LISTS (10u * STILB_RENDER_MAX_PASSES + 1u + STILB_RENDER_MAX_FEATURES)

/* The draws of a pass. */
typedef struct render_list {
	stilb_gpu_binding *bindings; /* [binding_capacity] */
	uint64_t *maps;              /* [map_capacity] by binding: of maps, 1 + its key; else 0 */
	uint32_t binding_capacity, map_capacity;
	uint32_t first_run; /* of device.runs */
	char name[64];      /* of its row */
} render_list;

#define RENDER_GBUFFER_IMAGES 3u /* besides radiance and depth */
/* By stilb_render_gbuffer: behind that of radiance. */
extern const stilb_gpu_format render_gbuffer_formats[STILB_RENDER_GBUFFER_KINDS][1 + RENDER_GBUFFER_IMAGES];

#define RENDER_APART_IMAGES 2u /* of light, and of highlights */

/* Rows of a frame for further lights and single lights, of all views, at most: the plan's limit is twice that. */
#define RENDER_LIGHT_ROWS 2048u
/* How many of them a view may add: half of what is left. */
static inline uint32_t render_light_rows_left(uint32_t used)
{
	return used < RENDER_LIGHT_ROWS ? (RENDER_LIGHT_ROWS - used + 1) / 2 : 0;
}

#define RENDER_MAX_LAYERS 256u /* of a target of kind DEPTH */

/* The images of a stilb_render_target in a frame. */
typedef struct render_frame_target {
	const stilb_render_target
		*from;                      /* NULL: the main images in the picture's size. The caller's, during replay alone */
	bool main;                      /* these are the main images */
	uint16_t color, samples, depth; /* resources of the plan; 0: it has none. samples: with several a pixel */
	uint16_t encoded;               /* likewise, what passes of one sample draw in place of color */
	stilb_render_hdr hdr;           /* what the light of passes is kept in */
	uint16_t behind;                /* as of render_through.c; 0: no pass has needed it so far */
	uint16_t beside[RENDER_BESIDE_IMAGES];    /* of one sample a pixel; 0: no view has asked for them so far */
	uint16_t velocity_depth;                  /* of rows that draw velocities alone; 0: there are none */
	uint16_t surfaces[RENDER_GBUFFER_IMAGES]; /* in the order of gbuffer.glsl; 0: as those */
	uint16_t terms;                           /* the buffer of shadows; 0: as those */
	uint16_t apart[RENDER_APART_IMAGES]; /* the light of PREPASS, or that of PRELIGHT and its highlights; 0: as those */
	char lights[STILB_GPU_MAX_NAME + 1]; /* name of the rows that light surfaces */
	stilb_result result;                 /* of making its image; else there is none */
	bool drawn;                          /* a pass has drawn into it */
	uint64_t layers_drawn[RENDER_MAX_LAYERS / 64]; /* likewise, a bit for each layer of depth alone */
	bool transparent;                              /* the backdrop is nothing, and alpha counts */
	uint32_t width, height;
	uint32_t tone; /* SHADE_TONE_... or RENDER_TONE_... */
	bool data;     /* there is something else in the place of radiance */
	float exposure;
	stilb_render_dither dither;
	const stilb_render_grade *grade; /* NULL: none. The caller's, during replay alone */
} render_frame_target;

/* The frame that is being made. */
typedef struct render_frame {
	uint16_t picture;          /* resource of the plan */
	bool begun;                /* the plan has been begun */
	bool ended;                /* all scene passes are there, and what makes the picture of them */
	uint16_t atlas;            /* the image of shadow maps if it is shown in the picture's place; 0: it is not */
	bool shown;                /* picture has content: of targets, or of 2D passes */
	uint16_t cube, dfg, light; /* resources of the plan: render_device's; 0: no pass reads them */
	uint16_t texels;           /* likewise */
	uint32_t empty_list;       /* 1 + the list without draws; 0: no pass needed one so far */
	uint16_t no_shadows;       /* the image that programs read where there are none; 0: as those */
	uint16_t light_lists;      /* of the pass that is being added, made by compute; 0: it has none of these */
	uint32_t views;            /* of slot.views that are in use */
	uint32_t backdrops;
	uint32_t list_count, own_lists, run_count; /* own_lists: those of features */
	uint32_t light_rows;                       /* that draw further lights of views, or one light */
	uint32_t target_count;
	render_frame_target targets[STILB_RENDER_MAX_PASSES];
	struct {
		uint32_t first, end;
	} added[STILB_RENDER_MAX_FEATURES]; /* by feature: its rows first .. end - 1 */
} render_frame;

typedef struct render_device {
	stilb_gpu *gpu;
	stilb_gpu_plan *plan;
	bool null;
	uint32_t width, height, samples;
	stilb_render_replay_mode replay;
	stilb_render_materials materials;
	stilb_render_output output;
	stilb_render_stats stats;
	bool packed;          /* vertices are: stilb_render_desc.float_vertices */
	render_layout layout; /* of vertices */

	render_slot slots[STILB_GPU_FRAMES];
	uint32_t slot;
	render_buffer heaps[RENDER_HEAPS];
	render_buffer panorama;            /* the table of the panorama that is shown; {0}: none */
	void *next_panorama;               /* RENDER_PANORAMA_BYTES of the one that is being made; NULL: none */
	stilb_gpu_image cube, next_cube;   /* render_panorama_gloss.cube: shown, and being made; {0}: none */
	stilb_gpu_image light, next_light; /* and .light */
	stilb_gpu_image texels;            /* and .texels, shown */
	stilb_gpu_image dfg;               /* of all panoramas; {0}: none so far */
	stilb_gpu_image no_shadows;        /* what programs read where there are no shadows; {0}: likewise */
	stilb_gpu_image lasting;           /* of a lasting target; {0}: likewise */
	stilb_gpu_extent lasting_extent;
	stilb_gpu_sampler cube_sampler;
	render_buffer volume_draw, volume_indices; /* of a body around a light; {0}: none so far */
	render_device_texture *textures;           /* [STILB_RENDER_MAX_TEXTURES] */
	render_arrays arrays;
	render_device_maps *maps;  /* [RENDER_MAX_MAPS] by group */
	uint32_t through;          /* of maps: those that light goes through */
	float anisotropy;          /* of samplers of maps; 1: none */
	stilb_gpu_sampler sampler; /* of all textures: linear, repeated, no mip levels */
	stilb_gpu_sampler linear;  /* clamped */
	render_programs programs;

	uint32_t pairs[STILB_RENDER_MAX_PASSES]; /* of each pass's lists, as is known last; UINT32_MAX: nothing */
	uint32_t rooms[STILB_RENDER_MAX_PASSES]; /* of those by compute */
	uint32_t most_room;                      /* UINT32_MAX; tests change it */
	bool own_rows;                           /* nothing is drawn beside the picture; likewise */

	render_frame frame;
	render_list lists[RENDER_MAX_LISTS];
	stilb_gpu_draws draws[RENDER_MAX_LISTS]; /* of the lists; those of features have no other member */
	stilb_gpu_run *runs;                     /* [run_capacity] of all lists but those of features */
	uint32_t run_capacity;
	stilb_render_feature features[STILB_RENDER_MAX_FEATURES]; /* [feature_count] */
	uint32_t feature_count;
	stilb_render_shown shown; /* its name is `shown_name`, or NULL */
	char shown_name[STILB_GPU_MAX_NAME + 1];
	char until[STILB_GPU_MAX_NAME + 1]; /* the pass that frames end with; "": the last */
	bool drawn, lit;                    /* the last frame ran, and had light; the size is still its own */
} render_device;

static inline stilb_gpu_format render_picture_format(const render_device *device)
{
	return device->output == STILB_RENDER_OUTPUT_LINEAR ? STILB_GPU_RGBA16_F : STILB_GPU_RGBA8_SRGB;
}

static inline render_slot *render_slot_now(render_device *device)
{
	return &device->slots[device->slot];
}

/* ---- render_device.c: life, memory, results ---------------------------------------------------------------------- */

stilb_result render_device_create(const stilb_render_desc *desc, render_device **device);
/* Waits for the device. Accepts NULL. */
void render_device_destroy(render_device *device);
/* STILB_ERROR_DEVICE: the GPU draws no pictures of that size; it is kept all the same, and frames cannot begin. */
stilb_result render_device_resize(render_device *device, uint32_t width, uint32_t height);
/* Takes the next of STILB_GPU_FRAMES slots in turn: waits until the device is done with the frame that used it last,
 * and fills in data and capacity of memory[RENDER_MEMORY_KINDS]. */
stilb_result render_device_frame_begin(render_device *device, struct render_memory *memory);
/* Replaces memory's data by an array of `capacity` elements that begins with the first `keep` of the old one. kind: a
 * render_memory_kind. */
stilb_result render_device_grow(render_device *device, struct render_memory *memory, uint32_t kind, uint32_t capacity,
                                uint32_t keep);
/* Shows the last frame's picture. */
stilb_result render_device_present(render_device *device);
stilb_result render_device_read_picture(render_device *device, stilb_image *image);
stilb_result render_device_read_light(render_device *device, stilb_image *image);

/* A buffer of that memory and these uses (STILB_GPU_BUFFER_...); on failure {0}. [any-thread] */
stilb_result render_buffer_make(render_device *device, const char *name, uint64_t bytes, stilb_gpu_memory memory,
                                uint32_t uses, render_buffer *buffer);
/* Destroys it once no frame can use it; leaves {0}. [any-thread] */
void render_buffer_drop(render_device *device, render_buffer *buffer);

/* ---- render_gloss.c: panoramas ----------------------------------------------------------------------------------- */

/* Memory for a panorama that frames will show. The one that is shown stays in place. NULL: there is none, and the
 * message says so. */
void *render_device_panorama_make(render_device *device, size_t bytes);
/* From this frame on they show that one, with this gloss. */
stilb_result render_device_panorama_show(render_device *device, const render_panorama_gloss *gloss);

/* ---- render_heaps.c: resources ----------------------------------------------------------------------------------- */

/* Copies what has changed in the heaps (render_heap.dirty) and new textures to the device, before the frame's passes.
 * The caller holds the lock of resources. */
stilb_result render_device_update(render_device *device, const render_resources *resources);
/* The textures' part of it. */
stilb_result render_device_textures_update(render_device *device, const render_resources *resources);
/* STILB_ERROR_ARGUMENT: the device has no such textures. [any-thread] */
stilb_result render_device_texture_check(const render_device *device, const render_texture_shape *shape);
/* Makes texture number `texture`; update copies the pixels. The caller holds the lock of render_resources.
 * [any-thread] */
stilb_result render_device_texture_create(render_device *device, uint32_t texture, const render_texture_shape *shape);
void render_device_texture_destroy(render_device *device, uint32_t texture);
/* The set of a draw with this texture alone. */
stilb_result render_device_texture_set(render_device *device, uint32_t texture, uint32_t *set);
/* Makes what the draws of group number `group` bind: the images and samplers of maps that are in it. The caller holds
 * the lock of render_resources. [any-thread] */
stilb_result render_device_maps_set(render_device *device, uint32_t group, const render_maps *maps);
void render_device_maps_drop(render_device *device, uint32_t group);
/* Copies upload->bytes into the ring; empties it first where they do not fit. */
stilb_result render_device_send(render_device *device, const stilb_gpu_upload *upload, const void *from);
/* Memory for rows that the CPU writes at any time, and frames read; freed once no frame can use it. [any-thread] */
stilb_result render_device_rows_make(render_device *device, uint32_t capacity, render_rows **rows);
void render_device_rows_free(render_device *device, render_rows *rows);

/* ---- render_programs.c ------------------------------------------------------------------------------------------- */

stilb_result render_programs_create(render_device *device);
void render_programs_destroy(render_device *device);
/* The programs for a view's formulas and light_bits, or, with RENDER_LIGHTS_DEPTH in these, for depth alone, compiled
 * for these kinds (render_stream.kinds) and surfaces, 1 << render_surface each. shadow_bits: RENDER_SHADOW_..., of
 * which those are left that such programs read. [any-thread] */
stilb_result render_programs_choose(render_device *device, const stilb_render_shading *wanted, uint32_t light_bits,
                                    uint32_t shadow_bits, uint32_t kinds, uint32_t surfaces,
                                    render_formula_programs **chosen);
/* Likewise, of programs that also draw what is `beside`. */
stilb_result render_programs_choose_beside(render_device *device, const stilb_render_shading *wanted,
                                           uint32_t light_bits, uint32_t shadow_bits, uint32_t beside, uint32_t kinds,
                                           uint32_t surfaces, render_formula_programs **chosen);
/* Makes choice->deferred, unless it is there; and, if asked for, choice->volumes and what that needs. All are compiled.
 * [any-thread] */
stilb_result render_programs_deferred(render_device *device, render_formula_programs *choice, bool volumes);
/* Makes programs.cells and compiles them, unless they are there. [any-thread] */
stilb_result render_programs_cells(render_device *device);
/* The program of that kind for images of surfaces with these bits, _GBUFFER8 or 0; compiled. [any-thread] */
stilb_result render_programs_tiles(render_device *device, const stilb_render_shading *shading, render_tiles kind,
                                   uint32_t bits, stilb_gpu_program *program);
/* The program of that choice and key; made and compiled unless it is there. {0}: its function has been destroyed
 * meanwhile. [any-thread] */
stilb_result render_programs_maps(render_device *device, render_formula_programs *choice, uint64_t key,
                                  stilb_gpu_program *program);
/* Gives a function its index, or, with NULL, frees the one that has it, with all of its programs. [any-thread] */
void render_programs_set_function(render_device *device, uint32_t index, struct render_function *function);
/* Adds what a program reads of vertices. */
void render_program_vertices(const render_device *device, render_surface surface, stilb_gpu_program_desc *desc);
/* Compiles what turns light into the picture. tone: also RENDER_TONE_...; placed: of an image with a place in it.
 * [any-thread] */
stilb_result render_programs_tone(render_device *device, uint32_t tone, bool placed);
/* The same with a table of colours, and the program. tone: SHADE_TONE_... [any-thread] */
stilb_result render_programs_grade(render_device *device, uint32_t tone, bool placed, bool curves,
                                   stilb_gpu_program *program);
/* Compiles what draws the backdrop into light that is kept so. [any-thread] */
stilb_result render_programs_backdrop(render_device *device, render_backdrop_kind kind, stilb_render_hdr hdr);
/* Compiles what makes the main images' light of several samples, or of 8 bits. [any-thread] */
stilb_result render_programs_hdr(render_device *device, stilb_render_hdr hdr);
/* What draws velocities where no model is. [any-thread] */
stilb_result render_programs_velocity(render_device *device);
/* What adds the surroundings' light where it is apart. [any-thread] */
stilb_result render_programs_around(render_device *device);
/* Compiles what compares two images. [any-thread] */
stilb_result render_programs_difference(render_device *device);
/* What copies the light behind draws with transmission. */
stilb_result render_programs_behind(render_device *device);
/* The kinds of maps that materials have. */
typedef struct render_known_maps {
	uint64_t *bits; /* [count] each once */
	uint32_t count, capacity;
	bool extras, plain; /* some meshes have extras; some have none */
} render_known_maps;

/* Makes the programs that draws of a scene pass with this view and light_bits need. [any-thread] */
stilb_result render_device_prepare(render_device *device, const stilb_render_view *view, uint32_t light_bits,
                                   const render_known_maps *maps);
/* Makes what draws velocities and what else is seen, but for programs of light that do so. Likewise */
stilb_result render_device_prepare_seen(render_device *device, const stilb_render_view *view,
                                        const render_known_maps *maps);

/* ---- render_frame.c: the plan ------------------------------------------------------------------------------------ */

/* Adds a pass to the frame. */
stilb_result render_device_pass(render_device *device, const struct render_stream *stream);
/* Gives the frame to the device. pool: its threads record secondary command buffers; NULL: the caller does. */
stilb_result render_device_run(render_device *device, stilb_job_pool *pool, uint32_t worker);

/* ---- render_through.c: what is seen through draws with transmission ---------------------------------------------- */

/* Adds the passes that copy what the target shows so far, with mips, to its image `behind`. */
stilb_result render_through_copy(render_device *device, const struct render_stream *stream,
                                 render_frame_target *target);
/* The use of that image, as the programs of such draws read it at this binding. */
stilb_result render_through_use(render_device *device, const render_frame_target *target, uint16_t slot,
                                stilb_gpu_use *use);

/* ---- render_velocity.c: where things were in the frame before, and what they are --------------------------------- */

/* Begins the target's image of velocities, unless it is there: with those of what is infinitely far away. view: the
 * address of its render_view_data. */
stilb_result render_velocity_begin(render_device *device, const struct render_stream *stream, uint64_t view,
                                   render_frame_target *target);
/* The depth of a row that draws velocities alone. */
stilb_gpu_attachment render_velocity_depth(render_device *device, const stilb_render_view *view,
                                           render_frame_target *target);

/* ---- render_beside.c: what is drawn beside the picture ----------------------------------------------------------- */

/* RENDER_BESIDE_... of what a view's passes draw: of what is seen, 0: nothing; of the surroundings' light; and of both
 * what rows that draw surfaces draw. What is not among it has rows of its own: of several samples a pixel; of channels
 * and counts in the place of light; of DEFERRED and TILED_DEFERRED normals and mirrors, for which their rows have no
 * room; and on devices that cannot leave some images as they are. */
uint32_t render_seen_bits(const stilb_render_view *view);
uint32_t render_around_beside_bits(const render_device *device, const stilb_render_view *view);
uint32_t render_beside_bits(const render_device *device, const stilb_render_view *view);
/* Adds the formats of what the choice's programs draw beside to those of `count` images; returns how many there are. */
uint32_t render_beside_formats(const render_formula_programs *choice, stilb_gpu_format formats[STILB_GPU_MAX_COLORS],
                               uint32_t count);
/* The place of an image among what the choice's programs draw into; -1: they do not draw it. And what it is. */
int render_beside_place(const render_formula_programs *choice, render_beside image);
const char *render_beside_name(render_beside image);
stilb_gpu_format render_beside_format(render_beside image);

/* ---- render_around.c: the surroundings' light apart from all other ----------------------------------------------- */

/* Adds the row that adds both images of it, or what has taken their place, to the target's radiance. */
stilb_result render_around_add(render_device *device, const render_frame_target *target, const uint16_t images[2]);

/* ---- render_target.c: what scene passes draw into ---------------------------------------------------------------- */

/* The frame's images for a view's target, or NULL: for the main ones; made when they are first asked for, with light in
 * that. */
render_frame_target *render_target_get(render_device *device, const stilb_render_target *target, stilb_render_hdr hdr);
/* Makes the image of a lasting target, unless it is there. */
stilb_result render_target_reserve(render_device *device, const stilb_render_target *target);
/* What passes draw light into. */
static inline uint16_t render_target_light(const render_frame_target *target)
{
	return target->samples ? target->samples : target->encoded ? target->encoded : target->color;
}
/* By stilb_render_hdr. */
extern const stilb_gpu_format render_hdr_formats[STILB_RENDER_HDRS];
/* The number of a list without draws among the frame's: of passes that clear alone. */
uint32_t render_target_nothing(render_device *device);
/* The name of what the target has besides colour and depth: of the main images `what`, else it stands behind the
 * target's. */
void render_target_name(const render_frame_target *target, const char *what, char name[STILB_GPU_MAX_NAME + 1]);
/* An image of that name, of the target's size, with one sample a pixel. output: it is read after the frame, if the
 * target's are. */
uint16_t render_target_image(render_device *device, const render_frame_target *target, const char *what,
                             stilb_gpu_format format, bool output);
/* Likewise, of so many layers; of this frame alone. */
uint16_t render_target_layers(render_device *device, const render_frame_target *target, const char *what,
                              stilb_gpu_format format, uint16_t layers);
/* The target's image of what is drawn beside the picture (render_beside.c), made when it is first asked for. */
uint16_t render_target_beside(render_device *device, render_frame_target *target, render_beside image);
/* Adds to a row what the choice's programs draw beside. */
void render_target_attach(render_device *device, const render_formula_programs *choice, render_frame_target *target,
                          stilb_gpu_pass *row);
/* The main images; NULL: the frame has none. */
render_frame_target *render_target_main(render_device *device);
/* Adds the passes that make light of samples, and of what is kept in 8 bits. */
void render_targets_resolve(render_device *device);
/* Adds the passes that show targets in the picture, main_light in the place of the main one's light. */
void render_targets_show(render_device *device, uint16_t main_light);

/* ---- render_compare.c -------------------------------------------------------------------------------------------- */

/* Adds the pass that compares the light of a target, without what features have made of it, with the reference; *light:
 * how far they are apart. STILB_ERROR_ARGUMENT: there is none. */
stilb_result render_target_compare(render_device *device, const render_frame_target *target, uint16_t *light);

/* ---- render_show.c ----------------------------------------------------------------------------------------------- */

/* Adds the pass that shows an image in the place of the picture. */
stilb_result render_show_image(render_device *device, const stilb_render_shown *shown);
/* Adds the row that shows all layers of an image of depth in its place. */
stilb_result render_show_layers(render_device *device, uint16_t image);

/* ---- render_until.c ---------------------------------------------------------------------------------------------- */

/* Ends the frame with the pass that device->until names, and shows device->shown, or what that pass has drawn into. */
stilb_result render_until(render_device *device);

/* ---- render_backdrop.c: what is seen where no model is ----------------------------------------------------------- */

/* True if it is more than the colour that the picture is cleared to. */
bool render_backdrop_is_drawn(const stilb_render_view *view, const render_panorama *panorama);
/* The radiance that the light is cleared to: of the backdrop, or of the sky or the ground. */
void render_backdrop_clear(const stilb_render_view *view, float color[4]);
/* Directions of the view: at the picture's middle, of length 1, and what a step of 1 in clip space adds to it. */
void render_backdrop_axes(const stilb_render_view *view, float ahead[4], float across[4], float down[4]);
/* What it shows. panorama: the view's is made. */
static inline render_backdrop_kind render_backdrop_kind_of(const stilb_render_view *view, bool panorama)
{
	if (view->backdrop.kind == STILB_SCENE_BACKDROP_COLOR)
		return RENDER_BACKDROP_FLOOR;
	if (view->backdrop.kind == STILB_SCENE_BACKDROP_SURROUNDINGS)
		return panorama ? RENDER_BACKDROP_PANORAMA : RENDER_BACKDROP_SKY;
	return RENDER_BACKDROP_MAP;
}
/* Sets its constants, and writes the rest of it to the slot's memory. */
stilb_result render_backdrop_write(render_device *device, const stilb_render_view *view,
                                   const render_panorama *panorama, render_backdrop_push *push);

#endif
