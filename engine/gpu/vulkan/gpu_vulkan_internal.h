/*
 * The Vulkan device, version 1.3: dynamic rendering, synchronization2, timeline semaphores, buffer addresses.
 *
 * There are two frame slots. A slot owns the command buffers of a frame, and is reused when the timeline semaphore says
 * that the GPU is done with it. A frame makes two submissions: `draw` (what is drawn) and, in a window, `show` (the
 * picture to it). All frames follow each other on one queue, and barriers order them.
 */
#ifndef STILB_GPU_VULKAN_INTERNAL_H
#define STILB_GPU_VULKAN_INTERNAL_H

#include "gpu/gpu_internal.h"
#include "gpu/gpu_memory_internal.h"
#include "profiler/prof.h"

#include <pthread.h>
#include <string.h>
#include <vulkan/vulkan.h>

#define GPU_VULKAN_MAX_SWAPCHAIN_IMAGES 16

typedef struct gpu_vulkan_buffer {
	VkBuffer buffer;
	gpu_memory_place place;
	VkDeviceSize size;
	VkDeviceAddress address; /* 0 unless made with VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT */
	void *mapped;            /* for the CPU; NULL for STILB_GPU_MEMORY_DEVICE */
} gpu_vulkan_buffer;

typedef struct gpu_vulkan_image {
	VkImage image;
	VkImageView view;
	gpu_memory_place place;
} gpu_vulkan_image;

/* A view of an image: what of it, and how it is seen. */
typedef struct gpu_vulkan_view {
	VkImageViewType type;
	uint16_t mip, mips, layer, layers;
	VkImageView view;
} gpu_vulkan_view;

/* An image of any shape, with the views that were needed so far. */
typedef struct gpu_vulkan_texels {
	VkImage image;
	gpu_memory_place place; /* {0}: it lies in memory of others */
	stilb_gpu_extent extent;
	stilb_gpu_channels channels; /* of its views */
	VkFormat format;
	VkImageAspectFlags aspect;
	gpu_vulkan_view *views; /* [view_capacity], guarded by gpu_vulkan.views_lock */
	uint32_t view_count, view_capacity;
	uint64_t rested; /* the value of gpu_vulkan.resting that gave each part a layout which is not UNDEFINED; 0: none */
} gpu_vulkan_texels;

/* Something that is destroyed when the slot's frame is done. */
typedef struct gpu_vulkan_trash {
	gpu_vulkan_texels texels;
	gpu_vulkan_buffer buffer;
	gpu_memory_place place;
} gpu_vulkan_trash;

/* A kept, output or shown resource of plans, by its number (stilb_gpu_placed.stay). */
typedef struct gpu_vulkan_stay {
	stilb_gpu_extent extent; /* format NONE: a buffer */
	uint64_t bytes;
	gpu_vulkan_texels texels[2];
	gpu_vulkan_buffer buffers[2];
	uint32_t now;   /* which of two holds what the last frame wrote */
	uint64_t frame; /* whose plan had it last */
} gpu_vulkan_stay;

/* A plan's resource in shared memory, kept from frame to frame while it stays what and where it is. */
typedef struct gpu_vulkan_shared {
	stilb_gpu_extent extent;
	uint64_t bytes, offset;
	uint32_t heap;
	uint64_t heap_age; /* of the memory that it lies in */
	gpu_vulkan_texels texels;
	gpu_vulkan_buffer buffer;
} gpu_vulkan_shared;

/* Memory that resources of a plan share. */
typedef struct gpu_vulkan_heap {
	gpu_memory_place place;
	uint64_t age; /* another number for other memory; 0: none yet */
} gpu_vulkan_heap;

/* A plan's resource in this frame. */
typedef struct gpu_vulkan_target {
	gpu_vulkan_texels *texels, *before; /* before: what `previous` uses read; the same but for two */
	gpu_vulkan_buffer *buffer, *buffer_before;
	uint8_t *layouts; /* of owned images */
} gpu_vulkan_target;

/* Secondary command buffers of one part of a pass. */
typedef struct gpu_vulkan_list {
	_Alignas(STILB_CACHE_LINE) VkCommandPool pool;
	VkCommandBuffer *commands; /* [made] */
	uint32_t made, used;
} gpu_vulkan_list;

#define GPU_VULKAN_POOLS 64u /* of descriptors: each larger than the one before, up to a size */

