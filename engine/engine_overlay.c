/*
 * The windows over the picture: the profiler, the inspector, the notice of gamepads and toasts. They are created when
 * one of them is opened for the first time, get the mouse and the keys before the camera does, and are drawn as a 2D
 * pass of their own.
 */
#include "engine_internal.h"

#include "profiler/prof.h"

#include <stdlib.h>

#define OVERLAY_HINT_SECONDS 10.0f
#define OVERLAY_BELOW 16.0f /* pixels from the picture's lower edge to the lowest line */

/* The profiler's window is created with it. */
stilb_result engine_overlay_create(stilb_engine *engine)
{
	engine_overlay *overlay = &engine->overlay;
	STILB_ASSERT(!overlay->ui == !overlay->profiler);
	if (overlay->ui)
		return STILB_OK;
	stilb_ui_desc desc = stilb_ui_desc_default();
	desc.render = engine->render;
	desc.aa = engine->desc.ui_aa;
	stilb_result result = stilb_ui_create(&desc, &overlay->ui);
	if (result == STILB_OK)
		result = stilb_ui_profiler_create(&(stilb_ui_profiler_desc){.budget_ms = engine->desc.capture.spike_ms},
		                                  &overlay->profiler);
	if (result != STILB_OK)
		engine_overlay_finish(overlay);
	return result;
}

stilb_result engine_overlay_open(stilb_engine *engine, bool profiler, bool inspector)
{
	stilb_result result = profiler || inspector ? engine_overlay_create(engine) : STILB_OK;
	if (result != STILB_OK)
		return result;
	STILB_ASSERT(engine->overlay.ui || !(profiler || inspector));
	engine->overlay.profiler_open = profiler;
	engine->overlay.inspector_open = inspector;
	return STILB_OK;
}

stilb_result engine_overlay_start(stilb_engine *engine)
{
	const stilb_engine_desc *desc = &engine->desc;
	engine_overlay *overlay = &engine->overlay;
	bool hint = desc->hint && engine->window;
	stilb_result result = engine_overlay_open(engine, desc->overlay, desc->inspector);
	if (result == STILB_OK && (desc->keys || desc->clips || desc->lights || desc->effects || desc->times || hint))
		result = engine_overlay_create(engine);
	if (result != STILB_OK)
		return result;
	overlay->keys.open = desc->keys;
	overlay->keys.list.selected = STILB_UI_NO_ROW;
	overlay->clips.list.selected = STILB_UI_NO_ROW;
	overlay->clips.open = desc->clips;
	overlay->lights.picked = STILB_UI_NO_ROW;
	overlay->lights.open = desc->lights;
	overlay->effects.open = desc->effects;
	overlay->rate.open = desc->times;
	overlay->keys.hint_seconds = hint ? OVERLAY_HINT_SECONDS : 0.0f;
	return STILB_OK;
}

void engine_overlay_finish(engine_overlay *overlay)
{
	stilb_ui_profiler_destroy(overlay->profiler);
	stilb_ui_destroy(overlay->ui);
	*overlay = (engine_overlay){0};
}

stilb_ui_input engine_ui_input(const stilb_window_state *window)
{
	static const uint32_t rows[STILB_UI_KEY_COUNT] = {
		[STILB_UI_KEY_TAB] = STILB_INPUT_PANEL_NEXT,    [STILB_UI_KEY_ENTER] = STILB_INPUT_PANEL_ENTER,
		[STILB_UI_KEY_SPACE] = STILB_INPUT_PANEL_SPACE, [STILB_UI_KEY_ESCAPE] = STILB_INPUT_PANEL_LEAVE,
		[STILB_UI_KEY_LEFT] = STILB_INPUT_PANEL_LEFT,   [STILB_UI_KEY_RIGHT] = STILB_INPUT_PANEL_RIGHT,
		[STILB_UI_KEY_UP] = STILB_INPUT_PANEL_UP,       [STILB_UI_KEY_DOWN] = STILB_INPUT_PANEL_DOWN,
	};
	stilb_input_table panels = stilb_input_table_panels();
	stilb_input_state asked = stilb_input_from_window(&panels, window);
	stilb_ui_input input = {
		.mouse_present = window->pointer,
		.mouse_x = window->pointer_x,
		.mouse_y = window->pointer_y,
		.mouse_down = window->button,
		.mouse_presses = window->clicks,
		.wheel = window->wheel,
		.shift = asked.actions[STILB_INPUT_PANEL_BACK] > 0,
	};
	for (int key = 0; key < STILB_UI_KEY_COUNT; key++)
		input.keys[key] = asked.actions[rows[key]];
	return input;
}

