/* Panels, labels, buttons, check boxes, sliders and the tooltip. Widgets are drawn at whole pixels, so that their
 * straight edges are sharp and only their corners are feathered. */
#include "ui/ui_internal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- helpers of all widgets -------------------------------------------------------------------------------------- */

ui_label ui_label_shown(const char *label)
{
	STILB_ASSERT(label);
	ui_label shown;
	const char *hidden = strstr(label, "##");
	size_t length = hidden ? (size_t)(hidden - label) : strlen(label);
	if (length > sizeof shown.text - 1)
		length = sizeof shown.text - 1;
	memcpy(shown.text, label, length);
	shown.text[length] = 0;
	return shown;
}

static stilb_ui_rect rect_on_pixels(stilb_ui_rect rect)
{
	return (stilb_ui_rect){roundf(rect.x0), roundf(rect.y0), roundf(rect.x1), roundf(rect.y1)};
}

/* Thickness of borders, whole pixels, 1 at least. */
static float line_width(const stilb_ui *ui)
{
	return ui_max(1.0f, roundf(ui->scale));
}

/* The color of a control's face while the user's action on it is *action. */
static stilb_ui_color control_color(const stilb_ui *ui, const stilb_ui_action *action)
{
	if (action->held && action->hovered)
		return ui->style.control_active;
	return action->hovered || action->held ? ui->style.control_hot : ui->style.control;
}

void ui_draw_focus(stilb_ui *ui, stilb_ui_rect rect, float radius, const stilb_ui_action *action)
{
	float width = line_width(ui);
	if (action->focused)
		stilb_ui_draw_rounded_outline(&ui->list, stilb_ui_inset(rect, -2.0f * width), radius + 2.0f * width,
		                              1.5f * width, ui->style.accent);
}

/* The face of a control with its border. */
static void draw_control(stilb_ui *ui, stilb_ui_rect rect, float radius, stilb_ui_color face, stilb_ui_color border)
{
	stilb_ui_draw_rounded(&ui->list, rect, radius, border);
	stilb_ui_draw_rounded(&ui->list, stilb_ui_inset(rect, line_width(ui)), radius - line_width(ui), face);
}

/* ---- panels ------------------------------------------------------------------------------------------------------ */

/* Moves the interval [*from, *to] into [0, limit]; if it is longer than limit, so that it begins at 0. */
static void keep_within(float *from, float *to, float limit)
{
	float size = *to - *from;
	*from = roundf(ui_max(ui_min(*from, limit - size), 0.0f));
	*to = *from + roundf(size);
}

/* The title bar, by which a movable panel is dragged. */
static void panel_move(stilb_ui *ui, stilb_ui_rect *rect, uint32_t flags)
{
	stilb_ui_rect title = {rect->x0, rect->y0, rect->x1, rect->y0 + ui->style.title_height};
	if (!(flags & STILB_UI_PANEL_MOVABLE))
		return;
	stilb_ui_action drag = stilb_ui_area(ui, "##title", title, STILB_UI_TAKES_WHEEL);
	*rect =
		(stilb_ui_rect){rect->x0 + drag.drag_x, rect->y0 + drag.drag_y, rect->x1 + drag.drag_x, rect->y1 + drag.drag_y};
	keep_within(&rect->x0, &rect->x1, ui->input.width);
	keep_within(&rect->y0, &rect->y1, ui->input.height);
}

