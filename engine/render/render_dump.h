/*
 * render_dump: a frame's command stream as a file, and the file played without the scene that it came from.
 *
 * What is in it. The views, the passes (2D passes are left out), every draw (mesh, material, key, transform) in the order
 *                of its recording, cut into segments as it was recorded, and the meshes, materials and textures that the
 *                draws use, with their ids. So the file needs nothing else, and what is played has the frame's stream
 *                hash, which is in the file too. render_dump_format.h describes the bytes.
 * Life cycle.    stilb_render_dump_save after a frame's replay. stilb_render_dump_load -> stilb_render_dump_upload into
 *                a new renderer -> frames -> stilb_render_dump_destroy, before or after the renderer.
 * Per frame.     stilb_render_frame_begin, stilb_render_dump_record, stilb_render_dump_replay.
 * Threads.       [main-thread].
 * Errors.        Files are checked field by field before anything is made from them; a message names the file and the
 *                place. Nothing that a file can hold reaches an assert.
 */
#ifndef STILB_RENDER_DUMP_H
#define STILB_RENDER_DUMP_H

#include "render/render.h"

typedef struct stilb_render_dump stilb_render_dump;

/* Writes the last replayed frame; the tables are those that were given to stilb_render_replay. base_file.h says how
 * files are written. Valid after replay until the next frame begins, as the stream hash. STILB_ERROR_ARGUMENT: no frame
 * with a scene pass has been replayed, or a draw uses a texture and the renderer was made without keep_textures.
 * STILB_ERROR_MEMORY, STILB_ERROR_FILE. */
stilb_result stilb_render_dump_save(stilb_render *render, const stilb_render_pass *passes, uint32_t pass_count,
                                    const stilb_render_view *views, uint32_t view_count, const char *path);

/* Reads and checks all of path ("-": standard input). STILB_ERROR_FILE: it cannot be read, is no dump, or is damaged.
 * STILB_ERROR_MEMORY. */
stilb_result stilb_render_dump_load(const char *path, stilb_render_dump **dump);
void stilb_render_dump_destroy(stilb_render_dump *dump);

/* What the file says about the frame. */
typedef struct stilb_render_dump_info {
	uint64_t stream_hash, draws;
	uint32_t passes, meshes, materials, textures;
	uint32_t width, height, samples;
	stilb_render_output output;
} stilb_render_dump_info;

stilb_render_dump_info stilb_render_dump_info_get(const stilb_render_dump *dump);

/* Creates the meshes, textures and materials, with the ids of the file: in a renderer that has none yet.
 * STILB_ERROR_MEMORY, STILB_ERROR_DEVICE. */
stilb_result stilb_render_dump_upload(stilb_render_dump *dump, stilb_render *render);

/* Records all passes, their segments spread over the pool; the caller's index there is worker. */
stilb_result stilb_render_dump_record(const stilb_render_dump *dump, stilb_render *render, stilb_job_pool *pool,
                                      uint32_t worker);

/* stilb_render_replay with the file's passes and views. */
stilb_result stilb_render_dump_replay(const stilb_render_dump *dump, stilb_render *render, stilb_job_pool *pool,
                                      uint32_t worker);

/* ---- what each kind of command costs --------------------------------------------------------------------------------
 * No single command is timed: a clock costs more than most of them. Whole frames are, in rounds, each round all of
 * these one after the other while the device is idle:
 *
 *   real         the frame as it is: recording, order, passes, in the first rounds submission
 *   few          its passes with as few draws as there are command lists
 *   plain        its passes, with the bindings of the first draw for all
 *   one pipeline its passes, with one pipeline for all draws
 *   split        plain, with an indirect command for every draw (only with indirect replay)
 *
 * All others are given to the device and never submitted: the commands are valid, their results thrown away. What two
 * of them differ by, divided by how many commands of one kind they differ by, is the cost of such a command. The number
 * is the median over the rounds, and the quartiles show how far it can be trusted. */

typedef struct stilb_render_dump_cost {
	const char *kind;     /* "draw" */
	const char *method;   /* how it was measured */
	uint64_t count;       /* of such commands in a frame */
	bool known;           /* false: the frame has too few to tell */
	double ns, low, high; /* one such command: median and quartiles */
} stilb_render_dump_cost;

#define STILB_RENDER_DUMP_COSTS 8
#define STILB_RENDER_DUMP_MIN_ROUNDS 5

typedef struct stilb_render_dump_costs {
	stilb_render_dump_cost kinds[STILB_RENDER_DUMP_COSTS]; /* the last is the submission */
	uint32_t rounds;
	double frame_ns; /* the real frame, median: recording, order, passes */
} stilb_render_dump_costs;

/* STILB_RENDER_DUMP_MIN_ROUNDS rounds, in which the device draws, and then some for `seconds`. The renderer's picture
 * and stream hash are lost. After stilb_render_dump_upload, between frames. */
stilb_result stilb_render_dump_measure(const stilb_render_dump *dump, stilb_render *render, stilb_job_pool *pool,
                                       uint32_t worker, double seconds, stilb_render_dump_costs *costs);

#endif
