/* The table of all strips, which are pictures of spheres in rows, and the materials of the spheres in most of the
 * rows. */
#include "shade_strip.h"

#include <math.h>
#include <stdio.h>

#define COLUMNS 11

static stilb_vec3 gray(float reflectance)
{
	return stilb_vec3_make(reflectance, reflectance, reflectance);
}

/* The diffuse reflectance of the spheres that show wrapped light and the sum of diffuse and specular. */
static stilb_vec3 clay(void)
{
	return stilb_vec3_make(0.62f, 0.26f, 0.15f);
}

/* F0, the reflectance along the normal, of gold. Source: Hoffman, "Background: Physics and Math of Shading" (2013),
 * table 1. */
static stilb_vec3 gold(void)
{
	return stilb_vec3_make(1.000f, 0.766f, 0.336f);
}

static float roughness_of(int column)
{
	return column == 0 ? 0.05f : 0.1f * (float)column;
}

static strip_sphere highlight_of(int kind, stilb_vec3 specular, float roughness)
{
	return (strip_sphere){
		.diffuse_gain = 1.0f,
		.model = {.kind = kind, .ndf = SHADE_NDF_GGX, .g = SHADE_G_SMITH_GGX, .f = SHADE_F_SCHLICK},
		.highlight = {.specular = specular, .roughness = roughness},
		.highlight_gain = 1.0f,
	};
}

/* ---- classic ----------------------------------------------------------------------------------------------------- */

static void make_metal(const strip_row *row, int column, strip_sphere *sphere, strip_words words)
{
	(void)row;
	*sphere = highlight_of(SHADE_BRDF_MICROFACET, gold(), roughness_of(column));
	sphere->mirror = 1.0f;
	snprintf(words, sizeof(strip_words), "roughness %.3g", (double)roughness_of(column));
}

static void make_normalised(const strip_row *row, int column, strip_sphere *sphere, strip_words words)
{
	(void)row;
	float roughness = roughness_of(column);
	*sphere = highlight_of(SHADE_BRDF_BLINN_PHONG_MODIFIED, gray(0.5f), roughness);
	sphere->diffuse = stilb_vec3_make(0.06f, 0.12f, 0.30f);
	double n = (double)shade_exponent_from_alpha(shade_alpha_from_roughness(roughness));
	snprintf(words, sizeof(strip_words), n < 10.0 ? "n = %.1f" : "n = %.0f", n);
}

/* The highlight of early Blinn-Phong, (n.h)^n without a factor. It was used with lights whose intensity includes the
 * 1/pi of the diffuse part, hence SHADE_INV_PI. */
static void make_old(const strip_row *row, int column, strip_sphere *sphere, strip_words words)
{
	make_normalised(row, column, sphere, words);
	float n = shade_exponent_from_alpha(shade_alpha_from_roughness(roughness_of(column)));
	sphere->highlight_gain = SHADE_INV_PI / shade_blinn_phong_modified_factor(n);
}

static void make_wrapped(const strip_row *row, int column, strip_sphere *sphere, strip_words words)
{
	(void)row;
	float wrap = 0.1f * (float)column;
	*sphere = (strip_sphere){.diffuse = clay(), .wrap = wrap, .diffuse_gain = 1.0f};
	snprintf(words, sizeof(strip_words), "w = %.1f", (double)wrap);
}

/* Wrapped diffuse divided by 1 + w once instead of twice, so that it reflects more light than comes. */
static void make_wrapped_old(const strip_row *row, int column, strip_sphere *sphere, strip_words words)
{
	make_wrapped(row, column, sphere, words);
	sphere->diffuse_gain = 1.0f + sphere->wrap;
}

static void make_mixed(const strip_row *row, int column, strip_sphere *sphere, strip_words words)
{
	(void)row;
	float specular = 0.1f * (float)column;
	*sphere = highlight_of(SHADE_BRDF_BLINN_PHONG_MODIFIED, gray(specular), 0.35f);
	sphere->diffuse = clay() * (1.0f - specular);
	sphere->mirror = 1.0f;
	snprintf(words, sizeof(strip_words), "%d %% + %d %%", 100 - 10 * column, 10 * column);
}

/* As make_mixed, but the diffuse part stays the same, however much the highlight reflects. */
static void make_mixed_old(const strip_row *row, int column, strip_sphere *sphere, strip_words words)
{
	make_mixed(row, column, sphere, words);
	sphere->diffuse = clay();
	snprintf(words, sizeof(strip_words), "100 %% + %d %%", 10 * column);
}

static const strip_row classic[] = {
	{.caption = "Microfacets (GGX, Smith,\nSchlick): gold,\nsmooth to rough", .make = make_metal},
	{.caption = "Blinn-Phong of old:\nwithout its factor the\nhighlight loses light", .make = make_old},
	{.caption = "Blinn-Phong, normalised:\nsmaller is brighter", .make = make_normalised},
	{.caption = "Wrapped diffuse of old:\ngains up to 2 x", .make = make_wrapped_old},
	{.caption = "Wrapped diffuse,\nenergy conserving", .make = make_wrapped},
	{.caption = "Diffuse + specular,\nadded up: more light\nleaves than came", .make = make_mixed_old},
	{.caption = "100 % diffuse to\n100 % specular,\nthe sum limited to one", .make = make_mixed},
};

