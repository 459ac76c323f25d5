/*
 * offline_work: opens the scene, renders and writes the picture, on a thread of its own, so that the main thread can
 * show how far it is.
 *
 * Life cycle.  offline_work_start -> offline_work_look until it says that all is done -> offline_work_join.
 * Threads.     All [main-thread].
 */
#ifndef STILB_RENDER_WORK_H
#define STILB_RENDER_WORK_H

#include "render_options.h"

typedef struct offline_work offline_work;

typedef enum offline_stage {
	RENDER_OPENING, /* the scene's file */
	RENDER_BUILDING,
	RENDER_RENDERING,
	RENDER_WRITING,
	RENDER_DONE,
} offline_stage;

/* What is known when all is done. */
typedef struct offline_result {
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
} offline_result;

/* STILB_ERROR_THREAD, STILB_ERROR_MEMORY. options outlives the work. */
stilb_result offline_work_start(const offline_options *options, offline_work **work);

/* Where it is. progress is {0} but in the stages that render. */
offline_stage offline_work_look(offline_work *work, stilb_gi_progress *progress);

/* A copy of the picture so far, of the size in the options; false while there is none. */
bool offline_work_preview(offline_work *work, float *rgb);

/* Ends the rendering; what there is is written. */
void offline_work_stop(offline_work *work);

/* Has a checkpoint written soon. */
void offline_work_checkpoint(offline_work *work);

/* Waits for the end and frees work. */
offline_result offline_work_join(offline_work *work);

#endif
