/*
 * threads_hand: a frame of the stress test recorded by hand on the null device: the stages of engine/frame.c as
 * functions that can be called in other threading patterns. Errors end the program.
 */
#ifndef BENCH_THREADS_HAND_H
#define BENCH_THREADS_HAND_H

#include "culling/cull.h"
#include "render/render.h"
#include "scene/scene.h"

/* The mesh and material of a part, which is one draw of a model, as the module render knows them. */
typedef struct threads_part {
	stilb_render_mesh mesh;
	stilb_render_material material;
} threads_part;

typedef struct threads_hand {
	stilb_scene *scene;
	stilb_cull *cull;
	stilb_render *render;
	stilb_job_pool *pool; /* without workers, for calls that need a pool */
	stilb_render_view view;
	threads_part *parts; /* [scene->part_count] */
} threads_hand;

void threads_hand_open(threads_hand *hand, uint32_t contexts);
void threads_hand_close(threads_hand *hand);

/* Finds the models that the camera sees. Two threads must not call it at once, since it uses hand->cull. */
void threads_hand_cull(threads_hand *hand, stilb_cull_visible *visible);

/* The frame's draws are the parts of the visible models, in order. Writes them to parts[scene->part_count] and returns
 * their number. */
uint32_t threads_hand_list(const threads_hand *hand, const stilb_cull_visible *visible, uint32_t *parts);

/* A frame has `lists` command lists, each begun, filled and ended by one thread; threads_hand_replay draws the lists
 * one after the other. */
void threads_hand_begin(threads_hand *hand, uint32_t lists);
stilb_render_context *threads_hand_list_begin(threads_hand *hand, uint32_t list);
void threads_hand_draw_parts(const threads_hand *hand, stilb_render_context *context, const uint32_t *parts,
                             uint32_t count);
void threads_hand_draw_model(const threads_hand *hand, stilb_render_context *context, uint32_t model);
void threads_hand_list_end(stilb_render_context *context);
void threads_hand_replay(threads_hand *hand);

#endif
