/* The program of the suite `furnace`: traces paths inside a glowing ball (furnace_cases.h) by Embree, with the engine's
 * surfaces and the subject's random numbers. A path that leaves the ball is a failure. */
#include "bench/furnace/furnace_run.h"
#include "bench/furnace/furnace_cases.h"

#include "gi/sample/gi_bsdf.h"
#include "gi/trace/gi_ray.h"
#include "profiler/prof.h"

#include <math.h>
#include <string.h>

#define EXPERIMENTS_A_SECOND 40.0
#define EXPERIMENTS_LEAST 4u
#define SERIES_TOLERANCE 1e-5 /* largest error of the share of light that paths of n bounces lose; they do not vary */
#define SIGMAS 5.0

static const uint32_t survivals[] = {
#define SURVIVAL(PERCENT) PERCENT,
	FURNACE_SURVIVALS(SURVIVAL)
#undef SURVIVAL
};
#define SURVIVAL_COUNT (sizeof survivals / sizeof *survivals)

furnace_world furnace_world_open(const char *name, uint32_t workers)
{
	furnace_world world = {0};
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	desc.worker_count = workers;
	if (stilb_job_pool_create(&desc, &world.pool) != 0)
		bench_child_fail("cannot start worker threads");
	stilb_gi_scene_desc gi_desc = stilb_gi_scene_desc_default(world.pool);
	if (stilb_scene_open(name, &world.scene) != STILB_OK ||
	    stilb_gi_scene_create(world.scene, &gi_desc, &world.gi) != STILB_OK)
		bench_child_fail("%s: %s", name, stilb_error_message());
	return world;
}

void furnace_world_close(furnace_world *world)
{
	stilb_gi_scene_destroy(world->gi);
	stilb_scene_destroy(world->scene);
	stilb_job_pool_destroy(world->pool);
}

/* ---- one path ---------------------------------------------------------------------------------------------------- */

/* A path: its current surface and its throughput. */
typedef struct walk {
	const stilb_gi_scene *gi;
	gi_ray_hit ray;
	gi_surface surface;
	double throughput;
} walk;

static void walk_trace(walk *w, stilb_vec3 origin, stilb_vec3 direction)
{
	w->ray = gi_ray_hit_make(origin, direction);
	w->gi->tracer.intersect(&w->gi->tracer, &w->ray);
	if (!gi_is_hit(&w->ray))
		bench_child_fail("a ray left the ball");
	gi_surface_at(w->gi, &w->ray, &w->surface);
}

static walk walk_begin(const furnace_world *world)
{
	walk w = {.gi = world->gi, .throughput = 1.0};
	walk_trace(&w, stilb_vec3_make(0.0f, 0.0f, 0.0f), stilb_vec3_make(0.36f, 0.48f, -0.8f));
	return w;
}

static void walk_bounce(walk *w, const float numbers[3])
{
	shade_brdf_model lambert = {.kind = SHADE_BRDF_LAMBERT};
	gi_bsdf bsdf;
	gi_bsdf_make(&lambert, &w->surface, -gi_ray_direction(&w->ray.ray), &bsdf);
	gi_bsdf_sample chosen;
	if (!gi_bsdf_sample_direction(&bsdf, 0.0f, (stilb_vec2){numbers[0], numbers[1]}, &chosen))
		bench_child_fail("a direction points into the ball's wall");
	w->throughput *= (double)chosen.weight[0];
	walk_trace(w, gi_surface_ray_origin(&w->surface, chosen.direction), chosen.direction);
}

/* ---- cut after n bounces ----------------------------------------------------------------------------------------- */

