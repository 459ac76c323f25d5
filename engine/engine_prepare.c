/*
 * What a thread makes ready beside the frames: a scene that will be shown, or pipelines for other formulas. There is
 * one thread for each, started when it is needed, which ends when it is done.
 */
#include "engine_internal.h"

#include "shading/shade_tonemap.h"

#include "profiler/prof.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct engine_prepare {
	stilb_render *render;
	const stilb_scene *scene;     /* NULL: only pipelines */
	stilb_render_view view;       /* whose pipelines are made; its lights are the scene's, or the copy */
	stilb_engine_shadows shadows; /* how its maps are drawn */
	stilb_scene_light *lights;
	pthread_t thread;
	_Atomic int speed;  /* stilb_render_speed, set by the main thread; relaxed: nothing else depends on it */
	_Atomic float done; /* set by the thread, read by the main thread; relaxed: it is only told */
	/* Set by the thread: release, and acquire where it is read, so that the outcome is seen, too. */
	atomic_bool ended;
	/* The outcome, written by the thread and read after `ended` or joining it. */
	stilb_result result;
	char message[1024];
	stilb_cull *cull;
	stilb_render_prepared *made;
};

/* ---- the thread -------------------------------------------------------------------------------------------------- */

static stilb_render_speed prepare_pace(void *user, float done)
{
	engine_prepare *prepare = user;
	atomic_store_explicit(&prepare->done, done, memory_order_relaxed); /* partner: stilb_engine_prepared */
	return (stilb_render_speed)atomic_load_explicit(&prepare->speed, memory_order_relaxed); /* partner: prepare_end */
}

/* Compiles what the view, its reference and its shadow maps need. */
static stilb_result prepare_views(const engine_prepare *prepare)
{
	stilb_result result = stilb_render_prepare_view(prepare->render, &prepare->view);
	if (result == STILB_OK && prepare->view.show == STILB_RENDER_SHOW_ERROR) {
		stilb_render_view reference = prepare->view;
		engine_reference_view(&reference);
		result = stilb_render_prepare_view(prepare->render, &reference);
	}
	if (result != STILB_OK || !prepare->view.shadows)
		return result;
	stilb_render_target target = {.kind = STILB_RENDER_TARGET_DEPTH};
	stilb_render_view map = engine_shadows_view(&prepare->view, &prepare->shadows);
	map.target = &target;
	return stilb_render_prepare_view(prepare->render, &map);
}

static void *prepare_run(void *user)
{
	engine_prepare *prepare = user;
	stilb_prof_thread_begin("prepare");
	pthread_setname_np(pthread_self(), "prepare");
	stilb_result result = prepare_views(prepare);
	if (result == STILB_OK && prepare->scene)
		result = stilb_cull_create(prepare->scene, &prepare->cull);
	if (result == STILB_OK && prepare->scene)
		result = stilb_render_prepare_scene(prepare->render, prepare->scene, prepare_pace, prepare, &prepare->made);
	if (result == STILB_OK && prepare->scene && prepare->scene->surface_count > 0)
		result = prepare_views(prepare); /* its surfaces are known now */
	prepare->result = result;
	if (result != STILB_OK)
		snprintf(prepare->message, sizeof prepare->message, "%s", stilb_error_message());
	stilb_prof_thread_end();
	atomic_store_explicit(&prepare->ended, true, memory_order_release); /* partner: prepare_has_ended */
	return NULL;
}

static bool prepare_has_ended(const engine_prepare *prepare)
{
	return atomic_load_explicit(&prepare->ended, memory_order_acquire); /* partner: prepare_run */
}

/* ---- life -------------------------------------------------------------------------------------------------------- */

/* Starts a thread. *out is NULL on failure. */
static stilb_result prepare_start(stilb_engine *engine, const stilb_scene *scene, const stilb_render_view *view,
                                  engine_prepare **out)
{
	*out = NULL;
	engine_prepare *prepare = calloc(1, sizeof *prepare);
	stilb_scene_light *lights = calloc(view->light_count + 1u, sizeof *lights);
	if (!prepare || !lights) {
		free(prepare);
		free(lights);
		return stilb_fail(STILB_ERROR_MEMORY, "no memory to prepare a scene");
	}
	prepare->render = engine->render;
	prepare->scene = scene;
	prepare->shadows = engine->desc.shadows;
	prepare->view = *view;
	for (uint32_t i = 0; i < view->light_count; i++)
		lights[i] = view->lights[i]; /* the program may change its own meanwhile */
	prepare->view.lights = prepare->lights = lights;
	prepare->view.surfaces = engine_draws_surfaces(engine);
	prepare->view.ids = engine_draws_ids(engine);
	if (engine_draws_velocity(engine))
		prepare->view.last = &prepare->view.view_projection; /* it is not read */
	if (engine->desc.shadows.kind != STILB_ENGINE_SHADOWS_OFF && view->light_count > 0)
		prepare->view.shadows = &engine->shadows.shadows; /* there are some; they are not read */
	int error = engine_thread_start(&prepare->thread, prepare_run, prepare);
	if (error != 0) {
		free(lights);
		free(prepare);
		return stilb_fail_threads(1, error);
	}
	*out = prepare;
	return STILB_OK;
}

