/* shade_brdf.h and what it is made of and used by (shade_frame.h, shade_diffuse.h, shade_energy.h, shade_surface.h)
 * against the same formulas in double, and by their properties. */

#include "shading/shade_brdf.h"
#include "shading/shade_energy.h"
#include "shading/shade_surface.h"

#include "numeric/numeric_dfg.h"
#include "numeric/numeric_quadrature.h"
#include "support/shade_proof.h"
#include "support/shade_reference.h"

#define MODEL_COUNT (SHADE_BRDF_COUNT - 1 + SHADE_NDF_COUNT * SHADE_G_COUNT * SHADE_F_COUNT)

/* Model number index: first every kind of model once, then every combination of D, G and F (shade_specular.h). */
static shade_brdf_model model_of(int index)
{
	int rest = index - (SHADE_BRDF_COUNT - 1);
	if (rest < 0)
		return (shade_brdf_model){.kind = index};
	return (shade_brdf_model){SHADE_BRDF_MICROFACET, rest % SHADE_NDF_COUNT, rest / SHADE_NDF_COUNT % SHADE_G_COUNT,
	                          rest / SHADE_NDF_COUNT / SHADE_G_COUNT};
}

static shade_frame random_frame(shade_proof_random *random)
{
	stilb_vec3 n = shade_proof_random_direction(random);
	return shade_frame_from_tangent(n, shade_proof_random_direction(random));
}

/* ---- exactness -------------------------------------------------------------------------------------------------- */

static void frame_is_orthonormal(shade_frame f, double bound)
{
	stilb_vec3 n = stilb_vec3_cross(f.t, f.b);
	SHADE_PROOF_NEAR(stilb_vec3_dot(f.t, f.t), 1.0, bound, 0.0);
	SHADE_PROOF_NEAR(stilb_vec3_dot(f.b, f.b), 1.0, bound, 0.0);
	SHADE_PROOF_NEAR(stilb_vec3_dot(f.t, f.b), 0.0, 0.0, bound);
	SHADE_PROOF_NEAR3(n, f.n[0], f.n[1], f.n[2], 0.0, bound);
}

static void frames_stand_on_their_normal(void **state)
{
	(void)state;
	static const stilb_vec3 poles[] = {{0.0f, 0.0f, 1.0f},  {0.0f, 0.0f, -1.0f}, {1.0f, 0.0f, 0.0f},
	                                   {1.0f, 0.0f, -0.0f}, {0.0f, -1.0f, 0.0f}, {1e-4f, 0.0f, -1.0f}};
	shade_proof_random random = {.seed = 51};
	for (size_t i = 0; i < sizeof poles / sizeof poles[0]; i++)
		frame_is_orthonormal(shade_frame_from_normal(poles[i]), 5e-7);
	for (int i = 0; i < 1000; i++) {
		stilb_vec3 n = shade_proof_random_direction(&random), w = shade_proof_random_direction(&random) * 7.0f;
		stilb_vec3 across = stilb_vec3_cross(n, w);
		shade_frame any = shade_frame_from_normal(n), along = shade_frame_from_tangent(n, w);
		stilb_vec3 local = shade_frame_to_local(any, w), back = shade_frame_to_world(any, local);
		double bound = 3.5e-6 / sqrt((double)stilb_vec3_dot(across, across));
		frame_is_orthonormal(any, 5e-7);
		frame_is_orthonormal(along, bound);
		SHADE_PROOF_NEAR(stilb_vec3_dot(along.b, w), 0.0, 0.0, 7.0 * bound);
		assert_true(stilb_vec3_dot(along.t, w) > 0.0f);
		SHADE_PROOF_NEAR3(back, w[0], w[1], w[2], 0.0, 1e-5);
		SHADE_PROOF_NEAR3(local, stilb_vec3_dot(any.t, w), stilb_vec3_dot(any.b, w), stilb_vec3_dot(n, w), 0.0, 1e-5);
	}
	stilb_vec3 n = {0.6f, 0.0f, 0.8f}, across = {0.8f, 0.0f, -0.6f}, other = {0.0f, 1.0f, 0.0f};
	/* Of any length, a tangent 0.12 degrees from the normal has a direction, and one 0.03 degrees from it has none. */
	for (float length = 1e-3f; length < 1e4f; length *= 1e3f) {
		shade_frame along = shade_frame_from_tangent(n, (n + other * 2e-3f) * length);
		SHADE_PROOF_NEAR3(along.t, other[0], other[1], other[2], 0.0, 1e-4);
		shade_frame any = shade_frame_from_normal(n),
					too_near = shade_frame_from_tangent(n, (n + across * 5e-4f) * length);
		assert_true(too_near.t[0] == any.t[0] && too_near.t[1] == any.t[1] && too_near.t[2] == any.t[2]);
	}
	frame_is_orthonormal(shade_frame_from_tangent(n, n), 5e-7);
	frame_is_orthonormal(shade_frame_from_tangent(n, stilb_vec3_make(0.0f, 0.0f, 0.0f)), 5e-7);
}

