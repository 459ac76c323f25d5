/*
 * vulkan_bare: the stress test drawn by a plain Vulkan 1.3 program, the least that gives the engine's picture.
 *
 * One pipeline with the engine's shaders, one buffer of rows and one of indirect commands a frame, two frames in
 * flight, one multi-draw-indirect, the picture copied to memory. No lists, no jobs, no engine.
 */
#ifndef VULKAN_BARE_H
#define VULKAN_BARE_H

#include "scene/scene.h"

#include <vulkan/vulkan.h>

#define BARE_FRAMES 2

/* As the shaders read them (engine/render/shaders/mesh.glsl). */
typedef struct bare_row {
	float transform[12]; /* the rows of the affine transform */
	uint32_t material;
	uint32_t unused[3];
} bare_row;

typedef struct bare_material {
	float diffuse[3], roughness;
	float specular[3], anisotropy;
	float wrap, unused[3];
} bare_material;

typedef struct bare_view {
	float view_projection[16];
	float camera_position[4], sun_direction[4], sun_irradiance[4], sky[4], ground[4];
	float lamp[12], added[4]; /* zero: the shader's own choice is the sun, and nothing is added to materials */
} bare_view;

typedef struct bare_push {
	VkDeviceAddress view, rows, materials;
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

/* What one frame in flight owns. */
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

typedef struct bare {
	VkInstance instance;
	VkPhysicalDevice gpu;
	VkDevice device;
	VkQueue queue;
	VkPipelineLayout layout;
	VkPipeline pipeline;
	bare_image color, depth;
	bare_buffer vertices, indices, materials;
	bare_mesh *meshes;
	bare_frame frames[BARE_FRAMES];
} bare;

/* Ends the program when a call failed. */
void bare_check(VkResult result, const char *call);

/* False: there is no lavapipe here, and stderr says why. Whatever else goes wrong ends the program. */
bool bare_open(bare *b);
/* All that the scene needs: its meshes and materials, targets of this size, the pipeline, the frames. */
void bare_prepare(bare *b, const stilb_scene *scene, uint32_t width, uint32_t height);
void bare_close(bare *b);

#endif
