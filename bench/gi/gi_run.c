/* The program of the suite `gi`: its cases that compare techniques of the offline renderer (engine/gi), and main. */
#include "bench/gi/gi_run.h"
#include "bench/gi/gi_cases.h"

#include "base/base.h"
#include "profiler/prof.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

void gi_run_check(stilb_result result, const char *what)
{
	if (result != STILB_OK)
		bench_child_fail("%s: %s", what, stilb_error_message());
}

gi_run_world gi_run_world_make(stilb_scene *scene, uint32_t workers)
{
	gi_run_world world = {.scene = scene};
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	desc.worker_count = workers;
	if (stilb_job_pool_create(&desc, &world.pool) != 0)
		bench_child_fail("cannot start worker threads");
	stilb_gi_scene_desc gi_desc = stilb_gi_scene_desc_default(world.pool);
	gi_run_check(stilb_gi_scene_create(scene, &gi_desc, &world.gi), "the scene");
	return world;
}

void gi_run_world_finish(gi_run_world *world)
{
	stilb_gi_scene_destroy(world->gi);
	stilb_scene_destroy(world->scene);
	stilb_job_pool_destroy(world->pool);
	*world = (gi_run_world){0};
}

static gi_run_world cornell(uint32_t workers)
{
	stilb_scene *scene;
	gi_run_check(stilb_scene_open("cornell", &scene), "cornell");
	return gi_run_world_make(scene, workers);
}

static double once(const gi_run_world *world, const stilb_gi_settings *settings)
{
	gi_run_picture picture = gi_run_render(world, settings);
	gi_run_picture_finish(&picture);
	return picture.seconds;
}

/* ---- speed alone ------------------------------------------------------------------------------------------------- */

static void run_sobol(const bench_child *child)
{
	gi_run_world world = cornell(0);
	stilb_gi_settings settings = gi_run_cornell(world.scene);
	settings.samples = 4;
	double sobol = (double)INFINITY, random = (double)INFINITY, spent = 0.0;
	while (spent < child->seconds) {
		settings.seed++;
		settings.sampler = STILB_GI_SAMPLER_SOBOL;
		double a = once(&world, &settings);
		settings.sampler = STILB_GI_SAMPLER_RANDOM;
		double b = once(&world, &settings);
		sobol = fmin(sobol, a);
		random = fmin(random, b);
		spent += a + b;
	}
	double samples = 1e-6 * settings.samples * GI_RUN_SIDE * GI_RUN_SIDE;
	bench_child_metric("sobol", samples / sobol);
	bench_child_metric("random", samples / random);
	bench_child_metric("ratio", random / sobol);
	gi_run_world_finish(&world);
}

static void run_workers(const bench_child *child)
{
	if (bench_child_cpu_count() < 2)
		exit(BENCH_CHILD_SKIP);
	gi_run_world one = cornell(0), two = cornell(1);
	stilb_gi_settings settings = gi_run_cornell(one.scene);
	settings.samples = 16;
	double a = (double)INFINITY, b = (double)INFINITY, spent = 0.0;
	while (spent < child->seconds) {
		double alone = once(&one, &settings), both = once(&two, &settings);
		a = fmin(a, alone);
		b = fmin(b, both);
		spent += alone + both;
	}
	double samples = 1e-6 * settings.samples * GI_RUN_SIDE * GI_RUN_SIDE;
	bench_child_metric("one", samples / a);
	bench_child_metric("two", samples / b);
	bench_child_metric("ratio", a / b);
	gi_run_world_finish(&two);
	gi_run_world_finish(&one);
}

/* ---- speed and error --------------------------------------------------------------------------------------------- */

/* Sums over several pictures: rendering time, squared error, bias in percent (gi_run_error), and records, the points at
 * which the irradiance cache stores light. */
typedef struct tally {
	double seconds, square, bias, records;
	uint32_t count;
} tally;

static void tally_add(tally *t, gi_run_picture *picture, const gi_run_reference *reference, bool indirect)
{
	gi_run_error error = gi_run_compare(reference, picture->rgb, indirect);
	t->seconds += picture->seconds;
	t->square += error.square;
	t->bias += error.bias;
	t->records += (double)picture->records;
	t->count++;
	gi_run_picture_finish(picture);
}