static void diffuse_has_its_formulas(void **state)
{
	(void)state;
	SHADE_PROOF_NEAR3(shade_lambert(stilb_vec3_make(0.2f, 0.7f, 1.0f)), 0.2 / M_PI, 0.7 / M_PI, 1.0 / M_PI, 1e-6, 0.0);
	for (double w = 0.0; w <= 1.0; w += 0.25)
		for (double c = -1.0; c <= 1.0; c += 0.125)
			SHADE_PROOF_NEAR(shade_wrapped((float)c, (float)w), fmax(c + w, 0.0) / ((1.0 + w) * (1.0 + w) * M_PI), 1e-6,
			                 0.0);
}

/* Checks the limited diffuse and specular reflectances d and s: if their sum is above 1, both are scaled so that it is
 * 1. */
static void limited_as_one(float d, float s)
{
	shade_reflectance limited = shade_limit_to_one(stilb_vec3_make(d, 0.0f, s), stilb_vec3_make(s, 0.0f, d));
	double total = fmax((double)d, 0.0) + fmax((double)s, 0.0), scale = total > 1.0 ? 1.0 / total : 1.0;
	SHADE_PROOF_NEAR(limited.diffuse[0], fmax((double)d, 0.0) * scale, 0.0, 1.5e-7);
	SHADE_PROOF_NEAR(limited.specular[0], fmax((double)s, 0.0) * scale, 0.0, 1.5e-7);
	for (int k = 0; k < 3; k++) {
		assert_true(limited.diffuse[k] >= 0.0f && limited.specular[k] >= 0.0f);
		float sum = limited.diffuse[k] + limited.specular[k]; /* as a float, rounded */
		assert_true(sum <= 1.0f);
	}
}

static void materials_are_limited_to_one(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 52};
	for (int i = 0; i < 3000; i++) {
		float high = i % 3 == 0 ? 1.0f : i % 3 == 1 ? 4.0f : 1e6f;
		float d = shade_proof_range(&random, -0.2f * high, high), s = shade_proof_range(&random, -0.2f * high, high);
		limited_as_one(d, s);
	}
	shade_reflectance kept = shade_limit_to_one(stilb_vec3_make(0.5f, 0.0f, 1.0f), stilb_vec3_make(0.25f, 1.0f, 0.0f));
	SHADE_PROOF_NEAR3(kept.diffuse, 0.5, 0.0, 1.0, 0.0, 0.0);
	SHADE_PROOF_NEAR3(kept.specular, 0.25, 1.0, 0.0, 0.0, 0.0);
	/* A small share beside a large one keeps its digits. */
	kept = shade_limit_to_one(stilb_vec3_make(1e-5f, 2.0f, 0.0f), stilb_vec3_make(2.0f, 1e-5f, 0.0f));
	SHADE_PROOF_NEAR(kept.diffuse[0], 5e-6 / 1.000005, 1e-6, 0.0);
	SHADE_PROOF_NEAR(kept.specular[1], 5e-6 / 1.000005, 1e-6, 0.0);
}

static void brdf_is_near(shade_brdf_model model, shade_brdf_parameters p, const shade_frame *frame, stilb_vec3 l,
                         stilb_vec3 v)
{
	stilb_vec3 got = shade_brdf_cos(model, p, *frame, l, v);
	for (int k = 0; k < 3; k++) {
		double want = reference_brdf_cos(model, p, k, frame, l, v);
		double difference = fabs((double)got[k] - want);
		if (!(difference <= fmax(5e-5 * want, 2e-6)))
			fail_msg("kind %d, D %d, G %d, F %d, roughness %g: %.9g instead of %.9g", model.kind, model.ndf, model.g,
			         model.f, (double)p.roughness, (double)got[k], want);
	}
}

