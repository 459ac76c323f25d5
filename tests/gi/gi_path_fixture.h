/* What the tests of the path tracer share: a scene with its rays, and single camera samples through an integrator. */
#ifndef GI_PATH_FIXTURE_H
#define GI_PATH_FIXTURE_H

#include "gi/film/gi_camera.h"
#include "gi/integrate/gi_integrator.h"
#include "support/test.h"

#include <stdlib.h>

typedef struct path_fixture {
	stilb_job_pool *pool;
	stilb_scene *scene;
	stilb_gi_scene *gi;
} path_fixture;

/* A scene made ready for rays; the fixture owns the scene from now on. */
static inline path_fixture path_fixture_make(stilb_scene *scene)
{
	path_fixture fixture = {.scene = scene};
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	desc.worker_count = 0;
	assert_int_equal(stilb_job_pool_create(&desc, &fixture.pool), 0);
	stilb_gi_scene_desc gi_desc = stilb_gi_scene_desc_default(fixture.pool);
	assert_int_equal(stilb_gi_scene_create(scene, &gi_desc, &fixture.gi), STILB_OK);
	return fixture;
}

static inline path_fixture path_fixture_open(const char *name)
{
	stilb_scene *scene;
	assert_int_equal(stilb_scene_open(name, &scene), STILB_OK);
	return path_fixture_make(scene);
}

static inline void path_fixture_finish(path_fixture *fixture)
{
	stilb_gi_scene_destroy(fixture->gi);
	stilb_scene_destroy(fixture->scene);
	stilb_job_pool_destroy(fixture->pool);
}

/* The view (scene, settings, sampler) of a square picture by the scene's camera. */
static inline gi_view path_view(const path_fixture *fixture, stilb_gi_integrator integrator, uint32_t side,
                                uint32_t samples)
{
	gi_view view = {.scene = fixture->gi, .settings = stilb_gi_settings_default(fixture->scene)};
	view.settings.integrator = integrator;
	view.settings.width = view.settings.height = side;
	view.settings.samples = samples;
	view.sampler = gi_sampler_make(view.settings.sampler, view.settings.seed, samples);
	return view;
}

/* Camera samples of a picture, in order: sample s is number s % samples of pixel s / samples. */
typedef struct path_samples {
	gi_ray_hit rays[GI_BATCH];
	gi_point points[GI_BATCH];
	stilb_vec3 radiance[GI_BATCH];
	uint32_t count;
	uint64_t rays_traced, shadow_rays;
} path_samples;

static inline void path_samples_take(const gi_view *view, uint64_t first, uint32_t count, path_samples *out)
{
	const stilb_gi_settings *s = &view->settings;
	gi_camera camera = gi_camera_make(&s->camera, &s->lens, s->width, s->height);
	const gi_tracer *tracer = &view->scene->tracer;
	out->count = count;
	for (uint32_t i = 0; i < count; i++) {
		uint32_t pixel = (uint32_t)((first + i) / s->samples), x = pixel % s->width, y = pixel / s->width;
		out->points[i] = gi_sampler_point(&view->sampler, x, y, (uint32_t)((first + i) % s->samples));
		stilb_vec2 u = gi_sample_2d(&view->sampler, out->points[i], GI_DIMENSION_PIXEL);
		gi_camera_ray(&camera, (float)x + u[0], (float)y + u[1], (stilb_vec2){0.5f, 0.5f}, &out->rays[i]);
		tracer->intersect(tracer, &out->rays[i]);
	}
}

static inline void path_samples_shade(const gi_view *view, path_samples *samples)
{
	const gi_integrator *integrator = gi_integrator_of(view->settings.integrator);
	gi_batch batch = {.view = view,
	                  .count = samples->count,
	                  .points = samples->points,
	                  .rays = samples->rays,
	                  .radiance = samples->radiance,
	                  .scratch = stilb_memory_alloc(1, integrator->scratch_size)};
	assert_non_null(batch.scratch);
	integrator->shade(&batch);
	samples->rays_traced = batch.rays_traced;
	samples->shadow_rays = batch.shadow_rays;
	free(batch.scratch);
}

/* A mean of three channels and the standard error of each. */
typedef struct path_mean {
	double sum[3], square[3];
	uint64_t count;
} path_mean;

static inline void path_mean_add(path_mean *mean, stilb_vec3 radiance)
{
	for (int c = 0; c < 3; c++) {
		mean->sum[c] += (double)radiance[c];
		mean->square[c] += (double)radiance[c] * (double)radiance[c];
	}
	mean->count++;
}

static inline double path_mean_of(const path_mean *mean, int channel)
{
	return mean->sum[channel] / (double)mean->count;
}

/* The standard error of the mean, as if samples were independent: too large where the sampler spreads them evenly. */
static inline double path_mean_error(const path_mean *mean, int channel)
{
	double n = (double)mean->count, m = mean->sum[channel] / n, variance = mean->square[channel] / n - m * m;
	return variance > 0.0 ? sqrt(variance / n) : 0.0;
}

/* The mean of all samples of the whole picture. */
static inline path_mean path_picture_mean(const gi_view *view)
{
	path_mean mean = {0};
	path_samples *samples = stilb_memory_alloc(1, sizeof *samples);
	assert_non_null(samples);
	uint64_t end = (uint64_t)view->settings.width * view->settings.height * view->settings.samples;
	for (uint64_t first = 0; first < end; first += GI_BATCH) {
		path_samples_take(view, first, end - first < GI_BATCH ? (uint32_t)(end - first) : GI_BATCH, samples);
		path_samples_shade(view, samples);
		for (uint32_t i = 0; i < samples->count; i++)
			path_mean_add(&mean, samples->radiance[i]);
	}
	free(samples);
	return mean;
}

#endif
