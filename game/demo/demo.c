/* stilb demo: draws the stress test, a scene of thousands of models, in a window or headless, which is without one. */
#include "game/commands.h"
#include "game/live/live_run.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>

#define DEMO_VIEWS 3u /* number of values of stilb_scene_stress_view */

typedef struct demo {
	live_options options;
	uint64_t models, seed, cameras;
	uint64_t figures;           /* that walk between the models */
	uint64_t lamps;             /* over the tiles */
	bool strings;               /* the lamps hang on strings */
	bool carried;               /* lamps that figures carry */
	bool animate;               /* a tenth of the models moves */
	int view;                   /* a stilb_scene_stress_view */
	int light;                  /* a stilb_scene_stress_light, as the flag chose it; below 0: it was not given */
	stilb_engine_choice lights; /* and as the user chooses it in the materials' window */
	uint32_t shown;             /* the one that the scene has; UINT32_MAX: none so far */
	stilb_scene *scene;
	live_run *run;
} demo;

/* Rows of the table of actions. */
enum { DEMO_NEXT_VIEW = STILB_ENGINE_ACTIONS };
static const stilb_input_action demo_rows[] = {
	{.name = "next view",
     .keys = {STILB_WINDOW_KEY_V},
     .pad = STILB_INPUT_PAD(EAST) | STILB_INPUT_PAD(RIGHT),
     .main = true,
     .help = "next view"},
};
static const live_keys demo_keys = {demo_rows, sizeof demo_rows / sizeof *demo_rows};

static const char *const demo_views[] = {"all", "half", "few", NULL};

/* Tiles of the picture, one for each camera. */
static void demo_tiles(const demo *d, uint32_t *columns, uint32_t *rows)
{
	*columns = 1;
	while ((uint64_t)*columns * *columns < d->cameras)
		*columns += 1;
	*rows = ((uint32_t)d->cameras + *columns - 1) / *columns;
}

/* The part of the picture that shows camera number `camera`. */
static void demo_place(const demo *d, uint32_t camera, float place[4])
{
	uint32_t columns, rows;
	demo_tiles(d, &columns, &rows);
	uint32_t column = camera % columns, row = camera / columns;
	place[0] = (float)column / (float)columns;
	place[1] = (float)row / (float)rows;
	place[2] = (float)(column + 1) / (float)columns;
	place[3] = (float)(row + 1) / (float)rows;
}

/* Moves the camera to the place of the view in the engine's picture. */
static void demo_look(const demo *d, const stilb_engine *engine)
{
	uint32_t width, height, columns, rows;
	stilb_engine_size(engine, &width, &height);
	demo_tiles(d, &columns, &rows);
	float aspect = (float)width * (float)rows / ((float)height * (float)columns);
	d->scene->camera = stilb_scene_stress_camera(d->scene, (stilb_scene_stress_view)d->view, aspect);
}

/* The other cameras stand around the scene's middle, each turned on by the same angle. */
static void demo_turn_cameras(const demo *d)
{
	stilb_engine_camera cameras[STILB_ENGINE_MAX_CAMERAS] = {0};
	char names[STILB_ENGINE_MAX_CAMERAS][16];
	for (uint32_t c = 1; c < d->cameras; c++) {
		stilb_engine_camera *camera = &cameras[c - 1];
		const float *from = d->scene->camera.position;
		float angle = 6.2831853f * (float)c / (float)d->cameras;
		snprintf(names[c - 1], sizeof names[c - 1], "camera %u", c + 1);
		camera->name = names[c - 1];
		camera->camera = d->scene->camera;
		camera->camera.position[0] = from[0] * cosf(angle) + from[2] * sinf(angle);
		camera->camera.position[2] = from[2] * cosf(angle) - from[0] * sinf(angle);
		camera->camera.yaw = remainderf(d->scene->camera.yaw + angle, 6.2831853f);
		demo_place(d, c, camera->place);
	}
	stilb_engine_set_cameras(d->run->engine, cameras, (uint32_t)d->cameras - 1);
}

static stilb_result demo_start(void *user, live_run *run)
{
	demo *d = user;
	float place[4];
	d->run = run;
	demo_place(d, 0, place);
	stilb_engine_set_place(run->engine, place);
	stilb_result result = stilb_scene_create_stress((uint32_t)d->models, d->seed, &d->scene);
	if (result == STILB_OK && d->figures > 0)
		result = stilb_scene_stress_add_figures(d->scene, (uint32_t)d->figures);
	if (result == STILB_OK && d->lamps > 0)
		result = stilb_scene_stress_add_lamps(d->scene, (uint32_t)d->lamps);
	if (result == STILB_OK && d->strings)
		stilb_scene_stress_hang_strings(d->scene);
	if (result == STILB_OK && d->carried)
		result = stilb_scene_stress_add_carried(d->scene);
	/* Smaller than a thumb at arm's length they are posed less often; joints below two milliradians stand still. */
	stilb_scene_rates rates = {.angle = 0.06f, .still = 0.002f};
	if (result == STILB_OK && d->figures > 0 && run->options->picture.detail != STILB_RENDER_DETAIL_OFF)
		result = stilb_scene_set_rates(d->scene, &rates);
	if (result != STILB_OK)
		return result;
	demo_look(d, run->engine);
	bool metered = false;
	picture_flags_tone(&run->options->picture, d->scene);
	if (run->options->picture.exposure)
		result = picture_flags_expose(&run->options->picture, d->scene, &metered);
	if (result != STILB_OK)
		return result;
	return stilb_engine_set_scene(run->engine, d->scene);
}