/* All 103 models, directions in and out of their lobes. Below a roughness of 0.3 the angles of float vectors are too
 * coarse for an error of 5e-5: test_shade_specular.c has the narrow lobes. */
static void every_model_has_its_formula(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 53};
	for (int index = 0; index < MODEL_COUNT; index++)
		for (int i = 0; i < 60; i++) {
			shade_frame frame = random_frame(&random);
			stilb_vec3 l = shade_proof_random_above(&random, frame.n), v = shade_proof_random_above(&random, frame.n);
			if (i % 2)
				v = stilb_vec3_normalize(2.0f * stilb_vec3_dot(frame.n, l) * frame.n - l + 0.3f * v);
			if (i % 10 == 0)
				l = -l;
			shade_brdf_parameters p = {.specular = shade_proof_random_color(&random, 0.99f),
			                           .roughness = shade_proof_range(&random, 0.3f, 1.0f),
			                           .anisotropy = shade_proof_range(&random, -0.7f, 0.7f),
			                           .wrap = shade_proof_uniform(&random)};
			if (stilb_vec3_dot(l, v) > -0.99f) /* the half vector of nearly opposite ones is rounding */
				brdf_is_near(model_of(index), p, &frame, l, v);
		}
}

/* The sun at an angle, seen in mirror reflection: the half vector is the normal, so that the power in the highlight is
 * 1 and its constant factor alone is left. */
static void surface_has_its_closed_form(void **state)
{
	(void)state;
	shade_brdf_model model = {.kind = SHADE_BRDF_BLINN_PHONG_MODIFIED};
	shade_material material = {.diffuse = {0.5f, 0.2f, 0.0f}, .specular = {0.1f, 0.3f, 0.6f}, .wrap = 0.0f};
	double a = 0.6, alpha = 0.2, n = 2.0 / (alpha * alpha) - 2.0;
	material.roughness = (float)sqrt(alpha);
	shade_sun sun = {{(float)sin(a), (float)cos(a), 0.0f}, {3.0f, 2.0f, 1.0f}};
	shade_sky sky = {{0.2f, 0.3f, 0.4f}, {9.0f, 9.0f, 9.0f}};
	stilb_vec3 v = {-(float)sin(a), (float)cos(a), 0.0f};
	shade_frame frame = shade_frame_from_normal(stilb_vec3_make(0.0f, 1.0f, 0.0f));
	stilb_vec3 radiance = shade_surface_radiance(model, material, sun, sky, frame, v);
	for (int k = 0; k < 3; k++) {
		double diffuse = (double)material.diffuse[k],
			   factor = (n + 2.0) * (n + 4.0) / (8.0 * M_PI * (exp2(-n / 2.0) + n));
		double brdf = diffuse / M_PI + (double)material.specular[k] * factor;
		double want = brdf * (double)sun.irradiance[k] * cos(a) + diffuse * (double)sky.sky[k];
		SHADE_PROOF_NEAR(radiance[k], want, 3e-6, 0.0);
	}
}

/* Diffuse light alone for the two diffuse kinds, diffuse light and highlight for the others. */
static void surface_adds_what_its_kind_says(void **state)
{
	(void)state;
	shade_material material = {
		.diffuse = {0.5f, 0.2f, 0.1f}, .specular = {0.1f, 0.3f, 0.6f}, .roughness = 0.5f, .wrap = 0.5f};
	shade_brdf_parameters p = {.specular = material.specular, .roughness = 0.5f, .wrap = 0.5f};
	shade_frame frame = shade_frame_from_normal(stilb_vec3_make(0.0f, 0.0f, 1.0f));
	stilb_vec3 l = {0.6f, 0.0f, 0.8f}, v = {0.0f, 0.6f, 0.8f};
	for (int kind = 0; kind < SHADE_BRDF_COUNT; kind++) {
		shade_brdf_model model = {kind, SHADE_NDF_GGX, SHADE_G_SMITH_GGX, SHADE_F_SCHLICK};
		stilb_vec3 got = shade_surface_brdf_cos(model, material, frame, l, v);
		for (int k = 0; k < 3; k++) {
			double even = kind == SHADE_BRDF_LAMBERT ? 0.8 / M_PI : 1.3 / (2.25 * M_PI);
			double highlight = kind == SHADE_BRDF_LAMBERT || kind == SHADE_BRDF_WRAPPED
			                       ? 0.0
			                       : reference_brdf_cos(model, p, k, &frame, l, v);
			SHADE_PROOF_NEAR(got[k], even * (double)material.diffuse[k] + highlight, 1e-5, 0.0);
		}
	}
}

