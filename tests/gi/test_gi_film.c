/* What a pixel makes of its samples: means, variances, weights, and what a preview shows where there is none yet. */
#include "gi/film/gi_film.h"

#include "shading/shade_firefly.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define COUNT 1000

static stilb_vec3 radiance_of(uint32_t i)
{
	float bright = stilb_random_float(3, i) < 0.01f ? 400.0f : 1.0f;
	return stilb_vec3_make(bright * stilb_random_float(1, i), stilb_random_float(2, i), 0.25f);
}

static void add(gi_film *film, size_t pixel, stilb_vec3 radiance, float depth)
{
	const float albedo[3] = {0.5f, 0.25f, 0.125f}, normal[3] = {0.0f, depth < INFINITY ? 1.0f : 0.0f, 0.0f};
	gi_film_sample sample = {.radiance = radiance, .albedo = albedo, .normal = normal, .depth = depth};
	assert_true(gi_film_add(film, pixel, &sample));
}

static gi_film film_of(uint32_t width, uint32_t height, bool weighted)
{
	gi_film film;
	assert_int_equal(gi_film_create(&film, width, height, (gi_film_kind){.weighted = weighted}), STILB_OK);
	return film;
}

static float radiance_at(const gi_film *film, size_t index)
{
	return atomic_load_explicit(&film->radiance[index], memory_order_relaxed);
}

/* The film's means and variances are those of the definitions, computed over the samples one by one. */
static void means_and_variances(void **state)
{
	(void)state;
	gi_film film = film_of(2, 1, false);
	for (uint32_t i = 0; i < COUNT; i++)
		add(&film, 1, radiance_of(i), i % 4 ? (float)(i % 8) : INFINITY);
	gi_film_resolve(&film, 1);
	for (int c = 0; c < 3; c++) {
		double mean = 0.0, variance = 0.0;
		for (uint32_t i = 0; i < COUNT; i++)
			mean += (double)radiance_of(i)[c] / COUNT;
		for (uint32_t i = 0; i < COUNT; i++)
			variance += pow((double)radiance_of(i)[c] - mean, 2.0) / (COUNT - 1.0) / COUNT;
		assert_true(fabs((double)radiance_at(&film, (size_t)(3 + c)) - mean) <= 1e-6 * mean);
		assert_true(fabs((double)film.variance[3 + c] - variance) <= 1e-6 * variance + 1e-18);
	}
	assert_true(film.albedo[3] == 0.5f && film.albedo[5] == 0.125f);
	assert_true(film.normal[4] == 0.75f);
	assert_true(fabsf(film.depth[1] - (1 + 2 + 3 + 5 + 6 + 7) / 6.0f) < 1e-6f);
	assert_int_equal(atomic_load_explicit(&film.samples[1], memory_order_relaxed), COUNT);
	assert_true(isinf(film.depth[0]) && film.variance[0] == 0.0f && radiance_at(&film, 0) == 0.0f);
	gi_film_finish(&film);
}

/* Weighted samples: the mean is Karis's, and the variance agrees with that of many such means. */
static void weights(void **state)
{
	(void)state;
	enum { FILMS = 4000, EACH = 50 };
	gi_film film = film_of(FILMS, 1, true);
	double mean = 0.0, spread = 0.0, variance = 0.0;
	for (uint32_t f = 0; f < FILMS; f++) {
		stilb_vec4 sums = {0.0f, 0.0f, 0.0f, 0.0f};
		for (uint32_t i = 0; i < EACH; i++) {
			add(&film, f, radiance_of(f * EACH + i), 1.0f);
			sums = shade_firefly_add(sums, radiance_of(f * EACH + i), 1.0f);
		}
		gi_film_resolve(&film, f);
		assert_true(fabsf(radiance_at(&film, 3 * f) - shade_firefly_mean(sums)[0]) < 1e-5f);
		mean += (double)radiance_at(&film, 3 * f) / FILMS;
		variance += (double)film.variance[3 * f] / FILMS;
	}
	for (uint32_t f = 0; f < FILMS; f++)
		spread += pow((double)radiance_at(&film, 3 * f) - mean, 2.0) / (FILMS - 1.0);
	assert_true(fabs(variance / spread - 1.0) < 0.08); /* 4000 means: their variance is known to 3 % */
	gi_film_finish(&film);
}

