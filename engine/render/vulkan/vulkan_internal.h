/*
 * The Vulkan device, version 1.3: dynamic rendering, synchronization2, timeline semaphores, buffer addresses.
 *
 * There are two frame slots. A slot owns everything that the CPU writes for a frame, and is reused when the timeline
 * semaphore says that the GPU is done with it. A frame makes two submissions: `draw` (the passes, into the picture) and
 * `show` (the picture to the window or to memory). All frames share one picture: they follow each other on one queue,
 * and barriers order them.
 * Shaders get buffer addresses in a push constant. Descriptor sets are used for textures (set 0), which have no
 * address, and for materials that are bound one by one (set 1, --materials bind).
 */
#ifndef STILB_VULKAN_INTERNAL_H
#define STILB_VULKAN_INTERNAL_H

#include "render/render_internal.h"

#include <pthread.h>
#include <vulkan/vulkan.h>

#define VULKAN_SLOTS RENDER_FRAMES_IN_FLIGHT
#define VULKAN_MAX_SWAPCHAIN_IMAGES 16
#define VULKAN_MAX_LISTS (STILB_JOB_MAX_WORKERS + 1)

typedef struct vulkan_buffer {
	VkBuffer buffer;
	VkDeviceMemory memory;
	VkDeviceSize size;
	VkDeviceAddress address; /* 0 unless made with VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT */
	void *mapped;            /* for the CPU; NULL for VULKAN_MEMORY_DEVICE */
} vulkan_buffer;

typedef struct vulkan_image {
	VkImage image;
	VkImageView view;
	VkDeviceMemory memory;
} vulkan_image;

/* A view as the shaders read it (shaders/mesh.glsl). */
typedef struct vulkan_view {
	float view_projection[16];
	float camera_position[4];
	float sky[4];
	float ground[4];
	float added[4]; /* added to every material's roughness, anisotropy, wrap and specular */
	VkDeviceAddress lights;
	uint32_t light_count;
	float exposure;           /* factor of radiance before the tone map */
	VkDeviceAddress panorama; /* of device.panorama: its table */
	float turn[2];            /* sine and cosine of its rotation */
} vulkan_view;

static_assert(sizeof(vulkan_view) == 160, "std430");

/* Push constants of scene passes (shaders/mesh.glsl). */
typedef struct vulkan_push {
	VkDeviceAddress view, rows, materials, vertices;
} vulkan_push;

/* Push constants of 2D passes (shaders/flat.vert). */
typedef struct vulkan_push_2d {
	float scale[2]; /* pixels to clip space */
	VkDeviceAddress rows;
} vulkan_push_2d;

static_assert(sizeof(vulkan_push_2d) <= sizeof(vulkan_push), "one pipeline layout serves both");

/* Commands that were recorded into a command buffer. */
typedef struct vulkan_sent {
	uint64_t draws, binds;
} vulkan_sent;

/* The secondary command buffers of one thread's share of each pass of the frame. A list is recorded by one job at a
 * time. */
typedef struct vulkan_list {
	_Alignas(STILB_CACHE_LINE) VkCommandPool pool;
	VkCommandBuffer commands[STILB_RENDER_MAX_PASSES];
	uint32_t made, used; /* command buffers: allocated; used in this frame */
	VkResult result;     /* of the last recording */
	vulkan_sent sent;
} vulkan_list;

/* The GPU's clock (ticks) and CLOCK_MONOTONIC (ns), read together; ns 0: never read. */
typedef struct vulkan_moment {
	uint64_t ticks, ns;
} vulkan_moment;

/* The timestamps of a slot's frame. */
typedef struct vulkan_slot_times {
	vulkan_buffer results; /* GPU ticks: begin and end of the frame, then of each pass */
	const stilb_prof_site *sites[STILB_RENDER_MAX_PASSES]; /* [passes] names of the passes */
	uint32_t passes;
	bool taken;            /* the frame was submitted, its timestamps were not read */
	vulkan_moment moment;  /* reading of both clocks that was the last at its submission */
	uint64_t submitted_ns; /* CLOCK_MONOTONIC */
} vulkan_slot_times;

