/*
 * gpu: the frame as a table. Images and passes are rows of plain data; the plan finds out from the rows alone what a
 * device must do between the passes, and which images can share memory.
 *
 * How it works.  Each frame the rows are written anew, in the order in which the passes run: stilb_gpu_plan_begin, one
 *                call for each image and each pass, stilb_gpu_plan_make. That checks every row, leaves out passes whose
 *                results nobody reads, finds the barriers between passes, down to single mips and layers, and gives
 *                images that live only within the frame places in shared memory. The result is plain data, too: the
 *                Vulkan device follows it, the null device checks and counts it, dumps and --plan show it.
 * Order.         The table's order is the order. Nothing is moved: a pass that reads what only a later one writes is a
 *                mistake, unless it asks for last frame's.
 * Cost.          Some 80 ns a pass and its image from writing the rows to the null device's run, if all passes touch
 *                what last frame's did, with other programs and constants or not; else three times that.
 * Frames.        A plan knows what its last frame left: kept, output and owned resources, and the shared memory, are
 *                where and how the last plan left them. So the frames of one plan run on one device and one queue, in
 *                the order in which they were made, each whole or not at all (stilb_gpu_plan_dropped).
 * Barriers.      The fewest that do, each before the pass that needs it. A pass touches a part of an image in one way:
 *                two uses that need different layouts, or of which one writes, are a mistake.
 * Left out.      A pass whose results nobody reads does not run. Outputs, shown, kept and owned resources count as
 *                read. A frame can be cut after a pass, to see what there is by then (stilb_gpu_plan_cut).
 * Queues.        A pass may ask for a queue beside the main one; the plan says which steps must then wait for which. On
 *                a device with one queue, as Vulkan's is here, the table's order is all.
 * Threads.       A plan belongs to one thread at a time and needs no device.
 * Example.       A scene in half floats, and a fullscreen pass that tone maps it into the picture:
 *
 *   stilb_gpu_plan_begin(plan, 1280, 720);
 *   uint16_t color = stilb_gpu_plan_image(plan, &(stilb_gpu_plan_image_row){.name = "color",
 *                                                                           .format = STILB_GPU_RGBA16_F,
 *                                                                           .scale = 1.0f});
 *   uint16_t depth = stilb_gpu_plan_image(plan, &(stilb_gpu_plan_image_row){.name = "depth",
 *                                                                           .format = STILB_GPU_D32_F,
 *                                                                           .scale = 1.0f});
 *   uint16_t picture = stilb_gpu_plan_image(plan, &(stilb_gpu_plan_image_row){.name = "picture",
 *                                                                             .format = STILB_GPU_RGBA8_SRGB,
 *                                                                             .scale = 1.0f,
 *                                                                             .output = true});
 *   stilb_gpu_plan_pass(plan, &(stilb_gpu_pass){
 *       .name = "scene",
 *       .kind = STILB_GPU_PASS_DRAWS,
 *       .color = {{.image = color, .load = STILB_GPU_LOAD_CLEAR}},
 *       .color_count = 1,
 *       .depth = {.image = depth, .load = STILB_GPU_LOAD_CLEAR},
 *       .draws = 0,
 *   });
 *   stilb_gpu_plan_pass(plan, &(stilb_gpu_pass){
 *       .name = "tone",
 *       .kind = STILB_GPU_PASS_FULLSCREEN,
 *       .color = {{.image = picture, .load = STILB_GPU_LOAD_DISCARD}},
 *       .color_count = 1,
 *       .uses = {{.resource = color, .how = STILB_GPU_USE_SAMPLED}},
 *       .use_count = 1,
 *       .program = tone,
 *   });
 *   stilb_result result = stilb_gpu_plan_make(plan, needs);
 */
#ifndef STILB_GPU_PLAN_H
#define STILB_GPU_PLAN_H

#include "gpu/gpu_format.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* ---- resources: images and buffers that passes name --------------------------------------------------------------
 * One number space for both; 0 is none. Valid for the frame whose plan gave it. */