static void surface_turned_away_sees_only_the_sky(void **state)
{
	(void)state;
	shade_brdf_model model = {.kind = SHADE_BRDF_BLINN_PHONG_MODIFIED};
	shade_material material = {.diffuse = {0.5f, 0.5f, 0.5f}, .specular = {0.5f, 0.5f, 0.5f}, .roughness = 0.6f};
	shade_sun sun = {{0.0f, -1.0f, 0.0f}, {5.0f, 5.0f, 5.0f}};
	shade_sky dark = {.sky = {0.0f}}, sky = {.sky = {1.0f, 1.0f, 1.0f}};
	shade_frame frame = shade_frame_from_normal(stilb_vec3_make(0.0f, 1.0f, 0.0f));
	/* v = n: l = -v leaves no half vector, and nothing becomes NaN. */
	SHADE_PROOF_NEAR3(shade_surface_radiance(model, material, sun, dark, frame, frame.n), 0.0, 0.0, 0.0, 0.0, 0.0);
	SHADE_PROOF_NEAR3(shade_surface_radiance(model, material, sun, sky, frame, frame.n), 0.5, 0.5, 0.5, 1e-6, 0.0);
	/* A normal that rounding made longer than 1 sees no negative share of the sky. */
	frame.n = stilb_vec3_make(0.0f, -1.0005f, 0.0f);
	sun.direction[1] = 1.0f;
	SHADE_PROOF_NEAR3(shade_surface_radiance(model, material, sun, sky, frame, frame.n), 0.0, 0.0, 0.0, 0.0, 0.0);
}

/* In double. */
static void what_highlights_leave_has_its_formula(void **state)
{
	(void)state;
	for (int i = 0; i <= 20; i++)
		for (int k = 0; k <= 20; k++) {
			double c = pow(k / 20.0, 2), r = 0.0317 + 0.9683 * i / 20, width = r * (0.376 + r * (1.064 - 1.442 * r));
			double share = 1 - sqrt((c * c + width * width) / (1 + width * width));
			double most = exp(r * (0.737 - r * (4.148 + 0.539 * r))), power = 5 - r * (1.8 + 1.593 * r);
			SHADE_PROOF_NEAR(shade_diffuse_left((float)c, (float)r), 1 - most * pow(fmax(share, 1e-9), power), 0.0,
			                 3e-6);
		}
	SHADE_PROOF_NEAR(shade_diffuse_left(1.0f, 0.0f), 1.0, 0.0, 1e-6);
	SHADE_PROOF_NEAR(shade_diffuse_left(0.0f, 0.0f), 0.0, 0.0, 1e-6);
	SHADE_PROOF_NEAR(shade_diffuse_left(2.0f, 0.5f), 1.0, 0.0, 1e-6);
}

/* Microfacets with a Fresnel term alone, and of these such as have a highlight. */
static void other_models_take_nothing(void **state)
{
	(void)state;
	shade_material material = {.diffuse = {0.5f, 0.2f, 0.1f}, .specular = {0.0f, 0.3f, 0.1f}, .roughness = 0.3f};
	for (int kind = 0; kind < SHADE_BRDF_COUNT; kind++)
		for (int f = SHADE_F_NONE; f <= SHADE_F_COOK_TORRANCE; f++) {
			shade_brdf_model model = {kind, SHADE_NDF_GGX, SHADE_G_SMITH_GGX, f};
			bool takes = kind == SHADE_BRDF_MICROFACET && f != SHADE_F_NONE;
			double left = takes ? (double)shade_diffuse_left(0.2f, 0.3f) : 1.0;
			SHADE_PROOF_NEAR(shade_brdf_diffuse_left(model, 0.2f, 0.3f), left, 0.0, 0.0);
			shade_material seen = shade_surface_seen(model, material, 0.2f), matt = material;
			SHADE_PROOF_NEAR3(seen.diffuse, 0.5 * left, 0.2 * left, 0.1 * left, 1e-6, 0.0);
			SHADE_PROOF_NEAR3(seen.specular, 0.0, 0.3, 0.1, 1e-6, 0.0);
			matt.specular = stilb_vec3_make(0.0f, 0.0f, 0.0f);
			SHADE_PROOF_NEAR3(shade_surface_seen(model, matt, 0.2f).diffuse, 0.5, 0.2, 0.1, 1e-6, 0.0);
		}
}