typedef struct vulkan_times {
	VkQueryPool queries;                          /* null: the queue has no timestamps */
	PFN_vkGetCalibratedTimestampsEXT read_clocks; /* NULL: this GPU cannot read both clocks together */
	vulkan_moment moment;                         /* the last accurate reading of both (TIMES_WORST_NS) */
	stilb_prof_lane_handle *lane;                 /* NULL: there was no memory for it */
	uint64_t shown_ns;                            /* end of the frame shown last in the lane, CLOCK_MONOTONIC */
} vulkan_times;

typedef struct vulkan_slot {
	VkCommandPool pool;
	VkCommandBuffer draw, show;
	VkSemaphore acquired; /* signalled when the window's image may be drawn into */
	vulkan_list *lists;   /* [list_count] one for each part that a pass is cut into; secondary replay alone */
	uint32_t list_count;
	vulkan_buffer memory[RENDER_MEMORY_KINDS];
	vulkan_buffer staging;     /* the source of update's copies */
	VkDeviceSize staging_used; /* bytes of it that the slot's frame copies */
	vulkan_buffer
		*outgrown; /* [outgrown_count] replaced in this slot's frame, and still read by it or the one before */
	uint32_t outgrown_count, outgrown_capacity;
	VkDescriptorSet material_set; /* --materials bind: a set with the buffer of materials */
	VkBuffer material_buffer;     /* the buffer that material_set refers to */
	vulkan_buffer backdrop;       /* what shaders/backdrop.frag reads; {0}: not needed so far */
	vulkan_buffer views;          /* vulkan_view[STILB_RENDER_MAX_PASSES] */
	vulkan_buffer picture;        /* the picture in memory, if there is no window */
	vulkan_slot_times times;
	uint64_t done;      /* timeline value of the slot's last submission */
	bool picture_valid; /* `picture` holds the slot's frame */
} vulkan_slot;

/* Made and destroyed with the lock of render_resources held. Replay reads `set` without it: a texture that a frame uses
 * exists until the frame is done. */
typedef struct vulkan_texture {
	vulkan_image image;
	VkDescriptorSet set;
} vulkan_texture;

/* The pipelines of 2D passes. */
typedef enum vulkan_pipeline_2d {
	VULKAN_PIPELINE_2D_FLAT,
	VULKAN_PIPELINE_2D_TEXTURE,
	VULKAN_PIPELINE_2D_PICTURE, /* stilb_render_draw_picture */
	VULKAN_PIPELINES_2D
} vulkan_pipeline_2d;

/* The materials that a mesh pipeline draws (shaders/mesh.frag): all, or with --materials pipeline those with an even or
 * an odd index. */
typedef enum vulkan_pipeline_materials {
	VULKAN_PIPELINE_ANY,
	VULKAN_PIPELINE_EVEN,
	VULKAN_PIPELINE_ODD,
	VULKAN_PIPELINE_MATERIALS,
} vulkan_pipeline_materials;

/* What the draws of a mesh pipeline show. */
typedef enum vulkan_surface {
	VULKAN_SURFACE_PLAIN,    /* meshes whose material has no texture */
	VULKAN_SURFACE_TEXTURE,  /* meshes with one */
	VULKAN_SURFACE_IMPOSTOR, /* impostors, which always have one */
	VULKAN_SURFACES,
} vulkan_surface;

/* The formulas that a pipeline is compiled with, in the order of the shader's specialization constants. */
typedef enum vulkan_formula {
	VULKAN_FORMULA_BRDF,
	VULKAN_FORMULA_NDF,
	VULKAN_FORMULA_G,
	VULKAN_FORMULA_F,
	VULKAN_FORMULA_LIGHTS, /* render_stream.light_bits */
	VULKAN_FORMULAS,
} vulkan_formula;

/* A pipeline that is made when it is first needed, or before. Both members are guarded by vulkan_device.pipelines_lock
 * until vulkan_pipeline_once has returned. */
