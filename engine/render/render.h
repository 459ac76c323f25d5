/*
 * render: draws are recorded by many threads as plain commands, and replayed by one thread on a device.
 *
 * How it works.  Every worker owns a render context. Recording appends 32-byte commands to blocks of memory that belong to
 *                the context for this frame, and writes each draw's transform into a row of the frame's row memory; with
 *                indirect replay both are memory that the GPU reads, written once and never copied. A pass is cut into
 *                segments, numbered by the scene; any worker may record any segment, and replay takes the segments in
 *                number order. So the command stream, and the picture, do not depend on how many workers there are or
 *                who was faster.
 * Life cycle.    stilb_render_create -> stilb_render_upload_scene, stilb_render_mesh_create, ... -> frames ->
 *                stilb_render_destroy.
 * Per frame.     stilb_render_frame_begin, stilb_render_record per pass, stilb_render_replay, stilb_render_present.
 * Threads.       [main-thread] unless a function says [one-writer], one thread at a time per context, or [any-thread].
 * Devices.       `null` counts and writes what a GPU would be given, and draws nothing; `vulkan` draws, and shows in the
 *                profiler's lane "GPU" when it drew what: a zone for each frame, in it one for each pass.
 * Limits.        None on draws: lists and buffers grow, and running out of memory is an error of the frame. Nothing is
 *                ever dropped.
 */
#ifndef STILB_RENDER_H
#define STILB_RENDER_H

#include "base/base.h"
#include "base/base_math.h"
#include "image/image.h"
#include "jobs/job.h"
#include "scene/scene.h"

typedef struct stilb_render stilb_render;
typedef struct stilb_render_context stilb_render_context;

typedef enum stilb_render_device_kind {
	STILB_RENDER_DEVICE_VULKAN,
	STILB_RENDER_DEVICE_NULL,
} stilb_render_device_kind;

/* How a command list becomes device commands. The pixels are the same. */
typedef enum stilb_render_replay_mode {
	STILB_RENDER_REPLAY_INDIRECT,  /* multi-draw-indirect: the GPU reads the workers' commands where they lie */
	STILB_RENDER_REPLAY_DIRECT,    /* one device command a draw, in one primary command buffer */
	STILB_RENDER_REPLAY_SECONDARY, /* the same in a secondary command buffer per worker, recorded in parallel */
} stilb_render_replay_mode;

/* How a draw gets its material. The pixels are the same. */
typedef enum stilb_render_materials {
	STILB_RENDER_MATERIALS_INDEX,    /* an index in the draw's row: no device command */
	STILB_RENDER_MATERIALS_BIND,     /* a descriptor set for each change of material */
	STILB_RENDER_MATERIALS_PIPELINE, /* two pipelines, for materials with even and with odd ids: the worst case */
} stilb_render_materials;

/* What a device lets go wrong on purpose, for tests; 0: nothing. Counted from 1. */
typedef struct stilb_render_faults {
	uint32_t allocation; /* the device's n-th allocation of memory fails */
	uint32_t lost_frame; /* the device is lost when frame n is handed to it */
} stilb_render_faults;

/* What the picture holds. */
typedef enum stilb_render_output {
	STILB_RENDER_OUTPUT_DISPLAY, /* tone mapped, 8-bit sRGB */
	STILB_RENDER_OUTPUT_LINEAR,  /* radiance as it is, 16-bit float */
} stilb_render_output;

/* A window's surface without knowing windows or Vulkan: instance is a VkInstance, *surface a VkSurfaceKHR. */
typedef struct stilb_render_surface {
	void *user;
	const char *const *(*extensions)(void *user, uint32_t *count);    /* instance extensions it needs */
	int32_t (*create)(void *user, void *instance, uint64_t *surface); /* returns a VkResult */
} stilb_render_surface;

typedef struct stilb_render_desc {
	stilb_render_device_kind device;
	stilb_render_replay_mode replay;
	stilb_render_materials materials;
	stilb_render_output output;
	const char *gpu;                     /* a number or a part of a name as `stilb info` prints them; NULL: the best */
	const stilb_render_surface *surface; /* NULL: no window */
	uint32_t width, height;              /* 1..16384 */
	uint32_t samples;                    /* 1 or 4 per pixel; 0: 4 on a GPU, 1 on a software device */
	uint32_t context_count;              /* workers + 1 */
	bool validate;                       /* Vulkan validation layer with synchronization checks */
	bool keep_textures;                  /* in memory, too: for stilb_render_dump_save */
	stilb_render_faults faults;
} stilb_render_desc;

