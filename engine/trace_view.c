/* Shows the profiler's user interface over a trace file, on a device and in a window opened for it alone. */
#include "trace_view.h"

#include "engine_internal.h"
#include "image/image.h"
#include "profiler/prof_capture.h"

#include <stdlib.h>

#define VIEW_PASS 0u
#define VIEW_WORKER 0u /* there is only the main thread */

enum { VIEW_ZOOM = STILB_INPUT_PANEL_ACTIONS, VIEW_MOVE, VIEW_SELECT, VIEW_FIT, VIEW_KEYS, VIEW_ACTIONS };

struct stilb_engine_trace_view {
	stilb_owner owner; /* the main thread: the one that created it */
	const stilb_prof_snapshot *trace;
	uint32_t first, count; /* the history: trace->frames[first .. first + count - 1] */
	stilb_window *window;  /* NULL: none */
	stilb_render *render;
	engine_surface surface; /* of the window */
	stilb_ui *ui;
	stilb_ui_profiler *profiler;
	stilb_ui_input input;
	stilb_input_table actions;
	engine_keys keys; /* the key card */
	uint64_t last_ns; /* clock at which the last frame began; 0 before the first */
};

/* ---- the source of the profiler's window ------------------------------------------------------------------------- */

/* The source of snapshots for the profiler's window (stilb_ui_profiler_desc.take). Gives the whole trace, whichever
 * frames are asked for: it is in memory already. */
static int view_take(void *user, stilb_prof_snapshot *snapshot, const stilb_prof_window *window)
{
	(void)window;
	const stilb_engine_trace_view *view = user;
	*snapshot = *view->trace;
	snapshot->memory = NULL; /* so that the profiler's window does not free the trace, which is the caller's */
	return 0;
}

static void view_frames(void *user, stilb_prof_frame_stats *stats, double budget_ms)
{
	const stilb_engine_trace_view *view = user;
	STILB_ASSERT(view->first + view->count <= view->trace->frame_count);
	stilb_prof_frame_stats_make(stats, view->trace->frames + view->first, view->count, budget_ms);
}

/* Sets the history to the STILB_PROF_STATS_FRAMES frames around the one to be shown, or to all if there are fewer. */
static void view_choose(stilb_engine_trace_view *view, uint32_t frame)
{
	uint32_t all = view->trace->frame_count, most = STILB_PROF_STATS_FRAMES;
	view->count = all < most ? all : most;
	view->first = frame > most / 2 ? frame - most / 2 : 0;
	if (view->first > all - view->count)
		view->first = all - view->count;
}

/* ---- what keys and mouse do -------------------------------------------------------------------------------------- */

/* What the mouse does is the profiler's window's own doing, which knows what lies under it. */
stilb_input_table stilb_engine_trace_view_table(void)
{
#define VIEW_ROW(row) [VIEW_##row - STILB_INPUT_PANEL_ACTIONS]
	static const stilb_input_action rows[VIEW_ACTIONS - STILB_INPUT_PANEL_ACTIONS] = {
		VIEW_ROW(ZOOM) = {"zoom", STILB_INPUT_MOTION, .mouse = STILB_INPUT_MOUSE_WHEEL,
	                      .help = "zoom in and out at the pointer"},
		VIEW_ROW(MOVE) = {"move", STILB_INPUT_MOTION, .mouse = STILB_INPUT_MOUSE_LEFT,
	                      .help = "move through time and lanes"},
		VIEW_ROW(SELECT) = {"select", STILB_INPUT_MOTION, .mouse = STILB_INPUT_MOUSE_CLICK,
	                        .help = "select a zone, or the frame of a bar"},
		VIEW_ROW(FIT) = {"fit", STILB_INPUT_MOTION, .mouse = STILB_INPUT_MOUSE_DOUBLE,
	                     .help = "fit a zone into the view"},
		VIEW_ROW(KEYS) = {"keys", STILB_INPUT_SWITCH, .keys = {STILB_WINDOW_KEY_H}, .typed = "?", .help = "this list"},
	};
#undef VIEW_ROW
	stilb_input_table table = stilb_input_table_panels();
	stilb_result result = stilb_input_table_add(&table, rows, sizeof rows / sizeof *rows);
	STILB_ASSERT(result == STILB_OK);
	(void)result;
	return table;
}

/* ---- life -------------------------------------------------------------------------------------------------------- */

static stilb_result view_start(stilb_engine_trace_view *view, const stilb_engine_trace_view_desc *desc)
{
	stilb_result result = STILB_OK;
	if (desc->window)
		result = stilb_window_create("Stilb trace", desc->width, desc->height, &view->window);
	if (result != STILB_OK)
		return result;
	stilb_gpu_surface surface = view->window ? engine_surface_of(view->window) : (stilb_gpu_surface){0};
	stilb_render_desc render = {
		.gpu = desc->gpu,
		.surface = view->window ? &surface : NULL,
		.width = desc->width,
		.height = desc->height,
		.samples = 1,
		.context_count = 1,
	};
	result = stilb_render_create(&render, &view->render);
	if (result != STILB_OK)
		return result;
	stilb_ui_desc ui = stilb_ui_desc_default();
	ui.render = view->render;
	ui.aa = desc->aa;
	result = stilb_ui_create(&ui, &view->ui);
	if (result != STILB_OK)
		return result;
	stilb_ui_profiler_desc profiler = {.user = view, .take = view_take, .frames = view_frames, .whole = true};
	result = stilb_ui_profiler_create(&profiler, &view->profiler);
	if (result == STILB_OK)
		stilb_ui_profiler_show(view->profiler, desc->trace->frames[desc->frame].number);
	return result;
}