#define STILB_GPU_PLAN_MAX_RESOURCES 4096u
#define STILB_GPU_PLAN_MAX_PASSES 4096u
#define STILB_GPU_MAX_COLORS 8u
#define STILB_GPU_MAX_USES 12u
#define STILB_GPU_MAX_CONSTANTS 128u /* bytes: what every device offers as push constants */
#define STILB_GPU_ALL 0xffffu        /* of an image row's mips: down to one texel */
#define STILB_GPU_NO_SLOT 0xffffu    /* of a buffer by address: the program has that from elsewhere */
#define STILB_GPU_MAX_SIDE 16384u    /* texels of an image's side; a device may have less */
#define STILB_GPU_MAX_LAYERS 2048u
#define STILB_GPU_MAX_BUFFER (1ull << 40) /* bytes; likewise */
#define STILB_GPU_MAX_NAME 63u            /* bytes of a resource's name */

typedef enum stilb_gpu_shape {
	STILB_GPU_SHAPE_2D,   /* layers > 1: an array */
	STILB_GPU_SHAPE_CUBE, /* layers is a multiple of six: +X -X +Y -Y +Z -Z */
	STILB_GPU_SHAPE_3D,   /* depth slices; layers is 1 */
	STILB_GPU_SHAPE_1D,   /* height is 1 */
} stilb_gpu_shape;

/* An image. Members that are 0 have the value that the comment names. */
typedef struct stilb_gpu_plan_image_row {
	const char *name; /* unique in the plan; copied */
	stilb_gpu_format format;
	stilb_gpu_shape shape;
	float scale;                   /* > 0: sides are this share of the picture's, rounded up, at least 1 */
	uint32_t width, height, depth; /* texels, if scale is 0; height and depth 0: 1 */
	uint16_t layers;               /* 0: 1, of cubes 6 */
	uint16_t mips;                 /* 0: 1; STILB_GPU_ALL: down to one texel */
	uint8_t samples;               /* 0: 1; 1, 2, 4, 8 a texel */
	bool keep;                     /* the next frame may read its content, by stilb_gpu_use.previous */
	bool output;                   /* somebody reads it after the frame: the window, a screenshot */
	uint64_t owned;                /* not 0: the program's own image of this description, with contents that stay from
	                                  frame to frame; the plan gives it no memory (stilb_gpu_image.id). It may be read
	                                  before a pass has written it, and `keep` says nothing more */
} stilb_gpu_plan_image_row;

/* A buffer that the device writes or reads within passes. */
typedef struct stilb_gpu_plan_buffer_row {
	const char *name;
	uint64_t bytes;
	bool keep, output; /* as of images */
	uint64_t owned;    /* as of images (stilb_gpu_buffer.id) */
} stilb_gpu_plan_buffer_row;

/* ---- passes ------------------------------------------------------------------------------------------------------ */

typedef enum stilb_gpu_load {
	STILB_GPU_LOAD_KEEP,    /* what earlier passes have written stays and counts */
	STILB_GPU_LOAD_CLEAR,   /* every texel of the mip and layer becomes `clear` first, whatever the pass's area */
	STILB_GPU_LOAD_DISCARD, /* nobody needs what was there; the pass writes every texel that is read later */
	/* The texels of the pass's area become `clear` first; the others stay and count. Other attachments of the pass are
	 * cleared in the area alone, too. */
	STILB_GPU_LOAD_CLEAR_AREA,
	/* Of colours: there is no image here, and what programs draw at this place is dropped. */
	STILB_GPU_LOAD_NONE,
} stilb_gpu_load;

/* What a pass draws into: one mip and layer of an image, or several layers of it at once. */
typedef struct stilb_gpu_attachment {
	uint16_t image;   /* 0: there is none; of colours with STILB_GPU_LOAD_NONE alone */
	uint16_t resolve; /* 0, or an image with one sample that gets the mean of the samples: mip 0, layer 0, not depth */
	uint16_t layer;
	uint16_t layers; /* 0: 1; more: the vertex shader chooses by gl_Layer */
	uint8_t mip;
	uint8_t load;   /* stilb_gpu_load */
	bool read_only; /* depth alone: tested, not written; may be sampled by the same pass */
	float clear[4]; /* of depth the first; integers as floats with the same value */
} stilb_gpu_attachment;

