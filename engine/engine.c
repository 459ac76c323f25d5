/* Creates and destroys the engine, and answers what a frame left behind. */
#include "engine_faults.h"
#include "engine_internal.h"

#include "image/image.h"
#include "job_prof/job_prof.h"
#include "profiler/prof.h"
#include "render/device/render_images.h"
#include "render/render_dump.h"

#include <stdlib.h>
#include <string.h>

/* ---- workers ----------------------------------------------------------------------------------------------------- */

/* Lets the renderer and the effects have the pool; NULL: none. */
static void engine_lend_pool(stilb_engine *engine, stilb_job_pool *pool)
{
	if (engine->render)
		stilb_render_set_pool(engine->render, pool);
	if (engine->post)
		stilb_post_set_pool(engine->post, pool);
}

static stilb_result engine_start_workers(stilb_engine *engine, uint32_t workers)
{
	STILB_ASSERT(!engine->pool);
	stilb_job_pool_desc desc = {.worker_count = workers, .hooks = stilb_job_prof_hooks("worker")};
	int error = stilb_job_pool_create(&desc, &engine->pool);
	engine_lend_pool(engine, engine->pool);
	if (error == 0)
		return STILB_OK;
	return stilb_fail_threads(workers, -error);
}

uint32_t stilb_engine_default_workers(void)
{
	return stilb_job_pool_desc_default().worker_count;
}

uint32_t stilb_engine_workers(const stilb_engine *engine)
{
	STILB_ASSERT_OWNER(engine->owner);
	return stilb_job_pool_worker_count(engine->pool);
}

stilb_job_pool *stilb_engine_pool(const stilb_engine *engine)
{
	STILB_ASSERT_OWNER(engine->owner);
	return engine->pool;
}

stilb_job_pool_stats stilb_engine_job_stats(const stilb_engine *engine)
{
	STILB_ASSERT_OWNER(engine->owner);
	stilb_job_pool_stats stats;
	stilb_job_pool_get_stats(engine->pool, &stats);
	return stats;
}

stilb_result stilb_engine_set_workers(stilb_engine *engine, uint32_t workers)
{
	STILB_ASSERT_OWNER(engine->owner);
	engine_lend_pool(engine, NULL);
	stilb_job_pool_destroy(engine->pool);
	engine->pool = NULL;
	stilb_result result = engine_start_workers(engine, workers);
	return result == STILB_OK ? stilb_render_set_context_count(engine->render, workers + 1) : result;
}

/* ---- creation ---------------------------------------------------------------------------------------------------- */

stilb_engine_desc stilb_engine_desc_default(void)
{
	return (stilb_engine_desc){
		.workers = stilb_engine_default_workers(),
		.width = 1280,
		.height = 720,
		.present = true,
		.shading = stilb_render_shading_default(),
		.profile = true,
		.profile_ring_mib = 64,
		.capture = stilb_prof_capture_desc_default(),
		.control = stilb_input_control_settings_default(),
	};
}

static stilb_render_faults engine_faults; /* of the next engines */

void stilb_engine_set_faults(const stilb_render_faults *faults)
{
	engine_faults = faults ? *faults : (stilb_render_faults){0};
}

/* The effect of these settings that has one sample a pixel; NULL: there is none. */
static const char *engine_effect_of_one_sample(const stilb_post_settings *post)
{
	return post->occlusion > 0.0f                            ? "ambient occlusion (post.occlusion)"
	       : post->reflections != STILB_POST_REFLECTIONS_OFF ? "what surfaces mirror (post.reflections)"
	       : post->dof != STILB_POST_DOF_OFF                 ? "depth of field (post.dof)"
	                                                         : NULL;
}

/* True if frames with several samples a pixel would lack something that is asked for. */
static bool engine_is_of_one_sample(const stilb_engine_desc *desc)
{
	return stilb_render_lighting_is_of_one_sample(desc->lighting) || desc->ambient_apart ||
	       engine_effect_of_one_sample(&desc->post) || desc->post.aa == STILB_POST_AA_TEMPORAL ||
	       desc->shadows.kind == STILB_ENGINE_SHADOWS_BUFFER;
}

