/* The shadow maps of a frame: each is a view and a pass of its own, before those of the cameras. All cameras read the
 * maps of the scene's own one. */
#include "engine_internal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SHADOWS_OWNER 0u   /* the worker number of the main thread */
#define SHADOWS_FADE 16.0f /* pixels of a lamp's reach in the picture where its shadow has faded out */
#define SHADOWS_NAMED 8u   /* lights without shadows that a line names */
#define SHADOWS_ERROR 0.5f /* texels by which levels of meshes may be off in maps */
#define SHADOWS_ROOM 1.1f /* of the bounds' radius: what moves stays within for a while, and maps stay where they are */
#define SHADOWS_OBJECT 0.25f /* of the distance: a model's radius at most, of which a map of near things is */
#define SHADOWS_PAGES 64u
#define SHADOWS_BYTES (512u << 20) /* of all pages together, at most */

#define SHADOWS_WORD(id, word, ...) word,
const char *const stilb_engine_shadow_names[] = {STILB_ENGINE_SHADOW_KINDS(SHADOWS_WORD) NULL};
const char *const stilb_engine_shadow_faces_names[] = {STILB_ENGINE_SHADOW_FACES(SHADOWS_WORD) NULL};
const char *const stilb_engine_shadow_bias_names[] = {STILB_ENGINE_SHADOW_BIASES(SHADOWS_WORD) NULL};
const char *const stilb_engine_shadow_filter_names[] = {STILB_ENGINE_SHADOW_FILTERS(SHADOWS_WORD) NULL};

/* ---- the scene's bounds ------------------------------------------------------------------------------------------ */

/* A sphere around all models that are there. False: there is none. */
static bool shadows_bounds_now(const stilb_scene *scene, stilb_sphere *sphere)
{
	const stilb_scene_bounds *bounds = &scene->bounds;
	float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
	for (uint32_t i = 0; i < scene->model_count; i++) {
		const float center[3] = {bounds->x[i], bounds->y[i], bounds->z[i]}, radius = bounds->radius[i];
		if (!isfinite(center[0] + center[1] + center[2] + radius))
			continue;
		for (int c = 0; c < 3; c++) {
			low[c] = fminf(low[c], center[c] - radius);
			high[c] = fmaxf(high[c], center[c] + radius);
		}
	}
	float half[3];
	for (int c = 0; c < 3; c++)
		half[c] = 0.5f * (high[c] - low[c]);
	*sphere = (stilb_sphere){low[0] + half[0], low[1] + half[1], low[2] + half[2],
	                         sqrtf(half[0] * half[0] + half[1] * half[1] + half[2] * half[2])};
	return isfinite(sphere->radius) && sphere->radius > 0.0f;
}

/* Bounds that hold the models, and change only when they must. */
static bool shadows_bounds(engine_shadows *shadows, const stilb_scene *scene)
{
	stilb_sphere now, *kept = &shadows->bounds;
	if (!shadows_bounds_now(scene, &now))
		return false;
	float away = sqrtf((now.x - kept->x) * (now.x - kept->x) + (now.y - kept->y) * (now.y - kept->y) +
	                   (now.z - kept->z) * (now.z - kept->z));
	bool holds = away + now.radius <= kept->radius && kept->radius <= 2.0f * now.radius;
	if (!holds)
		*kept = (stilb_sphere){now.x, now.y, now.z, now.radius * SHADOWS_ROOM};
	return true;
}

/* A sphere around the models near the camera that a map of near things is for; radius 0: there is none. */
static stilb_sphere shadows_near(const stilb_scene *scene, const float eye[3], float distance)
{
	const stilb_scene_bounds *bounds = &scene->bounds;
	float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY}, half[3], most = 0.0f;
	for (uint32_t i = 0; i < scene->model_count; i++) {
		const float center[3] = {bounds->x[i], bounds->y[i], bounds->z[i]}, radius = bounds->radius[i];
		float away = hypotf(hypotf(center[0] - eye[0], center[1] - eye[1]), center[2] - eye[2]);
		if (!(away <= distance) || !(radius <= SHADOWS_OBJECT * distance)) /* or NaN */
			continue;
		for (int c = 0; c < 3; c++) {
			low[c] = fminf(low[c], center[c] - radius);
			high[c] = fmaxf(high[c], center[c] + radius);
		}
	}
	if (!(low[0] <= high[0]))
		return (stilb_sphere){0};
	for (int c = 0; c < 3; c++) {
		half[c] = 0.5f * (high[c] - low[c]);
		most += half[c] * half[c];
	}
	return (stilb_sphere){low[0] + half[0], low[1] + half[1], low[2] + half[2], sqrtf(most)};
}

