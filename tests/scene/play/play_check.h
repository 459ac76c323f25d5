/* Compares what a scene shows with the reference. */
#ifndef PLAY_CHECK_H
#define PLAY_CHECK_H

#include "scene/play/scene_play.h"

/* The largest errors so far. */
typedef struct play_errors {
	double position; /* of all, as a share of the diagonal of what is shown */
	double normal, tangent;
	double bound; /* how far a vertex is outside of its model's sphere, as position */
	uint64_t vertices, directions;
	char where[96]; /* of the largest */
} play_errors;

/* Compares all models of a figure with the reference. rest: the same file, of which nothing has moved yet; place: where
 * the figure stands; plays: with their times. name: of the file, for `where`. */
void play_compare(const stilb_scene *rest, const stilb_scene *scene, uint32_t figure, const stilb_mat4 *place,
                  const stilb_scene_play *plays, uint32_t count, const char *name, play_errors *errors);

/* Fails if they are too large: positions 1e-5, normals and tangents 1e-4. */
void play_assert(const play_errors *errors, const char *name);

#endif
