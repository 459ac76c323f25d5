/*
 * One frame: eight stages, called in the order of the table. Each has one owner and one output and reads only what a
 * stage above it wrote. GPU times and a new size of the window are known only later and enter with the next frame's
 * input.
 *
 *   stage          reads                       writes                                  threads
 *   frame_begin    the window, the device      keys, step, rewound contexts            main
 *   update_scene   keys, gamepads, step        camera; poses of clips; the program:    main, jobs
 *                                              its scene; then what hangs on moved
 *                                              nodes, posed meshes, and meshes,
 *                                              materials, textures that changed
 *   cull           scene, moved list, views    octree, visible ids per view            jobs
 *   record         scene, visible ids          command lists in numbered segments      jobs, one writer a list
 *   ui             input, profiler snapshots,  the lists of the open overlay and of    main
 *                  the program's picture       that picture
 *   debug          what threads have drawn     its records, sorted                     main, jobs
 *                  into the world
 *   replay         the lists                   device commands, in number order        main (jobs: secondary lists)
 *   present        the device's picture        the window, or an image in memory       main
 */
#include "engine_internal.h"

#include "profiler/prof.h"
#include "scene/edit/scene_node.h"
#include "scene/play/scene_play.h"

#define FRAME_STEP (1.0f / 60.0f)
#define FRAME_MAX_STEP 0.1f /* seconds: after a stall a longer step would make everything that moves jump */
#define FRAME_STILL 4.0f    /* pixels that the pointer may move in a click */
#define FRAME_OWNER 0u      /* the main thread's worker index */

/* Ends a stage that began at *since: *ms is its time, and the next stage begins now. */
static void frame_clock(uint64_t *since, double *ms)
{
	uint64_t now = stilb_time_ns();
	*ms = (double)(now - *since) * 1e-6;
	*since = now;
}

/* Resizes the picture to the window's size. *drawn is false if the window has no area to draw to. */
static stilb_result frame_resize(stilb_engine *engine, const stilb_window_state *state, bool *drawn)
{
	uint32_t width, height;
	*drawn = state->width > 0 && state->height > 0;
	stilb_render_size(engine->render, &width, &height);
	if (!*drawn || (state->width == width && state->height == height))
		return STILB_OK;
	return stilb_render_resize(engine->render, state->width, state->height);
}

/* Frames that somebody watches step by the clock. */
static bool frame_by_clock(const stilb_engine *engine)
{
	return engine->window || engine->desc.surface;
}

/* Sets the frame's step by the clock. */
static void frame_step(stilb_engine *engine)
{
	uint64_t now = stilb_time_ns();
	float elapsed = engine->last_ns ? (float)((double)(now - engine->last_ns) * 1e-9) : FRAME_STEP;
	engine->step = elapsed < FRAME_MAX_STEP ? elapsed : FRAME_MAX_STEP;
	engine->last_ns = now;
}

/* A click is a press of the left button that does not become a drag. */
static void frame_click(stilb_engine *engine, const stilb_window_state *state, stilb_engine_report *report)
{
	const engine_overlay *overlay = &engine->overlay;
	engine_press *press = &engine->press;
	if (state->clicks > 0 && state->pointer)
		*press = (engine_press){!engine_overlay_is_open(overlay) || !stilb_ui_wants_mouse(overlay->ui),
		                        state->pointer_x, state->pointer_y};
	float x = state->pointer_x - press->x, y = state->pointer_y - press->y;
	press->still = press->still && state->pointer && x * x + y * y <= FRAME_STILL * FRAME_STILL;
	if (state->button || !press->still)
		return;
	report->clicked = true;
	report->click_x = press->x;
	report->click_y = press->y;
	press->still = false;
}

