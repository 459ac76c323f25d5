/* What paths scatter: every model of the catalogue through gi_bsdf: its samples, their weights and its density say the
 * same, a white surface gives back what quadrature says, light goes both ways alike, and nothing comes from below the
 * surface. */
#include "support/shade_proof.h"

#include "gi/sample/gi_bsdf.h"
#include "numeric/numeric_catalog.h"
#include "shading/shade_layers.h"

#include <stdio.h>

static const shade_brdf_model lambert = {.kind = SHADE_BRDF_LAMBERT};

/* A normal that leans, so that no axis of the world is an axis of the frame about it. */
static stilb_vec3 test_normal(void)
{
	return stilb_vec3_normalize(stilb_vec3_make(0.3f, 0.8f, -0.5f));
}

static gi_surface make_surface(float diffuse, float specular, float roughness, float anisotropy)
{
	return (gi_surface){.geometric = test_normal(),
	                    .normal = test_normal(),
	                    .diffuse = stilb_vec3_make(diffuse, diffuse, diffuse),
	                    .specular = stilb_vec3_make(specular, specular, specular),
	                    .roughness = roughness,
	                    .anisotropy = anisotropy};
}

/* The direction at the polar angle from the normal, and the azimuth around it from the tangent that gi_bsdf takes. */
static stilb_vec3 direction_at(stilb_numeric_angles angles)
{
	stilb_vec3 n = test_normal();
	shade_frame frame = shade_frame_from_tangent(n, stilb_vec3_make(n[2], 0.0f, -n[0]));
	double sine = sin(angles.polar);
	return shade_frame_to_world(frame, stilb_vec3_make((float)(sine * cos(angles.azimuth)),
	                                                   (float)(sine * sin(angles.azimuth)), (float)cos(angles.polar)));
}

typedef void row_check(const stilb_numeric_row *row);

static void each_brdf(row_check *check)
{
	size_t count, seen = 0;
	const stilb_numeric_row *rows = stilb_numeric_catalog(&count);
	for (size_t i = 0; i < count; i++)
		if (rows[i].kind == STILB_NUMERIC_BRDF && rows[i].model.kind != SHADE_BRDF_WRAPPED) {
			check(&rows[i]);
			seen++;
		}
	assert_true(seen > 30);
}

/* ---- samples ----------------------------------------------------------------------------------------------------- */

typedef struct estimate {
	double sum, sum2, largest;
	int count;
} estimate;

static void estimate_add(estimate *to, double value)
{
	to->sum += value;
	to->sum2 += value * value;
	to->largest = fmax(to->largest, value);
	to->count++;
}

static double estimate_mean(const estimate *of)
{
	return of->sum / of->count;
}

static double estimate_sigma(const estimate *of)
{
	double mean = estimate_mean(of);
	return sqrt(fmax(of->sum2 / of->count - mean * mean, 0.0) / of->count);
}

static bool draw(const gi_bsdf *bsdf, shade_proof_random *random, gi_bsdf_sample *chosen)
{
	float u_lobe = shade_proof_uniform(random);
	stilb_vec2 u = {shade_proof_uniform(random), shade_proof_uniform(random)};
	return gi_bsdf_sample_direction(bsdf, u_lobe, u, chosen);
}

