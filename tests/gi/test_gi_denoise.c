/* The denoiser against pictures whose truth is known: what is noise goes, what is not stays, whatever the picture's
 * shape and the number of workers. */
#include "gi/film/gi_denoise.h"
#include "gi_render_fixture.h"

#include <math.h>

#define SAMPLES 16u

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

/* What the camera sees at a pixel, and the light that comes from there. */
typedef struct place {
	float albedo[3], light; /* radiance is albedo x light */
	float normal[3];
	float depth; /* +infinity: nothing is there, and light is what is behind */
} place;

/* The truth at a pixel, and a factor for each of its samples of mean 1. */
typedef place place_fn(uint32_t x, uint32_t y);
typedef float noise_fn(uint64_t pixel, uint32_t sample);

static place wall(uint32_t x, uint32_t y)
{
	(void)x;
	(void)y;
	return (place){{0.5f, 0.5f, 0.5f}, 2.0f, {0.0f, 0.0f, 1.0f}, 4.0f};
}

/* A texture of squares of 4 pixels in a light that grows from left to right. */
static place texture(uint32_t x, uint32_t y)
{
	place p = wall(x, y);
	bool dark = (x / 4 + y / 4) % 2 == 0;
	for (int c = 0; c < 3; c++)
		p.albedo[c] = dark ? 0.1f : 0.8f - 0.2f * (float)c;
	p.light = 1.0f + 0.02f * (float)x;
	return p;
}

/* The shadow of a straight edge, which no feature shows. */
static place shadow(uint32_t x, uint32_t y)
{
	place p = wall(x, y);
	p.light = x + y / 2 < 30 ? 2.0f : 0.2f;
	return p;
}

/* A wall before something that glows behind it: the lower half of the picture is a miss. */
static place half_open(uint32_t x, uint32_t y)
{
	place p = wall(x, y);
	if (y >= 20)
		p = (place){.light = 0.1f * (float)(x % 7), .depth = INFINITY};
	return p;
}

static float even(uint64_t pixel, uint32_t sample)
{
	return 2.0f * stilb_random_float(pixel, sample);
}

static float none(uint64_t pixel, uint32_t sample)
{
	(void)pixel;
	(void)sample;
	return 1.0f;
}

/* Seldom a sample is a hundred times as bright. */
static float fireflies(uint64_t pixel, uint32_t sample)
{
	bool bright = stilb_random_float(pixel, 1000 + sample) < 5e-4f;
	return even(pixel, sample) * (bright ? 100.0f : 1.0f) / (1.0f + 99.0f * 5e-4f);
}

static void film_paint(gi_film *film, place_fn *at, noise_fn *noise, uint32_t samples)
{
	for (uint32_t y = 0; y < film->height; y++)
		for (uint32_t x = 0; x < film->width; x++) {
			place p = at(x, y);
			size_t pixel = (size_t)y * film->width + x;
			for (uint32_t i = 0; i < samples; i++) {
				bool hit = p.depth < INFINITY;
				float light = p.light * (hit ? noise(pixel, i) : 1.0f);
				gi_film_sample sample = {.albedo = p.albedo, .normal = p.normal, .depth = p.depth};
				for (int c = 0; c < 3; c++)
					sample.radiance[c] = hit ? p.albedo[c] * light : light;
				gi_film_add(film, pixel, &sample);
			}
			gi_film_resolve(film, pixel);
		}
}

static gi_film film_make(uint32_t width, uint32_t height)
{
	gi_film film;
	assert_int_equal(gi_film_create(&film, width, height, (gi_film_kind){.halves = true}), STILB_OK);
	return film;
}

static void film_denoise(gi_film *film, uint32_t workers)
{
	stilb_job_pool *pool;
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	desc.worker_count = workers;
	assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
	assert_int_equal(gi_denoise(film, pool, 0), STILB_OK);
	stilb_job_pool_destroy(pool);
	assert_non_null(film->denoised);
}

static float truth_at(place_fn *at, uint32_t x, uint32_t y, size_t c)
{
	place p = at(x, y);
	return p.depth < INFINITY ? p.albedo[c] * p.light : p.light;
}

