/* The profiler's window: which frame it shows, and where its snapshots come from. */
#include "ui/ui_profiler_internal.h"

#include "profiler/prof.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PROFILER_WIDTH 480.0f /* pixels: less is too small for more than a line */
#define PROFILER_HEIGHT 270.0f
#define PROFILER_SEED 8227u /* of colours, see profiler_color */
#define PROFILER_LATE 4u    /* frames after which the GPU's zones of a frame have come for certain */

static int profiler_take(void *user, stilb_prof_snapshot *snapshot, const stilb_prof_window *window)
{
	(void)user;
	return stilb_prof_snapshot_take(snapshot, window);
}

static void profiler_frames(void *user, stilb_prof_frame_stats *stats, double budget_ms)
{
	(void)user;
	stilb_prof_frame_stats_take(stats, budget_ms);
}

stilb_result stilb_ui_profiler_create(const stilb_ui_profiler_desc *desc, stilb_ui_profiler **out)
{
	stilb_ui_profiler *profiler = calloc(1, sizeof *profiler);
	*out = profiler;
	if (!profiler)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the profiler's window");
	if (desc)
		profiler->desc = *desc;
	if (!profiler->desc.take)
		profiler->desc.take = profiler_take;
	if (!profiler->desc.frames)
		profiler->desc.frames = profiler_frames;
	profiler->sort = (stilb_ui_sort){.column = UI_PROFILER_INCLUSIVE, .descending = true};
	profiler->table.selected = STILB_UI_NO_ROW;
	profiler->hot_label = STILB_PROF_NONE;
	profiler->held_number = UINT64_MAX;
	return STILB_OK;
}

void stilb_ui_profiler_destroy(stilb_ui_profiler *profiler)
{
	if (!profiler)
		return;
	stilb_prof_snapshot_finish(&profiler->live);
	stilb_prof_snapshot_finish(&profiler->held);
	stilb_prof_stats_finish(&profiler->stats);
	ui_profiler_data_finish(&profiler->data);
	ui_profiler_spans_finish(&profiler->spans);
	free(profiler->colors.rgb);
	free(profiler->rows);
	free(profiler);
}

/* ---- colours ----------------------------------------------------------------------------------------------------- */

/* Told apart from each other, from the colours that mean something here, and from the dark ground; dark text is read on
 * all of them. */
static const uint32_t PROFILER_PALETTE[] = {0x74a9f7, 0x7fd39b, 0xc99cf0, 0x62d0d6, 0xa9c765, 0xd9a0d8, 0x8f9ff5,
                                            0xc9c07a, 0x57b8a3, 0xb8b4e8, 0x9cc3d9, 0x8cc08c, 0xc4a98f, 0xa58be0};

/* By the name alone, so that pictures can be compared; the seed is one that tells the engine's own stages apart. */
static uint32_t profiler_color(const char *name)
{
	const uint64_t hash = stilb_hash_fnv1a64(STILB_FNV1A64_START ^ PROFILER_SEED, name, strlen(name));
	return PROFILER_PALETTE[(hash >> 32) % (sizeof PROFILER_PALETTE / sizeof *PROFILER_PALETTE)];
}

/* A name that was given a colour in one place has it everywhere. */
static uint32_t profiler_given_color(const stilb_prof_snapshot *snapshot, const char *name)
{
	for (uint32_t i = 0; i < snapshot->label_count; i++)
		if (snapshot->labels[i].color && strcmp(snapshot->labels[i].name, name) == 0)
			return snapshot->labels[i].color;
	return profiler_color(name);
}

static bool profiler_color_labels(ui_profiler_colors *colors, const stilb_prof_snapshot *snapshot)
{
	if (colors->capacity < snapshot->label_count) {
		free(colors->rgb);
		colors->capacity = snapshot->label_count + 32;
		colors->rgb = malloc(colors->capacity * sizeof *colors->rgb);
		if (!colors->rgb) {
			colors->capacity = 0;
			return false;
		}
	}
	for (uint32_t i = 0; i < snapshot->label_count; i++) {
		const stilb_prof_label *label = &snapshot->labels[i];
		switch (ui_profiler_kind_of(label->name)) {
		case UI_PROFILER_WAIT:
			colors->rgb[i] = UI_PROFILER_WAITING;
			break;
		case UI_PROFILER_IDLE:
			colors->rgb[i] = UI_PROFILER_PARKED;
			break;
		case UI_PROFILER_WORK:
			colors->rgb[i] = label->color ? label->color : profiler_given_color(snapshot, label->name);
			break;
		}
	}
	return true;
}

/* ---- which frame ------------------------------------------------------------------------------------------------- */

