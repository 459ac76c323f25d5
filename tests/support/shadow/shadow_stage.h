/*
 * shadow_stage: scenes under one light, drawn by an engine with shadow maps and without: which share of the light each
 * pixel gets, and how large a texel of the map is on each surface.
 *
 *   shadow_stage stage = shadow_stage_open(SHADOW_STAGE_BALLS, 1, &light, shadows, 320, 180);
 *   stage.scene->camera = shadow_stage_camera(&random);
 *   const float *live = shadow_stage_share(&stage);
 *   shadow_stage_close(&stage);
 *
 * Failures end the test.
 */
#ifndef SHADOW_STAGE_H
#define SHADOW_STAGE_H

#include "engine.h"
#include "scene/scene_build.h"

typedef enum shadow_stage_kind {
	SHADOW_STAGE_BALLS,   /* balls and boxes that stand on a floor, or float above it */
	SHADOW_STAGE_HALL,    /* a hall with pillars and an open strip in its ceiling */
	SHADOW_STAGE_CLUTTER, /* boxes and balls in all places and directions, some of them thin */
	SHADOW_STAGE_BOARD,   /* a floor, and half of a plane above it at x < 0, 1 m high */
	SHADOW_STAGE_WALL,    /* a floor, and a plane that stands on it at x = 0, 1 m high, 8 m long */
	SHADOW_STAGE_KINDS
} shadow_stage_kind;

typedef struct shadow_stage {
	stilb_engine *engine;
	stilb_scene *scene;
	uint32_t width, height;
	stilb_engine_shadows shadows;
	float *lit, *share; /* [height][width] */
} shadow_stage;

/* A number between low and high, the next one of a row. */
double shadow_stage_random(uint64_t *state, double low, double high);

/* The scene of a kind; seed: of what is random in it. */
stilb_scene *shadow_stage_scene(shadow_stage_kind kind, uint64_t seed, const stilb_scene_light *light);

shadow_stage shadow_stage_open(shadow_stage_kind kind, uint64_t seed, const stilb_scene_light *light,
                               stilb_engine_shadows shadows, uint32_t width, uint32_t height);

void shadow_stage_close(shadow_stage *stage);

/* A light of a kind over the scenes' middle, in a random place and direction. radius: of those with a size, metres. */
stilb_scene_light shadow_stage_light(uint64_t *state, stilb_scene_light_kind kind, float radius);

/* Somewhere in the scenes, looking somewhere near their middle. */
stilb_scene_camera shadow_stage_camera(uint64_t *state);

/* Of one frame without shadows and one with them: the share of the light that arrives at each pixel, until the next
 * call; NaN: none would. */
const float *shadow_stage_share(shadow_stage *stage);

/* The same without the frame that has no shadows: of a camera and a light of which it was drawn before. */
const float *shadow_stage_share_again(shadow_stage *stage);

/* Metres of the last frame's map that a texel of the scene's only light covers at a point, across the light's rays. */
float shadow_stage_texel(const shadow_stage *stage, const float at[3]);

#endif
