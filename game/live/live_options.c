#include "live_options.h"

#include "live_draw.h"

#include "base/base_file.h"
#include "game/cli/trace_path.h"
#include "image/image.h"
#include "input/input_recording.h"
#include "shading/shade_brdf.h"

#include <inttypes.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const char *const live_edge_choices[] = {"feather", "article", "off", NULL};       /* as stilb_ui_aa */
static const char *const live_present_choices[] = {"fifo", "mailbox", "immediate", NULL}; /* as its enumeration */
const char *const live_cull_choices[] = {"auto", "octree", "flat", NULL};                 /* as stilb_cull_method */

live_options live_options_default(void)
{
	return (live_options){
		.picture = picture_flags_default(),
		.brdf = stilb_render_shading_default().brdf,
		.size = {1280, 720},
		.workers = FLAG_WORKERS_AUTO,
		.profile_ring = 64,
		.sensitivity = 1.0f,
		.scale = 1.0f,
	};
}

static void live_add_run(live_options *o, flag_rows *table)
{
	const flag run[] = {
		{"The run", FLAG_TITLE, NULL, NULL, NULL, 0, 0, NULL},
		{"--frames", FLAG_NUMBER, &o->frames, "N", o->frames_help, 1, 1000000, NULL},
		{"--workers", FLAG_WORKERS, &o->workers, "N", "threads beside the main one, 0..256 or auto (CPUs - 1)", 0, 256,
	     NULL},
		{"--headless", FLAG_SWITCH, &o->headless, NULL, "open no window", 0, 0, NULL},
		{"--present", FLAG_CHOICE, &o->present, "MODE",
	     "how frames get to the window: fifo, mailbox (the newest) or immediate (fifo)", 0, 0, live_present_choices},
		{"--no-present", FLAG_SWITCH, &o->no_present, NULL, "draw the frames, but do not show them", 0, 0, NULL},
		{"--cull", FLAG_CHOICE, &o->cull, "METHOD", "auto, octree or flat (auto)", 0, 0, live_cull_choices},
		{"--wait-textures", FLAG_SWITCH, &o->wait_textures, NULL,
	     "draw no frame without all textures, as without a window", 0, 0, NULL},
		{"--watch-shaders", FLAG_SWITCH, &o->watch_shaders, NULL, "show shaders anew as soon as their files change", 0,
	     0, NULL},
		{"--no-watch-shaders", FLAG_SWITCH, &o->no_watch_shaders, NULL,
	     "do not, which a debug build does in a window by itself", 0, 0, NULL},
		{"--shaders", FLAG_TEXT, &o->shaders, "DIR", "watch these: the folder 'engine' of Stilb's sources", 0, 0, NULL},
	};
	const flag device[] = {{"The device and its pictures", FLAG_TITLE, NULL, NULL, NULL, 0, 0, NULL}};
	const flag size[] = {
		{"--size", FLAG_SIZE, o->size, "WxH", "picture size, 1x1..16384x16384 (1280x720)", 1, 16384, NULL}};
	const flag scale[] = {{"--render-scale", FLAG_AMOUNT, &o->scale, "X",
	                       "draw the scene in X times the picture's width and height, 0.1..4 (1)", 0, 4, NULL}};
	const flag materials[] = {{"Materials and light", FLAG_TITLE, NULL, NULL, NULL, 0, 0, NULL}};
	flag_rows_add(table, run, sizeof run / sizeof *run);
	picture_flags_add(&o->picture, PICTURE_COMMANDS, table);
	flag_rows_add(table, device, 1);
	picture_flags_add(&o->picture, PICTURE_DEVICE, table);
	flag_rows_add(table, size, 1);
	flag_rows_add(table, scale, 1);
	picture_flags_add(&o->picture, PICTURE_SAMPLES, table);
	picture_flags_add(&o->picture, PICTURE_DETAIL, table);
	picture_flags_add(&o->picture, PICTURE_EXPOSURE, table);
	picture_flags_add(&o->picture, PICTURE_TONE, table);
	flag_rows_add(table, materials, 1);
	picture_flags_add(&o->picture, PICTURE_LIGHTING, table);
	picture_flags_add(&o->picture, PICTURE_POST, table);
	picture_flags_add(&o->picture, PICTURE_BRDF, table);
	picture_flags_add(&o->picture, PICTURE_ADDED, table);
}

