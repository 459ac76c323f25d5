/* gi_bsdf chooses directions as often as its density says: every highlight of the catalogue, and every layer, over
 * roughness, view and tilted triangles: support/chi_square.h. With the argument "long" more of each. */
#include "support/chi_square.h"

#include "gi/integrate/gi_direct.h"
#include "gi/sample/gi_bsdf.h"
#include "numeric/numeric_catalog.h"

static bool is_long;
static uint32_t draws;

typedef struct scatter {
	gi_bsdf bsdf;
	shade_frame frame; /* of the square: about the shading normal */
	double off;        /* the density is multiplied by this: 1, but to see that the test sees it */
} scatter;

/* Nothing is chosen where no light is reflected. A choice's own density and weight are those of its direction. */
static bool scatter_draw(const void *context, shade_proof_random *random, double at[2])
{
	const scatter *s = context;
	gi_bsdf_sample chosen;
	float u_lobe = shade_proof_uniform(random);
	stilb_vec2 u = {shade_proof_uniform(random), shade_proof_uniform(random)};
	if (!gi_bsdf_sample_direction(&s->bsdf, u_lobe, u, &chosen))
		return false;
	chi_square_place(s->frame, chosen.direction, at);
	return true;
}

static double scatter_density(const void *context, const double at[2])
{
	const scatter *s = context;
	stilb_vec3 l = chi_square_direction(s->frame, at), f = gi_bsdf_cos(&s->bsdf, l);
	return f[0] + f[1] + f[2] > 0.0f ? s->off * 4.0 * M_PI * (double)gi_bsdf_pdf(&s->bsdf, l) : 0.0;
}

static chi_square_result compare(const scatter *s, uint64_t seed)
{
	return chi_square_compare(&(chi_square_subject){scatter_draw, scatter_density, s}, seed, draws);
}

static stilb_vec3 test_normal(void)
{
	return stilb_vec3_normalize(stilb_vec3_make(0.3f, 0.8f, -0.5f));
}

/* A direction at the angle polar from the normal. */
static stilb_vec3 view_at(float polar)
{
	stilb_vec3 local = stilb_vec3_make(sinf(polar) * 0.6f, sinf(polar) * 0.8f, cosf(polar));
	return stilb_vec3_normalize(shade_frame_to_world(shade_frame_from_normal(test_normal()), local));
}

static gi_surface surface_of(float diffuse, float specular, float roughness)
{
	return (gi_surface){.geometric = test_normal(),
	                    .normal = test_normal(),
	                    .diffuse = {diffuse, diffuse, diffuse},
	                    .specular = {specular, specular, specular},
	                    .roughness = roughness,
	                    .anisotropy = 0.5f,
	                    .front = true};
}

static scatter scatter_of(const shade_brdf_model *model, gi_surface *surface, float polar)
{
	scatter s = {.frame = shade_frame_from_normal(test_normal()), .off = 1.0};
	gi_bsdf_make(model, surface, view_at(polar), &s.bsdf);
	return s;
}

/* ---- highlights -------------------------------------------------------------------------------------------------- */

static const float polars[] = {0.9f, 1.5f, 0.0f};

static void check_highlight(const stilb_numeric_row *row, chi_square_family *family)
{
	static const float roughnesses[] = {0.4f, 0.1f, 0.9f};
	for (int r = 0; r < (is_long ? 3 : 1); r++)
		for (int p = 0; p < (is_long ? 3 : 1); p++) {
			gi_surface surface = surface_of(0.3f, 0.4f, roughnesses[r]);
			scatter s = scatter_of(&row->model, &surface, polars[p]);
			chi_square_result got = compare(&s, 100 + family->done);
			if (!chi_square_passes(family, got.p))
				fail_msg("%s, roughness %g, view %g: p %.2g, integral %.5f", row->name, (double)roughnesses[r],
				         (double)polars[p], got.p, got.mass);
		}
}

static void highlights_are_chosen_as_their_density_says(void **state)
{
	(void)state;
	size_t count;
	uint32_t models = 0;
	const stilb_numeric_row *rows = stilb_numeric_catalog(&count);
	for (size_t i = 0; i < count; i++)
		models += rows[i].kind == STILB_NUMERIC_BRDF;
	chi_square_family family = chi_square_family_of(models * (is_long ? 9 : 1));
	for (size_t i = 0; i < count; i++)
		if (rows[i].kind == STILB_NUMERIC_BRDF)
			check_highlight(&rows[i], &family);
	chi_square_end(&family);
}

