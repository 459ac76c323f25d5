/* The integrators without bounces against closed forms: color, direct light, ambient occlusion beside a wall. */
#include "gi_path_fixture.h"

#include "gi/trace/gi_ray.h"
#include "scene/scene_internal.h"

#include <math.h>
#include <string.h>

/* The built-in plane-wall: y = 0 reflects 1/2, a black wall 1 high stands on x = 0. Without its sky, and with room for
 * lights. */
static stilb_scene *plane_wall(uint32_t light_count)
{
	stilb_scene *scene;
	assert_int_equal(stilb_scene_open("plane-wall", &scene), STILB_OK);
	scene->surroundings = (stilb_scene_surroundings){0};
	assert_int_equal(scene_add_lights(scene, light_count), STILB_OK);
	return scene;
}

/* Samples first .. first + count - 1 of one pixel that looks at a point of the plane from above, and their mean. */
static stilb_vec3 mean_at(const gi_view *view, float x, float z, uint32_t first, uint32_t count, path_samples *samples)
{
	stilb_vec3 origin = stilb_vec3_make(x + 0.1f, 0.5f, z - 0.2f), target = stilb_vec3_make(x, 0.0f, z);
	stilb_vec3 direction = stilb_vec3_normalize(target - origin);
	samples->count = count;
	for (uint32_t i = 0; i < count; i++) {
		samples->points[i] = gi_sampler_point(&view->sampler, 0, 0, first + i);
		samples->rays[i] = gi_ray_hit_make(origin, direction);
		view->scene->tracer.intersect(&view->scene->tracer, &samples->rays[i]);
		assert_true(gi_is_hit(&samples->rays[i]));
	}
	path_samples_shade(view, samples);
	stilb_vec3 sum = {0};
	for (uint32_t i = 0; i < count; i++)
		sum += samples->radiance[i];
	return sum / (float)count;
}

static path_samples samples;

/* Relative tolerance of the light on the plane. The plane is 200 m wide, so rays leave it some hundredths of a
 * millimetre above it (gi_surface.error), and the light is computed for that point. */
#define OFFSET 2e-4

/* One sample from above the plane. */
static stilb_vec3 look(const gi_view *view, stilb_vec3 direction)
{
	samples.count = 1;
	samples.points[0] = gi_sampler_point(&view->sampler, 0, 0, 0);
	samples.rays[0] = gi_ray_hit_make(stilb_vec3_make(1.0f, 0.5f, 0.0f), direction);
	view->scene->tracer.intersect(&view->scene->tracer, &samples.rays[0]);
	path_samples_shade(view, &samples);
	return samples.radiance[0];
}

static void assert_near(double value, double truth, double relative, const char *what)
{
	if (!(fabs(value - truth) <= relative * fabs(truth)))
		fail_msg("%s: %.7g, not %.7g", what, value, truth);
}

/* ---- color ------------------------------------------------------------------------------------------------------- */

static void color_is_all_that_a_surface_reflects(void **state)
{
	(void)state;
	stilb_scene *scene = plane_wall(0);
	scene->materials[0] = (stilb_scene_material){.diffuse = {0.1f, 0.2f, 0.3f},
	                                             .specular = {0.4f, 0.3f, 0.1f},
	                                             .emission = {7.0f, 7.0f, 7.0f},
	                                             .roughness = 0.5f};
	path_fixture fixture = path_fixture_make(scene);
	gi_view view = path_view(&fixture, STILB_GI_INTEGRATOR_COLOR, 1, 1);
	stilb_vec3 seen = mean_at(&view, 1.0f, 0.0f, 0, 1, &samples);
	const float truth[3] = {0.5f, 0.5f, 0.4f};
	for (int c = 0; c < 3; c++)
		assert_near((double)seen[c], (double)truth[c], 1e-6, "reflectance");
	samples.rays[0].hit.part = GI_NO_PART;
	path_samples_shade(&view, &samples);
	for (int c = 0; c < 3; c++)
		assert_true(samples.radiance[0][c] == 0.0f);
	path_fixture_finish(&fixture);
}

/* ---- direct ------------------------------------------------------------------------------------------------------ */

