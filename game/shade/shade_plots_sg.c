/* Plots of Spherical Gaussians, von Mises-Fisher distributions and the filtering of normals with them. */
#include "shade_plots.h"

#include "numeric/numeric_quadrature.h"
#include "numeric/numeric_vmf.h"
#include "shading/shade_normal_filter.h"
#include "shading/shade_sampling.h"
#include "shading/shade_sg.h"
#include "shading/shade_vmf.h"

#include <math.h>

#define DEGREES (180.0 / M_PI)
#define DOTS "points pointtype 7 pointsize 0.5 linecolor rgb '#222222'"

static stilb_vec3 sg_in_plane(double angle)
{
	return stilb_vec3_make((float)sin(angle), 0.0f, (float)cos(angle));
}

static shade_sg lobe_of(double angle, float sharpness, float amplitude)
{
	return (shade_sg){sg_in_plane(angle), sharpness, stilb_vec3_make(amplitude, amplitude, amplitude)};
}

/* The value of a lobe in a direction of the plane x, z: by the direction's angle from z in radians (around) and in
 * degrees (along). */
static plot_point around(double angle, const void *context)
{
	const shade_sg *g = context;
	return (plot_point){angle, (double)shade_sg_evaluate(*g, sg_in_plane(angle))[0]};
}

static plot_point along(double degrees, const void *context)
{
	return (plot_point){degrees, around(degrees / DEGREES, context).y};
}

/* ---- lobes ------------------------------------------------------------------------------------------------------- */

static void sg_draw_lobes(plot_page *page, const void *subject)
{
	(void)subject;
	static const float sharpnesses[] = {1.0f, 4.0f, 16.0f, 64.0f};
	plot_panel_begin(page, &(plot_panel){.kind = PLOT_LOBES,
	                                     .title = "Evaluate",
	                                     .y_range = "[-0.75:1.2]",
	                                     .key = "bottom center vertical maxrows 2",
	                                     .extra = "unset label\nset label 'μ' at 0.05,1.14"});
	for (uint32_t i = 0; i < PLOT_COUNT(sharpnesses); i++) {
		shade_sg g = lobe_of(0.0, sharpnesses[i], 1.0f);
		plot_curve(page, around, &g, -M_PI, M_PI, 241, NULL, "sharpness %g", (double)sharpnesses[i]);
	}
	plot_panel_end(page);
	shade_sg g1 = lobe_of(-25.0 / DEGREES, 5.0f, 1.0f), g2 = lobe_of(25.0 / DEGREES, 9.0f, 0.8f);
	shade_sg product = shade_sg_product(g1, g2), power = shade_sg_power(g1, 4.0f);
	plot_panel_begin(page, &(plot_panel){.title = "Product and power",
	                                     .x_label = "angle (degrees)",
	                                     .x_range = "[-90:90]",
	                                     .y_range = "[0:1.5]",
	                                     .key = "top right",
	                                     .extra = "set xtics 30"});
	plot_curve(page, along, &g1, -90.0, 90.0, 181, NULL, "G_1, sharpness 5");
	plot_curve(page, along, &g2, -90.0, 90.0, 181, NULL, "G_2, sharpness 9");
	plot_curve(page, along, &product, -90.0, 90.0, 181, NULL, "G_1 G_2, sharpness %.1f", (double)product.sharpness);
	plot_curve(page, along, &power, -90.0, 90.0, 181, NULL, "G_1^4, sharpness 20");
	plot_panel_end(page);
}

/* ---- integrals --------------------------------------------------------------------------------------------------- */

static plot_point integral(double sharpness, const void *context)
{
	(void)context;
	return (plot_point){sharpness, (double)shade_sg_integral(lobe_of(0.0, (float)sharpness, 1.0f))[0]};
}

static plot_point normalized(double sharpness, const void *context)
{
	(void)context;
	return (plot_point){sharpness, (double)shade_sg_normalize(lobe_of(0.0, (float)sharpness, 1.0f)).amplitude[0]};
}