/* Takes the window's events and sets the frame's step. */
static stilb_result frame_window(stilb_engine *engine, stilb_engine_report *report)
{
	stilb_window_state state;
	report->drawn = true;
	engine->step = FRAME_STEP;
	if (frame_by_clock(engine))
		frame_step(engine);
	if (!engine->window && !engine_input_take_given(engine, &state))
		return STILB_OK;
	if (engine->window)
		stilb_window_poll(engine->window, &state);
	if (engine->window && !state.lost && (state.width == 0 || state.height == 0))
		stilb_window_wait(engine->window, 0.05, &state);
	engine->input.focused = state.focused && state.width > 0;
	report->input = stilb_input_from_window(&engine->actions, &state);
	report->close = state.close;
	report->lost = state.lost;
	report->dropped = state.dropped;
	report->dropped_count = state.dropped_count;
	if (state.lost)
		return STILB_OK; /* frames go on without a window, in the last size */
	frame_click(engine, &state, report);
	engine_overlay_input(engine, &state, &report->input);
	return frame_resize(engine, &state, &report->drawn);
}

/* Consumes the input of keys and gamepads, also while minimised, so that it does not pile up. */
static void frame_input(stilb_engine *engine, stilb_engine_report *report)
{
	report->time_us = engine_input_frame(engine, &report->input);
	report->replayed = engine->input.replayed;
	engine_overlay_act(engine, &report->input);
	engine_images_act(engine, &report->input);
}

static stilb_result frame_begin(stilb_engine *engine)
{
	PROFILE("frame begin");
	return stilb_render_frame_begin(engine->render);
}

/* Brings the renderer up to date with what the program has changed in its scene. */
static stilb_result update_render(stilb_engine *engine)
{
	stilb_scene_changes changes = stilb_scene_changes_read(engine->scene);
	engine_pick_forget(engine, &changes);
	return stilb_render_update_scene(engine->render, engine->scene, &changes);
}

/* Moves what plays on by the time since the frame before, and by what the program has asked for besides. */
static void update_clips(stilb_engine *engine)
{
	engine_playing *playing = &engine->playing;
	double seconds = (engine->seconds - playing->seconds) * (double)playing->pace + playing->step;
	playing->seconds = engine->seconds;
	playing->step = 0.0;
	stilb_scene_advance(engine->scene, seconds, engine->pool, FRAME_OWNER);
}

/* Exposure and grade go on, but while the scene is hidden: what hides it is shown with the same. */
static stilb_result update_exposure(stilb_engine *engine)
{
	if (engine->picture.hides_scene)
		return STILB_OK;
	stilb_result result = stilb_post_stand(engine->post, engine->scene->camera.position);
	return result == STILB_OK ? stilb_post_adapt(engine->post, engine->step) : result;
}

static stilb_result update_scene(stilb_engine *engine)
{
	PROFILE("scene update");
	frame_input(engine, &engine->report); /* as late as possible: the picture shows the camera of this moment */
	if (engine->scene)
		update_clips(engine);
	if (engine->desc.update)
		engine->desc.update(engine->desc.user,
		                    &(stilb_engine_update){engine->frame + 1, engine->seconds, &engine->report.input});
	engine_picture_decide(engine);
	const stilb_scene *scene = engine->scene;
	if (!scene) {
		engine->views[0] = (stilb_render_view){.shading = engine->shading};
		engine->view_count = engine->pass_count = 1;
		return STILB_OK;
	}
	stilb_scene_update_nodes(engine->scene, engine->pool, FRAME_OWNER);
	STILB_ASSERT(scene->moved_count <= scene->model_count);
	engine->frame_formulas = engine_prepare_formulas(engine);
	stilb_result result = update_exposure(engine);
	engine_cameras_frame(engine);
	if (result == STILB_OK)
		result = update_render(engine);
	return result == STILB_OK ? engine_shadows_frame(engine) : result;
}

