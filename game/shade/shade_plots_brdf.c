/* Plots of the parts of reflection models: diffuse, Schueler's normalisation factors of highlights, distributions of
 * normals, shadowing, Fresnel. The models themselves are rows of numeric's catalogue, drawn by shade_plots_row.c. */
#include "shade_plots.h"

#include "numeric/numeric_albedo.h"
#include "shading/shade_brdf.h"
#include "shading/shade_energy.h"

#include <math.h>

#define DEGREES (180.0 / M_PI)

static float cosine(double degrees)
{
	return (float)cos(degrees / DEGREES);
}

static const plot_panel angle_panel = {.x_range = "[0:90]", .extra = "set xtics 15"};

/* ---- diffuse ----------------------------------------------------------------------------------------------------- */

static const float wraps[] = {0.0f, 0.25f, 0.5f, 1.0f};
#define WRAPS (sizeof wraps / sizeof *wraps)

static plot_point wrapped_light(double degrees, const void *context)
{
	const float *wrap = context;
	return (plot_point){degrees, M_PI * (double)shade_wrapped(cosine(degrees), *wrap)};
}

static plot_point wrapped_old(double degrees, const void *context)
{
	const float *wrap = context;
	return (plot_point){degrees, wrapped_light(degrees, context).y * (1.0 + (double)*wrap)};
}

/* The albedo of a white surface seen along the normal under uniform light; *conserving: with the factor 1 / (1 + w)^2,
 * which conserves energy, else with 1 / (1 + w). */
static plot_point wrapped_total(double wrap, const void *context)
{
	const bool *conserving = context;
	shade_brdf_model model = {.kind = SHADE_BRDF_WRAPPED};
	shade_brdf_parameters white = {.specular = stilb_vec3_make(1.0f, 1.0f, 1.0f), .wrap = (float)wrap};
	double albedo = stilb_numeric_albedo_of_view(&model, &white, (stilb_numeric_angles){0.0, 0.0});
	return (plot_point){wrap, *conserving ? albedo : albedo * (1.0 + wrap)};
}

static void draw_wrapped(plot_page *page, const void *subject)
{
	(void)subject;
	static const bool conserving = true, old = false;
	plot_panel_begin(page, &(plot_panel){.title = "π f n·l; dashed: as it was, without the second 1 / (1 + w)",
	                                     .x_label = "light angle from the normal (degrees)",
	                                     .x_range = "[0:180]",
	                                     .y_range = "[0:1.05]",
	                                     .key = "top right",
	                                     .extra = "set xtics 30"});
	for (size_t i = 0; i < WRAPS; i++)
		plot_curve(page, wrapped_light, &wraps[i], 0.0, 180.0, 181, NULL, "w = %.2g", (double)wraps[i]);
	for (uint32_t i = 1; i < WRAPS; i++)
		plot_curve(page, wrapped_old, &wraps[i], 0.0, 180.0, 181, plot_dashed(i), "%s", "");
	plot_panel_end(page);
	plot_panel_begin(page, &(plot_panel){.title = "Albedo of a view: what a white furnace shows",
	                                     .x_label = "w",
	                                     .y_range = "[0:2.1]",
	                                     .key = "top left"});
	plot_curve(page, wrapped_total, &conserving, 0.0, 1.0, 11, NULL, "1 / (1 + w)^2");
	plot_curve(page, wrapped_total, &old, 0.0, 1.0, 11, NULL, "1 / (1 + w)");
	plot_panel_end(page);
}

/* A diffuse reflectance of 0.6 beside a highlight of reflectance `specular`, limited to a sum of 1. */
static plot_point limited_diffuse(double specular, const void *context)
{
	(void)context;
	shade_reflectance r =
		shade_limit_to_one(stilb_vec3_make(0.6f, 0.6f, 0.6f), stilb_vec3_make((float)specular, 0.0f, 0.0f));
	return (plot_point){specular, (double)r.diffuse[0]};
}

static plot_point limited_specular(double specular, const void *context)
{
	(void)context;
	shade_reflectance r =
		shade_limit_to_one(stilb_vec3_make(0.6f, 0.6f, 0.6f), stilb_vec3_make((float)specular, 0.0f, 0.0f));
	return (plot_point){specular, (double)r.specular[0]};
}

static plot_point limited_sum(double specular, const void *context)
{
	return (plot_point){specular, limited_diffuse(specular, context).y + limited_specular(specular, context).y};
}

