/*
 * scene_edit: changes a scene between frames: models come, go, move and hide; meshes, materials and textures come, go
 * and change. What an engine shows of the scene is brought up to date in its next frame, at the cost of what has
 * changed.
 *
 * Ids.         stay what they are until the thing is removed; the id may then be given to a new one. Models and
 *              resources of a scene that was opened or built can be edited like those that were added here. A mesh or
 *              material is removed after the models that name it, a surface after the materials, a texture after
 *              both, a function after the surfaces.
 * Arrays.      A model that is hidden or removed has a NaN as the radius of its bounds, so that no view sees it; the
 *              parts of a removed model name STILB_SCENE_NONE. A removed mesh, material, surface, function or texture
 *              is all zeros. The arrays may move: no pointer into them outlives an edit.
 * Bounds       follow the edits: those of a model that was added or moved enclose the spheres around its meshes.
 * Mistakes.    STILB_ERROR_ARGUMENT with a line that names what is wrong, or STILB_ERROR_MEMORY: then the scene is as
 *              it was.
 * Not here.    Surroundings and camera are plain members of the scene, which frames read anew: assign them.
 * Threads.     [one-writer] for each scene, and nobody reads it meanwhile: between frames, or in
 *              stilb_engine_desc.update.
 * Readers.     stilb_scene_changes_read tells what has changed since stilb_scene_changes_clear; one reader, the engine
 *              that shows the scene, calls both in each frame.
 * Example.     A model that appears, moves in each frame, and goes:
 *
 *   uint32_t model;
 *   stilb_mat4 place = stilb_mat4_scale_translate(1.0f, 0.0f, 2.0f, 0.0f);
 *   stilb_scene_build_part part = {ball, paint};
 *   stilb_result result = stilb_scene_add_model(scene, &place, &part, 1, &model);
 *   for (int frame = 0; frame < 60 && result == STILB_OK; frame++) {
 *       place.m[13] -= 0.01f;
 *       result = stilb_scene_set_transform(scene, model, &place);
 *       if (result == STILB_OK)
 *           result = stilb_engine_frame(engine, &report);
 *   }
 *   if (result == STILB_OK)
 *       result = stilb_scene_remove_model(scene, model);
 */
#ifndef STILB_SCENE_EDIT_H
#define STILB_SCENE_EDIT_H

#include "scene/scene.h"
#include "scene/scene_build.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* ---- models ------------------------------------------------------------------------------------------------------ */

/* Adds a model of part_count >= 1 parts, all at transform (model to world, affine, within 1e18 m). *id is that of a
 * removed model with as many parts, else a new one; at most STILB_SCENE_MAX_MODELS. */
stilb_result stilb_scene_add_model(stilb_scene *scene, const stilb_mat4 *transform, const stilb_scene_build_part *parts,
                                   uint32_t part_count, uint32_t *id);

/* A light whose face was a part of the model has none from then on. */
stilb_result stilb_scene_remove_model(stilb_scene *scene, uint32_t id);

/* Moves all parts of a model to this transform. */
stilb_result stilb_scene_set_transform(stilb_scene *scene, uint32_t id, const stilb_mat4 *transform);

/* Moves the parts of a model, each to a transform of its own: transforms has one for each, in their order. */
stilb_result stilb_scene_set_part_transforms(stilb_scene *scene, uint32_t id, const stilb_mat4 *transforms);

/* Gives a part of a model, counted from 0 within it, another mesh and material. */
stilb_result stilb_scene_set_part(stilb_scene *scene, uint32_t id, uint32_t part, stilb_scene_build_part with);

/* Shows or hides a model. It may be moved while it is hidden. */
stilb_result stilb_scene_show_model(stilb_scene *scene, uint32_t id, bool shown);

/* Gives a model its flags, STILB_SCENE_MODEL_..., in place of those it had; one that is added has none. Frames follow
 * at no cost; stilb_gi_scene_update builds all of its tree anew. */
stilb_result stilb_scene_set_model_flags(stilb_scene *scene, uint32_t id, uint32_t flags);

/* ---- meshes, materials, textures ---------------------------------------------------------------------------------
 * What is passed in is copied, and must be what scene_build.h says of its like. */

stilb_result stilb_scene_add_mesh(stilb_scene *scene, const stilb_scene_mesh *mesh, uint32_t *id);

/* Replaces a mesh by one of any size. */
stilb_result stilb_scene_set_mesh(stilb_scene *scene, uint32_t id, const stilb_scene_mesh *mesh);

