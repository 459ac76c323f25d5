/*
 * The case `choice`: 1,000 emitting triangles and 1,000 points, of which each sample asks one: by the light tree, at
 * random, or in proportion to what each light would send if nothing were in the way, which takes all of them at every
 * point and so is the best that a choice that knows of no shadows can be. Brightness of irradiance at the ends of
 * camera rays; independent numbers, so that the variance of samples is that of one.
 */
#include "bench/gi/gi_run.h"

#include "gi/gi_scene_internal.h"
#include "gi/gi_surface.h"
#include "gi/gi_vector.h"
#include "gi/light/gi_light_listed.h"
#include "gi/trace/gi_ray.h"

#include <math.h>
#include <stdlib.h>

#define CHOICE_SIDE 48u
#define CHOICE_POINTS (CHOICE_SIDE * CHOICE_SIDE)
#define CHOICE_SAMPLES 64u /* of each point */

typedef enum choice_kind { CHOICE_TREE, CHOICE_UNIFORM, CHOICE_IDEAL, CHOICE_KINDS } choice_kind;

typedef struct choice_point {
	stilb_vec3 position, normal;
} choice_point;

static uint32_t choice_lights(const gi_lights *lights)
{
	return lights->shape_count + lights->listed_count;
}

static bool choice_sample_light(const gi_lights *lights, uint32_t light, stilb_vec3 position, stilb_vec2 u,
                                gi_light_sample *sample)
{
	return light < lights->shape_count
	           ? gi_light_shape_sample(&lights->shapes[light], position, u, sample)
	           : gi_light_listed_sample(&lights->listed[light - lights->shape_count], position, u, sample);
}

static float choice_value(const choice_point *at, const gi_light_sample *sample)
{
	float cosine = stilb_vec3_dot(at->normal, sample->direction);
	return cosine > 0.0f ? gi_brightness(sample->radiance) * cosine / sample->pdf : 0.0f;
}

/* Sums of what each light sends from its middle. */
static void choice_ideal(const gi_lights *lights, const choice_point *at, float *sums)
{
	float sum = 0.0f;
	for (uint32_t light = 0; light < choice_lights(lights); light++) {
		gi_light_sample sample;
		if (choice_sample_light(lights, light, at->position, (stilb_vec2){4.0f / 9.0f, 0.5f}, &sample))
			sum += choice_value(at, &sample);
		sums[light] = sum;
	}
}

/* One sample of the irradiance and its shadow ray. */
static float choice_ask(const gi_lights *lights, choice_kind kind, const choice_point *at, const float *sums,
                        const float u[3], gi_ray *shadow)
{
	gi_light_sample sample = {.pdf = 0.0f};
	stilb_vec2 place = {u[0], u[1]};
	uint32_t count = choice_lights(lights);
	bool found;
	if (kind == CHOICE_TREE) {
		found = gi_light_sample_at(lights, GI_LIGHT_PLACED, true, at->position, at->normal, u[2], place, &sample);
	} else {
		float all = kind == CHOICE_IDEAL ? sums[count - 1] : 1.0f;
		uint32_t light = kind == CHOICE_IDEAL ? gi_run_find(sums, count, u[2] * all) : (uint32_t)(u[2] * (float)count);
		found = choice_sample_light(lights, light, at->position, place, &sample);
		sample.pdf *=
			kind == CHOICE_IDEAL ? (sums[light] - (light ? sums[light - 1] : 0.0f)) / all : 1.0f / (float)count;
	}
	float value = found && sample.pdf > 0.0f ? choice_value(at, &sample) : 0.0f;
	*shadow = gi_ray_make(at->position, sample.direction, value > 0.0f ? sample.distance : 0.0f, 0.0f);
	return value;
}

