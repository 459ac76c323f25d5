/* What debug drawing looks like, against closed forms: colours, widths, ends, what hides it, the camera's planes,
 * spheres, letters, order; and the same picture whichever threads draw. */
#include "scene/edit/scene_edit.h"
#include "shading/shade_srgb.h"
#include "tests/debug/debug_world.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define W WORLD_WIDTH
#define H WORLD_HEIGHT

static stilb_engine_desc device_desc(uint32_t samples, stilb_render_output output)
{
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.workers = 1;
	desc.samples = samples;
	desc.output = output;
	desc.validate = true;
	return desc;
}

/* The last frame's picture: three floats a pixel, linear light, or codes 0..255. */
typedef struct picture {
	float pixels[H][W][3];
} picture;

static float half_float(uint16_t bits)
{
	float magnitude = (bits & 0x7c00) ? ldexpf((float)((bits & 0x3ff) | 0x400), (bits >> 10 & 31) - 25)
	                                  : ldexpf((float)(bits & 0x3ff), -24);
	return bits & 0x8000 ? -magnitude : magnitude;
}

static void read_picture(const world *w, picture *out)
{
	stilb_image image;
	if (stilb_render_read_image(w->engine->render, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_true(image.width == W && image.height == H && image.channels == 3);
	for (uint32_t i = 0; i < W * H * 3; i++)
		(&out->pixels[0][0][0])[i] = image.format == STILB_IMAGE_U8_SRGB
		                                 ? ((const uint8_t *)image.pixels)[i]
		                                 : half_float(((const uint16_t *)image.pixels)[i]);
	stilb_image_finish(&image);
}

static void frame(const world *w, picture *out)
{
	stilb_engine_report report;
	if (stilb_engine_frame(w->engine, &report) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	read_picture(w, out);
}

static void assert_near(const picture *p, uint32_t x, uint32_t y, int channel, float want, float tolerance)
{
	float got = p->pixels[y][x][channel];
	if (!(fabsf(got - want) <= tolerance))
		fail_msg("pixel %u, %u channel %d: %g, not %g", x, y, channel, (double)got, (double)want);
}

/* A horizontal line of a width covers so many rows, in its own colour. */
static void lines_have_their_width(void **state)
{
	(void)state;
	static const uint8_t code[3] = {0x40, 0x80, 0xc0};
	for (uint32_t samples = 1; samples <= 4; samples += 3) {
		world w = world_open(device_desc(samples, STILB_RENDER_OUTPUT_DISPLAY));
		for (uint32_t width = 1; width <= 5; width++) {
			picture p;
			float middle = 10.0f + 0.5f * (float)width;
			world_line(&w, -50.0f, middle, 200.0f, middle, 2.0f,
			           (stilb_debug_style){.rgba = 0x4080c0ff, .width = width == 1 ? 0.0f : (float)width});
			frame(&w, &p);
			for (uint32_t y = 0; y < H; y++)
				for (uint32_t x = 0; x < W; x++)
					for (int c = 0; c < 3; c++)
						assert_near(&p, x, y, c, y >= 10 && y < 10 + width ? code[c] : 0.0f, 0.0f);
		}
		world_close(&w);
	}
}

/* Between rows each gets its share; so do lines thinner than a pixel, and alpha; blended in linear light. */
static void edges_are_smooth(void **state)
{
	(void)state;
	static const struct {
		float middle, width;
		uint32_t alpha;
		float rows[3]; /* 9, 10, 11 */
	} cases[] = {
		{10.5f, 1.0f, 255, {0.0f, 1.0f, 0.0f}},    {10.75f, 1.0f, 255, {0.0f, 0.75f, 0.25f}},
		{10.25f, 1.0f, 255, {0.25f, 0.75f, 0.0f}}, {10.5f, 0.5f, 255, {0.0f, 0.5f, 0.0f}},
		{11.0f, 0.5f, 255, {0.0f, 0.25f, 0.25f}},  {10.5f, 2.0f, 255, {0.5f, 1.0f, 0.5f}},
		{10.5f, 1.0f, 51, {0.0f, 0.2f, 0.0f}},
	};
	world w = world_open(device_desc(1, STILB_RENDER_OUTPUT_LINEAR));
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		picture p;
		world_line(&w, 5.0f, cases[i].middle, 60.0f, cases[i].middle, 3.0f,
		           (stilb_debug_style){.rgba = 0xbcffff00u | cases[i].alpha, .width = cases[i].width});
		frame(&w, &p);
		for (uint32_t y = 8; y < 13; y++) {
			float share = y >= 9 && y < 12 ? cases[i].rows[y - 9] : 0.0f;
			assert_near(&p, 30, y, 1, share, 2e-3f);
			assert_near(&p, 30, y, 0, share * shade_srgb_to_linear(0xbc / 255.0f), 2e-3f);
		}
	}
	world_close(&w);
	/* Half of white over half of white is three quarters of the light, as codes: 225. */
	w = world_open(device_desc(1, STILB_RENDER_OUTPUT_DISPLAY));
	picture p;
	for (int i = 0; i < 2; i++)
		world_line(&w, -5.0f, 10.5f, 80.0f, 10.5f, 3.0f + (float)i, (stilb_debug_style){.rgba = 0xffffff80});
	frame(&w, &p);
	float half = 128.0f / 255.0f;
	assert_near(&p, 30, 10, 0, 255.0f * shade_srgb_from_linear(half + (1.0f - half) * half), 0.6f);
	world_close(&w);
}

/* Ends are half discs; a dot is a disc: its area is that of a circle, at any place within its pixel. */
static void ends_are_round(void **state)
{
	(void)state;
	world w = world_open(device_desc(1, STILB_RENDER_OUTPUT_LINEAR));
	for (int i = 0; i < 8; i++) {
		picture p;
		float x = 20.0f + 0.13f * (float)i, y = 20.0f + 0.29f * (float)i, at[3];
		double sum = 0.0;
		world_place(x, y, 2.0f, at);
		stilb_debug_line(w.debug, at, at, (stilb_debug_style){.rgba = 0xffffffff, .width = 9.0f});
		frame(&w, &p);
		for (uint32_t r = 0; r < H; r++)
			for (uint32_t c = 0; c < W; c++) {
				float distance = hypotf((float)c + 0.5f - x, (float)r + 0.5f - y);
				assert_near(&p, c, r, 0, fminf(fmaxf(5.0f - distance, 0.0f), 1.0f), 2e-3f);
				sum += (double)p.pixels[r][c][0];
			}
		assert_true(fabs(sum / (3.14159265 * 4.5 * 4.5) - 1.0) < 0.02);
	}
	world_close(&w);
}

/* A diagonal's light is its area. */
static void diagonals_have_their_area(void **state)
{
	(void)state;
	world w = world_open(device_desc(1, STILB_RENDER_OUTPUT_LINEAR));
	for (int i = 0; i < 12; i++) {
		picture p;
		float angle = 0.5236f * (float)i + 0.1f, width = 1.0f + 0.37f * (float)i;
		float x = 15.0f * cosf(angle), y = 15.0f * sinf(angle);
		world_line(&w, 33.0f - x, 20.0f - y, 33.0f + x, 20.0f + y, 4.0f,
		           (stilb_debug_style){.rgba = 0xffffffff, .width = width});
		frame(&w, &p);
		double sum = 0.0, want = 30.0 * (double)width + 0.785398 * (double)(width * width);
		for (uint32_t n = 0; n < W * H; n++)
			sum += (double)(&p.pixels[0][0][0])[3 * n];
		if (fabs(sum / want - 1.0) > 0.03)
			fail_msg("width %g, angle %g: %g pixels, not %g", (double)width, (double)angle, sum, want);
	}
	world_close(&w);
}

/* The square hides what is behind it, unless that is on top; what lies on it is seen. */
static void the_scene_hides_lines(void **state)
{
	(void)state;
	static const struct {
		float distance;
		bool on_top, hidden;
	} cases[] = {{4.0f, false, false},       {6.0f, false, true},  {6.0f, true, false},
	             {WORLD_WALL, false, false}, {99.0f, false, true}, {WORLD_WALL * 1.002f, false, true}};
	for (uint32_t samples = 1; samples <= 4; samples += 3) {
		world w = world_open(device_desc(samples, STILB_RENDER_OUTPUT_LINEAR));
		for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
			picture p;
			world_line(&w, -10.0f, 20.5f, 80.0f, 20.5f, cases[i].distance,
			           (stilb_debug_style){.rgba = 0xffffffff, .on_top = cases[i].on_top});
			frame(&w, &p);
			/* The square is 0.2 of the height to each side: columns 33.5 +- 4.1. */
			for (uint32_t x = 0; x < W; x++) {
				float share = 1.0f;
				if (cases[i].hidden && x >= 30 && x <= 36)
					share = 0.0f;
				else if (cases[i].hidden && (x == 29 || x == 37))
					share = samples == 1 ? 0.0f : p.pixels[20][x][0]; /* the square covers 0.6 of it */
				assert_near(&p, x, 20, 0, share, 1e-3f);
			}
			if (cases[i].hidden && samples == 4)
				for (uint32_t x = 29; x <= 37; x += 8) {
					float quarters = roundf(4.0f * p.pixels[20][x][0]);
					assert_true(quarters >= 1.0f && quarters <= 2.0f);
					assert_near(&p, x, 20, 0, 0.25f * quarters, 1e-3f);
				}
		}
		world_close(&w);
	}
}

/* A line that goes through the camera's near plane is drawn up to there, one behind it not at all, and one to the far
 * plane ends there. */
static void planes_cut_lines(void **state)
{
	(void)state;
	world w = world_open(device_desc(1, STILB_RENDER_OUTPUT_LINEAR));
	picture p, cut;
	stilb_debug_style style = {.rgba = 0xffffffff, .width = 3.0f, .on_top = true};
	static const struct {
		float from[3], to[3], end[3]; /* end: where it should be cut, between from and to */
	} cases[] = {
		{{0.3f, 0.2f, -4.0f}, {-0.1f, 0.0f, 4.0f}, {0.105f, 0.1025f, -0.1f}},
		{{0.3f, 0.2f, -4.0f}, {0.4f, -3.0f, 1.0f}, {0.378f, -2.296f, -0.1f}},
		{{3.0f, 0.2f, -80.0f}, {3.0f, 20.2f, -120.0f}, {3.0f, 10.2f, -100.0f}},
	};
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		for (int turn = 0; turn < 2; turn++) {
			stilb_debug_line(w.debug, turn ? cases[i].to : cases[i].from, turn ? cases[i].from : cases[i].to, style);
			frame(&w, &p);
			stilb_debug_line(w.debug, cases[i].from, cases[i].end, style);
			frame(&w, &cut);
			float sum = 0.0f;
			for (uint32_t y = 0; y < H; y++)
				for (uint32_t x = 0; x < W; x++) {
					assert_near(&p, x, y, 0, cut.pixels[y][x][0], 0.02f);
					sum += p.pixels[y][x][0];
				}
			assert_true(sum > 5.0f);
		}
	}
	/* Lines that go on for ten thousand kilometres are as exact as short ones. */
	for (int i = 0; i < 12; i++) {
		float angle = 0.5236f * (float)i + 0.2f, x = cosf(angle), y = sinf(angle), start[3] = {0.01f, 0.02f, -2.0f};
		stilb_debug_line(w.debug, start, (float[3]){0.01f + 1e7f * x, 0.02f + 1e7f * y, -2.0f}, style);
		frame(&w, &p);
		stilb_debug_line(w.debug, start, (float[3]){0.01f + 8.0f * x, 0.02f + 8.0f * y, -2.0f}, style);
		frame(&w, &cut);
		for (uint32_t n = 0; n < W * H; n++)
			assert_near(&p, n % W, n / W, 0, cut.pixels[n / W][n % W][0], 4e-3f);
	}
	static const float behind[2][3] = {{-1, 0, 1}, {1, 0, 0.5f}}, at[3] = {0, 0, 0}, nearer[3] = {0, 0, -0.05f};
	static const float far[2][3] = {{-50, 1, -101}, {50, 1, -101}};
	stilb_debug_line(w.debug, behind[0], behind[1], style);
	stilb_debug_line(w.debug, far[0], far[1], style);
	stilb_debug_line(w.debug, at, at, style);
	stilb_debug_line(w.debug, nearer, at, style);
	stilb_debug_text(w.debug, behind[0], style, "behind");
	stilb_debug_text(w.debug, nearer, style, "too near");
	frame(&w, &p);
	for (uint32_t i = 0; i < W * H * 3; i++)
		assert_true((&p.pixels[0][0][0])[i] == 0.0f);
	world_close(&w);
}

