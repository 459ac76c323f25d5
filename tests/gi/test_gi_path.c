/* The path tracer against closed forms, and against itself taken apart: furnace, cut series, direct and indirect light,
 * three estimators of one integral, and samples that do not know which batch they are in. */
#include "gi_path_fixture.h"
#include "gi_world_fixture.h"

#include "gi/integrate/gi_direct.h"
#include "gi/trace/gi_ray.h"

#include <stdio.h>

#define SIGMAS 4.5 /* one test in 100,000 fails by chance */

static void expect_mean(const path_mean *mean, double truth, const char *what)
{
	for (int c = 0; c < 3; c++) {
		double error = path_mean_error(mean, c), off = fabs(path_mean_of(mean, c) - truth);
		if (!(off <= SIGMAS * error + 1e-5 * truth) || !(error < 0.05 * truth))
			fail_msg("%s, channel %d: %.5f +- %.5f, not %.5f", what, c, path_mean_of(mean, c), error, truth);
	}
}

static void expect_same_mean(const path_mean *a, const path_mean *b, const char *what)
{
	for (int c = 0; c < 3; c++) {
		double error = hypot(path_mean_error(a, c), path_mean_error(b, c));
		double off = fabs(path_mean_of(a, c) - path_mean_of(b, c));
		if (!(off <= SIGMAS * error) || !(error < 0.2 * path_mean_of(a, c)))
			fail_msg("%s, channel %d: %.5f and %.5f, standard error %.5f", what, c, path_mean_of(a, c),
			         path_mean_of(b, c), error);
	}
}

/* ---- furnace ----------------------------------------------------------------------------------------------------- */

/* The variance is finite where rho^2 < survival. */
static void furnace_has_its_radiance_at_every_survival(void **state)
{
	(void)state;
	static const struct {
		const char *name;
		double rho;
		float survivals[4]; /* 0: by throughput */
	} furnaces[] = {{"furnace:0.5", 0.5, {0.0f, 0.4f, 0.8f, 1.0f}}, {"furnace:0.8", 0.8, {0.0f, 0.75f, 0.9f, 1.0f}}};
	for (int f = 0; f < 2; f++) {
		path_fixture fixture = path_fixture_open(furnaces[f].name);
		for (int s = 0; s < 4; s++) {
			gi_view view = path_view(&fixture, STILB_GI_INTEGRATOR_PATH, 16, 8);
			view.settings.roulette = furnaces[f].survivals[s];
			path_mean mean = path_picture_mean(&view);
			expect_mean(&mean, 1.0 / (1.0 - furnaces[f].rho), furnaces[f].name);
		}
		path_fixture_finish(&fixture);
	}
}

static void depth_cuts_the_series(void **state)
{
	(void)state;
	path_fixture fixture = path_fixture_open("furnace:0.5");
	for (uint32_t depth = 0; depth <= 5; depth++) {
		gi_view view = path_view(&fixture, STILB_GI_INTEGRATOR_PATH, 16, 8);
		view.settings.depth = depth;
		path_mean mean = path_picture_mean(&view);
		double truth = (1.0 - pow(0.5, depth + 1.0)) / (1.0 - 0.5);
		expect_mean(&mean, truth, "a cut series");
		if (depth == 0)
			assert_true(path_mean_error(&mean, 0) == 0.0);
	}
	path_fixture_finish(&fixture);
}

/* A matt triangle whose normals are tilted, under a white sky: what goes below it is lost, and the rest is what
 * a tilted plane sees of the sky, (1 + cosine) / 2. */
static void tilted_normals_see_what_is_above(void **state)
{
	(void)state;
	static const float corners[3][3] = {{-100.0f, 0.0f, 100.0f}, {100.0f, 0.0f, 100.0f}, {0.0f, 0.0f, -200.0f}};
	stilb_scene *scene = world_scene(1, 1, 1);
	world_triangle(&scene->meshes[0], corners);
	for (int i = 0; i < 3; i++) {
		float normal[3] = {0.8f, 0.6f, 0.0f};
		memcpy(scene->meshes[0].vertices[i].normal, normal, sizeof normal);
	}
	scene->surroundings = (stilb_scene_surroundings){.sky = {1.0f, 1.0f, 1.0f}};
	scene->camera = (stilb_scene_camera){
		.position = {0.0f, 5.0f, 0.0f}, .pitch = -1.5f, .fov_y = 0.5f, .near_z = 0.1f, .far_z = 1000.0f};
	path_fixture fixture = path_fixture_make(scene);
	gi_view view = path_view(&fixture, STILB_GI_INTEGRATOR_PATH, 32, 16);
	path_mean mean = path_picture_mean(&view);
	expect_mean(&mean, 0.5 * 0.5 * (1.0 + 0.6), "tilted normals");
	path_fixture_finish(&fixture);
}

