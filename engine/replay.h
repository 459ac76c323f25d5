/*
 * engine replay: plays a frame dump (render/render_dump.h) again and again, without the scene and without culling.
 *
 * Life cycle.  stilb_engine_replay_create -> stilb_engine_replay_frame, any number of times -> ..._destroy.
 * Threads.     All [main-thread]; the workers are the replay's own.
 */
#ifndef STILB_ENGINE_REPLAY_H
#define STILB_ENGINE_REPLAY_H

#include "engine.h"
#include "render/render_dump.h"

typedef struct stilb_engine_replay stilb_engine_replay;

typedef struct stilb_engine_replay_desc {
	const char *path; /* the dump, "-": standard input */
	uint32_t workers; /* threads beside the main thread, 0..STILB_JOB_MAX_WORKERS */
	stilb_render_device_kind device;
	stilb_render_replay_mode replay;
	stilb_render_materials materials;
	const stilb_render_output *output; /* NULL: the dump's own */
	const char *gpu;                   /* NULL: the best */
	uint32_t width, height;            /* 1..16384, or 0 for the dump's own; another shape stretches the picture */
	bool validate;
} stilb_engine_replay_desc;

/* Reads the dump first, so that a bad one is refused before a device is opened. */
stilb_result stilb_engine_replay_create(const stilb_engine_replay_desc *desc, stilb_engine_replay **replay);
void stilb_engine_replay_destroy(stilb_engine_replay *replay);

/* One frame; of times, culling and present stay 0. STILB_ERROR_FILE: the first frame's stream hash is not the one in
 * the dump. */
stilb_result stilb_engine_replay_frame(stilb_engine_replay *replay, stilb_engine_times *times);

/* Waits until the device has drawn every frame, and gives the last one's time on it, milliseconds (0: unknown). */
stilb_result stilb_engine_replay_wait(stilb_engine_replay *replay, double *gpu_ms);

/* The last frame's picture as .png or .exr (image.h). With output LINEAR it is the radiance itself. */
stilb_result stilb_engine_replay_screenshot(stilb_engine_replay *replay, const char *path);

/* What each kind of command costs; see render_dump.h. The picture is lost. */
stilb_result stilb_engine_replay_measure(stilb_engine_replay *replay, double seconds, stilb_render_dump_costs *costs);

/* What is played, and on what. */
stilb_render_dump_info stilb_engine_replay_info(const stilb_engine_replay *replay);
const stilb_render *stilb_engine_replay_render(const stilb_engine_replay *replay);

#endif
