/* numeric_sh.h: projections against closed forms, and of environment maps against quadrature of the same map. */

#include "numeric/numeric_sh.h"

#include "shading/shade_light.h"
#include "support/shade_proof.h"

#include <string.h>

/* ---- functions --------------------------------------------------------------------------------------------------- */

static double first_harmonics(const double d[3], const void *context)
{
	const double *c = context;
	stilb_vec3 direction = stilb_vec3_make((float)d[0], (float)d[1], (float)d[2]);
	double sum = 0.0;
	for (int i = 0; i < 9; i++)
		sum += c[i] * (double)shade_sh_basis(direction).c[i];
	return sum;
}

static void three_bands_come_back(void **state)
{
	(void)state;
	const double c[9] = {0.5, -1.0, 2.0, 0.25, 3.0, -0.125, 1.5, -2.5, 0.75};
	shade_sh sh = stilb_numeric_sh_project(first_harmonics, c, 1);
	for (int i = 0; i < 9; i++)
		SHADE_PROOF_NEAR(sh.c[i], c[i], 1e-6, 0.0);
}

static double upper_cosine(const double d[3], const void *context)
{
	(void)context;
	return fmax(d[2], 0.0);
}

/* Projects the clamped cosine about an axis, the lobe that irradiance is made with: its coefficients of the bands 0, 1
 * and 2 are pi, 2 pi / 3 and pi / 4 times the basis functions at the axis. */
static void cosine_lobe_has_its_bands(void **state)
{
	(void)state;
	shade_sh got = stilb_numeric_sh_project(upper_cosine, NULL, 2);
	shade_sh want = shade_sh_convolve_cosine(shade_sh_basis(stilb_vec3_make(0.0f, 0.0f, 1.0f)));
	for (int i = 0; i < 9; i++)
		SHADE_PROOF_NEAR(got.c[i], (double)want.c[i], 1e-6, 1e-7);
}

static double two_halves(const double d[3], const void *context)
{
	const double *radiance = context;
	return radiance[d[2] > 0.0 ? 0 : 1];
}

/* Two uniform halves, sky and ground, have no part in band 2, and the cosine has none in band 3 and higher odd ones: so
 * three bands give their irradiance exactly. */
static void two_halves_have_their_irradiance(void **state)
{
	(void)state;
	const double radiance[2] = {2.0, 0.5};
	shade_sh sh = stilb_numeric_sh_project(two_halves, radiance, 2);
	stilb_vec3 sky = stilb_vec3_make(2.0f, 2.0f, 2.0f), ground = stilb_vec3_make(0.5f, 0.5f, 0.5f);
	shade_proof_random random = {.seed = 1};
	for (int k = 0; k < 100; k++) {
		stilb_vec3 n = shade_proof_random_direction(&random);
		double want = (double)shade_hemisphere_irradiance(n[2], sky, ground)[0];
		SHADE_PROOF_NEAR(shade_sh_irradiance(sh, n), want, 2e-6, 0.0);
	}
}

/* ---- environment maps -------------------------------------------------------------------------------------------- */

static stilb_image made_map(uint32_t width, uint32_t height, uint32_t channels)
{
	stilb_image map;
	assert_int_equal(stilb_image_create(&map, width, height, channels, STILB_IMAGE_F32_LINEAR), STILB_OK);
	return map;
}

static stilb_image random_map(uint32_t width, uint32_t height, uint32_t channels)
{
	stilb_image map = made_map(width, height, channels);
	float *values = map.pixels;
	for (uint32_t i = 0; i < width * height * channels; i++)
		values[i] = 4.0f * stilb_random_float(2, i);
	return map;
}

static shade_sh_rgb projected(const stilb_image *map)
{
	shade_sh_rgb sh;
	assert_int_equal(stilb_numeric_sh_project_map(map, &sh), STILB_OK);
	return sh;
}

/* Compares the projection of the map's green with sums over 60 x 60 pieces of each texel, the basis being evaluated in
 * each piece's middle. */
static void assert_green_by_midpoints(const stilb_image *map, shade_sh got)
{
	enum { PIECES = 60 };
	const float *values = map->pixels;
	uint32_t width = map->width * PIECES, height = map->height * PIECES;
	double sum[9] = {0};
	for (uint32_t y = 0; y < height; y++)
		for (uint32_t x = 0; x < width; x++) {
			double d[3], area = M_PI / height * 2.0 * M_PI / width;
			stilb_numeric_latlong_direction((x + 0.5) / width, (y + 0.5) / height, d);
			shade_sh basis = shade_sh_basis(stilb_vec3_make((float)d[0], (float)d[1], (float)d[2]));
			double light = (double)values[(y / PIECES * map->width + x / PIECES) * map->channels + 1] * area;
			for (int i = 0; i < 9; i++)
				sum[i] += light * sin(M_PI * (y + 0.5) / height) * (double)basis.c[i];
		}
	for (int i = 0; i < 9; i++)
		SHADE_PROOF_NEAR(got.c[i], sum[i], 0.0, 4e-4);
}

static void map_is_integrated(void **state)
{
	(void)state;
	stilb_image map = random_map(5, 3, 3);
	assert_green_by_midpoints(&map, projected(&map).g);
	stilb_image_finish(&map);
}

/* A map in which each texel is replaced by four of its colour is the same light: it has the same coefficients. */
static void resolution_adds_nothing(void **state)
{
	(void)state;
	stilb_image small = random_map(6, 4, 3), large = made_map(12, 8, 3);
	const float *from = small.pixels;
	float *to = large.pixels;
	for (uint32_t y = 0; y < 8; y++)
		for (uint32_t x = 0; x < 12; x++)
			memcpy(to + (y * 12 + x) * 3, from + (y / 2 * 6 + x / 2) * 3, 3 * sizeof(float));
	shade_sh_rgb a = projected(&small), b = projected(&large);
	for (int i = 0; i < 9; i++) {
		SHADE_PROOF_NEAR(b.r.c[i], (double)a.r.c[i], 1e-6, 1e-6);
		SHADE_PROOF_NEAR(b.b.c[i], (double)a.b.c[i], 1e-6, 1e-6);
	}
	stilb_image_finish(&small);
	stilb_image_finish(&large);
}