typedef struct vulkan_pipeline {
	VkPipeline handle; /* null: not needed so far */
	bool making;       /* a thread compiles it */
} vulkan_pipeline;

/* The mesh pipelines of one choice of formulas, by render_state_detail. */
typedef struct vulkan_shading {
	uint32_t formulas[VULKAN_FORMULAS];
	vulkan_pipeline pipelines[RENDER_DETAIL_KINDS][VULKAN_SURFACES][VULKAN_PIPELINE_MATERIALS];
} vulkan_shading;

typedef struct vulkan_swapchain {
	VkSwapchainKHR handle;
	VkExtent2D extent;
	uint32_t image_count;
	VkImage images[VULKAN_MAX_SWAPCHAIN_IMAGES];
	VkSemaphore shown[VULKAN_MAX_SWAPCHAIN_IMAGES]; /* signalled when the blit into this image is done */
	bool stale;                                     /* the window has changed: must be made anew before its next use */
} vulkan_swapchain;

typedef struct vulkan_device {
	render_device base;

	VkInstance instance;
	VkDebugUtilsMessengerEXT messenger;
	PFN_vkCmdBeginDebugUtilsLabelEXT label_begin; /* NULL without desc.validate */
	PFN_vkCmdEndDebugUtilsLabelEXT label_end;
	VkSurfaceKHR surface;                   /* null without a window */
	bool presents;                          /* created with a surface: another one can take its place */
	stilb_render_presentation presentation; /* of this surface; as asked for, or FIFO */
	stilb_render_presentation asked;        /* as asked for */
	bool surface_lost;                      /* the window or its display has gone: pictures are copied to memory */
	VkPhysicalDevice gpu;
	VkPhysicalDeviceProperties properties;
	VkPhysicalDeviceMemoryProperties memory;
	VkDevice device;
	VkQueue queue;
	uint32_t queue_family;

	VkSemaphore timeline;
	uint64_t timeline_value; /* the semaphore's value once the last submission is done */
	uint64_t timestamp_mask; /* valid bits of a timestamp; 0: the queue has none */
	bool calibrates;         /* VK_EXT_calibrated_timestamps is enabled */
	vulkan_times times;

	const VkAllocationCallbacks *allocator; /* for all objects of the device; NULL: the driver's own */

	VkSampler sampler; /* for all textures: linear, repeated, no mip levels */
	VkDescriptorSetLayout texture_layout, material_layout;
	VkDescriptorPool texture_pool, material_pool;
	vulkan_texture *textures; /* [STILB_RENDER_MAX_TEXTURES] */
	VkPipelineLayout pipeline_layout;
	VkShaderModule mesh_modules[VULKAN_SURFACES][2]; /* by stage, kept for pipelines that later frames need */
	/* Several threads may need pipelines: this guards which there are and which a thread is making, not their use. */
	pthread_mutex_t pipelines_lock;
	pthread_cond_t pipelines_made;
	bool pipelines_lock_made;
	vulkan_shading **shadings; /* [shading_count] every choice of formulas that a pass has used or will */
	uint32_t shading_count, shading_capacity;
	const vulkan_shading *shading; /* of the pass that is being replayed; secondary lists read it on other threads */
	VkPipeline pipelines_2d[VULKAN_PIPELINES_2D];
	vulkan_pipeline backdrop;
	vulkan_buffer panorama, next_panorama; /* RENDER_PANORAMA_BYTES: shown, and being made; {0}: none */
	bool transparent;                      /* the frame's backdrop is nothing, and the picture's alpha counts */
	stilb_render_output output;
	VkFormat color_format;
	vulkan_image color;         /* the picture, one sample a pixel */
	vulkan_image color_samples; /* with 4 samples a pixel, resolved into color; null with 1 */
	vulkan_image depth;
	bool drawn; /* color holds a submitted picture, in the layout TRANSFER_SRC_OPTIMAL */

	vulkan_buffer heaps[RENDER_HEAPS];
	bool packed;          /* vertices are: stilb_render_desc.float_vertices */
	render_layout layout; /* of vertices */

	vulkan_slot slots[VULKAN_SLOTS];
	uint32_t slot; /* index of the current frame's slot */
	uint32_t pass; /* number of the current frame's passes so far that had draws */
	vulkan_swapchain swapchain;
} vulkan_device;

