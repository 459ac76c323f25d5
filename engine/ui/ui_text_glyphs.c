/* Rasterises the glyphs of the fonts, once, at the size at which they are shown: a texel is a pixel, and nothing is
 * resampled. Vertically, outlines are fitted to pixel rows, because a baseline, x-height or cap height between two rows
 * would blur the edges of all letters. Horizontally they keep their shape, with a picture for each quarter of a
 * pixel. */
#include "ui/ui_internal.h"

#include <math.h>
#include <stdlib.h>

/* Memory for stb_truetype. If there is none, the library leaves out a part of the glyph and goes on; so that this is
 * noticed, *user, a bool, becomes true. */
static void *glyph_alloc(size_t size, void *user)
{
	void *memory = malloc(size);
	if (!memory)
		*(bool *)user = true;
	return memory;
}

#define STBTT_malloc(size, user) glyph_alloc(size, user)
#define STBTT_free(memory, user) ((void)(user), free(memory))
#define STBTT_assert(condition) ((void)sizeof(condition)) /* off: they would fail when memory runs out */
#define STB_TRUETYPE_IMPLEMENTATION
#define STBTT_STATIC
#include <stb_truetype.h>

/* ---- characters -------------------------------------------------------------------------------------------------- */

#define ASCII_FIRST 0x20u
#define ASCII_END 0x7fu
#define LATIN_FIRST 0xa0u
#define LATIN_END 0x100u

/* Characters other than ASCII and Latin-1, ascending. */
static const uint16_t symbols[] = {
	0x0394,                         /* Delta */
	0x03a3,                         /* Sigma */
	0x03bc,                         /* mu */
	0x03c3,                         /* sigma */
	0x2013,                         /* en dash */
	0x2014,                         /* em dash */
	0x2018,                         /* single quotes */
	0x2019, 0x201c,                 /* double quotes */
	0x201d, 0x2022,                 /* bullet */
	0x2026,                         /* ellipsis */
	0x2190,                         /* arrows: left, up, right, down */
	0x2191, 0x2192, 0x2193, 0x2212, /* minus */
	0x221e,                         /* infinity */
	0x2248,                         /* almost equal */
	0x2264,                         /* less or equal */
	0x2265,                         /* greater or equal */
	0x25b2,                         /* triangles: up, right, down, left */
	0x25b6, 0x25bc, 0x25c0,
};
#define SYMBOLS ((uint32_t)(sizeof symbols / sizeof *symbols))
#define ASCII_AT 1u
#define LATIN_AT (ASCII_AT + ASCII_END - ASCII_FIRST)
#define SYMBOLS_AT (LATIN_AT + LATIN_END - LATIN_FIRST)
#define GLYPHS (SYMBOLS_AT + (uint32_t)(sizeof symbols / sizeof *symbols))

_Static_assert(GLYPHS <= UI_GLYPHS_MAX, "UI_GLYPHS_MAX is too small");

uint32_t ui_glyph_index(uint32_t character)
{
	if (character >= ASCII_FIRST && character < ASCII_END)
		return ASCII_AT + character - ASCII_FIRST;
	if (character >= LATIN_FIRST && character < LATIN_END)
		return LATIN_AT + character - LATIN_FIRST;
	for (uint32_t i = 0; i < SYMBOLS; i++)
		if (symbols[i] == character)
			return SYMBOLS_AT + i;
	return 0;
}

uint32_t ui_glyph_character(uint32_t index)
{
	if (index >= SYMBOLS_AT)
		return index < GLYPHS ? symbols[index - SYMBOLS_AT] : 0;
	if (index >= LATIN_AT)
		return LATIN_FIRST + index - LATIN_AT;
	return index >= ASCII_AT ? ASCII_FIRST + index - ASCII_AT : 0xffff;
}

/* ---- fitting ----------------------------------------------------------------------------------------------------- */

/* A piecewise linear map of heights, in the typeface's units: from[i], ascending, goes to to[i], the boundary of a row
 * of pixels. */
