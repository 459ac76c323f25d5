/*
 * gpu: a device, its memory, and the execution of frames that are planned as tables (gpu_plan.h). It knows no scene, no
 * light and no mesh.
 *
 * Devices.       `vulkan` draws. `null` needs no driver: it checks and counts what a device would be given, and its
 *                buffers are memory, so that the CPU's side of a frame can be measured and tested anywhere.
 * Life cycle.    stilb_gpu_create -> buffers, images, samplers, programs, sets -> frames -> stilb_gpu_destroy.
 * Per frame.     stilb_gpu_frame_begin, a plan, stilb_gpu_frame_run, stilb_gpu_present.
 * Threads.       [main-thread] is the thread that created the device or was made its owner (stilb_gpu_own).
 *                [any-thread]: any, at any time, also while a frame runs.
 * Lifetime.      Whatever is destroyed is freed once no frame that may use it is in flight.
 * Limits.        Each call that a device's limit forbids is an error with the limit and a way out; none is left to the
 *                driver to crash on.
 */
#ifndef STILB_GPU_H
#define STILB_GPU_H

#include "gpu/gpu_device.h"
#include "gpu/gpu_plan.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

typedef struct stilb_gpu stilb_gpu;

/* ---- the device -------------------------------------------------------------------------------------------------- */

#define STILB_GPU_FRAMES 2u /* in flight */

/* What the device can do and how much. */
typedef struct stilb_gpu_limits {
	uint32_t image_side, image_side_3d, image_layers;            /* largest */
	uint32_t attachment_side;                                    /* of images that passes draw into */
	uint32_t color_attachments;                                  /* at most STILB_GPU_MAX_COLORS are used */
	uint32_t samplers_stage, images_stage, storage_images_stage; /* of one stage of a program */
	uint32_t uniforms_stage;                                     /* uniform buffers, likewise */
	uint32_t uniform_bytes,
		uniform_align; /* largest part of a buffer that is one; what its first byte is a multiple of */
	uint32_t group_size[3], group_invocations; /* of a dispatch's work group */
	uint32_t group_count[3];
	uint32_t shared_bytes; /* of a work group */
	uint32_t samples;      /* bits of sample counts that colour and depth images can have */
	uint64_t buffer_bytes;
	float anisotropy;    /* largest; 1: none */
	bool timestamps, bc; /* pass times; BC1 to BC7 */
	bool indirect_count; /* the number of indirect draws may come from a buffer */
	bool lines;          /* programs may draw the edges of triangles alone */
	bool counts;         /* programs may have a stencil, and images the format D32_F_S8 */
	bool some_colors;    /* programs may leave some colour attachments as they are */
} stilb_gpu_limits;

const stilb_gpu_limits *stilb_gpu_limits_get(const stilb_gpu *gpu);

/* The GPU's name, or "null". Valid as long as the device. [any-thread] */
const char *stilb_gpu_name(const stilb_gpu *gpu);
/* True if the device runs on the CPU. False for the null device. [any-thread] */
bool stilb_gpu_is_software(const stilb_gpu *gpu);
/* Messages of the validation layer so far. [main-thread] */
uint32_t stilb_gpu_validation_messages(const stilb_gpu *gpu);

/* ---- memory ------------------------------------------------------------------------------------------------------ */

/* Where a buffer lies and who writes it. */
typedef enum stilb_gpu_memory {
	STILB_GPU_MEMORY_DEVICE, /* the device alone */
	STILB_GPU_MEMORY_WRITE,  /* the CPU writes once, the device reads: in the device's memory if the CPU can map it */
	STILB_GPU_MEMORY_SHARED, /* the CPU writes and may read, the device reads: cached by the CPU */
	STILB_GPU_MEMORY_READ,   /* the device writes, the CPU reads: cached by the CPU */
} stilb_gpu_memory;

/* What a device's memory is used for. Memory comes from the driver in blocks of 64 MiB (less where the whole is small),
 * which buffers and images share; larger ones get a block of their own. */
typedef struct stilb_gpu_memory_report {
	uint64_t blocks, block_bytes; /* from the driver: how many, bytes together */
	uint64_t used_bytes;          /* of them, by `allocations` buffers and images */
	uint64_t allocations;
	uint64_t largest_free_bytes; /* the largest hole */
	double fragmentation;        /* 0: all that is free is one hole; 1: no hole is useful: 1 - largest / all free */
} stilb_gpu_memory_report;

