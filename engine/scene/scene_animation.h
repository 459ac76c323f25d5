/*
 * scene_animation: what of a file moves, as plain data: the hierarchy of nodes at rest, clips, skins and morph targets.
 * Nothing plays it yet: the scene shows the rest pose. Programs may read it and play it themselves, by scene_edit.h.
 *
 * Life cycle.  stilb_scene.animation is made with the scene and freed with it; NULL: nothing of the file moves.
 * Ids.         A node, clip, skin, ... is its index in the arrays. Edits do not change them: removed models are still
 *              named here.
 * Ranges.      Everything here was checked when the file was opened: what it names exists, times do not descend, and
 *              all numbers are finite.
 * Threads.     [any-thread] reads; nobody writes.
 * Units.       Metres, seconds. Rotations are unit quaternions x, y, z, w, to the precision of the file.
 * Source.      glTF 2.0, 3.7.3 (skins), 3.7.2.2 (morph targets), 3.11 and appendix C (animations).
 * Example.     The clip "walk":
 *
 *   const stilb_scene_animation *a = scene->animation;
 *   for (uint32_t c = 0; a && c < a->clip_count; c++)
 *       if (strcmp(a->clips[c].name, "walk") == 0)
 *           for (uint32_t i = 0; i < a->clips[c].channel_count; i++)
 *               play(&a->channels[a->clips[c].first_channel + i]);
 */
#ifndef STILB_SCENE_ANIMATION_H
#define STILB_SCENE_ANIMATION_H

#include "scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* A place in the space of its parent. At rest a model's part is at the product of the matrices from its root to the
 * node: with several models, which a file has instances of, at that product times a matrix of the instance's own. */
typedef struct stilb_scene_rest {
	char name[64];                               /* UTF-8, cut to fit; "": it has none */
	uint32_t parent;                             /* below the node's own index, or STILB_SCENE_NONE: the world */
	stilb_mat4 local;                            /* at rest, from the node to its parent */
	float translation[3], rotation[4], scale[3]; /* as near to local as a product T R S can be: nearly always they make
	                                                it. Without `moves` they are 0 and 1 */
	bool moves;                                  /* it is made of those three, or channels replace them */
	uint32_t first_model, model_count;           /* those that show its mesh, after those of the nodes before */
	uint32_t skin;                               /* of these models, or STILB_SCENE_NONE */
	uint32_t first_weight, weight_count;         /* of its mesh's morph targets at rest, in weights; 0: it has none */
} stilb_scene_rest;

/* What a channel replaces. */
typedef enum stilb_scene_path {
	STILB_SCENE_PATH_TRANSLATION, /* three numbers a key */
	STILB_SCENE_PATH_ROTATION,    /* four; LINEAR: spherically, the shorter way */
	STILB_SCENE_PATH_SCALE,       /* three */
	STILB_SCENE_PATH_WEIGHTS,     /* as many as the node has weights */
	STILB_SCENE_PATHS,
} stilb_scene_path;

/* Between two keys. Before the first key its value holds, and after the last one the last's. */
typedef enum stilb_scene_interpolation {
	STILB_SCENE_STEP,   /* the value of the key before */
	STILB_SCENE_LINEAR, /* a straight line */
	STILB_SCENE_CUBIC,  /* a cubic Hermite spline; tangents are in units of a second. A rotation is made unit again */
	STILB_SCENE_INTERPOLATIONS,
} stilb_scene_interpolation;

typedef struct stilb_scene_channel {
	uint32_t node;
	stilb_scene_path path;
	stilb_scene_interpolation interpolation;
	uint32_t key_count;  /* >= 1 */
	uint32_t width;      /* numbers of a value: 3, 4, 3, or the node's weight_count */
	uint32_t first_time; /* times[first_time .. + key_count - 1], seconds, >= 0, none below the one before */
	uint32_t
		first_value; /* values: key_count * width; CUBIC: for each key the incoming tangent, the value, the outgoing
	                         tangent, each of `width` numbers */
} stilb_scene_channel;

typedef struct stilb_scene_clip {
	char name[64];  /* "number 3" if it has none */
	float duration; /* the time of its last key, seconds */
	uint32_t first_channel, channel_count;
} stilb_scene_clip;

/* A vertex of a skinned mesh is where the sum of weight * (node of the joint to world) * inverse_bind over its
 * influences takes it: the node that shows the mesh does not move it. */
typedef struct stilb_scene_skin {
	char name[64];                     /* "number 3" if it has none */
	uint32_t first_joint, joint_count; /* in joints and inverse_binds */
} stilb_scene_skin;

/* What vertices of a mesh have besides stilb_scene_vertex, in the same order. */
typedef struct stilb_scene_deform {
	uint32_t mesh;
	uint32_t influences; /* of each vertex, a multiple of 4; 0: it is not skinned */
	uint16_t *joints;    /* [vertex_count * influences] within the joints of the node's skin */
	float *weights;      /* [vertex_count * influences] >= 0, as the file has them: their sum may differ from 1 */
	uint32_t targets;    /* morph targets */
	float *positions;    /* [targets * vertex_count * 3] added to the position, times the target's weight */
	float *normals;      /* as positions, added to the normal; NULL: no target has any */
	float *tangents; /* as normals, added to the tangent of the mesh's extras, not to its sign; NULL: none has any */
} stilb_scene_deform;

typedef struct stilb_scene_animation {
	uint32_t node_count, clip_count, channel_count, skin_count, joint_count, deform_count;
	uint32_t time_count, value_count, weight_count;
	stilb_scene_rest *nodes;       /* [node_count] parents before children */
	stilb_scene_clip *clips;       /* [clip_count] */
	stilb_scene_channel *channels; /* [channel_count] */
	stilb_scene_skin *skins;       /* [skin_count] */
	uint32_t *joints;              /* [joint_count] nodes */
	stilb_mat4 *inverse_binds;     /* [joint_count] from the mesh at rest to the joint's node */
	stilb_scene_deform *deforms;   /* [deform_count] by ascending mesh */
	float *times, *values;         /* [time_count], [value_count] */
	float *weights;                /* [weight_count] of morph targets at rest */
} stilb_scene_animation;

/* The deform of a mesh; NULL: no skin or shape moves it. Accepts NULL. [any-thread] */
const stilb_scene_deform *stilb_scene_animation_deform(const stilb_scene_animation *animation, uint32_t mesh);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
