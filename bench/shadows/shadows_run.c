/* The program of the suite `shadows`: the whole engine with the stress test. */
#include "bench/harness/bench_child.h"
#include "bench/shadows/shadows_scene.h"

#include "engine.h"
#include "tests/engine/stress_engine.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>

#define SEED 1

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

static stilb_engine *open_engine(stilb_engine_desc desc, uint32_t models, bool animate)
{
	stilb_engine *engine;
	stress_engine stress = {.models = models, .seed = SEED, .view = STILB_SCENE_VIEW_ALL, .animate = animate};
	desc.profile = false;
	require(stress_engine_create(&desc, &stress, &engine));
	return engine;
}

static stilb_engine_report draw(stilb_engine *engine)
{
	stilb_engine_report report;
	require(stilb_engine_frame(engine, &report));
	return report;
}

/* CPU time of a frame, ms: the least of those after the first two, in half of the child's time, of eight at least. */
static double least_ms(const bench_child *child, stilb_engine *engine)
{
	double best = HUGE_VAL;
	uint64_t end = bench_child_now_ns() + (uint64_t)(child->seconds * 5e8);
	for (uint32_t frame = 0; frame < 8 || bench_child_now_ns() < end; frame++) {
		double start = cpu_ms(), gpu;
		draw(engine);
		require(stilb_engine_wait(engine, &gpu));
		best = frame > 1 ? fmin(best, cpu_ms() - start) : best;
	}
	return best;
}

/* ---- triangles --------------------------------------------------------------------------------------------------- */

typedef struct counted {
	double triangles, draws;
} counted;

static counted count(uint32_t models, stilb_engine_shadow_kind kind, stilb_render_detail_mode mode)
{
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.device = STILB_RENDER_DEVICE_NULL;
	desc.shadows = (stilb_engine_shadows){.kind = kind, .cascades = 3, .size = 1024};
	desc.detail = (stilb_render_detail){mode, 0.5f};
	stilb_engine *engine = open_engine(desc, models, false);
	counted all = {.draws = (double)draw(engine).render.draws};
	all.triangles = (double)stilb_engine_triangles(engine);
	stress_engine_destroy(engine);
	return all;
}

/* CPU time of a frame in which all models are where they were not before. */
static double frame_ms(const bench_child *child, uint32_t models, stilb_engine_shadow_kind kind)
{
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.shadows = (stilb_engine_shadows){.kind = kind, .cascades = 3, .size = 1024};
	desc.detail = (stilb_render_detail){STILB_RENDER_DETAIL_POP, 0.5f};
	stilb_engine *engine = open_engine(desc, models, true);
	double best = least_ms(child, engine);
	stress_engine_destroy(engine);
	return best;
}

static void run_triangles(const bench_child *child, uint32_t models)
{
	stilb_render_detail_mode modes[] = {STILB_RENDER_DETAIL_POP, STILB_RENDER_DETAIL_OFF};
	for (int i = 0; i < 2; i++) {
		counted without = count(models, STILB_ENGINE_SHADOWS_OFF, modes[i]);
		counted with = count(models, STILB_ENGINE_SHADOWS_MAP, modes[i]);
		bench_child_metric(i == 0 ? "main" : "main-off", 1e-3 * without.triangles);
		bench_child_metric(i == 0 ? "maps" : "maps-off", 1e-3 * (with.triangles - without.triangles));
		bench_child_metric(i == 0 ? "ratio" : "ratio-off", with.triangles / without.triangles - 1.0);
		if (i == 0)
			bench_child_metric("casters", with.draws - without.draws);
	}
	bench_child_metric("frame-without", frame_ms(child, models, STILB_ENGINE_SHADOWS_OFF));
	bench_child_metric("frame-maps", frame_ms(child, models, STILB_ENGINE_SHADOWS_MAP));
}

/* ---- views ------------------------------------------------------------------------------------------------------- */

/* CPU time of a frame that lights next to nothing, in which a tenth of the models moves, the least of some. */
static double views_ms(const bench_child *child, uint32_t models, stilb_engine_shadow_kind kind, double *triangles)
{
	stilb_scene *scene = shadows_scene(models);
	stilb_engine *engine;
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.width = SHADOWS_WIDTH;
	desc.height = SHADOWS_HEIGHT;
	desc.profile = false;
	desc.samples = 1;
	desc.update = stress_engine_animate;
	desc.user = scene;
	desc.shadows = (stilb_engine_shadows){.kind = kind, .cascades = SHADOWS_CASCADES, .size = SHADOWS_SIZE};
	require(stilb_engine_create(&desc, &engine));
	require(stilb_engine_set_scene(engine, scene));
	double best = least_ms(child, engine);
	*triangles = (double)stilb_engine_triangles(engine);
	stress_engine_destroy(engine);
	return best;
}