void ui_profiler_fit(stilb_ui_profiler *profiler, uint64_t begin_ns, uint64_t end_ns)
{
	const double begin = (double)begin_ns - (double)ui_profiler_frame(profiler)->begin_ns;
	const double length = end_ns > begin_ns ? (double)(end_ns - begin_ns) : 1.0;
	profiler->view_begin_ns = begin - 0.02 * length;
	profiler->view_ns = 1.04 * length;
}

void ui_profiler_fit_frame(stilb_ui_profiler *profiler)
{
	const stilb_prof_frame *frame = ui_profiler_frame(profiler);
	ui_profiler_fit(profiler, frame->begin_ns, frame->end_ns);
}

bool stilb_ui_profiler_frozen(const stilb_ui_profiler *profiler)
{
	return profiler->frozen;
}

void stilb_ui_profiler_freeze(stilb_ui_profiler *profiler, bool frozen)
{
	if (profiler->frozen == frozen)
		return;
	profiler->frozen = frozen;
	profiler->settle = PROFILER_LATE;
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

/* What has happened since the last draw. */
static void profiler_follow(stilb_ui_profiler *profiler)
{
	const uint64_t before = profiler->history.last;
	const stilb_prof_window two = {.last_frames = 2};
	profiler->desc.frames(profiler->desc.user, &profiler->history, profiler->desc.budget_ms);
	if (profiler->freeze_on_spike && profiler->history.spike && profiler->history.last != before)
		stilb_ui_profiler_show(profiler, profiler->history.last);
	if (profiler->mode == UI_PROFILER_LATEST)
		profiler->out_of_memory = profiler->desc.take(profiler->desc.user, &profiler->live, &two) != 0;
}

static uint64_t profiler_choose(const stilb_ui_profiler *profiler)
{
	switch (profiler->mode) {
	case UI_PROFILER_SLOWEST:
		return ui_profiler_frame_number(&profiler->history, ui_profiler_slowest(&profiler->history));
	case UI_PROFILER_PICKED:
		return profiler->picked;
	case UI_PROFILER_LATEST:
		break;
	}
	return profiler->history.last;
}

/* Fills `held` for that frame unless it is there already. While the frame is young it is taken again, since what comes
 * late belongs to it as well; once all is there, a frozen history is taken as a whole, so that it can be gone through
 * at leisure while the rings go on. False: nothing changed. */
static bool profiler_hold(stilb_ui_profiler *profiler, uint64_t number)
{
	const stilb_prof_frame_stats *history = &profiler->history;
	stilb_prof_window window = {.first_frame = number > 0 ? number - 1 : 0, .frame_count = 3};
	if (profiler->frozen && profiler->settle > 0)
		profiler->settle--;
	const bool in_history = number >= ui_profiler_frame_number(history, 0);
	const bool all = profiler->frozen && profiler->settle == 0 && in_history, other = profiler->held_number != number;
	const bool young = profiler->taken_at < number + PROFILER_LATE && profiler->taken_at != history->last;
	profiler->held_number = number;
	if (all ? profiler->held_all : !other && !young && !profiler->held_all)
		return other;
	if (all) {
		window.first_frame = ui_profiler_frame_number(history, 0);
		window.frame_count = history->count;
	}
	profiler->out_of_memory = profiler->desc.take(profiler->desc.user, &profiler->held, &window) != 0;
	if (profiler->out_of_memory)
		profiler->held_number = UINT64_MAX;
	profiler->held_all = all && !profiler->out_of_memory;
	profiler->taken_at = history->last;
	return true;
}

/* Threads without work are seen in the lanes; in the table they would stand above what matters. */
static void profiler_leave_out_idle(stilb_ui_profiler *profiler)
{
	stilb_prof_stats *stats = &profiler->stats;
	uint32_t count = 0;
	for (uint32_t i = 0; i < stats->row_count; i++)
		if (profiler->data.kinds[stats->rows[i].label] != UI_PROFILER_IDLE)
			stats->rows[count++] = stats->rows[i];
	stats->row_count = count;
}

/* Works out all that is said and drawn about the snapshot's frame of that number. False: it is not there. */
static bool profiler_look(stilb_ui_profiler *profiler, const stilb_prof_snapshot *snapshot, uint64_t number)
{
	const uint32_t frame = ui_profiler_frame_find(snapshot, number);
	if (frame == STILB_PROF_NONE)
		return false;
	/* The time of the frame, as in the picture: the GPU's zones belong to frames before. */
	const stilb_prof_stats_range range = {.begin_ns = snapshot->frames[frame].begin_ns,
	                                      .end_ns = snapshot->frames[frame].end_ns};
	const bool other = !profiler->snapshot || profiler->number != number;
	profiler->snapshot = snapshot;
	profiler->number = number;
	profiler->out_of_memory = !ui_profiler_data_build(&profiler->data, snapshot, frame) ||
	                          !profiler_color_labels(&profiler->colors, snapshot) ||
	                          stilb_prof_stats_take(&profiler->stats, snapshot, &range) != 0 ||
	                          !ui_profiler_layout_lanes(profiler);
	if (profiler->out_of_memory)
		return false;
	profiler_leave_out_idle(profiler);
	ui_profiler_sort_table(profiler);
	if (other)
		ui_profiler_fit_frame(profiler);
	return true;
}

static void profiler_update(stilb_ui_profiler *profiler)
{
	PROFILE("profiler snapshot");
	profiler->out_of_memory = false;
	if (!profiler->frozen || profiler->history.count == 0)
		profiler_follow(profiler);
	if (profiler->history.count == 0 || profiler->out_of_memory) {
		profiler->snapshot = NULL;
		return;
	}
	const uint64_t number = profiler_choose(profiler);
	const stilb_prof_snapshot *snapshot = &profiler->held;
	if (profiler->mode == UI_PROFILER_LATEST) {
		snapshot = &profiler->live;
		profiler->held_number = UINT64_MAX;
	} else if (!profiler_hold(profiler, number) && profiler->snapshot == snapshot) {
		return;
	}
	if (profiler->out_of_memory || !profiler_look(profiler, snapshot, number))
		profiler->snapshot = NULL;
}

/* ---- drawing ----------------------------------------------------------------------------------------------------- */

static void profiler_draw_empty(stilb_ui_profiler *profiler, stilb_ui *ui, stilb_ui_rect area)
{
	const char *text = "Waiting for the first whole frame.";
	if (profiler->out_of_memory)
		text = "There is no memory for a copy of what was recorded.";
	else if (profiler->history.count > 0)
		text = "That frame has been overwritten meanwhile. A larger ring keeps frames longer.";
	stilb_ui_label(ui, area, STILB_UI_ALIGN_LEFT, text);
}

/* Of all that it says the one line that matters most. */
static void profiler_draw_small(const stilb_ui_profiler *profiler, stilb_ui *ui)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	const stilb_ui_input *input = stilb_ui_input_get(ui);
	const stilb_ui_rect line = {0.0f, input->height - style->row_height, input->width, input->height};
	stilb_ui_draw_rect(stilb_ui_list(ui), line, style->panel);
	const stilb_ui_rect words = {style->margin, line.y0, line.x1 - style->margin, line.y1};
	stilb_ui_label(ui, words, STILB_UI_ALIGN_LEFT,
	               profiler->snapshot ? profiler->data.report.wait_text : "Too small for the profiler.");
}

