/* What frames are given of a panorama, without a device: its light at random normals against the sum over all texels,
 * and the same bytes for any number of workers, at once or in slices. */
#include "numeric/numeric_dfg.h"
#include "numeric/numeric_sh.h"
#include "panorama_exact.h"
#include "render/render_panorama.h"
#include "shading/shade_environment.h"
#include "shading/shade_light_area.h"
#include "support/shade_proof.h"
#include "support/test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- panoramas --------------------------------------------------------------------------------------------------- */

static stilb_image map_of(uint32_t width, uint32_t height, uint32_t channels)
{
	stilb_image map;
	assert_int_equal(stilb_image_create(&map, width, height, channels, STILB_IMAGE_F32_LINEAR), STILB_OK);
	memset(map.pixels, 0, stilb_image_size(&map));
	return map;
}

static float *texel_of(const stilb_image *map, uint32_t x, uint32_t y)
{
	return (float *)map->pixels + ((size_t)y * map->width + x) * map->channels;
}

/* Noise, a few windows of any size and colour, and some suns of a texel or a few. */
static stilb_image random_map(shade_proof_random *random, uint32_t width, uint32_t height)
{
	stilb_image map = map_of(width, height, 3);
	for (uint32_t i = 0; i < width * height * 3; i++)
		((float *)map.pixels)[i] = shade_proof_range(random, 0.0f, 0.5f);
	for (int window = 0; window < 6; window++) {
		float left = shade_proof_range(random, 0.0f, 1.0f), top = shade_proof_range(random, 0.1f, 0.8f);
		float wide = shade_proof_range(random, 0.005f, 0.15f), high = shade_proof_range(random, 0.01f, 0.2f), light[3];
		for (int c = 0; c < 3; c++)
			light[c] = shade_proof_range(random, 0.1f, 0.4f) / (wide * high);
		uint32_t across = (uint32_t)(wide * (float)width) + 1, down = (uint32_t)(high * (float)height) + 1;
		for (uint32_t y = (uint32_t)(top * (float)height); down > 0 && y < height; y++, down--)
			for (uint32_t x = 0; x < across; x++)
				memcpy(texel_of(&map, ((uint32_t)(left * (float)width) + x) % width, y), light, sizeof light);
	}
	for (int sun = 0; sun < 3; sun++) {
		uint32_t x = (uint32_t)(shade_proof_range(random, 0.0f, 0.999f) * (float)width);
		uint32_t y = (uint32_t)(shade_proof_range(random, 0.2f, 0.8f) * (float)height);
		float light = shade_proof_range(random, 0.5f, 3.0f) * (float)(width * height) / 10.0f;
		for (int c = 0; c < 3; c++)
			texel_of(&map, x, y)[c] = texel_of(&map, (x + 1) % width, y)[c] = light;
	}
	return map;
}

/* ---- made -------------------------------------------------------------------------------------------------------- */

typedef struct made {
	render_panorama panorama;
	void *shown, *next;
	size_t bytes;
	uint16_t cube[RENDER_PANORAMA_CUBE][4], dfg[RENDER_PANORAMA_DFG][RENDER_PANORAMA_DFG][2];
	uint32_t dfg_sent; /* how often */
	bool refuses;
} made;

static void *made_make(void *user, size_t bytes)
{
	made *m = user;
	free(m->next);
	m->next = m->refuses ? NULL : calloc(1, bytes);
	m->bytes = bytes;
	return m->next;
}

static stilb_result made_show(void *user, const render_panorama_gloss *gloss)
{
	made *m = user;
	assert_non_null(m->next);
	memcpy(m->cube, gloss->cube, sizeof m->cube);
	if (gloss->dfg)
		memcpy(m->dfg, gloss->dfg, sizeof m->dfg);
	m->dfg_sent += gloss->dfg ? 1 : 0;
	free(m->shown);
	m->shown = m->next;
	m->next = NULL;
	return STILB_OK;
}

static stilb_result made_update(made *m, const stilb_image *map, bool sliced, stilb_job_pool *pool)
{
	return render_panorama_update(&m->panorama, map, (render_panorama_memory){made_make, made_show, m}, sliced, pool,
	                              0);
}

