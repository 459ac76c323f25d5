/* Shared by the files of scene/ and the import process: making and checking what moves. */
#ifndef STILB_SCENE_ANIMATION_INTERNAL_H
#define STILB_SCENE_ANIMATION_INTERNAL_H

#include "scene/scene_animation.h"

/* An array of a struct: where its pointer is, its elements, and the bytes of one. */
typedef struct scene_animation_array {
	void **at;
	uint64_t count;
	size_t size;
} scene_animation_array;

/* Those of a stilb_scene_animation, as its counts have it, without deforms; those of a deform of a mesh. */
#define SCENE_ANIMATION_ARRAYS 9
#define SCENE_DEFORM_ARRAYS 5
void scene_animation_arrays(stilb_scene_animation *animation, scene_animation_array arrays[SCENE_ANIMATION_ARRAYS]);
void scene_deform_arrays(stilb_scene_deform *deform, uint32_t vertex_count,
                         scene_animation_array arrays[SCENE_DEFORM_ARRAYS]);

/* Arrays for these counts, all zeros. STILB_ERROR_MEMORY; *out is NULL then. */
stilb_result scene_animation_create(const stilb_scene_animation *counts, stilb_scene_animation **out);

/* Accepts NULL. */
void scene_animation_finish(stilb_scene_animation *animation);

/* Arrays for the deform's influences and targets, all zeros, in place of its pointers; normals, tangents: also those.
 * STILB_ERROR_MEMORY; all are NULL then. */
stilb_result scene_deform_create(stilb_scene_deform *deform, uint32_t vertex_count, bool normals, bool tangents);
void scene_deform_finish(stilb_scene_deform *deform);

/* 1 + the largest joint that a vertex names; 0: none does. */
uint32_t scene_deform_joints(const stilb_scene_deform *deform, uint32_t vertex_count);

/* True if scene->animation is NULL or as its header says. The scene is sound otherwise. */
bool scene_animation_is_sound(const stilb_scene *scene);

#endif
