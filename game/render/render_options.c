#include "render_options.h"

#include "base/base_file.h"
#include "engine.h"
#include "game/cli/trace_path.h"
#include "game/live/live_keys.h"
#include "image/image.h"
#include "viewer.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>
#include <strings.h>

#define RENDER_WORD(id, name, ...) #name,
#define RENDER_HELP(id, name, help, ...) {#name, help},
#define RENDER_SCENE(name, help) {name, help},

const char *const offline_samplers[] = {STILB_GI_SAMPLERS(RENDER_WORD) NULL};
static const char *const offline_dithers[] = {"off", "triangular", NULL};
const char *const offline_filters[] = {STILB_GI_FILTERS(RENDER_WORD) NULL};
const char *const offline_cache_radii[] = {"split-sphere", "hessian", "harmonic", NULL};
static const char *const isa_choices[] = {STILB_GI_ISAS(RENDER_WORD) NULL};
static const char *const only_choices[] = {"all", "indirect", NULL};
static const char *const firefly_choices[] = {"keep", "weight", NULL};
static const char *const ao_choices[] = {"hits", "distance", NULL};
static const char *const cache_choices[] = {"frozen", "live", NULL};
static const char *const switch_choices[] = {"off", "on", NULL};

#define RENDER_MAX_SAMPLES 65536

/* ---- defaults ---------------------------------------------------------------------------------------------------- */

static stilb_gi_settings options_settings_default(int integrator)
{
	static const stilb_scene nothing;
	return rays_flags_settings(&(rays_flags){.integrator = integrator}, &nothing);
}

static offline_options options_default(void)
{
	stilb_gi_settings s = options_settings_default(STILB_GI_INTEGRATOR_PATH);
	return (offline_options){
		.size = {s.width, s.height},
		.workers = FLAG_WORKERS_AUTO,
		.seed = s.seed,
		.light = rays_flags_default(),
		.sampler = (int)s.sampler,
		.filter = (int)s.filter,
		.roulette = s.roulette,
		.ao_distance = s.ao_distance,
		.cache = RENDER_NOT_GIVEN,
		.show = RENDER_NOT_GIVEN,
		.cache_error = s.cache.error,
		.cache_rays = s.cache.rays,
		.cache_radius = (int)s.cache.radius,
		.gradients = s.cache.gradients,
		.overture = s.cache.overture,
		.picture = picture_flags_default(),
		.checkpoint_s = 60.0f,
		.fps = 30.0f,
		.moments = 16,
	};
}

/* ---- flags ------------------------------------------------------------------------------------------------------- */

static void options_print(const flag *flags, size_t count)
{
	static const char *const integrators[][2] = {STILB_GI_INTEGRATORS(RENDER_HELP)};
	static const char *const channels[][2] = {STILB_SCENE_CHANNELS_OF_SURFACES(RENDER_HELP)};
	static const char *const samplers[][2] = {STILB_GI_SAMPLERS(RENDER_HELP)};
	static const char *const filters[][2] = {STILB_GI_FILTERS(RENDER_HELP)};
	char text[FLAG_CHOICE_SIZE];
	static const char *const scenes[][2] = {STILB_SCENE_BUILTINS(RENDER_SCENE)};
	printf("stilb render SCENE -o FILE [FLAGS]: renders a picture by ray tracing. SCENE is a file (glTF, OBJ, ...) or\n"
	       "one of:\n");
	for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++)
		printf("  %-18s %s\n", scenes[i][0], scenes[i][1]);
	flags_print(flags, count);
	printf("\nIntegrators:\n");
	for (size_t i = 0; i < sizeof integrators / sizeof *integrators; i++)
		printf("  %-18s %s\n", flags_choice(text, integrators[i][0]), integrators[i][1]);
	printf("\nWhat --show shows:\n");
	for (size_t i = 0; i < STILB_SCENE_CHANNELS_OF_RAYS; i++)
		printf("  %-18s %s\n", channels[i][0], channels[i][1]);
	printf("\nSamplers:\n");
	for (size_t i = 0; i < sizeof samplers / sizeof *samplers; i++)
		printf("  %-18s %s\n", flags_choice(text, samplers[i][0]), samplers[i][1]);
	printf("\nFilters:\n");
	for (size_t i = 0; i < sizeof filters / sizeof *filters; i++)
		printf("  %-18s %s\n", flags_choice(text, filters[i][0]), filters[i][1]);
	printf("\nIn the window of --preview:\n");
	stilb_input_table keys = stilb_engine_viewer_table();
	live_keys_print_table(&keys);
	printf("\nCtrl-C writes the picture so far, and OUTPUT.checkpoint, from which --resume continues.\n");
}