/* The GPU's clock (ticks) and CLOCK_MONOTONIC (ns), read together; ns 0: never read. */
typedef struct gpu_vulkan_moment {
	uint64_t ticks, ns;
} gpu_vulkan_moment;

/* The timestamps of a slot's frame. */
typedef struct gpu_vulkan_slot_times {
	VkQueryPool queries;           /* null: the queue has no timestamps */
	gpu_vulkan_buffer results;     /* GPU ticks: begin and end of the frame, then of each pass */
	const stilb_prof_site **sites; /* [passes] names of the passes */
	uint32_t passes, capacity;
	bool taken;               /* the frame was submitted, its timestamps were not read */
	gpu_vulkan_moment moment; /* reading of both clocks that was the last at its submission */
	uint64_t submitted_ns;    /* CLOCK_MONOTONIC */
} gpu_vulkan_slot_times;

typedef struct gpu_vulkan_times {
	PFN_vkGetCalibratedTimestampsEXT read_clocks; /* NULL: this GPU cannot read both clocks together */
	gpu_vulkan_moment moment;                     /* the last accurate reading of both (TIMES_WORST_NS) */
	stilb_prof_lane_handle *lane;                 /* NULL: there was no memory for it */
	uint64_t shown_ns;                            /* end of the frame shown last in the lane, CLOCK_MONOTONIC */
} gpu_vulkan_times;

/* Commands of a frame up to a pass that is the program's function. */
typedef struct gpu_vulkan_part {
	VkCommandBuffer commands;
	const stilb_gpu_pass *pass; /* of the plan */
	const stilb_prof_site *site;
} gpu_vulkan_part;

typedef struct gpu_vulkan_slot {
	VkCommandPool pool;
	VkCommandBuffer draw, show;
	VkSemaphore acquired; /* signalled when the window's image may be drawn into */
	gpu_vulkan_slot_times times;
	uint64_t done; /* timeline value of the slot's last submission */

	/* of frames that are planned (gpu_vulkan_run.c) */
	VkDescriptorPool pools[GPU_VULKAN_POOLS];
	uint32_t pool_count, pool_now;
	gpu_vulkan_list *lists; /* [list_count] */
	uint32_t list_count;
	gpu_vulkan_part *parts; /* [part_count] of the frame, before `draw` */
	uint32_t part_count, part_capacity;
	VkCommandBuffer *extra; /* [extra_count] for copies that are asked for after the frame, and for its further parts */
	uint32_t extra_count, extra_used;
	gpu_vulkan_trash *trash; /* [trash_capacity] */
	uint32_t trash_count, trash_capacity;
} gpu_vulkan_slot;

typedef struct gpu_vulkan_swapchain {
	VkSwapchainKHR handle;
	VkExtent2D extent;
	uint32_t image_count;
	VkImage images[GPU_VULKAN_MAX_SWAPCHAIN_IMAGES];
	VkSemaphore shown[GPU_VULKAN_MAX_SWAPCHAIN_IMAGES]; /* signalled when the blit into this image is done */
	bool stale; /* the window has changed: must be made anew before its next use */
} gpu_vulkan_swapchain;

