/*
 * scene_build: makes a scene of a program's own meshes, textures, materials, models and lights.
 *
 * Life cycle.  stilb_scene_build_begin -> stilb_scene_build_mesh, ... -> stilb_scene_build_end, which returns the scene
 *              and ends the build. Everything that is passed in is copied.
 * Ids.         Functions return the id of what they add: 0, 1, 2, ... for each kind. What another function names by id
 *              must have been added before.
 * Mistakes.    The first one is kept, in words that name what was added and what is wrong with it. From then on all
 *              functions do nothing and return 0, and stilb_scene_build_end returns the error: one check is enough.
 * Threads.     [one-writer] for each build.
 * Example.     A red sphere over a floor, in a white light from above:
 *
 *   static const float red[3] = {0.6f, 0.1f, 0.1f}, grey[3] = {0.5f, 0.5f, 0.5f}, dark[3] = {0.04f, 0.04f, 0.04f};
 *   stilb_scene_material paint = stilb_scene_material_make(red, dark, 0.3f);
 *   stilb_scene_material stone = stilb_scene_material_make(grey, dark, 0.8f);
 *   stilb_mat4 up = stilb_mat4_scale_translate(1.0f, 0.0f, 1.0f, 0.0f);
 *   stilb_mat4 wide = stilb_mat4_scale_translate(10.0f, 0.0f, 0.0f, 0.0f);
 *   stilb_scene_build *build = stilb_scene_build_begin();
 *   uint32_t ball = stilb_scene_build_mesh(build, &sphere), floor = stilb_scene_build_mesh(build, &plane);
 *   stilb_scene_build_part parts[] = {{ball, stilb_scene_build_material(build, &paint)},
 *                                     {floor, stilb_scene_build_material(build, &stone)}};
 *   stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &up), &parts[0], 1);
 *   stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &wide), &parts[1], 1);
 *   stilb_scene_build_light(build, &(stilb_scene_light){.kind = STILB_SCENE_LIGHT_DIRECTIONAL,
 *                                                       .direction = {0, -1, 0},
 *                                                       .intensity = {3, 3, 3}});
 *   stilb_scene *scene;
 *   stilb_result result = stilb_scene_build_end(build, &scene);
 */
#ifndef STILB_SCENE_BUILD_H
#define STILB_SCENE_BUILD_H

#include "scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

typedef struct stilb_scene_build stilb_scene_build;

/* NULL if there is no memory, which all functions accept: stilb_scene_build_end then returns STILB_ERROR_MEMORY.
 * [any-thread] */
stilb_scene_build *stilb_scene_build_begin(void);

/* Adds a mesh: triangles of at least one vertex, each index below vertex_count. Positions are finite and within 1e18 m;
 * normals are unit, to 1 %; uv are finite. Tangents are unit with a fourth number of 1 or -1, or all 0; colours of
 * vertices are within 0..65504. Levels, if there are any, are as stilb_scene_level says, at most
 * STILB_SCENE_MAX_LEVELS. */
uint32_t stilb_scene_build_mesh(stilb_scene_build *build, const stilb_scene_mesh *mesh);

/* Adds a texture: 1..16384 pixels a side, 1..4 channels, any stilb_image_format, with its mip levels. */
uint32_t stilb_scene_build_texture(stilb_scene_build *build, const stilb_image *image);

/* Adds a function of surfaces, with which stilb_scene_function_mistake finds nothing wrong. */
uint32_t stilb_scene_build_function(stilb_scene_build *build, const stilb_scene_function *function);

/* Adds a surface, with which stilb_scene_surface_mistake finds nothing wrong and whose textures and function were
 * added. */
uint32_t stilb_scene_build_surface(stilb_scene_build *build, const stilb_scene_surface *surface);

/* Adds a material, each member in the range that stilb_scene_material says, diffuse + specular at most 1 a channel
 * (stilb_scene_material_make). diffuse_texture is 1 + the id of a texture, or 0, and surface 1 + the id of a surface,
 * or 0, not both. */
uint32_t stilb_scene_build_material(stilb_scene_build *build, const stilb_scene_material *material);

/* Adds a node: a place in its parent's space, or in the world's if parent is STILB_SCENE_NO_PARENT. local: node to
 * parent, affine (its last row is 0 0 0 1) and finite. */
#define STILB_SCENE_NO_PARENT UINT32_MAX
uint32_t stilb_scene_build_node(stilb_scene_build *build, uint32_t parent, const stilb_mat4 *local);

/* The same by a pose: numbers within 1e18, the rotation unit to 1 %. */
uint32_t stilb_scene_build_pose(stilb_scene_build *build, uint32_t parent, const stilb_scene_pose *pose);

/* Names a node; cut to 63 bytes. */
void stilb_scene_build_name(stilb_scene_build *build, uint32_t node, const char *name);

/* The pieces of a model, by id. */
typedef struct stilb_scene_build_part {
	uint32_t mesh, material;
} stilb_scene_build_part;

/* Adds a model, which is culled as a whole: part_count >= 1 parts in the space of the node, on which it hangs: who
 * moves the node later moves the model (scene_node.h). Its bounds are computed. At
 * most STILB_SCENE_MAX_MODELS. */
uint32_t stilb_scene_build_model(stilb_scene_build *build, uint32_t node, const stilb_scene_build_part *parts,
                                 uint32_t part_count);

/* Gives a model its flags, STILB_SCENE_MODEL_..., in place of those it had: none at first. */
void stilb_scene_build_model_flags(stilb_scene_build *build, uint32_t model, uint32_t flags);

/* Adds a light of any kind, with which stilb_scene_light_mistake finds nothing wrong. face: 1 + the number of a part,
 * counted over all models so far, or 0. */
uint32_t stilb_scene_build_light(stilb_scene_build *build, const stilb_scene_light *light);

/* The same for a light that hangs on a node, and is in its space: who moves the node later moves the light
 * (scene_node.h). */
uint32_t stilb_scene_build_light_on(stilb_scene_build *build, uint32_t node, const stilb_scene_light *light);

/* Sets the surroundings: radiances finite and >= 0; a finite rotation; a panorama of 3 channels in F32_LINEAR, or
 * none. Without this call
 * they are black. */
void stilb_scene_build_surroundings(stilb_scene_build *build, const stilb_scene_surroundings *surroundings);

/* Sets the camera, whose members are in the ranges that stilb_scene_camera says. Without this call it is one that sees
 * the whole scene from the front, a little from above. */
void stilb_scene_build_camera(stilb_scene_build *build, const stilb_scene_camera *camera);

/* Adds to scene->cameras one that hangs on a node, and is in its space; STILB_SCENE_NO_PARENT: it hangs on none. The
 * name is cut to 63 bytes. */
uint32_t stilb_scene_build_named_camera(stilb_scene_build *build, const char *name, uint32_t node,
                                        const stilb_scene_camera *camera);

/* Makes the scene, and frees the build in any case. STILB_ERROR_ARGUMENT: the first mistake. STILB_ERROR_MEMORY.
 * *scene is NULL then. */
stilb_result stilb_scene_build_end(stilb_scene_build *build, stilb_scene **scene);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