/* ---- models ------------------------------------------------------------------------------------------------------ */

static void make_model(const strip_row *row, int column, strip_sphere *sphere, strip_words words)
{
	*sphere = highlight_of(row->kind, gray(0.5f), roughness_of(column));
	sphere->diffuse = stilb_vec3_make(0.05f, 0.16f, 0.12f);
	snprintf(words, sizeof(strip_words), "roughness %.3g", (double)roughness_of(column));
}

static const strip_row models[] = {
	{.caption = "Phong", .make = make_model, .kind = SHADE_BRDF_PHONG},
	{.caption = "Phong, modified", .make = make_model, .kind = SHADE_BRDF_PHONG_MODIFIED},
	{.caption = "Blinn-Phong", .make = make_model, .kind = SHADE_BRDF_BLINN_PHONG},
	{.caption = "Blinn-Phong,\nmodified", .make = make_model, .kind = SHADE_BRDF_BLINN_PHONG_MODIFIED},
	{.caption = "Minimalist\nCook-Torrance", .make = make_model, .kind = SHADE_BRDF_MINIMALIST},
	{.caption = "Microfacets:\nGGX, Smith,\nSchlick", .make = make_model, .kind = SHADE_BRDF_MICROFACET},
};

/* ---- distributions ----------------------------------------------------------------------------------------------- */

static void make_distribution(const strip_row *row, int column, strip_sphere *sphere, strip_words words)
{
	*sphere = highlight_of(SHADE_BRDF_MICROFACET, stilb_vec3_make(0.56f, 0.57f, 0.58f), roughness_of(column));
	sphere->model.ndf = row->kind;
	sphere->highlight.anisotropy = row->anisotropy;
	sphere->mirror = 1.0f;
	snprintf(words, sizeof(strip_words), "roughness %.3g", (double)roughness_of(column));
}

static const strip_row distributions[] = {
	{.caption = "Blinn", .make = make_distribution, .kind = SHADE_NDF_BLINN},
	{.caption = "Beckmann", .make = make_distribution, .kind = SHADE_NDF_BECKMANN},
	{.caption = "GGX: a bright core\nand a long tail", .make = make_distribution, .kind = SHADE_NDF_GGX},
	{.caption = "GGX, anisotropy 0.6:\nwide around the\nvertical axis",
     .make = make_distribution,
     .kind = SHADE_NDF_GGX_ANISOTROPIC,
     .anisotropy = 0.6f},
	{.caption = "GGX, anisotropy -0.6:\nwide along it",
     .make = make_distribution,
     .kind = SHADE_NDF_GGX_ANISOTROPIC,
     .anisotropy = -0.6f},
};

#define COUNT(rows) ((int)(sizeof(rows) / sizeof *(rows)))

const strip strips[] = {
	{.name = "classic",
     .title = "Energy conservation and roughness",
     .rows = classic,
     .row_count = COUNT(classic),
     .column_count = COLUMNS},
	{.name = "models",
     .title = "Reflection models",
     .rows = models,
     .row_count = COUNT(models),
     .column_count = COLUMNS},
	{.name = "distributions",
     .title = "Distributions of normals, with Smith's shadowing of GGX: iron",
     .rows = distributions,
     .row_count = COUNT(distributions),
     .column_count = COLUMNS},
	{.name = "bump",
     .title = "Bumps without tangents, from dents to hills",
     .rows = strip_bump_rows,
     .row_count = STRIP_BUMP_ROWS,
     .column_count = COLUMNS},
	{.name = "lights",
     .title = "A ball of radius 0.5 m and a lamp of radius 0.25 m, farther and farther away",
     .rows = strip_light_rows,
     .row_count = STRIP_LIGHT_ROWS,
     .column_count = COLUMNS},
	{.name = "harmonics",
     .title = "A sun, and less and less sky, in three bands of spherical harmonics (magenta: negative light)",
     .rows = strip_sh_rows,
     .row_count = STRIP_SH_ROWS,
     .column_count = COLUMNS},
	{.name = "tonemap",
     .title = "Tone mapping: the same ball under more and more light",
     .rows = strip_tonemap_rows,
     .row_count = STRIP_TONEMAP_ROWS,
     .column_count = COLUMNS,
     .tone_mapped = true},
	{.name = "filter",
     .title = "A normal map of small bumps, mip level by mip level",
     .rows = strip_filter_rows,
     .row_count = STRIP_FILTER_ROWS,
     .column_count = 9,
     .prepare = strip_filter_prepare,
     .finish = strip_filter_finish},
};
const int strip_count = COUNT(strips);
