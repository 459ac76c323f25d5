/*
 * shade_gpu: one compute shader over many inputs: two buffers, a program and a dispatch, on the first Vulkan device
 * and under the validation layer.
 *
 * The shader gets shade_gpu_push as its push constants: addresses of the inputs (two vec4 for each result, [0, 1)) and
 * of the results (vec4), an integer that is the test's own, and the count.
 */
#ifndef SHADE_GPU_H
#define SHADE_GPU_H

#include "support/shade_proof.h"

#include "base/base.h"
#include "gpu/gpu.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define SHADE_GPU_COUNT 20000u
#define SHADE_GPU_GROUP 64u

typedef struct shade_gpu_push {
	uint64_t inputs, results;
	int32_t row;
	uint32_t count;
} shade_gpu_push;

static struct {
	stilb_gpu *gpu;
	stilb_gpu_plan *plan;
	stilb_gpu_shader code;
	stilb_gpu_program program;
	stilb_gpu_buffer inputs;
	float results[4 * SHADE_GPU_COUNT];
} shade_gpu;

#define SHADE_GPU_RESULTS (SHADE_GPU_COUNT * sizeof(stilb_vec4))

/* Compiles the code with specialization constants 0 .. count - 1. */
static inline void shade_gpu_specialise(const int32_t *constants, uint32_t count)
{
	stilb_gpu_program_desc desc = {.name = "cases", .compute = shade_gpu.code, .constant_count = (uint8_t)count};
	for (uint32_t c = 0; c < count; c++) {
		desc.constants[c].id = c;
		desc.constants[c].value = (uint32_t)constants[c];
	}
	stilb_gpu_program_destroy(shade_gpu.gpu, shade_gpu.program);
	if (stilb_gpu_program_create(shade_gpu.gpu, &desc, &shade_gpu.program) != STILB_OK)
		fail_msg("%s", stilb_error_message());
}

static inline void shade_gpu_fill_inputs(void)
{
	float *input = stilb_gpu_buffer_mapped(shade_gpu.gpu, shade_gpu.inputs);
	for (uint64_t i = 0; i < 8 * (uint64_t)SHADE_GPU_COUNT; i++)
		input[i] = stilb_random_float(3, i);
	for (int corner = 0; corner < SHADE_PROOF_CORNERS; corner++)
		for (int k = 0; k < 8; k++)
			input[8 * corner + k] = shade_proof_corner(corner, k);
}

