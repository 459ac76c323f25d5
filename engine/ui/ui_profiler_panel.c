/* The upper part of the profiler's window: the frame in words, the history and the table; and the legend at the
 * bottom. */
#include "ui/ui_internal.h"
#include "ui/ui_profiler_internal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define PANEL_ROWS 7         /* visible rows of the table */
#define PANEL_ROWS_WHOLE 11  /* visible rows if the window fills the picture */
#define PANEL_TABLE 0.40f    /* the table's share of the width */
#define PANEL_SCALE_MAX 4.0f /* the bars' scale ends at most at this many medians: one slow frame must not flatten it */
#define PANEL_HEADROOM 1.15f /* the end of the bars' scale, as a multiple of the highest bar */
#define PANEL_LEVELS 92.0f   /* pixels at the right of the history for "p50 12.34" and "p99 12.34" */

static float panel_line(const stilb_ui *ui)
{
	return stilb_ui_font_line(stilb_ui_font_get(ui, STILB_UI_TEXT_NORMAL)) + 3.0f;
}

float ui_profiler_top_height(const stilb_ui_profiler *profiler, stilb_ui *ui)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	return style->control_height + style->gap +
	       style->row_height * (float)(1 + (profiler->desc.whole ? PANEL_ROWS_WHOLE : PANEL_ROWS));
}

/* ---- headline ---------------------------------------------------------------------------------------------------- */

/* A toggle cut off the right end of area. True if the user pressed it; the caller keeps the state. */
static bool panel_toggle(stilb_ui *ui, stilb_ui_rect *area, const char *label, bool on)
{
	stilb_ui_rect place = stilb_ui_cut_right(area, stilb_ui_button_width(ui, label));
	stilb_ui_cut_right(area, stilb_ui_style_get(ui)->gap * 0.5f);
	return stilb_ui_toggle(ui, place, label, &on);
}

static void panel_draw_controls(stilb_ui_profiler *profiler, stilb_ui *ui, stilb_ui_rect *area)
{
	const char *spike = "freeze on spikes";
	if (profiler->desc.whole) { /* no new frames come, so there is nothing to freeze */
		if (panel_toggle(ui, area, "Slowest", profiler->mode == UI_PROFILER_SLOWEST))
			profiler->mode = UI_PROFILER_SLOWEST;
		return;
	}
	if (panel_toggle(ui, area, "Freeze (space)", profiler->frozen))
		stilb_ui_profiler_freeze(profiler, !profiler->frozen);
	stilb_ui_checkbox(ui, stilb_ui_cut_right(area, stilb_ui_checkbox_width(ui, spike)), spike,
	                  &profiler->freeze_on_spike);
	stilb_ui_cut_right(area, stilb_ui_style_get(ui)->gap * 2.0f);
	if (panel_toggle(ui, area, "Latest", profiler->mode == UI_PROFILER_LATEST)) {
		stilb_ui_profiler_freeze(profiler, false);
		profiler->mode = UI_PROFILER_LATEST;
	}
	if (panel_toggle(ui, area, "Slowest", profiler->mode == UI_PROFILER_SLOWEST))
		profiler->mode = UI_PROFILER_SLOWEST;
}

/* Words for the place of the shown frame among those of the history, like "the slowest of the last". */
static const char *panel_which(const stilb_ui_profiler *profiler)
{
	const stilb_prof_frame_stats *history = &profiler->history;
	if (profiler->number == ui_profiler_frame_number(history, ui_profiler_slowest(history)))
		return profiler->desc.whole ? "the slowest of these" : "the slowest of the last";
	if (profiler->desc.whole)
		return "one of these";
	return profiler->number == history->last ? "the latest of" : "one of the last";
}