/* ---- taken apart ------------------------------------------------------------------------------------------------- */

static void samples_of(const gi_view *view, path_samples *out)
{
	path_samples_take(view, 0, GI_BATCH, out);
	path_samples_shade(view, out);
}

/* Sample by sample: what is seen of lights and reflected once, and the rest. */
static void direct_and_indirect_light_are_all_light(void **state)
{
	(void)state;
	static const char *const names[] = {"cornell", "spheres"};
	path_samples *all = malloc(sizeof *all), *direct = malloc(sizeof *direct), *indirect = malloc(sizeof *indirect);
	for (int n = 0; n < 2; n++) {
		path_fixture fixture = path_fixture_open(names[n]);
		gi_view view = path_view(&fixture, STILB_GI_INTEGRATOR_PATH, 32, 1);
		samples_of(&view, all);
		view.settings.only = STILB_GI_ONLY_INDIRECT;
		samples_of(&view, indirect);
		view.settings.only = STILB_GI_ALL_LIGHT;
		view.settings.depth = 1;
		samples_of(&view, direct);
		uint32_t lit[2] = {0};
		for (uint32_t i = 0; i < GI_BATCH; i++)
			for (int c = 0; c < 3; c++) {
				float whole = all->radiance[i][c], sum = direct->radiance[i][c] + indirect->radiance[i][c];
				if (!(fabsf(whole - sum) <= 1e-5f * whole + 1e-6f))
					fail_msg("%s, sample %u: %g + %g, not %g", names[n], i, (double)direct->radiance[i][c],
					         (double)indirect->radiance[i][c], (double)whole);
				lit[0] += direct->radiance[i][c] > 0.0f;
				lit[1] += indirect->radiance[i][c] > 0.0f;
			}
		assert_true(lit[0] > 100 && lit[1] > 100);
		path_fixture_finish(&fixture);
	}
	free(all);
	free(direct);
	free(indirect);
}

/* Where a camera ray ended, as a path's first vertex sees it. */
typedef struct first_vertex {
	gi_bsdf bsdf;
	stilb_vec3 origin; /* of the rays that leave */
	float numbers[8];
	uint32_t part;
} first_vertex;

/* False: it hit nothing. */
static bool first_vertex_of(const gi_view *view, const path_samples *samples, uint32_t i, first_vertex *vertex)
{
	const gi_ray_hit *camera = &samples->rays[i];
	if (!gi_is_hit(camera))
		return false;
	gi_surface surface;
	gi_surface_at(view->scene, camera, &surface);
	gi_bsdf_make(&view->settings.model, &surface, -gi_ray_direction(&camera->ray), &vertex->bsdf);
	vertex->origin = gi_surface_ray_origin(&surface, surface.geometric);
	vertex->part = surface.part;
	gi_sample_8(&view->sampler, samples->points[i], GI_DIMENSION_OF(0), vertex->numbers);
	return true;
}

/* Light reflected once by the first hit of the camera ray, found by the BSDF's directions alone. */
static stilb_vec3 found_by_bsdf(const gi_view *view, const first_vertex *vertex)
{
	const float *numbers = vertex->numbers;
	stilb_vec2 u = {numbers[GI_DIMENSION_DIRECTION], numbers[GI_DIMENSION_DIRECTION + 1]};
	gi_bsdf_sample chosen;
	if (!gi_bsdf_sample_direction(&vertex->bsdf, numbers[GI_DIMENSION_LOBE], u, &chosen))
		return (stilb_vec3){0};
	gi_ray_hit ray = gi_ray_hit_make(vertex->origin, chosen.direction);
	view->scene->tracer.intersect(&view->scene->tracer, &ray);
	gi_surface surface;
	bool hit = gi_is_hit(&ray);
	if (hit)
		gi_surface_at(view->scene, &ray, &surface);
	return chosen.weight * gi_direct_found(view, &(gi_direct_left){.pdf = 0.0f}, &ray, hit ? &surface : NULL);
}

/* By asking lights alone. */
static stilb_vec3 found_by_light(const gi_view *view, const first_vertex *vertex)
{
	gi_ray shadows[GI_LIGHT_GROUPS];
	stilb_vec3 direct[GI_LIGHT_GROUPS], sum = {0};
	uint32_t count = gi_direct_ask(view, &vertex->bsdf, vertex->part, vertex->origin, vertex->numbers, GI_DIRECT_ALONE,
	                               shadows, direct);
	view->scene->tracer.occluded(&view->scene->tracer, shadows, count);
	for (uint32_t i = 0; i < count; i++)
		sum += shadows[i].t_max >= 0.0f ? direct[i] : (stilb_vec3){0};
	return sum;
}

