/*
 * view_trace: path traces a scene on a thread of its own and on the workers of a pool, while frames go on.
 *
 *   view_trace *trace;
 *   if (view_trace_start(scene, pool, 1, &stilb_gi_embree, &trace) == STILB_OK) {
 *       view_trace_look(trace, &settings);
 *       while (view_trace_state(trace, &progress) == VIEW_TRACE_RENDERING)
 *           ...                                     draw frames; view_trace_preview(trace, rgb); view_trace_look again
 *       view_trace_hold(trace);
 *       result = stilb_scene_set_transform(...);      any edits
 *       stilb_scene_revisions_read(scene);
 *       view_trace_follow(trace);
 *       view_trace_look(trace, &settings);
 *       view_trace_end(trace);
 *   }
 *
 * The scene.  It is read in VIEW_TRACE_BUILDING, its textures and its panorama also later. Nothing of it but the camera
 *             may change, except between view_trace_hold and view_trace_follow: so rays see one state of it. What has
 *             changed then decides how much is built again (stilb_gi_scene_update): nothing for materials and lights,
 *             the top of the tree for models that moved, from the second time on.
 * Slices.     The workers' loops end after some 3 ms, so that frames get workers, too, and so does all of it when it is
 *             told to. A tree that is being built is given up then.
 * Threads.    [main-thread]
 */
#ifndef STILB_VIEW_TRACE_H
#define STILB_VIEW_TRACE_H

#include "gi/gi_render.h"

typedef struct view_trace view_trace;

typedef enum view_trace_stage {
	VIEW_TRACE_BUILDING, /* the tree of the scene's triangles */
	VIEW_TRACE_WAITING,  /* for view_trace_look */
	VIEW_TRACE_RENDERING,
	VIEW_TRACE_FINISHED, /* all samples are done */
	VIEW_TRACE_FAILED,   /* view_trace_error says why; only view_trace_end may follow */
} view_trace_stage;

/* Begins to build the tree. pool: its workers trace, if it has any, and none of its other threads; NULL: a pool of the
 * trace's own of `workers` threads, 1..STILB_JOB_MAX_WORKERS, this one's not counted. STILB_ERROR_MEMORY,
 * STILB_ERROR_THREAD; *trace is NULL then. */
stilb_result view_trace_start(const stilb_scene *scene, stilb_job_pool *pool, uint32_t workers,
                              const stilb_gi_intersector *intersector, view_trace **trace);

/* Begins a picture with these settings, in place of the one before. */
void view_trace_look(view_trace *trace, const stilb_gi_settings *settings);

/* Stops the picture that is being rendered, within milliseconds. */
void view_trace_rest(view_trace *trace);

/* Goes on with the picture that was rested, where it was. False: there is none, or the scene was edited. */
bool view_trace_go_on(view_trace *trace);

/* To be called before the scene is edited: gives up the picture, and the tree if it is being built, and waits until
 * nothing reads the scene, milliseconds. */
void view_trace_hold(view_trace *trace);

/* After the edits, and after stilb_scene_revisions_read, which gives moved nodes their places: brings the tree up to
 * date. There is no picture until view_trace_look asks for one. */
void view_trace_follow(view_trace *trace);

/* Where it stands. *progress is {0} without a picture. */
view_trace_stage view_trace_state(view_trace *trace, stilb_gi_progress *progress);

/* The error of VIEW_TRACE_FAILED; valid until the end. */
stilb_result view_trace_error(view_trace *trace, const char **message);

/* Copies the picture so far, [height][width][3] of the settings' size. False: there is none yet. */
bool view_trace_preview(view_trace *trace, float *rgb);

/* Ends all of it within milliseconds. Accepts NULL. */
void view_trace_end(view_trace *trace);

#endif