typedef struct gpu_vulkan {
	stilb_gpu base;

	VkInstance instance;
	VkDebugUtilsMessengerEXT messenger;
	PFN_vkCmdBeginDebugUtilsLabelEXT label_begin; /* NULL without desc.validate, and nobody captures */
	PFN_vkCmdEndDebugUtilsLabelEXT label_end;
	PFN_vkCmdInsertDebugUtilsLabelEXT label_insert; /* NULL unless RenderDoc captures */
	VkSurfaceKHR surface;                           /* null without a window */
	bool presents;                                  /* created with a surface: another one can take its place */
	stilb_gpu_presentation presentation;            /* of this surface; as asked for, or FIFO */
	stilb_gpu_presentation asked;                   /* as asked for */
	bool surface_lost;                              /* the window or its display has gone: pictures are not shown */
	VkPhysicalDevice physical;
	VkPhysicalDeviceProperties properties;
	VkPhysicalDeviceMemoryProperties memory;
	VkDevice device;
	VkQueue queue;
	uint32_t queue_family;

	VkSemaphore timeline;
	uint64_t timeline_value; /* the semaphore's value once the last submission is done */
	uint64_t timestamp_mask; /* valid bits of a timestamp; 0: the queue has none */
	bool anisotropic;        /* samplers can be */
	bool lines;              /* of triangles the edges alone can be drawn */
	bool counts;             /* depthClamp */
	bool some_colors;        /* independentBlend */
	bool calibrates;         /* VK_EXT_calibrated_timestamps is enabled */
	gpu_vulkan_times times;

	gpu_memory blocks;
	const VkAllocationCallbacks *allocator; /* for all objects of the device; NULL: the driver's own */

	/* Several threads may need pipelines: this guards which there are and which a thread is making, not their use. */
	pthread_mutex_t pipelines_lock;
	pthread_cond_t pipelines_made;
	bool pipelines_lock_made;

	gpu_vulkan_slot slots[STILB_GPU_FRAMES];
	uint32_t slot; /* index of the current frame's slot */
	gpu_vulkan_swapchain swapchain;

	/* what gpu.h's functions need */
	PFN_vkSetDebugUtilsObjectNameEXT object_name; /* as label_begin */
	stilb_lock views_lock;                        /* views of images, sets of draw lists */
	bool views_lock_made;
	VkSampler samplers[GPU_MAX_SAMPLERS];
	VkDescriptorSetLayout item_layouts[STILB_GPU_MAX_SET_ITEMS + 1]; /* by items */
	VkDescriptorPool item_pools[GPU_VULKAN_POOLS];
	uint32_t item_pool_count;
	gpu_vulkan_texels white; /* what stands for no image in sets */
	uint64_t white_rested;   /* as of other images */
	/* Images that no commands have given a layout yet, guarded by the device's lock. */
	gpu_image **fresh;
	uint32_t fresh_count, fresh_capacity;
	uint64_t resting; /* number of the commands that are recorded, or were last, and give images their first layouts */
	gpu_vulkan_stay *stays; /* [stay_capacity] by number */
	uint32_t stay_capacity;
	gpu_vulkan_shared *shared; /* [shared_capacity] by resource of the plan */
	uint32_t shared_capacity;
	gpu_vulkan_target *targets; /* [shared_capacity + 1] */
	gpu_vulkan_heap heaps[GPU_MEMORY_POOLS];
	uint64_t heap_ages;
	VkExtent2D picture; /* size of what the window shows, where the window says none of its own */
} gpu_vulkan;

/* The slot of the current frame. */
static inline gpu_vulkan_slot *gpu_vulkan_slot_now(gpu_vulkan *gpu)
{
	STILB_ASSERT(gpu->slot < STILB_GPU_FRAMES);
	return &gpu->slots[gpu->slot];
}

/* For tests: the allocator of devices that are created from now on. NULL, its first value: the driver's own. */
extern const VkAllocationCallbacks *gpu_vulkan_host_allocator;

/* gpu_vulkan_instance.c: errors, the instance, the choice of a GPU. */

/* The result for a VkResult that is an error, with the message "cannot WHAT: out of memory
 * (VK_ERROR_OUT_OF_HOST_MEMORY -1); try ...". */
stilb_result gpu_vulkan_fail(const gpu_vulkan *gpu, VkResult error, const char *what);
stilb_result gpu_vulkan_instance_create(gpu_vulkan *gpu, const stilb_gpu_desc *desc);
/* Makes the surface of a window, gpu->surface. STILB_ERROR_WINDOW: then it is null. */
stilb_result gpu_vulkan_surface_create(gpu_vulkan *gpu, const stilb_gpu_surface *surface);
/* Safe to call without a surface; its swapchain has been destroyed. */
void gpu_vulkan_surface_destroy(gpu_vulkan *gpu);
/* Chooses the GPU that `wanted` names (stilb_gpu_desc.name). */
stilb_result gpu_vulkan_gpu_select(gpu_vulkan *gpu, const char *wanted);
/* Safe to call again, and without an instance. */
void gpu_vulkan_instance_destroy(gpu_vulkan *gpu);
/* The words for a kind of GPU: "discrete GPU", ... , "other" also for kinds that are newer than this program. */
const char *gpu_vulkan_gpu_type_text(VkPhysicalDeviceType type);

/* gpu_vulkan_device.c */

/* Opens a GPU: with a timeline, slots, timestamps and, where there is a window, its swapchain. picture: what the window
 * shows. */
