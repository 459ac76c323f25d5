/* Lists, tables and plots. */
#include "ui/ui_internal.h"

#include <math.h>
#include <stdio.h>

/* ---- lists ------------------------------------------------------------------------------------------------------- */

#define WHEEL_ROWS 3.0f /* rows that a notch of the wheel scrolls */

/* Applies the arrow keys: selects another row and scrolls it into view. */
static void list_keys(const stilb_ui *ui, stilb_ui_rows *rows, uint32_t row_count, stilb_ui_list_state *state)
{
	int64_t step = (int64_t)ui->input.keys[STILB_UI_KEY_DOWN] - ui->input.keys[STILB_UI_KEY_UP];
	if (step == 0 || row_count == 0)
		return;
	int64_t row = state->selected == STILB_UI_NO_ROW ? (step > 0 ? -1 : (int64_t)row_count) : (int64_t)state->selected;
	row += step;
	row = row < 0 ? 0 : row >= row_count ? row_count - 1 : row;
	rows->changed = (uint32_t)row != state->selected;
	state->selected = (uint32_t)row;
	/* Scrolls as little as brings the row into view. */
	float top = (float)row * rows->row_height, height = rows->area.y1 - rows->area.y0;
	state->scroll = ui_clamp(state->scroll, top + rows->row_height - height, top);
}

/* Finds the row under the mouse, and selects it if it was pressed. */
static void list_mouse(const stilb_ui_action *action, stilb_ui_rows *rows, uint32_t row_count,
                       stilb_ui_list_state *state)
{
	float row = floorf((action->mouse_y - rows->area.y0 + state->scroll) / rows->row_height);
	if (!action->hovered || !(row >= 0.0f && row < (float)row_count))
		return;
	rows->hovered = (uint32_t)row;
	if (!action->pressed)
		return;
	rows->clicked = rows->hovered;
	rows->changed = state->selected != rows->clicked;
	state->selected = rows->clicked;
}

/* The scroll bar. Dragging its thumb scrolls; a press beside the thumb moves its middle to the mouse. content: the
 * height of all rows, pixels. */
static void list_bar(stilb_ui *ui, stilb_ui_rect bar, float content, stilb_ui_list_state *state)
{
	float height = bar.y1 - bar.y0, hidden = content - height;
	if (hidden <= 0.0f)
		return;
	float thumb = ui_max(height * height / content, 2.0f * ui->style.scroll_bar), travel = height - thumb;
	stilb_ui_action action = stilb_ui_area(ui, "##bar", bar, 0);
	if (action.held && travel > 0.0f) {
		float at = bar.y0 + travel * state->scroll / hidden; /* top of the thumb */
		bool beside = action.pressed && (action.mouse_y < at || action.mouse_y >= at + thumb);
		float moved = beside ? action.mouse_y - 0.5f * thumb - at : action.drag_y;
		state->scroll = ui_clamp(state->scroll + moved * hidden / travel, 0.0f, hidden);
	}
	float top = bar.y0 + travel * state->scroll / hidden, inset = roundf(2.0f * ui->scale);
	stilb_ui_rect shown = {bar.x0 + inset, top, bar.x1, top + thumb};
	stilb_ui_draw_rounded(&ui->list, shown, 0.5f * (shown.x1 - shown.x0),
	                      action.held || action.hovered ? ui->style.accent : ui->style.control_border);
}