/* By both, weighed: what the path does, without what is seen of the lights themselves. Into samples. */
static void found_by_path(const gi_view *view, path_samples *samples)
{
	gi_batch batch = {.view = view,
	                  .count = samples->count,
	                  .points = samples->points,
	                  .rays = samples->rays,
	                  .radiance = samples->radiance,
	                  .scratch = stilb_memory_alloc(1, gi_integrator_path.scratch_size)};
	assert_non_null(batch.scratch);
	gi_path_gather(&batch, 0, 1);
	free(batch.scratch);
}

static void three_ways_to_find_light_agree(void **state)
{
	(void)state;
	static const char *const names[] = {"cornell", "spheres", "outdoor"};
	path_samples *samples = malloc(sizeof *samples);
	for (int n = 0; n < 3; n++) {
		path_fixture fixture = path_fixture_open(names[n]);
		gi_view view = path_view(&fixture, STILB_GI_INTEGRATOR_PATH, 32, 32);
		path_mean bsdf = {0}, light = {0}, both = {0};
		for (uint64_t first = 0; first < 32 * 32 * 32; first += GI_BATCH) {
			path_samples_take(&view, first, GI_BATCH, samples);
			found_by_path(&view, samples);
			for (uint32_t i = 0; i < GI_BATCH; i++) {
				first_vertex vertex;
				bool hit = first_vertex_of(&view, samples, i, &vertex);
				path_mean_add(&bsdf, hit ? found_by_bsdf(&view, &vertex) : (stilb_vec3){0});
				path_mean_add(&light, hit ? found_by_light(&view, &vertex) : (stilb_vec3){0});
				path_mean_add(&both, samples->radiance[i]);
			}
		}
		printf("%-8s bsdf %.4f +- %.4f, light %.4f +- %.4f, both %.4f +- %.4f\n", names[n], path_mean_of(&bsdf, 0),
		       path_mean_error(&bsdf, 0), path_mean_of(&light, 0), path_mean_error(&light, 0), path_mean_of(&both, 0),
		       path_mean_error(&both, 0));
		expect_same_mean(&both, &light, names[n]);
		expect_same_mean(&both, &bsdf, names[n]);
		path_fixture_finish(&fixture);
	}
	free(samples);
}

/* N paths from one hit have the mean of one path, and less noise. */
static void split_is_path_with_less_noise(void **state)
{
	(void)state;
	path_fixture fixture = path_fixture_open("cornell");
	gi_view view = path_view(&fixture, STILB_GI_INTEGRATOR_PATH, 32, 4);
	path_mean path = path_picture_mean(&view);
	view.settings.integrator = STILB_GI_INTEGRATOR_SPLIT;
	view.settings.rays = 7; /* waves end inside a sample */
	path_mean split = path_picture_mean(&view);
	expect_same_mean(&path, &split, "split");
	assert_true(path_mean_error(&split, 0) < path_mean_error(&path, 0));
	path_fixture_finish(&fixture);
}

/* ---- the same bits ----------------------------------------------------------------------------------------------- */

static void expect_same_bits(stilb_vec3 a, stilb_vec3 b, uint32_t sample)
{
	for (int c = 0; c < 3; c++)
		if (!(a[c] == b[c]))
			fail_msg("sample %u, channel %d: %.9g and %.9g", sample, c, (double)a[c], (double)b[c]);
}

/* Alone or in other company. */
static void a_sample_does_not_know_its_batch(void **state)
{
	(void)state;
	static const char *const names[] = {"cornell", "spheres"};
	path_samples *all = malloc(sizeof *all), *part = malloc(sizeof *part);
	for (int n = 0; n < 2; n++) {
		path_fixture fixture = path_fixture_open(names[n]);
		gi_view view = path_view(&fixture, STILB_GI_INTEGRATOR_PATH, 32, 1);
		samples_of(&view, all);
		uint64_t rays_traced = 0, shadow_rays = 0;
		for (uint32_t first = 0, count = 1; first < GI_BATCH; first += count, count = count % 37 + 1) {
			count = first + count < GI_BATCH ? count : GI_BATCH - first;
			path_samples_take(&view, first, count, part);
			path_samples_shade(&view, part);
			for (uint32_t i = 0; i < count; i++)
				expect_same_bits(part->radiance[i], all->radiance[first + i], first + i);
			rays_traced += part->rays_traced;
			shadow_rays += part->shadow_rays;
		}
		assert_int_equal(rays_traced, all->rays_traced);
		assert_int_equal(shadow_rays, all->shadow_rays);
		path_fixture_finish(&fixture);
	}
	free(all);
	free(part);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(furnace_has_its_radiance_at_every_survival),
		cmocka_unit_test(depth_cuts_the_series),
		cmocka_unit_test(tilted_normals_see_what_is_above),
		cmocka_unit_test(direct_and_indirect_light_are_all_light),
		cmocka_unit_test(three_ways_to_find_light_agree),
		cmocka_unit_test(split_is_path_with_less_noise),
		cmocka_unit_test(a_sample_does_not_know_its_batch),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