/* ---- maps that stay ---------------------------------------------------------------------------------------------- */

static stilb_sphere shadows_sphere(const stilb_scene *scene, uint32_t model)
{
	const stilb_scene_bounds *bounds = &scene->bounds;
	return (stilb_sphere){bounds->x[model], bounds->y[model], bounds->z[model], bounds->radius[model]};
}

/* True if what all maps show may be another than in the frame before. */
static bool shadows_all_changed(engine_shadows *shadows, const stilb_engine *engine, const stilb_render_target *target)
{
	stilb_scene *scene = engine->scene;
	stilb_scene_revisions now = stilb_scene_revisions_read(scene), *last = &shadows->revisions;
	bool same = shadows->valid && shadows->scene == scene && now.models == last->models &&
	            now.geometry == last->geometry && now.materials == last->materials && now.textures == last->textures &&
	            now.poses == last->poses && scene->function_count == 0 && !shadows->loading &&
	            scene->impostor_count == shadows->impostor_count &&
	            scene->impostors_removed == shadows->impostors_removed &&
	            memcmp(&engine->views[0].detail, &shadows->detail, sizeof shadows->detail) == 0 &&
	            target->width == shadows->target.width && target->layers == shadows->target.layers;
	shadows->scene = scene;
	shadows->revisions = now;
	shadows->impostor_count = scene->impostor_count;
	shadows->impostors_removed = scene->impostors_removed;
	shadows->detail = engine->views[0].detail;
	shadows->loading = stilb_render_textures_left(engine->render) > 0;
	return !same;
}

static bool shadows_map_has(const stilb_shadow_map *map, const stilb_frustum *frustum, stilb_sphere sphere)
{
	return stilb_frustum_may_see(frustum, sphere) && stilb_shadow_casters_have(map, sphere);
}

/* stilb_job_range_fn: notes of maps begin .. end - 1 those that models have left, entered or moved in. */
static void shadows_note_moved(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	stilb_engine *engine = context;
	engine_shadows *shadows = &engine->shadows;
	const stilb_scene *scene = engine->scene;
	for (uint32_t m = begin; m < end; m++) {
		const stilb_shadow_map *map = &shadows->plan.maps[m];
		stilb_frustum frustum = stilb_frustum_from_matrix(&map->view_projection);
		for (uint32_t i = 0; i < scene->moved_count && shadows->stays[m]; i++) {
			uint32_t model = scene->moved[i]; /* a hidden one's radius is NaN */
			shadows->stays[m] = !shadows_map_has(map, &frustum, shadows_sphere(scene, model)) &&
			                    !shadows_map_has(map, &frustum, shadows->models[model]);
		}
	}
}

/* Where models are now. False: no memory. */
static bool shadows_keep_models(engine_shadows *shadows, const stilb_scene *scene, bool all)
{
	if (!all) {
		for (uint32_t i = 0; i < scene->moved_count; i++)
			shadows->models[scene->moved[i]] = shadows_sphere(scene, scene->moved[i]);
		return true;
	}
	stilb_sphere *models = realloc(shadows->models, (scene->model_count + 1) * sizeof *models);
	if (!models)
		return false;
	shadows->models = models;
	for (uint32_t i = 0; i < scene->model_count; i++)
		models[i] = shadows_sphere(scene, i);
	return true;
}

static bool shadows_map_is(const stilb_shadow_map *now, const stilb_shadow_map *kept, const stilb_shadow_view *view)
{
	return now->page == kept->page && memcmp(now->area, kept->area, sizeof now->area) == 0 &&
	       memcmp(now->eye, kept->eye, sizeof now->eye) == 0 &&
	       memcmp(&now->view_projection, &kept->view_projection, sizeof now->view_projection) == 0 &&
	       stilb_shadow_casters_hold(kept, now, view);
}