static stilb_result engine_create_render(stilb_engine *engine)
{
	const stilb_engine_desc *desc = &engine->desc;
	stilb_gpu_surface own = engine->window ? engine_surface_of(engine->window) : (stilb_gpu_surface){0};
	stilb_render_desc render = {
		.device = desc->device,
		.replay = desc->replay,
		.materials = desc->materials,
		.output = desc->output,
		.gpu = desc->gpu,
		.surface = engine->window ? &own : desc->surface,
		.presentation = desc->presentation,
		.width = desc->width,
		.height = desc->height,
		.samples = desc->samples == 0 && engine_is_of_one_sample(desc) ? 1 : desc->samples,
		.max_anisotropy = desc->max_anisotropy,
		.specular_aa = desc->specular_aa,
		.context_count = desc->workers + 1,
		.validate = desc->validate,
		.keep_textures = desc->keep_textures,
		.morph = desc->detail.mode == STILB_RENDER_DETAIL_MORPH,
		.faults = engine_faults,
	};
	return stilb_render_create(&render, &engine->render);
}

/* Fills the engine's tables of views and passes with one view and one pass, "scene". */
static void engine_fill_passes(stilb_engine *engine)
{
	engine->view_count = 1;
	engine->passes[0] = (stilb_render_pass){.name = "scene", .view = 0, .order = 0};
	engine->pass_count = 1;
	engine->place[2] = engine->place[3] = 1.0f;
}

static stilb_result engine_start(stilb_engine *engine)
{
	const stilb_engine_desc *desc = &engine->desc;
	stilb_result result = STILB_OK;
	if (desc->window)
		result = stilb_window_create("Stilb", desc->width, desc->height, &engine->window);
	if (result == STILB_OK)
		result = engine_create_render(engine);
	if (result == STILB_OK)
		result = stilb_debug_create(engine->render, &engine->debug);
	if (result == STILB_OK)
		result = stilb_post_create(engine->render, &engine->post);
	if (result == STILB_OK)
		stilb_post_set(engine->post, &desc->post);
	if (result == STILB_OK)
		result = engine_start_workers(engine, desc->workers);
	engine_fill_passes(engine);
	if (result == STILB_OK)
		result = engine_overlay_start(engine);
	if (result == STILB_OK)
		result = engine_input_start(engine);
	if (result == STILB_OK)
		engine_watch_start(engine);
	return result;
}

static void shadows_assert(const stilb_engine_shadows *shadows)
{
	uint32_t size = shadows->size, samples = shadows->samples;
	STILB_ASSERT((unsigned)shadows->kind < STILB_ENGINE_SHADOWS_COUNT);
	STILB_ASSERT(shadows->cascades <= STILB_SHADOW_MAX_CASCADES);
	STILB_ASSERT((unsigned)shadows->faces < STILB_ENGINE_SHADOW_FACES_COUNT);
	STILB_ASSERT(size == 0 || (size >= STILB_SHADOW_MIN_SIZE && size <= 8192 && (size & (size - 1)) == 0));
	STILB_ASSERT(shadows->distance >= 0.0f && isfinite(shadows->distance));
	STILB_ASSERT(!shadows->objects || shadows->distance > 0.0f);
	bool gathers = shadows->filter == STILB_ENGINE_SHADOW_FILTER_GATHER;
	STILB_ASSERT((unsigned)shadows->filter < STILB_ENGINE_SHADOW_FILTER_COUNT);
	STILB_ASSERT((unsigned)shadows->bias < STILB_ENGINE_SHADOW_BIAS_COUNT);
	STILB_ASSERT(samples == 0 || samples == 1 || samples == 4 ||
	             (gathers ? samples == 16 || samples == 36 : samples == 12));
}

