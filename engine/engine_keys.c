/*
 * What keys, mouse and gamepad do, written from the table of actions: the key card, a panel with a line for each
 * action, and the line of main keys that is shown for the first seconds.
 */
#include "engine_internal.h"

#include <math.h>
#include <string.h>

#define KEYS_COLUMNS 4
#define KEYS_GAP 14.0f   /* pixels between columns */
#define KEYS_EDGE 6.0f   /* pixels between the card and the picture's edges at least */
#define KEYS_HELP 0.8f   /* less of the width of the help texts, and there is one column of keys */
#define KEYS_BORDER 2.0f /* pixels: the panel's border is no thicker */
#define HINT_FADING 2.0f /* the last seconds, in which the line fades */
#define HINT_GAP 18.0f   /* pixels between two keys of the line */
#define HINT_WORD 5.0f   /* pixels between a key and its name */

static const char *const keys_heads[KEYS_COLUMNS] = {"Keyboard", "Mouse", "Gamepad", ""};
static const char *const keys_narrow_heads[KEYS_COLUMNS] = {"Key or mouse", "", "", ""};

/* ---- the card ---------------------------------------------------------------------------------------------------- */

/* How the card is set: the font that fits, and the columns' widths with it. */
typedef struct keys_set {
	const stilb_ui_font *font;
	float line;                  /* height of a line, pixels */
	float columns[KEYS_COLUMNS]; /* widths, with the gap behind each but the last */
	float width;                 /* of all columns */
	uint32_t lines;
	bool narrow; /* one column for keys, mouse and gamepad: the first of these that the line has */
} keys_set;

static const char *keys_cell(const keys_set *set, const stilb_input_help *line, int column)
{
	const char *cells[KEYS_COLUMNS] = {line->keys, line->mouse, line->pad, line->help};
	if (set->narrow && column == 0 && !line->keys[0])
		return line->mouse[0] ? line->mouse : line->pad;
	return set->narrow && (column == 1 || column == 2) ? "" : cells[column];
}

static keys_set keys_measure(const stilb_input_table *table, const stilb_ui_font *font, float line_height, bool narrow)
{
	keys_set set = {.font = font, .line = line_height, .narrow = narrow};
	stilb_input_help line;
	for (uint32_t next = 0; stilb_input_help_next(table, &next, &line); set.lines++)
		for (int c = 0; c < KEYS_COLUMNS; c++)
			set.columns[c] = fmaxf(set.columns[c], stilb_ui_text_width(font, keys_cell(&set, &line, c)));
	for (int c = 0; c < KEYS_COLUMNS; c++) {
		if (set.columns[c] > 0.0f) /* a column without cells has no head */
			set.columns[c] =
				fmaxf(set.columns[c], stilb_ui_text_width(font, narrow ? keys_narrow_heads[c] : keys_heads[c]));
		bool gap = c + 1 < KEYS_COLUMNS && set.columns[c] > 0.0f;
		set.columns[c] = ceilf(set.columns[c]) + (gap ? KEYS_GAP : 0.0f);
		set.width += set.columns[c];
	}
	return set;
}

/* Height of the card around its lines. */
static float keys_around(const stilb_ui_style *style, const keys_set *set)
{
	return style->title_height + set->line + 2.0f * (style->margin + KEYS_BORDER);
}

static void keys_line(stilb_ui *ui, const keys_set *set, stilb_ui_rect place, const char *const cells[KEYS_COLUMNS],
                      const stilb_ui_color colors[KEYS_COLUMNS])
{
	for (int c = 0; c < KEYS_COLUMNS; c++) {
		stilb_ui_rect cell = stilb_ui_cut_left(&place, set->columns[c]);
		cell.x1 = c + 1 < KEYS_COLUMNS ? cell.x1 - KEYS_GAP : cell.x1;
		if (set->columns[c] > 0.0f)
			stilb_ui_draw_text(stilb_ui_list(ui), set->font, cell, STILB_UI_ALIGN_LEFT, colors[c], cells[c]);
	}
}

/* Draws the lines into the area: all of them, or a list that scrolls. */
static void keys_lines(engine_keys *keys, const stilb_input_table *table, stilb_ui *ui, const keys_set *set,
                       stilb_ui_rect area)
{
	stilb_ui_style *style = stilb_ui_style_get(ui);
	stilb_ui_color colors[KEYS_COLUMNS] = {style->text_strong, style->text_strong, style->text_strong, style->text};
	bool whole = (float)set->lines * set->line <= area.y1 - area.y0;
	stilb_ui_rows rows = {.first = 0, .end = set->lines};
	stilb_input_help line;
	float usual = style->row_height;
	style->row_height = set->line;
	if (!whole)
		rows = stilb_ui_rows_begin(ui, area, "keys", set->lines, &keys->list);
	for (uint32_t row = 0, next = 0; stilb_input_help_next(table, &next, &line); row++) {
		if (row < rows.first || row >= rows.end)
			continue;
		const char *cells[KEYS_COLUMNS];
		for (int c = 0; c < KEYS_COLUMNS; c++)
			cells[c] = keys_cell(set, &line, c);
		keys_line(ui, set, whole ? stilb_ui_cut_top(&area, set->line) : stilb_ui_row(ui, &rows, row), cells, colors);
	}
	if (!whole)
		stilb_ui_rows_end(ui);
	style->row_height = usual;
}