/* Finds the maps that need not be drawn: they were drawn before, and nothing in them has changed. */
static stilb_result shadows_find_stays(stilb_engine *engine, const stilb_shadow_view *view,
                                       const stilb_render_target *target)
{
	engine_shadows *shadows = &engine->shadows;
	stilb_shadow_plan *plan = &shadows->plan;
	bool all = shadows_all_changed(shadows, engine, target);
	bool *stays = realloc(shadows->stays, plan->map_count * sizeof *stays);
	shadows->stays = stays ? stays : shadows->stays;
	stilb_shadow_map *kept = realloc(shadows->kept, (plan->map_count + shadows->kept_count) * sizeof *kept);
	shadows->kept = kept ? kept : shadows->kept;
	if (!stays || !kept)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory to keep %u shadow maps", plan->map_count);
	for (uint32_t m = 0; m < plan->map_count; m++) {
		stays[m] = false;
		for (uint32_t k = 0; k < shadows->kept_count && !all && !stays[m]; k++) {
			uint32_t light = plan->maps[m].light;
			stays[m] = shadows_map_is(&plan->maps[m], &kept[k], view);
			if (stays[m])
				plan->maps[m] = kept[k]; /* with the casters that are in it */
			plan->maps[m].light = light;
		}
	}
	if (!all && engine->scene->moved_count > 0)
		stilb_job_parallel_for(engine->pool, plan->map_count, 1, shadows_note_moved, engine, SHADOWS_OWNER);
	if (!shadows_keep_models(shadows, engine->scene, all))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory to keep the places of %u models", engine->scene->model_count);
	memcpy(kept, plan->maps, plan->map_count * sizeof *kept);
	shadows->kept_count = plan->map_count;
	return STILB_OK;
}

/* ---- a frame ----------------------------------------------------------------------------------------------------- */

stilb_engine_shadows stilb_engine_shadows_used(const stilb_engine *engine)
{
	STILB_ASSERT_OWNER(engine->owner);
	stilb_engine_shadows desc = engine->desc.shadows;
	bool software = stilb_render_device_is_software(engine->render);
	if (desc.objects)
		desc.cascades = 1;
	if (desc.cascades == 0)
		desc.cascades = software ? 2 : 4;
	if (desc.size == 0)
		desc.size = software ? 1024 : 2048;
	if (engine->shadows.room > 0 && desc.size > engine->shadows.room)
		desc.size = engine->shadows.room;
	if (desc.samples == 0)
		desc.samples = desc.filter == STILB_ENGINE_SHADOW_FILTER_COMPARE ? 12 : 16;
	return desc;
}

/* Half of the filter's width, texels; 0: it has none. */
static uint32_t shadows_filter(const stilb_engine_shadows *desc)
{
	if (desc->filter == STILB_ENGINE_SHADOW_FILTER_COMPARE) /* the farthest texel that a comparison weighs */
		return desc->samples >= 12 ? 3 : desc->samples >= 4 ? 2 : 1;
	return desc->samples >= 36 ? 3 : desc->samples >= 16 ? 2 : desc->samples >= 4 ? 1 : 0;
}

stilb_render_shadow_reading engine_shadows_reading(const stilb_engine *engine)
{
	stilb_engine_shadows desc = stilb_engine_shadows_used(engine);
	bool all = desc.bias == STILB_ENGINE_SHADOW_BIAS_ALL;
	return (stilb_render_shadow_reading){
		.no_plane = !all && desc.bias != STILB_ENGINE_SHADOW_BIAS_PLANE,
		.no_way = !all && desc.bias != STILB_ENGINE_SHADOW_BIAS_WAY,
		.things = desc.objects,
		.taps = desc.filter == STILB_ENGINE_SHADOW_FILTER_COMPARE ? desc.samples : 0,
		.buffer = desc.kind == STILB_ENGINE_SHADOWS_BUFFER,
	};
}

/* A picture that is mirrored shows the other sides of triangles. */
static void shadows_mirror(stilb_shadow_plan *plan)
{
	for (uint32_t m = 0; m < plan->map_count; m++)
		for (size_t c = 0; c < 16; c += 4)
			plan->maps[m].view_projection.m[c] = -plan->maps[m].view_projection.m[c];
}

stilb_render_view engine_shadows_view(const stilb_render_view *seen, const stilb_engine_shadows *desc)
{
	bool slope = desc->bias == STILB_ENGINE_SHADOW_BIAS_ALL || desc->bias == STILB_ENGINE_SHADOW_BIAS_SLOPE;
	return (stilb_render_view){
		.shadow = true,
		.shadow_flat = !slope,
		.both_sides = desc->faces == STILB_ENGINE_SHADOW_FACES_BOTH,
		.shading = seen->shading,
		.impostors = seen->impostors,
		.detail = {STILB_RENDER_DETAIL_POP, SHADOWS_ERROR}, /* of their own, whatever the cameras have */
		.time = seen->time,
	};
}