/* Bumps and interpolated normals: directions above the shading normal's horizon, but below the triangle, are none. */
static void tilted_triangles_cut_off_what_is_below(void **state)
{
	(void)state;
	shade_brdf_model models[] = {{.kind = SHADE_BRDF_LAMBERT}, stilb_numeric_catalog_find("ggx_smith_ggx")->model};
	shade_proof_random random = {.seed = 13};
	chi_square_family family = chi_square_family_of(is_long ? 24 : 4);
	for (uint32_t i = 0; i < family.planned; i++) {
		gi_surface surface = surface_of(0.5f, 0.3f, shade_proof_range(&random, 0.3f, 1.0f));
		surface.geometric = stilb_vec3_normalize(test_normal() + shade_proof_random_direction(&random) * 0.5f);
		scatter s = scatter_of(&models[i % 2], &surface, shade_proof_range(&random, 0.0f, 1.2f));
		chi_square_result got = compare(&s, 300 + i);
		if (!chi_square_passes(&family, got.p))
			fail_msg("%u: p %.2g, integral %.5f", i, got.p, got.mass);
		assert_true(got.mass < 0.9999);
	}
	chi_square_end(&family);
}

/* ---- layers ------------------------------------------------------------------------------------------------------ */

static float some_or_none(shade_proof_random *random, float low, float high)
{
	float value = shade_proof_range(random, low, high);
	return shade_proof_uniform(random) < 0.5f ? value : 0.0f;
}

enum { OPAQUE, THIN, INTO_VOLUME, OUT_OF_VOLUME, SOLIDITIES };

/* A surface with some of the layers, of any strength. */
static gi_surface layered_surface(shade_proof_random *random, int solidity)
{
	float least = 0.15f; /* narrower lobes are the highlights' */
	float roughness = shade_proof_range(random, least, 1.0f);
	gi_surface surface = surface_of(some_or_none(random, 0.1f, 0.8f), some_or_none(random, 0.02f, 0.9f), roughness);
	stilb_vec3 lean = stilb_vec3_make(some_or_none(random, 0.0f, 0.4f), 0.0f, 0.2f);
	float coat = some_or_none(random, 0.1f, 1.0f), sheen = some_or_none(random, 0.1f, 1.0f);
	float through = solidity == OPAQUE ? 0.0f : shade_proof_range(random, 0.2f, 1.0f);
	surface.layered = true;
	surface.front = solidity != OUT_OF_VOLUME;
	surface.layers = (gi_layers){.coat_normal = stilb_vec3_normalize(test_normal() + lean),
	                             .sheen = {sheen, 0.5f * sheen, 0.0f},
	                             .brushed = {0.2f, 0.4f, 0.9f},
	                             .coat = coat,
	                             .coat_roughness = shade_proof_range(random, least, 1.0f),
	                             .sheen_roughness = shade_proof_range(random, 0.2f, 1.0f),
	                             .anisotropy = some_or_none(random, 0.2f, 0.9f),
	                             .roughness = roughness,
	                             .through = {through, 0.5f * through, through},
	                             .solid = solidity >= INTO_VOLUME,
	                             .ior = solidity >= INTO_VOLUME ? shade_proof_range(random, 1.1f, 2.6f) : 0.0f};
	return surface;
}

static void layers_are_chosen_as_their_density_says(void **state)
{
	(void)state;
	shade_brdf_model model = stilb_numeric_catalog_find("ggx_smith_ggx")->model;
	chi_square_family family = chi_square_family_of(is_long ? 80 : 12);
	for (uint32_t i = 0; i < family.planned; i++) {
		shade_proof_random random = {.seed = 500 + i};
		int solidity = (int)(i % SOLIDITIES);
		gi_surface surface = layered_surface(&random, solidity);
		float polar = shade_proof_range(&random, 0.0f, 1.5f);
		scatter s = scatter_of(&model, &surface, polar);
		chi_square_result got = compare(&s, 700 + i);
		if (!chi_square_passes(&family, got.p))
			fail_msg("%u: solidity %d, roughness %g, coat %g of %g, sheen %g of %g, brushed %g, index %g, view %g: "
			         "p %.2g, integral %.5f",
			         i, solidity, (double)surface.roughness, (double)surface.layers.coat,
			         (double)surface.layers.coat_roughness, (double)surface.layers.sheen[0],
			         (double)surface.layers.sheen_roughness, (double)surface.layers.anisotropy,
			         (double)surface.layers.ior, (double)polar, got.p, got.mass);
	}
	chi_square_end(&family);
}

