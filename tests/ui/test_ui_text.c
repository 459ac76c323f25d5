/* ui: text is drawn as wide as it is measured and where it should be; horizontal edges of glyphs are sharp. */
#include "test_ui_raster.h"

static ui_fonts fonts;

static const stilb_ui_color light = {230, 230, 230, 255}, dark = {10, 10, 10, 255};

static const stilb_ui_font *font(void)
{
	return &fonts.fonts[STILB_UI_TEXT_NORMAL];
}

static int make_fonts(void **state)
{
	(void)state;
	return ui_fonts_init(&fonts, 1.0f) == STILB_OK ? 0 : -1;
}

static int drop_fonts(void **state)
{
	(void)state;
	ui_fonts_finish(&fonts);
	ui_fonts_finish(&fonts); /* {0} is accepted */
	return 0;
}

static const ui_glyph *glyph_of(const stilb_ui_font *from, uint32_t character, uint32_t phase)
{
	return &from->glyphs[ui_glyph_index(character)][phase];
}

/* ---- characters -------------------------------------------------------------------------------------------------- */

static void test_characters_are_found_again(void **state)
{
	(void)state;
	const uint32_t known[] = {' ', 'A', '~', 0xa0, 0xb5, 0xd7, 0xff, 0x2026, 0x2192, 0x2264, 0x3c3, 0x25b6};
	for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
		assert_true(ui_glyph_index(known[i]) > 0);
		assert_int_equal(ui_glyph_character(ui_glyph_index(known[i])), known[i]);
	}
	const uint32_t unknown[] = {0, 7, 0x7f, 0x80, 0x100, 0x4e00, 0x1f600, UINT32_MAX};
	for (size_t i = 0; i < sizeof unknown / sizeof *unknown; i++)
		assert_int_equal(ui_glyph_index(unknown[i]), 0);
}

static void assert_characters(const char *text, const uint32_t *characters)
{
	const char *at = text, *end = text + strlen(text);
	do {
		assert_int_equal(ui_text_next(&at), *characters);
		assert_true(at <= end);
	} while (*characters++ != 0);
	assert_ptr_equal(at, end);
}

static void test_utf8(void **state)
{
	(void)state;
	uint32_t bad = UINT32_MAX;
	assert_characters("a\xc2\xb5\xe2\x86\x92\xf0\x9f\x98\x80z", (const uint32_t[]){'a', 0xb5, 0x2192, 0x1f600, 'z', 0});
	assert_characters("\x80\xbfz", (const uint32_t[]){bad, bad, 'z', 0}); /* continuation bytes without a first byte */
	assert_characters("\xe2\x86", (const uint32_t[]){bad, bad, 0});       /* the text ends within a character */
	assert_characters("\xc3z\xff",
	                  (const uint32_t[]){bad, 'z', bad, 0}); /* another character begins within a character */
	assert_characters("\xf0\x9f\x98", (const uint32_t[]){bad, bad, bad, 0});
}

/* ---- measures ---------------------------------------------------------------------------------------------------- */

static void test_widths(void **state)
{
	(void)state;
	assert_true(stilb_ui_text_width(font(), "") == 0.0f);
	float digit = stilb_ui_text_width(font(), "0");
	for (char c = '1'; c <= '9'; c++)
		assert_true(stilb_ui_text_width(font(), (char[]){c, 0}) == digit);
	assert_float_equal(stilb_ui_text_width(font(), "ab") + stilb_ui_text_width(font(), "c"),
	                   stilb_ui_text_width(font(), "abc"), 1e-4f);
	assert_true(stilb_ui_text_width(font(), "i") < stilb_ui_text_width(font(), "m"));
	assert_true(stilb_ui_text_width(&fonts.fonts[STILB_UI_TEXT_SMALL], "record") <
	            stilb_ui_text_width(font(), "record"));
	assert_true(stilb_ui_text_width(&fonts.fonts[STILB_UI_TEXT_STRONG], "record") >
	            stilb_ui_text_width(font(), "record"));
	/* Characters that the fonts lack are as wide as the box. */
	assert_true(stilb_ui_text_width(font(), "\xe4\xb8\x80") > 0.0f);
}

