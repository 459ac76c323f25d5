/*
 * Functions of surfaces (scene/scene_function.h) as the device has them: their code, from which programs of meshes with
 * maps are made as these are needed. Inside render/.
 *
 * Index.    1 .. RENDER_MAX_FUNCTIONS - 1; it rides above the bits of maps (RENDER_MAPS_FUNCTION_SHIFT), so that
 *           groups, classes and programs of different functions differ.
 * Life.     A function goes after the materials that name it, and is freed with its programs once no frame can use
 *           them.
 * Threads.  The table of functions is under the lock of render_programs; an entry does not change while it is there.
 */
#ifndef RENDER_FUNCTIONS_H
#define RENDER_FUNCTIONS_H

#include "render/maps/render_maps.h"

#define RENDER_MAX_FUNCTIONS (STILB_SCENE_MAX_FUNCTIONS + 1)

struct render_device;

typedef struct render_function {
	stilb_scene_function own;
	uint64_t hash;                                /* render_function_hash */
	char program[STILB_SCENE_FUNCTION_NAME + 32]; /* "surface function NAME", of its programs, for messages */
} render_function;

/* The kinds of fragment shaders that a function comes as, in the order of stilb_scene_function.codes: MAPS by layers,
 * gloss, coverage, extras; THROUGH by gloss, extras; CHANNEL by coverage, extras; DEPTH, VELOCITY and SEEN (normals and
 * ids with velocities) by layers, extras; the last counts fastest. As cmake/StilbSurface.cmake writes them. */
typedef enum render_function_kind {
	RENDER_FUNCTION_MAPS,
	RENDER_FUNCTION_THROUGH = 16,
	RENDER_FUNCTION_CHANNEL = 20,
	RENDER_FUNCTION_DEPTH = 24,
	RENDER_FUNCTION_VELOCITY = 28,
	RENDER_FUNCTION_SEEN = 32,
} render_function_kind;

/* [any-thread] */
stilb_gpu_shader render_function_code(const stilb_scene_function *function, render_function_kind kind, bool layers,
                                      bool gloss, bool coverage, bool extras);

/* Of name and code, not 0. [any-thread] */
uint64_t render_function_hash(const stilb_scene_function *function);

/* render_function_check.c: checks it against the vertex shaders and bindings of all programs that it may be in, and
 * copies it. STILB_ERROR_ARGUMENT: it does not fit, and the message names it. STILB_ERROR_MEMORY. [any-thread] */
stilb_result render_function_make(struct render_device *device, const stilb_scene_function *from,
                                  render_function **function);
/* Accepts NULL. */
void render_function_free(render_function *function);

/* render_resources.c: gives it an index. Errors as of render_function_make. [any-thread] */
stilb_result render_function_create(stilb_render *render, const stilb_scene_function *from, uint32_t *index);
/* It is released once no frame can use it. Accepts 0. [any-thread] */
void render_function_destroy(stilb_render *render, uint32_t index);
void render_function_release(stilb_render *render, uint32_t index);

/* Has maps name the function of this index; 0: none. [any-thread] */
void render_function_name(const stilb_render *render, uint32_t index, render_maps *maps);

#endif
