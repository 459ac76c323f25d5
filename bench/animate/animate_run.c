/* The subject `stilb` of the suite `animate`: times the stages of a frame in which all figures move. The poses of one
 * thread and of two must have the same bits. */
#include "bench/animate/animate_cases.h"
#include "bench/animate/animate_scene.h"
#include "bench/harness/bench_child.h"
#include "jobs/job.h"
#include "scene/edit/scene_edit.h"
#include "scene/play/scene_play_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- times ------------------------------------------------------------------------------------------------------- */

/* CPU times of the busier thread, and of all. */
typedef struct times {
	double sample, nodes, pose, all; /* ns */
	double pose_cpu;
	double clock;
} times;

static times frame(stilb_scene *scene, double step, stilb_job_pool *pool)
{
	times t;
	uint64_t begin = bench_child_now_ns();
	animate_cpu start = animate_cpu_now();
	stilb_scene_advance(scene, step, pool, 0);
	t.sample = animate_busier_ns(start);
	animate_cpu sampled = animate_cpu_now();
	scene_edit_update_places(scene, pool, 0);
	t.nodes = animate_busier_ns(sampled);
	animate_cpu placed = animate_cpu_now();
	stilb_scene_update_nodes(scene, pool, 0);
	t.pose = animate_busier_ns(placed);
	t.pose_cpu = (double)(animate_cpu_now().all_ns - placed.all_ns);
	t.all = animate_busier_ns(start);
	t.clock = (double)(bench_child_now_ns() - begin);
	stilb_scene_changes_clear(scene);
	return t;
}

static void keep_least(times *least, times t)
{
	least->sample = fmin(least->sample, t.sample);
	least->nodes = fmin(least->nodes, t.nodes);
	least->pose = fmin(least->pose, t.pose);
	least->all = fmin(least->all, t.all);
	least->pose_cpu = fmin(least->pose_cpu, t.pose_cpu);
	least->clock = fmin(least->clock, t.clock);
}

/* Copies the mesh at rest over all posed ones, as many bytes as poses write. */
static void copy_meshes(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	stilb_scene *scene = context;
	const play_rest *rest = &scene->figures->shared.rests[0];
	(void)worker;
	for (uint32_t f = begin; f < end; f++)
		memcpy(scene->meshes[scene->figures->figures[f].meshes[0].mesh].vertices, rest->streams,
		       rest->vertex_count * sizeof(stilb_scene_vertex));
}

/* The CPU time of all threads. */
static double copy_all(stilb_scene *scene, uint32_t figures, stilb_job_pool *pool)
{
	animate_cpu start = animate_cpu_now();
	if (pool)
		stilb_job_parallel_for(pool, figures, 1, copy_meshes, scene, 0);
	else
		copy_meshes(0, figures, 0, scene);
	return (double)(animate_cpu_now().all_ns - start.all_ns);
}

/* What a copy of all bytes that a pose reads and writes takes, for one that reads and writes a vertex: the joints of
 * eight vertices, their weights and where they begin, the streams at rest, and the vertex. */
static double moved_share(const stilb_scene *scene)
{
	const play_rest *rest = &scene->figures->shared.rests[0];
	double eights = rest->stride / PLAY_LANES, joints = rest->starts[rest->stride / PLAY_LANES] / eights;
	double carried = (joints * (PLAY_LANES * sizeof(float) + sizeof(uint16_t)) + sizeof(uint32_t)) / PLAY_LANES;
	return (carried + PLAY_STREAMS_PLAIN * sizeof(float) + sizeof(stilb_scene_vertex)) /
	       (2 * sizeof(stilb_scene_vertex));
}

static uint64_t hash_of(const stilb_scene *scene)
{
	uint64_t hash = 1469598103934665603u;
	for (uint32_t m = 0; m < scene->mesh_count; m++) {
		const unsigned char *bytes = (const unsigned char *)scene->meshes[m].vertices;
		for (size_t i = 0; i < scene->meshes[m].vertex_count * sizeof(stilb_scene_vertex); i += 8) {
			uint64_t word;
			memcpy(&word, bytes + i, sizeof word);
			hash = (hash ^ word) * 1099511628211u;
		}
	}
	return hash;
}

static void run(const bench_child *child, uint32_t figures, uint32_t joints, uint32_t vertices, bool torn)
{
	stilb_job_pool *pool;
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	desc.worker_count = 1;
	if (stilb_job_pool_create(&desc, &pool) != 0)
		bench_child_fail("no worker starts");
	stilb_scene *scene = animate_scene(figures, joints, vertices, torn);
	frame(scene, 0.0, NULL);
	double never = (double)INFINITY;
	times one = {never, never, never, never, never, never}, two = one;
	double copy = never, copy_two = never, still = never;
	uint64_t end = bench_child_now_ns() + (uint64_t)(child->seconds * 1e9);
	for (int i = 0; i < 4 || bench_child_now_ns() < end; i++) {
		keep_least(&one, frame(scene, 1.0 / 64, NULL));
		uint64_t was = hash_of(scene);
		frame(scene, -1.0 / 64, pool);
		keep_least(&two, frame(scene, 1.0 / 64, pool));
		if (hash_of(scene) != was)
			bench_child_fail("two threads make other poses than one");
		copy = fmin(copy, copy_all(scene, figures, NULL));
		copy_two = fmin(copy_two, copy_all(scene, figures, pool));
		still = fmin(still, frame(scene, 0.0, pool).clock);
	}
	double count = (double)figures * joints;
	bench_child_metric("channel", one.sample / count / ANIMATE_CHANNELS);
	bench_child_metric("joint", one.sample / count);
	bench_child_metric("two", one.sample / two.sample);
	bench_child_metric("nodes", one.nodes / count);
	bench_child_metric("frame", two.clock * 1e-6);
	bench_child_metric("still", still * 1e-3);
	if (vertices > 0) {
		bench_child_metric("vertex", one.pose / figures / vertices);
		bench_child_metric("copy", copy / figures / vertices);
		bench_child_metric("limit", copy_two * moved_share(scene) / figures / vertices);
		bench_child_metric("jobs", two.pose / figures / vertices);
		bench_child_metric("share", copy_two * moved_share(scene) / two.pose_cpu);
		bench_child_metric("cpu", two.pose_cpu / figures / vertices);
	}
	stilb_scene_destroy(scene);
	stilb_job_pool_destroy(pool);
}

int main(int argc, char **argv)
{
	bench_child child = bench_child_args(argc, argv);
#define CASE(NAME, TITLE, FIGURES, JOINTS, VERTICES, TORN)                                                             \
	if (strcmp(child.case_name, NAME) == 0) {                                                                          \
		run(&child, FIGURES, JOINTS, VERTICES, TORN);                                                                  \
		return 0;                                                                                                      \
	}
	ANIMATE_CASES(CASE)
#undef CASE
	return BENCH_CHILD_SKIP;
}
