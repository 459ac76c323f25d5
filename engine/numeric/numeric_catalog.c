#include "numeric/numeric_catalog.h"

#include "base/base.h"
#include "numeric/numeric_quadrature.h"

#include "shading/shade_vmf.h"

#include <math.h>
#include <string.h>

/* ---- what a shape means to the functions ------------------------------------------------------------------------- */

static float alpha_of(const stilb_numeric_shape *shape)
{
	return shade_alpha_from_roughness(shape->roughness);
}

static shade_alphas alphas_of(const stilb_numeric_shape *shape)
{
	return shade_alphas_from_anisotropy(alpha_of(shape), shape->anisotropy);
}

static float exponent_of(const stilb_numeric_shape *shape)
{
	return shade_exponent_from_alpha(alpha_of(shape));
}

/* The sharpness of a vMF lobe as wide as D: alpha^2 = 2 / sharpness. */
static float sharpness_of(const stilb_numeric_shape *shape)
{
	return 2.0f / (alpha_of(shape) * alpha_of(shape));
}

static float sine2(stilb_vec3 h)
{
	return h[0] * h[0] + h[1] * h[1];
}

/* ---- distributions ----------------------------------------------------------------------------------------------- */

static float d_blinn(const stilb_numeric_shape *shape, stilb_vec3 h)
{
	return h[2] > 0.0f ? shade_d_blinn(sine2(h), alpha_of(shape)) : 0.0f;
}

static float d_beckmann(const stilb_numeric_shape *shape, stilb_vec3 h)
{
	return h[2] > 0.0f ? shade_d_beckmann(sine2(h), alpha_of(shape)) : 0.0f;
}

static float d_ggx(const stilb_numeric_shape *shape, stilb_vec3 h)
{
	return h[2] > 0.0f ? shade_d_ggx(sine2(h), alpha_of(shape)) : 0.0f;
}

static float d_ggx_anisotropic(const stilb_numeric_shape *shape, stilb_vec3 h)
{
	shade_alphas alphas = alphas_of(shape);
	return h[2] > 0.0f ? shade_d_ggx_anisotropic(h[0], h[1], alphas.x, alphas.y) : 0.0f;
}

static float d_blinn_phong(const stilb_numeric_shape *shape, stilb_vec3 h)
{
	float n = exponent_of(shape);
	return h[2] > 0.0f ? shade_blinn_phong_ndf_factor(n) * shade_cos_power(sine2(h), n) : 0.0f;
}

static float d_heightfield(const stilb_numeric_shape *shape, stilb_vec3 h)
{
	float n = exponent_of(shape);
	return h[2] > 0.0f ? shade_blinn_phong_heightfield_factor(n) * shade_cos_power(sine2(h), n) : 0.0f;
}

static float d_vmf(const stilb_numeric_shape *shape, stilb_vec3 direction)
{
	shade_vmf lobe = {{0.0f, 0.0f, 1.0f}, 1.0f / sharpness_of(shape)};
	return shade_vmf_density(lobe, direction);
}

/* ---- samplers: a density and a sample, in this order ------------------------------------------------------------- */

static float pdf_sphere(const stilb_numeric_shape *shape, stilb_vec3 direction)
{
	(void)shape;
	(void)direction;
	return shade_pdf_sphere();
}

static shade_sample sample_sphere(const stilb_numeric_shape *shape, stilb_vec2 u)
{
	(void)shape;
	return shade_sample_sphere(u);
}

static float pdf_hemisphere(const stilb_numeric_shape *shape, stilb_vec3 direction)
{
	(void)shape;
	return shade_pdf_hemisphere(direction);
}

static shade_sample sample_hemisphere(const stilb_numeric_shape *shape, stilb_vec2 u)
{
	(void)shape;
	return shade_sample_hemisphere(u);
}

static float pdf_cosine(const stilb_numeric_shape *shape, stilb_vec3 direction)
{
	(void)shape;
	return shade_pdf_cosine(direction);
}

