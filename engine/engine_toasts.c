/*
 * Toasts: lines at the picture's lower edge that say what has just been done, such as a file that was written. Each
 * fades and disappears after a few seconds.
 */
#include "engine_internal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define TOAST_SECONDS 5.0f
#define TOAST_FADING 1.0f /* the last seconds, in which it fades */
#define TOAST_EDGE 8.0f   /* pixels between a toast and the picture's sides at least */

void engine_toasts_add(engine_toasts *toasts, const char *text)
{
	STILB_ASSERT(toasts->count <= ENGINE_TOASTS);
	if (toasts->count == ENGINE_TOASTS)
		memmove(toasts->lines, toasts->lines + 1, --toasts->count * sizeof *toasts->lines);
	engine_toast *toast = &toasts->lines[toasts->count++];
	toast->seconds = TOAST_SECONDS;
	snprintf(toast->text, sizeof toast->text, "%s", text);
}

/* Fills line with the next line of the text, of this width at most, and returns what comes after it. */
static const char *toast_line(const stilb_ui_font *font, const char *text, float width, char line[static 256])
{
	size_t length = engine_notice_line(font, text, width);
	snprintf(line, 256, "%.*s", (int)length, text);
	return text + length + (text[length] == '\n');
}

/* Draws one toast, in as many lines as it needs, with its lower edge at this height; returns that of its upper edge. */
static float toast_draw(const engine_toast *toast, stilb_ui *ui, float bottom)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	const stilb_ui_font *font = stilb_ui_font_get(ui, STILB_UI_TEXT_NORMAL);
	stilb_ui_draw_list *list = stilb_ui_list(ui);
	float opacity = toast->seconds / TOAST_FADING, line_height = stilb_ui_font_line(font), width = 0.0f, lines = 0.0f;
	float room = fmaxf(stilb_ui_input_get(ui)->width - 2.0f * (style->margin + TOAST_EDGE), 1.0f);
	char line[256];
	for (const char *rest = toast->text; *rest; lines += 1.0f) {
		rest = toast_line(font, rest, room, line);
		width = fmaxf(width, ceilf(stilb_ui_text_width(font, line)));
	}
	float height = style->control_height + fmaxf(lines - 1.0f, 0.0f) * line_height;
	float left = floorf(0.5f * (stilb_ui_input_get(ui)->width - width) - style->margin);
	stilb_ui_rect place = {left, bottom - height, left + width + 2.0f * style->margin, bottom};
	stilb_ui_draw_rounded(list, place, style->radius, stilb_ui_fade(style->panel, opacity));
	stilb_ui_draw_rounded_outline(list, place, style->radius, 1.0f, stilb_ui_fade(style->panel_border, opacity));
	stilb_ui_rect inside = {place.x0 + style->margin, 0.0f, place.x1, 0.0f};
	float top = floorf(place.y0 + 0.5f * (height - lines * line_height));
	for (const char *rest = toast->text; *rest; top += line_height) {
		rest = toast_line(font, rest, room, line);
		inside.y0 = top;
		inside.y1 = top + line_height;
		stilb_ui_draw_text(list, font, inside, STILB_UI_ALIGN_LEFT, stilb_ui_fade(style->text_strong, opacity), line);
	}
	return place.y0;
}

void engine_toasts_draw(engine_toasts *toasts, stilb_ui *ui, float below)
{
	const stilb_ui_input *input = stilb_ui_input_get(ui);
	float bottom = floorf(input->height - below);
	for (uint32_t i = toasts->count; i-- > 0;)
		bottom = toast_draw(&toasts->lines[i], ui, bottom) - stilb_ui_style_get(ui)->gap;
	uint32_t kept = 0;
	for (uint32_t i = 0; i < toasts->count; i++) {
		toasts->lines[i].seconds -= input->seconds;
		if (toasts->lines[i].seconds > 0.0f)
			toasts->lines[kept++] = toasts->lines[i];
	}
	toasts->count = kept;
}
