/*
 * engine: owns every module and runs frames. What a program sees of Stilb.
 *
 * Life cycle.  stilb_engine_create -> stilb_engine_frame until done -> stilb_engine_destroy.
 * Threads.     All [main-thread]; the workers are the engine's own.
 * One at a time: engines share the process's profiler and window library, and destroy shuts both down.
 * The story of a frame is frame.c.
 */
#ifndef STILB_ENGINE_H
#define STILB_ENGINE_H

#include "base/base.h"
#include "culling/cull.h"
#include "input/input.h"
#include "input/input_control.h"
#include "profiler/prof_capture.h"
#include "render/render.h"
#include "scene/scene.h"
#include "ui/ui_draw.h"

typedef struct stilb_engine stilb_engine;

/* Where gamepads come from. */
typedef enum stilb_engine_gamepad {
	STILB_ENGINE_GAMEPAD_AUTO, /* in a window as HIDRAW, and OFF without one; trouble is said and does not end it */
	STILB_ENGINE_GAMEPAD_OFF,
	STILB_ENGINE_GAMEPAD_HIDRAW, /* from the kernel directly, and in a window from its library what is not read so */
	STILB_ENGINE_GAMEPAD_HIDAPI, /* the same through hidapi */
	STILB_ENGINE_GAMEPAD_REPLAY  /* from a recording: the same camera in every run */
} stilb_engine_gamepad;

typedef struct stilb_engine_desc {
	uint32_t models; /* 1..STILB_SCENE_MAX_MODELS */
	uint64_t seed;
	uint32_t workers; /* threads beside the main thread, 0..STILB_JOB_MAX_WORKERS */
	stilb_cull_method cull;
	stilb_scene_stress_view view;
	stilb_render_device_kind device;
	stilb_render_replay_mode replay;
	stilb_render_materials materials;
	stilb_render_output output;
	stilb_render_shading shading;
	const char *gpu;        /* NULL: the best */
	uint32_t width, height; /* 1..16384 */
	uint32_t samples;       /* 1, 4, or 0 for the device's own choice */
	bool window;            /* else headless: frames step by 1/60 s, and the picture goes to memory */
	bool present;           /* else no frame is shown */
	bool animate;           /* a tenth of the models moves */
	bool validate;
	stilb_render_faults faults; /* what is to go wrong, for tests */
	uint64_t slow_frame;        /* counted from 1, takes 100 ms longer, for tests; 0: none */
	bool overlay;               /* the profiler's window is open from the start */
	bool inspector;             /* the materials' window is */
	stilb_ui_aa ui_aa;          /* their edges */
	bool profile;               /* record what every thread does, for the overlay and for files */
	uint32_t profile_ring_mib; /* what each thread keeps of it, a power of two, 1..STILB_ENGINE_PROFILE_RING_MAX; memory
	                               is taken as it is used */
	stilb_prof_capture_desc capture; /* files of the frames around a moment; without a path there are none */
	stilb_engine_gamepad gamepad;
	const char *gamepad_recording;         /* of REPLAY, see input_recording.h */
	const char *gamepad_sys, *gamepad_dev; /* NULL: /sys and /dev; others for tests */
	stilb_input_control_settings control;  /* how pads and keys fly */
} stilb_engine_desc;

#define STILB_ENGINE_PROFILE_RING_MAX 1024u

/* 10,000 models, seed 1, CPUs - 1 workers (at least 1), auto culling, all visible, Vulkan, indirect, 1280x720,
 * headless; profiled with rings of 64 MiB, no captures; gamepads AUTO. */
stilb_engine_desc stilb_engine_desc_default(void);

/* The default number of workers. [any-thread] */
uint32_t stilb_engine_default_workers(void);

/* STILB_ERROR_WINDOW: no window can be opened here, headless would do. */
stilb_result stilb_engine_create(const stilb_engine_desc *desc, stilb_engine **engine);
void stilb_engine_destroy(stilb_engine *engine);

/* What a frame cost, milliseconds of the main thread's time; the stages of frame.c. gpu is the device's own measure of
 * a frame some two frames back, 0 when there is none. pad is how old the newest gamepad report was when its draws were
 * handed to the device; 0 when none came since the frame before, or in replays. */
typedef struct stilb_engine_times {
	double frame, update, cull, record, ui, replay, present, gpu, pad;
} stilb_engine_times;

/* What came of the last frame. */
typedef struct stilb_engine_report {
	uint64_t frame; /* frames so far */
	stilb_engine_times times;
	uint32_t visible;       /* models */
	stilb_cull_method cull; /* what found them; never AUTO */
	stilb_render_stats render;
	stilb_input_state input; /* {0} without a window and gamepads */
	int64_t time_us; /* of the camera: of the run headless, of the recording in a replay, else CLOCK_MONOTONIC */
	bool replayed;   /* the recording is over */
	bool close;      /* the user wants out */
	bool lost;       /* the window's display has gone: frames are drawn on, to memory, and nobody can close them */
	bool drawn;      /* false: the window is minimised, nothing was done */
} stilb_engine_report;

