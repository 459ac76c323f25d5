/* A world to draw into: an engine whose camera is at the origin, looks along -Z and sees 90 degrees of height, and a
 * black square, 2 m a side, 5 m in front of it, in the dark. So all that is seen is what is drawn. */
#ifndef TEST_DEBUG_WORLD_H
#define TEST_DEBUG_WORLD_H

#include "debug/debug_internal.h"
#include "engine_internal.h"
#include "scene/scene_build.h"
#include "support/test.h"

#define WORLD_WIDTH 67u /* odd: the middle is the middle of a pixel */
#define WORLD_HEIGHT 41u
#define WORLD_NEAR 0.1f
#define WORLD_WALL 5.0f /* metres to the square */

typedef struct world {
	stilb_engine *engine;
	stilb_scene *scene;
	stilb_debug *debug;
} world;

static inline stilb_scene *world_scene(void)
{
	static const float black[3] = {0};
	stilb_scene_vertex corners[4];
	static const float places[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
	uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
	stilb_scene *scene = NULL;
	for (int i = 0; i < 4; i++)
		corners[i] = (stilb_scene_vertex){.position = {places[i][0], places[i][1], 0}, .normal = {0, 0, 1}};
	stilb_scene_mesh mesh = {.vertices = corners, .indices = indices, .vertex_count = 4, .index_count = 6};
	stilb_scene_material material = stilb_scene_material_make(black, black, 1.0f);
	stilb_mat4 place = stilb_mat4_scale_translate(1.0f, 0.0f, 0.0f, -WORLD_WALL);
	stilb_scene_camera camera = {.fov_y = 1.57079633f, .near_z = WORLD_NEAR, .far_z = 100.0f};
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_build_part part = {stilb_scene_build_mesh(build, &mesh), stilb_scene_build_material(build, &material)};
	stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &place), &part, 1);
	stilb_scene_build_camera(build, &camera);
	if (stilb_scene_build_end(build, &scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return scene;
}

static inline world world_open(stilb_engine_desc desc)
{
	world w = {.scene = world_scene()};
	desc.width = WORLD_WIDTH;
	desc.height = WORLD_HEIGHT;
	desc.profile = false;
	if (stilb_engine_create(&desc, &w.engine) != STILB_OK || stilb_engine_set_scene(w.engine, w.scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	w.debug = stilb_engine_debug(w.engine);
	return w;
}

static inline void world_close(world *w)
{
	assert_int_equal(stilb_engine_validation_messages(w->engine), 0);
	stilb_engine_destroy(w->engine);
	stilb_scene_destroy(w->scene);
}

/* The place that is seen at this point of the picture, pixels, and this far in front of the camera. */
static inline void world_place(float x, float y, float distance, float out[3])
{
	float aspect = (float)WORLD_WIDTH / (float)WORLD_HEIGHT;
	out[0] = (2.0f * x / (float)WORLD_WIDTH - 1.0f) * aspect * distance;
	out[1] = (1.0f - 2.0f * y / (float)WORLD_HEIGHT) * distance;
	out[2] = -distance;
}

/* Draws a line between two points of the picture. */
static inline void world_line(const world *w, float x0, float y0, float x1, float y1, float distance,
                              stilb_debug_style style)
{
	float from[3], to[3];
	world_place(x0, y0, distance, from);
	world_place(x1, y1, distance, to);
	stilb_debug_line(w->debug, from, to, style);
}

#endif