/* stilb_job_range_fn: takes from what views begin .. end - 1 see those models that are not for them. */
static void leave_out(uint32_t begin, uint32_t end, uint32_t worker, void *user)
{
	stilb_engine *engine = user;
	(void)worker;
	for (uint32_t v = begin; v < end; v++) {
		uint32_t flag = engine->views[v].shadow ? STILB_SCENE_MODEL_CASTS_NO_SHADOW : STILB_SCENE_MODEL_UNSEEN;
		stilb_cull_visible *visible = &engine->visible[v];
		visible->count = stilb_scene_leave_out(engine->scene, flag, visible->ids, visible->count);
		if (engine->views[v].shadow)
			engine_shadows_leave_out(engine, v, visible);
	}
}

/* Finds what each view sees. */
static stilb_result see_views(stilb_engine *engine)
{
	const stilb_scene *scene = engine->scene;
	stilb_frustum frusta[ENGINE_MAX_VIEWS];
	for (uint32_t v = 0; v < engine->view_count; v++)
		frusta[v] = stilb_frustum_from_matrix(&engine->views[v].view_projection);
	stilb_result result = stilb_cull_run_views(engine->cull, engine->desc.cull, scene, frusta, engine->view_count,
	                                           engine->pool, FRAME_OWNER, engine->visible);
	if (result == STILB_OK)
		stilb_job_parallel_for(engine->pool, engine->view_count, 1, leave_out, engine, FRAME_OWNER);
	return result;
}

static stilb_result cull(stilb_engine *engine)
{
	PROFILE("cull");
	STILB_ASSERT(engine->view_count >= 1 && engine->view_count <= ENGINE_MAX_VIEWS);
	stilb_scene *scene = engine->scene;
	if (!scene) {
		for (uint32_t v = 0; v < engine->view_count; v++)
			engine->visible[v].count = 0;
		return STILB_OK;
	}
	stilb_result result = stilb_cull_update(engine->cull, scene, scene->moved, scene->moved_count);
	stilb_scene_changes_clear(scene); /* the program's lists for the next frame begin */
	if (engine->picture.hides_scene)
		return result; /* what was visible is so still */
	return result == STILB_OK ? see_views(engine) : result;
}

static stilb_result record(stilb_engine *engine)
{
	PROFILE("record");
	bool hidden = engine->picture.hides_scene;
	stilb_render_recording recordings[ENGINE_MAX_VIEWS];
	for (uint32_t p = 0; p < engine->pass_count; p++) {
		uint32_t v = engine->passes[p].view;
		STILB_ASSERT(v < engine->view_count);
		recordings[p] = (stilb_render_recording){.pass = p,
		                                         .visible = engine->visible[v].ids,
		                                         .visible_count = hidden ? 0 : engine->visible[v].count,
		                                         .view = &engine->views[v]};
	}
	engine->frame_passes = engine->pass_count;
	return stilb_render_record_views(engine->render, engine->scene, recordings, engine->pass_count, engine->pool,
	                                 FRAME_OWNER);
}

/* Records the program's picture, if one is shown: after ui, in which the user drags its edge. */
static stilb_result picture(stilb_engine *engine)
{
	if (!engine->picture.shown)
		return STILB_OK;
	PROFILE("picture");
	STILB_ASSERT(engine->frame_passes < STILB_RENDER_MAX_PASSES);
	uint32_t pass = engine->frame_passes++;
	engine->passes[pass] = (stilb_render_pass){.name = "picture", .kind = STILB_RENDER_PASS_2D, .order = 0};
	return engine_picture_record(engine, pass, FRAME_OWNER);
}

static stilb_result ui(stilb_engine *engine)
{
	PROFILE("ui");
	if (!engine_overlay_is_open(&engine->overlay))
		return STILB_OK;
	STILB_ASSERT(engine->frame_passes < STILB_RENDER_MAX_PASSES);
	uint32_t pass = engine->frame_passes++;
	engine->passes[pass] = (stilb_render_pass){.name = "overlay", .kind = STILB_RENDER_PASS_2D, .order = UINT32_MAX};
	return engine_overlay_record(engine, pass, FRAME_OWNER);
}

