/* stilb replay: draws a frame that `stilb demo --dump` wrote again and again, and measures the cost of its commands. */
#include "game/cli/flags.h"
#include "game/cli/picture_flags.h"
#include "game/cli/stage_times.h"
#include "game/commands.h"

#include "base/base_file.h"
#include "base/base_json.h"
#include "image/image.h"
#include "replay.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define REPLAY_FRAMES 120u
#define REPLAY_MEASURE_SECONDS 0.5

typedef struct replay_options {
	uint64_t frames;
	uint32_t workers, size[2];
	picture_flags picture;
	bool headless; /* headless has no effect: there never is a window */
	const char *file, *until, *screenshot, *stats, *plan;
} replay_options;

typedef struct replay_run {
	replay_options options;
	stilb_engine_replay *replay;
	stage_times times;
	stilb_render_stats render; /* of the last frame that was drawn before the costs of commands are measured */
	uint64_t hash;             /* of the command stream of that frame */
} replay_run;

/* ---- flags ------------------------------------------------------------------------------------------------------- */

static flags_result replay_parse(replay_options *o, int argc, char **argv)
{
	const flag run[] = {
		{"--frames", FLAG_NUMBER, &o->frames, "N", "frames to draw, 1..1000000 (120)", 1, 1000000, NULL},
		{"--workers", FLAG_WORKERS, &o->workers, "N", "threads beside the main one, 0..256 or auto (CPUs - 1)", 0, 256,
	     NULL},
	};
	const flag until[] = {
		{"--until", FLAG_TEXT, &o->until, "PASS",
	     "end frames with this pass, a name or number of --plan, and show its image", 0, 0, NULL},
	};
	const flag output[] = {
		{"--size", FLAG_SIZE, o->size, "WxH", "picture size (the file's); other proportions stretch the picture", 1,
	     16384, NULL},
		{"--screenshot", FLAG_TEXT, &o->screenshot, "FILE", "the picture as .png, or its radiance as .exr or .hdr", 0,
	     0, NULL},
		{"--stats", FLAG_TEXT, &o->stats, "FILE.json", "stage times, counts, and the cost of each kind of command", 0,
	     0, NULL},
		{"--plan", FLAG_TEXT, &o->plan, "FILE", "passes, images and barriers of the last frame: .svg, else text", 0, 0,
	     NULL},
		{"--headless", FLAG_SWITCH, &o->headless, NULL, "accepted for scripts; there never is a window", 0, 0, NULL},
	};
	flag_rows table = {0};
	flag_rows_add(&table, run, sizeof run / sizeof *run);
	picture_flags_add(&o->picture, PICTURE_COMMANDS, &table);
	picture_flags_add(&o->picture, PICTURE_DEVICE, &table);
	flag_rows_add(&table, until, sizeof until / sizeof *until);
	picture_flags_add(&o->picture, PICTURE_IMAGE, &table);
	flag_rows_add(&table, output, sizeof output / sizeof *output);
	flags_result result = flags_parse(table.rows, table.count, argc, argv);
	if (result == FLAGS_HELP) {
		printf("stilb replay FILE [FLAGS]: draws a frame without its scene, and measures its commands. 'stilb demo\n"
		       "--dump FILE' writes one; - is standard input.\n\n");
		flags_print(table.rows, table.count);
	}
	return result;
}

/* True if the file exists and may be read; its content is checked when it is read. */
static bool replay_check_file(const char *path)
{
	struct stat info;
	if (strcmp(path, "-") == 0)
		return true;
	int error = stat(path, &info) != 0 || access(path, R_OK) != 0 ? errno : S_ISDIR(info.st_mode) ? EISDIR : 0;
	if (error != 0)
		stilb_log("cannot read '%s': %s; 'stilb demo --dump FILE' writes a frame", path, strerror(error));
	return error == 0;
}

/* --show: a dump has draws of whatever its frame showed, so there are images of the plan alone to choose from. */
static bool replay_check_show(const replay_options *o)
{
	stilb_render_show show;
	picture_shown image;
	if (!o->picture.show || picture_flags_show(&o->picture, &show, &image))
		return true;
	stilb_scene_surface_channel channel;
	bool of_materials = stilb_render_show_channel(show, &channel);
	stilb_log("--show: '%s' is %s; name an image of --plan, such as depth", o->picture.show,
	          of_materials ? "in no dump" : "chosen when a frame is dumped");
	return false;
}

static bool replay_outputs_differ(const replay_options *o)
{
	const char *const paths[] = {o->screenshot, o->stats, o->plan};
	for (size_t i = 0; i < sizeof paths / sizeof *paths; i++)
		for (size_t j = 0; j < i; j++)
			if (paths[i] && paths[j] && stilb_file_same(paths[i], paths[j])) {
				stilb_log("two outputs would go to '%s'; give each a name of its own", paths[i]);
				return false;
			}
	return true;
}