/* A sphere in front: the circle that faces the camera has its radius; the others reach as far as a sphere's outline. */
static void spheres_have_their_radius(void **state)
{
	(void)state;
	world w = world_open(device_desc(1, STILB_RENDER_OUTPUT_LINEAR));
	picture p;
	static const float center[3] = {0, 0, -4};
	float radius = 2.0f, pixels = radius / 4.0f * 0.5f * (float)H; /* 10.25 */
	stilb_debug_sphere(w.debug, center, radius, (stilb_debug_style){.rgba = 0xffffffff, .width = 3.0f, .on_top = true});
	frame(&w, &p);
	uint32_t on = 0;
	for (uint32_t y = 0; y < H; y++)
		for (uint32_t x = 0; x < W; x++) {
			float right = (float)x + 0.5f - 0.5f * (float)W, down = (float)y + 0.5f - 0.5f * (float)H;
			float off = fabsf(hypotf(right, down) - pixels);
			if (fabsf(right) < 3.0f || fabsf(down) < 3.0f)
				continue; /* the other two circles */
			if (off < 0.9f)
				assert_near(&p, x, y, 0, 1.0f, 1e-3f);
			if (off > 2.1f)
				assert_near(&p, x, y, 0, 0.0f, 0.0f);
			on += off < 0.9f;
		}
	assert_true(on > 50);
	/* The two circles through the poles reach r / sqrt(d^2 - r^2), and half their width. */
	float reach = radius / sqrtf(16.0f - radius * radius) * 0.5f * (float)H; /* 11.84 */
	float light = 0.0f;
	for (uint32_t y = 0; y < H / 2 - 3; y++)
		light += p.pixels[y][W / 2][0];
	assert_true(fabsf(light - (reach + 1.5f - 3.5f)) < 0.25f);
	world_close(&w);
}