static void demo_update(void *user, const stilb_engine_update *update)
{
	demo *d = user;
	if (d->shown != d->lights.chosen) { /* else what the window of lights has changed stays */
		stilb_scene_stress_set_light(d->scene, (stilb_scene_stress_light)d->lights.chosen);
		d->shown = d->lights.chosen;
	}
	if (d->lamps > 0)
		stilb_scene_stress_move_lamps(d->scene, update->seconds);
	if (d->animate)
		stilb_scene_animate(d->scene, update->seconds);
	if (d->cameras > 1)
		demo_turn_cameras(d);
}

static stilb_result demo_act(void *user, live_run *run, const stilb_engine_report *report)
{
	demo *d = user;
	uint32_t views = report->input.actions[DEMO_NEXT_VIEW];
	if (views % DEMO_VIEWS > 0) {
		d->view = (int)(((uint32_t)d->view + views) % DEMO_VIEWS);
		demo_look(d, run->engine);
	}
	return STILB_OK;
}

static void demo_title(void *user, const live_run *run, char title[static 256])
{
	const demo *d = user;
	uint32_t workers = stilb_engine_workers(run->engine);
	snprintf(title, 256, "Stilb: %u of %" PRIu64 " models, %u worker%s, frame %.1f ms", run->report.visible, d->models,
	         workers, workers == 1 ? "" : "s", run->report.times.frame);
}

static void demo_finish(void *user)
{
	const demo *d = user;
	if (!d->scene || d->figures == 0)
		return;
	stilb_scene_play_counts counts = stilb_scene_play_counts_of(d->scene);
	fprintf(live_message_stream(&d->options),
	        "figures: %" PRIu64 "; in the last frame %" PRIu32 " got poses of %" PRIu64 " channels, %" PRIu64
	        " channels stood still, %" PRIu32 " figures waited (--lod off: none)\n",
	        d->figures, counts.sampled, counts.channels, counts.still, counts.waiting);
}

/* Refuses flags without those that they are of. */
static bool demo_check(const demo *d)
{
	if (d->strings && d->lamps == 0) {
		stilb_log("--light-strings is of --lights, the number of bulbs; give that, too");
		return false;
	}
	if (d->carried && d->figures == 0) {
		stilb_log("--carried-lights is of --figures, which carry them; give that, too");
		return false;
	}
	return true;
}

int demo_command(int argc, char **argv)
{
	static const live_program program = {
		.keys = &demo_keys,
		.picture = "stilb-demo.png",
		.frames = 120,
		.software_frames = 30, /* each takes a quarter of a second */
		.start = demo_start,
		.update = demo_update,
		.act = demo_act,
		.title = demo_title,
		.finish = demo_finish,
	};
	static const live_help help = {
		"stilb demo: the stress test. Each model is a sphere over a ground tile, each with its own material.",
		"frames, 1..1000000 (headless 120, in software 30; in a window endless)",
		&demo_keys,
	};
	demo d = {
		.options = live_options_default(), .models = 10000, .seed = 1, .cameras = 1, .light = -1, .shown = UINT32_MAX};
	const flag own[] = {
		{"The scene", FLAG_TITLE, NULL, NULL, NULL, 0, 0, NULL},
		{"--models", FLAG_NUMBER, &d.models, "N", "models, 1..4000000 (10000)", 1, STILB_SCENE_MAX_MODELS, NULL},
		{"--seed", FLAG_NUMBER, &d.seed, "N", "of the random sizes and colours, 0..2^64-1 (1)", 0, UINT64_MAX, NULL},
		{"--animate", FLAG_SWITCH, &d.animate, NULL, "move a tenth of the models each frame", 0, 0, NULL},
		{"--figures", FLAG_NUMBER, &d.figures, "N", "figures with skins that walk between them, 0..100000 (0)", 0,
	     100000, NULL},
		{"--view", FLAG_CHOICE, &d.view, "all|half|few", "how many models the camera sees (all)", 0, 0, demo_views},
		{"--cameras", FLAG_NUMBER, &d.cameras, "N",
	     "cameras around the scene, each in a tile of the picture, 1..16 (1)", 1, STILB_ENGINE_MAX_CAMERAS + 1, NULL},
		{"--carried-lights", FLAG_SWITCH, &d.carried, NULL, "each figure carries three small lamps", 0, 0, NULL},
		{"--lights", FLAG_NUMBER, &d.lamps, "N",
	     "coloured lamps that hang over the tiles, move and swing, 0..1000000 (0)", 0, STILB_SCENE_MAX_LAMPS, NULL},
		{"--light-strings", FLAG_SWITCH, &d.strings, NULL, "these lamps are bulbs on strings of fifty", 0, 0, NULL},
		{"--light-model", FLAG_CHOICE, &d.light, "NAME",
	     "the sun, the sky alone, a kind of lamp, or night (sun; night with lamps)", 0, 0,
	     stilb_scene_stress_light_names},
	};
	flags_result parsed = live_options_parse(&d.options, &help, own, sizeof own / sizeof *own, argc, argv);
	if (parsed == FLAGS_HELP)
		return EXIT_DONE;
	if (parsed == FLAGS_REFUSED || !live_options_check(&d.options) || !demo_check(&d)) {
		live_options_finish(&d.options);
		return EXIT_REFUSED;
	}
	if (d.light < 0)
		d.light = d.lamps > 0 || d.carried ? STILB_SCENE_STRESS_LIGHT_NIGHT : STILB_SCENE_STRESS_LIGHT_SUN;
	d.lights = (stilb_engine_choice){"Light", stilb_scene_stress_light_names, STILB_SCENE_STRESS_LIGHT_COUNT,
	                                 (uint32_t)d.light, 0};
	live_run run = {.options = &d.options, .program = &program, .user = &d, .light = &d.lights};
	int code = live_run_main(&run);
	live_options_finish(&d.options);
	stilb_scene_destroy(d.scene);
	return code;
}
