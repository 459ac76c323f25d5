/*
 * live_run: the run of a command that draws frames, in a window or headless: the engine, the loop, keys that every such
 * command has, files that are written during the run and at its end. What is drawn is the command's.
 *
 *   live_run run = {.options = &options, .program = &program, .user = &demo};
 *   int code = live_run_main(&run);
 *
 * Threads.  [main-thread]
 */
#ifndef STILB_LIVE_RUN_H
#define STILB_LIVE_RUN_H

#include "game/cli/stage_times.h"
#include "live_draw.h"
#include "live_gamepads.h"
#include "live_options.h"
#include "live_track.h"

typedef struct live_run live_run;

/* What a command adds to a run. user is the run's. */
typedef struct live_program {
	const live_keys *keys; /* rows of the command's own */
	const char *picture;   /* name of pictures that a key saves, unless --screenshot names one */
	/* Frames of a headless run without --frames: on a GPU, and on a device that draws on the CPU. */
	uint64_t frames, software_frames;
	stilb_result (*start)(void *user, live_run *run); /* shows the scene in run->engine */
	stilb_engine_update_fn *update;                   /* as stilb_engine_desc.update */
	/* Acts on the frame before, before each frame, with its report; {0} before the first frame. */
	stilb_result (*act)(void *user, live_run *run, const stilb_engine_report *report);
	/* Before the engine's workers are replaced; NULL: nothing to do. */
	void (*release)(void *user);
	void (*finish)(void *user); /* before the engine is destroyed; NULL: nothing to do */
	void (*title)(void *user, const live_run *run, char title[static 256]); /* of the window, twice a second */
} live_program;

struct live_run {
	const live_options *options;
	const live_program *program;
	void *user;
	stilb_engine_choice *light; /* a choice among kinds of light in the materials' window; NULL: none */
	/* The run's own, for the program to read; all but engine are 0 at first. */
	stilb_engine *engine;
	stilb_input_action rows[STILB_INPUT_ACTIONS_MAX]; /* the program's rows of the engine's table */
	stilb_engine_report report;                       /* of the last frame that was drawn */
	uint64_t frames;                                  /* number of frames drawn */
	bool window;
	stilb_result wrong;  /* set by the program in its update, with the line of stilb_error_message: the run ends */
	bool starting;       /* set by the program: as long as it is true, a failure is one of the start (exit_code_of) */
	bool lost;           /* the window's display has gone */
	uint32_t slow_frame; /* number of a frame that is made 100 ms longer, a fault for tests; 0: none */
	bool shadows_told;   /* how fine shadows are on this kind of device */
	uint64_t titled_ns;  /* time of the title's last change */
	stage_times times;
	live_track track;
	live_gamepads gamepads;
	live_draw draw;              /* what --draw names */
	char *series;                /* --screenshot's name for a series of pictures (live_picture.h); NULL: none yet */
	stilb_result picture_result; /* of the first picture of a series that could not be written */
	/* Both are written on the profiler's capturing thread. The main thread reads them after it has destroyed the
	 * engine, which ends that thread. */
	int capture_error;   /* of the last capture: negative errno, or 0 */
	bool capture_failed; /* true if any capture failed */
	/* What the window is to say of the newest capture; NULL: nothing. Whoever takes it out frees it. */
	_Atomic(char *) told;
};

/* Gives the engine the table of --grade, or else the preset's, and the preset's areas. STILB_ERROR_FILE,
 * STILB_ERROR_MEMORY. */
stilb_result live_run_grade(const live_run *run);

/* Runs until the frames are drawn, the window is closed or a signal comes; writes the outputs; destroys the engine.
 * Returns the exit code. The program frees its scene afterwards. */
int live_run_main(live_run *run);

/* How often one of the keys was pressed that all live commands have. */
uint32_t live_run_asked(const live_run *run, const stilb_engine_report *report, live_key key);

/* A signal has come that ends the run. */
bool live_run_is_stopped(void);

/* Prints "WHAT: PATH" for a file that was written, or the error. */
void live_run_say(const live_run *run, stilb_result result, const char *what, const char *path);

/* Shows a line in the window for some seconds, but not if --screenshot saves the last frame as the window shows it. */
void live_run_tell(live_run *run, const char *text);

/* Prints a line on stderr, and shows it in the window. */
void live_run_warn(live_run *run, const char *text);

/* The frames after which the run ends; 0: it ends with its window, its recording or a signal. */
uint64_t live_run_wanted(const live_run *run);

#endif