static void draw_limited(plot_page *page, const void *subject)
{
	(void)subject;
	plot_panel_begin(page, &(plot_panel){.title = "diffuse 0.6 and a growing specular reflectance",
	                                     .x_label = "specular, as asked for",
	                                     .y_label = "share of the light",
	                                     .y_range = "[0:1.1]",
	                                     .key = "bottom right"});
	plot_curve(page, limited_diffuse, NULL, 0.0, 1.0, 101, NULL, "diffuse");
	plot_curve(page, limited_specular, NULL, 0.0, 1.0, 101, NULL, "specular");
	plot_curve(page, limited_sum, NULL, 0.0, 1.0, 101, NULL, "sum");
	plot_panel_end(page);
}

/* ---- Schueler's zoo ---------------------------------------------------------------------------------------------- */

/* A normalisation factor, sr^-1, as a function of the exponent n of a highlight; exact: the factor that `value` is a
 * bound of, or NULL. */
typedef struct factor {
	const char *words;
	float (*value)(float n);
	float (*exact)(float n);
} factor;

static plot_point factor_value(double n, const void *context)
{
	const factor *f = context;
	return (plot_point){n, (double)f->value((float)n)};
}

static plot_point factor_share(double n, const void *context)
{
	const factor *f = context;
	return (plot_point){n, (double)(f->value((float)n) / f->exact((float)n))};
}

static const factor factors[] = {
	{"Phong", shade_phong_factor, NULL},
	{"Phong, modified", shade_phong_modified_factor, NULL},
	{"Blinn-Phong", shade_blinn_phong_factor, NULL},
	{"Blinn-Phong, modified", shade_blinn_phong_modified_factor, NULL},
	{"NDF", shade_blinn_phong_ndf_factor, NULL},
	{"heightfield", shade_blinn_phong_heightfield_factor, NULL},
};

static const factor bounds[] = {
	{"Blinn-Phong: (n + 2) / 8π", shade_blinn_phong_factor_low, shade_blinn_phong_factor},
	{"Blinn-Phong: (n + 4) / 8π", shade_blinn_phong_factor_high, shade_blinn_phong_factor},
	{"modified: (n + 6) / 8π", shade_blinn_phong_modified_factor_low, shade_blinn_phong_modified_factor},
	{"modified: (n + 8) / 8π", shade_blinn_phong_modified_factor_high, shade_blinn_phong_modified_factor},
};

static void draw_factors(plot_page *page, const void *subject)
{
	(void)subject;
	plot_panel_begin(page, &(plot_panel){.title = "Factors; NDF is Phong's, heightfield is modified Phong's",
	                                     .x_label = "exponent n",
	                                     .y_label = "sr^{-1}",
	                                     .logarithmic = "xy",
	                                     .key = "top left"});
	for (uint32_t i = 0; i < PLOT_COUNT(factors); i++)
		plot_curve(page, factor_value, &factors[i], 0.1, 10000.0, 101, i < 4 ? NULL : plot_dashed(i), "%s",
		           factors[i].words);
	plot_panel_end(page);
	plot_panel_begin(page, &(plot_panel){.title = "Bounds, as shares of the exact factor",
	                                     .x_label = "exponent n",
	                                     .y_range = "[0.4:1.6]",
	                                     .logarithmic = "x",
	                                     .key = "top right",
	                                     .extra = PLOT_LINE_AT_ONE});
	for (uint32_t i = 0; i < PLOT_COUNT(bounds); i++)
		plot_curve(page, factor_share, &bounds[i], 0.1, 10000.0, 101, NULL, "%s", bounds[i].words);
	plot_panel_end(page);
}

static plot_point gloss_exponent(double gloss, const void *context)
{
	(void)context;
	return (plot_point){gloss, (double)shade_exponent_from_gloss((float)gloss)};
}

static plot_point gloss_roughness(double gloss, const void *context)
{
	(void)context;
	return (plot_point){gloss, sqrt((double)shade_alpha_from_exponent(shade_exponent_from_gloss((float)gloss)))};
}

static void draw_gloss(plot_page *page, const void *subject)
{
	(void)subject;
	plot_panel_begin(page, &(plot_panel){.title = "Exponent", .x_label = "gloss", .y_label = "n", .logarithmic = "y"});
	plot_curve(page, gloss_exponent, NULL, 0.0, 1.0, 51, NULL, "%s", "");
	plot_panel_end(page);
	plot_panel_begin(page, &(plot_panel){.title = "The same as roughness: √α, α = √(2 / (n + 2))",
	                                     .x_label = "gloss",
	                                     .y_label = "roughness",
	                                     .y_range = "[0:1]"});
	plot_curve(page, gloss_roughness, NULL, 0.0, 1.0, 101, NULL, "%s", "");
	plot_panel_end(page);
}

