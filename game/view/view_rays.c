#include "view_rays.h"

#include "game/render/render_progress.h"
#include "view.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define RAYS_SAMPLES 64u        /* of a picture without a window, unless --spp is given */
#define RAYS_MAX_SAMPLES 65536u /* in a window */
#define RAYS_REST_NS 150000000u /* so long must what is seen be still before rays begin */
#define RAYS_LOOK_NS 100000000u /* between two copies of their picture */
#define RAYS_FRAME_NS 33000000u /* between two frames while rays are shown */
#define RAYS_COARSEST 8u        /* side of the blocks that are shown at first */
#define RAYS_ENDLESS 1e9        /* seconds: with a limit of time, the first samples of all pixels are there soon */
#define RAYS_TICK_NS 20000000   /* between two looks at a picture that frames wait for */

view_rays view_rays_default(void)
{
	return (view_rays){.flags = rays_flags_default(), .split = NAN};
}

void view_rays_add(view_rays *rays, flag_rows *table)
{
	const flag title[] = {{"Rays beside the frames", FLAG_TITLE, NULL, NULL, NULL, 0, 0, NULL}};
	const flag rows[] = {
		{"--split", FLAG_AMOUNT, &rays->split, "X", "path traced right of this share of the width, 0..1; 0: all of it",
	     0, 1, NULL},
		{"--spp", FLAG_NUMBER, &rays->spp, "N", "samples a pixel of the rays, 1..65536 (64; in a window 65536)", 1,
	     RAYS_MAX_SAMPLES, NULL},
	};
	flag_rows_add(table, title, 1);
	flag_rows_add(table, rows, sizeof rows / sizeof *rows);
	rays_flags_add(&rays->flags, RAYS_INTEGRATOR, table);
}

/* True if frames show a channel that rays do not have, which *name is then. */
static bool rays_lack(stilb_render_show show, const char **name)
{
	stilb_scene_surface_channel channel;
	*name = stilb_render_show_names[show];
	return stilb_render_show_channel(show, &channel) && channel >= STILB_SCENE_CHANNELS_OF_RAYS;
}

bool view_rays_check(const view *v)
{
	const char *name;
	stilb_render_show show;
	picture_shown image;
	picture_flags_show(&v->options.picture, &show, &image);
	const view_rays *rays = &v->rays;
	bool split = !isnan(rays->split), headless = v->options.headless;
	if (split && v->options.picture.device == STILB_RENDER_DEVICE_NULL)
		stilb_log("--split: the null device draws no picture; use --device vulkan");
	else if (split && rays_lack(show, &name))
		stilb_log("--show %s: rays have none; leave out --split", name);
	else if (headless && !split && rays->spp > 0)
		stilb_log("--spp: without a window only --split X has rays; give it, too");
	else if (rays->flags.integrator == STILB_GI_INTEGRATOR_IRRADIANCE_CACHE)
		stilb_log("--integrator: the irradiance cache has no place beside frames; 'stilb render' has it");
	else
		return true;
	return false;
}

void view_rays_begin(view_rays *rays)
{
	rays->on = !isnan(rays->split);
	rays->from = rays->on ? rays->split : 0.0f;
}

/* ---- what is seen ------------------------------------------------------------------------------------------------ */

static view_seen rays_seen(const view *v)
{
	stilb_render_shading shading = stilb_engine_shading(v->run->engine);
	uint32_t width, height;
	stilb_engine_size(v->run->engine, &width, &height);
	return view_seen_read(v->scene, &shading, stilb_engine_shows(v->run->engine), width, height);
}

/* The settings of `stilb render` with the same flags, so that it gives the same bits. */
static stilb_gi_settings rays_settings(const view *v)
{
	const view_rays *rays = &v->rays;
	const stilb_render_shading *shading = &rays->seen.shading;
	rays_flags flags = rays->flags;
	flags.shadows = v->options.picture.shadows != STILB_ENGINE_SHADOWS_OFF;
	stilb_scene_surface_channel channel;
	if (stilb_render_show_channel(rays->seen.show, &channel) && channel < STILB_SCENE_CHANNELS_OF_RAYS) {
		flags.integrator = STILB_GI_INTEGRATOR_CHANNEL;
		flags.channel = (int)channel;
	}
	stilb_gi_settings settings = rays_flags_settings(&flags, v->scene);
	settings.width = rays->seen.width;
	settings.height = rays->seen.height;
	settings.model = (shade_brdf_model){(int)shading->brdf, (int)shading->ndf, (int)shading->g, (int)shading->f};
	settings.samples = rays->spp > 0 ? (uint32_t)rays->spp : v->run->window ? RAYS_MAX_SAMPLES : RAYS_SAMPLES;
	if (v->run->window)
		settings.seconds = RAYS_ENDLESS;
	return settings;
}