/* A highlight alone, F0 = 1, under light from everywhere: the mean weight is the albedo. */
static void check_furnace(const stilb_numeric_row *row)
{
	static const float roughnesses[] = {0.15f, 0.5f, 1.0f};
	static const double polars[] = {0.0, 0.8, 1.4};
	shade_proof_random random = {.seed = 3};
	for (int r = 0; r < 3; r++)
		for (int p = 0; p < 3; p++) {
			stilb_numeric_angles view = {polars[p], 0.7};
			float anisotropy = row->model.ndf == SHADE_NDF_GGX_ANISOTROPIC ? 0.4f : 0.0f;
			gi_surface surface = make_surface(0.0f, 1.0f, roughnesses[r], anisotropy);
			if (row->model.kind == SHADE_BRDF_LAMBERT)
				surface.diffuse = surface.specular;
			gi_bsdf bsdf;
			gi_bsdf_make(&row->model, &surface, direction_at(view), &bsdf);
			estimate albedo = {0};
			for (int i = 0; i < 2000; i++) {
				gi_bsdf_sample chosen;
				estimate_add(&albedo, draw(&bsdf, &random, &chosen) ? (double)chosen.weight[0] : 0.0);
			}
			shade_brdf_parameters white = stilb_numeric_white(roughnesses[r], anisotropy);
			double truth = stilb_numeric_albedo_of_view(&row->model, &white, view);
			double off = fabs(estimate_mean(&albedo) - truth);
			if (!(off <= 4.5 * estimate_sigma(&albedo) + 1e-3))
				fail_msg("%s, roughness %g, %g rad: albedo %.4f, not %.4f: %.1f sigma", row->name,
				         (double)roughnesses[r], polars[p], estimate_mean(&albedo), truth,
				         off / estimate_sigma(&albedo));
			/* A mirror's weight is 1: no sample is so much brighter that it would be a firefly. */
			if (row->conserving && !(albedo.largest <= 8.0))
				fail_msg("%s, roughness %g, %g rad: a weight of %g", row->name, (double)roughnesses[r], polars[p],
				         albedo.largest);
		}
}

static void white_surfaces_give_back_their_albedo(void **state)
{
	(void)state;
	each_brdf(check_furnace);
}

/* Of a diffuse surface with a highlight: weight x density is the BSDF, and what divides by the density integrates: the
 * mean of cos / pdf over the samples is the integral of cos, pi. */
static void check_samples(const stilb_numeric_row *row)
{
	shade_proof_random random = {.seed = 5};
	estimate projected = {0};
	gi_surface surface = make_surface(0.4f, 0.5f, 0.4f, 0.3f);
	gi_bsdf bsdf;
	gi_bsdf_make(&row->model, &surface, direction_at((stilb_numeric_angles){0.9, 2.0}), &bsdf);
	for (int i = 0; i < 4000; i++) {
		gi_bsdf_sample chosen;
		if (!draw(&bsdf, &random, &chosen)) {
			estimate_add(&projected, 0.0);
			continue;
		}
		stilb_vec3 want = gi_bsdf_cos(&bsdf, chosen.direction);
		SHADE_PROOF_NEAR(chosen.weight[0] * chosen.pdf, want[0], 1e-4, 1e-7);
		SHADE_PROOF_NEAR(gi_bsdf_pdf(&bsdf, chosen.direction), chosen.pdf, 1e-3, 1e-6);
		estimate_add(&projected, (double)(stilb_vec3_dot(test_normal(), chosen.direction) / chosen.pdf));
	}
	SHADE_PROOF_NEAR(estimate_mean(&projected), M_PI, 0.0, 4.5 * estimate_sigma(&projected) + 1e-4);
}

static void samples_weights_and_densities_agree(void **state)
{
	(void)state;
	each_brdf(check_samples);
}

/* The weight of a diffuse surface's sample is its reflectance without rounding. So the picture of a furnace (walls that
 * shine and reflect diffusely) is exact to the last bounce. */
static void diffuse_weights_are_the_reflectance(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 9};
	gi_surface surface = make_surface(0.37f, 0.0f, 0.5f, 0.0f);
	gi_bsdf bsdf;
	gi_bsdf_make(&lambert, &surface, test_normal(), &bsdf);
	for (int i = 0; i < 1000; i++) {
		gi_bsdf_sample chosen;
		if (!draw(&bsdf, &random, &chosen))
			continue;
		assert_true(chosen.weight[0] == 0.37f);
		SHADE_PROOF_NEAR(stilb_vec3_dot(chosen.direction, chosen.direction), 1.0, 1e-6, 0.0);
	}
}

/* ---- symmetry and sides ------------------------------------------------------------------------------------------ */