stilb_ui_rows stilb_ui_rows_begin(stilb_ui *ui, stilb_ui_rect rect, const char *label, uint32_t row_count,
                                  stilb_ui_list_state *state)
{
	STILB_ASSERT(state);
	STILB_ASSERT(ui->style.row_height > 0.0f);
	stilb_ui_id_push(ui, label);
	stilb_ui_action action =
		stilb_ui_area(ui, "##rows", rect, STILB_UI_TAKES_WHEEL | STILB_UI_TAKES_KEYS | STILB_UI_TAKES_FOCUS);
	stilb_ui_rows rows = {
		.hovered = STILB_UI_NO_ROW, .clicked = STILB_UI_NO_ROW, .area = rect, .row_height = ui->style.row_height};
	stilb_ui_rect bar = stilb_ui_cut_right(&rows.area, ui->style.scroll_bar);
	float content = (float)row_count * rows.row_height, height = rect.y1 - rect.y0;
	if (action.focused)
		list_keys(ui, &rows, row_count, state);
	float scrolled = state->scroll - action.wheel * WHEEL_ROWS * rows.row_height;
	state->scroll = ui_clamp(scrolled, 0.0f, ui_max(content - height, 0.0f));
	list_mouse(&action, &rows, row_count, state);
	list_bar(ui, bar, content, state);
	if (state->selected >= row_count)
		state->selected = STILB_UI_NO_ROW;

	state->scroll = roundf(state->scroll);
	rows.top = rect.y0 - state->scroll;
	rows.selected = state->selected;
	rows.first = (uint32_t)(state->scroll / rows.row_height);
	float end = ceilf((state->scroll + ui_max(height, 0.0f)) / rows.row_height);
	rows.end = end < (float)row_count ? (uint32_t)end : row_count;
	if (action.focused)
		stilb_ui_draw_rect_outline(&ui->list, stilb_ui_inset(rect, -1.0f), 1.0f, ui->style.accent);
	STILB_ASSERT(rows.end <= row_count);
	STILB_ASSERT(rows.selected == STILB_UI_NO_ROW || rows.selected < row_count);
	stilb_ui_clip_push(&ui->list, rows.area);
	return rows;
}

stilb_ui_rect stilb_ui_row(stilb_ui *ui, const stilb_ui_rows *rows, uint32_t row)
{
	UI_ASSERT_IN_FRAME(ui);
	STILB_ASSERT(row >= rows->first && row < rows->end && "a visible row");
	const stilb_ui_style *style = &ui->style;
	float top = rows->top + (float)row * rows->row_height;
	stilb_ui_rect rect = {rows->area.x0, top, rows->area.x1, top + rows->row_height};
	if (row == rows->selected)
		stilb_ui_draw_rect(&ui->list, rect, style->row_selected);
	else if (row == rows->hovered)
		stilb_ui_draw_rect(&ui->list, rect, style->row_hot);
	else if (row % 2 == 1)
		stilb_ui_draw_rect(&ui->list, rect, style->row_odd);
	return rect;
}

void stilb_ui_rows_end(stilb_ui *ui)
{
	stilb_ui_clip_pop(&ui->list);
	stilb_ui_id_pop(ui);
}

/* ---- tables ------------------------------------------------------------------------------------------------------ */

/* The rectangle of a column of a row, without padding. */
static stilb_ui_rect table_column(stilb_ui_rect row, const stilb_ui_column *columns, uint32_t column_count,
                                  uint32_t column)
{
	STILB_ASSERT(columns && column < column_count);
	float left = row.x1 - row.x0;
	for (uint32_t i = 0; i < column_count; i++)
		left -= columns[i].width;
	for (uint32_t i = 0; i < column; i++)
		row.x0 += columns[i].width > 0.0f ? columns[i].width : ui_max(left, 0.0f);
	float width = columns[column].width > 0.0f ? columns[column].width : ui_max(left, 0.0f);
	return stilb_ui_cut_left(&row, width);
}

stilb_ui_rect stilb_ui_table_cell(stilb_ui_rect row, const stilb_ui_column *columns, uint32_t column_count,
                                  uint32_t column)
{
	stilb_ui_rect cell = table_column(row, columns, column_count, column);
	cell.x0 += 5.0f;
	cell.x1 -= 5.0f;
	return cell;
}

/* The triangle at the right end of the column that the table is sorted by; returns the rest of the cell, for the
 * name. */
static stilb_ui_rect header_mark(stilb_ui *ui, stilb_ui_rect cell, bool descending)
{
	float side = roundf(8.0f * ui->scale), tip = descending ? 1.0f : -1.0f;
	stilb_ui_rect mark = stilb_ui_cut_right(&cell, side + roundf(3.0f * ui->scale));
	stilb_ui_point center = {mark.x1 - 0.5f * side, roundf(0.5f * (mark.y0 + mark.y1))};
	stilb_ui_draw_triangle(&ui->list, (stilb_ui_point){center.x - 0.5f * side, center.y - tip * 0.25f * side},
	                       (stilb_ui_point){center.x + 0.5f * side, center.y - tip * 0.25f * side},
	                       (stilb_ui_point){center.x, center.y + tip * 0.35f * side}, ui->style.accent);
	return cell;
}