static made made_of(const stilb_image *map)
{
	made m = {.shown = NULL};
	assert_int_equal(made_update(&m, map, false, NULL), STILB_OK);
	assert_true(m.shown && render_panorama_shows(&m.panorama, map));
	return m;
}

static void made_finish(made *m)
{
	render_panorama_finish(&m->panorama);
	free(m->shown);
	free(m->next);
}

/* Irradiance at a normal in the panorama's own axes, as shaders/mesh.frag computes it. */
static void made_irradiance(const made *m, const double n[3], double out[3])
{
	const render_panorama_table *table = m->shown;
	double x = (atan2(n[0], -n[2]) / (2.0 * M_PI) + 0.5) * RENDER_PANORAMA_COLUMNS;
	double y = acos(n[1]) / M_PI * (RENDER_PANORAMA_ROWS - 1);
	uint32_t column = (uint32_t)x, row = (uint32_t)fmin(y, RENDER_PANORAMA_ROWS - 2);
	stilb_vec3 normal = stilb_vec3_make((float)n[0], (float)n[1], (float)n[2]);
	for (int c = 0; c < 3; c++) {
		double across = x - column, down = y - row, value[2];
		for (uint32_t i = 0; i < 2; i++)
			value[i] = (1.0 - across) * (double)(*table)[row + i][column % RENDER_PANORAMA_COLUMNS][c] +
			           across * (double)(*table)[row + i][(column + 1) % RENDER_PANORAMA_COLUMNS][c];
		out[c] = (1.0 - down) * value[0] + down * value[1];
		for (uint32_t i = 0; i < m->panorama.lamp_count; i++) {
			const render_panorama_lamp *l = &m->panorama.lamps[i];
			out[c] += (double)(l->irradiance[c] *
			                   shade_distant_share(stilb_vec3_make(l->direction[0], l->direction[1], l->direction[2]),
			                                       stilb_vec3_make(l->half_x[0], l->half_x[1], l->half_x[2]),
			                                       stilb_vec3_make(l->half_y[0], l->half_y[1], l->half_y[2]), normal));
		}
	}
}

#define NORMALS (TEST_ASAN ? 4 : 30) /* where light is compared: the exact sum is over all texels */

/* The largest difference from the exact light at random normals, as a share of the largest value. */
static double made_error(const made *m, const stilb_image *map, shade_proof_random *random, int count)
{
	double most = 0.0, apart = 0.0;
	for (int i = 0; i < count; i++) {
		double n[3], exact[3], live[3];
		double height = (double)shade_proof_range(random, -1.0f, 1.0f);
		double phi = (double)shade_proof_range(random, -3.14159f, 3.14159f);
		n[0] = sqrt(1.0 - height * height) * sin(phi);
		n[1] = height;
		n[2] = -sqrt(1.0 - height * height) * cos(phi);
		panorama_exact(map, 0.0, n, exact);
		made_irradiance(m, n, live);
		for (int c = 0; c < 3; c++) {
			most = fmax(most, exact[c]);
			apart = fmax(apart, fabs(live[c] - exact[c]));
		}
	}
	return apart / most;
}

/* ---- tests ------------------------------------------------------------------------------------------------------- */

/* The sum over texels is exact where it can be known: constant light gives pi, a hemisphere its closed form. */
static void the_exact_sum_is_exact(void **state)
{
	(void)state;
	stilb_image map = map_of(90, 44, 3);
	double n[3] = {0.48, 0.6, -0.64}, out[3];
	for (uint32_t i = 0; i < 90 * 44 * 3; i++)
		((float *)map.pixels)[i] = i % 3 == 0 || i / 270 < 22 ? 1.0f : 0.0f;
	panorama_exact(&map, 0.7, n, out);
	assert_true(fabs(out[0] - M_PI) < 1e-5 * M_PI);
	assert_true(fabs(out[1] - M_PI * 0.5 * (1.0 + n[1])) < 1e-4 * M_PI && out[1] == out[2]);
	stilb_image_finish(&map);
}