/* Letters are the pixels of the glyphs, in the text's colour, at any distance; hidden as a whole by their place. */
static void letters_are_glyphs(void **state)
{
	(void)state;
	ui_fonts fonts;
	assert_int_equal(ui_fonts_init(&fonts, 1.0f), STILB_OK);
	const stilb_ui_font *font = &fonts.fonts[STILB_UI_TEXT_NORMAL];
	for (uint32_t samples = 1; samples <= 4; samples += 3) {
		world w = world_open(device_desc(samples, STILB_RENDER_OUTPUT_LINEAR));
		static const struct {
			float distance;
			bool on_top, hidden;
		} cases[] = {{2.0f, false, false}, {40.0f, false, true}, {40.0f, true, false}, {4.999f, false, false}};
		for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
			picture p;
			static float want[H][W];
			float at[3], pen = -0.5f * stilb_ui_text_width(font, "Stilb");
			memset(want, 0, sizeof want);
			for (const char *c = "Stilb"; *c; c++) {
				uint32_t index = ui_glyph_index((uint32_t)*c);
				float quarters = floorf(pen * 4.0f + 0.5f), whole = floorf(quarters / 4.0f);
				const ui_glyph *glyph = &font->glyphs[index][(int)(quarters - 4.0f * whole)];
				for (int y = 0; y < glyph->height && !cases[i].hidden; y++)
					for (int x = 0; x < glyph->width; x++) {
						float *to = &want[20 + glyph->top + y][33 + (int)whole + glyph->left + x];
						float share = (float)fonts.coverage[(glyph->y + y) * (int)fonts.width + glyph->x + x] / 255.0f;
						*to += (1.0f - *to) * share;
					}
				pen += font->advance[index];
			}
			world_place(33.4f, 20.6f, cases[i].distance, at);
			stilb_debug_text(w.debug, at, (stilb_debug_style){.rgba = 0xffffffff, .on_top = cases[i].on_top}, "%s%s",
			                 "Sti", "lb");
			frame(&w, &p);
			for (uint32_t y = 0; y < H; y++)
				for (uint32_t x = 0; x < W; x++)
					assert_near(&p, x, y, 1, want[y][x], 2e-3f);
		}
		world_close(&w);
	}
	ui_fonts_finish(&fonts);
}

