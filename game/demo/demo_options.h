/* What `stilb demo` was asked for: its command line, read and checked. */
#ifndef STILB_DEMO_OPTIONS_H
#define STILB_DEMO_OPTIONS_H

#include "engine.h"
#include "game/cli/flags.h"

#include <stdio.h>

#define DEMO_PICTURE "stilb-demo.png"
#define DEMO_CAPTURE "stilb-capture.json"
#define DEMO_KEYS                                                                                                      \
	"WASD fly, Q/E down/up, shift fast, right mouse looks, Esc releases the mouse,\n"                                  \
	"F1 profiler, space freezes it, F2 materials, V next view, P captures a trace,\n"                                  \
	"F12 picture, - and + workers\n"                                                                                   \
	"gamepad: left stick flies, right stick looks, triggers slower and faster, shoulders down and up;\n"               \
	"buttons go by place: A/cross freezes the profiler, B/circle next view, X/square captures a trace,\n"              \
	"Y/triangle profiler, menu/options materials, view/share picture;\n"                                               \
	"d-pad right next view, up and down workers"

#define DEMO_NOT_GIVEN (-1)

typedef struct demo_options {
	uint64_t models, frames, seed, samples, profile_ring;
	uint32_t workers, size[2];
	int view, cull, replay, materials, device, ui_aa;
	int brdf, ndf, g, f; /* DEMO_NOT_GIVEN, or the number of the word */
	int light;
	float roughness, anisotropy, wrap, specular; /* added; NAN: what the choice adds by itself */
	bool headless, no_present, animate, validate, overlay, inspector, no_profile, invert_y;
	float sensitivity; /* of looking with a stick */
	const char *gpu, *screenshot, *trace, *stats, *dump, *capture, *spike, *fault, *gamepad, *track;
} demo_options;

/* The words of the choices, in the order of the engine's enumerations; NULL-terminated. */
extern const char *const demo_cull_choices[];
extern const char *const demo_replay_choices[];
extern const char *const demo_materials_choices[];
extern const char *const demo_device_choices[];

/* What it does without any flag. */
demo_options demo_options_default(void);

/* Reads the flags, or prints the help. */
flags_result demo_options_parse(demo_options *o, int argc, char **argv);

/* What the flags alone cannot say: false after a line that tells what is wrong. Nothing is started or written. */
bool demo_options_check(const demo_options *o);

/* The engine for these options, which are right. */
stilb_engine_desc demo_options_engine(const demo_options *o);

/* A recording is flown, which ends. */
bool demo_options_is_replay(const demo_options *o);

/* Where the words go: not among the bytes of a file that is written to stdout. */
FILE *demo_options_words(const demo_options *o);

#endif