#define FIT_KNOTS 8
typedef struct glyph_fit {
	float from[FIT_KNOTS], to[FIT_KNOTS];
} glyph_fit;

/* The height of a letter's top or bottom, in the typeface's units, y up. */
static float letter_edge(const stbtt_fontinfo *face, int letter, bool top)
{
	int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
	stbtt_GetCodepointBox(face, letter, &x0, &y0, &x1, &y1);
	return (float)(top ? y1 : y0);
}

/* The map for a typeface at this scale. Round letters (o, O) reach a little beyond flat ones (x, H). At the sizes of a
 * screen the difference would be a blurred row, so both are mapped to the same height. */
static glyph_fit fit_of(const stbtt_fontinfo *face, float scale)
{
	float x_height = letter_edge(face, 'x', true), capitals = letter_edge(face, 'H', true);
	float heights[FIT_KNOTS] = {
		letter_edge(face, 'p', false), /* tails */
		letter_edge(face, 'o', false), 0.0f,     x_height,
		letter_edge(face, 'o', true),  capitals, letter_edge(face, 'O', true),
		letter_edge(face, 'l', true),
	};
	float flat[FIT_KNOTS] = {heights[0], 0.0f, 0.0f, x_height, x_height, capitals, capitals, heights[7]};
	glyph_fit fit;
	for (int i = 0; i < FIT_KNOTS; i++) {
		fit.from[i] = heights[i];
		fit.to[i] = roundf(flat[i] * scale) / scale;
		STILB_ASSERT(i == 0 || fit.from[i - 1] <= fit.from[i]);
	}
	return fit;
}

static float fit_height(const glyph_fit *fit, float y)
{
	if (y <= fit->from[0])
		return y + fit->to[0] - fit->from[0];
	for (int i = 1; i < FIT_KNOTS; i++)
		if (y <= fit->from[i]) {
			float t = (y - fit->from[i - 1]) / (fit->from[i] - fit->from[i - 1]);
			return fit->to[i - 1] + t * (fit->to[i] - fit->to[i - 1]);
		}
	return y + fit->to[FIT_KNOTS - 1] - fit->from[FIT_KNOTS - 1];
}

/* fit_height, rounded to the typeface's units. */
static stbtt_vertex_type fit_unit(const glyph_fit *fit, stbtt_vertex_type y)
{
	return (stbtt_vertex_type)lrintf(fit_height(fit, (float)y));
}

/* ---- drawing ----------------------------------------------------------------------------------------------------- */

/* The picture of all glyphs, filled in rows from the top down. The outermost columns and rows stay empty for the white
 * corners. */
typedef struct glyph_atlas {
	uint8_t *coverage; /* [height][width]; NULL: glyphs are given their positions, and are not drawn */
	uint32_t width, height;
	uint32_t x, y, row; /* position of the next glyph, and the height of the current row so far */
	bool out_of_memory; /* memory was short: parts of glyphs are missing */
} glyph_atlas;

/* Gives a glyph of known size its position. */
static void atlas_place(glyph_atlas *atlas, ui_glyph *glyph)
{
	STILB_ASSERT(glyph->width + 2u <= atlas->width && "an empty row holds the glyph");
	if (atlas->x + glyph->width + 1u > atlas->width) {
		atlas->x = 1;
		atlas->y += atlas->row + 1;
		atlas->row = 0;
	}
	glyph->x = (uint16_t)atlas->x;
	glyph->y = (uint16_t)atlas->y;
	atlas->x += glyph->width + 1u;
	if (glyph->height > atlas->row)
		atlas->row = glyph->height;
}

/* The size and offset of the pixels that the outline touches if the pen stands `shift` pixels, 0..1, to the right of a
 * pixel boundary. */
