/* stilb demo: the stress test, in a window or headless. */
#include "commands.h"
#include "flags.h"
#include "stage_times.h"

#include "base/base_file.h"
#include "base/base_json.h"
#include "image/image.h"

#include <inttypes.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define DEMO_PICTURE "stilb-demo.png"
#define DEMO_TRACE "stilb-demo.trace.json"
#define DEMO_FRAMES 120u /* headless */

typedef struct demo_options {
	uint64_t models, frames, seed, samples;
	uint32_t workers, size[2];
	int view, cull, replay, materials, device;
	bool headless, no_present, animate, validate, help;
	const char *gpu, *screenshot, *trace, *stats, *dump, *fault;
} demo_options;

/* ---- flags --------------------------------------------------------------------------------------------------------- */

static const char *const view_choices[] = {"all", "half", "few", NULL};
static const char *const cull_choices[] = {"auto", "octree", "flat", NULL}; /* as stilb_cull_method */
static const char *const replay_choices[] = {"indirect", "direct", "secondary", NULL};
static const char *const materials_choices[] = {"index", "bind", "pipeline", NULL};
static const char *const device_choices[] = {"vulkan", "null", NULL};

static flags_result demo_parse(demo_options *o, int argc, char **argv)
{
	const flag flags[] = {
		{"--models", FLAG_NUMBER, &o->models, "N", "models, 1..4000000 (10000)", 1, STILB_SCENE_MAX_MODELS, NULL},
		{"--workers", FLAG_WORKERS, &o->workers, "N", "threads beside the main one, 0..256 or auto (CPUs - 1)", 0, 256,
	     NULL},
		{"--frames", FLAG_NUMBER, &o->frames, "N", "frames, 1..1000000 (120 headless, endless in a window)", 1, 1000000,
	     NULL},
		{"--headless", FLAG_SWITCH, &o->headless, NULL, "no window", 0, 0, NULL},
		{"--no-present", FLAG_SWITCH, &o->no_present, NULL, "draw, but show no frame", 0, 0, NULL},
		{"--animate", FLAG_SWITCH, &o->animate, NULL, "move a tenth of the models each frame", 0, 0, NULL},
		{"--validate", FLAG_SWITCH, &o->validate, NULL, "Vulkan validation; any message fails the run", 0, 0, NULL},
		{"--size", FLAG_SIZE, o->size, "WxH", "picture size, 1x1..16384x16384 (1280x720)", 1, 16384, NULL},
		{"--view", FLAG_CHOICE, &o->view, "all|half|few", "how many models are in view (all)", 0, 0, view_choices},
		{"--cull", FLAG_CHOICE, &o->cull, "auto|octree|flat", "culling method (auto)", 0, 0, cull_choices},
		{"--replay", FLAG_CHOICE, &o->replay, "indirect|direct|secondary",
	     "lists as they are; one command a draw; that in parallel (indirect)", 0, 0, replay_choices},
		{"--materials", FLAG_CHOICE, &o->materials, "index|bind|pipeline",
	     "by index; by descriptor set; by one of two pipelines (index)", 0, 0, materials_choices},
		{"--device", FLAG_CHOICE, &o->device, "vulkan|null", "null draws nothing: the CPU's side alone (vulkan)", 0, 0,
	     device_choices},
		{"--gpu", FLAG_TEXT, &o->gpu, "N|NAME", "which GPU: number or part of its name, see 'stilb info'", 0, 0, NULL},
		{"--msaa", FLAG_NUMBER, &o->samples, "1|4", "samples per pixel (4 on a GPU, 1 in software)", 1, 4, NULL},
		{"--seed", FLAG_NUMBER, &o->seed, "N", "of sizes and colours, 0..2^64-1 (1)", 0, UINT64_MAX, NULL},
		{"--screenshot", FLAG_TEXT, &o->screenshot, "FILE", "the last frame as .png, or its radiance as .exr", 0, 0,
	     NULL},
		{"--trace", FLAG_TEXT, &o->trace, "FILE.json", "a profiler trace of the last frames", 0, 0, NULL},
		{"--stats", FLAG_TEXT, &o->stats, "FILE.json", "stage times and counts", 0, 0, NULL},
		{"--dump", FLAG_TEXT, &o->dump, "FILE", "the last frame's commands, for 'stilb replay'", 0, 0, NULL},
		{"--fault", FLAG_TEXT, &o->fault, "memory:N|lost:N", "fail on purpose: its N-th allocation, or frame N", 0, 0,
	     NULL},
	};
	const size_t count = sizeof flags / sizeof *flags;
	flags_result result = flags_parse(flags, count, argc, argv);
	if (result == FLAGS_HELP) {
		printf(
			"stilb demo: the stress test. Each model is a sphere over a ground tile, each with its own material.\n\n");
		flags_print(flags, count);
		printf("\nIn the window: WASD fly, Q/E down/up, shift fast, right mouse looks, Esc releases the mouse,\n"
		       "P writes " DEMO_TRACE ", F12 writes " DEMO_PICTURE ", - and + change the workers.\n");
	}
	return result;
}