#define RENDER_BIT(name) (1u << STILB_GI_INTEGRATOR_##name)
#define RENDER_GATHERS (RENDER_BIT(AO) | RENDER_BIT(MONTECARLO) | RENDER_BIT(SPLIT))
#define RENDER_PATHS (RENDER_BIT(PATH) | RENDER_BIT(SPLIT) | RENDER_BIT(IRRADIANCE_CACHE))
#define RENDER_INDIRECT (RENDER_PATHS | RENDER_BIT(MONTECARLO))
#define RENDER_LIT (RENDER_INDIRECT | RENDER_BIT(DIRECT))
#define RENDER_NOISY (RENDER_LIT | RENDER_BIT(AO))
#define RENDER_SHOWN (~RENDER_BIT(CHANNEL))

/* The flags that only some integrators use, with a bit for each of those: 1 << STILB_GI_INTEGRATOR_... */
static const struct {
	const char *flag;
	uint32_t integrators;
} options_uses[] = {
	{"--exposure", RENDER_SHOWN},
	{"--grade", RENDER_SHOWN},
	{"--dither", RENDER_SHOWN},
	{"--tone", RENDER_SHOWN},
	{"--rays", RENDER_GATHERS},
	{"--depth", RENDER_INDIRECT},
	{"--roulette", RENDER_PATHS},
	{"--only", RENDER_INDIRECT},
	{"--fireflies", RENDER_LIT},
	{"--denoise", RENDER_NOISY},
	{"--brdf", RENDER_LIT},
	{"--ndf", RENDER_LIT},
	{"--g", RENDER_LIT},
	{"--f", RENDER_LIT},
	{"--ao", RENDER_BIT(AO)},
	{"--ao-distance", RENDER_BIT(AO)},
	{"--cache", RENDER_BIT(IRRADIANCE_CACHE)},
	{"--cache-error", RENDER_BIT(IRRADIANCE_CACHE)},
	{"--cache-rays", RENDER_BIT(IRRADIANCE_CACHE)},
	{"--cache-radius", RENDER_BIT(IRRADIANCE_CACHE)},
	{"--gradients", RENDER_BIT(IRRADIANCE_CACHE)},
	{"--overture", RENDER_BIT(IRRADIANCE_CACHE)},
	{"--show-records", RENDER_BIT(IRRADIANCE_CACHE)},
	{"--cache-load", RENDER_BIT(IRRADIANCE_CACHE)},
	{"--cache-save", RENDER_BIT(IRRADIANCE_CACHE)},
};

/* Prints a line for each given flag that the integrator does not use. */
static void options_say_unused(const offline_options *o, const flag *flags, size_t count, int argc, char **argv)
{
	char text[FLAG_CHOICE_SIZE];
	for (size_t i = 0; i < sizeof options_uses / sizeof *options_uses; i++)
		if (!(options_uses[i].integrators >> o->light.integrator & 1) &&
		    flags_given(flags, count, argc, argv, options_uses[i].flag))
			stilb_log("%s is ignored: --integrator %s does not use it", options_uses[i].flag,
			          flags_choice(text, rays_integrators[o->light.integrator]));
	if (!o->light.shadows && o->light.integrator != STILB_GI_INTEGRATOR_DIRECT)
		stilb_log("--shadows off is ignored: only --integrator direct can leave shadows out");
}

