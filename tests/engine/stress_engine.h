/* An engine that shows the stress test, as `stilb demo` does. */
#ifndef STILB_TEST_STRESS_ENGINE_H
#define STILB_TEST_STRESS_ENGINE_H

#include "engine.h"

typedef struct stress_engine {
	uint32_t models;
	uint64_t seed;
	stilb_scene_stress_view view;
	bool animate; /* a tenth of the models moves; desc.update is replaced */
} stress_engine;

static inline void stress_engine_animate(void *scene, const stilb_engine_update *update)
{
	stilb_scene_animate(scene, update->seconds);
}

/* Creates the engine, then its scene. On failure *engine is NULL. */
static inline stilb_result stress_engine_create(const stilb_engine_desc *desc, const stress_engine *stress,
                                                stilb_engine **engine)
{
	stilb_scene *scene;
	stilb_engine_desc with_scene = *desc;
	*engine = NULL;
	stilb_result result = stilb_scene_create_stress(stress->models, stress->seed, &scene);
	if (result != STILB_OK)
		return result;
	scene->camera = stilb_scene_stress_camera(scene, stress->view, (float)desc->width / (float)desc->height);
	if (stress->animate) {
		with_scene.update = stress_engine_animate;
		with_scene.user = scene;
	}
	result = stilb_engine_create(&with_scene, engine);
	if (result == STILB_OK)
		result = stilb_engine_set_scene(*engine, scene);
	if (result != STILB_OK) {
		stilb_engine_destroy(*engine);
		*engine = NULL;
		stilb_scene_destroy(scene);
	}
	return result;
}

/* Accepts NULL. */
static inline void stress_engine_destroy(stilb_engine *engine)
{
	stilb_scene *scene = engine ? stilb_engine_scene(engine) : NULL;
	stilb_engine_destroy(engine);
	stilb_scene_destroy(scene);
}

#endif
