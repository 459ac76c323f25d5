/* The profiler's window: takes snapshots, has the data about the frame that is shown computed, and draws the parts. */
#include "ui/ui_profiler_internal.h"

#include "profiler/prof.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PROFILER_WIDTH 480.0f /* pixels: a smaller picture gets one line of text instead of the window */
#define PROFILER_HEIGHT 270.0f
#define PROFILER_SEED 8227u /* of the hash of names that picks colours: chosen so that the engine's stages differ */

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
	STILB_ASSERT(out);
	STILB_ASSERT((!desc || !desc->take == !desc->frames) && "take and frames come together");
	stilb_ui_profiler *profiler = calloc(1, sizeof *profiler);
	*out = profiler;
	if (!profiler)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the profiler's window");
	stilb_owner_take(&profiler->owner);
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
	STILB_ASSERT_OWNER(profiler->owner);
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

/* Colours of zones of work, 0xRRGGBB: easy to tell from each other, from the colours with a meaning of their own
 * (UI_PROFILER_BAD and so on) and from the dark background; dark text is readable on all of them. */
static const uint32_t PROFILER_PALETTE[] = {0x74a9f7, 0x7fd39b, 0xc99cf0, 0x62d0d6, 0xa9c765, 0xd9a0d8, 0x8f9ff5,
                                            0xc9c07a, 0x57b8a3, 0xb8b4e8, 0x9cc3d9, 0x8cc08c, 0xc4a98f, 0xa58be0};

/* The colour of zones of that name. It depends on the name alone, so that a zone has the same colour in every run and
 * pictures can be compared. */
static uint32_t profiler_color(const char *name)
{
	uint64_t hash = stilb_hash_fnv1a64(STILB_FNV1A64_START ^ PROFILER_SEED, name, strlen(name));
	return PROFILER_PALETTE[(hash >> 32) % (sizeof PROFILER_PALETTE / sizeof *PROFILER_PALETTE)];
}

/* The same name may be recorded by several sites: if one of them gives a colour, all of them are drawn in it. */
static uint32_t profiler_given_color(const stilb_prof_snapshot *snapshot, const char *name)
{
	for (uint32_t i = 0; i < snapshot->label_count; i++)
		if (snapshot->labels[i].color && strcmp(snapshot->labels[i].name, name) == 0)
			return snapshot->labels[i].color;
	return profiler_color(name);
}

/* Fills colors->rgb for all labels of the snapshot. False: no memory. */
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

/* Takes the frame times recorded since the last draw; in mode LATEST, also the newest frames themselves. */
static void profiler_follow(stilb_ui_profiler *profiler)
{
	uint64_t before = profiler->history.last;
	stilb_prof_window two = {.last_frames = 2};
	profiler->desc.frames(profiler->desc.user, &profiler->history, profiler->desc.budget_ms);
	if (profiler->freeze_on_spike && profiler->history.spike && profiler->history.last != before)
		stilb_ui_profiler_show(profiler, profiler->history.last);
	if (profiler->mode == UI_PROFILER_LATEST)
		profiler->out_of_memory = profiler->desc.take(profiler->desc.user, &profiler->live, &two) != 0;
}

