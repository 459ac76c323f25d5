/* The integrator montecarlo inside a ball of known radiance: every sample is the cut series, to the last digits, since
 * directions as likely as their cosine leave no variance; and what it will cost is known beforehand. */
#include "gi_path_fixture.h"

#include "gi/trace/gi_ray.h"
#include "scene/scene_internal.h"

#include <math.h>
#include <stdio.h>

static const double albedos[] = {0.2, 0.5, 0.8, 0.9, 0.95};
#define ALBEDO_COUNT (sizeof albedos / sizeof *albedos)
#define TOLERANCE 1e-5

static path_samples samples;

static path_fixture furnace(double albedo)
{
	char name[32];
	snprintf(name, sizeof name, "furnace:%g", albedo);
	return path_fixture_open(name);
}

/* 1 + rho + ... + rho^bounces */
static double series(double rho, uint32_t bounces)
{
	return (1.0 - pow(rho, bounces + 1)) / (1.0 - rho);
}

/* All samples of a picture of side x side. */
static void take(gi_view *view, uint32_t side)
{
	path_samples_take(view, 0, side * side, &samples);
	path_samples_shade(view, &samples);
}

static void assert_every_sample(double truth, double albedo, uint32_t bounces)
{
	for (uint32_t i = 0; i < samples.count; i++)
		for (int c = 0; c < 3; c++)
			if (!(fabs((double)samples.radiance[i][c] - truth) <= TOLERANCE * truth))
				fail_msg("albedo %g, %u bounces, sample %u: %.8g, not %.8g", albedo, bounces, i,
				         (double)samples.radiance[i][c], truth);
}

static void one_ray_a_hit_is_the_cut_series(void **state)
{
	(void)state;
	static const uint32_t bounces[] = {0, 1, 2, 3, 4, 6, 8, 12, 16, 64};
	for (size_t a = 0; a < ALBEDO_COUNT; a++) {
		path_fixture fixture = furnace(albedos[a]);
		gi_view view = path_view(&fixture, STILB_GI_INTEGRATOR_MONTECARLO, 8, 1);
		view.settings.rays = 1;
		for (size_t b = 0; b < sizeof bounces / sizeof *bounces; b++) {
			view.settings.depth = bounces[b];
			take(&view, 8);
			assert_every_sample(series(albedos[a], bounces[b]), albedos[a], bounces[b]);
		}
		path_fixture_finish(&fixture);
	}
}

/* 1 / (1 - rho): by then nothing is left of the rest. */
static void many_bounces_are_the_whole_light(void **state)
{
	(void)state;
	for (size_t a = 0; a < ALBEDO_COUNT; a++) {
		path_fixture fixture = furnace(albedos[a]);
		gi_view view = path_view(&fixture, STILB_GI_INTEGRATOR_MONTECARLO, 2, 1);
		view.settings.rays = 1;
		view.settings.depth = (uint32_t)ceil(log(1e-7) / log(albedos[a]));
		take(&view, 2);
		assert_every_sample(1.0 / (1.0 - albedos[a]), albedos[a], view.settings.depth);
		path_fixture_finish(&fixture);
	}
}

static void rays_branch_and_are_counted(void **state)
{
	(void)state;
	path_fixture fixture = furnace(0.8);
	gi_view view = path_view(&fixture, STILB_GI_INTEGRATOR_MONTECARLO, 4, 1);
	for (uint32_t rays = 1; rays <= 5; rays++)
		for (uint32_t depth = 0; depth <= 4; depth++) {
			view.settings.rays = rays;
			view.settings.depth = depth;
			take(&view, 4);
			assert_every_sample(series(0.8, depth), 0.8, depth);
			assert_true((double)(samples.rays_traced + samples.count) == stilb_gi_montecarlo_rays(&view.settings));
		}
	path_fixture_finish(&fixture);
}

static void indirect_light_has_bounced_before(void **state)
{
	(void)state;
	path_fixture fixture = furnace(0.5);
	gi_view view = path_view(&fixture, STILB_GI_INTEGRATOR_MONTECARLO, 4, 1);
	view.settings.only = STILB_GI_ONLY_INDIRECT;
	view.settings.rays = 2;
	for (uint32_t depth = 0; depth <= 6; depth++) {
		view.settings.depth = depth;
		take(&view, 4);
		assert_every_sample(depth < 2 ? 0.0 : series(0.5, depth) - 1.5, 0.5, depth);
	}
	path_fixture_finish(&fixture);
}

/* The built-in plane-wall: y = 0 reflects 1/2, a black wall 1 high stands on x = 0. Without its sky. */
static stilb_scene *dark_plane_wall(uint32_t light_count)
{
	stilb_scene *scene;
	assert_int_equal(stilb_scene_open("plane-wall", &scene), STILB_OK);
	scene->surroundings = (stilb_scene_surroundings){0};
	assert_int_equal(scene_add_lights(scene, light_count), STILB_OK);
	return scene;
}

