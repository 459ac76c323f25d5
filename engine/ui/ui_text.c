/* Measures text, cuts it short and draws it, one quadrilateral for each glyph. */
#include "ui/ui_internal.h"

#include <math.h>
#include <string.h>

#define ELLIPSIS 0x2026u

float stilb_ui_font_line(const stilb_ui_font *font)
{
	return font->line;
}

float stilb_ui_font_ascent(const stilb_ui_font *font)
{
	return font->ascent;
}

/* Source: RFC 3629. Surrogates and overlong forms, which it forbids, are decoded all the same: a box is drawn at worst.
 */
uint32_t ui_text_next(const char **text)
{
	STILB_ASSERT(text && *text);
	const uint8_t *bytes = (const uint8_t *)*text;
	/* more: number of bytes that follow the first one; 4: it is a continuation byte, which begins no character. */
	uint32_t first = bytes[0], more = first < 0x80 ? 0 : first < 0xc0 ? 4 : first < 0xe0 ? 1 : first < 0xf0 ? 2 : 3;
	if (more == 0) {
		*text += first != 0;
		return first;
	}
	uint32_t character = more < 4 ? first & (0x3fu >> more) : 0;
	for (uint32_t i = 1; i <= more; i++) {
		if (more == 4 || (bytes[i] & 0xc0) != 0x80) { /* also true for the 0 at the end: nothing beyond it is read */
			*text += 1;
			return UINT32_MAX;
		}
		character = character << 6 | (bytes[i] & 0x3fu);
	}
	*text += 1 + more;
	return character;
}

float stilb_ui_text_width(const stilb_ui_font *font, const char *text)
{
	STILB_ASSERT(font);
	float width = 0.0f;
	for (uint32_t c; (c = ui_text_next(&text)) != 0;)
		width += font->advance[ui_glyph_index(c)];
	return width;
}

/* True for letters that are drawn from the lower half of the texture, see atlas_add_dark. */
static bool color_is_dark(stilb_ui_color color)
{
	return 2 * color.r + 5 * color.g + color.b < 8 * 96;
}

/* Draws a glyph with the pen at x; returns the pen's next position. */
static float draw_glyph(stilb_ui_draw_list *list, const stilb_ui_font *font, uint32_t index, float x, float baseline,
                        stilb_ui_color color)
{
	STILB_ASSERT(index < UI_GLYPHS_MAX);
	STILB_ASSERT(isfinite(x) && isfinite(baseline));
	float quarters = floorf(x * UI_GLYPH_PHASES + 0.5f), whole = floorf(quarters / UI_GLYPH_PHASES);
	const ui_glyph *glyph = &font->glyphs[index][(uint32_t)(quarters - whole * UI_GLYPH_PHASES)];
	float width = (float)glyph->width, height = (float)glyph->height;
	float x0 = whole + (float)glyph->left, y0 = baseline + (float)glyph->top;
	float x1 = x0 + width, y1 = y0 + height, end = x + font->advance[index];
	ui_mesh mesh;
	if (glyph->width == 0 || !ui_list_sees(list, x0, y0, x1, y1) || !ui_list_add(list, 4, 6, &mesh))
		return end;
	float left = (float)glyph->x, top = (float)glyph->y;
	float u0 = left * font->texel_x, u1 = (left + width) * font->texel_x;
	float half = color_is_dark(color) ? 0.5f : 0.0f;
	float v0 = half + top * font->texel_y, v1 = half + (top + height) * font->texel_y;
	float places[4][4] = {{x0, y0, u0, v0}, {x1, y0, u1, v0}, {x1, y1, u1, v1}, {x0, y1, u0, v1}};
	for (uint32_t i = 0; i < 4; i++) {
		mesh.vertices[i] = ui_vertex(places[i][0], places[i][1], color);
		mesh.vertices[i].uv[0] = places[i][2];
		mesh.vertices[i].uv[1] = places[i][3];
	}
	ui_quad_indices(mesh.indices, mesh.first, mesh.first + 1, mesh.first + 2, mesh.first + 3);
	return end;
}

/* Draws the characters of [text, end). */
static float draw_characters(stilb_ui_draw_list *list, const stilb_ui_font *font, float x, float baseline,
                             stilb_ui_color color, const char *text, const char *end)
{
	baseline = roundf(baseline);
	while (text < end)
		x = draw_glyph(list, font, ui_glyph_index(ui_text_next(&text)), x, baseline, color);
	return x;
}

float stilb_ui_draw_text_at(stilb_ui_draw_list *list, const stilb_ui_font *font, float x, float baseline,
                            stilb_ui_color color, const char *text)
{
	return draw_characters(list, font, x, baseline, color, text, text + strlen(text));
}

/* Cuts short a text that is wider than `room` pixels: returns the end of its longest beginning that fits into them
 * together with an ellipsis; NULL: not even one letter fits. */
static const char *text_fitting(const stilb_ui_font *font, const char *text, float room)
{
	const char *end = NULL;
	float width = font->advance[ui_glyph_index(ELLIPSIS)];
	for (uint32_t c; (c = ui_text_next(&text)) != 0; end = text) {
		width += font->advance[ui_glyph_index(c)];
		if (width > room)
			break;
	}
	return end;
}

void stilb_ui_draw_text(stilb_ui_draw_list *list, const stilb_ui_font *font, stilb_ui_rect rect, stilb_ui_align align,
                        stilb_ui_color color, const char *text)
{
	if (!ui_list_sees(list, rect.x0, rect.y0, rect.x1, rect.y1))
		return;
	float room = rect.x1 - rect.x0, width = stilb_ui_text_width(font, text);
	float baseline = floorf(0.5f * (rect.y0 + rect.y1 - font->line) + 0.5f) + font->ascent;
	if (width > room) {
		const char *end = text_fitting(font, text, room);
		if (!end)
			return;
		float x = draw_characters(list, font, rect.x0, baseline, color, text, end);
		draw_glyph(list, font, ui_glyph_index(ELLIPSIS), x, baseline, color);
		return;
	}
	float free_share = align == STILB_UI_ALIGN_LEFT ? 0.0f : align == STILB_UI_ALIGN_CENTER ? 0.5f : 1.0f;
	stilb_ui_draw_text_at(list, font, rect.x0 + free_share * (room - width), baseline, color, text);
}