void engine_overlay_input(stilb_engine *engine, const stilb_window_state *window, stilb_input_state *input)
{
	engine_overlay *overlay = &engine->overlay;
	/* The user acted on what the last frame showed, so the focus of that frame decides who gets the keys. */
	engine->report.ui_keys = engine_overlay_is_open(overlay) && stilb_ui_wants_keys(overlay->ui);
	engine->report.ui_mouse = engine_overlay_is_open(overlay) && stilb_ui_wants_mouse(overlay->ui);
	if (engine->report.ui_keys)
		*input = stilb_input_without_keys(&engine->actions, *input);
	if (engine->report.ui_mouse)
		*input = stilb_input_without_pointer(*input);
	overlay->input = engine_ui_input(window);
	overlay->input.seconds = engine->step;
}

void engine_overlay_act(stilb_engine *engine, const stilb_input_state *input)
{
	engine_overlay *overlay = &engine->overlay;
	bool profiler = input->actions[STILB_ENGINE_PROFILER] > 0, inspector = input->actions[STILB_ENGINE_MATERIALS] > 0;
	overlay->toasts.hidden = input->actions[STILB_ENGINE_PICTURE] > 0;
	if ((profiler || inspector) && engine_overlay_open(engine, overlay->profiler_open != profiler,
	                                                   overlay->inspector_open != inspector) != STILB_OK)
		stilb_log("%s", stilb_error_message()); /* only logged: frames go on without that window */
	bool keys = input->actions[STILB_ENGINE_KEYS] > 0, times = input->actions[STILB_ENGINE_TIMES] > 0;
	if ((keys || times) && engine_overlay_create(engine) != STILB_OK) {
		stilb_log("%s", stilb_error_message());
	} else {
		overlay->keys.open ^= keys;
		overlay->rate.open ^= times;
	}
	bool clips = input->actions[STILB_ENGINE_CLIPS] > 0, lights = input->actions[STILB_ENGINE_LIGHTS] > 0;
	bool effects = input->actions[STILB_ENGINE_EFFECTS] > 0;
	if ((clips || lights || effects) && engine_overlay_create(engine) != STILB_OK) {
		stilb_log("%s", stilb_error_message());
	} else {
		overlay->clips.open ^= clips;
		overlay->lights.open ^= lights;
		overlay->effects.open ^= effects;
	}
	if (overlay->profiler_open && input->actions[STILB_ENGINE_FREEZE] > 0)
		stilb_ui_profiler_freeze(overlay->profiler, !stilb_ui_profiler_frozen(overlay->profiler));
	else if (input->actions[STILB_ENGINE_FREEZE] > 0)
		engine_playing_pause(engine);
	int steps = input->actions[STILB_ENGINE_STEP] - input->actions[STILB_ENGINE_STEP_BACK];
	stilb_engine_step(engine, (double)steps * ENGINE_STEP);
	engine->value.open ^= input->actions[STILB_ENGINE_VALUE] > 0;
	overlay->value_open =
		engine->value.known && engine_value_wanted(engine) && engine_overlay_create(engine) == STILB_OK;
	bool counts = engine->desc.show == STILB_RENDER_SHOW_LIGHTS || engine->desc.show == STILB_RENDER_SHOW_ERROR;
	overlay->counts_open =
		counts && engine->scene && engine->image[0] == '\0' && engine_overlay_create(engine) == STILB_OK;
	if (engine->window)
		stilb_window_set_capturing(engine->window,
		                           !engine_overlay_is_open(overlay) || !stilb_ui_wants_mouse(overlay->ui));
}

void engine_overlay_deny(stilb_engine *engine, uint32_t pad, const stilb_input_pad_info *info)
{
	char rule[512];
	stilb_log("%s: %s may not be opened: no permission; as root put this line into", info->path,
	          info->name[0] ? info->name : "a gamepad");
	stilb_log("  " ENGINE_NOTICE_FILE ", run 'udevadm control --reload', and plug it in again:");
	stilb_log("  %s", stilb_input_udev_rule(info, rule, sizeof rule));
	if (engine_overlay_create(engine) == STILB_OK)
		engine_notice_add(&engine->overlay.notice, pad, info);
	else
		stilb_log("%s", stilb_error_message());
}

