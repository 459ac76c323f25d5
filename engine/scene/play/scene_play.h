/*
 * scene_play: plays the clips of a scene (scene_animation.h): nodes move, and skins and morph targets change the shapes
 * of meshes.
 *
 * Figures.     A figure is all that scene->animation holds, once: its nodes, the models on them, and for each mesh that
 *              a skin or morph targets change a posed mesh of its own. Figure 0 is what the file has; others are added
 *              here, and share clips, materials and all other meshes with it.
 * Life cycle.  Figure 0 comes with a scene whose file has something that moves, in the pose that the file has
 *              (scene->figures is not NULL then). Figures end when they are removed, and with their scene.
 * Per frame.   In the engine's stage update_scene: stilb_scene_advance moves the times of what plays on and gives the
 *              nodes their poses -> the program's update, which may replace some of these poses
 *              (stilb_scene_set_node_pose) -> stilb_scene_update_nodes, which gives models, lights and cameras their
 *              places and posed meshes their vertices. Everybody reads the result: frames, rays, picking, culling.
 * Blending.    Several plays of a figure are mixed by their weights: with a sum below 1 the pose of the file counts for
 *              the rest, beyond 1 they are divided by it. Rotations are mixed on the shorter way and made unit. A node
 *              that no clip moves keeps the pose that it has.
 * Skins.       The node that shows a skinned mesh does not move it: such models hang on no node, and have the place of
 *              their figure. Influences of a vertex are divided by their sum; one that has none follows the first joint
 *              of the skin. Normals follow by the inverse transpose. Bounds are made of the vertices of each pose.
 * Meshes.      A posed mesh is an ordinary one of scene->meshes, without coarser levels, whose vertices are written
 *              again when its pose changes. A program that replaces it (stilb_scene_set_mesh) or removes it has it for
 *              itself; so it is with models and nodes of a figure that are removed.
 * Mistakes.    As in scene_edit.h.
 * Threads.     [one-writer], as edits.
 * Example.     "walk", half as fast, which goes over into "run":
 *
 *   stilb_scene_play plays[2] = {stilb_scene_play_make(stilb_scene_find_clip(scene, "walk")),
 *                                stilb_scene_play_make(stilb_scene_find_clip(scene, "run"))};
 *   plays[0].speed = 0.5f;
 *   plays[0].weight = 0.25f;
 *   plays[1].weight = 0.75f;
 *   stilb_result result = stilb_scene_set_plays(scene, 0, plays, 2);
 */
#ifndef STILB_SCENE_PLAY_H
#define STILB_SCENE_PLAY_H

#include "jobs/job.h"
#include "scene/edit/scene_node.h"
#include "scene/scene_animation.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* What follows when a play has come to an end of its clip. */
typedef enum stilb_scene_repeat {
	STILB_SCENE_LOOP, /* it begins anew, at the other end */
	STILB_SCENE_ONCE, /* it stands still there */
	STILB_SCENE_REPEATS,
} stilb_scene_repeat;

#define STILB_SCENE_MAX_PLAYS 64u /* of a figure */

/* A clip that a figure plays. */
typedef struct stilb_scene_play {
	uint32_t clip; /* in scene->animation->clips */
	double time;   /* seconds in the clip; LOOP: [0, duration), any finite number comes down to that */
	float speed;   /* seconds of the clip a second, finite; 0: it is paused, below 0: it runs backwards */
	float weight;  /* finite, >= 0 */
	stilb_scene_repeat repeat;
	/* Called in stilb_scene_advance, when all figures have their poses, for each play that came to its end in that
	 * step: LOOP once a step at most, ONCE once when it stops. play: its index among those of the figure. It may call
	 * all functions of this header but stilb_scene_advance. NULL: nobody asks. */
	void (*ended)(void *user, uint32_t figure, uint32_t play);
	void *user;
} stilb_scene_play;

/* The clip from its beginning, once as fast as it is, of weight 1, again and again. [any-thread] */
stilb_scene_play stilb_scene_play_make(uint32_t clip);

/* The first clip of this name, or by its number from 1 on ("2"), or STILB_SCENE_NONE. [any-thread] */
uint32_t stilb_scene_find_clip(const stilb_scene *scene, const char *name);

/* Replaces all that a figure plays by a copy of this; the next stilb_scene_advance shows it. count: at most
 * STILB_SCENE_MAX_PLAYS; 0: its nodes keep the poses that they have then. STILB_ERROR_ARGUMENT also without such a
 * figure or clip. */
stilb_result stilb_scene_set_plays(stilb_scene *scene, uint32_t figure, const stilb_scene_play *plays, uint32_t count);