/* The view and the pass that draw a map. */
static void shadows_view(stilb_engine *engine, uint32_t number, const stilb_shadow_map *map)
{
	stilb_render_view *view = &engine->views[number];
	*view = engine_shadows_view(&engine->views[0], &engine->desc.shadows);
	view->target = &engine->shadows.target;
	view->view_projection = map->view_projection;
	view->layer = map->page;
	memcpy(view->area, map->area, sizeof view->area);
	memcpy(view->camera_position, map->eye, sizeof view->camera_position);
	engine->passes[number] = (stilb_render_pass){.name = "shadow", .view = number};
}

/* Hands the lights' maps to the views of cameras. STILB_ERROR_MEMORY. */
static stilb_result shadows_hand_on_lights(stilb_engine *engine)
{
	engine_shadows *shadows = &engine->shadows;
	const stilb_shadow_plan *plan = &shadows->plan;
	stilb_render_shadow *lights = realloc(shadows->lights, plan->light_count * sizeof *lights);
	if (!lights)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the shadow maps of %u lights", plan->light_count);
	shadows->lights = lights;
	for (uint32_t l = 0; l < plan->light_count; l++)
		lights[l] = (stilb_render_shadow){plan->lights[l].first, plan->lights[l].count, plan->lights[l].faded};
	for (uint32_t v = 0; v < engine->view_count; v++) /* which has no maps yet */
		engine->views[v].shadows = &shadows->shadows;
	return STILB_OK;
}

/* Lights are there, and none needs a map now: the programs stay those of shadows, since the next frame may need one. */
static stilb_result shadows_hand_on_none(stilb_engine *engine)
{
	stilb_result result = shadows_hand_on_lights(engine);
	engine->shadows.shadows = (stilb_render_shadows){.lights = engine->shadows.lights, .filter = 1};
	return result;
}

/* What the plan's maps are drawn into. */
static stilb_render_target shadows_target(const engine_shadows *shadows, const stilb_engine_shadows *desc)
{
	/* So that the image stays when pages come and go, it grows by doubling, and shrinks when a quarter will do. */
	uint16_t layers = 2, had = shadows->target.width == desc->size ? shadows->target.layers : 0;
	while (layers < shadows->plan.page_count)
		layers *= 2;
	layers = layers < had && layers * 4 > had ? had : layers;
	return (stilb_render_target){.name = STILB_RENDER_IMAGE_SHADOW,
	                             .kind = STILB_RENDER_TARGET_DEPTH,
	                             .width = desc->size,
	                             .height = desc->size,
	                             .layers = layers,
	                             .lasting = true};
}

/* Hands the plan to the views of cameras. */
static stilb_result shadows_hand_on(stilb_engine *engine, const stilb_engine_shadows *desc,
                                    const stilb_shadow_view *view)
{
	engine_shadows *shadows = &engine->shadows;
	const stilb_shadow_plan *plan = &shadows->plan;
	stilb_render_shadow_map *maps = realloc(shadows->maps, plan->map_count * sizeof *maps);
	shadows->maps = maps ? maps : shadows->maps;
	if (!maps)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for %u shadow maps", plan->map_count);
	for (uint32_t m = 0; m < plan->map_count; m++) {
		const stilb_shadow_map *from = &plan->maps[m];
		maps[m] = (stilb_render_shadow_map){
			.view_projection = from->view_projection, .layer = from->page, .blend = from->blend, .far = from->far};
		memcpy(maps[m].area, from->area, sizeof maps[m].area);
	}
	stilb_render_target target = shadows_target(shadows, desc);
	stilb_result result = shadows_hand_on_lights(engine);
	if (result == STILB_OK)
		result = shadows_find_stays(engine, view, &target);
	if (result != STILB_OK)
		return result;
	shadows->target = target;
	shadows->shadows = (stilb_render_shadows){.target = &shadows->target,
	                                          .maps = maps,
	                                          .lights = shadows->lights,
	                                          .map_count = plan->map_count,
	                                          .filter = shadows_filter(desc)};
	shadows->shadows.map_error = SHADOWS_ERROR;
	if (engine->views[0].detail.mode != STILB_RENDER_DETAIL_OFF)
		shadows->shadows.view_error = engine->views[0].detail.error;
	for (uint32_t v = 0; v < engine->view_count; v++) /* which has no maps yet */
		engine->passes[v].order++;                    /* behind the maps */
	return STILB_OK;
}