static void light_is_that_of_all_texels(void **state)
{
	(void)state;
	static const uint32_t sizes[][2] = {{90, 45}, {333, 111}, {64, 200}, {512, 256}, {400, 200}, {1, 1}};
	shade_proof_random random = {.seed = 7};
	uint32_t lamps = 0;
	for (int i = 0; i < (TEST_ASAN ? 6 : 12); i++) {
		const uint32_t *size = sizes[i % 6];
		stilb_image map = random_map(&random, size[0], size[1]);
		made m = made_of(&map);
		double apart = made_error(&m, &map, &random, NORMALS);
		printf("%4u x %3u: %u lamps, %.1e\n", size[0], size[1], m.panorama.lamp_count, apart);
		assert_true(apart < (size[0] < size[1] ? 1e-3 : 4e-4)); /* wide texels have suns that are stripes */
		lamps += m.panorama.lamp_count;
		made_finish(&m);
		stilb_image_finish(&map);
	}
	assert_true(lamps > (TEST_ASAN ? 2 : 12));
}

/* Suns of half a degree all over the sky, at the poles and across the seam too, are lamps with all of their light. */
static void suns_are_lamps(void **state)
{
	(void)state;
	static const double suns[][2] = {{0.0, 0.5}, {1.0, 0.3}, {0.5, 0.0}, {0.25, 1.0}, {0.7, 0.01}, {0.31, 0.77}};
	shade_proof_random random = {.seed = 9};
	for (size_t i = 0; i < sizeof suns / sizeof *suns; i += TEST_ASAN ? 3 : 1) {
		stilb_image map = map_of(720, 360, 3);
		double phi = 2.0 * M_PI * (suns[i][0] - 0.5), theta = M_PI * suns[i][1];
		double sun[3] = {sin(theta) * sin(phi), cos(theta), -sin(theta) * cos(phi)};
		for (uint32_t k = 0; k < 720 * 360; k++) {
			double p = 2.0 * M_PI * ((k % 720 + 0.5) / 720.0 - 0.5), t = M_PI * (k / 720 + 0.5) / 360.0;
			double own[3] = {sin(t) * sin(p), cos(t), -sin(t) * cos(p)};
			for (int c = 0; c < 3; c++)
				((float *)map.pixels)[3 * k + (uint32_t)c] = panorama_exact_dot(own, sun) > cos(0.008) ? 9000.0f : 0.3f;
		}
		made m = made_of(&map);
		assert_int_equal(m.panorama.lamp_count, 1);
		for (int c = 0; c < 3; c++)
			assert_true(fabs((double)m.panorama.lamps[0].direction[c] - sun[c]) < 0.002);
		assert_true(made_error(&m, &map, &random, TEST_ASAN ? 2 : 12) < 4e-4);
		made_finish(&m);
		stilb_image_finish(&map);
	}
}

/* The same error at normals whose horizon passes near a direction: at angles up to 0.03 from a right one to it. */
static double made_error_across(const made *m, const stilb_image *map, const double direction[3])
{
	double most = 0.0, apart = 0.0, exact[3], live[3];
	panorama_exact(map, 0.0, direction, exact);
	most = fmax(exact[0], fmax(exact[1], exact[2]));
	double right[3] = {direction[2], 0.0, -direction[0]}, level = sqrt(panorama_exact_dot(right, right));
	for (int side = 0; side < 8; side += TEST_ASAN ? 5 : 1)
		for (double above = -0.03; above <= 0.03; above += 0.005) {
			double turn = side * M_PI / 4.0 + 0.2, n[3];
			for (int c = 0; c < 3; c++) {
				double r = right[c] / level, next = right[(c + 1) % 3] / level, last = right[(c + 2) % 3] / level;
				double up = direction[(c + 1) % 3] * last - direction[(c + 2) % 3] * next;
				n[c] = sqrt(1.0 - above * above) * (cos(turn) * r + sin(turn) * up) + above * direction[c];
			}
			panorama_exact(map, 0.0, n, exact);
			made_irradiance(m, n, live);
			for (int c = 0; c < 3; c++)
				apart = fmax(apart, fabs(live[c] - exact[c]));
		}
	return apart / most;
}