static plot_point mean_cosine(double sharpness, const void *context)
{
	(void)context;
	return (plot_point){sharpness, (double)shade_sg_mean_cosine((float)sharpness)};
}

typedef struct pair {
	shade_sg g1, g2;
} pair;

/* The product of the two lobes in the direction d, computed in double for the exact curves. */
static double product_at(const double d[3], const void *context)
{
	const pair *p = context;
	double product = 1.0;
	const shade_sg *const lobes[2] = {&p->g1, &p->g2};
	for (int i = 0; i < 2; i++) {
		double cosine = 0.0;
		for (int k = 0; k < 3; k++)
			cosine += d[k] * (double)lobes[i]->axis[k];
		product *= (double)lobes[i]->amplitude[0] * exp((double)lobes[i]->sharpness * (cosine - 1.0));
	}
	return product;
}

static pair sg_apart(double degrees)
{
	return (pair){lobe_of(0.0, 5.0f, 1.0f), lobe_of(degrees / DEGREES, 9.0f, 1.0f)};
}

static plot_point inner_product(double degrees, const void *context)
{
	(void)context;
	pair p = sg_apart(degrees);
	return (plot_point){degrees, (double)shade_sg_inner_product(p.g1, p.g2)[0]};
}

static plot_point inner_product_true(double degrees, const void *context)
{
	(void)context;
	pair p = sg_apart(degrees);
	return (plot_point){degrees, stilb_numeric_integrate_sphere(product_at, &p, -1.0, 1.0, 4)};
}

/* The inner product as Karis's article prints it. The true formula has the length of the sum of the axes, each times
 * its sharpness; printed is that length divided by lambda_m, the sum of both sharpnesses. */
static plot_point inner_product_printed(double degrees, const void *context)
{
	(void)context;
	pair p = sg_apart(degrees);
	stilb_vec3 mean = (p.g1.axis * p.g1.sharpness + p.g2.axis * p.g2.sharpness) / (p.g1.sharpness + p.g2.sharpness);
	double length = sqrt((double)stilb_vec3_dot(mean, mean)), sum = (double)(p.g1.sharpness + p.g2.sharpness);
	return (plot_point){degrees, 2.0 * M_PI * exp(length - sum) * (1.0 - exp(-2.0 * length)) / length};
}

static void draw_integrals(plot_page *page, const void *subject)
{
	(void)subject;
	plot_panel_begin(page, &(plot_panel){.title = "Integral and amplitude of integral 1",
	                                     .x_label = "sharpness",
	                                     .y_range = "[1e-4:1e6]",
	                                     .logarithmic = "xy",
	                                     .key = "top left"});
	plot_curve(page, integral, NULL, 0.01, 10000.0, 101, NULL, "integral of amplitude 1");
	plot_curve(page, normalized, NULL, 0.01, 10000.0, 101, NULL, "normalised amplitude (sr^{-1})");
	plot_panel_end(page);
	plot_panel_begin(page, &(plot_panel){.title = "Mean cosine, coth λ - 1 / λ",
	                                     .x_label = "sharpness",
	                                     .y_range = "[0:1]",
	                                     .logarithmic = "x"});
	plot_curve(page, mean_cosine, NULL, 0.01, 10000.0, 101, NULL, "%s", "");
	plot_panel_end(page);
	plot_panel_begin(page, &(plot_panel){.title = "Inner product, sharpness 5 and 9",
	                                     .x_label = "angle between the axes (degrees)",
	                                     .x_range = "[0:180]",
	                                     .y_range = "[1e-7:1]",
	                                     .logarithmic = "y",
	                                     .key = "bottom left",
	                                     .extra = "set xtics 30"});
	plot_curve(page, inner_product, NULL, 0.0, 180.0, 91, NULL, "as here");
	plot_curve(page, inner_product_true, NULL, 0.0, 180.0, 19, DOTS, "quadrature");
	plot_curve(page, inner_product_printed, NULL, 0.0, 180.0, 91, plot_dashed(1), "as printed");
	plot_panel_end(page);
}