/* What a figure plays, with the times that it has come to: valid until the next call for this scene. NULL and *count 0:
 * nothing, or there is no such figure. [any-thread] */
const stilb_scene_play *stilb_scene_plays_of(const stilb_scene *scene, uint32_t figure, uint32_t *count);

/* Gives all nodes and morph targets of a figure the pose that the file has. What it plays takes hold again in the next
 * stilb_scene_advance in which its time moves on, or after stilb_scene_set_plays. */
stilb_result stilb_scene_rest_figure(stilb_scene *scene, uint32_t figure);

/* Sets the weights of the morph targets of a figure's node: count as of its stilb_scene_rest, finite. Like the pose of
 * a node they hold until a clip replaces them. */
stilb_result stilb_scene_set_weights(stilb_scene *scene, uint32_t figure, uint32_t node, const float *weights,
                                     uint32_t count);

/* Moves the times of all plays on by `seconds`, finite, below 0: back, and gives the nodes and morph targets of
 * figures whose times or plays have changed their poses. The pool's workers help with many channels; NULL: none.
 * worker: the caller's index in the pool. The same bits for any number of workers. The engine calls it in each frame;
 * a program does that shows scenes otherwise, followed by stilb_scene_update_nodes. */
void stilb_scene_advance(stilb_scene *scene, double seconds, stilb_job_pool *pool, uint32_t worker);

/* Plays a clip of figure 0 through once and keeps where it takes the models, at STILB_SCENE_SWEEP times: from then on
 * stilb_scene_frame frames all of these places, too, until the next call. The scene then has the pose of what it plays,
 * or of the file. STILB_SCENE_NONE: it frames the scene as it is again. STILB_ERROR_ARGUMENT also without such a
 * clip. */
#define STILB_SCENE_SWEEP 16u
stilb_result stilb_scene_sweep(stilb_scene *scene, uint32_t clip);

/* True if poses write the vertices of this mesh: nothing may be made of them that is to last. [any-thread] */
bool stilb_scene_mesh_is_posed(const stilb_scene *scene, uint32_t mesh);

/* scene->revisions.poses as it was when this mesh got its last pose, so that a reader finds those that have another one
 * than it knows; 0: it never had one. [any-thread] */
uint64_t stilb_scene_mesh_pose(const stilb_scene *scene, uint32_t mesh);

/* ---- hordes ------------------------------------------------------------------------------------------------------ */

/* What is saved on figures that look small from scene->camera; {0}: nothing. Which figure is posed when depends on the
 * number of calls of stilb_scene_advance and on the camera alone. */
typedef struct stilb_scene_rates {
	/* Radians, >= 0: a figure whose models are seen within a smaller angle is posed in each second call, below half of
	 * it in each fourth, below a quarter in each eighth. Times move on in each. */
	float angle;
	/* Radians, >= 0: a node whose turn by a radian would move all that hangs on it by less than this keeps the pose
	 * that it has. */
	float still;
} stilb_scene_rates;

/* Finite, >= 0. STILB_ERROR_ARGUMENT also if nothing of the scene moves. */
stilb_result stilb_scene_set_rates(stilb_scene *scene, const stilb_scene_rates *rates);

/* Of the last stilb_scene_advance. */
typedef struct stilb_scene_play_counts {
	uint32_t figures;  /* that there are */
	uint32_t sampled;  /* that got poses */
	uint32_t waiting;  /* that will, since they look small */
	uint64_t channels; /* sampled */
	uint64_t still;    /* left out, since what they move looks small */
} stilb_scene_play_counts;

/* All 0 if nothing of the scene moves. [any-thread] */
stilb_scene_play_counts stilb_scene_play_counts_of(const stilb_scene *scene);

/* ---- more figures ------------------------------------------------------------------------------------------------ */

/* Adds a figure in the pose that the file has, which plays nothing, on a new node with this pose, in *figure. Lights
 * and cameras of the file have no copies. */
stilb_result stilb_scene_add_figure(stilb_scene *scene, const stilb_scene_pose *place, uint32_t *figure);

/* Removes a figure with its nodes, models and posed meshes, but for those nodes on which other things hang. Figure 0
 * stays. */
stilb_result stilb_scene_remove_figure(stilb_scene *scene, uint32_t figure);

/* 1 + the highest figure; 0: nothing of the scene moves. [any-thread] */
uint32_t stilb_scene_figure_count(const stilb_scene *scene);

/* The scene's node in place of node `node` of the animation in a figure; STILB_SCENE_NONE: the one on which the whole
 * figure stands. Returns STILB_SCENE_NONE if it has none, or there is no such figure. [any-thread] */
uint32_t stilb_scene_figure_node(const stilb_scene *scene, uint32_t figure, uint32_t node);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
