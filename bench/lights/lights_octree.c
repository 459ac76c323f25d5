/* Which of many lights: they live in a loose octree, from which the candidates of a view are chosen. Beside them the
 * stress test with as many models, of which a tenth moves, too, and one in a hundred is in view. */
#include "bench/lights/lights_octree.h"
#include "culling/cull.h"
#include "scene/edit/scene_edit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MOVING 10u /* every so-manieth moves */
#define SWING 1.0f /* metres to both sides */
#define SEEN 0.01  /* share of lights in view that is aimed at */

typedef struct world {
	stilb_scene_light *lights;
	float *home_x; /* [count] metres */
	uint32_t count;
	stilb_cull_octree *octree;
	uint64_t *bits;
	uint32_t *candidates, candidate_count;
	stilb_scene *scene; /* the stress test */
	stilb_frustum scene_frustum;
	stilb_cull *cull;
	stilb_cull_visible visible;
	stilb_frustum frustum;
} world;

static void check(stilb_result result)
{
	if (result != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
}

static void *allocate(size_t count, size_t size)
{
	void *memory = stilb_memory_alloc(count, size);
	if (!memory)
		bench_child_fail("no memory");
	return memory;
}

static double cpu_ns(void)
{
	struct timespec now;
	clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
	return (double)now.tv_sec * 1e9 + (double)now.tv_nsec;
}

static void choose_lights(world *w)
{
	uint32_t words = (w->count + 63) / 64;
	memset(w->bits, 0, words * sizeof *w->bits);
	check(stilb_cull_octree_mark(w->octree, &w->frustum, w->bits));
	w->candidate_count = 0;
	for (uint32_t word = 0; word < words; word++)
		for (uint64_t left = w->bits[word]; left; left &= left - 1)
			w->candidates[w->candidate_count++] = 64 * word + (uint32_t)__builtin_ctzll(left);
}

static float place_of(const world *w, uint32_t i, uint32_t frame)
{
	return w->home_x[i] + SWING * sinf(0.1f * (float)frame + (float)i);
}

static void frame_lights(world *w, uint32_t frame)
{
	for (uint32_t i = frame % MOVING; i < w->count; i += MOVING) {
		w->lights[i].position[0] = place_of(w, i, frame);
		check(stilb_cull_octree_move(w->octree, i, stilb_light_bounds_of(&w->lights[i]).sphere));
	}
	choose_lights(w);
}

static void frame_models(world *w, uint32_t frame)
{
	stilb_scene_animate(w->scene, 0.1 * frame);
	check(stilb_cull_update(w->cull, w->scene, w->scene->moved, w->scene->moved_count));
	check(stilb_cull_run(w->cull, STILB_CULL_AUTO, w->scene, &w->scene_frustum, NULL, 0, &w->visible));
	stilb_scene_changes_clear(w->scene);
}

static void stress_make(world *w)
{
	check(stilb_scene_create_stress(w->count, 1, &w->scene));
	stilb_scene_camera camera = stilb_scene_stress_camera(w->scene, STILB_SCENE_VIEW_FEW, 16.0f / 9.0f);
	stilb_mat4 view = stilb_mat4_view(stilb_vec3_make(camera.position[0], camera.position[1], camera.position[2]),
	                                  camera.yaw, camera.pitch);
	stilb_mat4 matrix =
		stilb_mat4_multiply(stilb_mat4_perspective(camera.fov_y, 16.0f / 9.0f, camera.near_z, camera.far_z), view);
	w->scene_frustum = stilb_frustum_from_matrix(&matrix);
	check(stilb_cull_create(w->scene, &w->cull));
}

/* Where a light is on a curve that visits squares of 1, 4, 16, ... square metres one after the other: Morton's. */
static uint32_t curve_of(const stilb_scene_light *light)
{
	uint32_t x = (uint32_t)(light->position[0] + 1024.0f), z = (uint32_t)(light->position[2] + 1536.0f), code = 0;
	for (uint32_t bit = 0; bit < 11; bit++)
		code |= (x >> bit & 1u) << (2 * bit) | (z >> bit & 1u) << (2 * bit + 1);
	return code;
}

static int by_curve(const void *a, const void *b)
{
	uint32_t p = curve_of(a), q = curve_of(b);
	return p < q ? -1 : p > q;
}

/* Neighbours in space are neighbours in memory, as the stress test's models are. Cells have sides of 65 m and some 400
 * lights: of four times as many cells, moves miss the cache more often. */
static void world_make(world *w, stilb_scene_light *lights, uint32_t count)
{
	*w = (world){.lights = lights, .count = count};
	stilb_cull_octree_desc desc = {.center = {0.0f, 0.0f, -500.0f}, .half_size = 520.0f, .max_depth = 4};
	qsort(lights, count, sizeof *lights, by_curve);
	w->home_x = allocate(count, sizeof *w->home_x);
	w->bits = allocate(count / 64 + 1, sizeof *w->bits);
	w->candidates = allocate(count, sizeof *w->candidates);
	check(stilb_cull_octree_create(&desc, &w->octree));
	for (uint32_t i = 0; i < count; i++) {
		stilb_sphere sphere = stilb_light_bounds_of(&lights[i]).sphere;
		w->home_x[i] = lights[i].position[0];
		check(stilb_cull_octree_insert(w->octree, i, sphere));
	}
	stress_make(w);
}

static void world_free(world *w)
{
	stilb_cull_octree_destroy(w->octree);
	stilb_cull_visible_finish(&w->visible);
	stilb_cull_destroy(w->cull);
	stilb_scene_destroy(w->scene);
	free(w->home_x);
	free(w->bits);
	free(w->candidates);
}

/* Sets the view to one that sees about SEEN of the lights: as far as needed. */
static void choose_view(world *w, stilb_light_grid *grid)
{
	stilb_mat4 view = stilb_mat4_view(stilb_vec3_make(0.0f, 1.7f, 0.0f), 0.1f, 0.05f);
	float aspect = (float)grid->width / (float)grid->height;
	for (float far_z = 20.0f; far_z < 2000.0f; far_z *= 1.05f) {
		grid->view_projection = stilb_mat4_multiply(stilb_mat4_perspective(1.0f, aspect, 0.1f, far_z), view);
		w->frustum = stilb_frustum_from_matrix(&grid->view_projection);
		choose_lights(w);
		if (w->candidate_count >= SEEN * w->count)
			return;
	}
}

/* The candidates must be the lights whose spheres the frustum has: what a plain loop says. */
static void require_right(const world *w)
{
	uint32_t at = 0;
	for (uint32_t i = 0; i < w->count; i++) {
		stilb_sphere s = stilb_light_bounds_of(&w->lights[i]).sphere;
		bool seen = true;
		for (int p = 0; p < 6; p++) {
			stilb_plane plane = w->frustum.planes[p];
			seen = seen && ((s.x * plane.x + s.y * plane.y) + s.z * plane.z) + plane.distance >= -s.radius;
		}
		if (seen && (at == w->candidate_count || w->candidates[at++] != i))
			bench_child_fail("light %u is in view and was not chosen", i);
	}
	if (at != w->candidate_count)
		bench_child_fail("%u lights were chosen and %u are in view", w->candidate_count, at);
}

void lights_octree_measure(const bench_child *child, stilb_light_grid *grid, stilb_scene_light *lights, uint32_t count)
{
	world w;
	stilb_light_lists lists = {0};
	world_make(&w, lights, count);
	choose_view(&w, grid);
	double chosen = (double)INFINITY, models = chosen, build = chosen, linear = chosen;
	stilb_light_grid behind = *grid; /* where no lights are: what is left is to look at each */
	stilb_mat4 turned = stilb_mat4_view(stilb_vec3_make(0.0f, 1.7f, 100.0f), 3.1415927f, 0.0f);
	behind.view_projection = stilb_mat4_multiply(stilb_mat4_perspective(1.0f, 1.7f, 0.1f, 1000.0f), turned);
	uint64_t end = bench_child_now_ns() + (uint64_t)(child->seconds * 1e9);
	for (uint32_t frame = 0; frame < 2 * MOVING || bench_child_now_ns() < end; frame++) {
		double begin = cpu_ns();
		frame_lights(&w, frame);
		double moved = cpu_ns();
		frame_models(&w, frame);
		double culled = cpu_ns();
		check(stilb_light_lists_build(&lists, grid, lights, count, w.candidates, w.candidate_count, NULL, 0));
		double built = cpu_ns();
		check(stilb_light_lists_build(&lists, &behind, lights, count, NULL, 0, NULL, 0));
		double looked = cpu_ns();
		if (lists.light_count > 0)
			bench_child_fail("%u lights are in view where none is", lists.light_count);
		if (frame < MOVING) /* what has not moved yet moves a longer way */
			continue;
		chosen = fmin(chosen, moved - begin);
		models = fmin(models, culled - moved);
		build = fmin(build, built - culled);
		linear = fmin(linear, looked - built);
	}
	require_right(&w);
	bench_child_metric("chosen", chosen * 1e-6);
	bench_child_metric("models", models * 1e-6);
	bench_child_metric("ratio", chosen / models);
	bench_child_metric("one", build * 1e-6);
	bench_child_metric("linear", linear * 1e-6);
	bench_child_metric("seen", 100.0 * w.candidate_count / count);
	stilb_light_lists_finish(&lists);
	world_free(&w);
}
