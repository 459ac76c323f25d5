/* stilb shade table: compares what numeric's catalogue (numeric_catalog.h) promises of each formula, a row, with a
 * measurement, and lists the albedo of each combination of a distribution D, a shadowing term G and a Fresnel term
 * F. */
#include "shade_table.h"
#include "shade.h"

#include "base/base_file.h"
#include "engine.h"
#include "numeric/numeric_catalog.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define RADIANS (M_PI / 180.0)

/* ---- the catalogue ----------------------------------------------------------------------------------------------- */

/* The integral that the row's formula must keep at 1, at the roughness and view at which it is farthest from 1. */
static double table_measure(const stilb_numeric_row *row)
{
	double worst = 1.0;
	for (int step = 0; step <= 4; step++)
		for (int tilt = 0; tilt <= 2; tilt++) {
			double angle = 35.0 * tilt * RADIANS;
			stilb_numeric_shape shape = {0.25f * (float)step, 0.0f,
			                             stilb_vec3_make((float)sin(angle), 0.0f, (float)cos(angle))};
			double value = stilb_numeric_measure_of(row, &shape);
			if (fabs(value - 1.0) > fabs(worst - 1.0))
				worst = value;
		}
	return worst;
}

static void table_rows(FILE *out, stilb_numeric_kind kind, const char *heading)
{
	size_t count;
	const stilb_numeric_row *rows = stilb_numeric_catalog(&count);
	bool brdf = kind == STILB_NUMERIC_BRDF;
	fprintf(out, "\n## %s\n\n| name | formula | is 1 | measured%s | source |\n|---|---|---|---|%s---|\n", heading,
	        brdf ? " | conserving | reciprocal | largest albedo" : "", brdf ? "---|---|---|" : "");
	for (size_t i = 0; i < count; i++) {
		const stilb_numeric_row *row = &rows[i];
		if (row->kind != kind)
			continue;
		fprintf(out, "| `%s` | `%s` | %s | %.5f |", row->name, row->formula, stilb_numeric_measure_text(row->measure),
		        table_measure(row));
		if (brdf)
			fprintf(out, " %s | %s | %.3f |", row->conserving ? "yes" : "**no**", row->reciprocal ? "yes" : "**no**",
			        stilb_numeric_largest_albedo(row));
		fprintf(out, " %s |\n", row->source);
	}
}

/* ---- D x G x F --------------------------------------------------------------------------------------------------- */

static const float table_roughnesses[] = {0.2f, 0.5f, 0.8f};
static const double table_angles[] = {0.0, 60.0, 85.0};

static void table_pair(FILE *out, shade_brdf_model model, float f0)
{
	fprintf(out, "| `%s` | `%s` |", stilb_engine_ndf_names[model.ndf], stilb_engine_g_names[model.g]);
	for (int r = 0; r < 3; r++)
		for (int a = 0; a < 3; a++) {
			shade_brdf_parameters p = stilb_numeric_white(
				table_roughnesses[r], model.ndf == SHADE_NDF_GGX_ANISOTROPIC ? STILB_NUMERIC_CATALOG_ANISOTROPY : 0.0f);
			p.specular = stilb_vec3_make(f0, f0, f0);
			double albedo =
				stilb_numeric_albedo_of_view(&model, &p, (stilb_numeric_angles){table_angles[a] * RADIANS, 0.0});
			fprintf(out, albedo > 1.001 ? " **%.3f** |" : " %.3f |", albedo);
		}
	fprintf(out, "\n");
}

static void table_fresnel(FILE *out, int f, float f0)
{
	fprintf(out, "\n### F = %s, F0 = %g\n\n| D | G |", stilb_engine_f_names[f], (double)f0);
	for (int r = 0; r < 3; r++)
		for (int a = 0; a < 3; a++)
			fprintf(out, " %.1f, %.0f° |", (double)table_roughnesses[r], table_angles[a]);
	fprintf(out, "\n|---|---|---|---|---|---|---|---|---|---|---|\n");
	for (int ndf = 0; ndf < SHADE_NDF_COUNT; ndf++)
		for (int g = 0; g < SHADE_G_COUNT; g++)
			table_pair(out, (shade_brdf_model){SHADE_BRDF_MICROFACET, ndf, g, f}, f0);
}

static void table_write(FILE *out)
{
	fprintf(
		out,
		"# The shading catalogue, measured\n\n"
		"Written by `stilb shade table`: every number is computed when it is asked for, by quadrature in double "
		"around\n"
		"the float functions of `engine/shading`. [shading.md](../shading.md) says what they are for.\n\n"
		"*is 1*: the integral that normalises the row; *measured*: that integral where it is farthest from 1, over\n"
		"roughnesses from 0 to 1 and views from 0° to 70°. *largest albedo*: the most that a white surface gives back\n"
		"of the light, seen from a view and from a light, up to 89° and over all roughnesses; a row that does not\n"
		"conserve energy grows further beyond. Normalised is not conserving.\n");
	table_rows(out, STILB_NUMERIC_DISTRIBUTION, "Distributions");
	table_rows(out, STILB_NUMERIC_BRDF, "Reflection models");
	table_rows(out, STILB_NUMERIC_SAMPLER, "Samplers");
	fprintf(
		out,
		"\n## Albedo of D x G x F\n\n"
		"The share of the light from all around that is seen, by roughness and by the view's angle from the normal.\n"
		"Where the anisotropic D has two widths (anisotropy %g) the view is along the wider one. **Bold** is more "
		"light\n"
		"than came.\n",
		(double)STILB_NUMERIC_CATALOG_ANISOTROPY);
	table_fresnel(out, SHADE_F_NONE, 1.0f);
	table_fresnel(out, SHADE_F_SCHLICK, 0.05f);
	table_fresnel(out, SHADE_F_COOK_TORRANCE, 0.05f);
}

/* ---- the command ------------------------------------------------------------------------------------------------- */

stilb_result shade_table_save(const char *path)
{
	char *text = NULL;
	size_t size = 0;
	FILE *out = open_memstream(&text, &size);
	if (!out)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the table");
	table_write(out);
	stilb_result result = fclose(out) == 0 ? stilb_file_save(path, text, size)
	                                       : stilb_fail(STILB_ERROR_MEMORY, "no memory for the table");
	free(text);
	return result;
}

int shade_table_command(int argc, char **argv)
{
	const char *output = "-";
	const flag flags[] = {{"-o", FLAG_TEXT, &output, "FILE.md", "Markdown (standard output)", 0, 0, NULL}};
	flags_result parsed = flags_parse(flags, 1, argc, argv);
	if (parsed == FLAGS_HELP) {
		printf("stilb shade table: measures every formula of the catalogue, and the albedo of every combination of a\n"
		       "distribution, a shadowing and a Fresnel term, and writes the numbers as a table.\n\n");
		flags_print(flags, 1);
		return EXIT_DONE;
	}
	if (parsed == FLAGS_REFUSED)
		return EXIT_REFUSED;
	if (stilb_file_check(output) != STILB_OK)
		return shade_complain(EXIT_REFUSED);
	return shade_table_save(output) == STILB_OK ? EXIT_DONE : shade_complain(EXIT_FAILED);
}
