/* The program of the suite `plan`: a chain of fullscreen passes and dispatches, each into an image of its own, which
 * the next pass samples, and one a few passes later, too. Every plan is checked for its steps and barriers. */
#include "bench/harness/bench_child.h"
#include "bench/plan/plan_cases.h"
#include "gpu/gpu.h"

#include <math.h>
#include <string.h>

#define MOST 1000u

static const uint32_t none_frag[] =
#include "none.frag.inc"
	;
static const uint32_t none_comp[] =
#include "none.comp.inc"
	;

/* What changes from frame to frame, besides constants. */
typedef enum change { CHANGE_NONE, CHANGE_PROGRAM, CHANGE_USE } change;

static char names[MOST][12];
static stilb_gpu *gpu;             /* the null device */
static uint32_t programs[2][3][2]; /* by kind, by samplers; two that are alike */

static void check(stilb_result result)
{
	if (result != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
}

static void open_all(uint32_t count)
{
	for (uint32_t i = 0; i < count; i++)
		snprintf(names[i], sizeof names[i], "i%u", i);
	check(stilb_gpu_create(&(stilb_gpu_desc){.kind = STILB_GPU_KIND_NULL}, &gpu));
	for (uint32_t p = 0; p < 12; p++) {
		bool compute = p / 6 == 1;
		stilb_gpu_program program;
		stilb_gpu_program_desc desc = {.name = "none", .samplers = (uint8_t)(p / 2 % 3), .storage_images = compute};
		if (compute)
			desc.compute = (stilb_gpu_shader){.words = none_comp, .bytes = sizeof none_comp};
		else
			desc.fragment = (stilb_gpu_shader){.words = none_frag, .bytes = sizeof none_frag};
		check(stilb_gpu_program_create(gpu, &desc, &program));
		programs[compute][p / 2 % 3][p % 2] = program.id;
	}
}

/* Adds the rows. */
static void add_rows(stilb_gpu_plan *plan, uint32_t count, change what, uint32_t frame)
{
	uint16_t images[MOST];
	uint32_t odd = what == CHANGE_NONE ? 0 : frame % 2;
	stilb_gpu_plan_begin(plan, 1280, 720);
	for (uint32_t i = 0; i < count; i++)
		images[i] = stilb_gpu_plan_image(plan, &(stilb_gpu_plan_image_row){.name = names[i],
		                                                                   .format = STILB_GPU_RGBA16_F,
		                                                                   .scale = i % 3 == 0 ? 0.5f : 1.0f,
		                                                                   .output = i + 1 == count});
	for (uint32_t i = 0; i < count; i++) {
		stilb_gpu_pass row = {.name = names[i], .constant_bytes = 16};
		if (i > 0)
			row.uses[row.use_count++] = (stilb_gpu_use){.resource = images[i - 1], .how = STILB_GPU_USE_SAMPLED};
		if (i > 3) /* one pass samples another image in each other frame */
			row.uses[row.use_count++] =
				(stilb_gpu_use){.resource = images[i - (what == CHANGE_USE && odd && i == 5 ? 3 : 4)],
			                    .how = STILB_GPU_USE_SAMPLED,
			                    .slot = 1};
		row.program = programs[i % 4 == 3][row.use_count][what == CHANGE_PROGRAM && i == 0 ? odd : 0];
		if (i % 4 == 3) {
			row.kind = STILB_GPU_PASS_DISPATCH;
			row.groups[0] = row.groups[1] = row.groups[2] = 8;
			row.uses[row.use_count] = (stilb_gpu_use){
				.resource = images[i], .how = STILB_GPU_USE_STORAGE_WRITE, .mips = 1, .slot = row.use_count};
			row.use_count++;
		} else {
			row.kind = STILB_GPU_PASS_FULLSCREEN;
			row.color[0] = (stilb_gpu_attachment){.image = images[i], .load = STILB_GPU_LOAD_DISCARD};
			row.color_count = 1;
		}
		memcpy(row.constants, &frame, sizeof frame);
		stilb_gpu_plan_pass(plan, &row);
	}
}

static void check_plan(const stilb_gpu_plan *plan, uint32_t count)
{
	const stilb_gpu_step *steps;
	const stilb_gpu_barrier *barriers;
	if (stilb_gpu_plan_steps(plan, &steps) != count || stilb_gpu_plan_barriers(plan, &barriers) != 2 * count)
		bench_child_fail("%u passes have %u steps and %u barriers", count, stilb_gpu_plan_steps(plan, &steps),
		                 stilb_gpu_plan_barriers(plan, &barriers));
}

/* The least time of a frame, ns a pass. runs: the null device asks for its mistakes and runs it. */
static double least_ns(uint32_t count, double seconds, change what, bool runs)
{
	double least = (double)INFINITY;
	uint64_t end = bench_child_now_ns() + (uint64_t)(seconds * 1e9);
	stilb_gpu_plan *plan = stilb_gpu_plan_create();
	stilb_gpu_planner planner = stilb_gpu_planner_of(gpu);
	if (!plan)
		bench_child_fail("no memory");
	for (uint32_t frame = 0; frame < 8 || bench_child_now_ns() < end; frame++) {
		uint64_t begin = bench_child_now_ns();
		if (runs)
			check(stilb_gpu_frame_begin(gpu));
		add_rows(plan, count, what, frame);
		check(stilb_gpu_plan_make(plan, runs ? &planner : NULL));
		if (runs)
			check(stilb_gpu_frame_run(gpu, plan, NULL, 0, NULL));
		double time = (double)(bench_child_now_ns() - begin);
		check_plan(plan, count);
		if (frame >= 4)
			least = fmin(least, time / count);
	}
	stilb_gpu_plan_destroy(plan);
	return least;
}

static void run(const bench_child *child, uint32_t count)
{
	double seconds = child->seconds / 6;
	open_all(count);
	bench_child_metric("same", least_ns(count, seconds, CHANGE_NONE, false));
	bench_child_metric("program", least_ns(count, seconds, CHANGE_PROGRAM, false));
	bench_child_metric("new", least_ns(count, seconds, CHANGE_USE, false));
	bench_child_metric("same-run", least_ns(count, seconds, CHANGE_NONE, true));
	bench_child_metric("program-run", least_ns(count, seconds, CHANGE_PROGRAM, true));
	bench_child_metric("new-run", least_ns(count, seconds, CHANGE_USE, true));
	bench_child_metric("barriers", 2.0 * count);
	stilb_gpu_destroy(gpu);
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