stilb_result stilb_engine_create(const stilb_engine_desc *desc, stilb_engine **out)
{
	STILB_ASSERT(desc && out);
	STILB_ASSERT(desc->scale == 0.0f ||
	             (desc->scale >= STILB_ENGINE_MIN_SCALE && desc->scale <= STILB_ENGINE_MAX_SCALE));
	STILB_ASSERT((unsigned)desc->gamepad <= STILB_ENGINE_GAMEPAD_REPLAY);
	STILB_ASSERT((unsigned)desc->lighting < STILB_RENDER_LIGHTING_WAYS &&
	             (unsigned)desc->deferred.coverage < STILB_RENDER_COVERAGE_WAYS &&
	             (unsigned)desc->deferred.gbuffer < STILB_RENDER_GBUFFER_KINDS &&
	             (unsigned)desc->light_lists < STILB_RENDER_LIGHT_LISTS_WAYS);
	STILB_ASSERT(desc->light_tolerance >= 0.0f && desc->light_tolerance <= 1.0f);
	STILB_ASSERT(desc->light_fade >= 0.0f && isfinite(desc->light_fade));
	STILB_ASSERT((unsigned)desc->ambient < STILB_RENDER_AMBIENT_KINDS && (unsigned)desc->hdr < STILB_RENDER_HDRS);
	STILB_ASSERT(stilb_post_settings_are_valid(&desc->post));
	shadows_assert(&desc->shadows);
	STILB_ASSERT(desc->gamepad != STILB_ENGINE_GAMEPAD_REPLAY || desc->gamepad_recording);
	STILB_ASSERT(!(desc->window && desc->surface) && "one window");
	STILB_ASSERT((unsigned)desc->presentation <= STILB_GPU_PRESENT_IMMEDIATE);
	STILB_ASSERT((unsigned)desc->watch_shaders <= STILB_ENGINE_WATCH_AUTO);
	*out = NULL;
	const char *single = desc->ambient_apart ? "light of the surroundings apart (ambient_apart)"
	                                         : engine_effect_of_one_sample(&desc->post);
	if (single && desc->samples > 1)
		return stilb_fail(STILB_ERROR_ARGUMENT, "%s has one sample a pixel, and %u are asked for", single,
		                  desc->samples);
	if (desc->shadows.kind == STILB_ENGINE_SHADOWS_BUFFER && desc->samples > 1)
		return stilb_fail(STILB_ERROR_ARGUMENT, "a buffer of shadows has one sample a pixel, and %u are asked for",
		                  desc->samples);
	stilb_engine *engine = calloc(1, sizeof *engine);
	if (!engine)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the engine");
	stilb_owner_take(&engine->owner);
	engine->desc = *desc;
	engine->shading = desc->shading;
	engine->playing.pace = 1.0f;
	stilb_result result = stilb_engine_table(desc, &engine->actions);
	if (result == STILB_OK)
		result = engine_profile_start(engine);
	if (result == STILB_OK)
		result = engine_start(engine);
	if (result != STILB_OK) {
		stilb_engine_destroy(engine);
		return result;
	}
	*out = engine;
	return STILB_OK;
}

void stilb_engine_destroy(stilb_engine *engine)
{
	if (!engine)
		return;
	STILB_ASSERT_OWNER(engine->owner);
	stilb_engine_pictures_wait(engine);
	engine_pictures_destroy(engine->pictures); /* their thread ends while the profiler is there, as the workers do */
	engine_watch_finish(engine);
	engine_prepare_drop(&engine->prepare);
	engine_prepare_drop(&engine->compiling);
	engine_profile_stop_capture(engine); /* before the workers end, whose records it may still write */
	engine_input_finish(&engine->input);
	engine_lend_pool(engine, NULL);
	stilb_job_pool_destroy(engine->pool);
	for (uint32_t v = 0; v < ENGINE_MAX_VIEWS; v++)
		stilb_cull_visible_finish(&engine->visible[v]);
	stilb_cull_destroy(engine->cull);
	stilb_scene_pick_index_destroy(engine->pick_index);
	engine_picture_finish(engine);
	engine_shadows_finish(&engine->shadows);
	if (engine->render)
		engine_value_forget(engine);
	if (engine->render)
		engine_counts_forget(engine);
	engine_overlay_finish(&engine->overlay);
	stilb_post_destroy(engine->post);
	stilb_debug_destroy(engine->debug);
	stilb_render_destroy(engine->render);
	stilb_window_destroy(engine->window);
	engine_profile_stop(engine);
	free(engine);
}

stilb_result stilb_engine_wait(stilb_engine *engine, double *gpu_ms)
{
	STILB_ASSERT_OWNER(engine->owner);
	STILB_ASSERT(gpu_ms);
	stilb_result result = stilb_render_wait(engine->render);
	*gpu_ms = stilb_render_stats_get(engine->render).gpu_ms;
	return result;
}

/* ---- the scene --------------------------------------------------------------------------------------------------- */