static void live_add_windows(live_options *o, flag_rows *table)
{
	const flag windows[] = {
		{"Windows over the picture", FLAG_TITLE, NULL, NULL, NULL, 0, 0, NULL},
		{"--draw", FLAG_TEXT, &o->draw, "WHAT,...",
	     "bounds (of models in view), lights, axes (with a grid), also in saved pictures", 0, 0, NULL},
		{"--overlay", FLAG_SWITCH, &o->overlay, NULL, "show the profiler from the start, also in saved pictures", 0, 0,
	     NULL},
		{"--inspector", FLAG_SWITCH, &o->inspector, NULL, "show the materials from the start, also in saved pictures",
	     0, 0, NULL},
		{"--clips", FLAG_SWITCH, &o->clips, NULL, "show the animation's window from the start, also in saved pictures",
	     0, 0, NULL},
		{"--effects-window", FLAG_SWITCH, &o->effects, NULL, "show the effects from the start, likewise", 0, 0, NULL},
		{"--lights-window", FLAG_SWITCH, &o->lights, NULL, "show the list of lights from the start, likewise", 0, 0,
	     NULL},
		{"--keys", FLAG_SWITCH, &o->keys, NULL, "show the list of keys from the start, also in saved pictures", 0, 0,
	     NULL},
		{"--times", FLAG_SWITCH, &o->times, NULL, "show frame rate and time, also in the picture of --screenshot", 0, 0,
	     NULL},
		{"--ui-aa", FLAG_CHOICE, &o->ui_aa, "MODE",
	     "their edges: feather (soft), article (soft outside only) or off (feather)", 0, 0, live_edge_choices},

		{"Gamepads", FLAG_TITLE, NULL, NULL, NULL, 0, 0, NULL},
		{"--gamepad", FLAG_TEXT, &o->gamepad, "SOURCE",
	     "auto, off, hidraw, hidapi or replay:FILE (auto: hidraw in a window)", 0, 0, NULL},
		{"--invert-y", FLAG_SWITCH, &o->invert_y, NULL, "pushing the right stick up looks down", 0, 0, NULL},
		{"--sensitivity", FLAG_AMOUNT, &o->sensitivity, "X", "of looking with the right stick, 0..10 (1)", 0, 10, NULL},
	};
	flag_rows_add(table, windows, sizeof windows / sizeof *windows);
}

static void live_add_output(live_options *o, flag_rows *table)
{
	const flag output[] = {
		{"Output", FLAG_TITLE, NULL, NULL, NULL, 0, 0, NULL},
		{"--screenshot", FLAG_TEXT, &o->screenshot, "FILE", "the last frame as .png, or its radiance as .exr or .hdr",
	     0, 0, NULL},
		{"--photo", FLAG_SIZE, o->photo, "WxH", "another size of it, and of a key's pictures, by tiles: up to 65536", 1,
	     STILB_ENGINE_PHOTO_SIDE, NULL},
		{"--photo-tile", FLAG_NUMBER, &o->photo_tile, "N", "side of these tiles, pixels, 64, 128, ... 8192 (1024)",
	     STILB_ENGINE_PHOTO_STEP, 8192, NULL},
		{"--stats", FLAG_TEXT, &o->stats, "FILE.json", "stage times and counts", 0, 0, NULL},
		{"--track", FLAG_TEXT, &o->track, "FILE", "the camera's path, a line for each frame", 0, 0, NULL},
		{"--save-preset", FLAG_TEXT, &o->save_preset, "FILE.json", "the look at the end, for --preset", 0, 0, NULL},
		{"--plan", FLAG_TEXT, &o->plan, "FILE", "passes, images and barriers of the last frame: .svg, else text", 0, 0,
	     NULL},
		{"--dump", FLAG_TEXT, &o->dump, "FILE", "the commands of the last frame, for 'stilb replay'", 0, 0, NULL},
		{"--trace", FLAG_TEXT, &o->trace, "FILE", "a trace of the last 1000 frames: .json, .folded or .csv", 0, 0,
	     NULL},
		{"--capture", FLAG_TEXT, &o->capture, "FILE", "traces by P, SIGUSR1 or --spike, numbered (" LIVE_CAPTURE ")", 0,
	     0, NULL},
		{"--spike", FLAG_TEXT, &o->spike, "off|auto|MS",
	     "capture slow frames: longer than MS, or than twice the median (off)", 0, 0, NULL},
		{"--profile-ring", FLAG_NUMBER, &o->profile_ring, "MIB",
	     "size of each thread's profile, 1, 2, 4, ... 1024 (64)", 1, STILB_ENGINE_PROFILE_RING_MAX, NULL},
		{"--no-profile", FLAG_SWITCH, &o->no_profile, NULL, "record no profile", 0, 0, NULL},
		{"--fault", FLAG_TEXT, &o->fault, "KIND:N",
	     "for tests: memory:N or frame lost:N fails, surface:N is lost, slow:N is slow", 0, 0, NULL},
	};
	flag_rows_add(table, output, sizeof output / sizeof *output);
}

