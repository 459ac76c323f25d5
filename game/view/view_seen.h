/* view_seen: what a picture depends on, and which of two pictures are the same. [any-thread] */
#ifndef STILB_VIEW_SEEN_H
#define STILB_VIEW_SEEN_H

#include "engine.h"

typedef struct view_seen {
	stilb_scene_camera camera;
	stilb_scene_revisions scene; /* but for the camera's, which is 0 */
	stilb_render_shading shading;
	uint32_t width, height;
	stilb_render_show show;
} view_seen;

/* Reads what is seen now of a scene, in a picture of this size that shows this. [one-writer] for the scene. */
view_seen view_seen_read(stilb_scene *scene, const stilb_render_shading *shading, stilb_render_show show,
                         uint32_t width, uint32_t height);

/* The same scene, from wherever. */
bool view_seen_same_scene(const view_seen *a, const view_seen *b);

/* Rays would find the same radiance. The exposure, which only shows it, the clip planes, and what is added to the
 * materials of frames do not matter. */
bool view_seen_same_rays(const view_seen *a, const view_seen *b);

/* Frames show the same. */
bool view_seen_same_frame(const view_seen *a, const view_seen *b);

#endif