/* The plane's radiance, 0.5 / pi times its irradiance I cos / d^2 from a light of intensity I at the distance d. */
static double from_point_light(const stilb_scene_light *light, double x, double z, int channel)
{
	double dx = (double)light->position[0] - x, dy = (double)light->position[1], dz = (double)light->position[2] - z,
		   d2 = dx * dx + dy * dy + dz * dz;
	return 0.5 / M_PI * (double)light->intensity[channel] * dy / (d2 * sqrt(d2));
}

static void a_point_light_falls_with_the_square_and_casts_hard_shadows(void **state)
{
	(void)state;
	stilb_scene *scene = plane_wall(1);
	scene->lights[0] = (stilb_scene_light){
		.kind = STILB_SCENE_LIGHT_POINT, .position = {-0.5f, 1.5f, 0.25f}, .intensity = {1.0f, 2.0f, 30.0f}};
	stilb_scene_light light = scene->lights[0];
	path_fixture fixture = path_fixture_make(scene);
	gi_view view = path_view(&fixture, STILB_GI_INTEGRATOR_DIRECT, 1, 1);
	/* The light, at x = -0.5 and y = 1.5, is above the wall's edge, at x = 0 and y = 1: the ray past the edge meets the
	 * plane at x = 1, for every z, so that the wall's shadow ends there. */
	for (int i = 0; i < 40; i++) {
		float x = 0.08f + 0.05f * (float)i, z = 0.1f * (float)(i % 7) - 0.3f;
		stilb_vec3 seen = mean_at(&view, x, z, 0, 1, &samples);
		for (int c = 0; c < 3; c++)
			if (x < 1.0f)
				assert_true(seen[c] == 0.0f);
			else
				assert_near((double)seen[c], from_point_light(&light, (double)x, (double)z, c), OFFSET, "point light");
	}
	assert_int_equal(samples.shadow_rays, 1);
	view.settings.only = STILB_GI_ONLY_INDIRECT;
	assert_true(mean_at(&view, 1.5f, 0.0f, 0, 1, &samples)[0] == 0.0f);
	path_fixture_finish(&fixture);
}

static void a_directional_light_is_the_same_everywhere(void **state)
{
	(void)state;
	stilb_scene *scene = plane_wall(1);
	scene->lights[0] = (stilb_scene_light){
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {0.6f, -0.8f, 0.0f}, .intensity = {3.0f, 2.0f, 1.0f}};
	path_fixture fixture = path_fixture_make(scene);
	gi_view view = path_view(&fixture, STILB_GI_INTEGRATOR_DIRECT, 1, 1);
	/* The wall's shadow is 1 x 0.6 / 0.8 long. */
	assert_true(mean_at(&view, 0.74f, 0.0f, 0, 1, &samples)[0] == 0.0f);
	const float places[] = {0.76f, 2.0f, 50.0f};
	for (int i = 0; i < 3; i++)
		for (int c = 0; c < 3; c++)
			assert_near((double)mean_at(&view, places[i], 1.0f, 0, 1, &samples)[c], 0.5 / M_PI * (3.0 - c) * 0.8, 1e-5,
			            "directional light");
	path_fixture_finish(&fixture);
}

static void many_lights_add_up(void **state)
{
	(void)state;
	stilb_scene *scene = plane_wall(3);
	double truth = 0.0;
	for (uint32_t i = 0; i < 3; i++) {
		float at = (float)i;
		scene->lights[i] = (stilb_scene_light){.kind = STILB_SCENE_LIGHT_POINT,
		                                       .position = {1.0f + at, 1.0f + 0.5f * at, -at},
		                                       .intensity = {1.0f + at, 1.0f, 1.0f}};
		truth += from_point_light(&scene->lights[i], 1.0, 0.0, 0);
	}
	path_fixture fixture = path_fixture_make(scene);
	gi_view view = path_view(&fixture, STILB_GI_INTEGRATOR_DIRECT, 1, GI_BATCH);
	stilb_vec3 seen = mean_at(&view, 1.0f, 0.0f, 0, GI_BATCH, &samples);
	assert_near((double)seen[0], truth, 5e-3, "three lights, one asked a sample");
	path_fixture_finish(&fixture);
}

