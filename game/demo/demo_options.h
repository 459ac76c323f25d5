/*
 * demo_options: the command line of `stilb demo`, read, checked, and turned into the description of an engine.
 *
 *   demo_options options = demo_options_default();
 *   if (demo_options_parse(&options, argc, argv) == FLAGS_OK && demo_options_check(&options))
 *       desc = demo_options_engine(&options);
 *
 * Threads.  All [main-thread], but for demo_message_stream, which is [any-thread].
 */
#ifndef STILB_DEMO_OPTIONS_H
#define STILB_DEMO_OPTIONS_H

#include "engine.h"
#include "game/cli/flags.h"

#include <stdio.h>

#define DEMO_PICTURE "stilb-demo.png"
#define DEMO_CAPTURE "stilb-capture.json"

/* The help for keys and gamepads. */
#define DEMO_KEYS                                                                                                      \
	"WASD fly, Q/E down/up, Shift faster, right mouse button looks, Esc releases the mouse,\n"                         \
	"F1 profiler, Space freezes it, F2 materials, V next view, P captures a trace,\n"                                  \
	"F12 saves a picture, - and + change the number of workers\n"                                                      \
	"gamepad: left stick flies, right stick looks, triggers slower and faster, shoulders down and up;\n"               \
	"buttons go by place: A/cross freezes the profiler, B/circle next view, X/square captures a trace,\n"              \
	"Y/triangle profiler, menu/options materials, view/share picture;\n"                                               \
	"d-pad right next view, up and down workers"

#define DEMO_NOT_GIVEN (-1)

typedef struct demo_options {
	uint64_t models, frames, seed, samples, profile_ring; /* frames, samples: 0 if not given */
	uint32_t workers, size[2];
	int view, cull, replay, materials, device, ui_aa; /* values of the engine's enumerations */
	int brdf, ndf, g, f;                              /* a SHADE_BRDF_, _NDF_, _G_ and _F_, or DEMO_NOT_GIVEN */
	int light;
	float roughness, anisotropy, wrap, specular; /* added to each material's value; NaN: the chosen BRDF's default */
	bool headless, no_present, animate, validate, overlay, inspector, no_profile, invert_y;
	float sensitivity; /* of the right stick */
	/* NULL if not given: */
	const char *gpu, *screenshot, *trace, *stats, *dump, *capture, *spike, *fault, *gamepad, *track;
} demo_options;

/* The words that --cull, --replay, --materials and --device accept, in the order of the engine's enumerations;
 * NULL-terminated. */
extern const char *const demo_cull_choices[];
extern const char *const demo_replay_choices[];
extern const char *const demo_materials_choices[];
extern const char *const demo_device_choices[];

/* The options without any flag. */
demo_options demo_options_default(void);

/* Reads the flags into *o; prints the help or the error instead, as flags_parse returns. */
flags_result demo_options_parse(demo_options *o, int argc, char **argv);

/* Checks what the table of flags cannot express: flags that contradict each other, and the files. Returns false after
 * one line on stderr. Starts nothing and writes nothing. */
bool demo_options_check(const demo_options *o);

/* The description of the engine for options that demo_options_check accepted. It points to strings of *o. */
stilb_engine_desc demo_options_engine(const demo_options *o);

/* What --fault asks for. */
typedef struct demo_faults {
	stilb_render_faults render;
	uint32_t slow_frame; /* number, from 1, of a frame that is made 100 ms longer; 0: none */
} demo_faults;
demo_faults demo_options_faults(const demo_options *o);

/* True if --gamepad replays a recording, which has an end. */
bool demo_options_is_replay(const demo_options *o);

/* The stream for messages: stderr if an output file is standard output, else stdout. */
FILE *demo_message_stream(const demo_options *o);

#endif
