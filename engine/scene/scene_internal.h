/* What the files of scene/ share. */
#ifndef STILB_SCENE_INTERNAL_H
#define STILB_SCENE_INTERNAL_H

#include "scene/scene.h"

/* A scene with room for these counts, everything zero: no textures, no lights. */
stilb_result scene_create(uint32_t model_count, uint32_t part_count, uint32_t mesh_count, uint32_t material_count,
                          stilb_scene **scene);

/* Room for textures and lights in a scene that has none yet, everything zero. */
stilb_result scene_add_textures(stilb_scene *scene, uint32_t count);
stilb_result scene_add_lights(stilb_scene *scene, uint32_t count);

/* Bounds of a model from the vertices of its parts: the sphere about the middle of their box. Vertices that are no
 * numbers are left out. */
void scene_fit_bounds(stilb_scene *scene, uint32_t model);

/* The sphere about the middle of the box around all models; radius 0 when there are none. */
stilb_sphere scene_sphere(const stilb_scene *scene);

/* At position, looking at target, upright; near and far planes 1/1000 and 1000 times their distance. */
stilb_scene_camera scene_camera_look(stilb_vec3 position, stilb_vec3 target, float fov_y);

/* Contents are not set. STILB_ERROR_MEMORY: mesh is {0}. */
stilb_result scene_mesh_create(stilb_scene_mesh *mesh, uint32_t vertex_count, uint32_t index_count);

#endif