/* The slot of the current frame. */
static inline vulkan_slot *vulkan_slot_now(vulkan_device *device)
{
	STILB_ASSERT(device->slot < VULKAN_SLOTS);
	return &device->slots[device->slot];
}

/* For tests: the allocator of devices that are created from now on. NULL, its first value: the driver's own. */
extern const VkAllocationCallbacks *vulkan_host_allocator;

/* vulkan_instance.c: errors, the instance, the choice of a GPU. */

/* The result for a VkResult that is an error, with the message "cannot WHAT: out of memory
 * (VK_ERROR_OUT_OF_HOST_MEMORY -1); try ...". */
stilb_result vulkan_fail(const vulkan_device *device, VkResult error, const char *what);
stilb_result vulkan_instance_create(vulkan_device *device, const stilb_render_desc *desc);
/* Makes the surface of a window, device->surface. STILB_ERROR_WINDOW: then it is null. */
stilb_result vulkan_surface_create(vulkan_device *device, const stilb_render_surface *surface);
/* Safe to call without a surface; its swapchain has been destroyed. */
void vulkan_surface_destroy(vulkan_device *device);
/* Chooses the GPU that `wanted` names (stilb_render_desc.gpu). */
stilb_result vulkan_gpu_select(vulkan_device *device, const char *wanted);
/* Safe to call again, and without an instance. */
void vulkan_instance_destroy(vulkan_device *device);
/* The words for a kind of GPU: "discrete GPU", ... , "other" also for kinds that are newer than this program. */
const char *vulkan_gpu_type_text(VkPhysicalDeviceType type);

/* vulkan_barrier.c: barriers between the commands of a queue. */

/* One image barrier: everything in from_stage and its writes come before everything in to_stage, and the layout changes
 * in between. VK_IMAGE_LAYOUT_UNDEFINED as `from` discards the contents. */
VkImageMemoryBarrier2 vulkan_image_transition(VkImage image, VkImageAspectFlags aspect, VkImageLayout from,
                                              VkImageLayout to, VkPipelineStageFlags2 from_stage,
                                              VkAccessFlags2 from_access, VkPipelineStageFlags2 to_stage,
                                              VkAccessFlags2 to_access);
/* Records several of them as one command. */
void vulkan_image_barriers(VkCommandBuffer commands, const VkImageMemoryBarrier2 *transitions, uint32_t count);
/* The transition of vulkan_image_transition, recorded as one command. */
void vulkan_image_barrier(VkCommandBuffer commands, VkImage image, VkImageAspectFlags aspect, VkImageLayout from,
                          VkImageLayout to, VkPipelineStageFlags2 from_stage, VkAccessFlags2 from_access,
                          VkPipelineStageFlags2 to_stage, VkAccessFlags2 to_access);
/* Makes copies recorded so far visible to the CPU once the submission has finished. */
void vulkan_host_barrier(VkCommandBuffer commands);

/* vulkan_memory.c: buffers and images, each with memory of its own (a frame has few). */

typedef enum vulkan_memory_kind {
	VULKAN_MEMORY_DEVICE,   /* only the GPU uses it */
	VULKAN_MEMORY_WRITE,    /* the CPU writes once, the GPU reads: device local if the CPU can map that */
	VULKAN_MEMORY_SHARED,   /* the CPU writes and may read, the GPU reads: cached by the CPU */
	VULKAN_MEMORY_READBACK, /* the GPU writes, the CPU reads: cached by the CPU */
} vulkan_memory_kind;

/* size > 0, bytes. On failure *buffer is {0}; the message says how much memory was asked for. */
stilb_result vulkan_buffer_create(vulkan_device *device, VkDeviceSize size, VkBufferUsageFlags usage,
                                  vulkan_memory_kind kind, vulkan_buffer *buffer);