/* Checks what the table of flags cannot express: the files, and flags that contradict each other. Writes nothing.
 * Returns false after one line on stderr. */
static bool replay_check(const replay_options *o)
{
	if (!replay_check_file(o->file))
		return false;
	if (o->screenshot && o->picture.device == STILB_RENDER_DEVICE_NULL) {
		stilb_log("--screenshot: the null device draws no picture; use --device vulkan");
		return false;
	}
	if (!picture_flags_check(&o->picture) || !replay_check_show(o) || !replay_outputs_differ(o))
		return false;
	stilb_result result = o->screenshot ? stilb_image_path_check(o->screenshot) : STILB_OK;
	if (result == STILB_OK && o->stats)
		result = stilb_file_check(o->stats);
	if (result == STILB_OK && o->plan)
		result = stilb_file_check(o->plan);
	if (result != STILB_OK)
		stilb_log("%s", stilb_error_message());
	return result == STILB_OK;
}

/* The stream for messages: stderr if an output file is standard output, else stdout. */
static FILE *replay_message_stream(const replay_options *o)
{
	const char *const paths[] = {o->screenshot, o->stats, o->plan};
	for (size_t i = 0; i < sizeof paths / sizeof *paths; i++)
		if (paths[i] && stilb_file_is_stdout(paths[i]))
			return stderr;
	return stdout;
}

/* ---- run --------------------------------------------------------------------------------------------------------- */

static stilb_result replay_start(replay_run *run)
{
	const replay_options *o = &run->options;
	bool light = o->screenshot && stilb_image_path_is_light(o->screenshot); /* of the whole picture, insets too */
	stilb_render_output output = light ? STILB_RENDER_OUTPUT_LINEAR : STILB_RENDER_OUTPUT_DISPLAY;
	stilb_render_show show;
	picture_shown image;
	bool shows = picture_flags_show(&o->picture, &show, &image);
	stilb_render_shown shown = {
		.name = image.name, .mip = image.mip, .layer = image.layer, .low = image.low, .high = image.high};
	stilb_engine_replay_desc desc = {
		.path = o->file,
		.workers = o->workers == FLAG_WORKERS_AUTO ? stilb_engine_default_workers() : o->workers,
		.device = (stilb_render_device_kind)o->picture.device,
		.replay = (stilb_render_replay_mode)o->picture.replay,
		.materials = (stilb_render_materials)o->picture.materials,
		.output = o->screenshot ? &output : NULL,
		.gpu = o->picture.gpu,
		.width = o->size[0],
		.height = o->size[1],
		.validate = o->picture.validate,
		.shown = shows ? &shown : NULL,
		.until = o->until,
	};
	run->options.workers = desc.workers;
	return stilb_engine_replay_create(&desc, &run->replay);
}

static stilb_result replay_play(replay_run *run)
{
	stilb_engine_times times;
	double gpu_ms;
	for (uint64_t frame = 0; frame < run->options.frames; frame++) {
		stilb_result result = stilb_engine_replay_frame(run->replay, &times);
		if (result != STILB_OK)
			return result;
		if (!stage_times_add(&run->times, &times))
			return stilb_fail(STILB_ERROR_MEMORY, "no memory for the times of %" PRIu64 " frames", frame);
	}
	stilb_result result = stilb_engine_replay_wait(run->replay, &gpu_ms);
	stage_times_last_gpu(&run->times, gpu_ms);
	run->render = stilb_render_stats_get(stilb_engine_replay_render(run->replay));
	run->hash = stilb_render_stream_hash(stilb_engine_replay_render(run->replay));
	return result;
}

/* ---- results ----------------------------------------------------------------------------------------------------- */

static const stage replay_stages[] = {STAGE_FRAME, STAGE_RECORD, STAGE_REPLAY, STAGE_GPU};
#define REPLAY_STAGES (sizeof replay_stages / sizeof *replay_stages)

/* Milliseconds that all commands of a frame take, summed over their kinds; the last kind, the submission of the command
 * buffer to the device, is left out. */
static double replay_kinds_ms(const stilb_render_dump_costs *costs)
{
	double ns = 0.0;
	for (int k = 0; k < STILB_RENDER_DUMP_COSTS - 1; k++)
		ns += costs->kinds[k].known ? (double)costs->kinds[k].count * costs->kinds[k].ns : 0.0;
	return ns * 1e-6;
}