static void panel_draw_title(const stilb_ui_profiler *profiler, stilb_ui *ui, stilb_ui_rect area)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	const stilb_prof_frame_stats *history = &profiler->history;
	char name[64], time[32], text[160];
	if (!profiler->snapshot)
		return;
	const stilb_prof_frame *frame = ui_profiler_frame(profiler);
	double ms = (double)(frame->end_ns - frame->begin_ns) * 1e-6;
	snprintf(name, sizeof name, "Frame %llu: %s", (unsigned long long)frame->number,
	         ui_profiler_time_text(time, sizeof time, frame->end_ns - frame->begin_ns));
	const stilb_ui_font *strong = stilb_ui_font_get(ui, STILB_UI_TEXT_STRONG);
	float width = stilb_ui_text_width(strong, name);
	stilb_ui_draw_text(stilb_ui_list(ui), strong, stilb_ui_cut_left(&area, width + 2.0f), STILB_UI_ALIGN_LEFT,
	                   ms > history->limit_ms ? stilb_ui_rgb(UI_PROFILER_BAD) : style->text_strong, name);
	int length = snprintf(text, sizeof text, "  %s %u", panel_which(profiler), history->count);
	if (history->p50_ms > 0.0)
		snprintf(text + length, sizeof text - (size_t)length, ", %.*f × the median",
		         ms > 100.0 * history->p50_ms ? 0 : 1, ms / history->p50_ms);
	stilb_ui_label(ui, area, STILB_UI_ALIGN_LEFT, text);
}

/* Draws the text in the area's topmost line if it fits there, else broken at a blank into two lines; cuts the lines
 * off the area. */
static void panel_draw_lines(stilb_ui *ui, stilb_ui_rect *area, stilb_ui_color color, const char *text)
{
	const stilb_ui_font *font = stilb_ui_font_get(ui, STILB_UI_TEXT_NORMAL);
	char first[512];
	snprintf(first, sizeof first, "%s", text);
	char *cut = first + strlen(first);
	while (cut > first && stilb_ui_text_width(font, first) > area->x1 - area->x0) {
		while (cut > first && *--cut != ' ')
			;
		*cut = 0;
	}
	if (cut == first) /* even the first word is too wide: draw it cut short */
		cut += snprintf(first, sizeof first, "%s", text);
	stilb_ui_draw_text(stilb_ui_list(ui), font, stilb_ui_cut_top(area, panel_line(ui)), STILB_UI_ALIGN_LEFT, color,
	                   first);
	const char *rest = text + (cut - first);
	if (*rest == ' ')
		stilb_ui_draw_text(stilb_ui_list(ui), font, stilb_ui_cut_top(area, panel_line(ui)), STILB_UI_ALIGN_LEFT, color,
		                   rest + 1);
}

/* The report's two sentences; the second has the colour in which the lanes mark the longest wait. */
static void panel_draw_words(const stilb_ui_profiler *profiler, stilb_ui *ui, stilb_ui_rect *area)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	const ui_profiler_report *report = &profiler->data.report;
	bool waited = report->wait.lane != STILB_PROF_NONE;
	panel_draw_lines(ui, area, report->limit == UI_PROFILER_LIMIT_UNKNOWN ? style->text_muted : style->text_strong,
	                 report->verdict);
	panel_draw_lines(ui, area, waited ? stilb_ui_rgb(UI_PROFILER_ATTENTION) : style->text_muted, report->wait_text);
}

/* ---- history ----------------------------------------------------------------------------------------------------- */

typedef struct panel_history {
	stilb_ui_rect area; /* where the bars are, one for each frame */
	float step;         /* from one bar to the next, pixels */
	float top_ms;       /* frame time at the area's top, > 0 */
} panel_history;

/* The y of a frame time; times above the scale's end are at the top. */
static float panel_y(const panel_history *h, float ms)
{
	STILB_ASSERT(h->top_ms > 0.0f);
	float share = ms / h->top_ms;
	return h->area.y1 - (h->area.y1 - h->area.y0) * (share < 1.0f ? share : 1.0f);
}