/* Says once that lights are without shadows, and which. */
static void shadows_tell_left(engine_shadows *shadows, uint32_t pages)
{
	const stilb_shadow_plan *plan = &shadows->plan;
	char names[SHADOWS_NAMED * 12 + 8] = "";
	size_t length = 0;
	if (shadows->told || plan->left_out == 0)
		return;
	shadows->told = true;
	uint32_t named = 0;
	for (uint32_t l = 0; l < plan->light_count && named < SHADOWS_NAMED; l++)
		if (plan->lights[l].left_out)
			length += (size_t)snprintf(names + length, sizeof names - length, "%s%u", named++ > 0 ? ", " : "", l);
	stilb_log("%u lights that are seen cast no shadow (number %s%s): those that are seen smallest, for a frame has at "
	          "most %u shadow maps in %u pages; fewer or smaller --cascades leave more to lamps",
	          plan->left_out, names, named < plan->left_out ? ", ..." : "", ENGINE_MAX_SHADOWS, pages);
}

/* Says once that more lights cast shadows than the buffer holds. */
static void shadows_tell_buffer(engine_shadows *shadows, const stilb_engine_shadows *desc)
{
	uint32_t count = 0;
	if (desc->kind != STILB_ENGINE_SHADOWS_BUFFER || shadows->told_buffer)
		return;
	for (uint32_t l = 0; l < shadows->plan.light_count; l++)
		count += shadows->plan.lights[l].count > 0;
	shadows->told_buffer = count > STILB_RENDER_SHADOW_BUFFER_LIGHTS;
	if (shadows->told_buffer)
		stilb_log("%u lights cast shadows, and a buffer of them holds %u: pixels read the maps", count,
		          STILB_RENDER_SHADOW_BUFFER_LIGHTS);
}

/* Says once what cameras beside the scene's own see of suns' shadows. */
static void shadows_tell_cameras(stilb_engine *engine)
{
	engine_shadows *shadows = &engine->shadows;
	if (shadows->told_cameras || engine->camera_count == 0 || !(engine->desc.shadows.distance > 0.0f))
		return;
	shadows->told_cameras = true;
	stilb_log("shadows of suns end %g m around each camera; others see those alone that are around the scene's own",
	          (double)engine->desc.shadows.distance);
}

/* Plans the maps of a size. */
static stilb_result shadows_plan(stilb_engine *engine, const stilb_engine_shadows *desc, const stilb_shadow_view *view)
{
	const stilb_render_view *seen = &engine->views[0];
	uint32_t pages = SHADOWS_BYTES / (4 * desc->size * desc->size), filter = shadows_filter(desc);
	stilb_shadow_desc plan = {.page = desc->size,
	                          .pages = pages < SHADOWS_PAGES ? pages : SHADOWS_PAGES,
	                          .maps = ENGINE_MAX_SHADOWS,
	                          .cascades = desc->cascades,
	                          .distance = desc->distance,
	                          .objects = desc->objects,
	                          .filter = filter > 0 ? filter : 1,
	                          .fade = fmaxf(SHADOWS_FADE, 2.0f * seen->light_fade),
	                          .keep = true};
	stilb_result result = stilb_shadow_plan_make(&engine->shadows.plan, &plan, view, seen->lights, seen->light_count);
	shadows_tell_left(&engine->shadows, plan.pages);
	return result;
}

/* Plans the maps, and has the device make their image. Where memory is short maps are half as large, from now on. */
static stilb_result shadows_plan_in_room(stilb_engine *engine, stilb_engine_shadows *desc,
                                         const stilb_shadow_view *view)
{
	engine_shadows *shadows = &engine->shadows;
	stilb_result result = shadows_plan(engine, desc, view);
	while (result == STILB_OK && shadows->plan.map_count > 0) {
		stilb_render_target target = shadows_target(shadows, desc);
		result = stilb_render_reserve_target(engine->render, &target);
		if (result != STILB_ERROR_MEMORY || desc->size <= STILB_SHADOW_MIN_SIZE)
			break;
		shadows->valid = false; /* what was in the image has gone */
		desc->size = shadows->room = desc->size / 2;
		stilb_log("%s; shadow maps have %u texels a side now, in place of %u: --cascade-size %u says so from the start",
		          stilb_error_message(), desc->size, 2 * desc->size, desc->size);
		result = shadows_plan(engine, desc, view);
	}
	return result;
}