/* ---- minimalist against what it stands for ----------------------------------------------------------------------- */

static plot_point minimalist_fv(double degrees, const void *context)
{
	const float *f0 = context;
	return (plot_point){degrees, (double)(*f0 * shade_minimalist_fv(cosine(degrees)))};
}

static plot_point schlick_kelemen_fv(double degrees, const void *context)
{
	const float *f0 = context;
	return (plot_point){degrees, (double)shade_schlick_kelemen_fv(stilb_vec3_make(*f0, *f0, *f0), cosine(degrees))[0]};
}

static void draw_minimalist_parts(plot_page *page, const void *subject)
{
	(void)subject;
	static const float f0s[] = {0.02f, 0.05f, 0.8f};
	for (size_t i = 0; i < 3; i++) {
		char title[64];
		snprintf(title, sizeof title, "F_0 = k_s = %g", (double)f0s[i]);
		plot_panel panel = angle_panel;
		panel.title = title;
		panel.x_label = "angle between l and h (degrees)";
		panel.y_label = i == 0 ? "F V" : NULL;
		panel.x_range = "[0:85]";
		panel.logarithmic = "y";
		panel.key = "top left";
		plot_panel_begin(page, &panel);
		plot_curve(page, minimalist_fv, &f0s[i], 0.0, 85.0, 86, NULL, "k_s / (4 (l·h)^3)");
		plot_curve(page, schlick_kelemen_fv, &f0s[i], 0.0, 85.0, 86, NULL, "Schlick F x Kelemen V");
		plot_panel_end(page);
	}
}

/* ---- distributions ----------------------------------------------------------------------------------------------- */

typedef struct distribution {
	int ndf;
	float alpha;
} distribution;

static plot_point ndf_value(double degrees, const void *context)
{
	const distribution *d = context;
	double sine = sin(degrees / DEGREES);
	return (plot_point){degrees, (double)shade_d(d->ndf, (float)(sine * sine), d->alpha)};
}

static void draw_ndf_panel(plot_page *page, float roughness, bool logarithmic)
{
	static const char *const words[] = {"Blinn", "Beckmann", "GGX"};
	char title[64];
	snprintf(title, sizeof title, "D at roughness %g (α = %.2g)", (double)roughness, (double)(roughness * roughness));
	plot_panel_begin(page, &(plot_panel){.title = title,
	                                     .x_label = "angle between n and h (degrees)",
	                                     .y_label = "sr^{-1}",
	                                     .x_range = logarithmic ? "[0:90]" : "[0:60]",
	                                     .y_range = logarithmic ? "[1e-4:*]" : "[0:*]",
	                                     .logarithmic = logarithmic ? "y" : NULL,
	                                     .key = roughness > 0.6f ? "bottom left" : "top right",
	                                     .extra = "set xtics 15"});
	for (int ndf = SHADE_NDF_BLINN; ndf <= SHADE_NDF_GGX; ndf++) {
		distribution d = {ndf, shade_alpha_from_roughness(roughness)};
		plot_curve(page, ndf_value, &d, 0.0, 90.0, 181, NULL, "%s", words[ndf]);
	}
	plot_panel_end(page);
}

static void draw_ndf(plot_page *page, const void *subject)
{
	(void)subject;
	draw_ndf_panel(page, 0.5f, false);
	draw_ndf_panel(page, 0.5f, true);
	draw_ndf_panel(page, 0.8f, true);
}

/* ---- shadowing --------------------------------------------------------------------------------------------------- */

static const char *const g_words[] = {"implicit",       "Neumann",   "Cook-Torrance",    "Kelemen",
                                      "Smith-Beckmann", "Smith-GGX", "Schlick-Beckmann", "Schlick-GGX"};

/* A curve of the shadowing term `g`, a SHADE_G_. The light comes along the normal, or, if mirrored, from the mirror
 * direction of the view. */
typedef struct shadowing {
	int g;
	bool mirrored;
} shadowing;

#define SHADOWING_ROUGHNESS 0.7f

static shade_angles shadowing_angles(double degrees, bool mirrored)
{
	float sine = (float)sin(degrees / DEGREES);
	stilb_vec3 n = stilb_vec3_make(0.0f, 0.0f, 1.0f), v = stilb_vec3_make(sine, 0.0f, cosine(degrees));
	return shade_angles_of(n, mirrored ? stilb_vec3_make(-sine, 0.0f, cosine(degrees)) : n, v);
}