static void check_reciprocity(const stilb_numeric_row *row)
{
	shade_proof_random random = {.seed = 11};
	double largest = 0.0;
	for (int i = 0; i < 300; i++) {
		/* A Fresnel term takes of diffuse light by the viewer's angle alone. */
		bool takes = row->model.kind == SHADE_BRDF_MICROFACET && row->model.f != SHADE_F_NONE;
		gi_surface surface = make_surface(takes ? 0.0f : 0.3f, 0.6f, shade_proof_range(&random, 0.1f, 1.0f), 0.3f);
		stilb_vec3 v = shade_proof_random_above(&random, test_normal());
		stilb_vec3 l = shade_proof_random_above(&random, test_normal());
		gi_bsdf to_v, to_l;
		gi_bsdf_make(&row->model, &surface, v, &to_v);
		gi_bsdf_make(&row->model, &surface, l, &to_l);
		double there = (double)(gi_bsdf_cos(&to_v, l)[0] / stilb_vec3_dot(test_normal(), l));
		double back = (double)(gi_bsdf_cos(&to_l, v)[0] / stilb_vec3_dot(test_normal(), v));
		largest = fmax(largest, fabs(there - back) / fmax(there, back));
	}
	if (row->reciprocal ? largest > 2e-4 : largest < 0.1)
		fail_msg("%s: the two ways differ by %g of the larger", row->name, largest);
}

static void reciprocal_models_stay_reciprocal(void **state)
{
	(void)state;
	each_brdf(check_reciprocity);
}

/* Where the shading normal leans away from the triangle's, samples are above the planes of both. */
static void nothing_comes_from_below(void **state)
{
	(void)state;
	shade_brdf_model ggx = stilb_numeric_catalog_find("ggx_smith_ggx")->model;
	shade_proof_random random = {.seed = 13};
	int below = 0;
	for (int i = 0; i < 5000; i++) {
		gi_surface surface = make_surface(0.5f, 0.3f, 0.8f, 0.0f);
		surface.geometric = stilb_vec3_normalize(test_normal() + shade_proof_random_direction(&random) * 0.5f);
		stilb_vec3 v = shade_proof_random_above(&random, surface.geometric);
		gi_bsdf bsdf;
		gi_bsdf_make(i % 2 ? &ggx : &lambert, &surface, v, &bsdf);
		stilb_vec3 l = shade_proof_random_direction(&random), f = gi_bsdf_cos(&bsdf, l);
		if (stilb_vec3_dot(l, surface.geometric) <= 0.0f || stilb_vec3_dot(l, surface.normal) <= 0.0f)
			assert_true(f[0] == 0.0f && f[1] == 0.0f && f[2] == 0.0f);
		else
			SHADE_PROOF_LIGHT(f[0]);
		gi_bsdf_sample chosen;
		if (!draw(&bsdf, &random, &chosen)) {
			below++;
			continue;
		}
		assert_true(stilb_vec3_dot(chosen.direction, surface.geometric) > 0.0f);
		assert_true(chosen.pdf > 0.0f);
		SHADE_PROOF_LIGHT(chosen.weight[0]);
	}
	assert_in_range(below, 100, 2500);
}

/* ---- layers ------------------------------------------------------------------------------------------------------ */

static const shade_brdf_model ggx_schlick = {
	.kind = SHADE_BRDF_MICROFACET, .ndf = SHADE_NDF_GGX, .g = SHADE_G_SMITH_GGX, .f = SHADE_F_SCHLICK};

/* A surface with layers: what is 0 is not there. */
typedef struct layers_row {
	const char *name;
	float diffuse, specular, roughness, coat, coat_roughness, sheen, sheen_roughness, anisotropy;
	float through, ior; /* ior > 0: of a volume */
	bool inside;        /* of the volume is the viewer */
	bool leans;         /* the coat has a normal of its own */
} layers_row;