stilb_gpu_memory_report stilb_gpu_memory_measure(stilb_gpu *gpu);

/* ---- buffers ----------------------------------------------------------------------------------------------------- */

typedef struct stilb_gpu_buffer {
	uint64_t id; /* 0: none */
} stilb_gpu_buffer;

#define STILB_GPU_BUFFER_ADDRESS 1u /* shaders read and write it by address */
#define STILB_GPU_BUFFER_VERTICES 2u
#define STILB_GPU_BUFFER_INDICES 4u
#define STILB_GPU_BUFFER_INDIRECT 8u
#define STILB_GPU_BUFFER_COPY 16u    /* copied from and to */
#define STILB_GPU_BUFFER_STORAGE 32u /* bound in a set */
#define STILB_GPU_BUFFER_UNIFORM 64u /* read by passes as STILB_GPU_USE_UNIFORM */

typedef struct stilb_gpu_buffer_desc {
	const char *name; /* for debuggers and messages; copied */
	uint64_t bytes;   /* > 0 */
	stilb_gpu_memory memory;
	uint32_t uses; /* STILB_GPU_BUFFER_... */
} stilb_gpu_buffer_desc;

/* STILB_ERROR_MEMORY, with the size; STILB_ERROR_ARGUMENT: larger than the device's buffers. [any-thread] */
stilb_result stilb_gpu_buffer_create(stilb_gpu *gpu, const stilb_gpu_buffer_desc *desc, stilb_gpu_buffer *out);
/* Accepts {0}. [any-thread] */
void stilb_gpu_buffer_destroy(stilb_gpu *gpu, stilb_gpu_buffer buffer);
/* The CPU's pointer to its bytes; NULL for STILB_GPU_MEMORY_DEVICE. [any-thread] */
void *stilb_gpu_buffer_mapped(stilb_gpu *gpu, stilb_gpu_buffer buffer);
/* The device's address of its bytes; needs STILB_GPU_BUFFER_ADDRESS. [any-thread] */
uint64_t stilb_gpu_buffer_address(stilb_gpu *gpu, stilb_gpu_buffer buffer);

/* ---- images and samplers ----------------------------------------------------------------------------------------- */

typedef struct stilb_gpu_image {
	uint64_t id; /* 0: none */
} stilb_gpu_image;

/* How sets see the channels of an image. */
typedef enum stilb_gpu_channels {
	STILB_GPU_CHANNELS_OWN,        /* as the format has them */
	STILB_GPU_CHANNELS_GREY,       /* red, red, red, 1 */
	STILB_GPU_CHANNELS_GREY_ALPHA, /* red, red, red, green */
	STILB_GPU_CHANNELS_COUNT
} stilb_gpu_channels;

typedef struct stilb_gpu_image_desc {
	const char *name;            /* copied */
	stilb_gpu_extent extent;     /* uses: SAMPLED, STORAGE..., COPY..., STILB_GPU_EXTENT_ATTACHMENT */
	stilb_gpu_channels channels; /* for images that are sampled by sets alone, or OWN */
} stilb_gpu_image_desc;

/* Its texels are undefined until they are written. STILB_ERROR_ARGUMENT: a size, a format or a use that the device has
 * not, with its limit; channels that are not OWN with uses but SAMPLED and copies. STILB_ERROR_MEMORY. [any-thread] */
stilb_result stilb_gpu_image_create(stilb_gpu *gpu, const stilb_gpu_image_desc *desc, stilb_gpu_image *out);
/* Accepts {0}. [any-thread] */
void stilb_gpu_image_destroy(stilb_gpu *gpu, stilb_gpu_image image);

typedef enum stilb_gpu_wrap { STILB_GPU_WRAP_CLAMP, STILB_GPU_WRAP_REPEAT, STILB_GPU_WRAP_MIRROR } stilb_gpu_wrap;
typedef struct stilb_gpu_sampler {
	uint8_t id; /* 0: nearest, clamped, first mip */
} stilb_gpu_sampler;
typedef struct stilb_gpu_sampler_desc {
	bool linear, mip_linear; /* filters; false: nearest */
	bool mips;               /* false: the first mip alone */
	uint8_t wrap[3];         /* stilb_gpu_wrap of u, v, w */
	uint8_t compare;         /* 0: none; 1: reversed depth, 1 where the texel is <= the reference */
	float anisotropy;        /* 0 or 1: none; at most the device's */
} stilb_gpu_sampler_desc;

