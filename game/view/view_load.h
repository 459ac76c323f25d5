/*
 * view_load: opens a scene on a thread of its own, so that the window answers meanwhile.
 *
 *   view_load *load;
 *   if (view_load_start("model.gltf", &picture, &load) == STILB_OK) {
 *       while (!view_load_ended(load))
 *           ...                              draw frames; view_load_give_up(load) if the user wants that
 *       result = view_load_take(load, &scene);
 *   }
 *
 * Threads.  [main-thread]
 */
#ifndef STILB_VIEW_LOAD_H
#define STILB_VIEW_LOAD_H

#include "game/cli/picture_flags.h"

typedef struct view_load view_load;

/* Opens the scene and sets the surroundings that the flags name; they must stay unchanged until the end. again is kept
 * for the caller. wait: the meshes' coarser levels are made, too; otherwise those that are on disk are read.
 * STILB_ERROR_MEMORY, STILB_ERROR_THREAD; *load is NULL then. */
stilb_result view_load_start(const char *name, const picture_flags *picture, bool again, bool wait, view_load **load);

const char *view_load_name(const view_load *load);
bool view_load_again(const view_load *load);
double view_load_seconds(const view_load *load);
float view_load_done(const view_load *load); /* as stilb_scene_open_options.progress */

/* The files that the scene's file names and that were read, paths from the root, each once; *count is their number.
 * Once the thread has ended; valid until view_load_take. */
const char *const *view_load_files(const view_load *load, uint32_t *count);

/* The thread has ended, and view_load_take will not wait. */
bool view_load_ended(const view_load *load);

/* Makes the load end soon, with an error that says so. */
void view_load_give_up(view_load *load);

/* What a load has cost. */
typedef struct view_load_cost {
	double seconds;
	uint64_t import_bytes; /* as stilb_scene_open_options.import_bytes */
} view_load_cost;

/* Waits for the end and frees the load. cost: NULL if nobody asks. Errors of stilb_scene_open and
 * picture_flags_surroundings; *scene is NULL then. */
stilb_result view_load_take(view_load *load, stilb_scene **scene, view_load_cost *cost);

#endif