/* Device, buffers and code; shade_gpu_specialise makes the program. */
static inline void shade_gpu_start(const uint32_t *words, size_t size)
{
	stilb_gpu_desc desc = {.validate = true};
	stilb_gpu_buffer_desc inputs = {.name = "inputs",
	                                .bytes = 2 * SHADE_GPU_RESULTS,
	                                .memory = STILB_GPU_MEMORY_SHARED,
	                                .uses = STILB_GPU_BUFFER_ADDRESS};
	if (stilb_gpu_create(&desc, &shade_gpu.gpu) != STILB_OK ||
	    stilb_gpu_buffer_create(shade_gpu.gpu, &inputs, &shade_gpu.inputs) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	shade_gpu.plan = stilb_gpu_plan_create();
	assert_non_null(shade_gpu.plan);
	shade_gpu.code = (stilb_gpu_shader){.words = words, .bytes = size};
	shade_gpu_fill_inputs();
}

static inline int shade_gpu_end(void **state)
{
	(void)state;
	stilb_gpu_plan_destroy(shade_gpu.plan);
	stilb_gpu_destroy(shade_gpu.gpu);
	return 0;
}

/* Runs the program and waits for the results. */
static inline void shade_gpu_run(int32_t row)
{
	stilb_gpu_planner planner = stilb_gpu_planner_of(shade_gpu.gpu);
	shade_gpu_push values = {
		.inputs = stilb_gpu_buffer_address(shade_gpu.gpu, shade_gpu.inputs), .row = row, .count = SHADE_GPU_COUNT};
	uint64_t ticket = 0, frame;
	const void *bytes = NULL;
	assert_int_equal(stilb_gpu_frame_begin(shade_gpu.gpu), STILB_OK);
	stilb_gpu_plan_begin(shade_gpu.plan, 1, 1);
	stilb_gpu_plan_buffer_row results = {.name = "results", .bytes = SHADE_GPU_RESULTS, .output = true};
	uint16_t resource = stilb_gpu_plan_buffer(shade_gpu.plan, &results);
	stilb_gpu_pass pass = {
		.name = "cases",
		.kind = STILB_GPU_PASS_DISPATCH,
		.program = shade_gpu.program.id,
		.groups = {(SHADE_GPU_COUNT + SHADE_GPU_GROUP - 1) / SHADE_GPU_GROUP, 1, 1},
		.uses = {{.resource = resource, .how = STILB_GPU_USE_STORAGE_WRITE, .slot = offsetof(shade_gpu_push, results)}},
		.use_count = 1,
		.constant_bytes = sizeof values,
	};
	memcpy(pass.constants, &values, sizeof values);
	stilb_gpu_plan_pass(shade_gpu.plan, &pass);
	if (stilb_gpu_plan_make(shade_gpu.plan, &planner) != STILB_OK ||
	    stilb_gpu_frame_run(shade_gpu.gpu, shade_gpu.plan, NULL, 0, NULL) != STILB_OK ||
	    stilb_gpu_read_begin(shade_gpu.gpu, shade_gpu.plan, resource, 0, 0, &ticket) != STILB_OK ||
	    stilb_gpu_read_get(shade_gpu.gpu, ticket, true, &bytes, &frame) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	memcpy(shade_gpu.results, bytes, sizeof shade_gpu.results);
	stilb_gpu_read_end(shade_gpu.gpu, ticket);
}

/* What the shader computes, in C: the result for the eight numbers of one input. row: the test's own integer. */
typedef stilb_vec4 shade_gpu_function(int row, stilb_vec4 a, stilb_vec4 b);

/* The largest of |gpu - c| / max(relative |c|, absolute): at most 1. where: the input and the lane it was seen at. */
static inline double shade_gpu_worst(shade_gpu_function *c, int row, double relative, double absolute, size_t where[2])
{
	const float *in = stilb_gpu_buffer_mapped(shade_gpu.gpu, shade_gpu.inputs), *out = shade_gpu.results;
	double worst = 0.0;
	for (size_t i = 0; i < SHADE_GPU_COUNT; i++, in += 8, out += 4) {
		stilb_vec4 want = c(row, (stilb_vec4){in[0], in[1], in[2], in[3]}, (stilb_vec4){in[4], in[5], in[6], in[7]});
		for (size_t k = 0; k < 4; k++) {
			double difference = fabs((double)out[k] - (double)want[k]);
			double share = difference == 0.0 ? 0.0 : difference / fmax(relative * fabs((double)want[k]), absolute);
			if (share <= worst)
				continue;
			worst = share; /* NaN comes here too, and stays */
			where[0] = i;
			where[1] = k;
			if (isnan(share))
				return share;
		}
	}
	return worst;
}

/* What was seen at shade_gpu_worst's place. */
static inline void shade_gpu_print_worst(shade_gpu_function *c, int row, const size_t where[2])
{
	const float *in = stilb_gpu_buffer_mapped(shade_gpu.gpu, shade_gpu.inputs), *out = shade_gpu.results;
	in += 8 * where[0];
	stilb_vec4 want = c(row, (stilb_vec4){in[0], in[1], in[2], in[3]}, (stilb_vec4){in[4], in[5], in[6], in[7]});
	printf("  TOO FAR: lane %zu of", where[1]);
	for (int k = 0; k < 8; k++)
		printf(" %.9g", (double)in[k]);
	printf(" is %.9g on the GPU, %.9g in C\n", (double)out[4 * where[0] + where[1]], (double)want[where[1]]);
}

static inline void shade_gpu_layer_said_nothing(void **state)
{
	(void)state;
	assert_int_equal(stilb_gpu_validation_messages(shade_gpu.gpu), 0);
}

static inline bool shade_gpu_present(void)
{
	stilb_gpu_listed one;
	uint32_t count;
	if (stilb_gpu_list(&one, 1, &count) == STILB_OK && count > 0)
		return true;
	printf("skipped: no Vulkan driver (apt install mesa-vulkan-drivers)\n");
	return false;
}

#endif