/* --show implies its integrator. Returns false after a line if another one is asked for, or rays do not have it. */
static bool options_show(offline_options *o, const flag *flags, size_t count, int argc, char **argv)
{
	char text[FLAG_CHOICE_SIZE];
	if (o->show == RENDER_NOT_GIVEN)
		return true;
	const char *name = stilb_scene_channel_names[o->show];
	bool given = flags_given(flags, count, argc, argv, "--integrator");
	if (o->show >= STILB_SCENE_CHANNELS_OF_RAYS)
		stilb_log("--show %s: rays have none; 'stilb view --show %s' draws it", name, name);
	else if (given && o->light.integrator != STILB_GI_INTEGRATOR_CHANNEL)
		stilb_log("--show %s is of --integrator channel, which it implies; leave out --integrator %s", name,
		          flags_choice(text, rays_integrators[o->light.integrator]));
	else {
		o->light.integrator = STILB_GI_INTEGRATOR_CHANNEL;
		o->light.channel = o->show;
		return true;
	}
	return false;
}

/* Sets the defaults that depend on other flags. */
static void options_complete(offline_options *o, const flag *flags, size_t count, int argc, char **argv)
{
	stilb_gi_settings s = options_settings_default(o->light.integrator);
	bool limited = o->seconds > 0.0f || o->error > 0.0f; /* then time or error ends the run, not a number of samples */
	if (!flags_given(flags, count, argc, argv, "--spp"))
		o->samples = limited ? RENDER_MAX_SAMPLES : s.samples;
	if (!flags_given(flags, count, argc, argv, "--rays"))
		o->rays = s.rays;
	if (!flags_given(flags, count, argc, argv, "--depth"))
		o->depth = s.depth;
	/* The overture computes the records of the irradiance cache before the picture. Without it they are made while
	 * rendering, so the cache cannot be frozen. */
	if (o->cache == RENDER_NOT_GIVEN)
		o->cache = o->overture ? STILB_GI_CACHE_FROZEN : STILB_GI_CACHE_LIVE;
	const char *extension = ".checkpoint";
	bool moves = o->frames || o->shutter > 0.0f; /* a checkpoint is of one pose */
	if (!moves && o->output && strlen(o->output) + strlen(extension) < sizeof o->checkpoint)
		snprintf(o->checkpoint, sizeof o->checkpoint, "%s%s", o->output, extension);
}

