/*
 * The Vulkan device, version 1.3: dynamic rendering, synchronization2, timeline semaphores, buffer addresses.
 *
 * Two frame slots. A slot owns everything the CPU writes for a frame, and is written again only when the timeline says
 * that the GPU is done with it. A frame makes two submissions: `draw` (the passes, into the picture) and `show` (the
 * picture to the window or to memory). The picture itself is one image: frames follow each other on one queue, and
 * barriers order them.
 * Shaders get addresses in a push constant. Descriptor sets are for what has no address, textures (set 0), and for
 * materials that are to be bound one by one (set 1, --materials bind).
 */
#ifndef STILB_VULKAN_INTERNAL_H
#define STILB_VULKAN_INTERNAL_H

#include "render/render_internal.h"

#include <vulkan/vulkan.h>

#define VULKAN_SLOTS RENDER_FRAMES_IN_FLIGHT
#define VULKAN_MAX_SWAPCHAIN_IMAGES 16
#define VULKAN_MAX_LISTS (STILB_JOB_MAX_WORKERS + 1)

typedef struct vulkan_buffer {
	VkBuffer buffer;
	VkDeviceMemory memory;
	VkDeviceSize size;
	VkDeviceAddress address; /* 0 unless made with VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT */
	void *mapped;            /* NULL unless the host can see it */
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
	float sun_direction[4];
	float sun_irradiance[4];
	float sky[4];
	float ground[4];
	float lamp_position[3], lamp_radius;
	float lamp_axis[3], lamp_reach;
	float lamp_intensity[4];
	float added[4]; /* to every material's roughness, anisotropy, wrap and specular */
} vulkan_view;

static_assert(sizeof(vulkan_view) == 208, "std430");

typedef struct vulkan_push {
	VkDeviceAddress view, rows, materials;
} vulkan_push;

/* Of 2D passes (shaders/flat.vert). */
typedef struct vulkan_push_2d {
	float scale[2]; /* pixels to clip space */
	VkDeviceAddress rows;
} vulkan_push_2d;

static_assert(sizeof(vulkan_push_2d) <= sizeof(vulkan_push), "one pipeline layout serves both");

/* What went into a command buffer. */
typedef struct vulkan_sent {
	uint64_t draws, binds;
} vulkan_sent;

/* Secondary command buffers: a list is recorded by one job at a time, a command buffer for each pass of the frame. */
typedef struct vulkan_list {
	_Alignas(STILB_CACHE_LINE) VkCommandPool pool;
	VkCommandBuffer commands[STILB_RENDER_MAX_PASSES];
	uint32_t made, used; /* of commands; used in this frame */
	VkResult result;     /* of the last recording */
	vulkan_sent sent;
} vulkan_list;

/* The GPU's clock and CLOCK_MONOTONIC, read together; ns 0: never. */
typedef struct vulkan_moment {
	uint64_t ticks, ns;
} vulkan_moment;

/* The timestamps of a slot's frame. */
typedef struct vulkan_slot_times {
	vulkan_buffer results;                                 /* the frame's begin and end, and those of each pass */
	const stilb_prof_site *sites[STILB_RENDER_MAX_PASSES]; /* [passes] their names */
	uint32_t passes;
	bool taken;            /* submitted, and not yet read */
	vulkan_moment moment;  /* near the frame */
	uint64_t submitted_ns; /* CLOCK_MONOTONIC */
} vulkan_slot_times;

typedef struct vulkan_times {
	VkQueryPool queries;                          /* null: the queue has no clock */
	PFN_vkGetCalibratedTimestampsEXT read_clocks; /* NULL: this GPU cannot */
	vulkan_moment moment;                         /* the last good one */
	stilb_prof_lane_handle *lane;                 /* NULL: there was no memory for it */
	uint64_t shown_ns;                            /* the end of the last frame in the lane */
} vulkan_times;

