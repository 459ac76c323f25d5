/*
 * play_reference: what a scene looks like at a time of its clips, in double precision: an implementation of its own
 * that reads the plain data of scene_animation.h and meshes at rest, and nothing of scene/play.
 *
 * Sources: glTF 2.0, 3.7.3 (skins), 3.7.2.2 (morph targets), 3.11 and appendix C (animations); for several clips
 * scene_play.h, "Blending".
 */
#ifndef PLAY_REFERENCE_H
#define PLAY_REFERENCE_H

#include "scene/play/scene_play.h"

/* An affine matrix: columns x, y, z and where the origin goes. */
typedef struct play_place {
	double m[4][3];
} play_place;

typedef struct play_pose {
	play_place *to_world; /* [node_count] */
	double *weights;      /* [weight_count] of morph targets */
	double (*targets)[4]; /* [node_count * 3]: translations, rotations and scales, while they are mixed */
	double *sums;         /* [node_count * STILB_SCENE_PATHS] of the weights of plays */
} play_pose;

typedef struct play_vertex {
	double position[3], normal[3], tangent[4]; /* in the world; tangent: 0 without extras */
	bool normal_is_clear, tangent_is_clear;    /* it does not come of nearly nothing */
	bool side_is_clear; /* a flat matrix leaves none: then the normal may point both ways, and tangent[3] be both */
} play_vertex;

play_place play_place_of(const stilb_mat4 *matrix);
play_place play_place_product(const play_place *a, const play_place *b);

/* Below 0: it mirrors. */
double play_place_determinant(const play_place *place);

/* What a point becomes; normals get the length that they get. */
void play_place_point(const play_place *place, const double from[3], double to[3]);
void play_place_normal(const play_place *place, const double from[3], double to[3]);

/* The pose of a figure that plays these from rest, times within the clips, on `root`. Freed by play_pose_free. */
play_pose play_pose_make(const stilb_scene_animation *animation, const stilb_scene_play *plays, uint32_t count,
                         const play_place *root);
void play_pose_free(play_pose *pose);

/* Vertex v of a mesh at rest, a part of a model of the node. own: the model's place on that node, the identity but for
 * instances. */
play_vertex play_pose_vertex(const play_pose *pose, const stilb_scene *rest, uint32_t node, const play_place *own,
                             uint32_t mesh, uint32_t v);

#endif