static ui_glyph glyph_box(const stbtt_vertex *outline, int count, float scale, float shift)
{
	int x0 = INT16_MAX, y0 = INT16_MAX, x1 = INT16_MIN, y1 = INT16_MIN;
	for (int i = 0; i < count; i++) { /* bounds of all points: a quadratic curve lies within its control points */
		bool curve = outline[i].type == STBTT_vcurve;
		int cx = curve ? outline[i].cx : outline[i].x, cy = curve ? outline[i].cy : outline[i].y;
		x0 = outline[i].x < x0 ? outline[i].x : x0;
		x1 = outline[i].x > x1 ? outline[i].x : x1;
		y0 = outline[i].y < y0 ? outline[i].y : y0;
		y1 = outline[i].y > y1 ? outline[i].y : y1;
		x0 = cx < x0 ? cx : x0;
		x1 = cx > x1 ? cx : x1;
		y0 = cy < y0 ? cy : y0;
		y1 = cy > y1 ? cy : y1;
	}
	if (count == 0)
		return (ui_glyph){0};
	/* Fitting rounds to the typeface's units, about 0.01 pixels each: an outline that reaches less than 0.02 pixels
	 * into a row gets no row. */
	float slack = 0.02f;
	float left = floorf((float)x0 * scale + shift), right = ceilf((float)x1 * scale + shift);
	float top = floorf(-(float)y1 * scale + slack), bottom = ceilf(-(float)y0 * scale - slack);
	return (ui_glyph){.width = (uint16_t)(right - left),
	                  .height = (uint16_t)(bottom - top),
	                  .left = (int16_t)left,
	                  .top = (int16_t)top};
}

/* Measures and places one glyph in all its phases, and draws it if the atlas has memory. */
static void glyph_draw(stilb_ui_font *font, uint32_t index, const stbtt_fontinfo *face, const glyph_fit *fit,
                       float scale, glyph_atlas *atlas)
{
	stbtt_vertex *outline = NULL;
	int glyph = index == 0 ? 0 : stbtt_FindGlyphIndex(face, (int)ui_glyph_character(index));
	int count = stbtt_GetGlyphShape(face, glyph, &outline), advance, bearing;
	stbtt_GetGlyphHMetrics(face, glyph, &advance, &bearing);
	font->advance[index] = (float)advance * scale;
	for (int i = 0; i < count; i++) {
		outline[i].y = fit_unit(fit, outline[i].y);
		outline[i].cy = fit_unit(fit, outline[i].cy);
	}
	for (uint32_t phase = 0; phase < UI_GLYPH_PHASES; phase++) {
		float shift = (float)phase / UI_GLYPH_PHASES;
		ui_glyph *picture = &font->glyphs[index][phase];
		*picture = glyph_box(outline, count, scale, shift);
		atlas_place(atlas, picture);
		if (!atlas->coverage || picture->width == 0)
			continue;
		stbtt__bitmap bitmap = {.w = picture->width, .h = picture->height, .stride = (int)atlas->width};
		bitmap.pixels = atlas->coverage + (size_t)picture->y * atlas->width + picture->x;
		stbtt_Rasterize(&bitmap, 0.1f, outline, count, scale, scale, shift, 0.0f, picture->left, picture->top, 1,
		                &atlas->out_of_memory);
	}
	stbtt_FreeShape(face, outline);
}

/* Measures, places and draws all glyphs of a typeface at `em` pixels an em (the font's size). */
static void font_draw(stilb_ui_font *font, const uint8_t *file, float em, glyph_atlas *atlas)
{
	stbtt_fontinfo face;
	int ascent, descent, gap;
	stbtt_InitFont(&face, file, 0);
	STILB_ASSERT(face.glyf != 0 && "the typeface in the program has outlines");
	face.userdata = &atlas->out_of_memory;
	float scale = stbtt_ScaleForMappingEmToPixels(&face, em);
	stbtt_GetFontVMetrics(&face, &ascent, &descent, &gap);
	glyph_fit fit = fit_of(&face, scale);
	font->ascent = ceilf((float)ascent * scale);
	font->line = font->ascent + ceilf(-(float)descent * scale);
	for (uint32_t index = 0; index < GLYPHS; index++)
		glyph_draw(font, index, &face, &fit, scale, atlas);
}

