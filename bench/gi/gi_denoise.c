/*
 * The cases `denoise-ROW` of the suite `gi`: what --denoise makes of few samples, beside many samples without it.
 *
 * All are compared with a picture of far more samples, whose own error, known from its two halves, is subtracted.
 * Pixels near a visible light are left out, as in the rows.
 */
#include "bench/gi/gi_run.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define SIDE 128u
#define PIXELS ((size_t)SIDE * SIDE)
#define FLOATS (3 * PIXELS)
#define MANY 8u /* times the few samples */
#define TRUTH_SEED 0x7a11

/* Samples of a pixel in the pictures, and seeds. */
typedef struct effort {
	uint32_t few, truth, seeds;
} effort;

static const effort thorough = {16, 1024, 3}, quick = {4, 128, 1};

typedef struct truth {
	float *rgb;
	double noise; /* its mean square error */
	bool *left_out;
} truth;

/* Mean square errors and CPU seconds, summed over seeds. */
typedef struct tally {
	double few, denoised, many;
	double few_seconds, denoise_seconds, many_seconds;
} tally;

static double mean_square(const truth *t, const float *rgb)
{
	double sum = 0.0;
	size_t count = 0;
	for (size_t i = 0; i < FLOATS; i++) {
		double difference = t->left_out[i / 3] ? 0.0 : (double)rgb[i] - (double)t->rgb[i];
		sum += difference * difference;
		count += !t->left_out[i / 3];
	}
	return fmax(sum / (double)count - t->noise, 1e-12);
}

static truth truth_make(const gi_run_world *world, stilb_gi_settings settings, uint32_t samples)
{
	settings.samples = samples / 2;
	settings.seed = TRUTH_SEED;
	gi_run_picture a = gi_run_render(world, &settings);
	settings.seed++;
	gi_run_picture b = gi_run_render(world, &settings);
	truth t = {.rgb = malloc(FLOATS * sizeof(float)), .left_out = calloc(PIXELS, sizeof(bool))};
	if (!t.rgb || !t.left_out)
		bench_child_fail("no memory for a picture");
	for (size_t i = 0; i < FLOATS; i++)
		t.rgb[i] = 0.5f * (a.rgb[i] + b.rgb[i]);
	gi_run_leave_out(t.left_out, t.rgb, SIDE);
	t.noise = mean_square(&t, a.rgb);
	gi_run_picture_finish(&a);
	gi_run_picture_finish(&b);
	return t;
}

static void tally_few(tally *sums, const gi_run_world *world, const stilb_gi_settings *settings, const truth *t)
{
	stilb_gi_render *render;
	gi_run_check(stilb_gi_render_create(world->gi, settings, world->pool, &render), "a render");
	double begin = gi_run_now().cpu_seconds;
	gi_run_check(stilb_gi_render_run(render), "rendering");
	double middle = gi_run_now().cpu_seconds;
	gi_run_check(stilb_gi_render_denoise(render), "denoising");
	double end = gi_run_now().cpu_seconds;
	stilb_gi_film film = stilb_gi_render_film(render);
	sums->few += mean_square(t, film.radiance);
	sums->denoised += mean_square(t, film.denoised);
	sums->few_seconds += middle - begin;
	sums->denoise_seconds += end - middle;
	stilb_gi_render_destroy(render);
}

/* The error without denoising if its time went into samples, by the power of their number that lies between few and
 * many. */
static double equal_time_error(const tally *sums)
{
	double power = log(sums->many / sums->few) / log((double)MANY);
	return sqrt(sums->few * pow(1.0 + sums->denoise_seconds / sums->few_seconds, power));
}

void gi_run_denoise(const bench_child *child, const char *row)
{
	gi_run_world world = gi_run_world_make(gi_run_row_scene(row), 0);
	stilb_gi_settings settings = gi_run_cornell(world.scene);
	settings.width = settings.height = SIDE;
	const effort *with = child->seconds < 0.5 ? &quick : &thorough;
	truth t = truth_make(&world, settings, with->truth);
	tally sums = {0};
	for (uint32_t i = 0; i < with->seeds; i++) {
		settings.seed = 1 + i + 100000 * (uint64_t)child->round;
		settings.samples = with->few;
		settings.denoise = true;
		tally_few(&sums, &world, &settings, &t);
		settings.samples = MANY * with->few;
		settings.denoise = false;
		gi_run_picture many = gi_run_render(&world, &settings);
		sums.many += mean_square(&t, many.rgb);
		sums.many_seconds += many.cpu_seconds;
		gi_run_picture_finish(&many);
	}
	bench_child_metric("ratio", sqrt(sums.denoised / sums.many));
	bench_child_metric("ratio-input", sqrt(sums.denoised / sums.few));
	bench_child_metric("ratio-time", sqrt(sums.denoised) / equal_time_error(&sums));
	bench_child_metric("few-rmse", sqrt(sums.few / with->seeds));
	bench_child_metric("denoised-rmse", sqrt(sums.denoised / with->seeds));
	bench_child_metric("many-rmse", sqrt(sums.many / with->seeds));
	bench_child_metric("few-seconds", sums.few_seconds / with->seeds);
	bench_child_metric("denoise-seconds", sums.denoise_seconds / with->seeds);
	bench_child_metric("many-seconds", sums.many_seconds / with->seeds);
	free(t.rgb);
	free(t.left_out);
	gi_run_world_finish(&world);
}
