/* Dither before 8 bits: flat colours keep their mean, by the triangle with the same noise wherever between two codes
 * they lie; black and white stay; and pixels alone decide. */
#include "post_stage.h"

#include "shading/shade_srgb.h"
#include "shading/shade_tonemap.h"

enum { SIDE = 128, PIXELS = SIDE * SIDE };

typedef struct spread {
	double mean, variance; /* of codes */
	int least, most;
} spread;

static float light[3 * PIXELS];
static uint8_t first[3 * PIXELS];

/* A frame of one grey, whose code before it is rounded is `code`; returns that of the half floats. */
static double frame_of(post_stage *s, double code, stilb_render_dither dither, stilb_image *image)
{
	float value = stilb_image_half_to_float(stilb_image_half_from_float(shade_srgb_to_linear((float)(code / 255.0))));
	for (uint32_t i = 0; i < 3 * PIXELS; i++)
		light[i] = value;
	stage_light(s, light);
	stilb_render_view view = stage_view();
	view.tone = SHADE_TONE_NONE;
	view.dither = dither;
	stage_draw_view(s, view);
	assert_int_equal(stilb_render_read_image(s->render, image), STILB_OK);
	assert_int_equal(image->channels, 4);
	return 255.0 * (double)shade_srgb_from_linear(value);
}

static spread spread_of(const stilb_image *image)
{
	const uint8_t *codes = image->pixels;
	spread is = {.least = 255};
	double squares = 0.0;
	for (uint32_t p = 0; p < PIXELS; p++) {
		int code = codes[4 * p];
		assert_true(codes[4 * p + 1] == code && codes[4 * p + 2] == code); /* greys stay grey */
		is.least = code < is.least ? code : is.least;
		is.most = code > is.most ? code : is.most;
		is.mean += code / (double)PIXELS;
		squares += (double)code * code / PIXELS;
	}
	is.variance = squares - is.mean * is.mean;
	return is;
}

static void colours_keep_their_mean(void **state)
{
	(void)state;
	post_stage s;
	stage_open_for(&s, STILB_RENDER_DEVICE_VULKAN, STILB_RENDER_OUTPUT_DISPLAY, SIDE, SIDE);
	for (int d = 0; d < STILB_RENDER_DITHERS; d++)
		for (double want = 0.0; want <= 255.0; want += 3.1875) {
			stilb_image image = {0};
			double code = frame_of(&s, want, (stilb_render_dither)d, &image);
			spread is = spread_of(&image);
			stilb_image_finish(&image);
			/* The device's encoding of sRGB is off by a tenth of a code. */
			double off = d == STILB_RENDER_DITHER_OFF ? 0.7 : d == STILB_RENDER_DITHER_ORDERED ? 0.2 : 0.15;
			bool middle = code > 1.0 && code < 254.0;
			if (fabs(is.mean - code) > off)
				fail_msg("dither %d: code %.3f is %.3f in the mean", d, code, is.mean);
			assert_true(is.most - is.least <= d);
			assert_true(is.most <= code + 1.7 && is.least >= code - 1.7);
			/* A triangle as wide as two codes leaves a quarter of a code squared, whatever the code. */
			if (d == STILB_RENDER_DITHER_TRIANGULAR && middle && fabs(is.variance - 0.25) > 0.05)
				fail_msg("code %.3f has the variance %.3f", code, is.variance);
		}
	stage_close(&s);
}

static void black_and_white_stay(void **state)
{
	(void)state;
	post_stage s;
	stage_open_for(&s, STILB_RENDER_DEVICE_VULKAN, STILB_RENDER_OUTPUT_DISPLAY, SIDE, SIDE);
	for (int d = 0; d < STILB_RENDER_DITHERS; d++)
		for (int white = 0; white < 2; white++) {
			stilb_image image = {0};
			frame_of(&s, 255.0 * white, (stilb_render_dither)d, &image);
			spread is = spread_of(&image);
			stilb_image_finish(&image);
			assert_true(is.least == 255 * white && is.most == 255 * white);
		}
	stage_close(&s);
}

/* The same pixel has the same code in each frame, in pictures of any size; and patterns do not repeat. */
static void pixels_alone_decide(void **state)
{
	(void)state;
	stilb_image image = {0};
	post_stage s;
	stage_open_for(&s, STILB_RENDER_DEVICE_VULKAN, STILB_RENDER_OUTPUT_DISPLAY, SIDE, SIDE);
	for (int frame = 0; frame < 3; frame++) {
		frame_of(&s, 100.5, STILB_RENDER_DITHER_TRIANGULAR, &image);
		const uint8_t *codes = image.pixels;
		for (uint32_t i = 0; i < PIXELS; i++) {
			if (frame == 0)
				first[i] = codes[4 * i];
			assert_int_equal(first[i], codes[4 * i]);
		}
		stilb_image_finish(&image);
	}
	for (uint32_t step = 1; step <= 64; step *= 2) { /* moved by a tile's side it would be the same everywhere */
		uint32_t same = 0, count = 0;
		for (uint32_t y = 0; y < SIDE; y++)
			for (uint32_t x = step; x < SIDE; x++, count++)
				same += first[y * SIDE + x] == first[y * SIDE + x - step];
		assert_true(same < 0.9 * count);
	}
	stage_close(&s);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(colours_keep_their_mean),
		cmocka_unit_test(black_and_white_stay),
		cmocka_unit_test(pixels_alone_decide),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