stilb_result stilb_engine_set_scene(stilb_engine *engine, stilb_scene *scene)
{
	STILB_ASSERT_OWNER(engine->owner);
	stilb_cull *cull = NULL;
	stilb_render_prepared *made = NULL;
	stilb_result result = STILB_OK;
	if (engine_prepare_is_of(engine->prepare, scene)) {
		result = engine_prepare_take(&engine->prepare, &cull, &made);
	} else {
		if (scene)
			stilb_scene_changes_read(scene); /* bounds that follow from changed meshes */
		result = scene ? stilb_cull_create(scene, &cull) : STILB_OK;
		stilb_render_set_textures(engine->render, engine_textures_now(engine));
		if (result == STILB_OK)
			result = stilb_render_set_scene(engine->render, scene);
	}
	if (result == STILB_OK && made)
		stilb_render_show_scene(engine->render, made);
	if (result != STILB_OK) {
		stilb_cull_destroy(cull);
		return result;
	}
	if (scene)
		stilb_scene_changes_clear(scene);
	stilb_cull_destroy(engine->cull);
	engine->cull = cull;
	engine->scene = scene;
	stilb_post_forget(engine->post);
	if (engine->exposure_based)
		engine->exposure_base = scene ? scene->camera.exposure : 0.0f;
	engine->peak.known = false;
	engine->playing.seconds = engine->seconds;
	engine->playing.step = 0.0;
	stilb_scene_pick_index_clear(engine->pick_index);
	if (!scene)
		engine_picture_finish(engine);
	engine_picture_forget_scene(engine);
	engine->culled_size[0] = 0;
	for (uint32_t v = 0; v < ENGINE_MAX_VIEWS; v++)
		engine->visible[v].count = 0; /* they are of the scene before */
	for (uint32_t v = 0; v < ENGINE_MAX_VIEWS; v++)
		engine->lasts[v].known = false;
	engine->panorama = scene ? scene->surroundings.panorama.pixels : NULL;
	engine->dumpable = false; /* the views have the lights of the scene before */
	engine_shadows_forget(&engine->shadows);
	engine->overlay.lights.picked = engine->overlay.lights.list.selected = STILB_UI_NO_ROW;
	engine->overlay.lights.solo = false;
	return STILB_OK;
}

stilb_scene *stilb_engine_scene(const stilb_engine *engine)
{
	STILB_ASSERT_OWNER(engine->owner);
	return engine->scene;
}

/* ---- what a frame left behind ------------------------------------------------------------------------------------ */

uint64_t stilb_engine_stream_hash(const stilb_engine *engine)
{
	STILB_ASSERT_OWNER(engine->owner);
	return stilb_render_stream_hash(engine->render);
}

uint64_t stilb_engine_triangles(const stilb_engine *engine)
{
	STILB_ASSERT_OWNER(engine->owner);
	return stilb_render_triangles(engine->render);
}

stilb_result stilb_engine_screenshot(stilb_engine *engine, const char *path)
{
	STILB_ASSERT_OWNER(engine->owner);
	STILB_ASSERT(path);
	PROFILE("screenshot"); /* longer than most frames: the profiler shall show why the next frame is late */
	stilb_image image = {0};
	stilb_result result;
	{
		PROFILE("read the picture back");
		result = stilb_render_read_for_file(engine->render, path, &image);
	}
	if (result == STILB_OK) {
		PROFILE("write the picture");
		stilb_scene_look look = engine_look(&engine->views[0]);
		result = stilb_scene_look_save(&look, &image, path);
	}
	stilb_image_finish(&image);
	return result;
}

stilb_result stilb_engine_dump(stilb_engine *engine, const char *path)
{
	STILB_ASSERT_OWNER(engine->owner);
	STILB_ASSERT(path);
	if (!engine->dumpable)
		return stilb_fail(STILB_ERROR_ARGUMENT, "there is no frame to dump: none has been drawn of this scene");
	uint32_t count = engine->camera_count + 1; /* without shadow maps */
	return stilb_render_dump_save(engine->render, engine->passes, count, engine->views, count, path);
}

const char *stilb_engine_device_name(const stilb_engine *engine)
{
	STILB_ASSERT_OWNER(engine->owner);
	return stilb_render_device_name(engine->render);
}

bool stilb_engine_device_is_software(const stilb_engine *engine)
{
	STILB_ASSERT_OWNER(engine->owner);
	return stilb_render_device_is_software(engine->render);
}