/* What a pass draws into. */
typedef enum stilb_render_target {
	STILB_RENDER_TARGET_MAIN, /* the picture */
} stilb_render_target;

/* How surfaces are shaded: the formulas, whose numbers are those of the shading headers, and what is added to the numbers
 * of every material, for trying out; the sums are kept within the material's ranges. */
typedef struct stilb_render_shading {
	uint32_t brdf;      /* SHADE_BRDF_... of shading/shade_brdf.h */
	uint32_t ndf, g, f; /* SHADE_NDF_..., SHADE_G_..., SHADE_F_...: the parts of SHADE_BRDF_MICROFACET, else not read */
	uint32_t light;     /* SHADE_LIGHT_... of shading/shade_light.h */
	float roughness;    /* added, [-1, 1] */
	float anisotropy;   /* added, [-1, 1] */
	float wrap;         /* added, [-1, 1] */
	float specular;     /* added to all channels, [-1, 1]; then diffuse + specular is limited to one again */
} stilb_render_shading;

/* Modified Blinn-Phong under the sun, nothing added; GGX, its Smith and Schlick where microfacets are chosen.
 * [any-thread] */
stilb_render_shading stilb_render_shading_default(void);

/* Where from, under which light and with which formulas; a pass names its view by index. Formulas that are new to the
 * device are compiled in the frame that first uses them, and kept: any number of combinations. */
typedef struct stilb_render_view {
	stilb_mat4 view_projection;
	float camera_position[3];
	stilb_scene_sun sun;
	stilb_scene_sky sky;
	stilb_scene_lamp lamp;
	stilb_render_shading shading;
} stilb_render_view;

/* What a pass draws. */
typedef enum stilb_render_pass_kind {
	STILB_RENDER_PASS_SCENE, /* meshes, seen from a view */
	STILB_RENDER_PASS_2D,    /* triangles over the finished picture, in the order of their recording */
} stilb_render_pass_kind;

typedef struct stilb_render_pass {
	const char *name;
	stilb_render_pass_kind kind;
	uint32_t view; /* index into the frame's views; 2D passes have none */
	stilb_render_target target;
	uint32_t order; /* passes are replayed by ascending order, 2D passes after all others */
	bool sort;      /* draws by ascending key, equal keys as recorded; else all as recorded. Not for 2D passes */
} stilb_render_pass;

#define STILB_RENDER_MAX_PASSES 16

/* Of the last replayed frame. */
typedef struct stilb_render_stats {
	uint64_t draws;
	uint64_t recorded_bytes; /* commands, rows and 2D geometry of these draws */
	uint64_t draw_commands;  /* device commands that draw one thing */
	uint64_t
		indirect_commands;     /* device commands that draw many: one for each stretch of memory that a worker filled */
	uint64_t execute_commands; /* command buffers recorded beside the main one and executed from it */
	uint64_t binds_asked;      /* pipeline, buffers and material of every draw: three a draw */
	uint64_t binds_sent;       /* of these, what changed and so went to the device */
	double gpu_ms;             /* last known time of a frame on the GPU; 0 on the null device */
} stilb_render_stats;

/* STILB_ERROR_DEVICE names what is missing and how to get it; STILB_ERROR_WINDOW: this GPU cannot show anything in this
 * window, without a surface it may do. */
stilb_result stilb_render_create(const stilb_render_desc *desc, stilb_render **render);
void stilb_render_destroy(stilb_render *render);

/* The GPU's name, or "null". */
const char *stilb_render_device_name(const stilb_render *render);
/* True when the GPU is a CPU. */
bool stilb_render_device_is_software(const stilb_render *render);
uint32_t stilb_render_samples(const stilb_render *render);
/* Warnings and errors of the validation layer so far. */
uint32_t stilb_render_validation_messages(const stilb_render *render);