/* A click on a column's name. The column that sorts already changes its direction; another one begins with large
 * numbers first if it is right-aligned, else with A. */
static void sort_turn(stilb_ui_sort *sort, const stilb_ui_column *columns, uint32_t column)
{
	sort->descending = sort->column == column ? !sort->descending : columns[column].align == STILB_UI_ALIGN_RIGHT;
	sort->column = column;
}

bool stilb_ui_table_header(stilb_ui *ui, stilb_ui_rect rect, const char *label, const stilb_ui_column *columns,
                           uint32_t column_count, stilb_ui_sort *sort)
{
	STILB_ASSERT(!sort || sort->column < column_count);
	const stilb_ui_style *style = &ui->style;
	bool changed = false;
	stilb_ui_id_push(ui, label);
	stilb_ui_draw_rect(&ui->list, rect, style->panel_title);
	rect.x1 -= style->scroll_bar; /* columns are as wide as in the rows below, which have a scroll bar */
	for (uint32_t i = 0; i < column_count; i++) {
		stilb_ui_rect cell = table_column(rect, columns, column_count, i);
		bool hovered = false;
		stilb_ui_id_push_number(ui, i);
		if (sort) {
			stilb_ui_action action = stilb_ui_area(ui, columns[i].name, cell, STILB_UI_TAKES_KEYS);
			hovered = action.hovered;
			changed |= action.clicked;
			if (action.clicked)
				sort_turn(sort, columns, i);
			if (action.focused)
				stilb_ui_draw_rect_outline(&ui->list, cell, 1.0f, style->accent);
		}
		stilb_ui_id_pop(ui);
		stilb_ui_rect name = stilb_ui_table_cell(rect, columns, column_count, i);
		bool sorted = sort && sort->column == i;
		if (sorted)
			name = header_mark(ui, name, sort->descending);
		stilb_ui_draw_text(&ui->list, stilb_ui_font_get(ui, STILB_UI_TEXT_NORMAL), name, columns[i].align,
		                   hovered || sorted ? style->text_strong : style->text_muted, columns[i].name);
	}
	stilb_ui_id_pop(ui);
	return changed;
}

/* ---- plots ------------------------------------------------------------------------------------------------------- */

#define PLOT_POINTS 64 /* points drawn at once; longer lines are drawn in parts that share a point */

typedef struct plot_frame {
	stilb_ui_rect rect;
	float minimum, maximum; /* values at rect's bottom and top, minimum < maximum */
	uint32_t count;         /* number of values plotted from rect's left to its right */
} plot_frame;

/* The point of value number i. Values far outside the range are clamped: clipping hides them anyway. */
static stilb_ui_point plot_point(const plot_frame *frame, uint32_t i, float value)
{
	STILB_ASSERT(i < frame->count);
	STILB_ASSERT(frame->minimum < frame->maximum);
	float across = frame->count > 1 ? (float)i / (float)(frame->count - 1) : 0.5f;
	float up = (value - frame->minimum) / (frame->maximum - frame->minimum);
	return (stilb_ui_point){frame->rect.x0 + across * (frame->rect.x1 - frame->rect.x0),
	                        frame->rect.y1 - ui_clamp(up, -1.0f, 2.0f) * (frame->rect.y1 - frame->rect.y0)};
}

/* If the caller gave no range of values for the plot: sets that of the finite values, widened if it is empty. */
static void plot_range(plot_frame *frame, const float *values)
{
	if (frame->maximum > frame->minimum)
		return;
	frame->minimum = INFINITY;
	frame->maximum = -INFINITY;
	for (uint32_t i = 0; i < frame->count; i++)
		if (isfinite(values[i])) {
			frame->minimum = ui_min(frame->minimum, values[i]);
			frame->maximum = ui_max(frame->maximum, values[i]);
		}
	if (frame->minimum > frame->maximum)
		frame->minimum = frame->maximum = 0.0f;
	if (frame->minimum == frame->maximum) {
		float reach = ui_max(1.0f, 0.1f * fabsf(frame->minimum));
		frame->minimum -= reach;
		frame->maximum += reach;
	}
}

