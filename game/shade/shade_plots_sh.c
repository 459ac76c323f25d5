/* Plots of spherical harmonics and of bumps. */
#include "shade_plots.h"

#include "numeric/numeric_sh.h"
#include "shading/shade_bump.h"
#include "shading/shade_sh.h"

#include <math.h>

#define DEGREES (180.0 / M_PI)
#define DOTS "points pointtype 7 pointsize 0.5 linecolor rgb '#222222'"

/* ---- the basis --------------------------------------------------------------------------------------------------- */

/* The positive or the negative part of a basis function in the plane of the axes `right` and `up`. */
typedef struct slice {
	int index, right, up;
	float sign;
} slice;

static plot_point slice_at(double angle, const void *context)
{
	const slice *s = context;
	stilb_vec3 d = stilb_vec3_make(0.0f, 0.0f, 0.0f);
	d[s->right] = (float)sin(angle);
	d[s->up] = (float)cos(angle);
	double value = (double)(shade_sh_basis(d).c[s->index] * s->sign);
	return (plot_point){angle, value > 0.0 ? value : 0.0};
}

static void draw_function(plot_page *page, int index, int right, int up, const char *words)
{
	static const char axes[] = "xyz";
	char extra[256];
	snprintf(
		extra, sizeof extra,
		"unset label\nset label '%c' at 0,0.77 center\nset label '%c' at 0.77,0 center\nset arrow from -0.7,0 to 0.7,0 "
		"nohead linecolor rgb '#c8c8c8' back\nset arrow from 0,-0.7 to 0,0.68 nohead linecolor rgb '#c8c8c8' back",
		axes[up], axes[right]);
	plot_panel_begin(
		page, &(plot_panel){
				  .kind = PLOT_MAP, .title = words, .x_range = "[-0.8:0.8]", .y_range = "[-0.8:0.8]", .extra = extra});
	for (int i = 0; i < 2; i++) {
		slice s = {index, right, up, i == 0 ? 1.0f : -1.0f};
		plot_lobe(page, slice_at, &s, -M_PI, M_PI, 181,
		          i == 0
		              ? "filledcurves closed fillcolor rgb '#9ec7e6' linecolor rgb '#0072B2' fillstyle solid border"
		              : "filledcurves closed fillcolor rgb '#f3bf98' linecolor rgb '#D55E00' fillstyle solid border");
	}
	plot_panel_end(page);
}

/* Draws a row of panels for each band (the functions Y_l^m of one l). A panel shows a function in a plane of two axes
 * in which it is not zero everywhere. */
static void draw_basis(plot_page *page, const void *subject)
{
	(void)subject;
	enum { X, Y, Z };
	plot_panel_skip(page, 2);
	draw_function(page, 0, X, Z, "Y_0^0");
	plot_panel_skip(page, 2);
	plot_panel_skip(page, 1);
	draw_function(page, 1, X, Y, "Y_1^{-1}");
	draw_function(page, 2, X, Z, "Y_1^0");
	draw_function(page, 3, X, Y, "Y_1^1");
	plot_panel_skip(page, 1);
	draw_function(page, 4, X, Y, "Y_2^{-2}");
	draw_function(page, 5, Y, Z, "Y_2^{-1}");
	draw_function(page, 6, X, Z, "Y_2^0");
	draw_function(page, 7, X, Z, "Y_2^1");
	draw_function(page, 8, X, Y, "Y_2^2");
}

/* ---- a directional light ----------------------------------------------------------------------------------------- */

static stilb_vec3 sh_in_plane(double angle)
{
	return stilb_vec3_make((float)sin(angle), 0.0f, (float)cos(angle));
}

static plot_point irradiance(double degrees, const void *context)
{
	const shade_sh *light = context;
	return (plot_point){degrees, (double)shade_sh_irradiance(*light, sh_in_plane(degrees / DEGREES))};
}

static plot_point radiance(double degrees, const void *context)
{
	const shade_sh *light = context;
	return (plot_point){degrees, (double)shade_sh_evaluate(*light, sh_in_plane(degrees / DEGREES))};
}

static plot_point clamped_cosine(double degrees, const void *context)
{
	(void)context;
	return (plot_point){degrees, fmax(cos(degrees / DEGREES), 0.0)};
}

static const plot_panel from_light = {
	.x_label = "angle from the light (degrees)",
	.x_range = "[0:180]",
	.key = "top right",
	.extra = "set xtics 30\nset arrow from 0,0 to 180,0 nohead linecolor rgb '#606060'",
};

