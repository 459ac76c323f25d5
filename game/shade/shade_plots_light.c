/* Plots of lights: sky and ground, falloff with distance, and the cones of light directions beyond which a highlight is
 * too dim to compute. */
#include "shade_plots.h"

#include "numeric/numeric_quadrature.h"
#include "shading/shade_brdf.h"
#include "shading/shade_light.h"
#include "shading/shade_light_cone.h"

#include <math.h>

#define DEGREES (180.0 / M_PI)

/* ---- sky and ground ---------------------------------------------------------------------------------------------- */

static plot_point sky_irradiance(double degrees, const void *context)
{
	(void)context;
	stilb_vec3 one = stilb_vec3_make(1.0f, 1.0f, 1.0f), none = stilb_vec3_make(0.0f, 0.0f, 0.0f);
	float up = (float)cos(degrees / DEGREES);
	return (plot_point){degrees, (double)shade_hemisphere_irradiance(up, one, none)[0] / M_PI};
}

static plot_point sky_share(double degrees, const void *context)
{
	const float *exponent = context;
	return (plot_point){degrees, (double)shade_hemisphere_share((float)sin(degrees / DEGREES), *exponent)};
}

static double cosine_power(double angle, const void *context)
{
	const float *exponent = context;
	return pow(fmax(cos(angle), 0.0), (double)*exponent);
}

static plot_point sky_share_exact(double degrees, const void *context)
{
	double below = stilb_numeric_integrate(cosine_power, context, -M_PI / 2.0, degrees / DEGREES, 64);
	return (plot_point){degrees, below / stilb_numeric_integrate(cosine_power, context, -M_PI / 2.0, M_PI / 2.0, 64)};
}

static void draw_hemisphere(plot_page *page, const void *subject)
{
	(void)subject;
	static const float exponents[] = {1.0f, 5.0f, 25.0f, 125.0f, 3000.0f};
	plot_panel_begin(page, &(plot_panel){.title = "Diffuse: share of the sky",
	                                     .x_label = "angle between normal and up (degrees)",
	                                     .x_range = "[0:180]",
	                                     .y_range = "[0:1]",
	                                     .extra = "set xtics 30"});
	plot_curve(page, sky_irradiance, NULL, 0.0, 180.0, 91, NULL, "%s", "");
	plot_panel_end(page);
	plot_panel_begin(page, &(plot_panel){.title = "Highlight: share of the sky; dotted: exact",
	                                     .x_label = "height of the mirrored view over the horizon (degrees)",
	                                     .x_range = "[-90:90]",
	                                     .y_range = "[0:1]",
	                                     .key = "top left",
	                                     .extra = "set xtics 30"});
	for (uint32_t i = 0; i < PLOT_COUNT(exponents); i++) {
		plot_curve(page, sky_share, &exponents[i], -90.0, 90.0, 181, NULL, "n = %g", (double)exponents[i]);
		plot_curve(page, sky_share_exact, &exponents[i], -90.0, 90.0, 37,
		           "points pointtype 7 pointsize 0.35 linecolor rgb '#404040'", "%s", "");
	}
	plot_panel_end(page);
}

/* ---- falloff ----------------------------------------------------------------------------------------------------- */

#define LAMP_RADIUS 0.5f
#define LAMP_REACH 5.0f
#define LAMP(of_kind, of_falloff)                                                                                      \
	{                                                                                                                  \
		.kind = (of_kind), .falloff = (of_falloff), .radius = LAMP_RADIUS, .reach = LAMP_REACH                         \
	}

/* Irradiance over intensity, m^-2, at distance d, metres, on the axis of the context, a shade_light. */
static plot_point falloff(double d, const void *context)
{
	const shade_light *light = context;
	return (plot_point){d, (double)shade_light_falloff(*light, (float)(d * d), 1.0f)};
}

static plot_point falloff_share(double d, const void *context)
{
	return (plot_point){d, falloff(d, context).y * d * d};
}

static void draw_falloff(plot_page *page, const void *subject)
{
	(void)subject;
	static const struct {
		const char *words;
		shade_light light;
	} rows[] = {{"sphere", LAMP(SHADE_LIGHT_SPHERE, SHADE_FALLOFF_PHYSICAL)},
	            {"disk, on its axis", LAMP(SHADE_LIGHT_DISK, SHADE_FALLOFF_PHYSICAL)},
	            {"windowed", LAMP(SHADE_LIGHT_SPHERE, SHADE_FALLOFF_WINDOWED)},
	            {"subtracted", LAMP(SHADE_LIGHT_SPHERE, SHADE_FALLOFF_SUBTRACTED)}};
	static const shade_light inverse_square = LAMP(SHADE_LIGHT_POINT, SHADE_FALLOFF_PHYSICAL);
	plot_panel_begin(page, &(plot_panel){.title = "E / I (m^{-2}); dashed: 1 / d^2",
	                                     .x_label = "distance d (m)",
	                                     .x_range = "[0.1:10]",
	                                     .y_range = "[1e-3:20]",
	                                     .logarithmic = "xy",
	                                     .key = "bottom left"});
	plot_curve(page, falloff, &inverse_square, 0.1, 10.0, 101, plot_dashed(6), "%s", "");
	for (uint32_t i = 0; i < PLOT_COUNT(rows); i++)
		plot_curve(page, falloff, &rows[i].light, 0.1, 10.0, 301, NULL, "%s", rows[i].words);
	plot_panel_end(page);
	plot_panel_begin(page, &(plot_panel){.title = "The same as a share of 1 / d^2",
	                                     .x_label = "distance d (m)",
	                                     .x_range = "[0:6]",
	                                     .y_range = "[0:1.05]"});
	for (uint32_t i = 0; i < PLOT_COUNT(rows); i++)
		plot_curve(page, falloff_share, &rows[i].light, 0.01, 6.0, 301, NULL, "%s", "");
	plot_panel_end(page);
}