/* Those of the device's images that are drawn only if asked for (render_images.h). */
static const char *const live_images[][2] = {
	{"velocity", "pixels to where what is seen was in the frame before"},
	{"surface normal", "the normal that is shaded with, on the octahedral map"},
	{"id", "which model is seen"},
	{"ambient", "the surroundings' light that surfaces scatter, apart from all other"},
	{"reflection", "likewise what highlights mirror"},
};

/* Flags that a preset says, too, in the order of the bits of look_given, and of `words` in live_options_look. */
static const char *const live_look_flags[] = {"--ao",
                                              "--ao-radius",
                                              "--bloom",
                                              "--bloom-width",
                                              "--bloom-format",
                                              "--post",
                                              "--dither",
                                              "--aa",
                                              "--motion-blur",
                                              "--motion-blur-most",
                                              "--reflections",
                                              "--dof",
                                              "--motion-blur-of",
                                              "--motion-blur-far",
                                              "--aperture",
                                              "--focus",
                                              "--blades",
                                              "--exposure",
                                              "--tone"};

void live_options_look(live_options *o, stilb_post_preset *preset)
{
	STILB_ASSERT(o);
	static const stilb_post_settings none = {0};
	picture_flags *p = &o->picture;
	const stilb_post_settings *s = preset ? &preset->settings : &none;
	const struct {
		void *to;
		const void *from;
	} words[] = {
		{&p->occlusion, &s->occlusion},
		{&p->occlusion_radius, &s->occlusion_radius},
		{&p->bloom, &s->bloom},
		{&p->bloom_width, &s->bloom_width},
		{&p->bloom_format, &s->bloom_format},
		{&p->post_place, &s->place},
		{&p->dither, &s->dither},
		{&p->aa, &s->aa},
		{&p->motion_blur, &s->motion_blur},
		{&p->motion_blur_most, &s->motion_blur_most},
		{&p->reflections, &s->reflections},
		{&p->dof, &s->dof},
		{&p->motion, &s->motion},
		{&p->motion_blur_far, &s->motion_blur_far},
		{&p->aperture, &s->aperture},
		{&p->focus, &s->focus},
	};
	enum { WORDS = sizeof words / sizeof *words, BLADES = WORDS, EXPOSURE, TONE };
	static_assert(sizeof(float) == 4 && sizeof(int) == 4 && sizeof(stilb_post_place) == 4, "each has four bytes");
	for (uint32_t i = 0; i < WORDS; i++)
		if (!(o->look_given >> i & 1u))
			memcpy(words[i].to, words[i].from, 4);
	p->post = *s;
	if (!(o->look_given >> BLADES & 1u))
		p->blades = s->blades;
	if (p->dof != STILB_POST_DOF_OFF && p->aperture > 0.0f && p->focus == 0.0f) {
		stilb_log("depth of field needs --focus: there is none");
		p->dof = STILB_POST_DOF_OFF;
	}
	if (!(o->look_given >> EXPOSURE & 1u)) {
		bool says = preset && preset->has_exposure;
		if (says)
			snprintf(o->look_exposure, sizeof o->look_exposure, s->exposure_adapts ? "adapt" : "%.9g",
			         (double)preset->exposure);
		p->exposure = says ? o->look_exposure : NULL;
	}
	if (!(o->look_given >> TONE & 1u))
		p->tone = preset && preset->has_tone ? (int)preset->tone : PICTURE_NOT_GIVEN;
	stilb_post_preset_destroy(o->preset);
	o->preset = preset;
}