/* The left edge of bar number 0..history->count; the newest bar stands at the right end even if the history is short.
 */
static float panel_x(const panel_history *h, const stilb_prof_frame_stats *history, uint32_t bar)
{
	STILB_ASSERT(bar <= history->count);
	return h->area.x1 - (float)(history->count - bar) * h->step;
}

static void panel_draw_bar(const stilb_ui_profiler *profiler, stilb_ui *ui, const panel_history *h, uint32_t bar,
                           bool hot)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	const stilb_prof_frame_stats *history = &profiler->history;
	float x = roundf(panel_x(h, history, bar)), next = roundf(panel_x(h, history, bar + 1));
	bool shown = profiler->snapshot && ui_profiler_frame_number(history, bar) == profiler->number;
	stilb_ui_color color = stilb_ui_rgb(history->ms[bar] > history->limit_ms ? UI_PROFILER_BAD : 0x5b7fb5);
	stilb_ui_rect rect = {x, floorf(panel_y(h, (float)history->ms[bar])), next - 1.0f, h->area.y1};
	if (shown || hot) {
		stilb_ui_rect column = {x - 1.0f, h->area.y0, next, h->area.y1};
		stilb_ui_draw_rect(stilb_ui_list(ui), column, stilb_ui_fade(style->text_strong, shown ? 0.28f : 0.12f));
	}
	stilb_ui_draw_rect(stilb_ui_list(ui), rect, color);
}

/* A horizontal line across the bars, with its name and value at the right. */
static void panel_draw_level(stilb_ui *ui, const panel_history *h, float ms, const char *name, stilb_ui_color color)
{
	const stilb_ui_font *font = stilb_ui_font_get(ui, STILB_UI_TEXT_SMALL);
	float y = floorf(panel_y(h, ms)) + 0.5f, line = stilb_ui_font_line(font);
	char text[48];
	if (ms > h->top_ms)
		return;
	snprintf(text, sizeof text, "%s %.2f", name, (double)ms);
	stilb_ui_rect place = {h->area.x1 + 6.0f, y - line * 0.5f, h->area.x1 + PANEL_LEVELS - 2.0f, y + line * 0.5f};
	stilb_ui_draw_line(stilb_ui_list(ui), (stilb_ui_point){h->area.x0, y}, (stilb_ui_point){h->area.x1 + 4.0f, y}, 1.0f,
	                   stilb_ui_fade(color, 0.7f));
	stilb_ui_draw_text(stilb_ui_list(ui), font, place, STILB_UI_ALIGN_LEFT, color, text);
}

/* The line of the moving average over the bars. */
static void panel_draw_average(const stilb_ui_profiler *profiler, stilb_ui *ui, const panel_history *h)
{
	const stilb_prof_frame_stats *history = &profiler->history;
	stilb_ui_point points[STILB_PROF_STATS_FRAMES];
	float average[STILB_PROF_STATS_FRAMES];
	ui_profiler_average(history, average);
	for (uint32_t i = 0; i < history->count; i++)
		points[i] = (stilb_ui_point){panel_x(h, history, i) + 0.5f * h->step, panel_y(h, average[i])};
	if (history->count > 1)
		stilb_ui_draw_polyline(stilb_ui_list(ui), points, history->count, false, 1.5f,
		                       stilb_ui_rgb(UI_PROFILER_AVERAGE_LINE));
}

static void panel_history_tip(const stilb_ui_profiler *profiler, stilb_ui *ui, uint32_t bar)
{
	const stilb_prof_frame_stats *history = &profiler->history;
	char text[160];
	snprintf(text, sizeof text, "frame %llu\t%.2f ms\n%s", (unsigned long long)ui_profiler_frame_number(history, bar),
	         history->ms[bar],
	         history->ms[bar] > history->limit_ms ? "a spike: over twice the median" : "click to look at it");
	stilb_ui_tooltip(ui, text);
}