/* Dark letters have a bright halo, one pixel wide, and stay dark. */
static void letters_stand_out(void **state)
{
	(void)state;
	world w = world_open(device_desc(1, STILB_RENDER_OUTPUT_LINEAR));
	picture p;
	float at[3];
	world_place(33.4f, 20.6f, 2.0f, at);
	stilb_debug_text(w.debug, at, (stilb_debug_style){.rgba = 0x000000ff}, "|");
	frame(&w, &p);
	uint32_t dark = 0, bright = 0;
	for (uint32_t x = 28; x < 40; x++) {
		bright += p.pixels[16][x][0] > 0.3f && p.pixels[16][x][0] < 0.71f;
		dark += p.pixels[16][x][0] < 0.2f;
	}
	assert_true(bright >= 2 && bright <= 3 && dark >= 9);
	world_close(&w);
}

/* On a floor that is seen at a grazing angle, 2 m above it and up to 28 m away, lines are seen; a metre below it
 * they are not. */
static void lines_lie_on_floors(void **state)
{
	(void)state;
	for (uint32_t samples = 1; samples <= 4; samples += 3) {
		world w = world_open(device_desc(samples, STILB_RENDER_OUTPUT_LINEAR));
		picture p;
		/* The square becomes a floor of 100 m, 2 m below the camera. */
		stilb_mat4 floor = {.m = {50, 0, 0, 0, 0, 0, -50, 0, 0, 50, 0, 0, 0, -2, -51, 1}};
		assert_int_equal(stilb_scene_set_part_transforms(w.scene, 0, &floor), STILB_OK);
		for (int below = 0; below < 2; below++) {
			float y = below ? -3.0f : -2.0f;
			for (int i = 0; i < 6; i++) {
				float z = -3.0f - 5.0f * (float)i, x = 0.2f + 1.7f * (float)i;
				stilb_debug_line(w.debug, (float[3]){-60, y, z}, (float[3]){60, y, z - 0.01f},
				                 (stilb_debug_style){.rgba = 0xff0000ff});
				stilb_debug_line(w.debug, (float[3]){x, y, -3}, (float[3]){x, y, -28},
				                 (stilb_debug_style){.rgba = 0xff0000ff, .width = 3.0f});
			}
			frame(&w, &p);
			picture top;
			for (int i = 0; i < 6; i++) {
				float z = -3.0f - 5.0f * (float)i, x = 0.2f + 1.7f * (float)i;
				stilb_debug_line(w.debug, (float[3]){-60, y, z}, (float[3]){60, y, z - 0.01f},
				                 (stilb_debug_style){.rgba = 0xff0000ff, .on_top = true});
				stilb_debug_line(w.debug, (float[3]){x, y, -3}, (float[3]){x, y, -28},
				                 (stilb_debug_style){.rgba = 0xff0000ff, .width = 3.0f, .on_top = true});
			}
			frame(&w, &top);
			double seen = 0.0, all = 0.0;
			for (uint32_t i = 0; i < W * H; i++) {
				seen += (double)(&p.pixels[0][0][0])[3 * i];
				all += (double)(&top.pixels[0][0][0])[3 * i];
			}
			assert_true(all > 100.0);
			/* Where two triangles meet, the software device leaves single samples open, with four a pixel. */
			if (below ? seen > 0.01 * all : seen < 0.97 * all)
				fail_msg("%g of %g is seen", seen, all);
		}
		world_close(&w);
	}
}