static char *live_copy(const char *text)
{
	return text ? strdup(text) : NULL;
}

stilb_result live_options_look_of(const live_options *o, const stilb_engine *engine, stilb_post_preset **look)
{
	const stilb_post_preset *from = o->preset;
	stilb_post_preset *made = *look = calloc(1, sizeof *made);
	if (!made)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a preset");
	made->settings = stilb_engine_post(engine);
	char *end = NULL;
	made->exposure = o->picture.exposure ? strtof(o->picture.exposure, &end) : 0.0f;
	made->has_exposure = end && end != o->picture.exposure && *end == '\0';
	made->has_tone = o->picture.tone != PICTURE_NOT_GIVEN;
	made->tone = made->has_tone ? (uint32_t)o->picture.tone : 0;
	const char *grade = o->picture.grade ? o->picture.grade : from ? from->grade_file : NULL;
	made->grade_file = live_copy(grade);
	made->area_count = from ? from->area_count : 0;
	for (uint32_t a = 0; a < made->area_count; a++) {
		made->areas[a] = from->areas[a]; /* with the tables of that one, which is there */
		made->area_files[a] = live_copy(from->area_files[a]);
	}
	bool named = !grade == !made->grade_file;
	for (uint32_t a = 0; a < made->area_count; a++)
		named &= !from->area_files[a] == !made->area_files[a];
	stilb_result result = grade ? stilb_post_table_open(grade, &made->grade) : STILB_OK;
	if (!named)
		result = stilb_fail(STILB_ERROR_MEMORY, "no memory for a preset");
	if (result == STILB_OK)
		return STILB_OK;
	stilb_post_preset_destroy(made);
	*look = NULL;
	return result;
}

void live_options_finish(live_options *o)
{
	stilb_post_preset_destroy(o->preset);
	o->preset = NULL;
}

flags_result live_options_parse(live_options *o, const live_help *help, const flag *own, size_t own_count, int argc,
                                char **argv)
{
	flag_rows table = {0};
	STILB_ASSERT(o && help && own);
	o->frames_help = help->frames;
	flag_rows_add(&table, own, own_count);
	live_add_run(o, &table);
	live_add_windows(o, &table);
	live_add_output(o, &table);
	flags_result result = flags_parse(table.rows, table.count, argc, argv);
	for (uint32_t i = 0; result == FLAGS_OK && i < sizeof live_look_flags / sizeof *live_look_flags; i++)
		o->look_given |= (uint32_t)flags_given(table.rows, table.count, argc, argv, live_look_flags[i]) << i;
	if (result == FLAGS_OK && o->picture.preset) {
		stilb_post_preset *preset;
		if (stilb_post_preset_open(o->picture.preset, &preset) != STILB_OK) {
			stilb_log("--preset: %s", stilb_error_message());
			return FLAGS_REFUSED;
		}
		live_options_look(o, preset);
	}
	if (result == FLAGS_HELP) {
		printf("%s\n\n", help->purpose);
		flags_print(table.rows, table.count);
		printf("\nWhat --show shows:\n");
		for (int i = 0; i < STILB_RENDER_SHOWS; i++)
			printf("  %-18s %s\n", stilb_render_show_names[i], stilb_render_show_words[i]);
		printf("\nImages that frames have for --show:\n");
		for (size_t i = 0; i < sizeof live_images / sizeof *live_images; i++)
			printf("  %-18s %s\n", live_images[i][0], live_images[i][1]);
		printf("\nWays of --lighting:\n");
		for (int i = 0; i < STILB_RENDER_LIGHTING_WAYS; i++)
			printf("  %-18s %s\n", stilb_render_lighting_names[i], stilb_render_lighting_words[i]);
		printf("\nKinds of --ambient:\n");
		for (int i = 0; i < STILB_RENDER_AMBIENT_KINDS; i++)
			printf("  %-18s %s\n", stilb_render_ambient_names[i], stilb_render_ambient_words[i]);
		printf("\nIn the window (with a gamepad):\n");
		live_keys_print(help->keys);
	}
	return result;
}

