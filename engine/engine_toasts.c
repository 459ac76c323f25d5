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

void engine_toasts_add(engine_toasts *toasts, const char *text)
{
	STILB_ASSERT(toasts->count <= ENGINE_TOASTS);
	if (toasts->count == ENGINE_TOASTS)
		memmove(toasts->lines, toasts->lines + 1, --toasts->count * sizeof *toasts->lines);
	engine_toast *toast = &toasts->lines[toasts->count++];
	toast->seconds = TOAST_SECONDS;
	snprintf(toast->text, sizeof toast->text, "%s", text);
}

/* Draws one toast with its lower edge at this height; returns that of its upper edge. */
static float toast_draw(const engine_toast *toast, stilb_ui *ui, float bottom)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	const stilb_ui_font *font = stilb_ui_font_get(ui, STILB_UI_TEXT_NORMAL);
	stilb_ui_draw_list *list = stilb_ui_list(ui);
	float room = stilb_ui_input_get(ui)->width, opacity = toast->seconds / TOAST_FADING;
	float width = fminf(ceilf(stilb_ui_text_width(font, toast->text)) + 2.0f * style->margin, room);
	float left = floorf(0.5f * (room - width));
	stilb_ui_rect place = {left, bottom - style->control_height, left + width, bottom};
	stilb_ui_draw_rounded(list, place, style->radius, stilb_ui_fade(style->panel, opacity));
	stilb_ui_draw_rounded_outline(list, place, style->radius, 1.0f, stilb_ui_fade(style->panel_border, opacity));
	stilb_ui_rect inside = place;
	stilb_ui_cut_left(&inside, style->margin);
	stilb_ui_draw_text(list, font, inside, STILB_UI_ALIGN_LEFT, stilb_ui_fade(style->text_strong, opacity),
	                   toast->text);
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