typedef struct vulkan_slot {
	VkCommandPool pool;
	VkCommandBuffer draw, show;
	VkSemaphore acquired; /* the window's image is ours */
	vulkan_list *lists;   /* [list_count] with secondary replay: one a worker, as far as there have been workers */
	uint32_t list_count;
	vulkan_buffer memory[RENDER_MEMORY_KINDS];
	vulkan_buffer staging; /* what update copies from */
	vulkan_buffer
		*outgrown; /* [outgrown_count] replaced in this slot's frame, and still read by it or the one before */
	uint32_t outgrown_count, outgrown_capacity;
	VkDescriptorSet material_set; /* of the buffer of materials that the slot's frame uses */
	VkBuffer material_buffer;     /* in it */
	vulkan_buffer views;          /* vulkan_view[STILB_RENDER_MAX_PASSES] */
	vulkan_buffer picture;        /* the picture in memory, when there is no window */
	vulkan_slot_times times;
	uint64_t done; /* timeline value of the slot's last submission */
	bool picture_valid;
} vulkan_slot;

/* Textures are made and destroyed with the lock of resources; a draw reads the set of one that stays. */
typedef struct vulkan_texture {
	vulkan_image image;
	VkDescriptorSet set;
} vulkan_texture;

/* Pipelines differ in whether they read a texture, and in which materials they draw (shaders/mesh.frag). */
typedef enum vulkan_pipeline_materials {
	VULKAN_PIPELINE_ANY,
	VULKAN_PIPELINE_EVEN,
	VULKAN_PIPELINE_ODD,
	VULKAN_PIPELINE_MATERIALS,
} vulkan_pipeline_materials;

/* The formulas that a pipeline is compiled with, in the order of the shader's constants. */
typedef enum vulkan_formula {
	VULKAN_FORMULA_BRDF,
	VULKAN_FORMULA_NDF,
	VULKAN_FORMULA_G,
	VULKAN_FORMULA_F,
	VULKAN_FORMULA_LIGHT,
	VULKAN_FORMULAS,
} vulkan_formula;

/* The mesh pipelines of one choice of formulas: without and with a texture. Null: none such has been needed. */
typedef struct vulkan_shading {
	uint32_t formulas[VULKAN_FORMULAS];
	VkPipeline pipelines[2][VULKAN_PIPELINE_MATERIALS];
} vulkan_shading;

typedef struct vulkan_swapchain {
	VkSwapchainKHR handle;
	VkExtent2D extent;
	uint32_t image_count;
	VkImage images[VULKAN_MAX_SWAPCHAIN_IMAGES];
	VkSemaphore shown[VULKAN_MAX_SWAPCHAIN_IMAGES]; /* the blit into this image is done */
	bool stale;
} vulkan_swapchain;

typedef struct vulkan_device {
	render_device base;

	VkInstance instance;
	VkDebugUtilsMessengerEXT messenger;
	PFN_vkCmdBeginDebugUtilsLabelEXT label_begin; /* NULL: not validating */
	PFN_vkCmdEndDebugUtilsLabelEXT label_end;
	VkSurfaceKHR surface; /* null without a window */
	bool surface_lost;    /* it has gone: the picture goes to memory */
	VkPhysicalDevice gpu;
	VkPhysicalDeviceProperties properties;
	VkPhysicalDeviceMemoryProperties memory;
	VkDevice device;
	VkQueue queue;
	uint32_t queue_family;

	VkSemaphore timeline;
	uint64_t timeline_value;
	uint64_t timestamp_mask; /* the bits that count; 0: the queue has no clock */
	bool calibrates;         /* VK_EXT_calibrated_timestamps is on */
	vulkan_times times;

	const VkAllocationCallbacks *allocator; /* of everything that belongs to the device; NULL: the driver's own */

	VkSampler sampler; /* of all textures: linear, repeated, no mip levels */
	VkDescriptorSetLayout texture_layout, material_layout;
	VkDescriptorPool texture_pool, material_pool;
	vulkan_texture *textures; /* [STILB_RENDER_MAX_TEXTURES] */
	VkPipelineLayout pipeline_layout;
	VkShaderModule mesh_modules[2][2]; /* [texture][stage], kept for the pipelines that are still to come */
	vulkan_shading *shadings;          /* [shading_count] every choice that a pass has had */
	uint32_t shading_count, shading_capacity;
	const vulkan_shading *shading; /* of the pass that is being replayed; secondary lists read it on other threads */
	VkPipeline pipelines_2d[2];    /* without and with a texture */
	stilb_render_output output;
	VkFormat color_format;
	vulkan_image color;         /* the picture, one sample */
	vulkan_image color_samples; /* with 4 samples; resolved into color */
	vulkan_image depth;
	bool drawn; /* color holds a picture, ready to be copied from */

	vulkan_buffer heaps[RENDER_HEAPS];

	vulkan_slot slots[VULKAN_SLOTS];
	uint32_t slot;
	uint32_t pass; /* passes begun in this frame */
	vulkan_swapchain swapchain;
} vulkan_device;

