/* Whole materials in a white furnace: under light of radiance 1 from everywhere, also from behind, every combination of
 * layers sends at most 1 to every viewer. The mean weight of well spread samples is what is sent. With an argument it
 * prints the most of each combination. */
#include "gi/sample/gi_bsdf.h"
#include "shading/shade_gltf.h"
#include "support/shade_proof.h"

/* Samples of a view, and of one that may send more than 1, whose error is then below 5e-4. */
#define SAMPLES 4096
#define SAMPLES_FINE 262144

enum { METAL = 1, COAT = 2, SHEEN = 4, THIN = 8, SOLID = 16, BRUSHED = 32, TINTED = 64, COMBINATIONS = 128 };

static const shade_brdf_model model = {SHADE_BRDF_MICROFACET, SHADE_NDF_GGX, SHADE_G_SMITH_GGX, SHADE_F_SCHLICK};
static bool prints;

/* White, so that nothing is absorbed; TINTED: of a reflectance of half, as specular and glossiness has it. */
static gi_surface material_of(int kind, float roughness)
{
	stilb_vec3 white = stilb_vec3_make(1.0f, 1.0f, 1.0f), up = stilb_vec3_make(0.0f, 0.0f, 1.0f);
	stilb_vec3 dielectric = kind & TINTED ? white * 0.5f : shade_gltf_dielectric(1.5f, white, 1.0f);
	shade_gltf_base base = shade_gltf_metallic(white, kind & METAL ? 1.0f : 0.0f, roughness, dielectric);
	bool through = kind & (THIN | SOLID);
	gi_surface surface = {.geometric = up,
	                      .normal = up,
	                      .diffuse = base.diffuse * (through ? 0.0f : 1.0f),
	                      .specular = base.specular,
	                      .roughness = roughness,
	                      .front = true,
	                      .layered = kind & ~(METAL | TINTED)};
	surface.layers = (gi_layers){.coat_normal = up,
	                             .sheen = kind & SHEEN ? white : stilb_vec3_make(0.0f, 0.0f, 0.0f),
	                             .brushed = stilb_vec3_make(1.0f, 0.0f, 0.0f),
	                             .through = through ? white : stilb_vec3_make(0.0f, 0.0f, 0.0f),
	                             .left = white,
	                             .roughness = roughness,
	                             .coat = kind & COAT ? 1.0f : 0.0f,
	                             .coat_roughness = 0.2f,
	                             .sheen_roughness = 0.4f,
	                             .anisotropy = kind & BRUSHED ? 0.7f : 0.0f,
	                             .ior = 1.5f,
	                             .solid = kind & SOLID};
	return surface;
}

/* What is sent to a viewer at this cosine. */
static double sent_to(gi_surface *surface, float n_dot_v, int samples)
{
	stilb_vec3 v =
		stilb_vec3_make(sqrtf(1.0f - n_dot_v * n_dot_v) * 0.8f, sqrtf(1.0f - n_dot_v * n_dot_v) * 0.6f, n_dot_v);
	gi_bsdf bsdf;
	gi_bsdf_make(&model, surface, v, &bsdf);
	double sum = 0.0, a[3] = {0.5, 0.5, 0.5};
	for (int i = 0; i < samples; i++) {
		/* Source: Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences" (2018): R3. */
		static const double steps[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
		for (int c = 0; c < 3; c++)
			a[c] = a[c] + steps[c] - floor(a[c] + steps[c]);
		gi_bsdf_sample chosen;
		stilb_vec2 u = {(float)(a[1] * 0.9999999), (float)(a[2] * 0.9999999)};
		if (gi_bsdf_sample_direction(&bsdf, (float)(a[0] * 0.9999999), u, &chosen))
			sum += (double)chosen.weight[0];
	}
	return sum / samples;
}

static void no_material_makes_light(void **state)
{
	(void)state;
	static const float cosines[] = {0.02f, 0.05f, 0.1f, 0.2f, 0.35f, 0.5f, 0.7f, 0.9f, 1.0f};
	double worst = 0.0;
	for (int kind = 0; kind < COMBINATIONS; kind++) {
		double most = 0.0, at[2] = {0};
		if (((kind & THIN) && (kind & SOLID)) || ((kind & METAL) && (kind & (THIN | SOLID | TINTED))))
			continue;
		for (int r = 1; r <= 10; r++)
			for (size_t c = 0; c < sizeof cosines / sizeof *cosines; c++) {
				gi_surface surface = material_of(kind, 0.1f * (float)r);
				double sent = sent_to(&surface, cosines[c], SAMPLES);
				if (sent > 1.0 + 5e-4)
					sent = sent_to(&surface, cosines[c], SAMPLES_FINE);
				if (sent > most)
					most = sent, at[0] = 0.1 * r, at[1] = (double)cosines[c];
			}
		if (prints)
			print_message("%s%s%s%s%s%s%s: %.4f at roughness %.1f, cosine %.2f\n",
			              kind & METAL ? "metal" : "dielectric", kind & TINTED ? " of 0.5" : "",
			              kind & COAT ? ", coat" : "", kind & SHEEN ? ", sheen" : "", kind & THIN ? ", thin" : "",
			              kind & SOLID ? ", solid" : "", kind & BRUSHED ? ", brushed" : "", most, at[0], at[1]);
		worst = fmax(worst, most);
	}
	if (!(worst <= 1.0 + 1e-3))
		fail_msg("a material sends %.4f", worst);
}

int main(int argc, char **argv)
{
	(void)argv;
	const struct CMUnitTest tests[] = {cmocka_unit_test(no_material_makes_light)};
	prints = argc > 1;
	return cmocka_run_group_tests(tests, NULL, NULL);
}