static void draw_light(plot_page *page, const void *subject)
{
	(void)subject;
	shade_sh sun = shade_sh_directional(sh_in_plane(0.0), 1.0f);
	shade_sh soft = shade_sh_window(sun, SHADE_SH_WINDOW_IRRADIANCE);
	shade_sh softer = shade_sh_window(sun, SHADE_SH_WINDOW_RADIANCE);
	plot_panel panel = from_light;
	panel.title = "Irradiance on a normal";
	plot_panel_begin(page, &panel);
	plot_curve(page, clamped_cosine, NULL, 0.0, 180.0, 181, plot_dashed(6), "max(cos, 0)");
	plot_curve(page, irradiance, &sun, 0.0, 180.0, 181, NULL, "three bands, least -0.0396");
	plot_curve(page, irradiance, &soft, 0.0, 180.0, 181, NULL, "windowed, not negative");
	plot_panel_end(page);
	panel.title = "The light itself (radiance)";
	plot_panel_begin(page, &panel);
	plot_curve(page, radiance, &sun, 0.0, 180.0, 181, NULL, "three bands");
	plot_curve(page, radiance, &soft, 0.0, 180.0, 181, NULL, "windowed for irradiance");
	plot_curve(page, radiance, &softer, 0.0, 180.0, 181, NULL, "windowed for radiance");
	plot_panel_end(page);
}

/* ---- surroundings ------------------------------------------------------------------------------------------------ */

#define SUN_ANGLE 0.9 /* from z to the right, radians */

/* The surroundings: a soft sun, and an upper half that is brighter than the lower. */
static double sky(const double d[3], const void *context)
{
	(void)context;
	double to_sun = d[0] * sin(SUN_ANGLE) + d[2] * cos(SUN_ANGLE);
	return 0.25 + 0.2 * (d[2] > 0.0 ? d[2] : 0.0) + 2.0 * exp(12.0 * (to_sun - 1.0));
}

typedef struct facing {
	stilb_vec3 n;
} facing;

static double received(const double d[3], const void *context)
{
	const facing *f = context;
	double cosine = d[0] * (double)f->n[0] + d[1] * (double)f->n[1] + d[2] * (double)f->n[2];
	return cosine > 0.0 ? cosine * sky(d, NULL) : 0.0;
}

static plot_point irradiance_true(double degrees, const void *context)
{
	(void)context;
	facing f = {sh_in_plane(degrees / DEGREES)};
	return (plot_point){degrees, stilb_numeric_integrate_sphere(received, &f, -1.0, 1.0, 12)};
}

static plot_point sh_radiance_true(double degrees, const void *context)
{
	(void)context;
	double d[3] = {sin(degrees / DEGREES), 0.0, cos(degrees / DEGREES)};
	return (plot_point){degrees, sky(d, NULL)};
}

static plot_point radiance_around(double angle, const void *context)
{
	const shade_sh *f = context;
	return (plot_point){angle, 0.6 * fmax((double)shade_sh_evaluate(*f, sh_in_plane(angle)), 0.0)};
}

static void draw_projection(plot_page *page, const shade_sh *f)
{
	plot_panel panel = from_light;
	panel.title = "Projected surroundings";
	panel.x_label = "angle in the plane x, z (degrees)";
	panel.x_range = "[-180:180]";
	panel.y_range = "[0:3.9]";
	panel.extra = "set xtics 60";
	plot_panel_begin(page, &panel);
	plot_curve(page, sh_radiance_true, NULL, -180.0, 180.0, 181, plot_dashed(6), "radiance");
	plot_curve(page, radiance, f, -180.0, 180.0, 181, NULL, "three bands of it");
	plot_curve(page, irradiance, f, -180.0, 180.0, 181, NULL, "irradiance from them");
	plot_curve(page, irradiance_true, NULL, -180.0, 180.0, 37, DOTS, "by quadrature");
	plot_panel_end(page);
}

static void draw_turned(plot_page *page, const shade_sh *f)
{
	static const double turns[] = {0.0, 40.0, 80.0};
	plot_panel_begin(page, &(plot_panel){.kind = PLOT_LOBES,
	                                     .title = "Rotated; arrows: the dominant light",
	                                     .y_range = "[-0.6:1.2]",
	                                     .key = "bottom center vertical maxrows 1",
	                                     .extra = "unset label\nset label 'z' at 0.05,1.14"});
	for (uint32_t i = 0; i < PLOT_COUNT(turns); i++) {
		shade_frame frame = {sh_in_plane(M_PI / 2.0 - turns[i] / DEGREES), stilb_vec3_make(0.0f, 1.0f, 0.0f),
		                     sh_in_plane(-turns[i] / DEGREES)};
		shade_sh turned = shade_sh_rotate(*f, frame);
		stilb_vec3 to_light = shade_sh_dominant_direction(turned);
		plot_light(page, -atan2((double)to_light[0], (double)to_light[2]), plot_color(i));
		plot_curve(page, radiance_around, &turned, -M_PI, M_PI, 181, NULL, "by %.0f°", turns[i]);
	}
	plot_panel_end(page);
}