/* One row of white sky above one of black ground: two texels are enough for the exact irradiance. */
static void two_texels_are_a_sky(void **state)
{
	(void)state;
	stilb_image map = made_map(1, 2, 1);
	*(float *)map.pixels = 1.0f;
	shade_sh_rgb sh = projected(&map);
	stilb_vec3 white = stilb_vec3_make(1.0f, 1.0f, 1.0f), black = stilb_vec3_make(0.0f, 0.0f, 0.0f);
	shade_proof_random random = {.seed = 3};
	for (int k = 0; k < 100; k++) {
		stilb_vec3 n = shade_proof_random_direction(&random);
		stilb_vec3 want = shade_hemisphere_irradiance(n[1], white, black);
		SHADE_PROOF_NEAR3(shade_sh_rgb_irradiance(sh, n), want[0], want[1], want[2], 0.0, 2e-6);
	}
	stilb_image_finish(&map);
}

static void map_has_its_directions(void **state)
{
	(void)state;
	static const struct {
		double u, v, d[3];
	} places[] = {
		{0.5, 0.0, {0, 1, 0}},  {0.5, 1.0, {0, -1, 0}},  {0.5, 0.5, {0, 0, -1}},
		{0.75, 0.5, {1, 0, 0}}, {0.25, 0.5, {-1, 0, 0}}, {0.0, 0.5, {0, 0, 1}},
	};
	for (size_t i = 0; i < sizeof places / sizeof places[0]; i++) {
		double d[3];
		stilb_numeric_latlong_direction(places[i].u, places[i].v, d);
		for (int axis = 0; axis < 3; axis++)
			SHADE_PROOF_NEAR(d[axis], places[i].d[axis], 0.0, 1e-12);
	}
}

/* A lamp of one texel: the light comes from where the texel is, and is as strong as the texel is large. */
static void bright_texel_is_a_light(void **state)
{
	(void)state;
	uint32_t width = 64, height = 32;
	for (uint32_t k = 0; k < 40; k++) {
		uint32_t x = k * 37 % width, y = 3 + k * 11 % (height - 6);
		stilb_image map = made_map(width, height, 4);
		float *texel = (float *)map.pixels + (y * width + x) * 4;
		texel[0] = 100.0f;
		texel[1] = 200.0f;
		texel[2] = 50.0f;
		shade_sh_light light = shade_sh_dominant_light(projected(&map));
		double d[3], solid_angle = (cos(M_PI * y / height) - cos(M_PI * (y + 1) / height)) * 2.0 * M_PI / width;
		stilb_numeric_latlong_direction((x + 0.5) / width, (y + 0.5) / height, d);
		SHADE_PROOF_NEAR3(light.direction, d[0], d[1], d[2], 0.0, 3e-3);
		SHADE_PROOF_NEAR3(light.irradiance, 100.0 * solid_angle, 200.0 * solid_angle, 50.0 * solid_angle, 5e-3, 0.0);
		stilb_image_finish(&map);
	}
}

static void grey_and_alpha_are_understood(void **state)
{
	(void)state;
	stilb_image grey = random_map(4, 3, 2), color = made_map(4, 3, 4);
	const float *from = grey.pixels;
	float *to = color.pixels;
	for (uint32_t i = 0; i < 12; i++) {
		to[4 * i] = to[4 * i + 1] = to[4 * i + 2] = from[2 * i];
		to[4 * i + 3] = NAN; /* alpha is ignored, so NaN does no harm */
	}
	shade_sh_rgb a = projected(&grey), b = projected(&color);
	assert_memory_equal(&a, &b, sizeof a);
	assert_memory_equal(&a.r, &a.b, sizeof a.r);
	stilb_image_finish(&grey);
	stilb_image_finish(&color);
}

static void bad_maps_are_refused(void **state)
{
	(void)state;
	shade_sh_rgb sh = {.r = {{42.0f}}}, before = sh;
	stilb_image codes, map = random_map(4, 3, 3);
	assert_int_equal(stilb_image_create(&codes, 4, 2, 3, STILB_IMAGE_U8_SRGB), STILB_OK);
	assert_int_equal(stilb_numeric_sh_project_map(&codes, &sh), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), ".exr"));
	const float bad[] = {NAN, INFINITY, -INFINITY, 2e30f};
	for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
		((float *)map.pixels)[(1 * 4 + 2) * 3 + 1] = bad[i];
		assert_int_equal(stilb_numeric_sh_project_map(&map, &sh), STILB_ERROR_ARGUMENT);
		assert_non_null(strstr(stilb_error_message(), "column 2, row 1"));
	}
	assert_memory_equal(&sh, &before, sizeof sh);
	stilb_image_finish(&codes);
	stilb_image_finish(&map);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(three_bands_come_back),
		cmocka_unit_test(cosine_lobe_has_its_bands),
		cmocka_unit_test(two_halves_have_their_irradiance),
		cmocka_unit_test(map_is_integrated),
		cmocka_unit_test(resolution_adds_nothing),
		cmocka_unit_test(two_texels_are_a_sky),
		cmocka_unit_test(map_has_its_directions),
		cmocka_unit_test(bright_texel_is_a_light),
		cmocka_unit_test(grey_and_alpha_are_understood),
		cmocka_unit_test(bad_maps_are_refused),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
