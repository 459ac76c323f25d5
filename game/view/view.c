/* stilb view: shows a scene in a window, or headless, which is without one. */
#include "view.h"

#include "base/base_file.h"
#include "game/commands.h"
#include "shading/shade_brdf.h"

#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <time.h>
#include <unistd.h>

#define VIEW_SCENE "spheres" /* without a scene: it has textures and all kinds of materials */

static const stilb_input_action view_actions[VIEW_ACTIONS - STILB_ENGINE_ACTIONS] = {
	[VIEW_TURN - STILB_ENGINE_ACTIONS] = {.name = "turn",
                                          .kind = STILB_INPUT_MOTION,
                                          .mouse = STILB_INPUT_MOUSE_LEFT,
                                          .main = true,
                                          .help = "turn about it; a click names the part"},
	[VIEW_PAN - STILB_ENGINE_ACTIONS] = {.name = "move",
                                         .kind = STILB_INPUT_MOTION,
                                         .mouse = STILB_INPUT_MOUSE_MIDDLE,
                                         .help = "move along with it"},
	[VIEW_ZOOM - STILB_ENGINE_ACTIONS] = {.name = "closer",
                                          .kind = STILB_INPUT_MOTION,
                                          .mouse = STILB_INPUT_MOUSE_WHEEL,
                                          .main = true,
                                          .help = "come closer"},
	[VIEW_FRAME - STILB_ENGINE_ACTIONS] = {.name = "frame",
                                           .keys = {STILB_WINDOW_KEY_F},
                                           .main = true,
                                           .help = "frame the model from this side"},
	[VIEW_HOME - STILB_ENGINE_ACTIONS] = {.name = "start",
                                          .keys = {STILB_WINDOW_KEY_HOME},
                                          .help = "back to the camera at the start"},
	[VIEW_NEXT - STILB_ENGINE_ACTIONS] = {.name = "next file",
                                          .keys = {STILB_WINDOW_KEY_PAGE_DOWN},
                                          .help = "next, previous file of the folder"},
	[VIEW_PREVIOUS - STILB_ENGINE_ACTIONS] = {.name = "previous file",
                                              .keys = {STILB_WINDOW_KEY_PAGE_UP},
                                              .help = "next, previous file of the folder"},
	[VIEW_DROP - STILB_ENGINE_ACTIONS] = {.name = "open",
                                          .kind = STILB_INPUT_MOTION,
                                          .mouse = STILB_INPUT_MOUSE_DROP,
                                          .help = "open it"},
	[VIEW_VARIANT - STILB_ENGINE_ACTIONS] = {.name = "variant",
                                             .keys = {STILB_WINDOW_KEY_V},
                                             .help = "next variant of the materials"},
	[VIEW_GIVE_UP - STILB_ENGINE_ACTIONS] = {.name = "give up",
                                             .keys = {STILB_WINDOW_KEY_ESCAPE},
                                             .help = "give up what is being opened"},
	[VIEW_RAYS - STILB_ENGINE_ACTIONS] = {.name = "path trace",
                                          .keys = {STILB_WINDOW_KEY_T},
                                          .main = true,
                                          .help = "path traced; drag its left edge"},
#define VIEW_CAMERA(number)                                                                                            \
	[VIEW_CAMERA_1 + (number)-1 - STILB_ENGINE_ACTIONS] = {                                                            \
		.name = "camera " #number, .keys = {STILB_WINDOW_KEY_##number}, .help = "look with a camera of the file"}
	VIEW_CAMERA(1),
	VIEW_CAMERA(2),
	VIEW_CAMERA(3),
	VIEW_CAMERA(4),
	VIEW_CAMERA(5),
	VIEW_CAMERA(6),
	VIEW_CAMERA(7),
	VIEW_CAMERA(8),
	VIEW_CAMERA(9),
#undef VIEW_CAMERA
};
static const live_keys view_keys = {view_actions, sizeof view_actions / sizeof *view_actions};

/* Gives up what has been opened and is not yet shown. */
static void view_end_coming(view *v)
{
	if (!v->coming.scene)
		return;
	stilb_engine_prepare(v->run->engine, NULL);
	stilb_scene_destroy(v->coming.scene);
	view_watch_finish(&v->coming.watch);
	free(v->coming.name);
	v->coming = (view_coming){.watch = VIEW_WATCH_NONE};
}

/* Gives up levels that are not made yet. */
static void view_end_detail(view *v)
{
	stilb_geometry_detail_end(v->detail);
	v->detail = NULL;
}

/* Gives up what is being opened, and waits for that. */
static void view_end_load(view *v)
{
	stilb_scene *scene;
	view_end_coming(v);
	if (!v->load)
		return;
	view_load_give_up(v->load);
	view_load_take(v->load, &scene, NULL);
	stilb_scene_destroy(scene);
	v->load = NULL;
}

/* Begins to open a scene; one that is being opened is given up. again: it is the scene that is shown. */
static stilb_result view_open(view *v, const char *name, bool again)
{
	view_end_load(v);
	return view_load_start(name, &v->options.picture, again, !v->run->window, &v->load);
}

/* Says a line on the terminal and in the window. */
__attribute__((format(printf, 2, 3))) static void view_warn(const view *v, const char *format, ...)
{
	char text[1280];
	va_list arguments;
	va_start(arguments, format);
	vsnprintf(text, sizeof text, format, arguments);
	va_end(arguments);
	live_run_warn(v->run, text);
}

/* Begins to make what the scene's meshes lack; in a window alone, since without one nothing is shown before they are
 * there. */
static void view_start_detail(view *v)
{
	bool drawn = v->options.picture.detail != STILB_RENDER_DETAIL_OFF;
	if (drawn && v->run->window && stilb_geometry_detail_start(v->scene, &v->detail) != STILB_OK)
		view_warn(v, "%s; they are drawn as they are", stilb_error_message());
}

/* Takes what has been opened, and adds its files to those that are watched. */
static stilb_result view_load_taken(view *v, stilb_scene **scene, view_watch *watch, view_load_cost *cost)
{
	uint32_t count = 0;
	while (!view_load_ended(v->load))
		nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
	const char *const *files = view_load_files(v->load, &count);
	for (uint32_t i = 0; i < count; i++)
		view_watch_add(watch, files[i]);
	stilb_result result = view_load_take(v->load, scene, cost);
	v->load = NULL;
	return result;
}

/* A panorama that was dropped counts from when it has been read; until then, and if it cannot be, the one before
 * does. */
static void view_settle_environment(view *v, bool good)
{
	if (!v->dropping)
		return;
	if (good) {
		free(v->dropped);
		v->dropped = v->dropping;
	} else {
		free(v->dropping);
	}
	v->dropping = NULL;
	v->options.picture.environment = v->dropped ? v->dropped : v->environment;
}

/* The scene that has been opened cannot be shown. The first one must be; later, a line says why the one before
 * stays. */
static stilb_result view_fails(view *v, stilb_result result)
{
	view_settle_environment(v, false);
	if (!v->scene)
		return result;
	view_warn(v, "%s; '%s' stays as it was", stilb_error_message(), v->name);
	return STILB_OK;
}

/* Shows what has been opened and is ready. */
static stilb_result view_arrived(view *v)
{
	view_coming come = v->coming;
	v->coming = (view_coming){.watch = VIEW_WATCH_NONE};
	view_end_detail(v);
	stilb_result result = view_show(v, come.scene, come.again, come.metered);
	if (result != STILB_OK) {
		free(come.name);
		view_watch_finish(&come.watch);
		return view_fails(v, result);
	}
	if (come.looks) {
		stilb_post_settings look = picture_flags_post(&v->options.picture);
		stilb_engine_set_post(v->run->engine, &look);
		v->own_look = come.own;
		if (live_run_grade(v->run) != STILB_OK)
			view_warn(v, "%s", stilb_error_message());
	}
	view_start_detail(v);
	view_settle_environment(v, true);
	v->run->starting = false;
	free(v->name);
	v->name = come.name;
	if (come.cost.import_bytes > 0 && !v->options.picture.quiet)
		fprintf(live_message_stream(&v->options), "%s: opened in %.2f s; the import process had %.1f MiB at most\n",
		        come.name, come.cost.seconds, (double)come.cost.import_bytes / 1048576.0);
	if (!come.again) {
		view_watch_finish(&v->watch);
		v->watch = come.watch;
	}
	return STILB_OK;
}

/* Takes the look that lies beside the scene's file, or none; --preset counts for all scenes. */
static stilb_result view_take_look(view *v, const char *name, view_coming *come)
{
	char path[PATH_MAX];
	stilb_post_preset *preset = NULL;
	if (v->options.picture.preset)
		return STILB_OK;
	snprintf(path, sizeof path, "%s" STILB_POST_PRESET_SUFFIX, name);
	if (access(path, F_OK) == 0) {
		stilb_result result = stilb_post_preset_open(path, &preset);
		if (result != STILB_OK)
			return result;
		if (!v->options.picture.quiet)
			stilb_log("%s: pictures are shown as this file says", path);
	}
	bool has = preset;
	live_options_look(&v->options, preset);
	if (has && !live_options_check_look(&v->options)) {
		live_options_look(&v->options, NULL);
		return stilb_fail(STILB_ERROR_ARGUMENT, "%s: what it says does not go with the flags that are given", path);
	}
	come->own = has;
	come->looks = has || v->own_look; /* else what the user has chosen stays */
	return STILB_OK;
}

/* Makes what has been opened ready to be shown: in a window beside the frames. */
static stilb_result view_opened(view *v)
{
	view_coming come = {.again = view_load_again(v->load), .watch = VIEW_WATCH_NONE};
	come.name = strdup(view_load_name(v->load));
	if (!come.again)
		view_watch_set(&come.watch, view_load_name(v->load));
	stilb_result result = view_load_taken(v, &come.scene, come.again ? &v->watch : &come.watch, &come.cost);
	if (result == STILB_OK && !come.name)
		result = stilb_fail(STILB_ERROR_MEMORY, "no memory for a name");
	if (result == STILB_OK)
		result = view_take_look(v, come.name, &come);
	if (result == STILB_OK)
		result = view_ready(v, come.scene, come.again, &come.metered);
	if (result == STILB_OK && v->run->window)
		result = stilb_engine_prepare(v->run->engine, come.scene);
	if (result != STILB_OK) {
		stilb_scene_destroy(come.scene);
		free(come.name);
		view_watch_finish(&come.watch);
		return view_fails(v, result);
	}
	v->coming = come;
	return v->run->window ? STILB_OK : view_arrived(v);
}

/* Goes on with what is being opened: read, then ready, then shown. */
static stilb_result view_go_on(view *v)
{
	if (v->coming.scene)
		return stilb_engine_prepared(v->run->engine) >= 1.0f ? view_arrived(v) : STILB_OK;
	return v->load && view_load_ended(v->load) ? view_opened(v) : STILB_OK;
}

/* The user gives up what is being opened. */
static stilb_result view_give_up(view *v)
{
	if (v->load)
		view_load_give_up(v->load); /* its end says so */
	if (!v->coming.scene)
		return STILB_OK;
	stilb_result result = stilb_fail(STILB_ERROR_GIVEN_UP, "'%s' was given up", v->coming.name);
	view_end_coming(v);
	return view_fails(v, result);
}

static stilb_result view_start(void *user, live_run *run)
{
	view *v = user;
	v->run = run;
	run->starting = true;
	bool plays = run->window || v->options.picture.animation; /* pictures show the clip where --at has it */
	stilb_engine_set_pace(run->engine, plays ? 1.0f : 0.0f);
	stilb_result result = view_open(v, v->name, false);
	if (result != STILB_OK || run->window)
		return result;
	return view_opened(v); /* headless, the first frame shows the scene: this waits for it */
}

static void view_update(void *user, const stilb_engine_update *update)
{
	view *v = user;
	view_rays_give_way(v);
	view_move(v, update);
	view_show_inset(v);
	if (v->detail && stilb_geometry_detail_give(v->detail, v->scene))
		view_end_detail(v);
	for (uint8_t i = 0; v->scene && i < update->input->actions[VIEW_VARIANT]; i++)
		view_variant_next(v);
	if (update->input->actions[VIEW_RAYS] % 2 > 0)
		view_rays_switch(v);
	v->run->wrong = view_rays_frame(v, update->frame);
}

static void view_release(void *user)
{
	view_rays_forget(user);
}

/* Opens a file that was dropped onto the window; a panorama becomes the environment of what is shown, which is opened
 * again with it, beside the frames. */
static stilb_result view_drop(view *v, const char *path)
{
	const char *dot = strrchr(path, '.');
	if (!dot || (strcasecmp(dot, ".hdr") != 0 && strcasecmp(dot, ".exr") != 0))
		return view_open(v, path, false);
	char *dropping = strdup(path);
	if (!dropping)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a name");
	view_end_load(v); /* it reads the flags */
	free(v->dropping);
	v->dropping = dropping;
	v->options.picture.environment = dropping;
	return view_open(v, v->name, true);
}

/* Looks whether the file on disk has changed. */
static stilb_result view_look(view *v)
{
	switch (view_watch_look(&v->watch)) {
	case VIEW_WATCH_CHANGED:
		if (view_watch_is(&v->watch, STILB_SCENE_LIGHTS_SUFFIX) && !stilb_scene_lights_changed(v->scene))
			return STILB_OK; /* the window of lights has saved them */
		return view_open(v, v->name, true);
	case VIEW_WATCH_GONE:
		view_warn(v, "'%s' has gone; what it was stays, until there is such a file again", v->name);
		return STILB_OK;
	default:
		return STILB_OK;
	}
}

/* Begins to open the next or the previous file of the folder. */
static stilb_result view_step(view *v, int step)
{
	const char *from = v->load ? view_load_name(v->load) : v->coming.scene ? v->coming.name : v->name;
	char *name = step != 0 ? view_watch_neighbour(from, step) : NULL;
	stilb_result result = name ? view_open(v, name, false) : STILB_OK;
	free(name);
	return result;
}

static stilb_result view_act(void *user, live_run *run, const stilb_engine_report *report)
{
	view *v = user;
	stilb_result result = STILB_OK;
	view_rays_wait(v);
	bool opens = v->load || v->coming.scene;
	if (!run->window && !opens)
		return STILB_OK;
	if (opens && report->input.actions[VIEW_GIVE_UP] > 0)
		result = view_give_up(v);
	if (result != STILB_OK)
		return result;
	if (v->scene && report->clicked)
		view_choose_part(v, report->click_x, report->click_y);
	if (v->scene) {
		result = view_step(v, report->input.actions[VIEW_NEXT] - report->input.actions[VIEW_PREVIOUS]);
		if (result == STILB_OK && report->dropped_count > 0)
			result = view_drop(v, report->dropped[report->dropped_count - 1]);
		if (result == STILB_OK && !v->load && !v->coming.scene)
			result = view_look(v);
		if (result != STILB_OK) /* no thread, or no memory for it: the scene stays */
			live_run_warn(v->run, stilb_error_message());
	}
	return view_go_on(v);
}

static void view_finish(void *user)
{
	view *v = user;
	view_end_load(v);
	view_end_detail(v);
	view_rays_finish(v);
	view_watch_finish(&v->watch);
}

static void view_title(void *user, const live_run *run, char title[static 256])
{
	const view *v = user;
	const char *name = v->load ? view_load_name(v->load) : v->coming.scene ? v->coming.name : v->name;
	const char *slash = strrchr(name, '/');
	name = slash ? slash + 1 : name;
	if (v->load)
		snprintf(title, 256, "Stilb: opening %.120s, %.0f %%, %.0f s; Esc gives it up", name,
		         100.0 * (double)view_load_done(v->load), view_load_seconds(v->load));
	else if (v->coming.scene)
		snprintf(title, 256, "Stilb: copying %.120s to the device, %.0f %%; Esc gives it up", name,
		         100.0 * (double)stilb_engine_prepared(v->run->engine));
	else if (v->rays.on && v->rays.plays)
		snprintf(title, 256, "Stilb: %.120s, playing; path traced when paused", name);
	else if (v->rays.on && v->rays.edits)
		snprintf(title, 256, "Stilb: %.120s; path traced when the window of lights is closed", name);
	else if (v->rays.shown)
		snprintf(title, 256, "Stilb: %.120s, path traced", name);
	else
		snprintf(title, 256, "Stilb: %.120s, frame %.1f ms", name, run->report.times.frame);
}

/* Checks what the table of flags cannot express. Returns false after one line on stderr. */
static bool view_check(view *v)
{
	if (v->turntable > 0 && !v->options.screenshot) {
		stilb_log("--turntable needs --screenshot FILE, whose name it numbers: FILE-001.png, ...");
		return false;
	}
	if (v->turntable > 0 && stilb_file_is_stdout(v->options.screenshot)) {
		stilb_log("--turntable: several pictures cannot go to standard output; give --screenshot a file name");
		return false;
	}
	if (v->turntable > 0 && v->options.frames > 0) {
		stilb_log("--turntable draws a frame for each picture; leave --frames out");
		return false;
	}
	const char *dot = v->options.screenshot ? strrchr(v->options.screenshot, '.') : NULL;
	if (picture_flags_are_transparent(&v->options.picture) && dot && strcasecmp(dot, ".hdr") == 0) {
		stilb_log("--background transparent: a .hdr has no alpha; give --screenshot a .png or an .exr");
		return false;
	}
	v->options.pictures = v->turntable;
	v->options.headless |= v->turntable > 0;
	return picture_flags_check_camera("--inset", v->inset) && live_options_check(&v->options) && view_rays_check(v);
}

/* The look beside the first scene's file, as far as it can be read, so that the engine is made for it. What is wrong
 * with it is said when the scene has been opened. */
static void view_first_look(view *v)
{
	char path[PATH_MAX];
	stilb_post_preset *preset;
	snprintf(path, sizeof path, "%s" STILB_POST_PRESET_SUFFIX, v->name);
	if (!v->options.picture.preset && access(path, F_OK) == 0 && stilb_post_preset_open(path, &preset) == STILB_OK) {
		live_options_look(&v->options, preset);
		v->own_look = true;
	}
}

int view_command(int argc, char **argv)
{
	static const live_program program = {
		.keys = &view_keys,
		.picture = "stilb-view.png",
		.frames = 1,
		.software_frames = 1,
		.start = view_start,
		.update = view_update,
		.act = view_act,
		.release = view_release,
		.finish = view_finish,
		.title = view_title,
	};
	static const live_help help = {
		"stilb view [SCENE] [FLAGS]: shows a scene in a window, or headless in a picture. SCENE is a file (glTF, OBJ, "
		"...)\n"
		"or a built-in scene, as in 'stilb render'; without it spheres. A file that changes on disk is read again.",
		"frames, 1..1000000 (headless 1; in a window endless)",
		&view_keys,
	};
	view v = {.options = live_options_default(),
	          .coming = {.watch = VIEW_WATCH_NONE},
	          .watch = VIEW_WATCH_NONE,
	          .rays = view_rays_default()};
	const char *name = NULL;
	v.options.brdf = SHADE_BRDF_MICROFACET;
	flag_rows own = {0};
	const flag title[] = {{"The scene", FLAG_TITLE, NULL, NULL, NULL, 0, 0, NULL}};
	const flag rows[] = {
		{"scene", FLAG_WORD, &name, NULL, NULL, 0, 0, NULL},
		{"--inset", FLAG_TEXT, &v.inset, "CAMERA", "show another camera, as --camera names one, in a corner", 0, 0,
	     NULL},
		{"--turntable", FLAG_NUMBER, &v.turntable, "N", "N pictures of a whole turn, --screenshot FILE with numbers", 1,
	     100000, NULL},
	};
	flag_rows_add(&own, title, 1);
	picture_flags_add(&v.options.picture, PICTURE_PLACE, &own);
	picture_flags_add(&v.options.picture, PICTURE_POSE, &own);
	picture_flags_add(&v.options.picture, PICTURE_LOOK, &own);
	flag_rows_add(&own, rows, sizeof rows / sizeof *rows);
	view_rays_add(&v.rays, &own);
	flags_result parsed = live_options_parse(&v.options, &help, own.rows, own.count, argc, argv);
	if (parsed == FLAGS_HELP)
		return EXIT_DONE;
	if (parsed == FLAGS_REFUSED || !view_check(&v)) {
		live_options_finish(&v.options);
		return EXIT_REFUSED;
	}
	view_rays_begin(&v.rays);
	v.environment = v.options.picture.environment;
	v.name = strdup(name ? name : VIEW_SCENE);
	if (!v.name) {
		stilb_log("no memory for a name");
		return EXIT_FAILED;
	}
	view_first_look(&v);
	live_run run = {.options = &v.options, .program = &program, .user = &v};
	int code = live_run_main(&run);
	live_options_finish(&v.options);
	stilb_scene_destroy(v.scene);
	free(v.dropping);
	free(v.dropped);
	free(v.name);
	return code;
}
