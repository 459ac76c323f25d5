/*
 * render_work: opens the scene, renders and writes the picture, on a thread of its own, so that the main thread can show
 * how far it is.
 *
 * Life cycle.  render_work_start -> render_work_look until it says that all is done -> render_work_join.
 * Threads.     All [main-thread].
 */
#ifndef STILB_RENDER_WORK_H
#define STILB_RENDER_WORK_H

#include "render_options.h"

typedef struct render_work render_work;

typedef enum render_stage {
	RENDER_OPENING, /* the scene's file */
	RENDER_BUILDING,
	RENDER_RENDERING,
	RENDER_WRITING,
	RENDER_DONE,
} render_stage;

/* What is known when all is done. */
typedef struct render_result {
	int code;                 /* of the program */
	char message[512];        /* why it is not 0, "" where it is said already */
	bool prepared;            /* the scene was ready: settings, scene and progress hold; else all three are {0} */
	bool stopped;             /* before it was finished, by the user */
	bool saved, checkpointed; /* which files were written */
	uint32_t workers;         /* threads that rendered */
	double open_s, build_s, save_s;
	stilb_gi_settings settings;
	stilb_gi_scene_info scene;
	stilb_gi_progress progress;
} render_result;

/* STILB_ERROR_THREAD, STILB_ERROR_MEMORY. options outlives the work. */
stilb_result render_work_start(const render_options *options, render_work **work);

/* Where it is. progress is {0} but in the stages that render. */
render_stage render_work_look(render_work *work, stilb_gi_progress *progress);

/* A copy of the picture so far, of the size in the options; false while there is none. */
bool render_work_preview(render_work *work, float *rgb);

/* Ends the rendering; what there is is written. */
void render_work_stop(render_work *work);

/* Has a checkpoint written soon. */
void render_work_checkpoint(render_work *work);

/* Waits for the end and frees work. */
render_result render_work_join(render_work *work);

#endif