/* The sampler of this description, made when it is first asked for; kept as long as the device. STILB_ERROR_ARGUMENT:
 * there are 255 already. [any-thread] */
stilb_result stilb_gpu_sampler_get(stilb_gpu *gpu, const stilb_gpu_sampler_desc *desc, stilb_gpu_sampler *out);

/* ---- sets: sampled images that draws of a list bind together ------------------------------------------------------
 * Set 1 of draw lists; set 0 is the pass's uses. Their images are those of programs (stilb_gpu_image_create). What a
 * plan draws into, writes, copies or has as an output is sampled by a use: stilb_gpu_frame_run refuses it in a set. */

typedef struct stilb_gpu_set {
	uint32_t id; /* 0: none */
} stilb_gpu_set;
/* How shaders see an item's image. */
typedef enum stilb_gpu_seen {
	STILB_GPU_SEEN_WHOLE, /* as it is: of several layers an array */
	STILB_GPU_SEEN_ARRAY, /* of shape 2D, an array also of one layer: sampler2DArray */
	STILB_GPU_SEEN_LAYER, /* of shape 2D, `layer` alone: sampler2D */
} stilb_gpu_seen;
typedef struct stilb_gpu_set_item {
	stilb_gpu_image image; /* {0}: a white texel */
	stilb_gpu_sampler sampler;
	uint8_t seen; /* stilb_gpu_seen */
	uint16_t layer;
} stilb_gpu_set_item;
#define STILB_GPU_MAX_SET_ITEMS 16u

/* Every binding of a set is always written. A run's set has as many items as its program asks for (set_items).
 * STILB_ERROR_ARGUMENT: the count, or an item's image, layer or sampler; STILB_ERROR_MEMORY. [any-thread] */
stilb_result stilb_gpu_set_create(stilb_gpu *gpu, const stilb_gpu_set_item *items, uint32_t count, stilb_gpu_set *out);
void stilb_gpu_set_destroy(stilb_gpu *gpu, stilb_gpu_set set);

/* ---- programs: shaders and the state that they run with --------------------------------------------------------- */

typedef struct stilb_gpu_program {
	uint32_t id; /* 0: none */
} stilb_gpu_program;

typedef struct stilb_gpu_shader {
	const uint32_t *words; /* SPIR-V; copied */
	size_t bytes;
	const char *source; /* what it was compiled of; copied. stilb_gpu_shaders_replace finds it by this text; NULL: it is
	                       never replaced */
} stilb_gpu_shader;

typedef enum stilb_gpu_blend {
	STILB_GPU_BLEND_NONE,
	STILB_GPU_BLEND_PREMULTIPLIED, /* source + (1 - alpha) * target */
	STILB_GPU_BLEND_ADD,
	STILB_GPU_BLEND_MULTIPLY, /* source * target; alpha stays the target's */
} stilb_gpu_blend;

typedef enum stilb_gpu_compare {
	STILB_GPU_COMPARE_NONE,
	STILB_GPU_COMPARE_GREATER,
	STILB_GPU_COMPARE_GREATER_EQUAL,
	STILB_GPU_COMPARE_EQUAL
} stilb_gpu_compare;

/* What programs do with the stencil of their depth attachment, a number of 8 bits that LOAD_CLEAR makes 0. */
typedef enum stilb_gpu_stencil {
	STILB_GPU_STENCIL_NONE,
	/* No colour is written. Where the depth test fails, triangles that are clockwise in the picture add 1, the others
	 * take 1 away, modulo 256. Depth is clamped, not clipped, so that a closed surface leaves a number other than 0
	 * just where it encloses the depth that is there. Needs stilb_gpu_limits.counts. */
	STILB_GPU_STENCIL_COUNT,
	/* Draws where the stencil is not 0, and sets it to 0; where the shader discards, it stays. Depth is clamped here,
	 * too. */
	STILB_GPU_STENCIL_COUNTED,
} stilb_gpu_stencil;

#define STILB_GPU_MAX_SPECIALIZATIONS 16u
#define STILB_GPU_MAX_VERTEX_INPUTS 8u

typedef struct stilb_gpu_vertex_input {
	uint8_t location, format; /* stilb_gpu_format */
	uint16_t offset;
} stilb_gpu_vertex_input;

