/*
 * The notice of gamepads that may not be opened: which one, and the rule that gives permission, for as long as it takes
 * to read, or until it is given.
 */
#include "engine_internal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define NOTICE_SECONDS 30.0f
#define NOTICE_WIDTH 620.0f /* pixels, where the picture is as wide */
#define NOTICE_TOP 16.0f
#define NOTICE_BORDER 2.0f /* the panel's, or a little more */

void engine_notice_remove(engine_notice *notice, uint32_t pad)
{
	uint32_t kept = 0;
	for (uint32_t i = 0; i < notice->pad_count; i++)
		if (notice->pads[i].pad != pad)
			notice->pads[kept++] = notice->pads[i];
	notice->pad_count = kept;
}

void engine_notice_add(engine_notice *notice, uint32_t pad, const stilb_input_pad_info *info)
{
	engine_notice_remove(notice, pad); /* told of before */
	if (notice->pad_count == ENGINE_NOTICE_PADS)
		engine_notice_remove(notice, notice->pads[0].pad);
	uint32_t place = notice->pad_count++;
	notice->pads[place].pad = pad;
	snprintf(notice->pads[place].who, sizeof notice->pads[place].who, "%s (%04x:%04x) at %s",
	         info->name[0] ? info->name : "A gamepad", info->vendor, info->product, info->path);
	stilb_input_udev_rule(info, notice->pads[place].rule, sizeof notice->pads[place].rule);
	notice->seconds = NOTICE_SECONDS;
}

/* ---- drawing ----------------------------------------------------------------------------------------------------- */

/* How much of the text, bytes, goes into one line: up to a blank, a comma or a newline where there is one. */
static size_t notice_line(const stilb_ui_font *font, const char *text, float width)
{
	char line[512];
	size_t fits = 0, length = 0;
	while (text[length] && text[length] != '\n' && length + 1 < sizeof line) {
		line[length] = text[length];
		line[++length] = '\0';
		if (stilb_ui_text_width(font, line) > width)
			return fits > 0 ? fits : length;
		if (strchr(" ,", text[length - 1]))
			fits = length;
	}
	return length;
}

/* Text from the area's top, which is cut off, in as many lines as it takes; only measured where ui is NULL. */
static void notice_text(stilb_ui *ui, const stilb_ui_font *font, stilb_ui_rect *area, stilb_ui_color color,
                        const char *text)
{
	while (*text) {
		char line[512];
		size_t length = notice_line(font, text, area->x1 - area->x0);
		stilb_ui_rect row = stilb_ui_cut_top(area, stilb_ui_font_line(font));
		snprintf(line, sizeof line, "%.*s", (int)length, text);
		if (ui)
			stilb_ui_draw_text_at(stilb_ui_list(ui), font, row.x0, row.y0 + stilb_ui_font_ascent(font), color, line);
		text += length + (text[length] == '\n');
	}
}

/* Measured with ui NULL, like notice_text. */
static void notice_help(const engine_notice *notice, const stilb_ui_style *style, stilb_ui *ui,
                        const stilb_ui_font *font, stilb_ui_rect *area)
{
	notice_text(ui, font, area, style->text,
	            "may not be opened by this user. As root put this line into " ENGINE_NOTICE_FILE
	            ", run 'udevadm control --reload', and plug it in again:");
	for (uint32_t i = 0; i < notice->pad_count; i++)
		if (i == 0 || strcmp(notice->pads[i].rule, notice->pads[i - 1].rule) != 0) {
			stilb_ui_cut_top(area, style->gap);
			notice_text(ui, font, area, style->accent, notice->pads[i].rule);
		}
}

/* The words from the area's top on; draw false: only how much room they take. brief: half a rule would help nobody. */
static void notice_content(const engine_notice *notice, stilb_ui *ui, bool draw, bool brief, stilb_ui_rect *area)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	const stilb_ui_font *font = stilb_ui_font_get(ui, STILB_UI_TEXT_NORMAL);
	stilb_ui *out = draw ? ui : NULL;
	for (uint32_t i = 0; i < notice->pad_count; i++)
		notice_text(out, font, area, style->text_strong, notice->pads[i].who);
	stilb_ui_cut_top(area, style->gap);
	if (brief)
		notice_text(out, font, area, style->text,
		            "may not be opened by this user. The terminal says what to do, and so does a larger window.");
	else
		notice_help(notice, style, out, font, area);
}

/* Of the whole panel. */
static float notice_height(const engine_notice *notice, stilb_ui *ui, bool brief, float width)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	float edge = style->margin + NOTICE_BORDER;
	stilb_ui_rect inner = {0.0f, 0.0f, width - 2.0f * edge, 1e6f};
	notice_content(notice, ui, false, brief, &inner);
	return style->title_height + inner.y0 + 2.0f * edge;
}

void engine_notice_draw(engine_notice *notice, stilb_ui *ui)
{
	const stilb_ui_input *input = stilb_ui_input_get(ui);
	float width = fminf(NOTICE_WIDTH, input->width - 2.0f * stilb_ui_style_get(ui)->margin);
	float left = floorf(0.5f * (input->width - width));
	bool brief = NOTICE_TOP + notice_height(notice, ui, false, width) > input->height;
	float height = notice_height(notice, ui, brief, width);
	stilb_ui_rect place = {left, NOTICE_TOP, left + width, NOTICE_TOP + height};
	bool open = true;
	stilb_ui_rect area = stilb_ui_panel_begin(ui, "No permission for a gamepad", &place, 0, &open);
	notice_content(notice, ui, true, brief, &area);
	stilb_ui_panel_end(ui);
	notice->seconds -= input->seconds;
	if (!open || notice->seconds <= 0.0f)
		notice->pad_count = 0;
}