/* The box with a cross at the right end of *title; a click sets *open to false. */
static void panel_close_box(stilb_ui *ui, stilb_ui_rect *title, bool *open)
{
	stilb_ui_rect box = stilb_ui_inset(stilb_ui_cut_right(title, ui->style.title_height), roundf(4.0f * ui->scale));
	stilb_ui_action action = stilb_ui_area(ui, "##close", box, STILB_UI_TAKES_KEYS);
	if (action.clicked)
		*open = false;
	if (action.hovered)
		stilb_ui_draw_rounded(&ui->list, box, ui->style.radius, ui->style.control_hot);
	stilb_ui_rect cross = stilb_ui_inset(box, roundf(4.0f * ui->scale));
	stilb_ui_color color = action.hovered ? ui->style.text_strong : ui->style.text_muted;
	float width = 1.5f * ui->scale;
	stilb_ui_draw_line(&ui->list, (stilb_ui_point){cross.x0, cross.y0}, (stilb_ui_point){cross.x1, cross.y1}, width,
	                   color);
	stilb_ui_draw_line(&ui->list, (stilb_ui_point){cross.x0, cross.y1}, (stilb_ui_point){cross.x1, cross.y0}, width,
	                   color);
	ui_draw_focus(ui, box, ui->style.radius, &action);
}

stilb_ui_rect stilb_ui_panel_begin(stilb_ui *ui, const char *title, stilb_ui_rect *rect, uint32_t flags, bool *open)
{
	const stilb_ui_style *style = &ui->style;
	STILB_ASSERT(rect);
	STILB_ASSERT((flags & ~(uint32_t)(STILB_UI_PANEL_MOVABLE | STILB_UI_PANEL_RESIZABLE)) == 0);
	STILB_ASSERT(ui->panel_count < UI_PANEL_DEPTH);
	stilb_ui_id_push(ui, title);
	stilb_ui_area(ui, "##panel", *rect, STILB_UI_TAKES_WHEEL); /* takes the mouse from areas behind the panel */
	panel_move(ui, rect, flags);
	ui->panels[ui->panel_count++] = (ui_panel){rect, flags};

	stilb_ui_rect frame = rect_on_pixels(*rect), inside = stilb_ui_inset(frame, line_width(ui));
	stilb_ui_draw_shadow(&ui->list, frame, style->radius, 10.0f * ui->scale, style->shadow);
	stilb_ui_draw_rounded(&ui->list, inside, style->radius - line_width(ui), style->panel);
	stilb_ui_rect bar = stilb_ui_cut_top(&inside, style->title_height - line_width(ui)), content = inside;
	/* The title bar shares the panel's rounded upper corners; the clip cuts off its lower ones. */
	stilb_ui_clip_push(&ui->list, bar);
	stilb_ui_draw_rounded(&ui->list, (stilb_ui_rect){bar.x0, bar.y0, bar.x1, bar.y1 + 2.0f * style->radius},
	                      style->radius - line_width(ui), style->panel_title);
	stilb_ui_clip_pop(&ui->list);
	stilb_ui_draw_rect(&ui->list, stilb_ui_cut_bottom(&bar, line_width(ui)), style->panel_border);
	stilb_ui_draw_rounded_outline(&ui->list, frame, style->radius, line_width(ui), style->panel_border);
	if (open)
		panel_close_box(ui, &bar, open);
	stilb_ui_cut_left(&bar, style->margin);
	stilb_ui_draw_text(&ui->list, stilb_ui_font_get(ui, STILB_UI_TEXT_STRONG), bar, STILB_UI_ALIGN_LEFT, style->text,
	                   ui_label_shown(title).text);
	stilb_ui_clip_push(&ui->list, content);
	return stilb_ui_inset(content, style->margin);
}

