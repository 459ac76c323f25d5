/* Tone maps of pictures (shade_tonemap.h): curves against their formulas as printed, in
 * double; their inverses; limits; and the choice by number. */

#include "shading/shade_tonemap.h"

#include "support/shade_proof.h"

#include <string.h>

static double least_of(const double c[3])
{
	return fmin(c[0], fmin(c[1], c[2]));
}

static double most_of(const double c[3])
{
	return fmax(c[0], fmax(c[1], c[2]));
}

/* Khronos' specification, step by step. */
static void neutral_printed(stilb_vec3 color, double out[3])
{
	double start = 0.8 - 0.04, desaturation = 0.15;
	double in[3] = {(double)color[0], (double)color[1], (double)color[2]};
	double x = least_of(in), offset = x < 0.08 ? x - 6.25 * x * x : 0.04;
	for (int c = 0; c < 3; c++)
		out[c] = in[c] - offset;
	double peak = most_of(out);
	if (peak < start)
		return;
	double d = 1.0 - start, new_peak = 1.0 - d * d / (peak + d - start);
	double g = 1.0 - 1.0 / (desaturation * (peak - new_peak) + 1.0);
	for (int c = 0; c < 3; c++)
		out[c] = out[c] * new_peak / peak * (1.0 - g) + new_peak * g;
}

static double filmic_printed(double x)
{
	return fmin(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 1.0);
}

/* The steps of the specification backwards. color: shown, its largest channel below 1. */
static void neutral_inverse_printed(stilb_vec3 color, double out[3])
{
	double start = 0.8 - 0.04, desaturation = 0.15, d = 1.0 - start;
	double in[3] = {(double)color[0], (double)color[1], (double)color[2]};
	double new_peak = most_of(in), peak = d * d / (1.0 - new_peak) - d + start;
	double g = 1.0 - 1.0 / (desaturation * (peak - new_peak) + 1.0);
	for (int c = 0; c < 3; c++)
		out[c] = new_peak < start ? in[c] : (in[c] - new_peak * g) / (1.0 - g) * peak / new_peak;
	double least = fmax(least_of(out), 0.0), offset = least < 0.04 ? sqrt(least / 6.25) - least : 0.04;
	for (int c = 0; c < 3; c++)
		out[c] = fmax(out[c], 0.0) + offset;
}

/* The positive root x of filmic_printed(x) = y. */
static double filmic_inverse_printed(double y)
{
	double a = 2.51 - 2.43 * y, b = 0.03 - 0.59 * y, c = -0.14 * y;
	return (-b + sqrt(b * b - 4.0 * a * c)) / (2.0 * a);
}

/* Hable's operator as he printed it: twice the exposure, white at 11.2. */
static double hable_of(double x)
{
	double a = 0.15, b = 0.50, c = 0.10, d = 0.20, e = 0.02, f = 0.30;
	return (x * (a * x + c * b) + d * e) / (x * (a * x + b) + d * f) - e / f;
}

static double hable_printed(double x)
{
	return fmin(hable_of(2.0 * x) / hable_of(11.2), 1.0);
}

/* A line of slope 1.25 through (0.18, 0.18) from 0.09 to 0.45, continued by powers with its slope. */
static double piecewise_printed(double x)
{
	double slope = 1.25, toe = 0.18 - slope * 0.09, shoulder = 0.18 + slope * 0.27, power = 1.5;
	if (x < 0.09)
		return toe * pow(x / 0.09, slope * 0.09 / toe);
	if (x < 0.45)
		return 0.18 + slope * (x - 0.18);
	return 1.0 - (1.0 - shoulder) * pow(1.0 + slope * (x - 0.45) / (power * (1.0 - shoulder)), -power);
}

static double luminance_of(const double c[3])
{
	return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
}

/* Scaled to the knee's curve of the luminance, and as near to grey as it needs to fit. */
static void luminance_printed(stilb_vec3 color, double out[3])
{
	double in[3] = {(double)color[0], (double)color[1], (double)color[2]};
	double y = luminance_of(in), shown = y <= 0.6 ? y : (0.36 - y) / (1.2 - 1.0 - y);
	for (int c = 0; c < 3; c++)
		out[c] = in[c] * (y > 0.0 ? shown / y : 1.0);
	double most = most_of(out), kept = most > 1.0 ? (1.0 - shown) / (most - shown) : 1.0;
	for (int c = 0; c < 3; c++)
		out[c] = shown + kept * (out[c] - shown);
}