/* Each camera shows what is drawn in its own part of the picture, which hides that of those below it, but for its
 * border; in a scene drawn coarser, too. */
static void cameras_show_it_each(void **state)
{
	(void)state;
	for (int coarse = 0; coarse < 2; coarse++) {
		stilb_engine_desc desc = device_desc(coarse ? 4 : 1, STILB_RENDER_OUTPUT_LINEAR);
		desc.scale = coarse ? 0.5f : 1.0f;
		world w = world_open(desc);
		picture p;
		/* Columns 34..66 and rows 0..20 of the picture are another camera's, turned by a half: it looks along +Z. */
		stilb_engine_camera back = {.name = "back",
		                            .camera = w.scene->camera,
		                            .place = {33.6f / (float)W, 0.0f, 1.0f, 20.6f / (float)H},
		                            .border = 2};
		back.camera.yaw = 3.14159265f;
		stilb_engine_set_cameras(w.engine, &back, 1);
		/* In front, hidden in the middle by the square; behind, at a quarter of its height. */
		world_line(&w, -50.0f, 20.5f, 200.0f, 20.5f, 6.0f, (stilb_debug_style){.rgba = 0xff0000ff});
		world_line(&w, -50.0f, 5.5f, 200.0f, 5.5f, 2.0f, (stilb_debug_style){.rgba = 0x00ff00ff});
		stilb_debug_line(w.debug, (float[3]){-30, 1, 2}, (float[3]){30, 1, 2}, (stilb_debug_style){.rgba = 0x0000ffff});
		frame(&w, &p);
		/* Its row: 21 rows high, 1 m of 2 above the middle. */
		float row = 10.5f * (1.0f - 0.5f);
		for (uint32_t x = 0; x < W; x++) {
			bool other = x >= 34, inner = x >= 36 && x < W - 2;
			assert_near(&p, x, 5, 1, other ? 0.0f : 1.0f, 2e-3f);
			float blue = p.pixels[4][x][2] + p.pixels[5][x][2] + p.pixels[6][x][2];
			assert_true(fabsf(blue - (inner ? 1.0f : 0.0f)) < 5e-3f);
			if (inner)
				assert_true(p.pixels[(int)row][x][2] > 0.4f);
			if (x < 28)
				assert_near(&p, x, 20, 0, 1.0f, 2e-3f);
			if (x > 31)
				assert_near(&p, x, 20, 0, 0.0f, 2e-3f);
		}
		world_close(&w);
	}
}

