/* The camera of `stilb view`. */
#include "view.h"

#include "input/input_orbit.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define VIEW_SPEED 0.75f /* of flying: distances of the orbit a second */
#define VIEW_NEAR 1e-3f  /* distances of the clip planes, in distances of the orbit */
#define VIEW_FAR 1e4f
#define VIEW_TURN_DIRECTIONS 16 /* from which a turntable must see all of the scene, */
#define VIEW_TURN_SPARE 1.15f   /* so much farther away, as it looks at the same point from all of them */

static float view_aspect(const view *v)
{
	uint32_t width, height;
	stilb_engine_size(v->run->engine, &width, &height);
	return (float)width / (float)height;
}

/* Takes the scene's camera as the one to orbit with from now on. */
static void view_settle(view *v)
{
	stilb_scene_camera *camera = &v->scene->camera;
	camera->near_z = VIEW_NEAR * v->distance;
	camera->far_z = VIEW_FAR * v->distance;
	camera->exposure = v->exposure;
	camera->tone = v->tone;
	v->last = *camera;
}

/* Frames the scene from this direction. */
static void view_frame(view *v, float yaw, float pitch)
{
	v->aspect = view_aspect(v);
	v->scene->camera = stilb_scene_frame(v->scene, yaw, pitch, v->aspect);
	v->distance = stilb_scene_camera_distance(v->scene, &v->scene->camera);
	v->framed = true;
	view_settle(v);
}

/* Where a turntable begins: far enough away that the scene is in view from all around, if the camera frames it. */
static stilb_scene_camera view_turn_home(const view *v)
{
	stilb_scene_camera home = v->home;
	stilb_sphere sphere = stilb_scene_sphere(v->scene);
	stilb_vec3 center = stilb_vec3_make(sphere.x, sphere.y, sphere.z);
	float farthest = 0.0f;
	if (!v->scene->framed)
		return home;
	for (int i = 0; i < VIEW_TURN_DIRECTIONS; i++) {
		float yaw = 6.2831853f * (float)i / VIEW_TURN_DIRECTIONS;
		stilb_scene_camera camera = stilb_scene_frame(v->scene, yaw, home.pitch, v->aspect);
		stilb_vec3 away = stilb_vec3_make(camera.position[0], camera.position[1], camera.position[2]) - center;
		farthest = fmaxf(farthest, sqrtf(stilb_vec3_dot(away, away)));
	}
	stilb_mat4 axes = stilb_mat4_view((stilb_vec3){0}, home.yaw, home.pitch);
	for (int i = 0; i < 3; i++)
		home.position[i] = center[i] + VIEW_TURN_SPARE * farthest * axes.m[4 * i + 2];
	return home;
}

/* Sets the camera of the flags, and the exposure that suits what it sees. A camera that this file lacks is an error
 * only for the first scene: later ones are seen by their own. */
static stilb_result view_place(view *v, stilb_scene *scene, bool *metered)
{
	picture_flags flags = v->options.picture;
	stilb_result result = picture_flags_place(&flags, v->aspect, scene);
	if (result != STILB_OK && v->scene) {
		live_run_warn(v->run, stilb_error_message());
		flags.camera = NULL;
		result = picture_flags_place(&flags, v->aspect, scene);
	}
	return result == STILB_OK ? picture_flags_expose(&flags, scene, metered) : result;
}

/* Takes the camera of --inset in the scene that is shown now; one that it lacks is said. */
static void view_find_inset(view *v)
{
	v->has_inset = v->inset && picture_flags_look("--inset", v->inset, v->scene, &v->inset_camera) == STILB_OK;
	if (v->inset && !v->has_inset)
		live_run_warn(v->run, stilb_error_message());
	if (!v->has_inset)
		return;
	float distance = stilb_scene_camera_distance(v->scene, &v->inset_camera);
	v->inset_camera.near_z = VIEW_NEAR * distance;
	v->inset_camera.far_z = VIEW_FAR * distance;
}

#define VIEW_INSET_SIDE 0.3f  /* share of the picture's sides, */
#define VIEW_INSET_EDGE 0.02f /* and of what is left beside it */

void view_show_inset(const view *v)
{
	stilb_engine_camera inset = {
		.name = "inset",
		.camera = v->inset_camera,
		.place = {1.0f - VIEW_INSET_EDGE - VIEW_INSET_SIDE, 1.0f - VIEW_INSET_EDGE - VIEW_INSET_SIDE,
	              1.0f - VIEW_INSET_EDGE, 1.0f - VIEW_INSET_EDGE},
		.border = 1,
	};
	bool shown = v->has_inset && v->scene;
	if (shown) {
		inset.camera.exposure = v->exposure;
		inset.camera.tone = v->tone;
	}
	stilb_engine_set_cameras(v->run->engine, &inset, shown ? 1 : 0);
}

static void view_tell_exposure(const view *v)
{
	char text[96];
	snprintf(text, sizeof text, "exposure: %.2f EV, metered", (double)v->exposure);
	fprintf(live_message_stream(&v->options), "%s\n", text);
	live_run_tell(v->run, text);
}