/* The lower right corner, by which the user resizes a panel; it stays large enough for its title and a few rows. */
static void panel_resize(stilb_ui *ui, stilb_ui_rect *rect)
{
	float side = roundf(14.0f * ui->scale), least = 4.0f * ui->style.title_height;
	stilb_ui_rect corner = {rect->x1 - side, rect->y1 - side, rect->x1, rect->y1};
	stilb_ui_action drag = stilb_ui_area(ui, "##corner", corner, 0);
	stilb_ui_color color = drag.hovered || drag.held ? ui->style.accent : ui->style.control_border;
	for (int mark = 0; mark < 2; mark++) {
		float x = rect->x1 - 3.5f * ui->scale, y = rect->y1 - 3.5f * ui->scale;
		float reach = (mark == 0 ? 5.0f : 9.0f) * ui->scale;
		stilb_ui_draw_line(&ui->list, (stilb_ui_point){x - reach, y}, (stilb_ui_point){x, y - reach}, 1.5f * ui->scale,
		                   color);
	}
	rect->x1 =
		ui_clamp(rect->x1 + drag.drag_x, rect->x0 + 2.0f * least, ui_max(ui->input.width, rect->x0 + 2.0f * least));
	rect->y1 = ui_clamp(rect->y1 + drag.drag_y, rect->y0 + least, ui_max(ui->input.height, rect->y0 + least));
}

void stilb_ui_panel_end(stilb_ui *ui)
{
	UI_ASSERT_IN_FRAME(ui);
	STILB_ASSERT(ui->panel_count > 0 && "a panel has begun");
	ui_panel panel = ui->panels[--ui->panel_count];
	stilb_ui_clip_pop(&ui->list);
	if (panel.flags & STILB_UI_PANEL_RESIZABLE)
		panel_resize(ui, panel.rect);
	stilb_ui_id_pop(ui);
}

/* ---- labels ------------------------------------------------------------------------------------------------------ */

/* Pixels between a control's border and its text. */
static float text_padding(const stilb_ui *ui)
{
	return roundf(8.0f * ui->scale);
}

/* Width and height of the box of a check box, pixels. */
static float box_side(const stilb_ui *ui)
{
	return roundf(16.0f * ui->scale);
}

float stilb_ui_label_width(const stilb_ui *ui, const char *label)
{
	return ceilf(stilb_ui_text_width(stilb_ui_font_get(ui, STILB_UI_TEXT_NORMAL), ui_label_shown(label).text));
}

float stilb_ui_button_width(const stilb_ui *ui, const char *label)
{
	return stilb_ui_label_width(ui, label) + 2.0f * text_padding(ui);
}

float stilb_ui_checkbox_width(const stilb_ui *ui, const char *label)
{
	return box_side(ui) + ui->style.gap + stilb_ui_label_width(ui, label) + ui->style.gap;
}

void stilb_ui_label(stilb_ui *ui, stilb_ui_rect rect, stilb_ui_align align, const char *text)
{
	UI_ASSERT_IN_FRAME(ui);
	stilb_ui_draw_text(&ui->list, stilb_ui_font_get(ui, STILB_UI_TEXT_NORMAL), rect, align, ui->style.text, text);
}

void stilb_ui_label_muted(stilb_ui *ui, stilb_ui_rect rect, stilb_ui_align align, const char *text)
{
	UI_ASSERT_IN_FRAME(ui);
	stilb_ui_draw_text(&ui->list, stilb_ui_font_get(ui, STILB_UI_TEXT_NORMAL), rect, align, ui->style.text_muted, text);
}

/* ---- buttons ----------------------------------------------------------------------------------------------------- */

/* Draws a button of any kind; on: it is drawn as held down. True if the user pressed it. */
static bool button(stilb_ui *ui, stilb_ui_rect rect, const char *label, float radius, bool on)
{
	const stilb_ui_style *style = &ui->style;
	stilb_ui_action action = stilb_ui_area(ui, label, rect, STILB_UI_TAKES_KEYS);
	rect = rect_on_pixels(rect);
	stilb_ui_color face = control_color(ui, &action), border = style->control_border, text = style->text;
	if (on) {
		face = stilb_ui_mix(style->accent_face, style->accent, action.hovered ? 0.3f : 0.0f);
		border = style->accent;
		text = style->accent_text;
	} else if (action.hovered) {
		text = style->text_strong;
	}
	draw_control(ui, rect, radius, face, border);
	stilb_ui_rect inside = stilb_ui_inset(rect, line_width(ui));
	inside.x0 += roundf(3.0f * ui->scale);
	inside.x1 -= roundf(3.0f * ui->scale);
	stilb_ui_draw_text(&ui->list, stilb_ui_font_get(ui, STILB_UI_TEXT_NORMAL), inside, STILB_UI_ALIGN_CENTER, text,
	                   ui_label_shown(label).text);
	ui_draw_focus(ui, rect, radius, &action);
	return action.clicked;
}