void engine_overlay_tell(stilb_engine *engine, const char *text)
{
	if (engine_overlay_create(engine) == STILB_OK)
		engine_toasts_add(&engine->overlay.toasts, text);
	else
		stilb_log("%s: %s", text, stilb_error_message());
}

void stilb_engine_tell(stilb_engine *engine, const char *text)
{
	STILB_ASSERT_OWNER(engine->owner);
	STILB_ASSERT(text);
	if (engine->window || engine->input.is_given)
		engine_overlay_tell(engine, text);
}

/* Builds it from back to front. */
static void engine_overlay_build(stilb_engine *engine)
{
	PROFILE("ui build");
	engine_overlay *overlay = &engine->overlay;
	bool covered = overlay->profiler_open || overlay->inspector_open || overlay->clips.open || overlay->lights.open ||
	               overlay->effects.open || overlay->keys.open;
	float below = OVERLAY_BELOW;
	stilb_ui_rect caption = {0};
	stilb_ui_begin(overlay->ui, &overlay->input);
	if (overlay->divider_open && !overlay->toasts.hidden)
		engine_picture_divider(engine, overlay->ui);
	if (overlay->caption_open && !overlay->toasts.hidden)
		caption = engine_picture_caption(engine, overlay->ui);
	stilb_ui_rect places[] = {overlay->inspector_open ? overlay->inspector.place : (stilb_ui_rect){0},
	                          overlay->keys.open ? overlay->keys.place : (stilb_ui_rect){0},
	                          overlay->clips.open ? overlay->clips.place : (stilb_ui_rect){0},
	                          overlay->lights.open ? overlay->lights.place : (stilb_ui_rect){0},
	                          overlay->effects.open ? overlay->effects.place : (stilb_ui_rect){0}};
	if (overlay->rate.open && !overlay->toasts.hidden && !overlay->profiler_open) /* which has them, too */
		engine_rate_draw(&overlay->rate, overlay->ui, caption, places, sizeof places / sizeof *places);
	if (overlay->value_open && !overlay->toasts.hidden)
		engine_value_draw(engine, overlay->ui);
	if (overlay->counts_open && !overlay->toasts.hidden)
		engine_counts_draw(engine, overlay->ui);
	if (overlay->keys.hint_seconds > 0.0f && !overlay->toasts.hidden)
		below += engine_keys_hint(&overlay->keys, &engine->actions, overlay->ui, below, covered);
	if (overlay->profiler_open)
		stilb_ui_profiler_draw(overlay->profiler, overlay->ui);
	if (overlay->inspector_open)
		engine_inspector_draw(&overlay->inspector, overlay->ui, &engine->shading, engine->desc.choice,
		                      &overlay->inspector_open);
	if (overlay->clips.open)
		engine_clips_draw(engine, overlay->ui);
	if (overlay->lights.open)
		engine_lights_draw(engine, overlay->ui);
	if (overlay->effects.open)
		engine_effects_draw(&overlay->effects, overlay->ui, &engine->desc.post);
	if (overlay->keys.open)
		engine_keys_draw(&overlay->keys, &engine->actions, overlay->ui);
	if (overlay->notice.pad_count > 0)
		engine_notice_draw(&overlay->notice, overlay->ui);
	if (overlay->shader_error && !overlay->toasts.hidden && !engine_watch_draw(overlay->shader_error, overlay->ui)) {
		free(overlay->shader_error);
		overlay->shader_error = NULL;
	}
	if (!overlay->toasts.hidden)
		engine_toasts_draw(&overlay->toasts, overlay->ui, below);
	stilb_ui_end(overlay->ui);
}

stilb_result engine_overlay_record(stilb_engine *engine, uint32_t pass, uint32_t worker)
{
	engine_overlay *overlay = &engine->overlay;
	STILB_ASSERT(engine_overlay_is_open(overlay));
	uint32_t width, height;
	stilb_render_size(engine->render, &width, &height);
	overlay->input.width = (float)width;
	overlay->input.height = (float)height;
	engine_overlay_build(engine);
	PROFILE("ui record");
	return stilb_ui_record(overlay->ui, pass, worker);
}
