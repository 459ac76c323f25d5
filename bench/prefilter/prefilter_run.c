/* The program of the suite `prefilter`: makes the cube on one thread and on two in turn, and compares texels of it with
 * quadrature in double. Both cubes must be the same. */
#include "bench/harness/bench_child.h"
#include "bench/prefilter/prefilter_cases.h"
#include "jobs/job.h"
#include "numeric/numeric_prefilter.h"
#include "numeric/numeric_sh.h"
#include "shading/shade_environment.h"

#include <math.h>
#include <string.h>

#define FACE 256u
#define QUADRATURE_TEXELS 16u /* of a mip */

static const double sun[3] = {0.501, 0.601, -0.622};

static double dot_of(const double a[3], const double b[3])
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* A sky with a sun of half a degree that gives it about as much light as all the rest. */
static void sky(const double d[3], float *texel)
{
	double length = sqrt(dot_of(sun, sun)), bright = d[1] > 0.0 ? 1.5 - 0.5 * d[1] : 0.3 + 0.1 * d[1];
	double disk = acos(fmin(dot_of(sun, d) / length, 1.0)) < 0.0047 ? 6e4 : 0.0;
	for (int c = 0; c < 3; c++)
		texel[c] = (float)(bright * (0.6 + 0.2 * c) + disk * (1.0 - 0.1 * c));
}

static stilb_image image_of(uint32_t width, uint32_t height, int face)
{
	stilb_image image = {width, height, 3, STILB_IMAGE_F32_LINEAR, NULL, 0};
	image.pixels = stilb_memory_alloc((size_t)width * height, 3 * sizeof(float));
	if (!image.pixels)
		bench_child_fail("no memory");
	for (uint32_t i = 0; i < width * height; i++) {
		double u = (i % width + 0.5) / width, v = (i / width + 0.5) / height, d[3];
		stilb_numeric_latlong_direction(u, v, d);
		if (face >= 0) {
			stilb_vec3 toward =
				stilb_vec3_normalize(shade_cube_direction(face, (float)(2.0 * u - 1.0), (float)(2.0 * v - 1.0)));
			for (int c = 0; c < 3; c++)
				d[c] = (double)toward[c];
		}
		sky(d, (float *)image.pixels + (size_t)3 * i);
	}
	return image;
}

/* ---- times ------------------------------------------------------------------------------------------------------- */

typedef struct stage_loop {
	stilb_numeric_prefilter *work;
	uint32_t stage;
} stage_loop;

static void run_rows(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	const stage_loop *loop = context;
	stilb_numeric_prefilter_run(loop->work, loop->stage, begin, end);
}

