/*
 * live_options: the flags that `stilb demo` and `stilb view` have in common, read, checked, and turned into the
 * description of an engine.
 *
 *   live_options options = live_options_default();
 *   if (live_options_parse(&options, &help, own, own_count, argc, argv) == FLAGS_OK && live_options_check(&options))
 *       desc = live_options_engine(&options);
 *
 * Threads.  All [main-thread], but for live_message_stream, which is [any-thread].
 */
#ifndef STILB_LIVE_OPTIONS_H
#define STILB_LIVE_OPTIONS_H

#include "engine.h"
#include "game/cli/flags.h"
#include "game/cli/picture_flags.h"
#include "live_keys.h"

#include <stdio.h>

#define LIVE_CAPTURE "stilb-capture.json"

typedef struct live_options {
	picture_flags picture;
	stilb_post_preset *preset;     /* of --preset, or the scene's own; NULL: none */
	uint32_t look_given;           /* which flags were given that a preset says, too */
	char look_exposure[32];        /* what picture.exposure is from there */
	uint32_t brdf;                 /* a SHADE_BRDF_: the command's default, set before parsing */
	uint64_t frames, profile_ring; /* frames: 0 if not given */
	uint64_t pictures; /* > 0: end after so many frames, and save each under --screenshot's name with a number */
	uint32_t workers, size[2];
	uint32_t photo[2]; /* of --screenshot and of pictures of keys, pixels; 0: those of frames */
	uint64_t photo_tile;
	int cull, ui_aa, present; /* values of the engine's enumerations */
	bool watch_shaders, no_watch_shaders, wait_textures;
	bool headless, no_present, overlay, inspector, clips, lights, effects, keys, times, no_profile, invert_y;
	float sensitivity; /* of the right stick */
	float scale;       /* stilb_engine_desc.scale */
	const char *frames_help;
	/* NULL if not given: */
	const char *screenshot, *trace, *stats, *dump, *capture, *spike, *fault, *gamepad, *track, *plan, *draw, *shaders,
		*save_preset;
} live_options;

/* The words that --cull accepts, in the order of stilb_cull_method; NULL-terminated. */
extern const char *const live_cull_choices[];

/* What a command says of itself in --help. */
typedef struct live_help {
	const char *purpose; /* "stilb demo: what it does." */
	const char *frames;  /* help of --frames */
	const live_keys *keys;
} live_help;

/* The options without any flag. */
live_options live_options_default(void);

/* Reads the command's own flags, which come first in --help, and the common ones into *o; prints the help or the error
 * instead, as flags_parse returns. */
flags_result live_options_parse(live_options *o, const live_help *help, const flag *own, size_t own_count, int argc,
                                char **argv);

/* Checks what the table of flags cannot express: flags that contradict each other, and the files. Returns false after
 * one line on stderr. Starts nothing and writes nothing. */
bool live_options_check(const live_options *o);

/* Takes a preset, which is the options' from then on, NULL: none, in place of the one before: what it says counts where
 * no flag was given. */
void live_options_look(live_options *o, stilb_post_preset *preset);

/* Of live_options_check what a preset that was taken since may break. */
bool live_options_check_look(const live_options *o);

/* The look that frames have: the engine's effects, and exposure, tone map and tables as of the options; to be freed.
 * STILB_ERROR_MEMORY, STILB_ERROR_FILE. */
stilb_result live_options_look_of(const live_options *o, const stilb_engine *engine, stilb_post_preset **look);

/* Frees what parsing has opened. */
void live_options_finish(live_options *o);

/* The description of the engine for options that live_options_check accepted. It points to strings of *o. */
stilb_engine_desc live_options_engine(const live_options *o);

/* What --fault asks for. */
typedef struct live_faults {
	stilb_render_faults render;
	uint32_t slow_frame; /* number, from 1, of a frame that is made 100 ms longer; 0: none */
} live_faults;
live_faults live_options_faults(const live_options *o);

/* True if --gamepad replays a recording, which has an end. */
bool live_options_is_replay(const live_options *o);

/* The stream for messages: stderr if an output file is standard output, else stdout. */
FILE *live_message_stream(const live_options *o);

#endif
