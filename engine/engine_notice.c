/*
 * The notice of gamepads that may not be opened: their names and the udev rules that would permit it. It disappears
 * after a while, when the user closes it, and when the gamepads have been removed.
 */
#include "engine_internal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define NOTICE_SECONDS 30.0f
#define NOTICE_WIDTH 620.0f /* pixels at most */
#define NOTICE_TOP 16.0f    /* pixels from the picture's top */
#define NOTICE_BORDER 2.0f  /* pixels: the panel's border is no thicker */

void engine_notice_remove(engine_notice *notice, uint32_t pad)
{
	STILB_ASSERT(notice->pad_count <= ENGINE_NOTICE_PADS);
	uint32_t kept = 0;
	for (uint32_t i = 0; i < notice->pad_count; i++)
		if (notice->pads[i].pad != pad)
			notice->pads[kept++] = notice->pads[i];
	notice->pad_count = kept;
}

void engine_notice_add(engine_notice *notice, uint32_t pad, const stilb_input_pad_info *info)
{
	STILB_ASSERT(info);
	engine_notice_remove(notice, pad); /* the notice may name this pad already */
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

size_t engine_notice_line(const stilb_ui_font *font, const char *text, float width)
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

void engine_notice_text(stilb_ui *ui, const stilb_ui_font *font, stilb_ui_rect *area, stilb_ui_color color,
                        const char *text)
{
	while (*text && area->y1 - area->y0 > 0.5f * stilb_ui_font_line(font)) {
		char line[512];
		size_t length = engine_notice_line(font, text, area->x1 - area->x0);
		stilb_ui_rect row = stilb_ui_cut_top(area, stilb_ui_font_line(font));
		snprintf(line, sizeof line, "%.*s", (int)length, text);
		if (ui)
			stilb_ui_draw_text_at(stilb_ui_list(ui), font, row.x0, row.y0 + stilb_ui_font_ascent(font), color, line);
		text += length + (text[length] == '\n');
	}
}

/* The explanation, and each udev rule once. ui NULL: only measures. */
static void notice_help(const engine_notice *notice, const stilb_ui_style *style, stilb_ui *ui,
                        const stilb_ui_font *font, stilb_ui_rect *area)
{
	engine_notice_text(ui, font, area, style->text,
	                   "may not be opened by this user. As root put this line into " ENGINE_NOTICE_FILE
	                   ", run 'udevadm control --reload', and plug it in again:");
	for (uint32_t i = 0; i < notice->pad_count; i++)
		if (i == 0 || strcmp(notice->pads[i].rule, notice->pads[i - 1].rule) != 0) {
			stilb_ui_cut_top(area, style->gap);
			engine_notice_text(ui, font, area, style->accent, notice->pads[i].rule);
		}
}

/* The panel's text, cut off the area's top. draw false: only measures. brief: without the rules, for pictures too small
 * to show them whole. */
static void notice_content(const engine_notice *notice, stilb_ui *ui, bool draw, bool brief, stilb_ui_rect *area)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	const stilb_ui_font *font = stilb_ui_font_get(ui, STILB_UI_TEXT_NORMAL);
	stilb_ui *out = draw ? ui : NULL;
	for (uint32_t i = 0; i < notice->pad_count; i++)
		engine_notice_text(out, font, area, style->text_strong, notice->pads[i].who);
	stilb_ui_cut_top(area, style->gap);
	if (brief)
		engine_notice_text(
			out, font, area, style->text,
			"may not be opened by this user. The terminal says what to do, and so does a larger window.");
	else
		notice_help(notice, style, out, font, area);
}

/* Height of the whole panel, pixels. */
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
