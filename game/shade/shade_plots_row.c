/* Plots of the rows of numeric's catalogue (numeric_catalog.h), each a formula: a distribution of normals, a reflection
 * model or a sampler of directions. */
#include "shade_plots.h"

#include "numeric/numeric_catalog.h"

#include <ctype.h>
#include <math.h>
#include <string.h>

#define DEGREES (180.0 / M_PI)

static const float roughnesses[] = {0.1f, 0.3f, 0.5f, 0.7f, 1.0f};

/* One curve: a row of the catalogue and its parameters. The directions of the curve lie in the plane of light and
 * normal. */
typedef struct subject {
	const stilb_numeric_row *row;
	stilb_numeric_shape shape;
	double light; /* angle of the light from the normal to the left, radians */
	double scale; /* factor of the values */
	double end;   /* largest angle of the curve, degrees */
} subject;

static stilb_vec3 row_in_plane(double angle)
{
	return stilb_vec3_make((float)sin(angle), 0.0f, (float)cos(angle));
}

static bool is_anisotropic(const stilb_numeric_row *row)
{
	return strstr(row->name, "anisotropic");
}

static subject subject_of(const stilb_numeric_row *row, float roughness)
{
	return (subject){
		.row = row,
		.shape = {roughness, is_anisotropic(row) ? STILB_NUMERIC_CATALOG_ANISOTROPY : 0.0f,
	              row_in_plane(-45.0 / DEGREES)},
		.light = 45.0 / DEGREES,
		.scale = 1.0,
	};
}

/* ---- distributions ----------------------------------------------------------------------------------------------- */

/* The angle of a curve at t in [0, 1]: points are denser near the axis, where smooth surfaces have their normals. */
static double degrees_of(const subject *s, double t)
{
	return s->end * t * t;
}

static plot_point density(double t, const void *context)
{
	const subject *s = context;
	double degrees = degrees_of(s, t);
	return (plot_point){degrees, (double)s->row->density(&s->shape, row_in_plane(degrees / DEGREES))};
}

static plot_point density_across(double t, const void *context)
{
	const subject *s = context;
	double degrees = degrees_of(s, t);
	stilb_vec3 h = row_in_plane(degrees / DEGREES);
	return (plot_point){degrees, (double)s->row->density(&s->shape, stilb_vec3_make(0.0f, h[0], h[2]))};
}

/* The integral of D or of D cos, whichever must be 1 over all directions for this row, over those up to an angle from
 * the axis. */
static plot_point measured_within(double share, const void *context)
{
	const subject *s = context;
	double degrees = degrees_of(s, share), end = degrees / DEGREES;
	double sum = 0.0;
	int steps = 2000;
	for (int i = 0; i < steps; i++) { /* denser near the axis, where D is high */
		double t = (i + 0.5) / steps, theta = end * t * t, width = end * 2.0 * t / steps;
		double cosine = s->row->measure == STILB_NUMERIC_MEASURE_D_COS ? cos(theta) : 1.0;
		double around = 0.0;
		for (int k = 0; k < 8; k++) {
			double phi = (k + 0.5) * M_PI / 16.0;
			stilb_vec3 h =
				stilb_vec3_make((float)(sin(theta) * cos(phi)), (float)(sin(theta) * sin(phi)), (float)cos(theta));
			around += (double)s->row->density(&s->shape, h) / 8.0;
		}
		sum += around * cosine * 2.0 * M_PI * sin(theta) * width;
	}
	return (plot_point){degrees, sum};
}

