/* shade_gltf.h: against the specification's numbers, and in double. */

#include "shading/shade_gltf.h"

#include "support/shade_proof.h"

static stilb_vec3 color_of(shade_proof_random *random)
{
	float r = shade_proof_range(random, 0.0f, 1.0f), g = shade_proof_range(random, 0.0f, 1.0f);
	return stilb_vec3_make(r, g, shade_proof_range(random, 0.0f, 1.0f));
}

static double largest(stilb_vec3 v)
{
	return fmax((double)v[0], fmax((double)v[1], (double)v[2]));
}

/* 1.5 reflects 4 %, 1.33 2 %, water to diamond as the table of KHR_materials_ior has it; 0 is a mirror. */
static void reflectance_of_an_index(void **state)
{
	(void)state;
	static const double rows[][2] = {{1.0, 0.0},        {1.333, 0.0203731}, {1.5, 0.04},
	                                 {1.76, 0.0758244}, {2.42, 0.1723949},  {0.0, 1.0}};
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
		SHADE_PROOF_NEAR(shade_gltf_reflectance((float)rows[i][0]), rows[i][1], 0.0, 1e-6);
	stilb_vec3 tinted = shade_gltf_dielectric(1.5f, stilb_vec3_make(0.5f, 2.0f, 30.0f), 0.5f);
	SHADE_PROOF_NEAR3(tinted, 0.01, 0.04, 0.5, 0.0, 1e-7);
}

static void workflows_in_double(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 1};
	for (int k = 0; k < 1000; k++) {
		stilb_vec3 color = color_of(&random), other = color_of(&random);
		float metal = shade_proof_range(&random, 0.0f, 1.0f), rough = shade_proof_range(&random, 0.0f, 1.0f);
		double m = (double)metal, left = (1 - m) * (1 - largest(other)), kept = 1 - largest(other);
		shade_gltf_base base = shade_gltf_metallic(color, metal, rough, other);
		SHADE_PROOF_NEAR3(base.diffuse, left * (double)color[0], left * (double)color[1], left * (double)color[2], 1e-5,
		                  1e-7);
		SHADE_PROOF_NEAR3(base.specular, (double)other[0] * (1 - m) + m * (double)color[0],
		                  (double)other[1] * (1 - m) + m * (double)color[1],
		                  (double)other[2] * (1 - m) + m * (double)color[2], 1e-5, 1e-7);
		SHADE_PROOF_NEAR(base.roughness, (double)rough, 0.0, 0.0);
		base = shade_gltf_specular(color, other, rough);
		SHADE_PROOF_NEAR3(base.diffuse, kept * (double)color[0], kept * (double)color[1], kept * (double)color[2], 1e-5,
		                  1e-7);
		SHADE_PROOF_NEAR3(base.specular, (double)other[0], (double)other[1], (double)other[2], 0.0, 0.0);
		SHADE_PROOF_NEAR(base.roughness, 1.0 - (double)rough, 0.0, 1e-7);
	}
}