typedef struct errors {
	double before, after; /* root-mean-square */
	double bias;          /* of the mean, relative */
} errors;

static errors errors_of(const gi_film *film, place_fn *at)
{
	stilb_gi_film planes = gi_film_planes(film);
	double before = 0.0, after = 0.0, sum = 0.0, input = 0.0;
	for (uint32_t y = 0; y < film->height; y++)
		for (uint32_t x = 0; x < film->width; x++)
			for (size_t c = 0; c < 3; c++) {
				size_t i = 3 * ((size_t)y * film->width + x) + c;
				double truth = (double)truth_at(at, x, y, c);
				assert_true(isfinite(planes.denoised[i]));
				before += pow((double)planes.radiance[i] - truth, 2.0);
				after += pow((double)planes.denoised[i] - truth, 2.0);
				sum += (double)planes.denoised[i];
				input += (double)planes.radiance[i];
			}
	double count = 3.0 * film->width * film->height;
	return (errors){sqrt(before / count), sqrt(after / count), sum / input - 1.0};
}

static errors denoised(place_fn *at, noise_fn *noise)
{
	gi_film film = film_make(64, 48);
	film_paint(&film, at, noise, SAMPLES);
	film_denoise(&film, 0);
	errors e = errors_of(&film, at);
	gi_film_finish(&film);
	return e;
}

/* ---- what it does ------------------------------------------------------------------------------------------------ */

/* The halves of any number of samples: together they are all, and of 2^k samples each has as many. */
static void halves(void **state)
{
	(void)state;
	uint32_t first = 0;
	for (uint32_t i = 0; i < 4096; i++) {
		first += gi_film_is_first_half(i);
		uint32_t count = i + 1;
		if ((count & i) == 0 && count > 1)
			assert_int_equal(2 * first, count);
		if (count > 1)
			assert_in_range(3 * first, count, 2 * count); /* a third at least in each */
	}
	assert_true(gi_film_is_first_half(4) && gi_film_is_first_half(5));
	assert_false(gi_film_is_first_half(6) || gi_film_is_first_half(7));
	assert_true(gi_film_is_first_half(1u << 31) && !gi_film_is_first_half(UINT32_MAX));
}

/* Of even noise on an even wall less than a quarter is left, and the mean stays. */
static void even_noise_goes(void **state)
{
	(void)state;
	errors e = denoised(wall, even);
	assert_true(e.before > 0.12 && e.before < 0.17);
	assert_true(e.after < e.before / 4.0);
	assert_true(fabs(e.bias) < 0.001);
}

/* Noise on a texture goes, and its edges stay: the differences of pixels beside each other are right within 5 %. */
static void texture_stays(void **state)
{
	(void)state;
	gi_film film = film_make(64, 48);
	film_paint(&film, texture, even, SAMPLES);
	film_denoise(&film, 0);
	errors e = errors_of(&film, texture);
	assert_true(e.after < e.before / 3.2);
	double wrong = 0.0, all = 0.0;
	for (uint32_t y = 0; y < 48; y++)
		for (uint32_t x = 0; x + 1 < 64; x++)
			for (size_t c = 0; c < 3; c++) {
				size_t i = 3 * ((size_t)y * 64 + x) + c;
				double edge = (double)truth_at(texture, x + 1, y, c) - (double)truth_at(texture, x, y, c);
				if (fabs(edge) < 0.1)
					continue;
				wrong += fabs((double)film.denoised[i + 3] - (double)film.denoised[i] - edge);
				all += fabs(edge);
			}
	assert_true(wrong < 0.05 * all);
	gi_film_finish(&film);
}

/* An edge that is in the light alone is not blurred into an error larger than the noise was. */
static void shadow_stays(void **state)
{
	(void)state;
	errors e = denoised(shadow, even);
	assert_true(e.after < e.before / 3.0);
}

/* Without noise nothing changes, but for what rounding does. */
static void clean_stays(void **state)
{
	(void)state;
	assert_true(denoised(wall, none).after < 1e-6);
	if (!TEST_ASAN) {
		assert_true(denoised(texture, none).after < 1e-5);
		assert_true(denoised(shadow, none).after < 1e-5);
	}
}