/* Fills the table with all flags of the command. */
static void options_table(offline_options *o, flag_rows *table)
{
	const flag output[] = {
		{"scene", FLAG_WORD, &o->scene, NULL, NULL, 0, 0, NULL},
		{"The picture", FLAG_TITLE, NULL, NULL, NULL, 0, 0, NULL},
		{"-o", FLAG_TEXT, &o->output, "FILE", "the picture: .exr with all layers, .hdr, .png tone mapped", 0, 0, NULL},
	};
	const flag picture[] = {
		{"--show", FLAG_CHOICE, &o->show, "CHANNEL",
	     "what surfaces are made of in place of their light, see below: base, normal, ... (light)", 0, 0,
	     stilb_scene_channel_names},
		{"--size", FLAG_SIZE, o->size, "WxH", "picture size, at most 67108864 pixels (512x512)", 1, 65536, NULL},
		{"--spp", FLAG_NUMBER, &o->samples, "N",
	     "samples a pixel, 1..65536 (64; ao, split, cache, channel 16; montecarlo 4)", 1, RENDER_MAX_SAMPLES, NULL},
		{"--time", FLAG_AMOUNT, &o->seconds, "S", "end after S seconds; 0: when all samples are done (0)", 0, 10000000,
	     NULL},
		{"--error", FLAG_AMOUNT, &o->error, "E",
	     "end when the relative error of the picture is below E, 0..1; 0: never (0)", 0, 1, NULL},
		{"--grade", FLAG_TEXT, &o->grade, "FILE.cube", "a table of colours that a .png is shown through (none)", 0, 0,
	     NULL},
		{"--dither", FLAG_CHOICE, &o->dither, "KIND", "of a .png's 8-bit codes: off, or triangular, by one (off)", 0, 0,
	     offline_dithers},
		{"--denoise", FLAG_SWITCH, &o->denoise, NULL,
	     "filter the noise out of the picture that is written: smoother, and biased, which the file states", 0, 0,
	     NULL},
		{"--workers", FLAG_WORKERS, &o->workers, "N", "threads that render, 1..256 or auto (one for each CPU)", 1,
	     STILB_JOB_MAX_WORKERS, NULL},
		{"--preview", FLAG_SWITCH, &o->preview, NULL,
	     "show the picture in a window as it gets finer; closing it ends the run", 0, 0, NULL},

		{"The scene", FLAG_TITLE, NULL, NULL, NULL, 0, 0, NULL},
	};
	const flag lens[] = {
		{"--aperture", FLAG_AMOUNT, &o->aperture, "R", "radius of the lens, metres; 0: everything is in focus (0)", 0,
	     1000, NULL},
		{"--focus", FLAG_AMOUNT, &o->focus, "D", "distance of the plane in focus, metres, with --aperture", 0, 1000000,
	     NULL},
		{"--blades", FLAG_NUMBER, &o->blades, "N", "corners of the aperture, 3..16; 0: a circle (0)", 0, 16, NULL},
	};
	const flag motion[] = {
		{"--frames", FLAG_TEXT, &o->frames, "A..B",
	     "pictures of the frames A to B of --animation, FILE-0000.png and so on, frame 0 at --at", 0, 0, NULL},
		{"--fps", FLAG_AMOUNT, &o->fps, "N", "frames a second (30)", 0, 10000, NULL},
		{"--shutter", FLAG_AMOUNT, &o->shutter, "X",
	     "share of a frame's time, from its beginning, in which what moves is blurred, 0..1 (0)", 0, 1, NULL},
		{"--moments", FLAG_NUMBER, &o->moments, "N", "poses of which the blur is made, 2..32 (16)", 2, 32, NULL},
	};
	const flag lit[] = {{"The light", FLAG_TITLE, NULL, NULL, NULL, 0, 0, NULL}};
	const flag light[] = {
		{"--depth", FLAG_NUMBER, &o->depth, "N",
	     "bounces of a path at most, 0..1024; 1: direct light only (64; montecarlo 2)", 0, 1024, NULL},
		{"--only", FLAG_CHOICE, &o->only, "all|indirect",
	     "show all light, or only what surfaces reflect onto others (all)", 0, 0, only_choices},
		{"--rays", FLAG_NUMBER, &o->rays, "N", "rays at a hit, of ao and split (16) and of montecarlo (8), 1..65536", 1,
	     65536, NULL},
		{"--roulette", FLAG_AMOUNT, &o->roulette, "P", "probability that a path continues, 0..1; 0: its throughput (0)",
	     0, 1, NULL},
		{"--fireflies", FLAG_CHOICE, &o->fireflies, "keep|weight",
	     "weight: bright samples count less, a bias that the file states (keep)", 0, 0, firefly_choices},
		{"--sampler", FLAG_CHOICE, &o->sampler, "NAME", "source of random numbers, see below (sobol)", 0, 0,
	     offline_samplers},
		{"--filter", FLAG_CHOICE, &o->filter, "NAME", "pixel filter, see below (box)", 0, 0, offline_filters},
		{"--seed", FLAG_NUMBER, &o->seed, "N", "seed of all random numbers, 0..2^64-1 (0)", 0, UINT64_MAX, NULL},
		{"--isa", FLAG_CHOICE, &o->isa, "NAME",
	     "auto, sse2, sse42, avx, avx2 or avx512; the lowest bits depend on it (auto)", 0, 0, isa_choices},
		{"--ao", FLAG_CHOICE, &o->ao, "hits|distance", "distance: near surfaces occlude more than far ones (hits)", 0,
	     0, ao_choices},
		{"--ao-distance", FLAG_AMOUNT, &o->ao_distance, "D",
	     "surfaces farther away than D metres do not occlude; 0: all do (0)", 0, 1000000, NULL},

		{"The irradiance cache", FLAG_TITLE, NULL, NULL, NULL, 0, 0, NULL},
		{"--cache", FLAG_CHOICE, &o->cache, "frozen|live",
	     "frozen: the same bits in every run; live: faster, the bits vary (frozen)", 0, 0, cache_choices},
		{"--cache-error", FLAG_AMOUNT, &o->cache_error, "A",
	     "allowed error of interpolation, 0..1: larger is coarser (0.05)", 0, 1, NULL},
		{"--cache-rays", FLAG_NUMBER, &o->cache_rays, "N", "rays that each record gathers, 16..65536 (1024)", 16, 65536,
	     NULL},
		{"--cache-radius", FLAG_CHOICE, &o->cache_radius, "NAME",
	     "split-sphere, hessian, or harmonic: split-sphere without bounds (hessian)", 0, 0, offline_cache_radii},
		{"--gradients", FLAG_CHOICE, &o->gradients, "on|off", "interpolate with the gradients of the records (on)", 0,
	     0, switch_choices},
		{"--overture", FLAG_CHOICE, &o->overture, "on|off", "compute records before the picture is begun (on)", 0, 0,
	     switch_choices},
		{"--show-records", FLAG_SWITCH, &o->show_records, NULL, "mark the positions of the records in the picture", 0,
	     0, NULL},
		{"--cache-load", FLAG_TEXT, &o->cache_load, "FILE", "start with the records that an earlier run saved", 0, 0,
	     NULL},
		{"--cache-save", FLAG_TEXT, &o->cache_save, "FILE", "save the records", 0, 0, NULL},

		{"Many machines", FLAG_TITLE, NULL, NULL, NULL, 0, 0, NULL},
		{"--part", FLAG_TEXT, &o->part, "I/N", "render share I of N of the picture, to -o FILE.part", 0, 0, NULL},
		{"--merge", FLAG_SWITCH, &o->merge, NULL, "make the picture of all its parts, which stand in place of SCENE", 0,
	     0, NULL},

		{"The run", FLAG_TITLE, NULL, NULL, NULL, 0, 0, NULL},
		{"--resume", FLAG_SWITCH, &o->resume, NULL, "continue from OUTPUT.checkpoint, if there is one", 0, 0, NULL},
		{"--checkpoint", FLAG_AMOUNT, &o->checkpoint_s, "S", "seconds between checkpoints; 0: only on Ctrl-C (60)", 0,
	     1000000, NULL},
		{"--dry-run", FLAG_SWITCH, &o->dry_run, NULL, "print the number of rays, and render nothing", 0, 0, NULL},
		{"--force", FLAG_SWITCH, &o->force, NULL, "render even if it will take minutes to hours", 0, 0, NULL},
		{"--stats", FLAG_TEXT, &o->stats, "FILE.json", "times, ray counts and settings", 0, 0, NULL},
		{"--trace", FLAG_TEXT, &o->trace, "FILE", "a trace of the threads: .json, .folded or .csv", 0, 0, NULL},
	};
	flag_rows_add(table, output, sizeof output / sizeof *output);
	rays_flags_add(&o->light, RAYS_INTEGRATOR, table);
	flag_rows_add(table, picture, sizeof picture / sizeof *picture);
	picture_flags_add(&o->picture, PICTURE_PLACE, table);
	picture_flags_add(&o->picture, PICTURE_POSE, table);
	flag_rows_add(table, motion, sizeof motion / sizeof *motion);
	picture_flags_add(&o->picture, PICTURE_EXPOSURE, table);
	picture_flags_add(&o->picture, PICTURE_LOOK, table);
	picture_flags_add(&o->picture, PICTURE_TONE, table);
	flag_rows_add(table, lens, sizeof lens / sizeof *lens);
	picture_flags_add(&o->picture, PICTURE_BRDF, table);
	flag_rows_add(table, lit, 1);
	rays_flags_add(&o->light, RAYS_SHADOWS, table);
	flag_rows_add(table, light, sizeof light / sizeof *light);
}