/* Which side of a wall asks lights, and what is left of the number that chose it, which chooses the light. */
static void sides_ask_as_often_as_they_say(void **state)
{
	(void)state;
	enum { PARTS = 8 };
	shade_brdf_model model = stilb_numeric_catalog_find("ggx_smith_ggx")->model;
	chi_square_family family = chi_square_family_of(is_long ? 60 : 12);
	for (uint32_t i = 0; i < family.planned; i++) {
		shade_proof_random random = {.seed = 2000 + i};
		gi_surface surface = layered_surface(&random, (int)(i % SOLIDITIES));
		scatter s = scatter_of(&model, &surface, shade_proof_range(&random, 0.0f, 1.4f));
		const gi_lobes *lobes = &s.bsdf.layers->lobes;
		double expected[2 * PARTS + 1] = {[2 * PARTS] = draws * (1.0 - (double)lobes->ask - (double)lobes->ask_beyond)};
		uint32_t found[2 * PARTS + 1] = {0};
		expected[2 * PARTS] = fmax(expected[2 * PARTS], 0.0);
		for (int k = 0; k < 2 * PARTS; k++)
			expected[k] = draws * (double)(k < PARTS ? lobes->ask : lobes->ask_beyond) / PARTS;
		for (uint32_t k = 0; k < draws; k++) {
			float choice = shade_proof_uniform(&random), chance;
			stilb_vec3 origin = {0}, normal = test_normal();
			if (!gi_direct_side(&s.bsdf, &origin, &normal, &choice, &chance)) {
				found[2 * PARTS]++;
				continue;
			}
			bool beyond = stilb_vec3_dot(normal, test_normal()) < 0.0f;
			assert_true(chance == (beyond ? lobes->ask_beyond : lobes->ask));
			found[(beyond ? PARTS : 0) + (int)(choice * PARTS)]++;
		}
		double p = chi_square_p(expected, found, 2 * PARTS + 1, 0.0);
		if (!chi_square_passes(&family, p))
			fail_msg("%u: solidity %u: p %.2g", i, i % SOLIDITIES, p);
	}
	chi_square_end(&family);
}

/* The density that a choice comes with is that of its direction. */
static void choices_come_with_their_density(void **state)
{
	(void)state;
	shade_brdf_model model = stilb_numeric_catalog_find("ggx_smith_ggx")->model;
	for (uint32_t i = 0; i < 40; i++) {
		shade_proof_random random = {.seed = 900 + i};
		gi_surface surface = layered_surface(&random, (int)(i % SOLIDITIES));
		surface.layered = i % 8 > 3;
		scatter s = scatter_of(&model, &surface, shade_proof_range(&random, 0.0f, 1.4f));
		for (int k = 0; k < 1000; k++) {
			gi_bsdf_sample chosen;
			stilb_vec2 u = {shade_proof_uniform(&random), shade_proof_uniform(&random)};
			if (!gi_bsdf_sample_direction(&s.bsdf, shade_proof_uniform(&random), u, &chosen))
				continue;
			SHADE_PROOF_NEAR(gi_bsdf_pdf(&s.bsdf, chosen.direction), chosen.pdf, 5e-3, 1e-6);
		}
	}
}

/* What this test is for: a density that is off by 5 % is found, too small and too large. */
static void five_percent_are_found(void **state)
{
	(void)state;
	shade_brdf_model model = stilb_numeric_catalog_find("ggx_smith_ggx")->model;
	for (int i = 0; i < 2; i++) {
		gi_surface surface = surface_of(0.3f, 0.4f, 0.4f);
		scatter s = scatter_of(&model, &surface, 0.9f);
		s.off = i ? 1.05 : 0.95;
		assert_true(compare(&s, 1).p < 1e-9);
	}
}

int main(int argc, char **argv)
{
	is_long = argc > 1 && strcmp(argv[1], "long") == 0;
	draws = is_long ? 40000 : TEST_ASAN || TEST_EMULATED ? 10000 : 30000;
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(highlights_are_chosen_as_their_density_says),
		cmocka_unit_test(tilted_triangles_cut_off_what_is_below),
		cmocka_unit_test(layers_are_chosen_as_their_density_says),
		cmocka_unit_test(sides_ask_as_often_as_they_say),
		cmocka_unit_test(choices_come_with_their_density),
		cmocka_unit_test(five_percent_are_found),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