#define LIVE_OUTPUTS 8

static const char *const live_output_flags[LIVE_OUTPUTS] = {"--screenshot", "--trace", "--stats", "--dump",
                                                            "--capture",    "--track", "--plan",  "--save-preset"};

static void live_outputs(const live_options *o, const char *paths[LIVE_OUTPUTS])
{
	paths[0] = o->screenshot;
	paths[1] = o->trace;
	paths[2] = o->stats;
	paths[3] = o->dump;
	paths[4] = o->capture;
	paths[5] = o->track;
	paths[6] = o->plan;
	paths[7] = o->save_preset;
}

FILE *live_message_stream(const live_options *o)
{
	const char *paths[LIVE_OUTPUTS];
	live_outputs(o, paths);
	for (int i = 0; i < LIVE_OUTPUTS; i++)
		if (paths[i] && stilb_file_is_stdout(paths[i]))
			return stderr;
	return stdout;
}

/* Refuses two outputs with the same file. */
static bool live_outputs_differ(const live_options *o)
{
	const char *paths[LIVE_OUTPUTS];
	live_outputs(o, paths);
	for (int i = 0; i < LIVE_OUTPUTS; i++)
		for (int k = i + 1; k < LIVE_OUTPUTS; k++)
			if (paths[i] && paths[k] && stilb_file_same(paths[i], paths[k])) {
				stilb_log("two outputs would go to '%s'; give each a name of its own", paths[k]);
				return false;
			}
	return true;
}

/* Reads --fault, "memory:3", "lost:10", "surface:5" or "slow:50"; NULL: no fault. False: it is none of these. */
static bool live_parse_fault(const char *text, live_faults *faults)
{
	*faults = (live_faults){0};
	if (!text)
		return true;
	const struct {
		const char *kind;
		uint32_t *number;
	} kinds[] = {
		{"memory:", &faults->render.allocation},
		{"lost:", &faults->render.lost_frame},
		{"surface:", &faults->render.surface_lost},
		{"slow:", &faults->slow_frame},
	};
	for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
		size_t length = strlen(kinds[i].kind);
		int end = 0;
		if (strncmp(text, kinds[i].kind, length) == 0 &&
		    sscanf(text + length, "%9" SCNu32 "%n", kinds[i].number, &end) == 1 && text[length + (size_t)end] == '\0')
			return *kinds[i].number > 0;
	}
	return false;
}

/* Reads --spike, "off", "auto" or milliseconds like "33.3", into *capture. Returns false if it is none of these. */
static bool live_parse_spike(const char *text, stilb_prof_capture_desc *capture)
{
	char *end;
	if (!text || strcmp(text, "off") == 0)
		return true;
	capture->spike = STILB_PROF_SPIKE_AUTO;
	if (strcmp(text, "auto") == 0)
		return true;
	capture->spike = STILB_PROF_SPIKE_FIXED;
	capture->spike_ms = strtod(text, &end);
	return strspn(text, "0123456789.") == strlen(text) && end != text && *end == '\0' && capture->spike_ms > 0.0 &&
	       capture->spike_ms <= 1e6;
}

/* Reads --gamepad, for example "hidraw" or "replay:flight.rec"; *recording is the file's name of the latter, else NULL.
 * Returns false if it is not known. */
static bool live_parse_gamepad(const char *text, stilb_engine_gamepad *gamepad, const char **recording)
{
	static const char *const words[] = {[STILB_ENGINE_GAMEPAD_AUTO] = "auto",
	                                    [STILB_ENGINE_GAMEPAD_OFF] = "off",
	                                    [STILB_ENGINE_GAMEPAD_HIDRAW] = "hidraw",
	                                    [STILB_ENGINE_GAMEPAD_HIDAPI] = "hidapi",
	                                    [STILB_ENGINE_GAMEPAD_REPLAY] = "replay:"};
	*gamepad = STILB_ENGINE_GAMEPAD_AUTO;
	*recording = NULL;
	if (!text)
		return true;
	for (int i = 0; i < STILB_ENGINE_GAMEPAD_REPLAY; i++)
		if (strcmp(text, words[i]) == 0) {
			*gamepad = (stilb_engine_gamepad)i;
			return true;
		}
	size_t length = strlen(words[STILB_ENGINE_GAMEPAD_REPLAY]);
	if (strncmp(text, words[STILB_ENGINE_GAMEPAD_REPLAY], length) != 0 || text[length] == '\0')
		return false;
	*gamepad = STILB_ENGINE_GAMEPAD_REPLAY;
	*recording = text + length;
	return true;
}

