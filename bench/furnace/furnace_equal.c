/* The case equal-time: the Cornell box by the integrators `path` and `montecarlo` in equal time. Both end paths after
 * the same number of bounces, so their pictures have the same expectation, and the variance among renderings of one
 * kind is its error: no reference is needed. */
#include "bench/furnace/furnace_cases.h"
#include "bench/furnace/furnace_run.h"

#include "gi/gi_render.h"

#include <math.h>

#define SIDE 32u
#define VALUES (3u * SIDE * SIDE)
#define RENDERINGS 8u /* of each kind */
#define SIGMAS 5.0

/* An integrator: rays 0 is `path`, else `montecarlo` with that number of rays at every hit. */
typedef struct kind {
	uint32_t rays, samples;
	double seconds; /* of all renderings */
	double sum[VALUES], squares[VALUES];
} kind;

static kind kinds[] = {{.rays = 0},
#define KIND(RAYS) {.rays = RAYS},
                       FURNACE_BRANCHES(KIND)
#undef KIND
};
#define KIND_COUNT (sizeof kinds / sizeof *kinds)

static void check(stilb_result result)
{
	if (result != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
}

/* Renders the picture once, adds it to the sums of its kind if `wanted`, and returns the time in seconds. */
static double render_once(const furnace_world *world, kind *k, uint32_t samples, uint64_t seed, bool wanted)
{
	stilb_gi_settings settings = stilb_gi_settings_default(world->scene);
	settings.integrator = k->rays ? STILB_GI_INTEGRATOR_MONTECARLO : STILB_GI_INTEGRATOR_PATH;
	settings.width = settings.height = SIDE;
	settings.depth = FURNACE_EQUAL_DEPTH;
	settings.samples = samples;
	settings.seed = seed;
	if (k->rays)
		settings.rays = k->rays;
	stilb_gi_render *render;
	check(stilb_gi_render_create(world->gi, &settings, world->pool, &render));
	uint64_t begin = bench_child_now_ns();
	check(stilb_gi_render_run(render));
	double seconds = (double)(bench_child_now_ns() - begin) * 1e-9;
	const float *radiance = stilb_gi_render_film(render).radiance;
	for (uint32_t i = 0; wanted && i < VALUES; i++) {
		k->sum[i] += (double)radiance[i];
		k->squares[i] += (double)radiance[i] * (double)radiance[i];
	}
	stilb_gi_render_destroy(render);
	return seconds;
}

/* The mean of all values of all renderings of a kind. *error_squared: the variance of a value among the renderings,
 * averaged over the picture. */
static double kind_mean(const kind *k, double *error_squared)
{
	double mean = 0.0, variance = 0.0;
	for (uint32_t i = 0; i < VALUES; i++) {
		double m = k->sum[i] / RENDERINGS;
		mean += m;
		variance += (k->squares[i] - RENDERINGS * m * m) / (RENDERINGS - 1);
	}
	*error_squared = variance / VALUES;
	return mean / VALUES;
}

void furnace_equal_time(const bench_child *child)
{
	furnace_world world = furnace_world_open("cornell", stilb_job_pool_desc_default().worker_count);
	double slot = child->seconds / (RENDERINGS * KIND_COUNT);
	for (size_t i = 0; i < KIND_COUNT; i++) {
		render_once(&world, &kinds[i], 1, 1, false); /* warm-up */
		double one = render_once(&world, &kinds[i], 1, 1, false);
		kinds[i].samples = (uint32_t)fmax(slot / one, 1.0);
	}
	for (uint32_t r = 0; r < RENDERINGS; r++)
		for (size_t i = 0; i < KIND_COUNT; i++)
			kinds[i].seconds += render_once(&world, &kinds[i], kinds[i].samples, 1000 * (child->round + 1) + r, true);
	double path_squared, path_mean = kind_mean(&kinds[0], &path_squared);
	for (size_t i = 0; i < KIND_COUNT; i++) {
		double squared, mean = kind_mean(&kinds[i], &squared);
		double sigma = sqrt((squared + path_squared) / (VALUES * RENDERINGS));
		if (!(fabs(mean - path_mean) <= SIGMAS * sigma))
			bench_child_fail(
				"wrong result: the means of path and of montecarlo with %u rays differ by %.3g, sigma %.3g",
				kinds[i].rays, mean - path_mean, sigma);
		/* A kind's renderings took longer or shorter than their slots of equal time. variance * time is constant, so
		 * this is the variance that they would have after exactly their slots. */
		double equal = squared * kinds[i].seconds / (slot * RENDERINGS);
		char metric[32];
		snprintf(metric, sizeof metric, kinds[i].rays ? "montecarlo-%u" : "path", kinds[i].rays);
		bench_child_metric(metric, 100.0 * sqrt(equal) / path_mean);
	}
	furnace_world_close(&world);
}