stilb_result stilb_engine_trace_view_create(const stilb_engine_trace_view_desc *desc, stilb_engine_trace_view **out)
{
	STILB_ASSERT(desc && out);
	STILB_ASSERT(desc->trace);
	*out = NULL;
	if (desc->frame >= desc->trace->frame_count)
		return stilb_fail(STILB_ERROR_ARGUMENT, "the trace has %u frames, no frame %u", desc->trace->frame_count,
		                  desc->frame);
	stilb_engine_trace_view *view = calloc(1, sizeof *view);
	if (!view)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a view of a trace");
	stilb_owner_take(&view->owner);
	view->trace = desc->trace;
	view_choose(view, desc->frame);
	view->actions = stilb_engine_trace_view_table();
	view->keys.list.selected = STILB_UI_NO_ROW;
	stilb_result result = view_start(view, desc);
	if (result == STILB_OK)
		*out = view;
	else
		stilb_engine_trace_view_destroy(view);
	return result;
}

void stilb_engine_trace_view_destroy(stilb_engine_trace_view *view)
{
	if (!view)
		return;
	STILB_ASSERT_OWNER(view->owner);
	stilb_ui_profiler_destroy(view->profiler);
	stilb_ui_destroy(view->ui);
	stilb_render_destroy(view->render);
	stilb_window_destroy(view->window);
	free(view);
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

/* Takes the window's input and follows its size. *drawn is false if the window has no area to draw to. */
static stilb_result view_input(stilb_engine_trace_view *view, bool *close, bool *drawn)
{
	stilb_window_state state;
	*close = false;
	*drawn = true;
	view->input = (stilb_ui_input){0};
	if (!view->window)
		return STILB_OK;
	stilb_window_wait(view->window, 0.1, &state);
	if (state.lost)
		return stilb_fail(STILB_ERROR_WINDOW, "the display has gone");
	uint64_t now = stilb_time_ns();
	*close = state.close;
	*drawn = state.width > 0 && state.height > 0;
	stilb_window_set_capturing(view->window, false); /* there is no camera */
	view->input = engine_ui_input(&state);
	view->keys.open ^= stilb_input_from_window(&view->actions, &state).actions[VIEW_KEYS] > 0;
	view->input.seconds = view->last_ns ? (float)((double)(now - view->last_ns) * 1e-9) : 0.0f;
	view->last_ns = now;
	uint32_t width, height;
	stilb_render_size(view->render, &width, &height);
	if (!*drawn || (state.width == width && state.height == height))
		return STILB_OK;
	return stilb_render_resize(view->render, state.width, state.height);
}

static stilb_result view_draw(stilb_engine_trace_view *view)
{
	stilb_render_pass pass = {.name = "ui", .kind = STILB_RENDER_PASS_2D};
	uint32_t width, height;
	stilb_render_size(view->render, &width, &height);
	view->input.width = (float)width;
	view->input.height = (float)height;
	stilb_ui_begin(view->ui, &view->input);
	stilb_ui_profiler_draw(view->profiler, view->ui);
	if (view->keys.open)
		engine_keys_draw(&view->keys, &view->actions, view->ui);
	stilb_ui_end(view->ui);
	stilb_result result = stilb_render_frame_begin(view->render);
	if (result == STILB_OK)
		result = stilb_ui_record(view->ui, VIEW_PASS, VIEW_WORKER);
	if (result == STILB_OK)
		result = stilb_render_replay(view->render, &pass, 1, NULL, 0, NULL, VIEW_WORKER);
	return result == STILB_OK ? engine_surface_present(&view->surface, view->render, view->window) : result;
}

stilb_result stilb_engine_trace_view_frame(stilb_engine_trace_view *view, bool *close)
{
	STILB_ASSERT_OWNER(view->owner);
	STILB_ASSERT(close);
	bool drawn;
	stilb_result result = view_input(view, close, &drawn);
	if (result == STILB_OK && drawn)
		result = view_draw(view);
	if (result == STILB_OK && engine_surface_is_gone(&view->surface, view->window))
		result = stilb_fail(STILB_ERROR_WINDOW, "the window's surface was lost, and it gives no other");
	return result;
}

stilb_result stilb_engine_trace_view_screenshot(stilb_engine_trace_view *view, const char *path)
{
	STILB_ASSERT_OWNER(view->owner);
	STILB_ASSERT(path);
	stilb_image image = {0};
	stilb_result result = stilb_render_read_image(view->render, &image);
	if (result == STILB_OK)
		result = stilb_image_save(&image, path);
	stilb_image_finish(&image);
	return result;
}