/* ---- meshes, textures, materials ---------------------------------------------------------------------------------
 * Created and destroyed by any thread at any time, also while frames are recorded. Zero is no handle. What the handle
 * stands for is there for every draw recorded after the creation, and stays until the frame in which it was destroyed, and
 * all before, are drawn. Draws take no lock. No thread may draw with a
 * handle while or after another destroys it.
 * STILB_ERROR_ARGUMENT: empty, or an index beyond the vertices. STILB_ERROR_MEMORY: no memory, or no id left. */

typedef struct stilb_render_mesh {
	uint32_t id;
} stilb_render_mesh;

typedef struct stilb_render_texture {
	uint32_t id;
} stilb_render_texture;

typedef struct stilb_render_material {
	uint32_t id;
} stilb_render_material;

/* Creating into a heap with n holes takes time in proportion to n: 0.2 us with 1,000, 5 us with 100,000. */
#define STILB_RENDER_MAX_MESHES (1u << 20)
#define STILB_RENDER_MAX_MATERIALS (1u << 24)
#define STILB_RENDER_MAX_TEXTURES (1u << 12) /* one less: 0 is none */

/* Copies vertices and indices. [any-thread] */
stilb_result stilb_render_mesh_create(stilb_render *render, const stilb_scene_mesh *mesh, stilb_render_mesh *out);
/* Accepts {0}, as the others. [any-thread] */
void stilb_render_mesh_destroy(stilb_render *render, stilb_render_mesh mesh);

/* Copies the pixels, of any format and 1..4 channels; 1..16384 a side. Sampled with linear filtering, repeated.
 * [any-thread] */
stilb_result stilb_render_texture_create(stilb_render *render, const stilb_image *image, stilb_render_texture *out);
/* No material may hold it any longer. [any-thread] */
void stilb_render_texture_destroy(stilb_render *render, stilb_render_texture texture);

/* texture multiplies the diffuse reflectance; {0}: none. [any-thread] */
stilb_result stilb_render_material_create(stilb_render *render, const stilb_scene_material *material,
                                          stilb_render_texture texture, stilb_render_material *out);
/* [any-thread] */
void stilb_render_material_destroy(stilb_render *render, stilb_render_material material);

/* Creates all meshes and materials of a scene, once; the arrays may change afterwards. */
stilb_result stilb_render_upload_scene(stilb_render *render, const stilb_scene *scene);

/* The handles of the uploaded scene's ids. [any-thread] */
stilb_render_mesh stilb_render_scene_mesh(const stilb_render *render, uint32_t id);
stilb_render_material stilb_render_scene_material(const stilb_render *render, uint32_t id);

/* ---- frames ------------------------------------------------------------------------------------------------------ */

/* For another number of workers: between frames; the last frame's stream hash is lost. After an error all is as before. */
stilb_result stilb_render_set_context_count(stilb_render *render, uint32_t context_count);

/* Another picture size, 1..16384: between frames. After an error no frame can be drawn until a resize succeeds. */
stilb_result stilb_render_resize(stilb_render *render, uint32_t width, uint32_t height);
void stilb_render_size(const stilb_render *render, uint32_t *width, uint32_t *height);

/* Waits until the device is done with the frame before the last, and rewinds the contexts. */
stilb_result stilb_render_frame_begin(stilb_render *render);

/* Records pass: every part of every visible model, in scene order, on the pool and on the caller (whose index is worker). */
stilb_result stilb_render_record(stilb_render *render, uint32_t pass, const stilb_scene *scene, const uint32_t *visible,
                                 uint32_t visible_count, stilb_job_pool *pool, uint32_t worker);

/* Turns the lists of all passes, at least one, into device commands, in order, and hands them to the device. Once a
 * frame. Secondary command buffers are recorded on the pool; the caller's index there is worker. */
stilb_result stilb_render_replay(stilb_render *render, const stilb_render_pass *passes, uint32_t pass_count,
                                 const stilb_render_view *views, uint32_t view_count, stilb_job_pool *pool,
                                 uint32_t worker);

/* Shows the picture in the window, or copies it to memory when there is none. An outdated or minimised window is no
 * error. STILB_ERROR_WINDOW: the window or its display has gone; later pictures are copied to memory. */
stilb_result stilb_render_present(stilb_render *render);

/* The last replayed picture, top row first; waits for the device; between frames. STILB_ERROR_DEVICE: there is none, since
 * no frame of this size has been drawn, or on the null device. */
stilb_result stilb_render_read_image(stilb_render *render, stilb_image *image);