/* Lambert's formula for the irradiance of a polygon: half the sum of the angles that its edges take up, each weighed
 * by how upright the edge's plane stands; y is up. Source: Lambert, "Photometria" (1760). */
static double polygon_irradiance(const double (*corner)[3], int count)
{
	double sum = 0.0;
	for (int i = 0; i < count; i++) {
		const double *a = corner[i], *b = corner[(i + 1) % count];
		const double n[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
		double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
		sum += atan2(length, a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) * n[1] / length;
	}
	return 0.5 * fabs(sum);
}

/* The wall as a lamp: its side towards +x shines. */
static void an_area_light_is_seen_and_shines(void **state)
{
	(void)state;
	stilb_scene *scene = plane_wall(0);
	for (int c = 0; c < 3; c++)
		scene->materials[1].emission[c] = 4.0f;
	const stilb_scene_mesh *wall = &scene->meshes[1];
	double corner[4][3];
	for (int i = 0; i < 4; i++)
		for (int c = 0; c < 3; c++)
			corner[i][c] = (double)wall->vertices[i].position[c] - (c == 0 ? 1.0 : 0.0); /* seen from (1, 0, 0) */
	path_fixture fixture = path_fixture_make(scene);
	gi_view view = path_view(&fixture, STILB_GI_INTEGRATOR_DIRECT, 1, GI_BATCH);
	double irradiance = 4.0 * polygon_irradiance(corner, 4);
	assert_near((double)mean_at(&view, 1.0f, 0.0f, 0, GI_BATCH, &samples)[0], 0.5 / M_PI * irradiance, 1e-2,
	            "a wall of light");
	assert_near((double)look(&view, stilb_vec3_make(-1.0f, 0.0f, 0.0f))[1], 4.0, 1e-6, "the lamp itself");
	path_fixture_finish(&fixture);
}

static void the_sky_is_seen_and_shines(void **state)
{
	(void)state;
	path_fixture fixture = path_fixture_open("plane-wall");
	gi_view view = path_view(&fixture, STILB_GI_INTEGRATOR_DIRECT, 1, GI_BATCH);
	double open = 0.5 * (1.0 + cos(M_PI / 4.0));
	assert_near((double)mean_at(&view, 1.0f, 0.0f, 0, GI_BATCH, &samples)[2], 0.5 * open, 1e-2, "the sky past a wall");
	assert_true(look(&view, stilb_vec3_make(0.0f, 1.0f, 0.0f))[2] == 1.0f);
	path_fixture_finish(&fixture);
}

/* Far from the wall a mirror shows the sky, which asking for light would hardly ever find. */
static void a_mirror_shows_the_sky(void **state)
{
	(void)state;
	stilb_scene *scene;
	assert_int_equal(stilb_scene_open("plane-wall", &scene), STILB_OK);
	scene->materials[0] = (stilb_scene_material){.specular = {1.0f, 1.0f, 1.0f}, .roughness = 0.05f};
	path_fixture fixture = path_fixture_make(scene);
	gi_view view = path_view(&fixture, STILB_GI_INTEGRATOR_DIRECT, 1, 64);
	assert_near((double)mean_at(&view, 50.0f, 0.0f, 0, 64, &samples)[0], 1.0, 1e-2, "a mirror");
	view.settings.only = STILB_GI_ONLY_INDIRECT;
	assert_true(mean_at(&view, 50.0f, 0.0f, 0, 64, &samples)[0] == 0.0f);
	path_fixture_finish(&fixture);
}

/* ---- ambient occlusion ------------------------------------------------------------------------------------------- */

/* The share of cosine-weighted directions that stay open beside a wall of endless length, whose upper edge is seen at
 * the angle a above the horizon: (1 + cos a) / 2. */
static double open_beside_wall(double height, double distance)
{
	return 0.5 * (1.0 + cos(atan2(height, distance)));
}

/* How much a wall, higher and longer than reach, takes away: cosine-weighted directions fall evenly onto the disk,
 * and the wall is met after distance / w where w is the disk's coordinate towards it. */
static double taken_by_wall(double distance, double reach, bool weighted)
{
	double c = distance / reach, s = sqrt(1.0 - c * c);
	double chord = 0.5 * (acos(c) - c * s);
	return 2.0 / M_PI * (weighted ? chord - c * (log((1.0 + s) / c) - s) : chord);
}

static void ao_beside_a_wall(void **state)
{
	(void)state;
	path_fixture fixture = path_fixture_make(plane_wall(0));
	gi_view view = path_view(&fixture, STILB_GI_INTEGRATOR_AO, 1, 1);
	view.settings.rays = 16384;
	assert_near((double)mean_at(&view, 1.0f, 0.0f, 0, 1, &samples)[0], open_beside_wall(1.0, 1.0), 1e-3, "45 degrees");
	assert_near((double)mean_at(&view, 0.25f, 0.0f, 0, 1, &samples)[0], open_beside_wall(1.0, 0.25), 1e-3,
	            "76 degrees");
	assert_int_equal(samples.rays_traced, 16384);
	view.settings.ao_distance = 1.0f;
	assert_near((double)mean_at(&view, 0.3f, 0.0f, 0, 1, &samples)[0], 1.0 - taken_by_wall(0.3, 1.0, false), 1e-3,
	            "hits within 1 m");
	assert_true(mean_at(&view, 1.25f, 0.0f, 0, 1, &samples)[0] == 1.0f);
	view.settings.ao_weighted = true;
	assert_near((double)mean_at(&view, 0.3f, 0.0f, 0, 1, &samples)[0], 1.0 - taken_by_wall(0.3, 1.0, true), 1e-3,
	            "hits within 1 m, weighed by distance");
	path_fixture_finish(&fixture);
}

static void ao_of_a_miss_is_open(void **state)
{
	(void)state;
	path_fixture fixture = path_fixture_make(plane_wall(0));
	gi_view view = path_view(&fixture, STILB_GI_INTEGRATOR_AO, 1, 1);
	mean_at(&view, 1.0f, 0.0f, 0, 1, &samples);
	samples.rays[0].hit.part = GI_NO_PART;
	path_samples_shade(&view, &samples);
	assert_true(samples.radiance[0][0] == 1.0f && samples.radiance[0][2] == 1.0f);
	path_fixture_finish(&fixture);
}

/* The ambient occlusion rays of many samples are traced together, in blocks that may end between the rays of one
 * sample: the results are the same bits as when each sample is computed alone. */
static void ao_does_not_depend_on_the_batch(void **state)
{
	(void)state;
	path_fixture fixture = path_fixture_make(plane_wall(0));
	gi_view view = path_view(&fixture, STILB_GI_INTEGRATOR_AO, 1, GI_BATCH);
	view.settings.rays = 7;
	mean_at(&view, 0.5f, 0.0f, 0, GI_BATCH, &samples);
	static stilb_vec3 together[GI_BATCH];
	memcpy(together, samples.radiance, sizeof together);
	uint32_t between = 0;
	for (uint32_t i = 0; i < GI_BATCH; i++) {
		mean_at(&view, 0.5f, 0.0f, i, 1, &samples);
		assert_memory_equal(&together[i], &samples.radiance[0], 3 * sizeof(float));
		between += together[i][0] > 0.0f && together[i][0] < 1.0f;
	}
	assert_true(between > GI_BATCH / 2);
	path_fixture_finish(&fixture);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(color_is_all_that_a_surface_reflects),
		cmocka_unit_test(a_point_light_falls_with_the_square_and_casts_hard_shadows),
		cmocka_unit_test(a_directional_light_is_the_same_everywhere),
		cmocka_unit_test(many_lights_add_up),
		cmocka_unit_test(an_area_light_is_seen_and_shines),
		cmocka_unit_test(the_sky_is_seen_and_shines),
		cmocka_unit_test(a_mirror_shows_the_sky),
		cmocka_unit_test(ao_beside_a_wall),
		cmocka_unit_test(ao_of_a_miss_is_open),
		cmocka_unit_test(ao_does_not_depend_on_the_batch),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