static void draw_distribution(plot_page *page, const void *context)
{
	const stilb_numeric_row *row = context;
	const char *measure = row->measure == STILB_NUMERIC_MEASURE_D_COS ? "D n·h" : "D";
	subject widest = subject_of(row, 1.0f);
	bool whole = row->density(&widest.shape, row_in_plane(M_PI)) > 0.0f; /* defined on the sphere, not the hemisphere */
	double end = whole ? 180.0 : 90.0;
	plot_panel panel = {.title = is_anisotropic(row) ? "Density; dashed: along b" : "Density",
	                    .x_label = "angle from the axis (degrees)",
	                    .y_label = "sr^{-1}",
	                    .x_range = whole ? "[0:180]" : "[0:90]",
	                    .y_range = "[1e-4:*]",
	                    .logarithmic = "y",
	                    .key = "top right",
	                    .extra = whole ? "set xtics 30" : "set xtics 15"};
	plot_panel_begin(page, &panel);
	for (uint32_t i = 0; i < PLOT_COUNT(roughnesses); i++) {
		subject s = subject_of(row, roughnesses[i]);
		s.end = end;
		plot_curve(page, density, &s, 0.0, 1.0, 361, NULL, "roughness %.1f", (double)roughnesses[i]);
		if (is_anisotropic(row))
			plot_curve(page, density_across, &s, 0.0, 1.0, 361, plot_dashed(i), "%s", "");
	}
	plot_panel_end(page);
	char title[64];
	snprintf(title, sizeof title, "Integral of %s up to the angle: ends at 1", measure);
	panel.title = title;
	panel.y_label = NULL;
	panel.y_range = "[0:1.1]";
	panel.logarithmic = panel.key = NULL;
	panel.extra = whole ? "set xtics 30\n" PLOT_LINE_AT_ONE : "set xtics 15\n" PLOT_LINE_AT_ONE;
	plot_panel_begin(page, &panel);
	for (uint32_t i = 0; i < PLOT_COUNT(roughnesses); i++) {
		subject s = subject_of(row, roughnesses[i]);
		s.end = end;
		plot_curve(page, measured_within, &s, 0.0, 1.0, 121, NULL, "%s", "");
	}
	plot_panel_end(page);
}

/* ---- reflection models ------------------------------------------------------------------------------------------- */

static const shade_frame upright = {{1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}, {0.0f, 0.0f, 1.0f}};

static shade_brdf_parameters white_of(const subject *s)
{
	return stilb_numeric_white(s->shape.roughness, s->shape.anisotropy);
}

/* The radiance, times scale, at a view angle in radians under a light whose irradiance on a facing surface is 1. */
static plot_point lobe_at(const subject *s, double angle)
{
	stilb_vec3 radiance =
		shade_brdf_cos(s->row->model, white_of(s), upright, row_in_plane(-s->light), row_in_plane(angle));
	return (plot_point){angle, (double)radiance[0] * s->scale};
}

/* lobe_at for all view angles, t in [-1, 1]: points are denser around the mirror direction (t = 0), where smooth
 * surfaces reflect most. */
static plot_point row_lobe(double t, const void *context)
{
	const subject *s = context;
	return lobe_at(s, s->light + t * fabs(t) * (M_PI / 2.0 + (t < 0.0 ? s->light : -s->light)));
}

static double lobe_peak(const subject *s)
{
	double peak = 0.0;
	for (int i = -9000; i <= 9000; i++)
		peak = fmax(peak, lobe_at(s, i * 0.01 / DEGREES).y);
	return peak;
}

static bool is_diffuse(const stilb_numeric_row *row)
{
	return row->model.kind == SHADE_BRDF_LAMBERT || row->model.kind == SHADE_BRDF_WRAPPED;
}

static void row_draw_lobes(plot_page *page, const stilb_numeric_row *row)
{
	plot_panel_begin(page, &(plot_panel){.kind = PLOT_LOBES,
	                                     .title = "f n·l for light at 45°, scaled to its peak (below, sr^{-1})",
	                                     .key = "bottom center vertical maxrows 3"});
	plot_light(page, 45.0 / DEGREES, PLOT_LIGHT_COLOR);
	for (uint32_t i = 0; i < (is_diffuse(row) ? 1 : PLOT_COUNT(roughnesses)); i++) {
		subject s = subject_of(row, roughnesses[i]);
		char words[32];
		double peak = lobe_peak(&s);
		s.scale = 1.0 / peak;
		snprintf(words, sizeof words, is_diffuse(row) ? "every view" : "roughness %.1f", (double)roughnesses[i]);
		plot_curve(page, row_lobe, &s, -1.0, 1.0, 361, NULL, "%s: %.4g", words, peak);
	}
	plot_panel_end(page);
}

static plot_point albedo_of_view(double degrees, const void *context)
{
	const subject *s = context;
	shade_brdf_parameters white = white_of(s);
	return (plot_point){
		degrees, stilb_numeric_albedo_of_view(&s->row->model, &white, (stilb_numeric_angles){degrees / DEGREES, 0.0})};
}