static void test_letters_fit_in_their_line(void **state)
{
	(void)state;
	for (int kind = 0; kind < STILB_UI_TEXT_KINDS; kind++) {
		const stilb_ui_font *f = &fonts.fonts[kind];
		assert_true(floorf(stilb_ui_font_line(f)) == stilb_ui_font_line(f));
		for (uint32_t c = 1; c < 0x2600; c++) {
			const ui_glyph *glyph = glyph_of(f, c, 0);
			assert_true(ui_glyph_index(c) == 0 || -glyph->top <= (int)f->ascent);
			assert_true(ui_glyph_index(c) == 0 || glyph->top + glyph->height <= (int)(f->line - f->ascent));
		}
	}
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

static uint8_t texel(const ui_glyph *glyph, uint32_t x, uint32_t y)
{
	return fonts.coverage[(size_t)(glyph->y + y) * fonts.width + glyph->x + x];
}

static void test_atlas_has_white_corners_and_dark_letters_below(void **state)
{
	(void)state;
	uint32_t half = fonts.height / 2;
	assert_int_equal(fonts.height, 2 * half);
	for (int corner = 0; corner < 4; corner++)
		assert_int_equal(fonts.coverage[(size_t)(corner / 2 * (fonts.height - 1)) * fonts.width +
		                                (uint32_t)(corner % 2) * (fonts.width - 1)],
		                 255);
	for (size_t i = 1; i < (size_t)half * fonts.width - 1; i++) { /* except the white corners */
		uint8_t here = fonts.coverage[i], below = fonts.coverage[(size_t)half * fonts.width + i];
		if (i != fonts.width - 1 && i != (size_t)(half - 1) * fonts.width)
			assert_true(below >= here && (here == 0) == (below == 0) && (here == 255) <= (below == 255));
	}
}

static void test_glyphs_do_not_overlap(void **state)
{
	(void)state;
	uint8_t *taken = calloc(fonts.height / 2, fonts.width);
	assert_non_null(taken);
	for (int kind = 0; kind < STILB_UI_TEXT_KINDS; kind++)
		for (uint32_t index = 0; ui_glyph_character(index) != 0; index++)
			for (uint32_t phase = 0; phase < UI_GLYPH_PHASES; phase++) {
				const ui_glyph *glyph = &fonts.fonts[kind].glyphs[index][phase];
				if (glyph->width == 0)
					continue;
				assert_true(glyph->x > 0 && glyph->x + glyph->width < fonts.width);
				assert_true(glyph->y > 0 && glyph->y + glyph->height < fonts.height / 2);
				for (uint32_t y = 0; y < glyph->height; y++)
					for (uint32_t x = 0; x < glyph->width; x++)
						assert_int_equal(taken[(size_t)(glyph->y + y) * fonts.width + glyph->x + x]++, 0);
			}
	free(taken);
}

/* The flat tops and bottoms of x and H are at boundaries of pixel rows, so none of these edges is blurred. */
static void test_letters_stand_on_rows(void **state)
{
	(void)state;
	for (int kind = 0; kind < STILB_UI_TEXT_KINDS; kind++)
		for (const char *c = "xHLEz"; *c; c++) {
			const ui_glyph *glyph = glyph_of(&fonts.fonts[kind], (uint8_t)*c, 0);
			uint8_t top = 0, bottom = 0;
			assert_int_equal(glyph->top + glyph->height, 0); /* nothing below the baseline */
			for (uint32_t x = 0; x < glyph->width; x++) {
				top = texel(glyph, x, 0) > top ? texel(glyph, x, 0) : top;
				bottom = texel(glyph, x, glyph->height - 1u) > bottom ? texel(glyph, x, glyph->height - 1u) : bottom;
			}
			assert_true(top > 180 && bottom > 180);
		}
	/* o is as high as x: its overshoot would be a blurred row. */
	assert_int_equal(glyph_of(font(), 'o', 0)->top, glyph_of(font(), 'x', 0)->top);
	assert_int_equal(glyph_of(font(), 'o', 0)->height, glyph_of(font(), 'x', 0)->height);
}

/* The x of the middle of the drawn letter o if it is placed at x. */
static double ink_middle(float x)
{
	stilb_ui_draw_list list = {0};
	raster_picture picture = raster_create(40, 30, stilb_ui_rgb(0));
	stilb_ui_list_begin(&list, 40, 30);
	stilb_ui_draw_text_at(&list, font(), x, 20.3f, light, "o");
	raster_draw(&picture, &list, &fonts);
	double sum = 0.0, moment = 0.0;
	for (uint32_t y = 0; y < 30; y++)
		for (uint32_t column = 0; column < 40; column++) {
			sum += raster_at(&picture, column, y)[0];
			moment += raster_at(&picture, column, y)[0] * column;
		}
	assert_true(sum > 0.0);
	free(picture.rgb);
	stilb_ui_list_finish(&list);
	return moment / sum;
}

static void test_text_stands_on_the_nearest_quarter(void **state)
{
	(void)state;
	double first = ink_middle(8.0f);
	for (int quarter = 0; quarter < 8; quarter++) {
		float x = 8.0f + 0.25f * (float)quarter;
		assert_float_equal((float)(ink_middle(x) - first), 0.25f * (float)quarter, 0.02f);
		assert_true(ink_middle(x + 0.1f) == ink_middle(x) && ink_middle(x - 0.1f) == ink_middle(x));
	}
}

/* ---- layout ------------------------------------------------------------------------------------------------------ */

/* The drawn text's extent from x0 to x1, pixels, and the number of its glyphs. */
typedef struct ink {
	float x0, x1;
	uint32_t glyphs;
} ink;

static ink ink_of(float width, stilb_ui_align align, const char *text)
{
	stilb_ui_draw_list list = {0};
	ink found = {1e9f, -1e9f, 0};
	stilb_ui_list_begin(&list, 400, 40);
	stilb_ui_draw_text(&list, font(), (stilb_ui_rect){20, 5, 20 + width, 27}, align, light, text);
	for (uint32_t i = 0; i < list.vertex_count; i++) {
		found.x0 = fminf(found.x0, list.vertices[i].position[0]);
		found.x1 = fmaxf(found.x1, list.vertices[i].position[0]);
		assert_true(list.vertices[i].position[1] >= 5 && list.vertices[i].position[1] <= 27);
	}
	found.glyphs = list.vertex_count / 4;
	stilb_ui_list_finish(&list);
	return found;
}

static void test_alignment_and_ellipsis(void **state)
{
	(void)state;
	float width = stilb_ui_text_width(font(), "workers"), ellipsis = stilb_ui_text_width(font(), "\xe2\x80\xa6");
	ink left = ink_of(200, STILB_UI_ALIGN_LEFT, "workers"), right = ink_of(200, STILB_UI_ALIGN_RIGHT, "workers");
	ink center = ink_of(200, STILB_UI_ALIGN_CENTER, "workers");
	assert_float_equal(left.x0, 20, 1.5f);
	assert_float_equal(right.x1, 220, 1.5f);
	assert_float_equal(center.x0 + center.x1, 240, 2.5f);
	assert_int_equal(ink_of(width + 0.01f, STILB_UI_ALIGN_LEFT, "workers").glyphs, 7);
	ink cut = ink_of(width - 0.5f, STILB_UI_ALIGN_RIGHT, "workers");
	assert_int_equal(cut.glyphs, 5); /* the ellipsis is as wide as three letters */
	assert_true(cut.x1 <= 20 + width);
	for (float room = 0.0f; room < width; room += 0.7f)
		assert_true(ink_of(room, STILB_UI_ALIGN_CENTER, "workers").x1 <= 20 + room);
	assert_int_equal(ink_of(ellipsis + 5.0f, STILB_UI_ALIGN_LEFT, "workers").glyphs, 0); /* the w does not fit */
	assert_int_equal(ink_of(0, STILB_UI_ALIGN_LEFT, "w").glyphs, 0);
	assert_int_equal(ink_of(100, STILB_UI_ALIGN_LEFT, " ").glyphs, 0);
}

static void test_drawing_ends_where_measuring_says(void **state)
{
	(void)state;
	stilb_ui_draw_list list = {0};
	stilb_ui_list_begin(&list, 400, 40);
	const char *text = "main waited 3.14 ms \xe2\x86\x92 \xc2\xb5s";
	float end = stilb_ui_draw_text_at(&list, font(), 10.3f, 20, dark, text);
	assert_float_equal(end, 10.3f + stilb_ui_text_width(font(), text), 1e-3f);
	for (uint32_t i = 0; i < list.vertex_count; i++) /* dark letters are in the lower half */
		assert_true(list.vertices[i].uv[1] > 0.5f && list.vertices[i].uv[1] < 1.0f);
	uint32_t before = list.vertex_count;
	stilb_ui_draw_text_at(&list, font(), 500, 20, light, text); /* outside the picture */
	assert_int_equal(list.vertex_count, before);
	stilb_ui_draw_text_at(&list, font(), 10, 20, light, "x");
	assert_true(list.vertices[before].uv[1] < 0.5f);
	stilb_ui_list_finish(&list);
}

static void test_scales(void **state)
{
	(void)state;
	const float scales[] = {0.5f, 1.5f, 4.0f};
	for (size_t i = 0; i < sizeof scales / sizeof *scales; i++) {
		ui_fonts scaled;
		assert_int_equal(ui_fonts_init(&scaled, scales[i]), STILB_OK);
		float width = stilb_ui_text_width(&scaled.fonts[STILB_UI_TEXT_NORMAL], "record");
		assert_float_equal(width, scales[i] * stilb_ui_text_width(font(), "record"), 0.1f * width);
		ui_fonts_finish(&scaled);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_characters_are_found_again),
		cmocka_unit_test(test_utf8),
		cmocka_unit_test(test_widths),
		cmocka_unit_test(test_letters_fit_in_their_line),
		cmocka_unit_test(test_atlas_has_white_corners_and_dark_letters_below),
		cmocka_unit_test(test_glyphs_do_not_overlap),
		cmocka_unit_test(test_letters_stand_on_rows),
		cmocka_unit_test(test_text_stands_on_the_nearest_quarter),
		cmocka_unit_test(test_alignment_and_ellipsis),
		cmocka_unit_test(test_drawing_ends_where_measuring_says),
		cmocka_unit_test(test_scales),
	};
	return cmocka_run_group_tests(tests, make_fonts, drop_fonts);
}