/* The arrow keys go from frame to frame. */
static void panel_step(stilb_ui_profiler *profiler, const stilb_ui *ui, const stilb_ui_action *action)
{
	const stilb_prof_frame_stats *history = &profiler->history;
	const stilb_ui_input *input = stilb_ui_input_get(ui);
	int64_t step = (int64_t)input->keys[STILB_UI_KEY_RIGHT] - (int64_t)input->keys[STILB_UI_KEY_LEFT];
	ui_profiler_freeze_key(profiler, ui, action);
	if (!action->focused || step == 0 || !profiler->snapshot)
		return;
	int64_t first = (int64_t)ui_profiler_frame_number(history, 0), last = (int64_t)history->last;
	int64_t number = (int64_t)profiler->number + step;
	stilb_ui_profiler_show(profiler, (uint64_t)(number < first ? first : number > last ? last : number));
}

static void panel_draw_history(stilb_ui_profiler *profiler, stilb_ui *ui, stilb_ui_rect area)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	const stilb_prof_frame_stats *history = &profiler->history;
	panel_history h = {.area = area};
	h.area.x1 -= PANEL_LEVELS;
	if (history->count == 0 || stilb_ui_is_empty(h.area))
		return;
	h.step = (h.area.x1 - h.area.x0) / (float)STILB_PROF_STATS_FRAMES;
	h.top_ms = (float)history->max_ms;
	if (h.top_ms > PANEL_SCALE_MAX * (float)history->p50_ms)
		h.top_ms = PANEL_SCALE_MAX * (float)history->p50_ms;
	h.top_ms = h.top_ms > 0.0f ? h.top_ms * PANEL_HEADROOM : 1.0f;
	stilb_ui_draw_rect(stilb_ui_list(ui), h.area, style->plot_background);
	stilb_ui_action action = stilb_ui_area(ui, "history", h.area, STILB_UI_TAKES_KEYS);
	panel_step(profiler, ui, &action);
	ui_draw_focus(ui, h.area, style->radius, &action);
	uint32_t hot = UINT32_MAX;
	if (action.hovered && action.mouse_x >= panel_x(&h, history, 0))
		hot = (uint32_t)((action.mouse_x - panel_x(&h, history, 0)) / h.step);
	for (uint32_t i = 0; i < history->count; i++)
		panel_draw_bar(profiler, ui, &h, i, i == hot);
	panel_draw_average(profiler, ui, &h);
	panel_draw_level(ui, &h, (float)history->p50_ms, "p50", style->good);
	if (panel_y(&h, (float)history->p50_ms) - panel_y(&h, (float)history->p99_ms) > panel_line(ui))
		panel_draw_level(ui, &h, (float)history->p99_ms, "p99", stilb_ui_rgb(UI_PROFILER_BAD));
	if (hot < history->count) {
		panel_history_tip(profiler, ui, hot);
		if (action.clicked)
			stilb_ui_profiler_show(profiler, ui_profiler_frame_number(history, hot));
	}
}

/* ---- table ------------------------------------------------------------------------------------------------------- */

void ui_profiler_sort_table(stilb_ui_profiler *profiler)
{
	STILB_ASSERT(profiler->snapshot && "the rows' names are the snapshot's");
	STILB_ASSERT(profiler->sort.column < UI_PROFILER_COLUMNS);
	static const stilb_prof_order ORDERS[UI_PROFILER_COLUMNS] = {
		STILB_PROF_BY_NAME, STILB_PROF_BY_CALLS, STILB_PROF_BY_INCLUSIVE, STILB_PROF_BY_SELF, STILB_PROF_BY_OFF_CPU};
	stilb_prof_stats_sort(&profiler->stats, profiler->snapshot, ORDERS[profiler->sort.column]);
}