/* Colour and metalness come back; so does the colour of what is no metal, whatever its highlight. */
static void reflectances_are_unmixed(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 7};
	stilb_vec3 plastic = stilb_vec3_make(0.04f, 0.04f, 0.04f);
	for (int k = 0; k < 1000; k++) {
		stilb_vec3 color = 0.1f + 0.9f * color_of(&random);
		float metal = k % 10 == 0 ? 1.0f : k % 10 == 1 ? 0.0f : shade_proof_range(&random, 0.01f, 1.0f);
		shade_gltf_base base = shade_gltf_metallic(color, metal, 0.5f, plastic);
		shade_gltf_color found = shade_gltf_unmixed(base.diffuse, base.specular);
		SHADE_PROOF_NEAR(found.metalness, (double)metal, 0.0, 2e-5);
		SHADE_PROOF_NEAR3(found.color, (double)color[0], (double)color[1], (double)color[2], 0.0, 1e-5);
	}
	shade_gltf_color matt = shade_gltf_unmixed(stilb_vec3_make(0.02f, 0.5f, 0.9f), stilb_vec3_make(0.0f, 0.0f, 0.0f));
	SHADE_PROOF_NEAR3(matt.color, 0.02, 0.5, 0.9, 0.0, 1e-6);
	SHADE_PROOF_NEAR(matt.metalness, 0.0, 0.0, 0.0);
	shade_gltf_color weak = shade_gltf_unmixed(stilb_vec3_make(0.2f, 0.4f, 0.5f), stilb_vec3_make(0.02f, 0.0f, 0.01f));
	SHADE_PROOF_NEAR3(weak.color, 0.2 / 0.98, 0.4 / 0.98, 0.5 / 0.98, 0.0, 1e-6);
	SHADE_PROOF_NEAR(weak.metalness, 0.0, 0.0, 0.0);
	shade_gltf_color black = shade_gltf_unmixed(stilb_vec3_make(0.0f, 0.0f, 0.0f), stilb_vec3_make(0.0f, 0.0f, 0.0f));
	SHADE_PROOF_NEAR3(black.color, 0.0, 0.0, 0.0, 0.0, 0.0);
	/* The border: a dark surface whose highlight is a dielectric's is none of metal, above it is. */
	shade_gltf_base below = {stilb_vec3_make(0.01f, 0.01f, 0.01f), stilb_vec3_make(0.04009f, 0.04009f, 0.04009f), 0.0f};
	shade_gltf_base above = {below.diffuse, stilb_vec3_make(0.04011f, 0.04011f, 0.04011f), 0.0f};
	SHADE_PROOF_NEAR(shade_gltf_unmixed(below.diffuse, below.specular).metalness, 0.0, 0.0, 0.0);
	assert_true(shade_gltf_unmixed(above.diffuse, above.specular).metalness > 0.7f);
}

/* 128, 128, 255 is nearly up; black and white have a direction; a scale of 0 is flat. */
static void normals_of_texels(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 2};
	SHADE_PROOF_NEAR3(shade_gltf_normal(stilb_vec3_make(0.5f, 0.5f, 1.0f), 3.0f), 0.0, 0.0, 1.0, 0.0, 0.0);
	SHADE_PROOF_NEAR3(shade_gltf_normal(stilb_vec3_make(1.0f, 0.5f, 0.5f), 1.0f), 1.0, 0.0, 0.0, 0.0, 0.0);
	SHADE_PROOF_NEAR3(shade_gltf_normal(stilb_vec3_make(1.0f, 0.0f, 0.5f), 0.0f), 0.0, 0.0, 1.0, 0.0, 0.0);
	SHADE_PROOF_NEAR3(shade_gltf_normal(stilb_vec3_make(0.5f, 0.5f, 0.5f), 1.0f), 0.0, 0.0, 1.0, 0.0, 0.0);
	for (int k = 0; k < 1000; k++) {
		stilb_vec3 texel = color_of(&random);
		float scale = shade_proof_range(&random, 0.0f, 2.0f);
		double x = (2 * (double)texel[0] - 1) * (double)scale, y = (2 * (double)texel[1] - 1) * (double)scale;
		double z = 2 * (double)texel[2] - 1, length = sqrt(x * x + y * y + z * z);
		SHADE_PROOF_NEAR3(shade_gltf_normal(texel, scale), x / length, y / length, z / length, 1e-5, 1e-5 / length);
		double a = 2 * (double)texel[0] - 1, b = 2 * (double)texel[1] - 1, rest = 1 - a * a - b * b;
		SHADE_PROOF_NEAR(shade_gltf_normal_z(texel[0], texel[1]), 0.5 + 0.5 * sqrt(fmax(rest, 0.0)), 0.0,
		                 rest > 1e-3 ? 1e-5 : 1e-2);
	}
}

