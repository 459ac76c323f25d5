/* A panel with what is wrong with shaders, until it is right or the user closes it. */
#include "engine_internal.h"

#include <math.h>

#define PANEL_WIDTH 760.0f /* pixels at most */
#define PANEL_TOP 16.0f    /* pixels from the picture's top */
#define PANEL_BORDER 2.0f  /* pixels: the panel's border is no thicker */
#define PANEL_LINES 12.0f  /* of text at most; stderr has them all */

bool engine_watch_draw(const char *text, stilb_ui *ui)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	const stilb_ui_font *font = stilb_ui_font_get(ui, STILB_UI_TEXT_NORMAL);
	float width = fminf(PANEL_WIDTH, stilb_ui_input_get(ui)->width - 2.0f * style->margin);
	float left = floorf(0.5f * (stilb_ui_input_get(ui)->width - width)), edge = style->margin + PANEL_BORDER;
	stilb_ui_rect inner = {0.0f, 0.0f, width - 2.0f * edge, PANEL_LINES * stilb_ui_font_line(font)};
	engine_notice_text(NULL, font, &inner, style->text, text);
	float height = style->title_height + inner.y0 + 2.0f * edge;
	stilb_ui_rect place = {left, PANEL_TOP, left + width, PANEL_TOP + height};
	bool open = true;
	stilb_ui_rect area = stilb_ui_panel_begin(ui, "Shader error; the old shaders stay", &place, 0, &open);
	engine_notice_text(ui, font, &area, style->text_strong, text);
	stilb_ui_panel_end(ui);
	return open;
}
