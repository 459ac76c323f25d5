/* demo_scene: the stress test's scene in an engine. All [main-thread]. */
#ifndef STILB_DEMO_SCENE_H
#define STILB_DEMO_SCENE_H

#include "demo_options.h"

typedef struct demo_scene {
	stilb_scene *scene;  /* NULL: not made yet */
	bool animate;        /* a tenth of the models moves */
	uint32_t slow_frame; /* number of a frame that is made 100 ms longer; 0: none */
	/* Of the stilb_scene_stress_light; the materials' window lists them. */
	stilb_engine_choice light;
} demo_scene;

/* Sets what the options say; there is no scene yet. */
void demo_scene_init(demo_scene *scene, const demo_options *options, uint32_t slow_frame);

/* The part of each frame that is the demo's own; user is the demo_scene. */
void demo_scene_update(void *user, const stilb_engine_update *update);

/* Makes the scene that the options describe and shows it. STILB_ERROR_MEMORY. */
stilb_result demo_scene_show(demo_scene *scene, const demo_options *options, stilb_engine *engine);

/* Moves the camera to the place of this view in the engine's picture. */
void demo_scene_look(demo_scene *scene, stilb_scene_stress_view view, const stilb_engine *engine);

/* Frees the scene, which no engine shows any more. Accepts {0}. */
void demo_scene_finish(demo_scene *scene);

#endif