static shade_sample sample_cosine(const stilb_numeric_shape *shape, stilb_vec2 u)
{
	(void)shape;
	return shade_sample_cosine(u);
}

/* shade_sample_disk, each point lifted to the hemisphere above it: an area of the disk is a solid angle times its
 * cosine. */
static float pdf_disk(const stilb_numeric_shape *shape, stilb_vec3 direction)
{
	(void)shape;
	return shade_pdf_disk((stilb_vec2){direction[0], direction[1]}) * fmaxf(direction[2], 0.0f);
}

static shade_sample sample_disk(const stilb_numeric_shape *shape, stilb_vec2 u)
{
	stilb_vec2 p = shade_sample_disk(u);
	stilb_vec3 direction = stilb_vec3_make(p[0], p[1], sqrtf(fmaxf(1.0f - p[0] * p[0] - p[1] * p[1], 0.0f)));
	return (shade_sample){direction, pdf_disk(shape, direction)};
}

/* shade_sample_stratified with a 4 x 4 grid, each cell as likely as any other, and the pair made a direction of the
 * sphere. */
static float pdf_stratified(const stilb_numeric_shape *shape, stilb_vec3 direction)
{
	(void)shape;
	(void)direction;
	return shade_pdf_stratified((stilb_vec2){0.5f, 0.5f}) * shade_pdf_sphere();
}

static shade_sample sample_stratified(const stilb_numeric_shape *shape, stilb_vec2 u)
{
	float cell = floorf(u[0] * 16.0f);
	stilb_vec2 pair = shade_sample_stratified((int)cell, 4, 4, (stilb_vec2){u[0] * 16.0f - cell, u[1]});
	shade_sample chosen = shade_sample_sphere(pair);
	chosen.pdf = pdf_stratified(shape, chosen.direction);
	return chosen;
}

static float pdf_power(const stilb_numeric_shape *shape, stilb_vec3 direction)
{
	return shade_pdf_power(exponent_of(shape), direction);
}

static shade_sample sample_power(const stilb_numeric_shape *shape, stilb_vec2 u)
{
	return shade_sample_power(exponent_of(shape), u);
}

static float pdf_vmf(const stilb_numeric_shape *shape, stilb_vec3 direction)
{
	return shade_pdf_vmf(sharpness_of(shape), direction);
}

static shade_sample sample_vmf(const stilb_numeric_shape *shape, stilb_vec2 u)
{
	return shade_sample_vmf(sharpness_of(shape), u);
}

static float pdf_blinn_normal(const stilb_numeric_shape *shape, stilb_vec3 direction)
{
	return shade_pdf_blinn_normal(exponent_of(shape), direction);
}

static shade_sample sample_blinn_normal(const stilb_numeric_shape *shape, stilb_vec2 u)
{
	return shade_sample_blinn_normal(exponent_of(shape), u);
}

static float pdf_ggx_normal(const stilb_numeric_shape *shape, stilb_vec3 direction)
{
	return shade_pdf_ggx_normal(alphas_of(shape), direction);
}

static shade_sample sample_ggx_normal(const stilb_numeric_shape *shape, stilb_vec2 u)
{
	return shade_sample_ggx_normal(alphas_of(shape), u);
}

static float pdf_ggx_visible_normal(const stilb_numeric_shape *shape, stilb_vec3 direction)
{
	return shade_pdf_ggx_visible_normal(alphas_of(shape), shape->view, direction);
}

static shade_sample sample_ggx_visible_normal(const stilb_numeric_shape *shape, stilb_vec2 u)
{
	return shade_sample_ggx_visible_normal(alphas_of(shape), shape->view, u);
}

static float pdf_phong(const stilb_numeric_shape *shape, stilb_vec3 direction)
{
	return shade_pdf_phong(shade_exponent_about_r(exponent_of(shape)), shape->view, direction);
}

static shade_sample sample_phong(const stilb_numeric_shape *shape, stilb_vec2 u)
{
	return shade_sample_phong(shade_exponent_about_r(exponent_of(shape)), shape->view, u);
}