/* Runs one frame. Waits a moment instead while the window is minimised. */
stilb_result stilb_engine_frame(stilb_engine *engine, stilb_engine_report *report);

/* Waits until the device has drawn every frame, and gives the last one's time on it, milliseconds (0: unknown). */
stilb_result stilb_engine_wait(stilb_engine *engine, double *gpu_ms);

/* Another number of workers from the next frame on, 0..STILB_JOB_MAX_WORKERS. After an error only destroy may
 * follow. */
stilb_result stilb_engine_set_workers(stilb_engine *engine, uint32_t workers);
uint32_t stilb_engine_workers(const stilb_engine *engine);

/* Of the last frame; see render.h. */
uint64_t stilb_engine_stream_hash(const stilb_engine *engine);

/* The last frame's picture as .png, .exr or .hdr (image.h). With output LINEAR it is the radiance itself. */
stilb_result stilb_engine_screenshot(stilb_engine *engine, const char *path);

/* The last frame's command stream, for `stilb replay`; see render_dump.h. */
stilb_result stilb_engine_dump(stilb_engine *engine, const char *path);

/* The last frames that are still held, at most last_frames (0: all), as a file: prof_trace.h. */
stilb_result stilb_engine_trace(stilb_engine *engine, const char *path, uint32_t last_frames);

/* Asks for a file of the frames around this moment, which desc.capture describes; a gamepad that asked for it in the
 * last frame shakes. STILB_ERROR_ARGUMENT: nothing is captured. */
stilb_result stilb_engine_capture(stilb_engine *engine);

const char *stilb_engine_device_name(const stilb_engine *engine);
bool stilb_engine_device_is_software(const stilb_engine *engine);
uint32_t stilb_engine_samples(const stilb_engine *engine);
uint32_t stilb_engine_validation_messages(const stilb_engine *engine);

/* The picture's size, pixels: follows the window. */
void stilb_engine_size(const stilb_engine *engine, uint32_t *width, uint32_t *height);

/* Another picture size from the next frame on; for programs without a window. 1..16384. */
stilb_result stilb_engine_resize(stilb_engine *engine, uint32_t width, uint32_t height);

void stilb_engine_set_title(stilb_engine *engine, const char *title);

/* One of the libraries that are loaded, and its version. */
typedef struct stilb_engine_library {
	const char *name, *version;
} stilb_engine_library;

/* Fills libraries, returns how many: at most STILB_ENGINE_LIBRARIES. */
#define STILB_ENGINE_LIBRARIES 2
uint32_t stilb_engine_libraries(stilb_engine_library libraries[STILB_ENGINE_LIBRARIES]);

/* How the next frame is shaded; the user may have chosen in the inspector. */
stilb_render_shading stilb_engine_shading(const stilb_engine *engine);
void stilb_engine_set_shading(stilb_engine *engine, const stilb_render_shading *shading);

/* After a choice of another model or D than before. Wrapped light and anisotropic GGX need materials with such numbers
 * in order to be seen: where nothing is added yet, choosing them adds wrap 0.5 or anisotropy 0.6, and choosing another
 * takes just that away again. [any-thread] */
void stilb_engine_shading_chosen(const stilb_render_shading *before, stilb_render_shading *shading);

/* The words for what can be chosen, in the order of the numbers in stilb_render_shading; NULL-terminated.
 * [any-thread] */
extern const char *const stilb_engine_brdf_names[];
extern const char *const stilb_engine_ndf_names[];
extern const char *const stilb_engine_g_names[];
extern const char *const stilb_engine_f_names[];
extern const char *const stilb_engine_light_names[];

/* The gamepads there are, at most STILB_INPUT_PADS_MAX, also those that may not be opened. Texts are valid until the
 * next frame. */
uint32_t stilb_engine_gamepads(const stilb_engine *engine, stilb_input_control_pad pads[STILB_INPUT_PADS_MAX]);

/* What came from them in all. */
typedef struct stilb_engine_gamepad_counts {
	uint64_t reports; /* that frames took */
	uint64_t corrupt; /* of those: refused */
	uint64_t lost;    /* between two frames: more than the buffer holds */
} stilb_engine_gamepad_counts;
stilb_engine_gamepad_counts stilb_engine_gamepad_counts_get(const stilb_engine *engine);

/* Where the scene's camera is. */
stilb_input_pose stilb_engine_pose(const stilb_engine *engine);

/* Puts the camera where desc.view = view would have it. */
void stilb_engine_set_view(stilb_engine *engine, stilb_scene_stress_view view);

/* The scene and its camera: change them between frames only. */
stilb_scene *stilb_engine_scene(stilb_engine *engine);

#endif