static bool has_extension(const char *path, const char *extension)
{
	const char *dot = strrchr(path, '.');
	return dot && strcasecmp(dot, extension) == 0;
}

#define DEMO_OUTPUTS 4

static void demo_outputs(const demo_options *o, const char *paths[DEMO_OUTPUTS])
{
	paths[0] = o->screenshot;
	paths[1] = o->trace;
	paths[2] = o->stats;
	paths[3] = o->dump;
}

/* Where the words go: not among the bytes of a file that is written to stdout. */
static FILE *demo_words(const demo_options *o)
{
	const char *paths[DEMO_OUTPUTS];
	demo_outputs(o, paths);
	for (int i = 0; i < DEMO_OUTPUTS; i++)
		if (paths[i] && stilb_file_is_stdout(paths[i]))
			return stderr;
	return stdout;
}

/* One file cannot hold two outputs. */
static bool demo_outputs_differ(const demo_options *o)
{
	const char *paths[DEMO_OUTPUTS];
	demo_outputs(o, paths);
	for (int i = 0; i < DEMO_OUTPUTS; i++)
		for (int k = i + 1; k < DEMO_OUTPUTS; k++)
			if (paths[i] && paths[k] && stilb_file_same(paths[i], paths[k])) {
				stilb_log("two outputs would go to '%s'; give each a name of its own", paths[k]);
				return false;
			}
	return true;
}

/* "memory:3", "lost:10". */
static bool demo_parse_fault(const char *text, stilb_render_faults *faults)
{
	uint32_t number;
	int end = 0;
	*faults = (stilb_render_faults){0};
	if (!text)
		return true;
	if (sscanf(text, "memory:%9" SCNu32 "%n", &number, &end) == 1 && text[end] == '\0')
		faults->allocation = number;
	else if (sscanf(text, "lost:%9" SCNu32 "%n", &number, &end) == 1 && text[end] == '\0')
		faults->lost_frame = number;
	return faults->allocation || faults->lost_frame;
}

/* What the table cannot say. Nothing has been started or written yet. */
static bool demo_check(const demo_options *o)
{
	if (o->samples != 0 && o->samples != 1 && o->samples != 4) {
		stilb_log("--msaa: %" PRIu64 " samples are not offered; give 1 or 4", o->samples);
		return false;
	}
	if (!demo_parse_fault(o->fault, &(stilb_render_faults){0})) {
		stilb_log("--fault: '%s' is not known; give memory:N or lost:N with N from 1 on", o->fault);
		return false;
	}
	if (o->screenshot && o->device == STILB_RENDER_DEVICE_NULL) {
		stilb_log("--screenshot: the null device draws no picture; use --device vulkan");
		return false;
	}
	if (!demo_outputs_differ(o))
		return false;
	stilb_isa isa;
	stilb_result result = stilb_cpu_isa(&isa);
	if (result == STILB_OK && o->screenshot)
		result = stilb_image_path_check(o->screenshot);
	if (result == STILB_OK && o->trace)
		result = stilb_file_check(o->trace);
	if (result == STILB_OK && o->stats)
		result = stilb_file_check(o->stats);
	if (result == STILB_OK && o->dump)
		result = stilb_file_check(o->dump);
	if (result != STILB_OK)
		stilb_log("%s", stilb_error_message());
	return result == STILB_OK;
}

/* ---- run ----------------------------------------------------------------------------------------------------------- */

typedef struct demo_run {
	demo_options options;
	stilb_engine *engine;
	stilb_engine_report report; /* of the last frame drawn */
	stage_times times;
	uint64_t frames; /* drawn */
	bool window;
} demo_run;

static volatile sig_atomic_t demo_interrupted;

