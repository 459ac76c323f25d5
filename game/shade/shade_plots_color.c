/* Plots of tone curves, averages without fireflies, and encodings of radiance. */
#include "shade_plots.h"

#include "base/base_math.h"
#include "shading/shade_encoding.h"
#include "shading/shade_firefly.h"
#include "shading/shade_srgb.h"
#include "shading/shade_tonemap.h"

#include <math.h>

static stilb_vec3 color_gray(double value)
{
	return stilb_vec3_make((float)value, (float)value, (float)value);
}

/* ---- tone mapping ------------------------------------------------------------------------------------------------ */

typedef struct curve_ends {
	float a, b;
} curve_ends;

static plot_point bent(double x, const void *context)
{
	const curve_ends *c = context;
	return (plot_point){x, (double)shade_tonemap_curve((float)x, c->a, c->b)};
}

static plot_point simple(double x, const void *context)
{
	(void)context;
	return (plot_point){x, (double)shade_tonemap_simple(color_gray(x), (float)x, 1.0f)[0]};
}

static plot_point unbent(double y, const void *context)
{
	const curve_ends *c = context;
	return (plot_point){(double)shade_tonemap_curve_inverse((float)y, c->a, c->b), y};
}

/* The tone-mapped blue channel of the saturated blue (0, 0.1, 1) x. */
static plot_point blue_by_largest(double x, const void *context)
{
	(void)context;
	return (plot_point){x, (double)shade_tonemap(stilb_vec3_make(0.0f, 0.1f * (float)x, (float)x), 0.6f, 1.0f)[2]};
}

static plot_point blue_by_luminance(double x, const void *context)
{
	(void)context;
	stilb_vec3 blue = stilb_vec3_make(0.0f, 0.1f * (float)x, (float)x);
	return (plot_point){x, (double)shade_tonemap_luminance(blue, 0.6f, 1.0f)[2]};
}

static void draw_tonemap(plot_page *page, const void *subject)
{
	(void)subject;
	static const curve_ends ends[] = {{0.0f, 1.0f}, {0.3f, 1.0f}, {0.6f, 1.0f}};
	plot_panel_begin(page, &(plot_panel){.title = "Curves; dots: their inverse",
	                                     .x_label = "luma",
	                                     .y_label = "shown",
	                                     .x_range = "[0:4]",
	                                     .y_range = "[0:1.05]",
	                                     .key = "bottom right"});
	for (uint32_t i = 0; i < PLOT_COUNT(ends); i++) {
		plot_curve(page, bent, &ends[i], 0.0, 4.0, 161, NULL, "a = %g, b = 1", (double)ends[i].a);
		plot_curve(page, unbent, &ends[i], 0.05, 0.85, 12, "points pointtype 7 pointsize 0.4 linecolor rgb '#222222'",
		           "%s", "");
	}
	plot_curve(page, simple, NULL, 0.0, 4.0, 161, plot_dashed(6), "simple, x / (1 + x)");
	plot_panel_end(page);
	plot_panel_begin(page, &(plot_panel){.title = "The blue channel of (0, 0.1, 1) x, a = 0.6, b = 1",
	                                     .x_label = "x",
	                                     .x_range = "[0:20]",
	                                     .y_range = "[0:6]",
	                                     .key = "center right",
	                                     .extra = PLOT_LINE_AT_ONE});
	plot_curve(page, blue_by_largest, NULL, 0.0, 20.0, 161, NULL, "by the largest channel");
	plot_curve(page, blue_by_luminance, NULL, 0.0, 20.0, 161, NULL, "by the luminance");
	plot_panel_end(page);
}

/* ---- fireflies --------------------------------------------------------------------------------------------------- */

#define VALUES 16

/* Fifteen white pixels of 1 and a red one that is far brighter: a firefly. */
static stilb_vec3 sample(int i, double firefly)
{
	return i > 0 ? color_gray(1.0) : stilb_vec3_make((float)firefly, 0.1f * (float)firefly, 0.05f * (float)firefly);
}