typedef struct stilb_gpu_program_desc {
	const char *name;                  /* copied */
	stilb_gpu_shader vertex, fragment; /* FULLSCREEN programs: vertex {0}, then the triangle over the area with uv 0..1
	                                      at location 0 */
	stilb_gpu_shader compute;          /* alone */
	uint8_t samplers;                  /* bindings 0 .. of set 0 that are sampled images */
	uint8_t storage_images;            /* bindings behind them */
	uint8_t uniforms;                  /* and behind these, that are uniform buffers */
	uint8_t set_items;                 /* bindings of set 1, of draw lists */
	uint8_t depth;                     /* stilb_gpu_compare; NONE: no test */
	uint8_t stencil;                   /* stilb_gpu_stencil */
	bool depth_write;
	bool cull_back; /* triangles that are clockwise in the picture */
	bool lines;     /* of triangles the edges alone, a pixel wide; needs stilb_gpu_limits.lines */
	uint8_t blend;  /* stilb_gpu_blend, of every colour attachment */
	uint8_t colors; /* so many attachments, the first ones, it draws into, and leaves the others as they are; 0: into
	                   all. Needs stilb_gpu_limits.some_colors */
	bool alpha_to_coverage;
	float depth_bias, depth_bias_slope;
	uint16_t vertex_bytes; /* stride; 0: no vertex buffer */
	uint8_t input_count;
	stilb_gpu_vertex_input inputs[STILB_GPU_MAX_VERTEX_INPUTS];
	uint8_t constant_count;
	struct {
		uint32_t id, value;
	} constants[STILB_GPU_MAX_SPECIALIZATIONS]; /* specialization constants, as bits */
} stilb_gpu_program_desc;

/* Checks the program against the device's limits, and its SPIR-V against the rest of the description: bindings, vertex
 * inputs, specialization constants, and what its stages hand on. Pipelines, one for each
 * combination of attachment formats and samples, are compiled when a pass first needs them, or by
 * stilb_gpu_program_prepare. [any-thread] */
stilb_result stilb_gpu_program_create(stilb_gpu *gpu, const stilb_gpu_program_desc *desc, stilb_gpu_program *out);
void stilb_gpu_program_destroy(stilb_gpu *gpu, stilb_gpu_program program);
/* Compiles what a pass with these attachments needs, unless it is there. [any-thread] */
stilb_result stilb_gpu_program_prepare(stilb_gpu *gpu, stilb_gpu_program program, const stilb_gpu_format *colors,
                                       uint32_t color_count, stilb_gpu_format depth, uint32_t samples);

/* Puts shaders in the place of those with the same `source`: in all programs that have one, and in those that will be
 * created; all of them or none. Each program is checked as by stilb_gpu_program_create, and gets its pipelines here,
 * one for each combination of attachments that it has been used with. Programs keep their ids. All have the new shaders
 * from one frame on: the next that begins while no stilb_gpu_program_prepare of one of them runs. What they were is
 * destroyed once no frame can use it. count > 0, and each shader has a source. *programs, unless NULL: how many have
 * changed. Errors as of stilb_gpu_program_create; nothing has changed then. [any-thread] */
stilb_result stilb_gpu_shaders_replace(stilb_gpu *gpu, const stilb_gpu_shader *shaders, uint32_t count,
                                       uint32_t *programs);
/* The sources of all programs so far, each once, in the order in which they came: number `index`; NULL: there are no
 * more. Valid as long as the device. [any-thread] */
const char *stilb_gpu_shader_source(stilb_gpu *gpu, uint32_t index);

/* ---- uploads ------------------------------------------------------------------------------------------------------
 * From any thread into a ring of memory that the device can read, copied on to their places before the passes of the
 * next frame that runs. */

/* Where an upload goes: bytes of a buffer, or texels of one mip and layer of an image, tightly packed. */
typedef struct stilb_gpu_upload {
	stilb_gpu_buffer buffer; /* or */
	stilb_gpu_image image;
	uint64_t offset;                        /* buffers */
	uint16_t mip, layer;                    /* images */
	uint32_t x, y, z, width, height, depth; /* images, texels, whole blocks */
	uint64_t bytes;
} stilb_gpu_upload;

