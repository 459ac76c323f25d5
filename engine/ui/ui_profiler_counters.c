/* The curves of the counters (values that the program records by name), below the timeline's lanes. A counter keeps its
 * value until the next one is recorded, so a curve is made of steps. */
#include "ui/ui_internal.h"
#include "ui/ui_profiler_internal.h"

#include <math.h>
#include <stdio.h>

#define COUNTER_LINES 2.0f /* height of a curve, in lines of text */
#define COUNTER_GAP 10.0f  /* pixels between two curves */
#define COUNTER_LINE 1.5f  /* pixels: thickness of a curve */

/* A curve that is being drawn. */
typedef struct counter_curve {
	stilb_ui_draw_list *list;
	const ui_profiler_view *view;
	stilb_ui_rect area;
	stilb_ui_color line, ground; /* line: of the curve; ground: of the area between it and the value 0 */
	double low, high;            /* values at the area's bottom and top: low <= 0 <= high, low < high */
} counter_curve;

/* The values that were recorded within one column of pixels, whose left edge is x: their range and the last one. */
typedef struct counter_column {
	float x;
	double least, most, last;
} counter_column;

float ui_profiler_counters_height(const stilb_ui_profiler *profiler, float level)
{
	return (float)profiler->data.counter_count * (COUNTER_LINES * level + COUNTER_GAP);
}

/* The x of the column of pixels in which a time is drawn, clamped to the area. */
static float counter_x(const counter_curve *curve, uint64_t ns)
{
	double x = ((double)ns - curve->view->begin_ns) * curve->view->pixels_per_ns;
	float width = curve->area.x1 - curve->area.x0;
	return floorf(curve->area.x0 + (x < 0.0 ? 0.0f : x > (double)width ? width : (float)x));
}

static float counter_y(const counter_curve *curve, double value)
{
	STILB_ASSERT(curve->low < curve->high);
	double share = (value - curve->low) / (curve->high - curve->low);
	return curve->area.y1 - COUNTER_LINE - (float)share * (curve->area.y1 - curve->area.y0 - COUNTER_LINE);
}

/* The curve at one value from x0 to x1, and the area between it and 0. */
static void counter_draw_value(const counter_curve *curve, float x0, float x1, double value)
{
	float y = counter_y(curve, value), zero = counter_y(curve, 0.0);
	stilb_ui_rect below = {x0, fminf(y, zero), x1, fmaxf(y, zero) + COUNTER_LINE};
	if (x1 <= x0)
		return;
	stilb_ui_draw_rect(curve->list, below, curve->ground);
	stilb_ui_draw_rect(curve->list, (stilb_ui_rect){x0, y, x1, y + COUNTER_LINE}, curve->line);
}

/* Draws a column's last value up to the next column at x1; several values in the column become a vertical line. */
static void counter_draw_column(const counter_curve *curve, const counter_column *column, float x1)
{
	counter_draw_value(curve, column->x, x1, column->last);
	float top = counter_y(curve, column->most), bottom = counter_y(curve, column->least) + COUNTER_LINE;
	if (column->most > column->least)
		stilb_ui_draw_rect(curve->list, (stilb_ui_rect){column->x, top, column->x + 1.0f, bottom}, curve->line);
}

/* Walks the points that are visible, and the last one before them, and draws them column by column. */
static void counter_draw_curve(const counter_curve *curve, const stilb_ui_profiler *profiler,
                               const ui_profiler_counter *counter)
{
	const stilb_prof_snapshot *snapshot = profiler->snapshot;
	const ui_profiler_view *view = curve->view;
	double end_ns = view->begin_ns + (double)(curve->area.x1 - curve->area.x0) / view->pixels_per_ns;
	uint64_t begin = ui_profiler_whole_ns(view->begin_ns), end = ui_profiler_whole_ns(end_ns);
	uint32_t i = ui_profiler_counter_at(&profiler->data, snapshot, counter, begin);
	i = i != STILB_PROF_NONE ? i : counter->first;
	counter_column column = {-1.0f, 0.0, 0.0, 0.0};
	for (; i < counter->first + counter->count; i++) {
		const stilb_prof_point *point = &snapshot->points[profiler->data.points[i]];
		float x = counter_x(curve, point->ns);
		if (point->ns > end)
			break;
		if (column.x >= 0.0f && x == column.x) {
			column.least = fmin(column.least, point->value);
			column.most = fmax(column.most, point->value);
			column.last = point->value;
			continue;
		}
		if (column.x >= 0.0f)
			counter_draw_column(curve, &column, x);
		/* The step's vertical line begins at the previous value. */
		column = (counter_column){x, point->value, point->value, point->value};
		if (i > counter->first && point->ns > begin) {
			double before = snapshot->points[profiler->data.points[i - 1]].value;
			column.least = fmin(before, point->value);
			column.most = fmax(before, point->value);
		}
	}
	if (column.x >= 0.0f)
		counter_draw_column(curve, &column, counter_x(curve, snapshot->end_ns));
}

