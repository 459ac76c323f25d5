/* The cameras of a frame: the scene's own and those beside it, each a view with a target. */
#include "engine_internal.h"

#include <math.h>
#include <string.h>

static_assert(STILB_ENGINE_MAX_CAMERAS + 2 <= ENGINE_MAX_VIEWS && ENGINE_MAX_VIEWS + 2 <= STILB_RENDER_MAX_PASSES,
              "a view and a pass for each and for the reference, and passes for picture and overlay");

/* ---- what the program asks for ----------------------------------------------------------------------------------- */

static bool camera_place_is_sound(const float place[4])
{
	bool none = place[0] == 0.0f && place[1] == 0.0f && place[2] == 0.0f && place[3] == 0.0f;
	return none || (place[0] >= 0.0f && place[0] < place[2] && place[2] <= 1.0f && place[1] >= 0.0f &&
	                place[1] < place[3] && place[3] <= 1.0f);
}

/* What the still scene looks like is not known any more. */
static void cameras_changed(stilb_engine *engine)
{
	engine_picture_forget_scene(engine);
	engine->culled_size[0] = 0;
}

static bool camera_is(const engine_camera *camera, const stilb_engine_camera *other)
{
	const stilb_engine_camera *asked = &camera->asked;
	return strcmp(camera->name, other->name) == 0 && asked->border == other->border && asked->width == other->width &&
	       asked->height == other->height && memcmp(asked->place, other->place, sizeof asked->place) == 0 &&
	       memcmp(&asked->camera, &other->camera, sizeof asked->camera) == 0;
}

void stilb_engine_set_cameras(stilb_engine *engine, const stilb_engine_camera *cameras, uint32_t count)
{
	STILB_ASSERT_OWNER(engine->owner);
	STILB_ASSERT(count <= STILB_ENGINE_MAX_CAMERAS && (cameras || count == 0));
	bool same = count == engine->camera_count;
	for (uint32_t c = 0; c < count; c++) {
		engine_camera *to = &engine->cameras[c];
		size_t length = cameras[c].name ? strnlen(cameras[c].name, STILB_RENDER_TARGET_NAME + 1) : 0;
		STILB_ASSERT(length > 0 && length <= STILB_RENDER_TARGET_NAME && camera_place_is_sound(cameras[c].place));
		STILB_ASSERT(cameras[c].width <= 16384 && cameras[c].height <= 16384);
		STILB_ASSERT(cameras[c].place[2] > 0.0f || (cameras[c].width > 0 && cameras[c].height > 0));
		same = same && camera_is(to, &cameras[c]);
		to->asked = cameras[c];
		memcpy(to->name, cameras[c].name, length);
		to->name[length] = '\0';
	}
	engine->camera_count = count;
	if (!same)
		cameras_changed(engine);
}

void stilb_engine_set_place(stilb_engine *engine, const float place[4])
{
	STILB_ASSERT_OWNER(engine->owner);
	STILB_ASSERT(place && place[2] > 0.0f && camera_place_is_sound(place));
	if (memcmp(engine->place, place, sizeof engine->place) != 0)
		cameras_changed(engine);
	memcpy(engine->place, place, sizeof engine->place);
}

void stilb_engine_set_scale(stilb_engine *engine, float scale)
{
	STILB_ASSERT_OWNER(engine->owner);
	STILB_ASSERT(scale >= STILB_ENGINE_MIN_SCALE && scale <= STILB_ENGINE_MAX_SCALE);
	if (engine->desc.scale != scale)
		cameras_changed(engine);
	engine->desc.scale = scale;
}

/* ---- a frame ----------------------------------------------------------------------------------------------------- */

/* Pixels first .. first + count - 1 that a part of a side covers; at least one. */
static void camera_pixels(float from, float to, uint32_t side, uint16_t *first, uint16_t *count)
{
	float begin = floorf(from * (float)side + 0.5f), end = floorf(to * (float)side + 0.5f);
	begin = fminf(begin, (float)side - 1.0f);
	*first = (uint16_t)begin;
	*count = (uint16_t)fmaxf(end - begin, 1.0f);
}

static uint32_t camera_scaled(uint32_t side, float scale)
{
	float scaled = floorf((float)side * scale + 0.5f);
	return (uint32_t)fminf(fmaxf(scaled, 1.0f), 16384.0f);
}

/* The target of a camera that is shown in a part of the picture; place all 0: in none. */
static stilb_render_target camera_target(const stilb_engine *engine, const char *name, const float place[4],
                                         uint32_t width, uint32_t height)
{
	float scale = engine->desc.scale > 0.0f ? engine->desc.scale : 1.0f;
	stilb_render_target target = {.name = name, .width = width, .height = height, .output = place[2] == 0.0f};
	if (place[2] > 0.0f) {
		uint32_t side[2];
		stilb_render_size(engine->render, &side[0], &side[1]);
		camera_pixels(place[0], place[2], side[0], &target.place[0], &target.place[2]);
		camera_pixels(place[1], place[3], side[1], &target.place[1], &target.place[3]);
	}
	if (width == 0)
		target.width = camera_scaled(target.place[2], scale);
	if (height == 0)
		target.height = camera_scaled(target.place[3], scale);
	return target;
}