static const layers_row layers_rows[] = {
	{.name = "none", .diffuse = 0.5f, .specular = 0.3f, .roughness = 0.4f},
	{.name = "coat", .diffuse = 0.5f, .specular = 0.04f, .roughness = 0.6f, .coat = 1.0f, .coat_roughness = 0.3f},
	{.name = "half a coat that leans",
     .diffuse = 0.5f,
     .specular = 0.04f,
     .roughness = 0.6f,
     .coat = 0.5f,
     .coat_roughness = 0.5f,
     .leans = true},
	{.name = "a coat alone that leans", .roughness = 0.5f, .coat = 1.0f, .coat_roughness = 0.5f, .leans = true},
	{.name = "sheen", .diffuse = 0.6f, .roughness = 1.0f, .sheen = 0.9f, .sheen_roughness = 0.4f},
	{.name = "smooth sheen alone", .roughness = 1.0f, .sheen = 1.0f, .sheen_roughness = 0.2f},
	{.name = "brushed", .specular = 0.9f, .roughness = 0.4f, .anisotropy = 0.8f},
	{.name = "all",
     .diffuse = 0.3f,
     .specular = 0.5f,
     .roughness = 0.5f,
     .coat = 0.8f,
     .coat_roughness = 0.4f,
     .sheen = 0.5f,
     .sheen_roughness = 0.6f,
     .anisotropy = 0.6f},
	{.name = "thin wall", .diffuse = 0.2f, .specular = 0.1f, .roughness = 0.5f, .through = 0.7f},
	{.name = "coated thin wall",
     .specular = 0.04f,
     .roughness = 0.6f,
     .coat = 0.6f,
     .coat_roughness = 0.5f,
     .sheen = 0.3f,
     .sheen_roughness = 0.5f,
     .through = 1.0f},
	{.name = "into glass", .diffuse = 0.1f, .specular = 0.04f, .roughness = 0.6f, .through = 0.9f, .ior = 1.5f},
	{.name = "out of glass", .specular = 0.04f, .roughness = 0.6f, .through = 1.0f, .ior = 1.5f, .inside = true},
	{.name = "out of thick glass", .specular = 0.2f, .roughness = 0.7f, .through = 1.0f, .ior = 2.6f, .inside = true},
	{.name = "into a coated volume",
     .specular = 0.02f,
     .roughness = 0.5f,
     .coat = 1.0f,
     .coat_roughness = 0.4f,
     .through = 1.0f,
     .ior = 1.33f},
};
#define LAYERS_ROWS (sizeof layers_rows / sizeof *layers_rows)

static gi_surface layered_surface(const layers_row *row)
{
	gi_surface surface = make_surface(row->diffuse, row->specular, row->roughness, 0.0f);
	stilb_vec3 lean = row->leans ? stilb_vec3_make(0.3f, 0.0f, 0.2f) : (stilb_vec3){0};
	surface.layered = true;
	surface.layers = (gi_layers){.coat_normal = stilb_vec3_normalize(test_normal() + lean),
	                             .sheen = stilb_vec3_make(row->sheen, 0.5f * row->sheen, 0.0f),
	                             .brushed = stilb_vec3_make(0.2f, 0.4f, 0.9f),
	                             .coat = row->coat,
	                             .coat_roughness = row->coat_roughness,
	                             .sheen_roughness = row->sheen_roughness,
	                             .anisotropy = row->anisotropy,
	                             .roughness = row->roughness,
	                             .through = stilb_vec3_make(row->through, 0.5f * row->through, row->through),
	                             .solid = row->ior > 0.0f,
	                             .ior = row->ior};
	surface.front = !row->inside;
	return surface;
}

/* Layers from the inside to the outside, as the head of shade_layers.h has them, of the same functions. */
static stilb_vec3 layers_wanted(const gi_surface *s, stilb_vec3 l, stilb_vec3 v)
{
	const gi_layers *layers = &s->layers;
	stilb_vec3 n = s->normal;
	shade_brdf_model model = ggx_schlick;
	shade_brdf_parameters p = {.specular = s->specular, .roughness = s->roughness};
	shade_frame frame = shade_frame_from_tangent(n, layers->brushed);
	if (layers->anisotropy > 0.0f) {
		stilb_vec2 brushed = shade_gltf_brushed(s->roughness, layers->anisotropy);
		model.ndf = SHADE_NDF_GGX_ANISOTROPIC;
		p.roughness = brushed[0];
		p.anisotropy = brushed[1];
	}
	float share = shade_coat_share(layers->coat, stilb_vec3_dot(layers->coat_normal, v));
	float left = shade_sheen_left(layers->sheen, stilb_vec3_dot(n, v), layers->sheen_roughness);
	if (stilb_vec3_dot(n, l) <= 0.0f)
		return layers->through * (shade_thin_cos(s->specular, s->roughness, n, l, v) * left * (1.0f - share));
	stilb_vec3 b = s->diffuse * (stilb_vec3_dot(n, l) * (float)M_1_PI);
	if (p.specular[0] > 0.0f) /* a base that reflects nothing straight ahead has no highlight */
		b = b * shade_brdf_diffuse_left(model, stilb_vec3_dot(n, v), s->roughness) +
		    shade_brdf_cos(model, p, frame, l, v);
	stilb_vec3 up = b * left + layers->sheen * shade_sheen_cos(layers->sheen_roughness, n, l, v);
	return up * (1.0f - share) + share * shade_coat_cos(layers->coat_roughness, layers->coat_normal, l, v);
}