static double tally_seconds(const tally *t)
{
	return t->seconds / t->count;
}

static double tally_rmse(const tally *t)
{
	return sqrt(t->square / t->count);
}

static stilb_gi_settings cache_settings(const gi_run_world *world)
{
	stilb_gi_settings settings = gi_run_cornell(world->scene);
	settings.integrator = STILB_GI_INTEGRATOR_IRRADIANCE_CACHE;
	return settings;
}

static void run_cache_time(const bench_child *child)
{
	gi_run_reference reference = gi_run_reference_read(child->argument);
	gi_run_world world = cornell(0);
	stilb_gi_settings settings = cache_settings(&world);
	settings.samples = 16;
	settings.seed = 1 + 1000 * child->round;
	tally cache = {0};
	while (cache.count == 0 || cache.seconds < child->seconds) {
		settings.seed++;
		gi_run_picture picture = gi_run_render(&world, &settings);
		tally_add(&cache, &picture, &reference, false);
	}
	bench_child_metric("seconds", tally_seconds(&cache));
	bench_child_metric("rmse", tally_rmse(&cache));
	bench_child_metric("bias", cache.bias / cache.count);
	bench_child_metric("records", cache.records / cache.count);
	gi_run_world_finish(&world);
}

/* Compares the error of the irradiance cache with that of path tracing if both render for `budget` seconds. */
static void run_equal_time(const bench_child *child, double budget)
{
	gi_run_reference reference = gi_run_reference_read(child->argument);
	gi_run_world world = cornell(bench_child_cpu_count() - 1);
	stilb_gi_settings cached = cache_settings(&world), traced = gi_run_cornell(world.scene);
	cached.only = traced.only = STILB_GI_ONLY_INDIRECT;
	cached.seconds = traced.seconds = budget;
	cached.samples = traced.samples = 4096;
	cached.seed = traced.seed = 1 + 1000 * child->round;
	if (budget < 0.5) {
		cached.cache.error *= 1.5f;
		cached.cache.rays /= 2;
	}
	tally cache = {0}, path = {0};
	while (cache.count == 0 || cache.seconds + path.seconds < child->seconds) {
		cached.seed = ++traced.seed;
		gi_run_picture a = gi_run_render(&world, &cached), b = gi_run_render(&world, &traced);
		tally_add(&cache, &a, &reference, true);
		tally_add(&path, &b, &reference, true);
	}
	bench_child_metric("cache-rmse", tally_rmse(&cache));
	bench_child_metric("path-rmse", tally_rmse(&path));
	bench_child_metric("ratio", tally_rmse(&cache) / tally_rmse(&path));
	bench_child_metric("cache-seconds", tally_seconds(&cache));
	bench_child_metric("path-seconds", tally_seconds(&path));
	bench_child_metric("bias", cache.bias / cache.count);
	gi_run_world_finish(&world);
}

#define HESSIAN_RAYS 2048u /* for each cache record: enough that noise does not hide the error of interpolation */
#define RECORDS_APART 0.02 /* two numbers of records whose relative difference is less count as equal */
#define RECORD_SEARCHES 12

static gi_run_picture indirect(const gi_run_world *world, stilb_gi_cache_radius radius, float error)
{
	stilb_gi_settings settings = cache_settings(world);
	settings.only = STILB_GI_ONLY_INDIRECT;
	settings.samples = 4;
	settings.cache.radius = radius;
	settings.cache.error = error;
	settings.cache.rays = HESSIAN_RAYS;
	return gi_run_render(world, &settings);
}

/* Renders with about `records` cache records: searches for the error setting of the cache that gives so many. The area
 * for which a record is used is proportional to the square of that setting. */
static gi_run_picture indirect_with(const gi_run_world *world, stilb_gi_cache_radius radius, uint64_t records)
{
	gi_run_picture picture = {0};
	float error = 0.2f;
	for (int search = 0; search < RECORD_SEARCHES; search++) {
		gi_run_picture_finish(&picture);
		picture = indirect(world, radius, error);
		double share = (double)picture.records / (double)records;
		if (fabs(share - 1.0) < RECORDS_APART)
			break;
		error = fminf(error * (float)sqrt(share), 1.0f);
	}
	return picture;
}