/* Rare bright samples are spread over their surroundings, and their light is not lost. */
static void fireflies_are_spread(void **state)
{
	(void)state;
	errors e = denoised(wall, fireflies);
	assert_true(e.before > 0.5);
	assert_true(e.after < e.before / 4.0);
	assert_true(fabs(e.bias) < 0.01);
}

/* What is behind the scene is without noise: its pixels keep their bits. */
static void misses_keep_their_bits(void **state)
{
	(void)state;
	gi_film film = film_make(64, 48);
	film_paint(&film, half_open, even, SAMPLES);
	film_denoise(&film, 0);
	const float *radiance = gi_film_planes(&film).radiance;
	size_t wall_floats = (size_t)3 * 64 * 20;
	assert_memory_equal(film.denoised + wall_floats, radiance + wall_floats, (size_t)3 * 64 * 28 * sizeof(float));
	assert_memory_not_equal(film.denoised, radiance, wall_floats * sizeof(float));
	gi_film_finish(&film);
}

/* How bright a picture is does not matter: one of 2^-20 times the radiance becomes 2^-20 times the denoised one. */
static void any_radiance(void **state)
{
	(void)state;
	gi_film one = film_make(40, 30), dim = film_make(40, 30);
	film_paint(&one, shadow, even, SAMPLES);
	memcpy(dim.pixels, one.pixels, (size_t)40 * 30 * sizeof *one.pixels);
	memcpy(dim.halves, one.halves, (size_t)40 * 30 * sizeof *one.halves);
	for (size_t i = 0; i < (size_t)40 * 30; i++) {
		for (int c = 0; c < 3; c++) {
			dim.pixels[i].radiance[c] = ldexp(one.pixels[i].radiance[c], -20);
			dim.pixels[i].radiance_squared[c] = ldexp(one.pixels[i].radiance_squared[c], -40);
			dim.halves[i].radiance[c] = ldexp(one.halves[i].radiance[c], -20);
		}
		gi_film_resolve(&dim, i);
	}
	film_denoise(&one, 0);
	film_denoise(&dim, 0);
	for (size_t i = 0; i < (size_t)3 * 40 * 30; i++)
		assert_true(fabsf(ldexpf(dim.denoised[i], 20) - one.denoised[i]) <= 1e-5f * one.denoised[i]);
	gi_film_finish(&one);
	gi_film_finish(&dim);
}

/* ---- what may come ----------------------------------------------------------------------------------------------- */

/* Pictures of one pixel, row or column, and those that end within a tile or a pixel behind one. */
static void any_shape(void **state)
{
	(void)state;
	const uint32_t sizes[][2] = {{1, 1}, {1, 50}, {50, 1}, {2, 3}, {42, 42}, {43, 5}, {5, 43}, {85, 3}};
	for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
		gi_film film = film_make(sizes[k][0], sizes[k][1]);
		film_paint(&film, wall, even, SAMPLES);
		film_denoise(&film, 0);
		errors e = errors_of(&film, wall);
		assert_true(e.after <= e.before);
		gi_film_finish(&film);
	}
}

/* Samples that are no numbers count as black, and those at the end of the range are kept: none of them reaches another
 * pixel. */
static void any_sample(void **state)
{
	(void)state;
	const float odd[] = {NAN, INFINITY, -INFINITY, 3e38f, 1e30f, 1e16f, -5.0f, 1e-40f};
	gi_film film = film_make(48, 40);
	film_paint(&film, wall, even, SAMPLES);
	for (size_t i = 0; i < sizeof odd / sizeof *odd; i++) {
		size_t pixel = 48 * 20 + 5 * i + 4;
		place p = wall(0, 0);
		gi_film_sample sample = {
			.radiance = {odd[i], 1.0f, odd[i]}, .albedo = p.albedo, .normal = p.normal, .depth = 4};
		gi_film_add(&film, pixel, &sample);
		gi_film_resolve(&film, pixel);
	}
	film_denoise(&film, 0);
	for (size_t i = 0; i < (size_t)48 * 40; i++)
		for (size_t c = 0; c < 3; c++) {
			assert_false(isnan(film.denoised[3 * i + c]));
			if (i / 48 != 20)
				assert_true(film.denoised[3 * i + c] > 0.5f && film.denoised[3 * i + c] < 2.0f);
		}
	gi_film_finish(&film);
}