/* A picture of the program's beside a still scene, which is not drawn again: what was drawn into it stays. */
static void still_scenes_keep_it(void **state)
{
	(void)state;
	static float light[H][W][3];
	world w = world_open(device_desc(1, STILB_RENDER_OUTPUT_LINEAR));
	picture p;
	float from = 0.5f;
	stilb_engine_shown shown = {.radiance = &light[0][0][0], .width = W, .height = H, .from = &from, .still = true};
	for (int f = 0; f < 5; f++) {
		if (f == 2)
			assert_int_equal(stilb_engine_show(w.engine, &shown), STILB_OK);
		if (f == 4) /* smaller than what was gathered last */
			assert_int_equal(stilb_engine_resize(w.engine, W - 20, H - 10), STILB_OK);
		world_line(&w, -9.0f, 5.5f, 99.0f, 5.5f, 3.0f, (stilb_debug_style){.rgba = 0xffffffff});
		stilb_engine_report report;
		if (stilb_engine_frame(w.engine, &report) != STILB_OK)
			fail_msg("%s", stilb_error_message());
		if (f == 4)
			break;
		read_picture(&w, &p);
		for (uint32_t x = 0; x < W; x++)
			assert_near(&p, x, 5, 0, f < 2 || x < W / 2 ? 1.0f : 0.0f, x == W / 2 ? 1.0f : 2e-3f);
	}
	world_close(&w);
}

/* 22,000 dots, eight to a pixel, each layer nearer and in another colour: the nearest is seen. More than one command's,
 * in any order. */
static void near_lies_over_far(void **state)
{
	(void)state;
	enum { LAYERS = 8, COUNT = LAYERS * W * H };
	for (int top = 0; top < 2; top++) {
		world w = world_open(device_desc(1, STILB_RENDER_OUTPUT_DISPLAY));
		picture p;
		for (uint32_t i = 0; i < COUNT; i++) {
			uint32_t n = (uint32_t)((uint64_t)i * 7919 % COUNT), layer = n / (W * H), pixel = n % (W * H);
			float at[3];
			world_place((float)(pixel % W) + 0.5f, (float)(pixel / W) + 0.5f, 1.0f + 0.1f * (float)layer, at);
			stilb_debug_line(w.debug, at, at,
			                 (stilb_debug_style){.rgba = (layer << 28 | pixel << 8) | 0xff, .on_top = top});
		}
		frame(&w, &p);
		for (uint32_t pixel = 0; pixel < W * H; pixel++)
			for (int c = 0; c < 3; c++)
				assert_near(&p, pixel % W, pixel / W, c, (float)(pixel >> (16 - 8 * c) & 0xff), 0.0f);
		world_close(&w);
	}
}

/* ---- threads ----------------------------------------------------------------------------------------------------- */

typedef struct drawer {
	stilb_debug *debug;
	uint32_t number, count;
	pthread_t thread;
} drawer;