/* Compares three rules for the radii of cache records, with equal numbers of records: the occlusion Hessian, and Ward's
 * split-sphere radii, plain (harmonic mean of distances) and bounded. */
static void run_hessian(const bench_child *child)
{
	gi_run_reference reference = gi_run_reference_read(child->argument);
	gi_run_world world = cornell(bench_child_cpu_count() - 1);
	float error = cache_settings(&world).cache.error;
	gi_run_picture hessian = indirect(&world, STILB_GI_CACHE_HESSIAN, error);
	gi_run_picture plain = indirect_with(&world, STILB_GI_CACHE_HARMONIC, hessian.records);
	gi_run_picture bounded = indirect_with(&world, STILB_GI_CACHE_SPLIT_SPHERE, hessian.records);
	double square = gi_run_compare(&reference, hessian.rgb, true).square;
	double plain_square = gi_run_compare(&reference, plain.rgb, true).square;
	double bounded_square = gi_run_compare(&reference, bounded.rgb, true).square;
	bench_child_metric("hessian-rmse", sqrt(square));
	bench_child_metric("plain-rmse", sqrt(plain_square));
	bench_child_metric("bounded-rmse", sqrt(bounded_square));
	bench_child_metric("ratio", sqrt(square / plain_square));
	bench_child_metric("ratio-bounded", sqrt(square / bounded_square));
	bench_child_metric("hessian-records", (double)hessian.records);
	bench_child_metric("plain-records", (double)plain.records);
	bench_child_metric("bounded-records", (double)bounded.records);
	gi_run_picture_finish(&hessian);
	gi_run_picture_finish(&plain);
	gi_run_picture_finish(&bounded);
	gi_run_world_finish(&world);
}

/* ---- programs of others ------------------------------------------------------------------------------------------ */

#define PATHTRACER_SCENE "/usr/share/doc/embree3/models/cornell_box"
#define PATHTRACER_DEPTH 5u

/* A run of Embree's example program on one thread. */
typedef struct pathtracer_run {
	double cpu_seconds;     /* of all of it, its start included */
	double million_a_frame; /* rays; 0 if it is not installed */
} pathtracer_run;

static pathtracer_run pathtracer_frames(uint32_t frames)
{
	char command[256], line[256];
	snprintf(command, sizeof command,
	         "pathtracer -c " PATHTRACER_SCENE ".ecs --rtcore threads=1 --size 256 256 --max-path-length 5 --spp 4 "
	         "--benchmark 0 %u 2>&1",
	         frames);
	double rays_rate = 0.0, frame_rate = 0.0;
	struct rusage before, after;
	getrusage(RUSAGE_CHILDREN, &before);
	FILE *pipe = popen(command, "r");
	while (pipe && fgets(line, sizeof line, pipe)) {
		sscanf(line, "BENCHMARK_RENDER_MRAYPS_AVG %lf", &rays_rate);
		sscanf(line, "BENCHMARK_RENDER_AVG %lf", &frame_rate);
	}
	if (pipe)
		pclose(pipe);
	getrusage(RUSAGE_CHILDREN, &after);
	double cpu = (double)(after.ru_utime.tv_sec - before.ru_utime.tv_sec) +
	             1e-6 * (double)(after.ru_utime.tv_usec - before.ru_utime.tv_usec);
	return (pathtracer_run){cpu, frame_rate > 0.0 ? rays_rate / frame_rate : 0.0};
}

/* Million rays in a second of CPU time; 0 if the program is not installed. */
static double pathtracer_rate(void)
{
	pathtracer_run some = pathtracer_frames(2), more = pathtracer_frames(12);
	double seconds = more.cpu_seconds - some.cpu_seconds;
	return seconds > 0.0 ? 10.0 * more.million_a_frame / seconds : 0.0;
}

