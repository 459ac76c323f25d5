/* The program of the suite `post`: frames of the whole engine by turns with an effect and without. */
#include "bench/harness/bench_child.h"
#include "bench/post/post_bare.h"

#include "engine.h"
#include "tests/engine/stress_engine.h"

#include <math.h>
#include <string.h>
#include <sys/resource.h>

#define SEED 1
#define MODELS 225
#define WAYS 4 /* without, by the device, by bare programs, by the CPU */
#define MOST_NAMES 64u

static void require(stilb_result result)
{
	if (result != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
}

static double cpu_ms(void)
{
	struct rusage usage;
	getrusage(RUSAGE_SELF, &usage);
	return 1e3 * (double)(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
	       1e-3 * (double)(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

static double frame_ms(stilb_engine *engine)
{
	double start = cpu_ms(), gpu;
	stilb_engine_report report;
	require(stilb_engine_frame(engine, &report));
	require(stilb_engine_wait(engine, &gpu));
	return cpu_ms() - start;
}

typedef struct effect {
	const char *name;
	uint32_t width, height;
	stilb_post_settings settings;
	bool placed;         /* the CPU can do it, too */
	bool apart, surface; /* frames have what it reads also without it: ambient light apart; velocities and models */
} effect;

static const effect effects[] = {
	{"bloom", 640, 360, {.bloom = 0.1f}, true, false, false},
	{"bloom-large", 1920, 1080, {.bloom = 0.1f}, true, false, false},
	{"ao", 640, 360, {.occlusion = 1.0f}, true, true, false},
	{"temporal", 640, 360, {.aa = STILB_POST_AA_TEMPORAL}, false, false, true},
	{"motion", 640, 360, {.motion_blur = 0.5f}, false, false, true},
};

/* The names of the last frame's rows; returns how many. */
static uint32_t row_names(const stilb_engine *engine, char (*names)[64])
{
	const stilb_gpu_plan *plan = stilb_engine_plan(engine);
	uint32_t count = stilb_gpu_plan_passes(plan);
	if (count > MOST_NAMES)
		bench_child_fail("a frame of %u rows: make room in post_run.c", count);
	for (uint32_t p = 0; p < count; p++)
		snprintf(names[p], sizeof *names, "%s", stilb_gpu_plan_row(plan, p)->name);
	return count;
}

/* The least CPU time of a frame in each way, of frames by turns. */
static void effect_measure(const bench_child *child, const effect *e, double ms[WAYS])
{
	stilb_engine *engine;
	stilb_engine_desc desc = stilb_engine_desc_default();
	stress_engine stress = {.models = MODELS, .seed = SEED, .view = STILB_SCENE_VIEW_ALL};
	desc.width = e->width;
	desc.height = e->height;
	desc.profile = false;
	desc.post = e->settings; /* so that programs and images of all ways can be */
	desc.ambient_apart = e->apart;
	desc.surfaces = e->surface;
	require(stress_engine_create(&desc, &stress, &engine));
	if (!stilb_engine_device_is_software(engine))
		bench_child_fail("this device is a GPU, whose time is not the CPU's: --gpu chooses, see README.md");
	uint64_t end = bench_child_now_ns() + (uint64_t)(child->seconds * 1e9);
	uint32_t ways = e->placed ? WAYS : WAYS - 1, count = 0;
	static char names[MOST_NAMES][64];
	post_bare *bare = NULL;
	for (uint32_t way = 0; way < WAYS; way++)
		ms[way] = HUGE_VAL;
	for (uint32_t turn = 0; turn < 6 || bench_child_now_ns() < end; turn++)
		for (uint32_t way = 0; way < ways; way++) {
			stilb_post_settings settings = way % 2 == 1 ? e->settings : (stilb_post_settings){0};
			settings.place = way == 3 ? STILB_POST_PLACE_CPU : STILB_POST_PLACE_GPU;
			stilb_engine_set_post(engine, &settings);
			if (bare)
				post_bare_switch(bare, way == 2);
			frame_ms(engine); /* images come and go */
			double took = frame_ms(engine);
			ms[way] = turn > 0 ? fmin(ms[way], took) : ms[way];
			if (turn == 0 && way == 0)
				count = row_names(engine, names);
			if (turn == 0 && way == 1)
				bare = post_bare_learn(engine, names, count);
		}
	post_bare_destroy(bare, engine);
	stress_engine_destroy(engine);
}

int main(int argc, char **argv)
{
	bench_child child = bench_child_args(argc, argv);
	for (size_t i = 0; i < sizeof effects / sizeof *effects; i++) {
		const effect *e = &effects[i];
		double ms[WAYS], pixels = (double)e->width * (double)e->height;
		if (strcmp(child.case_name, e->name) != 0)
			continue;
		effect_measure(&child, e, ms);
		bench_child_metric("frame", ms[0]);
		bench_child_metric("gpu", ms[1] - ms[0]);
		bench_child_metric("gpu-pixel", 1e6 * (ms[1] - ms[0]) / pixels);
		bench_child_metric("bare", ms[2] - ms[0]);
		bench_child_metric("over-bare", (ms[1] - ms[0]) / (ms[2] - ms[0]));
		if (e->placed) {
			bench_child_metric("cpu", ms[3] - ms[0]);
			bench_child_metric("cpu-pixel", 1e6 * (ms[3] - ms[0]) / pixels);
			bench_child_metric("ratio", (ms[3] - ms[0]) / (ms[1] - ms[0]));
		}
		return 0;
	}
	return BENCH_CHILD_SKIP;
}