static void replay_print_costs(FILE *out, const stilb_render_dump_costs *costs)
{
	fprintf(out, "nanoseconds for one command, medians and quartiles of %" PRIu32 " rounds:\n", costs->rounds);
	fprintf(out, "  %-16s %9s %10s %10s %10s  %s\n", "kind", "a frame", "median", "low", "high", "measured as");
	for (int k = 0; k < STILB_RENDER_DUMP_COSTS; k++) {
		const stilb_render_dump_cost *cost = &costs->kinds[k];
		fprintf(out, "  %-16s %9" PRIu64 " ", cost->kind, cost->count);
		if (cost->known)
			fprintf(out, "%10.2f %10.2f %10.2f  %s\n", cost->ns, cost->low, cost->high, cost->method);
		else
			fprintf(out, "%10s %10s %10s  too few in this frame\n", "-", "-", "-");
	}
	fprintf(out, "up to the submission they add up to %.3f ms; measured together they took %.3f ms\n",
	        replay_kinds_ms(costs), costs->frame_ns * 1e-6);
}

static void replay_print(const replay_run *run, const stage_summary *summary, uint64_t warmup,
                         const stilb_render_dump_costs *costs)
{
	const replay_options *o = &run->options;
	const stilb_render *render = stilb_engine_replay_render(run->replay);
	stilb_render_dump_info info = stilb_engine_replay_info(run->replay);
	FILE *out = replay_message_stream(o);
	uint32_t width, height;
	stilb_render_size(render, &width, &height);
	fprintf(out, "%s: %" PRIu64 " draws in %u pass%s; %u mesh%s, %u material%s, %u texture%s\n", o->file, info.draws,
	        info.passes, info.passes == 1 ? "" : "es", info.meshes, info.meshes == 1 ? "" : "es", info.materials,
	        info.materials == 1 ? "" : "s", info.textures, info.textures == 1 ? "" : "s");
	fprintf(out, "%s, %ux%u; %s replay, materials by %s, %u worker%s; stream hash %016" PRIx64 ", as in the file\n",
	        stilb_render_device_name(render), width, height, picture_replay_choices[o->picture.replay],
	        picture_materials_choices[o->picture.materials], o->workers, o->workers == 1 ? "" : "s", run->hash);
	if (o->until)
		fprintf(out, "frames end with the pass '%s'; the costs of commands are those of whole frames\n", o->until);
	fprintf(out, "%" PRIu64 " frame%s, the first %" PRIu64 " not counted; milliseconds:\n", o->frames,
	        o->frames == 1 ? "" : "s", warmup);
	fprintf(out, "  %-8s %9s %9s %9s\n", "stage", "median", "p99", "min");
	for (size_t i = 0; i < REPLAY_STAGES; i++) {
		const stage_summary *s = &summary[replay_stages[i]];
		if (replay_stages[i] != STAGE_GPU || o->picture.device != STILB_RENDER_DEVICE_NULL)
			fprintf(out, "  %-8s %9.3f %9.3f %9.3f\n", stage_names[replay_stages[i]], s->median, s->p99, s->min);
	}
	replay_print_costs(out, costs);
	if (o->picture.validate)
		fprintf(out, "the validation layer was on; all of these numbers include its work\n");
}

static void replay_json_costs(stilb_json *json, const stilb_render_dump_costs *costs)
{
	stilb_json_int(json, "rounds", costs->rounds);
	stilb_json_begin(json, "kinds", '[');
	for (int k = 0; k < STILB_RENDER_DUMP_COSTS; k++) {
		const stilb_render_dump_cost *cost = &costs->kinds[k];
		stilb_json_begin(json, NULL, '{');
		stilb_json_string(json, "kind", cost->kind);
		stilb_json_int(json, "count", (int64_t)cost->count);
		stilb_json_bool(json, "known", cost->known);
		stilb_json_double(json, "ns", cost->ns);
		stilb_json_double(json, "low", cost->low);
		stilb_json_double(json, "high", cost->high);
		stilb_json_string(json, "method", cost->method);
		stilb_json_end(json, '}');
	}
	stilb_json_end(json, ']');
	stilb_json_double(json, "kinds_ms", replay_kinds_ms(costs));
	stilb_json_double(json, "measured_ms", costs->frame_ns * 1e-6);
}