static plot_point plain_mean(double firefly, const void *context)
{
	(void)context;
	double sum = 0.0;
	for (int i = 0; i < VALUES; i++)
		sum += (double)shade_luminance(sample(i, firefly));
	return (plot_point){firefly, sum / VALUES};
}

static plot_point weighted_mean(double firefly, const void *context)
{
	(void)context;
	stilb_vec4 sums = {0.0f, 0.0f, 0.0f, 0.0f};
	for (int i = 0; i < VALUES; i++)
		sums = shade_firefly_add(sums, sample(i, firefly), 1.0f);
	return (plot_point){firefly, (double)shade_luminance(shade_firefly_mean(sums))};
}

/* A measure of brightness: mapped_mean tone maps every pixel by it, averages, and maps the mean back. */
typedef float luma_function(stilb_vec3 color);

static float by_luminance(stilb_vec3 color)
{
	return shade_luminance(color);
}

static float by_largest(stilb_vec3 color)
{
	return shade_largest(color);
}

typedef struct luma {
	luma_function *of;
} luma;

static plot_point mapped_mean(double firefly, const void *context)
{
	const luma *l = context;
	stilb_vec3 mean = color_gray(0.0);
	for (int i = 0; i < VALUES; i++) {
		stilb_vec3 color = sample(i, firefly);
		mean += shade_tonemap_simple(color, l->of(color), 1.0f) * (1.0f / VALUES);
	}
	return (plot_point){firefly, (double)shade_luminance(shade_tonemap_simple_inverse(mean, l->of(mean), 1.0f))};
}

static void draw_firefly(plot_page *page, const void *subject)
{
	(void)subject;
	static const luma luminance = {by_luminance}, largest = {by_largest};
	plot_panel_begin(page, &(plot_panel){.title = "Mean luminance of 15 white pixels of 1 and a red one",
	                                     .x_label = "red channel of the red pixel",
	                                     .x_range = "[1:1000]",
	                                     .y_range = "[0.8:50]",
	                                     .logarithmic = "xy",
	                                     .key = "top left",
	                                     .extra = "set ytics ('1' 1, '2' 2, '5' 5, '10' 10, '20' 20, '50' 50)"});
	plot_curve(page, plain_mean, NULL, 1.0, 1000.0, 61, NULL, "plain mean");
	plot_curve(page, weighted_mean, NULL, 1.0, 1000.0, 61, NULL, "weighted, 1 / (1 + luminance)");
	plot_curve(page, mapped_mean, &luminance, 1.0, 1000.0, 19,
	           "points pointtype 7 pointsize 0.5 linecolor rgb '#222222'", "mapped by luminance, mean, back");
	plot_curve(page, mapped_mean, &largest, 1.0, 1000.0, 61, plot_dashed(1), "mapped by the largest channel, back");
	plot_panel_end(page);
}

/* ---- encodings --------------------------------------------------------------------------------------------------- */

/* A random colour whose largest channel is given: the others are random shares of it. */
static stilb_vec3 random_color(double largest, uint64_t i)
{
	stilb_vec3 color = color_gray(largest);
	for (uint64_t k = 0; k < 3; k++)
		if (k != i % 3)
			color[k] *= stilb_random_float(4, 3 * i + k);
	return color;
}

#define COLORS_EACH 400

/* The largest relative error, percent, of the largest channel of random colours that were stored as RGBM. */
static plot_point rgbm_error(double largest, const void *context)
{
	const float *gamma = context;
	double worst = 0.0;
	for (uint64_t i = 0; i < COLORS_EACH; i++) {
		stilb_vec3 color = random_color(largest * (1.0 + 0.02 * (double)i / COLORS_EACH), i);
		stilb_vec4 stored = shade_unorm8(shade_rgbm_encode(color, SHADE_RGBM_FACTOR, *gamma));
		stilb_vec3 back = shade_rgbm_decode(stored, SHADE_RGBM_FACTOR, *gamma);
		worst = fmax(worst, fabs((double)(shade_largest(back) / shade_largest(color)) - 1.0));
	}
	return (plot_point){largest, 100.0 * worst};
}

/* The bound on that error, percent, that shade_encoding.h states: gamma k / (k - 1) / 510, with k = 255 m the byte in
 * which the factor m of RGBM is stored. */
