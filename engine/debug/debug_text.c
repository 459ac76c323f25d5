/* Text: a record for each letter, laid out by the calling thread. */
#include "debug/debug_internal.h"

#include <stdarg.h>
#include <stdio.h>

#define TEXT_BYTES 256
#define TEXT_RECORDS 64u /* that are handed over together; two a letter */
#define TEXT_HALO 0.7f   /* its alpha, as a share of the text's */

/* The fonts, which the first text makes; NULL: no memory. */
static const stilb_ui_font *text_font(stilb_debug *debug)
{
	bool there = atomic_load_explicit(&debug->has_fonts, memory_order_acquire); /* see its declaration */
	if (!there) {
		stilb_lock_take(&debug->fonts_lock);
		/* Relaxed: the lock orders it. */
		there = atomic_load_explicit(&debug->has_fonts, memory_order_relaxed) ||
		        ui_fonts_init(&debug->fonts, 1.0f) == STILB_OK;
		atomic_store_explicit(&debug->has_fonts, there, memory_order_release); /* see its declaration */
		stilb_lock_give(&debug->fonts_lock);
	}
	return there ? &debug->fonts.fonts[STILB_UI_TEXT_NORMAL] : NULL;
}

/* What stands out from text of this colour: black or white. */
static uint32_t text_halo(uint32_t rgba)
{
	stilb_ui_color text = {(uint8_t)(rgba >> 24), (uint8_t)(rgba >> 16), (uint8_t)(rgba >> 8), (uint8_t)rgba};
	stilb_ui_color halo = stilb_ui_text_color_on(text);
	return (uint32_t)halo.r << 24 | (uint32_t)halo.g << 16 | (uint32_t)halo.b << 8 |
	       (uint32_t)(TEXT_HALO * (float)text.a);
}

void stilb_debug_text(stilb_debug *debug, const float place[3], stilb_debug_style style, const char *format, ...)
{
	STILB_ASSERT(debug && place && format && debug_is_finite(place));
	char text[TEXT_BYTES];
	debug_record records[TEXT_RECORDS];
	uint32_t count = 0, word = (debug_word(style) & DEBUG_ON_TOP) | DEBUG_LETTER, halo = text_halo(style.rgba);
	va_list arguments;
	va_start(arguments, format);
	vsnprintf(text, sizeof text, format, arguments);
	va_end(arguments);
	const stilb_ui_font *font = text_font(debug);
	if (!font) {
		atomic_store_explicit(&debug->failed, true, memory_order_relaxed); /* see its declaration */
		return;
	}
	float pen = -0.5f * stilb_ui_text_width(font, text);
	const char *at = text;
	for (uint32_t c; (c = ui_text_next(&at)) != 0;) {
		uint32_t index = ui_glyph_index(c);
		/* As the user interface places letters: at quarters of a pixel. */
		float quarters = floorf(pen * UI_GLYPH_PHASES + 0.5f), whole = floorf(quarters / UI_GLYPH_PHASES);
		const ui_glyph *glyph = &font->glyphs[index][(uint32_t)(quarters - whole * UI_GLYPH_PHASES)];
		pen += font->advance[index];
		if (glyph->width == 0)
			continue;
		records[count] = (debug_record){
			.from = {place[0], place[1], place[2]},
			.rgba = style.rgba,
			.letter = {(int16_t)((int)whole + glyph->left), glyph->top, glyph->x, glyph->y, glyph->width,
		               glyph->height},
			.word = word,
		};
		records[count + 1] = records[count];
		records[count].rgba = halo;
		records[count].word |= DEBUG_HALO;
		count += 2;
		if (count < TEXT_RECORDS)
			continue;
		debug_put(debug, records, count, style.seconds);
		count = 0;
	}
	if (count > 0)
		debug_put(debug, records, count, style.seconds);
}