stilb_result engine_shadows_frame(stilb_engine *engine)
{
	engine_shadows *shadows = &engine->shadows;
	const stilb_render_view *seen = &engine->views[0];
	stilb_engine_shadows desc = stilb_engine_shadows_used(engine);
	stilb_scene_surface_channel channel;
	bool lit =
		!stilb_render_show_channel(seen->show, &channel) && seen->light_count > 0 && !engine->picture.hides_scene;
	bool valid = shadows->valid;
	shadows->valid = false;
	shadows->drawn = shadows->lights_drawn = 0;
	shadows->plan.map_count = shadows->plan.left_out = shadows->plan.faded = 0;
	if (desc.kind == STILB_ENGINE_SHADOWS_OFF || !lit || !shadows_bounds(shadows, engine->scene))
		return STILB_OK;
	shadows->valid = valid;
	stilb_shadow_view view = {.view_projection = seen->view_projection,
	                          .height = engine->part.height > 0 ? engine->part.height : engine->targets[0].height,
	                          .bounds = shadows->bounds,
	                          .others = engine->camera_count > 0};
	memcpy(view.camera_position, seen->camera_position, sizeof view.camera_position);
	if (desc.objects)
		view.near = shadows_near(engine->scene, seen->camera_position, desc.distance);
	stilb_result result = shadows_plan_in_room(engine, &desc, &view);
	shadows_tell_cameras(engine);
	shadows_tell_buffer(shadows, &desc);
	if (result != STILB_OK || shadows->plan.map_count == 0) {
		shadows->valid = false;
		return result == STILB_OK ? shadows_hand_on_none(engine) : result;
	}
	if (desc.faces == STILB_ENGINE_SHADOW_FACES_BACK)
		shadows_mirror(&shadows->plan);
	result = shadows_hand_on(engine, &desc, &view);
	shadows->valid = false;     /* until the device has drawn them */
	uint32_t last = UINT32_MAX; /* the light of the map that was drawn last; a light's maps follow one another */
	shadows->first_view = engine->view_count;
	for (uint32_t m = 0; m < shadows->plan.map_count && result == STILB_OK; m++) {
		if (shadows->stays[m])
			continue;
		shadows->view_maps[shadows->drawn] = m;
		shadows_view(engine, engine->view_count++, &shadows->plan.maps[m]);
		shadows->drawn++;
		uint32_t light = shadows->plan.maps[m].light;
		shadows->lights_drawn += light != last;
		last = light;
	}
	engine->pass_count = engine->view_count;
	return result;
}

void engine_shadows_leave_out(const stilb_engine *engine, uint32_t view, stilb_cull_visible *visible)
{
	const engine_shadows *shadows = &engine->shadows;
	STILB_ASSERT(view >= shadows->first_view && view - shadows->first_view < shadows->drawn);
	const stilb_shadow_map *map = &shadows->plan.maps[shadows->view_maps[view - shadows->first_view]];
	uint32_t kept = 0;
	for (uint32_t i = 0; i < visible->count && map->caster_count > 0; i++) {
		visible->ids[kept] = visible->ids[i];
		kept += stilb_shadow_casters_have(map, shadows_sphere(engine->scene, visible->ids[i]));
	}
	visible->count = map->caster_count > 0 ? kept : visible->count;
}

void engine_shadows_drawn(stilb_engine *engine)
{
	engine->shadows.valid = engine->shadows.plan.map_count > 0;
	engine->report.shadow_maps = engine->shadows.plan.map_count;
	engine->report.shadow_maps_drawn = engine->shadows.drawn;
	engine->report.shadow_lights_left = engine->shadows.plan.left_out;
	engine->report.shadow_lights_faded = engine->shadows.plan.faded;
	engine->report.shadow_lights_drawn = engine->shadows.lights_drawn;
}

void engine_shadows_forget(engine_shadows *shadows)
{
	shadows->valid = shadows->told = shadows->told_cameras = shadows->told_buffer = false;
	shadows->room = 0;
	shadows->scene = NULL;
	shadows->bounds = (stilb_sphere){0};
}

void engine_shadows_finish(engine_shadows *shadows)
{
	stilb_shadow_plan_finish(&shadows->plan);
	free(shadows->maps);
	free(shadows->lights);
	free(shadows->kept);
	free(shadows->stays);
	free(shadows->models);
	*shadows = (engine_shadows){0};
}