static void layers_are_as_the_header_says(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 17};
	for (size_t r = 0; r < LAYERS_ROWS; r++)
		for (int i = 0; i < 400 && layers_rows[r].ior == 0.0f; i++) {
			gi_surface surface = layered_surface(&layers_rows[r]);
			stilb_vec3 v = shade_proof_random_above(&random, test_normal());
			stilb_vec3 l = shade_proof_random_direction(&random);
			gi_bsdf bsdf;
			gi_bsdf_make(&ggx_schlick, &surface, v, &bsdf);
			stilb_vec3 got = gi_bsdf_cos(&bsdf, l), wanted = layers_wanted(&surface, l, v);
			for (int c = 0; c < 3; c++)
				SHADE_PROOF_NEAR(got[c], wanted[c], 1e-3, 1e-6);
		}
}

/* Samples, weights and densities say the same, and the density is 1 over the sphere: the mean over the samples of a
 * known function over the density is its integral. */
static void layers_are_sampled_as_their_density_says(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 19};
	for (size_t r = 0; r < LAYERS_ROWS; r++) {
		gi_surface surface = layered_surface(&layers_rows[r]);
		gi_bsdf bsdf;
		gi_bsdf_make(&ggx_schlick, &surface, direction_at((stilb_numeric_angles){0.9, 2.0}), &bsdf);
		estimate density = {0}, sampled = {0}, even = {0}, kept = {0};
		for (int i = 0; i < 40000; i++) {
			stilb_vec3 l = shade_proof_random_direction(&random);
			estimate_add(&density, 4.0 * M_PI * (double)gi_bsdf_pdf(&bsdf, l));
			estimate_add(&even, 4.0 * M_PI * (double)gi_bsdf_cos(&bsdf, l)[0]);
			gi_bsdf_sample chosen;
			bool some = draw(&bsdf, &random, &chosen);
			estimate_add(&kept, some ? 1.0 : 0.0);
			if (!some) {
				estimate_add(&sampled, 0.0);
				continue;
			}
			SHADE_PROOF_NEAR(chosen.weight[0] * chosen.pdf, gi_bsdf_cos(&bsdf, chosen.direction)[0], 1e-3, 1e-6);
			SHADE_PROOF_NEAR(gi_bsdf_pdf(&bsdf, chosen.direction), chosen.pdf, 1e-3, 1e-6);
			estimate_add(&sampled, (double)chosen.weight[0]);
		}
		/* Into a volume other lobes send nothing, and facets may reflect all: such choices are no directions. */
		double whole = layers_rows[r].ior > 0.0f ? estimate_mean(&kept) : 1.0;
		if (fabs(estimate_mean(&density) - whole) > 4.5 * hypot(estimate_sigma(&density), estimate_sigma(&kept)))
			fail_msg("%s: the density is %g in all, +- %g", layers_rows[r].name, estimate_mean(&density),
			         estimate_sigma(&density));
		double off = fabs(estimate_mean(&sampled) - estimate_mean(&even));
		if (off > 4.5 * hypot(estimate_sigma(&sampled), estimate_sigma(&even)))
			fail_msg("%s: %g by samples, %g by even directions", layers_rows[r].name, estimate_mean(&sampled),
			         estimate_mean(&even));
		if (sampled.largest > 12.0)
			fail_msg("%s: a weight of %g", layers_rows[r].name, sampled.largest);
	}
}