/* Waits until the device has drawn every frame; the statistics' gpu_ms is then the last frame's. */
stilb_result stilb_render_wait(stilb_render *render);

stilb_render_stats stilb_render_stats_get(const stilb_render *render);

/* FNV-1a 64 over the last frame's passes in replay order, but for 2D passes, little endian: the members of the view's
 * stilb_render_shading (32-bit each); then of each draw mesh id, material id (32-bit, counted from 0), the 16 floats of
 * the transform (column-major) and index count (32-bit). The same for every device, replay mode and number of workers.
 * Valid after replay until the next frame begins. */
uint64_t stilb_render_stream_hash(const stilb_render *render);

/* ---- recording by hand ------------------------------------------------------------------------------------------- */

/* Begins a pass of segment_count segments; every one must then be recorded (an empty one too). [main-thread] */
stilb_result stilb_render_pass_begin(stilb_render *render, uint32_t pass, uint32_t segment_count);

/* The context of a worker, 0..context_count - 1. */
stilb_render_context *stilb_render_context_get(stilb_render *render, uint32_t worker);

/* Between begin and end all draws of a context belong to this segment. [one-writer] */
void stilb_render_segment_begin(stilb_render_context *context, uint32_t pass, uint32_t segment);
void stilb_render_segment_end(stilb_render_context *context);

/* One draw; transform is affine (its last row is 0 0 0 1). [one-writer] */
void stilb_render_draw(stilb_render_context *context, stilb_render_mesh mesh, stilb_render_material material,
                       const stilb_mat4 *transform);

/* The same with a key, for passes that sort; without one it is 0. [one-writer] */
void stilb_render_draw_with_key(stilb_render_context *context, uint64_t key, stilb_render_mesh mesh,
                                stilb_render_material material, const stilb_mat4 *transform);

/* Passes of kind 2D: text and flat shapes over the picture, alpha blended in linear light, not tone mapped, without
 * depth, with one sample a pixel whatever the scene has. Without a scene pass the picture below is black. One without
 * draws costs nothing. They are no part of the stream hash and of dumps. */
typedef struct stilb_render_vertex_2d {
	float position[2]; /* pixels from the picture's top left corner; the first pixel's centre is at 0.5, 0.5 */
	float uv[2];
	uint8_t color[4]; /* sRGB and straight alpha; interpolated in linear light, premultiplied */
} stilb_render_vertex_2d;

/* Copies triangles into the frame's memory; each index is below vertex_count. Returns the place of the first index, for
 * this frame's draws. Without memory pass_end fails. Inside a segment of a 2D pass. [one-writer] */
uint32_t stilb_render_geometry_2d(stilb_render_context *context, const stilb_render_vertex_2d *vertices,
                                  uint32_t vertex_count, const uint32_t *indices, uint32_t index_count);

/* Draws index_count of the copied indices where pixel centres lie in the clip rectangle: left, top, right, bottom in
 * pixels. The texture multiplies the color, its alpha the color's (so a glyph is white with alpha as coverage); {0}: none.
 * Draws of one texture in a row are one device command with indirect replay, whatever their clips. [one-writer] */
void stilb_render_draw_2d(stilb_render_context *context, uint32_t first_index, uint32_t index_count,
                          const float clip[4], stilb_render_texture texture);

/* Ends the recording of a pass; no context records meanwhile. STILB_ERROR_MEMORY when one ran out of memory on the way.
 * [main-thread] */
stilb_result stilb_render_pass_end(stilb_render *render, uint32_t pass);

/* ---- what there is --------------------------------------------------------------------------------------------------- */

typedef struct stilb_render_gpu {
	char name[256];
	char driver[256];     /* name and version as the driver says them */
	char api_version[32]; /* "1.3.230" */
	const char *type;     /* "discrete GPU", "integrated GPU", "virtual GPU", "software", "other" */
	const char *missing;  /* NULL when it can run Stilb, else what it lacks */
} stilb_render_gpu;

/* "1.3.239": what the Vulkan loader offers. */
const char *stilb_render_vulkan_version(void);

/* Lists up to capacity GPUs in the order of --gpu numbers; count may be 0. STILB_ERROR_DEVICE: no Vulkan at all. */
stilb_result stilb_render_gpu_list(stilb_render_gpu *gpus, uint32_t capacity, uint32_t *count);

#endif
