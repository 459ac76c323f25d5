/*
 * The rows of the suite `gi`: one scene each, rendered by Stilb's path tracer and by the plain one.
 *
 * Both render pairs of pictures with different seeds. Half of the mean square difference of a pair is the mean square
 * error of one picture of it, if its tracer is right; that it is, is checked by the other tracer: the means of all
 * their pictures must agree, as a whole and in each block of pixels, within what the pairs say of the noise. Pixels
 * near a visible light are left out: their noise is that of its edges.
 */
#include "bench/gi/gi_run.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define SIDE 128u
#define PIXELS ((size_t)SIDE * SIDE)
#define FLOATS (3 * PIXELS)
#define SAMPLES 64u
#define SAMPLES_QUICK 8u
#define BLOCK 16u
/* The means may differ by this share beside their noise: the plain tracer starts its rays 0.1 mm off a surface. */
#define APART 0.005
#define SIGMAS 5.0
#define SIGMAS_BLOCK 8.0 /* there are many blocks, and few pixels in one */

/* Sums over the pictures of one tracer. */
typedef struct row {
	double *sum, *square; /* [FLOATS] of the pairs' means, and of (half their differences)^2 */
	double cpu_seconds;
	uint32_t pairs;
} row;

static row row_make(void)
{
	row r = {.sum = calloc(FLOATS, sizeof(double)), .square = calloc(FLOATS, sizeof(double))};
	if (!r.sum || !r.square)
		bench_child_fail("no memory for a picture");
	return r;
}

static void row_add(row *r, gi_run_picture *a, gi_run_picture *b)
{
	for (size_t i = 0; i < FLOATS; i++) {
		double half = 0.5 * ((double)a->rgb[i] - (double)b->rgb[i]);
		r->sum[i] += 0.5 * ((double)a->rgb[i] + (double)b->rgb[i]);
		r->square[i] += half * half;
	}
	r->cpu_seconds += 0.5 * (a->cpu_seconds + b->cpu_seconds);
	r->pairs++;
	gi_run_picture_finish(a);
	gi_run_picture_finish(b);
}

/* Mean square error of one picture. */
static double row_error(const row *r, const bool *left_out)
{
	double sum = 0.0;
	size_t count = 0;
	for (size_t i = 0; i < FLOATS; i++) {
		sum += left_out[i / 3] ? 0.0 : 2.0 * r->square[i] / r->pairs;
		count += !left_out[i / 3];
	}
	return fmax(sum / (double)count, 1e-12);
}

typedef struct apart {
	double relative, sigmas; /* difference of two means over the mean, and over its standard deviation */
} apart;

/* Compares the means of both tracers in the square of pixels from (x, y) on. */
static apart compare(const row *a, const row *b, const bool *left_out, uint32_t x, uint32_t y, uint32_t side)
{
	double difference = 0.0, variance = 0.0, mean = 0.0;
	for (uint32_t v = y; v < y + side; v++)
		for (uint32_t u = x; u < x + side; u++)
			for (size_t i = 3 * ((size_t)v * SIDE + u), end = i + 3; i < end && !left_out[i / 3]; i++) {
				difference += a->sum[i] / a->pairs - b->sum[i] / b->pairs;
				mean += 0.5 * (a->sum[i] / a->pairs + b->sum[i] / b->pairs);
				variance += a->square[i] / a->pairs / a->pairs + b->square[i] / b->pairs / b->pairs;
			}
	if (!(mean > 0.0))
		return (apart){0};
	double beyond = fmax(fabs(difference) - APART * mean, 0.0);
	return (apart){difference / mean, variance > 0.0 ? beyond / sqrt(variance) : 0.0};
}

static void check(const char *name, const row *own, const row *plain, const bool *left_out)
{
	for (uint32_t y = 0; y < SIDE; y += BLOCK)
		for (uint32_t x = 0; x < SIDE; x += BLOCK) {
			apart block = compare(own, plain, left_out, x, y, BLOCK);
			if (block.sigmas > SIGMAS_BLOCK)
				bench_child_fail("%s: wrong result: at pixel (%u, %u) the tracers are %.2f %% apart, %.1f sigmas", name,
				                 x, y, 100.0 * block.relative, block.sigmas);
		}
	apart all = compare(own, plain, left_out, 0, 0, SIDE);
	if (all.sigmas > SIGMAS)
		bench_child_fail("%s: wrong result: the tracers' means are %.2f %% apart, %.1f sigmas", name,
		                 100.0 * all.relative, all.sigmas);
}

void gi_run_row(const bench_child *child)
{
	gi_run_world world = gi_run_world_make(gi_run_row_scene(child->case_name), 0);
	gi_plain *plain = gi_plain_make(world.scene);
	stilb_gi_settings settings = gi_run_cornell(world.scene);
	settings.width = settings.height = SIDE;
	settings.samples = child->seconds < 1.0 ? SAMPLES_QUICK : SAMPLES;
	settings.seed = 1 + 100000 * (uint64_t)child->round;
	row own = row_make(), base = row_make();
	while (own.pairs < 2 || own.cpu_seconds + base.cpu_seconds < 0.5 * child->seconds) {
		settings.seed++;
		gi_run_picture a = gi_run_render(&world, &settings), b = gi_plain_render(plain, &settings, 1);
		settings.seed++;
		gi_run_picture c = gi_run_render(&world, &settings), d = gi_plain_render(plain, &settings, 1);
		row_add(&own, &a, &c);
		row_add(&base, &b, &d);
	}
	bool *left_out = calloc(PIXELS, sizeof *left_out);
	float *mean = malloc(FLOATS * sizeof *mean);
	if (!left_out || !mean)
		bench_child_fail("no memory for a picture");
	for (size_t i = 0; i < FLOATS; i++)
		mean[i] = (float)(base.sum[i] / base.pairs);
	gi_run_leave_out(left_out, mean, SIDE);
	check(child->case_name, &own, &base, left_out);
	double square = row_error(&own, left_out), plain_square = row_error(&base, left_out);
	double seconds = own.cpu_seconds / own.pairs, plain_seconds = base.cpu_seconds / base.pairs;
	bench_child_metric("stilb", 1.0 / (square * seconds));
	bench_child_metric("plain", 1.0 / (plain_square * plain_seconds));
	bench_child_metric("ratio", plain_square * plain_seconds / (square * seconds));
	bench_child_metric("stilb-seconds", seconds);
	bench_child_metric("plain-seconds", plain_seconds);
	bench_child_metric("stilb-rmse", sqrt(square));
	bench_child_metric("plain-rmse", sqrt(plain_square));
	bench_child_metric("apart", 100.0 * compare(&own, &base, left_out, 0, 0, SIDE).relative);
	free(left_out);
	free(mean);
	free(own.sum);
	free(own.square);
	free(base.sum);
	free(base.square);
	gi_plain_finish(plain);
	gi_run_world_finish(&world);
}