/* Lamps with a shape in front of nearly nothing, as high or low as their texels, where the horizon cuts them. */
static void lamps_set_behind_the_horizon(void **state)
{
	(void)state;
	static const uint32_t shapes[][6] = {/* texels across and down, and of the lamp its first and its size */
	                                     {360, 180, 100, 60, 2, 1},
	                                     {720, 360, 300, 170, 4, 1},
	                                     {720, 360, 500, 130, 1, 3},
	                                     {300, 150, 0, 50, 1, 1}};
	for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
		const uint32_t *s = shapes[i];
		stilb_image map = map_of(s[0], s[1], 3);
		for (uint32_t k = 0; k < s[0] * s[1] * 3; k++)
			((float *)map.pixels)[k] = 0.001f;
		for (uint32_t y = s[3]; y < s[3] + s[5]; y++)
			for (uint32_t x = s[2]; x < s[2] + s[4]; x++)
				for (int c = 0; c < 3; c++)
					texel_of(&map, x, y)[c] = 1000.0f;
		made m = made_of(&map);
		double phi = 2.0 * M_PI * ((s[2] + 0.5 * s[4]) / s[0] - 0.5), theta = M_PI * (s[3] + 0.5 * s[5]) / s[1];
		double direction[3] = {sin(theta) * sin(phi), cos(theta), -sin(theta) * cos(phi)};
		double apart = made_error_across(&m, &map, direction);
		printf("lamp of %u x %u texels: %.1e\n", s[4], s[5], apart);
		assert_true(m.panorama.lamp_count >= 1 && apart < 5e-5); /* what lies farther from its middle may be another */
		made_finish(&m);
		stilb_image_finish(&map);
	}
}

/* Windows are none, however bright: light is as bright beside their middle. Nor are stripes, which leave the table to
 * find each cell's place. */
static void windows_and_stripes_are_no_lamps(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 2};
	for (int stripes = 0; stripes < 2; stripes++) {
		stilb_image map = map_of(512, 256, 3);
		for (uint32_t y = 0; y < 256; y++)
			for (uint32_t x = 0; x < 512; x++) {
				bool lit = stripes ? x % 8 == 3 || y % 64 == 5 : x < 30 && y > 100 && y < 125;
				for (int c = 0; c < 3; c++)
					texel_of(&map, x, y)[c] = lit ? 10.0f : 0.01f;
			}
		made m = made_of(&map);
		double apart = made_error(&m, &map, &random, 30);
		printf("%s: %.1e\n", stripes ? "stripes" : "window", apart);
		assert_true(m.panorama.lamp_count == 0 && apart < 3e-4);
		made_finish(&m);
		stilb_image_finish(&map);
	}
}

static void same_is_the_same(const made *a, const made *b)
{
	assert_int_equal(a->bytes, b->bytes);
	assert_memory_equal(a->shown, b->shown, a->bytes);
	assert_memory_equal(a->cube, b->cube, sizeof a->cube);
	assert_memory_equal(a->dfg, b->dfg, sizeof a->dfg);
	assert_int_equal(a->panorama.lamp_count, b->panorama.lamp_count);
	assert_memory_equal(a->panorama.lamps, b->panorama.lamps, sizeof a->panorama.lamps);
	assert_memory_equal(&a->panorama.around, &b->panorama.around, sizeof a->panorama.around);
	assert_true(a->panorama.key == b->panorama.key);
}

/* The means of the halves and the harmonics, lamps included, are those of the panorama's texels: the light of a cell
 * that shines from its middle is off by less than 1e-5 of all light, that of a texel that two rows of cells share by as
 * much as the texel is wide: none lies on the horizon here. A narrow light is blurred until its irradiance is nowhere
 * negative, all other light not at all. */