/* A picture that was stopped has pixels with no sample, one, two and many: those with halves are filtered. */
static void any_count(void **state)
{
	(void)state;
	gi_film film = film_make(64, 48), sparse = film_make(64, 48);
	film_paint(&film, wall, even, SAMPLES);
	for (size_t i = 0; i < (size_t)64 * 48; i++) {
		gi_film_sample sample = {.albedo = (float[3]){0.5f, 0.5f, 0.5f}, .normal = (float[3]){0}, .depth = 4.0f};
		for (uint32_t k = 0; k < i % 4; k++) {
			for (int c = 0; c < 3; c++)
				sample.radiance[c] = even(i, k);
			gi_film_add(&sparse, i, &sample);
		}
		gi_film_resolve(&sparse, i);
	}
	film_denoise(&sparse, 0);
	const float *radiance = gi_film_planes(&sparse).radiance;
	double before = 0.0, after = 0.0;
	for (size_t i = 0; i < (size_t)64 * 48; i++) {
		if (i % 4 < 2)
			assert_true(sparse.denoised[3 * i] == radiance[3 * i]);
		before += i % 4 < 2 ? 0.0 : pow((double)radiance[3 * i] - 1.0, 2.0);
		after += i % 4 < 2 ? 0.0 : pow((double)sparse.denoised[3 * i] - 1.0, 2.0);
	}
	assert_true(after < 0.16 * before);
	gi_film_finish(&film);
	gi_film_finish(&sparse);
}

/* The same pixels elsewhere in a picture, and so elsewhere in its tiles, become the same, bit by bit, but for those
 * that see the picture's border. */
static void tiles_are_not_seen(void **state)
{
	(void)state;
	enum { WIDTH = 100, HEIGHT = 70, RIGHT = 17, DOWN = 9, SEEN = 3 + 3 + 1 + 2 + 4 };
	gi_film film = film_make(WIDTH, HEIGHT), part = film_make(WIDTH - RIGHT, HEIGHT - DOWN);
	film_paint(&film, texture, even, SAMPLES);
	for (uint32_t y = 0; y < part.height; y++)
		for (uint32_t x = 0; x < part.width; x++) {
			size_t to = (size_t)y * part.width + x, from = (size_t)(y + DOWN) * WIDTH + x + RIGHT;
			part.pixels[to] = film.pixels[from];
			part.halves[to] = film.halves[from];
			gi_film_resolve(&part, to);
		}
	film_denoise(&film, 0);
	film_denoise(&part, 0);
	for (uint32_t y = SEEN; y < part.height - SEEN; y++)
		for (uint32_t x = SEEN; x < part.width - SEEN; x++) {
			size_t a = (size_t)y * part.width + x, b = (size_t)(y + DOWN) * WIDTH + x + RIGHT;
			assert_memory_equal(part.denoised + 3 * a, film.denoised + 3 * b, sizeof(float[3]));
		}
	gi_film_finish(&film);
	gi_film_finish(&part);
}

static void any_workers(void **state)
{
	(void)state;
	enum { WIDTH = TEST_TSAN ? 50 : 101, HEIGHT = TEST_TSAN ? 45 : 90 };
	gi_film films[3];
	int count = TEST_ASAN ? 2 : 3;
	for (int i = 0; i < count; i++) {
		films[i] = film_make(WIDTH, HEIGHT);
		film_paint(&films[i], texture, fireflies, SAMPLES);
		film_denoise(&films[i], (const uint32_t[]){0, 1, 4}[i]);
		assert_memory_equal(films[i].denoised, films[0].denoised, (size_t)3 * WIDTH * HEIGHT * sizeof(float));
	}
	for (int i = 0; i < count; i++)
		gi_film_finish(&films[i]);
}

/* ---- the definition ---------------------------------------------------------------------------------------------- */

enum { ROW = 23, COLUMN = 17, COUNT = ROW * COLUMN, TERMS = 10 };

