/* The case `move`: 10,000 small models and one of a million triangles, of which some move. */
#include "bench/gi/gi_run.h"

#include "scene/edit/scene_edit.h"

#include <math.h>
#include <stdlib.h>

#define MODELS 10000u
#define MOVED 10u /* every tenth small model moves, and so does the large one */

static stilb_mat4 place_of(uint32_t model, uint32_t turn)
{
	float x = -9.5f + 0.19f * (float)(model % 100), z = -9.5f + 0.19f * (float)(model / 100);
	return stilb_mat4_scale_translate(0.06f, x, -9.0f + 0.01f * (float)(turn % 50), z);
}

/* The large model is number 0. */
static stilb_scene *crowd(void)
{
	stilb_scene *scene = gi_run_million();
	stilb_scene_mesh ball;
	stilb_scene_build_part part = {.material = 0};
	gi_run_check(stilb_scene_mesh_sphere(1, &ball), "a ball");
	gi_run_check(stilb_scene_add_mesh(scene, &ball, &part.mesh), "a ball");
	stilb_scene_mesh_finish(&ball);
	for (uint32_t i = 0, id; i < MODELS; i++) {
		stilb_mat4 place = place_of(i, 0);
		gi_run_check(stilb_scene_add_model(scene, &place, &part, 1, &id), "a model");
	}
	return scene;
}

static void move(stilb_scene *scene, uint32_t turn)
{
	stilb_mat4 large = stilb_mat4_scale_translate(1.0f, 0.001f * (float)turn, 0.0f, 0.0f);
	gi_run_check(stilb_scene_set_transform(scene, 0, &large), "a move");
	for (uint32_t i = 0; i < MODELS; i += MOVED) {
		stilb_mat4 place = place_of(i, turn);
		gi_run_check(stilb_scene_set_transform(scene, i + 1, &place), "a move");
	}
}

static double seconds_of(const gi_run_world *world)
{
	stilb_gi_settings settings = gi_run_cornell(world->scene);
	settings.samples = 2;
	gi_run_picture picture = gi_run_render(world, &settings);
	gi_run_picture_finish(&picture);
	return picture.seconds;
}

/* Least times: each turn is the same work, so longer times are disturbances. */
void gi_run_move(const bench_child *child)
{
	double whole = (double)INFINITY, movable = whole, update = whole, fixed_rays = whole, rays = whole, spent = 0.0;
	gi_run_world world = gi_run_world_make(crowd(), bench_child_cpu_count() - 1);
	for (uint32_t turn = 1; turn < 4 || spent < child->seconds; turn++) {
		stilb_gi_scene_desc desc = stilb_gi_scene_desc_default(world.pool);
		uint64_t times[6] = {bench_child_now_ns()};
		stilb_gi_scene_destroy(world.gi);
		gi_run_check(stilb_gi_scene_create(world.scene, &desc, &world.gi), "the scene");
		times[1] = bench_child_now_ns();
		fixed_rays = fmin(fixed_rays, seconds_of(&world));
		stilb_gi_scene_destroy(world.gi);
		desc.movable = true;
		times[2] = bench_child_now_ns();
		gi_run_check(stilb_gi_scene_create(world.scene, &desc, &world.gi), "the scene");
		times[3] = bench_child_now_ns();
		move(world.scene, turn);
		times[4] = bench_child_now_ns();
		gi_run_check(stilb_gi_scene_update(world.gi, world.scene, &desc), "the moved scene");
		times[5] = bench_child_now_ns();
		rays = fmin(rays, seconds_of(&world));
		whole = fmin(whole, 1e-6 * (double)(times[1] - times[0]));
		movable = fmin(movable, 1e-6 * (double)(times[3] - times[2]));
		update = fmin(update, 1e-6 * (double)(times[5] - times[4]));
		spent += 1e-9 * (double)(times[5] - times[0]);
	}
	bench_child_metric("whole", whole);
	bench_child_metric("movable", movable);
	bench_child_metric("update", update);
	bench_child_metric("ratio", update / whole);
	bench_child_metric("rays", fixed_rays / rays);
	gi_run_world_finish(&world);
}