/* How a pass uses a resource besides its attachments. In shaders one layer of an image is 2D (3D, 1D), several are an
 * array, and all six of a cube a cube (as storage images an array). Each binding that its program has must have a
 * use. */
typedef enum stilb_gpu_use_kind {
	STILB_GPU_USE_SAMPLED,       /* image: sampled, at binding `slot` of set 0: 0 .. the program's samplers - 1 */
	STILB_GPU_USE_STORAGE_READ,  /* image: at binding `slot` of set 0, behind those of the program's samplers: the
	                                first storage image has the slot `samplers` (stilb_gpu_program_desc), or 0 if none
	                                is sampled. Buffer: its address at byte `slot` of constants, or
	                                STILB_GPU_NO_SLOT */
	STILB_GPU_USE_STORAGE_WRITE, /* likewise; what was there is lost, unless an earlier pass of the frame wrote it */
	STILB_GPU_USE_STORAGE,       /* likewise, read and written */
	STILB_GPU_USE_VERTICES,      /* buffer: vertices or indices of draws */
	STILB_GPU_USE_INDIRECT,      /* buffer: commands of draws or a dispatch's three group counts, at byte `slot` */
	STILB_GPU_USE_COPY_FROM,     /* of a pass of kind COPY, together with COPY_TO */
	STILB_GPU_USE_COPY_TO,
	STILB_GPU_USE_UNIFORM, /* buffer: read at binding `slot` of set 0, behind those of the program's storage images */
	STILB_GPU_USE_HOST,    /* of a pass of kind HOST: an owned buffer that its function reads and writes as mapped
	                          memory (stilb_gpu_buffer_mapped) */
	STILB_GPU_USE_KINDS,
} stilb_gpu_use_kind;

typedef struct stilb_gpu_use {
	uint16_t resource;
	uint8_t how;            /* stilb_gpu_use_kind */
	bool previous;          /* reads last frame's content of a resource with `keep`, also if this frame writes it */
	uint16_t slot;          /* see stilb_gpu_use_kind; addresses take 8 bytes of the constants, at a multiple of 8 */
	uint8_t sampler;        /* SAMPLED: stilb_gpu_sampler.id; 0: nearest, clamped */
	uint8_t mip, mips;      /* images: mips mip .. mip + mips - 1; mips 0: all from mip on. Storage images: one mip */
	bool array;             /* SAMPLED, of 2D images: an array for shaders, also if it is one layer */
	uint16_t layer, layers; /* as mip, mips */
	uint32_t first, bytes;  /* UNIFORM: bytes first .. first + bytes - 1 of the buffer; bytes 0: all from first on */
} stilb_gpu_use;

typedef enum stilb_gpu_pass_kind {
	STILB_GPU_PASS_DRAWS,      /* a list of draws that the caller hands over with the plan */
	STILB_GPU_PASS_FULLSCREEN, /* one triangle over the attachments' area, without vertices */
	STILB_GPU_PASS_DISPATCH,   /* groups[0] x groups[1] x groups[2] work groups of a compute program; all 0: the counts
	                              come from the pass's INDIRECT use */
	STILB_GPU_PASS_COPY,       /* from its COPY_FROM use to its COPY_TO use: texel by texel where format and size of
	                              the mips agree, else filtered (sRGB in linear light); of buffers, and between an image
	                              and a buffer, bytes */
	STILB_GPU_PASS_HOST, /* the program's function, on the thread that runs the plan: the passes before it are done
	                              then, and those behind it begin when it returns. Nothing else goes on meanwhile, so it
	                              is for devices whose work is the CPU's own. The null device leaves it out */
	STILB_GPU_PASS_KINDS,
} stilb_gpu_pass_kind;

/* Where a pass may run. A device with one queue runs all in the table's order, as Vulkan's does today; one with several
 * does what stilb_gpu_plan_waits says. */
typedef enum stilb_gpu_queue {
	STILB_GPU_QUEUE_MAIN,    /* any pass */
	STILB_GPU_QUEUE_COMPUTE, /* dispatches and copies */
	STILB_GPU_QUEUE_COPY,    /* copies */
	STILB_GPU_QUEUES,
} stilb_gpu_queue;