/* Gathers what threads have drawn into the world; without a scene there are no cameras to see it. */
static stilb_result debug(stilb_engine *engine)
{
	return stilb_debug_frame(engine->debug, engine->views, engine->scene ? engine->camera_count + 1 : 0,
	                         engine->seconds, engine->pool, FRAME_OWNER);
}

static stilb_result replay(stilb_engine *engine)
{
	PROFILE("replay");
	engine_cameras_jitter(engine);
	stilb_post_see(engine->post, &engine->views[0]);
	return stilb_render_replay(engine->render, engine->passes, engine->frame_passes, engine->views, engine->view_count,
	                           engine->pool, FRAME_OWNER);
}

/* A window whose display went away during the frame is not an error: the next frame's stilb_window_poll reports it. */
static stilb_result present(stilb_engine *engine)
{
	PROFILE("present");
	stilb_result result =
		engine_surface_present(&engine->surface, engine->render, engine->report.lost ? NULL : engine->window);
	engine->report.lost |= engine_surface_is_gone(&engine->surface, engine->window);
	return result;
}

stilb_result engine_frame_again(stilb_engine *engine, bool hidden)
{
	engine->picture.hides_scene = false;
	stilb_result result = frame_begin(engine);
	engine_cameras_frame(engine);
	engine->shadows.valid &= !hidden;
	if (result == STILB_OK && engine->part.width > 0)
		result = update_render(engine); /* reads the scene's changes again: none since, so that velocities are 0 */
	if (result == STILB_OK)
		result = engine_shadows_frame(engine);
	if (engine->part.width > 0)
		engine_cameras_part(engine);
	if (result == STILB_OK)
		result = see_views(engine);
	if (result == STILB_OK)
		result = record(engine);
	return result == STILB_OK ? replay(engine) : result;
}

/* Draws a frame of the still scene without windows over it, which is shown to nobody, to know what it looks like. */
static stilb_result frame_keep_scene(stilb_engine *engine)
{
	PROFILE("keep the scene");
	stilb_image image = {0};
	stilb_result result = engine_frame_again(engine, true);
	if (result == STILB_OK)
		result = stilb_render_read_image(engine->render, &image);
	if (result == STILB_OK)
		result = engine_picture_keep_scene(engine, &image);
	stilb_image_finish(&image);
	return result;
}

/* While nothing is known of the light: draws a frame of it that nobody sees, and takes the exposure that suits it. */
static stilb_result frame_look(stilb_engine *engine)
{
	bool counted = engine->views[0].show == STILB_RENDER_SHOW_SHADED && !engine->picture.hides_scene;
	if (!engine->scene || !counted || !stilb_post_is_blind(engine->post))
		return STILB_OK;
	PROFILE("look at the light");
	float before = stilb_post_exposure(engine->post);
	stilb_result result = record(engine);
	if (result == STILB_OK)
		result = replay(engine);
	if (result == STILB_OK)
		result = stilb_post_look(engine->post);
	for (uint32_t v = 0; v < engine->view_count; v++)
		engine->views[v].exposure += stilb_post_exposure(engine->post) - before;
	return result == STILB_OK ? frame_begin(engine) : result;
}

/* The device has got the frame of the scene. */
static void engine_scene_drawn(stilb_engine *engine)
{
	engine_cameras_drawn(engine);
	engine_shadows_drawn(engine);
}