static void demo_on_signal(int signal_number)
{
	(void)signal_number;
	demo_interrupted = 1; /* the loop ends, and what was asked for is written */
}

static stilb_engine_desc demo_engine_desc(const demo_options *o)
{
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.models = (uint32_t)o->models;
	desc.seed = o->seed;
	desc.workers = o->workers;
	desc.cull = (stilb_cull_method)o->cull;
	desc.view = (stilb_scene_stress_view)o->view;
	desc.device = (stilb_render_device_kind)o->device;
	desc.replay = (stilb_render_replay_mode)o->replay;
	desc.materials = (stilb_render_materials)o->materials;
	desc.gpu = o->gpu;
	desc.width = o->size[0];
	desc.height = o->size[1];
	desc.samples = (uint32_t)o->samples;
	desc.window = !o->headless && o->device != STILB_RENDER_DEVICE_NULL;
	desc.present = !o->no_present;
	desc.animate = o->animate;
	desc.validate = o->validate;
	demo_parse_fault(o->fault, &desc.faults);
	if (o->screenshot && has_extension(o->screenshot, ".exr")) /* the window then shows the same, clipped */
		desc.output = STILB_RENDER_OUTPUT_LINEAR;
	return desc;
}

/* Without a display the stress test runs headless. */
static stilb_result demo_start(demo_run *run)
{
	stilb_engine_desc desc = demo_engine_desc(&run->options);
	stilb_result result = stilb_engine_create(&desc, &run->engine);
	if (result == STILB_ERROR_WINDOW) {
		stilb_log("%s; running headless", stilb_error_message());
		desc.window = false;
		result = stilb_engine_create(&desc, &run->engine);
	}
	run->window = desc.window;
	return result;
}

static void demo_say_result(const demo_run *run, stilb_result result, const char *what, const char *path)
{
	if (result == STILB_OK)
		fprintf(demo_words(&run->options), "%s: %s\n", what, path);
	else
		stilb_log("%s", stilb_error_message());
}

/* What the keys asked for. A file that cannot be written is said and does not end the run. */
static stilb_result demo_act(demo_run *run, const stilb_engine_report *report)
{
	if (report->input.capture) {
		const char *path = run->options.trace ? run->options.trace : DEMO_TRACE;
		demo_say_result(run, stilb_engine_trace(run->engine, path, 0), "trace", path);
	}
	if (report->input.screenshot) {
		const char *path = run->options.screenshot ? run->options.screenshot : DEMO_PICTURE;
		demo_say_result(run, stilb_engine_screenshot(run->engine, path), "picture", path);
	}
	int64_t workers = (int64_t)stilb_engine_workers(run->engine) + report->input.workers;
	workers = workers < 0 ? 0 : workers > STILB_JOB_MAX_WORKERS ? STILB_JOB_MAX_WORKERS : workers;
	if (workers == (int64_t)stilb_engine_workers(run->engine))
		return STILB_OK;
	fprintf(demo_words(&run->options), "workers: %" PRId64 "\n", workers);
	return stilb_engine_set_workers(run->engine, (uint32_t)workers);
}

/* Twice a second the window's title says how it goes. */
static void demo_title(demo_run *run, uint64_t *last)
{
	uint64_t now = stilb_time_ns();
	char title[160];
	if (!run->window || now - *last < 500000000u)
		return;
	*last = now;
	uint32_t workers = stilb_engine_workers(run->engine);
	snprintf(title, sizeof title, "Stilb: %u of %" PRIu64 " models, %u worker%s, frame %.1f ms", run->report.visible,
	         run->options.models, workers, workers == 1 ? "" : "s", run->report.times.frame);
	stilb_engine_set_title(run->engine, title);
}

static stilb_result demo_loop(demo_run *run)
{
	uint64_t wanted = run->options.frames, last_title = 0;
	stilb_engine_report report = {0};
	if (wanted == 0)
		wanted = run->window ? UINT64_MAX : DEMO_FRAMES;
	while (run->frames < wanted && !demo_interrupted && !report.close) {
		stilb_result result = demo_act(run, &report); /* what the frame before was asked for */
		if (result == STILB_OK)
			result = stilb_engine_frame(run->engine, &report);
		if (result != STILB_OK)
			return result;
		if (report.drawn) {
			run->report = report;
			run->frames++;
			if (!stage_times_add(&run->times, &report.times))
				return stilb_fail(STILB_ERROR_MEMORY, "no memory for the times of %" PRIu64 " frames", run->frames);
		}
		demo_title(run, &last_title);
	}
	return STILB_OK;
}