typedef struct stilb_gpu_pass {
	const char *name; /* for messages, the profiler, debuggers; need not be unique; the text must stay until the next
	                     plan begins */
	uint8_t kind;     /* stilb_gpu_pass_kind */
	uint8_t color_count;
	uint8_t use_count;
	uint8_t constant_bytes; /* a multiple of 4 */
	uint32_t program;       /* stilb_gpu_program.id; 0 for COPY and HOST, and for DRAWS whose runs name theirs */
	uint32_t draws;         /* DRAWS: index of the list among those that come with the plan */
	uint32_t groups[3];     /* DISPATCH */
	uint32_t queue;         /* stilb_gpu_queue */
	uint16_t area[4]; /* left, top, width, height in texels of the attachments: DRAWS and FULLSCREEN fill this rectangle
	                     in place of all of them, and leave the rest as it is loaded; width and height 0: all */
	void (*host)(void *user); /* HOST: the function, which runs no plan; not NULL */
	void *host_user;
	stilb_gpu_attachment color[STILB_GPU_MAX_COLORS];
	stilb_gpu_attachment depth;
	stilb_gpu_use uses[STILB_GPU_MAX_USES];
	uint8_t constants[STILB_GPU_MAX_CONSTANTS]; /* push constants of DRAWS, FULLSCREEN and DISPATCH */
} stilb_gpu_pass;

/* ---- the plan ---------------------------------------------------------------------------------------------------- */

typedef struct stilb_gpu_plan stilb_gpu_plan;

/* NULL: no memory. */
stilb_gpu_plan *stilb_gpu_plan_create(void);
/* Accepts NULL. */
void stilb_gpu_plan_destroy(stilb_gpu_plan *plan);

/* Forgets the rows of the frame before, but not which of its resources were kept. width, height: the picture's, pixels,
 * 1..16384. */
void stilb_gpu_plan_begin(stilb_gpu_plan *plan, uint32_t width, uint32_t height);

/* Adds a row and returns its number. What is wrong with a row, no memory included, is told by stilb_gpu_plan_make: the
 * number is then 0, and rows that name it are no mistakes of their own. */
uint16_t stilb_gpu_plan_image(stilb_gpu_plan *plan, const stilb_gpu_plan_image_row *row);
uint16_t stilb_gpu_plan_buffer(stilb_gpu_plan *plan, const stilb_gpu_plan_buffer_row *row);
void stilb_gpu_plan_pass(stilb_gpu_plan *plan, const stilb_gpu_pass *row);

/* Adds the rows that fill an image's mips from its first one on, each from the one before: copies named "mips", one a
 * mip, for layers first_layer .. first_layer + layers - 1, 0: all from first_layer on; a cube has six. Returns how
 * many. Where a side is even, each texel is the mean of the two it lies over, so of four in 2D; where it is odd, it
 * lies over two and a half or so, and is the linear interpolation at its middle, which leaves the outer ones out in
 * part. sRGB is filtered as light. For formats that the device filters: neither depth nor integers nor compressed. */
uint32_t stilb_gpu_plan_mips(stilb_gpu_plan *plan, uint16_t image, uint16_t first_layer, uint16_t layers);

/* The number of the resource with this name among those added so far; 0: there is none. For features that read what
 * others write. */
uint16_t stilb_gpu_plan_find(const stilb_gpu_plan *plan, const char *name);

/* True if the last frame has left content for `previous` uses of this resource: it was in the last plan that was made,
 * under the same name, with the same description and size, was kept, and a pass wrote it. Where it is false the device
 * gives zeros (stilb_gpu_barrier.zero). Valid from the row's addition on. */
bool stilb_gpu_plan_kept(const stilb_gpu_plan *plan, uint16_t resource);

/* Marks a resource as read after the frame, as row.output does: to show an image live, or to read it back. */
void stilb_gpu_plan_show(stilb_gpu_plan *plan, uint16_t resource);

/* Ends the frame with pass `pass`, the index of a row among those added so far: the rows behind it do not run, but
 * those that are added after this call do. The pass runs even if nobody reads what it writes, and so do the passes
 * before it that the frame would run without the cut. An output that only passes behind it write has no content in
 * this frame, and what they would have kept the next frame does not find. At most once a frame. */