/* The largest of many values of shade_brdf_cos as a share of shade_brdf_peak: directions about the mirrored one, from
 * flat ones on, where microfacets are brightest. */
static double peak_share(shade_brdf_model model, shade_proof_random *random)
{
	double most = 0.0;
	for (int i = 0; i < 4000; i++) {
		shade_frame frame = shade_frame_from_normal(stilb_vec3_make(0.0f, 0.0f, 1.0f));
		float roughness = shade_proof_range(random, 0.05f, 1.0f);
		shade_brdf_parameters p = {stilb_vec3_make(1.0f, 1.0f, 1.0f), roughness,
		                           shade_proof_range(random, -0.95f, 0.95f), shade_proof_uniform(random)};
		float height = i % 4 == 0 ? shade_proof_uniform(random) : shade_proof_log_range(random, 1e-3f, 1.0f);
		float turn = shade_proof_range(random, 0.0f, 6.2831853f), across = sqrtf(1.0f - height * height);
		stilb_vec3 v = stilb_vec3_make(across * cosf(turn), across * sinf(turn), height);
		float tilt = i % 8 == 0 ? 0.0f : shade_proof_log_range(random, 1e-4f, 1.0f);
		stilb_vec3 l =
			stilb_vec3_normalize(stilb_vec3_make(-v[0], -v[1], v[2]) + shade_proof_random_direction(random) * tilt);
		if (i % 16 == 1) /* the brightest of the kinds with n.l and no 1 / (n.v) */
			l = v = frame.n;
		float bound = shade_brdf_peak(model, p.roughness, p.anisotropy);
		most = fmax(most, (double)shade_brdf_cos(model, p, frame, l, v)[0] / (double)bound);
	}
	return most;
}

/* The bounds' formulas, in double. */
static void peaks_have_their_formulas(void **state)
{
	(void)state;
	double pi = 3.14159265358979, epsilon = (double)SHADE_COSINE_EPSILON;
	static const float widths[][2] = {{0.01f, 0.01f}, {0.2f, 0.6f}, {1.7f, 0.3f}};
	for (size_t i = 0; i < sizeof widths / sizeof *widths; i++) {
		shade_alphas alphas = {widths[i][0], widths[i][1]};
		double x = (double)widths[i][0], y = (double)widths[i][1], wide = fmax(x, y), narrow = fmin(x, y);
		SHADE_PROOF_NEAR(shade_d_peak(SHADE_NDF_BECKMANN, alphas), 1.48 / (pi * x * y), 1e-5, 0.0);
		SHADE_PROOF_NEAR(shade_d_peak(SHADE_NDF_GGX, alphas), pow(fmax(wide, 1.0), 4.0) / (pi * x * y), 1e-5, 0.0);
		SHADE_PROOF_NEAR(shade_v_peak(SHADE_G_IMPLICIT, alphas), 0.25, 1e-6, 0.0);
		SHADE_PROOF_NEAR(shade_v_peak(SHADE_G_NEUMANN, alphas), 0.25, 1e-6, 0.0);
		SHADE_PROOF_NEAR(shade_v_peak(SHADE_G_KELEMEN, alphas), 0.5 / epsilon, 1e-5, 0.0);
		SHADE_PROOF_NEAR(shade_v_peak(SHADE_G_COOK_TORRANCE, alphas), 0.5 / epsilon, 1e-5, 0.0);
		SHADE_PROOF_NEAR(shade_v_peak(SHADE_G_SMITH_BECKMANN, alphas), 0.884 * sqrt(1.0 + 2.56 * wide * wide) / narrow,
		                 1e-5, 0.0);
		SHADE_PROOF_NEAR(shade_v_peak(SHADE_G_SMITH_GGX, alphas), 0.5 / narrow, 1e-5, 0.0);
	}
	shade_brdf_model minimalist = {SHADE_BRDF_MINIMALIST, 0, 0, 0};
	double n = (double)shade_exponent_from_alpha(0.25f), lobe = (double)shade_blinn_phong_ndf_factor((float)n);
	SHADE_PROOF_NEAR(shade_brdf_peak(minimalist, 0.5f, 0.0f), lobe * 0.5 / (epsilon * epsilon), 1e-5, 0.0);
}