static void ambient_light_is_that_of_all_texels(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 11};
	for (int narrow = 0; narrow < 2; narrow++) {
		stilb_image map = random_map(&random, 256, 128);
		for (uint32_t i = 0; i < 256 * 128; i++) { /* a spot of 20 degrees in the dark */
			bool spot = i % 256 > 200 && i % 256 < 215 && i / 256 > 40 && i / 256 < 55;
			for (uint32_t c = 0; c < 3; c++)
				((float *)map.pixels)[3 * i + c] *= narrow && !spot ? 0.0f : 1.0f;
		}
		made m = made_of(&map);
		const render_panorama_around *around = &m.panorama.around;
		shade_sh_rgb exact;
		assert_int_equal(stilb_numeric_sh_project_map(&map, &exact), STILB_OK);
		double halves[2] = {0.0, 0.0};
		for (uint32_t i = 0; i < 256 * 128; i++)
			halves[i / 256 >= 64] += (double)((float *)map.pixels)[3 * i + 1] *
			                         (cos(M_PI * (i / 256) / 128.0) - cos(M_PI * (i / 256 + 1) / 128.0)) / 256.0;
		assert_true(fabs((double)around->sky[1] - halves[0]) <= 1e-5 * (halves[0] + halves[1]));
		assert_true(fabs((double)around->ground[1] - halves[1]) <= 1e-5 * (halves[0] + halves[1]));
		double blur = -0.5 * log((double)around->harmonics.g.c[1] / (double)exact.g.c[1]);
		double least = 1.0;
		for (int i = 0; i < 9; i++) {
			int l = i == 0 ? 0 : i < 4 ? 1 : 2;
			double wanted = (double)exact.g.c[i] * exp(-l * (l + 1) * blur);
			assert_true(fabs((double)around->harmonics.g.c[i] - wanted) <= 3e-5 * (double)exact.g.c[0]);
		}
		for (int i = 0; i < 5000; i++) {
			stilb_vec3 n = shade_proof_random_direction(&random);
			least = fmin(least, (double)shade_sh_irradiance(around->harmonics.g, n) / (double)exact.g.c[0]);
		}
		assert_true(narrow ? blur > 0.05 && blur <= 0.0931 : fabs(blur) < 1e-3);
		assert_true(narrow ? least > -1e-3 && least < 0.01 : least > 0.1);
		made_finish(&m);
		stilb_image_finish(&map);
	}
}

static void workers_and_slices_change_nothing(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 3};
	stilb_image map = random_map(&random, 1900, TEST_TSAN ? 95 : TEST_ASAN ? 200 : 900);
	made alone = made_of(&map);
	for (uint32_t workers = TEST_TSAN ? 2 : 0; workers < 4; workers++) {
		stilb_job_pool *pool;
		stilb_job_pool_desc desc = stilb_job_pool_desc_default();
		desc.worker_count = workers;
		assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
		made sliced = {.shown = NULL};
		uint32_t frames = 0;
		do {
			assert_int_equal(made_update(&sliced, &map, workers != 2, pool), STILB_OK);
			frames++;
		} while (sliced.panorama.next);
		assert_true(workers == 2 ? frames == 1 : frames > 5 && frames < 120);
		same_is_the_same(&alone, &sliced);
		made_finish(&sliced);
		stilb_job_pool_destroy(pool);
	}
	made_finish(&alone);
	stilb_image_finish(&map);
}

/* While the next one is made the last one is shown; another one in between, and none. */
static void the_last_one_is_shown_until_the_next_is_made(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 5};
	stilb_image first = random_map(&random, 90, 45), second = random_map(&random, 1200, 600);
	stilb_image third = random_map(&random, 1201, 1400); /* more texels than are read in a frame */
	made m = made_of(&first), alone = made_of(&third);
	uint64_t key = m.panorama.key;
	for (int frame = 0; frame < 3; frame++)
		assert_int_equal(made_update(&m, &second, true, NULL), STILB_OK);
	assert_true(m.panorama.next && m.panorama.key == key && render_panorama_shows(&m.panorama, &second));
	assert_false(render_panorama_shows(&m.panorama, &first));
	assert_int_equal(made_update(&m, &third, true, NULL), STILB_OK);
	assert_true(m.panorama.key == key);
	stilb_image moved = map_of(1201, 1400, 3); /* the same values at another place, and no longer at the first */
	memcpy(moved.pixels, third.pixels, stilb_image_size(&third));
	memset(third.pixels, 0, stilb_image_size(&third));
	do
		assert_int_equal(made_update(&m, &moved, true, NULL), STILB_OK);
	while (m.panorama.next);
	same_is_the_same(&m, &alone);
	stilb_image_finish(&third);
	third = moved;
	render_panorama_renew(&m.panorama); /* another scene, with the same values at the same place */
	assert_int_equal(made_update(&m, &third, true, NULL), STILB_OK);
	assert_true(m.panorama.next && render_panorama_shows(&m.panorama, &third));
	assert_int_equal(made_update(&m, &third, false, NULL), STILB_OK);
	same_is_the_same(&m, &alone);
	render_panorama_leave(&m.panorama);
	assert_true(render_panorama_shows(&m.panorama, &third));
	render_panorama_renew(&m.panorama);
	render_panorama_leave(&m.panorama);
	assert_false(render_panorama_shows(&m.panorama, &third));
	made_finish(&m);
	made_finish(&alone);
	stilb_image_finish(&first);
	stilb_image_finish(&second);
	stilb_image_finish(&third);
}