void stilb_ui_profiler_draw(stilb_ui_profiler *profiler, stilb_ui *ui)
{
	PROFILE("profiler window");
	profiler_update(profiler);
	if (stilb_ui_input_get(ui)->width < PROFILER_WIDTH || stilb_ui_input_get(ui)->height < PROFILER_HEIGHT) {
		profiler_draw_small(profiler, ui);
		return;
	}
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	const stilb_ui_input *input = stilb_ui_input_get(ui);
	const float edge = style->gap, margin = style->margin;
	const float top = ui_profiler_top_height(profiler, ui), legend = ui_profiler_legend_height(ui);
	float height = top + legend + ui_profiler_timeline_height(profiler, ui) + 2.0f * margin + 2.0f * style->gap;
	if (profiler->desc.whole || height > input->height - 2.0f * edge)
		height = input->height - 2.0f * edge;
	stilb_ui_rect panel = {edge, floorf(input->height - edge - height), input->width - edge, input->height - edge};
	stilb_ui_draw_list *list = stilb_ui_list(ui);

	stilb_ui_id_push(ui, "profiler");
	stilb_ui_area(ui, "panel", panel, STILB_UI_TAKES_WHEEL); /* nothing behind it is reached */
	stilb_ui_draw_shadow(list, panel, style->radius, 12.0f, style->shadow);
	stilb_ui_draw_rounded(list, panel, style->radius, style->panel);
	stilb_ui_draw_rounded_outline(list, panel, style->radius, 1.0f, style->panel_border);
	stilb_ui_rect area = stilb_ui_inset(panel, margin);
	stilb_ui_rect head = stilb_ui_cut_top(&area, top);
	ui_profiler_draw_top(profiler, ui, head);
	if (profiler->snapshot) {
		stilb_ui_rect foot = stilb_ui_cut_bottom(&area, legend);
		stilb_ui_cut_top(&area, style->gap);
		stilb_ui_cut_bottom(&area, style->gap);
		ui_profiler_draw_timeline(profiler, ui, area);
		ui_profiler_draw_legend(profiler, ui, foot);
	} else {
		profiler_draw_empty(profiler, ui, area);
	}
	stilb_ui_id_pop(ui);
}