/* The model of Embree's example program, with the camera and light that its file of options (.ecs) sets. */
static stilb_scene *pathtracer_scene(void)
{
	stilb_scene *scene;
	if (access(PATHTRACER_SCENE ".obj", R_OK) != 0)
		exit(BENCH_CHILD_SKIP);
	gi_run_check(stilb_scene_open(PATHTRACER_SCENE ".obj", &scene), "Embree's Cornell box");
	scene->camera = (stilb_scene_camera){.position = {278.0f, 273.0f, -800.0f},
	                                     .yaw = 3.14159265f,
	                                     .fov_y = 37.0f * 3.14159265f / 180.0f,
	                                     .near_z = 1.0f,
	                                     .far_z = 10000.0f};
	scene->lights = stilb_memory_alloc(1, sizeof *scene->lights);
	if (!scene->lights)
		bench_child_fail("no memory for a light");
	scene->light_count = 1;
	scene->lights[0] = (stilb_scene_light){
		.kind = STILB_SCENE_LIGHT_POINT, .position = {213.0f, 300.0f, 227.0f}, .intensity = {1e5f, 1e5f, 1e5f}};
	stilb_scene_set_sky(scene, (const float[3]){0});
	return scene;
}

static void run_pathtracer(const bench_child *child)
{
	double theirs = pathtracer_rate();
	if (theirs <= 0.0)
		exit(BENCH_CHILD_SKIP);
	gi_run_world world = gi_run_world_make(pathtracer_scene(), 0);
	stilb_gi_settings settings = stilb_gi_settings_default(world.scene);
	settings.integrator = STILB_GI_INTEGRATOR_PATH;
	settings.width = settings.height = GI_RUN_SIDE;
	settings.samples = 4;
	settings.depth = PATHTRACER_DEPTH; /* the example counts a camera ray and its shadow ray as depth 1 */
	settings.roulette = 1.0f;          /* as in the example: paths end at a miss or at their depth */
	double seconds = 0.0, rays = 0.0;
	while (seconds < child->seconds) {
		settings.seed++;
		gi_run_picture picture = gi_run_render(&world, &settings);
		seconds += picture.thread_seconds;
		rays += (double)picture.rays;
		gi_run_picture_finish(&picture);
	}
	double own = 1e-6 * rays / seconds;
	bench_child_metric("stilb", own);
	bench_child_metric("embree", theirs);
	bench_child_metric("ratio", own / theirs);
	gi_run_world_finish(&world);
}

/* ---- which case -------------------------------------------------------------------------------------------------- */

static bool is_case(const bench_child *child, const char *name)
{
	return strcmp(child->case_name, name) == 0;
}

static bool is_row(const bench_child *child)
{
#define ROW(NAME, TITLE) is_case(child, NAME) ||
	return GI_ROWS(ROW) false;
#undef ROW
}

/* The row whose scene the case denoises; NULL: it is none of these cases. */
static const char *denoised_row(const bench_child *child)
{
	size_t prefix = strlen(GI_DENOISE);
	if (strncmp(child->case_name, GI_DENOISE, prefix) != 0)
		return NULL;
	bench_child row = *child;
	row.case_name = child->case_name + prefix;
	return is_row(&row) ? row.case_name : NULL;
}

int main(int argc, char **argv)
{
	bench_child child = bench_child_args(argc, argv);
	stilb_prof_record_set(false); /* else the cost of recording profiler zones would be measured, too */
	if (is_case(&child, "reference")) {
		gi_run_reference_write(child.argument, child.round);
		bench_child_metric("samples", child.round); /* a run must print at least one metric */
	} else if (strncmp(child.case_name, "build", strlen("build")) == 0)
		gi_run_build(&child);
	else if (is_case(&child, "move"))
		gi_run_move(&child);
	else if (strncmp(child.case_name, GI_RUN_RAYS, strlen(GI_RUN_RAYS)) == 0)
		gi_run_rays(&child);
	else if (is_case(&child, "sobol"))
		run_sobol(&child);
	else if (is_case(&child, "workers"))
		run_workers(&child);
	else if (is_case(&child, "cache-time"))
		run_cache_time(&child);
	else if (is_case(&child, "cache-0.25s"))
		run_equal_time(&child, 0.25);
	else if (is_case(&child, "cache-1s"))
		run_equal_time(&child, 1.0);
	else if (is_case(&child, "hessian"))
		run_hessian(&child);
	else if (is_case(&child, "pathtracer"))
		run_pathtracer(&child);
	else if (is_case(&child, "choice"))
		gi_run_choice(&child);
	else if (is_row(&child))
		gi_run_row(&child);
	else if (denoised_row(&child))
		gi_run_denoise(&child, denoised_row(&child));
	else
		return BENCH_CHILD_SKIP;
	return 0;
}