/* Draws every count-th thing of a crowd that overlaps, some of it transparent. */
static void *draw_some(void *user)
{
	const drawer *d = user;
	for (uint32_t i = d->number; i < 1200; i += d->count) {
		float at[3], to[3];
		for (uint32_t a = 0; a < 3; a++) {
			at[a] = 6.0f * (stilb_random_float(1, 6 * i + a) - 0.5f) - (a == 2 ? 4.5f : 0.0f);
			to[a] = 6.0f * (stilb_random_float(1, 6 * i + 3 + a) - 0.5f) - (a == 2 ? 4.5f : 0.0f);
		}
		if (i % 4 == 0)
			at[2] = to[2] = -3.0f;
		stilb_debug_style style = {.rgba = (uint32_t)stilb_random_u64(2, i),
		                           .width = 0.5f + 3.0f * stilb_random_float(3, i),
		                           .on_top = i % 3 == 0};
		stilb_debug_line(d->debug, at, to, style);
		if (i % 50 == 0)
			stilb_debug_text(d->debug, at, style, "text %u", i);
	}
	return NULL;
}

static void threads_do_not_matter(void **state)
{
	(void)state;
	static picture one, many;
	for (uint32_t samples = 1; samples <= 4; samples += 3) {
		world w = world_open(device_desc(samples, STILB_RENDER_OUTPUT_DISPLAY));
		for (uint32_t count = 1; count <= 8; count++) {
			drawer drawers[8];
			for (uint32_t t = 0; t < count; t++) {
				drawers[t] = (drawer){.debug = w.debug, .number = count - 1 - t, .count = count};
				assert_int_equal(pthread_create(&drawers[t].thread, NULL, draw_some, &drawers[t]), 0);
			}
			for (uint32_t t = 0; t < count; t++)
				pthread_join(drawers[t].thread, NULL);
			frame(&w, &many);
			if (count == 1)
				one = many;
			assert_memory_equal(&one, &many, sizeof one);
		}
		float sum = 0.0f;
		for (uint32_t i = 0; i < W * H * 3; i++)
			sum += (&one.pixels[0][0][0])[i];
		assert_true(sum > 20.0f * W * H);
		world_close(&w);
	}
}

/* Frames of other sizes, and 100,000 lines after a few: memory grows while frames are in flight. */
static void memory_grows(void **state)
{
	(void)state;
	world w = world_open(device_desc(4, STILB_RENDER_OUTPUT_DISPLAY));
	picture p;
	for (uint32_t count = 1; count <= 100000; count *= 10) {
		for (uint32_t i = 0; i < count; i++)
			world_line(&w, 10.0f, 5.5f, 12.0f, 5.5f, 2.0f, (stilb_debug_style){.rgba = 0xffffffff});
		frame(&w, &p);
		assert_near(&p, 11, 5, 0, 255.0f, 0.0f);
		assert_near(&p, 11, 7, 0, 0.0f, 0.0f);
	}
	for (uint32_t side = 1; side < 40; side += 19) {
		stilb_engine_report report;
		stilb_image image;
		assert_int_equal(stilb_engine_resize(w.engine, side, 2 * side), STILB_OK);
		static const float left[3] = {-9, 0, -3}, right[3] = {9, 0, -3};
		stilb_debug_line(w.debug, left, right, (stilb_debug_style){.rgba = 0xff0000ff, .width = 2.0f});
		assert_int_equal(stilb_engine_frame(w.engine, &report), STILB_OK);
		assert_int_equal(stilb_render_read_image(w.engine->render, &image), STILB_OK);
		for (uint32_t x = 0; x < side; x++)
			assert_true(((const uint8_t *)image.pixels)[(side * side + x) * 3] == 255);
		stilb_image_finish(&image);
	}
	world_close(&w);
}

int main(void)
{
	stilb_gpu_listed listed;
	uint32_t count;
	if (stilb_gpu_list(&listed, 1, &count) != STILB_OK || count == 0) {
		printf("skipped: no Vulkan driver (apt install mesa-vulkan-drivers)\n");
		return 77;
	}
	struct CMUnitTest tests[] = {
		cmocka_unit_test(lines_have_their_width),
		cmocka_unit_test(edges_are_smooth),
		cmocka_unit_test(ends_are_round),
		cmocka_unit_test(diagonals_have_their_area),
		cmocka_unit_test(the_scene_hides_lines),
		cmocka_unit_test(planes_cut_lines),
		cmocka_unit_test(spheres_have_their_radius),
		cmocka_unit_test(letters_are_glyphs),
		cmocka_unit_test(letters_stand_out),
		cmocka_unit_test(cameras_show_it_each),
		cmocka_unit_test(still_scenes_keep_it),
		cmocka_unit_test(lines_lie_on_floors),
		cmocka_unit_test(near_lies_over_far),
		cmocka_unit_test(threads_do_not_matter),
		cmocka_unit_test(memory_grows),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