/* Waits for the thread, and frees all but its outcome. */
static void prepare_end(engine_prepare *prepare, stilb_render_speed speed)
{
	atomic_store_explicit(&prepare->speed, speed, memory_order_relaxed); /* partner: prepare_pace */
	pthread_join(prepare->thread, NULL);
	free(prepare->lights);
}

void engine_prepare_drop(engine_prepare **prepare)
{
	if (!*prepare)
		return;
	prepare_end(*prepare, STILB_RENDER_GIVE_UP);
	stilb_cull_destroy((*prepare)->cull);
	stilb_render_drop_scene((*prepare)->render, (*prepare)->made);
	free(*prepare);
	*prepare = NULL;
}

/* ---- views ------------------------------------------------------------------------------------------------------- */

stilb_render_view engine_view_of(const stilb_engine *engine, const stilb_scene *scene)
{
	static const stilb_render_dither dithers[STILB_POST_DITHERS_COUNT] = {
		[STILB_POST_DITHER_ORDERED] = STILB_RENDER_DITHER_ORDERED,
		[STILB_POST_DITHER_TRIANGULAR] = STILB_RENDER_DITHER_TRIANGULAR,
		[STILB_POST_DITHER_OFF] = STILB_RENDER_DITHER_OFF,
	};
	stilb_render_view view = {
		.surroundings = scene->surroundings,
		.backdrop = scene->backdrop,
		.lights = scene->lights,
		.light_count = scene->light_count,
		.lighting = engine->desc.lighting,
		.deferred = engine->desc.deferred,
		.light_lists = engine->desc.light_lists,
		.light_tolerance = engine->desc.light_tolerance,
		.light_fade = engine->desc.light_fade,
		.ambient = engine->desc.ambient,
		.shadow_reading = engine_shadows_reading(engine),
		.ambient_apart = engine->desc.ambient_apart || engine->shows_ambient || engine->desc.post.occlusion > 0.0f ||
	                     engine->desc.post.reflections != STILB_POST_REFLECTIONS_OFF,
		.mirrors = engine->desc.post.reflections != STILB_POST_REFLECTIONS_OFF,
		.shading = engine->shading,
		.both_sides = scene->both_sides,
		.impostors = scene->impostor_count > 0,
		.exposure = scene->camera.exposure - engine->exposure_base + stilb_post_exposure(engine->post),
		.time = (float)engine->seconds,
		.tone = scene->camera.tone,
		.grade = stilb_post_grade(engine->post),
		.dither = dithers[engine->desc.post.dither],
		.hdr = engine->desc.hdr,
		.detail = engine->desc.detail,
		.show = engine->desc.show,
	};
	uint32_t solo;
	if (scene == engine->scene && engine_lights_solo(engine, &solo)) {
		view.lights += solo;
		view.light_count = 1;
	}
	stilb_scene_surface_channel channel;
	if (stilb_render_show_channel(view.show, &channel)) { /* a picture of rays over it is shown the same way */
		view.exposure = 0.0f;
		view.tone = SHADE_TONE_NONE;
	}
	memcpy(view.camera_position, scene->camera.position, sizeof view.camera_position);
	return view;
}

void engine_reference_view(stilb_render_view *view)
{
	bool few = view->light_count <= ENGINE_FORWARD_LIGHTS;
	view->lighting = few ? STILB_RENDER_LIGHTING_FORWARD : STILB_RENDER_LIGHTING_CLUSTERED;
	view->light_lists = STILB_RENDER_LIGHT_LISTS_JOBS;
	view->light_tolerance = 0.0f;
	view->ambient_apart = view->mirrors = view->surfaces = view->ids = view->shadow_reading.buffer = false;
	view->last = NULL;
	view->hdr = STILB_RENDER_HDR_HALF;
	view->show = STILB_RENDER_SHOW_SHADED;
}

