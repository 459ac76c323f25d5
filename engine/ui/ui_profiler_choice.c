/* The user's choices: which frame is shown, if the history is frozen, and which stretch of time the timeline's lanes
 * show. Nothing is drawn or computed here; the panel, the timeline and the window itself call these. */
#include "ui/ui_profiler_internal.h"

#define FIT_MARGIN 0.02 /* at each end, as a share of the time that is fitted */

void ui_profiler_fit(stilb_ui_profiler *profiler, uint64_t begin_ns, uint64_t end_ns)
{
	const stilb_prof_frame *frame = ui_profiler_frame(profiler);
	double begin = (double)begin_ns - (double)frame->begin_ns;
	double length = end_ns > begin_ns ? (double)(end_ns - begin_ns) : 1.0;
	profiler->view_begin_ns = begin - FIT_MARGIN * length;
	profiler->view_ns = (1.0 + 2.0 * FIT_MARGIN) * length;
}

void ui_profiler_fit_frame(stilb_ui_profiler *profiler)
{
	const stilb_prof_frame *frame = ui_profiler_frame(profiler);
	ui_profiler_fit(profiler, frame->begin_ns, frame->end_ns);
}

bool stilb_ui_profiler_frozen(const stilb_ui_profiler *profiler)
{
	STILB_ASSERT_OWNER(profiler->owner);
	return profiler->frozen;
}

void stilb_ui_profiler_freeze(stilb_ui_profiler *profiler, bool frozen)
{
	STILB_ASSERT_OWNER(profiler->owner);
	if (profiler->frozen == frozen)
		return;
	profiler->frozen = frozen;
	profiler->settle = UI_PROFILER_LATE;
	if (frozen && profiler->mode == UI_PROFILER_LATEST) {
		profiler->mode = UI_PROFILER_PICKED;
		profiler->picked = profiler->number;
	} else if (!frozen && profiler->mode == UI_PROFILER_PICKED) {
		profiler->mode = UI_PROFILER_SLOWEST;
	}
}

void stilb_ui_profiler_show(stilb_ui_profiler *profiler, uint64_t frame_number)
{
	stilb_ui_profiler_freeze(profiler, true);
	profiler->mode = UI_PROFILER_PICKED;
	profiler->picked = frame_number;
}

void ui_profiler_freeze_key(stilb_ui_profiler *profiler, const stilb_ui *ui, const stilb_ui_action *action)
{
	if (action->focused && stilb_ui_input_get(ui)->keys[STILB_UI_KEY_SPACE] % 2 == 1)
		stilb_ui_profiler_freeze(profiler, !profiler->frozen);
}