static double half(uint16_t bits)
{
	int exponent = bits >> 10 & 31, mantissa = bits & 1023;
	return exponent ? ldexp(1024 + mantissa, exponent - 25) : ldexp(mantissa, -24);
}

/* Means of what a texel covers, in the nearest half floats; values that are none count as 0 or as the largest. */
static void texels_are_the_nearest_halves(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 1};
	stilb_image map = map_of(4096, 3, 4);
	for (uint32_t i = 0; i < 4096 * 3; i++)
		for (int c = 0; c < 3; c++)
			((float *)map.pixels)[4 * i + (uint32_t)c] = exp2f(shade_proof_range(&random, -26.0f, 17.0f));
	texel_of(&map, 0, 0)[0] = texel_of(&map, 1, 0)[0] = NAN;
	texel_of(&map, 0, 0)[1] = texel_of(&map, 1, 0)[1] = -1.0f;
	texel_of(&map, 0, 0)[2] = INFINITY;
	for (uint32_t x = 2; x < 4; x++) { /* ties */
		texel_of(&map, x, 0)[0] = 1.0f + 0x1p-11f;
		texel_of(&map, x, 0)[1] = 1.0f + 0x3p-11f;
	}
	made m = made_of(&map);
	const uint16_t(*texels)[4] = (const void *)((const char *)m.shown + sizeof(render_panorama_table));
	assert_int_equal(m.panorama.width, 2048);
	assert_int_equal(m.panorama.height, 3);
	assert_true(texels[0][0] == 0 && texels[0][1] == 0 && half(texels[0][2]) == 65504.0);
	assert_true(half(texels[1][0]) == 1.0 && half(texels[1][1]) == 1.0 + 0x1p-9);
	for (uint32_t i = 1; i < 2048 * 3; i++)
		for (int c = 0; c < 3; c++) {
			const float *pair = (const float *)map.pixels + 8 * (size_t)i;
			double mean = fmin(0.5 * ((double)pair[c] + (double)pair[4 + c]), 65504.0), value = half(texels[i][c]);
			double step = fmax(ldexp(1.0, ilogb(mean) - 10), 0x1p-24);
			assert_true(fabs(value - mean) <= 0.5001 * step && texels[i][3] == 0);
		}
	made_finish(&m);
	stilb_image_finish(&map);
}

/* ---- gloss ------------------------------------------------------------------------------------------------------- */

/* All light of a map, L dw, of one colour. */
static double light_of(const stilb_image *map, uint32_t color)
{
	double sum = 0.0;
	for (uint32_t y = 0; y < map->height; y++) {
		double ring = cos(M_PI * y / map->height) - cos(M_PI * (y + 1) / map->height);
		for (uint32_t x = 0; x < map->width; x++)
			sum += (double)texel_of(map, x, y)[color] * ring * 2.0 * M_PI / map->width;
	}
	return sum;
}