static void run_views(const bench_child *child, uint32_t models)
{
	double with, without;
	double ms = views_ms(child, models, STILB_ENGINE_SHADOWS_MAP, &with);
	ms -= views_ms(child, models, STILB_ENGINE_SHADOWS_OFF, &without);
	bench_child_metric("maps", 1e-3 * (with - without));
	bench_child_metric("frame", ms);
}

/* ---- recording --------------------------------------------------------------------------------------------------- */

typedef struct recorded {
	double record, all; /* ms: recording; with culling */
	double draws;
} recorded;

/* The least of many frames, in each of which everything is drawn. */
static recorded record_ms(const bench_child *child, uint32_t models, uint32_t workers, stilb_engine_shadow_kind kind)
{
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.device = STILB_RENDER_DEVICE_NULL;
	desc.workers = workers;
	desc.shadows = (stilb_engine_shadows){.kind = kind, .cascades = 8, .size = 1024};
	desc.detail = (stilb_render_detail){STILB_RENDER_DETAIL_POP, 0.5f};
	recorded best = {HUGE_VAL, HUGE_VAL, 0.0};
	stilb_engine *engine = open_engine(desc, models, true);
	uint64_t end = bench_child_now_ns() + (uint64_t)(child->seconds * 2e8);
	for (uint32_t frame = 0; frame < 10 || bench_child_now_ns() < end; frame++) {
		stilb_engine_report report = draw(engine);
		best.record = fmin(best.record, report.times.record);
		best.all = fmin(best.all, report.times.record + report.times.cull);
		best.draws = (double)report.render.draws;
	}
	stress_engine_destroy(engine);
	return best;
}

static void run_record(const bench_child *child)
{
	recorded without = record_ms(child, 10000, 0, STILB_ENGINE_SHADOWS_OFF);
	recorded with = record_ms(child, 10000, 0, STILB_ENGINE_SHADOWS_MAP);
	double draw_ns = 1e6 * without.all / without.draws;
	double caster_ns = 1e6 * (with.all - without.all) / (with.draws - without.draws);
	bench_child_metric("draw", draw_ns);
	bench_child_metric("caster", caster_ns);
	bench_child_metric("ratio", caster_ns / draw_ns);
	bench_child_metric("two-10000", with.record / record_ms(child, 10000, 1, STILB_ENGINE_SHADOWS_MAP).record);
	with = record_ms(child, 100000, 0, STILB_ENGINE_SHADOWS_MAP);
	bench_child_metric("two", with.record / record_ms(child, 100000, 1, STILB_ENGINE_SHADOWS_MAP).record);
}

/* ---- lamps ------------------------------------------------------------------------------------------------------- */

#define LAMP_MODELS 1024u
#define LAMPS_MOVING 8u

typedef struct lamps {
	stilb_scene *scene;
	stilb_scene_light first[LAMPS_MOVING]; /* where those that move have been */
	float camera[3];
	bool walks; /* its camera */
} lamps;

static void lamps_move(void *user, const stilb_engine_update *update)
{
	lamps *l = user;
	float along = 0.3f * sinf(3.0f * (float)update->seconds);
	for (uint32_t i = 0; i < LAMPS_MOVING; i++)
		l->scene->lights[1 + i].position[0] = l->first[i].position[0] + along;
	/* A walk of 1.5 m a second. */
	l->scene->camera.position[2] = l->camera[2] - (l->walks ? 1.5f * (float)update->seconds : 0.0f);
}

