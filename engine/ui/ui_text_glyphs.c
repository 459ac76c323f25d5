/* From outlines to pictures of glyphs. They are drawn once, at the size they are shown at, so a texel is a pixel and
 * nothing is ever resampled. Down the letters are fitted to the pixels (a baseline, an x-height or a cap height between
 * two rows would blur every letter's edge); across they keep their shape, with a picture for each quarter of a
 * pixel. */
#include "ui/ui_internal.h"

#include <math.h>
#include <stdlib.h>

/* stb_truetype leaves out what it has no memory for; `user` is told. */
static void *glyph_alloc(size_t size, void *user)
{
	void *memory = malloc(size);
	if (!memory)
		*(bool *)user = true;
	return memory;
}

#define STBTT_malloc(size, user) glyph_alloc(size, user)
#define STBTT_free(memory, user) ((void)(user), free(memory))
#define STBTT_assert(condition) ((void)sizeof(condition)) /* it goes on without memory, too */
#define STB_TRUETYPE_IMPLEMENTATION
#define STBTT_STATIC
#include <stb_truetype.h>

/* ---- characters -------------------------------------------------------------------------------------------------- */

#define ASCII_FIRST 0x20u
#define ASCII_END 0x7fu
#define LATIN_FIRST 0xa0u
#define LATIN_END 0x100u

/* Ascending. */
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

/* Heights of a typeface, in its units, that go to whole rows; between them an outline is stretched. */
#define FIT_KNOTS 8
typedef struct glyph_fit {
	float from[FIT_KNOTS], to[FIT_KNOTS];
} glyph_fit;

/* The top, or the bottom, of a letter, in the typeface's units. */
static float letter_edge(const stbtt_fontinfo *face, int letter, bool top)
{
	int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
	stbtt_GetCodepointBox(face, letter, &x0, &y0, &x1, &y1);
	return (float)(top ? y1 : y0);
}

/* Round letters reach a little beyond flat ones; at sizes of a screen that is a blurred row, so both go to one
 * height. */
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

static stbtt_vertex_type fit_unit(const glyph_fit *fit, stbtt_vertex_type y)
{
	return (stbtt_vertex_type)lrintf(fit_height(fit, (float)y));
}

/* ---- drawing ----------------------------------------------------------------------------------------------------- */

/* Rows of glyphs from the top down; the first column, row and the last ones stay free for the white corners. */
typedef struct glyph_atlas {
	uint8_t *coverage; /* NULL: only places are found */
	uint32_t width, height;
	uint32_t x, y, row; /* where the next goes, and the height of its row */
	bool out_of_memory; /* something is missing */
} glyph_atlas;

static void atlas_place(glyph_atlas *atlas, ui_glyph *glyph)
{
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

/* The pixels that the outline touches when the pen is `shift` pixels right of a pixel's edge. */
static ui_glyph glyph_box(const stbtt_vertex *outline, int count, float scale, float shift)
{
	int x0 = INT16_MAX, y0 = INT16_MAX, x1 = INT16_MIN, y1 = INT16_MIN;
	for (int i = 0; i < count; i++) { /* a curve lies within its control points */
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
	/* A unit is a hundredth of a pixel or so: no row for what reaches that far into it. */
	float slack = 0.02f;
	float left = floorf((float)x0 * scale + shift), right = ceilf((float)x1 * scale + shift);
	float top = floorf(-(float)y1 * scale + slack), bottom = ceilf(-(float)y0 * scale - slack);
	return (ui_glyph){.width = (uint16_t)(right - left),
	                  .height = (uint16_t)(bottom - top),
	                  .left = (int16_t)left,
	                  .top = (int16_t)top};
}

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

static void font_draw(stilb_ui_font *font, const uint8_t *file, float em, glyph_atlas *atlas)
{
	stbtt_fontinfo face;
	int ascent, descent, gap;
	stbtt_InitFont(&face, file, 0); /* the file is the program's own */
	face.userdata = &atlas->out_of_memory;
	float scale = stbtt_ScaleForMappingEmToPixels(&face, em);
	stbtt_GetFontVMetrics(&face, &ascent, &descent, &gap);
	glyph_fit fit = fit_of(&face, scale);
	font->ascent = ceilf((float)ascent * scale);
	font->line = font->ascent + ceilf(-(float)descent * scale);
	for (uint32_t index = 0; index < GLYPHS; index++)
		glyph_draw(font, index, &face, &fit, scale, atlas);
}

/* Places all glyphs, and draws them where the atlas has memory. */
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

/* Colours are blended in linear light, where a pixel half covered by black still looks bright: dark letters would seem
 * thin. Their coverage is raised to what blending sRGB codes would show, and a little less. Light letters need no such
 * help. */
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

stilb_result ui_fonts_init(ui_fonts *fonts, float scale)
{
	glyph_atlas atlas = {.width = 512 * (uint32_t)ceilf(scale)};
	*fonts = (ui_fonts){0};
	fonts_draw(fonts, scale, &atlas); /* finds the places */
	if (!atlas.out_of_memory)
		atlas.coverage = calloc(2 * atlas.height, atlas.width);
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
	return STILB_OK;
}

void ui_fonts_finish(ui_fonts *fonts)
{
	free(fonts->coverage);
	*fonts = (ui_fonts){0};
}