static stilb_vec3 random_color(shade_proof_random *random)
{
	float height = shade_proof_log_range(random, 0.01f, 1e5f);
	return shade_proof_random_color(random, 1.0f) * height;
}

static void neutral_is_the_printed_one(void **state)
{
	(void)state;
	shade_proof_random random = {11, 0};
	for (int i = 0; i < 20000; i++) {
		stilb_vec3 color = random_color(&random), got = shade_neutral(color);
		double want[3];
		neutral_printed(color, want);
		SHADE_PROOF_NEAR3(got, want[0], want[1], want[2], 2e-6, 3e-7);
	}
}

static void filmic_is_the_printed_one(void **state)
{
	(void)state;
	shade_proof_random random = {12, 0};
	for (int i = 0; i < 20000; i++) {
		stilb_vec3 color = random_color(&random), got = shade_filmic(color);
		SHADE_PROOF_NEAR3(got, filmic_printed((double)color[0]), filmic_printed((double)color[1]),
		                  filmic_printed((double)color[2]), 2e-6, 1e-9);
	}
	SHADE_PROOF_NEAR(shade_filmic_curve_inverse(1.0f), 7.2420, 2e-4, 0.0);
}

static void hable_is_the_printed_one(void **state)
{
	(void)state;
	shade_proof_random random = {21, 0};
	for (int i = 0; i < 20000; i++) {
		stilb_vec3 color = random_color(&random), got = shade_hable(color);
		SHADE_PROOF_NEAR3(got, hable_printed((double)color[0]), hable_printed((double)color[1]),
		                  hable_printed((double)color[2]), 2e-6, 1e-9);
		float shown = shade_proof_random_color(&random, 1.0f)[0];
		SHADE_PROOF_NEAR(shade_hable_curve(shade_hable_curve_inverse(shown)), (double)shown, 4e-6, 1e-9);
	}
	SHADE_PROOF_NEAR(shade_hable_curve_inverse(1.0f), 5.6, 1e-5, 0.0);
	SHADE_PROOF_NEAR(shade_hable_curve(5.5f), hable_printed(5.5), 2e-6, 0.0);
	assert_true(shade_hable_curve(5.5f) < 1.0f && shade_hable_curve(5.7f) == 1.0f);
}

static void piecewise_is_the_printed_one(void **state)
{
	(void)state;
	shade_proof_random random = {22, 0};
	for (int i = 0; i < 20000; i++) {
		stilb_vec3 color = random_color(&random), got = shade_piecewise(color);
		SHADE_PROOF_NEAR3(got, piecewise_printed((double)color[0]), piecewise_printed((double)color[1]),
		                  piecewise_printed((double)color[2]), 2e-6, 1e-9);
		float x = shade_proof_log_range(&random, 1e-4f, 8.0f);
		SHADE_PROOF_NEAR(shade_piecewise_curve_inverse((float)piecewise_printed((double)x)), (double)x, 2e-5, 0.0);
	}
	assert_true(shade_piecewise_curve(0.18f) == 0.18f);
	static const double joints[] = {0.09, 0.45};
	for (int j = 0; j < 2; j++) /* values and slopes go on */
		for (double d = -1e-3; d < 2e-3; d += 2e-3)
			SHADE_PROOF_NEAR(shade_piecewise_curve((float)(joints[j] + d)),
			                 (double)shade_piecewise_curve((float)joints[j]) + 1.25 * d, 0.0, 1e-5);
}

static void luminance_is_the_printed_one(void **state)
{
	(void)state;
	shade_proof_random random = {23, 0};
	for (int i = 0; i < 20000; i++) {
		stilb_vec3 color = random_color(&random), got = shade_shown_by_luminance(color);
		double want[3], shown[3] = {(double)got[0], (double)got[1], (double)got[2]};
		luminance_printed(color, want);
		SHADE_PROOF_NEAR3(got, want[0], want[1], want[2], 2e-6, 2e-6);
		SHADE_PROOF_NEAR((float)luminance_of(shown), luminance_of(want), 1e-6, 1e-7);
	}
	/* A blue that would be shown as 8.3 becomes as bright a grey's neighbour, and is not cut to a darker blue. */
	stilb_vec3 blue = shade_shown_by_luminance(stilb_vec3_make(0.0f, 0.0f, 8.310249f));
	SHADE_PROOF_NEAR3(blue, 0.5688726, 0.5688726, 1.0, 1e-5, 0.0);
}