/* ---- convolution ------------------------------------------------------------------------------------------------- */

static plot_point convolved(double degrees, const void *context)
{
	const pair *p = context;
	return along(degrees, &(shade_sg){p->g1.axis, shade_sg_convolve(p->g1, p->g2).sharpness,
	                                  shade_sg_convolve(p->g1, p->g2).amplitude});
}

/* The value of the blurred lobe in a direction: its inner product with the blurring lobe turned into that direction. */
static plot_point convolved_true(double degrees, const void *context)
{
	const pair *p = context;
	shade_sg turned = p->g2;
	turned.axis = sg_in_plane(degrees / DEGREES);
	return (plot_point){degrees, (double)shade_sg_inner_product(p->g1, turned)[0]};
}

static void draw_convolution(plot_page *page, const void *subject)
{
	(void)subject;
	static const float sharpnesses[2][2] = {{20.0f, 40.0f}, {2.0f, 4.0f}};
	for (int i = 0; i < 2; i++) {
		pair p = {lobe_of(0.0, sharpnesses[i][0], 1.0f), lobe_of(0.0, sharpnesses[i][1], 1.0f)};
		char title[64];
		snprintf(title, sizeof title, "Sharpness %g blurred by %g", (double)sharpnesses[i][0],
		         (double)sharpnesses[i][1]);
		plot_panel_begin(page, &(plot_panel){.title = title,
		                                     .x_label = "angle (degrees)",
		                                     .x_range = i == 0 ? "[0:60]" : "[0:180]",
		                                     .y_range = "[0:*]",
		                                     .key = "top right"});
		plot_curve(page, convolved, &p, 0.0, 180.0, 181, NULL, "as a lobe");
		plot_curve(page, convolved_true, &p, 0.0, 180.0, 61, DOTS, "exact");
		plot_panel_end(page);
	}
}

/* ---- von Mises-Fisher -------------------------------------------------------------------------------------------- */

typedef struct inverse {
	float (*of_variance)(float variance);
} inverse;

/* The sharpness that is computed back from the length of the mean vector, as a share of the true sharpness. */
static plot_point sharpness_share(double sharpness, const void *context)
{
	const inverse *i = context;
	float variance = shade_vmf_variance((float)(1.0 / sharpness));
	return (plot_point){sharpness, 1.0 / (double)i->of_variance(variance) / sharpness};
}

static plot_point fitted_share(double sharpness, const void *context)
{
	(void)context;
	enum { DIRECTIONS = 1000 };
	static stilb_vec3 directions[DIRECTIONS];
	uint64_t seed = (uint64_t)(sharpness * 1000.0);
	for (uint64_t i = 0; i < DIRECTIONS; i++) {
		stilb_vec2 u = {stilb_random_float(seed, 2 * i), stilb_random_float(seed, 2 * i + 1)};
		directions[i] = shade_sample_vmf((float)sharpness, u).direction;
	}
	shade_vmf fit = {.inverse_sharpness = NAN};
	if (stilb_numeric_vmf_fit(directions, NULL, DIRECTIONS, &fit) != STILB_OK)
		return (plot_point){sharpness, (double)NAN};
	return (plot_point){sharpness, 1.0 / (double)fit.inverse_sharpness / sharpness};
}

static void draw_vmf_fit(plot_page *page)
{
	static const inverse fast = {shade_vmf_inverse_sharpness_fast}, exact = {shade_vmf_inverse_sharpness};
	plot_panel_begin(page, &(plot_panel){.title = "Sharpness back from the averaged vector r",
	                                     .x_label = "sharpness",
	                                     .y_label = "as a share of the right one",
	                                     .y_range = "[0.9:1.2]",
	                                     .logarithmic = "x",
	                                     .key = "top right"});
	plot_curve(page, sharpness_share, &fast, 0.1, 10000.0, 121, NULL, "r (3 - r^2) / (1 - r^2)");
	plot_curve(page, sharpness_share, &exact, 0.1, 10000.0, 121, NULL, "two steps of Newton");
	plot_curve(page, fitted_share, NULL, 0.5, 10000.0, 20, DOTS, "fit of 1000 directions");
	plot_panel_end(page);
}