stilb_result gpu_vulkan_create(const stilb_gpu_desc *desc, VkExtent2D picture, gpu_vulkan **out);
/* Accepts NULL. What others made of it has been destroyed, after gpu_vulkan_idle. */
void gpu_vulkan_destroy(gpu_vulkan *gpu);
/* Waits until the GPU has nothing to do, also if the driver has no memory to wait with. */
void gpu_vulkan_idle(gpu_vulkan *gpu);
/* STILB_ERROR_MEMORY: a software driver needs this much address space, and there is not so much. */
stilb_result gpu_vulkan_check_memory(const gpu_vulkan *gpu, size_t bytes);

/* gpu_vulkan_barrier.c: barriers between the commands of a queue. */

/* One image barrier: everything in from_stage and its writes come before everything in to_stage, and the layout changes
 * in between. VK_IMAGE_LAYOUT_UNDEFINED as `from` discards the contents. */
VkImageMemoryBarrier2 gpu_vulkan_image_transition(VkImage image, VkImageAspectFlags aspect, VkImageLayout from,
                                                  VkImageLayout to, VkPipelineStageFlags2 from_stage,
                                                  VkAccessFlags2 from_access, VkPipelineStageFlags2 to_stage,
                                                  VkAccessFlags2 to_access);
/* Records several of them as one command. */
void gpu_vulkan_image_barriers(VkCommandBuffer commands, const VkImageMemoryBarrier2 *transitions, uint32_t count);
/* The transition of gpu_vulkan_image_transition, recorded as one command. */
void gpu_vulkan_image_barrier(VkCommandBuffer commands, VkImage image, VkImageAspectFlags aspect, VkImageLayout from,
                              VkImageLayout to, VkPipelineStageFlags2 from_stage, VkAccessFlags2 from_access,
                              VkPipelineStageFlags2 to_stage, VkAccessFlags2 to_access);
/* Makes copies recorded so far visible to the CPU once the submission has finished. */
void gpu_vulkan_host_barrier(VkCommandBuffer commands);

/* gpu_vulkan_memory.c: buffers and images. */

VkResult gpu_vulkan_memory_create(gpu_vulkan *gpu);
/* All buffers and images have been destroyed. */
void gpu_vulkan_memory_destroy(gpu_vulkan *gpu);

/* size > 0, bytes. On failure *buffer is {0}; the message says how much memory was asked for. */
stilb_result gpu_vulkan_buffer_create(gpu_vulkan *gpu, VkDeviceSize size, VkBufferUsageFlags usage,
                                      stilb_gpu_memory kind, gpu_vulkan_buffer *buffer);
/* Leaves {0}; accepts {0}. */
void gpu_vulkan_buffer_destroy(gpu_vulkan *gpu, gpu_vulkan_buffer *buffer);
/* The caller has checked that the GPU supports such an image. On failure *image is {0}. */
VkResult gpu_vulkan_image_create(gpu_vulkan *gpu, const VkImageCreateInfo *info, VkImageAspectFlags aspect,
                                 gpu_vulkan_image *image);
/* Leaves {0}; accepts {0}. */
void gpu_vulkan_image_destroy(gpu_vulkan *gpu, gpu_vulkan_image *image);

/* gpu_vulkan_once.c */

/* A pipeline that is made when it is first needed, or before. Both members are guarded by gpu_vulkan.pipelines_lock
 * until gpu_vulkan_pipeline_once has returned. */
typedef struct gpu_vulkan_pipeline {
	VkPipeline handle; /* null: not needed so far */
	bool making;       /* a thread compiles it */
} gpu_vulkan_pipeline;

VkResult gpu_vulkan_once_create(gpu_vulkan *gpu);
void gpu_vulkan_once_destroy(gpu_vulkan *gpu);
/* Makes a pipeline unless it is there; if another thread makes it, waits for that. `make` stores it. [any-thread] */
typedef VkResult gpu_vulkan_make_fn(void *user, const void *what, VkPipeline *pipeline);
VkResult gpu_vulkan_pipeline_once(gpu_vulkan *gpu, gpu_vulkan_pipeline *pipeline, gpu_vulkan_make_fn *make, void *user,
                                  const void *what);

/* gpu_vulkan_frame.c: slots and submission. */
stilb_result gpu_vulkan_frames_create(gpu_vulkan *gpu);
void gpu_vulkan_frames_destroy(gpu_vulkan *gpu);
/* Makes the next slot the current one: waits until the GPU is done with it, reads its timestamps and empties its
 * command buffers. */