#define RENDER_MOST_FRAMES 100000u

/* Reads --frames. Returns false after a line if it is no range. */
static bool options_frames(offline_options *o)
{
	int end = 0;
	if (!o->frames)
		return true;
	/* Digits alone, and no more of them than sscanf can hold: it takes signs, and wraps where a number is too large. */
	bool good = strspn(o->frames, "0123456789.") == strlen(o->frames) &&
	            sscanf(o->frames, "%9" SCNu32 "..%9" SCNu32 "%n", &o->frame_first, &o->frame_last, &end) == 2 &&
	            o->frames[end] == '\0';
	if (good && o->frame_first <= o->frame_last && o->frame_last < RENDER_MOST_FRAMES)
		return true;
	stilb_log("--frames: '%s' is no A..B; give two numbers in 0..%u, the smaller one first, as 0..29", o->frames,
	          RENDER_MOST_FRAMES - 1);
	return false;
}

#define RENDER_MOST_PARTS 1000000u

/* Reads --part. Returns false after a line if it is no share. */
static bool options_part(offline_options *o)
{
	int end = 0;
	if (!o->part)
		return true;
	bool good = strspn(o->part, "0123456789/") == strlen(o->part) &&
	            sscanf(o->part, "%9" SCNu32 "/%9" SCNu32 "%n", &o->part_index, &o->part_of, &end) == 2 &&
	            o->part[end] == '\0';
	if (good && o->part_index >= 1 && o->part_index <= o->part_of && o->part_of <= RENDER_MOST_PARTS)
		return true;
	stilb_log("--part: '%s' is no I/N; give 1/4, 2/4, 3/4 and 4/4 for four parts, %u at most", o->part,
	          RENDER_MOST_PARTS);
	return false;
}