/* An upload waits for the frame that runs after its end; all are copied, or as many as stilb_gpu_desc.upload_frame
 * allows, in the order in which they were begun. That bound is for programs that stream while they draw, and look
 * themselves whether what they draw with has arrived. An image whose other mips and layers nobody has written can be
 * sampled; what is there is undefined.
 * Memory to write the upload's bytes to, before stilb_gpu_upload_end; *bytes is NULL where the ring has no room now:
 * try again after the next frame, or on the main thread after stilb_gpu_upload_flush. STILB_ERROR_ARGUMENT: outside of
 * the target, or more than the ring holds at all (stilb_gpu_upload_most). [any-thread] */
stilb_result stilb_gpu_upload_begin(stilb_gpu *gpu, const stilb_gpu_upload *upload, void **bytes);
void stilb_gpu_upload_end(stilb_gpu *gpu, void *bytes);
uint64_t stilb_gpu_upload_most(const stilb_gpu *gpu);
/* Copies the uploads that have ended, now, and waits until the device is done with all that it was given: then the ring
 * has room for all that no other thread is writing. STILB_ERROR_MEMORY, STILB_ERROR_DEVICE, STILB_ERROR_DEVICE_LOST:
 * the uploads still wait. [main-thread] */
stilb_result stilb_gpu_upload_flush(stilb_gpu *gpu);

/* ---- draw lists ------------------------------------------------------------------------------------------------- */

/* One draw: laid out as VkDrawIndexedIndirectCommand, 32 bytes apart; what follows its 20 bytes is the caller's. */
#define STILB_GPU_DRAW_STRIDE 32u

/* What many runs of a list have in common. */
typedef struct stilb_gpu_binding {
	uint32_t program;    /* stilb_gpu_program.id; 0: the pass's */
	uint8_t index_bytes; /* 2, 4 */
	uint64_t indices;    /* stilb_gpu_buffer.id */
	uint64_t vertices;   /* or 0 */
	uint32_t scissor[4]; /* x, y, width, height in texels; width 0: all that the pass fills, as it is cut to that */
} stilb_gpu_binding;

/* Consecutive draws that need the same bindings. */
typedef struct stilb_gpu_run {
	uint32_t first, count; /* of the list's draws */
	uint32_t binding;      /* index into the list's bindings */
	uint32_t set;          /* stilb_gpu_set.id, or 0 */
	uint64_t constant;     /* if the list has some: this run's */
} stilb_gpu_run;

typedef enum stilb_gpu_replay {
	STILB_GPU_REPLAY_INDIRECT,  /* one command a run, read by the device where the draws lie */
	STILB_GPU_REPLAY_DIRECT,    /* one command a draw */
	STILB_GPU_REPLAY_SECONDARY, /* likewise, in command buffers that several threads fill */
} stilb_gpu_replay;

typedef struct stilb_gpu_draws {
	const void *draws;         /* the CPU's pointer to draw 0, STILB_GPU_DRAW_STRIDE apart */
	stilb_gpu_buffer commands; /* the buffer in which they lie, from its byte `offset` on */
	uint64_t offset;
	const stilb_gpu_binding *bindings; /* [binding_count] few: the cost of one is that of a program's change */
	const stilb_gpu_run *runs;         /* [run_count] */
	uint32_t binding_count, run_count;
	stilb_gpu_replay replay;
	bool has_constants;     /* runs have 8 bytes each in place of those of the pass's constants */
	uint8_t constant_place; /* at this byte of them, a multiple of 8 */
} stilb_gpu_draws;

/* Runs task(0 .. count - 1, context), maybe on several threads, and returns when all are done. */
typedef struct stilb_gpu_threads {
	void *user;
	uint32_t count; /* into how many parts work should be cut; 0: none of this, all on the calling thread */
	void (*run)(void *user, uint32_t count, void (*task)(uint32_t index, void *context), void *context);
} stilb_gpu_threads;

/* ---- creation, frames, results ---------------------------------------------------------------------------------- */

typedef struct stilb_gpu_desc {
	stilb_gpu_kind kind;
	const char *name;                 /* a number or a part of a name as `stilb info` prints them; NULL: the best */
	const stilb_gpu_surface *surface; /* NULL: no window */
	stilb_gpu_presentation presentation;
	uint32_t width, height; /* of pictures in a window that says no size of its own, pixels; 0: 1280 x 720 */
	bool validate;          /* the Vulkan validation layer, with synchronization checks */
	uint64_t upload_bytes;  /* of the ring; 0: 32 MiB */
	uint64_t upload_frame;  /* bytes of uploads that one frame copies, at least one upload; 0: all that have ended */
	stilb_gpu_faults faults;
} stilb_gpu_desc;