/* ---- cones ------------------------------------------------------------------------------------------------------- */

static const stilb_vec3 upwards = {0.0f, 0.0f, 1.0f, 0.0f};

static stilb_vec3 light_in_plane(double angle)
{
	return stilb_vec3_make((float)sin(angle), 0.0f, (float)cos(angle));
}

typedef enum lobe_kind { LOBE_PHONG, LOBE_BLINN_PHONG, LOBE_GGX, LOBE_KINDS } lobe_kind;

static const char *const lobe_words[LOBE_KINDS] = {"Phong", "Blinn-Phong", "GGX"};

/* The cone of light directions outside of which a lobe of this roughness is below the tolerance, sr^-1. Phong's
 * exponent is converted from that of Blinn-Phong so that both highlights look alike. */
static shade_cone cone_of(lobe_kind kind, float roughness, stilb_vec3 v, float tolerance)
{
	float alpha = shade_alpha_from_roughness(roughness), n = shade_exponent_from_alpha(alpha);
	if (kind == LOBE_GGX)
		return shade_cone_ggx(upwards, v, alpha, tolerance);
	if (kind == LOBE_BLINN_PHONG)
		return shade_cone_blinn_phong(upwards, v, fmaxf(n, 1e-3f), tolerance);
	return shade_cone_phong(upwards, v, fmaxf(shade_exponent_about_r(n), 1e-3f), tolerance);
}

typedef struct cone_subject {
	lobe_kind kind;
	float tolerance;
} cone_subject;

static plot_point cone_angle(double roughness, const void *context)
{
	const cone_subject *c = context;
	shade_cone cone = cone_of(c->kind, (float)roughness, light_in_plane(0.0), c->tolerance);
	return (plot_point){roughness, cone.chord < 0.0f ? 0.0 : (double)shade_cone_half_angle(cone) * DEGREES};
}

static void draw_cone_angles(plot_page *page, float tolerance, const char *key)
{
	char title[64];
	snprintf(title, sizeof title, "Half angle, tolerance %g sr^{-1}", (double)tolerance);
	plot_panel_begin(page, &(plot_panel){.title = title,
	                                     .x_label = "roughness",
	                                     .y_label = "degrees",
	                                     .x_range = "[0:1]",
	                                     .y_range = "[0:185]",
	                                     .key = key,
	                                     .extra = "set ytics 30"});
	for (lobe_kind kind = 0; kind < LOBE_KINDS; kind++) {
		cone_subject c = {kind, tolerance};
		plot_curve(page, cone_angle, &c, 0.0, 1.0, 201, NULL, "%s", lobe_words[kind]);
	}
	plot_panel_end(page);
}

/* A lobe as a function of the light's direction in the plane of the view, on a logarithmic scale from `lowest`, a tenth
 * of the tolerance, to `peak`. */
typedef struct lobe_subject {
	shade_brdf_model model;
	double lowest, peak;
} lobe_subject;

#define CONE_ROUGHNESS 0.35f
#define CONE_VIEW (35.0 / DEGREES)
#define CONE_TOLERANCE 0.01f

static double lobe_value(const lobe_subject *s, double angle)
{
	shade_brdf_parameters p = {.specular = stilb_vec3_make(1.0f, 1.0f, 1.0f), .roughness = CONE_ROUGHNESS};
	shade_frame frame = shade_frame_from_normal(upwards);
	return (double)shade_brdf_cos(s->model, p, frame, light_in_plane(angle), light_in_plane(-CONE_VIEW))[0];
}

static plot_point light_lobe(double angle, const void *context)
{
	const lobe_subject *s = context;
	double share = log(fmax(lobe_value(s, angle), s->lowest) / s->lowest) / log(s->peak / s->lowest);
	return (plot_point){angle, share};
}

static plot_point rim(double length, const void *context)
{
	const double *angle = context;
	return (plot_point){*angle, length};
}