/* Variance of one sample, mean over the points; *mean: of the irradiance, *seconds: of CPU. */
static double choice_variance(const gi_run_world *world, choice_kind kind, const choice_point *points, uint32_t count,
                              uint64_t seed, double *mean, double *seconds)
{
	const gi_lights *lights = &world->gi->lights;
	float *sums = malloc(choice_lights(lights) * sizeof *sums);
	if (!sums)
		bench_child_fail("no memory for the sums");
	double variance = 0.0;
	*mean = 0.0;
	gi_run_clock begin = gi_run_now();
	for (uint32_t i = 0; i < count; i++) {
		gi_ray shadows[CHOICE_SAMPLES];
		float values[CHOICE_SAMPLES];
		double sum = 0.0, squares = 0.0;
		if (kind == CHOICE_IDEAL)
			choice_ideal(lights, &points[i], sums);
		for (uint32_t k = 0; k < CHOICE_SAMPLES; k++) {
			float u[3];
			for (uint64_t d = 0; d < 3; d++)
				u[d] = stilb_random_float(seed, 4 * ((uint64_t)i * CHOICE_SAMPLES + k) + d);
			values[k] = choice_ask(lights, kind, &points[i], sums, u, &shadows[k]);
		}
		world->gi->tracer.occluded(&world->gi->tracer, shadows, CHOICE_SAMPLES);
		for (uint32_t k = 0; k < CHOICE_SAMPLES; k++) {
			double value = shadows[k].t_max >= 0.0f ? (double)values[k] : 0.0;
			sum += value / CHOICE_SAMPLES;
			squares += value * value / CHOICE_SAMPLES;
		}
		variance += (squares - sum * sum) * CHOICE_SAMPLES / (CHOICE_SAMPLES - 1) / count;
		*mean += sum / count;
	}
	*seconds = gi_run_now().cpu_seconds - begin.cpu_seconds;
	free(sums);
	return variance;
}

void gi_run_choice(const bench_child *child)
{
	gi_run_world world = gi_run_world_make(gi_run_row_scene("lights"), 0);
	choice_point *points = malloc(CHOICE_POINTS * sizeof *points);
	if (!points)
		bench_child_fail("no memory for the points");
	uint32_t count = 0;
	for (uint32_t i = 0; i < CHOICE_POINTS; i++) {
		const stilb_scene_camera *camera = &world.scene->camera;
		float half = tanf(0.5f * camera->fov_y), c = cosf(camera->pitch), s = sinf(camera->pitch);
		float x = (((float)(i % CHOICE_SIDE) + 0.5f) / CHOICE_SIDE * 2.0f - 1.0f) * half;
		float y = (((float)(i / CHOICE_SIDE) + 0.5f) / CHOICE_SIDE * 2.0f - 1.0f) * half;
		stilb_vec3 direction = stilb_vec3_normalize(stilb_vec3_make(x, y * c + s, y * s - c)); /* yaw is 0 */
		gi_ray_hit ray = gi_ray_hit_make(gi_vector(camera->position), direction);
		world.gi->tracer.intersect(&world.gi->tracer, &ray);
		if (!gi_is_hit(&ray))
			continue;
		gi_surface surface;
		gi_surface_at(world.gi, &ray, &surface);
		points[count++] = (choice_point){gi_surface_ray_origin(&surface, -direction), surface.normal};
	}
	double variance[CHOICE_KINDS] = {0.0}, mean[CHOICE_KINDS] = {0.0}, seconds[CHOICE_KINDS] = {0.0};
	uint64_t seed = 1 + 1000 * (uint64_t)child->round;
	uint32_t rounds = 0;
	for (; rounds < 2 || seconds[0] + seconds[1] < 0.5 * child->seconds; rounds++)
		for (choice_kind kind = 0; kind < CHOICE_KINDS; kind++) {
			double m, s;
			variance[kind] += choice_variance(&world, kind, points, count, seed++, &m, &s);
			mean[kind] += m;
			seconds[kind] += s;
		}
	for (choice_kind kind = 0; kind < CHOICE_KINDS; kind++)
		if (fabs(mean[kind] / mean[CHOICE_TREE] - 1.0) > 0.03)
			bench_child_fail("wrong result: the means of two choices are %.2f %% apart",
			                 100.0 * (mean[kind] / mean[CHOICE_TREE] - 1.0));
	double slower = seconds[CHOICE_TREE] / seconds[CHOICE_UNIFORM];
	bench_child_metric("tree-rmse", sqrt(variance[CHOICE_TREE] / rounds) / (mean[CHOICE_TREE] / rounds));
	bench_child_metric("uniform-rmse", sqrt(variance[CHOICE_UNIFORM] / rounds) / (mean[CHOICE_TREE] / rounds));
	bench_child_metric("ideal-rmse", sqrt(variance[CHOICE_IDEAL] / rounds) / (mean[CHOICE_TREE] / rounds));
	bench_child_metric("slower", slower);
	bench_child_metric("ratio", sqrt(variance[CHOICE_TREE] / variance[CHOICE_UNIFORM] * slower));
	bench_child_metric("ratio-ideal", sqrt(variance[CHOICE_TREE] / variance[CHOICE_IDEAL]));
	double faster = seconds[CHOICE_IDEAL] / seconds[CHOICE_TREE];
	bench_child_metric("ratio-ideal-time", sqrt(variance[CHOICE_TREE] / variance[CHOICE_IDEAL] / faster));
	free(points);
	gi_run_world_finish(&world);
}