/* Half of the lamps are points, half spots; all reach so far that two are at a point of the ground. */
static stilb_engine *lamps_open(lamps *l, uint32_t lamp_count, stilb_engine_shadow_kind kind)
{
	stilb_engine_desc desc = stilb_engine_desc_default();
	stilb_engine *engine;
	require(stilb_scene_create_stress(LAMP_MODELS, SEED, &l->scene));
	require(stilb_scene_stress_add_lamps(l->scene, lamp_count));
	l->scene->lights[0].intensity[0] = l->scene->lights[0].intensity[1] = l->scene->lights[0].intensity[2] = 0.0f;
	float side = ceilf(sqrtf((float)LAMP_MODELS)) * STILB_SCENE_TILE;
	float reach = sqrtf(2.0f * side * side / (3.14159265f * (float)lamp_count) + 4.0f);
	for (uint32_t i = 0; i < lamp_count; i++) {
		stilb_scene_light *light = &l->scene->lights[1 + i];
		light->kind = i % 2 ? STILB_SCENE_LIGHT_SPOT : STILB_SCENE_LIGHT_POINT;
		memcpy(light->direction, (float[3]){0.0f, -1.0f, 0.0f}, sizeof light->direction);
		light->position[1] = 2.0f;
		light->cos_inner = 0.7f;
		light->cos_outer = 0.6f;
		light->radius = 0.0f;
		light->reach = reach;
		if (i < LAMPS_MOVING)
			l->first[i] = *light;
	}
	desc.width = 640;
	desc.height = 360;
	desc.profile = false;
	desc.update = lamps_move;
	desc.user = l;
	desc.lighting = STILB_RENDER_LIGHTING_CLUSTERED;
	desc.detail = (stilb_render_detail){STILB_RENDER_DETAIL_POP, 0.5f};
	desc.shadows = (stilb_engine_shadows){.kind = kind, .size = 1024};
	l->scene->camera = stilb_scene_stress_camera(l->scene, STILB_SCENE_VIEW_ALL, 16.0f / 9.0f);
	memcpy(l->camera, l->scene->camera.position, sizeof l->camera);
	require(stilb_engine_create(&desc, &engine));
	require(stilb_engine_set_scene(engine, l->scene));
	return engine;
}

/* CPU time of a frame, the least of some. *most: lights whose maps a frame draws, at most. */
static double lamps_ms(stilb_engine *engine, uint32_t frames, uint32_t *most)
{
	double best = HUGE_VAL;
	*most = 0;
	for (uint32_t frame = 0; frame < frames; frame++) {
		double start = cpu_ms(), gpu;
		stilb_engine_report report = draw(engine);
		require(stilb_engine_wait(engine, &gpu));
		best = fmin(best, cpu_ms() - start);
		*most = report.shadow_lights_drawn > *most ? report.shadow_lights_drawn : *most;
	}
	return best;
}

/* Eight lamps and 64, by turns. ms: of frames under a camera that stands still and under one that walks; lights: that
 * these draw at most, of 64. */
static void lamps_measure(stilb_engine_shadow_kind kind, double ms[2][2], uint32_t lights[2])
{
	lamps few = {0}, many = {0};
	stilb_engine *of_few = lamps_open(&few, LAMPS_MOVING, kind), *of_many = lamps_open(&many, 64, kind);
	uint32_t most;
	lamps_ms(of_few, 2, &most);
	lamps_ms(of_many, 2, &most);
	for (int round = 0; round < 4; round++)
		for (int m = 0; m < 2; m++) {
			few.walks = many.walks = m;
			lamps_ms(of_few, 1, &most); /* it has jumped */
			lamps_ms(of_many, 1, &most);
			ms[m][0] = fmin(ms[m][0], lamps_ms(of_few, 4, &most));
			ms[m][1] = fmin(ms[m][1], lamps_ms(of_many, 4, &most));
			lights[m] = lights[m] > most ? lights[m] : most;
		}
	stress_engine_destroy(of_few);
	stress_engine_destroy(of_many);
}

static void run_lamps(const bench_child *child)
{
	(void)child;
	double with[2][2] = {{HUGE_VAL, HUGE_VAL}, {HUGE_VAL, HUGE_VAL}}, without[2][2];
	uint32_t lights[2] = {0, 0}, none[2] = {0, 0};
	memcpy(without, with, sizeof without);
	lamps_measure(STILB_ENGINE_SHADOWS_MAP, with, lights);
	lamps_measure(STILB_ENGINE_SHADOWS_OFF, without, none);
	bench_child_metric("still", lights[0]);
	bench_child_metric("moving", lights[1]);
	bench_child_metric("of-8", with[0][0]);
	bench_child_metric("of-64", with[0][1]);
	bench_child_metric("ratio", with[0][1] / with[0][0]);
	bench_child_metric("ratio-moving", with[1][1] / with[1][0]);
	bench_child_metric("ratio-without", without[0][1] / without[0][0]);
}

int main(int argc, char **argv)
{
	bench_child child = bench_child_args(argc, argv);
	uint32_t models;
	if (sscanf(child.case_name, "triangles-%u", &models) == 1)
		run_triangles(&child, models);
	else if (sscanf(child.case_name, "views-%u", &models) == 1)
		run_views(&child, models);
	else if (strcmp(child.case_name, "record") == 0)
		run_record(&child);
	else if (strcmp(child.case_name, "lamps") == 0)
		run_lamps(&child);
	else
		return BENCH_CHILD_SKIP;
	return 0;
}