uint32_t stilb_engine_samples(const stilb_engine *engine)
{
	STILB_ASSERT_OWNER(engine->owner);
	return stilb_render_samples(engine->render);
}

uint32_t stilb_engine_validation_messages(const stilb_engine *engine)
{
	STILB_ASSERT_OWNER(engine->owner);
	return stilb_render_validation_messages(engine->render);
}

void engine_pick_forget(const stilb_engine *engine, const stilb_scene_changes *changes)
{
	for (uint32_t i = 0; i < changes->mesh_count; i++)
		stilb_scene_pick_index_forget(engine->pick_index, changes->meshes[i]);
	for (uint32_t i = 0; i < changes->vertices_count; i++)
		stilb_scene_pick_index_forget(engine->pick_index, changes->vertices[i].mesh);
}

bool stilb_engine_pick(stilb_engine *engine, double x, double y, stilb_engine_hit *hit)
{
	STILB_ASSERT_OWNER(engine->owner);
	STILB_ASSERT(hit);
	stilb_scene_ray ray;
	if (!engine->scene || !engine_cameras_ray(engine, x, y, &ray))
		return false;
	if (!engine->pick_index)
		engine->pick_index = stilb_scene_pick_index_create();              /* without memory it is slower */
	stilb_scene_changes changes = stilb_scene_changes_read(engine->scene); /* bounds, and what no frame has seen yet */
	engine_pick_forget(engine, &changes);
	return stilb_scene_pick_indexed(engine->scene, &ray, engine->pick_index, hit);
}

stilb_gpu_presentation stilb_engine_presentation(const stilb_engine *engine)
{
	STILB_ASSERT_OWNER(engine->owner);
	return stilb_render_presentation_used(engine->render);
}

void stilb_engine_size(const stilb_engine *engine, uint32_t *width, uint32_t *height)
{
	STILB_ASSERT_OWNER(engine->owner);
	STILB_ASSERT(width && height);
	stilb_render_size(engine->render, width, height);
}

stilb_result stilb_engine_resize(stilb_engine *engine, uint32_t width, uint32_t height)
{
	STILB_ASSERT_OWNER(engine->owner);
	STILB_ASSERT(!engine->window && "the picture follows the window");
	return stilb_render_resize(engine->render, width, height);
}

stilb_result stilb_engine_add_feature(stilb_engine *engine, const stilb_render_feature *feature)
{
	STILB_ASSERT_OWNER(engine->owner);
	return stilb_render_add_feature(engine->render, feature);
}

void stilb_engine_remove_feature(stilb_engine *engine, const void *user)
{
	STILB_ASSERT_OWNER(engine->owner);
	stilb_render_remove_feature(engine->render, user);
}

/* True if the image is the main view's of that name, or another target's. */
static bool engine_image_is(const char *name, const char *image)
{
	size_t all = strlen(name), length = strlen(image);
	return all >= length && strcmp(name + all - length, image) == 0 && (all == length || name[all - length - 1] == ' ');
}

bool stilb_engine_image_is_of_one_sample(const char *name)
{
	return engine_image_is(name, STILB_RENDER_IMAGE_AMBIENT) || engine_image_is(name, STILB_RENDER_IMAGE_REFLECTION);
}

void stilb_engine_show_image(stilb_engine *engine, const stilb_render_shown *shown)
{
	STILB_ASSERT_OWNER(engine->owner);
	const char *name = shown && shown->name ? shown->name : "";
	engine->shows_surfaces =
		engine_image_is(name, STILB_RENDER_IMAGE_SURFACE_NORMAL) || engine_image_is(name, STILB_RENDER_IMAGE_ID);
	engine->shows_velocity = engine->shows_surfaces || engine_image_is(name, STILB_RENDER_IMAGE_VELOCITY) ||
	                         engine_image_is(name, STILB_RENDER_IMAGE_VELOCITY_DEPTH);
	engine->shows_ambient = stilb_engine_image_is_of_one_sample(name);
	stilb_render_show_image(engine->render, shown);
}

stilb_gpu *stilb_engine_gpu(stilb_engine *engine)
{
	return stilb_render_gpu(engine->render);
}

stilb_debug *stilb_engine_debug(const stilb_engine *engine)
{
	return engine->debug;
}

const stilb_gpu_plan *stilb_engine_plan(const stilb_engine *engine)
{
	STILB_ASSERT_OWNER(engine->owner);
	return stilb_render_plan(engine->render);
}