bool live_options_is_replay(const live_options *o)
{
	stilb_engine_gamepad gamepad;
	const char *recording;
	return live_parse_gamepad(o->gamepad, &gamepad, &recording) && recording;
}

/* True if a file can be read now, to check it, and again when the run starts. A pipe or a terminal can be read only
 * once. */
static bool live_is_readable_twice(const char *path)
{
	struct stat info;
	return strcmp(path, "-") != 0 && (stat(path, &info) != 0 || S_ISREG(info.st_mode) || S_ISDIR(info.st_mode));
}

/* Checks the source of gamepads that --gamepad names: a recording must be sound, as far as it can be read before the
 * start, and no output may replace it. */
static bool live_check_recording(const live_options *o)
{
	stilb_engine_gamepad gamepad;
	const char *path;
	if (!live_parse_gamepad(o->gamepad, &gamepad, &path)) {
		stilb_log("--gamepad: '%s' is not known; give auto, off, hidraw, hidapi or replay:FILE", o->gamepad);
		return false;
	}
	if (!path || !live_is_readable_twice(path))
		return true;
	stilb_input_recording *recording;
	if (stilb_input_recording_load(path, &recording) != STILB_OK) {
		stilb_log("--gamepad: %s", stilb_error_message());
		return false;
	}
	stilb_input_recording_free(recording);
	const char *outputs[LIVE_OUTPUTS];
	live_outputs(o, outputs);
	for (int i = 0; i < LIVE_OUTPUTS; i++)
		if (outputs[i] && stilb_file_same(path, outputs[i])) {
			stilb_log("%s: '%s' would replace the recording '%s' that --gamepad replays; give it another name",
			          live_output_flags[i], outputs[i], path);
			return false;
		}
	return true;
}

/* Checks the flags of the profiler. */
static bool live_check_profile(const live_options *o)
{
	if (o->profile_ring & (o->profile_ring - 1)) {
		stilb_log("--profile-ring: %" PRIu64 " is not a power of two; give 1, 2, 4, ... 1024", o->profile_ring);
		return false;
	}
	if (!live_parse_spike(o->spike, &(stilb_prof_capture_desc){0})) {
		stilb_log("--spike: '%s' is not known; give off, auto or milliseconds", o->spike);
		return false;
	}
	if (o->capture && stilb_file_is_stdout(o->capture)) {
		stilb_log("--capture: captures are several files, which cannot go to standard output; give a file name");
		return false;
	}
	if (!trace_path_check("--trace", o->trace) || !trace_path_check("--capture", o->capture))
		return false;
	const char *needs = o->trace ? "--trace" : o->capture ? "--capture" : o->spike ? "--spike" : NULL;
	if (o->no_profile && needs) {
		stilb_log("%s needs the profile that --no-profile switches off; leave one of them out", needs);
		return false;
	}
	return true;
}

/* Files of radiance are without effects. */
static bool live_check_radiance(const live_options *o)
{
	int aa = o->picture.aa;
	if (!o->screenshot || aa == STILB_POST_AA_NONE || !stilb_image_path_is_light(o->screenshot))
		return true;
	stilb_log("--aa %s: '%s' keeps radiance, which is without effects; leave it out, or give a .png",
	          stilb_post_aa_names[aa], o->screenshot);
	return false;
}

bool live_options_check_look(const live_options *o)
{
	return picture_flags_check_look(&o->picture) && live_check_radiance(o);
}

