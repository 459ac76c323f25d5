/* Long runs: ambient occlusion beside walls of many heights, and montecarlo and direct against path. */
#include "gi_path_fixture.h"

#include "gi/trace/gi_ray.h"
#include "scene/scene_internal.h"

#include <math.h>
#include <stdio.h>

static path_samples samples;

/* ---- ambient occlusion ------------------------------------------------------------------------------------------- */

/* The built-in plane-wall with a wall of another height, ten times as long: where it ends nothing of it is left to
 * see. */
static path_fixture walled(float height)
{
	stilb_scene *scene;
	assert_int_equal(stilb_scene_open("plane-wall", &scene), STILB_OK);
	stilb_scene_mesh *wall = &scene->meshes[1];
	for (uint32_t i = 0; i < wall->vertex_count; i++) {
		wall->vertices[i].position[1] *= height;
		wall->vertices[i].position[2] *= 10.0f;
	}
	scene_fit_bounds(scene, 0);
	return path_fixture_make(scene);
}

/* The ambient occlusion (share of the hemisphere that is open) at (x, 0, 0), seen from above. */
static double openness(const gi_view *view, float x)
{
	samples.count = 1;
	samples.points[0] = gi_sampler_point(&view->sampler, 0, 0, 0);
	samples.rays[0] = gi_ray_hit_make(stilb_vec3_make(x, 1.0f, 0.0f), stilb_vec3_make(0.0f, -1.0f, 0.0f));
	view->scene->tracer.intersect(&view->scene->tracer, &samples.rays[0]);
	path_samples_shade(view, &samples);
	return (double)samples.radiance[0][0];
}

/* (1 + cos a) / 2, where the wall ends at the angle a over the horizon. */
static void ao_beside_walls(void **state)
{
	(void)state;
	static const float heights[] = {0.1f, 0.5f, 1.0f, 2.0f, 10.0f, 1000.0f};
	static const float distances[] = {0.05f, 0.3f, 1.0f, 2.0f};
	for (size_t h = 0; h < sizeof heights / sizeof *heights; h++) {
		path_fixture fixture = walled(heights[h]);
		gi_view view = path_view(&fixture, STILB_GI_INTEGRATOR_AO, 1, 1);
		view.settings.rays = 65536;
		for (size_t d = 0; d < sizeof distances / sizeof *distances; d++) {
			double truth = 0.5 * (1.0 + cos(atan2((double)heights[h], (double)distances[d])));
			double value = openness(&view, distances[d]);
			if (!(fabs(value - truth) <= 1e-3))
				fail_msg("height %g, distance %g: %.6f, not %.6f", (double)heights[h], (double)distances[d], value,
				         truth);
		}
		path_fixture_finish(&fixture);
	}
}

/* ---- montecarlo and path ----------------------------------------------------------------------------------------- */

#define RENDERINGS 16

/* Mean radiances of two integrators over as many renderings, each pair with a seed of its own. The error is what the
 * pairs' differences tell: pixels differ among themselves, and camera rays are shared. largest: what that error may
 * be, relative. */
static void expect_same(const char *name, gi_view a, gi_view b, double largest)
{
	path_mean difference = {0}, level = {0};
	for (uint32_t r = 0; r < RENDERINGS; r++) {
		a.sampler = gi_sampler_make(a.settings.sampler, 1 + r, a.settings.samples);
		b.sampler = gi_sampler_make(b.settings.sampler, 1 + r, b.settings.samples);
		path_mean of_a = path_picture_mean(&a), of_b = path_picture_mean(&b);
		stilb_vec3 d = {0}, l = {0};
		for (int c = 0; c < 3; c++) {
			d[c] = (float)(path_mean_of(&of_a, c) - path_mean_of(&of_b, c));
			l[c] = (float)path_mean_of(&of_b, c);
		}
		path_mean_add(&difference, d);
		path_mean_add(&level, l);
	}
	for (int c = 0; c < 3; c++) {
		double off = path_mean_of(&difference, c) / path_mean_of(&level, c);
		double sigma = path_mean_error(&difference, c) / path_mean_of(&level, c);
		printf("%s, channel %d: mean %.5f, off by %+.4f %%, sigma %.4f %%\n", name, c, path_mean_of(&level, c),
		       100.0 * off, 100.0 * sigma);
		if (!(fabs(off) <= 5.0 * sigma && sigma <= largest)) /* 15 degrees of freedom */
			fail_msg("%s, channel %d: off by %g, sigma %g", name, c, off, sigma);
	}
}

/* At most three bounces, so that both cut off the same. */
static void montecarlo_is_path(void **state)
{
	(void)state;
	static const struct {
		const char *scene;
		stilb_gi_only only;
		uint32_t rays, samples;
	} cases[] = {
		{"cornell", STILB_GI_ALL_LIGHT, 2, 32},
		{"cornell", STILB_GI_ONLY_INDIRECT, 4, 8},
		{"spheres", STILB_GI_ALL_LIGHT, 2, 16},
	};
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		path_fixture fixture = path_fixture_open(cases[i].scene);
		gi_view montecarlo = path_view(&fixture, STILB_GI_INTEGRATOR_MONTECARLO, 32, cases[i].samples);
		gi_view path = path_view(&fixture, STILB_GI_INTEGRATOR_PATH, 32, cases[i].samples);
		montecarlo.settings.rays = cases[i].rays;
		montecarlo.settings.only = path.settings.only = cases[i].only;
		montecarlo.settings.depth = path.settings.depth = 3;
		expect_same(cases[i].scene, montecarlo, path, 1.5e-2);
		path_fixture_finish(&fixture);
	}
}

static void direct_is_a_path_of_one_bounce(void **state)
{
	(void)state;
	static const char *const scenes[] = {"cornell", "spheres", "outdoor"};
	for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
		path_fixture fixture = path_fixture_open(scenes[i]);
		gi_view direct = path_view(&fixture, STILB_GI_INTEGRATOR_DIRECT, 32, 16);
		gi_view path = path_view(&fixture, STILB_GI_INTEGRATOR_PATH, 32, 16);
		path.settings.depth = 1;
		expect_same(scenes[i], direct, path, 1e-3);
		path_fixture_finish(&fixture);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(ao_beside_walls),
		cmocka_unit_test(montecarlo_is_path),
		cmocka_unit_test(direct_is_a_path_of_one_bounce),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