stilb_result stilb_engine_save_plan(stilb_engine *engine, const char *path)
{
	STILB_ASSERT_OWNER(engine->owner);
	STILB_ASSERT(path);
	return stilb_gpu_plan_save(stilb_render_plan(engine->render), path);
}

void stilb_engine_set_title(stilb_engine *engine, const char *title)
{
	STILB_ASSERT_OWNER(engine->owner);
	STILB_ASSERT(title);
	if (engine->window)
		stilb_window_title(engine->window, title);
}

stilb_render_shading stilb_engine_shading(const stilb_engine *engine)
{
	STILB_ASSERT_OWNER(engine->owner);
	return engine->shading;
}

void stilb_engine_set_shading(stilb_engine *engine, const stilb_render_shading *shading)
{
	STILB_ASSERT_OWNER(engine->owner);
	STILB_ASSERT(shading);
	engine->shading = *shading;
}

stilb_render_show stilb_engine_shows(const stilb_engine *engine)
{
	STILB_ASSERT_OWNER(engine->owner);
	return engine->desc.show;
}

void stilb_engine_set_shows(stilb_engine *engine, stilb_render_show show)
{
	STILB_ASSERT_OWNER(engine->owner);
	STILB_ASSERT(show < STILB_RENDER_SHOWS);
	engine->desc.show = show;
}

stilb_render_lighting stilb_engine_lighting(const stilb_engine *engine)
{
	STILB_ASSERT_OWNER(engine->owner);
	return engine->desc.lighting;
}

void stilb_engine_set_lighting(stilb_engine *engine, stilb_render_lighting lighting)
{
	STILB_ASSERT_OWNER(engine->owner);
	STILB_ASSERT(lighting < STILB_RENDER_LIGHTING_WAYS);
	engine->desc.lighting = lighting;
}

float stilb_engine_light_tolerance(const stilb_engine *engine)
{
	STILB_ASSERT_OWNER(engine->owner);
	return engine->desc.light_tolerance;
}

void stilb_engine_set_light_tolerance(stilb_engine *engine, float tolerance)
{
	STILB_ASSERT_OWNER(engine->owner);
	STILB_ASSERT(tolerance >= 0.0f && tolerance <= 1.0f);
	engine->desc.light_tolerance = tolerance;
}

stilb_render_ambient stilb_engine_ambient(const stilb_engine *engine)
{
	STILB_ASSERT_OWNER(engine->owner);
	return engine->desc.ambient;
}

void stilb_engine_set_ambient(stilb_engine *engine, stilb_render_ambient ambient)
{
	STILB_ASSERT_OWNER(engine->owner);
	STILB_ASSERT((unsigned)ambient < STILB_RENDER_AMBIENT_KINDS);
	engine->desc.ambient = ambient;
}

stilb_post_settings stilb_engine_post(const stilb_engine *engine)
{
	STILB_ASSERT_OWNER(engine->owner);
	return engine->desc.post;
}

void stilb_engine_set_post(stilb_engine *engine, const stilb_post_settings *settings)
{
	STILB_ASSERT_OWNER(engine->owner);
	const char *single = engine_effect_of_one_sample(settings);
	if (single && single != engine_effect_of_one_sample(&engine->desc.post) && stilb_render_samples(engine->render) > 1)
		stilb_log("%s has one sample a pixel, and frames have %u: they are without it", single,
		          stilb_render_samples(engine->render));
	stilb_post_set(engine->post, settings);
	engine->desc.post = *settings;
	engine->exposure_base = 0.0f;
	engine->exposure_based = false;
}

stilb_result stilb_engine_set_grade(stilb_engine *engine, const stilb_post_table *table, const stilb_post_area *areas,
                                    uint32_t area_count)
{
	STILB_ASSERT_OWNER(engine->owner);
	return stilb_post_set_grade(engine->post, table, areas, area_count);
}

uint32_t stilb_engine_libraries(stilb_engine_library libraries[STILB_ENGINE_LIBRARIES])
{
	STILB_ASSERT(libraries);
	libraries[0] = (stilb_engine_library){"Vulkan loader", stilb_gpu_vulkan_version()};
	libraries[1] = (stilb_engine_library){"GLFW", stilb_window_library_version()};
	return STILB_ENGINE_LIBRARIES;
}
