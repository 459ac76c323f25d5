/*
 * threads_hand: a frame of the stress test recorded by hand, on the null device: what engine/frame.c does, in pieces
 * that another way of threading may put where it likes. All that the suite `threads` needs of render's "recording by
 * hand" is in threads_hand.c. Errors end the program.
 */
#ifndef BENCH_THREADS_HAND_H
#define BENCH_THREADS_HAND_H

#include "culling/cull.h"
#include "render/render.h"
#include "scene/scene.h"

/* What a part of the scene is to render. */
typedef struct threads_part {
	stilb_render_mesh mesh;
	stilb_render_material material;
} threads_part;

typedef struct threads_hand {
	stilb_scene *scene;
	stilb_cull *cull;
	stilb_render *render;
	stilb_job_pool *pool; /* of no workers: for calls that ask for one */
	stilb_render_view view;
	threads_part *parts; /* [scene->part_count] */
} threads_hand;

void threads_hand_open(threads_hand *hand, uint32_t contexts);
void threads_hand_close(threads_hand *hand);

/* Which models the camera sees. One call at a time. */
void threads_hand_cull(threads_hand *hand, stilb_cull_visible *visible);

/* The parts of these models, in order, are the frame's draws: fills parts (room for the scene's part_count) and returns
 * how many. */
uint32_t threads_hand_list(const threads_hand *hand, const stilb_cull_visible *visible, uint32_t *parts);

/* A list for each of as many threads, begun, filled and ended by that thread alone; replay draws one after the
 * other. */
void threads_hand_begin(threads_hand *hand, uint32_t lists);
stilb_render_context *threads_hand_list_begin(threads_hand *hand, uint32_t list);
void threads_hand_draw_parts(const threads_hand *hand, stilb_render_context *context, const uint32_t *parts,
                             uint32_t count);
void threads_hand_draw_model(const threads_hand *hand, stilb_render_context *context, uint32_t model);
void threads_hand_list_end(stilb_render_context *context);
void threads_hand_replay(threads_hand *hand);

#endif