stilb_result view_ready(view *v, stilb_scene *scene, bool again, bool *metered)
{
	*metered = false;
	v->aspect = view_aspect(v);
	stilb_result result = view_variant_begin(v, scene, again && v->scene);
	if (result == STILB_OK && v->inset && !v->scene) /* of the first scene it is an error if it has no such camera */
		result = picture_flags_look("--inset", v->inset, scene, &v->inset_camera);
	return result == STILB_OK ? view_place(v, scene, metered) : result;
}

stilb_result view_show(view *v, stilb_scene *scene, bool again, bool metered)
{
	again = again && v->scene;
	stilb_scene_camera kept = again ? v->scene->camera : (stilb_scene_camera){0};
	stilb_result result = stilb_engine_set_scene(v->run->engine, scene);
	if (result != STILB_OK) {
		stilb_scene_destroy(scene);
		return result;
	}
	if (v->scene)
		view_rays_forget(v);
	stilb_scene_destroy(v->scene);
	v->scene = scene;
	v->home = scene->camera;
	v->exposure = scene->camera.exposure;
	v->tone = scene->camera.tone;
	if (v->turntable > 0)
		v->home = view_turn_home(v);
	if (again && !v->framed) {
		scene->camera = kept;
	} else {
		v->framed = scene->framed;
		v->distance = stilb_scene_camera_distance(scene, &scene->camera);
	}
	stilb_engine_set_speed(v->run->engine, VIEW_SPEED * v->distance);
	view_settle(v);
	view_find_inset(v);
	if (metered)
		view_tell_exposure(v);
	return STILB_OK;
}

static bool view_orbits(const stilb_input_orbit *orbit)
{
	return orbit->turn[0] != 0.0f || orbit->turn[1] != 0.0f || orbit->pan[0] != 0.0f || orbit->pan[1] != 0.0f ||
	       orbit->closer != 0.0f;
}

static void view_orbit(view *v, const stilb_input_orbit *orbit)
{
	stilb_scene_camera *camera = &v->scene->camera;
	stilb_input_pose pose = {
		.position = {camera->position[0], camera->position[1], camera->position[2]},
		.yaw = camera->yaw,
		.pitch = camera->pitch,
	};
	stilb_input_orbit_move(orbit, &pose, &v->distance);
	memcpy(camera->position, pose.position, sizeof camera->position);
	camera->yaw = pose.yaw;
	camera->pitch = pose.pitch;
}

/* What the pointer asks for. A drag moves what is at the orbit's distance along with the pointer. */
static stilb_input_orbit view_asked(const view *v, const stilb_input_state *input)
{
	float height = 2.0f * tanf(0.5f * v->scene->camera.fov_y); /* of the picture at the distance 1 */
	return (stilb_input_orbit){
		.turn = {-input->drag[0] * STILB_INPUT_ORBIT_TURN, -input->drag[1] * STILB_INPUT_ORBIT_TURN},
		.pan = {-input->pan[0] * height, input->pan[1] * height},
		.closer = input->zoom,
	};
}

/* Turns the camera at the start about the vertical axis through the scene's middle. */
static void view_turn(view *v, float angle)
{
	stilb_sphere sphere = stilb_scene_sphere(v->scene);
	stilb_vec3 center = stilb_vec3_make(sphere.x, sphere.y, sphere.z);
	stilb_scene_camera *camera = &v->scene->camera;
	*camera = v->home;
	float x = camera->position[0] - center[0], z = camera->position[2] - center[2];
	camera->position[0] = center[0] + x * cosf(angle) + z * sinf(angle);
	camera->position[2] = center[2] - x * sinf(angle) + z * cosf(angle);
	camera->yaw = remainderf(camera->yaw + angle, 6.2831853f);
	v->distance = stilb_scene_camera_distance(v->scene, camera);
	v->framed = false;
}

void view_move(view *v, const stilb_engine_update *update)
{
	if (!v->scene)
		return;
	stilb_scene_camera *camera = &v->scene->camera;
	stilb_input_orbit orbit = view_asked(v, update->input);
	if (v->turntable > 0)
		view_turn(v, 6.2831853f * (float)(update->frame - 1) / (float)v->turntable);
	if (update->input->actions[VIEW_HOME] > 0) {
		*camera = v->home;
		v->distance = stilb_scene_camera_distance(v->scene, camera);
		v->framed = v->scene->framed;
	}
	for (uint32_t i = 0; i < 9; i++)
		if (update->input->actions[VIEW_CAMERA_1 + i] > 0)
			view_choose_camera(v, i);
	if (update->input->actions[VIEW_FRAME] > 0)
		view_frame(v, camera->yaw, camera->pitch);
	if (view_orbits(&orbit))
		view_orbit(v, &orbit);
	/* Flown or orbited since the scene was framed: the user's own camera stays in a window of another shape. */
	v->framed = v->framed && memcmp(camera->position, v->last.position, sizeof camera->position) == 0 &&
	            camera->yaw == v->last.yaw && camera->pitch == v->last.pitch;
	if (v->framed && v->aspect != view_aspect(v))
		view_frame(v, camera->yaw, camera->pitch);
	view_settle(v);
}