stilb_render_textures engine_textures_now(const stilb_engine *engine)
{
	bool watched = engine->window || engine->desc.surface;
	stilb_engine_textures textures = engine->desc.textures;
	if (textures == STILB_ENGINE_TEXTURES_WAIT || (textures == STILB_ENGINE_TEXTURES_AUTO && !watched))
		return STILB_RENDER_TEXTURES_AT_ONCE;
	return watched ? STILB_RENDER_TEXTURES_SPARE : STILB_RENDER_TEXTURES_EVEN;
}

/* ---- a scene ----------------------------------------------------------------------------------------------------- */

stilb_result stilb_engine_prepare(stilb_engine *engine, stilb_scene *scene)
{
	STILB_ASSERT_OWNER(engine->owner);
	STILB_ASSERT(!scene || scene != engine->scene);
	engine_prepare_drop(&engine->prepare);
	if (!scene)
		return STILB_OK;
	stilb_scene_changes_read(scene); /* bounds that follow from changed meshes */
	stilb_render_set_textures(engine->render, engine_textures_now(engine));
	stilb_render_view view = engine_view_of(engine, scene);
	return prepare_start(engine, scene, &view, &engine->prepare);
}

float stilb_engine_prepared(const stilb_engine *engine)
{
	STILB_ASSERT_OWNER(engine->owner);
	const engine_prepare *prepare = engine->prepare;
	if (!prepare || prepare_has_ended(prepare))
		return 1.0f;
	float done = atomic_load_explicit(&prepare->done, memory_order_relaxed); /* partner: prepare_pace */
	return done < 0.999f ? done : 0.999f;
}

bool engine_prepare_is_of(const engine_prepare *prepare, const stilb_scene *scene)
{
	return prepare && scene && prepare->scene == scene;
}

stilb_result engine_prepare_take(engine_prepare **prepare, stilb_cull **cull, stilb_render_prepared **made)
{
	engine_prepare *taken = *prepare;
	*prepare = NULL;
	prepare_end(taken, STILB_RENDER_HURRY);
	stilb_result result = taken->result;
	*cull = taken->cull;
	*made = taken->made;
	if (result != STILB_OK) {
		stilb_cull_destroy(taken->cull);
		*cull = NULL;
		stilb_fail(result, "%s", taken->message);
	}
	free(taken);
	return result;
}

/* ---- formulas ---------------------------------------------------------------------------------------------------- */

static bool formulas_are_same(const engine_formulas *a, const engine_formulas *b)
{
	return a->shading.brdf == b->shading.brdf && a->shading.ndf == b->shading.ndf && a->shading.g == b->shading.g &&
	       a->shading.f == b->shading.f && a->lighting == b->lighting && a->error == b->error;
}

/* The renderer makes a new panorama ready over several frames in a window; meanwhile its pipelines are compiled. */
static void prepare_panorama(stilb_engine *engine)
{
	const void *pixels = engine->scene->surroundings.panorama.pixels;
	if (pixels && pixels != engine->panorama && !engine->compiling) {
		stilb_render_view view = engine_view_of(engine, engine->scene);
		prepare_start(engine, NULL, &view, &engine->compiling); /* on failure the frame makes them, and waits */
	}
	engine->panorama = pixels;
}

engine_formulas engine_prepare_formulas(stilb_engine *engine)
{
	const stilb_render_view *seen = &engine->views[0];
	engine_formulas wanted = {engine->shading, engine->desc.lighting, engine->desc.show == STILB_RENDER_SHOW_ERROR};
	engine_formulas shown = {seen->shading, seen->lighting, seen->show == STILB_RENDER_SHOW_ERROR};
	engine_prepare *compiling = engine->compiling;
	bool watched = engine->window || engine->desc.surface;
	if (compiling && prepare_has_ended(compiling)) { /* what failed fails again in the frame, with its message */
		engine->compiled = (engine_formulas){compiling->view.shading, compiling->view.lighting,
		                                     compiling->view.show == STILB_RENDER_SHOW_ERROR};
		engine_prepare_drop(&engine->compiling);
	}
	if (watched && engine->culled_size[0] > 0)
		prepare_panorama(engine);
	bool waits = watched && engine->culled_size[0] > 0 && !formulas_are_same(&wanted, &shown) &&
	             !formulas_are_same(&wanted, &engine->compiled);
	if (!waits)
		return wanted;
	if (!engine->compiling) {
		stilb_render_view view = engine_view_of(engine, engine->scene);
		if (prepare_start(engine, NULL, &view, &engine->compiling) != STILB_OK)
			return wanted; /* the frame makes it, and waits */
	}
	engine_formulas before = {wanted.shading, shown.lighting, shown.error}; /* its numbers count at once */
	before.shading.brdf = shown.shading.brdf;
	before.shading.ndf = shown.shading.ndf;
	before.shading.g = shown.shading.g;
	before.shading.f = shown.shading.f;
	return before;
}