/* The text of a row in a column of numbers: a count, or milliseconds with "-" for 0. */
static void panel_cell_text(char *text, size_t size, const stilb_prof_row *row, uint32_t column)
{
	STILB_ASSERT(column > UI_PROFILER_NAME && column < UI_PROFILER_COLUMNS);
	uint64_t ns = column == UI_PROFILER_INCLUSIVE ? row->inclusive_ns
	              : column == UI_PROFILER_SELF    ? row->self_ns
	                                              : row->off_cpu_ns;
	if (column == UI_PROFILER_CALLS)
		snprintf(text, size, "%u", row->calls);
	else if (ns == 0)
		snprintf(text, size, "-");
	else
		snprintf(text, size, "%.3f", (double)ns * 1e-6);
}

static void panel_draw_row(stilb_ui_profiler *profiler, stilb_ui *ui, stilb_ui_rect place,
                           const stilb_ui_column *columns, const stilb_prof_row *row)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	const stilb_ui_font *font = stilb_ui_font_get(ui, STILB_UI_TEXT_NORMAL);
	stilb_ui_draw_list *list = stilb_ui_list(ui);
	STILB_ASSERT(row->label < profiler->snapshot->label_count);
	stilb_ui_rect name = stilb_ui_table_cell(place, columns, UI_PROFILER_COLUMNS, UI_PROFILER_NAME);
	float box = floorf((name.y1 - name.y0) * 0.55f), y = floorf((name.y0 + name.y1 - box) * 0.5f);
	char text[64];
	stilb_ui_draw_rounded(list, (stilb_ui_rect){name.x0, y, name.x0 + box, y + box}, 2.0f,
	                      stilb_ui_rgb(profiler->colors.rgb[row->label]));
	name.x0 += box + 6.0f;
	snprintf(text, sizeof text, "%s%s", profiler->snapshot->labels[row->label].name,
	         row->kind == STILB_PROF_LANE_DEVICE ? " (GPU)" : "");
	stilb_ui_draw_text(list, font, name, STILB_UI_ALIGN_LEFT, style->text, text);
	for (uint32_t c = UI_PROFILER_CALLS; c < UI_PROFILER_COLUMNS; c++) {
		panel_cell_text(text, sizeof text, row, c);
		stilb_ui_draw_text(list, font, stilb_ui_table_cell(place, columns, UI_PROFILER_COLUMNS, c),
		                   STILB_UI_ALIGN_RIGHT, c == profiler->sort.column ? style->text_strong : style->text, text);
	}
}

/* Zooms the lanes to the longest zone of that label in the frame, on whichever lane it is. */
static void panel_fit_longest(stilb_ui_profiler *profiler, uint32_t label)
{
	const stilb_prof_snapshot *snapshot = profiler->snapshot;
	const stilb_prof_frame *frame = ui_profiler_frame(profiler);
	const stilb_prof_zone *longest = NULL;
	for (uint32_t l = 0; l < snapshot->lane_count; l++)
		for (uint32_t i = 0; i < snapshot->lanes[l].zone_count; i++) {
			const stilb_prof_zone *zone = &snapshot->lanes[l].zones[i];
			if (zone->label == label && zone->begin_ns < frame->end_ns && zone->end_ns > frame->begin_ns &&
			    (!longest || zone->end_ns - zone->begin_ns > longest->end_ns - longest->begin_ns))
				longest = zone;
		}
	if (longest)
		ui_profiler_fit(profiler, longest->begin_ns, longest->end_ns);
}

/* If the columns together are wider than `room` pixels, drops columns, the least important numbers first, so that the
 * names keep their width. A dropped column stays in the array, practically without width. */
static void panel_fit_columns(stilb_ui_column *columns, float room)
{
	static const uint32_t LEAST_WANTED[] = {UI_PROFILER_OFF_CPU, UI_PROFILER_SELF, UI_PROFILER_CALLS};
	float width = 0.0f;
	for (uint32_t i = 0; i < UI_PROFILER_COLUMNS; i++)
		width += columns[i].width;
	for (uint32_t i = 0; i < sizeof LEAST_WANTED / sizeof *LEAST_WANTED && width > room; i++) {
		stilb_ui_column *column = &columns[LEAST_WANTED[i]];
		width -= column->width;
		*column = (stilb_ui_column){"", 0.01f, STILB_UI_ALIGN_RIGHT};
	}
}

