/* What the suite's engine and its plain Vulkan program both draw: the stress test's spheres, whose meshes have no
 * levels of detail, and the maps of its sun, of the engine's own plan. */
#ifndef SHADOWS_SCENE_H
#define SHADOWS_SCENE_H

#include "bench/harness/bench_child.h"

#include "scene/scene.h"
#include "shadow/shadow.h"

#include <math.h>
#include <string.h>

#define SHADOWS_SIZE 1024u /* texels of a map's side */
#define SHADOWS_CASCADES 3u
#define SHADOWS_CUBE 512u /* texels of a side of a cube's map */
#define SHADOWS_WIDTH 32u /* of the picture, in which next to nothing is lit */
#define SHADOWS_HEIGHT 18u

/* A sphere around all models. */
static inline stilb_sphere shadows_around(const stilb_scene *scene)
{
	float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY}, half[3];
	for (uint32_t i = 0; i < scene->model_count; i++) {
		const stilb_scene_bounds *b = &scene->bounds;
		const float center[3] = {b->x[i], b->y[i], b->z[i]};
		for (int c = 0; c < 3; c++) {
			low[c] = fminf(low[c], center[c] - b->radius[i]);
			high[c] = fmaxf(high[c], center[c] + b->radius[i]);
		}
	}
	for (int c = 0; c < 3; c++)
		half[c] = 0.5f * (high[c] - low[c]);
	return (stilb_sphere){low[0] + half[0], low[1] + half[1], low[2] + half[2],
	                      1.1f * sqrtf(half[0] * half[0] + half[1] * half[1] + half[2] * half[2])};
}

/* The camera looks down on few of the models, so that the maps are all the work. */
static inline stilb_scene *shadows_scene(uint32_t models)
{
	stilb_scene *scene;
	if (stilb_scene_create_stress(models, 1, &scene) != STILB_OK)
		bench_child_fail("no scene of %u models", models);
	for (uint32_t m = 0; m < scene->mesh_count; m++)
		stilb_scene_mesh_drop_levels(&scene->meshes[m]);
	stilb_sphere around = shadows_around(scene);
	scene->camera =
		stilb_scene_stress_camera(scene, STILB_SCENE_VIEW_ALL, (float)SHADOWS_WIDTH / (float)SHADOWS_HEIGHT);
	memcpy(scene->camera.position, (float[3]){around.x, around.y + 8.0f, around.z}, sizeof scene->camera.position);
	scene->camera.yaw = scene->camera.roll = 0.0f;
	scene->camera.pitch = -1.57f;
	return scene;
}

static inline stilb_shadow_view shadows_view(const stilb_scene *scene)
{
	const stilb_scene_camera *camera = &scene->camera;
	stilb_shadow_view view = {.view_projection =
	                              stilb_scene_camera_matrix(camera, (float)SHADOWS_WIDTH / (float)SHADOWS_HEIGHT),
	                          .camera_position = {camera->position[0], camera->position[1], camera->position[2]},
	                          .height = SHADOWS_HEIGHT,
	                          .bounds = shadows_around(scene)};
	return view;
}

/* The cascades of the scene's sun. */
static inline stilb_result shadows_plan(const stilb_scene *scene, stilb_shadow_plan *plan)
{
	stilb_shadow_desc desc = {
		.page = SHADOWS_SIZE, .pages = 64, .maps = 64, .cascades = SHADOWS_CASCADES, .filter = 2, .keep = true};
	stilb_shadow_view view = shadows_view(scene);
	return stilb_shadow_plan_make(plan, &desc, &view, scene->lights, scene->light_count);
}

/* The six maps of a lamp two metres over the middle. */
static inline stilb_result shadows_plan_lamp(const stilb_scene *scene, stilb_shadow_plan *plan)
{
	stilb_shadow_desc desc = {.page = SHADOWS_CUBE, .pages = 64, .maps = 64, .cascades = 1, .filter = 2};
	stilb_shadow_view view = shadows_view(scene);
	stilb_scene_light lamp = {.kind = STILB_SCENE_LIGHT_POINT,
	                          .position = {view.bounds.x, view.bounds.y + 2.0f, view.bounds.z},
	                          .intensity = {1.0f, 1.0f, 1.0f}};
	return stilb_shadow_plan_make(plan, &desc, &view, &lamp, 1);
}

#endif