static stilb_result replay_write_stats(const replay_run *run, const stage_summary *summary,
                                       const stilb_render_dump_costs *costs)
{
	const replay_options *o = &run->options;
	char hash[17];
	snprintf(hash, sizeof hash, "%016" PRIx64, run->hash);
	stilb_json json = {0};
	stilb_json_begin(&json, NULL, '{');
	stilb_json_string(&json, "file", o->file);
	stilb_json_int(&json, "draws", (int64_t)run->render.draws);
	stilb_json_int(&json, "workers", o->workers);
	stilb_json_int(&json, "frames", (int64_t)o->frames);
	stilb_json_string(&json, "device", picture_device_choices[o->picture.device]);
	stilb_json_string(&json, "device_name", stilb_render_device_name(stilb_engine_replay_render(run->replay)));
	stilb_json_string(&json, "replay", picture_replay_choices[o->picture.replay]);
	stilb_json_string(&json, "materials", picture_materials_choices[o->picture.materials]);
	stilb_json_string(&json, "stream_hash", hash);
	stilb_json_begin(&json, "commands", '{');
	stilb_json_int(&json, "draw", (int64_t)run->render.draw_commands);
	stilb_json_int(&json, "draw_indirect", (int64_t)run->render.indirect_commands);
	stilb_json_int(&json, "execute", (int64_t)run->render.execute_commands);
	stilb_json_int(&json, "binds_asked", (int64_t)run->render.binds_asked);
	stilb_json_int(&json, "binds_sent", (int64_t)run->render.binds_sent);
	stilb_json_end(&json, '}');
	stilb_json_begin(&json, "stages", '{');
	for (size_t i = 0; i < REPLAY_STAGES; i++) {
		const stage_summary *s = &summary[replay_stages[i]];
		stilb_json_begin(&json, stage_names[replay_stages[i]], '{');
		stilb_json_double(&json, "median", s->median);
		stilb_json_double(&json, "p99", s->p99);
		stilb_json_double(&json, "min", s->min);
		stilb_json_end(&json, '}');
	}
	stilb_json_end(&json, '}');
	replay_json_costs(&json, costs);
	stilb_json_end(&json, '}');
	return stilb_json_save(&json, o->stats);
}

static bool replay_say_result(const replay_run *run, stilb_result result, const char *what, const char *path)
{
	if (result == STILB_OK)
		fprintf(replay_message_stream(&run->options), "%s: %s\n", what, path);
	else
		stilb_log("%s", stilb_error_message());
	return result == STILB_OK;
}

/* Writes all outputs, measures, and prints the results; an output that fails does not keep the others from being
 * written. Returns true if everything succeeded. */
static bool replay_finish(replay_run *run)
{
	const replay_options *o = &run->options;
	stage_summary summary[STAGE_COUNT];
	stilb_render_dump_costs costs;
	uint64_t warmup;
	bool good = stage_times_summarise(&run->times, summary, &warmup);
	if (!good)
		stilb_log("no memory to sort the stage times; they are reported as 0");
	if (o->screenshot)
		good &= replay_say_result(run, stilb_engine_replay_screenshot(run->replay, o->screenshot), "picture",
		                          o->screenshot);
	if (o->plan)
		good &= replay_say_result(run, stilb_engine_replay_save_plan(run->replay, o->plan), "plan", o->plan);
	if (stilb_engine_replay_measure(run->replay, REPLAY_MEASURE_SECONDS, &costs) != STILB_OK) {
		stilb_log("%s", stilb_error_message());
		return false;
	}
	if (o->stats)
		good &= replay_say_result(run, replay_write_stats(run, summary, &costs), "stats", o->stats);
	replay_print(run, summary, warmup, &costs);
	uint32_t messages = stilb_render_validation_messages(stilb_engine_replay_render(run->replay));
	if (messages > 0)
		stilb_log("the validation layer had %u message%s", messages, messages == 1 ? "" : "s");
	return good && messages == 0;
}

static int replay_main(replay_run *run)
{
	stilb_result started = replay_start(run), played = started == STILB_OK ? replay_play(run) : started;
	if (played != STILB_OK) {
		picture_flags_log_start(&run->options.picture, played);
		/* Damage to a file may be noticed only in the first frame, when the hash of its draws differs from the
		 * file's; and only a frame has the passes and images that --until and --show name. */
		bool refused = started != STILB_OK || played == STILB_ERROR_FILE || played == STILB_ERROR_ARGUMENT;
		return refused ? exit_code_of(played) : EXIT_FAILED;
	}
	return replay_finish(run) ? EXIT_DONE : EXIT_FAILED;
}

int replay_command(int argc, char **argv)
{
	replay_run run = {
		.options = {.picture = picture_flags_default(), .frames = REPLAY_FRAMES, .workers = FLAG_WORKERS_AUTO}};
	bool named = argc > 0 && (argv[0][0] != '-' || argv[0][1] == '\0');
	flags_result parsed = replay_parse(&run.options, argc - named, argv + named);
	if (parsed == FLAGS_HELP)
		return EXIT_DONE;
	if (parsed == FLAGS_REFUSED)
		return EXIT_REFUSED;
	if (!named || argv[0][0] == '\0') {
		stilb_log("no file to draw; give it before the flags: stilb replay FILE");
		return EXIT_REFUSED;
	}
	run.options.file = argv[0];
	if (!replay_check(&run.options))
		return EXIT_REFUSED;
	int code = replay_main(&run);
	stilb_engine_replay_destroy(run.replay);
	stage_times_finish(&run.times);
	return code;
}