/* ---- life -------------------------------------------------------------------------------------------------------- */

/* Shows frames again. */
static void rays_hide(view *v)
{
	if (v->rays.shown)
		stilb_engine_show(v->run->engine, NULL);
	v->rays.shown = v->rays.whole = false;
}

void view_rays_forget(view *v)
{
	rays_hide(v);
	view_trace_end(v->rays.trace);
	v->rays.trace = NULL;
	v->rays.held = v->rays.asked = false;
	v->rays.paused_ns = 0;
	v->rays.changed_ns = stilb_time_ns();
}

void view_rays_hold(view *v)
{
	rays_hide(v);
	v->rays.asked = false;
	v->rays.paused_ns = 0;
	v->rays.changed_ns = stilb_time_ns();
	if (!v->rays.trace || v->rays.held)
		return;
	view_trace_hold(v->rays.trace);
	v->rays.held = true;
}

void view_rays_give_way(view *v)
{
	v->rays.plays = v->scene && stilb_scene_play_counts_of(v->scene).sampled > 0;
	v->rays.edits = v->scene && stilb_engine_lights_shown(v->run->engine);
	if (v->rays.plays || v->rays.edits)
		view_rays_hold(v);
}

/* After edits, which view_rays_hold came before: brings the tracer up to date. */
static void rays_take_edits(view *v, const view_seen *seen)
{
	view_rays *rays = &v->rays;
	if (rays->held) {
		rays->held = false;
		rays->begun_ns = stilb_time_ns();
		view_trace_follow(rays->trace);
		return;
	}
	bool same = view_seen_same_scene(seen, &rays->seen);
	STILB_ASSERT((same || !rays->trace) && "view_rays_hold comes before edits");
	if (!same)
		view_rays_forget(v);
}

static void rays_turn_off(view *v)
{
	view_rays_forget(v);
	stilb_engine_caption(v->run->engine, NULL);
	v->rays.on = false;
}

/* Gives the window back. The tree stays, and the picture. */
static void rays_pause(view *v)
{
	view_rays *rays = &v->rays;
	rays_hide(v);
	if (rays->trace)
		view_trace_rest(rays->trace);
	rays->paused_ns = rays->asked ? stilb_time_ns() : 0;
	rays->on = rays->asked = false;
	stilb_engine_caption(v->run->engine, NULL);
}

/* Goes on with the picture at which rays were turned off. False: there is none any more. */
static bool rays_go_on(view_rays *rays, uint64_t now)
{
	uint64_t since = rays->paused_ns;
	rays->paused_ns = 0;
	if (since == 0 || !view_trace_go_on(rays->trace))
		return false;
	rays->begun_ns += now - since;
	rays->looked_ns = 0;
	rays->asked = true;
	return true;
}

void view_rays_switch(view *v)
{
	if (v->rays.on)
		rays_pause(v);
	else
		v->rays.on = true;
}

void view_rays_finish(view *v)
{
	view_trace_end(v->rays.trace);
	free(v->rays.radiance);
	v->rays.trace = NULL;
	v->rays.radiance = NULL;
}

static stilb_result rays_begin(view *v)
{
	view_rays *rays = &v->rays;
	uint32_t workers = v->run->window ? 1 : stilb_engine_default_workers() + 1;
	rays->begun_ns = stilb_time_ns();
	return view_trace_start(v->scene, v->run->window ? stilb_engine_pool(v->run->engine) : NULL, workers,
	                        &stilb_gi_embree, &rays->trace);
}

/* ---- the picture ------------------------------------------------------------------------------------------------- */