/* The line through all values; those that are not finite leave gaps. */
static void plot_line(stilb_ui *ui, const plot_frame *frame, const float *values)
{
	stilb_ui_point points[PLOT_POINTS];
	uint32_t count = 0;
	for (uint32_t i = 0; i <= frame->count; i++) {
		bool gap = i == frame->count || !isfinite(values[i]);
		if (!gap)
			points[count++] = plot_point(frame, i, values[i]);
		if (count > 0 && (gap || count == PLOT_POINTS)) {
			stilb_ui_draw_polyline(&ui->list, points, count, false, 1.5f * ui->scale, ui->style.accent);
			points[0] = points[count - 1];
			count = !gap;
		}
	}
}

/* The tooltip and the dot for the value nearest to the mouse. */
static void plot_hover(stilb_ui *ui, const plot_frame *frame, const stilb_ui_action *action, const char *label,
                       const float *values)
{
	if (!action->hovered || frame->count == 0)
		return;
	float across = (action->mouse_x - frame->rect.x0) / (frame->rect.x1 - frame->rect.x0);
	uint32_t i = (uint32_t)(ui_clamp(across, 0.0f, 1.0f) * (float)(frame->count - 1) + 0.5f);
	if (!isfinite(values[i]))
		return;
	char text[320];
	snprintf(text, sizeof text, "%s %u: %g", label, i, (double)values[i]);
	stilb_ui_tooltip(ui, text);
	stilb_ui_draw_circle(&ui->list, plot_point(frame, i, values[i]), 3.0f * ui->scale, ui->style.text_strong);
}

void stilb_ui_plot(stilb_ui *ui, stilb_ui_rect rect, const char *label, const float *values, uint32_t count,
                   float minimum, float maximum)
{
	enum { GRID = 4 };
	STILB_ASSERT(values || count == 0);
	const stilb_ui_style *style = &ui->style;
	const stilb_ui_font *font = stilb_ui_font_get(ui, STILB_UI_TEXT_SMALL);
	ui_label shown = ui_label_shown(label);
	stilb_ui_action action = stilb_ui_area(ui, label, rect, 0);
	plot_frame frame = {stilb_ui_inset(rect, roundf(4.0f * ui->scale)), minimum, maximum, count};
	plot_range(&frame, values);
	stilb_ui_draw_rect(&ui->list, rect, style->plot_background);
	for (uint32_t i = 0; i <= GRID; i++) {
		float y = roundf(frame.rect.y0 + (frame.rect.y1 - frame.rect.y0) * (float)i / GRID);
		stilb_ui_draw_rect(&ui->list, (stilb_ui_rect){rect.x0, y, rect.x1, y + 1.0f}, style->plot_grid);
	}
	stilb_ui_clip_push(&ui->list, rect);
	plot_line(ui, &frame, values);
	char text[32];
	stilb_ui_rect top = frame.rect, bottom = frame.rect;
	top.y1 = top.y0 + stilb_ui_font_line(font);
	bottom.y0 = bottom.y1 - stilb_ui_font_line(font);
	stilb_ui_draw_text(&ui->list, font, top, STILB_UI_ALIGN_LEFT, style->text, shown.text);
	snprintf(text, sizeof text, "%.4g", (double)frame.maximum);
	stilb_ui_draw_text(&ui->list, font, top, STILB_UI_ALIGN_RIGHT, style->text_muted, text);
	snprintf(text, sizeof text, "%.4g", (double)frame.minimum);
	stilb_ui_draw_text(&ui->list, font, bottom, STILB_UI_ALIGN_RIGHT, style->text_muted, text);
	plot_hover(ui, &frame, &action, shown.text, values);
	stilb_ui_clip_pop(&ui->list);
}