/* Lights of the same hue, half a stop apart, up to a thousand times white: none is shown as the one before it. */
static void some_never_cut_off(void **state)
{
	(void)state;
	static const int tones[] = {SHADE_TONE_KNEE, SHADE_TONE_NEUTRAL, SHADE_TONE_LUMINANCE, SHADE_TONE_PIECEWISE};
	shade_proof_random random = {24, 0};
	for (size_t t = 0; t < sizeof tones / sizeof *tones; t++)
		for (int i = 0; i < 500; i++) {
			stilb_vec3 color = shade_proof_random_color(&random, 1.0f) + 0.01f;
			float last = 0.0f;
			for (float height = 0.01f; height < 1000.0f; height *= 1.41421356f) {
				float bright = shade_luminance(shade_tone(tones[t], color * height));
				assert_true(bright > last);
				last = bright;
			}
		}
}

static void inverses_are_the_printed_ones(void **state)
{
	(void)state;
	shade_proof_random random = {17, 0};
	for (int i = 0; i < 20000; i++) {
		stilb_vec3 shown = shade_proof_random_color(&random, 0.9f) + 0.05f, got = shade_neutral_inverse(shown);
		double want[3];
		neutral_inverse_printed(shown, want);
		SHADE_PROOF_NEAR3(got, want[0], want[1], want[2], 5e-6, 3e-5);
		got = shade_filmic_inverse(shown);
		SHADE_PROOF_NEAR3(got, filmic_inverse_printed((double)shown[0]), filmic_inverse_printed((double)shown[1]),
		                  filmic_inverse_printed((double)shown[2]), 5e-6, 0.0);
	}
	assert_true(shade_filmic_curve_inverse(0.0f) == 0.0f);
	/* Near white colours, whose least channel is far above the parabola: no large errors hide a small one. */
	for (int i = 0; i < 20000; i++) {
		stilb_vec3 shown = shade_proof_random_color(&random, 0.13f) + 0.85f, got = shade_neutral_inverse(shown);
		double want[3];
		neutral_inverse_printed(shown, want);
		SHADE_PROOF_NEAR3(got, want[0], want[1], want[2], 2e-5, 0.0);
	}
}

/* What the neutral curve is for: a surface whose base colour is below 0.76, which mirrors 4 % of white light besides,
 * is shown in its base colour, and greys stay grey. */
static void neutral_keeps_base_colors(void **state)
{
	(void)state;
	shade_proof_random random = {13, 0};
	for (int i = 0; i < 2000; i++) {
		stilb_vec3 base = shade_proof_random_color(&random, 0.70f) + 0.05f, got = shade_neutral(base + 0.04f);
		SHADE_PROOF_NEAR3(got, base[0], base[1], base[2], 0.0, 1e-7);
		float grey = shade_proof_log_range(&random, 1e-4f, 1e6f);
		got = shade_neutral(stilb_vec3_make(grey, grey, grey));
		assert_true(got[0] == got[1] && got[1] == got[2]);
	}
}

/* Each tone map: in [0, 1], never falling along a ray of brightness, 0 without light, 1 at the end of floats. */
static void all_end_in_the_display(void **state)
{
	(void)state;
	shade_proof_random random = {14, 0};
	for (int tone = 0; tone < SHADE_TONE_COUNT; tone++)
		for (int i = 0; i < 200; i++) {
			stilb_vec3 color = shade_proof_random_color(&random, 1.0f);
			float last = 0.0f;
			for (float height = 1e-3f; height < 1e9f; height *= 1.5f) {
				stilb_vec3 got = shade_tone(tone, color * height);
				float largest = shade_largest(got);
				for (int c = 0; c < 3; c++)
					assert_true(got[c] >= 0.0f && got[c] <= 1.0f);
				assert_true(largest >= last * (1.0f - 3e-7f));
				last = largest;
			}
			stilb_vec3 end = shade_tone(tone, stilb_vec3_make(INFINITY, 1e30f, 3e38f));
			for (int c = 0; c < 3; c++)
				assert_true(end[c] >= 0.999f && end[c] <= 1.0f);
			stilb_vec3 dark = shade_tone(tone, stilb_vec3_make(0.0f, 0.0f, 0.0f));
			assert_true(shade_largest(dark) == 0.0f);
		}
}