/* The picture's error: what the known variance of its pixels says, once each has two samples. */
static void picture_error(void **state)
{
	(void)state;
	gi_film film = film_of(100, 100, false);
	for (uint32_t i = 0; i < 10000; i++)
		add(&film, i, stilb_vec3_make(1.0f, 1.0f, 1.0f), 1.0f);
	assert_true(isinf(gi_film_error(&film)));
	for (uint32_t i = 0; i < 10000; i++) {
		float x = i % 2 ? 0.5f : 1.5f; /* two numbers 0.5 apart: variance of their mean 0.0625, mean of all pixels 1 */
		add(&film, i, stilb_vec3_make(x, x, x), 1.0f);
		gi_film_resolve(&film, i);
	}
	assert_true(fabs(gi_film_error(&film) - 0.25) < 1e-6);
	gi_film_finish(&film);
	film = film_of(1, 1, false);
	for (int i = 0; i < 2; i++)
		add(&film, 0, stilb_vec3_make(0.0f, 0.0f, 0.0f), INFINITY);
	gi_film_resolve(&film, 0);
	assert_true(gi_film_error(&film) == 0.0);
	gi_film_finish(&film);
}

static void bad_samples(void **state)
{
	(void)state;
	const float bad[] = {NAN, INFINITY, -INFINITY}, zero[3] = {0};
	for (int weighted = 0; weighted < 2; weighted++) {
		gi_film film = film_of(1, 1, weighted);
		for (int i = 0; i < 3; i++) {
			stilb_vec3 radiance = {1.0f, 1.0f, 1.0f};
			radiance[i] = bad[i];
			gi_film_sample sample = {.radiance = radiance, .albedo = zero, .normal = zero, .depth = INFINITY};
			assert_false(gi_film_add(&film, 0, &sample));
		}
		gi_film_resolve(&film, 0);
		assert_true(radiance_at(&film, 0) == 0.0f && film.variance[0] == 0.0f);
		assert_int_equal(atomic_load_explicit(&film.samples[0], memory_order_relaxed), 3);
		gi_film_finish(&film);
	}
}

/* Each pixel without samples shows the corner of the smallest block that has some; sizes that no block divides. */
static void preview(void **state)
{
	(void)state;
	enum { W = 75, H = 41 };
	gi_film film = film_of(W, H, false);
	float *rgb = calloc(3 * W * H, sizeof *rgb);
	for (uint32_t block = 32; block >= 1; block /= 2) {
		for (uint32_t y = 0; y < H; y += block) {
			for (uint32_t x = 0; x < W; x += block) {
				if (film.pixels[y * W + x].samples == 0)
					add(&film, y * W + x, stilb_vec3_make((float)(y * W + x), 0.0f, 1.0f), 1.0f);
				gi_film_resolve(&film, y * W + x);
			}
		}
		gi_film_preview(&film, rgb);
		for (uint32_t y = 0; y < H; y++) {
			for (uint32_t x = 0; x < W; x++)
				assert_true(rgb[3 * (y * W + x)] == (float)(y / block * block * W + x / block * block));
		}
	}
	free(rgb);
	gi_film_finish(&film);
}

/* Bytes of this process that are in memory. */
static size_t resident(void)
{
	unsigned long pages = 0;
	FILE *file = fopen("/proc/self/statm", "r");
	assert_non_null(file);
	assert_int_equal(fscanf(file, "%*u %lu", &pages), 1);
	fclose(file);
	return pages * (size_t)sysconf(_SC_PAGESIZE);
}

/* A large picture begins at once: of the 168 bytes a pixel only the 4 of depth, which begin as infinity, are written
 * before its first sample. */
static void large_films_take_no_memory_yet(void **state)
{
	(void)state;
	size_t before = resident();
	gi_film film = film_of(4096, 4096, false);
	assert_in_range(resident() - before, (size_t)4096 * 4096 * 4, (size_t)4096 * 4096 * 5);
	gi_film_finish(&film);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(means_and_variances), cmocka_unit_test(weights), cmocka_unit_test(picture_error),
		cmocka_unit_test(bad_samples),         cmocka_unit_test(preview), test_no_asan(large_films_take_no_memory_yet)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