flags_result offline_options_parse(offline_options *o, int argc, char **argv)
{
	flag_rows table = {0};
	*o = options_default();
	options_table(o, &table);
	const flag *flags = table.rows;
	size_t count = table.count;
	flags_result result = flags_parse(flags, count, argc, argv);
	if (result == FLAGS_HELP)
		options_print(flags, count);
	if (result != FLAGS_OK)
		return result;
	if (!options_show(o, flags, count, argc, argv))
		return FLAGS_REFUSED;
	if (!options_frames(o) || !options_part(o))
		return FLAGS_REFUSED;
	options_complete(o, flags, count, argc, argv);
	options_say_unused(o, flags, count, argc, argv);
	return FLAGS_OK;
}

void offline_options_be_guest(offline_options *o)
{
	o->output = o->stats = o->trace = o->cache_save = NULL;
	o->grade = NULL;
	o->dither = 0;
	o->checkpoint[0] = '\0';
	o->preview = o->resume = false;
	o->guest = true;
}

/* ---- checks ------------------------------------------------------------------------------------------------------ */

#define RENDER_OUTPUTS 5

static void options_outputs(const offline_options *o, const char *paths[RENDER_OUTPUTS])
{
	paths[0] = o->output;
	paths[1] = o->checkpoint[0] ? o->checkpoint : NULL;
	paths[2] = o->stats;
	paths[3] = o->trace;
	paths[4] = o->cache_save;
}

FILE *offline_message_stream(const offline_options *o)
{
	const char *paths[RENDER_OUTPUTS];
	options_outputs(o, paths);
	for (int i = 0; i < RENDER_OUTPUTS; i++)
		if (paths[i] && stilb_file_is_stdout(paths[i]))
			return stderr;
	return stdout;
}

/* Refuses two outputs with the same file, and an output that is also an input. */
static bool options_outputs_differ(const offline_options *o)
{
	const char *outputs[RENDER_OUTPUTS], *const inputs[] = {o->scene, o->picture.environment};
	options_outputs(o, outputs);
	for (int i = 0; i < RENDER_OUTPUTS; i++) {
		for (int k = i + 1; k < RENDER_OUTPUTS; k++)
			if (outputs[i] && outputs[k] && stilb_file_same(outputs[i], outputs[k])) {
				stilb_log("two outputs would go to '%s'; give each a name of its own", outputs[k]);
				return false;
			}
		for (size_t k = 0; k < sizeof inputs / sizeof *inputs; k++)
			if (outputs[i] && inputs[k] && stilb_file_same(outputs[i], inputs[k])) {
				stilb_log("the output would replace '%s'; give it another name", inputs[k]);
				return false;
			}
	}
	return true;
}

static bool options_readable(const char *flag_name, const char *path)
{
	FILE *stream;
	if (stilb_file_read_open(path, &stream) == STILB_OK)
		return fclose(stream) == 0;
	stilb_log("%s: %s", flag_name, stilb_error_message());
	return false;
}