/* Up stays up; x goes along the tangent, y along the bitangent, which the sign turns over; lengths do not count. */
static void normals_are_turned(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 3};
	for (int k = 0; k < 1000; k++) {
		shade_frame frame = shade_frame_from_normal(shade_proof_random_direction(&random));
		float sign = k % 2 ? 1.0f : -1.0f, length = shade_proof_range(&random, 0.2f, 1.0f);
		stilb_vec3 local = shade_proof_random_direction(&random);
		stilb_vec3 got = shade_gltf_turned(local, frame.t, sign, frame.n);
		double x = (double)local[0], y = (double)local[1] * (double)sign, z = (double)local[2];
		SHADE_PROOF_NEAR3(got, x * (double)frame.t[0] + y * (double)frame.b[0] + z * (double)frame.n[0],
		                  x * (double)frame.t[1] + y * (double)frame.b[1] + z * (double)frame.n[1],
		                  x * (double)frame.t[2] + y * (double)frame.b[2] + z * (double)frame.n[2], 1e-5, 1e-6);
		stilb_vec3 same = shade_gltf_turned(stilb_vec3_make(0, 0, 1), frame.t, sign, frame.n * length);
		SHADE_PROOF_NEAR3(same, (double)frame.n[0], (double)frame.n[1], (double)frame.n[2], 1e-5, 1e-6);
	}
	stilb_vec3 up = stilb_vec3_make(0, 0, 1);
	SHADE_PROOF_NEAR3(shade_gltf_turned(stilb_vec3_make(0, 1, 0), (stilb_vec3){0}, 1.0f, up), 0.0, 0.0, 1.0, 0.0, 0.0);
}

/* alpha^2 is the sum of both squares, at most 1; without a spread the roughness comes back bit by bit. */
static void lobes_are_widened(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 5};
	for (int k = 0; k < 1000; k++) {
		float roughness = shade_proof_range(&random, 0.0f, 1.0f), spread = shade_proof_range(&random, 0.0f, 1.0f);
		double alpha2 = pow((double)roughness, 4) + (double)spread * (double)spread;
		SHADE_PROOF_NEAR(shade_gltf_widened(roughness, spread), pow(fmin(alpha2, 1.0), 0.25), 1e-6, 0.0);
		SHADE_PROOF_NEAR(shade_gltf_widened(roughness, 0.0f), (double)roughness, 0.0, 0.0);
		assert_true(shade_gltf_widened(roughness, spread) >= roughness * (1.0f - 1e-6f));
	}
	SHADE_PROOF_NEAR(shade_gltf_widened(1.0f, 1.0f), 1.0, 0.0, 0.0);
	SHADE_PROOF_NEAR(shade_gltf_widened(0.5f, 0.25f), pow(0.125, 0.25), 1e-6, 0.0);
}

static void occlusion_by_strength(void **state)
{
	(void)state;
	SHADE_PROOF_NEAR(shade_gltf_occlusion(0.25f, 1.0f), 0.25, 0.0, 1e-7);
	SHADE_PROOF_NEAR(shade_gltf_occlusion(0.25f, 0.0f), 1.0, 0.0, 0.0);
	SHADE_PROOF_NEAR(shade_gltf_occlusion(0.5f, 0.5f), 0.75, 0.0, 1e-7);
}

/* No surface of either workflow reflects more than arrives: diffuse + specular <= 1. */
static void nothing_is_added(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 4};
	for (int k = 0; k < 100000; k++) {
		stilb_vec3 color = color_of(&random), other = color_of(&random);
		float metal = shade_proof_range(&random, 0.0f, 1.0f);
		shade_gltf_base bases[2] = {shade_gltf_metallic(color, metal, 0.5f, other),
		                            shade_gltf_specular(color, other, 0.5f)};
		for (int i = 0; i < 2; i++)
			assert_true(largest(bases[i].diffuse + bases[i].specular) <= 1.0 + 1e-6);
	}
}

int main(void)
{
	const struct CMUnitTest exactness[] = {
		cmocka_unit_test(reflectance_of_an_index),  cmocka_unit_test(workflows_in_double),
		cmocka_unit_test(reflectances_are_unmixed), cmocka_unit_test(normals_of_texels),
		cmocka_unit_test(normals_are_turned),       cmocka_unit_test(lobes_are_widened),
		cmocka_unit_test(occlusion_by_strength),
	};
	const struct CMUnitTest properties[] = {cmocka_unit_test(nothing_is_added)};
	return SHADE_PROOF_RUN(exactness, properties);
}
