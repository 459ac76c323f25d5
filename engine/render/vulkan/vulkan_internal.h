/*
 * Scenes on the Vulkan device of engine/gpu: what a frame's slot holds for them, the images that they are drawn into,
 * heaps, textures, pipelines, draws. All frames share one picture: they follow each other on one queue, and barriers
 * order them.
 * Shaders get buffer addresses in a push constant. Descriptor sets are used for textures (set 0), which have no
 * address, and for materials that are bound one by one (set 1, --materials bind).
 */
#ifndef STILB_VULKAN_INTERNAL_H
#define STILB_VULKAN_INTERNAL_H

#include "gpu/vulkan/gpu_vulkan_internal.h"
#include "render/render_internal.h"
#include "shading/shade_tonemap.h"

#define VULKAN_MAX_LISTS (STILB_JOB_MAX_WORKERS + 1)

/* A view as the shaders read it (shaders/mesh.glsl). */
typedef struct vulkan_view {
	float view_projection[16];
	float camera_position[4];
	float sky[4];
	float ground[4];
	float added[4]; /* added to every material's roughness, anisotropy, wrap and specular */
	VkDeviceAddress lights;
	uint32_t light_count;
	float unused;
	VkDeviceAddress panorama; /* of device.panorama: its table */
	float turn[2];            /* sine and cosine of its rotation */
} vulkan_view;

static_assert(sizeof(vulkan_view) == 160, "std430");

/* Push constants of scene passes (shaders/mesh.glsl). */
typedef struct vulkan_push {
	VkDeviceAddress view, rows, materials, vertices, frame_rows;
} vulkan_push;

/* Push constants of 2D passes (shaders/flat.vert). */
typedef struct vulkan_push_2d {
	float scale[2]; /* pixels to clip space */
	VkDeviceAddress rows;
} vulkan_push_2d;

static_assert(sizeof(vulkan_push_2d) <= sizeof(vulkan_push), "one pipeline layout serves both");

typedef struct vulkan_rows {
	render_rows base;
	gpu_vulkan_buffer buffer;
} vulkan_rows;

/* Push constants of shaders/resolve.frag and tone.frag. */
typedef struct vulkan_tone_push {
	float exposure;  /* factor of radiance */
	uint32_t dither; /* 0, 1 */
} vulkan_tone_push;

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

/* What a frame's slot has besides its command buffers. */
typedef struct vulkan_slot {
	gpu_vulkan_slot *gpu;
	vulkan_list *lists; /* [list_count] one for each part that a pass is cut into; secondary replay alone */
	uint32_t list_count;
	gpu_vulkan_buffer memory[RENDER_MEMORY_KINDS];
	gpu_vulkan_buffer staging; /* the source of update's copies */
	VkDeviceSize staging_used; /* bytes of it that the slot's frame copies */
	gpu_vulkan_buffer
		*outgrown; /* [outgrown_count] replaced in this slot's frame, and still read by it or the one before */
	uint32_t outgrown_count, outgrown_capacity;
	VkDescriptorSet material_set; /* --materials bind: a set with the buffer of materials */
	VkBuffer material_buffer;     /* the buffer that material_set refers to */
	gpu_vulkan_buffer backdrop;   /* what shaders/backdrop.frag reads; {0}: not needed so far */
	gpu_vulkan_buffer views;      /* vulkan_view[STILB_RENDER_MAX_PASSES] */
	gpu_vulkan_buffer picture;    /* the picture in memory, if there is no window */
	bool picture_valid;           /* `picture` holds the slot's frame */
} vulkan_slot;

/* Made and destroyed with the lock of render_resources held. Replay reads `set` without it: a texture that a frame uses
 * exists until the frame is done. */