/* A bound that no value is above, and that is not useless: some is above a fifth of it, but where G or minimalist's
 * form have no bound of their own. */
static void no_direction_is_brighter_than_the_peak(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 57};
	for (int index = 0; index < MODEL_COUNT; index++) {
		shade_brdf_model model = model_of(index);
		bool facets = model.kind == SHADE_BRDF_MICROFACET;
		bool open = model.kind == SHADE_BRDF_MINIMALIST ||
		            (facets && (model.g == SHADE_G_KELEMEN || model.g == SHADE_G_COOK_TORRANCE));
		double share = peak_share(model, &random);
		if (share > 1.0 + 1e-4 || share < (open ? 1e-9 : facets ? 0.2 : 0.99))
			fail_msg("model %d, D %d, G %d, F %d: %g of its peak", model.kind, model.ndf, model.g, model.f, share);
	}
}

static const struct CMUnitTest exactness[] = {
	cmocka_unit_test(frames_stand_on_their_normal),
	cmocka_unit_test(diffuse_has_its_formulas),
	cmocka_unit_test(materials_are_limited_to_one),
	cmocka_unit_test(every_model_has_its_formula),
	cmocka_unit_test(no_direction_is_brighter_than_the_peak),
	cmocka_unit_test(peaks_have_their_formulas),
	cmocka_unit_test(surface_has_its_closed_form),
	cmocka_unit_test(surface_adds_what_its_kind_says),
	cmocka_unit_test(surface_turned_away_sees_only_the_sky),
	cmocka_unit_test(what_highlights_leave_has_its_formula),
	cmocka_unit_test(other_models_take_nothing),
};

/* ---- properties ------------------------------------------------------------------------------------------------- */

/* Each list of names (SHADE_BRDFS and its kind) has each integer once, in order. */
static void lists_are_complete(void **state)
{
	(void)state;
#define NUMBER(integer, identifier) integer,
	static const int brdfs[] = {SHADE_BRDFS(NUMBER)}, ndfs[] = {SHADE_NDFS(NUMBER)};
	static const int gs[] = {SHADE_GS(NUMBER)}, fs[] = {SHADE_FS(NUMBER)};
#undef NUMBER
	assert_int_equal(sizeof brdfs / sizeof brdfs[0], SHADE_BRDF_COUNT);
	assert_int_equal(sizeof ndfs / sizeof ndfs[0], SHADE_NDF_COUNT);
	assert_int_equal(sizeof gs / sizeof gs[0], SHADE_G_COUNT);
	assert_int_equal(sizeof fs / sizeof fs[0], SHADE_F_COUNT);
	for (int i = 0; i < SHADE_G_COUNT; i++)
		assert_true(gs[i] == i && brdfs[i] == i && ndfs[i % SHADE_NDF_COUNT] == i % SHADE_NDF_COUNT &&
		            fs[i % SHADE_F_COUNT] == i % SHADE_F_COUNT);
}

/* Frames about random normals; also next to z = 0, where the frame's t and b jump, and next to -Z. */
static void every_normal_has_a_frame(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 57};
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		stilb_vec3 n = shade_proof_random_direction(&random);
		if (i % 3)
			n[2] *= shade_proof_log_range(&random, 1e-9f, 1.0f);
		if (i % 3 == 2)
			n = stilb_vec3_make(n[2], n[0] * n[2], -1.0f);
		frame_is_orthonormal(shade_frame_from_normal(stilb_vec3_normalize(n)), 6e-7);
	}
}