/* Snell's law and Fresnel's share on both sides of smooth glass, and nothing goes through under total reflection. */
static void smooth_glass_refracts(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 29};
	for (int i = 0; i < 64; i++) {
		bool inside = i & 1;
		double polar = 0.02 + 1.5 * (i >> 1) / 32.0, ior = 1.5, eta = inside ? ior : 1.0 / ior;
		layers_row row = {.specular = 0.04f, .through = 1.0f, .ior = (float)ior, .inside = inside};
		gi_surface surface = layered_surface(&row);
		surface.layers.through = stilb_vec3_make(1.0f, 1.0f, 1.0f);
		stilb_vec3 v = direction_at((stilb_numeric_angles){polar, 0.7}), n = test_normal();
		gi_bsdf bsdf;
		gi_bsdf_make(&ggx_schlick, &surface, v, &bsdf);
		double sine = eta * sin(polar), share = 1.0;
		if (sine < 1.0)
			share = 0.04 + 0.96 * pow(1.0 - (inside ? sqrt(1.0 - sine * sine) : cos(polar)), 5);
		estimate back = {0}, on = {0};
		int far = 0; /* GGX has a few facets that lean much, however smooth it is */
		for (int k = 0; k < 4000; k++) {
			gi_bsdf_sample chosen;
			bool some = draw(&bsdf, &random, &chosen), beyond = some && stilb_vec3_dot(chosen.direction, n) < 0.0f;
			estimate_add(&back, some && !beyond ? (double)chosen.weight[0] : 0.0);
			estimate_add(&on, beyond ? (double)chosen.weight[0] : 0.0);
			if (!beyond)
				continue;
			stilb_vec3 across = chosen.direction - n * stilb_vec3_dot(chosen.direction, n);
			bool there = fabs((double)stilb_vec3_dot(across, across) - sine * sine) < 0.05 * sine * sine + 1e-3;
			far += !there || stilb_vec3_dot(across, v) > 1e-3f; /* to the other side of the normal */
		}
		assert_in_range(far, 0, 40);
		if (fabs(sine - 1.0) < 0.05 || polar > 1.4)
			continue; /* where facets of this roughness are not all alike */
		SHADE_PROOF_NEAR(estimate_mean(&back), share, 0.0, 4.5 * estimate_sigma(&back) + 5e-3);
		SHADE_PROOF_NEAR(estimate_mean(&on), 1.0 - share, 0.0, 4.5 * estimate_sigma(&on) + 5e-3);
	}
}

/* Under light from everywhere nothing that is white gives back more than arrives, but for the fit of sheen's albedo. */
static void layers_make_no_light(void **state)
{
	(void)state;
	static const double polars[] = {0.0, 0.6, 1.1, 1.4, 1.5};
	shade_proof_random random = {.seed = 23};
	for (int i = 0; i < 60; i++) {
		layers_row row = {.specular = shade_proof_range(&random, 0.0f, 1.0f),
		                  .roughness = shade_proof_range(&random, 0.2f, 1.0f),
		                  .coat = shade_proof_range(&random, 0.0f, 1.0f),
		                  .coat_roughness = shade_proof_range(&random, 0.0f, 1.0f),
		                  .sheen = shade_proof_range(&random, 0.0f, 1.0f),
		                  .sheen_roughness = shade_proof_range(&random, 0.0f, 1.0f),
		                  .anisotropy = shade_proof_range(&random, 0.0f, 0.9f)};
		if (i % 2)
			row.through = 1.0f;
		if (i % 4 == 3) {
			row.ior = shade_proof_range(&random, 1.0f, 3.0f);
			row.inside = i % 8 == 7;
		}
		gi_surface surface = layered_surface(&row);
		gi_bsdf bsdf;
		gi_bsdf_make(&ggx_schlick, &surface, direction_at((stilb_numeric_angles){polars[i % 5], 0.7}), &bsdf);
		estimate albedo = {0};
		for (int k = 0; k < 4000; k++) {
			gi_bsdf_sample chosen;
			estimate_add(&albedo, draw(&bsdf, &random, &chosen) ? (double)chosen.weight[0] : 0.0);
		}
		if (estimate_mean(&albedo) > 1.001 + 4.5 * estimate_sigma(&albedo))
			fail_msg("%d: %g rad: albedo %g", i, polars[i % 5], estimate_mean(&albedo));
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(white_surfaces_give_back_their_albedo),
		cmocka_unit_test(samples_weights_and_densities_agree),
		cmocka_unit_test(diffuse_weights_are_the_reflectance),
		cmocka_unit_test(reciprocal_models_stay_reciprocal),
		cmocka_unit_test(nothing_comes_from_below),
		cmocka_unit_test(layers_are_as_the_header_says),
		cmocka_unit_test(layers_are_sampled_as_their_density_says),
		cmocka_unit_test(smooth_glass_refracts),
		cmocka_unit_test(layers_make_no_light),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