/* stilb_render_light_peak of the scene, which is read again only if a material or the shading has changed. */
static float camera_peak(stilb_engine *engine, const stilb_render_shading *shading)
{
	engine_peak *peak = &engine->peak;
	if (!peak->known || memcmp(&peak->shading, shading, sizeof *shading) != 0)
		*peak = (engine_peak){true, *shading, stilb_render_light_peak(engine->scene, shading)};
	return peak->value;
}

/* The view of a camera; its target is that of the view's number. */
static void camera_view(stilb_engine *engine, uint32_t number, const stilb_scene_camera *camera)
{
	stilb_render_view *view = &engine->views[number];
	const stilb_render_target *target = &engine->targets[number];
	*view = engine_view_of(engine, engine->scene);
	view->shading = engine->frame_formulas.shading;
	view->lighting = engine->frame_formulas.lighting;
	if (view->light_tolerance > 0.0f)
		view->light_peak = camera_peak(engine, &view->shading);
	const uint16_t *place = target->place; /* it is seen in these proportions, whatever the image's are */
	float aspect = place[3] > 0 ? (float)place[2] / (float)place[3] : (float)target->width / (float)target->height;
	const engine_part *part = &engine->part;
	if (number == 0 && part->width > 0)
		aspect = (float)part->width / (float)part->height;
	view->view_projection = stilb_scene_camera_matrix(camera, aspect);
	memcpy(view->camera_position, camera->position, sizeof view->camera_position);
	stilb_scene_surface_channel channel;
	if (number > 0) { /* what effects read alone: they are the main picture's */
		view->mirrors = false;
		view->ambient_apart = engine->desc.ambient_apart || engine->shows_ambient;
	}
	if (!stilb_render_show_channel(view->show, &channel)) {
		view->exposure = camera->exposure - engine->exposure_base + stilb_post_exposure(engine->post);
		view->tone = camera->tone;
	}
	if (view->show == STILB_RENDER_SHOW_CASCADES || view->show == STILB_RENDER_SHOW_ACNE)
		view->ambient = STILB_RENDER_AMBIENT_NONE; /* they colour the light of lights */
	bool error = number == 0 && engine->frame_formulas.error;
	if (view->show == STILB_RENDER_SHOW_ERROR && !error) /* of other cameras, and until its programs are there */
		view->show = STILB_RENDER_SHOW_SHADED;
	view->target = target;
	engine_last *last = &engine->lasts[number];
	if (!last->known || strcmp(last->name, engine->target_names[number]) != 0)
		last->view_projection = view->view_projection; /* it has not moved so far */
	view->surfaces = engine_draws_surfaces(engine);
	view->ids = engine_draws_ids(engine);
	view->blended = number == 0 && engine->desc.post.dof != STILB_POST_DOF_OFF;
	view->last = engine_draws_velocity(engine) ? &last->view_projection : NULL;
}

/* The scene's own camera once more, by the reference's way of lighting, into an image of its own. */
static void cameras_reference(stilb_engine *engine)
{
	uint32_t number = engine->view_count++;
	stilb_render_target *target = &engine->targets[number];
	*target = (stilb_render_target){.name = STILB_RENDER_IMAGE_REFERENCE,
	                                .width = engine->targets[0].width,
	                                .height = engine->targets[0].height,
	                                .output = true};
	engine->views[number] = engine->views[0];
	engine->views[number].target = target;
	engine_reference_view(&engine->views[number]);
	engine->passes[number] = (stilb_render_pass){.name = target->name, .view = number, .order = number};
}

/* Decides whether frames show a moment that is paused. */
static void cameras_hold(stilb_engine *engine)
{
	bool paused = engine->playing.pace == 0.0f,
		 same = memcmp(&engine->lasts[0].view_projection, &engine->views[0].view_projection, sizeof(stilb_mat4)) == 0;
	bool was = engine->holds;
	engine->holds = !paused || (was && same && engine->scene->moved_count == 0);
	stilb_post_hold(engine->post, paused && engine->holds);
}