/* A sample of the plane's radiance at (x, 0, 0). */
static stilb_vec3 plane_at(const gi_view *view, float x, uint32_t index)
{
	samples.count = 1;
	samples.points[0] = gi_sampler_point(&view->sampler, 0, 0, index);
	samples.rays[0] = gi_ray_hit_make(stilb_vec3_make(x, 0.5f, 0.0f), stilb_vec3_make(0.0f, -1.0f, 0.0f));
	view->scene->tracer.intersect(&view->scene->tracer, &samples.rays[0]);
	path_samples_shade(view, &samples);
	return samples.radiance[0];
}

static void assert_near(float value, double truth, double relative)
{
	if (!(fabs((double)value - truth) <= relative * truth))
		fail_msg("%.7g, not %.7g", (double)value, truth);
}

/* No ray finds a point light: it is asked at every hit. Reflected once it brings rho / pi I cos / d^2. */
static void lights_without_a_size_are_asked(void **state)
{
	(void)state;
	stilb_scene *scene = dark_plane_wall(1);
	scene->lights[0] = (stilb_scene_light){
		.kind = STILB_SCENE_LIGHT_POINT, .position = {-0.5f, 1.5f, 0.0f}, .intensity = {1.0f, 2.0f, 3.0f}};
	path_fixture fixture = path_fixture_make(scene);
	gi_view view = path_view(&fixture, STILB_GI_INTEGRATOR_MONTECARLO, 1, 1);
	view.settings.rays = 2;
	for (uint32_t depth = 0; depth <= 2; depth++) {
		view.settings.depth = depth;
		stilb_vec3 lit = plane_at(&view, 1.5f, 0);
		for (int c = 0; c < 3; c++)
			assert_near(lit[c], depth == 0 ? 0.0 : 0.5 / M_PI * (c + 1.0) * 1.5 / pow(6.25, 1.5), 2e-4);
		assert_true(plane_at(&view, 0.9f, 0)[0] == 0.0f); /* in the wall's shadow, which ends at 1 */
	}
	view.settings.only = STILB_GI_ONLY_INDIRECT;
	assert_true(plane_at(&view, 1.5f, 0)[0] == 0.0f);
	path_fixture_finish(&fixture);
}

/* One of them a sample. */
static void many_lights_add_up(void **state)
{
	(void)state;
	stilb_scene *scene = dark_plane_wall(2);
	for (int i = 0; i < 2; i++)
		scene->lights[i] = (stilb_scene_light){.kind = STILB_SCENE_LIGHT_POINT,
		                                       .position = {1.0f, 1.0f + (float)i, 0.0f},
		                                       .intensity = {1.0f, 2.0f, 3.0f}};
	path_fixture fixture = path_fixture_make(scene);
	gi_view view = path_view(&fixture, STILB_GI_INTEGRATOR_MONTECARLO, 1, 256);
	view.settings.rays = view.settings.depth = 1;
	float sum = 0.0f;
	for (uint32_t i = 0; i < 256; i++)
		sum += plane_at(&view, 1.0f, i)[0];
	assert_near(sum / 256.0f, 0.5 / M_PI * (1.0 + 0.25), 1e-2);
	path_fixture_finish(&fixture);
}

static void the_sky_is_found_by_rays(void **state)
{
	(void)state;
	path_fixture fixture = path_fixture_open("plane-wall");
	gi_view view = path_view(&fixture, STILB_GI_INTEGRATOR_MONTECARLO, 1, 1);
	view.settings.rays = 16384;
	view.settings.depth = 1;
	assert_near(plane_at(&view, 1.0f, 0)[0], 0.5 * 0.5 * (1.0 + cos(M_PI / 4.0)), 1e-3);
	view.settings.only = STILB_GI_ONLY_INDIRECT;
	assert_true(plane_at(&view, 1.0f, 0)[0] == 0.0f);
	path_fixture_finish(&fixture);
}

static void the_cost_is_known_beforehand(void **state)
{
	(void)state;
	stilb_gi_settings settings = {.width = 640, .height = 480, .samples = 2, .rays = 256, .depth = 4};
	/* 256 rays and 4 bounces: more than 4,000,000,000 rays for one sample. */
	double a_sample = 1.0 + 256.0 + 65536.0 + 16777216.0 + 4294967296.0;
	assert_true(stilb_gi_montecarlo_rays(&settings) == 640.0 * 480.0 * 2.0 * a_sample);
	settings.depth = 0;
	assert_true(stilb_gi_montecarlo_rays(&settings) == 640.0 * 480.0 * 2.0);
	settings.rays = 1;
	settings.depth = 1024;
	assert_true(stilb_gi_montecarlo_rays(&settings) == 640.0 * 480.0 * 2.0 * 1025.0);
	settings.rays = 256;
	assert_true(isinf(stilb_gi_montecarlo_rays(&settings)));
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(one_ray_a_hit_is_the_cut_series), cmocka_unit_test(many_bounces_are_the_whole_light),
		cmocka_unit_test(rays_branch_and_are_counted),     cmocka_unit_test(indirect_light_has_bounced_before),
		cmocka_unit_test(lights_without_a_size_are_asked), cmocka_unit_test(many_lights_add_up),
		cmocka_unit_test(the_sky_is_found_by_rays),        cmocka_unit_test(the_cost_is_known_beforehand),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