/* What gi_denoise.h says, pixel by pixel and in double. */
typedef struct model {
	double half[2][COUNT][3], filtered[2][COUNT][3], variance[COUNT][3], albedo[COUNT][3], feature[COUNT][7];
	double solution[COUNT][TERMS][3]; /* of the fit around each pixel */
} model;

/* Pixels in the square of so many around one, in the picture, as a list. */
static uint32_t around(uint32_t pixel, int reach, uint32_t *list)
{
	uint32_t count = 0;
	int x = (int)(pixel % ROW), y = (int)(pixel / ROW);
	for (int v = y - reach; v <= y + reach; v++)
		for (int u = x - reach; u <= x + reach; u++)
			if (u >= 0 && v >= 0 && u < ROW && v < COLUMN)
				list[count++] = (uint32_t)(v * ROW + u);
	return count;
}

static void model_make(const gi_film *film, model *m)
{
	double most = 0.0, scale[COUNT];
	uint32_t list[81];
	for (uint32_t i = 0; i < COUNT; i++) {
		const gi_film_pixel *pixel = &film->pixels[i];
		double n = pixel->samples;
		for (int c = 0; c < 3; c++) {
			double mean = pixel->radiance[c] / n;
			m->half[0][i][c] = film->halves[i].radiance[c] / (n / 2.0);
			m->half[1][i][c] = (pixel->radiance[c] - film->halves[i].radiance[c]) / (n / 2.0);
			m->variance[i][c] = (pixel->radiance_squared[c] / n - mean * mean) / (n - 1.0);
			m->albedo[i][c] = fmax(pixel->albedo[c] / n, 0.02);
			m->feature[i][c] = pixel->albedo[c] / n;
			m->feature[i][3 + c] = pixel->normal[c] / n;
		}
		m->feature[i][6] = n / pixel->depth;
		most = fmax(most, m->feature[i][6]);
	}
	for (uint32_t i = 0; i < COUNT; i++) {
		double seen = 0.0, said = 0.0;
		for (uint32_t k = around(i, 2, list); k-- > 0;)
			for (int c = 0; c < 3; c++) {
				uint32_t q = list[k];
				seen += pow((m->half[0][q][c] - m->half[1][q][c]) / m->albedo[q][c], 2.0);
				said += 4.0 * m->variance[q][c] / pow(m->albedo[q][c], 2.0);
			}
		scale[i] = fmin(seen / said, 1.0);
	}
	for (uint32_t i = 0; i < COUNT; i++) {
		m->feature[i][6] /= most;
		for (int c = 0; c < 3; c++)
			m->variance[i][c] *= 2.0 * scale[i]; /* of a half */
	}
}

/* d(p, q) of single pixels. */
static double model_pixel(const model *m, int half, uint32_t p, uint32_t q)
{
	double sum = 0.0;
	for (int c = 0; c < 3; c++) {
		double difference = m->half[half][p][c] / m->albedo[p][c] - m->half[half][q][c] / m->albedo[q][c];
		double v = m->variance[p][c] / pow(m->albedo[p][c], 2.0) + m->variance[q][c] / pow(m->albedo[q][c], 2.0);
		sum += (difference * difference - v) / (0.81 * v) / 3.0;
	}
	return sum;
}

/* The weight that a half gives q in the fit around p. */
static double model_weight(const model *m, int half, uint32_t p, uint32_t q)
{
	double sum = 0.0, count = 0.0;
	uint32_t list[9];
	int offset = (int)q - (int)p, dx = (int)(q % ROW) - (int)(p % ROW);
	for (uint32_t k = around(p, 1, list); k-- > 0;) {
		int other = (int)list[k] + offset, column = (int)(list[k] % ROW) + dx;
		if (other < 0 || other >= COUNT || column < 0 || column >= ROW)
			continue;
		sum += model_pixel(m, half, list[k], (uint32_t)other);
		count++;
	}
	return pow(fmax(1.0 - fmax(sum / count, 0.0) / 8.0, 0.0), 8.0);
}