stilb_result gpu_vulkan_slot_take(gpu_vulkan *gpu);
/* Begins `draw`, with timestamps for up to `passes` passes. */
stilb_result gpu_vulkan_slot_begin(gpu_vulkan *gpu, uint32_t passes);
/* A command buffer of the slot's `extra`, begun. */
VkResult gpu_vulkan_extra_begin(gpu_vulkan *gpu, gpu_vulkan_slot *slot, VkCommandBuffer *commands);
/* Ends a part of the frame with a pass of kind HOST: `draw` is then another command buffer, begun. */
stilb_result gpu_vulkan_slot_split(gpu_vulkan *gpu, const stilb_gpu_pass *pass, const stilb_prof_site *site);
/* Ends and submits `draw`. Before that, each part of the frame: submits it, waits for it, and calls its function. */
stilb_result gpu_vulkan_slot_submit(gpu_vulkan *gpu);
/* Begins `show`. */
stilb_result gpu_vulkan_show_begin(gpu_vulkan *gpu, gpu_vulkan_slot *slot);
/* Ends and submits `show`; see gpu_vulkan_queue_submit. */
stilb_result gpu_vulkan_show_submit(gpu_vulkan *gpu, gpu_vulkan_slot *slot, VkSemaphore wait, VkSemaphore signal);
/* Submits a command buffer. Its transfers wait for the semaphore `wait`, and it signals `signal` and the timeline's
 * next value; both semaphores may be null. */
stilb_result gpu_vulkan_queue_submit(gpu_vulkan *gpu, VkCommandBuffer commands, VkSemaphore wait, VkSemaphore signal);
/* Waits until the GPU has finished the submission that signals `value`. */
stilb_result gpu_vulkan_timeline_wait(gpu_vulkan *gpu, uint64_t value);
/* Waits for everything that was submitted, and reads all timestamps. */
stilb_result gpu_vulkan_wait(gpu_vulkan *gpu);

/* gpu_vulkan_times.c: timestamps, in the order of the calls of a frame. */
stilb_result gpu_vulkan_times_create(gpu_vulkan *gpu);
void gpu_vulkan_times_destroy(gpu_vulkan *gpu);
/* For up to `passes` passes; the slot's last frame has been read. */
stilb_result gpu_vulkan_times_begin(gpu_vulkan *gpu, uint32_t passes);
void gpu_vulkan_times_pass_begin(gpu_vulkan *gpu, const stilb_prof_site *name);
void gpu_vulkan_times_pass_end(gpu_vulkan *gpu);
void gpu_vulkan_times_end(gpu_vulkan *gpu);
/* Call right after the submission of the frame's draws. good: it succeeded. */
void gpu_vulkan_times_submitted(gpu_vulkan *gpu, bool good);
/* Call when the slot's frame is done, for frames in the order of their submission. Does nothing if it was read
 * already. */
void gpu_vulkan_times_read(gpu_vulkan *gpu, gpu_vulkan_slot *slot);

/* gpu_vulkan_present.c: a picture to the window. */
stilb_result gpu_vulkan_swapchain_create(gpu_vulkan *gpu);
void gpu_vulkan_swapchain_destroy(gpu_vulkan *gpu);
stilb_result gpu_vulkan_set_surface(gpu_vulkan *gpu, const stilb_gpu_surface *surface);
/* Copies an image, which is in the layout TRANSFER_SRC_OPTIMAL, to the window, scaled where sizes differ. The window
 * has been created and is not lost. STILB_ERROR_WINDOW: it is now (gpu->surface_lost). */
stilb_result gpu_vulkan_present_image(gpu_vulkan *gpu, VkImage image, VkExtent2D size);

/* ---- devices of gpu.h -------------------------------------------------------------------------------------------- */

/* gpu_vulkan_memory.c: memory for what gpu.h knows. */

/* Vulkan's handle, a pointer, or a number on machines of 32 bits. */
static inline VkDeviceMemory gpu_vulkan_memory_of(gpu_memory_handle handle)
{
	VkDeviceMemory memory;
	static_assert(sizeof memory <= sizeof handle.memory, "it fits");
	memcpy(&memory, &handle.memory, sizeof memory);
	return memory;
}

/* Which heap (stilb_gpu_needs.heap) something with these needs lies in. */
uint32_t gpu_vulkan_memory_heap(const gpu_vulkan *gpu, VkMemoryRequirements needs, bool image);
/* Takes memory of a heap. */
VkResult gpu_vulkan_memory_take(gpu_vulkan *gpu, uint32_t heap, uint64_t bytes, uint64_t align,
                                gpu_memory_place *place);