static void panel_draw_table(stilb_ui_profiler *profiler, stilb_ui *ui, stilb_ui_rect area)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	float digits = stilb_ui_text_width(stilb_ui_font_get(ui, STILB_UI_TEXT_NORMAL), "off CPU ms") + 14.0f;
	stilb_ui_column columns[UI_PROFILER_COLUMNS] = {{"zone", 0.0f, STILB_UI_ALIGN_LEFT},
	                                                {"calls", digits * 0.75f, STILB_UI_ALIGN_RIGHT},
	                                                {"total ms", digits, STILB_UI_ALIGN_RIGHT},
	                                                {"self ms", digits, STILB_UI_ALIGN_RIGHT},
	                                                {"off CPU ms", digits, STILB_UI_ALIGN_RIGHT}};
	panel_fit_columns(columns, area.x1 - area.x0 - digits);
	stilb_ui_rect header = stilb_ui_cut_top(&area, style->row_height);
	if (stilb_ui_table_header(ui, header, "zones", columns, UI_PROFILER_COLUMNS, &profiler->sort) && profiler->snapshot)
		ui_profiler_sort_table(profiler);
	uint32_t count = profiler->snapshot ? profiler->stats.row_count : 0;
	/* stilb_prof_stats_sort puts large numbers first and names in alphabetical order; the other direction reads the
	 * rows from the end. */
	bool reverse = profiler->sort.descending == (profiler->sort.column == UI_PROFILER_NAME);
	stilb_ui_rows rows = stilb_ui_rows_begin(ui, area, "zone list", count, &profiler->table);
	for (uint32_t i = rows.first; i < rows.end; i++)
		panel_draw_row(profiler, ui, stilb_ui_row(ui, &rows, i), columns,
		               &profiler->stats.rows[reverse ? count - 1 - i : i]);
	stilb_ui_rows_end(ui);
	profiler->hot_label = STILB_PROF_NONE;
	if (rows.hovered < count)
		profiler->hot_label = profiler->stats.rows[reverse ? count - 1 - rows.hovered : rows.hovered].label;
	if (rows.clicked < count)
		panel_fit_longest(profiler, profiler->stats.rows[reverse ? count - 1 - rows.clicked : rows.clicked].label);
}

/* ---- the upper part ---------------------------------------------------------------------------------------------- */

void ui_profiler_draw_top(stilb_ui_profiler *profiler, stilb_ui *ui, stilb_ui_rect area)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	stilb_ui_rect title = stilb_ui_cut_top(&area, style->control_height);
	stilb_ui_cut_top(&area, style->gap);
	panel_draw_controls(profiler, ui, &title);
	panel_draw_title(profiler, ui, title);
	stilb_ui_rect table = stilb_ui_cut_right(&area, floorf((area.x1 - area.x0) * PANEL_TABLE));
	stilb_ui_cut_right(&area, style->gap * 2.0f);
	if (profiler->snapshot)
		panel_draw_words(profiler, ui, &area);
	stilb_ui_cut_top(&area, style->gap);
	panel_draw_history(profiler, ui, area);
	panel_draw_table(profiler, ui, table);
}

/* ---- the legend -------------------------------------------------------------------------------------------------- */

float ui_profiler_legend_height(const stilb_ui *ui)
{
	return panel_line(ui);
}