/* Places the glyphs of all kinds of text, and draws them if the atlas has memory. */
static void fonts_draw(ui_fonts *fonts, float scale, glyph_atlas *atlas)
{
	static const struct {
		const uint8_t *file;
		float em;
	} kinds[STILB_UI_TEXT_KINDS] = {
		[STILB_UI_TEXT_SMALL] = {ui_text_sans, 11.0f},
		[STILB_UI_TEXT_NORMAL] = {ui_text_sans, 13.0f},
		[STILB_UI_TEXT_STRONG] = {ui_text_bold, 13.0f},
	};
	atlas->x = atlas->y = 1;
	atlas->row = 0;
	for (uint32_t kind = 0; kind < STILB_UI_TEXT_KINDS; kind++)
		font_draw(&fonts->fonts[kind], kinds[kind].file, roundf(kinds[kind].em * scale), atlas);
	atlas->height = atlas->y + atlas->row + 1;
}

/* Appends the lower half with the coverage for dark letters. Colours are blended in linear light, in which a pixel half
 * covered by black still looks bright, so dark letters would look thin. Their coverage is raised until they look nearly
 * as if sRGB codes were blended. Light letters look right as they are. */
static void atlas_add_dark(glyph_atlas *atlas)
{
	uint8_t curve[256];
	size_t half = (size_t)atlas->height * atlas->width;
	for (int i = 0; i < 256; i++)
		curve[i] = (uint8_t)lrintf(255.0f * (1.0f - powf(1.0f - (float)i / 255.0f, 1.8f)));
	for (size_t i = 0; i < half; i++)
		atlas->coverage[half + i] = curve[atlas->coverage[i]];
	atlas->height *= 2;
}

/* For STILB_CHECK: every glyph lies within the upper half of the atlas, off its border. */
static bool fonts_are_sound(const ui_fonts *fonts)
{
	for (uint32_t kind = 0; kind < STILB_UI_TEXT_KINDS; kind++)
		for (uint32_t index = 0; index < GLYPHS; index++)
			for (uint32_t phase = 0; phase < UI_GLYPH_PHASES; phase++) {
				const ui_glyph *glyph = &fonts->fonts[kind].glyphs[index][phase];
				if (glyph->width > 0 && (glyph->x == 0 || glyph->x + glyph->width >= fonts->width || glyph->y == 0 ||
				                         glyph->y + glyph->height >= fonts->height / 2))
					return false;
			}
	return true;
}

stilb_result ui_fonts_init(ui_fonts *fonts, float scale)
{
	STILB_ASSERT(scale >= 0.5f && scale <= 4.0f);
	glyph_atlas atlas = {.width = 512 * (uint32_t)ceilf(scale)};
	*fonts = (ui_fonts){0};
	fonts_draw(fonts, scale, &atlas); /* first without memory: finds the positions and the atlas' height */
	if (!atlas.out_of_memory)
		atlas.coverage = calloc((size_t)2 * atlas.height, atlas.width);
	if (atlas.coverage)
		fonts_draw(fonts, scale, &atlas);
	if (!atlas.coverage || atlas.out_of_memory) {
		free(atlas.coverage);
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the glyphs of the user interface");
	}
	atlas_add_dark(&atlas);
	uint8_t *last = atlas.coverage + (size_t)(atlas.height - 1) * atlas.width;
	atlas.coverage[0] = atlas.coverage[atlas.width - 1] = last[0] = last[atlas.width - 1] = 255;
	for (uint32_t kind = 0; kind < STILB_UI_TEXT_KINDS; kind++) {
		fonts->fonts[kind].texel_x = 1.0f / (float)atlas.width;
		fonts->fonts[kind].texel_y = 1.0f / (float)atlas.height;
	}
	fonts->width = atlas.width;
	fonts->height = atlas.height;
	fonts->coverage = atlas.coverage;
	STILB_CHECK(fonts_are_sound(fonts));
	return STILB_OK;
}

void ui_fonts_finish(ui_fonts *fonts)
{
	free(fonts->coverage);
	*fonts = (ui_fonts){0};
}