/* Leaves {0}; accepts {0}. */
void vulkan_buffer_destroy(vulkan_device *device, vulkan_buffer *buffer);
/* The caller has checked that the GPU supports such an image. On failure *image is {0}. */
VkResult vulkan_image_create(vulkan_device *device, const VkImageCreateInfo *info, VkImageAspectFlags aspect,
                             vulkan_image *image);
/* Leaves {0}; accepts {0}. */
void vulkan_image_destroy(vulkan_device *device, vulkan_image *image);

/* vulkan_heaps.c: the heaps of render_resources on the GPU. */
stilb_result vulkan_update(render_device *base, const render_resources *resources);
/* Stores `with` in *buffer, and destroys the old buffer when no frame can read it any more. On STILB_ERROR_MEMORY
 * *buffer is as before and `with` is destroyed. */
stilb_result vulkan_buffer_replace(vulkan_device *device, vulkan_buffer *buffer, vulkan_buffer with);
/* Destroys *buffer, which may be {0}, when no frame can read it any more, and leaves {0}. STILB_ERROR_MEMORY: *buffer
 * is as before. */
stilb_result vulkan_buffer_retire(vulkan_device *device, vulkan_buffer *buffer);
/* Call when the slot's last frame is done: destroys the buffers that were replaced in it. */
void vulkan_heaps_frame(vulkan_device *device, vulkan_slot *slot);
void vulkan_heaps_destroy_slot(vulkan_device *device, vulkan_slot *slot);
/* Bytes from one material to the next on the GPU. */
VkDeviceSize vulkan_material_stride(const vulkan_device *device);
/* Allocates the slots' material_set; nothing unless --materials bind. */
VkResult vulkan_material_sets_create(vulkan_device *device);

/* vulkan_texture.c: images and descriptor sets of textures. */
stilb_result vulkan_textures_create(vulkan_device *device);
void vulkan_textures_destroy(vulkan_device *device);
stilb_result vulkan_texture_create(render_device *base, uint32_t texture, const stilb_image *image);
void vulkan_texture_destroy(render_device *base, uint32_t texture);
/* Records the copy of the frame's rows of a texture, which lie in the slot's staging buffer at byte `at`, a multiple of
 * 16. The texture can be drawn once it has all. */
void vulkan_texture_copy(vulkan_device *device, const render_texture_upload *upload, VkDeviceSize at);

/* vulkan_pipeline.c: shaders, layouts, pipelines. */
stilb_result vulkan_pipeline_create(vulkan_device *device);
void vulkan_pipeline_destroy(vulkan_device *device);
/* Makes the pipelines that a scene pass needs, unless an earlier pass has, and stores them as device->shading. */
stilb_result vulkan_pipeline_choose(vulkan_device *device, const render_stream *stream);
/* Makes a pipeline unless it is there; if another thread makes it, waits for that. `make` stores it. [any-thread] */
typedef VkResult vulkan_make_fn(vulkan_device *device, const void *what, VkPipeline *pipeline);
VkResult vulkan_pipeline_once(vulkan_device *device, vulkan_pipeline *pipeline, vulkan_make_fn *make, const void *what);
/* See render_device_functions.prepare. */
stilb_result vulkan_prepare(render_device *base, const stilb_render_view *view, uint32_t light_bits);
/* The pipeline for a draw's state. [any-thread] while a pass is replayed. */
VkPipeline vulkan_pipeline_for(const vulkan_device *device, uint64_t state);

/* vulkan_frame.c: slots, the images that are drawn into, memory, submission. */
stilb_result vulkan_frames_create(vulkan_device *device);
void vulkan_frames_destroy(vulkan_device *device);
stilb_result vulkan_targets_create(vulkan_device *device);
void vulkan_targets_destroy(vulkan_device *device);
stilb_result vulkan_frame_begin(render_device *base, render_memory *memory);
stilb_result vulkan_grow(render_device *base, render_memory *memory, render_memory_kind kind, uint32_t capacity,
                         uint32_t keep);
