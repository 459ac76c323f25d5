/* The subject `trees` of the suite `animate`: what rays need after a pose, new trees of all posed meshes and of the
 * scene. */
#include "bench/animate/animate_cases.h"
#include "bench/animate/animate_scene.h"
#include "bench/harness/bench_child.h"
#include "gi/gi_scene.h"
#include "scene/edit/scene_edit.h"
#include "scene/edit/scene_node.h"
#include "scene/play/scene_play.h"

#include <math.h>
#include <string.h>

#define MOST_FIGURES 1000u

/* The least time of an update on so many threads, ns: CPU time of the busier one. */
static double update_ns(const bench_child *child, stilb_scene *scene, uint32_t threads)
{
	stilb_job_pool *pool;
	stilb_job_pool_desc pool_desc = stilb_job_pool_desc_default();
	stilb_gi_scene *gi;
	double least = (double)INFINITY;
	pool_desc.worker_count = threads - 1;
	if (stilb_job_pool_create(&pool_desc, &pool) != 0)
		bench_child_fail("no worker starts");
	stilb_gi_scene_desc desc = stilb_gi_scene_desc_default(pool);
	desc.movable = true;
	animate_check(stilb_gi_scene_create(scene, &desc, &gi));
	uint64_t end = bench_child_now_ns() + (uint64_t)(child->seconds * 0.5e9);
	for (int i = 0; i < 4 || bench_child_now_ns() < end; i++) {
		stilb_scene_advance(scene, 1.0 / 64, NULL, 0);
		stilb_scene_update_nodes(scene, NULL, 0);
		animate_cpu start = animate_cpu_now();
		animate_check(stilb_gi_scene_update(gi, scene, &desc));
		least = fmin(least, animate_busier_ns(start));
		stilb_scene_changes_clear(scene);
	}
	stilb_gi_scene_destroy(gi);
	stilb_job_pool_destroy(pool);
	return least;
}

static void run(const bench_child *child, uint32_t figures, uint32_t joints, uint32_t vertices)
{
	figures = figures < MOST_FIGURES ? figures : MOST_FIGURES;
	stilb_scene *scene = animate_scene(figures, joints, vertices, false);
	double one = update_ns(child, scene, 1), two = update_ns(child, scene, 2);
	bench_child_metric("frame", two * 1e-6);
	bench_child_metric("two", one / two);
	stilb_scene_destroy(scene);
}

int main(int argc, char **argv)
{
	bench_child child = bench_child_args(argc, argv);
#define CASE(NAME, TITLE, FIGURES, JOINTS, VERTICES, TORN)                                                             \
	if (strcmp(child.case_name, NAME) == 0 && (VERTICES) > 0 && (VERTICES) < 10000) {                                  \
		run(&child, FIGURES, JOINTS, VERTICES);                                                                        \
		return 0;                                                                                                      \
	}
	ANIMATE_CASES(CASE)
#undef CASE
	return BENCH_CHILD_SKIP;
}
