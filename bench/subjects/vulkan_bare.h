/*
 * vulkan_bare: the stress test (stilb_scene_create_stress) drawn by a plain Vulkan 1.3 program, with the least work
 * that gives the engine's picture: one pipeline with the engine's shaders; for each of two frames in flight a buffer of
 * rows (each the transform and material of a draw) and one of indirect commands; one multi-draw-indirect; a second
 * pass that tone maps the light; the picture copied to memory. It uses no part of the engine but the scene and the
 * shaders.
 *
 *   bare b = {0};
 *   if (!bare_open(&b))
 *       return BENCH_CHILD_SKIP;
 *   bare_prepare(&b, scene, width, height);
 *   ... record and submit frames with b.frames ...
 *   bare_close(&b);
 *
 * One thread throughout.
 */
#ifndef VULKAN_BARE_H
#define VULKAN_BARE_H

#include "scene/scene.h"

#include <vulkan/vulkan.h>

#define BARE_FRAMES 2

/* Structures that the shaders read (engine/render/shaders/mesh.glsl). */
typedef struct bare_row {
	float transform[12]; /* the rows of the affine transform */
	uint32_t material;
	uint32_t unused[3];
} bare_row;

typedef struct bare_material {
	float diffuse[3], roughness;
	float specular[3], anisotropy;
	float emission[3], wrap, unused[4];
} bare_material;

/* What is read of a view in a buffer. */
typedef struct bare_view {
	float view_projection[16];
	float sky[4], ground[4];
	VkDeviceAddress extras, extra_places; /* not read */
	float time, unused[3];                /* not read */
	float sun[20];                        /* no part of the shaders' view: a light, which stands behind it */
} bare_view;

/* And in constants. */
typedef struct bare_push {
	float camera_position[4];
	float added[4]; /* all 0: nothing added to the materials' colours */
	float turn[2];  /* of a panorama: not read */
	uint32_t light_count;
	float pixels;                                          /* not read */
	VkDeviceAddress lights, maps, panorama, view;          /* lights: of sun; maps, panorama: not read */
	VkDeviceAddress lists;                                 /* not read */
	uint32_t grid[2];                                      /* not read */
	VkDeviceAddress rows, materials, vertices, frame_rows; /* the last two are not read */
} bare_push;

typedef struct bare_buffer {
	VkBuffer buffer;
	VkDeviceMemory memory;
	VkDeviceAddress address;
	void *mapped;
} bare_buffer;

typedef struct bare_image {
	VkImage image;
	VkImageView view;
	VkDeviceMemory memory;
} bare_image;

/* The objects of one frame in flight. */
typedef struct bare_frame {
	VkCommandPool pool;
	VkCommandBuffer commands;
	VkFence done;
	bare_buffer rows, indirect, view, picture;
} bare_frame;

typedef struct bare_mesh {
	uint32_t index_count, first_index;
	int32_t vertex_offset;
} bare_mesh;

/* The pass that makes the picture of the light. */
typedef struct bare_tone {
	VkDescriptorSetLayout set_layout;
	VkDescriptorPool pool;
	VkDescriptorSet set;
	VkPipelineLayout layout;
	VkPipeline pipeline;
	VkSampler sampler;
} bare_tone;

typedef struct bare {
	VkInstance instance;
	VkPhysicalDevice gpu;
	VkDevice device;
	VkQueue queue;
	VkPipelineLayout layout;
	VkPipeline pipeline;
	bare_image light, color, depth; /* light: half floats, linear */
	bare_tone tone;
	bare_buffer vertices, indices, materials;
	bare_mesh *meshes;
	bare_frame frames[BARE_FRAMES];
	uint32_t width, height;
	bool dither; /* of the picture */
} bare;

/* What a pipeline reads of vertices. */
typedef struct bare_vertices {
	uint32_t binding_count, attribute_count;
	const VkVertexInputBindingDescription *bindings;
	const VkVertexInputAttributeDescription *attributes;
} bare_vertices;

/* A pipeline; without `vertices` one triangle over the picture, and no depth. */
typedef struct bare_program {
	const uint32_t *codes[2]; /* SPIR-V: vertex, fragment */
	size_t sizes[2];
	const bare_vertices *vertices;
	VkFormat format;
	VkPipelineLayout layout;
	uint32_t width, height;
} bare_program;

VkPipeline bare_make_pipeline(const bare *b, const bare_program *program);

/* The light exists. */
void bare_tone_make(bare *b, uint32_t width, uint32_t height);
/* Within a rendering into the picture. */
void bare_tone_draw(const bare *b, VkCommandBuffer commands);
void bare_tone_free(bare *b);

/* Ends the program, naming the call, if the result is an error. */
void bare_check(VkResult result, const char *call);

/* Opens lavapipe, Mesa's Vulkan driver that draws on the CPU. False if it is not installed, after a line on stderr;
 * other errors end the program. */
bool bare_open(bare *b);
/* Buffers are mapped; a view is of an image's first mip and layer. */
bare_buffer bare_make_buffer(bare *b, VkDeviceSize size, VkBufferUsageFlags usage);
void bare_free_buffer(bare *b, bare_buffer *buffer);
bare_image bare_make_image(bare *b, uint32_t width, uint32_t height, VkFormat format, VkImageUsageFlags usage,
                           VkImageAspectFlags aspect);
/* Memory of its own for an image. */
VkDeviceMemory bare_image_memory(bare *b, VkImage image);
void bare_free_image(bare *b, bare_image *image);
/* Creates the scene's meshes and materials, targets of this size in pixels, the pipeline and the frames. */
void bare_prepare(bare *b, const stilb_scene *scene, uint32_t width, uint32_t height);
/* A frame: bare_frame_wait, then write what it reads; bare_frame_begin, whose rendering begins with the radiance `sky`;
 * draws; bare_frame_end, which tone maps, copies the picture into frame->picture and submits. */
void bare_frame_wait(const bare *b, const bare_frame *frame);
void bare_frame_begin(const bare *b, const bare_frame *frame, const float sky[3]);
void bare_frame_end(const bare *b, const bare_frame *frame);
/* Waits for the device and destroys everything. */
void bare_close(bare *b);

#endif