void stilb_gpu_plan_cut(stilb_gpu_plan *plan, uint32_t pass);

/* What memory an image needs on a device. */
typedef struct stilb_gpu_needs {
	uint64_t bytes, align; /* align: a power of two */
	uint32_t heap;         /* below 64; resources of different heaps never share memory */
} stilb_gpu_needs;

/* The sizes of an image as a device needs to know them, no member 0. */
typedef struct stilb_gpu_extent {
	stilb_gpu_format format;
	stilb_gpu_shape shape;
	uint32_t width, height, depth;
	uint16_t layers, mips;
	uint8_t samples;
	uint16_t uses; /* bit by stilb_gpu_use_kind, and above them attachment */
} stilb_gpu_extent;
#define STILB_GPU_EXTENT_ATTACHMENT (1u << STILB_GPU_USE_KINDS)

/* An image as its row and the picture's size make it; format NONE: a buffer. uses are 0. Valid from the row's addition
 * on, until the plan's next row. */
const stilb_gpu_extent *stilb_gpu_plan_extent(const stilb_gpu_plan *plan, uint16_t resource);

/* What a device says of a frame's images and buffers; user is passed back. NULL functions: sizes are those of the
 * texels and bytes alone, aligned to 256, in heap 0. The answer for a row is remembered while it, `user` and `version`
 * stay the same. */
typedef struct stilb_gpu_planner {
	void *user;
	uint64_t version; /* another one after answers may have changed */
	/* Sets *needs. An error, whose message says the limit and the way out: the device has no such image. */
	stilb_result (*image_needs)(void *user, const stilb_gpu_extent *extent, stilb_gpu_needs *needs);
	/* The same of a buffer that lives within the frame. */
	stilb_result (*buffer_needs)(void *user, uint64_t bytes, stilb_gpu_needs *needs);
	/* What is wrong with a pass for the device and its program, as a static or plan-owned text; NULL: nothing. */
	const char *(*mistake)(void *user, const stilb_gpu_plan *plan, const stilb_gpu_pass *pass);
} stilb_gpu_planner;

/* Checks the rows and makes the plan; planner may be NULL. STILB_ERROR_ARGUMENT: a row is wrong; the message names the
 * pass and the resource, and there is no plan: it has no steps, and what the last frame left stays as it was.
 * STILB_ERROR_MEMORY. What the device's functions return. */
stilb_result stilb_gpu_plan_make(stilb_gpu_plan *plan, const stilb_gpu_planner *planner);

/* The frame that was planned last did not run on the device: the next plan goes on from what the frame before it left.
 * Call it before the next plan begins. A device that was lost, or another one: destroy the plan. */
void stilb_gpu_plan_dropped(stilb_gpu_plan *plan);

/* FNV-1a 64 of all rows that are not left out, by value: names, sizes, clear values, uses, group counts, constants but
 * for the 8 bytes at the slots of buffers. Numbers that depend on what was created before are not in it: program,
 * sampler, owned. */
uint64_t stilb_gpu_plan_hash(const stilb_gpu_plan *plan);

/* ---- what was made, for devices, dumps and --plan; valid until the next plan begins ------------------------------ */

/* The ways in which the device touches memory, as one number: order matters in barriers only between two of which one
 * writes, or whose images need another layout. */
typedef enum stilb_gpu_access {
	STILB_GPU_ACCESS_NONE, /* undefined content, or nobody before */
	STILB_GPU_ACCESS_COLOR,
	STILB_GPU_ACCESS_DEPTH,
	STILB_GPU_ACCESS_DEPTH_READ, /* tested, and maybe sampled */
	STILB_GPU_ACCESS_RESOLVE,
	STILB_GPU_ACCESS_SAMPLED_FRAGMENT,
	STILB_GPU_ACCESS_SAMPLED_COMPUTE,
	STILB_GPU_ACCESS_STORAGE_READ_GRAPHICS, /* these two: also of uniform buffers */
	STILB_GPU_ACCESS_STORAGE_READ_COMPUTE,
	STILB_GPU_ACCESS_STORAGE_GRAPHICS,
	STILB_GPU_ACCESS_STORAGE_COMPUTE,
	STILB_GPU_ACCESS_VERTICES,
	STILB_GPU_ACCESS_INDIRECT,
	STILB_GPU_ACCESS_COPY_FROM,
	STILB_GPU_ACCESS_COPY_TO,
	STILB_GPU_ACCESS_HOST,
	STILB_GPU_ACCESS_OUTPUT, /* after the frame: copied to the window or to memory */
	STILB_GPU_ACCESSES,
} stilb_gpu_access;