/* The same of a mip of the cube. */
static double light_of_cube(const made *m, uint32_t mip, uint32_t color)
{
	uint32_t side = RENDER_PANORAMA_FACE >> mip;
	const uint16_t(*texel)[4] = m->cube;
	double sum = 0.0;
	for (uint32_t finer = 0; finer < mip; finer++)
		texel += (size_t)6 * (RENDER_PANORAMA_FACE >> finer) * (RENDER_PANORAMA_FACE >> finer);
	for (uint32_t i = 0; i < 6 * side * side; i++) {
		double s = (2.0 * (i % side) + 1.0) / side - 1.0, t = (2.0 * (i / side % side) + 1.0) / side - 1.0;
		sum += half(texel[i][color]) * 4.0 / (side * side) / pow(1.0 + s * s + t * t, 1.5);
	}
	return sum;
}

/* The cube and the lamps together have the panorama's light, in every mip: nothing counts twice, and nothing is lost.
 * The table is that of GGX, for a second panorama, too. */
static void gloss_has_all_light_but_the_lamps(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 11};
	made m = {.shown = NULL};
	for (int map_number = 0; map_number < 2; map_number++) {
		stilb_image map = random_map(&random, 512, 256);
		assert_int_equal(made_update(&m, &map, false, NULL), STILB_OK);
		assert_true(m.panorama.lamp_count > 0);
		assert_int_equal(m.dfg_sent, 1);
		for (uint32_t c = 0; c < 3; c++) {
			double all = light_of(&map, c), lamps = 0.0;
			for (uint32_t i = 0; i < m.panorama.lamp_count; i++)
				lamps += (double)m.panorama.lamps[i].irradiance[c];
			assert_true(lamps > 0.05 * all);
			for (uint32_t mip = 0; mip < RENDER_PANORAMA_MIPS; mip++) {
				double apart = fabs(light_of_cube(&m, mip, c) + lamps - all) / all;
				assert_true(apart < (mip < 4 ? 2e-3 : 2e-2)); /* few texels stand for their middles */
			}
		}
		for (uint32_t row = 0; row < RENDER_PANORAMA_DFG; row += 21)
			for (uint32_t column = 0; column < RENDER_PANORAMA_DFG; column += 9) {
				stilb_vec2 at = shade_dfg_from_place(
					(stilb_vec2){(float)column / (RENDER_PANORAMA_DFG - 1), (float)row / (RENDER_PANORAMA_DFG - 1)});
				stilb_numeric_dfg dfg = stilb_numeric_dfg_of(fmin((double)at[0], 1.0), fmin((double)at[1], 1.0));
				assert_true(fabs(half(m.dfg[row][column][0]) - dfg.a) < 3e-4);
				assert_true(fabs(half(m.dfg[row][column][1]) - dfg.b) < 3e-4);
			}
		stilb_image_finish(&map);
	}
	made_finish(&m);
}

static void no_memory_is_said(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 1};
	stilb_image map = random_map(&random, 40, 20), grey = map_of(4, 4, 1);
	made m = {.refuses = true};
	assert_int_equal(made_update(&m, &map, false, NULL), STILB_ERROR_MEMORY);
	assert_non_null(strstr(stilb_error_message(), "40 x 20"));
	assert_false(render_panorama_shows(&m.panorama, &map) || render_panorama_is_good(&grey));
	m.refuses = false;
	assert_int_equal(made_update(&m, &map, false, NULL), STILB_OK);
	assert_true(render_panorama_shows(&m.panorama, &map));
	made_finish(&m);
	stilb_image_finish(&map);
	stilb_image_finish(&grey);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		test_one_thread(the_exact_sum_is_exact),
		test_one_thread(light_is_that_of_all_texels),
		test_one_thread(suns_are_lamps),
		test_one_thread(lamps_set_behind_the_horizon),
		test_one_thread(windows_and_stripes_are_no_lamps),
		cmocka_unit_test(ambient_light_is_that_of_all_texels),
		cmocka_unit_test(workers_and_slices_change_nothing),
		test_one_thread(the_last_one_is_shown_until_the_next_is_made),
		test_one_thread(texels_are_the_nearest_halves),
		test_one_thread(gloss_has_all_light_but_the_lamps),
		test_one_thread(no_memory_is_said),
	};
	setenv("STILB_CACHE", "off", 1); /* what is tested is made, not read */
	return cmocka_run_group_tests(tests, NULL, NULL);
}
