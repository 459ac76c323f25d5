/* The whole engine, seen by engine*.c and frame.c alone. */
#ifndef STILB_ENGINE_INTERNAL_H
#define STILB_ENGINE_INTERNAL_H

#include "engine.h"
#include "input/device/input_pads.h"
#include "input/input_recording.h"
#include "input/input_window.h"
#include "jobs/job.h"
#include "ui/ui.h"
#include "ui/ui_profiler.h"
#include "window/window.h"

#define ENGINE_MAX_VIEWS 4u

/* The window in which formulas are chosen; {0} at first. */
typedef struct engine_inspector {
	stilb_ui_rect place; /* empty: not yet drawn */
	bool beside;         /* the sliders stand beside the lists */
	stilb_ui_list_state lists[5];
} engine_inspector;

/* Which gamepads may not be opened, and what to do about it: a small panel, for a while. {0}: none. */
#define ENGINE_NOTICE_PADS 3u
#define ENGINE_NOTICE_FILE "/etc/udev/rules.d/70-stilb-pads.rules"
typedef struct engine_notice {
	struct {
		uint32_t pad; /* its number */
		char who[256], rule[512];
	} pads[ENGINE_NOTICE_PADS];
	uint32_t pad_count;
	float seconds; /* left */
} engine_notice;

/* What stands over the picture; {0} before any of it is opened for the first time. */
typedef struct engine_overlay {
	stilb_ui *ui;
	stilb_ui_profiler *profiler;
	engine_inspector inspector;
	engine_notice notice;
	stilb_ui_input input; /* of this frame; nobody touches anything when headless */
	bool profiler_open, inspector_open;
} engine_overlay;

/* Who flies the camera; {0}: nobody, as in a headless run without gamepads. */
typedef struct engine_input {
	stilb_input_control *control;
	stilb_input_pads *pads;           /* NULL: none are read here */
	stilb_input_recording *recording; /* NULL: none is replayed */
	stilb_input_window window;
	stilb_input_pose pose; /* what the scene's camera was told last, and for when */
	int64_t time_us;
	bool focused;      /* the window has the keyboard */
	bool pad_captures; /* a pad asked for the last frame's capture, if one was asked for */
	bool replayed;     /* the recording is over */
	int64_t start_us;  /* of a replay in a window; 0: not yet */
	int64_t newest_us; /* the last report's time; 0: none came since the frame before */
	uint64_t reports, corrupt;
} engine_input;

struct stilb_engine {
	stilb_engine_desc desc;
	stilb_job_pool *pool;
	stilb_scene *scene;
	stilb_cull *cull;
	stilb_window *window; /* NULL when headless */
	stilb_render *render;
	engine_input input;

	/* What is drawn, as data: frame.c runs cull once per view, and record and replay once per pass. */
	stilb_render_view views[ENGINE_MAX_VIEWS];
	stilb_cull_visible visible[ENGINE_MAX_VIEWS]; /* what each sees this frame */
	uint32_t view_count;
	stilb_render_pass passes[STILB_RENDER_MAX_PASSES];
	uint32_t pass_count;
	uint32_t frame_passes; /* this frame's: the overlay's comes after those of the table */
	engine_overlay overlay;
	stilb_render_shading shading; /* of the next frame */

	uint64_t frame;   /* frames done */
	uint64_t last_ns; /* when the frame before began; 0 before the first */
	double seconds;   /* the scene's time */
	float step;       /* of this frame, seconds */
	stilb_engine_report report;
};

/* engine_profile.c */

/* Before there are workers: the calling thread is "main" from now on, and captures begin. */
stilb_result engine_profile_start(const stilb_engine_desc *desc);

/* Writes what has been asked for; then, without workers, all is forgotten. Both also without a start. */
void engine_profile_stop_capture(void);
void engine_profile_stop(void);

/* engine_overlay.c */

/* Which of its windows are open. STILB_ERROR_MEMORY, STILB_ERROR_DEVICE: they cannot be made, and all stays as it
 * was. */
stilb_result engine_overlay_open(stilb_engine *engine, bool profiler, bool inspector);
static inline bool engine_overlay_is_open(const engine_overlay *overlay)
{
	return overlay->profiler_open || overlay->inspector_open || overlay->notice.pad_count > 0;
}
void engine_overlay_finish(engine_overlay *overlay);

/* What the window says goes to the overlay first; *input keeps what the overlay leaves. */
void engine_overlay_input(stilb_engine *engine, const stilb_window_state *window, stilb_input_state *input);

/* A gamepad may not be opened: says so, on the screen too. */
void engine_overlay_deny(stilb_engine *engine, uint32_t pad, const stilb_input_pad_info *info);

/* Opens, closes and freezes as keys and gamepads want it; says whether the mouse is the overlay's. */
void engine_overlay_act(stilb_engine *engine, const stilb_input_state *input);

/* What the user did, for the user interface; all but the picture's size and the time. */
stilb_ui_input engine_ui_input(const stilb_window_state *window);

/* Builds the overlay, which is open, and records it as `pass`, of kind 2D. */
stilb_result engine_overlay_record(stilb_engine *engine, uint32_t pass, uint32_t worker);

/* engine_input.c */

/* STILB_ERROR_MEMORY, STILB_ERROR_FILE, STILB_ERROR_DEVICE, STILB_ERROR_THREAD. */
stilb_result engine_input_start(stilb_engine *engine);
void engine_input_finish(engine_input *input);

/* Keys and gamepads together: *state is what the window said, and becomes what all of them want; the scene's camera is
 * moved. Returns the camera's time, microseconds. Never waits. */
int64_t engine_input_frame(stilb_engine *engine, stilb_input_state *state);

/* The frame's draws are with the device: how old its newest report is by now, milliseconds; 0: it had none. */
double engine_input_latency(const stilb_engine *engine);

/* A capture will be written. */
void engine_input_captured(stilb_engine *engine);

/* engine_notice.c */

void engine_notice_add(engine_notice *notice, uint32_t pad, const stilb_input_pad_info *info);
void engine_notice_remove(engine_notice *notice, uint32_t pad);

/* Between stilb_ui_begin and stilb_ui_end; its time goes on. */
void engine_notice_draw(engine_notice *notice, stilb_ui *ui);

/* engine_inspector.c */

/* Between stilb_ui_begin and stilb_ui_end. *shading and *open become what the user wants. */
void engine_inspector_draw(engine_inspector *inspector, stilb_ui *ui, stilb_render_shading *shading, bool *open);

#endif