/* The albedo of a light direction: of a reciprocal model the same as that of the view. */
static plot_point albedo_of_light(double degrees, const void *context)
{
	const subject *s = context;
	shade_brdf_parameters white = white_of(s);
	return (plot_point){
		degrees, stilb_numeric_albedo_of_light(&s->row->model, &white, (stilb_numeric_angles){degrees / DEGREES, 0.0})};
}

/* The curves have the colours of the lobes of the same roughness in the panel before. */
static void draw_albedos(plot_page *page, const stilb_numeric_row *row)
{
	bool high = row->largest_albedo > 2.0;
	plot_panel_begin(page, &(plot_panel){.title = row->reciprocal ? "Albedo of a white surface"
	                                                              : "Albedo: full of a view, dashed of a light",
	                                     .x_label = "angle from the normal (degrees)",
	                                     .x_range = "[0:90]",
	                                     .y_range = high ? "[0.01:100]" : "[0:1.2<*]",
	                                     .logarithmic = high ? "y" : NULL,
	                                     .extra = "set xtics 15\n" PLOT_LINE_AT_ONE});
	for (uint32_t i = 0; i < (is_diffuse(row) ? 1 : PLOT_COUNT(roughnesses)); i++) {
		subject s = subject_of(row, roughnesses[i]);
		plot_curve(page, albedo_of_view, &s, 0.0, 89.0, 60, NULL, "%s", "");
		if (!row->reciprocal)
			plot_curve(page, albedo_of_light, &s, 0.0, 89.0, 60, plot_dashed(i), "%s", "");
	}
	plot_panel_end(page);
}

static void draw_model(plot_page *page, const void *context)
{
	row_draw_lobes(page, context);
	draw_albedos(page, context);
}

void shade_plot_typed(char *out, size_t size, const char *words)
{
	snprintf(out, size, "%s", words);
	for (char *c = out; *c; c++)
		if (*c == '_')
			*c = '-';
}

/* ---- samplers ---------------------------------------------------------------------------------------------------- */

#define GRID 24 /* cells along each side of the unit square of random numbers */
#define BINS 60
#define DRAWS 200000
#define SAMPLER_ROUGHNESS 0.6f

static shade_sample draw_sample(const subject *s, uint64_t i)
{
	stilb_vec2 u = {stilb_random_float(1, 2 * i), stilb_random_float(1, 2 * i + 1)};
	return s->row->sample(&s->shape, u);
}

/* Draws directions from the sampler, seen from above: one for a pair of random numbers in each cell of a grid over the
 * unit square. */
static void draw_cloud(plot_page *page, const subject *s, const char *title)
{
	plot_point above[GRID * GRID], below[GRID * GRID];
	uint32_t above_count = 0, below_count = 0;
	for (uint32_t i = 0; i < GRID * GRID; i++) {
		uint32_t column = i % GRID, row = i / GRID;
		stilb_vec2 u = {((float)column + stilb_random_float(2, 2 * (uint64_t)i)) / GRID,
		                ((float)row + stilb_random_float(2, 2 * (uint64_t)i + 1)) / GRID};
		stilb_vec3 d = s->row->sample(&s->shape, u).direction;
		plot_point at = {(double)d[0], (double)d[1]};
		if (d[2] >= 0.0f)
			above[above_count++] = at;
		else
			below[below_count++] = at;
	}
	plot_panel_begin(page,
	                 &(plot_panel){.kind = PLOT_MAP,
	                               .title = title,
	                               .x_range = "[-1.1:1.1]",
	                               .y_range = "[-1.1:1.1]",
	                               .extra = "set object 1 circle at 0,0 size 1 fillstyle empty border linecolor rgb "
	                                        "'#b0b0b0'"});
	if (below_count > 0)
		plot_points(page, below, below_count, "points pointtype 7 pointsize 0.35 linecolor rgb '#b8b8b8'", "");
	plot_points(page, above, above_count, "points pointtype 7 pointsize 0.35 linecolor rgb '#0072B2'", "");
	plot_panel_end(page);
}

/* The density of directions at the height z, integrated around the axis. */
static plot_point ring_density(double z, const void *context)
{
	const subject *s = context;
	int steps = 720;
	double sum = 0.0, radius = sqrt(fmax(1.0 - z * z, 0.0));
	for (int i = 0; i < steps; i++) {
		double phi = (i + 0.5) / steps * 2.0 * M_PI;
		stilb_vec3 d = stilb_vec3_make((float)(radius * cos(phi)), (float)(radius * sin(phi)), (float)z);
		sum += (double)s->row->density(&s->shape, d);
	}
	return (plot_point){z, sum * 2.0 * M_PI / steps};
}