typedef struct vulkan_texture {
	gpu_vulkan_image image;
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

/* The mesh pipelines of one choice of formulas, by render_state_detail. */
typedef struct vulkan_shading {
	uint32_t formulas[VULKAN_FORMULAS];
	gpu_vulkan_pipeline pipelines[RENDER_DETAIL_KINDS][VULKAN_SURFACES][VULKAN_PIPELINE_MATERIALS];
} vulkan_shading;

#define VULKAN_LIGHT_FORMAT VK_FORMAT_R16G16B16A16_SFLOAT

/* What makes the picture of the frame's light. */
typedef struct vulkan_tone {
	VkDescriptorPool pool;
	VkDescriptorSetLayout layout;
	VkPipelineLayout pipeline_layout;
	VkDescriptorSet light, samples; /* of the images with these names; samples is null with one a pixel */
	gpu_vulkan_pipeline resolve, tones[SHADE_TONE_COUNT];
	vulkan_tone_push push; /* of this frame: that of its first scene pass */
	uint32_t curve;        /* SHADE_TONE_... of this frame */
	bool wanted;           /* a scene pass has drawn light of which no picture has been made */
	bool lit;              /* the last frame had one */
} vulkan_tone;

typedef struct vulkan_device {
	render_device base;

	gpu_vulkan *gpu;

	VkSampler sampler; /* for all textures: linear, repeated, no mip levels */
	VkDescriptorSetLayout texture_layout, material_layout;
	VkDescriptorPool texture_pool, material_pool;
	vulkan_texture *textures; /* [STILB_RENDER_MAX_TEXTURES] */
	VkPipelineLayout pipeline_layout;
	VkShaderModule mesh_modules[VULKAN_SURFACES][2]; /* by stage, kept for pipelines that later frames need */
	vulkan_shading **shadings; /* [shading_count] every choice of formulas that a pass has used or will */
	uint32_t shading_count, shading_capacity;
	const vulkan_shading *shading; /* of the pass that is being replayed; secondary lists read it on other threads */
	VkPipeline pipelines_2d[VULKAN_PIPELINES_2D];
	gpu_vulkan_pipeline backdrop;
	gpu_vulkan_buffer panorama, next_panorama; /* RENDER_PANORAMA_BYTES: shown, and being made; {0}: none */
	bool transparent;                          /* the frame's backdrop is nothing, and the picture's alpha counts */
	stilb_render_output output;
	/* Scene passes draw into `light` or its samples; from there vulkan_tone makes the picture, over which 2D passes
	 * draw. */
	gpu_vulkan_image light;         /* linear radiance, VULKAN_LIGHT_FORMAT, one sample a pixel */
	gpu_vulkan_image light_samples; /* with 4 samples a pixel, resolved into light; null with 1 */
	gpu_vulkan_image depth;
	VkFormat color_format;
	gpu_vulkan_image color; /* the picture, one sample a pixel */
	vulkan_tone tone;
	bool drawn; /* color holds a submitted picture, in the layout TRANSFER_SRC_OPTIMAL */

	gpu_vulkan_buffer heaps[RENDER_HEAPS];
	bool packed;          /* vertices are: stilb_render_desc.float_vertices */
	render_layout layout; /* of vertices */

	vulkan_slot slots[STILB_GPU_FRAMES];
	VkDeviceAddress rows; /* of the scene; in the pass that is being made */
	uint32_t pass;        /* number of the current frame's passes so far that had draws */
} vulkan_device;

/* The slot of the current frame. */
static inline vulkan_slot *vulkan_slot_now(vulkan_device *device)
{
	return &device->slots[device->gpu->slot];
}

/* vulkan_heaps.c: the heaps of render_resources on the GPU. */
stilb_result vulkan_update(render_device *base, const render_resources *resources);
/* Stores `with` in *buffer, and destroys the old buffer when no frame can read it any more. On STILB_ERROR_MEMORY
 * *buffer is as before and `with` is destroyed. */
stilb_result vulkan_buffer_replace(vulkan_device *device, gpu_vulkan_buffer *buffer, gpu_vulkan_buffer with);
/* Destroys *buffer, which may be {0}, when no frame can read it any more, and leaves {0}. STILB_ERROR_MEMORY: *buffer
 * is as before. */
stilb_result vulkan_buffer_retire(vulkan_device *device, gpu_vulkan_buffer *buffer);
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

/* gpu_vulkan_pipeline.c: shaders, layouts, pipelines. */
stilb_result vulkan_pipeline_create(vulkan_device *device);
void vulkan_pipeline_destroy(vulkan_device *device);
/* Makes the pipelines that a scene pass needs, unless an earlier pass has, and stores them as device->shading. */
stilb_result vulkan_pipeline_choose(vulkan_device *device, const render_stream *stream);
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
stilb_result vulkan_rows_make(render_device *base, uint32_t capacity, render_rows **rows);
void vulkan_rows_free(render_device *base, render_rows *rows);
void *vulkan_panorama_make(render_device *base, size_t bytes);
void vulkan_panorama_show(render_device *base);
/* vulkan_pass.c: the commands of one pass. */
stilb_result vulkan_pass(render_device *base, const render_stream *stream);

/* vulkan_backdrop.c: what is seen where no model is. */

/* True if what is seen is more than the colour that the picture is cleared to. */
bool vulkan_backdrop_is_drawn(const render_stream *stream);
/* The radiance that the picture is cleared to: of the backdrop, or of the sky or the ground; black without a view. */
VkClearColorValue vulkan_backdrop_clear(const stilb_render_view *view);
/* Makes the pipeline that draws backdrops. [any-thread] */
stilb_result vulkan_backdrop_make(vulkan_device *device);
/* Makes what is missing to draw the backdrop of the stream's view and writes it to the slot's memory. */
stilb_result vulkan_backdrop_prepare(vulkan_device *device, vulkan_slot *slot, const render_stream *stream);
/* Draws it, after vulkan_screen_area. */
void vulkan_backdrop_draw(const vulkan_device *device, const vulkan_slot *slot);
void vulkan_backdrop_destroy(vulkan_device *device);

/* vulkan_screen.c: what covers the whole picture. */

/* Sets viewport and scissor to the whole picture: every command buffer needs it, secondary ones inherit nothing. */
void vulkan_screen_area(const vulkan_device *device, VkCommandBuffer commands);

/* A pipeline of one triangle over the picture, which shaders/screen.vert makes. */
typedef struct vulkan_screen {
	const uint32_t *vertex, *fragment; /* SPIR-V */
	size_t vertex_bytes, fragment_bytes;
	uint32_t constants[2]; /* specialization constants 0 and 1 of the fragment shader */
	VkFormat format;
	VkFormat depth; /* of the depth image beside it, which it does not touch; VK_FORMAT_UNDEFINED: there is none */
	uint32_t samples;
	VkPipelineLayout layout;
} vulkan_screen;

VkResult vulkan_screen_make(const vulkan_device *device, const vulkan_screen *screen, VkPipeline *pipeline);

/* vulkan_tone.c: from the light that scene passes have drawn to the picture. */

stilb_result vulkan_tone_create(vulkan_device *device);
void vulkan_tone_destroy(vulkan_device *device);
/* Makes the pipelines of a tone map, SHADE_TONE_.... [any-thread] */
stilb_result vulkan_tone_make(vulkan_device *device, uint32_t curve);
/* To be called when the targets were made anew. */
void vulkan_tone_targets(vulkan_device *device);
/* Takes exposure and tone map of the frame's first scene pass, whose pipelines it makes. */
stilb_result vulkan_tone_begin(vulkan_device *device, const stilb_render_view *view);
/* Makes the picture, which is then ready to be drawn over. Nothing if it has been made, or there was no scene pass. */
void vulkan_tone_pass(vulkan_device *device, VkCommandBuffer commands);
stilb_result vulkan_read_light(render_device *base, stilb_image *image);

/* vulkan_draws.c: the draws of a stream and their bindings. */

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
stilb_result vulkan_present(render_device *base);
stilb_result vulkan_set_surface(render_device *base, const stilb_gpu_surface *surface);
stilb_result vulkan_read_image(render_device *base, stilb_image *image);

#endif