/* Shows the rays' picture as far as it is. */
static stilb_result rays_show(view *v, bool anew)
{
	view_rays *rays = &v->rays;
	if (anew && !view_trace_preview(rays->trace, rays->radiance))
		return STILB_OK;
	stilb_engine_shown picture = {.radiance = anew ? rays->radiance : NULL,
	                              .width = rays->seen.width,
	                              .height = rays->seen.height,
	                              .from = &rays->from,
	                              .still = v->run->window && !rays->redraw,
	                              .divider = true};
	rays->looked_ns = anew ? stilb_time_ns() : rays->looked_ns;
	stilb_result result = stilb_engine_show(v->run->engine, &picture);
	rays->shown = result == STILB_OK;
	return result;
}

/* Asks for a picture of what is seen. */
static stilb_result rays_ask(view *v)
{
	view_rays *rays = &v->rays;
	float *radiance = realloc(rays->radiance, (size_t)rays->seen.width * rays->seen.height * 3 * sizeof *radiance);
	if (!radiance)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a picture of %u x %u pixels", rays->seen.width,
		                  rays->seen.height);
	rays->radiance = radiance;
	rays->begun_ns = stilb_time_ns();
	rays->asked = true;
	stilb_gi_settings settings = rays_settings(v);
	view_trace_look(rays->trace, &settings);
	return STILB_OK;
}

static void rays_caption(view *v, view_trace_stage where, const stilb_gi_progress *at)
{
	char text[128], samples[64];
	double seconds = (double)(stilb_time_ns() - v->rays.begun_ns) * 1e-9;
	offline_progress_samples(at, samples, sizeof samples);
	if (where == VIEW_TRACE_BUILDING)
		snprintf(text, sizeof text, "preparing rays, %.1f s", seconds);
	else if (v->rays.shown)
		snprintf(text, sizeof text, "path traced: %s, %.1f s", samples,
		         where == VIEW_TRACE_FINISHED ? at->seconds : seconds);
	else if (v->rays.asked)
		snprintf(text, sizeof text, "path tracing begins");
	else
		snprintf(text, sizeof text, "path traced when the view is still");
	stilb_engine_caption(v->run->engine, text);
}

/* ---- in a window ------------------------------------------------------------------------------------------------- */

/* The pass that is shown first is done. */
static bool rays_are_fine(const stilb_gi_progress *at)
{
	return at->samples > 0 || (at->block > 0 && at->block <= RAYS_COARSEST);
}

static stilb_result rays_follow(view *v, uint64_t now)
{
	view_rays *rays = &v->rays;
	stilb_gi_progress at = {0};
	stilb_result result = STILB_OK;
	if (!rays->trace)
		result = rays_begin(v);
	if (result != STILB_OK)
		return result;
	view_trace_stage where = view_trace_state(rays->trace, &at);
	if (where == VIEW_TRACE_FAILED) {
		const char *message;
		stilb_result failed = view_trace_error(rays->trace, &message);
		return stilb_fail(failed, "%s", message);
	}
	if (rays_go_on(rays, now))
		where = view_trace_state(rays->trace, &at);
	if (!rays->asked && where != VIEW_TRACE_BUILDING && now - rays->changed_ns >= RAYS_REST_NS)
		return rays_ask(v);
	bool finished = rays->asked && where == VIEW_TRACE_FINISHED;
	if (rays->asked && rays_are_fine(&at) && !rays->whole && (finished || now - rays->looked_ns >= RAYS_LOOK_NS)) {
		result = rays_show(v, true);
		rays->whole = finished && result == STILB_OK;
	} else if (rays->shown) {
		result = rays_show(v, false);
	}
	rays_caption(v, where, &at);
	return result;
}

static void rays_in_window(view *v)
{
	view_rays *rays = &v->rays;
	uint64_t now = stilb_time_ns();
	view_seen seen = rays_seen(v);
	const char *name;
	if (rays_lack(seen.show, &name)) {
		char text[64];
		view_rays_hold(v);
		snprintf(text, sizeof text, "%s is of frames alone", name);
		stilb_engine_caption(v->run->engine, text);
		return;
	}
	if (rays->plays || rays->edits) {
		stilb_engine_caption(v->run->engine, rays->plays ? "playing; path traced when paused"
		                                                 : "lights are open; path traced when their window is closed");
		return;
	}
	rays_take_edits(v, &seen);
	rays->redraw = !view_seen_same_frame(&seen, &rays->seen);
	if (!view_seen_same_rays(&seen, &rays->seen)) {
		rays->changed_ns = now;
		rays->paused_ns = 0;
		rays->asked = false;
		rays_hide(v);
		if (rays->trace)
			view_trace_rest(rays->trace);
	}
	rays->seen = seen;
	stilb_result result = rays_follow(v, now);
	if (result == STILB_OK)
		return;
	stilb_log("%s; frames are shown again", stilb_error_message());
	stilb_engine_tell(v->run->engine, stilb_error_message());
	rays_turn_off(v);
}