static void draw_dominant(plot_page *page, const shade_sh *f)
{
	stilb_vec3 d = shade_sh_dominant_direction(*f);
	shade_sh_light light = shade_sh_dominant_light((shade_sh_rgb){*f, *f, *f});
	shade_sh both = shade_sh_add(shade_sh_directional(d, light.irradiance[0]), shade_sh_ambient(light.ambient[0]));
	plot_panel panel = from_light;
	panel.title = "Dominant light and ambient";
	panel.x_label = "angle in the plane x, z (degrees)";
	panel.x_range = "[-180:180]";
	panel.y_range = "[0:3]";
	panel.extra = "set xtics 60";
	plot_panel_begin(page, &panel);
	plot_curve(page, irradiance, f, -180.0, 180.0, 181, NULL, "irradiance");
	plot_curve(page, irradiance, &both, -180.0, 180.0, 181, NULL, "of one light and ambient");
	plot_panel_end(page);
}

static void draw_surroundings(plot_page *page, const void *subject)
{
	(void)subject;
	shade_sh f = stilb_numeric_sh_project(sky, NULL, 8);
	draw_projection(page, &f);
	draw_turned(page, &f);
	draw_dominant(page, &f);
}

/* ---- bumps ------------------------------------------------------------------------------------------------------- */

#define WAVES 20.0       /* radians per metre */
#define WAVE_HEIGHT 0.02 /* metres */

static double height(double x, double y)
{
	return WAVE_HEIGHT * sin(WAVES * x) * cos(0.7 * WAVES * y);
}

/* The angle between two unit vectors, degrees. */
static double sh_apart(stilb_vec3 a, stilb_vec3 b)
{
	stilb_vec3 difference = a - b;
	return 2.0 * asin(fmin(0.5 * sqrt((double)stilb_vec3_dot(difference, difference)), 1.0)) * DEGREES;
}

typedef enum bump_kind { BUMP_HEIGHT, BUMP_DERIVATIVES } bump_kind;

static stilb_vec3 bumped(bump_kind kind, double x, double y, double step)
{
	stilb_vec3 n = stilb_vec3_make(0.0f, 0.0f, 1.0f);
	stilb_vec3 dp_dx = stilb_vec3_make((float)step, 0.0f, 0.0f), dp_dy = stilb_vec3_make(0.0f, (float)step, 0.0f);
	double h = height(x, y);
	if (kind == BUMP_HEIGHT)
		return shade_bump_from_height(n, dp_dx, dp_dy, (float)(height(x + step, y) - h),
		                              (float)(height(x, y + step) - h), 1.0f);
	stilb_vec2 derivatives = {(float)(WAVE_HEIGHT * WAVES * cos(WAVES * x) * cos(0.7 * WAVES * y)),
	                          (float)(-0.7 * WAVE_HEIGHT * WAVES * sin(WAVES * x) * sin(0.7 * WAVES * y))};
	return shade_bump_from_derivatives(n, dp_dx, dp_dy, derivatives, (stilb_vec2){(float)step, 0.0f},
	                                   (stilb_vec2){0.0f, (float)step}, 1.0f);
}

static stilb_vec3 bumped_true(double x, double y)
{
	double dx = WAVE_HEIGHT * WAVES * cos(WAVES * x) * cos(0.7 * WAVES * y);
	double dy = -0.7 * WAVE_HEIGHT * WAVES * sin(WAVES * x) * sin(0.7 * WAVES * y);
	return stilb_vec3_normalize(stilb_vec3_make((float)-dx, (float)-dy, 1.0f));
}

/* The largest error of the bumped normal over a patch, degrees, by the distance between neighbouring pixels in mm;
 * `step` is that distance in metres. */
static plot_point bump_error(double step, const void *context)
{
	const bump_kind *kind = context;
	double worst = 0.0;
	for (int i = 0; i < 400; i++) {
		int column = i % 20, row = i / 20;
		double x = column * 0.031, y = row * 0.037;
		worst = fmax(worst, sh_apart(bumped(*kind, x, y, step), bumped_true(x, y)));
	}
	return (plot_point){step * 1000.0, worst};
}