stilb_result vulkan_submit(render_device *base);
stilb_result vulkan_wait(render_device *base);
void *vulkan_panorama_make(render_device *base, size_t bytes);
void vulkan_panorama_show(render_device *base);
/* Submits a command buffer. Its transfers wait for the semaphore `wait`, and it signals `signal` and the timeline's
 * next value; both semaphores may be null. */
stilb_result vulkan_queue_submit(vulkan_device *device, VkCommandBuffer commands, VkSemaphore wait, VkSemaphore signal);
/* Waits until the GPU has finished the submission that signals `value`. */
stilb_result vulkan_timeline_wait(vulkan_device *device, uint64_t value);

/* vulkan_times.c: timestamps, in the order of the calls of a frame. */
stilb_result vulkan_times_create(vulkan_device *device);
void vulkan_times_destroy(vulkan_device *device);
void vulkan_times_begin(vulkan_device *device);
void vulkan_times_pass_begin(vulkan_device *device, const stilb_prof_site *name);
void vulkan_times_pass_end(vulkan_device *device);
void vulkan_times_end(vulkan_device *device);
/* Call right after the submission of the frame's draws. good: it succeeded. */
void vulkan_times_submitted(vulkan_device *device, bool good);
/* Call when the slot's frame is done, for frames in the order of their submission. Does nothing if it was read
 * already. */
void vulkan_times_read(vulkan_device *device, vulkan_slot *slot);

/* vulkan_pass.c: the commands of one pass. */
stilb_result vulkan_pass(render_device *base, const render_stream *stream);

/* vulkan_backdrop.c: what is seen where no model is. */

/* True if what is seen is more than the colour that the picture is cleared to. */
bool vulkan_backdrop_is_drawn(const render_stream *stream);
/* The colour that the picture is cleared to: of the backdrop, or of the sky or the ground, tone mapped as the fragment
 * shader does it; black without a view. */
VkClearColorValue vulkan_backdrop_clear(const vulkan_device *device, const stilb_render_view *view);
/* Makes the pipeline that draws backdrops. [any-thread] */
stilb_result vulkan_backdrop_make(vulkan_device *device);
/* Makes what is missing to draw the backdrop of the stream's view and writes it to the slot's memory. */
stilb_result vulkan_backdrop_prepare(vulkan_device *device, vulkan_slot *slot, const render_stream *stream);
/* Draws it, after vulkan_draws_area. */
void vulkan_backdrop_draw(const vulkan_device *device, const vulkan_slot *slot);
void vulkan_backdrop_destroy(vulkan_device *device);

/* vulkan_draws.c: the draws of a stream and their bindings. */

/* Sets viewport and scissor to the whole picture: every command buffer needs it, secondary ones inherit nothing. */
void vulkan_draws_area(const vulkan_device *device, VkCommandBuffer commands);
/* Records one command for each draw of the part. */
vulkan_sent vulkan_draws_direct(vulkan_device *device, VkCommandBuffer commands, const render_stream *stream,
                                render_part part);
/* Records one indirect command for each run (draws with the same bindings); sent.draws counts these commands. */
vulkan_sent vulkan_draws_indirect(vulkan_device *device, VkCommandBuffer commands, const render_stream *stream);

/* vulkan_secondary.c: a command buffer for each worker. */

/* Records the stream into commands[count] on its pool, 1..VULKAN_MAX_LISTS; to be executed in the order of the
 * array. */
stilb_result vulkan_secondary_record(vulkan_device *device, const render_stream *stream, uint32_t count,
                                     VkCommandBuffer *commands);
/* Destroys the slot's lists. The GPU must have finished the slot's frame. */
void vulkan_secondary_destroy(vulkan_device *device, vulkan_slot *slot);

/* vulkan_present.c: the picture to the window or to memory. */
stilb_result vulkan_swapchain_create(vulkan_device *device);
void vulkan_swapchain_destroy(vulkan_device *device);
stilb_result vulkan_present(render_device *base);
stilb_result vulkan_set_surface(render_device *base, const stilb_render_surface *surface);
stilb_result vulkan_read_image(render_device *base, stilb_image *image);

#endif