static void model_terms(const model *m, uint32_t p, uint32_t q, double term[TERMS])
{
	term[0] = 1.0;
	term[1] = ((double)(q % ROW) - (double)(p % ROW)) / 3.0;
	term[2] = ((double)(q / ROW) - (double)(p / ROW)) / 3.0;
	for (int k = 0; k < 7; k++)
		term[3 + k] = m->feature[q][k] - m->feature[p][k];
}

/* By Gauss' elimination. */
static void model_solve(double a[TERMS][TERMS + 3], double solution[TERMS][3])
{
	for (int i = 0; i < TERMS; i++)
		for (int k = i + 1; k < TERMS; k++) {
			double f = a[k][i] / a[i][i];
			for (int j = i; j < TERMS + 3; j++)
				a[k][j] -= f * a[i][j];
		}
	for (int i = TERMS - 1; i >= 0; i--)
		for (int c = 0; c < 3; c++) {
			double sum = a[i][TERMS + c];
			for (int j = i + 1; j < TERMS; j++)
				sum -= a[i][j] * solution[j][c];
			solution[i][c] = sum / a[i][i];
		}
}

static void model_fit(model *m, int half, uint32_t p)
{
	double a[TERMS][TERMS + 3] = {{0}}, term[TERMS];
	uint32_t list[49];
	for (uint32_t k = around(p, 3, list); k-- > 0;) {
		double w = model_weight(m, !half, p, list[k]);
		model_terms(m, p, list[k], term);
		for (int i = 0; i < TERMS; i++) {
			for (int j = 0; j < TERMS; j++)
				a[i][j] += w * term[i] * term[j];
			for (int c = 0; c < 3; c++)
				a[i][TERMS + c] += w * term[i] * m->half[half][list[k]][c];
		}
	}
	for (int i = 1; i < TERMS; i++)
		a[i][i] += 1e-3 * a[0][0];
	model_solve(a, m->solution[p]);
}

static void model_filter(model *m, int half)
{
	uint32_t list[49];
	for (uint32_t p = 0; p < COUNT; p++)
		model_fit(m, half, p);
	for (uint32_t q = 0; q < COUNT; q++) {
		double sum[3] = {0}, weights = 0.0, term[TERMS];
		for (uint32_t k = around(q, 3, list); k-- > 0;) {
			double w = model_weight(m, !half, list[k], q);
			model_terms(m, list[k], q, term);
			weights += w;
			for (int c = 0; c < 3; c++)
				for (int i = 0; i < TERMS; i++)
					sum[c] += w * term[i] * m->solution[list[k]][i][c];
		}
		for (int c = 0; c < 3; c++)
			m->filtered[half][q][c] = sum[c] / weights;
	}
}

static double model_strength(const model *m, uint32_t pixel)
{
	double wanted = 0.0, step = 0.0;
	uint32_t list[81];
	for (uint32_t k = around(pixel, 4, list); k-- > 0;)
		for (int half = 0; half < 2; half++)
			for (int c = 0; c < 3; c++) {
				double own = m->half[half][list[k]][c], change = m->filtered[half][list[k]][c] - own;
				wanted += (m->half[!half][list[k]][c] - own) * change;
				step += change * change;
			}
	double s = fmax(0.0, fmin(wanted / step, 1.0));
	return s / (2.0 - s);
}

/* Balls and textures: all features vary. */
static place hills(uint32_t x, uint32_t y)
{
	place p = texture(x + y / 3, y);
	double a = 0.3 * x, b = 0.4 * y;
	p.normal[0] = (float)(0.5 * sin(a));
	p.normal[1] = (float)(0.5 * cos(b));
	p.normal[2] = sqrtf(1.0f - p.normal[0] * p.normal[0] - p.normal[1] * p.normal[1]);
	p.depth = 3.0f + 0.5f * (float)cos(a + b);
	p.light = 1.0f + p.normal[0] + (x > 11 ? 1.0f : 0.0f);
	return p;
}