/* What a frame's slot is now. */
static inline vulkan_slot *vulkan_slot_now(vulkan_device *device)
{
	return &device->slots[device->slot];
}

/* The allocator of devices made from now on: for tests. NULL, as at the start: the driver's own. */
extern const VkAllocationCallbacks *vulkan_host_allocator;

/* vulkan_instance.c: what there is before a device. */

/* Turns a VkResult into a result and a message: "cannot WHAT: out of memory (VK_ERROR_OUT_OF_HOST_MEMORY -1); try
 * ...". */
stilb_result vulkan_fail(const vulkan_device *device, VkResult error, const char *what);
stilb_result vulkan_instance_create(vulkan_device *device, const stilb_render_desc *desc);
stilb_result vulkan_gpu_select(vulkan_device *device, const char *wanted);
void vulkan_instance_destroy(vulkan_device *device);

/* vulkan_barrier.c: barriers between the commands of a queue. */

/* One image barrier: everything in from_stage and its writes come before everything in to_stage, and the layout changes in
 * between. VK_IMAGE_LAYOUT_UNDEFINED as `from` discards the contents. */
VkImageMemoryBarrier2 vulkan_image_transition(VkImage image, VkImageAspectFlags aspect, VkImageLayout from,
                                              VkImageLayout to, VkPipelineStageFlags2 from_stage,
                                              VkAccessFlags2 from_access, VkPipelineStageFlags2 to_stage,
                                              VkAccessFlags2 to_access);
/* Records several of them as one command. */
void vulkan_image_barriers(VkCommandBuffer commands, const VkImageMemoryBarrier2 *transitions, uint32_t count);
/* Records a single transition. */
void vulkan_image_barrier(VkCommandBuffer commands, VkImage image, VkImageAspectFlags aspect, VkImageLayout from,
                          VkImageLayout to, VkPipelineStageFlags2 from_stage, VkAccessFlags2 from_access,
                          VkPipelineStageFlags2 to_stage, VkAccessFlags2 to_access);
/* Makes copies recorded so far visible to the CPU once the submission has finished. */
void vulkan_host_barrier(VkCommandBuffer commands);

/* vulkan_memory.c: buffers and images, each with memory of its own (a frame has few). */

typedef enum vulkan_memory_kind {
	VULKAN_MEMORY_DEVICE,   /* the GPU alone */
	VULKAN_MEMORY_WRITE,    /* the CPU writes once, the GPU reads: device local where the CPU can reach it */
	VULKAN_MEMORY_SHARED,   /* the CPU writes and may read, the GPU reads: cached */
	VULKAN_MEMORY_READBACK, /* the GPU writes, the CPU reads: cached */
} vulkan_memory_kind;

stilb_result vulkan_buffer_create(vulkan_device *device, VkDeviceSize size, VkBufferUsageFlags usage,
                                  vulkan_memory_kind kind, vulkan_buffer *buffer);
void vulkan_buffer_destroy(vulkan_device *device, vulkan_buffer *buffer);
/* The caller has asked whether the GPU can. */
VkResult vulkan_image_create(vulkan_device *device, const VkImageCreateInfo *info, VkImageAspectFlags aspect,
                             vulkan_image *image);
void vulkan_image_destroy(vulkan_device *device, vulkan_image *image);

/* vulkan_heaps.c: what render_resources keeps, on the GPU. */
stilb_result vulkan_update(render_device *base, const render_resources *resources);
/* Replaces a buffer that the slot's frame or the one before may still read. Without memory nothing has happened. */
stilb_result vulkan_buffer_replace(vulkan_device *device, vulkan_buffer *buffer, vulkan_buffer with);
/* The slot's frame is done: frees what only that frame still used. */
void vulkan_heaps_frame(vulkan_device *device, vulkan_slot *slot);
void vulkan_heaps_destroy_slot(vulkan_device *device, vulkan_slot *slot);
/* From one material to the next on the GPU, bytes. */
VkDeviceSize vulkan_material_stride(const vulkan_device *device);
/* With --materials bind: the slots' sets. */
VkResult vulkan_material_sets_create(vulkan_device *device);

