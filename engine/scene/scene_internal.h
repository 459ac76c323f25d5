/* Shared by the files of scene/ and by the import process: making scenes and meshes. */
#ifndef STILB_SCENE_INTERNAL_H
#define STILB_SCENE_INTERNAL_H

#include "scene/scene.h"

/* A scene with arrays for these counts, all values zero, without textures and lights. model_count is at most
 * STILB_SCENE_MAX_MODELS. STILB_ERROR_MEMORY; *scene is NULL then. */
stilb_result scene_create(uint32_t model_count, uint32_t part_count, uint32_t mesh_count, uint32_t material_count,
                          stilb_scene **scene);

/* Arrays for textures, surfaces, cameras and lights in a scene that has none yet, all zeros. STILB_ERROR_MEMORY. */
stilb_result scene_add_textures(stilb_scene *scene, uint32_t count);
stilb_result scene_add_surfaces(stilb_scene *scene, uint32_t count);
stilb_result scene_add_functions(stilb_scene *scene, uint32_t count);
stilb_result scene_add_cameras(stilb_scene *scene, uint32_t count);

/* Room for the names of the scene's models and materials, all "", unless they are more than SCENE_NAMES: it has none
 * then. STILB_ERROR_MEMORY. */
#define SCENE_NAMES 65536u
stilb_result scene_add_names(stilb_scene *scene);

stilb_result scene_add_lights(stilb_scene *scene, uint32_t count);
/* HSV to RGB: hue and saturation in [0, 1], value any, as a clamped ramp for each channel. */
void scene_stress_color(float hue, float saturation, float value, float rgb[3]);

/* scene_variant.c: room for so many variants, all names "" and all materials 0. STILB_ERROR_MEMORY. */
stilb_result scene_add_variants(stilb_scene *scene, uint32_t count);

/* scene_impostor.c: the model has none any more, since its parts have changed. */
void scene_impostor_forget(stilb_scene *scene, uint32_t model);

/* Accepts NULL. */
void scene_variants_finish(struct stilb_scene_variants *variants);

/* True if the names end and the materials exist. */
bool scene_variants_are_sound(const stilb_scene *scene);

/* Arrays for nodes in a scene that has none yet, all values zero: who fills them gives each a parent, pose, local and
 * to_world. STILB_ERROR_MEMORY. */
stilb_result scene_add_nodes(stilb_scene *scene, uint32_t count);

/* Gives a model its flags, STILB_SCENE_MODEL_..., and tells nobody. */
void scene_set_model_flags(stilb_scene *scene, uint32_t model, uint32_t flags);

/* Rooms for what hangs on nodes of lights and cameras, of those that there are now, all on none. Does nothing if it is
 * there. STILB_ERROR_MEMORY. */
stilb_result scene_add_mounts(stilb_scene_mount **mounts, uint32_t count);

/* scene_mount.c: how a light or a camera stands in a space in which it is what it says. node: 1 + a node. */
stilb_scene_mount scene_mount_of_light(const stilb_scene_light *light, uint32_t node);
stilb_scene_mount scene_mount_of_camera(const stilb_scene_camera *camera, uint32_t node);

/* Puts a light or a camera where its node's place, affine, has it. False: it would be out of its ranges there; then it
 * is as it was. [any-thread] */
bool scene_mount_light(const stilb_scene_mount *mount, const stilb_mat4 *to_world, stilb_scene_light *light);
bool scene_mount_camera(const stilb_scene_mount *mount, const stilb_mat4 *to_world, stilb_scene_camera *camera);

/* True if each node stands after its parent, with finite places, and models, lights and cameras hang on nodes that
 * exist. Not for scenes that were edited. */
bool scene_nodes_are_sound(const stilb_scene *scene);

/* True if every index is in range: meshes' triangles, models' parts, parts' meshes and materials, materials' surfaces
 * and textures; and if no surface has a mistake. Walks the whole scene: for scenes that came from the import process,
 * and for STILB_CHECK when one has been made. */
bool scene_is_sound(const stilb_scene *scene);

/* True if the mesh and its levels hold whole triangles whose vertices exist. */
bool scene_mesh_is_sound(const stilb_scene_mesh *mesh);

/* Sets the bounds of a model from the vertices of its parts: a sphere around the centre of their box. Vertices that are
 * NaN or beyond 1e18 m in the world are left out. */
void scene_fit_bounds(stilb_scene *scene, uint32_t model);

/* True if all parts together have more than SCENE_PLACED_OFTEN vertices or indices, a mesh counted as often as it is
 * placed: to walk them would take seconds. A file of a kilobyte can place a mesh 70,000 times. */
#define SCENE_PLACED_OFTEN (1u << 27)
bool scene_is_placed_often(const stilb_scene *scene);

/* scene_fit_bounds for all models. If scene_is_placed_often, the corners of the meshes' boxes stand for their vertices:
 * bounds are larger then, of a similarity up to sqrt(3) times. */
void scene_fit_all_bounds(stilb_scene *scene);

/* scene_studio.c: false if nothing lights the scene: no light, no surroundings, and its emission gives its surfaces
 * less than a hundredth of the studio's light, on average and as if nothing were in between. */
bool scene_is_lit(const stilb_scene *scene);

/* scene_backdrop.c: frees map and floor, and leaves {0}. */
void scene_backdrop_finish(stilb_scene_backdrop *backdrop);

/* scene_backdrop.c: fills in the floor below the models, whose sphere this is. False: no memory. */
bool scene_floor_cover(const stilb_scene *scene, const stilb_sphere *sphere, stilb_scene_floor *floor);

/* scene_meter.c: the mean radiance of a panorama above and below its horizon. False: no memory. */
bool scene_panorama_halves(const stilb_image *panorama, float above[3], float below[3]);

/* A sphere around all models' bounds, about the centre of their box; radius 0 if there are no models. */
stilb_sphere scene_sphere(const stilb_scene *scene);

/* An upright camera at position that looks along the vector view. Its length (> 0, metres) is the distance of what the
 * picture is of: near and far planes are 1/1000 and 1000 times as far. fov_y in (0, pi) radians. */
stilb_scene_camera scene_camera_along(stilb_vec3 position, stilb_vec3 view, float fov_y);

/* scene_camera_along, looking from position to target, which differs from it. */
stilb_scene_camera scene_camera_look(stilb_vec3 position, stilb_vec3 target, float fov_y);

/* A mesh with arrays for these counts, not initialised, and without levels; index_count is a multiple of 3.
 * STILB_ERROR_MEMORY; mesh is {0} then. */
stilb_result scene_mesh_create(stilb_scene_mesh *mesh, uint32_t vertex_count, uint32_t index_count);

/* Extras in a mesh that has none yet, without tangents, of white. After STILB_ERROR_MEMORY stilb_scene_mesh_finish
 * frees what was made. */
stilb_result scene_mesh_add_extras(stilb_scene_mesh *mesh);

/* Arrays for level_count > 0 levels in a mesh that has none yet, not initialised, and morph of zeros if asked for.
 * After STILB_ERROR_MEMORY stilb_scene_mesh_finish frees what was made. */
stilb_result scene_mesh_add_levels(stilb_scene_mesh *mesh, uint32_t level_count, uint32_t level_index_count,
                                   bool morph);

/* Arrays for clusters in a mesh that has none yet, not initialised; cluster_count and group_count > 0. After
 * STILB_ERROR_MEMORY stilb_scene_mesh_finish frees what was made. */
stilb_result scene_mesh_add_clusters(stilb_scene_mesh *mesh, uint32_t cluster_count, uint32_t group_count,
                                     uint32_t cluster_index_count);

#endif