/* An entry of the legend, cut off the left end of area: a patch of colour, `height` pixels high, and its meaning. */
static void panel_draw_key(stilb_ui *ui, stilb_ui_rect *area, stilb_ui_color color, float height, const char *text)
{
	const stilb_ui_font *font = stilb_ui_font_get(ui, STILB_UI_TEXT_SMALL);
	float y = floorf((area->y0 + area->y1 - height) * 0.5f);
	if (area->x1 - area->x0 < 18.0f + stilb_ui_text_width(font, text) + 2.0f) {
		area->x1 = area->x0; /* leaves no room for the entries behind it either: a legend with holes misleads */
		return;
	}
	stilb_ui_rect patch = stilb_ui_cut_left(area, 18.0f);
	stilb_ui_draw_rect(stilb_ui_list(ui), (stilb_ui_rect){patch.x0, y, patch.x1 - 4.0f, y + height}, color);
	stilb_ui_rect label = stilb_ui_cut_left(area, stilb_ui_text_width(font, text) + 2.0f);
	stilb_ui_draw_text(stilb_ui_list(ui), font, label, STILB_UI_ALIGN_LEFT, stilb_ui_style_get(ui)->text_muted, text);
	stilb_ui_cut_left(area, 14.0f);
}

/* Why the snapshot has no context switches, or NULL if it has. */
static const char *panel_no_switches(const stilb_prof_snapshot *snapshot)
{
	for (uint32_t i = 0; i < snapshot->lane_count; i++)
		if (snapshot->lanes[i].kind == STILB_PROF_LANE_THREAD && snapshot->lanes[i].no_switches)
			return snapshot->lanes[i].no_switches;
	return NULL;
}

void ui_profiler_draw_legend(const stilb_ui_profiler *profiler, stilb_ui *ui, stilb_ui_rect area)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	const stilb_ui_font *font = stilb_ui_font_get(ui, STILB_UI_TEXT_SMALL);
	const ui_profiler_report *report = &profiler->data.report;
	const stilb_prof_frame *frame = ui_profiler_frame(profiler);
	const char *no_switches = panel_no_switches(profiler->snapshot);
	char cost[160], time[32];
	double share = frame->end_ns > frame->begin_ns
	                   ? 100.0 * (double)report->cost_ns / (double)(frame->end_ns - frame->begin_ns)
	                   : 0.0;
	int length = snprintf(cost, sizeof cost, "profiler: %u events, %s (%.2f %% of the frame)", report->events,
	                      ui_profiler_time_text(time, sizeof time, report->cost_ns), share);
	if (profiler->snapshot->without_ring > 0)
		snprintf(cost + length, sizeof cost - (size_t)length, "; %llu more missing: no memory for their threads",
		         (unsigned long long)profiler->snapshot->without_ring);
	stilb_ui_draw_text(stilb_ui_list(ui), font, stilb_ui_cut_right(&area, stilb_ui_text_width(font, cost) + 2.0f),
	                   STILB_UI_ALIGN_RIGHT, style->text_muted, cost);
	panel_draw_key(ui, &area, stilb_ui_rgb(UI_PROFILER_AVERAGE_LINE), 2.0f, "average of 10 frames");
	panel_draw_key(ui, &area, stilb_ui_rgb(UI_PROFILER_WAITING), 10.0f, "waiting");
	panel_draw_key(ui, &area, stilb_ui_rgb(UI_PROFILER_PARKED), 10.0f, "nothing to do");
	panel_draw_key(ui, &area, stilb_ui_rgb(UI_PROFILER_ATTENTION), 2.0f, "longest wait");
	panel_draw_key(ui, &area, stilb_ui_rgb(UI_PROFILER_FLOW), 1.0f, "submitted → run");
	if (no_switches) {
		stilb_ui_draw_text(stilb_ui_list(ui), font, area, STILB_UI_ALIGN_LEFT, style->text_muted, no_switches);
		return;
	}
	panel_draw_key(ui, &area, stilb_ui_rgb(UI_PROFILER_RUNNING), 4.0f, "on a CPU");
	panel_draw_key(ui, &area, stilb_ui_rgb(UI_PROFILER_BAD), 4.0f, "lost it to another thread");
}