static plot_point rgbm_bound(double largest, const void *context)
{
	const float *gamma = context;
	double k = fmax(ceil(pow(largest, 1.0 / (double)*gamma) / (double)SHADE_RGBM_FACTOR * 255.0), 2.0);
	return (plot_point){largest, 100.0 * (double)*gamma * k / (k - 1.0) / 510.0};
}

/* The error, percent, of multiplying a colour by a tint while both are encoded, instead of after decoding: with a pure
 * power (tint_error_power) and with the curve of sRGB (tint_error_srgb). */
static plot_point tint_error_power(double tint, const void *context)
{
	(void)context;
	stilb_vec3 color = stilb_vec3_make(0.8f, 0.5f, 0.3f);
	stilb_vec4 stored = shade_rgbm_encode(color, SHADE_RGBM_FACTOR, SHADE_RGBM_GAMMA);
	stored *= (stilb_vec4){1.0f, 1.0f, 1.0f, 0.0f} * shade_rgbm_tint(color_gray(tint), SHADE_RGBM_GAMMA)[0] +
	          (stilb_vec4){0.0f, 0.0f, 0.0f, 1.0f};
	stilb_vec3 back = shade_rgbm_decode(stored, SHADE_RGBM_FACTOR, SHADE_RGBM_GAMMA);
	return (plot_point){tint, 100.0 * ((double)back[0] / (0.8 * tint) - 1.0)};
}

static plot_point tint_error_srgb(double tint, const void *context)
{
	(void)context;
	float stored = shade_srgb_from_linear(0.8f) * shade_srgb_from_linear((float)tint);
	return (plot_point){tint, 100.0 * ((double)shade_srgb_to_linear(stored) / (0.8 * tint) - 1.0)};
}

static void draw_rgbm(plot_page *page, const void *subject)
{
	(void)subject;
	static const float gammas[] = {2.2f, 2.0f};
	plot_panel_begin(page, &(plot_panel){.title = "Largest error of the largest channel; dashed: promised",
	                                     .x_label = "largest channel",
	                                     .y_label = "percent",
	                                     .x_range = "[1e-3:60]",
	                                     .y_range = "[0:1]",
	                                     .logarithmic = "x",
	                                     .key = "top right"});
	for (uint32_t i = 0; i < 2; i++) {
		double range = (double)shade_rgbm_range(SHADE_RGBM_FACTOR, gammas[i]);
		plot_curve(page, rgbm_error, &gammas[i], 1e-3, range / 1.03, 161, NULL, "gamma %g, up to %.1f",
		           (double)gammas[i], range);
		plot_curve(page, rgbm_bound, &gammas[i], 1e-3, range / 1.03, 161, plot_dashed(i), "%s", "");
	}
	plot_panel_end(page);
	plot_panel_begin(page, &(plot_panel){.title = "Error when the stored colour is multiplied",
	                                     .x_label = "tint",
	                                     .y_label = "percent",
	                                     .x_range = "[0:1]",
	                                     .key = "top right"});
	plot_curve(page, tint_error_power, NULL, 0.02, 1.0, 99, NULL, "a pure power (RGBM)");
	plot_curve(page, tint_error_srgb, NULL, 0.02, 1.0, 99, NULL, "sRGB's transfer");
	plot_panel_end(page);
}

/* The largest error, percent, among random colours with luminances from 2^power to twice that: of the luminance, or of
 * any channel relative to the largest channel. */
static plot_point logluv_error(double power, bool of_luminance)
{
	double worst = 0.0;
	for (uint64_t i = 0; i < COLORS_EACH; i++) {
		stilb_vec3 color = random_color(1.0, i);
		color *= (float)exp2(power + (double)i / COLORS_EACH) / shade_luminance(color);
		stilb_vec3 back = shade_logluv_decode(shade_unorm8(shade_logluv_encode(color)));
		if (of_luminance) {
			worst = fmax(worst, fabs((double)(shade_luminance(back) / shade_luminance(color)) - 1.0));
			continue;
		}
		for (int k = 0; k < 3; k++)
			worst = fmax(worst, fabs((double)((back[k] - color[k]) / shade_largest(color))));
	}
	return (plot_point){power, 100.0 * worst};
}