static void draw_histogram(plot_page *page, const subject *s)
{
	uint32_t counts[BINS] = {0};
	double lowest = 0.0;
	for (uint64_t i = 0; i < DRAWS; i++) {
		double z = (double)draw_sample(s, i).direction[2];
		lowest = fmin(lowest, z);
		counts[(uint32_t)fmin(fmax((z + 1.0) * 0.5 * BINS, 0.0), BINS - 1.0)]++;
	}
	plot_point bars[BINS];
	for (uint32_t i = 0; i < BINS; i++)
		bars[i] = (plot_point){((double)i + 0.5) * 2.0 / BINS - 1.0, (double)counts[i] / DRAWS * BINS / 2.0};
	plot_panel_begin(
		page,
		&(plot_panel){.title = "200,000 draws and their density",
	                  .x_label = "height of the direction, cos of the polar angle",
	                  .x_range = lowest < -0.001 ? "[-1:1]" : "[0:1]",
	                  .y_range = "[0:*]",
	                  .key = "top left",
	                  .extra = "set boxwidth 0.0333\nset style fill solid 0.35 noborder\nset offsets 0,0,graph 0.3,0"});
	plot_points(page, bars, BINS, "boxes linecolor rgb '#0072B2'", "draws");
	plot_curve(page, ring_density, s, lowest < -0.001 ? -0.9999 : 0.0001, 0.9999, 400,
	           "lines linewidth 2 linecolor rgb '#D55E00'", "integral of the density around");
	plot_panel_end(page);
}

static void draw_sampler(plot_page *page, const void *context)
{
	subject s = subject_of(context, SAMPLER_ROUGHNESS);
	draw_cloud(page, &s, "Directions from above; grey: below the horizon");
	draw_histogram(page, &s);
}

static void draw_samplers(plot_page *page, const void *context)
{
	(void)context;
	size_t count;
	const stilb_numeric_row *rows = stilb_numeric_catalog(&count);
	for (size_t i = 0; i < count; i++)
		if (rows[i].kind == STILB_NUMERIC_SAMPLER && strcmp(rows[i].name, "sample_stratified") != 0) {
			subject s = subject_of(&rows[i], SAMPLER_ROUGHNESS);
			char title[64];
			shade_plot_typed(title, sizeof title, rows[i].name + strlen("sample_"));
			draw_cloud(page, &s, title);
		}
}

/* ---- stratified draws -------------------------------------------------------------------------------------------- */

#define REPEATS 100

/* The root mean square error of an estimate of the mean of x^2 over a disk, which is 1/4, from side * side points. */
static plot_point disk_error(double side, const void *context)
{
	const bool *stratified = context;
	int columns = (int)side, count = columns * columns;
	double squares = 0.0;
	for (int repeat = 0; repeat < REPEATS; repeat++) {
		double sum = 0.0;
		for (int i = 0; i < count; i++) {
			uint64_t at = (uint64_t)repeat * 1000000u + (uint64_t)i;
			stilb_vec2 u = {stilb_random_float(6, 2 * at), stilb_random_float(6, 2 * at + 1)};
			if (*stratified)
				u = shade_sample_stratified(i, columns, columns, u);
			double x = (double)shade_sample_disk(u)[0];
			sum += x * x;
		}
		squares += (sum / count - 0.25) * (sum / count - 0.25);
	}
	return (plot_point){count, sqrt(squares / REPEATS)};
}

static void draw_stratified(plot_page *page, const void *context)
{
	(void)context;
	static const bool free_draws = false, stratified = true;
	plot_panel_begin(page, &(plot_panel){.title = "Error of the mean of x^2 over a disk",
	                                     .x_label = "points",
	                                     .logarithmic = "xy",
	                                     .key = "bottom left"});
	plot_curve(page, disk_error, &free_draws, 1.0, 64.0, 13,
	           "linespoints pointtype 7 linewidth 2 linecolor rgb '#0072B2'", "free");
	plot_curve(page, disk_error, &stratified, 1.0, 64.0, 13,
	           "linespoints pointtype 7 linewidth 2 linecolor rgb '#D55E00'", "one in each cell");
	plot_panel_end(page);
}

