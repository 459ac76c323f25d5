/* Long runs: the irradiance cache against the path tracer, in time, in bias, and with both kinds of radii. */
#include "gi_render_fixture.h"

#include <math.h>

#define SIDE 96u

static render_fixture fixture;
static stilb_gi_settings settings;
static float *references[2]; /* indirect light, independent of one another */

static float *picture(const stilb_gi_settings *of, uint32_t *records)
{
	stilb_gi_render *render = render_fixture_create(&fixture, of);
	if (stilb_gi_render_run(render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	if (records)
		*records = progress_of(render).records;
	float *copy = malloc(SIDE * SIDE * 3 * sizeof *copy);
	assert_non_null(copy);
	memcpy(copy, stilb_gi_render_film(render).radiance, SIDE * SIDE * 3 * sizeof *copy);
	stilb_gi_render_destroy(render);
	return copy;
}

static int references_make(void **state)
{
	(void)state;
	fixture = render_fixture_with("cornell", 1, &stilb_gi_embree);
	settings = stilb_gi_settings_default(fixture.scene);
	settings.width = settings.height = SIDE;
	settings.only = STILB_GI_ONLY_INDIRECT;
	settings.samples = 160;
	for (int i = 0; i < 2; i++) {
		settings.seed = 100 + (uint64_t)i;
		references[i] = picture(&settings, NULL);
	}
	settings.seed = 1;
	settings.samples = 16;
	return 0;
}

static int references_drop(void **state)
{
	(void)state;
	free(references[0]);
	free(references[1]);
	render_fixture_finish(&fixture);
	return 0;
}

/* The product of the differences to two references has the square of the true difference as its mean: their own noise
 * is not in it. */
static double square_error(const float *rgb, double *bias)
{
	double square = 0.0, sum = 0.0, truth = 0.0;
	for (uint32_t i = 0; i < SIDE * SIDE * 3; i++) {
		double a = (double)references[0][i], b = (double)references[1][i], value = (double)rgb[i];
		square += (value - a) * (value - b);
		sum += value;
		truth += 0.5 * (a + b);
	}
	*bias = sum / truth - 1.0;
	return square / (SIDE * SIDE * 3);
}

static double rmse_of(const stilb_gi_settings *of, uint32_t *records, double *bias)
{
	float *rgb = picture(of, records);
	double square = square_error(rgb, bias);
	free(rgb);
	return sqrt(fmax(square, 0.0));
}

/* At the same number of samples a pixel. */
static void cache_is_quieter_than_paths_and_hardly_biased(void **state)
{
	(void)state;
	double path_bias, cache_bias;
	double path_rmse = rmse_of(&settings, NULL, &path_bias);
	stilb_gi_settings cached = settings;
	cached.integrator = STILB_GI_INTEGRATOR_IRRADIANCE_CACHE;
	double cache_rmse = rmse_of(&cached, NULL, &cache_bias);
	print_message("path %.5f, bias %.4f; cache %.5f, bias %.4f\n", path_rmse, path_bias, cache_rmse, cache_bias);
	assert_true(cache_rmse < 0.25 * path_rmse);
	assert_true(fabs(cache_bias) < 0.02); /* of indirect light, some 40 % of all */
}

static double light_of(const float *rgb)
{
	double sum = 0.0;
	for (uint32_t i = 0; i < SIDE * SIDE * 3; i++)
		sum += (double)rgb[i];
	return sum;
}

/* Mean of the light of pictures with other seeds, and the standard error of that mean. */
static double light_over_seeds(stilb_gi_settings of, uint32_t count, uint64_t seed, double *error)
{
	double sum = 0.0, squares = 0.0;
	for (uint32_t i = 0; i < count; i++) {
		of.seed = seed + i;
		float *rgb = picture(&of, NULL);
		double light = light_of(rgb);
		sum += light;
		squares += light * light;
		free(rgb);
	}
	double mean = sum / count;
	*error = sqrt(fmax(squares / count - mean * mean, 0.0) / (count - 1));
	return mean;
}

/* The bias of indirect light over 20 seeds. A picture of one seed is off by the noise of its records' rays, too, which
 * is not bias: 0.2 %. The bound is four standard errors away from what was measured. */
static void bias_is_below_three_permille(void **state)
{
	(void)state;
	stilb_gi_settings cached = settings, traced = settings;
	double truth_error, cache_error;
	traced.samples = 256;
	double truth = light_over_seeds(traced, 4, 300, &truth_error);
	cached.integrator = STILB_GI_INTEGRATOR_IRRADIANCE_CACHE;
	cached.samples = 8;
	double light = light_over_seeds(cached, 20, 1, &cache_error);
	double bias = light / truth - 1.0, error = hypot(truth_error, cache_error) / truth;
	print_message("bias of indirect light %.3f %% +- %.3f\n", 100.0 * bias, 100.0 * error);
	assert_true(fabs(bias) < 0.003);
	assert_true(error < 0.001);
}

static double split_sphere_at(uint32_t wanted, uint32_t *records)
{
	stilb_gi_settings split = settings;
	split.integrator = STILB_GI_INTEGRATOR_IRRADIANCE_CACHE;
	split.cache.radius = STILB_GI_CACHE_SPLIT_SPHERE;
	split.cache.rays = 2048;
	double low = 0.05, high = 1.0, rmse = 0.0, bias;
	for (int i = 0; i < 5; i++) {
		double middle = 0.5 * (low + high);
		split.cache.error = (float)middle;
		rmse = rmse_of(&split, records, &bias);
		*(*records > wanted ? &low : &high) = middle;
		if (abs((int)*records - (int)wanted) < (int)wanted / 20)
			break;
	}
	return rmse;
}

static void hessian_places_records_better(void **state)
{
	(void)state;
	stilb_gi_settings hessian = settings;
	hessian.integrator = STILB_GI_INTEGRATOR_IRRADIANCE_CACHE;
	hessian.cache.rays = 2048;
	uint32_t records, split_records;
	double bias, hessian_rmse = rmse_of(&hessian, &records, &bias);
	double split_rmse = split_sphere_at(records, &split_records);
	print_message("hessian %.5f with %u records, split-sphere %.5f with %u\n", hessian_rmse, records, split_rmse,
	              split_records);
	assert_true(hessian_rmse < split_rmse);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(cache_is_quieter_than_paths_and_hardly_biased),
		cmocka_unit_test(bias_is_below_three_permille),
		cmocka_unit_test(hessian_places_records_better),
	};
	return cmocka_run_group_tests(tests, references_make, references_drop);
}