/* The number of the frame to show. */
static uint64_t profiler_choose(const stilb_ui_profiler *profiler)
{
	STILB_ASSERT(profiler->history.count > 0 && "there is a frame to choose");
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

/* Fills profiler->held with the frame of that number unless it is held already. A frame younger than UI_PROFILER_LATE
 * frames is taken again on every draw, because the GPU's zones of it arrive late. Once they have arrived, a frozen
 * history is taken as a whole, so that the user can step through it while the rings (the threads' memory of recorded
 * events) are overwritten. False: `held` did not change. */
static bool profiler_hold(stilb_ui_profiler *profiler, uint64_t number)
{
	const stilb_prof_frame_stats *history = &profiler->history;
	stilb_prof_window window = {.first_frame = number > 0 ? number - 1 : 0, .frame_count = 3};
	if (profiler->frozen && profiler->settle > 0)
		profiler->settle--;
	bool in_history = number >= ui_profiler_frame_number(history, 0);
	bool all = profiler->frozen && profiler->settle == 0 && in_history, other = profiler->held_number != number;
	bool young = profiler->taken_at < number + UI_PROFILER_LATE && profiler->taken_at != history->last;
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

/* Removes the zones in which a thread had nothing to do: the longest of all, they would fill the top of the table. The
 * lanes still show them. */
static void profiler_leave_out_idle(stilb_ui_profiler *profiler)
{
	stilb_prof_stats *stats = &profiler->stats;
	uint32_t count = 0;
	for (uint32_t i = 0; i < stats->row_count; i++)
		if (profiler->data.kinds[stats->rows[i].label] != UI_PROFILER_IDLE)
			stats->rows[count++] = stats->rows[i];
	stats->row_count = count;
}

/* Computes everything that is said and drawn about the snapshot's frame of that number. False: the snapshot does not
 * hold it, or there is no memory (profiler->out_of_memory). */
static bool profiler_look(stilb_ui_profiler *profiler, const stilb_prof_snapshot *snapshot, uint64_t number)
{
	uint32_t frame = ui_profiler_frame_find(snapshot, number);
	if (frame == STILB_PROF_NONE)
		return false;
	/* The table sums the zones within the frame's time, as the lanes show it; GPU zones in it are of earlier frames. */
	stilb_prof_stats_range range = {.begin_ns = snapshot->frames[frame].begin_ns,
	                                .end_ns = snapshot->frames[frame].end_ns};
	bool other = !profiler->snapshot || profiler->number != number;
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

/* Decides which frame is shown and brings its snapshot up to date; profiler->snapshot is NULL if none can be shown. */
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
	uint64_t number = profiler_choose(profiler);
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

/* For pictures too small for the window: one line at the bottom, about the longest wait. */
static void profiler_draw_small(const stilb_ui_profiler *profiler, stilb_ui *ui)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	const stilb_ui_input *input = stilb_ui_input_get(ui);
	stilb_ui_rect line = {0.0f, input->height - style->row_height, input->width, input->height};
	stilb_ui_draw_rect(stilb_ui_list(ui), line, style->panel);
	stilb_ui_rect words = {style->margin, line.y0, line.x1 - style->margin, line.y1};
	stilb_ui_label(ui, words, STILB_UI_ALIGN_LEFT,
	               profiler->snapshot ? profiler->data.report.wait_text : "Too small for the profiler.");
}

void stilb_ui_profiler_draw(stilb_ui_profiler *profiler, stilb_ui *ui)
{
	STILB_ASSERT_OWNER(profiler->owner);
	PROFILE("profiler window");
	profiler_update(profiler);
	if (stilb_ui_input_get(ui)->width < PROFILER_WIDTH || stilb_ui_input_get(ui)->height < PROFILER_HEIGHT) {
		profiler_draw_small(profiler, ui);
		return;
	}
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	const stilb_ui_input *input = stilb_ui_input_get(ui);
	float edge = style->gap, margin = style->margin;
	float top = ui_profiler_top_height(profiler, ui), legend = ui_profiler_legend_height(ui);
	float height = top + legend + ui_profiler_timeline_height(profiler, ui) + 2.0f * margin + 2.0f * style->gap;
	if (profiler->desc.whole || height > input->height - 2.0f * edge)
		height = input->height - 2.0f * edge;
	stilb_ui_rect panel = {edge, floorf(input->height - edge - height), input->width - edge, input->height - edge};
	stilb_ui_draw_list *list = stilb_ui_list(ui);

	stilb_ui_id_push(ui, "profiler");
	stilb_ui_area(ui, "panel", panel, STILB_UI_TAKES_WHEEL); /* takes the mouse from areas behind the window */
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