static uint64_t cpu_ns(void)
{
	struct timespec now;
	clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
	return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

static const stilb_numeric_prefilter_settings settings = {.face = FACE, .mips = PREFILTER_MIPS};

/* pool: NULL for this thread alone. */
static void make(const stilb_numeric_prefilter_source *source, stilb_job_pool *pool, void *cube)
{
	stage_loop loop;
	if (stilb_numeric_prefilter_create(source, &settings, cube, &loop.work) != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
	for (loop.stage = 0; loop.stage < STILB_NUMERIC_PREFILTER_STAGES; loop.stage++) {
		uint32_t rows = stilb_numeric_prefilter_rows(loop.work, loop.stage);
		if (pool)
			stilb_job_parallel_for(pool, rows, 1, run_rows, &loop, 0);
		else
			run_rows(0, rows, 0, &loop);
	}
	stilb_numeric_prefilter_destroy(loop.work);
}

/* The least of several times each, in turn. */
static void measure(const bench_child *child, const stilb_numeric_prefilter_source *source, void *cubes[2])
{
	stilb_job_pool *pool;
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	desc.worker_count = 1;
	if (stilb_job_pool_create(&desc, &pool) != 0)
		bench_child_fail("no worker starts");
	double core = (double)INFINITY, one = (double)INFINITY, two = (double)INFINITY;
	uint64_t end = bench_child_now_ns() + (uint64_t)(child->seconds * 1e9);
	for (int i = 0; i < 2 || bench_child_now_ns() < end; i++) {
		uint64_t cpu = cpu_ns(), wall = bench_child_now_ns();
		make(source, NULL, cubes[0]);
		core = fmin(core, (double)(cpu_ns() - cpu));
		one = fmin(one, (double)(bench_child_now_ns() - wall));
		wall = bench_child_now_ns();
		make(source, pool, cubes[1]);
		two = fmin(two, (double)(bench_child_now_ns() - wall));
	}
	stilb_job_pool_destroy(pool);
	size_t size = stilb_numeric_prefilter_offset(&settings, PREFILTER_MIPS, 0);
	if (memcmp(cubes[0], cubes[1], size) != 0)
		bench_child_fail("two threads make another cube than one");
	bench_child_metric("core", core * 1e-6);
	bench_child_metric("two", two * 1e-6);
	bench_child_metric("speedup", one / two);
	bench_child_metric("texel", core / (double)(size / 16));
}

/* ---- errors ------------------------------------------------------------------------------------------------------ */

/* The mean of the panorama's green over the lobe about n. */
static double quadrature(const stilb_image *map, double alpha, const double n[3])
{
	double sum = 0.0, weights = 0.0;
	for (uint32_t y = 0; y < map->height; y++) {
		double theta = M_PI * (y + 0.5) / map->height, sine = sin(theta), up = cos(theta) * n[1];
		for (uint32_t x = 0; x < map->width; x++) {
			double phi = 2.0 * M_PI * ((x + 0.5) / map->width - 0.5);
			double cosine = sine * (sin(phi) * n[0] - cos(phi) * n[2]) + up;
			if (cosine <= 0.0)
				continue;
			double bracket = alpha * alpha + 0.5 * (1.0 - cosine) * (1.0 - alpha * alpha);
			double shadow = cosine / (cosine + sqrt(alpha * alpha + (1.0 - alpha * alpha) * cosine * cosine));
			double weight = sine * shadow / (bracket * bracket);
			sum += weight * (double)((const float *)map->pixels)[3 * ((size_t)y * map->width + x) + 1];
			weights += weight;
		}
	}
	return sum / weights;
}

/* A texel of the mip; every second one close to the sun. */
static shade_cube_place texel_of(uint32_t i, uint32_t side)
{
	stilb_vec3 d;
	for (int c = 0; c < 3; c++)
		d[c] = stilb_random_float(7, 3 * i + (uint32_t)c) - 0.5f;
	for (int c = 0; c < 3 && i % 2 == 1; c++)
		d[c] = (float)sun[c] + 0.3f * d[c];
	shade_cube_place place = shade_cube_place_of(d);
	place.s = floorf(fminf(0.5f * (place.s + 1.0f) * (float)side, (float)(side - 1)));
	place.t = floorf(fminf(0.5f * (place.t + 1.0f) * (float)side, (float)(side - 1)));
	return place;
}

static double error_of(const stilb_image *map, const void *cube, uint32_t mip)
{
	uint32_t side = FACE >> mip;
	double roughness = (double)mip / (PREFILTER_MIPS - 1), error = 0.0, mean = 0.0;
	for (uint32_t i = 0; i < QUADRATURE_TEXELS; i++) {
		shade_cube_place at = texel_of(i, side);
		float half = 0.5f * (float)side;
		stilb_vec3 toward = stilb_vec3_normalize(
			shade_cube_direction(at.face, (at.s + 0.5f) / half - 1.0f, (at.t + 0.5f) / half - 1.0f));
		const double n[3] = {(double)toward[0], (double)toward[1], (double)toward[2]};
		double want = quadrature(map, roughness * roughness, n);
		const float *texels =
			(const float *)cube + stilb_numeric_prefilter_offset(&settings, mip, (uint32_t)at.face) / 4;
		double got = (double)texels[4 * ((uint32_t)at.t * side + (uint32_t)at.s) + 1];
		error += (got - want) * (got - want);
		mean += want;
	}
	return 100.0 * sqrt(error / QUADRATURE_TEXELS) / (mean / QUADRATURE_TEXELS);
}

/* ---- cases ------------------------------------------------------------------------------------------------------- */

static void run(const bench_child *child, uint32_t side, bool is_cube)
{
	stilb_image images[6];
	for (int i = 0; i < (is_cube ? 6 : 1); i++)
		images[i] = is_cube ? image_of(side, side, i) : image_of(side, side / 2, -1);
	stilb_numeric_prefilter_source source = {is_cube ? NULL : images, is_cube ? images : NULL};
	size_t size = stilb_numeric_prefilter_offset(&settings, PREFILTER_MIPS, 0);
	void *cubes[2] = {stilb_memory_alloc(1, size), stilb_memory_alloc(1, size)};
	if (!cubes[0] || !cubes[1])
		bench_child_fail("no memory");
	measure(child, &source, cubes);
#define ERROR(METRIC, MIP) bench_child_metric(METRIC, error_of(images, cubes[0], MIP));
	if (side == 1024) {
		PREFILTER_ERRORS(ERROR)
	}
#undef ERROR
	for (int i = 0; i < (is_cube ? 6 : 1); i++)
		free(images[i].pixels);
	free(cubes[0]);
	free(cubes[1]);
}

int main(int argc, char **argv)
{
	bench_child child = bench_child_args(argc, argv);
#define CASE(NAME, TITLE, SIDE, IS_CUBE)                                                                               \
	if (strcmp(child.case_name, NAME) == 0) {                                                                          \
		run(&child, SIDE, IS_CUBE);                                                                                    \
		return 0;                                                                                                      \
	}
	PREFILTER_CASES(CASE)
#undef CASE
	return BENCH_CHILD_SKIP;
}