bool stilb_ui_button(stilb_ui *ui, stilb_ui_rect rect, const char *label)
{
	return button(ui, rect, label, ui->style.radius, false);
}

bool stilb_ui_button_rounded(stilb_ui *ui, stilb_ui_rect rect, const char *label)
{
	return button(ui, rect, label, 0.5f * (rect.y1 - rect.y0), false);
}

bool stilb_ui_toggle(stilb_ui *ui, stilb_ui_rect rect, const char *label, bool *on)
{
	STILB_ASSERT(on);
	bool turned = button(ui, rect, label, ui->style.radius, *on);
	*on ^= turned;
	return turned;
}

static void draw_check_mark(stilb_ui *ui, stilb_ui_rect box, stilb_ui_color color)
{
	float side = box.x1 - box.x0;
	stilb_ui_point mark[3] = {{box.x0 + 0.24f * side, box.y0 + 0.52f * side},
	                          {box.x0 + 0.43f * side, box.y0 + 0.71f * side},
	                          {box.x0 + 0.77f * side, box.y0 + 0.29f * side}};
	stilb_ui_draw_polyline(&ui->list, mark, 3, false, 0.13f * side, color);
}

bool stilb_ui_checkbox(stilb_ui *ui, stilb_ui_rect rect, const char *label, bool *on)
{
	STILB_ASSERT(on);
	const stilb_ui_style *style = &ui->style;
	stilb_ui_action action = stilb_ui_area(ui, label, rect, STILB_UI_TAKES_KEYS);
	*on ^= action.clicked;
	float side = box_side(ui), top = roundf(0.5f * (rect.y0 + rect.y1 - side));
	stilb_ui_rect box = {roundf(rect.x0), top, roundf(rect.x0) + side, top + side};
	stilb_ui_color face = control_color(ui, &action);
	if (*on)
		face = stilb_ui_mix(style->accent_face, style->accent, action.hovered ? 0.3f : 0.0f);
	draw_control(ui, box, style->radius, face, *on ? style->accent : style->control_border);
	if (*on)
		draw_check_mark(ui, box, style->accent_text);
	stilb_ui_rect text = {box.x1 + style->gap, rect.y0, rect.x1, rect.y1};
	stilb_ui_draw_text(&ui->list, stilb_ui_font_get(ui, STILB_UI_TEXT_NORMAL), text, STILB_UI_ALIGN_LEFT,
	                   action.hovered ? style->text_strong : style->text, ui_label_shown(label).text);
	ui_draw_focus(ui, box, style->radius, &action);
	return action.clicked;
}

/* ---- slider ------------------------------------------------------------------------------------------------------ */

/* The nearest value of the range that is a whole number of steps from its minimum. */
static float slider_snap(const stilb_ui_slider_range *range, float value)
{
	if (range->step > 0.0f)
		value = range->minimum + roundf((value - range->minimum) / range->step) * range->step;
	return ui_clamp(value, range->minimum, range->maximum);
}

/* The value that the user chose with the mouse or the arrow keys. The knob is `knob` pixels wide and stays within the
 * track. */
static float slider_value(const stilb_ui *ui, stilb_ui_rect track, float knob, const stilb_ui_action *action,
                          const stilb_ui_slider_range *range, float value)
{
	float reach = range->maximum - range->minimum, step = range->step > 0.0f ? range->step : 0.01f * reach;
	float travel = track.x1 - track.x0 - knob;
	if (action->held && travel > 0.0f)
		value = range->minimum + (action->mouse_x - track.x0 - 0.5f * knob) / travel * reach;
	if (action->focused)
		value += step * ((float)ui->input.keys[STILB_UI_KEY_RIGHT] - (float)ui->input.keys[STILB_UI_KEY_LEFT]);
	return slider_snap(range, value);
}

