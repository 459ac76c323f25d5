/* The program of the suite `plan`: a chain of fullscreen passes and dispatches, each into an image of its own, which
 * the next pass samples, and one a few passes later, too. Every plan is checked for its steps and barriers. */
#include "bench/harness/bench_child.h"
#include "bench/plan/plan_cases.h"
#include "gpu/gpu_plan.h"

#include <math.h>
#include <string.h>

#define MOST 1000u

static char names[MOST][8];

/* Adds the rows. program: of the first pass. */
static void add_rows(stilb_gpu_plan *plan, uint32_t count, uint32_t program, uint32_t frame)
{
	uint16_t images[MOST];
	stilb_gpu_plan_begin(plan, 1280, 720);
	for (uint32_t i = 0; i < count; i++)
		images[i] = stilb_gpu_plan_image(plan, &(stilb_gpu_plan_image_row){.name = names[i],
		                                                                   .format = STILB_GPU_RGBA16_F,
		                                                                   .scale = i % 3 == 0 ? 0.5f : 1.0f,
		                                                                   .output = i + 1 == count});
	for (uint32_t i = 0; i < count; i++) {
		stilb_gpu_pass row = {.name = names[i], .program = i == 0 ? program : 1, .constant_bytes = 16};
		if (i > 0)
			row.uses[row.use_count++] = (stilb_gpu_use){.resource = images[i - 1], .how = STILB_GPU_USE_SAMPLED};
		if (i > 3)
			row.uses[row.use_count++] =
				(stilb_gpu_use){.resource = images[i - 4], .how = STILB_GPU_USE_SAMPLED, .slot = 1};
		if (i % 4 == 3) {
			row.kind = STILB_GPU_PASS_DISPATCH;
			row.groups[0] = row.groups[1] = row.groups[2] = 8;
			row.uses[row.use_count++] =
				(stilb_gpu_use){.resource = images[i], .how = STILB_GPU_USE_STORAGE_WRITE, .mips = 1};
		} else {
			row.kind = STILB_GPU_PASS_FULLSCREEN;
			row.color[0] = (stilb_gpu_attachment){.image = images[i], .load = STILB_GPU_LOAD_DISCARD};
			row.color_count = 1;
		}
		memcpy(row.constants, &frame, sizeof frame);
		stilb_gpu_plan_pass(plan, &row);
	}
}

/* The least time of a frame, ns a pass. changes: its first pass has another program each frame. */
static double least_ns(stilb_gpu_plan *plan, uint32_t count, double seconds, bool changes)
{
	double least = (double)INFINITY;
	uint64_t end = bench_child_now_ns() + (uint64_t)(seconds * 1e9);
	for (uint32_t frame = 0; frame < 8 || bench_child_now_ns() < end; frame++) {
		uint64_t begin = bench_child_now_ns();
		add_rows(plan, count, changes ? 1 + frame % 2 : 1, frame);
		if (stilb_gpu_plan_make(plan, NULL) != STILB_OK)
			bench_child_fail("%s", stilb_error_message());
		double time = (double)(bench_child_now_ns() - begin);
		const stilb_gpu_step *steps;
		const stilb_gpu_barrier *barriers;
		if (stilb_gpu_plan_steps(plan, &steps) != count || stilb_gpu_plan_barriers(plan, &barriers) != 2 * count)
			bench_child_fail("%u passes have %u steps and %u barriers", count, stilb_gpu_plan_steps(plan, &steps),
			                 stilb_gpu_plan_barriers(plan, &barriers));
		if (frame >= 4)
			least = fmin(least, time / count);
	}
	return least;
}

static void run(const bench_child *child, uint32_t count)
{
	for (uint32_t i = 0; i < count; i++)
		snprintf(names[i], sizeof names[i], "i%u", i);
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	if (!plan)
		bench_child_fail("no memory");
	bench_child_metric("same", least_ns(plan, count, child->seconds / 2, false));
	bench_child_metric("new", least_ns(plan, count, child->seconds / 2, true));
	bench_child_metric("barriers", 2.0 * count);
	stilb_gpu_plan_destroy(plan);
}

int main(int argc, char **argv)
{
	bench_child child = bench_child_args(argc, argv);
#define CASE(NAME, TITLE, PASSES)                                                                                      \
	if (strcmp(child.case_name, NAME) == 0) {                                                                          \
		run(&child, PASSES);                                                                                           \
		return 0;                                                                                                      \
	}
	PLAN_CASES(CASE)
#undef CASE
	return BENCH_CHILD_SKIP;
}
