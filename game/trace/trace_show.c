/* stilb trace show: the profiler's timeline of a trace file, in a window or as a picture. */
#include "game/cli/flags.h"
#include "game/live/live_keys.h"
#include "trace.h"

#include "base/base_file.h"
#include "image/image.h"
#include "trace_view.h"

#include <stdio.h>

typedef struct show_options {
	const char *frame, *screenshot, *gpu;
	uint32_t size[2];
	int aa;
} show_options;

static const char *const aa_choices[] = {"feather", "article", "off", NULL}; /* in the order of stilb_ui_aa */

static flags_result show_parse(show_options *o, int argc, char **argv)
{
	const flag flags[] = {
		{"--frame", FLAG_TEXT, &o->frame, "N|slowest", "the frame to show first (slowest)", 0, 0, NULL},
		{"--screenshot", FLAG_TEXT, &o->screenshot, "FILE", "save it as .png, .exr or .hdr instead of opening a window",
	     0, 0, NULL},
		{"--size", FLAG_SIZE, o->size, "WxH", "picture size, 1x1..16384x16384 (1280x720)", 1, 16384, NULL},
		{"--ui-aa", FLAG_CHOICE, &o->aa, "feather|article|off", "edges: soft; soft outside only; hard (feather)", 0, 0,
	     aa_choices},
		{"--gpu", FLAG_TEXT, &o->gpu, "N|NAME", "number of a GPU or part of its name, see 'stilb info'", 0, 0, NULL},
	};
	size_t count = sizeof flags / sizeof *flags;
	flags_result result = flags_parse(flags, count, argc, argv);
	if (result == FLAGS_HELP) {
		printf("stilb trace show FILE [FLAGS]: shows what each thread did in a frame, and what it waited for. FILE is "
		       "what\n"
		       "'stilb demo --trace' wrote, or Chrome trace JSON of another program that marks frames as it does;\n"
		       "- is standard input.\n\n");
		flags_print(flags, count);
		printf("\nIn the window:\n");
		stilb_input_table table = stilb_engine_trace_view_table();
		live_keys_print_table(&table);
	}
	return result;
}

static int show_fail(void)
{
	stilb_log("%s", stilb_error_message());
	return EXIT_FAILED;
}

/* Draws two frames: the layout of the second follows from the text that the first one measured. */
static stilb_result show_picture(stilb_engine_trace_view *view, const char *path)
{
	bool close;
	stilb_result result = stilb_engine_trace_view_frame(view, &close);
	if (result == STILB_OK)
		result = stilb_engine_trace_view_frame(view, &close);
	return result == STILB_OK ? stilb_engine_trace_view_screenshot(view, path) : result;
}

static stilb_result show_window(stilb_engine_trace_view *view)
{
	stilb_result result = STILB_OK;
	for (bool close = false; result == STILB_OK && !close;)
		result = stilb_engine_trace_view_frame(view, &close);
	return result;
}

static int show_run(const show_options *o, const stilb_prof_snapshot *trace, uint32_t frame)
{
	stilb_engine_trace_view_desc desc = {
		.trace = trace,
		.frame = frame,
		.width = o->size[0],
		.height = o->size[1],
		.window = !o->screenshot,
		.aa = (stilb_ui_aa)o->aa,
		.gpu = o->gpu,
	};
	stilb_engine_trace_view *view;
	stilb_result result = stilb_engine_trace_view_create(&desc, &view);
	if (result == STILB_ERROR_WINDOW) {
		stilb_log("%s; give --screenshot FILE, which needs no window", stilb_error_message());
		return EXIT_REFUSED;
	}
	if (result != STILB_OK) {
		stilb_log("%s", stilb_error_message());
		return exit_code_of(result);
	}
	result = o->screenshot ? show_picture(view, o->screenshot) : show_window(view);
	stilb_engine_trace_view_destroy(view);
	if (result != STILB_OK)
		return show_fail();
	if (o->screenshot)
		fprintf(stilb_file_is_stdout(o->screenshot) ? stderr : stdout, "picture: %s\n", o->screenshot);
	return EXIT_DONE;
}

int trace_show_command(int argc, char **argv)
{
	show_options options = {.frame = "slowest", .size = {1280, 720}};
	trace_files files = trace_take_files(1, &argc, &argv);
	flags_result parsed = show_parse(&options, argc, argv);
	if (parsed == FLAGS_HELP)
		return EXIT_DONE;
	if (parsed == FLAGS_REFUSED || !trace_check("show", &files, options.screenshot))
		return EXIT_REFUSED;
	if (options.screenshot && stilb_image_path_check(options.screenshot) != STILB_OK) {
		stilb_log("%s", stilb_error_message());
		return EXIT_REFUSED;
	}
	uint32_t frame;
	stilb_prof_snapshot trace = {0};
	int code = EXIT_REFUSED;
	if (trace_load(files.path[0], &trace) && trace_choose_frame(&trace, files.path[0], options.frame, &frame))
		code = show_run(&options, &trace, frame);
	stilb_prof_snapshot_finish(&trace);
	return code;
}