static void run_bounces(const furnace_world *world, const furnace_numbers *numbers)
{
	double sums[FURNACE_MOST_BOUNCES + 1] = {0};
	for (uint32_t run = 0; run < FURNACE_RUNS; run++) {
		if (numbers->run)
			numbers->run(0, run);
		walk w = walk_begin(world);
		double radiance = (double)w.surface.emission[0];
		sums[0] += radiance;
		for (uint32_t bounce = 1; bounce <= FURNACE_MOST_BOUNCES; bounce++) {
			float three[3];
			numbers->vertex(bounce - 1, three);
			walk_bounce(&w, three);
			radiance += w.throughput * (double)w.surface.emission[0];
			sums[bounce] += radiance;
		}
	}
	for (uint32_t bounce = 0; bounce <= FURNACE_MOST_BOUNCES; bounce++) {
		double error = 1.0 - sums[bounce] / FURNACE_RUNS / FURNACE_RADIANCE;
		double truth = pow(FURNACE_REFLECTANCE, bounce + 1);
		if (!(fabs(error - truth) <= SERIES_TOLERANCE))
			bench_child_fail("wrong result: paths of %u bounces lose %.6g of the light, expected %.6g", bounce, error,
			                 truth);
		char metric[32];
		snprintf(metric, sizeof metric, "error-%u", bounce);
		bench_child_metric(metric, 100.0 * error);
	}
}

/* ---- Russian roulette -------------------------------------------------------------------------------------------- */

static double roulette_path(const furnace_world *world, const furnace_numbers *numbers, double survival)
{
	walk w = walk_begin(world);
	double radiance = (double)w.surface.emission[0];
	for (uint32_t vertex = 0;; vertex++) {
		float three[3];
		numbers->vertex(vertex, three);
		if ((double)three[2] >= survival)
			return radiance;
		walk_bounce(&w, three);
		w.throughput /= survival;
		radiance += w.throughput * (double)w.surface.emission[0];
	}
}

static void print_survival(const char *metric, uint32_t percent, double value)
{
	char name[32];
	snprintf(name, sizeof name, "%s-%u", metric, percent);
	bench_child_metric(name, value);
}

static void run_survival(const furnace_world *world, const furnace_numbers *numbers, uint32_t percent,
                         uint32_t experiments)
{
	double survival = percent / 100.0, runs = FURNACE_RUNS;
	double errors = 0.0, sum = 0.0, squares = 0.0;
	for (uint32_t e = 0; e < experiments; e++) {
		double part = 0.0;
		for (uint32_t run = 0; run < FURNACE_RUNS; run++) {
			if (numbers->run)
				numbers->run(e, run);
			double radiance = roulette_path(world, numbers, survival), off = radiance - FURNACE_RADIANCE;
			part += off;
			squares += off * off;
		}
		errors += fabs(part) / runs;
		sum += part;
	}
	double off = sum / (runs * experiments), sigma = sqrt(furnace_variance(survival) / (runs * experiments));
	if (isfinite(sigma) && percent >= 50 && !(fabs(off) <= SIGMAS * sigma))
		bench_child_fail("wrong result: with survival %u %% the mean is off by %.3g, more than %.0f sigma", percent,
		                 off, SIGMAS);
	print_survival("error", percent, 100.0 * errors / experiments / FURNACE_RADIANCE);
	print_survival("bias", percent, 100.0 * off / FURNACE_RADIANCE);
	print_survival("variance", percent, squares / (runs * experiments));
}

int main(int argc, char **argv)
{
	bench_child child = bench_child_args(argc, argv);
	stilb_prof_record_set(false); /* else the cost of recording profiler zones would be measured, too */
	if (strcmp(child.case_name, FURNACE_CASE_EQUAL_TIME) == 0) {
		furnace_equal_time(&child);
		return 0;
	}
	const furnace_numbers *numbers = furnace_numbers_find(child.subject);
	if (!numbers)
		return BENCH_CHILD_SKIP;
	furnace_world world = furnace_world_open("furnace:0.5", 0);
	numbers->seed(child.round + 1);
	if (strcmp(child.case_name, FURNACE_CASE_BOUNCES) == 0) {
		run_bounces(&world, numbers);
	} else {
		uint32_t experiments = (uint32_t)(child.seconds * EXPERIMENTS_A_SECOND);
		for (size_t i = 0; i < SURVIVAL_COUNT; i++)
			run_survival(&world, numbers, survivals[i],
			             experiments > EXPERIMENTS_LEAST ? experiments : EXPERIMENTS_LEAST);
	}
	furnace_world_close(&world);
	return 0;
}