/* Of --photo. */
static bool live_check_photo(const live_options *o)
{
	if (o->photo_tile % STILB_ENGINE_PHOTO_STEP != 0)
		stilb_log("--photo-tile: %" PRIu64 " is no multiple of %u", o->photo_tile, STILB_ENGINE_PHOTO_STEP);
	else if (o->photo_tile > 0 && o->photo[0] == 0)
		stilb_log("--photo-tile is of --photo WxH; give that, too");
	else if (o->photo[0] > 0 && o->pictures > 0)
		stilb_log("--photo is of one picture, and there are %" PRIu64 "; give them that --size", o->pictures);
	else if ((uint64_t)o->photo[0] * o->photo[1] * 4 > STILB_IMAGE_MAX_BYTES)
		stilb_log("--photo: a picture of %" PRIu64 "x%" PRIu64 " takes more than 4 GiB; give a smaller one",
		          (uint64_t)o->photo[0], (uint64_t)o->photo[1]);
	else if (o->photo[0] > 0 && o->headless && !o->screenshot)
		stilb_log("--photo: without a window it needs --screenshot FILE");
	else
		return true;
	return false;
}

bool live_options_check(const live_options *o)
{
	const picture_flags *picture = &o->picture;
	if (!picture_flags_check(picture))
		return false;
	if (!live_parse_fault(o->fault, &(live_faults){0})) {
		stilb_log("--fault: '%s' is not known; give memory:N, lost:N, surface:N or slow:N with N from 1 on", o->fault);
		return false;
	}
	if (!live_draw_parse(o->draw, &(live_draw){0})) {
		stilb_log("--draw: '%s' is not known; give bounds, lights and axes, each once, separated by commas", o->draw);
		return false;
	}
	if (o->scale < STILB_ENGINE_MIN_SCALE) {
		stilb_log("--render-scale: %g is too small; give 0.1..4", (double)o->scale);
		return false;
	}
	if (!live_check_radiance(o))
		return false;
	if (!live_check_photo(o))
		return false;
	if (o->screenshot && picture->device == STILB_RENDER_DEVICE_NULL) {
		stilb_log("--screenshot: the null device draws no picture; use --device vulkan");
		return false;
	}
	if (picture_flags_parts(picture) && picture->brdf != PICTURE_NOT_GIVEN && picture->brdf != SHADE_BRDF_MICROFACET) {
		char brdf[FLAG_CHOICE_SIZE];
		stilb_log("--brdf: %s has no D, G and F to choose; --ndf, --g and --f are parts of --brdf microfacet",
		          flags_choice(brdf, stilb_engine_brdf_names[picture->brdf]));
		return false;
	}
	if (o->no_watch_shaders && (o->watch_shaders || o->shaders)) {
		stilb_log("%s watches shaders, which --no-watch-shaders switches off; leave one of them out",
		          o->shaders ? "--shaders" : "--watch-shaders");
		return false;
	}
	if (!live_check_profile(o) || !live_outputs_differ(o) || !live_check_recording(o))
		return false;
	stilb_isa isa;
	stilb_result result = stilb_cpu_isa(&isa);
	if (result == STILB_OK && o->screenshot)
		result = stilb_image_path_check(o->screenshot);
	const char *const files[] = {o->trace, o->stats, o->dump, o->capture, o->track, o->plan, o->save_preset};
	for (size_t i = 0; i < sizeof files / sizeof *files && result == STILB_OK; i++)
		if (files[i])
			result = stilb_file_check(files[i]);
	if (result != STILB_OK)
		stilb_log("%s", stilb_error_message());
	return result == STILB_OK;
}

/* Debug builds are for those who change the sources, in a window. */
static stilb_engine_watch live_watch(const live_options *o, bool window)
{
	bool debug = false;
#ifndef NDEBUG
	debug = true;
#endif
	if (o->watch_shaders || o->shaders)
		return STILB_ENGINE_WATCH_ON;
	return debug && window && !o->no_watch_shaders ? STILB_ENGINE_WATCH_AUTO : STILB_ENGINE_WATCH_OFF;
}

live_faults live_options_faults(const live_options *o)
{
	live_faults faults;
	bool fault = live_parse_fault(o->fault, &faults);
	STILB_ASSERT(fault && "live_options_check accepted the options");
	return faults;
}