void view_rays_wait(view *v)
{
	uint64_t now = stilb_time_ns(), since = now - v->rays.frame_ns;
	if (v->rays.on && v->rays.asked && v->run->window && since < RAYS_FRAME_NS)
		nanosleep(&(struct timespec){.tv_nsec = (long)(RAYS_FRAME_NS - since)}, NULL); /* a signal ends it */
	/* The next frame reads its input when the device has drawn all that was read before. An error comes with it. */
	double gpu_ms;
	if (v->rays.on && v->run->window)
		stilb_engine_wait(v->run->engine, &gpu_ms);
	v->rays.frame_ns = stilb_time_ns();
}

/* ---- without a window -------------------------------------------------------------------------------------------- */

/* Says how far the rays' picture was when a signal came. */
static void rays_say_cut(const view *v, const stilb_gi_progress *at)
{
	char samples[64];
	FILE *out = live_message_stream(&v->options);
	offline_progress_samples(at, samples, sizeof samples);
	if (at->pass_count > 0)
		fprintf(out, "rays stopped early: of %u samples the picture has %s\n", rays_settings(v).samples, samples);
	else
		fputs("rays stopped before they began: the picture shows frames alone\n", out);
	fflush(out);
}

/* Waits until the picture is finished, or a signal has come. */
static stilb_result rays_await(const view *v, stilb_gi_progress *at)
{
	offline_progress progress;
	view_trace_stage where;
	offline_progress_begin(&progress);
	for (;;) {
		where = view_trace_state(v->rays.trace, at);
		if (where == VIEW_TRACE_FINISHED || where == VIEW_TRACE_FAILED || live_run_is_stopped())
			break;
		offline_progress_show(&progress, where == VIEW_TRACE_BUILDING ? RENDER_BUILDING : RENDER_RENDERING, at);
		nanosleep(&(struct timespec){.tv_nsec = RAYS_TICK_NS}, NULL);
	}
	if (progress.terminal)
		offline_progress_clear();
	if (where != VIEW_TRACE_FAILED && where != VIEW_TRACE_FINISHED)
		rays_say_cut(v, at);
	if (where != VIEW_TRACE_FAILED)
		return STILB_OK;
	const char *message;
	stilb_result failed = view_trace_error(v->rays.trace, &message);
	return stilb_fail(failed, "%s", message);
}

static stilb_result rays_headless(view *v)
{
	view_rays *rays = &v->rays;
	stilb_gi_progress at = {0};
	view_seen seen = rays_seen(v);
	if (rays->shown && !rays->held && view_seen_same_rays(&seen, &rays->seen))
		return rays_show(v, false);
	rays_take_edits(v, &seen);
	rays->seen = seen;
	stilb_result result = rays->trace ? STILB_OK : rays_begin(v);
	if (result == STILB_OK)
		result = rays_ask(v);
	if (result == STILB_OK)
		result = rays_await(v, &at);
	if (result == STILB_OK && at.pass_count > 0)
		result = rays_show(v, true);
	return result;
}

stilb_result view_rays_frame(view *v, uint64_t frame)
{
	view_rays *rays = &v->rays;
	if (!v->scene)
		return STILB_OK;
	if (v->run->window && rays->on)
		rays_in_window(v);
	if (v->run->lost && rays->on)
		rays_turn_off(v);
	if (v->run->window)
		return STILB_OK;
	/* Of a run of many frames the last one is what remains, or each of them is saved. */
	uint64_t wanted = live_run_wanted(v->run);
	bool saved = wanted == 0 || frame == wanted || v->options.pictures > 0;
	return rays->on && saved ? rays_headless(v) : STILB_OK;
}