static void all_have_inverses(void **state)
{
	(void)state;
	shade_proof_random random = {15, 0};
	for (int tone = 0; tone < SHADE_TONE_COUNT; tone++)
		for (int i = 0; i < 20000; i++) {
			float most = tone == SHADE_TONE_NONE ? 1.0f : 4.0f;
			stilb_vec3 color = shade_proof_random_color(&random, most);
			stilb_vec3 shown = shade_tone(tone, color), back = shade_tone_inverse(tone, shown);
			if (tone == SHADE_TONE_LUMINANCE && shade_largest(shown) > 0.999999f) { /* several look like this */
				back = shade_tone(tone, back);
				SHADE_PROOF_NEAR3(back, shown[0], shown[1], shown[2], 1e-5, 0.0);
				continue;
			}
			/* A float step near the display's end stands for ever more steps of what is shown: slopes are up to some
			 * 250. The neutral curve starts as a parabola: an error e of its result is sqrt(e / 6.25) of a channel that
			 * is black. */
			SHADE_PROOF_NEAR3(back, color[0], color[1], color[2], 1e-4, 1e-3);
			if (shade_largest(color) < 0.5f)
				SHADE_PROOF_NEAR3(back, color[0], color[1], color[2], 1e-5, 1e-4);
			if (tone != SHADE_TONE_NEUTRAL && shade_largest(color) < 0.5f)
				SHADE_PROOF_NEAR3(back, color[0], color[1], color[2], 1e-5, 1e-6);
		}
}

static void numbers_choose(void **state)
{
	(void)state;
	shade_proof_random random = {16, 0};
	for (int i = 0; i < 200; i++) {
		stilb_vec3 color = random_color(&random);
		stilb_vec3 want[SHADE_TONE_COUNT] = {
			[SHADE_TONE_KNEE] = shade_tonemap(color, SHADE_TONEMAP_A, SHADE_TONEMAP_B),
			[SHADE_TONE_NONE] = stilb_vec3_make(fminf(color[0], 1.0f), fminf(color[1], 1.0f), fminf(color[2], 1.0f)),
			[SHADE_TONE_NEUTRAL] = shade_neutral(color),
			[SHADE_TONE_FILMIC] = shade_filmic(color),
			[SHADE_TONE_LUMINANCE] = shade_shown_by_luminance(color),
			[SHADE_TONE_PIECEWISE] = shade_piecewise(color),
			[SHADE_TONE_HABLE] = shade_hable(color),
		};
		for (int tone = 0; tone < SHADE_TONE_COUNT; tone++) {
			stilb_vec3 got = shade_tone(tone, color);
			for (int c = 0; c < 3; c++)
				assert_true(got[c] == want[tone][c]);
		}
	}
	stilb_vec3 half = stilb_vec3_make(0.5f, 0.25f, 0.125f);
	assert_true(shade_tone_inverse(SHADE_TONE_NONE, half)[1] == 0.25f);
	assert_true(shade_tone_inverse(SHADE_TONE_KNEE, half)[1] == 0.25f);
	assert_true(shade_tone_inverse(SHADE_TONE_NEUTRAL, half)[1] == shade_neutral_inverse(half)[1]);
	assert_true(shade_tone_inverse(SHADE_TONE_FILMIC, half)[1] == shade_filmic_inverse(half)[1]);
	assert_true(shade_tone_inverse(SHADE_TONE_LUMINANCE, half)[1] == 0.25f);
	assert_true(shade_tone_inverse(SHADE_TONE_PIECEWISE, half)[1] == shade_piecewise_inverse(half)[1]);
	assert_true(shade_tone_inverse(SHADE_TONE_HABLE, half)[1] == shade_hable_inverse(half)[1]);
}

int main(void)
{
	const struct CMUnitTest exactness[] = {
		cmocka_unit_test(neutral_is_the_printed_one),   cmocka_unit_test(filmic_is_the_printed_one),
		cmocka_unit_test(hable_is_the_printed_one),     cmocka_unit_test(piecewise_is_the_printed_one),
		cmocka_unit_test(luminance_is_the_printed_one), cmocka_unit_test(inverses_are_the_printed_ones),
		cmocka_unit_test(neutral_keeps_base_colors),    cmocka_unit_test(numbers_choose),
	};
	const struct CMUnitTest properties[] = {
		cmocka_unit_test(all_end_in_the_display),
		cmocka_unit_test(all_have_inverses),
		cmocka_unit_test(some_never_cut_off),
	};
	return SHADE_PROOF_RUN(exactness, properties);
}
