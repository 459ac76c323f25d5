/* stilb view: shows a scene in a window, or headless, which is without one. */
#include "view.h"

#include "base/base_file.h"
#include "game/commands.h"
#include "shading/shade_brdf.h"

#include <stdio.h>
#include <string.h>

#define VIEW_SCENE "spheres" /* without a scene: it has textures and all kinds of materials */
#define VIEW_KEYS                                                                                                      \
	"drag orbits, middle drag pans, the wheel comes closer, F frames the model, Home goes back,\n" LIVE_KEYS

static stilb_result view_start(void *user, live_run *run)
{
	view *v = user;
	v->run = run;
	stilb_scene *scene;
	stilb_scene_open_options open = {.allow_outside = v->options.picture.allow_outside};
	stilb_result result = stilb_scene_open_with(v->name, &open, &scene);
	if (result == STILB_OK)
		result = picture_flags_surroundings(&v->options.picture, scene);
	return result == STILB_OK ? view_show(v, scene) : result;
}

static void view_update(void *user, const stilb_engine_update *update)
{
	view_move(user, update);
}

static stilb_result view_act(void *user, live_run *run, const stilb_engine_report *report)
{
	(void)user, (void)run, (void)report;
	return STILB_OK;
}

static void view_title(void *user, const live_run *run, char title[static 256])
{
	const view *v = user;
	const char *slash = strrchr(v->name, '/');
	snprintf(title, 256, "Stilb: %.120s, frame %.1f ms", slash ? slash + 1 : v->name, run->report.times.frame);
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
	v->options.pictures = v->turntable;
	v->options.headless |= v->turntable > 0;
	return live_options_check(&v->options);
}

int view_command(int argc, char **argv)
{
	static const live_program program = {
		.keys = VIEW_KEYS,
		.picture = "stilb-view.png",
		.frames = 1,
		.software_frames = 1,
		.start = view_start,
		.update = view_update,
		.act = view_act,
		.title = view_title,
	};
	static const live_help help = {
		"stilb view [SCENE] [FLAGS]: shows a scene in a window, or headless in a picture. SCENE is a file (glTF, OBJ, "
		"...)\n"
		"or a built-in scene, as in 'stilb render'; without it spheres.",
		"frames, 1..1000000 (headless 1; in a window endless)",
		VIEW_KEYS,
	};
	view v = {.options = live_options_default()};
	v.options.brdf = SHADE_BRDF_MICROFACET;
	flag_rows own = {0};
	const flag title[] = {{"The scene", FLAG_TITLE, NULL, NULL, NULL, 0, 0, NULL}};
	const flag rows[] = {
		{"scene", FLAG_WORD, &v.name, NULL, NULL, 0, 0, NULL},
		{"--turntable", FLAG_NUMBER, &v.turntable, "N", "N pictures of a whole turn, --screenshot FILE with numbers", 1,
	     100000, NULL},
	};
	flag_rows_add(&own, title, 1);
	picture_flags_add(&v.options.picture, PICTURE_PLACE, &own);
	flag_rows_add(&own, rows, sizeof rows / sizeof *rows);
	flags_result parsed = live_options_parse(&v.options, &help, own.rows, own.count, argc, argv);
	if (parsed == FLAGS_HELP)
		return EXIT_DONE;
	if (!v.name)
		v.name = VIEW_SCENE;
	if (parsed == FLAGS_REFUSED || !view_check(&v))
		return EXIT_REFUSED;
	live_run run = {.options = &v.options, .program = &program, .user = &v};
	int code = live_run_main(&run);
	stilb_scene_destroy(v.scene);
	return code;
}