/* ---- results ------------------------------------------------------------------------------------------------------- */

/* The costliest of what a frame waits for. */
static stage demo_bound(const stage_summary *summary)
{
	stage bound = STAGE_CULL;
	const stage candidates[] = {STAGE_RECORD, STAGE_REPLAY, STAGE_GPU};
	for (size_t i = 0; i < sizeof candidates / sizeof *candidates; i++)
		if (summary[candidates[i]].median > summary[bound].median)
			bound = candidates[i];
	return bound;
}

static const char *demo_bound_name(stage bound)
{
	static const char *const names[STAGE_COUNT] = {
		[STAGE_CULL] = "culling", [STAGE_RECORD] = "recording", [STAGE_REPLAY] = "replay", [STAGE_GPU] = "GPU"};
	return names[bound];
}

static stilb_result demo_write_stats(const demo_run *run, const stage_summary *summary)
{
	const demo_options *o = &run->options;
	const stilb_render_stats *render = &run->report.render;
	char hash[17];
	snprintf(hash, sizeof hash, "%016" PRIx64, stilb_engine_stream_hash(run->engine));
	stilb_json json = {0};
	stilb_json_begin(&json, NULL, '{');
	stilb_json_int(&json, "models", (int64_t)o->models);
	stilb_json_int(&json, "visible", run->report.visible);
	stilb_json_int(&json, "draws", (int64_t)render->draws);
	stilb_json_int(&json, "workers", stilb_engine_workers(run->engine));
	stilb_json_int(&json, "frames", (int64_t)run->frames);
	stilb_json_string(&json, "device", device_choices[o->device]);
	stilb_json_string(&json, "device_name", stilb_engine_device_name(run->engine));
	stilb_json_string(&json, "replay", replay_choices[o->replay]);
	stilb_json_string(&json, "materials", materials_choices[o->materials]);
	stilb_json_string(&json, "cull", cull_choices[o->cull]);
	stilb_json_string(&json, "culled_by", cull_choices[run->report.cull]);
	stilb_json_string(&json, "stream_hash", hash);
	stilb_json_begin(&json, "commands", '{');
	stilb_json_int(&json, "draw", (int64_t)render->draw_commands);
	stilb_json_int(&json, "draw_indirect", (int64_t)render->indirect_commands);
	stilb_json_int(&json, "execute", (int64_t)render->execute_commands);
	stilb_json_int(&json, "binds_asked", (int64_t)render->binds_asked);
	stilb_json_int(&json, "binds_sent", (int64_t)render->binds_sent);
	stilb_json_end(&json, '}');
	stilb_json_int(&json, "recorded_bytes", (int64_t)render->recorded_bytes);
	stilb_json_begin(&json, "stages", '{');
	for (int s = 0; s < STAGE_GPU; s++) {
		stilb_json_begin(&json, stage_names[s], '{');
		stilb_json_double(&json, "median", summary[s].median);
		stilb_json_double(&json, "p99", summary[s].p99);
		stilb_json_double(&json, "min", summary[s].min);
		stilb_json_end(&json, '}');
	}
	stilb_json_end(&json, '}');
	stilb_json_double(&json, "gpu_ms", summary[STAGE_GPU].median);
	stilb_json_string(&json, "bound", demo_bound_name(demo_bound(summary)));
	stilb_json_end(&json, '}');
	return stilb_json_save(&json, o->stats);
}