/* Replaces vertices first .. first + count - 1 of a mesh. Only they go to the device: frames that are still drawn keep
 * the ones they had. Bounds of the models that show the mesh follow when the scene is read
 * (stilb_scene_changes_read). Its extras stay. The mesh loses its levels, whose errors hold no longer; if it has some,
 * all of it goes to the device this once. */
stilb_result stilb_scene_set_vertices(stilb_scene *scene, uint32_t id, uint32_t first, uint32_t count,
                                      const stilb_scene_vertex *vertices);

/* STILB_ERROR_ARGUMENT also if a part names it. */
stilb_result stilb_scene_remove_mesh(stilb_scene *scene, uint32_t id);

stilb_result stilb_scene_add_material(stilb_scene *scene, const stilb_scene_material *material, uint32_t *id);
stilb_result stilb_scene_set_material(stilb_scene *scene, uint32_t id, const stilb_scene_material *material);

/* STILB_ERROR_ARGUMENT also if a part names it. */
stilb_result stilb_scene_remove_material(stilb_scene *scene, uint32_t id);

/* What materials name as their surface. The materials that name one which is replaced are listed as changed. */
stilb_result stilb_scene_add_surface(stilb_scene *scene, const stilb_scene_surface *surface, uint32_t *id);
stilb_result stilb_scene_set_surface(stilb_scene *scene, uint32_t id, const stilb_scene_surface *surface);

/* STILB_ERROR_ARGUMENT also if a material names it. */
stilb_result stilb_scene_remove_surface(stilb_scene *scene, uint32_t id);

/* What surfaces name as their function; mistakes are those that stilb_scene_function_mistake finds. A program that
 * edits its function sets surfaces to a new one and removes the old one. One that does not fit the device's shaders is
 * an error of the next frame, once, as of stilb_render_update_scene; its materials are shown without it. */
stilb_result stilb_scene_add_function(stilb_scene *scene, const stilb_scene_function *function, uint32_t *id);

/* STILB_ERROR_ARGUMENT also if a surface names it. */
stilb_result stilb_scene_remove_function(stilb_scene *scene, uint32_t id);

stilb_result stilb_scene_add_texture(stilb_scene *scene, const stilb_image *image, uint32_t *id);

/* Replaces a texture by one of any size; one of the same size and format takes its place on the device. */
stilb_result stilb_scene_set_texture(stilb_scene *scene, uint32_t id, const stilb_image *image);

/* STILB_ERROR_ARGUMENT also if a material or a surface names it. */
stilb_result stilb_scene_remove_texture(stilb_scene *scene, uint32_t id);

/* ---- lights ------------------------------------------------------------------------------------------------------ */

/* Replaces the list of lights by a copy of this one; count may be 0, and lights may be the scene's own. None of the new
 * list hangs on a node (stilb_scene_attach_light). A light may also be changed where it stands in the scene's list.
 * STILB_ERROR_ARGUMENT: stilb_scene_light_mistake finds something, or there is no part `face`. */
stilb_result stilb_scene_set_lights(stilb_scene *scene, const stilb_scene_light *lights, uint32_t count);

/* ---- what has changed -------------------------------------------------------------------------------------------- */

/* Vertices first .. first + count - 1 of a mesh. */
typedef struct stilb_scene_vertices {
	uint32_t mesh, first, count;
	bool extras; /* the same of its extras, if it has some */
} stilb_scene_vertices;

/* Ids in the order of their first change. Models are in scene->moved. Valid until the next edit. */
typedef struct stilb_scene_changes {
	const uint32_t *meshes;    /* [mesh_count] added, replaced or removed */
	const uint32_t *materials; /* [material_count] added, changed or removed */
	const uint32_t *textures;  /* [texture_count] added, replaced or removed */
	const uint32_t *functions; /* [function_count] added or removed */
	uint32_t mesh_count, material_count, texture_count, function_count;
	const stilb_scene_vertices *vertices; /* [vertices_count] of meshes that are not among the above */
	uint32_t vertices_count;
} stilb_scene_changes;

/* Everything that has changed since the last stilb_scene_changes_clear. Before, it gives the models whose meshes have
 * changed their new bounds. */
stilb_scene_changes stilb_scene_changes_read(stilb_scene *scene);

/* Begins new lists, scene->moved too. */
void stilb_scene_changes_clear(stilb_scene *scene);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