/* ---- a row as a plot --------------------------------------------------------------------------------------------- */

/* Translates a formula of the catalogue into gnuplot's markup for superscripts and Greek letters. */
static void set_formula(char *out, size_t size, const char *formula)
{
	size_t length = 0;
	bool raised = false;
	for (const char *c = formula; *c && length + 8 < size;) {
		const char *piece = NULL;
		size_t taken = 1;
		if (strncmp(c, "alpha", 5) == 0)
			piece = "α", taken = 5;
		else if (strncmp(c, "pi", 2) == 0 && !(c > formula && isalpha((unsigned char)c[-1])))
			piece = "π", taken = 2;
		else if (*c == '_')
			piece = "-";
		else if (strncmp(c, "^(", 2) == 0)
			piece = "^{", taken = 2, raised = true;
		else if (*c == '.' && c > formula && isalpha((unsigned char)c[-1]) && isalpha((unsigned char)c[1]))
			piece = "·";
		else if (*c == ')' && raised)
			piece = "}", raised = false;
		if (piece)
			length += (size_t)snprintf(out + length, size - length, "%s", piece);
		else
			out[length++] = *c;
		c += taken;
	}
	out[length] = '\0';
}

static bool depends_on_roughness(const stilb_numeric_row *row)
{
	subject a = subject_of(row, 0.5f), b = subject_of(row, 1.0f);
	return row->density(&a.shape, row_in_plane(0.0)) != row->density(&b.shape, row_in_plane(0.0));
}

/* Appends the parameters with which the row is drawn to the text of its formula. */
static void add_remark(char *formula, size_t size, const stilb_numeric_row *row)
{
	size_t length = strlen(formula);
	formula += length;
	size -= length;
	if (strcmp(row->name, "sample_disk") == 0)
		snprintf(formula, size, "; lifted to the hemisphere");
	else if (strcmp(row->name, "sample_stratified") == 0)
		snprintf(formula, size, "; as directions of the sphere");
	else if (row->kind == STILB_NUMERIC_SAMPLER && depends_on_roughness(row))
		snprintf(formula, size, "; roughness %g, the view at 45° to the left", (double)SAMPLER_ROUGHNESS);
	else if (row->kind == STILB_NUMERIC_BRDF && row->model.kind == SHADE_BRDF_WRAPPED)
		snprintf(formula, size, "; w = %g", (double)stilb_numeric_white(1.0f, 0.0f).wrap);
	else if (is_anisotropic(row))
		snprintf(formula, size, "; anisotropy %g, along t, the wide axis", (double)STILB_NUMERIC_CATALOG_ANISOTROPY);
}

bool shade_plot_of_row(const char *name, row_plot *out)
{
	static void (*const draw[STILB_NUMERIC_KIND_COUNT])(plot_page *, const void *) = {draw_distribution, draw_model,
	                                                                                  draw_sampler};
	const stilb_numeric_row *row = stilb_numeric_catalog_find(name);
	if (!row)
		return false;
	shade_plot_typed(out->title, sizeof out->title, row->name);
	set_formula(out->formula, sizeof out->formula, row->formula);
	add_remark(out->formula, sizeof out->formula, row);
	out->plot = (plot){.name = row->name,
	                   .title = out->title,
	                   .formula = out->formula,
	                   .source = row->source,
	                   .columns = 2,
	                   .rows = 1,
	                   .draw = draw[row->kind],
	                   .subject = row,
	                   .cloud = row->kind == STILB_NUMERIC_SAMPLER};
	return true;
}

static const plot row_plots[] = {
	{.name = "samplers",
     .title = "Samplers",
     .formula = "576 directions from above, one from each cell of a grid (grey: below the horizon); roughness 0.6, the "
                "view at "
                "45° to the left",
     .source = "The sources are in docs/shading.md",
     .columns = 5,
     .rows = 3,
     .panel_width = 260,
     .panel_height = 270,
     .cloud = true,
     .draw = draw_samplers},
	{.name = "stratified",
     .title = "Stratified draws",
     .formula = "one pair for each cell of a grid",
     .source = "Cook, \"Stochastic Sampling in Computer Graphics\" (1986)",
     .columns = 1,
     .rows = 1,
     .draw = draw_stratified},
};
const plot_topic shade_plots_sampling = {"sampling", row_plots, PLOT_COUNT(row_plots)};