/* The relative error of the ray differential, which predicts how far from here the ray of the neighbouring pixel meets
 * the ground. The eye is 1 m above the ground; *pixel is the angle between the rays, radians. */
static plot_point ray_error(double degrees, const void *context)
{
	const double *pixel = context;
	double tilt = degrees / DEGREES; /* from straight down */
	stilb_vec3 n = stilb_vec3_make(0.0f, 1.0f, 0.0f);
	stilb_vec3 forward = stilb_vec3_make(0.0f, (float)-cos(tilt), (float)-sin(tilt));
	stilb_vec3 down = stilb_vec3_make(0.0f, (float)(-sin(tilt) * *pixel), (float)(cos(tilt) * *pixel));
	shade_ray_differential ray = shade_ray_differential_pinhole(forward, down);
	stilb_vec3 step = shade_ray_differential_hit(ray, forward, (float)(1.0 / cos(tilt)), n);
	double here = tan(tilt), next = tan(tilt - atan(*pixel));
	return (plot_point){degrees, fabs(fabs((double)step[2]) / (here - next) - 1.0)};
}

static void draw_bump(plot_page *page, const void *subject)
{
	(void)subject;
	static const double pixels[] = {0.01, 0.003, 0.001};
	static const bump_kind kinds[] = {BUMP_HEIGHT, BUMP_DERIVATIVES};
	plot_panel_begin(page, &(plot_panel){.title = "Largest error of the normal, waves of 0.31 m",
	                                     .x_label = "pixel (mm)",
	                                     .y_label = "degrees",
	                                     .y_range = "[1e-6:100]",
	                                     .logarithmic = "xy",
	                                     .key = "top left"});
	plot_curve(page, bump_error, &kinds[0], 0.00003, 0.1, 61, NULL, "differences of height");
	plot_curve(page, bump_error, &kinds[1], 0.00003, 0.1, 61, NULL, "derivative map");
	plot_panel_end(page);
	plot_panel_begin(page, &(plot_panel){.title = "Ray differential: error of the step on the ground",
	                                     .x_label = "angle of the view from the ground's normal (degrees)",
	                                     .y_label = "share of the step",
	                                     .x_range = "[0:90]",
	                                     .y_range = "[1e-5:1]",
	                                     .logarithmic = "y",
	                                     .key = "top left",
	                                     .extra = "set xtics 15"});
	for (uint32_t i = 0; i < PLOT_COUNT(pixels); i++)
		plot_curve(page, ray_error, &pixels[i], 1.0, 89.0, 89, NULL, "pixels of %g rad", pixels[i]);
	plot_panel_end(page);
}

/* ---- the table --------------------------------------------------------------------------------------------------- */

#define MAXEST "maxest, \"Spherical Harmonic Lighting - Analytical Lights\" (2015)"

static const plot sh_plots[] = {
	{.name = "sh-basis",
     .title = "Spherical harmonics, three bands",
     .formula = "|Y| in a plane of two axes: blue above zero, orange below",
     .source = MAXEST,
     .columns = 5,
     .rows = 3,
     .panel_width = 210,
     .panel_height = 230,
     .draw = draw_basis},
	{.name = "sh-light",
     .title = "A directional light in three bands",
     .formula = "E(n) = Σ A_l c_i Y_i(n), A = π, 2π / 3, π / 4; the window scales band l by exp(-l (l + 1) blur)",
     .source = MAXEST "; Bulow (2004)",
     .columns = 2,
     .rows = 1,
     .draw = draw_light},
	{.name = "sh-surroundings",
     .title = "Surroundings in three bands",
     .formula = "Projection, rotation and the light in their place",
     .source = MAXEST "; Ramamoorthi and Hanrahan (2001); Sloan (2008)",
     .columns = 3,
     .rows = 1,
     .draw = draw_surroundings},
	{.name = "bump",
     .title = "Bumps",
     .formula = "n' = normalize(n - ((∂p/∂t × n) ∂h/∂s + (n × ∂p/∂s) ∂h/∂t) / (n · (∂p/∂s × ∂p/∂t)))",
     .source = "Mikkelsen (2010); Driscoll, \"Derivative Maps\" (2012); Igehy (1999)",
     .columns = 2,
     .rows = 1,
     .draw = draw_bump},
};
const plot_topic shade_plots_sh = {"surroundings and bumps", sh_plots, PLOT_COUNT(sh_plots)};
