/*
 * scene_node: a hierarchy of places in a scene, and the models, lights and cameras that hang on it: who moves a node
 * moves all that hangs on it.
 *
 * Life cycle.  Nodes come with a file or a build (stilb_scene_build_node), or are added here, and belong to the scene.
 * Per frame.   Set the poses of some nodes -> stilb_engine_frame, which gives the nodes, models, lights and cameras of
 *              the changed subtrees, and of no others, their new places (stilb_scene_update_nodes, on its workers).
 * Ids.         As in scene_edit.h: they stay what they are until a node is removed, after all that hangs on it.
 * Models.      A model on a node has the node's place. One that is moved by stilb_scene_set_transform leaves its node.
 * Lights       and cameras have a place in the space of their node (stilb_scene_mount). When the node moves, position
 *              and direction of a light, its radius and its sides follow, and position, yaw, pitch and roll of a
 *              camera; what the program has written there since the last move is lost. Lengths grow with the node's
 *              scale, a radius with the cube root of the volume; the sides of a rectangle stay perpendicular. All else
 *              stays, intensity and reach too: where a node scales a light that has a face, whose radiance stays,
 *              the program multiplies the intensity by the area's factor.
 * Limits.      A model whose node lies farther than 1e18 m from the origin is not shown while it is there. A light or
 *              a camera that would be out of its ranges there keeps the place that it had last.
 * Mistakes.    STILB_ERROR_ARGUMENT with a line that names what is wrong, or STILB_ERROR_MEMORY: then the scene is as
 *              it was.
 * Threads.     [one-writer], as edits (scene_edit.h).
 * Example.     A door that turns on its hinge, and the handle on it:
 *
 *   uint32_t hinge, handle;
 *   stilb_scene_pose at = stilb_scene_pose_identity(), half = at;
 *   half.translation[0] = 0.9f;
 *   stilb_result result = stilb_scene_add_node(scene, STILB_SCENE_NONE, &at, &hinge);
 *   if (result == STILB_OK)
 *       result = stilb_scene_add_node(scene, hinge, &half, &handle);
 *   if (result == STILB_OK)
 *       result = stilb_scene_attach_model(scene, door_model, hinge);
 *   if (result == STILB_OK)
 *       result = stilb_scene_attach_model(scene, handle_model, handle);
 *   for (float angle = 0.0f; angle < 1.5f && result == STILB_OK; angle += 0.02f) {
 *       at.rotation[1] = sinf(0.5f * angle);
 *       at.rotation[3] = cosf(0.5f * angle);
 *       result = stilb_scene_set_node_pose(scene, hinge, &at);
 *       if (result == STILB_OK)
 *           result = stilb_engine_frame(engine, &report);
 *   }
 */
#ifndef STILB_SCENE_NODE_H
#define STILB_SCENE_NODE_H

#include "jobs/job.h"
#include "scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* Adds a node in the space of parent, a node or STILB_SCENE_NONE, the world. *id is that of a removed node or a new
 * one; at most STILB_SCENE_MAX_MODELS. */
stilb_result stilb_scene_add_node(stilb_scene *scene, uint32_t parent, const stilb_scene_pose *pose, uint32_t *id);

/* STILB_ERROR_ARGUMENT also if nodes, models, lights or cameras hang on it. */
stilb_result stilb_scene_remove_node(stilb_scene *scene, uint32_t id);

/* Moves a node in the space of its parent. Numbers within 1e18; the rotation is unit, to 1 %. */
stilb_result stilb_scene_set_node_pose(stilb_scene *scene, uint32_t id, const stilb_scene_pose *pose);

/* The same by a matrix to the parent's space, affine and within 1e18, which may also shear. */
stilb_result stilb_scene_set_node_matrix(stilb_scene *scene, uint32_t id, const stilb_mat4 *local);

/* Hangs a node on another one or, STILB_SCENE_NONE, nowhere; its pose stays, now in the new parent's space.
 * STILB_ERROR_ARGUMENT also if the parent hangs on the node itself. */
stilb_result stilb_scene_set_node_parent(stilb_scene *scene, uint32_t id, uint32_t parent);

/* Cut to 63 bytes. NULL: none. */
stilb_result stilb_scene_set_node_name(stilb_scene *scene, uint32_t id, const char *name);

/* The node of this name with the lowest id, or STILB_SCENE_NONE. Looks at all of them. [any-thread] */
uint32_t stilb_scene_find_node(const stilb_scene *scene, const char *name);

/* Hangs a model on a node, off the one on which it hung. STILB_SCENE_NONE: on none; it stays where it is. */
stilb_result stilb_scene_attach_model(stilb_scene *scene, uint32_t model, uint32_t node);

/* Hangs a light of the list, or one of scene->cameras, on a node, off the one on which it hung: what it says of its
 * place, sides and radius is from then on meant in the node's space, and the next frame puts it there.
 * STILB_SCENE_NONE: on none; it stays where it is in the world. scene->camera, with which pictures are taken, hangs on
 * no node: copy the named camera to it. */
stilb_result stilb_scene_attach_light(stilb_scene *scene, uint32_t light, uint32_t node);
stilb_result stilb_scene_attach_camera(stilb_scene *scene, uint32_t camera, uint32_t node);

/* Gives the nodes that have changed since the last call, and all that hangs on them, their new places. The
 * engine calls it in each frame, after desc.update; a program does that wants to read to_world or part_transform
 * before. The pool's workers help with more than 8,000 nodes; NULL: none. worker: the caller's index in the pool. The
 * same bits for any number of workers. It takes 8 ns a node that moves, 31 ns one on which a model of two parts
 * hangs (AMD EPYC); a bare loop over matrices in this order takes 5 to 7 ns. */
void stilb_scene_update_nodes(stilb_scene *scene, stilb_job_pool *pool, uint32_t worker);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