static float pdf_blinn_phong(const stilb_numeric_shape *shape, stilb_vec3 direction)
{
	return shade_pdf_blinn_phong(exponent_of(shape), shape->view, direction);
}

static shade_sample sample_blinn_phong(const stilb_numeric_shape *shape, stilb_vec2 u)
{
	return shade_sample_blinn_phong(exponent_of(shape), shape->view, u);
}

static float pdf_ggx(const stilb_numeric_shape *shape, stilb_vec3 direction)
{
	return shade_pdf_ggx(alphas_of(shape), shape->view, direction);
}

static shade_sample sample_ggx(const stilb_numeric_shape *shape, stilb_vec2 u)
{
	return shade_sample_ggx(alphas_of(shape), shape->view, u);
}

static float pdf_ggx_visible(const stilb_numeric_shape *shape, stilb_vec3 direction)
{
	return shade_pdf_ggx_visible(alphas_of(shape), shape->view, direction);
}

static shade_sample sample_ggx_visible(const stilb_numeric_shape *shape, stilb_vec2 u)
{
	return shade_sample_ggx_visible(alphas_of(shape), shape->view, u);
}

/* ---- the table --------------------------------------------------------------------------------------------------- */

#define KARIS "Karis, \"Specular BRDF Reference\" (2013)"
#define SCHUELER "Schueler, \"The Blinn-Phong Normalization Zoo\" (2011)"

// clang-format off
#define DISTRIBUTION(id, of, formula_text, source_text) \
	{.name = #id, .formula = formula_text, .source = source_text, .kind = STILB_NUMERIC_DISTRIBUTION, .measure = of, \
	 .density = id}

#define ZOO(kind_of, id, of, formula_text, source_text, conserves, is_reciprocal, largest) \
	{.name = #id, .formula = formula_text, .source = source_text, .kind = STILB_NUMERIC_BRDF, .measure = of, \
	 .model = {.kind = kind_of}, .conserving = conserves, .reciprocal = is_reciprocal, .largest_albedo = largest}

/* Smith's G for Beckmann shadows too little with distributions that have more steep facets than Beckmann's. */
#define GAINS(d, g) ((g) == SHADE_G_SMITH_BECKMANN && (d) != SHADE_NDF_BECKMANN)
#define LARGEST(d, g) \
	(!GAINS(d, g) ? 1.0 : (d) == SHADE_NDF_BLINN ? 1.3026 : (d) == SHADE_NDF_GGX ? 1.6161 : 1.6453)
#define MICROFACET(d, d_id, g, g_id) \
	{.name = #d_id "_" #g_id, .formula = "D(" #d_id ") G(" #g_id ") F / (4 n.l n.v)", .source = KARIS, \
	 .kind = STILB_NUMERIC_BRDF, .measure = STILB_NUMERIC_MEASURE_SMOOTH, \
	 .model = {SHADE_BRDF_MICROFACET, d, g, SHADE_F_NONE}, \
	 .conserving = !GAINS(d, g), .reciprocal = true, .largest_albedo = LARGEST(d, g)},
#define BLINN(g, id) MICROFACET(SHADE_NDF_BLINN, blinn, g, id)
#define BECKMANN(g, id) MICROFACET(SHADE_NDF_BECKMANN, beckmann, g, id)
#define GGX(g, id) MICROFACET(SHADE_NDF_GGX, ggx, g, id)
#define GGX_ANISOTROPIC(g, id) MICROFACET(SHADE_NDF_GGX_ANISOTROPIC, ggx_anisotropic, g, id)

