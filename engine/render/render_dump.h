/*
 * render_dump: a frame's command stream as a file, and playing such a file without the scene that it came from.
 *
 * Contents.    The views with their backdrops and panorama, the scene passes, every draw (mesh, level, material, key,
 *              transform) in the order and the segments of its recording, and the meshes, materials and textures that
 *              the draws use, with their ids. So the file needs nothing else, and playing it gives the frame's
 *              stilb_render_stream_hash, which the file also holds. render_dump_format.h describes the bytes.
 * Left out.    2D passes, passes of features, and a panorama that was still being made or was not the frame's first:
 *              saving says so, in a line each that names them.
 * Life cycle.  Saving: stilb_render_dump_save after a frame's replay. Playing: stilb_render_dump_load ->
 *              stilb_render_dump_upload into a new renderer -> frames -> stilb_render_dump_destroy, before or after the
 *              renderer.
 * Per frame.   stilb_render_frame_begin, stilb_render_dump_record, stilb_render_dump_replay, stilb_render_present.
 * Threads.     [main-thread], that of the renderer. record, replay and measure spread work over the pool; `worker` is
 *              the caller's index in it.
 * Errors.      Files are checked field by field before anything is made from them; a message names the file and the
 *              field. No file can reach an assert. STILB_ERROR_MEMORY can come from every function that returns a
 *              result.
 * Example.     One frame of a dump, drawn again:
 *
 *   stilb_render_dump *dump;
 *   stilb_result result = stilb_render_dump_load("frame.dump", &dump);
 *   if (result == STILB_OK)
 *       result = stilb_render_dump_upload(dump, render);
 *   if (result == STILB_OK)
 *       result = stilb_render_frame_begin(render);
 *   if (result == STILB_OK)
 *       result = stilb_render_dump_record(dump, render, pool, 0);
 *   if (result == STILB_OK)
 *       result = stilb_render_dump_replay(dump, render, pool, 0);
 *   stilb_render_dump_destroy(dump);
 */
#ifndef STILB_RENDER_DUMP_H
#define STILB_RENDER_DUMP_H

#include "render/render.h"

typedef struct stilb_render_dump stilb_render_dump;

/* Writes the last replayed frame to path, as base_file.h says: whole or not at all. passes and views are the tables
 * that were given to stilb_render_replay. Valid from replay until the next frame begins. STILB_ERROR_ARGUMENT: no frame
 * with a scene pass has been replayed, it shows a channel in the place of light, or a draw uses a texture and the
 * renderer was created without keep_textures.
 * STILB_ERROR_FILE. [main-thread] */
stilb_result stilb_render_dump_save(stilb_render *render, const stilb_render_pass *passes, uint32_t pass_count,
                                    const stilb_render_view *views, uint32_t view_count, const char *path);

/* Reads and checks the whole of path ("-": standard input). On failure *dump is NULL. STILB_ERROR_FILE: it cannot be
 * read, is not a dump, is of another version or damaged. [any-thread] */
stilb_result stilb_render_dump_load(const char *path, stilb_render_dump **dump);

/* Accepts NULL. [main-thread] */
void stilb_render_dump_destroy(stilb_render_dump *dump);

/* The file's counts and settings. */
typedef struct stilb_render_dump_info {
	uint64_t stream_hash, draws;
	uint32_t passes, meshes, materials, textures;
	uint32_t width, height, samples; /* pixels; samples per pixel */
	stilb_render_output output;
	bool morph; /* it needs a renderer with stilb_render_desc.morph */
} stilb_render_dump_info;

/* [any-thread] */
stilb_render_dump_info stilb_render_dump_info_get(const stilb_render_dump *dump);

/* Creates the dump's meshes, textures and materials with the ids of the file, in a renderer that has none yet. Errors
 * are those of stilb_render_mesh_create, _texture_create and _material_create. [main-thread] */
stilb_result stilb_render_dump_upload(stilb_render_dump *dump, stilb_render *render);

/* Records all passes of an uploaded dump, their segments spread over the pool; after stilb_render_frame_begin.
 * [main-thread] */
stilb_result stilb_render_dump_record(const stilb_render_dump *dump, stilb_render *render, stilb_job_pool *pool,
                                      uint32_t worker);

/* stilb_render_replay with the file's passes and views; after stilb_render_dump_record. [main-thread] */
stilb_result stilb_render_dump_replay(const stilb_render_dump *dump, stilb_render *render, stilb_job_pool *pool,
                                      uint32_t worker);

/* ---- the cost of each kind of command -------------------------------------------------------------------------------
 * Most commands take less time than reading a clock, so whole frames are timed instead: in rounds, each of which runs
 * all of these variants one after the other while the device is idle:
 *
 *   real         the frame as it is: recording, ordering, passes, and in the first rounds submission
 *   few          its passes, with one draw in each command buffer (secondary ones: one for each thread)
 *   plain        its passes, with the bindings of the first draw for all draws
 *   one pipeline its passes, with one pipeline for all draws
 *   split        plain, with an indirect command for every draw (only with indirect replay)
 *
 * Only `real` is ever submitted; the commands of the others are valid and thrown away. The time between two variants,
 * divided by the number of commands of one kind that only one of them has, is the cost of such a command. Given are the
 * median over the rounds and the quartiles, which show how reliable it is. */

typedef struct stilb_render_dump_cost {
	const char *kind;     /* "draw" */
	const char *method;   /* the variants that were compared: "plain - few" */
	uint64_t count;       /* commands of this kind in a frame */
	bool known;           /* false: too few of them to tell, and the numbers below are 0 */
	double ns, low, high; /* nanoseconds of one such command: median, lower and upper quartile */
} stilb_render_dump_cost;

#define STILB_RENDER_DUMP_COSTS 8
#define STILB_RENDER_DUMP_MIN_ROUNDS 5

typedef struct stilb_render_dump_costs {
	stilb_render_dump_cost kinds[STILB_RENDER_DUMP_COSTS]; /* the last is the submission */
	uint32_t rounds;
	double frame_ns; /* recording, ordering and passes of the real frame, ns, median */
} stilb_render_dump_costs;

/* Measures STILB_RENDER_DUMP_MIN_ROUNDS rounds in which the device draws, and then more for `seconds` (>= 0). After
 * stilb_render_dump_upload, between frames. The renderer's picture and stream hash are lost. [main-thread] */
stilb_result stilb_render_dump_measure(const stilb_render_dump *dump, stilb_render *render, stilb_job_pool *pool,
                                       uint32_t worker, double seconds, stilb_render_dump_costs *costs);

#endif