static bool options_files_check(const offline_options *o)
{
	if (!options_outputs_differ(o) || (o->cache_load && !options_readable("--cache-load", o->cache_load)))
		return false;
	if (!trace_path_check("--trace", o->trace))
		return false;
	const char *const others[] = {o->stats, o->trace, o->cache_save};
	stilb_result result = STILB_OK;
	for (size_t i = 0; i < sizeof others / sizeof *others && result == STILB_OK; i++)
		if (others[i])
			result = stilb_file_check(others[i]);
	if (result == STILB_OK && o->output)
		result = o->part ? stilb_file_check(o->output) : stilb_image_path_check(o->output);
	if (result != STILB_OK)
		stilb_log("%s", stilb_error_message());
	return result == STILB_OK;
}

static bool options_lens_check(const offline_options *o)
{
	if (o->aperture > 0.0f && o->focus <= 0.0f)
		stilb_log("--aperture needs --focus D, the distance of the plane in focus in metres");
	else if (o->aperture <= 0.0f && (o->focus > 0.0f || o->blades > 0))
		stilb_log("%s needs --aperture R: without it everything is in focus", o->focus > 0.0f ? "--focus" : "--blades");
	else if (o->blades == 1 || o->blades == 2)
		stilb_log("--blades: '%u' corners are too few; give 3..16, or 0 for a circle", (unsigned)o->blades);
	else
		return true;
	return false;
}

static bool options_motion_check(const offline_options *o)
{
	bool moves = o->frames || o->shutter > 0.0f;
	if (moves && (o->seconds > 0.0f || o->error > 0.0f))
		stilb_log("--time and --error end one picture; with --frames and --shutter give --spp alone");
	else if (moves && o->light.integrator == STILB_GI_INTEGRATOR_IRRADIANCE_CACHE)
		stilb_log("the irradiance cache is of one pose; with --frames and --shutter give --integrator path");
	else if (moves && o->resume)
		stilb_log("--resume continues one picture of one pose; leave out --frames and --shutter");
	else if (o->frames && (!o->output || stilb_file_is_stdout(o->output)))
		stilb_log("--frames needs -o FILE.png, whose name the pictures get with their numbers");
	else if (moves && !(o->fps > 0.0f))
		stilb_log("--fps: frames need some of them a second; give 0.001..10000");
	else if (o->shutter > 0.0f && o->samples < o->moments)
		stilb_log("--moments: %u poses need as many samples a pixel; --spp is %u", (unsigned)o->moments,
		          (unsigned)o->samples);
	else
		return true;
	return false;
}

/* What many machines cannot share: `how` is the flag or the command that asks for them. */
bool offline_options_share_check(const offline_options *o, const char *how)
{
	if (o->seconds > 0.0f)
		stilb_log("--time ends each machine's work elsewhere; with %s give --spp", how);
	else if (o->error > 0.0f)
		stilb_log("--error looks at the whole picture, which no machine has; with %s give --spp", how);
	else if (o->light.integrator == STILB_GI_INTEGRATOR_IRRADIANCE_CACHE && o->cache == STILB_GI_CACHE_LIVE)
		stilb_log("--cache live gives other bits in every run; with %s leave it out, and --overture off", how);
	else if (o->frames)
		stilb_log("--frames: with %s give each machine frames of its own instead", how);
	else if (o->shutter > 0.0f)
		stilb_log("--shutter: a blurred picture is of many poses and cannot be shared; leave out %s", how);
	else
		return true;
	return false;
}

static bool options_part_check(const offline_options *o)
{
	const char *dot = o->output ? strrchr(o->output, '.') : NULL;
	if (!o->part)
		return true;
	if (!dot || strcmp(dot, ".part") != 0 || stilb_file_is_stdout(o->output))
		stilb_log("--part makes no picture; give -o FILE.part, and --merge the parts");
	else
		return offline_options_share_check(o, "--part");
	return false;
}

/* True if the picture has noise to be filtered, and is to be. */
static bool options_denoise(const offline_options *o)
{
	return o->denoise && RENDER_NOISY >> o->light.integrator & 1;
}

static bool options_denoise_check(const offline_options *o)
{
	if (options_denoise(o) && o->samples < 2)
		stilb_log("--denoise compares the halves of a pixel's samples, and --spp 1 has none; give --spp 2 or more");
	else if (options_denoise(o) && !o->output && !o->dry_run && !o->guest)
		stilb_log("--denoise filters the picture that is written; give -o FILE");
	else
		return true;
	return false;
}

