#include "demo_scene.h"

#include "profiler/prof.h"

#include <time.h>

static void demo_stall(void)
{
	PROFILE("slow on purpose");
	nanosleep(&(struct timespec){.tv_nsec = 100000000}, NULL);
}

void demo_scene_init(demo_scene *scene, const demo_options *options, uint32_t slow_frame)
{
	*scene = (demo_scene){.animate = options->animate,
	                      .slow_frame = slow_frame,
	                      .light = {"Light", stilb_scene_stress_light_names, STILB_SCENE_STRESS_LIGHT_COUNT,
	                                (uint32_t)options->light, 0}};
}

void demo_scene_update(void *user, const stilb_engine_update *update)
{
	demo_scene *scene = user;
	if (update->frame == scene->slow_frame)
		demo_stall();
	stilb_scene_stress_set_light(scene->scene, (stilb_scene_stress_light)scene->light.chosen);
	if (scene->animate)
		stilb_scene_animate(scene->scene, update->seconds);
}

stilb_result demo_scene_show(demo_scene *scene, const demo_options *options, stilb_engine *engine)
{
	STILB_ASSERT(!scene->scene);
	stilb_result result = stilb_scene_create_stress((uint32_t)options->models, options->seed, &scene->scene);
	if (result != STILB_OK)
		return result;
	demo_scene_look(scene, (stilb_scene_stress_view)options->view, engine);
	return stilb_engine_set_scene(engine, scene->scene);
}

void demo_scene_look(demo_scene *scene, stilb_scene_stress_view view, const stilb_engine *engine)
{
	uint32_t width, height;
	stilb_engine_size(engine, &width, &height);
	scene->scene->camera = stilb_scene_stress_camera(scene->scene, view, (float)width / (float)height);
}

void demo_scene_finish(demo_scene *scene)
{
	stilb_scene_destroy(scene->scene);
	*scene = (demo_scene){0};
}