/* In which arrangement an image must be for an access. Accesses with the same layout need no barrier between them if
 * both read. */
typedef enum stilb_gpu_layout {
	STILB_GPU_LAYOUT_NONE, /* undefined content */
	STILB_GPU_LAYOUT_COLOR,
	STILB_GPU_LAYOUT_DEPTH,
	STILB_GPU_LAYOUT_DEPTH_READ, /* depth images that are sampled, or tested and not written, or both */
	STILB_GPU_LAYOUT_SAMPLED,
	STILB_GPU_LAYOUT_STORAGE,
	STILB_GPU_LAYOUT_COPY_FROM, /* also outputs after the frame */
	STILB_GPU_LAYOUT_COPY_TO,
	STILB_GPU_LAYOUTS,
} stilb_gpu_layout;

/* kind: of the image's format. [any-thread] */
stilb_gpu_layout stilb_gpu_access_layout(stilb_gpu_access access, stilb_gpu_format_kind kind);
/* COLOR, DEPTH, RESOLVE, STORAGE_GRAPHICS, STORAGE_COMPUTE, COPY_TO and HOST write, all others read alone. [any-thread]
 */
bool stilb_gpu_access_writes(stilb_gpu_access access);
/* "color", "sampled_fragment", ... Static. [any-thread] */
const char *stilb_gpu_access_name(stilb_gpu_access access);

/* Before a pass: what was done with a part of a resource so far, and what the pass will do. One barrier stands before
 * the first of all reads that follow a write, and names them all; so a later read of the frame needs none.
 *
 *   from NONE, discard        nothing has touched the part that counts; from_all may name what used its memory
 *   from NONE, not discard    an owned image that this plan has not touched before: its content counts, and the device
 *                             knows from its own copies what was done with it. Owned buffers have no barrier then
 *
 * The device's own copies (uploads, read-back) between frames wait for everything before them, let everything after
 * them wait, and leave images in the layout in which they found them. */
typedef struct stilb_gpu_barrier {
	uint16_t resource;
	uint8_t from, to;  /* stilb_gpu_access: the last one so far, and the next */
	uint32_t from_all; /* bit by stilb_gpu_access: everything since the last write, `from` included; 0: nothing */
	uint32_t to_all;   /* likewise, all of the layout of `to`: what needs no further barrier, `to` included */
	bool discard;      /* the content is not needed: images may come from any layout */
	bool zero;         /* with discard: a `previous` use of what has no content; the device fills it with zeros */
	bool previous;     /* of the other one of two (stilb_gpu_placed.two) */
	bool memory;       /* from_all is what the memory was used for before, by this frame's resources or last frame's */
	uint8_t mip, mips; /* images; both at least 1 */
	uint16_t layer, layers;
} stilb_gpu_barrier;

/* A pass that runs: its row, and barriers first_barrier .. first_barrier + barrier_count - 1 before it. */
typedef struct stilb_gpu_step {
	uint32_t pass; /* index of the row */
	uint32_t first_barrier, barrier_count;
	uint32_t area[2]; /* the size of its attachments, texels; 0: it has none */
	uint8_t samples;
} stilb_gpu_step;

/* A step waits until an earlier one of another queue is done, besides all earlier ones of its own queue. */
typedef struct stilb_gpu_queue_wait {
	uint32_t step;   /* the number of steps: the end of the frame, on the main queue */
	uint32_t before; /* the step that it waits for */
} stilb_gpu_queue_wait;