void engine_cameras_frame(stilb_engine *engine)
{
	uint32_t width, height;
	stilb_render_size(engine->render, &width, &height);
	engine->peak.known &= stilb_scene_changes_read(engine->scene).material_count == 0;
	engine->targets[0] = camera_target(engine, "color", engine->place, 0, 0);
	camera_view(engine, 0, &engine->scene->camera);
	cameras_hold(engine);
	const stilb_render_target *main = &engine->targets[0];
	if (main->width == width && main->height == height && main->place[2] == width && main->place[3] == height)
		engine->views[0].target = NULL; /* as large as the picture and in all of it */
	engine->passes[0] = (stilb_render_pass){.name = "scene"};
	for (uint32_t c = 0; c < engine->camera_count; c++) {
		const engine_camera *camera = &engine->cameras[c];
		char *name = engine->target_names[c + 1];
		memcpy(name, camera->name, sizeof camera->name);
		engine->targets[c + 1] =
			camera_target(engine, name, camera->asked.place, camera->asked.width, camera->asked.height);
		engine->targets[c + 1].border = camera->asked.border;
		camera_view(engine, c + 1, &camera->asked.camera);
		engine->passes[c + 1] = (stilb_render_pass){.name = name, .view = c + 1, .order = c + 1};
	}
	engine->view_count = engine->camera_count + 1;
	if (engine->views[0].show == STILB_RENDER_SHOW_ERROR)
		cameras_reference(engine);
	engine->pass_count = engine->view_count;
}

void engine_cameras_part(stilb_engine *engine)
{
	const engine_part *part = &engine->part;
	uint32_t size[2];
	stilb_render_size(engine->render, &size[0], &size[1]);
	stilb_mat4 *m = &engine->views[0].view_projection;
	const float whole[2] = {(float)part->width, (float)part->height};
	const float middle[2] = {(float)part->left + 0.5f * (float)size[0], (float)part->top + 0.5f * (float)size[1]};
	for (int r = 0; r < 2; r++) {
		float scale = whole[r] / (float)size[r], shift = (whole[r] - 2.0f * middle[r]) / (float)size[r];
		for (int c = 0; c < 4; c++)
			m->m[4 * c + r] = scale * m->m[4 * c + r] + shift * m->m[4 * c + 3];
	}
	engine->lasts[0].view_projection = *m;
}

void engine_cameras_jitter(stilb_engine *engine)
{
	stilb_render_view *view = &engine->views[0];
	if (engine->desc.post.aa != STILB_POST_AA_TEMPORAL || view->show != STILB_RENDER_SHOW_SHADED || !view->last)
		return;
	const stilb_render_target *target = &engine->targets[0];
	stilb_post_jitter(engine->frame, view->jitter);
	view->jitter[0] *= 2.0f / (float)target->width;
	view->jitter[1] *= 2.0f / (float)target->height;
}

void engine_cameras_drawn(stilb_engine *engine)
{
	for (uint32_t v = 0; v <= engine->camera_count; v++) {
		engine_last *last = &engine->lasts[v];
		last->known = true;
		memcpy(last->name, engine->target_names[v], sizeof last->name);
		last->view_projection = engine->views[v].view_projection;
	}
}

/* ---- what lies under a point ------------------------------------------------------------------------------------- */

/* True if the point of the picture, pixels, lies in the part; *x, *y: then as pixels of a picture of its own, of
 * size[2] pixels. */
static bool camera_covers(const stilb_engine *engine, const float place[4], double *x, double *y, uint32_t size[2])
{
	stilb_render_target target = camera_target(engine, "", place, 0, 0);
	double left = *x - target.place[0], top = *y - target.place[1];
	if (target.place[2] == 0 || left < 0.0 || top < 0.0 || left >= target.place[2] || top >= target.place[3])
		return false;
	*x = left;
	*y = top;
	size[0] = target.place[2];
	size[1] = target.place[3];
	return true;
}

bool engine_cameras_own(const stilb_engine *engine, double *x, double *y, uint32_t size[2])
{
	for (uint32_t c = 0; c < engine->camera_count; c++)
		if (camera_covers(engine, engine->cameras[c].asked.place, x, y, size))
			return false;
	return camera_covers(engine, engine->place, x, y, size);
}

bool engine_cameras_ray(const stilb_engine *engine, double x, double y, stilb_scene_ray *ray)
{
	const stilb_scene_camera *camera = NULL;
	uint32_t size[2];
	if (engine_picture_covers(engine, x)) {
		stilb_render_size(engine->render, &size[0], &size[1]);
		*ray = stilb_scene_camera_ray(&engine->scene->camera, size[0], size[1], x, y);
		return true;
	}
	for (uint32_t c = engine->camera_count; c-- > 0 && !camera;) /* later ones lie over earlier ones */
		if (camera_covers(engine, engine->cameras[c].asked.place, &x, &y, size))
			camera = &engine->cameras[c].asked.camera;
	if (!camera && camera_covers(engine, engine->place, &x, &y, size))
		camera = &engine->scene->camera;
	if (!camera)
		return false;
	*ray = stilb_scene_camera_ray(camera, size[0], size[1], x, y);
	return true;
}