static plot_point shadowing_value(double degrees, const void *context)
{
	const shadowing *s = context;
	float alpha = shade_alpha_from_roughness(SHADOWING_ROUGHNESS);
	return (plot_point){degrees, (double)shade_g(s->g, shadowing_angles(degrees, s->mirrored), alpha, alpha)};
}

static plot_point shadowing_albedo(double degrees, const void *context)
{
	const shadowing *s = context;
	shade_brdf_model model = {SHADE_BRDF_MICROFACET, SHADE_NDF_GGX, s->g, SHADE_F_NONE};
	shade_brdf_parameters white = {.specular = stilb_vec3_make(1.0f, 1.0f, 1.0f), .roughness = SHADOWING_ROUGHNESS};
	return (plot_point){degrees,
	                    stilb_numeric_albedo_of_view(&model, &white, (stilb_numeric_angles){degrees / DEGREES, 0.0})};
}

static void draw_shadowing(plot_page *page, const void *subject)
{
	(void)subject;
	plot_panel panels[3] = {angle_panel, angle_panel, angle_panel};
	panels[0].title = "G, light along the normal (implicit as Neumann)";
	panels[1].title = "G, light mirrored (Cook-Torrance as Kelemen)";
	panels[2].title = "Albedo with GGX, F = 1";
	panels[0].key = "bottom left";
	panels[2].extra = "set xtics 15\n" PLOT_LINE_AT_ONE;
	for (int i = 0; i < 3; i++) {
		panels[i].x_label = "view angle (degrees)";
		panels[i].y_range = i < 2 ? "[0:1.05]" : "[0:1.8]";
		plot_panel_begin(page, &panels[i]);
		for (int g = 0; g < SHADE_G_COUNT; g++) {
			shadowing s = {g, i == 1};
			plot_curve(page, i < 2 ? shadowing_value : shadowing_albedo, &s, 0.0, 89.5, 90, NULL, "%s", g_words[g]);
		}
		plot_panel_end(page);
	}
}

/* The visibility V of GGX by the angle of the view; the light comes from the mirror direction of the view. */
static plot_point visibility(double degrees, const void *context)
{
	const float *roughness = context;
	float c = cosine(degrees), alpha = shade_alpha_from_roughness(*roughness);
	return (plot_point){degrees, (double)shade_v_smith_ggx(c, c, alpha, alpha)};
}

static plot_point visibility_as_g(double degrees, const void *context)
{
	double c = (double)cosine(degrees);
	return (plot_point){degrees, 4.0 * c * c * visibility(degrees, context).y};
}

static void draw_visibility(plot_page *page, const void *subject)
{
	(void)subject;
	static const float roughnesses[] = {0.1f, 0.3f, 0.5f, 0.7f, 1.0f};
	for (int i = 0; i < 2; i++) {
		plot_panel panel = angle_panel;
		panel.title = i == 0 ? "V, light mirrored to the view" : "4 n·l n·v V = G";
		panel.x_label = "view angle (degrees)";
		panel.y_range = i == 0 ? "[0.1:1e5]" : "[0:1.05]";
		panel.logarithmic = i == 0 ? "y" : NULL;
		panel.key = i == 0 ? "top left" : NULL;
		plot_panel_begin(page, &panel);
		for (uint32_t k = 0; k < PLOT_COUNT(roughnesses); k++)
			plot_curve(page, i == 0 ? visibility : visibility_as_g, &roughnesses[k], 0.0, 90.0, 181, NULL,
			           "roughness %.1f", (double)roughnesses[k]);
		plot_panel_end(page);
	}
}

/* ---- Fresnel ----------------------------------------------------------------------------------------------------- */

typedef struct fresnel {
	int f;
	float f0;
} fresnel;

static plot_point fresnel_value(double degrees, const void *context)
{
	const fresnel *f = context;
	return (plot_point){degrees, (double)shade_f(f->f, stilb_vec3_make(f->f0, f->f0, f->f0), cosine(degrees))[0]};
}

static plot_point fresnel_difference(double degrees, const void *context)
{
	fresnel exact = *(const fresnel *)context, schlick = exact;
	exact.f = SHADE_F_COOK_TORRANCE;
	schlick.f = SHADE_F_SCHLICK;
	return (plot_point){degrees, fresnel_value(degrees, &schlick).y - fresnel_value(degrees, &exact).y};
}