/* The track with the knob, below the label and the value so that it covers neither. share: the knob's place on its way
 * from left to right, 0..1. */
static void draw_slider_track(stilb_ui *ui, stilb_ui_rect inside, float knob, float share, stilb_ui_color color)
{
	float height = roundf(5.0f * ui->scale), radius = 0.5f * height;
	float at = inside.x0 + roundf(share * (inside.x1 - inside.x0 - knob));
	stilb_ui_rect track = stilb_ui_cut_bottom(&inside, height);
	stilb_ui_draw_rounded(&ui->list, track, radius, ui->style.plot_background);
	stilb_ui_draw_rounded(&ui->list, (stilb_ui_rect){track.x0, track.y0, at + knob, track.y1}, radius,
	                      ui->style.row_selected);
	stilb_ui_draw_rounded(&ui->list, (stilb_ui_rect){at, track.y0, at + knob, track.y1}, radius, color);
}

static bool slider(stilb_ui *ui, stilb_ui_rect rect, const char *label, float *value,
                   const stilb_ui_slider_range *range, bool muted)
{
	STILB_ASSERT(value && range);
	STILB_ASSERT(range->minimum <= range->maximum && range->step >= 0.0f);
	const stilb_ui_style *style = &ui->style;
	const stilb_ui_font *font = stilb_ui_font_get(ui, STILB_UI_TEXT_NORMAL);
	stilb_ui_action action = stilb_ui_area(ui, label, rect, STILB_UI_TAKES_KEYS | STILB_UI_TAKES_FOCUS);
	float knob = roundf(12.0f * ui->scale), before = *value;
	stilb_ui_rect box = rect_on_pixels(rect), inside = stilb_ui_inset(box, line_width(ui));
	if (action.held || action.focused)
		*value = slider_value(ui, inside, knob, &action, range, *value);
	draw_control(ui, box, style->radius, style->control_active, style->control_border);

	float reach = range->maximum - range->minimum;
	float share = reach > 0.0f ? ui_clamp((*value - range->minimum) / reach, 0.0f, 1.0f) : 0.0f;
	stilb_ui_color color = muted ? style->control_border : style->accent;
	draw_slider_track(ui, inside, knob, share,
	                  action.hovered || action.held ? stilb_ui_mix(color, style->text_strong, 0.3f) : color);
	char text[64];
	snprintf(text, sizeof text, range->format ? range->format : "%.2f", (double)*value);
	stilb_ui_rect room = {inside.x0 + text_padding(ui), inside.y0, inside.x1 - text_padding(ui),
	                      inside.y1 - roundf(4.0f * ui->scale)};
	stilb_ui_draw_text(&ui->list, font, stilb_ui_cut_right(&room, ceilf(stilb_ui_text_width(font, text))),
	                   STILB_UI_ALIGN_RIGHT, muted ? style->text_muted : style->text_strong, text);
	room.x1 -= style->gap;
	stilb_ui_draw_text(&ui->list, font, room, STILB_UI_ALIGN_LEFT, muted ? style->text_muted : style->text,
	                   ui_label_shown(label).text);
	ui_draw_focus(ui, box, style->radius, &action);
	return *value != before;
}

bool stilb_ui_slider(stilb_ui *ui, stilb_ui_rect rect, const char *label, float *value,
                     const stilb_ui_slider_range *range)
{
	return slider(ui, rect, label, value, range, false);
}

bool stilb_ui_slider_muted(stilb_ui *ui, stilb_ui_rect rect, const char *label, float *value,
                           const stilb_ui_slider_range *range)
{
	return slider(ui, rect, label, value, range, true);
}