/* Where a resource lies. */
typedef struct stilb_gpu_placed {
	stilb_gpu_extent extent; /* images; format NONE: a buffer. uses: those of this frame. Images that stay get all uses
	                            that their format has on the device: the next frame's may differ */
	uint64_t bytes;          /* of its memory if shared, else those of the texels; of a buffer those of its row */
	uint64_t offset;         /* in the heap's shared memory; of kept, output and owned resources 0 */
	uint64_t owned;          /* as in the row */
	uint64_t stay;           /* not 0: kept, output or shown; it is the device's from this frame on until a plan without
	                            it, and has the same number in each plan. 0: shared, owned, or touched by no pass */
	uint32_t heap;
	uint32_t first_step, last_step; /* that touch it; first > last: none does */
	uint32_t queues;                /* bit by stilb_gpu_queue: whose steps touch it; several: it belongs to none of them
	                                   alone (VK_SHARING_MODE_CONCURRENT) */
	bool shared;                    /* it lies in shared memory */
	bool two; /* kept, and read as `previous` after this frame has begun to write it: the device has two, of which one
	             holds what the last frame wrote and the other gets what this one writes. In a frame that needs but one
	             it keeps the one that was written last and gives the other up */
} stilb_gpu_placed;

/* Mips and layers; of buffers 0, 1, 0, 1. */
typedef struct stilb_gpu_range {
	uint8_t mip, mips;
	uint16_t layer, layers;
} stilb_gpu_range;

uint32_t stilb_gpu_plan_steps(const stilb_gpu_plan *plan, const stilb_gpu_step **steps);
uint32_t stilb_gpu_plan_barriers(const stilb_gpu_plan *plan, const stilb_gpu_barrier **barriers);
/* Barriers after the last pass, which make outputs ready for whoever reads them: first .. count. */
uint32_t stilb_gpu_plan_last_barriers(const stilb_gpu_plan *plan, uint32_t *first);
/* The fewest waits between queues that order what must be, sorted by step; none if all passes are of one queue. The end
 * of a frame comes after all of its steps, and the next frame after that end. */
uint32_t stilb_gpu_plan_waits(const stilb_gpu_plan *plan, const stilb_gpu_queue_wait **waits);
const stilb_gpu_pass *stilb_gpu_plan_row(const stilb_gpu_plan *plan, uint32_t pass);
uint32_t stilb_gpu_plan_passes(const stilb_gpu_plan *plan);
/* What a use of a row stands for, with 0 as all that there are. */
stilb_gpu_range stilb_gpu_plan_range(const stilb_gpu_plan *plan, const stilb_gpu_use *use);
/* Resources are 1 .. the number that this returns. */
uint32_t stilb_gpu_plan_resources(const stilb_gpu_plan *plan);
const stilb_gpu_placed *stilb_gpu_plan_place(const stilb_gpu_plan *plan, uint16_t resource);
const char *stilb_gpu_plan_name(const stilb_gpu_plan *plan, uint16_t resource);
/* True if this mip and layer, of a buffer 0 and 0, has content after the frame and is ready to be copied: a part of an
 * output or of a shown resource that a pass has written, or of an owned output. */
bool stilb_gpu_plan_ready(const stilb_gpu_plan *plan, uint16_t resource, uint8_t mip, uint16_t layer);
/* Heaps that shared memory lies in: 0 .. the planner's largest, 64 at most; and the bytes of each. */
uint32_t stilb_gpu_plan_heaps(const stilb_gpu_plan *plan);
uint64_t stilb_gpu_plan_heap_bytes(const stilb_gpu_plan *plan, uint32_t heap);

/* Writes the plan as lines of text: passes in order with their barriers, what was left out and why, images with sizes
 * and memory. STILB_ERROR_MEMORY. */
stilb_result stilb_gpu_plan_text(const stilb_gpu_plan *plan, char **text);
/* The same as a drawing, SVG. */
stilb_result stilb_gpu_plan_svg(const stilb_gpu_plan *plan, char **text);
/* Writes the drawing to a path that ends in .svg, the text to any other, as base_file.h says: whole or not at all.
 * STILB_ERROR_ARGUMENT: there is no plan with a pass that runs. STILB_ERROR_FILE, STILB_ERROR_MEMORY. */
stilb_result stilb_gpu_plan_save(const stilb_gpu_plan *plan, const char *path);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