static plot_point sum_along(double degrees, const void *context)
{
	const pair *p = context;
	return (plot_point){degrees, along(degrees, &p->g1).y + along(degrees, &p->g2).y};
}

static void draw_sum(plot_page *page, const char *title, double degrees)
{
	pair p = {lobe_of(0.0, 20.0f, 1.0f), lobe_of(degrees / DEGREES, 12.0f, 0.7f)};
	shade_sg sum = shade_sg_add(p.g1, p.g2);
	plot_panel_begin(page, &(plot_panel){.title = title,
	                                     .x_label = "angle (degrees)",
	                                     .x_range = "[-90:150]",
	                                     .y_range = "[0:1.9]",
	                                     .key = "top right",
	                                     .extra = "set xtics 30"});
	plot_curve(page, sum_along, &p, -90.0, 150.0, 241, NULL, "G_1 + G_2");
	plot_curve(page, along, &sum, -90.0, 150.0, 241, NULL, "one lobe, sharpness %.1f", (double)sum.sharpness);
	plot_panel_end(page);
}

static void draw_vmf(plot_page *page, const void *subject)
{
	(void)subject;
	draw_vmf_fit(page);
	draw_sum(page, "Addition: lobes 20° apart", 20.0);
	draw_sum(page, "Addition: lobes 70° apart", 70.0);
}

/* ---- filters of normals ------------------------------------------------------------------------------------------ */

typedef enum filter_kind {
	FILTER_VMF,
	FILTER_TOKSVIG,
	FILTER_VARIANCE,
	FILTER_CONVOLUTION,
	FILTER_LEAN,
	FILTER_KINDS
} filter_kind;

static const char *const filter_words[FILTER_KINDS] = {"vMF", "Toksvig", "variance", "convolution", "LEAN"};

/* Two texels filtered into one; share is the weight of b. */
static shade_rough_normal filtered(filter_kind kind, shade_rough_normal a, shade_rough_normal b, float share)
{
	float alpha2 = (1.0f - share) * a.alpha * a.alpha + share * b.alpha * b.alpha;
	shade_mean_direction plain =
		shade_mean_direction_mix(shade_filter_normal_mean(a.normal), shade_filter_normal_mean(b.normal), share);
	switch (kind) {
	case FILTER_VMF:
		return shade_filter_vmf(shade_mean_direction_mix(shade_filter_vmf_mean(a), shade_filter_vmf_mean(b), share));
	case FILTER_TOKSVIG:
		return shade_filter_toksvig(
			shade_mean_direction_mix(shade_filter_toksvig_mean(a), shade_filter_toksvig_mean(b), share));
	case FILTER_VARIANCE:
		return shade_filter_variance(plain, alpha2);
	case FILTER_CONVOLUTION:
		return shade_filter_convolution(plain, alpha2);
	default:
		return shade_lean_normal(shade_lean_mix(shade_lean_from_normal(a), shade_lean_from_normal(b), share));
	}
}

static plot_point filter_spread(double degrees, const void *context)
{
	const filter_kind *kind = context;
	shade_rough_normal a = {sg_in_plane(-degrees / DEGREES), 0.1f}, b = {sg_in_plane(degrees / DEGREES), 0.1f};
	return (plot_point){degrees, (double)filtered(*kind, a, b, 0.5f).alpha};
}

/* A smooth texel whose normal leans to the left and a rough one whose normal leans to the right. */
static shade_rough_normal smooth_and_rough(filter_kind kind, double share)
{
	shade_rough_normal smooth = {sg_in_plane(-20.0 / DEGREES), 0.05f}, rough = {sg_in_plane(20.0 / DEGREES), 0.7f};
	return filtered(kind, smooth, rough, (float)share);
}