/* The denoiser does what its header says. */
static void the_definition(void **state)
{
	(void)state;
	static model m;
	double partly = 0.0;
	gi_film film = film_make(ROW, COLUMN);
	film_paint(&film, hills, even, SAMPLES);
	film_denoise(&film, 0);
	model_make(&film, &m);
	model_filter(&m, 0);
	model_filter(&m, 1);
	for (uint32_t i = 0; i < COUNT; i++)
		for (int c = 0; c < 3; c++) {
			double input = 0.5 * (m.half[0][i][c] + m.half[1][i][c]), s = model_strength(&m, i);
			double want = input + s * (0.5 * (m.filtered[0][i][c] + m.filtered[1][i][c]) - input);
			assert_true(fabs((double)film.denoised[3 * i + (uint32_t)c] - want) < 2e-5 * (1.0 + want));
			partly += s > 0.1 && s < 0.9;
		}
	assert_true(partly > 100.0);
	gi_film_finish(&film);
}

/* ---- in a render ------------------------------------------------------------------------------------------------- */

/* The denoised picture of a render that is stopped, shown denoised, and continued is that of one that ran through. */
static void goes_on(void **state)
{
	(void)state;
	render_fixture fixture = render_fixture_make("cornell", 1);
	stilb_gi_settings settings = render_fixture_settings(&fixture);
	settings.denoise = true;
	settings.samples = 8;
	size_t bytes = (size_t)settings.width * settings.height * sizeof(float[3]);
	stilb_gi_render *whole = render_fixture_create(&fixture, &settings);
	stilb_gi_render *parts = render_fixture_create(&fixture, &settings);
	assert_int_equal(stilb_gi_render_run(whole), STILB_OK);
	assert_null(stilb_gi_render_film(whole).denoised);
	assert_int_equal(stilb_gi_render_denoise(whole), STILB_OK);
	stilb_gi_render_until(parts, 3);
	assert_int_equal(stilb_gi_render_run(parts), STILB_OK);
	assert_int_equal(stilb_gi_render_denoise(parts), STILB_OK);
	assert_memory_not_equal(stilb_gi_render_film(parts).denoised, stilb_gi_render_film(whole).denoised, bytes);
	stilb_gi_render_until(parts, 0);
	assert_int_equal(stilb_gi_render_run(parts), STILB_OK);
	assert_null(stilb_gi_render_film(parts).denoised); /* it was of the samples before */
	assert_int_equal(stilb_gi_render_denoise(parts), STILB_OK);
	assert_memory_equal(stilb_gi_render_film(parts).denoised, stilb_gi_render_film(whole).denoised, bytes);
	stilb_gi_render_destroy(whole);
	stilb_gi_render_destroy(parts);
	render_fixture_finish(&fixture);
}

static void what_has_no_noise(void **state)
{
	(void)state;
	render_fixture fixture = render_fixture_make("cornell", 0);
	stilb_gi_settings settings = render_fixture_settings(&fixture);
	settings.denoise = true;
	const struct {
		stilb_gi_integrator integrator;
		uint32_t samples;
		const char *said;
	} cases[] = {{STILB_GI_INTEGRATOR_PATH, 1, "samples is 1"},
	             {STILB_GI_INTEGRATOR_COLOR, 4, "color and channel"},
	             {STILB_GI_INTEGRATOR_CHANNEL, 4, "color and channel"}};
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		stilb_gi_render *render;
		settings.integrator = cases[i].integrator;
		settings.samples = cases[i].samples;
		assert_int_equal(stilb_gi_render_create(fixture.gi, &settings, fixture.pool, &render), STILB_ERROR_ARGUMENT);
		assert_non_null(strstr(stilb_error_message(), cases[i].said));
	}
	render_fixture_finish(&fixture);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		test_one_thread(halves),
		test_one_thread(even_noise_goes),
		test_one_thread(texture_stays),
		test_one_thread(shadow_stays),
		test_one_thread(clean_stays),
		test_one_thread(fireflies_are_spread),
		test_one_thread(misses_keep_their_bits),
		test_one_thread(any_radiance),
		test_one_thread(any_shape),
		test_one_thread(any_sample),
		test_one_thread(any_count),
		test_one_thread(the_definition),
		test_one_thread(tiles_are_not_seen),
		cmocka_unit_test(any_workers),
		cmocka_unit_test(goes_on),
		test_one_thread(what_has_no_noise),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