static void draw_fresnel(plot_page *page, const void *subject)
{
	(void)subject;
	static const float f0s[] = {0.02f, 0.05f, 0.3f, 0.8f};
	plot_panel panel = angle_panel;
	panel.title = "F: full Cook-Torrance, dashed Schlick";
	panel.x_label = "angle between v and h (degrees)";
	panel.y_range = "[0:1]";
	panel.key = "at graph 0.03,0.7 left top";
	plot_panel_begin(page, &panel);
	for (uint32_t i = 0; i < PLOT_COUNT(f0s); i++) {
		fresnel exact = {SHADE_F_COOK_TORRANCE, f0s[i]}, schlick = {SHADE_F_SCHLICK, f0s[i]};
		plot_curve(page, fresnel_value, &exact, 0.0, 90.0, 121, NULL, "F_0 = %g", (double)f0s[i]);
		plot_curve(page, fresnel_value, &schlick, 0.0, 90.0, 121, plot_dashed(i), "%s", "");
	}
	plot_panel_end(page);
	panel.title = "Schlick less Cook-Torrance";
	panel.y_range = NULL;
	panel.key = NULL;
	plot_panel_begin(page, &panel);
	for (uint32_t i = 0; i < PLOT_COUNT(f0s); i++) {
		fresnel f = {0, f0s[i]};
		plot_curve(page, fresnel_difference, &f, 0.0, 90.0, 121, NULL, "%s", "");
	}
	plot_panel_end(page);
}

/* ---- the table --------------------------------------------------------------------------------------------------- */

#define SCHUELER "Schueler, \"The Blinn-Phong Normalization Zoo\" (2011)"
#define KARIS "Karis, \"Specular BRDF Reference\" (2013)"

static const plot brdf_plots[] = {
	{.name = "wrapped-factor",
     .title = "Wrapped diffuse",
     .formula = "f n·l = max(n·l + w, 0) / (π (1 + w)^2)",
     .source = "McAuley, \"Energy-Conserving Wrapped Diffuse\" (2011)",
     .columns = 2,
     .rows = 1,
     .draw = draw_wrapped},
	{.name = "limit-to-one",
     .title = "Diffuse and specular, limited to one",
     .formula = "C_d + C_s ≤ 1, scaled by the same number",
     .source = "Driscoll, \"Energy Conservation In Games\" (2009)",
     .columns = 1,
     .rows = 1,
     .draw = draw_limited},
	{.name = "factors",
     .title = "The normalisation zoo",
     .formula = "What makes the albedo 1 for light along the normal, and the bounds of it",
     .source = SCHUELER,
     .columns = 2,
     .rows = 1,
     .draw = draw_factors},
	{.name = "gloss",
     .title = "Gloss",
     .formula = "n = 2^{13 gloss}",
     .source = "Lazarov, \"Physically-based lighting in Call of Duty: Black Ops\" (2011)",
     .columns = 2,
     .rows = 1,
     .draw = draw_gloss},
	{.name = "minimalist-parts",
     .title = "Minimalist against Schlick x Kelemen",
     .formula = "k_s / (4 (l·h)^3) for F(l·h) / (4 (l·h)^2)",
     .source = SCHUELER,
     .columns = 3,
     .rows = 1,
     .draw = draw_minimalist_parts},
	{.name = "distributions",
     .title = "Distributions of normals",
     .formula = "∫ D(h) n·h dh = 1",
     .source = KARIS,
     .columns = 3,
     .rows = 1,
     .draw = draw_ndf},
	{.name = "shadowing",
     .title = "Shadowing",
     .formula = "G of both directions at roughness 0.7",
     .source = KARIS,
     .columns = 3,
     .rows = 1,
     .panel_width = 500,
     .draw = draw_shadowing},
	{.name = "visibility",
     .title = "The fused GGX visibility",
     .formula = "V = G / (4 n·l n·v) = 1 / ((n·l + √(α^2 + (1 - α^2) (n·l)^2)) (n·v + √(α^2 + (1 - α^2) (n·v)^2)))",
     .source = KARIS,
     .columns = 2,
     .rows = 1,
     .draw = draw_visibility},
	{.name = "fresnel",
     .title = "Fresnel",
     .formula = "Schlick: F_0 + (1 - F_0)(1 - v·h)^5",
     .source = KARIS,
     .columns = 2,
     .rows = 1,
     .draw = draw_fresnel},
};
const plot_topic shade_plots_brdf = {"reflection", brdf_plots, PLOT_COUNT(brdf_plots)};
