/*
 * textured_bare: a scene of one model with one part, whose material has five maps, under a panorama, drawn by a plain
 * Vulkan program: one draw, one descriptor set, shaders that do this material and nothing else (textured.frag). Of the
 * engine it uses the scene, the makers of mips and of a panorama's table and cube, and the shading headers; its device
 * and frames are those of vulkan_bare.h.
 *
 *   static textured_bare b;
 *   if (!textured_bare_open(&b, scene, TEXTURED_STRAIGHT))
 *       return BENCH_CHILD_SKIP;
 *   textured_bare_frame(&b);
 *   textured_bare_picture(&b, &image);
 *   textured_bare_close(&b);
 *
 * One thread throughout.
 */
#ifndef TEXTURED_BARE_H
#define TEXTURED_BARE_H

#include "bench/subjects/vulkan_bare.h"
#include "bench/textured/textured_cases.h"

#define TEXTURED_MAPS 5u
#define TEXTURED_IMAGES 8u /* and cube, table of gloss, irradiance */

#define TEXTURED_ENUM(ID, ...) TEXTURED_##ID,
typedef enum textured_variant { TEXTURED_VARIANTS(TEXTURED_ENUM) TEXTURED_COUNT } textured_variant;
#undef TEXTURED_ENUM

/* Constants of both shaders (textured.glsl). */
typedef struct textured_push {
	float view_projection[16], transform[3][4], camera[4];
} textured_push;

/* The uniform buffer of both. */
typedef struct textured_material {
	float color[4], specular[3], roughness, emission[3], metalness, normal_scale, occlusion, unused[2];
	float turn[2];
	VkDeviceAddress table, record, extras, view, rest;
} textured_material;

typedef struct textured_bare {
	bare bare;
	const stilb_scene *scene;
	textured_push push;
	bare_image images[TEXTURED_IMAGES];
	bare_buffer extras, packed; /* as the scene has them, as the engine's shaders do */
	bare_buffer table, material, view;
	VkSampler samplers[2]; /* clamped, repeated */
	VkDescriptorSetLayout set_layout;
	VkDescriptorPool pool;
	VkDescriptorSet set;
	VkPipelineLayout layout;
	VkPipeline pipeline;
	uint32_t frames; /* drawn so far */
} textured_bare;

/* False if there is no lavapipe, after a line on stderr; other errors end the program. The scene stays as it is until
 * textured_bare_close. */
bool textured_bare_open(textured_bare *b, const stilb_scene *scene, textured_variant variant);
void textured_bare_frame(textured_bare *b);
/* The last frame's picture. */
void textured_bare_picture(textured_bare *b, stilb_image *image);
void textured_bare_close(textured_bare *b);

/* textured_bare_images.c: fills images and table. */
void textured_bare_make_images(textured_bare *b, bool arrays);

#endif