/* Takes the calling thread as the main thread. Errors: the name, no driver, a missing feature, a window that
 * the device cannot present to, memory. On failure *gpu is NULL. */
stilb_result stilb_gpu_create(const stilb_gpu_desc *desc, stilb_gpu **gpu);
/* Waits for the device. Accepts NULL. [main-thread] */
void stilb_gpu_destroy(stilb_gpu *gpu);
/* From now on the calling thread is the main thread. [any-thread] */
void stilb_gpu_own(stilb_gpu *gpu);

/* Waits until the device has finished the frame before the last, and frees what is not needed any more.
 * STILB_ERROR_DEVICE_LOST. [main-thread] */
stilb_result stilb_gpu_frame_begin(stilb_gpu *gpu);

/* The functions that stilb_gpu_plan_make asks. [any-thread] */
stilb_gpu_planner stilb_gpu_planner_of(stilb_gpu *gpu);

/* Hands a frame to the device: its uploads, then the plan's passes. lists: by stilb_gpu_pass.draws. Plan, lists and
 * what they point to are read during the call alone, but for the draws' buffers. STILB_ERROR_MEMORY,
 * STILB_ERROR_DEVICE, STILB_ERROR_DEVICE_LOST: the frame is not drawn, and its uploads wait for the next one; tell the
 * plan (stilb_gpu_plan_dropped). [main-thread] */
stilb_result stilb_gpu_frame_run(stilb_gpu *gpu, const stilb_gpu_plan *plan, const stilb_gpu_draws *lists,
                                 uint32_t list_count, const stilb_gpu_threads *threads);

/* Shows an output of the last frame in the window: copied, and scaled where sizes differ. Without a window it does
 * nothing. Errors as stilb_render_present. [main-thread] */
stilb_result stilb_gpu_present(stilb_gpu *gpu, const stilb_gpu_plan *plan, uint16_t image);

/* From now on pictures are shown in this window; NULL: in none. See stilb_render_set_surface. [main-thread] */
stilb_result stilb_gpu_set_surface(stilb_gpu *gpu, const stilb_gpu_surface *surface);
/* True if there is a window; and the presentation that it uses. [main-thread] */
bool stilb_gpu_in_window(const stilb_gpu *gpu);
stilb_gpu_presentation stilb_gpu_presentation_used(const stilb_gpu *gpu);

/* Asks for a copy of an output of the last frame, mip and layer; nothing waits. *ticket names it.
 * STILB_ERROR_ARGUMENT: it is no output of the last frame. [main-thread] */
stilb_result stilb_gpu_read_begin(stilb_gpu *gpu, const stilb_gpu_plan *plan, uint16_t resource, uint8_t mip,
                                  uint16_t layer, uint64_t *ticket);
/* What a ticket has given: texels tightly packed, or a buffer's bytes, and the number of the frame that they belong to.
 * *bytes is NULL while the device is not done; wait: waits for it. Valid until stilb_gpu_read_end, which may also give
 * the ticket up. [main-thread] */
stilb_result stilb_gpu_read_get(stilb_gpu *gpu, uint64_t ticket, bool wait, const void **bytes, uint64_t *frame);
void stilb_gpu_read_end(stilb_gpu *gpu, uint64_t ticket);

/* Waits until every submitted frame is done. [main-thread] */
stilb_result stilb_gpu_wait(stilb_gpu *gpu);

/* Counters of the last frame. */
typedef struct stilb_gpu_stats {
	uint64_t frame;             /* its number, from 1 */
	uint64_t passes, barriers;  /* barriers: stilb_gpu_barrier */
	uint64_t draw_commands;     /* that make a single draw */
	uint64_t indirect_commands; /* that make many */
	uint64_t execute_commands;  /* secondary command buffers executed */
	uint64_t binds;             /* of lists: a program, a run's set and constant, a buffer of indices */
	uint64_t uploaded_bytes;
	uint64_t submit_ns; /* that the driver took to be given the frame, once it was recorded; 0 on the null device */
	double gpu_ms;      /* of the last frame whose time is known; 0 on the null device */
} stilb_gpu_stats;
stilb_gpu_stats stilb_gpu_stats_get(const stilb_gpu *gpu); /* [main-thread] */

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