static void demo_print_summary(const demo_run *run, const stage_summary *summary, uint64_t warmup)
{
	const demo_options *o = &run->options;
	FILE *out = demo_words(o);
	bool software = stilb_engine_device_is_software(run->engine);
	uint32_t width, height, workers = stilb_engine_workers(run->engine), samples = stilb_engine_samples(run->engine);
	stilb_engine_size(run->engine, &width, &height);
	fprintf(out, "%" PRIu64 " model%s, %u visible, %" PRIu64 " draws; %s%s%s culling, %s replay, %u worker%s\n",
	        o->models, o->models == 1 ? "" : "s", run->report.visible, run->report.render.draws, cull_choices[o->cull],
	        o->cull == STILB_CULL_AUTO ? ": " : "", o->cull == STILB_CULL_AUTO ? cull_choices[run->report.cull] : "",
	        replay_choices[o->replay], workers, workers == 1 ? "" : "s");
	fprintf(out, "%s%s, %ux%u, %u sample%s per pixel\n", stilb_engine_device_name(run->engine),
	        software ? " (software: it draws on the CPU)" : "", width, height, samples, samples == 1 ? "" : "s");
	fprintf(out, "%" PRIu64 " frame%s, the first %" PRIu64 " not counted; milliseconds:\n", run->frames,
	        run->frames == 1 ? "" : "s", warmup);
	fprintf(out, "  %-8s %9s %9s %9s\n", "stage", "median", "p99", "min");
	for (int s = 0; s < STAGE_COUNT; s++)
		if (s != STAGE_GPU || o->device != STILB_RENDER_DEVICE_NULL)
			fprintf(out, "  %-8s %9.3f %9.3f %9.3f\n", stage_names[s], summary[s].median, summary[s].p99,
			        summary[s].min);
	stage bound = demo_bound(summary);
	fprintf(out, "bound by: %s, %.3f ms\n", demo_bound_name(bound), summary[bound].median);
}

/* Writes what was asked for, prints the summary. All is tried, also after a failure. */
static bool demo_finish(demo_run *run)
{
	const demo_options *o = &run->options;
	stage_summary summary[STAGE_COUNT];
	uint64_t warmup;
	double gpu_ms;
	stilb_result waited = stilb_engine_wait(run->engine, &gpu_ms);
	if (waited != STILB_OK) {
		stilb_log("%s", stilb_error_message());
		return false;
	}
	stage_times_last_gpu(&run->times, gpu_ms);
	bool good = stage_times_summarise(&run->times, summary, &warmup);
	if (!good)
		stilb_log("no memory to sort the stage times: they are given as 0");
	stilb_result picture = STILB_OK, trace = STILB_OK, stats = STILB_OK, dump = STILB_OK;
	if (o->screenshot)
		demo_say_result(run, picture = stilb_engine_screenshot(run->engine, o->screenshot), "picture", o->screenshot);
	if (o->trace)
		demo_say_result(run, trace = stilb_engine_trace(run->engine, o->trace, 0), "trace", o->trace);
	if (o->stats)
		demo_say_result(run, stats = demo_write_stats(run, summary), "stats", o->stats);
	if (o->dump)
		demo_say_result(run, dump = stilb_engine_dump(run->engine, o->dump), "dump", o->dump);
	demo_print_summary(run, summary, warmup);
	uint32_t messages = stilb_engine_validation_messages(run->engine);
	if (messages > 0)
		stilb_log("the validation layer had %u message%s", messages, messages == 1 ? "" : "s");
	return good && picture == STILB_OK && trace == STILB_OK && stats == STILB_OK && dump == STILB_OK && messages == 0;
}

static int demo_main(demo_run *run)
{
	if (demo_start(run) != STILB_OK) {
		stilb_log("%s", stilb_error_message());
		return EXIT_FAILED;
	}
	const struct sigaction once = {.sa_handler = demo_on_signal, .sa_flags = SA_RESETHAND}; /* a second one kills */
	sigaction(SIGINT, &once, NULL);
	sigaction(SIGTERM, &once, NULL);
	if (run->window)
		fprintf(demo_words(&run->options),
		        "WASD fly, Q/E down/up, shift fast, right mouse looks, Esc releases the mouse,\n"
		        "P trace, F12 picture, - and + workers; close the window to end\n");
	fflush(stdout);
	if (demo_loop(run) != STILB_OK) {
		stilb_log("%s", stilb_error_message());
		return EXIT_FAILED;
	}
	if (run->frames == 0) {
		stilb_log("no frame was drawn");
		return EXIT_FAILED;
	}
	return demo_finish(run) ? EXIT_DONE : EXIT_FAILED;
}

int demo_command(int argc, char **argv)
{
	demo_run run = {.options = {.models = 10000, .seed = 1, .size = {1280, 720}}};
	run.options.workers = FLAG_WORKERS_AUTO;
	flags_result parsed = demo_parse(&run.options, argc, argv);
	if (parsed == FLAGS_HELP)
		return EXIT_DONE;
	if (parsed == FLAGS_REFUSED || !demo_check(&run.options))
		return EXIT_REFUSED;
	if (run.options.workers == FLAG_WORKERS_AUTO)
		run.options.workers = stilb_engine_default_workers();
	int code = demo_main(&run);
	stilb_engine_destroy(run.engine);
	stage_times_finish(&run.times);
	return code;
}