static plot_point logluv_luminance(double power, const void *context)
{
	(void)context;
	return logluv_error(power, true);
}

static plot_point logluv_hue(double power, const void *context)
{
	(void)context;
	return logluv_error(power, false);
}

static void draw_logluv(plot_page *page, const void *subject)
{
	(void)subject;
	plot_panel_begin(page, &(plot_panel){.title = "Largest errors of random colours",
	                                     .x_label = "luminance, power of two",
	                                     .y_label = "percent",
	                                     .x_range = "[-70:70]",
	                                     .y_range = "[0.01:200]",
	                                     .logarithmic = "y",
	                                     .key = "top center"});
	plot_curve(page, logluv_luminance, NULL, -63.0, 63.0, 127, NULL, "luminance");
	plot_curve(page, logluv_hue, NULL, -63.0, 63.0, 127, NULL, "any channel, of the largest");
	plot_panel_end(page);
}

/* ---- sRGB -------------------------------------------------------------------------------------------------------- */

static plot_point srgb_code(double light, const void *context)
{
	(void)context;
	return (plot_point){light, (double)shade_srgb_from_linear((float)light)};
}

static plot_point power_code(double light, const void *context)
{
	(void)context;
	return (plot_point){light, pow(light, 1.0 / 2.2)};
}

static plot_point srgb_light(double code, const void *context)
{
	(void)context;
	return (plot_point){(double)shade_srgb_to_linear((float)code), code};
}

static void draw_srgb(plot_page *page, const void *subject)
{
	(void)subject;
	for (int i = 0; i < 2; i++) {
		double end = i == 0 ? 1.0 : 0.01;
		plot_panel_begin(page,
		                 &(plot_panel){.title = i == 0 ? "Code of a linear light; dots: the inverse" : "Near black",
		                               .x_label = "light",
		                               .y_label = "code",
		                               .key = "bottom right"});
		plot_curve(page, srgb_code, NULL, 0.0, end, 201, NULL, "sRGB");
		plot_curve(page, power_code, NULL, 0.0, end, 201, plot_dashed(1), "power 1 / 2.2");
		plot_curve(page, srgb_light, NULL, 0.0, i == 0 ? 1.0 : 0.0998, 15,
		           "points pointtype 7 pointsize 0.5 linecolor rgb '#222222'", "%s", "");
		plot_panel_end(page);
	}
}

/* ---- the table --------------------------------------------------------------------------------------------------- */

#define KARIS_TONE "Karis, \"Tone mapping\" (2013)"

static const plot color_plots[] = {
	{.name = "tonemap",
     .title = "Tone mapping",
     .formula = "T(x) = x up to a, then (a^2 - b x) / (2 a - b - x)",
     .source = KARIS_TONE,
     .columns = 2,
     .rows = 1,
     .draw = draw_tonemap},
	{.name = "firefly",
     .title = "Averages without fireflies",
     .formula = "weight 1 / (1 + luminance / range)",
     .source = KARIS_TONE,
     .columns = 1,
     .rows = 1,
     .draw = draw_firefly},
	{.name = "rgbm",
     .title = "RGBM",
     .formula = "colour = (6 rgb m)^{gamma}, in 8 bits each",
     .source = "Karis, \"RGBM color encoding\" (2009)",
     .columns = 2,
     .rows = 1,
     .draw = draw_rgbm},
	{.name = "logluv",
     .title = "LogLuv",
     .formula = "u', v' and 2 log_2 Y + 127, in 8, 8 and 16 bits",
     .source = "Ward Larson (1998); Karis (2009)",
     .columns = 1,
     .rows = 1,
     .draw = draw_logluv},
	{.name = "srgb",
     .title = "sRGB",
     .formula = "12.92 x up to 0.0031308, then 1.055 x^{1 / 2.4} - 0.055",
     .source = "IEC 61966-2-1:1999",
     .columns = 2,
     .rows = 1,
     .draw = draw_srgb},
};
const plot_topic shade_plots_color = {"colour", color_plots, PLOT_COUNT(color_plots)};