static plot_point filter_tilt(double share, const void *context)
{
	const filter_kind *kind = context;
	stilb_vec3 n = smooth_and_rough(*kind, share).normal;
	return (plot_point){share, atan2((double)n[0], (double)n[2]) * DEGREES};
}

static plot_point filter_alpha(double share, const void *context)
{
	const filter_kind *kind = context;
	return (plot_point){share, (double)smooth_and_rough(*kind, share).alpha};
}

static void draw_filters(plot_page *page, plot_function *f, double end, plot_panel panel)
{
	plot_panel_begin(page, &panel);
	for (filter_kind kind = 0; kind < FILTER_KINDS; kind++)
		plot_curve(page, f, &kind, 0.0, end, 121, kind < FILTER_CONVOLUTION ? NULL : plot_dashed(kind), "%s",
		           filter_words[kind]);
	plot_panel_end(page);
}

static void draw_normal_filter(plot_page *page, const void *subject)
{
	(void)subject;
	draw_filters(page, filter_spread, 60.0,
	             (plot_panel){.title = "Two normals apart, each α = 0.1",
	                          .x_label = "tilt of each, to both sides (degrees)",
	                          .y_label = "α of both",
	                          .x_range = "[0:60]",
	                          .y_range = "[0:1.05]",
	                          .key = "bottom right"});
	draw_filters(page, filter_tilt, 1.0,
	             (plot_panel){.title = "Smooth at -20°, rough at 20°: normal",
	                          .x_label = "share of the rough texel",
	                          .y_label = "tilt of both (degrees)",
	                          .y_range = "[-22:22]"});
	draw_filters(page, filter_alpha, 1.0,
	             (plot_panel){.title = "The same: width (α = 0.05 and 0.7)",
	                          .x_label = "share of the rough texel",
	                          .y_label = "α of both",
	                          .y_range = "[0:1]"});
}

/* ---- the table --------------------------------------------------------------------------------------------------- */

#define KARIS "Karis, \"Spherical Gaussians\" and \"von Mises-Fisher\" (2018)"

static const plot sg_plots[] = {
	{.name = "sg",
     .title = "Spherical Gaussians",
     .formula = "G(v) = a exp(λ (μ·v - 1))",
     .source = KARIS,
     .columns = 2,
     .rows = 1,
     .draw = sg_draw_lobes},
	{.name = "sg-integrals",
     .title = "Integrals of Spherical Gaussians",
     .formula = "∫ G = 2π a (1 - e^{-2λ}) / λ; the product of two lobes is a lobe, so its integral is known",
     .source = KARIS ", corrected",
     .columns = 3,
     .rows = 1,
     .draw = draw_integrals},
	{.name = "sg-convolution",
     .title = "Convolution of Spherical Gaussians",
     .formula = "sharpness λ_1 λ_2 / (λ_1 + λ_2)",
     .source = "Iwasaki et al. (2012)",
     .columns = 2,
     .rows = 1,
     .draw = draw_convolution},
	{.name = "vmf",
     .title = "von Mises-Fisher",
     .formula = "The lobe whose integral is 1, fitted by the mean direction r",
     .source = KARIS "; Banerjee et al. (2005)",
     .columns = 3,
     .rows = 1,
     .draw = draw_vmf},
	{.name = "normal-filter",
     .title = "Filters of normals and roughness",
     .formula =
         "Two texels averaged to one; convolution lies on vMF at the left and on variance in the middle, as LEAN does",
     .source = "Karis, \"Normal map filtering using vMF\" (2018); Toksvig (2004); Olano and Baker (2010)",
     .columns = 3,
     .rows = 1,
     .draw = draw_normal_filter},
};
const plot_topic shade_plots_sg = {"lobes and normals", sg_plots, PLOT_COUNT(sg_plots)};