/* gpu_vulkan_image.c: images of all shapes, their views, samplers, sets. */
VkFormat gpu_vulkan_format(stilb_gpu_format format);
void gpu_vulkan_formats_find(gpu_vulkan *gpu);
/* What memory such an image needs. */
VkResult gpu_vulkan_texels_needs(gpu_vulkan *gpu, const stilb_gpu_extent *extent, VkMemoryRequirements *needs);
/* memory: where it lies, with an offset; NULL: it gets memory of its own. name: for debuggers. */
VkResult gpu_vulkan_texels_create(gpu_vulkan *gpu, const char *name, const stilb_gpu_extent *extent,
                                  const gpu_memory_place *memory, uint64_t offset, gpu_vulkan_texels *texels);
/* Leaves {0}; accepts {0}. */
void gpu_vulkan_texels_destroy(gpu_vulkan *gpu, gpu_vulkan_texels *texels);
/* A view, made when it is first asked for. VK_NULL_HANDLE: no memory. [any-thread] */
/* ARRAY: sampled, as an array also where it has one layer. */
typedef enum gpu_vulkan_seen {
	GPU_VULKAN_SAMPLED,
	GPU_VULKAN_ARRAY,
	GPU_VULKAN_STORED,
	GPU_VULKAN_DRAWN
} gpu_vulkan_seen;
VkImageView gpu_vulkan_texels_view(gpu_vulkan *gpu, gpu_vulkan_texels *texels, gpu_vulkan_seen seen,
                                   stilb_gpu_range range);
VkImageLayout gpu_vulkan_layout(stilb_gpu_layout layout);

/* The stencil's format of attachments with this format of depth; UNDEFINED: there is none. */
static inline VkFormat gpu_vulkan_stencil_format(VkFormat depth)
{
	return depth == VK_FORMAT_D32_SFLOAT_S8_UINT ? depth : VK_FORMAT_UNDEFINED;
}
/* The layout in which an image waits for draws that sample it. */
stilb_gpu_layout gpu_vulkan_rest(const stilb_gpu_extent *extent);
void gpu_vulkan_name(gpu_vulkan *gpu, VkObjectType type, uint64_t object, const char *name);

stilb_result gpu_vulkan_image_make(stilb_gpu *gpu, gpu_image *image);
void gpu_vulkan_image_free(stilb_gpu *gpu, gpu_image *image);
stilb_result gpu_vulkan_sampler_make(stilb_gpu *gpu, uint32_t index, const stilb_gpu_sampler_desc *desc);
stilb_result gpu_vulkan_set_make(stilb_gpu *gpu, gpu_set *set);
void gpu_vulkan_set_free(stilb_gpu *gpu, gpu_set *set);
VkDescriptorSet gpu_vulkan_set_handle(const gpu_set *set);
/* Makes item_layouts[count], the layout of sets of so many images, unless it is there. The caller holds views_lock. */
VkResult gpu_vulkan_set_layout(gpu_vulkan *gpu, uint32_t count);

/* gpu_vulkan_program.c */
typedef struct gpu_vulkan_variant {
	VkFormat colors[STILB_GPU_MAX_COLORS];
	uint32_t color_count;
	VkFormat depth;
	uint32_t samples;
	gpu_vulkan_pipeline pipeline;
} gpu_vulkan_variant;

typedef struct gpu_vulkan_program {
	VkShaderModule modules[2]; /* vertex and fragment, or compute */
	VkDescriptorSetLayout uses;
	VkPipelineLayout layout;
	gpu_vulkan_variant **variants; /* [variant_capacity], guarded by pipelines_lock */
	uint32_t variant_count, variant_capacity;
} gpu_vulkan_program;

stilb_result gpu_vulkan_program_make(stilb_gpu *gpu, gpu_program *program);
void gpu_vulkan_program_free(stilb_gpu *gpu, gpu_program *program);
stilb_result gpu_vulkan_program_prepare(stilb_gpu *gpu, gpu_program *program, const stilb_gpu_format *colors,
                                        uint32_t color_count, stilb_gpu_format depth, uint32_t samples);