/* ---- tooltip ----------------------------------------------------------------------------------------------------- */

void stilb_ui_tooltip(stilb_ui *ui, const char *text)
{
	snprintf(ui->tooltip, sizeof ui->tooltip, "%s", text);
}

/* One line of the tooltip's text, as pointers into it: its two columns, and the begin of the next line; NULL: none. */
typedef struct tooltip_line {
	char *left, *right, *next;
} tooltip_line;

static tooltip_line tooltip_split(char *text)
{
	tooltip_line line = {.left = text, .next = strchr(text, '\n')};
	if (line.next)
		*line.next++ = 0;
	line.right = strchr(text, '\t');
	if (line.right)
		*line.right++ = 0;
	return line;
}

/* The tooltip's rectangle: below the mouse and to the right, or above it and to the left where the picture ends. */
static stilb_ui_rect tooltip_place(const stilb_ui *ui, float width, float height)
{
	const stilb_ui_input *input = &ui->input;
	float x = input->mouse_x + 14.0f * ui->scale, y = input->mouse_y + 18.0f * ui->scale;
	if (x + width > input->width)
		x = input->mouse_x - width - 6.0f * ui->scale;
	if (y + height > input->height)
		y = input->mouse_y - height - 6.0f * ui->scale;
	x = roundf(ui_max(x, 0.0f));
	y = roundf(ui_max(y, 0.0f));
	return (stilb_ui_rect){x, y, x + width, y + height};
}

void ui_tooltip_draw(stilb_ui *ui)
{
	enum { LINES_MAX = 32 };
	const stilb_ui_style *style = &ui->style;
	tooltip_line lines[LINES_MAX];
	uint32_t count = 0;
	float width = 0.0f, between = roundf(20.0f * ui->scale);
	bool heading = strchr(ui->tooltip, '\n');
	for (char *text = ui->tooltip; text && *text && count < LINES_MAX; text = lines[count++].next) {
		lines[count] = tooltip_split(text);
		bool strong = heading && count == 0;
		const stilb_ui_font *font = stilb_ui_font_get(ui, strong ? STILB_UI_TEXT_STRONG : STILB_UI_TEXT_NORMAL);
		float wide = stilb_ui_text_width(font, lines[count].left);
		if (lines[count].right)
			wide += between + stilb_ui_text_width(font, lines[count].right);
		width = ui_max(width, wide);
	}
	if (count == 0)
		return;
	float line = stilb_ui_font_line(stilb_ui_font_get(ui, STILB_UI_TEXT_NORMAL));
	stilb_ui_rect box =
		tooltip_place(ui, ceilf(width) + 2.0f * style->margin, (float)count * line + 1.5f * style->margin);
	stilb_ui_draw_shadow(&ui->list, box, style->radius, 8.0f * ui->scale, style->shadow);
	draw_control(ui, box, style->radius, style->panel_title, style->control_border);
	stilb_ui_rect inside = {box.x0 + style->margin, box.y0 + roundf(0.75f * style->margin), box.x1 - style->margin,
	                        box.y1};
	for (uint32_t i = 0; i < count; i++) {
		stilb_ui_rect row = stilb_ui_cut_top(&inside, line);
		bool strong = heading && i == 0;
		const stilb_ui_font *font = stilb_ui_font_get(ui, strong ? STILB_UI_TEXT_STRONG : STILB_UI_TEXT_NORMAL);
		stilb_ui_color color = strong ? style->text_strong : lines[i].right ? style->text_muted : style->text;
		stilb_ui_draw_text(&ui->list, font, row, STILB_UI_ALIGN_LEFT, color, lines[i].left);
		if (lines[i].right)
			stilb_ui_draw_text(&ui->list, font, row, STILB_UI_ALIGN_RIGHT, style->text, lines[i].right);
	}
}