stilb_engine_desc live_options_engine(const live_options *o)
{
	STILB_ASSERT(o->size[0] >= 1 && o->size[1] >= 1);
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.workers = o->workers == FLAG_WORKERS_AUTO ? stilb_engine_default_workers() : o->workers;
	desc.cull = (stilb_cull_method)o->cull;
	desc.device = (stilb_render_device_kind)o->picture.device;
	desc.replay = (stilb_render_replay_mode)o->picture.replay;
	desc.materials = (stilb_render_materials)o->picture.materials;
	desc.gpu = o->picture.gpu;
	desc.width = o->size[0];
	desc.height = o->size[1];
	desc.samples = (uint32_t)o->picture.samples;
	desc.max_anisotropy = (uint32_t)o->picture.max_anisotropy;
	desc.specular_aa = (stilb_render_specular_aa)o->picture.specular_aa;
	desc.scale = o->scale;
	if (o->wait_textures || o->screenshot || o->dump)
		desc.textures = STILB_ENGINE_TEXTURES_WAIT;
	desc.window = !o->headless && o->picture.device != STILB_RENDER_DEVICE_NULL;
	desc.present = !o->no_present;
	desc.presentation = (stilb_gpu_presentation)o->present;
	desc.validate = o->picture.validate;
	desc.keep_textures = o->dump;
	desc.watch_shaders = live_watch(o, desc.window);
	desc.shaders = o->shaders;
	desc.shading = picture_flags_shading(&o->picture, o->brdf);
	desc.detail = picture_flags_detail(&o->picture);
	desc.lighting = (stilb_render_lighting)o->picture.lighting;
	desc.deferred.coverage = (stilb_render_coverage)o->picture.coverage;
	desc.deferred.gbuffer = (stilb_render_gbuffer)o->picture.gbuffer;
	desc.light_lists = (stilb_render_light_lists)o->picture.light_lists;
	desc.light_tolerance = o->picture.light_tolerance;
	desc.light_fade = o->picture.light_fade;
	desc.ambient = (stilb_render_ambient)o->picture.ambient;
	desc.hdr = (stilb_render_hdr)o->picture.hdr;
	desc.shadows = (stilb_engine_shadows){.kind = (stilb_engine_shadow_kind)o->picture.shadows,
	                                      .cascades = (uint32_t)o->picture.cascades,
	                                      .size = (uint32_t)o->picture.cascade_size,
	                                      .distance = o->picture.shadow_distance,
	                                      .objects = o->picture.shadow_objects,
	                                      .faces = (stilb_engine_shadow_faces)o->picture.shadow_faces,
	                                      .samples = (uint32_t)o->picture.shadow_samples,
	                                      .bias = (stilb_engine_shadow_bias)o->picture.shadow_bias,
	                                      .filter = (stilb_engine_shadow_filter)o->picture.shadow_filter};
	desc.post = picture_flags_post(&o->picture);
	picture_shown image;
	picture_flags_show(&o->picture, &desc.show, &image);
	desc.ambient_apart = stilb_engine_image_is_of_one_sample(image.name);
	bool gamepad = live_parse_gamepad(o->gamepad, &desc.gamepad, &desc.gamepad_recording);
	desc.control.invert_y = o->invert_y;
	desc.control.sensitivity[2] = desc.control.sensitivity[3] = o->sensitivity;
	desc.overlay = o->overlay;
	desc.inspector = o->inspector;
	desc.clips = o->clips;
	desc.lights = o->lights;
	desc.effects = o->effects;
	desc.keys = o->keys;
	desc.hint = !o->screenshot; /* which saves the last frame as the window shows it */
	desc.times = o->times || (desc.window && !o->screenshot);
	desc.saves = true;
	desc.ui_aa = (stilb_ui_aa)o->ui_aa;
	desc.profile = !o->no_profile;
	desc.profile_ring_mib = (uint32_t)o->profile_ring;
	desc.capture.path = o->capture ? o->capture : LIVE_CAPTURE;
	desc.capture.process_name = "stilb";
	desc.capture.signal = SIGUSR1;
	desc.capture.crash = o->capture;
	bool spike = live_parse_spike(o->spike, &desc.capture);
	STILB_ASSERT(gamepad && spike && "live_options_check accepted the options");
	if (o->screenshot && stilb_image_path_is_light(o->screenshot)) /* with the half of --split that rays have drawn */
		desc.output = STILB_RENDER_OUTPUT_LINEAR;
	return desc;
}