static stilb_result frame_stages(stilb_engine *engine, stilb_engine_times *times)
{
	PROFILE_COLOR("frame", 0x7f8ea3); /* grey, so that the stages in it stand out */
	double begin, looked;
	uint64_t clock = stilb_time_ns(), start = clock;
	stilb_result result = frame_begin(engine);
	frame_clock(&clock, &begin);
	if (result == STILB_OK)
		result = update_scene(engine);
	frame_clock(&clock, &times->update);
	if (result == STILB_OK)
		result = cull(engine);
	frame_clock(&clock, &times->cull);
	if (result == STILB_OK)
		result = frame_look(engine);
	frame_clock(&clock, &looked);
	if (result == STILB_OK)
		result = record(engine);
	frame_clock(&clock, &times->record);
	if (result == STILB_OK)
		result = ui(engine);
	if (result == STILB_OK)
		result = picture(engine);
	frame_clock(&clock, &times->ui);
	if (result == STILB_OK)
		result = debug(engine);
	if (result == STILB_OK)
		result = replay(engine);
	if (result == STILB_OK)
		engine_value_frame(engine);
	if (result == STILB_OK)
		engine_counts_frame(engine);
	if (result == STILB_OK && engine->scene)
		engine_scene_drawn(engine);
	frame_clock(&clock, &times->replay);
	times->replay += looked;
	times->pad = engine_input_latency(engine);
	if (result == STILB_OK && engine->desc.present)
		result = present(engine);
	frame_clock(&clock, &times->present);
	if (!engine->desc.present)
		times->present = 0.0;
	times->frame = (double)(clock - start) * 1e-6;
	return result;
}

/* Takes what the user has changed in the effects' window. */
static void frame_choose_effects(stilb_engine *engine)
{
	engine_effects *effects = &engine->overlay.effects;
	effects->saves = engine->desc.saves;
	if (!effects->changed)
		return;
	bool adapted = engine->desc.post.exposure_adapts, adapts = effects->chosen.exposure_adapts;
	bool based = engine->exposure_based;
	float base = engine->exposure_base;
	stilb_engine_set_post(engine, &effects->chosen);
	if (adapts)
		engine->exposure_base = adapted ? base : engine->scene ? engine->scene->camera.exposure : 0.0f;
	engine->exposure_based = adapts && (!adapted || based);
	effects->changed = false;
}

stilb_result stilb_engine_frame(stilb_engine *engine, stilb_engine_report *report)
{
	STILB_ASSERT_OWNER(engine->owner);
	STILB_ASSERT(report);
	engine_pictures_tell(engine);
	engine_watch_tell(engine);
	frame_choose_effects(engine);
	engine->report = (stilb_engine_report){.frame = engine->frame, .saves_look = engine->overlay.effects.save};
	engine->overlay.effects.save = false;
	stilb_result result = frame_window(engine, &engine->report);
	if (result == STILB_OK && !engine->report.drawn)
		frame_input(engine, &engine->report);
	if (result == STILB_OK && !engine->report.drawn)
		result = stilb_debug_frame(engine->debug, NULL, 0, engine->seconds, engine->pool, FRAME_OWNER);
	if (result == STILB_OK && engine->report.drawn) {
		engine_profile_frame(engine);
		if (engine_picture_wants_scene(engine))
			result = frame_keep_scene(engine);
		if (result == STILB_OK)
			result = frame_stages(engine, &engine->report.times);
		engine->dumpable = result == STILB_OK && !engine->picture.hides_scene;
		if (engine->dumpable)
			stilb_render_size(engine->render, &engine->culled_size[0], &engine->culled_size[1]);
		engine->report.exposure = engine->views[0].exposure;
		engine->report.visible = engine->visible[0].count;
		engine->report.textures_left = stilb_render_textures_left(engine->render);
		engine->report.cull = engine->visible[0].method;
		engine->report.render = stilb_render_stats_get(engine->render);
		engine->report.times.gpu = engine->report.render.gpu_ms;
		engine_rate_add(&engine->overlay.rate, stilb_time_ns(), engine->report.times.frame);
		engine->report.frame = ++engine->frame;
		engine->seconds =
			frame_by_clock(engine) ? engine->seconds + (double)engine->step : (double)engine->frame / 60.0;
	}
	*report = engine->report;
	return result;
}