void engine_keys_draw(engine_keys *keys, const stilb_input_table *table, stilb_ui *ui)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	const stilb_ui_input *input = stilb_ui_input_get(ui);
	float room_x = input->width - 2.0f * KEYS_EDGE, room_y = input->height - 2.0f * KEYS_EDGE;
	keys_set set = keys_measure(table, stilb_ui_font_get(ui, STILB_UI_TEXT_NORMAL), style->row_height, false);
	float frame = 2.0f * (style->margin + KEYS_BORDER);
	if (set.width + frame > room_x || keys_around(style, &set) + (float)set.lines * set.line > room_y) {
		const stilb_ui_font *small = stilb_ui_font_get(ui, STILB_UI_TEXT_SMALL);
		set = keys_measure(table, small, ceilf(stilb_ui_font_line(small)), false);
		float left_for_help = room_x - frame - set.width + set.columns[KEYS_COLUMNS - 1];
		if (left_for_help < KEYS_HELP * set.columns[KEYS_COLUMNS - 1])
			set = keys_measure(table, small, set.line, true);
	}
	float width = fminf(set.width + frame, room_x);
	float height = fminf(keys_around(style, &set) + (float)set.lines * set.line, room_y);
	float left = floorf(0.5f * (input->width - width)), top = floorf(0.5f * (input->height - height));
	keys->place = (stilb_ui_rect){left, top, left + width, top + height};
	stilb_ui_color muted[KEYS_COLUMNS] = {style->text_muted, style->text_muted, style->text_muted, style->text_muted};
	stilb_ui_rect area = stilb_ui_panel_begin(ui, "Keys", &keys->place, 0, &keys->open);
	keys_line(ui, &set, stilb_ui_cut_top(&area, set.line), set.narrow ? keys_narrow_heads : keys_heads, muted);
	keys_lines(keys, table, ui, &set, area);
	stilb_ui_panel_end(ui);
}

/* ---- the line of main keys --------------------------------------------------------------------------------------- */

/* One key of the line, its names and what it is for, in the width that is left; returns the width that it takes, 0: it
 * does not fit. draw false: only measures. */
static float hint_key(stilb_ui *ui, const stilb_input_help *line, float x, float baseline, float room, float opacity,
                      bool draw)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	const stilb_ui_font *font = stilb_ui_font_get(ui, STILB_UI_TEXT_NORMAL);
	const char *key = line->keys[0] ? line->keys : line->mouse;
	float key_width = ceilf(stilb_ui_text_width(font, key));
	float width = key_width + HINT_WORD + ceilf(stilb_ui_text_width(font, line->name));
	if (width > room)
		return 0.0f;
	if (draw) {
		stilb_ui_draw_text_at(stilb_ui_list(ui), font, x, baseline, stilb_ui_fade(style->text_strong, opacity), key);
		stilb_ui_draw_text_at(stilb_ui_list(ui), font, x + key_width + HINT_WORD, baseline,
		                      stilb_ui_fade(style->text, opacity), line->name);
	}
	return width;
}

/* The main keys from left to right, as many as fit; the first is the one that opens the card, which has them all.
 * Returns the width that they take. */
static float hint_keys(stilb_ui *ui, const stilb_input_table *table, float x, float baseline, float room, float opacity,
                       bool draw)
{
	stilb_input_help line;
	float used = 0.0f;
	for (int pass = 0; pass < 2; pass++)
		for (uint32_t next = 0; stilb_input_help_next(table, &next, &line);) {
			if (!line.main || (line.row == STILB_ENGINE_KEYS) != (pass == 0))
				continue;
			float gap = used > 0.0f ? HINT_GAP : 0.0f;
			float width = hint_key(ui, &line, x + used + gap, baseline, room - used - gap, opacity, draw);
			used += width > 0.0f ? gap + width : 0.0f;
		}
	return used;
}

float engine_keys_hint(engine_keys *keys, const stilb_input_table *table, stilb_ui *ui, float below, bool covered)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	const stilb_ui_input *input = stilb_ui_input_get(ui);
	const stilb_ui_font *font = stilb_ui_font_get(ui, STILB_UI_TEXT_NORMAL);
	float opacity = fminf(keys->hint_seconds / HINT_FADING, 1.0f);
	keys->hint_seconds = fmaxf(keys->hint_seconds - input->seconds, 0.0f);
	float room = input->width - 2.0f * (style->margin + KEYS_EDGE);
	float width = hint_keys(ui, table, 0.0f, 0.0f, room, opacity, false) + 2.0f * style->margin;
	if (covered || room <= 0.0f)
		return 0.0f;
	float left = floorf(0.5f * (input->width - width)), bottom = floorf(input->height - below);
	stilb_ui_rect place = {left, bottom - style->control_height, left + width, bottom};
	float baseline =
		floorf(place.y0 + 0.5f * (style->control_height - stilb_ui_font_line(font)) + stilb_ui_font_ascent(font));
	stilb_ui_draw_list *list = stilb_ui_list(ui);
	stilb_ui_draw_rounded(list, place, style->radius, stilb_ui_fade(style->panel, opacity));
	stilb_ui_draw_rounded_outline(list, place, style->radius, 1.0f, stilb_ui_fade(style->panel_border, opacity));
	hint_keys(ui, table, left + style->margin, baseline, room, opacity, true);
	return style->control_height + style->gap;
}