static void every_material_is_limited(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 58};
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		float high = shade_proof_log_range(&random, 0.5f, 1e30f);
		float d = shade_proof_range(&random, -0.2f * high, high), s = shade_proof_range(&random, -0.2f * high, high);
		limited_as_one(d, s);
		SHADE_PROOF_LIGHT(shade_wrapped(shade_proof_range(&random, -1.0f, 1.0f), shade_proof_uniform(&random)));
	}
	limited_as_one(1.6e38f, 1.6e38f);
	limited_as_one(3e38f, 1e-30f);
}

/* A direction of a random kind: anywhere, near the horizon, on it, `other` mirrored at n, opposite to it, or n. */
static stilb_vec3 awkward_direction(shade_proof_random *random, stilb_vec3 n, stilb_vec3 other)
{
	stilb_vec3 any = shade_proof_random_direction(random), level = any - n * stilb_vec3_dot(n, any);
	switch ((int)(shade_proof_uniform(random) * 8.0f)) {
	case 0:
		return stilb_vec3_normalize(level + n * shade_proof_log_range(random, 1e-9f, 1e-2f));
	case 1:
		return stilb_vec3_normalize(level);
	case 2:
		return stilb_vec3_normalize(2.0f * stilb_vec3_dot(n, other) * n - other);
	case 3:
		return -other;
	case 4:
		return stilb_vec3_normalize(n + any * 1e-3f);
	case 5:
		return n;
	default:
		return any;
	}
}

/* Whatever the directions and parameters, the result is finite and not negative: 0 for v below the horizon, and 0 for l
 * below it but for the wrapped model. */
static void every_model_is_light(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 54};
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		shade_brdf_model model = model_of(i % MODEL_COUNT);
		shade_frame frame = random_frame(&random);
		stilb_vec3 v = awkward_direction(&random, frame.n, frame.t), l = awkward_direction(&random, frame.n, v);
		shade_brdf_parameters p = {.specular = shade_proof_random_color(&random, 1.0f),
		                           .roughness = i % 5 == 0 ? 0.0f : shade_proof_uniform(&random),
		                           .anisotropy = shade_proof_range(&random, -1.0f, 1.0f),
		                           .wrap = shade_proof_uniform(&random)};
		stilb_vec3 got = shade_brdf_cos(model, p, frame, l, v);
		SHADE_PROOF_LIGHT3(got);
		bool below = stilb_vec3_dot(frame.n, v) < -1e-6f ||
		             (stilb_vec3_dot(frame.n, l) < -1e-6f && model.kind != SHADE_BRDF_WRAPPED);
		assert_true(!below || (got[0] == 0.0f && got[1] == 0.0f && got[2] == 0.0f));
	}
}

static void every_surface_is_light(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 55};
	for (int i = 0; i < SHADE_PROOF_COUNT; i++) {
		shade_frame frame = random_frame(&random);
		stilb_vec3 v = awkward_direction(&random, frame.n, frame.t);
		shade_reflectance share =
			shade_limit_to_one(shade_proof_random_color(&random, 2.0f), shade_proof_random_color(&random, 2.0f));
		shade_material material = {share.diffuse, share.specular, shade_proof_uniform(&random),
		                           shade_proof_range(&random, -1.0f, 1.0f), shade_proof_uniform(&random)};
		shade_sun sun = {awkward_direction(&random, frame.n, v), shade_proof_random_color(&random, 1e6f)};
		shade_sky sky = {shade_proof_random_color(&random, 1e6f), shade_proof_random_color(&random, 1e6f)};
		SHADE_PROOF_LIGHT3(shade_surface_radiance(model_of(i % MODEL_COUNT), material, sun, sky, frame, v));
	}
}

typedef struct surface_case {
	shade_brdf_model model;
	shade_material material;
	shade_sun sun;
} surface_case;

static double surface_cosine(const double w[3], const void *context)
{
	const surface_case *c = context;
	shade_sky dark = {.sky = {0.0f}};
	shade_frame up = shade_frame_from_normal(stilb_vec3_make(0.0f, 0.0f, 1.0f));
	stilb_vec3 v = stilb_vec3_make((float)w[0], (float)w[1], (float)w[2]);
	return (double)shade_surface_radiance(c->model, c->material, c->sun, dark, up, v)[0] * w[2];
}