stilb_result gpu_vulkan_program_follow(stilb_gpu *gpu, const gpu_program *from, gpu_program *to);
stilb_result gpu_vulkan_program_compile(stilb_gpu *gpu, gpu_program *program);
/* The pipeline for these attachments, compiled unless it is there. [any-thread] */
stilb_result gpu_vulkan_program_pipeline(gpu_vulkan *gpu, gpu_program *program, const gpu_vulkan_variant *wanted,
                                         VkPipeline *pipeline);
VkShaderStageFlags gpu_vulkan_program_stages(const stilb_gpu_program_desc *desc);

/* gpu_vulkan_target.c: what stands for a plan's resources. */
stilb_result gpu_vulkan_targets_take(gpu_vulkan *gpu, const stilb_gpu_plan *plan);
/* The frame was submitted: of two, the other one is now last frame's; and owned images are as the plan left them. */
void gpu_vulkan_targets_done(gpu_vulkan *gpu, const stilb_gpu_plan *plan);
void gpu_vulkan_targets_free(gpu_vulkan *gpu);
/* What memory a plan's buffer needs. */
VkResult gpu_vulkan_shared_buffer_needs(gpu_vulkan *gpu, uint64_t bytes, VkMemoryRequirements *needs);
/* Destroys it when the slot's frame is done. Waits for the GPU where there is no memory to remember it. */
void gpu_vulkan_trash_add(gpu_vulkan *gpu, gpu_vulkan_trash item);
void gpu_vulkan_trash_empty(gpu_vulkan *gpu, gpu_vulkan_slot *slot);

/* gpu_vulkan_access.c: barriers of a plan. */
/* Records barriers first .. first + count - 1 of the plan. */
void gpu_vulkan_plan_barriers(gpu_vulkan *gpu, VkCommandBuffer commands, const stilb_gpu_plan *plan, uint32_t first,
                              uint32_t count);
/* One barrier for the layout of a part of an image, which waits for all and lets all wait; and the same, recorded. */
VkImageMemoryBarrier2 gpu_vulkan_relayout_barrier(const gpu_vulkan_texels *texels, stilb_gpu_layout from,
                                                  stilb_gpu_layout to, stilb_gpu_range range);
void gpu_vulkan_relayout(VkCommandBuffer commands, const gpu_vulkan_texels *texels, stilb_gpu_layout from,
                         stilb_gpu_layout to, stilb_gpu_range range);
/* Everything before comes before everything behind. */
void gpu_vulkan_full_barrier(VkCommandBuffer commands);

/* gpu_vulkan_upload.c: uploads, read-back. */
void gpu_vulkan_uploads(gpu_vulkan *gpu, VkCommandBuffer commands, const gpu_upload_ready *uploads, uint32_t count);
/* Before commands are recorded that may give images their first layout. */
void gpu_vulkan_rest_begin(gpu_vulkan *gpu);
/* Those commands do not run. */
void gpu_vulkan_rest_undo(gpu_vulkan *gpu);
/* Notes a new image. */
stilb_result gpu_vulkan_rest_add(gpu_vulkan *gpu, gpu_image *image);
/* Images that no upload has written yet get a layout, so that draws may sample them. */
void gpu_vulkan_images_ready(gpu_vulkan *gpu, VkCommandBuffer commands);
stilb_result gpu_vulkan_flush(stilb_gpu *base, const gpu_upload_ready *uploads, uint32_t upload_count);
stilb_result gpu_vulkan_read(stilb_gpu *gpu, const stilb_gpu_plan *plan, uint16_t resource, uint8_t mip, uint16_t layer,
                             gpu_read *read);
stilb_result gpu_vulkan_read_done(stilb_gpu *gpu, const gpu_read *read, bool wait, bool *done);

/* gpu_vulkan_pass.c: the commands of a pass. */
stilb_result gpu_vulkan_plan_pass(gpu_vulkan *gpu, const stilb_gpu_plan *plan, const stilb_gpu_step *step,
                                  const stilb_gpu_draws *lists, const stilb_gpu_threads *threads);
/* Frees what passes have made in a slot. */
void gpu_vulkan_pass_free(gpu_vulkan *gpu, gpu_vulkan_slot *slot);
/* The slot's frame is done: its sets and lists can be used again. */
stilb_result gpu_vulkan_pass_rewind(gpu_vulkan *gpu, gpu_vulkan_slot *slot);

/* gpu_vulkan_copy.c */
void gpu_vulkan_copy(gpu_vulkan *gpu, VkCommandBuffer commands, const stilb_gpu_plan *plan, const stilb_gpu_pass *pass);

#endif