/* The value with six significant digits, "3999.5". Returns text. */
static const char *counter_text(char *text, size_t size, double value)
{
	snprintf(text, size, "%.6g", value);
	return text;
}

/* The counter's name; below it its last value in the frame shown, and the range of its values in the whole snapshot. */
static void counter_draw_name(const stilb_ui_profiler *profiler, stilb_ui *ui, const ui_profiler_view *view, float top,
                              const ui_profiler_counter *counter)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	const stilb_prof_snapshot *snapshot = profiler->snapshot;
	const stilb_ui_font *strong = stilb_ui_font_get(ui, STILB_UI_TEXT_STRONG);
	const stilb_ui_font *small = stilb_ui_font_get(ui, STILB_UI_TEXT_SMALL);
	uint32_t last = ui_profiler_counter_at(&profiler->data, snapshot, counter, ui_profiler_frame(profiler)->end_ns);
	stilb_ui_rect place = {view->names.x0, top, view->names.x1, top + view->level};
	char text[128], value[32], least[32], most[32];
	stilb_ui_draw_text(stilb_ui_list(ui), strong, place, STILB_UI_ALIGN_LEFT, style->text_strong,
	                   snapshot->labels[counter->label].name);
	counter_text(least, sizeof least, counter->minimum);
	counter_text(most, sizeof most, counter->maximum);
	if (last == STILB_PROF_NONE)
		snprintf(value, sizeof value, "-");
	else
		counter_text(value, sizeof value, snapshot->points[profiler->data.points[last]].value);
	if (counter->minimum < counter->maximum)
		snprintf(text, sizeof text, "%s  (%s to %s)", value, least, most);
	else
		snprintf(text, sizeof text, "%s", value);
	place.y0 += view->level;
	place.y1 += view->level;
	stilb_ui_draw_text(stilb_ui_list(ui), small, place, STILB_UI_ALIGN_LEFT, style->text_muted, text);
}

/* The tooltip of the curve under the mouse: its value there, and when and by which thread that was recorded. */
static void counter_tip(const stilb_ui_profiler *profiler, stilb_ui *ui, const counter_curve *curve,
                        const ui_profiler_counter *counter)
{
	const ui_profiler_view *view = curve->view;
	const stilb_prof_snapshot *snapshot = profiler->snapshot;
	double ns = view->begin_ns + (double)(view->action.mouse_x - view->area.x0) / view->pixels_per_ns;
	uint32_t at = ui_profiler_counter_at(&profiler->data, snapshot, counter, ui_profiler_whole_ns(ns));
	char text[256], value[32], time[32];
	if (!view->action.hovered || !stilb_ui_contains(curve->area, view->action.mouse_x, view->action.mouse_y) ||
	    at == STILB_PROF_NONE)
		return;
	const stilb_prof_point *point = &snapshot->points[profiler->data.points[at]];
	snprintf(text, sizeof text, "%.100s\t%s\nrecorded\t%s before, by %.60s", snapshot->labels[counter->label].name,
	         counter_text(value, sizeof value, point->value),
	         ui_profiler_time_text(time, sizeof time, ui_profiler_whole_ns(ns) - point->ns),
	         point->lane < snapshot->lane_count ? snapshot->lanes[point->lane].name : "-");
	stilb_ui_tooltip(ui, text);
}

void ui_profiler_draw_counters(stilb_ui_profiler *profiler, stilb_ui *ui, const ui_profiler_view *view, float top)
{
	float height = COUNTER_LINES * view->level;
	for (uint32_t i = 0; i < profiler->data.counter_count; i++, top += height + COUNTER_GAP) {
		const ui_profiler_counter *counter = &profiler->data.counters[i];
		STILB_ASSERT(counter->minimum <= counter->maximum && "a counter has a point");
		stilb_ui_color color = stilb_ui_rgb(profiler->colors.rgb[counter->label]);
		counter_curve curve = {.list = stilb_ui_list(ui),
		                       .view = view,
		                       .area = {view->area.x0, top, view->area.x1, top + height},
		                       .line = color,
		                       .ground = stilb_ui_fade(color, 0.3f),
		                       .low = fmin(counter->minimum, 0.0),
		                       .high = fmax(counter->maximum, 0.0)};
		if (curve.area.y1 < view->area.y0 || curve.area.y0 > view->area.y1)
			continue;
		if (curve.high <= curve.low)
			curve.high = curve.low + 1.0;
		counter_draw_name(profiler, ui, view, top, counter);
		stilb_ui_clip_push(curve.list, view->area);
		counter_draw_curve(&curve, profiler, counter);
		stilb_ui_clip_pop(curve.list);
		counter_tip(profiler, ui, &curve, counter);
	}
}