bool offline_options_check(const offline_options *o)
{
	if (!o->scene) {
		stilb_log("no scene; give one: stilb render SCENE -o FILE, a file or one of %s", stilb_scene_builtin_names());
		return false;
	}
	if (!o->output && !o->dry_run && !o->preview && !o->guest) {
		stilb_log("no output; give -o FILE.exr, -o FILE.png or --preview");
		return false;
	}
	if (!o->output && o->resume) {
		stilb_log("--resume needs -o FILE: the checkpoint is FILE.checkpoint");
		return false;
	}
	if ((uint64_t)o->size[0] * o->size[1] > STILB_GI_MAX_PIXELS) {
		stilb_log("--size: %ux%u is %" PRIu64 " pixels; at most %u are possible", o->size[0], o->size[1],
		          (uint64_t)o->size[0] * o->size[1], STILB_GI_MAX_PIXELS);
		return false;
	}
	const char *dot = o->output ? strrchr(o->output, '.') : NULL;
	if (picture_flags_are_transparent(&o->picture) && dot && strcasecmp(dot, ".hdr") == 0) {
		stilb_log("--background transparent: a .hdr has no alpha; give -o a .png or an .exr");
		return false;
	}
	bool png = dot && strcasecmp(dot, ".png") == 0;
	if ((o->grade || o->dither) && (!png || o->part)) {
		stilb_log("%s is of a .png, and %s; give -o FILE.png", o->grade ? "--grade" : "--dither",
		          o->part ? "a part has none" : "other files keep radiance");
		return false;
	}
	if (picture_flags_adapt(&o->picture)) {
		stilb_log("--exposure adapt is of frames, one after another; give EV or auto");
		return false;
	}
	return picture_flags_check(&o->picture) && options_denoise_check(o) && options_lens_check(o) &&
	       options_motion_check(o) && options_part_check(o) && options_files_check(o);
}

/* ---- settings ---------------------------------------------------------------------------------------------------- */

static shade_brdf_model options_model(const offline_options *o, shade_brdf_model model)
{
	const picture_flags *p = &o->picture;
	model.kind = p->brdf != PICTURE_NOT_GIVEN ? p->brdf : picture_flags_parts(p) ? SHADE_BRDF_MICROFACET : model.kind;
	model.ndf = p->ndf != PICTURE_NOT_GIVEN ? p->ndf : model.ndf;
	model.g = p->g != PICTURE_NOT_GIVEN ? p->g : model.g;
	model.f = p->f != PICTURE_NOT_GIVEN ? p->f : model.f;
	return model;
}

stilb_gi_settings offline_options_settings(const offline_options *o, const stilb_scene *scene)
{
	stilb_gi_settings s = rays_flags_settings(&o->light, scene);
	s.width = o->size[0];
	s.height = o->size[1];
	s.samples = (uint32_t)o->samples;
	s.seconds = (double)o->seconds;
	s.error = o->error;
	s.seed = o->seed;
	s.sampler = (stilb_gi_sampler_kind)o->sampler;
	s.filter = (stilb_gi_filter_kind)o->filter;
	s.lens.radius = o->aperture;
	s.lens.focus = o->focus > 0.0f ? o->focus : s.lens.focus;
	s.lens.blades = (uint32_t)o->blades;
	s.depth = (uint32_t)o->depth;
	s.model = options_model(o, s.model);
	s.only = (stilb_gi_only)o->only;
	s.firefly_weight = o->fireflies == 1;
	s.denoise = options_denoise(o);
	s.roulette = o->roulette;
	s.rays = (uint32_t)o->rays;
	s.ao_distance = o->ao_distance;
	s.ao_weighted = o->ao == 1;
	s.cache.mode = (stilb_gi_cache_mode)o->cache;
	s.cache.radius = (stilb_gi_cache_radius)o->cache_radius;
	s.cache.error = o->cache_error;
	s.cache.rays = (uint32_t)o->cache_rays;
	s.cache.gradients = o->gradients;
	s.cache.overture = o->overture;
	s.cache.show_records = o->show_records;
	s.cache.load = o->cache_load;
	s.cache.save = o->cache_save;
	return s;
}
