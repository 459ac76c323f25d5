/* view: what `stilb view` shows: a scene, and the camera that orbits it. [main-thread] */
#ifndef STILB_VIEW_H
#define STILB_VIEW_H

#include "game/live/live_run.h"

typedef struct view {
	live_options options;
	const char *name;   /* of the scene, as the user gave it */
	uint64_t turntable; /* pictures of a whole turn; 0: none */
	live_run *run;
	stilb_scene *scene;
	float distance;          /* of the point that the camera orbits */
	float aspect;            /* of the picture that the scene was framed for */
	bool framed;             /* the camera frames the scene, and does so again in a picture of another aspect */
	stilb_scene_camera home; /* the camera at the start */
	stilb_scene_camera last; /* the camera as the last frame left it */
} view;

/* Shows the scene, which is the view's from then on, in place of the one before, which is freed. On failure the old one
 * stays, and the new one is freed. */
stilb_result view_show(view *v, stilb_scene *scene);

/* Moves the camera as the user asks for in this frame. */
void view_move(view *v, const stilb_engine_update *update);

#endif