#define SAMPLER(id, about, formula_text, source_text) \
	{.name = "sample_" #id, .formula = formula_text, .source = source_text, .kind = STILB_NUMERIC_SAMPLER, \
	 .measure = STILB_NUMERIC_MEASURE_PDF, .density = pdf_##id, .sample = sample_##id, \
	 .pole = STILB_NUMERIC_POLE_##about}

static const stilb_numeric_row rows[] = {
	DISTRIBUTION(d_blinn, STILB_NUMERIC_MEASURE_D_COS, "1 / (pi alpha^2) (n.h)^(2 / alpha^2 - 2)", KARIS),
	DISTRIBUTION(d_beckmann, STILB_NUMERIC_MEASURE_D_COS, "1 / (pi alpha^2 (n.h)^4) exp(-tan^2 / alpha^2)", KARIS),
	DISTRIBUTION(d_ggx, STILB_NUMERIC_MEASURE_D_COS, "alpha^2 / (pi ((n.h)^2 (alpha^2 - 1) + 1)^2)", KARIS),
	DISTRIBUTION(d_ggx_anisotropic, STILB_NUMERIC_MEASURE_D_COS,
		"1 / (pi ax ay ((t.h / ax)^2 + (b.h / ay)^2 + (n.h)^2)^2)", KARIS),
	DISTRIBUTION(d_blinn_phong, STILB_NUMERIC_MEASURE_D, "(n + 1) / (2 pi) (n.h)^n", SCHUELER),
	DISTRIBUTION(d_heightfield, STILB_NUMERIC_MEASURE_D_COS, "(n + 2) / (2 pi) (n.h)^n", SCHUELER),
	DISTRIBUTION(d_vmf, STILB_NUMERIC_MEASURE_D, "k / (4 pi sinh k) exp(k axis.w)",
		"Karis, \"von Mises-Fisher\" (2018)"),

	ZOO(SHADE_BRDF_LAMBERT, lambert, STILB_NUMERIC_MEASURE_REFLECTED, "1 / pi",
		"Driscoll, \"Energy Conservation In Games\" (2009)", true, true, 1.0),
	ZOO(SHADE_BRDF_WRAPPED, wrapped, STILB_NUMERIC_MEASURE_REFLECTED, "max(n.l + w, 0) / (pi (1 + w)^2 n.l)",
		"McAuley, \"Energy-Conserving Wrapped Diffuse\" (2011)", false, false, 14.575),
	ZOO(SHADE_BRDF_PHONG, phong, STILB_NUMERIC_MEASURE_REFLECTED, "(n + 1) / (2 pi) (r.l)^n / n.l", SCHUELER,
		false, false, 14.575),
	ZOO(SHADE_BRDF_PHONG_MODIFIED, phong_modified, STILB_NUMERIC_MEASURE_REFLECTED, "(n + 2) / (2 pi) (r.l)^n",
		SCHUELER, true, true, 1.0),
	ZOO(SHADE_BRDF_BLINN_PHONG, blinn_phong, STILB_NUMERIC_MEASURE_REFLECTED,
		"(n + 2) / (4 pi (2 - 2^(-n/2))) (n.h)^n / n.l", SCHUELER, false, false, 28.649),
	ZOO(SHADE_BRDF_BLINN_PHONG_MODIFIED, blinn_phong_modified, STILB_NUMERIC_MEASURE_REFLECTED,
		"(n + 2) (n + 4) / (8 pi (2^(-n/2) + n)) (n.h)^n", SCHUELER, true, true, 1.0),
	ZOO(SHADE_BRDF_MINIMALIST, minimalist, STILB_NUMERIC_MEASURE_SMOOTH, "ks (n + 1) (n.h)^n / (8 pi (l.h)^3)",
		SCHUELER, false, true, 57.204),
	SHADE_GS(BLINN)
	SHADE_GS(BECKMANN)
	SHADE_GS(GGX)
	SHADE_GS(GGX_ANISOTROPIC)

	SAMPLER(sphere, AXIS, "1 / (4 pi)", "Archimedes: equal heights, equal areas"),
	SAMPLER(hemisphere, AXIS, "1 / (2 pi)", "Archimedes: equal heights, equal areas"),
	SAMPLER(cosine, AXIS, "n.l / pi", "Malley's method"),
	SAMPLER(disk, AXIS, "1 / pi per area", "Shirley and Chiu, \"A Low Distortion Map Between Disk and Square\" (1997)"),
	SAMPLER(stratified, AXIS, "1 on the unit square", "Cook, \"Stochastic Sampling in Computer Graphics\" (1986)"),
	SAMPLER(power, AXIS, "(n + 1) / (2 pi) (axis.w)^n",
		"Lafortune and Willems, \"Using the modified Phong reflectance model\" (1994)"),
	SAMPLER(vmf, AXIS, "k / (4 pi sinh k) exp(k axis.w)", "Jakob, \"Numerically stable sampling of the vMF\" (2012)"),
	SAMPLER(blinn_normal, AXIS, "D(blinn) n.h", "Walter et al., \"Microfacet Models for Refraction\" (2007)"),
	SAMPLER(ggx_normal, AXIS, "D(ggx) n.h", "Walter et al., \"Microfacet Models for Refraction\" (2007)"),
	SAMPLER(ggx_visible_normal, AXIS, "D(ggx) G1(v) max(v.h, 0) / n.v",
		"Dupuy and Benyoub, \"Sampling Visible GGX Normals with Spherical Caps\" (2023)"),
	SAMPLER(phong, MIRRORED, "(n + 1) / (2 pi) (r.l)^n",
		"Lafortune and Willems, \"Using the modified Phong reflectance model\" (1994)"),
	SAMPLER(blinn_phong, HALF, "D(blinn) n.h / (4 v.h)", "Walter et al., \"Microfacet Models for Refraction\" (2007)"),
	SAMPLER(ggx, HALF, "D(ggx) n.h / (4 v.h)", "Walter et al., \"Microfacet Models for Refraction\" (2007)"),
	SAMPLER(ggx_visible, HALF, "D(ggx) G1(v) / (4 n.v)",
		"Dupuy and Benyoub, \"Sampling Visible GGX Normals with Spherical Caps\" (2023)"),
};
// clang-format on

const stilb_numeric_row *stilb_numeric_catalog(size_t *count)
{
	STILB_ASSERT(count);
	*count = sizeof rows / sizeof rows[0];
	return rows;
}

static bool same_name(const char *typed, const char *name)
{
	for (; *typed && *name; typed++, name++)
		if (*typed != *name && !(*typed == '-' && *name == '_'))
			return false;
	return *typed == *name;
}

const stilb_numeric_row *stilb_numeric_catalog_find(const char *name)
{
	STILB_ASSERT(name);
	for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
		if (same_name(name, rows[i].name))
			return &rows[i];
	return NULL;
}

const char *stilb_numeric_measure_text(stilb_numeric_measure measure)
{
	static const char *const texts[] = {
		[STILB_NUMERIC_MEASURE_D] = "integral of D",
		[STILB_NUMERIC_MEASURE_D_COS] = "integral of D n.h",
		[STILB_NUMERIC_MEASURE_REFLECTED] = "integral of f n.l, v = n",
		[STILB_NUMERIC_MEASURE_SMOOTH] = "integral of f n.l, v = n, alpha to 0",
		[STILB_NUMERIC_MEASURE_PDF] = "integral of the density",
	};
	return (unsigned)measure < STILB_NUMERIC_MEASURE_COUNT ? texts[measure] : "unknown";
}

/* ---- measures ---------------------------------------------------------------------------------------------------- */

typedef struct measured {
	const stilb_numeric_row *row;
	const stilb_numeric_shape *shape;
	shade_frame frame; /* its normal is the z axis of the quadrature */
} measured;

static double density_at(const double direction[3], const void *context)
{
	const measured *m = context;
	stilb_vec3 local = stilb_vec3_make((float)direction[0], (float)direction[1], (float)direction[2]);
	stilb_vec3 world = shade_frame_to_world(m->frame, local);
	double cosine = m->row->measure == STILB_NUMERIC_MEASURE_D_COS ? (double)world[2] : 1.0;
	return (double)m->row->density(m->shape, world) * cosine;
}

/* The integrand over half vectors h: the density of the direction that is the view mirrored at h, times the
 * 4 |view.h| by which a solid angle of half vectors grows. Those above the horizon reach all directions. */
static double density_at_mirrored(const double h[3], const void *context)
{
	const measured *m = context;
	double view[3], view_h = 0.0;
	for (int i = 0; i < 3; i++) {
		view[i] = (double)m->shape->view[i];
		view_h += view[i] * h[i];
	}
	if (h[2] <= 0.0)
		return 0.0;
	stilb_vec3 direction;
	for (int i = 0; i < 3; i++)
		direction[i] = (float)(2.0 * view_h * h[i] - view[i]);
	return (double)m->row->density(m->shape, direction) * 4.0 * fabs(view_h);
}

double stilb_numeric_measure_of(const stilb_numeric_row *row, const stilb_numeric_shape *shape)
{
	STILB_ASSERT(row && shape);
	STILB_ASSERT(shape->roughness >= 0.0f && shape->roughness <= 1.0f);
	STILB_ASSERT(shape->anisotropy > -1.0f && shape->anisotropy < 1.0f);
	if (row->kind == STILB_NUMERIC_BRDF) {
		float roughness = row->measure == STILB_NUMERIC_MEASURE_SMOOTH ? 0.0f : shape->roughness;
		shade_brdf_parameters white = stilb_numeric_white(roughness, shape->anisotropy);
		return stilb_numeric_albedo_of_view(&row->model, &white, (stilb_numeric_angles){0.0, 0.0});
	}
	stilb_vec3 view = shape->view, pole = {0.0f, 0.0f, 1.0f};
	if (row->pole == STILB_NUMERIC_POLE_MIRRORED)
		pole = stilb_vec3_make(-view[0], -view[1], view[2]);
	measured m = {row, shape, shade_frame_from_normal(pole)};
	return stilb_numeric_integrate_lobe(row->pole == STILB_NUMERIC_POLE_HALF ? density_at_mirrored : density_at, &m,
	                                    (double)alpha_of(shape));
}

/* ---- energy ------------------------------------------------------------------------------------------------------ */

shade_brdf_parameters stilb_numeric_white(float roughness, float anisotropy)
{
	STILB_ASSERT(roughness >= 0.0f && roughness <= 1.0f);
	return (shade_brdf_parameters){
		.specular = {1.0f, 1.0f, 1.0f}, .roughness = roughness, .anisotropy = anisotropy, .wrap = 1.0f};
}

static bool is_anisotropic(const stilb_numeric_row *row)
{
	return row->model.kind == SHADE_BRDF_MICROFACET && row->model.ndf == SHADE_NDF_GGX_ANISOTROPIC;
}

double stilb_numeric_white_albedo(const stilb_numeric_row *row, float roughness, stilb_numeric_angles angles)
{
	STILB_ASSERT(row->kind == STILB_NUMERIC_BRDF);
	shade_brdf_parameters white =
		stilb_numeric_white(roughness, is_anisotropic(row) ? STILB_NUMERIC_CATALOG_ANISOTROPY : 0.0f);
	double of_view = stilb_numeric_albedo_of_view(&row->model, &white, angles);
	return row->reciprocal ? of_view : fmax(of_view, stilb_numeric_albedo_of_light(&row->model, &white, angles));
}

double stilb_numeric_largest_albedo(const stilb_numeric_row *row)
{
	static const double degrees[] = {0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 85.0, 89.0};
	int azimuths = is_anisotropic(row) ? 2 : 1;
	double largest = 0.0;
	for (int step = 0; step <= 20; step++)
		for (size_t i = 0; i < sizeof degrees / sizeof degrees[0]; i++)
			for (int azimuth = 0; azimuth < azimuths; azimuth++) {
				stilb_numeric_angles angles = {degrees[i] * M_PI / 180.0, azimuth * M_PI / 2.0};
				largest = fmax(largest, stilb_numeric_white_albedo(row, (float)step / 20.0f, angles));
			}
	return largest;
}
