/*
 * offline_work: opens the scene, renders it and writes the picture, all on a thread of its own (and on the workers of a
 * job pool), so that the main thread is free to show the progress.
 *
 *   offline_work *work;
 *   stilb_gi_progress progress;
 *   if (offline_work_start(&options, &crew, &work) == STILB_OK) {
 *       while (offline_work_look(work, &progress) != RENDER_DONE)
 *           ...                                           show the progress, sleep
 *       offline_result result = offline_work_join(work);
 *   }
 *
 * Threads.  All [main-thread]: the thread that called offline_work_start.
 */
#ifndef STILB_RENDER_WORK_H
#define STILB_RENDER_WORK_H

#include "render_crew.h"
#include "render_options.h"

#include "jobs/job.h"

typedef struct offline_work offline_work;

typedef enum offline_stage {
	RENDER_OPENING,  /* reads the scene's file */
	RENDER_BUILDING, /* builds the ray tracer's scene */
	RENDER_RENDERING,
	RENDER_WRITING,
	RENDER_DONE,
} offline_stage;

/* The outcome of the work. */
typedef struct offline_result {
	int code;                                  /* exit code of the program */
	char message[512];                         /* the error, if code is not 0 */
	bool prepared;                             /* the scene could be built; else settings, scene and progress are {0} */
	bool stopped;                              /* the render ended before it was finished */
	uint32_t frames;                           /* pictures of --frames that were written */
	bool saved, checkpointed;                  /* the picture was written; the last checkpoint was written */
	uint32_t workers;                          /* threads that rendered here */
	uint32_t ranks;                            /* machines that rendered; 0: this one alone */
	char shares[256];                          /* who of these rendered how much, in words */
	double open_s, build_s, denoise_s, save_s; /* seconds of the stages; denoise_s: 0 without --denoise */
	bool metered;                              /* the exposure in settings is metered */
	uint64_t import_bytes;                     /* the most memory of the import process at once; 0: unknown */
	stilb_gi_settings settings;
	stilb_gi_scene_info scene;
	stilb_gi_progress progress;
	stilb_job_pool_stats jobs;
} offline_result;

/* Starts the thread, which renders with the crew. *crew and *options must stay valid, and *options unchanged, until
 * offline_work_join returns. STILB_ERROR_THREAD, STILB_ERROR_MEMORY: *work is NULL. */
stilb_result offline_work_start(const offline_options *options, offline_crew *crew, offline_work **work);

/* Returns the present stage. *progress is {0} before rendering begins. */
offline_stage offline_work_look(offline_work *work, stilb_gi_progress *progress);

/* Copies the picture so far into rgb, 3 floats for each pixel of options->size, and sets *exposure and *tone to those
 * of the settings. False: rendering has not begun, or the render has been freed already. */
bool offline_work_preview(offline_work *work, float *rgb, float *exposure, uint32_t *tone);

/* Asks the work to end soon: it writes the picture so far, and a checkpoint. */
void offline_work_stop(offline_work *work);

/* Asks the work to write a checkpoint soon, and to go on. */
void offline_work_checkpoint(offline_work *work);

/* Waits for the thread to end, frees work and returns the outcome. */
offline_result offline_work_join(offline_work *work);

#endif