/* vulkan_texture.c */
stilb_result vulkan_textures_create(vulkan_device *device);
void vulkan_textures_destroy(vulkan_device *device);
stilb_result vulkan_texture_create(render_device *base, uint32_t texture, const stilb_image *image);
void vulkan_texture_destroy(render_device *base, uint32_t texture);
/* Adds the copy of such pixels to the frame: they lie in the staging buffer at `at`, a multiple of a pixel's size. */
void vulkan_texture_copy(vulkan_device *device, const render_texture_upload *upload, VkDeviceSize at);

/* vulkan_pipeline.c */
stilb_result vulkan_pipeline_create(vulkan_device *device);
void vulkan_pipeline_destroy(vulkan_device *device);
/* Makes what a scene pass's draws need and no pass before it has needed, and chooses it. */
stilb_result vulkan_pipeline_choose(vulkan_device *device, const render_stream *stream);
/* [any-thread] while a pass is replayed. */
VkPipeline vulkan_pipeline_for(const vulkan_device *device, uint64_t state);

/* vulkan_frame.c */
stilb_result vulkan_frames_create(vulkan_device *device);
void vulkan_frames_destroy(vulkan_device *device);
stilb_result vulkan_targets_create(vulkan_device *device);
void vulkan_targets_destroy(vulkan_device *device);
stilb_result vulkan_frame_begin(render_device *base, render_memory *memory);
stilb_result vulkan_grow(render_device *base, render_memory *memory, render_memory_kind kind, uint32_t capacity,
                         uint32_t keep);
stilb_result vulkan_submit(render_device *base);
stilb_result vulkan_wait(render_device *base);
/* Submits a command buffer, waits for wait (or null) before transfers, signals signal (or null) and the timeline. */
stilb_result vulkan_queue_submit(vulkan_device *device, VkCommandBuffer commands, VkSemaphore wait, VkSemaphore signal);
stilb_result vulkan_timeline_wait(vulkan_device *device, uint64_t value);

/* vulkan_times.c: timestamps, in the order of the calls of a frame. */
stilb_result vulkan_times_create(vulkan_device *device);
void vulkan_times_destroy(vulkan_device *device);
void vulkan_times_begin(vulkan_device *device);
void vulkan_times_pass_begin(vulkan_device *device, const stilb_prof_site *name);
void vulkan_times_pass_end(vulkan_device *device);
void vulkan_times_end(vulkan_device *device);
/* Right after the submission of what has them. */
void vulkan_times_submitted(vulkan_device *device, bool good);
/* The slot's frame is done; frames in the order of their submission. Once read, nothing happens. */
void vulkan_times_read(vulkan_device *device, vulkan_slot *slot);

/* vulkan_pass.c */
stilb_result vulkan_pass(render_device *base, const render_stream *stream);

/* vulkan_draws.c: the draws of a stream, and what is bound for them. */

/* Viewport and scissor: command buffers inherit nothing. */
void vulkan_draws_area(const vulkan_device *device, VkCommandBuffer commands);
vulkan_sent vulkan_draws_direct(vulkan_device *device, VkCommandBuffer commands, const render_stream *stream,
                                render_part part);
/* Here draws counts device commands. */
vulkan_sent vulkan_draws_indirect(vulkan_device *device, VkCommandBuffer commands, const render_stream *stream);

/* vulkan_secondary.c: a command buffer for each worker. */

/* Records the stream into count command buffers, on its pool; they execute in the order of the array. */
stilb_result vulkan_secondary_record(vulkan_device *device, const render_stream *stream, uint32_t count,
                                     VkCommandBuffer *commands);
/* Lists that no frame has in flight. */
void vulkan_secondary_destroy(vulkan_device *device, vulkan_slot *slot);

/* vulkan_present.c */
stilb_result vulkan_swapchain_create(vulkan_device *device);
void vulkan_swapchain_destroy(vulkan_device *device);
stilb_result vulkan_present(render_device *base);
stilb_result vulkan_read_image(render_device *base, stilb_image *image);

#endif
