/* Draws the stress test's frame by calls of the modules scene, culling and render, without the engine's own frame
 * (engine/frame.c). */
#include "bench/threads/threads_hand.h"

#include "bench/harness/bench_child.h"
#include "bench/threads/threads_run.h"
#include "profiler/prof.h"

#include <string.h>

#define WIDTH 1280u
#define HEIGHT 720u
#define PASS 0u
#define CALLER 0u /* worker index of a pool's owner, and the context of a single thread */

static void must(stilb_result result)
{
	if (result != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
}

static void find_parts(threads_hand *hand)
{
	const stilb_scene *scene = hand->scene;
	hand->parts = malloc(scene->part_count * sizeof *hand->parts);
	if (!hand->parts)
		bench_child_fail("out of memory for the parts of the scene");
	for (uint32_t i = 0; i < scene->part_count; i++)
		hand->parts[i] = (threads_part){stilb_render_scene_mesh(hand->render, scene->part_mesh[i]),
		                                stilb_render_scene_material(hand->render, scene->part_material[i])};
}

void threads_hand_open(threads_hand *hand, uint32_t contexts)
{
	stilb_render_desc desc = {
		.device = STILB_RENDER_DEVICE_NULL, .width = WIDTH, .height = HEIGHT, .context_count = contexts};
	stilb_job_pool_desc no_workers = {.worker_count = 0};
	float aspect = (float)WIDTH / (float)HEIGHT;
	*hand = (threads_hand){0};
	if (stilb_job_pool_create(&no_workers, &hand->pool) != 0)
		bench_child_fail("cannot create the job pool");
	must(stilb_scene_create_stress(THREADS_MODELS, THREADS_SEED, &hand->scene));
	must(stilb_cull_create(hand->scene, &hand->cull));
	must(stilb_render_create(&desc, &hand->render));
	must(stilb_render_set_scene(hand->render, hand->scene));
	find_parts(hand);
	stilb_scene_camera camera = stilb_scene_stress_camera(hand->scene, STILB_SCENE_VIEW_ALL, aspect);
	hand->view.view_projection = stilb_scene_camera_matrix(&camera, aspect);
	memcpy(hand->view.camera_position, camera.position, sizeof camera.position);
	hand->view.lights = hand->scene->lights;
	hand->view.light_count = hand->scene->light_count;
	hand->view.surroundings = hand->scene->surroundings;
	hand->view.shading = stilb_render_shading_default();
}

void threads_hand_close(threads_hand *hand)
{
	stilb_render_destroy(hand->render);
	stilb_cull_destroy(hand->cull);
	stilb_scene_destroy(hand->scene);
	stilb_job_pool_destroy(hand->pool);
	free(hand->parts);
}

/* ---- the frame's draws ------------------------------------------------------------------------------------------- */

void threads_hand_cull(threads_hand *hand, stilb_cull_visible *visible)
{
	PROFILE("cull");
	stilb_frustum frustum = stilb_frustum_from_matrix(&hand->view.view_projection);
	must(stilb_cull_run(hand->cull, STILB_CULL_AUTO, hand->scene, &frustum, NULL, CALLER, visible));
}

uint32_t threads_hand_list(const threads_hand *hand, const stilb_cull_visible *visible, uint32_t *parts)
{
	const stilb_scene *scene = hand->scene;
	uint32_t count = 0;
	for (uint32_t i = 0; i < visible->count; i++) {
		uint32_t model = visible->ids[i];
		for (uint32_t part = scene->first_part[model]; part < scene->first_part[model + 1]; part++)
			parts[count++] = part;
	}
	return count;
}

/* ---- render ------------------------------------------------------------------------------------------------------ */

void threads_hand_begin(threads_hand *hand, uint32_t lists)
{
	PROFILE("frame begin");
	must(stilb_render_frame_begin(hand->render));
	must(stilb_render_pass_begin(hand->render, PASS, lists));
}

static inline void draw(const threads_hand *hand, stilb_render_context *context, uint32_t part)
{
	const threads_part *drawn = &hand->parts[part];
	stilb_render_draw(context, drawn->mesh, drawn->material, &hand->scene->part_transform[part]);
}

stilb_render_context *threads_hand_list_begin(threads_hand *hand, uint32_t list)
{
	stilb_render_context *context = stilb_render_context_get(hand->render, list);
	stilb_render_segment_begin(context, PASS, list);
	return context;
}

void threads_hand_list_end(stilb_render_context *context)
{
	stilb_render_segment_end(context);
}

void threads_hand_draw_parts(const threads_hand *hand, stilb_render_context *context, const uint32_t *parts,
                             uint32_t count)
{
	for (uint32_t i = 0; i < count; i++)
		draw(hand, context, parts[i]);
}

void threads_hand_draw_model(const threads_hand *hand, stilb_render_context *context, uint32_t model)
{
	for (uint32_t part = hand->scene->first_part[model]; part < hand->scene->first_part[model + 1]; part++)
		draw(hand, context, part);
}

void threads_hand_replay(threads_hand *hand)
{
	PROFILE("replay");
	stilb_render_pass pass = {.name = "main", .view = 0};
	must(stilb_render_pass_end(hand->render, PASS));
	must(stilb_render_replay(hand->render, &pass, 1, &hand->view, 1, hand->pool, CALLER));
	must(stilb_render_present(hand->render));
}