/* All that leaves a limited material (radiosity) against all that comes in (irradiance times the cosine), for the
 * models that conserve energy: no more, and no less than the diffuse share. */
static void surface_gives_back_no_more_than_it_gets(void **state)
{
	(void)state;
	static const shade_brdf_model models[] = {
		{.kind = SHADE_BRDF_LAMBERT},
		{.kind = SHADE_BRDF_PHONG_MODIFIED},
		{.kind = SHADE_BRDF_BLINN_PHONG_MODIFIED},
		{SHADE_BRDF_MICROFACET, SHADE_NDF_BECKMANN, SHADE_G_SMITH_BECKMANN, SHADE_F_NONE},
		{SHADE_BRDF_MICROFACET, SHADE_NDF_GGX, SHADE_G_SMITH_GGX, SHADE_F_NONE},
		{SHADE_BRDF_MICROFACET, SHADE_NDF_GGX_ANISOTROPIC, SHADE_G_SMITH_GGX, SHADE_F_NONE},
	};
	shade_proof_random random = {.seed = 56};
	for (size_t i = 0; i < 60; i++) {
		shade_reflectance share =
			shade_limit_to_one(shade_proof_random_color(&random, 2.0f), shade_proof_random_color(&random, 2.0f));
		float angle = shade_proof_range(&random, 0.0f, 1.5f);
		surface_case c = {.model = models[i % (sizeof models / sizeof models[0])],
		                  .material = {.diffuse = share.diffuse,
		                               .specular = share.specular,
		                               .roughness = shade_proof_range(&random, 0.45f, 1.0f),
		                               .anisotropy = shade_proof_range(&random, -0.4f, 0.4f)},
		                  .sun = {{sinf(angle), 0.0f, cosf(angle)}, {4.0f, 4.0f, 4.0f}}};
		double leaves = stilb_numeric_integrate_sphere(surface_cosine, &c, 0.0, 1.0, 4);
		double comes = 4.0 * cos((double)angle);
		if (!(leaves <= comes * 1.001))
			fail_msg("kind %d, D %d: %g leaves of %g", c.model.kind, c.model.ndf, leaves, comes);
		assert_true(leaves >= comes * (double)share.diffuse[0] * 0.999);
	}
}

/* At most what the table of the highlight says is left, but for .004, and not much less. */
static void highlights_take_of_diffuse_light(void **state)
{
	(void)state;
	double square = 0.0;
	for (int i = 0; i <= 20; i++)
		for (int k = 0; k <= 20; k++) {
			double c = pow(k / 20.0, 2), r = 0.0317 + 0.9683 * i / 20, taken = stilb_numeric_dfg_of(c, r).b;
			double left = (double)shade_diffuse_left((float)c, (float)r), above = 1 - left - taken;
			square += above * above / 441;
			if (!(above >= -0.004 && above <= (c < 0.05 ? 0.095 : 0.025)))
				fail_msg("n.v %g, roughness %g: %g is left, %g is taken", c, r, left, taken);
		}
	SHADE_PROOF_NEAR(sqrt(square), 0.0135, 0.0, 0.002);
}

/* McAuley's measure: over all directions of light, behind the surface too, the reflection density is 1. */
static double wrapped_density(double z, const void *context)
{
	const float *wrap = context;
	return 2.0 * M_PI * (double)shade_wrapped((float)z, *wrap);
}

static void wrapped_is_normalised(void **state)
{
	(void)state;
	for (float wrap = 0.0f; wrap <= 1.0f; wrap += 0.125f)
		SHADE_PROOF_NEAR(stilb_numeric_integrate(wrapped_density, &wrap, -(double)wrap, 1.0, 2), 1.0, 1e-6, 0.0);
}

static const struct CMUnitTest properties[] = {
	cmocka_unit_test(lists_are_complete),        cmocka_unit_test(every_normal_has_a_frame),
	cmocka_unit_test(every_material_is_limited), cmocka_unit_test(every_model_is_light),
	cmocka_unit_test(every_surface_is_light),    cmocka_unit_test(surface_gives_back_no_more_than_it_gets),
	cmocka_unit_test(wrapped_is_normalised),     cmocka_unit_test(highlights_take_of_diffuse_light),
};

int main(void)
{
	return SHADE_PROOF_RUN(exactness, properties);
}
