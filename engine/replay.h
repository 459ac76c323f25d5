/*
 * engine replay: plays the frame of a dump (render/render_dump.h) again and again, without its scene and without
 * culling.
 *
 * Life cycle.  stilb_engine_replay_create -> stilb_engine_replay_frame, any number of times ->
 *              stilb_engine_replay_destroy.
 * Threads.     [main-thread]: the thread that creates it makes all other calls; the workers are the replay's own.
 * Example.     A frame's picture:
 *
 *   stilb_engine_replay_desc desc = {.path = "frame.stilb", .workers = 1};
 *   stilb_engine_replay *replay;
 *   stilb_engine_times times;
 *   stilb_result result = stilb_engine_replay_create(&desc, &replay);
 *   if (result == STILB_OK)
 *       result = stilb_engine_replay_frame(replay, &times);
 *   if (result == STILB_OK)
 *       result = stilb_engine_replay_screenshot(replay, "frame.png");
 *   stilb_engine_replay_destroy(replay);
 */
#ifndef STILB_ENGINE_REPLAY_H
#define STILB_ENGINE_REPLAY_H

#include "engine.h"
#include "render/render_dump.h"

typedef struct stilb_engine_replay stilb_engine_replay;

typedef struct stilb_engine_replay_desc {
	const char *path; /* the dump; "-": standard input */
	uint32_t workers; /* threads besides the main thread, 0..STILB_JOB_MAX_WORKERS */
	stilb_render_device_kind device;
	stilb_render_replay_mode replay;
	stilb_render_materials materials;
	const stilb_render_output *output; /* NULL: the output that the dump was made with */
	const char *gpu;                   /* a number or a part of a name as `stilb info` prints them; NULL: the best */
	uint32_t width, height;            /* pixels, 1..16384, or 0 for the dump's own; other proportions stretch it */
	bool validate;                     /* with Vulkan's validation layer */
	const stilb_render_shown *shown;   /* as of stilb_render_show_image; copied */
	const char *until;                 /* as of stilb_render_until: the pass that frames end with; copied */
} stilb_engine_replay_desc;

/* Reads the dump, and if it is valid opens the device. On failure *replay is NULL. STILB_ERROR_FILE: the dump cannot be
 * read or is damaged. STILB_ERROR_ARGUMENT, STILB_ERROR_DEVICE, STILB_ERROR_MEMORY, STILB_ERROR_THREAD. */
stilb_result stilb_engine_replay_create(const stilb_engine_replay_desc *desc, stilb_engine_replay **replay);

/* Waits for the device and frees everything. NULL is accepted. */
void stilb_engine_replay_destroy(stilb_engine_replay *replay);

/* Records and replays one frame and fills *times, of which update, cull, ui, present and pad are 0. STILB_ERROR_FILE:
 * the first frame's stream hash, which covers all passes wherever frames end, is not the one in the dump.
 * STILB_ERROR_ARGUMENT: there is no such pass or image. STILB_ERROR_MEMORY, STILB_ERROR_DEVICE_LOST. */
stilb_result stilb_engine_replay_frame(stilb_engine_replay *replay, stilb_engine_times *times);

/* Waits until the device has drawn every frame; *gpu_ms is the last frame's time on it, milliseconds, 0 if unknown.
 * STILB_ERROR_DEVICE_LOST. */
stilb_result stilb_engine_replay_wait(stilb_engine_replay *replay, double *gpu_ms);

/* Writes the last frame's picture as .png, .exr or .hdr. With output LINEAR it is the radiance itself. Fails as
 * stilb_render_read_image and stilb_image_save do. */
stilb_result stilb_engine_replay_screenshot(stilb_engine_replay *replay, const char *path);

/* Writes the last frame's plan: a drawing if path ends in .svg, else text. Fails as stilb_gpu_plan_save does. */
stilb_result stilb_engine_replay_save_plan(stilb_engine_replay *replay, const char *path);

/* Measures for about `seconds` what each kind of command costs (render_dump.h), in whole frames that show the picture,
 * whatever desc.shown and desc.until are. The last picture and plan are lost, and later frames are such ones, too. */
stilb_result stilb_engine_replay_measure(stilb_engine_replay *replay, double seconds, stilb_render_dump_costs *costs);

/* The contents of the dump, and the renderer that plays it; valid until the replay is destroyed. */
stilb_render_dump_info stilb_engine_replay_info(const stilb_engine_replay *replay);
const stilb_render *stilb_engine_replay_render(const stilb_engine_replay *replay);

#endif