static void draw_cone_lobe(plot_page *page)
{
	static const int kinds[LOBE_KINDS] = {SHADE_BRDF_PHONG_MODIFIED, SHADE_BRDF_BLINN_PHONG_MODIFIED,
	                                      SHADE_BRDF_MICROFACET};
	plot_panel_begin(page, &(plot_panel){.kind = PLOT_LOBES,
	                                     .title = "Roughness 0.35, tolerance 0.01 sr^{-1}",
	                                     .y_range = "[-0.7:1.2]",
	                                     .key = "bottom center vertical maxrows 3"});
	for (lobe_kind kind = 0; kind < LOBE_KINDS; kind++) {
		lobe_subject s = {.model = {kinds[kind], SHADE_NDF_GGX, SHADE_G_SMITH_GGX, SHADE_F_NONE},
		                  .lowest = (double)CONE_TOLERANCE * 0.1,
		                  .peak = 10.0};
		shade_cone cone = cone_of(kind, CONE_ROUGHNESS, light_in_plane(-CONE_VIEW), CONE_TOLERANCE);
		double half = (double)shade_cone_half_angle(cone);
		double rims[2] = {CONE_VIEW - half, CONE_VIEW + half};
		plot_curve(page, light_lobe, &s, -M_PI / 2.0, M_PI / 2.0, 361, NULL, "%s: half angle %.1f°", lobe_words[kind],
		           half * DEGREES);
		for (int i = 0; i < 2; i++)
			plot_curve(page, rim, &rims[i], 0.0, 1.1, 2, plot_dashed(kind), "%s", "");
	}
	plot_panel_end(page);
}

static void draw_cones(plot_page *page, const void *subject)
{
	(void)subject;
	draw_cone_lobe(page);
	draw_cone_angles(page, 0.01f, "bottom right");
	draw_cone_angles(page, 0.1f, NULL);
}

/* The outline of a cone in its plane, t in [0, 1]: from the centre to the rim, along it, and back. */
typedef struct sector {
	double axis, half, length;
} sector;

static plot_point sector_outline(double t, const void *context)
{
	const sector *s = context;
	if (t <= 0.0 || t >= 1.0)
		return (plot_point){0.0, 0.0};
	double angle = s->axis + s->half * (2.0 * t - 1.0);
	return (plot_point){angle, s->length};
}

static void draw_union(plot_page *page, double a_degrees, double a_half, double b_degrees, double b_half)
{
	double at[2] = {a_degrees / DEGREES, b_degrees / DEGREES}, half[2] = {a_half / DEGREES, b_half / DEGREES};
	shade_cone cones[2];
	char title[96];
	for (int i = 0; i < 2; i++)
		cones[i] = (shade_cone){light_in_plane(at[i]), (float)(2.0 * sin(0.5 * half[i]))};
	shade_cone both = shade_cone_union(cones[0], cones[1]);
	sector whole = {atan2((double)both.axis[0], (double)both.axis[2]), (double)shade_cone_half_angle(both), 1.0};
	snprintf(title, sizeof title, "Half angles %g° and %g°, %g° apart", a_half, b_half, fabs(a_degrees - b_degrees));
	plot_panel_begin(page,
	                 &(plot_panel){.kind = PLOT_LOBES, .title = title, .key = "bottom center vertical maxrows 3"});
	for (int i = 0; i < 2; i++) {
		sector s = {at[i], half[i], 0.85 - 0.15 * i};
		plot_curve(page, sector_outline, &s, 0.0, 1.0, 91, NULL, "%s", i == 0 ? "a" : "b");
	}
	plot_curve(page, sector_outline, &whole, 0.0, 1.0, 91, NULL, "union: half angle %.1f°", whole.half * DEGREES);
	plot_panel_end(page);
}

static void draw_unions(plot_page *page, const void *subject)
{
	(void)subject;
	draw_union(page, -30.0, 25.0, 35.0, 12.0);
	draw_union(page, -10.0, 40.0, 12.0, 10.0);
}

/* ---- the table --------------------------------------------------------------------------------------------------- */

static const plot light_plots[] = {
	{.name = "hemisphere",
     .title = "Sky and ground",
     .formula =
         "E = π (sky (1 + n_y) / 2 + ground (1 - n_y) / 2); the highlight's share for exponents n of the mirrored view",
     .source = "Driscoll; Liu and Jordan (1963); Polya (1949)",
     .columns = 2,
     .rows = 1,
     .draw = draw_hemisphere},
	{.name = "falloff",
     .title = "Falloff",
     .formula = "Lamps of radius 0.5 m; windowed and subtracted ones end at 5 m",
     .source = "Karis, \"Tiled Light Culling\" (2012)",
     .columns = 2,
     .rows = 1,
     .draw = draw_falloff},
	{.name = "cones",
     .title = "Cones that hold a highlight",
     .formula =
         "Beyond the half angle no light of irradiance 1 shows more than the tolerance; left: lobes, logarithmic",
     .source = "Karis, \"Tiled Light Culling\" (2012); Blinn-Phong and GGX derived here",
     .columns = 3,
     .rows = 1,
     .draw = draw_cones},
	{.name = "cone-union",
     .title = "The union of two cones",
     .formula = "half angle (A + B + D) / 2, or the larger one where it holds the other",
     .source = "geometry",
     .columns = 2,
     .rows = 1,
     .draw = draw_unions},
};
const plot_topic shade_plots_light = {"light", light_plots, PLOT_COUNT(light_plots)};
